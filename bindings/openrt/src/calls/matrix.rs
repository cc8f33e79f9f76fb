// SPDX-License-Identifier: GPL-3.0-or-later
//! The calls that change the matrix stacks (rtMatrixMode to rtMultTransposeMatrixd).
//! Source: OpenGL 1.x. Tests: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::state::enums::MatrixMode;
use crate::state::error::{Result, not_null};
use crate::state::matrix::Matrix;
use crate::state::stacks::Entry;

impl Context {
    /// rtMatrixMode.
    pub(crate) fn matrix_mode(&mut self, mode: u32) -> Result<()> {
        self.outside_block()?;
        self.stacks.mode = MatrixMode::from_code(mode)?;
        Ok(())
    }

    /// rtLoadIdentity, and rtLoadMatrix* with a matrix.
    pub(crate) fn load_matrix(&mut self, matrix: Option<Matrix>) -> Result<()> {
        self.outside_block()?;
        let matrix = not_null(matrix)?;
        self.stacks.set_top(self.stacks.mode, Entry { matrix, follows_aspect: false });
        Ok(())
    }

    /// rtMultMatrix*, rtScale*, rtTranslate*, rtRotate*.
    pub(crate) fn multiply_matrix(&mut self, factor: Option<Matrix>) -> Result<()> {
        self.outside_block()?;
        let factor = not_null(factor)?;
        self.stacks.multiply(self.stacks.mode, factor);
        Ok(())
    }

    /// rtPushMatrix.
    pub(crate) fn push_matrix(&mut self) -> Result<()> {
        self.outside_block()?;
        self.stacks.push()
    }

    /// rtPopMatrix.
    pub(crate) fn pop_matrix(&mut self) -> Result<()> {
        self.outside_block()?;
        self.stacks.pop()
    }

    /// The current RT_MODELVIEW matrix.
    pub(super) fn modelview(&self) -> Matrix {
        self.stacks.top(MatrixMode::Modelview).matrix
    }
}
