// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of vertices by their corners. Corners of one position are a chain, which is near in memory where faces are
//! neighbours; a chain that grows long, in a file that is made for it, goes on in a table, so that no lookup is long.
//! Tests: `tests`, `tests/obj.rs::corners_that_are_alike_are_one_vertex`.

use std::collections::HashMap;

/// Represents a missing texture coordinate or normal.
pub(super) const NONE: u32 = u32::MAX;

/// Indices of a corner's position, texture coordinate and normal in the lists, from 0.
pub(super) type Corner = [u32; 3];

/// The number of a material, and a corner.
type Key = (u32, Corner);

/// Corners of a chain at most.
const LONGEST: usize = 16;

/// Vertices by their keys.
#[derive(Default)]
pub(super) struct Vertices {
    /// The first link of each position's chain; its number is [`NONE`] where there is none.
    heads: Vec<Link>,
    /// The others.
    links: Vec<Link>,
    /// Those beyond long chains.
    others: HashMap<Key, u32>,
}

/// A vertex of a position.
#[derive(Clone, Copy)]
struct Link {
    material: u32,
    texcoord: u32,
    normal: u32,
    number: u32,
    /// The next link of the chain, or [`NONE`].
    next: u32,
}

impl Link {
    const EMPTY: Self = Self { material: NONE, texcoord: NONE, normal: NONE, number: NONE, next: NONE };

    #[inline]
    fn is_of(&self, (material, [_, texcoord, normal]): Key) -> bool {
        (self.material, self.texcoord, self.normal) == (material, texcoord, normal)
    }
}

impl Vertices {
    /// About as many bytes as are held.
    pub(super) fn memory_bytes(&self) -> usize {
        // A table has a byte for each slot, an eighth of them empty.
        size_of::<Link>() * (self.heads.capacity() + self.links.capacity()) + 24 * self.others.capacity()
    }

    /// Makes room for this many positions.
    #[inline]
    pub(super) fn extend(&mut self, positions: usize) {
        if self.heads.len() < positions {
            self.heads.resize(positions, Link::EMPTY);
        }
    }

    /// The number of a key, whose position there is room for; a new one gets `next`.
    #[inline]
    pub(super) fn number(&mut self, key: Key, next: u32) -> u32 {
        let (material, [position, texcoord, normal]) = key;
        let new = Link { material, texcoord, normal, number: next, next: NONE };
        let head = &mut self.heads[position as usize];
        if head.number == NONE {
            *head = new;
            return next;
        }
        if head.is_of(key) {
            return head.number;
        }
        self.number_of_others(key, new)
    }

    fn number_of_others(&mut self, key: Key, new: Link) -> u32 {
        let position = key.1[0] as usize;
        let first = self.heads[position].next;
        let (mut at, mut length) = (first, 1);
        while let Some(link) = self.links.get(at as usize) {
            if link.is_of(key) {
                return link.number;
            }
            (at, length) = (link.next, length + 1);
        }
        if length >= LONGEST || self.links.len() >= NONE as usize {
            return *self.others.entry(key).or_insert(new.number);
        }
        self.heads[position].next = self.links.len() as u32;
        self.links.push(Link { next: first, ..new });
        new.number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_has_one_number() {
        let mut vertices = Vertices::default();
        vertices.extend(7);
        let mut expected: HashMap<Key, u32> = HashMap::new();
        let mut random = 1_u32;
        for _ in 0..20_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Many corners of few positions: chains grow long.
            let part = |shift: u32, count: u32| (random >> shift) % count;
            let key =
                (part(30, 2), [part(26, 7), part(16, 30), if part(9, 3) == 0 { NONE } else { part(4, 9) }]);
            let next = expected.len() as u32;
            let number = *expected.entry(key).or_insert(next);
            assert_eq!(vertices.number(key, next), number, "{key:?}");
        }
        assert!(vertices.others.len() > 100 && vertices.links.len() == 7 * (LONGEST - 1), "both are used");
        assert!(vertices.memory_bytes() > 24 * vertices.links.len());
    }
}
