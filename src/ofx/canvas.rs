//! The picture that pins are measured in, as a host tells it.
//!
//! In: properties of an effect, regions of its source. Out: a [`Canvas`].

use super::api::names::image;
use super::host::Effect;
use super::regions::is_endless;
use crate::live::Canvas;

/// The picture of a host that tells nothing.
const UNKNOWN: [f64; 4] = [0.0, 0.0, 1920.0, 1080.0];

/// The picture at its full size: the project's, or else the whole of the source.
pub(super) fn canvas_of(effect: Effect, time: f64) -> Canvas {
    canvas_at(effect, time, [1.0, 1.0], None)
}

/// The same while an image of these pixels is drawn: of hosts without a project, MLT tells regions of the source in
/// pixels of its preview, and its older versions tell none.
pub(super) fn canvas_at(effect: Effect, time: f64, scale: [f64; 2], drawn: Option<[i32; 4]>) -> Canvas {
    let props = effect.props();
    let size = props.doubles(image::PROJECT_SIZE).or_else(|| props.doubles(image::PROJECT_EXTENT));
    let [left, low]: [f64; 2] = props.doubles(image::PROJECT_OFFSET).unwrap_or_default();
    let source = effect.clip(image::SOURCE_CLIP);
    let aspect = source.and_then(|source| source.props().double(image::PIXEL_ASPECT));
    let aspect = aspect.or_else(|| props.double(image::PROJECT_PIXEL_ASPECT)).filter(|aspect| *aspect > 0.0);
    let aspect = aspect.unwrap_or(1.0);
    let region = match size.filter(|size: &[f64; 2]| size.iter().all(|side| *side >= 1.0)) {
        Some([width, height]) => [left, low, left + width, low + height],
        None => {
            let region = source.and_then(|source| source.region(time));
            let region = region.filter(|sides| !sides.iter().any(|side| is_endless(*side)));
            without_project(region, drawn, aspect, scale)
        }
    };
    Canvas::new(region, aspect, scale)
}

/// The source's region, or that of the drawn pixels where the host tells none, or tells it in pixels.
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
