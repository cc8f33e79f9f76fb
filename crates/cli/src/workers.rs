// SPDX-License-Identifier: GPL-3.0-or-later
//! What a command computes with. Tests: `tests/program/arguments.rs`.

use crate::arguments::MachineArguments;
use crate::environment::Environment;
use crate::failure::Failure;

/// Threads and instruction set: options win over the environment, which wins over what the machine has.
pub(crate) fn machine(
    arguments: &MachineArguments,
    environment: &Environment,
) -> Result<(gnurt::ThreadPool, gnurt::simd::Level), Failure> {
    let threads = arguments.threads.or(environment.threads).unwrap_or(0);
    let pool = gnurt::thread_pool(threads).map_err(Failure::data)?;
    Ok((pool, arguments.isa.or(environment.isa).unwrap_or_default()))
}
