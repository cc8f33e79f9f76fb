# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of a view layer from the layers of a picture.

Blender's rows begin with the lowest; ours with the upper one. Depth is that along the view, as Cycles has it.
"""

import numpy as np

from . import aovs, hashes, light_passes

# Property of the view layer: (name of the pass, channels, kind). Properties that are missing in a version are skipped.
PASSES = {
    "use_pass_z": ("Depth", 1, "Z", "VALUE"),
    "use_pass_normal": ("Normal", 3, "XYZ", "VECTOR"),
    "use_pass_position": ("Position", 3, "XYZ", "VECTOR"),
    "use_pass_uv": ("UV", 3, "UVA", "VECTOR"),
    "use_pass_object_index": ("Object Index", 1, "X", "VALUE"),
    "use_pass_material_index": ("Material Index", 1, "X", "VALUE"),
    "use_pass_mist": ("Mist", 1, "Z", "VALUE"),
    "use_pass_vector": ("Vector", 4, "XYZW", "VECTOR"),
    "use_pass_ambient_occlusion": ("Ambient Occlusion", 3, "RGB", "COLOR"),
    "use_pass_emit": ("Emission", 3, "RGB", "COLOR"),
    "use_pass_environment": ("Environment", 3, "RGB", "COLOR"),
    "use_pass_shadow_catcher": ("Shadow Catcher", 3, "RGB", "COLOR"),
}
OLD_NAMES = {"Object Index": "IndexOB", "Material Index": "IndexMA", "Emission": "Emit", "Environment": "Env", "Ambient Occlusion": "AO"}
OLD_NAMES |= light_passes.OLD_NAMES
NAMED = {"use_pass_shadow": "Shadow"}
NAMED |= {f"use_pass_subsurface_{part}": f"Subsurface {part.capitalize()}" for part in ("direct", "indirect", "color")}
# Mattes: (layer of the package, name of the first passes).
MATTES = {
    "use_pass_cryptomatte_object": ("crypto_object", "CryptoObject"),
    "use_pass_cryptomatte_material": ("crypto_material", "CryptoMaterial"),
    "use_pass_cryptomatte_asset": ("crypto_asset", "CryptoAsset"),
}
FAR = 1e10
# Channels of the layer of ids.
ID_INSTANCE, ID_PRIMITIVE, ID_MATERIAL = 1, 2, 3


def wanted(layer, warn=None):
    """The passes of a view layer beside Combined, by name."""
    for name in NAMED:
        if warn and light_passes.is_on(layer, name):
            warn(f"view layer '{layer.name}': the pass {NAMED[name]} is not rendered")
    found = {entry[0]: entry for name, entry in PASSES.items() if light_passes.is_on(layer, name)}
    names = [f"{name}{level:02}" for _, name in mattes(layer) for level in range((matte_depth(layer) + 1) // 2)]
    return found | light_passes.wanted(layer) | aovs.wanted(layer) | {name: (name, 4, "rgba", "COLOR") for name in names}


def mattes(layer):
    """The mattes of a view layer: (layer of the package, name)."""
    return [entry for name, entry in MATTES.items() if getattr(layer, name, False)]


def matte_depth(layer):
    """How many things of a pixel mattes keep."""
    return max(2, getattr(layer, "pass_cryptomatte_depth", 6))


def matte_fields(layer, picture):
    """Attributes of the picture's file by which other programs find names in the mattes."""
    fields = {}
    for key, value in picture.metadata.items():
        parts = key.split("/")
        if len(parts) == 3 and parts[0] == "cryptomatte" and parts[2] == "name":
            name = f"{layer.name}.{value}"
            new = f"cryptomatte/{hashes.murmur(name.encode()):08x}"[:19]
            fields[f"{new}/name"] = name
            for field in ("hash", "conversion", "manifest"):
                fields[f"{new}/{field}"] = picture.metadata[f"cryptomatte/{parts[1]}/{field}"]
    return fields


def registered(engine, scene, layer):
    """Tells Blender which passes there will be."""
    engine.register_pass(scene, layer, "Combined", 4, "RGBA", "COLOR")
    for name, channels, letters, kind in wanted(layer).values():
        engine.register_pass(scene, layer, name, channels, letters, kind)


def combined(picture, transparent):
    """Light and opacity, (height, width, 4), premultiplied."""
    color = np.asarray(picture)
    if not transparent:
        color[..., 3] = 1.0
        return color
    color[..., :3] -= picture["background"][..., :3]
    return color


def needs_layers(layer, transparent):
    return transparent or bool(wanted(layer))


def of_picture(picture, entry, export, others):
    """One pass, (height, width, channels); `others` are those that are there already, by name."""
    name = entry[0]
    if name in others:
        return others[name]
    if name in light_passes.BY_NAME:
        return light_passes.of_picture(picture, name)
    if entry in aovs.entries(export.view_layer):
        return aovs.of_picture(picture, entry, export)
    hit = np.isfinite(picture["depth"])
    if name == "Depth":
        depth = picture["Z"] if export.view.parameters.get("kind", 0) < 2 else picture["depth"]
        return np.where(hit, depth, FAR)[..., None]
    if name == "Normal":
        return picture["N"]
    if name == "Position":
        return np.where(hit[..., None], picture["P"], 0.0)
    if name in {"Emission", "Environment"} and name.lower() in picture.layers:
        return picture[name.lower()]
    if name == "Emission":
        return picture["unscattered"] - picture["background"][..., :3]
    if name == "Environment":
        return picture["background"][..., :3]
    if name.startswith("Crypto"):
        return picture[name]
    return indices(picture, name, export)


def indices(picture, name, export):
    """Pass indices of objects or materials at the first sample of each pixel."""
    ids = picture["id"]
    instance = ids[..., ID_INSTANCE]
    material = ids[..., ID_MATERIAL]
    made = np.zeros((*instance.shape, 1), np.float32)
    if name == "Object Index":
        for number in np.unique(instance):
            found = export.objects.get(int(number))
            if found:
                made[instance == number] = found[0].pass_index
        return made
    for number in np.unique(material):
        made[material == number] = export.material_indices.get(int(number), 0)
    return made


def write(layer, name, values):
    """Puts an array into a pass of a result."""
    found = layer.passes.get(name) or layer.passes.get(OLD_NAMES.get(name, name))
    if found is None:
        return False
    found.rect.foreach_set(np.ascontiguousarray(values[::-1], dtype=np.float32).ravel())
    return True
