// SPDX-License-Identifier: GPL-3.0-or-later
//! The statement `Camera`, and which way the file's world is mirrored.
//! pbrt's camera looks along +z with x to the right: left-handed. The renderer is right-handed, so the world is mirrored along x, unless the
//! camera's transform mirrors already, as many exporters have it. Source: the section Cameras of the file-format page.
//! Tests: `tests/view.rs`.

use gnurt_scene::io::reader::quoted;
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::{Affine, Camera, Lens, Projection, ShaderFile};

use crate::film::Film;
use crate::parameter::{Kind, Parameters};
use crate::transform::{dot, single};

/// A camera as its statement says it.
pub(crate) struct View {
    pub(crate) camera: Camera,
    /// What makes its rays, if no camera of the renderer's does.
    pub(crate) shader: Option<ShaderFile>,
    /// From the file's world to the renderer's.
    pub(crate) world_from_file: Affine,
    /// Seconds.
    pub(crate) shutter: [f32; 2],
}

/// All directions by the map that keeps areas.
const EQUAL_AREA: &str = r#"
camera equal_area ()
{
    float x = 2 * u - 1, y = 1 - 2 * v;
    float across = fabs (x), along = fabs (y);
    float within = 1 - (across + along);
    float r = 1 - fabs (within);
    float phi = (r == 0 ? 1 : (along - across) / r + 1) * M_PI / 4;
    float z = within < 0 ? r * r - 1 : 1 - r * r;
    float side = r * sqrt (max (0, 2 - r * r));
    float dx = cos (phi) * side * (x < 0 ? -1 : 1), dy = sin (phi) * side * (y < 0 ? -1 : 1);
    P = point ("camera", 0, 0, 0);
    I = normalize (vector ("camera", dx, z, -dy));
}
"#;

/// A window that is not in the middle, or whose pixels are not square.
const WINDOW: &str = r#"
camera window (float left = -1, float right = 1, float lower = -1, float upper = 1, float slope = 1, int parallel = 0,
    float lens = 0, float focus = 1)
{
    float x = mix (left, right, u) * slope, y = mix (lower, upper, v) * slope;
    float a = 0, b = 0;
    if (lens > 0) {
        float r = lens * sqrt (xi[0]);
        a = r * cos (M_2PI * xi[1]);
        b = r * sin (M_2PI * xi[1]);
    }
    if (parallel) {
        P = point ("camera", x, y, 0);
        I = normalize (vector ("camera", 0, 0, -1));
    } else {
        P = point ("camera", a, b, 0);
        I = normalize (vector ("camera", x - a / focus, y - b / focus, -1));
    }
}
"#;

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// The camera of a class, from the world's space to its own.
pub(crate) fn read(
    class: &str,
    parameters: &Parameters,
    camera_from_file: &Affine,
    film: &Film,
    warnings: &mut Warnings,
) -> Result<View, Error> {
    let location = &parameters.location;
    let file_from_camera = camera_from_file
        .inverse()
        .ok_or_else(|| location.error("the camera's transform flattens space", "it must have an inverse"))?;
    let is_mirrored = file_from_camera.determinant() < 0.0;
    let panorama = class == "spherical" && parameters.text("mapping")? == Some("equirectangular");
    // A panorama's middle is the camera's -x, and goes on to -z: that is right-handed.
    let mirror = is_mirrored == panorama;
    let world_from_file = if mirror { Affine::scale([-1.0, 1.0, 1.0]) } else { Affine::IDENTITY };
    let frame = world_from_file * file_from_camera;
    let [right, up, forward, eye] = frame.columns;
    let [wide, high, deep] = [right, up, forward].map(length);

    let frame_aspect = film.size[0] as f32 / film.size[1] as f32;
    let aspect = parameters.float_or("frameaspectratio", frame_aspect)?;
    if !(aspect > 0.0 && aspect.is_finite()) {
        return Err(location.error(format!("\"frameaspectratio\" is {aspect}"), "it must be above 0"));
    }
    let mut window = match aspect > 1.0 {
        true => [-aspect, aspect, -1.0, 1.0],
        false => [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect],
    };
    match parameters.floats("screenwindow") {
        Some(&[left, right, lower, upper]) if left < right && lower < upper => {
            window = [left, right, lower, upper]
        }
        Some(other) => {
            let problem = format!("\"screenwindow\" is {other:?}");
            return Err(location.error(problem, "give left, right, lower, upper, each pair ascending"));
        }
        None => {}
    }
    let lens = parameters.float_or("lensradius", 0.0)?.max(0.0);
    let focus = parameters.float_or("focaldistance", 1e6)?;
    if lens > 0.0 && !(focus > 0.0 && focus.is_finite()) {
        return Err(location.error(format!("\"focaldistance\" is {focus}"), "it must be above 0"));
    }
    let shutter = [parameters.float_or("shutteropen", 0.0)?, parameters.float_or("shutterclose", 1.0)?];
    let [left, across, lower, upper] = window;
    let pixel = [
        (across - left) * wide as f32 / film.size[0] as f32,
        (upper - lower) * high as f32 / film.size[1] as f32,
    ];
    let is_square = (pixel[0] / pixel[1] - 1.0).abs() < 1e-3;
    let is_middle =
        (left + across).abs() < 1e-4 * (across - left) && (lower + upper).abs() < 1e-4 * (upper - lower);

    let target = |along: [f64; 3]| [0, 1, 2].map(|k| eye[k] + along[k]);
    let mut camera = Camera {
        name: "pbrt".into(),
        eye: single(eye),
        target: single(target(forward)),
        up: single(up),
        ..Camera::default()
    };
    let mut shader = None;
    let mut windowed = |slope: f64, parallel: bool| {
        let of = |value: f64| format!("{value}");
        let [sides, heights] = [wide / deep, high / deep];
        let list = [
            ("left", f64::from(left) * sides),
            ("right", f64::from(across) * sides),
            ("lower", f64::from(lower) * heights),
            ("upper", f64::from(upper) * heights),
            ("slope", if parallel { deep } else { slope }),
            ("parallel", f64::from(u8::from(parallel))),
            ("lens", f64::from(lens) * deep),
            ("focus", f64::from(focus) * deep),
        ];
        shader = Some(ShaderFile {
            file: "window.osl".into(),
            text: Some(WINDOW.into()),
            parameters: list.map(|(name, value)| (name.to_owned(), of(value))).to_vec(),
            ..ShaderFile::default()
        });
    };
    let thin =
        || Lens { aperture: 2.0 * lens * deep as f32, focus: (lens > 0.0).then_some(focus * deep as f32) };
    match class {
        "perspective" | "realistic" => {
            let mut fov = parameters.float_or("fov", 90.0)?;
            if class == "realistic" {
                location.warn(warnings, Oddity::StandIn, "camera \"realistic\", a pinhole of a normal lens");
                parameters.ignore();
                fov = 40.0;
            }
            if !(fov > 0.0 && fov < 180.0) {
                return Err(location.error(
                    format!("\"fov\" is {fov}"),
                    "an angle of view is above 0 and below 180 degrees",
                ));
            }
            let slope = (f64::from(fov).to_radians() / 2.0).tan();
            camera.fov_y = (2.0 * (slope * f64::from(upper) * high / deep).atan()).to_degrees() as f32;
            camera.lens = thin();
            if !(is_square && is_middle) {
                camera.fov_y = (2.0 * (slope * f64::from((upper - lower) / 2.0) * high / deep).atan())
                    .to_degrees() as f32;
                windowed(slope, false);
            }
        }
        "orthographic" => {
            camera.projection = Projection::Orthographic { height: (upper - lower) * high as f32 };
            camera.lens = thin();
            if !(is_square && is_middle) {
                windowed(1.0, true);
            }
        }
        "spherical" if panorama => {
            camera.projection = Projection::Panorama;
            camera.target = single(target(right.map(|x| -x)));
        }
        "spherical" => match parameters.text("mapping")?.unwrap_or("equalarea") {
            "equalarea" => {
                camera.projection = Projection::Panorama;
                let text = Some(EQUAL_AREA.into());
                shader = Some(ShaderFile { file: "equal_area.osl".into(), text, ..ShaderFile::default() });
            }
            other => {
                let problem = format!("unknown mapping {} of a spherical camera", quoted(other));
                return Err(location.error(problem, "valid are equalarea and equirectangular"));
            }
        },
        other => {
            let known = "orthographic, perspective, realistic and spherical";
            return Err(
                location.error(format!("unknown camera {}", quoted(other)), format!("valid are {known}"))
            );
        }
    }
    parameters.find("medium", &[Kind::Text]);
    if let Some(fault) = camera.fault() {
        return Err(location.error(
            format!("the camera cannot be used: {fault}"),
            "look at LookAt and the transform before it",
        ));
    }
    Ok(View { camera, shader, world_from_file, shutter })
}
