// SPDX-License-Identifier: GPL-3.0-or-later
//! Lamps whose shaders send their light to some directions alone: closed forms, and no light samples where they do not shine.

use std::f64::consts::PI;

use glam::Vec3;
use gnurt_render::{Integrator, RenderOptions, Silent, World, render};
use gnurt_scene::{Material, MaterialId, Mesh, Scene, Surface};
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{SurfaceBatch, SurfaceShader};

use crate::common::*;

/// Radiance from the front within an angle of a direction, as a part of it that falls off towards the edge.
struct Narrow {
    axis: Vec3,
    cos: f32,
}

impl Narrow {
    fn radiance(&self, dir: Vec3) -> f32 {
        4.0 * ((dir.dot(self.axis) - self.cos) / (1.0 - self.cos)).max(0.0)
    }
}

impl SurfaceShader for Narrow {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in (0..hits.len()).filter(|&i| hits.front(i)) {
            out.emit(i, Vec3::splat(self.radiance(-hits.ray_dir.get(i))));
        }
    }

    fn emits(&self) -> bool {
        true
    }
}

/// The visible point of the floor.
const SPOT: [f32; 3] = [0.1, 0.2, 0.0];
/// A square lamp of this size above it that looks down.
const CORNER: [f32; 3] = [-0.3, -0.4, 1.0];
const SIZE: f32 = 0.8;

fn pane(material: MaterialId) -> Mesh {
    quad(CORNER, [0.0, SIZE, 0.0], [SIZE, 0.0, 0.0], material)
}

fn shining(scene: &mut Scene) -> MaterialId {
    scene.add_material(Material::of("lamp", Surface::Shader(0)))
}

/// A picture of that point.
fn picture(world: &World, options: &RenderOptions) -> Vec<f64> {
    let view = camera([0.1, -1.5, 0.8], SPOT, 0.01);
    let frame = render(world, &view, options, &pool(1), &Silent).expect("sound options");
    frame.picture.color.iter().map(|pixel| f64::from(pixel[0])).collect()
}

fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean over the pixels of the squared difference from the mean, over its square.
fn variance(values: &[f64]) -> f64 {
    let mean = mean_of(values);
    mean_of(&values.iter().map(|x| (x / mean - 1.0).powi(2)).collect::<Vec<_>>())
}

#[test]
fn narrow_panes_light_as_the_closed_form_says() {
    for degrees in [60.0_f32, 20.0] {
        let lamp = Narrow { axis: -Vec3::Z, cos: degrees.to_radians().cos() };
        // Midpoints of the pane, so many that its narrowest beam is resolved.
        const N: usize = 1024;
        let mut exact = 0.0;
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let at = |k: usize| SIZE * (k as f32 + 0.5) / N as f32;
            let offset = Vec3::from(CORNER) + Vec3::new(at(i), at(j), 0.0) - Vec3::from(SPOT);
            let (cos, area) = (f64::from(offset.normalize().z), f64::from(SIZE * SIZE) / (N * N) as f64);
            exact += 0.6 / PI * f64::from(lamp.radiance(-offset.normalize())) * cos * cos * area
                / f64::from(offset.length_squared());
        }
        let mut scene = floor(0.6, 10.0);
        let material = shining(&mut scene);
        put_mesh(&mut scene, pane(material));
        let world = world_with(&scene, lamp);
        let all = [Integrator::Whitted, Integrator::Path, Integrator::InstantRadiosity];
        for integrator in all {
            let options = RenderOptions { integrator, max_depth: 2, vpls: 256, ..options(8, 8, 1024) };
            let found = mean_of(&picture(&world, &options));
            assert_close(found, exact, 0.01, &format!("{integrator}, {degrees} degrees"));
        }
    }
}

/// Beside an even lamp, one that is much brighter but looks elsewhere adds nothing, and hardly any noise.
#[test]
fn lamps_that_look_elsewhere_are_not_sampled() {
    let mut plain = floor(0.6, 10.0);
    let even = emitter(&mut plain, [1.0; 3]);
    put_mesh(&mut plain, pane(even));
    let direct = RenderOptions { max_depth: 2, ..options(64, 64, 1) };
    let alone = picture(&world_of(&plain, false), &direct);
    let lamps: [fn(MaterialId) -> Mesh; 2] = [
        |material| ball([-0.5, 0.0, 0.7], 0.2, material),
        |material| quad([-1.0, -1.0, 0.1], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], material),
    ];
    for lamp in lamps {
        let mut both = plain.clone();
        let material = shining(&mut both);
        let dark = lamp(material);
        put_mesh(&mut both, dark);
        // Along x, 17 degrees upwards.
        let narrow = Narrow { axis: Vec3::new(1.0, 0.0, 0.3).normalize(), cos: 0.99 };
        let beside = picture(&world_with(&both, narrow), &direct);
        assert_close(mean_of(&beside), mean_of(&alone), 0.01, "the other lamp does not shine here");
        let ratio = variance(&beside) / variance(&alone);
        assert!(ratio < 1.2, "variance {ratio} of that without the other lamp");
    }
}

/// Fifty lamps in a row, so that choices walk a tree: only one of them shines on the visible point, the others away from it.
#[test]
fn trees_of_beams_are_unbiased() {
    let mut scene = floor(0.6, 10.0);
    let material = shining(&mut scene);
    for i in 0..50 {
        put_mesh(&mut scene, ball([0.3 * i as f32 - 7.3, 0.2, 2.0], 0.05, material));
    }
    let narrow = || Narrow { axis: -Vec3::Z, cos: 15.0_f32.to_radians().cos() };
    let world = world_with(&scene, narrow());
    let by = |integrator, spp| {
        let options = RenderOptions { integrator, max_depth: 2, vpls: 256, ..options(16, 16, spp) };
        mean_of(&picture(&world, &options))
    };
    // Spheres, far away for their size: intensities.
    let area = PI * 0.05_f64.powi(2);
    let one = |i: i32| {
        let offset = Vec3::new(0.3 * i as f32 - 7.3, 0.2, 2.0) - Vec3::from(SPOT);
        let cos = f64::from(offset.normalize().z);
        0.6 / PI * f64::from(narrow().radiance(-offset.normalize())) * area * cos
            / f64::from(offset.length_squared())
    };
    let exact: f64 = (0..50).map(one).sum();
    for integrator in [Integrator::Whitted, Integrator::Path, Integrator::InstantRadiosity] {
        assert_close(by(integrator, 64), exact, 0.01, &format!("{integrator}"));
    }
}
