// SPDX-License-Identifier: GPL-3.0-or-later
//! The main loop without a window: frames as fast as they come, to files. Tests: tests/window.rs.

use super::pixels::write_ppm;
use super::program::Program;
use super::settings::Settings;

/// Requests frames until there are enough, or none comes any more.
pub(super) fn run(program: &dyn Program, settings: &Settings) -> Result<(), String> {
    let mut size = [0; 2];
    program.stage(&mut |stage| size = stage.size);
    program.reshape(size);
    let mut displayed = 0;
    loop {
        let (mut is_stale, mut is_leaving) = (false, false);
        program.stage(&mut |stage| {
            (is_stale, is_leaving) = (std::mem::take(&mut stage.is_stale), stage.is_leaving);
        });
        if is_leaving {
            break;
        }
        if is_stale {
            program.display();
        }
        let mut is_over = false;
        keep(program, settings, &mut displayed)?;
        program.stage(&mut |stage| is_over = settings.is_enough(stage.pictures));
        if is_over {
            break;
        }
        let animates = program.idle();
        // Nothing would ever change again.
        let mut is_still = false;
        program.stage(&mut |stage| is_still = !stage.is_stale && !stage.is_leaving && !animates);
        if is_still {
            break;
        }
    }
    let mut is_enough = false;
    program.stage(&mut |stage| is_enough = settings.is_enough(stage.pictures));
    if !is_enough {
        program.finish();
    }
    keep(program, settings, &mut displayed)
}

/// Writes the picture if it is a new one.
pub(super) fn keep(program: &dyn Program, settings: &Settings, displayed: &mut u64) -> Result<(), String> {
    let mut outcome = Ok(());
    program.stage(&mut |stage| {
        if stage.pictures == *displayed {
            return;
        }
        let path = settings.file(*displayed);
        *displayed = stage.pictures;
        if let Some(path) = path {
            let mut bytes = Vec::new();
            let written = write_ppm(&mut bytes, stage.screen_size, &stage.screen);
            let written = written.and_then(|()| std::fs::write(&path, bytes));
            outcome = written.map_err(|error| format!("cannot write {}: {error}", path.display()));
        }
    });
    outcome
}
