//! The CPU twin: draws what the Vulkan raster draws, in safe Rust, in tiles over all cores.
