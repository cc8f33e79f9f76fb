# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of light: by the scattering at visible surfaces, direct and indirect, divided by the colours of that scattering.

As in Blender, (direct + indirect) x colour of diffuse, glossy and transmission, with volumes, emission and environment, is the picture.
"""

import numpy as np

# Blender counts translucent surfaces as diffuse. Light path expressions of docs/reference/layers.md, up to the light.
KINDS = {"diffuse": "C<.D>", "glossy": "C<R[GS]>", "transmission": "C<T[GS]>"}
PARTS = {"direct": "[LOB]", "indirect": "[RTV]+[LOB]", "color": "W"}
# Property of the view layer or of Cycles' settings of it: (name of the pass, layer, layer of the colour that it is divided by).
PASSES = {
    f"use_pass_{kind}_{part}": (f"{kind.capitalize()} {part.capitalize()}", f"{kind}_{part}", f"{kind}_color") for kind in KINDS for part in ("direct", "indirect")
}
PASSES |= {f"use_pass_{kind}_color": (f"{kind.capitalize()} Color", f"{kind}_color", None) for kind in KINDS}
PASSES |= {f"use_pass_volume_{part}": (f"Volume {part.capitalize()}", f"volume_{part}", None) for part in ("direct", "indirect")}
SHORT = {"Diffuse": "Diff", "Glossy": "Gloss", "Transmission": "Trans", "Volume": "Volume", "Direct": "Dir", "Indirect": "Ind", "Color": "Col"}
# The names before Blender 5.0.
OLD_NAMES = {name: "".join(SHORT[word] for word in name.split()) for name, *_ in PASSES.values()}
BY_NAME = {name: (layer, color) for name, layer, color in PASSES.values()}
LEAST = 1e-6


def is_on(layer, name):
    """Whether a view layer has a pass; Cycles keeps some of its own."""
    return bool(getattr(layer, name, False) or getattr(getattr(layer, "cycles", None), name, False))


def wanted(layer):
    """Passes of light of a view layer by name, as entries of passes."""
    return {name: (name, 3, "RGB", "COLOR") for prop, (name, *_) in PASSES.items() if is_on(layer, prop)}


def layers(names):
    """Layers of the package for some passes; light that is seen directly goes with them."""
    found = [each for name in names if name in BY_NAME for each in BY_NAME[name] if each]
    return [*(expression(each) for each in dict.fromkeys(found)), "emission", "environment"] if found else []


def expression(layer):
    """An entry of the package's list of layers."""
    kind, part = layer.split("_", 1)
    return f"blender.{layer}={KINDS[kind]}{PARTS[part]}" if kind in KINDS else layer


def of_picture(picture, name):
    """One pass, (height, width, 3)."""
    light, share = (found and picture[expression(found).partition("=")[0]] for found in BY_NAME[name])
    if share is None:
        return light
    return np.where(share > LEAST, light / np.maximum(share, LEAST), 0.0)
