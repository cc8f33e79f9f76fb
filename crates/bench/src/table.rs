// SPDX-License-Identifier: GPL-3.0-or-later
//! Rows for people: a table per class, and at the end how our best compares with Embree's.
//! Tests: `tests`.

use std::fmt::Write;

use crate::pools::{ANY, POOLS};
use crate::{Class, Row};

/// Rows of one class of one scene.
#[must_use]
pub fn of_class(rows: &[Row]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let mut text = format!(
        "{} {}: {} rays, {:.1} % hit; {}, threads: {}, median of {}\n",
        first.scene,
        first.class,
        first.rays,
        100.0 * first.hits as f64 / (first.rays.max(1)) as f64,
        first.isa,
        first.threads,
        first.runs
    );
    let [any, robust] = [best(rows, is_embree), best(rows, is_robust)];
    let _ = writeln!(
        text,
        "  {:<8} {:<22} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9}",
        "engine", "mode", "Mrays/s", "min", "max", "wall", "/ robust", "/ any"
    );
    for row in rows {
        let _ = writeln!(
            text,
            "  {:<8} {:<22} {:>8.2} {:>8.2} {:>8.2} {:>8.2} {:>9} {:>9}",
            row.engine,
            row.mode,
            row.mrays_cpu,
            row.min,
            row.max,
            row.mrays_wall,
            ratio(Some(row), robust),
            ratio(Some(row), any)
        );
    }
    text
}

/// How we compare, class by class and scene by scene, with geometric means over the scenes.
#[must_use]
pub fn summary(rows: &[Row]) -> String {
    let mut text = String::from(
        "our best over Embree's best, of equally many modes each: trees of one quality (medium over robust, which is medium and \
         watertight as ours are), any over any; one ray per call (1:); kd-trees\n",
    );
    let _ = write!(
        text,
        "  {:<9} {:<16} {:>8} {:<20} {:>8} {:<20}",
        "class", "scene", "gnurt", "", "embree4", ""
    );
    POOLS.iter().for_each(|pool| text += &format!(" {:>9}", pool.name));
    text.push('\n');
    for class in Class::ALL {
        let of_class: Vec<&Row> = rows.iter().filter(|row| row.class == class).collect();
        let mut scenes: Vec<&str> = Vec::new();
        for row in &of_class {
            if !scenes.contains(&&row.scene[..]) {
                scenes.push(&row.scene);
            }
        }
        let mut columns: [Vec<f64>; POOLS.len()] = Default::default();
        for scene in &scenes {
            let rows: Vec<Row> =
                of_class.iter().filter(|r| r.scene == *scene).map(|r| (*r).clone()).collect();
            let [own, embree] = match ANY.of(&rows).winners() {
                Some(winners) => winners.map(Some),
                None => [best(&rows, is_own), best(&rows, is_embree)],
            };
            let name = |row: Option<&Row>| row.map_or("-".into(), |row| row.mode.clone());
            let rate = |row: Option<&Row>| row.map_or("-".into(), |row| format!("{:.2}", row.mrays_cpu));
            let _ = write!(
                text,
                "  {:<9} {:<16} {:>8} {:<20} {:>8} {:<20}",
                class.name(),
                scene,
                rate(own),
                name(own),
                rate(embree),
                name(embree)
            );
            for (column, pool) in columns.iter_mut().zip(POOLS) {
                let value = pool.of(&rows).ratio();
                let _ = write!(text, " {:>9}", shown(value));
                column.extend(value);
            }
            text.push('\n');
        }
        if scenes.len() > 1 {
            let _ = write!(text, "  {:<9} {:<75}", class.name(), "geometric mean");
            for column in &columns {
                let is_whole = column.len() == scenes.len();
                let _ = write!(text, " {:>9}", shown(is_whole.then(|| geometric_mean(column))));
            }
            text.push('\n');
        }
    }
    text
}

pub(crate) fn is_own(row: &Row) -> bool {
    row.engine == "gnurt"
}

pub(crate) fn is_embree(row: &Row) -> bool {
    row.engine == "embree4"
}

pub(crate) fn is_robust(row: &Row) -> bool {
    is_embree(row) && row.mode.starts_with("robust")
}

pub(crate) fn best(rows: &[Row], wanted: impl Fn(&Row) -> bool) -> Option<&Row> {
    rows.iter().filter(|row| wanted(row)).max_by(|a, b| a.mrays_cpu.total_cmp(&b.mrays_cpu))
}

fn quotient(row: Option<&Row>, other: Option<&Row>) -> Option<f64> {
    row.zip(other).map(|(row, other)| row.mrays_cpu / other.mrays_cpu)
}

fn ratio(row: Option<&Row>, other: Option<&Row>) -> String {
    shown(quotient(row, other))
}

fn shown(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.2}"))
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len().max(1) as f64).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::sample;

    fn rows(scene: &str, scale: f64) -> Vec<Row> {
        vec![
            sample(scene, Class::Primary, "gnurt", "bvh-medium-one", 10.0 * scale),
            sample(scene, Class::Primary, "gnurt", "bvh-medium-coherent", 8.0 * scale),
            sample(scene, Class::Primary, "embree4", "medium-16-coherent", 20.0),
            sample(scene, Class::Primary, "embree4", "medium-1", 12.0),
            sample(scene, Class::Primary, "embree4", "robust-1", 5.0),
        ]
    }

    #[test]
    fn ratios_are_those_of_the_pools() {
        let rows = [rows("a", 1.0), rows("b", 4.0)].concat();
        let text = summary(&rows);
        let mean = text.lines().find(|line| line.contains("geometric mean")).expect("two scenes have a mean");
        let words: Vec<&str> = mean.split_whitespace().skip(3).collect();
        // Medium over robust: one mode each, the coherent one of ours; then two each; a call per ray.
        assert_eq!(words, ["3.20", "1.00", "-", "1.00", "4.00", "1.67", "-"], "{text}");
        let table = of_class(&rows[..5]);
        assert_eq!(table.lines().count(), 7, "a title, a head and the rows: {table}");
        assert!(table.contains("2.00") && table.contains("0.50"), "{table}");
    }

    #[test]
    fn without_embree_there_is_no_ratio() {
        let text = summary(&rows("a", 1.0)[..2]);
        assert!(text.lines().any(|line| line.contains("bvh-medium-one") && line.ends_with('-')), "{text}");
    }
}
