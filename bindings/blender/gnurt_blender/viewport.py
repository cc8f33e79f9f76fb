# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport: pictures that grow while nothing changes, drawn as a texture of the graphics card.

The first picture after a change is coarse and comes at once. A thread renders the others, so that the window answers meanwhile: a change of
the view stops it. Drawing is not covered by tests, because they run without a window.
"""

import threading
import time

import numpy as np

from . import cameras, catchers, passes
from .scene import Export
from .warned import Warned

# Seconds that the first picture after a change may take, and its pixels before that is known.
SOON, FIRST_PIXELS = 0.03, 15_000
# Its pixels are every second one across and down, or fewer.
COARSE = 2
# Seconds that drawing waits for a picture.
PATIENCE = 0.03
# Samples of what shadow catchers show of the background; they come before the picture.
CATCHING = 8


class Stopped(Exception):
    """The picture is not wanted any more."""


class Growing:
    """Pictures of one view, each with more samples, rendered by a thread."""

    def __init__(self, accumulate):
        self.is_stopped = False
        self.pictures = accumulate(progress=self.progress)
        self.thread, self.found, self.error = None, None, None

    def progress(self, _):
        if self.is_stopped:
            raise Stopped

    def stop(self):
        self.is_stopped = True
        if self.thread is not None:
            self.thread.join()

    def run(self):
        try:
            self.found = next(self.pictures, None)
        except Stopped:
            self.found = None
        except Exception as error:
            self.error = error

    def next(self, seconds):
        """Whether the next picture is there in time, and it; None after the last one."""
        if self.thread is None:
            self.thread = threading.Thread(target=self.run, daemon=True)
            self.thread.start()
        self.thread.join(seconds)
        if self.thread.is_alive():
            return False, None
        self.thread = None
        if self.error is not None:
            raise self.error
        return True, self.found


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
        self.pixels = FIRST_PIXELS

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
            self.stop()
            self.key, self.view = key, self.seen(context)
            self.growing, self.is_coarse = None, True
        picture = self.next(depsgraph.scene, PATIENCE)
        if picture is not None:
            self.upload(picture)
        self.paint(context, depsgraph.scene)

    def stop(self):
        """Ends the picture in the making."""
        if self.growing is not None:
            self.growing.stop()

    def coarse_size(self):
        """The size of the first picture after a change."""
        width, height = self.size
        step = max(COARSE, int(np.ceil((width * height / self.pixels) ** 0.5)))
        return max(1, width // step), max(1, height // step)

    def next(self, scene, seconds=None):
        """The next picture; None when it is finished, or not there within these seconds."""
        settings = scene.gnurt
        options = {"integrator": settings.integrator, "max_depth": settings.max_depth, "threads": settings.threads, **self.view.options()}
        if self.is_coarse:
            self.is_coarse = False
            self.engine.tag_redraw()
            width, height = self.coarse_size()
            began = time.monotonic()
            self.catch(width, height, 1, options)
            picture = self.shown(self.export.scene.render(width, height, spp=1, **options))
            # As many pixels the next time as take that long.
            took = max(time.monotonic() - began, 1e-3)
            self.pixels = min(max(width * height * SOON / took, 1000), 1_000_000)
            return picture
        if self.growing is None:
            self.catch(*self.size, min(CATCHING, settings.preview_samples), options)
            size, samples = self.size, settings.preview_samples
            self.growing = Growing(lambda **more: self.export.scene.accumulate(*size, spp=samples, **options, **more))
        is_there, picture = self.growing.next(seconds)
        if picture is not None or not is_there:
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
