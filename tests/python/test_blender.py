"""The Blender extension, in the `bpy` of PyPI: a walking character goes to a shot and its lattice comes back."""

import importlib.util
import shutil
import sys

import numpy
import pinwarp
import pytest
from conftest import ROOT, module

SIZE = (480, 270)


@pytest.fixture
def blender(tmp_path):
    """Blender with an empty scene and the extension registered."""
    bpy = module("bpy")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    folder = ROOT / "src/python/blender"
    spec = importlib.util.spec_from_file_location(
        "pinwarp_extension", folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    extension = importlib.util.module_from_spec(spec)
    sys.modules["pinwarp_extension"] = extension
    spec.loader.exec_module(extension)
    extension.register()
    yield bpy
    extension.unregister()
    for name in [name for name in sys.modules if name.startswith("pinwarp_extension")]:
        del sys.modules[name]


@pytest.fixture
def walker(blender, tmp_path):
    """The walking gnome, seen by a camera of its own, in a .blend file."""
    bpy = blender
    shutil.copy(ROOT / "scenes/walker/walker.glb", tmp_path)
    scene = bpy.context.scene
    scene.render.fps = 24
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "walker.glb"))
    scene.frame_start, scene.frame_end = 1, 12
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.camera = next(thing for thing in scene.objects if thing.type == "CAMERA")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "walker.blend"))
    return bpy


def near_the_frame(points):
    """Points that are seen, or nearly: pixels."""
    return points[(numpy.abs(points - numpy.array(SIZE) / 2) < SIZE).all(axis=1)]


def seen_by_blender(bpy, scene, frame, names=()):
    """Where Blender sees the vertices of meshes, pixels, y up."""
    from bpy_extras.object_utils import world_to_camera_view

    scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    places = []
    for thing in scene.objects:
        is_wanted = thing.name in names if names else not thing.name.startswith("pinwarp")
        if thing.type == "MESH" and is_wanted and thing.visible_get():
            evaluated = thing.evaluated_get(graph)
            for vertex in evaluated.to_mesh().vertices:
                x, y, depth = world_to_camera_view(scene, scene.camera, evaluated.matrix_world @ vertex.co)
                if depth > 0:
                    places.append((x * SIZE[0], y * SIZE[1]))
            evaluated.to_mesh_clear()
    return near_the_frame(numpy.array(places))


def farthest(points, others):
    """How far the farthest of some points is from the nearest of others."""
    return max(numpy.linalg.norm(others - point, axis=1).min() for point in points)


def test_the_scene_goes_out_to_a_tenth_of_a_pixel(walker, tmp_path):
    scene = walker.context.scene
    assert walker.ops.pinwarp.export() == {"FINISHED"}
    shot = pinwarp.Shot(tmp_path / "walker.pinwarp/shot.toml")
    assert (shot.frames, shot.size) == (range(1, 13), SIZE)
    for frame in (1, 6, 12):
        theirs = seen_by_blender(walker, scene, frame)
        ours = near_the_frame(numpy.concatenate([part["points"] for part in shot.project(frame)]) * SIZE[1])
        assert len(ours) > 100
        assert max(farthest(ours, theirs), farthest(theirs, ours)) < 0.1, frame
    # It moves, so another frame is another place.
    assert farthest(seen_by_blender(walker, scene, 6), theirs) > 1


def test_pins_go_out_and_the_lattice_comes_back(walker, tmp_path):
    from pinwarp_extension import pins, screen

    bpy, scene = walker, walker.context.scene
    scene.frame_set(1)
    places = seen_by_blender(bpy, scene, 1, ("Hat", "Legs"))
    # Just below the highest vertex and above the lowest.
    high, low = places[places[:, 1].argmax()] - [0, 2], places[places[:, 1].argmin()] + [0, 2]
    made = []
    for x, y in (high / SIZE[1], low / SIZE[1]):
        scene.cursor.location = scene.camera.matrix_world @ screen.camera_point(scene, x, y, 3.0)
        assert bpy.ops.pinwarp.add_pin() == {"FINISHED"}
        made.append(pins.pins(scene)[-1])
        assert numpy.abs(numpy.array(made[-1]["pinwarp_rest"]) - [x, y]).max() < 1e-5
    top = made[0]
    top.keyframe_insert("location", frame=1)
    x, y = top["pinwarp_rest"]
    pins.move(scene, top, x + 0.1, y + 0.05)
    top.keyframe_insert("location", frame=12)
    assert bpy.ops.pinwarp.solve() == {"FINISHED"}
    shot = pinwarp.Shot(tmp_path / "walker.pinwarp/shot.toml")
    pulled = next(pin for pin in shot.pins(12) if pin["name"] == top.name)
    still = next(pin for pin in shot.pins(1) if pin["name"] == top.name)
    assert numpy.allclose(numpy.subtract(pulled["target"], pulled["rest"]), [0.1, 0.05], atol=1e-5)
    assert numpy.allclose(still["target"], still["rest"], atol=1e-5)
    # The cage stands in the camera's view where the handles are.
    cage = bpy.data.objects["pinwarp pins"]
    lattices = shot.lattices()
    for frame in (1, 7, 12):
        scene.frame_set(frame)
        evaluated = cage.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = evaluated.to_mesh()
        seen = [screen.place(scene, evaluated.matrix_world @ vertex.co) for vertex in mesh.vertices]
        off = numpy.array(seen) - lattices.lattice(frame).handles.reshape(-1, 2)
        assert numpy.abs(off).max() * SIZE[1] < 0.1, frame
    # Made anew, there is one cage still, and the shot does not contain it.
    assert bpy.ops.pinwarp.solve() == {"FINISHED"}
    assert [thing.name for thing in bpy.data.objects if thing.name.startswith("pinwarp")] == ["pinwarp pins"]
    assert not any("pinwarp" in node for node in pinwarp.Shot(shot.path).scene.nodes)


def test_frames_are_rendered(walker, tmp_path):
    scene = walker.context.scene
    scene.frame_end, scene.pinwarp.samples = 2, 1
    assert walker.ops.pinwarp.render() == {"FINISHED"}
    assert len(list((tmp_path / "walker.pinwarp/frames").glob("*.exr"))) == 2


def test_faults_are_told(blender):
    with pytest.raises(RuntimeError, match="no camera"):
        blender.ops.pinwarp.export()


def test_the_manifest_is_that_of_the_package():
    tomllib = module("tomllib")
    manifest = tomllib.loads((ROOT / "src/python/blender/blender_manifest.toml").read_text())
    assert manifest["version"] == pinwarp.__version__ and pinwarp.__version__ in manifest["wheels"][0]
