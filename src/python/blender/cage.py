"""Shows the solved lattice in the camera's view: a cage of its handles with one shape key per frame."""

import bpy

from . import pins, screen

# Distance of the cage from the camera, in near clip distances: a little behind the near plane.
NEAR = 1.5


def build(scene, layer, lattices):
    """Rebuilds the cage of a layer from lattices by frame; returns its object."""
    name = f"pinwarp {layer}"
    old = bpy.data.objects.get(name)
    if old:
        bpy.data.objects.remove(old, do_unlink=True)
    frames = sorted(lattices)
    columns, rows = lattices[frames[0]].dims
    edges = [(row * columns + at, row * columns + at + 1) for row in range(rows) for at in range(columns - 1)]
    edges += [(row * columns + at, (row + 1) * columns + at) for row in range(rows - 1) for at in range(columns)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points(scene, lattices[frames[0]].rest_handles), edges, [])
    thing = bpy.data.objects.new(name, mesh)
    pins.collection(scene).objects.link(thing)
    thing.parent = scene.camera
    thing.show_in_front = thing.hide_render = True
    thing.shape_key_add(name="rest", from_mix=False)
    for at, frame in enumerate(frames):
        key = thing.shape_key_add(name=f"frame_{frame:04d}", from_mix=False)
        flat = [value for point in points(scene, lattices[frame].handles) for value in point]
        key.data.foreach_set("co", flat)
        for neighbour in frames[max(at - 1, 0) : at + 2]:
            key.value = 1.0 if neighbour == frame else 0.0
            key.keyframe_insert("value", frame=neighbour)
    return thing


def points(scene, handles):
    """Converts handles (rows, columns, 2) to points in camera space."""
    depth = NEAR * scene.camera.data.clip_start
    return [screen.camera_point(scene, x, y, depth) for x, y in handles.reshape(-1, 2)]
