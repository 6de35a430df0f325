//! Finds the connected triangles of a layer whose lattice branches, from the scene at rest, independent of the view.
//!
//! In: a scene, the parts of a layer, the cuts and joins of the shot. Out: [`RestLinks`] between triangles, which are
//! numbered consecutively over all parts.

use super::loose_parts::joined_to_pinned;
use super::picture_cuts::{PictureCuts, fault};
use super::picture_parts::parts_of_triangles;
use super::rest_mesh::{RestMesh, rest_pose};
use super::screen_cut::ScreenCut;
use super::selection::{Patterns, ShotParts, cut_off};
use crate::image::{CHOSEN, OTHER};
use crate::pipeline::PipelineError;
use crate::pose::{Pose, PosedPart};
use crate::scene::Scene;
use crate::screen::{Camera, primitive};
use crate::shot::{Cut, CutSurface, Join, Layer, Shot, Source};
use crate::solve::{Link, LinkEnd, LinkKind, Topology, islands_of, link_at, nearest_link, solid_links, surface_links};
use crate::spelling::{self, pluralised};
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

/// What to do where ids separate nothing.
const IDS_HINT: &str =
    "fill parts that touch with different colours, or ids, in a picture that lies over the whole picture";

/// What to do where the regions of a drawing separate nothing.
const REGIONS_HINT: &str =
    "lines have to close the regions: raise `gap` if a line has gaps, lower `threshold` if it is faint";

/// What to do where a stroke over a scene separates nothing.
const SCENE_STROKE_HINT: &str = "draw it over the layer as the camera sees it in that frame, between parts that touch at rest, in frame \
                                 heights, y up; the surface of one mesh is opened by `open = true` only";

/// What to do where a stroke separates nothing.
const STROKE_HINT: &str = "draw it across the picture, in frame heights, y up: [0, 0] is the lower left corner";

/// The links of a layer. Those through its solid are as dense as the lattice needs, because the time to split a shape grows with their
/// number.
#[derive(Debug)]
pub(in crate::pipeline) struct RestLinks {
    /// Distances of the links through the solid, descending, with all links.
    by_pitch: Vec<(f64, Arc<Vec<Link>>)>,
    /// For every cut into many parts: the part of every triangle. Those without a pin are joined to others.
    divisions: Vec<Vec<u32>>,
    /// The links with those between the parts of divisions, if there are some.
    undivided: Vec<(f64, Arc<Vec<Link>>)>,
    /// The parts with an order in depth: the number of the cut, and for every triangle whether the part has it.
    ordered: Vec<(usize, Vec<bool>)>,
}

impl RestLinks {
    /// Returns the links for a lattice with this number of spans along its longer side.
    pub(in crate::pipeline) fn for_spans(&self, spans: usize) -> &Arc<Vec<Link>> {
        let is_dense_enough = |(pitch, _): &&(f64, Arc<Vec<Link>>)| pitch * spans as f64 <= SPANS_APART;
        let found = self.by_pitch.iter().find(is_dense_enough).or(self.by_pitch.last());
        &found.expect("a layer has links of at least one distance").1
    }

    /// Whether there are parts that pins join to others.
    pub(super) const fn has_divisions(&self) -> bool {
        !self.divisions.is_empty()
    }

    /// Returns the parts of a picture that have an order in depth: the number of the cut, and for every triangle whether the part has it.
    pub(in crate::pipeline) fn ordered_parts(&self) -> &[(usize, Vec<bool>)] {
        &self.ordered
    }

    /// Separates the parts of divisions that have pins. `pinned`: the triangles with pins.
    pub(super) fn divide(&mut self, pinned: &[usize]) {
        if !self.has_divisions() {
            return;
        }
        self.by_pitch.clone_from(&self.undivided);
        for (_, links) in &mut self.by_pitch {
            for labels in &self.divisions {
                let parts = joined_to_pinned(labels, links, pinned);
                Arc::make_mut(links).retain(|link| !is_between(&parts, link));
            }
        }
    }
}

/// Returns the links of every layer; `None` for layers whose lattice does not branch. `cuts`: those of pictures; `view`: the pose and the
/// camera of a frame. Adds a note for every join that undoes a cut.
///
/// # Errors
/// [`PipelineError::Mismatch`] if a cut separates nothing or names something that does not exist.
pub(super) fn rest_links(
    (shot, scene): (&Shot, &Scene),
    (parts_of_layer, cuts): (&[Vec<usize>], &PictureCuts),
    view: &dyn Fn(i32) -> (Pose, Camera),
    notes: &mut Vec<String>,
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
        let layer = LayerLinks { shot, scene, index, parts, rest, mesh: &mesh, cuts, view };
        let joins = layer.joins()?;
        let count_between = |by_pitch: &LinksByPitch| -> Vec<usize> {
            let links = by_pitch.last().map_or(&[][..], |(_, links)| links);
            joins.iter().map(|join| links.iter().filter(|link| join.is_between(link)).count()).collect()
        };
        let before = count_between(&by_pitch);
        let divisions = layer.cut(&mut by_pitch)?;
        let after = count_between(&by_pitch);
        for (number, join) in joins.iter().enumerate() {
            let Some(mut link) = join.link(&mesh) else { continue };
            if before[number] > 0 && after[number] == 0 {
                notes.extend(layer.note_on_cut(number, &link));
            }
            link.ends.iter_mut().for_each(|end| in_own_order(end, &mesh));
            by_pitch.iter_mut().for_each(|(_, links)| links.push(link));
        }
        let sorted = |(pitch, mut links): (f64, Vec<Link>)| {
            // Solves sort them at every time, which takes less where they are sorted already.
            links.sort_by_key(|link| {
                let [a, b] = link.ends.map(|end| end.triangle);
                [a.min(b), a.max(b)]
            });
            (pitch, Arc::new(links))
        };
        let by_pitch: Vec<_> = by_pitch.into_iter().map(sorted).collect();
        let undivided = if divisions.is_empty() { Vec::new() } else { by_pitch.clone() };
        let mut links = RestLinks { by_pitch, divisions, undivided, ordered: layer.ordered_parts() };
        links.divide(&[]);
        all.push(Some(links));
    }
    Ok(all)
}

/// Links with the distance of those through the solid, as a fraction of its diagonal.
type LinksByPitch = Vec<(f64, Vec<Link>)>;

/// Returns links along the surface, through the solid, and from covers to what they cover, with descending distances.
fn links_of_solid(mesh: &RestMesh, radius: f64) -> LinksByPitch {
    let on_surface = surface_links(&mesh.points, &mesh.triangles, radius);
    let islands = islands_of(mesh.triangles.len(), &on_surface);
    let with_solid = |pitch: f64| {
        let mut links = on_surface.clone();
        links.extend(solid_links(&mesh.points, &mesh.triangles, pitch, Some(&islands)));
        links.iter_mut().flat_map(|link| &mut link.ends).for_each(|end| in_own_order(end, mesh));
        (pitch, links)
    };
    // Where triangles are small, each has one link at all distances.
    let longest = longest_edge(mesh) / mesh.diagonal();
    let is_needed = |(number, pitch): &(usize, f64)| *number == 0 || longest > *pitch;
    PITCHES.into_iter().enumerate().filter(is_needed).map(|(_, pitch)| with_solid(pitch)).collect()
}

/// Converts barycentric coordinates of a mesh at rest to those of the part, whose corners may be listed in reverse order.
fn in_own_order(end: &mut LinkEnd, mesh: &RestMesh) {
    if mesh.is_mirrored[end.triangle as usize] {
        end.barycentric.swap(1, 2);
    }
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
    cuts: &'a PictureCuts,
    /// The pose and the camera of a frame.
    view: &'a dyn Fn(i32) -> (Pose, Camera),
}

impl LayerLinks<'_> {
    fn layer(&self) -> &Layer {
        &self.shot.layers[self.index]
    }

    fn fault(&self, key: &str, what: &str, hint: &str) -> PipelineError {
        fault((self.shot, self.index), key, what, hint)
    }

    /// Removes the links that cuts separate, except those between the parts of divisions, which are returned.
    fn cut(&self, by_pitch: &mut LinksByPitch) -> Result<Vec<Vec<u32>>, PipelineError> {
        let mut divisions = Vec::new();
        let count = |by_pitch: &LinksByPitch| by_pitch.last().map_or(0, |(_, links)| links.len());
        for (number, cut) in self.layer().connectivity.cuts.iter().enumerate() {
            let key = format!("cuts[{number}]");
            let before = count(by_pitch);
            let (what, hint) = match cut {
                Cut::Stroke(stroke) => {
                    by_pitch.iter_mut().for_each(|(_, links)| self.cut_along(stroke, links));
                    (format!("stroke {number} cuts nothing"), STROKE_HINT)
                }
                Cut::SceneStroke { points, frame, surface } => {
                    self.cut_on_screen((points, *frame), *surface, by_pitch);
                    (format!("the stroke cuts nothing in frame {frame}"), SCENE_STROKE_HINT)
                }
                Cut::Part { nodes, selection, surface } => {
                    let (parts, hint) = match self.shot.source {
                        Source::Scene(_) => (self.named(number, Patterns { nodes, rules: selection })?, NAMED_HINT),
                        Source::Images(_) | Source::Frame => (self.parts_of_picture(number), PAINTED_HINT),
                    };
                    by_pitch.iter_mut().for_each(|(_, links)| self.cut_apart(&parts, *surface, links));
                    let count = parts.iter().filter(|part| **part == CHOSEN).count();
                    let of = parts.len();
                    (format!("cut {number} separates nothing: it selects {count} of {of} triangles"), hint)
                }
                Cut::Ids(_) | Cut::Regions(_) => {
                    let parts = self.parts_of_picture(number);
                    let count = parts.iter().collect::<BTreeSet<_>>().len();
                    if by_pitch.iter().any(|(_, links)| links.iter().any(|link| is_between(&parts, link))) {
                        if cut.is_division() {
                            divisions.push(parts);
                        } else {
                            by_pitch
                                .iter_mut()
                                .for_each(|(_, links)| self.cut_apart(&parts, CutSurface::Opened, links));
                        }
                        continue;
                    }
                    let parts = pluralised(count, "part", "parts");
                    let hint = if matches!(cut, Cut::Ids(_)) { IDS_HINT } else { REGIONS_HINT };
                    (format!("cut {number} separates nothing: it divides the picture into {parts}"), hint)
                }
            };
            if count(by_pitch) == before {
                return Err(self.fault(&key, &what, hint));
            }
        }
        Ok(divisions)
    }

    /// Returns [`CHOSEN`] for the triangles of the part of a scene that a cut names.
    fn named(&self, number: usize, patterns: Patterns) -> Result<Vec<u32>, PipelineError> {
        let parts: Vec<PosedPart> = self.parts.iter().map(|&part| self.rest.parts[part].clone()).collect();
        let own = ShotParts { shot: self.shot, scene: self.scene, parts: &parts };
        let is_in = cut_off(own, [self.index, number], patterns)?;
        Ok(is_in.into_iter().map(|is_in| if is_in { CHOSEN } else { OTHER }).collect())
    }

    /// Returns the part of every triangle of a picture by one of its cuts.
    fn parts_of_picture(&self, cut: usize) -> Vec<u32> {
        let map = self.cuts.map(self.index, cut);
        map.map_or_else(
            || vec![OTHER; self.mesh.triangles.len()],
            |map| parts_of_triangles(self.mesh, map, self.shot.size),
        )
    }

    /// Returns the parts of a picture that have an order in depth.
    fn ordered_parts(&self) -> Vec<(usize, Vec<bool>)> {
        let orders = self.layer().connectivity.orders.iter().enumerate().filter(|(_, keys)| !keys.is_empty());
        let is_in = |(cut, _)| (cut, self.parts_of_picture(cut).into_iter().map(|part| part == CHOSEN).collect());
        orders.map(is_in).collect()
    }

    /// Removes the links between different parts; a surface that stays whole keeps its own.
    fn cut_apart(&self, parts: &[u32], surface: CutSurface, links: &mut Vec<Link>) {
        links.retain(|link| !is_between(parts, link) || self.is_kept(link, surface));
    }

    /// Whether a link is part of a surface that stays whole.
    fn is_kept(&self, link: &Link, surface: CutSurface) -> bool {
        let [from, to] = link.ends.map(|end| self.mesh.nodes[end.triangle as usize]);
        surface == CutSurface::Whole && link.kind == LinkKind::Edge && from == to
    }

    /// Removes the links that a stroke over the scene crosses as the camera sees them in a frame.
    fn cut_on_screen(&self, (stroke, frame): (&[[f64; 2]], i32), surface: CutSurface, by_pitch: &mut LinksByPitch) {
        let (pose, camera) = (self.view)(frame);
        let mesh = RestMesh::of(self.scene, &pose, self.parts);
        let cut = ScreenCut::new(stroke, &mesh, &camera);
        for (_, links) in by_pitch {
            links.retain(|link| self.is_kept(link, surface) || !cut.separates(link));
        }
    }

    /// Removes the links that a stroke crosses. Pictures are flat: their x and y are screen coordinates.
    fn cut_along(&self, stroke: &[[f64; 2]], links: &mut Vec<Link>) {
        let points = self.mesh.flat();
        links.retain(|link| {
            let way = link.ends.each_ref().map(|end| middle(&points, &self.mesh.triangles[end.triangle as usize]));
            !stroke.windows(2).any(|segment| meet(way, [segment[0], segment[1]]))
        });
    }

    /// Returns the triangles of the pairs that the shot joins.
    fn joins(&self) -> Result<Vec<JoinedParts>, PipelineError> {
        let mut all = Vec::new();
        for (number, Join { nodes: pair, at }) in self.layer().connectivity.joins.iter().enumerate() {
            let key = format!("joins[{number}]");
            let [from, to] = pair.each_ref().map(|pattern| self.triangles_of(pattern));
            let sides = [(&from, &pair[0]), (&to, &pair[1])];
            if let Some((_, pattern)) = sides.iter().find(|(triangles, _)| triangles.is_empty()) {
                let names = self.parts.iter().map(|&part| self.scene.nodes[self.rest.parts[part].node].name.as_str());
                let what = format!("no node of the layer with a mesh matches '{pattern}'");
                return Err(self.fault(&key, &what, &spelling::hint(pattern, names)));
            }
            if let Some(shared) = from.iter().find(|triangle| to.binary_search(triangle).is_ok()) {
                let name = &self.scene.nodes[self.mesh.nodes[*shared]].name;
                let what =
                    format!("'{}' and '{}' both name '{name}', which would be joined with itself", pair[0], pair[1]);
                return Err(self.fault(&key, &what, "name two different parts of the layer"));
            }
            all.push(JoinedParts { sides: [from, to], at: *at });
        }
        Ok(all)
    }

    /// Returns a note on parts that a cut separates and a join links where they are nearest, as they were linked without
    /// the cut; `None` if the join names its place.
    fn note_on_cut(&self, number: usize, link: &Link) -> Option<String> {
        let Join { nodes: [from, to], at: None } = &self.layer().connectivity.joins[number] else { return None };
        let end = link.ends[0];
        let corners = self.mesh.triangles[end.triangle as usize].map(|corner| self.mesh.points[corner as usize]);
        let nearest = (0..3).max_by(|&a, &b| end.barycentric[a].total_cmp(&end.barycentric[b])).unwrap_or(0);
        let [x, y, z] = corners[nearest];
        Some(format!(
            "layer '{}': joins[{number}] links '{from}' and '{to}' again, which a cut separates, where they are nearest, at [{x:.2}, {y:.2}, \
             {z:.2}]; to hinge one on the other, name the place: {{ nodes = [\"{from}\", \"{to}\"], at = [x, y, z] }}, in metres at rest",
            self.layer().name
        ))
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

/// The triangles of two parts that a shot joins, ascending.
struct JoinedParts {
    sides: [Vec<usize>; 2],
    /// The place, metres; `None`: where they are nearest.
    at: Option<[f64; 3]>,
}

impl JoinedParts {
    /// Whether a link connects the two parts.
    fn is_between(&self, link: &Link) -> bool {
        let [from, to] = link.ends.map(|end| end.triangle as usize);
        let is_on = |side: usize, triangle: usize| self.sides[side].binary_search(&triangle).is_ok();
        is_on(0, from) && is_on(1, to) || is_on(1, from) && is_on(0, to)
    }

    /// Returns the link of the join, in the order of the mesh at rest; `None` if a part is empty.
    fn link(&self, mesh: &RestMesh) -> Option<Link> {
        let sides = self.sides.each_ref().map(Vec::as_slice);
        match &self.at {
            Some(at) => link_at(&mesh.points, &mesh.triangles, sides, at),
            None => nearest_link(&mesh.points, &mesh.triangles, sides),
        }
    }
}

/// Whether a link joins triangles of different parts. `parts`: #triangles.
fn is_between(parts: &[u32], link: &Link) -> bool {
    let [from, to] = link.ends.map(|end| parts[end.triangle as usize]);
    from != to
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
