// SPDX-License-Identifier: GPL-3.0-or-later
//! The workspace, by `cargo metadata`.

use std::path::PathBuf;

use serde_json::Value;

use crate::command;
use crate::failure::Failure;

/// A package of the workspace.
#[derive(Clone, Debug)]
pub(crate) struct Package {
    pub(crate) name: String,
    /// Names of the workspace's packages that its normal and build dependencies are.
    pub(crate) uses: Vec<String>,
}

/// The workspace.
#[derive(Debug)]
pub(crate) struct Workspace {
    pub(crate) packages: Vec<Package>,
    pub(crate) target: PathBuf,
    pub(crate) version: String,
}

impl Workspace {
    /// Runs cargo.
    pub(crate) fn load() -> Result<Self, Failure> {
        Self::from_metadata(&Self::metadata()?)
    }

    /// The output of cargo.
    pub(crate) fn metadata() -> Result<Value, Failure> {
        let output = command::cargo().args(["metadata", "--format-version", "1", "--no-deps"]).output();
        let output = output.map_err(|error| format!("cargo metadata cannot be run: {error}"))?;
        if !output.status.success() {
            return Err(format!("cargo metadata failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo metadata is no JSON: {error}"))
    }

    /// Reads cargo's JSON, format version 1.
    pub(crate) fn from_metadata(metadata: &Value) -> Result<Self, Failure> {
        let missing = |what: &str| format!("cargo metadata lacks '{what}'");
        let list = metadata["packages"].as_array().ok_or_else(|| missing("packages"))?;
        let packages = list.iter().map(package).collect::<Option<Vec<_>>>().ok_or_else(|| missing("name"))?;
        let version = list.iter().find(|p| p["name"] == "gnurt").and_then(|p| p["version"].as_str());
        let target = metadata["target_directory"].as_str().ok_or_else(|| missing("target_directory"))?;
        Ok(Self {
            packages,
            target: target.into(),
            version: version.ok_or_else(|| missing("version"))?.into(),
        })
    }
}

fn package(value: &Value) -> Option<Package> {
    let empty = Vec::new();
    let dependencies = value["dependencies"].as_array().unwrap_or(&empty);
    // Ours have a path; development dependencies are free.
    let ours = dependencies.iter().filter(|d| d["path"].is_string() && d["kind"] != "dev");
    let uses = ours.filter_map(|d| d["name"].as_str()).map(String::from).collect();
    Some(Package { name: value["name"].as_str()?.into(), uses })
}
