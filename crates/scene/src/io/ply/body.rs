// SPDX-License-Identifier: GPL-3.0-or-later
//! PLY bodies: elements one by one into the arrays of a mesh.
//! Source: G. Turk, The PLY polygon file format, 1994. Cost: linear; memory: the mesh's arrays and one element.
//! Polygons are cut by their shape if the vertices come before the faces, else as fans.
//! Proof: `tests/ply.rs`, `tests/broken_files.rs`.

use std::io::{BufRead, Read};
use std::path::Path;

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyType, ScalarType};

use super::header::{Header, least_bytes, size};
use super::record::{Columns, Face, Skipped, Vertex, is_corners};
use crate::io::error::quoted;
use crate::io::{Error, Oddity, Warnings, polygon};
use crate::mesh::Mesh;

/// Bytes that a line of a text body may have.
const LONGEST_LINE: u64 = 64 << 20;

/// Reads the body that `header` describes.
pub(super) fn read(
    input: &mut impl BufRead,
    header: &Header,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<Mesh, Error> {
    let mut body = Body { input, encoding: header.encoding, path, line: header.lines, text: Vec::new() };
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut builder = Builder { mesh: Mesh::default(), vertices, path, corners: Vec::new(), cut: Vec::new() };
    for element in &header.elements {
        let has_corners =
            element.properties.iter().any(|(name, p)| is_corners(name) && is_integer_list(&p.data_type));
        let triangles = likely_triangles(header, element);
        match element.name.as_str() {
            "vertex" => builder.read_vertices(&mut body, element)?,
            "face" if has_corners => {
                builder.read_faces(&mut body, element, triangles, warnings, Builder::add_polygon)?
            }
            "tristrips" if has_corners => {
                builder.read_faces(&mut body, element, triangles, warnings, Builder::add_strips)?
            }
            _ => body.skip(element)?,
        }
    }
    body.note_rest(warnings)?;
    Ok(builder.mesh)
}

fn is_integer_list(data_type: &PropertyType) -> bool {
    matches!(data_type, PropertyType::List(_, item) if !matches!(item, ScalarType::Float | ScalarType::Double))
}

/// The bytes of a body and the place in it.
struct Body<'a, R> {
    input: &'a mut R,
    encoding: Encoding,
    path: &'a Path,
    /// Lines read so far, of a text.
    line: u64,
    text: Vec<u8>,
}

impl<R: BufRead> Body<'_, R> {
    /// The element number `index` of its kind.
    fn element<E: PropertyAccess>(
        &mut self,
        parser: &Parser<E>,
        element: &ElementDef,
        index: usize,
    ) -> Result<E, Error> {
        let read = match self.encoding {
            Encoding::Ascii => return self.text_element(element, index),
            Encoding::BinaryLittleEndian => parser.read_little_endian_element(self.input, element),
            Encoding::BinaryBigEndian => parser.read_big_endian_element(self.input, element),
        };
        read.map_err(|e| {
            let what = if e.kind() == std::io::ErrorKind::UnexpectedEof {
                "the file ends in"
            } else {
                "broken list in"
            };
            self.error(
                format!("{what} `{}` {index} of {}", element.name, element.count),
                "it may have been cut off",
            )
        })
    }

    fn text_element<E: PropertyAccess>(&mut self, element: &ElementDef, index: usize) -> Result<E, Error> {
        if !self.next_line()? {
            let problem = format!("the file ends before `{}` {index} of {}", element.name, element.count);
            return Err(self.error(problem, "it may have been cut off"));
        }
        let text = String::from_utf8_lossy(&self.text);
        let mut words = text.split_ascii_whitespace();
        let mut value = E::new();
        for (name, property) in &element.properties {
            let property = text_property(&mut words, &property.data_type).ok_or_else(|| {
                let properties: Vec<_> = element.properties.iter().map(|(name, _)| name.as_str()).collect();
                let problem = format!("bad `{}` line {}", element.name, quoted(text.trim()));
                self.error(problem, format!("expected numbers for {}", properties.join(" ")))
            })?;
            value.set_property(name, property);
        }
        Ok(value)
    }

    /// Reads the next line that is not blank; `false` at the end.
    fn next_line(&mut self) -> Result<bool, Error> {
        loop {
            self.text.clear();
            self.line += 1;
            let n = self.input.take(LONGEST_LINE).read_until(b'\n', &mut self.text);
            if n.map_err(|e| Error::system(self.path, &e))? == 0 {
                return Ok(false);
            }
            if !self.text.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    fn skip(&mut self, element: &ElementDef) -> Result<(), Error> {
        let parser = Parser::<Skipped>::new();
        (0..element.count).try_for_each(|i| self.element(&parser, element, i).map(drop))
    }

    fn note_rest(&mut self, warnings: &mut Warnings) -> Result<(), Error> {
        let more = match self.encoding {
            Encoding::Ascii => self.next_line()?,
            _ => !self.input.fill_buf().map_err(|e| Error::system(self.path, &e))?.is_empty(),
        };
        if more {
            warnings.note(Oddity::TrailingData, self.path, self.text_line(), "");
        }
        Ok(())
    }

    fn text_line(&self) -> Option<u64> {
        (self.encoding == Encoding::Ascii).then_some(self.line)
    }

    fn error(&self, problem: String, remedy: impl Into<String>) -> Error {
        Error::data(self.path, self.text_line(), problem, remedy)
    }
}

/// One property from the words of a line; `None` if a word is missing or no number of its type.
fn text_property<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    data_type: &PropertyType,
) -> Option<Property> {
    let mut scalar = |scalar: &ScalarType| -> Option<Property> {
        let word = words.next()?;
        Some(match scalar {
            ScalarType::Float => Property::Float(word.parse().ok()?),
            ScalarType::Double => Property::Double(word.parse().ok()?),
            // All integers fit into a double; only colours care how large they may be.
            ScalarType::UChar => Property::UChar(word.parse().ok()?),
            ScalarType::UShort => Property::UShort(word.parse().ok()?),
            ScalarType::Char => Property::Char(word.parse().ok()?),
            ScalarType::Short => Property::Short(word.parse().ok()?),
            ScalarType::Int => Property::Int(word.parse().ok()?),
            ScalarType::UInt => Property::UInt(word.parse().ok()?),
        })
    };
    let integer = |property| match property {
        Property::Char(x) => Some(i64::from(x)),
        Property::UChar(x) => Some(i64::from(x)),
        Property::Short(x) => Some(i64::from(x)),
        Property::UShort(x) => Some(i64::from(x)),
        Property::Int(x) => Some(i64::from(x)),
        Property::UInt(x) => Some(i64::from(x)),
        _ => None,
    };
    match data_type {
        PropertyType::Scalar(of_type) => scalar(of_type),
        PropertyType::List(length, item) => {
            let length = integer(scalar(length)?).filter(|&n| n >= 0)?;
            let mut list = Vec::new();
            for _ in 0..length {
                let value = scalar(item)?;
                // Lists of floats are never corners: only their length matters.
                list.extend(integer(value).map(|x| i32::try_from(x).unwrap_or(i32::MAX)));
            }
            Some(Property::ListInt(list))
        }
    }
}

/// A mesh in the making.
struct Builder<'a> {
    mesh: Mesh,
    /// Vertices that the header declares.
    vertices: usize,
    path: &'a Path,
    corners: Vec<[f32; 3]>,
    cut: Vec<[usize; 3]>,
}

type AddFace<'a, R> = fn(&mut Builder<'a>, &Body<'a, R>, &Face, usize, &mut Warnings) -> Result<(), Error>;

impl<'a> Builder<'a> {
    fn read_vertices<R: BufRead>(
        &mut self,
        body: &mut Body<'a, R>,
        element: &ElementDef,
    ) -> Result<(), Error> {
        let columns = Columns::of(element);
        if !columns.positions {
            return Err(Error::data(
                self.path,
                None,
                "vertices without x, y and z",
                "expected `property float x` and so on",
            ));
        }
        if element.count > u32::MAX as usize {
            return Err(Error::data(
                self.path,
                None,
                format!("{} vertices", element.count),
                "at most 2^32 - 1 are possible",
            ));
        }
        let mesh = &mut self.mesh;
        let reserve = |wanted: bool| if wanted { element.count } else { 0 };
        mesh.positions.reserve_exact(element.count);
        mesh.normals.reserve_exact(reserve(columns.normals));
        mesh.texcoords.reserve_exact(reserve(columns.texcoords));
        mesh.colors.reserve_exact(reserve(columns.colors));
        let parser = Parser::<Vertex>::new();
        for i in 0..element.count {
            let vertex = body.element(&parser, element, i)?;
            mesh.positions.push(vertex.position);
            mesh.normals.extend(columns.normals.then_some(vertex.normal));
            mesh.texcoords.extend(columns.texcoords.then_some(vertex.texcoord));
            mesh.colors.extend(columns.colors.then_some(vertex.color));
        }
        Ok(())
    }

    fn read_faces<R: BufRead>(
        &mut self,
        body: &mut Body<'a, R>,
        element: &ElementDef,
        triangles: usize,
        warnings: &mut Warnings,
        add: AddFace<'a, R>,
    ) -> Result<(), Error> {
        self.mesh.indices.reserve_exact(triangles);
        let parser = Parser::<Face>::new();
        for i in 0..element.count {
            let face = body.element(&parser, element, i)?;
            add(self, body, &face, i, warnings)?;
        }
        self.mesh.indices.shrink_to_fit();
        Ok(())
    }

    fn add_polygon<R: BufRead>(
        &mut self,
        body: &Body<'a, R>,
        face: &Face,
        index: usize,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let corners = &face.corners;
        if let Some(&bad) = corners.iter().find(|&&i| !self.exists(i)) {
            return Err(self.out_of_range(body, bad, index));
        }
        match corners[..] {
            [] | [_] | [_, _] => warnings.note(Oddity::ShortFace, self.path, body.text_line(), ""),
            [a, b, c] => self.mesh.indices.push([a, b, c].map(|i| i as u32)),
            _ => {
                self.corners.clear();
                let positions = &self.mesh.positions;
                let position = |&i: &i64| positions.get(i as usize).copied().unwrap_or_default();
                self.corners.extend(corners.iter().map(position));
                self.cut.clear();
                polygon::triangulate(&self.corners, &mut self.cut);
                self.mesh.indices.extend(self.cut.iter().map(|t| t.map(|k| corners[k] as u32)));
            }
        }
        Ok(())
    }

    /// Triangle strips; every other triangle of a strip is turned round.
    fn add_strips<R: BufRead>(
        &mut self,
        body: &Body<'a, R>,
        face: &Face,
        index: usize,
        _: &mut Warnings,
    ) -> Result<(), Error> {
        if let Some(&bad) = face.corners.iter().find(|&&i| i != -1 && !self.exists(i)) {
            return Err(self.out_of_range(body, bad, index));
        }
        for strip in face.corners.split(|&i| i == -1) {
            let triangles = strip.windows(3).enumerate().map(|(k, t)| match k % 2 {
                0 => [t[0], t[1], t[2]],
                _ => [t[1], t[0], t[2]],
            });
            self.mesh.indices.extend(triangles.map(|t| t.map(|i| i as u32)));
        }
        Ok(())
    }

    fn exists(&self, index: i64) -> bool {
        usize::try_from(index).is_ok_and(|i| i < self.vertices)
    }

    fn out_of_range<R: BufRead>(&self, body: &Body<'a, R>, bad: i64, index: usize) -> Error {
        let remedy = match self.vertices {
            0 => "no vertices are declared".to_owned(),
            n => format!("expected 0 to {}", n - 1),
        };
        body.error(format!("vertex index {bad} out of range in face {index}"), remedy)
    }
}

/// Triangles to take memory for: one per face, but no more than the body has bytes for.
fn likely_triangles(header: &Header, element: &ElementDef) -> usize {
    let corner = element.properties.iter().find_map(|(name, p)| match &p.data_type {
        PropertyType::List(_, item) if is_corners(name) => Some(size(item)),
        _ => None,
    });
    let triangle = match header.encoding {
        Encoding::Ascii => "3 0 1 2\n".len() as u64,
        _ => least_bytes(element, header.encoding) + 3 * corner.unwrap_or(1),
    };
    element.count.min(usize::try_from(header.body_bytes / triangle).unwrap_or(usize::MAX))
}
