// SPDX-License-Identifier: GPL-3.0-or-later
//! Blocks of vertices and the vertices in them (rtBegin, rtVertex*, rtEnd).
//! Source: OpenGL 1.x. Tests: tests/c/fragments.c; `random`.

use crate::context::Context;
use crate::state::block::Assembly;
use crate::state::current::Transforms;
use crate::state::enums::Primitive;
use crate::state::error::{Error, Result};

impl Context {
    /// Where vertices go: the open object, or the unnamed one of the next frame.
    fn assembly_mut(&mut self) -> &mut Assembly {
        match &mut self.open {
            Some(open) => &mut open.assembly,
            None => &mut self.unnamed,
        }
    }

    /// rtBegin.
    pub(crate) fn begin(&mut self, mode: u32) -> Result<()> {
        self.outside_block()?;
        let mode = Primitive::from_code(mode)?;
        let (surface, transforms) = (self.bound_surface(), Transforms::of(&self.stacks));
        self.block = Some(self.assembly_mut().begin(mode, surface, transforms));
        Ok(())
    }

    /// rtVertex*.
    #[inline]
    pub(crate) fn vertex(&mut self, position: [f64; 4]) -> Result<()> {
        let block = self.block.as_mut().ok_or(Error::InvalidOperation)?;
        let assembly = match &mut self.open {
            Some(open) => &mut open.assembly,
            None => &mut self.unnamed,
        };
        assembly.vertex(block, &self.current, position, &self.bound.values)
    }

    /// rtEnd.
    pub(crate) fn end(&mut self) -> Result<()> {
        let block = self.block.take().ok_or(Error::InvalidOperation)?;
        self.assembly_mut().end(&block);
        Ok(())
    }
}
