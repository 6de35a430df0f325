//! The Utah teapot as Martin Newell measured it in 1975: bicubic Bézier patches, in their published symmetric form.
//!
//! x points to the spout, z is the height, y = 0 is the plane of symmetry. Lid, rim, body and bottom are repeated four
//! times around the axis, handle and spout twice: 2·4 + 1·4 + 2·4 + 1·4 + 2·2 + 2·2 = 32 patches.

/// A circle of control points: radius, the radius times Newell's 0.56 (control arm of a quarter circle; 0.45 at the
/// knob, as published), height.
pub(crate) type Ring = [f64; 3];

/// Rings of the pot, from the rim down to the centre of the bottom; four per patch, of which neighbouring patches share
/// one.
pub(crate) const POT: [Ring; 13] = [
    [1.4, 0.784, 2.4],
    [1.3375, 0.749, 2.53125],
    [1.4375, 0.805, 2.53125],
    [1.5, 0.84, 2.4],
    [1.75, 0.98, 1.875],
    [2.0, 1.12, 1.35],
    [2.0, 1.12, 0.9],
    [2.0, 1.12, 0.45],
    [1.5, 0.84, 0.225],
    [1.5, 0.84, 0.15],
    [1.5, 0.84, 0.075],
    [1.425, 0.798, 0.0],
    [0.0, 0.0, 0.0],
];

/// Rings of the lid, from the top of the knob outwards.
pub(crate) const LID: [Ring; 7] = [
    [0.0, 0.0, 3.15],
    [0.8, 0.45, 3.15],
    [0.0, 0.0, 2.85],
    [0.2, 0.112, 2.7],
    [0.4, 0.224, 2.55],
    [1.3, 0.728, 2.55],
    [1.3, 0.728, 2.4],
];

/// A half ring of a tube: x and z of its inner and of its outer end, and half its breadth. The control points are
/// inner, inner at −breadth, outer at −breadth, outer; the other half is the mirror image.
pub(crate) type HalfRing = [f64; 5];

/// Half rings of the handle, from the top; four per patch, of which neighbouring patches share one.
pub(crate) const HANDLE: [HalfRing; 7] = [
    [-1.6, 2.025, -1.5, 2.25, 0.3],
    [-2.3, 2.025, -2.5, 2.25, 0.3],
    [-2.7, 2.025, -3.0, 2.25, 0.3],
    [-2.7, 1.8, -3.0, 1.8, 0.3],
    [-2.7, 1.575, -3.0, 1.35, 0.3],
    [-2.5, 1.125, -2.65, 0.9375, 0.3],
    [-2.0, 0.9, -1.9, 0.6, 0.3],
];

/// Half rings of the spout, from the pot to the inside of the lip.
pub(crate) const SPOUT: [HalfRing; 7] = [
    [1.7, 1.425, 1.7, 0.6, 0.66],
    [2.6, 1.425, 3.1, 0.825, 0.66],
    [2.3, 2.1, 2.4, 2.025, 0.25],
    [2.7, 2.4, 3.3, 2.4, 0.25],
    [2.8, 2.475, 3.525, 2.49375, 0.25],
    [2.9, 2.475, 3.45, 2.5125, 0.15],
    [2.8, 2.4, 3.2, 2.4, 0.15],
];
