// SPDX-License-Identifier: GPL-3.0-or-later
//! Motion between scenes: one scene at several moments, each loaded by itself.
//! Things are the same by their places in the scenes' lists. Space and units: those of the scenes. Tests: `tests::finds_what_moves`.

use std::sync::Arc;

use super::exposure::Exposure;
use crate::id::{CameraId, InstanceId, LightId, MeshId, ObjectId};
use crate::scene::Scene;

impl Exposure {
    /// The exposure of scenes at evenly spaced moments. Things that come, go or change shape are held as they are first.
    #[must_use]
    pub fn between(times: &[&Scene]) -> Self {
        let mut exposure = Self::default();
        let Some((first, later)) = times.split_first() else { return exposure };
        let lengths = |s: &Scene| {
            [s.meshes().len(), s.objects().len(), s.instances().len(), s.cameras().len(), s.lights().len()]
        };
        if later.iter().any(|scene| lengths(scene) != lengths(first)) {
            exposure.held = 1;
            return exposure;
        }
        let differs = |same: &dyn Fn(&Scene) -> bool| !later.iter().all(|scene| same(scene));
        for (i, mesh) in first.meshes().iter().enumerate() {
            let is_same = |s: &Scene| {
                s.meshes()[i].positions == mesh.positions && s.meshes()[i].normals == mesh.normals
            };
            if !differs(&is_same) {
                continue;
            }
            let fits = |s: &Scene| {
                s.meshes()[i].indices == mesh.indices && s.meshes()[i].positions.len() == mesh.positions.len()
            };
            match differs(&fits) {
                true => exposure.held += 1,
                false => {
                    let all = times.iter().map(|scene| Arc::clone(&scene.meshes()[i])).collect();
                    exposure.meshes.push((MeshId(i as u32), all));
                }
            }
        }
        for (i, object) in first.objects().iter().enumerate() {
            if differs(&|s| s.objects()[i].members.len() == object.members.len()) {
                exposure.held += 1;
                continue;
            }
            for (k, member) in object.members.iter().enumerate() {
                if differs(&|s| s.objects()[i].members[k].object_from_member == member.object_from_member) {
                    let all = times.iter().map(|s| s.objects()[i].members[k].object_from_member).collect();
                    exposure.members.push(((ObjectId(i as u32), k as u32), all));
                }
            }
        }
        for (i, instance) in first.instances().iter().enumerate() {
            if differs(&|s| s.instances()[i].world_from_object == instance.world_from_object) {
                let all = times.iter().map(|s| s.instances()[i].world_from_object).collect();
                exposure.instances.push((InstanceId(i as u32), all));
            }
        }
        for (i, camera) in first.cameras().iter().enumerate() {
            if differs(&|s| s.cameras()[i] == *camera) {
                exposure
                    .cameras
                    .push((CameraId(i as u32), times.iter().map(|s| s.cameras()[i].clone()).collect()));
            }
        }
        for (i, light) in first.lights().iter().enumerate() {
            if differs(&|s| s.lights()[i] == *light) {
                exposure
                    .lights
                    .push((LightId(i as u32), times.iter().map(|s| s.lights()[i].clone()).collect()));
            }
        }
        exposure
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Affine, Mesh};

    #[test]
    fn finds_what_moves() {
        let at = |x: f32, y: f64| {
            let mut scene = Scene::new();
            let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [x, 1.0, 0.0]];
            let mesh = scene.add_mesh(Mesh { positions, indices: vec![[0, 1, 2]], ..Mesh::default() });
            let object = scene.add_object_of("", vec![mesh]);
            scene.instantiate(object, Affine::translation([0.0, y, 0.0]));
            scene.instantiate(object, Affine::IDENTITY);
            scene
        };
        let [a, b, c] = [at(0.0, 0.0), at(1.0, 2.0), at(2.0, 4.0)];
        let exposure = Exposure::between(&[&a, &b, &c]);
        assert_eq!(
            (exposure.meshes.len(), exposure.instances.len(), exposure.held),
            (1, 1, 0),
            "{exposure:?}"
        );
        assert_eq!(exposure.instances[0].1[2].columns[3], [0.0, 4.0, 0.0], "the last moment");
        assert!(Exposure::between(&[&a, &a]).is_still(), "nothing moves");
        let mut more = at(0.0, 0.0);
        more.instantiate(ObjectId(0), Affine::IDENTITY);
        assert_eq!(Exposure::between(&[&a, &more]).held, 1, "something came");
    }
}
