//! Finds the plane at which a model at rest is its own mirror image.
//!
//! In: a [`RestMesh`]. Out: a [`Symmetry`]. Method: iterative closest points (P. Besl and N. McKay 1992; distances along normals: Y.
//! Chen and G. Medioni 1992) for a reflection, from several first planes. Planes across the scene's axes, through the origin or the
//! middle of the bounds, are preferred as they are: models are built about them.

use super::rest_mesh::RestMesh;
use crate::solve::symmetric_eigen;
use glam::{DMat3, DVec3};
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Number of points on the surface to which reflections are compared.
const TARGETS: usize = 20_000;

/// Number of points that are reflected.
const PROBES: usize = 1_000;

/// Maximum number of improvements of a plane.
const ROUNDS: usize = 12;

/// Distance up to which a reflected point counts as met, in diagonals of the model.
const MET_WITHIN: f64 = 0.015;

/// Mean distance of the surface from a plane, in diagonals, below which the plane contains the model instead of dividing it.
const LEAST_EXTENT: f64 = 0.02;

/// The axes across which a plane may lie, the preferred one first.
const FAMILIES: [DVec3; 3] = [DVec3::X, DVec3::Z, DVec3::Y];

/// Advantage in the fraction met of an earlier plane over one across the same axis, and over one across another axis: many a body is
/// nearly its own mirror image from front to back, and less so from left to right where it holds something.
const PREFERENCES: [f64; 2] = [0.03, 0.25];

/// Maximum advantage of an earlier plane, as a fraction of what is missing to an exact symmetry.
const MISSING_FRACTION: f64 = 0.75;

/// Maximum number of steps along normals.
const EXACT_ROUNDS: usize = 6;

/// Smallest determinant, relative to the entries, of a step along normals that determines the plane: a flat picture's do not.
const LEAST_DETERMINANT: f64 = 1e-9;

/// A plane of symmetry n · p = offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::pipeline) struct Symmetry {
    /// Unit normal, scene space.
    pub(in crate::pipeline) normal: DVec3,
    /// Distance from the origin along the normal, metres.
    pub(in crate::pipeline) offset: f64,
    /// Fraction of the surface whose reflection lies on the surface, 0..=1.
    pub(in crate::pipeline) met: f64,
}

/// Where a layer at rest mirrors.
#[cfg(any(test, feature = "editor"))]
#[derive(Clone, Copy, Debug)]
pub(in crate::pipeline) struct LayerMirror {
    pub(in crate::pipeline) plane: Symmetry,
    /// Diagonal of the layer's bounds, metres.
    pub(in crate::pipeline) diagonal: f64,
}

impl Symmetry {
    /// Returns the reflection of a point.
    pub(in crate::pipeline) fn reflected(&self, point: DVec3) -> DVec3 {
        point - 2.0 * (self.normal.dot(point) - self.offset) * self.normal
    }

    /// Returns the plane that divides a model best; `None` if the model is empty, or no plane divides it.
    pub(in crate::pipeline) fn of(mesh: &RestMesh) -> Option<Self> {
        let surface = Surface::of(mesh);
        let [low, high] = mesh.bounds();
        let center = surface.probes.iter().map(|probe| probe.at).sum::<DVec3>() / surface.probes.len().max(1) as f64;
        let mut best: [Option<Self>; 3] = [None; 3];
        let mut consider = |found: Option<Self>| {
            if let Some(found) = found {
                let best = &mut best[found.family()];
                *best = preferred(*best, Some(found), PREFERENCES[0]);
            }
        };
        for normal in FAMILIES {
            for offset in [0.0, normal.dot(0.5 * (low + high))] {
                consider(surface.rated(Self { normal, offset, met: 0.0 }));
            }
        }
        for normal in first_normals(&surface.probes, center) {
            consider(surface.improved(normal, center));
        }
        best.into_iter().fold(None, |best, found| preferred(best, found, PREFERENCES[1]))
    }

    /// Returns the index of the axis in [`FAMILIES`] that is nearest to the normal.
    fn family(&self) -> usize {
        let along = FAMILIES.map(|axis| self.normal.dot(axis).abs());
        (0..3).fold(0, |best, axis| if along[axis] > along[best] { axis } else { best })
    }
}

/// Returns the second plane if it is better than the first by more than the first one's advantage, which is less where little is missing
/// to an exact symmetry.
fn preferred(first: Option<Symmetry>, second: Option<Symmetry>, advantage: f64) -> Option<Symmetry> {
    let is_better = |second: &Symmetry| {
        first.is_none_or(|first| second.met > first.met + advantage.min(MISSING_FRACTION * (1.0 - first.met)))
    };
    second.filter(is_better).or(first)
}

/// Returns the axes of the scene, then the principal axes of the points.
fn first_normals(points: &[SurfacePoint], center: DVec3) -> [DVec3; 6] {
    let mut covariance = [[0.0; 3]; 3];
    for point in points.iter().map(|point| (point.at - center).to_array()) {
        for (row, x) in covariance.iter_mut().zip(point) {
            row.iter_mut().zip(point).for_each(|(entry, y)| *entry += x * y);
        }
    }
    let (_, vectors) = symmetric_eigen(&covariance);
    let column = |k: usize| DVec3::new(vectors[0][k], vectors[1][k], vectors[2][k]);
    [DVec3::X, DVec3::Z, DVec3::Y, column(0), column(1), column(2)]
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
struct SurfacePoint {
    at: DVec3,
    normal: DVec3,
}

/// Points of a surface.
struct Surface {
    tree: RTree<GeomWithData<[f64; 3], DVec3>>,
    probes: Vec<SurfacePoint>,
    diagonal: f64,
}

impl Surface {
    fn of(mesh: &RestMesh) -> Self {
        let leaf = |point: SurfacePoint| GeomWithData::new(point.at.to_array(), point.normal);
        let tree = RTree::bulk_load(spread(mesh, TARGETS).into_iter().map(leaf).collect());
        Self { tree, probes: spread(mesh, PROBES), diagonal: mesh.diagonal() }
    }

    /// Improves the plane through `through` with this normal; `None` if the model lies in the plane.
    fn improved(&self, normal: DVec3, through: DVec3) -> Option<Symmetry> {
        let mut plane = Symmetry { normal, offset: normal.dot(through), met: 0.0 };
        plane.met = self.met(&plane);
        for _ in 0..ROUNDS {
            let next = self.step(&plane)?;
            if next.met <= plane.met {
                break;
            }
            plane = next;
        }
        for _ in 0..EXACT_ROUNDS {
            let Some(next) = self.step_along_normals(&plane).filter(|next| next.met >= plane.met) else { break };
            plane = next;
        }
        self.rated(plane)
    }

    /// Returns the plane with the fraction that it maps onto the surface; `None` if the model lies in the plane.
    fn rated(&self, plane: Symmetry) -> Option<Symmetry> {
        let extent = self.probes.iter().map(|probe| (plane.normal.dot(probe.at) - plane.offset).abs()).sum::<f64>();
        let divides = extent > LEAST_EXTENT * self.diagonal * self.probes.len() as f64;
        divides.then(|| Symmetry { met: self.met(&plane), ..plane })
    }

    /// Returns the plane that maps the probes best to the points nearest to their reflections: with p and q relative to
    /// their common mean, Σ |S p − q|² is least for the normal n with the least nᵀ (Σ p qᵀ + q pᵀ) n.
    fn step(&self, plane: &Symmetry) -> Option<Symmetry> {
        let nearest = |probe: &SurfacePoint| Some([probe.at, self.nearest(plane.reflected(probe.at))?.at]);
        let pairs: Vec<[DVec3; 2]> = self.probes.iter().filter_map(nearest).collect();
        let mean = pairs.iter().map(|[p, q]| 0.5 * (*p + *q)).sum::<DVec3>() / pairs.len() as f64;
        let mut sum = [[0.0; 3]; 3];
        for pair in &pairs {
            let [p, q] = pair.map(|point| (point - mean).to_array());
            for (i, row) in sum.iter_mut().enumerate() {
                row.iter_mut().enumerate().for_each(|(j, entry)| *entry += p[i] * q[j] + q[i] * p[j]);
            }
        }
        let (values, vectors) = symmetric_eigen(&sum);
        let least = (0..3).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
        let normal = DVec3::new(vectors[0][least], vectors[1][least], vectors[2][least]).try_normalize()?;
        let normal = if normal.dot(plane.normal) < 0.0 { -normal } else { normal };
        self.rated(Symmetry { normal, offset: normal.dot(mean), met: 0.0 })
    }

    /// One Gauss-Newton step for Σ (m · (S p − q))² over the probes that are met, m the normal at q: distances along the
    /// surface, which are those of the sampling, do not count. `None` if that does not determine the plane.
    fn step_along_normals(&self, plane: &Symmetry) -> Option<Symmetry> {
        let [across, up] = [plane.normal.any_orthonormal_pair().0, plane.normal.any_orthonormal_pair().1];
        let (mut matrix, mut side) = (DMat3::ZERO, DVec3::ZERO);
        for probe in &self.probes {
            let image = plane.reflected(probe.at);
            let Some(found) = self.nearest(image).filter(|found| found.at.distance(image) <= self.met_within()) else {
                continue;
            };
            let height = plane.normal.dot(probe.at) - plane.offset;
            // The derivatives of S p by the two tilts of the normal and by the offset.
            let tilt = |by: DVec3| -2.0 * (by.dot(probe.at) * plane.normal + height * by);
            let row = DVec3::new(
                found.normal.dot(tilt(across)),
                found.normal.dot(tilt(up)),
                found.normal.dot(2.0 * plane.normal),
            );
            matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            side -= row * found.normal.dot(image - found.at);
        }
        let size = matrix.col(0).length() * matrix.col(1).length() * matrix.col(2).length();
        if matrix.determinant() <= LEAST_DETERMINANT * size {
            return None;
        }
        let by = matrix.inverse() * side;
        let normal = (plane.normal + by.x * across + by.y * up).try_normalize()?;
        self.rated(Symmetry { normal, offset: plane.offset + by.z, met: 0.0 })
    }

    fn met_within(&self) -> f64 {
        MET_WITHIN * self.diagonal
    }

    fn nearest(&self, point: DVec3) -> Option<SurfacePoint> {
        let found = self.tree.nearest_neighbor(point.to_array())?;
        Some(SurfacePoint { at: DVec3::from(*found.geom()), normal: found.data })
    }

    /// Returns the fraction of the probes whose reflections lie on the surface.
    fn met(&self, plane: &Symmetry) -> f64 {
        let is_met = |probe: &&SurfacePoint| {
            let image = plane.reflected(probe.at);
            self.nearest(image).is_some_and(|found| found.at.distance(image) <= self.met_within())
        };
        self.probes.iter().filter(is_met).count() as f64 / self.probes.len().max(1) as f64
    }
}

/// Returns points spread evenly over the area of a mesh, the same for the same mesh.
fn spread(mesh: &RestMesh, count: usize) -> Vec<SurfacePoint> {
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| DVec3::from(mesh.points[corner as usize]));
    let doubled = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
    let areas = mesh.triangles.iter().map(|triangle| doubled(corners(triangle)).length());
    let whole: f64 = areas.filter(|area| area.is_finite()).sum();
    let mut points = Vec::with_capacity(count);
    let mut seen = 0.0;
    for triangle in &mesh.triangles {
        let [a, b, c] = corners(triangle);
        let area = doubled([a, b, c]);
        if !(area.is_finite() && whole > 0.0) {
            continue;
        }
        seen += area.length();
        while points.len() < count && (points.len() as f64 + 0.5) * whole < seen * count as f64 {
            // The R2 sequence (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
            let [u, v] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2]
                .map(|step| (0.5 + step * points.len() as f64).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            points.push(SurfacePoint { at: a + u * (b - a) + v * (c - a), normal: area.normalize_or_zero() });
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with a nose and one longer arm on each side, rotated about y and moved.
    fn figure(angle: f64, arms: [f64; 2]) -> RestMesh {
        let mut mesh = RestMesh::default();
        let mut add = |lo: [f64; 3], hi: [f64; 3]| {
            let base = mesh.points.len() as u32;
            for k in 0..8 {
                let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] });
                let (sin, cos) = f64::sin_cos(angle);
                mesh.points.push([3.0 + cos * at[0] + sin * at[2], at[1], 5.0 - sin * at[0] + cos * at[2]]);
            }
            let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
            mesh.triangles.extend(
                quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t: [u32; 3]| t.map(|k| k + base)),
            );
        };
        add([-0.3, 0.0, -0.2], [0.3, 2.0, 0.2]);
        add([-0.1, 1.6, 0.2], [0.1, 1.8, 0.6]);
        add([0.3, 1.2, -0.1], [0.3 + arms[0], 1.4, 0.1]);
        add([-0.3 - arms[1], 1.2, -0.1], [-0.3, 1.4, 0.1]);
        mesh
    }

    #[test]
    fn a_turned_figure_is_divided_between_its_arms() {
        for angle in [0.0, 0.3, 1.1, 1.6, 2.5] {
            let found = Symmetry::of(&figure(angle, [0.8, 0.8])).expect("a plane");
            let (sin, cos) = f64::sin_cos(angle);
            let across = DVec3::new(cos, 0.0, -sin);
            assert!(found.normal.dot(across).abs() > 0.9999, "{angle}: {found:?}");
            assert!(
                (found.offset.abs() - across.dot(DVec3::new(3.0, 0.0, 5.0)).abs()).abs() < 0.01,
                "{angle}: {found:?}"
            );
            assert!(found.met > 0.97, "{angle}: {found:?}");
        }
    }

    #[test]
    fn a_lopsided_figure_is_met_in_part() {
        let found = Symmetry::of(&figure(0.0, [0.8, 0.5])).expect("a plane");
        assert!((0.5..0.99).contains(&found.met) && found.normal.x.abs() > 0.999, "{found:?}");
    }

    #[test]
    fn a_flat_picture_is_divided_upright_not_laid_on_itself() {
        let mut mesh = figure(0.0, [0.8, 0.8]);
        mesh.points.iter_mut().for_each(|point| point[2] = 0.0);
        let found = Symmetry::of(&mesh).expect("a plane");
        assert!(found.normal.x.abs() > 0.999 && (found.offset.abs() - 3.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn nothing_has_no_plane() {
        assert_eq!(Symmetry::of(&RestMesh::default()), None);
    }
}
