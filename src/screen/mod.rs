//! Stage 3: a pose seen through a camera becomes a mesh of screen space.
