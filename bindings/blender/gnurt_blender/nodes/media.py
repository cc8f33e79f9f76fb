# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume nodes as coefficients of media: absorption, scattering and emission, 1 over units of length.

A coefficient is a colour (3,) where it is even, else an array (x, y, z, 3) over the cells of a box. Numbers of nodes are floats or (x, y, z).
Rules of the Principled Volume were measured in pictures of Cycles: absorption is density (1 - colour) (1 - root of the absorption
colour), emission does not depend on density, and a black body at T has the luminance of Stefan and Boltzmann's law.
"""

import numpy as np

from .tree import Place, source

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
STEFAN_BOLTZMANN = 5.670374e-8
# Blender's scale of the light of hot gas, from W/m2.
HOT = 1e-6
# Cubics in 1000 / temperature as of osl/spectra.h: up to these temperatures, by powers from 3 to 0.
COLORS = (
    (1975.0, ((-0.546376, 0.377699, -5.32597), (0.249751, -0.631119, 10.61), (4.74889, -0.930496, -7.47307), (0.149821, 1.223, 1.7702))),
    (4500.0, ((-3.21967, 2.28278, -12.2192), (4.35916, -3.4014, 19.7841), (2.56138, 0.445317, -11.5491), (0.5516, 0.989374, 2.37564))),
    (1e30, ((-11.7249, 1.80127, 11.1273), (10.351, -3.72251, 8.9591), (1.13048, 0.650515, -10.15), (0.666909, 0.965097, 2.34435))),
)
# Two lobes of Henyey and Greenstein with the first moments of Rayleigh's phase function.
RAYLEIGH = 0.1**0.5
STEEPEST = 0.998


class Part:
    """One node's share of a medium; `lobes` are (mean cosine, mean cosine of a second lobe, its share)."""

    def __init__(self, absorption=0.0, scattering=0.0, emission=0.0, lobes=(0.0, 0.0, 0.0)):
        self.coefficients = [colored(x) for x in (absorption, scattering, emission)]
        self.lobes = lobes

    def times(self, factor):
        made = Part(lobes=self.lobes)
        made.coefficients = [x * (factor if np.ndim(factor) == 0 else factor[..., None]) for x in self.coefficients]
        return made


def colored(x):
    """A number or an array of them as colours; colours as they are."""
    x = np.asarray(x, np.float64)
    if x.ndim in {0, 3}:
        return x[..., None] * np.ones(3)
    return x


def grey(x):
    x = np.asarray(x, np.float64)
    return x @ LUMINANCE if x.ndim in {1, 4} else x


def scaled(color, number):
    """Colours times numbers."""
    return colored(color) * (np.asarray(number)[..., None] if np.ndim(number) == 3 else number)


def blackbody(kelvin):
    """The colour of a hot body, of luminance 1."""
    t = np.clip(np.asarray(kelvin, np.float64), 800.0, 12000.0)
    x = (1000.0 / t)[..., None]
    made = np.zeros((*t.shape, 3))
    low = 0.0
    for high, cubic in COLORS:
        a, b, c, d = (np.array(row) for row in cubic)
        within = ((t >= low) & (t < high))[..., None]
        made = np.where(within, ((a * x + b) * x + c) * x + d, made)
        low = high
    return np.maximum(made, 0.0)


def glow_of_heat(kelvin):
    """Radiance of each unit of length of hot gas."""
    kelvin = np.maximum(np.asarray(kelvin, np.float64), 0.0)
    return scaled(blackbody(kelvin), STEFAN_BOLTZMANN * kelvin**4 * HOT / np.pi)


class Reader:
    """Reads volume closures. `cells(name)` is a grid of the object as an array, or None; `bake(socket's place)` samples other nodes."""

    def __init__(self, code, cells=None, bake=None):
        self.code, self.cells, self.bake = code, cells, bake

    def parts(self, tree, socket, outer=None):
        """The parts of the medium that feeds a socket."""
        found = source(self.code, tree, socket, outer)
        if found is None or found[0] == "default":
            return []
        tree, origin, _, outer = found
        place = Place(self.code, tree, origin, outer)
        handler = CLOSURES.get(origin.type)
        if handler is None:
            place.warn(f"nodes of type {origin.bl_idname.removeprefix('ShaderNode')} are not shown as volumes")
            return []
        return handler(self, place)

    def shares(self, p, identifier):
        return self.parts(p.tree, p.socket(identifier), p.outer)

    def value(self, p, identifier):
        """An input: a number, a colour, or an array of them."""
        socket = p.socket(identifier)
        found = source(self.code, p.tree, socket, p.outer)
        if found is None or found[0] == "default":
            own = (socket if found is None else found[1]).default_value
            return np.array(own[:3], np.float64) if hasattr(own, "__len__") else float(own)
        tree, origin, output, outer = found
        place = Place(self.code, tree, origin, outer)
        handler = NUMBERS.get(origin.type)
        made = handler(self, place, output) if handler else None
        if made is None and self.bake:
            made = self.bake(p, identifier)
        if made is None:
            place.warn(f"its value varies in a volume; {p.node.name} is shown with the value of its own input '{socket.name}'")
            own = socket.default_value
            made = np.array(own[:3], np.float64) if hasattr(own, "__len__") else float(own)
        return made

    def number(self, p, identifier):
        return grey(self.value(p, identifier))

    def color(self, p, identifier):
        return np.maximum(colored(self.value(p, identifier)), 0.0)

    def attribute(self, name, missing):
        """A grid of the object; `missing` where it has none."""
        found = self.cells(name) if self.cells and name else None
        return missing if found is None else found


def lobes(r, p):
    """Directions of scattering."""
    kind = getattr(p.node, "phase", "HENYEY_GREENSTEIN")
    if kind == "RAYLEIGH":
        return (RAYLEIGH, -RAYLEIGH, 0.5)
    g = float(np.mean(r.number(p, "Anisotropy")))
    if kind == "DRAINE":
        alpha = float(np.mean(r.number(p, "Alpha")))
        g *= (1 + alpha * (3 + 2 * g * g) / 5) / (1 + alpha * (1 + 2 * g * g) / 3)
    if kind != "HENYEY_GREENSTEIN":
        p.warn(f"its phase function {kind} is shown as Henyey and Greenstein's")
    if kind in {"MIE", "FOURNIER_FORAND"}:
        g = 0.9
    return (min(max(g, -STEEPEST), STEEPEST), 0.0, 0.0)


def scatter(r, p):
    return [Part(scattering=scaled(r.color(p, "Color"), np.maximum(r.number(p, "Density"), 0.0)), lobes=lobes(r, p))]


def absorption(r, p):
    missing = np.maximum(1.0 - r.color(p, "Color"), 0.0)
    return [Part(absorption=scaled(missing, np.maximum(r.number(p, "Density"), 0.0)))]


def coefficients(r, p):
    names = ("Absorption Coefficients", "Scatter Coefficients", "Emission Coefficients")
    return [Part(*(r.color(p, name) for name in names), lobes=lobes(r, p))]


def emission(r, p):
    return [Part(emission=scaled(r.color(p, "Color"), r.number(p, "Strength")))]


def principled(r, p):
    density = np.maximum(r.number(p, "Density"), 0.0)
    is_object = r.cells is not None
    name = p.socket("Density Attribute").default_value
    if name and np.any(density > 0):
        density = density * r.attribute(name, 0.0 if is_object else 1.0)
    color = r.color(p, "Color")
    tint = r.attribute(p.socket("Color Attribute").default_value, None)
    if tint is not None:
        color = color * np.maximum(colored(tint), 0.0)
    lost = np.maximum(1.0 - color, 0.0) * np.maximum(1.0 - np.sqrt(r.color(p, "Absorption Color")), 0.0)
    light = scaled(r.color(p, "Emission Color"), r.number(p, "Emission Strength"))
    strength = r.number(p, "Blackbody Intensity")
    if np.any(strength > 0):
        name = p.socket("Temperature Attribute").default_value
        kelvin = r.number(p, "Temperature") * r.attribute(name, 0.0 if is_object and name else 1.0)
        light = light + scaled(glow_of_heat(kelvin), strength) * r.color(p, "Blackbody Tint")
    return [Part(scaled(lost, density), scaled(color, density), light, lobes(r, p))]


def mix(r, p):
    factor = np.clip(r.number(p, "Fac"), 0.0, 1.0)
    return [x.times(1.0 - factor) for x in r.shares(p, "Shader")] + [x.times(factor) for x in r.shares(p, "Shader_001")]


def add(r, p):
    return r.shares(p, "Shader") + r.shares(p, "Shader_001")


CLOSURES = {
    "VOLUME_SCATTER": scatter,
    "VOLUME_ABSORPTION": absorption,
    "VOLUME_COEFFICIENTS": coefficients,
    "PRINCIPLED_VOLUME": principled,
    "EMISSION": emission,
    "MIX_SHADER": mix,
    "ADD_SHADER": add,
}


# Numbers


def value_node(r, p, output):
    return float(p.node.outputs[0].default_value)


def rgb_node(r, p, output):
    return np.array(p.node.outputs[0].default_value[:3], np.float64)


def volume_info(r, p, output):
    return r.attribute({"Density": "density", "Flame": "flame", "Temperature": "temperature", "Color": "color"}[output.name], 0.0)


def attribute_node(r, p, output):
    if r.cells is None:
        return None
    found = r.attribute(p.node.attribute_name, 0.0)
    return grey(found) if output.name == "Fac" else found


OPERATIONS = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: np.where(np.equal(b, 0), 0.0, a / np.where(np.equal(b, 0), 1.0, b)),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: np.maximum(a, 0.0) ** b,
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "GREATER_THAN": lambda a, b, c: np.where(a > b, 1.0, 0.0),
    "LESS_THAN": lambda a, b, c: np.where(a < b, 1.0, 0.0),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0.0)),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
}


def math_node(r, p, output):
    operation = OPERATIONS.get(p.node.operation)
    if operation is None or r.bake:
        return None
    a, b, c = (r.number(p, name) for name in ("Value", "Value_001", "Value_002"))
    made = operation(a, b, c)
    return np.clip(made, 0.0, 1.0) if p.node.use_clamp else made


def ramp_node(r, p, output):
    if r.bake:
        return None
    at = np.linspace(0, 1, 1025)
    table = np.array([p.node.color_ramp.evaluate(x) for x in at])
    factor = np.clip(r.number(p, "Fac"), 0.0, 1.0)
    made = [np.interp(factor, at, table[:, k]) for k in range(4)]
    return made[3] if output.name == "Alpha" else np.stack(made[:3], axis=-1)


def blackbody_node(r, p, output):
    return None if r.bake else blackbody(r.number(p, "Temperature"))


NUMBERS = {
    "VALUE": value_node,
    "RGB": rgb_node,
    "VOLUME_INFO": volume_info,
    "ATTRIBUTE": attribute_node,
    "MATH": math_node,
    "VALTORGB": ramp_node,
    "BLACKBODY": blackbody_node,
}
