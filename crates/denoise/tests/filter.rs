// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in denoiser on pictures whose truth is known.
//! Noise is uniform with the variance that the layer says.

use gnurt_denoise::{Error, Method, Options, denoise};
use gnurt_image::{ChannelData, Layer, Picture};
use gnurt_testkit::Random;
use proptest::prelude::*;

const SIZE: u32 = 48;

/// A pixel: irradiance, albedo, normal.
struct Pixel {
    light: f32,
    albedo: [f32; 3],
    normal: [f32; 3],
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

fn built_in() -> Options {
    Options { method: Method::BuiltIn, ..Options::default() }
}

/// Radiance of a pixel; `wave` is in -1..1.
fn radiance(pixel: &Pixel, noise: f32, wave: [f32; 3]) -> [f32; 4] {
    let value = |k: usize| pixel.light * pixel.albedo[k] * (1.0 + noise * wave[k]);
    [value(0), value(1), value(2), 1.0]
}

/// The truth, and the same with noise of this relative size.
fn pictures(noise: f32, at: impl Fn(u32, u32) -> Pixel) -> [Picture; 2] {
    let mut random = Random::new(11);
    let pixels: Vec<Pixel> = (0..SIZE * SIZE).map(|i| at(i % SIZE, i / SIZE)).collect();
    let mut truth = Picture::new(SIZE, SIZE);
    let mut noisy = truth.clone();
    for (i, pixel) in pixels.iter().enumerate() {
        truth.color[i] = radiance(pixel, 0.0, [0.0; 3]);
        noisy.color[i] = radiance(pixel, noise, [0; 3].map(|_| random.between(-1.0, 1.0)));
    }
    let plane = |value: &dyn Fn(usize) -> f32| (0..pixels.len()).map(value).collect::<Vec<f32>>();
    let albedo = |k: usize| plane(&|i| pixels[i].albedo[k]);
    let normal = |k: usize| plane(&|i| pixels[i].normal[k]);
    // The variance of a uniform number in -1..1 is a third.
    let variance = |k: usize| plane(&|i| (noise * truth.color[i][k]).powi(2) / 3.0);
    noisy.layers = vec![
        Layer::floats("albedo", [("R", albedo(0)), ("G", albedo(1)), ("B", albedo(2))]),
        Layer::floats("variance", [("R", variance(0)), ("G", variance(1)), ("B", variance(2))]),
        Layer::floats("N", [("X", normal(0)), ("Y", normal(1)), ("Z", normal(2))]),
    ];
    [truth, noisy]
}

fn clean(noisy: &Picture) -> Picture {
    let mut picture = noisy.clone();
    denoise(&mut picture, &built_in(), &pool(2)).expect("all layers are there");
    picture
}

/// Root of the mean square error, relative to the truth.
fn error(picture: &Picture, truth: &Picture) -> f32 {
    let squares = picture
        .color
        .iter()
        .zip(&truth.color)
        .map(|(a, b)| (0..3).map(|k| ((a[k] - b[k]) / b[k].max(1e-3)).powi(2)).sum::<f32>() / 3.0);
    (squares.sum::<f32>() / picture.color.len() as f32).sqrt()
}

fn flat(_: u32, _: u32) -> Pixel {
    Pixel { light: 0.7, albedo: [0.8, 0.5, 0.2], normal: [0.0, 0.0, 1.0] }
}

#[test]
fn a_constant_stays_what_it_is() {
    let [truth, noisy] = pictures(0.0, flat);
    assert!(error(&clean(&noisy), &truth) < 1e-5, "there is nothing to take out");
}

#[test]
fn noise_goes_and_the_mean_stays() {
    let [truth, noisy] = pictures(0.5, flat);
    let after = clean(&noisy);
    let (before, left) = (error(&noisy, &truth), error(&after, &truth));
    assert!(left < 0.15 * before, "of {before} there is left {left}");
    let mean = |picture: &Picture| picture.color.iter().map(|p| p[0]).sum::<f32>();
    let (mean_before, mean_after) = (mean(&noisy), mean(&after));
    assert!((mean_after / mean_before - 1.0).abs() < 0.005, "{mean_before} became {mean_after}");
    assert_eq!(after.layer("noisy").map(|l| l.channels.len()), Some(3), "the noisy picture is kept");
}

/// Largest relative error left and right of the middle, beyond which one would see an edge blurred.
fn at_the_edge(picture: &Picture, truth: &Picture) -> f32 {
    let columns = [SIZE / 2 - 2, SIZE / 2 - 1, SIZE / 2, SIZE / 2 + 1];
    let mean = |picture: &Picture, x: u32| {
        (0..SIZE).map(|y| picture.pixel(x, y).expect("inside")[1]).sum::<f32>() / SIZE as f32
    };
    columns.into_iter().map(|x| (mean(picture, x) / mean(truth, x) - 1.0).abs()).fold(0.0, f32::max)
}

#[test]
fn edges_of_albedo_are_kept() {
    let [truth, noisy] = pictures(0.5, |x, _| {
        let albedo = if x < SIZE / 2 { [0.8, 0.6, 0.4] } else { [0.2, 0.3, 0.1] };
        Pixel { albedo, ..flat(0, 0) }
    });
    let after = clean(&noisy);
    assert!(error(&after, &truth) < 0.15 * error(&noisy, &truth), "the light is one on both sides");
    let off = at_the_edge(&after, &truth);
    assert!(off < 0.05, "the edge is off by {off}");
}

#[test]
fn edges_of_normals_are_kept() {
    // Differences of light below the noise, which only the normal tells apart.
    let [truth, noisy] = pictures(0.5, |x, _| {
        let (light, normal) = if x < SIZE / 2 { (0.8, [1.0, 0.0, 0.0]) } else { (0.55, [0.0, 0.0, 1.0]) };
        Pixel { light, normal, ..flat(0, 0) }
    });
    let after = clean(&noisy);
    assert!(error(&after, &truth) < 0.2 * error(&noisy, &truth), "noise goes on both sides");
    let off = at_the_edge(&after, &truth);
    assert!(off < 0.06, "the edge is off by {off}");
}

#[test]
fn shadows_are_kept() {
    // No layer tells of a shadow: only colours do.
    let [truth, noisy] = pictures(0.3, |x, _| {
        let light = if x < SIZE / 2 { 1.0 } else { 0.2 };
        Pixel { light, ..flat(0, 0) }
    });
    let after = clean(&noisy);
    let off = at_the_edge(&after, &truth);
    assert!(off < 0.1, "the edge is off by {off}");
    assert!(error(&after, &truth) < 0.3 * error(&noisy, &truth), "and noise goes");
}

#[test]
fn bright_edges_have_no_dark_rims() {
    // A lamp with a smooth rim of normals beside it: a slope that fits both overshoots.
    let [_, noisy] = pictures(0.6, |x, y| {
        let light = if x < SIZE / 2 { 60.0 } else { 0.5 };
        let lean = (x as f32 - SIZE as f32 / 2.0 + (y % 3) as f32) * 0.2;
        Pixel { light, normal: [lean.clamp(-1.0, 1.0), 0.0, 0.2], ..flat(0, 0) }
    });
    let least = |picture: &Picture| picture.color.iter().map(|p| p[0]).fold(f32::MAX, f32::min);
    let (before, after) = (least(&noisy), least(&clean(&noisy)));
    assert!(after >= before, "nothing is darker than all there was: {after} of {before}");
}

#[test]
fn lamps_keep_their_edges_and_leave_no_noise_around() {
    // A lamp a hundred times as bright as the wall; pixels of the middle column see half of it, some more, some less.
    let mut random = Random::new(5);
    let covered: Vec<f32> = (0..SIZE * SIZE)
        .map(|i| match (i % SIZE).cmp(&(SIZE / 2)) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => random.between(0.3, 0.7),
            std::cmp::Ordering::Greater => 1.0,
        })
        .collect();
    let emitter = 50.0;
    let [mut truth, mut noisy] = pictures(0.6, |x, y| {
        let surface = 1.0 - covered[(y * SIZE + x) as usize];
        Pixel { light: 0.5, albedo: [0.8 * surface; 3], normal: [0.0, 0.0, 1.0] }
    });
    for picture in [&mut truth, &mut noisy] {
        for (pixel, covered) in picture.color.iter_mut().zip(&covered) {
            pixel[..3].iter_mut().for_each(|x| *x += emitter * covered);
        }
    }
    for channel in &mut noisy.layers[1].channels {
        let ChannelData::F32(variance) = &mut channel.data else { unreachable!("floats were written") };
        for (variance, covered) in variance.iter_mut().zip(&covered) {
            *variance += emitter * emitter * covered * (1.0 - covered) / 15.0;
        }
    }
    let emission = |_: usize| covered.iter().map(|c| emitter * c).collect::<Vec<f32>>();
    noisy
        .layers
        .push(Layer::floats("emission", [("R", emission(0)), ("G", emission(1)), ("B", emission(2))]));
    let after = clean(&noisy);
    let worst = |picture: &Picture, columns: std::ops::Range<u32>| {
        let at = |x: u32, y: u32| {
            let (a, b) = (picture.pixel(x, y).expect("inside"), truth.pixel(x, y).expect("inside"));
            (a[0] / b[0] - 1.0).abs()
        };
        columns.flat_map(|x| (0..SIZE).map(move |y| [x, y])).map(|[x, y]| at(x, y)).fold(0.0, f32::max)
    };
    let neighbour = worst(&after, SIZE / 2 - 4..SIZE / 2);
    assert!(neighbour < 0.35, "beside the lamp, noise of 0.6 became {neighbour}");
    let edge = worst(&after, SIZE / 2..SIZE);
    assert!(edge < 0.02, "the lamp and its edge stay what they are: {edge}");
}

#[test]
fn edges_of_sunlit_things_leave_no_noise_around() {
    // Noise of an object forty times as bright as its background exceeds everything else.
    let [truth, noisy] = pictures(0.5, |x, y| {
        let inside = (x as f32 - 20.0).hypot(y as f32 - 20.0) < 12.0;
        let (light, normal) = if inside { (20.0, [0.7, 0.0, 0.7]) } else { (0.5, [0.0, 0.0, 1.0]) };
        Pixel { light, normal, ..flat(0, 0) }
    });
    let (before, left) = (error(&noisy, &truth), error(&clean(&noisy), &truth));
    assert!(left < 0.8 * before, "of {before} there is left {left}");
}

#[test]
fn plain_walls_have_no_blotches() {
    let [truth, noisy] = pictures(0.8, flat);
    let after = clean(&noisy);
    // Means over squares of 12 x 12 pixels: the eye sees those.
    let square = |picture: &Picture, at: u32| {
        let (x0, y0) = (at % 4 * 12, at / 4 * 12);
        let inside = (0..144).map(|i| picture.pixel(x0 + i % 12, y0 + i / 12).expect("inside")[1]);
        inside.sum::<f32>() / 144.0
    };
    let spread = |picture: &Picture| {
        let off = |at| (square(picture, at) / square(&truth, at) - 1.0).powi(2);
        ((0..16).map(off).sum::<f32>() / 16.0).sqrt()
    };
    let (before, left) = (spread(&noisy), spread(&after));
    assert!(left < 0.8 * before, "squares differ by {left}, and by {before} with noise");
}

#[test]
fn rare_bright_samples_go_and_their_light_stays() {
    let [truth, mut noisy] = pictures(0.4, flat);
    let mut random = Random::new(9);
    let mut lit = 0.0;
    for i in 0..noisy.color.len() {
        if random.below(150) == 0 {
            let more = random.between(5.0, 40.0);
            noisy.color[i][..3].iter_mut().for_each(|x| *x *= 1.0 + more);
            for (k, channel) in noisy.layers[1].channels.iter_mut().enumerate() {
                let ChannelData::F32(variance) = &mut channel.data else {
                    unreachable!("floats were written")
                };
                variance[i] = noisy.color[i][k].powi(2);
            }
            lit += more / noisy.color.len() as f32;
        }
    }
    let after = clean(&noisy);
    // The expected value of their light if it were even.
    let mut even = truth.clone();
    even.color.iter_mut().for_each(|pixel| pixel[..3].iter_mut().for_each(|x| *x *= 1.0 + lit));
    let (before, left) = (error(&noisy, &even), error(&after, &even));
    assert!(left < 0.06 * before, "of {before} there is left {left}");
    let mean = |picture: &Picture| picture.color.iter().map(|p| p[0]).sum::<f32>();
    let retained = mean(&after) / mean(&noisy);
    // Fifteen pixels do not tell for sure how much light is missing.
    assert!((retained - 1.0).abs() < 0.12, "of all light there is {retained}");
}

#[test]
fn a_picture_of_one_sample_is_denoised_too() {
    let [truth, mut noisy] = pictures(0.5, flat);
    noisy.layers[1].channels.iter_mut().for_each(|c| c.data = ChannelData::F32(vec![0.0; noisy.color.len()]));
    let (before, left) = (error(&noisy, &truth), error(&clean(&noisy), &truth));
    assert!(left < 0.5 * before, "of {before} there is left {left}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let [_, noisy] = pictures(0.5, |x, y| Pixel { light: 1.0 + (x * y % 17) as f32, ..flat(x, y) });
    let [one, two, seven] = [1, 2, 7].map(|threads| {
        let mut picture = noisy.clone();
        denoise(&mut picture, &built_in(), &pool(threads)).expect("all layers are there");
        picture
    });
    assert!(one == two && one == seven, "threads must not show");
}

#[test]
fn only_the_region_changes() {
    let [_, noisy] = pictures(0.5, flat);
    let mut part = noisy.clone();
    let region = Some([5, 6, 31, 17]);
    denoise(&mut part, &Options { region, ..built_in() }, &pool(2)).expect("the region is inside");
    for y in 0..SIZE {
        for x in 0..SIZE {
            let inside = (5..31).contains(&x) && (6..17).contains(&y);
            assert_eq!(part.pixel(x, y) != noisy.pixel(x, y), inside, "pixel {x}, {y}");
        }
    }
    for region in [[0, 0, 0, 4], [0, 0, SIZE + 1, 4], [3, 9, 8, 9]] {
        let options = Options { region: Some(region), ..built_in() };
        let refused = denoise(&mut noisy.clone(), &options, &pool(1));
        assert!(matches!(refused, Err(Error::Region { .. })), "{region:?}: {refused:?}");
    }
}

#[test]
fn a_missing_layer_is_named() {
    let [_, mut noisy] = pictures(0.5, flat);
    noisy.layers.remove(2);
    let message = denoise(&mut noisy, &built_in(), &pool(1)).expect_err("no normals").to_string();
    assert!(message.contains("'N.X'"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn whatever_comes_in_what_goes_out_is_light(seed in any::<u64>(), width in 1u32..24, height in 1u32..24) {
        let mut random = Random::new(seed);
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, f32::MAX, 1e30, f32::MIN_POSITIVE, 1e-30];
        let mut value = || if random.below(8) == 0 { random.pick(&odd) } else { random.between(0.0, 2.0) };
        let mut picture = Picture::new(width, height);
        picture.color.iter_mut().for_each(|pixel| *pixel = [value(), value(), value(), 1.0]);
        let pixels = picture.pixel_count();
        for (name, channels) in [("albedo", ["R", "G", "B"]), ("variance", ["R", "G", "B"]), ("N", ["X", "Y", "Z"]), ("emission", ["R", "G", "B"])] {
            let channels = channels.map(|channel| (channel, (0..pixels).map(|_| value()).collect()));
            picture.layers.push(Layer::floats(name, channels));
        }
        denoise(&mut picture, &built_in(), &pool(1)).expect("all layers are there");
        for pixel in &picture.color {
            prop_assert!(pixel[..3].iter().all(|x| x.is_finite() && *x >= 0.0), "{pixel:?}");
        }
    }
}

#[test]
fn light_of_surfaces_stays_out_of_pixels_without_any() {
    // A dark wall of much noise beside nothing.
    let is_empty = |x: u32| x < SIZE / 2;
    let [_, mut noisy] = pictures(0.9, |x, _| Pixel {
        light: if is_empty(x) { 0.0 } else { 0.2 },
        albedo: if is_empty(x) { [0.0; 3] } else { [0.5; 3] },
        normal: if is_empty(x) { [0.0; 3] } else { [0.0, 0.0, 1.0] },
    });
    // Light of a mist, of which nothing is known.
    for (i, pixel) in noisy.color.iter_mut().enumerate().filter(|(i, _)| is_empty(*i as u32 % SIZE)) {
        let mist = if i % 7 == 0 { 0.007 } else { 0.0 };
        *pixel = [mist, mist, mist, 1.0];
    }
    let [r, g, b] = [0, 1, 2].map(|_| {
        let of = |i: u32| if is_empty(i % SIZE) { 6e-6 } else { 0.0027 };
        (0..SIZE * SIZE).map(of).collect::<Vec<f32>>()
    });
    let variance = noisy.layers.iter_mut().find(|layer| layer.name == "variance").expect("there");
    *variance = Layer::floats("variance", [("R", r), ("G", g), ("B", b)]);
    let clean = clean(&noisy);
    let most = (0..SIZE * SIZE)
        .filter(|i| is_empty(i % SIZE))
        .map(|i| clean.color[i as usize][1])
        .fold(0.0, f32::max);
    assert!(most < 0.0071, "nothing shines as bright as {most}");
}

/// The edge of a shadow in direct light with little noise, below indirect light with much.
#[test]
fn edges_of_shadows_stay_below_noisy_indirect_light() {
    let mut random = Random::new(5);
    let is_lit = |p: u32| p % SIZE + p / SIZE / 3 < 30;
    let mut truth = Picture::new(SIZE, SIZE);
    let mut noisy = truth.clone();
    let [mut light, mut squares] = [Vec::new(), Vec::new()];
    for p in 0..SIZE * SIZE {
        let direct = if is_lit(p) { 0.3 } else { 0.0 };
        let wave = random.between(-1.0, 1.0);
        let found = direct * (1.0 + 0.05 * random.between(-1.0, 1.0));
        (truth.color[p as usize], noisy.color[p as usize]) =
            ([direct + 0.5, direct + 0.5, direct + 0.5, 1.0], [found + 0.5 * (1.0 + wave); 4]);
        light.push(found);
        squares.push((0.05_f32 * direct).powi(2) / 3.0);
    }
    let constant = |name: &str, channels: [&str; 3], value: [f32; 3]| {
        let planes = [0, 1, 2].map(|k| (channels[k], vec![value[k]; (SIZE * SIZE) as usize]));
        Layer::floats(name, planes)
    };
    let grey =
        |name: &str, plane: &Vec<f32>| Layer::floats(name, ["R", "G", "B"].map(|c| (c, plane.clone())));
    let rgb = ["R", "G", "B"];
    let of_indirect = 0.25 / 3.0;
    noisy.layers = vec![
        constant("albedo", rgb, [0.7; 3]),
        constant("N", ["X", "Y", "Z"], [0.0, 0.0, 1.0]),
        grey("variance", &squares.iter().map(|x| x + of_indirect).collect()),
    ];
    let together = error(&clean(&noisy), &truth);
    noisy.layers.extend([
        constant("seen_light", rgb, [0.0; 3]),
        constant("seen_split", rgb, [0.0; 3]),
        grey("seen_direct", &light),
        grey("seen_direct_variance", &squares),
        constant("seen_indirect_variance", rgb, [of_indirect; 3]),
    ]);
    let apart = error(&clean(&noisy), &truth);
    assert!(apart < 0.7 * together && together > 0.02, "{apart} apart, {together} together");
}
