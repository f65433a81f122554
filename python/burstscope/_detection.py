"""Features of a burst."""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from burstscope import _burstscope, _drawing
from burstscope._keywords import DetectorKeywords
from burstscope._progress import Progress, shown
from burstscope._values import Made, data_frame, documented, hloc_name, raw_burst, texts, write_hdf5
from burstscope._values import path as path_of

if TYPE_CHECKING:
    import cv2
    import h5py
    import pandas
    import pycolmap
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from burstscope._burst import Burst


Array = TypeVar("Array", bound=NDArray[Any])


class Detection(Made):
    """Features of a burst, strongest first, as arrays of one row a feature.

    Made by `detect` and `load`. ``len(d)`` is their number, and ``d[d.snr > 10]`` are some of them. The arrays are made
    once and cannot be written to.
    """

    _burst: Burst | None
    _raw: _burstscope.RawDetection

    @classmethod
    def _of(cls, burst: Burst | None, raw: _burstscope.RawDetection) -> Detection:
        self = cls.__new__(cls)
        self._burst, self._raw = burst, raw
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        raw = self._raw
        parts = (raw.rows(), raw.slope_index(), raw.descriptors(), raw.params_toml(), raw.document())
        return _restored, (self._burst, *parts)

    @property
    def burst(self) -> Burst:
        """The burst that was searched.

        Raises
        ------
        ValueError
            The features are those of a file, and the burst was not given to `load`.
        """
        if self._burst is None:
            raise ValueError("the features were loaded from a file; give their burst too: load(path, burst=burst)")
        return self._burst

    @property
    def has_burst(self) -> bool:
        """Whether `burst` is known: always, but for features of a file."""
        return self._burst is not None

    def _searched(self) -> _burstscope.RawDetection:
        """The detection, if it is known how it was made."""
        if not self._raw.document():
            raise ValueError("the features were loaded from a file, which does not hold how they were searched for")
        return self._raw

    @cached_property
    def xy(self) -> NDArray[np.float32]:
        """Places at mid-burst [n, 2]: column and row, pixels; the centre of the first pixel is (0, 0)."""
        return _fixed(self._raw.xy())

    @cached_property
    def sigma(self) -> NDArray[np.float32]:
        """Scales σ [n], pixels."""
        return _fixed(self._raw.column("sigma"))

    @cached_property
    def angle(self) -> NDArray[np.float32]:
        """Orientations [n], radians from +u towards +v (clockwise on the screen), in (-π, π]."""
        return _fixed(self._raw.column("orientation"))

    @cached_property
    def slope(self) -> NDArray[np.float32]:
        """Apparent motions [n, 2], pixels per frame to the right and down, refined between the slopes searched."""
        return _fixed(self._raw.slope())

    @cached_property
    def response(self) -> NDArray[np.float32]:
        """Interpolated DoG values [n] with their sign, fraction of full scale; bright blobs are negative."""
        return _fixed(self._raw.column("response"))

    @cached_property
    def snr(self) -> NDArray[np.float32]:
        """|response| over the standard deviation of its noise [n]; infinite for a burst without noise."""
        return _fixed(self._raw.column("snr"))

    @cached_property
    def octave(self) -> NDArray[np.int32]:
        """Octaves in which they were found [n]; -1 is the doubled image."""
        return _fixed(self._raw.column("octave"))

    @cached_property
    def level(self) -> NDArray[np.int32]:
        """Levels in the octaves [n]."""
        return _fixed(self._raw.column("level"))

    @cached_property
    def slope_index(self) -> NDArray[np.int64]:
        """Row of `slopes` at which each was found [n]."""
        return _fixed(self._searched().slope_index())

    @cached_property
    def at_slope_limit(self) -> NDArray[np.bool_]:
        """Whether the motion lies beyond the slopes that were searched [n]."""
        return _fixed(self._raw.column("at_slope_limit"))

    @cached_property
    def slope_sigma(self) -> NDArray[np.float32]:
        """Standard deviations of the slopes along their least certain direction [n], pixels per frame."""
        return _fixed(self._raw.column("slope_sigma"))

    @cached_property
    def field(self) -> NDArray[np.float32]:
        """Motions of the features' places, from the field of motion [n, 2], pixels per frame; NaN where unknown."""
        return _fixed(np.column_stack([self._raw.column("field_u"), self._raw.column("field_v")]))

    @cached_property
    def field_sigma(self) -> NDArray[np.float32]:
        """Their standard deviations along the least certain direction [n]; infinite where the motion is unknown."""
        return _fixed(self._raw.column("field_sigma"))

    @cached_property
    def layer(self) -> NDArray[np.int32]:
        """Motion layers that they move with [n], from 1, the nearest; 0 for none."""
        return _fixed(self._raw.column("layer"))

    @cached_property
    def motion(self) -> NDArray[np.str_]:
        """Their motions beside those of their places [n]: "surroundings", "own", "edge", "ghost" or "unknown"."""
        return _fixed(np.array(self._raw.column("motion"), dtype="U12"))

    @cached_property
    def descriptors(self) -> NDArray[np.uint8]:
        """Descriptors [n, 128], uint8, in the order of COLMAP (UBC); compared by Euclidean distance."""
        return _fixed(self._raw.descriptors())

    @cached_property
    def slopes(self) -> NDArray[np.float32]:
        """Slopes that were searched [k, 2], pixels per frame."""
        return _fixed(self._searched().slopes())

    @cached_property
    def strength(self) -> NDArray[np.float32]:
        """|response|·√snr [n], by which they are ordered; |response| without noise."""
        weight = np.where(np.isfinite(self.snr), np.sqrt(self.snr), np.float32(1))
        strength: NDArray[np.float32] = np.abs(self.response) * weight
        return _fixed(strength)

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Apparent motions [n, 2] in pixels per unit of the burst's `times`.

        Raises
        ------
        ValueError
            The burst has no times.
        """
        interval = self.burst.frame_interval
        if interval is None:
            raise ValueError("the burst has no times; give them: Burst(frames, times=...)")
        return self.slope.astype(np.float64) / interval

    @cached_property
    def report(self) -> dict[str, Any]:
        """What ``burstscope detect --json`` says of the burst: noise, tally of rejected samples, slopes, times, advice."""
        document: dict[str, Any] = json.loads(self._searched().document())
        for name in ("open_secs", "write_secs"):
            document["times"].pop(name, None)
        return document

    @property
    def tally(self) -> dict[str, Any]:
        """Numbers of samples that were examined, kept, and rejected by each test."""
        tally: dict[str, Any] = self.report["tally"]
        return tally

    @property
    def advice(self) -> str | None:
        """Why there are few features, where there are few, and the keyword to change, if one that was tried helps."""
        advice = self.report["advice"]
        return None if advice is None else str(advice["message"])

    @property
    def params(self) -> str:
        """The parameters with the slopes that were searched, as a parameter file (TOML)."""
        return self._searched().params_toml()

    def __len__(self) -> int:
        return len(self._raw)

    def __getitem__(self, rows: Union[int, slice, Sequence[int], NDArray[Any]]) -> Detection:
        """Some of the features, by number, slice, mask [n] or indices, in that order: ``found[found.snr > 10]``.

        They can be matched, saved and drawn as all can; `report` and `tally` stay those of the search.

        Raises
        ------
        IndexError
            A number beyond the features, or a mask of another length.
        TypeError
            Anything else than these.
        """
        try:
            numbers = np.atleast_1d(np.arange(len(self))[rows])
        except IndexError as error:
            if isinstance(rows, (str, float)):
                kind = type(rows).__name__
                raise TypeError(
                    f"rows: features have numbers, slices, masks and indices, not {kind}; columns are attributes: found.snr"
                ) from None
            raise error
        return Detection._of(self._burst, self._raw.subset(numbers.tolist()))

    def __iter__(self) -> Iterator[Detection]:
        """Each feature by itself, strongest first."""
        return (self[number] for number in range(len(self)))

    def __repr__(self) -> str:
        if not self._raw.document():
            return f"<Detection: {len(self)} features of a file>"
        rejected = self.tally["samples"] - self.tally["kept"]
        return (
            f"<Detection: {len(self)} features of {self.burst.name!r} at {len(self.slopes)} slopes, "
            f"{rejected} samples rejected>"
        )

    def _repr_html_(self) -> str:
        return _drawing.detection(self) if self.has_burst and self._raw.document() else _drawing.text(self)

    def plot(self, ax: Axes | None = None, *, image: bool | None = None, **how: Any) -> Axes:
        """Draws the features on axes of matplotlib: circles of 2σ with their orientations, coloured by motion.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            By default new axes.
        image : bool, optional
            Draw the motion-stack image at the slope with the most features below them; by default where the burst is
            known and the axes hold no image yet.
        **how
            Given to ``EllipseCollection``: ``linewidths``, ``edgecolors`` …

        Returns
        -------
        matplotlib.axes.Axes
            In pixels, v downwards.

        Raises
        ------
        ImportError
            matplotlib is not installed.
        """
        from burstscope import _plot

        if image is None:
            image = self.has_burst and len(getattr(ax, "images", [])) == 0
        return _plot.detection(self, ax, image, how)

    def save(self, path: str | os.PathLike[str], format: Literal["csv", "colmap", "npz", None] = None) -> Path:
        """Writes the features to a file, as ``burstscope detect --format``.

        Parameters
        ----------
        path : path
            The file; a file of Burstscope's that is there is replaced.
        format : {"csv", "colmap", "npz"}, optional
            By default what the name ends in: ``.csv``, ``.txt`` (COLMAP's importer) or ``.npz``.

        Returns
        -------
        pathlib.Path
        """
        target = path_of("path", path)
        kind = format or {".csv": "csv", ".txt": "colmap", ".npz": "npz"}.get(target.suffix.lower())
        if kind is None:
            raise ValueError(f"{target}: name the file .csv, .txt or .npz, or give format")
        self._raw.write(target, kind)
        return target

    def _table(self) -> dict[str, NDArray[Any]]:
        """The columns of the feature files by their names; motions of places that are not known are NaN."""
        u, v = self.xy.T
        slope_u, slope_v = self.slope.T
        field_u, field_v = self.field.T
        return {
            "u": u, "v": v, "sigma": self.sigma, "orientation": self.angle, "slope_u": slope_u, "slope_v": slope_v,
            "response": self.response, "snr": self.snr, "octave": self.octave, "level": self.level,
            "at_slope_limit": self.at_slope_limit, "slope_sigma": self.slope_sigma, "field_u": field_u,
            "field_v": field_v, "field_sigma": self.field_sigma, "layer": self.layer, "motion": self.motion,
        }  # fmt: skip

    def to_pandas(self) -> pandas.DataFrame:
        """A table of pandas with a row a feature, in the columns of the feature files.

        Raises
        ------
        ImportError
            pandas is not installed.
        """
        return data_frame(self._table())

    def to_napari(self) -> list[tuple[Any, dict[str, Any], str]]:
        """Layers for napari as (data, options, kind): the frames, and the features, which move with the frames.

        ``viewer.add_layer(napari.layers.Layer.create(*layer))`` adds each; a reader of a napari plugin may return them all.
        napari is not needed to make them. Places are (frame, row, column), as napari has them; the rings are of 2σ.
        """
        count, _, _ = self.burst.shape
        t = np.arange(count, dtype=np.float32)
        places = self.xy[None] + (t - np.float32((count - 1) / 2))[:, None, None] * self.slope[None]
        frame = np.broadcast_to(t[:, None], places.shape[:2])
        points = np.stack([frame, places[..., 1], places[..., 0]], 2).reshape(-1, 3)
        rings = {
            "name": f"features of {self.burst.name}",
            "size": np.tile(4 * self.sigma, count),
            "symbol": "ring",
            "face_color": np.tile(np.array(_drawing.colours(self.slope), dtype="U7"), count),
            "features": {name: np.tile(values, count) for name, values in self._table().items()},
        }
        return [(self.burst.frames, {"name": self.burst.name}, "image"), (points, rings, "points")]

    def to_cv2(self) -> tuple[list[cv2.KeyPoint], NDArray[np.float32]]:
        """OpenCV's keypoints and descriptors, as ``detectAndCompute`` returns them.

        The size of a keypoint is 2σ, its angle degrees clockwise in [0, 360), its response the strength, its octave that
        of the search; ``class_id`` is the row of the feature. Descriptors are float32 [n, 128], for ``cv2.NORM_L2``.

        Raises
        ------
        ImportError
            OpenCV (``opencv-python``) is not installed.
        """
        import cv2

        degrees = np.degrees(self.angle.astype(np.float64)) % 360.0
        rows = zip(self.xy.tolist(), self.sigma.tolist(), degrees.tolist(), self.strength.tolist(), self.octave.tolist())
        keypoints = [
            cv2.KeyPoint(x, y, 2 * sigma, angle, strength, octave, index)
            for index, ((x, y), sigma, angle, strength, octave) in enumerate(rows)
        ]
        return keypoints, self.descriptors.astype(np.float32)

    def _unit_descriptors(self) -> NDArray[np.float32]:
        """Descriptors of length 1 [n, 128]."""
        rows = self.descriptors.astype(np.float32)
        unit: NDArray[np.float32] = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), np.float32(1e-6))
        return unit

    def to_hloc(self) -> dict[str, NDArray[Any]]:
        """What hloc keeps of the features of an image: ``keypoints`` [n, 2], ``scores``, ``scales`` and ``oris`` [n] and
        ``descriptors`` [128, n], all float32, and ``image_size`` [2], columns and rows, int64.

        Keypoints are `xy`: hloc, too, has the centre of the first pixel at (0, 0). Scores are `strength`, scales `sigma`,
        oris `angle`; descriptors have length 1.

        Raises
        ------
        ValueError
            The burst, and so the size of the image, is not known.
        """
        _, rows, columns = self.burst.shape
        return {
            "keypoints": self.xy,
            "scores": self.strength,
            "scales": self.sigma,
            "oris": self.angle,
            "descriptors": np.ascontiguousarray(self._unit_descriptors().T),
            "image_size": np.array([columns, rows], np.int64),
        }

    def write_hloc(self, file: Union[str, os.PathLike[str], h5py.File], name: str) -> None:
        """Writes `to_hloc` into hloc's file of features (HDF5), in place of features of the same image.

        Parameters
        ----------
        file : path, or h5py.File
            Such as ``features.h5``; a file that is not there is made.
        name : str
            The name of the image, as hloc has it in its lists: its path below the folder of the images.

        Raises
        ------
        ImportError
            h5py is not installed.
        ValueError
            A name with a space; a burst that is not known.
        """
        write_hdf5(file, hloc_name("name", name), self.to_hloc())

    def to_lightglue(self) -> dict[str, NDArray[np.float32]]:
        """What LightGlue takes of an image with its weights for SIFT, float32: ``keypoints`` [1, n, 2], ``scales``, ``oris``
        and ``keypoint_scores`` [1, n], ``descriptors`` [1, n, 128], and ``image_size`` [1, 2], columns and rows.

        ``{name: torch.from_numpy(values) for name, values in found.to_lightglue().items()}`` are its tensors; the matches
        that it returns are rows of the features. Places are COLMAP's, with the centre of the first pixel at (0.5, 0.5), as
        of the SIFT with which those weights were trained; scales are `sigma`, oris `angle`, keypoint_scores `strength`, and
        descriptors have length 1. ``found[:2048]`` are the strongest 2048.

        Raises
        ------
        ValueError
            The burst, and so the size of the image, is not known.
        """
        arrays = self.to_hloc()
        named = {"keypoint_scores": arrays["scores"], "keypoints": self.to_colmap()[:, :2], "descriptors": arrays["descriptors"].T}
        named |= {name: arrays[name] for name in ("scales", "oris", "image_size")}
        # Copies, because a tensor could be written to.
        return {name: np.array(values, np.float32, order="C")[None] for name, values in named.items()}

    def to_colmap(self) -> NDArray[np.float32]:
        """COLMAP's keypoints [n, 4]: x, y, scale, orientation; the centre of the first pixel is (0.5, 0.5)."""
        half = np.float32(0.5)
        return np.column_stack([self.xy + half, self.sigma, self.angle]).astype(np.float32)

    def write_colmap(self, database: Union[str, os.PathLike[str], pycolmap.Database], image_id: int) -> None:
        """Writes keypoints and descriptors of an image into a database of COLMAP.

        Parameters
        ----------
        database : pycolmap.Database, or path
            An open database, or the path of one that is there, which is opened by pycolmap and closed again.
        image_id : int
            The image, which is in the database and has no features there yet.

        Raises
        ------
        ImportError
            pycolmap is not installed.
        ValueError
            There is no such image, or it has features already.
        FileNotFoundError
            There is no such database.
        """
        import pycolmap

        if isinstance(database, (str, os.PathLike)):
            path = Path(database)
            if not path.is_file():
                raise FileNotFoundError(f"there is no such database; make it first: {path}")
            with pycolmap.Database.open(path) as opened:
                self.write_colmap(opened, image_id)
            return
        if not database.exists_image(image_id):
            raise ValueError(f"image_id: the database has no image {image_id}; write the image first")
        if database.exists_keypoints(image_id) or database.exists_descriptors(image_id):
            raise ValueError(f"image_id: image {image_id} has features already; clear them first")
        database.write_keypoints(image_id, self.to_colmap())
        kind = pycolmap.FeatureExtractorType.SIFT
        database.write_descriptors(image_id, pycolmap.FeatureDescriptors(type=kind, data=self.descriptors))


def _fixed(array: Array) -> Array:
    array.flags.writeable = False
    return array


def strongest_slope(found: Detection) -> tuple[float, float]:
    """The searched slope at which most features were found; (0, 0) without features."""
    if len(found) == 0:
        return 0.0, 0.0
    if not found._raw.document():
        u, v = np.median(found.slope, 0).tolist()
        return u, v
    index = int(np.bincount(found.slope_index).argmax())
    u, v = (float(x) for x in found.slopes[index])
    return (u, v) if math.isfinite(u) and math.isfinite(v) else (0.0, 0.0)


def _restored(burst: Burst | None, *parts: Any) -> Detection:
    return Detection._of(burst, _burstscope.RawDetection.of_rows(*parts))


def load(path: str | os.PathLike[str], burst: Burst | None = None) -> Detection:
    """Loads the features that `Detection.save` or ``burstscope detect --format npz`` wrote.

    Parameters
    ----------
    path : path
        The file, ``.npz``.
    burst : Burst, optional
        The burst that was searched, for pictures.

    Returns
    -------
    Detection
        Its arrays and descriptors, to be matched, masked and drawn. The file does not hold how the features were searched
        for: `Detection.report`, `params`, `slopes` and `slope_index` are not known. To keep all of it, pickle a
        `Detection`.

    Raises
    ------
    ValueError
        The file holds no features of Burstscope.
    FileNotFoundError
        There is no such file.
    """
    target = path_of("path", path)
    if burst is not None:
        raw_burst(burst)
    try:
        with np.load(target, allow_pickle=False) as file:
            rows, descriptors = file["features"], file["descriptors"]
        index = np.zeros(len(rows), np.int64)
        return _restored(burst, rows.astype(np.float32, copy=False), index, descriptors.astype(np.uint8, copy=False), "", "")
    except (AttributeError, KeyError, TypeError, ValueError, zipfile.BadZipFile):
        raise ValueError(f"{target}: no features of Burstscope; give the .npz that save or detect wrote") from None


@documented(DetectorKeywords)
def detect(
    burst: Burst,
    *,
    params: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **keywords: Unpack[DetectorKeywords],
) -> Detection:
    """Finds the burst features of a burst; the same bits as ``burstscope detect`` gives.

    Parameters
    ----------
    burst : Burst
        The frames.
    params : path, optional
        A parameter file (TOML), as the window saves it; keywords override it.
    progress : callable, False or None
        ``None`` shows progress on a terminal and in a notebook, ``False`` nowhere; a function gets the name of the stage
        and the finished fraction (0 to 1), and cancels the work by raising an exception.
    **keywords
        The parameters, below. Ranges of slopes are (min, max, count), evenly spaced slopes as of ``np.linspace``, one
        number or "MIN:MAX:COUNT"; frames (a, b), a slice or "A..B".

    Returns
    -------
    Detection
        Features, strongest first.

    Raises
    ------
    ValueError
        A parameter that makes no sense, alone or for this burst; the message says what would be right.
    TypeError
        A keyword that does not exist, or a value of another type.
    KeyboardInterrupt
        Ctrl-C.
    """
    with shown(progress) as tell:
        file = None if params is None else path_of("params", params)
        return Detection._of(burst, _burstscope.detect(raw_burst(burst), file, texts(keywords), tell))
