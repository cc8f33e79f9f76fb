// SPDX-License-Identifier: GPL-3.0-or-later
//! The matrix stacks and the calls that change them (rtMatrixMode to rtMultTransposeMatrixd).
//! Source: original, after OpenGL 1.x. Invariant: each stack holds 1 to 1024 matrices.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::enums::MatrixMode;
use crate::error::{Error, Result, not_null};
use crate::matrix::Matrix;

/// Matrices per stack, the bottom one included.
pub const STACK_DEPTH: usize = 1024;

/// One entry of a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The matrix.
    pub matrix: Matrix,
    /// Whether it came from rtPerspective and is for a square picture, to be fitted to the frame buffer.
    pub follows_aspect: bool,
}

impl Entry {
    const BOTTOM: Self = Self { matrix: Matrix::IDENTITY, follows_aspect: false };
}

/// The three stacks and which of them calls change.
#[derive(Clone, Debug)]
pub struct Stacks {
    /// The stack that calls change.
    pub mode: MatrixMode,
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
    pub fn top(&self, mode: MatrixMode) -> Entry {
        self.stack(mode).last().copied().unwrap_or(Entry::BOTTOM)
    }

    /// Replaces the top entry of a stack.
    pub fn set_top(&mut self, mode: MatrixMode, entry: Entry) {
        if let Some(top) = self.stack_mut(mode).last_mut() {
            *top = entry;
        }
    }

    /// Multiplies `factor` to the right of the top of a stack.
    pub fn multiply(&mut self, mode: MatrixMode, factor: Matrix) {
        let top = self.top(mode);
        self.set_top(mode, Entry { matrix: top.matrix * factor, ..top });
    }
}

impl Context {
    /// rtMatrixMode.
    pub fn matrix_mode(&mut self, mode: u32) -> Result<()> {
        self.outside_block()?;
        self.stacks.mode = MatrixMode::from_code(mode)?;
        Ok(())
    }

    /// rtLoadIdentity, and rtLoadMatrix* with a matrix.
    pub fn load_matrix(&mut self, matrix: Option<Matrix>) -> Result<()> {
        self.outside_block()?;
        let matrix = not_null(matrix)?;
        self.stacks.set_top(self.stacks.mode, Entry { matrix, follows_aspect: false });
        Ok(())
    }

    /// rtMultMatrix*, rtScale*, rtTranslate*, rtRotate*.
    pub fn multiply_matrix(&mut self, factor: Option<Matrix>) -> Result<()> {
        self.outside_block()?;
        let factor = not_null(factor)?;
        self.stacks.multiply(self.stacks.mode, factor);
        Ok(())
    }

    /// rtPushMatrix.
    pub fn push_matrix(&mut self) -> Result<()> {
        self.outside_block()?;
        let (mode, top) = (self.stacks.mode, self.stacks.top(self.stacks.mode));
        let stack = self.stacks.stack_mut(mode);
        if stack.len() >= STACK_DEPTH {
            return Err(Error::StackOverflow);
        }
        stack.push(top);
        Ok(())
    }

    /// rtPopMatrix.
    pub fn pop_matrix(&mut self) -> Result<()> {
        self.outside_block()?;
        let stack = self.stacks.stack_mut(self.stacks.mode);
        if stack.len() <= 1 {
            return Err(Error::StackUnderflow);
        }
        stack.pop();
        Ok(())
    }

    /// The current RT_MODELVIEW matrix.
    pub(crate) fn modelview(&self) -> Matrix {
        self.stacks.top(MatrixMode::Modelview).matrix
    }
}
