//! Writes a Nuke script that applies the STMaps, and the same warp as grids that an artist can edit.
//!
//! In: screen lattices, and the STMap sequence beside the script. Out: the text of a .nk file.

mod grid;
mod lost_branches;

pub(crate) use lost_branches::LostBranches;

use super::{LatticeFile, Track};
use crate::files::GENERATOR;
use crate::space::FrameSize;
use grid::{Side, grid_knob};
use std::fmt::Write;

/// Contents of the script.
#[derive(Clone, Debug)]
pub(crate) struct NukeScene<'a> {
    /// The lattices; those in scene space are skipped.
    pub lattices: &'a LatticeFile,
    /// The STMap sequence, relative to the script: `out.stmap.####.exr`.
    pub stmap: String,
    /// First and last frame.
    pub frames: [i32; 2],
    /// Size of the frame in pixels.
    pub size: FrameSize,
}

/// Header of the script, below the line that names its generator.
const HEAD: &str = "\
# Connect your plate to the dots 'plate' and 'plate_for_grids'.
# pinwarp_stmap: the warp of pinwarp itself, to the pixel; use this one for finals.
# pinwarp_grid_*: the same lattices as grids to look at and to move by hand. Along grid lines of B-splines they agree,
# between the lines Nuke blends in its own way, and outside the grids nothing moves. The grids were written without a
# Nuke at hand: compare both branches before you trust them. A grid holds one branch of a lattice; its label says what it leaves out.
";

/// Returns the text of the script.
#[must_use]
pub(crate) fn script(scene: &NukeScene<'_>) -> String {
    let [first, last] = scene.frames;
    let FrameSize { width, height, pixel_aspect } = scene.size;
    let format = format!("\"{width} {height} 0 0 {width} {height} {pixel_aspect} pinwarp\"");
    let rate = scene.lattices.rate;
    let mut text = format!("# Written by {GENERATOR}, `pinwarp export --to nuke`.\n{HEAD}");
    let root = format!(
        "Root {{\n inputs 0\n project_directory \"\\[python \\{{nuke.script_directory()\\}}]\"\n first_frame {first}\n \
         last_frame {last}\n fps {rate}\n format {format}\n}}\n"
    );
    text.push_str(&root);
    // Nodes take their inputs from the top of the stack: the plate is pushed last and becomes input 0.
    let map = &scene.stmap;
    let read = format!(
        "Read {{\n inputs 0\n file_type exr\n file \"{map}\"\n format {format}\n first {first}\n last {last}\n \
         origfirst {first}\n origlast {last}\n origset true\n raw true\n name pinwarp_map\n xpos 0\n ypos 0\n}}\n"
    );
    text.push_str(&read);
    text.push_str("Dot {\n inputs 0\n name plate\n label \"your plate\"\n xpos 200\n ypos 0\n}\n");
    text.push_str(
        "STMap {\n inputs 2\n channels all\n uv rgb\n filter Cubic\n name pinwarp_stmap\n xpos 200\n ypos 100\n}\n",
    );
    text.push_str("Dot {\n inputs 0\n name plate_for_grids\n label \"your plate\"\n xpos 500\n ypos 0\n}\n");
    for (number, layer) in scene.lattices.layers.iter().enumerate() {
        let Track::Screen(lattices) = &layer.track else { continue };
        let [source, destination] = [Side::Source, Side::Destination].map(|side| grid_knob(lattices, scene.size, side));
        let name: String = layer.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let below = 100 + 100 * number;
        let lost = LostBranches::of(layer, scene.size);
        let label = lost.map_or_else(String::new, |lost| format!(" label \"largest branch only: {lost}\"\n"));
        write!(
            text,
            "GridWarp3 {{\n toolbar_visibility_src false\n source_grid_col {source}\n destination_grid_col \
             {destination}\n grids_manually_moved true\n destination_grid_visible false\n name pinwarp_grid_{name}\n\
             {label} xpos 500\n ypos {below}\n}}\n"
        )
        .expect("strings take all text");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::LatticeTrack;
    use crate::lattice::{Basis, Grid};
    use std::collections::BTreeMap;

    #[test]
    fn the_map_is_read_relative_to_the_script_and_the_plate_is_the_first_input() {
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
        let track = Track::Screen(BTreeMap::from([(7, grid.at_rest())]));
        let layers = vec![LatticeTrack {
            name: "left arm".into(),
            track,
            placements: BTreeMap::new(),
            branches: BTreeMap::new(),
            has_branches_in_scene: false,
            wholes: BTreeMap::new(),
        }];
        let lattices = &LatticeFile { frame_aspect: 2.0, rate: 24.0, layers };
        let stmap = "a.stmap.####.exr".to_owned();
        let text = script(&NukeScene { lattices, stmap, frames: [7, 7], size: FrameSize::new(200, 100) });
        let places = [
            "project_directory \"\\[python \\{nuke.script_directory()\\}]\"",
            "file \"a.stmap.####.exr\"",
            "name plate\n",
            "uv rgb",
            "name pinwarp_grid_left_arm",
        ]
        .map(|part| text.find(part).unwrap_or_else(|| unreachable!("{part} is missing in {text}")));
        assert!(places.is_sorted(), "{places:?}");
        let count = |brace: char| text.replace("\\{", "").replace("\\}", "").matches(brace).count();
        assert_eq!(count('{'), count('}'));
        assert!(!text.contains("largest branch"), "{text}");
    }

    #[test]
    fn the_label_of_a_grid_says_which_branches_it_leaves_out() {
        let lattices =
            &LatticeFile { frame_aspect: 2.0, rate: 24.0, layers: vec![lost_branches::tests::two_branches()] };
        let stmap = "a.stmap.####.exr".to_owned();
        let text = script(&NukeScene { lattices, stmap, frames: [1, 2], size: FrameSize::new(200, 100) });
        let label =
            "label \"largest branch only: in frame 2 it leaves out 1 branch, 5000 pixels (5000 around 1.25, 0.50)\"";
        assert!(text.contains(label), "{text}");
    }
}
