//! What tests say: start a host, make nodes, feed them, set them, ask and render.
//!
//! In: calls. Out: answers. A host ends by destroying what is left, unloading, and failing for every fault it noted.

use super::api::names::{action, image, interact, param, prop};
use super::api::{EntryPoint, Host as HostStruct, Plugin, PropertySet, RectI, Status};
use super::effects::{components_name, depth_name, seen};
use super::extras::fetch_suite;
use super::making::{Set, describe_host, end_effect, four, instance_of, new_effect, param_of};
use super::params::{put, value_at};
use super::pen::Overlay;
use super::pixels::Pixels;
use super::profile::Profile;
use super::spec::Owner;
use super::world::{Feed, Held, Said, Undo, Value, World, acting, replace, with};
use pinwarp::ofx::set_host;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Tests take turns: a plugin knows one host.
static TURN: Mutex<()> = Mutex::new(());

/// The entry of the plugin in use, for changes that are echoed.
static ENTRY: Mutex<Option<EntryPoint>> = Mutex::new(None);

/// One of the two plugins of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Which {
    PinWarp,
    StMap,
}

/// A host with one plugin loaded and described.
pub(crate) struct Host {
    entry: EntryPoint,
    /// The plugin keeps its address.
    _told: Box<HostStruct>,
    /// Its descriptor, described in the profile's context.
    pub(crate) descriptor: usize,
    context: &'static CStr,
    nodes: Vec<Node>,
    _turn: MutexGuard<'static, ()>,
}

/// An instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Node(pub(crate) usize);

/// A frame to render, or to ask about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) time: f64,
    /// What the host announces; images have their own.
    pub(crate) scale: [f64; 2],
    /// `None`: all of the output.
    pub(crate) window: Option<RectI>,
    pub(crate) field: &'static CStr,
}

impl Default for Frame {
    fn default() -> Self {
        Self { time: 0.0, scale: [1.0, 1.0], window: None, field: image::FIELD_NONE }
    }
}

pub(super) fn text(value: &CStr) -> Vec<Value> {
    vec![Value::Text(value.to_owned())]
}

pub(super) fn doubles(values: &[f64]) -> Vec<Value> {
    values.iter().copied().map(Value::Double).collect()
}

pub(super) fn ints(values: &[i32]) -> Vec<Value> {
    values.iter().copied().map(Value::Int).collect()
}

fn rect(RectI { x1, y1, x2, y2 }: RectI) -> Vec<Value> {
    ints(&[x1, y1, x2, y2])
}

/// Calls an entry with sets that are destroyed afterwards; the status and the answers.
pub(super) fn call(
    entry: EntryPoint,
    (name, short): (&CStr, &'static str),
    handle: usize,
    args: Vec<(&CStr, Vec<Value>)>,
) -> (Status, BTreeMap<CString, Vec<Value>>) {
    let [given, out] = with(|world| {
        let sets = [Owner::Arguments, Owner::Answers].map(|owner| world.set(owner, short));
        args.into_iter().for_each(|(name, values)| world.put(sets[0], name, values));
        sets
    });
    let sets = [given, out].map(|set| PropertySet(seen(set)));
    // SAFETY: the plugin's own entry, with a name that outlives the call and handles of this host.
    let status = acting(short, || unsafe { entry(name.as_ptr(), seen(handle), sets[0], sets[1]) });
    let answers = with(|world| {
        let kept: Vec<usize> =
            world.images.iter().filter(|(_, image)| image.action == short).map(|(set, _)| *set).collect();
        if !kept.is_empty() && short != "Render" {
            world.fault(format!("{short} left {} images unreleased", kept.len()));
        }
        let answers = std::mem::take(&mut world.sets.get_mut(&out).expect("made above").values);
        world.end_set(given, "set of arguments");
        world.end_set(out, "set of answers");
        answers
    });
    (status, answers)
}

/// Tells the plugin of what it changed itself, as hosts do, at once.
pub(crate) fn tell_changes() {
    let changed = with(|world| if world.profile.echoes { std::mem::take(&mut world.changed) } else { Vec::new() });
    let Some(entry) = *ENTRY.lock().unwrap_or_else(PoisonError::into_inner) else { return };
    for (effect, name) in changed {
        changed_by(entry, effect, &name, prop::CHANGE_PLUGIN_EDITED, 0.0);
    }
}

fn changed_by(entry: EntryPoint, effect: usize, name: &CStr, why: &'static CStr, time: f64) -> Status {
    let args = vec![
        (prop::TYPE, text(prop::TYPE_PARAMETER)),
        (prop::NAME, text(name)),
        (prop::CHANGE_REASON, text(why)),
        (prop::TIME, doubles(&[time])),
        (image::RENDER_SCALE, doubles(&[1.0, 1.0])),
    ];
    call(entry, (action::INSTANCE_CHANGED, "InstanceChanged"), effect, args).0
}

/// The structure of the nth plugin.
pub(crate) fn declared(nth: i32) -> Plugin {
    // SAFETY: a constant of the library with the layout that both sides declare.
    unsafe { pinwarp::ofx::plugin(nth).cast::<Plugin>().read() }
}

impl Host {
    /// Loads and describes a plugin in the profile's context.
    pub(crate) fn start(profile: &Profile, which: Which) -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let mut world = World::new(profile.clone());
        world.host_set = world.set(Owner::Host, "the host");
        let host = world.host_set;
        describe_host(&mut world, host);
        replace(Some(world));
        let told = Box::new(HostStruct { properties: PropertySet(seen(host)), fetch_suite: Some(fetch_suite) });
        if profile.sets_host {
            // SAFETY: the structure lives as long as the plugin is loaded.
            let status = unsafe { set_host((&raw const *told).cast()) };
            assert_eq!(status.0, Status::OK.0, "OfxSetHost");
        }
        let plugin = declared(which as i32);
        // SAFETY: the plugin's own function; the structure lives as long as the plugin is loaded.
        unsafe { plugin.set_host.expect("plugins take hosts")(&raw const *told) };
        let entry = plugin.main_entry.expect("plugins take actions");
        *ENTRY.lock().unwrap_or_else(PoisonError::into_inner) = Some(entry);
        let mut host =
            Self { entry, _told: told, descriptor: 0, context: profile.context, nodes: Vec::new(), _turn: turn };
        host.load();
        host
    }

    /// Load, describe, describe in context: all must be answered with OK.
    fn load(&mut self) {
        let load = PropertySet::NULL;
        // SAFETY: the plugin's own entry; loading has no handle and no arguments.
        let status = acting("Load", || unsafe { (self.entry)(action::LOAD.as_ptr(), std::ptr::null(), load, load) });
        assert_eq!(status, Status::OK, "MLT takes any other answer to Load for a failure");
        self.descriptor = new_effect(Owner::Descriptor, "descriptor");
        assert_eq!(self.ask((action::DESCRIBE, "Describe"), self.descriptor, Vec::new()).0, Status::OK);
        let args = vec![(image::CONTEXT, text(self.context))];
        let (status, _) = self.ask((action::DESCRIBE_IN_CONTEXT, "DescribeInContext"), self.descriptor, args);
        assert_eq!(status, Status::OK);
    }

    /// Loads and describes once more, as MLT does for every frame.
    pub(crate) fn load_again(&mut self) {
        end_effect(self.descriptor);
        self.load();
    }

    /// Calls any action.
    pub(crate) fn ask(
        &self,
        action: (&CStr, &'static str),
        effect: usize,
        args: Vec<(&CStr, Vec<Value>)>,
    ) -> (Status, BTreeMap<CString, Vec<Value>>) {
        call(self.entry, action, effect, args)
    }

    /// An instance with all parameters at their defaults.
    pub(crate) fn node(&mut self) -> Node {
        let node = Node(instance_of(self.descriptor, self.context));
        assert_eq!(self.ask((action::CREATE_INSTANCE, "CreateInstance"), node.0, Vec::new()).0, Status::OK);
        self.nodes.push(node);
        node
    }

    /// Ends an instance.
    pub(crate) fn destroy(&mut self, node: Node) {
        let (status, _) = self.ask((action::DESTROY_INSTANCE, "DestroyInstance"), node.0, Vec::new());
        assert!([Status::OK, Status::REPLY_DEFAULT].contains(&status), "{status:?}");
        self.break_off(node);
    }

    /// Connects a clip to a picture (`None`: to nothing at this time), as floats and premultiplied.
    pub(crate) fn feed(&self, node: Node, clip: &CStr, pixels: Option<&Pixels>) {
        let bounds = pixels.map_or_else(RectI::default, |pixels| pixels.bounds);
        self.feed_as(
            node,
            clip,
            super::making::feed(pixels.cloned(), bounds, pixels.map_or(4, |pixels| pixels.channels)),
        );
    }

    /// Connects a clip to a picture of any form.
    pub(crate) fn feed_as(&self, node: Node, clip: &CStr, mut feed: Feed) {
        with(|world| {
            feed.rows = world.profile.rows;
            let handle = world.effects[&node.0].clips[clip];
            let set = world.clips[&handle].set;
            for (name, values) in [
                (image::CLIP_CONNECTED, ints(&[1])),
                (image::PIXEL_DEPTH, text(depth_name(feed.depth))),
                (image::COMPONENTS, text(components_name(feed.channels))),
                (image::PREMULTIPLICATION, text(feed.premultiplication)),
                (image::PIXEL_ASPECT, doubles(&[feed.aspect])),
                (image::FRAME_RANGE, doubles(&[0.0, 2.0])),
            ] {
                world.put(set, name, values);
            }
            if clip == image::SOURCE_CLIP {
                let RectI { x1, y1, x2, y2 } = feed.bounds;
                let [width, height] =
                    [f64::from(x2 - x1) * feed.aspect / feed.scale[0], f64::from(y2 - y1) / feed.scale[1]];
                let set = world.effects[&node.0].set;
                world.put(set, image::PROJECT_SIZE, doubles(&[width, height]));
                world.put(set, image::PROJECT_EXTENT, doubles(&[width, height]));
                world.put(set, image::PROJECT_PIXEL_ASPECT, doubles(&[feed.aspect]));
            }
            world.clips.get_mut(&handle).expect("looked up above").feed = Some(feed);
        });
    }

    /// Gives the project a size of its own, canonical.
    pub(crate) fn project(&self, node: Node, size: [f64; 2]) {
        with(|world| {
            let set = world.effects[&node.0].set;
            for name in [image::PROJECT_SIZE, image::PROJECT_EXTENT] {
                world.put(set, name, doubles(&size));
            }
        });
    }

    /// Leaves a part of a clip's picture in memory; where the clip has pixels stays what it was.
    pub(crate) fn crop(&self, node: Node, clip: &CStr, part: RectI) {
        with(|world| {
            let handle = world.effects[&node.0].clips[clip];
            let feed = world.clips.get_mut(&handle).and_then(|clip| clip.feed.as_mut()).expect("it is fed");
            let pixels = feed.pixels.as_ref().expect("it has a picture");
            feed.pixels = Some(Pixels::new(part, pixels.channels, |x, y, channel| pixels.at(x, y, channel)));
        });
    }

    /// A picture as source, and an output of the same form.
    pub(crate) fn through(&self, node: Node, pixels: &Pixels) {
        self.feed(node, image::SOURCE_CLIP, Some(pixels));
        self.feed(node, image::OUTPUT_CLIP, Some(pixels));
    }

    /// What renders, from any thread.
    pub(crate) fn renderer(&self) -> Renderer {
        Renderer(self.entry)
    }

    /// Renders; the output, or the status where it is not OK.
    pub(crate) fn render(&self, node: Node, frame: Frame) -> Result<Pixels, Status> {
        self.renderer().render(node, frame)
    }

    /// Renders, whatever comes of it.
    pub(crate) fn try_render(&self, node: Node, frame: Frame) -> Status {
        let status = call(self.entry, (action::RENDER, "Render"), node.0, arguments(node, frame)).0;
        with(|world| world.rendered.clear());
        status
    }

    /// The region of definition, if the plugin has its own.
    pub(crate) fn region(&self, node: Node, scale: [f64; 2]) -> Option<[f64; 4]> {
        let args = vec![(prop::TIME, doubles(&[0.0])), (image::RENDER_SCALE, doubles(&scale))];
        let (status, answers) = self.ask((action::GET_REGION_OF_DEFINITION, "GetRegionOfDefinition"), node.0, args);
        four(status, &answers, image::REGION_OF_DEFINITION)
    }

    /// What is needed of the source for a part of the output.
    pub(crate) fn interest(&self, node: Node, part: [f64; 4]) -> Option<[f64; 4]> {
        let args = vec![
            (prop::TIME, doubles(&[0.0])),
            (image::RENDER_SCALE, doubles(&[1.0, 1.0])),
            (image::REGION_OF_INTEREST, doubles(&part)),
        ];
        let (status, answers) = self.ask((action::GET_REGIONS_OF_INTEREST, "GetRegionsOfInterest"), node.0, args);
        four(status, &answers, c"OfxImageClipPropRoI_Source")
    }

    /// Whether the source may be passed on.
    pub(crate) fn is_identity(&self, node: Node) -> bool {
        let args = arguments(node, Frame::default());
        let (status, answers) = self.ask((action::IS_IDENTITY, "IsIdentity"), node.0, args);
        assert!(status != Status::OK || answers[prop::NAME] == text(image::SOURCE_CLIP), "it names a clip");
        status == Status::OK
    }

    /// Sets a parameter without a word to the plugin.
    pub(crate) fn set(&self, node: Node, id: &str, value: impl Into<Set>) {
        self.key_at(node, id, None, value);
    }

    /// Sets a key.
    pub(crate) fn key(&self, node: Node, id: &str, time: f64, value: impl Into<Set>) {
        self.key_at(node, id, Some(time), value);
    }

    fn key_at(&self, node: Node, id: &str, time: Option<f64>, value: impl Into<Set>) {
        let Set(value) = value.into();
        with(|world| {
            let handle = param_of(world, node, id);
            let param = world.params.get_mut(&handle).expect("just found");
            assert_eq!(
                std::mem::discriminant(&param.value),
                std::mem::discriminant(&value),
                "{id} holds {:?}",
                param.value
            );
            put(param, time, value);
        });
    }

    /// Tells the plugin that the user pressed a button or changed a parameter.
    pub(crate) fn press(&self, node: Node, id: &str) -> Status {
        changed_by(self.entry, node.0, &CString::new(id).expect("an id"), prop::CHANGE_USER_EDITED, 0.0)
    }

    /// A point at a time.
    pub(crate) fn point(&self, node: Node, id: &str, time: f64) -> [f64; 2] {
        let held = with(|world| value_at(&world.params[&param_of(world, node, id)], time));
        let Held::Point(point) = held else { panic!("{id} is no point") };
        point
    }

    /// A whole number at a time.
    pub(crate) fn int(&self, node: Node, id: &str) -> i32 {
        let held = with(|world| value_at(&world.params[&param_of(world, node, id)], 0.0));
        let Held::Int(value) = held else { panic!("{id} is no whole number") };
        value
    }

    /// Places a pin and switches it on.
    pub(crate) fn pin(&self, node: Node, number: usize, rest: [f64; 2], target: [f64; 2]) {
        self.set(node, &format!("pin{number}On"), 1);
        self.set(node, &format!("pin{number}Rest"), rest);
        self.set(node, &format!("pin{number}Target"), target);
    }

    /// What the plugin said and did not take back.
    pub(crate) fn said(&self) -> Vec<Said> {
        with(|world| world.said.clone())
    }

    /// Everything that the plugin said, also what it took back.
    pub(crate) fn heard(&self) -> Vec<Said> {
        with(|world| world.heard.clone())
    }

    /// The host's side of an instance ends without a word to the plugin, as at the end of a session in Natron.
    pub(crate) fn break_off(&mut self, node: Node) {
        self.nodes.retain(|other| *other != node);
        end_effect(node.0);
    }

    /// Edits that were open when their effect ended are over.
    pub(crate) fn forgive_open_edits(&self) {
        with(|world| world.open_edits = 0);
    }

    /// The steps to undo that the plugin made.
    pub(crate) fn undo(&self) -> Vec<Undo> {
        with(|world| world.undo.clone())
    }

    /// Lets the host give up at its nth question from now; `None`: never.
    pub(crate) fn abort_at(&self, question: Option<u32>) -> u32 {
        with(|world| {
            world.abort_at = question;
            std::mem::take(&mut world.aborts_asked)
        })
    }

    /// A property of a parameter of the descriptor.
    pub(crate) fn described_of(&self, id: &str, name: &CStr) -> Vec<Value> {
        with(|world| {
            let set = world.params[&param_of(world, Node(self.descriptor), id)].set;
            world.sets[&set].values.get(name).cloned().unwrap_or_default()
        })
    }

    /// Texts of a property of the descriptor.
    pub(crate) fn described(&self, name: &CStr) -> Vec<String> {
        with(|world| world.texts(world.effects[&self.descriptor].set, name))
    }

    /// All parameters of the descriptor in order: id, type, whether limits of value and display are all there.
    pub(crate) fn parameters(&self) -> Vec<(String, String, bool)> {
        with(|world| {
            let effect = &world.effects[&self.descriptor];
            let of = |id: &CString| {
                let found = &world.params[&effect.params[id]];
                let limits = [param::MIN, param::MAX, param::DISPLAY_MIN, param::DISPLAY_MAX];
                let count = |name| world.ints(found.set, name).len().max(world.doubles(found.set, name).len());
                (id.to_string_lossy().into(), found.kind.clone(), limits.into_iter().all(|name| count(name) > 0))
            };
            effect.order.iter().map(of).collect()
        })
    }

    /// Faults so far; they are forgotten, so that a test can provoke some.
    pub(crate) fn take_faults(&self) -> Vec<String> {
        with(|world| std::mem::take(&mut world.faults))
    }

    /// Opens the overlay of a node, if the plugin has one; a pixel of the screen is `pixel` canonical units.
    pub(crate) fn overlay(&self, node: Node, pixel: f64) -> Option<Overlay<'_>> {
        let pointer = with(|world| {
            let set = world.effects[&self.descriptor].set;
            let entry = |name| match world.sets[&set].values.get(name).map(Vec::as_slice) {
                Some([Value::Pointer(entry)]) => Some(*entry),
                _ => None,
            };
            entry(image::OVERLAY_INTERACT_V2).or_else(|| entry(image::OVERLAY_INTERACT_V1))
        })?;
        // SAFETY: the property holds the overlay's entry, a function of this type.
        let entry = unsafe { std::mem::transmute::<usize, EntryPoint>(pointer) };
        let handle = with(|world| {
            let set = world.set(Owner::Interact, "overlay");
            world.put(set, prop::EFFECT_INSTANCE, vec![Value::Pointer(node.0)]);
            world.put(set, interact::PIXEL_SCALE, doubles(&[pixel, pixel]));
            let handle = world.handle();
            world.interacts.insert(handle, set);
            handle
        });
        let overlay = Overlay { entry, handle, node, pixel, _host: std::marker::PhantomData };
        assert_eq!(overlay.act(action::DESCRIBE, "Describe", Vec::new()), Status::OK);
        assert_eq!(overlay.act(action::CREATE_INSTANCE, "CreateInstance", Vec::new()), Status::OK);
        Some(overlay)
    }

    /// Ends everything and fails for faults.
    pub(crate) fn finish(mut self) {
        self.close();
    }

    fn close(&mut self) {
        for node in std::mem::take(&mut self.nodes) {
            self.destroy(node);
        }
        end_effect(self.descriptor);
        let none = PropertySet::NULL;
        // SAFETY: the plugin's own entry; unloading has no handle and no arguments.
        let status =
            acting("Unload", || unsafe { (self.entry)(action::UNLOAD.as_ptr(), std::ptr::null(), none, none) });
        assert!([Status::OK, Status::REPLY_DEFAULT].contains(&status), "{status:?}");
        *ENTRY.lock().unwrap_or_else(PoisonError::into_inner) = None;
        let world = replace(None).expect("it was there");
        let left = world.images.len() + world.effects.len() + world.clips.len() + world.params.len();
        let name = world.profile.name;
        assert!(world.faults.is_empty(), "faults in {name}:\n{}", world.faults.join("\n"));
        assert_eq!((left, world.open_edits), (0, 0), "images, effects, clips and parameters end; edits, too");
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        if !std::thread::panicking() && replace_is_some() {
            self.close();
        }
    }
}

fn replace_is_some() -> bool {
    let world = replace(None);
    let is_some = world.is_some();
    replace(world);
    is_some
}

/// Renders from any thread.
#[derive(Clone, Copy)]
pub(crate) struct Renderer(EntryPoint);

impl Renderer {
    /// Renders; the time that the plugin itself took.
    #[allow(dead_code, reason = "benches use it")]
    pub(crate) fn timed(self, node: Node, frame: Frame) -> Duration {
        let before = with(|world| world.spent);
        let begun = Instant::now();
        let rendered = self.render(node, frame);
        let all = begun.elapsed();
        assert!(rendered.is_ok(), "it renders");
        all.saturating_sub(with(|world| world.spent) - before)
    }

    /// Renders; the output, or the status where it is not OK.
    pub(crate) fn render(self, node: Node, frame: Frame) -> Result<Pixels, Status> {
        let clip = with(|world| world.effects[&node.0].clips[image::OUTPUT_CLIP]);
        let (status, _) = call(self.0, (action::RENDER, "Render"), node.0, arguments(node, frame));
        let mine = with(|world| {
            let at = world.rendered.iter().rposition(|(of, _)| *of == clip)?;
            Some(world.rendered.remove(at).1)
        });
        match (status.is_ok(), mine) {
            (true, Some(pixels)) => Ok(pixels),
            (true, None) => panic!("a render answered OK and gave no output back"),
            (false, _) => Err(status),
        }
    }
}

/// The arguments of a render or a question.
fn arguments(node: Node, frame: Frame) -> Vec<(&'static CStr, Vec<Value>)> {
    let all = with(|world| {
        let clip = world.effects[&node.0].clips[image::OUTPUT_CLIP];
        world.clips[&clip].feed.as_ref().map_or_else(RectI::default, |feed| feed.bounds)
    });
    vec![
        (prop::TIME, doubles(&[frame.time])),
        (image::FIELD_TO_RENDER, text(frame.field)),
        (image::RENDER_WINDOW, rect(frame.window.unwrap_or(all))),
        (image::RENDER_SCALE, doubles(&frame.scale)),
    ]
}
