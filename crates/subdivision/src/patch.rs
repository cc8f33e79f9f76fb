// SPDX-License-Identifier: GPL-3.0-or-later
//! A quadrangle whose limit is a uniform bicubic B-spline, and the values and derivatives of that.
//! At sides that are sharp forever, rows of control points behind the side are mirrored, which gives the crease's rules
//! exactly. Source: \[CC78\]; the control points of boundaries follow from the masks of \[DKT98\]. Tests: `tests/cage.rs`.

use super::sharpness::{FOREVER, Rule, Sharpness};
use super::topology::{Faces, Topology};

/// Values, first derivatives by u and v, second ones by uu, vv and uv: one after the other.
pub(super) const JET: usize = 6;

/// A side of the quadrangle.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    /// With a quadrangle behind it: the vertices there, beside the side's first vertex and its second.
    Smooth { face: u32, beside: [u32; 2] },
    /// Sharp forever.
    Sharp,
}

/// Places of control points: column by u, row by v.
const CORNERS: [[usize; 2]; 4] = [[1, 1], [2, 1], [2, 2], [1, 2]];

const NO_VERTEX: u32 = u32::MAX;

/// A quadrangle whose limit is a B-spline.
#[derive(Debug)]
pub(super) struct Spline {
    /// By column and row; those behind sharp sides are mirrored, and have no vertex ([`NO_VERTEX`]).
    vertices: [u32; 16],
    /// Which sides are sharp: below, right, above, left.
    is_sharp: [bool; 4],
}

/// Steps outwards from a side, by its first corner.
const OUTWARDS: [[isize; 2]; 4] = [[0, -1], [1, 0], [0, 1], [-1, 0]];

fn step([column, row]: [usize; 2], [x, y]: [isize; 2]) -> [usize; 2] {
    [column.wrapping_add_signed(x), row.wrapping_add_signed(y)]
}

impl Spline {
    /// Of a face, its corners beginning where parameters are 0; `None` where its limit is another surface.
    pub(super) fn of(
        faces: &Faces,
        topology: &Topology,
        sharpness: &Sharpness,
        face: u32,
        center: [u32; 4],
    ) -> Option<Self> {
        let mesh = Mesh { faces, topology, sharpness, face, center };
        let mut sides = [Side::Sharp; 4];
        for (at, side) in sides.iter_mut().enumerate() {
            *side = mesh.side(at)?;
        }
        let mut vertices = [NO_VERTEX; 16];
        let mut put = |[column, row]: [usize; 2], vertex: u32| vertices[4 * row + column] = vertex;
        for (at, own) in CORNERS.into_iter().enumerate() {
            let before = (at + 3) % 4;
            let diagonal = mesh.corner([sides[before], sides[at]], at)?;
            put(own, center[at]);
            if let Some(vertex) = diagonal {
                put(step(step(own, OUTWARDS[at]), OUTWARDS[before]), vertex);
            }
            if let Side::Smooth { beside, .. } = sides[at] {
                put(step(own, OUTWARDS[at]), beside[0]);
                put(step(CORNERS[(at + 1) % 4], OUTWARDS[at]), beside[1]);
            }
        }
        Some(Self { vertices, is_sharp: sides.map(|side| side == Side::Sharp) })
    }

    /// Sixteen control points of `width` numbers each; `fill` writes those of a vertex.
    pub(super) fn points(&self, width: usize, mut fill: impl FnMut(u32, &mut [f64])) -> Vec<f64> {
        let mut points = vec![0.0; 16 * width];
        for (vertex, values) in self.vertices.iter().zip(points.chunks_exact_mut(width.max(1))) {
            if *vertex != NO_VERTEX {
                fill(*vertex, values);
            }
        }
        let place = |[column, row]: [usize; 2]| (4 * row + column) * width;
        let mut mirror = |on: [usize; 2], [x, y]: [isize; 2]| {
            let (out, inner) = (place(step(on, [x, y])), place(step(on, [-x, -y])));
            for k in 0..width {
                points[out + k] = 2.0 * points[place(on) + k] - points[inner + k];
            }
        };
        for at in (0..4).filter(|&at| self.is_sharp[at]) {
            mirror(CORNERS[at], OUTWARDS[at]);
            mirror(CORNERS[(at + 1) % 4], OUTWARDS[at]);
        }
        // Corners last: a side's row goes on beyond its ends.
        for (at, own) in CORNERS.into_iter().enumerate() {
            let before = (at + 3) % 4;
            if self.is_sharp[at] {
                mirror(step(own, OUTWARDS[before]), OUTWARDS[at]);
            } else if self.is_sharp[before] {
                mirror(step(own, OUTWARDS[at]), OUTWARDS[before]);
            }
        }
        points
    }
}

/// A quadrangle in its mesh.
struct Mesh<'a> {
    faces: &'a Faces,
    topology: &'a Topology,
    sharpness: &'a Sharpness,
    face: u32,
    center: [u32; 4],
}

impl Mesh<'_> {
    /// A side; `None` where it is neither smooth with a quadrangle behind it nor sharp forever.
    fn side(&self, at: usize) -> Option<Side> {
        let Self { topology, sharpness, .. } = *self;
        let [a, b] = [self.center[at], self.center[(at + 1) % 4]];
        let edge = topology.edge_between(a, b)?;
        let sharp = sharpness.of_edge(edge);
        if sharp >= FOREVER {
            return Some(Side::Sharp);
        }
        let face = topology.edge_faces[edge].into_iter().find(|&face| face != self.face)?;
        let corners = self.corners(face);
        if sharp > 0.0 || topology.face_counts[edge] != 2 || corners.len() != 4 {
            return None;
        }
        let beside = |vertex: u32, other: u32| {
            let i = corners.iter().position(|&corner| corner == vertex)?;
            [corners[(i + 1) % 4], corners[(i + 3) % 4]].into_iter().find(|&next| next != other)
        };
        Some(Side::Smooth { face, beside: [beside(a, b)?, beside(b, a)?] })
    }

    /// The control point behind a corner, where there is one; the outer `None` where the corner's rule is no spline's.
    fn corner(&self, [before, after]: [Side; 2], at: usize) -> Option<Option<u32>> {
        let Self { topology, sharpness, .. } = *self;
        let vertex = self.center[at];
        let i = vertex as usize;
        let rule = sharpness.rule(topology, i, |sharpness| sharpness);
        let faces = topology.faces_of(i);
        match (before, after) {
            (Side::Smooth { face: first, .. }, Side::Smooth { face: second, .. }) => {
                let is_smooth = rule == Rule::Smooth
                    && topology.edges_of(i).iter().all(|&edge| sharpness.of_edge(edge as usize) == 0.0);
                if !is_smooth || faces.len() != 4 || topology.edges_of(i).len() != 4 {
                    return None;
                }
                let across =
                    *faces.iter().find(|&&face| face != self.face && face != first && face != second)?;
                let corners = self.corners(across);
                let place = corners.iter().position(|&corner| corner == vertex)?;
                (corners.len() == 4).then(|| Some(corners[(place + 2) % 4]))
            }
            (Side::Sharp, Side::Sharp) => {
                let edges = topology.edges_of(i);
                let sharp = edges.iter().filter(|&&edge| sharpness.of_edge(edge as usize) >= FOREVER).count();
                let stays = sharpness.is_torn(i) || sharpness.of_vertex(i) >= FOREVER || sharp > 2;
                stays.then_some(None)
            }
            (Side::Smooth { beside, .. }, Side::Sharp) => {
                let (own, on) = (self.center[(at + 1) % 4], beside[1]);
                self.goes_on(vertex, rule, [own, on]).then_some(None)
            }
            (Side::Sharp, Side::Smooth { beside, .. }) => {
                let (own, on) = (self.center[(at + 3) % 4], beside[0]);
                self.goes_on(vertex, rule, [own, on]).then_some(None)
            }
        }
    }

    /// Whether a crease goes through a vertex from one end to the other, forever.
    fn goes_on(&self, vertex: u32, rule: Rule, ends: [u32; 2]) -> bool {
        let Self { topology, sharpness, .. } = *self;
        let is_sharp = |end: u32| {
            topology.edge_between(vertex, end).is_some_and(|edge| sharpness.of_edge(edge) >= FOREVER)
        };
        let is_both = matches!(rule, Rule::Crease(found) if found == ends || found == [ends[1], ends[0]]);
        is_both && ends.into_iter().all(is_sharp)
    }

    fn corners(&self, face: u32) -> &[u32] {
        &self.faces.corners()[self.faces.range(face as usize)]
    }
}

/// The weights of four control points and their first and second derivatives.
fn basis(t: f64) -> [[f64; 4]; 3] {
    let s = 1.0 - t;
    [
        [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
            t * t * t / 6.0,
        ],
        [-0.5 * s * s, 1.5 * t * t - 2.0 * t, -1.5 * s * s + 2.0 * s, 0.5 * t * t],
        [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
    ]
}

/// Writes the jet of a bicubic patch, or as many parts of it as there is room; `scale` is by how much its parameters are finer
/// than those of the whole.
pub(super) fn spline(points: &[f64], width: usize, [u, v]: [f64; 2], scale: f64, jet: &mut [f64]) {
    // Orders by u and v of values, derivatives by u, v, uu, vv, uv.
    const ORDERS: [[usize; 2]; JET] = [[0, 0], [1, 0], [0, 1], [2, 0], [0, 2], [1, 1]];
    let (by_u, by_v) = (basis(u), basis(v));
    let parts = if jet.len() > width { JET } else { 1 };
    for k in 0..width {
        // By order and column: along v. Written out, for arrays' `map` is not always inlined.
        let mut along = [[0.0; 4]; 3];
        for row in 0..4 {
            for column in 0..4 {
                let x = points[(4 * row + column) * width + k];
                along[0][column] += by_v[0][row] * x;
                along[1][column] += by_v[1][row] * x;
                along[2][column] += by_v[2][row] * x;
            }
        }
        for (part, [a, b]) in ORDERS.iter().enumerate().take(parts) {
            let (weights, values) = (&by_u[*a], &along[*b]);
            jet[part * width + k] = weights[0] * values[0]
                + weights[1] * values[1]
                + weights[2] * values[2]
                + weights[3] * values[3];
        }
    }
    if jet.len() > width {
        scale_jet(jet, width, scale);
    }
}

/// The same of a bilinear patch of four corners, one after the other.
pub(super) fn bilinear(corners: &[f64], width: usize, [u, v]: [f64; 2], scale: f64, jet: &mut [f64]) {
    for k in 0..width {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| corners[corner * width + k]);
        let twist = a - b + c - d;
        let values = [a + u * (b - a) + v * (d - a) + u * v * twist, b - a + v * twist, d - a + u * twist];
        for (i, x) in values.into_iter().chain([0.0, 0.0, twist]).enumerate() {
            jet[i * width + k] = x;
        }
    }
    scale_jet(jet, width, scale);
}

fn scale_jet(jet: &mut [f64], width: usize, scale: f64) {
    jet[width..3 * width].iter_mut().for_each(|x| *x *= scale);
    jet[3 * width..].iter_mut().for_each(|x| *x *= scale * scale);
}
