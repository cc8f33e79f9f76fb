// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras of glTF. Properties that the format lacks go into `extras`, as `io::gltf::camera` reads them.
//! Source: glTF 2.0, section 3.10. Tests: `tests/save.rs`.

use serde_json::{Map, Value, json};

use gnurt_scene::camera::{Camera, Projection};

/// Angle of view of a camera that other programs take for a perspective, though it is none.
const SUBSTITUTE: f32 = 45.0;

pub(super) fn camera(camera: &Camera) -> Value {
    let perspective = |degrees: f32| json!({ "yfov": degrees.to_radians(), "znear": 0.01 });
    let mut extras = Map::new();
    let mut out = match camera.projection {
        Projection::Perspective => json!({ "type": "perspective", "perspective": perspective(camera.fov_y) }),
        Projection::Orthographic { height } => {
            let half = height / 2.0;
            // glTF requires a far plane; our renderer ignores it.
            let planes = json!({ "xmag": half, "ymag": half, "znear": 0.0, "zfar": 1e4 });
            json!({ "type": "orthographic", "orthographic": planes })
        }
        Projection::Fisheye | Projection::Panorama => {
            extras.insert("projection".into(), json!(camera.projection.to_string()));
            if camera.projection == Projection::Fisheye {
                extras.insert("fov".into(), json!(camera.fov_y));
            }
            json!({ "type": "perspective", "perspective": perspective(SUBSTITUTE) })
        }
    };
    out["name"] = json!(camera.name);
    if camera.lens.aperture > 0.0 {
        extras.insert("aperture".into(), json!(camera.lens.aperture));
        // The format has no target, and therefore no default focus.
        extras.insert("focus".into(), json!(camera.focus_distance()));
    }
    if camera.shift != [0.0; 2] {
        extras.insert("shift".into(), json!(camera.shift));
    }
    if !extras.is_empty() {
        out["extras"] = Value::Object(extras);
    }
    out
}
