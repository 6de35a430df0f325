//! Action names: what a host asks an effect to do.
//!
//! In: nothing. Out: C strings; each documents its in and out arguments.

names! {
    /// The first action, after the library is loaded; without a handle.
    LOAD = c"OfxActionLoad";
    /// The last action, before the library is unloaded; without a handle.
    UNLOAD = c"OfxActionUnload";
    /// Describes the effect's capabilities. Also the first action of an overlay.
    DESCRIBE = c"OfxActionDescribe";
    /// Declares clips and parameters for one context (in: `image::CONTEXT`).
    DESCRIBE_IN_CONTEXT = c"OfxImageEffectActionDescribeInContext";
    /// Creates an instance of an effect or of an overlay.
    CREATE_INSTANCE = c"OfxActionCreateInstance";
    /// Destroys an instance.
    DESTROY_INSTANCE = c"OfxActionDestroyInstance";
    /// Begins a series of changes (in: reason).
    BEGIN_INSTANCE_CHANGED = c"OfxActionBeginInstanceChanged";
    /// A clip or parameter changed (in: type, name, reason, time, render scale).
    INSTANCE_CHANGED = c"OfxActionInstanceChanged";
    /// Ends a series of changes (in: reason).
    END_INSTANCE_CHANGED = c"OfxActionEndInstanceChanged";
    /// Memory is low: the effect should free its caches.
    PURGE_CACHES = c"OfxActionPurgeCaches";
    /// The instance is about to be saved: private data must be written to the parameters.
    SYNC_PRIVATE_DATA = c"OfxActionSyncPrivateData";
    /// The first editor window of an instance opens.
    BEGIN_INSTANCE_EDIT = c"OfxActionBeginInstanceEdit";
    /// The last editor window of an instance closes.
    END_INSTANCE_EDIT = c"OfxActionEndInstanceEdit";
    /// Computes the output's region of definition (in: time, render scale; out: four doubles, canonical).
    GET_REGION_OF_DEFINITION = c"OfxImageEffectActionGetRegionOfDefinition";
    /// Computes the region of each clip that a region of the output needs (in: time, render scale, region; out: four
    /// doubles per clip).
    GET_REGIONS_OF_INTEREST = c"OfxImageEffectActionGetRegionsOfInterest";
    /// Computes the time range of the output.
    GET_TIME_DOMAIN = c"OfxImageEffectActionGetTimeDomain";
    /// Computes the frames of each clip needed to render one frame.
    GET_FRAMES_NEEDED = c"OfxImageEffectActionGetFramesNeeded";
    /// Sets the output's components, bit depth and premultiplication (out).
    GET_CLIP_PREFERENCES = c"OfxImageEffectActionGetClipPreferences";
    /// Asks whether a clip may be passed through unchanged (in: time, field, window, scale; out: the clip's name and
    /// time).
    IS_IDENTITY = c"OfxImageEffectActionIsIdentity";
    /// Renders a window of the output (in: time, field, window, scale).
    RENDER = c"OfxImageEffectActionRender";
    /// Begins a sequence of renders.
    BEGIN_SEQUENCE_RENDER = c"OfxImageEffectActionBeginSequenceRender";
    /// Ends a sequence of renders.
    END_SEQUENCE_RENDER = c"OfxImageEffectActionEndSequenceRender";
}
