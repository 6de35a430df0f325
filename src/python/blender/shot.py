"""Exports the open scene as a shot: `scene.glb` and `shot.toml` in a folder."""

import json
import pathlib
import tempfile

import bpy

from . import pins, screen

# Options of the glTF exporter; older versions of Blender lack some of them.
EXPORT = {
    "export_format": "GLB",
    "export_cameras": True,
    "export_lights": True,
    "export_extras": False,
    "export_animations": True,
    # A single animation for the whole scene.
    "export_animation_mode": "SCENE",
    "export_anim_scene_split_object": False,
    "export_force_sampling": True,
    "export_optimize_animation_size": False,
    "export_frame_range": True,
    "use_visible": True,
}


def folder(scene):
    """Returns the folder of shot and frames: beside the .blend file, or a temporary folder if the file is not saved."""
    if bpy.data.filepath:
        return pathlib.Path(bpy.data.filepath).with_suffix(".pinwarp")
    return pathlib.Path(tempfile.gettempdir()) / "blender.pinwarp" / scene.name


def text(scene):
    """Returns the text of the shot file."""
    width, height, pixel_aspect = screen.size(scene)
    rate = scene.render.fps / scene.render.fps_base
    settings = scene.pinwarp
    lines = [
        "version = 1",
        'scene  = "scene.glb"',
        f"camera = {json.dumps(scene.camera.name)}",
        # Frame f of Blender is at f / rate seconds in the file.
        f"frames = {{ first = {scene.frame_start}, last = {scene.frame_end}, rate = {rate!r}, clip_start = 0 }}",
        f"size   = [{width}, {height}]",
        f"pixel_aspect = {pixel_aspect!r}",
        f"samples = {settings.samples}",
        "",
        "[[layer]]",
        'name    = "pins"',
        f'lattice = {{ dims = [{settings.columns}, {settings.rows}], basis = "bspline" }}',
    ]
    if settings.nodes:
        names = [name.strip() for name in settings.nodes.split(",") if name.strip()]
        lines.append(f"nodes   = {json.dumps(names)}")
    for pin in pins.pins(scene):
        x, y = pin[pins.REST]
        keys = ", ".join(
            f'{{ frame = {frame}, offset = [{dx:.9f}, {dy:.9f}], ease = "smooth" }}'
            for frame, dx, dy in pins.keys(scene, pin)
        )
        lines += [
            "",
            "  [[layer.pin]]",
            f"  name   = {json.dumps(pin.name)}",
            f"  anchor = {{ screen = [{x:.9f}, {y:.9f}], frame = {pin[pins.FRAME]} }}",
            f"  keys   = [ {keys} ]",
        ]
    lines += ["", "[output]", 'path     = "frames/frame.####.exr"', 'channels = ["beauty", "depth", "motion", "id"]']
    return "\n".join(lines) + "\n"


def export(scene):
    """Writes both files; returns the path of the shot file."""
    if scene.camera is None:
        raise ValueError("the scene has no camera; add one and make it active (Ctrl Numpad 0)")
    place = folder(scene)
    place.mkdir(parents=True, exist_ok=True)
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    own = pins.collection(scene)
    hidden = own.hide_viewport
    # Pins and cages are not part of the scene.
    own.hide_viewport = True
    try:
        options = {name: value for name, value in EXPORT.items() if name in known}
        if bpy.app.version < (4, 3, 0):
            # The exporter of Blender 4.2 fails at lights unless it also exports what KHR_animation_pointer animates.
            options["export_pointer_animation"] = True
        bpy.ops.export_scene.gltf(filepath=str(place / "scene.glb"), **options)
    finally:
        own.hide_viewport = hidden
    path = place / "shot.toml"
    path.write_text(text(scene), encoding="utf-8")
    return path
