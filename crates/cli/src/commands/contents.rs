// SPDX-License-Identifier: GPL-3.0-or-later
//! What `gnurt info --json` lists one by one: meshes where they are shown, lights, cameras.
//! Space: world, metres where the format has units. A centroid is that of the surface: of triangles, weighted by their area.
//! Invariant: at most [`MOST_OCCURRENCES`] meshes and [`MOST_TRIANGLES`] triangles are measured. Tests: `tests/program/info.rs`.

use std::collections::BTreeMap;

use gnurt::scene::labels::Luminaire;
use gnurt::scene::nesting::Occurrence;
use gnurt::scene::{Affine, Light, Mesh, Projection, Scene};
use serde_json::{Value, json};

/// Meshes that are listed.
const MOST_OCCURRENCES: usize = 100_000;
/// Triangles that are measured.
const MOST_TRIANGLES: u64 = 1 << 28;

/// A surface that is measured.
struct Measured {
    triangles: u64,
    area: f64,
    min: [f64; 3],
    max: [f64; 3],
    /// Of centres by area.
    moment: [f64; 3],
}

impl Measured {
    fn nothing() -> Self {
        Self {
            triangles: 0,
            area: 0.0,
            min: [f64::INFINITY; 3],
            max: [f64::NEG_INFINITY; 3],
            moment: [0.0; 3],
        }
    }

    fn add(&mut self, mesh: &Mesh, world_from_object: &Affine) {
        for &triangle in &mesh.indices {
            let corners =
                triangle.map(|i| world_from_object.point(mesh.positions[i as usize].map(f64::from)));
            let [u, v]: [[f64; 3]; 2] =
                [1, 2].map(|i: usize| std::array::from_fn(|k| corners[i][k] - corners[0][k]));
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let area = cross.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0;
            self.triangles += 1;
            self.area += area;
            for k in 0..3 {
                self.moment[k] += area * corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0;
                for corner in &corners {
                    self.min[k] = self.min[k].min(corner[k]);
                    self.max[k] = self.max[k].max(corner[k]);
                }
            }
        }
    }

    fn centroid(&self) -> [f64; 3] {
        match self.area > 0.0 {
            true => self.moment.map(|x| x / self.area),
            false => std::array::from_fn(|k| (self.min[k] + self.max[k]) / 2.0),
        }
    }
}

/// One entry for each mesh where it is shown: of an object with several materials one, with a list of its parts.
pub(super) fn occurrences(scene: &Scene) -> Vec<Value> {
    let labels = scene.labels();
    let is_mesh = |found: &Occurrence<'_>| {
        let luminaire = labels.luminaires.get(&found.instance);
        let has_triangles = found.object.meshes.iter().any(|&id| scene.mesh(id).has_triangles());
        has_triangles && luminaire.is_none_or(|&luminaire| luminaire == Luminaire::Mesh)
    };
    let mut left = MOST_TRIANGLES;
    let shown = scene.occurrences().filter(is_mesh).take(MOST_OCCURRENCES);
    let affordable = shown.take_while(|found| {
        let triangles: u64 = found.object.meshes.iter().map(|&id| scene.mesh(id).indices.len() as u64).sum();
        left = left.saturating_sub(triangles);
        left > 0
    });
    affordable.map(|found| occurrence(scene, &found)).collect()
}

fn occurrence(scene: &Scene, found: &Occurrence<'_>) -> Value {
    let mut whole = Measured::nothing();
    let mut parts: BTreeMap<u32, (u64, f64)> = BTreeMap::new();
    for &id in &found.object.meshes {
        let mesh = scene.mesh(id);
        let (triangles, area) = (whole.triangles, whole.area);
        whole.add(mesh, &found.world_from_object);
        let part = parts.entry(mesh.material.0).or_default();
        *part = (part.0 + whole.triangles - triangles, part.1 + whole.area - area);
    }
    let name = |material: u32| {
        let named = scene.materials().get(material as usize).map(|material| &material.name[..]);
        named.filter(|name| !name.is_empty())
    };
    let labels = scene.labels();
    let bound = labels.bound_materials.get(&found.object_id).map(|name| &name[..]);
    // Of several materials that of the largest part.
    let largest =
        parts.iter().max_by(|a, b| a.1.1.total_cmp(&b.1.1)).and_then(|(&material, _)| name(material));
    let mut value = json!({
        "path": found.name,
        "triangles": whole.triangles + labels.flat_triangles.get(&found.object_id).copied().unwrap_or(0),
        "area": whole.area,
        "bounds": [whole.min, whole.max],
        "centroid": whole.centroid(),
        "material": bound.map_or(largest, |name| Some(name).filter(|name| !name.is_empty())),
    });
    let Value::Object(fields) = &mut value else { return value };
    if parts.len() > 1 {
        let part = |(&material, &(triangles, area)): (&u32, &(u64, f64))| json!({ "material": name(material), "triangles": triangles, "area": area });
        fields.insert("parts".into(), parts.iter().map(part).collect());
    }
    if let Some(control) = labels.control_meshes.get(&found.object_id) {
        let told = json!({ "scheme": control.scheme, "level": control.level, "control_triangles": control.triangles });
        fields.insert("subdivision".into(), told);
    }
    value
}

/// Lights without and with a surface of their own.
pub(super) fn lights(scene: &Scene) -> Vec<Value> {
    let labels = scene.labels();
    let named = scene.lights().iter().zip(0..).map(|(light, id)| {
        let name = labels.lights.get(&gnurt::scene::LightId(id));
        match light {
            Light::Point { position, intensity, radius } => json!({
                "type": "point", "name": name, "position": position, "intensity": intensity, "radius": radius,
            }),
            Light::Spot { position, direction, intensity, inner_angle, outer_angle, edge, radius } => json!({
                "type": "spot", "name": name, "position": position, "direction": direction, "intensity": intensity,
                "inner_angle": inner_angle.to_degrees(), "outer_angle": outer_angle.to_degrees(), "edge": edge, "radius": radius,
            }),
            Light::Directional { direction, irradiance, angle } => json!({
                "type": "directional", "name": name, "direction": direction, "irradiance": irradiance, "angle": angle.to_degrees(),
            }),
            Light::Environment { radiance, texture, .. } => {
                let texture = texture.map(|id| &scene.texture(id).name[..]);
                json!({ "type": "environment", "name": name, "radiance": radiance, "texture": texture })
            }
            Light::Backdrop { texture, .. } => {
                json!({ "type": "backdrop", "name": name, "texture": scene.texture(*texture).name })
            }
        }
    });
    let surfaces = labels.luminaires.iter().map(|(id, luminaire)| {
        let instance = scene.instance(*id);
        let mesh = scene.object(instance.object).meshes.first().map(|&id| scene.mesh(id));
        let radiance = mesh.map(|mesh| scene.material(mesh.material).emission);
        let position = instance.world_from_object.columns[3];
        json!({ "type": luminaire.name(), "name": instance.name, "position": position, "radiance": radiance })
    });
    named.chain(surfaces).collect()
}

/// Cameras.
pub(super) fn cameras(scene: &Scene) -> Vec<Value> {
    let camera = |camera: &gnurt::scene::Camera| {
        let height = match camera.projection {
            Projection::Orthographic { height } => Some(height),
            _ => None,
        };
        json!({
            "type": camera.projection.to_string(),
            "name": camera.name,
            "eye": camera.eye,
            "target": camera.target,
            "up": camera.up,
            "fov_y": camera.fov_y,
            "height": height,
            "shift": camera.shift,
            "aperture": camera.lens.aperture,
            "focus": camera.focus_distance(),
        })
    };
    scene.cameras().iter().map(camera).collect()
}
