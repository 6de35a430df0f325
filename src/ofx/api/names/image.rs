//! Properties of effects, clips and images, and their values.
//!
//! In: nothing. Out: C strings; each documents its type and number of values.

names! {
    /// Clip name: the input picture.
    SOURCE_CLIP = c"Source";
    /// Clip name: the output.
    OUTPUT_CLIP = c"Output";
    /// String: the context of an instance or of a description.
    CONTEXT = c"OfxImageEffectPropContext";
    /// Strings, of an effect: the contexts it supports.
    SUPPORTED_CONTEXTS = c"OfxImageEffectPropSupportedContexts";
    /// Context: one input, one output.
    CONTEXT_FILTER = c"OfxImageEffectContextFilter";
    /// Context: any clips.
    CONTEXT_GENERAL = c"OfxImageEffectContextGeneral";
    /// String, of an effect: its menu group.
    GROUPING = c"OfxImageEffectPluginPropGrouping";
    /// Int, of an effect: whether at most one instance may exist.
    SINGLE_INSTANCE = c"OfxImageEffectPluginPropSingleInstance";
    /// Int: whether the host may split one frame over several threads.
    HOST_FRAME_THREADING = c"OfxImageEffectPluginPropHostFrameThreading";
    /// String: the thread safety of renders.
    RENDER_THREAD_SAFETY = c"OfxImageEffectPluginRenderThreadSafety";
    /// Value of [`RENDER_THREAD_SAFETY`]: one render at a time over all instances.
    RENDER_UNSAFE = c"OfxImageEffectRenderUnsafe";
    /// Value of [`RENDER_THREAD_SAFETY`]: one render at a time per instance.
    RENDER_INSTANCE_SAFE = c"OfxImageEffectRenderInstanceSafe";
    /// Value of [`RENDER_THREAD_SAFETY`]: any number of concurrent renders.
    RENDER_FULLY_SAFE = c"OfxImageEffectRenderFullySafe";
    /// Int, of hosts, effects and clips: whether tiles are supported.
    SUPPORTS_TILES = c"OfxImageEffectPropSupportsTiles";
    /// Int, of hosts and effects: whether images of different sizes and origins are supported.
    SUPPORTS_MULTI_RESOLUTION = c"OfxImageEffectPropSupportsMultiResolution";
    /// Int, of hosts, effects and clips: whether frames at other times than the current one are accessed.
    TEMPORAL_CLIP_ACCESS = c"OfxImageEffectPropTemporalClipAccess";
    /// Int: whether clips may differ in bit depth.
    SUPPORTS_MULTIPLE_CLIP_DEPTHS = c"OfxImageEffectPropMultipleClipDepths";
    /// Int: whether clips may differ in pixel aspect ratio.
    SUPPORTS_MULTIPLE_CLIP_PARS = c"OfxImageEffectPropSupportsMultipleClipPARs";
    /// Int, of an effect: whether each field of interlaced material is rendered, even where nothing moves.
    FIELD_RENDER_TWICE_ALWAYS = c"OfxImageEffectPluginPropFieldRenderTwiceAlways";
    /// Strings: the bit depths that a host or effect supports.
    SUPPORTED_PIXEL_DEPTHS = c"OfxImageEffectPropSupportedPixelDepths";
    /// Strings: the components that a host or clip supports.
    SUPPORTED_COMPONENTS = c"OfxImageEffectPropSupportedComponents";
    /// Strings, of an effect: the parameters that affect the clip preferences.
    CLIP_PREFERENCES_SLAVE_PARAM = c"OfxImageEffectPropClipPreferencesSlaveParam";
    /// Int, of an action's out arguments: whether the output varies with time even if no parameter does.
    FRAME_VARYING = c"OfxImageEffectFrameVarying";
    /// Int, of the host: whether it supports overlays.
    SUPPORTS_OVERLAYS = c"OfxImageEffectPropSupportsOverlays";
    /// Pointer, of an effect: entry point of its overlay, drawn with OpenGL.
    OVERLAY_INTERACT_V1 = c"OfxImageEffectPluginPropOverlayInteractV1";
    /// Pointer, of an effect: entry point of its overlay, drawn with the Draw suite.
    OVERLAY_INTERACT_V2 = c"OfxImageEffectPluginPropOverlayInteractV2";
    /// Int, of a clip: whether it may be left unconnected.
    CLIP_OPTIONAL = c"OfxImageClipPropOptional";
    /// Int, of a clip: whether it is a mask.
    CLIP_IS_MASK = c"OfxImageClipPropIsMask";
    /// Int, of a clip: whether it is connected.
    CLIP_CONNECTED = c"OfxImageClipPropConnected";
    /// String, of a clip: how fields are extracted from it.
    CLIP_FIELD_EXTRACTION = c"OfxImageClipPropFieldExtraction";
    /// String, of a clip: which field comes first.
    CLIP_FIELD_ORDER = c"OfxImageClipPropFieldOrder";
    /// String, of clips and images: bit depth of a component.
    PIXEL_DEPTH = c"OfxImageEffectPropPixelDepth";
    /// String, of clips and images: the components of a pixel.
    COMPONENTS = c"OfxImageEffectPropComponents";
    /// String, of clips and images: the premultiplication state.
    PREMULTIPLICATION = c"OfxImageEffectPropPreMultiplication";
    /// Double, of clips and images: pixel aspect ratio, width / height.
    PIXEL_ASPECT = c"OfxImagePropPixelAspectRatio";
    /// Double: frames per second.
    FRAME_RATE = c"OfxImageEffectPropFrameRate";
    /// Doubles (2), of a clip: first and last frame.
    FRAME_RANGE = c"OfxImageEffectPropFrameRange";
    /// Doubles (2): rendered pixels per pixel at full size.
    RENDER_SCALE = c"OfxImageEffectPropRenderScale";
    /// Ints (4): the pixels to render.
    RENDER_WINDOW = c"OfxImageEffectPropRenderWindow";
    /// String: the field to render.
    FIELD_TO_RENDER = c"OfxImageEffectPropFieldToRender";
    /// Doubles (4), canonical: the region of definition.
    REGION_OF_DEFINITION = c"OfxImageEffectPropRegionOfDefinition";
    /// Doubles (4), canonical: the requested region.
    REGION_OF_INTEREST = c"OfxImageEffectPropRegionOfInterest";
    /// Prefix, completed by a clip's name; doubles (4): its region of interest.
    CLIP_ROI_PREFIX = c"OfxImageClipPropRoI_";
    /// Prefix, completed by a clip's name; string: its components.
    CLIP_COMPONENTS_PREFIX = c"OfxImageClipPropComponents_";
    /// Prefix, completed by a clip's name; string: its bit depth.
    CLIP_DEPTH_PREFIX = c"OfxImageClipPropDepth_";
    /// Prefix, completed by a clip's name; double: its pixel aspect ratio.
    CLIP_PAR_PREFIX = c"OfxImageClipPropPAR_";
    /// Doubles (2), of an instance, canonical: size of the project's picture.
    PROJECT_SIZE = c"OfxImageEffectPropProjectSize";
    /// Doubles (2), of an instance, canonical: lower left corner of the project's picture.
    PROJECT_OFFSET = c"OfxImageEffectPropProjectOffset";
    /// Doubles (2), of an instance, canonical: upper right corner of the project's canvas.
    PROJECT_EXTENT = c"OfxImageEffectPropProjectExtent";
    /// Double, of an instance: pixel aspect ratio of the project.
    PROJECT_PIXEL_ASPECT = c"OfxImageEffectPropPixelAspectRatio";
    /// Double, of an instance: its duration in frames.
    EFFECT_DURATION = c"OfxImageEffectInstancePropEffectDuration";
    /// Pointer, of an image: its lower left pixel.
    DATA = c"OfxImagePropData";
    /// Ints (4), of an image: the pixels it holds.
    BOUNDS = c"OfxImagePropBounds";
    /// Ints (4), of an image: its region of definition in pixels.
    IMAGE_REGION_OF_DEFINITION = c"OfxImagePropRegionOfDefinition";
    /// Int, of an image: bytes from a row to the next one above; may be negative.
    ROW_BYTES = c"OfxImagePropRowBytes";
    /// String, of an image: the fields it holds.
    FIELD = c"OfxImagePropField";
    /// String, of an image: a unique identifier.
    UNIQUE_IDENTIFIER = c"OfxImagePropUniqueIdentifier";
    /// Bit depth: the clip is unconnected.
    DEPTH_NONE = c"OfxBitDepthNone";
    /// Bit depth: 8-bit unsigned integers.
    DEPTH_BYTE = c"OfxBitDepthByte";
    /// Bit depth: 16-bit unsigned integers.
    DEPTH_SHORT = c"OfxBitDepthShort";
    /// Bit depth: 16-bit floats.
    DEPTH_HALF = c"OfxBitDepthHalf";
    /// Bit depth: 32-bit floats.
    DEPTH_FLOAT = c"OfxBitDepthFloat";
    /// Components: the clip is unconnected.
    COMPONENT_NONE = c"OfxImageComponentNone";
    /// Components: red, green, blue, alpha.
    COMPONENT_RGBA = c"OfxImageComponentRGBA";
    /// Components: red, green, blue.
    COMPONENT_RGB = c"OfxImageComponentRGB";
    /// Components: alpha.
    COMPONENT_ALPHA = c"OfxImageComponentAlpha";
    /// Premultiplication: opaque, alpha is ignored.
    OPAQUE = c"OfxImageOpaque";
    /// Premultiplication: colour is premultiplied by alpha.
    PREMULTIPLIED = c"OfxImageAlphaPremultiplied";
    /// Premultiplication: colour is straight.
    UNPREMULTIPLIED = c"OfxImageAlphaUnPremultiplied";
    /// Field: none, whole frames.
    FIELD_NONE = c"OfxFieldNone";
    /// Field: lower, rows 0, 2, 4.
    FIELD_LOWER = c"OfxFieldLower";
    /// Field: upper, rows 1, 3, 5.
    FIELD_UPPER = c"OfxFieldUpper";
    /// Field: both, interlaced.
    FIELD_BOTH = c"OfxFieldBoth";
    /// Field extraction: a single field, at half the height.
    FIELD_SINGLE = c"OfxFieldSingle";
    /// Field extraction: a single field, each row doubled.
    FIELD_DOUBLED = c"OfxFieldDoubled";
}
