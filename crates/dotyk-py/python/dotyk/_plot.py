"""Pictures by matplotlib: the report's deformed shape, pressure and gap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dotyk._errors import InputError
from dotyk._words import friend, number_of

if TYPE_CHECKING:
    from dotyk._solution import BodySolution, ContactSolution, Solution

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
    contacts = list(solution.contacts.values())
    low = 4 if space else 2
    figure = pyplot.figure(figsize=(8, 5 + low * len(contacts)), layout="constrained")
    grid = figure.add_gridspec(1 + len(contacts), 2, height_ratios=[5] + [low] * len(contacts))
    axes = figure.add_subplot(grid[0, :], projection="3d" if space else None)
    values = [_field(body, field) for body in bodies]
    moves = max(float(np.abs(body.displacement).max(initial=0.0)) for body in bodies)
    if scale is None:
        points = np.vstack([body.points for body in bodies])
        scale = 0.05 * float(np.ptp(points, axis=0).max()) / moves if moves > 0 else 1.0
    length, force = (solution.units.get(key) for key in ("length", "force"))
    stress = f" [{force}/{length}²]" if force and length else ""
    length = f" [{length}]" if length else ""
    ratios = ("utilisation", "equivalent_plastic_strain", "yielded")
    unit = length if field == "displacement" else "" if field in ratios else stress
    shapes = _space if space else _plane
    drawn = shapes(axes, bodies, values, scale)
    drawn.set_clim(*_range(np.concatenate(values)))
    figure.colorbar(drawn, ax=axes, label={"von_mises": "von Mises stress"}.get(field, field) + unit, shrink=0.8)
    axes.set_title(f"displacements {scale:.3g} times as large", fontsize="medium")
    for k, contact in enumerate(contacts):
        # rounding is no gap
        gap = np.where(np.abs(contact.gap) > 1e-9 * moves, contact.gap, 0.0)
        if space:
            for column, (nodal, label) in enumerate([(contact.pressure, "pressure" + stress), (gap, "gap" + length)]):
                below = figure.add_subplot(grid[1 + k, column], projection="3d")
                drawn = _side(below, solution, contact, nodal)
                figure.colorbar(drawn, ax=below, label=label, shrink=0.7)
                below.set_title(contact.name, fontsize="medium")
            continue
        below = figure.add_subplot(grid[1 + k, :])
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(contact.points, axis=0), axis=1))])
        below.plot(arc, contact.pressure, color="tab:red", label="pressure")
        below.set_ylabel("pressure" + stress)
        below.set_xlabel(f"{contact.name}: way along the side{length}")
        other = below.twinx()
        other.plot(arc, gap, color="tab:blue", linewidth=1, label="gap")
        other.set_ylabel("gap" + length)
    return figure


def _range(values: Any) -> tuple[float, float]:
    import numpy as np

    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    return low, high if high > low else low + 1.0


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


def _plane(axes: Any, bodies: list[BodySolution], values: list[Any], scale: float) -> Any:
    import numpy as np

    collections = friend("matplotlib.collections", "plot()")
    polygons, means = [], []
    for body, nodal in zip(bodies, values, strict=True):
        moved = body.points + scale * body._array("shown")
        for kind, _, nodes in body._mesh().blocks():  # type: ignore[attr-defined]
            around = nodes[:, _AROUND[kind]]
            polygons.extend(moved[around])
            means.append(np.nanmean(nodal[around], axis=1))
    drawn = collections.PolyCollection(polygons, array=np.concatenate(means), edgecolors="face", linewidths=0.2)
    axes.add_collection(drawn)
    axes.autoscale_view()
    axes.set_aspect("equal")
    return drawn


def _space(axes: Any, bodies: list[BodySolution], values: list[Any], scale: float) -> Any:
    """The faces of all bodies as one collection: what is nearer covers what is farther, whichever body it belongs to."""
    polygons: list[Any] = []
    means: list[float] = []
    for body, nodal in zip(bodies, values, strict=True):
        moved = body.points + scale * body._array("shown")
        seen: dict[tuple[int, ...], Any] = {}
        for kind, _, nodes in body._mesh().blocks():  # type: ignore[attr-defined]
            for face in _FACES[kind[:3]]:
                for corners in nodes[:, face]:
                    key = tuple(sorted(corners))
                    if seen.pop(key, None) is None:
                        seen[key] = corners
        polygons.extend(moved[face] for face in seen.values())
        means.extend(_mean(nodal[face]) for face in seen.values())
    return _faces(axes, polygons, means)


def _side(axes: Any, solution: Solution, contact: ContactSolution, nodal: Any) -> Any:
    """Values at the nodes of a contact on the facets of its nonmortar side, seen along its mean normal."""
    import numpy as np

    body, _, side = contact.nonmortar.partition(".")
    mesh = solution.bodies[body].mesh
    at = np.full(len(mesh.points), np.nan)
    at[contact.node] = nodal
    facets = np.atleast_2d(mesh.sides[side])
    corners = facets[:, : 3 if facets.shape[1] in (3, 6, 7) else 4]
    mean = np.nanmean(contact.normal, axis=0)
    length = float(np.linalg.norm(mean))
    # a side that goes around has no normal to be seen along
    if length > 0.5:
        x, y, z = mean / length
        axes.view_init(elev=float(np.degrees(np.arcsin(z))), azim=float(np.degrees(np.arctan2(y, x))))
    drawn = _faces(axes, list(mesh.points[corners]), [_mean(at[facet]) for facet in facets])
    drawn.set_clim(*_range(nodal))
    return drawn


def _mean(values: Any) -> float:
    """Of the finite ones; NaN where there is none."""
    import numpy as np

    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else float("nan")


def _faces(axes: Any, polygons: list[Any], means: list[float]) -> Any:
    import numpy as np

    art = friend("mpl_toolkits.mplot3d.art3d", "plot()")
    drawn = art.Poly3DCollection(polygons, linewidths=0.1, edgecolors="0.3")
    drawn.set_array(np.array(means))
    axes.add_collection3d(drawn)
    corners = np.vstack(polygons)
    low, high = corners.min(axis=0), corners.max(axis=0)
    # a flat side has an extent of its own across itself, so that its axes keep their proportions
    room = np.maximum(high - low, 0.02 * float((high - low).max()))
    for k, limits in enumerate((axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        middle = 0.5 * (low[k] + high[k])
        limits(middle - 0.5 * room[k], middle + 0.5 * room[k])
        if high[k] - low[k] < 0.1 * room.max():
            # no place for numbers
            (axes.set_xticks, axes.set_yticks, axes.set_zticks)[k]([])
    axes.set_box_aspect(room)
    axes.tick_params(labelsize="x-small")
    return drawn
