// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt info PICTURE`: size, range of values, layers and metadata of a picture, as a table or as JSON.
//! Tests: `tests/program/info.rs::pictures_are_listed`.

use std::fmt::Write;
use std::path::Path;

use gnurt::image::{ChannelData, Picture};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::messages::print;
use crate::workers::read_picture;

/// Prints the contents of a picture file.
pub(super) fn run(path: &Path, json: bool) -> Outcome {
    let picture = read_picture(path).map_err(Failure::data)?;
    let [least, most] = range(&picture);
    let odd = picture.color.iter().filter(|pixel| pixel.iter().any(|x| !x.is_finite())).count();
    let open = picture.color.iter().filter(|pixel| pixel[3] < 1.0).count();
    if json {
        let layers: Vec<_> = picture
            .layers
            .iter()
            .map(|layer| {
                let channels: Vec<_> = layer.channels.iter().map(|channel| &channel.name[..]).collect();
                json!({ "name": layer.name, "channels": channels })
            })
            .collect();
        let metadata: serde_json::Map<_, _> =
            picture.metadata.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
        return print(json!({
            "picture": path.display().to_string(),
            "width": picture.width,
            "height": picture.height,
            "least": least,
            "greatest": most,
            "pixels_not_finite": odd,
            "pixels_transparent": open,
            "layers": layers,
            "metadata": metadata,
        }));
    }
    let mut text = String::new();
    // Writing to a string does not fail.
    let mut row = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<12}{value}");
    };
    row("picture", path.display().to_string());
    row("size", format!("{} x {}", picture.width, picture.height));
    row("values", format!("{} to {}, linear", list(least), list(most)));
    row("pixels", format!("{open} partly or wholly transparent, {odd} with values that are not finite"));
    row("layers", picture.layers.len().to_string());
    for layer in &picture.layers {
        let channels = layer.channels.iter().map(|channel| match (&channel.data, channel.half) {
            (ChannelData::U32(_), _) => format!("{} (whole)", channel.name),
            (ChannelData::F32(_), true) => format!("{} (half)", channel.name),
            (ChannelData::F32(_), false) => channel.name.clone(),
        });
        row("", format!("'{}': {}", layer.name, channels.collect::<Vec<_>>().join(", ")));
    }
    row("metadata", picture.metadata.len().to_string());
    for (name, value) in &picture.metadata {
        // One line for each, whatever it holds.
        let value: String = value.chars().take(200).map(|c| if c.is_control() { ' ' } else { c }).collect();
        row("", format!("{name}: {value}"));
    }
    print(text.trim_end())
}

/// The least and the greatest finite value of red, green and blue.
fn range(picture: &Picture) -> [[f32; 3]; 2] {
    let of = |k: usize, start: f32, pick: fn(f32, f32) -> f32| {
        let finite = picture.color.iter().map(|pixel| pixel[k]).filter(|x| x.is_finite());
        let found = finite.fold(start, pick);
        if found.is_finite() { found } else { 0.0 }
    };
    [[0, 1, 2].map(|k| of(k, f32::INFINITY, f32::min)), [0, 1, 2].map(|k| of(k, f32::NEG_INFINITY, f32::max))]
}

fn list(values: [f32; 3]) -> String {
    format!("({})", values.map(|x| x.to_string()).join(", "))
}
