// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches of paths at all points of one shader.
//! Some are made by chance, and count more (`Chain::chance`).
//! Space: world. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;

use super::known::Caustics;
use super::rounds::{chance_of, search};
use super::search::{Found, Rough};
use crate::expressions::{Lobe, Scatter};
use crate::tracer::BatchTracer;
use crate::transport::add;
use crate::transport::step::{Met, Onward};

/// Adds the light of lamps behind smooth surfaces to points that paths met.
pub(crate) fn connect(tracer: &mut BatchTracer, met: &Met, onward: &mut Onward) {
    let Some(caustics) = met.caustics.filter(|_| !met.is_final) else { return };
    let points = (0..met.numbers.len()).filter_map(|k| rough(met, caustics, k));
    search(tracer, caustics, points, |rough, found, light| deposit(met, rough, (found, light), onward));
}

/// Point `k`, if it makes a search.
fn rough(met: &Met, caustics: &Caustics, k: usize) -> Option<Rough> {
    let path = met.path(k);
    if !met.is_there(k, &path) || met.is_hidden(k, &path) {
        return None;
    }
    let (key, edges, throughput) = (path.key, path.edges, path.throughput);
    let point = met.points.point(k);
    let of_path = (&path.chain, key, edges, throughput);
    let chance = chance_of((met.options, caustics), of_path, &point)?;
    let bsdf = met.closures.point(k).bsdf;
    bsdf.is_smooth().then(|| Rough {
        number: k,
        key,
        edges,
        throughput,
        point,
        bsdf,
        wo: -met.points.ray_dir.get(k),
        rays: 1.0,
        chance,
    })
}

/// Adds the light that a search found.
fn deposit(met: &Met, rough: &Rough, (found, light): (&Found, Vec3), onward: &mut Onward) {
    let k = rough.number;
    let path = met.path(k);
    if let Some(linked) = &onward.linked
        && !linked.links.reaches(found.lamp, found.last.inst_id)
    {
        return;
    }
    let edges = path.edges + found.turns.count as u32 + 1;
    let light = add(onward.radiance, path.lane, light, edges, met.options.clamp);
    if let Some(recorder) = &mut onward.recorder {
        recorder.found(path.trail, light);
    }
    if let Some(seen) = &mut onward.seen {
        seen.add(path.lane, light, (path.scattered + 1, edges));
    }
    if let Some(ledger) = &mut onward.ledger {
        let end = ledger.paths.classes.light(found.lamp, met.world.light_set());
        let how = (rough.bsdf.is_transmitted(found.dir), false);
        let here = met.events(ledger, k, [rough.wo, found.dir], how);
        let turn = |at: usize| -> [(Scatter, Vec3); 1] {
            let is_through = found.turns.through >> at & 1 != 0;
            [(ledger.paths.classes.scatter(found.materials[at], is_through, Lobe::Singular), Vec3::ONE)]
        };
        let turns: Vec<_> = (0..found.turns.count).map(turn).collect();
        let events: Vec<&[(Scatter, Vec3)]> =
            std::iter::once(&here[..]).chain(turns.iter().map(|turn| &turn[..])).collect();
        ledger.found_beyond(met.numbers[k] as usize, &events, (path.lane, light), end);
    }
}
