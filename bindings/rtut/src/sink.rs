// SPDX-License-Identifier: GPL-3.0-or-later
//! Where shapes go: the few calls of OpenRT that they make. Tests: tests of the shapes.

/// How vertices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Mode {
    /// `RT_TRIANGLES`.
    Triangles = 0x100,
    /// `RT_QUADS`.
    Quads = 0x103,
    /// `RT_QUAD_STRIP`.
    QuadStrip = 0x104,
}

/// A point of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position.
    pub position: [f64; 3],
    /// Unit normal, outwards.
    pub normal: [f64; 3],
    /// s, t.
    pub texcoord: [f64; 2],
}

/// Takes blocks of vertices.
pub trait Sink {
    /// rtBegin.
    fn begin(&mut self, mode: Mode);
    /// rtTexCoord, rtNormal, rtVertex.
    fn vertex(&mut self, vertex: Vertex);
    /// rtEnd.
    fn end(&mut self);
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Collects triangles.
    #[derive(Default)]
    pub(crate) struct Mesh {
        mode: Option<Mode>,
        block: Vec<Vertex>,
        pub(crate) triangles: Vec<[Vertex; 3]>,
    }

    fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    impl Sink for Mesh {
        fn begin(&mut self, mode: Mode) {
            assert_eq!(self.mode.replace(mode), None, "blocks do not nest");
        }

        fn vertex(&mut self, vertex: Vertex) {
            self.block.push(vertex);
        }

        fn end(&mut self) {
            let mode = self.mode.take().expect("a block has begun");
            let v = std::mem::take(&mut self.block);
            let mut add = |corners: [usize; 3]| {
                let triangle = corners.map(|i| v[i]);
                if area(&triangle) > 0.0 {
                    self.triangles.push(triangle);
                }
            };
            match mode {
                Mode::Triangles => (0..v.len() / 3).for_each(|i| add([3 * i, 3 * i + 1, 3 * i + 2])),
                Mode::Quads => (0..v.len() / 4).map(|i| 4 * i).for_each(|i| {
                    add([i, i + 1, i + 3]);
                    add([i + 3, i + 1, i + 2]);
                }),
                Mode::QuadStrip => (0..(v.len() / 2).saturating_sub(1)).map(|i| 2 * i).for_each(|i| {
                    add([i, i + 1, i + 2]);
                    add([i + 2, i + 1, i + 3]);
                }),
            }
        }
    }

    /// As the library sees it: in single precision.
    fn area([a, b, c]: &[Vertex; 3]) -> f64 {
        let p = |v: &Vertex| v.position.map(|x| f64::from(x as f32));
        let n = cross(minus(p(b), p(a)), minus(p(c), p(a)));
        dot(n, n).sqrt() / 2.0
    }

    impl Mesh {
        /// Normals are unit and point to the side from which triangles are counter-clockwise.
        pub(crate) fn check_normals(&self) {
            for triangle in &self.triangles {
                let [a, b, c] = triangle.map(|v| v.position);
                let facing = cross(minus(b, a), minus(c, a));
                let mut sum = [0.0; 3];
                for vertex in triangle {
                    let length = dot(vertex.normal, vertex.normal).sqrt();
                    assert!((length - 1.0).abs() < 1e-9, "a unit normal, not {length}");
                    (0..3).for_each(|k| sum[k] += vertex.normal[k]);
                    assert!(vertex.texcoord.iter().all(|s| (-1e-9..=1.0 + 1e-9).contains(s)));
                }
                assert!(dot(facing, sum) > 0.0, "normals and winding agree at {triangle:?}");
            }
        }

        /// Every edge has one triangle on each side.
        pub(crate) fn check_closed(&self) {
            let key = |v: &Vertex| v.position.map(|x| (x * 1e6).round() as i64);
            let mut edges: BTreeMap<_, i32> = BTreeMap::new();
            for t in &self.triangles {
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    let (a, b) = (key(&t[a]), key(&t[b]));
                    *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
                    assert_ne!(a, b, "an edge has a length");
                }
            }
            let open = edges.values().filter(|&&sum| sum != 0).count();
            assert_eq!(open, 0, "edges without a neighbour");
        }

        /// Six times the volume is the sum over triangles of the triple product: positive if outside is outside.
        pub(crate) fn volume(&self) -> f64 {
            let six = |t: &[Vertex; 3]| dot(t[0].position, cross(t[1].position, t[2].position));
            self.triangles.iter().map(six).sum::<f64>() / 6.0
        }
    }
}
