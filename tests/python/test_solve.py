"""The bare solver, and lattices."""

import json

import numpy
import pinwarp
import pytest
from conftest import command_line


def test_pins_are_met_and_the_rest_turns_along(strip):
    points, triangles = strip
    turn = numpy.array([[0.0, 1.0], [-1.0, 0.0]])
    rest = numpy.array([[0.2, 0.5], [1.8, 0.5]])
    solution = pinwarp.solve(points, triangles, numpy.concatenate([rest, rest @ turn], axis=1))
    assert max(solution.report["pin_errors"]) < 1e-9 and solution.report["is_converged"]
    # A turn of all pins is a turn of all points.
    assert numpy.abs(solution.lattice.warp(points) - points @ turn).max() < 1e-5
    assert "Solution" in repr(solution)


def test_the_command_line_finds_the_same(strip, tmp_path):
    points, triangles = strip
    pins = [[0.2, 0.5, 0.1, 0.6], [1.8, 0.5, 1.5, 0.9], [1.0, 0.1, 1.0, 0.1]]
    box = [[-0.2, -0.1], [2.2, 1.1]]
    problem = {
        "vertices": points.tolist(),
        "triangles": triangles.tolist(),
        "dims": [8, 6],
        "bbox": box,
        "pins": [{"point": pin[:2], "target": pin[2:]} for pin in pins],
    }
    (tmp_path / "problem.json").write_text(json.dumps(problem))
    command_line("solve", "problem.json", "-o", "result.json", folder=tmp_path)
    result = json.loads((tmp_path / "result.json").read_text())
    solution = pinwarp.solve(points, triangles, pins, dims=(8, 6), box=box)
    assert numpy.array_equal(solution.lattice.handles.reshape(-1, 2), numpy.array(result["P"]))


def test_three_dimensions():
    points = numpy.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    triangles = [[0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 3, 7], [2, 7, 6]]
    solution = pinwarp.solve(points, triangles, [[0.5, 0.5, 0.5, 0.7, 0.5, 0.4]])
    lattice = solution.lattice
    assert (lattice.space, lattice.dims, lattice.handles.shape) == ("world", [5, 5, 5], (5, 5, 5, 3))
    assert numpy.abs(lattice.warp(points) - points - [0.2, 0, -0.1]).max() < 1e-6


def test_without_pins_nothing_moves(strip):
    points, triangles = strip
    solution = pinwarp.solve(points, triangles, [])
    assert numpy.abs(solution.lattice.warp(points) - points).max() < 1e-12 and solution.report["warnings"]


def test_options_reach_the_solver(strip):
    points, triangles = strip
    pins = [[0.2, 0.5, 1.4, 0.5], [1.8, 0.5, 0.6, 0.5]]
    free = pinwarp.solve(points, triangles, pins)
    limited = pinwarp.solve(points, triangles, pins, guard="limit")
    assert limited.report["folded_model_cells"] == 0
    assert not numpy.array_equal(free.lattice.handles, limited.lattice.handles)
    assert pinwarp.solve(points, triangles, pins, energy="edge", basis="bilinear").lattice.basis == "bilinear"


def test_a_lattice_is_its_arrays():
    lattice = pinwarp.Lattice.rest([[0, 0], [2, 1]], [5, 4], basis="bernstein")
    assert (lattice.dims, lattice.box, lattice.basis) == ([5, 4], [[0, 0], [2, 1]], "bernstein")
    handles = lattice.handles
    assert handles.shape == (4, 5, 2) and numpy.allclose(handles[3, 4], [2, 1]) and numpy.allclose(handles[0, 4], [2, 0])
    handles += [0.25, -0.5]
    assert numpy.array_equal(lattice.handles, lattice.rest_handles), "handles are copies"
    moved = pinwarp.Lattice(handles, lattice.box, "bernstein")
    points = numpy.array([[0.5, 0.5], [1.9, 0.1], [5.0, 5.0]])
    assert numpy.allclose(moved.warp(points), points + [0.25, -0.5])
    assert numpy.allclose(moved.evaluate(points), points + [0.25, -0.5])
    assert numpy.allclose(moved.gradient(points), numpy.eye(2)) and moved.gradient(points).shape == (3, 2, 2)
    assert moved.folds() == [] and numpy.allclose(moved.with_strength(0).handles, lattice.handles)
    assert moved == pinwarp.Lattice(handles, lattice.box, "bernstein") and moved != lattice


def test_folds_are_found():
    handles = pinwarp.Lattice.rest([[0, 0], [1, 1]], [4, 4], "bilinear").handles
    handles[1, 1, 0] = 0.9
    assert [1, 1] in pinwarp.Lattice(handles, [[0, 0], [1, 1]], "bilinear").folds()


def test_lattice_files_come_back(tmp_path):
    lattices = {}
    for frame, shift in ((1, 0.0), (3, 0.5)):
        handles = pinwarp.Lattice.rest([[0, 0], [1, 1]], [4, 4]).handles + [shift, 0]
        lattices[frame] = pinwarp.Lattice(handles, [[0, 0], [1, 1]])
    file = pinwarp.LatticeFile({"body": lattices}, frame_aspect=16 / 9, rate=25)
    file.write(tmp_path / "body.json")
    back = pinwarp.LatticeFile.read(tmp_path / "body.json")
    assert (back.layers, back.frames(), back.rate, back.frame_aspect) == (["body"], [1, 3], 25, 16 / 9)
    assert back.lattice(3) == lattices[3] and numpy.allclose(back.lattice(2, "body").handles[0, 0, 0], -0.75)
    with pytest.raises(pinwarp.InputError, match="did you mean"):
        back.lattice(1, "bodi")
