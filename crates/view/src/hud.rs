// SPDX-License-Identifier: GPL-3.0-or-later
//! The numbers over the picture, and the explanation of keys.
//! The numbers that users expect in a viewer: fps of rendering and of display, milliseconds, samples, rays
//! per second, size, memory. Tests: `tests`.

use crate::controls::Controls;
use crate::text;

/// Measurements of the displayed picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Readings {
    /// Seconds that the last pass and its display took.
    pub(crate) seconds: f64,
    /// Rays of the last pass.
    pub(crate) rays: u64,
    /// Samples per pixel so far, and when it is done.
    pub(crate) samples: [u32; 2],
    /// Columns and rows that were rendered.
    pub(crate) rendered: [u32; 2],
    /// Whether the noise was taken out of it.
    pub(crate) denoised: bool,
    /// Seconds that it took to bring the scene to its time: poses, trees, lights.
    pub(crate) update_seconds: f64,
}

/// The keys, a line each.
pub const KEYS: &str = "\
left drag           orbit
right, shift drag   pan
wheel               nearer, farther
click               what is it?
W A S D  Q E        fly: forward, left, back, right, down, up
arrows              turn the head
+ -                 fly faster, slower
R                   back to the beginning
[ ]                 the scene's cameras
{ }                 its clips
1 .. 9 0, Tab       what is shown
b B                 brighter, darker
T                   tone curve
P                   pause: no more samples
space               play, stop
, .                 a frame back, a frame on
N                   take the noise out
M                   parameters of shaders
J K                 the one before, the next one
u i, U I            less, more; ten times as much
O                   as it was
C                   print the camera
F12, Ctrl-S         write a picture
Ctrl-R              write all pictures, until pressed again
F                   fill the screen
G                   numbers
H                   these keys
Esc, Ctrl-Q         leave";

/// The lines of numbers. `drawn` = pictures per second that reached the screen; `messages` are more lines, for a while.
pub(crate) fn lines(
    controls: &Controls,
    readings: &Readings,
    drawn: f64,
    memory: u64,
    messages: &[String],
) -> Vec<String> {
    let seconds = readings.seconds.max(1e-9);
    let [columns, rows] = readings.rendered;
    let exposure = controls.exposure;
    let paused = if controls.paused { "  paused" } else { "" };
    let noise = match (readings.denoised, controls.denoised) {
        (true, _) => "  denoised",
        (false, true) => "  not yet denoised",
        (false, false) => "",
    };
    let mut lines = vec![
        format!("{:.1} fps  drawn {drawn:.1}  {:.1} ms", 1.0 / seconds, seconds * 1e3),
        format!(
            "{} of {} samples  {columns}x{rows}{noise}{paused}",
            readings.samples[0], readings.samples[1]
        ),
        format!("{:.2} Mray/s  {} MiB", readings.rays as f64 * 1e-6 / seconds, memory >> 20),
        format!("{}  EV {:+.2}  {}", controls.shown, exposure.stops, exposure.tone),
    ];
    lines.extend(controls.playing.as_ref().map(|playing| playing.line(readings.update_seconds * 1e3)));
    lines.extend(controls.choices.line());
    lines.extend(controls.shader_controls.lines());
    lines.extend(messages.iter().cloned());
    lines
}

/// Draws the overlays that the controls enable.
pub(crate) fn draw(screen: &mut [u32], size: [u32; 2], controls: &Controls, lines: &[String]) {
    // Letters stay readable on screens with many pixels.
    let scale = (size[1] as usize / 800 + 1).min(4);
    if controls.help {
        let keys = KEYS.lines().chain([""]).map(ToString::to_string);
        let keys: Vec<String> = keys.chain(lines.iter().cloned()).collect();
        text::draw(screen, size, [8, 8], scale, &keys);
    } else if controls.hud {
        text::draw(screen, size, [8, 8], scale, lines);
    }
    if let Some(playing) = controls.playing.as_ref().filter(|_| controls.hud) {
        playing.draw_bar(screen, size, scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exposure::Exposure;
    use crate::playing::Playing;
    use crate::shown::Shown;

    #[test]
    fn all_numbers_are_shown() {
        let camera = gnurt::scene::Camera {
            name: String::new(),
            eye: [0.0, 0.0, 1.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov_y: 45.0,
            ..gnurt::scene::Camera::default()
        };
        let mut controls =
            Controls::new(&camera, Shown::Albedo, Exposure::default(), [200, 100]).expect("a view");
        controls.exposure.stops = -1.5;
        controls.paused = true;
        let readings = Readings {
            seconds: 0.05,
            rays: 1_500_000,
            samples: [3, 64],
            rendered: [640, 360],
            denoised: true,
            update_seconds: 0.0125,
        };
        let mut playing = Playing::new([0.0, 2.0]);
        playing.toggle();
        playing.pass_time(0.5);
        controls.playing = Some(playing);
        let messages = ["material 'oak'".to_owned()];
        let text = lines(&controls, &readings, 12.34, 77 << 20, &messages).join("\n");
        for part in [
            "20.0 fps",
            "12.3",
            "50.0 ms",
            "3 of 64",
            "640x360",
            "30.00 Mray/s",
            "77 MiB",
            "albedo",
            "-1.50",
            "clamp",
            "denoised",
            "paused",
            "0.50 of 2.00 s",
            "update 12.5 ms",
            "oak",
        ] {
            assert!(text.contains(part), "'{part}' is in:\n{text}");
        }
        let drawn = |controls: &Controls| {
            let mut screen = vec![0x0080_8080; 20_000];
            draw(&mut screen, [200, 100], controls, &["x".into()]);
            screen.iter().filter(|&&pixel| pixel != 0x0080_8080).count()
        };
        let numbers = drawn(&controls);
        controls.help = true;
        assert!(drawn(&controls) > 4 * numbers && numbers > 0, "help is larger");
        (controls.help, controls.hud) = (false, false);
        assert_eq!(drawn(&controls), 0, "nothing, if that is asked for");
    }
}
