// SPDX-License-Identifier: GPL-3.0-or-later
//! Reading textures: transform, wrap, decode, interpolate.
//! Source: references/README point 3 (decode first, then bilinear; texel centres at (i + 0.5) / N; v upwards), glTF 2.0
//! section 3.8 (wrap modes). Units: linear light. A coordinate that is not finite reads as 0.
//! For footprints of more than a texel, smaller copies are read (`mipmap`). Tests:
//! `tests::{centres_are_exact_and_v_points_up, wraps, decodes_before_interpolating}`.

use std::sync::Arc;

use gnurt_image::Texels;

use crate::batch::SurfaceBatch;
use crate::mipmap::{Minify, MipMap};
pub use crate::texels::Wrap;
use crate::texels::{bilinear, nearest};

/// A picture that can be evaluated at any coordinates.
#[derive(Clone, Debug)]
pub struct TextureSampler {
    /// The texels; row 0 lies at v = 1.
    pub texels: Arc<Texels>,
    /// Along u and v.
    pub wrap: [Wrap; 2],
    /// Interpolate between texel centres, or take the nearest one.
    pub linear: bool,
    /// The reader for footprints of more than a texel; `None` = the same.
    pub minify: Option<(Minify, Arc<MipMap>)>,
    /// `uv' = (a u + c v + e, b u + d v + f)` as `[a, b, c, d, e, f]`.
    pub uv_from_mesh: [f32; 6],
    /// The requested attribute with the texture's coordinates, in the order of
    /// [`SurfaceBatch::attributes`]; `None` = the mesh's own. Such textures are read without footprints,
    /// because the change of these coordinates over the surface is unknown.
    pub attribute: Option<usize>,
}

/// Samplers are equal if they read the same texels, in memory, in the same way.
impl PartialEq for TextureSampler {
    fn eq(&self, other: &Self) -> bool {
        let Self { texels, wrap, linear, minify, uv_from_mesh, attribute } = self;
        let same_mips = match (minify, &other.minify) {
            (None, None) => true,
            (Some((how, mips)), Some((other_how, other_mips))) => {
                how == other_how && Arc::ptr_eq(mips, other_mips)
            }
            _ => false,
        };
        let same_direction =
            (wrap, linear, uv_from_mesh) == (&other.wrap, &other.linear, &other.uv_from_mesh);
        let same_direction = same_direction && *attribute == other.attribute;
        Arc::ptr_eq(texels, &other.texels) && same_direction && same_mips
    }
}

impl TextureSampler {
    /// Repeating, bilinear, under the mesh's own coordinates.
    #[must_use]
    pub fn new(texels: Arc<Texels>) -> Self {
        let uv_from_mesh = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        Self { texels, wrap: [Wrap::Repeat; 2], linear: true, minify: None, uv_from_mesh, attribute: None }
    }

    /// Linear red, green, blue and opacity at the mesh's coordinates `uv`.
    #[must_use]
    pub fn sample(&self, [u, v]: [f32; 2]) -> [f32; 4] {
        self.read(self.own([u, v]), self.linear)
    }

    /// The same for a footprint of `width` of the mesh's coordinates in every direction: filtered by
    /// [`minify`](Self::minify) if that is more than a texel.
    #[must_use]
    pub fn sample_wide(&self, uv: [f32; 2], width: f32) -> [f32; 4] {
        let Some((minify, mips)) = &self.minify else { return self.sample(uv) };
        let [a, b, c, d, ..] = self.uv_from_mesh;
        let texels = self.texels.width as f32 * self.texels.height as f32;
        let level = (width * ((a * d - b * c).abs() * texels).sqrt()).log2();
        // A width of 0 gives -infinity, and NaN counts as no filter.
        if level.is_nan() || level <= 0.0 {
            return self.sample(uv);
        }
        mips.sample(self.own(uv), self.wrap, level, *minify)
    }

    /// The mean over a footprint: an ellipse around `uv` whose axes are two changes of the mesh's
    /// coordinates, as diameters.
    #[must_use]
    pub fn sample_over(&self, uv: [f32; 2], axes: [[f32; 2]; 2]) -> [f32; 4] {
        match &self.minify {
            None => self.sample(uv),
            Some((Minify::Ellipse, mips)) => {
                let [a, b, c, d, ..] = self.uv_from_mesh;
                let [width, height] = [self.texels.width, self.texels.height].map(|n| n as f32);
                let own = axes.map(|[u, v]| [(a * u + c * v) * width, (b * u + d * v) * height]);
                mips.over(self.own(uv), own, self.wrap).unwrap_or_else(|| self.sample(uv))
            }
            Some(_) => self.sample_wide(uv, axes.map(|[u, v]| u.hypot(v)).into_iter().fold(0.0, f32::max)),
        }
    }

    /// The mean over the footprint of lane `i` of a batch; an approximation if a broad lobe sent the ray.
    #[must_use]
    pub fn at_hit(&self, hits: &SurfaceBatch, i: usize) -> [f32; 4] {
        let uv = self.uv(hits, i);
        match &self.minify {
            _ if self.attribute.is_some() => self.sample(uv),
            None => self.sample(uv),
            Some((Minify::Ellipse, mips)) if hits.is_vague(i) => {
                let [a, b, c, d, ..] = self.uv_from_mesh;
                let texels = self.texels.width as f32 * self.texels.height as f32;
                let area = hits.texture_area(i) * (a * d - b * c).abs() * texels;
                mips.about(self.own(uv), area, self.wrap).unwrap_or_else(|| self.sample(uv))
            }
            Some((Minify::Ellipse, _)) => self.sample_over(uv, hits.texture_axes(i)),
            Some(_) => self.sample_wide(uv, hits.texture_width(i)),
        }
    }

    /// The coordinates of lane `i` of a batch that the texture reads.
    #[inline]
    #[must_use]
    pub fn uv(&self, hits: &SurfaceBatch, i: usize) -> [f32; 2] {
        let Some(values) = self.attribute.and_then(|k| hits.attributes.get(k)) else { return hits.uv(i) };
        [0, 1].map(|k| values.get(k * hits.len() + i).copied().unwrap_or(0.0))
    }

    /// The texture's own coordinates.
    fn own(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [a, b, c, d, e, f] = self.uv_from_mesh;
        [a * u + c * v + e, b * u + d * v + f]
    }

    fn read(&self, uv: [f32; 2], linear: bool) -> [f32; 4] {
        let read = if linear { bilinear } else { nearest };
        read(&self.texels, uv, self.wrap)
    }

    /// Mean of all texels, as seen from far away.
    #[must_use]
    pub fn mean(&self) -> [f32; 4] {
        let [w, h] = [self.texels.width, self.texels.height].map(|n| n as usize);
        let mut sum = [0.0_f64; 4];
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let texel = self.texels.texel(x, y);
            (0..4).for_each(|k| sum[k] += f64::from(texel[k]));
        }
        sum.map(|s| (s / (w * h) as f64) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_image::TexelData;

    fn picture(width: u32, height: u32, greys: &[f32]) -> TextureSampler {
        let data = TexelData::Float(greys.iter().map(|&g| [g, g, g, 1.0]).collect());
        TextureSampler::new(Arc::new(Texels { width, height, data }))
    }

    fn grey(sampler: &TextureSampler, u: f32, v: f32) -> f32 {
        sampler.sample([u, v])[0]
    }

    #[test]
    fn centres_are_exact_and_v_points_up() {
        let sampler = picture(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(grey(&sampler, 0.25, 0.75), 1.0, "upper left texel");
        assert_eq!(grey(&sampler, 0.75, 0.25), 4.0, "lower right texel");
        assert_eq!(grey(&sampler, 0.5, 0.5), 2.5, "between all four");
        let nearest = TextureSampler { linear: false, ..sampler };
        assert_eq!(grey(&nearest, 0.01, 0.01), 3.0, "lower left texel, all over");
        let moved = TextureSampler { uv_from_mesh: [0.0, 1.0, 1.0, 0.0, 0.0, 0.0], ..nearest };
        assert_eq!(grey(&moved, 0.75, 0.25), 1.0, "u and v exchanged");
    }

    #[test]
    fn wraps() {
        let sampler = picture(2, 1, &[1.0, 3.0]);
        let with = |wrap| TextureSampler { wrap: [wrap; 2], ..sampler.clone() };
        assert_eq!(grey(&with(Wrap::Repeat), 0.0, 0.5), 2.0, "half of each neighbour across the seam");
        assert_eq!(grey(&with(Wrap::Repeat), -7.75, 5.5), 1.0, "any number of periods away");
        assert_eq!(grey(&with(Wrap::Clamp), -3.0, 0.5), 1.0, "the edge goes on");
        assert_eq!(grey(&with(Wrap::Clamp), 9.0, 0.5), 3.0, "on both sides");
        assert_eq!(grey(&with(Wrap::Mirror), 1.25, 0.5), 3.0, "mirrored");
        assert_eq!(grey(&with(Wrap::Mirror), -0.25, 0.5), 1.0, "mirrored below 0");
        assert_eq!(grey(&with(Wrap::Mirror), 0.0, 0.5), 1.0, "no seam at the mirror");
        assert!(grey(&sampler, f32::NAN, f32::INFINITY).is_finite(), "no panic");
    }

    #[test]
    fn wide_points_read_smaller_copies() {
        let sharp = picture(4, 4, &std::array::from_fn::<f32, 16, _>(|i| ((i / 4 + i) % 2) as f32));
        let minify = Minify::Mipmap { linear: true, interpolate_levels: true };
        let mips = Arc::new(MipMap::new(sharp.texels.clone()));
        let wide = TextureSampler { minify: Some((minify, mips)), ..sharp.clone() };
        let at = |sampler: &TextureSampler, width| sampler.sample_wide([0.125, 0.125], width)[0];
        assert_eq!(at(&sharp, 0.9), 1.0, "no copies, as ever");
        assert_eq!(
            [0.0, 0.2, 0.25].map(|width| at(&wide, width)),
            [1.0; 3],
            "up to a texel the picture itself"
        );
        assert_eq!(at(&wide, 0.5), 0.5, "two texels wide: their mean");
        let halfway = at(&wide, 0.25 * 2.0_f32.sqrt());
        assert!((halfway - 0.75).abs() < 1e-5, "half-way between: {halfway}");
        assert_eq!([9.0, f32::INFINITY].map(|width| at(&wide, width)), [0.5; 2], "all of it");
        assert_eq!(at(&wide, f32::NAN), 1.0, "no number");
        let scaled = TextureSampler { uv_from_mesh: [4.0, 0.0, 0.0, 4.0, 0.0, 0.0], ..wide };
        assert_eq!(scaled.sample_wide([0.031_25; 2], 0.125)[0], 0.5, "the texture's own scale counts");
    }

    #[test]
    fn decodes_before_interpolating() {
        let data = TexelData::Srgb8(vec![[0, 0, 0, 0], [255, 255, 255, 255]]);
        let sampler = TextureSampler::new(Arc::new(Texels { width: 2, height: 1, data }));
        let [r, _, _, a] = sampler.sample([0.5, 0.5]);
        assert_eq!((r, a), (0.5, 0.5), "half of white's light, not of its byte");
        assert!((sampler.mean()[0] - 0.5).abs() < 1e-6, "the mean is of light too");
        let mid = TexelData::Srgb8(vec![[188, 188, 188, 255]]);
        let sampler = TextureSampler::new(Arc::new(Texels { width: 1, height: 1, data: mid }));
        assert!((sampler.sample([0.0, 0.0])[0] - 0.502_886).abs() < 1e-5, "the piecewise curve");
    }
}
