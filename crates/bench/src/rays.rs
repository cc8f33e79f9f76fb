// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench rays`: rates of ray queries, job by job.
//! Tests: `tests::measures_a_box`, and `tests/program/bench.rs` of the program.

use gnurt::ThreadPool;

use crate::comparison::{Contestant, hold};
pub use crate::event::BenchEvent;
pub use crate::options::Options;
use crate::ray_classes::RayMaker;
use crate::timing::Rays;
use crate::trees::Trees;
use crate::{EmbreeLibrary, Error, Job, Row, Subject};

/// Measures one scene. Trees are built with `pool`; `embree` is the reference, if there is one, and `others`
/// come after it.
///
/// # Errors
/// [`Error::NothingToDo`] without a job, [`Error::Embree`] if the library fails, [`Error::Scene`] without a view, and
/// [`Error::Differ`] if engines disagree.
pub fn run(
    subject: &Subject,
    options: &Options,
    embree: Option<&EmbreeLibrary>,
    others: Vec<Contestant>,
    pool: &ThreadPool,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<Row>, Error> {
    let mut jobs = options.filter.jobs()?;
    jobs.retain(|job| embree.is_some() || matches!(job, Job::Own { .. }));
    let device = embree.map(|library| library.device(options.level, 0)).transpose()?;
    let trees = Trees::build(subject, &jobs, embree.zip(device.as_ref()), pool, report)?;
    let ours = jobs.into_iter().filter_map(|job| trees.contestant(job, options.level));
    let contestants: Vec<Contestant> = ours.chain(others).collect();
    if contestants.is_empty() {
        return Err(Error::NothingToDo { valid: Job::all().iter().map(Job::mode).collect() });
    }
    let maker = RayMaker::new(subject, options.size, trees.reference(), options.level)?;
    let mut rows = Vec::new();
    for &class in &options.classes {
        let rays = Rays::new(maker.rays(class, options.batch), class.is_any_hit(), subject.triangles());
        let first = rows.len();
        rows.extend(hold(&subject.name, class, &rays, &contestants, options, report)?);
        report(BenchEvent::Class(&rows[first..]));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Class, Filter};

    #[test]
    fn measures_a_box() {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        let subject = Subject::new("cornell", &scene);
        let options = Options {
            filter: Filter { engines: vec!["gnurt".into()], modes: Vec::new() },
            size: 32,
            rounds: 2,
            batch: 100,
            threads: 2,
            ..Options::default()
        };
        let pool = gnurt::thread_pool(2).expect("threads");
        let mut classes = Vec::new();
        let rows = run(&subject, &options, None, Vec::new(), &pool, &mut |event| match event {
            BenchEvent::Class(rows) => classes.push(rows[0].class),
            BenchEvent::Differs(what) => panic!("our own trees agree: {what}"),
            BenchEvent::Built(_) => {}
        })
        .expect("it can be measured");
        assert_eq!(classes, Class::ALL, "each class is told");
        assert_eq!(rows.len(), 5 * 12, "each job for each class");
        for row in &rows {
            assert!(row.mrays_cpu > 0.0 && row.min <= row.mrays_cpu && row.mrays_cpu <= row.max, "{row:?}");
            assert_eq!((row.runs, row.threads), (2, 2), "{row:?}");
            assert_eq!(row.sum_t > 0.0, !row.class.is_any_hit(), "t of closest hits only: {row:?}");
        }
        let of = |class| rows.iter().find(|row| row.class == class).expect("it is there");
        assert_eq!(of(Class::Diffuse).hits, of(Class::Shuffled).hits, "the same rays in another order");
    }

    #[test]
    fn without_anybody_there_is_nothing_to_do() {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        let filter = Filter { engines: vec!["embree4".into()], modes: Vec::new() };
        let options = Options { filter, size: 8, ..Options::default() };
        let pool = gnurt::thread_pool(1).expect("a thread");
        let subject = Subject::new("cornell", &scene);
        let refused =
            run(&subject, &options, None, Vec::new(), &pool, &mut |_| {}).expect_err("nobody is there");
        assert!(matches!(refused, Error::NothingToDo { .. }), "{refused}");
    }
}
