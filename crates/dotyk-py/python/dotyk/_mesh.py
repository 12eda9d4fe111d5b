"""Meshes: generated, read, or given as arrays."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from dotyk import _dotyk
from dotyk._errors import ArgumentError, InputError
from dotyk._words import Writer, friend, key_of, keywords, keywords_of, path_of, taken, unmasked

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Floats = Sequence[float] | npt.NDArray[Any]
    Counts = Sequence[int] | npt.NDArray[Any]

#: Kinds of cells as meshio calls them.
_MESHIO = {
    "tri3": "triangle", "tri6": "triangle6", "quad4": "quad", "quad8": "quad8", "quad9": "quad9",
    "tet4": "tetra", "tet10": "tetra10", "hex8": "hexahedron", "hex20": "hexahedron20",
    "hex27": "hexahedron27", "prism6": "wedge", "prism15": "wedge15", "prism18": "wedge18",
}  # fmt: skip
_KINDS = {theirs: ours for ours, theirs in _MESHIO.items()}
_PLANE = ("tri3", "tri6", "quad4", "quad8", "quad9")
_FACETS = {2: {2: "line", 3: "line3"}, 3: {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}}
_VTK = {
    "tri3": 5, "tri6": 22, "quad4": 9, "quad8": 23, "quad9": 28, "tet4": 10, "tet10": 24,
    "hex8": 12, "hex20": 25, "hex27": 29, "prism6": 13, "prism15": 26, "prism18": 32,
}  # fmt: skip


class Mesh:
    """A checked mesh with named sides.

    points:
        (n, 2) in the plane, (n, 3) in space; any floats.
    cells:
        ``{kind: (m, k) numbers of nodes}``, kinds as in a case file (``quad4``, ``hex8``, ...), nodes in VTK's order. A key
        ``(kind, group)`` makes a group of cells, for several materials.
    sides:
        ``{name: (f, k)}``, facets by the numbers of their nodes; the corners suffice. ``boundary`` is the whole boundary,
        unless you give that name to another side.
    named:
        ``{name: point}``, points that supports, loads and probes may name.

    Numbers are taken over: later changes of the arrays change nothing. A cell that is listed several times counts once, in the
    group that comes first.

    >>> import dotyk
    >>> mesh = dotyk.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad4": [[0, 1, 2, 3]]}, {"bottom": [[0, 1]]})
    >>> mesh
    <dotyk.Mesh: 4 nodes, 1 quad4, sides bottom, boundary>
    """

    _native: Any

    @keywords
    def __init__(
        self,
        points: npt.ArrayLike,
        cells: Mapping[Any, npt.ArrayLike],
        sides: Mapping[str, npt.ArrayLike] | None = None,
        named: Mapping[str, Any] | None = None,
    ) -> None:
        import numpy as np

        unmasked(points, "`points`")
        try:
            if np.iscomplexobj(points):
                raise TypeError
            coordinates = np.ascontiguousarray(points, dtype=np.float64)
        except (TypeError, ValueError):
            raise ArgumentError("`points` is an array of numbers (n, 2 or 3)") from None
        if coordinates.ndim == 2 and coordinates.shape[1] == 3 and _is_plane(cells) and not coordinates[:, 2].any():
            coordinates = np.ascontiguousarray(coordinates[:, :2])
        if coordinates.ndim != 2:
            raise InputError(f"`points` has the shape {coordinates.shape}: it must be (n, 2) or (n, 3)")
        if not isinstance(cells, Mapping):
            raise ArgumentError("`cells` is a mapping from kinds of cells to arrays, {kind: (m, k)}")
        if sides is not None and not isinstance(sides, Mapping):
            raise ArgumentError("`sides` is a mapping from names to arrays, {name: (f, k)}")
        blocks = []
        for key, nodes in cells.items():
            kind, group = key if isinstance(key, tuple) and len(key) == 2 else (key, None)
            group = None if group is None else _text(group, "a group of cells")
            blocks.append((_text(kind, "a kind of cells"), group, _indices(nodes, f"cells of the kind {kind}")))
        facets = [(_text(name, "a side"), _indices(nodes, f"side `{name}`")) for name, nodes in (sides or {}).items()]
        places = _places(named or {}, coordinates.shape[1])
        self._native = _dotyk.Mesh.of_arrays(coordinates, blocks, facets, places, True)

    @classmethod
    def _of(cls, native: Any) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._native = native
        return mesh

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space.

        >>> import dotyk
        >>> mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
        >>> mesh.dimension
        2
        """
        return int(self._native.dimension)

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """Coordinates of the nodes, (n, 2 or 3), read-only.

        >>> import dotyk
        >>> mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
        >>> mesh.points.shape
        (6, 2)
        """
        return _frozen(self._native.points())  # type: ignore[no-any-return]

    @property
    def cells(self) -> dict[Any, npt.NDArray[np.uint32]]:
        """Nodes of the cells (m, k) by kind; by (kind, group) where cells have groups. Read-only.

        >>> import dotyk
        >>> mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
        >>> mesh.cells["quad4"].tolist()
        [[0, 1, 4, 3], [1, 2, 5, 4]]
        """
        import numpy as np

        found: dict[Any, Any] = {}
        for kind, group, nodes in self._native.blocks():
            key = kind if group is None else (kind, group)
            found[key] = np.vstack([found[key], nodes]) if key in found else nodes
        return {key: _frozen(nodes) for key, nodes in found.items()}

    @property
    def sides(self) -> dict[str, npt.NDArray[np.uint32]]:
        """Nodes of the facets (f, k) by side, read-only; of a side with facets of several kinds their corners.

        >>> import dotyk
        >>> mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
        >>> mesh.sides["left"].tolist()
        [[3, 0]]
        """
        import numpy as np

        found: dict[str, Any] = {}
        for name, nodes in self._native.sides():
            if name in found:
                corners = 2 if self.dimension == 2 else 3
                least = min(found[name].shape[1], nodes.shape[1], corners)
                found[name] = np.vstack([found[name][:, :least], nodes[:, :least]])
            else:
                found[name] = nodes
        return {name: _frozen(nodes) for name, nodes in found.items()}

    @property
    def named(self) -> dict[str, list[list[float]]]:
        """Named points, such as the groups of points of a mesh file.

        >>> import dotyk
        >>> mesh = dotyk.Mesh([[0, 0], [1, 0], [0, 1]], {"tri3": [[0, 1, 2]]}, named={"tip": [0, 1]})
        >>> mesh.named
        {'tip': [[0.0, 1.0]]}
        """
        return dict(self._native.named())

    @property
    def warnings(self) -> list[str]:
        """What was noticed when it was made, such as parts of a file that have no place in it.

        >>> import dotyk
        >>> mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
        >>> mesh.warnings
        []
        """
        return list(self._native.warnings)

    @keywords
    def patch(self, name: str, of: str, min: Floats, max: Floats) -> Mesh:
        """The mesh with one more side: the whole facets of the side ``of`` whose corners lie in a box.

        >>> import dotyk
        >>> dotyk.rectangle([0, 0], [4, 1], cells=[4, 1]).patch("left_half", of="top", min=[0, 1], max=[2, 1])
        <dotyk.Mesh: 10 nodes, 4 quad4, sides bottom, left, left_half, right, top>
        """
        return _made({"file": self, "sides": {name: {"of": of, "min": min, "max": max}}}, self.dimension == 3)

    def to_meshio(self) -> Any:
        """A ``meshio.Mesh`` with the sides as ``cell_sets``, so that it can be a body again. Needs meshio.

        >>> import dotyk
        >>> mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
        >>> mesh.to_meshio().cells_dict["quad"].shape
        (2, 4)
        """
        import numpy as np

        from dotyk._meshio import library

        meshio = library("to_meshio()")
        cells: list[tuple[str, Any]] = []
        groups: dict[str, list[int]] = {}
        for kind, group, nodes in self._native.blocks():
            if group is not None:
                groups.setdefault(group, []).append(len(cells))
            cells.append((_MESHIO[kind], nodes))
        sides: dict[str, list[int]] = {}
        for name, nodes in self._native.sides():
            sides.setdefault(name, []).append(len(cells))
            cells.append((_FACETS[self.dimension][nodes.shape[1]], nodes))
        sets = {
            name: [np.arange(len(nodes)) if k in places else np.array([], int) for k, (_, nodes) in enumerate(cells)]
            for name, places in (groups | sides).items()
        }
        points = self._native.points()
        if self.dimension == 2:
            points = np.column_stack([points, np.zeros(len(points))])
        return meshio.Mesh(points, cells, cell_sets=sets)

    def __repr__(self) -> str:
        cells: dict[str, int] = {}
        for kind, _, nodes in self._native.blocks():
            cells[kind] = cells.get(kind, 0) + len(nodes)
        counts = ", ".join(f"{count} {kind}" for kind, count in cells.items())
        names = sorted({name for name, _ in self._native.sides()})
        sides = f", side{'s' if len(names) > 1 else ''} {', '.join(names)}" if names else ""
        return f"<dotyk.Mesh: {len(self._native.points())} nodes, {counts}{sides}>"

    def __reduce__(self) -> tuple[Any, ...]:
        words = self._native.words()
        if words is not None:
            # made anew it has the curves behind its sides, too
            text, folder, space, meshes = words
            return _made_anew, (text, str(folder), space, [Mesh._of(mesh) for mesh in meshes])
        blocks = [(kind, group, nodes) for kind, group, nodes in self._native.blocks()]
        return _restored, (self._native.points(), blocks, self._native.sides(), self.named)


def _made_anew(text: str, folder: str, space: bool, meshes: list[Mesh]) -> Mesh:
    return Mesh._of(_dotyk.Mesh.of_text(text, folder, space, [mesh._native for mesh in meshes]))


def _restored(points: Any, blocks: Any, sides: Any, named: Any) -> Mesh:
    import numpy as np

    def own(nodes: Any) -> Any:
        return np.ascontiguousarray(nodes, dtype=np.int64)

    native = _dotyk.Mesh.of_arrays(
        points, [(k, g, own(n)) for k, g, n in blocks], [(name, own(n)) for name, n in sides], named
    )
    return Mesh._of(native)


def _frozen(array: Any) -> Any:
    """The same numbers where nobody can make them writeable again: in bytes."""
    import numpy as np

    return np.frombuffer(array.tobytes(), dtype=array.dtype).reshape(array.shape)


def _is_plane(cells: Any) -> bool:
    kinds = (key[0] if isinstance(key, tuple) and key else key for key in cells)
    return isinstance(cells, Mapping) and all(kind in _PLANE for kind in kinds)


def _places(named: Any, dimension: int) -> dict[str, list[list[float]]]:
    """Named points, checked."""
    import numpy as np

    if not isinstance(named, Mapping):
        raise ArgumentError("`named` is a mapping from names to points")
    places = {}
    for name, at in named.items():
        unmasked(at, f"the named point `{name}`")
        try:
            points = np.atleast_2d(np.asarray(at, dtype=float))
        except (TypeError, ValueError):
            raise ArgumentError(f"the named point `{name}` is {dimension} numbers") from None
        if points.ndim != 2 or points.shape[1] != dimension or not np.isfinite(points).all():
            raise InputError(f"the named point `{name}` is {dimension} finite numbers")
        places[_text(name, "a point")] = points.tolist()
    return places


def _text(value: Any, what: str) -> str:
    if not isinstance(value, str):
        raise ArgumentError(f"the name of {what} is a string, not {value!r}")
    return value


def _indices(nodes: Any, what: str) -> Any:
    import numpy as np

    unmasked(nodes, what)
    try:
        array = np.asarray(nodes)
    except (TypeError, ValueError):
        raise ArgumentError(f"{what}: an array of numbers of nodes is expected") from None
    if array.size == 0:
        array = array.reshape(0, array.shape[-1] if array.ndim == 2 else 2).astype(np.int64)
    if array.dtype.kind not in "iu":
        raise ArgumentError(f"{what}: numbers of nodes are integers, not {array.dtype}")
    if array.ndim != 2:
        raise InputError(f"{what}: an array with a row for each is expected, not the shape {array.shape}")
    return np.ascontiguousarray(array, dtype=np.int64)


def _made(mesh: Mapping[str, Any], space: bool, drawing: Any = None) -> Mesh:
    writer = Writer(3 if space else 2)
    text = f"mesh = {writer.table(taken(mesh), 'the mesh')}\n"
    if drawing is not None:
        text = f"drawing = {writer.table(taken(drawing), 'the drawing')}\n{text}"
    return Mesh._of(_dotyk.Mesh.of_text(text, os.getcwd(), space, writer.meshes))


def _generated(kind: str, space: bool, values: Mapping[str, Any]) -> Mesh:
    given = {key_of(key): value for key, value in values.items() if value is not None}
    return _made({kind: given}, space)


@keywords
def rectangle(
    from_: Floats,
    to: Floats,
    cells: Counts,
    cell: str | None = None,
    diagonals: str | None = None,
) -> Mesh:
    """A rectangle from one corner to the other; sides ``left``, ``right``, ``bottom``, ``top``.

    >>> import dotyk
    >>> dotyk.rectangle([0, 0], [4, 1], cells=[80, 20])
    <dotyk.Mesh: 1701 nodes, 1600 quad4, sides bottom, left, right, top>
    """
    return _generated("rectangle", False, locals())


@keywords
def ring(
    inner: float,
    outer: float,
    cells: Counts,
    center: Floats | None = None,
    from_: float | None = None,
    to: float | None = None,
    ratio: float | None = None,
    grade: float | None = None,
    cell: str | None = None,
    diagonals: str | None = None,
) -> Mesh:
    """A ring, or a part of one between two angles in degrees from +x; sides ``inner``, ``outer``, ``start``, ``end``.

    >>> import dotyk
    >>> dotyk.ring(1, 2, cells=[32, 4], cell="quad9")
    <dotyk.Mesh: 576 nodes, 128 quad9, sides inner, outer>
    """
    return _generated("ring", False, locals())


@keywords
def tunnel_rock(
    radius: float,
    half_width: float,
    half_height: float,
    cells: Counts,
    ratio: float | None = None,
    grade: float | None = None,
    cell: str | None = None,
    diagonals: str | None = None,
) -> Mesh:
    """The half x ≥ 0 of a plate with a round hole at the origin; sides ``hole``, ``top``, ``bottom``, ``right``, ``axis``.

    >>> import dotyk
    >>> sorted(dotyk.tunnel_rock(1, 5, 5, cells=[16, 8]).sides)
    ['axis', 'bottom', 'hole', 'right', 'top']
    """
    return _generated("tunnel_rock", False, locals())


@keywords_of("outline")
def outline(**keys: Any) -> Mesh:
    """A mesh of triangles within lines and arcs, with holes: the keys of ``mesh.outline`` of a case file.

    >>> import dotyk
    >>> mesh = dotyk.outline(size=0.5, from_=[0, 0], edges=[{"to": [1, 0], "name": "bottom"}, {"to": [0, 1]}, {"to": [0, 0]}])
    >>> sorted(mesh.sides)
    ['bottom', 'outline']
    """
    return _generated("outline", False, keys)


@keywords
def box(from_: Floats, to: Floats, cells: Counts, cell: str | None = None) -> Mesh:
    """A box; sides ``left``, ``right`` (x), ``front``, ``back`` (y), ``bottom``, ``top`` (z).

    >>> import dotyk
    >>> dotyk.box([0, 0, 0], [1, 1, 1], cells=[2, 2, 2])
    <dotyk.Mesh: 27 nodes, 8 hex8, sides back, bottom, front, left, right, top>
    """
    return _generated("box", True, locals())


@keywords
def cylinder(
    base: Floats,
    axis: Floats,
    radius: float,
    height: float,
    cells: Counts,
    inner: float | None = None,
    from_: float | None = None,
    to: float | None = None,
    cell: str | None = None,
) -> Mesh:
    """A cylinder or a tube; sides ``bottom``, ``top``, ``outer``, ``inner``, ``start``, ``end``.

    >>> import dotyk
    >>> tube = dotyk.cylinder([0, 0, 0], [0, 0, 1], radius=2, inner=1, height=1, cells=[16, 2, 1])
    >>> sorted(tube.sides)
    ['bottom', 'inner', 'outer', 'top']
    """
    return _generated("cylinder", True, locals())


@keywords
def sphere(
    center: Floats,
    radius: float,
    cells: Counts,
    inner: float | None = None,
    from_: float | None = None,
    to: float | None = None,
    cell: str | None = None,
) -> Mesh:
    """A ball, a shell, or a cap between two polar angles from +z in degrees; sides ``outer``, ``inner``, ``start``, ``end``.

    >>> import dotyk
    >>> sorted(dotyk.sphere([0, 0, 0], 1, cells=[8, 2]).sides)
    ['outer']
    """
    return _generated("sphere", True, locals())


@keywords
def extrude(
    mesh: Mesh | Mapping[str, Any],
    layers: Any,
    height: float | None = None,
    turn: Mapping[str, Any] | None = None,
    offset: float | None = None,
) -> Mesh:
    """A plane mesh moved along z (``height``, which may be negative) or turned about an axis (``turn``), from z or an angle
    ``offset``; its sides keep their names, ``first`` and ``last`` are the ends. An axis may touch the mesh.

    >>> import dotyk
    >>> plate = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
    >>> dotyk.extrude(plate, height=1, layers=1)
    <dotyk.Mesh: 12 nodes, 2 hex8, sides bottom, first, last, left, right, top>
    >>> dotyk.extrude(plate, turn={"point": [0, 0, 0], "axis": [0, 1, 0], "angle": 90}, layers=3)
    <dotyk.Mesh: 18 nodes, 3 prism6, 3 hex8, sides bottom, first, last, right, top>
    """
    plane: Any = {"file": mesh} if isinstance(mesh, Mesh) else mesh
    keys = {"mesh": plane, "layers": layers, "height": height, "turn": turn, "offset": offset}
    return _generated("extrude", True, keys)


@keywords_of("drawing")
def drawing(regions_of: str | Sequence[str], **keys: Any) -> Mesh:
    """The mesh of some regions of a drawing: lines whose regions share their nodes; the keys are those of ``[drawing]``.

    >>> import dotyk
    >>> frame = {"from_": [0, 0], "edges": [{"to": [2, 0]}, {"to": [2, 2]}, {"to": [0, 2]}, {"to": [0, 0], "name": "west"}]}
    >>> layer = {"from_": [-1, 1], "to": [3, 1]}
    >>> regions = [{"name": "clay", "at": [1, 0.5]}, {"name": "sand", "at": [1, 1.5]}]
    >>> sorted(dotyk.drawing("sand", size=1, lines=[frame, layer], regions=regions).sides)
    ['clay', 'outline', 'west']
    """
    given = {key_of(key): value for key, value in keys.items() if value is not None}
    return _made({"region": regions_of}, False, given)


@keywords
def read(path: Any, group: str | Sequence[str] | None = None, space: bool | None = None) -> Mesh:
    """The mesh of a file of Gmsh (``.msh`` 1, 2, 4) or VTU, of the live model of Gmsh (``gmsh`` or ``gmsh.model``), of a
    ``meshio.Mesh``, or of any other file that meshio reads (MED, Abaqus, Exodus, ...).

    ``group`` selects cells, groups of facets are its sides, and so are sets of nodes that cover facets of the boundary;
    other sets of nodes are named points. ``part.msh`` joins part_1.msh, part_2.msh, .. of a mesh with partitions.

    ``space`` says whether a body of space or of the plane is wanted; without it, solid cells make a body of space.

    >>> import dotyk
    >>> dotyk.read("no-such-file.msh")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    dotyk._errors.InputError: ...no-such-file.msh: cannot read the file: there is no such file
    """
    if _is_gmsh(path):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "model.msh")
            gmsh = friend("gmsh", "a live model")
            if not gmsh.isInitialized():
                raise InputError("Gmsh has no live model: call gmsh.initialize() and make one")
            try:
                gmsh.write(file)
            except Exception as error:
                raise InputError(f"Gmsh cannot write its model: {error}") from None
            return read(file, group=group, space=space)
    if _is_meshio(path):
        return _of_meshio(path, group, space)
    file = os.path.abspath(path_of(path, "path"))
    if _is_foreign(file):
        from dotyk._meshio import of_file

        return of_file(file, group, space)
    table = {"file": {"path": file, "group": group}}
    if space is not None:
        return _made(table, space)
    try:
        return _made(table, True)
    except InputError as error:
        try:
            return _made(table, False)
        except InputError as other:
            # which of both was meant, nobody knows: a file without solid cells is one of the plane
            raise (other if "cells of space" in str(error) else error) from None


def _is_meshio(thing: Any) -> bool:
    return type(thing).__module__.startswith("meshio")


def _is_gmsh(thing: Any) -> bool:
    return getattr(thing, "__module__", None) == "gmsh" or getattr(thing, "__name__", None) == "gmsh"


def _of_meshio(mesh: Any, group: str | Sequence[str] | None, space: bool | None) -> Mesh:
    from dotyk._meshio import of_meshio

    return of_meshio(mesh, group, space)


def _is_foreign(path: str) -> bool:
    """Whether a file is neither of Gmsh nor VTU, by its ending and its first bytes; one that is not there is none."""
    if os.path.splitext(path)[1].lower() in ("", ".msh", ".vtu") or not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        start = file.read(1024).lstrip()
    return not start.startswith((b"$MeshFormat", b"$NOD", b"$Comments")) and b"<VTKFile" not in start


def of_any(mesh: Any) -> Mesh | Mapping[str, Any]:
    """A mesh, a mesh of meshio, a live model of Gmsh, or a table of a case file."""
    if _is_gmsh(mesh):
        return read(mesh)
    if isinstance(mesh, (Mesh, Mapping)):
        return mesh
    if _is_meshio(mesh):
        return _of_meshio(mesh, None, None)
    raise ArgumentError(
        f"a mesh is a dotyk.Mesh, a meshio.Mesh or a table such as {{'rectangle': ..}}, not {type(mesh).__name__}"
    )
