// SPDX-License-Identifier: GPL-3.0-or-later
//! Questions about the library and the state (rtGetString, rtGetIntegerv, rtGetFloatv).
//! Source: after OpenGL 1.x; integers of colours and normals span the integer's range.
//! Tests: tests/c/scene.c.

use std::ffi::CStr;

use crate::context::Context;
use crate::state::enums::{MatrixMode, StateName, StringName};
use crate::state::error::{Result, Writer, not_null};

/// Version of the API and of the library.
const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!("1.0 GNU RT ", env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("one zero byte, at the end"),
    };

impl Context {
    /// rtGetString.
    pub(crate) fn get_string(&self, name: u32) -> Result<&'static CStr> {
        self.outside_block()?;
        Ok(match StringName::from_code(name)? {
            StringName::Vendor => c"The GNU RT authors",
            StringName::Renderer => c"GNU RT",
            StringName::Version => VERSION,
            StringName::Extensions => c"",
        })
    }

    /// rtGetFloatv: passes the value's numbers to `write`.
    pub(crate) fn get_floats(&self, name: u32, write: Option<Writer<'_, f32>>) -> Result<()> {
        self.outside_block()?;
        let write = not_null(write)?;
        let floats: Vec<f32> = self.state(StateName::from_code(name)?).iter().map(|&x| x as f32).collect();
        write(&floats);
        Ok(())
    }

    /// rtGetIntegerv: passes the value's numbers to `write`.
    pub(crate) fn get_integers(&self, name: u32, write: Option<Writer<'_, i32>>) -> Result<()> {
        self.outside_block()?;
        let write = not_null(write)?;
        let name = StateName::from_code(name)?;
        // OpenGL maps 1 to the largest and -1 to the smallest integer. Casts saturate.
        let spans_range = matches!(name, StateName::CurrentColor | StateName::CurrentNormal);
        let integer = |x: f64| {
            let scaled = if spans_range { (x * f64::from(u32::MAX) - 1.0) / 2.0 } else { x };
            scaled.round() as i32
        };
        let integers: Vec<i32> = self.state(name).iter().map(|&x| integer(x)).collect();
        write(&integers);
        Ok(())
    }

    /// Samples that each pixel of the frame that ended last has.
    fn sample_count(&self) -> u32 {
        self.stage.accumulation.as_ref().map_or(0, gnurt::render::Accumulation::samples)
    }

    fn state(&self, name: StateName) -> Vec<f64> {
        let matrix = |mode| self.stacks.top(mode).matrix.0.to_vec();
        let count = |n: usize| vec![n as f64];
        match name {
            StateName::ObjectCount => count(self.objects.counts().0),
            StateName::TriangleCount => count(self.objects.counts().1),
            StateName::InstanceCount => count(self.instances.len()),
            StateName::SampleCount => vec![f64::from(self.sample_count())],
            StateName::CurrentColor => self.current.color.map(f64::from).to_vec(),
            StateName::CurrentNormal => self.current.normal.to_vec(),
            StateName::CurrentTextureCoords => self.current.texcoord.to_vec(),
            StateName::MatrixMode => vec![f64::from(self.stacks.mode.code())],
            StateName::ModelviewMatrix => matrix(MatrixMode::Modelview),
            StateName::ProjectionMatrix => matrix(MatrixMode::Projection),
            StateName::TextureMatrix => matrix(MatrixMode::Texture),
        }
    }
}
