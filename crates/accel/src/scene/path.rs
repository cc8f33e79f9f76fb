// SPDX-License-Identifier: GPL-3.0-or-later
//! Motion of an instance during an open shutter: matrices at evenly spaced times, and their interpolation.
//! Rotations are in `rotation.rs`.
//! Space: world. Invariant: keys are reproduced exactly, and the box of a path encloses the object at every
//! time.
//! Tests: `tests`, `tests/surfaces/motion.rs`.

use gnurt_accel_core::affine::inverse;

use super::box64::Box64;
use super::exact::Stand;
use super::rotation::{Columns, Rotation};

/// The transform of an instance at each time from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionPath {
    keys: Vec<[[f64; 3]; 4]>,
    pieces: Vec<Piece>,
    /// Of the first key and the last.
    times: [f32; 2],
}

/// The piece between two keys: all data for a ray between them, contiguous in memory.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    /// Where the object's origin is at both ends; it goes straight.
    translations: [[f64; 3]; 2],
    linear: Linear,
}

/// Interpolation of the linear part.
#[derive(Clone, Debug, PartialEq)]
enum Linear {
    /// It stays: the rows of its inverse.
    Stays([[f64; 3]; 3]),
    Rotating(Rotation),
    /// Its columns go straight, which shears on the way.
    Straight([[[f64; 3]; 3]; 2]),
}

/// Between two linear parts, entry by entry.
#[inline(always)]
fn mixed([from, to]: &[[[f64; 3]; 3]; 2], share: f64) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| [0, 1, 2].map(|k| (1.0 - share) * from[c][k] + share * to[c][k]))
}

/// The times of keys that have no others.
const SHUTTER: [f32; 2] = [0.0, 1.0];

impl Piece {
    fn new(from: &Columns, to: &Columns, is_straight: bool) -> Option<Self> {
        let linear = match from[..3] == to[..3] {
            true => Linear::Stays(inverse(from)?),
            false if is_straight => Linear::Straight([from, to].map(|key| [key[0], key[1], key[2]])),
            false => Linear::Rotating(Rotation::new(from, to)?),
        };
        Some(Self { translations: [from[3], to[3]], linear })
    }

    /// The object's transform at a fraction of the piece that is neither 0 nor 1; `None` if it is flat.
    #[inline(always)]
    pub(super) fn stand(&self, share: f64) -> Option<Stand> {
        let translation = self.translation(share);
        let rows = match &self.linear {
            Linear::Stays(rows) => *rows,
            Linear::Rotating(rotation) => {
                let [x, y, z] = rotation.linear(share);
                inverse(&[x, y, z, translation])?
            }
            Linear::Straight(ends) => {
                let [x, y, z] = mixed(ends, share);
                inverse(&[x, y, z, translation])?
            }
        };
        Some(Stand { rows, translation })
    }

    #[inline(always)]
    fn translation(&self, share: f64) -> [f64; 3] {
        let [from, to] = &self.translations;
        let mix = |k: usize| (1.0 - share) * from[k] + share * to[k];
        [mix(0), mix(1), mix(2)]
    }

    fn angle(&self) -> f64 {
        match &self.linear {
            Linear::Stays(_) | Linear::Straight(_) => 0.0,
            Linear::Rotating(rotation) => rotation.angle(),
        }
    }

    /// In how many steps a box follows it, and by how much at most a point of the box leaves the straight line within one.
    fn steps(&self, object: &Box64) -> (f64, f64) {
        match &self.linear {
            Linear::Stays(_) | Linear::Straight(_) => (1.0, 0.0),
            Linear::Rotating(rotation) => rotation.steps(object),
        }
    }
}

impl MotionPath {
    /// Through these transforms, columns as of
    /// [`Instance::world_from_object`](super::Instance::world_from_object), one or more, at times evenly
    /// spaced from 0 to 1. Rotations follow the shorter arc: give more transforms if an object rotates by
    /// more than half a circle. `None` if there is no transform, or if one is flat or not finite.
    #[must_use]
    pub fn new(translations: &[[[f64; 3]; 4]]) -> Option<Self> {
        Self::through(translations, false)
    }

    /// The same, but entries of the transforms go straight from key to key, and so do all points of an object. A rotation by
    /// half a circle goes through a flat object that no ray sees.
    #[must_use]
    pub fn straight(keys: &[[[f64; 3]; 4]]) -> Option<Self> {
        Self::through(keys, true)
    }

    /// The same path with its keys from one time to another, which may lie outside of 0 to 1. Before and after these no
    /// ray sees the instance.
    #[must_use]
    pub fn within(self, times: [f32; 2]) -> Self {
        Self { times, ..self }
    }

    fn through(translations: &[[[f64; 3]; 4]], is_straight: bool) -> Option<Self> {
        let first = translations.first()?;
        let mut keys = translations.to_vec();
        if keys.len() == 1 {
            keys.push(*first);
        }
        let is_sound = |key: &Columns| key.as_flattened().iter().all(|x| x.is_finite());
        if !keys.iter().all(|key| is_sound(key) && inverse(key).is_some()) {
            return None;
        }
        let pieces =
            keys.windows(2).map(|pair| Piece::new(&pair[0], &pair[1], is_straight)).collect::<Option<_>>()?;
        Some(Self { keys, pieces, times: SHUTTER })
    }

    /// The transforms that it was made from, two at least.
    #[must_use]
    pub fn keys(&self) -> &[[[f64; 3]; 4]] {
        &self.keys
    }

    /// How far a time is from the first key to the last.
    #[inline(always)]
    fn local(&self, time: f32) -> f32 {
        let [from, to] = self.times;
        if self.times == SHUTTER {
            time
        } else if to > from {
            (time - from) / (to - from)
        } else {
            0.0
        }
    }

    /// Whether its keys are not those of the open shutter.
    pub(super) fn is_partial(&self) -> bool {
        self.times != SHUTTER
    }

    /// Whether a time is between the first key and the last.
    pub(super) fn is_there(&self, time: f32) -> bool {
        !self.is_partial() || time >= self.times[0] && time <= self.times[1]
    }

    /// The instance's transform at a time; times outside of 0 to 1 are clamped, NaN is 0.
    #[must_use]
    pub fn at(&self, time: f32) -> [[f64; 3]; 4] {
        let (piece, share) = share_of(self.local(time), self.pieces.len());
        self.segment(piece, share)
    }

    /// The derivative of [`at`](Self::at) by the time; at a key that of the piece behind it, and 0 at times at which the
    /// path has ended or not begun.
    #[must_use]
    pub fn rate(&self, time: f32) -> [[f64; 3]; 4] {
        let [first, last] = self.times;
        if !(time >= first && time <= last && last > first) {
            return [[0.0; 3]; 4];
        }
        let (number, share) = share_of(self.local(time), self.pieces.len());
        let piece = &self.pieces[number];
        let change = |[from, to]: &[[f64; 3]; 2]| std::array::from_fn(|k| to[k] - from[k]);
        let [x, y, z] = match &piece.linear {
            Linear::Stays(_) => [[0.0; 3]; 3],
            Linear::Rotating(rotation) => rotation.rate(share),
            Linear::Straight([from, to]) => [0, 1, 2].map(|c| change(&[from[c], to[c]])),
        };
        let speed = self.pieces.len() as f64 / f64::from(last - first);
        [x, y, z, change(&piece.translations)].map(|column| column.map(|x: f64| x * speed))
    }

    fn segment(&self, number: usize, share: f64) -> [[f64; 3]; 4] {
        let (from, to) = (&self.keys[number], &self.keys[number + 1]);
        if share == 0.0 {
            return *from;
        }
        if share == 1.0 {
            return *to;
        }
        let piece = &self.pieces[number];
        let translation = piece.translation(share);
        let [x, y, z] = match &piece.linear {
            Linear::Stays(_) => [from[0], from[1], from[2]],
            Linear::Rotating(rotation) => rotation.linear(share),
            Linear::Straight(ends) => mixed(ends, share),
        };
        [x, y, z, translation]
    }

    /// The same for rays; `None` at a time at which the object is flat or not there.
    pub(super) fn stand(&self, time: f32) -> Option<Stand> {
        if !self.is_there(time) {
            return None;
        }
        let (number, share) = share_of(self.local(time), self.pieces.len());
        if share == 0.0 || share == 1.0 {
            let columns = &self.keys[number + usize::from(share == 1.0)];
            return Some(Stand { rows: inverse(columns)?, translation: columns[3] });
        }
        self.pieces[number].stand(share)
    }

    /// The only piece, where there is one only.
    pub(super) fn only_piece(&self) -> Option<&Piece> {
        match &self.pieces[..] {
            [only] if !self.is_partial() => Some(only),
            _ => None,
        }
    }

    /// Calls `visit` with successive pairs of transforms along the path, and a bound on the distance of the
    /// box's points from the straight line between them.
    pub(super) fn steps(&self, object: &Box64, mut visit: impl FnMut(&[[f64; 3]; 4], &[[f64; 3]; 4], f64)) {
        for (i, piece) in self.pieces.iter().enumerate() {
            let (count, bulge) = piece.steps(object);
            for step in 0..count as u32 {
                let [from, to] = [step, step + 1].map(|step| self.segment(i, f64::from(step) / count));
                visit(&from, &to, bulge);
            }
        }
    }
}

/// The piece, of this many, that contains a time, and the fraction of it before the time; times outside of 0
/// to 1 are clamped, NaN is 0.
#[inline(always)]
pub(super) fn share_of(time: f32, pieces: usize) -> (usize, f64) {
    let at = f64::from(if time > 0.0 { time.min(1.0) } else { 0.0 }) * pieces as f64;
    let piece = (at as usize).min(pieces - 1);
    (piece, at - piece as f64)
}

/// Pieces between which boxes go straight: two keys more for each.
const MOST_PIECES: usize = 8;

/// The greatest rotation of an object, in radians, per straight piece of its box's path.
const STRAIGHT: f64 = 0.35;

impl MotionPath {
    /// In how many pieces of the time, a power of two, a box can follow it by going straight.
    pub(super) fn straight_pieces(&self) -> usize {
        let count = self.pieces.len();
        let widest = self.pieces.iter().map(Piece::angle).fold(0.0, f64::max) * count as f64;
        let expected = count.max((widest / STRAIGHT).ceil() as usize);
        expected.next_power_of_two().min(MOST_PIECES)
    }

    /// As [`steps`](Self::steps), cut at the ends of this many pieces of the time. `visit` is called with the
    /// number of that piece, with two transforms and their positions on that piece (0 to 1), and with the
    /// bulge; pieces and positions ascend.
    pub(super) fn steps_of(
        &self,
        object: &Box64,
        pieces: usize,
        mut visit: impl FnMut(usize, [(f64, [[f64; 3]; 4]); 2], f64),
    ) {
        let own = self.pieces.len() as f64;
        for (i, piece) in self.pieces.iter().enumerate() {
            let (count, bulge) = piece.steps(object);
            let mut ends: Vec<f64> = (0..=count as u32).map(|step| f64::from(step) / count).collect();
            let cuts = (1..pieces).map(|cut| cut as f64 / pieces as f64 * own - i as f64);
            ends.extend(cuts.filter(|&behind| behind > 0.0 && behind < 1.0));
            ends.sort_unstable_by(f64::total_cmp);
            for pair in ends.windows(2) {
                let at = |behind: f64| (i as f64 + behind) / own * pieces as f64;
                let piece = (at(0.5 * (pair[0] + pair[1])) as usize).min(pieces - 1);
                let end =
                    |behind: f64| ((at(behind) - piece as f64).clamp(0.0, 1.0), self.segment(i, behind));
                visit(piece, [end(pair[0]), end(pair[1])], bulge);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotated by `angle` around z, scaled, moved.
    fn turned(angle: f64, scale: [f64; 3], translation: [f64; 3]) -> [[f64; 3]; 4] {
        let (s, c) = angle.sin_cos();
        let [x, y, z] = scale;
        [[x * c, x * s, 0.0], [-y * s, y * c, 0.0], [0.0, 0.0, z], translation]
    }

    fn near(a: &[[f64; 3]; 4], b: &[[f64; 3]; 4]) -> bool {
        a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn rotations_follow_the_arc_and_reach_their_keys() {
        for scale in [[1.0; 3], [2.0, 0.5, 3.0], [-1.0, 1.0, 1.0], [1.0, -2.0, 0.25], [0.5, 1.0, -1.0]] {
            let at = |t: f64| turned(0.3 + 2.8 * t, scale, [1.0 + t, 5.0 * t, -t]);
            let path = MotionPath::new(&[at(0.0), at(1.0)]).expect("two places");
            assert_eq!([path.at(0.0), path.at(1.0)], [at(0.0), at(1.0)], "keys are met");
            for t in [0.1_f32, 0.25, 0.5, 0.9] {
                let (found, expected) = (path.at(t), at(f64::from(t)));
                assert!(near(&found, &expected), "{scale:?} at {t}: {found:?}, not {expected:?}");
            }
        }
        let quarters = MotionPath::new(
            &[0.0, 0.25, 0.5, 0.75, 1.0].map(|t: f64| turned(t * std::f64::consts::TAU, [1.0; 3], [0.0; 3])),
        );
        let third = quarters.expect("five places").at(1.0 / 3.0);
        let expected = turned(f64::from(1.0_f32 / 3.0) * std::f64::consts::TAU, [1.0; 3], [0.0; 3]);
        assert!(near(&third, &expected), "a whole turn by quarters: {third:?}");
    }

    #[test]
    fn rates_are_the_slopes_of_paths() {
        let at = |t: f64| turned(0.3 + 2.8 * t, [2.0, 0.5 + t, 3.0], [1.0 + t, 5.0 * t, -t]);
        let keys = [at(0.0), at(0.4), at(1.0)];
        let still = [at(0.0), at(0.0)];
        for (name, path) in [
            ("arcs", MotionPath::new(&keys)),
            ("lines", MotionPath::straight(&keys)),
            ("lines in another range", MotionPath::straight(&keys).map(|path| path.within([-1.0, 2.0]))),
            ("arcs in another range", MotionPath::new(&keys).map(|path| path.within([0.1, 0.9]))),
            ("a line in place", MotionPath::new(&still)),
        ] {
            let path = path.expect("sound keys");
            for t in [0.15_f32, 0.25, 0.45, 0.6, 0.875] {
                let h = 1.0 / 1024.0;
                let (from, to) = (path.at(t - h), path.at(t + h));
                let found = path.rate(t);
                for ((found, from), to) in
                    found.iter().flatten().zip(from.iter().flatten()).zip(to.iter().flatten())
                {
                    let slope = (to - from) / (2.0 * f64::from(h));
                    assert!(
                        (found - slope).abs() < 1e-4 * (1.0 + slope.abs()),
                        "{name} at {t}: {found}, not {slope}"
                    );
                }
            }
        }
        let path = MotionPath::new(&keys).expect("sound keys").within([0.25, 0.75]);
        assert_eq!([path.rate(0.2), path.rate(0.8), path.rate(f32::NAN)], [[[0.0; 3]; 4]; 3], "not there");
    }

    #[test]
    fn what_has_no_inverse_is_refused() {
        let good = turned(0.0, [1.0; 3], [0.0; 3]);
        for bad in [
            turned(0.0, [1.0, 0.0, 1.0], [0.0; 3]),
            turned(f64::NAN, [1.0; 3], [0.0; 3]),
            turned(0.0, [1.0; 3], [f64::INFINITY, 0.0, 0.0]),
        ] {
            assert_eq!(MotionPath::new(&[good, bad]), None, "{bad:?} is no place");
        }
        assert_eq!(MotionPath::new(&[]), None, "nowhere");
        let still = MotionPath::new(&[good]).expect("one place");
        assert_eq!((still.at(0.0), still.at(0.7)), (good, good), "one place stays");
    }

    #[test]
    fn boxes_of_paths_hold_what_moves() {
        let object = Box64 { min: [-1.0, 0.5, -2.0], max: [3.0, 4.0, 1.0] };
        let keys = [
            turned(0.0, [1.0, 2.0, 1.0], [0.0; 3]),
            turned(2.9, [2.0, 1.0, 0.5], [9.0, 1.0, 0.0]),
            turned(5.0, [1.0; 3], [9.0, 9.0, 9.0]),
        ];
        let path = MotionPath::new(&keys).expect("three places");
        let apply = |m: &[[f64; 3]; 4], p: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|row| (0..3).map(|k| m[k][row] * p[k]).sum::<f64>() + m[3][row])
        };
        let corner =
            |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { object.min[k] } else { object.max[k] });
        let mut around = Box64::EMPTY;
        path.steps(&object, |from, to, bulge| {
            for p in (0..8).flat_map(|i| [apply(from, corner(i)), apply(to, corner(i))]) {
                for (k, &x) in p.iter().enumerate() {
                    around.min[k] = around.min[k].min(x - bulge);
                    around.max[k] = around.max[k].max(x + bulge);
                }
            }
        });
        let mut true_box = Box64::EMPTY;
        for step in 0..=10_000 {
            let translation = path.at(step as f32 / 10_000.0);
            for p in (0..8).map(|i| apply(&translation, corner(i))) {
                for (k, &x) in p.iter().enumerate() {
                    assert!(around.min[k] <= x && x <= around.max[k], "step {step}: {p:?} is in {around:?}");
                    true_box.min[k] = true_box.min[k].min(x);
                    true_box.max[k] = true_box.max[k].max(x);
                }
            }
        }
        for k in 0..3 {
            let more = (around.max[k] - around.min[k]) / (true_box.max[k] - true_box.min[k]);
            assert!(more < 1.01, "the box is tight along {k}: {more}");
        }
    }
}
