// SPDX-License-Identifier: GPL-3.0-or-later
//! Point instancers: prototypes at many places, those hidden by their ids left out.
//! Source: UsdGeomPointInstancer. A prototype's own transform is part of what is repeated. Space: that of the instancer.
//! Tests: `tests/instancing.rs`.

use gnurt_scene::io::{Error, Oddity};
use gnurt_scene::{Affine, Member, ObjectId};
use openusd::sdf::{Path, Value};

use crate::builder::{Builder, State};
use crate::transform::rotation;
use crate::value;

impl Builder<'_> {
    /// The object of all that a point instancer shows.
    pub(crate) fn instancer(&mut self, prim: &Path, state: &State) -> Result<Option<ObjectId>, Error> {
        let reader = self.reader;
        let prototypes = reader.targets(prim, "prototypes");
        let Some(indices) = reader.value(prim, "protoIndices").as_ref().and_then(value::integers) else {
            return Ok(None);
        };
        let positions = reader.value(prim, "positions").as_ref().and_then(value::vectors::<3>);
        let positions = positions.filter(|positions| positions.len() == indices.len());
        let Some(positions) = positions else {
            reader.note(
                Oddity::BadNode,
                prim,
                format_args!("{} protoIndices and another number of positions", indices.len()),
            );
            return Ok(None);
        };
        if let Err(excess) = reader.files.access.budget.hold(indices.len().saturating_mul(160)) {
            reader.note(Oddity::BadNode, prim, excess);
            return Ok(None);
        }
        let fitting = |name: &str, length: usize| {
            let fits = length == indices.len();
            if !fits && length > 0 {
                reader.note(
                    Oddity::BadAttribute,
                    prim,
                    format_args!("{length} {name} of {} instances", indices.len()),
                );
            }
            fits
        };
        let rotations = ["orientationsf", "orientations"].into_iter().find_map(|name| {
            let rotations = reader.value(prim, name).as_ref().and_then(value::quaternions)?;
            fitting(name, rotations.len()).then_some(rotations)
        });
        let scales = reader.value(prim, "scales").as_ref().and_then(value::vectors::<3>);
        let scales = scales.filter(|scales| fitting("scales", scales.len()));
        let objects = prototypes
            .iter()
            .map(|prototype| self.prototype(prototype, state))
            .collect::<Result<Vec<_>, Error>>()?;
        let hidden = self.hidden(prim, indices.len());
        let mut members = Vec::new();
        for (i, &index) in indices.iter().enumerate() {
            let object = usize::try_from(index).ok().and_then(|index| objects.get(index));
            let Some(object) = object else {
                reader.note(Oddity::BadNode, prim, format_args!("no prototype {index}"));
                continue;
            };
            if hidden[i] {
                continue;
            }
            let mut transform = Affine::translation(positions[i].map(f64::from));
            if let Some(rotations) = &rotations {
                transform = transform * rotation(rotations[i]);
            }
            if let Some(scales) = &scales {
                transform = transform * Affine::scale(scales[i].map(f64::from));
            }
            if let Some(object) = *object {
                members.push(Member::new(object, transform));
            }
        }
        members.retain(|member| member.object_from_member.inverse().is_some());
        let any = !members.is_empty();
        Ok(any.then(|| self.scene.add_object_of_members(prim.as_str(), members)))
    }

    /// The object of a prototype; `None` where it shows nothing.
    fn prototype(&mut self, prim: &Path, state: &State) -> Result<Option<ObjectId>, Error> {
        if let Some(known) = self.prototypes.get(prim) {
            return Ok(*known);
        }
        // One that instances itself shows nothing.
        self.prototypes.insert(prim.clone(), None);
        let state = State { world_from_parent: Affine::IDENTITY, ..state.clone() };
        let mut placed = Vec::new();
        let outer = std::mem::replace(&mut self.root, Affine::IDENTITY);
        let outer_is_prototype = std::mem::replace(&mut self.is_prototype, true);
        let walked = self.prim(prim, &state, &mut placed);
        (self.root, self.is_prototype) = (outer, outer_is_prototype);
        walked?;
        let object = match &placed[..] {
            [] => None,
            [only] if only.transform == Affine::IDENTITY => Some(only.object),
            all => Some(self.scene.add_object_of_members(prim.as_str(), Self::members(all))),
        };
        self.prototypes.insert(prim.clone(), object);
        Ok(object)
    }

    /// By instance: whether its id is hidden or not active.
    fn hidden(&self, prim: &Path, count: usize) -> Vec<bool> {
        let reader = self.reader;
        let longs = |name: &str| reader.value(prim, name).as_ref().and_then(value::long_integers);
        let ids = longs("ids").filter(|ids| ids.len() == count);
        let mut left_out = longs("invisibleIds").unwrap_or_default();
        left_out.extend(reader.inactive_ids(prim));
        left_out.sort_unstable();
        let id = |i: usize| ids.as_ref().map_or(i as i64, |ids| ids[i]);
        (0..count).map(|i| left_out.binary_search(&id(i)).is_ok()).collect()
    }
}

impl crate::reader::Reader {
    /// The ids that a point instancer's metadata make inactive.
    fn inactive_ids(&self, prim: &Path) -> Vec<i64> {
        match self.prim_metadata(prim, "inactiveIds") {
            Some(Value::Int64ListOp(list)) => list.flatten(),
            Some(other) => value::long_integers(&other).unwrap_or_default(),
            None => Vec::new(),
        }
    }
}
