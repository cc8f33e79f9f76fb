// SPDX-License-Identifier: GPL-3.0-or-later
//! Perspective cameras.
//! Source: original; the frame is that of references/README point 5. Space: world; right-handed.

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// For people.
    pub name: String,
    /// Where the pinhole is.
    pub eye: [f32; 3],
    /// A point in the middle of the picture.
    pub target: [f32; 3],
    /// What is up; need not be perpendicular to the view.
    pub up: [f32; 3],
    /// Vertical angle of view in degrees, in (0, 180).
    pub fov_y: f32,
}

/// The camera's axes in world space: unit vectors, perpendicular to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// To the right of the picture: forward x up.
    pub right: [f32; 3],
    /// Up in the picture.
    pub up: [f32; 3],
    /// Into the picture.
    pub forward: [f32; 3],
    /// Whether `up` was parallel to the view and another one was chosen.
    pub up_replaced: bool,
}

impl Camera {
    /// Its axes, computed in double precision; `None` if eye and target coincide or a value is not finite.
    #[must_use]
    pub fn frame(&self) -> Option<Frame> {
        let eye = self.eye.map(f64::from);
        let forward = unit([0, 1, 2].map(|k| f64::from(self.target[k]) - eye[k]))?;
        let given = unit(self.up.map(f64::from)).map(|up| cross(forward, up));
        // Closer than a hundred-thousandth of a radian to the view, `up` says nothing.
        let usable = given.filter(|r| r.iter().map(|x| x * x).sum::<f64>().sqrt() > 1e-5);
        let right = match usable {
            Some(right) => unit(right)?,
            None => {
                let other = if forward[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, -1.0] };
                unit(cross(forward, other))?
            }
        };
        let up = cross(right, forward);
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        Some(Frame {
            right: single(right),
            up: single(up),
            forward: single(forward),
            up_replaced: usable.is_none(),
        })
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_is_right_handed_and_survives_bad_up() {
        let camera = |target, up| Camera { name: String::new(), eye: [0.0; 3], target, up, fov_y: 45.0 };
        let frame = camera([0.0, 0.0, -5.0], [0.0, 3.0, 0.0]).frame().expect("a view");
        assert_eq!(frame.right, [1.0, 0.0, 0.0], "x is to the right when one looks along -z");
        assert!(!frame.up_replaced, "the up given was good");
        assert!(camera([0.0, 2.0, 0.0], [0.0, 1.0, 0.0]).frame().expect("a view").up_replaced, "parallel up");
        assert_eq!(camera([0.0; 3], [0.0, 1.0, 0.0]).frame(), None, "no view");
    }
}
