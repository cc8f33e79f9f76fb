// SPDX-License-Identifier: GPL-3.0-or-later
//! Random programs against the state machine: no call panics, and failing calls change no state that can be
//! queried.

use super::{perform, small_context, visible_state};
use crate::context::Context;
use crate::state::error::Error;
use proptest::prelude::*;

/// Constants and small ids, so that calls succeed about as often as they fail.
fn argument() -> impl Strategy<Value = u32> {
    let constants: Vec<u32> =
        (0x100..0x107).chain(0x200..0x204).chain(0x600..0x603).chain(0x1700..0x1704).collect();
    prop_oneof![4 => 0_u32..6, 3 => prop::sample::select(constants), 1 => any::<u32>()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn random_programs(calls in prop::collection::vec((any::<u8>(), argument(), -9_f32..9.0), 1..200)) {
        let mut context = small_context();
        for call in calls {
            let before = visible_state(&context);
            let outcome = perform(&mut context, call);
            // Calls 11 and 12 may close an object and fail; 22, 24 and 40 are two calls.
            let is_single = ![11, 12, 22, 24, 40].contains(&(call.0 % 44));
            if let (Err(error), Some(before), true) = (outcome, before, is_single) {
                let after = visible_state(&context);
                let same = after.is_some_and(|after| {
                    after.iter().map(|x| x.to_bits()).eq(before.iter().map(|x| x.to_bits()))
                });
                prop_assert!(same, "{call:?} failed with {error} and changed something");
            }
        }
        let _ = context.end();
        prop_assert_eq!(context.exit(), Ok(()), "a program may always leave");
    }
}

#[test]
fn the_first_error_stays() {
    let mut context = Context::default();
    context.record(Error::StackOverflow);
    context.record(Error::InvalidEnum);
    assert_eq!(context.take_error(), Ok(Error::StackOverflow.code()), "the first one");
    assert_eq!(context.take_error(), Ok(Error::NONE_CODE), "reading it clears it");
}

/// Pseudorandom bytes, the same on every run (splitmix64).
fn noise(mut state: u64, length: usize) -> Vec<u8> {
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)).to_le_bytes()
    };
    (0..length.div_ceil(8)).flat_map(|_| next()).collect()
}

#[test]
fn thirty_thousand_calls() {
    (0..10).for_each(|seed| super::run(&noise(seed, 7 * 3000)));
}

/// The work of the fuzz target, without a fuzzer.
#[test]
#[ignore = "takes a minute"]
fn a_million_calls() {
    (0..100).for_each(|seed| super::run(&noise(1000 + seed, 7 * 10_000)));
}
