// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives compressed by Draco: their triangles and vertices, in the order of the stream.
//! Source: KHR_draco_mesh_compression; the crate `draco-core` decodes the bitstream (docs/decisions/0048-draco.md).
//! The stream replaces the accessors of the attributes that the extension names. It gives counts and types; the
//! accessor says whether integers are normalized. Other attributes are read as usual. Where a stream cannot be
//! decoded and the file does not require the extension, the uncompressed accessors are read, with a warning.
//! Invariant: a decode gets limits below the memory that is left.
//! Tests: `tests/draco.rs`, `tests/draco_growth.rs`.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};

use super::decoded::{Array, ComponentType, Decoded};
use super::document::{DRACO, Document};
use super::json::{self, Attributes, Index, Primitive};
use gnurt_image::expecting_panics;
use gnurt_scene::io::{Error, Oddity, Warnings};

/// Bytes that the decoder takes at once for a triangle, and for each byte of the values of vertices. Measured on
/// meshes of 200,000 triangles: less than the sum, 255 bytes for each triangle of a mesh with six attributes.
const BYTES_PER_FACE: u64 = 128;
const BYTES_PER_VALUE_BYTE: u64 = 5;
/// Bytes of work that a stream costs that cannot be decoded.
const WORK_OF_FAILURE: usize = 32 << 20;

/// Decodes a primitive; `None` if it is not compressed, or if its uncompressed form is to be read instead.
pub(super) fn decode(
    document: &Document<'_>,
    primitive: &Primitive,
    location: &str,
    warnings: &mut Warnings,
) -> Result<Option<Decoded>, Error> {
    let Some(packed) = primitive.extensions.draco.as_ref().filter(|_| primitive.mode > 3) else {
        return Ok(None);
    };
    let problem = match try_decode(document, primitive, packed, location)? {
        Ok(decoded) => return Ok(Some(decoded)),
        Err(problem) => format!("{DRACO}: {problem}"),
    };
    document.work(WORK_OF_FAILURE, location)?;
    if document.requires(DRACO) || !is_plain(document, primitive, location)? {
        return Err(document.error(location, problem, "write the file again"));
    }
    let detail = format!("{location}: {problem}; its uncompressed form is read");
    warnings.note(Oddity::NotShown, &document.path, None, detail);
    Ok(None)
}

/// Whether there are uncompressed positions.
fn is_plain(document: &Document<'_>, primitive: &Primitive, location: &str) -> Result<bool, Error> {
    let Some(positions) = primitive.attributes.positions else { return Ok(false) };
    let accessor: json::Accessor<'_> =
        document.get(&document.root.accessors, positions, location, "accessor")?;
    Ok(accessor.buffer_view.is_some() || accessor.sparse.is_some())
}

/// The outer error is one of the document; the inner one says what is wrong with the stream.
fn try_decode(
    document: &Document<'_>,
    primitive: &Primitive,
    packed: &json::Draco,
    location: &str,
) -> Result<Result<Decoded, String>, Error> {
    if !matches!(primitive.mode, 4 | 5) {
        return Ok(Err(format!("mode {}; expected 4 or 5, triangles or a strip", primitive.mode)));
    }
    let (_, stream) = document.view(packed.buffer_view, location)?;
    document.work(stream.len(), location)?;
    let mesh = match mesh_of(stream, document.budget().left()) {
        Ok(mesh) => mesh,
        Err(problem) => return Ok(Err(problem)),
    };
    let pairs = pairs(&primitive.attributes, &packed.attributes);
    let mut found = Vec::with_capacity(pairs.len());
    for (name, accessor, id) in pairs {
        match mesh.attribute_by_unique_id(id.0) {
            Some(attribute) => found.push((name, accessor, attribute)),
            None => return Ok(Err(format!("{name}: there is no attribute with the unique id {}", id.0))),
        }
    }
    let vertices = mesh.num_points();
    let values = |attribute: &PointAttribute| vertices.saturating_mul(element_bytes(attribute));
    let triangle_bytes = mesh.num_faces().saturating_mul(size_of::<[u32; 3]>());
    let copied = found.iter().map(|(_, _, attribute)| values(attribute)).sum::<usize>();
    let all = (0..mesh.num_attributes()).map(|i| mesh.attribute(i).buffer().data_size()).sum::<usize>();
    let held = all.saturating_add(triangle_bytes);
    document.hold(held, location)?;
    document.hold(copied.saturating_add(triangle_bytes), location)?;
    document.work((copied.saturating_add(triangle_bytes)).saturating_mul(8), location)?;
    let mut arrays = Vec::with_capacity(found.len());
    for (name, accessor, attribute) in found {
        match array(attribute, vertices) {
            Ok(array) => arrays.push((accessor, array)),
            Err(problem) => return Ok(Err(format!("{name}: {problem}"))),
        }
    }
    let triangles = mesh.faces().iter().map(|face| face.map(|point| point.0)).collect();
    drop(mesh);
    document.budget().release(held);
    Ok(Ok(Decoded { triangles, count: vertices, arrays }))
}

/// The mesh of a stream that takes at most `left` bytes to decode.
fn mesh_of(stream: &[u8], left: u64) -> Result<Mesh, String> {
    let limits = DecodeLimits::default()
        .with_max_points(0)
        .with_max_faces(left / 2 / BYTES_PER_FACE)
        .with_max_decoded_bytes(left / 2 / BYTES_PER_VALUE_BYTE);
    let decoded = expecting_panics(|| {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
    });
    match decoded {
        Some(decoded) => decoded.map_err(|error| error.to_string().replace(['\n', '{', '}'], " ")),
        None => Err("the data contradicts itself".to_owned()),
    }
}

/// Name, accessor and unique id of each attribute that is read and that the stream has.
fn pairs(accessors: &Attributes, ids: &Attributes) -> Vec<(String, Index, Index)> {
    let single = [
        ("POSITION", accessors.positions, ids.positions),
        ("NORMAL", accessors.normals, ids.normals),
        ("TANGENT", accessors.tangents, ids.tangents),
        ("COLOR_0", accessors.colors, ids.colors),
    ];
    let single = single.into_iter().filter_map(|(name, a, id)| Some((name.to_owned(), a?, id?)));
    let sets = [
        ("TEXCOORD", &accessors.texcoords, &ids.texcoords),
        ("JOINTS", &accessors.joints, &ids.joints),
        ("WEIGHTS", &accessors.weights, &ids.weights),
    ];
    let sets = sets.into_iter().flat_map(|(name, accessors, ids)| {
        accessors.iter().filter_map(move |&(set, accessor)| {
            let &(_, id) = ids.iter().find(|(other, _)| *other == set)?;
            Some((format!("{name}_{set}"), accessor, id))
        })
    });
    single.chain(sets).collect()
}

fn element_bytes(attribute: &PointAttribute) -> usize {
    usize::from(attribute.num_components()) * attribute.data_type().byte_length()
}

/// The values of an attribute for each vertex.
fn array(attribute: &PointAttribute, vertices: usize) -> Result<Array, String> {
    let component = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 => ComponentType::U32,
        DataType::Float32 => ComponentType::F32,
        DataType::Float64 => ComponentType::F64,
        other => return Err(format!("values of type {other:?}; expected a type of glTF")),
    };
    let size = element_bytes(attribute);
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0);
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(vertices * size);
    for vertex in 0..vertices {
        // A vertex of no value has an index beyond all.
        let at = attribute.mapped_index(PointIndex(vertex as u32)).0 as usize;
        let start = at.checked_mul(stride).filter(|_| at < attribute.size());
        let value = start.and_then(|start| data.get(start..)?.get(..size));
        bytes.extend_from_slice(value.ok_or_else(|| format!("vertex {vertex} has no value"))?);
    }
    Ok(Array { component, components: usize::from(attribute.num_components()), bytes })
}
