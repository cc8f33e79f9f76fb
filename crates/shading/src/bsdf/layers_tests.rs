// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers, by colours. Original.

use glam::Vec3;

use super::tests::around_z;
use super::*;

/// Each colour of a layer takes from its own colour below, and leaves the others alone.
#[test]
fn layers_hide_by_colours() {
    let body = Lobe::lambert(Vec3::ONE);
    let tops = [
        Lobe::sheen(Vec3::ONE, 0.5).into(),
        Lobe::microfacets(0.4, Vec3::splat(0.3), Vec3::ONE).into(),
        Lobes::from(Lobe::lambert(Vec3::splat(0.4))),
    ];
    for top in tops {
        let of = |weight: Vec3| around_z(top.clone().times(weight).over(body));
        let (bare, all, some) = (of(Vec3::ZERO), of(Vec3::ONE), of(Vec3::Y));
        let (wo, wi) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.48, 0.6, 0.64));
        let [bare, all, some] = [bare, all, some].map(|bsdf| bsdf.eval(wo, wi));
        let expected = Vec3::new(bare.x, all.y, bare.z);
        assert!((some - expected).abs().max_element() < 1e-6, "{some}, not {expected}");
        assert!((bare.y - all.y).abs() > 1e-3, "the layer is seen");
    }
}
