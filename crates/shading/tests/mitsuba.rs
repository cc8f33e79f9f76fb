// SPDX-License-Identifier: GPL-3.0-or-later
//! Facets, glass, panes and layers against values that were made apart from this code, with Mitsuba 3's parts.
//! Source: bench/renderers/mitsuba_values.py, which also says how Mitsuba's own models differ; tables of energy there are
//! quadratures at the very roughness, ours are interpolated.

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, Lobe, Lobes, Principled};

/// Share of a value, and of a white surface's, that interpolation may cost.
const RELATIVE: f32 = 0.002;
const OF_WHITE: f32 = 0.002;

#[test]
fn values_are_those_of_the_definitions() {
    let mut worst = (0.0, "");
    for line in include_str!("mitsuba.csv").lines().skip(1) {
        let (model, numbers) = line.split_once(',').expect("a name and numbers");
        let numbers: Vec<f32> = numbers.split(',').map(|n| n.parse().expect("a number")).collect();
        let [
            r,
            g,
            b,
            metallic,
            alpha,
            ior,
            coat,
            coat_alpha,
            sr,
            sg,
            sb,
            sheen_roughness,
            transmission,
            rest @ ..,
        ] = &numbers[..]
        else {
            panic!("too few numbers: {line}");
        };
        let [wo, wi, expected] = [0, 3, 6].map(|k| Vec3::from_slice(&rest[k..]));
        let base = Vec3::new(*r, *g, *b);
        let model: Lobes = match model {
            "layered" | "partly pane" | "partly glass" => {
                let mut layered = Principled::new(base, *metallic, alpha.sqrt(), *ior);
                (layered.coat, layered.coat_alpha) = (*coat, *coat_alpha);
                (layered.sheen, layered.sheen_roughness) = (Vec3::new(*sr, *sg, *sb), *sheen_roughness);
                (layered.transmission, layered.thin) = (*transmission, model == "partly pane");
                layered.into()
            }
            "glass" | "pane" => Lobe::rough_glass(*alpha, 1.0 / ior, Vec3::ONE, base, model == "pane").into(),
            other => panic!("no such model: {other}"),
        };
        let found = Bsdf::new(Vec3::Z, model).eval(wo, wi);
        let allowed = RELATIVE * expected + Vec3::splat(OF_WHITE * wi.z.abs() / std::f32::consts::PI);
        let off = ((found - expected).abs() / allowed).max_element();
        if off > worst.0 {
            worst = (off, line);
        }
    }
    assert!(worst.0 <= 1.0, "{} times as far off as it may be: {}", worst.0, worst.1);
}
