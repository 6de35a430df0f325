//! The frame in which pins are measured, as described by the host.
//!
//! In: properties of an effect, regions of its source. Out: a [`HostFrame`]: that of the source, or for a shot the
//! project's.

use super::api::names::image;
use super::host::Effect;
use super::params::{SHAPES, ShapeFrom};
use super::values::ParamValues;
pub(super) use crate::live::HostFrame;

/// The assumed frame of a host that describes none.
const UNKNOWN: [f64; 4] = [0.0, 0.0, 1920.0, 1080.0];

/// Returns whether a side of a region stands for an infinite extent.
pub(super) fn is_endless(side: f64) -> bool {
    side <= f64::from(i32::MIN) || side >= f64::from(i32::MAX)
}

/// The pixels of a render: their scale, and the bounds of the output's image.
pub(super) type Drawn = ([f64; 2], Option<[i32; 4]>);

/// Returns the frame at full size.
pub(super) fn host_frame_of(effect: Effect, time: f64) -> HostFrame {
    host_frame_at(effect, time, ([1.0, 1.0], None))
}

/// Returns the frame that is warped while an image of these pixels is rendered: all of the source, which may be larger
/// or smaller than the project. For a shot it is the project's, which its camera frames.
pub(super) fn host_frame_at(effect: Effect, time: f64, drawn: Drawn) -> HostFrame {
    let shape = ParamValues::of(effect, time).map(|values| values.choice("shape", &SHAPES));
    let project = project_at(effect, time, drawn);
    if matches!(shape, Ok(ShapeFrom::Shot)) {
        return project;
    }
    let region = effect.clip(image::SOURCE_CLIP).and_then(|source| source.region(time));
    region.map_or(project, |region| plate(effect, region, project, drawn.0))
}

/// Returns the source's region as a frame; the project's if the source is infinite or is given in proxy pixels.
fn plate(effect: Effect, region: [f64; 4], project: HostFrame, scale: [f64; 2]) -> HostFrame {
    let has_project = project_size(effect).is_some();
    let is_picture = region[2] - region[0] >= 1.0 && region[3] - region[1] >= 1.0;
    if !has_project || !is_picture || region.iter().any(|side| is_endless(*side)) {
        return project;
    }
    let of_project = project.canonical_region();
    let in_pixels = project.pixels(project.frame.window()).map(f64::from);
    let is_near = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1.0);
    if is_near(region, of_project) || scale != [1.0, 1.0] && is_near(region, in_pixels) {
        return project;
    }
    HostFrame::new(region, aspect_of(effect), scale)
}

/// Returns the project's frame; for hosts without one, the whole source.
pub(super) fn project_at(effect: Effect, time: f64, (scale, drawn): Drawn) -> HostFrame {
    let [left, low]: [f64; 2] = effect.props().doubles(image::PROJECT_OFFSET).unwrap_or_default();
    let aspect = aspect_of(effect);
    let region = match project_size(effect) {
        Some([width, height]) => [left, low, left + width, low + height],
        None => {
            let region = effect.clip(image::SOURCE_CLIP).and_then(|source| source.region(time));
            let region = region.filter(|sides| !sides.iter().any(|side| is_endless(*side)));
            without_project(region, drawn, aspect, scale)
        }
    };
    HostFrame::new(region, aspect, scale)
}

fn project_size(effect: Effect) -> Option<[f64; 2]> {
    let props = effect.props();
    let size = props.doubles(image::PROJECT_SIZE).or_else(|| props.doubles(image::PROJECT_EXTENT));
    size.filter(|size: &[f64; 2]| size.iter().all(|side| *side >= 1.0))
}

fn aspect_of(effect: Effect) -> f64 {
    let aspect = effect.clip(image::SOURCE_CLIP).and_then(|source| source.props().double(image::PIXEL_ASPECT));
    let aspect = aspect.or_else(|| effect.props().double(image::PROJECT_PIXEL_ASPECT));
    aspect.filter(|aspect| *aspect > 0.0).unwrap_or(1.0)
}

/// Returns the source's region, or that of the rendered pixels if the host gives none, or gives it in preview pixels,
/// as MLT does (its older versions give none).
fn without_project(region: Option<[f64; 4]>, drawn: Option<[i32; 4]>, aspect: f64, [across, up]: [f64; 2]) -> [f64; 4] {
    let scaled = |[x1, y1, x2, y2]: [i32; 4], [x, y]: [f64; 2]| {
        [f64::from(x1) * x, f64::from(y1) * y, f64::from(x2) * x, f64::from(y2) * y]
    };
    match (region, drawn) {
        (Some(region), Some(drawn)) if region == scaled(drawn, [aspect, 1.0]) => {
            scaled(drawn, [aspect / across, 1.0 / up])
        }
        (Some(region), _) => region,
        (None, Some(drawn)) => scaled(drawn, [aspect / across, 1.0 / up]),
        (None, None) => UNKNOWN,
    }
}
