"""The ruler: contact forces and pressures from the displacements that a program gives, by the same code for all.

The forces inside the nonmortar body, less its loads, are what acts on its nodes from outside: on those of the contact it
is the contact force, on those that are free it must vanish. A program that solved another problem, or this one badly,
shows there. Where a node of the contact is held in a direction, the force of the support hides that of the contact, and
that direction drops out of force and normal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import problems

GAUSS = 1 / np.sqrt(3)
CORNERS = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)])
CHUNK = 20_000


def gradients(points: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Of cells (m, nodes, d): weight (m) and gradient of the shape functions (m, nodes, d) at each quadrature point."""
    if points.shape[1] == 3:
        reference = [np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])]
        size = 0.5
    else:
        reference = []
        for at in CORNERS * GAUSS:
            one = 1 + CORNERS * at
            others = [one[:, [1, 2]].prod(1), one[:, [0, 2]].prod(1), one[:, [0, 1]].prod(1)]
            reference.append(CORNERS * np.stack(others, axis=1) / 8)
        size = 1.0
    found = []
    for derivative in reference:
        jacobian = np.einsum("ka,mkb->mab", derivative, points)
        gradient = np.einsum("ka,mia->mki", derivative, np.linalg.inv(jacobian))
        found.append((size * np.linalg.det(jacobian), gradient))
    return found


def internal_forces(body: problems.Body, moved: np.ndarray) -> np.ndarray:
    """Forces (n, d) that hold the body in its displacements, plane strain in the plane."""
    first, shear = body.lame()
    force = np.zeros_like(moved)
    dimension = moved.shape[1]
    for begin in range(0, len(body.cells), CHUNK):
        cells = body.cells[begin : begin + CHUNK]
        for weight, gradient in gradients(body.points[cells]):
            slope = np.einsum("mki,mkj->mij", moved[cells], gradient)
            stress = shear * (slope + slope.transpose(0, 2, 1))
            stress += first * np.trace(slope, axis1=1, axis2=2)[:, None, None] * np.eye(dimension)
            part = np.einsum("m,mij,mkj->mki", weight, stress, gradient)
            for axis in range(dimension):
                force[:, axis] += np.bincount(cells.ravel(), part[:, :, axis].ravel(), len(force))
    return force


def areas(body: problems.Body, side: str) -> np.ndarray:
    """Outward normal times area of each node's share of a side (n, d): the integral of its shape function times n."""
    facets = body.facets(side)
    corners = body.points[facets]
    shares = np.zeros_like(corners)
    if facets.shape[1] == 2:
        along = corners[:, 1] - corners[:, 0]
        shares[:] = 0.5 * np.stack([along[:, 1], -along[:, 0]], axis=1)[:, None]
    else:
        flat = CORNERS[:4, :2]
        for at in flat * GAUSS:
            one = 1 + flat * at
            shape = one.prod(1) / 4
            s, t = flat[:, 0] * one[:, 1] / 4, flat[:, 1] * one[:, 0] / 4
            normal = np.cross(np.einsum("k,mki->mi", s, corners), np.einsum("k,mki->mi", t, corners))
            shares += shape[None, :, None] * normal[:, None]
    found = np.zeros_like(body.points)
    np.add.at(found, facets, shares)
    return found


def load_forces(problem: problems.Problem, number: int) -> np.ndarray:
    body = problem.bodies[number]
    force = np.zeros_like(body.points)
    for of, side, traction in problem.load:
        if of == number:
            # the sides that bear loads are plane
            force += np.linalg.norm(areas(body, side), axis=1)[:, None] * np.array(traction)
    return force


@dataclass
class Measured:
    """What all programs are compared by.

    force: integral of the pressure. shear: sum of the sizes of tangential nodal forces. pressure: the largest; pressures:
    at each node of the nonmortar side, in the order of its nodes. proof: the contact force on the nonmortar body in the
    components that supports bear alone; hidden: how much of it supports at the contact may hide. imbalance: largest force
    at a free node.
    """

    force: float
    shear: float
    pressure: float
    pressures: np.ndarray
    weights: np.ndarray
    proof: np.ndarray
    hidden: np.ndarray
    imbalance: float


def measure(problem: problems.Problem, moved: list[np.ndarray]) -> Measured:
    number, side = problem.nonmortar
    body = problem.bodies[number]
    outside = internal_forces(body, moved[number]) - load_forces(problem, number)
    held = np.zeros(outside.shape, bool)
    for of, name, values in problem.fix:
        if of == number:
            nodes = body.nodes(name)
            for axis, value in enumerate(values):
                held[nodes, axis] |= value is not None
    nodes = body.nodes(side)
    normal = areas(body, side)[nodes]
    across = np.where(held[nodes], np.abs(normal), 0.0)
    normal[held[nodes]] = 0.0
    weight = np.linalg.norm(normal, axis=1)
    normal /= weight[:, None]
    contact = np.where(held[nodes], 0.0, outside[nodes])
    pushed = -(contact * normal).sum(axis=1)
    sideways = np.linalg.norm(contact + pushed[:, None] * normal, axis=1)
    free = ~held
    free[nodes] = False
    pressures = pushed / weight
    # what a held direction may bear: the pressure on the area across it, and friction
    hidden = np.abs(pressures)[:, None] * (across + problem.friction * weight[:, None] * held[nodes])
    axes = problem.proof[1]
    return Measured(
        force=float(pushed.sum()),
        shear=float(sideways.sum()),
        pressure=float(pressures.max()),
        pressures=pressures,
        weights=weight,
        proof=contact.sum(axis=0)[axes],
        hidden=hidden.sum(axis=0)[axes],
        imbalance=float(np.abs(outside[free]).max()),
    )


def distance(one: Measured, other: Measured) -> float:
    """Root mean square difference of two pressures, relative to that of the second."""
    apart = (one.weights * (one.pressures - other.pressures) ** 2).sum()
    return float(np.sqrt(apart / (other.weights * other.pressures**2).sum()))
