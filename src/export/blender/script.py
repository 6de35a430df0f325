"""Warped scene for Blender (tried in 5.0), written by @GENERATOR@, `pinwarp export --to blender`.

Run it with `blender --python THIS_FILE`, or open it in the text editor and press Run. In a new file the default cube,
light and camera are removed first; other objects are kept.
The script imports @SCENE@, which must lie beside it, and deforms these layers:

@LAYERS@
A lattice layer is a Lattice object with one shape key per frame: move its points, add shape keys, or lower the
strength of the modifiers. Between frames, neighbouring keys are interpolated.
"""

import json
import os

import bpy
from mathutils import Matrix

DATA = json.loads(r'''@DATA@''')

# glTF is y-up, Blender is z-up.
BLENDER_FROM_GLTF = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def folder():
    """Returns the folder of this script, also when the text editor runs it, which sets no __file__."""
    if "__file__" in globals():
        return os.path.dirname(os.path.abspath(__file__))
    texts = [text.filepath for text in bpy.data.texts if text.filepath and DATA["scene"] in text.as_string()]
    return os.path.dirname(bpy.path.abspath(texts[0])) if texts else bpy.path.abspath("//")


def remove_default_scene():
    """Removes the default cube, light and camera of a new file, if nothing else was added."""
    names = sorted(thing.name for thing in bpy.data.objects)
    if not bpy.data.filepath and names == ["Camera", "Cube", "Light"]:
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing, do_unlink=True)


def import_scene():
    """Imports the scene; returns its objects by the node numbers that the export stored in them."""
    path = os.path.join(folder(), DATA["scene"])
    if not os.path.exists(path):
        raise RuntimeError(f"{path} is missing: it was written beside this script and has to stay there")
    render = bpy.context.scene.render
    # Key k of the file is at k / nominal seconds; the true rate is set afterwards.
    render.fps, render.fps_base = DATA["nominal"], 1.0
    before = set(bpy.data.objects)
    bpy.ops.import_scene.gltf(filepath=path)
    render.fps_base = DATA["nominal"] / DATA["rate"]
    new = [thing for thing in bpy.data.objects if thing not in before]
    return {thing["pinwarp_node"]: thing for thing in new if "pinwarp_node" in thing}


def fcurves(owner):
    """Returns all curves of a data block, for the data layouts of both Blender 3 and Blender 5."""
    action = owner.animation_data.action
    if not hasattr(action, "layers"):
        return list(action.fcurves)
    strips = [strip for layer in action.layers for strip in layer.strips]
    return [curve for strip in strips for bag in strip.channelbags for curve in bag.fcurves]


def make_linear(owner):
    for curve in fcurves(owner):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def add_lattice(layer):
    """Adds the lattice at rest, with a shape key and a placement for every frame."""
    data = bpy.data.lattices.new(layer["name"])
    data.points_u, data.points_v, data.points_w = layer["dims"]
    for axis in "uvw":
        setattr(data, f"interpolation_type_{axis}", layer["interpolation"])
    thing = bpy.data.objects.new(f"pinwarp {layer['name']}", data)
    bpy.context.scene.collection.objects.link(thing)
    add_shapes(thing, layer["frames"])
    place(thing, layer["frames"])
    return thing


def spread(thing):
    """Returns the extent of the points along each axis, which differs between versions of Blender."""
    points = [point.co for point in thing.data.points]
    sides = [max(point[axis] for point in points) - min(point[axis] for point in points) for axis in range(3)]
    return [side or 1.0 for side in sides]


def add_shapes(thing, frames):
    rest = thing.shape_key_add(name="Basis", from_mix=False)
    points = [0.0] * (3 * len(thing.data.points))
    rest.data.foreach_get("co", points)
    sides = spread(thing)
    numbers = [frame["frame"] for frame in frames]
    for at, frame in enumerate(frames):
        key = thing.shape_key_add(name=f"frame_{frame['shot_frame']:04d}", from_mix=False)
        moved = [by * sides[k % 3] for k, by in enumerate(frame["moved"])]
        key.data.foreach_set("co", [a + b for a, b in zip(points, moved)])
        for neighbour in numbers[max(at - 1, 0):at + 2]:
            key.value = 1.0 if neighbour == frame["frame"] else 0.0
            key.keyframe_insert("value", frame=neighbour)
    make_linear(thing.data.shape_keys)


def place(thing, frames):
    """Keys location, rotation and scale; a lattice that does not move gets no keys."""
    thing.rotation_mode = "QUATERNION"
    matrices = [frame["scene_from_lattice"] for frame in frames]
    moves = any(matrix != matrices[0] for matrix in matrices)
    fit = Matrix.Diagonal([1.0 / side for side in spread(thing)]).to_4x4()
    turn = None
    for frame in frames if moves else frames[:1]:
        rows = Matrix([frame["scene_from_lattice"][4 * row:4 * row + 4] for row in range(4)])
        location, rotation, scale = (BLENDER_FROM_GLTF @ rows @ fit).decompose()
        if turn is not None:
            rotation.make_compatible(turn)
        turn = rotation.copy()
        thing.location, thing.rotation_quaternion, thing.scale = location, rotation, scale
        if moves:
            for path in ("location", "rotation_quaternion", "scale"):
                thing.keyframe_insert(path, frame=frame["frame"])
    if moves:
        make_linear(thing)


def set_up_scene(things):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = DATA["first"], DATA["last"]
    scene.render.resolution_x, scene.render.resolution_y = DATA["size"]
    scene.render.resolution_percentage = 100
    aspect = DATA["pixel_aspect"]
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = max(aspect, 1.0), max(1.0 / aspect, 1.0)
    if DATA["camera"] in things:
        scene.camera = things[DATA["camera"]]
        # The vertical field of view fills the frame's height.
        scene.camera.data.sensor_fit = "VERTICAL"
        if scene.camera.data.type == "PERSP":
            scene.camera.data.angle_y = DATA["yfov"]
        else:
            scene.camera.data.ortho_scale = 2.0 * DATA["ymag"]
    scene.frame_set(DATA["first"])


def main():
    remove_default_scene()
    things = import_scene()
    for layer in DATA["layers"]:
        if layer["baked"]:
            print(f"pinwarp: layer '{layer['name']}': baked shape keys: {layer['baked']}")
            continue
        lattice = add_lattice(layer)
        for node in layer["nodes"]:
            modifier = things[node].modifiers.new(f"pinwarp {layer['name']}", "LATTICE")
            modifier.object = lattice
        print(f"pinwarp: layer '{layer['name']}': a lattice of {layer['dims']}, as exact as single precision")
    set_up_scene(things)


main()
