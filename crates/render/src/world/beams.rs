// SPDX-License-Identifier: GPL-3.0-or-later
//! Beams of shapes that emit by shaders to some directions alone, from samples of their emission.
//! Source: see `gnurt_shading::lights::Beam`. Space: world.
//! Invariant: shapes that emit to all directions, and those of emitters of very many shapes, have none; they are chosen by
//! their mean. Tests: crates/render/tests/beams.rs.

use glam::Vec3;
use gnurt_image::srgb::luminance;
use gnurt_shading::lights::{Beam, EmissiveShape, EmitterPoint, Outline, looking_at};
use gnurt_shading::real::Vector;
use gnurt_shading::sampling::octahedron::square_of;

use super::shader_emission::{EmissionShape, ShaderEmission};

/// Points of a triangle for each direction; and of all shapes of one emitter and side for one direction.
const PLACES: usize = 4;
const MOST_PLACES: usize = 64;
/// Least share of dark samples among a few for which a beam is looked for.
const FEW_DARK: f32 = 1.0 / 8.0;

impl ShaderEmission {
    /// Where the light of shape `number` goes, and its mean brightness, if it goes to some directions alone; `count` shapes are
    /// of its emitter's side, and among a few samples the share `dark` was dark.
    pub(super) fn beam_of(
        &self,
        number: usize,
        shape: &EmissiveShape,
        (count, dark): (usize, f32),
    ) -> Option<(Beam, f32)> {
        let emission = self.shapes[number].filter(|_| dark >= FEW_DARK && count <= MOST_PLACES)?;
        // Of spheres the place whose normal is the direction stands for all that send light there.
        let (normal, places) = match shape.outline {
            Outline::Triangle(_) => {
                (Some(shape.outline.normal_at([0.0; 2])), (MOST_PLACES / count).clamp(1, PLACES))
            }
            Outline::Sphere { .. } => (None, 1),
        };
        let dirs: Vec<Vec3> = Beam::directions().chain(normal).collect();
        let lit: Vec<usize> =
            (0..dirs.len()).filter(|&i| normal.is_none_or(|normal| normal.dot(dirs[i]) > 0.0)).collect();
        let mut bright = vec![0.0; dirs.len()];
        for place in 0..places {
            let requests: Vec<(EmissionShape, EmitterPoint)> = lit
                .iter()
                .map(|&i| {
                    let position = match normal {
                        Some(_) => shape.outline.place(looking_at(place as u32)),
                        None => square_of(Vector::from(dirs[i])),
                    };
                    let dir = -dirs[i];
                    (emission, EmitterPoint { shape: number as u32, position, dir, distance: 1.0 })
                })
                .collect();
            self.query(emission.emitter, &requests, |k, radiance| {
                bright[lit[k]] += luminance(radiance.into()) / places as f32;
            });
        }
        let along = normal.map(|normal| (normal, bright.pop().unwrap_or(0.0)));
        Beam::new(&bright, along)
    }
}
