//! Pins that are to move apart though too few cells lie between them are told, with what helps.

use super::support::Studio;
use super::tiny::{Tiny, grid};
use pinwarp::pipeline::{PreparedShot, report};

/// What is said of two pins a fifteenth of the mesh from each other that go so far apart.
fn told(dims: &str, apart: f64) -> Vec<String> {
    told_of(dims, [[0.0, 0.5 * apart], [0.0, -0.5 * apart]])
}

/// The same of two that go anywhere.
fn told_of(dims: &str, [hand, skirt]: [[f64; 2]; 2]) -> Vec<String> {
    let quad = grid("Quad", [-0.3, -0.3, 0.3, 0.3], 16);
    let pin = |name: &str, x: f64, by: [f64; 2]| {
        format!(
            "[[layer.pin]]\nname = \"{name}\"\nanchor = {{ screen = [{x}, 0.5], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = [0.0, 0.0] }}, {{ frame = 5, offset = {by:?} }}]\n"
        )
    };
    let pins = pin("hand", 0.8, hand) + &pin("skirt", 0.84, skirt);
    let mut studio = Studio::tiny(
        &Tiny::of(vec![quad]),
        &format!("[[layer]]\nname = \"girl\"\nlattice = {{ dims = {dims} }}\n{pins}"),
    );
    studio.shot.size = pinwarp::space::FrameSize::new(1728, 1080);
    let prepared = alone(studio);
    let warnings = |frame: i32| report(&prepared, frame, &prepared.mid_exposure(frame).expect("it is solved")).warnings;
    assert!(!warnings(1).iter().any(|text| text.contains("share cells")), "nothing moves yet");
    warnings(5).into_iter().filter(|text| text.contains("share cells")).collect()
}

#[test]
fn pins_that_share_cells_are_reported_with_layer_pins_and_remedy() {
    let words = told("[8, 8]", 0.12);
    assert_eq!(words.len(), 1, "{words:?}");
    assert!(words[0].starts_with("layer 'girl': pins 'hand' and 'skirt' share cells of the lattice ("), "{words:?}");
    assert!(words[0].contains("are to move 130 px apart"), "{words:?}");
    let dims = words[0].split("dims = ").nth(1).and_then(|rest| rest.split(')').next()).expect("a remedy");
    assert_eq!(told(dims, 0.12), [""; 0], "the remedy helps");
    assert_eq!(told("[8, 8]", 0.03), [""; 0], "a little is no reason");
    assert_eq!(told_of("[8, 8]", [[0.0, 0.0], [-0.08, 0.0]]), [""; 0], "one turns about the other by 180 degrees");
}

/// Prepares a shot whose frames are solved alone.
fn alone(mut studio: Studio) -> PreparedShot {
    studio.shot.layers[0].settings.temporal = 0.0;
    studio.prepared()
}

/// The same of the girl who raises her hand beside her skirt.
fn told_of_puppet(dims: &str, topology: &str) -> Vec<String> {
    let prepared = alone(Studio::puppet(dims, topology));
    let warnings = report(&prepared, 11, &prepared.mid_exposure(11).expect("it is solved")).warnings;
    warnings.into_iter().filter(|text| text.contains("share cells")).collect()
}

#[test]
fn pins_on_branches_that_share_their_handles_are_reported() {
    let words = told_of_puppet("[10, 10]", "branching");
    assert_eq!(words.len(), 1, "{words:?}");
    assert!(words[0].starts_with("layer 'girl': pins 'right hand' and 'right hem' share cells"), "{words:?}");
    assert!(words[0].contains("(dims = [23, 23])") && words[0].contains("(dims = \"auto\")"), "{words:?}");
    assert!(!words[0].contains("topology"), "{words:?}");
    for dims in ["[23, 23]", "\"auto\""] {
        assert_eq!(told_of_puppet(dims, "branching"), [""; 0], "{dims}: the remedy helps");
    }
    let plain = told_of_puppet("[10, 10]", "plain");
    assert!(plain.len() == 1 && plain[0].contains("topology = \"branching\""), "{plain:?}");
}
