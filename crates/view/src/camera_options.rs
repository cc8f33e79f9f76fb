// SPDX-License-Identifier: GPL-3.0-or-later
//! A camera as options of the command line, for another picture of the same view.
//! Tests: `tests`.

use std::fmt::Write as _;

use gnurt::scene::{Camera, Projection};

/// The options that set this camera: its projection and lens only where they are not a pinhole's perspective.
#[must_use]
pub fn camera_options(camera: &Camera) -> String {
    let point = |v: [f32; 3]| v.map(|x| x.to_string()).join(",");
    let (eye, target, up) = (point(camera.eye), point(camera.target), point(camera.up));
    let mut options = format!("--eye {eye} --target {target} --up {up}");
    // Writing to a string does not fail.
    let _ = match camera.projection {
        Projection::Perspective => write!(options, " --fov {}", camera.fov_y),
        Projection::Orthographic { height } => {
            write!(options, " --projection orthographic --view-height {height}")
        }
        Projection::Fisheye => write!(options, " --projection fisheye --fov {}", camera.fov_y),
        Projection::Panorama => write!(options, " --projection panorama"),
    };
    if camera.shift != [0.0; 2] {
        let _ = write!(options, " --shift {},{}", camera.shift[0], camera.shift[1]);
    }
    if camera.lens.aperture > 0.0 {
        let _ = write!(options, " --aperture {}", camera.lens.aperture);
        if let Some(focus) = camera.lens.focus {
            let _ = write!(options, " --focus {focus}");
        }
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::scene::Lens;

    #[test]
    fn all_of_a_camera_is_told() {
        let camera = Camera::default();
        assert_eq!(camera_options(&camera), "--eye 0,0,0 --target 0,0,-1 --up 0,1,0 --fov 45");
        let projection = Projection::Orthographic { height: 2.5 };
        let lens = Lens { aperture: 0.25, focus: Some(3.0) };
        let all = camera_options(&Camera { projection, lens, shift: [0.5, -0.25], ..camera });
        assert!(
            all.ends_with(
                "--projection orthographic --view-height 2.5 --shift 0.5,-0.25 --aperture 0.25 --focus 3"
            ),
            "{all}"
        );
    }
}
