// SPDX-License-Identifier: GPL-3.0-or-later
//! The graphics state, and the blocks that save it: `AttributeBegin` and its kin.
//! Source: the section Graphics State of the file-format page.

use std::sync::Arc;

use gnurt_scene::{Affine, MediumId};

use crate::color_space::ColorSpace;
use crate::lights::AreaLight;
use crate::location::Location;
use crate::parameter::Parameter;

/// Targets of the statement `Attribute`.
pub(crate) const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// Values for the statements that follow.
#[derive(Clone)]
pub(crate) struct State {
    /// From the current space to the file's world, when the shutter opens and when it closes.
    pub(crate) transforms: [Affine; 2],
    /// Which of them statements change.
    pub(crate) active: [bool; 2],
    pub(crate) reversed: bool,
    /// The number of the material.
    pub(crate) material: u32,
    pub(crate) area_light: Option<Arc<AreaLight>>,
    /// Media within the shapes that follow, and around them.
    pub(crate) media: [Option<MediumId>; 2],
    pub(crate) space: ColorSpace,
    /// Parameters by targets.
    pub(crate) attributes: [Arc<Vec<Parameter>>; 5],
}

impl State {
    pub(crate) fn new(material: u32) -> Self {
        Self {
            transforms: [Affine::IDENTITY; 2],
            active: [true; 2],
            reversed: false,
            material,
            area_light: None,
            media: [None; 2],
            space: ColorSpace::default(),
            attributes: Default::default(),
        }
    }

    /// Multiplies the active transforms.
    pub(crate) fn concatenate(&mut self, by: &Affine) {
        self.each(|transform| *transform = *transform * *by);
    }

    /// Changes the active transforms.
    pub(crate) fn each(&mut self, with: impl Fn(&mut Affine)) {
        let active = self.active;
        self.transforms.iter_mut().zip(active).filter(|(_, active)| *active).for_each(|(t, _)| with(t));
    }
}

/// Kinds of blocks, by the statements that begin them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Block {
    Attribute,
    Transform,
    Object,
    Import,
}

impl Block {
    /// The statements that begin and end it.
    pub(crate) fn names(self) -> [&'static str; 2] {
        match self {
            Self::Attribute => ["AttributeBegin", "AttributeEnd"],
            Self::Transform => ["TransformBegin", "TransformEnd"],
            Self::Object => ["ObjectBegin", "ObjectEnd"],
            Self::Import => ["Import", "the end of its file"],
        }
    }
}

/// A state that comes back.
pub(crate) struct Saved {
    pub(crate) block: Block,
    pub(crate) location: Location,
    pub(crate) state: State,
}
