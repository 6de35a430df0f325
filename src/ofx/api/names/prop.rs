//! Properties of no kind in particular, and the values they take.
//!
//! In: nothing. Out: names; each says its type and number of values.

names! {
    /// String: what is behind a handle.
    TYPE = c"OfxPropType";
    /// String: the name of a host, clip or parameter.
    NAME = c"OfxPropName";
    /// String: what the user reads.
    LABEL = c"OfxPropLabel";
    /// String: the same, for little room.
    SHORT_LABEL = c"OfxPropShortLabel";
    /// String: the same, for much room.
    LONG_LABEL = c"OfxPropLongLabel";
    /// Ints: a version, most significant first.
    VERSION = c"OfxPropVersion";
    /// String: a version to read.
    VERSION_LABEL = c"OfxPropVersionLabel";
    /// Ints, of the host: the version of the API; absent: 1.0.
    API_VERSION = c"OfxPropAPIVersion";
    /// String: what the plugin is for.
    PLUGIN_DESCRIPTION = c"OfxPropPluginDescription";
    /// String, of an effect: the bundle.
    PLUGIN_FILE_PATH = c"OfxPluginPropFilePath";
    /// Pointer, of an instance: whatever the plugin keeps.
    INSTANCE_DATA = c"OfxPropInstanceData";
    /// Int: whether there is a user interface.
    IS_INTERACTIVE = c"OfxPropIsInteractive";
    /// Double: a time, in frames.
    TIME = c"OfxPropTime";
    /// String: why something changed.
    CHANGE_REASON = c"OfxPropChangeReason";
    /// Pointer, of an overlay: its effect.
    EFFECT_INSTANCE = c"OfxPropEffectInstance";
    /// Value of [`CHANGE_REASON`]: the user did it.
    CHANGE_USER_EDITED = c"OfxChangeUserEdited";
    /// Value of [`CHANGE_REASON`]: the plugin did it.
    CHANGE_PLUGIN_EDITED = c"OfxChangePluginEdited";
    /// Value of [`CHANGE_REASON`]: the time moved on.
    CHANGE_TIME = c"OfxChangeTime";
    /// Value of [`TYPE`]: a host.
    TYPE_IMAGE_EFFECT_HOST = c"OfxTypeImageEffectHost";
    /// Value of [`TYPE`]: an effect's descriptor.
    TYPE_IMAGE_EFFECT = c"OfxTypeImageEffect";
    /// Value of [`TYPE`]: an effect's instance.
    TYPE_IMAGE_EFFECT_INSTANCE = c"OfxTypeImageEffectInstance";
    /// Value of [`TYPE`]: a parameter.
    TYPE_PARAMETER = c"OfxTypeParameter";
    /// Value of [`TYPE`]: a parameter of an instance.
    TYPE_PARAMETER_INSTANCE = c"OfxTypeParameterInstance";
    /// Value of [`TYPE`]: a clip.
    TYPE_CLIP = c"OfxTypeClip";
    /// Value of [`TYPE`]: an image.
    TYPE_IMAGE = c"OfxTypeImage";
}
