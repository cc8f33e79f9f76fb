// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames: renderings that run beside the program, end, add up, are stopped and called back.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anari_library_gnurt::types as t;

use crate::common::Set;

fn scene() -> Set {
    let mut set = Set::new("default");
    let (square, grey) = (set.square(0.7), set.matte([0.5; 3]));
    set.add(square, grey);
    set.light("point", &[("position", &[0.3, 0.2, 1.0])]);
    set.ambient(0.3);
    set.commit();
    set
}

const COLOR: [(&str, t::DataType); 1] = [("channel.color", t::FLOAT32_VEC4)];

fn bits(set: &Set, frame: usize) -> Vec<u8> {
    set.client.channel(frame, "channel.color").expect("a picture").bytes
}

#[test]
fn equal_frames_are_equal_and_accumulation_adds_up() {
    let set = scene();
    set.samples(4);
    let (once, twice, sums) =
        (set.frame([32, 32], &COLOR), set.frame([32, 32], &COLOR), set.frame([32, 32], &COLOR));
    set.client.set(sums, "accumulation", t::BOOL, &[1]);
    set.client.commit(sums);
    for frame in [once, twice, twice, sums] {
        set.client.render(frame);
    }
    assert_eq!(bits(&set, once), bits(&set, twice), "without accumulation each frame begins again");
    assert_eq!(bits(&set, once), bits(&set, sums), "the first frame is the same");
    set.client.render(sums);
    let second = bits(&set, sums);
    assert_ne!(bits(&set, once), second, "further samples change it");
    let samples = |frame| set.client.property(frame, "numSamples", t::INT32).map(|b| b[0]);
    assert_eq!([samples(once), samples(sums)], [Some(4), Some(8)], "samples of a pixel");
    // Twice as many samples at once are the same picture.
    set.samples(8);
    set.client.render(once);
    assert_eq!(bits(&set, once), second, "eight samples, whichever frames take them");
    // Changes begin the sums again.
    set.samples(4);
    set.client.render(sums);
    assert_eq!(samples(sums), Some(4), "another renderer");
    set.client.render(sums);
    set.client.set_vec3(set.camera, "position", [0.1, 0.0, 5.0]);
    set.client.commit(set.camera);
    set.client.render(sums);
    assert_eq!(samples(sums), Some(4), "another camera");
    set.assert_quiet();
}

#[test]
fn frames_run_beside_the_program_and_are_stopped() {
    let set = scene();
    set.samples(1 << 16);
    let frame = set.frame([256, 256], &COLOR);
    let begin = Instant::now();
    set.client.render(frame);
    assert!(!set.client.is_ready(frame, false), "it takes minutes");
    std::thread::sleep(Duration::from_millis(50));
    set.client.discard(frame);
    assert!(set.client.is_ready(frame, true), "stopped");
    assert!(begin.elapsed() < Duration::from_secs(60), "soon: {:?}", begin.elapsed());
    set.samples(1);
    set.client.render(frame);
    assert!(set.client.is_ready(frame, true), "and it renders again");
    assert!(
        set.client.property(frame, "duration", t::FLOAT32).is_some_and(|b| b != [0; 4]),
        "it took some time"
    );
}

#[test]
fn callbacks_are_called_once_for_each_rendering() {
    let set = scene();
    let counter = AtomicUsize::new(0);
    let frame = set.frame([16, 16], &COLOR);
    set.client.count_completions(frame, &counter);
    set.client.commit(frame);
    for expected in 1..=3 {
        set.client.render(frame);
        assert!(set.client.is_ready(frame, true), "waited for");
        assert_eq!(counter.load(Ordering::SeqCst), expected, "called before the wait ends");
    }
    set.client.release(frame);
}

#[test]
fn frames_show_what_was_committed_when_they_began() {
    let set = scene();
    let frame = set.frame([16, 16], &COLOR);
    set.client.render(frame);
    let before = bits(&set, frame);
    set.client.set_floats(set.renderer, "background", t::FLOAT32_VEC4, &[1.0; 4]);
    set.client.render(frame);
    assert_eq!(bits(&set, frame), before, "set, but not committed");
    set.client.commit(set.renderer);
    set.client.render(frame);
    assert_ne!(bits(&set, frame), before, "committed");
}

#[test]
fn frames_that_do_not_add_up_take_more_samples() {
    let set = scene();
    let (once, sums) = (set.frame([4, 4], &COLOR), set.frame([4, 4], &COLOR));
    set.client.set(sums, "accumulation", t::BOOL, &[1]);
    set.client.commit(sums);
    for (frame, expected) in [(once, 16), (sums, 4)] {
        set.client.render(frame);
        let samples = set.client.property(frame, "numSamples", t::INT32);
        assert_eq!(samples.map(|b| b[0]), Some(expected), "by default");
    }
}

#[test]
fn many_threads_render_at_once() {
    let set = scene();
    let frames: Vec<usize> = (0..4).map(|_| set.frame([24, 24], &COLOR)).collect();
    std::thread::scope(|scope| {
        for &frame in &frames {
            let client = &set.client;
            scope.spawn(move || {
                for _ in 0..3 {
                    client.render(frame);
                    assert!(client.is_ready(frame, true), "waited for");
                }
            });
        }
    });
    let first = bits(&set, frames[0]);
    assert!(frames.iter().all(|&frame| bits(&set, frame) == first), "all show the same");
    set.assert_quiet();
}

#[test]
fn released_frames_end() {
    let set = scene();
    set.samples(1 << 16);
    let frame = set.frame([128, 128], &COLOR);
    set.client.render(frame);
    set.client.release(frame);
    let begin = Instant::now();
    drop(set);
    assert!(begin.elapsed() < Duration::from_secs(60), "the device waits for it, but not for its end");
}
