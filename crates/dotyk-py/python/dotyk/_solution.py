"""Solutions: every key of ``summary.json`` as an attribute, and the arrays behind it."""

from __future__ import annotations

import io
import json
import math
import os
import pickle
from collections.abc import Iterator, Mapping
from html import escape
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar, overload

from dotyk import _dotyk
from dotyk._errors import InputError, UnknownName
from dotyk._mesh import _VTK, Mesh, _frozen
from dotyk._vtu import arrays_of
from dotyk._words import Writer, friend, keywords, path_of, written

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

T = TypeVar("T")

#: Keys whose null is none, and not a number that is not there.
_NONE = frozenset({"name", "length", "force", "stress", "energy", "at", "max_pressure_at", "failed_step", "overlap"})


def unknown(name: object, known: list[str], what: str) -> UnknownName:
    """The error of a name that a mapping does not have."""
    near = _dotyk.nearest(str(name), known) if known else None
    hint = f": did you mean `{near}`?" if near else ""
    return UnknownName(f"there is no {what} `{name}`{hint}; known: {', '.join(known) or 'none'}")


class Named(Mapping[str, T], Generic[T]):
    """Things by name, in the order of the case.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> s.contacts["sol"]
    Traceback (most recent call last):
    dotyk._errors.UnknownName: there is no contact `sol`: did you mean `sole`?; known: sole
    """

    def __init__(self, what: str, items: dict[str, T]) -> None:
        self._what, self._items = what, items

    def __getitem__(self, name: str) -> T:
        if name not in self._items:
            raise unknown(name, list(self._items), self._what)
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        return f"<{', '.join(self._items) or 'none'}>"


class Fixed(list[Any]):
    """A list that never changes."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise AttributeError("a solution never changes")

    append = extend = insert = remove = pop = clear = sort = reverse = _refuse
    __setitem__ = __delitem__ = __iadd__ = __imul__ = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return Fixed, (list(self),)


def _fixed(value: Any) -> Any:
    return Fixed(value) if type(value) is list else value


class _Frozen:
    """Attributes of a table that never change."""

    def __init__(self, table: dict[str, Any]) -> None:
        for key, value in table.items():
            object.__setattr__(self, key, _fixed(value))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a solution never changes")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a solution never changes")


class Figure(NamedTuple):
    """One figure of the certificate; it holds where ``relative`` is at most ``limit``.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> s.certificate["imbalance_force"].limit
    1e-10
    """

    value: float
    relative: float
    limit: float

    @property
    def holds(self) -> bool:
        """Whether it is within its limit.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> all(figure.holds for figure in s.certificate.values())
        True
        """
        return self.relative <= self.limit


class ProbeValue(float):
    """A number that was read, with ``name``, ``quantity``, ``unit`` and ``at``; of a line ``points``, ``length``, ``smallest`` and ``largest``.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().probe("rise", "punch.displacement.y", at=[2, 2]).solve()
    >>> s.probes["rise"] < 0, s.probes["rise"].unit
    (True, 'm')
    """

    name: str
    quantity: str
    value: float
    unit: str | None
    at: list[float] | None
    #: Of a line: number of values, length and range.
    points: int
    length: float
    smallest: float
    largest: float

    @classmethod
    def _of(cls, table: dict[str, Any]) -> ProbeValue:
        value = table.get("value")
        probe = cls(math.nan if value is None else value)
        for key, own in {"unit": None, "at": None, **table, "value": float(probe)}.items():
            setattr(probe, key, own)
        return probe


class Line(NamedTuple):
    """Values along a line: distance (n,), points (n, 3), values (n,).

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> line = s.probe("block.stress.yy", along="block.top")
    >>> line.points.shape, round(float(line.s[-1]), 9)
    ((41, 3), 4.0)
    """

    s: Array
    points: Array
    values: Array


class _Arrays:
    """Arrays of a body or contact, fetched when they are asked for first."""

    def __init__(self, fetch: Any) -> None:
        self._fetch = fetch
        self._arrays: dict[str, Any] | None = None

    def __call__(self) -> dict[str, Any]:
        if self._arrays is None:
            self._arrays = {
                key: _frozen(value) if hasattr(value, "flags") else value for key, value in self._fetch().items()
            }
        return self._arrays


class ContactSolution(_Frozen):
    """One contact: its row of ``summary.json`` and the columns of ``contact.csv``.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> sole = s.contacts["sole"]
    >>> sole.closed, sole.open, [round(force) for force in sole.resultant][1]
    (11, 0, 1000000)
    """

    name: str
    #: "BODY.SIDE" that carries the multipliers.
    nonmortar: str
    #: "BODY.SIDE" opposite, or "obstacle".
    mortar: str
    #: Force ON the nonmortar body.
    resultant: list[float]
    closed: int
    open: int
    length: float
    max_pressure: float
    max_pressure_at: list[float] | None
    max_penetration: float
    imbalance: float
    dissipated_work: float
    #: In space: of the contact forces about the origin.
    moment: list[float]

    def __init__(self, table: dict[str, Any], arrays: _Arrays, solution: Solution) -> None:
        super().__init__(table)
        object.__setattr__(self, "_arrays", arrays)
        object.__setattr__(self, "_solution", solution)

    def _array(self, key: str) -> Any:
        return self._arrays()[key]  # type: ignore[attr-defined]

    @property
    def node(self) -> npt.NDArray[np.int64]:
        """Numbers of the nodes in their body (n,).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> sole.node[:3].tolist()
        [0, 1, 2]
        """
        return self._array("node")  # type: ignore[no-any-return]

    @property
    def points(self) -> Array:
        """Undeformed positions (n, 2 or 3).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> sole.points[:2].tolist()
        [[1.5, 1.0], [1.6, 1.0]]
        """
        return self._array("points")  # type: ignore[no-any-return]

    @property
    def normal(self) -> Array:
        """Outward unit normals of the nonmortar side (n, 2 or 3).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> sole.normal[0].tolist()
        [0.0, -1.0]
        """
        return self._array("normal")  # type: ignore[no-any-return]

    @property
    def weight(self) -> Array:
        """The area that a node stands for (n,).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> round(float(sole.weight.sum()), 9)
        1.0
        """
        return self._array("weight")  # type: ignore[no-any-return]

    @property
    def gap(self) -> Array:
        """Gap after deformation (n,), NaN where nothing is opposite.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> bool(abs(sole.gap).max() < 1e-15)
        True
        """
        return self._array("gap")  # type: ignore[no-any-return]

    @property
    def pressure(self) -> Array:
        """Contact pressure (n,), positive in compression.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> bool(sole.pressure.min() > 0), round(float(sole.pressure @ sole.weight))
        (True, 1000000)
        """
        return self._array("pressure")  # type: ignore[no-any-return]

    @property
    def shear(self) -> Array:
        """Shear traction ON the nonmortar body: (n,) in the plane, (n, 3) in space.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> bool((abs(sole.shear) <= 0.2 * sole.pressure * (1 + 1e-9)).all())
        True
        """
        return self._array("shear")  # type: ignore[no-any-return]

    @property
    def slip(self) -> Array:
        """Tangential displacement relative to the other side: (n,) in the plane, (n, 3) in space.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> bool((abs(sole.slip[sole.status == "stick"]) < 1e-12).all())
        True
        """
        return self._array("slip")  # type: ignore[no-any-return]

    @property
    def status(self) -> npt.NDArray[np.str_]:
        """``open``, ``closed``, ``stick``, ``slip``, ``tied`` or ``fixed`` (n,).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> sorted(set(sole.status.tolist()))
        ['slip', 'stick']
        """
        import numpy as np

        return _frozen(np.array(self._array("status"), dtype=str))  # type: ignore[no-any-return]

    def to_pandas(self) -> Any:
        """A table of pandas with the columns of ``contact.csv`` and the rows of this step.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> sole = s.contacts["sole"]
        >>> table = sole.to_pandas()
        >>> table.shape, list(table.columns[:4])
        ((11, 18), ['step', 'contact', 'node', 'x'])
        """
        pandas = friend("pandas", "to_pandas()")
        text: str = self._solution._run.contact_csv()  # type: ignore[attr-defined]
        # names stay words, whatever they look like
        words = {"contact": str, "status": str, "nonmortar": str, "mortar": str}
        missing = {head: ["NaN"] for head in text.split("\n", 1)[0].split(",") if head not in words}
        table = pandas.read_csv(io.StringIO(text), dtype=words, keep_default_na=False, na_values=missing)
        for head in words:
            # what a spreadsheet would take for a formula stands behind an apostrophe
            table[head] = table[head].str.replace(r"^'(?=[=+@\t\r-])", "", regex=True)
        own = (table["contact"] == self.name) & (table["step"] == self._solution._step + 1)  # type: ignore[attr-defined]
        return table[own].reset_index(drop=True)

    def __reduce__(self) -> tuple[Any, ...]:
        return _part, (self._solution, "contacts", self.name)  # type: ignore[attr-defined]

    def __repr__(self) -> str:
        return f"<contact {self.name}: {self.closed} closed, {self.open} open, max pressure {self.max_pressure:.4g}>"


class BodySolution(_Frozen):
    """One body: its row of ``summary.json`` and the fields at its nodes.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> punch = s.bodies["punch"]
    >>> punch.nodes, punch.dofs, round(punch.reaction[1])
    (121, 242, 0)
    """

    name: str
    nodes: int
    cells: int
    dofs: int
    floating_modes: int
    #: Force of its supports ON the body.
    reaction: list[float]
    max_displacement: float
    max_von_mises: float
    max_von_mises_at: list[float]
    #: Where the largest stress is singular: what makes it so; else ``None``.
    max_von_mises_place: str | None
    #: The largest one away from such places.
    max_von_mises_away: float
    max_von_mises_away_at: list[float]
    strain_energy: float
    #: Where a body of the model has a strength: the area, in space volume, where the utilisation exceeds 1.
    overstressed_area: float
    max_utilisation: float
    max_utilisation_at: list[float]
    max_utilisation_place: str | None
    #: Where a material of the body yields: the area, in space volume, of what has a plastic strain.
    plastic_area: float
    #: The points of its couples, where it has some.
    couples: list[dict[str, Any]]
    #: The rigid motion that is nearest to its displacements.
    rigid: dict[str, Any]

    def __init__(self, table: dict[str, Any], arrays: _Arrays, mesh: Any, vtu: Any) -> None:
        super().__init__(table)
        object.__setattr__(self, "_arrays", arrays)
        object.__setattr__(self, "_mesh", mesh)
        object.__setattr__(self, "_vtu", vtu)

    def _array(self, key: str) -> Any:
        arrays = self._arrays()  # type: ignore[attr-defined]
        if key not in arrays:
            lacks = "a `strength`" if key == "utilisation" else "a `strength` and `plastic`"
            raise InputError(f"body `{self.name}` has no {key}: give its material {lacks}")
        return arrays[key]

    @property
    def points(self) -> Array:
        """Undeformed positions of the nodes (n, 2 or 3).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> punch.points[0].tolist()
        [1.5, 1.0]
        """
        return self._array("points")  # type: ignore[no-any-return]

    @property
    def displacement(self) -> Array:
        """Displacements of the nodes (n, 2 or 3).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> punch.displacement.shape, bool((punch.displacement[:, 1] < 0).all())
        ((121, 2), True)
        """
        return self._array("displacement")  # type: ignore[no-any-return]

    @property
    def stress(self) -> Array:
        """Stresses at the nodes (n, 6): xx yy zz xy yz xz, tension positive.

        They jump between materials: a node there has those of the material with the largest von Mises stress. A VTU file has all.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> punch.stress.shape, bool(punch.stress[:, 1].max() < 0)
        ((121, 6), True)
        """
        return self._array("stress")  # type: ignore[no-any-return]

    @property
    def strain(self) -> Array:
        """Strains at the nodes (n, 6), tensor components; between materials those of the material that `stress` tells of.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> punch.strain.shape
        (121, 6)
        """
        return self._array("strain")  # type: ignore[no-any-return]

    @property
    def principal_stress(self) -> Array:
        """Principal stresses at the nodes (n, 3), largest first; between materials those of the material that `stress` tells of.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> first, _, third = punch.principal_stress.T
        >>> bool((first >= third).all())
        True
        """
        return self._array("principal_stress")  # type: ignore[no-any-return]

    @property
    def von_mises(self) -> Array:
        """Von Mises stress at the nodes (n,); between materials the largest.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> bool(punch.von_mises.max() == punch.max_von_mises)
        True
        """
        return self._array("von_mises")  # type: ignore[no-any-return]

    @property
    def utilisation(self) -> Array:
        """Utilisation of the strength at the nodes (n,), 1 is failure; between materials the largest.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> block = m.body("block", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e3, poisson=0, strength={"yield": 10})
        >>> s = block.fix("bottom", x=0, y=0).load("top", pressure=5) and m.solve()
        >>> float(s.bodies["block"].utilisation.max().round(6))
        0.5
        """
        return self._array("utilisation")  # type: ignore[no-any-return]

    @property
    def plastic_strain(self) -> Array:
        """Plastic strain at the nodes, where a material of the body yields (n, 6): xx yy zz xy yz xz, tensor components.

        >>> import dotyk
        >>> m = dotyk.Model("axisymmetric")
        >>> mesh = dotyk.rectangle([0, 0], [1, 2], cells=[2, 4], cell="quad8")
        >>> bar = m.body("bar", mesh, young=200, poisson=0.3, strength={"yield": 1}, plastic=True, hardening=10)
        >>> s = bar.fix("bottom", y=0).load("top", traction=[0, 1.5]) and m.solve()
        >>> [float(round(strain, 6)) for strain in s.bodies["bar"].plastic_strain[0, :3]]
        [-0.025, 0.05, -0.025]
        """
        return self._array("plastic_strain")  # type: ignore[no-any-return]

    @property
    def equivalent_plastic_strain(self) -> Array:
        """Equivalent plastic strain at the nodes, where a material of the body yields (n,): the sum of sqrt(2/3 de:de) over all steps.

        >>> import dotyk
        >>> m = dotyk.Model("axisymmetric")
        >>> mesh = dotyk.rectangle([0, 0], [1, 2], cells=[2, 4], cell="quad8")
        >>> bar = m.body("bar", mesh, young=200, poisson=0.3, strength={"yield": 1}, plastic=True, hardening=10)
        >>> s = bar.fix("bottom", y=0).load("top", traction=[0, 1.5]) and m.solve()
        >>> float(s.bodies["bar"].equivalent_plastic_strain.max().round(6))
        0.05
        """
        return self._array("equivalent_plastic_strain")  # type: ignore[no-any-return]

    @property
    def yielded(self) -> Array:
        """Part of the cells around each node that has yielded in this step, where a material of the body yields (n,), in [0, 1].

        >>> import dotyk
        >>> m = dotyk.Model("axisymmetric")
        >>> mesh = dotyk.rectangle([0, 0], [1, 2], cells=[2, 4], cell="quad8")
        >>> bar = m.body("bar", mesh, young=200, poisson=0.3, strength={"yield": 1}, plastic=True, hardening=10)
        >>> s = bar.fix("bottom", y=0).load("top", traction=[0, 0.5]) and m.solve()
        >>> float(s.bodies["bar"].yielded.max())
        0.0
        """
        return self._array("yielded")  # type: ignore[no-any-return]

    @property
    def cell_data(self) -> dict[str, Array]:
        """Results of cells by name, in the order of the mesh: `yielded`, where a material of the body yields, is the share of the cell's
        points that have yielded in this step. Files and exports have them as arrays of cells.

        >>> import dotyk
        >>> m = dotyk.Model("axisymmetric")
        >>> mesh = dotyk.rectangle([0, 0], [1, 2], cells=[2, 4], cell="quad8")
        >>> bar = m.body("bar", mesh, young=200, poisson=0.3, strength={"yield": 1}, plastic=True, hardening=10)
        >>> s = bar.fix("bottom", y=0).load("top", traction=[0, 1.5]) and m.solve()
        >>> s.bodies["bar"].cell_data["yielded"].tolist()
        [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
        """
        return {name: _frozen(values) for name, values in self._array("cells").items()}

    @property
    def reactions(self) -> Array:
        """Forces of supports and springs ON the nodes (n, 2 or 3).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> block = s.bodies["block"]
        >>> round(block.reactions[:, 1].sum())
        1000000
        """
        return self._array("reaction")  # type: ignore[no-any-return]

    @property
    def contact_force(self) -> Array:
        """Forces of contacts and couples ON the nodes (n, 2 or 3).

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> round(punch.contact_force[:, 1].sum())
        1000000
        """
        return self._array("contact_force")  # type: ignore[no-any-return]

    @property
    def mesh(self) -> Mesh:
        """Its mesh.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> punch.mesh
        <dotyk.Mesh: 121 nodes, 100 quad4, sides bottom, left, right, top>
        """
        return Mesh._of(self._mesh())  # type: ignore[attr-defined]

    def _fields(self) -> dict[str, Any]:
        """The point arrays of the VTU file at the nodes: between materials, where the file has several points, those of `stress`."""
        fields = arrays_of(self._vtu())  # type: ignore[attr-defined]
        own = self._arrays()  # type: ignore[attr-defined]
        count = len(own["points"])

        def nodal(name: str, values: Any) -> Any:
            same = name in own and own[name].shape[1:] == values.shape[1:]
            return own[name] if same else values[:count]

        return {name: nodal(name, values) for name, values in fields.items()}

    def to_meshio(self) -> Any:
        """A ``meshio.Mesh`` with the fields, and the sides as ``cell_sets``. Needs meshio.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> sorted(punch.to_meshio().cell_sets)
        ['bottom', 'left', 'right', 'top']
        """
        import numpy as np

        mesh = self.mesh.to_meshio()
        mesh.point_data.update(self._fields())
        counts = [len(block.data) for block in mesh.cells]
        for name, values in self.cell_data.items():
            # facets of the sides stand behind the cells
            facets = np.full((sum(counts) - len(values), *values.shape[1:]), np.nan)
            mesh.cell_data[name] = np.split(np.concatenate([values, facets]), np.cumsum(counts)[:-1])
        return mesh

    def to_pyvista(self) -> Any:
        """A ``pyvista.UnstructuredGrid`` with the fields. Needs pyvista.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> punch = s.bodies["punch"]
        >>> grid = punch.to_pyvista()
        >>> grid.n_points, grid.point_data["stress"].shape
        (121, (121, 6))
        """
        import numpy as np

        pyvista = friend("pyvista", "to_pyvista()")
        cells, kinds = [], []
        for kind, _, nodes in self._mesh().blocks():  # type: ignore[attr-defined]
            counts = np.full((len(nodes), 1), nodes.shape[1], dtype=np.int64)
            cells.append(np.hstack([counts, nodes.astype(np.int64)]).ravel())
            kinds.append(np.full(len(nodes), _VTK[kind], dtype=np.uint8))
        points = self.points
        if points.shape[1] == 2:
            points = np.column_stack([points, np.zeros(len(points))])
        grid = pyvista.UnstructuredGrid(np.concatenate(cells), np.concatenate(kinds), np.array(points))
        for name, values in self._fields().items():
            grid.point_data[name] = values
        for name, values in self.cell_data.items():
            grid.cell_data[name] = values
        return grid

    def __reduce__(self) -> tuple[Any, ...]:
        return _part, (self._solution, "bodies", self.name)  # type: ignore[attr-defined]

    def __repr__(self) -> str:
        return f"<body {self.name}: {self.nodes} nodes, max displacement {self.max_displacement:.4g}, max von Mises {self.max_von_mises:.4g}>"


class Solution(_Frozen):
    """The answer of a load step with its certificate; every key of ``summary.json`` is an attribute.

    >>> import dotyk
    >>> m = dotyk.Model("plane-strain")
    >>> block = m.body("block", dotyk.rectangle([0, 0], [2, 1], cells=[2, 1]), young=1e9, poisson=0)
    >>> _ = block.fix("bottom", y=0).fix(point=[0, 0], x=0).load("top", pressure="1e6*t")
    >>> s = m.solve(steps=[0.5, 1.0])
    >>> [step.time for step in s.steps]
    [0.5, 1.0]
    >>> round(s.probe("block.stress.yy", at=[1, 0.5]))
    -1000000
    >>> s.bodies["block"].displacement.shape
    (6, 2)
    """

    #: Version of the keys.
    schema: int
    case: str
    version: str
    units: dict[str, str]
    parameters: dict[str, float]
    #: Number of the load step from 1, and its name where it has one.
    step: int
    name: str | None
    time: float
    #: With ``zero_displacements``: the time of the step at whose end displacements are zero.
    displacements_from: float
    converged: bool
    solver: str
    iterations: int
    #: Where a material yields: increments of the plastic strain.
    increments: int
    #: Where Coulomb's law was solved as a fixed point: the factor by which each round reduces the error.
    contraction: float
    dofs: int
    contact_unknowns: int
    #: Pieces of all bodies; a whole one counts as one.
    subdomains: int
    #: Where a body is divided: rigid motions of its pieces, and solutions with all pieces so far.
    coarse_size: int
    glue_iterations: int
    threads: int
    peak_memory_bytes: int
    seconds: dict[str, float]
    certificate: Named[Figure]
    contacts: Named[ContactSolution]
    bodies: Named[BodySolution]
    probes: Named[ProbeValue]
    #: Bedded sides by "BODY.SIDE": area, closed_area, mean_pressure, max_pressure, max_gap, resultant ...
    beds: Named[Any]
    bars: Named[Any]
    springs: Named[Any]
    bolts: Named[Any]
    sections: Named[Any]
    warnings: list[str]
    #: The step that has no answer, with its number, time and reason; ``None`` where all have one.
    failed_step: dict[str, Any] | None
    #: Where two deformed bodies stand in each other, their ``bodies`` and the place ``at``; ``None`` where nothing is unexplained.
    overlap: dict[str, Any] | None
    #: The solutions of all load steps, at least one; the last is this one.
    steps: tuple[Solution, ...]

    _run: Any
    _step: int

    @classmethod
    def _of(cls, run: Any) -> Solution:
        summary = _numbers(json.loads(run.summary()))
        top = {key: value for key, value in summary.items() if key != "steps"}
        tables = summary.get("steps") or [top]
        if len(tables) < run.steps:
            tables = [*tables, top]
        common = {key: summary[key] for key in ("schema", "units", "parameters") if key in summary}
        earlier = [cls({**common, **table}, run, k) for k, table in enumerate(tables[:-1])]
        last = cls({**tables[-1], **top}, run, len(tables) - 1)
        steps = (*earlier, last)
        for step in earlier:
            object.__setattr__(step, "steps", (step,))
        object.__setattr__(last, "steps", steps)
        return last

    def __init__(self, table: dict[str, Any], run: Any, step: int) -> None:
        super().__init__({"units": {}, "parameters": {}, "step": 1, "name": None, "failed_step": None, "overlap": None, **table})
        own: dict[str, Any] = {"_run": run, "_step": step}
        figures = {name: Figure(**figure) for name, figure in table["certificate"].items()}
        own["certificate"] = Named("figure", figures)
        own["contacts"] = Named(
            "contact",
            {
                entry["name"]: ContactSolution(entry, _Arrays(_fetch(run, "contact", step, k)), self)
                for k, entry in enumerate(table["contacts"])
            },
        )
        own["bodies"] = Named(
            "body",
            {
                entry["name"]: BodySolution(
                    entry, _Arrays(_fetch(run, "body", step, k)), _fetch(run, "mesh", step, k), _fetch(run, "vtu", step, k)
                )
                for k, entry in enumerate(table["bodies"])
            },
        )
        own["probes"] = Named("probe", {p["name"]: ProbeValue._of(p) for p in table["probes"]})
        members = ((key, plural) for key, plural, _ in _dotyk.members())
        for word, kind in (("bed", "beds"), *members, ("section", "sections")):
            own[kind] = Named(word, {entry["name"]: _Frozen(entry) for entry in table.get(kind, [])})
        for key, value in own.items():
            object.__setattr__(self, key, value)
        for body in own["bodies"].values():
            object.__setattr__(body, "_solution", self)

    @keywords
    @overload
    def probe(self, *, expression: str) -> float: ...

    @overload
    def probe(
        self,
        quantity: str,
        at: Any = None,
        along: None = None,
        reduce: str | None = None,
        mean_of_neighbours: bool | None = None,
        minus_rigid: str | None = None,
        center: Any = None,
        factor: float | str | None = None,
    ) -> float: ...

    @overload
    def probe(
        self,
        quantity: str,
        at: None = None,
        *,
        along: Any,
        reduce: str,
        minus_rigid: str | None = None,
        center: Any = None,
        factor: float | str | None = None,
    ) -> float: ...

    @overload
    def probe(
        self,
        quantity: str,
        at: None = None,
        *,
        along: Any,
        reduce: None = None,
        minus_rigid: str | None = None,
        center: Any = None,
        factor: float | str | None = None,
    ) -> Line: ...

    def probe(
        self,
        quantity: str | None = None,
        at: Any = None,
        along: Any = None,
        reduce: str | None = None,
        mean_of_neighbours: bool | None = None,
        minus_rigid: str | None = None,
        center: Any = None,
        factor: float | str | None = None,
        expression: str | None = None,
    ) -> float | Line:
        """Reads a quantity, as a probe of a case file does: a number, or along a line distance, points and values.

        An ``expression`` is one of the probes of the model.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().probe("rise", "punch.displacement.y", at=[2, 2]).solve()
        >>> round(s.probe("punch.stress.yy", at=[2, 2]), -3)
        -1000000.0
        >>> s.probe(expression="-1e3*rise") == -1e3 * s.probes["rise"]
        True
        """
        table = {key: value for key, value in locals().items() if key != "self"}
        text = Writer(2).entries(table, "the probe")
        read = self._run.probe(self._step, text)
        return Line(*map(_frozen, read)) if isinstance(read, tuple) else float(read)

    def report(self, path: str | os.PathLike[str] | None = None) -> str:
        """The report as one HTML page; written into a file where ``path`` is given.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> s.report()[:15]
        '<!DOCTYPE html>'
        """
        page: str = self._run.report()
        if path is not None:
            written(path, page)
        return page

    def write(self, folder: str | os.PathLike[str]) -> list[str]:
        """Writes all files that the command writes into a folder; returns their paths.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> import os, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     sorted(os.path.basename(path) for path in s.write(folder))[:2]
        ['block.vtu', 'case.pvd']
        """
        return [str(path) for path in self._run.write(path_of(folder, "folder"))]

    def plot(self, field: str = "von_mises", scale: float | None = None) -> Any:
        """Deformed bodies coloured by a field, and pressure and gap of every contact, as a figure of matplotlib.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> figure = s.plot()
        >>> len(figure.axes)
        4
        """
        from dotyk._plot import plot

        return plot(self, field, scale)

    def to_pyvista(self) -> Any:
        """A ``pyvista.MultiBlock`` of the bodies by name. Needs pyvista.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> s.to_pyvista().keys()
        ['block', 'punch']
        """
        pyvista = friend("pyvista", "to_pyvista()")
        return pyvista.MultiBlock({name: body.to_pyvista() for name, body in self.bodies.items()})

    @property
    def history(self) -> list[tuple[int, float, int]]:
        """Iterations of the contact solver: number, relative violation, contacts with a force.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> number, violation, contacts = s.history[-1]
        >>> violation < 1e-8, contacts
        (True, 22)
        """
        return list(self._run.history(self._step))

    def __repr__(self) -> str:
        verdict = "converged" if self.converged else "NOT CONVERGED"
        worst = max(self.certificate.items(), key=lambda item: item[1].relative / item[1].limit)
        return (
            f"<dotyk.Solution {self.case}: {verdict}, {self.dofs} dofs, {self.contact_unknowns} contact unknowns, "
            f"{self.solver}, {self.iterations} iterations; worst figure {worst[0]} {worst[1].relative:.1e} "
            f"of {worst[1].limit:.0e}>"
        )

    def _repr_html_(self) -> str:
        verdict = "converged" if self.converged else "<b>not converged</b>"
        rows = "".join(
            f"<tr><td>{name.replace('_', ' ')}</td><td>{figure.relative:.1e}</td><td>{figure.limit:.0e}</td>"
            f"<td>{'holds' if figure.holds else '<b>violated</b>'}</td></tr>"
            for name, figure in self.certificate.items()
        )
        table = f"<table><tr><th>certificate</th><th>relative</th><th>limit</th><th></th></tr>{rows}</table>"
        of = f"{self.dofs} dofs, {self.contact_unknowns} contact unknowns, {self.iterations} iterations of {escape(self.solver)}"
        head = f"<p>{escape(self.case)}: {verdict}, {of}</p>"
        figures = "".join(figure for _, figure in self._run.figures())
        return f"<div>{head}{table}{figures}</div>"

    def __reduce__(self) -> tuple[Any, ...]:
        whole = self.steps[-1] is self and len(self.steps) == self._run.steps
        return _restored, (_kept(self._run), None if whole else self._step)


def _part(solution: Solution, kind: str, name: str) -> Any:
    return getattr(solution, kind)[name]


def _fetch(run: Any, method: str, *place: int) -> Any:
    return lambda: getattr(run, method)(*place)


def _kept(run: Any) -> Any:
    """A run as a pickle keeps it."""
    if not isinstance(run, _dotyk.Run):
        return run
    text, (name, folder), parameters, meshes, (callables, dimension), files = run.arguments()
    functions = []
    for function, where, called, components in callables:
        try:
            functions.append((pickle.dumps(function), where, called, components))
        except Exception as error:
            return _Numbers(run, f"{where}: the function {called} cannot be pickled ({error})")
    case = (text, (name, str(folder)), parameters, [Mesh._of(mesh) for mesh in meshes], (functions, dimension), files)
    return _Kept(case, run)


def _restored(run: Any, step: int | None) -> Solution:
    solution = Solution._of(run)
    return solution if step is None else solution.steps[step]


class _Function:
    """A function out of a pickle, which is looked up when it is called first."""

    def __init__(self, pickled: bytes, name: str) -> None:
        self._pickled, self.__name__ = pickled, name
        self._function: Any = None

    def __call__(self, points: Any, t: float) -> Any:
        if self._function is None:
            try:
                self._function = pickle.loads(self._pickled)
            except Exception as error:
                raise InputError(f"the function {self.__name__} of a pickled model is not found here: {error}") from None
        return self._function(points, t)


class _Kept:
    """A run out of a pickle: its numbers at once, the rest by its case and its solutions, which are read when they are asked for."""

    _run: Any = None
    _summary: str

    def __init__(self, case: tuple[Any, ...], run: Any) -> None:
        self._case, self._solutions = case, run.kept()
        self._summary, self.steps = run.summary(), run.steps

    def summary(self) -> str:
        return self._summary

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if self._run is None:
            text, place, parameters, meshes, (callables, dimension), files = self._case
            functions = [(_Function(pickled, name), where, name, size) for pickled, where, name, size in callables]
            natives = [mesh._native for mesh in meshes]
            case = _dotyk.Case.of_text(text, place, parameters, natives, (functions, dimension), files)
            self._run = case.restored(self._solutions)
        return getattr(self._run, name)

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_run"}


class _Numbers:
    """What is left of a run whose model cannot be pickled: numbers, meshes and pictures."""

    def __init__(self, run: Any, reason: str) -> None:
        self._reason = reason
        summary = json.loads(run.summary())
        tables = summary.get("steps") or [summary]
        tables = tables if len(tables) >= run.steps else [*tables, summary]
        self._kept = {
            "summary": run.summary(),
            "report": run.report(),
            "figures": run.figures(),
            "contact_csv": run.contact_csv(),
            "steps": run.steps,
            "bodies": [[run.body(k, i) for i in range(len(t["bodies"]))] for k, t in enumerate(tables)],
            "meshes": [[Mesh._of(run.mesh(k, i)) for i in range(len(t["bodies"]))] for k, t in enumerate(tables)],
            "vtus": [[run.vtu(k, i) for i in range(len(t["bodies"]))] for k, t in enumerate(tables)],
            "contacts": [[run.contact(k, i) for i in range(len(t["contacts"]))] for k, t in enumerate(tables)],
            "history": [run.history(k) for k in range(len(tables))],
        }

    @property
    def steps(self) -> int:
        return int(self._kept["steps"])

    def summary(self) -> str:
        return str(self._kept["summary"])

    def report(self) -> str:
        return str(self._kept["report"])

    def contact_csv(self) -> str:
        return str(self._kept["contact_csv"])

    def figures(self) -> list[tuple[str, str]]:
        return list(self._kept["figures"])

    def body(self, step: int, index: int) -> Any:
        return self._kept["bodies"][step][index]

    def contact(self, step: int, index: int) -> Any:
        return self._kept["contacts"][step][index]

    def mesh(self, step: int, index: int) -> Any:
        return self._kept["meshes"][step][index]._native

    def vtu(self, step: int, index: int) -> str:
        return str(self._kept["vtus"][step][index])

    def history(self, step: int) -> Any:
        return self._kept["history"][step]

    def write(self, folder: str) -> list[str]:
        raise self._lacks("files are written")

    def probe(self, step: int, text: str) -> Any:
        raise self._lacks("probes are read")

    def _lacks(self, what: str) -> InputError:
        return InputError(
            f"this solution came out of a pickle without its model, because of {self._reason}: {what} before it is pickled, or with "
            "a function at the top of a module"
        )


def _numbers(value: Any, key: str = "") -> Any:
    """Null as NaN, where a number is meant."""
    if value is None:
        return None if key in _NONE else math.nan
    if isinstance(value, dict):
        return {own: _numbers(entry, own) for own, entry in value.items()}
    if isinstance(value, list):
        return [_numbers(entry) for entry in value]
    return value


