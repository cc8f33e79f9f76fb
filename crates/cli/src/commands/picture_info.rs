// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt info PICTURE`: size, range of values, layers and metadata of a picture, as a table or as JSON.
//! Tests: `tests/program/info.rs::pictures_are_listed`.

use std::fmt::Write;
use std::path::Path;

use gnurt::image::{ChannelData, Survey};
use serde_json::json;

use crate::failure::{Failure, Outcome};
use crate::messages::print;
use crate::workers::read_picture;

/// Prints the contents of a picture file.
pub(super) fn run(path: &Path, json: bool) -> Outcome {
    let picture = read_picture(path).map_err(Failure::data)?;
    let Survey { least, greatest, odd, open } = Survey::of(&picture);
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
            "greatest": greatest,
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
    row("values", format!("{} to {}, linear", list(least), list(greatest)));
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

fn list(values: [f32; 3]) -> String {
    format!("({})", values.map(|x| x.to_string()).join(", "))
}
