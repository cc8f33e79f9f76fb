// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials and samplers in glTF's words.
//! Source: glTF 2.0 section 3.9 and the extensions below. Matte is rough plastic without reflections, a mirror smooth metal, glass transmits.

use serde_json::{Value, json};

use gnurt_scene::animation::{Animation, MovingMaterial};
use gnurt_scene::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence};
use gnurt_scene::material::{Alpha, Color, Material, Principled, Surface, TextureRef};
use gnurt_scene::texture::{Filter, TexcoordSet, Texture, Wrap};

/// Whether its base colour is outside of glTF's range.
pub(super) fn is_too_bright(material: &Material) -> bool {
    color(material).0.factor.iter().any(|&x| x > 1.0)
}

/// The base colour in glTF's words, and the metalness and roughness that go with it.
fn color(material: &Material) -> (Color, f32, f32) {
    match &material.surface {
        Surface::Matte { base_color } | Surface::RoughMatte { base_color, .. } => (*base_color, 0.0, 1.0),
        Surface::MetallicRoughness { base_color, metallic, roughness, .. } => {
            (*base_color, *metallic, *roughness)
        }
        Surface::Principled(p) => (p.base_color, p.metallic, p.roughness),
        Surface::ShadowCatcher { .. } => (material.surface.base_color(), 0.0, 1.0),
        Surface::Metal { roughness, .. } => (material.surface.base_color(), 1.0, *roughness),
        Surface::RoughDielectric { roughness, transmittance, .. } => {
            (Color::constant(*transmittance), 0.0, *roughness)
        }
        Surface::Mirror { reflectance } => (*reflectance, 1.0, 0.0),
        Surface::Dielectric { transmittance, .. } => (Color::constant(*transmittance), 0.0, 0.0),
        Surface::Unlit { color } => (*color, 0.0, 1.0),
        Surface::Shader(_) => (material.diffuse_color(), 0.0, 1.0),
    }
}

/// A material; `base_texture` returns the texture for its base colour, given that of its surface.
pub(super) fn material(
    material: &Material,
    base_texture: impl FnOnce(Option<TextureRef>) -> Option<TextureRef>,
) -> Value {
    let mut extensions = json!({});
    let (base, metallic, roughness) = color(material);
    match &material.surface {
        Surface::Matte { .. } | Surface::RoughMatte { .. } | Surface::ShadowCatcher { .. } => {
            extensions["KHR_materials_specular"] = json!({ "specularFactor": 0.0 });
        }
        Surface::MetallicRoughness { ior, .. } => set_ior(*ior, &mut extensions),
        Surface::Principled(p) => {
            set_ior(p.ior, &mut extensions);
            layers(p, &mut extensions);
        }
        Surface::RoughDielectric { ior, thin, interior, .. } => {
            set_ior(*ior, &mut extensions);
            extensions["KHR_materials_transmission"] = json!({ "transmissionFactor": 1.0 });
            if !thin {
                inside(interior, &mut extensions);
            }
        }
        Surface::Dielectric { ior, interior, .. } => {
            set_ior(*ior, &mut extensions);
            extensions["KHR_materials_transmission"] = json!({ "transmissionFactor": 1.0 });
            inside(interior, &mut extensions);
        }
        Surface::Unlit { .. } => extensions["KHR_materials_unlit"] = json!({}),
        Surface::Metal { .. } | Surface::Mirror { .. } | Surface::Shader(_) => {}
    }
    let (alpha, mode) = match material.alpha {
        Alpha::Opaque => (1.0, "OPAQUE"),
        Alpha::Mask { opacity, .. } => (opacity.factor, "MASK"),
        Alpha::Blend { opacity } => (opacity.factor, "BLEND"),
    };
    // Factors stop at 1.
    let [r, g, b] = base.factor.map(|x| x.clamp(0.0, 1.0));
    let mut pbr = json!({
        "baseColorFactor": [r, g, b, alpha], "metallicFactor": metallic, "roughnessFactor": roughness,
    });
    set_texture(&mut pbr, "baseColorTexture", base_texture(base.texture));
    // A volume has an inside and an outside.
    let is_sheet = extensions.get("KHR_materials_volume").is_none();
    let mut to = json!({ "name": material.name, "alphaMode": mode, "doubleSided": is_sheet });
    let details = match &material.surface {
        Surface::MetallicRoughness { metallic_roughness_texture, normal_texture, .. } => {
            Some((metallic_roughness_texture, normal_texture))
        }
        Surface::Principled(p) => Some((&p.metallic_roughness_texture, &p.normal_texture)),
        _ => None,
    };
    if let Some((metallic_roughness_texture, normal_texture)) = details {
        set_texture(&mut pbr, "metallicRoughnessTexture", *metallic_roughness_texture);
        if let Some(normal) = normal_texture {
            set_texture(&mut to, "normalTexture", Some(normal.texture));
            to["normalTexture"]["scale"] = json!(normal.scale);
        }
    }
    to["pbrMetallicRoughness"] = pbr;
    if let Alpha::Mask { cutoff, .. } = material.alpha {
        to["alphaCutoff"] = json!(cutoff);
    }
    if material.emits() {
        // Factors are 1 at most; the excess goes into the strength.
        let strength = material.emission.iter().copied().fold(1.0, f32::max);
        to["emissiveFactor"] = json!(material.emission.map(|e| e / strength));
        if strength > 1.0 {
            extensions["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": strength });
        }
        set_texture(&mut to, "emissiveTexture", material.emission_texture);
    }
    if extensions.as_object().is_some_and(|extensions| !extensions.is_empty()) {
        to["extensions"] = extensions;
    }
    to
}

/// Writes the emission of driven materials as the channels see it: factor and strength apart.
pub(super) fn set_driven(animation: &Animation, document: &mut Value) {
    for MovingMaterial { material, factors } in &animation.materials {
        let Some(to) = document["materials"].get_mut(material.index()) else { continue };
        to["emissiveFactor"] = json!(factors.emission.map(|x| x.clamp(0.0, 1.0)));
        if factors.emission_strength != 1.0 {
            to["extensions"]["KHR_materials_emissive_strength"] =
                json!({ "emissiveStrength": factors.emission_strength });
        } else if let Some(extensions) = to["extensions"].as_object_mut() {
            extensions.remove("KHR_materials_emissive_strength");
        }
        if to["extensions"].is_null() || to["extensions"].as_object().is_some_and(|all| all.is_empty()) {
            to.as_object_mut().map(|map| map.remove("extensions"));
        }
    }
}

/// The index of refraction, unless it is glTF's default.
fn set_ior(ior: f32, extensions: &mut Value) {
    if ior != 1.5 {
        extensions["KHR_materials_ior"] = json!({ "ior": ior });
    }
}

/// Layers above the body or instead of it; defaults of glTF are not written.
fn layers(p: &Principled, extensions: &mut Value) {
    let maps = &p.layer_textures;
    let mut put = |name: &str, mut values: Value, textures: &[(&str, Option<TextureRef>)]| {
        textures.iter().for_each(|(key, texture)| set_texture(&mut values, key, *texture));
        extensions[name] = values;
    };
    let has_map = maps.specular.or(maps.specular_color).is_some();
    if p.specular != 1.0 || p.specular_color != [1.0; 3] || has_map {
        put(
            "KHR_materials_specular",
            json!({ "specularFactor": p.specular, "specularColorFactor": p.specular_color }),
            &[("specularTexture", maps.specular), ("specularColorTexture", maps.specular_color)],
        );
    }
    if p.clearcoat > 0.0 {
        put(
            "KHR_materials_clearcoat",
            json!({ "clearcoatFactor": p.clearcoat, "clearcoatRoughnessFactor": p.clearcoat_roughness }),
            &[
                ("clearcoatTexture", maps.clearcoat),
                ("clearcoatRoughnessTexture", maps.clearcoat_roughness),
                ("clearcoatNormalTexture", maps.clearcoat_normal),
            ],
        );
    }
    if p.sheen_color != [0.0; 3] {
        put(
            "KHR_materials_sheen",
            json!({ "sheenColorFactor": p.sheen_color, "sheenRoughnessFactor": p.sheen_roughness }),
            &[("sheenColorTexture", maps.sheen_color), ("sheenRoughnessTexture", maps.sheen_roughness)],
        );
    }
    if p.transmission > 0.0 {
        put(
            "KHR_materials_transmission",
            json!({ "transmissionFactor": p.transmission }),
            &[("transmissionTexture", maps.transmission)],
        );
    }
    let Anisotropy { strength, rotation, texture } = p.anisotropy;
    if strength > 0.0 {
        put(
            "KHR_materials_anisotropy",
            json!({ "anisotropyStrength": strength, "anisotropyRotation": rotation }),
            &[("anisotropyTexture", texture)],
        );
    }
    let Iridescence { factor, ior, thickness, least_thickness } = p.iridescence;
    if factor > 0.0 {
        put(
            "KHR_materials_iridescence",
            json!({
                "iridescenceFactor": factor, "iridescenceIor": ior, "iridescenceThicknessMaximum": thickness,
                "iridescenceThicknessMinimum": least_thickness,
            }),
            &[
                ("iridescenceTexture", maps.iridescence),
                ("iridescenceThicknessTexture", maps.iridescence_thickness),
            ],
        );
    }
    let DiffuseTransmission { factor, color } = p.diffuse_transmission;
    if factor > 0.0 {
        put(
            "KHR_materials_diffuse_transmission",
            json!({ "diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": color }),
            &[
                ("diffuseTransmissionTexture", maps.diffuse_transmission),
                ("diffuseTransmissionColorTexture", maps.diffuse_transmission_color),
            ],
        );
    }
    if p.clearcoat > 0.0 && maps.clearcoat_normal_scale != 1.0 {
        let map = &mut extensions["KHR_materials_clearcoat"]["clearcoatNormalTexture"];
        if map.is_object() {
            map["scale"] = json!(maps.clearcoat_normal_scale);
        }
    }
    if !p.thin && (p.transmission > 0.0 || p.diffuse_transmission.factor > 0.0) {
        inside(&p.interior, extensions);
    }
}

/// The interior of solid glass; glTF marks solid glass by a thickness.
fn inside(interior: &Interior, extensions: &mut Value) {
    let mut volume = json!({ "thicknessFactor": 1.0 });
    // JSON has no infinity, which is the default.
    if interior.attenuation_distance.is_finite() {
        volume["attenuationColor"] = json!(interior.attenuation_color);
        volume["attenuationDistance"] = json!(interior.attenuation_distance);
    }
    extensions["KHR_materials_volume"] = volume;
    if interior.scatter_color != [0.0; 3] {
        extensions["KHR_materials_volume_scatter"] = json!({
            "multiscatterColor": interior.scatter_color, "scatterAnisotropy": interior.scatter_anisotropy,
        });
    }
    if interior.dispersion > 0.0 {
        extensions["KHR_materials_dispersion"] = json!({ "dispersion": interior.dispersion });
    }
}

fn set_texture(to: &mut Value, key: &str, texture: Option<TextureRef>) {
    let Some(TextureRef { texture, uv_from_mesh, set }) = texture else {
        return;
    };
    to[key] = json!({ "index": texture.0 });
    if set == TexcoordSet::Second {
        to[key]["texCoord"] = json!(1);
    }
    if uv_from_mesh != [1.0, 0.0, 0.0, 1.0, 0.0, 0.0] {
        to[key]["extensions"] = json!({ "KHR_texture_transform": transform(uv_from_mesh) });
    }
}

/// Scale, rotation and offset of glTF, whose v runs downwards; the inverse of the reader's `uv_from_mesh`.
fn transform([a, b, c, d, e, f]: [f32; 6]) -> Value {
    let rotation = b.atan2(a);
    let (sin, cos) = rotation.sin_cos();
    let scale = [a.hypot(b), c.hypot(d).copysign(a * d - b * c)];
    json!({ "scale": scale, "rotation": rotation, "offset": [e - sin * scale[1], 1.0 - cos * scale[1] - f] })
}

pub(super) fn sampler(texture: &Texture) -> Value {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge => 33071,
    };
    let filter = match texture.filter {
        Filter::Nearest => 9728,
        Filter::Linear => 9729,
    };
    json!({ "wrapS": wrap(texture.wrap[0]), "wrapT": wrap(texture.wrap[1]), "magFilter": filter, "minFilter": filter })
}
