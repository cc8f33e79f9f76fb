// SPDX-License-Identifier: GPL-3.0-or-later
//! Rows for people: a table per class, and at the end how our best compares with Embree's. Source: original.
//! Proof: `tests`.

use std::fmt::Write;

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
    let mut text = format!(
        "our best over Embree's best (robust, any); one ray per call over Embree's (robust, any); kd-tree over Embree's best\n  {:<9} {:<16} {:>8} {:<20} {:>8} {:<20} {:>8} {:>8} {:>8} {:>8} {:>8}\n",
        "class", "scene", "gnurt", "", "embree4", "", "/ robust", "/ any", "1 / rob.", "1 / any", "kd / any"
    );
    for class in Class::ALL {
        let of_class: Vec<&Row> = rows.iter().filter(|row| row.class == class).collect();
        let mut scenes: Vec<&str> = Vec::new();
        for row in &of_class {
            if !scenes.contains(&&row.scene[..]) {
                scenes.push(&row.scene);
            }
        }
        let mut columns: [Vec<f64>; 5] = Default::default();
        for scene in &scenes {
            let rows: Vec<Row> =
                of_class.iter().filter(|r| r.scene == *scene).map(|r| (*r).clone()).collect();
            let comparison = Comparison::of(&rows);
            let name = |row: Option<&Row>| row.map_or("-".into(), |row| row.mode.clone());
            let rate = |row: Option<&Row>| row.map_or("-".into(), |row| format!("{:.2}", row.mrays_cpu));
            let _ = write!(
                text,
                "  {:<9} {:<16} {:>8} {:<20} {:>8} {:<20}",
                class.name(),
                scene,
                rate(comparison.own),
                name(comparison.own),
                rate(comparison.embree),
                name(comparison.embree)
            );
            for (column, value) in columns.iter_mut().zip(comparison.ratios) {
                let _ = write!(text, " {:>8}", shown(value));
                column.extend(value);
            }
            text.push('\n');
        }
        if scenes.len() > 1 {
            let _ = write!(text, "  {:<9} {:<75}", class.name(), "geometric mean");
            for column in &columns {
                let is_whole = column.len() == scenes.len();
                let _ = write!(text, " {:>8}", shown(is_whole.then(|| geometric_mean(column))));
            }
            text.push('\n');
        }
    }
    text
}

/// The best of each side, and the ratios that are of interest.
struct Comparison<'a> {
    own: Option<&'a Row>,
    embree: Option<&'a Row>,
    ratios: [Option<f64>; 5],
}

impl<'a> Comparison<'a> {
    fn of(rows: &'a [Row]) -> Self {
        let (own, embree) = (best(rows, is_own), best(rows, is_embree));
        let robust = best(rows, is_robust);
        let one = best(rows, |row| is_own(row) && row.mode.ends_with("-one"));
        let single = |row: &Row| row.mode.ends_with("-1");
        let any_1 = best(rows, |row| is_embree(row) && single(row));
        let robust_1 = best(rows, |row| is_robust(row) && single(row));
        let kd = best(rows, |row| is_own(row) && row.mode.starts_with("kd-"));
        let ratios = [
            quotient(own, robust),
            quotient(own, embree),
            quotient(one, robust_1),
            quotient(one, any_1),
            quotient(kd, embree),
        ];
        Self { own, embree, ratios }
    }
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
            sample(scene, Class::Primary, "gnurt", "kd-medium-coherent", 8.0 * scale),
            sample(scene, Class::Primary, "embree4", "medium-16-coherent", 20.0),
            sample(scene, Class::Primary, "embree4", "robust-1", 5.0),
        ]
    }

    #[test]
    fn ratios_are_to_the_best() {
        let rows = [rows("a", 1.0), rows("b", 4.0)].concat();
        let comparison = Comparison::of(&rows[..4]);
        let expected = [Some(2.0), Some(0.5), Some(2.0), Some(2.0), Some(0.4)];
        assert_eq!(comparison.ratios, expected, "robust, any, single robust, single any, kd-tree");
        let text = summary(&rows);
        let mean = text.lines().find(|line| line.contains("geometric mean")).expect("two scenes have a mean");
        assert!(mean.contains("4.00") && mean.contains("1.00"), "of 2 and 8, of 0.5 and 2: {mean}");
        let table = of_class(&rows[..4]);
        assert_eq!(table.lines().count(), 6, "a title, a head and the rows: {table}");
        assert!(table.contains("2.00") && table.contains("0.50"), "{table}");
    }

    #[test]
    fn without_embree_there_is_no_ratio() {
        let text = summary(&rows("a", 1.0)[..2]);
        assert!(text.lines().any(|line| line.contains("bvh-medium-one") && line.ends_with('-')), "{text}");
    }
}
