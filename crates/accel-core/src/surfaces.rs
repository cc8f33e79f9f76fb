// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the corners of an object's triangles are found: meshes of triangles and of quads under one numbering.
//! Space: object. Tests: `valid_triangles::tests`, `tests/refit.rs` of `gnurt-accel`.

use std::ops::Range;

use crate::geometry::{BadPrimitives, Geometry, GeometryKind, Numbering, Quads, Triangles, geometry_of};

/// Triangles of some geometries under the object's numbers, the halves of quads among them. Any of them may be bad.
pub struct Surfaces<'a> {
    pub(crate) meshes: Vec<Surface<'a>>,
    /// First number of each geometry, and one past the last.
    pub starts: Vec<u32>,
}

/// The source of the triangles of one geometry.
#[derive(Clone, Copy)]
pub(crate) enum Surface<'a> {
    Triangles(Triangles<'a>),
    Quads(Quads<'a>),
    /// Another kind, or for another tree.
    None,
}

/// The triangles of one geometry, by their numbers.
#[derive(Clone, Copy)]
pub struct Mesh<'a> {
    surface: Surface<'a>,
    /// Numbers that it holds.
    start: u32,
    end: u32,
}

impl<'a> Surfaces<'a> {
    /// Those of the geometries that are `accept`.
    pub fn new(
        geometries: &[Geometry<'a>],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
    ) -> Self {
        let surface = |geometry: &Geometry<'a>| match &geometry.kind {
            GeometryKind::Triangles(mesh) if accept(geometry) => Surface::Triangles(*mesh),
            GeometryKind::Quads(mesh) if accept(geometry) => Surface::Quads(*mesh),
            _ => Surface::None,
        };
        Self { meshes: geometries.iter().map(surface).collect(), starts: numbering.starts.clone() }
    }

    /// Those of moving meshes that are `accept`, at a key that all of them have.
    pub fn at_key(
        geometries: &[Geometry<'a>],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
        key: usize,
    ) -> Self {
        let surface = |geometry: &Geometry<'a>| match &geometry.kind {
            GeometryKind::Moving(mesh) if accept(geometry) => Surface::Triangles(mesh.at_key(key)),
            GeometryKind::MovingQuads(mesh) if accept(geometry) => Surface::Quads(mesh.at_key(key)),
            _ => Surface::None,
        };
        Self { meshes: geometries.iter().map(surface).collect(), starts: numbering.starts.clone() }
    }

    /// The numbers of all its triangles, good and bad, geometry by geometry.
    pub fn numbers(&self) -> impl Iterator<Item = Range<u32>> + '_ {
        let some = |&(i, surface): &(usize, &Surface)| {
            (!matches!(surface, Surface::None)).then(|| self.starts[i]..self.starts[i + 1])
        };
        self.meshes.iter().enumerate().filter_map(move |one| some(&one))
    }

    /// The mesh that holds a number.
    pub fn mesh(&self, number: u32) -> Mesh<'a> {
        let geometry = geometry_of(&self.starts, number);
        Mesh { surface: self.meshes[geometry], start: self.starts[geometry], end: self.starts[geometry + 1] }
    }

    /// Positions of all vertices of a geometry; none of one of another kind, or for another tree.
    pub fn positions(&self, geometry: usize) -> &'a [[f32; 3]] {
        match &self.meshes[geometry] {
            Surface::Triangles(mesh) => mesh.positions,
            Surface::Quads(mesh) => mesh.positions,
            Surface::None => &[],
        }
    }

    /// Vertices of all triangles, or quads, of a geometry.
    pub fn vertices(&self, geometry: usize) -> &'a [u32] {
        match &self.meshes[geometry] {
            Surface::Triangles(mesh) => mesh.indices.as_flattened(),
            Surface::Quads(mesh) => mesh.indices.as_flattened(),
            Surface::None => &[],
        }
    }

    /// The corners of triangle `number`, whose indices must be valid.
    #[inline]
    pub fn corners(&self, number: u32) -> [[f32; 3]; 3] {
        let (positions, corners) = self.indices(number);
        corners.map(|i| positions[i as usize])
    }

    /// Positions of all vertices of a triangle's mesh, and which of them are its corners.
    #[inline]
    pub fn indices(&self, number: u32) -> (&'a [[f32; 3]], [u32; 3]) {
        let geometry = geometry_of(&self.starts, number);
        self.meshes[geometry].triangle(number - self.starts[geometry])
    }

    /// Checks whether the triangle `number` is traceable, as a build decides it (a half of a quad by itself);
    /// counts faults. Second halves of quads count no faults: their quad has one fault at most.
    pub fn judge(&self, number: u32, bad: &mut BadPrimitives) -> bool {
        let geometry = geometry_of(&self.starts, number);
        let within = number - self.starts[geometry];
        match &self.meshes[geometry] {
            Surface::Triangles(mesh) => {
                let fault = check(bad, mesh.positions, mesh.indices[within as usize]);
                fault.map_err(|fault| *fault += 1).is_ok()
            }
            Surface::Quads(mesh) => {
                let mut faults = BadPrimitives::default();
                let halves = check_quad(&mut faults, mesh.positions, &mesh.indices[within as usize / 2]);
                *bad += if within & 1 == 0 { faults } else { BadPrimitives::default() };
                halves[within as usize & 1].is_some()
            }
            Surface::None => unreachable!("{number} is not a triangle's"),
        }
    }
}

impl<'a> Mesh<'a> {
    /// That of no number.
    pub const NONE: Self = Self { surface: Surface::None, start: 0, end: 0 };

    /// Whether all of these triangles are its own.
    #[inline(always)]
    pub fn holds<const N: usize>(&self, numbers: &[u32; N]) -> bool {
        numbers.iter().all(|number| (self.start..self.end).contains(number))
    }

    /// Whether its triangles are halves of quads, whose faults depend on each other.
    #[must_use]
    pub fn is_quads(&self) -> bool {
        matches!(self.surface, Surface::Quads(_))
    }

    /// Its first number and its arrays, where it is one of triangles.
    #[inline(always)]
    #[must_use]
    pub fn as_triangles(&self) -> Option<(u32, Triangles<'a>)> {
        match self.surface {
            Surface::Triangles(mesh) => Some((self.start, mesh)),
            _ => None,
        }
    }
}

impl<'a> Surface<'a> {
    #[inline(always)]
    pub(crate) fn triangle(&self, within: u32) -> (&'a [[f32; 3]], [u32; 3]) {
        match self {
            Self::Triangles(mesh) => (mesh.positions, mesh.indices[within as usize]),
            Self::Quads(mesh) => (mesh.positions, half(&mesh.indices[within as usize / 2], within & 1)),
            Self::None => unreachable!("{within} is not among the numbers"),
        }
    }
}

/// Vertices of one half of a quad.
#[inline]
pub(crate) fn half(&[a, b, c, d]: &[u32; 4], which: u32) -> [u32; 3] {
    if which == 0 { [a, b, d] } else { [c, d, b] }
}

/// The halves of a quad that can be traced. A quad with one flat half is a triangle; any other fault of a half is one of the
/// quad, and counted.
pub(crate) fn check_quad(
    bad: &mut BadPrimitives,
    positions: &[[f32; 3]],
    quad: &[u32; 4],
) -> [Option<[[f32; 3]; 3]>; 2] {
    let mut faults = BadPrimitives::default();
    let halves = [0, 1].map(|i| match check(&mut faults, positions, half(quad, i)) {
        Ok(triangle) => Some(triangle),
        Err(fault) => {
            *fault += 1;
            None
        }
    });
    if faults.total() == faults.zero_area && faults.zero_area < 2 {
        return halves;
    }
    // The second half may have the same fault as the first, or another one.
    if let Err(fault) = check(bad, positions, half(quad, u32::from(halves[0].is_some()))) {
        *fault += 1;
    }
    [None, None]
}

/// The corners, or where their fault is to be counted.
pub(crate) fn check<'b>(
    bad: &'b mut BadPrimitives,
    positions: &[[f32; 3]],
    corners: [u32; 3],
) -> Result<[[f32; 3]; 3], &'b mut u64> {
    if corners.iter().any(|&i| i as usize >= positions.len()) {
        return Err(&mut bad.bad_index);
    }
    let triangle = corners.map(|i| positions[i as usize]);
    // Not so of NaN.
    if triangle.iter().flatten().all(|x| x.abs() <= crate::LARGEST_COORDINATE) {
        return if is_flat(&triangle) { Err(&mut bad.zero_area) } else { Ok(triangle) };
    }
    match bad.fault(triangle.iter().flatten().copied()) {
        Some(fault) => Err(fault),
        None => Ok(triangle),
    }
}

/// Whether the corners span no area, in double precision.
fn is_flat([a, b, c]: &[[f32; 3]; 3]) -> bool {
    let edge = |p: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
    uy * vz == uz * vy && uz * vx == ux * vz && ux * vy == uy * vx
}
