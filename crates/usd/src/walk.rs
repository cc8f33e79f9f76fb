// SPDX-License-Identifier: GPL-3.0-or-later
//! The walk over a stage: places of prims, their visibility, and their objects in the scene.
//! Shown are active, defined, visible prims of the purposes `default` and `render`. Space: metres, y up. Tests: `tests/composition.rs`.

use std::collections::HashMap;

use gnurt_scene::io::Error;
use gnurt_scene::io::Oddity;
use gnurt_scene::io::reader::{Cutter, Pictures};
use gnurt_scene::{Affine, Instance, RayMask, Scene};
use openusd::sdf::Path;

use crate::binding::Bindings;
use crate::builder::{Builder, Placed, State};
use crate::material::Materials;
use crate::reader::Reader;
use crate::skin::Skinned;

/// Prims within one another.
const DEEPEST: usize = 400;

/// The scene of a stage at its moment.
pub(crate) fn scene(reader: &Reader) -> Result<Scene, Error> {
    let mut builder = Builder {
        reader,
        scene: Scene::new(),
        bindings: Bindings::default(),
        materials: Materials::new(Pictures::new(&reader.files.access)),
        cutter: Cutter::for_file(reader.files.length()),
        objects: HashMap::new(),
        is_prototype: false,
        equal: HashMap::new(),
        prototypes: HashMap::new(),
        root: world_from_stage(reader),
        skeletons: HashMap::new(),
        lights: Vec::new(),
    };
    let state = State { world_from_parent: builder.root, is_of_purpose: true };
    let mut placed = Vec::new();
    for child in reader.children(&Path::abs_root()) {
        builder.prim(&child, &state, &mut placed)?;
    }
    for Placed { object, transform, path, luminaire } in placed {
        let instance =
            Instance { name: path, object, world_from_object: transform, visible: true, mask: RayMask::ALL };
        let id = builder.scene.add_instance(instance);
        if let Some(luminaire) = luminaire {
            builder.scene.labels_mut().luminaires.insert(id, luminaire);
        }
    }
    builder.link_lights();
    builder.settings();
    let code = |field: &str| reader.stage_number(field).unwrap_or(0.0) / reader.rate();
    builder.scene.labels_mut().times = Some(["startTimeCode", "endTimeCode"].map(code));
    Ok(builder.scene)
}

/// Metres with y up, from the stage's units and its axis.
pub(crate) fn world_from_stage(reader: &Reader) -> Affine {
    let axis = reader.stage.stage_metadata("upAxis").ok().flatten();
    let is_z = axis.as_ref().and_then(crate::value::word).is_some_and(|axis| axis == "Z");
    let rotation = match is_z {
        true => Affine { columns: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0; 3]] },
        false => Affine::IDENTITY,
    };
    rotation * Affine::scale([reader.metres_per_unit(); 3])
}

impl Builder<'_> {
    /// Adds the objects of a prim and of those below it to `placed`.
    pub(crate) fn prim(&mut self, prim: &Path, state: &State, placed: &mut Vec<Placed>) -> Result<(), Error> {
        let reader = self.reader;
        reader.count_prim()?;
        if prim.prim_element_count() > DEEPEST {
            reader.note(Oddity::BadNode, prim, format_args!("more than {DEEPEST} prims lie in one another"));
            return Ok(());
        }
        let kind = reader.kind(prim);
        if matches!(&kind[..], "Material" | "Shader" | "NodeGraph" | "GeomSubset") {
            return Ok(());
        }
        if reader.word(prim, "visibility").as_deref() == Some("invisible") {
            return Ok(());
        }
        let state = self.state(prim, state);
        self.show(prim, &kind, &state, placed)?;
        if kind == "PointInstancer" {
            // Its prototypes are shown by it alone.
            return Ok(());
        }
        for child in reader.children(prim) {
            self.prim(&child, &state, placed)?;
        }
        Ok(())
    }

    fn state(&self, prim: &Path, above: &State) -> State {
        let local = self.reader.local(prim);
        let from = if local.resets { self.root } else { above.world_from_parent };
        let mut state = State { world_from_parent: from * local.parent_from_prim, ..above.clone() };
        if let Some(purpose) = self.reader.word(prim, "purpose") {
            state.is_of_purpose = matches!(&purpose[..], "default" | "render");
        }
        state
    }

    fn show(
        &mut self,
        prim: &Path,
        kind: &str,
        state: &State,
        placed: &mut Vec<Placed>,
    ) -> Result<(), Error> {
        if !state.is_of_purpose {
            return Ok(());
        }
        let reader = self.reader;
        let is_light = kind.ends_with("Light") || reader.has_schema(prim, "MeshLightAPI");
        if is_light {
            self.light(prim, kind, state, placed);
            return Ok(());
        }
        let object = match kind {
            "" | "Scope" | "Xform" | "SkelRoot" | "Skeleton" | "SkelAnimation" | "BlendShape" => None,
            "Mesh" => match self.skinned_mesh(prim, state) {
                Skinned::At(object, transform) => {
                    self.add_instance(prim, object, transform, placed);
                    None
                }
                Skinned::Not => self.mesh(prim, None),
                Skinned::Nothing => None,
            },
            "PointInstancer" => self.instancer(prim, state)?,
            "BasisCurves" | "Points" => self.strands(prim, kind),
            "Camera" => {
                self.camera(prim, state);
                None
            }
            "Volume" => {
                self.volume(prim, state);
                None
            }
            "Cube" | "Sphere" | "Cylinder" | "Cylinder_1" | "Cone" | "Capsule" | "Capsule_1" | "Plane" => {
                self.shape(prim, kind)
            }
            "NurbsPatch" | "NurbsCurves" | "HermiteCurves" | "TetMesh" | "PluginLight" => {
                reader.unsupported(prim, kind);
                None
            }
            _ => None,
        };
        if let Some(object) = object {
            self.add_instance(prim, object, state.world_from_parent, placed);
        }
        Ok(())
    }
}
