// SPDX-License-Identifier: GPL-3.0-or-later
//! `path` against `ir` and `bir`, all unbiased: every kind of material under every kind of light, on both sides of a surface.
//! A difference between two of them is a bug; their common parts are checked first, against the definition.
//! Means of independent renderings are compared; seeds are fixed, so that the test is deterministic.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::*;
use glam::Vec3;
use gnurt_render::{
    CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt_scene::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence};
use gnurt_scene::material::{Alpha, Color, NormalMap, Opacity, OpacityChannel, Principled, TextureRef};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt_scene::{Affine, Light, Material, MaterialId, Scene, Surface, TextureId};
use gnurt_shading::bsdf::{Bsdf, ClosureBatch, Lobe, Lobes};
use gnurt_shading::lights::PointLight;
use gnurt_shading::sampling::Basis;
use gnurt_shading::{LightBatch, LightShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s};

/// Independent renderings per integrator.
const BATCHES: u64 = 8;
/// Standard errors that the means of one pair of renderings may lie apart: by 8, with 7 to 14 degrees of freedom, in one of
/// 10,000 pairs and less; there are about 900.
const MOST_OF_A_PAIR: f64 = 8.0;
/// The same for all pairs of one material or one light together, 38 and more: about one sum of 50 million lies so far off.
const MOST_OF_A_GROUP: f64 = 5.5;
/// Share by which means may lie apart whatever their errors are: shading normals do not treat light and its measurement quite
/// alike.
const SLACK: f64 = 4e-3;

fn texture(scene: &mut Scene, width: u32, texels: Vec<[f32; 4]>) -> TextureId {
    let height = texels.len() as u32 / width;
    scene.add_texture(Texture {
        name: String::new(),
        texels: Arc::new(Texels { width, height, data: TexelData::Float(texels) }),
        wrap: [Wrap::ClampToEdge; 2],
        filter: Filter::Nearest,
    })
}

const MATERIALS: [&str; 21] = [
    "matte",
    "rough matte",
    "mirror",
    "metal",
    "plastic",
    "plastic under a normal map",
    "principled",
    "sheen",
    "coat",
    "thin polished glass",
    "solid smooth glass",
    "thin rough glass",
    "solid rough glass",
    "partly transmitting plastic",
    "cut-out",
    "veil",
    "veil of vertices",
    "emissive",
    "brushed metal under a film",
    "translucent plastic",
    "tea that bends colours",
];

fn material(scene: &mut Scene, name: &str) -> MaterialId {
    let base = Color::constant([0.7, 0.5, 0.3]);
    let plastic = |roughness, normal_texture| Surface::MetallicRoughness {
        base_color: base,
        metallic: 0.0,
        roughness,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture,
    };
    let principled = Principled { base_color: base, metallic: 0.2, roughness: 0.6, ..Principled::default() };
    let layered = |p: Principled| Surface::Principled(Box::new(p));
    let glass = |roughness, thin| Surface::RoughDielectric {
        ior: 1.5,
        roughness,
        reflectance: [1.0; 3],
        transmittance: [0.9; 3],
        thin,
        interior: Default::default(),
    };
    let opacity = |texture, factor| Opacity { factor, texture, channel: OpacityChannel::Alpha };
    let surface = match name {
        "rough matte" => Surface::RoughMatte { base_color: base, roughness: 0.8 },
        "mirror" => Surface::Mirror { reflectance: base },
        "metal" => Surface::Metal { eta: [0.2, 0.9, 1.2], k: [3.9, 2.4, 2.2], roughness: 0.6 },
        "plastic" => plastic(0.5, None),
        "plastic under a normal map" => {
            let map = texture(scene, 1, vec![[0.85, 0.4, 0.8, 1.0]]);
            plastic(0.6, Some(NormalMap { texture: TextureRef::new(map), scale: 1.0 }))
        }
        "principled" => layered(Principled { specular: 0.5, ..principled }),
        "sheen" => layered(Principled { sheen_color: [0.8; 3], sheen_roughness: 0.5, ..principled }),
        "coat" => layered(Principled { clearcoat: 1.0, clearcoat_roughness: 0.5, ..principled }),
        "thin polished glass" => glass(0.35, true),
        "solid smooth glass" => Surface::Dielectric {
            ior: 1.5,
            reflectance: [1.0; 3],
            transmittance: [0.9; 3],
            interior: Default::default(),
        },
        "thin rough glass" => glass(0.6, true),
        "solid rough glass" => glass(0.6, false),
        "brushed metal under a film" => layered(Principled {
            metallic: 0.7,
            anisotropy: Anisotropy { strength: 0.7, rotation: 0.5, texture: None },
            iridescence: Iridescence { factor: 1.0, ior: 1.4, thickness: 380.0, ..Iridescence::default() },
            ..principled
        }),
        "translucent plastic" => {
            let diffuse_transmission = DiffuseTransmission { factor: 0.6, color: [0.9, 0.7, 0.5] };
            layered(Principled { diffuse_transmission, ..principled })
        }
        "tea that bends colours" => {
            let (attenuation_color, attenuation_distance) = ([0.8, 0.5, 0.2], 1.0);
            let interior =
                Interior { attenuation_color, attenuation_distance, dispersion: 2.0, ..Interior::default() };
            let (reflectance, transmittance) = ([1.0; 3], [0.9; 3]);
            Surface::RoughDielectric {
                ior: 1.5,
                roughness: 0.5,
                reflectance,
                transmittance,
                thin: false,
                interior,
            }
        }
        "partly transmitting plastic" => layered(Principled { transmission: 0.6, thin: true, ..principled }),
        _ => Surface::Matte { base_color: base },
    };
    let alpha = match name {
        "cut-out" => {
            // A chequer that the coordinates read once per quarter.
            let (on, off) = ([1.0; 4], [1.0, 1.0, 1.0, 0.0]);
            let map = TextureRef::new(texture(scene, 2, vec![on, off, off, on]));
            Alpha::Mask { cutoff: 0.5, opacity: opacity(Some(map), 1.0) }
        }
        "veil" => Alpha::Blend { opacity: opacity(None, 0.6) },
        "veil of vertices" => Alpha::Blend { opacity: opacity(None, 1.0) },
        _ => Alpha::Opaque,
    };
    let emission = if name == "emissive" { [0.3, 0.2, 0.1] } else { [0.0; 3] };
    scene.add_material(Material { alpha, emission, ..Material::of(name, surface) })
}

const LIGHTS: [&str; 9] = [
    "point",
    "spot",
    "directional",
    "area",
    "textured area",
    "area with vertex opacity",
    "environment",
    "environment picture",
    "plugin",
];

/// A light that gives nothing to normals that look away from it, as lights of plugins may.
struct Heeding(PointLight);

impl LightShader for Heeding {
    fn illuminate(&self, p: &Vec3s, normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        self.0.illuminate(p, normal, random, out);
        for i in (0..p.len()).filter(|&i| normal.get(i).dot(out.dir.get(i)) <= 0.0) {
            out.radiance.set(i, [0.0; 3].into());
        }
    }
}

/// Adds a light on the side of `up` (1 or -1) of the subject, as wide as it may be.
fn light(scene: &mut Scene, name: &str, up: f32) -> Option<Arc<dyn LightShader>> {
    let placement = [0.3, 0.5, 1.4 * up];
    let opacity = Opacity { factor: 1.0, texture: None, channel: OpacityChannel::Alpha };
    match name {
        "point" => {
            _ = scene.add_light(Light::Point { position: placement, intensity: [3.0; 3], radius: 0.0 })
        }
        "spot" => {
            _ = scene.add_light(Light::Spot {
                position: placement,
                direction: [-0.3, -0.5, -1.4 * up],
                intensity: [3.0; 3],
                inner_angle: 0.3,
                outer_angle: 0.6,
                edge: gnurt_scene::ConeEdge::Smooth,
                radius: 0.3,
            });
        }
        "directional" => {
            _ = scene.add_light(Light::Directional {
                direction: [-0.3, -0.4, -up],
                irradiance: [2.0; 3],
                angle: 0.0,
            });
        }
        "environment" => _ = scene.add_light(environment([0.8; 3])),
        "environment picture" => {
            // Bright on one side: rows from the top of the sky to its bottom.
            let rows = [2.0 + 1.5 * up, 1.0, 1.0, 2.0 - 1.5 * up].map(|x| [x, x, x, 1.0]);
            let map = texture(scene, 2, rows.into_iter().flat_map(|row| [row; 2]).collect());
            // Its top is +y; the subject's is +z.
            let columns = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0; 3]];
            scene.add_light(Light::Environment {
                radiance: [0.4; 3],
                texture: Some(map),
                world_from_light: Affine { columns },
            });
        }
        "plugin" => {
            let point = PointLight::new(placement.into(), [3.0; 3].into());
            return Some(Arc::new(Heeding(point)));
        }
        _ => {
            let area_light = emitter(scene, [4.0; 3]);
            if name == "textured area" {
                let map = texture(scene, 2, vec![[0.2, 0.2, 0.2, 1.0], [1.0, 0.6, 0.3, 1.0]]);
                scene.edit_material(area_light).emission_texture = Some(TextureRef::new(map));
            }
            let edges = [[1.4, 0.0, 0.0], [0.0, 1.4, 0.0]];
            // It shines towards the subject.
            let [a, b] = if up > 0.0 { [edges[1], edges[0]] } else { edges };
            let mut mesh = quad([-0.4, -0.2, 1.4 * up], a, b, area_light);
            if name == "area with vertex opacity" {
                scene.edit_material(area_light).alpha = Alpha::Blend { opacity };
                mesh.colors = [0.1, 0.9, 0.5, 0.1].map(|alpha| [1.0, 1.0, 1.0, alpha]).into();
            }
            crate::common::put_mesh(scene, mesh);
        }
    }
    None
}

/// A sheet of the material seen from above, its mesh's front up or down, beside a matte wall that reaches above and below it.
fn world(subject: &str, area_light: &str, up: f32, front: bool, threads: &rayon::ThreadPool) -> World {
    let mut scene = Scene::new();
    let of_lobes = LOBES.into_iter().find(|&name| name == subject);
    let sheet = match of_lobes {
        Some(name) => scene.add_material(Material::of(name, Surface::Shader(0))),
        None => material(&mut scene, subject),
    };
    let edges = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let [a, b] = if front { edges } else { [edges[1], edges[0]] };
    let mut mesh = quad([-1.0, -1.0, 0.0], a, b, sheet);
    if subject == "veil of vertices" {
        mesh.colors = [0.2, 0.9, 0.4, 0.7].map(|alpha| [1.0, 1.0, 1.0, alpha]).into();
    }
    put_mesh(&mut scene, mesh);
    let grey = matte(&mut scene, [0.6; 3]);
    put_mesh(&mut scene, quad([-1.2, -1.2, -1.2], [0.0, 2.4, 0.0], [0.0, 0.0, 2.4], grey));
    let plugin = light(&mut scene, area_light, up);
    let surfaces =
        of_lobes.map(|name| Arc::new(OfLobes(name)) as Arc<dyn SurfaceShader>).into_iter().collect();
    let lights = plugin.into_iter().collect();
    let table = ShaderTable { lights, surfaces, ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(&scene, &table, &CommitOptions::default(), threads).expect("the scene is sound");
    world
}

/// Lobes of a shading language: few surfaces have them, or around normals of their own.
const LOBES: [&str; 16] = [
    "phong",
    "ward",
    "brushed ward",
    "beckmann",
    "beckmann that mirrors",
    "beckmann glass",
    "fibres",
    "fibres over a body",
    "schlick's glass",
    "body that leans",
    "coat that leans",
    "coat over a body that leans",
    "leaning both ways",
    "glass and paper",
    "coloured veil",
    "coloured film",
];

/// A surface of those lobes.
struct OfLobes(&'static str);

impl OfLobes {
    /// The share of paths that it stops, and how much light others carry on.
    fn passing(&self) -> Option<(f32, Vec3)> {
        match self.0 {
            "coloured veil" => Some((0.6, Vec3::new(0.75, 0.25, 0.125) / 0.4)),
            "coloured film" => Some((0.0, Vec3::new(0.3, 0.8, 0.4))),
            _ => None,
        }
    }

    fn lobes(&self, ns: Vec3, front: bool) -> Lobes {
        let (tint, white) = (Vec3::new(0.7, 0.5, 0.3), Vec3::ONE);
        let Basis { tangent: x, bitangent: y, .. } = Basis::around(ns);
        let lean = |mut lobe: Lobe, to: Vec3| {
            lobe.normal = (ns + to).normalize();
            lobe
        };
        let (body, coat) = (Lobe::lambert(tint), Lobe::coat(0.4));
        let eta = if front { 1.0 / 1.5 } else { 1.5 };
        let times = |lobe: Lobe, share: f32| Lobes::from(lobe).times(Vec3::splat(share));
        match self.0 {
            "coloured film" => Lobes::default(),
            "coloured veil" => times(body, 0.8),
            "phong" => times(Lobe::phong(12.0), 0.8),
            "ward" => times(Lobe::ward(0.4), 0.8),
            "brushed ward" => times(Lobe::ward(0.3).brushed(x, 0.6), 0.8),
            "beckmann" => times(Lobe::beckmann(0.4, 0.0, white, white), 0.8),
            "beckmann that mirrors" => Lobe::beckmann(0.4, eta, white, Vec3::ZERO).into(),
            "beckmann glass" => times(Lobe::beckmann(0.4, eta, white, white), 0.9),
            "fibres" => Lobe::fibres(tint, 0.7).into(),
            "fibres over a body" => Lobes::from(Lobe::fibres(tint, 0.5)).over(body),
            "schlick's glass" => {
                let part = |through| Lobe::schlick_glass(0.4, eta, [Vec3::splat(0.04), white], 5.0, through);
                Lobes::from(part(false)).plus(part(true))
            }
            "body that leans" => times(lean(body, x * 0.7), 0.6).plus(times(body, 0.4)),
            "coat that leans" => Lobes::from(lean(coat, x * 0.5)).over(body),
            "coat over a body that leans" => Lobes::from(coat).over(lean(body, y * 0.7)),
            "leaning both ways" => {
                times(lean(body, x * 0.6), 0.5).plus(times(lean(Lobe::fibres(tint, 0.8), x * -0.6), 0.5))
            }
            _ => times(Lobe::rough_glass(0.4, eta, white, white, false), 0.5)
                .plus(times(Lobe::translucent(tint), 0.5)),
        }
    }
}

impl SurfaceShader for OfLobes {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let ns = hits.facing_ns(i);
            out.set(i, ns, self.lobes(ns, hits.front(i)).as_slice());
            if let Some((coverage, passing)) = self.passing() {
                out.cover(i, coverage);
                out.tint(i, passing);
            }
        }
    }

    fn transmit(&self, _tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let (coverage, passing) = self.passing().expect("only where it lets light through");
        (0..hits.len()).for_each(|i| out.set(i, passing * (1.0 - coverage)));
    }

    fn is_opaque(&self) -> bool {
        self.passing().is_none()
    }
}

/// Mean brightness of independent renderings, and the squared error of their mean.
fn mean_by(
    world: &World,
    view: &SceneCamera,
    options: &RenderOptions,
    threads: &rayon::ThreadPool,
) -> (f64, f64) {
    let one = |seed| {
        let options = RenderOptions { seed, ..options.clone() };
        let frame = render(world, view, &options, threads, &Silent).expect("sound options");
        mean(&frame.picture).iter().sum::<f64>() / 3.0
    };
    let means: Vec<f64> = (0..BATCHES).map(|k| one(50 + k)).collect();
    let n = BATCHES as f64;
    let mean = means.iter().sum::<f64>() / n;
    (mean, means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}

const ALL: [Integrator; 4] = [
    Integrator::Path,
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

/// Radiance at the middle of a sheet with only direct light.
fn direct(scene: &Scene, lights: Vec<Arc<dyn LightShader>>, integrator: Integrator) -> f64 {
    let table = ShaderTable { lights, ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    let options = RenderOptions { integrator, max_depth: 2, vpls: 16, ..options(2, 2, 4) };
    let view = camera([0.4, -0.8, 2.0], [0.0; 3], 0.001);
    mean(&render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture)[0]
}

fn sheet(scene: &mut Scene, material: MaterialId) {
    put_mesh(scene, quad([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], material));
}

/// Lights without extent on both sides of rough glass, by the definition: the BSDF times the irradiance.
#[test]
fn lights_behind_rough_glass_shine_through() {
    let (ior, roughness) = (1.5_f32, 0.6_f32);
    let glass = |thin| {
        let alpha = roughness * roughness;
        Bsdf::new(Vec3::Z, Lobe::rough_glass(alpha, 1.0 / ior, Vec3::ONE, Vec3::ONE, thin))
    };
    let wo = Vec3::new(0.4, -0.8, 2.0).normalize();
    for (thin, up) in [(true, 1.0), (true, -1.0), (false, 1.0), (false, -1.0)] {
        let position = Vec3::new(0.3, 0.5, 1.4 * up);
        let (dir, distance2) = (position.normalize(), position.length_squared());
        let value = f64::from(glass(thin).eval(wo, dir).x);
        assert!(value > 1e-3, "it goes through: {value}");
        let lights = [
            (
                "point",
                Light::Point { position: position.into(), intensity: [3.0; 3], radius: 0.0 },
                3.0 / distance2,
            ),
            ("spot", spot(position), 3.0 / distance2),
            (
                "directional",
                Light::Directional { direction: (-dir).into(), irradiance: [2.0; 3], angle: 0.0 },
                2.0,
            ),
        ];
        for integrator in ALL {
            let surface = Surface::RoughDielectric {
                ior,
                roughness,
                reflectance: [1.0; 3],
                transmittance: [1.0; 3],
                thin,
                interior: Default::default(),
            };
            let pane = || {
                let mut scene = Scene::new();
                let material = scene.add_material(Material::of("glass", surface.clone()));
                sheet(&mut scene, material);
                scene
            };
            for (name, light, arriving) in &lights {
                let mut scene = pane();
                scene.add_light(light.clone());
                let found = direct(&scene, Vec::new(), integrator);
                let what = format!("{integrator}, thin: {thin}, {name} at height {}", position.z);
                assert_close(found, value * f64::from(*arriving), 2e-3, &what);
            }
            let point = PointLight::new(position, Vec3::splat(3.0));
            let found = direct(&pane(), vec![Arc::new(Heeding(point))], integrator);
            let what = format!("{integrator}, thin: {thin}, a plugin's at height {}", position.z);
            assert_close(found, value * f64::from(3.0 / distance2), 2e-3, &what);
        }
    }
}

/// A body with index 1, seen through to its other side and to its contents: Beer's law, with every
/// integrator.
#[test]
fn light_is_absorbed_by_its_way_within() {
    let (attenuation_color, attenuation_distance) = ([0.5, 0.25, 1.0], 1.5);
    let interior = Interior { attenuation_color, attenuation_distance, ..Interior::default() };
    let clear = |thin| match thin {
        false => {
            Surface::Dielectric { ior: 1.000_01, reflectance: [1.0; 3], transmittance: [1.0; 3], interior }
        }
        true => Surface::Principled(Box::new(Principled {
            base_color: Color::constant([1.0; 3]),
            metallic: 0.0,
            roughness: 0.0,
            specular: 0.0,
            ior: 1.000_01,
            transmission: 1.0,
            interior,
            ..Principled::default()
        })),
    };
    for (thin, lamp_within) in [(false, false), (false, true), (true, false)] {
        let mut scene = Scene::new();
        let body = scene.add_material(Material::of("tea", clear(thin)));
        let [x, y] = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        // Normals point out of it: from height -1 to 1.
        put_mesh(&mut scene, quad([-1.0, -1.0, 1.0], x, y, body));
        put_mesh(&mut scene, quad([-1.0, -1.0, -1.0], y, x, body));
        let offset = if lamp_within {
            let area_light = emitter(&mut scene, [1.0; 3]);
            put_mesh(&mut scene, quad([-0.5, -0.5, 0.4], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], area_light));
            0.6
        } else {
            scene.add_light(environment([1.0; 3]));
            2.0
        };
        let mut world = World::new();
        world
            .commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool(1))
            .expect("the scene is sound");
        for integrator in ALL.into_iter().chain([Integrator::Whitted]) {
            // Whitted's renderer applies absorption where light leaves the glass; a pane of minimal roughness
            // is nearly a delta, which only `path` finds reliably.
            if (integrator == Integrator::Whitted && lamp_within) || (integrator != Integrator::Path && thin)
            {
                continue;
            }
            let options = RenderOptions { integrator, max_depth: 4, vpls: 16, ..options(2, 2, 4) };
            let view = camera([0.0, 0.1, 4.0], [0.0, 0.1, 0.0], 0.001);
            let picture = render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture;
            for (found, color) in mean(&picture).into_iter().zip(attenuation_color) {
                let expected =
                    if thin { 1.0 } else { f64::from(color).powf(offset / f64::from(attenuation_distance)) };
                let what = format!("{integrator}, thin: {thin}, lamp within: {lamp_within}");
                assert_close(found, expected, 4e-3, &what);
            }
        }
    }
}

fn spot(position: Vec3) -> Light {
    let (inner_angle, outer_angle) = (0.3, 0.6);
    Light::Spot {
        position: position.into(),
        direction: (-position).into(),
        intensity: [3.0; 3],
        inner_angle,
        outer_angle,
        edge: gnurt_scene::ConeEdge::default(),
        radius: 0.0,
    }
}

/// A mapped normal may see light that is behind the sheet; the sheet is in its way all the same.
#[test]
fn no_light_leaks_through_normal_maps() {
    for integrator in ALL {
        let mut scene = Scene::new();
        let material = material(&mut scene, "plastic under a normal map");
        sheet(&mut scene, material);
        // Above the map's normal, which leans by 40 degrees to +x, and below the sheet.
        scene.add_light(Light::Directional { direction: [-1.0, 0.2, 0.3], irradiance: [2.0; 3], angle: 0.0 });
        scene.add_light(Light::Point { position: [2.0, -0.4, -0.6], intensity: [9.0; 3], radius: 0.0 });
        assert_eq!(
            direct(&scene, Vec::new(), integrator),
            0.0,
            "{integrator}: a sheet that lets nothing through"
        );
        let point = PointLight::new(Vec3::new(2.0, -0.4, -0.6), Vec3::splat(9.0));
        let found = direct(&scene, vec![Arc::new(point)], integrator);
        assert_eq!(found, 0.0, "{integrator}: nor from a plugin's light");
    }
}

/// Opacity is the product of all that make it, for light samples as for rays.
#[test]
fn vertex_opacity_weakens_lamps() {
    let lit = |factor: f32, vertices: f32, integrator| {
        let mut scene = floor(0.6, 3.0);
        let opacity = Opacity { factor, texture: None, channel: OpacityChannel::Alpha };
        let alpha = Alpha::Blend { opacity };
        let area_light =
            scene.add_material(Material { emission: [5.0; 3], alpha, ..Material::matte("", [0.0; 3]) });
        let mut mesh = quad([-0.5, -0.5, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], area_light);
        mesh.colors = vec![[1.0, 1.0, 1.0, vertices]; 4];
        put_mesh(&mut scene, mesh);
        let options = RenderOptions { integrator, max_depth: 2, vpls: 16, ..options(4, 4, 16) };
        mean(&frame(&scene, &camera([2.0, 0.0, 0.5], [0.3, 0.0, 0.0], 2.0), &options).picture)[0]
    };
    for integrator in ALL {
        assert_close(lit(1.0, 0.25, integrator), lit(0.25, 1.0, integrator), 1e-5, &format!("{integrator}"));
    }
}

/// Sums of the results of two integrators, and the squared error of their difference.
#[derive(Clone, Copy, Default)]
struct Sums {
    found: f64,
    paths: f64,
    error: f64,
}

impl Sums {
    fn add(&mut self, other: Self) {
        self.found += other.found;
        self.paths += other.paths;
        self.error += other.error;
    }

    /// Standard errors between them.
    fn difference(&self) -> f64 {
        let off = (self.found - self.paths).abs();
        (off - SLACK * self.paths).max(0.0) / self.error.sqrt().max(1e-9)
    }
}

impl std::fmt::Display for Sums {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Self { found, paths, error } = self;
        write!(
            f,
            "{found:.4}, by paths {paths:.4}, +- {:.4}: {:.1} errors apart",
            error.sqrt(),
            self.difference()
        )
    }
}

#[test]
fn paths_and_virtual_lights_see_the_same_light() {
    see_the_same(&MATERIALS, &LIGHTS, 16);
}

/// Lobes with cached lanes, lobes with their own normals, and nonreciprocal lobes, in light paths.
#[test]
fn lobes_of_shading_languages_scatter_the_same_light() {
    see_the_same(&LOBES, &["point", "area"], 32);
}

/// Compares all subjects under all lights, by `spp` samples per pixel of paths.
fn see_the_same(subjects: &[&'static str], lights: &[&'static str], spp: u32) {
    let mut cases = Vec::new();
    for (subject, area_light) in subjects.iter().flat_map(|m| lights.iter().map(move |l| (*m, *l))) {
        let see_through =
            ["glass", "transmitting", "veil", "cut-out"].iter().any(|part| subject.contains(part));
        // A solid looks alike from both sides, but its light may be behind it.
        let sides = [(1.0, true), (-1.0, false), (-1.0, true), (1.0, false)];
        cases.extend(
            sides.into_iter().take(if see_through { 4 } else { 2 }).map(|side| (subject, area_light, side)),
        );
    }
    let view = camera([0.5, -1.2, 2.2], [0.1, 0.0, 0.0], 28.0);
    let by = |integrator, spp| RenderOptions { integrator, spp, vpls: 32, max_depth: 4, ..options(5, 5, 1) };
    let compared = side_by_side(cases.len(), |number, threads| {
        let (subject, area_light, (up, front)) = cases[number];
        let world = world(subject, area_light, up, front, threads);
        let (paths, paths_error) = mean_by(&world, &view, &by(Integrator::Path, spp), threads);
        [Integrator::InstantRadiosity, Integrator::BidirectionalInstantRadiosity].map(|integrator| {
            let (found, error) = mean_by(&world, &view, &by(integrator, spp / 8), threads);
            (integrator, Sums { found, paths, error: error + paths_error })
        })
    });
    let mut groups: BTreeMap<String, Sums> = BTreeMap::new();
    let mut mistakes = Vec::new();
    let results = cases.iter().zip(compared).flat_map(|(case, both)| both.map(|one| (*case, one)));
    for ((subject, area_light, (up, front)), (integrator, sums)) in results {
        for group in [subject, area_light] {
            groups.entry(format!("{group}, {integrator}")).or_default().add(sums);
        }
        if sums.difference() > MOST_OF_A_PAIR {
            let side = if up > 0.0 { "before" } else { "behind" };
            let face = if front { "front" } else { "back" };
            mistakes.push(format!(
                "{subject}, {area_light} {side} it, seen from its {face}, {integrator}: {sums}"
            ));
        }
    }
    for (group, sums) in &groups {
        eprintln!("all of {group}: {sums}");
        if sums.difference() > MOST_OF_A_GROUP {
            mistakes.push(format!("all of {group}: {sums}"));
        }
    }
    assert!(mistakes.is_empty(), "{} differ:\n{}", mistakes.len(), mistakes.join("\n"));
}
