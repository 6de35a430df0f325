//! Types and properties of parameters, and their values.
//!
//! In: nothing. Out: C strings; each documents its type and number of values.

names! {
    /// Type: one int.
    TYPE_INTEGER = c"OfxParamTypeInteger";
    /// Type: one double.
    TYPE_DOUBLE = c"OfxParamTypeDouble";
    /// Type: an int that is 0 or 1.
    TYPE_BOOLEAN = c"OfxParamTypeBoolean";
    /// Type: an int, the index of an option.
    TYPE_CHOICE = c"OfxParamTypeChoice";
    /// Type: two doubles.
    TYPE_DOUBLE_2D = c"OfxParamTypeDouble2D";
    /// Type: a string.
    TYPE_STRING = c"OfxParamTypeString";
    /// Type: a group of parameters; no value.
    TYPE_GROUP = c"OfxParamTypeGroup";
    /// Type: a page of parameters; no value.
    TYPE_PAGE = c"OfxParamTypePage";
    /// Type: a button; no value.
    TYPE_PUSH_BUTTON = c"OfxParamTypePushButton";
    /// String: the type of a parameter.
    TYPE = c"OfxParamPropType";
    /// The default value, of the parameter's own type and dimension.
    DEFAULT = c"OfxParamPropDefault";
    /// The minimum value.
    MIN = c"OfxParamPropMin";
    /// The maximum value.
    MAX = c"OfxParamPropMax";
    /// The minimum of the slider.
    DISPLAY_MIN = c"OfxParamPropDisplayMin";
    /// The maximum of the slider.
    DISPLAY_MAX = c"OfxParamPropDisplayMax";
    /// Double: the increment of the slider.
    INCREMENT = c"OfxParamPropIncrement";
    /// Int: digits after the decimal point.
    DIGITS = c"OfxParamPropDigits";
    /// Int: whether it can be animated.
    ANIMATES = c"OfxParamPropAnimates";
    /// Int: whether it is animated.
    IS_ANIMATING = c"OfxParamPropIsAnimating";
    /// Int: whether a change triggers a new render.
    EVALUATE_ON_CHANGE = c"OfxParamPropEvaluateOnChange";
    /// Int: whether the plugin itself may set it.
    PLUGIN_MAY_WRITE = c"OfxParamPropPluginMayWrite";
    /// Int: whether it is saved.
    PERSISTENT = c"OfxParamPropPersistant";
    /// Int: whether it is hidden.
    SECRET = c"OfxParamPropSecret";
    /// Int: whether the user may change it.
    ENABLED = c"OfxParamPropEnabled";
    /// String: the tooltip.
    HINT = c"OfxParamPropHint";
    /// String: the name used in scripts.
    SCRIPT_NAME = c"OfxParamPropScriptName";
    /// String: the group it belongs to.
    PARENT = c"OfxParamPropParent";
    /// Int, of a group: whether it is shown open.
    GROUP_OPEN = c"OfxParamPropGroupOpen";
    /// Strings, of a page: its parameters.
    PAGE_CHILD = c"OfxParamPropPageChild";
    /// Strings, of a choice: its options.
    CHOICE_OPTION = c"OfxParamPropChoiceOption";
    /// String: the kind of string.
    STRING_MODE = c"OfxParamPropStringMode";
    /// Int, of a path: whether the file must exist.
    STRING_FILE_PATH_EXISTS = c"OfxParamPropStringFilePathExists";
    /// Value of [`STRING_MODE`]: a single line of text.
    STRING_SINGLE_LINE = c"OfxParamStringIsSingleLine";
    /// Value of [`STRING_MODE`]: a file path.
    STRING_FILE_PATH = c"OfxParamStringIsFilePath";
    /// Value of [`STRING_MODE`]: a directory path.
    STRING_DIRECTORY_PATH = c"OfxParamStringIsDirectoryPath";
    /// String, of doubles: the meaning of the value.
    DOUBLE_TYPE = c"OfxParamPropDoubleType";
    /// Value of [`DOUBLE_TYPE`]: a plain number.
    DOUBLE_PLAIN = c"OfxParamDoubleTypePlain";
    /// Value of [`DOUBLE_TYPE`]: an angle in degrees.
    DOUBLE_ANGLE = c"OfxParamDoubleTypeAngle";
    /// Value of [`DOUBLE_TYPE`]: a scale factor.
    DOUBLE_SCALE = c"OfxParamDoubleTypeScale";
    /// Value of [`DOUBLE_TYPE`]: a position in canonical coordinates; hosts may show a handle (API 1.2).
    DOUBLE_XY_ABSOLUTE = c"OfxParamDoubleTypeXYAbsolute";
    /// String, of positions: the coordinate system of their default.
    DEFAULT_COORDINATES = c"OfxParamPropDefaultCoordinateSystem";
    /// Value of [`DEFAULT_COORDINATES`]: canonical coordinates.
    COORDINATES_CANONICAL = c"OfxParamCoordinatesCanonical";
    /// Value of [`DEFAULT_COORDINATES`]: 0 to 1 across the project.
    COORDINATES_NORMALISED = c"OfxParamCoordinatesNormalised";
    /// Int: whether the host should show its own handle (the API spells the name so).
    USE_HOST_OVERLAY_HANDLE = c"kOfxParamPropUseHostOverlayHandle";
    /// Int: whether the host has a handle for this parameter.
    HAS_HOST_OVERLAY_HANDLE = c"OfxParamPropHasHostOverlayHandle";
    /// Int, of the host: whether choices can be animated.
    HOST_CHOICE_ANIMATION = c"OfxParamHostPropSupportsChoiceAnimation";
    /// Int, of the host: whether booleans can be animated.
    HOST_BOOLEAN_ANIMATION = c"OfxParamHostPropSupportsBooleanAnimation";
    /// Int, of the host: whether strings can be animated.
    HOST_STRING_ANIMATION = c"OfxParamHostPropSupportsStringAnimation";
    /// Int, of the host: the maximum number of parameters; -1: unlimited.
    HOST_MAX_PARAMETERS = c"OfxParamHostPropMaxParameters";
    /// Strings, of an effect's descriptor: the order of its pages.
    PAGE_ORDER = c"OfxPluginPropParamPageOrder";
}
