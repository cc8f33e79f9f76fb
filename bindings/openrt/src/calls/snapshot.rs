// SPDX-License-Identifier: GPL-3.0-or-later
//! What a frame takes along when it starts: the stage brought up to date, shaders, plugins, threads.
//! Source: \[DWBS03\] (frame semantics). Invariant: nothing of it is shared with what the program goes on to edit.
//! Proof: tests/c/scene.c, tests/c/frames.c.

use std::collections::BTreeSet;
use std::sync::Arc;

use gnurt::render::ShaderTable;
use gnurt::scene::RayMask;
use gnurt::shading::classes::Shader as RenderShader;
use gnurt_plugins::host::{FrameState, PluginFrame};

use crate::context::Context;
use crate::frame::{Rendering, told};
use crate::stage::{Shown, Stage, UNNAMED};
use crate::state::class::ClassCode;
use crate::state::enums::MatrixMode;
use crate::state::error::{Error, Result};
use crate::state::instance::Instance;
use crate::state::object::Nested;
use crate::state::progress::Seen;

impl Context {
    /// Frees objects and shaders that were removed and that nothing shows any more.
    pub(super) fn prune(&mut self) {
        if self.objects.has_removed() {
            let alive = self.objects.defined.keys().copied().filter(|&id| self.objects.ids.exists(id));
            let shown = self.instances.iter().map(|i| i.object).chain(alive).collect();
            let shown: BTreeSet<u32> = self.objects.with_held(shown);
            self.objects.prune(|id| shown.contains(&id));
        }
        if !self.shaders.has_deleted() {
            return;
        }
        let of_objects = self.objects.defined.values().flat_map(|object| object.shaders.iter().copied());
        let of_unnamed = self.unnamed.geometry.shaders();
        let used = of_objects.chain(of_unnamed).chain(self.usage.ids()).collect();
        self.shaders.prune(&used);
    }

    /// Brings the stage up to date with the program's objects and instances.
    pub(super) fn update(&mut self, stage: &mut Stage) {
        let unnamed = std::mem::take(&mut self.unnamed).geometry;
        let has_unnamed = !unnamed.is_empty();
        let held = self.objects.held();
        stage.keep_objects(|id| {
            self.objects.defined.contains_key(&id) || held.contains(&id) || id == UNNAMED && has_unnamed
        });
        for (&id, object) in &mut self.objects.defined {
            if let Some(meshes) = object.fresh.take() {
                let member = |nested: &Nested| Shown {
                    object: nested.object,
                    world_from_object: nested.object_from_nested.to_affine(),
                    mask: RayMask(nested.mask),
                };
                stage.define(id, meshes, object.nested.iter().map(member));
            }
        }
        if has_unnamed {
            stage.define(UNNAMED, unnamed.finish(), std::iter::empty());
        }
        let place = |instance: &Instance| Shown {
            object: instance.object,
            world_from_object: instance.world_from_object.to_affine(),
            mask: RayMask(instance.mask),
        };
        let changes = self.instances.take_changes();
        let all = self.instances.entries().map(|(id, instance)| (id, place(instance)));
        let changed = changes.ids.iter().map(|&id| (id, self.instances.get(id).map(place)));
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
            for (place, id) in stage.places() {
                let Some(instance) = self.instances.get(id) else { continue };
                ids.resize(ids.len().max(place + 1), [UNNAMED; 2]);
                ids[place] = [instance.object, id];
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
        let pool =
            Arc::new(gnurt::JoinedPool::new(self.threads).map_err(|error| told(&error, Error::OutOfMemory))?);
        self.pool = Some(pool.clone());
        Ok(pool)
    }

    /// Whether the frame that starts shows what the last one showed, so that their samples may be added.
    pub(super) fn continues(&mut self, stage: &Stage, size: [u32; 2]) -> bool {
        if !self.sampling.progressive {
            self.seen = None;
            return false;
        }
        let now = Seen {
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
        let continues = self.seen.as_ref() == Some(&now);
        self.seen = Some(now);
        continues
    }
}
