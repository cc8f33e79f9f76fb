// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --shader`: velocity, camera attributes, trace sets, and the closures `debug` and `holdout` in pictures.

use gnurt::image::{ChannelData, Picture, read};

use super::animation::animated;
use super::harness::Folder;

fn plane<'a>(picture: &'a Picture, layer: &str, channel: &str) -> &'a [f32] {
    let found = picture.layer(layer).unwrap_or_else(|| panic!("the layer {layer}"));
    match &found.channel(channel).unwrap_or_else(|| panic!("{layer}.{channel}")).data {
        ChannelData::F32(values) => values,
        ChannelData::U32(_) => panic!("{layer} holds numbers"),
    }
}

#[test]
fn moving_surfaces_know_their_velocity() {
    let folder = Folder::new();
    animated(&folder);
    folder.write(
        "v.osl",
        "surface v (output vector way = 0, output float open = 0) { way = dPdtime; open = dtime; Ci = emission (); }",
    );
    // One unit in a second; the shutter is open for half of it.
    let run =
        "render a.gltf --animation slide --at 0.2 --fps 8 --shutter 4 -r 24x16 --spp 16 --integrator path
        --denoise=none --shader *=v.osl --layers shader.way,shader.open -o v.exr";
    folder.gnurt(&run.split_whitespace().collect::<Vec<_>>().join(" ")).success();
    let picture = read(&folder.at("v.exr")).expect("a picture");
    let [way, open] = [plane(&picture, "shader.way", "X"), plane(&picture, "shader.open", "Y")];
    let covered: Vec<usize> = (0..open.len()).filter(|&i| open[i] == 1.0).collect();
    assert!(covered.len() > 10, "{} pixels see the triangle in all samples", covered.len());
    for (&way, &open) in way.iter().zip(open) {
        assert!((way - 0.5 * open).abs() < 1e-4, "half a unit while the shutter is open: {way}, {open}");
    }
}

#[test]
fn shaders_query_camera_names_and_sets() {
    let folder = Folder::new();
    folder.write(
        "q.osl",
        "surface q (output color size = 0, output float gold = 0, output float near = 0)
        {
            int pixels[2]; float fov = 0; string name = \"\";
            getattribute (\"camera:resolution\", pixels); getattribute (\"camera:fov\", fov);
            getattribute (\"geom:name\", name);
            size = color (pixels[0], pixels[1], fov); gold = name == \"gold\";
            Ci = gold * debug (\"tag\") + 0.5 * diffuse (N);
        }",
    );
    let run = "render builtin:spheres -r 40x30 --spp 4 --integrator path --denoise=none --fov 40";
    let layers = "--layers shader.size,shader.gold,shader.tag,crypto_object";
    folder.gnurt(&format!("{run} --shader *=q.osl {layers} -o q.exr")).success();
    let picture = read(&folder.at("q.exr")).expect("a picture");
    let matte = gnurt::mattes::matte(&picture, gnurt::render::MatteKind::Object, "gold").expect("mattes");
    let [gold, tag] = [plane(&picture, "shader.gold", "Y"), plane(&picture, "shader.tag", "G")];
    assert!(matte.contains(&1.0), "gold is seen");
    for (i, &share) in matte.iter().enumerate() {
        assert!((gold[i] - share).abs() < 1e-5 && (tag[i] - share).abs() < 1e-5, "pixel {i}: its name");
        if share == 1.0 {
            let size = ["R", "G", "B"].map(|channel| plane(&picture, "shader.size", channel)[i]);
            assert!(size[0] == 40.0 && size[1] == 30.0 && (size[2] - 40.0).abs() < 1e-3, "{size:?}");
        }
    }
}

#[test]
fn rays_of_shaders_hit_their_sets() {
    let folder = Folder::new();
    folder.write(
        "near.osl",
        "surface near ()
        {
            int hits = trace (P, N, \"maxdist\", 100, \"traceset\", \"props\");
            Ci = hits * radiance ();
        }",
    );
    let run = "render builtin:spheres -r 40x30 --spp 4 --integrator path --denoise=none --shader *=near.osl";
    let lit = |change: &str| {
        folder.gnurt(&format!("{run} {change} --exposure 0 -o n.pfm")).success();
        let picture = read(&folder.at("n.pfm")).expect("a picture");
        picture.color.iter().filter(|pixel| pixel[0] > 0.5).count()
    };
    let sky = lit("");
    let gold = lit("--set instances.gold.traceset=props");
    assert!(gold > sky, "the sky alone has {sky} pixels, with the floor below gold {gold}");
    let all = lit("--set instances.*.traceset=props");
    assert!(all > gold, "{all} pixels below any, {gold} below gold");
    folder
        .gnurt(&format!("{run} --set instances.gold.traceset=a/b -o o.png"))
        .fails(2, "invalid name of a trace set");
}

#[test]
fn closures_hold_out() {
    let folder = Folder::new();
    folder.write(
        "h.osl",
        "surface h (float share = 1) { Ci = share * holdout () + (1 - share) * emission (); }",
    );
    let run = "render builtin:spheres -r 40x30 --spp 4 --denoise=none --layers crypto_object";
    for (integrator, share) in [("path", 1.0), ("path", 0.25), ("whitted", 0.25)] {
        let shader = format!("--shader gold=h.osl:share={share} --integrator {integrator}");
        folder.gnurt(&format!("{run} {shader} -o h.exr")).success();
        let picture = read(&folder.at("h.exr")).expect("a picture");
        let matte = gnurt::mattes::matte(&picture, gnurt::render::MatteKind::Object, "gold").expect("mattes");
        let inside: Vec<usize> = (0..matte.len()).filter(|&i| matte[i] > 0.999).collect();
        assert!(!inside.is_empty(), "it has a matte");
        for i in inside {
            let [r, _, _, alpha] = picture.color[i];
            assert!((alpha - (1.0 - share)).abs() < 1e-5, "{integrator}, {share}: opacity {alpha}");
            assert!((r - (1.0 - share)).abs() < 1e-5, "{integrator}, {share}: its other light, {r}");
        }
    }
}
