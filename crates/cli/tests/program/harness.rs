// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs the program in an empty folder and inspects its output and its files. Invariants: no run takes longer
//! than [`PATIENCE`]; no variable of the tester's environment reaches the program.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longer than any run may take, even on a machine that is busy with other things.
const PATIENCE: Duration = Duration::from_secs(60);

/// Output and status of a run.
#[derive(Debug)]
pub(crate) struct Run {
    /// `None` if a signal ended it.
    pub(crate) status: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    /// Panics with all that was said unless the program succeeded.
    #[track_caller]
    pub(crate) fn success(self) -> Self {
        assert_eq!(self.status, Some(0), "the program was to succeed: {}{}", self.stdout, self.stderr);
        self
    }

    /// Lines of standard error that begin with this label.
    pub(crate) fn lines(&self, label: &str) -> Vec<&str> {
        self.stderr.lines().filter(|line| line.starts_with(label)).collect()
    }

    /// Panics unless there is exactly one line on standard error, an error, that contains `expected`.
    #[track_caller]
    pub(crate) fn fails(&self, status: i32, expected: &str) {
        let message = &self.stderr;
        assert_eq!(self.status, Some(status), "exit status; said: {message}{}", self.stdout);
        assert_eq!(self.lines("error: ").len(), 1, "exactly one error line: {message}");
        let others =
            message.lines().filter(|line| !line.starts_with("error: ") && !line.starts_with("warning: "));
        assert_eq!(others.count(), 0, "nothing but the error and warnings: {message}");
        assert!(self.lines("error: ")[0].contains(expected), "'{expected}' must be said: {message}");
        assert!(!message.contains("panicked") && !message.contains("internal:"), "a bug: {message}");
        assert!(!message.contains('\x1b'), "no colours where there is no terminal: {message}");
    }
}

/// A folder with the files of a test, removed at its end.
pub(crate) struct Folder {
    folder: tempfile::TempDir,
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn at(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Writes a file; makes folders on the way.
    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.at(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("folders can be made");
        std::fs::write(&path, bytes).expect("the folder can be written to");
        path
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.at(name)).unwrap_or_else(|error| panic!("{name} must be there: {error}"))
    }

    /// Names and contents of the files: equal before and after = nothing was touched.
    pub(crate) fn contents(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut all = BTreeMap::new();
        let mut folders = vec![self.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder can be listed") {
                let path = entry.expect("an entry").path();
                match path.is_dir() {
                    true => folders.push(path),
                    false => drop(all.insert(path.clone(), std::fs::read(path).unwrap_or_default())),
                }
            }
        }
        all
    }

    /// The program, to be run here.
    pub(crate) fn command<S: AsRef<OsStr>>(&self, arguments_given: &[S]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gnurt"));
        command.current_dir(self.path()).args(arguments_given).stdin(Stdio::null());
        let reaches_it = |name: &OsStr| {
            name.to_string_lossy().starts_with("GNURT_")
                || ["EMBREE4_LIB", "OIDN_LIB"].iter().any(|other| name == *other)
        };
        for (name, _) in std::env::vars_os().filter(|(name, _)| reaches_it(name)) {
            command.env_remove(name);
        }
        command
    }

    /// Runs the program here with these words.
    pub(crate) fn run<S: AsRef<OsStr>>(&self, arguments_given: &[S]) -> Run {
        finish(self.command(arguments_given))
    }

    /// Runs the program here; words are separated by blanks.
    pub(crate) fn gnurt(&self, line: &str) -> Run {
        self.run(&line.split_whitespace().collect::<Vec<_>>())
    }
}

/// Runs a command to its end and collects its output.
pub(crate) fn finish(mut command: Command) -> Run {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    collect(command.spawn().expect("the program can be started"))
}

/// Waits for a program, and collects its output.
pub(crate) fn collect(mut child: Child) -> Run {
    let [stdout, stderr] = [reader(child.stdout.take()), reader(child.stderr.take())];
    let begin = Instant::now();
    let status = loop {
        match child.try_wait().expect("the program can be waited for") {
            Some(status) => break status,
            None if begin.elapsed() > PATIENCE => {
                child.kill().expect("the program can be killed");
                panic!("the program still runs after {PATIENCE:?}");
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let text = |reader: std::thread::JoinHandle<String>| reader.join().expect("what was said can be read");
    Run { status: status.code(), stdout: text(stdout), stderr: text(stderr) }
}

/// Reads a pipe to its end beside the program, so that a full pipe never holds it up.
fn reader(pipe: Option<impl std::io::Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            pipe.read_to_end(&mut bytes).expect("the pipe can be read");
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
