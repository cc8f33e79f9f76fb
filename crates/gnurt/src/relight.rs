// SPDX-License-Identifier: GPL-3.0-or-later
//! Light groups of a finished picture, mixed with other strengths and colours: light adds up, so each group's layer is
//! multiplied by its gain.
//! The light that is in no group's layer is the rest, and has a gain of its own. Layers of Cycles (`Combined_NAME`)
//! are groups, too. Invariant: gains of 1 leave the picture as it is, up to rounding.
//! Tests: `tests`, crates/cli/tests/program/relight.rs.

use gnurt_image::{BACKGROUND, ChannelData, Layer, Picture};
use gnurt_render::{GROUP_PREFIX, UNGROUPED};

use crate::mattes::is_matte;

/// The name of the light in no group.
pub const REST: &str = "rest";
/// What Cycles puts before the name of a group.
const OF_CYCLES: &str = "Combined_";
/// Layers that describe surfaces stay; those of light do not fit the new light.
const KEPT: [&str; 8] = ["albedo", "N", "P", "depth", "", "id", "motion", BACKGROUND];

/// A gain of a light group.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    /// The group, or [`REST`].
    pub group: String,
    /// Factors of red, green and blue, at least 0.
    pub color: [f32; 3],
}

/// The group that a layer holds the light of.
fn group_of(layer: &str) -> Option<&str> {
    if layer == UNGROUPED {
        return Some(REST);
    }
    let of_cycles = || layer.rsplit('.').next().and_then(|last| last.strip_prefix(OF_CYCLES));
    layer.strip_prefix(GROUP_PREFIX).or_else(of_cycles)
}

/// The light groups of a picture, in the order of its layers; the rest is last, if it is a layer.
#[must_use]
pub fn light_groups(picture: &Picture) -> Vec<String> {
    let mut groups: Vec<&str> = picture.layers.iter().filter_map(|layer| group_of(&layer.name)).collect();
    groups.sort_by_key(|&group| group == REST);
    groups.into_iter().map(str::to_owned).collect()
}

/// Gives the light of each group its gain, 1 if there is none. Layers of groups are multiplied, so that they make the
/// new picture; other layers of light are dropped.
///
/// # Errors
/// The picture has no light group, or none of a name; its layers do not have its size.
pub fn relight(picture: &mut Picture, gains: &[Gain]) -> Result<(), String> {
    picture.check().map_err(|error| error.to_string())?;
    let groups = light_groups(picture);
    if groups.iter().all(|group| group == REST) {
        return Err("it has no light groups; `gnurt render --light-groups` writes them".into());
    }
    for Gain { group, color } in gains {
        if group != REST && !groups.contains(group) {
            return Err(format!("unknown light group '{group}'; valid are: {}, {REST}", listed(&groups)));
        }
        if !color.iter().all(|gain| gain.is_finite() && *gain >= 0.0) {
            return Err(format!("{group}: gains are numbers of at least 0"));
        }
    }
    let gain = |group: &str| {
        let found = gains.iter().rev().find(|gain| gain.group == group);
        found.map_or([1.0; 3], |gain| gain.color)
    };
    let behind = group_behind(picture).map(|group| gain(&group));
    let rest = gain(REST);
    let mut change = vec![[0.0_f64; 3]; picture.color.len()];
    let mut grouped = vec![[0.0_f64; 3]; picture.color.len()];
    for layer in &mut picture.layers {
        let Some(gain) = group_of(&layer.name).map(gain) else { continue };
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            let Some(values) = floats_mut(layer, name) else { continue };
            for (i, value) in values.iter_mut().enumerate() {
                let before = f64::from(*value);
                *value = (before * f64::from(gain[k])) as f32;
                grouped[i][k] += before;
                change[i][k] += before * f64::from(gain[k]) - before;
            }
        }
    }
    for ((pixel, change), grouped) in picture.color.iter_mut().zip(&change).zip(&grouped) {
        for k in 0..3 {
            let before = f64::from(pixel[k]);
            // Rounding is no light.
            let left = before - grouped[k];
            let left = if left.abs() > 1e-5 * before.abs().max(1.0) { left } else { 0.0 };
            pixel[k] = (before + change[k] + left * (f64::from(rest[k]) - 1.0)) as f32;
        }
    }
    for layer in picture.layers.iter_mut().filter(|layer| layer.name == BACKGROUND) {
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            let gain = behind.unwrap_or(rest)[k];
            floats_mut(layer, name).into_iter().flatten().for_each(|value| *value *= gain);
        }
    }
    picture.layers.retain(|layer| {
        KEPT.contains(&&layer.name[..]) || group_of(&layer.name).is_some() || is_matte(&layer.name)
    });
    Ok(())
}

fn listed(groups: &[String]) -> String {
    let names: Vec<&str> = groups.iter().map(String::as_str).filter(|&group| group != REST).collect();
    names.join(", ")
}

/// The group whose light the background is: the one that is most like it where nothing else is seen.
fn group_behind(picture: &Picture) -> Option<String> {
    let background = picture.layer(BACKGROUND)?;
    let [r, g, b, a] = ["R", "G", "B", "A"].map(|name| floats(background, name));
    let (behind, share) = ([r?, g?, b?], a?);
    let off = |layer: &Layer| {
        let channels = ["R", "G", "B"].map(|name| floats(layer, name));
        let mut sum = 0.0_f64;
        for (channel, behind) in channels.into_iter().zip(behind) {
            for ((value, behind), share) in channel?.iter().zip(behind).zip(share) {
                // Where something is in front, a group has at least the light behind it.
                let difference = f64::from(value - behind);
                sum += if *share >= 1.0 { difference.abs() } else { (-difference).max(0.0) };
            }
        }
        Some(sum)
    };
    let found = picture.layers.iter().filter_map(|layer| Some((group_of(&layer.name)?, off(layer)?)));
    found.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(group, _)| group.to_owned())
}

fn floats<'a>(layer: &'a Layer, name: &str) -> Option<&'a [f32]> {
    match &layer.channel(name)?.data {
        ChannelData::F32(values) => Some(values),
        ChannelData::U32(_) => None,
    }
}

fn floats_mut<'a>(layer: &'a mut Layer, name: &str) -> Option<&'a mut Vec<f32>> {
    let channel = layer.channels.iter_mut().find(|channel| channel.name == name)?;
    match &mut channel.data {
        ChannelData::F32(values) => Some(values),
        ChannelData::U32(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(name: &str, value: [f32; 3]) -> Layer {
        Layer::floats(name, ["R", "G", "B"].into_iter().zip(value.map(|x| vec![x, 2.0 * x])))
    }

    /// Key, sky and 0.25 of light without a group.
    fn picture() -> Picture {
        let mut picture = Picture::new(2, 1);
        picture.color = vec![[1.0, 1.5, 2.0, 1.0], [1.75, 2.75, 3.75, 1.0]];
        picture.layers.extend([
            layer("light.key", [0.5, 0.75, 1.0]),
            layer("light.sky", [0.25, 0.5, 0.75]),
            layer("direct", [1.0; 3]),
            layer("albedo", [0.5; 3]),
        ]);
        picture
    }

    fn gain(group: &str, color: [f32; 3]) -> Gain {
        Gain { group: group.into(), color }
    }

    #[test]
    fn groups_are_multiplied_and_added() {
        let mut same = picture();
        relight(&mut same, &[]).expect("groups");
        assert_eq!(same.color, picture().color, "nothing changes");
        let mut mixed = picture();
        relight(&mut mixed, &[gain("key", [2.0, 0.0, 1.0]), gain("rest", [4.0; 3])]).expect("groups");
        assert_eq!(mixed.color[0], [2.25, 1.5, 2.75, 1.0], "1 + 0.25 + 1, and so on");
        let names: Vec<&str> = mixed.layers.iter().map(|layer| &layer.name[..]).collect();
        assert_eq!(names, ["light.key", "light.sky", "albedo"], "others do not fit the new light");
        assert_eq!(floats(&mixed.layers[0], "R").expect("floats"), [1.0, 2.0], "it can be mixed again");
        let mut cycles = picture();
        cycles.layers[0].name = "ViewLayer.Combined_key".into();
        assert_eq!(light_groups(&cycles), ["key", "sky"], "of Cycles");
    }

    #[test]
    fn the_background_follows_its_group() {
        let mut lit = picture();
        let mut background = layer(BACKGROUND, [0.25, 0.5, 0.75]);
        background.channels.extend(Layer::floats("", [("A", vec![1.0, 1.0])]).channels);
        lit.layers.push(background);
        relight(&mut lit, &[gain("sky", [0.0; 3])]).expect("groups");
        assert_eq!(floats(lit.layer(BACKGROUND).expect("kept"), "G").expect("floats"), [0.0; 2], "dark");
    }

    #[test]
    fn mistakes_are_told() {
        let error = |gains: &[Gain]| relight(&mut picture(), gains).expect_err("a mistake");
        assert_eq!(error(&[gain("kye", [1.0; 3])]), "unknown light group 'kye'; valid are: key, sky, rest");
        assert!(error(&[gain("key", [-1.0; 3])]).contains("at least 0"), "negative light");
        let mut plain = Picture::new(1, 1);
        assert!(relight(&mut plain, &[]).expect_err("none").contains("no light groups"), "none");
    }
}
