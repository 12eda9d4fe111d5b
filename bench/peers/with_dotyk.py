"""dotyk on a problem: one mesh file of Gmsh for each body, as a user would have it, and a case file.

Nothing is set but the contact pair, which tells nonmortar and mortar side as the others are told; solver, pairing and
gap are dotyk's own choice.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import meshio
import numpy as np

import problems

NAME = "dotyk"
PENALTY = False
SETTINGS = "defaults"
CELLS = {3: ("triangle", "line"), 8: ("hexahedron", "quad")}
SOLVE = ("assemble", "order", "factor", "condense", "contact", "recover")
SOLVE_WORDS = "its own clock, from assembly to recovered stresses"


def version(tools: dict[str, str]) -> str:
    return subprocess.run([tools["dotyk"], "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]


def write_mesh(body: problems.Body, path: Path) -> None:
    dimension = body.points.shape[1]
    solid, facet = CELLS[body.cells.shape[1]]
    points = np.column_stack([body.points, np.zeros((len(body.points), 3 - dimension))])
    cells = [(solid, body.cells)]
    numbers = [np.ones(len(body.cells), np.int32)]
    names = {body.name: np.array([1, dimension])}
    for number, side in enumerate(body.sides, start=2):
        cells.append((facet, body.facets(side)))
        numbers.append(np.full(len(body.sides[side]), number, np.int32))
        names[side] = np.array([number, dimension - 1])
    data = {"gmsh:physical": numbers, "gmsh:geometrical": numbers}
    meshio.Mesh(points, cells, cell_data=data, field_data=names).write(path, file_format="gmsh22", binary=True)


def prepare(problem: problems.Problem, folder: Path) -> None:
    lines = [f'analysis = "{"plane-strain" if problem.dimension == 2 else "3d"}"']
    for number, body in enumerate(problem.bodies):
        write_mesh(body, folder / f"{body.name}.msh")
        fix = []
        for of, side, values in problem.fix:
            held = ", ".join(f"{axis} = {value}" for axis, value in zip("xyz", values) if value is not None)
            if of == number:
                fix.append(f'{{ side = "{side}", {held} }}')
        load = [f'{{ side = "{side}", traction = {force} }}' for of, side, force in problem.load if of == number]
        lines += [
            "[[body]]",
            f'name = "{body.name}"',
            f'mesh = {{ file = {{ path = "{body.name}.msh", group = "{body.name}" }} }}',
            f"material = {{ young = {body.young}, poisson = {body.poisson} }}",
            f"fix = [{', '.join(fix)}]",
            f"load = [{', '.join(load)}]",
        ]
    lines += ["[[contact]]", 'name = "contact"']
    for word, (number, side) in (("nonmortar", problem.nonmortar), ("mortar", problem.mortar)):
        lines.append(f'{word} = "{problem.bodies[number].name}.{side}"')
    if problem.friction:
        lines.append(f"friction = {problem.friction}")
    (folder / "case.toml").write_text("\n".join(lines) + "\n")


def command(folder: Path, tools: dict[str, str], threads: int) -> list[str]:
    return [tools["dotyk"], "run", "case.toml", "--out", "out", "--threads", str(threads), "--quiet"]


def answer(problem: problems.Problem, folder: Path) -> dict:
    out = folder / "out"
    summary = json.loads((out / "summary.json").read_text())
    moved = []
    for body in problem.bodies:
        field = meshio.read(out / f"{body.name}.vtu").point_data["displacement"]
        moved.append(np.array(field[:, : problem.dimension]))
    number, axes = problem.proof
    reaction = summary["bodies"][number]["reaction"]
    return {
        "moved": moved,
        "reaction": [reaction[axis] for axis in axes],
        "solve": sum(summary["seconds"][stage] for stage in SOLVE),
        "iterations": summary["iterations"],
        "converged": summary["converged"],
        "warnings": summary["warnings"],
    }
