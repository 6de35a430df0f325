//! Descriptors and instances with their clips and parameters: how hosts make and end them.
//!
//! In: what was described. Out: handles, and values that tests set.

use super::api::names::{image, param, prop};
use super::api::{RectI, Status};
use super::pixels::{Depth, Pixels, Rows};
use super::session::{Node, doubles, ints, text};
use super::spec::Owner;
use super::world::{Clip, Effect, Feed, Held, Value, World, with};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};

/// A value that a test sets.
pub(crate) struct Set(pub(super) Held);

impl From<i32> for Set {
    fn from(value: i32) -> Self {
        Self(Held::Int(value))
    }
}
impl From<f64> for Set {
    fn from(value: f64) -> Self {
        Self(Held::Double(value))
    }
}
impl From<[f64; 2]> for Set {
    fn from(value: [f64; 2]) -> Self {
        Self(Held::Point(value))
    }
}
impl From<&str> for Set {
    fn from(value: &str) -> Self {
        Self(Held::Text(CString::new(value).expect("no zero in it")))
    }
}

/// A feed of floats at full size, premultiplied.
pub(crate) fn feed(pixels: Option<Pixels>, bounds: RectI, channels: usize) -> Feed {
    Feed {
        pixels,
        bounds,
        channels,
        depth: Depth::Float,
        rows: Rows::Up,
        premultiplication: if channels == 3 { image::OPAQUE } else { image::PREMULTIPLIED },
        scale: [1.0, 1.0],
        aspect: 1.0,
    }
}

pub(super) fn four(status: Status, answers: &BTreeMap<CString, Vec<Value>>, name: &CStr) -> Option<[f64; 4]> {
    let values = answers.get(name).filter(|_| status == Status::OK)?;
    let numbers: Vec<f64> =
        values.iter().map(|value| if let Value::Double(n) = value { *n } else { f64::NAN }).collect();
    numbers.try_into().ok()
}

pub(super) fn param_of(world: &World, node: Node, id: &str) -> usize {
    let id = CString::new(id).expect("no zero in it");
    *world.effects[&node.0].params.get(&id).unwrap_or_else(|| panic!("no parameter {id:?}"))
}

pub(super) fn describe_host(world: &mut World, host: usize) {
    let profile = world.profile.clone();
    world.put(host, prop::TYPE, text(prop::TYPE_IMAGE_EFFECT_HOST));
    world.put(host, prop::NAME, text(&CString::new(profile.name).expect("no zero in it")));
    world.put(host, image::SUPPORTED_CONTEXTS, text(profile.context));
    world.put(host, image::SUPPORTS_OVERLAYS, ints(&[profile.overlays]));
    for ability in [param::HOST_CHOICE_ANIMATION, param::HOST_BOOLEAN_ANIMATION] {
        world.put(host, ability, ints(&[1]));
    }
    if let Some(version) = profile.api {
        world.put(host, prop::API_VERSION, ints(&version));
    }
}

pub(super) fn new_effect(owner: Owner, label: &str) -> usize {
    with(|world| {
        let set = world.set(owner, label);
        let param_set = world.handle();
        let handle = world.handle();
        let made = Effect { set, param_set, clips: BTreeMap::new(), params: BTreeMap::new(), order: Vec::new() };
        world.effects.insert(handle, made);
        world.param_sets.insert(param_set, handle);
        handle
    })
}

/// Copies clips and parameters of a descriptor to a new instance.
pub(super) fn instance_of(descriptor: usize, context: &CStr) -> usize {
    let instance = new_effect(Owner::Instance, "instance");
    with(|world| {
        let described = world.effects[&descriptor].clone();
        let set = world.effects[&instance].set;
        world.put(set, image::CONTEXT, text(context));
        world.put(set, prop::TYPE, text(prop::TYPE_IMAGE_EFFECT_INSTANCE));
        world.put(set, image::PROJECT_OFFSET, doubles(&[0.0, 0.0]));
        for (name, clip) in &described.clips {
            let from = world.sets[&world.clips[clip].set].clone();
            let set = world.set(Owner::Clip, &name.to_string_lossy());
            world.sets.get_mut(&set).expect("made above").values = from.values;
            world.put(set, image::CLIP_CONNECTED, ints(&[0]));
            let handle = world.handle();
            world.clips.insert(handle, Clip { set, name: name.clone(), feed: None });
            world.effects.get_mut(&instance).expect("made above").clips.insert(name.clone(), handle);
        }
        for name in &described.order {
            let mut copy = world.params[&described.params[name]].clone();
            let from = world.sets[&copy.set].clone();
            copy.value = default_of(world, copy.set, &copy.kind);
            copy.set = world.set(Owner::Param, &name.to_string_lossy());
            world.sets.get_mut(&copy.set).expect("made above").values = from.values;
            world.sets.get_mut(&copy.set).expect("made above").param_kind = from.param_kind;
            copy.effect = instance;
            let handle = world.handle();
            world.params.insert(handle, copy);
            let effect = world.effects.get_mut(&instance).expect("made above");
            effect.params.insert(name.clone(), handle);
            effect.order.push(name.clone());
        }
    });
    instance
}

fn default_of(world: &World, set: usize, kind: &str) -> Held {
    let whole = world.ints(set, param::DEFAULT).first().copied().unwrap_or(0);
    let numbers = world.doubles(set, param::DEFAULT);
    match kind.as_bytes() {
        kind if kind == param::TYPE_DOUBLE.to_bytes() => Held::Double(numbers.first().copied().unwrap_or(0.0)),
        kind if kind == param::TYPE_DOUBLE_2D.to_bytes() => Held::Point(numbers.try_into().unwrap_or_default()),
        kind if kind == param::TYPE_STRING.to_bytes() => {
            let text = world.texts(set, param::DEFAULT).first().cloned().unwrap_or_default();
            Held::Text(CString::new(text).expect("it was C"))
        }
        kind if [param::TYPE_GROUP, param::TYPE_PAGE, param::TYPE_PUSH_BUTTON]
            .iter()
            .any(|of| of.to_bytes() == kind) =>
        {
            Held::Nothing
        }
        _ => Held::Int(whole),
    }
}

pub(super) fn end_effect(effect: usize) {
    with(|world| {
        let Some(ended) = world.effects.remove(&effect) else { return };
        for clip in ended.clips.values() {
            let set = world.clips.remove(clip).expect("clips end with their effect").set;
            world.end_set(set, "set of a clip");
            world.end(*clip, "clip");
        }
        for param in ended.params.values() {
            let set = world.params.remove(param).expect("parameters end with their effect").set;
            world.end_set(set, "set of a parameter");
            world.end(*param, "parameter");
        }
        world.end_set(ended.set, "set of an effect");
        world.param_sets.remove(&ended.param_set);
        world.end(ended.param_set, "parameters");
        world.end(effect, "effect");
    });
}
