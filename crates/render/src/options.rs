// SPDX-License-Identifier: GPL-3.0-or-later
//! Options of a picture: size, samples, integrator, filter. Pixels count from the upper left corner; names
//! are the command line's words.
//! Tests: `tests::names_round_trip`, `tests::crops_are_clipped`.

use std::time::Duration;

pub use gnurt_image::FilterShape as ReconstructionFilter;
use gnurt_simd::Level;

use crate::by_name::by_name;
use crate::error::RenderError;
use crate::expressions::{self, LightLayer};
use crate::mattes::Mattes;
use crate::piece::{BAND_UNIT, Piece};
use crate::pixel_noise::PixelNoise;

/// How radiance is computed along a camera ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Base colours, lit from the eye: shows geometry without lights.
    Eyelight,
    /// Shading normals as colours.
    Normals,
    /// Direct light with shadows, mirrors and glass by recursion \[Whi80\].
    #[default]
    Whitted,
    /// Virtual lights at the vertices of light paths \[Kel97\]; converges to the result of path tracing.
    InstantRadiosity,
    /// The same with virtual lights on paths from both sides, the most important of them \[SIMP06\].
    BidirectionalInstantRadiosity,
    /// The same with virtual lights from Markov chains over paths from lights to the camera \[SIP07\].
    MetropolisInstantRadiosity,
    /// All light, by scattered rays: the reference \[Kaj86\].
    Path,
    /// `Path` or `BidirectionalInstantRadiosity` with 32 to 1024 virtual lights, whichever has the smaller variance for its cost in a pilot
    /// rendering. The number of virtual lights and patterns are ignored; paths are guided where the pilot of the guide finds that it
    /// pays. `Path` without a pilot where virtual lights leave something out: media, links of lights, open shutters, noise targets, layers
    /// by events.
    Auto,
}

impl Integrator {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Eyelight,
        Self::Normals,
        Self::Whitted,
        Self::Path,
        Self::InstantRadiosity,
        Self::BidirectionalInstantRadiosity,
        Self::MetropolisInstantRadiosity,
        Self::Auto,
    ];

    /// Whether it can add this layer: paths have all of them, virtual lights those that need no events of paths.
    #[must_use]
    pub fn has_light_layer(self, layer: &LightLayer) -> bool {
        self.without_pilot() == Self::Path || (self.has_virtual_lights() && !layer.needs_events())
    }

    /// The integrator where no pilot is rendered: in motion, and along single rays.
    #[must_use]
    pub fn without_pilot(self) -> Self {
        if self == Self::Auto { Self::Path } else { self }
    }

    /// Whether samples are taken with virtual lights, a fresh set for each.
    #[must_use]
    pub fn has_virtual_lights(self) -> bool {
        matches!(
            self,
            Self::InstantRadiosity | Self::BidirectionalInstantRadiosity | Self::MetropolisInstantRadiosity
        )
    }

    /// Whether it chooses lights by their contribution.
    pub(crate) fn needs_light_set(self) -> bool {
        self.without_pilot() == Self::Path || self.has_virtual_lights()
    }

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Eyelight => "eyelight",
            Self::Normals => "normals",
            Self::Whitted => "whitted",
            Self::InstantRadiosity => "ir",
            Self::BidirectionalInstantRadiosity => "bir",
            Self::MetropolisInstantRadiosity => "mir",
            Self::Path => "path",
            Self::Auto => "auto",
        }
    }
}

by_name!(Integrator, UnknownIntegrator, "integrator");

/// Whether paths are guided to where light was found by a pilot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Guiding {
    /// Directions are chosen by lobes alone.
    #[default]
    Off,
    /// All samples are guided.
    On,
    /// Samples from [`RenderOptions::guided_from`] on are guided, if the pilot finds that it pays.
    Auto,
}

impl Guiding {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::On, Self::Auto];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::On => "on",
            Self::Auto => "auto",
        }
    }
}

by_name!(Guiding, UnknownGuiding, "choice");

/// Whether lamps behind smooth surfaces are searched for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Caustics {
    /// Scattered rays meet them by chance.
    #[default]
    Off,
    /// All lamps are; environments and lights of plugins have no point to search for.
    On,
    /// Lamps without extent are, and lamps that are small as seen from smooth surfaces.
    Auto,
}

impl Caustics {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::On, Self::Auto];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::On => "on",
            Self::Auto => "auto",
        }
    }
}

by_name!(Caustics, UnknownCaustics, "choice");

/// Everything about a picture but the world and the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Samples per pixel, at least 1.
    pub spp: u32,
    /// The same seed gives the same picture, bit for bit, on any number of threads.
    pub seed: u64,
    /// A separate seed for virtual lights: pictures that differ in `seed` alone then share their virtual
    /// lights, and the common part of their errors comes from these. `None` = `seed`.
    pub lights_seed: Option<u64>,
    /// How radiance is computed.
    pub integrator: Integrator,
    /// How samples make a pixel.
    pub filter: ReconstructionFilter,
    /// How the errors of neighbouring pixels relate.
    pub pixel_noise: PixelNoise,
    /// Take all samples at the pixels' centres, not where the filter puts them: exact, but jagged edges.
    pub pixel_centres: bool,
    /// `[x0, y0, x1, y1]` in pixels, upper left origin, `x1` and `y1` exclusive; the picture keeps its size and is
    /// black with alpha 0 outside.
    pub crop: Option<[u32; 4]>,
    /// How deep light is followed. `Whitted`: how many bounces a ray may have behind it; deeper ones see the
    /// environment. `Path`: how many edges a path may have, as Mitsuba counts: 1 = emission seen directly, 2 = direct light.
    pub max_depth: u32,
    /// Virtual lights of a pass, about; for the integrators that have them.
    pub vpls: u32,
    /// `InstantRadiosity`: the largest geometry term, one over area, that virtual lights bring light over; rays bring the
    /// rest. `None` = from the scene's size and the number of virtual lights. `Path`: each contribution of
    /// light that was scattered more than once (one light sample, or one light or sky hit by a path) counts
    /// no more than this in any channel: less noise, but the picture becomes too dark. A sample may add up
    /// several. `None` = unbiased.
    pub clamp: Option<f32>,
    /// `Path`: whether directions are learned from a pilot rendering of the whole picture.
    pub guiding: Guiding,
    /// `Path` and the integrators with virtual lights: whether light that mirrors and smooth glass bring from lamps to rough
    /// surfaces is searched for. [`Integrator::Auto`] searches as by [`Caustics::Auto`] where this is off.
    pub caustics: Caustics,
    /// For the integrators with virtual lights: the radiance of a white diffuse surface under light 1, if its
    /// shader only has `shade`. 1 in the light model of OpenRT (light times colour times cosine), 1 / pi in
    /// radiometry.
    pub white: f32,
    /// For the integrators with virtual lights: each pixel of a square pattern of this width gathers its
    /// subset of the virtual lights, then light is averaged over a pattern's pixels of a surface \[WKB*02\].
    /// Much faster, slightly blurred: **biased**. 1 = every pixel gathers from all; 3, 5 and 7 are patterns
    /// with a middle, others count as the next of these.
    pub interleave: u32,
    /// World units that origins move off a surface on top of the computed error bound.
    pub ray_epsilon: f32,
    /// CPU level of the kernels.
    pub level: Level,
    /// Time limit of the rendering; the picture so far is kept.
    pub time_limit: Option<Duration>,
    /// Tiles get as many samples as bring their noise below this share of their radiance: at least 16, at most `spp`.
    /// Not for integrators with virtual lights, whose pixels share their noise. `None` = `spp` samples everywhere.
    pub noise: Option<f32>,
    /// Add layers: albedo, variance, normal, position, depth, ids.
    pub aovs: bool,
    /// With `aovs`: add layers of what mirrors and smooth glass show, for denoisers.
    pub seen: bool,
    /// Add layers of light; those that the integrator has ([`Integrator::has_light_layer`]).
    pub light_layers: Vec<LightLayer>,
    /// Add Cryptomatte's layers.
    pub mattes: Mattes,
    /// Make a picture of the cost per pixel.
    pub heatmap: bool,
    /// Render only the tiles of this piece. Not for interleaved pixels, which read their neighbours. `None` =
    /// all.
    pub piece: Option<Piece>,
    /// Render only these rows of the frame, from the first to the one before the second; the picture has no others. The
    /// first is a multiple of [`BAND_UNIT`], and so is the second unless it is the height. Their pixels are those of the
    /// whole picture. Not with `piece`, nor for interleaved pixels. `None` = all.
    pub rows: Option<[u32; 2]>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 1024,
            height: 768,
            spp: 16,
            seed: 0,
            lights_seed: None,
            integrator: Integrator::default(),
            filter: ReconstructionFilter::Box,
            pixel_noise: PixelNoise::White,
            pixel_centres: false,
            crop: None,
            max_depth: 16,
            vpls: 1024,
            clamp: None,
            guiding: Guiding::default(),
            caustics: Caustics::default(),
            white: 1.0,
            interleave: 1,
            ray_epsilon: 0.0,
            level: Level::default(),
            time_limit: None,
            noise: None,
            aovs: false,
            seen: false,
            light_layers: Vec::new(),
            mattes: Mattes::default(),
            heatmap: false,
            piece: None,
            rows: None,
        }
    }
}

impl RenderOptions {
    /// Width of the pattern of interleaved pixels, if there is one.
    pub(crate) fn pattern(&self) -> Option<u32> {
        let n = self.interleave.min(WIDEST) | 1;
        (n > 1 && self.integrator.has_virtual_lights()).then_some(n)
    }

    /// The first sample of each pixel that a guide is asked for, if any is: by `auto` the 17th, and of small pictures that
    /// from which on they have cost as much as the pilot. It depends on the picture's size, not on `spp`.
    #[must_use]
    pub fn guided_from(&self) -> Option<u32> {
        match (self.integrator, self.guiding) {
            (Integrator::Path, Guiding::On) => Some(0),
            (Integrator::Path, Guiding::Auto) => Some(self.pilot().samples.max(AUTO_FROM)),
            _ => None,
        }
    }

    /// The size of pilots, and the samples of a guide's: an eighth of the pixels, within limits, and as many samples as make enough paths.
    pub(crate) fn pilot(&self) -> Pilot {
        let pixels = f64::from(self.width) * f64::from(self.height);
        let scale = ((pixels / 8.0).clamp(PILOT_PIXELS[0], PILOT_PIXELS[1]) / pixels).sqrt().min(1.0);
        let [width, height] =
            [self.width, self.height].map(|size| ((f64::from(size) * scale).round() as u32).max(1));
        let wanted = PILOT_PATHS / (f64::from(width) * f64::from(height));
        let samples = (wanted.min(f64::from(MOST_PILOT_SAMPLES)) as u32).max(1).next_power_of_two();
        Pilot { width, height, samples: samples.clamp(LEAST_PILOT_SAMPLES, MOST_PILOT_SAMPLES) }
    }

    /// Options of a pilot of the whole picture: smaller, of nothing but light, and under a seed that differs in these bits.
    pub(crate) fn of_pilot(&self, bits: u64) -> Self {
        let Pilot { width, height, samples } = self.pilot();
        Self {
            width,
            height,
            seed: self.seed ^ bits,
            crop: None,
            piece: None,
            rows: None,
            noise: None,
            time_limit: None,
            aovs: false,
            seen: false,
            heatmap: false,
            pixel_centres: false,
            light_layers: Vec::new(),
            mattes: Mattes::default(),
            spp: samples,
            ..self.clone()
        }
    }

    /// The seed of virtual lights.
    pub(crate) fn seed_of_lights(&self) -> u64 {
        self.lights_seed.unwrap_or(self.seed)
    }

    /// The crop clipped to the frame, or the whole frame; an error if nothing is left or a size is 0.
    pub fn region(&self) -> Result<[u32; 4], RenderError> {
        if self.width == 0 || self.height == 0 || self.spp == 0 {
            return Err(RenderError::NothingToDo { width: self.width, height: self.height, spp: self.spp });
        }
        if u64::from(self.width) * u64::from(self.height) > MAX_PIXELS {
            return Err(RenderError::TooLarge { width: self.width, height: self.height });
        }
        let [x0, y0, x1, y1] = self.crop.unwrap_or([0, 0, self.width, self.height]);
        let clipped = [x0, y0, x1.min(self.width), y1.min(self.height)];
        if clipped[0] >= clipped[2] || clipped[1] >= clipped[3] {
            return Err(RenderError::EmptyCrop { crop: [x0, y0, x1, y1] });
        }
        if !self.light_layers.is_empty() {
            if !self.light_layers.iter().all(|layer| self.integrator.has_light_layer(layer)) {
                return Err(RenderError::LayersOfLight { integrator: self.integrator.name() });
            }
            if self.pattern().is_some() {
                return Err(RenderError::InterleavedLayers);
            }
            expressions::check(&self.light_layers).map_err(RenderError::Expression)?;
        }
        if let Some(piece) = self.piece {
            if piece.index >= piece.count {
                return Err(RenderError::NoSuchPiece { piece });
            }
            if self.pattern().is_some() {
                return Err(RenderError::InterleavedPiece);
            }
        }
        if let Some(rows) = self.rows {
            let [top, end] = rows;
            let is_aligned = top % BAND_UNIT == 0 && (end % BAND_UNIT == 0 || end == self.height);
            if top >= end
                || end > self.height
                || !is_aligned
                || self.piece.is_some()
                || self.pattern().is_some()
            {
                return Err(RenderError::NoSuchRows { rows, height: self.height });
            }
        }
        Ok(clipped)
    }
}

/// Size of a pilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pilot {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Per pixel, a power of two.
    pub(crate) samples: u32,
}

/// With [`Guiding::Auto`], pictures of no more samples per pixel make no pilot.
const AUTO_FROM: u32 = 16;
/// Pixels of a pilot, if the picture has as many.
const PILOT_PIXELS: [f64; 2] = [20_000.0, 80_000.0];
/// Paths of a pilot, about, if its samples are within limits.
const PILOT_PATHS: f64 = 120_000.0;
const LEAST_PILOT_SAMPLES: u32 = 8;
const MOST_PILOT_SAMPLES: u32 = 64;

/// No pattern is wider: its tiles would be few.
const WIDEST: u32 = 7;

/// No picture is larger: 2^31 pixels, so that a pixel has a 32-bit number.
const MAX_PIXELS: u64 = 1 << 31;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for integrator in Integrator::ALL {
            assert_eq!(integrator.to_string().parse(), Ok(integrator), "{integrator} comes back");
        }
        for noise in PixelNoise::ALL {
            assert_eq!(noise.to_string().parse(), Ok(noise), "{noise} comes back");
        }
        let error = "witted".parse::<Integrator>().expect_err("no such integrator");
        assert_eq!(
            error.to_string(),
            "unknown integrator 'witted': expected eyelight, normals, whitted, path, ir, bir, mir, auto",
            "the message says what there is"
        );
    }

    #[test]
    fn pilots_are_small() {
        let with = |width, height| {
            let options = RenderOptions {
                integrator: Integrator::Path,
                guiding: Guiding::Auto,
                width,
                height,
                ..Default::default()
            };
            let Pilot { width, height, samples } = options.pilot();
            ([width, height, samples], options.guided_from())
        };
        assert_eq!(with(160, 120), ([160, 120, 8], Some(16)), "all pixels of a small one");
        assert_eq!(with(70, 45), ([70, 45, 64], Some(64)), "more samples of a tiny one");
        assert_eq!(with(1, 1), ([1, 1, 64], Some(64)), "but no more than these");
        assert_eq!(with(4000, 2000), ([400, 200, 8], Some(16)), "a hundredth of a large one");
    }

    #[test]
    fn crops_are_clipped() {
        let with = |crop| RenderOptions { width: 10, height: 8, crop, ..Default::default() }.region();
        assert_eq!(with(None), Ok([0, 0, 10, 8]), "no crop is all");
        assert_eq!(with(Some([2, 3, 99, 99])), Ok([2, 3, 10, 8]), "clipped");
        assert!(with(Some([10, 0, 12, 8])).is_err(), "outside");
        assert!(with(Some([5, 5, 5, 6])).is_err(), "empty");
    }
}
