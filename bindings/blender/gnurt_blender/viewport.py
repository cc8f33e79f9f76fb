# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport: pictures that grow while nothing changes, drawn as a texture of the graphics card.

Not covered by tests, because they run without a window.
"""

import numpy as np

from . import cameras, catchers, passes
from .scene import Export
from .warned import Warned

# Pixels of the first picture after a change: every second one across and down.
COARSE = 2
# Samples of what shadow catchers show of the background; they come before the picture.
CATCHING = 8


class Viewport:
    """What is on the screen, and the picture in the making."""

    def __init__(self, engine, context, depsgraph):
        self.engine, self.warned = engine, Warned()
        self.view = self.seen(context)
        self.has_catchers = catchers.are_there(depsgraph)
        part = "others" if self.has_catchers else None
        self.export = Export(depsgraph, self.size, view=self.view, warned=self.warned, part=part)
        self.export.put_all()
        self.key = self.key_of(context)
        self.growing, self.texture, self.is_coarse, self.caught = None, None, True, None

    def key_of(self, context):
        region, data = context.region, context.region_data
        matrix = tuple(tuple(row) for row in data.view_matrix)
        return region.width, region.height, matrix, data.view_perspective, data.view_camera_zoom, tuple(data.view_camera_offset)

    def seen(self, context):
        """The view of the region, from its matrices."""
        region, data = context.region, context.region_data
        self.size = max(1, region.width), max(1, region.height)
        matrix = cameras.unscaled(np.linalg.inv(np.array(data.view_matrix)))
        projection = np.array(data.window_matrix)
        wide, high = 2 / projection[0, 0], 2 / projection[1, 1]
        parameters = {"wide": float(wide), "high": float(high)}
        window = np.eye(4)
        window[0, 0], window[1, 1] = 1 / wide, 1 / high
        if data.is_perspective:
            parameters |= {"across": float(projection[0, 2] / projection[0, 0]), "up": float(projection[1, 2] / projection[1, 1])}
            window[0, 2], window[1, 2] = parameters["across"] / wide - 0.5, parameters["up"] / high - 0.5
            window[3] = (0, 0, -1, 0)
        else:
            parameters |= {"kind": 1, "across": float(-projection[0, 3] / projection[0, 0]), "up": float(-projection[1, 3] / projection[1, 1])}
            window[0, 3], window[1, 3] = 0.5 - parameters["across"] / wide, 0.5 - parameters["up"] / high
            # Orthographic views begin far behind the middle of the screen.
            matrix[:3, 3] += matrix[:3, 2] * 1e3
        return cameras.View(cameras.posed(matrix), parameters, matrix, window)

    def draw(self, context, depsgraph):
        key = self.key_of(context)
        if key != self.key:
            self.key, self.view = key, self.seen(context)
            self.growing, self.is_coarse = None, True
        picture = self.next(depsgraph.scene)
        if picture is not None:
            self.upload(picture)
        self.paint(context, depsgraph.scene)

    def next(self, scene):
        """The next picture; None when it is finished."""
        settings = scene.gnurt
        options = {"integrator": settings.integrator, "max_depth": settings.max_depth, "threads": settings.threads, **self.view.options()}
        if self.is_coarse:
            self.is_coarse = False
            self.engine.tag_redraw()
            width, height = (max(1, n // COARSE) for n in self.size)
            self.catch(width, height, 1, options)
            return self.shown(self.export.scene.render(width, height, spp=1, **options))
        if self.growing is None:
            self.catch(*self.size, min(CATCHING, settings.preview_samples), options)
            self.growing = self.export.scene.accumulate(*self.size, spp=settings.preview_samples, **options)
        picture = next(self.growing, None)
        if picture is not None:
            self.engine.tag_redraw()
        return picture if picture is None else self.shown(picture)

    def catch(self, width, height, samples, options):
        """Renders what shadow catchers show, while the scene is not being rendered."""
        if self.has_catchers:
            options["layers"] = True
            self.caught = catchers.Caught(self.export, {**options, "width": width, "height": height, "spp": samples}, None)

    def shown(self, picture):
        """A picture with what shadow catchers show."""
        if self.caught is None:
            return picture
        return self.caught.put(passes.combined(picture, True), False)

    def upload(self, picture):
        import gpu

        pixels = np.asarray(picture)[::-1].copy()
        pixels[..., 3] = 1.0
        height, width = pixels.shape[:2]
        buffer = gpu.types.Buffer("FLOAT", width * height * 4, pixels.ravel())
        self.texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)

    def paint(self, context, scene):
        import gpu
        from gpu_extras.presets import draw_texture_2d

        if self.texture is None:
            return
        gpu.state.blend_set("ALPHA_PREMULT")
        self.engine.bind_display_space_shader(scene)
        draw_texture_2d(self.texture, (0, 0), *self.size)
        self.engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
