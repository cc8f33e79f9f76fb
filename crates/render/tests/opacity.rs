// SPDX-License-Identifier: GPL-3.0-or-later
//! The opacity of pictures: what covers the background, and its share of the light.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, RenderOptions};
use gnurt_scene::material::{Alpha, Color, Opacity, OpacityChannel};
use gnurt_scene::medium::{Extent, Medium};
use gnurt_scene::{Material, Scene, Surface};

const SKY: [f32; 3] = [0.5, 1.0, 2.0];

/// A picture of a sky, from the origin upwards.
fn seen(scene: &mut Scene, integrator: Integrator, spp: u32) -> Picture {
    scene.add_light(environment(SKY));
    let options = RenderOptions { integrator, aovs: true, ..options(16, 16, spp) };
    frame(scene, &camera([0.0; 3], [0.0, 0.01, 1.0], 10.0), &options).picture
}

/// The mean light of the foreground, and its opacity.
fn front(picture: &Picture) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (pixel, behind) in picture.color.iter().zip(background(picture)) {
        (0..3).for_each(|k| sum[k] += f64::from(pixel[k] - behind[k]));
        sum[3] += f64::from(pixel[3]);
    }
    sum.map(|sum| sum / picture.pixel_count() as f64)
}

fn pane(scene: &mut Scene, z: f32, material: Material) {
    let material = scene.add_material(material);
    put_mesh(scene, quad([-9.0, -9.0, z], [0.0, 18.0, 0.0], [18.0, 0.0, 0.0], material));
}

/// A surface that covers this share, and emits where it does.
fn veil(share: f32) -> Material {
    let opacity = Opacity { factor: share, texture: None, channel: OpacityChannel::Alpha };
    Material { alpha: Alpha::Blend { opacity }, emission: [3.0; 3], ..Material::matte("veil", [0.0; 3]) }
}

#[test]
fn transparent_surfaces_show_the_background_in_their_share() {
    for integrator in [
        Integrator::Path,
        Integrator::InstantRadiosity,
        Integrator::BidirectionalInstantRadiosity,
        Integrator::MetropolisInstantRadiosity,
    ] {
        let mut scene = Scene::new();
        pane(&mut scene, 1.0, veil(0.0));
        let picture = seen(&mut scene, integrator, 4);
        assert_eq!(front(&picture), [0.0; 4], "{integrator}: nothing is there");

        let mut scene = Scene::new();
        pane(&mut scene, 1.0, veil(0.2));
        pane(&mut scene, 2.0, veil(0.5));
        let [r, g, b, opacity] = front(&seen(&mut scene, integrator, 64));
        assert_close(opacity, 0.6, 0.02, &format!("{integrator}: opacity"));
        for light in [r, g, b] {
            assert_close(light, 1.8, 0.04, &format!("{integrator}: light of the veils"));
        }

        let mut scene = Scene::new();
        pane(&mut scene, 1.0, veil(0.2));
        pane(&mut scene, 2.0, veil(1.0));
        let picture = seen(&mut scene, integrator, 16);
        assert_eq!(front(&picture)[3], 1.0, "{integrator}: something opaque is behind");
    }
}

#[test]
fn media_cover_what_they_take() {
    let seen_through = |medium: Medium| {
        let mut scene = Scene::new();
        scene.add_medium(Medium { extent: Extent::Around { centre: [0.0; 3], radius: 4.0 }, ..medium });
        front(&seen(&mut scene, Integrator::Path, 256))
    };
    let covered = 1.0 - (-0.2_f64 * 4.0).exp();
    let [r, g, b, opacity] = seen_through(Medium { absorption: [0.2; 3], ..Medium::default() });
    assert_close(opacity, covered, 0.01, "smoke that absorbs");
    assert!([r, g, b].iter().all(|light| light.abs() < 1e-6), "it brings no light: {r} {g} {b}");
    let [r, .., opacity] =
        seen_through(Medium { absorption: [0.2; 3], emission: [3.0; 3], ..Medium::default() });
    assert_close(opacity, covered, 0.01, "fire");
    assert_close(r, 3.0 * covered, 0.03, "the light of fire is not of the background");
    let [.., opacity] = seen_through(Medium { scattering: [0.2; 3], ..Medium::default() });
    assert_close(opacity, covered, 0.02, "fog");
}

#[test]
fn glass_and_mirrors_cover() {
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        interior: Default::default(),
    };
    for surface in [glass, Surface::Mirror { reflectance: Color::constant([1.0; 3]) }] {
        let mut scene = Scene::new();
        pane(&mut scene, 1.0, Material::of("", surface));
        let picture = seen(&mut scene, Integrator::Path, 4);
        assert_eq!(front(&picture)[3], 1.0, "their rays are not those of the camera");
    }
}
