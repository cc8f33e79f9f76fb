// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles without any order: hard input for trees. The kinds are those of the degenerate-input reports of
//! other tracers.

use crate::Random;

/// An indexed mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Triangles.
    pub indices: Vec<[u32; 3]>,
}

impl Soup {
    /// Appends a triangle with its own vertices.
    pub fn push(&mut self, corners: [[f32; 3]; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.push([first, first + 1, first + 2]);
    }

    /// Appends another soup.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.indices.extend(other.indices.iter().map(|triangle| triangle.map(|i| i + first)));
    }

    /// Corners of triangle `i`, or `None` where an index leads nowhere.
    #[must_use]
    pub fn corners(&self, i: usize) -> Option<[[f32; 3]; 3]> {
        let [a, b, c] = self.indices[i].map(|i| self.positions.get(i as usize).copied());
        Some([a?, b?, c?])
    }

    /// Moved by `offset`, rounded to floats.
    #[must_use]
    pub fn moved(mut self, offset: [f32; 3]) -> Self {
        self.positions.iter_mut().flatten().enumerate().for_each(|(i, x)| *x += offset[i % 3]);
        self
    }

    /// `n` triangles of size up to `size` in the cube `[-1, 1]^3`.
    #[must_use]
    pub fn random(seed: u64, n: usize, size: f32) -> Self {
        let mut random = Random::new(seed);
        let mut soup = Self::default();
        for _ in 0..n {
            let at = random.point();
            soup.push(std::array::from_fn(|_| {
                let d = random.point();
                [0, 1, 2].map(|k| at[k] + size * d[k])
            }));
        }
        soup
    }

    /// Axis-aligned triangles on a coarse grid: many are in one plane, share corners, overlap or are equal.
    #[must_use]
    pub fn grid(seed: u64, n: usize) -> Self {
        let mut random = Random::new(seed);
        let mut soup = Self::default();
        for _ in 0..n {
            let mut coordinate = || random.below(9) as f32 / 4.0 - 1.0;
            let mut corners: [[f32; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| coordinate()));
            let (axis, level) = (random.below(3), corners[0]);
            corners.iter_mut().for_each(|corner| corner[axis] = level[axis]);
            soup.push(corners);
        }
        soup
    }

    /// Triangles a thousand to a million times longer than wide.
    #[must_use]
    pub fn slivers(seed: u64, n: usize) -> Self {
        let mut random = Random::new(seed);
        let mut soup = Self::default();
        for _ in 0..n {
            let (a, b) = (random.point(), random.point());
            let width = random.pick(&[1e-3, 1e-4, 1e-6]);
            let d = random.point();
            soup.push([a, b, [0, 1, 2].map(|k| b[k] + width * d[k])]);
        }
        soup
    }

    /// Tables whose corners are at one of two neighbouring floats in height: typical "flat" exports of
    /// modelling programs.
    #[must_use]
    pub fn flat_but_for_one_bit(seed: u64, n: usize) -> Self {
        let mut random = Random::new(seed);
        let mut soup = Self::default();
        for _ in 0..n {
            let axis = random.below(3);
            let level = random.pick(&[-7.221_487_5_f32, 0.3, 2.0]);
            let middle = random.point();
            let mut corners = [random.point(), random.point(), random.point()];
            for corner in &mut corners {
                *corner = [0, 1, 2].map(|k| 4.0 * middle[k] + corner[k]);
                corner[axis] = random.pick(&[level, level.next_up()]);
            }
            soup.push(corners);
        }
        soup
    }

    /// Good triangles with bad ones among them: NaN, infinities, too large, no area, twice the same, indices that lead
    /// nowhere.
    #[must_use]
    pub fn degenerate(seed: u64, n: usize) -> Self {
        let mut random = Random::new(seed);
        let mut soup = Self::random(seed, n, 0.3);
        for _ in 0..n / 2 {
            let i = random.below(soup.positions.len());
            let bad = random.pick(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -1e19]);
            match random.below(6) {
                0 => soup.positions[i][random.below(3)] = bad,
                1 => soup.positions[i] = soup.positions[(i + 1) % (3 * n)],
                2 => {
                    let triangle = random.below(n);
                    soup.indices[triangle][random.below(3)] = random.pick(&[u32::MAX, 3 * n as u32, 1 << 31]);
                }
                3 => {
                    let again = random.below(soup.indices.len());
                    soup.indices.push(soup.indices[again]);
                }
                4 => soup.indices.push([i as u32; 3]),
                _ => {
                    let a = random.point();
                    soup.push([a, a.map(|x| 2.0 * x), a.map(|x| 4.0 * x)]);
                }
            }
        }
        soup
    }

    /// The same triangle `n` times.
    #[must_use]
    pub fn copies(n: usize) -> Self {
        let mut soup = Self::default();
        (0..n).for_each(|_| soup.push([[-0.5, -0.5, 0.1], [0.75, -0.25, 0.0], [0.0, 0.75, -0.2]]));
        soup
    }
}
