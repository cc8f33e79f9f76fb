// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials of the renderer: those that it has where they are the same, shaders with its closures otherwise.
//! Source: [PJH23] chapters 9, 10 and 14. A coat over a diffuse base adds up all paths between them:
//! (1 - Fi) r / (1 - r Fi), Fi being the coat's share of mirrored diffuse light from within. Roughness: alpha is its root.
//! Facets of pbrt lose light of several bounces between them; ours keep it, and are darkened by the same share: `microfacets`.
//! Tests: `tests/materials.rs`.

use gnurt_scene::detail::Interior;
use gnurt_scene::material::{Alpha, Color, Opacity, OpacityChannel, TextureRef};
use gnurt_scene::{Material as Made, ShaderFile, Surface, TextureId};

use crate::material::{Coat, Facets, Hair, HairColor, Material, Metal, Model};
use crate::microfacets::{STEPS, coated, table};
use crate::osl::{Code, Library, color, number};
use crate::patterns::FUNCTIONS;
use crate::texture::{Encoding, Image, Input, Mapping, Node, Texture};

/// Mixes may be nested this deep, and be made of so many.
const DEEPEST: u32 = 16;
const MOST: u32 = 64;
/// Perceptual roughness from which on facets lose light that counts.
const NARROW: f32 = 0.2;

/// The emission and opacity of a mesh, beside its material.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage {
    /// Radiance, of both sides?
    pub(crate) emission: Option<([f32; 3], bool)>,
    /// Multiplied to it.
    pub(crate) emission_picture: Option<TextureId>,
    pub(crate) alpha: Option<Input>,
}

/// A material, and the shader that it is shown by, if there is one.
pub(crate) fn make(
    number_of: u32,
    name: &str,
    coverage: &Coverage,
    library: &mut dyn Library,
) -> (Made, Option<ShaderFile>) {
    let Some(material) = library.material(number_of) else {
        return (Made::matte(name, [0.5; 3]), None);
    };
    let is_plain = material.normal_map.is_none() && material.bump.is_none();
    let surface = if is_plain { plain(&material.model, library) } else { None };
    let alpha = coverage.alpha.as_ref().map_or(Some(Alpha::Opaque), plain_alpha);
    let is_two_sided = coverage.emission.is_some_and(|(_, both)| both);
    if let (Some(surface), Some(alpha), false) = (&surface, alpha, is_two_sided) {
        let mut made = Made::of(name, surface.clone());
        made.alpha = alpha;
        made.emission = coverage.emission.map_or([0.0; 3], |(radiance, _)| radiance);
        made.emission_texture = coverage.emission_picture.map(TextureRef::new);
        return (made, None);
    }
    let mut code = Code::new(library);
    let text = shader(&material, coverage, alpha.is_none(), &mut code);
    let pictures = std::mem::take(&mut code.pictures);
    let mut made = Made::of(name, surface.unwrap_or(stand_in(&material.model)));
    made.alpha = alpha.unwrap_or(Alpha::Opaque);
    if !is_two_sided {
        made.emission = coverage.emission.map_or([0.0; 3], |(radiance, _)| radiance);
        made.emission_texture = coverage.emission_picture.map(TextureRef::new);
    }
    let shown = ShaderFile {
        file: format!("{name}.osl").into(),
        text: Some(text.into()),
        pictures,
        ..ShaderFile::default()
    };
    (made, Some(shown))
}

/// The surface in place of a material where shaders are not run.
fn stand_in(model: &Model) -> Surface {
    let base_color = match model {
        Model::Diffuse(color) | Model::CoatedDiffuse { reflectance: color, .. } => color.constant(),
        Model::DiffuseTransmission { reflectance, .. } => reflectance.constant(),
        _ => None,
    };
    Surface::Matte { base_color: Color::constant(base_color.unwrap_or([0.5; 3])) }
}

/// The renderer's own surface that is the same.
fn plain(model: &Model, library: &mut dyn Library) -> Option<Surface> {
    match model {
        Model::Diffuse(reflectance) => {
            plain_color(reflectance, library).map(|base_color| Surface::Matte { base_color })
        }
        Model::Conductor { metal, microfacets } => {
            let roughness = even(microfacets)?;
            if roughness > NARROW {
                return None;
            }
            let [eta, k] = match metal {
                Metal::Complex(eta, k) => [eta.constant()?, k.constant()?],
                Metal::Reflectance(reflectance) => {
                    let k = |r: f32| (2.0 * r.sqrt() / (1.0 - r).sqrt()).min(1e4);
                    [[1.0; 3], reflectance.constant()?.map(|r| k(r.clamp(0.0, 0.9999)))]
                }
            };
            Some(Surface::Metal { eta, k, roughness })
        }
        Model::Dielectric { index, abbe, microfacets } => {
            let roughness = even(microfacets)?;
            let interior =
                Interior { dispersion: abbe.map_or(0.0, |abbe| 20.0 / abbe), ..Interior::default() };
            let (ior, reflectance, transmittance) = (*index, [1.0; 3], [1.0; 3]);
            Some(match roughness {
                // Narrower than a thousandth, alpha is none.
                roughness if roughness * roughness < 1e-3 => {
                    Surface::Dielectric { ior, reflectance, transmittance, interior }
                }
                roughness if roughness <= NARROW => Surface::RoughDielectric {
                    ior,
                    roughness,
                    reflectance,
                    transmittance,
                    thin: false,
                    interior,
                },
                _ => return None,
            })
        }
        Model::ThinDielectric { index } => Some(Surface::RoughDielectric {
            ior: *index,
            roughness: 0.0,
            reflectance: [1.0; 3],
            transmittance: [1.0; 3],
            thin: true,
            interior: Interior::default(),
        }),
        _ => None,
    }
}

/// The perceptual roughness of facets that are as wide along u as along v, everywhere.
fn even(microfacets: &Facets) -> Option<f32> {
    let [u, v] = &microfacets.roughness;
    let [u, v] = [u.constant()?[0], v.constant()?[0]];
    // Alpha is the square of ours.
    let alpha = if microfacets.remap { u.max(0.0).sqrt() } else { u.max(0.0) };
    (u == v).then(|| alpha.min(1.0).sqrt())
}

/// A picture under the mesh's texture coordinates, and a factor.
fn plain_image(input: &Input) -> Option<(&Image, &Texture, f32)> {
    let Input::Texture(texture) = input else { return None };
    match &texture.node {
        Node::Image(image) => {
            let is_plain = !image.invert
                && image.wrap.is_some()
                && matches!(image.mapping, Mapping::Uv { .. })
                && !matches!(image.encoding, Encoding::Gamma(_));
            is_plain.then_some((image, &**texture, image.scale))
        }
        Node::Scale(of, by) => {
            let (image, texture, factor) = plain_image(of)?;
            Some((image, texture, factor * by.constant()?[0]))
        }
        _ => None,
    }
}

fn plain_texture(image: &Image, texture: &Texture, library: &mut dyn Library) -> Option<TextureRef> {
    let Mapping::Uv { scale, offset } = &image.mapping else { return None };
    let uv_from_mesh = [scale[0], 0.0, 0.0, scale[1], offset[0], offset[1]];
    Some(TextureRef { uv_from_mesh, ..TextureRef::new(library.picture(image, texture)?) })
}

fn plain_color(input: &Input, library: &mut dyn Library) -> Option<Color> {
    if let Some(value) = input.constant() {
        return Some(Color::constant(value.map(|x| x.clamp(0.0, 1.0))));
    }
    let (image, texture, factor) = plain_image(input)?;
    if !(0.0..=1.0).contains(&factor) {
        return None;
    }
    Some(Color { factor: [factor; 3], texture: Some(plain_texture(image, texture, library)?) })
}

fn plain_alpha(input: &Input) -> Option<Alpha> {
    let factor = input.constant()?[0].clamp(0.0, 1.0);
    if factor >= 1.0 {
        return Some(Alpha::Opaque);
    }
    Some(Alpha::Blend { opacity: Opacity { factor, texture: None, channel: OpacityChannel::Red } })
}

/// The text of a shader.
fn shader(material: &Material, coverage: &Coverage, has_alpha: bool, code: &mut Code) -> String {
    normals(material, code);
    let mut closure = model(&material.model, code, 0);
    if let Some((radiance, true)) = coverage.emission {
        let mut emitted = color(radiance);
        if let Some(id) = coverage.emission_picture {
            let name = format!("picture{}", id.0);
            code.pictures.push((name.clone(), id));
            emitted = format!("{emitted} * color (texture (\"{name}\", u, 1 - v, \"wrap\", \"clamp\"))");
        }
        closure = format!("{closure} + {emitted} * emission ()");
    }
    if let (Some(alpha), true) = (&coverage.alpha, has_alpha) {
        let alpha = code.float(alpha);
        let name = code.name('f');
        code.line(format!("float {name} = clamp ({alpha}, 0, 1);"));
        closure = format!("{name} * ({closure}) + (1 - {name}) * transparent ()");
    }
    code.line(format!("Ci = {closure};"));
    let body = std::mem::take(&mut code.text);
    format!("{FUNCTIONS}\nsurface pbrt ()\n{{\n{body}}}\n")
}

/// Statements that make `Nn`, the normal that lobes lie around, and `T`, along which facets are brushed.
fn normals(material: &Material, code: &mut Code) {
    code.line("normal Nn = normalize (N);");
    code.line("vector T = normalize (dPdu - Nn * dot (Nn, dPdu));");
    if let Some(path) = &material.normal_map
        && let Some(id) = code.library.normals(path, material)
    {
        let name = format!("picture{}", id.0);
        code.pictures.push((name.clone(), id));
        code.line(format!("color map = texture (\"{name}\", u, 1 - v, \"wrap\", \"periodic\");"));
        code.line("vector local = 2 * vector (map[0], map[1], map[2]) - vector (1);");
        code.line("normal outer = backfacing () ? -Nn : Nn;");
        code.line("vector B = cross (outer, T); B = dot (B, dPdv) < 0 ? -B : B;");
        code.line("vector turned = normalize (local[0] * T + local[1] * B + local[2] * outer);");
        code.line("Nn = backfacing () ? -turned : turned;");
    } else if let Some(bump) = &material.bump {
        let height = code.float(bump);
        code.line("normal outer = backfacing () ? -Nn : Nn;");
        code.line(format!("float height = {height};"));
        code.line("normal turned = normalize (calculatenormal (P + height * normalize (outer)));");
        code.line("normal flat = normalize (calculatenormal (P));");
        code.line("turned = normalize (outer + (dot (flat, outer) < 0 ? flat - turned : turned - flat));");
        code.line("Nn = backfacing () ? -turned : turned;");
    }
}

/// Alphas along and across, as expressions.
fn alphas(microfacets: &Facets, code: &mut Code) -> [String; 2] {
    let mut one = |input: &Input| {
        let roughness = code.float(input);
        let name = code.name('a');
        let alpha = match microfacets.remap {
            true => format!("sqrt (max ({roughness}, 0))"),
            false => format!("max ({roughness}, 0)"),
        };
        code.line(format!("float {name} = min ({alpha}, 1);"));
        name
    };
    let [u, v] = &microfacets.roughness;
    let along = one(u);
    let across = match (u.constant(), v.constant()) {
        (Some(a), Some(b)) if a == b => along.clone(),
        _ => one(v),
    };
    [along, across]
}

/// The mean share of diffuse light from outside that a glass of this index mirrors.
fn diffuse_mirrored(index: f32) -> f32 {
    const STEPS: usize = 256;
    let fresnel = |cosine: f32| {
        let sine = (1.0 - cosine * cosine) / (index * index);
        if sine >= 1.0 {
            return 1.0;
        }
        let beyond = (1.0 - sine).sqrt();
        let a = (index * cosine - beyond) / (index * cosine + beyond);
        let b = (cosine - index * beyond) / (cosine + index * beyond);
        0.5 * (a * a + b * b)
    };
    // Uniform in the square of the cosine.
    let sum: f32 = (0..STEPS).map(|i| fresnel(((i as f32 + 0.5) / STEPS as f32).sqrt())).sum();
    sum / STEPS as f32
}

fn coat(coat: &Coat, code: &mut Code) -> String {
    let [along, across] = alphas(&coat.microfacets, code);
    // A coat that is a mirror is drawn too bright over a base that scatters to all sides: narrow facets are the same to the eye.
    let [along, across] = [along, across].map(|alpha| format!("max ({alpha}, 0.002)"));
    let index = number(coat.index);
    format!("dielectric_bsdf (Nn, T, color (1), color (0), {along}, {across}, {index}, \"ggx\")")
}

/// Variables of a coat over a base: the shares of [`facets::Coated`](crate::facets::Coated) in the order of its fields.
/// `below` is the base's alpha, `None` if it is diffuse. Returns `None` if the coat is not as rough everywhere and both ways.
fn over(of: &Coat, below: Option<f32>, code: &mut Code) -> Option<[String; 3]> {
    let alpha = f64::from(even(&of.microfacets)?.powi(2));
    let table = coated(alpha, f64::from(of.index), below.map(f64::from));
    let at = code.name('f');
    code.line(format!("float {at} = sqrt (min (fabs (dot (Nn, normalize (I))), 1)) * {STEPS};"));
    let column = code.name('i');
    code.line(format!("int {column} = min (int ({at}), {});", STEPS - 1));
    Some([table.mirrored, table.out, table.again].map(|list| {
        let [row, value] = [code.name('k'), code.name('f')];
        let numbers: Vec<String> = list.into_iter().map(number).collect();
        code.line(format!("float {row}[{}] = {{ {} }};", numbers.len(), numbers.join(", ")));
        code.line(format!("float {value} = mix ({row}[{column}], {row}[{column} + 1], {at} - {column});"));
        value
    }))
}

/// A metal's indices and extinction coefficients, as variables; those within glass of an index.
fn metal(of: &Metal, within: f32, code: &mut Code) -> [String; 2] {
    let [eta, k] = [code.name('c'), code.name('c')];
    match of {
        Metal::Complex(indices, extinctions) => {
            let [indices, extinctions] = [code.color(indices), code.color(extinctions)];
            let within = number(within);
            code.line(format!("color {eta} = {indices} / {within};"));
            code.line(format!("color {k} = {extinctions} / {within};"));
        }
        Metal::Reflectance(reflectance) => {
            let reflectance = code.color(reflectance);
            let r = code.name('c');
            code.line(format!("color {r} = clamp ({reflectance}, color (0), color (0.9999));"));
            code.line(format!("color {eta} = color ({});", number(1.0 / within)));
            code.line(format!("color {k} = 2 * sqrt ({r}) / sqrt (color (1) - {r}) / {};", number(within)));
        }
    }
    [eta, k]
}

/// The share that facets send on after one bounce, as a variable, and the same for light from all sides; `index` is glass's, outside.
fn retained(
    microfacets: &Facets,
    [along, across]: &[String; 2],
    index: Option<f64>,
    code: &mut Code,
) -> [String; 2] {
    let alpha = even(microfacets).map(|roughness| roughness * roughness);
    let lobe_of = |index: Option<f64>, code: &mut Code| {
        let table: Vec<String> = table(alpha, index).into_iter().map(number).collect();
        let [rows, at, kept, all] = [code.name('k'), code.name('f'), code.name('f'), code.name('f')];
        code.line(format!("float {rows}[{}] = {{ {} }};", table.len(), table.join(", ")));
        code.line(format!("float {at} = sqrt (min (fabs (dot (Nn, normalize (I))), 1)) * {STEPS};"));
        let one = |at: &str, code: &mut Code| {
            let column = code.name('i');
            code.line(format!("int {column} = min (int ({at}), {});", STEPS - 1));
            if alpha.is_some() {
                return format!("mix ({rows}[{column}], {rows}[{column} + 1], {at} - {column})");
            }
            let [wide, row] = [code.name('f'), code.name('i')];
            code.line(format!("float {wide} = sqrt ({along} * {across}) * {STEPS};"));
            code.line(format!("int {row} = min (int ({wide}), {});", STEPS - 1));
            let width = STEPS + 1;
            let of = |more: &str| {
                let first = format!("({row}{more}) * {width} + {column}");
                format!("mix ({rows}[{first}], {rows}[{first} + 1], {at} - {column})")
            };
            format!("mix ({}, {}, {wide} - {row})", of(""), of(" + 1"))
        };
        let share = one(&at, code);
        code.line(format!("float {kept} = {share};"));
        // A cosine of two thirds stands for all.
        let mean = one("6.53", code);
        code.line(format!("float {all} = {mean};"));
        [kept, all]
    };
    let Some(outside) = index else { return lobe_of(None, code) };
    let [[out, out_all], [within, within_all]] =
        [outside, 1.0 / outside].map(|index| lobe_of(Some(index), code));
    let [kept, all] = [code.name('f'), code.name('f')];
    code.line(format!("float {kept} = backfacing () ? {within} : {out};"));
    code.line(format!("float {all} = backfacing () ? {within_all} : {out_all};"));
    [kept, all]
}

/// A metal's lobe without light of several bounces between its facets, and its reflectance at normal incidence.
fn metal_lobe(of: &Metal, microfacets: &Facets, within: f32, code: &mut Code) -> [String; 2] {
    let alphas = alphas(microfacets, code);
    let [eta, k] = metal(of, within, code);
    let [along, across] = &alphas;
    let lobe = format!("conductor_bsdf (Nn, T, {along}, {across}, {eta}, {k}, \"ggx\")");
    let mirrored = code.name('c');
    code.line(format!(
        "color {mirrored} = (({eta} - 1) * ({eta} - 1) + {k} * {k}) / (({eta} + 1) * ({eta} + 1) + {k} * {k});"
    ));
    if even(microfacets).is_some_and(|roughness| roughness <= NARROW) {
        return [lobe, mirrored];
    }
    let [kept, all] = retained(microfacets, &alphas, None, code);
    let share = code.name('c');
    code.line(format!(
        "color {share} = color ({kept}) / (color ({kept}) + (1 - {kept}) * {all} * {mirrored} / (color (1) - {mirrored} * (1 - {all})));"
    ));
    [format!("{share} * {lobe}"), format!("({mirrored} * {kept})")]
}

/// A model as an expression.
fn model(of: &Model, code: &mut Code, depth: u32) -> String {
    code.models += 1;
    if depth > DEEPEST || code.models > MOST {
        return "0.5 * diffuse (Nn)".into();
    }
    let clamped = |code: &mut Code, input: &Input| {
        let value = code.color(input);
        let name = code.name('c');
        code.line(format!("color {name} = clamp ({value}, color (0), color (1));"));
        name
    };
    match of {
        Model::Interface => "transparent ()".into(),
        Model::Diffuse(reflectance) => {
            let reflectance = clamped(code, reflectance);
            format!("{reflectance} * diffuse (Nn)")
        }
        Model::CoatedDiffuse { reflectance, coat: layer } => {
            let r = clamped(code, reflectance);
            let top = coat(layer, code);
            if even(&layer.microfacets).is_some_and(|roughness| roughness > NARROW)
                && let Some([mirrored, out, again]) = over(layer, None, code)
            {
                let base = format!("{r} * {out} / (color (1) - {r} * {again})");
                return format!("layer ({mirrored} * {top}, {base} * diffuse (Nn))");
            }
            // (1 - Fi) = (1 - Fe) / eta².
            let outer = diffuse_mirrored(layer.index);
            let inner = number(1.0 - (1.0 - outer) / (layer.index * layer.index));
            format!("layer ({top}, {r} * (1 - {inner}) / (color (1) - {r} * {inner}) * diffuse (Nn))")
        }
        Model::Conductor { metal: of, microfacets } => {
            let [lobe, _] = metal_lobe(of, microfacets, 1.0, code);
            lobe
        }
        Model::CoatedConductor { metal: of, microfacets, coat: layer } => {
            let [base, color] = metal_lobe(of, microfacets, layer.index, code);
            let top = coat(layer, code);
            let below = even(microfacets).map_or(0.3, |roughness| roughness * roughness);
            let Some([mirrored, out, again]) = over(layer, Some(below), code) else {
                return format!("layer ({top}, {base})");
            };
            if below < NARROW * NARROW {
                return format!(
                    "layer ({mirrored} * {top}, {out} / (color (1) - {color} * {again}) * {base})"
                );
            }
            // Light that has met a rough base twice goes to all sides.
            let alpha = even(&layer.microfacets).map_or(0.3, |roughness| roughness * roughness);
            let later = coated(f64::from(alpha), f64::from(layer.index), None);
            let [late_out, late_again] =
                [later.out, later.again].map(|list| number(list.last().copied().unwrap_or(0.5)));
            let late = format!("{again} * {color} * {late_out} / (color (1) - {color} * {late_again})");
            format!("layer ({mirrored} * {top}, (color ({out}) + {late}) * {base})")
        }
        Model::Dielectric { index, microfacets, .. } => {
            let alphas = alphas(microfacets, code);
            let [along, across] = &alphas;
            let is_narrow = even(microfacets).is_some_and(|roughness| roughness <= NARROW);
            let kept = match is_narrow {
                true => "1".to_owned(),
                false => retained(microfacets, &alphas, Some(f64::from(*index)), code)[0].clone(),
            };
            let index = number(*index);
            format!(
                "{kept} * dielectric_bsdf (Nn, T, color (1), color (1), {along}, {across}, {index}, \"ggx\")"
            )
        }
        Model::ThinDielectric { index } => {
            let f = code.name('f');
            code.line(format!(
                "float {f} = pbrt_fresnel (fabs (dot (Nn, normalize (I))), {});",
                number(*index)
            ));
            code.line(format!("{f} = {f} < 1 ? {f} + (1 - {f}) * (1 - {f}) * {f} / (1 - {f} * {f}) : 1;"));
            format!("{f} * reflection (Nn) + (1 - {f}) * transparent ()")
        }
        Model::DiffuseTransmission { reflectance, transmittance, scale } => {
            let [r, t] = [clamped(code, reflectance), clamped(code, transmittance)];
            let scale = number(*scale);
            format!("{scale} * ({r} * diffuse (Nn) + {t} * translucent (Nn))")
        }
        Model::Hair(hair) => {
            let Hair { color, roughness, index, tilt } = &**hair;
            let [along, around] = roughness.each_ref().map(|input| {
                let (value, name) = (code.float(input), code.name('a'));
                code.line(format!("float {name} = clamp ({value}, 0.01, 1);"));
                name
            });
            let (absorption, tilt) = (code.name('c'), code.float(tilt));
            let made = match color {
                HairColor::Absorption(color) => code.color(color),
                HairColor::Reflectance(color) => {
                    format!("pbrt_hair_absorption ({}, {around})", code.color(color))
                }
                HairColor::Melanin(dark, red) => {
                    let [dark, red] = [dark, red].map(|input| code.float(input));
                    format!("{dark} * color (0.419, 0.697, 1.37) + {red} * color (0.187, 0.4, 1.05)")
                }
            };
            code.line(format!("color {absorption} = max ({made}, color (0));"));
            code.line(format!(
                "{along} = pbrt_hair_variance ({along}); {around} = pbrt_hair_scale ({around});"
            ));
            format!(
                "chiang_hair_bsdf (Nn, dPdu, color (1), color (1), color (1), {}, {along}, 0.25 * {along}, 4 * {along}, \
                 {around}, {around}, {around}, radians ({tilt}), {absorption})",
                number(*index)
            )
        }
        Model::Mix { parts, amount } => {
            let amount = code.float(amount);
            let share = code.name('f');
            code.line(format!("float {share} = clamp ({amount}, 0, 1);"));
            let [a, b] = parts.map(|part| {
                let part = code.library.material(part);
                part.map_or("0.5 * diffuse (Nn)".into(), |part| model(&part.model, code, depth + 1))
            });
            format!("((1 - {share}) * ({a}) + {share} * ({b}))")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_mirrors_a_tenth_of_diffuse_light() {
        // Egan and Hilgeman's value for an index of 1.5.
        assert!((diffuse_mirrored(1.5) - 0.0918).abs() < 1e-3, "{}", diffuse_mirrored(1.5));
        assert!(diffuse_mirrored(1.0).abs() < 1e-6);
    }
}
