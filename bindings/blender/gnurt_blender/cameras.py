# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras as camera shaders: shift, sensor fit, clipping, lenses with blades, orthographic and panoramic pictures.

Space: the shader's "camera", which looks along -z with y up, as Blender's.
"""

import math

import numpy as np
import gnurt

SHADER = """
camera blender (
    float wide = 1, float high = 1, float across = 0, float up = 0, int kind = 0, float fov = 1,
    float near = 0, float far = 1e30, float focus = 1, float radius = 0, int blades = 0, float turn = 0, float ratio = 1,
    float longitude_low = 0, float longitude_high = 0, float latitude_low = 0, float latitude_high = 0, float lens = 10)
{
    float x = (u - 0.5) * wide + across, y = (v - 0.5) * high + up;
    vector d = vector(x, y, -1);
    point from = point(0);
    weight = color(1);
    float forward = 1.0;
    if (kind == 1) {
        from = point(x, y, 0);
        d = vector(0, 0, -1);
    } else if (kind == 2) {
        float a = mix(longitude_low, longitude_high, u), b = mix(latitude_low, latitude_high, v);
        d = vector(sin(a) * cos(b), sin(b), -cos(a) * cos(b));
    } else if (kind >= 3) {
        float r = 2.0 * sqrt((u - 0.5) * (u - 0.5) + (v - 0.5) * (v - 0.5));
        float a = atan2(v - 0.5, u - 0.5), b = 0.5 * r * fov;
        int outside = (r > 1.0);
        if (kind == 4) {
            float q = length(vector(x, y, 0));
            a = atan2(y, x);
            b = 2.0 * asin(min(q / (2.0 * lens), 1.0));
            outside = (b > 0.5 * fov);
        }
        d = vector(sin(b) * cos(a), sin(b) * sin(a), -cos(b));
        if (outside)
            weight = color(0);
    }
    if (radius > 0.0) {
        float angle = M_2PI * xi[1], r = sqrt(xi[0]);
        vector spot = vector(r * cos(angle), r * sin(angle), 0);
        if (blades >= 3) {
            // One triangle of the polygon, and a point of it.
            float wedge = M_2PI / blades, part = xi[1] * blades, corner = floor(part), b = part - corner;
            vector one = vector(cos(wedge * corner + turn), sin(wedge * corner + turn), 0);
            vector two = vector(cos(wedge * (corner + 1) + turn), sin(wedge * (corner + 1) + turn), 0);
            spot = r * mix(one, two, b);
        }
        vector on_lens = radius * vector(spot[0] / ratio, spot[1], 0);
        if (kind == 1) {
            d = vector(0, 0, -focus) - on_lens;
            from += on_lens;
        } else if (kind == 0) {
            d = focus * d - on_lens;
            from = point(0) + on_lens;
        } else {
            vector unit = normalize(d), side = normalize(cross(unit, vector(0, 1, 0.001))), above = cross(side, unit);
            vector moved = on_lens[0] * side + on_lens[1] * above;
            d = focus * unit - moved;
            from = point(0) + moved;
        }
    }
    d = normalize(d);
    if (kind <= 1)
        forward = max(-d[2], 1e-6);
    tmin = near / forward;
    tmax = far / forward;
    P = transform("camera", "common", from);
    I = transform("camera", "common", d);
}
"""


class View:
    """A camera as options of `Scene.render`, and its matrices."""

    def __init__(self, camera, parameters, world_from_camera, window_from_camera):
        self.camera, self.parameters = camera, parameters
        self.world_from_camera, self.window_from_camera = world_from_camera, window_from_camera

    def options(self):
        return {"camera": self.camera, "camera_shader": SHADER, "camera_parameters": self.parameters}


def posed(matrix):
    """A camera of the package where a matrix puts it."""
    m = np.array(matrix, dtype=np.float64)
    eye, back, up = m[:3, 3], m[:3, 2], m[:3, 1]
    back, up = back / np.linalg.norm(back), up / np.linalg.norm(up)
    return gnurt.Camera(eye=tuple(eye), target=tuple(eye - back), up=tuple(up), fov=50.0)


def unscaled(matrix):
    """A matrix without its scale."""
    m = np.array(matrix, dtype=np.float64)
    m[:3, :3] /= np.linalg.norm(m[:3, :3], axis=0)
    return m


def lens_of(data, matrix):
    """Parameters of depth of field."""
    dof = data.dof
    if not dof.use_dof:
        return {}
    distance = dof.focus_distance
    if dof.focus_object is not None:
        target = np.array(dof.focus_object.matrix_world)[:3, 3]
        distance = abs((np.linalg.inv(matrix) @ np.append(target, 1.0))[2])
    fstop = max(dof.aperture_fstop, 1e-5)
    size = 1.0 / (2.0 * fstop) if data.type == "ORTHO" else data.lens * 1e-3 / (2.0 * fstop)
    return {
        "focus": max(float(distance), 1e-5),
        "radius": float(size),
        "blades": int(dof.aperture_blades),
        "turn": float(dof.aperture_rotation),
        "ratio": float(dof.aperture_ratio),
    }


def of_scene(scene, camera, size, warn):
    """The view of a camera object in a picture of this size."""
    data, render = camera.data, scene.render
    matrix = unscaled(camera.matrix_world)
    pixel = (render.pixel_aspect_x, render.pixel_aspect_y)
    return of_data(data, matrix, size, pixel, warn, getattr(data, "cycles", None))


def of_data(data, matrix, size, pixel, warn, cycles=None):
    width, height = size[0] * pixel[0], size[1] * pixel[1]
    fit = data.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if width >= height else "VERTICAL"
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    longer = width if fit == "HORIZONTAL" else height
    extent = data.ortho_scale if data.type == "ORTHO" else sensor / data.lens
    wide, high = extent * width / longer, extent * height / longer
    across, up = data.shift_x * extent, data.shift_y * extent
    parameters = {"wide": wide, "high": high, "across": across, "up": up, "near": float(data.clip_start), "far": float(data.clip_end)}
    window = np.eye(4)
    window[0, 0], window[1, 1] = 1 / wide, 1 / high
    if data.type == "ORTHO":
        parameters["kind"] = 1
        window[0, 3], window[1, 3] = 0.5 - across / wide, 0.5 - up / high
    else:
        # Divided by the depth, which is -z.
        window[0, 2], window[1, 2] = across / wide - 0.5, up / high - 0.5
        window[3] = (0, 0, -1, 0)
    if data.type == "PANO":
        panorama(data, cycles, parameters, sensor, wide / extent, high / extent, warn)
    parameters |= lens_of(data, matrix)
    parameters = {name: value if isinstance(value, int) else float(value) for name, value in parameters.items()}
    return View(posed(matrix), parameters, matrix, window)


def panorama(data, cycles, parameters, sensor, wide, high, warn):
    """The kinds of panoramas; their settings moved from Cycles' group to the camera in Blender 5.0."""

    def setting(name, default):
        return getattr(data, name, getattr(cycles, name, default))

    kind = setting("panorama_type", "EQUIRECTANGULAR")
    if kind == "FISHEYE_EQUIDISTANT":
        parameters |= {"kind": 3, "fov": setting("fisheye_fov", math.pi)}
    elif kind == "FISHEYE_EQUISOLID":
        lens = setting("fisheye_lens", 10.5)
        parameters |= {"kind": 4, "fov": setting("fisheye_fov", math.pi), "lens": lens, "wide": sensor * wide, "high": sensor * high}
        parameters |= {"across": data.shift_x * sensor, "up": data.shift_y * sensor}
    else:
        if kind != "EQUIRECTANGULAR":
            warn(f"camera '{data.name}': panoramas of type {kind} are shown as equirectangular")
        parameters |= {
            "kind": 2,
            "longitude_low": setting("longitude_min", -math.pi),
            "longitude_high": setting("longitude_max", math.pi),
            "latitude_low": setting("latitude_min", -math.pi / 2),
            "latitude_high": setting("latitude_max", math.pi / 2),
        }
