// SPDX-License-Identifier: GPL-3.0-or-later
//! Prims of a scene: meshes, instances, cameras. Tests: `tests/save.rs`.

use gnurt_scene::{Affine, Camera, MaterialId, Mesh, Object, ObjectId, Primitives, Projection, Scene};

use super::text::{Text, VERTEX, tuple};
use super::transforms::{frame, write_transform};
use super::{lights, materials, strands};

/// Writes all of a scene; `files`: the names of its textures.
pub(super) fn write(scene: &Scene, files: &[String], text: &mut Text) {
    text.line("#usda 1.0");
    text.line("(");
    text.line("    defaultPrim = \"World\"");
    text.line("    metersPerUnit = 1");
    text.line("    upAxis = \"Y\"");
    text.line(")");
    text.line("");
    let mut uses = vec![0_u32; scene.objects().len()];
    let placed = scene.instances().iter().filter(|instance| instance.visible).map(|instance| instance.object);
    let within = scene.objects().iter().flat_map(|object| object.members.iter().map(|member| member.object));
    placed.chain(within).for_each(|object| uses[object.index()] += 1);
    let writer =
        Writer { scene, is_shared: uses.into_iter().map(|uses| uses > 1).collect(), looks: Vec::new() };
    writer.world(files, text);
}

struct Writer<'a> {
    scene: &'a Scene,
    /// By object: whether it occurs more than once.
    is_shared: Vec<bool>,
    /// Paths of materials.
    looks: Vec<String>,
}

impl Writer<'_> {
    fn world(mut self, files: &[String], text: &mut Text) {
        let scene = self.scene;
        text.open("def Xform", "World", &[]);
        text.open("def Scope", "Looks", &[]);
        for (material, id) in scene.materials().iter().zip((0..).map(MaterialId)) {
            let displacement = scene.displacement(id);
            let name = materials::write((material, displacement), scene, files, text);
            self.looks.push(format!("/World/Looks/{name}"));
        }
        text.close();
        for instance in scene.instances().iter().filter(|instance| instance.visible) {
            self.write_instance(&instance.name, instance.object, &instance.world_from_object, text);
        }
        for camera in scene.cameras() {
            write_camera(camera, text);
        }
        for (light, id) in scene.lights().iter().zip(0..) {
            let name = scene.labels().lights.get(&gnurt_scene::LightId(id)).map(|name| &name[..]);
            lights::write(light, name.unwrap_or("Light"), files, text);
        }
        text.close();
        if self.is_shared.contains(&true) {
            text.open("class Scope", "Prototypes", &[]);
            for (id, object) in scene.objects().iter().enumerate().filter(|&(id, _)| self.is_shared[id]) {
                text.open("def Xform", &format!("Object{id}"), &[]);
                self.contents(object, text);
                text.close();
            }
            text.close();
        }
    }

    /// An object at a place.
    fn write_instance(&self, name: &str, object: ObjectId, transform: &Affine, text: &mut Text) {
        let is_shared = self.is_shared[object.index()];
        let metadata = match is_shared {
            true => vec![
                "instanceable = true".to_owned(),
                format!("prepend references = </Prototypes/Object{}>", object.index()),
            ],
            false => Vec::new(),
        };
        let name = if name.is_empty() { "Object" } else { name };
        text.open("def Xform", name, &metadata);
        write_transform(transform, text);
        if !is_shared {
            self.contents(self.scene.object(object), text);
        }
        text.close();
    }

    fn contents(&self, object: &Object, text: &mut Text) {
        for mesh in object.meshes.iter().map(|&id| self.scene.mesh(id)) {
            self.mesh(mesh, text);
        }
        for member in &object.members {
            self.write_instance(
                &self.scene.object(member.object).name,
                member.object,
                &member.object_from_member,
                text,
            );
        }
    }

    fn mesh(&self, mesh: &Mesh, text: &mut Text) {
        let look = self.looks.get(mesh.material.index());
        let metadata = look.map(|_| "prepend apiSchemas = [\"MaterialBindingAPI\"]".to_owned());
        let (head, fallback) = match mesh.primitives {
            Primitives::Triangles => ("def Mesh", "Mesh"),
            Primitives::Curves(_) => ("def BasisCurves", "Curves"),
            Primitives::Spheres(_) => ("def Points", "Points"),
        };
        text.open(head, if mesh.name.is_empty() { fallback } else { &mesh.name }, metadata.as_slice());
        match &mesh.primitives {
            Primitives::Triangles => write_triangles(mesh, text),
            Primitives::Curves(curves) => strands::write_curves(mesh, curves, text),
            Primitives::Spheres(radii) => strands::write_spheres(mesh, radii, text),
        }
        if let Some(look) = look {
            text.line(format_args!("rel material:binding = <{look}>"));
        }
        text.close();
    }
}

fn write_triangles(mesh: &Mesh, text: &mut Text) {
    text.line("uniform token subdivisionScheme = \"none\"");
    text.numbers("int[] faceVertexCounts", mesh.indices.iter().map(|_| 3), "");
    text.numbers("int[] faceVertexIndices", mesh.indices.as_flattened().iter(), "");
    text.vectors("point3f[] points", mesh.positions.iter().copied(), "");
    let (least, most) = extent(mesh);
    text.line(format_args!("float3[] extent = [{}, {}]", tuple(least), tuple(most)));
    if !mesh.normals.is_empty() {
        text.vectors("normal3f[] normals", mesh.normals.iter().copied(), VERTEX);
    }
    if !mesh.texcoords.is_empty() {
        text.vectors("texCoord2f[] primvars:st", mesh.texcoords.iter().copied(), VERTEX);
    }
    if !mesh.colors.is_empty() {
        text.vectors(
            "color3f[] primvars:displayColor",
            mesh.colors.iter().map(|&[r, g, b, _]| [r, g, b]),
            VERTEX,
        );
        if mesh.colors.iter().any(|color| color[3] != 1.0) {
            text.numbers("float[] primvars:displayOpacity", mesh.colors.iter().map(|color| color[3]), VERTEX);
        }
    }
}

fn extent(mesh: &Mesh) -> ([f32; 3], [f32; 3]) {
    let all = || mesh.positions.iter().copied();
    let fold = |pick: fn(f32, f32) -> f32| {
        all().reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default()
    };
    (fold(f32::min), fold(f32::max))
}

/// Apertures and focal lengths in tenths of a metre: a film that is 24 mm high.
fn write_camera(camera: &Camera, text: &mut Text) {
    const FILM: f32 = 0.24;
    let Some(axes) = camera.frame() else { return };
    text.open("def Camera", if camera.name.is_empty() { "Camera" } else { &camera.name }, &[]);
    write_transform(&frame([axes.right, axes.up, axes.forward.map(|x| -x)], camera.eye), text);
    let focus = camera.focus_distance();
    let (height, focal) = match camera.projection {
        Projection::Orthographic { height } => {
            text.line("token projection = \"orthographic\"");
            (10.0 * height, 0.5)
        }
        _ => (FILM, FILM / 2.0 / (camera.fov_y.to_radians() / 2.0).tan()),
    };
    text.line(format_args!("float verticalAperture = {height}"));
    text.line(format_args!("float horizontalAperture = {}", 1.5 * height));
    text.line(format_args!("float focalLength = {focal}"));
    text.line(format_args!("float focusDistance = {focus}"));
    for (name, shift) in ["horizontalApertureOffset", "verticalApertureOffset"].into_iter().zip(camera.shift)
    {
        if shift != 0.0 {
            text.line(format_args!("float {name} = {}", height * shift));
        }
    }
    if camera.lens.aperture > 0.0 {
        text.line(format_args!("float fStop = {}", focal / 10.0 / camera.lens.aperture));
    }
    text.close();
}
