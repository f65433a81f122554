"""Commands on a burst in memory: what the search would find, films and cases."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from burstscope import _burstscope
from burstscope._command import command
from burstscope._keywords import DetectorKeywords, FilmKeywords, RecoverKeywords
from burstscope._progress import Progress, shown
from burstscope._values import documented, needed, pair, path, raw_burst, texts, whole
from burstscope.evaluate import Report

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from burstscope._burst import Burst


def placing(burst: Burst, folder: Path) -> dict[str, str]:
    """The keyword that gives frames their places: a list of the times of uneven ones, in a folder, or the grid of views."""
    if burst.views is not None:
        rows, columns = burst.views
        return {"views": f"{rows}x{columns}"}
    positions, interval_s = burst._raw.positions()
    if positions == list(range(len(positions))):
        return {}
    file = folder / "times.txt"
    file.write_text("".join(f"{position * (interval_s or 1)!r}\n" for position in positions), encoding="utf-8")
    return {"times": str(file)}


@contextmanager
def _handed_over(burst: Burst) -> Iterator[tuple[Path, dict[str, Any]]]:
    """A file of the burst for a command, and the keywords with which its values are those in memory."""
    raw_burst(burst)
    with tempfile.TemporaryDirectory(prefix="burstscope-") as folder:
        safe = "".join(c if c.isalnum() or c in "-_ ." else "_" for c in burst.name).strip(". ") or "burst"
        if burst.quantisation_step > 0:
            # A case keeps integers, and the step between them, exactly.
            yield case(burst, Path(folder) / f"{safe[:80]}.burstcase", progress=False), {}
        else:
            frames = Path(folder) / f"{safe[:80]}.npy"
            np.save(frames, burst.seen)
            yield frames, {"full_scale": 1, **placing(burst, Path(folder))}


@documented(RecoverKeywords)
def recover(burst: Burst, **keywords: Unpack[RecoverKeywords]) -> Report:
    """Says what the search would find: things planted in the burst, and counted, as ``burstscope recover``.

    It runs in a process of its own.

    Parameters
    ----------
    burst : Burst
    **keywords
        The options, below, and the parameters of `burstscope.detect`.

    Returns
    -------
    burstscope.evaluate.Report
        ``half`` is the SNR at which half are found, ``over_snr`` the curve; its figure shows itself in a notebook.

    Raises
    ------
    ValueError
        A value that makes no sense.
    """
    with _handed_over(burst) as (file, scale), tempfile.TemporaryDirectory(prefix="burstscope-") as folder:
        plot = Path(folder) / "plot.svg"
        document = command("recover", file, plot=plot, **scale, **keywords)
        return Report(document, plot.read_text(encoding="utf-8"))


@documented(FilmKeywords)
def film(
    burst: Burst,
    out: str | os.PathLike[str],
    *,
    slope: tuple[float, float] | None = None,
    force: bool = False,
    **keywords: Unpack[FilmKeywords],
) -> Path:
    """Writes a sweep over slope, scale or frames as an animation (GIF, or MP4 by ``ffmpeg``), as ``burstscope film``.

    It runs in a process of its own.

    Parameters
    ----------
    burst : Burst
    out : path
        The file, named ``.gif`` or ``.mp4``; ``.png`` gives a file for each picture, named after it.
    slope : (u, v), optional
        Slope of a sweep over scale or frames, pixels per frame.
    force : bool
        Replace a file that is there and that Burstscope did not write.
    **keywords
        The options, below, such as ``sweep="slope-u=-3:3:49"``, and the parameters of `burstscope.detect`.

    Returns
    -------
    pathlib.Path
        The file.
    """
    target = path("out", out)
    given: dict[str, Any] = {} if slope is None else {"slope": list(pair("slope", slope))}
    with _handed_over(burst) as (file, full_scale):
        command("film", file, out=target, force=force, **given, **full_scale, **keywords)
    return target


@documented(DetectorKeywords)
def case(
    burst: Burst,
    out: str | os.PathLike[str],
    *,
    at: tuple[float, float] | None = None,
    around: int | None = None,
    note: str = "",
    params: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Path:
    """Writes a burst, its settings and what is asked of it into one file, as ``burstscope case``.

    The file holds the frames with 16 bits for each pixel. `burstscope.open`, the commands and the window open it.

    Parameters
    ----------
    burst : Burst
    out : path
        The file, named ``.burstcase``; one that is there is replaced.
    at : (u, v), optional
        The place that is asked about, pixels at mid-burst.
    around : int, optional
        Keep only the square of this many pixels to each side of the place.
    note : str
        A note, in any words.
    params, progress, **keywords
        See `burstscope.detect`.

    Returns
    -------
    pathlib.Path
        The file.
    """
    raw, target = raw_burst(burst), path("out", out)
    if target.suffix != ".burstcase":
        raise ValueError(f"out: name the file .burstcase: {target}")
    if around is not None and at is None:
        raise ValueError("around: it is around a place; give at=(u, v) too")
    place = None if at is None else pair("at", at)
    asked = (place, None if around is None else whole("around", around, 8), needed("note", note, str, "give words"))
    file = None if params is None else path("params", params)
    with shown(progress) as tell:
        _burstscope.write_case(raw, target, asked, file, texts(keywords), tell)
    return target
