//! Scales the matte of a layer together with its plate.
//!
//! In: a plate, a matte, a frame size. Out: the matte for the plate in that size.
//!
//! The colours of a smaller pixel are the mean of those that it covers, weighted by their alpha; so is its coverage.

use super::channel_table::ChannelTable;
use super::matte::{MatteRegion, alpha_of_picture, matte_coverage};
use super::{Coverage, Matte, Planes, PlateError, WarpSettings, scaled};
use crate::image::Plate;
use crate::space::FrameSize;
use std::sync::Arc;

/// Returns the matte of a layer for the plate in another size; the name in `layer` is for messages.
///
/// # Errors
/// [`PlateError`] if the plate lacks what the matte refers to.
pub(crate) fn scaled_matte(
    plate: &Plate,
    (layer, matte): (&str, &Matte),
    settings: &WarpSettings,
    to: FrameSize,
) -> Result<Matte, PlateError> {
    if matte.is_all() {
        return Ok(matte.clone());
    }
    let from = plate.frame_size();
    let table = ChannelTable::of(plate, &settings.semantics);
    let window = plate.parts.first().map_or(from.window(), |part| plate.window_of(part));
    let view = table.entries.first().and_then(|entry| entry.name.view.as_deref());
    let region = MatteRegion { view, window };
    let whole = vec![1.0; window.area()];
    let coverage = matte_coverage(&table, (layer, matte), region)?.coverage.unwrap_or_else(|| whole.clone());
    let alpha = alpha_of_picture(&table, region).map_or(whole, |alpha| alpha.into_owned());
    let visible: Vec<f32> = coverage.iter().zip(&alpha).map(|(coverage, alpha)| coverage * alpha).collect();
    let (window, planes) = scaled(&Planes { window, planes: vec![&visible, &coverage, &alpha] }, from, to);
    // Where nothing is visible, as in a glow, the coverage is that of the matte itself.
    let samples = (0..window.area()).map(|place| {
        let [visible, coverage, alpha] = [0, 1, 2].map(|plane: usize| planes[plane][place]);
        if alpha > 0.0 { visible } else { coverage }.clamp(0.0, 1.0)
    });
    Ok(Matte::Drawn(Arc::new(Coverage { frame: to, window, samples: samples.collect() })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Channel, Frame, Storage};

    const LARGE: FrameSize = FrameSize { width: 8, height: 2, pixel_aspect: 1.0 };
    const SMALL: FrameSize = FrameSize { width: 4, height: 1, pixel_aspect: 1.0 };

    /// Eight columns: four of the layer, of which two are half transparent, and four of others, of which two are empty.
    fn plate(alpha: [f32; 8]) -> Plate {
        let channel = |name: &str, row: [f32; 8]| Channel {
            name: name.into(),
            storage: Storage::Float,
            samples: [row, row].concat(),
        };
        let channels =
            vec![channel("R", alpha), channel("A", alpha), channel("mask.Y", [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0])];
        Plate::from_frame(Frame { display: LARGE.window(), data_window: LARGE.window(), pixel_aspect: 1.0, channels })
    }

    /// The share of every small pixel that the layer moves.
    fn shares(alpha: [f32; 8]) -> Vec<f32> {
        let (plate, settings) = (plate(alpha), WarpSettings::default());
        let matte = Matte::Channel("mask.Y".into());
        let Ok(Matte::Drawn(drawn)) = scaled_matte(&plate, ("", &matte), &settings, SMALL) else { panic!("a matte") };
        assert_eq!((drawn.frame, drawn.window), (SMALL, SMALL.window()));
        drawn.samples.clone()
    }

    #[test]
    fn coverage_is_scaled_by_what_is_visible_of_it() {
        let opaque = shares([1.0; 8]);
        let near = |found: &[f32], wanted: [f32; 4]| found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 0.1);
        assert!(near(&opaque, [1.0, 1.0, 0.0, 0.0]), "{opaque:?}");
        let soft = shares([0.5; 8]);
        assert!(near(&soft, [0.5, 0.5, 0.0, 0.0]), "{soft:?}");
        assert!(near(&shares([0.0; 8]), [1.0, 1.0, 0.0, 0.0]), "nothing is visible");
    }

    #[test]
    fn what_takes_the_whole_picture_stays_as_it_is_and_errors_name_the_layer() {
        let (plate, settings) = (plate([1.0; 8]), WarpSettings::default());
        let scaled = |matte: &Matte| scaled_matte(&plate, ("arm", matte), &settings, SMALL);
        assert_eq!(scaled(&Matte::Alpha).ok(), Some(Matte::Alpha));
        let told = scaled(&Matte::Channel("lost".into())).expect_err("there is none").to_string();
        assert!(told.contains("\"arm\"") && told.contains("lost"), "{told}");
    }
}
