//! Actions and properties of overlays.
//!
//! In: nothing. Out: C strings; each documents its type and number of values.

names! {
    /// Draws the overlay (in: effect, pixel scale, time, render scale, optionally a draw context).
    DRAW = c"OfxInteractActionDraw";
    /// The pen moved, pressed or not (in: as for drawing, and its position).
    PEN_MOTION = c"OfxInteractActionPenMotion";
    /// The pen was pressed.
    PEN_DOWN = c"OfxInteractActionPenDown";
    /// The pen was released.
    PEN_UP = c"OfxInteractActionPenUp";
    /// A key was pressed (in: effect, key, time, render scale).
    KEY_DOWN = c"OfxInteractActionKeyDown";
    /// A key was released.
    KEY_UP = c"OfxInteractActionKeyUp";
    /// A key repeats while it is held.
    KEY_REPEAT = c"OfxInteractActionKeyRepeat";
    /// The overlay gained input focus.
    GAIN_FOCUS = c"OfxInteractActionGainFocus";
    /// The overlay lost input focus.
    LOSE_FOCUS = c"OfxInteractActionLoseFocus";
    /// Strings, of an overlay: the parameters whose changes trigger a redraw.
    SLAVE_TO_PARAM = c"OfxInteractPropSlaveToParam";
    /// Doubles (2): canonical size of a screen pixel.
    PIXEL_SCALE = c"OfxInteractPropPixelScale";
    /// Doubles (3): the viewer's background colour.
    BACKGROUND_COLOUR = c"OfxInteractPropBackgroundColour";
    /// Doubles (3): the colour that the host suggests for overlays.
    SUGGESTED_COLOUR = c"OfxInteractPropSuggestedColour";
    /// Doubles (2): the pen's position, canonical.
    PEN_POSITION = c"OfxInteractPropPenPosition";
    /// Double: the pen's pressure, 0 to 1.
    PEN_PRESSURE = c"OfxInteractPropPenPressure";
    /// Pointer, of the draw action: the context of the Draw suite.
    DRAW_CONTEXT = c"OfxInteractPropDrawContext";
    /// Int: the key as an X11 keysym (the API spells the name so).
    KEY_SYM = c"kOfxPropKeySym";
    /// String: the key as text (the API spells the name so).
    KEY_STRING = c"kOfxPropKeyString";
}

/// Value of [`KEY_SYM`]: Escape.
pub(crate) const KEY_ESCAPE: i32 = 0xFF1B;
/// Value of [`KEY_SYM`]: Backspace.
pub(crate) const KEY_BACKSPACE: i32 = 0xFF08;
/// Value of [`KEY_SYM`]: Delete.
pub(crate) const KEY_DELETE: i32 = 0xFFFF;
/// Value of [`KEY_SYM`]: "r".
pub(crate) const KEY_R: i32 = 0x72;
/// Value of [`KEY_SYM`]: "[".
pub(crate) const KEY_BRACKET_LEFT: i32 = 0x5B;
/// Value of [`KEY_SYM`]: "]".
pub(crate) const KEY_BRACKET_RIGHT: i32 = 0x5D;
/// Value of [`KEY_SYM`]: the left Shift key.
pub(crate) const KEY_SHIFT_LEFT: i32 = 0xFFE1;
/// Value of [`KEY_SYM`]: the right Shift key.
pub(crate) const KEY_SHIFT_RIGHT: i32 = 0xFFE2;
