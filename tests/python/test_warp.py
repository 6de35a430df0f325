"""Pictures in memory are warped to the pixels of the files that the command line writes."""

import numpy
import pinwarp
import pytest
from conftest import command_line, module, read_exr, write_exr

# In frame heights: from where to where.
PINS = [[0.9, 0.5, 1.0, 0.6], [0.5, 0.3, 0.5, 0.3]]
SHOT = """frames = { first = 1, last = 1 }
[[layer]]
[[layer.pin]]
anchor = { screen = [0.9, 0.5] }
keys = [{ frame = 1, offset = [0.1, 0.1] }]
[[layer.pin]]
anchor = { screen = [0.5, 0.3] }
"""


def stack(channels):
    return numpy.stack([channels[name] for name in "RGBA" if name in channels], axis=-1)


def test_pins_warp_as_a_shot_does(tmp_path, picture):
    write_exr(tmp_path / "plate.exr", picture)
    shot = tmp_path / "shot.toml"
    shot.write_text('plate = "plate.exr"\n' + SHOT)
    command_line("warp", "--shot", shot, "-o", tmp_path / "warped.####.exr", "--device", "cpu")
    file = stack(read_exr(tmp_path / "warped.0001.exr"))
    warped = pinwarp.warp(picture, PINS)
    assert warped.shape == picture.shape and warped.dtype == numpy.float32
    assert numpy.array_equal(warped, file)
    assert numpy.abs(warped - picture).max() > 0.1
    # The comparison can fail.
    assert not numpy.array_equal(pinwarp.warp(picture, PINS, strength=0.99), file)


def test_a_lattice_warps_as_its_file_does(tmp_path, picture):
    write_exr(tmp_path / "plate.exr", picture)
    handles = pinwarp.Lattice.rest([[0.3, 0.1], [1.5, 0.9]], [6, 5]).handles
    handles[2, 3] += [0.1, 0.05]
    lattice = pinwarp.Lattice(handles, [[0.3, 0.1], [1.5, 0.9]])
    pinwarp.LatticeFile({"pins": {1: lattice}}, frame_aspect=128 / 72).write(tmp_path / "pins.json")
    plate, output = tmp_path / "plate.exr", tmp_path / "warped.####.exr"
    command_line("warp", plate, "--lattice", tmp_path / "pins.json", "-o", output, "--device", "cpu")
    file = stack(read_exr(tmp_path / "warped.0001.exr"))
    assert numpy.array_equal(pinwarp.warp(picture, lattice=lattice), file)
    assert numpy.abs(file - picture).max() > 0.01


def test_bytes_warp_as_a_png_does(tmp_path, picture):
    cv2 = module("cv2")
    codes = (numpy.clip(picture, 0, 1) * 255).astype(numpy.uint8)
    for count in (4, 3, 1):
        image = numpy.ascontiguousarray(codes[..., :count]) if count > 1 else codes[..., 0].copy()
        # OpenCV stores blue first.
        stored = image[..., [2, 1, 0, 3][:count]] if count > 1 else image
        cv2.imwrite(str(tmp_path / "plate.png"), stored)
        shot = tmp_path / "shot.toml"
        shot.write_text('plate = "plate.png"\n' + SHOT)
        arguments = ("warp", "--shot", shot, "-o", tmp_path / "warped.####.png", "--device", "cpu", "--overwrite")
        command_line(*arguments)
        file = cv2.imread(str(tmp_path / "warped.0001.png"), cv2.IMREAD_UNCHANGED)
        warped = pinwarp.warp(image, PINS)
        assert warped.dtype == numpy.uint8 and warped.shape == image.shape
        expected = file[..., [2, 1, 0, 3][: file.shape[2]]]
        assert numpy.array_equal(warped, expected if count > 1 else expected[..., 0]), count
        assert (warped != image).any()


def test_grey_with_alpha(picture):
    codes = (numpy.clip(picture[..., [0, 3]], 0, 1) * 255).astype(numpy.uint8)
    warped = pinwarp.warp(codes, PINS)
    four = pinwarp.warp(codes[..., [0, 0, 0, 1]].copy(), PINS)
    assert numpy.array_equal(warped, four[..., [0, 3]])


def test_types_and_layouts_agree(picture):
    whole = pinwarp.warp(picture, PINS)
    flipped = numpy.asfortranarray(picture)
    assert numpy.array_equal(pinwarp.warp(flipped, PINS), whole)
    assert numpy.array_equal(pinwarp.warp(numpy.repeat(picture, 2, axis=1)[:, ::2], PINS), whole)
    half = pinwarp.warp(picture.astype(numpy.float16), PINS)
    assert half.dtype == numpy.float16 and numpy.abs(half - whole).max() < 2e-3
    grey = pinwarp.warp(picture[..., 3].copy(), PINS)
    assert grey.shape == (72, 128) and numpy.abs(grey - whole[..., 3]).max() < 1e-6
    one = pinwarp.warp(picture[..., 3:].copy(), PINS)
    assert one.shape == (72, 128, 1) and numpy.array_equal(one[..., 0], grey)
    many = pinwarp.warp(numpy.concatenate([picture, picture[..., :2]], axis=-1), PINS)
    assert many.shape == (72, 128, 6) and numpy.abs(many[..., 3] - whole[..., 3]).max() < 1e-6


def test_the_picture_that_was_given_stays(picture):
    before = picture.copy()
    picture.setflags(write=False)
    pinwarp.warp(picture, PINS)
    assert numpy.array_equal(picture, before)


def test_pixels_and_frame_heights_agree(picture):
    pixels = [[x * 72, (1 - y) * 72, u * 72, (1 - v) * 72] for x, y, u, v in PINS]
    difference = pinwarp.warp(picture, pixels, units="pixels") - pinwarp.warp(picture, PINS)
    assert numpy.abs(difference).max() < 1e-5


def test_what_a_pin_marks_arrives(picture):
    dot = numpy.zeros((120, 200), numpy.float32)
    dot[60, 100] = 1
    warped = pinwarp.warp(dot, [[100.5, 60.5, 130.5, 40.5]], units="pixels")
    assert numpy.unravel_index(warped.argmax(), warped.shape) == (40, 130)


def test_pins_hold_turns_and_scales(picture):
    free = pinwarp.warp(picture, [pinwarp.Pin((0.9, 0.5), (0.9, 0.5))])
    turned = pinwarp.warp(picture, [pinwarp.Pin((0.9, 0.5), (0.9, 0.5), rotate=30)])
    assert numpy.abs(free - picture).max() == 0 and numpy.abs(turned - picture).max() > 0.05
    assert repr(pinwarp.Pin((0.9, 0.5), (1, 0.5), rotate=30)) == "Pin((0.9, 0.5), (1, 0.5), rotate=30)"


def test_channels_are_treated_by_their_names(teapot):
    frame = pinwarp.Shot(teapot).render(1, device="cpu")
    warped = pinwarp.warp(frame, [[0.8, 0.5, 0.9, 0.6]])
    assert set(warped) == set(frame)
    assert set(numpy.unique(warped["id.object"])) <= set(numpy.unique(frame["id.object"])), "ids are never blended"
    assert set(numpy.unique(warped["depth.Z"])) <= set(numpy.unique(frame["depth.Z"])), "nor are depths"
    assert numpy.abs(warped["R"] - frame["R"]).max() > 0.01
    named = pinwarp.warp(numpy.stack([frame["A"], frame["id.object"]], axis=-1), [[0.8, 0.5, 0.9, 0.6]], names=["A", "id"])
    assert numpy.array_equal(named[..., 1], warped["id.object"])


def test_alpha_moves_free_of_the_border(picture):
    pins = [[0.9, 0.5, 1.2, 0.5]]
    moved = pinwarp.warp(picture, pins, shape="alpha")
    columns = numpy.arange(128)
    middle = lambda image: (image[..., 3].sum(axis=0) * columns).sum() / image[..., 3].sum()
    assert abs(middle(moved) - middle(picture) - 0.3 * 72) < 1.5
    with pytest.raises(pinwarp.InputError, match="no alpha"):
        pinwarp.warp(picture[..., :3].copy(), pins, shape="alpha")


def test_large_pictures_are_one_call(picture):
    image = numpy.zeros((2160, 3840, 4), numpy.float32)
    image[1000:1200, 1900:2000] = 1
    warped = pinwarp.warp(image, [[1950, 1100, 2000, 1050]], units="pixels")
    assert warped.flags.c_contiguous and abs(float(warped.sum()) / float(image.sum()) - 1) < 0.2
