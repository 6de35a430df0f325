"""Arrays of other programs go in, and what comes out goes back."""

import subprocess
import sys

import numpy
import pinwarp
from conftest import module, write_exr

PIN = [[0.9, 0.5, 1.0, 0.6]]


def test_opencv(tmp_path, picture):
    cv2 = module("cv2")
    codes = (numpy.clip(picture[..., [2, 1, 0]], 0, 1) * 255).astype(numpy.uint8)
    cv2.imwrite(str(tmp_path / "picture.png"), codes)
    image = cv2.imread(str(tmp_path / "picture.png"))
    warped = pinwarp.warp(image, PIN)
    assert cv2.imwrite(str(tmp_path / "warped.png"), warped)
    assert numpy.array_equal(cv2.imread(str(tmp_path / "warped.png")), warped)
    # The order of the colours does not matter to a warp.
    assert numpy.array_equal(pinwarp.warp(image[..., ::-1], PIN), warped[..., ::-1])


def test_openimageio(tmp_path, picture):
    oiio = module("OpenImageIO")
    write_exr(tmp_path / "picture.exr", picture)
    image = oiio.ImageBuf(str(tmp_path / "picture.exr")).get_pixels(oiio.FLOAT)
    warped = pinwarp.warp(image, PIN)
    assert numpy.array_equal(warped, pinwarp.warp(picture, PIN))
    buffer = oiio.ImageBuf(oiio.ImageSpec(128, 72, 4, oiio.FLOAT))
    assert buffer.set_pixels(oiio.ROI(0, 128, 0, 72, 0, 1, 0, 4), warped)
    assert numpy.array_equal(buffer.get_pixels(oiio.FLOAT), warped)


def test_openexr(tmp_path, picture):
    openexr = module("OpenEXR")
    write_exr(tmp_path / "picture.exr", picture)
    with openexr.File(str(tmp_path / "picture.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    warped = pinwarp.warp(channels, PIN)
    with openexr.File({"type": openexr.scanlineimage}, warped) as file:
        file.write(str(tmp_path / "warped.exr"))
    with openexr.File(str(tmp_path / "warped.exr"), separate_channels=True) as file:
        assert numpy.array_equal(file.channels()["G"].pixels, pinwarp.warp(picture, PIN)[..., 1])


def test_all_of_them_in_one_process():
    for name in ("cv2", "OpenImageIO", "OpenEXR"):
        module(name)
    script = "import cv2, OpenImageIO, OpenEXR, pinwarp, numpy; print(pinwarp.warp(numpy.ones((9, 16), 'f4'), [[1, .5, 1, .6]]).shape)"
    for order in (script, script.replace("cv2, OpenImageIO, OpenEXR, pinwarp", "pinwarp, OpenEXR, OpenImageIO, cv2")):
        done = subprocess.run([sys.executable, "-c", order], capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (0, "(9, 16)\n"), done.stderr
