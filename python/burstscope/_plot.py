"""Drawings on axes of matplotlib, which is imported only here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from burstscope import _drawing
from burstscope._image import stack, stretched

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from burstscope._detection import Detection
    from burstscope._field import Field
    from burstscope._matches import Matches


def _axes(ax: Axes | None) -> Axes:
    """The axes, or new ones."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError("matplotlib, which plots need, is not installed: pip install matplotlib") from None
    from matplotlib.axes import Axes

    if ax is None:
        return plt.subplots()[1]
    if isinstance(ax, Axes):
        return ax
    raise TypeError(f"ax: axes of matplotlib are needed, not {type(ax).__name__}; make them, plt.subplots()")


def _grey(ax: Axes, image: NDArray[np.float32]) -> None:
    low, high = stretched(image)
    ax.imshow(image, cmap="gray", vmin=low, vmax=high, interpolation="nearest")


def detection(found: Detection, ax: Axes | None, image: bool, how: dict[str, Any]) -> Axes:
    """Features as circles of 2σ with their orientations, over the motion-stack image at the slope with the most."""
    from burstscope._detection import strongest_slope

    ax = _axes(ax)
    from matplotlib.collections import EllipseCollection, LineCollection

    if image:
        _grey(ax, np.asarray(stack(found.burst, strongest_slope(found), progress=False)))
    sides = 4 * found.sigma
    colours = _drawing.colours(found.slope)
    ends = found.xy + 2 * found.sigma[:, None] * np.column_stack([np.cos(found.angle), np.sin(found.angle)])
    style: dict[str, Any] = {"linewidths": 0.8, "edgecolors": colours, "facecolors": "none", **how}
    circles = EllipseCollection(sides, sides, np.zeros(len(found)), units="xy", offsets=found.xy, transOffset=ax.transData, **style)
    ax.add_collection(circles)
    ticks = list(np.stack([found.xy, ends], 1))
    ax.add_collection(LineCollection(ticks, colors=style["edgecolors"], linewidths=style["linewidths"]))
    _in_pixels(ax, found)
    return ax


def _in_pixels(ax: Axes, found: Detection) -> None:
    """Limits of the burst's picture, with v downwards; of the features, where the burst is not known."""
    if found.has_burst:
        _, rows, columns = found.burst.shape
        ax.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5))
    else:
        ax.autoscale_view()
        if not ax.yaxis_inverted():
            ax.invert_yaxis()
    ax.set(aspect="equal", xlabel="u, px", ylabel="v, px")


def matches(
    matched: Matches, ax: Axes | None, which: NDArray[np.bool_], as_found: bool, how: dict[str, Any]
) -> Axes:
    """Both bursts side by side, with lines between matched places, after the alignment or as found."""
    from burstscope._detection import strongest_slope

    ax = _axes(ax)
    from matplotlib.collections import LineCollection

    images = [np.asarray(stack(found.burst, strongest_slope(found), progress=False)) for found in (matched.a, matched.b)]
    rows, gap = max(len(image) for image in images), 8
    shift = images[0].shape[1] + gap
    both = np.full((rows, shift + images[1].shape[1]), np.nan, np.float32)
    for image, left in zip(images, (0, shift)):
        low, high = stretched(image)
        both[: len(image), left : left + image.shape[1]] = (image - low) / max(high - low, 1e-12)
    ax.imshow(both, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    inliers = np.zeros(len(matched), bool) if matched.inliers is None else matched.inliers
    colours = np.where(inliers, "#e69f00", "#cc79a7" if matched.inliers is not None else "#56b4e9")
    of_a, of_b = (matched.xy_a, matched.xy_b) if as_found else (matched.aligned_a, matched.aligned_b)
    lines = np.stack([of_a, of_b + np.array([shift, 0], np.float32)], 1)
    style: dict[str, Any] = {"colors": list(colours[which]), "linewidths": 0.6, "alpha": 0.8, **how}
    ax.add_collection(LineCollection(list(lines[which]), **style))
    ax.set_axis_off()
    ax.set_title(f"{which.sum()} of {len(matched)} matches drawn, {inliers.sum()} inliers", fontsize="small")
    return ax


def field(motions: Field, ax: Axes | None, how: dict[str, Any]) -> Axes:
    """Lengths of the known motions, with a bar of their colours."""
    ax = _axes(ax)
    rows, columns = np.array(motions.known.shape) * motions.cell_px
    style: dict[str, Any] = {"cmap": "viridis", "interpolation": "nearest", **how}
    extent = (-0.5, columns - 0.5, rows - 0.5, -0.5)
    drawn = ax.imshow(np.ma.masked_invalid(motions.speed), extent=extent, **style)
    _, height, width = motions.burst.shape
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xlabel="u, px", ylabel="v, px")
    ax.figure.colorbar(drawn, ax=ax, label="motion, px/frame")
    return ax
