"""Tests of the Python package as it is installed: `.ci/python` builds the wheel, installs it and runs them.

The command line that results are compared with is the wheel's own. Modules of other programs (OpenEXR, OpenImageIO, cv2) are needed where
PINWARP_REQUIRE_PYTHON=1, but for those that PINWARP_PYTHON_WITHOUT names; elsewhere their tests skip.
"""

import importlib
import os
import pathlib
import shutil
import subprocess
import sys

import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def module(name):
    """A module of another program."""
    if name in os.environ.get("PINWARP_PYTHON_WITHOUT", "").split(","):
        pytest.skip(f"{name} is not at hand (PINWARP_PYTHON_WITHOUT)")
    try:
        return importlib.import_module(name)
    except ImportError as error:
        if os.environ.get("PINWARP_REQUIRE_PYTHON") == "1":
            pytest.fail(f"PINWARP_REQUIRE_PYTHON is set, but {name} cannot be imported: {error}")
        pytest.skip(f"{name} cannot be imported: {error}")


def command_line(*arguments, folder=None, code=0):
    """Runs the command line of the wheel; what it says."""
    command = [sys.executable, "-m", "pinwarp", *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def read_exr(path):
    """All channels of an EXR file, by name, as they lie in it."""
    with module("OpenEXR").File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.copy() for name, channel in file.channels().items()}


def write_exr(path, image):
    """Writes R, G, B (and A) as 32-bit floats."""
    openexr = module("OpenEXR")
    channels = {name: numpy.ascontiguousarray(image[..., at]) for at, name in enumerate("RGBA"[: image.shape[2]])}
    with openexr.File({"type": openexr.scanlineimage}, channels) as file:
        file.write(str(path))


@pytest.fixture
def teapot(tmp_path):
    """A copy of the teapot's shot, in small."""
    for file in ("shot.toml", "teapot.glb"):
        shutil.copy(ROOT / "scenes/teapot" / file, tmp_path)
    shot = tmp_path / "shot.toml"
    text = shot.read_text()
    for old, new in (("[960, 540]", "[160, 90]"), ("samples = 16", "samples = 4")):
        assert old in text
        text = text.replace(old, new)
    shot.write_text(text)
    return shot


@pytest.fixture
def picture():
    """A smooth picture with alpha, float32 (72, 128, 4), colour multiplied."""
    y, x = numpy.mgrid[0:72, 0:128].astype(numpy.float32)
    alpha = numpy.clip(1.5 - numpy.hypot(x - 64, y - 36) / 30, 0, 1)
    light = numpy.stack([x / 128, y / 72, 0.5 + 0.5 * numpy.sin(x / 5)], axis=-1)
    return numpy.concatenate([light * alpha[..., None], alpha[..., None]], axis=-1).astype(numpy.float32)


@pytest.fixture
def strip():
    """A flat strip of triangles from (0, 0) to (2, 1): points and triangles."""
    across, up = 41, 21
    points = [(2 * x / (across - 1), y / (up - 1)) for y in range(up) for x in range(across)]
    corners = [(y * across + x, y * across + x + 1, (y + 1) * across + x) for y in range(up - 1) for x in range(across - 1)]
    upper = [(b, c + 1, c) for _, b, c in corners]
    return numpy.array(points), numpy.array(corners + upper)
