"""Matches of two bursts."""

from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from burstscope import _burstscope, _drawing
from burstscope._detection import Detection, _fixed
from burstscope._keywords import MatchKeywords
from burstscope._progress import Progress, shown
from burstscope._values import Given, Made, data_frame, documented, needed, texts

if TYPE_CHECKING:
    import pandas
    import pycolmap
    from matplotlib.axes import Axes
    from typing_extensions import Unpack


class Matches(Made):
    """Putative matches of two detections, and which of them agree with a geometry of the two views. Made by `match`.

    A pickle holds both detections and the parameters; matching, which gives the same bits again, is done anew.
    """

    _a: Detection
    _b: Detection
    _asked: tuple[str | None, Given]
    _raw: _burstscope.RawMatches

    @classmethod
    def _of(cls, a: Detection, b: Detection, asked: tuple[str | None, Given], progress: Progress = False) -> Matches:
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
        """Places in A [m, 2], pixels."""
        return _fixed(self.a.xy[self.pairs[:, 0]])

    @cached_property
    def xy_b(self) -> NDArray[np.float32]:
        """Places in B [m, 2], pixels."""
        return _fixed(self.b.xy[self.pairs[:, 1]])

    @cached_property
    def distance(self) -> NDArray[np.float32]:
        """Euclidean distances of the descriptors [m]."""
        return _fixed(self._raw.distance())

    @cached_property
    def ratio(self) -> NDArray[np.float32]:
        """Ratios of that distance to the one to the second nearest descriptor [m], 0 to 1."""
        return _fixed(self._raw.ratio())

    @cached_property
    def inliers(self) -> NDArray[np.bool_] | None:
        """Whether each match agrees with the geometry [m]; ``None`` for ``geometry="none"``."""
        inliers = self._raw.inliers()
        return None if inliers is None else _fixed(inliers)

    @cached_property
    def error_px(self) -> NDArray[np.float32] | None:
        """Error of each match under the geometry [m], pixels; infinite without one."""
        error = self._raw.error_px()
        return None if error is None else _fixed(error)

    @cached_property
    def geometry(self) -> NDArray[np.float64] | None:
        """The 3×3 matrix on which the inliers agree, from A to B; ``None`` where too few agree on any.

        For a fundamental matrix x_b·F·x_a = 0 with x = (u, v, 1) in pixels, the centre of the first pixel at (0, 0); an
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

    def plot(self, ax: Axes | None = None, *, which: NDArray[np.bool_] | None = None, **how: Any) -> Axes:
        """Draws both bursts side by side with lines between matches, on axes of matplotlib.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            By default new axes.
        which : bool array [m], optional
            The matches that are drawn: by default the inliers, or all where there is no geometry.
            ``~matches.inliers`` are the outliers, ``matches.distance < 80`` those that are most alike.
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

        if which is None:
            which = np.ones(len(self), bool) if self.inliers is None else self.inliers
        which = np.asarray(which)
        if which.shape != (len(self),) or which.dtype != bool:
            raise ValueError(f"which: an array of {which.dtype} {which.shape}; give a bool for each of the {len(self)} matches")
        return _plot.matches(self, ax, which, how)

    def to_pandas(self) -> pandas.DataFrame:
        """A table of pandas with a row a match.

        Raises
        ------
        ImportError
            pandas is not installed.
        """
        (a, b), (u_a, v_a), (u_b, v_b) = self.pairs.T, self.xy_a.T, self.xy_b.T
        table = {"a": a, "b": b, "u_a": u_a, "v_a": v_a, "u_b": u_b, "v_b": v_b}
        table |= {"distance": self.distance, "ratio": self.ratio}
        if self.inliers is not None:
            table |= {"error_px": self.error_px, "inlier": self.inliers}
        return data_frame(table)

    def write_colmap(self, database: Union[str, os.PathLike[str], pycolmap.Database], id_a: int, id_b: int) -> None:
        """Writes the putative matches of two images into a database of COLMAP, which verifies them itself.

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
    camera: Union[str, os.PathLike[str], pycolmap.Camera, None] = None,
    progress: Progress = None,
    **keywords: Unpack[MatchKeywords],
) -> Matches:
    """Matches the features of two bursts and verifies the matches; the same bits as ``burstscope match`` gives.

    Parameters
    ----------
    a, b : Detection
    camera : str, path of a TOML file or pycolmap.Camera, optional
        The camera of both, such as ``"PINHOLE,640,480,500,500,320,240"`` (in COLMAP's order and convention). With one,
        matches are verified by the essential matrix.
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
    text = None if camera is None else _camera_text(camera)
    return Matches._of(a, b, (text, texts(keywords)), progress)
