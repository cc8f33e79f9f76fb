// SPDX-License-Identifier: GPL-3.0-or-later
//! Measurements of moving scenes, as plain values, as a table and as JSON.
//! Tests: `dynamic::tests::a_box_is_twisted`, `crowd::tests`.

use serde_json::{Value, json};

/// One strategy's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct DynamicRow {
    /// `refit`, `rebuild`, `top`, `stadium`, `fuzzy`, `crowd` or `crowd64`.
    pub case: &'static str,
    /// The scene.
    pub scene: String,
    /// The work for each frame; for `rebuild` the quality of a BVH, or another structure: `grid`, `kd-fast`.
    pub strategy: &'static str,
    /// `gnurt` or `embree4`.
    pub engine: &'static str,
    /// Threads of an update; times are processor time of all of them.
    pub threads: usize,
    /// Triangles of the scene, those of each instance.
    pub triangles: u64,
    /// Instances of the scene.
    pub instances: u64,
    /// Median of the milliseconds that an update took.
    pub update_ms_cpu: f64,
    /// Millions of rays in a second, after the last frame.
    pub trace_mrays_cpu: f64,
    /// Bytes of the trees and their triangles, in crowds also of the vertices that they are made from; `None`
    /// where the engine does not report them.
    pub bytes: Option<u64>,
    /// Of the rays.
    pub hits: u64,
    /// Updates that built the tree again, at least in part; not in the JSON.
    pub rebuilds: usize,
}

impl DynamicRow {
    /// Processor milliseconds of a frame: an update, and a million rays.
    #[must_use]
    pub fn frame_ms_cpu(&self) -> f64 {
        self.update_ms_cpu + 1e3 / self.trace_mrays_cpu
    }
}

/// A table for people. A frame is an update and a million rays.
#[must_use]
pub fn table(rows: &[DynamicRow]) -> String {
    let mut text = String::new();
    let mut scene = "";
    for row in rows {
        if row.scene != scene {
            scene = &row.scene;
            text += &format!(
                "{scene}: {} triangles\n  {:<8} {:<8} {:<9} {:>7} {:>10} {:>10} {:>9} {:>10} {:>9} {:>9}\n",
                row.triangles,
                "case",
                "engine",
                "strategy",
                "threads",
                "update ms",
                "Mtri/s",
                "Mrays/s",
                "frame ms",
                "MB",
                "rebuilds"
            );
        }
        text += &format!(
            "  {:<8} {:<8} {:<9} {:>7} {:>10.3} {:>10.1} {:>9.3} {:>10.1} {:>9} {:>9}\n",
            row.case,
            row.engine,
            row.strategy,
            row.threads,
            row.update_ms_cpu,
            row.triangles as f64 / row.update_ms_cpu / 1e3,
            row.trace_mrays_cpu,
            row.frame_ms_cpu(),
            row.bytes.map_or_else(|| "-".to_owned(), |bytes| format!("{:.1}", bytes as f64 / 1e6)),
            row.rebuilds
        );
    }
    text
}

/// An array of objects.
#[must_use]
pub fn to_json(rows: &[DynamicRow]) -> Value {
    rows.iter()
        .map(|row| {
            json!({
                "case": row.case,
                "scene": row.scene,
                "strategy": row.strategy,
                "engine": row.engine,
                "threads": row.threads,
                "triangles": row.triangles,
                "instances": row.instances,
                "update_ms_cpu": row.update_ms_cpu,
                "trace_mrays_cpu": row.trace_mrays_cpu,
                "bytes": row.bytes,
                "hits": row.hits,
            })
        })
        .collect()
}
