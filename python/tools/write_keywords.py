"""Writes the keywords of the functions from the program's own table into the sources. `make keywords` calls it."""

from pathlib import Path

from burstscope import _burstscope

PATH = Path(__file__).parent.parent / "burstscope" / "_keywords.py"

if __name__ == "__main__":
    PATH.write_text(_burstscope.keywords_source(), encoding="utf-8")
