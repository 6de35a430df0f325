//! Plates whose holes a clean plate fills: no trace of the old outline stays, and no background travels with the layer.

use super::stage::Stage;

#[test]
fn a_clean_plate_leaves_no_outline_where_a_layer_was() {
    let stage = Stage::with(&["Wall", "Figure"]);
    let found = stage.compared(stage.clean(), "before a wall");
    // Measured: 35 and 29, at the outline where it is now. With the wall in its edges the figure had 755 and 736.
    assert!(found.iter().all(|wrong| wrong.alpha == 0 && wrong.color < 60 && wrong.whole == 0), "{found:?}");
    // Over nothing the filter softens the new outline once more.
    let stage = Stage::with(&["Figure"]);
    let found = stage.compared(stage.clean(), "before nothing");
    assert!(found.iter().all(|wrong| wrong.traces == 0 && wrong.alpha < 200 && wrong.whole == 0), "{found:?}");
}
