// SPDX-License-Identifier: GPL-3.0-or-later
//! The geometry of an object, by its subtype. Tests: tests/shapes.rs.

use super::data::Geometry;
use super::segments::{self, Shapes};
use super::{faces, isosurface};
use crate::ffi_array::Array;
use crate::field::Field;
use crate::object::Object;
use crate::types;

/// The geometry of an object, and a warning; an error in words where it cannot be shown.
pub(crate) fn build(object: &Object, shapes: Shapes) -> Result<(Geometry, Option<String>), String> {
    let now = object.committed();
    let (mut geometry, warning) = shape(object, shapes)?;
    if let Some(array) = now.object("primitive.id", types::ARRAY1D).and_then(|array| Array::of(array)) {
        geometry.ids = array.indices::<1>().unwrap_or_default().into_iter().map(|[id]| id as u32).collect();
    }
    Ok((geometry, warning))
}

fn shape(object: &Object, shapes: Shapes) -> Result<(Geometry, Option<String>), String> {
    let now = object.committed();
    match object.subtype.as_str() {
        "triangle" => faces::faces::<3>(&now),
        "quad" => faces::faces::<4>(&now),
        "sphere" => segments::spheres(&now),
        "cylinder" => segments::cylinders(&now, shapes),
        "cone" => segments::cones(&now, shapes),
        "curve" => segments::curves(&now, shapes),
        "isosurface" => {
            let field = now.object("field", types::SPATIAL_FIELD).ok_or("parameter 'field': missing")?;
            isosurface::isosurface(&now, &Field::new(field)?)
        }
        other => Err(format!("subtype '{other}': unsupported")),
    }
}
