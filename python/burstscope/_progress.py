"""Progress of long work: a line on the terminal, or a bar in a notebook."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Literal, Union

#: ``None`` shows progress on a terminal and in a notebook, ``False`` nowhere; a function gets the name of the stage and
#: the finished fraction of the work, 0 to 1, on the calling thread. What it raises cancels the work.
Progress = Union[None, Literal[False], Callable[[str, float], object]]

# Seconds after which progress is shown: what is done sooner needs none.
_PATIENCE = 0.7


class _Line:
    """One line on the terminal's standard error."""

    def __init__(self) -> None:
        self.started = time.monotonic()
        self.shown = False

    def __call__(self, stage: str, fraction: float) -> None:
        if self.shown or time.monotonic() - self.started > _PATIENCE:
            self.shown = True
            self.draw(stage, fraction)

    def draw(self, stage: str, fraction: float) -> None:
        bar = "#" * round(30 * fraction)
        print(f"\r{stage:24} {bar:30} {100 * fraction:3.0f} %", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        if self.shown:
            print("\r" + " " * 64 + "\r", end="", file=sys.stderr, flush=True)


class _NotebookBar(_Line):
    """A bar below the cell, which goes when the work has ended."""

    def __init__(self) -> None:
        super().__init__()
        self.handle: Any = None

    def draw(self, stage: str, fraction: float) -> None:
        from IPython.display import HTML, display

        bar = HTML(f'<progress max="1" value="{fraction:.3f}"></progress> {stage}')
        if self.handle is None:
            self.handle = display(bar, display_id=True)
        else:
            self.handle.update(bar)

    def end(self) -> None:
        if self.handle is not None:
            from IPython.display import HTML

            self.handle.update(HTML(""))


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and type(shell).__name__ == "ZMQInteractiveShell"


@contextmanager
def shown(progress: Progress) -> Iterator[Callable[[str, float], object] | None]:
    """The function that work calls with its progress, or ``None``."""
    if progress is False:
        yield None
    elif callable(progress):
        yield progress
    elif progress is not None:
        raise TypeError(f"progress: a function, False or None is needed, not {type(progress).__name__}")
    elif _in_notebook() or sys.stderr.isatty():
        line = _NotebookBar() if _in_notebook() else _Line()
        try:
            yield line
        finally:
            line.end()
    else:
        yield None
