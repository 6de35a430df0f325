//! Random problems of four kinds: limbs that are shortened, strips that are pressed, figures that are posed, shapes whose pins go far.
//!
//! In: the number of a problem, which is its seed. Out: the problem.

use super::figure::{Pose, around, figure, posed};
use super::hard::{Hard, hard};
use super::limbs::Limb;
use crate::internal::numbers::{Random, SplitMix};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{PointPin, Shape, TimedProblem, Timeline};

/// A problem; the kind changes with the number.
pub(crate) fn varied(number: u64) -> Hard {
    let seed = 5000 + number / 4;
    match number % 4 {
        0 => limb(seed),
        1 => pressed(seed),
        2 => figure_in_pose(seed),
        _ => hard(seed),
    }
}

/// Two to four bones, turned by up to 60 degrees and shortened by up to 30 %.
fn limb(seed: u64) -> Hard {
    let limb = Limb::random(seed, 0.3, 24.0);
    let time = 3.0 + (seed % 18) as f64;
    let TimedProblem { grid, shape, path, .. } = limb.at(time).expect("a valid problem").expect("one at each time");
    let pins = path.into_iter().flat_map(|targets| targets.pins).collect();
    Hard { grid, shape, pins }
}

/// A strip with two to four pins along it, pressed to 60 to 95 % and turned; half of them shaken.
fn pressed(seed: u64) -> Hard {
    let mut numbers = SplitMix(seed);
    let mut within = |most: f64| numbers.within(most);
    let (count, half) = (3 + within(1.5) as i32, 0.16 + within(0.1));
    let (share, noise) = (0.775 + within(0.175), if seed.is_multiple_of(2) { 0.0 } else { 0.1 });
    let (sin, cos) = within(3.1).sin_cos();
    let pins = (0..count).map(|k| {
        let x = -0.95 + 1.9 * f64::from(k) / f64::from(count - 1);
        let (a, b) = (share * x + within(noise), within(noise));
        PointPin::new([x, 0.0], [cos * a - sin * b, sin * a + cos * b])
    });
    let pins = pins.collect();
    let dims = [10, 6 + (seed % 5) as usize];
    Hard {
        grid: Grid { dims, basis: Basis::Bspline, lo: [-1.1, -0.35], hi: [1.1, 0.35], angle: 0.0 },
        shape: strip(half),
        pins,
    }
}

/// A straight strip from −1 to 1 of this half width.
pub(crate) fn strip(half: f64) -> Shape<2> {
    let [along, across] = [40_u32, 4];
    let place = |k: u32| {
        let (i, j) = (k / (across + 1), k % (across + 1));
        [2.0 * f64::from(i) / f64::from(along) - 1.0, half * (2.0 * f64::from(j) / f64::from(across) - 1.0)]
    };
    let cells = (0..along).flat_map(|i| (0..across).map(move |j| i * (across + 1) + j));
    let halves = |c: u32| [[c, c + across + 1, c + across + 2], [c, c + across + 2, c + 1]];
    Shape::of_triangles((0..(along + 1) * (across + 1)).map(place).collect(), cells.flat_map(halves).collect())
}

/// Every other limb turned, by up to 110 degrees; all pins shaken by a tenth of the box.
fn figure_in_pose(seed: u64) -> Hard {
    let mut numbers = SplitMix(seed);
    let mut within = |most: f64| numbers.within(most);
    let mut limb = |most: f64| if within(1.0) < 0.0 { within(most) } else { 0.0 };
    let pose = Pose { limbs: [limb(1.92), limb(1.92), limb(1.4), limb(1.4)], shift: [0.0; 2] };
    let mut pins = posed(pose);
    pins.iter_mut().for_each(|pin| pin.target = pin.target.map(|x| x + within(0.25)));
    Hard { grid: around(10, Basis::Bspline), shape: figure(0.086), pins }
}
