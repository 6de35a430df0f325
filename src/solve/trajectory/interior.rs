//! How the times between two knots are solved: freely where the energy is convex, else so that the motion cannot jump.

/// How the times between two knots are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interior {
    /// With the weight that couples the knots: the motion is continuous because the energy is convex.
    Coupled,
    /// With a weight so large that the motion is practically the interpolation of the knots.
    Interpolated,
}

impl Interior {
    /// Weight of the proximal term as a multiple of the weight that couples the knots.
    pub(super) fn factor(self) -> f64 {
        match self {
            Self::Coupled => 1.0,
            Self::Interpolated => 65536.0,
        }
    }
}
