"""NGSolve (pip ngsolve) on a problem: ContactBoundary with a penalty, Newton's method, direct factorisation.

Its documentation has contact as an energy or an integrator of the gap over pairs of boundaries that it finds, so the law
is the user's: here the penalty K g of the closed part. Chosen here:
* the penalty as a virtual work (AddIntegrator), six times as fast as the same as an energy (AddEnergy);
* K = 100 E / L, E of the softer body, L the size of the contact, as for CalculiX, whose answers it then repeats;
* `sparsecholesky`, faster here than `umfpack`, on the symmetric form;
* a body that floats has no contact in the first step, where all gaps are zero: its first matrix gets a small mass.
Friction: its documentation has none; one would write the law oneself. Not attempted.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import in_python
import problems
from in_python import answer, prepare  # noqa: F401, part of what a peer is

NAME = "NGSolve"
PENALTY = True
SOLVE_WORDS = "spaces, forms and Newton steps, without the mesh"
# K times the size of the contact over the modulus of the softer body.
FACTOR = 100.0
SETTINGS = "ContactBoundary, penalty as a virtual work, the same K, sparsecholesky"
MOST = 60


def version(tools: dict[str, str]) -> str:
    return in_python.version(tools["python"], "import ngsolve; print(ngsolve.__version__)")


def excluded(problem: problems.Problem) -> str:
    return "no friction in its documentation: one would write the law oneself" if problem.friction else ""


def command(folder: Path, tools: dict[str, str], threads: int) -> list[str]:
    return [tools["python"], __file__, str(folder)]


def mesh_of(problem: problems.Problem):
    """Both bodies in one mesh; sides are called BODY-SIDE."""
    from netgen.meshing import Element1D, Element2D, Element3D, FaceDescriptor, Mesh, MeshPoint, Pnt

    import ngsolve as ng

    plane = problem.dimension == 2
    mesh = Mesh(dim=problem.dimension)
    nodes = []
    for body in problem.bodies:
        padded = np.column_stack([body.points, np.zeros((len(body.points), 3 - problem.dimension))])
        nodes.append([mesh.Add(MeshPoint(Pnt(*point))) for point in padded.tolist()])
    sides = [(number, side) for number, body in enumerate(problem.bodies) for side in body.sides]
    if plane:
        for number in (1, 2):
            mesh.Add(FaceDescriptor(surfnr=number, domin=number, bc=number))
    else:
        for index, (number, _) in enumerate(sides, start=1):
            mesh.Add(FaceDescriptor(surfnr=index, domin=number + 1, bc=index))
    for number, body in enumerate(problem.bodies):
        kind = Element2D if plane else Element3D
        for cell in body.cells.tolist():
            mesh.Add(kind(number + 1, [nodes[number][node] for node in cell]))
        mesh.SetMaterial(number + 1, body.name)
    for index, (number, side) in enumerate(sides, start=1):
        for facet in problem.bodies[number].facets(side).tolist():
            corners = [nodes[number][node] for node in facet]
            mesh.Add(Element1D(corners, index=index) if plane else Element2D(index, corners))
        mesh.SetBCName(index - 1, f"{problem.bodies[number].name}-{side}")
    return ng.Mesh(mesh)


def solve(folder: Path) -> None:
    import ngsolve as ng

    problem = problems.Problem.read(folder / "problem.npz")
    dimension = problem.dimension
    ng.ngsglobals.msg_level = 0
    ng.SetNumThreads(1)
    mesh = mesh_of(problem)
    begin = time.perf_counter()

    def name(number: int, side: str) -> str:
        return f"{problem.bodies[number].name}-{side}"

    def strain(w):
        return ng.Sym(ng.Grad(w))

    def elastic():
        """Virtual work of both bodies."""
        form = ng.BilinearForm(space, symmetric=True)
        form += (
            2 * shear * ng.InnerProduct(strain(u), strain(v)) * ng.dx
            + first * ng.Trace(strain(u)) * ng.Trace(strain(v)) * ng.dx
        )
        return form

    held = {f"dirichlet{axis}": [] for axis in "xyz"[:dimension]}
    for number, side, values in problem.fix:
        for axis, value in zip("xyz", values):
            if value is not None:
                held[f"dirichlet{axis}"].append(name(number, side))
    space = ng.VectorH1(mesh, order=1, **{axis: "|".join(sides) for axis, sides in held.items()})
    u, v = space.TnT()
    first = mesh.MaterialCF({body.name: body.lame()[0] for body in problem.bodies})
    shear = mesh.MaterialCF({body.name: body.lame()[1] for body in problem.bodies})
    form, inside = elastic(), elastic()
    # a body that floats has no contact yet where all gaps are zero
    mass = ng.Parameter(1e-3 if problem.load else 0.0)
    form += mass * u * v * ng.dx
    load = ng.LinearForm(space)
    for number, side, force in problem.load:
        load += ng.CF(tuple(force)) * v * ng.ds(name(number, side))
    load.Assemble()
    penalty = FACTOR * min(body.young for body in problem.bodies) / problem.length
    contact = ng.ContactBoundary(mesh.Boundaries(name(*problem.nonmortar)), mesh.Boundaries(name(*problem.mortar)))
    normal = ng.specialcf.normal(dimension)
    gap = (contact.gap + u.Other() - u) * normal
    contact.AddIntegrator(ng.IfPos(-gap, penalty * gap * ((v.Other() - v) * normal), 0.0 * gap))
    moved = ng.GridFunction(space)
    undeformed = ng.GridFunction(space)
    # pairs farther apart than the bodies move cannot touch
    contact.Update(undeformed, form, intorder=4, maxdist=1.0 if problem.homogeneous else 2 * problems.PRESS)
    count = mesh.nv
    values_of = moved.vec.FV().NumPy()
    for number, side, values in problem.fix:
        nodes = problem.offsets[number] + problem.bodies[number].nodes(side)
        for axis, value in enumerate(values):
            if value is not None:
                values_of[axis * count + nodes] = value
    residual, step = moved.vec.CreateVector(), moved.vec.CreateVector()
    start, size, steps = 0.0, 1.0, 0
    while size >= 1e-9 * start and steps < MOST:
        steps += 1
        form.Apply(moved.vec, residual)
        residual -= load.vec
        form.AssembleLinearization(moved.vec)
        step.data = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky") * residual
        moved.vec.data -= step
        mass.Set(0.0)
        size = ng.sqrt(abs(ng.InnerProduct(step, residual)))
        start = start or size
    seconds = time.perf_counter() - begin
    inside.Apply(moved.vec, residual)
    forces = residual.FV().NumPy().reshape(dimension, count)
    number, axes = problem.proof
    held = problem.reacting()
    reaction = [float(forces[axis, problem.offsets[number] + nodes].sum()) for axis, nodes in zip(axes, held)]
    all_moved = values_of.reshape(dimension, count).T
    in_python.tell(folder, np.split(all_moved, [problem.offsets[1]]), reaction, seconds, steps, steps < MOST)


if __name__ == "__main__":
    solve(Path(sys.argv[1]))
