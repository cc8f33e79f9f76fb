// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces, lights, cameras and skies.

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{
    AttributeRequest, Bounces, CameraSamples, LightBatch, RayKind, RayRequest, SampleKey, SurfaceBatch,
    SurfaceShader, Tracer, Vec3s,
};
use gnurt_sl_shading::{CameraFrame, Codes, Kind, ParameterValue};

use super::floor::{Probe, floor, script, surface};

/// Emission of each point.
pub(crate) fn emitted(shader: &dyn SurfaceShader, hits: &SurfaceBatch) -> Vec<Vec3> {
    let mut out = ClosureBatch::default();
    out.reset(hits.len());
    shader.evaluate(hits, &mut out);
    (0..hits.len()).map(|i| out.emission(i)).collect()
}

#[test]
fn globals_are_those_of_the_points() {
    let hits = floor(40);
    let shader = surface(
        "Ci = color (P[0], u, v) * emission () + (N[1] - I[1] + raytype (\"camera\") + backfacing ()) * emission ();",
    );
    let add = 2.0 - hits.ray_dir.get(0).y;
    for (i, light) in emitted(&*shader, &hits).into_iter().enumerate() {
        let expected = Vec3::new(i as f32, i as f32, 0.5) + Vec3::splat(add);
        assert!((light - expected).length() < 1e-4, "point {i}: {light}, {expected}");
    }
}

#[test]
fn rays_have_kinds() {
    let names = ["camera", "diffuse", "glossy", "reflection", "refraction"];
    let kinds =
        [RayKind::Camera, RayKind::Diffuse, RayKind::Glossy, RayKind::Reflection, RayKind::Refraction];
    let sum = names.iter().enumerate().map(|(i, name)| format!("{} * raytype (\"{name}\")", i + 1));
    let sum = sum.collect::<Vec<_>>().join(" + ");
    let shader = surface(&format!("Ci = color ({sum}, raytype (\"shadow\"), 0) * emission ();"));
    let mut hits = floor(40);
    for depth in 0..2 {
        (hits.depth, hits.kinds) = (depth, Vec::new());
        let light = emitted(&*shader, &hits)[17];
        assert_eq!(light, Vec3::new(1.0 + depth as f32, 0.0, 0.0), "{depth} bounces, and nobody asked");
    }
    hits.kinds = kinds.into_iter().cycle().take(40).collect();
    for (i, light) in emitted(&*shader, &hits).into_iter().enumerate() {
        assert_eq!(light, Vec3::new((i % 5 + 1) as f32, 0.0, 0.0), "point {i}");
    }
    let shade = surface("Ci = (raytype (\"shadow\") ? color (0.25) : color (0.5)) * transparent ();");
    let mut through = Vec3s::splat(40, Vec3::ZERO);
    assert!(!shade.is_opaque());
    shade.transmit(&mut Probe(1.0), &hits, &mut through);
    assert_eq!(through.get(33), Vec3::splat(0.25), "rays that ask for shadow");
}

#[test]
fn lamps_know_their_area() {
    let shader = surface("Ci = color (6 / surfacearea ()) * emission ();");
    let names: Vec<&str> = shader.attributes().iter().map(|request| &request.name[..]).collect();
    assert_eq!(names, [AttributeRequest::SURFACE_AREA]);
    let mut hits = floor(20);
    assert_eq!(emitted(&*shader, &hits)[19].x, 6.0, "1 where nobody knows");
    hits.attributes = vec![(1..=20).map(|i| i as f32).collect()];
    assert_eq!(emitted(&*shader, &hits)[19].x, 6.0 / 20.0);
}

#[test]
fn surfaces_know_the_time() {
    let shader = surface("Ci = color (time, u, 0) * emission ();");
    let names: Vec<&str> = shader.attributes().iter().map(|request| &request.name[..]).collect();
    assert_eq!(names, [AttributeRequest::TIME]);
    let mut hits = floor(20);
    assert_eq!(emitted(&*shader, &hits)[19].x, 0.0, "where nobody knows");
    hits.attributes = vec![(0..20).map(|i| i as f32 / 20.0).collect()];
    let found: Vec<f32> = emitted(&*shader, &hits).iter().map(|light| light.x).collect();
    assert_eq!(found, hits.attributes[0], "of each point");
}

#[test]
fn surfaces_know_their_velocity() {
    let shader = surface("Ci = (color (dPdtime) * dtime + color (0, 0, time)) * emission ();");
    let names: Vec<(&str, u32)> =
        shader.attributes().iter().map(|request| (&request.name[..], request.components)).collect();
    let expected =
        [(AttributeRequest::TIME, 1), (AttributeRequest::SHUTTER, 1), (AttributeRequest::VELOCITY, 3)];
    assert_eq!(names, expected);
    let mut hits = floor(20);
    assert_eq!(emitted(&*shader, &hits)[19], Vec3::ZERO, "of a closed shutter");
    // By component, then by point.
    let velocity = (0..60).map(|i| i as f32).collect();
    hits.attributes = vec![vec![0.5; 20], vec![2.0; 20], velocity];
    for by_code in [false, true] {
        if by_code {
            Codes::default().wait();
        }
        for (i, found) in emitted(&*shader, &hits).into_iter().enumerate() {
            let i = i as f32;
            assert_eq!(found, Vec3::new(2.0 * i, 2.0 * (20.0 + i), 2.0 * (40.0 + i) + 0.5), "point {i}");
        }
    }
    let camera = script("camera c () { P = point (time, dtime, 0); I = vector (0, 0, -1); }");
    let frame = CameraFrame {
        eye: [0.0; 3],
        right: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        back: [0.0, 0.0, 1.0],
        pixels: [2, 2],
    };
    let camera = camera.camera(frame).expect("a camera");
    for (times, org) in [(&[][..], [0.5, 0.0, 0.0]), (&[0.25][..], [0.25, 1.0, 0.0])] {
        let mut rays = RayBatch::default();
        camera.rays(&CameraSamples { positions: &[[0.5; 2]], lens: &[], times }, 1.0, &mut rays);
        assert_eq!(rays.get(0).org, org, "the camera's times {times:?}");
    }
}

#[test]
fn derivatives_follow_the_width_of_rays() {
    let mut hits = floor(1);
    hits.ray_dir = Vec3s::splat(1, -Vec3::Y);
    hits.footprint = vec![0.25];
    let shader = surface(
        "Ci = color (length (vector (Dx (u), Dy (u), 0)), length (Dx (P)), length (Dy (P))) * emission ();",
    );
    let light = emitted(&*shader, &hits)[0];
    assert!((light - Vec3::splat(0.25)).length() < 1e-5, "as wide as the ray, in u as in the world: {light}");
    let still = emitted(&*shader, &floor(1))[0];
    assert_eq!(still, Vec3::ZERO, "nobody knows");
}

#[test]
fn meshes_and_instances_give_what_is_asked_for() {
    let text =
        "surface s (float heat = 3 [[ int interpolated = 1 ]], color tint = 5 [[ int lockgeom = 0 ]]) {
        float shine = 0; int found = getattribute (\"shine\", shine);
        color c = 0; getattribute (\"Cd\", c);
        point p = transform (\"object\", P);
        Ci = color (heat, tint[0], shine + found) * emission () + p[1] * emission () + c[2] * emission ();
    }";
    let shader = script(text).surface().expect("a surface");
    let names: Vec<(&str, u32)> =
        shader.attributes().iter().map(|request| (&request.name[..], request.components)).collect();
    let expected =
        [("heat", 1), ("tint", 3), ("shine", 1), ("Cd", 3), (AttributeRequest::WORLD_FROM_OBJECT, 12)];
    assert_eq!(names, expected, "what is asked of the mesh");
    let mut hits = floor(2);
    let nan = f32::NAN;
    // One point's mesh has all of it, the other's nothing; the object lies 4 below the world.
    let lanes = |first: &[f32]| first.iter().flat_map(|&x| [x, nan]).collect::<Vec<f32>>();
    hits.attributes = vec![lanes(&[7.0]), lanes(&[0.5; 3]), lanes(&[9.0]), vec![nan; 6]];
    let matrix = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -4.0, 0.0];
    hits.attributes.push(matrix.iter().flat_map(|&x| [x, x]).collect());
    let light = emitted(&*shader, &hits);
    assert_eq!(light[0], Vec3::new(7.0, 0.5, 10.0) + Vec3::splat(4.0 + 0.75), "as the mesh says");
    assert_eq!(light[1], Vec3::new(3.0, 5.0, 0.0) + Vec3::splat(4.0 + 0.75), "as the shader says");
}

#[test]
fn pictures_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "surface s (string file = \"two.png\") { float a = 0; int size[2];
        gettextureinfo (file, \"resolution\", size);
        Ci = (color) texture (file, 0.5, 0.25, \"alpha\", a, \"interp\", \"closest\") * emission ()
            + color (0, a, size[1]) * emission () + (color) texture (file, 0.5, 1.5) * emission (); }";
    let mut image = vec![];
    image.extend_from_slice(&png());
    std::fs::write(folder.path().join("two.png"), image).expect("a picture");
    let at = folder.path().join("s.osl");
    std::fs::write(&at, text).expect("a shader");
    let made =
        gnurt_sl_shading::Script::open(&at, &gnurt_sl_shading::Access::default()).expect("it compiles");
    let light = emitted(&*made.surface().expect("a surface"), &floor(1))[0];
    assert_eq!(
        light,
        Vec3::new(1.0, 2.0, 3.0),
        "row 0 lies at t = 0; opaque; 2 high; black outside; {:?}",
        made.faults()
    );
}

/// Bytes are sRGB unless a shader specifies the space.
#[test]
fn pictures_are_of_the_colour_space_that_shaders_say() {
    use gnurt_image::{Picture, WriteOptions};
    let folder = tempfile::tempdir().expect("a folder");
    let mut picture = Picture::new(1, 1);
    picture.color[0] = [0.5, 0.5, 0.5, 1.0];
    gnurt_image::write(&picture, &folder.path().join("grey.png"), &WriteOptions::default())
        .expect("a picture");
    let of = |space: &str| {
        let at = folder.path().join("s.osl");
        let text = format!(
            "surface s () {{ Ci = (color) texture (\"grey.png\", 0.5, 0.5, \"missingcolor\", color (2){space}) * emission (); }}"
        );
        std::fs::write(&at, text).expect("a shader");
        let made = gnurt_sl_shading::Script::open(&at, &gnurt_sl_shading::Access::default());
        emitted(&*made.expect("it compiles").surface().expect("a surface"), &floor(1))[0].x
    };
    let near = |x: f32, expected: f32| (x - expected).abs() < 0.005;
    assert!(near(of(""), 0.5) && near(of(", \"colorspace\", \"sRGB\""), 0.5), "decoded: {}", of(""));
    for space in ["raw", "linear", "lin_rec709"] {
        let found = of(&format!(", \"colorspace\", \"{space}\""));
        assert!(near(found, 0.735), "as they are: {found}");
    }
    assert_eq!(of(", \"colorspace\", \"mine\""), 2.0, "what is not known is missing");
}

/// A picture of one column: white over black.
fn png() -> Vec<u8> {
    use gnurt_image::{Picture, WriteOptions};
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.png");
    let mut picture = Picture::new(1, 2);
    picture.color[0] = [1.0; 4];
    picture.color[1] = [0.0, 0.0, 0.0, 1.0];
    gnurt_image::write(&picture, &path, &WriteOptions::default()).expect("a picture");
    std::fs::read(path).expect("it was written")
}

#[test]
fn shaders_that_ask_rays_and_lights_are_told() {
    let hits = floor(20);
    let shade = |body: &str| {
        let shader = surface(body);
        let mut out = Vec3s::splat(20, Vec3::ZERO);
        shader.radiance().expect("it works out its own").shade(&mut Probe(4.0), &hits, &mut out);
        let all: Vec<Vec3> = (0..20).map(|i| out.get(i)).collect();
        assert!(all.iter().all(|light| *light == all[0]), "all points are alike: {all:?}");
        all[0]
    };
    let own =
        shade("color c = 0; illuminance (P) c += Cl * dot (N, L) * lightpdf + Cl; Ci = c * radiance ();");
    assert_eq!(own, Vec3::splat(2.5), "half of the light is in shadow, and its density is a quarter");
    let both = shade(
        "color c = 0; illuminance (P) c += Cl; illuminance (P, \"shadow\", 0) c += Cl; Ci = c * radiance ();",
    );
    assert_eq!(both, Vec3::splat(6.0), "and all of it without");
    let elsewhere = shade("color c = 0; illuminance (P + 1) c += Cl; Ci = c * radiance ();");
    assert_eq!(elsewhere, Vec3::splat(2.0), "at another place");
    let shaded = shade("Ci = (color) trace (P, vector (0, 2, 0)) * radiance ();");
    assert_eq!(shaded, Vec3::Y, "what lies above");
    let far =
        shade("float d = 0; if (trace (P, N)) getmessage (\"trace\", \"hitdist\", d); Ci = d * radiance ();");
    assert_eq!(far, Vec3::splat(7.0), "how far it is");
    // A mixture: other closures are lit by all lights.
    let mixed = shade("Ci = M_PI * diffuse (N) + radiance ();");
    assert!((mixed - Vec3::splat(3.0)).length() < 1e-5, "{mixed}");
}

/// Notes the sets of rays and the categories of lights.
#[derive(Default)]
struct Listener {
    sets: Vec<String>,
    categories: Vec<String>,
}

impl Tracer for Listener {
    fn light_count(&self) -> usize {
        1
    }

    fn illuminate(&mut self, _: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        out.reset(hits.len());
        self.categories.push(String::new());
    }

    fn illuminate_in(&mut self, category: &str, _: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        out.reset(hits.len());
        self.categories.push(category.to_owned());
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        assert_eq!(request.set, None, "shadow rays have no set");
        transmittance.reset(request.rays.len(), Vec3::ONE);
    }

    fn trace(&mut self, _: u32, request: &RayRequest, radiance: &mut Vec3s) {
        radiance.reset(request.rays.len(), Vec3::ONE);
        self.sets.push(format!("light of {:?}", request.set.as_deref()));
    }

    fn distances(&mut self, request: &RayRequest, out: &mut Vec<f32>) {
        out.clear();
        out.resize(request.rays.len(), 2.0);
        self.sets.push(format!("{:?}", request.set.as_deref()));
    }

    fn random(&self, _: SampleKey, _: u32, _: u32) -> [f32; 2] {
        [0.5; 2]
    }
}

#[test]
fn rays_have_sets_and_lights_have_categories() {
    let shader = surface(
        "color c = 0; string other = u > 0 ? \"-walls\" : \"walls\";
            if (trace (P, N, \"traceset\", \"props\")) c += 1;
            if (trace (P, N, \"maxdist\", 5, \"traceset\", other)) c += 1;
            if (trace (P, N)) c += 1;
            c += (color) trace (P, N, \"traceset\", \"walls\");
            illuminance (P, \"category\", \"key\") c += Cl;
            illuminance (P) c += Cl;
            illuminance (P, \"category\", \"-key\") c += Cl;
            Ci = c * radiance ();",
    );
    let names: Vec<&str> = shader.attributes().iter().map(|request| &request.name[..]).collect();
    assert_eq!(names, [AttributeRequest::IDS], "names must be known");
    let mut out = Vec3s::splat(1, Vec3::ZERO);
    let mut listener = Listener::default();
    shader.radiance().expect("it traces").shade(&mut listener, &floor(1), &mut out);
    assert_eq!(out.get(0), Vec3::splat(4.0));
    assert_eq!(listener.sets, ["Some(\"props\")", "Some(\"walls\")", "None", "light of Some(\"walls\")"]);
    assert_eq!(listener.categories, ["key", "", "-key"]);
    // Any number of computed names.
    let shader = surface(
        "color c = 0; for (int i = 0; i < 10000; ++i) illuminance (P, \"category\", format (\"%d\", i)) c += Cl;
            Ci = c * radiance ();",
    );
    let mut listener = Listener::default();
    shader.radiance().expect("it loops").shade(&mut listener, &floor(1), &mut out);
    assert_eq!(listener.categories.len(), 10_000);
}

#[test]
fn lights_shine() {
    let mut script = script(
        "light l (color power = 1, point from = point (0, 2, 0)) {
        vector way = from - Ps; lightdist = length (way); L = way; Cl = power * xi[0]; lightpdf = xi[1] - 0.25; }",
    );
    assert_eq!(script.kind(), Kind::Light);
    script.set("power", &ParameterValue::Floats(vec![1.0, 2.0, 3.0])).expect("a colour");
    let light = script.light().expect("a light");
    let mut out = LightBatch::default();
    out.reset(20);
    let p = Vec3s::splat(20, Vec3::ZERO);
    let random: Vec<[f32; 2]> = (0..20).map(|i| [0.5, i as f32]).collect();
    light.illuminate(&p, &Vec3s::splat(20, Vec3::Y), &random, &mut out);
    assert_eq!([out.pdf[0], out.pdf[3]], [0.0, 2.75], "densities are not negative");
    for i in 0..20 {
        assert_eq!((out.dir.get(i), out.dist[i]), (Vec3::Y, 2.0), "where it is");
        assert_eq!(out.radiance.get(i), Vec3::new(0.5, 1.0, 1.5), "what it sends");
    }
}

#[test]
fn cameras_make_rays() {
    let frame = CameraFrame {
        eye: [1.0, 0.0, 0.0],
        right: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        back: [0.0, 0.0, 1.0],
        pixels: [200, 100],
    };
    let text = "camera c (float fov = 90, float aspect = 1) {
        float half = tan (radians (0.5 * fov));
        P = transform (\"camera\", \"common\", point (0, xi[0], 0));
        I = vector (\"camera\", (2 * u - 1) * half * aspect, (2 * v - 1) * half, -1);
        weight = raster[1] > 90 ? 0 : 1; }";
    let camera = script(text).camera(frame).expect("a camera");
    assert!(camera.has_lens(), "it asks for xi");
    let mut rays = RayBatch::default();
    let positions = [[1.0, 0.5], [0.5, 1.0], [0.5, 0.0]];
    camera.rays(
        &CameraSamples { positions: &positions, lens: &[[0.25, 0.0]; 3], times: &[] },
        2.0,
        &mut rays,
    );
    assert_eq!(rays.get(0).org.map(|x| x), [1.0, 0.25, 0.0], "on the lens");
    let dir = Vec3::from(rays.get(0).dir);
    assert!((dir - Vec3::new(2.0, 0.0, -1.0).normalize()).length() < 1e-6, "as wide as the picture: {dir}");
    assert!(rays.get(1).dir[1] > 0.7, "v is upwards");
    assert_eq!(Vec3::from(rays.get(2).dir), Vec3::ZERO, "no weight, no ray");
}

#[test]
fn skies_are_seen() {
    let sky = script("environment e () { Ci = color (I[0], 0, 0) * background () + emission (); }");
    let sky = sky.environment().expect("a sky");
    let mut out = Vec3s::splat(2, Vec3::ZERO);
    let mut dirs = Vec3s::splat(2, Vec3::X);
    dirs.set(1, Vec3::Y);
    sky.miss(&dirs, &mut out);
    assert_eq!([out.get(0), out.get(1)], [Vec3::new(2.0, 1.0, 1.0), Vec3::ONE]);
}

#[test]
fn it_tells_its_variables() {
    let shader = surface(
        "float a = P[0] + 2; { string b = \"x\"; if (a > 1) b = \"y\"; Ci = (a + startswith (b, \"z\")) * diffuse (N); }",
    );
    let lines = shader.describe(&floor(2), 1);
    for expected in ["a = 3", "b = \"y\"", "Ci = (3, 3, 3) * diffuse ((0, 1, 0))"] {
        assert!(lines.iter().any(|line| line.ends_with(expected)), "{expected}: {lines:?}");
    }
}

#[test]
fn normals_of_raised_places_face_the_ray() {
    let mut hits = floor(1);
    hits.ray_dir = Vec3s::splat(1, -Vec3::Y);
    hits.footprint = vec![0.25];
    let shader = surface("Ci = (color (calculatenormal (P + N * 0.1 * P[0])) + 1) * emission ();");
    let normal = emitted(&*shader, &hits)[0] - Vec3::ONE;
    assert!(normal.y > 0.0 && normal.x < 0.0, "up, and away from where it is higher: {normal}");
}

#[test]
fn closures_may_depend_on_rays() {
    // All rays meet something in the distance 7; integrators scatter the closures.
    let shader = script("surface s () { float d = 0; if (trace (P, N)) getmessage (\"trace\", \"hitdist\", d); Ci = (d / 8) * diffuse (N) + emission (); }")
        .surface()
        .expect("a surface");
    assert!(shader.radiance().is_none() && !shader.emits(), "its light is met, not sampled");
    let hits = floor(20);
    let albedo = |traced: bool| {
        let mut out = ClosureBatch::default();
        out.reset(20);
        match traced {
            true => shader.evaluate_traced(&mut Probe(4.0), &hits, &mut out),
            false => shader.evaluate(&hits, &mut out),
        }
        out.point(19).bsdf.albedo(Vec3::Y)
    };
    assert_eq!([albedo(true), albedo(false)], [Vec3::splat(0.875), Vec3::ZERO], "rays, or none");
}

#[test]
fn paths_count_their_bounces() {
    let mut hits = floor(2);
    let twice = Bounces::default().and(RayKind::Diffuse).and(RayKind::Glossy).and(RayKind::Refraction);
    hits.bounces = vec![Bounces::default(), twice.and(RayKind::Reflection).beyond()];
    hits.t[1] = 2.5;
    for (name, expected) in [
        ("ray_depth", [0.0, 4.0]),
        ("diffuse_depth", [0.0, 1.0]),
        ("glossy_depth", [0.0, 2.0]),
        ("transmission_depth", [0.0, 1.0]),
        ("transparent_depth", [0.0, 1.0]),
        ("ray_length", [1.0, 2.5]),
    ] {
        let text = format!(
            "surface s () {{ float x = -1; getattribute (\"path:{name}\", x); Ci = x * emission (); }}"
        );
        let shader = script(&text).surface().expect("a surface");
        assert_eq!(shader.emits(), name == "ray_length", "{name} is sampled as a light");
        let mut out = ClosureBatch::default();
        out.reset(2);
        shader.evaluate(&hits, &mut out);
        assert_eq!([0, 1].map(|i| out.emission(i).x), expected, "{name}");
    }
}
