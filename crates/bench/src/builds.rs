// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench build`: time and memory of trees, and of Embree's. Processor time is that of the whole program,
//! which does nothing else meanwhile; the first build of each, which is not timed, traces some rays, and all
//! must agree. Tests: `tests::builds_a_box`.

use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::accel::{BuildOptions, Coherence, ObjectTree, Threads};
use gnurt::simd::Level;
use serde_json::{Value, json};

use crate::clock::{process_seconds, thread_seconds};
use crate::comparison::check;
use crate::embree::EmbreeEngine;
use crate::event::BenchEvent;
use crate::ffi_embree::{Device, Scene};
use crate::job::{ENGINES, EmbreeKind, OwnKind, Packets, QueryKind};
use crate::memory::growth;
use crate::options::Options as RayOptions;
use crate::own::OwnEngine;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::timing::Rays;
use crate::{Class, Contestant, EmbreeLibrary, Error, Filter, Subject};

/// The scenes to measure, and the method.
#[derive(Clone, Debug)]
pub struct Options {
    /// Which builds: of the modes, the part before the kind of query (`bvh-high`, `kd-fast`, `compact`).
    pub filter: Filter,
    /// Runs of each.
    pub rounds: usize,
    /// Instruction set of Embree, and of the rays that check the trees. Ours are built with the best.
    pub level: Level,
}

/// One build's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildRow {
    /// The scene.
    pub scene: String,
    /// `gnurt` or `embree4`.
    pub engine: &'static str,
    /// The built structure.
    pub mode: String,
    /// Threads that built.
    pub threads: usize,
    /// Triangles of the scene.
    pub triangles: u64,
    /// Median of the processor time of all threads, in seconds.
    pub cpu_s: f64,
    /// Median of the time on the wall, in seconds.
    pub wall_s: f64,
    /// Least processor time.
    pub min: f64,
    /// Greatest processor time.
    pub max: f64,
    /// Runs.
    pub runs: usize,
    /// Bytes of the tree and its triangles.
    pub bytes: u64,
    /// The most memory while it was built: Embree's own count, of ours the growth of the program.
    pub peak_bytes: Option<u64>,
    /// Cost of a ray by the surface area heuristic, in the builder's unit; Embree keeps it to itself.
    pub sah_cost: Option<f64>,
    /// Nodes.
    pub nodes: Option<u64>,
}

/// Something to be built.
#[derive(Clone, Copy)]
enum Plan {
    Own(OwnKind),
    Embree(EmbreeKind),
}

impl Plan {
    fn all() -> Vec<Self> {
        OwnKind::all().into_iter().map(Self::Own).chain(EmbreeKind::ALL.map(Self::Embree)).collect()
    }

    fn engine(self) -> &'static str {
        ENGINES[usize::from(matches!(self, Self::Embree(_)))]
    }

    fn mode(self) -> String {
        match self {
            Self::Own(kind) => kind.name(),
            Self::Embree(kind) => kind.name().into(),
        }
    }
}

fn plans(filter: &Filter) -> Result<Vec<Plan>, Error> {
    let mut plans = Plan::all();
    plans.retain(|plan| filter.has_engine(plan.engine()));
    let modes: Vec<String> = plans.iter().map(|plan| plan.mode()).collect();
    if !filter.modes.iter().all(|part| modes.iter().any(|mode| mode.contains(part))) {
        return Err(Error::NothingToDo { valid: modes });
    }
    let is_usual = |plan: &Plan| match plan {
        Plan::Own(kind) => !kind.is_second(),
        Plan::Embree(_) => true,
    };
    plans.retain(|plan| match filter.modes.is_empty() {
        true => is_usual(plan),
        false => filter.modes.iter().any(|part| plan.mode().contains(part)),
    });
    Ok(plans)
}

/// Checks the choice of builds, to fail before the work.
///
/// # Errors
/// [`Error::NothingToDo`] if a part of a name is in no mode.
pub fn check_filter(filter: &Filter) -> Result<(), Error> {
    plans(filter).map(drop)
}

/// Measures one scene, with one thread and with those of `pool`, the plans alternating.
///
/// # Errors
/// As [`rays::run`](crate::rays::run).
pub fn run(
    subject: &Subject,
    options: &Options,
    embree: Option<&EmbreeLibrary>,
    pool: &ThreadPool,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<BuildRow>, Error> {
    let mut plans = plans(&options.filter)?;
    plans.retain(|plan| embree.is_some() || matches!(plan, Plan::Own(..)));
    if plans.is_empty() {
        return Err(Error::NothingToDo { valid: Plan::all().iter().map(|plan| plan.mode()).collect() });
    }
    let all_threads = pool.current_num_threads();
    let counts: &[usize] = if all_threads == 1 { &[1] } else { &[1, all_threads] };
    let mut rows = Vec::new();
    for &threads in counts {
        let device = embree.map(|library| library.device(options.level, threads)).transpose()?;
        let site = Site { subject, threads, pool, device: device.as_ref(), level: options.level };
        if rows.is_empty() {
            site.check(&plans, report)?;
        }
        let mut builds: Vec<Vec<Build>> = plans.iter().map(|_| Vec::new()).collect();
        for _ in 0..options.rounds {
            for (plan, builds) in plans.iter().zip(&mut builds) {
                builds.push(site.build(*plan)?.1);
            }
        }
        rows.extend(plans.iter().zip(&builds).map(|(plan, builds)| site.row(*plan, builds)));
    }
    Ok(rows)
}

/// Where it is built.
struct Site<'a> {
    subject: &'a Subject,
    threads: usize,
    pool: &'a ThreadPool,
    device: Option<&'a Device<'a>>,
    level: Level,
}

/// The result of a build.
enum Built<'a> {
    Own(Box<ObjectTree>),
    Embree(Scene<'a>),
}

/// One build's numbers.
#[derive(Clone, Copy)]
struct Build {
    cpu: f64,
    wall_time: f64,
    bytes: u64,
    peak: Option<u64>,
    sah_cost: Option<f64>,
    nodes: Option<u64>,
}

impl<'a> Site<'a> {
    fn build(&self, plan: Plan) -> Result<(Built<'a>, Build), Error> {
        let held_before = self.device.map_or(0, |device| device.memory().0);
        let ((built, cpu, wall_time), growth) = growth(|| {
            // One thread builds where it is called. Idle workers of Embree's may spin meanwhile.
            let cpu_seconds = if self.threads == 1 { thread_seconds } else { process_seconds };
            let (start, before) = (Instant::now(), cpu_seconds());
            let built = self.construct(plan);
            (built, cpu_seconds() - before, start.elapsed().as_secs_f64())
        });
        let built = built?;
        let build = match &built {
            Built::Own(tree) => {
                let stats = tree.stats();
                let bytes = stats.tree_bytes + stats.primitive_bytes;
                let (sah_cost, nodes) = (Some(stats.sah_cost), Some(stats.nodes));
                Build { cpu, wall_time, bytes, peak: growth, sah_cost, nodes }
            }
            Built::Embree(_) => {
                let (held, peak) = self.device.map_or((0, 0), Device::memory);
                let above = |bytes: i64| (bytes - held_before).max(0).unsigned_abs();
                Build {
                    cpu,
                    wall_time,
                    bytes: above(held),
                    peak: Some(above(peak)),
                    sah_cost: None,
                    nodes: None,
                }
            }
        };
        Ok((built, build))
    }

    fn construct(&self, plan: Plan) -> Result<Built<'a>, Error> {
        match (plan, self.device) {
            (Plan::Own(kind), _) => {
                let threads = if self.threads == 1 { Threads::Single } else { Threads::Pool(self.pool) };
                let tree = ObjectTree::build(&[self.subject.triangles()], &kind.options(), threads);
                Ok(Built::Own(Box::new(tree)))
            }
            (Plan::Embree(kind), Some(device)) => {
                let (quality, flags) = kind.settings();
                let (padded, indices) = (&self.subject.padded, &self.subject.indices);
                let scene = Scene::build(device, padded, indices, quality, flags);
                scene.map(Built::Embree).map_err(|why| Error::Embree { library: "embree4".into(), why })
            }
            (Plan::Embree(_), None) => Err(Error::NothingToDo { valid: Vec::new() }),
        }
    }

    /// Builds each once and compares the trees' answers.
    fn check(&self, plans: &[Plan], report: &mut dyn FnMut(BenchEvent)) -> Result<(), Error> {
        let built =
            plans.iter().map(|plan| Ok((*plan, self.build(*plan)?.0))).collect::<Result<Vec<_>, _>>()?;
        let reference = ObjectTree::build(
            &[self.subject.triangles()],
            &BuildOptions::default(),
            Threads::Pool(self.pool),
        );
        let maker = RayMaker::new(self.subject, 128, &reference, self.level)?;
        let query_kind = QueryKind::Batch(Coherence::Incoherent);
        let contestants: Vec<Contestant> = built
            .iter()
            .map(|(plan, built)| Contestant {
                engine: plan.engine(),
                mode: plan.mode(),
                isa: self.level.name(),
                tracer: match built {
                    Built::Own(tree) => Box::new(OwnEngine { tree, query_kind, level: self.level }),
                    Built::Embree(scene) => {
                        Box::new(EmbreeEngine { scene, packets: Packets { size: 1, coherent: false } })
                    }
                },
            })
            .collect();
        let options = RayOptions::default();
        for class in [Class::Primary, Class::Diffuse] {
            let rays =
                Rays::new(maker.rays(class, options.batch), class.is_any_hit(), self.subject.triangles());
            let what = format!("{} {class}", self.subject.name);
            check(&what, &rays, &contestants, options.tolerance, report)?;
        }
        Ok(())
    }

    fn row(&self, plan: Plan, builds: &[Build]) -> BuildRow {
        let of = |value: fn(&Build) -> f64| builds.iter().map(value).collect::<Vec<f64>>();
        let cpu = of(|build| build.cpu);
        let last = builds.last();
        BuildRow {
            scene: self.subject.name.clone(),
            engine: plan.engine(),
            mode: plan.mode(),
            threads: self.threads,
            triangles: self.subject.triangle_count() as u64,
            cpu_s: median(&cpu),
            wall_s: median(&of(|build| build.wall_time)),
            min: cpu.iter().copied().fold(f64::INFINITY, f64::min),
            max: cpu.iter().copied().fold(0.0, f64::max),
            runs: builds.len(),
            bytes: last.map_or(0, |build| build.bytes),
            peak_bytes: builds.iter().filter_map(|build| build.peak).max(),
            sah_cost: last.and_then(|build| build.sah_cost),
            nodes: last.and_then(|build| build.nodes),
        }
    }
}

/// A table for people.
#[must_use]
pub fn table(rows: &[BuildRow]) -> String {
    let mut text = String::new();
    let mut scene = "";
    for row in rows {
        if row.scene != scene {
            scene = &row.scene;
            text += &format!(
                "{scene}: {} triangles, median of {}\n  {:<8} {:<10} {:>7} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>9} {:>10}\n",
                row.triangles,
                row.runs,
                "engine",
                "mode",
                "threads",
                "CPU s",
                "min",
                "max",
                "wall s",
                "MB",
                "peak MB",
                "SAH cost",
                "nodes"
            );
        }
        let megabytes = |bytes: u64| format!("{:.1}", bytes as f64 / 1e6);
        let or_dash = |value: Option<String>| value.unwrap_or_else(|| "-".into());
        text += &format!(
            "  {:<8} {:<10} {:>7} {:>8.3} {:>8.3} {:>8.3} {:>8.3} {:>9} {:>9} {:>9} {:>10}\n",
            row.engine,
            row.mode,
            row.threads,
            row.cpu_s,
            row.min,
            row.max,
            row.wall_s,
            megabytes(row.bytes),
            or_dash(row.peak_bytes.map(megabytes)),
            or_dash(row.sah_cost.map(|cost| format!("{cost:.1}"))),
            or_dash(row.nodes.map(|nodes| nodes.to_string()))
        );
    }
    text
}

/// An array of objects.
#[must_use]
pub fn to_json(rows: &[BuildRow]) -> Value {
    rows.iter()
        .map(|row| {
            json!({
                "scene": row.scene,
                "engine": row.engine,
                "mode": row.mode,
                "threads": row.threads,
                "triangles": row.triangles,
                "cpu_s": row.cpu_s,
                "wall_s": row.wall_s,
                "min": row.min,
                "max": row.max,
                "runs": row.runs,
                "bytes": row.bytes,
                "peak_bytes": row.peak_bytes,
                "sah_cost": row.sah_cost,
                "nodes": row.nodes,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builds_a_box() {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        let subject = Subject::new("cornell", &scene);
        let pool = gnurt::thread_pool(2).expect("threads");
        let filter = Filter { engines: vec!["gnurt".into()], modes: Vec::new() };
        let options = Options { filter, rounds: 2, level: Level::best() };
        let rows = run(&subject, &options, None, &pool, &mut |_| {}).expect("it can be built");
        assert_eq!(rows.len(), 2 * 6, "six builds with one thread and with two");
        for row in &rows {
            assert!(row.bytes > 0 && row.sah_cost.is_some_and(|cost| cost > 0.0), "{row:?}");
            assert!(row.wall_s > 0.0 && row.min <= row.cpu_s && row.cpu_s <= row.max, "{row:?}");
        }
        let text = table(&rows);
        assert_eq!(text.lines().count(), 2 + rows.len(), "a title, a head, a line each: {text}");
        assert_eq!(to_json(&rows).as_array().map(Vec::len), Some(rows.len()), "an object each");
        let slip = Filter { engines: Vec::new(), modes: vec!["compakt".into()] };
        assert!(matches!(check_filter(&slip), Err(Error::NothingToDo { .. })), "a slip is told");
    }
}
