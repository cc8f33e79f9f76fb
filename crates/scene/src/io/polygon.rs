// SPDX-License-Identifier: GPL-3.0-or-later
//! Cuts polygons into triangles.
//! Source: [Mei75] (ear clipping: G. H. Meisters, Polygons have ears); the normal by Newell's method.
//! Convex polygons become fans. Others are clipped ear by ear in the plane of their normal; where no ear is left
//! (crossing edges) the rest becomes a fan. Cost: O(n) for convex ones, up to O(n³) for others, n at most
//! [`LARGEST_CLIPPED`]; all polygons of a file together test [`WORK`] corners and [`WORK_GROWTH`] for each of
//! its bytes.
//! Tests: `tests::{convex_is_a_fan, concave_keeps_its_area, survives_anything, work_ends}`.

/// Corners up to which a concave polygon is clipped; beyond, a fan.
const LARGEST_CLIPPED: usize = 2000;
/// The limit of tested corners in any file.
const WORK: u64 = 1 << 26;
/// Further tested corners for each byte of the file.
const WORK_GROWTH: u64 = 6;

type Point = [f64; 2];

/// Cuts the polygons of one file within a budget of work, so that no file takes quadratic time: after it is
/// spent, polygons become fans.
pub struct Cutter {
    work_left: u64,
    corners: Vec<[f32; 3]>,
    cut: Vec<[usize; 3]>,
}

impl Cutter {
    /// For a file of this length.
    pub fn for_file(length: u64) -> Self {
        let work_left = length.saturating_mul(WORK_GROWTH).saturating_add(WORK);
        Self { work_left, corners: Vec::new(), cut: Vec::new() }
    }

    /// Hands out triangles of the numbers `0..count` of a polygon's corners, which lie at `position`: two less than
    /// corners.
    pub fn cut(
        &mut self,
        count: usize,
        position: impl Fn(usize) -> [f32; 3],
        mut triangle: impl FnMut([usize; 3]),
    ) {
        if count <= 3 || count > LARGEST_CLIPPED {
            return (2..count).for_each(|i| triangle([0, i - 1, i]));
        }
        self.corners.clear();
        self.corners.extend((0..count).map(position));
        self.cut.clear();
        triangulate(&self.corners, &mut self.cut, &mut self.work_left);
        self.cut.iter().copied().for_each(triangle);
    }
}

/// Appends triangles of positions `0..corners.len()` in the polygon to `triangles`, two less than corners.
fn triangulate(corners: &[[f32; 3]], triangles: &mut Vec<[usize; 3]>, work_left: &mut u64) {
    let flat = project(corners);
    if is_convex(&flat) {
        return triangles.extend((2..flat.len()).map(|i| [0, i - 1, i]));
    }
    clip_ears(&flat, triangles, work_left);
}

fn fan(ring: &[usize], triangles: &mut Vec<[usize; 3]>) {
    triangles.extend((2..ring.len()).map(|i| [ring[0], ring[i - 1], ring[i]]));
}

/// The corners in the plane that Newell's normal is largest on, counter-clockwise.
fn project(corners: &[[f32; 3]]) -> Vec<Point> {
    let n = corners.len();
    let corner = |i: usize| corners[i % n].map(f64::from);
    let mut normal = [0.0; 3];
    for i in 0..n {
        let (p, q) = (corner(i), corner(i + 1));
        for (k, sum) in normal.iter_mut().enumerate() {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            *sum += (p[a] - q[a]) * (p[b] + q[b]);
        }
    }
    let axis = (0..3).fold(0, |best, k| if normal[k].abs() > normal[best].abs() { k } else { best });
    let (u, v) = if normal[axis] >= 0.0 { (axis + 1, axis + 2) } else { (axis + 2, axis + 1) };
    (0..n).map(|i| [corner(i)[u % 3], corner(i)[v % 3]]).collect()
}

/// Twice the signed area of a triangle: above 0 if it runs counter-clockwise.
fn orientation(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether every corner of a polygon is a left turn, and the sum is one full turn (a pentagram has left turns
/// too).
fn is_convex(p: &[Point]) -> bool {
    let n = p.len();
    let left = (0..n).all(|i| orientation(p[i], p[(i + 1) % n], p[(i + 2) % n]) >= 0.0);
    left && (2..n).all(|i| orientation(p[0], p[i - 1], p[i]) >= 0.0)
}

/// Cuts off corner after corner that is convex and holds no other corner.
fn clip_ears(p: &[Point], triangles: &mut Vec<[usize; 3]>, work_left: &mut u64) {
    let mut ring: Vec<usize> = (0..p.len()).collect();
    let (mut at, mut refused) = (0, 0);
    while ring.len() > 3 && refused < ring.len() && *work_left > 0 {
        let n = ring.len();
        at %= n;
        let ear = [ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]];
        // A reflex corner is rejected at once.
        let is_convex = orientation(p[ear[0]], p[ear[1]], p[ear[2]]) > 0.0;
        *work_left = work_left.saturating_sub(if is_convex { n as u64 } else { 1 });
        if is_ear(p, &ring, ear) {
            triangles.push(ear);
            ring.remove(at);
            refused = 0;
        } else {
            refused += 1;
            at += 1;
        }
    }
    fan(&ring, triangles);
}

fn is_ear(p: &[Point], ring: &[usize], ear: [usize; 3]) -> bool {
    let [a, b, c] = ear.map(|i| p[i]);
    // Corners at the position of one of the ear's corners (bridges to holes) do not block it; this test comes
    // last because it is rarely needed.
    let inside = |q: Point| {
        orientation(a, b, q) >= 0.0
            && orientation(b, c, q) >= 0.0
            && orientation(c, a, q) >= 0.0
            && q != a
            && q != b
            && q != c
    };
    // A reflex, straight or NaN corner is no ear.
    orientation(a, b, c) > 0.0 && !ring.iter().any(|&i| inside(p[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[[f32; 3]]) -> Vec<[usize; 3]> {
        let mut all = Vec::new();
        Cutter::for_file(0).cut(corners.len(), |i| corners[i], |t| all.push(t));
        all
    }

    /// Sum of the areas of the triangles: above the polygon's own where they overlap or lie outside.
    fn area(corners: &[[f32; 3]]) -> f64 {
        let p = project(corners);
        triangles(corners).iter().map(|t| orientation(p[t[0]], p[t[1]], p[t[2]]).abs() / 2.0).sum()
    }

    #[test]
    fn convex_is_a_fan() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(triangles(&square), [[0, 1, 2], [0, 2, 3]], "the usual cut");
    }

    #[test]
    fn concave_keeps_its_area() {
        let arrow = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 0.0, 0.0], [1.0, 3.0, 0.0]];
        assert!((area(&arrow) - 2.0).abs() < 1e-9, "an arrow head, area 2: {}", area(&arrow));
        let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        for k in 0..6 {
            // Every corner first once, in both directions, upright in the yz plane.
            let ring: Vec<_> = (0..6).map(|i| l[(i + k) % 6]).map(|[y, z]| [7.0, y, z]).collect();
            assert!((area(&ring) - 5.0).abs() < 1e-9, "an L from corner {k}");
            let back: Vec<_> = ring.into_iter().rev().collect();
            assert!((area(&back) - 5.0).abs() < 1e-9, "an L from corner {k}, the other way round");
        }
    }

    #[test]
    fn work_ends() {
        // A comb: every other corner of its upper edge is reflex.
        let n = 1000;
        let tooth = |i: usize| [i as f32, if i.is_multiple_of(2) { 1.0 } else { 9.0 }, 0.0];
        let mut comb: Vec<_> = (0..n).rev().map(tooth).collect();
        comb.extend([[0.0; 3], [n as f32, 0.0, 0.0]]);
        let mut cutter = Cutter::for_file(0);
        cutter.work_left = 10_000;
        let mut count = 0;
        cutter.cut(comb.len(), |i| comb[i], |_| count += 1);
        assert_eq!((count, cutter.work_left), (n, 0), "two triangles less than corners, and no more work");
        assert!(
            (area(&comb) - 5.0 * n as f64).abs() < 10.0,
            "with enough of it the comb is whole: {}",
            area(&comb)
        );
    }

    #[test]
    fn survives_anything() {
        let bad = [[f32::NAN; 3], [0.0; 3], [f32::INFINITY, 0.0, 1.0], [0.0; 3], [1.0; 3]];
        assert_eq!(triangles(&bad).len(), 3, "always corners less 2");
        let star = [[0.0, 3.0, 0.0], [2.0, -3.0, 0.0], [-3.0, 1.0, 0.0], [3.0, 1.0, 0.0], [-2.0, -3.0, 0.0]];
        assert_eq!(triangles(&star).len(), 3, "crossing edges too");
        assert_eq!(triangles(&bad[..2]).len(), 0, "too short");
    }
}
