"""The problems that dotyk and its peers are given: two elastic bodies each, the same nodes and cells for every program.

A problem is made here once, with numpy alone, and saved as one file of arrays; every program is fed from that file.

tunnel-1, tunnel-2   the tunnel of Janovsky and Prochazka (Apl. mat. 25, 1980): half a lining that floats in half a plate of
                     rock, a load on top. The right side is held in case 1; in case 2 it is free, and a part opens.
                     Triangles, plane strain, nodes of both circles coincide. Size: nodes of the contact, 39 to 1217.
blocks               a block pressed into a larger one, its top moved down, with friction sideways too. Hexahedra that do
                     not match. Size: displacement unknowns, 7k to 200k.
hertz                the same with a curved lower face (a paraboloid, radius 4): the contact grows from a point.
lining               tunnel-2 in space: extruded, hexahedra, loaded on half of its length, so that it is no plane problem.

A name with `-friction` behind it is the same with Coulomb's law, coefficient 0.3, all load in one step.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

# Corner nodes of each facet of a cell, seen from outside counterclockwise (in the plane: the body on the left). The
# order of the facets is that of Abaqus and CalculiX: S1, S2, ..
FACETS = {
    3: np.array([(0, 1), (1, 2), (2, 0)]),
    8: np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]),
}
FRICTION = 0.3


@dataclass
class Body:
    """Nodes (n, 2 or 3), cells (m, 3 or 8) in the order of VTK, and sides: facets as pairs (cell, number in the cell)."""

    name: str
    points: np.ndarray
    cells: np.ndarray
    young: float
    poisson: float
    sides: dict[str, np.ndarray] = field(default_factory=dict)

    def facets(self, side: str) -> np.ndarray:
        """Nodes of the facets of a side."""
        cell, number = self.sides[side].T
        return self.cells[cell[:, None], FACETS[self.cells.shape[1]][number]]

    def nodes(self, side: str) -> np.ndarray:
        return np.unique(self.facets(side))

    def lame(self) -> tuple[float, float]:
        """The first constant of Lame and the shear modulus."""
        young, poisson = self.young, self.poisson
        return young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))


@dataclass
class Problem:
    """Two bodies, what holds and loads them, and who touches whom.

    fix: (body, side, displacement of each component or None); load: (body, side, force per area).
    nonmortar, mortar: (body, side). proof: the body without load whose supports bear the whole contact force, and the
    components in which they do. length: the size of the contact. homogeneous: no gap anywhere, so that displacements are
    proportional to the load.
    """

    name: str
    size: str
    bodies: list[Body]
    fix: list[tuple[int, str, list[float | None]]]
    load: list[tuple[int, str, list[float]]]
    nonmortar: tuple[int, str]
    mortar: tuple[int, str]
    proof: tuple[int, list[int]]
    length: float
    friction: float = 0.0
    homogeneous: bool = True

    @property
    def dimension(self) -> int:
        return self.bodies[0].points.shape[1]

    @property
    def dofs(self) -> int:
        return sum(body.points.size for body in self.bodies)

    @property
    def offsets(self) -> list[int]:
        """Number of the first node of each body where both are numbered together."""
        return [0, len(self.bodies[0].points)]

    def reacting(self) -> list[np.ndarray]:
        """For each component of `proof` the nodes of its body that are held in it."""
        number, axes = self.proof
        body = self.bodies[number]
        sides = [
            [body.nodes(side) for of, side, values in self.fix if of == number and values[axis] is not None]
            for axis in axes
        ]
        return [np.unique(np.concatenate(nodes)) for nodes in sides]

    def save(self, path: Path) -> None:
        arrays: dict[str, np.ndarray] = {}
        bodies = []
        for number, body in enumerate(self.bodies):
            arrays[f"points{number}"], arrays[f"cells{number}"] = body.points, body.cells
            arrays |= {f"side{number}{side}": facets for side, facets in body.sides.items()}
            bodies.append([body.name, body.young, body.poisson, list(body.sides)])
        names = ("name", "size", "fix", "load", "nonmortar", "mortar", "proof", "length", "friction", "homogeneous")
        rest = {name: getattr(self, name) for name in names}
        np.savez(path, rest=json.dumps([bodies, rest]), **arrays)

    @staticmethod
    def read(path: Path) -> Problem:
        with np.load(path) as file:
            bodies, rest = json.loads(str(file["rest"]))
            made = []
            for number, (name, young, poisson, sides) in enumerate(bodies):
                facets = {side: file[f"side{number}{side}"] for side in sides}
                made.append(Body(name, file[f"points{number}"], file[f"cells{number}"], young, poisson, facets))
        return Problem(bodies=made, **rest)


def skin(cells: np.ndarray) -> np.ndarray:
    """The facets (cell, number) that belong to one cell alone."""
    numbers = FACETS[cells.shape[1]]
    facets = np.sort(cells[:, numbers].reshape(-1, numbers.shape[1]), axis=1)
    _, which, count = np.unique(facets, axis=0, return_inverse=True, return_counts=True)
    single = np.flatnonzero(count[which.ravel()] == 1)
    return np.stack([single // len(numbers), single % len(numbers)], axis=1)


def name_sides(body: Body, where: dict[str, np.ndarray]) -> None:
    """A side is all facets of the skin whose nodes are all in the given mask; the rest is the side `free`."""
    outer = skin(body.cells)
    nodes = body.cells[outer[:, :1], FACETS[body.cells.shape[1]][outer[:, 1]]]
    left = np.ones(len(outer), bool)
    for name, mask in where.items():
        on = mask[nodes].all(axis=1)
        if not on.any():
            raise ValueError(f"side {name} of {body.name} has no facets")
        body.sides[name] = outer[on]
        left &= ~on
    if left.any():
        body.sides["free"] = outer[left]


# ---------------------------------------------------------------------------------------------------------------------
# The tunnel

OUTER, INNER, HALF, LOAD = 15.0, 12.0, 40.0, 50.0
ROCK, LINING = (2000.0, 0.25), (2100000.0, 0.15)
NEAR = 1e-9


def circle(nodes: int) -> np.ndarray:
    """Points of the half circle from invert to crown, radius 1, exactly 0 on the axis."""
    angle = np.linspace(-math.pi / 2, math.pi / 2, nodes)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points[[0, -1], 0] = 0.0
    return points


def fan(inner: np.ndarray, outer: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Nodes on the straight lines from inner to outer points, line by line."""
    points = inner[:, None, :] * (1 - steps[None, :, None]) + outer[:, None, :] * steps[None, :, None]
    return points.reshape(-1, 2)


def lining_points(around: int) -> tuple[np.ndarray, int]:
    layers = max(4, round((around - 1) / math.pi * math.log(OUTER / INNER)))
    return fan(INNER * circle(around), OUTER * circle(around), np.linspace(0, 1, layers + 1)), layers


def rock_points(around: int) -> tuple[np.ndarray, int]:
    """Rays from the circle to the square; the nearest ray goes to each corner; layers grow by a constant ratio."""
    ray = circle(around)
    with np.errstate(divide="ignore"):
        outer = ray * np.minimum(HALF / ray[:, 0], HALF / np.abs(ray[:, 1]))[:, None]
    for sign in (-1, 1):
        outer[np.argmin(np.hypot(*(ray - [math.sqrt(0.5), sign * math.sqrt(0.5)]).T))] = [HALF, sign * HALF]
    for axis in (0, 1):
        near = np.abs(np.abs(outer[:, axis]) - HALF) < NEAR
        outer[near, axis] = np.sign(outer[near, axis]) * HALF
    reach = np.hypot(outer[:, 0], outer[:, 1]).mean()
    layers = max(3, round((around - 1) / math.pi * math.log(reach / OUTER)))
    ratio = (reach / OUTER) ** (1.0 / layers)
    steps = ratio ** np.arange(layers + 1) - 1
    steps /= steps[-1]
    return fan(OUTER * ray, outer, steps), layers


def quads(around: int, layers: int) -> np.ndarray:
    """Counterclockwise cells of a fan of points."""
    line, layer = np.meshgrid(np.arange(around - 1), np.arange(layers), indexing="ij")
    first = (line * (layers + 1) + layer).ravel()
    return np.stack([first, first + 1, first + layers + 2, first + layers + 1], axis=1)


def triangles(around: int, layers: int) -> np.ndarray:
    """Each quadrilateral divided in two, the diagonals in turns."""
    cell = quads(around, layers)
    even = (np.add.outer(np.arange(around - 1), np.arange(layers)) % 2 == 0).ravel()[:, None]
    first = np.where(even, cell[:, [0, 1, 2]], cell[:, [0, 1, 3]])
    second = np.where(even, cell[:, [0, 2, 3]], cell[:, [1, 2, 3]])
    return np.stack([first, second], axis=1).reshape(-1, 3)


def tunnel(name: str, size: str, friction: float) -> Problem:
    around = int(size)
    case = int(name.split("-")[1])
    points, layers = rock_points(around)
    rock = Body("rock", points, triangles(around, layers), *ROCK)
    hole = np.zeros(len(points), bool)
    hole[:: layers + 1] = True
    x, y = points.T
    name_sides(rock, {"hole": hole, "axis": x == 0, "bottom": y == -HALF, "top": y == HALF, "right": x == HALF})
    points, layers = lining_points(around)
    lining = Body("lining", points, triangles(around, layers), *LINING)
    outer = np.zeros(len(points), bool)
    outer[layers :: layers + 1] = True
    name_sides(lining, {"outer": outer, "axis": points[:, 0] == 0})
    fix: list = [(0, "axis", [0.0, None]), (0, "bottom", [None, 0.0]), (1, "axis", [0.0, None])]
    if case == 1:
        fix.append((0, "right", [0.0, None]))
    load = [(0, "top", [0.0, -LOAD])]
    return Problem(name, size, [rock, lining], fix, load, (0, "hole"), (1, "outer"), (1, [0]), OUTER, friction)


def extruded(points: np.ndarray, cells: np.ndarray, length: float, layers: int) -> tuple[np.ndarray, np.ndarray]:
    """Quadrilaterals of the plane as hexahedra along z."""
    z = np.linspace(0.0, length, layers + 1)
    solid = np.concatenate([np.column_stack([points, np.full(len(points), height)]) for height in z])
    base = np.arange(layers)[:, None, None] * len(points) + cells
    return solid, np.concatenate([base, base + len(points)], axis=2).reshape(-1, 8)


# Nodes around and layers along by the number of displacement unknowns.
LINING_SIZES = {"7k": (29, 4), "20k": (41, 6), "60k": (61, 10), "200k": (91, 14)}


def lining(name: str, size: str, friction: float) -> Problem:
    around, along = LINING_SIZES[size]
    length = 20.0
    bodies = []
    for body, material, made in (("rock", ROCK, rock_points(around)), ("lining", LINING, lining_points(around))):
        points, cells = extruded(made[0], quads(around, made[1]), length, along)
        bodies.append(Body(body, points, cells, *material))
    rock, ring = bodies
    x, y, z = rock.points.T
    ends = {"first": z == 0, "last": z == length}
    where = {"hole": np.hypot(x, y) < OUTER + NEAR, "axis": x == 0, "bottom": y == -HALF}
    name_sides(rock, where | {"loaded": (y == HALF) & (z <= length / 2)} | ends)
    x, y, z = ring.points.T
    ends = {"first": z == 0, "last": z == length}
    name_sides(ring, {"outer": np.hypot(x, y) > OUTER - NEAR, "axis": x == 0} | ends)
    fix: list = [(0, "bottom", [None, 0.0, None])]
    for body in (0, 1):
        fix.append((body, "axis", [0.0, None, None]))
        fix += [(body, end, [None, None, 0.0]) for end in ("first", "last")]
    load = [(0, "loaded", [0.0, -LOAD, 0.0])]
    return Problem(name, size, bodies, fix, load, (0, "hole"), (1, "outer"), (1, [0]), OUTER, friction)


# ---------------------------------------------------------------------------------------------------------------------
# Two blocks in space

# Cells of the lower block over half of its width, and of the upper block over its whole width.
BLOCK_SIZES = {"2k": (4, 6), "7k": (6, 9), "20k": (9, 13), "60k": (13, 20), "200k": (20, 31)}
BLOCK, PRESS, SHEAR, RADIUS = (1e4, 0.3), 0.01, 0.002, 4.0


def box(number: tuple[int, int, int], low: tuple, high: tuple) -> tuple[np.ndarray, np.ndarray]:
    axes = [np.linspace(low[k], high[k], number[k] + 1) for k in range(3)]
    z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    k, j, i = (a.ravel() for a in np.meshgrid(*(np.arange(n) for n in reversed(number)), indexing="ij"))

    def node(a: int, b: int, c: int) -> np.ndarray:
        return ((k + c) * (number[1] + 1) + j + b) * (number[0] + 1) + i + a

    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    return points, np.stack([node(*corner) for corner in corners], axis=1)


def blocks(name: str, size: str, friction: float) -> Problem:
    below, above = BLOCK_SIZES[size]
    lower = Body("lower", *box((2 * below, 2 * below, below), (0, 0, 0), (2, 2, 1)), *BLOCK)
    upper = Body("upper", *box((above, above, above), (0.5, 0.5, 1), (1.5, 1.5, 2)), *BLOCK)
    z = lower.points[:, 2]
    name_sides(lower, {"bottom": z < NEAR, "top": z > 1 - NEAR})
    z = upper.points[:, 2]
    name_sides(upper, {"bottom": z < 1 + NEAR, "top": z > 2 - NEAR})
    if name == "hertz":
        square = ((upper.points[:, :2] - 1) ** 2).sum(axis=1)
        upper.points[:, 2] += (2 - upper.points[:, 2]) * square / (2 * RADIUS)
    # a plane face touches over the whole width, a curved one in the end over half of it
    plane = name == "blocks"
    moved = [SHEAR if friction else 0.0, 0.0, -PRESS]
    fix: list = [(0, "bottom", [0.0, 0.0, 0.0]), (1, "top", moved)]
    length = 1.0 if plane else 0.5
    return Problem(name, size, [lower, upper], fix, [], (1, "bottom"), (0, "top"), (1, [0, 2]), length, friction, plane)


# ---------------------------------------------------------------------------------------------------------------------

PLANE_SIZES = ["39", "77", "153", "305", "609", "1217"]
SPACE_SIZES = ["7k", "20k", "60k", "200k"]
MAKERS = {"tunnel-1": tunnel, "tunnel-2": tunnel, "blocks": blocks, "hertz": blocks, "lining": lining}
TITLES = {
    "tunnel-1": "Tunnel in the plane, right side held",
    "tunnel-2": "Tunnel in the plane, right side free",
    "blocks": "Two blocks that do not match",
    "hertz": "Curved block on a block",
    "lining": "Lining in rock, in space",
}
# Every problem with its sizes. The curved block is pressed without friction only.
PROBLEMS = {
    plain + behind: PLANE_SIZES if plain.startswith("tunnel") else SPACE_SIZES
    for plain in MAKERS
    for behind in ("", "-friction")
    if plain + behind != "hertz-friction"
}


def title(name: str) -> str:
    plain = name.removesuffix("-friction")
    return TITLES[plain] + (f", friction {FRICTION}" if plain != name else "")


def make(name: str, size: str) -> Problem:
    plain = name.removesuffix("-friction")
    problem = MAKERS[plain](plain, size, FRICTION if plain != name else 0.0)
    problem.name = name
    return problem
