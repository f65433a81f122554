"""Float images that show themselves in notebooks, and those that the steps of the search make."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from burstscope import _burstscope
from burstscope._keywords import DetectorKeywords
from burstscope._progress import Progress, shown
from burstscope._values import pair, raw_burst, texts, whole
from burstscope._values import slope as slope_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from burstscope._burst import Burst

#: Longest side of a picture in a notebook, pixels.
MAX_SIDE = 480
_JPEG_QUALITY = 72


def reduced(array: NDArray[np.float32], max_side: int = MAX_SIDE) -> NDArray[np.float32]:
    """Means of square blocks, so that no side is longer than ``max_side``."""
    rows, columns = array.shape
    factor = -(-max(rows, columns) // max_side)
    if factor <= 1:
        return np.ascontiguousarray(array, np.float32)
    fv, fu = min(factor, rows), min(factor, columns)
    blocks = array[: rows // fv * fv, : columns // fu * fu].reshape(rows // fv, fv, columns // fu, fu)
    return np.ascontiguousarray(blocks.mean((1, 3)), np.float32)


def stretched(array: NDArray[np.float32], signed: bool = False) -> tuple[float, float]:
    """The range that covers nearly all values; symmetric about 0 for values with a sign."""
    if signed:
        limit = float(np.percentile(np.abs(array), 99.8)) or 1.0
        return -limit, limit
    low, high = (float(x) for x in np.percentile(array, [0.1, 99.9]))
    return low, high


def encoded(
    array: NDArray[np.float32],
    limits: tuple[float, float] | None = None,
    colour_map: str = "Grey",
    jpeg_quality: int | None = None,
    signed: bool = False,
) -> bytes:
    """The array as a PNG, or as a JPEG of this quality."""
    limits = stretched(array, signed) if limits is None else limits
    plain = np.ascontiguousarray(np.asarray(array), np.float32)
    return _burstscope.encode_picture(plain, limits, colour_map, jpeg_quality)


def data_uri(array: NDArray[np.float32], **how: Any) -> str:
    """The array as the address of a JPEG that holds its own bytes."""
    jpeg = encoded(array, jpeg_quality=_JPEG_QUALITY, **how)
    return "data:image/jpeg;base64," + base64.b64encode(jpeg).decode()


if TYPE_CHECKING:
    _Array = np.ndarray[Any, np.dtype[np.float32]]
else:
    _Array = np.ndarray


class Image(_Array):
    """An image [H, W], float32, fraction of full scale: a numpy array that shows itself in notebooks.

    Values of an image with a sign (a DoG response) are shown from blue over white to red, others in grey, both stretched
    to the range of nearly all values.
    """

    #: Whether its values have a sign.
    signed: bool

    @classmethod
    def of(cls, array: NDArray[np.float32], signed: bool = False) -> Image:
        """The array as an image; its memory is shared."""
        image = np.asarray(array, np.float32).view(cls)
        image.signed = signed
        return image

    def __array_finalize__(self, made_of: object) -> None:
        self.signed = getattr(made_of, "signed", False)

    def __reduce__(self) -> tuple[Any, ...]:
        return Image.of, (np.array(self), self.signed)

    def png(self, *, limits: tuple[float, float] | None = None, colour_map: str | None = None) -> bytes:
        """The image as a PNG.

        Parameters
        ----------
        limits : (float, float), optional
            Values that become the colour map's first and last colour; by default nearly all values are between them.
        colour_map : str, optional
            One of the window's: Grey, Viridis, Magma, Cividis, Turbo, "Blue – white – red", "Blue – black – orange",
            "Purple – white – green".
        """
        limits = None if limits is None else pair("limits", limits)
        colour_map = colour_map or ("Blue – white – red" if self.signed else "Grey")
        return encoded(self, limits, colour_map, signed=self.signed)

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        if self.ndim != 2 or self.size == 0:
            return {"text/plain": repr(self)}
        small = reduced(np.asarray(self))
        how = {"colour_map": "Blue – white – red", "signed": True} if self.signed else {}
        rows, columns = self.shape
        width = min(columns, MAX_SIDE)
        text = f"Image {rows}×{columns} (rows × columns), {self.min():.5g} to {self.max():.5g}"
        html = f'<img src="{data_uri(small, **how)}" width="{width}"><br><small>{text}</small>'
        return {"text/html": html, "text/plain": text}


def _step(
    burst: Burst,
    kind: str,
    slope: Union[float, tuple[float, float]],
    octave: int,
    level: int,
    progress: Progress,
    keywords: Any,
) -> NDArray[np.float32]:
    asked = {"kind": kind, "slope": slope_of(slope), "octave": whole("octave", octave), "level": whole("level", level)}
    with shown(progress) as tell:
        return _burstscope.step_picture(raw_burst(burst), asked, texts(keywords), tell)


def stack(
    burst: Burst, slope: Union[float, tuple[float, float]], *, progress: Progress = None, **keywords: Unpack[DetectorKeywords]
) -> Image:
    """The motion-stack image: the frames shifted by a slope and averaged, as ``burstscope stack``.

    Frames that are shifted by fractions of a pixel are interpolated, which smooths their noise: at whole slopes an image is
    noisier than between them. To find the slopes of a burst use `burstscope.slopes`, not the sharpness of such images.

    Parameters
    ----------
    burst : Burst
    slope : (u, v) or float
        Pixels per frame, to the right and down; need not be on any grid. One number is u.
    progress : callable, False or None
        See `burstscope.detect`.
    **keywords
        ``frames``, ``rules`` and ``method`` count; see `burstscope.detect`.

    Returns
    -------
    Image
        float32 [H, W], fraction of full scale, at mid-burst.
    """
    return Image.of(_step(burst, "stack", slope, 0, 0, progress, keywords))


def dog(
    burst: Burst,
    slope: Union[float, tuple[float, float]],
    *,
    octave: int = 0,
    level: int = 0,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Image:
    """The DoG response D = G(level + 1) - G(level) of the motion-stack image, as ``burstscope stack --octave --level``.

    Parameters
    ----------
    burst : Burst
    slope : (u, v) or float
        Pixels per frame, to the right and down. One number is u.
    octave, level : int
        Octave, and level in it, -1 to ``levels``. Pixel (i, j) lies at (i, j)·2^octave of the input image.

    Returns
    -------
    Image
        float32 [H, W] on the pixels of the octave, fraction of full scale; bright blobs are negative.
    """
    return Image.of(_step(burst, "dog", slope, octave, level, progress, keywords), signed=True)


def merge(burst: Burst, *, frames: Any = None, progress: Progress = None) -> Image:
    """The frames aligned to the middle one and averaged robustly, as ``burstscope merge``.

    Parameters
    ----------
    burst : Burst
    frames : (a, b), slice or str, optional
        Frames a to b - 1; all of them by default.

    Returns
    -------
    Image
        float32 [H, W], fraction of full scale, at the middle frame.
    """
    return Image.of(_step(burst, "merge", (0.0, 0.0), 0, 0, progress, {"frames": frames}))


def coverage(
    burst: Burst, slope: Union[float, tuple[float, float]], *, progress: Progress = None, **keywords: Unpack[DetectorKeywords]
) -> Image:
    """Share (0 to 1) of the frames that cover each pixel at a slope.

    Returns
    -------
    Image
        float32 [H, W].
    """
    return Image.of(_step(burst, "coverage", slope, 0, 0, progress, keywords))


def noise_map(burst: Burst, keywords: Any, progress: Progress) -> Image:
    """Standard deviation of the noise of one frame by place, fraction of full scale."""
    return Image.of(_step(burst, "noise", (0.0, 0.0), 0, 0, progress, keywords))
