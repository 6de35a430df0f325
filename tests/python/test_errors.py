"""Bad input: an exception says what is wrong, where, and what to do."""

import pickle

import numpy
import pinwarp
import pytest
from conftest import ROOT, command_line

IMAGE = numpy.zeros((20, 30, 3), numpy.float32)
TRIANGLE = ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]])


def fault(call, *arguments, kind=pinwarp.InputError, **options):
    with pytest.raises(kind) as caught:
        call(*arguments, **options)
    return caught.value


@pytest.mark.parametrize(
    ("image", "what"),
    [
        (IMAGE.astype(numpy.float64), "array of float64 with the shape (20, 30, 3); use image.astype(numpy.float32)"),
        (IMAGE.astype(numpy.uint16), "uint16"),
        (IMAGE.tolist(), "of the type list"),
        (IMAGE[0, 0], "has the shape [3]"),
        (numpy.zeros((0, 5), numpy.float32), "sides of 1 to 65536"),
        (numpy.zeros((2, 5, 5), numpy.uint8), "has 5 channels of uint8"),
        ({}, "is empty"),
        ({"R": IMAGE[..., 0], "G": IMAGE[1:, :, 0]}, "has [30, 19] pixels, \"R\" has [30, 20]"),
        ({"R": IMAGE}, "give (height, width)"),
        ({"R": IMAGE[..., 0].astype(numpy.float64)}, "ids of uint32"),
    ],
)
def test_pictures(image, what):
    error = fault(pinwarp.warp, image, [[0.5, 0.5, 0.6, 0.5]])
    assert what in str(error) and "image" in error.key and error.hint in str(error)
    assert isinstance(error, ValueError)


@pytest.mark.parametrize(
    ("pins", "key", "what"),
    [
        ([[0.5, 0.5, float("nan"), 0.5]], "pins[0]", "NaN"),
        ([[0.5, 0.5, 0.6]], "pins", "(1, 3)"),
        ([0.5, 0.5, 0.6, 0.5], "pins", "shape (N, 4)"),
        ("nose", "pins", "of the type str"),
        ([["a", "b", "c", "d"]], "pins", "not a table of numbers"),
    ],
)
def test_pins(pins, key, what):
    error = fault(pinwarp.warp, IMAGE, pins)
    assert (error.key, what in str(error)) == (key, True), error
    assert "pins[0]" in fault(pinwarp.solve, *TRIANGLE, [[0, 0, numpy.inf, 0]]).key


def test_far_pins():
    # Pixels where frame heights are asked for.
    assert "within 1000 of the frame" in str(fault(pinwarp.warp, IMAGE, [[9600, 540, 1060, 540]]))


def test_choices():
    pin = [[0.5, 0.5, 0.6, 0.5]]
    assert "bspline" in str(fault(pinwarp.warp, IMAGE, pin, basis="spline"))
    assert "pixels" in str(fault(pinwarp.warp, IMAGE, pin, units="meters"))
    assert "ewa" in str(fault(pinwarp.warp, IMAGE, pin, filter="soft"))
    assert "4 to 64" in str(fault(pinwarp.warp, IMAGE, pin, dims=(2, 2)))
    assert "give one of the two" in str(fault(pinwarp.warp, IMAGE))
    assert "give 2 numbers" in str(fault(pinwarp.solve, *TRIANGLE, [[0, 0, 1, 1]], dims=(4, 4, 4)))
    with pytest.raises(TypeError, match=r"no argument 'filtre'; did you mean \"filter\""):
        pinwarp.warp(IMAGE, pin, filtre="ewa")
    with pytest.raises(TypeError, match="dims"):
        pinwarp.warp(IMAGE, pin, dims="ten")


def test_lattices():
    assert "box[0]" in fault(pinwarp.Lattice, numpy.zeros((4, 4, 2)), [[0], [1, 1]]).key
    assert "finite size" in str(fault(pinwarp.Lattice, numpy.zeros((4, 4, 2)), [[0, 0], [0, 1]]))
    handles = numpy.zeros((4, 4, 2))
    handles[1, 1, 0] = numpy.nan
    assert "handle 5" in str(fault(pinwarp.Lattice, handles, [[0, 0], [1, 1]]))
    assert "(ny, nx, 2)" in str(fault(pinwarp.Lattice, numpy.zeros((4, 4)), [[0, 0], [1, 1]]))
    lattice = pinwarp.Lattice.rest([[0, 0], [1, 1]], [4, 4])
    assert "(N, 2)" in str(fault(lattice.warp, [[0, 0, 0]]))
    world = pinwarp.Lattice.rest([[0, 0, 0], [1, 1, 1]], [4, 4, 4])
    assert "of the screen" in str(fault(pinwarp.warp, IMAGE, lattice=world))


def test_shapes_of_triangles():
    assert "triangles[0]" in fault(pinwarp.solve, TRIANGLE[0], [[0, 1, -1]], [[0, 0, 1, 1]]).key
    assert "triangle" in str(fault(pinwarp.solve, TRIANGLE[0], [[0, 1, 7]], [[0, 0, 1, 1]]))
    assert "points" in fault(pinwarp.solve, numpy.zeros((0, 2)), numpy.zeros((0, 3)), numpy.zeros((0, 4))).key


def test_missing_files(tmp_path):
    error = fault(pinwarp.Shot, tmp_path / "none.toml", kind=pinwarp.MissingFileError)
    assert isinstance(error, FileNotFoundError) and error.file.endswith("none.toml") and "check the path" in str(error)
    fault(pinwarp.Scene, tmp_path / "none.glb", kind=pinwarp.MissingFileError)
    fault(pinwarp.LatticeFile.read, tmp_path / "none.json", kind=FileNotFoundError)


def test_a_fault_of_a_shot_has_file_line_and_key(tmp_path):
    shot = tmp_path / "shot.toml"
    shot.write_text('scene = "a.glb"\nframes = { first = 1, last = 2 }\nsampels = 4\n')
    error = fault(pinwarp.Shot, shot)
    assert (error.file, error.line, error.key) == (str(shot), 3, "sampels") and "samples" in error.hint
    said = command_line("check", shot, code=2)
    assert str(error) in said
    shot.write_text('scene = "a.glb"\nframes = { first = 1, last = 2 }\nsampels = 4\nstrength = "much"\n')
    error = fault(pinwarp.Shot, shot)
    assert [(single.line, single.key) for single in error.faults] == [(3, "sampels"), (4, "strength")]


def test_a_shot_that_does_not_fit_its_scene(teapot):
    teapot.write_text(teapot.read_text().replace('camera = "ShotCam"', 'camera = "ShotCan"'))
    error = fault(pinwarp.Shot, teapot)
    assert (error.key, error.line) == ("camera", 4) and "ShotCam" in str(error)


def test_lattice_files_name_the_key(tmp_path):
    path = tmp_path / "a.json"
    lattice = pinwarp.Lattice.rest([[0, 0], [1, 1]], [4, 4])
    pinwarp.LatticeFile({"body": {1: lattice}}, 1.0).write(path)
    path.write_text(path.read_text().replace('"dims":[4,4]', '"dims":[4,5]'))
    error = fault(pinwarp.LatticeFile.read, path)
    assert error.file == str(path) and error.key == "layers[0].frames[0].handles"
    other = pinwarp.Lattice.rest([[0, 0], [1, 1]], [5, 5])
    assert "frame 2" in str(fault(pinwarp.LatticeFile, {"body": {1: lattice, 2: other}}, 1.0))


def test_devices_and_frames(teapot):
    shot = pinwarp.Shot(teapot)
    fault(shot.render, 1, device="no such card", kind=pinwarp.Error)
    assert "frames" in fault(shot.check, []).key
    assert "did you mean" in str(fault(pinwarp.Shot, teapot, channels=["depht"]))
    assert "above 0" in str(fault(pinwarp.Shot, teapot, scale=0.0))


def test_exceptions_travel(tmp_path):
    error = fault(pinwarp.Shot, tmp_path / "none.toml", kind=pinwarp.MissingFileError)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error) and (str(again), again.file) == (str(error), error.file)


def test_all_of_the_public_names_have_docstrings():
    for name in pinwarp.__all__:
        thing = getattr(pinwarp, name)
        assert name == "__version__" or thing.__doc__, name
        for own, member in vars(thing).items() if isinstance(thing, type) else ():
            assert own.startswith("_") or member.__doc__ or name == "Pin", f"{name}.{own}"
    assert f'version = "{pinwarp.__version__}"' in (ROOT / "Cargo.toml").read_text()
