"""Peers: the friction solvers of Siconos on the same problems, judged by the same scaled error.

    /usr/bin/python3 bench/friction/siconos.py FOLDER RESULTS.csv [--limit 60] [--tolerance 1e-8] [--only TEXT]

Needs Debian's python3-siconos (apt-get install --no-install-recommends python3-siconos), numpy and scipy, and
python3-h5py for HDF5 files. Files are read by problems.py, not by Siconos: its own reader does not come back from what
CSparse prints.

What the peers are given:
* W / max diag W and q / |q|: in these units the measure that they stop on is the scaled error, but for its
  denominator (|q| there, the larger of |r| and rho |q| here), so that they are asked for the same or a little more;
* no limit of iterations: the clock decides, which begins when the problem is read and ends the process;
* W in blocks, as most files have it; dense below 100 unknowns, where that is faster for all but NSGS;
* problems in the plane: NSGS for the plane; the others exist in space only and get a third component with its own
  W = 1 and q = 0, whose force is 0, which changes nothing else.

RESULTS.csv: problem, solver, seconds, iterations, scaled, solved (1 or 0). Empty seconds: the time was over, or the
process ended without an answer.
"""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
import scipy.sparse as sparse

import problems

# This file has the name of the package.
sys.path.remove(os.path.dirname(os.path.abspath(__file__)))

SOLVERS = ["NSGS", "NSN_AC", "ADMM", "PROX"]
MOST = 2**31 - 1
DENSE = 100
READING = 300.0


def in_space(problem):
    """W, q, dimension of a plane problem with a third component that bears no force."""
    contacts = len(problem.mu)
    size = 3 * contacts
    place = np.arange(size).reshape(-1, 3)[:, :2].ravel()
    entries = problem.W.tocoo()
    third = np.arange(2, size, 3)
    rows = np.concatenate([place[entries.row], third])
    columns = np.concatenate([place[entries.col], third])
    values = np.concatenate([entries.data, np.full(contacts, 1.0 / problem.unit())])
    q = np.zeros(size)
    q[place] = problem.q
    return sparse.csr_matrix((values, (rows, columns)), shape=(size, size)), q, place


def in_blocks(dimension, W, q, mu):
    """The problem in blocks, by way of a text file: the Python interface has no other."""
    import siconos.numerics as numerics

    blocks = W.tobsr((dimension, dimension))
    blocks.sort_indices()
    contacts = len(mu)
    ends = " ".join(str(dimension * (k + 1)) for k in range(contacts))
    lines = [str(x) for x in (dimension, contacts, 1, len(q), len(q), len(blocks.indices), contacts, contacts)]
    lines += [ends, ends, str(contacts + 1), str(len(blocks.indices))]
    lines += [" ".join(map(str, numbers)) for numbers in (blocks.indptr, blocks.indices)]
    for number, block in enumerate(blocks.data):
        lines.append(str(number))
        lines += [repr(float(x)) for x in block.T.ravel()]
    lines += [" ".join(repr(float(x)) for x in numbers) for numbers in (q, mu)]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "problem.dat")
        with open(path, "w") as file:
            file.write("\n".join(lines) + "\n0\n")
        return numerics.frictionContact_new_from_filename(path)


def single(path, solver, tolerance):
    """Solves one problem; prints `ready`, and then seconds, iterations and the scaled error."""
    import siconos.numerics as numerics

    problem = problems.read(path)
    dimension, W, q = problem.dimension, problem.W, problem.q
    place = slice(None)
    if dimension == 2 and solver != "NSGS":
        W, q, place = in_space(problem)
        dimension = 3
    size = np.linalg.norm(q)
    size = size if size > 0.0 else 1.0
    W, q = (W * problem.unit()).tocsr(), q / size
    if len(q) < DENSE and solver != "NSGS":
        data = numerics.FrictionContactProblem(
            dimension, len(problem.mu), np.asfortranarray(W.toarray()), q, problem.mu
        )
    else:
        data = in_blocks(dimension, W, q, problem.mu)
    options = numerics.SolverOptions(getattr(numerics, f"SICONOS_FRICTION_{dimension}D_{solver}"))
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = MOST
    options.dparam[numerics.SICONOS_DPARAM_TOL] = tolerance
    driver = numerics.fc2d_driver if dimension == 2 else numerics.fc3d_driver
    force, velocity = np.zeros(len(q)), np.zeros(len(q))
    print("ready", flush=True)
    begin = time.perf_counter()
    driver(data, force, velocity, options)
    seconds = time.perf_counter() - begin
    iterations = options.iparam[numerics.SICONOS_IPARAM_ITER_DONE]
    error = problem.scaled(force[place] * problem.unit() * size)
    print(f"\nanswer {seconds:e} {iterations} {error:e}", flush=True)


def in_own_process(path, solver, limit, tolerance):
    """(seconds, iterations, scaled error), or None where there is no answer within the limit."""
    command = [sys.executable, os.path.abspath(__file__), "--single", path, solver, repr(tolerance)]
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    output = tempfile.TemporaryFile("w+")
    child = subprocess.Popen(command, stdout=output, stderr=subprocess.DEVNULL, env=environment)

    def said(word):
        output.flush()
        output.seek(0)
        return [line.split() for line in output if line.startswith(word)]

    def wait(until, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end and child.poll() is None and not said(until):
            time.sleep(0.02)

    wait("ready", READING)
    if said("ready"):
        wait("answer", limit)
    child.kill()
    child.wait()
    answer = said("answer")
    if not answer:
        return None
    return float(answer[0][1]), int(answer[0][2]), float(answer[0][3])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("results")
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--tolerance", type=float, default=1e-8)
    parser.add_argument("--only", default="", help="only problems whose names hold this text")
    arguments = parser.parse_args()
    rows = []
    for path in problems.files(arguments.folder):
        name = problems.name_of(path)
        if arguments.only not in name:
            continue
        try:
            problems.read(path)
        except problems.Unreadable as reason:
            print(f"left out: {reason}")
            continue
        for solver in SOLVERS:
            answer = in_own_process(path, solver, arguments.limit, arguments.tolerance)
            if answer is None:
                rows.append([name, solver, "", "", "", 0])
                print(f"{name:<44} {solver:<7} no answer within {arguments.limit:g} s", flush=True)
                continue
            seconds, iterations, error = answer
            solved = int(error <= arguments.tolerance)
            rows.append([name, solver, f"{seconds:e}", iterations, f"{error:e}", solved])
            verdict = "solved" if solved else "NOT solved"
            print(f"{name:<44} {solver:<7} {iterations:>9} {seconds:>9.4f} {error:>8.1e}  {verdict}", flush=True)
    partial = arguments.results + ".part"
    with open(partial, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["problem", "solver", "seconds", "iterations", "scaled", "solved"])
        writer.writerows(rows)
    os.replace(partial, arguments.results)
    for solver in SOLVERS:
        mine = [row for row in rows if row[1] == solver]
        print(f"{solver}: solved {sum(row[5] for row in mine)} of {len(mine)}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--single"]:
        single(sys.argv[2], sys.argv[3], float(sys.argv[4]))
    else:
        main()
