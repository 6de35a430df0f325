//! The image effect suite: effects, clips, images with their lifetimes, aborting.

use super::api::names::{image, prop};
use super::api::{ClipHandle, EffectHandle, ImageEffectSuiteV1, ParamSetHandle, PropertySet, RectD, RectI, Status};
use super::pixels::{Buffer, Depth};
use super::profile::{NoClip, Regions};
use super::props::name_of;
use super::spec::Owner;
use super::world::{Clip, Feed, Image, Value, World, current_action, with};
use std::ffi::{CStr, c_char, c_int, c_void};

/// The table of functions. The image pool is left out, as it may be.
pub(crate) static SUITE: ImageEffectSuiteV1 = ImageEffectSuiteV1 {
    get_property_set: Some(get_property_set),
    get_param_set: Some(get_param_set),
    clip_define: Some(clip_define),
    clip_get_handle: Some(clip_get_handle),
    clip_get_property_set: Some(clip_get_property_set),
    clip_get_image: Some(clip_get_image),
    clip_release_image: Some(clip_release_image),
    clip_get_region_of_definition: Some(clip_get_region_of_definition),
    abort: Some(abort),
    image_memory_alloc: None,
    image_memory_free: None,
    image_memory_lock: None,
    image_memory_unlock: None,
};

/// Writes an answer, where the plugin wants one.
pub(crate) fn give<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: the plugin gives a place for one value, or null.
        unsafe { place.write(value) };
    }
}

/// A handle as the pointer that the plugin sees.
pub(crate) fn seen(handle: usize) -> *mut c_void {
    handle as *mut c_void
}

unsafe extern "C" fn get_property_set(effect: EffectHandle, to: *mut PropertySet) -> Status {
    with(|world| match world.effects.get(&(effect.0 as usize)) {
        Some(found) => {
            give(to, PropertySet(seen(found.set)));
            Status::OK
        }
        None => world.bad_handle(effect.0 as usize, "an effect"),
    })
}

unsafe extern "C" fn get_param_set(effect: EffectHandle, to: *mut ParamSetHandle) -> Status {
    with(|world| match world.effects.get(&(effect.0 as usize)) {
        Some(found) => {
            give(to, ParamSetHandle(seen(found.param_set)));
            Status::OK
        }
        None => world.bad_handle(effect.0 as usize, "an effect"),
    })
}

unsafe extern "C" fn clip_define(effect: EffectHandle, name: *const c_char, to: *mut PropertySet) -> Status {
    let name = name_of(name);
    with(|world| {
        let effect = effect.0 as usize;
        if !world.effects.contains_key(&effect) {
            return world.bad_handle(effect, "an effect");
        }
        if current_action() != "DescribeInContext" {
            return world.fault("a clip was defined");
        }
        if world.effects[&effect].clips.contains_key(&name) {
            world.fault(format!("clip {} was defined twice", name.to_string_lossy()));
            return Status::ERR_EXISTS;
        }
        let set = world.set(Owner::ClipDescriptor, &name.to_string_lossy());
        let handle = world.handle();
        world.clips.insert(handle, Clip { set, name: name.clone(), feed: None });
        world.effects.get_mut(&effect).expect("it was looked up").clips.insert(name, handle);
        give(to, PropertySet(seen(set)));
        Status::OK
    })
}

unsafe extern "C" fn clip_get_handle(
    effect: EffectHandle,
    name: *const c_char,
    to: *mut ClipHandle,
    set: *mut PropertySet,
) -> Status {
    let name = name_of(name);
    with(|world| {
        let Some(found) = world.effects.get(&(effect.0 as usize)) else {
            return world.bad_handle(effect.0 as usize, "an effect");
        };
        if let Some(clip) = found.clips.get(&name) {
            give(set, PropertySet(seen(world.clips[clip].set)));
            give(to, ClipHandle(seen(*clip)));
            return Status::OK;
        }
        if world.profile.no_clip == NoClip::Null {
            give(to, ClipHandle::NULL);
            return Status::OK;
        }
        Status::ERR_UNKNOWN
    })
}

unsafe extern "C" fn clip_get_property_set(clip: ClipHandle, to: *mut PropertySet) -> Status {
    with(|world| match world.clips.get(&(clip.0 as usize)) {
        Some(found) => {
            give(to, PropertySet(seen(found.set)));
            Status::OK
        }
        None => world.bad_handle(clip.0 as usize, "a clip"),
    })
}

unsafe extern "C" fn clip_get_image(clip: ClipHandle, _: f64, _: *const RectD, to: *mut PropertySet) -> Status {
    with(|world| {
        let handle = clip.0 as usize;
        let Some(clip) = world.clips.get(&handle) else { return world.bad_handle(handle, "a clip") };
        if !matches!(current_action(), "Render" | "InstanceChanged") {
            return world.fault("an image was fetched");
        }
        let is_output = clip.name.as_c_str() == image::OUTPUT_CLIP;
        let Some(feed) = clip.feed.clone().filter(|feed| is_output || feed.pixels.is_some()) else {
            return Status::FAILED;
        };
        let buffer = match &feed.pixels {
            Some(pixels) if !is_output => Buffer::of(pixels, feed.depth, feed.rows),
            _ => Buffer::new(feed.bounds, feed.channels, feed.depth, feed.rows),
        };
        let name = clip.name.to_string_lossy().into_owned();
        let set = world.set(Owner::Image, &format!("image of {name}"));
        describe_image(world, set, &feed, &buffer);
        world.images.insert(set, Image { clip: handle, buffer, action: current_action() });
        world.images_given += 1;
        give(to, PropertySet(seen(set)));
        Status::OK
    })
}

fn describe_image(world: &mut World, set: usize, feed: &Feed, buffer: &Buffer) {
    let (data, row_bytes) = buffer.told();
    let RectI { x1, y1, x2, y2 } = buffer.bounds;
    let rect = [x1, y1, x2, y2].map(Value::Int).to_vec();
    let given = world.images_given;
    for (name, values) in [
        (prop::TYPE, vec![Value::Text(prop::TYPE_IMAGE.to_owned())]),
        (image::DATA, vec![Value::Pointer(data as usize)]),
        (image::ROW_BYTES, vec![Value::Int(row_bytes)]),
        (image::BOUNDS, rect.clone()),
        (image::IMAGE_REGION_OF_DEFINITION, rect),
        (image::RENDER_SCALE, feed.scale.map(Value::Double).to_vec()),
        (image::PIXEL_ASPECT, vec![Value::Double(feed.aspect)]),
        (image::PIXEL_DEPTH, vec![Value::Text(depth_name(feed.depth).to_owned())]),
        (image::COMPONENTS, vec![Value::Text(components_name(feed.channels).to_owned())]),
        (image::PREMULTIPLICATION, vec![Value::Text(feed.premultiplication.to_owned())]),
        (image::FIELD, vec![Value::Text(image::FIELD_NONE.to_owned())]),
        (image::UNIQUE_IDENTIFIER, vec![Value::Text(std::ffi::CString::new(given.to_string()).expect("digits"))]),
    ] {
        world.put(set, name, values);
    }
}

/// The API's name of a depth.
pub(crate) fn depth_name(depth: Depth) -> &'static CStr {
    match depth {
        Depth::Byte => image::DEPTH_BYTE,
        Depth::Short => image::DEPTH_SHORT,
        Depth::Half => image::DEPTH_HALF,
        Depth::Float => image::DEPTH_FLOAT,
    }
}

/// The API's name of so many channels.
pub(crate) fn components_name(channels: usize) -> &'static CStr {
    match channels {
        4 => image::COMPONENT_RGBA,
        3 => image::COMPONENT_RGB,
        _ => image::COMPONENT_ALPHA,
    }
}

unsafe extern "C" fn clip_release_image(set: PropertySet) -> Status {
    with(|world| {
        let set = set.0 as usize;
        let Some(held) = world.images.remove(&set) else { return world.bad_handle(set, "an image") };
        if held.action != current_action() {
            world.fault(format!("an image was kept from {}", held.action));
        }
        world.end_set(set, "image");
        let clip = world.clips.get(&held.clip).cloned();
        match (held.buffer.read(), clip) {
            (None, _) => world.fault("bytes outside an image were written"),
            (Some(pixels), Some(clip)) if clip.name.as_c_str() == image::OUTPUT_CLIP => {
                world.rendered.push((held.clip, pixels));
                Status::OK
            }
            (Some(pixels), Some(clip)) => {
                let given = clip.feed.and_then(|feed| Some(Buffer::of(&feed.pixels?, feed.depth, feed.rows)));
                if given.and_then(|given| given.read()).is_some_and(|given| given != pixels) {
                    return world.fault(format!("the image of {} was written", clip.name.to_string_lossy()));
                }
                Status::OK
            }
            (Some(_), None) => Status::OK,
        }
    })
}

unsafe extern "C" fn clip_get_region_of_definition(clip: ClipHandle, _: f64, place: *mut RectD) -> Status {
    with(|world| {
        let Some(clip) = world.clips.get(&(clip.0 as usize)) else {
            return world.bad_handle(clip.0 as usize, "a clip");
        };
        let Some(feed) = &clip.feed else { return Status::FAILED };
        let RectI { x1, y1, x2, y2 } = feed.bounds;
        let [x, y] = match world.profile.regions {
            Regions::Unwritten => return Status::OK,
            Regions::Refused => return Status::FAILED,
            Regions::Endless => {
                let [from, to] = [i32::MIN, i32::MAX].map(f64::from);
                give(place, RectD { x1: from, y1: from, x2: to, y2: to });
                return Status::OK;
            }
            Regions::Pixels => [feed.aspect, 1.0],
            Regions::Canonical => [feed.aspect / feed.scale[0], 1.0 / feed.scale[1]],
        };
        let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(f64::from);
        give(place, RectD { x1: x1 * x, y1: y1 * y, x2: x2 * x, y2: y2 * y });
        Status::OK
    })
}

unsafe extern "C" fn abort(effect: EffectHandle) -> c_int {
    with(|world| {
        if !world.effects.contains_key(&(effect.0 as usize)) {
            world.bad_handle(effect.0 as usize, "an effect");
        }
        world.aborts_asked += 1;
        c_int::from(world.abort_at.is_some_and(|from| world.aborts_asked >= from))
    })
}
