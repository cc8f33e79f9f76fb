// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask dist`: the release files in target/dist: the source and the program with its libraries as
//! tarballs, and three Debian packages (gnurt, libopenrt0, libopenrt-dev). The split after the Debian policy,
//! chapter 8. Needs git, tar and, for the packages, dpkg-deb and gzip.

mod debian;

use std::path::Path;
use std::process::Command;

use crate::command::{self, output_of};
use crate::failure::Failure;
use crate::install::{Locations, install_at, parse};
use crate::notices;
use crate::workspace::Workspace;

const USAGE: &str = "usage: cargo xtask dist [--built DIR] [--no-strip]";

/// Makes everything; `--built DIR` uses cargo's output there.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if arguments == ["--help"] {
        eprintln!("{USAGE}");
        return Ok(());
    }
    // Wrong ones are reported before anything is made.
    check(arguments)?;
    notices::check()?;
    let workspace = Workspace::load()?;
    let version = &workspace.version;
    let dist = workspace.target.join("dist");
    let _ = std::fs::remove_dir_all(&dist);
    std::fs::create_dir_all(&dist).map_err(|error| format!("{}: {error}", dist.display()))?;

    source_tarball(&dist, version)?;

    let machine = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    let folder = format!("gnurt-{version}-{machine}");
    install_at(&locations(arguments, &dist.join(&folder), "/usr/local", "lib")?)?;
    tarball(&dist, &folder)?;

    if Command::new("dpkg-deb").arg("--version").output().is_err() {
        eprintln!("note: no dpkg-deb here: the Debian packages are left out");
        return Ok(());
    }
    let multiarch = output_of("dpkg-architecture", &["-qDEB_HOST_MULTIARCH"])
        .unwrap_or_else(|_| format!("{}-linux-gnu", std::env::consts::ARCH));
    let staged = dist.join("debian");
    install_at(&locations(arguments, &staged, "/usr", &format!("lib/{multiarch}"))?)?;
    debian::pack(&dist, &staged, version)?;
    std::fs::remove_dir_all(&staged).map_err(|error| format!("{}: {error}", staged.display()))?;
    eprintln!("made {}", dist.display());
    Ok(())
}

/// Of the arguments of `install` only those that leave each file in the folder where its package needs it.
fn check(arguments: &[String]) -> Result<(), Failure> {
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match &argument[..] {
            "--no-strip" => {}
            "--built" => drop(rest.next()),
            other if other.starts_with("--built=") => {}
            other => return Err(format!("unknown argument '{other}'; {USAGE}")),
        }
    }
    locations(arguments, Path::new("/nowhere"), "/usr", "lib").map(drop)
}

fn locations(arguments: &[String], destdir: &Path, prefix: &str, lib: &str) -> Result<Locations, Failure> {
    let mut tokens = vec!["--prefix".to_owned(), prefix.to_owned(), "--libdir".to_owned(), lib.to_owned()];
    tokens.extend(["--destdir".to_owned(), destdir.display().to_string()]);
    // Debian has it in the package of development files.
    if cfg!(target_os = "linux") {
        tokens.push("--static".to_owned());
    }
    tokens.extend_from_slice(arguments);
    parse(&tokens)
}

/// The committed files.
fn source_tarball(dist: &Path, version: &str) -> Result<(), Failure> {
    let name = format!("gnurt-{version}");
    let to = dist.join(format!("{name}.tar.gz"));
    let mut archive = Command::new("git");
    archive.current_dir(command::root()).args(["archive", "--format=tar.gz"]);
    command::run(archive.arg(format!("--prefix={name}/")).arg("-o").arg(to).arg("HEAD"))
}

/// A folder in `dist`, as a tarball that is the same for the same files.
fn tarball(dist: &Path, folder: &str) -> Result<(), Failure> {
    let mut tar = Command::new("tar");
    tar.current_dir(dist).args([
        "--sort=name",
        "--owner=0",
        "--group=0",
        "--numeric-owner",
        "--mtime",
        &time()?,
    ]);
    command::run(tar.args(["-czf", &format!("{folder}.tar.gz"), folder]))
}

/// When the last commit was made.
fn time() -> Result<String, Failure> {
    output_of("git", &["log", "-1", "--format=@%ct"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_that_move_files_are_refused() {
        let check = |line: &str| check(&line.split_whitespace().map(String::from).collect::<Vec<_>>());
        for good in ["", "--built target/debug", "--no-strip --built=x"] {
            assert_eq!(check(good), Ok(()), "'{good}'");
        }
        for (bad, expected) in
            [("--prefix /opt", "'--prefix'"), ("--buildt x", "'--buildt'"), ("--built", "'--built'")]
        {
            let failure = check(bad).expect_err("this is no way to call it");
            assert!(failure.contains(expected) && failure.contains("usage: "), "'{bad}': {failure}");
        }
    }
}
