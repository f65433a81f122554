"""The commands: as the program of the wheel, and from Python in a process of their own."""

from __future__ import annotations

import difflib
import json
import os
import signal
import subprocess
import sys
from typing import Any

from burstscope import _burstscope, _decoding
from burstscope._keywords import COMMANDS
from burstscope._values import fault, options, paths


def main() -> int:
    """Runs the command that the program's arguments name, or opens the window; the entry ``burstscope``."""
    # The commands end themselves in order at Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.platform == "linux" and not os.path.isdir(os.environ.get("XDG_RUNTIME_DIR", "")):
        # Mesa asks a display that is not there which adapter is the first one, and complains.
        os.environ.setdefault("NODEVICE_SELECT", "1")
    _decoding.install()
    code = _burstscope.run_command(["burstscope", *sys.argv[1:]])
    sys.stdout.flush()
    return code


class CommandError(RuntimeError):
    """A command that failed: `returncode` is its exit code, the message what it wrote to the standard error."""

    def __init__(self, message: str, returncode: int) -> None:
        super().__init__(message)
        self.returncode = returncode

    def __reduce__(self) -> tuple[Any, ...]:
        return CommandError, (str(self), self.returncode)


def command(*arguments: str | os.PathLike[str], **keywords: Any) -> Any:
    """Runs a command of Burstscope in a process of its own, and returns its JSON document.

    Parameters
    ----------
    *arguments : str or path
        The command and what it is about: ``"colmap", "film/"``.
    **keywords
        Its options: ``burst_length=7`` is ``--burst-length 7``, ``force=True`` is ``--force``; lists are joined by
        commas, tuples by colons.

    Returns
    -------
    dict
        The document of ``--json``.

    Raises
    ------
    ValueError
        Wrong use (exit code 2), also a command that does not exist.
    TypeError
        A keyword that the command does not have.
    CommandError
        The command failed.
    KeyboardInterrupt
        Ctrl-C; the command ends too, in order.
    """
    words = paths(arguments)
    if not words or words[0] not in COMMANDS:
        close = difflib.get_close_matches(words[0], COMMANDS, 1) if words else []
        hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(COMMANDS)}"
        raise ValueError(f"command: there is no {words[0]!r}; {hint}" if words else f"command: none is given; {hint}")
    # The standard error has what failed, and no progress.
    line = [sys.executable, "-m", "burstscope", *words, *options({"quiet": True, **keywords}), "--json"]
    # What the keywords say is all: the user's defaults are for commands that are typed.
    environment = {**os.environ, "BURSTSCOPE_DEFAULTS": "", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
    try:
        output, errors = process.communicate()
    except BaseException:
        process.send_signal(signal.SIGINT)
        process.wait()
        raise
    if process.returncode == 0:
        return json.loads(output)
    message = errors.decode(errors="replace").strip().removeprefix("error: ")
    if process.returncode == 2:
        raise fault(message)
    if process.returncode == 130:
        raise KeyboardInterrupt
    raise CommandError(message or f"the command ended with {process.returncode}", process.returncode)
