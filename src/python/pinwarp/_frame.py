"""A rendered frame."""

from __future__ import annotations

import numpy


class Frame(dict):
    """A dict of channels by their names in EXR files: arrays (H, W) with rows from the top, float32, or uint32 for ids of other programs.

    number: frame number.
    size: width and height of the display window in pixels.
    data_window: (x, y, width, height) of the arrays, from the upper left corner of the display window.
    pixel_aspect: width of a pixel divided by its height.
    """

    def __init__(
        self,
        channels: dict[str, numpy.ndarray],
        number: int = 0,
        size: tuple[int, int] = (0, 0),
        data_window: tuple[int, int, int, int] = (0, 0, 0, 0),
        pixel_aspect: float = 1.0,
    ) -> None:
        super().__init__(channels)
        self.number = number
        self.size = size
        self.data_window = data_window
        self.pixel_aspect = pixel_aspect

    def rgba(self, dtype: numpy.typing.DTypeLike = numpy.float32) -> numpy.ndarray:
        """Returns a copy of R, G, B and A as one array (H, W, 4), scene-linear, colour multiplied with alpha."""
        return numpy.stack([self[name] for name in "RGBA"], axis=-1).astype(dtype, copy=False)

    def preview(self) -> numpy.ndarray:
        """Returns the picture over black as uint8 (H, W, 3), sRGB, to display it in a notebook."""
        light = numpy.stack([self[name] for name in "RGB"], axis=-1).clip(0.0, 1.0)
        code = numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        return (code * 255.0 + 0.5).astype(numpy.uint8)

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Frame {self.number}, {width} x {height}: {', '.join(self)}>"
