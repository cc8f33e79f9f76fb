// SPDX-License-Identifier: GPL-3.0-or-later
//! Attributes of the next vertex (rtNormal*, rtTexCoord*, rtColor*): legal everywhere.
//! Source: OpenGL 1.x. Tests: tests/c/scene.c.

use crate::context::Context;

impl Context {
    /// rtNormal*: legal everywhere.
    #[inline]
    pub(crate) fn normal(&mut self, normal: [f64; 3]) {
        self.current.normal = normal;
        // The unnamed object began before any object that is open: the normal came after both.
        self.unnamed.has_normals = true;
        if let Some(open) = &mut self.open {
            open.assembly.has_normals = true;
        }
    }

    /// rtTexCoord*: legal everywhere.
    #[inline]
    pub(crate) fn tex_coord(&mut self, texcoord: [f64; 4]) {
        self.current.texcoord = texcoord;
    }

    /// rtColor*: legal everywhere.
    #[inline]
    pub(crate) fn color(&mut self, color: [f32; 4]) {
        self.current.color = color;
    }
}
