"""Kratos (pip KratosMultiphysics-all) on a problem: augmented Lagrangian dual mortar contact.

As the pages of its contact application have it: the ALM process with its default search, multipliers on the slave side,
SmallDisplacement elements. Chosen here:
* components are not needed without friction: ALMContactFrictionless; with it ALMContactFrictional and Coulomb's law;
* in the plane its default direct solver; in space `amgcl`, ten times as fast there as the default;
* contact residual 1e-8 without friction; with friction 1e-4: it does not come to 1e-8 in 40 steps;
* nodes of the contact that supports hold across it on both sides leave a column of its matrix empty, with friction and in
  space ("structurally singular"): those of the mortar side are not held there, as the contact holds them. Every other
  program holds them. Without friction in space this changes the force by less than 0.1 per cent;
* the load of problems without gaps is scaled by 1e-4 and the answer back: it works on the moved bodies.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import numpy as np

import in_python
import problems
from in_python import answer  # noqa: F401, part of what a peer is

NAME = "Kratos"
PENALTY = False
SETTINGS = (
    "ALM dual mortar, amgcl in space; with friction and in space the mortar side's nodes at the contact are not held, "
    "which its matrix does not allow"
)
SOLVE_WORDS = "the solution loop, without reading the mesh and setting up"
SCALE = 1e-4
ELEMENT = {3: "SmallDisplacementElement2D3N", 8: "SmallDisplacementElement3D8N"}
SURFACE = {2: "LineCondition2D2N", 3: "SurfaceCondition3D4N"}
LOADED = {2: "LineLoadCondition2D2N", 3: "SurfaceLoadCondition3D4N"}
MOST = 60


def version(tools: dict[str, str]) -> str:
    return in_python.version(
        tools["python"], "from importlib.metadata import version as v; print(v('KratosMultiphysics'))"
    )


def command(folder: Path, tools: dict[str, str], threads: int) -> list[str]:
    return [tools["python"], __file__, str(folder)]


def scale(problem: problems.Problem) -> float:
    return SCALE if problem.homogeneous else 1.0


def singular(problem: problems.Problem) -> bool:
    """Whether nodes of the contact that both bodies hold leave a column of its matrix empty."""
    return problem.dimension == 3 or problem.friction > 0


def write_mesh(problem: problems.Problem, path: Path) -> None:
    """Nodes, elements, a condition for each facet that touches or bears a load, and a part for each side."""
    pad = np.zeros((1, 3 - problem.dimension))
    offsets = problem.offsets
    element, condition = 0, 0
    parts: list[tuple[str, list, range, range]] = []
    with open(path, "w") as file:

        def tell(*lines) -> None:
            print(*lines, sep="\n", file=file)

        def nodes_of(number: int, side: str) -> list[int]:
            return (problem.bodies[number].nodes(side) + offsets[number] + 1).tolist()

        tell("Begin ModelPartData", "End ModelPartData")
        for number in range(3):
            tell(f"Begin Properties {number}", "End Properties")
        tell("Begin Nodes")
        points = np.concatenate([body.points for body in problem.bodies])
        points = np.column_stack([points, np.repeat(pad, len(points), axis=0)])
        file.writelines("%d %.17g %.17g %.17g\n" % (k, *point) for k, point in enumerate(points, start=1))
        tell("End Nodes")
        for number, body in enumerate(problem.bodies):
            tell(f"Begin Elements {ELEMENT[body.cells.shape[1]]}")
            for nodes in (body.cells + offsets[number] + 1).tolist():
                element += 1
                file.write(f"{element} {number + 1} {' '.join(map(str, nodes))}\n")
            tell("End Elements")
            all_nodes = range(offsets[number] + 1, offsets[number] + len(body.points) + 1)
            parts.append((body.name, list(all_nodes), range(element - len(body.cells) + 1, element + 1), range(0)))

        def conditions(kind: str, number: int, side: str) -> range:
            nonlocal condition
            first = condition + 1
            tell(f"Begin Conditions {kind}")
            for nodes in (problem.bodies[number].facets(side) + offsets[number] + 1).tolist():
                condition += 1
                file.write(f"{condition} 0 {' '.join(map(str, nodes))}\n")
            tell("End Conditions")
            return range(first, condition + 1)

        both: list[int] = []
        for word, (number, side) in (("slave", problem.nonmortar), ("master", problem.mortar)):
            parts.append((word, nodes_of(number, side), range(0), conditions(SURFACE[problem.dimension], number, side)))
            both += parts[-1][1]
        parts.append(("contact", both, range(0), range(1, condition + 1)))
        for place, (number, side, _) in enumerate(problem.load):
            facets = conditions(LOADED[problem.dimension], number, side)
            parts.append((f"load{place}", nodes_of(number, side), range(0), facets))
        touching = set(nodes_of(*problem.mortar)) if singular(problem) else set()
        for place, (number, side, _) in enumerate(problem.fix):
            nodes = [node for node in nodes_of(number, side) if node not in touching]
            parts.append((f"fix{place}", nodes, range(0), range(0)))
        for name, nodes, elements, facets in parts:
            tell(f"Begin SubModelPart {name}")
            for word, listed in (("Nodes", nodes), ("Elements", elements), ("Conditions", facets)):
                if len(listed):
                    tell(f"Begin SubModelPart{word}", *listed, f"End SubModelPart{word}")
            tell("End SubModelPart")


def settings(problem: problems.Problem) -> dict:
    plane, friction = problem.dimension == 2, problem.friction > 0
    scaled = scale(problem)
    law = "Frictional" if friction else "Frictionless"

    def process(module: str, of: str, **parameters) -> dict:
        part = {"model_part_name": "Structure" + (f".{of}" if of else "")}
        application = "KratosMultiphysics"
        if "contact_type" in parameters:
            application += ".ContactStructuralMechanicsApplication"
        return {"python_module": module, "kratos_module": application, "Parameters": part | parameters}

    held = []
    for place, (_, _, values) in enumerate(problem.fix):
        values = [value if value is None else value * scaled for value in values + [None] * (3 - len(values))]
        constrained = [value is not None for value in values]
        always = {"variable_name": "DISPLACEMENT", "interval": [0.0, "End"]}
        held.append(
            process("assign_vector_variable_process", f"fix{place}", **always, constrained=constrained, value=values)
        )
    loads = []
    for place, (_, _, force) in enumerate(problem.load):
        size = float(np.linalg.norm(force))
        way = {"direction": [value / size for value in force + [0.0] * (3 - len(force))], "modulus": size * scaled}
        variable = {"variable_name": "LINE_LOAD" if plane else "SURFACE_LOAD", "interval": [0.0, "End"]}
        loads.append(process("assign_vector_by_direction_to_condition_process", f"load{place}", **variable, **way))
    coulomb = {"frictional_law": "Coulomb", "friction_coefficients": {"0": problem.friction}} if friction else {}
    pair = {"contact_model_part": {"0": ["contact"]}, "assume_master_slave": {"0": ["slave"]}, "contact_type": law}
    solver = {
        "solver_type": "Static",
        "echo_level": 0,
        "model_part_name": "Structure",
        "domain_size": problem.dimension,
        "analysis_type": "non_linear",
        "time_stepping": {"time_step": 1.1},
        "model_import_settings": {"input_type": "mdpa", "input_filename": "mesh"},
        "material_import_settings": {"materials_filename": "materials.json"},
        "max_iteration": MOST,
        "contact_settings": {"mortar_type": f"ALMContact{law}"},
        "convergence_criterion": "contact_residual_criterion",
        "residual_relative_tolerance": 1e-4 if friction else 1e-8,
        "residual_absolute_tolerance": 1e-12 if problem.homogeneous else 1e-9,
    }
    if not plane:
        solver["linear_solver_settings"] = {"solver_type": "amgcl"}
    times = {"start_time": 0.0, "end_time": 1.0}
    return {
        "problem_data": {"problem_name": "mesh", "parallel_type": "OpenMP", "echo_level": 0} | times,
        "solver_settings": solver,
        "processes": {
            "constraints_process_list": held,
            "loads_process_list": loads,
            "contact_process_list": [process("alm_contact_process", "", **pair, **coulomb)],
        },
        "output_processes": {},
    }


def prepare(problem: problems.Problem, folder: Path) -> None:
    in_python.prepare(problem, folder)
    write_mesh(problem, folder / "mesh.mdpa")
    law = "LinearElasticPlaneStrain2DLaw" if problem.dimension == 2 else "LinearElastic3DLaw"
    materials = []
    for number, body in enumerate(problem.bodies, start=1):
        values = {"DENSITY": 1.0, "YOUNG_MODULUS": body.young, "POISSON_RATIO": body.poisson}
        values |= {"THICKNESS": 1.0} if problem.dimension == 2 else {}
        values |= {"FRICTION_COEFFICIENT": problem.friction} if problem.friction else {}
        material = {"constitutive_law": {"name": law}, "Variables": values, "Tables": {}}
        materials.append({"model_part_name": f"Structure.{body.name}", "properties_id": number, "Material": material})
    (folder / "materials.json").write_text(json.dumps({"properties": materials}))
    (folder / "settings.json").write_text(json.dumps(settings(problem)))


def solve(folder: Path) -> None:
    import KratosMultiphysics as KM
    import KratosMultiphysics.ContactStructuralMechanicsApplication  # noqa: F401, registers the mortar conditions
    import KratosMultiphysics.StructuralMechanicsApplication  # noqa: F401
    from KratosMultiphysics.StructuralMechanicsApplication.structural_mechanics_analysis import (
        StructuralMechanicsAnalysis,
    )

    problem = problems.Problem.read(folder / "problem.npz")
    os.chdir(folder)
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    analysis = StructuralMechanicsAnalysis(KM.Model(), KM.Parameters(Path("settings.json").read_text()))
    analysis.Initialize()
    begin = time.perf_counter()
    analysis.RunSolutionLoop()
    seconds = time.perf_counter() - begin
    analysis.Finalize()
    model = analysis.model["Structure"]
    steps = int(model.ProcessInfo[KM.NL_ITERATION_NUMBER])
    moved = np.array([list(node.GetSolutionStepValue(KM.DISPLACEMENT)) for node in model.Nodes])
    forces = np.array([list(node.GetSolutionStepValue(KM.REACTION)) for node in model.Nodes])
    scaled = scale(problem)
    number, axes = problem.proof
    held = problem.reacting()
    reaction = [float(forces[problem.offsets[number] + nodes, axis].sum()) / scaled for axis, nodes in zip(axes, held)]
    moved = np.split(moved[:, : problem.dimension] / scaled, [problem.offsets[1]])
    in_python.tell(Path("."), moved, reaction, seconds, steps, steps < MOST)


if __name__ == "__main__":
    solve(Path(sys.argv[1]))
