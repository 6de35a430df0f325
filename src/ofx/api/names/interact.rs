//! Actions and properties of overlays.
//!
//! In: nothing. Out: names; each says its type and number of values.

names! {
    /// Draws (in: effect, pixel scale, time, render scale, perhaps a draw context).
    DRAW = c"OfxInteractActionDraw";
    /// The pen moved, up or down (in: as for drawing, and where it is).
    PEN_MOTION = c"OfxInteractActionPenMotion";
    /// The pen went down.
    PEN_DOWN = c"OfxInteractActionPenDown";
    /// The pen went up.
    PEN_UP = c"OfxInteractActionPenUp";
    /// A key went down (in: effect, key, time, render scale).
    KEY_DOWN = c"OfxInteractActionKeyDown";
    /// A key went up.
    KEY_UP = c"OfxInteractActionKeyUp";
    /// A key is held.
    KEY_REPEAT = c"OfxInteractActionKeyRepeat";
    /// The overlay is listened to.
    GAIN_FOCUS = c"OfxInteractActionGainFocus";
    /// It no longer is.
    LOSE_FOCUS = c"OfxInteractActionLoseFocus";
    /// Strings, of an overlay: parameters whose changes call for drawing.
    SLAVE_TO_PARAM = c"OfxInteractPropSlaveToParam";
    /// Doubles (2): canonical size of a pixel of the screen.
    PIXEL_SCALE = c"OfxInteractPropPixelScale";
    /// Doubles (3): colour behind the picture.
    BACKGROUND_COLOUR = c"OfxInteractPropBackgroundColour";
    /// Doubles (3): colour that the host suggests for overlays.
    SUGGESTED_COLOUR = c"OfxInteractPropSuggestedColour";
    /// Doubles (2): the pen, canonical.
    PEN_POSITION = c"OfxInteractPropPenPosition";
    /// Double: how hard it is pressed, 0 to 1.
    PEN_PRESSURE = c"OfxInteractPropPenPressure";
    /// Pointer, in the draw action: where the Draw suite draws.
    DRAW_CONTEXT = c"OfxInteractPropDrawContext";
    /// Int: the key (spelled so in the API), as X11 counts keys.
    KEY_SYM = c"kOfxPropKeySym";
    /// String: the key as text (spelled so in the API).
    KEY_STRING = c"kOfxPropKeyString";
}

/// Value of [`KEY_SYM`]: Escape.
pub const KEY_ESCAPE: i32 = 0xFF1B;
/// Value of [`KEY_SYM`]: Backspace.
pub const KEY_BACKSPACE: i32 = 0xFF08;
/// Value of [`KEY_SYM`]: Delete.
pub const KEY_DELETE: i32 = 0xFFFF;
/// Value of [`KEY_SYM`]: "r".
pub const KEY_R: i32 = 0x72;
/// Value of [`KEY_SYM`]: "[".
pub const KEY_BRACKET_LEFT: i32 = 0x5B;
/// Value of [`KEY_SYM`]: "]".
pub const KEY_BRACKET_RIGHT: i32 = 0x5D;
/// Value of [`KEY_SYM`]: the left Shift key.
pub const KEY_SHIFT_LEFT: i32 = 0xFFE1;
/// Value of [`KEY_SYM`]: the right Shift key.
pub const KEY_SHIFT_RIGHT: i32 = 0xFFE2;
