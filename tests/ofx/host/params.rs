//! The parameter suite: values, keys, undo. Its variadic functions are plain ones here, see [`variadic`].

use super::api::names::param as names;
use super::api::{ParamHandle, ParamSetHandle, ParameterSuiteV1, PropertySet, Status};
use super::effects::{give, seen};
use super::profile::{Keys, Points};
use super::props::name_of;
use super::session::tell_changes;
use super::spec::Owner;
use super::world::{Held, Param, Undo, Value, World, current_action, with};
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};

/// Variadic functions of the API.
///
/// Stable Rust can call variadic C functions and not define any. On the systems that `main.rs` lets this test run on
/// (x86-64 of System V, 64-bit ARM under Linux) a variadic call puts its first integers, pointers and doubles into the
/// same registers as a call of a function with such fixed parameters, counted by kind: so plain functions with a fixed
/// number of pointers and doubles receive them. What was not passed is read as whatever the register held, and not looked at.
pub(crate) mod variadic {
    use super::{ParamHandle, Status, c_void};

    /// A pointer for each value.
    pub(crate) type Get = unsafe extern "C" fn(ParamHandle, *mut c_void, *mut c_void) -> Status;
    /// The same, at a time.
    pub(crate) type GetAt = unsafe extern "C" fn(ParamHandle, f64, *mut c_void, *mut c_void) -> Status;
    /// An int or a text in the first whole register, doubles in their own.
    pub(crate) type Set = unsafe extern "C" fn(ParamHandle, usize, f64, f64) -> Status;
    /// The same, at a time.
    pub(crate) type SetAt = unsafe extern "C" fn(ParamHandle, f64, usize, f64, f64) -> Status;
}

/// The table of functions; those that integrate, derive and copy are left out.
pub(crate) fn suite() -> ParameterSuiteV1 {
    ParameterSuiteV1 {
        define: Some(define),
        get_handle: Some(get_handle),
        set_get_property_set: Some(set_get_property_set),
        get_property_set: Some(get_property_set),
        // SAFETY: see `variadic`: the registers are the same.
        get_value: Some(unsafe {
            std::mem::transmute::<variadic::Get, unsafe extern "C" fn(ParamHandle, ...) -> Status>(get_value)
        }),
        // SAFETY: as above.
        get_value_at_time: Some(unsafe {
            std::mem::transmute::<variadic::GetAt, unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>(
                get_value_at_time,
            )
        }),
        get_derivative: None,
        get_integral: None,
        // SAFETY: as above.
        set_value: Some(unsafe {
            std::mem::transmute::<variadic::Set, unsafe extern "C" fn(ParamHandle, ...) -> Status>(set_value)
        }),
        // SAFETY: as above.
        set_value_at_time: Some(unsafe {
            std::mem::transmute::<variadic::SetAt, unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>(
                set_value_at_time,
            )
        }),
        get_num_keys: Some(get_num_keys),
        get_key_time: Some(get_key_time),
        get_key_index: Some(get_key_index),
        delete_key: Some(delete_key),
        delete_all_keys: Some(delete_all_keys),
        copy: None,
        edit_begin: Some(edit_begin),
        edit_end: Some(edit_end),
    }
}

unsafe extern "C" fn define(
    params: ParamSetHandle,
    kind: *const c_char,
    name: *const c_char,
    to: *mut PropertySet,
) -> Status {
    let [kind, name] = [kind, name].map(name_of);
    with(|world| {
        let Some(&effect) = world.param_sets.get(&(params.0 as usize)) else {
            return world.bad_handle(params.0 as usize, "parameters");
        };
        if current_action() != "DescribeInContext" {
            return world.fault("a parameter was defined");
        }
        if world.profile.no_params.contains(&kind.as_c_str()) {
            return Status::ERR_UNSUPPORTED;
        }
        let shown = name.to_string_lossy().into_owned();
        if world.effects[&effect].params.contains_key(&name) {
            world.fault(format!("parameter {shown} was defined twice"));
            return Status::ERR_EXISTS;
        }
        let set = world.set(Owner::Param, &shown);
        let kind = kind.to_string_lossy().into_owned();
        world.sets.get_mut(&set).expect("made above").param_kind.clone_from(&kind);
        world.put(set, names::TYPE, vec![Value::Text(CString::new(kind.clone()).expect("it was C"))]);
        let handle = world.handle();
        let made = Param { set, effect, name: name.clone(), kind, value: Held::Nothing, keys: Vec::new() };
        world.params.insert(handle, made);
        let effect = world.effects.get_mut(&effect).expect("it has parameters");
        effect.order.push(name.clone());
        effect.params.insert(name, handle);
        give(to, PropertySet(seen(set)));
        Status::OK
    })
}

unsafe extern "C" fn get_handle(
    params: ParamSetHandle,
    name: *const c_char,
    to: *mut ParamHandle,
    set: *mut PropertySet,
) -> Status {
    let name = name_of(name);
    with(|world| {
        let Some(effect) = world.param_sets.get(&(params.0 as usize)) else {
            return world.bad_handle(params.0 as usize, "parameters");
        };
        let Some(&handle) = world.effects[effect].params.get(&name) else { return Status::ERR_UNKNOWN };
        give(set, PropertySet(seen(world.params[&handle].set)));
        give(to, ParamHandle(seen(handle)));
        Status::OK
    })
}

unsafe extern "C" fn set_get_property_set(params: ParamSetHandle, to: *mut PropertySet) -> Status {
    with(|world| {
        let Some(effect) = world.param_sets.get(&(params.0 as usize)) else {
            return world.bad_handle(params.0 as usize, "parameters");
        };
        give(to, PropertySet(seen(world.effects[effect].set)));
        Status::OK
    })
}

unsafe extern "C" fn get_property_set(param: ParamHandle, to: *mut PropertySet) -> Status {
    with(|world| match world.params.get(&(param.0 as usize)) {
        Some(found) => {
            give(to, PropertySet(seen(found.set)));
            Status::OK
        }
        None => world.bad_handle(param.0 as usize, "a parameter"),
    })
}

/// The value at a time: numbers between keys are on a line, the rest holds.
pub(crate) fn value_at(param: &Param, time: f64) -> Held {
    let after = param.keys.iter().position(|(key, _)| *key > time);
    let (Some(first), Some(last)) = (param.keys.first(), param.keys.last()) else { return param.value.clone() };
    let (before, after) = match after {
        Some(0) => return first.1.clone(),
        None => return last.1.clone(),
        Some(after) => (&param.keys[after - 1], &param.keys[after]),
    };
    let share = (time - before.0) / (after.0 - before.0);
    let between = |a: f64, b: f64| a + (b - a) * share;
    match (&before.1, &after.1) {
        (Held::Double(a), Held::Double(b)) => Held::Double(between(*a, *b)),
        (Held::Point(a), Held::Point(b)) => Held::Point([between(a[0], b[0]), between(a[1], b[1])]),
        (held, _) => held.clone(),
    }
}

fn read(param: ParamHandle, time: f64, [first, second]: [*mut c_void; 2]) -> Status {
    with(|world| {
        let Some(found) = world.params.get(&(param.0 as usize)) else {
            return world.bad_handle(param.0 as usize, "a parameter");
        };
        match value_at(found, time) {
            Held::Int(value) => give(first.cast::<c_int>(), value),
            Held::Double(value) => give(first.cast::<f64>(), value),
            Held::Point([x, y]) => {
                let behind = first.cast::<f64>().wrapping_add(1);
                if world.profile.points == Points::InARow && second.cast() != behind {
                    return world
                        .fault("the places for a point's numbers do not lie in a row: this host writes beside them");
                }
                give(first.cast::<f64>(), x);
                give(second.cast::<f64>(), y);
            }
            Held::Text(text) => {
                let text = world.lend(&text);
                give(first.cast::<*mut c_char>(), text);
            }
            Held::Nothing => {
                let name = found.name.to_string_lossy().into_owned();
                return world.fault(format!("{name} has no value to read"));
            }
        }
        Status::OK
    })
}

unsafe extern "C" fn get_value(param: ParamHandle, first: *mut c_void, second: *mut c_void) -> Status {
    read(param, 0.0, [first, second])
}

unsafe extern "C" fn get_value_at_time(
    param: ParamHandle,
    time: f64,
    first: *mut c_void,
    second: *mut c_void,
) -> Status {
    read(param, time, [first, second])
}

/// What was passed, by the parameter's type.
fn passed(held: &Held, whole: usize, numbers: [f64; 2]) -> Held {
    match held {
        Held::Int(_) => Held::Int(whole as u32 as i32),
        Held::Double(_) => Held::Double(numbers[0]),
        Held::Point(_) => Held::Point(numbers),
        // SAFETY: the plugin passes a text that ends with zero.
        Held::Text(_) => Held::Text(unsafe { CStr::from_ptr(whole as *const c_char) }.to_owned()),
        Held::Nothing => Held::Nothing,
    }
}

fn write(param: ParamHandle, time: Option<f64>, whole: usize, numbers: [f64; 2]) -> Status {
    let status = with(|world| {
        let handle = param.0 as usize;
        let Some(found) = world.params.get(&handle) else { return world.bad_handle(handle, "a parameter") };
        let (name, effect, set) = (found.name.clone(), found.effect, found.set);
        let shown = name.to_string_lossy().into_owned();
        if !matches!(
            current_action(),
            "InstanceChanged" | "PenDown" | "PenMotion" | "PenUp" | "KeyDown" | "CloseOverlay"
        ) {
            return world.fault(format!("{shown} was set"));
        }
        let value = passed(&found.value, whole, numbers);
        let is_number = match value {
            Held::Double(number) => number.is_finite(),
            Held::Point(point) => point.iter().all(|number| number.is_finite()),
            _ => true,
        };
        if !is_number {
            return world.fault(format!("{shown} was set to no number"));
        }
        if time.is_some() && world.ints(set, names::ANIMATES) == [0] {
            return world.fault(format!("{shown} got a key; it does not animate"));
        }
        let found = world.params.get_mut(&handle).expect("looked up above");
        put(found, time, value);
        if world.open_edits > 0 {
            world.undo.last_mut().expect("one is open").params.push(shown);
        }
        world.changed.push((effect, name));
        Status::OK
    });
    tell_changes();
    status
}

/// Sets a value or a key.
pub(crate) fn put(param: &mut Param, time: Option<f64>, value: Held) {
    let Some(time) = time else {
        param.value = value;
        return;
    };
    param.keys.retain(|(key, _)| *key != time);
    let at = param.keys.partition_point(|(key, _)| *key < time);
    param.keys.insert(at, (time, value));
}

unsafe extern "C" fn set_value(param: ParamHandle, whole: usize, x: f64, y: f64) -> Status {
    write(param, None, whole, [x, y])
}

unsafe extern "C" fn set_value_at_time(param: ParamHandle, time: f64, whole: usize, x: f64, y: f64) -> Status {
    write(param, Some(time), whole, [x, y])
}

/// Answers from a parameter's keys.
fn keys<R>(param: ParamHandle, work: impl FnOnce(&mut World, usize) -> (R, Status), none: R) -> (R, Status) {
    with(|world| {
        let handle = param.0 as usize;
        if world.profile.keys == Keys::Fatal {
            return (none, world.fault("keys were asked for: this host ends the program then"));
        }
        if world.params.contains_key(&handle) {
            work(world, handle)
        } else {
            (none, world.bad_handle(handle, "a parameter"))
        }
    })
}

unsafe extern "C" fn get_num_keys(param: ParamHandle, to: *mut c_uint) -> Status {
    let (count, status) = keys(param, |world, at| (world.params[&at].keys.len() as c_uint, Status::OK), 0);
    give(to, count);
    status
}

unsafe extern "C" fn get_key_time(param: ParamHandle, nth: c_uint, to: *mut f64) -> Status {
    let find = |world: &mut World, at: usize| match world.params[&at].keys.get(nth as usize) {
        Some((time, _)) => (*time, Status::OK),
        None => (0.0, Status::ERR_BAD_INDEX),
    };
    let (time, status) = keys(param, find, 0.0);
    if status.is_ok() {
        give(to, time);
    }
    status
}

unsafe extern "C" fn get_key_index(param: ParamHandle, time: f64, direction: c_int, to: *mut c_int) -> Status {
    let find = |world: &mut World, at: usize| {
        let keys = &world.params[&at].keys;
        let found = match direction {
            0 => keys.iter().position(|(key, _)| *key == time),
            before if before < 0 => keys.iter().rposition(|(key, _)| *key < time),
            _ => keys.iter().position(|(key, _)| *key > time),
        };
        (found.map_or(-1, |index| index as c_int), if found.is_some() { Status::OK } else { Status::FAILED })
    };
    let (index, status) = keys(param, find, -1);
    give(to, index);
    status
}

unsafe extern "C" fn delete_key(param: ParamHandle, time: f64) -> Status {
    keys(
        param,
        |world, at| (world.params.get_mut(&at).expect("there").keys.retain(|(key, _)| *key != time), Status::OK),
        (),
    )
    .1
}

unsafe extern "C" fn delete_all_keys(param: ParamHandle) -> Status {
    keys(param, |world, at| (world.params.get_mut(&at).expect("there").keys.clear(), Status::OK), ()).1
}

unsafe extern "C" fn edit_begin(params: ParamSetHandle, label: *const c_char) -> Status {
    let label = name_of(label).to_string_lossy().into_owned();
    with(|world| {
        if !world.param_sets.contains_key(&(params.0 as usize)) {
            return world.bad_handle(params.0 as usize, "parameters");
        }
        if world.open_edits == 0 {
            world.undo.push(Undo { label, params: Vec::new() });
        }
        world.open_edits += 1;
        Status::OK
    })
}

unsafe extern "C" fn edit_end(params: ParamSetHandle) -> Status {
    with(|world| {
        if !world.param_sets.contains_key(&(params.0 as usize)) {
            return world.bad_handle(params.0 as usize, "parameters");
        }
        if world.open_edits == 0 {
            return world.fault("an edit was ended that never began");
        }
        world.open_edits -= 1;
        Status::OK
    })
}
