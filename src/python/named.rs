//! Enumerations given by name.
//!
//! In: `"bspline"`, `"ewa"`, `"cpu"`. Out: the library's values, by the names used in files and on the command line.

use super::failure::Failure;
use crate::raster::{ChannelGroup, DeviceChoice};
use crate::spelling;
use serde::de::DeserializeOwned;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};

/// Parses a value by its name in files.
pub(super) fn named<T: DeserializeOwned>(key: &str, name: &str) -> Result<T, Failure> {
    let text: StrDeserializer<'_, Error> = name.into_deserializer();
    T::deserialize(text).map_err(|error| Failure::argument(key, format!("is {name:?}"), error.to_string()))
}

/// Parses a rendering device as `--device` does.
pub(super) fn device(name: &str) -> Result<DeviceChoice, Failure> {
    match name {
        "" => {
            Err(Failure::argument("device", "is empty", "give \"auto\", \"cpu\", \"vulkan\" or the name of a device"))
        }
        name => Ok(DeviceChoice::of_name(name)),
    }
}

/// Channel groups by their names in shot files.
const GROUPS: [(&str, ChannelGroup); 6] = [
    ("beauty", ChannelGroup::Beauty),
    ("depth", ChannelGroup::Depth),
    ("motion", ChannelGroup::Motion),
    ("normal", ChannelGroup::Normal),
    ("id", ChannelGroup::Id),
    ("cryptomatte", ChannelGroup::Cryptomatte),
];

/// Parses channel groups, in the order of a frame.
pub(super) fn channel_groups(names: &[String]) -> Result<Vec<ChannelGroup>, Failure> {
    let group = |name: &String| {
        let found = GROUPS.iter().find(|(known, _)| known == name).map(|(_, group)| *group);
        let hint = || spelling::hint(name, GROUPS.iter().map(|(known, _)| *known));
        found.ok_or_else(|| Failure::argument("channels", format!("there is no group {name:?}"), hint()))
    };
    let mut groups = names.iter().map(group).collect::<Result<Vec<_>, _>>()?;
    if groups.is_empty() {
        return Err(Failure::argument("channels", "is empty", "name at least one group, such as \"beauty\""));
    }
    groups.sort_unstable();
    groups.dedup();
    Ok(groups)
}

/// Returns the names of channel groups.
pub(super) fn group_names(groups: &[ChannelGroup]) -> Vec<&'static str> {
    GROUPS.iter().filter(|(_, group)| groups.contains(group)).map(|(name, _)| *name).collect()
}
