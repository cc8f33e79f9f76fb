// SPDX-License-Identifier: GPL-3.0-or-later
//! Opaque surfaces of facets over a body as numbers, for light from one fixed direction: what is the same for all other
//! directions is computed once, and the rest is plain arithmetic that compilers turn into lanes.
//! Source: the model of `principled.rs` without coat, sheen and glass; Lambert's reflector is the same without facets.
//! Space: world, unit directions away from the surface. Invariant: values and densities are those of [`Bsdf::eval`] and
//! [`Bsdf::pdf`], up to rounding. Proof: `tests`.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::energy::{Energy, Row, SentBack};
use super::{Bsdf, GRAZING, Lobes, Model};

/// Declares numbers and arrays of numbers of the same names.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident: $kind:tt,)*) => {
        /// A surface seen from one direction.
        #[derive(Clone, Copy, Debug, Default)]
        pub struct Facets {
            $($(#[$doc])* $name: numbers!(@one $kind),)*
            row: Row,
        }

        /// Many of them, lane by lane.
        #[derive(Clone, Debug)]
        pub struct FacetLanes<const N: usize> {
            $($name: numbers!(@many $kind N),)*
            /// The tables that lanes look into, and which one each does.
            tables: Vec<(Row, SentBack)>,
            table_of: [u32; N],
        }

        impl<const N: usize> Default for FacetLanes<N> {
            fn default() -> Self {
                Self { $($name: numbers!(@none $kind N),)* tables: Vec::new(), table_of: [0; N] }
            }
        }

        impl<const N: usize> FacetLanes<N> {
            /// Writes lane `i`.
            pub fn set(&mut self, i: usize, facets: &Facets) {
                $(numbers!(@set $kind, self.$name, facets.$name, i);)*
                self.table_of[i] = 0;
                if facets.over == 0.0 {
                    // Without facets no table counts.
                    return;
                }
                let known = self.tables.iter().position(|(row, _)| *row == facets.row);
                self.table_of[i] = known.unwrap_or_else(|| {
                    self.tables.push((facets.row, facets.sent_back()));
                    self.tables.len() - 1
                }) as u32;
            }

            /// Lane `i`, but for its row of the tables: for [`Facets::eval`] alone.
            #[inline(always)]
            #[must_use]
            pub fn lane(&self, i: usize) -> Facets {
                Facets { $($name: numbers!(@get $kind, self.$name, i),)* row: Row::default() }
            }
        }
    };
    (@one f32) => { f32 };
    (@one vec) => { [f32; 3] };
    (@many f32 $n:ident) => { [f32; $n] };
    (@many vec $n:ident) => { [[f32; $n]; 3] };
    (@none f32 $n:ident) => { [0.0; $n] };
    (@none vec $n:ident) => { [[0.0; $n]; 3] };
    (@set f32, $to:expr, $from:expr, $i:ident) => { $to[$i] = $from };
    (@set vec, $to:expr, $from:expr, $i:ident) => { for k in 0..3 { $to[k][$i] = $from[k]; } };
    (@get f32, $from:expr, $i:ident) => { $from[$i] };
    (@get vec, $from:expr, $i:ident) => { [$from[0][$i], $from[1][$i], $from[2][$i]] };
}

numbers! {
    /// The BSDF's shading normal.
    normal: vec,
    /// The fixed direction, raised to where it sees the front.
    wo: vec,
    /// Square of the facets' width.
    a2: f32,
    /// Smith's auxiliary function of `wo`, plus 1.
    hidden: f32,
    /// One over four cosines of `wo`; 0 without facets.
    over: f32,
    /// Reflectances at normal and grazing incidence.
    f0: vec,
    f90: f32,
    /// What further bounces add, where the facets send back nothing at once; times cos / pi.
    more: vec,
    /// What the body adds, where the facets let everything through; times cos / pi.
    body: vec,
    /// What the facets send back of the light for the body: reflectances and further bounces.
    top0: vec,
    top90: f32,
    top_more: vec,
    /// Chances of the facets and of the cosine.
    by_facets: f32,
    by_cosine: f32,
}

impl Facets {
    /// The surface as it is seen from `wo`; `None` where it is none of facets over a body, or `wo` is all but below the horizon
    /// of its shading normal.
    #[must_use]
    pub fn new(bsdf: &Bsdf, wo: Vec3) -> Option<Self> {
        let cos = bsdf.normal().dot(wo);
        if cos < GRAZING {
            return None;
        }
        let at = Self { normal: bsdf.normal().into(), wo: wo.into(), hidden: 1.0, ..Self::default() };
        match &bsdf.model {
            Model::Lambert { albedo } => Some(Self { a2: 1.0, body: (*albedo).into(), by_cosine: 1.0, ..at }),
            Model::Principled(p) => {
                let is_bare = p.coat == 0.0 && p.sheen == Vec3::ZERO && p.parts()[2] == 0.0;
                if !is_bare || p.lobes != Lobes::ALL {
                    return None;
                }
                let (gloss, energy) = (p.gloss(), Energy::of(p.gloss()));
                let local = bsdf.basis.to_local(wo);
                let (shares, (f0, f90)) = (p.shares(local), p.mixed());
                let (from, lost) = (p.above(cos), 1.0 - energy.white_average());
                let more = if lost < 1e-6 {
                    Vec3::ZERO
                } else {
                    p.more(energy) * ((1.0 - energy.white(cos)) / lost)
                };
                let body = p.body() * (Vec3::ONE - from.sum()) / p.left_on_average();
                Some(Self {
                    a2: gloss.alpha() * gloss.alpha(),
                    hidden: 1.0 / gloss.visible_from(local),
                    over: 0.25 / cos,
                    f0: f0.into(),
                    f90,
                    more: more.into(),
                    body: body.into(),
                    top0: p.f0.into(),
                    top90: p.f90,
                    top_more: energy.more(super::fresnel::schlick_average(p.f0, p.f90)).into(),
                    by_facets: shares.gloss,
                    by_cosine: shares.body,
                    row: energy.row(),
                    ..at
                })
            }
            _ => None,
        }
    }

    /// Cosine of the fixed direction.
    #[must_use]
    pub fn cos(&self) -> f32 {
        dot(self.normal, self.wo)
    }

    /// The shading normal.
    #[must_use]
    pub fn normal(&self) -> [f32; 3] {
        self.normal
    }

    /// What the facets send back at once.
    #[must_use]
    pub fn sent_back(&self) -> SentBack {
        SentBack::of(self.row)
    }

    /// [`Bsdf::eval`] and [`Bsdf::pdf`] for `wi`, whose cosine is `cos` > 0; `sent_back` is what
    /// [`sent_back`](Self::sent_back) tells of it.
    #[inline(always)]
    #[must_use]
    pub fn eval(&self, wi: [f32; 3], cos: f32, sent_back: [f32; 2]) -> ([f32; 3], f32) {
        let (n, wo) = (self.normal, self.wo);
        let sum = [wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]];
        let to_unit = 1.0 / dot(sum, sum).sqrt();
        let h = [sum[0] * to_unit, sum[1] * to_unit, sum[2] * to_unit];
        // Squared sine by the cross product: nothing cancels near the normal.
        let across = [n[1] * h[2] - n[2] * h[1], n[2] * h[0] - n[0] * h[2], n[0] * h[1] - n[1] * h[0]];
        let h_z = dot(n, h);
        let d = h_z * h_z * self.a2 + dot(across, across);
        let density = self.a2 / (PI * d * d) * self.over;
        let tan2 = (1.0 - cos * cos) / (cos * cos);
        let hidden_i = 0.5 * ((1.0 + self.a2 * tan2).sqrt() - 1.0);
        let mirrored = density / (self.hidden + hidden_i);
        let m = 1.0 - dot(wo, h);
        let (rise, white) = (m * m * m * m * m, sent_back[0] + sent_back[1]);
        let (by_cosine, lost) = (cos * FRAC_1_PI, 1.0 - white);
        let channel = |k: usize| {
            let fresnel = self.f0[k] + (self.f90 - self.f0[k]) * rise;
            let top = self.top0[k] * sent_back[0] + self.top90 * sent_back[1] + self.top_more[k] * lost;
            fresnel * mirrored + (self.more[k] * lost + self.body[k] * (1.0 - top)) * by_cosine
        };
        let pdf = self.by_cosine * by_cosine + self.by_facets * density / self.hidden;
        ([channel(0), channel(1), channel(2)], pdf)
    }
}

impl<const N: usize> FacetLanes<N> {
    /// [`Facets::sent_back`] of all lanes, each for its cosine.
    #[inline(always)]
    pub fn sent_back(&self, cos: &[f32; N], out: &mut [[f32; N]; 2]) {
        // Lanes that were not set look into the first table.
        let Some((_, first)) = self.tables.first() else { return };
        if self.tables.len() == 1 {
            for i in 0..N {
                [out[0][i], out[1][i]] = first.at(cos[i]);
            }
            return;
        }
        for i in 0..N {
            let table = self.tables.get(self.table_of[i] as usize).map_or(first, |(_, table)| table);
            [out[0][i], out[1][i]] = table.at(cos[i]);
        }
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::bsdf::Principled;
    use crate::sampling::{cosine_hemisphere, sample_pair, uniform_sphere};

    fn pair(n: u32, purpose: u32) -> [f32; 2] {
        sample_pair(7, SampleKey { pixel: n, sample: 0, branch: 0 }, 0, purpose)
    }

    #[test]
    fn numbers_say_what_the_bsdf_says() {
        let models = [(0.0, 0.3, 1.5), (0.0, 1.0, 1.3), (1.0, 0.5, 1.5), (0.5, 0.15, 1.8), (0.0, 0.05, 1.5)];
        let (mut lanes, mut n) = (FacetLanes::<4>::default(), 0);
        for (metallic, roughness, ior) in models {
            for _ in 0..200 {
                n += 1;
                let normal = uniform_sphere(pair(n, 0));
                let base = Vec3::new(0.9, 0.5, pair(n, 1)[0]);
                let model = match n % 5 {
                    0 => Model::Lambert { albedo: base },
                    _ => Model::Principled(Principled::new(base, metallic, roughness, ior)),
                };
                let bsdf = Bsdf::new(normal, model);
                let basis = crate::sampling::Basis::around(normal);
                let [wo, wi] =
                    [2, 3].map(|purpose| basis.to_world(cosine_hemisphere(pair(n, purpose))).normalize());
                let cos = normal.dot(wi);
                let (Some(facets), true) = (Facets::new(&bsdf, wo), cos > 1e-3) else { continue };
                lanes.set(2, &facets);
                let mut sent_back = [[0.0; 4]; 2];
                lanes.sent_back(&[cos; 4], &mut sent_back);
                let sent_back = [sent_back[0][2], sent_back[1][2]];
                if !matches!(model, Model::Lambert { .. }) {
                    assert_eq!(sent_back, facets.sent_back().at(cos), "the same table");
                }
                let (value, pdf) = lanes.lane(2).eval(wi.into(), cos, sent_back);
                let (wanted, wanted_pdf) = (bsdf.eval(wo, wi), bsdf.pdf(wo, wi));
                let off = (Vec3::from(value) - wanted).length() / wanted.length().max(1e-3);
                let off_pdf = (pdf - wanted_pdf).abs() / wanted_pdf.max(1e-3);
                assert!(off < 2e-3 && off_pdf < 2e-3, "{model:?}: {value:?} {pdf} for {wanted} {wanted_pdf}");
            }
        }
    }

    #[test]
    fn others_are_left_to_the_bsdf() {
        let plastic = Principled::new(Vec3::ONE, 0.0, 0.5, 1.5);
        for principled in [
            Principled { coat: 0.5, coat_alpha: 0.1, ..plastic },
            Principled { sheen: Vec3::ONE, sheen_roughness: 0.5, ..plastic },
            Principled { transmission: 0.5, ..plastic },
        ] {
            let bsdf = Bsdf::new(Vec3::Z, Model::Principled(principled));
            assert!(Facets::new(&bsdf, Vec3::Z).is_none(), "{principled:?}");
        }
        let bsdf = Bsdf::new(Vec3::Z, Model::Principled(plastic));
        assert!(
            Facets::new(&bsdf, Vec3::Z).is_some() && Facets::new(&bsdf, Vec3::X).is_none(),
            "not from below"
        );
    }
}
