// SPDX-License-Identifier: GPL-3.0-or-later
//! What a group asks of the renderer, read from its code. Names that are made while it runs are not known.

use std::collections::BTreeSet;

use gnurt_sl::exec::Plan;
use gnurt_sl::group::{Group, Layer};
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{Op, SymId, Symbol, SymbolKind, ops, uses};
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::Base;

/// Names that a renderer can prepare for. Sorted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Globals that are read or written, by their names in shaders: `P`, `N`, `u`, `Ci` and others.
    pub globals: BTreeSet<String>,
    /// Fields of [`Point`](crate::Point) that are read, by their names in Rust: `p` for the global `P`, `dpdu` for `dPdu`,
    /// `backfacing` for `backfacing ()`, `ray_kinds` for `raytype ()`, and so on. Others may stay as they are, unless a
    /// [`Host`](crate::Host) of yours reads them.
    pub fields: BTreeSet<&'static str>,
    /// Those of `fields` whose derivatives count, by `Dx`, `filterwidth`, or filters of textures and noise: some of `p`, `i`, `u`
    /// and `v`.
    pub derivatives: BTreeSet<&'static str>,
    /// Parameters that the geometry may give: names of [`Host::userdata`](crate::Host::userdata).
    pub userdata: BTreeSet<String>,
    /// Objects (empty for the shaded one) and names of `getattribute`.
    pub attributes: BTreeSet<(String, String)>,
    /// Files of `texture`, `environment`, `texture3d` and `gettextureinfo`.
    pub textures: BTreeSet<String>,
    /// Files of point clouds.
    pub point_clouds: BTreeSet<String>,
    /// Named spaces of `transform` and `matrix`.
    pub spaces: BTreeSet<String>,
    /// Kinds of rays that it tells apart.
    pub ray_kinds: BTreeSet<String>,
    /// Closures that it makes.
    pub closures: BTreeSet<String>,
    /// Whether it traces rays.
    pub traces: bool,
    /// Whether some names are made while it runs, and are not listed.
    pub has_unknown_names: bool,
}

impl Needs {
    pub(crate) fn of(group: &Group, plan: &Plan, live: &[&str]) -> Self {
        let mut needs = Self::default();
        for symbol in plan.layers.iter().flat_map(|layer| &layer.shader.symbols) {
            if let Some(field) = field_of(symbol).filter(|field| symbol.derivs && DUAL.contains(field)) {
                needs.derivatives.insert(field);
            }
        }
        for (number, layer) in group.layers.iter().enumerate() {
            let shader = &layer.shader;
            let is_connected = |id: SymId| {
                group.connections.iter().any(|made| made.to_layer == number && made.to.symbol == id)
            };
            for (id, symbol) in shader.params() {
                let name: &str = &symbol.name;
                if layer.interpolated(id) && !is_connected(id) && !live.contains(&name) {
                    needs.userdata.insert(name.to_owned());
                }
            }
            let inits = shader.symbols.iter().map(|symbol| &symbol.init);
            for block in inits.chain([&shader.code]) {
                ops(block, &mut |op| needs.add(layer, op, &is_connected));
                uses(block, &mut |id, _| {
                    let symbol = shader.symbol(id);
                    if symbol.kind == SymbolKind::Global {
                        needs.globals.insert(symbol.name.to_string());
                        needs.fields.extend(field_of(symbol));
                    }
                });
            }
        }
        needs
    }

    fn add(&mut self, layer: &Layer, op: &Op, is_connected: &dyn Fn(SymId) -> bool) {
        let is_text = |id: SymId| layer.shader.symbol(id).ty.base == Base::String;
        // The last argument of `getattribute` is its result.
        let end =
            if op.code == Opcode::GetAttribute { op.args.len().saturating_sub(1) } else { op.args.len() };
        let texts: Vec<SymId> = op.args.iter().copied().take(end).skip(1).filter(|&id| is_text(id)).collect();
        let mut name = |needs: &mut Self, id: Option<&SymId>| -> String {
            let known = id.map(|&id| known_text(layer, id, is_connected));
            needs.has_unknown_names |= known == Some(None);
            known.flatten().unwrap_or_default()
        };
        let put = |to: &mut BTreeSet<String>, name: String| {
            if !name.is_empty() {
                to.insert(name);
            }
        };
        let first = |needs: &mut Self, name: &mut dyn FnMut(&mut Self, Option<&SymId>) -> String| {
            name(needs, texts.first())
        };
        match op.code {
            Opcode::GetAttribute => {
                let (object, attribute) = match &texts[..] {
                    [object, attribute] => (name(self, Some(object)), name(self, Some(attribute))),
                    _ => (String::new(), first(self, &mut name)),
                };
                if !attribute.is_empty() {
                    self.attributes.insert((object, attribute));
                }
            }
            Opcode::Texture | Opcode::Environment | Opcode::Texture3d | Opcode::GetTextureInfo => {
                let file = first(self, &mut name);
                put(&mut self.textures, file);
            }
            Opcode::PointcloudSearch | Opcode::PointcloudGet => {
                let file = first(self, &mut name);
                put(&mut self.point_clouds, file);
            }
            Opcode::Transform
            | Opcode::TransformV
            | Opcode::TransformN
            | Opcode::GetMatrix
            | Opcode::Matrix => {
                for text in &texts {
                    let space = name(self, Some(text));
                    put(&mut self.spaces, space);
                }
            }
            Opcode::RayType => {
                let kind = first(self, &mut name);
                put(&mut self.ray_kinds, kind);
                self.fields.insert("ray_kinds");
            }
            Opcode::Backfacing => drop(self.fields.insert("backfacing")),
            Opcode::SurfaceArea => drop(self.fields.insert("surface_area")),
            Opcode::CalculateNormal => drop(self.fields.insert("flipped")),
            Opcode::Random => drop(self.fields.insert("index")),
            Opcode::Closure => {
                let closure = first(self, &mut name);
                put(&mut self.closures, closure);
            }
            Opcode::Trace => self.traces = true,
            _ => {}
        }
    }
}

/// Globals of points, and the fields of [`Point`](crate::Point) that they are.
const FIELDS: [(&str, &str); 14] = [
    ("P", "p"),
    ("I", "i"),
    ("N", "n"),
    ("Ng", "ng"),
    ("u", "u"),
    ("v", "v"),
    ("dPdu", "dpdu"),
    ("dPdv", "dpdv"),
    ("Ps", "ps"),
    ("time", "time"),
    ("dtime", "dtime"),
    ("dPdtime", "dpdtime"),
    ("xi", "xi"),
    ("raster", "raster"),
];

/// Fields that have derivatives.
const DUAL: [&str; 5] = ["p", "i", "u", "v", "ps"];

/// The field that a global is, if it is one.
fn field_of(symbol: &Symbol) -> Option<&'static str> {
    let found = FIELDS.iter().find(|(global, _)| *global == &*symbol.name);
    found.filter(|_| symbol.kind == SymbolKind::Global).map(|(_, field)| *field)
}

/// The text of a symbol, where it is the same for all points.
fn known_text(layer: &Layer, id: SymId, is_connected: &dyn Fn(SymId) -> bool) -> Option<String> {
    let symbol = layer.shader.symbol(id);
    let value = match symbol.kind {
        SymbolKind::Const => symbol.value.as_ref(),
        SymbolKind::Param if !is_connected(id) && !layer.interpolated(id) && symbol.init.is_empty() => {
            layer.values.get(&id).or(symbol.value.as_ref())
        }
        _ => None,
    };
    match value {
        Some(Data::Str(list)) => list.first().map(ToString::to_string),
        _ => None,
    }
}
