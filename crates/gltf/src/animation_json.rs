// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's JSON of animations: only the properties that are read.
//! Source: glTF 2.0 section 5 and KHR_animation_pointer. Tests: `tests/animation.rs`.

use serde::Deserialize;

use super::json::{Index, Pieces, Text};

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Animation<'a> {
    pub(super) name: Option<String>,
    #[serde(borrow)]
    pub(super) channels: Pieces<'a>,
    #[serde(borrow)]
    pub(super) samplers: Pieces<'a>,
}

#[derive(Deserialize)]
pub(super) struct Channel<'a> {
    pub(super) sampler: Index,
    #[serde(borrow)]
    pub(super) target: ChannelTarget<'a>,
}

/// The target of a channel: a path of a node, or a pointer.
#[derive(Deserialize)]
pub(super) struct ChannelTarget<'a> {
    #[serde(default)]
    pub(super) node: Option<Index>,
    #[serde(borrow)]
    pub(super) path: Text<'a>,
    #[serde(default, borrow)]
    pub(super) extensions: TargetExtensions<'a>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct TargetExtensions<'a> {
    #[serde(rename = "KHR_animation_pointer", borrow)]
    pub(super) pointer: Option<Pointer<'a>>,
}

#[derive(Deserialize)]
pub(super) struct Pointer<'a> {
    #[serde(borrow)]
    pub(super) pointer: Text<'a>,
}

/// Keys of an animation.
#[derive(Deserialize)]
pub(super) struct Curve<'a> {
    pub(super) input: Index,
    pub(super) output: Index,
    #[serde(default, borrow)]
    pub(super) interpolation: Option<Text<'a>>,
}
