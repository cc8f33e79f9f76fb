// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors over samples as curves, as SVG: root of the mean relative squared error, and the error of the picture's mean.
//! Both scales are logarithmic; grey lines fall as one over the root of the samples. Each point is the root
//! of the mean square over seeds. Tests: `tests::curves_of_each_integrator`.

use std::fmt::Write;

use gnurt::render::Integrator;

use crate::light::Point;

/// Units of the picture are pixels.
const SIDE: f64 = 300.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 50.0;
const STEP: f64 = SIDE + 90.0;

/// The plotted value of a point.
type Value = fn(&Point) -> f64;

/// Colours that are distinct for the colour-blind.
fn color(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::InstantRadiosity => "#0072b2",
        Integrator::BidirectionalInstantRadiosity => "#e69f00",
        Integrator::MetropolisInstantRadiosity => "#d55e00",
        _ => "#009e73",
    }
}

/// Root of the mean square over seeds, by samples, up to the shortest run.
fn curve(points: &[Point], integrator: Integrator, value: Value) -> Vec<(f64, f64)> {
    let own: Vec<&Point> =
        points.iter().filter(|p| p.integrator == integrator && p.samples.is_power_of_two()).collect();
    let most = own.iter().filter(|p| p.samples == 1).count();
    let mut samples: Vec<u32> = own.iter().map(|p| p.samples).collect();
    samples.sort_unstable();
    samples.dedup();
    let mean = |n: u32| {
        let of_n: Vec<f64> = own.iter().filter(|p| p.samples == n).map(|p| value(p)).collect();
        let squares = of_n.iter().map(|v| v * v).sum::<f64>() / of_n.len() as f64;
        (of_n.len() == most).then_some((f64::from(n), squares.sqrt()))
    };
    samples.into_iter().filter_map(mean).filter(|(_, v)| *v > 0.0).collect()
}

/// A whole SVG file: two diagrams side by side.
#[must_use]
pub fn svg(scene: &str, points: &[Point]) -> String {
    let mut integrators: Vec<Integrator> = Vec::new();
    points.iter().map(|p| p.integrator).for_each(|i| {
        if !integrators.contains(&i) {
            integrators.push(i);
        }
    });
    let values: [(&str, Value); 2] = [
        ("root of relMSE", |p| p.rel_mse.max(0.0).sqrt()),
        ("error of the picture's mean", |p| p.mean_error),
    ];
    let mut body = String::new();
    // Writing to strings does not fail.
    let _ = writeln!(body, r#"<text x="{LEFT}" y="20" font-weight="bold">{}</text>"#, escaped(scene));
    for (n, integrator) in integrators.iter().enumerate() {
        let (x, color) = (LEFT + 160.0 + 80.0 * n as f64, color(*integrator));
        let _ = writeln!(body, r#"<rect x="{x}" y="9" width="12" height="12" fill="{color}"/>"#);
        let _ = writeln!(body, r#"<text x="{}" y="20">{}</text>"#, x + 17.0, integrator.name());
    }
    for (n, (title, value)) in values.into_iter().enumerate() {
        let curves: Vec<_> = integrators.iter().map(|&i| (i, curve(points, i, value))).collect();
        diagram(&mut body, LEFT + STEP * n as f64, title, &curves);
    }
    let (width, height) = (LEFT + 2.0 * STEP, TOP + SIDE + 50.0);
    format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#ffffff"/>
{body}</svg>
"##
    )
}

fn diagram(body: &mut String, left: f64, title: &str, curves: &[(Integrator, Vec<(f64, f64)>)]) {
    let all = || curves.iter().flat_map(|(_, curve)| curve.iter().copied());
    let last = all().map(|p| p.0).fold(2.0, f64::max).log2();
    let low = all().map(|p| p.1).fold(f64::INFINITY, f64::min).log10().floor();
    let high = all().map(|p| p.1).fold(f64::MIN_POSITIVE, f64::max).log10().ceil().max(low + 1.0);
    if !low.is_finite() {
        return;
    }
    let x = |samples: f64| left + SIDE * samples.log2() / last;
    let y = |value: f64| TOP + SIDE * (high - value.log10().clamp(low, high)) / (high - low);
    let _ = writeln!(body, r#"<text x="{left}" y="{}">{title}</text>"#, TOP - 10.0);
    let _ = writeln!(
        body,
        r##"<rect x="{left}" y="{TOP}" width="{SIDE}" height="{SIDE}" fill="none" stroke="#000000"/>"##
    );
    for power in low as i32..=high as i32 {
        let (value, at) = (10f64.powi(power), y(10f64.powi(power)));
        let (x0, x1) = (left, left + SIDE);
        let _ = writeln!(body, r##"<line x1="{x0}" y1="{at:.1}" x2="{x1}" y2="{at:.1}" stroke="#cccccc"/>"##);
        let _ = writeln!(
            body,
            r#"<text x="{}" y="{:.1}" text-anchor="end">{value}</text>"#,
            left - 5.0,
            at + 4.0
        );
    }
    for n in 0..=last as i32 {
        let (samples, at) = (1_u64 << n, x(2f64.powi(n)));
        let under = TOP + SIDE + 16.0;
        let _ = writeln!(body, r#"<text x="{at:.1}" y="{under}" text-anchor="middle">{samples}</text>"#);
    }
    let under = TOP + SIDE + 34.0;
    let _ = writeln!(
        body,
        r#"<text x="{}" y="{under}" text-anchor="middle">samples per pixel</text>"#,
        left + SIDE / 2.0
    );
    for (integrator, curve) in curves {
        let Some(&(_, first)) = curve.first() else { continue };
        let ideal = (x(1.0), y(first), x(2f64.powf(last)), y(first / 2f64.powf(last / 2.0)));
        let _ = writeln!(
            body,
            r##"<line x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}" stroke="#999999" stroke-dasharray="3"/>"##,
            ideal.0, ideal.1, ideal.2, ideal.3
        );
        let positions: Vec<String> = curve.iter().map(|&(n, v)| format!("{:.1},{:.1}", x(n), y(v))).collect();
        let _ = writeln!(
            body,
            r#"<polyline points="{}" fill="none" stroke="{}" stroke-width="2"/>"#,
            positions.join(" "),
            color(*integrator)
        );
    }
}

/// Text escaped for XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_each_integrator() {
        let mut points = Vec::new();
        for (n, integrator) in [Integrator::InstantRadiosity, Integrator::Path].into_iter().enumerate() {
            for k in 0..4 {
                let samples = 1 << k;
                let rel_mse = 0.01 * (n + 1) as f64 / f64::from(samples);
                let mean_error = 0.1 / f64::from(samples);
                points.push(Point {
                    integrator,
                    seed: 0,
                    samples,
                    seconds: 1.0,
                    rel_mse,
                    mean_error,
                    of_lights: None,
                });
            }
        }
        let text = svg("a<b", &points);
        assert_eq!(text.matches("<polyline").count(), 4, "two curves in two diagrams: {text}");
        assert!(text.contains("a&lt;b") && text.trim_end().ends_with("</svg>"), "{text}");
        // From 0.1 to 0.01 is one decade: the first curve falls by log10(sqrt(8)) of the side.
        let end = TOP + SIDE * 8f64.sqrt().log10();
        let curve = curve(&points, Integrator::InstantRadiosity, |p| p.rel_mse.sqrt());
        assert!((curve[3].1 - 0.1 / 8f64.sqrt()).abs() < 1e-12 && end < TOP + SIDE, "{curve:?}");
    }
}
