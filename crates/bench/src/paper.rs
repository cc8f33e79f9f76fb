// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench paper`: tables 1 and 2 of the paper behind GNU RT, with its figures next to ours.
//! Source: its section 4 (Table 1, time to build a kd-tree) and 5.1 (Table 2, rays per second with and without SSE).
//! Ours: one thread builds the kd-tree, by the exact sweep and from samples of the cost; camera rays go in packets at
//! the level of SSE 4.2, and one by one at the scalar level. Its machine is of 2006 and is not named.
//! Tests: `tests::a_box_has_both_tables`.

use std::fmt::Write;
use std::time::Instant;

use gnurt::accel::{BuildOptions, Coherence, ObjectTree, Quality, Threads};
use gnurt::simd::Level;
use serde_json::{Value, json};

use crate::clock::thread_seconds;
use crate::comparison::hold;
use crate::event::BenchEvent;
use crate::job::QueryKind;
use crate::options::Options;
use crate::own::OwnEngine;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::timing::Rays;
use crate::{Class, Contestant, Error, Subject, research};

/// The values of \[SIP06\] for a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// The paper's name.
    pub scene: &'static str,
    /// Prefixes of the names of the scene, or of its substitutes.
    names: &'static [&'static str],
    /// Triangles.
    pub triangles: u64,
    /// Table 1: seconds to build.
    pub build_s: f64,
    /// Table 2: millions of rays per second, in packets of four with SSE.
    pub simd: f64,
    /// Table 2: one by one.
    pub scalar: f64,
}

const TABLE: [Figures; 4] = [
    Figures {
        scene: "Office",
        names: &["office"],
        triangles: 23_000,
        build_s: 0.065,
        simd: 5.0,
        scalar: 2.3,
    },
    Figures {
        scene: "Theater",
        names: &["theater", "soda"],
        triangles: 120_000,
        build_s: 3.0,
        simd: 2.8,
        scalar: 1.5,
    },
    Figures {
        scene: "Conference",
        names: &["conference"],
        triangles: 195_000,
        build_s: 3.9,
        simd: 4.4,
        scalar: 2.2,
    },
    Figures {
        scene: "Buddha",
        names: &["happy", "buddha", "dragon"],
        triangles: 1_100_000,
        build_s: 18.5,
        simd: 3.8,
        scalar: 1.9,
    },
];

/// A scene's line of both tables.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperRow {
    /// The scene.
    pub scene: String,
    /// The values of \[SIP06\] for it, or for the scene that it substitutes.
    pub paper: Option<Figures>,
    /// Triangles.
    pub triangles: u64,
    /// Processor time of the exact build, in seconds.
    pub build_cpu_s: f64,
    /// Time on the wall of the exact build.
    pub build_wall_s: f64,
    /// Processor time of the build from samples.
    pub fast_cpu_s: f64,
    /// Millions of rays per second of processor time, in packets at SSE 4.2.
    pub simd: f64,
    /// The same at the scalar level, one by one.
    pub scalar: f64,
    /// The same in packets at the CPU's best level.
    pub best: f64,
    /// Name of that level.
    pub best_isa: &'static str,
}

/// Measures one scene with one thread; of `options` size, rounds and batch count.
///
/// # Errors
/// [`Error::NoResearch`] without kd-trees, [`Error::Scene`] without a view, [`Error::Differ`] if the levels disagree.
pub fn run(
    subject: &Subject,
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<PaperRow, Error> {
    let structure = research::require("kd")?;
    let build = |quality| {
        let settings = BuildOptions { structure, quality, ..BuildOptions::default() };
        let (start, before) = (Instant::now(), thread_seconds());
        let tree = ObjectTree::build(&[subject.triangles()], &settings, Threads::Single);
        (tree, thread_seconds() - before, start.elapsed().as_secs_f64())
    };
    let (mut fast, mut cpu, mut wall_time) = (Vec::new(), Vec::new(), Vec::new());
    let (tree, ..) = build(Quality::Medium);
    for _ in 0..options.rounds {
        fast.push(build(Quality::Fast).1);
        let (_, cpu_s, wall_s) = build(Quality::Medium);
        cpu.push(cpu_s);
        wall_time.push(wall_s);
    }

    // If a level is missing (NEON machines), the one below it runs, and the row shows that level.
    let (simd, best) = (Level::Sse42, Level::best());
    let query_kind = [
        ("scalar", Level::Scalar, Coherence::Incoherent),
        ("simd", simd, Coherence::Coherent),
        ("best", best, Coherence::Coherent),
    ];
    let contestants = query_kind.map(|(mode, level, coherence)| Contestant {
        engine: "gnurt",
        mode: format!("kd-medium-{mode}"),
        isa: level.name(),
        tracer: Box::new(OwnEngine { tree: &tree, query_kind: QueryKind::Batch(coherence), level }),
    });
    let maker = RayMaker::new(subject, options.size, &tree, best)?;
    let rays = Rays::new(maker.rays(Class::Primary, options.batch), false, subject.triangles());
    let options = Options { threads: 1, ..options.clone() };
    let rows = hold(&subject.name, Class::Primary, &rays, &contestants, &options, report)?;
    let name = subject.name.to_lowercase();
    let is_it = |figures: &&Figures| figures.names.iter().any(|known| name.starts_with(known));
    Ok(PaperRow {
        scene: subject.name.clone(),
        paper: TABLE.iter().find(is_it).copied(),
        triangles: subject.triangle_count() as u64,
        build_cpu_s: median(&cpu),
        build_wall_s: median(&wall_time),
        fast_cpu_s: median(&fast),
        scalar: rows[0].mrays_cpu,
        simd: rows[1].mrays_cpu,
        best: rows[2].mrays_cpu,
        best_isa: best.name(),
    })
}

/// Both tables.
#[must_use]
pub fn tables(rows: &[PaperRow]) -> String {
    let dash = || "-".to_string();
    let of = |row: &PaperRow, value: fn(&Figures) -> f64| {
        row.paper.as_ref().map_or_else(dash, |figures| value(figures).to_string())
    };
    let named = |row: &PaperRow| row.paper.map_or("-", |figures| figures.scene);
    // Writing to a string does not fail.
    let mut text = String::from("Table 1: seconds to build a kd-tree, one thread\n");
    let _ = writeln!(
        text,
        "  {:<12} {:>10} {:<12} {:>9} {:>7} {:>9} {:>9} {:>9} {:>7}",
        "paper", "triangles", "here", "triangles", "paper", "CPU", "wall", "sampled", "ratio"
    );
    for row in rows {
        let ratio =
            row.paper.map_or_else(dash, |figures| format!("{:.1}", figures.build_s / row.build_cpu_s));
        let _ = writeln!(
            text,
            "  {:<12} {:>10} {:<12} {:>9} {:>7} {:>9.3} {:>9.3} {:>9.3} {:>7}",
            named(row),
            of(row, |figures| figures.triangles as f64),
            row.scene,
            row.triangles,
            of(row, |figures| figures.build_s),
            row.build_cpu_s,
            row.build_wall_s,
            row.fast_cpu_s,
            ratio
        );
    }
    let best = rows.first().map_or("best", |row| row.best_isa);
    text += "\nTable 2: millions of rays per second, kd-tree, one thread\n";
    let _ = writeln!(
        text,
        "  {:<12} {:<12} {:>9} {:>9} {:>6} {:>9} {:>9} {:>6} {:>9} {:>6}",
        "paper", "here", "SSE", "non-SSE", "gain", "sse4.2", "scalar", "gain", best, "gain"
    );
    for row in rows {
        let gain = row.paper.map_or_else(dash, |figures| format!("{:.1}", figures.simd / figures.scalar));
        let _ = writeln!(
            text,
            "  {:<12} {:<12} {:>9} {:>9} {:>6} {:>9.2} {:>9.2} {:>6.1} {:>9.2} {:>6.1}",
            named(row),
            row.scene,
            of(row, |figures| figures.simd),
            of(row, |figures| figures.scalar),
            gain,
            row.simd,
            row.scalar,
            row.simd / row.scalar,
            row.best,
            row.best / row.scalar
        );
    }
    text
}

/// An array of objects; values missing from the paper are null.
#[must_use]
pub fn to_json(rows: &[PaperRow]) -> Value {
    rows.iter()
        .map(|row| {
            let paper = row.paper.map(|figures| {
                json!({
                    "scene": figures.scene,
                    "triangles": figures.triangles,
                    "build_s": figures.build_s,
                    "simd_mrays": figures.simd,
                    "scalar_mrays": figures.scalar,
                })
            });
            json!({
                "scene": row.scene,
                "triangles": row.triangles,
                "build_cpu_s": row.build_cpu_s,
                "build_wall_s": row.build_wall_s,
                "sampled_build_cpu_s": row.fast_cpu_s,
                "sse42_mrays": row.simd,
                "scalar_mrays": row.scalar,
                "best_mrays": row.best,
                "best_isa": row.best_isa,
                "paper": paper,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_both_tables() {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        let options = Options { size: 32, rounds: 1, ..Options::default() };
        let measure =
            |name| run(&Subject::new(name, &scene), &options, &mut |_| {}).expect("it can be measured");
        // The box under the name of a scene of the paper, and under its own.
        let rows = [measure("soda"), measure("box")];
        assert_eq!(rows[0].paper.map(|figures| figures.scene), Some("Theater"), "what soda stands in for");
        assert_eq!(rows[1].paper, None, "the paper knows no such scene");
        assert!(
            rows.iter().all(|row| row.scalar > 0.0 && row.simd > 0.0 && row.build_wall_s > 0.0),
            "{rows:?}"
        );
        let text = tables(&rows);
        assert!(text.contains("120000") && text.contains("2.8") && text.contains("1.9"), "{text}");
        assert_eq!(to_json(&rows)[1]["paper"], Value::Null, "nothing is made up");
    }
}
