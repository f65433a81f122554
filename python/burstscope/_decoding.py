"""The process that decodes files for this one, so that a faulty decoder cannot end Python."""

from __future__ import annotations

import sys

from burstscope import _burstscope

# Loads the extension module by its path, without the package and without numpy: a short start.
_PROGRAM = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("_burstscope", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
sys.exit(module.run_command(["burstscope", *sys.argv[2:]]))
"""


def install() -> None:
    """Lets raw files and large pictures be decoded in a process of their own."""
    module = str(_burstscope.__file__)
    if sys.executable:
        arguments = ["-I", "-S", "-c", _PROGRAM, module, _burstscope.DECODE_WORKER]
        _burstscope.install_decode_worker(sys.executable, arguments)
