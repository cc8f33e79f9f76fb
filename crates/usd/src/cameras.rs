// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras and the picture that a stage wants: apertures and focal lengths in tenths of the stage's unit.
//! Source: UsdGeomCamera, UsdRenderSettings. Space: world, in metres. Tests: `tests/cameras.rs`.

use gnurt_scene::io::Oddity;
use gnurt_scene::{Camera, Lens, Projection};
use openusd::sdf::Path;

use crate::builder::{Builder, State};
use crate::value;

impl Builder<'_> {
    /// Adds a camera.
    pub(crate) fn camera(&mut self, prim: &Path, state: &State) {
        let reader = self.reader;
        let number = |name: &str, fallback: f64| reader.number_or(prim, name, fallback);
        let transform = &state.world_from_parent;
        let (vertical, focal) = (number("verticalAperture", 15.2908), number("focalLength", 50.0));
        let unit = self.root.determinant().abs().cbrt();
        let is_parallel = reader.word(prim, "projection").as_deref() == Some("orthographic");
        let direction = unit_vector(transform.vector([0.0, 0.0, -1.0]));
        let eye = transform.point([0.0; 3]);
        let focus = number("focusDistance", 0.0) * unit;
        let reach = if focus > 0.0 { focus } else { 1.0 };
        let target: [f64; 3] = std::array::from_fn(|k| eye[k] + direction[k] * reach);
        let stop = number("fStop", 0.0);
        // The diameter of the aperture is the focal length over the stop.
        let aperture = if stop > 0.0 && focus > 0.0 { focal / 10.0 * unit / stop } else { 0.0 };
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        let camera = Camera {
            name: prim.as_str().to_owned(),
            eye: single(eye),
            target: single(target),
            up: single(unit_vector(transform.vector([0.0, 1.0, 0.0]))),
            fov_y: (2.0 * (vertical / 2.0).atan2(focal)).to_degrees() as f32,
            projection: match is_parallel {
                true => Projection::Orthographic { height: (vertical / 10.0 * unit) as f32 },
                false => Projection::Perspective,
            },
            lens: Lens { aperture: aperture as f32, focus: (focus > 0.0).then_some(focus as f32) },
            shift: ["horizontalApertureOffset", "verticalApertureOffset"]
                .map(|name| (number(name, 0.0) / vertical) as f32),
        };
        if reader
            .value(prim, "clippingPlanes")
            .as_ref()
            .and_then(value::vectors::<4>)
            .is_some_and(|p| !p.is_empty())
        {
            reader.unsupported(prim, "clippingPlanes");
        }
        match camera.fault() {
            None => {
                self.scene.add_camera(camera);
            }
            Some(fault) => reader.note(Oddity::BadCamera, prim, fault),
        }
    }

    /// The camera and the size of the picture that the stage's render settings name.
    pub(crate) fn settings(&mut self) {
        let reader = self.reader;
        let named = reader.stage.stage_metadata("renderSettingsPrimPath").ok().flatten();
        let named = named.as_ref().and_then(value::word).and_then(|path| Path::new(&path).ok());
        let render = Path::new("/Render").ok();
        let found = named.or_else(|| {
            let below = render.map(|render| reader.children(&render)).unwrap_or_default();
            below.into_iter().find(|prim| reader.kind(prim) == "RenderSettings")
        });
        let Some(settings) = found else { return };
        let camera = reader.targets(&settings, "camera").into_iter().next();
        let index_of = |camera: &Path| self.scene.cameras().iter().position(|c| c.name == camera.as_str());
        let camera = camera.as_ref().and_then(index_of);
        let resolution = reader.value(&settings, "resolution").as_ref().and_then(value::vector::<2>);
        let outputs = self.outputs(&settings);
        let labels = self.scene.labels_mut();
        labels.outputs = outputs;
        labels.camera = camera.map(|index| gnurt_scene::CameraId(index as u32));
        labels.resolution =
            resolution.filter(|size| size.iter().all(|&n| n >= 1.0)).map(|size| size.map(|n| n as u32));
    }
}

impl Builder<'_> {
    /// The layers of the products of render settings. Source: UsdRender: RenderVar's `sourceName` and `sourceType`.
    fn outputs(&self, settings: &Path) -> Vec<String> {
        let reader = self.reader;
        let products = reader.targets(settings, "products").into_iter();
        let variables = products.flat_map(|product| reader.targets(&product, "orderedVars"));
        let mut outputs = Vec::new();
        for variable in variables {
            let source = reader.word(&variable, "sourceName").unwrap_or_default();
            let kind = reader.word(&variable, "sourceType").unwrap_or_else(|| "raw".into());
            let name = variable.name().unwrap_or_default().to_owned();
            let expression = source.strip_prefix("lpe:").unwrap_or(&source);
            let output = match (&kind[..], &source.to_lowercase()[..]) {
                ("lpe", _) => Some(format!("{name}={expression}")),
                // The picture itself.
                ("raw", "ci" | "color" | "rgb" | "rgba" | "a" | "alpha" | "") => continue,
                ("raw", "z" | "depth") => Some("depth".into()),
                ("raw", "n" | "nn" | "normal") => Some("normal".into()),
                ("raw", "p" | "position") => Some("position".into()),
                ("raw", "albedo" | "cryptomatte" | "direct" | "indirect" | "emission") => {
                    Some(source.to_lowercase())
                }
                _ => None,
            };
            match output {
                Some(output) if !outputs.contains(&output) => outputs.push(output),
                Some(_) => {}
                None => reader.unsupported(&variable, format_args!("the render variable {kind} '{source}'")),
            }
        }
        outputs
    }
}

fn unit_vector(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { v }
}
