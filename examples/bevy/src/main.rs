// SPDX-License-Identifier: GPL-3.0-or-later
//! Picking in Bevy: the entity below a ray, among instances of shared meshes.
//! A mesh is built once; each frame the tree over its instances follows the transforms. Run: `cargo run --release`.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_math::{Ray3d, Vec3};
use bevy_transform::components::GlobalTransform;
use gnurt_accel::{BuildOptions, Instance, ObjectTree, Ray, SceneTree, Threads, Triangles};

/// A mesh that can be picked; entities share it.
#[derive(Component, Clone)]
struct PickMesh(Arc<ObjectTree>);

/// The tree over all entities with a mesh, and the entities by instance.
#[derive(Resource, Default)]
struct Picker {
    tree: Option<SceneTree>,
    entities: Vec<Entity>,
}

/// An answer of the picker.
#[derive(Debug, PartialEq)]
struct Picked {
    entity: Entity,
    distance: f32,
    triangle: u32,
}

impl Picker {
    /// The first entity along a ray.
    fn pick(&self, ray: Ray3d) -> Option<Picked> {
        let hit = self.tree.as_ref()?.intersect(&Ray::new(ray.origin.to_array(), ray.direction.to_array()))?;
        let entity = self.entities[hit.inst_id as usize];
        Some(Picked { entity, distance: hit.t, triangle: hit.prim_id })
    }
}

/// Follows the transforms. Building over instances takes less than a millisecond for thousands.
fn follow(
    mut picker: ResMut<Picker>,
    shown: Query<(Entity, &PickMesh, &GlobalTransform)>,
    changed: Query<(), Or<(Changed<GlobalTransform>, Changed<PickMesh>)>>,
    removed: RemovedComponents<PickMesh>,
) {
    if changed.is_empty() && removed.is_empty() {
        return;
    }
    let (mut instances, mut entities) = (Vec::new(), Vec::new());
    for (entity, mesh, transform) in &shown {
        let affine = transform.affine();
        let columns = [affine.x_axis, affine.y_axis, affine.z_axis, affine.translation];
        let columns = columns.map(|column| Vec3::from(column).as_dvec3().to_array());
        instances.push(Instance::new(mesh.0.clone(), columns));
        entities.push(entity);
    }
    picker.tree = Some(SceneTree::build(&instances, &BuildOptions::default(), Threads::Single));
    picker.entities = entities;
}

/// A cube around the origin, of side 1.
fn cube() -> ObjectTree {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|side| side as f32 - 0.5);
    let positions: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let indices: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = Triangles { positions: &positions, indices: &indices };
    ObjectTree::build(&[mesh], &BuildOptions::default(), Threads::Single)
}

fn main() {
    let mut world = World::new();
    world.init_resource::<Picker>();
    let mesh = PickMesh(Arc::new(cube()));
    let place = |x: f32| GlobalTransform::from_translation(Vec3::new(x, 0.0, 0.0));
    let cubes: Vec<Entity> =
        (0..100).map(|i| world.spawn((mesh.clone(), place(2.0 * i as f32))).id()).collect();
    let mut schedule = Schedule::default();
    schedule.add_systems(follow);
    schedule.run(&mut world);

    // In a game: camera.viewport_to_world(transform, cursor).
    let ray = Ray3d::new(Vec3::new(6.2, 0.1, 5.0), bevy_math::Dir3::NEG_Z);
    let picked = world.resource::<Picker>().pick(ray).expect("cube 3 is below");
    println!("{picked:?}");
    assert_eq!((picked.entity, picked.distance), (cubes[3], 4.5));

    // A moved entity is found at its new place.
    *world.get_mut::<GlobalTransform>(cubes[3]).expect("it exists") = place(-20.0);
    schedule.run(&mut world);
    assert_eq!(world.resource::<Picker>().pick(ray), None);
    let ray = Ray3d::new(Vec3::new(-20.0, 0.1, 5.0), bevy_math::Dir3::NEG_Z);
    assert_eq!(world.resource::<Picker>().pick(ray).map(|picked| picked.entity), Some(cubes[3]));
}
