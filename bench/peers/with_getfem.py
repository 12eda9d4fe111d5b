"""GetFEM (Debian's python3-getfem) on a problem: the integral contact brick between meshes that do not match.

As its documentation has it ("Contact with Coulomb friction bricks"): large or non-matching surfaces are for the integral
brick, an augmented Lagrangian solved by Newton's method; the multiplier lives on the nonmortar side. Chosen here:
* multipliers linear on the faces, as the displacements, filtered as in its examples; constant on each face where the rim
  of the contact lies between nodes (hertz): there linear ones oscillate, and the answer depends on r by several per cent;
* augmentation r = Young's modulus of the softer body: answers do not depend on it between E/1000 and 10 E;
* option 1, its default, the unsymmetric Alart-Curnier tangent; with friction the same brick with a coefficient;
* `lsolver mumps`: by itself it takes SuperLU and, when large, an iterative solver that does not come back;
* stop at 1e-8, simplest line search, at most 60 steps.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import in_python
import problems
from in_python import answer, prepare  # noqa: F401, part of what a peer is

NAME = "GetFEM"
SETTINGS = (
    "integral brick, augmented Lagrangian, r = E, MUMPS; multipliers constant on faces where the rim lies between nodes"
)
PENALTY = False
SOLVE_WORDS = "the set-up of the model and Model.solve, without the mesh"
MOST = 60
# GetFEM's own order of the nodes of a cell.
ORDER = {3: [0, 1, 2], 8: [0, 1, 3, 2, 4, 5, 7, 6]}


def version(tools: dict[str, str]) -> str:
    # the module does not tell it, its package does
    said = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", "python3-getfem"], capture_output=True, text=True)
    return said.stdout.split("+")[0].split("-")[0]


def command(folder: Path, tools: dict[str, str], threads: int) -> list[str]:
    return [tools["system python"], __file__, str(folder)]


def mesh_of(gf, body: problems.Body):
    """The mesh, its sides as regions 1, 2, .. in their order, and for each of its points the number of ours."""
    nodes = body.cells.shape[1]
    dimension = body.points.shape[1]
    mesh = gf.Mesh("empty", dimension)
    kind = gf.GeoTrans("GT_PK(2,1)" if nodes == 3 else "GT_QK(3,1)")
    mesh.set("add convex", kind, body.points[body.cells[:, ORDER[nodes]]].transpose(2, 1, 0))
    # its numbers of the facets of a cell: asked for the first one, by their nodes
    point = mesh.pid_in_cvids([0])
    numbers = {}
    for face in range(len(problems.FACETS[nodes])):
        there = mesh.pid_in_faces([[0], [face]])
        corners = {int(np.flatnonzero(point == p)[0]) for p in there}
        ours = {ORDER[nodes][corner] for corner in corners}
        numbers[next(k for k, facet in enumerate(problems.FACETS[nodes]) if set(facet) == ours)] = face
    number = np.array([numbers[k] for k in range(len(numbers))])
    for region, facets in enumerate(body.sides.values(), start=1):
        mesh.set_region(region, np.stack([facets[:, 0], number[facets[:, 1]]]))
    return mesh


def places(body: problems.Body, fem) -> np.ndarray:
    """For each node of ours the number of its first unknown."""
    dimension = body.points.shape[1]
    there = fem.basic_dof_nodes()[:, ::dimension].T
    scale = 1e-7 * np.abs(body.points).max()
    ours = np.lexsort(np.round(body.points / scale).T)
    theirs = np.lexsort(np.round(there / scale).T)
    if np.abs(body.points[ours] - there[theirs]).max() > scale:
        raise RuntimeError("nodes of GetFEM are not those of the problem")
    first = np.empty(len(ours), int)
    first[ours] = dimension * theirs
    return first


def solve(folder: Path) -> None:
    import getfem as gf

    problem = problems.Problem.read(folder / "problem.npz")
    dimension = problem.dimension
    gf.util_trace_level(0)
    gf.util_warning_level(0)
    meshes = [mesh_of(gf, body) for body in problem.bodies]
    begin = time.perf_counter()
    model = gf.Model("real")
    plane = dimension == 2
    element, rule = ("FEM_PK(2,1)", "IM_TRIANGLE(6)") if plane else ("FEM_QK(3,1)", "IM_GAUSS_PARALLELEPIPED(3,3)")
    fems, rules, regions = [], [], []
    for number, (body, mesh) in enumerate(zip(problem.bodies, meshes)):
        fem = gf.MeshFem(mesh, dimension)
        fem.set_fem(gf.Fem(element))
        fems.append(fem)
        rules.append(gf.MeshIm(mesh, gf.Integ(rule)))
        regions.append({side: k for k, side in enumerate(body.sides, start=1)})
        model.add_fem_variable(f"u{number}", fem)
        first, shear = body.lame()
        model.add_initialized_data(f"first{number}", first)
        model.add_initialized_data(f"shear{number}", shear)
        model.add_isotropic_linearized_elasticity_brick(rules[-1], f"u{number}", f"first{number}", f"shear{number}")
    for place, (number, side, values) in enumerate(problem.fix):
        variable, region = f"u{number}", regions[number][side]
        if None not in values:
            model.add_initialized_data(f"moved{place}", values)
            model.add_Dirichlet_condition_with_simplification(variable, region, f"moved{place}")
        else:
            # the sides held in one direction are across it, and held at 0
            model.add_normal_Dirichlet_condition_with_multipliers(rules[number], variable, 1, region)
    for place, (number, side, force) in enumerate(problem.load):
        model.add_initialized_data(f"load{place}", force)
        model.add_source_term_brick(rules[number], f"u{number}", f"load{place}", regions[number][side])
    (slave, slave_side), (master, master_side) = problem.nonmortar, problem.mortar
    model.add_initialized_data("r", min(body.young for body in problem.bodies))
    multiplier = gf.MeshFem(meshes[slave], dimension if problem.friction else 1)
    multiplier.set_fem(gf.Fem(element if problem.homogeneous else "FEM_QK(3,0)"))
    where = regions[slave][slave_side]
    model.add_filtered_fem_variable("p", multiplier, where)
    law = []
    if problem.friction:
        model.add_initialized_data("friction", problem.friction)
        law = ["friction"]
    model.add_integral_contact_between_nonmatching_meshes_brick(
        rules[slave], f"u{slave}", f"u{master}", "p", "r", *law, where, regions[master][master_side], 1
    )
    search = ["lsearch", "simplest", "alpha min", 0.8]
    steps = int(model.solve("max_res", 1e-8, "max_iter", MOST, "lsolver", "mumps", *search)[0])
    seconds = time.perf_counter() - begin
    moved = []
    for number, (body, fem) in enumerate(zip(problem.bodies, fems)):
        unknowns = model.variable(f"u{number}")
        moved.append(unknowns[places(body, fem)[:, None] + np.arange(dimension)])
    # reactions: its forces inside the body, summed over the sides that hold it
    number, axes = problem.proof
    u = f"u{number}"
    form = f"(first{number}*Trace(Grad_{u})*Id({dimension})+2*shear{number}*Sym(Grad_{u})):Grad_Test_{u}"
    forces = gf.asm_generic(rules[number], 1, form, -1, model)
    start = model.interval_of_variable(u)[0]
    forces = forces[start : start + fems[number].nbdof()]
    first = places(problem.bodies[number], fems[number])
    reaction = [float(forces[first[nodes] + axis].sum()) for axis, nodes in zip(axes, problem.reacting())]
    in_python.tell(folder, moved, reaction, seconds, steps, steps < MOST)


if __name__ == "__main__":
    solve(Path(sys.argv[1]))
