"""Features in Python: the bits of the commands, their arrays, parameters and faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Run, refused

import burstscope as bs
from burstscope import _values


@pytest.mark.parametrize(
    "keywords",
    [
        {},
        {"slopes_u": (-1, 1, 5)},
        {"slopes_u": "-1:1:3", "slopes_v": (-0.5, 0.5, 3), "slope_extrema": "joint", "noise_gate": "strict"},
        {"method": "sift", "max_features": 40, "first_octave": -1, "distinct": "off"},
        {"method": "merge", "frames": (0, 3), "noise_gate": 4.5},
    ],
)
def test_the_bits_are_those_of_the_command(
    keywords: dict[str, object], stack_file: Path, tmp_path: Path, run: Run
) -> None:
    found = bs.detect(bs.open(stack_file), **keywords)  # type: ignore[arg-type]
    options = _values.options(keywords)
    document = run("detect", stack_file, "--out", tmp_path / "out", "--format", "npz,csv,colmap", *options)
    with np.load(tmp_path / "out" / "night.npz") as npz:
        columns, descriptors = npz["features"], npz["descriptors"]
    assert len(found) > 0
    ours = np.column_stack(
        [
            found.xy, found.sigma, found.angle, found.slope, found.response, found.snr,
            found.octave, found.level, found.at_slope_limit,
            found.slope_sigma, found.field, found.field_sigma, found.layer,
            [("unknown", "surroundings", "own", "edge", "ghost").index(word) for word in found.motion],
        ]
    )  # fmt: skip
    np.testing.assert_array_equal(ours.astype(np.float32), columns)
    np.testing.assert_array_equal(found.descriptors, descriptors)
    for name in ("csv", "colmap", "npz"):
        path = found.save(tmp_path / f"mine.{name}", format=name)
        written = sorted((tmp_path / "out").glob("night*"))
        assert any(path.read_bytes() == other.read_bytes() for other in written), name
    theirs = document["bursts"][0]
    for name in ("tally", "noise", "slope_grid", "octaves", "frame_noise", "noise_gate_factor", "slopes", "advice"):
        assert found.report[name] == theirs[name], name


def test_some_of_the_features_are_a_detection_too(found: bs.Detection, tmp_path: Path) -> None:
    n = len(found)
    some = found[found.sigma > np.median(found.sigma)]
    assert 0 < len(some) < n
    np.testing.assert_array_equal(some.descriptors, found.descriptors[found.sigma > np.median(found.sigma)])
    np.testing.assert_array_equal(found[2:5].xy, found.xy[2:5])
    np.testing.assert_array_equal(found[[3, 1]].snr, found.snr[[3, 1]])
    np.testing.assert_array_equal(found[-1].xy, found.xy[-1:])
    assert [len(one) for one in found[:3]] == [1, 1, 1] and len(found[:0]) == 0
    assert bs.match(found[:5], found[:5]).pairs.shape[1] == 2
    with np.load(some.save(tmp_path / "some.npz")) as npz:
        assert len(npz["features"]) == len(some)
    for wrong in (n, np.zeros(n + 1, dtype=bool)):
        with pytest.raises(IndexError):
            found[wrong]


def test_slopes_may_be_arrays_or_numbers(chart: bs.Burst) -> None:
    expected = bs.detect(chart, slopes_u=(-1, 1, 5))
    for row in (np.linspace(-1, 1, 5), [-1, -0.5, 0, 0.5, 1], np.linspace(-1, 1, 5, dtype=np.float32)):
        found = bs.detect(chart, slopes_u=row)
        np.testing.assert_array_equal(found.xy, expected.xy)
    np.testing.assert_array_equal(bs.stack(chart, 1.5), bs.stack(chart, (1.5, 0)))
    for wrong, words in (([0, 1, 3], "not evenly spaced"), ([[0, 1]], "in a row"), ([1, 0], "not evenly spaced")):
        refused(ValueError, f"slopes_u: .*{words}", bs.detect, chart, slopes_u=wrong)


def test_what_is_no_burst_or_detection_is_said(chart: bs.Burst, found: bs.Detection) -> None:
    refused(TypeError, "burst: a Burst is needed, not ndarray", bs.detect, np.zeros((3, 40, 40)))
    refused(TypeError, "b: a Detection is needed, not Burst", bs.match, found, chart)
    refused(ValueError, "slope: .*give two", bs.stack, chart, (1, 2, 3))
    refused(ValueError, "at: .*give two", bs.probe, chart, (1, 2, 3))


def test_arrays_have_one_row_a_feature_and_are_fixed(found: bs.Detection) -> None:
    n = len(found)
    assert n > 5
    shapes = {name: getattr(found, name).shape for name in ("xy", "slope", "descriptors", "sigma", "angle", "snr")}
    assert shapes == {
        "xy": (n, 2), "slope": (n, 2), "descriptors": (n, 128), "sigma": (n,), "angle": (n,), "snr": (n,)
    }  # fmt: skip
    assert [str(x.dtype) for x in (found.xy, found.descriptors, found.octave)] == ["float32", "uint8", "int32"]
    assert (np.diff(found.strength) <= 0).all()
    assert (np.abs(found.angle) <= np.pi).all()
    np.testing.assert_array_equal(found.slopes, [[-1, 0], [-0.5, 0], [0, 0], [0.5, 0], [1, 0]])
    nearest = np.abs(found.slopes[found.slope_index] - found.slope).max()
    assert nearest <= 1
    with pytest.raises(ValueError, match="read-only"):
        found.xy[0, 0] = 3


def test_features_lie_on_the_discs(made: bs.synth.Synthetic, found: bs.Detection) -> None:
    for disc in made.truth["features"]:
        away = np.hypot(*(found.xy - [disc["u"], disc["v"]]).T)
        near = (away < 1.5) & (np.abs(found.slope[:, 0] - disc["slope_u"]) < 0.5)
        assert near.any(), disc


def test_a_burst_with_times_has_velocities(chart: bs.Burst, found: bs.Detection) -> None:
    timed = bs.Burst(chart.frames, times=0.02 * np.arange(len(chart)))
    again = bs.detect(timed, slopes_u=(-1, 1, 5))
    np.testing.assert_allclose(again.velocity, again.slope / 0.02, rtol=1e-6)
    with pytest.raises(ValueError, match="no times"):
        _ = found.velocity


def test_a_parameter_file_is_read_and_overridden(chart: bs.Burst, found: bs.Detection, tmp_path: Path) -> None:
    file = tmp_path / "p.toml"
    file.write_text(found.params)
    again = bs.detect(chart, params=file)
    np.testing.assert_array_equal(again.descriptors, found.descriptors)
    assert len(bs.detect(chart, params=file, max_features=3)) == 3
    refused(OSError, "gone.toml", bs.detect, chart, params=tmp_path / "gone.toml")
    file.write_text("octave = 3\n")
    refused(ValueError, "octave", bs.detect, chart, params=file)


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"levels": 0}, "levels: 0; give 1 to 10"),
        ({"levels": "many"}, "levels: 'many' is not a whole number"),
        ({"method": "surf"}, "method: 'surf' is not known; give one of buff, sift, merge"),
        ({"slopes_u": (3, -3, 7)}, "slopes_u: .*give the smaller slope first"),
        ({"slopes": "all"}, "give auto"),
        ({"slopes": "auto", "slopes_v": (0, 1, 3)}, "both given"),
        ({"frames": (3, 99)}, "reaches past the burst's 5 frames"),
        ({"frames": slice(None, 3)}, "or a slice or a range with a start"),
        ({"noise_gate": "lots"}, "noise_gate: .*auto"),
        ({"edge_threshold": float("nan")}, "edge"),
    ],
)
def test_nonsense_is_a_value_error_with_a_remedy(chart: bs.Burst, keywords: dict[str, object], words: str) -> None:
    refused(ValueError, words, bs.detect, chart, **keywords)


def test_unknown_keywords_and_values_are_type_errors(chart: bs.Burst) -> None:
    refused(TypeError, "there is no keyword 'octave'; there are method, .*octaves", bs.detect, chart, octave=3)
    refused(TypeError, "no value of a keyword", bs.detect, chart, levels=object())


def test_none_is_not_given(chart: bs.Burst, found: bs.Detection) -> None:
    again = bs.detect(chart, slopes_u=(-1, 1, 5), levels=None, params=None)  # type: ignore[arg-type]
    np.testing.assert_array_equal(again.xy, found.xy)


def test_a_burst_without_features_gives_empty_arrays_and_advice() -> None:
    flat = bs.Burst(np.random.default_rng(1).normal(0.5, 0.01, (4, 64, 64)).astype(np.float32))
    found = bs.detect(flat, slopes_u=(-1, 1, 3), noise_gate="strict")
    assert (len(found), found.xy.shape, found.descriptors.shape) == (0, (0, 2), (0, 128))
    assert found.advice
    assert "<svg" in found._repr_html_()


def test_images_are_those_of_the_commands(stack_file: Path, tmp_path: Path, run: Run) -> None:
    burst = bs.open(stack_file)
    for name, image, arguments in (
        ("stack", bs.stack(burst, (-0.4, 0.1)), ["stack", "--slope=-0.4,0.1"]),
        ("dog", bs.dog(burst, (-0.4, 0), octave=1, level=2), ["stack", "--slope=-0.4,0", "--octave=1", "--level=2"]),
        ("merge", bs.merge(burst), ["merge"]),
    ):
        out = tmp_path / f"{name}.tiff"
        run(*arguments, stack_file, "--out", out)
        written = bs.open(out)
        np.testing.assert_array_equal(np.asarray(written[0]), np.asarray(image), err_msg=name)
        assert image.dtype == np.float32
    still = bs.stack(burst, (0, 0))
    np.testing.assert_allclose(np.asarray(still), burst.frames.mean(0), atol=1e-6)
    covered = bs.coverage(burst, (1, 0))
    assert covered.shape == burst.shape[1:] and float(covered.max()) == 1.0
    refused(ValueError, "octave|level", bs.dog, burst, (0, 0), octave=9)
    refused(ValueError, "not finite", bs.stack, burst, (float("nan"), 0))
