"""Models built call by call: every key of a case file has its call or keyword."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from dotyk import _dotyk
from dotyk._errors import ArgumentError, InputError
from dotyk._mesh import Mesh, of_any
from dotyk._solve import Check, Study, solved, studied
from dotyk._words import (
    Writer,
    keywords,
    keywords_of,
    number_of,
    parameters_of,
    path_of,
    taken,
    text_of,
    threads_of,
    unmasked,
)

if TYPE_CHECKING:
    import numpy.typing as npt

    from dotyk._dual import Dual, Problem
    from dotyk._solution import Solution

    #: What may be a number, an expression, or a function of points and time.
    Number = float | str | Callable[..., Any]
    Vector = Sequence[Number] | npt.NDArray[Any] | Callable[..., Any]
    Place = Sequence[float] | npt.NDArray[Any]
    Table = Mapping[str, Any]
    # of a Problem; Any, so that a function of a Dual, which is one, may stand here
    Solver = Callable[[Any], tuple[Any, Any]]

#: Parts whose names no other part may have.
_PARTS = ("body", "contact", "section", *(key for key, *_ in _dotyk.members()))
#: Lists of a case.
_LISTS = (*_PARTS, "step", "probe")
#: Keys of a material that a body may have itself.
_MATERIAL = ("young", "poisson", "thickness", "strength", "plastic", "hardening", "dilation", "unload")
#: What of a body others need to know when they are checked.
_BASE = ("name", "mesh", "material", "points", "couple", "initial_stress", "pore_pressure", "surface")


class Body:
    """A body of a model; made by :meth:`Model.body`. Every call returns the body, so that calls can be chained.

    >>> import dotyk.examples
    >>> m = dotyk.examples.punch()
    >>> m.bodies["punch"].load("top", traction=[1e3, 0])
    <dotyk.Body punch: 121 nodes, 100 quad4, sides bottom, left, right, top>
    """

    def __init__(self, model: Model, table: dict[str, Any]) -> None:
        self._model = model
        self._table = table

    @property
    def name(self) -> str:
        """Its name.

        >>> import dotyk.examples
        >>> m = dotyk.examples.punch()
        >>> m.bodies["block"].name
        'block'
        """
        return str(self._table["name"])

    @property
    def mesh(self) -> Mesh:
        """Its mesh.

        >>> import dotyk.examples
        >>> m = dotyk.examples.punch()
        >>> m.bodies["block"].mesh
        <dotyk.Mesh: 451 nodes, 400 quad4, sides bottom, left, right, top>
        """
        mesh = self._table["mesh"]
        if isinstance(mesh, Mesh):
            return mesh
        writer = Writer(self._model.dimension)
        text = f"mesh = {writer.value(mesh, 'the mesh')}\n"
        native = _dotyk.Mesh.of_text(text, self._model._folder, self._model.dimension == 3, writer.meshes)
        return Mesh._of(native)

    def _add(self, kind: str, entry: dict[str, Any]) -> Body:
        entry = taken({key: value for key, value in entry.items() if value is not None})
        base = {key: value for key, value in self._table.items() if key in _BASE}
        listed = [*base.get(kind, []), entry] if kind in _BASE else [entry]
        self._model._try({"body": [{**base, kind: listed}]})
        self._table.setdefault(kind, []).append(entry)
        return self

    def _set(self, key: str, value: Any) -> Body:
        value = taken(value, what=f"`{key}`")
        base = {known: own for known, own in self._table.items() if known in _BASE}
        self._model._try({"body": [{**base, key: value}]})
        self._table[key] = value
        return self

    @keywords
    def fix(
        self,
        side: str | Sequence[str] | None = None,
        x: Number | None = None,
        y: Number | None = None,
        z: Number | None = None,
        normal: Number | None = None,
        rotation: Any = None,
        point: Place | str | None = None,
        active: Table | None = None,
    ) -> Body:
        """Holds a side, or the node nearest to a point: each component zero, prescribed by a number, or by an expression.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> block = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> block.fix("bottom", x=0, y=0).fix(point=[0, 1], x="1e-3*t")
        <dotyk.Body block: 10 nodes, 4 quad4, sides bottom, left, right, top>
        """
        return self._add("fix", {k: v for k, v in locals().items() if k != "self"})

    @keywords
    def load(
        self,
        side: str | Sequence[str] | None = None,
        traction: Vector | None = None,
        pressure: Number | None = None,
        force: Vector | None = None,
        in_situ: Number | None = None,
        moment: Any = None,
        point: Place | str | None = None,
        active: Table | None = None,
    ) -> Body:
        """Loads a side (``traction``, ``pressure``, a resultant ``force``, ``in_situ``) or a point (``force``).

        A function gets all its points (n, 2 or 3) and t, and gives (n,), of a vector (n, 2 or 3).

        >>> import dotyk, numpy as np
        >>> m = dotyk.Model("plane-strain")
        >>> block = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> _ = block.load("top", traction=[0, "-1e6*t"])
        >>> _ = block.load("right", pressure=lambda points, t: 1e3 * points[:, 1] * t)
        """
        return self._add("load", {k: v for k, v in locals().items() if k != "self"})

    @keywords
    def spring(
        self,
        side: str | Sequence[str] | None = None,
        normal: Number | None = None,
        tangential: Number | None = None,
        compression_only: bool | None = None,
        x: Number | None = None,
        y: Number | None = None,
        z: Number | None = None,
        point: Place | str | None = None,
        active: Table | None = None,
    ) -> Body:
        """Beds a side on springs (force per area and length) or a point (force per length).

        A stiffness may be an expression in ``x``, ``y`` and ``z``, or a function, that is the same at all times.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> beam = m.body("beam", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1e9, poisson=0)
        >>> _ = beam.spring("bottom", normal="1e7*(1 + x)", compression_only=True).fix(point=[0, 0], x=0)
        >>> bed = beam.load("top", pressure="1e3*(1 + x)") and m.solve().beds["beam.bottom"]
        >>> round(bed.mean_pressure, 6), round(bed.closed_area, 6), round(bed.resultant[1], 6)
        (3000.0, 4.0, 12000.0)
        """
        return self._add("spring", {k: v for k, v in locals().items() if k != "self"})

    @keywords
    def couple(self, side: str | Sequence[str], point: str, kind: str) -> Body:
        """Makes a side move with a named point (``kind="rigid"``), or gives the point its mean motion (``"average"``).

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> beam = m.body("beam", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3, points={"jack": [4, 0.5]})
        >>> _ = beam.couple("right", point="jack", kind="rigid")
        """
        return self._add("couple", {k: v for k, v in locals().items() if k != "self"})

    @keywords
    def cyclic(
        self,
        from_: str | Sequence[str],
        to: str | Sequence[str],
        sectors: int | str,
        point: Vector | None = None,
        axis: Sequence[float] | None = None,
    ) -> Body:
        """Makes the body one of equal sectors of a turn, with these two faces, about an axis (3D) or a point.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> disc = m.body("disc", dotyk.ring(1, 2, from_=0, to=30, cells=[4, 4]), young=1, poisson=0.3)
        >>> _ = disc.cyclic("start", "end", sectors=12)
        """
        given = {"from": from_, "to": to, "sectors": sectors, "point": point, "axis": axis}
        return self._set("cyclic", {key: value for key, value in given.items() if value is not None})

    @keywords
    def body_force(self, force: Vector) -> Body:
        """Force per volume, such as gravity.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> rock = m.body("rock", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> _ = rock.body_force([0, -27e3])
        """
        return self._set("body_force", force)

    @keywords
    def pore_pressure(
        self,
        pressure: Number | None = None,
        level: Number | None = None,
        weight: float | str | None = None,
        direction: Vector | None = None,
    ) -> Body:
        """The pressure of the water in the pores: a value, or that of water at rest below a ``level``.

        The initial stress is then that between the grains.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> rock = m.body("rock", dotyk.rectangle([0, -10], [4, 0], cells=[4, 10]), young=1, poisson=0.3)
        >>> _ = rock.pore_pressure(level="-2 - 0.1*x", weight=9.81e3)
        """
        below = {"level": level, "weight": weight, "direction": direction}
        below = {key: value for key, value in below.items() if value is not None}
        if (pressure is None) == (not below):
            raise ArgumentError("`pore_pressure` is a `pressure`, or a `level` with its `weight`")
        return self._set("pore_pressure", pressure if pressure is not None else below)

    @keywords_of("initial_stress")
    def initial_stress(self, **components: Any) -> Body:
        """The stress that is there before anything acts: components, or ``vertical`` with ``k0``. Tension is positive.

        The vertical is along y, in space along z, or along a ``direction``.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> rock = m.body("rock", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> _ = rock.initial_stress(vertical="-27e3*(80 - y)", k0=0.6)
        """
        return self._set("initial_stress", components)

    @keywords_of("initial_strain")
    def initial_strain(self, **components: Any) -> Body:
        """A strain without stress: ``thermal`` with ``expansion``, ``isotropic``, or components.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> ring = m.body("ring", dotyk.ring(1, 2, cells=[16, 2]), young=1, poisson=0.3)
        >>> _ = ring.initial_strain(thermal=20, expansion=1.2e-5)
        """
        return self._set("initial_strain", components)

    @keywords_of("surface")
    def surface(self, side: str, facets: Literal["facets"] | None = None, **surface: Any) -> Body:
        """The true surface behind a polygonal side: ``plane``, ``circle``, ``cylinder``, ``cone`` or ``sphere``; ``"facets"``
        where its facets are what it is, although the mesh knows what they stand for.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> ring = m.body("ring", dotyk.ring(1, 2, cells=[16, 2]), young=1, poisson=0.3)
        >>> _ = ring.surface("inner", circle={"center": [0, 0], "radius": 1})
        """
        if facets is not None and surface:
            raise TypeError('surface() takes one shape, or "facets"')
        shape = surface if facets is None else facets
        return self._set("surface", {**self._table.get("surface", {}), side: shape})

    @keywords
    def points(self, **points: Place) -> Body:
        """Named points for supports, loads, probes and couples.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> beam = m.body("beam", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> _ = beam.points(tip=[4, 0.5])
        """
        return self._set("points", {**self._table.get("points", {}), **points})

    def __repr__(self) -> str:
        mesh = self._table["mesh"]
        what = repr(mesh)[len("<dotyk.Mesh: ") : -1] if isinstance(mesh, Mesh) else "not meshed yet"
        return f"<dotyk.Body {self.name}: {what}>"


class _Solves:
    """The solves of a model that are going on; a copy of the model has none."""

    def __init__(self) -> None:
        # of a list, adding and taking are whole, whichever thread does it
        self._running: list[None] = []

    def __enter__(self) -> None:
        self._running.append(None)

    def __exit__(self, *_: object) -> None:
        self._running.pop()

    def __bool__(self) -> bool:
        return bool(self._running)

    def __reduce__(self) -> tuple[Any, ...]:
        return _Solves, ()


class Model:
    """Bodies, and what is between them.

    analysis:
        ``"plane-strain"``, ``"plane-stress"``, ``"axisymmetric"`` or ``"3d"``.
    parameters:
        Names for numbers, which every expression may use.
    drawing:
        Lines whose regions are bodies, as ``[drawing]`` of a case file.

    >>> import dotyk
    >>> m = dotyk.Model("plane-strain", title="Punch")
    >>> block = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[40, 10]), young=210e9, poisson=0.3)
    >>> punch = m.body("punch", dotyk.rectangle([1.5, 1], [2.5, 2], cells=[10, 10]), young=210e9, poisson=0.3)
    >>> _ = block.fix("bottom", x=0, y=0)
    >>> _ = punch.fix("left", x=0).fix("right", x=0).load("top", traction=[0, -1e6])
    >>> m.contact("sole", nonmortar="punch.bottom", mortar="block.top")
    <dotyk.Model Punch: plane-strain, bodies block, punch, contacts sole>
    >>> s = m.solve()
    >>> s.converged
    True
    >>> round(s.contacts["sole"].resultant[1])
    1000000
    """

    @keywords
    def __init__(
        self,
        analysis: str,
        title: str | None = None,
        source: str | None = None,
        units: Table | None = None,
        parameters: Table | None = None,
        drawing: Table | None = None,
    ) -> None:
        text_of(analysis, "analysis")
        parameters_of(parameters)
        head = {"title": title, "source": source, "analysis": analysis, "units": units}
        self._head: dict[str, Any] = {key: value for key, value in head.items() if value is not None}
        self._parameters: dict[str, Any] = taken(parameters or {})
        self._drawing = taken(drawing)
        self._lists: dict[str, list[dict[str, Any]]] = {key: [] for key in _LISTS}
        self._solver: dict[str, Any] = {}
        self._name, self._folder = "model", os.getcwd()
        self._solves = _Solves()
        # a head that no case can have is refused here, beside a body that is always right
        self._try({"body": [_ANY[self.dimension]]})

    @classmethod
    @keywords
    def from_case(cls, path: str | os.PathLike[str], parameters: Table | None = None) -> Model:
        """The model of a case file, to change and to solve.

        >>> import dotyk
        >>> dotyk.Model.from_case("no-such-case.toml")
        Traceback (most recent call last):
        dotyk._errors.InputError: no-such-case.toml: cannot read the file: there is no such file
        """
        file = path_of(path, "path")
        _dotyk.Case.of_file(file, parameters_of(parameters))
        if file.lower().endswith(".inp"):
            raise InputError(f"{file}: a deck can be run, not changed: `dotyk import` makes a case file of it")
        with open(file, encoding="utf-8") as stream:
            table = json.loads(_dotyk.to_json(stream.read(), file))
        model = cls.__new__(cls)
        model._head = {key: table[key] for key in ("title", "source", "analysis", "units") if key in table}
        model._parameters = {**table.get("parameters", {}), **(parameters or {})}
        model._drawing = table.get("drawing")
        model._lists = {key: list(table.get(key, [])) for key in _LISTS}
        model._solver = table.get("solver", {})
        model._folder = os.path.dirname(os.path.abspath(file))
        model._name = os.path.basename(file)
        model._solves = _Solves()
        model._head.setdefault("title", os.path.splitext(model._name)[0])
        return model

    @property
    def dimension(self) -> int:
        """2 in the plane and with axial symmetry, 3 in space.

        >>> import dotyk.examples
        >>> m = dotyk.examples.punch()
        >>> m.dimension, dotyk.examples.boxes().dimension
        (2, 3)
        """
        return dimension_of(self._head.get("analysis"))

    @property
    def bodies(self) -> Mapping[str, Body]:
        """The bodies by name.

        >>> import dotyk.examples
        >>> m = dotyk.examples.punch()
        >>> list(m.bodies)
        ['block', 'punch']
        """
        from dotyk._solution import Named

        return Named("body", {body["name"]: Body(self, body) for body in self._lists["body"]})

    @property
    def parameters(self) -> dict[str, Any]:
        """Names and values of parameters.

        >>> import dotyk
        >>> dotyk.Model("plane-strain", parameters={"E": 210e9}).parameters
        {'E': 210000000000.0}
        """
        return dict(self._parameters)

    @keywords
    def body(
        self,
        name: str,
        mesh: Any,
        young: float | str | None = None,
        poisson: float | str | None = None,
        thickness: float | str | None = None,
        strength: Table | None = None,
        plastic: bool | None = None,
        hardening: float | str | None = None,
        dilation: float | str | None = None,
        unload: Table | None = None,
        material: Table | Sequence[Table] | None = None,
        formulation: str | None = None,
        fix: Sequence[Table] | None = None,
        spring: Sequence[Table] | None = None,
        load: Sequence[Table] | None = None,
        couple: Sequence[Table] | None = None,
        cyclic: Table | None = None,
        body_force: Vector | None = None,
        initial_stress: Table | None = None,
        initial_strain: Table | None = None,
        pore_pressure: Number | Table | None = None,
        active: Table | None = None,
        surface: Table | None = None,
        points: Table | None = None,
    ) -> Body:
        """Adds a body: its mesh (a :class:`Mesh`, a ``meshio.Mesh``, or a table of a case file) and its material.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> m.body("rock", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=2e9, poisson=0.25)
        <dotyk.Body rock: 10 nodes, 4 quad4, sides bottom, left, right, top>
        >>> m.body("lining", dotyk.rectangle([0, 1], [4, 2], cells=[4, 1]), young=-1, poisson=0.25)
        Traceback (most recent call last):
        dotyk._errors.InputError: body `lining`, material: `young` must be positive
        """
        arguments = dict(locals())
        given = {key: value for key, value in arguments.items() if key not in ("self", *_MATERIAL)}
        text_of(name, "name")
        own = {key: arguments[key] for key in _MATERIAL}
        own = {key: value for key, value in own.items() if value is not None}
        if own and material is not None:
            raise InputError(f"body `{name}`: give `material` or {', '.join(f'`{key}`' for key in own)}, not both")
        table = taken({key: value for key, value in given.items() if value is not None and key != "mesh"})
        table["mesh"] = taken(of_any(mesh))
        table["material"] = taken(material if material is not None else own, what="`material`")
        for kind in ("fix", "spring", "load", "couple"):
            if not isinstance(table.get(kind, []), list):
                raise ArgumentError(f"`{kind}` is a list of tables")
        self._unused("body", name)
        self._try({"body": [table]})
        self._lists["body"].append(table)
        return Body(self, table)

    @keywords
    def contact(
        self,
        name: str,
        nonmortar: str | Sequence[str] | None = None,
        mortar: str | Sequence[str] | None = None,
        sides: Sequence[Any] | None = None,
        bodies: Literal["all"] | Sequence[str | Body] | None = None,
        obstacle: Table | None = None,
        reach: float | None = None,
        pairing: str | None = None,
        gap: Number | Table | None = None,
        friction: Number | Table | None = None,
        tied: bool | None = None,
        exclude: Sequence[Any] | None = None,
        friction_exclude: Sequence[Any] | None = None,
        gasket: Table | None = None,
        active: Table | None = None,
    ) -> Model:
        """Adds a contact between two sides, or between a side and a rigid obstacle; or, with ``bodies``, every contact that is
        found between these: bodies whose outer surfaces face each other within ``reach``.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> _ = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> m.contact("floor", nonmortar="block.bottom", obstacle={"gap": 0.0}, friction=0.3)
        <dotyk.Model: plane-strain, bodies block, contacts floor>
        >>> _ = m.body("lid", dotyk.rectangle([0, 1], [4, 2], cells=[6, 1]), young=1, poisson=0.3)
        >>> _ = m.contact("pile", bodies="all", friction=0.3)
        >>> list(m.check().contacts)
        ['floor', 'pile-block-lid']
        """
        if bodies is not None and not isinstance(bodies, str):
            bodies = [body.name if isinstance(body, Body) else body for body in bodies]
        return self._add("contact", locals())

    @keywords
    def section(
        self,
        name: str,
        body: str | None = None,
        sides: Sequence[Any] | None = None,
        stations: Any = None,
        capacity: Table | None = None,
        reinforcement: Sequence[Table] | None = None,
        bodies: Sequence[str | Body] | None = None,
        axis: Sequence[float] | None = None,
        places: int | None = None,
    ) -> Model:
        """Adds a section: N, V and M on cuts between two sides of a body, or of several bodies, by equilibrium; in space of bodies
        extruded along an axis, as means over their length or at some places along it.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> _ = m.body("ring", dotyk.ring(1, 1.2, cells=[32, 2]), young=1, poisson=0.3)
        >>> _ = m.section("hoop", body="ring", sides=["inner", "outer"], stations=8)
        >>> _ = m.body("shell", dotyk.ring(0.9, 1, cells=[30, 2]), young=1, poisson=0.3)
        >>> _ = m.section("both", bodies=["ring", "shell"], sides=["shell.inner", "ring.outer"], stations=8)
        >>> m = dotyk.Model("3d")
        >>> tube = dotyk.extrude(dotyk.ring(1, 1.2, from_=0, to=90, cells=[8, 2], cell="quad8"), height=3, layers=2)
        >>> tube = m.body("tube", tube, young=1, poisson=0.3).load("inner", pressure=1)
        >>> _ = tube.fix("start", y=0).fix("end", x=0).fix("first", z=0).fix("last", z=0)
        >>> s = m.section("hoop", body="tube", sides=["inner", "outer"], stations=2, places=3).solve()
        >>> [(station["along"], round(station["N"], 6)) for station in s.sections["hoop"].stations][::2]
        [(0.0, 1.0), (1.5, 1.0), (3.0, 1.0)]
        """
        body = body.name if isinstance(body, Body) else body
        if bodies is not None:
            bodies = [one.name if isinstance(one, Body) else one for one in bodies]
        return self._add("section", locals())

    @keywords
    def bar(
        self,
        name: str,
        from_: Any,
        to: Any,
        young: float | str,
        area: float | str,
        bodies: Sequence[str] | None = None,
        bond: str | None = None,
        prestress: Number | None = None,
        spacing: float | str | None = None,
        tension_only: bool | None = None,
        yield_: float | str | None = None,
        radius: float | str | None = None,
        active: Table | None = None,
        count: int | None = None,
        free_length: float | str | None = None,
        bond_length: float | str | None = None,
    ) -> Model:
        """Adds a bar: a bolt, an anchor or a tie between points or sides; ``bond`` is ``"ends"`` or ``"grouted"``.

        An anchor is grouted behind its ``free_length``, or over its ``bond_length``: two bars, NAME and NAME-bond. With axial
        symmetry ``count`` is the number of bars around the axis.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> _ = m.body("rock", dotyk.rectangle([0, 0], [4, 4], cells=[8, 8]), young=1e9, poisson=0.3)
        >>> _ = m.bar("bolt", from_=[1, 4], to=[1, 1], bodies=["rock"], young=210e9, area=5e-4, yield_=500e6, bond="grouted")
        """
        return self._add("bar", locals())

    @keywords
    def spring(
        self,
        name: str,
        from_: Any,
        to: Any,
        stiffness: float | str,
        bodies: Sequence[str] | None = None,
        acts: str | None = None,
        gap: float | str | None = None,
        spacing: float | str | None = None,
        radius: float | str | None = None,
        active: Table | None = None,
        count: int | None = None,
    ) -> Model:
        """Adds a spring between two points or sides; ``acts`` is ``"both"``, ``"tension"`` or ``"compression"``, with a ``gap``.

        Springs that hold a body, and have no other end, are :meth:`Body.spring`.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> _ = m.body("low", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1e9, poisson=0.3)
        >>> _ = m.body("up", dotyk.rectangle([0, 2], [4, 3], cells=[4, 1]), young=1e9, poisson=0.3)
        >>> _ = m.spring("buffer", from_=[2, 1], to=[2, 2], bodies=["low", "up"], stiffness=1e6, acts="compression", gap=0.01)
        """
        return self._add("spring", locals())

    @keywords
    def bolt(
        self,
        name: str,
        body: str | None = None,
        at: Any = None,
        axis: Place | None = None,
        from_: Any = None,
        to: Any = None,
        prestress: Number | None = None,
        tightened: Table | None = None,
        shortening: Number | None = None,
    ) -> Model:
        """Adds a bolt made of cells: its ``body`` is cut ``at`` a place across its ``axis``, and drawn together there.

        A mesh that is cut already has the two sides ``from_`` and ``to``. The step that tightens it has ``prestress``; then its
        shortening stays, or is ``shortening``.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> bar = m.body("bar", dotyk.rectangle([0, 0], [1, 4], cells=[2, 8]), young=1000, poisson=0)
        >>> _ = bar.fix("bottom", x=0, y=0).fix("top", y=0)
        >>> _ = m.bolt("stud", body="bar", at=[0.5, 2], axis=[0, 1], prestress=5)
        >>> stud = m.solve().bolts["stud"]
        >>> round(stud.force, 9), round(stud.shortening, 9)
        (5.0, 0.02)
        """
        return self._add("bolt", locals())

    @keywords
    def probe(
        self,
        name: str,
        quantity: str | None = None,
        at: Any = None,
        along: Any = None,
        reduce: str | None = None,
        mean_of_neighbours: bool | None = None,
        minus_rigid: str | None = None,
        center: Place | None = None,
        factor: Number | None = None,
        expression: str | None = None,
    ) -> Model:
        """Adds a probe, which every solution of this model reads: a quantity, or an expression of probes that were added before.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> _ = m.body("rock", dotyk.rectangle([0, 0], [4, 4], cells=[8, 8]), young=1e9, poisson=0.3)
        >>> _ = m.probe("settlement", "rock.displacement.y", at=[2, 4])
        >>> _ = m.probe("left side", "rock.displacement.y", at=[0, 4])
        >>> _ = m.probe("slope", expression="(settlement - 'left side')/2")
        """
        if expression is not None:
            text_of(expression, "expression")
        return self._add("probe", locals())

    @keywords
    def step(self, time: float, name: str | None = None, zero_displacements: bool | None = None) -> Model:
        """Adds a load step at a time, with a name that ``active`` may use. With ``zero_displacements`` the displacements of results count
        from the end of the step before.

        >>> import dotyk
        >>> _ = dotyk.Model("plane-strain").step(0.5, name="excavation").step(1.0, name="lining", zero_displacements=True)
        """
        steps = self._lists["step"]
        entry = {"name": name, "time": time, "zero_displacements": zero_displacements}
        self._try({"body": [_ANY[self.dimension]], "step": [*steps, entry]})
        steps.append(entry)
        return self

    def _add(self, kind: str, values: dict[str, Any]) -> Model:
        entry = taken({key: value for key, value in values.items() if key != "self" and value is not None})
        text_of(entry.get("name"), "name")
        self._unused(kind, entry["name"])
        # a probe may be of a bed
        keys = (*_BASE, "spring") if kind == "probe" else _BASE
        bodies = [{key: value for key, value in body.items() if key in keys} for body in self._lists["body"]]
        known = _PARTS[1:] if kind == "probe" else ()
        # of other probes an expression needs the names, and whether they have values along a line
        others = self._lists["probe"] if "expression" in entry else []
        others = [own if "along" in own else {"name": own["name"], "expression": "0"} for own in others]
        document = {"body": bodies, **{other: self._lists[other] for other in known}, kind: [*others, entry]}
        self._try(document)
        self._lists[kind].append(entry)
        return self

    def _unused(self, kind: str, name: str) -> None:
        """Refuses a name that another part has whose quantities are called by it."""
        for other in {kind, *_PARTS} if kind in _PARTS else {kind}:
            if any(own["name"] == name for own in self._lists[other]):
                parts = "two bodies" if kind == other == "body" else f"two {kind}s" if kind == other else f"a {other} and a {kind}"
                raise InputError(f"{parts} are named `{name}`")
        if kind == "body":
            _dotyk.check_file_names([*(own["name"] for own in self._lists[kind]), name])

    def _try(self, document: dict[str, Any]) -> None:
        """Lets the reader of case files look at what the model is to have more; steps may come later."""
        if self._solves:
            raise InputError("a model cannot be changed while it is solved")
        self._case(_without_active(document), {})

    def _document(self) -> dict[str, Any]:
        return {key: entries for key, entries in self._lists.items() if entries}

    def _case(self, document: Mapping[str, Any], solver: Table, parameters: Table | None = None) -> Any:
        writer = Writer(self.dimension)
        return _dotyk.Case.of_text(
            self._text(document, solver, writer),
            (self._name, self._folder),
            parameters_of(parameters),
            writer.meshes,
            (writer.functions, self.dimension),
        )

    def _text(self, document: Mapping[str, Any], solver: Table, writer: Writer) -> str:
        parts = [writer.entries(self._head, "the model")]
        if self._parameters:
            parts.append("[parameters]\n" + writer.entries(self._parameters, "parameters", names=True))
        if self._drawing is not None:
            parts.append("[drawing]\n" + writer.entries(self._drawing, "the drawing"))
        if solver:
            parts.append("[solver]\n" + writer.entries(solver, "the solver"))
        for kind, entries in document.items():
            for entry in entries:
                name = entry.get("name")
                place = f"{kind} `{name}`" if name is not None else f"a {kind}"
                parts.append(f"[[{kind}]]\n" + writer.entries(_file_mesh(entry), place))
        return "\n".join(parts)

    @keywords
    def solve(
        self,
        steps: Sequence[Any] | None = None,
        method: str | Solver | None = None,
        tolerance: float | None = None,
        max_iterations: int | None = None,
        rho: float | None = None,
        threads: int | None = None,
        callback: Callable[[Any], Any] | None = None,
        parameters: Table | None = None,
        progress: bool | None = None,
        bolt: Any = None,
        subdomains: int | str | None = None,
    ) -> Solution:
        """Solves all load steps; the solution is that of the last, with all of them in ``steps``.

        steps:
            Times, pairs (name, time), or tables with ``name`` and ``time``; else those of :meth:`step`, else one at t = 1.
        method:
            ``"auto"``, ``"newton"``, ``"mprgp"``, ``"gradient"``, ``"accelerated"``, ``"secant"``, ``"uzawa"``, or a function
            of a dual problem that gives λ and α; its answer is judged as all others.
        subdomains:
            Number of pieces into which all bodies together are divided, glued by forces: they need less memory, and the answer is
            the same to the tolerance. ``"auto"``: by size and memory.
        callback:
            Called with a :class:`Progress` at every stage, iteration and step. It may raise, but not change the model.

        Raises :class:`InputError` where there is no such model, :class:`NotConverged` with the last iterate where there is no
        answer.

        >>> import dotyk.examples
        >>> m = dotyk.examples.punch()
        >>> m.solve(method="mprgp", threads=1).solver
        'mprgp'
        """
        document = self._document()
        if steps is not None:
            if isinstance(steps, (str, Mapping)) or not hasattr(steps, "__iter__"):
                raise ArgumentError("`steps` is a list of times, of pairs (name, time) or of tables")
            unmasked(steps, "`steps`")
            listed = [_step(step) for step in steps]
            if not listed:
                raise InputError("`steps` is an empty list: leave it out for the steps of the model, or for one at t = 1")
            document = {**document, "step": listed}
        solver = dict(self._solver)
        if bolt is not None:
            solver |= {"method": method if isinstance(method, str) else solver.get("method"), "bolt": taken(bolt)}
        if subdomains is not None:
            solver |= {"subdomains": taken(subdomains)}
        case = self._case(document, solver, parameters)
        with self._solves:
            return solved(case, method, tolerance, max_iterations, rho, threads, callback, progress)

    def check(self) -> Check:
        """Looks at meshes, supports, loads, what floats and what holds it, and contacts; solves nothing.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain")
        >>> _ = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]), young=1, poisson=0.3)
        >>> m.check().bodies["block"].floating  # doctest: +ELLIPSIS
        ('...',)
        """
        return Check(self._case(self._document(), self._solver).check())

    @keywords
    def dual(self, t: float | None = None) -> Dual:
        """The contact problem of the step at a time, condensed onto the contact forces; see :class:`Dual`.

        >>> import dotyk.examples
        >>> m = dotyk.examples.punch()
        >>> m.dual()
        <dotyk.Dual: 22 contact forces, 1 rigid amplitudes>
        """
        from dotyk._dual import Dual

        case = self._case(self._document(), self._solver)
        with self._solves:
            return Dual(case.dual(number_of(t, "t")))

    @keywords
    def study(
        self,
        vary: Table,
        parameters: Table | None = None,
        threads: int | None = None,
        steps: Literal["last", "all"] = "last",
    ) -> Study:
        """Solves the model for all combinations of values of its parameters; rows tell the last load step, or all of them.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain", parameters={"q": 1.0})
        >>> block = m.body("block", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e3, poisson=0)
        >>> _ = block.fix("bottom", x=0, y=0).load("top", pressure="q")
        >>> study = m.probe("top", "block.displacement.y", at=[0.5, 1]).study(vary={"q": [1.0, 2.0]})
        >>> [round(u, 9) for u in study["top"].tolist()]
        [-0.001, -0.002]
        >>> list(m.step(0.5).step(1.0).study(vary={"q": [1.0, 2.0]}, steps="all"))
        ['q', 'step', 'time', 'top', 'converged', 'reason']
        """
        case = self._case(self._document(), self._solver, parameters)
        with self._solves:
            return studied(case, vary, parameters, threads_of(threads), steps)

    def __repr__(self) -> str:
        title = self._head.get("title")
        parts = [str(self._head.get("analysis"))]
        members = ((key, plural) for key, plural, _ in _dotyk.members())
        for kind, word in (("body", "bodies"), ("contact", "contacts"), *members, ("section", "sections")):
            if self._lists[kind]:
                parts.append(f"{word} {', '.join(str(entry['name']) for entry in self._lists[kind])}")
        return f"<dotyk.Model{' ' + title if title else ''}: {', '.join(parts)}>"


_ANY: dict[int, dict[str, Any]] = {
    2: {
        "name": "b",
        "mesh": {"rectangle": {"from": [0, 0], "to": [1, 1], "cells": [1, 1]}},
        "material": {"young": 1, "poisson": 0},
    },
    3: {
        "name": "b",
        "mesh": {"box": {"from": [0, 0, 0], "to": [1, 1, 1], "cells": [1, 1, 1]}},
        "material": {"young": 1, "poisson": 0},
    },
}


def dimension_of(analysis: Any) -> int:
    """3 in space, else 2."""
    return 3 if analysis == "3d" else 2


def _file_mesh(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    mesh = entry.get("mesh")
    return {**entry, "mesh": {"file": mesh}} if isinstance(mesh, Mesh) else entry


def _without_active(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_active(own) for key, own in value.items() if key != "active"}
    if isinstance(value, list):
        return [_without_active(own) for own in value]
    return value


def _step(step: Any) -> dict[str, Any]:
    if isinstance(step, Mapping):
        return dict(step)
    if isinstance(step, tuple) and len(step) == 2:
        return {"name": step[0], "time": step[1]}
    if isinstance(step, str):
        raise ArgumentError(f"a step is a time, (name, time) or a table, not {step!r}")
    return {"time": step}
