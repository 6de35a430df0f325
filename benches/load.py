"""Measures how time and memory grow with the size of a shot: frames, pixels, triangles, layers, keys, pins.

    python3 benches/load.py target/release/pinwarp [--devices cpu,vulkan] [--only NAME] [--most SHARE]

In: the program. Out: a Markdown table with wall time and processor time in seconds, peak memory of the process (`wait4`),
and the exponents by which processor time and memory grew since the row above (1 means linear). `--most 0.1` omits sizes
above a tenth of the largest. Needs Python 3.10 and numpy.
"""

import argparse
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
HEAD = """version = 1
{source}
frames = {{ first = 1, last = {frames}, rate = 24 }}
size = [{width}, {height}]
samples = 1
{camera}
[output]
path = "out/f.####.exr"
channels = {channels}
"""
CAMERA = 'camera = "front"'


def grid(triangles: int, center: tuple[float, float], size: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and indices of a bumpy square with approximately this number of triangles."""
    side = max(1, round(math.sqrt(triangles / 2)))
    line = np.linspace(-0.5, 0.5, side + 1, dtype=np.float32) * size
    x, y = np.meshgrid(line + np.float32(center[0]), line + np.float32(center[1]))
    positions = np.stack([x, y, 0.02 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1, 1)
    faces = np.concatenate([corner + [0, 1, side + 1], corner + [1, side + 2, side + 1]], axis=1)
    return positions, faces.astype(np.uint32).reshape(-1)


def write_glb(path: pathlib.Path, meshes: list[tuple[np.ndarray, np.ndarray]]) -> None:
    """A scene with a node `part N` for each mesh. It has normals, so that triangles share vertices."""
    blob, views, accessors, nodes, own = bytearray(), [], [], [], []
    for number, (positions, indices) in enumerate(meshes):
        normals = np.broadcast_to(np.float32([0, 0, 1]), positions.shape)
        for array, kind, component in ((positions, "VEC3", 5126), (normals, "VEC3", 5126), (indices, "SCALAR", 5125)):
            views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes})
            accessor = {"bufferView": len(views) - 1, "componentType": component, "type": kind, "count": len(array)}
            if kind == "VEC3":
                accessor |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
            accessors.append(accessor)
            blob += array.tobytes()
        own.append({"primitives": [{"attributes": {"POSITION": 3 * number, "NORMAL": 3 * number + 1}, "indices": 3 * number + 2}]})
        nodes.append({"name": f"part {number}", "mesh": number})
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": own,
        "buffers": [{"byteLength": len(blob)}], "bufferViews": views, "accessors": accessors,
    }  # fmt: skip
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(blob)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(blob), b"BIN\0") + blob)


def layer(nodes: str, pins: str, dims: tuple[int, int] = (5, 5), name: str = "all") -> str:
    return f'\n[[layer]]\nname = "{name}"\nnodes = ["{nodes}"]\nlattice = {{ dims = [{dims[0]}, {dims[1]}] }}\n{pins}'


def pin(x: float, y: float, keys: str, more: str = "") -> str:
    return f"  [[layer.pin]]\n  anchor = {{ screen = [{x:.5f}, {y:.5f}], frame = 1 }}\n  {more}\n  keys = [{keys}]\n"


def key(frame: int, x: float, y: float) -> str:
    return f"{{ frame = {frame}, offset = [{x:.5f}, {y:.5f}] }}"


MOVED = pin(0.9, 0.5, key(1, 0, 0) + ", " + key(100, 0.05, 0.03))


class Load:
    """Creates shots in a work folder and measures the program on them."""

    def __init__(self, program: pathlib.Path, work: pathlib.Path, options: argparse.Namespace):
        self.program, self.work, self.options = program, work, options

    def shot(self, layers: str, frames: int = 1, size: tuple[int, int] = (160, 90), channels: str = '["beauty"]') -> list[str]:
        head = HEAD.format(
            source='scene = "scene.glb"', frames=frames, width=size[0], height=size[1], channels=channels, camera=CAMERA
        )
        (self.work / "shot.toml").write_text(head + layers)
        return ["render", "shot.toml", "--overwrite"]

    def measure(self, words: list[str]) -> tuple[float, float, float]:
        """Wall time and processor time in seconds, and peak memory in MiB."""
        with open(self.work / "log", "wb") as log:
            start = time.monotonic()
            process = subprocess.Popen([str(self.program), *words], cwd=self.work, stdout=log, stderr=log)
            _, status, used = os.wait4(process.pid, 0)
            wall = time.monotonic() - start
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            text = (self.work / "log").read_text(errors="replace")
            raise SystemExit(f"{' '.join(words)}: exit code {process.returncode}\n{text[-3000:]}")
        return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024

    def rows(self, what: str, sizes: list[int], prepare, devices: bool = True) -> None:
        """Measures a shot at growing sizes. `prepare` writes it and returns the arguments of the program."""
        if self.options.only not in what:
            return
        for device in self.options.devices.split(",") if devices else ["cpu"]:
            before = None
            for size in (size for size in sizes if size <= self.options.most * sizes[-1]):
                shutil.rmtree(self.work / "out", ignore_errors=True)
                wall, cores, memory = self.measure([*prepare(size), "--device", device])
                growth = "" if before is None else growths(before, (size, cores, memory))
                print(f"| {what} | {device} | {size:,} | {wall:.2f} | {cores:.2f} | {memory:,.0f} | {growth} |", flush=True)
                before = (size, cores, memory)


def growths(before: tuple[float, float, float], now: tuple[float, float, float]) -> str:
    steps = math.log(now[0] / before[0])
    return " / ".join(f"{math.log(now[i] / before[i]) / steps:.2f}" for i in (1, 2))


def frames(load: Load):
    def prepare(count: int) -> list[str]:
        write_glb(load.work / "scene.glb", [grid(2000, (0, 0), 1)])
        return load.shot(layer("*", MOVED), frames=count)

    load.rows("frames", [100, 1000, 10000], prepare)


def pixels(load: Load):
    """16:9 frames by number of pixels. The largest is 16K and has to stay within the memory budget."""

    def prepare(count: int) -> list[str]:
        width = round(math.sqrt(count * 16 / 9))
        write_glb(load.work / "scene.glb", [grid(2000, (0, 0), 1)])
        words = load.shot(layer("*", MOVED), size=(width, width * 9 // 16), channels='["beauty", "depth"]')
        return [*words, "--max-memory", load.options.budget]

    def plate(count: int) -> list[str]:
        load.measure([*prepare(count), "--device", "cpu", "-o", "in/p.####.exr"])
        return ["warp", "in/p.####.exr", "--shot", "shot.toml", "-o", "out/w.####.exr", "--overwrite", "--max-memory", load.options.budget]

    sizes = [width * width * 9 // 16 for width in (1920, 3840, 7680, 15360)]
    load.rows("pixels of a frame", sizes, prepare)
    load.rows("pixels of a plate", sizes, plate, devices=False)


def triangles(load: Load):
    def prepare(count: int) -> list[str]:
        write_glb(load.work / "scene.glb", [grid(count, (0, 0), 1)])
        return load.shot(layer("*", MOVED), size=(1920, 1080))

    load.rows("triangles", [50_000, 500_000, 5_000_000], prepare)


def layers(load: Load):
    """One node, lattice and pair of pins per layer; ten frames."""

    def prepare(count: int) -> list[str]:
        side = math.ceil(math.sqrt(count))
        places = [((n % side + 0.5) / side - 0.5, (n // side + 0.5) / side - 0.5) for n in range(count)]
        write_glb(load.work / "scene.glb", [grid(50, place, 0.8 / side) for place in places])
        text = ""
        for number in range(count):
            anchors = [f'{{ node = "part {number}", primitive = 0, triangle = {t}, barycentric = [0.3, 0.3, 0.4] }}' for t in (0, 40)]
            moves = [key(1, 0, 0) + ", " + key(10, 0.2 / side, 0.1 / side), ""]
            pins = "".join(f"  [[layer.pin]]\n  anchor = {a}\n  keys = [{k}]\n" for a, k in zip(anchors, moves))
            text += layer(f"part {number}", pins, name=f"layer {number}")
        return load.shot(text, frames=10, size=(480, 270))

    load.rows("layers", [5, 50, 500], prepare)


def keys(load: Load):
    """Ten pins share the keys; ten frames in the middle are rendered."""

    def prepare(count: int) -> list[str]:
        write_glb(load.work / "scene.glb", [grid(2000, (0, 0), 1)])
        each = count // 10
        moves = [", ".join(key(f, 0.02 * math.sin(f / 9 + p), 0.02 * math.cos(f / 7)) for f in range(1, each + 1)) for p in range(10)]
        ring = [(0.889 + 0.35 * math.cos(0.63 * p), 0.5 + 0.35 * math.sin(0.63 * p)) for p in range(10)]
        pins = "".join(pin(*ring[p], moves[p]) for p in range(10))
        first = max(1, each // 2)
        return [*load.shot(layer("*", pins, (10, 10)), frames=each), "--frames", f"{first}-{first + 9}"]

    load.rows("keys", [1000, 10_000, 100_000], prepare, devices=False)


def pins(load: Load):
    """All pins in one layer of 40 x 40 handles; ten frames. Their weight is below 1, because they are more than the handles can satisfy."""

    def prepare(count: int) -> list[str]:
        write_glb(load.work / "scene.glb", [grid(20_000, (0, 0), 1)])
        side = math.ceil(math.sqrt(count))
        text = ""
        for number in range(count):
            x, y = (number % side + 0.5) / side, (number // side + 0.5) / side
            move = key(1, 0, 0) + ", " + key(10, 0.02 * math.sin(9 * x), 0.02 * math.cos(7 * y))
            text += pin(0.889 + 0.7 * (x - 0.5), 0.5 + 0.7 * (y - 0.5), move, "weight = 0.8")
        return load.shot(layer("*", text, (40, 40)), frames=10)

    load.rows("pins", [20, 200, 2000], prepare, devices=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--devices", default="cpu,vulkan")
    parser.add_argument("--only", default="", help="rows whose name contains this")
    parser.add_argument("--most", type=float, default=1.0, help="share of the largest size")
    parser.add_argument("--budget", default="14G", help="--max-memory of large frames")
    options = parser.parse_args()
    print("| what | device | size | s | core s | MiB | growth of time / memory |\n|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory(prefix="pinwarp-load-") as work:
        load = Load(options.program.resolve(), pathlib.Path(work), options)
        for measure in (frames, pixels, triangles, layers, keys, pins):
            measure(load)


if __name__ == "__main__":
    sys.exit(main())
