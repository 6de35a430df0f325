//! The metadata of a frame's file.
//!
//! In: [`FrameMetadata`]. Out: EXR attributes, and the inverse. Nothing here depends on the time or the machine. Our
//! own fields share one attribute (`pinwarp`, JSON).

use super::cryptomatte::MatteHeader;
use super::exr_file::text;
use super::provenance::{self, Provenance};
use crate::files::GENERATOR;
use crate::space::{FrameSize, ScreenPoint};
use exr::meta::attribute::{AttributeValue, Chromaticities, Rational, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::Vec2;
use glam::{DMat4, DVec4};
use serde_json::Value;

/// Metadata written with the pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameMetadata {
    /// Frame number.
    pub frame: i32,
    /// Frame rate, in frames per second; omitted unless positive.
    pub frames_per_second: f64,
    /// Digest of the shot and everything it refers to.
    pub shot_hash: String,
    /// The class of device that drew the frame, independent of the machine: `CPU`, `Vulkan`.
    pub device: String,
    /// The camera, if there is one.
    pub camera: Option<CameraMatrices>,
    /// Cryptomattes of the frame; not read back.
    pub mattes: Vec<MatteHeader>,
    /// Report on the frame as JSON; null: none.
    pub report: Value,
}

/// Matrices of a frame's camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// Scene space to glTF's camera space: right-handed, y up, looking along −z, metres.
    pub camera_from_scene: DMat4,
    /// Scene space to homogeneous screen space (x·w, y·w, z·w, w): frame heights, y up.
    pub screen_from_scene: DMat4,
}

impl FrameMetadata {
    pub(super) fn add_to_layer(&self, layer: &mut LayerAttributes, frame: FrameSize) {
        self.add_provenance(layer);
        for (name, words) in self.mattes.iter().flat_map(MatteHeader::attributes) {
            layer.other.insert(text(&name), AttributeValue::Text(text(&words)));
        }
        layer.software_name = Some(Text::from(GENERATOR));
        layer.frames_per_second = rational_rate(self.frames_per_second);
        if let Some(camera) = &self.camera {
            layer.world_to_camera = Some(row_vector_matrix(exr_camera_from_scene(camera)));
            layer.world_to_normalized_device = Some(row_vector_matrix(ndc_from_scene(camera, frame)));
        }
    }

    /// Adds only what resuming needs, and nothing that a plate of another program already specifies.
    pub(super) fn add_provenance(&self, layer: &mut LayerAttributes) {
        provenance::put(layer, &self.provenance());
    }

    /// Returns the fields that resuming needs.
    pub(super) fn provenance(&self) -> Provenance {
        Provenance {
            frame: self.frame,
            shot_hash: self.shot_hash.clone(),
            device: self.device.clone(),
            version: provenance::VERSION.to_owned(),
            report: self.report.clone(),
        }
    }

    pub(super) fn from_provenance(provenance: Provenance) -> Self {
        Self {
            frame: provenance.frame,
            shot_hash: provenance.shot_hash,
            device: provenance.device,
            report: provenance.report,
            ..Self::default()
        }
    }

    /// Returns `None` for files that pinwarp did not write. The camera is not read back.
    pub(super) fn from_layer(layer: &LayerAttributes) -> Option<Self> {
        let provenance = provenance::from_layer(layer)?;
        let rate = layer.frames_per_second.map_or(0.0, |(count, secs)| f64::from(count) / f64::from(secs.max(1)));
        Some(Self { frames_per_second: rate, ..Self::from_provenance(provenance) })
    }
}

/// Scene-linear Rec. 709 / sRGB primaries with a D65 white (ITU-R BT.709-6, table 1).
pub(super) fn add_color_space(image: &mut ImageAttributes) {
    image.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
}

/// Converts a frame rate: 24 to 24/1; 23.976 and 23.98 to 24000/1001, 29.97 to 30000/1001; anything else in thousandths.
fn rational_rate(frames_per_second: f64) -> Option<Rational> {
    if !(frames_per_second > 0.0 && frames_per_second <= 1e6) {
        return None;
    }
    let whole = frames_per_second.round();
    if (frames_per_second - whole).abs() < 1e-6 {
        return Some((whole as i32, 1));
    }
    // NTSC rates are commonly rounded to two digits: tolerate half a hundredth.
    let ntsc = frames_per_second.ceil() * 1000.0;
    if (frames_per_second - ntsc / 1001.0).abs() < 0.005 {
        return Some((ntsc as i32, 1001));
    }
    let thousandths = ((frames_per_second * 1000.0).round() as u32).max(1);
    let divisor = greatest_common_divisor(thousandths, 1000);
    Some(((thousandths / divisor) as i32, 1000 / divisor))
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Returns `worldToCamera`: OpenEXR's camera space is left-handed, x right, y up, looking along +z (ImfStandardAttributes.h).
fn exr_camera_from_scene(camera: &CameraMatrices) -> DMat4 {
    let exr_from_camera = DMat4::from_diagonal(DVec4::new(1.0, 1.0, -1.0, 1.0));
    exr_from_camera * camera.camera_from_scene
}

/// Returns `worldToNDC`: (0, 0) is the upper left corner of the display window, (1, 1) its lower right (ImfStandardAttributes.h).
fn ndc_from_scene(camera: &CameraMatrices, frame: FrameSize) -> DMat4 {
    let image_from_screen = |x, y| frame.image_from_screen(ScreenPoint::new(x, y)).0;
    let origin = image_from_screen(0.0, 0.0);
    let (x, y) = (image_from_screen(1.0, 0.0) - origin, image_from_screen(0.0, 1.0) - origin);
    let size = glam::DVec2::new(f64::from(frame.width), f64::from(frame.height));
    let column = |v: glam::DVec2| (v / size).extend(0.0).extend(0.0);
    let ndc_from_screen = DMat4::from_cols(column(x), column(y), DVec4::Z, (origin / size).extend(0.0).extend(1.0));
    ndc_from_screen * camera.screen_from_scene
}

/// OpenEXR multiplies row vectors from the left and stores rows: the same 16 numbers as our columns.
fn row_vector_matrix(matrix: DMat4) -> [f32; 16] {
    matrix.as_mat4().to_cols_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec4Swizzles};

    #[test]
    fn rates_become_the_fractions_people_mean() {
        for (rate, fraction) in [
            (24.0, (24, 1)),
            (23.976, (24000, 1001)),
            (23.98, (24000, 1001)),
            (29.97, (30000, 1001)),
            (59.94, (60000, 1001)),
            (12.5, (25, 2)),
            (0.5, (1, 2)),
        ] {
            assert_eq!(rational_rate(rate), Some(fraction), "{rate}");
        }
        for rate in [0.0, -24.0, f64::NAN, f64::INFINITY] {
            assert_eq!(rational_rate(rate), None, "{rate}");
        }
    }

    #[test]
    fn camera_matrices_follow_the_conventions_of_openexr() {
        // A camera at (1, 2, 3) that looks along −z and sees half a metre up and down at a distance of one metre.
        let camera_from_scene = DMat4::from_translation(-DVec3::new(1.0, 2.0, 3.0));
        let frame = FrameSize { width: 200, height: 100, pixel_aspect: 2.0 };
        // x_screen = (x / -z + aspect / 2), y_screen = (y / -z + 1 / 2).
        let aspect = frame.aspect();
        let screen_from_camera = DMat4::from_cols(
            DVec4::X,
            DVec4::Y,
            DVec4::new(-aspect / 2.0, -0.5, 0.0, -1.0),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
        );
        let camera = CameraMatrices { camera_from_scene, screen_from_scene: screen_from_camera * camera_from_scene };

        // Half right of the frame's width, a quarter of its height above the middle, two metres ahead.
        let point = DVec3::new(1.0 + 2.0 * aspect / 2.0, 2.0 + 2.0 * 0.25, 1.0).extend(1.0);
        assert_eq!((exr_camera_from_scene(&camera) * point).z, 2.0);
        let ndc = ndc_from_scene(&camera, frame) * point;
        assert!((ndc.xy() / ndc.w - glam::DVec2::new(1.0, 0.25)).length() < 1e-12, "{ndc}");
    }
}
