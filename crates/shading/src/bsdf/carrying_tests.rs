// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of light paths against values of paths from the eye, over all models. Source: \[Vea97\] sections
//! 5.2 and 5.3; original.

use glam::Vec3;

use super::tests::{around_z, models, randoms, turned_over};
use super::*;
use crate::batch::SampleKey;
use crate::sampling::{sample_pair, uniform_sphere};

/// A path carried from the light has the value of the path from the eye, for any normals of the lobes, and
/// its stated density.
#[test]
fn light_paths_are_corrected() {
    let ng = Vec3::Z;
    let tilt = |lobes: &Lobes, normal: Vec3| {
        let mut tilted = lobes.clone();
        tilted.as_mut_slice().iter_mut().for_each(|lobe| lobe.normal = normal);
        tilted
    };
    let [a, b] = [Vec3::new(0.5, 0.1, 0.8), Vec3::new(-0.5, 0.3, 0.8)].map(Vec3::normalize);
    let body = Lobes::from(Lobe::lambert(Vec3::new(0.8, 0.6, 0.4)));
    let glassy = Lobes::from(Lobe::rough_glass(0.4, 0.66, Vec3::ONE, Vec3::ONE, false));
    let mut all: Vec<(String, Lobes)> = vec![
        ("two ways".into(), tilt(&body, a).mixed(Lobe { normal: b, ..Lobe::lambert(Vec3::ONE) }, 0.4)),
        ("tilted coat".into(), tilt(&Lobe::coat(0.3).into(), a).over(body.clone())),
        ("tilted below".into(), Lobes::from(Lobe::coat(0.3)).over(tilt(&body, b))),
        ("glass and paper".into(), glassy.clone().mixed(Lobe::translucent(Vec3::ONE), 0.5)),
        ("tilted glass and body".into(), tilt(&glassy, a).plus(body)),
    ];
    // Rough fibres, as other hair, are those of the view from either side.
    for (name, lobes) in models().into_iter().filter(|(name, _)| !name.starts_with("dark fibre that")) {
        all.push((format!("{name}, beside another normal"), tilt(&lobes, a).plus(Lobe::lambert(Vec3::ONE))));
        all.push((name, lobes));
    }
    let (mut some, mut mistakes) = ([0; 2], Vec::new());
    for (name, lobes) in all {
        let ns = if name.contains(',') { Vec3::new(0.3, -0.2, 0.9).normalize() } else { Vec3::Z };
        let bsdf = Bsdf::new(ns, lobes.clone());
        let mut over = turned_over(&lobes);
        over.as_mut_slice().iter_mut().for_each(|lobe| {
            (lobe.normal, lobe.tangent.z) = (-lobe.normal, -lobe.tangent.z);
        });
        let behind = Bsdf::new(-ns, over);
        for n in 0..48_u32 {
            let draw = |k| sample_pair(8, SampleKey { pixel: n, sample: 0, branch: 0 }, 0, k);
            let (light, eye) = (uniform_sphere(draw(0)), uniform_sphere(draw(1)));
            let light = if light.z < 0.0 { -light } else { light };
            let carrying = Carrying::new(&bsdf, light);
            let through = eye.z < 0.0;
            // Where geometry and shading do not agree on the side no light goes, nor do views that count as
            // grazing the point's normal.
            if ns.dot(light) < 2e-3 || through != (ns.dot(eye) < 0.0) || ns.dot(eye).abs() < 2e-3 {
                continue;
            }
            // Light of a path is measured per area across it: the cosines to ng stand for the surface.
            let found = carrying.eval_pdf(eye, ng).0 * carrying.correction(eye, ng);
            let from_eye = if through { behind.eval(eye, light) } else { bsdf.eval(eye, light) };
            let expected = from_eye * (ng.dot(eye) / ng.dot(light)).abs();
            let off = (found - expected).abs().max_element();
            if off > 4e-3 * expected.max_element() + 1e-5 {
                mistakes.push(format!("{name} {light} {eye}: {found}, not {expected}"));
            }
            some[usize::from(through)] += u32::from(expected.max_element() > 1e-3);
        }
        // Samples have the stated density and weight.
        let light = Vec3::new(-0.4, 0.3, 0.7).normalize();
        let carrying = Carrying::new(&bsdf, light);
        for u in randoms(32) {
            let Some(sample) = carrying.sample(u, ng).filter(|sample| !sample.delta) else { continue };
            let (value, pdf) = carrying.eval_pdf(sample.wi, ng);
            let value = value * carrying.correction(sample.wi, ng);
            assert!((sample.pdf - pdf).abs() <= 2e-3 * pdf, "{name}: {} is {pdf}", sample.pdf);
            let off = (sample.weight * pdf - value).abs().max_element();
            assert!(off <= 4e-3 * value.max_element() + 1e-5, "{name}: weight times density is the value");
        }
    }
    assert!(mistakes.is_empty(), "{} differ:\n{}", mistakes.len(), mistakes.join("\n"));
    assert!(some[0] > 1000 && some[1] > 100, "the test has something to test: {some:?}");
    let bsdf = Bsdf::new(Vec3::new(0.3, -0.2, 0.9).normalize(), Lobe::lambert(Vec3::ONE));
    let below = Carrying::new(&bsdf, Vec3::new(0.0, 0.9, 0.05));
    assert_eq!(below.correction(Vec3::Z, ng), Vec3::ZERO, "light from below");
}

/// Light paths at mirrors and smooth glass, by the definition: a reflection at a tilted plane counts by the
/// microfacet's cosines, a refraction by the square of the index, too.
#[test]
fn light_paths_of_deltas_are_corrected() {
    let (ng, light) = (Vec3::Z, Vec3::new(-0.4, 0.3, 0.7).normalize());
    let glass = around_z(Lobe::glass(1.0 / 1.5, Vec3::ONE, Vec3::ONE, false));
    let wi = glass.delta_branches(light)[1].expect("light enters").wi;
    let correction = Carrying::new(&glass, light).correction(wi, ng).x;
    assert!((correction - 1.0 / 2.25).abs() < 1e-5, "refraction: {correction}");
    let normal = Vec3::new(0.3, 0.1, 0.9).normalize();
    let tilted = Lobe { normal, ..Lobe::glass(1.0 / 1.5, Vec3::ONE, Vec3::ONE, false) };
    let lobes = Lobes::from(tilted).plus(Lobe { weight: Vec3::splat(0.25), ..Lobe::translucent(Vec3::ONE) });
    let bsdf = around_z(lobes);
    let carrying = Carrying::new(&bsdf, light);
    let (mut found, mut expected) = ([0.0; 2], [0.0; 2]);
    for (through, branch) in bsdf.delta_branches(light).into_iter().enumerate() {
        let BsdfSample { wi, weight, .. } = branch.expect("light goes both ways");
        let bent = if through == 1 { 1.0 / 2.25 } else { 1.0 };
        let cosines = (normal.dot(light) * ng.dot(wi) / (ng.dot(light) * normal.dot(wi))).abs();
        expected[through] = weight.x * bent * cosines;
    }
    let n = 4096;
    for sample in randoms(n).filter_map(|u| carrying.sample(u, ng)).filter(|sample| sample.delta) {
        found[usize::from(sample.transmitted)] += sample.weight.x / n as f32;
    }
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}");
    }
}
