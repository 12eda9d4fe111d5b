"""Exceptions, with the library's own texts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dotyk._solution import Solution


class Error(Exception):
    """Anything that dotyk refuses or cannot do."""


class InputError(Error, ValueError):
    """Bad input: the text says what is wrong, where, and what to do."""


class UnknownName(InputError, KeyError):
    """A name that a mapping does not have; the text names the nearest one."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class ArgumentError(InputError, TypeError):
    """A wrong keyword or type of an argument; the text names the nearest keyword."""


class NotConverged(Error, RuntimeError):
    """No answer with a certificate.

    ``solution`` is the last iterate, complete but for ``converged``; ``None`` where a solver of the dual problem gave none.
    """

    solution: Solution | None

    def __init__(self, message: str, solution: Solution | None = None) -> None:
        super().__init__(message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.solution)
