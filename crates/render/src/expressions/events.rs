// SPDX-License-Identifier: GPL-3.0-or-later
//! Events of paths as small numbers: scattering at surfaces and in media, and the lights at their ends.
//! Surfaces and lights with the same labels of the expressions are one class: an event is a kind and a class.
//! Tests: `automaton::tests`.

use super::syntax::{
    BACKGROUND, DIFFUSE, EMISSION, GLOSSY, LIGHT, NONE, REFLECTION, SINGULAR, TRANSMISSION, VOLUME,
};

/// Most labels in all expressions of a picture: a bit each.
pub(crate) const MOST_LABELS: usize = 63;

/// Types and scattering of events between camera and light.
const SCATTERS: [[u8; 2]; 7] = [
    [REFLECTION, DIFFUSE],
    [REFLECTION, GLOSSY],
    [REFLECTION, SINGULAR],
    [TRANSMISSION, DIFFUSE],
    [TRANSMISSION, GLOSSY],
    [TRANSMISSION, SINGULAR],
    [VOLUME, NONE],
];
/// Types of lights.
pub(super) const ENDS: [u8; 3] = [LIGHT, EMISSION, BACKGROUND];

/// How a surface scattered light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobe {
    Diffuse,
    Glossy,
    Singular,
}

/// A scattering event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Scatter(u16);

impl Scatter {
    /// Of a surface of a class.
    pub(crate) fn surface(class: u16, is_transmitted: bool, lobe: Lobe) -> Self {
        Self(class * SCATTERS.len() as u16 + 3 * u16::from(is_transmitted) + lobe as u16)
    }

    /// Of a medium.
    pub(crate) const VOLUME: Self = Self(6);

    #[cfg(test)]
    pub(super) fn of_index(index: usize) -> Self {
        Self(index as u16)
    }

    pub(super) fn index(self) -> usize {
        self.0.into()
    }
}

/// A light at the end of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct End(u16);

impl End {
    /// A light that light samples know.
    pub(crate) fn light(class: u16) -> Self {
        Self(class * ENDS.len() as u16)
    }

    /// Other emission.
    pub(crate) fn emission(class: u16) -> Self {
        Self(class * ENDS.len() as u16 + 1)
    }

    /// The environment.
    pub(crate) fn background(class: u16) -> Self {
        Self(class * ENDS.len() as u16 + 2)
    }

    #[cfg(test)]
    pub(super) fn of_index(index: usize) -> Self {
        Self(index as u16)
    }

    pub(super) fn index(self) -> usize {
        self.0.into()
    }
}

/// An event as patterns see it: bits of its type, its scattering and its labels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub(super) kind: u8,
    pub(super) scattering: u8,
    pub(super) labels: u64,
}

/// All events: the labels that expressions name, and the classes of surfaces and lights as bits of them.
#[derive(Clone, Debug)]
pub(crate) struct Alphabet {
    labels: Vec<String>,
    surfaces: Vec<u64>,
    lights: Vec<u64>,
}

impl Alphabet {
    pub(crate) fn new(labels: Vec<String>, surfaces: Vec<u64>, lights: Vec<u64>) -> Self {
        Self { labels, surfaces, lights }
    }

    pub(super) fn labels(&self) -> &[String] {
        &self.labels
    }

    /// In the order of [`Scatter`].
    pub(super) fn scatters(&self) -> impl Iterator<Item = Event> + '_ {
        let of_class = |&labels: &u64| SCATTERS.map(|[kind, scattering]| Event { kind, scattering, labels });
        self.surfaces.iter().flat_map(of_class)
    }

    /// In the order of [`End`].
    pub(super) fn ends(&self) -> impl Iterator<Item = Event> + '_ {
        let of_class = |&labels: &u64| ENDS.map(|kind| Event { kind, scattering: NONE, labels });
        self.lights.iter().flat_map(of_class)
    }
}
