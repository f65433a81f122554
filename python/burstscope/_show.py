"""The window, in a process of its own, on a burst in memory."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from burstscope._memory import placing

if TYPE_CHECKING:
    from burstscope._burst import Burst
    from burstscope._detection import Detection


class Window:
    """A window that `show` opened. It stays open when Python ends."""

    def __init__(self, process: subprocess.Popen[bytes], folder: Path) -> None:
        self._process, self._folder = process, folder
        threading.Thread(target=self._remove_at_end, daemon=True).start()

    def _remove_at_end(self) -> None:
        self._process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)

    @property
    def process(self) -> subprocess.Popen[bytes]:
        """The window's process."""
        return self._process

    @property
    def is_open(self) -> bool:
        """Whether the window is open."""
        return self._process.poll() is None

    def wait(self, timeout: float | None = None) -> int:
        """Waits until the window is closed, at most ``timeout`` seconds; returns its exit code."""
        return self._process.wait(timeout)

    def close(self) -> None:
        """Closes the window."""
        self._process.terminate()
        self._process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)

    def __repr__(self) -> str:
        return f"<Window: {'open' if self.is_open else 'closed'}>"


def _word(text: str) -> str:
    """The text as a string of TOML."""
    escaped = "".join(f"\\u{ord(c):04x}" if ord(c) < 32 or c in '"\\\x7f' else c for c in text)
    return f'"{escaped}"'


def hand_over(folder: Path, burst: Burst, detection: Detection | None) -> Path:
    """Writes what the window opens into a folder: the frames, the features, and a session that names both."""
    safe = "".join(c if c.isalnum() or c in "-_ ." else "_" for c in burst.name).strip(". ") or "burst"
    frames = folder / f"{safe[:80]}.npy"
    np.save(frames, burst.seen)
    lines = [
        "version = 4",
        f"detected = {'true' if detection is not None else 'false'}",
        "[burst]",
        f"paths = [{_word(str(frames))}]",
        # The values are fractions of full scale already.
        "[document.calibration]",
        "full_scale = 1.0",
    ]
    lines += [f"{name} = {_word(value)}" for name, value in placing(burst, folder).items()]
    if detection is not None:
        features = detection.save(folder / "features.csv")
        lines += ["[document.comparisons.a]", 'with = "file"', f"file = {_word(str(features))}"]
        lines += ["[document.look]", 'overlay = "this_slope"']
        params = detection.params.splitlines()
        # A new window finds the slopes of each burst.
        found = any(line.startswith("slopes = ") for line in params)
        lines += [] if found else ["[document]", 'slopes = "given"']
        lines += ["[document.params]", *(_in_params(line) for line in params if not line.startswith("slopes = "))]
    session = folder / f"{safe[:80]}.burstscope.toml"
    session.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return session


def _in_params(line: str) -> str:
    """A line of a parameter file below the table ``params``."""
    return f"[document.params.{line[1:]}" if line.startswith("[") else line


def show(burst: Burst, detection: Detection | None = None) -> Window:
    """Opens the window on a burst, in a process of its own; Python goes on.

    The frames are handed over in a temporary file that is removed when the window is closed.

    Parameters
    ----------
    burst : Burst
    detection : Detection, optional
        Features that are shown beside those that the window finds with the same parameters.

    Returns
    -------
    Window
        To wait for it or to close it.

    Raises
    ------
    RuntimeError
        There is no display.
    """
    from burstscope._detection import Detection as Found
    from burstscope._values import needed, raw_burst

    raw_burst(burst)
    if detection is not None:
        needed("detection", detection, Found, "make it, detect(burst)")
    if sys.platform == "linux" and not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET")):
        raise RuntimeError("there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set), so no window can be opened")
    folder = Path(tempfile.mkdtemp(prefix="burstscope-"))
    try:
        session = hand_over(folder, burst, detection)
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        line = [sys.executable, "-m", "burstscope._window", str(folder), str(session)]
        # A session of its own, so that Ctrl-C in Python does not close the window.
        process = subprocess.Popen(line, env=environment, start_new_session=True)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return Window(process, folder)
