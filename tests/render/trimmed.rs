//! Trimmed shots: a frame within `solve_range` stays what it is, whichever frames are rendered.

use super::support::Studio;
use pinwarp::shot::{LayerSpace, Shot};
use std::path::Path;

/// A scene without lights under a camera that moves, with a lattice of automatic dims.
fn orbit(frames: [i32; 2]) -> Studio {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/gingerman/gingerman.glb");
    let [first, last] = frames;
    let text = format!(
        "version = 1\nscene = {scene:?}\nframes = {{ first = {first}, last = {last}, rate = 24, clip_start = 1 }}\n\
         solve_range = [1, 12]\nsize = [64, 40]\nsamples = 1\n\
         camera = {{ look_at = \"Gingerman\", keys = [{{ frame = 1, yaw = 75 }}, {{ frame = 12, yaw = 10 }}] }}\n\
         [[layer]]\nname = \"all\"\nlattice = {{ dims = \"auto\" }}\n\
         [[layer.pin]]\nname = \"held\"\nanchor = {{ node = \"Body\", triangle = 0, barycentric = [1, 0, 0] }}\n\
         [[layer.pin]]\nname = \"moved\"\nanchor = {{ node = \"Body\", triangle = 100, barycentric = [1, 0, 0] }}\n\
         keys = [{{ frame = 1, offset = [0.0, 0.0] }}, {{ frame = 12, offset = [0.1, 0.1] }}]\n"
    );
    Studio::of_shot(Shot::parse(&text, &scene.with_file_name("orbit.toml")).expect("a right shot"))
}

/// Handles per axis.
fn dims(studio: &Studio) -> [usize; 2] {
    match studio.prepared().shot.layers[0].space {
        LayerSpace::Screen { dims, .. } => dims,
        LayerSpace::World { .. } => unreachable!("the layer is on the screen"),
    }
}

#[test]
fn lattice_and_light_stay_when_the_shot_is_trimmed() {
    let (whole, trimmed) = (orbit([1, 12]), orbit([6, 8]));
    assert_eq!(dims(&whole), dims(&trimmed));
    let [whole, trimmed] = [whole, trimmed].map(|studio| studio.frame(7));
    assert_eq!(whole.data_window, trimmed.data_window);
    for (a, b) in whole.channels.iter().zip(&trimmed.channels) {
        assert_eq!((&a.name, &a.samples), (&b.name, &b.samples));
    }
    // A shot that is solved over other frames is another one.
    let mut other = orbit([6, 8]);
    other.shot.solve_range = [6, 8];
    assert_ne!(other.frame(7).channel("R").map(|c| &c.samples), trimmed.channel("R").map(|c| &c.samples));
}
