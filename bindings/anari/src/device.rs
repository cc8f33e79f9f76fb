// SPDX-License-Identifier: GPL-3.0-or-later
//! A device: the objects that the program holds, by handle, and their parameters.
//! Handles are numbers, never addresses: one that was released or never given is found out and named in a message.
//! Tests: tests/{lifetimes,wrong}.rs.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};

use gnurt::JoinedPool;

use crate::ffi_array::Array;
use crate::ffi_status::{Code, Reporter, Severity};
use crate::object::{Object, Snapshot, Value, lock};
use crate::schema::{self, Values};
use crate::types::{self, DataType};

/// An object that the program holds.
struct Held {
    object: Arc<Object>,
    /// How often the program holds it.
    count: usize,
}

/// A device.
pub(crate) struct Device {
    /// Its handle, and the address of its table.
    pub(crate) handle: usize,
    pub(crate) reporter: Reporter,
    /// The listener that the library was loaded with: function and data.
    default_listener: [usize; 2],
    held: Mutex<HashMap<usize, Held>>,
    next: AtomicUsize,
    alive: Arc<AtomicUsize>,
    /// Its own parameters.
    pub(crate) own: Object,
    pool: OnceLock<Option<JoinedPool>>,
    /// Renderings under way.
    busy: Mutex<usize>,
    rest: Condvar,
}

/// Handles are multiples of this, as addresses are, from this on.
const STEP: usize = 16;

impl Device {
    /// A device without objects.
    pub(crate) fn new(handle: usize, reporter: Reporter, default_listener: [usize; 2]) -> Self {
        let own = Object::new(handle, types::DEVICE, "", Box::new(()), Arc::default());
        Self {
            handle,
            reporter,
            default_listener,
            held: Mutex::default(),
            next: AtomicUsize::new(STEP),
            alive: Arc::default(),
            own,
            pool: OnceLock::new(),
            busy: Mutex::default(),
            rest: Condvar::new(),
        }
    }

    /// Objects that live, held by the program or by others.
    pub(crate) fn alive(&self) -> usize {
        self.alive.load(Ordering::Relaxed)
    }

    /// A new object, held once by the program, and its handle.
    pub(crate) fn add(
        &self,
        kind: DataType,
        subtype: &str,
        payload: Box<dyn std::any::Any + Send + Sync>,
    ) -> usize {
        let known = schema::subtypes(kind);
        let mut subtype = subtype;
        if !known.is_empty() && !known.contains(&subtype) {
            let name = types::name(kind);
            if kind == types::RENDERER {
                // Programs that ask for a vendor's renderer want a picture.
                self.say(Severity::Warning, &format!("{name} '{subtype}': unknown, 'default' is used"));
                subtype = "default";
            } else {
                let list = known.join(", ");
                self.say(Severity::Error, &format!("{name} '{subtype}': unknown subtype; allowed: {list}"));
            }
        }
        let handle = self.next.fetch_add(STEP, Ordering::Relaxed);
        let object = Arc::new(Object::new(handle, kind, subtype, payload, self.alive.clone()));
        lock(&self.held).insert(handle, Held { object, count: 1 });
        handle
    }

    /// Counts a rendering that begins.
    pub(crate) fn begin_work(&self) {
        *lock(&self.busy) += 1;
    }

    /// Counts a rendering that ended.
    pub(crate) fn end_work(&self) {
        *lock(&self.busy) -= 1;
        self.rest.notify_all();
    }

    /// Waits until nothing renders.
    pub(crate) fn wait(&self) {
        let mut busy = lock(&self.busy);
        while *busy > 0 {
            busy = self.rest.wait(busy).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A message about the device.
    pub(crate) fn say(&self, severity: Severity, text: &str) {
        let code = if severity == Severity::Info { Code::None } else { Code::Argument };
        self.reporter.send(None, severity, code, text);
    }

    /// The object of a handle that the program holds; `None` and a message where it holds none.
    pub(crate) fn object(&self, handle: usize, call: &str) -> Option<Arc<Object>> {
        let found = self.find(handle);
        if found.is_none() {
            self.say(Severity::Error, &format!("{call}: object {handle:#x}: unknown, or released already"));
        }
        found
    }

    fn find(&self, handle: usize) -> Option<Arc<Object>> {
        lock(&self.held).get(&handle).map(|held| held.object.clone())
    }

    /// Holds an object once more.
    pub(crate) fn retain(&self, handle: usize) {
        let found = lock(&self.held).get_mut(&handle).map(|held| held.count += 1).is_some();
        if !found {
            self.object(handle, "retain");
        }
    }

    /// Holds an object once less; true where the program lets it go.
    pub(crate) fn release(&self, handle: usize) -> Option<Arc<Object>> {
        let mut held = lock(&self.held);
        let Some(entry) = held.get_mut(&handle) else {
            drop(held);
            self.object(handle, "release");
            return None;
        };
        entry.count -= 1;
        if entry.count > 0 {
            return None;
        }
        let gone = held.remove(&handle).map(|held| held.object);
        drop(held);
        if let Some(array) = gone.as_deref().and_then(Array::of)
            && gone.as_ref().is_some_and(|object| Arc::strong_count(object) > 1)
        {
            array.privatize();
        }
        gone
    }

    /// All objects that the program holds.
    pub(crate) fn all(&self) -> Vec<Arc<Object>> {
        lock(&self.held).values().map(|held| held.object.clone()).collect()
    }

    /// Lets all objects go.
    pub(crate) fn forget_all(&self) {
        let gone = std::mem::take(&mut *lock(&self.held));
        drop(gone);
    }

    /// Finds the objects of an array of objects.
    pub(crate) fn resolve(&self, object: &Object) {
        let Some(array) = Array::of(object) else { return };
        let unknown = array.resolve(|handle| self.find(handle));
        if unknown > 0 {
            let text = format!(
                "{unknown} elements: unknown or released objects, or of another type; they are left out"
            );
            self.reporter.send(Some(object), Severity::Error, Code::Argument, &text);
        }
    }

    /// The object of a parameter's value.
    pub(crate) fn value(&self, object: &Object, name: &str, handle: usize) -> Option<Value> {
        let found = self.find(handle).map(Value::Object);
        if found.is_none() {
            let text = format!("parameter '{name}': object {handle:#x}: unknown, or released already");
            self.reporter.send(Some(object), Severity::Error, Code::Argument, &text);
        }
        found
    }

    /// Sets a parameter for the next commit; one of a wrong type is named and left out.
    pub(crate) fn set(&self, object: &Object, name: &str, value: Value) {
        let entry = schema::find(object.kind, &object.subtype);
        let known = entry.and_then(|entry| entry.parameters.iter().find(|parameter| parameter.name == name));
        let Some(known) = known else {
            if is_unsupported(name) {
                return self.reporter.warn(object, &format!("parameter '{name}': unsupported, ignored"));
            }
            // Other devices may have it.
            let text = format!("parameter '{name}': unknown, ignored");
            return self.reporter.send(Some(object), Severity::Info, Code::None, &text);
        };
        let kind = value.kind();
        let fits = known.types.contains(&kind) || is_alike(kind, &known.types);
        if !fits {
            let allowed: Vec<String> = known.types.iter().map(|&kind| types::name(kind)).collect();
            let text = format!(
                "parameter '{name}': type {}: invalid; allowed: {}",
                types::name(kind),
                allowed.join(", ")
            );
            self.reporter.warn(object, &text);
            return;
        }
        if let (Values::Texts(words), Value::Text(text)) = (&known.values, &value)
            && !words.contains(&&**text)
        {
            let text = format!("parameter '{name}': '{text}': invalid; allowed: {}", words.join(", "));
            self.reporter.warn(object, &text);
        }
        if let Value::Object(array) = &value
            && let Some(array) = Array::of(array)
            && !known.elements.is_empty()
            && !known.elements.contains(&array.element)
        {
            let text =
                format!("parameter '{name}': elements of type {}: invalid", types::name(array.element));
            self.reporter.warn(object, &text);
        }
        object.stage(name, value);
    }

    /// Makes parameters count, and names those that are missing.
    pub(crate) fn commit(&self, object: &Object) {
        object.commit();
        let now = object.committed();
        if let Some(array) = Array::of(object) {
            array.set_region(region(&now));
        }
        let entry = schema::find(object.kind, &object.subtype);
        for parameter in
            entry.iter().flat_map(|entry| &entry.parameters).filter(|parameter| parameter.required)
        {
            if now.get(parameter.name).is_none() {
                self.reporter.warn(object, &format!("parameter '{}': missing", parameter.name));
            }
        }
    }

    /// Makes the device's own parameters count.
    pub(crate) fn commit_own(&self) {
        self.own.commit();
        let now = self.own.committed();
        let [function, user] = self.default_listener;
        let function = now.pointer("statusCallback").unwrap_or(function);
        let user = now.pointer("statusCallbackUserData").unwrap_or(user);
        self.reporter.listen(function, user);
    }

    /// The threads that render; `None` where the system refuses them.
    pub(crate) fn pool(&self) -> Option<&JoinedPool> {
        let make = || {
            let threads = self.own.committed().u32("threads").unwrap_or(0) as usize;
            match JoinedPool::new(threads) {
                Ok(pool) => Some(pool),
                Err(error) => {
                    self.reporter.send(None, Severity::Fatal, Code::Memory, &error.to_string());
                    None
                }
            }
        };
        self.pool.get_or_init(make).as_ref()
    }
}

/// Whether a parameter is one of ANARI's that the device has not: pictures would be others than the program means.
fn is_unsupported(name: &str) -> bool {
    const NAMES: [&str; 5] =
        ["stereoMode", "interpupillaryDistance", "rollingShutterDirection", "rollingShutterDuration", "time"];
    NAMES.contains(&name) || name.starts_with("motion.")
}

/// Types that programs use for each other.
fn is_alike(kind: DataType, allowed: &[DataType]) -> bool {
    let pairs = [
        (types::INT32, types::UINT32),
        (types::UINT32, types::INT32),
        (types::INT32, types::BOOL),
        (types::UINT32, types::BOOL),
        (types::UINT32, types::UINT64),
        (types::FLOAT64, types::FLOAT32),
        (types::FLOAT32_VEC4, types::FLOAT32_VEC3),
        (types::UINT8, types::BOOL),
    ];
    pairs.iter().any(|(given, wanted)| *given == kind && allowed.contains(wanted))
}

fn region(now: &Snapshot) -> Option<[u64; 2]> {
    match now.get("region")? {
        Value::Plain(types::UINT64_REGION1, bytes) => {
            let number = |k: usize| bytes.get(8 * k..8 * k + 8)?.try_into().ok().map(u64::from_ne_bytes);
            Some([number(0)?, number(1)?])
        }
        _ => None,
    }
}
