// SPDX-License-Identifier: GPL-3.0-or-later
//! PLY bodies: elements one by one into the arrays of a mesh.
//! Source: G. Turk, The PLY polygon file format, 1994. Cost: linear; memory: the mesh's arrays and one element.
//! Polygons are cut by their shape if the vertices come before the faces, else as fans.
//! Tests: `tests/ply.rs`, `tests/broken_files.rs`, `tests/growth.rs`.

use std::io::BufRead;
use std::path::Path;

use super::columns::{Columns, Slot, Vertex};
use super::header::{Element, Encoding, Header, Property, Scalar};
use super::numbers::{Fault, Numbers};
use super::rows::Rows;
use crate::io::error::quoted;
use crate::io::origin::Origin;
use crate::io::polygon::Cutter;
use crate::io::{Error, Oddity, Warnings};
use crate::mesh::Mesh;
use gnurt_image::{Budget, Excess};

/// Bytes of a row of which many are read at once.
const LONGEST_ROW: usize = 1 << 12;
/// Elements between charges of the budget.
const ELEMENTS_BETWEEN: u64 = 1 << 12;

/// Reads the body that `header` describes.
pub(super) fn read(
    input: &mut impl BufRead,
    header: &Header,
    path: &Path,
    (budget, origin): (&Budget, &mut Origin),
    warnings: &mut Warnings,
) -> Result<Mesh, Error> {
    let numbers = Numbers::new(input, header.encoding, header.lines);
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut body = Body {
        numbers,
        path,
        budget,
        warnings,
        mesh: Mesh::default(),
        vertices,
        corners: Vec::new(),
        cutter: Cutter::for_file(header.body_bytes),
        origin,
        held: 0,
    };
    for element in &header.elements {
        let corners = element.properties.iter().position(is_corners);
        if element.name == "face" && element.count > 0 {
            warn_unread(element, path, body.warnings);
        }
        match (&element.name[..], corners) {
            ("vertex", _) => body.read_vertices(element)?,
            ("face", Some(corners)) => body.read_faces(element, corners, header, Faces::Polygons)?,
            ("tristrips", Some(corners)) => body.read_faces(element, corners, header, Faces::Strips)?,
            _ => body.skip(element)?,
        }
    }
    if body.numbers.has_more().map_err(|e| Error::system(path, &e))? {
        body.warnings.note(Oddity::TrailingData, path, body.numbers.line(), "");
    }
    Ok(body.mesh)
}

/// Warns about properties of faces that our meshes do not have.
fn warn_unread(face: &Element, path: &Path, warnings: &mut Warnings) {
    let has = |names: &[&str]| face.properties.iter().any(|property| names.contains(&&property.name[..]));
    for (names, what) in [
        (&["red", "green", "blue", "diffuse_red"][..], "colours of faces"),
        (&["texcoord"], "texture coordinates of the corners of faces"),
        (&["texnumber", "material_index", "material_indices"], "textures and materials of faces"),
    ] {
        if has(names) {
            warnings.note(Oddity::NotShown, path, None, what);
        }
    }
}

/// Whether a property holds the corners of a face.
fn is_corners(property: &Property) -> bool {
    property.count.is_some()
        && property.item.is_integer()
        && matches!(&property.name[..], "vertex_indices" | "vertex_index")
}

/// The kind of corners in an element.
#[derive(Clone, Copy, PartialEq)]
enum Faces {
    Polygons,
    Strips,
}

/// A body during its conversion to a mesh.
struct Body<'a, R> {
    numbers: Numbers<'a, R>,
    path: &'a Path,
    budget: &'a Budget,
    warnings: &'a mut Warnings,
    mesh: Mesh,
    /// Vertices that the header declares.
    vertices: u64,
    /// Of one face.
    corners: Vec<i64>,
    cutter: Cutter,
    origin: &'a mut Origin,
    /// Bytes of triangles and corners charged to the budget.
    held: usize,
}

impl<R: BufRead> Body<'_, R> {
    fn error(&self, problem: String, remedy: impl Into<String>) -> Error {
        Error::data(self.path, self.numbers.line(), problem, remedy)
    }

    fn hold(&self, bytes: usize) -> Result<(), Error> {
        self.budget.hold(bytes).map_err(|e| self.error(e.to_string(), Excess::REMEDY))
    }

    /// The error for element `index`.
    fn fault(&self, fault: Fault, element: &Element, index: u64) -> Error {
        let (name, count) = (&element.name, element.count);
        let problem = match fault {
            Fault::System(error) => return Error::system(self.path, &error),
            Fault::TooLong => "a line of more than 16 MiB".to_owned(),
            Fault::Negative => format!("broken list in `{name}` {index} of {count}"),
            Fault::End if self.numbers.line().is_some() => {
                format!("the file ends before `{name}` {index} of {count}")
            }
            Fault::End => format!("the file ends in `{name}` {index} of {count}"),
            Fault::Token => {
                let properties: Vec<_> = element.properties.iter().map(|p| &p.name[..]).take(16).collect();
                let problem = format!("bad `{name}` line {}", quoted(self.numbers.text().trim()));
                return self.error(problem, format!("expected numbers for {}", properties.join(" ")));
            }
        };
        self.error(problem, "it may have been cut off")
    }

    /// Notes a line that ends before unused properties.
    fn note_short(&mut self, is_whole: bool) {
        if !is_whole {
            self.warnings.note(Oddity::ShortLine, self.path, self.numbers.line(), "");
        }
    }

    fn skip(&mut self, element: &Element) -> Result<(), Error> {
        for index in 0..element.count {
            let mut skip = || -> Result<(), Fault> {
                self.numbers.begin()?;
                element.properties.iter().try_for_each(|property| self.numbers.skip(property))
            };
            skip().map_err(|fault| self.fault(fault, element, index))?;
        }
        Ok(())
    }

    fn read_vertices(&mut self, element: &Element) -> Result<(), Error> {
        let columns = Columns::of(element);
        if !columns.positions {
            let problem = "vertices without x, y and z";
            return Err(Error::data(self.path, None, problem, "expected `property float x` and so on"));
        }
        let count = u32::try_from(element.count).ok().filter(|&count| count < u32::MAX);
        let Some(count) = count.map(|count| count as usize) else {
            let problem = format!("{} vertices", element.count);
            return Err(Error::data(self.path, None, problem, "at most 2^32 - 2 are possible"));
        };
        self.hold(count.saturating_mul(columns.vertex_bytes()))?;
        let mesh = &mut self.mesh;
        let reserve = |requested: bool| if requested { count } else { 0 };
        mesh.positions.reserve_exact(count);
        mesh.normals.reserve_exact(reserve(columns.normals));
        mesh.texcoords.reserve_exact(reserve(columns.texcoords));
        mesh.colors.reserve_exact(reserve(columns.colors));
        let slots: Vec<(Slot, &Property)> = element.properties.iter().map(|p| (Slot::of(p), p)).collect();
        let read_before = self.read_rows(element, columns)?;
        for index in read_before..element.count {
            let read = read_vertex(&mut self.numbers, &slots);
            let (vertex, is_whole) = read.map_err(|fault| self.fault(fault, element, index))?;
            self.note_short(is_whole);
            let mesh = &mut self.mesh;
            mesh.positions.push(self.origin.place(vertex.position));
            mesh.normals.extend(columns.normals.then_some(vertex.normal));
            mesh.texcoords.extend(columns.texcoords.then_some(vertex.texcoord));
            mesh.colors.extend(columns.colors.then_some(vertex.color));
        }
        Ok(())
    }

    /// Reads the vertices that are rows of bytes, all of one length, as long as the file has them; returns their number.
    fn read_rows(&mut self, element: &Element, columns: Columns) -> Result<u64, Error> {
        let rows = Rows::of(element, self.numbers.encoding());
        let Some(rows) = rows.filter(|rows| (1..=LONGEST_ROW).contains(&rows.size)) else { return Ok(0) };
        let mut done = 0;
        while done < element.count {
            self.numbers.read_ahead(rows.size).map_err(|fault| self.fault(fault, element, done))?;
            let ahead = self.numbers.ahead();
            let count = ((ahead.len() / rows.size) as u64).min(element.count - done);
            if count == 0 {
                break;
            }
            let bytes = count as usize * rows.size;
            rows.add(&ahead[..bytes], columns, self.origin, &mut self.mesh);
            self.numbers.step(bytes);
            done += count;
        }
        Ok(done)
    }

    /// Reads the faces from `done` on that are triangles of indices of 32 bits that are there, and nothing else, as far as they were
    /// read ahead; returns the number of all faces that were read.
    fn read_triangles(&mut self, element: &Element, done: u64) -> Result<u64, Error> {
        const TRIANGLE: usize = 13;
        let [Property { count: Some(Scalar::U8), item, .. }] = &element.properties[..] else {
            return Ok(done);
        };
        let most = match item {
            Scalar::I32 => self.vertices.min(1 << 31) as u32,
            Scalar::U32 => self.vertices.min(u32::MAX.into()) as u32,
            _ => return Ok(done),
        };
        let is_big = match self.numbers.encoding() {
            Encoding::Text => return Ok(done),
            encoding => encoding == Encoding::BigEndian,
        };
        self.numbers.read_ahead(TRIANGLE).map_err(|fault| self.fault(fault, element, done))?;
        let index = |bytes: &[u8]| {
            let number = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            if is_big { number.swap_bytes() } else { number }
        };
        let left = usize::try_from(element.count - done).unwrap_or(usize::MAX);
        let mut read = 0;
        for row in self.numbers.ahead().chunks_exact(TRIANGLE).take(left) {
            let triangle = [1, 5, 9].map(|at| index(&row[at..at + 4]));
            if row[0] != 3 || triangle.iter().any(|&index| index >= most) {
                break;
            }
            self.mesh.indices.push(triangle);
            read += 1;
        }
        self.numbers.step(read * TRIANGLE);
        Ok(done + read as u64)
    }

    /// Reads faces, whose corners are property number `corners`.
    fn read_faces(
        &mut self,
        element: &Element,
        corners: usize,
        header: &Header,
        kind: Faces,
    ) -> Result<(), Error> {
        let triangles = likely_triangles(header, element, element.properties[corners].item);
        self.hold(triangles.saturating_mul(size_of::<[u32; 3]>()))?;
        self.mesh.indices.reserve_exact(triangles);
        self.held = self.face_bytes();
        let (mut index, mut charged) = (0, 0);
        while index < element.count {
            if kind == Faces::Polygons {
                index = self.read_triangles(element, index)?;
            }
            if index == element.count {
                break;
            }
            let read = read_face(&mut self.numbers, element, corners, &mut self.corners);
            let is_whole = read.map_err(|fault| self.fault(fault, element, index))?;
            self.note_short(is_whole);
            match kind {
                Faces::Polygons => self.add_polygon(index)?,
                Faces::Strips => self.add_strips(index)?,
            }
            index += 1;
            // One list may be as long as the file.
            if index - charged >= ELEMENTS_BETWEEN || self.corners.len() > ELEMENTS_BETWEEN as usize {
                self.hold_faces()?;
                charged = index;
            }
        }
        self.hold_faces()?;
        self.mesh.indices.shrink_to_fit();
        Ok(())
    }

    /// Charges the budget for the memory taken since the last call.
    fn hold_faces(&mut self) -> Result<(), Error> {
        let now = self.face_bytes();
        self.hold(now.saturating_sub(self.held))?;
        self.held = now.max(self.held);
        Ok(())
    }

    /// Bytes of triangles and of one face's corners.
    fn face_bytes(&self) -> usize {
        12 * self.mesh.indices.capacity() + 8 * self.corners.capacity()
    }

    fn add_polygon(&mut self, index: u64) -> Result<(), Error> {
        let corners = &self.corners;
        if let Some(&bad) = corners.iter().find(|&&i| !self.exists(i)) {
            return Err(self.out_of_range(bad, index));
        }
        if corners.len() < 3 {
            self.warnings.note(Oddity::ShortFace, self.path, self.numbers.line(), "");
        }
        let Mesh { positions, indices, .. } = &mut self.mesh;
        let position = |k: usize| positions.get(corners[k] as usize).copied().unwrap_or_default();
        self.cutter
            .cut(corners.len(), position, |triangle| indices.push(triangle.map(|k| corners[k] as u32)));
        Ok(())
    }

    /// Triangle strips, -1 between them; every other triangle of a strip is reversed.
    fn add_strips(&mut self, index: u64) -> Result<(), Error> {
        if let Some(&bad) = self.corners.iter().find(|&&i| i != -1 && !self.exists(i)) {
            return Err(self.out_of_range(bad, index));
        }
        for strip in self.corners.split(|&i| i == -1) {
            let triangles = strip.windows(3).enumerate().map(|(k, t)| match k % 2 {
                0 => [t[0], t[1], t[2]],
                _ => [t[1], t[0], t[2]],
            });
            self.mesh.indices.extend(triangles.map(|t| t.map(|i| i as u32)));
        }
        Ok(())
    }

    fn exists(&self, index: i64) -> bool {
        u64::try_from(index).is_ok_and(|i| i < self.vertices)
    }

    fn out_of_range(&self, bad: i64, index: u64) -> Error {
        let remedy = match self.vertices {
            0 => "no vertices are declared".to_owned(),
            n => format!("expected 0 to {}", n - 1),
        };
        self.error(format!("vertex index {bad} out of range in face {index}"), remedy)
    }
}

/// A vertex, and whether its line had all that the header declares.
fn read_vertex<R: BufRead>(
    numbers: &mut Numbers<'_, R>,
    slots: &[(Slot, &Property)],
) -> Result<(Vertex, bool), Fault> {
    numbers.begin()?;
    let mut vertex = Vertex::NEUTRAL;
    let mut is_whole = true;
    for &(slot, property) in slots {
        match slot {
            // An unused property may be missing.
            Slot::None if numbers.is_spent() => is_whole = false,
            Slot::None => numbers.skip(property)?,
            slot => vertex.set(slot, numbers.float(property.item)?, property.item),
        }
    }
    Ok((vertex, is_whole))
}

/// The corners of a face, and whether its line had all that the header declares.
fn read_face<R: BufRead>(
    numbers: &mut Numbers<'_, R>,
    element: &Element,
    corners: usize,
    into: &mut Vec<i64>,
) -> Result<bool, Fault> {
    numbers.begin()?;
    let mut is_whole = true;
    for (k, property) in element.properties.iter().enumerate() {
        match property.count {
            Some(count) if k == corners => {
                into.clear();
                let length = numbers.length(count)?;
                numbers.integers(property.item, length, into)?;
            }
            _ if numbers.is_spent() => is_whole = false,
            _ => numbers.skip(property)?,
        }
    }
    Ok(is_whole)
}

/// Triangles to take memory for: one per face, but no more than the body has bytes for.
fn likely_triangles(header: &Header, element: &Element, corner: Scalar) -> usize {
    let triangle = match header.encoding {
        Encoding::Text => "3 0 1 2\n".len() as u64,
        encoding => element.least_bytes(encoding) + 3 * corner.size() as u64,
    };
    usize::try_from(element.count.min(header.body_bytes / triangle)).unwrap_or(usize::MAX)
}
