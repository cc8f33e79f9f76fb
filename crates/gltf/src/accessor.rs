// SPDX-License-Identifier: GPL-3.0-or-later
//! Accessors: typed arrays in buffers, with strides, sparse substitutes and normalized integers.
//! Source: glTF 2.0 section 3.6.2. Declared counts are checked against the buffer before memory is taken.
//! Tests: `tests/gltf.rs`, `tests/broken_files.rs`.

use super::decoded::{Array, ComponentType, Decoded};
use super::document::Document;
use super::json::{Accessor, Index};
use gnurt_scene::io::Error;
use gnurt_scene::io::reader::fill;

/// Least bytes of an element of at most four components in memory.
const LEAST_HELD: usize = 16;

/// Reads an accessor of at least `N` components as floats: normalized integers in their range, others as they are.
/// Values of `decoded` replace those of its accessors.
pub(super) fn floats<const N: usize>(
    document: &Document<'_>,
    index: Index,
    location: &str,
    decoded: Option<&Decoded>,
) -> Result<Vec<[f32; N]>, Error> {
    let reader = Reader::new(document, index, location, decoded)?;
    if reader.components < N {
        let problem = format!("accessor {} has {} components", index.0, reader.components);
        return Err(document.error(location, problem, &format!("expected {N}")));
    }
    if let Some(bytes) = reader.packed(ComponentType::F32, N)? {
        return Ok(words(document, bytes, f32::from_le_bytes));
    }
    let mut values = vec![[0.0; N]; reader.count];
    let size = size_of_component(reader.component);
    reader.for_each(|i, bytes| {
        for (k, slot) in values[i].iter_mut().enumerate() {
            *slot = float(reader.component, reader.normalized, &bytes[k * size..]);
        }
    })?;
    Ok(values)
}

/// Reads an accessor of one unsigned integer each, and the largest number of its type, which ends strips
/// and fans.
pub(super) fn indices(
    document: &Document<'_>,
    index: Index,
    location: &str,
) -> Result<(Vec<u32>, u32), Error> {
    let accessor: Accessor<'_> = document.get(&document.root.accessors, index, location, "accessor")?;
    let largest = match ComponentType::of(accessor.component_type) {
        Some(ComponentType::U8) => u8::MAX.into(),
        Some(ComponentType::U16) => u16::MAX.into(),
        _ => u32::MAX,
    };
    Ok((integers(document, index, location)?, largest))
}

/// The triangles of an accessor of packed indices of 32 bits, three to each; `None` leaves others to [`indices`].
pub(super) fn packed_triangles(
    document: &Document<'_>,
    index: Index,
    location: &str,
) -> Result<Option<Vec<[u32; 3]>>, Error> {
    let accessor: Accessor<'_> = document.get(&document.root.accessors, index, location, "accessor")?;
    let is_plain = ComponentType::of(accessor.component_type) == Some(ComponentType::U32)
        && accessor.sparse.is_none()
        && accessor.count.is_multiple_of(3);
    if !is_plain {
        return Ok(None);
    }
    let reader = Reader::new(document, index, location, None)?;
    let Some(bytes) = reader.packed(ComponentType::U32, 1)? else { return Ok(None) };
    Ok(Some(words(document, bytes, u32::from_le_bytes)))
}

/// Packed groups of values of four bytes.
fn words<T: Copy + Default + Send, const N: usize>(
    document: &Document<'_>,
    bytes: &[u8],
    value: impl Fn([u8; 4]) -> T + Copy + Sync,
) -> Vec<[T; N]> {
    /// Bytes from which on threads fill memory that is zero because it is new.
    const LARGE: usize = 1 << 20;
    let groups = bytes.as_chunks::<4>().0.as_chunks::<N>().0;
    if bytes.len() < LARGE {
        return groups.iter().map(|group| group.map(value)).collect();
    }
    let mut values = vec![[T::default(); N]; groups.len()];
    fill(document.access.threads(), &mut values, groups, &|to, from| {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = from.map(value));
    });
    values
}

/// Reads an accessor of one unsigned integer each.
fn integers(document: &Document<'_>, index: Index, location: &str) -> Result<Vec<u32>, Error> {
    let reader = Reader::new(document, index, location, None)?;
    let unsigned = matches!(reader.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
    if reader.components != 1 || !unsigned {
        return Err(document.error(
            location,
            "indices of a wrong type",
            "expected SCALAR of unsigned integers",
        ));
    }
    if let Some(bytes) = reader.packed(ComponentType::U32, 1)? {
        return Ok(words::<u32, 1>(document, bytes, u32::from_le_bytes).into_flattened());
    }
    if let Some(bytes) = reader.packed(ComponentType::U16, 1)? {
        return Ok(bytes.as_chunks::<2>().0.iter().map(|&bytes| u16::from_le_bytes(bytes).into()).collect());
    }
    let mut values = vec![0; reader.count];
    match reader.component {
        ComponentType::U32 => {
            reader.for_each(|i, bytes| values[i] = unsigned_integer(ComponentType::U32, bytes))?
        }
        ComponentType::U16 => {
            reader.for_each(|i, bytes| values[i] = unsigned_integer(ComponentType::U16, bytes))?
        }
        other => reader.for_each(|i, bytes| values[i] = unsigned_integer(other, bytes))?,
    }
    Ok(values)
}

/// Reads an accessor of four unsigned integers each: the joints of a skin.
pub(super) fn joints(
    document: &Document<'_>,
    index: Index,
    location: &str,
    decoded: Option<&Decoded>,
) -> Result<Vec<[u32; 4]>, Error> {
    let reader = Reader::new(document, index, location, decoded)?;
    if reader.components != 4 {
        return Err(document.error(location, "joints of a wrong type", "expected VEC4 of unsigned integers"));
    }
    let size = size_of_component(reader.component);
    let mut values = vec![[0; 4]; reader.count];
    reader.for_each(|i, bytes| {
        values[i] = [0, 1, 2, 3].map(|k| unsigned_integer(reader.component, &bytes[k * size..]));
    })?;
    Ok(values)
}

/// An accessor whose numbers were checked.
struct Reader<'a> {
    document: &'a Document<'a>,
    accessor: Accessor<'a>,
    location: &'a str,
    component: ComponentType,
    components: usize,
    normalized: bool,
    count: usize,
    /// The values in place of the accessor's own.
    array: Option<&'a Array>,
}

impl<'a> Reader<'a> {
    fn new(
        document: &'a Document<'_>,
        index: Index,
        location: &'a str,
        decoded: Option<&'a Decoded>,
    ) -> Result<Self, Error> {
        let accessor: Accessor<'_> = document.get(&document.root.accessors, index, location, "accessor")?;
        let components = match &*accessor.shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" | "MAT2" => 4,
            "MAT3" => 9,
            "MAT4" => 16,
            _ => 0,
        };
        let Some(component) = ComponentType::of(accessor.component_type).filter(|_| components > 0) else {
            return Err(document.error(location, format!("accessor {} has an unknown type", index.0), ""));
        };
        let array = decoded.and_then(|decoded| Some((decoded.count, decoded.array(index)?)));
        let (component, components, count) = match array {
            Some((count, array)) => (array.component, array.components, count),
            None => (component, components, usize::try_from(accessor.count).unwrap_or(usize::MAX)),
        };
        let normalized = accessor.normalized;
        let array = array.map(|(_, array)| array);
        let reader = Self { document, accessor, location, component, components, normalized, count, array };
        // After this check all `count` elements exist, so the caller may allocate memory for them.
        reader.for_each_plain(|_, _| {}, true)?;
        // No array that is made of it has more bytes per element.
        let bytes = count.saturating_mul(LEAST_HELD.max(4 * components));
        document.hold(bytes, location)?;
        document.work(bytes, location)?;
        Ok(reader)
    }

    fn element_bytes(&self) -> usize {
        self.components * size_of_component(self.component)
    }

    /// Calls `element` with the number and the bytes of each element that is not zero.
    fn for_each(&self, mut element: impl FnMut(usize, &[u8])) -> Result<(), Error> {
        self.for_each_plain(&mut element, false)?;
        let Some(sparse) = &self.accessor.sparse else {
            return Ok(());
        };
        let index_type = ComponentType::of(sparse.indices.component_type);
        let Some(index_type) = index_type.filter(|t| !matches!(t, ComponentType::F32 | ComponentType::F64))
        else {
            return Err(self.document.error(self.location, "sparse indices of an unknown type", ""));
        };
        let count = usize::try_from(sparse.count).unwrap_or(usize::MAX);
        let (at, from) = (&sparse.indices, &sparse.values);
        let indices = self.span(at.buffer_view, at.byte_offset, size_of_component(index_type), count)?;
        let values = self.span(from.buffer_view, from.byte_offset, self.element_bytes(), count)?;
        self.document.work(count.saturating_mul(self.element_bytes()), self.location)?;
        for (index, value) in indices.zip(values) {
            let index = unsigned_integer(index_type, index) as usize;
            if index >= self.count {
                let problem = format!("sparse index {index} out of range");
                let remedy = match self.count {
                    0 => "the accessor has no elements".into(),
                    n => format!("expected 0 to {}", n - 1),
                };
                return Err(self.document.error(self.location, problem, &remedy));
            }
            element(index, value);
        }
        Ok(())
    }

    /// The bytes of all elements, where they have this type and follow one another, as in most files.
    fn packed(&self, component: ComponentType, components: usize) -> Result<Option<&'a [u8]>, Error> {
        let is_plain = self.accessor.sparse.is_none() && self.array.is_none();
        let Some(view) = self.accessor.buffer_view.filter(|_| is_plain) else { return Ok(None) };
        let (view, bytes) = self.document.view(view, self.location)?;
        let stride = view.byte_stride;
        let size = self.element_bytes();
        if self.component != component
            || self.components != components
            || (stride != 0 && stride != size as u64)
        {
            return Ok(None);
        }
        let start = usize::try_from(self.accessor.byte_offset).unwrap_or(usize::MAX);
        Ok(bytes.get(start..).and_then(|bytes| bytes.get(..self.count.checked_mul(size)?)))
    }

    /// The elements in the buffer view; with `check_only`, only whether they fit.
    fn for_each_plain(&self, mut element: impl FnMut(usize, &[u8]), check_only: bool) -> Result<(), Error> {
        if let Some(array) = self.array {
            if !check_only {
                let elements = array.bytes.chunks_exact(self.element_bytes().max(1));
                elements.enumerate().for_each(|(i, bytes)| element(i, bytes));
            }
        } else if let Some(view) = self.accessor.buffer_view {
            let offset = self.accessor.byte_offset;
            let span = self.span(view, offset, self.element_bytes(), self.count)?;
            if !check_only {
                span.enumerate().for_each(|(i, bytes)| element(i, bytes));
            }
        }
        Ok(())
    }

    /// `count` elements of `size` bytes each in a buffer view.
    fn span(
        &self,
        index: Index,
        offset: u64,
        size: usize,
        count: usize,
    ) -> Result<impl Iterator<Item = &'a [u8]>, Error> {
        let (view, bytes) = self.document.view(index, self.location)?;
        let stride = usize::try_from(view.byte_stride).unwrap_or(usize::MAX);
        let stride = if stride == 0 { size } else { stride };
        let last = count.checked_sub(1).map(|n| n.saturating_mul(stride).saturating_add(size)).unwrap_or(0);
        let start = usize::try_from(offset).unwrap_or(usize::MAX);
        if start.saturating_add(last) > bytes.len() {
            let problem = format!(
                "{count} elements do not fit into the {} bytes of bufferView {}",
                bytes.len(),
                index.0
            );
            return Err(self.document.error(self.location, problem, "the buffer may have been cut off"));
        }
        Ok((0..count).map(move |i| &bytes[start + i * stride..][..size]))
    }
}

fn size_of_component(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
        ComponentType::F64 => 8,
    }
}

/// The first component in `bytes`, which has enough of them.
fn float(component: ComponentType, normalized: bool, bytes: &[u8]) -> f32 {
    let scaled = |value: f32, largest: f32| if normalized { (value / largest).max(-1.0) } else { value };
    match component {
        ComponentType::I8 => scaled((bytes[0] as i8).into(), 127.0),
        ComponentType::U8 => scaled(bytes[0].into(), 255.0),
        ComponentType::I16 => scaled(i16::from_le_bytes([bytes[0], bytes[1]]).into(), 32767.0),
        ComponentType::U16 => scaled(u16::from_le_bytes([bytes[0], bytes[1]]).into(), 65535.0),
        ComponentType::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32,
        ComponentType::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        ComponentType::F64 => {
            let bits = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| bytes[k]);
            f64::from_le_bytes(bits) as f32
        }
    }
}

/// The first component in `bytes` as an index; floats and signed numbers are converted to unsigned ones.
#[inline]
fn unsigned_integer(component: ComponentType, bytes: &[u8]) -> u32 {
    match size_of_component(component) {
        1 => bytes[0].into(),
        2 => u16::from_le_bytes([bytes[0], bytes[1]]).into(),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}
