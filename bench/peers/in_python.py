"""What the peers that are Python modules have in common: a process that reads the problem, solves it and tells the answer."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np

import problems


def prepare(problem: problems.Problem, folder: Path) -> None:
    problem.save(folder / "problem.npz")


def tell(
    folder: Path, moved: list[np.ndarray], reaction: list[float], solve: float, iterations: int, converged: bool
) -> None:
    """The end of the process: displacements as arrays, the rest as one line of JSON."""
    np.savez(folder / "moved.npz", *moved)
    told = {"reaction": reaction, "solve": solve, "iterations": iterations, "converged": converged}
    print(json.dumps(told), flush=True)


def answer(problem: problems.Problem, folder: Path) -> dict:
    line = (folder / "stdout.txt").read_text().rstrip("\n").rsplit("\n", 1)[-1]
    with np.load(folder / "moved.npz") as file:
        return json.loads(line) | {"moved": [file[name] for name in file.files]}


def version(python: str, expression: str) -> str:
    """What a line of Python prints last, such as the version of a module."""
    said = subprocess.run([python, "-c", expression], capture_output=True, text=True)
    return said.stdout.strip().rsplit("\n", 1)[-1] if said.returncode == 0 else "not there"
