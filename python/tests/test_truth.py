"""Synthetic bursts, studies, and the keywords with their types."""

from __future__ import annotations

import inspect
import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import get_type_hints

import numpy as np
from conftest import Run, refused

import burstscope as bs
from burstscope import _burstscope, _keywords


def test_a_chart_is_that_of_the_command(tmp_path: Path, run: Run) -> None:
    burst, truth = bs.synth.chart(width=120, height=90, discs=4, frames=3, max_slope=1.0, radius=(3.6, 8), seed=9)
    document = run(
        "synth", "chart", "--out", tmp_path / "chart", "--width=120", "--height=90", "--discs=4", "--frames=3",
        "--max-slope=1", "--radius=3.6:8", "--seed=9",
    )  # fmt: skip
    assert document["truth"] == truth and len(truth["features"]) == 4
    opened = bs.open(tmp_path / "chart")
    # The files hold 16 bits.
    np.testing.assert_allclose(burst.frames.clip(0, 1), opened.frames, atol=1.0 / 65535)
    again = bs.synth.chart(width=120, height=90, discs=4, frames=3, max_slope=1.0, radius=(3.6, 8), seed=9).burst
    np.testing.assert_array_equal(again.frames, burst.frames)


def test_scenes_copies_and_trajectories(stack_file: Path, tmp_path: Path) -> None:
    burst, truth = bs.synth.scene(width=120, height=90, frames=3, layers=2, snr=5)
    assert burst.shape == (3, 90, 120) and len(truth["layers"]) == 2
    copies = bs.synth.noisy(stack_file, out=tmp_path / "dark", snr=1.0, seed=2)
    assert len(copies["frames"]) == 4 and bs.open(tmp_path / "dark").shape == bs.open(stack_file).shape
    refused(ValueError, "width: 3 pixels; give 16 to 32768", bs.synth.chart, width=3)
    refused(TypeError, "there is no keyword 'contrats'", bs.synth.chart, contrats=3)


def test_a_study_has_numbers_and_a_figure() -> None:
    report = bs.evaluate.chart(
        snr=[0.6], seeds=1, width=200, height=150, discs=8, radius=(3.6, 9), methods=["sift-mean", "buff-1d"]
    )
    (row,) = report["rows"]
    assert {method["method"] for method in row["methods"]} == {"sift-mean", "buff-1d"} or len(row["methods"]) == 2
    assert report.svg is not None
    ElementTree.fromstring(report.svg)
    assert report._repr_svg_() == report.svg
    refused(ValueError, "seeds", bs.evaluate.chart, seeds=0)


def test_the_keywords_are_those_of_the_program() -> None:
    path = Path(_keywords.__file__)
    source = _burstscope.keywords_source()
    if os.environ.get("BURSTSCOPE_UPDATE_DOCS"):
        path.write_text(source, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == source, "run `make keywords`"


def test_every_public_name_is_documented_and_typed() -> None:
    for name in bs.__all__:
        thing = getattr(bs, name)
        if callable(thing):
            assert inspect.getdoc(thing), name
    for function in (bs.detect, bs.match, bs.synth.chart, bs.evaluate.chart):
        assert "Other Parameters\n----------------\n" in (function.__doc__ or "")
    assert "noise_gate : float or {'auto', 'matching', 'strict'}" in (bs.detect.__doc__ or "")
    fields = get_type_hints(_keywords.DetectorKeywords)
    assert fields["octaves"] is int and fields["peak_threshold"] is float
    for kind in (bs.Burst, bs.Detection, bs.Matches, bs.Slopes, bs.Probe, bs.Noise):
        for name, member in inspect.getmembers(kind):
            if not name.startswith("_"):
                assert inspect.getdoc(member), f"{kind.__name__}.{name}"
