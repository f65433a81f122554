"""Matches: the bits of the command, OpenCV's and COLMAP's forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Run, refused
from numpy.typing import NDArray

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
    rows = np.genfromtxt(tmp_path / "demo_demo-later.matches.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    np.testing.assert_array_equal(matched.pairs, np.column_stack([rows["a"], rows["b"]]))
    np.testing.assert_array_equal(matched.xy_a, np.column_stack([rows["u_a"], rows["v_a"]]).astype(np.float32))
    assert matched.inliers is not None and matched.error_px is not None and matched.geometry is not None
    np.testing.assert_array_equal(matched.inliers, rows["inlier"] == 1)
    for name in ("putative", "inliers", "keypoints_a", "match_ratio", "match_score", "inlier_ratio"):
        assert matched.counts[name] == document[name]
    assert matched.counts["refused"] is None and matched.refused is None
    assert matched.geometry_name == "homography"
    np.testing.assert_array_equal(matched.geometry, document["model"]["matrix"])
    assert matched.png() == (tmp_path / "demo_demo-later.matches.png").read_bytes()
    places = np.column_stack([matched.aligned_a, np.ones(len(matched))]) @ matched.geometry.T
    away = np.hypot(*(places[:, :2] / places[:, 2:] - matched.aligned_b).T)
    assert away[matched.inliers].max() < 2 * 0.35 * matched.params["max_error_px"]


def _sampson(a: NDArray[np.float32], b: NDArray[np.float32], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances of places from epipolar geometry, pixels."""
    a, b = (np.column_stack([side.astype(np.float64), np.ones(len(side))]) for side in (a, b))
    to_b, to_a = a @ matrix.T, b @ matrix
    lengths = np.sqrt((to_b[:, :2] ** 2).sum(1) + (to_a[:, :2] ** 2).sum(1))
    distances: NDArray[np.float64] = np.abs((b * to_b).sum(1)) / lengths
    return distances


def test_lines_are_drawn_between_the_places_that_the_geometry_is_about(street: tuple[bs.Detection, bs.Detection]) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    matched = bs.match(*street, geometry="homography", min_inliers=8)
    inliers = matched.inliers
    assert inliers is not None and np.abs(matched.aligned_b - matched.xy_b)[inliers].max() > 0.1
    right = np.array([street[0].burst.frames.shape[2] + 8, 0], np.float32)
    for as_found, a, b in ((False, matched.aligned_a, matched.aligned_b), (True, matched.xy_a, matched.xy_b)):
        lines: Any = matched.plot(as_found=as_found, drawn=None).collections[0]
        np.testing.assert_allclose(lines.get_segments(), np.stack([a, b + right], 1)[inliers], rtol=1e-6)


def test_errors_and_geometry_are_those_of_the_aligned_places(street: tuple[bs.Detection, bs.Detection]) -> None:
    matched = bs.match(*street)
    assert matched.geometry is not None and matched.error_px is not None and matched.inliers is not None
    errors = _sampson(matched.aligned_a, matched.aligned_b, matched.geometry)
    np.testing.assert_allclose(errors, matched.error_px, atol=1e-3)
    as_found = _sampson(matched.xy_a, matched.xy_b, matched.geometry)
    assert np.median(errors[matched.inliers]) < 0.5 * np.median(as_found[matched.inliers])
    moved = np.hypot(*(matched.aligned_b - matched.xy_b).T)
    assert moved.max() <= 20.001 and (moved > 0).any()
    # What was measured is known of each inlier; with the pictures laid over one another they agree.
    assert np.isfinite(matched.shift[matched.inliers]).all() and (matched.correlation[matched.inliers] > 0.5).all()
    assert set(matched.how) == {"sure", "predicted"}
    plain = bs.match(*street, align=False, predict=False)
    assert set(plain.how) == {"sure"} and np.isnan(plain.shift).all()
    np.testing.assert_array_equal(plain.aligned_b, plain.xy_b)


def test_a_refused_pair_says_why(street: tuple[bs.Detection, bs.Detection]) -> None:
    # Fewer than thirty inliers are too few for their pictures to be believed.
    few = street[0][np.flatnonzero(street[0].snr > np.sort(street[0].snr)[-60])]
    matched = bs.match(few, street[1], min_inliers=8)
    assert matched.counts["inliers"] == 0 and matched.counts["refused"] == "pictures", matched.counts
    assert matched.refused == "the pictures of too many matches contradict each other"
    unaligned = bs.match(few, street[1], min_inliers=8, align=False)
    assert unaligned.refused is None and unaligned.counts["inliers"] >= 8, unaligned.counts


@pytest.mark.parametrize("keywords", [{}, {"geometry": "none"}, {"align": False}])
def test_tables_have_the_columns_and_values_of_the_file(
    street: tuple[bs.Detection, bs.Detection], tmp_path: Path, run: Run, keywords: dict[str, Any]
) -> None:
    pandas = pytest.importorskip("pandas")
    options = [f"--{name}={str(value).lower()}" for name, value in keywords.items()]
    run("match", "demo", "demo-later", "--out", tmp_path, "--slopes-u=" + SLOPES, *options)
    path = tmp_path / "demo_demo-later.matches.csv"
    table, frame = pandas.read_csv(path), bs.match(*street, **keywords).to_pandas()
    assert list(table.columns) == list(frame.columns)
    assert "nan" not in path.read_text() and "inf" not in path.read_text()
    for name in table.columns:
        if name == "how":
            assert list(table[name]) == list(frame[name])
        else:
            ours = frame[name].to_numpy(np.float64, copy=True)
            ours[np.isinf(ours)] = np.nan
            np.testing.assert_allclose(ours, table[name].to_numpy(np.float64), rtol=1e-6, atol=1e-4, err_msg=name)


def test_colmap_solves_jointly_as_the_command_does(tmp_path: Path, run: Run) -> None:
    sqlite3 = pytest.importorskip("sqlite3")
    scene = bs.synth.scene(width=240, height=180, frames=21, max_slope=1.5, snr=1.0, seed=2)
    paths = [tmp_path / f"{name}.npy" for name in "abc"]
    for index, path in enumerate(paths):
        np.save(path, (scene.burst.frames[7 * index : 7 * index + 7].clip(0, 1) * 65535).round().astype(np.uint16))
    nights = [bs.open(path) for path in paths]
    detections = [bs.detect(night, slopes_u=(-2, 2, 9), noise_gate="matching") for night in nights]
    report = bs.colmap(detections, tmp_path / "ours", ratio=0.85)
    theirs = run("colmap", *paths, "--out", tmp_path / "theirs", "--slopes-u=-2:2:9", "--ratio=0.85")
    assert report["pairs"] == theirs["pairs"] and report["moved"] == theirs["moved"]
    assert report["moved"]["max_px"] <= 20 and sum(pair["inliers"] for pair in report["pairs"]) > 100

    def contents(folder: str) -> list[Any]:
        with sqlite3.connect(tmp_path / folder / "database.db") as database:
            tables = ("keypoints", "descriptors", "matches", "two_view_geometries", "images", "cameras")
            return [database.execute(f"SELECT * FROM {table}").fetchall() for table in tables]

    assert contents("ours") == contents("theirs")
    for file in ("images/a.png", "features/b.png.txt"):
        assert (tmp_path / "ours" / file).read_bytes() == (tmp_path / "theirs" / file).read_bytes()
    # Again into its own folder, but into no other.
    for pairs in ("sequential:1", "near:1"):
        again = bs.colmap(detections[:2], tmp_path / "ours", pairs=pairs, images="stack")
        assert [pair["ids"] for pair in again["pairs"]] == [[1, 2]]
    refused(OSError, "name a new or an empty folder", bs.colmap, detections, tmp_path)
    refused(ValueError, "two or more", bs.colmap, detections[:1], tmp_path / "one")
    refused(ValueError, "pairs: .*sequential:K", bs.colmap, detections, tmp_path / "one", pairs="some")
    detections[0].save(tmp_path / "a.npz")
    with pytest.raises(ValueError, match="give their burst too"):
        bs.colmap([bs.load(tmp_path / "a.npz"), detections[1]], tmp_path / "one")


def test_parameters_reach_matching(street: tuple[bs.Detection, bs.Detection]) -> None:
    plain = bs.match(*street, geometry="none", mutual=False, ratio=0.9, seed=4)
    assert plain.inliers is None and plain.geometry is None and plain.error_px is None
    assert (plain.params["mutual"], plain.params["seed"]) == (False, 4)
    assert "not verified" in plain._repr_html_() and "not verified" in repr(plain)
    refused(ValueError, "ratio: .*0.8 is usual", bs.match, *street, ratio=0)
    refused(ValueError, "intrinsics", bs.match, *street, geometry="essential")
    refused(ValueError, "camera: .*SIMPLE_PINHOLE", bs.match, *street, camera="FISHEYE,1,2")
    refused(TypeError, "no keyword 'rato'", bs.match, *street, rato=1)


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
    # Of each its own: equal ones are one.
    simple = f"SIMPLE_PINHOLE,{columns},{rows},{columns},{columns / 2},{rows / 2}"
    same, other = (bs.match(*street, camera=(text, camera_b), min_inliers=8) for camera_b in (file, simple))
    assert "camera_b" not in same.params and len(same) == len(results[0])
    assert other.params["camera"] == results[0].params["camera"] and other.params["camera_b"]["model"] == "SIMPLE_PINHOLE"
    refused(ValueError, "camera: a tuple of 1; give one camera, or A's and B's", bs.match, *street, camera=(text,))


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
        refused(ValueError, "has features already", a.write_colmap, database, ids[0])
        refused(ValueError, "no image 77", a.write_colmap, database, 77)
    b.write_colmap(path, ids[1])
    matched.write_colmap(path, *ids)
    refused(FileNotFoundError, "make it first", b.write_colmap, tmp_path / "gone.db", 1)
    with pycolmap.Database.open(path) as database:
        keypoints = np.asarray(database.read_keypoints(ids[0]))
        np.testing.assert_allclose(keypoints[:, :2], a.xy + 0.5, atol=1e-6)
        np.testing.assert_allclose(keypoints[:, 2:4], np.column_stack([a.sigma, a.angle]), rtol=1e-6)
        np.testing.assert_array_equal(database.read_descriptors(ids[1]).data, b.descriptors)
        np.testing.assert_array_equal(database.read_matches(*ids), matched.pairs)
        refused(ValueError, "has matches", matched.write_colmap, database, *ids)
