"""The open scene as a shot: `scene.glb` and `shot.toml` in a folder."""

import json
import pathlib
import tempfile

import bpy

from . import pins, screen

# Older versions of Blender lack some of these.
EXPORT = {
    "export_format": "GLB",
    "export_cameras": True,
    "export_lights": True,
    "export_extras": False,
    "export_animations": True,
    # One animation of everything.
    "export_animation_mode": "SCENE",
    "export_anim_scene_split_object": False,
    "export_force_sampling": True,
    "export_optimize_animation_size": False,
    "export_frame_range": True,
    "use_visible": True,
}


def folder(scene):
    """Where shot and frames go: beside the .blend file, else a temporary folder that stays the same for the session."""
    if bpy.data.filepath:
        return pathlib.Path(bpy.data.filepath).with_suffix(".pinwarp")
    return pathlib.Path(tempfile.gettempdir()) / "blender.pinwarp" / scene.name


def text(scene):
    """The shot file."""
    width, height, pixel_aspect = screen.size(scene)
    rate = scene.render.fps / scene.render.fps_base
    settings = scene.pinwarp
    lines = [
        "version = 1",
        'scene  = "scene.glb"',
        f"camera = {json.dumps(scene.camera.name)}",
        # Frame f of Blender lies at f / rate seconds of the file.
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
    """Writes both files; where the shot lies."""
    if scene.camera is None:
        raise ValueError("the scene has no camera; add one and make it active (Ctrl Numpad 0)")
    place = folder(scene)
    place.mkdir(parents=True, exist_ok=True)
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    own = pins.collection(scene)
    hidden = own.hide_viewport
    # Pins and cages are no part of the scene.
    own.hide_viewport = True
    try:
        options = {name: value for name, value in EXPORT.items() if name in known}
        bpy.ops.export_scene.gltf(filepath=str(place / "scene.glb"), **options)
    finally:
        own.hide_viewport = hidden
    path = place / "shot.toml"
    path.write_text(text(scene), encoding="utf-8")
    return path
