"""Matches: the bits of the command, OpenCV's and COLMAP's forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Run

import burstscope as bs

SLOPES = "-3:3:7"


@pytest.fixture(scope="module")
def street() -> tuple[bs.Detection, bs.Detection]:
    """Features of the two built-in bursts."""
    first, second = bs.open("demo"), bs.open("demo-later")
    return bs.detect(first, slopes_u=SLOPES), bs.detect(second, slopes_u=SLOPES)


def test_matches_are_those_of_the_command(
    street: tuple[bs.Detection, bs.Detection], tmp_path: Path, run: Run
) -> None:
    matched = bs.match(*street, geometry="homography", min_inliers=8)
    document = run(
        "match", "demo", "demo-later", "--out", tmp_path, "--slopes-u=" + SLOPES, "--geometry=homography",
        "--min-inliers=8",
    )  # fmt: skip
    rows = np.genfromtxt(tmp_path / "demo_demo-later.matches.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(matched.pairs, np.column_stack([rows["a"], rows["b"]]))
    np.testing.assert_array_equal(matched.xy_a, np.column_stack([rows["u_a"], rows["v_a"]]).astype(np.float32))
    assert matched.inliers is not None and matched.error_px is not None and matched.geometry is not None
    np.testing.assert_array_equal(matched.inliers, rows["inlier"] == 1)
    for name in ("putative", "inliers", "keypoints_a", "match_ratio", "match_score", "precision"):
        assert matched.counts[name] == document[name]
    assert matched.geometry_name == "homography"
    np.testing.assert_array_equal(matched.geometry, document["model"]["matrix"])
    assert matched.png() == (tmp_path / "demo_demo-later.matches.png").read_bytes()
    places = np.column_stack([matched.xy_a, np.ones(len(matched))]) @ matched.geometry.T
    away = np.hypot(*(places[:, :2] / places[:, 2:] - matched.xy_b).T)
    assert away[matched.inliers].max() < 2 * matched.params["max_error_px"]


def test_parameters_reach_matching(street: tuple[bs.Detection, bs.Detection]) -> None:
    plain = bs.match(*street, geometry="none", mutual=False, ratio=0.9, seed=4)
    assert plain.inliers is None and plain.geometry is None and plain.error_px is None
    assert (plain.params["mutual"], plain.params["seed"]) == (False, 4)
    assert "not verified" in plain._repr_html_() and "not verified" in repr(plain)
    with pytest.raises(ValueError, match="ratio: .*0.8 is usual"):
        bs.match(*street, ratio=0)
    with pytest.raises(ValueError, match="intrinsics"):
        bs.match(*street, geometry="essential")
    with pytest.raises(ValueError, match="camera: .*SIMPLE_PINHOLE"):
        bs.match(*street, camera="FISHEYE,1,2")
    with pytest.raises(TypeError, match="no keyword 'rato'"):
        bs.match(*street, rato=1)  # type: ignore[call-arg]


def test_a_camera_is_text_file_or_pycolmaps(street: tuple[bs.Detection, bs.Detection], tmp_path: Path) -> None:
    _, rows, columns = street[0].burst.shape
    numbers = [float(columns), float(columns), columns / 2, rows / 2]
    file = tmp_path / "lens.toml"
    file.write_text(f'model = "PINHOLE"\nwidth = {columns}\nheight = {rows}\nparams = {numbers}\n')
    text = "PINHOLE,{},{},{}".format(columns, rows, ",".join(map(str, numbers)))
    cameras: list[object] = [text, file]
    pycolmap = pytest.importorskip("pycolmap")
    cameras.append(pycolmap.Camera(model="PINHOLE", width=columns, height=rows, params=numbers))
    results = [bs.match(*street, camera=camera, min_inliers=8) for camera in cameras]  # type: ignore[arg-type]
    assert {result.params["geometry"] for result in results} == {"essential"}
    assert len({len(result) for result in results}) == 1
    assert [result.params["camera"] for result in results] == 3 * [results[0].params["camera"]]


def test_opencv_gets_keypoints_and_descriptors_that_it_matches(street: tuple[bs.Detection, bs.Detection]) -> None:
    cv2 = pytest.importorskip("cv2")
    (found, _), sides = street, [side.to_cv2() for side in street]
    keypoints, descriptors = sides[0]
    assert len(keypoints) == len(found) and descriptors.dtype == np.float32
    np.testing.assert_allclose([k.pt for k in keypoints], found.xy, atol=1e-4)
    np.testing.assert_allclose([k.size for k in keypoints], 2 * found.sigma, rtol=1e-5)
    turned = np.radians([k.angle for k in keypoints]) - found.angle
    np.testing.assert_allclose(np.cos(turned), 1, atol=1e-6)
    assert all(0 <= k.angle < 360 for k in keypoints)
    assert [k.class_id for k in keypoints] == list(range(len(found)))
    theirs = cv2.BFMatcher(cv2.NORM_L2, crossCheck=True).match(sides[0][1], sides[1][1])
    ours = bs.match(*street, geometry="none", ratio=1)
    assert len(theirs) == pytest.approx(len(ours), rel=0.02)
    both = {(m.queryIdx, m.trainIdx) for m in theirs} & {tuple(pair) for pair in ours.pairs.tolist()}
    assert len(both) > 0.98 * len(ours)


def test_opencv_gives_the_angle_of_its_own_sift(chart: bs.Burst) -> None:
    cv2 = pytest.importorskip("cv2")
    ramp = np.fromfunction(lambda v, u: np.exp(-(((u - 60) / 9) ** 2) - ((v - 50) / 5) ** 2) + 0.006 * (u + v / 2), (100, 120))
    grey = (255 * (ramp - ramp.min()) / np.ptp(ramp)).astype(np.uint8)
    theirs = max(cv2.SIFT_create().detect(grey, None), key=lambda k: -abs(k.pt[0] - 60) - abs(k.pt[1] - 50))
    found = bs.detect(bs.Burst(grey[None]), method="sift", noise_gate=0, progress=False)
    row = int(np.hypot(*(found.xy - theirs.pt).T).argmin())
    ours = found.to_cv2()[0][row]
    away = (ours.angle - theirs.angle + 180) % 360 - 180
    assert abs(away) < 30 or abs(abs(away) - 180) < 30, (ours.angle, theirs.angle)


def test_colmap_reads_what_was_written(street: tuple[bs.Detection, bs.Detection], tmp_path: Path) -> None:
    pycolmap = pytest.importorskip("pycolmap")
    path = tmp_path / "database.db"
    a, b = street
    matched = bs.match(a, b)
    _, rows, columns = a.burst.shape
    with pycolmap.Database.open(path) as database:
        camera = pycolmap.Camera(model="SIMPLE_RADIAL", width=columns, height=rows, params=[columns, columns / 2, rows / 2, 0])
        camera_id = database.write_camera(camera)
        ids = [database.write_image(pycolmap.Image(name=name, camera_id=camera_id)) for name in ("a.png", "b.png")]
        a.write_colmap(database, ids[0])
        with pytest.raises(ValueError, match="has features already"):
            a.write_colmap(database, ids[0])
        with pytest.raises(ValueError, match="no image 77"):
            a.write_colmap(database, 77)
    b.write_colmap(path, ids[1])
    matched.write_colmap(path, *ids)
    with pytest.raises(FileNotFoundError, match="make it first"):
        b.write_colmap(tmp_path / "gone.db", 1)
    with pycolmap.Database.open(path) as database:
        keypoints = np.asarray(database.read_keypoints(ids[0]))
        np.testing.assert_allclose(keypoints[:, :2], a.xy + 0.5, atol=1e-6)
        np.testing.assert_allclose(keypoints[:, 2:4], np.column_stack([a.sigma, a.angle]), rtol=1e-6)
        np.testing.assert_array_equal(database.read_descriptors(ids[1]).data, b.descriptors)
        np.testing.assert_array_equal(database.read_matches(*ids), matched.pairs)
        with pytest.raises(ValueError, match="has matches"):
            matched.write_colmap(database, *ids)
