"""The operators behind the buttons."""

import bpy
import pinwarp

from . import cage, pins, shot


class Failing:
    """Base of the operators: reports errors to the user and then cancels, so that the scene stays unchanged."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            self.report({"INFO"}, self.run(context.scene))
        except (pinwarp.Error, ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class AddPin(Failing, bpy.types.Operator):
    """Adds a pin on the surface at the 3D cursor, as the camera sees it in this frame; drag its empty, and key its location"""

    bl_idname = "pinwarp.add_pin"
    bl_label = "Add Pin at Cursor"

    def run(self, scene):
        if scene.camera is None:
            raise ValueError("the scene has no camera; add one and make it active")
        return f"added {pins.add(scene, scene.cursor.location).name}"


class Export(Failing, bpy.types.Operator):
    """Writes scene and shot for pinwarp's own programs"""

    bl_idname = "pinwarp.export"
    bl_label = "Export Shot"

    def run(self, scene):
        return f"wrote {shot.export(scene)}"


class Solve(Failing, bpy.types.Operator):
    """Solves all frames and shows the lattice in the camera's view, keyed by shape keys"""

    bl_idname = "pinwarp.solve"
    bl_label = "Solve"

    def run(self, scene):
        opened = pinwarp.Shot(shot.export(scene))
        found = opened.lattices(progress=progress)
        for layer in found.layers:
            cage.build(scene, layer, {frame: found.lattice(frame, layer) for frame in found.frames(layer)})
        report = opened.check()
        worst = max((layer["pin_error_px"] for frame in report["frames"] for layer in frame["layers"]), default=0.0)
        return f"solved {len(opened.frames)} frames; pins are off by at most {worst:.2f} px"


class Render(Failing, bpy.types.Operator):
    """Renders the warped frames into EXR files beside the .blend file"""

    bl_idname = "pinwarp.render"
    bl_label = "Render Frames"

    def run(self, scene):
        opened = pinwarp.Shot(shot.export(scene))
        report = opened.write(existing="overwrite", progress=progress)
        if report["failures"]:
            raise ValueError(report["failures"][0]["error"])
        return f"{report['rendered']} frames in {opened.output.parent}"


def progress(done, of):
    """Shows the progress beside the mouse pointer."""
    manager = bpy.context.window_manager
    if done == 0:
        manager.progress_begin(0, of)
    manager.progress_update(done)
    if done == of:
        manager.progress_end()


ALL = (AddPin, Export, Solve, Render)
