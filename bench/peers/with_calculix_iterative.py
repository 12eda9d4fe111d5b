"""CalculiX with its iterative solver, conjugate gradients with an incomplete Cholesky factor: its fast one in space.

Its manual ("*STATIC") advises it for bulky structures and against it for thin ones; plane problems are left to SPOOLES.
"""

from __future__ import annotations

from pathlib import Path

import problems
import with_calculix
from with_calculix import PENALTY, SOLVE_WORDS, answer, command, version  # noqa: F401, part of what a peer is

NAME = "CalculiX, iterative"
SETTINGS = "surface to surface, the same K, ITERATIVE CHOLESKY"


def excluded(problem: problems.Problem) -> str:
    return "" if problem.dimension == 3 else "its manual advises the iterative solver for bulky structures in space"


def prepare(problem: problems.Problem, folder: Path) -> None:
    with_calculix.prepare(problem, folder, "ITERATIVE CHOLESKY")
