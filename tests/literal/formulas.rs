//! The energies, each as its formula reads.

use super::problem::Problem;
use std::array::from_fn;

/// Rows of a matrix.
pub(crate) type Square<const D: usize> = [[f64; D]; D];
type Point<const D: usize> = [f64; D];

/// Unweighted terms.
pub(crate) struct Terms {
    pub(crate) ml: f64,
    pub(crate) mp: f64,
    pub(crate) gp: f64,
    pub(crate) gr: f64,
}

impl Terms {
    pub(crate) fn pairs(&self, other: &Self) -> [(&'static str, f64, f64); 4] {
        [("ml", self.ml, other.ml), ("mp", self.mp, other.mp), ("gp", self.gp, other.gp), ("gr", self.gr, other.gr)]
    }
}

fn minus<const D: usize>(a: Point<D>, b: Point<D>) -> Point<D> {
    from_fn(|d| a[d] - b[d])
}

fn dot<const D: usize>(a: Point<D>, b: Point<D>) -> f64 {
    (0..D).map(|d| a[d] * b[d]).sum()
}

fn square<const D: usize>(a: Point<D>) -> f64 {
    dot(a, a)
}

fn times<const D: usize>(m: &Square<D>, x: Point<D>) -> Point<D> {
    m.map(|row| dot(row, x))
}

/// Σ weights of a row times handles.
fn carried<const D: usize>(row: &[f64], handles: &[Point<D>]) -> Point<D> {
    from_fn(|d| row.iter().zip(handles).map(|(w, p)| w * p[d]).sum())
}

/// a + weight · x yᵀ.
fn add_outer<const D: usize>(a: &mut Square<D>, weight: f64, x: Point<D>, y: Point<D>) {
    (0..D).for_each(|i| (0..D).for_each(|j| a[i][j] += weight * x[i] * y[j]));
}

/// The rotation that maximises tr(Rᵀ A), by turning a frame until it balances (M. Müller et al., "A robust method to
/// extract the rotational part of deformations", 2016); the identity where A is zero.
fn nearest_rotation<const D: usize>(a: &Square<D>) -> Square<D> {
    let mut r: Square<D> = from_fn(|i| from_fn(|j| f64::from(u8::from(i == j))));
    let column = |m: &Square<D>, j: usize| -> [f64; 3] { from_fn(|d| if d < D { m[d][j] } else { 0.0 }) };
    for _ in 0..3000 {
        let (mut turn, mut along) = ([0.0; 3], 0.0);
        for j in 0..D {
            let (x, y) = (column(&r, j), column(a, j));
            (0..3).for_each(|k| turn[k] += x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3]);
            along += dot(x, y);
        }
        let omega = turn.map(|x| x / (along.abs() + 1e-300));
        let angle = square(omega).sqrt();
        if along == 0.0 || angle < 1e-16 {
            break;
        }
        let axis = omega.map(|x| x / angle);
        for j in 0..D {
            let x = column(&r, j);
            let across: [f64; 3] = from_fn(|k| axis[(k + 1) % 3] * x[(k + 2) % 3] - axis[(k + 2) % 3] * x[(k + 1) % 3]);
            let share = dot(axis, x) * (1.0 - angle.cos());
            (0..D).for_each(|d| r[d][j] = x[d] * angle.cos() + across[d] * angle.sin() + axis[d] * share);
        }
    }
    r
}

/// Half-edges of a vertex: each neighbour once, with w_ij.
fn neighbours<const D: usize>(problem: &Problem<D>, i: usize) -> Vec<(usize, f64)> {
    let mut found: Vec<(usize, f64)> = Vec::new();
    for t in &problem.triangles {
        for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (2, 1, 0), (0, 2, 1)] {
            let (from, to, apex) = (t[a], t[b], problem.vertices[t[c]]);
            if from != i || to == i {
                continue;
            }
            let (u, v) = (minus(problem.vertices[from], apex), minus(problem.vertices[to], apex));
            let area = (square(u) * square(v) - dot(u, v).powi(2)).max(0.0).sqrt();
            let half_cotangent = if area > 1e-12 { 0.5 * dot(u, v) / area } else { 0.0 };
            let weight = if problem.is_cotangent { half_cotangent } else { 1.0 };
            match found.iter_mut().find(|entry| entry.0 == to) {
                Some(entry) if problem.is_cotangent => entry.1 += weight,
                Some(_) => {}
                None => found.push((to, weight)),
            }
        }
    }
    found
}

/// A triangle: area, an orthonormal frame of it, and J, whose columns are the images of the frame.
struct Element<const D: usize> {
    area: f64,
    frame: [Point<D>; 2],
    images: [Point<D>; 2],
}

impl<const D: usize> Element<D> {
    fn of(rest: [Point<D>; 3], now: [Point<D>; 3]) -> Option<Self> {
        let [[u, v], [a, b]] = [rest, now].map(|p| [minus(p[1], p[0]), minus(p[2], p[0])]);
        let first: Point<D> = u.map(|x| x / square(u).sqrt());
        let across: Point<D> = from_fn(|d| v[d] - dot(v, first) * first[d]);
        let height = square(across).sqrt();
        if height.is_nan() || height <= 1e-12 {
            return None;
        }
        // u = |u| f1 and v = (v·f1) f1 + height f2, so J f1 = a / |u| and J f2 = (b − (v·f1) J f1) / height.
        let along: Point<D> = a.map(|x| x / square(u).sqrt());
        let up = from_fn(|d| (b[d] - dot(v, first) * along[d]) / height);
        let frame = [first, across.map(|x| x / height)];
        Some(Self { area: 0.5 * square(u).sqrt() * height, frame, images: [along, up] })
    }

    /// Σ_k (J f_k) f_kᵀ.
    fn map(&self) -> Square<D> {
        let mut map = [[0.0; D]; D];
        (0..2).for_each(|k| add_outer(&mut map, 1.0, self.images[k], self.frame[k]));
        map
    }

    /// ‖J − R‖² over the plane of the triangle.
    fn miss(&self, r: &Square<D>) -> f64 {
        (0..2).map(|k| square(minus(self.images[k], times(r, self.frame[k])))).sum()
    }
}

fn elements<const D: usize>(problem: &Problem<D>, moved: &[Point<D>]) -> Vec<Option<Element<D>>> {
    let of = |t: &[usize; 3]| Element::of(t.map(|k| problem.vertices[k]), t.map(|k| moved[k]));
    problem.triangles.iter().map(of).collect()
}

/// Points of a line as vertices, its ring pairs (j, k, length of line between), both ways.
fn ring_pairs<const D: usize>(problem: &Problem<D>, stroke: &[usize]) -> Vec<(usize, usize, f64)> {
    let closed = stroke.len() > 2 && stroke.first() == stroke.last();
    let count = if closed { stroke.len() - 1 } else { stroke.len() };
    let step =
        |k: usize| square(minus(problem.vertices[stroke[k % count]], problem.vertices[stroke[(k + 1) % count]])).sqrt();
    let mut pairs = Vec::new();
    for k in 0..count {
        for ring in 1..=2 {
            let wraps = closed && count > 2 * ring;
            if k + ring < count || wraps {
                let length: f64 = (k..k + ring).map(step).sum();
                if length > 0.0 {
                    pairs.extend([(k, (k + ring) % count, length), ((k + ring) % count, k, length)]);
                }
            }
        }
    }
    pairs
}

/// Samples of `quad`: place, area.
fn samples<const D: usize>(problem: &Problem<D>) -> Vec<(Point<D>, f64)> {
    if let Some(samples) = &problem.samples {
        return samples.clone();
    }
    let still = elements(problem, &problem.vertices);
    let sample = |(t, element): (&[usize; 3], Option<Element<D>>)| {
        let at = from_fn(|d| t.iter().map(|&k| problem.vertices[k][d]).sum::<f64>() / 3.0);
        element.map(|element| (at, element.area))
    };
    problem.triangles.iter().zip(still).filter_map(sample).collect()
}

/// J of the lattice at a point, by central differences.
fn gradient<const D: usize>(problem: &Problem<D>, at: Point<D>, handles: &[Point<D>]) -> Square<D> {
    let step = 1e-6;
    let columns: [Point<D>; D] = from_fn(|axis| {
        let [up, down] = [step, -step].map(|step| {
            let mut at = at;
            at[axis] += step;
            carried(&problem.row(at), handles)
        });
        minus(up, down).map(|x| x / (2.0 * step))
    });
    from_fn(|i| from_fn(|j| columns[j][i]))
}

/// One rotation a vertex, triangle, sample or point of a line, in the order the form goes through them.
pub(crate) fn rotations_at<const D: usize>(problem: &Problem<D>, handles: &[Point<D>]) -> Vec<Square<D>> {
    let moved: Vec<Point<D>> = problem.weights.iter().map(|row| carried(row, handles)).collect();
    let rest = &problem.vertices;
    let maps: Vec<Square<D>> = match problem.form.as_str() {
        "edge" | "vrd" => (0..rest.len())
            .map(|i| {
                let mut map = [[0.0; D]; D];
                for (j, w) in neighbours(problem, i) {
                    add_outer(&mut map, w, minus(moved[i], moved[j]), minus(rest[i], rest[j]));
                }
                map
            })
            .collect(),
        "elem" => elements(problem, &moved).iter().map(|e| e.as_ref().map_or([[0.0; D]; D], Element::map)).collect(),
        "rims" => (0..rest.len())
            .map(|v| {
                let mut sum = [[0.0; D]; D];
                let around = problem.triangles.iter().zip(elements(problem, &moved)).filter(|(t, _)| t.contains(&v));
                for element in around.filter_map(|(_, element)| element) {
                    let map = element.map();
                    (0..D).for_each(|i| (0..D).for_each(|j| sum[i][j] += element.area * map[i][j]));
                }
                sum
            })
            .collect(),
        "quad" => samples(problem).iter().map(|&(at, _)| gradient(problem, at, handles)).collect(),
        _ => problem.strokes.iter().flat_map(|stroke| stroke_maps(problem, stroke, &moved)).collect(),
    };
    maps.iter().map(nearest_rotation).collect()
}

fn stroke_maps<const D: usize>(problem: &Problem<D>, stroke: &[usize], moved: &[Point<D>]) -> Vec<Square<D>> {
    let mut maps = vec![[[0.0; D]; D]; stroke.len()];
    for (k, j, length) in ring_pairs(problem, stroke) {
        let (a, b) = (stroke[k], stroke[j]);
        let rest = minus(problem.vertices[a], problem.vertices[b]);
        add_outer(&mut maps[k], 1.0 / length, minus(moved[a], moved[b]), rest);
    }
    maps
}

/// The terms at `handles` with the rotations held.
pub(crate) fn terms<const D: usize>(problem: &Problem<D>, handles: &[Point<D>], rotations: &[Square<D>]) -> Terms {
    let moved: Vec<Point<D>> = problem.weights.iter().map(|row| carried(row, handles)).collect();
    Terms {
        ml: distortion(problem, handles, &moved, rotations),
        mp: problem.pins.iter().map(|(row, target)| square(minus(carried(row, handles), *target))).sum(),
        gp: problem.handles.iter().map(|&(handle, target)| square(minus(handles[handle], target))).sum(),
        gr: regulariser(problem, handles),
    }
}

fn distortion<const D: usize>(
    problem: &Problem<D>,
    handles: &[Point<D>],
    moved: &[Point<D>],
    rotations: &[Square<D>],
) -> f64 {
    let rest = &problem.vertices;
    match problem.form.as_str() {
        "edge" => {
            let pairs = (0..rest.len()).flat_map(|i| neighbours(problem, i).into_iter().map(move |(j, w)| (i, j, w)));
            let miss = |i: usize, j: usize| {
                square(minus(minus(moved[i], moved[j]), times(&rotations[i], minus(rest[i], rest[j]))))
            };
            pairs.map(|(i, j, w)| w * miss(i, j)).sum()
        }
        "vrd" => {
            let laplacian = |x: &[Point<D>], i: usize| {
                let mut sum = [0.0; D];
                for (j, w) in neighbours(problem, i) {
                    (0..D).for_each(|d| sum[d] += w * (x[i][d] - x[j][d]));
                }
                sum
            };
            (0..rest.len()).map(|i| square(minus(laplacian(moved, i), times(&rotations[i], laplacian(rest, i))))).sum()
        }
        "elem" => {
            let elements = elements(problem, moved).into_iter().zip(rotations);
            elements.filter_map(|(e, r)| e.map(|e| 2.0 * e.area * e.miss(r))).sum()
        }
        "rims" => {
            let elements = problem.triangles.iter().zip(elements(problem, moved));
            let parts = elements.filter_map(|(t, e)| {
                e.map(|e| t.iter().map(|&v| 2.0 * e.area / 3.0 * e.miss(&rotations[v])).sum::<f64>())
            });
            parts.sum()
        }
        "quad" => {
            let parts = samples(problem).into_iter().zip(rotations).map(|((at, area), r)| {
                let j = gradient(problem, at, handles);
                2.0 * area * (0..D).map(|i| square(minus(j[i], r[i]))).sum::<f64>()
            });
            parts.sum()
        }
        _ => {
            let mut first = 0;
            let mut sum = 0.0;
            for stroke in &problem.strokes {
                for (k, j, length) in ring_pairs(problem, stroke) {
                    let (a, b) = (stroke[k], stroke[j]);
                    let turned = times(&rotations[first + k], minus(rest[a], rest[b]));
                    sum += square(minus(minus(moved[a], moved[b]), turned)) / length;
                }
                first += stroke.len();
            }
            sum
        }
    }
}

fn regulariser<const D: usize>(problem: &Problem<D>, handles: &[Point<D>]) -> f64 {
    let rest = problem.rest_handles();
    let is_free = |i: &usize| problem.handles.iter().all(|(handle, _)| handle != i);
    let free: Vec<usize> = (0..handles.len()).filter(is_free).collect();
    // The handle some steps along some axes, where there is one.
    let beside = |i: usize, steps: [usize; D]| {
        let place = problem.place(i);
        let next: [usize; D] = from_fn(|d| place[d] + steps[d]);
        (0..D).all(|d| next[d] < problem.dims[d]).then(|| problem.handle_at(next))
    };
    let along = |a: usize, steps: usize| -> [usize; D] { from_fn(|d| if d == a { steps } else { 0 }) };
    let all = 0..handles.len();
    match problem.regulariser.as_str() {
        "gr" => free.iter().map(|&i| square(minus(handles[i], rest[i]))).sum(),
        "noh" => {
            let edges = all.flat_map(|i| (0..D).filter_map(move |a| beside(i, along(a, 1)).map(|j| (i, j))));
            edges.map(|(i, j)| square(minus(minus(handles[i], handles[j]), minus(rest[i], rest[j])))).sum()
        }
        "affproj" => (0..D).map(|d| affine_residual(&rest, &free, |i| handles[i][d])).sum(),
        _ => {
            let mut sum = 0.0;
            for (i, a) in all.flat_map(|i| (0..D).map(move |a| (i, a))) {
                if let (Some(j), Some(k)) = (beside(i, along(a, 1)), beside(i, along(a, 2))) {
                    sum += square::<D>(from_fn(|d| handles[i][d] - 2.0 * handles[j][d] + handles[k][d]));
                }
                for b in a + 1..D {
                    let both = from_fn(|d| usize::from(d == a || d == b));
                    let others = (beside(i, along(a, 1)), beside(i, along(b, 1)), beside(i, both));
                    if let (Some(j), Some(k), Some(l)) = others {
                        sum += 2.0
                            * square::<D>(from_fn(|d| handles[i][d] - handles[j][d] - handles[k][d] + handles[l][d]));
                    }
                }
            }
            sum
        }
    }
}

/// What least squares over 1 and the rest coordinates leave of values, squared: the normal equations by elimination.
fn affine_residual<const D: usize>(rest: &[Point<D>], free: &[usize], value: impl Fn(usize) -> f64) -> f64 {
    let row = |i: usize| -> Vec<f64> { std::iter::once(1.0).chain(rest[i]).collect() };
    let count = D + 1;
    let mut system = vec![vec![0.0; count + 1]; count];
    for &i in free {
        let row = row(i);
        for a in 0..count {
            (0..count).for_each(|b| system[a][b] += row[a] * row[b]);
            system[a][count] += row[a] * value(i);
        }
    }
    for pivot in 0..count {
        for a in (0..count).filter(|&a| a != pivot) {
            let factor = system[a][pivot] / system[pivot][pivot];
            (0..=count).for_each(|b| system[a][b] -= factor * system[pivot][b]);
        }
    }
    let share = |a: usize| system[a][count] / system[a][a];
    free.iter().map(|&i| (value(i) - row(i).iter().enumerate().map(|(a, x)| share(a) * x).sum::<f64>()).powi(2)).sum()
}
