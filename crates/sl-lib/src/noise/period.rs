// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise that repeats: coordinates wrapped into a period. Source: OSL 1.14. Tests: `tests/noise.rs`.

use crate::number::{Real, UInts};

/// Coordinates moved by whole periods to [0, period). Periods are rounded down and at least 1.
#[inline(always)]
pub(super) fn wrap<R: Real, const N: usize>(p: [R; N], period: [R; N]) -> [R; N] {
    let mut out = p;
    for i in 0..N {
        let (whole, one) = (period[i].floor(), period[i].of(1.0));
        let whole = R::choose(whole.less(one), one, whole);
        out[i] = p[i] - whole * (p[i] / whole).floor();
    }
    out
}

/// Periods as whole numbers of at least 1, for [`UInts::wrapped`].
#[inline(always)]
pub(super) fn whole_periods<R: Real, const N: usize>(period: [R; N]) -> [R::UInts; N] {
    let mut periods = [period[0].bits(); N];
    for (whole, period) in periods.iter_mut().zip(period) {
        let floor = period.floor_int();
        *whole = floor.signed_max(floor.constant(1));
    }
    periods
}
