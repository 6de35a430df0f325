//! The window of an export has the options of its format.

use super::stage::{SHOT, Stage};
use super::window::{Window, session, settled, window};
use egui_kittest::kittest::{NodeT, Queryable};

fn order(window: &mut Window, format: &str) {
    for entry in ["File", "Export", format] {
        window.get_by_label(entry).click();
        window.run_steps(3);
    }
}

#[test]
fn an_export_is_ordered_with_the_options_of_its_format() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    order(&mut window, "glTF with shape keys");
    let has = |window: &Window, label: &str| window.query_all_by_label(label).next().is_some();
    assert!(has(&window, "Export Frames") && has(&window, "Replace existing files"));
    assert!(!has(&window, "Overscan") && !has(&window, "Export layer left"), "it has neither maps nor layers");
    order(&mut window, "STMaps (EXR)");
    for label in ["Export Output", "Width of the maps", "Overscan", "Inverse maps, which undo the warp", "Start export"]
    {
        assert!(has(&window, label), "{label}");
    }
    window.get_by_label("Export layer left").click();
    window.run_steps(2);
    assert!(!window.get_by_label("Start export").accesskit_node().is_disabled());
    window.get_by_label("Export layer right").click();
    window.run_steps(2);
    assert!(window.get_by_label("Start export").accesskit_node().is_disabled(), "no layer is left");
    assert_eq!(session(&window).document().text(), SHOT, "options of an export are not saved");
}
