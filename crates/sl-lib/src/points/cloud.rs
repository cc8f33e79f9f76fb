// SPDX-License-Identifier: GPL-3.0-or-later
//! Points with values.
//! Source: the OSL specification, "Point clouds"; original. A column stores the values of all points in
//! order.
//! Tests: `tests/points.rs`.

use std::sync::{Arc, OnceLock};

use super::tree::{Found, Tree};

/// Values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floats.
    Float(Vec<f32>),
    /// Ints.
    Int(Vec<i32>),
    /// Texts.
    Text(Vec<Arc<str>>),
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Float(list) => list.len(),
            Self::Int(list) => list.len(),
            Self::Text(list) => list.len(),
        }
    }

    /// Makes it longer, by zeros and empty texts.
    fn resize(&mut self, count: usize) {
        match self {
            Self::Float(list) => list.resize(count, 0.0),
            Self::Int(list) => list.resize(count, 0),
            Self::Text(list) => list.resize(count, "".into()),
        }
    }

    /// Appends a column of the same kind; returns whether the kinds agree.
    fn append(&mut self, more: &Self) -> bool {
        match (self, more) {
            (Self::Float(list), Self::Float(more)) => list.extend(more),
            (Self::Int(list), Self::Int(more)) => list.extend(more),
            (Self::Text(list), Self::Text(more)) => list.extend(more.iter().cloned()),
            _ => return false,
        }
        true
    }
}

/// Values that all points have.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: Arc<str>,
    /// How many values a point has.
    pub width: usize,
    /// Whether three floats are a direction, a position or a colour.
    pub is_vector: bool,
    /// Its values, `width` for each point.
    pub values: Values,
}

/// Points, their attributes, and a tree over them, built at the first search.
#[derive(Clone, Debug, Default)]
pub struct PointCloud {
    positions: Vec<[f32; 3]>,
    columns: Vec<Column>,
    tree: OnceLock<Tree>,
}

impl PointCloud {
    /// Of points and columns; none if a column has too few or too many values.
    #[must_use]
    pub fn new(positions: Vec<[f32; 3]>, columns: Vec<Column>) -> Option<Self> {
        let fits = |column: &Column| Some(column.values.len()) == positions.len().checked_mul(column.width);
        columns.iter().all(fits).then(|| Self { positions, columns, tree: OnceLock::new() })
    }

    /// Where the points are.
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Their attributes, without the position.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// A column; `position` is where the points are.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<Column> {
        if name == "position" {
            let values = Values::Float(self.positions.iter().flatten().copied().collect());
            return Some(Column { name: name.into(), width: 3, is_vector: true, values });
        }
        self.columns.iter().find(|column| &*column.name == name).cloned()
    }

    /// Adds a point with one value for each column given, in columns of one row. Columns that are new are zero for points before it,
    /// those that are not given are zero for this one. False if one has another kind than before: it is left out.
    pub fn push(&mut self, point: [f32; 3], row: &[Column]) -> bool {
        let before = self.positions.len();
        self.positions.push(point);
        self.tree = OnceLock::new();
        let mut fits = true;
        for new in row {
            let at = self.columns.iter().position(|column| column.name == new.name).unwrap_or_else(|| {
                let mut values = match new.values {
                    Values::Float(_) => Values::Float(Vec::new()),
                    Values::Int(_) => Values::Int(Vec::new()),
                    Values::Text(_) => Values::Text(Vec::new()),
                };
                values.resize(before * new.width);
                self.columns.push(Column { values, ..new.clone() });
                self.columns.len() - 1
            });
            let column = &mut self.columns[at];
            let same = column.width == new.width && column.values.len() == before * new.width;
            fits &= same && column.values.append(&new.values);
        }
        for column in &mut self.columns {
            column.values.resize(self.positions.len() * column.width);
        }
        fits
    }

    /// The nearest points within `radius` of `center`, at most `most`, nearest first, equally near ones by number; with their
    /// distances. Points that are no numbers are never found.
    #[must_use]
    pub fn nearest(&self, center: [f32; 3], radius: f32, most: usize) -> Vec<Found> {
        self.tree.get_or_init(|| Tree::new(&self.positions)).nearest(&self.positions, center, radius, most)
    }
}
