"""Explanations: the numbers, texts and figures of the commands."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Run, refused

import burstscope as bs


def without_times(document: Any) -> Any:
    """The document without what is measured by the clock."""
    if isinstance(document, dict):
        return {key: without_times(value) for key, value in document.items() if not key.endswith("_secs")}
    if isinstance(document, list):
        return [without_times(value) for value in document]
    return document


def test_slopes_are_those_of_the_command(stack_file: Path, tmp_path: Path, run: Run) -> None:
    answer = bs.slopes(bs.open(stack_file))
    document = run("slopes", stack_file, "--plot", tmp_path / "slopes.svg")
    assert without_times(answer.data["spectrum"]) == without_times(document["spectrum"])
    assert answer.data["most_features_at"] == document["most_features_at"]
    ElementTree.fromstring(answer.svg)
    assert len(answer.bars) == len(document["spectrum"]["bars"])
    assert answer.most_features_at is not None and "slopes" in str(answer).lower()
    judged = bs.slopes(bs.open(stack_file), slopes_u=(-0.2, 0.2, 3))
    assert judged.advice and judged.finding


def test_a_probe_is_that_of_the_command(stack_file: Path, tmp_path: Path, run: Run) -> None:
    burst = bs.open(stack_file)
    answer = bs.probe(burst, (60, 40), slopes_u=(-1, 1, 5))
    document = run("probe", stack_file, "--at=60,40", "--slopes-u=-1:1:5", "--plot", tmp_path / "p.svg")
    assert answer.data["probe"] == document["probe"]
    # The file ends with the mark of the program.
    text = (tmp_path / "p.svg").read_text()
    assert text.startswith(answer.svg) and text.removeprefix(answer.svg).startswith('<!-- {"program":"burstscope"')
    assert answer.summary in str(answer) and answer.summary in repr(answer)
    found = bs.detect(burst, slopes_u=(-1, 1, 5))
    of_feature = bs.probe(burst, feature=0, slopes_u=(-1, 1, 5))
    place = of_feature.data["probe"]["subject"]["pos_image"]
    np.testing.assert_allclose(place, found.xy[0], atol=2)
    for wrong, words in (
        ({"at": (9999, 0)}, "outside the 200×150 image"),
        ({"feature": 10**6}, "there is no feature"),
        ({}, "either a place"),
        ({"at": (1, 1), "feature": 1}, "either a place"),
    ):
        refused(ValueError, words, bs.probe, burst, slopes_u=(-1, 1, 5), **wrong)


def test_one_search_answers_several_questions(chart: bs.Burst) -> None:
    bs.probe(chart, (30, 30), slopes_u=(-1, 1, 5))
    first = list(chart._inspections.values())
    bs.slopes(chart, slopes_u=(-1, 1, 5))
    bs.noise(chart, slopes_u=(-1, 1, 5))
    assert list(chart._inspections.values()) == first
    bs.probe(chart, (30, 30), slopes_u=(-1, 1, 3))
    assert list(chart._inspections.values()) != first and len(chart._inspections) == 1


def test_noise_is_that_of_the_detection(chart: bs.Burst, found: bs.Detection, made: bs.synth.Synthetic) -> None:
    noise = bs.noise(chart, slopes_u=(-1, 1, 5))
    assert noise.data == found.report["noise"]
    truth = made.truth["noise"]["sigma_background"]
    assert noise.frame_noise == pytest.approx(truth, rel=0.25)
    assert noise.map.shape == chart.shape[1:] and float(np.median(noise.map)) == pytest.approx(truth, rel=0.25)
    assert isinstance(noise.warnings, list)
