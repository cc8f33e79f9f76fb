// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of a frame at its start: the updated stage, shaders, plugins, threads.
//! Source: \[DWBS03\] (frame semantics). Invariant: later edits of the program affect nothing of it.
//! Tests: tests/c/scene.c, tests/c/frames.c.

use std::sync::Arc;

use gnurt::render::ShaderTable;
use gnurt::scene::RayMask;
use gnurt::shading::classes::Shader as RenderShader;
use gnurt_plugins::host::{FrameState, PluginFrame};

use crate::context::Context;
use crate::frame::{Rendering, reported};
use crate::stage::{Shown, Stage, UNNAMED};
use crate::state::class::ClassCode;
use crate::state::enums::MatrixMode;
use crate::state::error::{Error, Result};
use crate::state::instance::Instance;
use crate::state::object::Nested;
use crate::state::progress::Recorded;

impl Context {
    /// Frees objects and shaders that were removed and that nothing shows any more.
    pub(super) fn prune(&mut self) {
        if self.objects.has_removed() {
            self.objects.prune(|id| self.instances.show(id));
        }
        self.shaders.end_blocks();
        if !self.shaders.has_deleted() {
            return;
        }
        let of_objects = self.objects.definitions().flat_map(|object| object.shaders.iter().copied());
        let of_unnamed = self.unnamed.geometry.shaders();
        let used = of_objects.chain(of_unnamed).chain(self.usage.ids()).collect();
        self.shaders.prune(&used);
        self.shaders.end_blocks();
    }

    /// Brings the stage up to date with the program's objects and instances. Checks only those that were
    /// edited.
    pub(super) fn update(&mut self, stage: &mut Stage) {
        let unnamed = std::mem::take(&mut self.unnamed).geometry;
        let has_unnamed = !unnamed.is_empty();
        for id in self.objects.take_left() {
            if !self.objects.is_needed(id) {
                stage.free_object(id);
            }
        }
        if !has_unnamed {
            stage.free_object(UNNAMED);
        }
        self.objects.take_fresh(|id, meshes, nested| {
            let member = |nested: &Nested| Shown {
                object: nested.object,
                world_from_object: nested.object_from_nested.to_affine(),
                mask: RayMask(nested.mask),
            };
            stage.define(id, meshes, nested.iter().map(member));
        });
        if has_unnamed {
            stage.define(UNNAMED, unnamed.finish(), std::iter::empty());
        }
        let position = |instance: &Instance| Shown {
            object: instance.object,
            world_from_object: instance.world_from_object.to_affine(),
            mask: RayMask(instance.mask),
        };
        let changes = self.instances.take_changes();
        let all = self.instances.entries().map(|(id, instance)| (id, position(instance)));
        let changed = changes.ids.iter().map(|&id| (id, self.instances.get(id).map(position)));
        if changes.any {
            stage.show_all(all);
        } else {
            stage.show(changed, all);
        }
        stage.show_unnamed(has_unnamed);
    }

    /// All shaders in use, with their present values.
    pub(super) fn shader_table(&mut self, stage: &mut Stage, plugins: &PluginFrame) -> ShaderTable {
        let mut table = stage.surfaces(&mut self.shaders, &self.textures, plugins);
        for id in self.usage.ids() {
            let shader = self.shaders.in_use_mut(id);
            match shader.and_then(|shader| shader.make(id, &self.textures, plugins)) {
                Some(RenderShader::Light(light)) => table.lights.push(light),
                Some(RenderShader::Camera(camera)) => table.camera = Some(camera),
                Some(RenderShader::Environment(environment)) => table.environment = Some(environment),
                Some(RenderShader::Pixel(pixel)) => table.pixel = Some(pixel),
                Some(RenderShader::Surface(_)) | None => {}
            }
        }
        table
    }

    /// The plugins among the shaders in use, prepared for a frame.
    pub(super) fn plugins(&self, stage: &Stage) -> PluginFrame {
        let ids = stage.shader_ids().chain(self.usage.ids());
        let blocks = ids.filter_map(|id| Some((id, self.shaders.in_use(id)?.block.as_ref()?)));
        PluginFrame::new(blocks, || {
            let sampler = |id: u32| Some((id, self.textures.sampler(i32::try_from(id).ok()?)?));
            let textures = self.textures.ids().filter_map(sampler).collect();
            let mut ids = Vec::new();
            for (position, id) in stage.places() {
                let Some(instance) = self.instances.get(id) else { continue };
                ids.resize(ids.len().max(position + 1), [UNNAMED; 2]);
                ids[position] = [instance.object, id];
            }
            FrameState { textures, ids, third_texcoords: stage.has_third_texcoords() }
        })
    }

    /// The rendering object in use.
    pub(super) fn rendering(&self) -> Option<Rendering> {
        let shader = self.shaders.in_use(self.usage.rendering_object?)?;
        match &shader.class.code {
            ClassCode::Rendering(class) => Some((class, shader.values.clone())),
            _ => None,
        }
    }

    /// The threads, made when the first frame needs them.
    pub(super) fn pool(&mut self) -> Result<Arc<gnurt::JoinedPool>> {
        if let Some(pool) = &self.pool {
            return Ok(pool.clone());
        }
        let pool = Arc::new(
            gnurt::JoinedPool::new(self.threads).map_err(|error| reported(&error, Error::OutOfMemory))?,
        );
        self.pool = Some(pool.clone());
        Ok(pool)
    }

    /// Whether the starting frame shows the same as the last one, so that their samples may be added.
    pub(super) fn continues(&mut self, stage: &Stage, size: [u32; 2]) -> bool {
        if !self.sampling.progressive {
            self.recorded = None;
            return false;
        }
        let now = Recorded {
            scene: stage.scene.cursor(),
            shaders: self
                .shaders
                .iter()
                .map(|(id, shader)| {
                    (id, shader.values.clone(), shader.block.as_ref().map(|block| block.version()))
                })
                .collect(),
            textures: self.textures.revision(),
            usage: self.usage.clone(),
            view: self.view,
            projection: self.stacks.top(MatrixMode::Projection),
            limits: self.limits,
            size,
        };
        let continues = self.recorded.as_ref() == Some(&now);
        self.recorded = Some(now);
        continues
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    /// How long a frame takes to see one edit of this many objects: the shortest of several times.
    fn one_edit(objects: i32) -> Duration {
        let mut context = Context::default();
        let first = context.gen_objects(objects).expect("ids");
        for id in first..first + objects as u32 {
            context.new_object(id, 0x201).expect("it is new");
            context.end_object().expect("it is open");
        }
        let mut stage = Stage::default();
        context.prune();
        context.update(&mut stage);
        let edit = |i: u32| {
            // One is redefined, one holds another, one is removed and still shown.
            context.new_object(first + i, 0x200).expect("it is there");
            context.nest_object(first + i + 20, u32::MAX).expect("it is there");
            context.end_object().expect("it is open");
            context.remove_object(first + i + 40).expect("it is there");
            let start = Instant::now();
            context.prune();
            context.update(&mut stage);
            start.elapsed()
        };
        (0..20).map(edit).min().expect("some")
    }

    #[test]
    fn frames_cost_what_was_edited() {
        let (few, many) = (one_edit(500), one_edit(50_000));
        assert!(many < 20 * few, "{many:?} for one edit among 100 times as many objects, not {few:?}");
    }
}
