// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether camera rays meet other instances than scattered rays do.
//! Tests: crates/render/tests/ray_masks.rs.

use std::collections::HashSet;
use std::sync::Arc;

use gnurt_scene::RayMask;

use super::World;
use super::instance::InstanceSlot;
use super::object::WorldObject;

impl World {
    /// Whether some instance, or a member of its object, is met by camera rays alone, or by scattered rays alone.
    pub(crate) fn differs_for_camera(&self) -> bool {
        let mut known = HashSet::new();
        let mut placed = self.instances.iter().filter_map(InstanceSlot::placed);
        placed.any(|placed| differs(placed.mask) || has_difference(&placed.object, &mut known))
    }
}

fn differs(mask: RayMask) -> bool {
    mask.meets(RayMask::CAMERA) != mask.meets(RayMask::OTHER)
}

/// Whether members of an object differ; of a `known` object that is not asked again.
fn has_difference(object: &Arc<WorldObject>, known: &mut HashSet<*const WorldObject>) -> bool {
    let Some(members) = object.members.as_ref().filter(|_| known.insert(Arc::as_ptr(object))) else {
        return false;
    };
    members.iter().any(|(_, member, mask)| differs(mask) || has_difference(&member.object, known))
}
