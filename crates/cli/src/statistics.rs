// SPDX-License-Identifier: GPL-3.0-or-later
//! Counts and times of a rendering, as a table for people and as JSON for programs. Times are wall-clock
//! seconds, sizes bytes. Invariant: the JSON holds no NaN and no infinity.
//! Tests: `tests/program/statistics.rs`.

use std::fmt;
use std::path::Path;

use gnurt::render::{CommitReport, RenderOptions, RenderStats, WorldStats};
use serde_json::{Value, json};

use gnurt::memory::format_bytes as bytes;

/// All that is known about a rendering.
pub(crate) struct Statistics<'a> {
    pub(crate) scene: String,
    pub(crate) picture: &'a Path,
    pub(crate) options: &'a RenderOptions,
    pub(crate) world: WorldStats,
    pub(crate) report: CommitReport,
    pub(crate) render: &'a RenderStats,
    pub(crate) load_seconds: f64,
    pub(crate) total_seconds: f64,
}

impl Statistics<'_> {
    /// Rays per second of rendering.
    fn rays_per_second(&self) -> f64 {
        self.render.rays() as f64 / self.render.seconds.max(1e-9)
    }

    /// One JSON object.
    pub(crate) fn to_json(&self) -> Value {
        let Self { options, world, report, render, .. } = self;
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": self.scene,
            "output": self.picture.display().to_string(),
            "width": options.width,
            "height": options.height,
            "spp": options.spp,
            "spp_done_min": render.spp_min,
            "spp_done_max": render.spp_max,
            "complete": render.complete,
            "seed": options.seed,
            "integrator": options.integrator.name(),
            "filter": options.filter.name(),
            "isa": options.level.name(),
            "threads": render.threads,
            "seconds": {
                "load": self.load_seconds,
                "build": report.build_seconds,
                "render": render.seconds,
                "total": self.total_seconds,
            },
            "rays": {
                "camera": render.camera_rays,
                "shadow": render.shadow_rays,
                "secondary": render.secondary_rays,
                "total": render.rays(),
                "per_second": self.rays_per_second(),
            },
            "gather": { "rays": render.gather_rays, "seconds": render.gather_seconds },
            "choice": render.choice.map(|choice| json!({
                "integrator": choice.integrator.name(),
                "virtual_lights": choice.virtual_lights,
                "methods": choice.methods.map(|methods| methods.map(|method| json!({
                    "variance": method.variance,
                    "cost": method.cost,
                    "mean": method.mean,
                    "mean_error": method.mean_error,
                }))),
                "seconds": choice.seconds,
            })),
            "guide": render.guide.map(|guide| json!({
                "on": guide.is_on,
                "moment": guide.moment,
                "vertices": guide.vertices,
                "cells": guide.cells,
                "nodes": guide.nodes,
                "bytes": guide.bytes,
                "seconds": guide.seconds,
            })),
            "samples": render.samples,
            "bad_samples": render.bad_samples,
            "nodes_visited": render.nodes_visited,
            "triangles_tested": render.triangles_tested,
            "world": {
                "triangles": world.triangles,
                "instanced_triangles": world.instanced_triangles,
                "objects": world.objects,
                "instances": world.instances,
                "tree_nodes": world.tree_nodes,
                "tree_bytes": world.tree_bytes,
                "array_bytes": world.array_bytes,
                "dropped_triangles": report.dropped_triangles,
                "dropped_instances": report.dropped_instances,
            },
        })
    }
}

impl fmt::Display for Statistics<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { options, world, report, render, .. } = self;
        let per_ray = |count: u64| count as f64 / (render.rays() as f64).max(1.0);
        let mut row = |name: &str, value: String| writeln!(f, "{name:<18}{value}");
        row("scene", self.scene.clone())?;
        row("triangles", format!("{} ({} with instances)", world.triangles, world.instanced_triangles))?;
        row("objects", format!("{}, {} instances", world.objects, world.instances))?;
        row(
            "left out",
            format!("{} triangles, {} instances", report.dropped_triangles, report.dropped_instances),
        )?;
        row("arrays", bytes(world.array_bytes as u64))?;
        row("trees", format!("{} nodes, {}", world.tree_nodes, bytes(world.tree_bytes as u64)))?;
        row(
            "picture",
            format!(
                "{}x{}, {} to {} samples per pixel",
                options.width, options.height, render.spp_min, render.spp_max
            ),
        )?;
        row("machine", format!("{} threads, {}", render.threads, options.level))?;
        row("camera rays", render.camera_rays.to_string())?;
        row("shadow rays", render.shadow_rays.to_string())?;
        row("secondary rays", render.secondary_rays.to_string())?;
        if let Some(choice) = &render.choice {
            row("integrator", choice.to_string())?;
        }
        if let Some(guide) = &render.guide {
            row("guide", guide.to_string())?;
        }
        row("nodes per ray", format!("{:.2}", per_ray(render.nodes_visited)))?;
        row("triangles per ray", format!("{:.2}", per_ray(render.triangles_tested)))?;
        row("rays per second", format!("{:.3e}", self.rays_per_second()))?;
        row("load", format!("{:.3} s", self.load_seconds))?;
        row("build", format!("{:.3} s", report.build_seconds))?;
        row("render", format!("{:.3} s", render.seconds))?;
        write!(f, "{:<18}{:.3} s", "total", self.total_seconds)
    }
}
