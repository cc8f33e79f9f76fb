# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: our settings, and those of Blender that every engine with Cycles' nodes shows."""

import bpy

ENGINE = "GNURT"
# Panels that belong to other engines, or that show what is not supported.
EXCLUDED = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_simplify", "RENDER_PT_eevee_film"}


class RENDER_PT_gnurt_sampling(bpy.types.Panel):
    bl_label = "Sampling"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        layout, settings = self.layout, context.scene.gnurt
        layout.use_property_split = True
        for name in ("samples", "preview_samples", "noise", "denoise", "pixel_noise", "seed", "threads"):
            layout.prop(settings, name)


class RENDER_PT_gnurt_light(bpy.types.Panel):
    bl_label = "Light paths"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        layout, settings = self.layout, context.scene.gnurt
        layout.use_property_split = True
        for name in ("integrator", "guide", "max_depth", "clamp"):
            layout.prop(settings, name)
        layout.prop(context.scene.render, "film_transparent")


class RENDER_PT_gnurt_warnings(bpy.types.Panel):
    bl_label = "Not shown"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES and bool(context.scene.gnurt.warnings)

    def draw(self, context):
        for line in context.scene.gnurt.warnings.split("\n"):
            self.layout.label(text=line, icon="ERROR")


class NodePanel(bpy.types.Panel):
    """The surface of a material, a world or a light: its node tree."""

    bl_label = "Surface"
    bl_space_type, bl_region_type = "PROPERTIES", "WINDOW"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE and cls.shown(context) is not None

    def draw(self, context):
        tree = self.shown(context).node_tree
        output = tree.get_output_node("ALL") or tree.get_output_node("CYCLES") if tree else None
        if output is None:
            self.layout.label(text="No output node")
            return
        self.layout.use_property_split = True
        self.layout.template_node_view(tree, output, output.inputs["Surface"])


class MATERIAL_PT_gnurt_surface(NodePanel):
    bl_context = "material"

    @staticmethod
    def shown(context):
        return context.material


class WORLD_PT_gnurt_surface(NodePanel):
    bl_context = "world"

    @staticmethod
    def shown(context):
        return context.world


class DATA_PT_gnurt_light(bpy.types.Panel):
    bl_label = "Light"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "data"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE and context.light is not None

    def draw(self, context):
        layout, light = self.layout, context.light
        layout.use_property_split = True
        layout.prop(light, "type", expand=True)
        for name in ("color", "energy", "exposure", "normalize"):
            if hasattr(light, name):
                layout.prop(light, name)
        names = {
            "POINT": ("shadow_soft_size",),
            "SUN": ("angle",),
            "SPOT": ("shadow_soft_size", "spot_size", "spot_blend"),
            "AREA": ("shape", "size", "size_y", "spread"),
        }
        for name in names[light.type]:
            if name != "size_y" or light.shape in {"RECTANGLE", "ELLIPSE"}:
                layout.prop(light, name)


CLASSES = (
    RENDER_PT_gnurt_sampling,
    RENDER_PT_gnurt_light,
    RENDER_PT_gnurt_warnings,
    MATERIAL_PT_gnurt_surface,
    WORLD_PT_gnurt_surface,
    DATA_PT_gnurt_light,
)


def shared_panels():
    """Blender's own panels that its built-in engines without an interface of their own show."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if "BLENDER_RENDER" in engines and panel.__name__ not in EXCLUDED:
            yield panel


def register():
    for panel in CLASSES:
        bpy.utils.register_class(panel)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for panel in reversed(CLASSES):
        bpy.utils.unregister_class(panel)
