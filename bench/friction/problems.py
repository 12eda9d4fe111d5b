"""Friction problems of the literature: reader of every format, and the measure that judges an answer.

    find r in K:   u = W r + q,   u + mu |u_t| e_n in K*,   orthogonal to r

K is the product of the cones |r_t| <= mu r_n, one per contact, its normal component first; r are forces (compression
>= 0), u relative velocities (separation >= 0), q those without contact forces. Global problems give M, H, f, w with
W = H' M^-1 H and q = H' M^-1 f + w.

Text (.dat, .dat.gz): dimension, contacts, matrix W, q, mu; or dimension, contacts, matrices M and H, f, w, mu. A matrix
is its storage and its two sizes, then
    0   rows, columns, values row by row;
    1   blocks, block rows, block columns, cumulative sizes of rows and of columns, lengths of two indices, the indices
        (begin of each block row; block column of each block), then of each block its number and its values column by
        column;
    2   2 (compressed columns) or 1 (triplets), then what CSparse prints.
HDF5 of the Friction Contact Library: groups fclib_local (W, q, mu) or fclib_global (M, H, f, w, mu); nz >= 0 triplets
(i row, p column), -1 compressed columns, -2 compressed rows.

Needs numpy and scipy, and h5py for HDF5.
"""

import gzip
import os

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg


class Unreadable(Exception):
    """The file is not a friction problem of these formats."""


class Problem:
    """W (csr), q, mu and the dimension of a contact (2 or 3)."""

    def __init__(self, name, dimension, W, q, mu):
        self.name, self.dimension, self.mu, self.q = name, dimension, np.asarray(mu), np.asarray(q)
        self.W = sparse.csr_matrix(W)
        size = dimension * len(self.mu)
        if dimension not in (2, 3) or self.W.shape != (size, size) or self.q.shape != (size,):
            raise Unreadable(f"W {self.W.shape}, q {self.q.shape}, mu {self.mu.shape} do not fit")

    def unit(self):
        """1 / max diag W: what turns velocities into forces; 1 where that vanishes."""
        largest = self.W.diagonal().max(initial=0.0)
        return 1.0 / largest if largest > 0.0 else 1.0

    def project(self, x):
        """Nearest point of K."""
        x = x.reshape(-1, self.dimension)
        n, t = x[:, 0], x[:, 1:]
        length, mu = np.linalg.norm(t, axis=1), self.mu
        normal = (n + mu * length) / (1.0 + mu * mu)
        with np.errstate(invalid="ignore", divide="ignore"):
            shear = np.where(length > 0.0, mu * normal / length, 0.0)
        inside, polar = length <= mu * n, mu * length <= -n
        normal = np.where(inside, n, np.where(polar, 0.0, normal))
        shear = np.where(inside, 1.0, np.where(polar, 0.0, shear))
        return np.column_stack([normal, shear[:, None] * t]).ravel()

    def natural(self, r, rho):
        """r - P_K(r - rho (u + mu |u_t| e_n))."""
        u = (self.W @ r + self.q).reshape(-1, self.dimension)
        u[:, 0] += self.mu * np.linalg.norm(u[:, 1:], axis=1)
        return r - self.project(r - rho * u.ravel())

    def scaled(self, r):
        """The scale-free error: the natural map for rho = 1 / max diag W, over max(|r|, rho |q|)."""
        rho = self.unit()
        size = max(np.linalg.norm(r), rho * np.linalg.norm(self.q))
        return np.linalg.norm(self.natural(r, rho)) / (size if size > 0.0 else 1.0)

    def literature(self, r):
        """The error of the literature: the natural map for rho = 1, over |q|."""
        size = np.linalg.norm(self.q)
        return np.linalg.norm(self.natural(r, 1.0)) / (size if size > 0.0 else 1.0)


SUFFIXES = (".dat", ".dat.gz", ".hdf5", ".h5")


def files(folder):
    """Files of the folder that may be problems, sorted by name."""
    return sorted(os.path.join(folder, name) for name in os.listdir(folder) if name.endswith(SUFFIXES))


def name_of(path):
    """The name of the problem: that of the file without the endings of the formats."""
    name = os.path.basename(path)
    endings = (".gz", ".dat", ".hdf5", ".h5")
    while name.endswith(endings):
        name = name[: name.rindex(".")]
    return name


def read(path):
    """The problem in the file. Raises Unreadable."""
    name = name_of(path)
    try:
        if path.endswith((".hdf5", ".h5")):
            return read_hdf5(path, name)
        opener = gzip.open if path.endswith(".gz") else open
        with opener(path, "rt") as file:
            return read_text(file.read().split(), name)
    except (ValueError, IndexError, KeyError) as error:
        raise Unreadable(f"{name}: {error}") from error


class Words:
    """Words of a text one after the other."""

    def __init__(self, words):
        self.words, self.at = words, 0

    def word(self):
        self.at += 1
        return self.words[self.at - 1]

    def integer(self):
        return int(self.word())

    def array(self, count, kind=float):
        values = self.words[self.at : self.at + count]
        if len(values) < count:
            raise ValueError("the file ends too early")
        self.at += count
        return np.array(values, dtype=kind)


def read_text(words, name):
    words = Words(words)
    dimension, contacts = words.integer(), words.integer()
    if dimension not in (2, 3) or contacts < 1:
        raise Unreadable(f"{name}: dimension {dimension} with {contacts} contacts is not a friction problem")
    first = read_matrix(words)
    ahead = words.words[words.at : words.at + 3]
    if ahead[0] in ("0", "1", "2") and ahead[1:] == [str(first.shape[0]), str(dimension * contacts)]:
        H = read_matrix(words)
        f, w, mu = words.array(H.shape[0]), words.array(H.shape[1]), words.array(contacts)
        return condensed(name, dimension, first, H, f, w, mu)
    q, mu = words.array(first.shape[0]), words.array(contacts)
    return Problem(name, dimension, first, q, mu)


def read_matrix(words):
    storage, rows, columns = words.integer(), words.integer(), words.integer()
    if storage == 0:
        shape = words.integer(), words.integer()
        matrix = sparse.csr_matrix(words.array(shape[0] * shape[1]).reshape(shape))
    elif storage == 1:
        matrix = read_blocks(words)
    elif storage == 2:
        matrix = read_printed(words)
    else:
        raise ValueError(f"storage {storage} is unknown")
    if matrix.shape != (rows, columns):
        raise ValueError(f"a matrix of sizes {matrix.shape} is announced as {(rows, columns)}")
    return matrix


def read_blocks(words):
    blocks, block_rows, block_columns = words.integer(), words.integer(), words.integer()
    row_ends, column_ends = words.array(block_rows, int), words.array(block_columns, int)
    begin_count, place_count = words.integer(), words.integer()
    begins, places = words.array(begin_count, int), words.array(place_count, int)
    row_of = np.repeat(np.arange(begin_count - 1), np.diff(begins))
    starts = [np.concatenate([[0], ends]) for ends in (row_ends, column_ends)]
    i, j, x = [], [], []
    for _ in range(blocks):
        block = words.integer()
        a, b = row_of[block], places[block]
        rows = np.arange(starts[0][a], starts[0][a + 1])
        columns = np.arange(starts[1][b], starts[1][b + 1])
        x.append(words.array(len(rows) * len(columns)))
        i.append(np.tile(rows, len(columns)))
        j.append(np.repeat(columns, len(rows)))
    entries = np.concatenate(x), (np.concatenate(i), np.concatenate(j))
    return sparse.csr_matrix(entries, shape=(row_ends[-1], column_ends[-1]))


def read_printed(words):
    kind = words.integer()
    while "-by-" not in words.words[words.at]:
        words.at += 1
    shape = tuple(int(size) for size in words.word().rstrip(",").split("-by-"))
    while words.word() != "nnz:":
        pass
    count = int(words.word().rstrip(","))
    i, j, x = np.zeros(count, int), np.zeros(count, int), np.zeros(count)
    column = -1
    for k in range(count):
        if kind == 1:
            i[k], j[k], _, x[k] = words.integer(), words.integer(), words.word(), words.word()
            continue
        while words.words[words.at] in ("col", "1-norm:"):
            if words.word() == "col":
                column = words.integer()
                words.at += 5  # : locations a to b
            else:
                words.at += 1
        i[k], j[k], _, x[k] = words.integer(), column, words.word(), words.word()
    while words.at < len(words.words) and words.words[words.at] == "col":
        words.at += 7
    return sparse.csr_matrix((x, (i, j)), shape=shape)


def read_hdf5(path, name):
    import h5py

    with h5py.File(path) as file:
        if "fclib_local" in file:
            group = file["fclib_local"]
            if "R" in group:
                raise Unreadable(f"{name}: bilateral rows are not treated")
            vectors = group["vectors"]
            dimension = int(group["spacedim"][0])
            return Problem(name, dimension, hdf5_matrix(group["W"]), vectors["q"][:], vectors["mu"][:])
        if "fclib_global" not in file:
            raise Unreadable(f"{name}: neither fclib_local nor fclib_global")
        group = file["fclib_global"]
        if "G" in group:
            raise Unreadable(f"{name}: bilateral rows are not treated")
        vectors = group["vectors"]
        M, H = hdf5_matrix(group["M"]), hdf5_matrix(group["H"])
        parts = vectors["f"][:], vectors["w"][:], vectors["mu"][:]
        return condensed(name, int(group["spacedim"][0]), M, H, *parts)


def hdf5_matrix(group):
    m, n, nz = (int(group[key][0]) for key in ("m", "n", "nz"))
    i, p, x = group["i"][:], group["p"][:], group["x"][:]
    if nz >= 0:
        return sparse.csr_matrix((x[:nz], (i[:nz], p[:nz])), shape=(m, n))
    kind = sparse.csc_matrix if nz == -1 else sparse.csr_matrix
    return kind((x, i, p), shape=(m, n)).tocsr()


def condensed(name, dimension, M, H, f, w, mu):
    factor = scipy.sparse.linalg.splu(sparse.csc_matrix(M))
    W = H.T @ factor.solve(H.toarray())
    return Problem(name, dimension, W, H.T @ factor.solve(f) + w, mu)
