"""Values of keywords as texts, as they are typed on the command line."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

Given = list[tuple[str, str]]
Function = TypeVar("Function", bound=Callable[..., Any])


def documented(keywords: Any) -> Callable[[Function], Function]:
    """Appends the documentation of the keywords to that of a function."""

    def with_keywords(function: Function) -> Function:
        function.__doc__ = f"{function.__doc__}\n{keywords.__doc__}"
        return function

    return with_keywords


def text(value: Any) -> str:
    """The text of one value: ``True`` is ``true``, (a, b, c) is ``a:b:c``, [a, b] is ``a,b``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, tuple):
        return ":".join(text(part) for part in value)
    if isinstance(value, (slice, range)):
        if value.start is None or value.stop is None or value.step not in (None, 1):
            raise ValueError("frames are A..B: give a slice or a range with a start, a stop and no step")
        return f"{value.start}..{value.stop}"
    if hasattr(value, "tolist"):  # numpy's scalars and arrays
        return text(value.tolist())
    if isinstance(value, list):
        return ",".join(text(part) for part in value)
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{type(value).__name__} is no value of a keyword; give a number, a word, a tuple or a list")


def texts(keywords: Mapping[str, Any]) -> Given:
    """The keywords that are given, with the texts of their values; ``None`` is not given."""
    given: Given = []
    for name, value in keywords.items():
        if value is None:
            continue
        if name == "frames" and isinstance(value, tuple):
            value = slice(*value)
        given.append((name, text(value)))
    return given


def options(keywords: Mapping[str, Any]) -> list[str]:
    """The keywords as options of a command."""
    line: list[str] = []
    for name, value in keywords.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            line.append(option)
        elif value is not None and value is not False:
            line.append(f"{option}={texts({name: value})[0][1]}")
    return line


def paths(values: tuple[str | os.PathLike[str], ...]) -> list[str]:
    """The paths as texts."""
    return [os.fspath(value) for value in values]
