//! Attaches pins to the scene: resolves node names to indices once, and then computes the pin's rest point in every frame.
//!
//! In: the anchor of a pin. Out: a [`PinAnchor`], and its [`RestPoint`] at any time.

use crate::pipeline::PipelineError;
use crate::pose::{Pose, PosedPart};
use crate::scene::{Primitive, Scene};
use crate::screen::{Camera, Hit, ScreenMesh, primitive};
use crate::shot::{Anchor, Shot, Source};
use crate::smoothstep::smoothstep;
use crate::space::ScreenPoint;
use crate::spelling;
use glam::{DVec2, DVec3};

/// Depth at which a pin starts to fade out, in near-plane distances; it has faded out at the near plane.
const FADE_STARTS_AT: f64 = 2.0;

/// Maximum distance between a stored and a current rest position without a warning, as a fraction of the primitive's size.
const MOVED_FRACTION: f64 = 1e-3;

/// The point to which a pin is attached, given by indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PinAnchor {
    /// A point on a triangle.
    Surface {
        /// Index into the pose's parts.
        part: usize,
        /// Index into the part's triangles.
        triangle: usize,
        /// Vertex indices.
        corners: [u32; 3],
        /// Barycentric coordinates of the point.
        barycentric: [f64; 3],
    },
    /// A fixed point of the screen.
    Screen(ScreenPoint),
}

/// The position of a pinned point before the warp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RestPoint {
    /// Position on the screen.
    pub point: ScreenPoint,
    /// 1, falling to 0 where the point approaches the near plane; 0 at the plane and in front of it.
    pub presence: f64,
}

impl PinAnchor {
    /// Returns the pinned point in a projected pose.
    #[must_use]
    pub(crate) fn rest(&self, mesh: &ScreenMesh, camera: &Camera) -> RestPoint {
        match *self {
            Self::Screen(point) => RestPoint { point, presence: 1.0 },
            Self::Surface { part, corners, barycentric, .. } => {
                let vertices = corners.map(|corner| mesh.parts[part].vertices[corner as usize]);
                let h =
                    vertices[0].h * barycentric[0] + vertices[1].h * barycentric[1] + vertices[2].h * barycentric[2];
                let mix = |of: fn(&crate::screen::Projected) -> f64| -> f64 {
                    vertices.iter().zip(barycentric).map(|(vertex, share)| of(vertex) * share).sum()
                };
                let (w, depth) = (mix(|vertex| vertex.w), mix(|vertex| vertex.depth));
                if w <= 0.0 {
                    return RestPoint { point: ScreenPoint::default(), presence: 0.0 };
                }
                RestPoint { point: ScreenPoint(h / w), presence: presence(depth, camera) }
            }
        }
    }

    /// Returns the pinned point of a pose in scene space, metres; `None` for a point of the screen.
    #[must_use]
    pub(crate) fn in_scene(&self, pose: &Pose) -> Option<DVec3> {
        let Self::Surface { part, corners, barycentric, .. } = *self else { return None };
        let place = |corner: usize| pose.parts[part].positions[corners[corner] as usize].0.as_dvec3();
        Some((0..3).map(|corner| place(corner) * barycentric[corner]).sum())
    }

    /// Creates the anchor of a pick.
    #[must_use]
    pub(crate) fn on(scene: &Scene, pose: &Pose, hit: &Hit) -> Self {
        let corners = primitive(scene, &pose.parts[hit.part]).triangles[hit.triangle];
        Self::Surface { part: hit.part, triangle: hit.triangle, corners, barycentric: hit.barycentric }
    }
}

/// Returns 1 for depths well beyond the near plane, falling to 0 at the plane. Parallel projections do not grow without
/// bound at the near plane, so for them the function is a step.
pub(in crate::pipeline) fn presence(depth: f64, camera: &Camera) -> f64 {
    let near = camera.near();
    if camera.is_parallel() {
        return if depth >= near { 1.0 } else { 0.0 };
    }
    smoothstep((depth / near - 1.0) / (FADE_STARTS_AT - 1.0))
}

/// Finds the triangle of a surface anchor, and returns a note if its stored rest position no longer matches.
pub(in crate::pipeline) fn find(
    (shot, place): (&Shot, [usize; 2]),
    scene: &Scene,
    parts: &[PosedPart],
) -> Result<(PinAnchor, Option<String>), PipelineError> {
    let layer = &shot.layers[place[0]];
    let pin = &layer.pins[place[1]];
    let fault = |(what, hint)| mismatch(shot, (place, "anchor"), (what, hint));
    let Anchor::Surface { node, primitive: wanted, triangle, barycentric, rest } = &pin.anchor else {
        return Err(fault(("is not a surface anchor".into(), "pick it again".into())));
    };
    if scene.node_named(node).is_none() {
        let names = scene.nodes.iter().filter(|node| node.mesh.is_some()).map(|node| node.name.as_str());
        let hint = spelling::hint(node, names);
        return Err(fault((format!("there is no node '{node}' in the scene"), hint)));
    }
    // Names need not be unique: the first node of that name with this primitive is used.
    let is_named =
        |part: &&PosedPart| scene.nodes[part.node].name == *node && !primitive(scene, part).triangles.is_empty();
    let Some(part) = parts.iter().position(|part| is_named(&part) && part.primitive == *wanted) else {
        let count = parts.iter().filter(is_named).count();
        let what = format!("node '{node}' has no primitive {wanted} with triangles");
        return Err(fault((what, format!("it has {count}, counted from 0"))));
    };
    let source = primitive(scene, &parts[part]);
    // How the outline of a picture is divided may differ between versions of the program: what was stored is the place.
    if let (Source::Images(_), Some([x, y, _])) = (&shot.source, *rest)
        && let stored = DVec2::new(x, y)
        && point_on(source, *triangle, *barycentric)
            .is_none_or(|held| held.truncate().distance(stored) > MOVED_FRACTION)
        && let Some((triangle, barycentric)) = place_on_picture(source, stored)
    {
        let corners = source.triangles[triangle];
        return Ok((PinAnchor::Surface { part, triangle, corners, barycentric }, None));
    }
    let Some(&corners) = source.triangles.get(*triangle) else {
        let what = format!("node '{node}', primitive {wanted} has no triangle {triangle}");
        let hint = format!("its last is {}; `pinwarp pick` prints a ready anchor", source.triangles.len() - 1);
        return Err(fault((what, hint)));
    };
    let now = point_on(source, *triangle, *barycentric).unwrap_or_default();
    let size = source.positions.iter().map(|point| point.as_dvec3().length()).fold(0.0, f64::max);
    let moved = rest.map(DVec3::from_array).filter(|&stored| stored.distance(now) > MOVED_FRACTION * size);
    let note = moved.map(|stored| {
        format!(
            "layer '{}', pin '{}': its triangle was at {stored} when it was placed and is at {now} now; was the scene \
             exported again? Place it anew with `pinwarp pick --write {}`",
            layer.name, pin.name, pin.name
        )
    });
    Ok((PinAnchor::Surface { part, triangle: *triangle, corners, barycentric: *barycentric }, note))
}

/// Returns a point of a primitive, given by a triangle and barycentric coordinates; `None` if there is no such triangle.
fn point_on(primitive: &Primitive, triangle: usize, barycentric: [f64; 3]) -> Option<DVec3> {
    let corners = primitive.triangles.get(triangle)?;
    let place = |corner: usize| primitive.positions[corners[corner] as usize].as_dvec3() * barycentric[corner];
    Some(place(0) + place(1) + place(2))
}

/// Returns the triangle of a picture that holds a point, and its barycentric coordinates there. Beside the picture it is the nearest
/// triangle, and the point is moved onto it. `None` if the picture has no triangles.
fn place_on_picture(picture: &Primitive, at: DVec2) -> Option<(usize, [f64; 3])> {
    let weights = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| picture.positions[corner as usize].as_dvec3().truncate() - at);
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let distance = (a + b + c).length_squared();
        (weights.map(|weight| weight / weights.iter().sum::<f64>()), distance)
    };
    let all = || picture.triangles.iter().map(weights).enumerate();
    let holding = all().find(|(_, (weights, _))| weights.iter().all(|&weight| weight >= 0.0));
    let (triangle, (weights, _)) = holding.or_else(|| all().min_by(|a, b| a.1.1.total_cmp(&b.1.1)))?;
    let inside = weights.map(|weight| if weight.is_finite() { weight.max(0.0) } else { 1.0 });
    let sum: f64 = inside.iter().sum();
    Some((triangle, inside.map(|weight| weight / sum)))
}

/// Creates the error for a key of a pin that does not match the scene, from a description and a hint.
pub(in crate::pipeline) fn mismatch(
    shot: &Shot,
    ([layer, pin], key): ([usize; 2], &str),
    (what, hint): (String, String),
) -> PipelineError {
    let names = (&shot.layers[layer].name, &shot.layers[layer].pins[pin].name);
    let what = format!("layer '{}', pin '{}': {what}", names.0, names.1);
    PipelineError::mismatch(shot, &format!("layer[{layer}].pin[{pin}].{key}"), what, hint)
}
