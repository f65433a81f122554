"""Values of keywords as texts, as they are typed on the command line."""

from __future__ import annotations

import inspect
import operator
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from burstscope._burstscope import RawBurst

Given = list[tuple[str, str]]
Kind = TypeVar("Kind")
Function = TypeVar("Function", bound=Callable[..., Any])


def data_frame(table: Mapping[str, Any]) -> Any:
    """The columns as a table of pandas, which is imported only here."""
    try:
        import pandas
    except ImportError:
        raise ImportError("pandas, which a DataFrame needs, is not installed: pip install pandas") from None
    return pandas.DataFrame(table)


def write_hdf5(file: Any, group: str, arrays: Mapping[str, Any]) -> None:
    """Writes arrays into a group of an HDF5 file, which may be open, in place of a group of that name."""
    try:
        import h5py
    except ImportError:
        raise ImportError("h5py, which hloc's files need, is not installed: pip install h5py") from None
    if isinstance(file, (str, os.PathLike)):
        with h5py.File(file, "a") as opened:
            write_hdf5(opened, group, arrays)
        return
    if group in file:
        del file[group]
    made = file.create_group(group)
    for name, values in arrays.items():
        made.create_dataset(name, data=values)


def hloc_name(name: str, value: Any) -> str:
    """The name of an image in hloc, which splits its lists at spaces."""
    text = needed(name, value, str, "give the name of an image, such as 'night.png'")
    if not text or text.split() != [text]:
        raise ValueError(f"{name}: {text!r}; hloc's lists are split at spaces, so give a name without any")
    return text


def documented(keywords: Any) -> Callable[[Function], Function]:
    """Appends the documentation of the keywords to that of a function."""

    def with_keywords(function: Function) -> Function:
        # Without the line that names the function.
        _, _, parameters = inspect.cleandoc(keywords.__doc__).partition("\n\n")
        function.__doc__ = f"{inspect.cleandoc(function.__doc__ or '')}\n\n{parameters}\n"
        return function

    return with_keywords


def needed(name: str, value: Any, kind: type[Kind] | tuple[type[Kind], type[Any]], remedy: str) -> Kind:
    """The argument ``name`` if it is of its kind; else an error that says what was given, and how to make one."""
    if isinstance(value, kind):
        return value  # type: ignore[return-value, unused-ignore]
    words = "path" if isinstance(kind, tuple) else kind.__name__
    raise TypeError(f"{name}: a {words} is needed, not {type(value).__name__}; {remedy}")


class Made:
    """Base of what functions of the module make, and nobody else."""

    def __init__(self) -> None:
        raise TypeError(f"{type(self).__name__} has no constructor; functions make it, see its documentation")


def real(name: str, value: Any) -> float | None:
    """A number, or ``None``."""
    try:
        return None if value is None else float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: a number is needed, not {type(value).__name__}") from None


def whole(name: str, value: Any, low: int | None = None) -> int:
    """A whole number, of ``low`` or more."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: a whole number is needed, not {type(value).__name__}") from None
    if low is not None and number < low:
        raise ValueError(f"{name}: {number}; give {low} or more")
    return number


def path(name: str, value: Any) -> Path:
    """The path of a file or folder."""
    return Path(needed(name, value, (str, os.PathLike), "give the path of a file"))


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


def _axis(name: str, value: Any) -> str:
    """MIN:MAX:COUNT of a range, a number, or evenly spaced slopes, such as ``np.linspace`` gives."""
    if isinstance(value, str):
        return value
    try:
        slopes = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        slopes = np.full((0, 0), np.nan)
    is_range = isinstance(value, tuple) and len(value) == 3
    if slopes.ndim > 1 or slopes.size == 0 or not np.isfinite(slopes).all() or (isinstance(value, tuple) and not is_range):
        raise ValueError(
            f"{name}: {value!r} are no slopes; give (min, max, count), slopes in a row (np.linspace(...)) or one number, "
            "in pixels per frame"
        )
    if slopes.ndim == 0:
        return text(name, float(slopes))
    if is_range:
        low, high, count = (text(name, part) for part in slopes.tolist())
        return f"{low}:{high}:{count}"
    even = np.linspace(slopes[0], slopes[-1], slopes.size)
    if slopes[0] > slopes[-1] or not np.allclose(slopes, even, rtol=0, atol=1e-6 * max(1.0, float(np.abs(slopes).max()))):
        raise ValueError(f"{name}: the slopes are not evenly spaced from the smallest to the largest; give np.linspace(...)")
    return f"{text(name, float(slopes[0]))}:{text(name, float(slopes[-1]))}:{slopes.size}"


def _frames(name: str, value: Any) -> str:
    """A..B of a pair, a slice or a range."""
    if isinstance(value, str):
        return value
    try:
        given = slice(*value) if isinstance(value, (tuple, list)) and len(value) == 2 else value
        if given.step in (None, 1):
            return f"{operator.index(given.start)}..{operator.index(given.stop)}"
    except (AttributeError, TypeError):
        pass
    raise ValueError(f"{name}: {value!r}; give (a, b), or a slice or a range with a start, a stop and no step")


def text(name: str, value: Any) -> str:
    """The text of one value: ``True`` is ``true``, (a, b, c) is ``a:b:c``, [a, b] is ``a,b``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, tuple):
        return ":".join(text(name, part) for part in value)
    if hasattr(value, "tolist"):  # numpy's scalars and arrays
        return text(name, value.tolist())
    if isinstance(value, list):
        return ",".join(text(name, part) for part in value)
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{name}: {type(value).__name__} is no value of a keyword; give a number, a word, a tuple or a list")


_FORMS = {"frames": _frames, "slopes_u": _axis, "slopes_v": _axis, "planted_slopes": _axis}


def texts(keywords: Mapping[str, Any]) -> Given:
    """The keywords that are given, with the texts of their values; ``None`` is not given."""
    return [(name, _FORMS.get(name, text)(name, value)) for name, value in keywords.items() if value is not None]


def options(keywords: Mapping[str, Any]) -> list[str]:
    """The keywords as options of a command."""
    line: list[str] = []
    for name, value in keywords.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            line.append(option)
        elif value is not None and value is not False:
            # Commands that make frames take their number, or several.
            is_number = name == "frames" and not isinstance(value, (tuple, slice, range))
            line.append(f"{option}={text(name, value) if is_number else texts({name: value})[0][1]}")
    return line


def paths(values: tuple[str | os.PathLike[str], ...]) -> list[str]:
    """The paths as texts."""
    return [os.fspath(path("path", value)) for value in values]


def fault(message: str) -> Exception:
    """The error for what a command says of wrong use: its options are keywords here."""
    unknown = re.search(r"unexpected argument '-*([\w-]+)' found", message)
    if unknown is not None:
        similar = re.search(r"similar argument exists: '-*([\w-]+)'", message)
        hint = "" if similar is None else f"; did you mean {similar[1].replace('-', '_')}?"
        return TypeError(f"there is no keyword '{unknown[1].replace('-', '_')}'{hint}")
    message = message.split("\n\n")[0]
    message = re.sub(r"the following required arguments were not provided:\s*", "needed: ", message)
    message = re.sub(r"--([a-z][a-z-]*)( <[^>]*>)?", lambda found: found[1].replace("-", "_"), message)
    wrong = re.match(r"invalid value ('.*?') for '([\w-]+)[^']*': (.*)", message, re.DOTALL)
    if wrong is not None:
        value, name, why = wrong.groups()
        message = f"{name.replace('-', '_')}: {why if why.startswith(value) else f'{value}: {why}'}"
    return ValueError(" ".join(message.split()))
