"""Matches of two bursts."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import NDArray

from burstscope import _burstscope, _drawing
from burstscope._detection import Detection, _fixed
from burstscope._keywords import MatchKeywords
from burstscope._progress import Progress, shown
from burstscope._values import Given, Made, data_frame, documented, hloc_name, needed, texts, write_hdf5
from burstscope._values import path as path_of

if TYPE_CHECKING:
    import h5py
    import pandas
    import pycolmap
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    _Camera = Union[str, os.PathLike[str], pycolmap.Camera]


class Matches(Made):
    """Putative matches of two detections, and which of them agree with a geometry of the two views. Made by `match`.

    A pickle holds both detections and the parameters; matching, which gives the same bits again, is done anew.
    """

    _a: Detection
    _b: Detection
    _asked: tuple[list[str], Given]
    _raw: _burstscope.RawMatches

    @classmethod
    def _of(cls, a: Detection, b: Detection, asked: tuple[list[str], Given], progress: Progress = False) -> Matches:
        self = cls.__new__(cls)
        self._a, self._b, self._asked = a, b, asked
        with shown(progress) as tell:
            self._raw = _burstscope.match_features(_side(a), _side(b), *asked, tell)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Matches._of, (self._a, self._b, self._asked)

    @property
    def a(self) -> Detection:
        """The first detection."""
        return self._a

    @property
    def b(self) -> Detection:
        """The second detection."""
        return self._b

    @cached_property
    def pairs(self) -> NDArray[np.int64]:
        """Rows of the features in A and B [m, 2], in the order of A's."""
        return _fixed(self._raw.pairs())

    @cached_property
    def xy_a(self) -> NDArray[np.float32]:
        """Places in A as they were found [m, 2], pixels: those of `a`."""
        return _fixed(self.a.xy[self.pairs[:, 0]])

    @cached_property
    def xy_b(self) -> NDArray[np.float32]:
        """Places in B as they were found [m, 2], pixels: those of `b`."""
        return _fixed(self.b.xy[self.pairs[:, 1]])

    @cached_property
    def aligned_a(self) -> NDArray[np.float32]:
        """Places in A after the alignment [m, 2], pixels, on which `inliers`, `error_px` and `geometry` are based; as found
        where nothing was measured, and with ``align=False``."""
        return _fixed(self._raw.aligned()[:, 0])

    @cached_property
    def aligned_b(self) -> NDArray[np.float32]:
        """Places in B after the alignment [m, 2], pixels; see `aligned_a`."""
        return _fixed(self._raw.aligned()[:, 1])

    @cached_property
    def shift(self) -> NDArray[np.float64]:
        """From the places found in B to where the pictures of those in A are seen there [m, 2], pixels; NaN where the
        pictures do not tell, or were not compared."""
        return _fixed(self._raw.measured()[:, :2])

    @cached_property
    def correlation(self) -> NDArray[np.float64]:
        """Correlations of the pictures of both places, laid over one another [m], -1 to 1; NaN as in `shift`."""
        return _fixed(self._raw.measured()[:, 2])

    @cached_property
    def how(self) -> NDArray[np.str_]:
        """How each match was found [m]: ``sure``, by descriptors alone, or ``predicted``, where its motion puts it."""
        return _fixed(np.array(self._raw.how(), dtype=np.str_))

    @cached_property
    def distance(self) -> NDArray[np.float32]:
        """Euclidean distances of the descriptors [m]."""
        return _fixed(self._raw.distance())

    @cached_property
    def ratio(self) -> NDArray[np.float32]:
        """Ratios of that distance to the one to the second nearest descriptor of those compared [m], 0 to 1; NaN without a
        second. Of sure matches all were compared, of predicted ones those where the motion puts it."""
        return _fixed(self._raw.ratio())

    @cached_property
    def inliers(self) -> NDArray[np.bool_] | None:
        """Whether each match agrees with the geometry [m]; ``None`` for ``geometry="none"``."""
        inliers = self._raw.inliers()
        return None if inliers is None else _fixed(inliers)

    @cached_property
    def error_px(self) -> NDArray[np.float32] | None:
        """Error of each match under the geometry, at its aligned places [m], pixels; NaN without a geometry."""
        error = self._raw.error_px(False)
        return None if error is None else _fixed(error)

    @property
    def refused(self) -> str | None:
        """Why the pair was refused although enough matches agreed on a geometry; ``None`` where it was not."""
        return self._raw.refused()

    @cached_property
    def geometry(self) -> NDArray[np.float64] | None:
        """The 3×3 matrix on which the inliers agree, from A to B; ``None`` where too few agree on any.

        It is that of the aligned places. For a fundamental matrix x_b·F·x_a = 0 with x = (u, v, 1) in pixels, the centre of the first pixel at (0, 0); an
        essential matrix is for directions of the camera.
        """
        geometry = self._raw.geometry()
        return None if geometry is None else _fixed(geometry[1])

    @property
    def geometry_name(self) -> str | None:
        """``fundamental``, ``essential`` or ``homography``; ``None`` without a geometry."""
        geometry = self._raw.geometry()
        return None if geometry is None else geometry[0]

    @cached_property
    def counts(self) -> dict[str, Any]:
        """Numbers of keypoints, putative matches and inliers, and the ratios, as ``burstscope match --json``."""
        counts: dict[str, Any] = json.loads(self._raw.counts())
        return counts

    @cached_property
    def params(self) -> dict[str, Any]:
        """The parameters of matching."""
        params: dict[str, Any] = json.loads(self._raw.params())
        return params

    def png(self) -> bytes:
        """The figure of both bursts with the matches between them, as ``burstscope match`` draws it (PNG)."""
        picture = self._raw.picture((self.a.burst._raw, self.a._raw), (self.b.burst._raw, self.b._raw))
        return bytes(picture)

    def plot(
        self,
        ax: Axes | None = None,
        *,
        which: NDArray[np.bool_] | None = None,
        drawn: int | None = 100,
        as_found: bool = False,
        **how: Any,
    ) -> Axes:
        """Draws both bursts side by side with lines between the places of matches, on axes of matplotlib.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            By default new axes.
        which : bool array [m], optional
            The matches that are drawn: by default the inliers, or all where there is no geometry.
            ``~matches.inliers`` are the outliers, ``matches.distance < 80`` those that are most alike.
        drawn : int or None, default 100
            How many of these are drawn, the most alike first, as ``burstscope match --drawn`` says; ``None`` for all.
        as_found : bool, default False
            Whether lines end where features were found, `xy_a` and `xy_b`, and not at the places after the alignment,
            `aligned_a` and `aligned_b`, which `inliers` and `geometry` are about.
        **how
            Given to ``LineCollection``: ``linewidths``, ``colors`` …

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ImportError
            matplotlib is not installed.
        """
        from burstscope import _plot

        chosen = self._chosen(self.inliers if which is None else which)
        if drawn is not None:
            best = np.argsort(np.where(chosen, self.distance, np.inf), kind="stable")[: max(drawn, 0)]
            chosen = chosen & np.isin(np.arange(len(self)), best)
        return _plot.matches(self, ax, chosen, as_found, how)

    def to_pandas(self) -> pandas.DataFrame:
        """A table of pandas with a row a match and the columns of the CSV file that ``burstscope match`` writes: NaN where a
        cell is empty there.

        Raises
        ------
        ImportError
            pandas is not installed.
        """
        none = np.full(len(self), np.nan, np.float32)
        as_found = self._raw.error_px(True)
        columns: dict[tuple[str, ...], Any] = {
            ("a", "b"): self.pairs,
            ("u_a", "v_a"): self.xy_a,
            ("u_b", "v_b"): self.xy_b,
            ("distance",): self.distance,
            ("ratio",): self.ratio,
            ("error_px",): none if self.error_px is None else self.error_px,
            ("inlier",): none if self.inliers is None else self.inliers.astype(np.int64),
            ("shift_u_b", "shift_v_b"): self.shift,
            ("correlation",): self.correlation,
            ("how",): self.how,
            ("among",): self._raw.among(),
            ("ratio_among_all",): self._raw.ratio_among_all(),
            ("aligned_u_a", "aligned_v_a"): self.aligned_a,
            ("aligned_u_b", "aligned_v_b"): self.aligned_b,
            ("error_found_px",): none if as_found is None else as_found,
        }
        rows = ((names, values.reshape(len(self), -1)) for names, values in columns.items())
        return data_frame({name: values[:, k] for names, values in rows for k, name in enumerate(names)})

    def _chosen(self, which: Any) -> NDArray[np.bool_]:
        """The argument ``which`` as an array, of all for ``None``."""
        chosen = np.ones(len(self), bool) if which is None else np.asarray(which)
        if chosen.shape != (len(self),) or chosen.dtype != bool:
            raise ValueError(f"which: an array of {chosen.dtype} {chosen.shape}; give a bool for each of the {len(self)} matches")
        return chosen

    def to_hloc(self, which: NDArray[np.bool_] | None = None) -> dict[str, NDArray[Any]]:
        """What hloc keeps of a pair of images: ``matches0`` [n], for each feature of A the row of B's, or -1 (int32), and
        ``matching_scores0`` [n], 0 without a match (float32).

        As of hloc's nearest neighbours, the score is (1 + c)/2 with the cosine c of the angle between both descriptors.

        Parameters
        ----------
        which : bool array [m], optional
            The matches: by default all putative ones, which hloc has COLMAP verify. ``matches.inliers`` are verified.

        Raises
        ------
        ValueError
            An array that has not a bool for each match.
        """
        chosen = self._chosen(which)
        a, b = self.pairs[chosen].T
        rows, scores = np.full(len(self.a), -1, np.int32), np.zeros(len(self.a), np.float32)
        # Descriptors have length 512.
        rows[a], scores[a] = b, 1 - (self.distance[chosen] / 512) ** 2 / 4
        return {"matches0": rows, "matching_scores0": scores.clip(0, 1)}

    def write_hloc(
        self,
        file: Union[str, os.PathLike[str], h5py.File],
        name_a: str,
        name_b: str,
        which: NDArray[np.bool_] | None = None,
    ) -> None:
        """Writes `to_hloc` into hloc's file of matches (HDF5), in place of matches of the same two images in this order.

        Parameters
        ----------
        file : path, or h5py.File
            Such as ``matches.h5``; a file that is not there is made.
        name_a, name_b : str
            The names of the images, as for `Detection.write_hloc`; a line ``name_a name_b`` in hloc's list of pairs asks
            for them.
        which : bool array [m], optional
            As of `to_hloc`.

        Raises
        ------
        ImportError
            h5py is not installed.
        ValueError
            A name with a space.
        """
        names = [hloc_name(name, value) for name, value in (("name_a", name_a), ("name_b", name_b))]
        # A pair is a group of two names, in which folders are joined to the name.
        write_hdf5(file, "/".join(name.replace("/", "-") for name in names), self.to_hloc(which))

    def write_colmap(self, database: Union[str, os.PathLike[str], pycolmap.Database], id_a: int, id_b: int) -> None:
        """Writes the putative matches of two images into a database of COLMAP, which verifies them itself.

        The features there lie where they were found: `burstscope.colmap` writes aligned ones, which are about twice as
        exact, with verified matches of all pairs.

        Parameters
        ----------
        database : pycolmap.Database, or path
            As for `Detection.write_colmap`.
        id_a, id_b : int
            The images, whose features are in the database.

        Raises
        ------
        ImportError
            pycolmap is not installed.
        ValueError
            The pair has matches already.
        """
        import pycolmap

        if isinstance(database, (str, os.PathLike)):
            path = Path(database)
            if not path.is_file():
                raise FileNotFoundError(f"there is no such database; make it first: {path}")
            with pycolmap.Database.open(path) as opened:
                self.write_colmap(opened, id_a, id_b)
            return
        if database.exists_matches(id_a, id_b):
            raise ValueError(f"the database has matches of the images {id_a} and {id_b} already; clear them first")
        database.write_matches(id_a, id_b, self.pairs.astype(np.uint32))

    def __len__(self) -> int:
        return len(self._raw)

    def __repr__(self) -> str:
        counts = self.counts
        inliers = "not verified" if counts["inliers"] is None else f"{counts['inliers']} inliers"
        return f"<Matches of {_name(self.a)} and {_name(self.b)}: {len(self)} putative, {inliers}>"

    def _repr_html_(self) -> str:
        return _drawing.matches(self) if self.a.has_burst and self.b.has_burst else _drawing.text(self)


def _side(found: Detection) -> tuple[_burstscope.RawBurst | None, _burstscope.RawDetection]:
    return found._burst._raw if found._burst is not None else None, found._raw


def _name(found: Detection) -> str:
    return repr(found.burst.name) if found.has_burst else "a file"


def _camera_text(camera: Any) -> str:
    if isinstance(camera, str):
        return camera
    if isinstance(camera, os.PathLike):
        return str(os.fspath(camera))
    try:
        model = getattr(camera.model, "name", camera.model)
        values = [model, camera.width, camera.height, *(repr(float(x)) for x in camera.params)]
    except AttributeError:
        raise TypeError(f"camera: a text, a path or a pycolmap.Camera is needed, not {type(camera).__name__}") from None
    return ",".join(str(value) for value in values)


@documented(MatchKeywords)
def match(
    a: Detection,
    b: Detection,
    *,
    camera: Union[_Camera, tuple[_Camera, _Camera], None] = None,
    progress: Progress = None,
    **keywords: Unpack[MatchKeywords],
) -> Matches:
    """Matches the features of two bursts and verifies the matches; the same bits as ``burstscope match`` gives with the same
    cameras.

    Parameters
    ----------
    a, b : Detection
    camera : str, path of a TOML file or pycolmap.Camera, or two of them, optional
        The camera of both, such as ``"PINHOLE,640,480,500,500,320,240"`` (in COLMAP's order and convention), or a tuple
        of A's and B's. With them, matches are verified by the essential matrix. A file ``camera.toml`` beside the frames,
        which the command finds, is not looked for.
    progress : callable, False or None
        See `burstscope.detect`.
    **keywords
        The parameters, below.

    Returns
    -------
    Matches

    Raises
    ------
    ValueError
        A parameter that makes no sense.
    """
    a, b = (needed(name, found, Detection, "make it, detect(burst)") for name, found in (("a", a), ("b", b)))
    cameras = camera if isinstance(camera, tuple) else () if camera is None else (camera,)
    if isinstance(camera, tuple) and len(camera) != 2:
        raise ValueError(f"camera: a tuple of {len(camera)}; give one camera, or A's and B's")
    return Matches._of(a, b, ([_camera_text(one) for one in cameras], texts(keywords)), progress)


@documented(MatchKeywords)
def colmap(
    detections: Sequence[Detection],
    out: Union[str, os.PathLike[str]],
    *,
    camera: Union[_Camera, None] = None,
    camera_model: str = "SIMPLE_RADIAL",
    pairs: str = "all",
    images: Literal["middle", "merged", "stack"] = "middle",
    progress: Progress = None,
    **keywords: Unpack[MatchKeywords],
) -> dict[str, Any]:
    """Writes what COLMAP's mapper takes from the features of several bursts, as ``burstscope colmap`` does.

    The pairs are matched and verified, and all keypoints moved to where their matches agree, by at most 20 px.
    The folder gets ``database.db``, a picture of each burst in ``images``, and the features, where they were found, in
    ``features``. ``pycolmap.incremental_mapping(out / "database.db", out / "images", out / "sparse")`` goes on from there.

    Parameters
    ----------
    detections : sequence of Detection
        Two or more, with their bursts.
    out : path
        The folder: a new or an empty one, or one of an earlier call.
    camera : str, path of a TOML file or pycolmap.Camera, optional
        The camera of all, as for `match`; COLMAP's guess without.
    camera_model : str
        The model of a guessed camera.
    pairs : str
        ``"all"``, ``"sequential:K"`` for each with the next K, or ``"near:K"`` for each with the K in which most of its
        300 strongest features have their nearest descriptor.
    images : 'middle', 'merged' or 'stack'
        The pictures: the middle frames, the merged ones, or each place stacked along its own motion at mid-burst.
    progress : callable, False or None
        See `burstscope.detect`.
    **keywords
        The parameters of matching, below.

    Returns
    -------
    dict
        What ``burstscope colmap --json`` says of cameras, images, pairs, how far keypoints were moved, in
        ``beside`` and ``implied`` how many inliers are known by the pictures beside others, and by matches with
        other bursts alone, and in ``no_start`` why a mapper would not be able to start, or ``None``.

    Raises
    ------
    ValueError
        A parameter that makes no sense, fewer than two detections, or one whose burst is not known.
    FileExistsError
        The folder holds other files.
    """
    found = [needed("detections", one, Detection, "make it, detect(burst)") for one in detections]
    if len(found) < 2:
        raise ValueError(f"detections: {len(found)}; a reconstruction needs two or more")
    sides = [(one.burst._raw, one._raw) for one in found]
    text = None if camera is None else _camera_text(camera)
    words = (pairs, images, camera_model)
    with shown(progress) as tell:
        report = _burstscope.export_colmap(sides, path_of("out", out), text, words, texts(keywords), tell)
    document: dict[str, Any] = json.loads(report)
    return document
