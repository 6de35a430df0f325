//! First and second derivative of the barrier potential φ(det J) of one sample with respect to its gradient J.
//!
//! In: J, φ' and φ''. Out: the cofactor matrix of J (the first derivative is φ' cof J), and the eigendecomposition of the second
//! derivative.
//! B. Smith et al., "Analytic Eigensystems for Isotropic Distortion Energies", 2019: for a function of det J the eigenmatrices
//! are twists and flips of pairs of singular vectors, and combinations of the stretches along the singular vectors.

use crate::solve::linalg::small_matrix::{SquareMatrix, symmetric_eigen};

/// Lower bound of singular values, which are divided by.
const MIN_STRETCH: f64 = 1e-9;

/// An eigenvalue and its eigenmatrix Q: the second derivative along dJ is Σ value ⟨Q, dJ⟩².
pub(super) type EigenPair<const D: usize> = (f64, SquareMatrix<D>);

/// Returns the cofactor matrix, the derivative of det J.
pub(super) fn cofactors<const D: usize>(j: &SquareMatrix<D>) -> SquareMatrix<D> {
    if D == 2 {
        return std::array::from_fn(|row| {
            std::array::from_fn(|axis| if row == axis { j[1 - row][1 - axis] } else { -j[1 - row][1 - axis] })
        });
    }
    std::array::from_fn(|row| {
        std::array::from_fn(|axis| {
            let ([a, b], [c, d]) = ([(row + 1) % D, (row + 2) % D], [(axis + 1) % D, (axis + 2) % D]);
            j[a][c] * j[b][d] - j[a][d] * j[b][c]
        })
    })
}

/// Returns the eigenpairs of the second derivative at a J of positive determinant, `slope` = φ', `bend` = φ''. With `is_convex`,
/// pairs with a negative eigenvalue are left out.
pub(super) fn eigen_pairs<const D: usize>(
    j: &SquareMatrix<D>,
    [slope, bend]: [f64; 2],
    is_convex: bool,
) -> Vec<EigenPair<D>> {
    let gram: SquareMatrix<D> =
        std::array::from_fn(|a| std::array::from_fn(|b| (0..D).map(|row| j[row][a] * j[row][b]).sum()));
    let (squares, right) = symmetric_eigen(&gram);
    let stretches = squares.map(|square| square.max(MIN_STRETCH * MIN_STRETCH).sqrt());
    let left: SquareMatrix<D> = std::array::from_fn(|row| {
        std::array::from_fn(|k| (0..D).map(|axis| j[row][axis] * right[axis][k]).sum::<f64>() / stretches[k])
    });
    let outer = |p: usize, q: usize| -> SquareMatrix<D> {
        std::array::from_fn(|row| std::array::from_fn(|axis| left[row][p] * right[axis][q]))
    };
    let det: f64 = stretches.iter().product();
    // Second derivative of det J with respect to the stretches p and q.
    let mixed = |p: usize, q: usize| det / (stretches[p] * stretches[q]);
    let scaling: SquareMatrix<D> = std::array::from_fn(|p| {
        std::array::from_fn(|q| {
            let both = bend * det / stretches[p] * det / stretches[q];
            if p == q { both } else { both + slope * mixed(p, q) }
        })
    });
    let (values, vectors) = symmetric_eigen(&scaling);
    let mut eigen_pairs: Vec<EigenPair<D>> = Vec::with_capacity(D * D);
    for (k, &value) in values.iter().enumerate() {
        let mut along = [[0.0; D]; D];
        for (p, row) in vectors.iter().enumerate() {
            add(&mut along, row[k], &outer(p, p));
        }
        eigen_pairs.push((value, along));
    }
    for p in 0..D {
        for q in p + 1..D {
            for sign in [1.0, -1.0] {
                // The positive sign gives the flip, the negative one the twist.
                let mut along = [[0.0; D]; D];
                add(&mut along, std::f64::consts::FRAC_1_SQRT_2, &outer(p, q));
                add(&mut along, sign * std::f64::consts::FRAC_1_SQRT_2, &outer(q, p));
                eigen_pairs.push((-sign * slope * mixed(p, q), along));
            }
        }
    }
    eigen_pairs.retain(|(value, _)| if is_convex { *value > 0.0 } else { *value != 0.0 });
    eigen_pairs
}

fn add<const D: usize>(sum: &mut SquareMatrix<D>, factor: f64, matrix: &SquareMatrix<D>) {
    for (slots, row) in sum.iter_mut().zip(matrix) {
        slots.iter_mut().zip(row).for_each(|(slot, x)| *slot += factor * x);
    }
}

#[cfg(test)]
mod tests {
    use super::super::potential::potential;
    use super::*;
    use crate::solve::linalg::small_matrix::determinant;

    fn check<const D: usize>(j: SquareMatrix<D>, along: SquareMatrix<D>) {
        let at = |t: f64| -> SquareMatrix<D> {
            std::array::from_fn(|row| std::array::from_fn(|axis| j[row][axis] + t * along[row][axis]))
        };
        let inner = |a: &SquareMatrix<D>, b: &SquareMatrix<D>| -> f64 {
            a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| x * y).sum()
        };
        let [_, slope, bend] = potential(determinant(&j));
        let found: f64 =
            eigen_pairs(&j, [slope, bend], false).iter().map(|(value, q)| value * inner(q, &along).powi(2)).sum();
        let first = |t: f64| potential(determinant(&at(t)))[1] * inner(&cofactors(&at(t)), &along);
        let step = 1e-6;
        let wanted = (first(step) - first(-step)) / (2.0 * step);
        assert!((found - wanted).abs() < 1e-5 * wanted.abs().max(bend), "{found} {wanted}");
        assert!(eigen_pairs(&j, [slope, bend], true).iter().all(|(value, _)| *value > 0.0));
    }

    #[test]
    fn eigenmatrices_give_the_second_derivative() {
        for [a, b] in [[1.0, 0.0], [0.3, -0.8], [-0.5, 0.4]] {
            check([[0.9, 0.3], [0.5, 0.3]], [[a, b], [b, 0.7 * a]]);
            check([[-0.4, 1.1], [-0.3, 0.5]], [[a, b], [0.2, a - b]]);
            check([[0.9, 0.3, 0.1], [0.5, 0.4, -0.2], [0.1, 0.2, 0.6]], [[a, b, 0.2], [b, 0.7, a], [0.1, b, -a]]);
        }
    }
}
