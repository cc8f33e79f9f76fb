// SPDX-License-Identifier: GPL-3.0-or-later
//! Point clouds that `testshade` reads, and those that it writes after all points.

use gnurt_sl_lib::points::{Column, PointCloud, read_cloud, write_cloud};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Clouds by their files' names.
#[derive(Default)]
pub(super) struct Clouds {
    read: RefCell<HashMap<String, Result<Arc<PointCloud>, String>>>,
    written: RefCell<BTreeMap<String, PointCloud>>,
}

impl Clouds {
    /// A file's cloud, read on the first request.
    pub(super) fn find(&self, file: &str) -> Result<Arc<PointCloud>, String> {
        let mut known = self.read.borrow_mut();
        known.entry(file.to_owned()).or_insert_with(|| open(file).map(Arc::new)).clone()
    }

    /// Adds a point to the future contents of a file.
    pub(super) fn push(&self, file: &str, position: [f32; 3], row: &[Column]) -> bool {
        self.written.borrow_mut().entry(file.to_owned()).or_default().push(position, row)
    }

    /// Writes the added points; returns the reasons of failures.
    pub(super) fn save(&self) -> Vec<String> {
        let written = self.written.take();
        let save = |(file, cloud): (String, PointCloud)| {
            let text = write_cloud(&cloud).map_err(|why| format!("could not write \"{file}\": {why}"));
            text.and_then(|text| {
                std::fs::write(&file, text).map_err(|why| format!("could not write \"{file}\": {why}"))
            })
            .err()
        };
        written.into_iter().filter_map(save).collect()
    }
}

fn open(file: &str) -> Result<PointCloud, String> {
    let text = std::fs::read_to_string(file).map_err(|why| format!("could not open \"{file}\": {why}"))?;
    read_cloud(&text).map_err(|why| format!("could not open \"{file}\": {why}"))
}
