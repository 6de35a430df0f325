//! Algebra of 2 x 2, 3 x 3 and 4 x 4 matrices: eigenvectors, best rotations, singular values.
//!
//! In: row-major matrices, `m[row][column]`. Out: the same. Nothing fails; the best rotation of a zero matrix is the identity.

/// A square matrix, row-major.
pub(crate) type SquareMatrix<const N: usize> = [[f64; N]; N];

/// The identity.
pub(crate) fn identity<const N: usize>() -> SquareMatrix<N> {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { 1.0 } else { 0.0 }))
}

/// m·x.
pub(crate) fn apply<const N: usize>(m: &SquareMatrix<N>, x: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|row| dot(&m[row], x))
}

/// a·b of matrices.
pub(crate) fn times<const N: usize>(a: &SquareMatrix<N>, b: &SquareMatrix<N>) -> SquareMatrix<N> {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..N).map(|k| a[row][k] * b[k][column]).sum()))
}

/// mᵀ.
pub(crate) fn transpose<const N: usize>(m: &SquareMatrix<N>) -> SquareMatrix<N> {
    std::array::from_fn(|row| std::array::from_fn(|column| m[column][row]))
}

/// a·b of vectors.
pub(crate) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|k| a[k] * b[k]).sum()
}

/// a − b of vectors.
pub(crate) fn minus<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|k| a[k] - b[k])
}

/// Distance between two points.
pub(crate) fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let gap = minus(a, b);
    dot(&gap, &gap).sqrt()
}

/// ‖a − b‖² of matrices.
pub(crate) fn squared_distance<const N: usize>(a: &SquareMatrix<N>, b: &SquareMatrix<N>) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y) * (x - y)).sum()
}

/// Determinant of a 2 x 2 or 3 x 3 matrix.
pub(crate) fn determinant<const N: usize>(m: &SquareMatrix<N>) -> f64 {
    match N {
        2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
        3 => (0..3)
            .map(|k| {
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                m[0][k] * (m[1][a] * m[2][b] - m[1][b] * m[2][a])
            })
            .sum(),
        _ => m[0][0],
    }
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by cyclic Jacobi rotations; unsorted.
pub(crate) fn symmetric_eigen<const N: usize>(m: &SquareMatrix<N>) -> ([f64; N], SquareMatrix<N>) {
    let (mut a, mut vectors) = (*m, identity::<N>());
    for _ in 0..30 {
        let off: f64 = (0..N).map(|p| (p + 1..N).map(|q| a[p][q] * a[p][q]).sum::<f64>()).sum();
        let on: f64 = (0..N).map(|p| a[p][p] * a[p][p]).sum();
        // 1e-34 is far below the rounding error of the squares.
        if off.is_nan() || off <= 1e-34 * on {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                rotate_pair(&mut a, &mut vectors, [p, q]);
            }
        }
    }
    (std::array::from_fn(|k| a[k][k]), vectors)
}

/// A Jacobi rotation that makes a[p][q] zero.
fn rotate_pair<const N: usize>(a: &mut SquareMatrix<N>, vectors: &mut SquareMatrix<N>, [p, q]: [usize; 2]) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.mul_add(theta, 1.0).sqrt());
    let c = 1.0 / t.mul_add(t, 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut().chain(vectors.iter_mut()) {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    let (above, below) = (a[p], a[q]);
    a[p] = std::array::from_fn(|k| c * above[k] - s * below[k]);
    a[q] = std::array::from_fn(|k| s * above[k] + c * below[k]);
}

/// The symmetric square root of a positive semidefinite matrix; eigenvalues that rounding makes negative count as zero.
pub(crate) fn symmetric_root<const N: usize>(m: &SquareMatrix<N>) -> SquareMatrix<N> {
    let (values, vectors) = symmetric_eigen(m);
    let roots = values.map(|value| value.max(0.0).sqrt());
    std::array::from_fn(|row| {
        std::array::from_fn(|column| (0..N).map(|k| vectors[row][k] * roots[k] * vectors[column][k]).sum())
    })
}

/// The rotation R that maximises tr(R S), S = Σ w (rest edge)(moved edge)ᵀ; the identity if S is zero or not finite.
pub(crate) fn best_rotation<const D: usize>(s: &SquareMatrix<D>) -> SquareMatrix<D> {
    match D {
        2 => best_rotation_2d(s),
        3 => best_rotation_3d(s),
        _ => identity(),
    }
}

/// The rotation nearest to a gradient: S = Σ (axis)(image of the axis)ᵀ = Jᵀ.
pub(crate) fn nearest_rotation<const D: usize>(gradient: &SquareMatrix<D>) -> SquareMatrix<D> {
    best_rotation(&transpose(gradient))
}

/// In 2D: the angle is atan2(Σ w e × e', Σ w e · e').
fn best_rotation_2d<const D: usize>(s: &SquareMatrix<D>) -> SquareMatrix<D> {
    let (along, across) = (s[0][0] + s[1][1], s[0][1] - s[1][0]);
    let length = (along * along + across * across).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return identity();
    }
    let (cos, sin) = (along / length, across / length);
    let mut rotation = identity::<D>();
    rotation[0][0] = cos;
    rotation[0][1] = -sin;
    rotation[1][0] = sin;
    rotation[1][1] = cos;
    rotation
}

/// In 3D: the unit quaternion that maximises a quadratic form. The result is never a reflection; the direction of the smallest
/// singular value flips instead.
fn best_rotation_3d<const D: usize>(s: &SquareMatrix<D>) -> SquareMatrix<D> {
    let Some((_, values, vectors)) = rotation_eigen(s) else { return identity() };
    let best = largest(&values);
    from_quaternion(std::array::from_fn(|k| vectors[k][best]))
}

/// In 3D: the mean of four rotations that belong to orthogonal quaternions, the best one and the best of the others. `weight` maps
/// what such a rotation loses of tr(R S), to its weight, 1 for a loss of 0. It is continuous in S, because R is quadratic in the
/// quaternion and equal eigenvalues have equal weights. The identity if S is zero or not finite.
pub(crate) fn mean_of_best_rotations<const D: usize>(
    s: &SquareMatrix<D>,
    weight: impl Fn(f64) -> f64,
) -> SquareMatrix<D> {
    let Some((size, values, vectors)) = rotation_eigen(s) else { return identity() };
    let best = values[largest(&values)];
    let weights = values.map(|value| weight(size * (best - value)));
    let total: f64 = weights.iter().sum();
    let mut mean = [[0.0; D]; D];
    for (k, weight) in weights.into_iter().enumerate().filter(|(_, weight)| *weight > 0.0) {
        let rotation: SquareMatrix<D> = from_quaternion(std::array::from_fn(|row| vectors[row][k]));
        mean.as_flattened_mut().iter_mut().zip(rotation.as_flattened()).for_each(|(sum, x)| *sum += weight / total * x);
    }
    mean
}

/// In 3D: the size of S, and eigenvalues and eigenvectors (columns) of the quadratic form qᵀ N q = tr(R(q) S) of S divided by it (B.
/// K. P. Horn, "Closed-form solution of absolute orientation using unit quaternions", 1987). `None` if S is zero or not finite.
fn rotation_eigen<const D: usize>(s: &SquareMatrix<D>) -> Option<(f64, [f64; 4], SquareMatrix<4>)> {
    let size: f64 = s.iter().flatten().map(|x| x.abs()).sum();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let s: SquareMatrix<D> = s.map(|row| row.map(|x| x / size));
    let (xx, yy, zz) = (s[0][0], s[1][1], s[2][2]);
    let (x, y, z) = (s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]);
    let (xy, yz, zx) = (s[0][1] + s[1][0], s[1][2] + s[2][1], s[2][0] + s[0][2]);
    let (values, vectors) = symmetric_eigen(&[
        [xx + yy + zz, x, y, z],
        [x, xx - yy - zz, xy, zx],
        [y, xy, yy - xx - zz, yz],
        [z, zx, yz, zz - xx - yy],
    ]);
    Some((size, values, vectors))
}

/// Index of the largest value, of the first of several.
fn largest(values: &[f64; 4]) -> usize {
    (1..4).fold(0, |best, k| if values[k] > values[best] { k } else { best })
}

/// The rotation of a unit quaternion (w, x, y, z).
fn from_quaternion<const D: usize>([w, x, y, z]: [f64; 4]) -> SquareMatrix<D> {
    let rows = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ];
    std::array::from_fn(|row| std::array::from_fn(|column| rows[row][column]))
}

/// A fraction of a rotation: the same axis, and `share` times the angle, which is taken within ±π.
pub(crate) fn rotation_part<const D: usize>(rotation: &SquareMatrix<D>, share: f64) -> SquareMatrix<D> {
    if D == 2 {
        let (sin, cos) = (share * rotation[1][0].atan2(rotation[0][0])).sin_cos();
        return std::array::from_fn(|row| {
            std::array::from_fn(|column| if row == column { cos } else { sin * (row as f64 - column as f64) })
        });
    }
    let [w, axis @ ..] = quaternion(rotation);
    let length = dot(&axis, &axis).sqrt();
    if length <= 0.0 {
        return identity();
    }
    let (sin, cos) = (share * length.atan2(w)).sin_cos();
    let [x, y, z] = axis.map(|x| x * sin / length);
    from_quaternion([cos, x, y, z])
}

/// The unit quaternion (w, x, y, z) of a 3D rotation with w ≥ 0, from the largest of the four columns of 4 q qᵀ.
fn quaternion<const D: usize>(m: &SquareMatrix<D>) -> [f64; 4] {
    let (x, y, z) = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]);
    let (xy, yz, zx) = (m[1][0] + m[0][1], m[2][1] + m[1][2], m[0][2] + m[2][0]);
    let (xx, yy, zz) = (m[0][0], m[1][1], m[2][2]);
    let columns = [
        [1.0 + xx + yy + zz, x, y, z],
        [x, 1.0 + xx - yy - zz, xy, zx],
        [y, xy, 1.0 - xx + yy - zz, yz],
        [z, zx, yz, 1.0 - xx - yy + zz],
    ];
    let best = (1..4).fold(0, |best, k| if columns[k][k] > columns[best][best] { k } else { best });
    let column = columns[best];
    let length = dot(&column, &column).sqrt();
    column.map(|x| x / if column[0] < 0.0 { -length } else { length })
}

/// Largest and smallest singular value of the 2-column matrix [u v].
pub(crate) fn singular_values<const D: usize>(u: &[f64; D], v: &[f64; D]) -> [f64; 2] {
    let (uu, vv, uv) = (dot(u, u), dot(v, v), dot(u, v));
    let area = area_of(u, v);
    let mean = 0.5 * (uu + vv);
    let largest = (mean + (0.5 * (uu - vv)).hypot(uv)).sqrt();
    // s1·s2 = area, which avoids cancellation for slivers.
    [largest, if largest > 0.0 { area / largest } else { 0.0 }]
}

/// Area of the parallelogram spanned by u and v.
pub(crate) fn area_of<const D: usize>(u: &[f64; D], v: &[f64; D]) -> f64 {
    let mut squares = 0.0;
    for a in 0..D {
        for b in a + 1..D {
            squares += (u[a] * v[b] - u[b] * v[a]).powi(2);
        }
    }
    squares.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    /// Reference values computed by an independent program; `None` if they are absent.
    fn units() -> Option<Value> {
        let shared = std::env::var_os("PINWARP_SHARED")
            .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared").into());
        let text = std::fs::read_to_string(std::path::Path::new(&shared).join("oracle/units.json"));
        if text.is_err() {
            assert!(std::env::var_os("PINWARP_REQUIRE_SHARED").is_none(), "the reference units are not there");
            crate::internal::skip::skip("the reference units are not there; set PINWARP_SHARED");
        }
        Some(serde_json::from_str(&text.ok()?).expect("JSON"))
    }

    fn compare<const D: usize>(cases: &Value) {
        for case in cases.as_array().expect("a list") {
            let read = |key: &str| -> SquareMatrix<D> {
                let rows: Vec<Vec<f64>> = serde_json::from_value(case[key].clone()).expect("a matrix");
                std::array::from_fn(|row| std::array::from_fn(|column| rows[row][column]))
            };
            let (found, wanted) = (best_rotation(&read("S")), read("R"));
            for (a, b) in found.iter().flatten().zip(wanted.iter().flatten()) {
                assert!((a - b).abs() < 1e-9, "{found:?} {wanted:?}");
            }
        }
    }

    #[test]
    fn rotations_are_those_of_the_reference() {
        let Some(units) = units() else { return };
        compare::<2>(&units["rot2"]);
        compare::<3>(&units["rot3"]);
    }

    #[test]
    fn roots_square_to_their_matrix() {
        let m = [[2.0, 0.3, -0.1], [0.3, 1.0, 0.4], [-0.1, 0.4, 0.5]];
        let root = symmetric_root(&m);
        for row in 0..3 {
            for column in 0..3 {
                assert!((dot(&root[row], &root[column]) - m[row][column]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn nothing_to_turn_is_the_identity() {
        assert_eq!(best_rotation(&[[0.0; 2]; 2]), identity());
        assert_eq!(best_rotation(&[[0.0; 3]; 3]), identity());
        assert_eq!(best_rotation(&[[f64::NAN; 2]; 2]), identity());
    }
}
