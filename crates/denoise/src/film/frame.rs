// SPDX-License-Identifier: GPL-3.0-or-later
//! The planes of a frame that other frames borrow from.
//! Space: pixels of the frame, to the right and down; distances from the eye in world units.
//! Tests: `tests/film.rs`.

use gnurt_image::{ChannelData, Picture};

use crate::error::Error;
use crate::light::Light;
use crate::noisy::{Noisy, Triple};

/// The layer of motion, in pixels to the right and down. `X` and `Y` lead to where a point was in the frame before,
/// `Z` and `W` to where it will be in the next one. `before` and `after` are its distances from the eye there.
pub const MOTION: &str = "motion";

/// A frame of a film.
pub struct FilmFrame {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) noisy: Noisy,
    pub(super) light: Light,
    /// Of the first hit: instance, object and material; 0 = none.
    pub(super) id: Vec<u32>,
    /// From the eye.
    pub(super) distance: Vec<f32>,
    /// How much the distance changes to pixels beside, at least.
    pub(super) slope: Vec<f32>,
    /// To the frame before, and to the one after.
    pub(super) steps: [Vec<Step>; 2],
}

/// The way of a point to another frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Step {
    pub(super) by: [f32; 2],
    /// The distance from the eye there; 0 = unknown.
    pub(super) distance: f32,
}

impl FilmFrame {
    /// Takes the planes from a picture.
    ///
    /// # Errors
    /// [`Error::NoChannel`] if a layer is missing.
    pub fn of(picture: &Picture) -> Result<Self, Error> {
        let mut noisy = Noisy::of(picture, [0, 0, picture.width, picture.height])?;
        let light = Light::of(&noisy);
        // The rest is in the light.
        (noisy.color, noisy.variance, noisy.emission) = (Vec::new(), Vec::new(), Vec::new());
        let (width, height) = (noisy.width, noisy.height);
        let channel = |layer: &str, name: &str| picture.layer(layer).and_then(|layer| layer.channel(name));
        let floats = |layer: &str, name: &str| match channel(layer, name).map(|channel| &channel.data) {
            Some(ChannelData::F32(values)) => Ok(values),
            _ => Err(Error::NoChannel(format!("{layer}.{name}"))),
        };
        let ids = |layer: &str| -> Result<Vec<u32>, Error> {
            let of = |name: &str| match channel(layer, name).map(|channel| &channel.data) {
                Some(ChannelData::U32(values)) => Ok(values),
                _ => Err(Error::NoChannel(format!("{layer}.{name}"))),
            };
            let (instance, object, material) = (of("instance")?, of("object")?, of("material")?);
            Ok((0..width * height).map(|p| mixed([instance[p], object[p], material[p]])).collect())
        };
        let mut id = ids("id")?;
        let mut distance = floats("depth", "Z")?.clone();
        if let (Ok(seen), Ok(way)) = (ids("seen_id"), floats("seen_depth", "Z")) {
            // Surfaces in a mirror differ from the same ones without it.
            for (p, id) in id.iter_mut().enumerate().filter(|(p, id)| seen[*p] != **id) {
                (*id, distance[p]) = (mixed([*id, seen[p], 0]), way[p]);
            }
        }
        let way = |x: &str, y: &str, far: &str| -> Result<Vec<Step>, Error> {
            let (x, y, far) = (floats(MOTION, x)?, floats(MOTION, y)?, floats(MOTION, far)?);
            Ok((0..width * height).map(|p| Step { by: [x[p], y[p]], distance: far[p] }).collect())
        };
        let steps = [way("X", "Y", "before")?, way("Z", "W", "after")?];
        let slope = slopes(&distance, &id, width);
        Ok(Self { width, height, noisy, light, id, distance, slope, steps })
    }

    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Whether its pixel `q` shows the surface of this id and normal at this distance from the eye.
    pub(super) fn shows(&self, q: usize, id: u32, normal: &Triple, distance: f32) -> bool {
        if self.id[q] != id {
            return false;
        }
        if id == 0 {
            return true;
        }
        let off = (self.distance[q] - distance).abs();
        let is_near = distance <= 0.0 || off <= FAR * distance + STEEP * self.slope[q];
        is_near && cosine(&self.noisy.normal[q], normal) > SAME_NORMAL
    }
}

/// Distances of one surface differ by this share at most, for other reasons than its slope.
const FAR: f32 = 0.01;
/// Slopes between pixels that a point may be off.
const STEEP: f32 = 2.0;
/// Cosine between normals of one surface, at least, from frame to frame.
const SAME_NORMAL: f32 = 0.85;

/// Normals are means: shorter than 1 where they vary.
fn cosine(a: &Triple, b: &Triple) -> f32 {
    let dot = |a: &Triple, b: &Triple| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let lengths = (dot(a, a) * dot(b, b)).sqrt();
    if lengths > 1e-6 { dot(a, b) / lengths } else { 1.0 }
}

fn mixed(ids: [u32; 3]) -> u32 {
    if ids == [u32::MAX; 3] {
        return 0;
    }
    let mix = |hash: u32, id: u32| (hash ^ id).wrapping_mul(0x9e37_79b1).rotate_left(15);
    ids.into_iter().fold(0x2545_f491, mix) | 1
}

/// The least difference to a neighbour of the same id in a row, and in a column; the larger of the two.
fn slopes(distance: &[f32], id: &[u32], width: usize) -> Vec<f32> {
    let height = distance.len() / width;
    let of = |p: usize| {
        let (x, y) = (p % width, p / width);
        let to = |is_inside: bool, q: usize| {
            let is_same = is_inside && id.get(q) == Some(&id[p]);
            if is_same { (distance[q] - distance[p]).abs() } else { f32::INFINITY }
        };
        let across = to(x > 0, p.wrapping_sub(1)).min(to(x + 1 < width, p + 1));
        let down = to(y > 0, p.wrapping_sub(width)).min(to(y + 1 < height, p + width));
        let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
        finite(across).max(finite(down))
    };
    (0..distance.len()).map(of).collect()
}
