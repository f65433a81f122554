"""Long work: progress, Ctrl-C, other threads; the commands and the window in processes of their own."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import refused

import burstscope as bs


@pytest.fixture(scope="module")
def slow() -> bs.Burst:
    """A burst whose search over a plane of slopes takes seconds."""
    frames = np.random.default_rng(3).normal(0.3, 0.05, (12, 480, 640)).astype(np.float32)
    return bs.Burst(frames.clip(0, 1))


def test_progress_names_stages_and_rises(slow: bs.Burst) -> None:
    heard: list[tuple[str, float]] = []
    bs.detect(slow, slopes_u=(-2, 2, 9), slopes_v=(-1, 1, 3), progress=lambda stage, fraction: heard.append((stage, fraction)))
    assert heard and all(0 <= fraction <= 1 for _, fraction in heard)
    assert any("Searching" in stage for stage, _ in heard)


def test_an_exception_of_progress_cancels_the_work(slow: bs.Burst) -> None:
    def stop(stage: str, fraction: float) -> None:
        raise LookupError("enough")

    started = time.monotonic()
    refused(LookupError, "enough", bs.detect, slow, slopes_u=(-4, 4, 33), slopes_v=(-4, 4, 33), progress=stop)
    # The whole search takes minutes.
    assert time.monotonic() - started < 60


def test_ctrl_c_ends_the_work(slow: bs.Burst) -> None:
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        bs.detect(slow, slopes_u=(-4, 4, 33), slopes_v=(-4, 4, 33))
    timer.join()
    assert len(bs.detect(slow, slopes_u=(0, 0, 1), slopes_v=(0, 0, 1)).slopes) == 1


def test_other_threads_run_meanwhile_and_work_runs_in_them(slow: bs.Burst) -> None:
    ticks = 0
    results: list[int] = []

    def work() -> None:
        results.append(len(bs.detect(slow, slopes_u=(-2, 2, 9), slopes_v=(-1, 1, 3), progress=False)))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        ticks += 1
        time.sleep(0.002)
    assert len(set(results)) == 1 and len(results) == 2
    assert ticks > 20


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_process_is_refused_instead_of_hanging() -> None:
    script = """
import os, numpy as np, burstscope as bs
burst = bs.Burst(np.zeros((3, 48, 64), np.uint8))
child = os.fork()
if child == 0:
    for work in (lambda: bs.Burst(np.zeros((3, 48, 64), np.uint8)), lambda: bs.detect(burst, progress=False)):
        try:
            work()
        except RuntimeError as error:
            print(error, flush=True)
    os._exit(0)
os.waitpid(child, 0)
bs.detect(burst, progress=False)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.count("forked after Burstscope had begun to work") == 2, done.stdout
    assert "spawn" in done.stdout


def test_commands_return_their_document_and_their_faults(stack_file: Path, tmp_path: Path) -> None:
    document = bs.command("detect", stack_file, out=tmp_path, slopes_u=(-1, 1, 3), format=["csv", "npz"])
    assert document["bursts"][0]["features"] > 0 and (tmp_path / "night.npz").is_file()
    refused(ValueError, "levels", bs.command, "detect", stack_file, out=tmp_path, levels=0)
    with pytest.raises(bs.CommandError, match="gone") as failed:
        bs.command("detect", tmp_path / "gone", out=tmp_path)
    assert failed.value.returncode == 1


def test_the_program_and_the_module_are_one(tmp_path: Path) -> None:
    line = [sys.executable, "-m", "burstscope"]
    version = subprocess.run([*line, "--version"], capture_output=True, text=True, check=True).stdout
    # A wheel of a checkout names its commit.
    assert re.fullmatch(rf"burstscope {re.escape(bs.__version__)} \((\w+, )?detector {bs.REVISION}\)", version.strip())
    helped = subprocess.run([*line, "detect", "--help"], capture_output=True, text=True, check=True).stdout
    assert "--max-features" in helped
    wrong = subprocess.run([*line, "detect"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2 and "--out" in wrong.stderr


def test_ctrl_c_ends_a_command_with_130(tmp_path: Path) -> None:
    frames = np.random.default_rng(3).normal(0.3, 0.05, (12, 480, 640)).astype(np.float32)
    np.save(tmp_path / "slow.npy", frames.clip(0, 1))
    line = [sys.executable, "-m", "burstscope", "detect", "slow.npy", "--out", "out", "--slopes-u=-4:4:33", "--slopes-v=-4:4:33"]
    process = subprocess.Popen(line, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    time.sleep(3)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert b"Traceback" not in errors
    assert not list((tmp_path / "out").glob("*.csv"))


def test_raw_frames_are_decoded_by_the_wheels_own_command(monkeypatch: pytest.MonkeyPatch) -> None:
    shared = Path(os.environ.get("BURSTSCOPE_SHARED", Path(__file__).parents[3] / "shared"))
    raw = sorted((shared / "data" / "raw").rglob("*.[dD][nN][gG]"))
    if not raw:
        pytest.skip(f"there are no raw frames in {shared}/data/raw")
    burst = bs.open(raw[0])
    assert burst.binning == 2 and float(burst[0].max()) > 0
    code = (
        "import burstscope._decoding as d; d.sys.executable = '/nowhere/python'\n"
        "import burstscope as bs, sys\n"
        "try: bs.open(sys.argv[1])\n"
        "except (OSError, ValueError) as e: print(e)\n"
    )
    del monkeypatch
    line = [sys.executable, "-c", "import sys; sys.executable='/nowhere/python'\n" + code, str(raw[0])]
    told = subprocess.run(line, capture_output=True, text=True, check=False)
    assert raw[0].name in told.stdout, told.stderr


def test_show_needs_a_display(chart: bs.Burst, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    refused(RuntimeError, "no display", bs.show, chart)


def test_what_is_handed_over_opens_in_the_window(chart: bs.Burst, found: bs.Detection, tmp_path: Path) -> None:
    from burstscope._show import hand_over

    handed = tmp_path / "handed"
    handed.mkdir()
    session = hand_over(handed, chart, found)
    np.testing.assert_array_equal(bs.open(next(handed.glob("*.npy")), full_scale=1).frames, chart.frames)
    out = tmp_path / "window.png"
    line = [sys.executable, "-m", "burstscope._window", str(handed), "render", str(session), "--out", str(out)]
    drawn = subprocess.run(line, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert drawn.returncode == 0, drawn.stderr
    assert out.read_bytes().startswith(b"\x89PNG") and out.stat().st_size > 20_000
    assert not handed.exists()


def test_show_opens_a_window_and_removes_what_it_handed_over(
    chart: bs.Burst, found: bs.Detection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed: make packages")
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
        pass_fds=[write], stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(write)
    try:
        with os.fdopen(read) as numbers:
            monkeypatch.setenv("DISPLAY", f":{numbers.readline().strip()}")
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        monkeypatch.setenv("TMPDIR", str(tmp_path))
        monkeypatch.setattr("tempfile.tempdir", None)
        monkeypatch.setenv("HOME", str(tmp_path))
        monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
        window = bs.show(chart, found)
        assert len(list(tmp_path.glob("burstscope-*/*.npy"))) == 1
        time.sleep(8)
        assert window.is_open, window.process.returncode
        window.close()
        assert not list(tmp_path.glob("burstscope-*"))
        assert not window.is_open
    finally:
        server.terminate()
        server.wait()
