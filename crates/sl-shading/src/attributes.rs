// SPDX-License-Identifier: GPL-3.0-or-later
//! Answers to `getattribute` about the camera of the picture, the path of a ray, the names and numbers of a point's geometry, and other
//! objects by their names.
//! Source: names, types and conversions of the Open Shading Language.
//! Tests: `tests/scripts/attributes.rs`.

use gnurt_shading::{CameraProjection, CameraProperties, SceneNames, SurfaceBatch};
use gnurt_sl::exec::Given;
use gnurt_sl::hir::Data;
use gnurt_sl::types::{Base, Type};

/// Names of these attributes begin so.
pub(crate) const CAMERA_PREFIX: &str = "camera:";

/// Names of a ray's attributes begin so.
pub(crate) const PATH_PREFIX: &str = "path:";

/// Whether an attribute depends on the path before the last ray.
pub(crate) fn is_of_bounces(name: &str) -> bool {
    name.starts_with(PATH_PREFIX) && name != "path:ray_length"
}

/// A named value of the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Ints(Vec<i32>),
    Floats(Vec<f32>),
    Text(&'static str),
}

/// An attribute of the camera.
pub(crate) fn of_camera(camera: &CameraProperties, name: &str) -> Option<Value> {
    let CameraProperties { resolution, projection, shutter, .. } = camera;
    let (near, far) = (0.0, CameraProperties::FAR);
    Some(match name.strip_prefix(CAMERA_PREFIX)? {
        "resolution" => Value::Ints(resolution.map(|n| n as i32).to_vec()),
        "pixelaspect" => Value::Floats(vec![1.0]),
        "projection" => Value::Text(match (*projection)? {
            CameraProjection::Perspective { .. } => "perspective",
            CameraProjection::Parallel { .. } => "orthographic",
            CameraProjection::Fisheye { .. } => "fisheye",
            CameraProjection::Panorama => "panorama",
        }),
        "fov" => Value::Floats(vec![camera.fov()?]),
        "clip_near" => Value::Floats(vec![near]),
        "clip_far" => Value::Floats(vec![far]),
        "clip" => Value::Floats(vec![near, far]),
        "shutter_open" => Value::Floats(vec![shutter[0]]),
        "shutter_close" => Value::Floats(vec![shutter[1]]),
        "shutter" => Value::Floats(shutter.to_vec()),
        "screen_window" => Value::Floats(camera.screen_window()?.to_vec()),
        _ => return None,
    })
}

/// An attribute of the path that came to a point: how often it was scattered, by kind, the transparent surfaces that it passed, and
/// the length of its last ray.
pub(crate) fn of_path(hits: &SurfaceBatch, lane: usize, name: &str) -> Option<Value> {
    let bounces = hits.bounces.get(lane).copied().unwrap_or_default();
    let [diffuse, glossy, through] = [bounces.diffuse, bounces.glossy, bounces.transmission].map(i32::from);
    Some(match name.strip_prefix(PATH_PREFIX)? {
        "ray_depth" => Value::Ints(vec![diffuse + glossy + through]),
        "diffuse_depth" => Value::Ints(vec![diffuse]),
        "glossy_depth" => Value::Ints(vec![glossy]),
        "transmission_depth" => Value::Ints(vec![through]),
        "transparent_depth" => Value::Ints(vec![bounces.transparent.into()]),
        "ray_length" => Value::Floats(vec![*hits.t.get(lane)?]),
        _ => return None,
    })
}

/// A value as the destination's type has it; with an index, one element of an array. `None` if it has no such form.
pub(crate) fn converted(value: &Value, index: Option<i32>, ty: Type) -> Option<Given> {
    let (ints, floats) = match value {
        Value::Text(text) => {
            let fits = ty == Type::STRING && index.is_none();
            return fits.then(|| Given::from(Data::Str(vec![(*text).into()])));
        }
        Value::Ints(list) => (Some(list), list.iter().map(|&x| x as f32).collect::<Vec<_>>()),
        Value::Floats(list) => (None, list.clone()),
    };
    let element = |i: i32| usize::try_from(i).ok().filter(|&i| floats.len() > 1 && i < floats.len());
    let range = match index {
        Some(index) => element(index).map(|i| i..i + 1)?,
        None => 0..floats.len(),
    };
    let is_triple = ty.base.is_triple();
    let found = match (&floats[range.clone()], ty.array) {
        ([x], 0) if is_triple => vec![*x; 3],
        ([x], 0) => vec![*x],
        ([x], 2) if !is_triple => vec![*x; 2],
        ([x, y], 0) if is_triple && ints.is_none() => vec![*x, *y, 0.0],
        (list, array) if !is_triple && usize::try_from(array).is_ok_and(|array| array == list.len()) => {
            // Elements of arrays are not converted.
            if (ty.base == Base::Int) != ints.is_some() {
                return None;
            }
            list.to_vec()
        }
        _ => return None,
    };
    match (ty.base, ints) {
        // Exactly, where they are given so.
        (Base::Int, Some(ints)) => {
            let exact = ints[range].iter().copied().cycle().take(found.len()).collect();
            Some(Given::from(Data::Int(exact)))
        }
        (Base::Int, None) => Some(Given::from(Data::Int(found.iter().map(|&x| x as i32).collect()))),
        (base, _) if base == Base::Float || is_triple => Some(Given::from(Data::Float(found))),
        _ => None,
    }
}

/// The kinds of parts that have a number, in the order of `AttributeRequest::IDS`.
const PARTS: [&str; 4] = ["instance", "object", "material", "prim"];
/// OSL's word for the name of the geometry.
pub(crate) const GEOMETRY: &str = "geom:name";

/// Whether a name is one of a part.
pub(crate) fn is_of_part(name: &str) -> bool {
    name == GEOMETRY || PARTS.contains(&name)
}

/// The number of a part as an int, or its name as a string. `ids` are the numbers of instance, object, material and
/// primitive.
pub(crate) fn of_part(hits: &SurfaceBatch, ids: [u32; 4], name: &str, ty: Type) -> Option<Given> {
    let part = PARTS.iter().position(|part| *part == name);
    if let (Some(part), true) = (part, ty == Type::INT) {
        return Some(Given::from(Data::Int(vec![ids[part] as i32])));
    }
    let names = hits.names.as_ref().filter(|_| ty == Type::STRING)?;
    let [instance, object, material, _] = ids;
    let text = match part {
        None if name == GEOMETRY => names.of_geometry(instance, object),
        Some(0) => names.instances.get(instance as usize)?,
        Some(1) => names.objects.get(object as usize)?,
        Some(2) => names.materials.get(material as usize)?,
        _ => return None,
    };
    Some(Given::from(Data::Str(vec![text.into()])))
}

/// An attribute of the object or instance with a name: its number and names, or a value that is the same all over it.
pub(crate) fn of_object(
    names: &SceneNames,
    object: &str,
    name: &str,
    index: Option<i32>,
    ty: Type,
) -> Option<Given> {
    let (instance, object) = names.find(object)?;
    if let Some(value) = names.constants.get(&object).and_then(|values| values.get(name)) {
        let list = match index {
            Some(index) => vec![*value.get(usize::try_from(index).ok()?)?],
            None => value.clone(),
        };
        return fitting(list, ty);
    }
    let text = match (name, ty) {
        ("object", Type::INT) => return Some(Given::from(Data::Int(vec![object as i32]))),
        ("instance", Type::INT) => return Some(Given::from(Data::Int(vec![instance? as i32]))),
        ("object", Type::STRING) => names.objects.get(object as usize)?,
        ("instance", Type::STRING) => names.instances.get(instance? as usize)?,
        (GEOMETRY, Type::STRING) => names.of_geometry(instance.unwrap_or(u32::MAX), object),
        _ => return None,
    };
    Some(Given::from(Data::Str(vec![text.into()])))
}

/// Numbers as the type has them; none if there are too few.
pub(crate) fn fitting(mut list: Vec<f32>, ty: Type) -> Option<Given> {
    if list.len() < ty.size() {
        return None;
    }
    list.truncate(ty.size().max(1));
    match ty.base {
        Base::Int => Some(Given::from(Data::Int(list.iter().map(|&x| x as i32).collect()))),
        base if base.is_float_based() => Some(Given::from(Data::Float(list))),
        _ => None,
    }
}
