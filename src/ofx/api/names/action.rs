//! Actions: what the host asks an effect to do.
//!
//! In: nothing. Out: the names; each says whether arguments come with it.

names! {
    /// First of all; no handle.
    LOAD = c"OfxActionLoad";
    /// Last of all; no handle.
    UNLOAD = c"OfxActionUnload";
    /// Says what the effect can do. Also the first action of an overlay.
    DESCRIBE = c"OfxActionDescribe";
    /// Declares clips and parameters for one context (in: `image::CONTEXT`).
    DESCRIBE_IN_CONTEXT = c"OfxImageEffectActionDescribeInContext";
    /// An instance (of an effect, of an overlay) begins.
    CREATE_INSTANCE = c"OfxActionCreateInstance";
    /// An instance ends.
    DESTROY_INSTANCE = c"OfxActionDestroyInstance";
    /// A run of changes begins (in: reason).
    BEGIN_INSTANCE_CHANGED = c"OfxActionBeginInstanceChanged";
    /// A clip or a parameter changed (in: type, name, reason, time, render scale).
    INSTANCE_CHANGED = c"OfxActionInstanceChanged";
    /// A run of changes ends (in: reason).
    END_INSTANCE_CHANGED = c"OfxActionEndInstanceChanged";
    /// Memory is short.
    PURGE_CACHES = c"OfxActionPurgeCaches";
    /// The instance is about to be saved: parameters must hold all.
    SYNC_PRIVATE_DATA = c"OfxActionSyncPrivateData";
    /// The first window on an instance opens.
    BEGIN_INSTANCE_EDIT = c"OfxActionBeginInstanceEdit";
    /// The last window on an instance closes.
    END_INSTANCE_EDIT = c"OfxActionEndInstanceEdit";
    /// Where the output has pixels (in: time, render scale; out: four doubles, canonical).
    GET_REGION_OF_DEFINITION = c"OfxImageEffectActionGetRegionOfDefinition";
    /// What of each clip is needed for a part of the output (in: time, render scale, that part; out: four doubles a clip).
    GET_REGIONS_OF_INTEREST = c"OfxImageEffectActionGetRegionsOfInterest";
    /// The times at which there is output.
    GET_TIME_DOMAIN = c"OfxImageEffectActionGetTimeDomain";
    /// The frames of each clip that one frame needs.
    GET_FRAMES_NEEDED = c"OfxImageEffectActionGetFramesNeeded";
    /// Components, depth, premultiplication of the output (out).
    GET_CLIP_PREFERENCES = c"OfxImageEffectActionGetClipPreferences";
    /// Whether a clip may be passed on as it is (in: time, field, window, scale; out: the clip's name, its time).
    IS_IDENTITY = c"OfxImageEffectActionIsIdentity";
    /// Draws a window of the output (in: time, field, window, scale).
    RENDER = c"OfxImageEffectActionRender";
    /// A run of renders begins.
    BEGIN_SEQUENCE_RENDER = c"OfxImageEffectActionBeginSequenceRender";
    /// A run of renders ends.
    END_SEQUENCE_RENDER = c"OfxImageEffectActionEndSequenceRender";
}
