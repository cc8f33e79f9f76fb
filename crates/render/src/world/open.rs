// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of a world that move during an open shutter, and the times of rays.
//! Source: [CPC84] (a time for each ray); original for the rest. Where each ray has its own time, the time is
//! a function of its pixel and sample, so that all rays of a path share it without carrying it. Where all
//! rays of a pass need one time, because virtual lights belong to the pass or because lights move, the pass
//! has it: a van der Corput sequence over the samples.
//! Invariant: times are in [0, 1) and do not depend on threads. Tests: crates/render/tests/shutter.rs.

use std::collections::HashMap;
use std::sync::Arc;

use gnurt_accel::{Aabb, KeyInterval, MotionPath};
use gnurt_scene::animation::Exposure;
use gnurt_scene::{Affine, Light, Scene};
use gnurt_shading::SampleKey;
use gnurt_shading::sampling::{hash_combine, purpose, sample_pair};

/// The times of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Shutter {
    /// Nothing moves.
    #[default]
    Closed,
    /// Each at its own time, drawn by this seed.
    Each(u64),
    /// All at this time.
    All(f32),
}

impl Shutter {
    /// The time of a ray with this key.
    #[inline]
    pub(crate) fn time(self, key: SampleKey) -> f32 {
        match self {
            Self::Closed => 0.0,
            Self::Each(seed) => sample_pair(seed, SampleKey { branch: 0, ..key }, 0, purpose::TIME)[0],
            Self::All(time) => time,
        }
    }
}

/// The time of a pass.
pub(super) fn time_of_pass(seed: u64, sample: u32) -> f32 {
    let shift = hash_combine(seed as u32, (seed >> 32) as u32 ^ purpose::TIME);
    // The sum wraps around, as the times do.
    let bits = sample.reverse_bits().wrapping_add(shift);
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// Moving parts in addition to the paths of instances and the keys of objects.
#[derive(Default)]
pub(super) struct Open {
    /// Objects with meshes that bend or members that move, ascending.
    pub(super) objects: Vec<u32>,
    /// Instances that move, ascending.
    pub(super) instances: Vec<u32>,
    /// All lights of the scene, if some of them move.
    lights: Vec<Light>,
    /// Indices of these, and the lights at each key.
    moving: Vec<(usize, Vec<Light>)>,
    /// Whether emissive triangles move.
    pub(super) lights_move: bool,
}

impl Open {
    pub(super) fn new(scene: &Scene, exposure: &Exposure) -> Self {
        let is_exposed = |id: &gnurt_scene::MeshId| exposure.meshes.iter().any(|(mesh, _)| mesh == id);
        let bends = |id: &u32| scene.objects()[*id as usize].meshes.iter().any(is_exposed);
        let mut objects: Vec<u32> = match exposure.meshes.is_empty() {
            true => Vec::new(),
            false => (0..scene.objects().len() as u32).filter(bends).collect(),
        };
        objects.extend(exposure.members.iter().map(|((object, _), _)| object.0));
        objects.sort_unstable();
        objects.dedup();
        let is_there = |id: &u32| (*id as usize) < scene.instances().len();
        let mut instances: Vec<u32> =
            exposure.instances.iter().map(|(id, _)| id.0).filter(is_there).collect();
        instances.sort_unstable();
        instances.dedup();
        let moving: Vec<(usize, Vec<Light>)> = exposure
            .lights
            .iter()
            .filter(|(id, keys)| id.index() < scene.lights().len() && !keys.is_empty())
            .map(|(id, keys)| (id.index(), keys.clone()))
            .collect();
        let lights = if moving.is_empty() { Vec::new() } else { scene.lights().to_vec() };
        Self { objects, instances, lights, moving, lights_move: false }
    }

    /// Whether lights move during the open shutter.
    pub(super) fn lights_move(&self) -> bool {
        self.lights_move || !self.moving.is_empty()
    }

    /// The scene's lights at a time; `None` if none of them moves.
    pub(super) fn lights_at(&self, time: f32) -> Option<Vec<Light>> {
        let mut lights = self.lights.clone();
        for (instance_index, keys) in &self.moving {
            let interval = KeyInterval::of(time, keys.len());
            lights[*instance_index] = mixed(&keys[interval.key], &keys[interval.next], &interval);
        }
        (!self.moving.is_empty()).then_some(lights)
    }
}

/// A light between two keys; where these are of different kinds, the first.
fn mixed(from: &Light, to: &Light, interval: &KeyInterval) -> Light {
    let mix = |a: &[f32; 3], b: &[f32; 3]| interval.mix3(*a, *b);
    match (from, to) {
        (
            Light::Point { position, intensity, radius },
            Light::Point { position: to_position, intensity: to_intensity, radius: to_radius },
        ) => Light::Point {
            position: mix(position, to_position),
            intensity: mix(intensity, to_intensity),
            radius: interval.mix(*radius, *to_radius),
        },
        (
            Light::Spot { position, direction, intensity, inner_angle, outer_angle, edge, radius },
            Light::Spot {
                position: to_position,
                direction: to_direction,
                intensity: to_intensity,
                inner_angle: to_inner,
                outer_angle: to_outer,
                radius: to_radius,
                ..
            },
        ) => Light::Spot {
            position: mix(position, to_position),
            direction: mix(direction, to_direction),
            intensity: mix(intensity, to_intensity),
            inner_angle: interval.mix(*inner_angle, *to_inner),
            outer_angle: interval.mix(*outer_angle, *to_outer),
            edge: *edge,
            radius: interval.mix(*radius, *to_radius),
        },
        (
            Light::Directional { direction, irradiance, angle },
            Light::Directional { direction: to_direction, irradiance: to_irradiance, angle: to_angle },
        ) => Light::Directional {
            direction: mix(direction, to_direction),
            irradiance: mix(irradiance, to_irradiance),
            angle: interval.mix(*angle, *to_angle),
        },
        _ => from.clone(),
    }
}

/// How far a corner of an object may be from where it is, in parts of its size.
const OFF: f64 = 1.0 / 4096.0;

/// Transforms of the moving members of an object, by their indices in its list.
pub(super) fn ways_in(exposure: &Exposure, object: u32) -> HashMap<u32, &[Affine]> {
    let of = exposure.members.iter().filter(|((holder, _), _)| holder.0 == object);
    of.map(|((_, member), transforms)| (*member, &transforms[..])).collect()
}

/// A path through the fewest of the evenly spaced transforms that determine the others for an object with
/// these bounds; `None` if a transform is flat, or if there is nothing visible.
pub(super) fn path(transforms: &[Affine], bounds: &Aabb) -> Option<Arc<MotionPath>> {
    if bounds.is_empty() {
        return None;
    }
    let columns: Vec<[[f64; 3]; 4]> =
        transforms.iter().map(|instance_index| instance_index.columns).collect();
    let pieces = columns.len().checked_sub(1)?;
    let steps = (0..).map(|i| pieces >> i).take_while(|&step| step > 1);
    for step in steps.filter(|step| pieces.is_multiple_of(*step)) {
        let some: Vec<[[f64; 3]; 4]> = columns.iter().copied().step_by(step).collect();
        let path = MotionPath::new(&some)?;
        let share = |i: usize| i as f32 / pieces as f32;
        if columns
            .iter()
            .enumerate()
            .all(|(i, instance_index)| is_near(&path.at(share(i)), instance_index, bounds))
        {
            return Some(Arc::new(path));
        }
    }
    MotionPath::new(&columns).map(Arc::new)
}

/// Whether all corners of a box are nearly at the same positions.
fn is_near(a: &[[f64; 3]; 4], b: &[[f64; 3]; 4], bounds: &Aabb) -> bool {
    let apply = |m: &[[f64; 3]; 4], p: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|row| m[3][row] + (0..3).map(|k| m[k][row] * p[k]).sum::<f64>())
    };
    let extent = bounds.extent();
    let grown = |m: &[[f64; 3]; 4]| -> f64 {
        let along = |row: usize| (0..3).map(|k| m[k][row].abs() * extent[k]).sum::<f64>();
        along(0).max(along(1)).max(along(2))
    };
    let most = OFF * grown(b);
    (0..8).all(|corner| {
        let p =
            [0, 1, 2].map(|k| f64::from(if corner >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] }));
        let (a, b) = (apply(a, p), apply(b, p));
        (0..3).all(|k| (a[k] - b[k]).abs() <= most)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_passes_fill_the_time_evenly() {
        for (seed, count) in [(0, 64), (7, 64), (99, 16)] {
            let mut transforms: Vec<usize> =
                (0..count).map(|sample| (time_of_pass(seed, sample) * count as f32) as usize).collect();
            transforms.sort_unstable();
            assert_eq!(transforms, (0..count as usize).collect::<Vec<_>>(), "one in each piece, seed {seed}");
        }
    }

    #[test]
    fn paths_have_as_few_places_as_do() {
        let bounds = Aabb { min: [-1.0; 3], max: [1.0; 3] };
        let turned = |t: f64| Affine::translation([3.0 * t, 0.0, 0.0]) * Affine::rotation([0.0, 1.0, 0.0], t);
        let transforms =
            |angle: f64| -> Vec<Affine> { (0..=16).map(|i| turned(angle * f64::from(i) / 16.0)).collect() };
        assert_eq!(
            path(&transforms(1.0), &bounds).expect("a path").keys().len(),
            2,
            "a turn in place, and a line"
        );
        let whole = path(&transforms(7.0), &bounds).expect("a path");
        assert!(whole.keys().len() > 2, "more than half a turn needs more places");
        assert!(is_near(&whole.at(0.5), &turned(3.5).columns, &bounds), "and is followed");
        let swing: Vec<Affine> = (0..=16)
            .map(|i| {
                Affine::rotation([0.0, 0.0, 1.0], 2.0 * f64::from(i) / 16.0)
                    * Affine::translation([5.0, 0.0, 0.0])
            })
            .collect();
        let swing = path(&swing, &bounds).expect("a path");
        assert!(swing.keys().len() > 2, "one that swings around something else goes along its circle");
        let flat = vec![Affine::scale([1.0, 0.0, 1.0]); 3];
        assert!(path(&flat, &bounds).is_none(), "what is flat has no path");
    }
}
