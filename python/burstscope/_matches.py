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
from burstscope._values import documented, needed, texts

if TYPE_CHECKING:
    import pycolmap
    from typing_extensions import Unpack


class Matches:
    """Putative matches of two detections, and which of them agree with a geometry of the two views. Made by `match`."""

    def __init__(self, a: Detection, b: Detection, raw: _burstscope.RawMatches) -> None:
        self._a, self._b, self._raw = a, b, raw

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
        """Both bursts with the matches between them, at full size, as ``burstscope match`` draws them (PNG)."""
        picture = self._raw.picture((self.a.burst._raw, self.a._raw), (self.b.burst._raw, self.b._raw))
        return bytes(picture)

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
        return f"<Matches of {self.a.burst.name!r} and {self.b.burst.name!r}: {len(self)} putative, {inliers}>"

    def _repr_html_(self) -> str:
        return _drawing.matches(self)


def _camera_text(camera: Any) -> str:
    if isinstance(camera, str):
        return camera
    if isinstance(camera, os.PathLike):
        return str(os.fspath(camera))
    model = getattr(camera.model, "name", camera.model)
    values = [model, camera.width, camera.height, *(repr(float(x)) for x in camera.params)]
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
    with shown(progress) as tell:
        text = None if camera is None else _camera_text(camera)
        return Matches(a, b, _burstscope.match_features((a.burst._raw, a._raw), (b.burst._raw, b._raw), text, texts(keywords), tell))
