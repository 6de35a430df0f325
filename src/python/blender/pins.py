"""Pins: empties parented to the camera, so that dragging one moves its position on the screen.

A pin is anchored to the surface that was visible under it when it was created, and follows that surface. The distance that its empty has
moved on the screen since then is the pin's offset; keyframes of the empty become keys of the pin.
"""

import bpy

from . import screen

REST, FRAME = "pinwarp_rest", "pinwarp_frame"
COLLECTION = "Pinwarp"


def collection(scene):
    """Returns the collection that holds the objects of this extension."""
    found = bpy.data.collections.get(COLLECTION) or bpy.data.collections.new(COLLECTION)
    if found.name not in scene.collection.children:
        scene.collection.children.link(found)
    return found


def pins(scene):
    """Returns the empties that are pins, sorted by name."""
    objects = collection(scene).objects
    return sorted((thing for thing in objects if REST in thing), key=lambda thing: thing.name)


def add(scene, point, name="pin"):
    """Creates a pin at a point in world space, in the scene's current frame."""
    thing = bpy.data.objects.new(name, None)
    thing.empty_display_type = "SPHERE"
    thing.empty_display_size = 0.02 * screen.depth(scene, point)
    thing.show_in_front = True
    collection(scene).objects.link(thing)
    thing.parent = scene.camera
    x, y = screen.place(scene, point)
    thing.location = screen.camera_point(scene, x, y, screen.depth(scene, point))
    thing[REST], thing[FRAME] = [x, y], scene.frame_current
    return thing


def move(scene, pin, x, y):
    """Moves a pin's empty to a position on the screen, keeping its distance from the camera."""
    pin.location = screen.camera_point(scene, x, y, -pin.location.z)


def key_frames(pin):
    """Returns the frames at which the location of an empty is keyed."""
    action = pin.animation_data.action if pin.animation_data else None
    if action is None:
        return []
    curves = list(action.fcurves) if not hasattr(action, "layers") else [
        curve
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        for curve in bag.fcurves
    ]
    own = [curve for curve in curves if curve.data_path == "location"]
    return sorted({round(key.co.x) for curve in own for key in curve.keyframe_points})


def keys(scene, pin):
    """Returns the key frames, each with the distance that the empty has moved on the screen since the pin was created."""
    rest, kept = pin[REST], scene.frame_current
    found = []
    for frame in key_frames(pin) or [pin[FRAME]]:
        scene.frame_set(frame)
        x, y = screen.place(scene, pin.matrix_world.translation)
        found.append((frame, x - rest[0], y - rest[1]))
    scene.frame_set(kept)
    return found
