# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: those with a size are shapes that emit, so that mirrors show them. Points, spots and suns light the scene as lights of those kinds, or
of the shading language where light falls otherwise than with the square of the distance.

Units: watts for points, spots and areas, W/m2 for suns, as in Blender. A point of P watts has the radiant intensity P / (4 pi^2)
times pi, which Blender spreads over its sphere. Space: world.
"""

import math
from functools import partial

import numpy as np

from . import links
from .nodes.tree import fed_by

# Points and spots in one light of the language, those whose light falls otherwise; it chooses one of them for each sample.
MOST_TOGETHER = 48
# Narrow areas that are sampled one by one.
MOST_SAMPLED = 16
# Of a sun's disc from the origin, world units.
FAR = 1e5

# Numbers of each of them.
NUMBERS = 14
POINT = """
float blender_falloff(float distance, float power, float smooth)
{
    float square = distance * distance;
    return ((power > 1.5) ? square : ((power > 0.5) ? distance : 1.0)) * ((smooth > 0.0) ? square / (smooth + square) : 1.0);
}
light blender_points (float given[TOTAL] = {0})
{
    // Each light has a power, a place, a radius, an axis, the cosine of its cone (-2 is none), the width of the cone's edge, and the power
    // of the distance and the smoothness of its falloff. One is chosen by its light without shadows.
    float share[COUNT];
    float total = 0.0;
    for (int i = 0; i < COUNT; i += 1) {
        int k = NUMBERS * i;
        vector way = point(given[k + 3], given[k + 4], given[k + 5]) - Ps;
        float near = max(dot(way, way), 1e-8);
        float own = (given[k] + given[k + 1] + given[k + 2]) / near * blender_falloff(sqrt(near), given[k + 12], given[k + 13]);
        if (given[k + 10] > -1.0) {
            float c = -dot(normalize(way), vector(given[k + 7], given[k + 8], given[k + 9]));
            // The edge of a sphere may see more than its middle.
            if (c < given[k + 10] - 2.0 * given[k + 6] / max(length(way), 1e-4))
                own = 0.0;
        }
        total += own;
        share[i] = own;
    }
    Cl = color(0);
    L = vector(0, 0, 1);
    lightdist = 1.0;
    if (total > 0.0) {
        float left = xi[0] * total;
        int n = 0;
        while (n < COUNT - 1 && left >= share[n]) {
            left -= share[n];
            n += 1;
        }
        float chance = share[n] / total, x = (share[n] > 0.0) ? clamp(left / share[n], 0.0, 1.0) : 0.5;
        int k = NUMBERS * n;
        // A disc that faces the point, as large as the sphere seems from afar.
        point where = point(given[k + 3], given[k + 4], given[k + 5]);
        vector d = normalize(where - Ps);
        vector side = normalize(cross(d, (fabs(d[2]) < 0.9) ? vector(0, 0, 1) : vector(1, 0, 0)));
        float r = given[k + 6] * sqrt(x), a = M_2PI * xi[1];
        vector way = where + r * cos(a) * side + r * sin(a) * cross(d, side) - Ps;
        lightdist = length(way);
        L = way / lightdist;
        if (chance > 0.0)
            Cl = color(given[k], given[k + 1], given[k + 2]) * max(dot(L, d), 0.0) / (lightdist * lightdist * chance)
                * blender_falloff(lightdist, given[k + 12], given[k + 13]);
        if (given[k + 10] > -1.0) {
            float c = -dot(L, vector(given[k + 7], given[k + 8], given[k + 9])) - given[k + 10], smooth = given[k + 11];
            Cl *= (c <= 0.0) ? 0.0 : ((smooth > 0.0) ? smoothstep(0.0, 1.0, c / smooth) : 1.0);
        }
    }
}
"""
NARROW = """
light blender_narrow (color light = 1, point where = point(0), vector side = vector(1, 0, 0), vector up = vector(0, 1, 0),
    vector axis = vector(0, 0, -1), float wide = 1, float high = 1, float spread = 1, float spread_scale = 1, int is_round = 0)
{
    // Of a rectangle only the part from which the light reaches the point, by the spread.
    vector d = Ps - where;
    float x = dot(d, side), y = dot(d, up), z = dot(d, axis), reach = z * spread;
    float x0 = max(-0.5 * wide, x - reach), x1 = min(0.5 * wide, x + reach);
    float y0 = max(-0.5 * high, y - reach), y1 = min(0.5 * high, y + reach);
    Cl = color(0);
    L = -axis;
    lightdist = 1.0;
    if (z > 0.0 && x1 > x0 && y1 > y0) {
        float px = mix(x0, x1, xi[0]), py = mix(y0, y1, xi[1]);
        vector way = where + px * side + py * up - Ps;
        lightdist = length(way);
        L = way / lightdist;
        float c = -dot(L, axis);
        float share = max((spread - sqrt(max(1.0 - c * c, 0.0)) / max(c, 1e-6)) * spread_scale, 0.0);
        if (is_round && 4.0 * (px * px / (wide * wide) + py * py / (high * high)) > 1.0)
            share = 0.0;
        Cl = light * share * c * (x1 - x0) * (y1 - y0) / (lightdist * lightdist);
    }
}
"""
SHINING = """
surface blender_lamp (color light = 1, vector axis = vector(0, 0, -1), float cone = -2, float smooth = 0, float spread = 0,
    float spread_scale = 1)
{
    if (backfacing()HIDDEN)
        Ci = transparent();
    else {
        float share = 1.0;
        vector d = normalize(-I);
        if (cone > -1.0) {
            float c = dot(d, axis) - cone;
            share = (c <= 0.0) ? 0.0 : ((smooth > 0.0) ? smoothstep(0.0, 1.0, c / smooth) : 1.0);
        }
        if (spread > 0.0) {
            float c = max(fabs(dot(d, Ng)), 1e-6);
            share *= max((spread - sqrt(max(1.0 - c * c, 0.0)) / c) * spread_scale, 0.0);
        }
        // Lights of Blender stop no light.
        Ci = (BODY) * share * emission() + transparent();
    }
}
"""


def flat_shape(shape, size, size_y, segments=48):
    """A rectangle or an ellipse of exact area around the origin that faces -z."""
    if shape in {"SQUARE", "RECTANGLE"}:
        high = size if shape == "SQUARE" else size_y
        points = np.array([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]) * (size, high, 1)
        return points, np.array([(0, 2, 1), (0, 3, 2)]), size * high
    high = size if shape == "DISK" else size_y
    angles = np.arange(segments) * (2 * math.pi / segments)
    # As large as the ellipse.
    grown = math.sqrt(2 * math.pi / segments / math.sin(2 * math.pi / segments))
    rim = np.stack([np.cos(angles) * size / 2 * grown, np.sin(angles) * high / 2 * grown, 0 * angles], axis=1)
    points = np.concatenate([[(0, 0, 0)], rim])
    faces = np.array([(0, (i + 1) % segments + 1, i + 1) for i in range(segments)])
    return points, faces, math.pi * size * high / 4


def put_points(scene, points):
    """Points and spots with a falloff of their own together, as lights that choose among them."""
    for first in range(0, len(points), MOST_TOGETHER):
        some = points[first : first + MOST_TOGETHER]
        text = POINT.replace("NUMBERS", str(NUMBERS)).replace("TOTAL", str(NUMBERS * len(some))).replace("COUNT", str(len(some)))
        scene.add_light_shader(text, parameters={"given": [x for point in some for x in point]})


# The condition under which a lamp that lights the scene by other means is not there.
SCATTERED = ' || (!raytype("camera") && !raytype("reflection") && !raytype("refraction"))'


def falloff_of(data):
    """The colour of the Emission node of a lamp whose strength a Light Falloff node gives, the power of the distance and the smoothness; or None."""
    output = data.node_tree.get_output_node("CYCLES")
    emission = fed_by(output.inputs["Surface"]) if output else None
    if emission is None or emission[0].type != "EMISSION" or emission[0].inputs["Color"].is_linked:
        return None
    falloff = fed_by(emission[0].inputs["Strength"])
    if falloff is None or falloff[0].type != "LIGHT_FALLOFF" or any(each.is_linked for each in falloff[0].inputs):
        return None
    node, name = falloff
    color = np.array(emission[0].inputs["Color"].default_value[:3], float) * node.inputs["Strength"].default_value
    return color, {"Quadratic": 0.0, "Linear": 1.0, "Constant": 2.0}[name], max(node.inputs["Smooth"].default_value, 0.0)


class Lamp:
    """A light of Blender on its way into the scene of `export`."""

    def __init__(self, export, lamp_object, matrix, data):
        self.export, self.object, self.data = export, lamp_object, data
        self.matrix = np.array(matrix, dtype=np.float64)
        self.scale = np.linalg.norm(self.matrix[:3, :3], axis=0)
        self.turn = self.matrix[:3, :3] / np.maximum(self.scale, 1e-20)
        self.color = self._color()
        # Whether its nodes are in its colour.
        self.is_plain = False
        self.has_links = links.are_there(lamp_object)
        # Lights of the language light neither media nor some objects alone.
        self.is_shape = export.has_media or self.has_links

    def _color(self):
        data = self.data
        color = np.array(data.color, float)
        if getattr(data, "use_temperature", False):
            color *= np.array(data.temperature_color)
        return color * data.energy * 2.0 ** getattr(data, "exposure", 0.0)

    def put(self):
        data = self.data
        # A portal marks where light of the sky comes in; the sky is sampled without it.
        if data.type == "AREA" and getattr(getattr(data, "cycles", None), "is_portal", False):
            return
        getattr(self, {"POINT": "point", "SPOT": "point", "SUN": "sun", "AREA": "area"}[data.type])()

    def spot(self):
        """Parameters of the cone of a spot."""
        if self.data.type != "SPOT":
            return {}
        cone = math.cos(self.data.spot_size / 2)
        return {"axis": tuple(-self.turn[:, 2]), "cone": cone, "smooth": (1 - cone) * self.data.spot_blend}

    def point(self):
        data = self.data
        radius = data.shadow_soft_size
        where = self.matrix[:3, 3]
        normalize = getattr(data, "normalize", True)
        is_soft = getattr(data, "use_soft_falloff", True)
        falloff = falloff_of(data) if self.has_nodes() else None
        color, *powers = falloff or (1.0, 0.0, 0.0)
        # Light that falls with another power of the distance is one of the language.
        is_script = any(powers)
        is_sampled = (falloff is not None or not self.has_nodes()) and (radius <= 0 or is_soft) and not (is_script and self.is_shape)
        if is_sampled:
            # The lamp itself is seen as it is at a distance of 1.
            self.color, self.is_plain = self.color * color, True
            power = self.color / (4 * math.pi)
            if not normalize:
                power = self.color * (radius * radius if radius > 0 else 1 / math.pi)
            if is_script:
                cone = self.spot()
                own = [*power, *where, radius, *cone.get("axis", (0, 0, -1)), cone.get("cone", -2.0), cone.get("smooth", 0.0), *powers]
                self.export.points.append([float(x) for x in own])
            else:
                self.disc_to_all(power, where, radius)
            if radius <= 0:
                return
        radius = max(radius, 1e-3)
        area = 4 * math.pi * radius * radius
        light = self.color / (math.pi * area) if normalize else self.color / math.pi
        if data.shadow_soft_size <= 0 and not normalize:
            light = self.color / (math.pi * radius) ** 2
        # Lamps that move stay what they are.
        place = np.eye(4)
        place[:3, 3] = where
        self.shape(partial(self.export.scene.add_points, [(0, 0, 0)], [radius], transform=place), light, self.spot(), is_sampled)

    def disc_to_all(self, power, where, radius):
        """A light that is a disc facing the lit point, as a point or spot of Blender is."""
        data = self.data
        given = {"position": tuple(where), "intensity": tuple(power), "radius": radius}
        if data.type == "SPOT":
            # The edge is a part of the cone's share of the axis.
            cone = math.cos(data.spot_size / 2)
            inner = math.acos(min(cone + (1 - cone) * data.spot_blend, 1.0))
            angles = {"outer_angle": math.degrees(data.spot_size / 2), "inner_angle": math.degrees(inner)}
            given |= {"direction": tuple(-self.turn[:, 2]), "edge": "smooth", **angles}
        number = self.export.scene.add_light(data.type.lower(), **given)
        if self.has_links:
            self.export.linked_lights.setdefault(self.object.name, []).append(number)

    def sun(self):
        radius = math.sin(min(self.data.angle, math.pi) / 2)
        color = self.color
        if self.has_nodes():
            self.export.warn(f"light '{self.object.name}': nodes of suns are not shown")
        if radius > 0 and not getattr(self.data, "normalize", True):
            color = color * math.pi * radius * radius
        if self.has_links:
            self.disc(color, max(radius, 1e-4), False)
            return
        angle = math.degrees(min(self.data.angle, math.pi))
        self.export.scene.add_light("directional", direction=tuple(-self.turn[:, 2]), irradiance=tuple(color), angle=angle)
        if self.is_shape and radius > 1e-4:
            self.disc(color, radius, True)

    def disc(self, color, radius, is_mirrored):
        """A sun as a disc far away: one that lights some objects alone, or for mirrors."""
        size = 2 * FAR * math.tan(math.asin(min(radius, 0.999)))
        points, faces, _ = flat_shape("ELLIPSE", size, size)
        points = points @ self.turn.T + FAR * self.turn[:, 2]
        light = color / (math.pi * radius * radius)
        self.shape(partial(self.export.scene.add_mesh, points, faces), light, {}, is_mirrored, given=["other"])

    def area(self):
        data = self.data
        size = data.size * self.scale[0]
        size_y = (data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size) * self.scale[1]
        shape = {"SQUARE": "RECTANGLE", "DISK": "ELLIPSE"}.get(data.shape, data.shape)
        points, faces, area = flat_shape(shape, max(size, 1e-6), max(size_y, 1e-6))
        points = points @ self.turn.T + self.matrix[:3, 3]
        if np.linalg.det(self.turn) < 0:
            faces = faces[:, ::-1]
        light = self.color / (math.pi * area) if getattr(data, "normalize", True) else self.color / math.pi
        parameters = {}
        half = min(data.spread, math.pi) / 2
        if half < math.pi / 2 - 1e-4:
            half = max(half, math.radians(0.5))
            parameters = {"spread": math.tan(half), "spread_scale": 1 / (math.tan(half) - half)}
        is_narrow = bool(parameters) and half < math.radians(50) and not self.has_nodes() and self.export.lamps <= MOST_SAMPLED and not self.is_shape
        if is_narrow:
            place = {"where": tuple(self.matrix[:3, 3]), "side": tuple(self.turn[:, 0]), "up": tuple(self.turn[:, 1]), "axis": tuple(-self.turn[:, 2])}
            place |= {"wide": max(size, 1e-6), "high": max(size_y, 1e-6), "is_round": int(shape == "ELLIPSE")}
            self.export.scene.add_light_shader(NARROW, parameters={"light": tuple(light), **place, **parameters})
        self.shape(partial(self.export.scene.add_mesh, points, faces), light, parameters, is_narrow)

    def has_nodes(self):
        if self.is_plain:
            return False
        tree = getattr(self.data, "node_tree", None)
        return bool(getattr(self.data, "use_nodes", False) and tree)

    def shape(self, add, light, parameters, is_mirrored=False, given=None):
        """A surface that emits, which `add` adds to the scene; to mirrors and the camera only if something else lights the scene in its place."""
        export = self.export
        body, extra = "light", {}
        if self.has_nodes():
            made = export.light_nodes(self.data, self.object)
            if made is not None:
                body, extra = made
        # Without that condition the emission of a side is even, and is computed once.
        shader = SHINING.replace("BODY", body).replace("HIDDEN", SCATTERED if is_mirrored else "")
        if extra:
            shader = extra["head"] + shader.replace("        float share = 1.0;", extra["lines"] + "\n        float share = 1.0;")
        material = export.scene.add_material(
            self.object.name, shader=shader, parameters={"light": tuple(light), **parameters}, textures=extra.get("textures") or {}
        )
        rays = [*(["camera"] if export.lamp_shows(self.object) else []), *(["other"] if light.any() else [])]
        rays = given or rays
        if rays:
            add(material=material, rays=rays, name=self.object.name)
