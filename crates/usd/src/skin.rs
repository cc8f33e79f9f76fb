// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes that blend shapes and joints bend.
//! Source: UsdSkel: shapes first, then the linear blend of joints, in the space of the skeleton. Tests: `tests/skeletons.rs`.

use gnurt_scene::io::Oddity;
use gnurt_scene::{Affine, ObjectId};
use openusd::sdf::Path;

use crate::bent::Bent;
use crate::builder::{Builder, State};
use crate::pose::Skeleton;
use crate::value;

/// The result of skinning a mesh.
pub(crate) enum Skinned {
    /// Nothing bends it.
    Not,
    /// It is there.
    At(ObjectId, Affine),
    /// There is nothing to show.
    Nothing,
}

impl Builder<'_> {
    /// A mesh that is bound to a skeleton.
    pub(crate) fn skinned_mesh(&mut self, prim: &Path, state: &State) -> Skinned {
        let reader = self.reader;
        let Some(path) = self.inherited_target(prim, "skel:skeleton") else { return Skinned::Not };
        let has_joints = self.inherited_value(prim, "primvars:skel:jointIndices").is_some();
        let shapes = reader.targets(prim, "skel:blendShapeTargets");
        if !has_joints && shapes.is_empty() {
            return Skinned::Not;
        }
        let Some(skeleton) = self.skeleton(&path) else { return Skinned::Not };
        let Some(polygons) = self.polygons(prim) else { return Skinned::Nothing };
        let mut points = polygons.points;
        self.blend(prim, &skeleton, &shapes, &mut points);
        let mut rotations = Vec::new();
        let mut transform = state.world_from_parent;
        if has_joints {
            match self.bend(prim, &skeleton, &mut points) {
                Some(found) => {
                    rotations = found;
                    // Points are now in the space of the skeleton.
                    let [mesh, skeleton] = [prim, &path].map(|prim| self.chain(prim));
                    transform = match mesh.inverse() {
                        Some(unplaced) => transform * unplaced * skeleton,
                        None => transform,
                    };
                }
                None => return Skinned::Not,
            }
        }
        match self.mesh(prim, Some(Bent { points, rotations })) {
            Some(object) => Skinned::At(object, transform),
            None => Skinned::Nothing,
        }
    }

    /// An attribute of a prim or of the nearest prim above it.
    fn inherited_value(&self, prim: &Path, name: &str) -> Option<(Path, openusd::sdf::Value)> {
        prim.ancestors_below_root().find_map(|above| Some((above.clone(), self.reader.value(&above, name)?)))
    }

    /// The product of all transforms of a prim and of those above it.
    fn chain(&self, prim: &Path) -> Affine {
        let mut product = Affine::IDENTITY;
        for above in prim.ancestors_below_root() {
            let local = self.reader.local(&above);
            product = local.parent_from_prim * product;
            if local.resets {
                break;
            }
        }
        product
    }

    /// Moves points by joints; returns the matrix of each point's normals. `None` where the mesh's joints are missing or wrong.
    fn bend(&self, prim: &Path, skeleton: &Skeleton, points: &mut [[f32; 3]]) -> Option<Vec<[[f32; 3]; 3]>> {
        let reader = self.reader;
        let (owner, indices) = self.inherited_value(prim, "primvars:skel:jointIndices")?;
        let indices = value::integers(&indices)?;
        let (_, weights) = self.inherited_value(prim, "primvars:skel:jointWeights")?;
        let (_, weights) = value::floats(&weights)?;
        let metadata = |key: &str| reader.metadata(&owner, "primvars:skel:jointIndices", key);
        let each = metadata("elementSize").as_ref().and_then(value::number).unwrap_or(1.0).max(1.0) as usize;
        let is_rigid =
            metadata("interpolation").as_ref().and_then(value::word).is_some_and(|word| word == "constant");
        let needed = if is_rigid { each } else { each.saturating_mul(points.len()) };
        if indices.len() < needed || weights.len() < needed {
            let fault = format!(
                "{} joint indices and {} weights, the mesh needs {needed}",
                indices.len(),
                weights.len()
            );
            reader.note(Oddity::BadAttribute, prim, fault);
            return None;
        }
        if reader.word(prim, "primvars:skel:skinningMethod").is_some_and(|method| method != "classicLinear") {
            reader.unsupported(prim, "skinning by dual quaternions, shown as linear");
        }
        let own =
            self.inherited_value(prim, "skel:joints").as_ref().and_then(|(_, value)| value::words(value));
        let joint = |index: i32| {
            let index = usize::try_from(index).ok()?;
            let index = match &own {
                Some(own) => skeleton.joints.iter().position(|joint| Some(joint) == own.get(index))?,
                None => index,
            };
            skeleton.moves.get(index)
        };
        let bound = self.inherited_value(prim, "primvars:skel:geomBindTransform");
        let bound = bound.as_ref().and_then(|(_, value)| value::matrices(value));
        let bound =
            bound.and_then(|all| all.first().map(Affine::from_column_major)).unwrap_or(Affine::IDENTITY);
        let mut rotations = Vec::with_capacity(points.len());
        let mut is_lost = false;
        for (i, point) in points.iter_mut().enumerate() {
            let range = if is_rigid { 0..each } else { i * each..(i + 1) * each };
            let mut blend = Affine { columns: [[0.0; 3]; 4] };
            let mut sum = 0.0;
            for (&index, &weight) in indices[range.clone()].iter().zip(&weights[range]) {
                if weight == 0.0 {
                    continue;
                }
                let Some(moved) = joint(index) else {
                    is_lost = true;
                    continue;
                };
                sum += f64::from(weight);
                for (to, from) in
                    blend.columns.as_flattened_mut().iter_mut().zip(moved.columns.as_flattened())
                {
                    *to += f64::from(weight) * from;
                }
            }
            if sum == 0.0 {
                blend = Affine::IDENTITY;
            }
            let whole = blend * bound;
            *point = whole.point(point.map(f64::from)).map(|x| x as f32);
            let [a, b, c, _] = whole.to_f32();
            rotations.push([a, b, c]);
        }
        if is_lost {
            reader.note(Oddity::BadAttribute, prim, "joint indices that the skeleton does not have");
        }
        Some(rotations)
    }

    /// Adds the offsets of blend shapes.
    fn blend(&self, prim: &Path, skeleton: &Skeleton, shapes: &[Path], points: &mut [[f32; 3]]) {
        let reader = self.reader;
        let names =
            reader.value(prim, "skel:blendShapes").as_ref().and_then(value::words).unwrap_or_default();
        for (name, shape) in names.iter().zip(shapes) {
            let weight = skeleton.weights.get(name).copied().unwrap_or(0.0);
            if weight == 0.0 || !weight.is_finite() {
                continue;
            }
            let indices = reader.value(shape, "pointIndices").as_ref().and_then(value::integers);
            let index = |i: usize| match &indices {
                Some(indices) => indices.get(i).and_then(|&index| usize::try_from(index).ok()),
                None => Some(i),
            };
            for (offsets, share) in self.shares(shape, weight) {
                for (i, offset) in offsets.iter().enumerate() {
                    if let Some(point) = index(i).and_then(|index| points.get_mut(index)) {
                        (0..3).for_each(|k| point[k] += share * offset[k]);
                    }
                }
            }
        }
    }

    /// The offsets that a weight of a shape adds, and how much of each: the shape's own at 1, those between at theirs, none at 0.
    fn shares(&self, shape: &Path, weight: f32) -> Vec<(Vec<[f32; 3]>, f32)> {
        let reader = self.reader;
        let offsets =
            |name: &str| reader.value(shape, name).as_ref().and_then(value::vectors::<3>).unwrap_or_default();
        let mut keys = vec![(0.0, String::new()), (1.0, "offsets".to_owned())];
        for name in reader.properties(shape).iter().filter(|name| name.starts_with("inbetweens:")) {
            let at = reader.metadata(shape, name, "weight").as_ref().and_then(value::number);
            if let Some(at) = at.filter(|_| !name.ends_with(":normalOffsets")) {
                keys.push((at as f32, name.clone()));
            }
        }
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        let upper = keys.iter().position(|(at, _)| *at >= weight).unwrap_or(keys.len() - 1).max(1);
        let ((low, before), (high, after)) = (&keys[upper - 1], &keys[upper]);
        let t = if high > low { (weight - low) / (high - low) } else { 1.0 };
        [(before, 1.0 - t), (after, t)]
            .into_iter()
            .filter(|(name, share)| !name.is_empty() && *share != 0.0)
            .map(|(name, share)| (offsets(name), share))
            .collect()
    }
}
