"""Times `pinwarp.warp` from Python next to `cv2.remap` and a plain copy of the same picture.

Usage: python benches/wheel.py [RUNS], in an environment with the wheel, NumPy and OpenCV. Prints a Markdown table with the
median milliseconds per picture on all cores. `warp` includes the solve for four pins and the inversion of the map;
`cv2.remap` gets a finished map.
"""

import statistics
import sys
import time

import cv2
import numpy
import pinwarp

SIZES = {"1920 x 1080": (1080, 1920), "3840 x 2160": (2160, 3840)}
# Rest positions and targets of the pins, in frame heights from the lower left corner.
PINS = [[0.4, 0.5, 0.5, 0.6], [1.3, 0.5, 1.3, 0.4], [0.8, 0.2, 0.8, 0.2], [0.9, 0.8, 0.9, 0.8]]


def median_ms(run, runs):
    run()
    times = []
    for _ in range(runs):
        begun = time.perf_counter()
        run()
        times.append(1e3 * (time.perf_counter() - begun))
    return statistics.median(times)


def picture(height, width, dtype):
    y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
    channels = [x / width, y / height, numpy.hypot(x - width / 2, y - height / 2) % 20 / 20, numpy.ones_like(x)]
    values = numpy.stack(channels, axis=-1)
    return (255 * values).astype(numpy.uint8) if dtype == numpy.uint8 else values.astype(dtype)


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 9
    print(f"pinwarp {pinwarp.__version__}, NumPy {numpy.__version__}, OpenCV {cv2.__version__}, {cv2.getNumberOfCPUs()} cores")
    print("| RGBA picture | `pinwarp.warp`, ms | `cv2.remap`, cubic, ms | copy, ms |\n|---|---|---|---|")
    for name, (height, width) in SIZES.items():
        for dtype in (numpy.float32, numpy.float16, numpy.uint8):
            image = picture(height, width, dtype)
            y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
            where = (x + 30 * numpy.sin(y / 90), y + 30 * numpy.sin(x / 70))
            warp = median_ms(lambda: pinwarp.warp(image, PINS), runs)
            # OpenCV does not support half floats.
            remap = "-" if dtype == numpy.float16 else f"{median_ms(lambda: cv2.remap(image, *where, cv2.INTER_CUBIC), runs):.1f}"
            copy = median_ms(image.copy, runs)
            print(f"| {name}, {numpy.dtype(dtype).name} | {warp:.1f} | {remap} | {copy:.1f} |")


main()
