"""Pinwarp in Blender: pins on the screen deform an animated shot.

The open scene and its camera are exported as a shot. Pins are empties parented to the camera. One button solves the shot and shows the
lattice in the camera's view; another renders warped frames.
"""

import bpy

from . import operators


class Settings(bpy.types.PropertyGroup):
    """The warp settings that a scene stores."""

    columns: bpy.props.IntProperty(name="Columns", default=10, min=4, max=64)
    rows: bpy.props.IntProperty(name="Rows", default=10, min=4, max=64)
    samples: bpy.props.IntProperty(name="Samples", default=16, min=1, max=4096)
    nodes: bpy.props.StringProperty(name="Objects", description="Patterns of names, with * and ?, by commas; empty: all")


class Panel(bpy.types.Panel):
    """The panel in the sidebar of the 3D view."""

    bl_idname = "VIEW3D_PT_pinwarp"
    bl_label = "Pinwarp"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Pinwarp"

    def draw(self, context):
        settings = context.scene.pinwarp
        column = self.layout.column(align=True)
        column.prop(settings, "columns")
        column.prop(settings, "rows")
        column.prop(settings, "samples")
        self.layout.prop(settings, "nodes")
        for operator in operators.ALL:
            self.layout.operator(operator.bl_idname)


CLASSES = (Settings, Panel, *operators.ALL)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.pinwarp = bpy.props.PointerProperty(type=Settings)


def unregister():
    del bpy.types.Scene.pinwarp
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
