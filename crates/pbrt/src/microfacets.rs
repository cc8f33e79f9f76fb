// SPDX-License-Identifier: GPL-3.0-or-later
//! The share of light that GGX facets send on after one bounce. The renderer's facets keep light of more bounces, pbrt's lose it, so
//! lobes are multiplied by this share. Source: [Hei14] (masking and shadowing that know of each other), visible normals after
//! Heitz, Sampling the GGX Distribution of Visible Normals, 2018. Tests: `tests`.

use std::f64::consts::TAU;

/// Steps of the root of the view's cosine and of alpha, both in [0, 1].
pub(crate) const STEPS: usize = 8;
/// Normals along each axis of the square that they are drawn from.
const NORMALS: usize = 24;

/// Smith's function for one direction.
fn hidden(cosine: f64, alpha: f64) -> f64 {
    let square = cosine * cosine;
    0.5 * ((1.0 + alpha * alpha * (1.0 - square) / square).sqrt() - 1.0)
}

/// Normals that a view of this cosine meets, as they are seen.
fn normals(cosine: f64, alpha: f64) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
    let cosine = cosine.clamp(0.02, 1.0);
    let view = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
    let length = (alpha * alpha * view[0] * view[0] + cosine * cosine).sqrt();
    let stretched = [alpha * view[0] / length, 0.0, cosine / length];
    (0..NORMALS * NORMALS).map(move |i| {
        let [u, v] = [i % NORMALS, i / NORMALS].map(|k| (k as f64 + 0.5) / NORMALS as f64);
        let (r, (sin, cos)) = (u.sqrt(), (TAU * v).sin_cos());
        let across = r * cos;
        let half = 0.5 * (1.0 + stretched[2]);
        let along = (1.0 - half) * (1.0 - across * across).max(0.0).sqrt() + half * r * sin;
        let up = (1.0 - across * across - along * along).max(0.0).sqrt();
        // The tangents of the stretched view are y, and the vector square to both.
        let normal = [
            alpha * (up * stretched[0] - along * stretched[2]),
            alpha * across,
            (up * stretched[2] + along * stretched[0]).max(1e-9),
        ];
        let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        (view, normal.map(|x| x / size))
    })
}

/// Shares of the light of a direction that one bounce sends back and through, and that facets mirror before some of it is lost. Metals
/// without an index mirror all; glass has an index, beyond over this side.
fn bounce(cosine: f64, alpha: f64, index: Option<f64>) -> [f64; 3] {
    let ours = hidden(cosine.clamp(0.02, 1.0), alpha);
    let shown = |z: f64| (1.0 + ours) / (1.0 + ours + hidden(z.abs().clamp(1e-6, 1.0), alpha));
    let mut sums = [0.0; 3];
    for (view, normal) in normals(cosine, alpha) {
        let met: f64 = (0..3).map(|k| view[k] * normal[k]).sum();
        let mirrored = 2.0 * met * normal[2] - view[2];
        let back = if mirrored > 0.0 { shown(mirrored) } else { 0.0 };
        let Some(index) = index else {
            sums = [sums[0] + back, 0.0, sums[2] + 1.0];
            continue;
        };
        let sine = (1.0 - met * met) / (index * index);
        let beyond = (1.0 - sine).max(0.0).sqrt();
        let a = (index * met - beyond) / (index * met + beyond);
        let b = (met - index * beyond) / (met + index * beyond);
        let share = if sine >= 1.0 { 1.0 } else { 0.5 * (a * a + b * b) };
        let through = (met / index - beyond) * normal[2] - view[2] / index;
        let on = if through < 0.0 && share < 1.0 { shown(through) } else { 0.0 };
        sums = [sums[0] + share * back, sums[1] + (1.0 - share) * on, sums[2] + share];
    }
    sums.map(|sum| sum / (NORMALS * NORMALS) as f64)
}

/// Share of the light of a direction that one bounce sends on.
pub(crate) fn retained(cosine: f64, alpha: f64, index: Option<f64>) -> f64 {
    let [back, through, _] = bounce(cosine, alpha, index);
    back + through
}

/// Shares of light at a coat of glass above a base, by the root of the view's cosine in steps.
pub(crate) struct Coated {
    /// Share of the light mirrored by the coat that is not lost.
    pub(crate) mirrored: Vec<f32>,
    /// Share of the light of the base that comes out at once, with the loss on the way in.
    pub(crate) out: Vec<f32>,
    /// Share that goes back to the base.
    pub(crate) again: Vec<f32>,
}

/// The same for facets of the coat and of the base; `None` is a diffuse base.
pub(crate) fn coated(alpha: f64, index: f64, base: Option<f64>) -> Coated {
    const FINE: usize = 32;
    // From within, by the cosine.
    let within: Vec<[f64; 3]> =
        (0..=FINE).map(|i| bounce(i as f64 / FINE as f64, alpha, Some(1.0 / index))).collect();
    let reflected = |cosine: f64| {
        let at = cosine.clamp(0.0, 1.0) * FINE as f64;
        let i = (at as usize).min(FINE - 1);
        let rest = at - i as f64;
        [0, 1].map(|k| within[i][k] * (1.0 - rest) + within[i + 1][k] * rest)
    };
    let mut table = Coated { mirrored: Vec::new(), out: Vec::new(), again: Vec::new() };
    for i in 0..=STEPS {
        let cosine = ((i as f64 / STEPS as f64).powi(2)).max(0.02);
        let [back, through, mirrored] = bounce(cosine, alpha, Some(index));
        let [mut again, mut out, mut count] = [0.0; 3];
        match base {
            None => (0..FINE).for_each(|i| {
                let cosine = (i as f64 + 0.5) / FINE as f64;
                let [back, through] = reflected(cosine);
                (again, out, count) = (again + cosine * back, out + cosine * through, count + cosine);
            }),
            Some(base) => {
                let below = (1.0 - (1.0 - cosine * cosine) / (index * index)).max(0.0).sqrt();
                for (view, normal) in normals(below, base.max(1e-3)) {
                    let met: f64 = (0..3).map(|k| view[k] * normal[k]).sum();
                    let up = 2.0 * met * normal[2] - view[2];
                    if up > 0.0 {
                        let [back, through] = reflected(up);
                        (again, out, count) = (again + back, out + through, count + 1.0);
                    }
                }
            }
        }
        let count = if count > 0.0 { count } else { 1.0 };
        table.mirrored.push((back / mirrored.max(1e-6)) as f32);
        table.out.push((through / (1.0 - mirrored).max(1e-3) * out / count) as f32);
        table.again.push((again / count) as f32);
    }
    table
}

/// The shares by the root of the cosine: of one alpha, or of all in steps, one row after the other.
pub(crate) fn table(alpha: Option<f32>, index: Option<f64>) -> Vec<f32> {
    let row = |alpha: f64| {
        let of = move |i: usize| retained((i as f64 / STEPS as f64).powi(2), alpha.max(1e-3), index) as f32;
        (0..=STEPS).map(of)
    };
    match alpha {
        Some(alpha) => row(f64::from(alpha)).collect(),
        None => (0..=STEPS).flat_map(|i| row(i as f64 / STEPS as f64)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_facets_lose_nothing() {
        for index in [None, Some(1.5), Some(1.0 / 1.5)] {
            let kept = retained(0.7, 0.01, index);
            assert!((kept - 1.0).abs() < 5e-3, "{index:?}: {kept}");
        }
        let [smooth, rough] = [0.3, 0.9].map(|alpha| retained(0.7, alpha, None));
        assert!(smooth > 0.8 && rough < 0.6 && rough > 0.3, "{smooth} {rough}");
        // Glass loses more from within: it mirrors more there.
        assert!(retained(0.7, 0.3, Some(1.0 / 1.5)) < retained(0.7, 0.3, Some(1.5)));
        // A smooth coat on a diffuse base: 1 - Fi comes out, Fi goes back.
        let smooth = coated(0.01, 1.5, None);
        assert!(
            (smooth.out[8] - 0.4037).abs() < 0.02 && (smooth.again[8] - 0.5963).abs() < 0.02,
            "{:?}",
            smooth.out
        );
    }
}
