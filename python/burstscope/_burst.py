"""Bursts: frames of one size, in time order."""

from __future__ import annotations

import builtins
import html
import json
import operator
import os
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, Literal, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from burstscope import _burstscope
from burstscope._image import Image, data_uri, reduced, stretched
from burstscope._progress import Progress, shown
from burstscope._values import needed, path, real
from burstscope._values import paths as path_texts

_NATIVE = (np.dtype(np.uint8), np.dtype(np.uint16), np.dtype(np.float32))
# Largest deviation of a frame's time from even spacing, as a part of the interval.
_UNEVEN = 0.01


def _frames(name: str, values: Any) -> Sequence[NDArray[Any]]:
    """The frames of an array [N, H, W], or of a sequence of arrays [H, W], if there is memory for their planes."""
    if isinstance(values, (list, tuple)):
        frames: Any = [np.asarray(frame) for frame in values]
        for frame in frames:
            if frame.ndim != 2:
                raise ValueError(f"{name}: a frame of shape {frame.shape}; give [rows, columns]")
        sizes = [frame.shape for frame in frames]
    else:
        frames = np.asarray(values)
        if frames.ndim == 0:
            raise TypeError(f"{name}: an array is needed, not {type(values).__name__}")
        if frames.ndim == 2 and name != "frames":
            frames = frames[None]
        if frames.ndim != 3:
            colour = frames.ndim == 4 and frames.shape[-1] in (3, 4)
            hint = "; make one channel of the colours first, such as their mean" if colour else ""
            raise ValueError(f"{name}: an array of shape {frames.shape}; give [frames, rows, columns]{hint}")
        sizes = [frames.shape[1:]]
    # By strides an array can be larger than any memory; nothing is copied before this.
    for rows, columns in sizes:
        _burstscope.check_size(name, len(frames), columns, rows)
    return cast("Sequence[NDArray[Any]]", frames)


def _converted(name: str, frames: Sequence[NDArray[Any]]) -> Iterator[NDArray[Any]]:
    """The frames one after the other, contiguous and of a type that is taken, so that only one copy is held."""
    return (_frame(name, frame) for frame in frames)


def _frame(name: str, frame: NDArray[Any]) -> NDArray[Any]:
    kind = frame.dtype.newbyteorder("=")
    if kind in (np.dtype(np.float64), np.dtype(np.float16)):
        kind = np.dtype(np.float32)
    if kind not in _NATIVE:
        raise TypeError(f"{name}: values of type {frame.dtype}; give uint8, uint16 or float32")
    return np.require(frame, kind, ["C", "A"])


class Burst:
    """Frames of one size, in time order, as float32 fractions of full scale.

    Parameters
    ----------
    frames : array [N, H, W], or a sequence of arrays [H, W]
        uint8 and uint16 are divided by 255 and 65535. float32 in [0, 1] is taken as it is and **not copied** where it is
        contiguous: do not write into the array while the burst is in use. Floats above 1 are divided by the
        largest, which `notes` and a warning name; give ``full_scale``, so that bursts have one unit. float64 and
        float16 are converted to float32.
    times : sequence of N numbers, optional
        When the frames were taken, in any unit, rising. Then `frame_interval` and `Detection.velocity` are known. Uneven
        times, as of frames that were dropped, are those at which things are searched; slopes are per frame interval.
    views : str, optional
        Rows and columns of the views of a light field, such as ``"9x9"``, whose frames these are, row by row. An array
        [rows, columns, H, W] is one without.
    bias : array [H, W] or [N, H, W], optional
        Bias frame or frames, which are averaged: subtracted, in the frames' unit.
    flat : array [H, W] or [N, H, W], optional
        Flat frame or frames, which are averaged: the frames are divided by them (less the bias, over their mean).
    mask : array [H, W] or [N, H, W], optional
        Mask of all frames or one a frame, of numbers or bool: what is less than half of white is masked, as is NaN in
        the frames. A masked sample is in no mean and gives no features.
    mask_saturated : bool
        Mask samples at or above the full scale.
    full_scale : float, optional
        Value that becomes 1, such as 4095 for 12 bits in uint16.
    black_level : float, optional
        Value that becomes 0, where there is no bias.
    name : str
        Name for display and for files.

    Raises
    ------
    ValueError
        Arrays of other shapes, infinite values, a bias, flat or mask that does not fit, times that do not rise.
    TypeError
        Values of other types.

    Examples
    --------
    >>> import numpy as np, burstscope as bs
    >>> burst = bs.Burst(np.zeros((5, 48, 64), np.uint8))
    >>> burst.shape
    (5, 48, 64)
    """

    def __init__(
        self,
        frames: Union[ArrayLike, Sequence[ArrayLike]],
        *,
        times: Sequence[float] | NDArray[Any] | None = None,
        views: str | None = None,
        bias: ArrayLike | None = None,
        flat: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        mask_saturated: bool = False,
        full_scale: float | None = None,
        black_level: float | None = None,
        name: str = "burst",
    ) -> None:
        if isinstance(frames, np.ndarray) and frames.ndim == 4 and frames.shape[-1] > 4:
            rows, columns, *size = frames.shape
            views, frames = views or f"{rows}x{columns}", frames.reshape(-1, *size)
        arrays = _frames("frames", frames)
        if times is not None and views is not None:
            raise ValueError("views: the views of a light field have no times; leave out either")
        self._times = None if times is None else _rising(times, len(arrays))
        self._raw = _burstscope.RawBurst.of_arrays(
            needed("name", name, str, "give words"),
            _converted("frames", arrays),
            None if self._times is None or _are_even(self._times) else self._times.tolist(),
            None if views is None else needed("views", views, str, "give ROWSxCOLUMNS"),
            _converted("bias", [] if bias is None else _frames("bias", bias)),
            _converted("flat", [] if flat is None else _frames("flat", flat)),
            _converted("mask", [] if mask is None else _frames("mask", _of_numbers(mask))),
            bool(mask_saturated),
            real("full_scale", full_scale),
            real("black_level", black_level),
        )
        self._inspections: dict[Any, Any] = {}
        if full_scale is None and self.quantisation_step == 0 and self.full_scale != 1:
            message = f"frames: floats above 1; the largest, {self.full_scale:g}, was taken for full scale; give full_scale"
            warnings.warn(message, stacklevel=2)

    @classmethod
    def _of(cls, raw: _burstscope.RawBurst, times: NDArray[np.float64] | None = None) -> Burst:
        burst = cls.__new__(cls)
        if times is None:
            positions, interval_s = raw.positions()
            times = None if interval_s is None else np.asarray(positions) * interval_s
        burst._raw, burst._times, burst._inspections = raw, times, {}
        return burst

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (list(self.seen), self._raw.about(), self._times)

    @property
    def name(self) -> str:
        """Name of the folder or file, or the given one."""
        return self._raw.name

    @property
    def shape(self) -> tuple[int, int, int]:
        """(N, H, W): frames, rows, columns."""
        return self._raw.shape

    @property
    def frame_names(self) -> list[str]:
        """Name of each frame."""
        return self._raw.frame_names

    @property
    def frames(self) -> NDArray[np.float32]:
        """All frames as a new array [N, H, W], fractions of full scale; masked samples are filled from around."""
        return np.stack([self._raw.frame(t) for t in range(len(self))])

    @property
    def seen(self) -> NDArray[np.float32]:
        """All frames as a new array [N, H, W], as `frames`, with NaN where they are masked."""
        return np.stack([self._raw.seen(t) for t in range(len(self))])

    @property
    def views(self) -> tuple[int, int] | None:
        """Rows and columns of the views of a light field; None for frames in time."""
        return self._raw.views

    @property
    def times(self) -> NDArray[np.float64] | None:
        """When the frames were taken, where it is known: as given, or in seconds from the first."""
        return None if self._times is None else self._times.copy()

    @property
    def frame_interval(self) -> float | None:
        """Time from frame to frame, in the unit of `times`."""
        if self._times is None or len(self) < 2:
            return None
        return float(self._times[-1] - self._times[0]) / self._raw.positions()[0][-1]

    @property
    def full_scale(self) -> float:
        """Value of the files or arrays that became 1."""
        return self._raw.full_scale

    @property
    def quantisation_step(self) -> float:
        """Smallest difference that the source can hold, fraction of full scale; 0 for floats."""
        return self._raw.quantisation_step

    @property
    def encoding(self) -> str:
        """Relation of the values to light: ``linear`` or ``srgb``."""
        return self._raw.encoding

    @property
    def binning(self) -> int:
        """Sensor pixels along a side of one pixel: 2 for raw frames, whose colours are binned."""
        return self._raw.binning

    @property
    def notes(self) -> list[str]:
        """Remarks on how the values were read."""
        return self._raw.notes

    @property
    def sources(self) -> list[str]:
        """Files or folders that it was opened from."""
        return [os.fspath(path) for path in self._raw.sources]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, t: int) -> Image:
        """Frame t as an image [H, W]; negative numbers count from the end."""
        try:
            t = operator.index(t)
        except TypeError:
            kind = type(t).__name__
            raise TypeError(f"a frame has a whole number, not {kind}; of several frames make a burst: Burst(burst.frames[2:5])") from None
        index = t + len(self) if t < 0 else t
        if not 0 <= index < len(self):
            raise IndexError(f"there is no frame {t}: the burst has {len(self)}")
        return Image.of(self._raw.frame(index))

    def __iter__(self) -> Iterator[Image]:
        return (self[t] for t in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("the frames lie apart in memory, so an array of all of them is a copy")
        return np.asarray(self.frames, dtype)

    def __repr__(self) -> str:
        frames, rows, columns = self.shape
        return f"<Burst {self.name!r}: {frames} frames of {columns}×{rows} (columns × rows)>"

    def _repr_html_(self) -> str:
        count, rows, columns = self.shape
        middle = reduced(np.asarray(self[count // 2]))
        width = min(columns, middle.shape[1], 480)
        lines = [
            f"<b>{html.escape(self.name)}</b>: {count} frames of {columns}×{rows}, frame {count // 2} below, stretched",
            *(html.escape(note) for note in self.notes),
        ]
        return f'<img src="{data_uri(middle, limits=stretched(middle))}" width="{width}"><br>' + "<br>".join(lines)


def _restored(frames: list[NDArray[np.float32]], about: Any, times: NDArray[np.float64] | None) -> Burst:
    return Burst._of(_burstscope.RawBurst.of_parts(frames, about), times)


def _of_numbers(mask: ArrayLike) -> ArrayLike:
    values = np.asarray(mask)
    return values.view(np.uint8) if values.dtype == np.bool_ else values


def _rising(times: Any, count: int) -> NDArray[np.float64]:
    try:
        values = np.asarray(times, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"times: numbers are needed, not {type(times).__name__}") from None
    if values.shape != (count,) or not np.isfinite(values).all():
        raise ValueError(f"times: {values.shape} values for {count} frames; give one finite number a frame")
    if (np.diff(values) <= 0).any():
        raise ValueError("times: they do not rise from frame to frame; give the frames in time order")
    return values


def _are_even(times: NDArray[np.float64]) -> bool:
    """Whether they are within what a clock's jitter leaves of even, so that positions need no fractions."""
    even = np.linspace(times[0], times[-1], len(times))
    return len(times) < 2 or bool(np.abs(times - even).max() <= _UNEVEN * (even[1] - even[0]))


def open(
    *paths: str | os.PathLike[str],
    bias: str | os.PathLike[str] | None = None,
    flat: str | os.PathLike[str] | None = None,
    full_scale: float | None = None,
    black_level: float | None = None,
    linearise: bool = False,
    accept_damaged: bool = False,
    mask: str | os.PathLike[str] | None = None,
    mask_saturated: bool = False,
    raw_colour: Literal["luma", "green", "red", "blue"] = "luma",
    mosaic: Literal["rggb", "grbg", "gbrg", "bggr", "none"] | None = None,
    raw: str | None = None,
    axis: str | None = None,
    array: str | None = None,
    topic: str | None = None,
    take: str | None = None,
    times: str | os.PathLike[str] | None = None,
    views: str | None = None,
    progress: Progress = None,
) -> Burst:
    """Opens a burst from files, as the window and the commands do.

    Parameters
    ----------
    *paths : path
        A folder of frames (in natural order), several image files (in the order given), a multi-page TIFF, raw files
        (DNG and others), a ``.npy`` stack [N, H, W], ``.npz``, FITS, SER, Y4M, a film (with ``ffmpeg``), a ROS bag or MCAP, or the name of a built-in burst: ``demo``, ``demo-later``.
    bias, flat : path, optional
        Bias and flat frame, or stacks or folders of them, which are averaged.
    full_scale : float, optional
        Value in the files that becomes 1, such as 4095 for 12 bits in 16-bit files.
    black_level : float, optional
        Value in the files that becomes 0.
    linearise : bool
        Undo the sRGB encoding of 8 and 16-bit pictures, so that values are proportional to light.
    accept_damaged : bool
        Take damaged JPEG frames as far as they can be decoded; `Burst.notes` name them.
    mask : path, optional
        Mask of the frames' size, white where they are seen, or a folder with one for each file of frames, named
        ``NAME.EXT.png``, as COLMAP names them, or as the file. What it hides is in no mean and gives no features.
    mask_saturated : bool
        Mask pixels at or above the full scale.
    raw_colour : {"luma", "green", "red", "blue"}
        What is taken of the 2×2 colours of raw frames and mosaics.
    mosaic : {"rggb", "grbg", "gbrg", "bggr", "none"}, optional
        Mosaic of colours of frames whose files do not say that they have one; ``"none"`` leaves each pixel as it is.
    raw : str, optional
        Shape of files without header, such as ``"1600x1200:u16le"``.
    axis : str, optional
        Axis of the frames in a file that has others than time: ``"T"``, ``"Z"``, ``"C"``, ``"T,C=1"``, ``"first"``.
    array : str, optional
        Array of an ``.npz`` archive, image of a FITS or OME file, or track of a film, that holds the frames.
    topic : str, optional
        Topic of a ROS bag or MCAP file that holds the frames, where several hold pictures.
    take : str, optional
        Frames of a long recording that are opened, ``"300..310"``, counted from 0.
    times : str or path, optional
        Times of the frames: a list in a file, ``"names"`` for stamps in the names of files, ``"header"`` for times that
        the files hold (EXIF, FITS, SER, bags), ``"found"`` for those in which the images move uniformly. Without, frames are
        even.
    views : str, optional
        Frames are views of a light field: ``"9x9"`` (rows, columns), ``"9x9:tiled"`` or ``"9x9:eslf"`` for one picture of
        all, ``"names"`` for rows and columns in the names of files, which usual names of a grid need not say.
    progress : callable, False or None
        See `burstscope.detect`.

    Returns
    -------
    Burst

    Raises
    ------
    FileNotFoundError
        There is no such file or folder.
    ValueError
        Files that are no burst: of several sizes, damaged, of several bursts. The message says what would be right.
    """
    calibration: dict[str, Any] = {
        "bias": None if bias is None else path("bias", bias),
        "flat": None if flat is None else path("flat", flat),
        "full_scale": real("full_scale", full_scale),
        "black_level": real("black_level", black_level),
        "linearise": bool(linearise),
        "accept_damaged": bool(accept_damaged),
        "mask": None if mask is None else path("mask", mask),
        "mask_saturated": bool(mask_saturated),
        "raw_colour": needed("raw_colour", raw_colour, str, "give luma, green, red or blue"),
    }
    for name, word in {"mosaic": mosaic, "raw": raw, "axis": axis, "array": array, "topic": topic, "take": take, "views": views}.items():
        calibration[name] = None if word is None else needed(name, word, str, "see the documentation")
    calibration["times"] = None if times is None else path("times", times)
    given = json.dumps({name: value for name, value in calibration.items() if value is not None}, default=os.fspath)
    with shown(progress) as tell:
        return Burst._of(_burstscope.RawBurst.open(path_texts(paths), given, tell))
