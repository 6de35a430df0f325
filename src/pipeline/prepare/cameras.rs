//! Finds the camera of a shot: a camera of the scene, a standard view, the shot's own camera, or one that frames the scene.
//!
//! In: a [`CameraRule`], the scene, and the parts of every layer. Out: the camera at any frame.

use crate::pipeline::PipelineError;
use crate::pose::{ClipChoice, Pose, is_still, pose};
use crate::scene::{FindError, Scene};
use crate::screen::{self, Camera, CameraPlacement};
use crate::shot::{CameraAim, CameraKey, CameraLens, CameraRule, Ease, LookAt, OwnCamera, Shot, Source};
use crate::spelling;
use glam::DVec3;

/// Standard views: name, yaw and pitch in degrees.
const VIEWS: [(&str, f64, f64); 9] = [
    ("front", 0.0, 0.0),
    ("back", 180.0, 0.0),
    ("right", 90.0, 0.0),
    ("left", -90.0, 0.0),
    ("side", 90.0, 0.0),
    ("top", 0.0, 90.0),
    ("bottom", 0.0, -90.0),
    ("three-quarter", 45.0, 15.0),
    ("fit", 20.0, 12.0),
];

/// Vertical field of view of standard views, degrees.
const VIEW_FOV_DEGREES: f64 = 30.0;

/// Distance of the near plane, relative to the distance of the camera's subject.
const NEAR_FRACTION: f64 = 0.01;

/// Maximum distance of the near plane, relative to the radius of the scene.
const NEAR_RADII: f64 = 0.01;

/// The source of the camera.
#[derive(Clone, Debug)]
pub(in crate::pipeline) enum CameraSource {
    /// A camera node of the scene.
    Node(usize),
    /// A camera that frames a scene without cameras.
    Automatic(Camera),
    /// The shot's own camera, resolved: subjects are points and distances are known.
    Own {
        /// The camera's keys.
        camera: OwnCamera,
        /// Radius of the bounding sphere of everything visible, metres.
        radius: f64,
    },
}

/// The inputs to the choice of a camera.
pub(in crate::pipeline) struct CameraContext<'a> {
    pub(in crate::pipeline) shot: &'a Shot,
    pub(in crate::pipeline) scene: &'a Scene,
    pub(in crate::pipeline) clip: ClipChoice,
    /// #layers: the parts of each layer.
    pub(in crate::pipeline) parts_of_layer: &'a [Vec<usize>],
}

impl CameraSource {
    /// Returns the camera at a (fractional) frame, whose pose is given.
    pub(in crate::pipeline) fn at(&self, (shot, scene): (&Shot, &Scene), frame: f64, pose: &Pose) -> Camera {
        match self {
            Self::Automatic(camera) => *camera,
            Self::Node(node) => {
                let camera = scene.nodes[*node].camera.map(|camera| &scene.cameras[camera]);
                let camera = camera.expect("camera nodes are chosen among nodes that carry one");
                Camera::new(pose.scene_from_node[*node], camera.lens, camera.near, shot.size)
            }
            Self::Own { camera, radius } => own_camera(camera, *radius, frame).seen(shot.size),
        }
    }
}

/// Chooses the camera of a shot. `notes` receives choices made on the user's behalf.
pub(in crate::pipeline) fn choose(
    context: &CameraContext<'_>,
    notes: &mut Vec<String>,
) -> Result<CameraSource, PipelineError> {
    let CameraContext { shot, scene, .. } = context;
    match &shot.camera {
        CameraRule::Automatic => match scene.find_camera(None) {
            Ok(node) => Ok(CameraSource::Node(node)),
            Err(_) => {
                notes.push("the scene has no camera: one that shows the whole scene is used".into());
                context.automatic()
            }
        },
        CameraRule::Named(name) => context.named(name),
        CameraRule::Own(camera) => context.own(camera),
    }
}

impl CameraContext<'_> {
    fn named(&self, name: &str) -> Result<CameraSource, PipelineError> {
        let found = self.scene.find_camera(Some(name));
        if let Ok(node) = found {
            return Ok(CameraSource::Node(node));
        }
        let (view, layer) = name.split_once(':').map_or((name, None), |(view, layer)| (view, Some(layer)));
        let view = VIEWS.iter().find(|(known, ..)| *known == view && matches!(self.shot.source, Source::Scene(_)));
        let Some(&(_, yaw, pitch)) = view else { return Err(self.unknown_camera(name, found)) };
        let look_at = layer.map_or(LookAt::Scene, |layer| LookAt::Layer(layer.to_owned()));
        let aim = CameraAim::Orbit { look_at, distance: None, yaw, pitch };
        let frame = f64::from(self.shot.reference_frame());
        let lens = CameraLens::Fov(VIEW_FOV_DEGREES);
        self.own(&OwnCamera { keys: vec![CameraKey { frame, aim, roll: 0.0, lens, ease: Ease::default() }] })
    }

    fn unknown_camera(&self, name: &str, found: Result<usize, FindError>) -> PipelineError {
        let views = VIEWS.map(|(view, ..)| view);
        let hint = match found {
            Err(FindError::UnknownCamera { hint, .. }) => match spelling::nearest(name, views.into_iter()) {
                Some(view) if !hint.starts_with("did you mean") => format!("did you mean \"{view}\"? Cameras: {hint}"),
                _ => hint,
            },
            _ => "it has none".to_owned(),
        };
        let hint = match &self.shot.source {
            Source::Scene(_) => format!("{hint}; views: {}", views.join(", ")),
            _ => hint,
        };
        let source = FindError::UnknownCamera { name: name.to_owned(), hint };
        PipelineError::find(self.shot, "camera", source)
    }

    /// Creates a camera that frames the whole scene.
    fn automatic(&self) -> Result<CameraSource, PipelineError> {
        let framed = screen::automatic(&self.poses(), self.shot.size).map(CameraSource::Automatic);
        let what = "the scene has no vertices to frame";
        framed.ok_or_else(|| PipelineError::mismatch(self.shot, "scene", what, "add a camera to the scene"))
    }

    /// Resolves the parts of the shot's own camera that depend on the scene.
    fn own(&self, camera: &OwnCamera) -> Result<CameraSource, PipelineError> {
        let poses = self.poses();
        let everything = points(&poses, |_| true);
        let radius = Extent::of(&everything).map_or(1.0, |extent| extent.radius);
        let keys = camera.keys.iter().map(|key| self.resolved(key, (&poses, &everything)));
        Ok(CameraSource::Own { camera: OwnCamera { keys: keys.collect::<Result<_, _>>()? }, radius })
    }

    fn resolved(&self, key: &CameraKey, scene: (&[Pose], &[DVec3])) -> Result<CameraKey, PipelineError> {
        let aim = match &key.aim {
            CameraAim::Along { .. } => key.aim.clone(),
            CameraAim::Towards { position, look_at } => {
                let (middle, _) = self.subject(look_at, scene)?;
                CameraAim::Towards { position: *position, look_at: LookAt::Point(middle.to_array()) }
            }
            CameraAim::Orbit { look_at, distance, yaw, pitch } => {
                let (middle, points) = self.subject(look_at, scene)?;
                let axes = CameraPlacement::orbit(middle, 1.0, [*yaw, *pitch, key.roll]);
                let fitted = || screen::fit_distance(&points, &axes, (lens(key.lens), self.shot.size));
                let look_at = LookAt::Point(middle.to_array());
                CameraAim::Orbit { look_at, distance: Some(distance.unwrap_or_else(fitted)), yaw: *yaw, pitch: *pitch }
            }
        };
        Ok(CameraKey { aim, ..key.clone() })
    }

    /// Returns the centre of a camera's subject and the points that the camera has to show.
    fn subject(
        &self,
        look_at: &LookAt,
        (poses, everything): (&[Pose], &[DVec3]),
    ) -> Result<(DVec3, Vec<DVec3>), PipelineError> {
        let of_points = |points: Vec<DVec3>| {
            let middle = Extent::of(&points).map_or(DVec3::ZERO, |extent| extent.middle);
            // A subject without extent, such as a single joint: the whole scene is shown.
            let is_point = Extent::of(&points).is_none_or(|extent| extent.radius < 1e-6);
            (middle, if is_point { everything.to_vec() } else { points })
        };
        match look_at {
            LookAt::Scene => Ok(of_points(everything.to_vec())),
            LookAt::Point(point) => Ok((DVec3::from_array(*point), everything.to_vec())),
            LookAt::Layer(name) => {
                let names = self.shot.layers.iter().map(|layer| layer.name.as_str());
                let Some(layer) = names.clone().position(|layer| layer == name) else {
                    let what = format!("there is no layer '{name}' that the view could be fitted to");
                    return Err(PipelineError::mismatch(self.shot, "camera", what, spelling::hint(name, names)));
                };
                Ok(of_points(points(poses, |part| self.parts_of_layer[layer].contains(&part))))
            }
            LookAt::Nodes(pattern) => {
                let matched = self.scene.matching(pattern);
                if matched.is_empty() {
                    let names = self.scene.nodes.iter().map(|node| node.name.as_str());
                    let what = format!("no node matches '{pattern}'");
                    let hint = spelling::hint(pattern, names);
                    return Err(PipelineError::mismatch(self.shot, "camera.look_at", what, hint));
                }
                let inside: Vec<usize> = matched.iter().flat_map(|&node| self.scene.subtree(node)).collect();
                let seen = points(poses, |part| inside.contains(&poses[0].parts[part].node));
                if !seen.is_empty() {
                    return Ok(of_points(seen));
                }
                let origin = |pose: &Pose, node: usize| pose.scene_from_node[node].w_axis.truncate().as_dvec3();
                Ok(of_points(
                    matched.iter().flat_map(|&node| poses.iter().map(move |pose| origin(pose, node))).collect(),
                ))
            }
        }
    }

    /// Returns the poses in the first, middle and last frame of the shot; one if they are the same.
    fn poses(&self) -> Vec<Pose> {
        let (frames, [first, last]) = (self.shot.frames, self.shot.solve_range);
        // Frames that are trimmed within the range that is solved keep their camera.
        let [first, last] = [first.min(frames.first), last.max(frames.last)];
        let times = [first, first.midpoint(last), last];
        // A still scene is the same at all times.
        let count = if is_still(self.scene, self.clip) { 1 } else { times.len() };
        times[..count].iter().map(|&frame| pose(self.scene, self.clip, frames.seconds(f64::from(frame)))).collect()
    }
}

/// Returns the vertices of the chosen parts in all poses.
fn points(poses: &[Pose], is_meant: impl Fn(usize) -> bool) -> Vec<DVec3> {
    let parts = poses.iter().flat_map(|pose| pose.parts.iter().enumerate());
    let meant = parts.filter(|(part, _)| is_meant(*part));
    meant.flat_map(|(_, part)| part.positions.iter().map(|point| point.0.as_dvec3())).collect()
}

/// A bounding sphere around the centre of the bounding box.
struct Extent {
    middle: DVec3,
    radius: f64,
}

impl Extent {
    fn of(points: &[DVec3]) -> Option<Self> {
        let low = points.iter().copied().reduce(DVec3::min)?;
        let high = points.iter().copied().reduce(DVec3::max)?;
        let middle = (low + high) * 0.5;
        Some(Self { middle, radius: points.iter().map(|point| point.distance(middle)).fold(0.0, f64::max) })
    }
}

const fn lens(lens: CameraLens) -> crate::scene::Lens {
    match lens {
        CameraLens::Fov(degrees) => crate::scene::Lens::Perspective { yfov: degrees.to_radians() as f32 },
        CameraLens::Ortho(height) => crate::scene::Lens::Orthographic { ymag: (0.5 * height) as f32 },
    }
}

/// A camera before the frame size is applied.
struct PlacedCamera {
    placement: CameraPlacement,
    lens: CameraLens,
    near: f64,
}

impl PlacedCamera {
    fn seen(&self, frame: crate::space::FrameSize) -> Camera {
        Camera::placed(&self.placement, lens(self.lens), self.near, frame)
    }
}

/// Returns a resolved camera at a (fractional) frame; between keys, every parameter is interpolated separately.
fn own_camera(camera: &OwnCamera, radius: f64, frame: f64) -> PlacedCamera {
    let (from, to, weight) = camera.keys_at(frame).expect("the checks give every camera a key");
    let (from, to) = (&camera.keys[from], &camera.keys[to]);
    let mix = |a: f64, b: f64| a * (1.0 - weight) + b * weight;
    let mix_points = |a: [f64; 3], b: [f64; 3]| DVec3::from_array(std::array::from_fn(|axis| mix(a[axis], b[axis])));
    let roll = mix(from.roll, to.roll);
    let (placement, distance) = match (&from.aim, &to.aim) {
        (
            CameraAim::Orbit { look_at: LookAt::Point(a), distance: Some(near), yaw, pitch },
            CameraAim::Orbit { look_at: LookAt::Point(b), distance: Some(far), yaw: to_yaw, pitch: to_pitch },
        ) => {
            // Easing may overshoot, but the distance to the subject must stay positive.
            let distance = mix(*near, *far).max(1e-6);
            let angles = [mix(*yaw, *to_yaw), mix(*pitch, *to_pitch), roll];
            (CameraPlacement::orbit(mix_points(*a, *b), distance, angles), distance)
        }
        (
            CameraAim::Towards { position, look_at: LookAt::Point(a) },
            CameraAim::Towards { position: to_position, look_at: LookAt::Point(b) },
        ) => {
            let (position, target) = (mix_points(*position, *to_position), mix_points(*a, *b));
            (CameraPlacement::towards(position, target, roll), position.distance(target))
        }
        (
            CameraAim::Along { position, yaw, pitch },
            CameraAim::Along { position: to_position, yaw: to_yaw, pitch: to_pitch },
        ) => {
            let angles = [mix(*yaw, *to_yaw), mix(*pitch, *to_pitch), roll];
            (CameraPlacement::orbit(mix_points(*position, *to_position), 0.0, angles), radius)
        }
        // The shot checks admit only keys of one kind, and resolving keeps their kinds.
        _ => (CameraPlacement::orbit(DVec3::ZERO, radius, [0.0; 3]), radius),
    };
    let lens = match (from.lens, to.lens) {
        (CameraLens::Fov(from), CameraLens::Fov(to)) => CameraLens::Fov(mix(from, to).clamp(0.1, 170.0)),
        (CameraLens::Ortho(from), CameraLens::Ortho(to)) => CameraLens::Ortho(mix(from, to).max(1e-6)),
        (from, _) => from,
    };
    let near = match lens {
        CameraLens::Fov(_) => (distance * NEAR_FRACTION).min(radius * NEAR_RADII).max(1e-6),
        CameraLens::Ortho(_) => 0.0,
    };
    PlacedCamera { placement, lens, near }
}
