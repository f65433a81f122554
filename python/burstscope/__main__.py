"""``python -m burstscope``: the commands and the window."""

from burstscope._command import main

if __name__ == "__main__":
    raise SystemExit(main())
