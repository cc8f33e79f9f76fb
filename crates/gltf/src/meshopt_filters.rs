// SPDX-License-Identifier: GPL-3.0-or-later
//! Filters behind meshoptimizer's codec of attributes: directions, rotations, floats and colours in fewer bits.
//! Source: EXT_meshopt_compression and KHR_meshopt_compression, appendix B. Tests: `tests`,
//! `tests/extensions.rs::compressed_views_agree`.

/// Undoes the filter `name` for elements of `stride` bytes; the error gives the fault.
pub(super) fn filter(name: &str, stride: usize, bytes: &mut [u8]) -> Result<(), String> {
    match (name, stride) {
        ("OCTAHEDRAL", 4) => each::<i8, 4>(bytes, octahedral),
        ("OCTAHEDRAL", 8) => each::<i16, 8>(bytes, octahedral),
        ("QUATERNION", 8) => each::<i16, 8>(bytes, quaternion),
        ("COLOR", 4) => each::<u8, 4>(bytes, color),
        ("COLOR", 8) => each::<u16, 8>(bytes, color),
        ("EXPONENTIAL", _) => {
            for word in bytes.chunks_exact_mut(4) {
                let packed = i32::from_le_bytes([word[0], word[1], word[2], word[3]]);
                let value = f64::from(packed << 8 >> 8) * f64::from(packed >> 24).exp2();
                word.copy_from_slice(&(value as f32).to_le_bytes());
            }
        }
        _ => return Err(format!("filter {name} of {stride} bytes")),
    }
    Ok(())
}

/// An integer of one or two bytes.
trait Part: Copy {
    /// 1 as a normalized number.
    const ONE: f32;
    fn from_bytes(bytes: &[u8]) -> Self;
    fn put(self, to: &mut [u8]);
    fn float(self) -> f32;
    fn of(value: f32) -> Self;
    /// Its bits as a signed number.
    fn signed(self) -> i32;
    /// Its bits as a number without a sign.
    fn unsigned(self) -> i32;
}

macro_rules! parts {
    ($($type:ty, $signed:ty, $unsigned:ty);*) => {$(
        impl Part for $type {
            const ONE: f32 = <$type>::MAX as f32;

            fn from_bytes(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$type>()];
                own.copy_from_slice(bytes);
                <$type>::from_le_bytes(own)
            }

            fn put(self, to: &mut [u8]) {
                to.copy_from_slice(&self.to_le_bytes());
            }

            fn float(self) -> f32 {
                f32::from(self)
            }

            fn of(value: f32) -> Self {
                value.round() as $type
            }

            fn signed(self) -> i32 {
                i32::from(self as $signed)
            }

            fn unsigned(self) -> i32 {
                i32::from(self as $unsigned)
            }
        }
    )*};
}

parts!(i8, i8, u8; i16, i16, u16; u8, i8, u8; u16, i16, u16);

/// Replaces all elements of `N` bytes.
fn each<T: Part, const N: usize>(bytes: &mut [u8], to: fn([T; 4]) -> [T; 4]) {
    for element in bytes.chunks_exact_mut(N) {
        let made = to([0, 1, 2, 3].map(|k| T::from_bytes(&element[k * N / 4..][..N / 4])));
        made.into_iter().zip(element.chunks_exact_mut(N / 4)).for_each(|(value, to)| value.put(to));
    }
}

/// A unit vector from the octahedron that it was projected to; the fourth number stays.
fn octahedral<T: Part>(from: [T; 4]) -> [T; 4] {
    let one = from[2].float();
    let (x, y) = (from[0].float() / one, from[1].float() / one);
    let z = 1.0 - x.abs() - y.abs();
    let below = z.min(0.0);
    let (x, y) = (x - below.copysign(x), y - below.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|part| T::of(part / length * T::ONE));
    [x, y, z, from[3]]
}

/// A rotation from its three smaller numbers.
fn quaternion(from: [i16; 4]) -> [i16; 4] {
    let one = f32::from(from[3] | 3);
    let [x, y, z] = [0, 1, 2].map(|k| f32::from(from[k]) / one * std::f32::consts::FRAC_1_SQRT_2);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = usize::from(from[3] as u16 & 3);
    let mut out = [0; 4];
    for (k, part) in [w, x, y, z].into_iter().enumerate() {
        out[(largest + k) % 4] = i16::of(part * 32767.0);
    }
    out
}

/// Red, green and blue from luma and two differences; the highest bit of the opacity marks the precision.
fn color<T: Part>(from: [T; 4]) -> [T; 4] {
    let [y, a] = [from[0], from[3]].map(T::unsigned);
    let [co, cg] = [from[1], from[2]].map(T::signed);
    let bits = 32 - a.leading_zeros();
    let most = (1 << bits) - 1;
    let a = a & (most >> 1);
    let scale = T::ONE / (most as f32).max(1.0);
    [y + co - cg, y + cg, y - co - cg, (a << 1) | (a & 1)].map(|part| T::of(part as f32 * scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_follow_their_formulas() {
        let one = |name: &str, bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            filter(name, bytes.len(), &mut bytes).expect("a filter");
            bytes
        };
        assert_eq!(one("OCTAHEDRAL", &[0, 0, 127, 9]), [0, 0, 127, 9], "up");
        assert_eq!(one("OCTAHEDRAL", &[127, 0, 127, 0]), [127, 0, 0, 0], "along x");
        // The corner of the octahedron's lower half.
        assert_eq!(one("OCTAHEDRAL", &[127, 127, 127, 0])[2] as i8, -127, "down");
        let turn = one("QUATERNION", &[0, 0, 0, 0, 0, 0, 0xff, 0x7f]);
        assert_eq!(turn, [0, 0, 0, 0, 0, 0, 0xff, 0x7f], "w is the largest: no rotation");
        assert_eq!(one("EXPONENTIAL", &[3, 0, 0, 0xfe]), 0.75_f32.to_le_bytes(), "three quarters");
        assert_eq!(one("EXPONENTIAL", &[0xff, 0xff, 0xff, 1]), (-2.0_f32).to_le_bytes(), "minus two");
        assert_eq!(one("COLOR", &[255, 0, 0, 255]), [255; 4], "white");
        assert_eq!(one("COLOR", &[64, 127, 192, 0xc0]), [255, 0, 1, 128], "orange");
        assert!(filter("COLOR", 12, &mut [0; 12]).is_err() && filter("NEW", 4, &mut [0; 4]).is_err(), "none");
    }
}
