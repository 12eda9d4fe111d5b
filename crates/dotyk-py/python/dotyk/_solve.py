"""Solving: cases of files and of models, checks, studies, progress."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from dotyk import _dotyk
from dotyk._errors import ArgumentError, InputError, NotConverged
from dotyk._words import count_of, friend, keywords, number_of, parameters_of, path_of, threads_of, unmasked

if TYPE_CHECKING:
    from dotyk._solution import Solution

Table = Mapping[str, Any]


@dataclass(frozen=True)
class Progress:
    """What a callback is told.

    >>> import dotyk.examples
    >>> stages = []
    >>> _ = dotyk.examples.punch().solve(callback=lambda progress: stages.append(progress.stage))
    >>> stages[0], "factor" in stages, "contact" in stages
    ('step', True, True)
    """

    #: ``"step"``, or the stage: ``"assemble"``, ``"order"``, ``"factor"``, ``"condense"``, ``"contact"``, ``"recover"``.
    stage: str
    #: Number of the load step, from 1.
    step: int
    #: Number of load steps.
    steps: int
    #: Time of the load step.
    time: float
    #: Iteration of the contact solver, 0 before the first.
    iteration: int
    #: Its relative violation of the optimality conditions; NaN before the first.
    measure: float


class _Told:
    """Events of the library as :class:`Progress`."""

    def __init__(self, callback: Callable[[Progress], Any]) -> None:
        self.callback = callback
        self.stage, self.step, self.steps, self.time = "read", 1, 1, float("nan")
        self.iteration, self.measure = 0, float("nan")

    def __call__(self, event: tuple[str, Any]) -> None:
        kind, what = event
        if kind == "step":
            self.step, self.steps, self.time = what
            self.stage, self.iteration, self.measure = "step", 0, float("nan")
        elif kind == "stage":
            self.stage = what
        elif kind == "iteration":
            self.iteration, self.measure = what
        else:
            return
        values = (self.stage, self.step, self.steps, self.time, self.iteration, self.measure)
        self.callback(Progress(*values))


class _Line:
    """A line of progress on a terminal or in a notebook, from the first second on."""

    def __init__(self) -> None:
        self.start = self.last = time.monotonic()
        self.shown: Any = None

    def __call__(self, progress: Progress) -> None:
        now = time.monotonic()
        if now - self.start < 1.0 or now - self.last < 0.1:
            return
        self.last = now
        step = f"step {progress.step} of {progress.steps}, " if progress.steps > 1 else ""
        iteration = f", iteration {progress.iteration}, {progress.measure:.1e}" if progress.iteration else ""
        self.show(f"{step}{progress.stage}{iteration}, {now - self.start:.0f} s")

    def show(self, text: str) -> None:
        if _in_notebook():
            from IPython import display  # type: ignore[import-not-found, unused-ignore]

            if self.shown is None:
                self.shown = display.display({"text/plain": text}, raw=True, display_id=True)  # type: ignore[no-untyped-call, unused-ignore]
            else:
                self.shown.update({"text/plain": text}, raw=True)
        else:
            self.shown = True
            sys.stderr.write(f"\r  {text:<76}")
            sys.stderr.flush()

    def clear(self) -> None:
        if self.shown is None:
            return
        if _in_notebook():
            # nothing of it stays on the page
            self.shown.update({"text/html": "", "text/plain": ""}, raw=True)
        else:
            sys.stderr.write("\r" + " " * 78 + "\r")


def _in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    return shell is not None and type(shell.get_ipython()).__name__ == "ZMQInteractiveShell"


def _wants_line(progress: bool | None) -> bool:
    if progress is not None:
        return bool(progress)
    try:
        return _in_notebook() or sys.stderr.isatty()
    except (AttributeError, ValueError):
        return False


def solved(
    case: Any,
    method: Any,
    tolerance: Any,
    max_iterations: Any,
    rho: Any,
    threads: Any,
    callback: Any,
    progress: Any,
) -> Solution:
    """The solution of a case, or an exception."""
    from dotyk._dual import own_solver
    from dotyk._solution import Solution

    if callback is not None and not callable(callback):
        raise ArgumentError("`callback` is a function of one argument")
    if method is not None and not isinstance(method, str) and not callable(method):
        raise ArgumentError("`method` is a name or a function of a dual problem")
    name, own = (method, None) if isinstance(method, str) or method is None else (None, own_solver(method))
    line = _Line() if _wants_line(progress) else None
    listeners = [listener for listener in (callback, line) if listener is not None]

    def all_of_them(told: Progress) -> None:
        for listener in listeners:
            listener(told)

    try:
        run = case.solve(
            name,
            own,
            (number_of(tolerance, "tolerance"), count_of(max_iterations, "max_iterations"), number_of(rho, "rho")),
            threads_of(threads),
            _Told(all_of_them) if listeners else None,
        )
    finally:
        if line is not None:
            line.clear()
    failure = run.failure
    if failure is None:
        return Solution._of(run)
    reason, refused = failure
    # what an own solver gives is judged, whatever it is
    if refused and not (own is not None and "returned is no answer" in reason):
        raise InputError(reason)
    raise NotConverged(reason, Solution._of(run) if run.steps else None)


@keywords
def run(
    case: str | os.PathLike[str],
    parameters: Table | None = None,
    method: Any = None,
    threads: int | None = None,
    tolerance: float | None = None,
    max_iterations: int | None = None,
    rho: float | None = None,
    callback: Callable[[Progress], Any] | None = None,
    progress: bool | None = None,
) -> Solution:
    """Solves a case file, as the command does, and writes nothing.

    ``parameters`` gives parameters of the case other values.

    >>> import dotyk
    >>> dotyk.run("no-such-case.toml")
    Traceback (most recent call last):
    dotyk._errors.InputError: no-such-case.toml: cannot read the file: there is no such file
    """
    read = _dotyk.Case.of_file(path_of(case, "case"), parameters_of(parameters))
    return solved(read, method, tolerance, max_iterations, rho, threads, callback, progress)


@dataclass(frozen=True)
class BodyCheck:
    """What a check found of a body.

    >>> import dotyk.examples
    >>> check = dotyk.examples.punch().check()
    >>> check.bodies["punch"].nodes, check.bodies["punch"].load
    (121, (0.0, -1000000.0))
    """

    name: str
    nodes: int
    cells: int
    #: Resultant of its loads.
    load: tuple[float, ...]
    #: Number of held degrees of freedom.
    held: int
    #: Rigid motions that its supports leave free, each with what holds it.
    floating: tuple[str, ...]


@dataclass(frozen=True)
class ContactCheck:
    """What a check found of a contact.

    >>> import dotyk.examples
    >>> dotyk.examples.punch().check().contacts["sole"].unknowns
    11
    """

    name: str
    sides: tuple[str, str]
    #: Number of multipliers.
    unknowns: int


@dataclass(frozen=True)
class MemberCheck:
    """What a check found of a bar, a spring between places, or a bolt.

    >>> import dotyk
    >>> m = dotyk.Model("plane-strain")
    >>> rock = m.body("rock", dotyk.rectangle([0, 0], [4, 4], cells=[8, 8]), young=1e9, poisson=0.3)
    >>> _ = rock.fix("bottom", x=0, y=0) and m.bar("tie", from_=[1, 4], to=[1, 1], bodies=["rock"], young=2e11, area=1e-3)
    >>> m.check().members["tie"].length, m.check().members["tie"].ends
    (3.0, ('(1, 4)', '(1, 1)'))
    """

    name: str
    #: ``bar``, ``spring`` or ``bolt``.
    kind: str
    #: Where it begins and ends: "BODY.SIDE", or a point.
    ends: tuple[str, str]
    #: From its beginning to its end; that of a bolt is 0.
    length: float
    #: Number of its elements.
    elements: int
    #: How many it stands for.
    count: float


class Check:
    """What can be said of a model before anything is solved.

    >>> import dotyk.examples
    >>> check = dotyk.examples.punch().check()
    >>> bool(check), check.errors
    (True, [])
    >>> print(check)  # doctest: +ELLIPSIS
    body "block": 451 nodes, 400 cells, ...
    """

    #: What makes a solution impossible.
    errors: list[str]
    #: What the user should know.
    warnings: list[str]
    #: What else is worth to be known.
    notes: list[str]
    #: One for each body, by name.
    bodies: dict[str, BodyCheck]
    #: One for each contact, by name.
    contacts: dict[str, ContactCheck]
    #: One for each bar, spring between places and bolt, by name.
    members: dict[str, MemberCheck]

    def __init__(self, found: dict[str, Any]) -> None:
        self.errors, self.warnings = list(found["errors"]), list(found["warnings"])
        self.notes = list(found["notes"])
        self.bodies = {
            name: BodyCheck(name, size[0], size[1], tuple(load), held, tuple(floating))
            for name, size, load, held, floating in found["bodies"]
        }
        self.contacts = {
            name: ContactCheck(name, tuple(sides), unknowns) for name, sides, unknowns in found["contacts"]
        }
        self.members = {
            name: MemberCheck(name, kind, tuple(ends), length, elements, count)
            for name, kind, ends, length, elements, count in found["members"]
        }
        self._text = str(found["text"])

    def __bool__(self) -> bool:
        return not self.errors

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<dotyk.Check: {len(self.errors)} errors, {len(self.warnings)} warnings>"


@keywords
def check(case: str | os.PathLike[str], parameters: Table | None = None) -> Check:
    """Looks at a case file without solving it: what is wrong, what floats and what holds it.

    >>> import dotyk
    >>> dotyk.check("no-such-case.toml")
    Traceback (most recent call last):
    dotyk._errors.InputError: no-such-case.toml: cannot read the file: there is no such file
    """
    return Check(_dotyk.Case.of_file(path_of(case, "case"), parameters_of(parameters)).check())


@dataclass(frozen=True)
class Study(Mapping[str, Any]):
    """The columns of ``study.csv`` by name: parameters, probes, ``converged``, ``reason``; a row for each combination.

    Of all load steps, ``step`` and ``time`` come before the probes; a row for each step up to one without an answer.

    >>> import dotyk
    >>> m = dotyk.Model("plane-strain", parameters={"q": 1.0})
    >>> block = m.body("block", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e3, poisson=0)
    >>> _ = block.fix("bottom", x=0, y=0).load("top", pressure="q")
    >>> study = m.probe("top", "block.displacement.y", at=[0.5, 1]).study(vary={"q": [1.0, 2.0]})
    >>> len(study), list(study), [round(u, 9) for u in study["top"].tolist()]
    (2, ['q', 'top', 'converged', 'reason'], [-0.001, -0.002])
    """

    columns: dict[str, Any] = field(repr=False)
    #: Warnings of reading.
    warnings: list[str] = field(default_factory=list, repr=False)

    def __getitem__(self, name: str) -> Any:
        from dotyk._solution import unknown

        if name not in self.columns:
            raise unknown(name, list(self.columns), "column")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns["converged"])

    @property
    def converged(self) -> bool:
        """Every member, and of all load steps every step, has its answer.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain", parameters={"q": 1.0})
        >>> block = m.body("block", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e3, poisson=0)
        >>> _ = block.fix("bottom", x=0, y=0).load("top", pressure="q")
        >>> study = m.probe("top", "block.displacement.y", at=[0.5, 1]).study(vary={"q": [1.0, 2.0]})
        >>> study.converged
        True
        """
        return bool(self.columns["converged"].all())

    def to_pandas(self) -> Any:
        """A table of pandas.

        >>> import dotyk
        >>> m = dotyk.Model("plane-strain", parameters={"q": 1.0})
        >>> block = m.body("block", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e3, poisson=0)
        >>> _ = block.fix("bottom", x=0, y=0).load("top", pressure="q")
        >>> study = m.probe("top", "block.displacement.y", at=[0.5, 1]).study(vary={"q": [1.0, 2.0]})
        >>> study.to_pandas().shape
        (2, 4)
        """
        return friend("pandas", "to_pandas()").DataFrame(self.columns)

    def __repr__(self) -> str:
        rows = "load steps" if "step" in self.columns else "members"
        return f"<dotyk.Study: {len(self)} {rows}, columns {', '.join(self.columns)}>"


def studied(case: Any, vary: Any, parameters: Any, threads: int | None, steps: Any) -> Study:
    """The study of a case."""
    if not isinstance(steps, str) or steps not in ("last", "all"):
        raise ArgumentError(f'`steps` of a study is "last" or "all", not {steps!r}: the times are those of the model')
    if not isinstance(vary, Mapping) or not vary:
        raise ArgumentError("`vary` is a mapping from names of parameters to their values")
    varied = []
    for name, values in vary.items():
        if isinstance(values, (str, bytes)):
            raise ArgumentError(f"the values of `{name}` are an array of numbers")
        unmasked(values, f"the values of `{name}`")
        try:
            numbers = [float(value) for value in values]
        except (TypeError, ValueError):
            raise ArgumentError(f"the values of `{name}` are an array of numbers") from None
        if not numbers or not all(abs(number) < float("inf") for number in numbers):
            raise InputError(f"the values of `{name}` are finite numbers, at least one")
        varied.append((str(name), numbers))
    return Study(case.study(parameters_of(parameters), varied, steps == "all", threads), case.warnings)


@keywords
def study(
    case: Any,
    vary: Table,
    parameters: Table | None = None,
    threads: int | None = None,
    steps: Literal["last", "all"] = "last",
) -> Study:
    """Solves a case file, or a model, for all combinations of values of its parameters; rows tell the last load step, or all of them.

    >>> import dotyk
    >>> dotyk.study("no-such-case.toml", vary={"E": [1.0, 2.0]})
    Traceback (most recent call last):
    dotyk._errors.InputError: no-such-case.toml: cannot read the file: there is no such file
    """
    from dotyk._model import Model

    if isinstance(case, Model):
        return case.study(vary, parameters, threads, steps)
    pairs = parameters_of(parameters)
    read = _dotyk.Case.of_file(path_of(case, "case"), pairs)
    return studied(read, vary, parameters, threads_of(threads), steps)
