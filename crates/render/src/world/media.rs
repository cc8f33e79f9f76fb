// SPDX-License-Identifier: GPL-3.0-or-later
//! The media of a world: those that its scene lists, and the interiors of its glass.
//! A world without media that scatter, and without listed ones, has none here: its glass absorbs by the
//! simpler rule of `gnurt_shading::bsdf::Medium`.
//! Space: world. Numbers count from 1: 0 is no medium. Tests: crates/render/tests/media.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt_scene::medium::{DensityGrid, Extent, Phase as ScenePhase};
use gnurt_scene::{Material, Medium, Scene, Surface};
use gnurt_shading::phase::Phase;
use gnurt_shading::{ColorMap, Interior};

use super::grid::Grid;
use super::table::ShaderTable;

/// A medium as rays meet it.
#[derive(Clone)]
pub(crate) struct MediumEntry {
    pub(crate) absorption: Vec3,
    pub(crate) scattering: Vec3,
    /// Both together.
    pub(crate) extinction: Vec3,
    /// Radiance, times absorption for each stretch.
    pub(crate) emission: Vec3,
    pub(crate) phase: Phase<f32>,
    priority: i32,
    /// Of bodies: in addition to others.
    adds: bool,
    pub(crate) grid: Option<Arc<Grid>>,
    /// Centre and radius of a ball that bounds it.
    pub(crate) ball: Option<(Vec3, f32)>,
}

/// All media of a world.
#[derive(Clone, Default)]
pub(crate) struct Media {
    list: Vec<MediumEntry>,
    /// By material: the medium behind it, or 0.
    of_material: Vec<u16>,
    /// The medium outside of all bodies, or 0.
    around: u16,
    /// Media that add to what is there.
    free: Vec<u16>,
    has_bodies: bool,
}

/// The bodies with media that a point is in, the one that was entered last first: up to four.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Inside(u64);

impl Inside {
    /// Their numbers, the last first.
    fn numbers(self) -> impl Iterator<Item = u16> {
        (0..4).map(move |k| (self.0 >> (16 * k)) as u16).take_while(|&number| number != 0)
    }

    /// After a step through the boundary of a medium.
    pub(crate) fn crossing(self, medium: u16, is_entering: bool) -> Self {
        if is_entering {
            return Self(self.0 << 16 | u64::from(medium));
        }
        let Some(k) = self.numbers().position(|number| number == medium) else { return self };
        let low = self.0 & ((1 << (16 * k)) - 1);
        let high = self.0.checked_shr(16 * (k as u32 + 1)).unwrap_or(0);
        Self(high << (16 * k) | low)
    }
}

impl Media {
    /// Those of a scene; grids that are there are kept.
    pub(super) fn new(scene: &Scene, shaders: &ShaderTable, before: &Self, map: ColorMap) -> Self {
        let mut media = Self::default();
        for medium in scene.media() {
            media.list.push(entry(medium, before, map));
        }
        let numbers = 1..=u16::MAX;
        for (number, medium) in numbers.clone().zip(scene.media()) {
            match medium.extent {
                Extent::Bodies => {}
                Extent::Around { .. } => media.around = number,
                Extent::Free => media.free.push(number),
            }
        }
        let needs_media = |material: &Material| {
            let own = interior_of(material, shaders);
            let scatters = own.is_some_and(|interior| interior.scattering != [0.0; 3]);
            material.medium.is_some() || scatters
        };
        if media.list.is_empty() && !scene.materials().iter().any(needs_media) {
            return Self::default();
        }
        for material in scene.materials() {
            // Shaders answer in the working space.
            let is_shader = matches!(material.surface, Surface::Shader(_));
            let own_map = if is_shader { ColorMap::default() } else { map };
            let number = match (material.medium, interior_of(material, shaders)) {
                (Some(id), _) => numbers.clone().nth(id.index()).unwrap_or(0),
                (None, Some(interior)) if media.list.len() < usize::from(u16::MAX) => {
                    media.list.push(entry(&interior, before, own_map));
                    media.list.len() as u16
                }
                _ => 0,
            };
            media.of_material.push(number);
        }
        media.has_bodies = media.of_material.iter().any(|&number| number != 0);
        media
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether some surface bounds a medium.
    pub(crate) fn has_bodies(&self) -> bool {
        self.has_bodies
    }

    /// The medium behind a material, or 0.
    pub(crate) fn of_material(&self, material: u32) -> u16 {
        self.of_material.get(material as usize).copied().unwrap_or(0)
    }

    pub(crate) fn get(&self, number: u16) -> &MediumEntry {
        &self.list[usize::from(number) - 1]
    }

    /// The numbers of all media at a point of a body, or outside: those that add to it included.
    pub(crate) fn at(&self, inside: Inside) -> impl Iterator<Item = u16> + '_ {
        // Of equals the one that was entered last.
        let replacing = inside.numbers().filter(|&body| !self.get(body).adds);
        let body =
            replacing.reduce(
                |best, other| {
                    if self.get(other).priority > self.get(best).priority { other } else { best }
                },
            );
        let base = body.unwrap_or(self.around);
        let adding = inside.numbers().filter(|&body| self.get(body).adds);
        (base != 0).then_some(base).into_iter().chain(adding).chain(self.free.iter().copied())
    }
}

/// The medium of a material's interior, if it is not clear.
fn interior_of(material: &Material, shaders: &ShaderTable) -> Option<Medium> {
    let Surface::Shader(number) = material.surface else { return material.interior_medium() };
    let Interior { absorption, scattering, anisotropy } =
        shaders.surfaces.get(number as usize)?.interior()?;
    Some(Medium {
        name: material.name.clone(),
        absorption: absorption.into(),
        scattering: scattering.into(),
        phase: ScenePhase { anisotropy, ..ScenePhase::default() },
        ..Medium::default()
    })
}

fn entry(medium: &Medium, before: &Media, map: ColorMap) -> MediumEntry {
    let [absorption, scattering, emission] =
        [medium.absorption, medium.scattering, medium.emission].map(|color| map.of(Vec3::from(color)));
    let phase = medium.phase;
    let same = |grid: &Arc<DensityGrid>| {
        let mut known = before.list.iter().filter_map(|entry| entry.grid.as_ref());
        known.find(|known| known.is_of(grid)).cloned()
    };
    let grid = medium.grid.as_ref();
    MediumEntry {
        absorption,
        scattering,
        extinction: absorption + scattering,
        emission,
        phase: Phase {
            anisotropy: [phase.anisotropy, phase.second_anisotropy],
            second_share: phase.second_share,
        },
        priority: medium.priority,
        adds: medium.adds,
        grid: grid.map(|grid| same(grid).unwrap_or_else(|| Arc::new(Grid::new(grid)))),
        ball: match medium.extent {
            Extent::Around { centre, radius } if radius.is_finite() => Some((Vec3::from(centre), radius)),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_entered_and_left() {
        let numbers = |inside: Inside| inside.numbers().collect::<Vec<_>>();
        let glass = Inside::default().crossing(1, true);
        let water = glass.crossing(2, true);
        assert_eq!(numbers(water), [2, 1]);
        assert_eq!(numbers(water.crossing(1, false)), [2], "overlapping bodies");
        assert_eq!(water.crossing(2, false), glass, "nested ones");
        assert_eq!(glass.crossing(7, false), glass, "a body that was not entered");
        let deep = (1..=6).fold(Inside::default(), |inside, n| inside.crossing(n, true));
        assert_eq!(numbers(deep), [6, 5, 4, 3], "the innermost four");
        assert_eq!(numbers(deep.crossing(3, false)), [6, 5, 4]);
    }
}
