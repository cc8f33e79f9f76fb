// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene's own light, which decides whether default lights are added. The rule is meant to be foreseen:
//! 1. A light or an environment of the scene counts, however dim; so does a shader of lights or skies.
//! 2. A visible surface with constant emission is a light, however dim.
//! 3. A visible surface whose emission is a texture is a light if its radiance is above 1 anywhere. Up to 1 it may be a display or a
//!    label, which is modelled to be seen in other light: pictures for screens get that light, files of floats do not.
//!
//! Space: linear radiance, any channel. Invariant: the answer does not depend on areas, on distances or on other
//! surfaces. Tests: `tests`; crates/cli/tests/program/display.rs.

use crate::render::ShaderTable;
use crate::scene::{Material, Mesh, ObjectId, RayMask, Scene};

/// The radiance up to which an emissive texture may be a display: white.
const DISPLAY: f32 = 1.0;

/// The light of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OwnLight {
    /// Nothing emits.
    Nothing,
    /// Emissive textures of radiance up to 1, and nothing else.
    Displays,
    /// Lights, an environment, or surfaces that emit.
    Lights,
}

/// The use of a picture, which decides about scenes whose only light is displays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A screen: displays are seen in light that is added.
    Screen,
    /// Measurement, or a file of floats: light is added only if nothing at all emits.
    Numbers,
}

impl Purpose {
    /// Whether a scene with this light gets default lights.
    #[must_use]
    pub fn needs_light(self, own: OwnLight) -> bool {
        own == OwnLight::Nothing || (own == OwnLight::Displays && self == Self::Screen)
    }
}

/// The light that `scene` has of its own. Emissive meshes count if a visible instance shows them to rays of light; in a scene
/// without visible instances, as while it is made, all meshes count. Shaders of surfaces do not: most of
/// those that could emit do not.
#[must_use]
pub fn own_light(scene: &Scene, shaders: &ShaderTable) -> OwnLight {
    if !scene.lights().is_empty() || !shaders.lights.is_empty() || shaders.environment.is_some() {
        return OwnLight::Lights;
    }
    let emits: Vec<OwnLight> = scene.materials().iter().map(|material| emission(scene, material)).collect();
    if emits.iter().all(|&light| light == OwnLight::Nothing) {
        return OwnLight::Nothing;
    }
    let of_mesh = |mesh: &Mesh| {
        let material = emits.get(mesh.material.index()).copied().unwrap_or(OwnLight::Nothing);
        if mesh.primitive_count() == 0 { OwnLight::Nothing } else { material }
    };
    let shown = shown_objects(scene);
    let brightest = if shown.is_empty() {
        scene.meshes().iter().map(|mesh| of_mesh(mesh)).max()
    } else {
        let meshes = shown
            .iter()
            .flat_map(|&(id, mask)| scene.objects()[id.index()].meshes.iter().map(move |mesh| (*mesh, mask)));
        let lights = meshes.filter_map(|(id, mask)| {
            let light = of_mesh(scene.meshes().get(id.index())?);
            // Visible only to the camera, it emits no light to other surfaces.
            Some(if mask.meets(RayMask::OTHER) { light } else { light.min(OwnLight::Displays) })
        });
        lights.max()
    };
    brightest.unwrap_or(OwnLight::Nothing)
}

/// Objects that visible instances show, within others too, with the rays that meet them; each once for each mask.
fn shown_objects(scene: &Scene) -> Vec<(ObjectId, RayMask)> {
    let objects = scene.objects();
    // Whether it was met, by rays of light and by others.
    let mut met = vec![[false; 2]; objects.len()];
    let mut pending: Vec<(ObjectId, RayMask)> = Vec::new();
    let visible = scene.instances().iter().filter(|instance| instance.visible);
    pending.extend(visible.map(|instance| (instance.object, instance.mask)));
    let mut shown = Vec::new();
    while let Some((id, mask)) = pending.pop() {
        if mask == RayMask::NONE {
            continue;
        }
        let Some(met) = met.get_mut(id.index()).map(|met| &mut met[usize::from(mask.meets(RayMask::OTHER))])
        else {
            continue;
        };
        if !std::mem::replace(met, true) {
            shown.push((id, mask));
            pending
                .extend(objects[id.index()].members.iter().map(|member| (member.object, mask & member.mask)));
        }
    }
    shown
}

/// The light that surfaces of a material are.
fn emission(scene: &Scene, material: &Material) -> OwnLight {
    if !material.emits() {
        return OwnLight::Nothing;
    }
    let texture = material.emission_texture.and_then(|to| scene.textures().get(to.texture.index()));
    let Some(texels) = texture.map(|texture| &*texture.texels) else { return OwnLight::Lights };
    // Texels that are no floats are 1 at most: then the first that is not black decides.
    let may_be_bright = texels.is_float() || material.emission.iter().any(|&factor| factor > DISPLAY);
    let mut found = OwnLight::Nothing;
    for row in 0..texels.height as usize {
        for column in 0..texels.width as usize {
            let texel = texels.texel(column, row);
            let radiance = (0..3).map(|k| material.emission[k] * texel[k]).fold(0.0, f32::max);
            if radiance > DISPLAY {
                return OwnLight::Lights;
            }
            if radiance > 0.0 {
                found = OwnLight::Displays;
                if !may_be_bright {
                    return found;
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::image::{TexelData, Texels};
    use crate::scene::texture::{Filter, Wrap};
    use crate::scene::{Affine, Instance, Light, Member, Object, Primitives, Texture, texture::TextureRef};

    fn own_light(scene: &Scene) -> OwnLight {
        super::own_light(scene, &ShaderTable::default())
    }

    /// An object with a surface of area 1/2 of the emission, by a texture of these texels if there are some,
    /// and one of `other` that is dark.
    fn thing(emission: [f32; 3], texels: Option<TexelData>, other: f32) -> Scene {
        let mut scene = Scene::new();
        let mut glowing = Material::matte("glowing", [0.5; 3]);
        glowing.emission = emission;
        glowing.emission_texture = texels.map(|data| {
            let texels = Arc::new(Texels { width: 2, height: 1, data });
            let wrap = [Wrap::Repeat; 2];
            TextureRef::new(scene.add_texture(Texture {
                name: String::new(),
                texels,
                wrap,
                filter: Filter::Linear,
            }))
        });
        for (size, material) in [(1.0, glowing), (other, Material::matte("dark", [0.5; 3]))] {
            let material = scene.add_material(material);
            let positions = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
            let mesh =
                scene.add_mesh(Mesh { positions, indices: vec![[0, 1, 2]], material, ..Mesh::default() });
            let object = scene.add_object_of("", vec![mesh]);
            scene.instantiate(object, Affine::IDENTITY);
        }
        scene
    }

    fn srgb(red: u8) -> Option<TexelData> {
        Some(TexelData::Srgb8(vec![[0, 0, 0, 255], [red, 0, 0, 255]]))
    }

    #[test]
    fn constants_are_lights_whatever_else_there_is() {
        for emission in [1e-6, 0.05, 0.98, 1.0, 40.0] {
            for other in [0.01, 1.0, 1000.0] {
                let scene = thing([0.0, emission, 0.0], None, other);
                assert_eq!(own_light(&scene), OwnLight::Lights, "{emission} beside {other}");
            }
        }
        assert_eq!(own_light(&thing([0.0; 3], None, 1.0)), OwnLight::Nothing, "nothing emits");
    }

    #[test]
    fn textures_are_lights_above_white() {
        let float = |red: f32| Some(TexelData::Float(vec![[0.0; 4], [red, 0.0, 0.0, 1.0]]));
        for (factor, texels, expected) in [
            (1.0, srgb(255), OwnLight::Displays),
            (1.01, srgb(255), OwnLight::Lights),
            (1.01, srgb(200), OwnLight::Displays),
            (9.0, srgb(0), OwnLight::Nothing),
            (1.0, srgb(0), OwnLight::Nothing),
            (1.0, float(1.0), OwnLight::Displays),
            (1.0, float(7.0), OwnLight::Lights),
            (0.1, float(7.0), OwnLight::Displays),
            (1.0, float(f32::NAN), OwnLight::Nothing),
        ] {
            let name = format!("{factor} x {texels:?}");
            assert_eq!(own_light(&thing([factor; 3], texels, 5.0)), expected, "{name}");
        }
    }

    #[test]
    fn lights_count_where_they_are_shown() {
        let mut scene = thing([3.0; 3], None, 1.0);
        let emitter = scene.instances()[0].clone();
        let hidden = Instance { visible: false, ..emitter.clone() };
        let for_camera = Instance { mask: RayMask::CAMERA, ..emitter.clone() };
        let mut now = |instance: Instance| {
            *scene.edit_instance(crate::scene::InstanceId(0)) = instance;
            own_light(&scene)
        };
        assert_eq!(now(hidden.clone()), OwnLight::Nothing, "nobody sees it");
        assert_eq!(now(for_camera), OwnLight::Displays, "it lights nothing else");
        let for_none = Instance { mask: RayMask::NONE, ..emitter.clone() };
        assert_eq!(now(for_none), OwnLight::Nothing, "no ray meets it");
        assert_eq!(now(emitter.clone()), OwnLight::Lights, "seen by all");
        now(hidden);
        let held = scene.add_object(Object {
            members: vec![Member::new(emitter.object, Affine::IDENTITY)],
            ..Object::default()
        });
        assert_eq!(own_light(&scene), OwnLight::Nothing, "held by what is not shown");
        scene.instantiate(held, Affine::IDENTITY);
        assert_eq!(own_light(&scene), OwnLight::Lights, "held by what is");
    }

    #[test]
    fn lights_without_power_are_meant() {
        let mut scene = thing([0.0; 3], None, 1.0);
        scene.add_light(Light::Environment {
            radiance: [0.0; 3],
            texture: None,
            world_from_light: Affine::IDENTITY,
        });
        assert_eq!(own_light(&scene), OwnLight::Lights, "black was asked for");
    }

    #[test]
    fn scenes_in_the_making_count_their_meshes() {
        let mut scene = Scene::new();
        let mut emitter = Material::matte("lamp", [0.5; 3]);
        emitter.emission = [0.0, 0.2, 0.0];
        let material = scene.add_material(emitter);
        assert_eq!(own_light(&scene), OwnLight::Nothing, "a material that nothing is made of");
        let mut mesh = Mesh { positions: vec![[0.0; 3]; 3], material, ..Mesh::default() };
        scene.add_mesh(mesh.clone());
        assert_eq!(own_light(&scene), OwnLight::Nothing, "a mesh without triangles");
        let sphere = Mesh { primitives: Primitives::Spheres(vec![1.0]), ..mesh.clone() };
        mesh.indices = vec![[0, 1, 2]];
        for (mesh, what) in [(mesh, "a mesh"), (sphere, "a sphere")] {
            let mut scene = scene.clone();
            scene.add_mesh(mesh);
            assert_eq!(own_light(&scene), OwnLight::Lights, "{what}");
        }
    }

    #[test]
    fn displays_get_light_for_screens_only() {
        for (own, screen, numbers) in [
            (OwnLight::Nothing, true, true),
            (OwnLight::Displays, true, false),
            (OwnLight::Lights, false, false),
        ] {
            assert_eq!(Purpose::Screen.needs_light(own), screen, "{own:?} on a screen");
            assert_eq!(Purpose::Numbers.needs_light(own), numbers, "{own:?} in a file of floats");
        }
    }
}
