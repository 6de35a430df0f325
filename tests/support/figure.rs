//! A gingerman of triangles, with arms, legs and eyes that hang together with nothing, and poses of it.
//!
//! In: how fine it is, angles. Out: shapes and pins in a box of about 2 x 2 units.

use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{PointPin, Shape};

/// Joints: shoulder and hip, hand and foot, on the right; the left ones are mirrored.
const SHOULDER: [f64; 2] = [0.28, 0.3];
const HAND: [f64; 2] = [0.85, 0.36];
const HIP: [f64; 2] = [0.17, -0.32];
const FOOT: [f64; 2] = [0.32, -0.9];

/// A pose: right arm, left arm, right leg, left leg, radians counter-clockwise; and how far the body goes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pose {
    pub(crate) limbs: [f64; 4],
    pub(crate) shift: [f64; 2],
}

/// Distance from a line between two points.
fn from_line(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let t = ((ab[0] * ap[0] + ab[1] * ap[1]) / (ab[0] * ab[0] + ab[1] * ab[1])).clamp(0.0, 1.0);
    (ap[0] - t * ab[0]).hypot(ap[1] - t * ab[1])
}

fn is_inside([x, y]: [f64; 2]) -> bool {
    let p = [x.abs(), y];
    from_line(p, [0.0, 0.62], [0.0, 0.66]) < 0.3
        || from_line(p, [0.0, -0.25], [0.0, 0.25]) < 0.32
        || from_line(p, SHOULDER, HAND) < 0.15
        || from_line(p, HIP, FOOT) < 0.16
}

/// Rows of points `spacing` apart; triangles all of whose corners lie inside; two eyes of six triangles each.
pub(crate) fn figure(spacing: f64) -> Shape<2> {
    let side = (2.4 / spacing) as usize;
    let place = |k: usize| {
        let (i, j) = (k % side, k / side);
        [-1.2 + spacing * (i as f64 + 0.5 * (j % 2) as f64), -1.2 + spacing * j as f64]
    };
    let mut used: Vec<Option<u32>> = vec![None; side * side];
    let mut shape = Shape::default();
    for k in (0..side * (side - 1)).filter(|k| k % side > 0 && k % side + 1 < side) {
        let odd = k / side % 2;
        let above = k + side;
        for corners in [[k, k + 1, above + odd], [k + odd, above + 1, above]] {
            if !corners.iter().all(|&corner| is_inside(place(corner))) {
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
    [-0.12, 0.12].into_iter().for_each(|x| add_eye(&mut shape, [x, 0.72]));
    shape
}

fn add_eye(shape: &mut Shape<2>, at: [f64; 2]) {
    let middle = shape.points.len() as u32;
    shape.points.push(at);
    let rim = (0..6).map(|k| (f64::from(k) * 60.0).to_radians().sin_cos());
    shape.points.extend(rim.map(|(sin, cos)| [at[0] + 0.05 * cos, at[1] + 0.05 * sin]));
    shape.triangles.extend((0..6).map(|k| [middle, middle + 1 + k, middle + 1 + (k + 1) % 6]));
}

/// A lattice around it, its box padded by a tenth.
pub(crate) fn around(dims: usize, basis: Basis) -> Grid<2> {
    Grid { dims: [dims, dims], basis, lo: [-1.2, -1.25], hi: [1.2, 1.15], angle: 0.0 }
}

/// Hands and feet where the pose puts them, head and belly shifted.
pub(crate) fn posed(pose: Pose) -> Vec<PointPin<2>> {
    let mirrored = |[x, y]: [f64; 2]| [-x, y];
    let limbs = [(SHOULDER, HAND), (mirrored(SHOULDER), mirrored(HAND)), (HIP, FOOT), (mirrored(HIP), mirrored(FOOT))];
    let shifted = |[x, y]: [f64; 2]| [x + pose.shift[0], y + pose.shift[1]];
    let turned = |((joint, end), angle): (([f64; 2], [f64; 2]), f64)| {
        let (sin, cos) = angle.sin_cos();
        let [x, y] = [end[0] - joint[0], end[1] - joint[1]];
        PointPin::new(end, shifted([joint[0] + cos * x - sin * y, joint[1] + sin * x + cos * y]))
    };
    let still = [[0.0, 0.75], [0.0, -0.1]].map(|at| PointPin::new(at, shifted(at)));
    limbs.into_iter().zip(pose.limbs).map(turned).chain(still).collect()
}
