// SPDX-License-Identifier: GPL-3.0-or-later
//! Output parameters and `debug` closures of surface shaders as values for layers of pictures.
//! Each requested output is a program of its own, compiled at its first use, without the work for other outputs.
//! Names are those of OSL's renderers: an output of the last layer that has it, or `layer.output`; or the tag of `debug`
//! closures, whose weights are added to an output of the same name.
//! Tests: `tests/scripts/outputs.rs`.

use std::sync::OnceLock;

use glam::Vec3;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{ColorMap, OutputKind, ShaderOutput, SurfaceBatch, Vec3s};
use gnurt_sl::exec::{LANES, Points};
use gnurt_sl::group::Group;
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::types::{Base, Type};

use crate::parts::Flattened;
use crate::surface_state::{Caller, points};
use crate::world::{Common, Ran, World, vector};

type Make = dyn Fn(&Wanted) -> Option<Made> + Send + Sync;

/// The program of an output.
pub(crate) struct Made {
    pub(crate) common: Common,
    /// The number of its name among the texts, if `debug` closures have it as their tag.
    pub(crate) tag: Option<u32>,
}

/// A layer's value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Wanted {
    pub(crate) name: String,
    /// Whether there is an output parameter of this name.
    pub(crate) is_parameter: bool,
    /// Whether there are `debug` closures of this name.
    pub(crate) is_tag: bool,
}

/// The outputs of a shader.
pub(crate) struct Outputs {
    pub(crate) all: Vec<ShaderOutput>,
    /// Compiles the program of an output.
    make: Box<Make>,
    /// By output.
    wanted: Vec<Wanted>,
    /// By output; `None` where it could not be compiled.
    made: Vec<OnceLock<Option<Made>>>,
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
    /// Those of a group, and its `debug` closures' by tag; `make` compiles the program of one.
    pub(crate) fn of(group: &Group, tags: &[String], make: Box<Make>) -> Self {
        let mut all = listed(group);
        let wanted =
            |output: &ShaderOutput| Wanted { name: output.name.clone(), is_parameter: true, is_tag: false };
        let mut wanted: Vec<Wanted> = all.iter().map(wanted).collect();
        for name in tags {
            match wanted.iter().position(|wanted| wanted.name == *name) {
                Some(known) => {
                    wanted[known].is_tag = true;
                    all[known].kind = all[known].kind.max(OutputKind::Color);
                }
                None => {
                    wanted.push(Wanted { name: name.clone(), is_parameter: false, is_tag: true });
                    all.push(ShaderOutput { name: name.clone(), kind: OutputKind::Color });
                }
            }
        }
        let made = all.iter().map(|_| OnceLock::new()).collect();
        Self { all, make, wanted, made }
    }

    /// Writes an output of all points.
    pub(crate) fn write(&self, name: &str, hits: &SurfaceBatch, out: &mut Vec3s) {
        let Some(number) = self.all.iter().position(|output| output.name == name) else { return };
        let wanted = &self.wanted[number];
        let Some(made) = self.made[number].get_or_init(|| (self.make)(wanted)) else { return };
        let common = &made.common;
        let row = if wanted.is_parameter { common.row(name) } else { None };
        let is_number = common.is_number(name);
        let is_color = self.all[number].kind == OutputKind::Color;
        let world = World::around(common, hits, None);
        let mut closures = ClosureBatch::default();
        closures.reset(LANES);
        let fill = |first: usize, to: &mut Points| points(hits, first, Caller::Rays, common.needs, to);
        common.run_all(&world, hits.len(), fill, |Ran { first, points, results, open }| {
            let tagged = made.tag.map(|tag| {
                let how = (Some(tag), ColorMap::default());
                Flattened::flatten_tagged(points, results, (&mut closures, 0), open, how).lights.debug
            });
            for lane in 0..points.count {
                let value = match row {
                    None => Vec3::ZERO,
                    Some(row) if is_number => Vec3::splat(results.rows[row][lane]),
                    Some(row) => vector(results, row, lane),
                };
                let value = value + tagged.map_or(Vec3::ZERO, |tagged| tagged.get(lane));
                out.set(first + lane, if is_color { common.map.of(value) } else { value });
            }
        });
    }
}
