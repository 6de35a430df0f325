//! Properties of effects, clips and images, and the values they take.
//!
//! In: nothing. Out: names; each says its type and number of values.

names! {
    /// Clip name: the picture that is worked on.
    SOURCE_CLIP = c"Source";
    /// Clip name: the result.
    OUTPUT_CLIP = c"Output";
    /// String: the context of an instance, or of the description.
    CONTEXT = c"OfxImageEffectPropContext";
    /// Strings, of an effect: contexts it works in.
    SUPPORTED_CONTEXTS = c"OfxImageEffectPropSupportedContexts";
    /// Context: one picture in, one out.
    CONTEXT_FILTER = c"OfxImageEffectContextFilter";
    /// Context: any clips.
    CONTEXT_GENERAL = c"OfxImageEffectContextGeneral";
    /// String, of an effect: its place in menus.
    GROUPING = c"OfxImageEffectPluginPropGrouping";
    /// Int, of an effect: at most one instance.
    SINGLE_INSTANCE = c"OfxImageEffectPluginPropSingleInstance";
    /// Int: the host may share out one frame over threads.
    HOST_FRAME_THREADING = c"OfxImageEffectPluginPropHostFrameThreading";
    /// String: how renders may run side by side.
    RENDER_THREAD_SAFETY = c"OfxImageEffectPluginRenderThreadSafety";
    /// Value of [`RENDER_THREAD_SAFETY`]: one render at a time, of all instances.
    RENDER_UNSAFE = c"OfxImageEffectRenderUnsafe";
    /// Value of [`RENDER_THREAD_SAFETY`]: one render at a time in an instance.
    RENDER_INSTANCE_SAFE = c"OfxImageEffectRenderInstanceSafe";
    /// Value of [`RENDER_THREAD_SAFETY`]: any number.
    RENDER_FULLY_SAFE = c"OfxImageEffectRenderFullySafe";
    /// Int, of hosts, effects and clips: pieces of pictures are welcome.
    SUPPORTS_TILES = c"OfxImageEffectPropSupportsTiles";
    /// Int, of hosts and effects: pictures of several sizes and origins are.
    SUPPORTS_MULTI_RESOLUTION = c"OfxImageEffectPropSupportsMultiResolution";
    /// Int, of hosts, effects and clips: other times than the current one are looked at.
    TEMPORAL_CLIP_ACCESS = c"OfxImageEffectPropTemporalClipAccess";
    /// Int: clips may differ in depth.
    SUPPORTS_MULTIPLE_CLIP_DEPTHS = c"OfxImageEffectPropMultipleClipDepths";
    /// Int: clips may differ in pixel aspect.
    SUPPORTS_MULTIPLE_CLIP_PARS = c"OfxImageEffectPropSupportsMultipleClipPARs";
    /// Int, of an effect: render each field of fielded material, even where nothing moves.
    FIELD_RENDER_TWICE_ALWAYS = c"OfxImageEffectPluginPropFieldRenderTwiceAlways";
    /// Strings: depths that hosts and effects know.
    SUPPORTED_PIXEL_DEPTHS = c"OfxImageEffectPropSupportedPixelDepths";
    /// Strings: components that hosts and clips know.
    SUPPORTED_COMPONENTS = c"OfxImageEffectPropSupportedComponents";
    /// Strings, of an effect: parameters that the clip preferences depend on.
    CLIP_PREFERENCES_SLAVE_PARAM = c"OfxImageEffectPropClipPreferencesSlaveParam";
    /// Int, of an effect's argument: the output varies with time by itself.
    FRAME_VARYING = c"OfxImageEffectFrameVarying";
    /// Int, of the host: there are overlays.
    SUPPORTS_OVERLAYS = c"OfxImageEffectPropSupportsOverlays";
    /// Pointer, of an effect: entry of its overlay, drawn with OpenGL.
    OVERLAY_INTERACT_V1 = c"OfxImageEffectPluginPropOverlayInteractV1";
    /// Pointer, of an effect: entry of its overlay, drawn with the Draw suite.
    OVERLAY_INTERACT_V2 = c"OfxImageEffectPluginPropOverlayInteractV2";
    /// Int, of a clip: it may be left unconnected.
    CLIP_OPTIONAL = c"OfxImageClipPropOptional";
    /// Int, of a clip: it is a mask.
    CLIP_IS_MASK = c"OfxImageClipPropIsMask";
    /// Int, of a clip: there is something at its other end.
    CLIP_CONNECTED = c"OfxImageClipPropConnected";
    /// String, of a clip: how fields are taken out of it.
    CLIP_FIELD_EXTRACTION = c"OfxImageClipPropFieldExtraction";
    /// String, of a clip: which field comes first.
    CLIP_FIELD_ORDER = c"OfxImageClipPropFieldOrder";
    /// String, of clips and images: depth of a value.
    PIXEL_DEPTH = c"OfxImageEffectPropPixelDepth";
    /// String, of clips and images: what a pixel holds.
    COMPONENTS = c"OfxImageEffectPropComponents";
    /// String, of clips and images: how colour and alpha go together.
    PREMULTIPLICATION = c"OfxImageEffectPropPreMultiplication";
    /// Double, of clips and images: width of a pixel / its height.
    PIXEL_ASPECT = c"OfxImagePropPixelAspectRatio";
    /// Double: frames a second.
    FRAME_RATE = c"OfxImageEffectPropFrameRate";
    /// Doubles (2), of a clip: first and last frame.
    FRAME_RANGE = c"OfxImageEffectPropFrameRange";
    /// Doubles (2): pixels rendered per pixel at full size.
    RENDER_SCALE = c"OfxImageEffectPropRenderScale";
    /// Ints (4): the pixels to draw.
    RENDER_WINDOW = c"OfxImageEffectPropRenderWindow";
    /// String: the field to draw.
    FIELD_TO_RENDER = c"OfxImageEffectPropFieldToRender";
    /// Doubles (4), canonical: where there is output.
    REGION_OF_DEFINITION = c"OfxImageEffectPropRegionOfDefinition";
    /// Doubles (4), canonical: what is asked for.
    REGION_OF_INTEREST = c"OfxImageEffectPropRegionOfInterest";
    /// Beginning of the names, one a clip, of doubles (4): what is needed of it.
    CLIP_ROI_PREFIX = c"OfxImageClipPropRoI_";
    /// Beginning of the names, one a clip, of a string: its components.
    CLIP_COMPONENTS_PREFIX = c"OfxImageClipPropComponents_";
    /// Beginning of the names, one a clip, of a string: its depth.
    CLIP_DEPTH_PREFIX = c"OfxImageClipPropDepth_";
    /// Beginning of the names, one a clip, of a double: its pixel aspect.
    CLIP_PAR_PREFIX = c"OfxImageClipPropPAR_";
    /// Doubles (2), of an instance, canonical: the project's picture.
    PROJECT_SIZE = c"OfxImageEffectPropProjectSize";
    /// Doubles (2), of an instance, canonical: lower left corner of that picture.
    PROJECT_OFFSET = c"OfxImageEffectPropProjectOffset";
    /// Doubles (2), of an instance, canonical: upper right corner of the project's canvas.
    PROJECT_EXTENT = c"OfxImageEffectPropProjectExtent";
    /// Double, of an instance: pixel aspect of the project.
    PROJECT_PIXEL_ASPECT = c"OfxImageEffectPropPixelAspectRatio";
    /// Double, of an instance: how many frames it lasts.
    EFFECT_DURATION = c"OfxImageEffectInstancePropEffectDuration";
    /// Pointer, of an image: the pixel at its lower left corner.
    DATA = c"OfxImagePropData";
    /// Ints (4), of an image: its pixels.
    BOUNDS = c"OfxImagePropBounds";
    /// Ints (4), of an image: the pixels it could have.
    IMAGE_REGION_OF_DEFINITION = c"OfxImagePropRegionOfDefinition";
    /// Int, of an image: bytes from a row to the next above; may be negative.
    ROW_BYTES = c"OfxImagePropRowBytes";
    /// String, of an image: its fields.
    FIELD = c"OfxImagePropField";
    /// String, of an image: unlike that of any other.
    UNIQUE_IDENTIFIER = c"OfxImagePropUniqueIdentifier";
    /// Depth: nothing is connected.
    DEPTH_NONE = c"OfxBitDepthNone";
    /// Depth: 8 bits.
    DEPTH_BYTE = c"OfxBitDepthByte";
    /// Depth: 16 bits.
    DEPTH_SHORT = c"OfxBitDepthShort";
    /// Depth: 16-bit floats.
    DEPTH_HALF = c"OfxBitDepthHalf";
    /// Depth: 32-bit floats.
    DEPTH_FLOAT = c"OfxBitDepthFloat";
    /// Components: nothing is connected.
    COMPONENT_NONE = c"OfxImageComponentNone";
    /// Components: red, green, blue, alpha.
    COMPONENT_RGBA = c"OfxImageComponentRGBA";
    /// Components: red, green, blue.
    COMPONENT_RGB = c"OfxImageComponentRGB";
    /// Components: alpha.
    COMPONENT_ALPHA = c"OfxImageComponentAlpha";
    /// Premultiplication: there is no alpha to speak of.
    OPAQUE = c"OfxImageOpaque";
    /// Premultiplication: colour is multiplied by alpha.
    PREMULTIPLIED = c"OfxImageAlphaPremultiplied";
    /// Premultiplication: it is not.
    UNPREMULTIPLIED = c"OfxImageAlphaUnPremultiplied";
    /// Field: whole frames.
    FIELD_NONE = c"OfxFieldNone";
    /// Field: rows 0, 2, 4.
    FIELD_LOWER = c"OfxFieldLower";
    /// Field: rows 1, 3, 5.
    FIELD_UPPER = c"OfxFieldUpper";
    /// Field: both, interlaced.
    FIELD_BOTH = c"OfxFieldBoth";
    /// Field extraction: one field, at half the height.
    FIELD_SINGLE = c"OfxFieldSingle";
    /// Field extraction: one field, each row twice.
    FIELD_DOUBLED = c"OfxFieldDoubled";
}
