// SPDX-License-Identifier: GPL-3.0-or-later
//! How an instance moves while the shutter is open: matrices at moments that are evenly spaced, and what lies between two.
//! Source: turns follow the shorter arc at constant speed [Sho85], as glTF's do; a matrix is taken apart into a place, a
//! turn and a stretch by Gram and Schmidt, which for a translation, a turn and a scale finds those.
//! Space: world. Invariant: keys are met exactly. The box of a path holds the object at every moment: between two moments
//! points leave the straight line by less than the square of the time between them, times an eighth of their greatest
//! acceleration. Proof: `tests`, `tests/surfaces/motion.rs`.

use super::box64::Box64;
use super::exact::Exact;

/// Where an instance is at each moment from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionPath {
    keys: Vec<[[f64; 3]; 4]>,
    pieces: Vec<Piece>,
}

/// The way from one key to the next.
#[derive(Clone, Debug, PartialEq)]
enum Piece {
    /// All but the place stays: the rows of the inverse.
    Shift([[f64; 3]; 3]),
    Turn(Turn),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    /// The first turn, and the unit quaternion a quarter of a circle on along the arc.
    from: [f64; 4],
    beyond: [f64; 4],
    /// How long the arc is: half the angle by which the object turns.
    arc: f64,
    /// Columns of what is done before the turn, at both ends.
    stretch: [[[f64; 3]; 3]; 2],
    /// Whether these two are the same but for rounding: then the first counts.
    is_rigid: bool,
}

/// The object turns by so much at most, in radians, between two boxes of which one around its way is made.
const STEP: f64 = 0.05;

impl MotionPath {
    /// Through these places, columns as of [`Instance::world_from_object`](super::Instance::world_from_object), one or more, at
    /// moments evenly spaced from 0 to 1. Of each turn between two the shorter way is taken: give more places where an
    /// object turns by more than half a circle. `None` where there is no place, or one is flat or not finite.
    #[must_use]
    pub fn new(places: &[[[f64; 3]; 4]]) -> Option<Self> {
        let taken_apart: Vec<Parts> = places.iter().map(take_apart).collect::<Option<_>>()?;
        let first = places.first()?;
        let pairs = places.windows(2).zip(taken_apart.windows(2));
        let piece = |(places, parts): (&[Columns], &[Parts])| {
            if places[0][..3] == places[1][..3] {
                return Exact::new(&places[0]).map(|exact| Piece::Shift(exact.rows));
            }
            let ((from, stretch), (to, stretch_to)) = (parts[0], parts[1]);
            let dot: f64 = (0..4).map(|k| from[k] * to[k]).sum();
            let to = if dot < 0.0 { to.map(|x| -x) } else { to };
            let across: Quaternion = std::array::from_fn(|k| to[k] - dot.abs() * from[k]);
            let sine = length(&across);
            let beyond = if sine > 0.0 { across.map(|x| x / sine) } else { [0.0; 4] };
            let arc = sine.atan2(dot.abs());
            let is_rigid = is_same(&stretch, &stretch_to);
            Some(Piece::Turn(Turn { from, beyond, arc, stretch: [stretch, stretch_to], is_rigid }))
        };
        let mut pieces: Vec<Piece> = pairs.map(piece).collect::<Option<_>>()?;
        let mut keys = places.to_vec();
        if pieces.is_empty() {
            pieces.push(Piece::Shift(Exact::new(first)?.rows));
            keys.push(*first);
        }
        Some(Self { keys, pieces })
    }

    /// How many places it was made from, two at least.
    #[must_use]
    pub fn keys(&self) -> &[[[f64; 3]; 4]] {
        &self.keys
    }

    /// Where the instance is at a moment; other times than 0 to 1 are clamped, NaN is 0.
    #[must_use]
    pub fn at(&self, time: f32) -> [[f64; 3]; 4] {
        let (piece, behind) = self.piece(time);
        self.between(piece, behind)
    }

    /// The piece that a moment is in, and how far.
    fn piece(&self, time: f32) -> (usize, f64) {
        let at = f64::from(if time > 0.0 { time.min(1.0) } else { 0.0 }) * self.pieces.len() as f64;
        let piece = (at as usize).min(self.pieces.len() - 1);
        (piece, at - piece as f64)
    }

    fn between(&self, piece: usize, behind: f64) -> [[f64; 3]; 4] {
        let (from, to) = (&self.keys[piece], &self.keys[piece + 1]);
        if behind == 0.0 {
            return *from;
        }
        if behind == 1.0 {
            return *to;
        }
        let place = mix(&from[3], &to[3], behind);
        match &self.pieces[piece] {
            Piece::Shift(_) => [from[0], from[1], from[2], place],
            Piece::Turn(turn) => {
                let [x, y, z] = turn.linear(behind);
                [x, y, z, place]
            }
        }
    }

    /// That place and its inverse; `None` at a moment at which the object is flat.
    pub(super) fn exact(&self, time: f32) -> Option<Exact> {
        let (piece, behind) = self.piece(time);
        let columns = self.between(piece, behind);
        match &self.pieces[piece] {
            Piece::Shift(rows) => Some(Exact { rows: *rows, columns }),
            Piece::Turn(_) => Exact::new(&columns),
        }
    }

    /// Calls `visit` with places, two and two neighbours on the way, and by how much at most a point of the box leaves the
    /// straight line between them.
    pub(super) fn steps(&self, object: &Box64, mut visit: impl FnMut(&[[f64; 3]; 4], &[[f64; 3]; 4], f64)) {
        for (i, piece) in self.pieces.iter().enumerate() {
            let Piece::Turn(turn) = piece else {
                visit(&self.keys[i], &self.keys[i + 1], 0.0);
                continue;
            };
            let (count, bulge) = turn.steps(object);
            for step in 0..count as u32 {
                let [from, to] = [step, step + 1].map(|step| self.between(i, f64::from(step) / count));
                visit(&from, &to, bulge);
            }
        }
    }
}

/// Pieces between which boxes go straight: two keys more for each.
const MOST_PIECES: usize = 8;

/// The object turns by so much at most, in radians, while a box goes straight, where so many pieces do.
const STRAIGHT: f64 = 0.35;

impl MotionPath {
    /// In how many pieces of the time, a power of two, a box can follow it by going straight.
    pub(super) fn straight_pieces(&self) -> usize {
        let angle = |piece: &Piece| match piece {
            Piece::Shift(_) => 0.0,
            Piece::Turn(turn) => 2.0 * turn.arc,
        };
        let count = self.pieces.len();
        let widest = self.pieces.iter().map(angle).fold(0.0, f64::max) * count as f64;
        let wanted = count.max((widest / STRAIGHT).ceil() as usize);
        wanted.next_power_of_two().min(MOST_PIECES)
    }

    /// As [`steps`](Self::steps), cut where one of so many pieces of the time ends. `visit` is called with the number of that
    /// piece, with two places and where on that piece they are (0 to 1), and with the bulge; pieces and places ascend.
    pub(super) fn steps_of(
        &self,
        object: &Box64,
        pieces: usize,
        mut visit: impl FnMut(usize, [(f64, [[f64; 3]; 4]); 2], f64),
    ) {
        let own = self.pieces.len() as f64;
        for (i, piece) in self.pieces.iter().enumerate() {
            let (count, bulge) = match piece {
                Piece::Shift(_) => (1.0, 0.0),
                Piece::Turn(turn) => turn.steps(object),
            };
            let mut ends: Vec<f64> = (0..=count as u32).map(|step| f64::from(step) / count).collect();
            let cuts = (1..pieces).map(|cut| cut as f64 / pieces as f64 * own - i as f64);
            ends.extend(cuts.filter(|&behind| behind > 0.0 && behind < 1.0));
            ends.sort_unstable_by(f64::total_cmp);
            for pair in ends.windows(2) {
                let at = |behind: f64| (i as f64 + behind) / own * pieces as f64;
                let piece = (at(0.5 * (pair[0] + pair[1])) as usize).min(pieces - 1);
                let end =
                    |behind: f64| ((at(behind) - piece as f64).clamp(0.0, 1.0), self.between(i, behind));
                visit(piece, [end(pair[0]), end(pair[1])], bulge);
            }
        }
    }
}

type Quaternion = [f64; 4];
type Columns = [[f64; 3]; 4];
/// A turn, and the columns of what is done before it.
type Parts = (Quaternion, [[f64; 3]; 3]);

impl Turn {
    /// The linear part at a place of the piece, as columns.
    fn linear(&self, behind: f64) -> [[f64; 3]; 3] {
        // Written out: rays come here, each at its moment.
        let (sine, cosine) = (behind * self.arc).sin_cos();
        let (from, beyond) = (&self.from, &self.beyond);
        let along = |k: usize| cosine * from[k] + sine * beyond[k];
        let [x, y, z] = axes(&[along(0), along(1), along(2), along(3)]);
        let [[ax, ..], [bx, by, _], [cx, cy, cz]] = self.stretch_at(behind);
        // Upper triangular.
        let a = [x[0] * ax, x[1] * ax, x[2] * ax];
        let b = [x[0] * bx + y[0] * by, x[1] * bx + y[1] * by, x[2] * bx + y[2] * by];
        let c = [
            x[0] * cx + y[0] * cy + z[0] * cz,
            x[1] * cx + y[1] * cy + z[1] * cz,
            x[2] * cx + y[2] * cy + z[2] * cz,
        ];
        [a, b, c]
    }

    /// What is done before the turn.
    #[inline(always)]
    fn stretch_at(&self, behind: f64) -> [[f64; 3]; 3] {
        let [from, to] = &self.stretch;
        if self.is_rigid {
            return *from;
        }
        [mix(&from[0], &to[0], behind), mix(&from[1], &to[1], behind), mix(&from[2], &to[2], behind)]
    }

    /// In how many steps a box follows it, and by how much at most a point of the box leaves the straight line within one.
    fn steps(&self, object: &Box64) -> (f64, f64) {
        let (angle, [reach, growth]) = (2.0 * self.arc, self.reach(object));
        let count = (angle / STEP).ceil().max(1.0);
        let acceleration = angle * angle * reach + 2.0 * angle * growth;
        (count, acceleration / (8.0 * count * count))
    }

    /// How far corners of a box are from the origin that they turn around, and how much they move by stretching.
    fn reach(&self, object: &Box64) -> [f64; 2] {
        let mut most = [0.0_f64; 2];
        for corner in 0..8 {
            let p: [f64; 3] =
                std::array::from_fn(|k| if corner >> k & 1 == 0 { object.min[k] } else { object.max[k] });
            let apply = |columns: &[[f64; 3]; 3]| -> [f64; 3] {
                std::array::from_fn(|row| (0..3).map(|k| columns[k][row] * p[k]).sum())
            };
            let [from, to] = [apply(&self.stretch[0]), apply(&self.stretch[1])];
            let by: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
            most[0] = most[0].max(length(&from)).max(length(&to));
            most[1] = most[1].max(length(&by));
        }
        most
    }
}

/// Whether two stretches differ by what taking apart rounds, no more.
fn is_same(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> bool {
    let pairs = || a.as_flattened().iter().zip(b.as_flattened());
    let size = pairs().fold(0.0_f64, |most, (a, _)| most.max(a.abs()));
    pairs().all(|(a, b)| (a - b).abs() <= 1e-14 * size)
}

#[inline(always)]
fn mix(from: &[f64; 3], to: &[f64; 3], behind: f64) -> [f64; 3] {
    let mix = |k: usize| (1.0 - behind) * from[k] + behind * to[k];
    [mix(0), mix(1), mix(2)]
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A turn, and what is done before it, as columns: upper triangular. `None` where the columns are in one plane or not finite.
fn take_apart(columns: &Columns) -> Option<Parts> {
    Exact::new(columns)?;
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let [a, b, _, place] = *columns;
    let unit = |v: [f64; 3]| {
        let length = length(&v);
        v.map(|x| x / length)
    };
    let x = unit(a);
    // Twice is enough: what one subtraction leaves over is lost in the second.
    let without_x = |v: [f64; 3]| -> [f64; 3] {
        let along = dot(v, x);
        std::array::from_fn(|k| v[k] - along * x[k])
    };
    let y = unit(without_x(without_x(b)));
    let z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let stretch = [0, 1, 2].map(|k| [dot(x, columns[k]), dot(y, columns[k]), dot(z, columns[k])]);
    let turn = quaternion([x, y, z]);
    let finite = turn.iter().chain(stretch.as_flattened()).chain(&place).all(|x| x.is_finite());
    finite.then_some((turn, stretch))
}

/// The unit quaternion, the real part last, of a turn whose columns these are. Source: Shepperd, 1978: by the greatest part.
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> Quaternion {
    let trace = x[0] + y[1] + z[2];
    let greatest = trace.max(x[0]).max(y[1]).max(z[2]);
    let q = if greatest == trace {
        [y[2] - z[1], z[0] - x[2], x[1] - y[0], 1.0 + trace]
    } else if greatest == x[0] {
        [1.0 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2], y[2] - z[1]]
    } else if greatest == y[1] {
        [y[0] + x[1], 1.0 + y[1] - x[0] - z[2], z[1] + y[2], z[0] - x[2]]
    } else {
        [z[0] + x[2], z[1] + y[2], 1.0 + z[2] - x[0] - y[1], x[1] - y[0]]
    };
    let length = length(&q);
    q.map(|x| x / length)
}

/// The columns of a turn.
#[inline(always)]
fn axes(&[x, y, z, w]: &Quaternion) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turned by `angle` around z, scaled, moved.
    fn turned(angle: f64, scale: [f64; 3], place: [f64; 3]) -> [[f64; 3]; 4] {
        let (s, c) = angle.sin_cos();
        let [x, y, z] = scale;
        [[x * c, x * s, 0.0], [-y * s, y * c, 0.0], [0.0, 0.0, z], place]
    }

    fn near(a: &[[f64; 3]; 4], b: &[[f64; 3]; 4]) -> bool {
        a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn turns_follow_the_arc_and_meet_their_keys() {
        for scale in [[1.0; 3], [2.0, 0.5, 3.0], [-1.0, 1.0, 1.0], [1.0, -2.0, 0.25], [0.5, 1.0, -1.0]] {
            let at = |t: f64| turned(0.3 + 2.8 * t, scale, [1.0 + t, 5.0 * t, -t]);
            let path = MotionPath::new(&[at(0.0), at(1.0)]).expect("two places");
            assert_eq!([path.at(0.0), path.at(1.0)], [at(0.0), at(1.0)], "keys are met");
            for t in [0.1_f32, 0.25, 0.5, 0.9] {
                let (found, wanted) = (path.at(t), at(f64::from(t)));
                assert!(near(&found, &wanted), "{scale:?} at {t}: {found:?}, not {wanted:?}");
            }
        }
        let quarters = MotionPath::new(
            &[0.0, 0.25, 0.5, 0.75, 1.0].map(|t: f64| turned(t * std::f64::consts::TAU, [1.0; 3], [0.0; 3])),
        );
        let third = quarters.expect("five places").at(1.0 / 3.0);
        let wanted = turned(f64::from(1.0_f32 / 3.0) * std::f64::consts::TAU, [1.0; 3], [0.0; 3]);
        assert!(near(&third, &wanted), "a whole turn by quarters: {third:?}");
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
            let place = path.at(step as f32 / 10_000.0);
            for p in (0..8).map(|i| apply(&place, corner(i))) {
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
