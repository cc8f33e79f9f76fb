// SPDX-License-Identifier: GPL-3.0-or-later
//! Skeletons at a moment: where joints are, and the weights of blend shapes.
//! Source: UsdSkel. A joint that its animation does not name is at rest. Space: that of the skeleton. Tests: `tests/skeletons.rs`.

use std::collections::HashMap;
use std::rc::Rc;

use gnurt_scene::Affine;
use gnurt_scene::io::Oddity;
use openusd::sdf::Path;

use crate::builder::Builder;
use crate::pose::Skeleton;
use crate::transform::rotation;
use crate::value;

/// Joints and weights of an animation.
struct Pose {
    joints: HashMap<String, Affine>,
    weights: HashMap<String, f32>,
}

impl Builder<'_> {
    /// The first target of a relationship, from a prim or the nearest prim above it that has one.
    pub(crate) fn inherited_target(&self, prim: &Path, name: &str) -> Option<Path> {
        prim.ancestors_below_root().find_map(|above| self.reader.targets(&above, name).into_iter().next())
    }

    /// The skeleton at a path.
    pub(crate) fn skeleton(&mut self, prim: &Path) -> Option<Rc<Skeleton>> {
        if let Some(known) = self.skeletons.get(prim) {
            return known.clone();
        }
        let read = self.read_skeleton(prim).map(Rc::new);
        self.skeletons.insert(prim.clone(), read.clone());
        read
    }

    fn read_skeleton(&self, prim: &Path) -> Option<Skeleton> {
        let reader = self.reader;
        let joints = reader.value(prim, "joints").as_ref().and_then(value::words)?;
        let matrices = |name: &str| {
            let all = reader.value(prim, name).as_ref().and_then(value::matrices)?;
            (all.len() == joints.len()).then(|| all.iter().map(Affine::from_column_major).collect::<Vec<_>>())
        };
        let Some(bind) = matrices("bindTransforms") else {
            reader.note(Oddity::BadNode, prim, "a skeleton needs as many bindTransforms as joints");
            return None;
        };
        let numbers: HashMap<&str, usize> =
            joints.iter().enumerate().map(|(i, joint)| (&joint[..], i)).collect();
        let parent = |i: usize| {
            let mut path = &joints[i][..];
            while let Some((above, _)) = path.rsplit_once('/') {
                // Joints of a tree come behind those above them.
                if let Some(&found) = numbers.get(above).filter(|&&found| found < i) {
                    return Some(found);
                }
                path = above;
            }
            None
        };
        let rest = matrices("restTransforms").unwrap_or_else(|| {
            let local = |i: usize| match parent(i).and_then(|above| bind[above].inverse()) {
                Some(above) => above * bind[i],
                None => bind[i],
            };
            (0..joints.len()).map(local).collect()
        });
        let pose = self.inherited_target(prim, "skel:animationSource").map(|source| self.pose(&source));
        let mut now: Vec<Affine> = Vec::with_capacity(joints.len());
        for (i, joint) in joints.iter().enumerate() {
            let local = pose.as_ref().and_then(|pose| pose.joints.get(joint)).copied().unwrap_or(rest[i]);
            now.push(parent(i).map_or(local, |above| now[above] * local));
        }
        let moves =
            now.iter().zip(&bind).map(|(now, bind)| bind.inverse().map_or(*now, |unbound| *now * unbound));
        Some(Skeleton {
            moves: moves.collect(),
            joints,
            weights: pose.map(|pose| pose.weights).unwrap_or_default(),
        })
    }

    fn pose(&self, prim: &Path) -> Pose {
        let reader = self.reader;
        let words = |name: &str| reader.value(prim, name).as_ref().and_then(value::words).unwrap_or_default();
        let joints = words("joints");
        let count = joints.len();
        let vectors = |name: &str, fallback: [f32; 3]| {
            let found = reader.value(prim, name).as_ref().and_then(value::vectors::<3>);
            found.filter(|all| all.len() == count).unwrap_or_else(|| vec![fallback; count])
        };
        let (translations, scales) = (vectors("translations", [0.0; 3]), vectors("scales", [1.0; 3]));
        let rotations = reader.value(prim, "rotations").as_ref().and_then(value::quaternions);
        let rotations =
            rotations.filter(|all| all.len() == count).unwrap_or_else(|| vec![[1.0, 0.0, 0.0, 0.0]; count]);
        let local = |i: usize| {
            let [translation, scale] = [translations[i], scales[i]].map(|v| v.map(f64::from));
            Affine::translation(translation) * rotation(rotations[i]) * Affine::scale(scale)
        };
        let weights = reader.value(prim, "blendShapeWeights").as_ref().and_then(value::floats);
        let weights = weights.map(|(_, weights)| weights).unwrap_or_default();
        Pose {
            joints: joints.iter().cloned().zip((0..count).map(local)).collect(),
            weights: words("blendShapes").into_iter().zip(weights).collect(),
        }
    }
}
