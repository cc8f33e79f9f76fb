// SPDX-License-Identifier: GPL-3.0-or-later
//! What searches know of a world: smooth surfaces to start at, and lamps to end at.
//! Surfaces are chosen by area over the squares of the distances to
//! the point and to the lamp. Lamps are chosen by the light that the surfaces receive of them.
//! Space: world. Invariant: a function of the world and of options that do not depend on pieces or threads.
//! Tests: crates/render/tests/caustics.rs.

use std::ops::Range;

use glam::Vec3;
use gnurt_shading::lights::{LampPoint, LightId, LightKind, LightSet, Place};
use gnurt_shading::sampling::Distribution;

use super::places::Places;
use crate::transport::flight::Random;
use crate::world::{PlacedMesh, World};

/// Parts that surfaces are chosen from: the largest meshes, and all others together.
const MOST_PARTS: usize = 64;

/// Meshes that are chosen together.
#[derive(Debug)]
pub(super) struct Part {
    meshes: Vec<PlacedMesh>,
    /// Among them, if they are several.
    choice: Option<Distribution>,
    area: f32,
    center: Vec3,
    radius: f32,
}

/// Smooth surfaces and lamps.
#[derive(Debug)]
pub(crate) struct Caustics {
    /// By material.
    smooth: Vec<bool>,
    parts: Vec<Part>,
    lamps: Vec<LightId>,
    power: Distribution,
    /// By emissive triangle: the probability that a search chooses it.
    searched: Vec<f32>,
    /// Where searches are worth their rays, if a pilot told.
    places: Option<Places>,
}

impl Caustics {
    /// `None` if no surface may bring light of a lamp. Which materials are smooth, their meshes, lamps, and by emissive triangle
    /// whether it is one of them.
    pub(super) fn new(
        lights: &LightSet,
        (smooth, meshes): (Vec<bool>, Vec<PlacedMesh>),
        is_lamp: impl Fn(Range<usize>, &[Part]) -> bool,
    ) -> Option<Self> {
        let parts = parts(meshes);
        if parts.is_empty() {
            return None;
        }
        let mut lamps = Vec::new();
        let ids = lights.shape_ids();
        let mut first = 0;
        for mesh in ids.chunk_by(|a, b| a[..2] == b[..2]) {
            let shapes = first..first + mesh.len();
            first = shapes.end;
            if is_lamp(shapes.clone(), &parts) {
                lamps.extend(shapes.map(|i| LightId(i as u32)));
            }
        }
        let others = (ids.len() as u32..lights.len() as u32).map(LightId);
        lamps.extend(others.filter(|&light| lights.kind(light) != LightKind::Environment));
        let power = Distribution::new(lamps.iter().map(|&light| received(lights, light, &parts)))?;
        let mut searched = vec![0.0; ids.len()];
        for (i, light) in lamps.iter().enumerate() {
            if let Some(searched) = searched.get_mut(light.0 as usize) {
                *searched = power.probability(i);
            }
        }
        Some(Self { smooth, parts, lamps, power, searched, places: None })
    }

    /// The same with chances that a pilot learned.
    pub(crate) fn with_places(self, places: Option<Places>) -> Self {
        Self { places, ..self }
    }

    /// These chances.
    pub(crate) fn places(&self) -> Option<&Places> {
        self.places.as_ref()
    }

    /// Whether some surface of a material may be smooth.
    pub(crate) fn is_smooth(&self, material: u32) -> bool {
        self.smooth.get(material as usize).copied().unwrap_or(false)
    }

    /// The probability that a search chooses an emissive shape.
    pub(super) fn probability(&self, shape: u32) -> f32 {
        self.searched.get(shape as usize).copied().unwrap_or(0.0)
    }

    /// A point of a lamp, and the probability of the choice.
    pub(super) fn lamp(&self, lights: &LightSet, choice: f32, u: [f32; 2]) -> Option<(LampPoint, f32)> {
        let chosen = self.power.sample(choice);
        let lamp = lights.lamp_point(self.lamps[chosen.index], u)?;
        (chosen.probability > 0.0).then_some((lamp, chosen.probability))
    }

    /// A point of a smooth surface that may bring light of a lamp to a point.
    pub(super) fn start(&self, world: &World, (p, lamp): (Vec3, Place), random: &mut Random) -> Option<Vec3> {
        let weight = |part: &Part| {
            let near = part.area / part.square_distance(p);
            match lamp {
                Place::At(lamp) => near / part.square_distance(lamp),
                Place::Towards(_) => near,
            }
        };
        let sum: f32 = self.parts.iter().map(weight).sum();
        let mut rest = random.next() * sum;
        let is_here = |part: &&Part| {
            rest -= weight(part);
            rest < 0.0
        };
        let part = self.parts.iter().find(is_here).or(self.parts.last())?;
        let numbers = [(); 4].map(|()| random.next());
        let mesh = match &part.choice {
            Some(choice) => &part.meshes[choice.sample(numbers[3]).index],
            None => part.meshes.first()?,
        };
        world.point_on(mesh, [numbers[0], numbers[1], numbers[2]]).map(|point| point.p)
    }
}

impl Part {
    /// About: at its middle no less than its size.
    pub(super) fn square_distance(&self, p: Vec3) -> f32 {
        p.distance_squared(self.center) + self.radius * self.radius
    }
}

fn parts(mut meshes: Vec<PlacedMesh>) -> Vec<Part> {
    // Stable: equal ones stay in their order.
    meshes.sort_by(|a, b| b.area.total_cmp(&a.area));
    let rest = meshes.split_off(meshes.len().min(MOST_PARTS - 1));
    let single = |mesh: PlacedMesh| {
        let PlacedMesh { area, center, radius, .. } = mesh;
        Part { meshes: vec![mesh], choice: None, area, center, radius }
    };
    let mut parts: Vec<Part> = meshes.into_iter().map(single).collect();
    if let Some(choice) = Distribution::new(rest.iter().map(|mesh| f64::from(mesh.area))) {
        let area = choice.total() as f32;
        let center = rest.iter().map(|mesh| mesh.center * (mesh.area / area)).sum::<Vec3>();
        let reach = |mesh: &PlacedMesh| mesh.center.distance(center) + mesh.radius;
        let radius = rest.iter().map(reach).fold(0.0, f32::max);
        parts.push(Part { meshes: rest, choice: Some(choice), area, center, radius });
    }
    parts
}

/// About the light of a lamp that smooth surfaces receive.
fn received(lights: &LightSet, light: LightId, parts: &[Part]) -> f64 {
    let Some(lamp) = lights.lamp_point(light, [0.5; 2]) else { return 0.0 };
    let of_part = |part: &Part| match lamp.place {
        Place::At(p) => part.area / part.square_distance(p),
        Place::Towards(_) => part.area,
    };
    f64::from(lights.brightness(light) * parts.iter().map(of_part).sum::<f32>())
}
