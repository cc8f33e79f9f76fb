// SPDX-License-Identifier: GPL-3.0-or-later
//! A layer as the library gets it: a file, parts of which are replaced. Tests: `tests`, `tests/arrays.rs`.

use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use openusd::ar;

/// Other bytes for a part of a file.
#[derive(Clone, Debug)]
pub(crate) struct Edit {
    pub(crate) range: Range<usize>,
    pub(crate) by: Replacement,
}

/// The bytes of an [`Edit`].
#[derive(Clone, Debug)]
pub(crate) enum Replacement {
    Bytes(Vec<u8>),
    /// As many zeros, whose memory is never touched.
    Zeros,
}

/// A file and its edits.
#[derive(Debug)]
pub(crate) struct Layer {
    file: Arc<Vec<u8>>,
    /// In order, without overlaps.
    edits: Vec<Edit>,
}

impl Layer {
    /// The file with these edits, of which those that begin in another one are left out.
    pub(crate) fn new(file: Arc<Vec<u8>>, mut edits: Vec<Edit>) -> Self {
        edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
        let mut end = 0;
        edits.retain(|Edit { range, .. }| {
            let is_free = end <= range.start && range.start <= range.end && range.end <= file.len();
            end = if is_free { range.end } else { end };
            is_free
        });
        Self { file, edits }
    }

    /// The edited bytes.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let length = self.edits.iter().fold(self.file.len(), |length, Edit { range, by }| match by {
            Replacement::Bytes(bytes) => length - range.len() + bytes.len(),
            Replacement::Zeros => length,
        });
        let mut all = vec![0; length];
        let (mut from, mut to) = (0, 0);
        let mut put = |to: &mut usize, bytes: &[u8]| {
            all[*to..*to + bytes.len()].copy_from_slice(bytes);
            *to += bytes.len();
        };
        for Edit { range, by } in &self.edits {
            put(&mut to, &self.file[from..range.start]);
            match by {
                Replacement::Bytes(bytes) => put(&mut to, bytes),
                Replacement::Zeros => to += range.len(),
            }
            from = range.end;
        }
        put(&mut to, &self.file[from..]);
        all
    }
}

/// A layer that the library reads.
pub(crate) struct Asset {
    layer: Arc<Layer>,
    /// The bytes, once they are read in pieces.
    pieces: Option<Cursor<Vec<u8>>>,
}

impl Asset {
    pub(crate) fn new(layer: Arc<Layer>) -> Self {
        Self { layer, pieces: None }
    }

    fn pieces(&mut self) -> &mut Cursor<Vec<u8>> {
        self.pieces.get_or_insert_with(|| Cursor::new(self.layer.bytes()))
    }
}

impl Read for Asset {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        self.pieces().read(to)
    }
}

impl Seek for Asset {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.pieces().seek(to)
    }
}

impl ar::Asset for Asset {
    fn size(&self) -> io::Result<u64> {
        let bytes =
            self.pieces.as_ref().map_or_else(|| self.layer.bytes().len(), |bytes| bytes.get_ref().len());
        Ok(bytes as u64)
    }

    fn read_all(&mut self) -> io::Result<Vec<u8>> {
        Ok(self.layer.bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_in_order() {
        let put = |range: Range<usize>, text: &str| Edit { range, by: Replacement::Bytes(text.into()) };
        let zeros = |range: Range<usize>| Edit { range, by: Replacement::Zeros };
        let edited = |edits: &[Edit]| {
            let layer = Arc::new(Layer::new(Arc::new(b"0123456789".to_vec()), edits.to_vec()));
            let mut read = Vec::new();
            Asset::new(layer.clone()).read_to_end(&mut read).expect("memory");
            assert_eq!(layer.bytes(), read, "at once and in pieces");
            String::from_utf8(read).expect("text")
        };
        assert_eq!(edited(&[]), "0123456789");
        assert_eq!(edited(&[put(8..10, ""), put(2..3, "abc"), zeros(4..6)]), "01abc3\0\x0067");
        assert_eq!(edited(&[put(10..10, "end"), put(0..0, "start")]), "start0123456789end");
        assert_eq!(
            edited(&[put(2..5, "-"), put(4..6, "x"), put(9..99, "y")]),
            "01-56789",
            "overlaps are left out"
        );
    }
}
