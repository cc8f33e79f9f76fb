// SPDX-License-Identifier: GPL-3.0-or-later
//! The whole program.

use super::lowerer::Lowerer;
use crate::diagnostics::Diagnostics;
use crate::hir::Program;
use crate::ir::Shader;
use crate::source::Sources;

/// The intermediate form of a program that was checked without errors; whole if no errors come with it.
#[must_use]
pub fn lower(program: &Program, sources: &Sources) -> (Shader, Diagnostics) {
    let mut lowerer = Lowerer::new(program, sources);
    for &id in &program.params {
        lowerer.parameter(id);
    }
    lowerer.statements(&program.body, false);
    lowerer.shader.code = lowerer.blocks.pop().unwrap_or_default();
    (lowerer.shader, lowerer.diagnostics)
}
