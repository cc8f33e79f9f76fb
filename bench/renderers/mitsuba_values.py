# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of our definitions in Mitsuba (mitsuba_models.py) for chosen directions, as crates/shading/tests/mitsuba.rs reads them.

    python3 mitsuba_values.py > ../../crates/shading/tests/mitsuba.csv

First it checks itself: without what goes between facets more than once, and with the separable shadowing of Mitsuba's own
models, the definitions must have the values of Mitsuba's `roughconductor`, `roughdielectric` and `principled`. Directions: from
outside the surface; local, z = normal. Needs `pip install mitsuba numpy`. 
"""
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

import drjit as dr

from mitsuba_models import Facets, Glass, Layered, Mixed, Pane

PAIRS = 10


def directions(rng, through, alpha, ior):
    """A view and where light goes: near the lobe, so that values matter, or anywhere."""
    v = rng.normal(size=3)
    v[2] = abs(v[2]) + 0.05
    v /= np.linalg.norm(v)
    if rng.random() < 0.3:
        l = rng.normal(size=3)
        l[2] = abs(l[2]) * (-1 if through and rng.random() < 0.5 else 1)
        return v, l / np.linalg.norm(l)
    slope = rng.normal(size=2) * alpha
    h = np.array([*slope, 1.0]) / np.sqrt(1 + slope @ slope)
    c = v @ h
    if through and rng.random() < 0.6:
        beyond = np.sqrt(max(0, 1 - (1 - c * c) / ior**2))
        l = h * (c / ior - beyond) - v / ior
    else:
        l = 2 * c * h - v
    return v, l / np.linalg.norm(l)


def values(bsdf, pairs):
    si = dr.zeros(mi.SurfaceInteraction3f, len(pairs))
    si.wi = mi.Vector3f(*np.array([v for v, _ in pairs]).T.astype(np.float32))
    wo = mi.Vector3f(*np.array([l for _, l in pairs]).T.astype(np.float32))
    value = bsdf.eval(mi.BSDFContext(), si, wo)
    return np.array(value).reshape(3, -1).T.astype(float)


def shadowing(alpha, v, l):
    """The separable shadowing over the correlated one."""
    hidden = lambda w: 0.5 * (np.sqrt(1 + alpha**2 * (w[0] ** 2 + w[1] ** 2) / w[2] ** 2) - 1)
    a, b = hidden(v), hidden(l)
    return (1 + a + b) / ((1 + a) * (1 + b))


def check(name, own, stock, alpha, pairs, factor=1.0):
    """Both agree, `factor` times the stock model's value."""
    pairs = [(v, l) for v, l in pairs if v[2] > 0 and abs(l[2]) > 0.02]
    a = values(own, pairs) * np.array([[shadowing(alpha, v, l)] for v, l in pairs])
    b = values(mi.load_dict(stock), pairs) * factor
    off = np.abs(a - b) / np.maximum(b, 1e-3 * b.max())
    print(f"{name}: {len(pairs)} pairs, differ by {off.max():.1e} at most", file=sys.stderr)
    assert off.max() < 2e-3, (name, pairs[off.max(axis=1).argmax()])


def check_against_stock(rng):
    Facets.more_lobe = lambda self, v, l: mi.Float(0)
    rgb = lambda *c: {"type": "rgb", "value": list(c)}
    for alpha in (0.05, 0.2, 0.5):
        pairs = [directions(rng, False, alpha, 1.5) for _ in range(400)]
        pairs = [(v, l) for v, l in pairs if l[2] > 0]
        gold = (0.95, 0.7, 0.3)
        principled = {"type": "principled", "base_color": rgb(*gold), "metallic": 1.0, "roughness": alpha**0.5}
        check(f"principled metal {alpha}", Layered(gold, 1.0, alpha), principled, alpha, pairs)
        pairs = [directions(rng, True, alpha, 1.5) for _ in range(400)]
        glass = Glass(alpha, 1.5)
        glass.lost = [1e9, 1e9]
        stock = {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": 1.5, "ext_ior": 1.0}
        check(f"glass {alpha}, mirrored", glass, stock, alpha, [p for p in pairs if p[1][2] > 0])
        # Mitsuba scales radiance that enters glass.
        check(f"glass {alpha}, through", glass, stock, alpha, [p for p in pairs if p[1][2] < 0], 1.5**2)


def main():
    kept = Facets.more_lobe
    check_against_stock(np.random.default_rng(1))
    Facets.more_lobe = kept

    rng = np.random.default_rng(7)
    clay, gold = (0.7, 0.4, 0.15), (0.95, 0.7, 0.3)
    layered = [(clay, 0.0, 0.1, 1.5, 0, 0), (clay, 0.0, 0.4, 1.9, 0, 0), (gold, 1.0, 0.05, 1.5, 0, 0), (gold, 1.0, 0.25, 1.5, 0, 0), (gold, 1.0, 0.8, 1.5, 0, 0)]
    layered += [(gold, 0.5, 0.2, 1.5, 0, 0), (clay, 0.0, 0.3, 1.5, 1.0, 0.04), (gold, 1.0, 0.5, 1.5, 0.6, 0.15)]
    glass = [((1.0, 1.0, 1.0), alpha, ior) for alpha, ior in ((0.05, 1.5), (0.15, 2.2), (0.3, 1.5), (0.7, 1.33), (0.3, 1 / 1.5))]
    print("model,r,g,b,metallic,alpha,ior,coat,coat alpha,sheen r,g,b,sheen roughness,transmission,view x,y,z,light x,y,z,value r,g,b")
    plain = (0, 0, 0, 0, 0)
    for base, metallic, alpha, ior, coat, coat_alpha in layered:
        pairs = [p for p in (directions(rng, False, alpha, ior) for _ in range(3 * PAIRS)) if p[1][2] > 0.02][:PAIRS]
        show("layered", (*base, metallic, alpha, ior, coat, coat_alpha, *plain), pairs, Layered(base, metallic, alpha, ior, coat, coat_alpha))

    def show_both_sides(model, numbers, alpha, bent, bsdf):
        pairs = [p for p in (directions(rng, True, alpha, bent) for _ in range(9 * PAIRS)) if abs(p[1][2]) > 0.02][: 2 * PAIRS]
        show(model, numbers, pairs, bsdf)

    for tint, alpha, ior in glass:
        show_both_sides("glass", (*tint, 0, alpha, ior, 0, 0, *plain), alpha, ior, Glass(alpha, ior, tint))
    for metallic, coat, sheen, roughness in ((0, 0, (1, 1, 1), 0), (0, 0, gold, 0.15), (0, 0, (1, 1, 1), 0.3), (0, 0, gold, 1), (1, 0, gold, 0.5), (0, 1, gold, 0.5)):
        numbers = (*clay, metallic, 0.4, 1.5, coat, 0.04 * coat)
        pairs = [p for p in (directions(rng, False, 2.0, 1.5) for _ in range(6 * PAIRS)) if p[1][2] > 0.02][: 2 * PAIRS]
        show("layered", (*numbers, *sheen, roughness, 0), pairs, Layered(clay, *numbers[3:], sheen, roughness))
    # Light goes straight on through panes: as if there were no index.
    for tint, alpha, ior in ((gold, 0.05, 1.5), (gold, 0.3, 1.5), (gold, 0.7, 2.2)):
        show_both_sides("pane", (*tint, 0, alpha, ior, 0, 0, *plain), alpha, 1.0, Pane(alpha, ior, tint))
    for alpha, share in ((0.1, 0.3), (0.4, 0.7)):
        for model, made, bent in (("pane", Pane, 1.0), ("glass", Glass, 1.5)):
            mixed = Mixed(Layered(clay, 0.0, alpha), made(alpha, 1.5, clay), share)
            show_both_sides("partly " + model, (*clay, 0, alpha, 1.5, 0, 0, 0, 0, 0, 0, share), alpha, bent, mixed)


def show(model, numbers, pairs, bsdf):
    for (v, l), value in zip(pairs, values(bsdf, pairs)):
        print(",".join([model, *("%.9g" % x for x in (*numbers, *v, *l)), *("%.6g" % x for x in value)]))


main()
