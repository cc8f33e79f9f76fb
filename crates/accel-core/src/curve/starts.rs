// SPDX-License-Identifier: GPL-3.0-or-later
//! The first vertices of curves in few bytes, so that they stay in the cache: curves of a strand follow each other by one vertex,
//! and from strand to strand there is always the same jump. Tests: `tests::starts_are_the_indices`.

/// First vertices, where they follow that rule. A hint for requests of memory: indices themselves are read later.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    /// Of 64 curves: the first one's vertex, and by bits which of them begin a strand, the first one aside.
    groups: Vec<(u32, u64)>,
    /// Vertices that are left out where a strand begins.
    jump: u32,
}

impl Starts {
    /// Of all indices; empty where they do not follow the rule.
    pub fn new(indices: &[u32]) -> Self {
        let (mut groups, mut jump) = (Vec::with_capacity(indices.len().div_ceil(64)), 0);
        for group in indices.chunks(64) {
            let mut begins = 0;
            for (i, two) in (1..).zip(group.windows(2)) {
                let own = two[1].wrapping_sub(two[0]).wrapping_sub(1);
                if own == 0 {
                    continue;
                }
                if jump != 0 && jump != own {
                    return Self::default();
                }
                (jump, begins) = (own, begins | 1u64 << i);
            }
            groups.push((group[0], begins));
        }
        Self { groups, jump }
    }

    /// The first vertex of a curve, if it is known.
    #[inline(always)]
    pub fn get(&self, prim_id: u32) -> Option<u32> {
        let &(first, begins) = self.groups.get(prim_id as usize / 64)?;
        let i = prim_id % 64;
        let strands = (begins << (63 - i)).count_ones();
        Some(first.wrapping_add(i).wrapping_add(strands.wrapping_mul(self.jump)))
    }

    /// Bytes of it.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.groups[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_the_indices() {
        let mut indices = Vec::new();
        let mut vertex = 5;
        for strand in 0..90 {
            for _ in 0..1 + strand * 7 % 11 {
                indices.push(vertex);
                vertex += 1;
            }
            vertex += 3;
        }
        let starts = Starts::new(&indices);
        for (prim_id, &index) in (0..).zip(&indices) {
            assert_eq!(starts.get(prim_id), Some(index), "curve {prim_id}");
        }
        assert!(starts.memory_bytes() * 10 < 4 * indices.len(), "few bytes: {}", starts.memory_bytes());
        indices[70] += 1;
        assert_eq!(Starts::new(&indices).get(3), None, "another rule");
        assert_eq!(Starts::new(&[]).get(0), None, "nothing");
    }
}
