"""Drawings of features and matches for notebooks: SVG over a small picture."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from burstscope._image import data_uri, reduced, stack

if TYPE_CHECKING:
    from burstscope._detection import Detection
    from burstscope._matches import Matches

# Features and matches that are drawn: the strongest, or an even choice.
_FEATURES_DRAWN = 400
_LINES_DRAWN = 150
_WIDTH = 480
# From slow to fast along the main direction of motion: blue to vermilion, which colour-blind readers tell apart.
_SLOW, _FAST = np.array([0, 114, 178]), np.array([240, 120, 20])
_INLIER, _OTHER = "#f0e442", "#d55e00"


def colours(slopes: NDArray[np.float32]) -> list[str]:
    """A colour for each slope, by its place along the main direction."""
    if len(slopes) == 0:
        return []
    centred = slopes - slopes.mean(0)
    direction = np.linalg.svd(centred, full_matrices=False)[2][0]
    along = slopes @ (direction if direction[np.abs(direction).argmax()] > 0 else -direction)
    low, high = float(along.min()), float(along.max())
    position = (along - low) / (high - low) if high > low else np.full(len(along), 0.5)
    mixed = _SLOW + position[:, None] * (_FAST - _SLOW)
    return ["#{:02x}{:02x}{:02x}".format(*row) for row in mixed.round().astype(int).tolist()]


def text(value: object) -> str:
    """What has no picture, as text."""
    return f"<code>{html.escape(repr(value))}</code>"


def _picture(found: Detection) -> tuple[str, int, int]:
    """Motion-stack image at the slope with the most features: its address, columns and rows."""
    from burstscope._detection import strongest_slope

    image = stack(found.burst, strongest_slope(found), progress=False)
    rows, columns = image.shape
    return data_uri(reduced(np.asarray(image))), columns, rows


def detection(found: Detection) -> str:
    """The strongest features over the motion-stack image at the slope with the most."""
    address, columns, rows = _picture(found)
    count = min(len(found), _FEATURES_DRAWN)
    marks = []
    places = zip(
        found.xy[:count].tolist(), found.sigma[:count].tolist(), found.angle[:count].tolist(), colours(found.slope[:count])
    )
    for (u, v), sigma, angle, colour in places:
        radius = 2 * sigma
        x, y = u + radius * np.cos(angle), v + radius * np.sin(angle)
        marks.append(
            f'<g stroke="{colour}"><circle cx="{u:.1f}" cy="{v:.1f}" r="{radius:.1f}"/>'
            f'<path d="M{u:.1f} {v:.1f}L{x:.1f} {y:.1f}"/></g>'
        )
    width = min(columns, _WIDTH)
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" viewBox="-0.5 -0.5 {columns} {rows}">'
        f'<image href="{address}" x="-0.5" y="-0.5" width="{columns}" height="{rows}" preserveAspectRatio="none"/>'
        f'<g fill="none" stroke-width="{1.2 * columns / width:.2f}">{"".join(marks)}</g></svg>'
    )
    strongest = "" if count == len(found) else f", the {count} strongest drawn"
    about = f"{len(found)} features at {len(found.slopes)} slopes{strongest}; blue to orange by motion, circles of 2σ"
    advice = "" if found.advice is None else f"<br><small>{html.escape(found.advice)}</small>"
    return f"{svg}<br><small>{about}</small>{advice}"


def matches(matched: Matches) -> str:
    """Both bursts side by side with matches between them."""
    (left, columns_a, rows_a), (right, columns_b, rows_b) = _picture(matched.a), _picture(matched.b)
    gap = 8
    columns, rows = columns_a + gap + columns_b, max(rows_a, rows_b)
    inliers = matched.inliers
    drawn = np.arange(len(matched)) if inliers is None else np.flatnonzero(inliers)
    if len(drawn) > _LINES_DRAWN:
        drawn = drawn[np.linspace(0, len(drawn) - 1, _LINES_DRAWN).astype(int)]
    ends = np.hstack([matched.xy_a[drawn], matched.xy_b[drawn] + [columns_a + gap, 0]])
    lines = "".join(f'<path d="M{x:.1f} {y:.1f}L{z:.1f} {w:.1f}"/>' for x, y, z, w in ends.tolist())
    width = min(columns, 2 * _WIDTH)
    colour = _OTHER if inliers is None else _INLIER
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" viewBox="-0.5 -0.5 {columns} {rows}">'
        f'<image href="{left}" x="-0.5" y="-0.5" width="{columns_a}" height="{rows_a}" preserveAspectRatio="none"/>'
        f'<image href="{right}" x="{columns_a + gap - 0.5}" y="-0.5" width="{columns_b}" height="{rows_b}" '
        f'preserveAspectRatio="none"/>'
        f'<g fill="none" stroke="{colour}" stroke-opacity="0.8" stroke-width="{columns / width:.2f}">{lines}</g></svg>'
    )
    counts = matched.counts
    verified = "not verified" if inliers is None else f"{counts['inliers']} inliers of the {matched.geometry_name or 'geometry'}"
    return f"{svg}<br><small>{counts['putative']} putative matches, {verified}; {len(drawn)} drawn</small>"
