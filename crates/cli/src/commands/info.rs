// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt info FILE`: the contents of a scene or of a picture, as a table or as JSON. Triangles and vertices count once per
//! mesh; `instanced` counts them once per instance.
//! Tests: `tests/program/info.rs`.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use gnurt::defaults::{Bounds, bounds_of};
use gnurt::render::{CommitOptions, ShaderTable, World, WorldStats};
use gnurt::scene::animation::Clip;
use gnurt::scene::{Animation, Light, Mesh, Primitives, Scene};
use gnurt_view::camera_options;
use serde_json::{Value, json};

use super::{contents, picture_info};
use crate::arguments::InfoArguments;
use crate::clips::clip;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::source::Source;
use crate::workers::machine;
use gnurt::memory::format_bytes as bytes;

/// Prints the contents of a scene.
pub(crate) fn run(arguments: &InfoArguments, environment: &Environment, messages: Messages) -> Outcome {
    let path = Path::new(&arguments.scene);
    if gnurt::image::PictureFormat::is_named_any(path) && path.exists() {
        return picture_info::run(path, arguments.json);
    }
    let source = Source::find(&arguments.scene, &arguments.files, environment)?;
    let source = arguments.at.map_or_else(|| source.clone(), |seconds| source.at_moment(seconds));
    let mut scene = source.load(messages)?;
    if let (Some(seconds), Some(clip)) = (arguments.at, clip(&scene, None)?) {
        scene.pose(clip, seconds);
    }
    let scene = scene;
    let tree = arguments.tree.then(|| build(&scene, arguments, environment)).transpose()?;
    let inventory = Inventory::of(&scene);
    if arguments.json {
        print(inventory.to_json(&source.name(), &scene, tree.as_ref()))
    } else {
        print(inventory.to_text(&source.name(), &scene, tree.as_ref()).trim_end())
    }
}

/// At most this many names of materials are printed; a large scene has thousands.
const MOST_NAMES: usize = 48;
const NAMES_OF_A_LINE: usize = 6;

/// Size and time of the trees of a scene.
struct Tree {
    stats: WorldStats,
    seconds: f64,
}

fn build(scene: &Scene, arguments: &InfoArguments, environment: &Environment) -> Result<Tree, Failure> {
    let (pool, level) = machine(&arguments.machine, environment)?;
    let mut world = World::new();
    let options = CommitOptions { level, memory: arguments.trees.memory, ..CommitOptions::default() };
    let report = world.commit(scene, &ShaderTable::default(), &options, &pool).map_err(Failure::data)?;
    Ok(Tree { stats: world.stats(), seconds: report.build_seconds })
}

/// Counts.
struct Inventory {
    triangles: usize,
    /// Segments of curves, and spheres.
    curves: usize,
    spheres: usize,
    instanced: usize,
    emitting: usize,
    shining_spheres: usize,
    vertices: usize,
    mesh_bytes: usize,
    texture_bytes: usize,
    bounds: Option<Bounds>,
}

fn spheres_of(mesh: &Mesh) -> usize {
    if matches!(mesh.primitives, Primitives::Spheres(_)) { mesh.primitive_count() } else { 0 }
}

impl Inventory {
    fn of(scene: &Scene) -> Self {
        let meshes = scene.meshes();
        let emits =
            |mesh: &&Arc<Mesh>| scene.materials().get(mesh.material.index()).is_some_and(|m| m.emits());
        let of_objects = scene.unfolded_triangles().unwrap_or_default();
        let of_instances =
            scene.instances().iter().filter_map(|instance| of_objects.get(instance.object.index()));
        let count = |is: fn(&Primitives) -> bool| {
            let some = meshes.iter().filter(|mesh| is(&mesh.primitives));
            some.map(|mesh| mesh.primitive_count()).sum()
        };
        Self {
            curves: count(|primitives| matches!(primitives, Primitives::Curves(_))),
            spheres: count(|primitives| matches!(primitives, Primitives::Spheres(_))),
            triangles: meshes.iter().map(|mesh| mesh.indices.len()).sum(),
            instanced: of_instances.fold(0, |sum: u64, count| sum.saturating_add(*count)) as usize,
            emitting: meshes.iter().filter(emits).map(|mesh| mesh.indices.len()).sum(),
            shining_spheres: meshes.iter().filter(emits).map(|mesh| spheres_of(mesh)).sum(),
            vertices: meshes.iter().map(|mesh| mesh.positions.len()).sum(),
            mesh_bytes: meshes.iter().map(|mesh| mesh.memory_bytes()).sum(),
            texture_bytes: scene.textures().iter().map(|texture| texture.texels.memory_bytes()).sum(),
            bounds: bounds_of(scene),
        }
    }

    fn to_json(&self, name: &str, scene: &Scene, tree: Option<&Tree>) -> Value {
        let mut report = json!({
            "scene": name,
            "triangles": self.triangles,
            "curves": self.curves,
            "spheres": self.spheres,
            "instanced_triangles": self.instanced,
            "vertices": self.vertices,
            "meshes": scene.meshes().len(),
            "objects": scene.objects().len(),
            "instances": scene.instances().len(),
            "materials": scene.materials().len(),
            "textures": scene.textures().len(),
            "lights": contents::lights(scene),
            "emissive_triangles": self.emitting,
            "emissive_spheres": self.shining_spheres,
            "cameras": contents::cameras(scene),
            "bounds": self.bounds.map(|bounds| json!({ "min": bounds.min, "max": bounds.max })),
            "memory": {
                "meshes": self.mesh_bytes,
                "textures": self.texture_bytes,
                "total": self.mesh_bytes + self.texture_bytes,
            },
            "animations": clips(scene).map(|(clip, [first, last])| json!({
                "name": clip.name,
                "first_seconds": first,
                "last_seconds": last,
                "channels": clip.channels.len(),
            })).collect::<Vec<_>>(),
            "skins": scene.animation().map_or(0, |animation| animation.skins.len()),
            "joints": joints(scene),
            "morph_targets": morph_targets(scene),
            "occurrences": contents::occurrences(scene),
            "moments": scene.labels().times.map(|[first, last]| json!({ "first": first, "last": last })),
            "material_names": scene.materials().iter().map(|material| &material.name[..]).collect::<Vec<_>>(),
            "camera_names": scene.cameras().iter().map(|camera| &camera.name[..]).collect::<Vec<_>>(),
        });
        if let (Some(tree), Value::Object(report)) = (tree, &mut report) {
            let Tree { stats, seconds } = tree;
            let value =
                json!({ "nodes": stats.tree_nodes, "bytes": stats.tree_bytes, "build_seconds": seconds });
            report.insert("tree".into(), value);
        }
        report
    }

    fn to_text(&self, name: &str, scene: &Scene, tree: Option<&Tree>) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        let mut row = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<12}{value}");
        };
        row("scene", name.to_owned());
        row("triangles", format!("{} ({} with instances)", self.triangles, self.instanced));
        for (name, count) in [("curves", self.curves), ("spheres", self.spheres)] {
            if count > 0 {
                row(name, count.to_string());
            }
        }
        row("vertices", self.vertices.to_string());
        row("meshes", scene.meshes().len().to_string());
        row("objects", scene.objects().len().to_string());
        row("instances", scene.instances().len().to_string());
        row("materials", scene.materials().len().to_string());
        // The names that --shader takes.
        for names in scene.materials().iter().take(MOST_NAMES).collect::<Vec<_>>().chunks(NAMES_OF_A_LINE) {
            let names: Vec<String> = names.iter().map(|material| format!("'{}'", material.name)).collect();
            row("", names.join(", "));
        }
        match scene.materials().len().saturating_sub(MOST_NAMES) {
            0 => {}
            more => row("", format!("and {more} more, which --json lists")),
        }
        row("textures", scene.textures().len().to_string());
        let spheres = match self.shining_spheres {
            0 => String::new(),
            1 => ", 1 emissive sphere".to_owned(),
            some => format!(", {some} emissive spheres"),
        };
        row("lights", format!("{}, {} emissive triangles{spheres}", lights(scene.lights()), self.emitting));
        row("cameras", scene.cameras().len().to_string());
        for (index, camera) in scene.cameras().iter().enumerate() {
            row("", format!("{index} '{}': {}", camera.name, camera_options(camera)));
        }
        if let Some(animation) = scene.animation() {
            row("animations", animation.clips.len().to_string());
            for (index, (clip, [first, last])) in clips(scene).enumerate() {
                let channels = clip.channels.len();
                row("", format!("{index} '{}': {first} to {last} s, {channels} channels", clip.name));
            }
            let (skins, targets) = (animation.skins.len(), morph_targets(scene));
            row("", format!("{skins} skins of {} joints, {targets} morph targets", joints(scene)));
        }
        row(
            "bounds",
            self.bounds.map_or("nothing to see".into(), |b| corner(b.min) + " to " + &corner(b.max)),
        );
        let (meshes, textures) = (bytes(self.mesh_bytes as u64), bytes(self.texture_bytes as u64));
        row("memory", format!("{meshes} of meshes, {textures} of textures"));
        if let Some(Tree { stats, seconds }) = tree {
            let size = bytes(stats.tree_bytes as u64);
            row("trees", format!("{} nodes, {size}, built in {seconds:.2} s", stats.tree_nodes));
        }
        text
    }
}

/// The clips, with the times of their first and last keys.
fn clips(scene: &Scene) -> impl Iterator<Item = (&Clip, [f64; 2])> {
    let clips = scene.animation().map_or(&[][..], |animation: &Animation| &animation.clips);
    // As the file writes them.
    clips.iter().map(|clip| (clip, clip.range().map(rounded)))
}

/// A time without the digits that single precision does not have.
fn rounded(seconds: f64) -> f64 {
    (seconds as f32).to_string().parse().unwrap_or(seconds)
}

/// Joints of all skins that move.
fn joints(scene: &Scene) -> usize {
    scene.animation().map_or(0, |animation| animation.skins.iter().map(|skin| skin.joints.len()).sum())
}

/// Morph targets of all sets of weights that bend something.
fn morph_targets(scene: &Scene) -> usize {
    scene.animation().map_or(0, |animation| animation.weights.iter().map(Vec::len).sum())
}

/// A position to six digits, as in single precision.
fn corner(point: [f64; 3]) -> String {
    format!("({})", point.map(|x| (x as f32).to_string()).join(", "))
}

/// `3 (1 point, 2 spot)`.
fn lights(lights: &[Light]) -> String {
    let kind = |light: &Light| match light {
        Light::Point { .. } => "point",
        Light::Spot { .. } => "spot",
        Light::Directional { .. } => "directional",
        Light::Environment { .. } => "environment",
        Light::Backdrop { .. } => "backdrop",
    };
    let counts = ["point", "spot", "directional", "environment", "backdrop"]
        .map(|name| (lights.iter().filter(|light| kind(light) == name).count(), name));
    let named: Vec<String> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    if named.is_empty() { "0".into() } else { format!("{} ({})", lights.len(), named.join(", ")) }
}
