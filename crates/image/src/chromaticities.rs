// SPDX-License-Identifier: GPL-3.0-or-later
//! Chromaticities of primaries and white, and the matrices between the spaces that they span.
//! Source: SMPTE RP 177 (a matrix from primaries and white); whites are adapted by Bradford's transform \[Lam85\].
//! Space: linear light. The working space of all pictures is that of [`REC709`]. Tests: `tests`.

/// Chromaticities x, y of red, green, blue and white.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chromaticities {
    /// Red, green, blue.
    pub primaries: [[f32; 2]; 3],
    /// White.
    pub white: [f32; 2],
}

/// Rec. 709 and sRGB: the space of all pictures here.
pub const REC709: Chromaticities =
    Chromaticities { primaries: [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]], white: [0.3127, 0.3290] };
/// Rec. 2020.
pub const REC2020: Chromaticities =
    Chromaticities { primaries: [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]], white: [0.3127, 0.3290] };
/// Display P3.
pub const DISPLAY_P3: Chromaticities =
    Chromaticities { primaries: [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]], white: [0.3127, 0.3290] };
/// ACEScg (AP1).
pub const ACES_CG: Chromaticities =
    Chromaticities { primaries: [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]], white: [0.32168, 0.33767] };

/// Rows of the matrix that changes nothing.
pub(crate) const IDENTITY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(crate) type Rows = [[f64; 3]; 3];

impl Chromaticities {
    /// Whether two are the same within the rounding of files.
    #[must_use]
    pub fn is_near(&self, other: &Self) -> bool {
        let all = |c: &Self| [c.primaries[0], c.primaries[1], c.primaries[2], c.white];
        all(self).as_flattened().iter().zip(all(other).as_flattened()).all(|(a, b)| (a - b).abs() < 2e-3)
    }

    /// Rows of the matrix from linear colours of this space to those of another; `None` if the primaries span
    /// no space.
    #[must_use]
    pub fn to(&self, other: &Self) -> Option<[[f32; 3]; 3]> {
        let adapted = product(&adaptation(self.white, other.white)?, &self.xyz()?);
        let rows = product(&inverse(&other.xyz()?)?, &adapted);
        let single = rows.map(|row| row.map(|x| x as f32));
        single.as_flattened().iter().all(|x| x.is_finite()).then_some(single)
    }

    /// Rows of the matrices to XYZ and back.
    pub(crate) fn xyz_and_back(&self) -> Option<(Rows, Rows)> {
        let xyz = self.xyz()?;
        Some((xyz, inverse(&xyz)?))
    }

    /// XYZ of the primaries, in columns, whose sum is white of luminance 1.
    fn xyz(&self) -> Option<Rows> {
        let [r, g, b] = self.primaries.map(xyz_of);
        let [r, g, b] = [r?, g?, b?];
        let columns = [0, 1, 2].map(|k| [r[k], g[k], b[k]]);
        let scale = times(&inverse(&columns)?, xyz_of(self.white)?);
        Some(columns.map(|row| [row[0] * scale[0], row[1] * scale[1], row[2] * scale[2]]))
    }
}

fn xyz_of([x, y]: [f32; 2]) -> Option<[f64; 3]> {
    let (x, y) = (f64::from(x), f64::from(y));
    (y > 0.0).then(|| [x / y, 1.0, (1.0 - x - y) / y])
}

/// From colours under one white to the same under another.
fn adaptation(from: [f32; 2], to: [f32; 2]) -> Option<Rows> {
    if from == to {
        return Some(IDENTITY.map(|row| row.map(f64::from)));
    }
    const CONES: Rows = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
    let (before, after) = (times(&CONES, xyz_of(from)?), times(&CONES, xyz_of(to)?));
    let scaled = [0, 1, 2].map(|k| CONES[k].map(|x| x * after[k] / before[k]));
    Some(product(&inverse(&CONES)?, &scaled))
}

fn times(rows: &Rows, v: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn product(a: &Rows, b: &Rows) -> Rows {
    a.map(|row| [0, 1, 2].map(|c| (0..3).map(|k| row[k] * b[k][c]).sum()))
}

fn inverse(m: &Rows) -> Option<Rows> {
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    let is_regular = determinant.abs() > 1e-9 && determinant.is_finite();
    is_regular.then(|| [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(c, r) / determinant)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(rows: [[f32; 3]; 3], expected: [[f32; 3]; 3]) {
        for (a, b) in rows.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((a - b).abs() < 2e-4, "{rows:?}, {expected:?}");
        }
    }

    #[test]
    fn matrices_are_those_of_the_standards() {
        close(REC709.to(&REC709).expect("a matrix"), IDENTITY);
        // Rec. ITU-R BT.2087.
        let expected = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]];
        close(REC709.to(&REC2020).expect("a matrix"), expected);
        // ACEScg to sRGB under Bradford's adaptation, as OpenColorIO's configurations have it.
        let expected =
            [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]];
        close(ACES_CG.to(&REC709).expect("a matrix"), expected);
        let flat = Chromaticities { primaries: [[0.3, 0.3]; 3], ..REC709 };
        assert_eq!((flat.to(&REC709), REC709.to(&flat)), (None, None), "no space");
    }
}
