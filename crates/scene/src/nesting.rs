// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects made of other objects: the depth of nesting, cycles, and the occurrences that instances show after
//! unfolding. \[SIP06\], section 6, has two levels. Spaces: a member's transform goes to the object that holds
//! it. Invariants: traversals end, also in descriptions with cycles; each visits an object once, however
//! often it occurs, except [`Scene::occurrences`]. Tests: `tests`.

use crate::affine::Affine;
use crate::id::{InstanceId, ObjectId};
use crate::ray_mask::RayMask;
use crate::scene::{Object, Scene};

/// Most transforms on the path from the world to a mesh: that of an instance, and those of the members
/// within.
pub const DEEPEST: u32 = 16;

/// Objects whose nesting is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NestingError {
    /// A member that is no object of the scene.
    #[error("member {member} of object {object} shows object {missing}, which the scene does not have")]
    Missing {
        /// The object that holds it.
        object: u32,
        /// Its index among the members.
        member: usize,
        /// The missing object.
        missing: u32,
    },
    /// The members of an object, or theirs, show the object itself.
    #[error("object {object} holds itself; members must not lead back to the object that holds them")]
    Circle {
        /// The object.
        object: u32,
    },
    /// More than [`DEEPEST`] levels.
    #[error("below object {object} objects are nested more than {DEEPEST} levels deep")]
    TooDeep {
        /// The outermost of them.
        object: u32,
    },
}

/// An object where an instance shows it, by itself or within another.
#[derive(Clone, Copy, Debug)]
pub struct Occurrence<'a> {
    /// The instance of the scene.
    pub instance: InstanceId,
    /// Objects that hold it, along the path from the instance.
    pub depth: usize,
    /// Of the instance, or of an object within another its own.
    pub name: &'a str,
    /// The object.
    pub object_id: ObjectId,
    /// The object itself.
    pub object: &'a Object,
    /// The last transform of the path.
    pub parent_from_object: Affine,
    /// All transforms of the path.
    pub world_from_object: Affine,
    /// The intersection of all masks along the path.
    pub mask: RayMask,
}

/// A level that is not known yet.
const UNKNOWN: u32 = u32::MAX;

impl Scene {
    /// By object: 0 for one without members, else one more than the greatest of its members.
    ///
    /// # Errors
    /// [`NestingError`]: the first mistake.
    pub fn levels(&self) -> Result<Vec<u32>, NestingError> {
        let mut levels: Vec<u32> =
            self.objects().iter().map(|object| if object.members.is_empty() { 0 } else { UNKNOWN }).collect();
        for object in 0..levels.len() as u32 {
            self.level(object, &mut Vec::new(), &mut levels)?;
        }
        Ok(levels)
    }

    /// The level of an object below those of `above`, outermost first.
    fn level(&self, object: u32, above: &mut Vec<u32>, levels: &mut [u32]) -> Result<u32, NestingError> {
        let too_deep =
            |above: &[u32]| NestingError::TooDeep { object: above.first().copied().unwrap_or(object) };
        let known = levels[object as usize];
        if known != UNKNOWN {
            let fits = above.len() as u32 + known < DEEPEST;
            return fits.then_some(known).ok_or_else(|| too_deep(above));
        }
        if above.contains(&object) {
            return Err(NestingError::Circle { object });
        }
        if above.len() as u32 >= DEEPEST {
            return Err(too_deep(above));
        }
        above.push(object);
        let mut level = 0;
        for (location, member) in self.objects()[object as usize].members.iter().enumerate() {
            let missing = member.object.0;
            if member.object.index() >= levels.len() {
                return Err(NestingError::Missing { object, member: location, missing });
            }
            level = level.max(1 + self.level(missing, above, levels)?);
        }
        above.pop();
        levels[object as usize] = level;
        Ok(level)
    }

    /// By object: how many triangles rays may meet of it, those of objects in it as often as they occur. `None` where
    /// [`levels`](Self::levels) are an error; ids that name nothing count 0.
    #[must_use]
    pub fn unfolded_triangles(&self) -> Option<Vec<u64>> {
        let levels = self.levels().ok()?;
        let mut order: Vec<usize> = (0..levels.len()).collect();
        order.sort_by_key(|&object| levels[object]);
        let mut counts = vec![0_u64; levels.len()];
        for object in order {
            let Object { meshes, members, .. } = &self.objects()[object];
            let own = meshes
                .iter()
                .filter_map(|id| self.meshes().get(id.index()))
                .map(|mesh| mesh.indices.len() as u64);
            let inner = members.iter().map(|member| counts[member.object.index()]);
            counts[object] = own.chain(inner).fold(0, u64::saturating_add);
        }
        Some(counts)
    }

    /// All objects that visible instances show, nested ones too, each as often as it occurs: holders of
    /// others come first. There may be very many. If [`levels`](Self::levels) is an error, only the objects
    /// that instances show directly; invalid ids are skipped.
    #[must_use]
    pub fn occurrences(&self) -> Occurrences<'_> {
        let is_flat = self.objects().iter().all(|object| object.members.is_empty());
        let unfolds = !is_flat && self.levels().is_ok();
        Occurrences { scene: self, next: 0, unfolds, stack: Vec::new() }
    }
}

/// See [`Scene::occurrences`].
#[derive(Debug)]
pub struct Occurrences<'a> {
    scene: &'a Scene,
    /// The next instance.
    next: u32,
    unfolds: bool,
    /// Objects along the path to the last one, and the next member of each.
    stack: Vec<(Occurrence<'a>, usize)>,
}

impl<'a> Iterator for Occurrences<'a> {
    type Item = Occurrence<'a>;

    fn next(&mut self) -> Option<Occurrence<'a>> {
        let objects = self.scene.objects();
        while let Some((holder, next)) = self.stack.last_mut() {
            let holder = *holder;
            let Some(member) = holder.object.members.get(*next) else {
                self.stack.pop();
                continue;
            };
            *next += 1;
            let object = &objects[member.object.index()];
            return Some(self.enter(Occurrence {
                depth: holder.depth + 1,
                name: &object.name,
                object_id: member.object,
                object,
                parent_from_object: member.object_from_member,
                world_from_object: holder.world_from_object * member.object_from_member,
                mask: holder.mask & member.mask,
                ..holder
            }));
        }
        loop {
            let id = InstanceId(self.next);
            let instance = self.scene.instances().get(id.index())?;
            self.next += 1;
            if let Some(object) = objects.get(instance.object.index()).filter(|_| instance.visible) {
                let (location, mask) = (instance.world_from_object, instance.mask);
                return Some(self.enter(Occurrence {
                    instance: id,
                    depth: 0,
                    name: &instance.name,
                    object_id: instance.object,
                    object,
                    parent_from_object: location,
                    world_from_object: location,
                    mask,
                }));
            }
        }
    }
}

impl<'a> Occurrences<'a> {
    fn enter(&mut self, found: Occurrence<'a>) -> Occurrence<'a> {
        if self.unfolds && !found.object.members.is_empty() {
            self.stack.push((found, 0));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Member;

    fn along(x: f64) -> Affine {
        Affine::translation([x, 0.0, 0.0])
    }

    /// Objects each of which holds its predecessor twice.
    fn tower(levels: u32) -> Scene {
        let mut scene = Scene::new();
        scene.add_object(Object::default());
        for level in 1..=levels {
            let member = |x| Member::new(ObjectId(level - 1), along(x));
            scene.add_object(Object {
                members: vec![member(0.0), member(f64::from(1 << (level - 1)))],
                ..Object::default()
            });
        }
        scene.instantiate(ObjectId(levels), along(100.0));
        scene
    }

    #[test]
    fn levels_count_from_below() {
        assert_eq!(tower(3).levels(), Ok(vec![0, 1, 2, 3]), "one above the other");
        let deep = tower(15);
        assert_eq!(deep.levels().map(|levels| levels[15]), Ok(15), "sixteen transforms with the instance's");
        assert_eq!(tower(16).levels(), Err(NestingError::TooDeep { object: 16 }), "one too many");
        let mut turned = tower(16);
        // Known from below, or found from above: the same.
        turned.edit_object(ObjectId(0)).members.push(Member::new(ObjectId(17), along(0.0)));
        turned.add_object(Object::default());
        assert!(matches!(turned.levels(), Err(NestingError::TooDeep { .. })), "{:?}", turned.levels());
    }

    #[test]
    fn circles_and_gaps_are_found() {
        let mut scene = tower(3);
        scene.edit_object(ObjectId(1)).members.push(Member::new(ObjectId(3), along(0.0)));
        let error = scene.levels().expect_err("a circle");
        assert!(matches!(error, NestingError::Circle { .. }), "{error}");
        assert_eq!(scene.occurrences().count(), 1, "the walk ends");
        scene.edit_object(ObjectId(1)).members[2].object = ObjectId(9);
        let error = scene.levels().expect_err("a gap");
        assert_eq!(
            error.to_string(),
            "member 2 of object 1 shows object 9, which the scene does not have",
            "where"
        );
        let mut alone = Scene::new();
        alone.add_object(Object { members: vec![Member::new(ObjectId(0), along(0.0))], ..Object::default() });
        assert_eq!(alone.levels(), Err(NestingError::Circle { object: 0 }), "in itself");
    }

    #[test]
    fn all_occurrences_are_unfolded() {
        let mut scene = tower(3);
        scene.edit_object(ObjectId(3)).members[1].mask = RayMask::CAMERA;
        let leaves: Vec<_> = scene.occurrences().filter(|found| found.object.members.is_empty()).collect();
        let offsets: Vec<f64> = leaves.iter().map(|found| found.world_from_object.columns[3][0]).collect();
        assert_eq!(offsets, (0..8).map(|i| f64::from(100 + i)).collect::<Vec<_>>(), "in order");
        let masks: Vec<RayMask> = leaves.iter().map(|found| found.mask).collect();
        assert_eq!(masks, [[RayMask::ALL; 4], [RayMask::CAMERA; 4]].concat(), "masks of the way");
        assert_eq!(scene.occurrences().count(), 1 + 2 + 4 + 8, "with those that hold others");
        let mesh =
            crate::Mesh { positions: vec![[0.0; 3]], indices: vec![[0; 3]; 5], ..crate::Mesh::default() };
        let mesh = scene.add_mesh(mesh);
        scene.edit_object(ObjectId(0)).meshes.push(mesh);
        assert_eq!(scene.unfolded_triangles(), Some(vec![5, 10, 20, 40]), "triangles as often as they occur");
        scene.edit_instance(InstanceId(0)).visible = false;
        assert_eq!(scene.occurrences().count(), 0, "nothing is shown");
    }
}
