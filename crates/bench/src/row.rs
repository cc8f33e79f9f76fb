// SPDX-License-Identifier: GPL-3.0-or-later
//! Measurements, as plain values and as JSON. Units: rates in millions of rays per second. Tests:
//! `tests::json_has_all_fields`.

use serde_json::{Value, json};

use crate::Class;

/// One job's numbers for one class of rays of one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scene.
    pub scene: String,
    /// The class of rays.
    pub class: Class,
    /// `gnurt` or `embree4`.
    pub engine: &'static str,
    /// The built structure and the kind of query.
    pub mode: String,
    /// The instruction set.
    pub isa: &'static str,
    /// Threads.
    pub threads: usize,
    /// Rays.
    pub rays: u64,
    /// How many hit.
    pub hits: u64,
    /// Sum of the hits' `t`, in scene units since directions are of unit length; 0 where any hit would do.
    pub sum_t: f64,
    /// Median rate by processor time: the rate if each thread had a core to itself.
    pub mrays_cpu: f64,
    /// Median rate by the clock on the wall.
    pub mrays_wall: f64,
    /// Least rate by processor time.
    pub min: f64,
    /// Greatest rate by processor time.
    pub max: f64,
    /// Runs.
    pub runs: usize,
    /// Rate of each run by processor time, in the order of the rounds.
    pub rates: Vec<f64>,
}

/// An array of objects.
#[must_use]
pub fn to_json(rows: &[Row]) -> Value {
    rows.iter()
        .map(|row| {
            json!({
                "scene": row.scene,
                "class": row.class.name(),
                "engine": row.engine,
                "mode": row.mode,
                "isa": row.isa,
                "threads": row.threads,
                "rays": row.rays,
                "hits": row.hits,
                "sum_t": row.sum_t,
                "mrays_cpu": row.mrays_cpu,
                "mrays_wall": row.mrays_wall,
                "min": row.min,
                "max": row.max,
                "runs": row.runs,
            })
        })
        .collect()
}

/// The middle value; the mean of two. 0 of none.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[half],
        _ => 0.5 * (sorted[half - 1] + sorted[half]),
    }
}

#[cfg(test)]
pub(crate) fn sample(scene: &str, class: Class, engine: &'static str, mode: &str, mrays_cpu: f64) -> Row {
    Row {
        scene: scene.into(),
        class,
        engine,
        mode: mode.into(),
        isa: "avx2",
        threads: 1,
        rays: 100,
        hits: 90,
        sum_t: 12.5,
        mrays_cpu,
        mrays_wall: mrays_cpu,
        min: mrays_cpu,
        max: mrays_cpu,
        runs: 5,
        rates: vec![mrays_cpu; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_all_fields() {
        let value = to_json(&[sample("box", Class::Ao, "gnurt", "kd-medium-one", 3.5)]);
        let object = value[0].as_object().expect("an object");
        let names = "scene class engine mode isa threads rays hits sum_t mrays_cpu mrays_wall min max runs";
        assert!(names.split(' ').all(|name| object.contains_key(name)), "{value}");
        assert_eq!(object.len(), names.split(' ').count(), "and no other: {value}");
        assert_eq!(value[0]["class"], "ao", "classes by name");
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0, "of three");
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5, "of four");
        assert_eq!(median(&[]), 0.0, "of none");
    }
}
