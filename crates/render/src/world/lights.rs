// SPDX-License-Identifier: GPL-3.0-or-later
//! From lights and emissive triangles of the description to light shaders.
//! Source: original. All emissive triangles of all instances together are one light.
//! Proof: `crates/render/tests/lights.rs`.

use std::sync::Arc;

use glam::{Mat3, Vec3};
use gnurt_scene::material::TextureRef;
use gnurt_scene::{Light, Material, Scene};
use gnurt_shading::lights as shading;
use gnurt_shading::{EnvironmentShader, LightShader};

use super::ShaderTable;
use super::instance::PlacedInstance;
use super::materials::{coverage, emission, sampler};
use crate::error::CommitError;

type Lights = Vec<Arc<dyn LightShader>>;
type Environment = Option<Arc<dyn EnvironmentShader>>;

/// All lights, and what misses see.
pub(super) fn lights(
    scene: &Scene,
    instances: &[Option<PlacedInstance>],
    shaders: &ShaderTable,
    force_diffuse: bool,
) -> (Lights, Environment) {
    let mut lights = Lights::new();
    if let Some(triangles) = triangle_lights(scene, instances, force_diffuse) {
        lights.push(Arc::new(triangles));
    }
    lights.extend(scene.lights().iter().filter_map(punctual));
    lights.extend(shaders.lights.iter().cloned());
    if let Some(environment) = &shaders.environment {
        return (lights, Some(environment.clone()));
    }
    let (light, environment) = environment(scene);
    lights.extend(light);
    (lights, environment)
}

fn punctual(light: &Light) -> Option<Arc<dyn LightShader>> {
    match *light {
        Light::Point { position, intensity } => {
            Some(Arc::new(shading::PointLight { position: position.into(), intensity: intensity.into() }))
        }
        Light::Spot { position, direction, intensity, inner_angle, outer_angle } => {
            let (position, direction) = (Vec3::from(position), Vec3::from(direction));
            let spot =
                shading::SpotLight::new(position, direction, intensity.into(), inner_angle, outer_angle)?;
            Some(Arc::new(spot))
        }
        Light::Directional { direction, irradiance } => {
            Some(Arc::new(shading::DirectionalLight::new(direction.into(), irradiance.into())?))
        }
        Light::Environment { .. } => None,
    }
}

/// The last environment of the scene, as a light and as what misses see.
fn environment(scene: &Scene) -> (Option<Arc<dyn LightShader>>, Environment) {
    let last = scene.lights().iter().rev().find_map(|light| match light {
        Light::Environment { radiance, texture, world_from_light } => {
            Some((Vec3::from(*radiance), *texture, world_from_light))
        }
        _ => None,
    });
    let Some((radiance, texture, world_from_light)) =
        last.filter(|(radiance, ..)| radiance.max_element() > 0.0)
    else {
        return (None, None);
    };
    let Some(texture) = texture else {
        let constant = Arc::new(shading::ConstantEnvironment { radiance });
        return (Some(constant.clone()), Some(constant));
    };
    let [x, y, z, _] = world_from_light.to_f32();
    let unit = |v: [f32; 3]| Vec3::from(v).normalize_or_zero();
    let rotation = Mat3::from_cols(unit(x), unit(y), unit(z));
    let sampler = sampler(scene, &TextureRef::new(texture));
    match shading::PictureEnvironment::new(sampler, radiance, rotation) {
        Some(picture) => {
            let picture = Arc::new(picture);
            (Some(picture.clone()), Some(picture))
        }
        None => (None, None),
    }
}

/// Every triangle of a shining material, in the world.
fn triangle_lights(
    scene: &Scene,
    instances: &[Option<PlacedInstance>],
    force_diffuse: bool,
) -> Option<shading::TriangleLights> {
    let emitter = |material: &Material| {
        let emission = emission(scene, material)?;
        let coverage = if force_diffuse { None } else { coverage(scene, &material.alpha) };
        Some(Arc::new(shading::Emitter { emission, coverage }))
    };
    let by_material: Vec<_> = scene.materials().iter().map(emitter).collect();
    let emitters: Vec<_> = by_material.iter().flatten().cloned().collect();
    // Position among the emitters of each material that shines.
    let mut next = 0..;
    let number: Vec<Option<u32>> =
        by_material.iter().map(|emitter| emitter.as_ref().and_then(|_| next.next())).collect();
    let mut triangles = Vec::new();
    for instance in instances.iter().flatten() {
        for mesh in &instance.object.meshes {
            if let Some(emitter) = number[mesh.material.index()] {
                let shining = (0..mesh.indices.len()).filter_map(|i| triangle(instance, mesh, i, emitter));
                triangles.extend(shining);
            }
        }
    }
    shading::TriangleLights::new(triangles, emitters)
}

/// A triangle in the world; `None` if it cannot be traced, because what is not there does not shine.
fn triangle(
    instance: &PlacedInstance,
    mesh: &gnurt_scene::Mesh,
    prim_id: usize,
    emitter: u32,
) -> Option<shading::EmissiveTriangle> {
    let mut corners = mesh.indices[prim_id].map(|i| i as usize);
    if instance.mirrors {
        corners.swap(1, 2);
    }
    let position = |i: usize| mesh.positions.get(i).map(|&p| instance.point(p.into()));
    let p = [position(corners[0])?, position(corners[1])?, position(corners[2])?];
    let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    let uv = corners.map(|i| mesh.texcoords.get(i).copied().unwrap_or_default());
    (area > 0.0 && area.is_finite()).then_some(shading::EmissiveTriangle { p, uv, emitter })
}

/// Whether all ids of lights name something.
pub(super) fn check(scene: &Scene) -> Result<(), CommitError> {
    for (index, light) in scene.lights().iter().enumerate() {
        if let Light::Environment { texture: Some(texture), .. } = light
            && texture.index() >= scene.textures().len()
        {
            return Err(CommitError::DanglingId { what: "light", index, used: "texture", id: texture.0 });
        }
    }
    Ok(())
}
