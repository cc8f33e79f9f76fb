// SPDX-License-Identifier: GPL-3.0-or-later
//! Attributes of meshes and textures in shaders and light: normal maps, textured emission, attributes of both
//! rates.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::*;
use glam::Vec3;
use gnurt_render::{CommitOptions, Integrator, RenderOptions, ShaderTable, Silent, World, render};
use gnurt_scene::animation::Exposure;
use gnurt_scene::material::{Color, NormalMap, TextureRef};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt_scene::{
    Affine, Attribute, InstanceId, Light, Material, MaterialId, MeshId, Rate, Scene, Surface, TextureId,
};
use gnurt_shading::{AttributeRequest, RadianceShader, RayKind, SurfaceBatch, SurfaceShader, Tracer, Vec3s};

fn texture(scene: &mut Scene, width: u32, texels: Vec<[f32; 4]>) -> TextureId {
    let height = texels.len() as u32 / width;
    scene.add_texture(Texture {
        name: String::new(),
        texels: Arc::new(Texels { width, height, data: TexelData::Float(texels) }),
        wrap: [Wrap::ClampToEdge; 2],
        filter: Filter::Nearest,
    })
}

#[test]
fn normal_maps_turn_the_shading_normal() {
    let lit_from = |direction| {
        let mut scene = floor(0.5, 5.0);
        // Leans by 3 : 4 towards +u, which is +x on the floor.
        let map = texture(&mut scene, 1, vec![[0.8, 0.5, 0.9, 1.0]]);
        scene.edit_material(MaterialId(0)).surface = Surface::MetallicRoughness {
            base_color: Color::constant([0.5; 3]),
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            ior: 1.0,
            normal_texture: Some(NormalMap { texture: TextureRef::new(map), scale: 1.0 }),
        };
        scene.add_light(Light::Directional { direction, irradiance: [PI as f32; 3], angle: 0.0 });
        radiance_at(&scene, [0.1, 0.1, 5.0], [0.1, 0.1, 0.0], 1)[0]
    };
    assert_close(lit_from([0.0, 0.0, -1.0]), 0.5 * 0.8, 1e-2, "from above: the cosine of the map's normal");
    assert_close(lit_from([-0.6, 0.0, -0.8]), 0.5, 1e-2, "from where the map leans to");
    assert_close(lit_from([0.6, 0.0, -0.8]), 0.5 * (0.64 - 0.36), 2e-2, "from the other side");
}

/// The direction of a normal map's slope in the world, measured by light from each side: a floor, seen from
/// above.
fn lean(texel: [f32; 4], uv_from_mesh: [f32; 6], edit: impl Fn(&mut Scene)) -> [f64; 2] {
    let lit_from = |direction| {
        let mut scene = floor(0.5, 5.0);
        let map = texture(&mut scene, 1, vec![texel]);
        scene.edit_material(MaterialId(0)).surface = Surface::MetallicRoughness {
            base_color: Color::constant([0.5; 3]),
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            ior: 1.0,
            normal_texture: Some(NormalMap {
                texture: TextureRef { uv_from_mesh, ..TextureRef::new(map) },
                scale: 1.0,
            }),
        };
        edit(&mut scene);
        scene.add_light(Light::Directional { direction, irradiance: [PI as f32; 3], angle: 0.0 });
        radiance_at(&scene, [0.1, 0.1, 5.0], [0.1, 0.1, 0.0], 1)[0]
    };
    let towards = |x: f32, y: f32| lit_from([-x, -y, -0.8]);
    [towards(0.6, 0.0) - towards(-0.6, 0.0), towards(0.0, 0.6) - towards(0.0, -0.6)].map(|d| d / 0.36)
}

/// Red leans along the map's own u, green along its v, however the mesh, its coordinates, its tangents and its instance lie.
#[test]
fn normal_maps_follow_coordinates_tangents_and_mirrors() {
    const PLAIN: [f32; 6] = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    // Normals (0.6, 0, 0.8) and (0, 0.6, 0.8).
    let (red, green) = ([0.8, 0.5, 0.9, 1.0], [0.5, 0.8, 0.9, 1.0]);
    let mirrored_uv = |scene: &mut Scene| {
        scene.edit_mesh(MeshId(0)).texcoords.iter_mut().for_each(|uv| uv[0] = 1.0 - uv[0]);
    };
    let mirrored_instance = |scene: &mut Scene| {
        let mut columns = Affine::IDENTITY.columns;
        columns[0][0] = -1.0;
        scene.edit_instance(InstanceId(0)).world_from_object = Affine { columns };
    };
    let with_tangents = |tangent: [f32; 4]| {
        move |scene: &mut Scene| {
            let mesh = scene.edit_mesh(MeshId(0));
            mesh.normals = vec![[0.0, 0.0, 1.0]; 4];
            mesh.tangents = vec![tangent; 4];
        }
    };
    let nothing = |_: &mut Scene| {};
    // A quarter turn, v' = u and u' = -v: the map's u runs along -y, its v along x.
    let turned = [0.0, 1.0, -1.0, 0.0, 0.0, 0.0];
    let half = std::f64::consts::FRAC_1_SQRT_2;
    type Mapping = [[f64; 2]; 2];
    let cases: [(&str, Mapping, Mapping); 8] = [
        ("as it is", [lean(red, PLAIN, nothing), lean(green, PLAIN, nothing)], [[1.0, 0.0], [0.0, 1.0]]),
        (
            "mirrored coordinates",
            [lean(red, PLAIN, mirrored_uv), lean(green, PLAIN, mirrored_uv)],
            [[-1.0, 0.0], [0.0, 1.0]],
        ),
        (
            "a mirrored instance",
            [lean(red, PLAIN, mirrored_instance), lean(green, PLAIN, mirrored_instance)],
            [[-1.0, 0.0], [0.0, 1.0]],
        ),
        (
            "a quarter turn",
            [lean(red, turned, nothing), lean(green, turned, nothing)],
            [[0.0, -1.0], [1.0, 0.0]],
        ),
        (
            "an uneven scale before an eighth of a turn",
            // u' = (2u + v) / sqrt 2, v' = (v - 2u) / sqrt 2, whose u grows along (1, 2) and whose v along (-1, 2), the
            // frame upright on the former.
            [
                lean(red, [2.0, -2.0, 1.0, 1.0, 0.0, 0.0].map(|x| x * half as f32), nothing),
                lean(green, [2.0, -2.0, 1.0, 1.0, 0.0, 0.0].map(|x| x * half as f32), nothing),
            ],
            [[0.447, 0.894], [-0.894, 0.447]],
        ),
        (
            "tangents along y",
            [
                lean(red, PLAIN, with_tangents([0.0, 1.0, 0.0, 1.0])),
                lean(green, PLAIN, with_tangents([0.0, 1.0, 0.0, 1.0])),
            ],
            [[0.0, 1.0], [-1.0, 0.0]],
        ),
        (
            "left-handed tangents",
            [
                lean(red, PLAIN, with_tangents([0.0, 1.0, 0.0, -1.0])),
                lean(green, PLAIN, with_tangents([0.0, 1.0, 0.0, -1.0])),
            ],
            [[0.0, 1.0], [1.0, 0.0]],
        ),
        (
            "tangents that say nothing",
            [lean(red, PLAIN, with_tangents([0.0; 4])), lean(green, PLAIN, with_tangents([0.0; 4]))],
            [[1.0, 0.0], [0.0, 1.0]],
        ),
    ];
    for (what, found, expected) in cases {
        for (color, (found, expected)) in ["red", "green"].into_iter().zip(found.into_iter().zip(expected)) {
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 0.03, "{what}: {color} leans to {found:.2?} instead of {expected:?}");
        }
    }
}

#[test]
fn textures_modulate_emission_seen_and_given() {
    let mut scene = floor(0.6, 10.0);
    let map = texture(&mut scene, 2, vec![[0.0, 0.0, 0.0, 1.0], [1.0, 0.5, 0.25, 1.0]]);
    let light = emitter(&mut scene, [4.0; 3]);
    scene.edit_material(light).emission_texture = Some(TextureRef::new(map));
    // u runs along y, v along x; only y > 0 shines.
    put_mesh(&mut scene, quad([-1.0, -1.0, 1.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], light));
    let measured = |y| radiance_at(&scene, [0.0, y, 0.5], [0.0, y + 0.01, 1.0], 1);
    assert_eq!(measured(-0.5), [0.0; 3], "the black half");
    assert_close(measured(0.5)[1], 2.0, 1e-5, "the bright half shows factor times texel");
    let lit = radiance_at(&scene, [3.0, -3.0, 0.9], [0.0, 0.0, 0.0], 4096);
    // Two corner rectangles of 1 x 1 at height 1.
    let corner = 1.0_f64 / 2.0_f64.sqrt();
    let expected = 0.6 / PI * corner * corner.atan() * 2.0 * 4.0;
    assert_close(lit[0], expected, 1e-2, "half of the square lights the floor");
    assert_close(lit[2], expected / 4.0, 1e-2, "in the texel's colour");
}

/// Shows its two attributes, and the value of a missing one.
struct Show(Vec<AttributeRequest>);

impl RadianceShader for Show {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            let [triangle, vertex, missing] = [0, 1, 2].map(|a| &hits.attributes[a]);
            // Two components per vertex: the second is shown.
            out.set(i, Vec3::new(triangle[i], vertex[hits.len() + i], missing[i]));
        }
    }
}

impl SurfaceShader for Show {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.0
    }
}

#[test]
fn attributes_change_per_triangle_and_per_vertex() {
    let mut scene = floor(0.5, 1.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    scene.edit_mesh(MeshId(0)).attributes = vec![
        Attribute { name: "cell".into(), rate: Rate::Triangle, components: 1, data: vec![10.0, 20.0] },
        // The second component is x of the corner.
        Attribute {
            name: "place".into(),
            rate: Rate::Vertex,
            components: 2,
            data: vec![9.0, -1.0, 9.0, 1.0, 9.0, 1.0, 9.0, -1.0],
        },
    ];
    let want = |name: &str, components, default| AttributeRequest { name: name.into(), components, default };
    let requests =
        vec![want("cell", 1, vec![0.0]), want("place", 2, vec![0.0; 2]), want("none", 1, vec![7.0])];
    let table = ShaderTable { surfaces: vec![Arc::new(Show(requests))], ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    // The first triangle lies below the diagonal from (-1, -1) to (1, 1), the second above it.
    for (x, y, cell) in [(0.6, -0.2, 10.0), (-0.3, 0.4, 20.0), (0.1, -0.8, 10.0)] {
        let camera = camera([x, y, 3.0], [x, y, 0.0], 0.01);
        let frame = render(&world, &camera, &options(1, 1, 1), &pool(1), &Silent).expect("sound options");
        let [shown, placement, default, _] = frame.picture.color[0];
        assert_eq!(shown, cell, "per triangle at {x}, {y}");
        assert_close(f64::from(placement), f64::from(x), 1e-2, "per vertex, interpolated");
        assert_eq!(default, 7.0, "the default where the mesh has none");
    }
}

/// Shows three components of its first attribute, from one on.
struct ShowFrom(Vec<AttributeRequest>, usize);

impl RadianceShader for ShowFrom {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let row = |k: usize, i: usize| hits.attributes[0][(self.1 + k) * hits.len() + i];
        (0..hits.len()).for_each(|i| out.set(i, Vec3::from([0, 1, 2].map(|k| 100.0 + row(k, i)))));
    }
}

impl SurfaceShader for ShowFrom {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.0
    }
}

#[test]
fn gradients_of_attributes_are_those_in_the_world() {
    let mut scene = floor(0.5, 1.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    // 3 x + 5 y of the corners of a square of side 2.
    let heat = vec![7.0, -8.0, 7.0, -2.0, 7.0, 8.0, 7.0, 2.0];
    scene.edit_mesh(MeshId(0)).attributes = vec![
        Attribute { name: "heat".into(), rate: Rate::Vertex, components: 2, data: heat },
        Attribute { name: "cell".into(), rate: Rate::Triangle, components: 1, data: vec![10.0, 20.0] },
    ];
    let colors = [-1.0, 1.0, 1.0, -1.0].map(|x| [0.0, 0.5 + 0.25 * x, 1.0, 1.0]);
    scene.edit_mesh(MeshId(0)).colors = colors.to_vec();
    let (sin, cos) = 0.4_f64.sin_cos();
    let turned = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y, 0.0];
    scene.edit_instance(InstanceId(0)).world_from_object =
        Affine::scale([2.0, 0.5, 7.0]) * Affine::rotation([0.0, 0.0, 1.0], 0.4);
    // By the inverse of the transposed matrix: turned, then divided by the scale.
    let in_world = |x: f64, y: f64| {
        let [x, y, z] = turned(x, y);
        [x / 2.0, y / 0.5, z]
    };
    for (name, components, from, expected) in [
        ("heat", 6, 3, in_world(3.0, 5.0)),
        ("heat", 6, 0, [0.0; 3]),
        ("cell", 3, 0, [0.0; 3]),
        ("Cd", 9, 3, in_world(0.25, 0.0)),
        ("none", 3, 0, [0.0; 3]),
    ] {
        let name = format!("{}{name}", AttributeRequest::GRADIENT);
        let request = AttributeRequest { name, components, default: vec![0.0; components as usize] };
        let shown = format!("{} from {from}", request.name);
        let shader = Arc::new(ShowFrom(vec![request], from));
        let table = ShaderTable { surfaces: vec![shader], ..ShaderTable::default() };
        let mut world = World::new();
        world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
        for (x, y) in [(0.5, -0.1), (-0.3, 0.2)] {
            let camera = camera([x, y, 3.0], [x, y, 0.0], 0.01);
            let frame = render(&world, &camera, &options(1, 1, 1), &pool(1), &Silent).expect("sound options");
            let found = frame.picture.color[0];
            for k in 0..3 {
                assert_close(f64::from(found[k]) - 100.0, expected[k], 1e-4, &shown);
            }
        }
    }
}

/// Shows the kind of the ray, which no other shader of the test reads.
struct ByKind;

impl RadianceShader for ByKind {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, Vec3::splat(1.0 + hits.ray_kind(i) as u8 as f32)));
    }
}

impl SurfaceShader for ByKind {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }
}

#[test]
fn points_know_what_sent_the_rays() {
    // A small sample in the middle of a shell.
    let microfacets = |roughness| Surface::MetallicRoughness {
        base_color: Color::constant([1.0; 3]),
        metallic: 1.0,
        roughness,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    };
    let glass = Surface::Dielectric {
        ior: 1.0,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        interior: Default::default(),
    };
    let matte = Surface::Matte { base_color: Color::constant([1.0; 3]) };
    for (surface, kind) in [
        (matte, RayKind::Diffuse),
        (microfacets(0.5), RayKind::Glossy),
        (Surface::Mirror { reflectance: Color::constant([1.0; 3]) }, RayKind::Reflection),
        (glass, RayKind::Refraction),
    ] {
        let mut scene = Scene::new();
        let shell = scene.add_material(Material::of("shell", Surface::Shader(0)));
        let probe = scene.add_material(Material::of("probe", surface));
        put_mesh(&mut scene, sphere([0.0; 3], 10.0, 8, shell));
        put_mesh(&mut scene, quad([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], probe));
        let table = ShaderTable { surfaces: vec![Arc::new(ByKind)], ..ShaderTable::default() };
        let mut world = World::new();
        world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
        let shown = |target: [f32; 3]| {
            let camera = camera([0.0, 0.0, 3.0], target, 10.0);
            let options = RenderOptions { integrator: Integrator::Path, ..options(4, 4, 16) };
            let frame = render(&world, &camera, &options, &pool(1), &Silent).expect("sound options");
            mean(&frame.picture)[0]
        };
        let number = |kind: RayKind| 1.0 + f64::from(kind as u8);
        assert_close(shown([0.0, 0.0, 9.0]), number(RayKind::Camera), 1e-6, "camera rays");
        let found = shown([0.0; 3]);
        // Facets send a little light to all sides between them, and back less than all of it.
        assert_close(found, number(kind), 0.1, &format!("rays of the surface: {kind:?}"));
    }
}

#[test]
fn meshes_tell_their_area_where_they_stand() {
    let mut scene = floor(0.5, 1.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    let want = |name: &str, components| AttributeRequest {
        name: name.into(),
        components,
        default: vec![0.0; components as usize],
    };
    let requests = vec![want(AttributeRequest::SURFACE_AREA, 1), want("none", 2), want("none", 1)];
    let table = ShaderTable { surfaces: vec![Arc::new(Show(requests))], ..ShaderTable::default() };
    let mut world = World::new();
    let rotated = |angle| Affine::rotation([0.0, 0.0, 1.0], angle);
    for (placement, area) in [
        (Affine::IDENTITY, 4.0),
        (rotated(0.3), 4.0),
        (rotated(0.7) * Affine::scale([3.0, 3.0, 3.0]), 36.0),
        (Affine::scale([2.0, 0.5, 7.0]) * rotated(0.4), 4.0),
        (Affine::scale([2.0, 3.0, 1.0]), 24.0),
    ] {
        scene.edit_instance(InstanceId(0)).world_from_object = placement;
        world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
        let camera = camera([0.1, 0.05, 3.0], [0.1, 0.05, 0.0], 0.01);
        let frame = render(&world, &camera, &options(1, 1, 1), &pool(1), &Silent).expect("sound options");
        assert_close(f64::from(frame.picture.color[0][0]), area, 1e-4 * area, "area in the world");
    }
}

#[test]
fn surfaces_know_the_moment() {
    let mut scene = floor(0.5, 1.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    let want = |name: &str, components: u32| AttributeRequest {
        name: name.into(),
        components,
        default: vec![0.0; components as usize],
    };
    let requests = vec![want(AttributeRequest::TIME, 1), want("none", 2), want("none", 1)];
    let table = ShaderTable { surfaces: vec![Arc::new(Show(requests))], ..ShaderTable::default() };
    let shown = |world: &World| {
        let camera = camera([0.1, 0.05, 3.0], [0.1, 0.05, 0.0], 0.01);
        let frame = render(world, &camera, &options(1, 1, 1), &pool(1), &Silent).expect("sound options");
        f64::from(frame.picture.color[0][0])
    };
    let mut world = World::new();
    world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    assert_eq!(shown(&world), 0.0, "nothing moves");
    let positions = vec![Affine::IDENTITY, Affine::translation([0.2, 0.0, 0.0])];
    let exposure = Exposure { instances: vec![(InstanceId(0), positions)], ..Exposure::default() };
    world
        .commit_exposed(&scene, &exposure, &table, &CommitOptions::default(), &pool(1))
        .expect("the scene is sound");
    for time in [0.25, 0.75] {
        assert_close(shown(&world.at(time, &pool(1))), f64::from(time), 1e-6, "the moment of all rays");
    }
}

#[test]
fn the_camera_sees_a_backdrop() {
    let mut scene = floor(0.5, 5.0);
    scene.add_light(environment([1.0; 3]));
    let picture = texture(&mut scene, 1, vec![[0.25, 0.5, 2.0, 1.0]]);
    scene.add_light(Light::Backdrop { texture: picture, world_from_light: Affine::IDENTITY });
    for integrator in [
        Integrator::Path,
        Integrator::Whitted,
        Integrator::InstantRadiosity,
        Integrator::BidirectionalInstantRadiosity,
    ] {
        let shown = |target: [f32; 3]| {
            let camera = camera([0.0, 0.0, 3.0], target, 1.0);
            let options = RenderOptions { integrator, ..options(2, 2, 64) };
            let frame = render(&world_of(&scene, false), &camera, &options, &pool(1), &Silent);
            mean(&frame.expect("sound options").picture)
        };
        let above = shown([0.1, 0.0, 9.0]);
        let expected = [0.25, 0.5, 2.0];
        above.into_iter().zip(expected).for_each(|(x, expected)| assert_close(x, expected, 1e-5, "above"));
        let floor = shown([0.1, 0.0, 0.0]);
        floor
            .into_iter()
            .for_each(|x| assert_close(x, 0.5, 0.02, &format!("{integrator:?}: lit by another")));
    }
}
