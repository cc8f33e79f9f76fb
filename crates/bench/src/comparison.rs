// SPDX-License-Identifier: GPL-3.0-or-later
//! Contestants over one set of rays: first their answers are compared, then they are timed in alternating
//! runs. Runs alternate round by round, so that other load of the machine affects all of them equally. Every
//! round begins with another one, and every other round goes backwards, so that none always follows the same
//! one, which leaves its state in the caches and the clock.
//! Tests: `tests::a_wrong_answer_ends_it`, `tests::the_order_is_rotated`.

use crate::agreement::{Difference, Names, Sums, compare};
use crate::event::BenchEvent;
use crate::options::Options;
use crate::row::median;
use crate::timing::{Engine, Rays, Seconds, answers, time};
use crate::{Class, Error, Row};

/// An engine in a comparison, and its name in reports.
pub struct Contestant<'a> {
    /// The engine's name.
    pub engine: &'static str,
    /// The built structure and the kind of query.
    pub mode: String,
    /// The instruction set.
    pub isa: &'static str,
    /// The engine.
    pub tracer: Box<dyn Engine + 'a>,
}

impl Contestant<'_> {
    fn name(&self) -> String {
        format!("{} {}", self.engine, self.mode)
    }
}

/// Compares, then times. `scene` is for reports.
pub(crate) fn hold(
    scene: &str,
    class: Class,
    rays: &Rays,
    contestants: &[Contestant],
    options: &Options,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<Row>, Error> {
    let sums = check(&format!("{scene} {class}"), rays, contestants, options.tolerance, report)?;
    let mut seconds: Vec<Vec<Seconds>> = vec![Vec::new(); contestants.len()];
    for round in 0..options.rounds {
        for i in order(round, options.rounds, contestants.len()) {
            seconds[i].push(time(&*contestants[i].tracer, rays, options.threads));
        }
    }
    let results = contestants.iter().zip(&sums).zip(&seconds);
    let row = |((contestant, sums), seconds): ((&Contestant, &Sums), &Vec<Seconds>)| {
        let millions = rays.len() as f64 / 1e6;
        // A clock that does not advance between two ticks gives no rate: a nanosecond at least.
        let rates = |of: fn(&Seconds) -> f64| -> Vec<f64> {
            seconds.iter().map(|run| millions / of(run).max(1e-9)).collect()
        };
        let cpu = rates(|seconds| seconds.cpu);
        Row {
            scene: scene.to_owned(),
            class,
            engine: contestant.engine,
            mode: contestant.mode.clone(),
            isa: contestant.isa,
            threads: options.threads,
            rays: rays.len() as u64,
            hits: sums.hits,
            sum_t: sums.sum_t,
            mrays_cpu: median(&cpu),
            mrays_wall: median(&rates(|seconds| seconds.wall_time)),
            min: cpu.iter().copied().fold(f64::INFINITY, f64::min),
            max: cpu.iter().copied().fold(0.0, f64::max),
            runs: seconds.len(),
            rates: cpu,
        }
    };
    Ok(results.map(row).collect())
}

/// The order of a round of `rounds`.
fn order(round: usize, rounds: usize, contestants: usize) -> impl Iterator<Item = usize> {
    let first = round * contestants / rounds;
    (0..contestants).map(move |order_index| {
        let order_index = if round.is_multiple_of(2) { order_index } else { contestants - 1 - order_index };
        (first + order_index) % contestants
    })
}

/// Queries every engine once, and compares the results with the first one's.
pub(crate) fn check(
    what: &str,
    rays: &Rays,
    contestants: &[Contestant],
    tolerance: f64,
    report: &mut dyn FnMut(BenchEvent),
) -> Result<Vec<Sums>, Error> {
    let Some((first, others)) = contestants.split_first() else { return Ok(Vec::new()) };
    let expected = answers(&*first.tracer, rays);
    let mut sums = vec![Sums::of(&expected, rays.any)];
    // The reports, by contestant: several modes often have the same one.
    let mut differences: Vec<(Difference, String)> = Vec::new();
    for contestant in others {
        let answers = answers(&*contestant.tracer, rays);
        sums.push(Sums::of(&answers, rays.any));
        let named = |difference: &Difference, who: &str| {
            let example = rays.get(difference.ray).map(|ray| format!("; for instance {ray:?}"));
            let example = example.unwrap_or_default();
            format!("{what}: {who} against {}: {}{example}", first.name(), difference.what)
        };
        let names = Names { first: first.engine, second: contestant.engine };
        let compared = compare(&expected, &answers, names, rays, tolerance);
        let compared = compared.map_err(|much| Error::Differ(named(&much, &contestant.name())))?;
        let Some(difference) = compared else { continue };
        match differences.iter_mut().find(|(known, _)| *known == difference) {
            Some((_, who)) => *who += &format!(", {}", contestant.mode),
            None => differences.push((difference, contestant.name())),
        }
    }
    for (difference, who) in differences {
        report(BenchEvent::Differs(format!("{what}: {who} against {}: {}", first.name(), difference.what)));
    }
    Ok(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::Answers;
    use gnurt::accel::{Ray, RayBatch, Triangles};

    /// Returns this distance for all rays.
    struct Liar(f32);

    impl Engine for Liar {
        fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
            answers.resize(rays.len());
            answers.hits.t.fill(self.0);
        }
        fn any(&self, rays: &RayBatch, answers: &mut Answers) {
            answers.resize(rays.len());
        }
    }

    #[test]
    fn a_wrong_answer_ends_it() {
        let liar = |mode: &str, t| Contestant {
            engine: "liar",
            mode: mode.into(),
            isa: "-",
            tracer: Box::new(Liar(t)),
        };
        let ray = |i: usize| Ray::new([0.0; 3], [1.0, 0.0, i as f32]);
        let rays = Rays::new(vec![(0..50).map(ray).collect()], false, Triangles::default());
        let options = Options { rounds: 3, ..Options::default() };
        let hold = |liars: &[Contestant]| hold("a", Class::Diffuse, &rays, liars, &options, &mut |_| {});
        let rows = hold(&[liar("a", 1.0), liar("b", 1.0)]).expect("they agree");
        assert_eq!(rows.len(), 2, "a row each");
        assert!(rows.iter().all(|row| row.hits == 50 && row.sum_t == 50.0 && row.runs == 3), "{rows:?}");
        let refused = hold(&[liar("a", 1.0), liar("b", 1.5)]).expect_err("they do not agree").to_string();
        assert!(refused.contains("a diffuse: liar b against liar a"), "{refused}");
        assert!(refused.contains("50 hit elsewhere") && refused.contains("for instance"), "{refused}");
    }

    #[test]
    fn the_order_is_rotated() {
        for (rounds, n) in [(5, 12), (9, 27), (1, 3), (4, 1)] {
            let orders: Vec<Vec<usize>> =
                (0..rounds).map(|round| order(round, rounds, n).collect()).collect();
            for order in &orders {
                let mut sorted = order.clone();
                sorted.sort_unstable();
                assert!(sorted.into_iter().eq(0..n), "everybody has one turn: {order:?}");
            }
            if n > rounds {
                let mut firsts: Vec<usize> = orders.iter().map(|order| order[0]).collect();
                firsts.sort_unstable();
                firsts.dedup();
                assert_eq!(firsts.len(), rounds, "another one begins each round: {orders:?}");
            }
        }
    }
}
