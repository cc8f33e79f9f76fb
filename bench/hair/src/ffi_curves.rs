// SPDX-License-Identifier: GPL-3.0-or-later
//! Embree's curves: scenes of one geometry. Source: the public headers of Embree 4.4 (rtcore_geometry.h), as in `ffi_embree.rs`.
//! Invariant: the arrays outlive the scene.

use std::ffi::c_int;

use gnurt_accel::{CurveBasis, CurveForm, Curves};

use crate::ffi_embree::{BUFFER_INDEX, BUFFER_VERTEX, Device, Scene};

const FORMAT_UINT: c_int = 0x5001;
const FORMAT_FLOAT4: c_int = 0x9004;

/// RTC_GEOMETRY_TYPE_*_CURVE.
fn geometry_type(curves: &Curves) -> Option<c_int> {
    let form = match curves.form {
        CurveForm::Round => 0,
        CurveForm::Flat => 1,
        CurveForm::Oriented => return None,
    };
    Some(match curves.basis {
        CurveBasis::Linear => 16 + form,
        CurveBasis::Bezier => 24 + form,
        CurveBasis::BSpline => 32 + form,
        CurveBasis::CatmullRom => 58 + form,
        CurveBasis::Hermite => return None,
    })
}

/// Builds over curves without normals or tangents of their own.
///
/// # Panics
/// An index is out of range.
pub fn build<'a>(device: &'a Device<'a>, curves: &Curves<'a>, quality: i32) -> Result<Scene<'a>, String> {
    let kind = geometry_type(curves).ok_or("a form or basis without arrays for it")?;
    let order = if curves.basis == CurveBasis::Linear { 2 } else { 4 };
    let highest = curves.indices.iter().max().map_or(0, |&i| i as usize + order);
    assert!(highest <= curves.vertices.len(), "a curve ends at {highest} of {}", curves.vertices.len());
    let library = device.library;
    // SAFETY: handles are used as Embree's manual shows. The arrays outlive the scene, and all indices are in range.
    let scene = unsafe {
        let geometry = (library.new_geometry)(device.raw, kind);
        let (vertices, indices) = (curves.vertices.as_ptr().cast(), curves.indices.as_ptr().cast());
        let share = library.share_buffer;
        share(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT4, vertices, 0, 16, curves.vertices.len());
        share(geometry, BUFFER_INDEX, 0, FORMAT_UINT, indices, 0, 4, curves.indices.len());
        Scene::of(device, geometry, quality, 0)
    };
    device.check()?;
    Ok(scene)
}
