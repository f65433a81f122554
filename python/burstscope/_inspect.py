"""Explanations: which slopes a burst needs, why there is a feature at a place or none, and the noise."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

from burstscope import _burstscope
from burstscope._image import Image, noise_map
from burstscope._keywords import DetectorKeywords
from burstscope._progress import Progress, shown
from burstscope._values import documented, pair, path, raw_burst, texts, whole

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from burstscope._burst import Burst


class _Answer:
    """Numbers of an answer, its text and its figure."""

    def __init__(self, answer: tuple[str, str, str]) -> None:
        document, self._text, self._svg = answer
        self._document: dict[str, Any] = json.loads(document)

    @property
    def data(self) -> dict[str, Any]:
        """All numbers, as the command's ``--json`` has them."""
        return self._document

    @property
    def svg(self) -> str:
        """The figure, as the command's ``--plot`` draws it."""
        return self._svg

    def __str__(self) -> str:
        return self._text

    def _repr_svg_(self) -> str:
        return self._svg


class Slopes(_Answer):
    """The slopes that a burst needs. Made by `slopes`; prints as ``burstscope slopes`` does."""

    @property
    def most_features_at(self) -> tuple[float, float] | None:
        """The slope with the most features, not counting the ends of the range."""
        at = self.data["most_features_at"]
        return None if at is None else (at["u"], at["v"])

    @property
    def bars(self) -> list[dict[str, Any]]:
        """Features and evidence at each slope."""
        bars: list[dict[str, Any]] = self.data["spectrum"]["bars"]
        return bars

    @property
    def finding(self) -> dict[str, Any]:
        """The slopes that the frames themselves show."""
        finding: dict[str, Any] = self.data["spectrum"]["finding"]
        return finding

    @property
    def advice(self) -> list[str]:
        """What to change, the most important first; empty where nothing is."""
        return [advice["sentence"] for advice in self.data["spectrum"]["advice"]]

    def __repr__(self) -> str:
        at = self.most_features_at
        most = "no features" if at is None else f"most features at ({at[0]:.2f}, {at[1]:.2f}) px/frame"
        return f"<Slopes: {most}, {len(self.advice)} pieces of advice>"


class Probe(_Answer):
    """The fate of a place. Made by `probe`; prints as ``burstscope probe`` does."""

    @property
    def summary(self) -> str:
        """The answer in a sentence or two."""
        return str(self.data["probe"]["summary"])

    @property
    def fates(self) -> list[dict[str, Any]]:
        """The candidates near the place: their tests, the first one failed, and the keyword that would keep them."""
        fates: list[dict[str, Any]] = self.data["probe"]["fates"]
        return fates

    def __repr__(self) -> str:
        return f"<Probe: {self.summary}>"


class Noise:
    """The noise of a burst, as the search measures it. Made by `noise`."""

    def __init__(self, document: str, picture: Image) -> None:
        self._document: dict[str, Any] = json.loads(document)
        self._picture = picture

    @property
    def data(self) -> dict[str, Any]:
        """All numbers, as ``noise`` of ``burstscope detect --json`` has them."""
        return self._document

    @property
    def frame_noise(self) -> float:
        """Standard deviation of one frame's noise, fraction of full scale."""
        return float(self.data["frame_noise"])

    @property
    def warnings(self) -> list[str]:
        """Faults of the frames that were found: repeated, black or blurred frames, hot pixels, stripes, flicker."""
        return [warning["text"] for warning in self.data["warnings"]]

    @property
    def map(self) -> Image:
        """Standard deviation of one frame's noise by place, fraction of full scale: float32 [H, W]."""
        return self._picture

    def __str__(self) -> str:
        return "\n".join([f"noise of a frame: {self.frame_noise:.5f} of full scale", *self.warnings])

    def __repr__(self) -> str:
        return f"<Noise: {self.frame_noise:.5f} of full scale in a frame, {len(self.warnings)} warnings>"

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        bundle = self.map._repr_mimebundle_()
        lines = [f"noise of a frame by place; {self.frame_noise:.5f} of full scale overall", *self.warnings]
        html = bundle["text/html"] + "<br><small>" + "<br>".join(lines) + "</small>"
        return {"text/html": html, "text/plain": repr(self)}


def _inspection(
    burst: Burst, params: str | os.PathLike[str] | None, keywords: Any, progress: Progress
) -> _burstscope.RawInspection:
    """The search of a burst with what questions need; the last one of a burst is kept."""
    raw, given = raw_burst(burst), texts(keywords)
    file = None if params is None else path("params", params)
    key = (str(file), file.stat().st_mtime_ns if file is not None and file.exists() else 0, tuple(given))
    if key not in burst._inspections:
        with shown(progress) as tell:
            inspection = _burstscope.inspect(raw, file, given, tell)
        burst._inspections.clear()
        burst._inspections[key] = inspection
    kept: _burstscope.RawInspection = burst._inspections[key]
    return kept


@documented(DetectorKeywords)
def slopes(
    burst: Burst,
    *,
    params: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Slopes:
    """Says which slopes a burst needs: its spectrum, what lies at the limit, and what to change.

    Parameters
    ----------
    burst : Burst
    params, progress, **keywords
        See `burstscope.detect`. Without ranges the slopes are found; with ranges they are judged.

    Returns
    -------
    Slopes
        Numbers, text and figure. The search is kept with the burst for the next question with the same keywords.
    """
    inspection = _inspection(burst, params, keywords, progress)
    with shown(progress) as tell:
        return Slopes(inspection.slopes(tell))


@documented(DetectorKeywords)
def probe(
    burst: Burst,
    at: tuple[float, float] | None = None,
    *,
    feature: int | None = None,
    params: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Probe:
    """Says why there is a feature at a place, or why there is none.

    Parameters
    ----------
    burst : Burst
    at : (u, v)
        The place at mid-burst, pixels: column and row, the centre of the first pixel is (0, 0).
    feature : int
        Instead of a place: the feature of this row of `Detection`.
    params, progress, **keywords
        See `burstscope.detect`.

    Returns
    -------
    Probe

    Raises
    ------
    ValueError
        A place outside the image, or no such feature.
    """
    if (at is None) == (feature is None):
        raise ValueError("give either a place, such as (412, 230), or a feature")
    place = None if at is None else pair("at", at)
    feature = None if feature is None else whole("feature", feature, 0)
    inspection = _inspection(burst, params, keywords, progress)
    with shown(progress) as tell:
        return Probe(inspection.probe(place, feature, tell))


@documented(DetectorKeywords)
def noise(
    burst: Burst,
    *,
    params: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Noise:
    """Measures the noise of a burst: by brightness, place and scale, with faulty frames and patterns.

    Parameters
    ----------
    burst : Burst
    params, progress, **keywords
        See `burstscope.detect`.

    Returns
    -------
    Noise
    """
    inspection = _inspection(burst, params, keywords, progress)
    picture = noise_map(burst, keywords, progress)
    return Noise(inspection.noise(), picture)
