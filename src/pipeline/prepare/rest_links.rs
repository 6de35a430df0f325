//! Finds the connected triangles of a layer whose lattice branches, from the scene at rest, independent of the view.
//!
//! In: a scene, the parts of a layer, the cuts and joins of the shot. Out: [`RestLinks`] between triangles, which are
//! numbered consecutively over all parts.

use super::rest_mesh::{RestMesh, rest_pose};
use super::selection::cut_off;
use crate::image::PaintedMap;
use crate::pipeline::PipelineError;
use crate::pose::Pose;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{Cut, CutSurface, Layer, PaintedMask, Selection, Shot, Source};
use crate::solve::{Link, LinkEnd, LinkKind, Topology, islands_of, nearest_link, solid_links, surface_links};
use crate::space::FrameSize;
use crate::spelling;
use glam::DVec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Distances of the links through a solid, as fractions of its diagonal.
const PITCHES: [f64; 3] = [1.0 / 14.0, 1.0 / 28.0, 1.0 / 48.0];

/// Largest distance of the links through a solid, in spans of the lattice: the support of a B-spline is four spans wide, that of a
/// bilinear basis two.
const SPANS_APART: f64 = 0.5;

/// What to do where a cut by name separates nothing.
const NAMED_HINT: &str = "name a part that touches the rest of the layer at rest (`pinwarp info` lists names); the surface of one mesh \
                          is opened by `open = true` only";

/// What to do where a cut by mask separates nothing.
const PAINTED_HINT: &str =
    "paint some of the drawing white in the mask, which lies over the whole picture, and the rest black";

/// The links of a layer. Those through its solid are as dense as the lattice needs, because the time to split a shape grows with their
/// number.
#[derive(Debug)]
pub(in crate::pipeline) struct RestLinks {
    /// Distances of the links through the solid, descending, with all links.
    by_pitch: Vec<(f64, Arc<Vec<Link>>)>,
}

impl RestLinks {
    /// Returns the links for a lattice with this number of spans along its longer side.
    pub(in crate::pipeline) fn for_spans(&self, spans: usize) -> &Arc<Vec<Link>> {
        let is_dense_enough = |(pitch, _): &&(f64, Arc<Vec<Link>>)| pitch * spans as f64 <= SPANS_APART;
        let found = self.by_pitch.iter().find(is_dense_enough).or(self.by_pitch.last());
        &found.expect("a layer has links of at least one distance").1
    }
}

/// Returns the links of every layer; `None` for layers whose lattice does not branch.
///
/// # Errors
/// [`PipelineError::Mismatch`] if a cut separates nothing or names something that does not exist.
pub(in crate::pipeline) fn rest_links(
    shot: &Shot,
    scene: &Scene,
    parts_of_layer: &[Vec<usize>],
) -> Result<Vec<Option<RestLinks>>, PipelineError> {
    let mut rest = None;
    let mut all = Vec::with_capacity(shot.layers.len());
    for (index, (layer, parts)) in shot.layers.iter().zip(parts_of_layer).enumerate() {
        if layer.settings.topology == Topology::Plain {
            all.push(None);
            continue;
        }
        let rest = rest.get_or_insert_with(|| rest_pose(scene));
        let mesh = RestMesh::of(scene, rest, parts);
        let radius = layer.connectivity.island_radius * mesh.diagonal();
        let mut by_pitch = match shot.source {
            Source::Scene(_) => links_of_solid(&mesh, radius),
            Source::Images(_) | Source::Frame => vec![(1.0, surface_links(&mesh.flat(), &mesh.triangles, radius))],
        };
        let layer = LayerLinks { shot, scene, index, parts, rest, mesh: &mesh };
        layer.cut(&mut by_pitch)?;
        layer.join(&mut by_pitch)?;
        let sorted = |(pitch, mut links): (f64, Vec<Link>)| {
            // Solves sort them at every time, which takes less where they are sorted already.
            links.sort_by_key(|link| {
                let [a, b] = link.ends.map(|end| end.triangle);
                [a.min(b), a.max(b)]
            });
            (pitch, Arc::new(links))
        };
        all.push(Some(RestLinks { by_pitch: by_pitch.into_iter().map(sorted).collect() }));
    }
    Ok(all)
}

/// Links with the distance of those through the solid, as a fraction of its diagonal.
type LinksByPitch = Vec<(f64, Vec<Link>)>;

/// Returns links along the surface, through the solid, and from covers to what they cover, with descending distances.
fn links_of_solid(mesh: &RestMesh, radius: f64) -> LinksByPitch {
    let on_surface = surface_links(&mesh.points, &mesh.triangles, radius);
    let islands = islands_of(mesh.triangles.len(), &on_surface);
    let in_own_order = |end: &mut LinkEnd| {
        if mesh.is_mirrored[end.triangle as usize] {
            end.barycentric.swap(1, 2);
        }
    };
    let with_solid = |pitch: f64| {
        let mut links = on_surface.clone();
        links.extend(solid_links(&mesh.points, &mesh.triangles, pitch, Some(&islands)));
        links.iter_mut().flat_map(|link| &mut link.ends).for_each(in_own_order);
        (pitch, links)
    };
    // Where triangles are small, each has one link at all distances.
    let longest = longest_edge(mesh) / mesh.diagonal();
    let is_needed = |(number, pitch): &(usize, f64)| *number == 0 || longest > *pitch;
    PITCHES.into_iter().enumerate().filter(is_needed).map(|(_, pitch)| with_solid(pitch)).collect()
}

fn longest_edge(mesh: &RestMesh) -> f64 {
    let place = |corner: u32| DVec3::from(mesh.points[corner as usize]);
    let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.map(|[from, to]| place(from).distance_squared(place(to))).fold(0.0, f64::max).sqrt()
}

/// The inputs for the cuts and joins of one layer.
struct LayerLinks<'a> {
    shot: &'a Shot,
    scene: &'a Scene,
    index: usize,
    parts: &'a [usize],
    rest: &'a Pose,
    mesh: &'a RestMesh,
}

impl LayerLinks<'_> {
    fn layer(&self) -> &Layer {
        &self.shot.layers[self.index]
    }

    fn fault(&self, key: &str, what: &str, hint: &str) -> PipelineError {
        let (index, name) = (self.index, &self.layer().name);
        PipelineError::mismatch(
            self.shot,
            &format!("layer[{index}].lattice.{key}"),
            format!("layer '{name}': {what}"),
            hint,
        )
    }

    /// Removes the links that cuts separate.
    fn cut(&self, by_pitch: &mut LinksByPitch) -> Result<(), PipelineError> {
        let count = |by_pitch: &LinksByPitch| by_pitch.last().map_or(0, |(_, links)| links.len());
        for (number, cut) in self.layer().connectivity.cuts.iter().enumerate() {
            let key = format!("cuts[{number}]");
            let before = count(by_pitch);
            match cut {
                Cut::Stroke(stroke) => by_pitch.iter_mut().for_each(|(_, links)| self.cut_along(stroke, links)),
                Cut::Part { nodes, selection, surface } => {
                    let (is_in, hint) = match self.shot.source {
                        Source::Scene(_) => (self.named(number, (nodes, selection))?, NAMED_HINT),
                        Source::Images(_) | Source::Frame => {
                            (self.painted(&key, selection.mask.as_ref())?, PAINTED_HINT)
                        }
                    };
                    by_pitch.iter_mut().for_each(|(_, links)| self.cut_part(&is_in, *surface, links));
                    if count(by_pitch) == before {
                        let count = is_in.iter().filter(|is_in| **is_in).count();
                        let of = is_in.len();
                        let what = format!("cut {number} separates nothing: it selects {count} of {of} triangles");
                        return Err(self.fault(&key, &what, hint));
                    }
                }
            }
            if count(by_pitch) == before {
                let hint = "draw it across the picture, in frame heights, y up: [0, 0] is the lower left corner";
                return Err(self.fault(&key, &format!("stroke {number} cuts nothing"), hint));
            }
        }
        Ok(())
    }

    /// Returns whether each triangle belongs to the part of a scene that a cut names.
    fn named(&self, number: usize, rules: (&[String], &Selection)) -> Result<Vec<bool>, PipelineError> {
        let parts = (self.rest.parts.as_slice(), self.parts);
        cut_off((self.shot, self.scene), [self.index, number], rules, parts)
    }

    /// Returns whether the middle of each triangle of a picture is painted in a mask that lies over the frame.
    fn painted(&self, key: &str, mask: Option<&PaintedMask>) -> Result<Vec<bool>, PipelineError> {
        let Some(mask) = mask else { return Ok(vec![false; self.mesh.triangles.len()]) };
        let file_key = format!("{key}.mask.file");
        let map = PaintedMap::read(&mask.file, mask.channel.index());
        let map = map.map_err(|error| {
            self.fault(&file_key, &error.to_string(), "give a PNG, JPEG or EXR file of the picture's shape")
        })?;
        let FrameSize { width, height, .. } = self.shot.size;
        if !map.has_shape_of([width, height]) {
            let [w, h] = map.size;
            let what = format!("the mask has {w} x {h} pixels, the picture {width} x {height}");
            return Err(self.fault(&file_key, &what, "paint it over the picture; other sizes of that shape will do"));
        }
        let points = self.mesh.flat();
        let aspect = self.shot.size.aspect();
        let is_painted = |corners: &[u32; 3]| {
            let [x, y] = middle(&points, corners);
            map.at([(x / aspect) as f32, (1.0 - y) as f32]) > 0.5
        };
        Ok(self.mesh.triangles.iter().map(is_painted).collect())
    }

    /// Removes the links between a part and everything else; a surface that stays whole keeps its own.
    fn cut_part(&self, is_in: &[bool], surface: CutSurface, links: &mut Vec<Link>) {
        links.retain(|link| {
            let [from, to] = link.ends.map(|end| end.triangle as usize);
            let is_on_surface = link.kind == LinkKind::Edge && self.mesh.nodes[from] == self.mesh.nodes[to];
            is_in[from] == is_in[to] || surface == CutSurface::Whole && is_on_surface
        });
    }

    /// Removes the links that a stroke crosses. Pictures are flat: their x and y are screen coordinates.
    fn cut_along(&self, stroke: &[[f64; 2]], links: &mut Vec<Link>) {
        let points = self.mesh.flat();
        links.retain(|link| {
            let way = link.ends.each_ref().map(|end| middle(&points, &self.mesh.triangles[end.triangle as usize]));
            !stroke.windows(2).any(|segment| meet(way, [segment[0], segment[1]]))
        });
    }

    /// Links the pairs that the shot joins, at their nearest points.
    fn join(&self, by_pitch: &mut LinksByPitch) -> Result<(), PipelineError> {
        for (number, pair) in self.layer().connectivity.joins.iter().enumerate() {
            let key = format!("joins[{number}]");
            let [from, to] = pair.each_ref().map(|pattern| self.triangles_of(pattern));
            let sides = [(from, &pair[0]), (to, &pair[1])];
            if let Some((_, pattern)) = sides.iter().find(|(triangles, _)| triangles.is_empty()) {
                let names = self.parts.iter().map(|&part| self.scene.nodes[self.rest.parts[part].node].name.as_str());
                let what = format!("no node of the layer with a mesh matches '{pattern}'");
                return Err(self.fault(&key, &what, &spelling::hint(pattern, names)));
            }
            let [(from, _), (to, _)] = sides;
            if let Some(shared) = from.iter().find(|triangle| to.binary_search(triangle).is_ok()) {
                let name = &self.scene.nodes[self.mesh.nodes[*shared]].name;
                let what =
                    format!("'{}' and '{}' both name '{name}', which would be joined with itself", pair[0], pair[1]);
                return Err(self.fault(&key, &what, "name two different parts of the layer"));
            }
            let link = nearest_link(&self.mesh.points, &self.mesh.triangles, [&from, &to]);
            by_pitch.iter_mut().for_each(|(_, links)| links.extend(link));
        }
        Ok(())
    }

    /// Returns the triangles of the nodes that match a pattern, and of their descendants.
    fn triangles_of(&self, pattern: &str) -> Vec<usize> {
        let nodes: BTreeSet<usize> =
            self.scene.matching(pattern).into_iter().flat_map(|node| self.scene.subtree(node)).collect();
        let mut first = 0;
        let mut found = Vec::new();
        for part in self.parts.iter().map(|&part| &self.rest.parts[part]) {
            let count = primitive(self.scene, part).triangles.len();
            if nodes.contains(&part.node) {
                found.extend(first..first + count);
            }
            first += count;
        }
        found
    }
}

/// The centroid of a triangle.
fn middle(points: &[[f64; 2]], corners: &[u32; 3]) -> [f64; 2] {
    [0, 1].map(|axis| corners.iter().map(|&corner| points[corner as usize][axis]).sum::<f64>() / 3.0)
}

/// Whether two segments cross or touch.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 && a != b
}
