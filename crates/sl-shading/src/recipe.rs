// SPDX-License-Identifier: GPL-3.0-or-later
//! All that a script is made of, as plain data: for other processes, and for times when its files have changed.
//! The texts of its files are in it. Files that the running shader reads, such as pictures by name, are read again.
//! Tests: `tests/scripts/recipes.rs`.

use std::path::PathBuf;
use std::sync::Arc;

use gnurt_shading::script::ParameterValue;
use gnurt_shading::texture::TextureSampler;

use crate::access::Access;
use crate::script::Script;

/// The parts of a [`Script`] but for its working space. Its numbers are no longer tunable.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipe {
    /// As for [`Script::open`].
    pub path: PathBuf,
    /// The texts of all files that were compiled, by their paths.
    pub texts: Vec<(PathBuf, String)>,
    /// As [`Access::includes`].
    pub includes: Vec<String>,
    /// As [`Access::confined_to`].
    pub confined_to: Option<PathBuf>,
    /// Values of parameters, by their names.
    pub values: Vec<(String, ParameterValue)>,
    /// Pictures in memory by their names, in the order of these.
    pub pictures: Vec<(String, Arc<TextureSampler>)>,
}

impl Script {
    /// All that it is made of.
    #[must_use]
    pub fn recipe(&self) -> Recipe {
        let access = self.access();
        let mut pictures: Vec<_> =
            access.pictures.iter().map(|(name, sampler)| (name.clone(), sampler.clone())).collect();
        pictures.sort_unstable_by(|(a, _), (b, _)| a.cmp(b));
        Recipe {
            path: self.path().to_owned(),
            texts: self.texts().to_vec(),
            includes: access.includes.clone(),
            confined_to: access.confined_to.clone(),
            values: self.given().to_vec(),
            pictures,
        }
    }

    /// Compiles a recipe, for light in Rec. 709.
    ///
    /// # Errors
    /// As [`open`](Self::open), or a value does not fit.
    pub fn of_recipe(recipe: Recipe) -> Result<Self, String> {
        let Recipe { path, texts, includes, confined_to, values, pictures } = recipe;
        let (texts, pictures) =
            (Arc::new(texts.into_iter().collect()), Arc::new(pictures.into_iter().collect()));
        let access = Access { texts, includes, confined_to, pictures, ..Access::default() };
        let mut script = Self::open(&path, &access)?;
        values.iter().try_for_each(|(name, value)| script.set(name, value))?;
        Ok(script)
    }
}
