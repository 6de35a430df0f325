"""A rendered frame."""

from __future__ import annotations

import numpy


class Frame(dict):
    """Channels by their names in EXR files, each (H, W), rows from the top: float32, ids of other programs uint32.

    number: the frame. size: width and height of the frame as the viewer sees it, pixels. data_window: (x, y, width, height) of the
    arrays, from the frame's upper left corner. pixel_aspect: width of a pixel divided by its height.
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
        """R, G, B and A as one array (H, W, 4), scene-linear, colour multiplied with alpha: a copy."""
        return numpy.stack([self[name] for name in "RGBA"], axis=-1).astype(dtype, copy=False)

    def preview(self) -> numpy.ndarray:
        """The picture over black as uint8 (H, W, 3), sRGB: for a look at it in a notebook."""
        light = numpy.stack([self[name] for name in "RGB"], axis=-1).clip(0.0, 1.0)
        code = numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        return (code * 255.0 + 0.5).astype(numpy.uint8)

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Frame {self.number}, {width} x {height}: {', '.join(self)}>"
