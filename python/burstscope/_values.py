"""Values of keywords as texts, as they are typed on the command line."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from burstscope._burstscope import RawBurst

Given = list[tuple[str, str]]
Kind = TypeVar("Kind")
Function = TypeVar("Function", bound=Callable[..., Any])


def documented(keywords: Any) -> Callable[[Function], Function]:
    """Appends the documentation of the keywords to that of a function."""

    def with_keywords(function: Function) -> Function:
        function.__doc__ = f"{function.__doc__}\n{keywords.__doc__}"
        return function

    return with_keywords


def needed(name: str, value: Any, kind: type[Kind], remedy: str) -> Kind:
    """The argument ``name`` if it is of its kind; else an error that says what was given, and how to make one."""
    if isinstance(value, kind):
        return value
    raise TypeError(f"{name}: a {kind.__name__} is needed, not {type(value).__name__}; {remedy}")


def raw_burst(burst: Any) -> RawBurst:
    """The frames of the argument ``burst``."""
    from burstscope._burst import Burst

    raw: RawBurst = needed("burst", burst, Burst, "make one, Burst(frames), or open one, open(path)")._raw
    return raw


def pair(name: str, value: Any) -> tuple[float, float]:
    """Two numbers."""
    try:
        u, v = (float(part) for part in value)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: {value!r} is no pair of numbers; give two, such as (2.4, 0)") from None
    return u, v


def slope(value: Any) -> tuple[float, float]:
    """A slope (u, v), or one number for a horizontal one."""
    return pair("slope", (value, 0.0) if np.ndim(value) == 0 and not isinstance(value, str) else value)


def _axis(name: str, values: Any) -> str:
    """MIN:MAX:COUNT of evenly spaced slopes, such as ``np.linspace`` gives."""
    slopes = np.asarray(values, dtype=np.float64)
    if slopes.ndim != 1 or slopes.size == 0 or not np.isfinite(slopes).all():
        raise ValueError(f"{name}: give slopes in a row, (min, max, count) or one number, in pixels per frame")
    even = np.linspace(slopes[0], slopes[-1], slopes.size)
    if slopes[0] > slopes[-1] or not np.allclose(slopes, even, rtol=0, atol=1e-6 * max(1.0, float(np.abs(slopes).max()))):
        raise ValueError(f"{name}: the slopes are not evenly spaced from the smallest to the largest; give np.linspace(...)")
    return f"{text(float(slopes[0]))}:{text(float(slopes[-1]))}:{slopes.size}"


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
        is_row = name in ("slopes_u", "slopes_v") and (isinstance(value, list) or getattr(value, "ndim", 0) > 0)
        given.append((name, _axis(name, value) if is_row else text(value)))
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
