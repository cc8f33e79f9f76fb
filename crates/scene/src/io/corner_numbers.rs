// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of vertices by their corners. Corners of one position are a chain, which is near in memory where faces are
//! neighbours; a chain that grows long, in a file that is made for it, goes on in a table, so that no lookup is long.
//! Tests: `tests`, `tests/obj.rs::corners_that_are_alike_are_one_vertex`, crates/usd/tests/meshes.rs.

use std::collections::HashMap;

/// Represents no link, and no vertex.
const NONE: u32 = u32::MAX;

/// Corners of a chain at most.
const LONGEST: usize = 16;

/// Vertices by their positions and `N` more numbers: those of a material, of texture coordinates, of normals.
#[derive(Debug, Default)]
pub struct CornerNumbers<const N: usize> {
    /// The first link of each position's chain; its number is [`NONE`] where there is none.
    heads: Vec<Link<N>>,
    /// The others.
    links: Vec<Link<N>>,
    /// Those beyond long chains.
    others: HashMap<(u32, [u32; N]), u32>,
}

/// A vertex of a position.
#[derive(Clone, Copy, Debug)]
struct Link<const N: usize> {
    elements: [u32; N],
    number: u32,
    /// The next link of the chain, or [`NONE`].
    next: u32,
}

impl<const N: usize> CornerNumbers<N> {
    /// About as many bytes as are held.
    pub fn memory_bytes(&self) -> usize {
        // A table has a byte for each slot, an eighth of them empty.
        size_of::<Link<N>>() * (self.heads.capacity() + self.links.capacity())
            + (4 * N + 12) * self.others.capacity()
    }

    /// Makes room for this many positions.
    #[inline]
    pub fn extend(&mut self, positions: usize) {
        if self.heads.len() < positions {
            self.heads.resize(positions, Link { elements: [NONE; N], number: NONE, next: NONE });
        }
    }

    /// The number of a corner, whose position there is room for; a new one gets `next`.
    #[inline]
    pub fn number(&mut self, position: u32, elements: [u32; N], next: u32) -> u32 {
        let head = &mut self.heads[position as usize];
        if head.number == NONE {
            *head = Link { elements, number: next, next: NONE };
            return next;
        }
        if head.elements == elements {
            return head.number;
        }
        self.number_of_others(position, elements, next)
    }

    fn number_of_others(&mut self, position: u32, elements: [u32; N], next: u32) -> u32 {
        let first = self.heads[position as usize].next;
        let (mut at, mut length) = (first, 1);
        while let Some(link) = self.links.get(at as usize) {
            if link.elements == elements {
                return link.number;
            }
            (at, length) = (link.next, length + 1);
        }
        if length >= LONGEST || self.links.len() >= NONE as usize {
            return *self.others.entry((position, elements)).or_insert(next);
        }
        self.heads[position as usize].next = self.links.len() as u32;
        self.links.push(Link { elements, number: next, next: first });
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_corner_has_one_number() {
        let mut vertices = CornerNumbers::default();
        vertices.extend(7);
        let mut expected = HashMap::new();
        let mut random = 1_u32;
        for _ in 0..20_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Many corners of few positions: chains grow long.
            let part = |shift: u32, count: u32| (random >> shift) % count;
            let elements = [part(30, 2), part(16, 30), if part(9, 3) == 0 { NONE } else { part(4, 9) }];
            let (position, next) = (part(26, 7), expected.len() as u32);
            let number = *expected.entry((position, elements)).or_insert(next);
            assert_eq!(vertices.number(position, elements, next), number, "{position}: {elements:?}");
        }
        assert!(vertices.others.len() > 100 && vertices.links.len() == 7 * (LONGEST - 1), "both are used");
        assert!(vertices.memory_bytes() > 24 * vertices.links.len());
    }
}
