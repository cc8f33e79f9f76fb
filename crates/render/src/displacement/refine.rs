// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles cut in the middle of their edges.
//! Whether an edge is cut, and where, depends on the positions of its ends alone: meshes that share edges stay together.
//! Space: object. Tests: `tests` below; crates/render/tests/displacement.rs.

use gnurt_scene::{Mesh, Rate};
use rayon::prelude::*;

/// New vertices of one pass, and the triangles after it.
pub(super) struct Cut {
    /// The ends of each edge that got a vertex, ascending.
    edges: Vec<[u32; 2]>,
    /// The edges above as they are searched for.
    keys: Vec<u64>,
}

/// An edge by its vertices, whichever way it runs.
fn key(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

impl Cut {
    /// Edges that are longer than `longest`; all for `None`. Nothing but the list of edges is made yet. `None` if there are more than
    /// `most`, as they are if each belongs to two triangles.
    pub(super) fn of(mesh: &Mesh, longest: Option<f32>, most: usize) -> Option<Self> {
        let is_long = |a: u32, b: u32| {
            let Some(longest) = longest else { return true };
            let ends = [a, b].map(|i| mesh.positions.get(i as usize));
            let [Some(a), Some(b)] = ends else { return false };
            let squared: f64 = (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum();
            squared.is_finite() && squared > f64::from(longest).powi(2)
        };
        let long = |&[a, b, c]: &[u32; 3]| {
            [[a, b], [b, c], [c, a]].into_iter().filter(|&[a, b]| is_long(a, b)).map(|[a, b]| key(a, b))
        };
        let inside = |corners: &&[u32; 3]| corners.iter().all(|&i| (i as usize) < mesh.positions.len());
        let all = || mesh.indices.iter().filter(inside).flat_map(long);
        // The list would be the first to take memory.
        if all().count() / 2 > most {
            return None;
        }
        let mut keys: Vec<u64> = all().collect();
        keys.par_sort_unstable();
        keys.dedup();
        let edges = keys.iter().map(|&key| [(key >> 32) as u32, key as u32]).collect();
        Some(Self { edges, keys })
    }

    /// How many vertices it adds.
    pub(super) fn len(&self) -> usize {
        self.edges.len()
    }

    /// The arrays of vertices after it.
    pub(super) fn grow(&self, mesh: &mut Mesh) {
        let middles = |array: &mut Vec<[f32; 3]>, is_unit: bool| {
            if array.is_empty() {
                return;
            }
            array.reserve_exact(self.edges.len());
            for &[a, b] in &self.edges {
                let (a, b) = (array[a as usize], array[b as usize]);
                array.push(if is_unit { direction(a, b) } else { middle(a, b) });
            }
        };
        middles(&mut mesh.positions, false);
        middles(&mut mesh.normals, true);
        if !mesh.texcoords.is_empty() {
            for &[a, b] in &self.edges {
                mesh.texcoords.push(middle(mesh.texcoords[a as usize], mesh.texcoords[b as usize]));
            }
        }
        if !mesh.tangents.is_empty() {
            for &[a, b] in &self.edges {
                let ([ax, ay, az, aw], [bx, by, bz, bw]) =
                    (mesh.tangents[a as usize], mesh.tangents[b as usize]);
                let [x, y, z] = direction([ax, ay, az], [bx, by, bz]);
                // Vertices that disagree on the side leave it to the texture coordinates.
                mesh.tangents.push(if aw == bw { [x, y, z, aw] } else { [0.0; 4] });
            }
        }
        if !mesh.colors.is_empty() {
            for &[a, b] in &self.edges {
                mesh.colors.push(middle(mesh.colors[a as usize], mesh.colors[b as usize]));
            }
        }
        for attribute in mesh.attributes.iter_mut().filter(|attribute| attribute.rate == Rate::Vertex) {
            let n = attribute.components as usize;
            for &[a, b] in &self.edges {
                for k in 0..n {
                    let [a, b] =
                        [a, b].map(|i| attribute.data.get(i as usize * n + k).copied().unwrap_or(0.0));
                    attribute.data.push((a + b) * 0.5);
                }
            }
        }
    }

    /// Cuts the triangles of a mesh that had `before` vertices.
    pub(super) fn cut(&self, mesh: &mut Mesh, before: usize) {
        let at = |a: u32, b: u32| self.keys.binary_search(&key(a, b)).ok().map(|i| (before + i) as u32);
        let pieces: Vec<(Vec<[u32; 3]>, Vec<u32>)> = (0u32..)
            .zip(mesh.indices.chunks(PIECE))
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(piece, triangles)| {
                let (mut made, mut parents) = (Vec::new(), Vec::new());
                for (i, &[a, b, c]) in triangles.iter().enumerate() {
                    let first = made.len();
                    template([a, b, c], [at(a, b), at(b, c), at(c, a)], &mut made);
                    parents.extend(std::iter::repeat_n(piece * PIECE as u32 + i as u32, made.len() - first));
                }
                (made, parents)
            })
            .collect();
        let of_triangles: Vec<usize> =
            (0..mesh.attributes.len()).filter(|&i| mesh.attributes[i].rate == Rate::Triangle).collect();
        for i in of_triangles {
            let attribute = &mut mesh.attributes[i];
            let n = attribute.components as usize;
            let value = |parent: &u32| {
                let from = *parent as usize * n;
                (from..from + n).map(|at| attribute.data.get(at).copied().unwrap_or(0.0))
            };
            attribute.data = pieces.iter().flat_map(|(_, parents)| parents).flat_map(value).collect();
        }
        mesh.indices = pieces.into_iter().flat_map(|(made, _)| made).collect();
    }
}

/// Triangles that a thread cuts.
const PIECE: usize = 1 << 14;

/// The pieces of a triangle, with the middles of its edges `ab`, `bc`, `ca` where they are cut; all run as it does.
fn template([a, b, c]: [u32; 3], middles: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    match middles {
        [None, None, None] => out.push([a, b, c]),
        [Some(ab), None, None] => out.extend([[a, ab, c], [ab, b, c]]),
        [None, Some(bc), None] => out.extend([[b, bc, a], [bc, c, a]]),
        [None, None, Some(ca)] => out.extend([[c, ca, b], [ca, a, b]]),
        [Some(ab), Some(bc), None] => out.extend([[ab, b, bc], [a, ab, bc], [a, bc, c]]),
        [None, Some(bc), Some(ca)] => out.extend([[bc, c, ca], [b, bc, ca], [b, ca, a]]),
        [Some(ab), None, Some(ca)] => out.extend([[ca, a, ab], [c, ca, ab], [c, ab, b]]),
        [Some(ab), Some(bc), Some(ca)] => out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
    }
}

/// The same whichever comes first.
fn middle<const N: usize>(a: [f32; N], b: [f32; N]) -> [f32; N] {
    std::array::from_fn(|k| (a[k] + b[k]) * 0.5)
}

/// Half-way between two directions, of unit length; zero where one is.
fn direction(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    let unit = |v: [f32; 3]| glam::Vec3::from(v).try_normalize();
    let (Some(a), Some(b)) = (unit(a), unit(b)) else { return [0.0; 3] };
    (a + b).normalize_or_zero().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_their_triangle() {
        let sheet = Mesh {
            positions: vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            texcoords: vec![[0.0; 2], [1.0, 0.0], [0.0, 1.0]],
            indices: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        for longest in [None, Some(4.1), Some(2.0), Some(0.9), Some(0.3)] {
            let mut mesh = sheet.clone();
            for _ in 0..6 {
                let cut = Cut::of(&mesh, longest, usize::MAX).expect("few edges");
                let before = mesh.positions.len();
                cut.grow(&mut mesh);
                cut.cut(&mut mesh, before);
            }
            let area = |&[a, b, c]: &[u32; 3]| {
                let [a, b, c] = [a, b, c].map(|i| glam::Vec3::from(mesh.positions[i as usize]));
                let cross = (b - a).cross(c - a);
                assert!(cross.z > 0.0, "they run the same way");
                cross.length() / 2.0
            };
            let whole: f32 = mesh.indices.iter().map(area).sum();
            assert!((whole - 2.0).abs() < 1e-4, "{longest:?}: area {whole}");
            let longest_now = mesh.indices.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            let longest_now = longest_now
                .map(|[a, b]| {
                    let [a, b] = [a, b].map(|i| glam::Vec3::from(mesh.positions[i as usize]));
                    a.distance(b)
                })
                .fold(0.0, f32::max);
            assert!(longest.is_none_or(|longest| longest_now <= longest), "{longest:?}: {longest_now}");
            for (p, uv) in mesh.positions.iter().zip(&mesh.texcoords) {
                assert_eq!([p[0] / 4.0, p[1]], *uv, "coordinates follow");
            }
        }
        let edges = |longest| Cut::of(&sheet, Some(longest), 1).map(|cut| cut.len());
        assert_eq!([4.2, 4.0, 0.5].map(edges), [Some(0), Some(1), Some(3)], "edges of a triangle alone");
        assert!(Cut::of(&sheet, None, 0).is_none(), "more than there may be");
    }
}
