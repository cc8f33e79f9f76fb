// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench rays`: rates of ray queries, job by job. Source: original.
//! Jobs take turns, round by round, so that what else the machine does meets all of them alike.
//! Proof: `tests::measures_a_box`, and `tests/program/bench.rs` of the program.

use gnurt::ThreadPool;
use gnurt::accel::{BuildOptions, ObjectTree, Quality, Structure, Threads};
use gnurt::simd::Level;

use crate::embree::EmbreeEngine;
use crate::ffi_embree::{Device, Scene};
use crate::job::{EmbreeKind, quality_name, structure_name};
use crate::own::OwnEngine;
use crate::ray_classes::RayMaker;
use crate::row::median;
use crate::timing::{Engine, Rays, Seconds, answers, time};
use crate::verdict::{Sums, compare};
use crate::{Class, EmbreeLibrary, Error, Filter, Job, Row, Subject};

/// What is to be measured, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Classes of rays.
    pub classes: Vec<Class>,
    /// Which jobs.
    pub filter: Filter,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Runs of each job.
    pub rounds: usize,
    /// Rays per batch: what a call gets that takes more than one ray.
    pub batch: usize,
    /// Threads that trace.
    pub threads: usize,
    /// Instruction set.
    pub level: Level,
}

/// News while it goes on.
#[derive(Debug)]
pub enum News<'a> {
    /// A tree is there.
    Built(String),
    /// Answers differ, but by no more than rounding explains.
    Differs(String),
    /// A class is done: its rows, in the order of the jobs.
    Class(&'a [Row]),
}

/// Measures one scene. Trees are built with `pool`; `embree` is the rival, if there is one.
///
/// # Errors
/// [`Error::NothingToDo`] without a job, [`Error::Embree`] if the library fails, [`Error::Scene`] without a view, and
/// [`Error::Differ`] if engines disagree.
pub fn run(
    subject: &Subject,
    options: &Options,
    embree: Option<&EmbreeLibrary>,
    pool: &ThreadPool,
    tell: &mut dyn FnMut(News),
) -> Result<Vec<Row>, Error> {
    let jobs = jobs(options, embree.is_some())?;
    let device = embree.map(|library| library.device(options.level)).transpose()?;
    let rival = embree.zip(device.as_ref());
    let trees = Trees::build(subject, &jobs, rival, pool, tell)?;
    let engines: Vec<(Job, Box<dyn Engine + '_>)> =
        jobs.into_iter().filter_map(|job| Some((job, trees.engine(job, options.level)?))).collect();

    let maker = RayMaker::new(subject, options.size, trees.reference(), options.level)?;
    let mut rows = Vec::new();
    for &class in &options.classes {
        let rays = Rays { chunks: maker.rays(class, options.batch), any: class.is_any_hit() };
        let first = rows.len();
        rows.extend(measure(subject, options, class, &rays, &engines, tell)?);
        tell(News::Class(&rows[first..]));
    }
    Ok(rows)
}

fn jobs(options: &Options, has_embree: bool) -> Result<Vec<Job>, Error> {
    let mut jobs = options.filter.jobs()?;
    jobs.retain(|job| has_embree || matches!(job, Job::Own { .. }));
    if jobs.is_empty() {
        return Err(Error::NothingToDo { valid: Job::all().iter().map(Job::mode).collect() });
    }
    Ok(jobs)
}

/// All that the jobs ask.
struct Trees<'a> {
    own: Vec<(Structure, Quality, ObjectTree)>,
    embree: Vec<(EmbreeKind, Scene<'a>)>,
    device: Option<&'a Device<'a>>,
}

impl<'a> Trees<'a> {
    fn build(
        subject: &'a Subject,
        jobs: &[Job],
        rival: Option<(&EmbreeLibrary, &'a Device<'a>)>,
        pool: &ThreadPool,
        tell: &mut dyn FnMut(News),
    ) -> Result<Self, Error> {
        let mut trees = Self { own: Vec::new(), embree: Vec::new(), device: rival.map(|(_, device)| device) };
        // The tree that decides what primary rays see comes first: the same whatever is measured.
        trees.add_own(subject, Structure::Kd, Quality::Medium, pool, tell);
        for job in jobs {
            match *job {
                Job::Own { structure, quality, .. } => {
                    trees.add_own(subject, structure, quality, pool, tell);
                }
                Job::Embree { kind, .. } => {
                    let is_there = trees.embree.iter().any(|(known, _)| *known == kind);
                    if let Some((library, device)) = rival.filter(|_| !is_there) {
                        let (quality, flags) = kind.settings();
                        let scene = Scene::build(device, &subject.padded, &subject.indices, quality, flags);
                        trees.embree.push((kind, scene.map_err(|why| library.failed(why))?));
                        tell(News::Built(format!("{}: embree4 {}", subject.name, kind.name())));
                    }
                }
            }
        }
        Ok(trees)
    }

    fn add_own(
        &mut self,
        subject: &Subject,
        structure: Structure,
        quality: Quality,
        pool: &ThreadPool,
        tell: &mut dyn FnMut(News),
    ) {
        if self.own(structure, quality).is_none() {
            let options = BuildOptions { structure, quality, ..BuildOptions::default() };
            let tree = ObjectTree::build(&[subject.triangles()], &options, Threads::Pool(pool));
            let (structure_name, quality_name) = (structure_name(structure), quality_name(quality));
            tell(News::Built(format!("{}: gnurt {structure_name}-{quality_name}", subject.name)));
            self.own.push((structure, quality, tree));
        }
    }

    fn own(&self, structure: Structure, quality: Quality) -> Option<&ObjectTree> {
        let found = self.own.iter().find(|(s, q, _)| *s == structure && *q == quality);
        found.map(|(_, _, tree)| tree)
    }

    fn reference(&self) -> &ObjectTree {
        &self.own[0].2
    }

    /// `None` for packets that this CPU has no code for.
    fn engine(&'a self, job: Job, level: Level) -> Option<Box<dyn Engine + 'a>> {
        match job {
            Job::Own { structure, quality, asked } => {
                let tree = self.own(structure, quality)?;
                Some(Box::new(OwnEngine { tree, asked, level }))
            }
            Job::Embree { kind, packets } => {
                let (_, scene) = self.embree.iter().find(|(known, _)| *known == kind)?;
                let has_code = self.device.is_some_and(|device| device.has_packets(packets.size));
                has_code.then(|| Box::new(EmbreeEngine { scene, packets }) as Box<dyn Engine>)
            }
        }
    }
}

/// Compares, then times.
fn measure(
    subject: &Subject,
    options: &Options,
    class: Class,
    rays: &Rays,
    engines: &[(Job, Box<dyn Engine + '_>)],
    tell: &mut dyn FnMut(News),
) -> Result<Vec<Row>, Error> {
    let sums = check(&format!("{} {class}", subject.name), rays, engines, tell)?;
    let mut seconds: Vec<Vec<Seconds>> = vec![Vec::new(); engines.len()];
    for _ in 0..options.rounds {
        for ((_, engine), seconds) in engines.iter().zip(&mut seconds) {
            seconds.push(time(&**engine, rays, options.threads));
        }
    }
    let rows = engines.iter().zip(&sums).zip(&seconds);
    Ok(rows
        .map(|(((job, _), sums), seconds)| row(subject, options, class, rays, *job, *sums, seconds))
        .collect())
}

/// Asks every engine once, and compares its answers with the first one's.
fn check(
    what: &str,
    rays: &Rays,
    engines: &[(Job, Box<dyn Engine + '_>)],
    tell: &mut dyn FnMut(News),
) -> Result<Vec<Sums>, Error> {
    let mut reference: Option<(String, Vec<f32>)> = None;
    let mut sums = Vec::new();
    // What is to be told, and of whom: several jobs often have the same to tell.
    let mut differences: Vec<(String, Vec<String>)> = Vec::new();
    for (job, engine) in engines {
        let answers = answers(&**engine, rays);
        sums.push(Sums::of(&answers, rays.any));
        let Some((name, expected)) = &reference else {
            reference = Some((job.to_string(), answers));
            continue;
        };
        let differ = |how| Error::Differ(format!("{what}: {job} against {name}: {how}"));
        let Some(how) = compare(expected, &answers, rays.any).map_err(differ)? else { continue };
        match differences.iter_mut().find(|(known, _)| *known == how) {
            Some((_, jobs)) => jobs.push(job.mode()),
            None => differences.push((how, vec![job.to_string()])),
        }
    }
    let name = reference.map_or(String::new(), |(name, _)| name);
    for (how, jobs) in differences {
        tell(News::Differs(format!("{what}: {} against {name}: {how}", jobs.join(", "))));
    }
    Ok(sums)
}

fn row(
    subject: &Subject,
    options: &Options,
    class: Class,
    rays: &Rays,
    job: Job,
    sums: Sums,
    seconds: &[Seconds],
) -> Row {
    let millions = rays.len() as f64 / 1e6;
    // A clock that stands still between two ticks says nothing: a nanosecond at least.
    let rates = |of: fn(&Seconds) -> f64| -> Vec<f64> {
        let per_thread = |seconds: &Seconds| millions / of(seconds).max(1e-9);
        seconds.iter().map(per_thread).collect()
    };
    let cpu = rates(|seconds| seconds.cpu);
    Row {
        scene: subject.name.clone(),
        class,
        engine: job.engine(),
        mode: job.mode(),
        isa: options.level.name(),
        threads: options.threads,
        rays: rays.len() as u64,
        hits: sums.hits,
        sum_t: sums.sum_t,
        mrays_cpu: median(&cpu),
        mrays_wall: median(&rates(|seconds| seconds.wall)),
        min: cpu.iter().copied().fold(f64::INFINITY, f64::min),
        max: cpu.iter().copied().fold(0.0, f64::max),
        runs: seconds.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_a_box() {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        let subject = Subject::new("cornell", &scene);
        let options = Options {
            classes: Class::ALL.to_vec(),
            filter: Filter { engines: vec!["gnurt".into()], modes: Vec::new() },
            size: 32,
            rounds: 2,
            batch: 100,
            threads: 2,
            level: Level::best(),
        };
        let pool = gnurt::thread_pool(2).expect("threads");
        let mut classes = Vec::new();
        let rows = run(&subject, &options, None, &pool, &mut |news| match news {
            News::Class(rows) => classes.push(rows[0].class),
            News::Differs(what) => panic!("our own trees agree: {what}"),
            News::Built(_) => {}
        })
        .expect("it can be measured");
        assert_eq!(classes, Class::ALL, "each class is told");
        assert_eq!(rows.len(), 5 * 9, "each job for each class");
        for row in &rows {
            assert!(row.mrays_cpu > 0.0 && row.min <= row.mrays_cpu && row.mrays_cpu <= row.max, "{row:?}");
            assert_eq!((row.runs, row.threads), (2, 2), "{row:?}");
            assert_eq!(row.sum_t > 0.0, !row.class.is_any_hit(), "t of closest hits only: {row:?}");
        }
        let of = |class| rows.iter().find(|row| row.class == class).expect("it is there");
        assert_eq!(of(Class::Diffuse).hits, of(Class::Shuffled).hits, "the same rays in another order");
    }
}
