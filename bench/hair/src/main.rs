// SPDX-License-Identifier: GPL-3.0-or-later
//! Hair beside Embree's: rays, builds and memory, with processor time of one thread, in turns.
//! Run in this folder: `EMBREE4_LIB=FILE cargo run --release -- [--strands N] [--size N] [--rounds N] [--hair fur,long]
//! [--type flat-bspline,...] [--class camera,...] [--json FILE]`. A library that was built without curves finds no hits.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

// By the names of the crate that the file below belongs to.
extern crate self as gnurt;
mod accel {
    pub(crate) use gnurt_accel::Ray;
}
#[allow(dead_code, reason = "for more than curves")]
#[path = "../../../crates/bench/src/ffi_embree.rs"]
mod ffi_embree;
mod strands;

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use ffi_embree::{Active, Arguments, Device, Library, Packet, Scene};
use gnurt_accel::{
    BuildOptions, Coherence, CurveBasis, CurveForm, Curves, HitBatch, INVALID_ID, ObjectTree, Query,
    RayBatch, Record, Threads,
};
use strands::Strands;

fn seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What rays are traced by.
enum Engine<'a> {
    Ours(&'a ObjectTree, Option<Coherence>),
    Theirs(&'a Scene<'a>, usize, bool),
}

/// Distances of closest hits, or 0 and infinity for any.
fn trace(engine: &Engine, rays: &RayBatch, any: bool, t: &mut Vec<f32>) {
    t.clear();
    let of = |hit: bool| if hit { 0.0 } else { f32::INFINITY };
    match engine {
        Engine::Ours(tree, None) if any => {
            t.extend((0..rays.len()).map(|i| of(tree.occluded(&rays.get(i)))));
        }
        Engine::Ours(tree, None) => {
            t.extend(
                (0..rays.len()).map(|i| tree.intersect(&rays.get(i)).map_or(f32::INFINITY, |hit| hit.t)),
            );
        }
        Engine::Ours(tree, Some(coherence)) => {
            let query = Query { coherence: *coherence, ..Query::default() };
            let mut record = Record::default();
            if any {
                let mut occluded = Vec::new();
                tree.occluded_batch(&query, rays, &mut occluded, &mut record);
                t.extend(occluded.iter().map(|&hit| of(hit)));
            } else {
                let mut hits = HitBatch::default();
                tree.intersect_batch(&query, rays, &mut hits, &mut record);
                t.extend_from_slice(&hits.t);
                if std::env::var_os("COUNT").is_some() {
                    println!("{:?} {:?}", rays.len(), record);
                }
            }
        }
        Engine::Theirs(scene, 1, coherent) => packets::<1>(scene, rays, any, *coherent, t),
        Engine::Theirs(scene, 8, coherent) => packets::<8>(scene, rays, any, *coherent, t),
        Engine::Theirs(scene, _, coherent) => packets::<16>(scene, rays, any, *coherent, t),
    }
}

fn packets<const N: usize>(scene: &Scene, rays: &RayBatch, any: bool, coherent: bool, t: &mut Vec<f32>) {
    let (mut packet, mut active, arguments) = (Packet::<N>::new(), Active([-1; N]), Arguments::new(coherent));
    for first in (0..rays.len()).step_by(N) {
        let count = N.min(rays.len() - first);
        (0..N).for_each(|lane| active.0[lane] = if lane < count { -1 } else { 0 });
        for k in 0..3 {
            packet.org[k][..count].copy_from_slice(&rays.org[k][first..first + count]);
            packet.dir[k][..count].copy_from_slice(&rays.dir[k][first..first + count]);
        }
        packet.t_near[..count].copy_from_slice(&rays.t_near[first..first + count]);
        packet.t_far[..count].copy_from_slice(&rays.t_far[first..first + count]);
        packet.geom_id = [INVALID_ID; N];
        packet.inst_id = [INVALID_ID; N];
        if any {
            scene.occluded(&active, &mut packet, &arguments);
            let hit = |lane: usize| packet.t_far[lane] == f32::NEG_INFINITY;
            t.extend((0..count).map(|lane| if hit(lane) { 0.0 } else { f32::INFINITY }));
        } else {
            scene.intersect(&active, &mut packet, &arguments);
            let hit = |lane: usize| packet.geom_id[lane] != INVALID_ID;
            t.extend((0..count).map(|lane| if hit(lane) { packet.t_far[lane] } else { f32::INFINITY }));
        }
    }
}

/// Embree's scene of curves without normals or tangents of their own, in medium quality.
fn build_theirs<'a>(device: &'a Device<'a>, curves: &Curves<'a>) -> Result<Scene<'a>, String> {
    let is_flat = match curves.form {
        CurveForm::Round => 0,
        CurveForm::Flat => 1,
        CurveForm::Oriented => return Err("oriented curves need normals".into()),
    };
    // RTC_GEOMETRY_TYPE_*_CURVE, round and then flat.
    let (first, order) = match curves.basis {
        CurveBasis::Linear => (16, 2),
        CurveBasis::Bezier => (24, 4),
        CurveBasis::BSpline => (32, 4),
        CurveBasis::CatmullRom => (58, 4),
        CurveBasis::Hermite => return Err("Hermite curves need tangents".into()),
    };
    Scene::build_curves(device, first + is_flat, curves.vertices, curves.indices, order, 1)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let given: HashMap<&str, &str> = words
        .chunks(2)
        .filter_map(|pair| match pair {
            [key, value] => Some((key.trim_start_matches('-'), value.as_str())),
            _ => None,
        })
        .collect();
    let text = |key: &str, other: &'static str| given.get(key).map_or(other, |value| *value);
    let number = |key: &str, other: &'static str| text(key, other).parse::<usize>();
    let (count, size, rounds) =
        (number("strands", "100000")?, number("size", "256")?, number("rounds", "5")?);
    let builds = number("builds", "3")?;
    let file = std::env::var_os("EMBREE4_LIB").ok_or("EMBREE4_LIB names no library of Embree 4")?;
    let library = Library::open(Path::new(&file))?;
    let device = Device::open(&library, "threads=1")?;
    let is_asked =
        |key: &str, name: &str, other: &'static str| text(key, other).split(',').any(|word| word == name);
    let mut json = String::from("[\n");
    for hair in ["fur", "long"].into_iter().filter(|hair| is_asked("hair", hair, "fur,long")) {
        for (name, basis, form) in [
            ("flat-linear", CurveBasis::Linear, CurveForm::Flat),
            ("round-linear", CurveBasis::Linear, CurveForm::Round),
            ("flat-bspline", CurveBasis::BSpline, CurveForm::Flat),
            ("round-bspline", CurveBasis::BSpline, CurveForm::Round),
            ("flat-bezier", CurveBasis::Bezier, CurveForm::Flat),
        ] {
            if !is_asked("type", name, "flat-linear,round-linear,flat-bspline,round-bspline") {
                continue;
            }
            let strands = Strands::new(hair, count, basis);
            let curves = Curves {
                pieces: number("pieces", "0")? as u8,
                ..Curves::new(basis, form, &strands.vertices, &strands.indices)
            };
            let arrays = 16 * strands.vertices.len() + 4 * strands.indices.len();
            let (mut own_build, mut their_build) = (Vec::new(), Vec::new());
            let (mut tree, mut scene, mut bytes) = (None, None, 0);
            for _ in 0..builds.max(1) {
                drop(tree.take());
                let start = seconds();
                tree =
                    Some(ObjectTree::build_from(&[curves.into()], &BuildOptions::default(), Threads::Single));
                own_build.push(seconds() - start);
                drop(scene.take());
                let before = device.memory().0;
                let start = seconds();
                scene = Some(build_theirs(&device, &curves)?);
                their_build.push(seconds() - start);
                bytes = device.memory().0 - before;
            }
            let (Some(tree), Some(scene)) = (&tree, &scene) else { continue };
            let stats = tree.stats();
            let own_bytes = stats.tree_bytes + stats.primitive_bytes;
            let (own, their) = (median(&mut own_build), median(&mut their_build));
            println!(
                "{hair} {name}: build {own:.3} s, Embree {their:.3} s, ratio {:.2}; {:.1} MB, Embree {:.1} MB, ratio {:.2}; \
                 with arrays of {:.1} MB {:.2}; {} references, {} nodes, cost {:.1}",
                their / own,
                own_bytes as f64 / 1e6,
                bytes as f64 / 1e6,
                own_bytes as f64 / bytes as f64,
                arrays as f64 / 1e6,
                own_bytes as f64 / (bytes as usize + arrays) as f64,
                stats.references,
                stats.nodes,
                stats.sah_cost,
            );
            writeln!(
                json,
                r#"{{"hair":"{hair}","type":"{name}","build":{own:.4},"embree_build":{their:.4},"bytes":{own_bytes},"embree_bytes":{bytes},"arrays":{arrays}}},"#
            )?;
            let camera = strands::camera(size as u32);
            let mut t = Vec::new();
            trace(&Engine::Theirs(scene, 1, false), &camera, false, &mut t);
            let shadow = strands::further(&camera, &t, true);
            let diffuse = strands::further(&camera, &t, false);
            let random = strands::random(camera.len());
            let engines = [
                ("single", Engine::Ours(tree, None)),
                ("coherent", Engine::Ours(tree, Some(Coherence::Coherent))),
                ("fanned", Engine::Ours(tree, Some(Coherence::Fanned))),
                ("incoherent", Engine::Ours(tree, Some(Coherence::Incoherent))),
                ("e1", Engine::Theirs(scene, 1, false)),
                ("e8", Engine::Theirs(scene, 8, false)),
                ("e16", Engine::Theirs(scene, 16, false)),
                ("e16c", Engine::Theirs(scene, 16, true)),
            ];
            let classes = [
                ("camera", &camera, false),
                ("shadow", &shadow, true),
                ("diffuse", &diffuse, false),
                ("random", &random, false),
            ];
            for (class, rays, any) in classes {
                if !is_asked("class", class, "camera,shadow,diffuse,random") {
                    continue;
                }
                let mut times = vec![Vec::new(); engines.len()];
                let mut answers = vec![Vec::new(); engines.len()];
                for _ in 0..rounds {
                    for (i, (mode, engine)) in engines.iter().enumerate() {
                        if !is_asked("mode", mode, "single,coherent,fanned,incoherent,e1,e8,e16,e16c") {
                            continue;
                        }
                        let start = seconds();
                        trace(engine, rays, any, &mut answers[i]);
                        times[i].push(seconds() - start);
                    }
                }
                let rate = |times: &mut Vec<f64>| {
                    if times.is_empty() { 0.0 } else { rays.len() as f64 / 1e6 / median(times) }
                };
                let rates: Vec<f64> = times.iter_mut().map(rate).collect();
                let best = |range: std::ops::Range<usize>| rates[range].iter().copied().fold(0.0, f64::max);
                let (ours, theirs) = (best(0..4), best(4..8));
                let hits = |t: &[f32]| t.iter().filter(|t| t.is_finite()).count();
                let differ = answers[4].iter().zip(&answers[0]).filter(|(a, b)| {
                    a.is_finite() != b.is_finite() || a.is_finite() && (**a - **b).abs() > 1e-3 * **a
                });
                let rates_text: Vec<String> =
                    engines.iter().zip(&rates).map(|((mode, _), rate)| format!("{mode} {rate:.3}")).collect();
                println!(
                    "  {class}: {}; best {:.2}, single {:.2}; {} rays, {} hits, {} differ",
                    rates_text.join(", "),
                    ours / theirs,
                    rates[0] / rates[4],
                    rays.len(),
                    hits(&answers[0]),
                    differ.count(),
                );
                let pairs: Vec<String> = engines
                    .iter()
                    .zip(&rates)
                    .map(|((mode, _), rate)| format!(r#""{mode}":{rate:.4}"#))
                    .collect();
                writeln!(
                    json,
                    r#"{{"hair":"{hair}","type":"{name}","class":"{class}",{},"best":{:.3},"single":{:.3}}},"#,
                    pairs.join(","),
                    ours / theirs,
                    rates[0] / rates[4]
                )?;
            }
        }
    }
    if let Some(file) = given.get("json") {
        std::fs::write(file, format!("{}\n]\n", json.trim_end().trim_end_matches(',')))?;
    }
    Ok(())
}
