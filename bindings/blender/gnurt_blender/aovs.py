# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes that materials write by AOV Output nodes: layers of the package by the closure `debug`. Tests: `tests/checks.py`."""

import numpy as np

from .nodes.tree import socket_value

COLOR, VALUE = (4, "RGBA", "COLOR"), (1, "X", "VALUE")


def entries(layer):
    """The passes of a view layer, as `passes` has them."""
    return [(each.name, *(COLOR if each.type == "COLOR" else VALUE)) for each in layer.aovs if getattr(each, "is_valid", True)]


def wanted(layer):
    return {entry[0]: entry for entry in entries(layer)}


def tag(name, is_color):
    """The word of the package for a pass."""
    return f"aov_{'color' if is_color else 'value'}_{''.join(x if x.isalnum() else f'_{ord(x):x}' for x in name)}"


def statements(code, tree):
    """The end of a material: what its nodes write."""
    made = []
    for node in tree.nodes:
        if node.type != "OUTPUT_AOV" or node.mute or not node.aov_name:
            continue
        for name, kind in (("Color", "color"), ("Value", "float")):
            socket = node.inputs[name]
            value = code.var(kind, socket_value(code, tree, socket, None, kind))
            word = tag(node.aov_name, kind == "color")
            made.append(f'Ci += color({value}) * debug("{word}");' if kind == "float" else f'Ci += {value} * debug("{word}");')
            code.aovs.add(word)
    return made


def layers(export, passes):
    """The layers to render for these passes."""
    known = {tag(entry[0], entry[1:] == COLOR) for entry in passes.values() if entry in entries(export.view_layer)}
    return [f"shader.{word}" for word in sorted(known & export.aovs)]


def of_picture(picture, entry, export):
    """A pass; black where no material writes it."""
    name, channels, *_ = entry
    word = f"shader.{tag(name, entry[1:] == COLOR)}"
    shape = np.asarray(picture).shape[:2]
    found = np.asarray(picture[word])[..., :3] if word in picture.layers else np.zeros((*shape, 3), np.float32)
    return np.dstack([found, np.ones(shape, np.float32)]) if channels == 4 else found[..., :1]
