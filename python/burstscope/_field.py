"""Motions of all places of a burst."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from burstscope import _burstscope
from burstscope._keywords import DetectorKeywords
from burstscope._progress import Progress, shown
from burstscope._values import Made, documented, path, raw_burst, texts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from burstscope._burst import Burst

_Floats = NDArray[np.float32]


class Field(Made):
    """Motion of each cell of a burst's picture, with its uncertainty. Made by `field`.

    Attributes
    ----------
    motion : float32 [rows, columns, 2]
        Apparent motions, pixels per frame to the right and down; also where they are not known.
    covariance : float32 [rows, columns, 3]
        Covariances of the motions: of u, of u with v, of v, (pixels per frame)².
    known : bool [rows, columns]
        Whether the motion is known in every direction.
    layer : uint8 [rows, columns]
        Motion layers of the cells, from 1, the nearest; 0 for none.
    layers : float32 [n, 4]
        Motions of the layers (u, v), their spreads, pixels per frame, and their shares of the known cells.
    cell_px : int
        Pixels on a side of a cell. Cell (i, j) has its centre at ``(j, i) * cell_px + (cell_px - 1) / 2``.
    burst : Burst
        The burst.
    """

    motion: _Floats
    covariance: _Floats
    known: NDArray[np.bool_]
    layer: NDArray[np.uint8]
    layers: _Floats
    cell_px: int
    burst: Burst

    @classmethod
    def _of(cls, burst: Burst, parts: tuple[Any, ...]) -> Field:
        self = cls.__new__(cls)
        self.motion, self.covariance, self.layer, self.known, self.layers, self.cell_px = parts
        self.burst = burst
        return self

    @property
    def sigma(self) -> _Floats:
        """Standard deviations along the least certain direction [rows, columns], pixels per frame."""
        uu, uv, vv = np.moveaxis(self.covariance.astype(np.float64), 2, 0)
        sigma: _Floats = np.sqrt((uu + vv) / 2 + np.hypot((uu - vv) / 2, uv)).astype(np.float32)
        return sigma

    @property
    def speed(self) -> _Floats:
        """Lengths of the motions [rows, columns], pixels per frame; NaN where they are not known.

        For a camera that moves straight and sideways by b a frame, depth is ``f_px * b / speed``.
        """
        speed: _Floats = np.where(self.known, np.hypot(self.motion[..., 0], self.motion[..., 1]), np.float32("nan"))
        return speed

    def plot(self, ax: Axes | None = None, **how: Any) -> Axes:
        """Draws the lengths of the known motions on axes of matplotlib, with a bar of their colours.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            By default new axes.
        **how
            Given to ``Axes.imshow``: ``cmap``, ``vmin``, ``alpha`` …

        Returns
        -------
        matplotlib.axes.Axes
            In pixels of the burst.

        Raises
        ------
        ImportError
            matplotlib is not installed.
        """
        from burstscope import _plot

        return _plot.field(self, ax, how)

    def __repr__(self) -> str:
        rows, columns = self.known.shape
        return f"<Field: {columns}×{rows} cells of {self.cell_px} px, {self.known.mean():.0%} known, {len(self.layers)} layers>"


@documented(DetectorKeywords)
def field(
    burst: Burst,
    *,
    params: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Field:
    """Finds the motion of every place of a burst, as ``burstscope stack --field``.

    Parameters
    ----------
    burst : Burst
    params, progress, **keywords
        See `burstscope.detect`.

    Returns
    -------
    Field

    Raises
    ------
    ValueError
        A burst that shows no motion: of fewer than 3 frames, smaller than 32 × 32 pixels, or at a single slope.
    """
    file = None if params is None else path("params", params)
    with shown(progress) as tell:
        parts = _burstscope.motion_field(raw_burst(burst), file, texts(keywords), tell)
    if parts is None:
        raise ValueError(
            f"{burst.name}: there is no field of motion: it needs at least 3 frames of 32 × 32 pixels and a range of slopes"
        )
    return Field._of(burst, parts)
