"""Conversions to pinwarp's screen coordinates, for the scene's camera.

Screen positions are in frame heights, x right, y up, from the lower left corner of the frame.
"""

from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector


def size(scene):
    """Returns width and height of the frame in pixels, and the width of a pixel divided by its height."""
    render = scene.render
    scale = render.resolution_percentage / 100
    width, height = round(render.resolution_x * scale), round(render.resolution_y * scale)
    return width, height, render.pixel_aspect_x / render.pixel_aspect_y


def aspect(scene):
    """Returns the width of the frame in frame heights."""
    width, height, pixel_aspect = size(scene)
    return width * pixel_aspect / height


def place(scene, point):
    """Returns the screen position of a point in world space, in the scene's current frame."""
    x, y, _ = world_to_camera_view(scene, scene.camera, Vector(point))
    return x * aspect(scene), y


def depth(scene, point):
    """Returns the distance of a point in world space along the camera's view axis."""
    return world_to_camera_view(scene, scene.camera, Vector(point))[2]


def camera_point(scene, x, y, depth):
    """Returns the point in camera space at a screen position and a depth along the view axis."""
    # view_frame lists the corners from the upper right, clockwise; for a perspective camera they lie at some depth.
    _, right, corner, upper = scene.camera.data.view_frame(scene=scene)
    seen = corner + (right - corner) * (x / aspect(scene)) + (upper - corner) * y
    if scene.camera.data.type == "ORTHO":
        return Vector((seen.x, seen.y, -depth))
    return seen * (depth / -seen.z)
