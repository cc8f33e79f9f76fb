// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's cameras: perspective and orthographic, with the lens and fisheyes in `extras`.
//! Source: glTF 2.0, section 3.10; the words of `extras` are our own (docs/reference/cameras.md). Lengths: world units; angles: radians in glTF, degrees
//! in `extras`. Near and far planes are not read: nothing is clipped. Tests: `tests/gltf.rs`, `tests/save.rs`.

use serde_json::Value;

use super::json;
use gnurt_scene::camera::{Camera, Lens, Projection};

/// The camera at the origin, or the reason that it cannot be used. Faults in `extras` go to `complain`.
pub(super) fn described(
    name: &str,
    from: &json::Camera,
    mut complain: impl FnMut(String),
) -> Result<Camera, String> {
    let mut camera = match (&from.perspective, &from.orthographic) {
        (Some(perspective), _) => Camera { fov_y: perspective.yfov.to_degrees(), ..Camera::default() },
        (None, Some(parallel)) => {
            let projection = Projection::Orthographic { height: 2.0 * parallel.ymag.abs() };
            Camera { projection, ..Camera::default() }
        }
        (None, None) => return Err(format!("{name}: neither a perspective nor an orthographic camera")),
    };
    name.clone_into(&mut camera.name);
    let plain = camera.clone();
    let Some(Value::Object(extras)) = &from.extras else { return sound(camera) };
    let mut number = |key: &str, least: f64| {
        let value = extras.get(key)?;
        let found = value.as_f64().filter(|&x| x >= least && (x as f32).is_finite());
        if found.is_none() {
            complain(format!("{name}: extras.{key} is {value}, not a number of {least} or above"));
        }
        found.map(|x| x as f32)
    };
    let least = f64::from(f32::MIN_POSITIVE);
    camera.lens = Lens { aperture: number("aperture", 0.0).unwrap_or(0.0), focus: number("focus", least) };
    let angle = number("fov", least);
    if let Some(value) = extras.get("shift") {
        match serde_json::from_value(value.clone()) {
            Ok(shift) => camera.shift = shift,
            Err(_) => complain(format!("{name}: extras.shift is {value}, not a list of two numbers")),
        }
    }
    match extras.get("projection") {
        None => {}
        Some(Value::String(projection_name)) if *projection_name == plain.projection.to_string() => {}
        Some(Value::String(projection_name)) if projection_name == Projection::NAMES[2] => {
            camera.projection = Projection::Fisheye;
            camera.fov_y = angle.unwrap_or(180.0);
        }
        Some(Value::String(projection_name)) if projection_name == Projection::NAMES[3] => {
            camera.projection = Projection::Panorama
        }
        Some(other) => complain(format!(
            "{name}: unknown extras.projection {other}; valid are \"fisheye\" and \"panorama\""
        )),
    }
    sound(camera)
}

fn sound(camera: Camera) -> Result<Camera, String> {
    match camera.fault() {
        Some(fault) => Err(format!("{}: {fault}", camera.name)),
        None => Ok(camera),
    }
}
