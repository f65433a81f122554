"""Burst features in Python: the detector, the commands and the window of Burstscope.

    >>> import burstscope as bs
    >>> burst = bs.open("demo")
    >>> found = bs.detect(burst, max_features=500)
    >>> found.xy.shape, found.descriptors.shape
    ((500, 2), (500, 128))

Conventions, as everywhere in Burstscope:

* ``u`` is the column, to the right; ``v`` the row, down. The centre of the first pixel is (0, 0), as in OpenCV; COLMAP's
  is (0.5, 0.5), and what is written for COLMAP is converted.
* A slope is an apparent motion in pixels per frame. A place is where something is at mid-burst, t0 = (N - 1)/2: in frame
  t it is at ``xy + (t - t0) * slope``.
* Angles are radians from +u towards +v, clockwise on the screen.
* Frames are float32 fractions of full scale, and so are responses; scales (sigma) and slopes are in input pixels.

Long work shows its progress, lets other threads run, and ends with Ctrl-C (``KeyboardInterrupt``). Faults are exceptions
of Python's own kinds: ``ValueError`` for values that make no sense, ``TypeError`` for other types and keywords that do not exist,
``OSError`` and its kinds for files, ``MemoryError``.
"""

from burstscope import _decoding, evaluate, synth
from burstscope._burst import Burst, open
from burstscope._burstscope import REVISION as REVISION
from burstscope._burstscope import __version__ as __version__
from burstscope._command import CommandError, command
from burstscope._detection import Detection, detect, load
from burstscope._field import Field, field
from burstscope._image import Image, coverage, dog, merge, stack
from burstscope._memory import case, film, recover
from burstscope._inspect import Noise, Probe, Slopes, noise, probe, slopes
from burstscope._matches import Matches, colmap, match
from burstscope._show import Window, show
from burstscope._slider import Slider, slider

__all__ = [
    "Burst",
    "CommandError",
    "Detection",
    "Field",
    "Image",
    "Matches",
    "Noise",
    "Probe",
    "REVISION",
    "Slider",
    "Slopes",
    "Window",
    "__version__",
    "case",
    "colmap",
    "command",
    "coverage",
    "detect",
    "dog",
    "evaluate",
    "field",
    "film",
    "load",
    "match",
    "merge",
    "noise",
    "open",
    "probe",
    "recover",
    "show",
    "slider",
    "slopes",
    "stack",
    "synth",
]

_decoding.install()
