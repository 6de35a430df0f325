"""Types of the compiled module. The docstrings are in the module itself; stubtest compares both."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeVar, final

import numpy
from numpy.typing import ArrayLike, NDArray

from ._frame import Frame

__version__: str
__all__ = [
    "Lattice",
    "LatticeFile",
    "Pin",
    "RenderedFrames",
    "Scene",
    "Shot",
    "Solution",
    "__version__",
    "main",
    "solve",
    "warp",
]

_Path = str | PathLike[str]
# Called with (done, total) on the calling thread; False cancels.
_Progress = Callable[[int, int], object]
_Basis = Literal["bspline", "bernstein", "bilinear", "barytri"]
_Guard = Literal["report", "limit"]
_Channels = Mapping[str, NDArray[Any]]
_Image = TypeVar("_Image", bound=NDArray[Any] | dict[str, NDArray[Any]])

@final
class Pin:
    def __new__(
        cls,
        at: Sequence[float],
        to: Sequence[float],
        *,
        rotate: float | None = None,
        scale: float | None = None,
        weight: float = 1.0,
    ) -> Pin: ...
    @property
    def at(self) -> list[float]: ...
    @property
    def to(self) -> list[float]: ...
    @property
    def rotate(self) -> float | None: ...
    @property
    def scale(self) -> float | None: ...
    @property
    def weight(self) -> float: ...

@final
class Lattice:
    # The box and the handles rest rotated by `angle` degrees about the box's centre.
    def __new__(
        cls,
        handles: ArrayLike,
        box: Sequence[Sequence[float]],
        basis: _Basis = "bspline",
        angle: float = 0.0,
    ) -> Lattice: ...
    @staticmethod
    def rest(
        box: Sequence[Sequence[float]],
        dims: Sequence[int],
        basis: _Basis = "bspline",
        angle: float = 0.0,
    ) -> Lattice: ...
    @property
    def space(self) -> Literal["screen", "world"]: ...
    @property
    def dims(self) -> list[int]: ...
    @property
    def basis(self) -> str: ...
    @property
    def box(self) -> list[list[float]]: ...
    @property
    def handles(self) -> NDArray[numpy.float64]: ...
    @property
    def angle(self) -> float: ...
    @property
    def rest_handles(self) -> NDArray[numpy.float64]: ...
    def warp(self, points: ArrayLike) -> NDArray[numpy.float64]: ...
    def evaluate(self, points: ArrayLike) -> NDArray[numpy.float64]: ...
    def gradient(self, points: ArrayLike) -> NDArray[numpy.float64]: ...
    def folds(self) -> list[list[int]]: ...
    def with_strength(self, strength: float) -> Lattice: ...

@final
class LatticeFile:
    def __new__(
        cls, lattices: Mapping[str, Mapping[int, Lattice]], frame_aspect: float, rate: float = 24.0
    ) -> LatticeFile: ...
    @staticmethod
    def read(path: _Path) -> LatticeFile: ...
    def write(self, path: _Path) -> None: ...
    @property
    def layers(self) -> list[str]: ...
    @property
    def frame_aspect(self) -> float: ...
    @property
    def rate(self) -> float: ...
    @property
    def warnings(self) -> list[tuple[int, str]]: ...
    def frames(self, layer: str | None = None) -> list[int]: ...
    def lattice(self, frame: float, layer: str | None = None) -> Lattice: ...

@final
class Scene:
    def __new__(
        cls,
        path: _Path,
        *,
        camera: str | None = None,
        size: tuple[int, int] = (1920, 1080),
        rate: float = 24.0,
        clip: str | None = None,
    ) -> Scene: ...
    @property
    def path(self) -> PathLike[str]: ...
    @property
    def nodes(self) -> list[str]: ...
    @property
    def cameras(self) -> list[str]: ...
    @property
    def clips(self) -> list[tuple[str, float]]: ...
    @property
    def notes(self) -> list[str]: ...
    def project(self, frame: float) -> list[dict[str, Any]]: ...

@final
class RenderedFrames(Iterator[Frame]):
    def __iter__(self) -> RenderedFrames: ...
    def __next__(self) -> Frame: ...
    def __length_hint__(self) -> int: ...

@final
class Shot:
    def __new__(
        cls,
        path: _Path,
        *,
        camera: str | None = None,
        scale: float = 1.0,
        samples: int | None = None,
        channels: Sequence[Literal["beauty", "depth", "motion", "normal", "id", "cryptomatte"]] | None = None,
        output: _Path | None = None,
        allow_outside: bool = False,
    ) -> Shot: ...
    @property
    def path(self) -> PathLike[str]: ...
    @property
    def frames(self) -> range: ...
    @property
    def rate(self) -> float: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def layers(self) -> list[str]: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def output(self) -> PathLike[str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def scene(self) -> Scene: ...
    def render(self, frame: int, device: str = "auto", progress: _Progress | None = None) -> Frame: ...
    def render_frames(
        self, frames: Sequence[int] | None = None, device: str = "auto", progress: _Progress | None = None
    ) -> RenderedFrames: ...
    def write(
        self,
        frames: Sequence[int] | None = None,
        progress: _Progress | None = None,
        *,
        device: str = "auto",
        existing: Literal["refuse", "overwrite", "resume"] = "refuse",
        preview: bool = False,
    ) -> dict[str, Any]: ...
    def check(self, frames: Sequence[int] | None = None, progress: _Progress | None = None) -> dict[str, Any]: ...
    def lattices(self, frames: Sequence[int] | None = None, progress: _Progress | None = None) -> LatticeFile: ...
    def pins(self, frame: int) -> list[dict[str, Any]]: ...
    def project(self, frame: float) -> list[dict[str, Any]]: ...

@final
class Solution:
    @property
    def lattice(self) -> Lattice: ...
    @property
    def report(self) -> dict[str, Any]: ...

def solve(
    points: ArrayLike,
    triangles: ArrayLike,
    pins: ArrayLike,
    progress: _Progress | None = None,
    *,
    dims: Sequence[int] | None = None,
    box: Sequence[Sequence[float]] | None = None,
    basis: _Basis = "bspline",
    energy: Literal["area", "edge", "vertex", "element", "spokes-and-rims", "stroke"] = "area",
    smoothness: float = 1.0,
    guard: _Guard = "report",
    branching: bool = False,
) -> Solution: ...
def warp(
    image: _Image,
    pins: ArrayLike | Sequence[Pin] | None = None,
    progress: _Progress | None = None,
    *,
    lattice: Lattice | None = None,
    units: Literal["screen", "pixels"] = "screen",
    dims: Sequence[int] = (16, 16),
    basis: _Basis = "bspline",
    smoothness: float = 1.0,
    strength: float = 1.0,
    guard: _Guard = "report",
    shape: Literal["frame", "alpha"] = "frame",
    filter: Literal["ewa", "cubic", "lanczos", "nearest"] = "ewa",
    names: Sequence[str] | None = None,
    pixel_aspect: float = 1.0,
) -> _Image: ...
def main(args: Sequence[str]) -> int: ...
