//! A shape as a shot in memory: the scene that lattices are laid over, loaded once.
//!
//! In: a [`ShapeSource`] and the frame. Out: a [`BaseScene`]: the engine's own [`Setup`], and the layer that pins belong to.

use super::{Controls, Coverage, LiveError, Moved, OwnPins, Pin, ShapeSource, ShotShape, shape_source};
use crate::image::Compression;
use crate::pipeline::Setup;
use crate::plate::{Matte, WarpRules};
use crate::scene::{Picture, Scene, SceneError, frame_card, picture_cards};
use crate::shot::{
    Anchor, BoxRule, CameraRule, Ease, FrameRange, Goal, KeyLines, Layer, LayerSpace, OffsetUnit, Output, PinKey,
    Rotation, Shot, Shutter, Source, Unmatted, Visibility,
};
use crate::solve::{Guard, Settings};
use crate::space::FrameSize;
use std::path::PathBuf;

/// The layer of shots that have none.
const LAYER: &str = "pins";

/// A scene, and the layer of it that is driven.
#[derive(Debug)]
pub(super) struct BaseScene {
    /// `None`: nothing of the picture is there.
    pub(super) setup: Option<Setup>,
    /// Index of the layer.
    pub(super) layer: usize,
}

impl BaseScene {
    /// Loads or makes the scene.
    pub(super) fn of(shape: &ShapeSource, frame: FrameSize) -> Result<Self, LiveError> {
        let made = |source, bounds, scene| {
            let layers = vec![layer(bounds)];
            Ok(Self { setup: Some(Setup::with_scene(Shot { layers, ..shot(source, frame) }, scene)?), layer: 0 })
        };
        match shape {
            ShapeSource::Frame => made(Source::Frame, BoxRule::Frame, frame_card(frame.aspect())),
            ShapeSource::Window(window) => {
                let picture = Picture { path: PathBuf::new(), name: LAYER.to_owned(), window: *window, alpha: None };
                made(Source::Images(Vec::new()), BoxRule::Follow, picture_cards(frame, &[picture])?)
            }
            ShapeSource::Coverage(coverage) => match outlined(coverage, frame)? {
                Some(scene) => made(Source::Images(Vec::new()), BoxRule::Follow, scene),
                None => Ok(Self { setup: None, layer: 0 }),
            },
            ShapeSource::Shot(shot) => Self::of_shot(shot),
        }
    }

    fn of_shot(shape: &ShotShape) -> Result<Self, LiveError> {
        let mut shot = Shot::clone(&*shape_source::read(&shape.path)?);
        shot.camera = shape.camera.clone().map_or(shot.camera, CameraRule::Named);
        if shot.layers.is_empty() {
            let bounds = if shot.source == Source::Frame { BoxRule::Frame } else { BoxRule::Follow };
            shot.layers.push(layer(bounds));
        }
        let index = driven(&shot, shape)?;
        Ok(Self { setup: Some(Setup::new(shot)?), layer: index })
    }
}

/// The layer that pins belong to.
fn driven(shot: &Shot, shape: &ShotShape) -> Result<usize, LiveError> {
    let is_of_screen = |layer: &Layer| matches!(layer.space, LayerSpace::Screen { .. });
    let fault = |what: String, hint: String| LiveError::Layer { path: shape.path.clone(), what, hint };
    let Some(name) = &shape.layer else {
        let hint = "add a [[layer]] whose lattice lies on the screen".to_owned();
        let first = shot.layers.iter().position(|layer| is_of_screen(layer) && layer.transfer.is_none());
        return first.ok_or_else(|| fault("no layer of the screen takes pins".into(), hint));
    };
    let Some(index) = shot.layers.iter().position(|layer| layer.name == *name) else {
        let names: Vec<&str> = shot.layers.iter().map(|layer| layer.name.as_str()).collect();
        return Err(fault(format!("there is no layer '{name}'"), format!("its layers: {}", names.join(", "))));
    };
    if shot.layers[index].transfer.is_some() {
        let hint = "name a layer with pins".to_owned();
        return Err(fault(format!("layer '{name}' takes its lattices from a file"), hint));
    }
    if !is_of_screen(&shot.layers[index]) {
        let hint = "name a layer of the screen".to_owned();
        return Err(fault(format!("the lattice of layer '{name}' lies in the scene: it cannot warp pictures"), hint));
    }
    Ok(index)
}

/// The outline of what can be seen; `None`: nothing can.
fn outlined(coverage: &Coverage, frame: FrameSize) -> Result<Option<Scene>, LiveError> {
    let Coverage { window, alpha } = *coverage;
    if alpha.len() != window.area() {
        return Err(LiveError::Planes { what: "coverage", found: alpha.len(), wanted: window.area() });
    }
    let picture = Picture { path: PathBuf::new(), name: LAYER.to_owned(), window, alpha: Some(alpha) };
    match picture_cards(frame, &[picture]) {
        Ok(scene) => Ok(Some(scene)),
        Err(SceneError::Empty { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// A shot of one frame, without layers.
fn shot(source: Source, size: FrameSize) -> Shot {
    Shot {
        path: PathBuf::new(),
        lines: KeyLines::default(),
        source,
        plate: None,
        warp: WarpRules::default(),
        camera: CameraRule::Automatic,
        visibility: Visibility::default(),
        allow_outside: false,
        clip: None,
        is_looped: false,
        frames: FrameRange { first: 0, last: 0, rate: 24.0, clip_start: 0 },
        solve_range: [0, 0],
        shutter: Shutter { angle: 0.0, phase: 0.0 },
        size,
        samples: 1,
        environment: None,
        exposure_stops: 0.0,
        layers: Vec::new(),
        output: Output { path: PathBuf::new(), channels: Vec::new(), compression: Compression::Zip },
    }
}

/// A layer of everything, with the defaults of the controls.
fn layer(bounds: BoxRule) -> Layer {
    let Controls { dims, basis, .. } = Controls::default();
    Layer {
        name: LAYER.to_owned(),
        nodes: Vec::new(),
        space: LayerSpace::Screen { dims, bounds },
        basis,
        settings: Settings::default(),
        step: 1,
        strength: 1.0,
        stiffness: Vec::new(),
        pins: Vec::new(),
        handles: Vec::new(),
        transfer: None,
        matte: None,
        unmatted: Unmatted::default(),
    }
}

/// Whether the pins of the controls go where they shall, or stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goals {
    /// They hold their rest places: what is prepared must not depend on targets.
    AtRest,
    /// They go to their targets.
    Reached,
}

/// A layer with everything that the controls say; their pins come after its own, and first of all in time.
pub(super) fn driven_layer(layer: &Layer, controls: &Controls, (own, frame): (OwnPins, f64), goals: Goals) -> Layer {
    let mut layer = layer.clone();
    if let LayerSpace::Screen { bounds, .. } = layer.space {
        layer.space = LayerSpace::Screen { dims: controls.dims, bounds };
    }
    layer.basis = controls.basis;
    layer.settings = layer.settings.with_smoothness(controls.smoothness);
    layer.strength *= controls.strength;
    if controls.guard == Guard::Limit {
        layer.settings.guard = Guard::Limit;
    }
    if controls.moved == Moved::Masked {
        layer.matte = layer.matte.or(Some(Matte::Alpha));
    }
    if own == OwnPins::LeftOut {
        layer.pins.clear();
    }
    let start = first_key(&layer).min(frame - f64::from(layer.step)) - 1.0;
    let pins = controls.pins.iter().enumerate().map(|(index, pin)| driven_pin(index, pin, start, goals));
    layer.pins.extend(pins);
    layer
}

/// When the first key of a layer stands.
fn first_key(layer: &Layer) -> f64 {
    let pins = layer.pins.iter().filter_map(|pin| Some(pin.keys.first()?.frame));
    let handles = layer.handles.iter().filter_map(|handle| Some(handle.keys.first()?.frame));
    pins.chain(handles).fold(f64::INFINITY, f64::min)
}

/// A pin of the controls: one frame long it goes from its rest to its target. So turns of more than half a circle are wound.
fn driven_pin(index: usize, pin: &Pin, start: f64, goals: Goals) -> crate::shot::Pin {
    let key = |frame: f64, goals: Goals| {
        let is_reached = goals == Goals::Reached;
        let offset = if is_reached { pin.target - pin.rest } else { Default::default() };
        PinKey {
            frame,
            goal: Goal::Offset(offset),
            rotate_degrees: pin
                .rotation
                .map(|angle| Rotation::InView(if is_reached { angle.to_degrees() } else { 0.0 })),
            scale: pin.scale.map(|scale| if is_reached { scale } else { 1.0 }),
            ease: Ease::Linear,
        }
    };
    crate::shot::Pin {
        name: format!("live{}", index + 1),
        anchor: Anchor::Screen { at: pin.rest, frame: None },
        unit: OffsetUnit::Frame,
        region: pin.region.map(|region| crate::shot::PinRegion {
            radius: region.radius,
            rigidity: region.rigidity,
            stiffness: region.stiffness,
        }),
        keys: vec![key(start, Goals::AtRest), key(start + 1.0, goals)],
    }
}
