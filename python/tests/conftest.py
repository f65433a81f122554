"""Bursts and commands that the tests share."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import burstscope as bs

Run = Callable[..., Any]

# Results depend on no file of whoever runs the tests.
os.environ["BURSTSCOPE_DEFAULTS"] = ""


@pytest.fixture(scope="session")
def made() -> bs.synth.Synthetic:
    """A small, clear chart with its truth."""
    return bs.synth.chart(width=240, height=180, discs=12, radius=(3.6, 9), frames=5, max_slope=1.0, snr=2.0, seed=3)


@pytest.fixture(scope="session")
def chart(made: bs.synth.Synthetic) -> bs.Burst:
    """The chart's burst."""
    return made.burst


@pytest.fixture(scope="session")
def found(chart: bs.Burst) -> bs.Detection:
    """Features of the chart."""
    return bs.detect(chart, slopes_u=(-1, 1, 5))


@pytest.fixture(scope="session")
def stack_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A 16-bit stack of a chart in a file."""
    burst = bs.synth.chart(width=200, height=150, discs=10, radius=(3.6, 9), frames=4, max_slope=1.0, snr=3.0).burst
    path = tmp_path_factory.mktemp("stack") / "night.npy"
    np.save(path, (burst.frames.clip(0, 1) * 4095).round().astype(np.uint16))
    return path


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Runs a command with --json in a folder of its own, and returns its document."""

    def command(*arguments: object, code: int = 0) -> Any:
        line = [sys.executable, "-m", "burstscope", *map(str, arguments), "--json"]
        done = subprocess.run(line, capture_output=True, cwd=tmp_path, text=True, env=dict(os.environ), check=False)
        assert done.returncode == code, done.stderr
        return json.loads(done.stdout) if code == 0 else done.stderr

    return command


def refused(kind: type[Exception], words: str, call: Callable[..., object], /, *args: Any, **keywords: Any) -> None:
    """Expects that the call raises an exception of this kind whose message has these words, a regular expression."""
    with pytest.raises(kind, match=words):
        call(*args, **keywords)
