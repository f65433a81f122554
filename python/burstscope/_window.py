"""The process of a window that `show` opens: removes what was handed over when the window is closed."""

from __future__ import annotations

import shutil
import sys

from burstscope._command import main


def run() -> int:
    """Runs the window that the arguments name, after the folder with what was handed over; returns the exit code."""
    folder = sys.argv.pop(1)
    try:
        return main()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    raise SystemExit(run())
