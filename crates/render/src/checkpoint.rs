// SPDX-License-Identifier: GPL-3.0-or-later
//! Checkpoints: an unfinished picture as bytes, so that a rendering continues later, with the same bits.
//! Layout, little-endian 64-bit words: magic, version, fingerprint, rectangle, flags, counters, then per tile
//! its samples and sums; last a checksum of all words before it. One function visits all words for reading
//! and writing. Invariants: for any bytes, reading returns or fails without a panic; sizes must match.
//! Tests: crates/render/tests/checkpoint.rs; a killed program: crates/cli/tests/program/checkpoint.rs.

use crate::accumulation::Accumulation;
use crate::error::CheckpointError;
use crate::options::RenderOptions;
use crate::state::SavedState;
use crate::stats::MOST;

const MAGIC: u64 = u64::from_le_bytes(*b"GNURTchk");
const VERSION: u64 = 7;

impl Accumulation {
    /// All its contents; `fingerprint` identifies the picture, see [`fingerprint`](crate::fingerprint()).
    #[must_use]
    pub fn to_bytes(&self, fingerprint: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut sum = 0;
        let mut put = |value: &mut u64| {
            sum = checksum(sum, *value);
            bytes.extend(value.to_le_bytes());
        };
        self.header(fingerprint).iter_mut().for_each(&mut put);
        self.stats.clone().state(&mut put);
        for tile in &self.tiles {
            tile.clone().state(&mut put);
        }
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    /// How many bytes [`to_bytes`](Self::to_bytes) gives, now and later.
    #[must_use]
    pub fn byte_count(&self) -> u64 {
        let mut state = self.header(0).len() as u64 + 1;
        let mut count = |_: &mut u64| state += 1;
        self.stats.clone().state(&mut count);
        for tile in &self.tiles {
            tile.clone().state(&mut count);
        }
        8 * state
    }

    /// Restores the output of [`to_bytes`](Self::to_bytes), to continue under `options`: equal to the
    /// original ones, except for the number of samples.
    ///
    /// # Errors
    /// [`CheckpointError`] if the bytes are no checkpoint, are damaged, belong to another picture, or hold
    /// more samples than `options` request.
    pub fn from_bytes(
        options: RenderOptions,
        fingerprint: u64,
        bytes: &[u8],
    ) -> Result<Self, CheckpointError> {
        let mut accumulation = Self::new(options).map_err(|_| CheckpointError::OtherPicture)?;
        let (state, rest) = bytes.as_chunks::<8>();
        let value = |i: usize| state.get(i).map(|value| u64::from_le_bytes(*value));
        if value(0) != Some(MAGIC) {
            return Err(CheckpointError::NoCheckpoint);
        }
        if value(1) != Some(VERSION) {
            return Err(CheckpointError::OtherVersion);
        }
        // The reader of a file need not read more than one word too many.
        if bytes.len() as u64 > accumulation.byte_count() {
            return Err(CheckpointError::OtherPicture);
        }
        let (Some(last), true) = (state.len().checked_sub(1), rest.is_empty()) else {
            return Err(CheckpointError::Damaged);
        };
        let sum = state[..last].iter().fold(0, |sum, value| checksum(sum, u64::from_le_bytes(*value)));
        if value(last) != Some(sum) {
            return Err(CheckpointError::Damaged);
        }
        let header = accumulation.header(fingerprint);
        if (0..header.len()).any(|i| value(i) != Some(header[i])) {
            return Err(CheckpointError::OtherPicture);
        }
        let mut at = header.len();
        let mut enough = true;
        let mut get = |slot: &mut u64| match value(at).filter(|_| at < last) {
            Some(value) => {
                *slot = value;
                at += 1;
            }
            None => enough = false,
        };
        accumulation.stats.state(&mut get);
        for tile in &mut accumulation.tiles {
            tile.state(&mut get);
        }
        let costs = accumulation.tiles.iter().flat_map(|tile| &tile.costs);
        let can_go_on = accumulation.stats.are_sound() && costs.max().is_none_or(|&cost| cost <= MOST);
        if !enough || at != last || !can_go_on {
            return Err(CheckpointError::Damaged);
        }
        let most = accumulation.tiles.iter().map(|tile| tile.samples).max().unwrap_or(0);
        if most > accumulation.options.spp {
            return Err(CheckpointError::MoreSamples { has: most, requested: accumulation.options.spp });
        }
        Ok(accumulation)
    }

    fn header(&self, fingerprint: u64) -> [u64; 9] {
        let [x0, y0, x1, y1] = self.region.map(u64::from);
        let flags = [self.options.aovs, self.options.heatmap, self.options.seen];
        let flags = flags.iter().rev().fold(0, |bits, &flag| bits << 1 | u64::from(flag));
        [MAGIC, VERSION, fingerprint, x0, y0, x1, y1, flags, self.tiles.len() as u64]
    }
}

fn checksum(sum: u64, value: u64) -> u64 {
    (sum ^ value).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23)
}
