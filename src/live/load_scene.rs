//! Loads a shape as an in-memory shot.
//!
//! In: a [`ShapeSource`] and the frame. Out: a [`BaseScene`]: a [`PreparedShot`], and the layer that the pins belong to.

use super::base_scene::BaseScene;
use super::{Controls, Coverage, LiveError, ShapeSource, ShotShape, shape_source};
use crate::image::Compression;
use crate::pipeline::PreparedShot;
use crate::plate::WarpSettings;
use crate::scene::{Picture, Scene, SceneError, frame_card, picture_cards};
use crate::shot::{
    BoxOrientation, BoxRule, CameraRule, Connectivity, FrameRange, KeyLines, Layer, LayerSpace, Output, Selection,
    Shot, Shutter, Source, Unmatted, Visibility,
};
use crate::solve::Settings;
use crate::space::FrameSize;
use std::path::PathBuf;

/// Name of the layer in shots made here.
const LAYER: &str = "pins";

/// Loads or creates the scene of a shape.
pub(super) fn load_scene(shape: &ShapeSource, frame: FrameSize) -> Result<BaseScene, LiveError> {
    let made = |source, bounds, scene| {
        let layers = vec![layer(bounds)];
        Ok(BaseScene {
            prepared: Some(PreparedShot::with_scene(Shot { layers, ..shot(source, frame) }, scene)?),
            layer: 0,
        })
    };
    match shape {
        ShapeSource::Frame => made(Source::Frame, BoxRule::Frame, frame_card(frame.aspect())),
        ShapeSource::Window(window) => {
            let picture = Picture { path: PathBuf::new(), name: LAYER.to_owned(), window: *window, alpha: None };
            made(Source::Images(Vec::new()), BoxRule::Follow, picture_cards(frame, &[picture])?)
        }
        ShapeSource::Coverage(coverage) => match outlined(coverage, frame)? {
            Some(scene) => made(Source::Images(Vec::new()), BoxRule::Follow, scene),
            None => Ok(BaseScene { prepared: None, layer: 0 }),
        },
        ShapeSource::Shot(shot) => load_shot(shot),
    }
}

fn load_shot(shape: &ShotShape) -> Result<BaseScene, LiveError> {
    let mut shot = Shot::clone(&*shape_source::read(&shape.path)?);
    shot.camera = shape.camera.clone().map_or(shot.camera, CameraRule::Named);
    if shot.layers.is_empty() {
        let bounds = if shot.source == Source::Frame { BoxRule::Frame } else { BoxRule::Follow };
        shot.layers.push(layer(bounds));
    }
    let index = driven(&shot, shape)?;
    Ok(BaseScene { prepared: Some(PreparedShot::new(shot)?), layer: index })
}

/// Returns the layer that the pins belong to.
fn driven(shot: &Shot, shape: &ShotShape) -> Result<usize, LiveError> {
    let is_of_screen = |layer: &Layer| matches!(layer.space, LayerSpace::Screen { .. });
    let fault = |what: String, hint: String| LiveError::Layer { path: shape.path.clone(), what, hint };
    let Some(name) = &shape.layer else {
        let hint = "add a [[layer]] whose lattice lies on the screen".to_owned();
        let first = shot.layers.iter().position(|layer| is_of_screen(layer) && layer.transfer.is_none());
        return first.ok_or_else(|| fault("no screen-space layer accepts pins".into(), hint));
    };
    let Some(index) = shot.layer_index(name) else {
        let names: Vec<&str> = shot.layers.iter().map(|layer| layer.name.as_str()).collect();
        return Err(fault(format!("there is no layer '{name}'"), format!("its layers: {}", names.join(", "))));
    };
    if shot.layers[index].transfer.is_some() {
        let hint = "name a layer with pins".to_owned();
        return Err(fault(format!("layer '{name}' takes its lattices from a file"), hint));
    }
    if !is_of_screen(&shot.layers[index]) {
        let hint = "name a layer of the screen".to_owned();
        return Err(fault(format!("the lattice of layer '{name}' is in scene space: it cannot warp pictures"), hint));
    }
    Ok(index)
}

/// Traces the outline of the visible part; `None`: nothing is visible.
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

/// Creates a shot of one frame, without layers.
fn shot(source: Source, size: FrameSize) -> Shot {
    Shot {
        path: PathBuf::new(),
        lines: KeyLines::default(),
        source,
        plate: None,
        warp: WarpSettings::default(),
        camera: CameraRule::Automatic,
        visibility: Visibility::default(),
        allow_outside: false,
        clip: None,
        is_looped: false,
        frames: FrameRange { first: 0, last: 0, rate: 24.0, clip_start: 0 },
        solve_range: [0, 0],
        shutter: Shutter::CLOSED,
        size,
        samples: 1,
        environment: None,
        exposure_stops: 0.0,
        layers: Vec::new(),
        output: Output { path: PathBuf::new(), channels: Vec::new(), compression: Compression::Zip },
    }
}

/// Creates a layer of all nodes, with default controls.
fn layer(bounds: BoxRule) -> Layer {
    let Controls { dims, basis, .. } = Controls::default();
    Layer {
        name: LAYER.to_owned(),
        nodes: Vec::new(),
        selection: Selection::default(),
        space: LayerSpace::Screen { dims, bounds },
        has_auto_dims: false,
        // The coverage of a plate does not tell its parts apart.
        has_auto_topology: false,
        connectivity: Connectivity::default(),
        basis,
        settings: Settings::default(),
        step: 1,
        strength: 1.0,
        is_muted: false,
        stiffness: Vec::new(),
        strokes: Vec::new(),
        orientation: BoxOrientation::default(),
        symmetry: None,
        pins: Vec::new(),
        handles: Vec::new(),
        transfer: None,
        matte: None,
        unmatted: Unmatted::default(),
    }
}
