// SPDX-License-Identifier: GPL-3.0-or-later
//! Displacement by shaders: `displacement` shaders, surfaces that call `displace`, and those with an output `vector displacement`; and
//! `bump` of surfaces.
//! Source: the OSL specification, sections 5.1 and 7.6. A displacement shader assigns to `P`, or calls `displace`; the offset is the
//! change of `P`. `N` and `bump` change nothing there, because normals are those of the displaced triangles. The output of a surface is
//! the offset itself, and the rest of the surface is left out of that program. A surface is a program of its own at vertices, where only
//! `displace` changes `P` for others; where it is shaded, `displace` does nothing, because its point is displaced. `bump` of surfaces gives `N` the normal that the surface
//! would have if it were displaced so far.
//! Space: object is the common space; `world`, `object` and `shader` are the same. Tests: `tests/scripts/displacement.rs`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_shading::{AttributeRequest, DisplacementShader, SurfaceBatch, Vec3s};
use gnurt_sl::exec::Points;
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{
    Block, Node, Op, Shader, SourcePosition, SymId, Symbol, SymbolKind, Use, ops, ops_mut, uses,
};
use gnurt_sl::opcode::Opcode;
use gnurt_sl::passes::mark_derivatives;
use gnurt_sl::types::Type;

use crate::surface_state::{Caller, points};
use crate::world::{Common, Ran, World, vector};

/// The global that displacement shaders change.
pub(crate) const POSITION: &str = "P";

/// The output of surfaces that is their offset.
pub(crate) const OFFSET: &str = "displacement";

/// Whether a surface has an offset.
pub(crate) fn has_offset(shader: &Shader) -> bool {
    shader.find(OFFSET).is_some_and(|id| {
        let symbol = shader.symbol(id);
        symbol.kind == SymbolKind::OutputParam && symbol.ty.base.is_triple() && symbol.ty.array == 0
    })
}

/// A displacement.
pub(crate) struct ScriptDisplacement {
    pub(crate) common: Common,
    /// The stored value: [`POSITION`] or [`OFFSET`].
    pub(crate) value: &'static str,
}

impl DisplacementShader for ScriptDisplacement {
    fn displace(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        let common = &self.common;
        let Some(row) = common.row(self.value) else { return };
        let world = World::around(common, hits, None);
        let fill = |first: usize, to: &mut Points| points(hits, first, Caller::Vertices, common.needs, to);
        common.run_all(&world, hits.len(), fill, |Ran { first, points, results, .. }| {
            for lane in 0..points.count {
                let value = vector(results, row, lane);
                let start = if self.value == POSITION { hits.p.get(first + lane) } else { Vec3::ZERO };
                out.set(first + lane, value - start);
            }
        });
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.common.requests
    }

    fn faults(&self) -> Vec<String> {
        self.common.faults.lines()
    }
}

/// Replaces calls of `displace` by operations on `P`, or calls of `bump` by those on `N`. Both take `(amp)`, `(space, amp)` and
/// `(offset)`.
pub(crate) fn expand(shader: &mut Shader, which: Opcode) {
    let mut code = std::mem::take(&mut shader.code);
    expand_block(&mut code, shader, which);
    shader.code = code;
    mark_derivatives(shader);
}

/// Whether a layer's assignments to `P` displace.
pub(crate) fn assigns(shader: &Shader) -> bool {
    &*shader.kind == "displacement"
}

/// Gives a shader variables in place of the globals that it assigns to, so that those of other shaders and the renderer stay.
pub(crate) fn keep_globals(shader: &mut Shader) {
    let mut written = Vec::new();
    let mut note = |id: SymId, usage: Use| {
        if usage == Use::Write && shader.symbol(id).kind == SymbolKind::Global && !written.contains(&id) {
            written.push(id);
        }
    };
    uses(&shader.code, &mut note);
    for id in written {
        let (name, ty) = (shader.symbol(id).name.clone(), shader.symbol(id).ty);
        let own = &mut shader.symbols[id as usize];
        (own.name, own.kind) = (format!("$own{id}").into(), SymbolKind::Local);
        let global = push(shader, Symbol::new(name, SymbolKind::Global, ty));
        // Defaults are worked out before.
        for symbol in &mut shader.symbols {
            let mut put = |op: &mut Op| op.args.iter_mut().filter(|a| **a == id).for_each(|a| *a = global);
            ops_mut(&mut symbol.init, &mut put);
        }
        let args = vec![id, global];
        let start =
            Op { code: Opcode::Assign, args, reads: 2, writes: 1, derivs: 0, at: SourcePosition::default() };
        shader.code.insert(0, Node::Op(start));
    }
    mark_derivatives(shader);
}

/// Whether there are such calls.
pub(crate) fn calls(shader: &Shader, which: Opcode) -> bool {
    let mut found = false;
    ops(&shader.code, &mut |op| found |= op.code == which);
    found
}

fn expand_block(block: &mut Block, shader: &mut Shader, which: Opcode) {
    let mut made = Vec::with_capacity(block.len());
    for mut node in std::mem::take(block) {
        match &mut node {
            Node::Op(op) if op.code == which => {
                displace(op, shader, &mut made);
                continue;
            }
            Node::Op(_) => {}
            Node::If { yes, no, .. } => {
                expand_block(yes, shader, which);
                expand_block(no, shader, which);
            }
            Node::Loop { init, test, body, step, .. } => {
                [init, test, body, step].into_iter().for_each(|part| expand_block(part, shader, which));
            }
            Node::Call { body, .. } => expand_block(body, shader, which),
        }
        made.push(node);
    }
    *block = made;
}

/// The operations of one call.
fn displace(op: &Op, shader: &mut Shader, out: &mut Block) {
    let mut add = |code: Opcode, args: Vec<SymId>| {
        let reads = ((1_u64 << args.len()) - 1) & !1;
        let derivs = if code == Opcode::CalculateNormal { reads } else { 0 };
        out.push(Node::Op(Op { code, args, reads, writes: 1, derivs, at: op.at }));
    };
    let position = global(shader, POSITION, Type::POINT);
    let offset = match op.args[..] {
        [offset] if shader.symbol(offset).ty.base.is_triple() => offset,
        [amount] => {
            let (normal, offset) = (global(shader, "N", Type::NORMAL), local(shader, Type::VECTOR));
            add(Opcode::Mul, vec![offset, normal, amount]);
            offset
        }
        [space, amount] => {
            // The amount is a length in that space, along the normal.
            let (normal, offset) = (global(shader, "N", Type::NORMAL), local(shader, Type::VECTOR));
            let [there, length, share] = [Type::VECTOR, Type::FLOAT, Type::FLOAT].map(|ty| local(shader, ty));
            let common = text(shader, "common");
            add(Opcode::Assign, vec![offset, normal]);
            add(Opcode::TransformV, vec![there, common, space, offset]);
            add(Opcode::Length, vec![length, there]);
            add(Opcode::Div, vec![share, amount, length]);
            add(Opcode::Mul, vec![offset, normal, share]);
            offset
        }
        _ => return,
    };
    if op.code == Opcode::Bump {
        let (normal, there) = (global(shader, "N", Type::NORMAL), local(shader, Type::POINT));
        let slope = local(shader, Type::NORMAL);
        add(Opcode::Add, vec![there, position, offset]);
        add(Opcode::CalculateNormal, vec![slope, there]);
        add(Opcode::Normalize, vec![normal, slope]);
        return;
    }
    add(Opcode::Add, vec![position, position, offset]);
}

fn global(shader: &mut Shader, name: &str, ty: Type) -> SymId {
    let known = shader.find(name).filter(|&id| shader.symbol(id).kind == SymbolKind::Global);
    known.unwrap_or_else(|| push(shader, Symbol::new(name.into(), SymbolKind::Global, ty)))
}

fn local(shader: &mut Shader, ty: Type) -> SymId {
    let name = format!("$displace{}", shader.symbols.len());
    push(shader, Symbol::new(name.into(), SymbolKind::Temp, ty))
}

fn text(shader: &mut Shader, value: &str) -> SymId {
    let name = format!("$displace{}", shader.symbols.len());
    let data = Data::Str(vec![value.into()]);
    let symbol = Symbol { value: Some(data), ..Symbol::new(name.into(), SymbolKind::Const, Type::STRING) };
    push(shader, symbol)
}

fn push(shader: &mut Shader, symbol: Symbol) -> SymId {
    shader.symbols.push(symbol);
    (shader.symbols.len() - 1) as SymId
}

/// As the renderer takes it.
pub(crate) fn made(common: Common, value: &'static str) -> Arc<dyn DisplacementShader> {
    Arc::new(ScriptDisplacement { common, value })
}
