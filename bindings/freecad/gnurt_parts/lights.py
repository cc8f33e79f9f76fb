# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of a stage. Powers are watts of all three channels; lengths are metres.

Sky and sun follow Preetham, Shirley and Smits, A practical analytic model for daylight (1999).
"""

import math
import os

from . import stage

#: Kilolux per unit of irradiance: the sun at the zenith has about 3, as the library's sun.
SCALE = 40.0
#: Wavelengths that stand for red, green and blue, in micrometres.
WAVES = (0.610, 0.550, 0.465)
#: Diameter of the sun in degrees.
SUN = 0.53


def _color(rgb, factor=1.0):
    return "(" + ", ".join(f"{max(x, 0.0) * factor:.9g}" for x in rgb) + ")"


def point(name, place, color, power):
    """A point: its intensity is that of a ball with a disk of one square metre."""
    return f"""def SphereLight "{stage.identifier(name)}"
{{
    bool treatAsPoint = true
    float inputs:radius = {1 / math.sqrt(math.pi):.9g}
    float inputs:intensity = {power / (4 * math.pi):.9g}
    color3f inputs:color = {_color(color)}
    double3 xformOp:translate = {stage.tuples([place])}
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""


def area(name, matrix, width, height, color, power):
    """A rectangle. Areas of USD shine along -z, those of FreeCAD along z."""
    x, y, z, origin = matrix
    turned = [x, [-c for c in y], [-c for c in z], origin]
    return f"""def RectLight "{stage.identifier(name)}"
{{
{stage.transform(turned)}    float inputs:width = {width:.9g}
    float inputs:height = {height:.9g}
    float inputs:intensity = {power / (math.pi * width * height):.9g}
    color3f inputs:color = {_color(color)}
}}
"""


def dome(name, image):
    """A picture around the scene, its pole along z."""
    path = os.path.abspath(image).replace(os.sep, "/")
    return f"""def DomeLight "{stage.identifier(name)}"
{{
    asset inputs:texture:file = @@@{path}@@@
    float3 xformOp:rotateXYZ = (90, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}}
"""


def _disk(name, toward, irradiance, degrees):
    """A light shader: equal light from a small disk in the direction `toward`. Its world has y up."""
    x, y, z = toward
    return f"""light {name} ()
{{
    vector axis = normalize (vector ({x:.9g}, {z:.9g}, {-y:.9g}));
    float r = sqrt (xi[0]) * {math.tan(math.radians(min(degrees, 170.0) / 2)):.9g};
    vector a = normalize (cross (axis, abs (axis[1]) < 0.9 ? vector (0, 1, 0) : vector (1, 0, 0))), b = cross (axis, a);
    L = normalize (axis + r * (cos (M_2PI * xi[1]) * a + sin (M_2PI * xi[1]) * b));
    lightdist = 1e30;
    Cl = color {_color(irradiance)};
}}
"""


def _holder(place, name, text):
    return f'def Scope "{name}"\n{{\n    custom {stage.shader(place, name, text)}\n}}\n'


def distant(name, color, power, direction, degrees):
    """Light that travels along `direction`."""
    name = stage.identifier(name)
    toward = [-x for x in direction]
    return _holder("light", name, _disk(name, toward, [x * power for x in color], max(degrees, 0.0)))


def sunlight(height, turbidity):
    """The part of sunlight, per channel, that passes the air; `height` is the sine of the sun's elevation."""
    zenith = math.degrees(math.acos(min(max(height, 0.0), 1.0)))
    mass = 1 / (max(height, 0.0) + 0.15 * (93.885 - zenith) ** -1.253)
    haze = 0.04608 * turbidity - 0.04586
    return [math.exp(-mass * (0.008735 * w**-4.08 + haze * w**-1.3)) for w in WAVES]


def sky(name, direction, turbidity, albedo, sun_intensity, sky_intensity):
    """A sky, and a sun where it is above the horizon. `direction` points to the sun."""
    name = stage.identifier(name)
    turbidity = min(max(turbidity, 2.0), 10.0)
    length = math.sqrt(sum(x * x for x in direction)) or 1.0
    x, y, z = (c / length for c in direction)
    with open(os.path.join(os.path.dirname(__file__), "sky.h"), encoding="utf-8") as file:
        header = file.read()
    text = f"""{header}
environment {name} ()
{{
    vector d = normalize (I), sun = vector ({x:.9g}, {y:.9g}, {max(z, 0.0):.9g});
    // The ground shows the zenith's light times its albedo. 0.06 is the scale of the header.
    color light = d[2] > 0 ? b_preetham (d, sun, {turbidity:.9g})
        : {albedo:.9g} * b_preetham (vector (0, 0, 1), sun, {turbidity:.9g});
    Ci = {sky_intensity / SCALE / 0.06:.9g} * light * background ();
}}
"""
    parts = _holder("environment", name + "_sky", text)
    if z > 0 and sun_intensity > 0:
        light = [127.5 / SCALE * sun_intensity * part for part in sunlight(z, turbidity)]
        parts += _holder("light", name + "_sun", _disk(name + "_sun", (x, y, z), light, SUN))
    return parts
