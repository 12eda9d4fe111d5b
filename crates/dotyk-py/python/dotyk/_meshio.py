"""Meshes of meshio: which cells make a body, and which of its sets are groups, sides and points."""

from __future__ import annotations

import contextlib
import io
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from dotyk import _dotyk
from dotyk._errors import ArgumentError, InputError
from dotyk._mesh import _FACETS, _KINDS, _PLANE, Mesh, _indices
from dotyk._words import friend, unmasked

#: Cell data of meshio that number groups; zero is none.
_NUMBERS = (
    "medit:ref", "nastran:ref", "netgen:index", "su2:tag", "tetgen:ref", "ugrid:ref", "avsucd:material",
)  # fmt: skip
#: Place of each node in files of Exodus, which meshio reads as they are: the edges between bottom and top come before those
#: of the top, and the middle of the cell before those of its faces.
_EXODUS = {
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "hexahedron27": [*range(12), *range(16, 20), *range(12, 16), 23, 24, 25, 26, 21, 22, 20],
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
}
#: Corners of facets.
_CORNERS = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}


def of_file(path: str, group: str | Sequence[str] | None, space: bool | None) -> Mesh:
    """A mesh of any file that meshio reads."""
    meshio = library(f"a mesh file that is neither of Gmsh nor VTU ({path})")
    told = io.StringIO()
    try:
        # it prints why it cannot read a file, and then ends the program
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(io.StringIO()):
            mesh = meshio.read(path, file_format=_format(path))
    except (Exception, SystemExit) as error:
        why = " ".join(told.getvalue().split())
        if not why:
            quits = isinstance(error, SystemExit)
            why = "its content is not what its ending says" if quits else f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: meshio cannot read the file: {why}") from None
    if os.path.splitext(path)[1].lower() in (".e", ".exo", ".ex2"):
        for block in mesh.cells:
            if block.type in _EXODUS:
                block.data = block.data[:, _EXODUS[block.type]]
    try:
        return of_meshio(mesh, group, space)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _format(path: str) -> str | None:
    """The format of a file whose ending does not tell it: UCD of AVS begins with counts, a deck with a keyword."""
    if os.path.splitext(path)[1].lower() != ".inp":
        return None
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = (line.strip() for line in file)
        first = next((line for line in lines if line and not line.startswith("#")), "")
    return "avsucd" if first[:1].isdigit() else None


def of_meshio(mesh: Any, group: str | Sequence[str] | None = None, space: bool | None = None) -> Mesh:
    """A mesh of meshio: its sets, or the numbers of groups, are groups of cells, sides and points.

    Sets of facets are sides, sets of nodes are sides where they cover facets of the boundary, else points. ``boundary`` is the
    whole boundary where no set has that name. Cells that are listed several times, as version 2.2 of Gmsh's format has them,
    count once. ``group`` selects cells; ``space`` is as in :func:`dotyk.read`.
    """
    import numpy as np

    points = np.asarray(unmasked(mesh.points, "`points` of meshio"), dtype=float)
    if points.size == 0:
        raise InputError("the mesh of meshio has no points")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(f"points of meshio have the shape {points.shape}: it must be (n, 2) or (n, 3)")
    dimension = _wanted(mesh, space)
    notes: list[str] = []
    sets = _named(_sets(mesh), notes)
    _refuse_unknown(mesh, sets, dimension)
    blocks = [_nodes(block, len(points)) for block in mesh.cells]
    cells = _cells(mesh, blocks, sets, dimension, _chosen(sets, mesh, group, dimension), notes)
    if not cells:
        raise InputError("the mesh of meshio has no cells that a body can be made of")
    used = np.unique(np.concatenate([nodes.ravel() for nodes in cells.values()]))
    number = np.full(len(points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    facets = []
    for k, block in enumerate(mesh.cells):
        if block.type in _FACETS[dimension].values():
            corners = number[blocks[k][:, : _CORNERS[block.type]]]
            for name, members in sets.items():
                own = corners[members[k]]
                kept = own[(own >= 0).all(axis=1)]
                if len(kept):
                    facets.append((name, np.ascontiguousarray(kept)))
                if group is None and len(kept) < len(own):
                    off = len(own) - len(kept)
                    notes.append(f"{off} facets of the group `{name}` belong to no cell and are left out")
    nodes_of = {name: number[nodes] for name, nodes in _named(_node_sets(mesh, sets, blocks), notes).items()}
    held = {name: np.unique(nodes[nodes >= 0]) for name, nodes in nodes_of.items()}
    own_sets = [(name, nodes.tolist()) for name, nodes in held.items() if 0 < len(nodes) < len(used)]
    body = [(kind, of_group, number[nodes]) for (kind, of_group), nodes in cells.items()]
    places = np.ascontiguousarray(_flat(points[used]) if dimension == 2 else points[used])
    return Mesh._of(_dotyk.Mesh.of_arrays(places, body, facets, {}, True, own_sets, notes))


def library(what: str) -> Any:
    """meshio; its table of dimensions has all kinds but the wedge of 15 nodes, of which it could make no mesh."""
    meshio = friend("meshio", what)
    getattr(friend("meshio._mesh", what), "topological_dimension", {}).setdefault("wedge15", 3)
    return meshio


def _wanted(mesh: Any, space: bool | None) -> int:
    """The dimension of the body."""
    solid = any(_dimension(block) == 3 and len(block.data) for block in mesh.cells)
    if space and not solid:
        raise InputError("the mesh of meshio has no cells of space (tetrahedra, hexahedra or prisms)")
    return 3 if solid and space is not False else 2


def _flat(points: Any) -> Any:
    """Points without their third coordinate, which must be the same everywhere."""
    if points.shape[1] == 2:
        return points
    low, high = points[:, 2].min(), points[:, 2].max()
    width = (points[:, :2].max(axis=0) - points[:, :2].min(axis=0)).sum()
    if not high - low <= 1e-9 * width:
        raise InputError(
            f"z runs from {low:g} to {high:g} in the body: a plane mesh has one z, and a body of space needs cells of space "
            "(tetrahedra, hexahedra or prisms)"
        )
    return points[:, :2]


def _nodes(block: Any, count: int) -> Any:
    """The nodes of a block of cells; of kinds that nobody asks for, whatever it has."""
    if block.type not in _KINDS and block.type not in ("vertex", *_CORNERS):
        return block.data
    nodes = _indices(block.data, f"cells of the kind {block.type}")
    if nodes.size and not (0 <= nodes.min() and nodes.max() < count):
        raise InputError(f"cells of the kind {block.type}: a node is none of the {count} points")
    return nodes


def _cells(
    mesh: Any, blocks: Sequence[Any], sets: Mapping[str, Any], dimension: int, chosen: Any, notes: list[str]
) -> dict[Any, Any]:
    """Nodes of the cells of a body by kind and group; a cell of several groups is in the first one."""
    import numpy as np

    kinds = [k for k, block in enumerate(mesh.cells) if _KINDS.get(block.type) and _dimension(block) == dimension]
    count = sum(len(blocks[k]) for k in kinds)
    sizes = {name: sum(len(members[k]) for k in kinds) for name, members in sets.items()}
    # a set of all cells tells nothing where there are others
    order = sorted(sets, key=lambda name: sizes[name] == count)
    cells: dict[Any, list[Any]] = {}
    several = 0
    for k in kinds:
        group = np.full(len(blocks[k]), -1)
        for place, name in enumerate(order):
            if chosen is None or name in chosen:
                own = np.zeros(len(group), bool)
                own[sets[name][k]] = True
                if sizes[name] < count:
                    several += int((own & (group >= 0)).sum())
                group[own & (group < 0)] = place
        # in the order of the groups, as they come first
        for place in np.unique(group):
            if place < 0 and chosen is not None:
                continue
            key = (_KINDS[mesh.cells[k].type], None if place < 0 else order[place])
            cells.setdefault(key, []).append(blocks[k][group == place])
    if several:
        notes.append(f"{several} cells are in several groups, and count in the one that comes first")
    return {key: np.vstack(own) for key, own in cells.items()}


def _chosen(sets: Mapping[str, Any], mesh: Any, group: str | Sequence[str] | None, dimension: int) -> Any:
    """The groups that a user names; None is all cells."""
    if group is None:
        return None
    chosen = [group] if isinstance(group, str) else list(group)
    if not all(isinstance(name, str) for name in chosen):
        raise ArgumentError("`group` is the name of a group or a list of names")
    kinds = [k for k, block in enumerate(mesh.cells) if _dimension(block) == dimension]
    known = [name for name, members in sets.items() if any(len(members[k]) for k in kinds)]
    wanted = [_valid(name) for name in chosen]
    for name in wanted:
        if name not in known:
            there = f"it has {', '.join(known)}" if known else "it has none: leave `group` out to take all cells"
            raise InputError(f"the mesh of meshio has no group of cells `{name}`; {there}")
    return wanted


def _dimension(block: Any) -> int:
    """Dimension of the cells of a block of meshio; 0 where it does not say."""
    kind = _KINDS.get(block.type)
    return int(getattr(block, "dim", 0)) if kind is None else 2 if kind in _PLANE else 3


def _refuse_unknown(mesh: Any, sets: Mapping[str, list[Any]], dimension: int) -> None:
    """Cells, and facets in groups, of kinds that would be left out without a word are an error with their kinds and counts."""
    known = [theirs for theirs, ours in _KINDS.items() if (ours in _PLANE) == (dimension == 2)]
    facets = list(_FACETS[dimension].values())
    counts: dict[str, int] = {}
    for k, block in enumerate(mesh.cells):
        if _dimension(block) == dimension and block.type not in known:
            counts[block.type] = counts.get(block.type, 0) + len(block.data)
        elif _dimension(block) == dimension - 1 and block.type not in facets:
            named = sum(len(members[k]) for members in sets.values())
            counts[block.type] = counts.get(block.type, 0) + named
    told = ", ".join(f"{count} `{kind}`" for kind, count in counts.items() if count)
    if told:
        tied = "; of a body with pyramids make two, of its tetrahedra and its hexahedra, tied by a contact"
        raise InputError(
            f"the mesh of meshio has cells of kinds that are not supported: {told}; divide them or leave them out "
            f"(supported: {', '.join(known)}, and as facets {', '.join(facets)}){tied if 'pyramid' in told else ''}"
        )


def _valid(name: str) -> str:
    """A name that case files can use: each run of other characters is one `_`, as in mesh files."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name.strip())


def _named(sets: Mapping[str, Any], notes: list[str]) -> dict[str, Any]:
    """The same sets under names that case files can use."""
    named: dict[str, Any] = {}
    before: dict[str, str] = {}
    for original, members in sets.items():
        name = _valid(original)
        if not name:
            notes.append("a set without a name is left out")
            continue
        if name in before:
            raise InputError(
                f"the groups `{before[name]}` and `{original}` would both be called `{name}` (letters, digits, `_` and `-` "
                "are kept): rename one of them"
            )
        before[name] = original
        named[name] = members
        note = f"the group `{original}` is called `{name}`: names consist of letters, digits, `_` and `-`"
        if name != original and note not in notes:
            notes.append(note)
    return named


def _members(own: Any, count: int, name: str) -> Any:
    """Numbers of cells or nodes, which may be given as a mask."""
    import numpy as np

    if np.ma.isMaskedArray(own) and not np.ma.is_masked(own):
        # files of Exodus come with masks that hide nothing
        own = own.data
    array = np.asarray(unmasked(own, f"the set `{name}` of meshio"))
    if array.dtype == bool:
        array = np.flatnonzero(array)
    if array.size and not (0 <= array.min() and array.max() < count):
        raise InputError(f"the set `{name}` of meshio names a cell or node that there is not")
    return array.astype(np.int64).ravel()


def _sets(mesh: Any) -> dict[str, list[Any]]:
    """Members of every group, block by block: of Gmsh's groups, else families, sets, numbers."""
    physical = mesh.cell_data.get("gmsh:physical")
    if physical is not None:
        names = {(int(tag), int(dimension)): str(name) for name, (tag, dimension) in mesh.field_data.items()}
        return _numbered(mesh, physical, lambda tag, block: [names.get((abs(tag), block.dim), str(abs(tag)))])
    families = mesh.cell_data.get("cell_tags")
    of_family = getattr(mesh, "cell_tags", None)
    if families is not None and of_family:
        return _numbered(mesh, families, lambda tag, _: _family(of_family, tag))
    sets = {
        str(name): [
            _members([] if own is None else own, len(block.data), str(name))
            for own, block in zip(members, mesh.cells, strict=True)
        ]
        for name, members in mesh.cell_sets.items()
        if not str(name).startswith("gmsh:")
    }
    numbers = next((mesh.cell_data[key] for key in _NUMBERS if key in mesh.cell_data), None)
    if sets or numbers is None:
        return sets
    return _numbered(mesh, numbers, lambda tag, _: [str(tag)])


def _family(families: Mapping[Any, Any], tag: int) -> list[str]:
    """Names of the groups of a family of MED."""
    return [str(name).strip("\0 ") for name in families.get(tag, [])]


def _numbered(mesh: Any, numbers: Sequence[Any], names: Any) -> dict[str, list[Any]]:
    """Members of the groups of each number; zero is no group."""
    import numpy as np

    sets: dict[str, list[Any]] = {}
    for k, (block, own) in enumerate(zip(mesh.cells, numbers, strict=True)):
        own = np.asarray(own).ravel()
        for tag in np.unique(own[np.isfinite(own)]):
            for name in names(int(tag), block) if tag else []:
                members = sets.setdefault(name, [np.array([], dtype=np.int64) for _ in mesh.cells])
                members[k] = np.union1d(members[k], np.flatnonzero(own == tag))
    return sets


def _node_sets(mesh: Any, sets: Mapping[str, list[Any]], blocks: Sequence[Any]) -> dict[str, Any]:
    """Nodes of every set of nodes: those of meshio, families of nodes, groups of points."""
    import numpy as np

    count = len(mesh.points)
    found: dict[str, list[Any]] = {}
    for name, nodes in mesh.point_sets.items():
        found.setdefault(str(name), []).append(_members(nodes, count, str(name)))
    tags = mesh.point_data.get("point_tags")
    families = getattr(mesh, "point_tags", None)
    if tags is not None and families:
        numbers = np.asarray(tags).ravel()
        for tag in np.unique(numbers):
            for name in _family(families, int(tag)):
                found.setdefault(name, []).append(np.flatnonzero(numbers == tag))
    for name, nodes in _vertices(mesh, sets, blocks):
        found.setdefault(name, []).append(nodes)
    return {name: np.concatenate(nodes) for name, nodes in found.items()}


def _vertices(mesh: Any, sets: Mapping[str, list[Any]], blocks: Sequence[Any]) -> Iterator[tuple[str, Any]]:
    """Nodes of the cells of one node in every set."""
    for k, block in enumerate(mesh.cells):
        if block.type == "vertex":
            for name, members in sets.items():
                if len(members[k]):
                    yield name, blocks[k][members[k]].ravel()
