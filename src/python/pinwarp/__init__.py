"""Warps animated glTF scenes and finished frames with pins placed on the screen.

>>> import numpy, pinwarp
>>> image = numpy.zeros((1080, 1920, 4), numpy.float32)
>>> warped = pinwarp.warp(image, [[960, 540, 1060, 500]], units="pixels")

Shot opens, checks and renders shot files; Scene projects glTF scenes to the screen; Lattice and LatticeFile hold lattices; solve runs
the solver alone; warp deforms pictures in memory. Errors are pinwarp.Error and its subclasses. docs/PYTHON.md is the guide.
"""

from ._errors import Cancelled, Error, FileError, InputError, MissingFileError
from ._frame import Frame
from ._pinwarp import (
    Lattice,
    LatticeFile,
    Pin,
    RenderedFrames,
    Scene,
    Shot,
    Solution,
    __version__,
    solve,
    warp,
)

__all__ = [
    "Cancelled",
    "Error",
    "FileError",
    "Frame",
    "InputError",
    "Lattice",
    "LatticeFile",
    "MissingFileError",
    "Pin",
    "RenderedFrames",
    "Scene",
    "Shot",
    "Solution",
    "__version__",
    "solve",
    "warp",
]
