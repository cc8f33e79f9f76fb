// SPDX-License-Identifier: GPL-3.0-or-later
//! Rates as bars: for each class and scene our best mode, Embree's best and its best watertight one, as SVG.
//! Bars of a class share one scale, which starts at zero. Tests: `tests::bars_are_as_long_as_rates`.

use std::fmt::Write;

use crate::table::{best, is_embree, is_own, is_robust};
use crate::{Class, Row};

/// Units of the picture are pixels.
const BAR: f64 = 12.0;
const GAP: f64 = 10.0;
const LEFT: f64 = 110.0;
const LONGEST: f64 = 560.0;
const RIGHT: f64 = 230.0;
const TITLE: f64 = 34.0;

/// The name and filter of a bar, and its colour (of a palette for the colour-blind).
type Side = (&'static str, fn(&Row) -> bool, &'static str);

fn other(row: &Row) -> bool {
    !is_own(row) && !is_embree(row)
}

const SIDES: [Side; 4] = [
    ("gnurt", is_own, "#0072b2"),
    ("embree4 robust", is_robust, "#e69f00"),
    ("embree4", is_embree, "#d55e00"),
    ("others", other, "#999999"),
];

/// A whole SVG file.
#[must_use]
pub fn svg(rows: &[Row]) -> String {
    let mut body = String::new();
    let mut y = 28.0;
    let mut x = LEFT;
    let shown = SIDES.iter().filter(|(_, is_side, _)| rows.iter().any(is_side));
    for (name, _, color) in shown {
        // Writing to a string does not fail.
        let _ = writeln!(body, r#"<rect x="{x}" y="{}" width="12" height="12" fill="{color}"/>"#, y - 11.0);
        let _ = writeln!(body, r#"<text x="{}" y="{y}">{name}</text>"#, x + 17.0);
        x += 150.0;
    }
    for class in Class::ALL {
        let of_class: Vec<Row> = rows.iter().filter(|row| row.class == class).cloned().collect();
        if !of_class.is_empty() {
            y = draw_class(class, &of_class, y + TITLE, &mut body);
        }
    }
    let (width, height) = (LEFT + LONGEST + RIGHT, y + 16.0);
    format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#ffffff"/>
{body}</svg>
"##
    )
}

/// Draws the bars of a class from `y` on; gives where they end.
fn draw_class(class: Class, rows: &[Row], mut y: f64, body: &mut String) -> f64 {
    let greatest = rows.iter().map(|row| row.mrays_cpu).fold(f64::MIN_POSITIVE, f64::max);
    let title = format!("{class}: million rays per second and core");
    let _ = writeln!(body, r#"<text x="{LEFT}" y="{y}" font-weight="bold">{title}</text>"#);
    y += 8.0;
    let mut scenes: Vec<&str> = Vec::new();
    for row in rows {
        if !scenes.contains(&&row.scene[..]) {
            scenes.push(&row.scene);
        }
    }
    for scene in scenes {
        let of_scene: Vec<Row> = rows.iter().filter(|row| row.scene == scene).cloned().collect();
        let label = y + BAR;
        let _ = writeln!(
            body,
            r#"<text x="{}" y="{label}" text-anchor="end">{}</text>"#,
            LEFT - 8.0,
            escaped(scene)
        );
        for (_, is_side, color) in SIDES {
            let Some(row) = best(&of_scene, is_side) else { continue };
            let length = LONGEST * row.mrays_cpu / greatest;
            let _ = writeln!(
                body,
                r#"<rect x="{LEFT}" y="{y:.1}" width="{length:.1}" height="{:.1}" fill="{color}"/>"#,
                BAR - 1.0
            );
            let _ = writeln!(
                body,
                r#"<text x="{:.1}" y="{:.1}" font-size="10">{:.1} {}</text>"#,
                LEFT + length + 5.0,
                y + BAR - 3.0,
                row.mrays_cpu,
                escaped(&row.mode)
            );
            y += BAR;
        }
        y += GAP;
    }
    y
}

/// Text escaped for XML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::sample;

    #[test]
    fn bars_are_as_long_as_rates() {
        let rows = [
            sample("a<b", Class::Ao, "gnurt", "bvh-medium-one", 10.0),
            sample("a<b", Class::Ao, "embree4", "medium-1", 20.0),
            sample("a<b", Class::Ao, "embree4", "robust-1", 5.0),
        ];
        let text = svg(&rows);
        for length in ["280.0", "560.0", "140.0"] {
            assert!(text.contains(&format!(r#"width="{length}""#)), "a bar of {length}: {text}");
        }
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"), "{text}");
        assert!(text.contains("a&lt;b") && !text.contains("a<b"), "names are escaped");
        assert!(!text.contains("others") && !text.contains("shadow"), "nothing that is not there");
    }
}
