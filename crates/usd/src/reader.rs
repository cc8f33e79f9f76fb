// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of a composed stage at one moment, and their oddities.
//! At rest an attribute has its default value or, where it has none, its first sample. Tests: `tests/composition.rs`.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::fmt::Display;
use std::path::PathBuf;
use std::rc::Rc;

use gnurt_scene::io::{Error, Oddity, Warnings};
use openusd::sdf::{Path, Specifier, Value};
use openusd::usd::{Stage, TimeCode};

use crate::files::Files;
use crate::value;

/// Prims that may be looked at however short the files are; longer ones may have one for four bytes.
const MOST_PRIMS: u64 = 1 << 14;

/// A stage at a moment.
pub(crate) struct Reader {
    pub(crate) stage: Stage,
    pub(crate) path: PathBuf,
    pub(crate) files: Rc<Files>,
    /// In the stage's time codes.
    time: f64,
    warnings: RefCell<Warnings>,
    prims: Cell<u64>,
    /// Values that were read and are others at other moments.
    varying: Cell<u64>,
    /// Names of the properties of prims that were asked about lately.
    names: RefCell<HashMap<Path, Names>>,
}

type Names = Rc<[String]>;

impl Reader {
    pub(crate) fn new(stage: Stage, seconds: Option<f64>, path: PathBuf, files: Rc<Files>) -> Self {
        let (warnings, prims, varying) = (RefCell::default(), Cell::new(0), Cell::new(0));
        let names = RefCell::default();
        let mut reader = Self { stage, path, files, time: 0.0, warnings, prims, varying, names };
        let start = || reader.stage_number("startTimeCode").unwrap_or(0.0);
        reader.time = seconds.map_or_else(start, |seconds| seconds * reader.rate());
        reader
    }

    /// Time codes in a second.
    pub(crate) fn rate(&self) -> f64 {
        let rate = self.stage.time_codes_per_second();
        if rate > 0.0 && rate.is_finite() { rate } else { 24.0 }
    }

    /// The file's frames in a second must be a number above 0, as OpenUSD demands.
    pub(crate) fn check_rate(&self) -> Result<(), Error> {
        match self.stage_number("framesPerSecond") {
            Some(rate) if rate <= 0.0 => {
                let problem = format!("framesPerSecond is out of range: {rate}");
                Err(Error::data(&self.path, None, problem, "valid are numbers above 0"))
            }
            _ => Ok(()),
        }
    }

    /// Allows one more prim to be looked at.
    pub(crate) fn count_prim(&self) -> Result<(), Error> {
        let most = MOST_PRIMS.max(self.files.length() / 4);
        self.prims.set(self.prims.get() + 1);
        if self.prims.get() <= most {
            return Ok(());
        }
        let problem = format!("more than {most} prims are composed from files of this length");
        Err(Error::data(&self.path, None, problem, "leave out references that lie in one another"))
    }

    /// Notes an oddity of a prim.
    pub(crate) fn note(&self, oddity: Oddity, prim: &Path, what: impl Display) {
        let detail = format!("{}: {what}", prim.as_str());
        self.warnings.borrow_mut().note(oddity, &self.path, None, detail);
    }

    /// Notes a thing that is not shown.
    pub(crate) fn unsupported(&self, prim: &Path, what: impl Display) {
        self.note(Oddity::NotShown, prim, what);
    }

    /// Other oddities.
    pub(crate) fn warnings(&self) -> std::cell::RefMut<'_, Warnings> {
        self.warnings.borrow_mut()
    }

    pub(crate) fn into_warnings(self) -> Warnings {
        self.warnings.into_inner()
    }

    /// Notes layers, references and the like that could not be composed.
    pub(crate) fn note_composition_errors(&self) {
        let mut warnings = self.warnings.borrow_mut();
        for error in self.stage.composition_errors() {
            warnings.note(Oddity::BadComposition, &self.path, None, error.to_string().replace('\n', " "));
        }
    }

    /// The library's value; an error becomes a warning.
    fn checked<T>(&self, path: &Path, result: Result<Option<T>, impl Display>) -> Option<T> {
        result.unwrap_or_else(|error| {
            self.note(Oddity::BadAttribute, path, error);
            None
        })
    }

    /// The value of an attribute at the moment; `None` where it has none or is blocked.
    pub(crate) fn value(&self, prim: &Path, name: &str) -> Option<Value> {
        let [value] = self.values(prim, [name]);
        value
    }

    /// The values of several attributes, as [`value`](Self::value) has them: long ones are read side by side.
    pub(crate) fn values<const N: usize>(&self, prim: &Path, names: [&str; N]) -> [Option<Value>; N] {
        let composed = names.map(|name| self.composed(prim, name));
        let mut values = self.files.arrays.replace(composed, &self.files.access).into_iter();
        names.map(|name| {
            let value = values.next()?;
            self.checked(&prim.append_property(name).ok()?, value)
        })
    }

    /// The same with stand-ins for long arrays.
    fn composed(&self, prim: &Path, name: &str) -> Option<Value> {
        let path = self.property(prim, name)?;
        let attribute = self.stage.attribute(path.clone());
        if !self.files.varies.get() {
            return self.checked(&path, attribute.get::<Value>()).filter(is_value);
        }
        let time = TimeCode::new(self.time);
        let samples = attribute.bracketing_time_samples(time);
        self.varying.set(self.varying.get() + u64::from(samples.is_ok_and(|found| found.is_some())));
        let value = match self.checked(&path, attribute.get_at::<Value>(time)) {
            // Text layers keep samples without a point as whole numbers, which the library does not blend.
            Some(whole @ (Value::Int(_) | Value::Int64(_))) => {
                self.blended(&attribute, self.time).or(Some(whole))
            }
            value => value,
        };
        value.filter(is_value)
    }

    /// How many values with time samples were read so far: what is made of them may differ at another moment.
    pub(crate) fn varying(&self) -> u64 {
        self.varying.get()
    }

    /// Whole numbers of an attribute of broken ones, between two samples.
    fn blended(&self, attribute: &openusd::usd::Attribute, time: f64) -> Option<Value> {
        let kind = attribute.type_name().ok().flatten()?;
        if !matches!(kind.as_str(), "double" | "float" | "half") {
            return None;
        }
        let (low, high) = attribute.bracketing_time_samples(TimeCode::new(time)).ok().flatten()?;
        let number = |at: f64| {
            let value = attribute.get_at::<Value>(TimeCode::new(at)).ok().flatten();
            value.as_ref().and_then(value::number)
        };
        let (before, after) = (number(low)?, number(high)?);
        let share = if high > low { (time - low) / (high - low) } else { 0.0 };
        Some(Value::Double(before + (after - before) * share))
    }

    /// The value of an attribute that does not change with time.
    pub(crate) fn uniform(&self, prim: &Path, name: &str) -> Option<Value> {
        let path = self.property(prim, name)?;
        let value = self.checked(&path, self.stage.attribute(path.clone()).get::<Value>()).filter(is_value);
        let [value] = self.files.arrays.replace([value], &self.files.access);
        self.checked(&path, value)
    }

    /// A word of an attribute.
    pub(crate) fn word(&self, prim: &Path, name: &str) -> Option<String> {
        self.value(prim, name).as_ref().and_then(value::word)
    }

    /// A number of an attribute.
    pub(crate) fn number(&self, prim: &Path, name: &str) -> Option<f64> {
        self.value(prim, name).as_ref().and_then(value::number).filter(|x| x.is_finite())
    }

    /// A number of an attribute, or its fallback.
    pub(crate) fn number_or(&self, prim: &Path, name: &str, fallback: f64) -> f64 {
        self.number(prim, name).unwrap_or(fallback)
    }

    /// The folder that files may come from.
    pub(crate) fn confined_to(&self) -> Option<PathBuf> {
        self.files.access.confined_to()
    }

    /// Yes or no.
    pub(crate) fn flag(&self, prim: &Path, name: &str) -> Option<bool> {
        self.value(prim, name).as_ref().and_then(value::flag)
    }

    /// A word of an attribute's metadata.
    pub(crate) fn metadata(&self, prim: &Path, name: &str, key: &str) -> Option<Value> {
        self.stage.attribute(self.property(prim, name)?).get_metadata::<Value>(key).ok().flatten()
    }

    /// A prim's metadata.
    pub(crate) fn prim_metadata(&self, prim: &Path, key: &str) -> Option<Value> {
        self.stage.attribute(prim.clone()).get_metadata::<Value>(key).ok().flatten()
    }

    /// A word of a relationship's metadata.
    pub(crate) fn metadata_of_relationship(&self, prim: &Path, name: &str, key: &str) -> Option<Value> {
        // The library reads metadata of any property by the same path.
        self.metadata(prim, name, key)
    }

    /// The targets of a relationship.
    pub(crate) fn targets(&self, prim: &Path, name: &str) -> Vec<Path> {
        let Some(path) = self.property(prim, name) else { return Vec::new() };
        self.stage.relationship(path).forwarded_targets().unwrap_or_default()
    }

    /// The first source that an attribute is connected to.
    pub(crate) fn connection(&self, prim: &Path, name: &str) -> Option<Path> {
        let path = self.property(prim, name)?;
        self.stage.attribute(path).connections().ok()?.into_iter().next()
    }

    /// The type of a prim; empty where it has none.
    pub(crate) fn kind(&self, prim: &Path) -> String {
        let name = self.stage.prim(prim.clone()).type_name().ok().flatten();
        name.map(|name| name.as_str().to_owned()).unwrap_or_default()
    }

    /// Names of its properties.
    pub(crate) fn properties(&self, prim: &Path) -> Names {
        /// Prims whose names are kept.
        const MOST: usize = 256;
        if let Some(known) = self.names.borrow().get(prim) {
            return known.clone();
        }
        let names = self.stage.prim(prim.clone()).property_names().unwrap_or_default();
        let names: Names = names.iter().map(|name| name.as_str().to_owned()).collect();
        let mut known = self.names.borrow_mut();
        if known.len() >= MOST {
            known.clear();
        }
        known.insert(prim.clone(), names.clone());
        names
    }

    /// The path of a property; `None` where the prim has no such one, which most questions are about.
    fn property(&self, prim: &Path, name: &str) -> Option<Path> {
        // Clips have values of properties that no layer of the prim names.
        let is_there = self.files.varies.get() || self.properties(prim).iter().any(|known| known == name);
        is_there.then(|| prim.append_property(name).ok()).flatten()
    }

    /// Whether a schema is applied to a prim.
    pub(crate) fn has_schema(&self, prim: &Path, schema: &str) -> bool {
        self.stage.prim(prim.clone()).has_api_schema(schema).unwrap_or(false)
    }

    /// The children of a prim that are there: active and defined.
    pub(crate) fn children(&self, prim: &Path) -> Vec<Path> {
        let children = self.stage.prim(prim.clone()).children();
        let children = self.checked(prim, children.map(Some)).unwrap_or_default();
        let is_there = |child: &openusd::usd::Prim| {
            let is_defined = matches!(child.specifier(), Ok(Some(Specifier::Def)));
            is_defined && child.is_active().unwrap_or(false)
        };
        children.into_iter().filter(is_there).map(|child| child.path().clone()).collect()
    }

    /// The stage's own metadata.
    pub(crate) fn stage_number(&self, field: &str) -> Option<f64> {
        let value = self.stage.stage_metadata(field).ok().flatten();
        value.as_ref().and_then(value::number).filter(|x| x.is_finite())
    }

    /// Metres of the stage's unit: centimetres, where it says nothing.
    pub(crate) fn metres_per_unit(&self) -> f64 {
        self.stage_number("metersPerUnit").filter(|&unit| unit > 0.0).unwrap_or(0.01)
    }

    /// That the variants of the command line are there.
    pub(crate) fn check_variants(&self) -> Result<(), Error> {
        for choice in &self.files.access.variants {
            let Ok(path) = Path::new(&choice.prim) else { continue };
            let prim = self.stage.prim(path);
            let wrong = |problem: String, remedy: String| Err(Error::data(&self.path, None, problem, remedy));
            if !prim.is_valid().unwrap_or(false) || prim.type_name().is_err() {
                return wrong(format!("no prim '{}'", choice.prim), "check the path of --variant".into());
            }
            let selections = prim.variant_sets().get_all_variant_selections().unwrap_or_default();
            let is_chosen =
                |(set, variant): &(String, String)| *set == choice.set && *variant == choice.variant;
            // The choice alone makes a selection; whether there is such a variant say the layers.
            let is_there = |(layer, path): &(String, Path)| {
                let path = path.append_variant_selection(&choice.set, &choice.variant);
                self.stage.layer(layer).is_some_and(|layer| layer.data().has_spec(&path))
            };
            let sites = prim.prim_stack().unwrap_or_default();
            match selections.iter().any(is_chosen) && sites.iter().any(is_there) {
                true => {}
                false => {
                    let sets: Vec<String> =
                        selections.iter().map(|(set, variant)| format!("{set}={variant}")).collect();
                    let known = if sets.is_empty() { "none".into() } else { sets.join(", ") };
                    return wrong(
                        format!("no variant '{}={}' at {}", choice.set, choice.variant, choice.prim),
                        format!("its sets and what the file chooses: {known}"),
                    );
                }
            }
        }
        Ok(())
    }
}

fn is_value(value: &Value) -> bool {
    !matches!(value, Value::None | Value::ValueBlock)
}
