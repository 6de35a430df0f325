//! Runs the stages over a frame range.
