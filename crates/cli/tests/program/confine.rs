// SPDX-License-Identifier: GPL-3.0-or-later
//! `--confine DIR`: a scene reads nothing outside of a folder.

use super::harness::Folder;
use super::samples;

#[test]
fn scenes_stay_in_their_folder() {
    let folder = Folder::new();
    folder.write("scene.mtl", "newmtl red\nKd 1 0 0\nmap_Kd secret.png\n");
    folder.write("in/a.obj", format!("mtllib ../scene.mtl\n{}", samples::OBJ));
    folder.write("in/good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let commands = [
        "render in/a.obj -r 4x4 --spp 1 -o p.png",
        "info in/a.obj",
        "convert in/a.obj b.ply",
        "trace in/a.obj -r 4x4 --pixel 1,1",
        "view in/a.obj --headless -r 4x4",
        "bench light in/a.obj",
    ];
    for line in commands {
        let outside = "in/a.obj:1: in/../scene.mtl is outside of the folder that files may be in; expected a file below ";
        folder.gnurt(&format!("{line} --confine in")).fails(1, outside);
    }
    folder.gnurt("info in/a.obj --confine .").success();
    folder.gnurt("info in/good.obj --confine in").success();
    folder.gnurt("info in/good.obj --confine none").fails(2, "--confine none: the folder does not exist");
    folder.gnurt("info in/good.obj --confine in/good.obj").fails(2, "the folder does not exist");
    assert!(!folder.at("p.png").exists() && !folder.at("b.ply").exists(), "nothing was written");
}
