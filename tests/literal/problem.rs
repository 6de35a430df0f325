//! A problem file, read once more, and rows of W and differences of the lattice evaluated point by point.

use super::formulas::Terms;
use serde_json::Value;

/// What the formulas need of a problem.
pub(crate) struct Problem<const D: usize> {
    pub(crate) form: String,
    pub(crate) basis: String,
    pub(crate) regulariser: String,
    pub(crate) is_cotangent: bool,
    pub(crate) dims: [usize; D],
    pub(crate) lo: [f64; D],
    pub(crate) hi: [f64; D],
    pub(crate) vertices: Vec<[f64; D]>,
    /// Rows of W of the vertices, dense.
    pub(crate) weights: Vec<Vec<f64>>,
    pub(crate) triangles: Vec<[usize; 3]>,
    pub(crate) strokes: Vec<Vec<usize>>,
    /// Places and areas.
    pub(crate) samples: Option<Vec<([f64; D], f64)>>,
    /// Rows of W and targets.
    pub(crate) pins: Vec<(Vec<f64>, [f64; D])>,
    pub(crate) handles: Vec<(usize, [f64; D])>,
    /// ml, mp, gp, gr.
    pub(crate) lambdas: [f64; 4],
}

/// Lists as points.
pub(crate) fn points<const D: usize>(lists: &[Vec<f64>]) -> Vec<[f64; D]> {
    lists.iter().map(|list| list.as_slice().try_into().expect("D coordinates")).collect()
}

fn parse<T: serde::de::DeserializeOwned>(value: &Value) -> T {
    serde_json::from_value(value.clone()).expect("the right form")
}

impl<const D: usize> Problem<D> {
    pub(crate) fn read(file: &Value) -> Self {
        let word = |key: &str| file[key].as_str().expect("a word").to_owned();
        let bbox: Vec<[f64; D]> = points(&parse::<Vec<Vec<f64>>>(&file["bbox"]));
        let dims: Vec<usize> = parse(&file["dims"]);
        let sample = |values: Vec<f64>| (values[..D].try_into().expect("D coordinates"), values[D]);
        let mut problem = Self {
            form: word("form"),
            basis: word("basis"),
            regulariser: word("regulariser"),
            is_cotangent: file["weights"] == "cot",
            dims: dims.try_into().expect("D dims"),
            lo: bbox[0],
            hi: bbox[1],
            vertices: points(&parse::<Vec<Vec<f64>>>(&file["vertices"])),
            weights: Vec::new(),
            triangles: parse(&file["triangles"]),
            strokes: parse(&file["strokes"]),
            samples: file.get("samples").map(|list| parse::<Vec<Vec<f64>>>(list).into_iter().map(sample).collect()),
            pins: Vec::new(),
            handles: Vec::new(),
            lambdas: ["ml", "mp", "gp", "gr"].map(|key| file["lambdas"][key].as_f64().expect("a number")),
        };
        problem.weights = problem.vertices.iter().map(|&vertex| problem.row(vertex)).collect();
        let target = |pin: &Value| points(&[parse(&pin["target"])])[0];
        let list = |key: &str| file[key].as_array().expect("a list").clone();
        problem.pins = list("pins").iter().map(|pin| (problem.pin_row(pin), target(pin))).collect();
        problem.handles = list("handles").iter().map(|pin| (parse(&pin["index"]), target(pin))).collect();
        problem
    }

    fn pin_row(&self, pin: &Value) -> Vec<f64> {
        if let Some(point) = pin.get("point") {
            return self.row(points(&[parse(point)])[0]);
        }
        if let Some(vertex) = pin.get("vertex") {
            return self.weights[parse::<usize>(vertex)].clone();
        }
        let (corners, bary) = (self.triangles[parse::<usize>(&pin["triangle"])], parse::<[f64; 3]>(&pin["bary"]));
        let weight = |handle: usize| (0..3).map(|k| bary[k] * self.weights[corners[k]][handle]).sum();
        (0..self.handle_count()).map(weight).collect()
    }

    pub(crate) fn total(&self, terms: &Terms) -> f64 {
        let [ml, mp, gp, gr] = self.lambdas;
        ml * terms.ml + mp * terms.mp + gp * terms.gp + gr * terms.gr
    }

    pub(crate) fn diagonal(&self) -> f64 {
        (0..D).map(|d| (self.hi[d] - self.lo[d]).powi(2)).sum::<f64>().sqrt()
    }

    pub(crate) fn handle_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Place of a handle: h = i + nx (j + ny k).
    pub(crate) fn place(&self, handle: usize) -> [usize; D] {
        let mut left = handle;
        self.dims.map(|count| {
            let place = left % count;
            left /= count;
            place
        })
    }

    pub(crate) fn handle_at(&self, place: [usize; D]) -> usize {
        (0..D).rev().fold(0, |index, d| index * self.dims[d] + place[d])
    }

    pub(crate) fn rest_handles(&self) -> Vec<[f64; D]> {
        let coordinate = |place: [usize; D], d: usize| {
            let (i, n, size) = (place[d] as f64, self.dims[d] as f64, self.hi[d] - self.lo[d]);
            if self.basis == "bspline" {
                self.lo[d] + (i - 1.0) / (n - 3.0) * size
            } else {
                self.lo[d] + i / (n - 1.0) * size
            }
        };
        (0..self.handle_count()).map(|handle| std::array::from_fn(|d| coordinate(self.place(handle), d))).collect()
    }

    /// W at a point, all handles.
    pub(crate) fn row(&self, point: [f64; D]) -> Vec<f64> {
        let t: [f64; D] = std::array::from_fn(|d| (point[d] - self.lo[d]) / (self.hi[d] - self.lo[d]));
        if self.basis == "barytri" {
            return self.simplex_row(t);
        }
        let axes: [Vec<f64>; D] = std::array::from_fn(|d| axis(&self.basis, self.dims[d], t[d]));
        let weight = |handle: usize| (0..D).map(|d| axes[d][self.place(handle)[d]]).product();
        (0..self.handle_count()).map(weight).collect()
    }

    /// The corner with all steps up to the k-th largest coordinate taken weighs the drop from the k-th to the next.
    fn simplex_row(&self, t: [f64; D]) -> Vec<f64> {
        let mut row = vec![0.0; self.handle_count()];
        let mut place = [0; D];
        let mut local = Vec::new();
        for d in 0..D {
            let x = t[d] * (self.dims[d] - 1) as f64;
            place[d] = (x.floor().max(0.0) as usize).min(self.dims[d] - 2);
            local.push((x - place[d] as f64, d));
        }
        local.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut above = 1.0;
        for (x, d) in local {
            row[self.handle_at(place)] += above - x;
            above = x;
            place[d] += 1;
        }
        row[self.handle_at(place)] += above;
        row
    }
}

/// Basis functions of one axis, from their recursions.
fn axis(basis: &str, count: usize, t: f64) -> Vec<f64> {
    match basis {
        // De Casteljau, from the unit vectors.
        "bernstein" => (0..count)
            .map(|i| {
                let mut values: Vec<f64> = (0..count).map(|k| if k == i { 1.0 } else { 0.0 }).collect();
                while values.len() > 1 {
                    values = values.windows(2).map(|pair| (1.0 - t) * pair[0] + t * pair[1]).collect();
                }
                values[0]
            })
            .collect(),
        "bilinear" => {
            let x = t * (count - 1) as f64;
            let cell = (x.floor().max(0.0) as usize).min(count - 2);
            let u = x - cell as f64;
            (0..count)
                .map(|i| {
                    if i == cell {
                        1.0 - u
                    } else if i == cell + 1 {
                        u
                    } else {
                        0.0
                    }
                })
                .collect()
        }
        _ => {
            let x = t * (count - 3) as f64;
            let cell = (x.floor().max(0.0) as usize).min(count - 4);
            let u = x - cell as f64;
            // Cox and de Boor on whole knots: from the box function of the cell to cubics; u may be outside 0..=1.
            let mut values = vec![1.0];
            for degree in 1..=3 {
                let p = degree as f64;
                let mut next = vec![0.0; degree + 1];
                for (k, value) in values.iter().enumerate() {
                    let from_start = u + (degree - 1 - k) as f64;
                    next[k] += value * (p - from_start) / p;
                    next[k + 1] += value * (from_start) / p;
                }
                // A function of degree p − 1 that started `s` knots ago feeds the two that started s and s + 1 ago.
                values = next;
            }
            (0..count).map(|i| if (cell..cell + 4).contains(&i) { values[i - cell] } else { 0.0 }).collect()
        }
    }
}
