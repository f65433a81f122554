"""A slider over slopes that needs no server: its pictures are made beforehand."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from burstscope._image import encoded, reduced, stack, stretched
from burstscope._progress import Progress

if TYPE_CHECKING:
    from burstscope._burst import Burst

_QUALITY = 60


class Slider:
    """Motion-stack images of a burst at several slopes, one of which is shown. Made by `slider`."""

    def __init__(self, title: str, steps: list[tuple[str, bytes]], size: tuple[int, int]) -> None:
        self._title, self._steps, self._size = title, steps, size

    @property
    def html(self) -> str:
        """The slider as HTML that holds its own pictures (JPEG): no script, no server, no other file."""
        start = len(self._steps) // 2
        width, height = self._size
        shown = []
        for index, (label, jpeg) in enumerate(self._steps):
            address = "data:image/jpeg;base64," + base64.b64encode(jpeg).decode()
            hidden = "" if index == start else ' style="display:none"'
            shown.append(
                f'<figure{hidden}><img src="{address}" width="{width}" height="{height}">'
                f"<figcaption>{html.escape(label)}</figcaption></figure>"
            )
        move = (
            "this.parentNode.querySelectorAll('figure')"
            ".forEach((e,i)=>e.style.display=i==this.value?'':'none')"
        )
        return (
            f'<div><b>{html.escape(self._title)}</b><br><input type="range" min="0" max="{len(self._steps) - 1}" '
            f'value="{start}" style="width:{width}px" oninput="{move}">{"".join(shown)}</div>'
        )

    def save(self, path: str | Path) -> Path:
        """Writes the slider as a page that opens in any browser."""
        target = Path(path)
        target.write_text(f'<!doctype html><meta charset="utf-8">{self.html}', encoding="utf-8")
        return target

    def __len__(self) -> int:
        return len(self._steps)

    def __repr__(self) -> str:
        return f"<Slider: {self._title}, {len(self._steps)} slopes>"

    def _repr_html_(self) -> str:
        return self.html


def slider(
    burst: Burst,
    slopes: Sequence[tuple[float, float]] | None = None,
    *,
    count: int = 9,
    max_slope: float = 3.0,
    max_side: int = 320,
    progress: Progress = None,
) -> Slider:
    """Pictures of the burst's motion-stack images at several slopes, with a slider.

    Parameters
    ----------
    burst : Burst
    slopes : sequence of (u, v), optional
        Pixels per frame. By default ``count`` horizontal ones from ``-max_slope`` to ``max_slope``.
    max_side : int
        Longest side of the pictures, pixels. Nine of 320×240 take about 100 to 200 KB.

    Returns
    -------
    Slider
        Shows itself in a notebook; `Slider.save` writes a page.
    """
    if slopes is None:
        slopes = [(float(u), 0.0) for u in np.linspace(-max_slope, max_slope, count)]
    if not slopes:
        raise ValueError("slopes: none is given; give one or more (u, v), pixels per frame")
    images = [reduced(np.asarray(stack(burst, slope, progress=progress)), max_side) for slope in slopes]
    limits = stretched(np.stack(images))
    steps = [
        (f"slope ({u:.2f}, {v:.2f}) px/frame", encoded(image, limits, jpeg_quality=_QUALITY))
        for (u, v), image in zip(slopes, images)
    ]
    rows, columns = images[0].shape
    return Slider(f"{burst.name}: the frames, shifted by a slope and averaged", steps, (columns, rows))
