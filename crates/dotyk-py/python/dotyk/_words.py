"""Words of Python as words of a case file: keywords, values, handles of meshes and functions."""

from __future__ import annotations

import contextlib
import functools
import inspect
import keyword
import math
import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from dotyk import _dotyk
from dotyk._errors import ArgumentError, InputError

if TYPE_CHECKING:
    from dotyk._mesh import Mesh

P = ParamSpec("P")
R = TypeVar("R")

#: What a handle begins with: a character that no key, name or expression has.
HANDLE = "\ue000"

#: Keys whose functions give a vector for each point.
VECTORS = frozenset({"traction", "force", "body_force", "displacement"})

#: Tables whose keys are names of the user.
_NAMES = frozenset({"points", "surface", "sides", "parameters"})
#: Tables that messages name.
_TABLES = frozenset({"initial_stress", "initial_strain", "obstacle", "friction"})

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


def key_of(name: str) -> str:
    """The key of a case file for a keyword: ``from_`` is ``from``."""
    bare = name[:-1]
    return bare if name.endswith("_") and keyword.iskeyword(bare) else name


def keyword_of(key: str) -> str:
    """The keyword for a key of a case file."""
    return key + "_" if keyword.iskeyword(key) else key


def keys_of(table: str) -> list[str]:
    """The keys of a table of a case file."""
    return dict(_dotyk.keys())[table]


def keywords(function: Callable[P, R]) -> Callable[P, R]:
    """Wrong keywords name the nearest one; words of Python may be given without their underscore."""
    return _checked(function, None)


def keywords_of(table: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """The same for a function that takes the keys of a table of a case file as keywords."""
    return lambda function: _checked(function, table)


def _checked(function: Callable[P, R], table: str | None) -> Callable[P, R]:
    parameters = inspect.signature(function).parameters
    known = [
        name
        for name, parameter in parameters.items()
        if name not in ("self", "cls") and parameter.kind is not parameter.VAR_KEYWORD
    ]
    free = table is None and any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    if table is not None:
        known += [keyword_of(key) for key in keys_of(table)]

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        given: dict[str, Any] = {}
        for name, value in kwargs.items():
            own = name if free or name in known else keyword_of(name)
            if not free and own not in known:
                near = _dotyk.nearest(name, known)
                hint = f": did you mean `{near}`?" if near else ""
                raise ArgumentError(
                    f"{function.__name__}() has no keyword `{name}`{hint}; known: {', '.join(known)}"
                )
            given[own] = value
        try:
            inspect.signature(function).bind(*args, **given)
        except TypeError as error:
            raise ArgumentError(f"{function.__name__}(): {error}") from None
        return function(*args, **given)

    return call


def unmasked(value: Any, what: str) -> Any:
    """The value, unless it is a masked array of NumPy or a list of such: what its mask hides are no numbers."""
    masks = sys.modules.get("numpy.ma")
    if masks is not None and isinstance(value, masks.MaskedArray):
        raise InputError(
            f"{what}: masked arrays of NumPy are no numbers, for what is hidden is none; give a plain array, with numbers in "
            "its place (`.filled(..)`) or without it (`.compressed()`)"
        )
    if isinstance(value, (list, tuple)):
        for own in value:
            unmasked(own, what)
    return value


def taken(value: Any, depth: int = 0, what: str = "a value") -> Any:
    """A value that later changes of the caller's arrays, lists and tables do not change; ``what`` it is in messages."""
    from dotyk._mesh import Mesh

    if depth > 100:
        raise InputError("a value is nested more than 100 deep")
    if isinstance(value, (str, bytes, Mesh)) or callable(value):
        return value
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        return unmasked(value, what).tolist()
    if isinstance(value, Mapping):
        return {key: taken(own, depth + 1, f"`{key}`") for key, own in value.items()}
    if isinstance(value, (list, tuple)):
        return [taken(own, depth + 1, what) for own in value]
    return value


class Writer:
    """Writes values as TOML, and collects what no text can say."""

    def __init__(self, dimension: int) -> None:
        self.dimension = dimension
        self.meshes: list[Any] = []
        self.functions: list[tuple[Any, str, str, int | None]] = []

    def mesh(self, mesh: Mesh) -> str:
        """The handle of a mesh."""
        native = mesh._native
        if native not in self.meshes:
            self.meshes.append(native)
        return f'"{HANDLE}{self.meshes.index(native)}"'

    def function(self, function: Any, place: str, key: str) -> str:
        """The handle of a callable: a list of its components where it gives vectors."""
        components = self.dimension if key in VECTORS else None
        name = getattr(function, "__name__", type(function).__name__)
        number = len(self.functions)
        self.functions.append((function, place, name, components))
        if components is None:
            return f'"{HANDLE}{number}.0"'
        handles = (f'"{HANDLE}{number}.{c}"' for c in range(components))
        return f"[{', '.join(handles)}]"

    def value(self, value: Any, place: str, key: str = "") -> str:
        """A value as TOML; ``place`` says where it stands in messages."""
        from dotyk._mesh import Mesh

        if isinstance(value, Mesh):
            return self.mesh(value)
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, int):
            return str(int(value))
        if isinstance(value, float):
            return _number(float(value))
        if isinstance(value, str):
            return quoted(value)
        if isinstance(value, os.PathLike):
            return quoted(os.fspath(value))
        if isinstance(value, Mapping):
            where = value.get("side") or value.get("point")
            where = f"{place} on `{where}`" if isinstance(where, str) else place
            return self.table(value, f"{where}, {key}" if key in _TABLES else where, key in _NAMES)
        if hasattr(value, "tolist") and hasattr(value, "dtype"):
            what = f"{place}, `{key}`" if key else place
            return self.value(unmasked(value, what).tolist(), place, key)
        if callable(value):
            return self.function(value, f"{place}, {key}" if key else place, key)
        if isinstance(value, Sequence) or isinstance(value, (set, range)):
            # functions in a list are its components
            place = f"{place}, {key}" if key else place
            return f"[{', '.join(self.value(item, place) for item in value)}]"
        what = f"{place}, `{key}`" if key else place
        raise ArgumentError(f"{what}: a value of the type {type(value).__name__} means nothing here")

    def table(self, table: Mapping[Any, Any], place: str, names: bool = False) -> str:
        """An inline table; what is ``None`` is left out. Its keys are those of a case file, or names of the user."""
        entries = []
        for key, value in table.items():
            if not isinstance(key, str):
                raise ArgumentError(f"{place}: keys are strings, not {key!r}")
            if value is not None:
                own = key if names else key_of(key)
                entries.append(f"{_key(own)} = {self.value(value, place, own)}")
        return "{ " + ", ".join(entries) + " }" if entries else "{}"

    def entries(self, table: Mapping[str, Any], place: str, names: bool = False) -> str:
        """The lines of a table of its own, as :meth:`table`."""
        given = ((key if names else key_of(key), value) for key, value in table.items() if value is not None)
        return "".join(f"{_key(key)} = {self.value(value, place, key)}\n" for key, value in given)


def _key(key: str) -> str:
    return key if _BARE.match(key) else quoted(key)


def _number(value: float) -> str:
    if math.isnan(value):
        return "nan"
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return repr(value)


def quoted(text: str) -> str:
    """A string of TOML."""
    if HANDLE in text:
        raise InputError("a text has a character that stands for nothing")
    out = ['"']
    for c in text:
        if c in '"\\':
            out.append("\\" + c)
        elif ord(c) < 0x20 or ord(c) == 0x7F:
            out.append(f"\\u{ord(c):04x}")
        elif 0xD800 <= ord(c) <= 0xDFFF:
            raise InputError("a text has half a character")
        else:
            out.append(c)
    out.append('"')
    return "".join(out)


def parameters_of(parameters: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Names, and numbers or expressions as text."""
    if parameters is None:
        return []
    if not isinstance(parameters, Mapping):
        raise ArgumentError("`parameters` is a mapping from names to numbers or expressions")
    pairs = []
    for name, value in parameters.items():
        if not isinstance(name, str):
            raise ArgumentError(f"names of parameters are strings, not {name!r}")
        if isinstance(value, str):
            pairs.append((name, value))
            continue
        unmasked(value, f"the parameter `{name}`")
        try:
            pairs.append((name, _number(float(value))))
        except (TypeError, ValueError):
            raise ArgumentError(
                f"the value of the parameter `{name}` is a number or an expression, not {value!r}"
            ) from None
    return pairs


def number_of(value: Any, name: str) -> float | None:
    """A number or ``None``."""
    if value is None:
        return None
    if isinstance(value, (str, bytes, bool)):
        raise ArgumentError(f"`{name}` is a number, not {value!r}")
    unmasked(value, f"`{name}`")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"`{name}` is a number, not {value!r}") from None


#: More threads than this only wait for each other.
MOST_THREADS = 256


def threads_of(value: Any) -> int | None:
    """A number of threads, or ``None``."""
    count = count_of(value, "threads")
    if count is not None and count > MOST_THREADS:
        raise InputError(f"`threads` is at most {MOST_THREADS}")
    return count


def count_of(value: Any, name: str) -> int | None:
    """A whole number from 1 on, or ``None``."""
    number = number_of(value, name)
    if number is None:
        return None
    if not (number == number and 1 <= number < 2**31 and number == int(number)):
        raise InputError(f"`{name}` must be a positive integer")
    return int(number)


def text_of(value: Any, name: str) -> str:
    """A string."""
    if not isinstance(value, str):
        raise ArgumentError(f"`{name}` is a string, not {value!r}")
    return value


def written(path: Any, page: str) -> None:
    """Writes a page into a file, whole or not at all."""
    name = path_of(path, "path")
    part = name + ".part"
    try:
        with open(part, "w", encoding="utf-8") as stream:
            stream.write(page)
        os.replace(part, name)
    except OSError as error:
        with contextlib.suppress(OSError):
            os.remove(part)
        raise InputError(f"cannot write {name}: {error.strerror}") from error


def path_of(path: Any, name: str) -> str:
    """A path as text."""
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentError(f"`{name}` is a path, not {path!r}")
    text = os.fspath(path)
    if not isinstance(text, str) or not text or "\0" in text:
        raise InputError(f"`{name}`: {text!r} is not a path")
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        raise InputError(f"`{name}`: {text!r} is not a path") from None
    return text


def friend(name: str, what: str) -> Any:
    """A package that is not needed otherwise."""
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise ImportError(f"{what} needs {package}: pip install {package}") from error
