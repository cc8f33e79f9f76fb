// SPDX-License-Identifier: GPL-3.0-or-later
//! Measurements of moving scenes as bars: for each scene and case the processor time of an update, and the
//! rate of rays afterwards, strategy by strategy, as SVG. Bars of a case share one scale on either side,
//! which starts at zero.
//! Tests: `tests::bars_are_as_long_as_numbers`.

use std::fmt::Write;

use crate::dynamic_row::DynamicRow;
use crate::plot::escaped;

/// Units of the picture are pixels.
const BAR: f64 = 12.0;
const LEFT: f64 = 190.0;
const LONGEST: f64 = 240.0;
const LABEL: f64 = 90.0;
const TITLE: f64 = 30.0;

/// Ours and theirs, in colours that are distinct for the colour-blind.
const COLORS: [&str; 2] = ["#0072b2", "#d55e00"];

/// A number of each row: its title, itself, and how it is written.
type Side = (&'static str, fn(&DynamicRow) -> f64, usize);

const SIDES: [Side; 2] = [
    ("milliseconds of an update", |row| row.update_ms_cpu, 2),
    ("million rays per second", |row| row.trace_mrays_cpu, 2),
];

/// A whole SVG file.
#[must_use]
pub fn svg(rows: &[DynamicRow]) -> String {
    let mut body = String::new();
    let mut y = 0.0;
    for of_case in rows.chunk_by(|a, b| (&a.scene, a.case) == (&b.scene, b.case)) {
        y = draw(of_case, y + TITLE, &mut body);
    }
    let (width, height) = (LEFT + 2.0 * (LONGEST + LABEL), y + 16.0);
    format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#ffffff"/>
{body}</svg>
"##
    )
}

/// Draws the rows of a case from `y` on; gives where they end.
fn draw(rows: &[DynamicRow], mut y: f64, body: &mut String) -> f64 {
    let left = |side: usize| LEFT + side as f64 * (LONGEST + LABEL);
    let (case, scene) = (rows[0].case, escaped(&rows[0].scene));
    // Writing to a string does not fail.
    let _ = writeln!(body, r#"<text x="8" y="{y}" font-weight="bold">{case}: {scene}</text>"#);
    for (side, (title, ..)) in SIDES.iter().enumerate() {
        let _ = writeln!(body, r#"<text x="{}" y="{y}" font-weight="bold">{title}</text>"#, left(side));
    }
    y += 8.0;
    for row in rows {
        let threads = if row.threads == 1 { String::new() } else { format!(", {} threads", row.threads) };
        let name = format!("{} {}{threads}", row.engine, row.strategy);
        let label = y + BAR - 3.0;
        let at = LEFT - 8.0;
        let _ = writeln!(body, r#"<text x="{at}" y="{label}" text-anchor="end">{}</text>"#, escaped(&name));
        let color = COLORS[usize::from(row.engine != "gnurt")];
        for (side, (_, number, digits)) in SIDES.iter().enumerate() {
            let greatest = rows.iter().map(number).fold(f64::MIN_POSITIVE, f64::max);
            let (x, length) = (left(side), LONGEST * number(row) / greatest);
            let height = BAR - 1.0;
            let _ = writeln!(
                body,
                r#"<rect x="{x}" y="{y:.1}" width="{length:.1}" height="{height:.1}" fill="{color}"/>"#
            );
            let (x, number) = (x + length + 5.0, number(row));
            let _ =
                writeln!(body, r#"<text x="{x:.1}" y="{label:.1}" font-size="10">{number:.digits$}</text>"#);
        }
        y += BAR;
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &'static str, update_ms_cpu: f64, trace_mrays_cpu: f64) -> DynamicRow {
        DynamicRow {
            case: "refit",
            scene: "a<b".into(),
            strategy: "auto",
            engine,
            threads: 1,
            triangles: 1,
            instances: 1,
            update_ms_cpu,
            trace_mrays_cpu,
            bytes: None,
            hits: 1,
            rebuilds: 0,
        }
    }

    #[test]
    fn bars_are_as_long_as_numbers() {
        let rows = [row("gnurt", 5.0, 4.0), DynamicRow { threads: 2, ..row("embree4", 10.0, 1.0) }];
        let text = svg(&rows);
        for length in ["240.0", "120.0", "60.0"] {
            assert!(text.contains(&format!(r#"width="{length}""#)), "a bar of {length}: {text}");
        }
        assert!(text.contains("embree4 auto, 2 threads"), "{text}");
        assert!(text.contains("a&lt;b") && !text.contains("a<b"), "names are escaped");
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"), "{text}");
        assert!(svg(&[]).starts_with("<svg"), "nothing is a picture, too");
    }
}
