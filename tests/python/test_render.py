"""Shots in memory have the pixels of the files that the command line writes."""

import numpy
import pinwarp
import pytest
from conftest import ROOT, command_line, read_exr


def assert_same(frame, file):
    assert set(frame) == set(file)
    for name, stored in file.items():
        own = frame[name]
        assert own.shape == stored.shape and own.dtype == numpy.float32
        assert numpy.array_equal(own.astype(stored.dtype), stored), name


def test_a_frame_has_the_pixels_of_the_file(teapot):
    command_line("render", teapot, "--frames", "12", "--device", "cpu")
    shot = pinwarp.Shot(teapot)
    frame = shot.render(12, device="cpu")
    file = read_exr(teapot.parent / "out/teapot.0012.exr")
    assert_same(frame, file)
    assert frame["A"].max() > 0.9 and frame["id.layer"].max() == 1
    # The comparison can fail: another frame is another picture.
    assert not numpy.array_equal(shot.render(2, device="cpu")["R"], frame["R"])


def test_a_frame_knows_its_place(teapot):
    frame = pinwarp.Shot(teapot).render(1, device="cpu")
    assert (frame.number, frame.size, frame.data_window, frame.pixel_aspect) == (1, (160, 90), (0, 0, 160, 90), 1.0)
    assert frame.rgba().shape == (90, 160, 4) and frame.preview().dtype == numpy.uint8
    assert "160 x 90" in repr(frame)


def test_pictures_have_the_pixels_of_the_file(tmp_path):
    shot = ROOT / "scenes/flag/shot.toml"
    output = tmp_path / "flag.####.exr"
    command_line("render", shot, "--frames", "7", "-o", output)
    frame = pinwarp.Shot(shot).render(7)
    assert_same(frame, read_exr(tmp_path / "flag.0007.exr"))


def test_plates_have_the_pixels_of_the_file(tmp_path, picture):
    from conftest import write_exr

    write_exr(tmp_path / "plate.0001.exr", picture)
    shot = tmp_path / "shot.toml"
    shot.write_text(
        'plate = "plate.####.exr"\nframes = { first = 1, last = 1 }\nsize = [128, 72]\n[[layer]]\n[[layer.pin]]\n'
        "anchor = { screen = [0.9, 0.5] }\nkeys = [{ frame = 1, offset = [0.1, 0.1] }]\n"
    )
    command_line("warp", "--shot", shot, "-o", tmp_path / "warped.####.exr", "--device", "cpu")
    assert_same(pinwarp.Shot(shot).render(1), read_exr(tmp_path / "warped.0001.exr"))


def test_what_the_caller_says_counts(teapot):
    shot = pinwarp.Shot(teapot, scale=0.5, samples=1, channels=["depth"], output=teapot.parent / "other.####.exr")
    assert (shot.size, shot.channels, shot.output.name) == ((80, 45), ["depth"], "other.####.exr")
    assert list(shot.render(1, device="cpu")) == ["depth.Z"]
    assert (shot.frames, shot.rate, shot.layers) == (range(1, 25), 24.0, ["teapot"])


def test_frames_come_one_after_the_other(teapot):
    shot = pinwarp.Shot(teapot, channels=["beauty"])
    steps = []
    frames = list(shot.render_frames([3, 1], device="cpu", progress=lambda done, of: steps.append((done, of))))
    assert [frame.number for frame in frames] == [3, 1]
    assert numpy.array_equal(frames[1]["G"], shot.render(1, device="cpu")["G"])
    assert steps[0] == (0, 2) and steps[-1] == (2, 2) and steps == sorted(steps)


def test_files_are_those_of_the_command_line(teapot):
    steps = []
    shot = pinwarp.Shot(teapot)
    report = shot.write([5, 6], device="cpu", progress=lambda done, of: steps.append((done, of)))
    assert (report["rendered"], report["failed"], report["failures"]) == (2, 0, []) and steps[-1] == (2, 2)
    own = (teapot.parent / "out/teapot.0005.exr").read_bytes()
    command_line("render", teapot, "--frames", "5", "--device", "cpu", "--overwrite")
    assert (teapot.parent / "out/teapot.0005.exr").read_bytes() == own
    with pytest.raises(pinwarp.Error, match="exist"):
        shot.write([5])
    assert shot.write([5, 6], existing="resume", device="cpu")["kept"] == 2


def test_a_check_tells_what_a_render_would(teapot):
    report = pinwarp.Shot(teapot).check([1, 12])
    assert [frame["frame"] for frame in report["frames"]] == [1, 12] and report["failures"] == []
    layer = report["frames"][1]["layers"][0]
    assert layer["layer"] == "teapot" and layer["pin_error_px"] < 0.1 and layer["solve"]["is_converged"]


def test_pins_and_lattices_agree(teapot):
    shot = pinwarp.Shot(teapot)
    pins = shot.pins(12)
    assert [pin["name"] for pin in pins] == ["spout", "handle", "base left", "base middle", "base right"]
    file = shot.lattices([12])
    assert (file.layers, file.frames("teapot"), file.frame_aspect) == (["teapot"], [12], 160 / 90)
    lattice = file.lattice(12)
    rest, target = (numpy.array([pin[key] for pin in pins]) for key in ("rest", "target"))
    assert numpy.abs(lattice.warp(rest) - target).max() < 1e-3
    assert numpy.abs(rest - target).max() > 0.05


def test_lattices_and_files_tell_what_a_check_tells(teapot):
    text = teapot.read_text()
    anchor = next(line for line in text.splitlines() if line.strip().startswith("anchor"))
    rival = f'[[layer.pin]]\nname = "rival"\n{anchor.strip()}\nkeys = [{{ frame = 1, offset = [0.3, 0.3] }}]\n'
    torn = teapot.with_name("torn.toml")
    torn.write_text(text.replace("[output]", rival + "[output]") if "[output]" in text else text + rival)
    shot = pinwarp.Shot(torn)
    told = [(frame["frame"], warning) for frame in shot.check([1, 2])["frames"] for warning in frame["warnings"]]
    assert any("rival" in warning for _, warning in told)
    assert shot.lattices([1, 2]).warnings == told
    written = shot.write([1, 2], device="cpu", existing="overwrite")["warnings"]
    assert [tuple(warning) for warning in written] == told


def test_a_scene_is_projected(teapot):
    scene = pinwarp.Scene(teapot.parent / "teapot.glb", camera="ShotCam", size=(160, 90))
    assert "Teapot" in scene.nodes and scene.cameras == ["ShotCam"]
    parts = {part["node"]: part for part in scene.project(1)}
    part = parts["Teapot"]
    assert part["points"].shape == (len(part["depth"]), 2) and part["triangles"].dtype == numpy.uint32
    assert part["triangles"].max() < len(part["points"]) and (part["depth"] > 0).all()
    # Where the drawn teapot is, its points are.
    ids = pinwarp.Shot(teapot).render(1, device="cpu")["id.layer"]
    rows, columns = numpy.nonzero(ids == 1)
    for places, pixels, size in ((part["points"][:, 0] * 90, columns, 160), ((1 - part["points"][:, 1]) * 90, rows, 90)):
        assert abs(places.min() - pixels.min()) < 2 and abs(places.max() - pixels.max()) < 2, size
    own = {part["node"]: part for part in pinwarp.Shot(teapot).project(1)}
    assert numpy.array_equal(own["Teapot"]["points"], part["points"])
