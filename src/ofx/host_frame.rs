//! The picture that pins are measured in, as a host describes it.
//!
//! In: properties of an effect, regions of its source. Out: a [`HostFrame`]: the plate, or over a shot the project.

use super::api::names::image;
use super::host::Effect;
use super::params::{SHAPES, ShapeFrom};
use super::values::ParamValues;
pub(super) use crate::live::HostFrame;

/// The picture of a host that says nothing about it.
const UNKNOWN: [f64; 4] = [0.0, 0.0, 1920.0, 1080.0];

/// Whether a side of a region means that the region has no end there.
pub(super) fn is_endless(side: f64) -> bool {
    side <= f64::from(i32::MIN) || side >= f64::from(i32::MAX)
}

/// The pixels of a render: their scale, and the window of the output's image.
pub(super) type Drawn = ([f64; 2], Option<[i32; 4]>);

/// The picture at its full size.
pub(super) fn host_frame_of(effect: Effect, time: f64) -> HostFrame {
    host_frame_at(effect, time, ([1.0, 1.0], None))
}

/// The picture that is warped, while an image of these pixels is drawn: all of the source, which may be larger or smaller
/// than the project. A shot's camera shows the project.
pub(super) fn host_frame_at(effect: Effect, time: f64, drawn: Drawn) -> HostFrame {
    let shape = ParamValues::of(effect, time).map(|values| values.choice("shape", &SHAPES));
    let project = project_at(effect, time, drawn);
    if matches!(shape, Ok(ShapeFrom::Shot)) {
        return project;
    }
    let region = effect.clip(image::SOURCE_CLIP).and_then(|source| source.region(time));
    region.map_or(project, |region| plate(effect, region, project, drawn.0))
}

/// The source's region as a picture; the project where the source has no end, or is described in pixels of a proxy.
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

/// The project's picture; of hosts without one, the whole of the source.
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

/// The source's region, or that of the drawn pixels where the host gives none, or gives it in pixels of a preview, as MLT
/// does; its older versions give none.
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
