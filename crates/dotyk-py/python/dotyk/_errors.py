"""Exceptions, with the library's own texts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dotyk._solution import Solution


class Error(Exception):
    """Anything that dotyk refuses or cannot do.

    >>> import dotyk
    >>> try:
    ...     dotyk.run("no-such-case.toml")
    ... except dotyk.Error as error:
    ...     print(error)
    no-such-case.toml: cannot read the file: there is no such file
    """


class InputError(Error, ValueError):
    """Bad input: the text says what is wrong, where, and what to do.

    >>> import dotyk
    >>> dotyk.rectangle([0, 0], [1, 1], cells=[0, 2])
    Traceback (most recent call last):
    dotyk._errors.InputError: mesh, rectangle, `cells`: the number of cells must be a positive integer
    """


class UnknownName(InputError, KeyError):
    """A name that a mapping does not have; the text names the nearest one.

    >>> import dotyk.examples
    >>> dotyk.examples.punch().solve().bodies["blok"]
    Traceback (most recent call last):
    dotyk._errors.UnknownName: there is no body `blok`: did you mean `block`?; known: block, punch
    """

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class ArgumentError(InputError, TypeError):
    """A wrong keyword or type of an argument; the text names the nearest keyword.

    >>> import dotyk
    >>> dotyk.rectangle([0, 0], [1, 1], cels=[2, 2])
    Traceback (most recent call last):
    dotyk._errors.ArgumentError: rectangle() has no keyword `cels`: did you mean `cells`?; known: from_, to, cells, cell, diagonals
    """


class NotConverged(Error, RuntimeError):
    """No answer with a certificate.

    ``solution`` is the last iterate of a model, complete but for ``converged``. Only a solver of the dual problem
    (:meth:`Dual.solve`) gives none, ``None``.

    >>> import dotyk.examples
    >>> m = dotyk.examples.press_fit()
    >>> _ = m.bodies["hub"].load("top", force=[0, "-80e3*t"])
    >>> try:
    ...     m.solve(steps=[0.0, 1.0])
    ... except dotyk.NotConverged as error:
    ...     error.solution.converged
    False
    """

    solution: Solution

    def __init__(self, message: str, solution: Any = None) -> None:
        super().__init__(message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.solution)
