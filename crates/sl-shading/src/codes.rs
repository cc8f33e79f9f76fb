// SPDX-License-Identifier: GPL-3.0-or-later
//! Machine code of shaders, cached by contents: of materials, lights, cameras, skies and pixels. The key is
//! `gnurt_jit`'s `fingerprint`. By default there is one cache for the process. The key covers everything that
//! determines the code, so a picture cannot depend on earlier uses of the cache.
//! Tests: `tests/scripts/lanes.rs`.

use std::sync::{Arc, LazyLock};

use gnurt_jit::Cache;

static ALL: LazyLock<Codes> = LazyLock::new(Codes::separate);

/// Code that was made. Clones are the same one.
#[derive(Clone, Debug)]
pub struct Codes(Arc<Cache>);

impl Default for Codes {
    /// The process's.
    fn default() -> Self {
        ALL.clone()
    }
}

impl Codes {
    /// One by itself.
    #[must_use]
    pub fn separate() -> Self {
        Self(Arc::default())
    }

    /// How many groups of shaders, with values, it has code of, or has it made now.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.count()
    }

    /// Waits until all groups of shaders that have been called have their code: the interpreter runs them no more.
    pub fn wait(&self) {
        self.0.wait();
    }

    pub(crate) fn cache(&self) -> &Cache {
        &self.0
    }
}
