// SPDX-License-Identifier: GPL-3.0-or-later
//! The edit log: what changed since somebody last looked, so that a commit does only the work that is due.
//! Source: original. The log is folded: of several edits of one thing only the last is kept, so it never grows beyond
//! the scene itself. Any number of worlds can follow one scene, each with its own [`Cursor`].

use std::collections::BTreeMap;

use crate::id::{CameraId, InstanceId, LightId, MaterialId, MeshId, ObjectId, TextureId};

/// A thing that was added or replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edit {
    /// A mesh's arrays: objects that hold it need a new tree.
    Mesh(MeshId),
    /// An object's list of meshes.
    Object(ObjectId),
    /// An instance's transform, object or visibility: only the top tree changes.
    Instance(InstanceId),
    /// A material.
    Material(MaterialId),
    /// A texture.
    Texture(TextureId),
    /// A light.
    Light(LightId),
    /// A camera.
    Camera(CameraId),
}

/// A moment in the life of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cursor(u64);

/// Every thing with the moment of its last edit.
#[derive(Clone, Debug, Default)]
pub struct EditLog {
    now: u64,
    last: BTreeMap<Edit, u64>,
}

impl EditLog {
    /// Notes an edit.
    pub fn note(&mut self, edit: Edit) {
        self.now += 1;
        self.last.insert(edit, self.now);
    }

    /// The present moment: pass it to [`since`](Self::since) next time.
    #[must_use]
    pub fn cursor(&self) -> Cursor {
        Cursor(self.now)
    }

    /// What was edited after `cursor`, each thing once, in a fixed order.
    pub fn since(&self, cursor: Cursor) -> impl Iterator<Item = Edit> + '_ {
        self.last.iter().filter(move |&(_, &at)| at > cursor.0).map(|(&edit, _)| edit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_and_follows_cursors() {
        let mut log = EditLog::default();
        log.note(Edit::Mesh(MeshId(0)));
        let early = log.cursor();
        log.note(Edit::Instance(InstanceId(3)));
        log.note(Edit::Mesh(MeshId(0)));
        log.note(Edit::Instance(InstanceId(3)));
        let seen: Vec<_> = log.since(early).collect();
        assert_eq!(seen, [Edit::Mesh(MeshId(0)), Edit::Instance(InstanceId(3))], "each once");
        assert_eq!(log.since(log.cursor()).count(), 0, "nothing is newer than now");
    }
}
