"""CalculiX (Debian's calculix-ccx) on a problem: face-to-face penalty contact.

Its manual ("Contact", "*SURFACE BEHAVIOR") has faces on faces for meshes that do not match, a pressure linear in the
overlap, and a slope K of 5 to 50 times Young's modulus. Chosen here:
* K = 100 E / L, E of the softer body, L the size of the contact (a modulus has no length in it): 7 E in the tunnel, 100 E
  of the blocks. There the force at 50 E is more than a per cent low; in the tunnel matching polygons interlock like gears
  when K is larger (at 50 E of the coarsest the pressure is three times too large, and it is reported as converged);
* with friction the stick slope is K: with K / 10 shear is six per cent low;
* SPOOLES, its default solver; with_calculix_iterative.py has the other;
* the load of problems without gaps is scaled by 1e-4 and the answer back: contact is searched on the moved bodies.
NLGEOM is left out, as strains are small. Displacements are written as text of 7 digits.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

import problems

NAME = "CalculiX"
PENALTY = True
SETTINGS = "surface to surface, K = 100 E / size of the contact, SPOOLES"
SOLVER = "SPOOLES"
SOLVE_WORDS = "its whole process: it tells no times of its own"
# K times the size of the contact over the modulus of the softer body.
FACTOR = 100.0
SCALE = 1e-4


def command(folder: Path, tools: dict[str, str], threads: int) -> list[str]:
    return [tools["ccx"], "-i", "job"]


def scale(problem: problems.Problem) -> float:
    return SCALE if problem.homogeneous else 1.0


def prepare(problem: problems.Problem, folder: Path, solver: str = SOLVER) -> None:
    plane = problem.dimension == 2
    scaled = scale(problem)
    cells_of, offsets = [0, len(problem.bodies[0].cells)], problem.offsets

    def number(nodes: np.ndarray, body: int) -> list:
        return (nodes + offsets[body] + 1).tolist()

    with open(folder / "job.inp", "w") as file:

        def tell(*lines) -> None:
            print(*lines, sep="\n", file=file)

        tell("*NODE,NSET=ALL")
        points = np.concatenate([body.points for body in problem.bodies])
        if plane:
            points = np.column_stack([points, np.zeros(len(points))])
        file.writelines("%d,%.15g,%.15g,%.15g\n" % (k, *point) for k, point in enumerate(points, start=1))
        for k, body in enumerate(problem.bodies):
            tell(f"*ELEMENT,TYPE={'CPE3' if plane else 'C3D8'},ELSET={body.name}")
            for cell, nodes in enumerate(number(body.cells, k), start=cells_of[k] + 1):
                file.write(f"{cell},{','.join(map(str, nodes))}\n")
            for side in body.sides:
                tell(f"*NSET,NSET={body.name}-{side}", *number(body.nodes(side), k))
            tell(f"*MATERIAL,NAME={body.name}", "*ELASTIC", f"{body.young},{body.poisson}")
            tell(f"*SOLID SECTION,ELSET={body.name},MATERIAL={body.name}", *(["1."] if plane else []))
        of, axes = problem.proof
        for axis, nodes in zip(axes, problem.reacting()):
            tell(f"*NSET,NSET=held{axis}", *number(nodes, of))
        for k, side in (problem.nonmortar, problem.mortar):
            tell(f"*SURFACE,NAME={problem.bodies[k].name}-{side},TYPE=ELEMENT")
            for cell, facet in problem.bodies[k].sides[side].tolist():
                tell(f"{cell + cells_of[k] + 1},S{facet + 1}")
        slope = FACTOR * min(body.young for body in problem.bodies) / problem.length
        tell("*SURFACE INTERACTION,NAME=pair", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR", f"{slope:.10g},0.001")
        if problem.friction:
            tell("*FRICTION", f"{problem.friction},{slope:.10g}")
        pair = [f"{problem.bodies[k].name}-{side}" for k, side in (problem.nonmortar, problem.mortar)]
        tell("*CONTACT PAIR,INTERACTION=pair,TYPE=SURFACE TO SURFACE", ",".join(pair))
        moves = []
        tell("*BOUNDARY")
        for k, side, values in problem.fix:
            for axis, value in enumerate(values, start=1):
                if value is not None:
                    line = f"{problem.bodies[k].name}-{side},{axis},{axis},{value * scaled:.10g}"
                    if value:
                        moves.append(line)
                    else:
                        tell(line)
        tell("*STEP,INC=100", f"*STATIC,SOLVER={solver}", "1.,1.")
        if moves:
            tell("*BOUNDARY", *moves)
        for k, side, force in problem.load:
            # a load across the side, pushing
            size = float(np.linalg.norm(force)) * scaled
            tell("*DLOAD")
            for cell, facet in problem.bodies[k].sides[side].tolist():
                tell(f"{cell + cells_of[k] + 1},P{facet + 1},{size:.10g}")
        tell("*NODE PRINT,NSET=ALL", "U")
        for axis in axes:
            tell(f"*NODE PRINT,NSET=held{axis},TOTALS=ONLY", "RF")
        tell("*END STEP")


def version(tools: dict[str, str]) -> str:
    said = subprocess.run([tools["ccx"], "-v"], capture_output=True, text=True).stdout
    return said.split("ersion")[-1].strip()


def answer(problem: problems.Problem, folder: Path) -> dict:
    log = (folder / "stdout.txt").read_text()
    errors = [line.strip() for line in log.splitlines() if "*ERROR" in line]
    lines = (folder / "job.dat").read_text().splitlines()
    starts = [k for k, line in enumerate(lines) if line.startswith(" displacements")]
    if errors or not starts:
        raise RuntimeError("; ".join(errors) or "no displacements")
    moved = np.zeros((sum(len(body.points) for body in problem.bodies), 3))
    for line in lines[starts[-1] + 2 :]:
        if not line.strip():
            break
        node, *values = line.split()
        moved[int(node) - 1] = [float(value) for value in values]
    moved = moved[:, : problem.dimension] / scale(problem)
    reaction = []
    for axis in problem.proof[1]:
        head = next(k for k, line in enumerate(lines) if "total force" in line and f"HELD{axis} " in line)
        total = next(line for line in lines[head + 1 :] if line.strip()).split()
        reaction.append(float(total[axis]) / scale(problem))
    return {
        "moved": np.split(moved, [problem.offsets[1]]),
        "reaction": reaction,
        "iterations": log.count(" iteration "),
        "converged": "Job finished" in log,
    }
