// SPDX-License-Identifier: GPL-3.0-or-later
//! The limit surface of a control mesh at any point of any face: values, first and second derivatives.
//! Quadrangles that are bicubic B-splines are computed as such; others are cut, as far as a point asks for it, until the part
//! around it is one. Source: \[CC78\], the idea of \[Sta98\] without its eigenvectors. Cost: at a point of an irregular face
//! one step on a dozen faces per halving of the distance to its irregular corner. Tests: `tests/cage.rs`.

use std::sync::OnceLock;

use super::patch::{self, JET, Spline};
use super::ring::Ring;
use super::sharpness::Sharpness;
use super::surface::{Boundary, Scheme, Surface};
use super::topology::{Faces, Topology};

/// Steps after which a part of a face is taken as flat.
const MOST_STEPS: u32 = 16;
/// The same for derivatives at an irregular corner itself.
const STEPS_TO_CORNER: u32 = 10;

/// A face, or a part of one that is no quadrangle: the quadrangle at this corner after one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The face.
    pub face: u32,
    /// The corner; 0 for a quadrangle.
    pub part: u32,
}

/// A control mesh of quadrangles and other polygons by the rules of Catmull and Clark, or bilinear ones.
#[derive(Debug)]
pub struct Cage {
    surface: Surface,
    topology: Topology,
    sharpness: Sharpness,
    is_hidden: Vec<bool>,
    /// By face, once it was asked for: most are splines, whose control points take longer to find than to use.
    splines: Vec<OnceLock<Option<Box<Spline>>>>,
}

/// Vertices where faces end: those of edges with one face or more than two.
#[must_use]
pub fn boundary_vertices(faces: &Faces) -> Vec<u32> {
    let topology = Topology::new(faces);
    (0..faces.vertices() as u32).filter(|&vertex| topology.is_boundary(vertex as usize)).collect()
}

impl Cage {
    /// Prepares a surface. That of Loop's scheme is treated as Catmull and Clark's.
    #[must_use]
    pub fn new(surface: Surface) -> Self {
        let topology = Topology::new(&surface.faces);
        let sharpness = Sharpness::new(&topology, surface.boundary, &surface.creases, &surface.corners);
        let touches = |corners: &[u32]| corners.iter().any(|&vertex| topology.is_boundary(vertex as usize));
        let is_hidden = match surface.boundary {
            Boundary::None => surface.faces.iter().map(touches).collect(),
            _ => vec![false; surface.faces.len()],
        };
        let splines = (0..surface.faces.len()).map(|_| OnceLock::new()).collect();
        Self { surface, topology, sharpness, is_hidden, splines }
    }

    /// The faces.
    #[must_use]
    pub fn faces(&self) -> &Faces {
        &self.surface.faces
    }

    /// Whether a face is part of the surface and is not shown.
    #[must_use]
    pub fn is_hidden(&self, face: usize) -> bool {
        self.is_hidden[face]
    }

    /// The number of the edge from each corner to the next one of its face, by the place of the corner among all.
    #[must_use]
    pub fn edges(&self) -> &[u32] {
        &self.topology.corner_edges
    }

    /// How many edges there are.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.topology.edges.len()
    }

    /// The two vertices of an edge, the lower one first.
    #[must_use]
    pub fn ends(&self, edge: usize) -> [u32; 2] {
        self.topology.edges[edge]
    }

    /// How many faces an edge has.
    #[must_use]
    pub fn faces_of_edge(&self, edge: usize) -> u32 {
        self.topology.face_counts[edge]
    }

    /// The values of a surface at points of a face, whose `u` goes from the first corner of the place to the second and `v` to the
    /// last. `fill` writes the `width` values of a vertex. `each` gets the number of a point and six times as many: values,
    /// derivatives by u, by v, by uu, by vv, by uv. Without derivatives asked for, these are not computed.
    pub fn evaluate(
        &self,
        place: Place,
        points: &[[f64; 2]],
        width: usize,
        has_derivatives: bool,
        fill: &mut dyn FnMut(u32, &mut [f64]),
        each: &mut dyn FnMut(usize, &[f64]),
    ) {
        let face = place.face as usize;
        let corners = &self.faces().corners()[self.faces().range(face)];
        let mut search = Search { has_derivatives, jet: vec![0.0; JET * width], each };
        let all = points.iter().copied().enumerate().collect::<Vec<_>>();
        if self.surface.scheme == Scheme::Bilinear {
            let flat = flat_corners(corners, place.part as usize, width, fill);
            for (i, at) in all {
                patch::bilinear(&flat, width, at, 1.0, &mut search.jet);
                (search.each)(i, &search.jet);
            }
            return;
        }
        if let Some(spline) = self.spline(face) {
            return search.spline(&spline.points(width, &mut *fill), width, all, 1.0);
        }
        let ring = Ring::new(self.faces(), &self.topology, &self.sharpness, face, width, fill);
        if corners.len() == 4 {
            return search.run(&ring, all, 0);
        }
        let (topology, sharpness) = ring.topology();
        let part = ring.refined(&topology, &sharpness).part(place.part as usize, 0);
        search.run(&part, all, 0);
    }
}

impl Cage {
    fn spline(&self, face: usize) -> Option<&Spline> {
        let find = || {
            let &[a, b, c, d] = &self.faces().corners()[self.faces().range(face)] else { return None };
            Spline::of(self.faces(), &self.topology, &self.sharpness, face as u32, [a, b, c, d]).map(Box::new)
        };
        self.splines[face].get_or_init(find).as_deref()
    }
}

/// The four corners of a quadrangle, or of a part of another face.
fn flat_corners(
    corners: &[u32],
    part: usize,
    width: usize,
    fill: &mut dyn FnMut(u32, &mut [f64]),
) -> Vec<f64> {
    let n = corners.len();
    let mut values = vec![0.0; n * width];
    for (&vertex, values) in corners.iter().zip(values.chunks_exact_mut(width.max(1))) {
        fill(vertex, values);
    }
    if n == 4 {
        return values;
    }
    let mean =
        |of: &[usize], k: usize| of.iter().map(|i| values[i * width + k]).sum::<f64>() / of.len() as f64;
    let all: Vec<usize> = (0..n).collect();
    let four: [&[usize]; 4] = [&[part], &[part, (part + 1) % n], &all, &[(part + n - 1) % n, part]];
    four.iter().flat_map(|of| (0..width).map(move |k| (of, k))).map(|(of, k)| mean(of, k)).collect()
}

/// A way down to parts that can be computed.
struct Search<'a> {
    has_derivatives: bool,
    jet: Vec<f64>,
    each: &'a mut dyn FnMut(usize, &[f64]),
}

impl Search<'_> {
    fn spline(&mut self, spline: &[f64], width: usize, points: Vec<(usize, [f64; 2])>, scale: f64) {
        let parts = if self.has_derivatives { JET } else { 1 };
        for (i, at) in points {
            patch::spline(spline, width, at, scale, &mut self.jet[..parts * width]);
            (self.each)(i, &self.jet);
        }
    }

    fn run(&mut self, ring: &Ring, points: Vec<(usize, [f64; 2])>, steps: u32) {
        let scale = f64::from(1_u32 << steps);
        let (topology, sharpness) = ring.topology();
        if let Some(spline) = ring.control_points(&topology, &sharpness) {
            return self.spline(&spline, ring.width, points, scale);
        }
        let is_at_corner = |&(_, at): &(usize, [f64; 2])| at.iter().all(|&x| x == 0.0 || x == 1.0);
        let most = if points.iter().all(is_at_corner) { STEPS_TO_CORNER } else { MOST_STEPS };
        let is_end = steps >= most;
        let is_limit = !self.has_derivatives && ring.is_settled(&topology, &sharpness);
        let (ends, rest): (Vec<_>, Vec<_>) =
            points.into_iter().partition(|point| is_end || (is_limit && is_at_corner(point)));
        if !ends.is_empty() {
            let limits = ring.limits(&topology, &sharpness);
            for (i, at) in ends {
                patch::bilinear(&limits, ring.width, at, scale, &mut self.jet);
                (self.each)(i, &self.jet);
            }
        }
        if rest.is_empty() {
            return;
        }
        let finer = ring.refined(&topology, &sharpness);
        let mut parts: [Vec<(usize, [f64; 2])>; 4] = Default::default();
        for (i, [u, v]) in rest {
            let (right, upper) = (u >= 0.5, v >= 0.5);
            let part = match (right, upper) {
                (false, false) => 0,
                (true, false) => 1,
                (true, true) => 2,
                (false, true) => 3,
            };
            let inner = |x: f64, is_far: bool| 2.0 * x - f64::from(u8::from(is_far));
            parts[part].push((i, [inner(u, right), inner(v, upper)]));
        }
        for (part, points) in parts.into_iter().enumerate().filter(|(_, points)| !points.is_empty()) {
            self.run(&finer.part(ring.center[part] as usize, part), points, steps + 1);
        }
    }
}
