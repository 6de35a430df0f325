//! Types and properties of parameters, and the values they take.
//!
//! In: nothing. Out: names; each says its type and number of values.

names! {
    /// Type: one int.
    TYPE_INTEGER = c"OfxParamTypeInteger";
    /// Type: one double.
    TYPE_DOUBLE = c"OfxParamTypeDouble";
    /// Type: an int that is 0 or 1.
    TYPE_BOOLEAN = c"OfxParamTypeBoolean";
    /// Type: an int that counts options.
    TYPE_CHOICE = c"OfxParamTypeChoice";
    /// Type: two doubles.
    TYPE_DOUBLE_2D = c"OfxParamTypeDouble2D";
    /// Type: a string.
    TYPE_STRING = c"OfxParamTypeString";
    /// Type: a box around others; no value.
    TYPE_GROUP = c"OfxParamTypeGroup";
    /// Type: a page of others; no value.
    TYPE_PAGE = c"OfxParamTypePage";
    /// Type: a button; no value.
    TYPE_PUSH_BUTTON = c"OfxParamTypePushButton";
    /// String: the type of a parameter.
    TYPE = c"OfxParamPropType";
    /// The value before anyone touches it; of the parameter's own type and size.
    DEFAULT = c"OfxParamPropDefault";
    /// Least value.
    MIN = c"OfxParamPropMin";
    /// Greatest value.
    MAX = c"OfxParamPropMax";
    /// Least value of a slider.
    DISPLAY_MIN = c"OfxParamPropDisplayMin";
    /// Greatest value of a slider.
    DISPLAY_MAX = c"OfxParamPropDisplayMax";
    /// Double: step of a slider.
    INCREMENT = c"OfxParamPropIncrement";
    /// Int: digits after the point.
    DIGITS = c"OfxParamPropDigits";
    /// Int: it can have keys.
    ANIMATES = c"OfxParamPropAnimates";
    /// Int: it has some.
    IS_ANIMATING = c"OfxParamPropIsAnimating";
    /// Int: a change asks for a new render.
    EVALUATE_ON_CHANGE = c"OfxParamPropEvaluateOnChange";
    /// Int: the plugin itself may set it.
    PLUGIN_MAY_WRITE = c"OfxParamPropPluginMayWrite";
    /// Int: it is saved.
    PERSISTENT = c"OfxParamPropPersistant";
    /// Int: it is hidden.
    SECRET = c"OfxParamPropSecret";
    /// Int: the user may change it.
    ENABLED = c"OfxParamPropEnabled";
    /// String: what it is for.
    HINT = c"OfxParamPropHint";
    /// String: name for scripts.
    SCRIPT_NAME = c"OfxParamPropScriptName";
    /// String: the group it belongs to.
    PARENT = c"OfxParamPropParent";
    /// Int, of a group: it is shown open.
    GROUP_OPEN = c"OfxParamPropGroupOpen";
    /// Strings, of a page: what is on it.
    PAGE_CHILD = c"OfxParamPropPageChild";
    /// Strings, of a choice: what there is to choose.
    CHOICE_OPTION = c"OfxParamPropChoiceOption";
    /// String: what sort of string it is.
    STRING_MODE = c"OfxParamPropStringMode";
    /// Int, of a path: the file must be there.
    STRING_FILE_PATH_EXISTS = c"OfxParamPropStringFilePathExists";
    /// Value of [`STRING_MODE`]: a line.
    STRING_SINGLE_LINE = c"OfxParamStringIsSingleLine";
    /// Value of [`STRING_MODE`]: the path of a file.
    STRING_FILE_PATH = c"OfxParamStringIsFilePath";
    /// Value of [`STRING_MODE`]: the path of a folder.
    STRING_DIRECTORY_PATH = c"OfxParamStringIsDirectoryPath";
    /// String, of doubles: what the number means.
    DOUBLE_TYPE = c"OfxParamPropDoubleType";
    /// Value of [`DOUBLE_TYPE`]: just a number.
    DOUBLE_PLAIN = c"OfxParamDoubleTypePlain";
    /// Value of [`DOUBLE_TYPE`]: degrees.
    DOUBLE_ANGLE = c"OfxParamDoubleTypeAngle";
    /// Value of [`DOUBLE_TYPE`]: a factor.
    DOUBLE_SCALE = c"OfxParamDoubleTypeScale";
    /// Value of [`DOUBLE_TYPE`]: a canonical point; hosts may show a handle (API 1.2).
    DOUBLE_XY_ABSOLUTE = c"OfxParamDoubleTypeXYAbsolute";
    /// String, of canonical points: what their default is measured in.
    DEFAULT_COORDINATES = c"OfxParamPropDefaultCoordinateSystem";
    /// Value of [`DEFAULT_COORDINATES`]: canonical units.
    COORDINATES_CANONICAL = c"OfxParamCoordinatesCanonical";
    /// Value of [`DEFAULT_COORDINATES`]: 0 to 1 across the project.
    COORDINATES_NORMALISED = c"OfxParamCoordinatesNormalised";
    /// Int: the host is to show its own handle (spelled so in the API).
    USE_HOST_OVERLAY_HANDLE = c"kOfxParamPropUseHostOverlayHandle";
    /// Int: the host has one for this parameter.
    HAS_HOST_OVERLAY_HANDLE = c"OfxParamPropHasHostOverlayHandle";
    /// Int, of the host: choices can have keys.
    HOST_CHOICE_ANIMATION = c"OfxParamHostPropSupportsChoiceAnimation";
    /// Int, of the host: booleans can have keys.
    HOST_BOOLEAN_ANIMATION = c"OfxParamHostPropSupportsBooleanAnimation";
    /// Int, of the host: strings can have keys.
    HOST_STRING_ANIMATION = c"OfxParamHostPropSupportsStringAnimation";
    /// Int, of the host: how many parameters it takes; -1: any number.
    HOST_MAX_PARAMETERS = c"OfxParamHostPropMaxParameters";
    /// Strings, of an effect's description: order of its pages.
    PAGE_ORDER = c"OfxPluginPropParamPageOrder";
}
