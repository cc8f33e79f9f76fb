// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of other renderers' files, brought to the names and units that the filter reads.
//! Names as Blender (Cycles), Arnold, Mitsuba and pbrt write them, without the name of the view layer, in any case.
//! Missing variance is estimated from pixels beside it, after \[Imm96\]: the mask cancels planes, noise stays.
//! Left out: motion but Cycles' `Vector`, for its direction differs between renderers.
//! Tests: crates/denoise/tests/other_renderers.rs, crates/cli/tests/program/denoise.rs.

use gnurt_image::{Channel, ChannelData, Layer, Picture};

use crate::film::MOTION;
use crate::light::Light;
use crate::noisy::{Noisy, Triple};

/// The last parts of layers' names, the best first, and the name here.
const KNOWN: [(&str, [&str; 3], &[&str]); 3] = [
    (
        "albedo",
        ["R", "G", "B"],
        &["albedo", "denoising albedo", "denoise_albedo", "denoise_albedo_noice", "alb", "aa"],
    ),
    (
        "N",
        ["X", "Y", "Z"],
        &["n", "denoising normal", "n_noice", "normal", "normals", "ns", "nn", "sh_normal", "geo_normal"],
    ),
    ("emission", ["R", "G", "B"], &["emission", "emit"]),
];
/// Distances, by the last part of the name.
const DEPTHS: [&str; 7] = ["depth", "denoising depth", "dd", "z", "z_noice", "dd.y", "distance"];
/// Colours before a renderer's own filter.
const UNFILTERED: &str = "noisy image";
/// Where Blender has nothing: 1e10; other renderers write infinity or 0.
const NOWHERE: f32 = 1e9;

/// Gives the picture's layers the names that the filter reads, and adds those that it can work out. Layers that are
/// there stay. Returns a line for each one that it took from another name or worked out.
pub fn adopt(picture: &mut Picture) -> Vec<String> {
    if picture.check().is_err() {
        return Vec::new();
    }
    let mut told = Vec::new();
    if let Some((name, color)) = triple(picture, &[UNFILTERED], ["R", "G", "B"]) {
        for (i, pixel) in picture.color.iter_mut().enumerate() {
            (pixel[0], pixel[1], pixel[2]) = (color[0][i], color[1][i], color[2][i]);
        }
        told.push(format!("colours from '{name}'"));
    }
    for (own, channels, names) in KNOWN {
        if picture.layer(own).is_some_and(|layer| channels.iter().all(|c| layer.channel(c).is_some())) {
            continue;
        }
        if let Some((name, values)) = triple(picture, names, channels) {
            picture.layers.retain(|layer| layer.name != own);
            picture.layers.push(Layer::floats(own, channels.into_iter().zip(values)));
            told.push(format!("{own} from '{name}'"));
        }
    }
    add_depth(picture, &mut told);
    add_ids(picture, &mut told);
    add_motion(picture, &mut told);
    add_variance(picture, &mut told);
    told
}

/// Whether frames of this kind can lend each other light.
#[must_use]
pub fn has_motion(picture: &Picture) -> bool {
    picture.layer(MOTION).is_some_and(|layer| layer.channel("before").is_some())
}

/// The layer whose name ends so, the best first.
fn find<'a>(picture: &'a Picture, names: &[&str]) -> Option<&'a Layer> {
    names.iter().find_map(|name| {
        picture.layers.iter().find(|layer| {
            let full = layer.name.to_lowercase();
            full == *name || full.ends_with(&format!(".{name}"))
        })
    })
}

fn floats(channel: &Channel) -> Vec<f32> {
    match &channel.data {
        ChannelData::F32(values) => values.clone(),
        ChannelData::U32(values) => values.iter().map(|&value| value as f32).collect(),
    }
}

/// The three values of a layer, as R, G, B or X, Y, Z in any case.
fn triple(picture: &Picture, names: &[&str], channels: [&str; 3]) -> Option<(String, [Vec<f32>; 3])> {
    names.iter().find_map(|name| {
        let layer = find(picture, &[name])?;
        [channels, ["R", "G", "B"], ["X", "Y", "Z"]].into_iter().find_map(|set| {
            let [a, b, c] =
                set.map(|want| layer.channels.iter().find(|channel| channel.name.eq_ignore_ascii_case(want)));
            Some((layer.name.clone(), [floats(a?), floats(b?), floats(c?)]))
        })
    })
}

/// Distances: a layer of one channel, or the channel `Z` of no layer.
fn add_depth(picture: &mut Picture, told: &mut Vec<String>) {
    if picture.layer("depth").is_some_and(|layer| layer.channel("Z").is_some()) {
        return;
    }
    let single = |layer: &Layer| layer.channels.first().filter(|_| layer.channels.len() == 1).map(floats);
    let of_layer = find(picture, &DEPTHS).and_then(|layer| Some((layer.name.clone(), single(layer)?)));
    let unnamed = || {
        let layer = picture.layer("")?;
        let channel = layer.channels.iter().find(|c| DEPTHS.contains(&&*c.name.to_lowercase()))?;
        Some((channel.name.clone(), floats(channel)))
    };
    let Some((name, mut values)) = of_layer.or_else(unnamed) else { return };
    for value in values.iter_mut().filter(|value| !(**value > 0.0 && **value < NOWHERE)) {
        *value = f32::INFINITY;
    }
    picture.layers.retain(|layer| layer.name != "depth");
    picture.layers.push(Layer::floats("depth", [("Z", values)]));
    told.push(format!("depth from '{name}'"));
}

/// Numbers of objects and materials; without them all that was met is one object.
fn add_ids(picture: &mut Picture, told: &mut Vec<String>) {
    if picture.layer("id").is_some() {
        return;
    }
    let Some(ChannelData::F32(depth)) =
        picture.layer("depth").and_then(|layer| layer.channel("Z")).map(|channel| &channel.data)
    else {
        return;
    };
    let is_met: Vec<bool> = depth.iter().map(|depth| depth.is_finite()).collect();
    let numbers = |names: &[&str]| {
        let layer = find(picture, names)?;
        Some((layer.name.clone(), floats(layer.channels.first().filter(|_| layer.channels.len() == 1)?)))
    };
    let (object, material) =
        (numbers(&["indexob", "shape_index", "id", "object"]), numbers(&["indexma", "material"]));
    let plane = |of: &Option<(String, Vec<f32>)>| -> Vec<u32> {
        let number = |p: usize| of.as_ref().map_or(0, |(_, values)| values[p] as u32);
        is_met.iter().enumerate().map(|(p, met)| if *met { number(p) } else { u32::MAX }).collect()
    };
    let planes = [("instance", plane(&None)), ("object", plane(&object)), ("material", plane(&material))];
    told.extend([object, material].into_iter().flatten().map(|(name, _)| format!("ids from '{name}'")));
    picture.layers.push(Layer::ids("id", planes));
}

/// Cycles' `Vector`: `X`, `Y` to the frame before; `Z`, `W` from the next one; upwards.
fn add_motion(picture: &mut Picture, told: &mut Vec<String>) {
    if picture.layer(MOTION).is_some() {
        return;
    }
    let Some(layer) = find(picture, &["vector"]) else { return };
    let signed = |name: &str, sign: f32| -> Option<Vec<f32>> {
        Some(floats(layer.channel(name)?).into_iter().map(|value| sign * value).collect())
    };
    let planes = [signed("X", 1.0), signed("Y", -1.0), signed("Z", -1.0), signed("W", 1.0)];
    let [Some(x), Some(y), Some(z), Some(w)] = planes else { return };
    let (name, unknown) = (layer.name.clone(), vec![0.0; x.len()]);
    let channels = [("X", x), ("Y", y), ("Z", z), ("W", w), ("before", unknown.clone()), ("after", unknown)];
    picture.layers.push(Layer::floats(MOTION, channels));
    told.push(format!("{MOTION} from '{name}'"));
}

/// Pixels to each side over which estimates are averaged.
const AROUND: usize = 3;

/// Estimates the variance of each pixel from those beside it.
fn add_variance(picture: &mut Picture, told: &mut Vec<String>) {
    if picture.layer("variance").is_some() {
        return;
    }
    let (width, height) = (picture.width as usize, picture.height as usize);
    let zeros = || vec![0.0; width * height];
    picture.layers.push(Layer::floats("variance", [("R", zeros()), ("G", zeros()), ("B", zeros())]));
    let noisy = Noisy::of(picture, [0, 0, picture.width, picture.height]);
    picture.layers.pop();
    // What is missing is reported by the filter.
    let Ok(noisy) = noisy else { return };
    let light = Light::of(&noisy);
    let estimate = estimated(&light.parts[1].color, width, height);
    let plane = |k: usize| estimate.iter().zip(&light.divisor).map(|(v, by)| v[k] * by[k] * by[k]).collect();
    picture.layers.push(Layer::floats("variance", [("R", plane(0)), ("G", plane(1)), ("B", plane(2))]));
    told.push("variance estimated from pixels beside each other".into());
}

/// The square of the mask's answer, divided by the sum of its squares, averaged.
fn estimated(light: &[Triple], width: usize, height: usize) -> Vec<Triple> {
    const MASK: [f32; 3] = [1.0, -2.0, 1.0];
    let at = |x: usize, d: usize, length: usize| (x + d).saturating_sub(1).min(length - 1);
    let answer = |p: usize| {
        let (x, y) = (p % width, p / width);
        let mut sum = [0.0_f32; 3];
        for (dy, row) in MASK.into_iter().enumerate() {
            for (dx, column) in MASK.into_iter().enumerate() {
                let q = at(y, dy, height) * width + at(x, dx, width);
                (0..3).for_each(|k| sum[k] += row * column * light[q][k]);
            }
        }
        sum.map(|value| value * value / 36.0)
    };
    let squares: Vec<Triple> = (0..light.len()).map(answer).collect();
    let across = |x: usize, length: usize| x.saturating_sub(AROUND)..(x + AROUND + 1).min(length);
    let mean = |planes: &[Triple], of: &mut dyn Iterator<Item = usize>| {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for q in of {
            (0..3).for_each(|k| sum[k] += planes[q][k]);
            count += 1.0;
        }
        sum.map(|value| value / count)
    };
    let rows: Vec<Triple> = (0..light.len())
        .map(|p| mean(&squares, &mut across(p % width, width).map(|x| p / width * width + x)))
        .collect();
    (0..light.len())
        .map(|p| mean(&rows, &mut across(p / width, height).map(|y| y * width + p % width)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn variance_is_that_of_the_noise_and_none_of_a_slope() {
        let (width, height) = (64, 64);
        let mut random = Random::new(7);
        let slope = |p: usize| 1.0 + 0.02 * (p % width) as f32 + 0.03 * (p / width) as f32;
        let clean: Vec<Triple> = (0..width * height).map(|p| [slope(p); 3]).collect();
        let noisy: Vec<Triple> = clean.iter().map(|x| x.map(|x| x + random.between(-0.5, 0.5))).collect();
        let inner = |p: &usize| (8..56).contains(&(p % width)) && (8..56).contains(&(p / width));
        let mean = |light: &[Triple]| {
            let all = estimated(light, width, height);
            let of: Vec<f32> = (0..all.len()).filter(inner).map(|p| all[p][1]).collect();
            of.iter().sum::<f32>() / of.len() as f32
        };
        assert!(mean(&clean) < 1e-6, "none: {}", mean(&clean));
        let share = mean(&noisy) * 12.0;
        assert!((share - 1.0).abs() < 0.1, "a uniform number has the variance 1/12: {share} of it");
    }
}
