// SPDX-License-Identifier: GPL-3.0-or-later
//! Steps and blends.
//! Source: the OSL 1.14 language reference, "Pattern generation".
//! Tests: `tests/mathematics.rs`, `tests/derivatives.rs`.

use super::arithmetic::{abs, clamp, div};
use crate::number::{Number, Real};

/// 0 below the edge, 1 from it on.
#[inline(always)]
pub fn step<R: Real>(edge: R, x: R) -> R {
    R::choose(x.less(edge), x.of(0.0), x.of(1.0))
}

/// 0 below `low`, 1 from `high` on, a smooth cubic between.
#[inline(always)]
pub fn smoothstep<N: Number>(low: N, high: N, x: N) -> N {
    let t = div(x - low, high - low);
    let smooth = (t * 2.0).subtracted_from(3.0) * (t * t);
    let (below, beyond) = (x.value().less(low.value()), high.value().at_most(x.value()));
    N::pick(below, x.constant(0.0), N::pick(beyond, x.constant(1.0), smooth))
}

/// 0 below `low`, 1 from `high` on, linear between; a [`step`] where they are equal.
#[inline(always)]
pub fn linearstep<N: Number>(low: N, high: N, x: N) -> N {
    let ramp = clamp(div(x - low, high - low), x.constant(0.0), x.constant(1.0));
    N::pick(low.value().equal(high.value()), N::lift(step(low.value(), x.value())), ramp)
}

/// [`linearstep`] whose corners are rounded within `width` of them.
#[inline(always)]
pub fn smooth_linearstep<N: Number>(low: N, high: N, x: N, width: N) -> N {
    let inverse = div(x.constant(1.0), high - low);
    let eps = width * inverse;
    let at = (x - low) * inverse;
    let rampup = |x: N, r: N| div(x.constant(0.5), r) * x * x;
    let rising = rampup(at + eps, eps * 2.0);
    let falling = rampup((eps + 1.0) - at, eps * 2.0).subtracted_from(1.0);
    let (e, p) = (eps.value(), at.value());
    let one = p.of(1.0);
    let middle = e.at_most(p) & p.at_most(one - e);
    let rest = N::pick(p.less(e), rising, falling);
    let rest = N::pick(one.at_most(p - e), x.constant(1.0), rest);
    let rest = N::pick(middle, at, rest);
    let ramp = N::pick(p.at_most(-e), x.constant(0.0), rest);
    N::pick(low.value().equal(high.value()), N::lift(step(low.value(), x.value())), ramp)
}

/// A step at `edge`, filtered by a box as wide as both change from pixel to pixel.
#[inline(always)]
pub fn aastep<N: Number>(edge: N, s: N, edge_width: N, s_width: N) -> N {
    let width = abs(edge_width) + abs(s_width);
    let half = width * 0.5;
    let (start, end) = (edge - half, edge + half);
    let ramp = div(s - start, width);
    let rest = N::pick(end.value().at_most(s.value()), s.constant(1.0), ramp);
    N::pick(s.value().at_most(start.value()), s.constant(0.0), rest)
}

/// How much a number changes from this pixel to the next ones.
#[inline(always)]
pub fn filterwidth<R: Real>(dx: R, dy: R) -> R {
    (dx * dx + dy * dy).sqrt()
}

/// x (1 - a) + y a.
#[inline(always)]
pub fn mix<N: Number>(x: N, y: N, a: N) -> N {
    x * a.subtracted_from(1.0) + y * a
}

/// `y` where the condition is not 0, else `x`: OSL's order.
#[inline(always)]
pub fn select<N: Number>(x: N, y: N, condition: N::Real) -> N {
    N::pick(condition.equal(condition.of(0.0)), x, y)
}
