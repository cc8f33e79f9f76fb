// SPDX-License-Identifier: GPL-3.0-or-later
//! The accounts of a batch of paths: the states of each path, and the light of each layer.
//! A surface scatters by diffuse and by glossy lobes at once. Then a path is in several states, each with its
//! share of the light by colour; shares of one path make 1, but those whose light no layer counts.
//! Invariant: whatever is added to a lane's radiance is added here with the same number, so that layers whose
//! expressions divide all paths between them make the picture. Nothing here draws random numbers or changes paths.
//! Tests: crates/render/tests/light_layers.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt_shading::Vec3s;

use super::automaton::DEAD;
use super::events::{End, Scatter};
use super::light_paths::LightPaths;

/// A part of a path's light, by colour, and the events so far.
#[derive(Clone, Copy, Debug)]
struct Share {
    state: u16,
    part: Vec3,
}

/// Shares of many paths, one after the other.
#[derive(Default)]
struct Shares {
    /// Where those of each path end.
    ends: Vec<u32>,
    all: Vec<Share>,
}

impl Shares {
    fn clear(&mut self) {
        self.ends.clear();
        self.all.clear();
    }

    fn of(&self, i: usize) -> &[Share] {
        let begin = if i == 0 { 0 } else { self.ends[i - 1] as usize };
        &self.all[begin..self.ends[i] as usize]
    }

    /// Ends the shares of a path.
    fn close(&mut self) {
        self.ends.push(self.all.len() as u32);
    }
}

/// The accounts.
pub(crate) struct Ledger {
    pub(crate) paths: Arc<LightPaths>,
    /// The light of each layer, by lane.
    pub(crate) layers: Vec<Vec3s>,
    shares: Shares,
    next: Shares,
    /// Of light that may be occluded, and its lights.
    unshadowed: Shares,
    lights: Vec<End>,
}

impl Ledger {
    pub(crate) fn new(paths: Arc<LightPaths>) -> Self {
        let layers = (0..paths.automaton.layers).map(|_| Vec3s::default()).collect();
        let (shares, next, unshadowed) = Default::default();
        Self { paths, layers, shares, next, unshadowed, lights: Vec::new() }
    }

    /// Begins with one path for each of `count` lanes.
    pub(crate) fn start(&mut self, count: usize) {
        self.layers.iter_mut().for_each(|layer| layer.reset(count, Vec3::ZERO));
        self.shares.clear();
        let state = self.paths.automaton.start;
        self.shares.all.resize(count, Share { state, part: Vec3::ONE });
        self.shares.ends.extend(1..=count as u32);
        self.begin_step();
    }

    /// Drops what was noted of the next paths.
    pub(crate) fn begin_step(&mut self) {
        self.next.clear();
        self.unshadowed.clear();
        self.lights.clear();
    }

    /// Goes on to the next paths.
    pub(crate) fn end_step(&mut self) {
        std::mem::swap(&mut self.shares, &mut self.next);
    }

    /// The next path is path `number`, straight on.
    pub(crate) fn pass(&mut self, number: usize) {
        self.next.all.extend_from_slice(self.shares.of(number));
        self.next.close();
    }

    /// The next path is path `number`, scattered.
    pub(crate) fn scatter(&mut self, number: usize, events: &[(Scatter, Vec3)]) {
        advance(&self.paths, self.shares.of(number), events, &mut self.next);
    }

    /// The next light that may be occluded comes to path `number`, and is scattered there; without events it is not.
    pub(crate) fn light(&mut self, number: usize, events: &[(Scatter, Vec3)], light: End) {
        if events.is_empty() {
            self.unshadowed.all.extend_from_slice(self.shares.of(number));
            self.unshadowed.close();
        } else {
            advance(&self.paths, self.shares.of(number), events, &mut self.unshadowed);
        }
        self.lights.push(light);
    }

    /// Path `number` found light.
    pub(crate) fn found(&mut self, number: usize, (lane, light): (u32, Vec3), end: End) {
        deposit(&self.paths, self.shares.of(number), (lane, light), end, &mut self.layers);
    }

    /// Path `number` found light over further events, one after the other.
    pub(crate) fn found_beyond(
        &mut self,
        number: usize,
        events: &[&[(Scatter, Vec3)]],
        (lane, light): (u32, Vec3),
        end: End,
    ) {
        let mut shares = Shares::default();
        shares.all.extend_from_slice(self.shares.of(number));
        shares.close();
        for events in events {
            let mut next = Shares::default();
            advance(&self.paths, shares.of(0), events, &mut next);
            shares = next;
        }
        deposit(&self.paths, shares.of(0), (lane, light), end, &mut self.layers);
    }

    /// Light `k` that might have been occluded arrived.
    pub(crate) fn arrived(&mut self, k: usize, (lane, light): (u32, Vec3)) {
        let end = self.lights[k];
        deposit(&self.paths, self.unshadowed.of(k), (lane, light), end, &mut self.layers);
    }
}

fn advance(paths: &LightPaths, from: &[Share], events: &[(Scatter, Vec3)], to: &mut Shares) {
    let first = to.all.len();
    for share in from {
        for &(event, part) in events {
            let state = paths.automaton.after(share.state, event);
            let part = share.part * part;
            if state == DEAD || part == Vec3::ZERO {
                continue;
            }
            match to.all[first..].iter_mut().find(|known| known.state == state) {
                Some(known) => known.part += part,
                None => to.all.push(Share { state, part }),
            }
        }
    }
    to.close();
}

fn deposit(paths: &LightPaths, shares: &[Share], (lane, light): (u32, Vec3), end: End, layers: &mut [Vec3s]) {
    for share in shares {
        for &layer in paths.automaton.layers_of(share.state, end) {
            layers[layer as usize].add(lane as usize, light * share.part);
        }
    }
}
