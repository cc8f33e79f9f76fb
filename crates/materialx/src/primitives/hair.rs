// SPDX-License-Identifier: GPL-3.0-or-later
//! Conversions of what artists give: hair [CBTB16], metals [Gul14], roughness of microfacets, black bodies.

use crate::error::Error;
use crate::generator::{Call, Generator, Outputs};
use crate::types::{Ty, Value};

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let part = match call.category() {
        "deon_hair_absorption_from_melanin" => {
            let mut a = Vec::new();
            for name in ["melanin_concentration", "melanin_redness", "eumelanin_color", "pheomelanin_color"] {
                a.push(g.arg(call, name)?.first().to_owned());
            }
            g.needs("gnurt_melanin");
            format!("gnurt_melanin({})", a.join(", "))
        }
        "chiang_hair_absorption_from_color" => {
            let [color, width] = [g.arg(call, "color")?, g.arg(call, "azimuthal_roughness")?];
            g.needs("gnurt_hair_absorption");
            format!("gnurt_hair_absorption({}, {})", color.first(), width.first())
        }
        "roughness_anisotropy" => {
            let [roughness, anisotropy] = [g.arg(call, "roughness")?, g.arg(call, "anisotropy")?];
            let r = roughness.first();
            let alpha = g.name("float", &format!("clamp({r} * {r}, 1e-8, 1.0)"));
            let stretch = g.name("float", &format!("sqrt(1 - clamp({}, 0.0, 0.98))", anisotropy.first()));
            return Ok(Some(vec![format!("min({alpha} / {stretch}, 1.0)"), format!("{alpha} * {stretch}")]));
        }
        "roughness_dual" => {
            let roughness = g.arg(call, "roughness")?;
            let [x, y] = [&roughness.parts[0], &roughness.parts[1]];
            let y = g.name("float", &format!("({y} < 0 ? {x} : {y})"));
            return Ok(Some(vec![
                format!("clamp({x} * {x}, 1e-8, 1.0)"),
                format!("clamp({y} * {y}, 1e-8, 1.0)"),
            ]));
        }
        "blackbody" => {
            g.needs("gnurt_blackbody");
            format!("gnurt_blackbody({})", g.arg(call, "temperature")?.first())
        }
        _ => return Ok(None),
    };
    Ok(Some(vec![part]))
}

/// Widths of a hair's three lobes, along and around it.
pub(crate) fn roughness<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Outputs, Error> {
    let mut a = Vec::new();
    for name in ["longitudinal", "azimuthal", "scale_TT", "scale_TRT"] {
        a.push(g.arg(call, name)?.first().to_owned());
    }
    let [along, around] = ["clamp($, 0.001, 1.0)"; 2].map(str::to_owned);
    let along = g.name("float", &along.replace('$', &a[0]));
    let around = g.name("float", &around.replace('$', &a[1]));
    let root =
        g.name("float", &format!("0.726 * {along} + 0.812 * {along} * {along} + 3.7 * pow({along}, 20.0)"));
    let first = g.name("float", &format!("{root} * {root}"));
    let azimuth = format!("0.265 * {around} + 1.194 * {around} * {around} + 5.372 * pow({around}, 22.0)");
    let azimuth = g.name("float", &azimuth);
    let mut lobe = |name: &str, scale: Option<&String>| {
        let width = match scale {
            Some(scale) => g.name("float", &format!("{first} * {scale} * {scale}")),
            None => first.clone(),
        };
        (name.to_owned(), Value::new(Ty::Vector2, vec![width, azimuth.clone()]))
    };
    Ok(vec![lobe("roughness_R", None), lobe("roughness_TT", Some(&a[2])), lobe("roughness_TRT", Some(&a[3]))])
}
