// SPDX-License-Identifier: GPL-3.0-or-later
//! Smoke from files of OpenVDB and NanoVDB, and fog around a scene.
//! Source: the grid's numbers times `density` are the extinction coefficient, as production renderers read
//! them. The emission of a grid of temperatures is that of black bodies, in units of the luminance at 2000 K. Space: the file's world is the scene's. Cells that are not active hold nothing, and values below 0 count as 0.
//! Tests: `tests`, and the command line's `tests/program/volumes.rs`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::defaults::bounds_of;
use crate::error::Error;
use crate::image::{Grid, Volume};
use crate::scene::medium::{DensityGrid, Extent, Medium, Phase};
use crate::scene::volume_cells::{Heat, MOST_VOLUME_BYTES, VolumeCells, density_grid, grid_named};
use crate::scene::{MediumId, Scene};
use gnurt_sl_lib::color::ColorSystem;

/// How a medium of an option scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    albedo: [f32; 3],
    phase: Phase,
    emission: [f32; 3],
}

impl Default for Look {
    fn default() -> Self {
        Self { albedo: [1.0; 3], phase: Phase::default(), emission: [0.0; 3] }
    }
}

impl Look {
    /// Takes a value; false if it has no such name.
    fn take(&mut self, name: &str, value: &str) -> Result<bool, String> {
        let one = |value: &str| Ok::<_, String>(numbers(value)?[0]);
        match name {
            "albedo" => self.albedo = numbers(value)?,
            "anisotropy" => self.phase.anisotropy = one(value)?,
            "second_anisotropy" => self.phase.second_anisotropy = one(value)?,
            "second_share" => self.phase.second_share = one(value)?,
            "emission" => self.emission = numbers(value)?,
            _ => return Ok(false),
        }
        if self.albedo.iter().any(|&albedo| albedo > 1.0) {
            return Err("an albedo is at most 1".into());
        }
        Ok(true)
    }

    fn medium(&self, extinction: [f32; 3]) -> Medium {
        Medium {
            scattering: std::array::from_fn(|c| extinction[c] * self.albedo[c]),
            absorption: std::array::from_fn(|c| extinction[c] * (1.0 - self.albedo[c])),
            emission: self.emission,
            phase: self.phase,
            ..Medium::default()
        }
    }
}

const NAMES: &str = "albedo, anisotropy, emission, second_anisotropy and second_share";

/// One number, or three between commas.
fn numbers(text: &str) -> Result<[f32; 3], String> {
    let parts: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match parts.as_deref() {
        Ok(&[x]) if x.is_finite() => Ok([x; 3]),
        Ok(&[x, y, z]) if [x, y, z].iter().all(|x| x.is_finite()) => Ok([x, y, z]),
        _ => Err(format!("'{text}' is neither a number nor three between commas")),
    }
}

/// The pieces behind the first, as names and values.
fn values<'a>(pieces: impl Iterator<Item = &'a str>) -> Result<Vec<(&'a str, &'a str)>, String> {
    pieces.map(|piece| piece.split_once('=').ok_or_else(|| format!("'{piece}' is no NAME=VALUE"))).collect()
}

/// A medium is sound, or why not.
fn checked(medium: &Medium) -> Result<(), String> {
    medium.problem().map_or(Ok(()), |problem| Err(problem.into()))
}

/// Fog around a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Fog {
    medium: Medium,
}

impl Fog {
    /// From `DISTANCE[:NAME=VALUE...]`: the mean distance at which fog takes light out of a ray, world units, or one for each
    /// colour; `albedo` is the scattered share.
    ///
    /// # Errors
    /// A line for the user.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut pieces = text.split(':');
        let distance = numbers(pieces.next().unwrap_or_default())?;
        if distance.iter().any(|&distance| distance <= 0.0) {
            return Err("the distance of fog is above 0".into());
        }
        let mut look = Look::default();
        for (name, value) in values(pieces)? {
            if !look.take(name, value)? {
                return Err(format!("fog has no '{name}'; valid are {NAMES}"));
            }
        }
        let medium = Medium { name: "fog".into(), ..look.medium(distance.map(|distance| 1.0 / distance)) };
        checked(&medium)?;
        Ok(Self { medium })
    }

    /// Fills a ball around the scene and `eye`: twice as wide as both, so that light from infinitely far away
    /// comes through.
    pub fn put_around(&self, scene: &mut Scene, eye: [f32; 3]) -> MediumId {
        let eye = eye.map(f64::from);
        let (centre, corners) = match bounds_of(scene) {
            Some(bounds) => (bounds.center(), bounds.corners().to_vec()),
            None => (eye, vec![]),
        };
        let away = |p: &[f64; 3]| (0..3).map(|k| (p[k] - centre[k]).powi(2)).sum::<f64>().sqrt();
        let farthest = corners.iter().chain([&eye]).map(away).fold(0.0, f64::max);
        let radius =
            if farthest > 0.0 && farthest.is_finite() { 2.0 * farthest as f32 } else { f32::INFINITY };
        let extent = Extent::Around { centre: centre.map(|x| x as f32), radius };
        scene.add_medium(Medium { extent, ..self.medium.clone() })
    }
}

/// A file of OpenVDB or NanoVDB as smoke.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeFile {
    path: PathBuf,
    /// The grid's name.
    grid: Option<String>,
    /// The name of the grid of emission.
    glow: Option<String>,
    /// The name of the grid of temperatures, and kelvins of its unit.
    heat: Option<(String, f32)>,
    density: [f32; 3],
    look: Look,
}

impl VolumeFile {
    /// From `FILE[:NAME=VALUE...]`.
    ///
    /// # Errors
    /// A line for the user.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut pieces = text.split(':').peekable();
        let mut path = pieces.next().unwrap_or_default().to_owned();
        // Names of files may hold colons.
        while let Some(more) = pieces.next_if(|piece| !piece.contains('=')) {
            path = format!("{path}:{more}");
        }
        if path.is_empty() {
            return Err("give a file of OpenVDB or NanoVDB".into());
        }
        let mut file = Self {
            path: path.into(),
            grid: None,
            glow: None,
            heat: None,
            density: [1.0; 3],
            look: Look::default(),
        };
        let mut kelvin = None;
        for (name, value) in values(pieces)? {
            match name {
                "temperature" => file.heat = Some((value.to_owned(), 1.0)),
                "kelvin" => kelvin = Some(numbers(value)?[0]),
                "grid" => file.grid = Some(value.to_owned()),
                "glow" => file.glow = Some(value.to_owned()),
                "density" => file.density = numbers(value)?,
                _ if file.look.take(name, value)? => {}
                _ => {
                    return Err(format!(
                        "a volume has no '{name}'; valid are density, glow, grid, kelvin, temperature, {NAMES}"
                    ));
                }
            }
        }
        match (&mut file.heat, kelvin) {
            (_, None) => {}
            (Some(heat), Some(kelvin)) if kelvin > 0.0 => heat.1 = kelvin,
            (Some(_), Some(_)) => return Err("kelvin: the kelvins of a grid's unit are above 0".into()),
            (None, Some(_)) => return Err("kelvin: give temperature=NAME, too".into()),
        }
        checked(&file.look.medium(file.density))?;
        Ok(file)
    }

    /// A file by the names of its grids of density and of emission; the first name is by default "density", or that of the
    /// first grid of one number.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>, grid: Option<String>, glow: Option<String>) -> Self {
        Self { path: path.into(), grid, glow, heat: None, density: [1.0; 3], look: Look::default() }
    }

    /// The same with a grid of temperatures, and the kelvins of its unit: its emission is multiplied to that of the grid of
    /// emission.
    #[must_use]
    pub fn heated(self, grid: impl Into<String>, kelvin: f32) -> Self {
        Self { heat: Some((grid.into(), kelvin)), ..self }
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads it and adds it to a scene.
    ///
    /// # Errors
    /// [`Error::Image`] or [`Error::Volume`] if there is no such grid; the scene stays as it was.
    pub fn add_to(&self, scene: &mut Scene) -> Result<MediumId, Error> {
        let dense = self.cells()?;
        let name = self.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let medium = Medium {
            name,
            grid: Some(Arc::new(dense)),
            extent: Extent::Free,
            ..self.look.medium(self.density)
        };
        checked(&medium).map_err(|what| self.fault(&what))?;
        Ok(scene.add_medium(medium))
    }

    fn fault(&self, what: &str) -> Error {
        Error::Volume(format!("{}: {what}", self.path.display()))
    }

    /// Reads the cells round the active voxels of its grids.
    ///
    /// # Errors
    /// As [`add_to`](Self::add_to).
    pub fn cells(&self) -> Result<DensityGrid, Error> {
        let volume = Volume::read(&self.path, MOST_VOLUME_BYTES)?;
        let fault = |what: String| self.fault(&what);
        let find = |name: &str| grid_named(&volume, name).map_err(fault);
        let grid = match &self.grid {
            Some(name) => find(name)?,
            None => volume
                .grid("density")
                .or_else(|| volume.grids().iter().find(|grid| grid.channels() == 1))
                .ok_or_else(|| fault("it has no grid of one number".into()))?,
        };
        let glow = self.glow.as_deref().map(find).transpose()?;
        let Some((name, kelvin)) = &self.heat else {
            return density_grid(grid, glow, None, None).map_err(fault);
        };
        let emission = black_bodies(*kelvin).ok_or_else(|| fault("no colours of black bodies".into()))?;
        let heat = Heat { grid: find(name)?, emission: &emission };
        density_grid(grid, glow, Some(&heat), None).map_err(fault)
    }
}

/// Reads the grids of a file of OpenVDB or NanoVDB, or only those of some names. Grids without active voxels are left out.
///
/// # Errors
/// [`Error::Image`] if the file cannot be read, [`Error::Volume`] if a grid has too many cells.
pub fn read_volume(path: &Path, names: Option<&[String]>) -> Result<Vec<VolumeCells>, Error> {
    let volume = Volume::read(path, MOST_VOLUME_BYTES)?;
    let mut all = Vec::new();
    let is_wanted = |grid: &&Grid| names.is_none_or(|names| names.iter().any(|name| name == grid.name()));
    let fault = |what: String| Error::Volume(format!("{}: {what}", path.display()));
    // Before any is read: grids may take gigabytes.
    volume.grids().iter().filter(is_wanted).try_for_each(VolumeCells::check).map_err(fault)?;
    for grid in volume.grids().iter().filter(is_wanted) {
        all.extend(VolumeCells::of(grid).map_err(fault)?);
    }
    Ok(all)
}

/// Kelvins at which a black body's emission counts 1.
const UNIT_HEAT: f32 = 2000.0;

/// The emission of black bodies by temperatures in units of so many kelvins.
fn black_bodies(kelvin: f32) -> Option<impl Fn(f32) -> [f32; 3]> {
    let colors = ColorSystem::named("Rec709")?;
    let unit = colors.luminance(colors.blackbody(UNIT_HEAT));
    Some(move |temperature: f32| colors.blackbody(temperature * kelvin).map(|x| x / unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_become_numbers() {
        let fog = Fog::parse("4,8,16:albedo=0.5:anisotropy=0.25").expect("fog");
        assert_eq!(fog.medium.scattering, [0.125, 0.0625, 0.03125]);
        assert_eq!((fog.medium.absorption[0], fog.medium.phase.anisotropy), (0.125, 0.25));
        let file = VolumeFile::parse("a:b.vdb:density=2:albedo=0.25,0.5,1:grid=smoke").expect("a volume");
        assert_eq!((file.path().to_str(), file.density), (Some("a:b.vdb"), [2.0; 3]));
        for (text, part) in [
            ("0", "above 0"),
            ("x", "neither"),
            ("5:albedo=2", "at most 1"),
            ("5:anisotropy=1", "below 1"),
            ("5:colour=1", "no 'colour'"),
            ("5:albedo", "NAME=VALUE"),
        ] {
            let why = Fog::parse(text).expect_err("nonsense");
            assert!(why.contains(part), "{text}: {why}");
        }
        let hot = VolumeFile::parse("a.nvdb:temperature=heat:kelvin=1500").expect("a volume");
        assert_eq!(hot.heat, Some(("heat".into(), 1500.0)));
        assert!(VolumeFile::parse("a.vdb:kelvin=2").is_err_and(|why| why.contains("temperature=NAME")));
        assert!(VolumeFile::parse("a.vdb:density=-1").is_err_and(|why| why.contains("below 0")));
    }

    #[test]
    fn black_bodies_shine_by_their_temperature() {
        let heat = black_bodies(1.0).expect("colours");
        let luminance = |color: [f32; 3]| 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
        assert!((luminance(heat(2000.0)) - 1.0).abs() < 1e-2, "{:?}", heat(2000.0));
        assert_eq!(heat(0.0)[1], 0.0);
        // Planck's law, by a bell curve for the eye's sensitivity.
        let light = |kelvin: f64| -> f64 {
            let at = |nm: f64| {
                let seen = (-285.4 * (nm / 1000.0 - 0.559).powi(2)).exp();
                seen * nm.powi(-5) / ((1.438_777e7 / (nm * kelvin)).exp() - 1.0)
            };
            (380..780).map(|nm| at(f64::from(nm))).sum()
        };
        for kelvin in [1200.0, 1500.0, 3000.0, 5500.0] {
            let (found, expected) = (luminance(heat(kelvin)), light(f64::from(kelvin)) / light(2000.0));
            assert!((f64::from(found) / expected - 1.0).abs() < 0.1, "{kelvin} K: {found} and {expected}");
        }
        let [red, green, blue] = heat(1500.0);
        assert!(red > 2.0 * green && green > 2.0 * blue, "red hot");
    }

    #[test]
    fn fog_holds_scene_and_camera() {
        let mut scene = Scene::new();
        let id = Fog::parse("3").expect("fog").put_around(&mut scene, [1.0, 2.0, 3.0]);
        assert!(matches!(scene.medium(id).extent, Extent::Around { radius, .. } if radius == f32::INFINITY));
    }
}
