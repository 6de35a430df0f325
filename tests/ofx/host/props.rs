//! The property suite: checks every name, type and index against the API.

use super::api::names::param;
use super::api::{PropertySet, PropertySuiteV1, Status};
use super::spec::{Owner, Type, of_param, spec};
use super::world::{Value, World, with};
use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// The table of functions. What fetches or sets several values at once is left out, as it may be.
pub(crate) static SUITE: PropertySuiteV1 = ONE_BY_ONE;

/// The same for hosts that tell some values all at once only.
pub(crate) static SUITE_OF_MANY: PropertySuiteV1 = PropertySuiteV1 { get_int_n: Some(get_int_n), ..ONE_BY_ONE };

const ONE_BY_ONE: PropertySuiteV1 = PropertySuiteV1 {
    set_pointer: Some(set_pointer),
    set_string: Some(set_string),
    set_double: Some(set_double),
    set_int: Some(set_int),
    set_pointer_n: None,
    set_string_n: None,
    set_double_n: None,
    set_int_n: None,
    get_pointer: Some(get_pointer),
    get_string: Some(get_string),
    get_double: Some(get_double),
    get_int: Some(get_int),
    get_pointer_n: None,
    get_string_n: None,
    get_double_n: None,
    get_int_n: None,
    reset: None,
    get_dimension: Some(get_dimension),
};

/// A name that C hands over.
pub(crate) fn name_of(name: *const c_char) -> CString {
    assert!(!name.is_null(), "names are never null");
    // SAFETY: not null, and the plugin ends its names with zero.
    unsafe { CStr::from_ptr(name) }.to_owned()
}

/// Finds out what a property is; the status to answer with where it may not be used so.
fn checked(world: &mut World, set: usize, name: &CStr, index: c_int, wanted: Type) -> Result<usize, Status> {
    let Some(found) = world.sets.get(&set) else { return Err(world.bad_handle(set, "properties")) };
    let (owner, label, param_kind) = (found.owner, found.label.clone(), found.param_kind.clone());
    let shown = name.to_string_lossy();
    let Some((kind, size)) = spec(owner, name) else {
        world.fault(format!("{label} ({owner:?}) has no property {shown}"));
        return Err(Status::ERR_UNKNOWN);
    };
    let (kind, size) = if kind == Type::OfParam { of_param(&param_kind) } else { (kind, size) };
    if kind != wanted {
        return Err(world.fault(format!("{shown} of {label} holds {kind:?}, not {wanted:?}")));
    }
    let Some(index) = usize::try_from(index).ok().filter(|index| size == 0 || *index < size) else {
        world.fault(format!("{shown} of {label} has {size} values, and no number {index}"));
        return Err(Status::ERR_BAD_INDEX);
    };
    if world.profile.refuses.contains(&name) {
        return Err(Status::ERR_UNKNOWN);
    }
    Ok(index)
}

fn set(set: PropertySet, name: *const c_char, index: c_int, wanted: Type, value: Value) -> Status {
    let name = name_of(name);
    with(|world| {
        let set = set.0 as usize;
        let index = match checked(world, set, &name, index, wanted) {
            Ok(index) => index,
            Err(status) => return status,
        };
        let owner = world.sets[&set].owner;
        if matches!(owner, Owner::Host | Owner::Arguments | Owner::Clip | Owner::Image) {
            return world.fault(format!("{} of {owner:?} was set; it is the host's", name.to_string_lossy()));
        }
        let values = world.sets.get_mut(&set).expect("it was checked").values.entry(name.clone()).or_default();
        if index > values.len() {
            let shown = name.to_string_lossy().into_owned();
            return world.fault(format!("value {index} of {shown} was set before those below it"));
        }
        if index == values.len() {
            values.push(value)
        } else {
            values[index] = value
        }
        Status::OK
    })
}

fn get(set: PropertySet, name: *const c_char, index: c_int, wanted: Type) -> Result<Value, Status> {
    let name = name_of(name);
    with(|world| {
        let set = set.0 as usize;
        let index = checked(world, set, &name, index, wanted)?;
        if name.as_c_str() == param::IS_ANIMATING {
            let has_keys = world.params.values().any(|param| param.set == set && !param.keys.is_empty());
            return Ok(Value::Int(has_keys.into()));
        }
        let Some(values) = world.sets[&set].values.get(&name) else { return Err(Status::ERR_UNKNOWN) };
        values.get(index).cloned().ok_or(Status::ERR_BAD_INDEX)
    })
}

/// Writes an answer where the plugin wants it.
fn answer<T>(place: *mut T, value: T) -> Status {
    assert!(!place.is_null(), "a place for the answer");
    // SAFETY: the plugin gives a place for one value.
    unsafe { place.write(value) };
    Status::OK
}

unsafe extern "C" fn set_pointer(to: PropertySet, name: *const c_char, index: c_int, value: *mut c_void) -> Status {
    set(to, name, index, Type::Pointer, Value::Pointer(value as usize))
}

unsafe extern "C" fn set_string(to: PropertySet, name: *const c_char, index: c_int, value: *const c_char) -> Status {
    if value.is_null() {
        return with(|world| world.fault("a text was set to null"));
    }
    set(to, name, index, Type::Text, Value::Text(name_of(value)))
}

unsafe extern "C" fn set_double(to: PropertySet, name: *const c_char, index: c_int, value: f64) -> Status {
    if value.is_nan() {
        return with(|world| world.fault(format!("{} was set to no number", name_of(name).to_string_lossy())));
    }
    set(to, name, index, Type::Double, Value::Double(value))
}

unsafe extern "C" fn set_int(to: PropertySet, name: *const c_char, index: c_int, value: c_int) -> Status {
    set(to, name, index, Type::Int, Value::Int(value))
}

unsafe extern "C" fn get_pointer(from: PropertySet, name: *const c_char, index: c_int, to: *mut *mut c_void) -> Status {
    match get(from, name, index, Type::Pointer) {
        Ok(Value::Pointer(value)) => answer(to, value as *mut c_void),
        Ok(_) => Status::ERR_VALUE,
        Err(status) => status,
    }
}

unsafe extern "C" fn get_string(from: PropertySet, name: *const c_char, index: c_int, to: *mut *mut c_char) -> Status {
    match get(from, name, index, Type::Text) {
        Ok(Value::Text(text)) => answer(to, with(|world| world.lend(&text))),
        Ok(_) => Status::ERR_VALUE,
        Err(status) => status,
    }
}

unsafe extern "C" fn get_double(from: PropertySet, name: *const c_char, index: c_int, to: *mut f64) -> Status {
    match get(from, name, index, Type::Double) {
        Ok(Value::Double(value)) => answer(to, value),
        Ok(_) => Status::ERR_VALUE,
        Err(status) => status,
    }
}

unsafe extern "C" fn get_int(from: PropertySet, name: *const c_char, index: c_int, to: *mut c_int) -> Status {
    if with(|world| world.profile.untold_alone.contains(&name_of(name).as_c_str())) {
        return Status::OK;
    }
    match get(from, name, index, Type::Int) {
        Ok(Value::Int(value)) => answer(to, value),
        Ok(_) => Status::ERR_VALUE,
        Err(status) => status,
    }
}

unsafe extern "C" fn get_int_n(from: PropertySet, name: *const c_char, count: c_int, to: *mut c_int) -> Status {
    for index in 0..count {
        match get(from, name, index, Type::Int) {
            Ok(Value::Int(value)) => answer(to.wrapping_add(index as usize), value),
            Ok(_) => return Status::ERR_VALUE,
            Err(status) => return status,
        };
    }
    Status::OK
}

unsafe extern "C" fn get_dimension(from: PropertySet, name: *const c_char, to: *mut c_int) -> Status {
    let name = name_of(name);
    let count =
        with(|world| world.sets.get(&(from.0 as usize)).and_then(|set| set.values.get(&name)).map_or(0, Vec::len));
    answer(to, count as c_int)
}
