// SPDX-License-Identifier: GPL-3.0-or-later
//! Brushed surfaces: GGX microfacets whose slopes have one width along a direction and another across it.
//! Includes the albedo of single scattering, by cosine and azimuth of the view.
//! Source: \[Hei14\] sections 5.2 and 5.3 (GGX stretched along two axes, and its shadowing); [KC17] for the
//! use of the tables. Isotropic microfacets stay `Ggx`, with the same bits. Tables are indexed by the roots
//! of both widths; nodes are computed at first use, because a scene has few brushed surfaces.
//! Space: world; directions are unit. Tests: `tests`, `tests` of `bsdf`.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::dielectric::refract;
use super::energy::{Energy, average, cell};
use super::fresnel::{dielectric, schlick_rise};
use super::ggx::Ggx;
use crate::real::{Real, Vector};

/// The axes of slopes, and the points that have such.
#[derive(Clone, Copy)]
pub(super) struct AnisotropyFrame<R: Real> {
    /// Unit, perpendicular to each other and to the normal.
    pub(super) tangent: Vector<R>,
    pub(super) bitangent: Vector<R>,
    /// Width of the slopes along the second.
    pub(super) across: R,
    pub(super) is: R::Mask,
}

/// Microfacets, anisotropic or not.
#[derive(Clone, Copy)]
pub(super) struct Slopes<R: Real> {
    pub(super) ggx: Ggx<R>,
    pub(super) anisotropy: Option<AnisotropyFrame<R>>,
}

impl<R: Real> AnisotropyFrame<R> {
    /// Squares of the components of `w` along both axes.
    #[inline(always)]
    fn squares(&self, w: Vector<R>) -> [R; 2] {
        let (x, y) = (self.tangent.dot(w), self.bitangent.dot(w));
        [x * x, y * y]
    }

    /// The square of the cosine of the azimuth of `w`; one half where it has none.
    #[inline(always)]
    fn azimuth(&self, w: Vector<R>) -> R {
        let [x2, y2] = self.squares(w);
        let both = x2 + y2;
        R::pick(both.above_all(1e-12), x2 / both, both.all(0.5))
    }
}

impl<R: Real> Slopes<R> {
    /// Those of one point.
    pub(super) fn point(&self, i: usize) -> Slopes<f32> {
        let anisotropy = self.anisotropy.map(|anisotropy| AnisotropyFrame {
            tangent: anisotropy.tangent.get(i).into(),
            bitangent: anisotropy.bitangent.get(i).into(),
            across: anisotropy.across.lane(i),
            is: R::bits(anisotropy.is) >> i & 1 != 0,
        });
        Slopes { ggx: Ggx::from_alpha(self.ggx.alpha().lane(i)), anisotropy }
    }

    /// Density of microfacets facing `h` per solid angle and ground area, around the normal `n`.
    #[inline(always)]
    pub(super) fn density(&self, n: Vector<R>, h: Vector<R>) -> R {
        let (cos, sin2) = (n.dot(h), n.cross(h).length_squared());
        let plain = self.ggx.density(cos, sin2);
        let Some(anisotropy) = &self.anisotropy else { return plain };
        let (along, [x2, y2]) = (self.ggx.alpha(), anisotropy.squares(h));
        let d = x2 / (along * along) + y2 / (anisotropy.across * anisotropy.across) + cos * cos;
        let stretched = cos.all(1.0) / (along * anisotropy.across * d * d * PI);
        let stretched = R::pick(cos.above_all(0.0), stretched, cos.all(0.0));
        R::pick(anisotropy.is, stretched, plain)
    }

    /// Smith's auxiliary function of `w` at the cosine `cos`, of either sign.
    #[inline(always)]
    pub(super) fn lambda(&self, w: Vector<R>, cos: R) -> R {
        let plain = self.ggx.lambda(cos);
        let Some(anisotropy) = &self.anisotropy else { return plain };
        let (along, [x2, y2]) = (self.ggx.alpha(), anisotropy.squares(w));
        let wide = (x2 * along * along + y2 * anisotropy.across * anisotropy.across) / (cos * cos);
        R::pick(anisotropy.is, ((wide + cos.all(1.0)).root() - cos.all(1.0)) * 0.5, plain)
    }

    /// See [`Energy::of`].
    #[inline(always)]
    pub(super) fn energy(&self) -> Energy<R> {
        let plain = Energy::of(self.ggx);
        let Some(anisotropy) = &self.anisotropy else { return plain };
        let along = self.ggx.alpha();
        let [a, b] = along.outline(
            #[inline(always)]
            || {
                along.each_of(
                    #[inline(always)]
                    |i| mean_of_microfacets(along.lane(i), anisotropy.across.lane(i)),
                )
            },
        );
        let [plain_a, plain_b] = plain.average;
        Energy { average: [R::pick(anisotropy.is, a, plain_a), R::pick(anisotropy.is, b, plain_b)], ..plain }
    }

    /// Mean scattering of microfacets that are alike in all directions, of the geometric mean of both widths.
    #[inline(always)]
    pub(super) fn even(&self) -> Energy<R> {
        let Some(anisotropy) = &self.anisotropy else { return Energy::of(self.ggx) };
        let along = self.ggx.alpha();
        let width = R::pick(anisotropy.is, (along * anisotropy.across).root(), along);
        Energy::of(Ggx::from_alpha(width))
    }

    /// See [`Energy::split`]: of light from the direction `w` at the cosine `cos` > 0, or from all around at that cosine.
    #[inline(always)]
    pub(super) fn split(&self, w: Option<Vector<R>>, cos: R) -> [R; 2] {
        let plain = Energy::of(self.ggx).split(cos);
        let Some(anisotropy) = &self.anisotropy else { return plain };
        let (along, azimuth) = (self.ggx.alpha(), w.map_or(cos.all(0.5), |w| anisotropy.azimuth(w)));
        let [a, b] = cos.outline(
            #[inline(always)]
            || {
                cos.each_of(
                    #[inline(always)]
                    |i| {
                        split_of_microfacets(
                            [along.lane(i), anisotropy.across.lane(i)],
                            cos.lane(i),
                            azimuth.lane(i),
                        )
                    },
                )
            },
        );
        [R::pick(anisotropy.is, a, plain[0]), R::pick(anisotropy.is, b, plain[1])]
    }

    /// Share of light transmitted and reflected by anisotropic microfacets of glass after single scattering;
    /// `eta` is the index here over that beyond.
    #[inline(always)]
    pub(super) fn retained_by_glass(&self, w: Vector<R>, cos: R, eta: R, plain: R) -> R {
        let Some(anisotropy) = &self.anisotropy else { return plain };
        let (along, azimuth) = (self.ggx.alpha(), anisotropy.azimuth(w));
        let retained = cos.each(
            #[inline(always)]
            |i| {
                retained_by_glass(
                    [along.lane(i), anisotropy.across.lane(i)],
                    eta.lane(i),
                    cos.lane(i),
                    azimuth.lane(i),
                )
            },
        );
        R::pick(anisotropy.is, retained, plain)
    }

    /// See [`Ggx::sample_visible`]: in a frame whose first axis is that of the slopes.
    #[inline(always)]
    pub(super) fn sample_visible(&self, wo: Vector<R>, u: [R; 2]) -> Vector<R> {
        let along = self.ggx.alpha();
        let across =
            self.anisotropy.map_or(along, |anisotropy| R::pick(anisotropy.is, anisotropy.across, along));
        self.ggx.sample_visible_across(across, wo, u)
    }
}

/// Steps of the cosine and of the azimuth's squared cosine, of the root of a width, and of the index.
const COSINES: usize = 24;
const AZIMUTHS: usize = 7;
const WIDTHS: usize = 16;
const INDICES: usize = 33;

/// Albedo of single scattering: by azimuth and cosine, and on average over a cosine-weighted hemisphere.
struct Node {
    retained: [[Vec2; COSINES]; AZIMUTHS],
    average: Vec2,
}

type Cell = OnceLock<Box<Node>>;

impl Node {
    fn new(one_bounce: impl Fn(Vec3) -> Vec2) -> Box<Self> {
        let retained: [[Vec2; COSINES]; AZIMUTHS] = std::array::from_fn(|a| {
            let cos_azimuth = (a as f32 / (AZIMUTHS - 1) as f32).sqrt();
            let sin_azimuth = (1.0 - cos_azimuth * cos_azimuth).sqrt();
            std::array::from_fn(|c| {
                let cos = (c as f32 / (COSINES - 1) as f32).max(1e-3);
                let sin = (1.0 - cos * cos).sqrt();
                one_bounce(Vec3::new(sin * cos_azimuth, sin * sin_azimuth, cos))
            })
        });
        // Over a quarter of the circle.
        const PARTS: usize = 32;
        let part = |k: usize| {
            let (row, beyond) = cell((FRAC_PI_2 * (k as f32 + 0.5) / PARTS as f32).cos().powi(2), AZIMUTHS);
            let [a, b] = [row, row + 1].map(|row| average(&retained[row]));
            (a + (b - a) * beyond) / PARTS as f32
        };
        let average = (0..PARTS).map(part).sum();
        Box::new(Self { retained, average })
    }

    fn at(&self, cos: f32, azimuth: f32) -> Vec2 {
        let (row, t) = cell(azimuth, AZIMUTHS);
        let (column, s) = cell(cos, COSINES);
        let of = |row: &[Vec2; COSINES]| row[column] + (row[column + 1] - row[column]) * s;
        let [a, b] = [of(&self.retained[row]), of(&self.retained[row + 1])];
        a + (b - a) * t
    }
}

/// The four nodes around two widths, mixed: `of(along, across)` gives a node's number, that of the first axis being the wider one's, and
/// whether the axes are exchanged.
fn mix(widths: [f32; 2], of: impl Fn([usize; 2], bool) -> Vec2) -> Vec2 {
    let [(i, s), (j, t)] = widths.map(|alpha| cell(alpha.max(0.0).sqrt(), WIDTHS));
    let node = |i: usize, j: usize| if i >= j { of([i, j], false) } else { of([j, i], true) };
    let [a, b] = [i, i + 1].map(|i| {
        let [a, b] = [node(i, j), node(i, j + 1)];
        a + (b - a) * t
    });
    a + (b - a) * s
}

/// Mean of `f` over the visible microfacets, for all azimuths.
fn mean_visible([along, across]: [f32; 2], wo: Vec3, f: impl Fn(Vec3) -> Vec2) -> Vec2 {
    Ggx::from_alpha(along).mean_visible_across(across, (1.0, [24, 24]), wo, f)
}

/// Widths of a node.
fn widths([i, j]: [usize; 2]) -> [f32; 2] {
    [i, j].map(|k| Ggx::new(k as f32 / (WIDTHS - 1) as f32).alpha())
}

/// Smith's auxiliary function of a direction in the frame of the slopes.
fn lambda([along, across]: [f32; 2], w: Vec3) -> f32 {
    let wide = ((along * w.x).powi(2) + (across * w.y).powi(2)) / (w.z * w.z);
    ((1.0 + wide).sqrt() - 1.0) * 0.5
}

/// The unshadowed share of the light that a visible microfacet sends to `wi`.
fn unhidden(widths: [f32; 2], wo: Vec3, wi: Vec3) -> f32 {
    let hidden = lambda(widths, wo);
    (1.0 + hidden) / (1.0 + hidden + lambda(widths, wi))
}

fn microfacets(node: [usize; 2]) -> &'static Node {
    static NODES: [[Cell; WIDTHS]; WIDTHS] = [const { [const { OnceLock::new() }; WIDTHS] }; WIDTHS];
    NODES[node[0]][node[1]].get_or_init(|| {
        let widths = widths(node);
        Node::new(|wo| {
            mean_visible(widths, wo, |h| {
                let wi = (-wo).reflect(h);
                let weight = if wi.z > 0.0 { unhidden(widths, wo, wi) } else { 0.0 };
                let rise = schlick_rise(wo.dot(h));
                Vec2::new(weight * (1.0 - rise), weight * rise)
            })
        })
    })
}

fn split_of_microfacets(widths: [f32; 2], cos: f32, azimuth: f32) -> [f32; 2] {
    let of = |node, turned: bool| microfacets(node).at(cos, if turned { 1.0 - azimuth } else { azimuth });
    mix(widths, of).into()
}

fn mean_of_microfacets(along: f32, across: f32) -> [f32; 2] {
    if across <= 0.0 {
        return [0.0; 2];
    }
    mix([along, across], |node, _| microfacets(node).average).into()
}

/// Nodes for an index, by the number of its step.
fn glass(node: [usize; 2], index: usize) -> &'static Node {
    static NODES: [[[Cell; WIDTHS]; WIDTHS]; INDICES] =
        [const { [const { [const { OnceLock::new() }; WIDTHS] }; WIDTHS] }; INDICES];
    NODES[index][node[0]][node[1]].get_or_init(|| {
        let s = index as f32 / (INDICES - 1) as f32 - 0.5;
        let (widths, eta) = (widths(node), (1.0 + s) / (1.0 - s));
        Node::new(|wo| {
            mean_visible(widths, wo, |h| {
                let share = dielectric(wo.dot(h), eta);
                let mirrored = (-wo).reflect(h);
                let mirrored = if mirrored.z > 0.0 { share * unhidden(widths, wo, mirrored) } else { 0.0 };
                let (through, some) = refract(wo.into(), h.into(), eta);
                let through = Vec3::from(through);
                let through =
                    if some && through.z < 0.0 { (1.0 - share) * unhidden(widths, wo, through) } else { 0.0 };
                Vec2::new(mirrored + through, 0.0)
            })
            .min(Vec2::ONE)
        })
    })
}

fn by_index(eta: f32, of: impl Fn(usize) -> Vec2) -> f32 {
    let (index, beyond) = cell((eta - 1.0) / (eta + 1.0) + 0.5, INDICES);
    let [a, b] = [of(index), of(index + 1)];
    (a + (b - a) * beyond).x
}

fn retained_by_glass(widths: [f32; 2], eta: f32, cos: f32, azimuth: f32) -> f32 {
    if widths[1] <= 0.0 {
        return 0.0;
    }
    by_index(eta, |index| {
        mix(widths, |node, turned| glass(node, index).at(cos, if turned { 1.0 - azimuth } else { azimuth }))
    })
}

/// The same averaged over a cosine-weighted hemisphere.
pub(super) fn mean_retained_by_glass(widths: [f32; 2], eta: f32) -> f32 {
    by_index(eta, |index| mix(widths, |node, _| glass(node, index).average))
}

/// Albedo of single scattering of a metal or plastic, averaged over a cosine-weighted hemisphere.
pub(super) fn mean_retained(widths: [f32; 2]) -> f32 {
    mean_of_microfacets(widths[0], widths[1]).iter().sum()
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use super::*;

    fn unit(cos: f32, azimuth: f32) -> Vec3 {
        let sin = (1.0 - cos * cos).sqrt();
        Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
    }

    fn slopes([along, across]: [f32; 2]) -> Slopes<f32> {
        let anisotropy =
            AnisotropyFrame { tangent: Vec3::X.into(), bitangent: Vec3::Y.into(), across, is: true };
        Slopes { ggx: Ggx::from_alpha(along), anisotropy: Some(anisotropy) }
    }

    #[test]
    fn tables_hold_the_lobe() {
        for (widths, cos, azimuth) in [
            ([0.9, 0.2], 0.6, 0.3),
            ([0.15, 0.6], 0.3, 0.2),
            ([0.5, 0.45], 0.9, 1.2),
            ([1.0, 0.3], 0.15, 1.5),
        ] {
            let (slopes, wo) = (slopes(widths), unit(cos, azimuth));
            // Midpoint rule over the hemisphere, independent of the sampling for the table.
            let (rings, sectors) = (800, 400);
            let mut sum = 0.0_f64;
            for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                let wi =
                    unit((ring as f32 + 0.5) / rings as f32, TAU * (sector as f32 + 0.5) / sectors as f32);
                let h = (wo + wi).normalize();
                let hidden = slopes.lambda(wo.into(), wo.z) + slopes.lambda(wi.into(), wi.z);
                let lobe = slopes.density(Vec3::Z.into(), h.into()) / ((1.0 + hidden) * 4.0 * cos);
                sum += f64::from(lobe * (0.1 + 0.9 * schlick_rise(wo.dot(h))));
            }
            let expected = sum * f64::from(TAU) / f64::from(rings * sectors);
            let [normal, grazing] = slopes.split(Some(wo.into()), cos);
            let found = 0.1 * normal + grazing;
            assert!((f64::from(found) - expected).abs() < 5e-3, "{widths:?} {cos}: {found}, not {expected}");
        }
    }

    /// Slopes of equal widths equal isotropic ones.
    #[test]
    fn even_slopes_are_plain_ones() {
        for alpha in [0.05, 0.3, 0.8] {
            let (brushed, plain) = (slopes([alpha; 2]), Slopes { anisotropy: None, ..slopes([alpha; 2]) });
            for w in [unit(0.2, 0.4), unit(0.7, 2.0), unit(0.99, 5.0)] {
                let near = |a: f32, b: f32, off: f32| (a - b).abs() <= off * b.abs() + 1e-6;
                assert!(near(brushed.lambda(w.into(), w.z), plain.lambda(w.into(), w.z), 1e-4), "shadowing");
                let [a, b] = [brushed, plain].map(|s| s.density(Vec3::Z.into(), w.into()));
                assert!(near(a, b, 1e-3), "density {a} {b}");
                let [a, b] = [brushed, plain].map(|s| s.split(Some(w.into()), w.z));
                assert!((a[0] + a[1] - b[0] - b[1]).abs() < 0.012, "{alpha} {w}: kept {a:?} {b:?}");
            }
        }
    }
}
