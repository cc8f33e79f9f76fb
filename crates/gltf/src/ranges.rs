// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of a material outside of glTF's ranges; they are clamped when the material is made.
//! Source: glTF 2.0 section 5.19, 5.22 and the schemas of the KHR_materials extensions; KHR_materials_ior takes 0 for "mirrors all", which
//! is not known here. Tests: `tests/gltf.rs::numbers_out_of_range_are_told`.

use gnurt_scene::factors::Factors;

/// A message for each number out of range: name, value and range.
pub(super) fn out_of_range(factors: &Factors) -> Vec<String> {
    let f = factors;
    let mut wrong = Vec::new();
    let mut check = |name: &str, values: &[f32], expected: &str, is_right: &dyn Fn(f32) -> bool| {
        if let Some(value) = values.iter().find(|&&value| !is_right(value)) {
            wrong.push(format!("{name} {value}; expected {expected}"));
        }
    };
    let unit = |x: f32| (0.0..=1.0).contains(&x);
    let share = "0 to 1";
    // Colours above 1 are taken as they are.
    let positive = |x: f32| x >= 0.0 && x.is_finite();
    let any = "0 or more";
    let [r, g, b, a] = f.base_color;
    check("baseColorFactor", &[r, g, b], share, &positive);
    check("baseColorFactor's opacity", &[a], share, &unit);
    check("metallicFactor", &[f.metallic], share, &unit);
    check("roughnessFactor", &[f.roughness], share, &unit);
    check("emissiveFactor", &f.emission, share, &positive);
    check("emissiveStrength", &[f.emission_strength], any, &positive);
    check("alphaCutoff", &[f.alpha_cutoff], any, &positive);
    check("ior", &[f.ior], "1 or more", &|x| x > 0.0 && x.is_finite());
    check("specularFactor", &[f.specular], share, &unit);
    check("specularColorFactor", &f.specular_color, any, &positive);
    check("clearcoatFactor", &[f.clearcoat], share, &unit);
    check("clearcoatRoughnessFactor", &[f.clearcoat_roughness], share, &unit);
    check("sheenColorFactor", &f.sheen_color, share, &unit);
    check("sheenRoughnessFactor", &[f.sheen_roughness], share, &unit);
    check("transmissionFactor", &[f.transmission], share, &unit);
    check("thicknessFactor", &[f.thickness], any, &positive);
    check("attenuationColor", &f.attenuation_color, share, &unit);
    check("attenuationDistance", &[f.attenuation_distance], "more than 0", &|x| x > 0.0);
    check("dispersion", &[f.dispersion], any, &positive);
    check("anisotropyStrength", &[f.anisotropy], share, &unit);
    check("anisotropyRotation", &[f.anisotropy_rotation], "a finite angle", &f32::is_finite);
    check("iridescenceFactor", &[f.iridescence], share, &unit);
    check("iridescenceIor", &[f.iridescence_ior], "1 or more", &|x| x >= 1.0 && x.is_finite());
    check("iridescenceThicknessMaximum", &[f.iridescence_thickness], any, &positive);
    check("iridescenceThicknessMinimum", &[f.iridescence_least_thickness], any, &positive);
    check("diffuseTransmissionFactor", &[f.diffuse_transmission], share, &unit);
    check("diffuseTransmissionColorFactor", &f.diffuse_transmission_color, share, &unit);
    wrong
}
