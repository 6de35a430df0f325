//! General properties, and their values.
//!
//! In: nothing. Out: C strings; each documents its type and number of values.

names! {
    /// String: the type of the object behind a handle.
    TYPE = c"OfxPropType";
    /// String: the name of a host, clip or parameter.
    NAME = c"OfxPropName";
    /// String: the label shown to the user.
    LABEL = c"OfxPropLabel";
    /// String: a shorter label, for narrow displays.
    SHORT_LABEL = c"OfxPropShortLabel";
    /// String: a longer label, for wide displays.
    LONG_LABEL = c"OfxPropLongLabel";
    /// Ints: a version number, most significant component first.
    VERSION = c"OfxPropVersion";
    /// String: a human-readable version.
    VERSION_LABEL = c"OfxPropVersionLabel";
    /// Ints, of the host: the API version; absent in hosts of API 1.0.
    API_VERSION = c"OfxPropAPIVersion";
    /// String: a description of the plugin.
    PLUGIN_DESCRIPTION = c"OfxPropPluginDescription";
    /// String, of an effect: the path of its bundle.
    PLUGIN_FILE_PATH = c"OfxPluginPropFilePath";
    /// Pointer, of an instance: the plugin's private data.
    INSTANCE_DATA = c"OfxPropInstanceData";
    /// Int: whether there is a user interface.
    IS_INTERACTIVE = c"OfxPropIsInteractive";
    /// Double: a time, in frames.
    TIME = c"OfxPropTime";
    /// String: the reason for a change.
    CHANGE_REASON = c"OfxPropChangeReason";
    /// Pointer, of an overlay: its effect instance.
    EFFECT_INSTANCE = c"OfxPropEffectInstance";
    /// Value of [`CHANGE_REASON`]: edited by the user.
    CHANGE_USER_EDITED = c"OfxChangeUserEdited";
    /// Value of [`CHANGE_REASON`]: edited by the plugin.
    CHANGE_PLUGIN_EDITED = c"OfxChangePluginEdited";
    /// Value of [`CHANGE_REASON`]: the current time changed.
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
