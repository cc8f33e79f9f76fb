# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: final pictures, and the viewport.

With persistent data a frame changes the scene of the last one (`kept`); else it is exported anew. The viewport keeps its scene while only the
view moves.
"""

import time
import traceback

import bpy
import numpy as np

from . import aovs, catchers, holdouts, kept, light_passes, motion, passes, seen_passes
from .nodes import scripts
from .scene import Export
from .speeds import Speeds
from .still import Still
from .warned import Warned

# Seconds between two pictures on the screen.
INTERVAL = 1.0


class Cancelled(Exception):
    """The user has stopped the rendering."""


class GnurtEngine(bpy.types.RenderEngine):
    bl_idname = "GNURT"
    bl_label = "GNU RT"
    bl_use_preview = True
    bl_use_shading_nodes_custom = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True

    def update_script_node(self, node=None):
        """Blender calls this when the user changes or reloads a script."""
        scripts.update(node, self.report)

    # Final pictures

    def update_render_passes(self, scene=None, renderlayer=None):
        passes.registered(self, scene, renderlayer)

    def render(self, depsgraph):
        self.has_result = False
        try:
            self._render(depsgraph)
        except Cancelled:
            pass
        except Exception as error:
            traceback.print_exc()
            self.report({"ERROR"}, f"GNU RT: {error}")
        if not self.has_result:
            # Blender does not survive the saving of a picture that never began.
            box = picture_size(depsgraph.scene)
            self.end_result(self.begin_result(0, 0, *box, layer=depsgraph.view_layer.name))

    def _render(self, depsgraph):
        scene, layer = depsgraph.scene, depsgraph.view_layer
        size = picture_size(scene)
        warned = Warned()
        camera = self.camera_override or scene.camera
        if camera is None:
            raise ValueError("the scene has no camera")
        self.update_stats("", "Reading the scene")
        ways = motion.Ways(self, depsgraph, camera, size, warned) if scene.render.use_motion_blur else None
        wanted = passes.wanted(layer, warned)
        if scene.gnurt.integrator != "path":
            for name in [name for name in wanted if name in light_passes.BY_NAME]:
                warned(f"view layer '{layer.name}': the pass {name} needs the path integrator")
                del wanted[name]
        speeds = Speeds(self, depsgraph, camera, size, warned) if "Vector" in wanted else None
        camera_now = camera.evaluated_get(depsgraph)
        has_catchers = catchers.are_there(depsgraph)

        name = scene.name, layer.name
        # Other times of the same frame are evaluated for motion; then the list of updates is not that of the frame.
        still = Still(depsgraph, kept.holds(name, getattr(self, "shown", None)) and not ways and not speeds)

        def made(recorder):
            part = "others" if has_catchers else None
            export = Export(depsgraph, size, camera_now, warned=warned, recorder=recorder, shapes=ways and ways.shapes, part=part, still=still)
            return export if export.put_all(self.is_stopped) else None

        export = kept.exported(name, made, scene.render.use_persistent_data)
        self.shown = export.scene.scene if export and scene.render.use_persistent_data else None
        if export is None:
            return
        has_holdouts = holdouts.are_there(export, depsgraph)
        if scene.render.use_multiview:
            warned("stereo views are rendered from one camera")
        options = self.options(scene, layer, size, export, wanted, has_holdouts or has_catchers)
        if ways:
            options |= ways.options(export)
        share = holdouts.Shares(export, depsgraph, options) if has_holdouts else None
        caught = catchers.Caught(export, options, ways) if has_catchers else None
        others = {name: made(export, options) for name, made in seen_passes.SEEN.items() if name in wanted}
        region = options.get("crop")
        x0, y0, x1, y1 = region or (0, 0, *size)
        box = slice(y0, y1), slice(x0, x1)
        result = self.begin_result(0, 0, x1 - x0, y1 - y0, layer=layer.name)
        self.has_result, self.so_far = True, None
        try:
            picture = self.grow(export, options, lambda done: self.show(result, done, scene, export, {}, share, box, caught=caught))
            if scene.gnurt.denoise:
                picture = picture.denoise()
            self.show(result, picture, scene, export, wanted, share, box, others, speeds, caught)
        except Cancelled:
            # The samples so far stay.
            if self.so_far is not None:
                self.show(result, self.so_far, scene, export, {}, share, box, caught=caught)
            self.end_result(result)
            raise
        self.end_result(result)
        for field, value in passes.matte_fields(layer, picture).items():
            self.get_result().stamp_data_add_field(field, value)
        self.tell(scene, warned)

    def options(self, scene, layer, size, export, wanted, has_holdouts):
        """Options of `Scene.render`."""
        settings = scene.gnurt
        transparent = scene.render.film_transparent or has_holdouts
        options = {"width": size[0], "height": size[1], "spp": settings.samples, "integrator": settings.integrator}
        options |= {"max_depth": settings.max_depth, "seed": settings.seed, "threads": settings.threads, "filter": "blackman-harris"}
        options |= {"pixel_noise": settings.pixel_noise, "guide": settings.guide}
        options["layers"] = bool(wanted) or transparent or settings.denoise
        found, light = passes.mattes(layer), light_passes.layers(wanted)
        own = aovs.layers(export, wanted)
        seen = ["denoise"] if settings.denoise else []
        if found or light or own or seen:
            options |= {"layers": ["all", *seen, *(word for word, _ in found), *light, *own], "crypto_depth": passes.matte_depth(layer)}
        if settings.clamp > 0:
            options["clamp"] = settings.clamp
        if settings.noise > 0:
            options["noise"] = settings.noise
        if scene.render.use_border:
            r = scene.render
            x0, x1 = int(r.border_min_x * size[0]), int(r.border_max_x * size[0])
            y0, y1 = int((1 - r.border_max_y) * size[1]), int((1 - r.border_min_y) * size[1])
            options["crop"] = (max(x0, 0), max(y0, 0), max(x1, x0 + 1), max(y1, y0 + 1))
        return options | export.view.options()

    def grow(self, export, options, show):
        """The finished picture; pictures on the way are shown."""
        samples, last, picture = 0, 0.0, None
        total = options["spp"]

        def progress(done):
            self.update_progress(min(max(done, 0.0), 1.0))
            if self.is_stopped():
                raise Cancelled

        for picture in export.scene.accumulate(progress=progress, **options):
            self.so_far = picture
            samples = max(1, samples * 2)
            self.update_stats("", f"Sample {min(samples, total)} of {total}")
            if self.is_stopped():
                raise Cancelled
            if time.monotonic() - last > INTERVAL and samples < total and not self.is_quiet():
                show(picture)
                last = time.monotonic()
        return picture

    def is_stopped(self):
        """Whether the user has stopped the rendering."""
        return self.test_break()

    @staticmethod
    def is_quiet():
        return bpy.app.background

    def show(self, result, picture, scene, export, wanted, share, box, others=None, speeds=None, caught=None):
        """Puts a picture into the result on the screen; `others` are passes that are there already."""
        layer = result.layers[0]
        color = passes.combined(picture, scene.render.film_transparent or caught is not None)
        if caught is not None:
            color = caught.put(color, scene.render.film_transparent)
        if share is not None:
            color = holdouts.cut(color, share)
        passes.write(layer, "Combined", color[box])
        others = others or {}
        if "Shadow Catcher" in wanted:
            others = others | {"Shadow Catcher": np.ones_like(color[..., :3]) if caught is None else caught.factor}
        if speeds:
            others["Vector"] = speeds.of_picture(picture, export)
        for name, entry in wanted.items():
            if not passes.write(layer, name, passes.of_picture(picture, entry, export, others)[box]):
                export.warn(f"view layer '{layer.name}': the pass {name} is not rendered")
        if not wanted:
            self.update_result(result)

    def tell(self, scene, warned):
        """Reports what is not shown, once a rendering."""
        original = bpy.data.scenes.get(scene.name)
        if original is not None:
            original.gnurt.warnings = "\n".join(warned.lines)
        for line in warned.lines:
            self.report({"WARNING"}, f"GNU RT: {line}")

    # Viewport

    def view_update(self, context, depsgraph):
        """The scene has changed: it is exported at the next drawing."""
        state = getattr(self, "viewport", None)
        if state is not None:
            state.stop()
        self.viewport = None

    def view_draw(self, context, depsgraph):
        from .viewport import Viewport

        state = getattr(self, "viewport", None)
        if state is None:
            state = self.viewport = Viewport(self, context, depsgraph)
        state.draw(context, depsgraph)


def picture_size(scene):
    """Pixels across and down, by the percentage of the resolution."""
    scale = scene.render.resolution_percentage / 100
    return max(1, int(scene.render.resolution_x * scale)), max(1, int(scene.render.resolution_y * scale))


def register():
    bpy.utils.register_class(GnurtEngine)


def unregister():
    kept.clear()
    bpy.utils.unregister_class(GnurtEngine)


