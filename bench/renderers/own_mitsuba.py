# SPDX-License-Identifier: GPL-3.0-or-later
"""Mitsuba 3 as a rival of own_materials.py. Needs `pip install mitsuba` and, for llvm variants, a libLLVM (DRJIT_LIBLLVM_PATH). """
import time

import mitsuba as mi
import numpy as np

import interiors
import mitsuba_path


def bsdf(model, reflectance):
    """Mitsuba's own model."""
    rgb = lambda value: {"type": "rgb", "value": list(value)}
    twosided = lambda nested: {"type": "twosided", "nested": nested}
    if model.kind == "glass":
        return {"type": "dielectric", "int_ior": model.ior, "ext_ior": 1.0, "specular_transmittance": rgb(model.colour)}
    if model.kind == "metal":
        metal = {"material": "none", "specular_reflectance": rgb(model.colour)}
        rough = {"type": "roughconductor", "distribution": "ggx", "alpha": model.alpha}
        made = twosided((rough if model.alpha else {"type": "conductor"}) | metal)
    elif model.kind == "plastic":
        plastic = {"diffuse_reflectance": reflectance, "int_ior": model.ior, "ext_ior": 1.0, "nonlinear": False}
        # Mitsuba has no rough plastic that is nearly smooth.
        rough = {"type": "roughplastic", "distribution": "ggx", "alpha": model.alpha}
        made = twosided((rough if model.alpha >= 0.02 else {"type": "plastic"}) | plastic)
    else:
        made = twosided({"type": "diffuse", "reflectance": reflectance})
    return {"type": "mask", "opacity": model.opacity, "nested": made} if model.opacity < 1 else made


def reflectance(part):
    """Kd times map_Kd."""
    if not part.texture:
        return {"type": "rgb", "value": list(part.reflectance)}
    bitmap = mi.Bitmap(part.texture).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    data = (np.array(bitmap) * np.array(part.reflectance, np.float32)).astype(np.float32)
    return {"type": "bitmap", "data": mi.TensorXf(data), "raw": True, "filter_type": "bilinear", "wrap_mode": "repeat"}


class Mitsuba:
    name = f"Mitsuba {mi.__version__}"

    def __init__(self, arguments, scene, models, camera, depth, folder):
        mi.set_variant(arguments.variant)
        import drjit as dr

        dr.set_thread_count(1)
        parts = interiors.read(arguments.scenes, scene)
        bsdfs = {part.name: bsdf(models[part.name], reflectance(part)) for part in parts}
        self.scene = mitsuba_path.load_scene(parts, camera, folder, bsdfs, depth)
        mi.render(self.scene, spp=arguments.spp, seed=99).numpy()  # compiles

    def render(self, spp, seed):
        start = time.process_time()
        picture = mi.render(self.scene, spp=spp, seed=seed).numpy().astype(np.float64)
        return picture, time.process_time() - start, spp
