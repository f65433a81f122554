"""The process of a window that `show` opens: removes what was handed over when the window is closed."""

from __future__ import annotations

import shutil
import sys

from burstscope._command import main

if __name__ == "__main__":
    folder = sys.argv.pop(1)
    try:
        code = main()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    raise SystemExit(code)
