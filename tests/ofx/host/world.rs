//! Everything the host knows behind its handles, and the list of what the plugin did wrong.
//!
//! In: calls of the suites. Out: answers; each breach of the API is noted as a fault, and tests fail for it.

use super::api::Status;
use super::pixels::{Buffer, Depth, Pixels, Rows};
use super::profile::Profile;
use super::spec::Owner;
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};
use std::ffi::{CStr, CString, c_char};
use std::sync::{Mutex, PoisonError};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

/// The one host of the process: the plugin knows one host, too.
static WORLD: Mutex<Option<World>> = Mutex::new(None);

thread_local! {
    /// The action that runs on this thread.
    static ACTION: Cell<&'static str> = const { Cell::new("") };
}

/// A property's value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Int(i32),
    Double(f64),
    Text(CString),
    Pointer(usize),
}

/// A set of properties.
#[derive(Clone, Debug)]
pub(crate) struct PropSet {
    pub(crate) owner: Owner,
    /// What it belongs to, for messages.
    pub(crate) label: String,
    /// Type of the parameter it belongs to.
    pub(crate) param_kind: String,
    pub(crate) values: BTreeMap<CString, Vec<Value>>,
}

/// A descriptor or an instance.
#[derive(Clone, Debug)]
pub(crate) struct Effect {
    pub(crate) set: usize,
    pub(crate) param_set: usize,
    /// By name.
    pub(crate) clips: BTreeMap<CString, usize>,
    /// By name; `order` has them as they were defined.
    pub(crate) params: BTreeMap<CString, usize>,
    pub(crate) order: Vec<CString>,
}

/// What a clip of an instance shows.
#[derive(Clone, Debug)]
pub(crate) struct Feed {
    /// `None`: an output of these bounds, or a clip without an image at this time.
    pub(crate) pixels: Option<Pixels>,
    pub(crate) bounds: super::api::RectI,
    pub(crate) channels: usize,
    pub(crate) depth: Depth,
    pub(crate) rows: Rows,
    pub(crate) premultiplication: &'static CStr,
    pub(crate) scale: [f64; 2],
    pub(crate) aspect: f64,
}

impl Feed {
    /// The same in another depth.
    pub(crate) fn with_depth(self, depth: Depth) -> Self {
        Self { depth, ..self }
    }
}

/// A clip.
#[derive(Clone, Debug)]
pub(crate) struct Clip {
    pub(crate) set: usize,
    pub(crate) name: CString,
    pub(crate) feed: Option<Feed>,
}

/// A value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Held {
    Nothing,
    Int(i32),
    Double(f64),
    Point([f64; 2]),
    Text(CString),
}

/// A parameter.
#[derive(Clone, Debug)]
pub(crate) struct Param {
    pub(crate) set: usize,
    pub(crate) effect: usize,
    pub(crate) name: CString,
    pub(crate) kind: String,
    pub(crate) value: Held,
    /// By time.
    pub(crate) keys: Vec<(f64, Held)>,
}

/// An image that the plugin holds.
#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) clip: usize,
    pub(crate) buffer: Buffer,
    /// The action that fetched it.
    pub(crate) action: &'static str,
}

/// What a plugin said.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Said {
    pub(crate) kind: String,
    pub(crate) text: String,
    pub(crate) lasts: bool,
}

/// Something that was drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawn {
    /// Kind of figure, -1 for text.
    pub(crate) figure: i32,
    pub(crate) colour: [f32; 4],
    pub(crate) width: f32,
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) text: String,
}

/// A change that is undone in one step: its label, the parameters in it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Undo {
    pub(crate) label: String,
    pub(crate) params: Vec<String>,
}

/// The host.
pub(crate) struct World {
    pub(crate) profile: Profile,
    pub(crate) host_set: usize,
    next: usize,
    pub(crate) sets: BTreeMap<usize, PropSet>,
    pub(crate) effects: BTreeMap<usize, Effect>,
    pub(crate) clips: BTreeMap<usize, Clip>,
    pub(crate) params: BTreeMap<usize, Param>,
    /// Effects by the handle of their parameters.
    pub(crate) param_sets: BTreeMap<usize, usize>,
    /// Images by the handle of their properties.
    pub(crate) images: BTreeMap<usize, Image>,
    /// Overlays: their sets, by handle.
    pub(crate) interacts: BTreeMap<usize, usize>,
    /// What outputs hold after they were given back, latest last.
    pub(crate) rendered: Vec<(usize, Pixels)>,
    gone: BTreeMap<usize, &'static str>,
    pub(crate) faults: Vec<String>,
    pub(crate) said: Vec<Said>,
    /// The same, with what was taken back.
    pub(crate) heard: Vec<Said>,
    pub(crate) drawn: Vec<Drawn>,
    pub(crate) pencil: Drawn,
    pub(crate) undo: Vec<Undo>,
    pub(crate) open_edits: usize,
    pub(crate) redraws: usize,
    pub(crate) aborts_asked: u32,
    /// The host gives up from this question on.
    pub(crate) abort_at: Option<u32>,
    /// Parameters the plugin changed, of which it has to be told.
    pub(crate) changed: Vec<(usize, CString)>,
    pub(crate) images_given: usize,
    /// Time in the host's own functions.
    pub(crate) spent: Duration,
    lent: HashMap<ThreadId, Vec<u8>>,
}

impl World {
    /// A host before any plugin.
    pub(crate) fn new(profile: Profile) -> Self {
        let nothing = Drawn { figure: 0, colour: [0.0; 4], width: 1.0, points: Vec::new(), text: String::new() };
        Self {
            profile,
            host_set: 0,
            next: 0,
            sets: BTreeMap::new(),
            effects: BTreeMap::new(),
            clips: BTreeMap::new(),
            params: BTreeMap::new(),
            param_sets: BTreeMap::new(),
            images: BTreeMap::new(),
            interacts: BTreeMap::new(),
            rendered: Vec::new(),
            gone: BTreeMap::new(),
            faults: Vec::new(),
            said: Vec::new(),
            heard: Vec::new(),
            drawn: Vec::new(),
            pencil: nothing,
            undo: Vec::new(),
            open_edits: 0,
            redraws: 0,
            aborts_asked: 0,
            abort_at: None,
            changed: Vec::new(),
            images_given: 0,
            spent: Duration::ZERO,
            lent: HashMap::new(),
        }
    }

    /// A handle that was never used and points nowhere.
    pub(crate) fn handle(&mut self) -> usize {
        self.next += 1;
        0x1000 + 16 * self.next
    }

    /// A new set of properties.
    pub(crate) fn set(&mut self, owner: Owner, label: &str) -> usize {
        let handle = self.handle();
        let set = PropSet { owner, label: label.to_owned(), param_kind: String::new(), values: BTreeMap::new() };
        self.sets.insert(handle, set);
        handle
    }

    /// Sets a property from the host's side.
    pub(crate) fn put(&mut self, set: usize, name: &CStr, values: Vec<Value>) {
        self.sets.get_mut(&set).expect("a set of the host").values.insert(name.to_owned(), values);
    }

    /// The ints of a property, from the host's side.
    pub(crate) fn ints(&self, set: usize, name: &CStr) -> Vec<i32> {
        self.values(set, name)
            .iter()
            .filter_map(|value| if let Value::Int(int) = value { Some(*int) } else { None })
            .collect()
    }

    /// The doubles of a property.
    pub(crate) fn doubles(&self, set: usize, name: &CStr) -> Vec<f64> {
        let double = |value: &Value| if let Value::Double(double) = value { Some(*double) } else { None };
        self.values(set, name).iter().filter_map(double).collect()
    }

    /// The texts of a property.
    pub(crate) fn texts(&self, set: usize, name: &CStr) -> Vec<String> {
        let text =
            |value: &Value| if let Value::Text(text) = value { Some(text.to_string_lossy().into()) } else { None };
        self.values(set, name).iter().filter_map(text).collect()
    }

    fn values(&self, set: usize, name: &CStr) -> &[Value] {
        self.sets.get(&set).and_then(|set| set.values.get(name)).map_or(&[], Vec::as_slice)
    }

    /// Notes a breach of the API.
    pub(crate) fn fault(&mut self, what: impl AsRef<str>) -> Status {
        let action = ACTION.get();
        self.faults.push(format!("in {action}: {}", what.as_ref()));
        Status::ERR_VALUE
    }

    /// Notes that a handle is none.
    pub(crate) fn bad_handle(&mut self, handle: usize, wanted: &str) -> Status {
        let why = match self.gone.get(&handle) {
            Some(kind) => format!("a {kind} was used after its end, as {wanted}"),
            None if handle == 0 => format!("null was used as {wanted}"),
            None => format!("{handle:#x} was used as {wanted}, and is none"),
        };
        self.fault(why);
        Status::ERR_BAD_HANDLE
    }

    /// Notes the end of a handle.
    pub(crate) fn end(&mut self, handle: usize, kind: &'static str) {
        self.gone.insert(handle, kind);
        // The host's own memory must not grow either; handles count up.
        if self.gone.len() > 20_000 {
            self.gone.pop_first();
        }
    }

    /// Ends a set of properties.
    pub(crate) fn end_set(&mut self, set: usize, kind: &'static str) {
        self.sets.remove(&set);
        self.end(set, kind);
    }

    /// Lends a text until the thread's next call: then it is overwritten, though not freed.
    pub(crate) fn lend(&mut self, text: &CStr) -> *mut c_char {
        let bytes = self.lent.entry(std::thread::current().id()).or_default();
        *bytes = text.to_bytes_with_nul().to_vec();
        bytes.as_mut_ptr().cast()
    }

    fn take_back_what_was_lent(&mut self) {
        if let Some(bytes) = self.lent.get_mut(&std::thread::current().id()) {
            let length = bytes.len().saturating_sub(1);
            bytes[..length].fill(b'?');
        }
    }
}

/// Answers a call of a suite.
pub(crate) fn with<R>(work: impl FnOnce(&mut World) -> R) -> R {
    let begun = Instant::now();
    let mut world = WORLD.lock().unwrap_or_else(PoisonError::into_inner);
    let world = world.as_mut().expect("a host is there while its plugin is loaded");
    world.take_back_what_was_lent();
    let result = work(world);
    world.spent += begun.elapsed();
    result
}

/// Begins (or, with `None`, ends) a host.
pub(crate) fn replace(world: Option<World>) -> Option<World> {
    std::mem::replace(&mut *WORLD.lock().unwrap_or_else(PoisonError::into_inner), world)
}

/// Runs `work` as an action of that name on this thread.
pub(crate) fn acting<R>(action: &'static str, work: impl FnOnce() -> R) -> R {
    let before = ACTION.replace(action);
    let result = work();
    ACTION.set(before);
    result
}

/// The action that runs on this thread.
pub(crate) fn current_action() -> &'static str {
    ACTION.get()
}
