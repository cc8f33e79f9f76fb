// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects of the program: a kind, a subtype, and parameters that count from the commit on.
//! A parameter is staged when it is set; a commit makes a snapshot of all staged ones, and renderings read snapshots alone. Objects
//! die when neither the program nor a parameter, an array or a rendering holds them.
//! Tests: tests/lifetimes.rs.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::types::{self, DataType};

/// The value of a parameter.
#[derive(Clone)]
pub(crate) enum Value {
    /// Numbers, pointers and functions, as their bytes.
    Plain(DataType, Box<[u8]>),
    /// A string.
    Text(Arc<str>),
    /// Another object.
    Object(Arc<Object>),
}

impl Value {
    /// Its type.
    pub(crate) fn kind(&self) -> DataType {
        match self {
            Self::Plain(kind, _) => *kind,
            Self::Text(_) => types::STRING,
            Self::Object(object) => object.kind,
        }
    }
}

/// Parameters by name.
pub(crate) type Parameters = BTreeMap<String, Value>;

/// Parameters as they were committed.
#[derive(Clone, Default)]
pub(crate) struct Snapshot {
    /// Rises with each commit of any object; 0 = none yet.
    pub(crate) stamp: u64,
    parameters: Parameters,
}

impl Snapshot {
    /// The value of this name.
    pub(crate) fn get(&self, name: &str) -> Option<&Value> {
        self.parameters.get(name)
    }

    /// All values.
    pub(crate) fn values(&self) -> impl Iterator<Item = &Value> {
        self.parameters.values()
    }

    /// The bytes of a value of one of these types.
    fn plain(&self, name: &str, kinds: &[DataType]) -> Option<(DataType, &[u8])> {
        match self.get(name)? {
            Value::Plain(kind, bytes) if kinds.contains(kind) => Some((*kind, bytes)),
            _ => None,
        }
    }

    /// A number.
    pub(crate) fn f32(&self, name: &str) -> Option<f32> {
        let (kind, bytes) =
            self.plain(name, &[types::FLOAT32, types::FLOAT64, types::INT32, types::UINT32])?;
        types::decode(kind, bytes).map(|value| value[0])
    }

    /// Floats, in the order of memory: boxes and matrices too.
    pub(crate) fn floats<const N: usize>(&self, name: &str, kinds: &[DataType]) -> Option<[f32; N]> {
        let (_, bytes) = self.plain(name, kinds)?;
        let mut floats = [0.0; N];
        for (float, bytes) in floats.iter_mut().zip(bytes.chunks_exact(4)) {
            *float = f32::from_ne_bytes(bytes.try_into().ok()?);
        }
        (bytes.len() >= 4 * N).then_some(floats)
    }

    /// Three floats.
    pub(crate) fn vec3(&self, name: &str) -> Option<[f32; 3]> {
        self.floats(name, &[types::FLOAT32_VEC3, types::FLOAT32_VEC4])
    }

    /// Any numeric value, as four floats.
    pub(crate) fn color(&self, name: &str) -> Option<[f32; 4]> {
        match self.get(name)? {
            Value::Plain(kind, bytes) => types::decode(*kind, bytes),
            _ => None,
        }
    }

    /// A 4 x 4 matrix by columns.
    pub(crate) fn mat4(&self, name: &str) -> Option<[f32; 16]> {
        self.floats(name, &[types::FLOAT32_MAT4])
    }

    /// A whole number.
    pub(crate) fn u32(&self, name: &str) -> Option<u32> {
        let (_, bytes) = self.plain(name, &[types::UINT32, types::INT32, types::DATA_TYPE])?;
        Some(u32::from_ne_bytes(bytes.try_into().ok()?))
    }

    /// A large whole number.
    pub(crate) fn u64(&self, name: &str) -> Option<u64> {
        match self.plain(name, &[types::UINT64, types::UINT32])? {
            (types::UINT64, bytes) => Some(u64::from_ne_bytes(bytes.try_into().ok()?)),
            (_, bytes) => Some(u64::from(u32::from_ne_bytes(bytes.try_into().ok()?))),
        }
    }

    /// Two whole numbers.
    pub(crate) fn size(&self, name: &str) -> Option<[u32; 2]> {
        let (_, bytes) = self.plain(name, &[types::UINT32_VEC2])?;
        let number = |k: usize| bytes.get(4 * k..4 * k + 4)?.try_into().ok().map(u32::from_ne_bytes);
        Some([number(0)?, number(1)?])
    }

    /// A truth.
    pub(crate) fn bool(&self, name: &str) -> Option<bool> {
        let (_, bytes) = self.plain(name, &[types::BOOL, types::INT32, types::UINT32, types::UINT8])?;
        Some(bytes.iter().any(|&byte| byte != 0))
    }

    /// A pointer or a function, as a number.
    pub(crate) fn pointer(&self, name: &str) -> Option<usize> {
        let kinds = [types::VOID_POINTER, types::STATUS_CALLBACK, types::FRAME_COMPLETION_CALLBACK];
        let (_, bytes) = self.plain(name, &kinds)?;
        Some(usize::from_ne_bytes(bytes.try_into().ok()?))
    }

    /// A string.
    pub(crate) fn text(&self, name: &str) -> Option<&str> {
        match self.get(name)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// An object of this kind.
    pub(crate) fn object(&self, name: &str, kind: DataType) -> Option<&Arc<Object>> {
        match self.get(name)? {
            Value::Object(object) if object.kind == kind => Some(object),
            _ => None,
        }
    }
}

/// Something made of an object, after the stamp of its source.
type Derived = Option<(u64, Arc<dyn Any + Send + Sync>)>;

/// An object of the program.
pub(crate) struct Object {
    /// As the program knows it: never 0.
    pub(crate) handle: usize,
    /// ANARI_GEOMETRY and the like.
    pub(crate) kind: DataType,
    /// The subtype, or nothing.
    pub(crate) subtype: String,
    staged: Mutex<Parameters>,
    committed: Mutex<Arc<Snapshot>>,
    /// An array's memory, a frame's rendering.
    pub(crate) payload: Box<dyn Any + Send + Sync>,
    derived: Mutex<Derived>,
    alive: Arc<AtomicUsize>,
}

/// The next stamp of all.
static STAMP: AtomicU64 = AtomicU64::new(1);

/// A number greater than all before.
pub(crate) fn next_stamp() -> u64 {
    STAMP.fetch_add(1, Ordering::Relaxed)
}

/// Locks a value; only for values that a panic cannot leave in disorder.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Object {
    /// An object without parameters; `alive` counts it as long as it lives.
    pub(crate) fn new(
        handle: usize,
        kind: DataType,
        subtype: &str,
        payload: Box<dyn Any + Send + Sync>,
        alive: Arc<AtomicUsize>,
    ) -> Self {
        alive.fetch_add(1, Ordering::Relaxed);
        let (staged, committed, derived) = Default::default();
        Self { handle, kind, subtype: subtype.to_owned(), staged, committed, payload, derived, alive }
    }

    /// Sets a parameter for the next commit.
    pub(crate) fn stage(&self, name: &str, value: Value) {
        // The old value may die: not under the lock.
        let old = lock(&self.staged).insert(name.to_owned(), value);
        drop(old);
    }

    /// Takes a parameter away, or all.
    pub(crate) fn unstage(&self, name: Option<&str>) {
        let mut staged = lock(&self.staged);
        let old = match name {
            Some(name) => staged.remove_entry(name).into_iter().collect(),
            None => std::mem::take(&mut *staged),
        };
        drop(staged);
        drop(old);
    }

    /// A parameter that was set, committed or not.
    pub(crate) fn staged(&self, name: &str) -> Option<Value> {
        lock(&self.staged).get(name).cloned()
    }

    /// Makes the set parameters count.
    pub(crate) fn commit(&self) {
        let parameters = lock(&self.staged).clone();
        let snapshot = Arc::new(Snapshot { stamp: next_stamp(), parameters });
        let old = std::mem::replace(&mut *lock(&self.committed), snapshot);
        drop(old);
    }

    /// The parameters that count.
    pub(crate) fn committed(&self) -> Arc<Snapshot> {
        lock(&self.committed).clone()
    }

    /// The result of `make`, which is called again only if `stamp` differs from the last one.
    pub(crate) fn derived<T: Send + Sync + 'static>(&self, stamp: u64, make: impl FnOnce() -> T) -> Arc<T> {
        let known = lock(&self.derived).clone();
        if let Some((_, value)) = known.filter(|(of, _)| *of == stamp)
            && let Ok(value) = value.downcast()
        {
            return value;
        }
        let value = Arc::new(make());
        *lock(&self.derived) = Some((stamp, value.clone()));
        value
    }

    /// For messages: kind and subtype, and its name if it has one.
    pub(crate) fn label(&self) -> String {
        let kind = types::name(self.kind).trim_start_matches("ANARI_").to_lowercase();
        let subtype = if self.subtype.is_empty() { String::new() } else { format!(" '{}'", self.subtype) };
        let name = match self.staged("name") {
            Some(Value::Text(name)) => format!(" \"{name}\""),
            _ => String::new(),
        };
        format!("{kind}{subtype}{name}")
    }
}

impl Drop for Object {
    fn drop(&mut self) {
        self.alive.fetch_sub(1, Ordering::Relaxed);
    }
}
