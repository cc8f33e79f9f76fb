// SPDX-License-Identifier: GPL-3.0-or-later
//! Names of a material's factors in pointers, for reading and for writing.
//! Source: KHR_animation_pointer and the schemas of glTF 2.0 and of the KHR_materials extensions. Tests: `tests`
//! of `pointer`, `tests/save.rs::animations_are_written`.

use gnurt_scene::animation::{FactorPart, TexturePart};

/// Parts and their paths below a material.
const FACTORS: &[(FactorPart, &str)] = &[
    (FactorPart::BaseColor, "pbrMetallicRoughness/baseColorFactor"),
    (FactorPart::Metallic, "pbrMetallicRoughness/metallicFactor"),
    (FactorPart::Roughness, "pbrMetallicRoughness/roughnessFactor"),
    (FactorPart::Emission, "emissiveFactor"),
    (FactorPart::AlphaCutoff, "alphaCutoff"),
    (FactorPart::NormalScale, "normalTexture/scale"),
    (FactorPart::EmissionStrength, "extensions/KHR_materials_emissive_strength/emissiveStrength"),
    (FactorPart::Ior, "extensions/KHR_materials_ior/ior"),
    (FactorPart::Specular, "extensions/KHR_materials_specular/specularFactor"),
    (FactorPart::SpecularColor, "extensions/KHR_materials_specular/specularColorFactor"),
    (FactorPart::Clearcoat, "extensions/KHR_materials_clearcoat/clearcoatFactor"),
    (FactorPart::ClearcoatRoughness, "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor"),
    (FactorPart::SheenColor, "extensions/KHR_materials_sheen/sheenColorFactor"),
    (FactorPart::SheenRoughness, "extensions/KHR_materials_sheen/sheenRoughnessFactor"),
    (FactorPart::Transmission, "extensions/KHR_materials_transmission/transmissionFactor"),
    (FactorPart::Thickness, "extensions/KHR_materials_volume/thicknessFactor"),
    (FactorPart::AttenuationColor, "extensions/KHR_materials_volume/attenuationColor"),
    (FactorPart::AttenuationDistance, "extensions/KHR_materials_volume/attenuationDistance"),
    (FactorPart::Dispersion, "extensions/KHR_materials_dispersion/dispersion"),
    (FactorPart::Anisotropy, "extensions/KHR_materials_anisotropy/anisotropyStrength"),
    (FactorPart::AnisotropyRotation, "extensions/KHR_materials_anisotropy/anisotropyRotation"),
    (FactorPart::Iridescence, "extensions/KHR_materials_iridescence/iridescenceFactor"),
    (FactorPart::IridescenceIor, "extensions/KHR_materials_iridescence/iridescenceIor"),
    (FactorPart::IridescenceThickness, "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum"),
    (
        FactorPart::DiffuseTransmission,
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
    ),
    (
        FactorPart::DiffuseTransmissionColor,
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
    ),
];

/// A part of a texture's transform as a part of the material.
type OfTexture = fn(TexturePart) -> FactorPart;

/// Textures with a transform, and their paths below a material.
const TEXTURES: &[(OfTexture, &str)] = &[
    (FactorPart::BaseTexture, "pbrMetallicRoughness/baseColorTexture"),
    (FactorPart::MetallicRoughnessTexture, "pbrMetallicRoughness/metallicRoughnessTexture"),
    (FactorPart::NormalTexture, "normalTexture"),
    (FactorPart::EmissionTexture, "emissiveTexture"),
    (FactorPart::AnisotropyTexture, "extensions/KHR_materials_anisotropy/anisotropyTexture"),
];

/// Parts of a transform, and their paths below a texture.
const TRANSFORM: &[(TexturePart, &str)] = &[
    (TexturePart::Offset, "extensions/KHR_texture_transform/offset"),
    (TexturePart::Rotation, "extensions/KHR_texture_transform/rotation"),
    (TexturePart::Scale, "extensions/KHR_texture_transform/scale"),
];

/// The part of a path.
pub(super) fn part_of(path: &str) -> Option<FactorPart> {
    let factor = FACTORS.iter().find(|(_, name)| *name == path).map(|(part, _)| *part);
    factor.or_else(|| {
        TEXTURES.iter().find_map(|(part, texture)| {
            let rest = path.strip_prefix(texture)?.strip_prefix('/')?;
            TRANSFORM.iter().find(|(_, name)| *name == rest).map(|(of, _)| part(*of))
        })
    })
}

/// The path of a part.
pub(crate) fn path_of(part: FactorPart) -> String {
    if let Some((_, name)) = FACTORS.iter().find(|(known, _)| *known == part) {
        return (*name).to_owned();
    }
    let all = TEXTURES
        .iter()
        .flat_map(|(of, texture)| TRANSFORM.iter().map(move |(t, name)| (of(*t), texture, name)));
    let mut all = all.filter(|(known, ..)| *known == part);
    all.next().map(|(_, texture, name)| format!("{texture}/{name}")).unwrap_or_default()
}
