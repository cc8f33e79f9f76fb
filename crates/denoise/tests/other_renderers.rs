// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers under the names of other renderers.

use gnurt_denoise::{Method, Options, adopt, denoise, has_motion};
use gnurt_image::{ChannelData, Layer, Picture};

const SIZE: usize = 40;

/// A wall of two halves, with noise, and its layers under these names.
fn wall(albedo: (&str, [&'static str; 3]), normal: (&str, [&'static str; 3])) -> [Picture; 2] {
    let mut state = 3_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let side = |p: usize| if p % SIZE < SIZE / 2 { 0.2 } else { 0.8 };
    let mut truth = Picture::new(SIZE as u32, SIZE as u32);
    for (p, pixel) in truth.color.iter_mut().enumerate() {
        *pixel = [side(p), side(p), side(p), 1.0];
    }
    let mut noisy = truth.clone();
    for pixel in &mut noisy.color {
        *pixel = [0, 1, 2, 3].map(|k| if k < 3 { pixel[k] * (1.0 + noise()) } else { 1.0 });
    }
    let plane = |value: &dyn Fn(usize) -> f32| (0..SIZE * SIZE).map(value).collect::<Vec<f32>>();
    noisy.layers = vec![
        Layer::floats(albedo.0, albedo.1.map(|name| (name, plane(&side)))),
        Layer::floats(normal.0, normal.1.map(|name| (name, plane(&|_| 0.577)))),
    ];
    [truth, noisy]
}

fn error(a: &Picture, b: &Picture) -> f32 {
    a.color.iter().zip(&b.color).map(|(a, b)| (a[0] - b[0]).powi(2)).sum::<f32>()
}

#[test]
fn names_of_four_renderers_are_known() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    let options = Options { method: Method::BuiltIn, ..Options::default() };
    let (rgb, xyz) = (["R", "G", "B"], ["X", "Y", "Z"]);
    for (albedo, normal) in [
        (("ViewLayer.Denoising Albedo", rgb), ("ViewLayer.Denoising Normal", xyz)),
        (("denoise_albedo", rgb), ("N_noice", rgb)),
        (("albedo", rgb), ("nn", xyz)),
        (("Albedo", rgb), ("Ns", xyz)),
    ] {
        let [truth, noisy] = wall(albedo, normal);
        let mut picture = noisy.clone();
        assert!(denoise(&mut picture, &options, &pool).is_err(), "names are unknown before");
        let told = adopt(&mut picture);
        assert!(told.iter().any(|line| line.contains("variance")), "{told:?}");
        denoise(&mut picture, &options, &pool).expect("all layers are there now");
        let (before, after) = (error(&noisy, &truth), error(&picture, &truth));
        assert!(after < 0.1 * before, "{}: {after} of {before}", albedo.0);
    }
}

#[test]
fn own_layers_stay_and_vectors_of_cycles_turn() {
    let [_, mut picture] = wall(("albedo", ["R", "G", "B"]), ("N", ["X", "Y", "Z"]));
    let plane = |value: f32| vec![value; SIZE * SIZE];
    picture.layers.push(Layer::floats("variance", ["R", "G", "B"].map(|name| (name, plane(0.5)))));
    let before = picture.clone();
    assert!(adopt(&mut picture).is_empty() && picture == before, "nothing to do");
    let mut depth = plane(3.0);
    depth[0] = 1e10;
    picture.layers.push(Layer::floats("View Layer.Depth", [("V", depth)]));
    let vector = [("X", 1.0), ("Y", 2.0), ("Z", 3.0), ("W", 4.0)];
    picture.layers.push(Layer::floats("View Layer.Vector", vector.map(|(name, v)| (name, plane(v)))));
    adopt(&mut picture);
    let first = |layer: &str, name: &str| match &picture
        .layer(layer)
        .and_then(|layer| layer.channel(name))
        .expect("is made")
        .data
    {
        ChannelData::F32(values) => values[0],
        ChannelData::U32(values) => values[0] as f32,
    };
    assert!(has_motion(&picture), "for films");
    assert_eq!(
        ["X", "Y", "Z", "W"].map(|name| first("motion", name)),
        [1.0, -2.0, -3.0, 4.0],
        "to the right, down"
    );
    assert_eq!(first("depth", "Z"), f32::INFINITY, "nothing was met");
    assert_eq!(first("id", "object"), u32::MAX as f32, "nothing was met");
}
