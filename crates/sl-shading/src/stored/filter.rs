// SPDX-License-Identifier: GPL-3.0-or-later
//! The footprint of a lookup: the ellipse that a pixel covers, by probes along its longer axis in the two
//! levels where the shorter one is about a texel wide; of panoramas, by angles. Levels, probes and their
//! weights are those of OpenImageIO's texture system. Ellipses: Greene and Heckbert, Creating Raster Omnimax
//! Images from Multiple Perspective Views Using the Elliptical Weighted Average Filter (1986); probes along
//! the axis: Mavridis and Papaioannou, High Quality Elliptical Texture Filtering on GPU (2011).

use std::f32::consts::{FRAC_PI_2, PI};

use gnurt_image::Stored;
use gnurt_sl::exec::{TextureOptions, longitude_latitude};
use gnurt_sl_lib::Dual;

use super::sample::{Interpolation, Read, ReadOptions, read};
use crate::wrap::Wrap;

/// Probes along the longer axis, over the length of the shorter one.
const MOST_ANISOTROPIC: f32 = 32.0;
/// Pixels are at least so wide.
const NARROWEST: f32 = 1e-8;

/// An ellipse: its axes' lengths, and the angle of the longer one.
#[derive(Clone, Copy, Debug)]
struct Ellipse {
    major: f32,
    minor: f32,
    theta: f32,
}

impl Ellipse {
    /// Of the changes of (s, t) to the right and downwards.
    fn new([[sx, tx], [sy, ty]]: [[f32; 2]; 2]) -> Self {
        let a = f64::from(tx * tx + ty * ty);
        let b = -2.0 * f64::from(sx * tx + sy * ty);
        let c = f64::from(sx * sx + sy * sy);
        let root = (a - c).hypot(b);
        let length = |square: f64| (square.max(0.0) as f32).sqrt().min(1000.0);
        let theta = (b.atan2(a - c) * 0.5) as f32 + FRAC_PI_2;
        Self { major: length((a + c + root) * 0.5), minor: length((a + c - root) * 0.5), theta }
    }

    fn blurred(self, [s, t]: [f32; 2]) -> Self {
        if s + t == 0.0 {
            return self;
        }
        let (sin, cos) = self.theta.sin_cos();
        let along = (s * s * cos * cos + t * t * sin * sin).sqrt();
        let across = (s * s * sin * sin + t * t * cos * cos).sqrt();
        let (major, minor) = (self.major + along, self.minor + across);
        if minor > major {
            return Self { major: minor, minor: major, theta: self.theta + FRAC_PI_2 };
        }
        Self { major, minor, ..self }
    }

    /// How much longer than wide, once it is no longer than it may be.
    fn limit(&mut self) -> f32 {
        let aspect = (self.major / self.minor).clamp(1.0, 1e6);
        if aspect <= MOST_ANISOTROPIC {
            return aspect;
        }
        // Some too blurred across, some too coarse along.
        self.major = 0.5 * (self.major + self.minor * MOST_ANISOTROPIC);
        self.minor = self.major / MOST_ANISOTROPIC;
        MOST_ANISOTROPIC
    }
}

/// Changes that are not nothing.
fn widened([mut x, mut y]: [[f32; 2]; 2], width: [f32; 2]) -> [[f32; 2]; 2] {
    for change in [&mut x, &mut y] {
        *change = [change[0] * width[0], change[1] * width[1]];
    }
    let square = |v: [f32; 2]| v[0] * v[0] + v[1] * v[1];
    let least = NARROWEST * NARROWEST;
    // One of no length becomes a short one across the other.
    let across = |v: [f32; 2], sign: f32| {
        let scale = NARROWEST / square(v).sqrt();
        [sign * v[1] * scale, -sign * v[0] * scale]
    };
    match (square(x) < least, square(y) < least) {
        (true, true) => [[NARROWEST, 0.0], [0.0, NARROWEST]],
        (true, false) => [across(y, 1.0), y],
        (false, true) => [x, across(x, -1.0)],
        (false, false) => [x, y],
    }
}

/// Two levels and the share of the second, where `rows` texels of level `m` are one shorter side wide. None: the finest is too coarse.
fn levels(count: usize, texels: impl Fn(usize) -> f32) -> Option<[(usize, f32); 2]> {
    for m in 0..count {
        let width = texels(m);
        if width <= 1.0 {
            let share = (2.0 * width - 1.0).clamp(0.0, 1.0);
            return m.checked_sub(1).map(|finer| [(finer, 1.0 - share), (m, share)]);
        }
    }
    Some([(count - 1, 1.0), (count - 1, 0.0)])
}

fn interpolation_of(options: &TextureOptions, is_coarse: bool) -> Interpolation {
    match &*options.interpolation {
        "closest" => Interpolation::Closest,
        "linear" => Interpolation::Linear,
        "cubic" | "bicubic" => Interpolation::Cubic,
        _ if is_coarse => Interpolation::Cubic,
        _ => Interpolation::Linear,
    }
}

fn gather(out: &mut Read, found: Read, weight: f32) {
    for (out, found) in out.iter_mut().zip(found) {
        for (out, found) in out.iter_mut().zip(found) {
            *out += weight * found;
        }
    }
}

/// The picture at (s, t) over the ellipse of these changes.
pub(super) fn over_ellipse(
    file: &Stored,
    [s, t]: [f32; 2],
    changes: [[f32; 2]; 2],
    options: &TextureOptions,
    (wrap, first): ([Wrap; 2], usize),
) -> Read {
    let read_options = ReadOptions { wrap, first, channels: options.channels, fill: options.fill };
    // Texels that a picture of the pixels' own density would have.
    let natural = [0, 1]
        .map(|k: usize| (1.0 / changes[0][k].abs().max(changes[1][k].abs()).max(NARROWEST)) as usize / 2);
    let mut ellipse = Ellipse::new(widened(changes, options.width)).blurred(options.blur);
    let mut aspect = ellipse.limit();
    let side = |m: usize| file.levels[m].width.min(file.levels[m].height) as f32;
    let chosen = levels(file.levels.len(), |m| ellipse.minor * side(m)).unwrap_or_else(|| {
        // Probes nearer than half a texel give no information.
        let most = file.levels[0].width.max(file.levels[0].height) as f32;
        if ellipse.minor * most < 0.5 {
            aspect = (ellipse.major * most * 2.0).clamp(1.0, MOST_ANISOTROPIC);
        }
        [(0, 1.0), (0, 0.0)]
    });
    let mut out = Read::default();
    let probes = probes(ellipse, aspect);
    for (m, share) in chosen {
        if share == 0.0 {
            continue;
        }
        let level = &file.levels[m];
        let is_coarse = m == 0 || level.width < natural[0] || level.height < natural[1];
        let interpolation_of = interpolation_of(options, is_coarse);
        for &([ds, dt], weight) in &probes {
            gather(
                &mut out,
                read(file, level, [s + ds, t + dt], interpolation_of, &read_options),
                share * weight,
            );
        }
    }
    out
}

/// Steps from the middle along the longer axis, and weights.
fn probes(ellipse: Ellipse, aspect: f32) -> Vec<([f32; 2], f32)> {
    let (sin, cos) = ellipse.theta.sin_cos();
    let length = 2.0 * (ellipse.major - ellipse.minor);
    // The axes are diameters.
    let axis = [0.5 * length * cos, 0.5 * length * sin];
    let count = ((2.0 * aspect - 1.0) as usize).max(1);
    let abscissa = |i: usize| if count == 1 { 0.0 } else { 2.0 * (i as f32 + 0.5) / count as f32 - 1.0 };
    let weight = |i: usize| {
        let x = abscissa(i) * ellipse.major / length;
        if count <= 2 { 1.0 } else { (-2.0 * x * x).exp() }
    };
    let all: f32 = (0..count).map(weight).sum();
    (0..count).map(|i| (axis.map(|a| a * abscissa(i)), weight(i) / all)).collect()
}

/// The picture of all around in a direction. Its left and right border meet.
pub(super) fn around(
    file: &Stored,
    read_options: [Dual<f32>; 3],
    options: &TextureOptions,
    first: usize,
) -> Read {
    let unit = |v: [f32; 3]| {
        let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
        v.map(|x| if length > 0.0 { x / length } else { 0.0 })
    };
    let r = unit(read_options.map(|d| d.value));
    let there = [read_options.map(|d| d.value + d.dx), read_options.map(|d| d.value + d.dy)].map(unit);
    let angles = there.map(|v| {
        let cos: f32 = v.iter().zip(r).map(|(a, b)| a * b).sum();
        cos.clamp(-1.0, 1.0).acos().max(NARROWEST)
    });
    let natural = (PI / angles[0].min(angles[1])) as usize / 2;
    let filter = [0, 1].map(|k: usize| angles[k] * options.width[k] + options.blur[k]);
    let is_x = filter[0] >= filter[1];
    let (axis, major, minor) =
        if is_x { (there[0], filter[0], filter[1]) } else { (there[1], filter[1], filter[0]) };
    let mut ellipse = Ellipse { major, minor, theta: 0.0 };
    let aspect = ellipse.limit();
    let count = (aspect - 0.25).ceil().max(1.0);
    let rows = |m: usize| file.levels[m].height as f32 * ellipse.minor / PI;
    let chosen = levels(file.levels.len(), rows).unwrap_or([(0, 1.0), (0, 0.0)]);
    let wrap = [Wrap::Periodic, Wrap::Clamp];
    let how = ReadOptions { wrap, first, channels: options.channels, fill: options.fill };
    let mut out = Read::default();
    for probe in 0..count as usize {
        let step = (probe as f32 + 0.5) / count - 0.5;
        let abscissa = [0, 1, 2].map(|k: usize| Dual::from(r[k] + step * axis[k]));
        let [s, t] = of_file(file, abscissa);
        for (m, share) in chosen {
            if share == 0.0 {
                continue;
            }
            let level = &file.levels[m];
            let interpolation_of = interpolation_of(options, m == 0 || level.height < natural);
            let found = read(file, level, [s, t], interpolation_of, &how);
            gather(&mut out, towards_pole(file, m, t, found, &how), share / count);
        }
    }
    out
}

/// The coordinates of a direction: y is up unless the file names z.
fn of_file(file: &Stored, [x, y, z]: [Dual<f32>; 3]) -> [f32; 2] {
    let y_up = file.text("oiio:updirection") != Some("z");
    // The same picture, seen from axes that are named in another order.
    let read_options = if y_up { [x, y, z] } else { [-y, z, x] };
    longitude_latitude(read_options).map(|d| if d.value.is_nan() { 0.0 } else { d.value })
}

/// In levels of a single tile a row's mean is the pole's colour.
fn towards_pole(file: &Stored, m: usize, t: f32, found: Read, read_options: &ReadOptions) -> Read {
    let level = &file.levels[m];
    let fits = level.tile.is_none_or(|[w, h]| level.width <= w && level.height <= h);
    let height = level.height as f32;
    let row = t * height;
    let (pole, y) = if row < 1.0 {
        (1.0 - row, 0)
    } else if row > height - 1.0 {
        (row - row.floor(), level.height - 1)
    } else {
        return found;
    };
    if !fits {
        return found;
    }
    let share = pole.clamp(0.0, 1.0).powi(2);
    let mut out = found.map(|list| list.map(|x| x * (1.0 - share)));
    for (c, out) in out
        .iter_mut()
        .enumerate()
        .take(file.channels.saturating_sub(read_options.first).min(read_options.channels))
    {
        let value =
            |x: usize| level.values.get((y * level.width + x) * file.channels + read_options.first + c);
        let mean = (0..level.width).map(value).sum::<f32>() / level.width as f32;
        out[0] += share * mean;
    }
    out
}
