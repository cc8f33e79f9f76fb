// SPDX-License-Identifier: GPL-3.0-or-later
//! FLIP: differences as people see them who flip between two pictures on a screen.
//! Source: \[ANA*20\], LDR-FLIP for 67 pixels per degree (a screen of 0.7 m and 3840 pixels, 0.7 m away).
//! Colours are filtered by the eye's contrast sensitivity and compared in a space of equal steps; edges and
//! points that only one picture has add to that. In: linear light, cut to 0..1 as a screen does. Out: 0 = none
//! to 1 for each pixel. Invariant: symmetric. Tests: `tests`, with values of the authors' program.

use crate::chromaticities::REC709;
use crate::{Error, Picture};

/// Pixels per degree of the field of view.
const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (std::f64::consts::PI / 180.0);
/// Powers of the differences of colours and of features.
const COLOR_POWER: f64 = 0.7;
const FEATURE_POWER: f64 = 0.5;
/// The share of the largest difference below which differences take most of the range, and that part.
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;
/// Width of an edge, degrees.
const EDGE: f64 = 0.082;

/// Three numbers for each pixel.
type Colors = Vec<[f64; 3]>;

/// The difference of each pixel of two pictures of one size, in rows from the top.
///
/// # Errors
/// [`Error::SizesDiffer`], or [`Error::Shape`] for a picture whose parts do not fit.
pub fn flip(a: &Picture, b: &Picture) -> Result<Vec<f32>, Error> {
    a.check()?;
    b.check()?;
    let sizes = [[a.width, a.height], [b.width, b.height]];
    if sizes[0] != sizes[1] {
        return Err(Error::SizesDiffer { a: sizes[0], b: sizes[1] });
    }
    let size = sizes[0].map(|n| n as usize);
    let space = Space::new();
    let [a, b] = [a, b].map(|picture| {
        let opponent: Colors = picture.on_screen().map(|c| space.opponent(screen(c))).collect();
        let features = features(&opponent, size);
        (filtered(&opponent, size, &space), features)
    });
    let all = a.0.iter().zip(&b.0).zip(a.1.iter().zip(&b.1));
    let largest = space.largest();
    Ok(all.map(|((a, b), (f, g))| difference(*a, *b, *f, *g, largest) as f32).collect())
}

/// Over black, within the range of a screen; NaN is black.
fn screen([r, g, b, a]: [f32; 4]) -> [f64; 3] {
    // `max` answers the number where the other side is NaN.
    [r, g, b].map(|x| f64::from(x * a).max(0.0)).map(|x| x.min(1.0))
}

fn difference(a: [f64; 3], b: [f64; 3], f: [f64; 2], g: [f64; 2], largest: f64) -> f64 {
    let color = steps(a, b).powf(COLOR_POWER);
    let knee = KNEE * largest;
    let color = match color < knee {
        true => color * KNEE_VALUE / knee,
        false => KNEE_VALUE + (color - knee) / (largest - knee) * (1.0 - KNEE_VALUE),
    };
    let feature = (f[0] - g[0]).abs().max((f[1] - g[1]).abs());
    let feature = (feature * std::f64::consts::FRAC_1_SQRT_2).powf(FEATURE_POWER);
    color.powf(1.0 - feature)
}

/// The distance of colours in a space of equal steps: of lightness and of chroma, added.
fn steps(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Conversions from linear colours.
struct Space {
    xyz: [[f64; 3]; 3],
    rgb: [[f64; 3]; 3],
    white: [f64; 3],
}

impl Space {
    fn new() -> Self {
        let (xyz, rgb) = REC709.xyz_and_back().expect("the primaries of Rec. 709 span a space");
        Self { xyz, rgb, white: xyz.map(|row| row.iter().sum()) }
    }

    /// Luminance and two opponent colours (YCxCz), linear.
    fn opponent(&self, rgb: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.relative(rgb);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// The linear colour of them, within the range of a screen.
    fn of_opponent(&self, [y, cx, cz]: [f64; 3]) -> [f64; 3] {
        let y = (y + 16.0) / 116.0;
        let relative = [y + cx / 500.0, y, y - cz / 200.0];
        let xyz = [0, 1, 2].map(|k| relative[k] * self.white[k]);
        times(&self.rgb, xyz).map(|x| x.clamp(0.0, 1.0))
    }

    /// CIELAB with Hunt's effect: colours of little light have little chroma.
    fn lab(&self, rgb: [f64; 3]) -> [f64; 3] {
        let root = |t: f64| {
            let delta: f64 = 6.0 / 29.0;
            if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
        };
        let [x, y, z] = self.relative(rgb).map(root);
        let lightness = 116.0 * y - 16.0;
        let hunt = 0.01 * lightness;
        [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
    }

    fn relative(&self, rgb: [f64; 3]) -> [f64; 3] {
        let xyz = times(&self.xyz, rgb);
        [0, 1, 2].map(|k| xyz[k] / self.white[k])
    }

    /// The largest difference of colours: from green to blue.
    fn largest(&self) -> f64 {
        steps(self.lab([0.0, 1.0, 0.0]), self.lab([0.0, 0.0, 1.0])).powf(COLOR_POWER)
    }
}

fn times(rows: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The colours as the eye resolves them, in CIELAB.
fn filtered(opponent: &[[f64; 3]], size: [usize; 2], space: &Space) -> Colors {
    /// Sums of Gaussians for luminance, red-green and blue-yellow: heights and widths.
    const EYE: [[[f64; 2]; 2]; 3] =
        [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
    let pi = std::f64::consts::PI;
    let radius = (3.0 * (0.04 / (2.0 * pi * pi)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
    let mut out = vec![[0.0; 3]; opponent.len()];
    for (channel, gaussians) in EYE.iter().enumerate() {
        let plane: Vec<f64> = opponent.iter().map(|color| color[channel]).collect();
        let kernel = |width: f64| -> Vec<f64> {
            let at = |k: i64| (-(pi * k as f64 / PIXELS_PER_DEGREE).powi(2) / width).exp();
            (-radius..=radius).map(at).collect()
        };
        let used = gaussians.iter().filter(|[height, _]| *height > 0.0);
        let parts: Vec<(f64, Vec<f64>)> = used
            .map(|&[height, width]| {
                let kernel = kernel(width);
                let sum: f64 = kernel.iter().sum();
                let normal = kernel.into_iter().map(|x| x / sum).collect();
                (height * (pi / width).sqrt() * sum * sum, normal)
            })
            .collect();
        let total: f64 = parts.iter().map(|(weight, _)| weight).sum();
        for (weight, kernel) in parts {
            let blurred = convolved(&plane, size, &kernel, &kernel);
            out.iter_mut().zip(blurred).for_each(|(to, value)| to[channel] += weight / total * value);
        }
    }
    out.into_iter().map(|color| space.lab(space.of_opponent(color))).collect()
}

/// How much of an edge and of a point each pixel is.
fn features(opponent: &[[f64; 3]], size: [usize; 2]) -> Vec<[f64; 2]> {
    let lightness: Vec<f64> = opponent.iter().map(|color| (color[0] + 16.0) / 116.0).collect();
    let deviation = 0.5 * EDGE * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i64;
    let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let kernel = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let values: Vec<f64> = (-radius..=radius).map(|x| of(x as f64)).collect();
        // Positive values sum up to 1, negative ones to -1.
        let sum = |sign: f64| values.iter().map(|x| (sign * x).max(0.0)).sum::<f64>();
        let (above, below) = (sum(1.0), sum(-1.0));
        values
            .iter()
            .map(|&x| {
                if x > 0.0 {
                    x / above
                } else if x < 0.0 {
                    x / below
                } else {
                    0.0
                }
            })
            .collect()
    };
    let smooth = kernel(&gaussian);
    let edge = kernel(&|x| -x * gaussian(x));
    let point = kernel(&|x| (x * x / (deviation * deviation) - 1.0) * gaussian(x));
    let length = |kernel: &[f64]| -> Vec<f64> {
        let across = convolved(&lightness, size, kernel, &smooth);
        let down = convolved(&lightness, size, &smooth, kernel);
        across.into_iter().zip(down).map(|(x, y)| x.hypot(y)).collect()
    };
    length(&edge).into_iter().zip(length(&point)).map(|(edge, point)| [edge, point]).collect()
}

/// A plane convolved with a kernel along its rows and another along its columns; edges go on.
fn convolved(plane: &[f64], [width, height]: [usize; 2], across: &[f64], down: &[f64]) -> Vec<f64> {
    let clamped =
        |at: usize, k: usize, radius: usize, count: usize| (at + k).saturating_sub(radius).min(count - 1);
    let mut rows = vec![0.0; plane.len()];
    let radius = across.len() / 2;
    for (from, to) in plane.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        for (x, to) in to.iter_mut().enumerate() {
            *to = across.iter().enumerate().map(|(k, w)| w * from[clamped(x, k, radius, width)]).sum();
        }
    }
    let mut out = vec![0.0; plane.len()];
    let radius = down.len() / 2;
    for (y, to) in out.chunks_exact_mut(width).enumerate() {
        for (k, weight) in down.iter().enumerate() {
            let from = &rows[clamped(y, k, radius, height) * width..][..width];
            to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 48];

    fn pair() -> [Picture; 2] {
        let [w, h] = SIZE;
        let mut a = Picture::new(w, h);
        for (i, pixel) in a.color.iter_mut().enumerate() {
            let (x, y) = (i as u32 % w, i as u32 / w);
            let [r, g, b] =
                [x as f32 / (w - 1) as f32, y as f32 / (h - 1) as f32, ((x + y) % 16) as f32 / 15.0];
            *pixel = [r, g, b, 1.0];
        }
        let mut b = a.clone();
        for (i, pixel) in b.color.iter_mut().enumerate() {
            let (x, y) = (i as u32 % w, i as u32 / w);
            if (10..20).contains(&x) && (10..20).contains(&y) {
                *pixel = [0.9, 0.1, 0.1, 1.0];
            }
            if y == 30 {
                (0..3).for_each(|k| pixel[k] *= 0.5);
            }
            if x >= 50 {
                pixel[2] = (pixel[2] + 0.2).min(1.0);
            }
        }
        [a, b]
    }

    /// Values of the authors' program (flip-evaluator 1.7) for the same pictures.
    #[test]
    fn values_are_those_of_the_authors() {
        let [a, b] = pair();
        let map = flip(&a, &b).expect("pictures of one size");
        let mean = map.iter().map(|&x| f64::from(x)).sum::<f64>() / map.len() as f64;
        assert!((mean - 0.153_562).abs() < 2e-4, "mean {mean}");
        let expected = [
            ([15, 15], 0.86383),
            ([9, 9], 0.26171),
            ([30, 30], 0.30495),
            ([55, 5], 0.28096),
            ([63, 47], 0.29774),
        ];
        for ([x, y], expected) in expected {
            let found = map[y * SIZE[0] as usize + x];
            assert!((found - expected).abs() < 1e-3, "pixel {x}, {y}: {found}, {expected}");
        }
        assert_eq!(flip(&b, &a).expect("pictures of one size"), map, "symmetric");
        assert_eq!(flip(&a, &a).expect("one picture"), vec![0.0; map.len()], "no difference");
        assert!(flip(&a, &Picture::new(3, 3)).is_err(), "sizes differ");
    }
}
