//! Standing figures whose parts are close to each other: arms beside the body, legs, tails of hair, a skirt.
//!
//! In: a seed and the size of triangles. Out: a mesh about 1 high, and what its joints are.

use crate::internal::numbers::{Random, SplitMix};
use pinwarp::solve::{PointPin, Shape};

/// A figure: round strokes with a radius at each end, mirrored at x = 0 where they are limbs.
#[derive(Clone, Debug)]
pub(crate) struct Puppet {
    /// Ends and the radius at each.
    strokes: Vec<[[f64; 3]; 2]>,
    /// Chains of joints, from where they hang on to their tip: arms, legs, hair.
    pub(crate) limbs: Vec<[[f64; 2]; 2]>,
    /// Points of head, chest and hip.
    pub(crate) body: [[f64; 2]; 3],
    /// Where the skirt ends, left and right.
    pub(crate) hem: [[f64; 2]; 2],
}

/// Distance of a point from a stroke; negative inside.
fn distance(&[a, b]: &[[f64; 3]; 2], p: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let t = ((ab[0] * ap[0] + ab[1] * ap[1]) / (ab[0] * ab[0] + ab[1] * ab[1]).max(1e-12)).clamp(0.0, 1.0);
    (ap[0] - t * ab[0]).hypot(ap[1] - t * ab[1]) - (a[2] + t * (b[2] - a[2]))
}

impl Puppet {
    /// A girl with two tails of hair, arms beside a skirt, and legs; no gap between her parts is wider than 3 % of her height.
    pub(crate) fn girl() -> Self {
        Self::with([0.085, 0.135, 0.03, 0.036, 0.028, 0.012])
    }

    /// Another figure for each seed.
    pub(crate) fn random(seed: u64) -> Self {
        let mut random = SplitMix(seed);
        let mut vary = |low: f64, high: f64| low + (high - low) * random.unit();
        Self::with([
            vary(0.07, 0.1),
            vary(0.1, 0.15),
            vary(0.024, 0.036),
            vary(0.03, 0.042),
            vary(0.022, 0.032),
            vary(0.008, 0.02),
        ])
    }

    /// Half widths of the chest and of the skirt's hem, radii of arm, leg and hair, and the gap between arm and body.
    fn with([chest, hem, arm, leg, hair, gap]: [f64; 6]) -> Self {
        let shoulder = [chest - 0.01, 0.7];
        // The arm hangs beside chest and skirt.
        let side = |y: f64| if y > 0.5 { chest } else { chest + (hem - chest) * (0.5 - y) / 0.2 };
        let elbow = [side(0.56) + gap + arm, 0.56];
        let hand = [side(0.42) + gap + arm, 0.42];
        let hip = [gap.max(0.01) + leg, 0.34];
        let foot = [hip[0], 0.04];
        let (ear, tip) = ([0.085, 0.9], [0.1 + gap + hair, 0.72 + hair]);
        let mut strokes = vec![
            [[0.0, 0.88, 0.09], [0.0, 0.89, 0.09]],
            [[0.0, 0.82, 0.035], [0.0, 0.7, 0.035]],
            [[0.0, 0.69, chest], [0.0, 0.52, chest]],
            [[0.0, 0.5, chest], [0.0, 0.36, 0.6 * hem]],
        ];
        let limbs = [
            [shoulder, elbow, hand],
            [hip, [hip[0], 0.2], foot],
            [ear, [ear[0] + 0.4 * (tip[0] - ear[0]) + 0.02, 0.85], tip],
        ];
        let mut chains = Vec::new();
        for (limb, radius) in limbs.into_iter().zip([arm, leg, hair]) {
            for sign in [1.0, -1.0] {
                let joints = limb.map(|[x, y]| [sign * x, y]);
                strokes.extend(
                    joints.windows(2).map(|ends| [[ends[0][0], ends[0][1], radius], [ends[1][0], ends[1][1], radius]]),
                );
                chains.push([joints[0], joints[2]]);
            }
        }
        // The skirt is a fan of strokes, its hem level.
        for k in -6..=6 {
            let x = f64::from(k) / 6.0;
            strokes.push([[x * (chest - 0.02), 0.5, 0.02], [x * (hem - 0.02), 0.3, 0.02]]);
        }
        Self {
            strokes,
            limbs: chains,
            body: [[0.0, 0.92], [0.0, 0.64], [0.0, 0.5]],
            hem: [[0.02 - hem, 0.3], [hem - 0.02, 0.3]],
        }
    }

    fn is_inside(&self, p: [f64; 2]) -> bool {
        self.strokes.iter().any(|stroke| distance(stroke, p) < 0.0)
    }

    /// The limb to which a point belongs, in the order of `limbs`; `None` for the body.
    pub(crate) fn limb_at(&self, p: [f64; 2]) -> Option<usize> {
        let distances = self.strokes.iter().map(|stroke| distance(stroke, p)).enumerate();
        let (nearest, _) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
        // Four strokes of the body come first, then two per limb, then the skirt.
        nearest.checked_sub(4).map(|stroke| stroke / 2).filter(|&limb| limb < self.limbs.len())
    }

    /// Its mesh: rows of points `spacing` apart, and the triangles among them that lie inside.
    pub(crate) fn mesh(&self, spacing: f64) -> Shape<2> {
        let side = (1.1 / spacing) as usize;
        let place = |k: usize| {
            let (i, j) = (k % side, k / side);
            [-0.55 + spacing * (i as f64 + 0.5 * (j % 2) as f64), spacing * j as f64 - 0.03]
        };
        let mut used: Vec<Option<u32>> = vec![None; side * side];
        let mut shape = Shape::default();
        for k in (0..side * (side - 1)).filter(|k| k % side > 0 && k % side + 1 < side) {
            let odd = k / side % 2;
            let above = k + side;
            for corners in [[k, k + 1, above + odd], [k + 1 - odd, above + 1, above]] {
                let points = corners.map(place);
                let middle = |a: usize, b: usize| [0, 1].map(|d| 0.5 * (points[a][d] + points[b][d]));
                let probes = [points[0], points[1], points[2], middle(0, 1), middle(1, 2), middle(2, 0)];
                if !probes.into_iter().all(|probe| self.is_inside(probe)) {
                    continue;
                }
                shape.triangles.push(corners.map(|corner| {
                    *used[corner].get_or_insert_with(|| {
                        shape.points.push(place(corner));
                        shape.points.len() as u32 - 1
                    })
                }));
            }
        }
        shape
    }

    /// Nine pins or more at rest: head, chest, hip, the tips of all limbs, the hem.
    pub(crate) fn pins(&self) -> Vec<PointPin<2>> {
        let tips = self.limbs.iter().map(|limb| limb[1]);
        let points = self.body.into_iter().chain(tips).chain(self.hem);
        points.map(|point| PointPin::new(point, point)).collect()
    }

    /// The girl with one hand raised by .28 of her height.
    pub(crate) fn raised(&self) -> Vec<PointPin<2>> {
        let mut pins = self.pins();
        pins[3].target = [pins[3].at[0] + 0.11, pins[3].at[1] + 0.28];
        pins
    }

    /// Arms, legs and hair turned about where they hang on.
    pub(crate) fn posed(&self, random: &mut impl Random) -> Vec<PointPin<2>> {
        let mut pins = self.pins();
        for (k, &[joint, tip]) in self.limbs.iter().enumerate() {
            let most = [2.0, 0.7, 0.6][k / 2];
            // Away from the body: counter-clockwise on the right.
            let outwards = if k % 2 == 0 { 1.0 } else { -1.0 };
            let (sin, cos) = (outwards * most * random.unit()).sin_cos();
            let arm = [tip[0] - joint[0], tip[1] - joint[1]];
            pins[3 + k].target = [joint[0] + cos * arm[0] - sin * arm[1], joint[1] + sin * arm[0] + cos * arm[1]];
        }
        pins
    }
}
