// SPDX-License-Identifier: GPL-3.0-or-later
//! A path tracer of spheres whose surfaces are shaders in OSL. It uses nothing of GNU RT but `gnurt-osl`.
//!
//! `cargo run --release -p gnurt-osl --example tiny_path_tracer -- [SAMPLES] > spheres.ppm`

use std::io::Write as _;

use gnurt_osl::{Dual, Error, Host, Lobe, Point, Shaded, ShaderGroup, ShadingSystem};

type V = [f32; 3];

fn add(a: V, b: V) -> V {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn times(a: V, s: f32) -> V {
    a.map(|x| x * s)
}

fn product(a: V, b: V) -> V {
    [0, 1, 2].map(|k| a[k] * b[k])
}

fn dot(a: V, b: V) -> f32 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn unit(a: V) -> V {
    times(a, 1.0 / dot(a, a).sqrt())
}

fn mirrored(d: V, n: V) -> V {
    add(d, times(n, -2.0 * dot(d, n)))
}

/// The renderer's answers to shaders.
struct World;

impl Host for World {
    /// The space `shader` is ours with y and z exchanged.
    fn common_from(&self, space: &str, _: &Point) -> Option<[[f32; 4]; 4]> {
        let swapped = [[1., 0., 0., 0.], [0., 0., 1., 0.], [0., 1., 0., 0.], [0., 0., 0., 1.]];
        (space == "shader").then_some(swapped)
    }
}

struct Sphere {
    center: V,
    radius: f32,
    material: usize,
}

/// Random numbers in [0, 1) (PCG).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = ((self.0 >> 18) ^ self.0) >> 27;
        (x as u32).rotate_right((self.0 >> 59) as u32) as f32 / 4_294_967_808.0
    }

    /// Around `n`, by the cosine.
    fn cosine(&mut self, n: V) -> V {
        let (z, angle) = (1.0 - 2.0 * self.next(), std::f32::consts::TAU * self.next());
        let r = (1.0 - z * z).max(0.0).sqrt();
        unit(add(times(n, 1.001), [r * angle.cos(), r * angle.sin(), z]))
    }
}

/// A path on its way.
struct Path {
    pixel: usize,
    origin: V,
    dir: V,
    weight: V,
    random: Random,
}

fn hit(spheres: &[Sphere], origin: V, dir: V) -> Option<(f32, &Sphere)> {
    let each = |sphere: &'_ Sphere| {
        let to = add(origin, times(sphere.center, -1.0));
        let (b, c) = (dot(to, dir), dot(to, to) - sphere.radius * sphere.radius);
        let root = (b * b - c).max(0.0).sqrt();
        if b * b < c {
            f32::INFINITY
        } else if -b - root > 1e-3 {
            -b - root
        } else {
            -b + root
        }
    };
    let all = spheres.iter().map(|sphere| (each(sphere), sphere)).filter(|(t, _)| *t > 1e-3 && t.is_finite());
    all.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// A hit as shaders see it.
fn point(path: &Path, t: f32, sphere: &Sphere) -> Point {
    let p = add(path.origin, times(path.dir, t));
    let n = unit(add(p, times(sphere.center, -1.0)));
    let (phi, theta) = (n[2].atan2(n[0]), n[1].clamp(-1.0, 1.0).acos());
    let inside = dot(n, path.dir) > 0.0;
    // Normals face the viewer, as OSL's shaders expect.
    let n = if inside { times(n, -1.0) } else { n };
    Point {
        p: p.into(),
        i: path.dir.into(),
        n,
        ng: n,
        u: Dual::from(phi / std::f32::consts::TAU + 0.5),
        v: Dual::from(theta / std::f32::consts::PI),
        backfacing: inside,
        ..Point::default()
    }
}

/// The reflectance of glass of the index behind it over that before it. Closures of glass contain it.
fn fresnel(cosine: f32, eta: f32) -> f32 {
    let inner = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    if inner <= 0.0 {
        return 1.0;
    }
    let t = inner.sqrt();
    let (s, p) = ((cosine - eta * t) / (cosine + eta * t), (eta * cosine - t) / (eta * cosine + t));
    0.5 * (s * s + p * p)
}

/// The weight of a closure, with its reflectance or transmittance.
fn strength(lobe: &Lobe, dir: V) -> V {
    let (eta, cosine) = (lobe.float(1), -dot(dir, lobe.triple(0)));
    match &*lobe.name {
        "reflection" if eta > 0.0 => times(lobe.weight, fresnel(cosine, eta)),
        "refraction" => times(lobe.weight, 1.0 - fresnel(cosine, eta)),
        _ => lobe.weight,
    }
}

/// Adds emission to `light`, and sends the path on along one of the closures.
fn scatter(lobes: &[Lobe], p: V, path: &mut Path, light: &mut V) -> bool {
    let emits = |lobe: &&Lobe| &*lobe.name == "emission";
    lobes.iter().filter(emits).for_each(|lobe| *light = add(*light, product(path.weight, lobe.weight)));
    let others: Vec<(&Lobe, V)> =
        lobes.iter().filter(|lobe| !emits(lobe)).map(|lobe| (lobe, strength(lobe, path.dir))).collect();
    let share = |weight: V| weight.iter().sum::<f32>();
    let all: f32 = others.iter().map(|(_, weight)| share(*weight)).sum();
    let mut left = path.random.next() * all;
    let Some((lobe, weight)) = others.into_iter().find(|(_, weight)| {
        left -= share(*weight);
        left < 0.0
    }) else {
        return false;
    };
    let mut weight = times(weight, all / share(weight));
    let n = lobe.triple(0);
    path.dir = match &*lobe.name {
        "diffuse" => path.random.cosine(n),
        "reflection" => mirrored(path.dir, n),
        // Its second argument is the index behind the surface over that before it.
        "refraction" => {
            let (eta, cosine) = (1.0 / lobe.float(1), -dot(path.dir, n));
            let inner = (1.0 - eta * eta * (1.0 - cosine * cosine)).max(0.0).sqrt();
            unit(add(times(path.dir, eta), times(n, eta * cosine - inner)))
        }
        other => panic!("no model for the closure '{other}'"),
    };
    if path.random.next() > 0.9 {
        return false;
    }
    weight = times(weight, 1.0 / 0.9);
    (path.origin, path.weight) = (p, product(path.weight, weight));
    true
}

const SURFACES: [&str; 4] = [
    "surface checked (float size = 1) {
        point q = transform (\"shader\", P) / size;
        color c = mod (floor (q[0]) + floor (q[1]), 2) == 0 ? color (0.8, 0.75, 0.6) : color (0.15, 0.2, 0.35);
        Ci = c * diffuse (N);
    }",
    "surface marble () {
        float veins = pow (1 - abs (snoise (P * 3 + 0.7 * noise (P * 8))), 6);
        Ci = 0.85 * mix (color (0.9), color (0.1, 0.3, 0.25), veins) * diffuse (N) + 0.1 * reflection (N);
    }",
    "surface glass (float ior = 1.5) {
        float eta = backfacing () ? 1 / ior : ior;
        Ci = reflection (N, eta) + refraction (N, eta);
    }",
    "surface lamp (float power = 1) { Ci = power * color (1, 0.85, 0.6) * emission (); }",
];

fn main() -> Result<(), Error> {
    let samples: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(64);
    let system = ShadingSystem::new();
    let mut groups: Vec<ShaderGroup> = Vec::new();
    for (text, power) in SURFACES.iter().zip([0.0, 0.0, 0.0, 14.0]) {
        let shader = system.compile("surface.osl", text)?;
        let group = system.group(shader.name());
        let group = if power > 0.0 { group.param("power", power) } else { group };
        groups.push(group.shader(&shader, "surface").build()?);
    }
    groups.iter().for_each(|group| eprintln!("{}: closures {:?}", group.name(), group.needs().closures));
    let sphere = |center, radius, material| Sphere { center, radius, material };
    let spheres = [
        sphere([0.0, -1000.0, 0.0], 1000.0, 0),
        sphere([-1.1, 1.0, 0.0], 1.0, 1),
        sphere([1.1, 1.0, 0.6], 1.0, 2),
        sphere([0.3, 4.5, -1.0], 1.0, 3),
    ];
    let (width, height) = (320_usize, 240_usize);
    let mut light = vec![[0.0; 3]; width * height];
    for sample in 0..samples {
        let camera = |pixel: usize| {
            let mut random = Random((sample << 32 | pixel as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15));
            random.next();
            let x = (pixel % width) as f32 + random.next() - 0.5 * width as f32;
            let y = 0.5 * height as f32 - (pixel / width) as f32 - random.next();
            let dir = unit([x, y - 30.0, -1.4 * height as f32]);
            Path { pixel, origin: [0.0, 1.8, 6.0], dir, weight: [1.0; 3], random }
        };
        let mut paths: Vec<Path> = (0..light.len()).map(camera).collect();
        while !paths.is_empty() {
            // All hits of a material are shaded together.
            let mut hits: Vec<(Vec<Path>, Vec<Point>)> =
                groups.iter().map(|_| (Vec::new(), Vec::new())).collect();
            for path in paths.drain(..) {
                match hit(&spheres, path.origin, path.dir) {
                    Some((t, sphere)) => {
                        let (paths, points) = &mut hits[sphere.material];
                        points.push(point(&path, t, sphere));
                        paths.push(path);
                    }
                    None => {
                        let sky = times([0.5, 0.7, 1.0], 0.35 + 0.25 * path.dir[1].max(0.0));
                        light[path.pixel] = add(light[path.pixel], product(path.weight, sky));
                    }
                }
            }
            for (group, (mut on, points)) in groups.iter().zip(hits) {
                let shaded: Shaded = group.run(&World, &points);
                for (k, mut path) in on.drain(..).enumerate() {
                    let pixel = path.pixel;
                    if scatter(shaded.lobes(k), points[k].p.value, &mut path, &mut light[pixel]) {
                        paths.push(path);
                    }
                }
            }
        }
    }
    let byte = |x: f32| (255.0 * (x / samples as f32).clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8;
    let bytes: Vec<u8> = light.iter().flatten().map(|&x| byte(x)).collect();
    let mut out = std::io::stdout().lock();
    let written = writeln!(out, "P6 {width} {height} 255").and_then(|()| out.write_all(&bytes));
    written.map_err(|error| Error::File { path: "spheres.ppm".into(), why: error.to_string() })
}
