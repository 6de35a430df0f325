//! Polynomials over the unit cell in Bernstein form, whose coefficients bound the values from both sides.
//!
//! In: coefficients. Out: products, derivatives, halves, bounds (G. Farin, "Curves and Surfaces for CAGD", chapters 5, 6).

use super::axis::binomial;

/// Σ c_i Π_a B_ia(t_a) with Bernstein polynomials of degree `degrees[a]` on axis a; coefficients x fastest.
#[derive(Clone, Debug)]
pub(super) struct BezierPolynomial<const D: usize> {
    degrees: [usize; D],
    coefficients: Vec<f64>,
}

impl<const D: usize> BezierPolynomial<D> {
    /// Creates a polynomial; #coefficients = Π (degree + 1).
    pub(super) fn new(degrees: [usize; D], coefficients: Vec<f64>) -> Self {
        debug_assert_eq!(coefficients.len(), degrees.iter().map(|degree| degree + 1).product::<usize>());
        Self { degrees, coefficients }
    }

    fn stride(&self, axis: usize) -> usize {
        self.degrees[..axis].iter().map(|degree| degree + 1).product()
    }

    fn place(&self, index: usize, axis: usize) -> usize {
        index / self.stride(axis) % (self.degrees[axis] + 1)
    }

    /// Returns the multi-indices of all coefficients, in order.
    fn places(&self) -> impl Iterator<Item = [usize; D]> + use<D> {
        let (degrees, mut next) = (self.degrees, [0; D]);
        (0..self.coefficients.len()).map(move |_| {
            let place = next;
            for axis in 0..D {
                next[axis] += 1;
                if next[axis] <= degrees[axis] {
                    break;
                }
                next[axis] = 0;
            }
            place
        })
    }

    /// Returns the polynomial times a factor.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.coefficients.iter_mut().for_each(|c| *c *= factor);
        self
    }

    /// Returns the derivative along an axis, per cell; its degree is lower by one there.
    pub(super) fn slope(&self, axis: usize) -> Self {
        let (degree, step) = (self.degrees[axis], self.stride(axis));
        let rise = |index: usize| degree as f64 * (self.coefficients[index + step] - self.coefficients[index]);
        let mut coefficients = Vec::with_capacity(self.coefficients.len());
        let has_next = self.places().map(|place| place[axis] < degree);
        coefficients.extend(has_next.enumerate().filter(|entry| entry.1).map(|(index, _)| rise(index)));
        let mut degrees = self.degrees;
        degrees[axis] -= 1;
        Self { degrees, coefficients }
    }

    /// Multiplies (or divides) the coefficients by their binomials: in this form a product is a convolution.
    fn weighed(&self, weigh: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let factor = |place: [usize; D]| (0..D).map(|axis| binomial(self.degrees[axis], place[axis])).product();
        self.coefficients.iter().zip(self.places()).map(|(&c, place)| weigh(c, factor(place))).collect()
    }

    /// Returns Σ sign·a·b over pairs whose products have equal degrees.
    pub(super) fn sum_of_products(pairs: &[(f64, &Self, &Self)]) -> Self {
        let (_, a, b) = pairs[0];
        let degrees = std::array::from_fn(|axis| a.degrees[axis] + b.degrees[axis]);
        let mut sum = Self::new(degrees, vec![0.0; degrees.iter().map(|degree| degree + 1).product()]);
        for (sign, a, b) in pairs {
            let places = |patch: &Self| -> Vec<usize> {
                let strides: [usize; D] = std::array::from_fn(|axis| sum.stride(axis));
                patch.places().map(|place| (0..D).map(|axis| place[axis] * strides[axis]).sum()).collect()
            };
            let (at_a, at_b) = (places(a), places(b));
            let (values_a, values_b) = (a.weighed(|c, w| sign * c * w), b.weighed(|c, w| c * w));
            for (&from_a, value_a) in at_a.iter().zip(values_a) {
                for (&from_b, value_b) in at_b.iter().zip(&values_b) {
                    sum.coefficients[from_a + from_b] += value_a * value_b;
                }
            }
        }
        sum.coefficients = sum.weighed(|c, w| c / w);
        sum
    }

    /// Splits the polynomial into halves along an axis (de Casteljau).
    pub(super) fn halves(&self, axis: usize) -> [Self; 2] {
        let (degree, step) = (self.degrees[axis], self.stride(axis));
        let [mut below, mut above] = [self.clone(), self.clone()];
        for start in (0..self.coefficients.len()).filter(|&index| self.place(index, axis) == 0) {
            for round in 1..=degree {
                (0..=degree - round).for_each(|k| {
                    let at = start + k * step;
                    above.coefficients[at] = 0.5 * (above.coefficients[at] + above.coefficients[at + step]);
                });
                below.coefficients[start + round * step] = above.coefficients[start];
            }
        }
        [below, above]
    }

    /// Returns a lower bound of the values in the cell; `None` if a coefficient is NaN.
    pub(super) fn bound(&self) -> Option<f64> {
        let is_number = self.coefficients.iter().all(|c| !c.is_nan());
        is_number.then(|| self.coefficients.iter().fold(f64::INFINITY, |least, &c| least.min(c)))
    }

    /// Returns an upper bound of the values in the cell.
    pub(super) fn upper_bound(&self) -> f64 {
        self.coefficients.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the smallest value at the corners of the cell, where coefficients equal values.
    pub(super) fn min_corner(&self) -> f64 {
        let corner = |number: usize| {
            let index = (0..D).map(|axis| (number >> axis & 1) * self.degrees[axis] * self.stride(axis)).sum::<usize>();
            self.coefficients[index]
        };
        (0..1 << D).map(corner).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evaluates the polynomial by de Casteljau's algorithm, independently of the code above.
    fn value(patch: &BezierPolynomial<2>, at: [f64; 2]) -> f64 {
        let row = |c: &[f64], t: f64| {
            let mut c = c.to_vec();
            while c.len() > 1 {
                c = c.windows(2).map(|pair| pair[0] * (1.0 - t) + pair[1] * t).collect();
            }
            c[0]
        };
        let columns: Vec<f64> =
            patch.coefficients.chunks(patch.degrees[0] + 1).map(|coefficients| row(coefficients, at[0])).collect();
        row(&columns, at[1])
    }

    fn wavy(degrees: [usize; 2], seed: f64) -> BezierPolynomial<2> {
        let count = (degrees[0] + 1) * (degrees[1] + 1);
        BezierPolynomial::new(degrees, (0..count).map(|k| (seed + 1.7 * k as f64).sin()).collect())
    }

    #[test]
    fn products_slopes_and_halves_have_the_values_they_should() {
        let (a, b, c, d) = (wavy([2, 3], 0.1), wavy([3, 2], 0.7), wavy([3, 2], 2.0), wavy([2, 3], 3.0));
        let sum = BezierPolynomial::sum_of_products(&[(1.0, &a, &b), (-1.0, &c, &d)]);
        for at in [[0.0, 0.0], [0.3, 0.8], [0.5, 0.5], [1.0, 0.2]] {
            let expected = value(&a, at) * value(&b, at) - value(&c, at) * value(&d, at);
            assert!((value(&sum, at) - expected).abs() < 1e-13);
            assert!(sum.bound().is_some_and(|bound| bound <= expected) && sum.upper_bound() >= expected);
            let [below, above] = sum.halves(1);
            assert!((value(&below, at) - value(&sum, [at[0], 0.5 * at[1]])).abs() < 1e-13);
            assert!((value(&above, at) - value(&sum, [at[0], 0.5 + 0.5 * at[1]])).abs() < 1e-13);
            let step = 1e-6;
            let slope = (value(&a, [at[0] + step, at[1]]) - value(&a, [at[0] - step, at[1]])) / (2.0 * step);
            assert!((value(&a.slope(0), at) - slope).abs() < 1e-8);
        }
        assert_eq!(wavy([1, 1], 0.0).min_corner(), 0.0_f64.sin().min(5.1_f64.sin()).min(3.4_f64.sin()));
        assert_eq!(BezierPolynomial::<2>::new([1, 0], vec![0.0, f64::NAN]).bound(), None);
    }
}
