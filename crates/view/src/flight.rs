// SPDX-License-Identifier: GPL-3.0-or-later
//! Motion of a camera: orbit, pan, dolly, flight, and rotation in place. Turntable orbit: yaw about a fixed
//! up, pitch between the poles. Space: world; double precision, so that thousands of small moves add no
//! visible drift. Invariants: eye and target never coincide; the view never reaches the poles; a move and its
//! reverse cancel within rounding. Tests: `tests`.

use glam::{DQuat, DVec3};
use gnurt::scene::{Camera, Projection};

/// A camera in motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    eye: DVec3,
    target: DVec3,
    /// Unit; yaw rotates about it.
    up: DVec3,
    /// Its settings; the position is elsewhere.
    like: Camera,
    /// The initial camera, while nothing has moved: it is printed and rendered unchanged.
    untouched: Option<Camera>,
}

/// The view comes no nearer to straight up or down than this, in radians.
const POLE: f64 = 0.002;
/// Eye and target come no nearer than this share of their distance in the beginning, nor farther than its inverse.
const NEAREST: f64 = 1e-5;

impl Flight {
    /// Begins at a camera; `None` if that has no view.
    #[must_use]
    pub fn new(camera: &Camera) -> Option<Self> {
        let frame = camera.frame()?;
        let up = DVec3::from(camera.up.map(f64::from)).try_normalize();
        // The up of the picture, where the camera's own is undefined.
        let up = up.filter(|_| !frame.up_replaced).unwrap_or(DVec3::from(frame.up.map(f64::from)));
        Some(Self {
            eye: DVec3::from(camera.eye.map(f64::from)),
            target: DVec3::from(camera.target.map(f64::from)),
            up,
            like: camera.clone(),
            untouched: Some(camera.clone()),
        })
    }

    /// The camera where it is now.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let single = |v: DVec3| v.to_array().map(|x| x as f32);
        self.untouched.clone().unwrap_or_else(|| Camera {
            eye: single(self.eye),
            target: single(self.target),
            up: single(self.up),
            ..self.like.clone()
        })
    }

    /// Distance from eye to target.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.eye.distance(self.target)
    }

    /// Moves the eye around the target: to the right by `yaw` radians, upwards by `pitch`.
    pub fn orbit(&mut self, yaw: f64, pitch: f64) {
        let arm = self.turned(self.eye - self.target, yaw, pitch);
        self.set_position(self.target + arm, self.target);
    }

    /// Rotates the view by `yaw` radians to the left, by `pitch` upwards.
    pub fn rotate(&mut self, yaw: f64, pitch: f64) {
        let view = self.turned(self.target - self.eye, yaw, pitch);
        self.set_position(self.eye, self.eye + view);
    }

    /// `arm` rotated about the up and towards it, but not over the poles.
    fn turned(&self, arm: DVec3, yaw: f64, pitch: f64) -> DVec3 {
        let length = arm.length();
        let elevation = (arm.dot(self.up) / length).clamp(-1.0, 1.0).asin();
        let most = std::f64::consts::FRAC_PI_2 - POLE;
        let pitch = (elevation + pitch).clamp(-most, most) - elevation;
        let arm = DQuat::from_axis_angle(self.up, yaw) * arm;
        match arm.cross(self.up).try_normalize() {
            Some(axis) => DQuat::from_axis_angle(axis, pitch) * arm,
            None => arm,
        }
    }

    /// Moves the eye to `factor` times its distance from the target; for parallel rays, scales the height of
    /// the view.
    pub fn dolly(&mut self, factor: f64) {
        let farthest = 1.0 / NEAREST;
        let scale = self.scale();
        let distance = (self.distance() * factor).clamp(NEAREST * scale, farthest * scale);
        let arm = (self.eye - self.target) / self.distance() * distance;
        let ratio = distance / self.distance();
        if let Projection::Orthographic { height } = &mut self.like.projection {
            *height = (f64::from(*height) * ratio) as f32;
        }
        self.set_position(self.target + arm, self.target);
    }

    /// Moves eye and target in units of the world: to the right, up in the picture, forward.
    pub fn fly(&mut self, [right, up, forward]: [f64; 3]) {
        let axes = self.axes();
        let direction = axes[0] * right + axes[1] * up + axes[2] * forward;
        self.set_position(self.eye + direction, self.target + direction);
    }

    /// Moves eye and target so that a point at the target's distance follows a cursor that moves by `pixels`
    /// (right, down) in a picture of `height` pixels.
    pub fn pan(&mut self, pixels: [f64; 2], height: f64) {
        let half_angle = f64::from(self.like.fov_y).to_radians() / 2.0;
        let view_height = match self.like.projection {
            Projection::Perspective => 2.0 * self.distance() * half_angle.tan(),
            Projection::Orthographic { height } => f64::from(height),
            Projection::Fisheye => 2.0 * self.distance() * half_angle,
            Projection::Panorama => self.distance() * std::f64::consts::PI,
        };
        let unit = view_height / height.max(1.0);
        self.fly([-pixels[0] * unit, pixels[1] * unit, 0.0]);
    }

    /// A size to measure limits with: the magnitude of the numbers whose difference is eye minus target.
    fn scale(&self) -> f64 {
        self.target.abs().max_element().max(self.distance()).clamp(1e-12, 1e12)
    }

    fn axes(&self) -> [DVec3; 3] {
        let forward = (self.target - self.eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(self.up).normalize_or(DVec3::X);
        [right, right.cross(forward), forward]
    }

    fn set_position(&mut self, eye: DVec3, target: DVec3) {
        let distinct = eye.as_vec3().distance(target.as_vec3()) > 0.0;
        let moved = eye != self.eye || target != self.target;
        if moved && distinct && eye.is_finite() && target.is_finite() {
            (self.eye, self.target, self.untouched) = (eye, target, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn camera() -> Camera {
        Camera {
            name: "a".into(),
            eye: [0.0, 0.0, 4.0],
            target: [0.0; 3],
            up: [0.0, 2.0, 0.0],
            fov_y: 90.0,
            ..Camera::default()
        }
    }

    fn flight() -> Flight {
        Flight::new(&camera()).expect("a view")
    }

    fn near(found: [f32; 3], expected: [f32; 3]) -> bool {
        (0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5)
    }

    #[test]
    fn it_begins_where_the_camera_is() {
        assert_eq!(flight().camera(), camera(), "not a bit is changed, not even the length of up");
        let mut still = flight();
        still.fly([0.0; 3]);
        assert_eq!(still.camera(), camera(), "nor by no move");
        assert_eq!(Flight::new(&Camera { target: [0.0, 0.0, 4.0], ..camera() }), None, "no view");
    }

    #[test]
    fn orbits_keep_the_distance() {
        let mut flight = flight();
        flight.orbit(FRAC_PI_2, 0.0);
        assert!(near(flight.camera().eye, [4.0, 0.0, 0.0]), "a quarter to the right: {flight:?}");
        flight.orbit(0.0, PI / 6.0);
        assert!(near(flight.camera().eye, [12.0_f32.sqrt(), 2.0, 0.0]), "30 degrees up: {flight:?}");
        assert_eq!(flight.camera().target, [0.0; 3], "the target stays");
        for _ in 0..1000 {
            flight.orbit(2.0 * PI / 1000.0, 0.0);
        }
        assert!(near(flight.camera().eye, [12.0_f32.sqrt(), 2.0, 0.0]), "once around: {flight:?}");
        flight.orbit(0.0, 100.0);
        let eye = flight.camera().eye;
        assert!(eye[1] > 3.99 && (eye[0] > 0.0), "it stops before the pole: {eye:?}");
        assert!((flight.distance() - 4.0).abs() < 1e-9, "at the same distance");
        assert!(flight.camera().frame().is_some_and(|frame| !frame.up_replaced), "up is still up");
    }

    #[test]
    fn heads_turn_and_legs_walk() {
        let mut turning = flight();
        turning.rotate(FRAC_PI_2, 0.0);
        assert!(near(turning.camera().target, [-4.0, 0.0, 4.0]), "to the left: {turning:?}");
        assert_eq!(turning.camera().eye, [0.0, 0.0, 4.0], "the eye stays");
        turning.rotate(0.0, PI / 6.0);
        assert!(turning.camera().target[1] > 1.9, "up: {turning:?}");
        let mut flying = flight();
        flying.fly([1.0, 2.0, 3.0]);
        assert!(near(flying.camera().eye, [1.0, 2.0, 1.0]), "right, up, forward: {flying:?}");
        assert!(near(flying.camera().target, [1.0, 2.0, -3.0]), "the target goes with it");
    }

    #[test]
    fn pans_follow_the_cursor() {
        let mut flight = flight();
        // 90 degrees at distance 4 are 8 units over the whole height.
        flight.pan([100.0, 50.0], 800.0);
        assert!(
            near(flight.camera().target, [-1.0, 0.5, 0.0]),
            "what was in the middle moved along: {flight:?}"
        );
    }

    #[test]
    fn dollies_never_arrive() {
        let mut flight = flight();
        flight.dolly(0.5);
        assert!(near(flight.camera().eye, [0.0, 0.0, 2.0]), "half as far: {flight:?}");
        for factor in [1e-3, 1e3] {
            for _ in 0..50 {
                flight.dolly(factor);
            }
            let view = flight.camera().frame();
            assert!(view.is_some() && flight.distance() > 0.0, "there is still a view: {flight:?}");
        }
    }
}
