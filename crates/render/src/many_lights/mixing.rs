// SPDX-License-Identifier: GPL-3.0-or-later
//! A random order: points with a common choice of virtual lights have common errors, and adjacent ones would
//! show as a block. The shuffle is Fisher's and Yates's. Invariant: a function of the number of items and of
//! the seed. Tests: `tests`.

use gnurt_shading::sampling::hash_combine;

/// Puts items into an order by chance.
pub(super) fn mix<T>(items: &mut [T], seed: u32) {
    for i in (1..items.len()).rev() {
        items.swap(i, hash_combine(seed, i as u32) as usize % (i + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each item has each position with the same frequency.
    #[test]
    fn all_places_are_alike() {
        const N: usize = 8;
        const TIMES: u32 = 8000;
        let mut counts = [[0_u32; N]; N];
        for seed in 0..TIMES {
            let mut items: [usize; N] = std::array::from_fn(|i| i);
            mix(&mut items, seed);
            items.iter().enumerate().for_each(|(position, &item)| counts[item][position] += 1);
        }
        // 1000 each, six deviations at most.
        assert!(counts.iter().flatten().all(|count| count.abs_diff(1000) < 190), "{counts:?}");
        assert!(counts.iter().all(|row| row.iter().sum::<u32>() == TIMES), "none is lost");
    }
}
