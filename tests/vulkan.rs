//! The Vulkan raster against the CPU twin and against its own promises; validation and synchronisation layers on.
//!
//! Without a driver the tests skip and say so; with `PINWARP_REQUIRE_VULKAN=1` they fail instead.

#[path = "vulkan/channels.rs"]
mod channels;
#[path = "support/compare.rs"]
mod compare;
#[path = "vulkan/devices.rs"]
mod devices;
#[path = "vulkan/limits.rs"]
mod limits;
#[path = "vulkan/mattes.rs"]
mod mattes;
#[path = "vulkan/memory.rs"]
mod memory;
#[path = "vulkan/passes.rs"]
mod passes;
#[path = "vulkan/pictures.rs"]
mod pictures;
#[path = "vulkan/remap.rs"]
mod remap;
#[path = "vulkan/stage.rs"]
mod stage;
#[path = "vulkan/support.rs"]
mod support;
