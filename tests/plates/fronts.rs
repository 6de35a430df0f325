//! A static box in front of a figure that moves: it stays in front, and what it hid of the figure is a hole.

use super::stage::Stage;
use pinwarp::plate::Holes;

#[test]
fn a_box_in_front_of_a_moved_figure_stays_in_front() {
    let found = Stage::with(&["Figure", "Box"]).compared(Holes::Leave, "before nothing");
    // The first frame moves a part of the figure out from behind the box, the second does not.
    assert!(found[0].missing > 250 && found[1].missing == 0, "{found:?}");
    // Outlines. A figure over the box differs in 8473 and 3030 whole pixels.
    assert!(found.iter().all(|wrong| wrong.whole < 100 && wrong.alpha < 450 && wrong.color < 600), "{found:?}");
    let stage = Stage::with(&["Wall", "Figure", "Box"]);
    let found = stage.compared(stage.clean(), "before a wall");
    // Where the plate does not know the figure, the clean plate shows the wall.
    assert!(found[0].whole < 500 && found[1].whole < 60, "{found:?}");
    assert!(found.iter().all(|wrong| wrong.alpha < 50 && wrong.color < 900), "{found:?}");
}
