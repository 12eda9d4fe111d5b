"""Pictures by matplotlib: the report's deformed shape, pressure and gap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dotyk._errors import InputError
from dotyk._words import friend, number_of

if TYPE_CHECKING:
    from dotyk._solution import BodySolution, Solution

#: Edges of cells of the plane: their nodes in order around the cell.
_AROUND = {
    "tri3": [0, 1, 2], "tri6": [0, 3, 1, 4, 2, 5],
    "quad4": [0, 1, 2, 3], "quad8": [0, 4, 1, 5, 2, 6, 3, 7], "quad9": [0, 4, 1, 5, 2, 6, 3, 7],
}  # fmt: skip
#: Corners of the faces of cells of space.
_FACES = {
    "tet": [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]],
    "hex": [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    "pri": [[0, 1, 2], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
}


def plot(solution: Solution, field: str, scale: float | None) -> Any:
    """A figure: bodies above, contacts below."""
    import numpy as np

    friend("matplotlib", "plot()")
    pyplot = friend("matplotlib.pyplot", "plot()")
    scale = number_of(scale, "scale")
    if scale is not None and not np.isfinite(scale):
        raise InputError("`scale` must be finite")
    bodies = list(solution.bodies.values())
    space = bodies[0].points.shape[1] == 3
    contacts = [] if space else list(solution.contacts.values())
    figure = pyplot.figure(figsize=(8, 5 + 2 * len(contacts)), layout="constrained")
    grid = figure.add_gridspec(1 + len(contacts), 1, height_ratios=[5] + [2] * len(contacts))
    axes = figure.add_subplot(grid[0], projection="3d" if space else None)
    values = [_field(body, field) for body in bodies]
    finite = np.concatenate([v[np.isfinite(v)] for v in values])
    low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 1.0)
    moves = max(float(np.abs(body.displacement).max(initial=0.0)) for body in bodies)
    if scale is None:
        points = np.vstack([body.points for body in bodies])
        scale = 0.05 * float(np.ptp(points, axis=0).max()) / moves if moves > 0 else 1.0
    for body, nodal in zip(bodies, values, strict=True):
        shapes = _space if space else _plane
        drawn = shapes(axes, body, nodal, scale)
        drawn.set_clim(low, high if high > low else low + 1.0)
    length, force = (solution.units.get(key) for key in ("length", "force"))
    stress = f" [{force}/{length}²]" if force and length else ""
    length = f" [{length}]" if length else ""
    ratios = ("utilisation", "equivalent_plastic_strain", "yielded")
    unit = length if field == "displacement" else "" if field in ratios else stress
    figure.colorbar(drawn, ax=axes, label={"von_mises": "von Mises stress"}.get(field, field) + unit, shrink=0.8)
    axes.set_title(f"displacements {scale:.3g} times as large", fontsize="medium")
    for k, contact in enumerate(contacts):
        below = figure.add_subplot(grid[1 + k])
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(contact.points, axis=0), axis=1))])
        below.plot(arc, contact.pressure, color="tab:red", label="pressure")
        below.set_ylabel("pressure" + stress)
        below.set_xlabel(f"{contact.name}: way along the side{length}")
        other = below.twinx()
        # rounding is no gap
        gap = np.where(np.abs(contact.gap) > 1e-9 * moves, contact.gap, 0.0)
        other.plot(arc, gap, color="tab:blue", linewidth=1, label="gap")
        other.set_ylabel("gap" + length)
    return figure


def _field(body: BodySolution, field: str) -> Any:
    import numpy as np

    components = ["xx", "yy", "zz", "xy", "yz", "xz"]
    if field in components:
        return body.stress[:, components.index(field)]
    if field in ("s1", "s2", "s3"):
        return body.principal_stress[:, int(field[1]) - 1]
    if field == "displacement":
        return np.linalg.norm(body.displacement, axis=1)
    scalars = ("von_mises", "utilisation", "equivalent_plastic_strain", "yielded")
    if field in scalars:
        return getattr(body, field)
    known = ", ".join([*scalars, "displacement", "s1", "s2", "s3", *components])
    raise InputError(f"unknown field `{field}`; known: {known}")


def _plane(axes: Any, body: BodySolution, nodal: Any, scale: float) -> Any:
    import numpy as np

    collections = friend("matplotlib.collections", "plot()")
    moved = body.points + scale * body._array("shown")
    polygons, means = [], []
    for kind, _, nodes in body._mesh().blocks():  # type: ignore[attr-defined]
        around = nodes[:, _AROUND[kind]]
        polygons.extend(moved[around])
        means.append(np.nanmean(nodal[around], axis=1))
    drawn = collections.PolyCollection(polygons, array=np.concatenate(means), edgecolors="face", linewidths=0.2)
    axes.add_collection(drawn)
    axes.autoscale_view()
    axes.set_aspect("equal")
    return drawn


def _space(axes: Any, body: BodySolution, nodal: Any, scale: float) -> Any:
    import numpy as np

    art = friend("mpl_toolkits.mplot3d.art3d", "plot()")
    moved = body.points + scale * body._array("shown")
    seen: dict[tuple[int, ...], Any] = {}
    for kind, _, nodes in body._mesh().blocks():  # type: ignore[attr-defined]
        for face in _FACES[kind[:3]]:
            for corners in nodes[:, face]:
                key = tuple(sorted(corners))
                if seen.pop(key, None) is None:
                    seen[key] = corners
    faces = list(seen.values())
    drawn = art.Poly3DCollection([moved[face] for face in faces], linewidths=0.1, edgecolors="0.3")
    drawn.set_array(np.array([np.nanmean(nodal[face]) for face in faces]))
    axes.add_collection3d(drawn)
    low, high = moved.min(axis=0), moved.max(axis=0)
    for k, limits in enumerate((axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        limits(low[k], high[k])
    axes.set_box_aspect(np.maximum(high - low, 1e-9))
    return drawn
