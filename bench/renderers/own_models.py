# SPDX-License-Identifier: GPL-3.0-or-later
"""What gnurt makes of the materials of an MTL file (crates/scene/src/io/obj/material.rs), in words that other renderers have a model for.


"""
import math
from dataclasses import dataclass

MIRROR_EXPONENT = 1000.0


@dataclass
class Model:
    """`kind` is glass (smooth; `colour` of what goes through), metal (GGX without Fresnel; `colour` of what is thrown back),
    plastic (a matte ground under a GGX or smooth coat) or matte. `alpha` 0: smooth. `opacity`: the rest goes straight through."""

    kind: str
    colour: tuple = (1.0, 1.0, 1.0)
    ior: float = 1.5
    alpha: float = 0.0
    opacity: float = 1.0


def read_phong(path):
    """The statements of each material of an MTL file that say how it scatters."""
    materials, current = {}, None
    for line in open(path, errors="replace"):
        words = line.split()
        if words[:1] == ["newmtl"]:
            current = materials.setdefault(words[1], {})
        elif words and words[0] in ("Kd", "Ks", "Tf", "Ns", "Ni", "d", "illum", "map_d"):
            current[words[0]] = words[1:]
    return materials


def model(phong, textured):
    """The model that is nearest to a material with these statements."""
    number = lambda key, default: float(phong[key][0]) if key in phong else default
    colour = lambda key, default: tuple(float(x) for x in phong[key][:3]) if key in phong else default
    kd, ks = colour("Kd", (0.0,) * 3), colour("Ks", (0.0,) * 3)
    mean = lambda c: sum(c) / 3
    exponent, opacity = number("Ns", None), number("d", 1.0)
    alpha = math.sqrt(2 / (exponent + 2)) if exponent is not None else None
    illum, black = int(number("illum", 2)), mean(kd) == 0 and not textured
    if illum in (4, 6, 7, 9) or (opacity < 1 and black and ("Tf" in phong or number("Ni", 1.0) > 1)):
        return Model("glass", colour("Tf", (1.0,) * 3), number("Ni", 1.5))
    if (illum in (3, 5) and mean(ks) > mean(kd)) or (black and mean(ks) >= 0.2):
        smooth = exponent is None or exponent >= MIRROR_EXPONENT
        return Model("metal", ks, alpha=0.0 if smooth else alpha, opacity=opacity)
    if exponent is not None and mean(ks) > 0 and not black:
        root = math.sqrt(min(mean(ks), 0.95))
        return Model("plastic", ior=(1 + root) / (1 - root), alpha=alpha, opacity=opacity)
    return Model("matte", opacity=opacity)
