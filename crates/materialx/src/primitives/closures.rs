// SPDX-License-Identifier: GPL-3.0-or-later
//! Distribution functions and shaders, as the language's closures. A surface shader is one closure too: its light, and
//! transparency where it is not opaque.

use crate::error::Error;
use crate::generator::{Call, Generator};
use crate::types::{Ty, Value};

/// Several inputs.
fn all<'a, const N: usize>(
    g: &mut Generator<'a>,
    call: &Call<'a>,
    names: [&str; N],
) -> Result<[Value; N], Error> {
    let mut values = Vec::new();
    for name in names {
        values.push(g.arg(call, name)?);
    }
    values.try_into().map_err(|_| g.fault(call.scope, call.node, "an input is missing"))
}

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let node = call.category().to_owned();
    let closure = match &*node {
        "oren_nayar_diffuse_bsdf" => {
            let names = ["weight", "normal", "color", "roughness", "energy_compensation"];
            let [w, n, color, roughness, keeps] = all(g, call, names)?.map(|value| value.first().to_owned());
            format!(
                "{w} * oren_nayar_diffuse_bsdf({n}, {color}, {roughness}, \"energy_compensation\", {keeps})"
            )
        }
        "burley_diffuse_bsdf" => {
            let [w, n, color, roughness] = all(g, call, ["weight", "normal", "color", "roughness"])?
                .map(|value| value.first().to_owned());
            format!("{w} * burley_diffuse_bsdf({n}, {color}, {roughness})")
        }
        "translucent_bsdf" => {
            let [w, n, color] =
                all(g, call, ["weight", "normal", "color"])?.map(|value| value.first().to_owned());
            format!("{w} * translucent_bsdf({n}, {color})")
        }
        "subsurface_bsdf" => {
            let names = ["weight", "normal", "color", "radius", "anisotropy"];
            let [w, n, color, radius, g0] = all(g, call, names)?.map(|value| value.first().to_owned());
            format!("{w} * subsurface_bssrdf({n}, {color}, {radius}, {g0})")
        }
        "sheen_bsdf" => {
            let mode = g.word(call, "mode")?;
            let [w, n, color, roughness] = all(g, call, ["weight", "normal", "color", "roughness"])?
                .map(|value| value.first().to_owned());
            let mode = i32::from(mode == "zeltner");
            format!("{w} * sheen_bsdf({n}, {color}, {roughness}, \"mode\", {mode})")
        }
        "dielectric_bsdf" => {
            let [w, tint, ior] =
                all(g, call, ["weight", "tint", "ior"])?.map(|value| value.first().to_owned());
            let (facets, film) = facets(g, call)?;
            let [mirrored, through] = scattered(g, call, &tint)?;
            let [n, t, x, y, distribution] = facets;
            let thin = if g.is_thin && through != "color(0)" { ", \"thin_walled\", 1" } else { "" };
            format!(
                "{w} * dielectric_bsdf({n}, {t}, {mirrored}, {through}, {x}, {y}, {ior}, {distribution}{film}{thin})"
            )
        }
        "conductor_bsdf" => {
            let [w, ior, k] =
                all(g, call, ["weight", "ior", "extinction"])?.map(|value| value.first().to_owned());
            let ([n, t, x, y, distribution], film) = facets(g, call)?;
            format!("{w} * conductor_bsdf({n}, {t}, {x}, {y}, {ior}, {k}, {distribution}{film})")
        }
        "generalized_schlick_bsdf" => {
            let names = ["weight", "color0", "color90", "exponent"];
            let [w, f0, f90, power] = all(g, call, names)?.map(|value| value.first().to_owned());
            let ([n, t, x, y, distribution], film) = facets(g, call)?;
            let [mirrored, through] = scattered(g, call, "color(1)")?;
            let (f0, f90) = if g.is_given(call, "color82") {
                let f82 = g.arg(call, "color82")?.first().to_owned();
                g.needs("gnurt_darkening_at_82");
                let dark =
                    g.name("color", &format!("gnurt_darkening_at_82({f0}, {f90}, {f82}, {power}, {n})"));
                (format!("max({f0} - {dark}, color(0))"), format!("max({f90} - {dark}, color(0))"))
            } else {
                (f0, f90)
            };
            format!(
                "{w} * generalized_schlick_bsdf({n}, {t}, {mirrored}, {through}, {x}, {y}, {f0}, {f90}, {power}, \
                 {distribution}{film})"
            )
        }
        "chiang_hair_bsdf" => {
            let tints =
                all(g, call, ["tint_R", "tint_TT", "tint_TRT"])?.map(|value| value.first().to_owned());
            let widths = all(g, call, ["roughness_R", "roughness_TT", "roughness_TRT"])?;
            let names = ["normal", "curve_direction", "ior", "cuticle_angle", "absorption_coefficient"];
            let [n, along, ior, angle, absorption] =
                all(g, call, names)?.map(|value| value.first().to_owned());
            let width = |i: usize| widths.iter().map(|w| w.parts[i].clone()).collect::<Vec<_>>().join(", ");
            format!(
                "chiang_hair_bsdf({n}, {along}, {}, {ior}, {}, {}, {angle}, color({absorption}))",
                tints.join(", "),
                width(0),
                width(1)
            )
        }
        "uniform_edf" => format!("uniform_edf({})", g.arg(call, "color")?.first()),
        "conical_edf" => {
            let names = ["color", "normal", "inner_angle", "outer_angle"];
            let [color, n, inner, outer] = all(g, call, names)?.map(|value| value.first().to_owned());
            g.needs("gnurt_cone");
            format!("gnurt_cone({n}, {inner}, {outer}) * uniform_edf({color})")
        }
        "generalized_schlick_edf" => {
            let names = ["color0", "color90", "exponent", "base"];
            let [f0, f90, power, base] = all(g, call, names)?.map(|value| value.first().to_owned());
            g.needs("gnurt_edge_color");
            scaled(&format!("gnurt_edge_color({f0}, {f90}, {power})"), &base)
        }
        "measured_edf" => {
            g.warn(call, "measured_edf shines evenly, without its file");
            format!("uniform_edf({})", g.arg(call, "color")?.first())
        }
        "absorption_vdf" => {
            format!("anisotropic_vdf(color(0), color({}), 0)", g.arg(call, "absorption")?.first())
        }
        "anisotropic_vdf" => {
            let names = ["absorption", "scattering", "anisotropy"];
            let [absorption, scattering, g0] = all(g, call, names)?.map(|value| value.first().to_owned());
            let all = g.name("color", &format!("color({absorption}) + color({scattering})"));
            format!("anisotropic_vdf(color({scattering}) / max({all}, color(1e-9)), {all}, {g0})")
        }
        "layer" => {
            let [top, base] = all(g, call, ["top", "base"])?;
            match (top.first(), base.first()) {
                ("0", _) => base.first().to_owned(),
                (_, "0") => top.first().to_owned(),
                // Matter inside.
                (top, base_text) if base.ty == Ty::Vdf => format!("{top} + {base_text}"),
                (top, base) => format!("layer({top}, {base})"),
            }
        }
        "mix" if call.out.is_closure() => {
            let [fg, bg, mix] = all(g, call, ["fg", "bg", "mix"])?.map(|value| value.first().to_owned());
            let share = g.name("float", &format!("clamp({mix}, 0.0, 1.0)"));
            sum(&[scaled(&format!("(1 - {share})"), &bg), scaled(&share, &fg)])
        }
        "mix" if call.out == Ty::Displacement => {
            let [fg, bg, mix] = all(g, call, ["fg", "bg", "mix"])?.map(|value| value.first().to_owned());
            format!("{bg} * (1.0 - {mix}) + {fg} * {mix}")
        }
        "add" if call.out.is_closure() => {
            let [a, b] = all(g, call, ["in1", "in2"])?.map(|value| value.first().to_owned());
            sum(&[a, b])
        }
        "multiply" if call.out.is_closure() => {
            let [a, b] = all(g, call, ["in1", "in2"])?.map(|value| value.first().to_owned());
            scaled(&b, &a)
        }
        "dot" if call.out.is_closure() || call.out == Ty::Displacement => {
            g.arg(call, "in")?.first().to_owned()
        }
        _ => return shader(g, call, &node),
    };
    // Zero is no closure of its own.
    Ok(Some(vec![if call.out.is_closure() { g.name("closure color", &closure) } else { closure }]))
}

/// A closure times a factor.
fn scaled(factor: &str, closure: &str) -> String {
    if closure == "0" { "0".to_owned() } else { format!("{factor} * {closure}") }
}

/// Closures together.
fn sum(closures: &[String]) -> String {
    let there: Vec<&str> =
        closures.iter().map(|closure| &**closure).filter(|closure| *closure != "0").collect();
    if there.is_empty() { "0".to_owned() } else { there.join(" + ") }
}

/// The frame, widths and distribution of microfacets; and the arguments of their film.
fn facets<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<([String; 5], String), Error> {
    let [roughness, n, t, thickness, index, distribution] = all(
        g,
        call,
        ["roughness", "normal", "tangent", "thinfilm_thickness", "thinfilm_ior", "distribution"],
    )?;
    if g.arg(call, "retroreflective")?.text.as_deref() == Some("true") {
        g.warn(call, "retroreflection is left out");
    }
    let film = match g.is_given(call, "thinfilm_thickness") {
        true => {
            format!(", \"thinfilm_thickness\", {}, \"thinfilm_ior\", {}", thickness.first(), index.first())
        }
        false => String::new(),
    };
    let [x, y] = [0, 1].map(|i: usize| roughness.parts[i].clone());
    Ok(([n.first().to_owned(), t.first().to_owned(), x, y, distribution.first().to_owned()], film))
}

/// The reflected and the transmitted part of a tint.
fn scattered<'a>(g: &mut Generator<'a>, call: &Call<'a>, tint: &str) -> Result<[String; 2], Error> {
    let mode = g.word(call, "scatter_mode")?;
    let part = |is_there: bool| if is_there { tint.to_owned() } else { "color(0)".to_owned() };
    Ok([part(mode != "T"), part(mode != "R")])
}

fn shader<'a>(g: &mut Generator<'a>, call: &Call<'a>, node: &str) -> Result<Option<Vec<String>>, Error> {
    let part = match node {
        "surface" => {
            let [bsdf, edf, opacity] = all(g, call, ["bsdf", "edf", "opacity"])?;
            let light = match (bsdf.first(), edf.first()) {
                ("0", "0") => "0".to_owned(),
                ("0", light) | (light, "0") => light.to_owned(),
                (bsdf, edf) => g.name("closure color", &sum(&[bsdf.to_owned(), edf.to_owned()])),
            };
            match opacity.first() {
                "1.0" => g.name("closure color", &light),
                opacity => {
                    let share = g.name("float", &format!("clamp({opacity}, 0.0, 1.0)"));
                    let clear = format!("(1 - {share}) * transparent()");
                    g.name("closure color", &sum(&[scaled(&share, &light), clear]))
                }
            }
        }
        "surface_unlit" => {
            let names = ["emission", "emission_color", "transmission", "transmission_color", "opacity"];
            let [e, e_color, t, t_color, opacity] =
                all(g, call, names)?.map(|value| value.first().to_owned());
            let through = g.name("float", &format!("clamp({t}, 0.0, 1.0)"));
            let share = g.name("float", &format!("clamp({opacity}, 0.0, 1.0)"));
            let light = format!("{share} * (1 - {through}) * {e} * uniform_edf({e_color})");
            let clear = format!("({share} * {through} * {t_color} + color(1 - {share})) * transparent()");
            g.name("closure color", &format!("{light} + {clear}"))
        }
        "surfacematerial" => {
            let [front, back, moved] =
                all(g, call, ["surfaceshader", "backsurfaceshader", "displacementshader"])?;
            if g.is_given(call, "displacementshader") && moved.first() != "vector(0)" {
                g.displacement = Some(moved.first().to_owned());
            }
            match back.first() {
                "0" => front.first().to_owned(),
                back => {
                    let shown = g.name("closure color", front.first());
                    g.body.push_str(&format!("    if (backfacing()) {shown} = {back};\n"));
                    shown
                }
            }
        }
        "displacement" => {
            let [d, scale] = all(g, call, ["displacement", "scale"])?;
            let (d, scale) = (
                match d.ty {
                    Ty::Float => format!("{} * vector(N)", d.first()),
                    // Along dPdu, dPdv and N, of unit length.
                    _ => {
                        let by = g.name("vector", d.first());
                        let along = g.name("vector", "normalize(dPdu - dot(dPdu, N) * N)");
                        let side = "((dot(cross(N, dPdu), dPdv) < 0) ? -1.0 : 1.0)";
                        let across = g.name("vector", &format!("{side} * cross(N, {along})"));
                        format!("({by}[0] * {along} + {by}[1] * {across} + {by}[2] * vector(N))")
                    }
                },
                scale.first(),
            );
            g.name("vector", &format!("{scale} * {d}"))
        }
        "volume" => {
            let [vdf, edf] = all(g, call, ["vdf", "edf"])?.map(|value| value.first().to_owned());
            g.warn(call, "volumes are left out");
            g.name("closure color", &sum(&[vdf, edf]))
        }
        "volumematerial" => g.arg(call, "volumeshader")?.first().to_owned(),
        _ => return Ok(None),
    };
    Ok(Some(vec![part]))
}

/// Lights: as surfaces that shine.
pub(crate) fn emit_light<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let closure = match call.category() {
        "light" => {
            let [edf, intensity, exposure] =
                all(g, call, ["edf", "intensity", "exposure"])?.map(|value| value.first().to_owned());
            scaled(&format!("{intensity} * pow(2.0, {exposure})"), &edf)
        }
        "directional_light" | "point_light" | "spot_light" => {
            g.warn(call, "lights of documents are left out");
            let [color, intensity] =
                all(g, call, ["color", "intensity"])?.map(|value| value.first().to_owned());
            format!("{intensity} * uniform_edf({color})")
        }
        _ => return Ok(None),
    };
    Ok(Some(vec![g.name("closure color", &closure)]))
}
