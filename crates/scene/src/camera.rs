// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras: position, projection and lens. The frame is that of references/README point 5. Space: world;
//! right-handed.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// A label.
    pub name: String,
    /// Where the pinhole, or the middle of the lens, is.
    pub eye: [f32; 3],
    /// A point in the middle of the picture, where that is not shifted.
    pub target: [f32; 3],
    /// The up direction; it need not be perpendicular to the view.
    pub up: [f32; 3],
    /// Vertical angle of view in degrees: in (0, 180) of perspectives, in (0, 360] of fisheyes; others do not read it.
    pub fov_y: f32,
    /// The map from directions to positions in the picture.
    pub projection: Projection,
    /// The lens.
    pub lens: Lens,
    /// From the view to the middle of the picture, to the right and up, in heights of the picture: of perspective and orthographic
    /// cameras.
    pub shift: [f32; 2],
}

impl Default for Camera {
    /// A pinhole at the origin that faces -z.
    fn default() -> Self {
        Self {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 45.0,
            projection: Projection::default(),
            lens: Lens::default(),
            shift: [0.0; 2],
        }
    }
}

/// The map from directions to positions in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// Straight lines stay straight; distant objects are smaller.
    #[default]
    Perspective,
    /// All rays are parallel and begin in the plane of the eye.
    Orthographic {
        /// Height of the visible region, world units.
        height: f32,
    },
    /// The distance from the middle of the picture is the angle to the view (equidistant); `fov_y` is the angle between the upper and
    /// the lower edge. Nothing is seen where the angle would be more than 180 degrees.
    Fisheye,
    /// All directions: across the picture those around the camera's up, the view in the middle; from its upper to its lower edge those from
    /// straight up to straight down (equirectangular). Twice as wide as high, its pixels are square at the horizon.
    Panorama,
}

impl Projection {
    /// The words of all of them, as files and options have them.
    pub const NAMES: [&str; 4] = ["perspective", "orthographic", "fisheye", "panorama"];

    /// Whether pictures lie on a plane, and so may be [shifted](Camera::shift).
    #[must_use]
    pub fn is_flat(self) -> bool {
        matches!(self, Self::Perspective | Self::Orthographic { .. })
    }
}

impl fmt::Display for Projection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Perspective => Self::NAMES[0],
            Self::Orthographic { .. } => Self::NAMES[1],
            Self::Fisheye => Self::NAMES[2],
            Self::Panorama => Self::NAMES[3],
        })
    }
}

/// A thin, round lens. The focus surface is a plane across the view; for fisheyes and panoramas it is a
/// sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// Its diameter in world units; 0 = a pinhole, all is in focus.
    pub aperture: f32,
    /// Distance from the eye to the focus surface, world units, above 0; `None` = distance of the target.
    pub focus: Option<f32>,
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
    /// The largest shift, in heights of the picture.
    pub const MOST_SHIFT: f32 = 1000.0;

    /// Distance from the eye to the focus surface.
    #[must_use]
    pub fn focus_distance(&self) -> f32 {
        let target = || {
            (0..3).map(|k| (f64::from(self.target[k]) - f64::from(self.eye[k])).powi(2)).sum::<f64>().sqrt()
                as f32
        };
        self.lens.focus.unwrap_or_else(target)
    }

    /// How much a perspective of its angle shows at the target, from the lower edge to the upper one.
    #[must_use]
    pub fn height_at_target(&self) -> f32 {
        let far =
            (0..3).map(|k| (f64::from(self.target[k]) - f64::from(self.eye[k])).powi(2)).sum::<f64>().sqrt();
        (2.0 * far * (f64::from(self.fov_y).to_radians() / 2.0).tan()) as f32
    }

    /// The reason that the camera cannot be used, with the remedy; `None` for a valid camera.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        let Some(_) = self.frame().filter(|_| self.eye.iter().all(|x| x.is_finite())) else {
            return Some("it has no view: eye and target must be finite and differ".into());
        };
        let [angle, focus] = [self.fov_y, self.focus_distance()];
        match self.projection {
            Projection::Perspective if !(angle > 0.0 && angle < 180.0) => Some(format!(
                "its angle of view is {angle} degrees: that of a perspective is above 0 and below 180"
            )),
            Projection::Fisheye if !(angle > 0.0 && angle <= 360.0) => Some(format!(
                "its angle of view is {angle} degrees: that of a fisheye is above 0 and at most 360"
            )),
            Projection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                Some(format!("the height of its view is {height}: it must be above 0"))
            }
            _ if !(self.lens.aperture >= 0.0 && self.lens.aperture.is_finite()) => {
                Some(format!("its aperture is {}: it must be 0 or above", self.lens.aperture))
            }
            _ if !(focus > 0.0 && focus.is_finite()) => {
                Some(format!("its distance of focus is {focus}: it must be above 0"))
            }
            _ if !self.shift.iter().all(|x| x.abs() <= Self::MOST_SHIFT) => {
                Some(format!("its shift is {:?}: at most {} heights", self.shift, Self::MOST_SHIFT))
            }
            _ if self.shift != [0.0; 2] && !self.projection.is_flat() => {
                Some(format!("a {} has no shift", self.projection))
            }
            _ => None,
        }
    }

    /// Its axes, computed in double precision; `None` if eye and target coincide or a value is not finite.
    #[must_use]
    pub fn frame(&self) -> Option<Frame> {
        let eye = self.eye.map(f64::from);
        let forward = unit([0, 1, 2].map(|k| f64::from(self.target[k]) - eye[k]))?;
        let given = unit(self.up.map(f64::from)).map(|up| cross(forward, up));
        // Closer than a hundred-thousandth of a radian to the view, `up` is undefined.
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
        let camera = |target, up| Camera { target, up, ..Camera::default() };
        let frame = camera([0.0, 0.0, -5.0], [0.0, 3.0, 0.0]).frame().expect("a view");
        assert_eq!(frame.right, [1.0, 0.0, 0.0], "x is to the right when one looks along -z");
        assert!(!frame.up_replaced, "the up given was good");
        assert!(camera([0.0, 2.0, 0.0], [0.0, 1.0, 0.0]).frame().expect("a view").up_replaced, "parallel up");
        assert_eq!(camera([0.0; 3], [0.0, 1.0, 0.0]).frame(), None, "no view");
    }

    #[test]
    fn faults_are_told() {
        let fault = |edit: fn(&mut Camera)| {
            let mut camera = Camera::default();
            edit(&mut camera);
            camera.fault()
        };
        assert_eq!(fault(|_| ()), None, "the default is sound");
        let bad: [fn(&mut Camera); 12] = [
            |c| c.eye = c.target,
            |c| c.eye[0] = f32::NAN,
            |c| c.fov_y = 180.0,
            |c| (c.projection, c.fov_y) = (Projection::Fisheye, 361.0),
            |c| c.projection = Projection::Orthographic { height: 0.0 },
            |c| c.projection = Projection::Orthographic { height: f32::INFINITY },
            |c| c.lens.aperture = -1.0,
            |c| c.lens.aperture = f32::NAN,
            |c| c.lens.focus = Some(0.0),
            |c| c.shift[0] = f32::NAN,
            |c| c.shift[1] = -1001.0,
            |c| (c.projection, c.shift) = (Projection::Panorama, [0.0, 0.1]),
        ];
        for (i, bad) in bad.into_iter().enumerate() {
            assert!(fault(bad).is_some(), "fault {i}");
        }
        assert_eq!(fault(|c| (c.projection, c.fov_y) = (Projection::Fisheye, 360.0)), None, "all around");
        assert_eq!(fault(|c| (c.projection, c.fov_y) = (Projection::Panorama, 0.0)), None, "reads no angle");
    }
}
