"""Times OpenCV and OpenImageIO on the warp written by `cargo bench --bench plate`, one run per line of input.

In: the arguments width, height, a file of the source (interleaved RGBA float32) and one of offsets (x, y float32 per
pixel); then on standard input lines such as "opencv cubic 2" (package, filter, threads). Out: milliseconds per line, or
"-" if the package is missing. Both packages write into allocated memory.
"""

import sys
import time

import numpy as np

try:
    import cv2
except ImportError:
    cv2 = None
try:
    import OpenImageIO as oiio
except ImportError:
    oiio = None


def opencv(source, offsets):
    height, width = offsets.shape[:2]
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    where = (offsets + grid).astype(np.float32)
    result = np.empty((height, width, 4), np.float32)
    filters = {"linear": cv2.INTER_LINEAR, "cubic": cv2.INTER_CUBIC, "lanczos": cv2.INTER_LANCZOS4, "nearest": cv2.INTER_NEAREST}

    def run(name, threads):
        cv2.setNumThreads(threads)
        cv2.remap(source, where, None, filters[name], dst=result, borderMode=cv2.BORDER_CONSTANT)

    return run


def openimageio(source, offsets):
    height, width = offsets.shape[:2]
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    st = ((offsets + grid + 0.5) / [width, height]).astype(np.float32)

    def buffer(pixels):
        made = oiio.ImageBuf(oiio.ImageSpec(width, height, pixels.shape[2], oiio.FLOAT))
        made.set_pixels(made.roi, pixels)
        return made

    picture, where = buffer(source), buffer(st)
    result = oiio.ImageBuf(oiio.ImageSpec(width, height, 4, oiio.FLOAT))
    filters = {"cubic": "catmull-rom", "lanczos": "lanczos3"}

    def run(name, threads):
        if not oiio.ImageBufAlgo.st_warp(result, picture, where, filters[name], nthreads=threads):
            raise RuntimeError(result.geterror())

    return run


def main():
    width, height = int(sys.argv[1]), int(sys.argv[2])
    source = np.fromfile(sys.argv[3], np.float32).reshape(height, width, 4)
    offsets = np.fromfile(sys.argv[4], np.float32).reshape(height, width, 2)
    runs = {"opencv": cv2 and opencv(source, offsets), "openimageio": oiio and openimageio(source, offsets)}
    for line in sys.stdin:
        package, name, threads = line.split()
        if not runs[package]:
            print("-", flush=True)
            continue
        start = time.perf_counter()
        runs[package](name, int(threads))
        print(1e3 * (time.perf_counter() - start), flush=True)


main()
