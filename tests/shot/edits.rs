//! Pins put into a shot: what the user wrote stays, byte for byte.

use super::{GOOD, parse, replaced};
use pinwarp::shot::{Anchor, edit};
use pinwarp::space::ScreenPoint;

fn surface() -> Anchor {
    let node = "Tea \"pot\"".to_owned();
    Anchor::Surface {
        node,
        primitive: 1,
        triangle: 7,
        barycentric: [0.25, 0.25, 0.5],
        rest: Some([0.1 + 0.2, -2.0, -1e-9]),
    }
}

fn screen() -> Anchor {
    Anchor::Screen { at: ScreenPoint::new(0.3, 1.0), frame: Some(-4) }
}

#[test]
fn a_new_pin_is_appended_after_the_last_one_of_its_layer() {
    let edited = edit::add_pin(GOOD, Some("body"), "lid", &surface()).unwrap();
    let block = "  [[layer.pin]]
  name   = \"lid\"
  anchor = { node = 'Tea \"pot\"', primitive = 1, triangle = 7, barycentric = [0.25, 0.25, 0.5], \
                 rest = [0.3, -2.0, 0.0] }
  keys   = [ { frame = 1, offset = [0.0, 0.0] } ]

";
    let handle = "  [[layer.handle]]\n";
    assert_eq!(edited, replaced(GOOD, handle, &format!("{block}{handle}")));
    let shot = parse(&edited).unwrap();
    assert_eq!(shot.layers[0].pins.len(), 3);
    let Anchor::Surface { node, rest, .. } = &shot.layers[0].pins[2].anchor else { panic!("a surface") };
    assert_eq!((node.as_str(), *rest), ("Tea \"pot\"", Some([0.3, -2.0, 0.0])));
}

#[test]
fn a_pin_of_that_name_only_gets_the_new_anchor() {
    let commented = replaced(GOOD, "0.3005] }", "0.3005] }  # at the tip");
    let edited = edit::add_pin(&commented, None, "spout", &screen()).unwrap();
    let old = "{ node = \"Teapot\", primitive = 0, triangle = 312, barycentric = [0.2, 0.5, 0.3005] }";
    assert_eq!(edited, replaced(&commented, old, "{ screen = [0.3, 1.0], frame = -4 }"));
    // Pins without a name answer to the name they are given.
    let edited = edit::add_pin(GOOD, None, "pin2", &screen()).unwrap();
    assert_eq!(edited, replaced(GOOD, "{ screen = [0.91, 0.52], frame = 1 }", "{ screen = [0.3, 1.0], frame = -4 }"));
}

#[test]
fn line_ends_and_a_byte_order_mark_are_kept() {
    let windows = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
    let edited = edit::add_pin(&windows, None, "lid", &screen()).unwrap();
    let unix = edit::add_pin(GOOD, None, "lid", &screen()).unwrap();
    assert_eq!(edited, format!("\u{feff}{}", unix.replace('\n', "\r\n")));
    let error = edit::add_pin(&windows.replacen("\r\n", "\n", 1), None, "lid", &screen()).unwrap_err();
    assert!(error.to_string().contains("save it with one kind of line ends"), "{error}");
}

#[test]
fn every_way_to_write_layers_and_pins_is_understood() {
    let head = "scene = 'a.glb'\nframes = { first = 7, last = 9 }\n";
    for (rest, pins) in [
        ("", 1),
        ("layer = []", 1),
        ("[[layer]] # empty\n# tail", 1),
        ("layer = [ { name = 'a' } ] # one", 1),
        ("layer = [ { pin = [\n  # first\n  { name = 'x', anchor.screen = [0, 0] }, # x\n  # last\n] } ]", 2),
        ("[[layer]]\npin = [ { name = 'x', anchor = { screen = [0, 0] } } ] # x", 2),
        ("[[layer]]\n[[layer.pin]]\n[layer.pin.anchor] # sub\nscreen = [0, 0] # s\n# tail\n[output] # o", 2),
        ("[[layer]]\n[[layer.pin]]\nname = 'new' # n\n[layer.pin.anchor] # sub\n# above\nscreen = [0, 0] # s", 1),
        ("[[layer]]\n[[layer.pin]]\nname = 'new' # n\nanchor.screen = [0, 0] # s\n[output]", 1),
    ] {
        let text = format!("{head}{rest}");
        let edited = edit::add_pin(&text, None, "new", &screen()).unwrap();
        let shot = parse(&edited).unwrap_or_else(|error| panic!("{error}\n{edited}"));
        let pins_now = &shot.layers[0].pins;
        assert_eq!(pins_now.len(), pins, "{edited}");
        let new = pins_now.iter().find(|pin| pin.name == "new").unwrap();
        assert_eq!(new.anchor, screen(), "{edited}");
        assert_eq!(new.keys[0].frame, 7.0);
        for comment in text.lines().filter_map(|line| line.find('#').map(|start| &line[start..])) {
            assert!(edited.lines().any(|line| line.ends_with(comment)), "{comment} is gone:\n{edited}");
        }
    }
}

#[test]
fn the_named_layer_is_edited() {
    let text = format!("{GOOD}\n[[layer]]\nname = \"eyes\" # both\n");
    let edited = edit::add_pin(&text, Some("eyes"), "spout", &screen()).unwrap();
    assert!(edited.starts_with(&text), "{edited}");
    assert_eq!(parse(&edited).unwrap().layers[1].pins[0].name, "spout");
}

#[test]
fn unsupported_edits_are_refused_with_a_remedy() {
    for (text, layer, says) in [
        ("[[layer]]\nname = 'a'\n[[layer]]", Some("b"), "no layer \"b\"; layers here: a, layer2"),
        ("layer = 3", None, "`layer` is not a list of tables; write [[layer]]"),
        ("[[layer]]\npin = 3", None, "`pin` is not a list of tables; write [[layer.pin]]"),
        ("[[layer]]\npin = [3]", None, "`pin` is not a list of tables"),
        ("a = 1\nb == 2", None, "not valid TOML in line 2"),
    ] {
        let error = edit::add_pin(text, layer, "p", &screen()).unwrap_err().to_string();
        assert!(error.starts_with("cannot write pin \"p\": ") && error.contains(says), "{error}");
    }
    assert!(edit::add_pin(GOOD, None, "", &screen()).is_err());
}

#[test]
fn a_printed_pin_can_be_pasted() {
    let pasted =
        replaced(GOOD, "  [[layer.handle]]", &format!("{}\n  [[layer.handle]]", edit::pin_block("é\n", &surface(), 1)));
    assert_eq!(parse(&pasted).unwrap().layers[0].pins[2].name, "é\n");
}

/// A pin for each of two thousand names, then new keys for all of them: work that grows with the square of their number
/// takes minutes.
#[test]
fn thousands_of_pins_are_written_and_edited() {
    use pinwarp::lattice::Basis;
    use pinwarp::shot::edit::{Factor, KeyedPin, LayerEdit, put_layer};
    let names: Vec<String> = (0..4000).map(|k| format!("pin{k}")).collect();
    let edit = |has_anchor: bool| -> Vec<KeyedPin> {
        let anchor = Anchor::Screen { at: ScreenPoint::new(0.5, 0.5), frame: None };
        names
            .iter()
            .map(|name| KeyedPin { name, anchor: has_anchor.then(|| anchor.clone()), keys: Vec::new() })
            .collect()
    };
    let put = |text: &str, pins: &[KeyedPin]| {
        let (strength, smoothness) = (Factor::Times(1.0), Factor::Times(1.0));
        let layer = LayerEdit { dims: [10, 10], basis: Basis::Bspline, strength, smoothness, pins };
        put_layer(text, None, &layer).expect("it can be edited")
    };
    let written = put("plate = 'a.exr'\n", &edit(true));
    assert_eq!(written.matches("[[layer.pin]]").count(), names.len());
    assert_eq!(put(&written, &edit(false)), written, "nothing is new");
}

/// An edit says nothing of the topology of a lattice: it stays.
#[test]
fn edits_keep_the_topology() {
    use pinwarp::lattice::Basis;
    use pinwarp::shot::edit::{Factor, LayerEdit, put_layer};
    use pinwarp::solve::Topology;
    let (strength, smoothness) = (Factor::Times(1.0), Factor::Times(1.0));
    let edit = LayerEdit { dims: [20, 24], basis: Basis::Bspline, strength, smoothness, pins: &[] };
    let text = "version = 1\nsize = [96, 64]\nimage = 'girl.png'\nframes = { first = 1, last = 2 }\noutput.path = 'o.####.exr'\n[[layer]]\nlattice = { dims = [10, 10], topology = 'branching' }\n";
    let written = put_layer(text, None, &edit).expect("it can be edited");
    let shot = pinwarp::shot::Shot::parse(&written, std::path::Path::new("shot.toml")).expect("a right shot");
    assert_eq!(shot.layers[0].settings.topology, Topology::Branching);
    assert!(written.contains("[20, 24]"), "{written}");
}
