// SPDX-License-Identifier: GPL-3.0-or-later
//! Polygons of a surface, and which of them meet at edges and vertices.
//! Invariant: every corner of [`Faces`] is below the number of vertices, and every face has three corners or more.
//! Tests: `tests/subdivision.rs`.

/// Polygons by the numbers of their vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faces {
    /// Where the corners of each face begin; one more at the end.
    starts: Vec<u32>,
    corners: Vec<u32>,
    vertices: usize,
}

/// Polygons that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FacesError {
    /// A face of fewer than three corners.
    #[error("face {0} has fewer than 3 corners")]
    TooFew(usize),
    /// The faces have more or fewer corners than there are vertex numbers.
    #[error("the faces have {needed} corners, but there are {given} vertex indices")]
    Corners {
        /// Corners of all faces.
        needed: u64,
        /// Numbers of vertices.
        given: usize,
    },
    /// A corner that names no vertex.
    #[error("face {face} names point {point}, but there are {points}")]
    OutOfRange {
        /// The face.
        face: usize,
        /// The number of the point that it names.
        point: i64,
        /// How many there are.
        points: usize,
    },
}

impl Faces {
    /// Faces of so many corners each.
    ///
    /// # Errors
    /// [`FacesError`]: the first mistake.
    pub fn new(counts: &[i32], corners: &[i32], vertices: usize) -> Result<Self, FacesError> {
        Self::of(counts, corners.to_vec(), vertices)
    }

    /// The same of a list that is used further.
    ///
    /// # Errors
    /// [`FacesError`]: the first mistake.
    pub fn of(counts: &[i32], corners: Vec<i32>, vertices: usize) -> Result<Self, FacesError> {
        let mut starts = Vec::with_capacity(counts.len() + 1);
        let mut sum = 0_u64;
        starts.push(0);
        for (face, &count) in counts.iter().enumerate() {
            let count = u64::try_from(count).ok().filter(|&count| count >= 3);
            sum += count.ok_or(FacesError::TooFew(face))?;
            starts.push(u32::try_from(sum).unwrap_or(u32::MAX));
        }
        if sum != corners.len() as u64 {
            return Err(FacesError::Corners { needed: sum, given: corners.len() });
        }
        let is_there = |&corner: &i32| usize::try_from(corner).is_ok_and(|corner| corner < vertices);
        if let Some(at) = corners.iter().position(|corner| !is_there(corner)) {
            let face = starts.partition_point(|&start| start as usize <= at) - 1;
            return Err(FacesError::OutOfRange { face, point: corners[at].into(), points: vertices });
        }
        let corners = corners.into_iter().map(|corner| corner as u32).collect();
        Ok(Self { starts, corners, vertices })
    }

    /// Faces of `sides` corners each, all in range.
    pub(super) fn regular(sides: u32, corners: Vec<u32>, vertices: usize) -> Self {
        let count = corners.len() as u32 / sides;
        Self { starts: (0..=count).map(|face| face * sides).collect(), corners, vertices }
    }

    /// Faces of any number of sides: where the corners of each begin, one more at the end, all in range.
    pub(super) fn of_parts(starts: Vec<u32>, corners: Vec<u32>, vertices: usize) -> Self {
        Self { starts, corners, vertices }
    }

    /// The same faces with other values at their corners, all in range.
    pub(super) fn with_corners(&self, corners: Vec<u32>, vertices: usize) -> Self {
        Self { starts: self.starts.clone(), corners, vertices }
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The vertices of all corners.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// How many vertices there are, named or not.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// The place behind the last corner of each face.
    #[must_use]
    pub fn ends(&self) -> &[u32] {
        &self.starts[1..]
    }

    /// The places of a face's corners among all corners.
    #[must_use]
    pub fn range(&self, face: usize) -> std::ops::Range<usize> {
        self.starts[face] as usize..self.starts[face + 1] as usize
    }

    /// The vertices of each face.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|face| &self.corners[self.range(face)])
    }

    /// The faces that are kept.
    pub(super) fn only(&self, keep: &[bool]) -> Self {
        let mut starts = vec![0];
        for face in (0..self.len()).filter(|&face| keep[face]) {
            starts.push(starts[starts.len() - 1] + self.range(face).len() as u32);
        }
        Self { starts, corners: self.kept(keep, &self.corners), vertices: self.vertices }
    }

    /// Values of the corners of faces that are kept.
    pub(super) fn kept(&self, keep: &[bool], values: &[u32]) -> Vec<u32> {
        (0..self.len())
            .filter(|&face| keep[face])
            .flat_map(|face| values[self.range(face)].to_vec())
            .collect()
    }
}

/// Edges of faces.
#[derive(Debug)]
pub(super) struct Topology {
    /// Their two vertices, the lower one first.
    pub(super) edges: Vec<[u32; 2]>,
    /// How many faces meet at each.
    pub(super) face_counts: Vec<u32>,
    /// The first two of them.
    pub(super) edge_faces: Vec<[u32; 2]>,
    /// By corner: the edge to the next corner of its face.
    pub(super) corner_edges: Vec<u32>,
    /// By vertex: its edges.
    vertex_edges: Lists,
    /// By vertex: its faces.
    vertex_faces: Lists,
}

/// Lists of numbers, one after the other.
#[derive(Debug)]
struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    fn new(lists: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0_u32; lists + 1];
        pairs.clone().for_each(|(list, _)| starts[list as usize + 1] += 1);
        for list in 0..lists {
            starts[list + 1] += starts[list];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[lists] as usize];
        for (list, item) in pairs {
            let at = &mut next[list as usize];
            items[*at as usize] = item;
            *at += 1;
        }
        Self { starts, items }
    }

    fn of(&self, list: usize) -> &[u32] {
        &self.items[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}

impl Topology {
    /// Builds the edges of faces, and the lists of edges and faces that meet.
    pub(super) fn new(faces: &Faces) -> Self {
        let mut keyed: Vec<(u64, u32, u32)> = Vec::with_capacity(faces.corners.len());
        for face in 0..faces.len() {
            let range = faces.range(face);
            for corner in range.clone() {
                let next = if corner + 1 == range.end { range.start } else { corner + 1 };
                let (a, b) = (faces.corners[corner], faces.corners[next]);
                let key = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
                keyed.push((key, corner as u32, face as u32));
            }
        }
        keyed.sort_unstable();
        let mut topology = Self {
            edges: Vec::new(),
            face_counts: Vec::new(),
            edge_faces: Vec::new(),
            corner_edges: vec![0; faces.corners.len()],
            vertex_edges: Lists { starts: Vec::new(), items: Vec::new() },
            vertex_faces: Lists { starts: Vec::new(), items: Vec::new() },
        };
        let mut last = None;
        for (key, corner, face) in keyed {
            if last != Some(key) {
                last = Some(key);
                topology.edges.push([(key >> 32) as u32, key as u32]);
                topology.face_counts.push(0);
                topology.edge_faces.push([face; 2]);
            }
            let edge = topology.edges.len() - 1;
            topology.face_counts[edge] += 1;
            topology.edge_faces[edge][1] = face;
            topology.corner_edges[corner as usize] = edge as u32;
        }
        let ends = topology.edges.iter().zip(0..).flat_map(|(&[a, b], edge)| [(a, edge), (b, edge)]);
        topology.vertex_edges = Lists::new(faces.vertices, ends);
        let corners = (0..faces.len())
            .flat_map(|face| faces.range(face).map(move |corner| (corner, face)))
            .map(|(corner, face)| (faces.corners[corner], face as u32));
        topology.vertex_faces = Lists::new(faces.vertices, corners);
        topology
    }

    /// How many vertices there are.
    pub(super) fn vertices(&self) -> usize {
        self.vertex_edges.starts.len() - 1
    }

    /// The edges of a vertex.
    pub(super) fn edges_of(&self, vertex: usize) -> &[u32] {
        self.vertex_edges.of(vertex)
    }

    /// The faces of a vertex.
    pub(super) fn faces_of(&self, vertex: usize) -> &[u32] {
        self.vertex_faces.of(vertex)
    }

    /// The other end of an edge.
    pub(super) fn across(&self, edge: u32, vertex: usize) -> u32 {
        let [a, b] = self.edges[edge as usize];
        if a as usize == vertex { b } else { a }
    }

    /// The place of the edge between two vertices.
    pub(super) fn edge_between(&self, a: u32, b: u32) -> Option<usize> {
        self.edges.binary_search(&[a.min(b), a.max(b)]).ok()
    }

    /// Whether the surface ends at a vertex.
    pub(super) fn is_boundary(&self, vertex: usize) -> bool {
        self.edges_of(vertex).iter().any(|&edge| self.face_counts[edge as usize] != 2)
    }

    /// Whether the faces of a vertex make one fan around it.
    pub(super) fn is_fan(&self, vertex: usize) -> bool {
        let (edges, faces) = (self.edges_of(vertex), self.faces_of(vertex).len());
        let open = edges.iter().filter(|&&edge| self.face_counts[edge as usize] == 1).count();
        let crowded = edges.iter().any(|&edge| self.face_counts[edge as usize] > 2);
        !edges.is_empty()
            && !crowded
            && matches!((open, edges.len().checked_sub(faces)), (0, Some(0)) | (2, Some(1)))
    }
}
