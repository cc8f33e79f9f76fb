# SPDX-License-Identifier: GPL-3.0-or-later
"""BSDFs for Mitsuba by the definitions of docs/reference/materials.md, written from the papers and apart from gnurt's code.

Facets are Mitsuba's own GGX distribution, its sampling of visible normals and its Fresnel equations; what is added is the
height-correlated shadowing of [Hei14], Schlick's reflectance, what [KC17] sends back of light between facets (from tables
made here by quadrature, at the very roughness), layers, the sheen of [EK17] and [NP13], and panes. Directions as in Mitsuba: `si.wi` to the viewer.
Set the variant before this is imported. Source: as said; original.
"""
import drjit as dr
import mitsuba as mi
import numpy as np

COSINES = 256
GRID = 96


def visible_facets(alpha, cos):
    """Facets seen from cosine `cos`, at the middles of GRID x GRID strata, which are narrow towards those that face away, where
    few facets lose the light; their shares; the view; and the function that hides: (n, 3), (n,), (3,), lambda."""
    x, w = (np.mgrid[0:GRID, 0:GRID].reshape(2, -1) + 0.5) / GRID
    u, share = 1 - (1 - x) ** 3, 3 * (1 - x) ** 2 / len(x)
    share /= share.sum()
    v = np.array([np.sqrt(1 - cos * cos), 0, cos])
    stretched = v * [alpha, alpha, 1]
    stretched /= np.linalg.norm(stretched)
    z = (1 - u) * (1 + stretched[2]) - stretched[2]
    r = np.sqrt(np.maximum(0, 1 - z * z))
    h = np.stack([r * np.cos(2 * np.pi * w), r * np.sin(2 * np.pi * w), z], axis=-1) + stretched
    h *= [alpha, alpha, 1]
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    hidden = lambda d: 0.5 * (np.sqrt(1 + alpha**2 * (d[..., 0] ** 2 + d[..., 1] ** 2) / np.maximum(d[..., 2] ** 2, 1e-20)) - 1)
    return h, share, v, hidden


def cosines():
    return np.maximum(np.linspace(0, 1, COSINES), 1e-4)


def hemisphere(cos, rings=200, sectors=100):
    """A view of cosine `cos`, directions over half of its hemisphere, and twice their solid angles: (3,), (n, 3), (n,).
    Rings are narrow at the horizon."""
    edges = np.linspace(0, 1, rings + 1) ** 2
    z = np.repeat((edges[1:] + edges[:-1]) / 2, sectors)
    area = np.repeat(np.diff(edges), sectors) * 2 * np.pi / sectors
    turn = np.tile((np.arange(sectors) + 0.5) / sectors * np.pi, rings)
    r = np.sqrt(1 - z * z)
    return np.array([np.sqrt(1 - cos * cos), 0, cos]), np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1), area


def fibres(power, v, l):
    """The lobe of sheen times the cosine of `l`, white, by the papers: [EK17]'s distribution, [NP13]'s visibility."""
    h = v + l
    sin2 = np.clip(1 - h[:, 2] ** 2 / (h * h).sum(axis=-1), 0, 1)
    return (2 + power) * sin2 ** (power / 2) / (2 * np.pi) * l[:, 2] / (4 * (v[2] + l[:, 2] - v[2] * l[:, 2]))


def hemisphere_average(entries):
    """Of entries at equal steps of the cosine, weighted by it."""
    x = np.linspace(0, 1, len(entries))
    return np.trapezoid((entries.T * 2 * x).T, x, axis=0)


def mirrored_once(alpha):
    """Albedo after one bounce by cosine, split by Schlick's reflectances at normal and grazing incidence: (COSINES, 2)."""
    rows = []
    for cos in cosines():
        h, weights, v, hidden = visible_facets(alpha, cos)
        c = h @ v
        l = 2 * c[:, None] * h - v
        weight = np.where(l[:, 2] > 0, (1 + hidden(v)) / (1 + hidden(v) + hidden(l)), 0)
        rise = (1 - np.clip(c, 0, 1)) ** 5
        rows.append([weights @ (weight * (1 - rise)), weights @ (weight * rise)])
    return np.array(rows)


def fresnel(cos, eta):
    """Share that is mirrored; `eta` is the index here over that beyond."""
    sin2 = eta * eta * (1 - cos * cos)
    beyond = np.sqrt(np.maximum(0, 1 - sin2))
    a, b = (cos - eta * beyond) / (cos + eta * beyond), (eta * cos - beyond) / (eta * cos + beyond)
    return np.where(sin2 >= 1, 1, (a * a + b * b) / 2)


def glass_once(alpha, eta):
    """Albedo after one bounce, mirrored and through, by cosine."""
    rows = []
    for cos in cosines():
        h, weights, v, hidden = visible_facets(alpha, cos)
        c = h @ v
        share = fresnel(c, eta)
        l = 2 * c[:, None] * h - v
        mirrored = np.where(l[:, 2] > 0, (1 + hidden(v)) / (1 + hidden(v) + hidden(l)), 0)
        beyond = np.sqrt(np.maximum(0, 1 - eta * eta * (1 - c * c)))
        t = h * (eta * c - beyond)[:, None] - v * eta
        through = np.where(t[:, 2] < 0, (1 + hidden(v)) / (1 + hidden(v) + hidden(t)), 0)
        rows.append(weights @ (share * mirrored + (1 - share) * through))
    return np.array(rows)


class Table:
    """A function of the cosine, linear between its entries."""

    def __init__(self, entries):
        self.entries = mi.Float(entries.astype(np.float32))

    def __call__(self, cos, active=True):
        x = dr.clip(dr.abs(cos), 0, 1) * (dr.width(self.entries) - 1)
        i = dr.minimum(mi.UInt32(x), dr.width(self.entries) - 2)
        a, b = (dr.gather(mi.Float, self.entries, i + k, active) for k in (0, 1))
        return dr.lerp(a, b, x - mi.Float(i))


class Sheen:
    """White fibres: what makes light by the papers is scaled down, for both directions alike, to send back no more than all."""

    STEPS = 128  # of the root of the cosine: albedos are steep at the horizon

    def __init__(self, roughness):
        self.power = 1 / max(roughness, 0.07) ** 2
        views = [hemisphere(max(cos, 1e-6)) for cos in np.linspace(0, 1, self.STEPS) ** 2]
        roots = np.linspace(0, 1, self.STEPS)
        made = np.array([fibres(self.power, v, l) @ area for v, l, area in views])
        scale = lambda cos: np.maximum(1, np.interp(np.sqrt(cos), roots, made))
        kept = [(fibres(self.power, v, l) / np.maximum(scale(v[2]), scale(l[:, 2]))) @ area for v, l, area in views]
        self.made, self.kept = Table(made), Table(np.array(kept))
        # By the cosine, as those of facets.
        self.entries = np.interp(np.sqrt(cosines()), roots, kept)

    def albedo(self, w):
        """What is sent back in the end of light from `w`."""
        return self.kept(dr.sqrt(dr.abs(w.z)))

    def lobe(self, v, l, h):
        """Times the cosine of `l`."""
        density = (2 + self.power) * (1 - h.z * h.z) ** (self.power / 2) / (2 * dr.pi)
        most = dr.maximum(1, dr.maximum(self.made(dr.sqrt(v.z)), self.made(dr.sqrt(l.z))))
        return density * l.z / (4 * (v.z + l.z - v.z * l.z) * most)


class Facets:
    """GGX facets with Schlick's reflectance and all bounces between them, per channel."""

    def __init__(self, alpha):
        self.alpha = max(alpha, 1e-3)
        self.once = mirrored_once(self.alpha)
        self.average = hemisphere_average(self.once)
        self.normal, self.grazing = Table(self.once[:, 0]), Table(self.once[:, 1])

    def distribution(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)

    def hidden(self, w):
        return 0.5 * (dr.sqrt(1 + self.alpha**2 * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1)

    def lobe(self, v, l, h):
        """Without Fresnel's factor, times the cosine of `l`."""
        return self.distribution().eval(h) / ((1 + self.hidden(v) + self.hidden(l)) * 4 * v.z)

    def mirrored_pdf(self, v, h):
        return self.distribution().pdf(v, h) / (4 * dr.dot(v, h))

    def more(self, f0, f90):
        """Share of what one bounce leaves that comes out in the end."""
        average = f0 * 20 / 21 + f90 / 21
        white = float(self.average.sum())
        return average * average * white / (1 - average * (1 - white))

    def more_lobe(self, v, l):
        lost = lambda w: 1 - self.normal(w.z) - self.grazing(w.z)
        return lost(v) * lost(l) * l.z * dr.inv_pi / max(1 - float(self.average.sum()), 1e-6)

    def all(self, cos, f0, f90):
        normal, grazing = self.normal(cos), self.grazing(cos)
        return f0 * normal + f90 * grazing + self.more(f0, f90) * (1 - normal - grazing)

    def all_entries(self, f0, f90):
        """The same for every entry of the table: (COSINES,)."""
        return f0 * self.once[:, 0] + f90 * self.once[:, 1] + self.more(f0, f90) * (1 - self.once.sum(axis=1))


def schlick(f0, f90, cos):
    rise = (1 - dr.clip(cos, 0, 1)) ** 5
    return f0 + (f90 - f0) * rise


class Definition(mi.BSDF):
    """What has `eval_pdf` and chooses directions: the rest that Mitsuba asks for."""

    def __init__(self, *lobes):
        mi.BSDF.__init__(self, mi.Properties())
        self.m_components = list(lobes)
        self.m_flags = lobes[0]
        for lobe in lobes[1:]:
            self.m_flags = self.m_flags | lobe

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sampled(self, ctx, si, wo, active=True, eta=1.0):
        """What `sample` gives back for a direction; `eta` is the index beyond over that here."""
        value, pdf = self.eval_pdf(ctx, si, wo, active)
        mirrored = wo.z * si.wi.z > 0
        ok = active & (pdf > 0)
        bs = mi.BSDFSample3f()
        bs.wo = wo
        bs.pdf = dr.select(ok, pdf, 0)
        bs.eta = dr.select(mirrored, 1.0, eta)
        bs.sampled_type = dr.select(mirrored, mi.UInt32(+mi.BSDFFlags.GlossyReflection), mi.UInt32(+mi.BSDFFlags.GlossyTransmission))
        bs.sampled_component = dr.select(mirrored, mi.UInt32(0), mi.UInt32(1))
        return bs, dr.select(ok, value / pdf, 0)

    def to_string(self):
        return type(self).__name__ + "[]"


class Layered(Definition):
    """Plastic or metal or a mix, under sheen, under a coat: numbers as glTF's, but for `alpha`s, the squares of its roughnesses."""

    def __init__(self, base, metallic, alpha, ior=1.5, coat=0.0, coat_alpha=0.0, sheen=(0.0, 0.0, 0.0), sheen_roughness=0.0):
        Definition.__init__(self, mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide)
        self.base, self.metallic, self.coat = base, metallic, coat
        self.f0 = ((ior - 1) / (ior + 1)) ** 2
        self.gloss, self.clear = Facets(alpha), Facets(coat_alpha)
        self.sheen, self.fibres = sheen, Sheen(sheen_roughness) if any(sheen) else None
        left = 1 - coat * self.clear.all_entries(0.04, 1.0)
        left *= 1 - max(sheen) * self.fibres.entries if self.fibres else 1
        self.left_on_average = float(hemisphere_average(left * (1 - self.gloss.all_entries(self.f0, 1.0))))

    def eval_pdf(self, ctx, si, wo, active=True):
        v, l = si.wi, wo
        active = active & (v.z > 0) & (l.z > 0)
        h = dr.normalize(v + l)
        c = dr.dot(v, h)
        below_coat = lambda w: 1 - self.coat * self.clear.all(w.z, 0.04, 1.0)
        below_both = lambda w: below_coat(w) * (1 - max(self.sheen) * self.fibres.albedo(w) if self.fibres else 1)
        body_gets = lambda w: below_both(w) * (1 - self.gloss.all(w.z, self.f0, 1.0))
        left = dr.minimum(below_both(v), below_both(l))
        lobe, more = self.gloss.lobe(v, l, h), self.gloss.more_lobe(v, l)
        clear = self.coat * (
            schlick(0.04, 1.0, c) * self.clear.lobe(v, l, h) + self.clear.more(0.04, 1.0) * self.clear.more_lobe(v, l)
        )
        m = self.metallic
        body = (1 - m) * body_gets(v) * body_gets(l) / self.left_on_average * l.z * dr.inv_pi
        cloth = dr.minimum(below_coat(v), below_coat(l)) * self.fibres.lobe(v, l, h) if self.fibres else 0
        channels = []
        for base, sheen in zip(self.base, self.sheen):
            f0, f90 = (1 - m) * self.f0 + m * base, 1.0
            mixed = (1 - m) * self.gloss.more(self.f0, 1.0) + m * self.gloss.more(base, 1.0)
            channels.append(clear + sheen * cloth + left * (schlick(f0, f90, c) * lobe + mixed * more) + base * body)
        shares = self.shares()
        pdf = shares[0] * self.clear.mirrored_pdf(v, h) + shares[1] * self.gloss.mirrored_pdf(v, h)
        pdf += shares[2] * l.z * dr.inv_pi
        return dr.select(active, mi.Color3f(*channels), 0), dr.select(active, pdf, 0)

    def shares(self):
        """Of coat, gloss and the cosine in the choice of directions: any would do."""
        coat, gloss = 0.2 * (self.coat > 0), 0.3 + 0.4 * self.metallic
        return coat, gloss * (1 - coat), (1 - gloss) * (1 - coat)

    def sample(self, ctx, si, sample1, sample2, active=True):
        shares = self.shares()
        mirror = lambda facets: mi.reflect(si.wi, facets.distribution().sample(si.wi, sample2)[0])
        wo = mi.warp.square_to_cosine_hemisphere(sample2)
        wo = dr.select(sample1 < shares[0] + shares[1], mirror(self.gloss), wo)
        wo = dr.select(sample1 < shares[0], mirror(self.clear), wo)
        return self.sampled(ctx, si, wo, active)


class Glass(Definition):
    """Rough glass with all bounces between its facets; radiance is not scaled by the square of the index."""

    def __init__(self, alpha, ior, tint=(1.0, 1.0, 1.0)):
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        through = mi.BSDFFlags.GlossyTransmission | mi.BSDFFlags.NonSymmetric
        Definition.__init__(self, mi.BSDFFlags.GlossyReflection | sides, through | sides)
        self.alpha, self.ior, self.tint = alpha, ior, tint
        # From outside (index 1 over ior), from inside.
        once = [glass_once(alpha, 1 / ior), glass_once(alpha, ior)]
        self.once = [Table(entries) for entries in once]
        self.lost = [1 - float(hemisphere_average(entries)) for entries in once]
        # [KC17]: the average of Fresnel's share on the rarer side, and which part of further bounces goes through such that
        # light may go both ways.
        denser = max(ior, 1 / ior)
        mirrored = (denser - 1) / (4.08567 + 1.00071 * denser)
        capacity = [self.lost[0], self.lost[1] * ior * ior]
        self.through = [(1 - mirrored) * min(capacity) / c for c in capacity]

    def facets(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)

    def hidden(self, w):
        return 0.5 * (dr.sqrt(1 + self.alpha**2 * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1)

    def eval_pdf(self, ctx, si, wo, active=True):
        outside = si.wi.z > 0
        sign = dr.select(outside, 1.0, -1.0)
        v, l = si.wi * mi.Vector3f(1, 1, sign), wo * mi.Vector3f(1, 1, sign)
        eta = dr.select(outside, 1 / self.ior, self.ior)  # here over beyond
        here = lambda pair: dr.select(outside, pair[0], pair[1])
        beyond = lambda pair: dr.select(outside, pair[1], pair[0])
        once_here = lambda cos: here([t(cos) for t in self.once])
        once_beyond = lambda cos: beyond([t(cos) for t in self.once])
        mirrors = l.z > 0
        distribution = self.facets()

        # Facet that leads from v to l.
        h = dr.normalize(dr.select(mirrors, v + l, v * eta + l))
        h = dr.select(h.z < 0, -h, h)
        cv, cl = dr.dot(v, h), dr.dot(l, h)
        share = mi.fresnel(cv, mi.Float(1 / eta))[0]
        d, shadow = distribution.eval(h), 1 / (1 + self.hidden(v) + self.hidden(l))
        reflected = share * d * shadow / (4 * v.z)
        change = -cl / dr.square(eta * cv + cl)
        refracted = (1 - share) * d * shadow * cv * change / v.z
        once = dr.select(mirrors, reflected, dr.select((cv > 0) & (cl < 0), refracted, 0))

        lost, cos = 1 - once_here(v.z), dr.abs(l.z)
        lost_l = dr.select(mirrors, 1 - once_here(l.z), 1 - once_beyond(l.z))
        mean = dr.select(mirrors, here(self.lost), beyond(self.lost))
        part = dr.select(mirrors, 1 - here(self.through), here(self.through))
        more = part * lost * lost_l / mean * cos * dr.inv_pi
        value = once + more

        visible = distribution.pdf(v, h)
        pdf = dr.select(mirrors, share * visible / (4 * cv), dr.select((cv > 0) & (cl < 0), (1 - share) * visible * change, 0))
        pdf = (1 - lost) * pdf + lost * part * cos * dr.inv_pi
        active = active & (v.z > 0) & (l.z != 0)
        colour = dr.select(mirrors, mi.Color3f(1), mi.Color3f(*self.tint)) * value
        return dr.select(active, colour, 0), dr.select(active, pdf, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        outside = si.wi.z > 0
        flip = mi.Vector3f(1, 1, dr.select(outside, 1.0, -1.0))
        v = si.wi * flip
        h = self.facets().sample(v, sample2)[0]
        share, _, eta_it, eta_ti = mi.fresnel(dr.dot(v, h), mi.Float(dr.select(outside, self.ior, 1 / self.ior)))
        cos_t = mi.fresnel(dr.dot(v, h), mi.Float(dr.select(outside, self.ior, 1 / self.ior)))[1]
        lost = 1 - dr.select(outside, self.once[0](v.z), self.once[1](v.z))
        through = dr.select(outside, self.through[0], self.through[1])
        rest = (sample1 - lost) / (1 - lost)
        mirrors = dr.select(sample1 < lost, sample1 >= lost * through, rest < share)
        diffuse = mi.warp.square_to_cosine_hemisphere(sample2)
        diffuse = dr.select(mirrors, diffuse, -diffuse)
        facet = dr.select(mirrors, mi.reflect(v, h), mi.refract(v, h, cos_t, eta_ti))
        l = dr.select(sample1 < lost, diffuse, facet)
        ok = active & (dr.select(mirrors, l.z > 0, l.z < 0))
        return self.sampled(ctx, si, l * flip, ok, eta_it)


class Pane(Definition):
    """Rough glass so thin that its two faces are one surface: facets mirror what both faces do, all light between them summed,
    and what is not mirrored goes on as if mirrored and turned over to the other side. `by_formula`: glTF's example instead,
    where Schlick's reflectance of one face stands for both."""

    def __init__(self, alpha, ior, tint=(1.0, 1.0, 1.0), by_formula=False):
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        Definition.__init__(self, mi.BSDFFlags.GlossyReflection | sides, mi.BSDFFlags.GlossyTransmission | sides)
        self.ior, self.tint, self.facets = ior, tint, Facets(alpha)
        self.f0 = ((ior - 1) / (ior + 1)) ** 2 if by_formula else None
        cos = (np.arange(4096) + 0.5) / 4096
        once = fresnel(cos, 1 / ior)
        share = self.f0 + (1 - self.f0) * (1 - cos) ** 5 if by_formula else 2 * once / (1 + once)
        self.through_later = 1 - float((2 * cos * share).mean())

    def mirrored(self, c):
        if self.f0:
            return schlick(self.f0, 1.0, c)
        once = mi.fresnel(c, mi.Float(self.ior))[0]
        return 2 * once / (1 + once)

    def turned(self, si):
        return mi.Vector3f(1, 1, dr.select(si.wi.z > 0, 1.0, -1.0))

    def eval_pdf(self, ctx, si, wo, active=True):
        v, l = si.wi * self.turned(si), wo * self.turned(si)
        through = l.z < 0
        l = mi.Vector3f(l.x, l.y, dr.abs(l.z))
        h = dr.normalize(v + l)
        share, later = self.mirrored(dr.dot(v, h)), self.through_later
        once, part = dr.select(through, 1 - share, share), dr.select(through, later, 1 - later)
        value = once * self.facets.lobe(v, l, h) + part * self.facets.more_lobe(v, l)
        # A tenth by the cosine, alike to both sides.
        pdf = 0.9 * once * self.facets.mirrored_pdf(v, h) + 0.05 * l.z * dr.inv_pi
        active = active & (v.z > 0) & (l.z > 0)
        colour = dr.select(through, mi.Color3f(*self.tint), mi.Color3f(1)) * value
        return dr.select(active, colour, 0), dr.select(active, pdf, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        v = si.wi * self.turned(si)
        h = self.facets.distribution().sample(v, sample2)[0]
        share, by_facet = self.mirrored(dr.dot(v, h)), sample1 < 0.9
        l = dr.select(by_facet, mi.reflect(v, h), mi.warp.square_to_cosine_hemisphere(sample2))
        mirrored = dr.select(by_facet, sample1 < 0.9 * share, sample1 < 0.95)
        above = l.z > 0
        l = dr.select(mirrored, l, mi.Vector3f(l.x, l.y, -l.z))
        return self.sampled(ctx, si, l * self.turned(si), active & above)


class Mixed(Definition):
    """`share` of glass or a pane, the rest of a layered surface, which has the same layers on both sides."""

    def __init__(self, layered, glass, share):
        Definition.__init__(self, *glass.m_components)
        self.layered, self.glass, self.share = layered, glass, share

    def turned(self, si):
        """The same with both sides of the surface exchanged where it is seen from behind, and the factor for `z`."""
        factor = mi.Vector3f(1, 1, dr.select(si.wi.z > 0, 1.0, -1.0))
        turned = mi.SurfaceInteraction3f(si)
        turned.wi = si.wi * factor
        return turned, factor

    def eval_pdf(self, ctx, si, wo, active=True):
        turned, factor = self.turned(si)
        a = self.layered.eval_pdf(ctx, turned, wo * factor, active)
        b = self.glass.eval_pdf(ctx, si, wo, active)
        return tuple((1 - self.share) * x + self.share * y for x, y in zip(a, b))

    def sample(self, ctx, si, sample1, sample2, active=True):
        turned, factor = self.turned(si)
        is_glass = sample1 < self.share
        a = self.layered.sample(ctx, turned, (sample1 - self.share) / (1 - self.share), sample2, active)[0]
        b = self.glass.sample(ctx, si, sample1 / self.share, sample2, active)[0]
        wo = dr.select(is_glass, b.wo, a.wo * factor)
        eta = dr.select(is_glass, b.eta, 1.0)
        return self.sampled(ctx, si, wo, active & (dr.select(is_glass, b.pdf, a.pdf) > 0), eta)
