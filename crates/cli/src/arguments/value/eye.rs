// SPDX-License-Identifier: GPL-3.0-or-later
//! Values for the eye's position, and its camera. See docs/reference/cli.md. Tests: `tests` of
//! `value/mod.rs`.

use gnurt::scene::{Camera, Projection};

use super::plain::{by_name, list, number};

/// Three numbers.
pub(crate) fn point(text: &str) -> Result<[f32; 3], String> {
    let numbers: [f32; 3] = list(text, "give three numbers like 0,1.5,-3")?;
    if numbers.iter().all(|x| x.is_finite()) {
        Ok(numbers)
    } else {
        Err("not a finite number; give three numbers like 0,1.5,-3".into())
    }
}

/// Three numbers that are not all zero.
pub(crate) fn direction(text: &str) -> Result<[f32; 3], String> {
    if let "x" | "y" | "z" = text {
        return Err(format!(
            "give three numbers like 0,1,0; --up-axis {text} names the upward axis of a file"
        ));
    }
    match point(text)? {
        [0.0, 0.0, 0.0] => Err("the zero vector has no direction; give one like 0,1,0".into()),
        direction => Ok(direction),
    }
}

/// Degrees above 0, up to 360; how many a projection takes shows when it is known.
pub(crate) fn angle_of_view(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    // An angle that rounds to 0 in single precision shows nothing either.
    let usable = (1e-4..=360.0).contains(&degrees);
    if usable {
        Ok(degrees)
    } else {
        Err("give degrees above 0 and below 180, or of a fisheye at most 360".into())
    }
}

/// A projection's name; the height of an orthographic one has a separate option and is 0 here.
pub(crate) fn projection(name: &str) -> Result<Projection, String> {
    let all = [
        Projection::Perspective,
        Projection::Orthographic { height: 0.0 },
        Projection::Fisheye,
        Projection::Panorama,
    ];
    by_name("projection", name, &all)
}

/// A length above 0.
pub(crate) fn length(text: &str) -> Result<f32, String> {
    let length = number(text)?;
    if length > 0.0 { Ok(length) } else { Err("give a length above 0".into()) }
}

/// A diameter of 0 or above.
pub(crate) fn aperture(text: &str) -> Result<f32, String> {
    let diameter = number(text)?;
    if diameter >= 0.0 { Ok(diameter) } else { Err("give a diameter of 0 or above".into()) }
}

/// Two heights of the picture.
pub(crate) fn shift(text: &str) -> Result<[f32; 2], String> {
    let shift: [f32; 2] = list(text, "give two numbers like 0,0.25")?;
    if shift.iter().all(|x| x.abs() <= Camera::MOST_SHIFT) {
        Ok(shift)
    } else {
        Err(format!("give two numbers from -{0} to {0}", Camera::MOST_SHIFT))
    }
}

/// Degrees, in both directions.
pub(crate) fn turn(text: &str) -> Result<f64, String> {
    let degrees = f64::from(number(text)?);
    if degrees.abs() <= 1e6 { Ok(degrees) } else { Err("give degrees from -1000000 to 1000000".into()) }
}
