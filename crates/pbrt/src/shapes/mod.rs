// SPDX-License-Identifier: GPL-3.0-or-later
//! The statement `Shape`: each kind as a mesh of triangles, in its own space.
//! Source: the section Shapes of the file-format page. Invariant: the geometric normal is on pbrt's side; where a shape has
//! normals, its triangles turn to their side. Tests: `tests/shapes.rs`.

mod bilinear;
mod curve;
mod grid;
mod loops;
mod quadric;
mod reading;
mod triangles;

use gnurt_scene::io::reader::quoted;
use gnurt_scene::io::{Error, Oddity};
use gnurt_scene::{Affine, Mesh};

pub(crate) use reading::Reading;

use crate::parameter::{Kind, Parameters};
use crate::transform::{cross, dot, double};

/// The mesh of a shape, and its signature, if equal shapes share one mesh. A sphere is one of radius 1: its size goes into the transform.
pub(crate) fn read(
    class: &str,
    parameters: &Parameters,
    reading: &mut Reading,
    transforms: &mut [Affine; 2],
) -> Result<(Mesh, Option<String>), Error> {
    let mut signature = None;
    let location = &parameters.location;
    if parameters.texture("displacement")?.is_some() {
        location.warn(reading.warnings, Oddity::NotShown, "\"displacement\" of a shape");
        parameters.find("edgelength", &[Kind::Float]);
    }
    let mut mesh = match class {
        "trianglemesh" => triangles::mesh(parameters, reading)?,
        "plymesh" => triangles::ply(parameters, reading)?,
        "bilinearmesh" => bilinear::mesh(parameters, reading)?,
        "loopsubdiv" => loops::mesh(parameters, reading)?,
        "sphere" => {
            let (mesh, radius, shape) = quadric::sphere(parameters, reading.takes_spheres)?;
            transforms.iter_mut().for_each(|transform| *transform = *transform * Affine::scale([radius; 3]));
            signature = Some(format!("{shape} {}", reading.reversed));
            mesh
        }
        "disk" => quadric::disk(parameters)?,
        "cylinder" => quadric::cylinder(parameters)?,
        "curve" => curve::mesh(parameters, reading)?,
        other => {
            let known = "bilinearmesh, curve, cylinder, disk, loopsubdiv, plymesh, sphere and trianglemesh";
            return Err(
                location.error(format!("unknown shape {}", quoted(other)), format!("valid are {known}"))
            );
        }
    };
    parameters.find("emissionfilename", &[Kind::Text]);
    hold(&mesh, parameters, reading)?;
    if reading.reversed {
        mesh.normals.iter_mut().for_each(|n| *n = n.map(|x| -x));
        mesh.indices.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    turn_to_normals(&mut mesh);
    Ok((mesh, signature))
}

fn hold(mesh: &Mesh, parameters: &Parameters, reading: &Reading) -> Result<(), Error> {
    reading.access.budget.hold(mesh.memory_bytes()).map_err(|e| parameters.location.excess(e))
}

/// Turns triangles to the side of their corners' normals.
fn turn_to_normals(mesh: &mut Mesh) {
    let (positions, normals) = (&mesh.positions, &mesh.normals);
    if normals.is_empty() {
        return;
    }
    for triangle in &mut mesh.indices {
        let [a, b, c] = triangle.map(|i| double(positions[i as usize]));
        let minus = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
        let outer = cross(minus(b), minus(c));
        let sum: f64 = triangle.iter().map(|&i| dot(outer, double(normals[i as usize]))).sum();
        if sum < 0.0 {
            triangle.swap(1, 2);
        }
    }
}
