"""What Python's other tools are given: pickles and copies, files loaded again, plots, tables, layers, and commands."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import refused

import burstscope as bs


def copies(value: Any) -> list[Any]:
    return [pickle.loads(pickle.dumps(value)), copy.copy(value), copy.deepcopy(value)]


def test_bursts_and_detections_are_copied_with_all_that_they_hold(chart: bs.Burst, found: bs.Detection) -> None:
    timed = bs.Burst((chart.frames * 65535).astype(np.uint16), times=range(5), name="timed")
    for burst in copies(timed):
        np.testing.assert_array_equal(burst.frames, timed.frames)
        np.testing.assert_array_equal(burst.times, timed.times)
        for name in ("name", "frame_names", "full_scale", "quantisation_step", "encoding", "binning", "notes", "sources"):
            assert getattr(burst, name) == getattr(timed, name), name
    for again in copies(found):
        for name in ("xy", "sigma", "slope", "slope_index", "slopes", "motion", "field", "field_sigma", "descriptors"):
            np.testing.assert_array_equal(getattr(again, name), getattr(found, name), name)
        assert (again.report, again.params, repr(again)) == (found.report, found.params, repr(found))
    again = pickle.loads(pickle.dumps(bs.detect(timed, slopes_u=(-1, 1, 5))))
    np.testing.assert_array_equal(bs.detect(again.burst, slopes_u=(-1, 1, 5)).descriptors, again.descriptors)


def test_matches_images_answers_and_faults_are_copied(chart: bs.Burst, found: bs.Detection) -> None:
    matched = bs.match(found, found, ratio=0.9)
    for again in copies(matched):
        np.testing.assert_array_equal(again.pairs, matched.pairs)
        np.testing.assert_array_equal(again.inliers, matched.inliers)
    response = bs.dog(chart, 0.5)
    for image in copies(response):
        assert isinstance(image, bs.Image) and image.signed
        np.testing.assert_array_equal(image, response)
    field = bs.field(chart, slopes_u=(-1, 1, 5))
    assert all((again.motion == field.motion).all() and again.burst.shape == chart.shape for again in copies(field))
    answer = bs.slopes(chart, slopes_u=(-1, 1, 5))
    assert all(again.data == answer.data and again.svg == answer.svg for again in copies(answer))
    fault = pickle.loads(pickle.dumps(bs.CommandError("gone", 1)))
    assert (str(fault), fault.returncode) == ("gone", 1)


def test_features_are_loaded_from_a_file(chart: bs.Burst, found: bs.Detection, tmp_path: Path) -> None:
    path = found.save(tmp_path / "f.npz")
    for loaded, burst in ((bs.load(path), None), (bs.load(path, burst=chart), chart)):
        for name in ("xy", "sigma", "angle", "slope", "snr", "response", "motion", "layer", "descriptors"):
            np.testing.assert_array_equal(getattr(loaded, name), getattr(found, name), name)
        assert loaded.has_burst == (burst is not None) and "of a file" in repr(loaded)
        assert len(bs.match(loaded, found, align=False)) == len(bs.match(found, found, align=False))
        assert loaded.save(tmp_path / "again.npz").read_bytes() == path.read_bytes()
        assert len(pickle.loads(pickle.dumps(loaded[:3]))) == 3
        with pytest.raises(ValueError, match="does not hold how"):
            _ = loaded.report
    with pytest.raises(ValueError, match="load.path, burst=burst"):
        _ = bs.load(path).burst
    refused(ValueError, "align: ", bs.match, bs.load(path), found, align=True)
    np.savez(tmp_path / "other.npz", other=np.zeros(3))
    np.savez(tmp_path / "short.npz", features=np.zeros((3, 4)), descriptors=np.zeros((3, 128)))
    (tmp_path / "text.npz").write_text("text")
    for name in ("other", "short", "text"):
        refused(ValueError, f"{name}.npz: no features", bs.load, tmp_path / f"{name}.npz")
    with pytest.raises(FileNotFoundError):
        bs.load(tmp_path / "gone.npz")


def test_the_field_is_that_of_the_command(stack_file: Path, tmp_path: Path) -> None:
    burst = bs.open(stack_file)
    field = bs.field(burst, slopes_u=(-1, 1, 5))
    bs.command("stack", stack_file, field=True, out=tmp_path / "field.npz", slopes_u=(-1, 1, 5))
    with np.load(tmp_path / "field.npz") as file:
        for name in ("motion", "covariance", "known", "layer", "layers", "cell_px"):
            np.testing.assert_array_equal(np.asarray(getattr(field, name), np.float32), file[name].astype(np.float32), name)
    assert (field.sigma > 0).all() and np.isnan(field.speed[~field.known]).all()
    refused(ValueError, "no field of motion", bs.field, burst, slopes_u=0)


@pytest.mark.parametrize("kind", [np.uint16, np.float32])
def test_commands_on_a_burst_in_memory_are_those_on_its_file(kind: type, stack_file: Path, tmp_path: Path) -> None:
    values = np.load(stack_file).astype(kind)
    burst = bs.Burst(values, full_scale=4095)
    np.save(tmp_path / "same.npy", values)
    asked: dict[str, Any] = {"copies": 1, "snr": [1, 4], "per_copy": 3, "seed": 5, "slopes_u": (-1, 1, 3)}
    ours = bs.recover(burst, **asked)
    theirs = bs.command("recover", tmp_path / "same.npy", full_scale=4095, **asked)
    assert ours["planted"] == theirs["planted"] and ours["frame_noise"] == theirs["frame_noise"]
    assert ours.svg is not None and "<svg" in ours.svg
    refused(TypeError, "there is no keyword 'copis'; did you mean copies", bs.recover, burst, copis=3)


def test_films_and_cases_are_written(chart: bs.Burst, tmp_path: Path) -> None:
    film = bs.film(chart, tmp_path / "f.gif", sweep="slope-u=-1:1:3", max_side=120, no_features=True)
    assert film.read_bytes().startswith(b"GIF8")
    case = bs.case(chart, tmp_path / "c.burstcase", at=(60, 50), around=20, note="why?", slopes_u=(-1, 1, 5))
    again = bs.open(case)
    np.testing.assert_allclose(again.frames, chart.frames[:, 30:71, 40:81], atol=1e-5)
    assert len(bs.detect(again, params=case).slopes) == 5
    for words, how in (
        ("name the file .burstcase", {"out": tmp_path / "c.zip"}),
        ("give at=", {"around": 20}),
        ("at: .*outside", {"at": (1e4, 0)}),
        ("around: 3; give 8 or more", {"at": (60, 50), "around": 3}),
    ):
        refused(ValueError, words, bs.case, chart, **{"out": tmp_path / "d.burstcase", **how})


def test_plots_are_drawn_on_axes(chart: bs.Burst, found: bs.Detection) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    matched = bs.match(found, found)
    figure, (left, middle, right) = plt.subplots(1, 3)
    assert found.plot(left) is left and matched.plot(middle) is middle
    assert bs.field(chart, slopes_u=(-1, 1, 5)).plot(right) is right
    assert [len(ax.images) for ax in (left, middle, right)] == [1, 1, 1]
    circles: Any
    ticks: Any
    circles, ticks = left.collections
    np.testing.assert_allclose(circles.get_offsets(), found.xy)
    assert circles.get_linewidth()[0] == 0.8 and len(ticks.get_segments()) == len(found)
    assert left.get_ylim() == (179.5, -0.5)
    assert matched.inliers is not None
    outliers = matched.plot(which=~matched.inliers, drawn=None, linewidths=2)
    few = matched.plot(which=~matched.inliers, drawn=7)
    lines: list[Any] = [*middle.collections, *outliers.collections, *few.collections]
    counts = [min(matched.inliers.sum(), 100), (~matched.inliers).sum(), 7]
    assert [len(each.get_segments()) for each in lines] == counts
    assert f"7 of {len(matched)} matches" in few.get_title()
    for empty in (found[:0].plot(image=False), found[:2].plot(image=False, edgecolors="red")):
        assert not empty.images
    figure.canvas.draw()
    plt.close("all")
    refused(TypeError, "ax: axes of matplotlib are needed, not int", found.plot, 3)
    refused(ValueError, "which: .*a bool for each", matched.plot, which=np.zeros(3, bool))


def test_packages_that_are_not_there_are_named(found: bs.Detection, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("matplotlib", "matplotlib.pyplot", "pandas"):
        monkeypatch.setitem(sys.modules, name, None)
    refused(ImportError, "pip install matplotlib", found.plot)
    refused(ImportError, "pip install pandas", found.to_pandas)


def test_tables_have_the_columns_of_the_files(found: bs.Detection, tmp_path: Path) -> None:
    header = found.save(tmp_path / "f.csv").read_text().partition("\n")[0]
    assert ",".join(found._table()) == header
    pandas = pytest.importorskip("pandas")
    table = found.to_pandas()
    assert len(table) == len(found) and list(table["snr"]) == list(found.snr)
    assert isinstance(table, pandas.DataFrame)
    matched = bs.match(found, found).to_pandas()
    assert {"a", "b", "distance", "inlier"} <= set(matched)


def test_layers_for_napari_follow_the_frames(chart: bs.Burst, found: bs.Detection) -> None:
    (frames, _, image), (points, how, kind) = found.to_napari()
    assert (image, kind, frames.shape) == ("image", "points", chart.shape)
    assert points.shape == (len(found) * len(chart), 3) == (len(how["size"]), 3)
    in_middle = points[points[:, 0] == 2]
    np.testing.assert_allclose(in_middle[:, :0:-1], found.xy)
    later = points[points[:, 0] == 4]
    np.testing.assert_allclose(later[:, :0:-1], found.xy + 2 * found.slope, rtol=1e-5)
    assert len(how["features"]["snr"]) == len(points)


def test_the_module_has_its_names_and_no_others() -> None:
    modules = {"evaluate", "synth"}
    assert {name for name in dir(bs) if not name.startswith("_")} | {"__version__"} == set(bs.__all__)
    assert dir(bs.evaluate) == sorted(bs.evaluate.__all__) and dir(bs.synth) == sorted(bs.synth.__all__)
    assert all(getattr(bs, name).__doc__ for name in set(bs.__all__) - {"REVISION", "__version__"} - modules)
    for private in (bs.Detection, bs.Matches, bs.Field):
        refused(TypeError, "no constructor", private)
    about = bs.detect.__doc__ or ""
    assert "Other Parameters\n----------------\nmethod : {'buff', 'sift', 'merge'}\n" in about


def test_nothing_else_than_numpy_is_imported() -> None:
    code = "import burstscope, sys; print([m for m in ('matplotlib', 'pandas', 'napari', 'cv2', 'IPython') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("code", "kind", "words"),
    [
        ("bs.detect(5)", TypeError, "burst: a Burst is needed, not int"),
        ("bs.match(burst, burst)", TypeError, "a: a Detection is needed, not Burst"),
        ("bs.detect(burst, max_features=-5)", ValueError, "max_features: '-5' is not a whole number of 0 or more"),
        ("bs.detect(burst, slopes_u=(0, 1))", ValueError, r"slopes_u: \(0, 1\) are no slopes; give \(min, max, count\)"),
        ("bs.detect(burst, slopes_u={})", ValueError, "slopes_u: .*np.linspace"),
        ("bs.detect(burst, frames=3)", ValueError, r"frames: 3; give \(a, b\)"),
        ("bs.detect(burst, levels={})", TypeError, "levels: dict is no value"),
        ("bs.detect(burst, params=5)", TypeError, "params: a path is needed, not int"),
        ("bs.detect(burst, progress=5)", TypeError, "progress: a function, False or None is needed, not int"),
        ("bs.command('recoverr', 'demo')", ValueError, "command: there is no 'recoverr'; did you mean recover?"),
        ("bs.command()", ValueError, "command: none is given; there are detect"),
        ("bs.command('detect', 'demo')", ValueError, "needed: out"),
        ("bs.command('detect', 'demo', out='x', max_features=-5)", ValueError, "^max_features: '-5' is not a whole number"),
        ("bs.command('detect', 'demo', out='x', max_featurs=5)", TypeError, "no keyword 'max_featurs'; did you mean max_features"),
        ("bs.probe(burst, (1, 2, 3))", ValueError, "at: .*give two"),
        ("bs.probe(burst, feature='x')", TypeError, "feature: a whole number is needed, not str"),
        ("bs.probe(burst, feature=-1)", ValueError, "feature: -1; give 0 or more"),
        ("bs.dog(burst, 1, octave=1.5)", TypeError, "octave: a whole number is needed, not float"),
        ("bs.show(5)", TypeError, "burst: a Burst is needed, not int"),
        ("bs.show(burst, 5)", TypeError, "detection: a Detection is needed, not int"),
        ("bs.Burst(5)", TypeError, "frames: an array is needed, not int"),
        ("bs.Burst(burst.frames, full_scale='x')", TypeError, "full_scale: a number is needed, not str"),
        ("bs.Burst(burst.frames, times='abc')", TypeError, "times: numbers are needed, not str"),
        ("bs.open(burst.frames)", TypeError, "path: a path is needed, not ndarray"),
        ("bs.open('demo', bias=5)", TypeError, "bias: a path is needed, not int"),
        ("bs.match(found, found, camera=5)", TypeError, "camera: .*not int"),
        ("found['snr']", TypeError, "columns are attributes: found.snr"),
        ("found.save(5)", TypeError, "path: a path is needed, not int"),
        ("burst[1:3]", TypeError, "a whole number, not slice"),
        ("bs.synth.chart(snr='x')", ValueError, "^snr: 'x': invalid float"),
        ("bs.synth.chart(snrr=3)", TypeError, "no keyword 'snrr'"),
        ("bs.stack(burst, 1).png(limits=5)", ValueError, "limits: .*give two"),
    ],
)
def test_faults_name_the_argument_and_its_type(
    code: str, kind: type[Exception], words: str, chart: bs.Burst, found: bs.Detection
) -> None:
    with pytest.raises(kind, match=words) as raised:
        eval(code, {"bs": bs, "burst": chart, "found": found})
    assert "--" not in str(raised.value)


def test_floats_above_one_say_what_full_scale_was_taken(tmp_path: Path) -> None:
    values = np.random.default_rng(3).random((3, 40, 40), np.float32) * 254
    with pytest.warns(UserWarning, match=f"the largest, {values.max():g}, was taken for full scale; give full_scale"):
        burst = bs.Burst(values)
    assert any("floats above 1" in note for note in burst.notes)
    assert bs.Burst(values, full_scale=255).notes == []
    np.save(tmp_path / "floats.npy", values)
    assert any("floats above 1" in note for note in bs.open(tmp_path / "floats.npy").notes)


def test_noise_prints_its_text(chart: bs.Burst) -> None:
    assert str(bs.noise(chart)).startswith("noise of a frame: 0.01")


def test_hloc_has_features_of_images_and_matches_of_pairs(found: bs.Detection, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    some = found[::-1][:20]
    matched = bs.match(found, some, align=False)
    assert len(matched) > 10
    features, pairs = tmp_path / "features.h5", tmp_path / "matches.h5"
    for _ in range(2):  # the second time in place of the first
        found.write_hloc(features, "left/a.png")
        some.write_hloc(features, "b.png")
        matched.write_hloc(pairs, "left/a.png", "b.png")
    with h5py.File(features, "r") as file:
        kept = file["left/a.png"]
        shapes = {name: values.shape for name, values in kept.items()}
        n = len(found)
        assert shapes == {
            "keypoints": (n, 2), "scores": (n,), "scales": (n,), "oris": (n,), "descriptors": (128, n), "image_size": (2,),
        }  # fmt: skip
        np.testing.assert_array_equal(kept["keypoints"][:], found.xy)
        np.testing.assert_allclose(np.linalg.norm(kept["descriptors"][:], axis=0), 1, atol=1e-5)
        # A matcher makes an image of that size, so it is whole numbers.
        assert kept["image_size"][:].tolist() == [240, 180] and kept["image_size"].dtype.kind == "i"
    with h5py.File(pairs, "r") as file:
        rows, scores = (file["left-a.png/b.png"][name][:] for name in ("matches0", "matching_scores0"))
    np.testing.assert_array_equal(np.flatnonzero(rows >= 0), matched.pairs[:, 0])
    np.testing.assert_array_equal(rows[rows >= 0], matched.pairs[:, 1])
    a, b = (one.to_hloc()["descriptors"] for one in (found, some))
    cosines = (a[:, matched.pairs[:, 0]] * b[:, matched.pairs[:, 1]]).sum(0)
    np.testing.assert_allclose(scores[rows >= 0], (1 + cosines) / 2, atol=0.01)
    assert (scores[rows < 0] == 0).all()
    none = np.zeros(len(matched), bool)
    assert (matched.to_hloc(none)["matches0"] == -1).all()
    refused(ValueError, "a bool for each", matched.to_hloc, none[1:])
    refused(ValueError, "name: 'a b.png'; hloc's lists are split at spaces", found.write_hloc, features, "a b.png")


def test_lightglue_has_arrays_with_the_axis_of_a_batch(found: bs.Detection, tmp_path: Path) -> None:
    arrays = found.to_lightglue()
    n = len(found)
    assert {name: values.shape for name, values in arrays.items()} == {
        "keypoints": (1, n, 2), "keypoint_scores": (1, n), "scales": (1, n), "oris": (1, n), "descriptors": (1, n, 128),
        "image_size": (1, 2),
    }  # fmt: skip
    # torch.from_numpy takes them as they are.
    assert all(a.dtype == np.float32 and a.flags.writeable and a.flags.c_contiguous for a in arrays.values())
    np.testing.assert_array_equal(arrays["keypoints"][0], found.xy + np.float32(0.5))
    np.testing.assert_array_equal(arrays["scales"][0], found.sigma)
    np.testing.assert_allclose(np.linalg.norm(arrays["descriptors"], axis=2), 1, atol=1e-5)
    assert arrays["image_size"].tolist() == [[240, 180]] and np.abs(arrays["oris"]).max() <= np.pi + 1e-6
    with pytest.raises(ValueError, match="load.path, burst=burst"):
        bs.load(found.save(tmp_path / "f.npz")).to_lightglue()
