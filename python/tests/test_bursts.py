"""Bursts of arrays and of files: values, memory and faults."""

from __future__ import annotations

import gc
import pickle
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import refused

import burstscope as bs


def noise(shape: tuple[int, ...] = (4, 40, 56)) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    return np.random.default_rng(7).random(shape, np.float32)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32, np.float64, ">u2", ">f4"])
def test_an_array_gives_the_values_of_its_file(kind: str, tmp_path: Path) -> None:
    dtype = np.dtype(kind)
    values = noise() if dtype.kind == "f" else noise() * np.iinfo(dtype).max
    array = values.astype(dtype)
    np.save(tmp_path / "a.npy", array)
    burst, opened = bs.Burst(array), bs.open(tmp_path / "a.npy")
    assert burst.frames.dtype == np.float32
    np.testing.assert_array_equal(burst.frames, opened.frames)
    np.testing.assert_array_equal(np.asarray(burst), opened.frames)
    assert (burst.full_scale, burst.quantisation_step) == (opened.full_scale, opened.quantisation_step)
    if dtype.kind == "u":
        np.testing.assert_array_equal(burst.frames, (array.astype(np.float32) / np.float32(np.iinfo(dtype).max)))


def test_contiguous_float_frames_are_not_copied_and_others_are() -> None:
    array = noise()
    burst = bs.Burst(array)
    assert burst._raw.addresses() == [frame.ctypes.data for frame in array]
    apart = [array[2].copy(), array[0].copy()]
    assert bs.Burst(apart)._raw.addresses() == [frame.ctypes.data for frame in apart]
    turned = array.transpose(0, 2, 1)
    assert bs.Burst(turned)._raw.addresses()[0] != turned.ctypes.data
    np.testing.assert_array_equal(bs.Burst(turned).frames, turned)
    np.testing.assert_array_equal(bs.Burst(array[:, ::2, ::3]).frames, array[:, ::2, ::3])


@pytest.mark.parametrize("shape", [(1000, 100_000, 100_000), (10**12, 1, 1), (3, 10**8, 10**8), (100, 40_000, 10_000)])
@pytest.mark.parametrize("kind", [np.bool_, np.uint8, np.float32, np.float64])
def test_arrays_beyond_memory_are_refused_before_anything_is_copied(shape: tuple[int, ...], kind: type) -> None:
    # By strides they take no memory themselves.
    huge: np.ndarray[Any, np.dtype[Any]] = np.lib.stride_tricks.as_strided(np.zeros(1, kind), shape, (0, 0, 0))
    refused(ValueError, "frames", bs.Burst, huge)
    small = np.zeros((2, 40, 56), np.uint8)
    refused(ValueError, "bias", bs.Burst, small, bias=huge)
    refused(ValueError, "flat", bs.Burst, small, flat=huge)
    refused(ValueError, "mask", bs.Burst, small, mask=huge)
    with pytest.raises(ValueError, match="frames"):
        bs.Burst([np.lib.stride_tricks.as_strided(np.zeros(1, kind), (10**6, 10**6), (0, 0))] * 3)


def test_a_negative_outlier_does_not_set_the_full_scale(tmp_path: Path) -> None:
    array = noise() * np.float32(0.1)
    array[1, 2, 3] = -5
    np.save(tmp_path / "a.npy", array)
    for burst in (bs.Burst(array), bs.open(tmp_path / "a.npy")):
        assert burst.full_scale == 1
        np.testing.assert_array_equal(burst.frames, array)


def test_the_array_lives_as_long_as_the_burst() -> None:
    array = noise()
    kept = array.copy()
    gone = weakref.ref(array)
    burst = bs.Burst(array)
    del array
    gc.collect()
    assert gone() is not None
    np.testing.assert_array_equal(burst.frames, kept)
    found = bs.detect(burst, slopes_u=(0, 0, 1), slopes_v=(0, 0, 1), progress=False)
    del burst, found
    gc.collect()
    assert gone() is None


def test_what_is_masked_is_nan_in_seen_and_stays_masked(tmp_path: Path) -> None:
    frames, mask = noise(), np.ones((40, 56), bool)
    mask[:, 30:] = False
    burst = bs.Burst(frames, mask=mask)
    assert np.isnan(burst.seen[:, :, 30:]).all() and np.isfinite(burst.frames).all()
    np.testing.assert_array_equal(burst.seen[:, :, :30], frames[:, :, :30])
    np.save(tmp_path / "frames.npy", frames)
    np.save(tmp_path / "mask.npy", mask.astype(np.uint8))
    opened = bs.open(tmp_path / "frames.npy", mask=tmp_path / "mask.npy")
    for same in (opened, pickle.loads(pickle.dumps(burst))):
        np.testing.assert_array_equal(same.seen, burst.seen)
    frames[1, 3, 4], frames[2, 0, 0] = np.nan, 1
    assert np.argwhere(np.isnan(bs.Burst(frames).seen)).tolist() == [[1, 3, 4]]
    assert np.isnan(bs.Burst(frames, mask_saturated=True).seen[2, 0, 0])
    refused(ValueError, "this mask is 3×5", bs.Burst, frames, mask=np.ones((5, 3)))


def test_calibration_is_that_of_files(tmp_path: Path) -> None:
    frames = (noise() * 3000 + 500).astype(np.uint16)
    bias = np.full((2, 40, 56), 60, np.uint16)
    bias[1] += 8
    flat = (2000 + 10 * np.arange(56)[None, :] * np.ones((40, 1))).astype(np.uint16)
    for name, array in (("frames", frames), ("bias", bias), ("flat", flat)):
        np.save(tmp_path / f"{name}.npy", array)
    opened = bs.open(
        tmp_path / "frames.npy", bias=tmp_path / "bias.npy", flat=tmp_path / "flat.npy", full_scale=4095
    )
    made = bs.Burst(frames, bias=bias, flat=flat, full_scale=4095)
    np.testing.assert_array_equal(made.frames, opened.frames)
    dark = bs.Burst(frames, black_level=64, full_scale=4095)
    np.testing.assert_allclose(dark.frames, (frames.astype(float) - 64) / (4095 - 64), atol=1e-6)


def test_frames_are_images_and_a_burst_is_a_sequence() -> None:
    array = noise()
    burst = bs.Burst(array, name="mine")
    assert (len(burst), burst.shape, burst.name) == (4, (4, 40, 56), "mine")
    np.testing.assert_array_equal(burst[-1], array[-1])
    assert [frame.shape for frame in burst] == [(40, 56)] * 4
    with pytest.raises(IndexError, match="no frame 4"):
        burst[4]
    assert "4 frames of 56×40" in repr(burst)


def test_times_rise_and_gaps_are_gaps() -> None:
    burst = bs.Burst(noise(), times=[10.0, 10.1, 10.2, 10.3])
    assert burst.frame_interval == pytest.approx(0.1)
    assert bs.Burst(noise()).times is None
    # A dropped frame: the interval is the camera's, and the motion of what is planted is known all the same.
    dropped = bs.Burst(noise(), times=[0, 0.1, 0.2, 0.4])
    assert dropped.frame_interval == pytest.approx(0.1)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(dropped)).times, dropped.times)
    assert not np.array_equal(bs.stack(dropped, (2.0, 0.0)), bs.stack(burst, (2.0, 0.0)))
    for times, words in (
        ([0, 2, 1, 3], "time order"),
        ([0, 1, 2], "one finite number a frame"),
        ([0, 1, 2, np.nan], "one finite number a frame"),
    ):
        refused(ValueError, words, bs.Burst, noise(), times=times)


def test_a_part_of_a_long_recording_is_opened_alone(tmp_path: Path) -> None:
    frames = np.arange(6 * 40 * 56, dtype=np.uint16).reshape(6, 40, 56)
    np.save(tmp_path / "long.npy", frames)
    whole, part = bs.open(tmp_path / "long.npy"), bs.open(tmp_path / "long.npy", take="2..5")
    assert len(part) == 3 and all((part[t] == whole[t + 2]).all() for t in range(3))
    refused(ValueError, "take: 2..9 reaches beyond the 6 frames", bs.open, tmp_path / "long.npy", take="2..9")
    refused(ValueError, "take: 'two' is not A..B", bs.open, tmp_path / "long.npy", take="two")


def test_faults_say_what_would_be_right(tmp_path: Path) -> None:
    refused(FileNotFoundError, "check the spelling", bs.open, tmp_path / "gone")
    refused(ValueError, "no .*picture|holds no|no frames|nothing", bs.open, tmp_path)
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"\0" * 40)
    refused(ValueError, "broken.png", bs.open, tmp_path / "broken.png")
    with pytest.raises(ValueError, match="raw_colour: unknown variant `mauve`, expected one of `luma`"):
        bs.open("demo", raw_colour="mauve")  # type: ignore[arg-type]
    refused(ValueError, "built-in bursts need no calibration", bs.open, "demo", full_scale=3)
    refused(ValueError, r"give \[frames, rows, columns\]", bs.Burst, np.zeros((40, 56), np.uint8))
    refused(ValueError, "one channel of the colours", bs.Burst, np.zeros((4, 40, 56, 3), np.uint8))
    refused(TypeError, "give uint8, uint16 or float32", bs.Burst, np.zeros((4, 40, 56), np.int64))
    refused(ValueError, "crop them alike", bs.Burst, [np.zeros((40, 56), np.uint8), np.zeros((40, 57), np.uint8)])
    refused(ValueError, "frame", bs.Burst, np.full((2, 40, 56), np.nan, np.float32))
    refused(ValueError, "nothing to open", bs.Burst, np.zeros((0, 40, 56), np.uint8))
    refused(ValueError, "there is no light in it", bs.Burst, noise(), flat=np.zeros((40, 56), np.float32))
    refused(ValueError, "full scale", bs.Burst, noise(), full_scale=-1)
