//! The Vulkan raster: offscreen float targets through ash; the loader is opened at run time.
