// SPDX-License-Identifier: GPL-3.0-or-later
//! Affine maps as Embree's formats have them, and as columns in double precision: images of the axes, then of the
//! origin. Embree's manual for the formats. Tests: `tests`.

use crate::ffi_abi::format;

pub(crate) type Columns = [[f64; 3]; 4];

pub(crate) const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// How many floats a format has; `None` for one that is no map.
pub(crate) fn size(of: u32) -> Option<usize> {
    match of {
        format::FLOAT3X4_ROWS | format::FLOAT3X4_COLUMNS => Some(12),
        format::FLOAT4X4_ROWS | format::FLOAT4X4_COLUMNS | format::QUATERNION => Some(16),
        _ => None,
    }
}

/// The map that these floats are; there are [`size`] of them.
pub(crate) fn columns(of: u32, values: &[f32]) -> Columns {
    let at = |i: usize| f64::from(values[i]);
    let by = |f: &dyn Fn(usize, usize) -> usize| -> Columns {
        std::array::from_fn(|column| std::array::from_fn(|row| at(f(row, column))))
    };
    match of {
        format::FLOAT3X4_ROWS | format::FLOAT4X4_ROWS => by(&|row, column| 4 * row + column),
        format::FLOAT3X4_COLUMNS => by(&|row, column| 3 * column + row),
        format::FLOAT4X4_COLUMNS => by(&|row, column| 4 * column + row),
        _ => decomposed(&std::array::from_fn(at)),
    }
}

/// A decomposed map: scale, skew and shift first, then a rotation, then a translation.
fn decomposed(values: &[f64; 16]) -> Columns {
    let [sx, sy, sz, xy, xz, yz, tx, ty, tz, r, i, j, k, px, py, pz] = *values;
    let length = (r * r + i * i + j * j + k * k).sqrt();
    let [r, i, j, k] = [r, i, j, k].map(|x| if length > 0.0 { x / length } else { x });
    let rotation = [
        [r * r + i * i - j * j - k * k, 2.0 * (i * j + r * k), 2.0 * (i * k - r * j)],
        [2.0 * (i * j - r * k), r * r - i * i + j * j - k * k, 2.0 * (j * k + r * i)],
        [2.0 * (i * k + r * j), 2.0 * (j * k - r * i), r * r - i * i - j * j + k * k],
    ];
    let turned = |v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|row| (0..3).map(|column| rotation[column][row] * v[column]).sum())
    };
    let [tx, ty, tz] = turned([tx, ty, tz]);
    [turned([sx, 0.0, 0.0]), turned([xy, sy, 0.0]), turned([xz, yz, sz]), [tx + px, ty + py, tz + pz]]
}

/// The floats of a map in a format of matrices.
pub(crate) fn floats(of: u32, columns: &Columns) -> Option<Vec<f32>> {
    let at = |row: usize, column: usize| match (row, column) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        _ => columns[column][row] as f32,
    };
    let (rows, by_rows) = match of {
        format::FLOAT3X4_ROWS => (3, true),
        format::FLOAT4X4_ROWS => (4, true),
        format::FLOAT3X4_COLUMNS => (3, false),
        format::FLOAT4X4_COLUMNS => (4, false),
        _ => return None,
    };
    let elements = 0..rows * 4;
    Some(elements.map(|i| if by_rows { at(i / 4, i % 4) } else { at(i % rows, i / rows) }).collect())
}

/// First `inner`, then `outer`.
pub(crate) fn after(outer: &Columns, inner: &Columns) -> Columns {
    let mut all = inner.map(|column| linear(outer, column));
    all[3] = point(outer, inner[3]);
    all
}

pub(crate) fn linear(map: &Columns, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|row| (0..3).map(|column| map[column][row] * v[column]).sum())
}

/// A point carried by a map.
pub(crate) fn point(map: &Columns, p: [f64; 3]) -> [f64; 3] {
    let moved = linear(map, p);
    std::array::from_fn(|k| moved[k] + map[3][k])
}

/// The inverse map; for a flat one the result is not finite.
pub(crate) fn inverse(map: &Columns) -> Columns {
    let [a, b, c, at] = *map;
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant: f64 = (0..3).map(|k| a[k] * rows[0][k]).sum();
    let mut back: Columns = [[0.0; 3]; 4];
    for (row, normal) in rows.iter().enumerate() {
        for column in 0..3 {
            back[column][row] = normal[column] / determinant;
        }
    }
    let moved = linear(&back, at);
    back[3] = moved.map(|x| -x);
    back
}

/// The factor by which a map scales all lengths, or `None` if it depends on the direction.
pub(crate) fn similarity(map: &Columns) -> Option<f64> {
    let [axes @ .., _] = map;
    let dot = |p: &[f64; 3], q: &[f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let squares = [0, 1, 2].map(|k| dot(&axes[k], &axes[k]));
    let largest = squares.iter().fold(0.0f64, |most, &x| most.max(x));
    let near = |x: f64| x.abs() <= 1e-5 * largest;
    let alike = squares.iter().all(|&x| near(x - largest));
    let upright = [(0, 1), (1, 2), (2, 0)].iter().all(|&(i, j)| near(dot(&axes[i], &axes[j])));
    (alike && upright && largest > 0.0).then(|| largest.sqrt())
}

/// No length grows by more.
pub(crate) fn growth(map: &Columns) -> f64 {
    let squares: f64 = map[..3].iter().flatten().map(|x| x * x).sum();
    similarity(map).unwrap_or_else(|| squares.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: Columns = [[0.0, 2.0, 0.0], [-1.0, 0.5, 0.0], [0.0, 0.25, 3.0], [7.0, 8.0, 9.0]];

    #[test]
    fn formats_are_there_and_back_again() {
        let all = [
            format::FLOAT3X4_ROWS,
            format::FLOAT4X4_ROWS,
            format::FLOAT3X4_COLUMNS,
            format::FLOAT4X4_COLUMNS,
        ];
        for of in all {
            let values = floats(of, &MAP).expect("a format of matrices");
            assert_eq!(Some(values.len()), size(of), "{of:x}");
            assert_eq!(columns(of, &values), MAP, "{of:x}");
        }
        assert_eq!(
            floats(format::FLOAT3X4_ROWS, &MAP).expect("rows")[..4],
            [0.0, -1.0, 0.0, 7.0],
            "rows first"
        );
        assert_eq!((size(format::FLOAT), floats(format::QUATERNION, &MAP)), (None, None), "no matrices");
    }

    #[test]
    fn what_is_taken_apart_is_put_together() {
        // Scaled by 2 along x, shifted along x, rotated by a quarter around z, then moved.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let parts = [2.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, 0.0, 0.0, half, 0.0, 0.0, 5.0];
        let map = columns(format::QUATERNION, &parts);
        let at = point(&map, [1.0, 0.0, 0.0]);
        let error: f64 = [0.0, 3.0, 5.0].iter().zip(at).map(|(access, got)| (access - got).abs()).sum();
        assert!(error < 1e-6, "{at:?}: (1, 0, 0) goes to (3, 0, 0), then to (0, 3, 5)");
    }

    #[test]
    fn maps_are_undone() {
        let there = point(&MAP, [0.5, -2.0, 3.0]);
        let back = point(&inverse(&MAP), there);
        assert!((0..3).all(|k| (back[k] - [0.5, -2.0, 3.0][k]).abs() < 1e-12), "{back:?}");
        let both = after(&inverse(&MAP), &MAP);
        let off = both.iter().flatten().zip(IDENTITY.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{both:?} is nothing");
    }

    #[test]
    fn similar_maps_are_known() {
        assert_eq!(similarity(&IDENTITY), Some(1.0), "nothing");
        let turned = [[0.0, 3.0, 0.0], [0.0, 0.0, -3.0], [3.0, 0.0, 0.0], [1.0; 3]];
        assert_eq!(similarity(&turned), Some(3.0), "turned and three times as large");
        assert_eq!(similarity(&MAP), None, "sheared");
        assert!(growth(&MAP) >= 3.0, "as long as the longest axis at least");
    }
}
