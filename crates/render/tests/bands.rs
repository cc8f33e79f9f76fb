// SPDX-License-Identifier: GPL-3.0-or-later
//! Bands of rows have the pixels and layers of the whole picture.

use gnurt_image::{ChannelData, Picture};
use gnurt_render::{Integrator, LightLayer, MatteKind, Mattes, RenderOptions, Silent, render};
use gnurt_scene::{Light, Scene};

use crate::common::*;

/// Values as bits, by channel.
type Bits = Vec<(String, Vec<u32>)>;

/// The values of a picture's colours and channels in these rows, as bits.
fn bits(picture: &Picture, [top, end]: [u32; 2]) -> Bits {
    let width = picture.width as usize;
    let range = top as usize * width..end as usize * width;
    let mut all: Bits = (0..4)
        .map(|c| (c.to_string(), picture.color[range.clone()].iter().map(|p| p[c].to_bits()).collect()))
        .collect();
    for layer in &picture.layers {
        for channel in &layer.channels {
            let values = match &channel.data {
                ChannelData::F32(values) => values[range.clone()].iter().map(|x| x.to_bits()).collect(),
                ChannelData::U32(values) => values[range.clone()].to_vec(),
            };
            all.push((format!("{}.{}", layer.name, channel.name), values));
        }
    }
    all
}

fn scene() -> Scene {
    let mut scene = floor(0.6, 5.0);
    let red = matte(&mut scene, [0.8, 0.2, 0.1]);
    put_mesh(&mut scene, sphere([0.0, 0.0, 0.7], 0.7, 12, red));
    let light = emitter(&mut scene, [8.0, 7.0, 6.0]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 4.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], light));
    scene.add_light(Light::Point { position: [-3.0, -3.0, 2.0], intensity: [4.0; 3], radius: 0.0 });
    scene
}

#[test]
fn bands_are_rows_of_the_whole_picture() {
    let (world, camera) = (world_of(&scene(), false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0));
    let size = |spp| RenderOptions { aovs: true, vpls: 64, ..options(45, 75, spp) };
    let layers = vec![LightLayer::new("direct", "C<RD>L").expect("an expression")];
    let mattes = Mattes { kinds: MatteKind::ALL.to_vec(), depth: 4 };
    for options in [
        RenderOptions { integrator: Integrator::Path, light_layers: layers, mattes, ..size(5) },
        RenderOptions {
            integrator: Integrator::Path,
            noise: Some(0.2),
            crop: Some([3, 10, 40, 70]),
            ..size(40)
        },
        RenderOptions { integrator: Integrator::Whitted, ..size(2) },
        RenderOptions { integrator: Integrator::InstantRadiosity, ..size(2) },
        RenderOptions { integrator: Integrator::BidirectionalInstantRadiosity, ..size(2) },
        RenderOptions { integrator: Integrator::MetropolisInstantRadiosity, ..size(2) },
    ] {
        let whole = render(&world, &camera, &options, &pool(2), &Silent).expect("sound options").picture;
        for [top, end] in [[0, 32], [32, 75], [64, 75]] {
            let options = RenderOptions { rows: Some([top, end]), ..options.clone() };
            let band = render(&world, &camera, &options, &pool(1), &Silent).expect("sound options").picture;
            assert_eq!([band.width, band.height], [45, end - top]);
            assert!(band.check().is_ok(), "{:?}", band.check());
            let (found, expected) = (bits(&band, [0, end - top]), bits(&whole, [top, end]));
            for (found, expected) in found.iter().zip(&expected) {
                assert!(found == expected, "{} of rows {top} to {end}: {}", found.0, options.integrator);
            }
            assert_eq!(found.len(), expected.len(), "all layers");
        }
    }
}

#[test]
fn rows_that_cannot_be_alone_are_refused() {
    let with = |rows| RenderOptions { rows: Some(rows), ..options(40, 75, 1) };
    let of = |options: &RenderOptions| options.region().is_ok();
    assert!(of(&with([32, 64])) && of(&with([64, 75])));
    for rows in [[0, 31], [16, 64], [64, 64], [64, 96], [96, 75]] {
        let error = with(rows).region().expect_err("not rows of tiles").to_string();
        assert!(error.contains(&format!("rows {} to {} of 75", rows[0], rows[1])), "{error}");
    }
    let woven = RenderOptions { integrator: Integrator::InstantRadiosity, interleave: 3, ..with([0, 32]) };
    assert!(!of(&woven), "interleaved pixels");
}
