"""Bursts with exactly known truth, seeded: the same seed makes the same burst on every machine."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from burstscope import _burstscope
from burstscope._burst import Burst
from burstscope._command import command
from burstscope._keywords import ChartKeywords, NoisyKeywords, SceneKeywords, TrajectoryKeywords
from burstscope._progress import Progress, shown
from burstscope._values import documented, fault, options, paths

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Synthetic", "chart", "noisy", "scene", "trajectory"]


def __dir__() -> list[str]:
    return __all__


class Synthetic(NamedTuple):
    """A synthetic burst and its truth."""

    burst: Burst
    #: The content of ``truth.json``: ``features`` with u, v, radius, sigma, slope_u, slope_v, and the noise.
    truth: dict[str, Any]


def _made(kind: str, keywords: Any, progress: Progress) -> Synthetic:
    with shown(progress) as tell:
        try:
            burst, truth = _burstscope.synthesise([kind, *options(keywords)], tell)
        except ValueError as error:
            raise fault(str(error)) from None
    return Synthetic(Burst._of(burst), json.loads(truth))


@documented(ChartKeywords)
def chart(*, progress: Progress = None, **keywords: Unpack[ChartKeywords]) -> Synthetic:
    """Discs on an even background, each with its own slope, as ``burstscope synth chart``.

    Returns
    -------
    Synthetic
        (burst, truth).

    Raises
    ------
    ValueError
        A value that makes no sense.
    """
    return _made("chart", keywords, progress)


@documented(SceneKeywords)
def scene(*, progress: Progress = None, **keywords: Unpack[SceneKeywords]) -> Synthetic:
    """Textured layers at several depths, each with its own slope, as ``burstscope synth scene``.

    Returns
    -------
    Synthetic
        (burst, truth).
    """
    return _made("scene", keywords, progress)


@documented(TrajectoryKeywords)
def trajectory(out: str | os.PathLike[str], **keywords: Unpack[TrajectoryKeywords]) -> dict[str, Any]:
    """Bursts along a camera's way past textured planes, with its poses, as ``burstscope synth trajectory``.

    Parameters
    ----------
    out : path
        Folder to make: ``bursts/``, ``gold/``, ``poses.txt``, ``lens.toml``, ``trajectory.json``.

    Returns
    -------
    dict
        The truth.
    """
    truth: dict[str, Any] = command("synth", "trajectory", out=Path(out), **keywords)["truth"]
    return truth


@documented(NoisyKeywords)
def noisy(
    *inputs: str | os.PathLike[str], out: str | os.PathLike[str], **keywords: Unpack[NoisyKeywords]
) -> dict[str, Any]:
    """Noisy copies of real frames, as a camera would have taken them in the dark, as ``burstscope synth noisy``.

    Parameters
    ----------
    *inputs : path
        Bursts.
    out : path
        Folder to make.

    Returns
    -------
    dict
        What is known of the copies.
    """
    truth: dict[str, Any] = command("synth", "noisy", *paths(inputs), out=Path(out), **keywords)["truth"]
    return truth
