// SPDX-License-Identifier: GPL-3.0-or-later
//! Named media, and which of them shapes and the camera are in: `MediumInterface`.
//! Differs from pbrt: a shape only names its inside. Outside of it is the medium of the body around, as closed
//! shapes nest; the camera's medium fills all space unless a shape holds it. So an exterior that contradicts
//! the nesting has no effect.
//! Tests: tests/media.rs.

use std::collections::HashMap;
use std::sync::Arc;

use gnurt_scene::io::Error;
use gnurt_scene::io::reader::quoted;
use gnurt_scene::medium::Extent;
use gnurt_scene::{Affine, Medium, MediumId, Scene};

use crate::location::Location;

/// A medium by its name: it may be named before it is defined.
struct Named {
    id: MediumId,
    /// Where it was named first.
    location: Location,
    is_defined: bool,
    /// Whether some shape holds it.
    is_within: bool,
}

/// All media of a file.
#[derive(Default)]
pub(crate) struct Media {
    named: HashMap<String, Named>,
    /// Of shapes that hold nothing within a medium.
    vacuum: Option<MediumId>,
    /// The medium that the camera is in.
    pub(crate) of_camera: Option<MediumId>,
}

impl Media {
    /// A medium, defined or not; `None` for the empty name, which means nothing.
    pub(crate) fn named(&mut self, scene: &mut Scene, name: &str, location: &Location) -> Option<MediumId> {
        if name.is_empty() {
            return None;
        }
        let slot = self.named.entry(name.to_owned()).or_insert_with(|| Named {
            id: scene.add_medium(Medium { name: name.to_owned(), ..Medium::default() }),
            location: location.clone(),
            is_defined: false,
            is_within: false,
        });
        Some(slot.id)
    }

    /// Defines a medium, as nothing if it cannot be shown; false if it was defined before.
    pub(crate) fn define(
        &mut self,
        scene: &mut Scene,
        name: &str,
        medium: Option<Medium>,
        location: &Location,
    ) -> bool {
        let Some(id) = self.named(scene, name, location) else { return true };
        if let Some(medium) = medium {
            *scene.edit_medium(id) = Medium { name: name.to_owned(), ..medium };
        }
        let slot = self.named.get_mut(name);
        slot.is_some_and(|slot| !std::mem::replace(&mut slot.is_defined, true))
    }

    /// The medium within a shape, given the media within and around; `None` if the shape bounds none.
    pub(crate) fn within(
        &mut self,
        scene: &mut Scene,
        [within, around]: [Option<MediumId>; 2],
    ) -> Option<MediumId> {
        match (within, around) {
            (Some(id), _) => {
                self.named.values_mut().filter(|slot| slot.id == id).for_each(|slot| slot.is_within = true);
                Some(id)
            }
            (None, Some(_)) => {
                let nothing = || scene.add_medium(Medium { name: "nothing".into(), ..Medium::default() });
                Some(*self.vacuum.get_or_insert_with(nothing))
            }
            (None, None) => None,
        }
    }

    /// Ends the file: undefined media are errors.
    pub(crate) fn finish(&self, scene: &mut Scene, world_from_file: &Affine) -> Result<(), Error> {
        let mut undefined: Vec<_> = self.named.iter().filter(|(_, slot)| !slot.is_defined).collect();
        undefined.sort_by_key(|(_, slot)| slot.location.line);
        if let Some((name, slot)) = undefined.first() {
            let problem = format!("no medium {} is defined", quoted(name));
            return Err(slot
                .location
                .error(problem, "define it: MakeNamedMedium \"NAME\" \"string type\" ..."));
        }
        for slot in self.named.values() {
            if let Some(grid) = &mut scene.edit_medium(slot.id).grid {
                // The renderer's world is known only behind WorldBegin.
                let grid = Arc::make_mut(grid);
                grid.world_from_unit = *world_from_file * grid.world_from_unit;
            }
        }
        let of_camera = self.named.values().find(|slot| Some(slot.id) == self.of_camera);
        if let Some(slot) = of_camera.filter(|slot| !slot.is_within) {
            scene.edit_medium(slot.id).extent = Extent::Around { centre: [0.0; 3], radius: f32::INFINITY };
        }
        Ok(())
    }
}
