"""Two solutions side by side: what they answer to the same questions, and a page with both."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Sequence
from html import escape
from typing import Any, NamedTuple, overload

from dotyk import _dotyk
from dotyk._errors import ArgumentError
from dotyk._solution import Solution
from dotyk._words import friend, written


class Difference(NamedTuple):
    """A number in two solutions; NaN in one that does not have it.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> row = dotyk.compare(s, s)[0]
    >>> row.what, row.difference
    ('block.max_displacement', 0.0)
    """

    what: str
    first: float
    second: float

    @property
    def difference(self) -> float:
        """The second minus the first.

        >>> import dotyk
        >>> dotyk.Difference("u", 1.0, 3.0).difference
        2.0
        """
        return self.second - self.first

    @property
    def relative(self) -> float:
        """The difference in parts of the first; 0 of two zeros, infinite of the first alone.

        >>> import dotyk
        >>> dotyk.Difference("u", 2.0, 3.0).relative, dotyk.Difference("u", 0.0, 0.0).relative
        (0.5, 0.0)
        """
        if self.difference == 0.0:
            return 0.0
        return self.difference / abs(self.first) if self.first else math.copysign(math.inf, self.difference)


class Comparison(Sequence[Difference]):
    """What two solutions answer: probes, then bodies, contacts, beds, members and sections that they have, each number in both.

    >>> import dotyk
    >>> m = dotyk.Model("plane-strain", parameters={"q": 1.0})
    >>> block = m.body("block", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e3, poisson=0)
    >>> _ = block.fix("bottom", x=0, y=0).load("top", pressure="q")
    >>> _ = m.probe("top", "block.displacement.y", at=[0.5, 1])
    >>> both = dotyk.compare(m.solve(), m.solve(parameters={"q": 2.0}))
    >>> [(row.what, round(row.first, 9), round(row.second, 9), round(row.relative, 9)) for row in both][0]
    ('top', -0.001, -0.002, -1.0)
    """

    def __init__(self, first: Solution, second: Solution) -> None:
        self._both = (first, second)
        one, other = (_numbers(solution) for solution in self._both)
        names = [*one, *(name for name in other if name not in one)]
        self._rows = [Difference(name, one.get(name, math.nan), other.get(name, math.nan)) for name in names]

    @overload
    def __getitem__(self, index: int) -> Difference: ...

    @overload
    def __getitem__(self, index: slice) -> list[Difference]: ...

    def __getitem__(self, index: int | slice) -> Difference | list[Difference]:
        return self._rows[index]

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[Difference]:
        return iter(self._rows)

    def to_pandas(self) -> Any:
        """A table of pandas.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> list(dotyk.compare(s, s).to_pandas())
        ['what', 'first', 'second', 'difference', 'relative']
        """
        columns = ("what", "first", "second", "difference", "relative")
        rows = [{column: getattr(row, column) for column in columns} for row in self]
        return friend("pandas", "to_pandas()").DataFrame(rows, columns=list(columns))

    def report(self, path: str | os.PathLike[str] | None = None) -> str:
        """A page with the numbers, and the pictures of both beside each other; written into a file where ``path`` is given.

        >>> import dotyk.examples
        >>> s = dotyk.examples.punch().solve()
        >>> dotyk.compare(s, s).report()[:15]
        '<!DOCTYPE html>'
        """
        page = _page(self._both, self._rows)
        if path is not None:
            written(path, page)
        return page

    def __repr__(self) -> str:
        first, second = (solution.case or "a model" for solution in self._both)
        return f"<dotyk.Comparison: {first} and {second}, {len(self)} numbers>"

    def _repr_html_(self) -> str:
        return _table(self._rows)


def compare(first: Solution, second: Solution) -> Comparison:
    """Compares two solutions, such as two designs, two meshes or two load steps.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> all(row.difference == 0.0 for row in dotyk.compare(s, s))
    True
    """
    for solution in (first, second):
        if not isinstance(solution, Solution):
            raise ArgumentError(f"two solutions are compared, not {type(solution).__name__}")
    return Comparison(first, second)


#: What is told of each body, contact, bed and member, where it has it.
_KEYS = {
    "bodies": ("max_displacement", "max_von_mises", "strain_energy", "reaction"),
    "contacts": ("length", "max_pressure", "resultant"),
    "beds": ("closed_area", "max_pressure", "resultant"),
}


def _numbers(solution: Solution) -> dict[str, float]:
    """The numbers of a solution by name; components have those of their axes."""
    numbers: dict[str, float] = {}
    for name, probe in solution.probes.items():
        # of a line the range
        range_ = {f"{name}.{end}": float(getattr(probe, end)) for end in ("smallest", "largest") if hasattr(probe, end)}
        numbers.update(range_ or {name: float(probe)})
    for kind, keys in _KEYS.items():
        for name, part in getattr(solution, kind).items():
            for key in keys:
                value = getattr(part, key, None)
                if isinstance(value, list):
                    axes = {f"{name}.{key}.{axis}": float(own) for axis, own in zip("xyz", value)}
                    numbers.update(_without_rounding(axes))
                elif value is not None:
                    numbers[f"{name}.{key}"] = float(value)
    for _, kind, _ in _dotyk.members():
        numbers.update({f"{name}.force": float(part.force) for name, part in getattr(solution, kind).items()})
    for name, part in solution.sections.items():
        for keys in (("N", "V", "V2"), ("M", "M2", "T"), ("utilisation",)):
            ends: dict[str, float] = {}
            for key in keys:
                values = [station[key] for station in part.stations if station.get(key) is not None]
                known = [value for value in values if not math.isnan(value)]
                if known:
                    ends.update({f"{name}.{key}.min": min(known), f"{name}.{key}.max": max(known)})
            numbers.update(_without_rounding(ends))
    return numbers


#: A number below this part of the largest beside it is rounding.
_ROUNDING = 1e-9


def _without_rounding(numbers: dict[str, float]) -> dict[str, float]:
    least = _ROUNDING * max((abs(value) for value in numbers.values()), default=0.0)
    return {name: 0.0 if abs(value) < least else value for name, value in numbers.items()}


def _shown(value: float, digits: int = 5) -> str:
    return "–" if math.isnan(value) else f"{value:.{digits}g}".replace("-", "−")


def _table(rows: Sequence[Difference]) -> str:
    def cells(row: Difference) -> str:
        same = abs(row.relative) < _ROUNDING
        percent = "0" if same else f"{100 * row.relative:+.2f} %".replace("-", "−")
        relative = percent if math.isfinite(row.relative) else "–"
        numbers = (_shown(row.first), _shown(row.second), "0" if same else _shown(row.difference, 3), relative)
        return f"<tr><th>{escape(row.what)}</th>" + "".join(f"<td>{number}</td>" for number in numbers) + "</tr>"

    head = "<tr><th></th><th>first</th><th>second</th><th>difference</th><th>of the first</th></tr>"
    return f"<table><thead>{head}</thead><tbody>{''.join(map(cells, rows))}</tbody></table>"


_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2733; margin: 0; }
main { max-width: 1240px; margin: 0 auto; padding: 28px 20px; overflow-wrap: break-word; }
h1 { font-size: 25px; } h2 { font-size: 19px; border-bottom: 1.5px solid #1d2733; padding-bottom: 4px; margin: 32px 0 12px; }
table { border-collapse: collapse; font-size: 13.5px; font-variant-numeric: tabular-nums; } .scroll { overflow-x: auto; }
th, td { text-align: right; padding: 3px 12px; border-bottom: 1px solid #e4e8ec; white-space: nowrap; }
th:first-child { text-align: left; font-weight: 400; } thead th { font-weight: 600; }
.pair { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 24px; break-inside: avoid; }
figure { margin: 0; } figure svg, figure img { display: block; width: 100%; height: auto; }
figcaption { font-size: 13px; color: #5a6672; }
@media screen and (max-width: 640px) { .pair { grid-template-columns: minmax(0, 1fr); } main { padding: 16px 12px; } }
"""


def _apart(figure: str, prefix: str) -> str:
    """A drawing whose names, and groups of buttons, are distinct from those of the other drawings on the page."""
    figure = re.sub(r'\b(id|name)="', rf'\1="{prefix}', figure)
    figure = re.sub(r"url\(#", f"url(#{prefix}", figure)
    return re.sub(r'href="#', f'href="#{prefix}', figure)


def _page(both: tuple[Solution, Solution], rows: Sequence[Difference]) -> str:
    names = ("first", "second")
    # what turns needs a program, which this page has not
    pictures = [{title: one for title, one in solution._run.figures() if "<script" not in one} for solution in both]
    titles = [*pictures[0], *(title for title in pictures[1] if title not in pictures[0])]

    def about(name: str, solution: Solution) -> str:
        parameters = ", ".join(f"{key} = {_shown(value)}" for key, value in solution.parameters.items())
        verdict = "certified" if solution.converged else "<b>not converged</b>"
        words = [f"<b>{name}</b>: {escape(solution.case or 'a model')}", f"t = {_shown(solution.time)}", verdict]
        return "<p>" + ", ".join([*words, *([escape(parameters)] if parameters else [])]) + "</p>"

    def pair(title: str) -> str:
        own = (_apart(pictures[k].get(title, "<p>–</p>"), f"{names[k]}-") for k in range(2))
        return f"<h2>{escape(title)}</h2><div class=\"pair\">{''.join(f'<div>{one}</div>' for one in own)}</div>"

    head = "".join(about(name, solution) for name, solution in zip(names, both))
    drawn = "".join(pair(title) for title in titles)
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Two solutions</title><style>{_STYLE}</style></head><body><main><h1>Two solutions</h1>{head}"
        f'<h2>Numbers</h2><div class="scroll">{_table(rows)}</div>{drawn}</main></body></html>\n'
    )
