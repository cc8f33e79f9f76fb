// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures of films, read by a thread of its own: the shown frame first, then those that come next, up to a limit of memory.
//! Invariant: no lock is held while a file is read. Tests: `tests`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use gnurt::image::{ChannelData, Picture};

/// Reads a picture; the error is one line.
pub type ReadPicture = Box<dyn Fn(&Path) -> Result<Picture, String> + Send>;

/// A picture, or why there is none.
pub(crate) type Read = Result<Arc<Picture>, String>;

#[derive(Default)]
struct State {
    /// Files in the order in which they are needed.
    wanted: Vec<PathBuf>,
    read: HashMap<PathBuf, Read>,
    /// Files that have changed since they were wanted.
    stale: Vec<PathBuf>,
    is_over: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads files in the background.
pub(crate) struct Loader {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// Bytes of a picture in memory.
fn bytes(read: &Read) -> usize {
    let Ok(picture) = read else { return 0 };
    let channels = picture.layers.iter().flat_map(|layer| &layer.channels);
    let values = |data: &ChannelData| match data {
        ChannelData::F32(values) => values.len(),
        ChannelData::U32(values) => values.len(),
    };
    16 * picture.color.len() + channels.map(|channel| 4 * values(&channel.data)).sum::<usize>()
}

impl Loader {
    /// Begins a thread that keeps pictures of up to `most` bytes, and at least the first two wanted ones; `notify` is called after each file.
    ///
    /// # Errors
    /// The system's error.
    pub(crate) fn begin(
        read: ReadPicture,
        most: usize,
        notify: Box<dyn Fn() + Send>,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let inner = shared.clone();
        let work = move || {
            while let Some(path) = next(&inner, most) {
                let picture = read(&path).map(Arc::new);
                let mut state = inner.state();
                // A file that has changed meanwhile is read again.
                if !state.stale.contains(&path) {
                    state.read.insert(path, picture);
                }
                drop(state);
                notify();
            }
        };
        let thread = std::thread::Builder::new().name("pictures".into()).spawn(work)?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Hands in a picture that was read elsewhere.
    pub(crate) fn put(&self, path: PathBuf, picture: Picture) {
        self.shared.state().read.insert(path, Ok(Arc::new(picture)));
    }

    /// The files that are needed from now on, the most urgent first.
    pub(crate) fn want(&self, wanted: Vec<PathBuf>) {
        let mut state = self.shared.state();
        if state.wanted != wanted {
            state.wanted = wanted;
            self.shared.changed.notify_one();
        }
    }

    /// A picture, once it is read.
    pub(crate) fn get(&self, path: &Path) -> Option<Read> {
        self.shared.state().read.get(path).cloned()
    }

    /// Reads files again that have changed.
    pub(crate) fn forget(&self, changed: &[PathBuf]) {
        let mut state = self.shared.state();
        changed.iter().for_each(|path| _ = state.read.remove(path));
        state.stale = changed.to_vec();
        self.shared.changed.notify_one();
    }
}

/// Waits for the next file to read; `None` at the end.
fn next(shared: &Shared, most: usize) -> Option<PathBuf> {
    let mut state = shared.state();
    loop {
        if state.is_over {
            return None;
        }
        let State { wanted, read, .. } = &mut *state;
        read.retain(|path, _| wanted.contains(path));
        let mut held = 0;
        let missing = wanted.iter().enumerate().find_map(|(i, path)| match read.get(path) {
            Some(found) => {
                held += bytes(found);
                None
            }
            None => (i < 2 || held < most).then_some(path),
        });
        if let Some(path) = missing.cloned() {
            state.stale.retain(|stale| *stale != path);
            return Some(path);
        }
        state = shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.shared.state().is_over = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the reader was reported by its thread.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    use super::*;

    fn loader(most: usize) -> (Loader, Receiver<PathBuf>, Receiver<()>) {
        let (sender, asked) = channel();
        let (done, news) = channel();
        let read = move |path: &Path| {
            let _ = sender.send(path.to_owned());
            match path.to_str() {
                Some("bad") => Err("bad: broken".to_owned()),
                _ => Ok(Picture::new(10, 10)),
            }
        };
        let notify = move || _ = done.send(());
        (Loader::begin(Box::new(read), most, Box::new(notify)).expect("a thread"), asked, news)
    }

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    const PATIENCE: Duration = Duration::from_secs(20);

    #[test]
    fn urgent_files_first_and_no_more_than_fit() {
        let (loader, asked, news) = loader(3 * 1600);
        loader.want(paths(&["c", "bad", "d", "e", "f", "g"]));
        let order: Vec<PathBuf> = (0..4).map(|_| asked.recv_timeout(PATIENCE).expect("a file")).collect();
        assert_eq!(
            order,
            paths(&["c", "bad", "d", "e"]),
            "the fifth does not fit: the broken one takes none"
        );
        (0..4).for_each(|_| news.recv_timeout(PATIENCE).expect("news"));
        assert!(asked.recv_timeout(Duration::from_millis(50)).is_err());
        assert!(loader.get(Path::new("c")).is_some_and(|read| read.is_ok()));
        assert_eq!(loader.get(Path::new("bad")), Some(Err("bad: broken".into())));
        loader.want(paths(&["g", "h", "c"]));
        let order: Vec<PathBuf> = (0..2).map(|_| asked.recv_timeout(PATIENCE).expect("a file")).collect();
        assert_eq!(order, paths(&["g", "h"]), "the third is there still");
        (0..2).for_each(|_| news.recv_timeout(PATIENCE).expect("news"));
        assert_eq!(loader.get(Path::new("d")), None, "and this one no longer");
        loader.forget(&paths(&["g"]));
        assert_eq!(asked.recv_timeout(PATIENCE), Ok("g".into()), "it is read again");
    }
}
