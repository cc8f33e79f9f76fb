// SPDX-License-Identifier: GPL-3.0-or-later
//! Motion by `ActiveTransform`, as a clip from 0 to 1 second: of instances, members of objects and the camera.
//! Source: the section Animating Transformations of the file-format page; parts go straight, turns with constant speed. Transforms
//! that shear have no such parts: things under them stay where they begin, with a warning. Tests: `tests/motion.rs`.

use std::sync::Arc;

use gnurt_scene::animation::{
    Animation, Attachment, Channel, Clip, Interpolation, Local, MovingCamera, MovingInstance, MovingMember,
    Node, Sampler, Target, Trs,
};
use gnurt_scene::{Affine, CameraId, InstanceId, ObjectId};

use crate::transform::{cross, dot};

/// A transform's three parts; `None` if it has others.
fn parts(of: &Affine) -> Option<Trs> {
    let [x, y, z, translation] = of.columns;
    let mut scale = [x, y, z].map(|column| dot(column, column).sqrt());
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return None;
    }
    let mut axes = [x, y, z];
    for (axis, s) in axes.iter_mut().zip(scale) {
        *axis = axis.map(|value| value / s);
    }
    if dot(cross(axes[0], axes[1]), axes[2]) < 0.0 {
        axes[0] = axes[0].map(|value| -value);
        scale[0] = -scale[0];
    }
    let is_square = [(0, 1), (1, 2), (2, 0)].iter().all(|&(a, b)| dot(axes[a], axes[b]).abs() < 1e-5);
    is_square.then(|| Trs { translation, rotation: Some(quaternion(axes)), scale })
}

/// The quaternion of a rotation's columns: x, y, z, w.
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> [f64; 4] {
    let trace = x[0] + y[1] + z[2];
    if trace > 0.0 {
        let w = 0.5 * (trace + 1.0).sqrt();
        return [(y[2] - z[1]) / (4.0 * w), (z[0] - x[2]) / (4.0 * w), (x[1] - y[0]) / (4.0 * w), w];
    }
    let columns = [x, y, z];
    let i = (0..3).max_by(|&a, &b| columns[a][a].total_cmp(&columns[b][b])).unwrap_or(0);
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let large = 0.5 * (1.0 + columns[i][i] - columns[j][j] - columns[k][k]).max(1e-12).sqrt();
    let mut q = [0.0; 4];
    q[i] = large;
    q[j] = (columns[i][j] + columns[j][i]) / (4.0 * large);
    q[k] = (columns[i][k] + columns[k][i]) / (4.0 * large);
    q[3] = (columns[j][k] - columns[k][j]) / (4.0 * large);
    q
}

/// All that moves.
#[derive(Default)]
pub(crate) struct Motion {
    animation: Animation,
    channels: Vec<Channel>,
}

impl Motion {
    /// A node that goes from one transform to the other, on a place of the world; `None` if it cannot.
    fn node(&mut self, world_from_node: Affine, [start, end]: &[Affine; 2]) -> Option<u32> {
        let (from, to) = (parts(start)?, parts(end)?);
        let number = u32::try_from(self.animation.nodes.len()).ok()?;
        let times: Arc<[f32]> = [0.0, 1.0].into();
        let mut drive = |target: Target, values: Vec<f64>, width: usize| {
            let values = values.into_iter().map(|x| x as f32).collect();
            let sampler = Sampler::new(times.clone(), values, width, Interpolation::Linear).ok()?;
            self.channels.push(Channel { target, sampler: Arc::new(sampler) });
            Some(())
        };
        drive(Target::Translation(number), [from.translation, to.translation].concat(), 3)?;
        drive(Target::Rotation(number), [from.rotation?, to.rotation?].concat(), 4)?;
        drive(Target::Scale(number), [from.scale, to.scale].concat(), 3)?;
        self.animation.nodes.push(Node {
            name: String::new(),
            parent: Attachment::Fixed { world_from_node, visible: true },
            rest: Local::Parts(from),
            visible: true,
        });
        Some(number)
    }

    /// Moves an instance; false if it cannot.
    pub(crate) fn instance(&mut self, instance: InstanceId, world: Affine, transforms: &[Affine; 2]) -> bool {
        let node = self.node(world, transforms);
        let moving = node.map(|node| MovingInstance { instance, node, has_transform: true });
        self.animation.instances.extend(moving);
        moving.is_some()
    }

    /// Moves a member of an object; false if it cannot.
    pub(crate) fn member(&mut self, object: ObjectId, member: u32, transforms: &[Affine; 2]) -> bool {
        let node = self.node(Affine::IDENTITY, transforms);
        self.animation.members.extend(node.map(|node| MovingMember { object, member, node }));
        node.is_some()
    }

    /// Moves a camera, whose spaces look along -z; false if it cannot.
    pub(crate) fn camera(&mut self, camera: CameraId, fov_y: f32, transforms: &[Affine; 2]) -> bool {
        let Some(node) = self.node(Affine::IDENTITY, transforms) else { return false };
        let field_of_view = self.animation.fields_of_view.len() as u32;
        self.animation.fields_of_view.push(fov_y.to_radians());
        self.animation.cameras.push(MovingCamera { camera, attachment: Attachment::On(node), field_of_view });
        true
    }

    /// The animation, if something moves.
    pub(crate) fn finish(mut self) -> Option<Animation> {
        if self.channels.is_empty() {
            return None;
        }
        self.animation.clips = vec![Clip { name: "pbrt".into(), channels: self.channels }];
        Some(self.animation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_the_transform_again() {
        let of = Affine::translation([1.0, 2.0, 3.0])
            * Affine::rotation([0.3, -1.0, 0.2], 2.9)
            * Affine::scale([2.0, -0.5, 3.0]);
        let again = parts(&of).expect("parts").affine();
        let near = again
            .columns
            .iter()
            .flatten()
            .zip(of.columns.iter().flatten())
            .all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near, "{again:?} instead of {of:?}");
        let sheared = Affine { columns: [[1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]] };
        assert!(parts(&sheared).is_none());
    }
}
