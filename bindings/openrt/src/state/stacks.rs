// SPDX-License-Identifier: GPL-3.0-or-later
//! The matrix stacks.
//! Source: after OpenGL 1.x. Invariant: each stack holds 1 to 1024 matrices.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use super::enums::MatrixMode;
use super::error::{Error, Result};
use super::matrix::Matrix;

/// Matrices per stack, the bottom one included.
const STACK_DEPTH: usize = 1024;

/// One entry of a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    /// The matrix.
    pub(crate) matrix: Matrix,
    /// Whether it came from rtPerspective and is for a square picture, to be fitted to the frame buffer.
    pub(crate) follows_aspect: bool,
}

impl Entry {
    const BOTTOM: Self = Self { matrix: Matrix::IDENTITY, follows_aspect: false };
}

/// The three stacks and which of them calls change.
#[derive(Clone, Debug)]
pub(crate) struct Stacks {
    /// The stack that calls change.
    pub(crate) mode: MatrixMode,
    modelview: Vec<Entry>,
    projection: Vec<Entry>,
    texture: Vec<Entry>,
}

impl Default for Stacks {
    fn default() -> Self {
        let stack = || vec![Entry::BOTTOM];
        Self { mode: MatrixMode::Modelview, modelview: stack(), projection: stack(), texture: stack() }
    }
}

impl Stacks {
    fn stack(&self, mode: MatrixMode) -> &Vec<Entry> {
        match mode {
            MatrixMode::Modelview => &self.modelview,
            MatrixMode::Projection => &self.projection,
            MatrixMode::Texture => &self.texture,
        }
    }

    fn stack_mut(&mut self, mode: MatrixMode) -> &mut Vec<Entry> {
        match mode {
            MatrixMode::Modelview => &mut self.modelview,
            MatrixMode::Projection => &mut self.projection,
            MatrixMode::Texture => &mut self.texture,
        }
    }

    /// The top entry of a stack.
    #[must_use]
    pub(crate) fn top(&self, mode: MatrixMode) -> Entry {
        self.stack(mode).last().copied().unwrap_or(Entry::BOTTOM)
    }

    /// Replaces the top entry of a stack.
    pub(crate) fn set_top(&mut self, mode: MatrixMode, entry: Entry) {
        if let Some(top) = self.stack_mut(mode).last_mut() {
            *top = entry;
        }
    }

    /// Multiplies `factor` to the right of the top of a stack.
    pub(crate) fn multiply(&mut self, mode: MatrixMode, factor: Matrix) {
        let top = self.top(mode);
        self.set_top(mode, Entry { matrix: top.matrix * factor, ..top });
    }

    /// Doubles the top of the stack that calls change.
    pub(crate) fn push(&mut self) -> Result<()> {
        let top = self.top(self.mode);
        let stack = self.stack_mut(self.mode);
        if stack.len() >= STACK_DEPTH {
            return Err(Error::StackOverflow);
        }
        stack.push(top);
        Ok(())
    }

    /// Takes the top off the stack that calls change.
    pub(crate) fn pop(&mut self) -> Result<()> {
        let stack = self.stack_mut(self.mode);
        if stack.len() <= 1 {
            return Err(Error::StackUnderflow);
        }
        stack.pop();
        Ok(())
    }
}
