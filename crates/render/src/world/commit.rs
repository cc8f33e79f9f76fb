// SPDX-License-Identifier: GPL-3.0-or-later
//! Commit: from a description to a world, with only the necessary work. The scene's log lists the edits since
//! the last commit; each edit affects its part of the world, and the parts that depend on it (the table in
//! ARCHITECTURE.md). Parts are shared: a commit works on a copy of the world that shares all parts, replaces
//! the affected ones, and stores the copy at the end. Invariants: a clone of the world before is not touched;
//! after an error, or a panic, neither is the world.
//! Tests: `crates/render/tests/{commit,edits}.rs`.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use gnurt_scene::animation::Exposure;
use gnurt_scene::{Affine, Scene};
use gnurt_shading::ColorMap;

use super::dirty::{DirtyParts, Displaced};
use super::instance::InstanceSlot;
use super::labels::{self, WorldLabels};
use super::lights::{ChangedLights, order_in_set};
use super::media::Media;
use super::open::{Open, Shutter};
use super::table::{CommitOptions, CommitReport, ShaderTable};
use super::{Dropped, Followed, World, check, members, object_build, top, users};
use crate::error::CommitError;
use crate::mattes::ids_of_instance;

impl World {
    /// Brings the world up to date with `scene`. A world follows one scene: a commit rebuilds only the parts
    /// edited since the last one; for another scene, or with other options, it rebuilds all. Bad primitives
    /// and instances are dropped and counted.
    ///
    /// # Errors
    /// [`CommitError`] if the scene refers to missing things; the world stays as it was.
    pub fn commit(
        &mut self,
        scene: &Scene,
        shaders: &ShaderTable,
        options: &CommitOptions,
        pool: &rayon::ThreadPool,
    ) -> Result<CommitReport, CommitError> {
        self.commit_exposed(scene, &Exposure::default(), shaders, options, pool)
    }

    /// The same for an open shutter: the contents of `exposure` move during the picture, and the scene shows
    /// the state at its opening. Trees of deforming meshes are built at each commit. An instance that is flat
    /// at some time keeps the transform of the scene; ids outside of the scene are skipped.
    ///
    /// # Errors
    /// As [`commit`](Self::commit).
    pub fn commit_exposed(
        &mut self,
        scene: &Scene,
        exposure: &Exposure,
        shaders: &ShaderTable,
        options: &CommitOptions,
        pool: &rayon::ThreadPool,
    ) -> Result<CommitReport, CommitError> {
        let start = Instant::now();
        let followed = self.follows.as_ref();
        let followed = followed.filter(|it| it.options.serves(options) && it.identity == *scene.identity());
        let options = &followed.map_or(*options, |followed| followed.options);
        let (mut world, mut dirty) = match followed {
            Some(followed) => {
                let mut dirty = DirtyParts::since(followed.cursor, scene, &self.materials, shaders);
                dirty.displaced(&followed.displaced, scene, shaders);
                (self.clone(), dirty)
            }
            None => (Self::new(), DirtyParts::everything(scene)),
        };
        let mut open = Open::new(scene, exposure);
        dirty.open(&open);
        if let Some(before) = &world.open {
            dirty.open(before);
        }
        dirty.objects.retain(|&id| (id as usize) < scene.objects().len());
        dirty.instances.retain(|&id| (id as usize) < scene.instances().len());
        check::check(scene, shaders, &dirty)?;
        let mut report = CommitReport::default();
        let is_first = followed.is_none();
        world.update(is_first, &dirty, (scene, exposure), shaders, options, pool, &mut report);
        world.shutter = Shutter::Closed;
        world.pixel.clone_from(&shaders.pixel);
        open.lights_move = world.lights.emitters.move_in(&world.instances);
        world.open = (!exposure.is_still()).then(|| Arc::new(open));
        world.follows = Some(Followed {
            identity: scene.identity().clone(),
            cursor: scene.cursor(),
            options: *options,
            displaced: Displaced::of(scene, shaders),
        });
        *self = world;
        report.dropped_triangles = self.dropped.triangles;
        report.dropped_instances = self.dropped.instances + self.tree.dropped_instances() as usize;
        report.build_seconds = start.elapsed().as_secs_f64();
        Ok(report)
    }

    #[expect(clippy::too_many_arguments, reason = "the arguments of `commit`, and what it has found out")]
    fn update(
        &mut self,
        is_first: bool,
        dirty: &DirtyParts,
        (scene, exposure): (&Scene, &Exposure),
        shaders: &ShaderTable,
        options: &CommitOptions,
        pool: &rayon::ThreadPool,
        report: &mut CommitReport,
    ) {
        self.face_normals = options.force_diffuse;
        let mut emission_changed = false;
        if !dirty.materials.is_empty() {
            let materials = Arc::make_mut(&mut self.materials);
            let changed = materials.update(&dirty.materials, scene, shaders, options);
            (report.made_shaders, emission_changed) = (changed.made, changed.emission);
        }

        if !dirty.materials.is_empty() || !dirty.media.is_empty() {
            let media = Media::new(scene, shaders, &self.media, ColorMap::to(options.space));
            if !(media.is_empty() && self.media.is_empty()) {
                self.media = Arc::new(media);
            }
        }

        let Geometry { changed, is_moved } =
            self.update_geometry(dirty, (scene, exposure), shaders, options, pool, report);
        let tree_before = self.tree.clone();
        if is_moved {
            self.tree = top::after(&self.tree, scene, &self.instances, &changed, pool);
            report.built_top_tree = true;
        }

        let lights = &self.lights;
        let emitters = &lights.emitters;
        let found = emitters.after(&changed, emission_changed, self.shown(pool));
        let is_numbered = || emitters.ids.is_empty() || tree_before.numbers_alike(&self.tree);
        let emitters =
            found.or_else(|| (!is_numbered()).then(|| emitters.renumbered(&tree_before, &self.tree)));
        report.found_emitters = emitters.is_some();
        let bounds = self.tree.bounds();
        let changed = ChangedLights {
            edited: is_first || !dirty.lights.is_empty() || !dirty.textures.is_empty(),
            emitters,
            bounds: [bounds.min, bounds.max].map(Vec3::from),
        };
        if let Some(lights) = lights.after(changed, scene, shaders, pool, ColorMap::to(options.space)) {
            report.made_lights = true;
            self.lights = Arc::new(lights);
        }
        if is_first || report.made_lights || !dirty.materials.is_empty() {
            let emissive = &self.lights.emitters.instances;
            self.labels = Arc::new(WorldLabels::new(scene, &order_in_set(scene), emissive));
        }
        self.names = labels::names(scene, &self.materials, shaders.pixel.as_deref(), self.names.take());
    }

    /// Objects and instances.
    fn update_geometry(
        &mut self,
        dirty: &DirtyParts,
        (scene, exposure): (&Scene, &Exposure),
        shaders: &ShaderTable,
        options: &CommitOptions,
        pool: &rayon::ThreadPool,
        report: &mut CommitReport,
    ) -> Geometry {
        // Instances to process: hidden ones that stay hidden are absent.
        let slot = |id: u32| self.instances.get(id as usize);
        let object_before = |id: u32| slot(id).and_then(InstanceSlot::object);
        let is_visible = |id: &u32| scene.instances()[*id as usize].visible || object_before(*id).is_some();
        let mut changed: Vec<u32> = dirty.instances.iter().copied().filter(is_visible).collect();
        let mut is_moved = !changed.is_empty();

        let mut dirty_objects = dirty.objects.clone();
        if !changed.is_empty() || !dirty_objects.is_empty() {
            let objects = Arc::make_mut(&mut self.objects);
            objects.grow(scene.objects().len());
            for &id in &changed {
                let now = &scene.instances()[id as usize];
                let now = now.visible.then_some(now.object);
                let before = self.instances.get(id as usize).and_then(InstanceSlot::object);
                if before == now {
                    continue;
                }
                if let Some(now) = now {
                    users::retain(objects, scene, now.0, &mut dirty_objects);
                }
                if let Some(before) = before {
                    users::release(objects, before.0, &mut dirty_objects);
                }
            }
            for &id in &dirty.objects {
                if objects[id as usize].users > 0 {
                    users::hold(objects, scene, id, &mut dirty_objects);
                }
            }
            dirty_objects.sort_unstable();
            dirty_objects.dedup();
            let before = objects.clone();
            let mut rebuilt = object_build::update(
                objects,
                &self.crowds,
                &dirty_objects,
                (scene, exposure),
                shaders,
                object_build::build_options(options),
                pool,
            );
            report.warnings.append(&mut rebuilt.warnings);
            members::update(objects, &before, &dirty_objects, (scene, exposure), pool, &mut rebuilt);
            let mut touched = [&dirty_objects[..], &rebuilt.ids].concat();
            touched.sort_unstable();
            touched.dedup();
            for &id in &touched {
                self.dropped += Dropped::of(&objects[id as usize]);
                self.dropped -= Dropped::of(&before[id as usize]);
            }
            (report.built_objects, report.refitted_objects) = (rebuilt.built, rebuilt.refitted);
            is_moved |= rebuilt.reshaped;
            if !rebuilt.ids.is_empty() {
                // Instances that show it hold it.
                let shows = |slot: &InstanceSlot| {
                    slot.object().is_some_and(|object| rebuilt.ids.binary_search(&object.0).is_ok())
                };
                let more = (0..).zip(self.instances.iter()).filter(|(_, slot)| shows(slot));
                changed.extend(more.map(|(id, _)| id));
                changed.sort_unstable();
                changed.dedup();
            }
        }

        if let Some(&last) = changed.last() {
            let before = self.instances.clone();
            let instances = Arc::make_mut(&mut self.instances);
            instances.grow(last as usize + 1);
            let objects = &self.objects;
            let paths: HashMap<u32, &[Affine]> =
                exposure.instances.iter().map(|(id, positions)| (id.0, &positions[..])).collect();
            let index = |id: usize| {
                let (instance, id) = (&scene.instances()[id], id as u32);
                let mattes = ids_of_instance(scene, id, instance);
                InstanceSlot::new(instance, objects, paths.get(&id).copied(), mattes)
            };
            pool.install(|| instances.set_all(&changed, true, index));
            let is_dropped =
                |slot: Option<&InstanceSlot>| usize::from(slot.is_some_and(InstanceSlot::is_dropped));
            for &id in &changed {
                self.dropped.instances += is_dropped(instances.get(id as usize));
                self.dropped.instances -= is_dropped(before.get(id as usize));
            }
            report.placed_instances = changed.len();
        }
        Geometry { changed, is_moved }
    }
}

/// Changes of objects and instances.
struct Geometry {
    /// Instances that were placed again, ascending.
    changed: Vec<u32>,
    /// Whether the traced geometry, or its transform, may have changed.
    is_moved: bool,
}
