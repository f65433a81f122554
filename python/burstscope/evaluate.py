"""Measurements of the detector against known truth: the studies of ``burstscope evaluate``, in a process of their own."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from burstscope._command import command
from burstscope._keywords import (
    EvaluateAccuracyKeywords,
    EvaluateChartKeywords,
    EvaluateFramesKeywords,
    EvaluateMatchesKeywords,
    EvaluateNoiseKeywords,
    EvaluatePosesKeywords,
)
from burstscope._values import documented, paths

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Report", "accuracy", "chart", "frames", "matches", "noise", "poses"]


def __dir__() -> list[str]:
    return __all__


class Report:
    """Numbers of a study, as ``--json`` has them, and its figure where it has one."""

    def __init__(self, data: dict[str, Any], svg: str | None = None) -> None:
        self._data, self._svg = data, svg

    @property
    def data(self) -> dict[str, Any]:
        """All numbers."""
        return self._data

    @property
    def svg(self) -> str | None:
        """The figure, as ``--plot`` draws it."""
        return self._svg

    def __getitem__(self, name: str) -> Any:
        return self._data[name]

    def __repr__(self) -> str:
        return f"<Report of {self._data.get('command', 'a study')}: {', '.join(self._data)}>"

    def _repr_svg_(self) -> str | None:
        return self._svg


def _study(*arguments: str, keywords: Any, plots: bool) -> Report:
    if not plots:
        return Report(command("evaluate", *arguments, **keywords))
    with tempfile.TemporaryDirectory(prefix="burstscope-") as folder:
        plot = Path(folder) / "plot.svg"
        data = command("evaluate", *arguments, plot=plot, **keywords)
        return Report(data, plot.read_text(encoding="utf-8") if plot.exists() else None)


@documented(EvaluateChartKeywords)
def chart(**keywords: Unpack[EvaluateChartKeywords]) -> Report:
    """Methods compared on charts in the dark, with their ROC: ``burstscope evaluate chart``.

    Returns
    -------
    Report
        ``report["rows"]`` has one row a signal-to-noise ratio, with the methods' scores and curves.
    """
    return _study("chart", keywords=keywords, plots=True)


@documented(EvaluateFramesKeywords)
def frames(*inputs: str | os.PathLike[str], **keywords: Unpack[EvaluateFramesKeywords]) -> Report:
    """The effect of the number of frames, on charts or on a burst: ``burstscope evaluate frames``."""
    return _study("frames", *paths(inputs), keywords=keywords, plots=True)


@documented(EvaluateAccuracyKeywords)
def accuracy(**keywords: Unpack[EvaluateAccuracyKeywords]) -> Report:
    """Errors of place, scale and slope on charts: ``burstscope evaluate accuracy``."""
    return _study("accuracy", keywords=keywords, plots=False)


@documented(EvaluateNoiseKeywords)
def noise(**keywords: Unpack[EvaluateNoiseKeywords]) -> Report:
    """False features on pure noise: ``burstscope evaluate noise``."""
    return _study("noise", keywords=keywords, plots=False)


@documented(EvaluateMatchesKeywords)
def matches(*inputs: str | os.PathLike[str], **keywords: Unpack[EvaluateMatchesKeywords]) -> Report:
    """Matches of methods on pairs of bursts: ``burstscope evaluate matches``."""
    return _study("matches", *paths(inputs), keywords=keywords, plots=False)


@documented(EvaluatePosesKeywords)
def poses(**keywords: Unpack[EvaluatePosesKeywords]) -> Report:
    """Camera poses against true ones: ``burstscope evaluate poses``."""
    return _study("poses", keywords=keywords, plots=False)
