//! Displacement maps for After Effects, and the settings to enter there.
//!
//! In: maps, and the largest displacement of their sequence. Out: 16-bit codes; the settings of the Displacement Map
//! effect as a text file beside them. docs/AFTER_EFFECTS.md describes the procedure.

use crate::files::GENERATOR;
use crate::plate::WarpMap;
use crate::spelling::pluralised;

/// The settings for a sequence of maps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DisplacementNote {
    /// File name pattern of the maps: `shot.displacement_37px.####.png`.
    pub maps: String,
    /// Displacement at either end of the value range, in pixels.
    pub reach_px: u32,
    /// Size of the maps in pixels.
    pub size: [u32; 2],
    /// First and last frame.
    pub frames: [i32; 2],
    /// Frame rate, in frames per second.
    pub rate: f64,
    /// Digest of the inputs of the maps; if it changes, so do the maps.
    pub state: String,
}

impl DisplacementNote {
    /// Returns the text of the note.
    #[must_use]
    pub(crate) fn text(&self) -> String {
        let Self { maps, reach_px, size: [width, height], frames: [first, last], rate, state } = self;
        let reach = f64::from(*reach_px);
        let of_file = reach / 32767.0;
        let of_program = reach / 16384.0;
        let pace = pluralised(*rate, "frame", "frames");
        format!(
            "Displacement maps for After Effects, written by {GENERATOR}, `pinwarp export --to after-effects`.\n\n\
             maps:      {maps}, frames {first} to {last}, {rate} a second, {width} x {height} pixels, 16 bits\n\
             element:   the unwarped picture or matted layer, of the same size\n\
             state:     {state}\n\n\
             1. Set the project to 16 bits per channel, no working colour space (or preserve the maps' RGB).\n\
             2. Import element and maps as sequences at {pace} a second; put both into one composition, the maps\n   \
             hidden.\n\
             3. On the element: Effect > Distort > Displacement Map.\n   \
             Displacement Map Layer: the maps.\n   \
             Use For Horizontal Displacement: Red.    Max Horizontal Displacement: {reach_px}\n   \
             Use For Vertical Displacement:   Green.  Max Vertical Displacement:   {reach_px}\n   \
             Displacement Map Behavior: Center Map. Edge Behavior: no wrap. Expand Output: on.\n\
             4. The maps say where each pixel comes from (red: right, green: down; half: no way at all). This was not\n   \
             tried in After Effects: if things move the wrong way, type -{reach_px}.\n\n\
             Precision: one step of the files is {of_file:.5} px, one step of a 16-bit project {of_program:.5} px.\n"
        )
    }
}

/// Returns the largest displacement of any pixel along x or y, in pixels.
#[must_use]
pub(crate) fn greatest_offset(map: &WarpMap) -> f64 {
    map.offsets.iter().flatten().filter(|offset| offset.is_finite()).fold(0.0, |most, by| most.max(f64::from(by.abs())))
}

/// Encodes offsets as 16-bit red (x, right) and green (y, DOWN): ½ is no displacement, 0 and 1 are `reach` pixels. Blue
/// is 0. Pixels where nothing is visible are not displaced.
///
/// Rows from the top, 3 values per pixel. The step between two values is `reach` / 32767 pixels.
#[must_use]
pub(crate) fn displacement(map: &WarpMap, reach: f64) -> Vec<u16> {
    let value = |by: f32| {
        let share = if by.is_finite() { f64::from(by) / reach.max(f64::MIN_POSITIVE) } else { 0.0 };
        // 32768 is the midpoint in programs with a range up to 65536.
        (32768.0 + 32767.0 * share.clamp(-1.0, 1.0)).round() as u16
    };
    map.offsets.iter().flat_map(|&[x, y]| [value(x), value(y), 0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::FrameSize;

    #[test]
    fn reach_and_precision_are_told() {
        let note = DisplacementNote {
            maps: "a.displacement_64px.####.png".into(),
            reach_px: 64,
            size: [1920, 1080],
            frames: [1, 2],
            rate: 24.0,
            state: "0a1b".into(),
        };
        let text = note.text();
        for part in ["a.displacement_64px.####.png", "Displacement: 64", "0.00195 px", "0.00391 px", "-64", "0a1b"] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn displacements_are_centred_and_reach_both_ends() {
        let frame = FrameSize::new(4, 1);
        let mut map = WarpMap::identity(frame, frame.window());
        map.offsets = vec![[0.0, 3.0], [-3.0, 1.5], [f32::NAN, 0.0], [9.0, -9.0]];
        assert_eq!(greatest_offset(&map), 9.0);
        let values = displacement(&map, 3.0);
        assert_eq!(values, [32768, 65535, 0, 1, 49152, 0, 32768, 32768, 0, 65535, 1, 0]);
    }
}
