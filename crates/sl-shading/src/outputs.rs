// SPDX-License-Identifier: GPL-3.0-or-later
//! Output parameters of surface shaders as values for layers of pictures.
//! Each requested output is a program of its own, compiled at its first use, without the work for other outputs.
//! Names are those of OSL's renderers: an output of the last layer that has it, or `layer.output`.
//! Tests: `tests/scripts/outputs.rs`.

use std::sync::OnceLock;

use glam::Vec3;
use gnurt_shading::{OutputKind, ShaderOutput, SurfaceBatch, Vec3s};
use gnurt_sl::exec::LANES;
use gnurt_sl::group::Group;
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::types::{Base, Type};

use crate::surface_state::{Caller, points};
use crate::world::{Common, World, vector};

type Make = dyn Fn(&str) -> Option<Common> + Send + Sync;

/// The outputs of a shader.
pub(crate) struct Outputs {
    pub(crate) all: Vec<ShaderOutput>,
    /// Compiles the program of an output.
    make: Box<Make>,
    /// By output; `None` where it could not be compiled.
    made: Vec<OnceLock<Option<Common>>>,
}

/// The form of a type that layers can hold.
fn kind(ty: Type) -> Option<OutputKind> {
    match ty.base {
        _ if ty.array != 0 || ty.struct_id().is_some() => None,
        Base::Int | Base::Float => Some(OutputKind::Number),
        Base::Color => Some(OutputKind::Color),
        base if base.is_triple() => Some(OutputKind::Vector),
        _ => None,
    }
}

/// The outputs that layers can show: of the last layer without its name, of all layers with it.
fn listed(group: &Group) -> Vec<ShaderOutput> {
    let mut all: Vec<ShaderOutput> = Vec::new();
    let mut add = |name: String, kind: OutputKind| {
        if !all.iter().any(|known| known.name == name) {
            all.push(ShaderOutput { name, kind });
        }
    };
    for layer in group.layers.iter().rev() {
        for (_, symbol) in layer.shader.params() {
            if let (SymbolKind::OutputParam, Some(kind)) = (symbol.kind, kind(symbol.ty)) {
                add(symbol.name.to_string(), kind);
                // The only layer's name is made up.
                if group.layers.len() > 1 {
                    add(format!("{}.{}", layer.name, symbol.name), kind);
                }
            }
        }
    }
    all
}

impl Outputs {
    /// Those of a group; `make` compiles the program of one.
    pub(crate) fn of(group: &Group, make: Box<Make>) -> Self {
        let all = listed(group);
        let made = all.iter().map(|_| OnceLock::new()).collect();
        Self { all, make, made }
    }

    /// Writes an output of all points.
    pub(crate) fn write(&self, name: &str, hits: &SurfaceBatch, out: &mut Vec3s) {
        let Some(number) = self.all.iter().position(|output| output.name == name) else { return };
        let Some(common) = self.made[number].get_or_init(|| (self.make)(name)) else { return };
        let Some(row) = common.row(name) else { return };
        let kind = self.all[number].kind;
        let world = World::around(common, hits, None);
        common.with_scratch(|scratch| {
            for first in (0..hits.len()).step_by(LANES) {
                points(hits, first, Caller::Rays, common.needs, &mut scratch.points);
                common.run(&world, &scratch.points, &mut scratch.results);
                for lane in 0..LANES.min(hits.len() - first) {
                    let value = match kind {
                        OutputKind::Number => Vec3::splat(scratch.results.rows[row][lane]),
                        OutputKind::Vector | OutputKind::Color => vector(&scratch.results, row, lane),
                    };
                    out.set(first + lane, value);
                }
            }
        });
    }
}
