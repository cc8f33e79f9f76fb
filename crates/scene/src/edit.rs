// SPDX-License-Identifier: GPL-3.0-or-later
//! The edit log: the changes since a cursor, so that a commit does only the necessary work. A journal in the
//! order of time, and the time of each element's last edit: of several edits of one element only the last
//! counts. The journal is compacted when half of it is stale, so it never outgrows the scene. Cost: noting is
//! O(1), amortised; reading is linear in the number of edits since the cursor, for a scene of any size. Any
//! number of worlds can follow one scene, each with its own [`Cursor`]; a copy of a scene is another scene.

use std::sync::Arc;

use crate::id::{CameraId, InstanceId, LightId, MaterialId, MediumId, MeshId, ObjectId, TextureId};

/// An added or replaced element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edit {
    /// A mesh's arrays: objects that hold it need a new tree if its triangles moved.
    Mesh(MeshId),
    /// An object's lists of meshes and members.
    Object(ObjectId),
    /// An instance's transform, object, visibility or mask: only the top tree changes.
    Instance(InstanceId),
    /// A material.
    Material(MaterialId),
    /// A texture.
    Texture(TextureId),
    /// A light.
    Light(LightId),
    /// A camera.
    Camera(CameraId),
    /// A medium.
    Medium(MediumId),
}

impl Edit {
    /// The number of its kind, and its index in that.
    fn index_in_list(self) -> (usize, usize) {
        match self {
            Self::Mesh(id) => (0, id.index()),
            Self::Object(id) => (1, id.index()),
            Self::Instance(id) => (2, id.index()),
            Self::Material(id) => (3, id.index()),
            Self::Texture(id) => (4, id.index()),
            Self::Light(id) => (5, id.index()),
            Self::Camera(id) => (6, id.index()),
            Self::Medium(id) => (7, id.index()),
        }
    }
}

/// Kinds of elements.
const KINDS: usize = 8;

/// A position in the edit log of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cursor(u64);

/// Distinguishes a scene from all others, its copies included: their logs continue separately.
#[derive(Clone, Debug, Default)]
pub struct SceneIdentity(Arc<()>);

impl PartialEq for SceneIdentity {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for SceneIdentity {}

/// Every element with the time of its last edit.
#[derive(Debug, Default)]
pub struct EditLog {
    identity: SceneIdentity,
    now: u64,
    /// The edits, ascending in time. An entry counts while it is the last of its element.
    journal: Vec<(u64, Edit)>,
    /// By kind and index: the time of the last edit; 0 = none yet.
    last: [Vec<u64>; KINDS],
    /// How many entries of the journal count.
    things: usize,
}

impl Clone for EditLog {
    /// The same log of another scene.
    fn clone(&self) -> Self {
        Self {
            identity: SceneIdentity::default(),
            now: self.now,
            journal: self.journal.clone(),
            last: self.last.clone(),
            things: self.things,
        }
    }
}

impl EditLog {
    /// Notes an edit.
    pub fn note(&mut self, edit: Edit) {
        self.now += 1;
        let (kind, index_in_list) = edit.index_in_list();
        let last = &mut self.last[kind];
        if last.len() <= index_in_list {
            last.resize(index_in_list + 1, 0);
        }
        self.things += usize::from(last[index_in_list] == 0);
        last[index_in_list] = self.now;
        match self.journal.last_mut() {
            // Often one element is edited repeatedly.
            Some((edit_number, same)) if *same == edit => *edit_number = self.now,
            _ => self.journal.push((self.now, edit)),
        }
        // A few stale entries are not worth the walk.
        if self.journal.len() > 2 * self.things + 64 {
            let last = &self.last;
            self.journal.retain(|entry| is_last(last, entry));
        }
    }

    /// The current position: pass it to [`since`](Self::since) next time.
    #[must_use]
    pub fn cursor(&self) -> Cursor {
        Cursor(self.now)
    }

    /// Whose log it is.
    #[must_use]
    pub fn identity(&self) -> &SceneIdentity {
        &self.identity
    }

    /// The edits after `cursor`: each element once, in the order of last edits.
    pub fn since(&self, cursor: Cursor) -> impl Iterator<Item = Edit> + '_ {
        let first = self.journal.partition_point(|&(edit_number, _)| edit_number <= cursor.0);
        let entries = self.journal[first..].iter();
        entries.filter(|entry| is_last(&self.last, entry)).map(|&(_, edit)| edit)
    }
}

/// Whether an entry of the journal is the last of its element.
fn is_last(last: &[Vec<u64>; KINDS], &(edit_number, edit): &(u64, Edit)) -> bool {
    let (kind, index_in_list) = edit.index_in_list();
    last[kind][index_in_list] == edit_number
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
        let middle = log.cursor();
        log.note(Edit::Instance(InstanceId(3)));
        let edits: Vec<_> = log.since(early).collect();
        assert_eq!(edits, [Edit::Mesh(MeshId(0)), Edit::Instance(InstanceId(3))], "each once");
        let edits: Vec<_> = log.since(middle).collect();
        assert_eq!(edits, [Edit::Instance(InstanceId(3))], "only what is newer");
        assert_eq!(log.since(log.cursor()).count(), 0, "nothing is newer than now");
        let middle = log.cursor();
        log.note(Edit::Instance(InstanceId(3)));
        assert_eq!(log.since(middle).count(), 1, "an edit again is an edit");
    }

    /// Against a list of all edits that is searched from its end.
    #[test]
    fn long_logs_stay_short_and_forget_nothing() {
        let (mut log, mut all) = (EditLog::default(), Vec::new());
        let mut state = 1_u32;
        let mut cursors = vec![(log.cursor(), 0)];
        for step in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let id = state >> 26;
            let edit =
                if state & 1 << 20 == 0 { Edit::Instance(InstanceId(id)) } else { Edit::Mesh(MeshId(id)) };
            log.note(edit);
            all.push(edit);
            if step % 97 == 0 {
                cursors.push((log.cursor(), all.len()));
            }
            assert!(log.journal.len() <= 2 * 128 + 64, "{} entries for 128 things", log.journal.len());
        }
        for (cursor, from) in cursors {
            let mut expected: Vec<Edit> = Vec::new();
            for edit in all[from..].iter().rev() {
                if !expected.contains(edit) {
                    expected.push(*edit);
                }
            }
            expected.reverse();
            assert_eq!(log.since(cursor).collect::<Vec<_>>(), expected, "since edit {from}");
        }
    }

    #[test]
    fn copies_are_others() {
        let log = EditLog::default();
        assert_eq!(log.identity(), log.identity(), "itself");
        assert_ne!(log.identity(), log.clone().identity(), "a copy goes its own way");
    }
}
