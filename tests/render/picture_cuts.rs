//! Cuts of a picture: an arm that touches the body is one with it until a stroke, a mask, ids or the lines of the drawing cut them apart.

use super::pictures::{SIZE, Wall, body_and_arm, drawn};
use super::support::at;
use pinwarp::image::cryptomatte::MatteId;
use pinwarp::image::{Channel, Storage};
use pinwarp::shot::Shot;

/// Border of body and arm, pixels from the left.
const BORDER: f32 = 44.8;

/// A body with an arm that touches it along its whole length.
fn touching(x: f32, y: f32) -> f32 {
    body_and_arm(x, y).max(f32::from(u8::from(x > 38.0 && x < 52.0 && y > 6.0 && y < 50.0)))
}

/// Distance from the middle of a button on the body.
fn from_button(x: f32, y: f32) -> f32 {
    (x - 28.0).hypot(y - 28.0)
}

/// Whether there is ink: a line around the button, around body and arm, and between them where `is_closed` says so of the height.
fn ink(x: f32, y: f32, is_closed: fn(f32) -> bool) -> bool {
    let steps = [(-1.5, 0.0), (1.5, 0.0), (0.0, -1.5), (0.0, 1.5)];
    let is_rim = steps.iter().any(|(dx, dy)| touching(x + dx, y + dy) == 0.0);
    let is_button = (6.0..7.5).contains(&from_button(x, y));
    touching(x, y) > 0.0 && (is_rim || is_button || (x - BORDER).abs() < 1.0 && y < 50.0 && is_closed(y))
}

/// Channels of a drawing in ink on paper.
fn line_art(is_closed: fn(f32) -> bool) -> Vec<Channel> {
    let place = |k: usize| ((k % 96) as f32 + 0.5, (k / 96) as f32 + 0.5);
    let paper = |(x, y): (f32, f32)| if ink(x, y, is_closed) { 0.0 } else { 0.75 * touching(x, y) };
    let channel = |name: &str, value: &dyn Fn((f32, f32)) -> f32| Channel {
        name: name.to_owned(),
        storage: Storage::Half,
        samples: (0..SIZE.area()).map(|k| value(place(k))).collect(),
    };
    let light = ["R", "G", "B"].map(|name| channel(name, &paper));
    light.into_iter().chain([channel("A", &|(x, y)| touching(x, y))]).collect()
}

/// Channels of ids over the picture: 1 the body, 2 the arm.
fn ids() -> Vec<Channel> {
    let place = |k: usize| ((k % 96) as f32 + 0.5, (k / 96) as f32 + 0.5);
    let of = |value: &dyn Fn(bool) -> f32| -> Vec<f32> {
        let part = |(x, y): (f32, f32)| if touching(x, y) > 0.0 { value(x > BORDER) } else { 0.0 };
        (0..SIZE.area()).map(|k| part(place(k))).collect()
    };
    let [body, arm] = ["body", "arm"].map(|name| MatteId::of_name(name).sample());
    let channel = |name: &str, samples: Vec<f32>| Channel { name: name.to_owned(), storage: Storage::Float, samples };
    vec![
        channel("id.object", of(&|is_arm| if is_arm { 2.0 } else { 1.0 })),
        channel("CryptoObject00.R", of(&|is_arm| if is_arm { arm } else { body })),
        channel("CryptoObject00.G", of(&|_| 1.0)),
    ]
}

/// A wall with the picture and all that may cut it.
fn wall() -> Wall {
    let wall = Wall::new();
    wall.hang("one.exr", SIZE, drawn(SIZE, "", touching));
    wall.hang("lines.exr", SIZE, line_art(|_| true));
    wall.hang("gap.exr", SIZE, line_art(|y| !(22.0..28.0).contains(&y)));
    wall.hang("ids.exr", SIZE, ids());
    let save = |name: &str, [width, height]: [u32; 2], pixel: &dyn Fn(f32, f32) -> [u8; 4]| {
        let pixel = |x: u32, y: u32| image::Rgba(pixel(x as f32 + 0.5, y as f32 + 0.5));
        image::RgbaImage::from_fn(width, height, pixel).save(wall.folder.path().join(name)).expect("saved");
    };
    let grey = |is_white: bool| if is_white { [255; 4] } else { [0, 0, 0, 255] };
    save("arm.png", [192, 128], &|x, _| grey(x > 2.0 * BORDER));
    save("black.png", [96, 64], &|_, _| grey(false));
    save("square.png", [64, 64], &|x, _| grey(x > 40.0));
    // Twice as large, with a button and a soft border, and nothing around the drawing.
    save("ids.png", [192, 128], &|x, y| {
        let share = ((x - 2.0 * BORDER) / 3.0 + 0.5).clamp(0.0, 1.0);
        let code = |from: f32, to: f32| (from + share * (to - from)) as u8;
        let blue = if from_button(0.5 * x, 0.5 * y) < 7.0 { 200 } else { 90 };
        [code(200.0, 20.0), code(40.0, 160.0), blue, 255 * u8::from(touching(0.5 * x, 0.5 * y) > 0.0)]
    });
    save("noise.png", [96, 64], &|x, y| {
        [(37.0 * x % 251.0) as u8, (59.0 * y % 251.0) as u8, (x * y % 251.0) as u8, 255]
    });
    wall
}

/// A shot of a picture with these cuts.
fn text_of(image: &str, cuts: &str, pins: &str) -> String {
    let lattice = format!("{{ dims = [24, 24], topology = \"branching\", cuts = [{cuts}] }}");
    format!("version = 1\nimage = \"{image}\"\n[[layer]]\nlattice = {lattice}\n{pins}")
}

/// Pins at places in pixels, with offsets.
fn pins(places: &[(f32, f32, [f32; 2])]) -> String {
    let pin = |&(x, y, [dx, dy]): &(f32, f32, [f32; 2])| {
        format!(
            "[[layer.pin]]\nanchor = {{ screen = [{}, {}], frame = 1 }}\nkeys = [{{ frame = 1, offset = [{}, {}] }}]\n",
            x / 64.0,
            1.0 - y / 64.0,
            dx / 64.0,
            dy / 64.0
        )
    };
    places.iter().map(pin).collect()
}

/// What happens as the arm is pulled away: number of pixels that are uncovered between body and arm, and number of pixels of the body, the
/// arm's root apart, that change.
fn pulled(image: &str, cuts: &str) -> [usize; 2] {
    let wall = wall();
    let held = [0.0; 2];
    let pins = pins(&[(18.0, 10.0, held), (38.0, 40.0, held), (28.0, 55.0, held), (55.0, 46.0, [18.0, 6.0])]);
    let (still, _) = wall.render(wall.shot(&text_of(image, cuts, "")));
    std::fs::remove_dir_all(wall.folder.path().join("out")).expect("frames were written");
    let (frame, _) = wall.render(wall.shot(&text_of(image, cuts, &pins)));
    let alpha = |x: i32, y: i32| at(&frame, "A", x, y);
    let uncovered = (30..48).flat_map(|y| (44..56).map(move |x| (x, y))).filter(|&(x, y)| alpha(x, y) < 0.5).count();
    let differs = |&(x, y): &(i32, i32)| {
        ["R", "A"].iter().any(|name| (at(&frame, name, x, y) - at(&still, name, x, y)).abs() > 0.03)
    };
    let changed = (24..56).flat_map(|y| (18..43).map(move |x| (x, y))).filter(differs).count();
    [uncovered, changed]
}

/// Checks that cuts let the arm go, which without them takes the body along.
fn check_free(image: &str, cuts: &[&str]) {
    let [whole, dragged] = pulled(image, "");
    println!("{image}: {whole} pixels uncovered, {dragged} of the body dragged along as one piece");
    assert!(whole == 0 && dragged > 50, "{whole} uncovered, {dragged} dragged");
    for cut in cuts {
        let [uncovered, changed] = pulled(image, cut);
        println!("{cut}: {uncovered} uncovered, {changed} dragged");
        assert!(
            uncovered > 30 && 4 * changed < dragged,
            "{cut}: {uncovered} uncovered, {changed} of {dragged} dragged"
        );
    }
}

#[test]
fn a_stroke_or_a_mask_cuts_apart_what_touches() {
    check_free("one.exr", &["[[0.7, 0.05], [0.7, 0.77]]", "{ mask = { file = 'arm.png' } }"]);
}

#[test]
fn ids_cut_apart_what_touches() {
    check_free(
        "one.exr",
        &[
            "{ ids = { file = 'ids.png' } }",
            "{ ids = { file = 'ids.exr' } }",
            "{ ids = { file = 'ids.exr', cryptomatte = ['arm'], of = 'CryptoObject' } }",
            "{ ids = { file = 'ids.exr', id = 'id.object' } }",
            "{ ids = { file = 'ids.exr', id = 'id.object', values = [2] } }",
        ],
    );
}

#[test]
fn closed_regions_cut_apart_what_touches() {
    check_free(
        "lines.exr",
        &["{ regions = {} }", "{ regions = { at = [[0.82, 0.4]] } }", "{ regions = { file = 'gap.exr', gap = 0.12 } }"],
    );
    check_free("one.exr", &["{ regions = { file = 'lines.exr', at = [[0.82, 0.4]] } }"]);
}

#[test]
fn an_opaque_picture_tears_along_the_cut_and_not_along_its_triangles() {
    let wall = wall();
    wall.hang("full.exr", SIZE, drawn(SIZE, "", |_, _| 1.0));
    let border = |y: f32| 24.0 + 0.6 * y;
    let pixel = |x: u32, y: u32| {
        let is_right = x as f32 + 0.5 > 2.0 * border((y as f32 + 0.5) / 2.0);
        image::Rgba([if is_right { 255 } else { 0 }, 0, 90, 255])
    };
    image::RgbaImage::from_fn(192, 128, pixel).save(wall.folder.path().join("slant.png")).expect("saved");
    let (held, moved) = ([0.0; 2], [16.0, 0.0]);
    let pins = pins(&[(12.0, 12.0, held), (12.0, 50.0, held), (60.0, 12.0, moved), (75.0, 50.0, moved)]);
    for cut in ["{ ids = { file = 'slant.png' } }", "{ mask = { file = 'slant.png' } }", "[[0.375, 1.0], [0.975, 0.0]]"]
    {
        let (frame, _) = wall.render(wall.shot(&text_of("full.exr", cut, &pins)));
        for y in 2..62 {
            let is_seen = |x: &i32| at(&frame, "A", *x, y) > 0.5;
            let found = [(0..96).find(|x| !is_seen(x)), (40..96).find(|x| !is_seen(&(x - 1)) && is_seen(x))];
            for (found, shift) in found.into_iter().zip([0.0, moved[0]]) {
                let off = found.map(|x| x as f32 - border(y as f32 + 0.5) - shift);
                assert!(off.is_some_and(|off| off.abs() < 1.5), "{cut}: row {y} is off by {off:?} pixels");
            }
        }
        std::fs::remove_dir_all(wall.folder.path().join("out")).expect("frames were written");
    }
}

/// The part that a cut chooses is laid over the rest, or behind it, as its order says; an order of its own pin goes before.
#[test]
fn the_order_of_a_part_says_whether_it_is_in_front() {
    let red = |x: f32| x * 0.02 - 0.3;
    let wall = wall();
    let held = [0.0; 2];
    let body = pins(&[(18.0, 10.0, held), (38.0, 40.0, held), (28.0, 55.0, held)]);
    let hand = pins(&[(55.0, 46.0, [-25.0, 0.0])]);
    let seen_in_front = |cut: &str, [body, hand]: [&str; 2], [of_body, of_hand]: [&str; 2]| {
        let ordered = |pins: &str, order: &str| pins.replace("keys = ", &format!("{order}\nkeys = "));
        let pins = ordered(body, of_body) + &ordered(hand, of_hand);
        let (frame, _) = wall.render(wall.shot(&text_of("one.exr", cut, &pins)));
        std::fs::remove_dir_all(wall.folder.path().join("out")).expect("frames were written");
        // What is seen where the hand now is, and how far it is from the colours of body and arm.
        let [body, arm] = [30.5, 55.5].map(|x| (at(&frame, "R", 30, 45) - red(x)).abs());
        assert!(body.min(arm) < 0.1, "{cut}: {body} from the body, {arm} from the arm");
        arm < body
    };
    let is_in_front = |cut: &str, of_hand: &str, of_body: &str| seen_in_front(cut, [&body, &hand], [of_body, of_hand]);
    let mask = |order: &str| format!("{{ mask = {{ file = 'arm.png' }}, {order} }}");
    assert!(is_in_front(&mask("order = 1"), "", ""));
    assert!(!is_in_front(&mask("order = -1"), "", ""));
    assert!(is_in_front(&mask("order = [{ frame = 1, value = 2 }, { frame = 2, value = -1 }]"), "", ""));
    for (order, wanted) in [(1, true), (-1, false)] {
        let ids = format!("{{ ids = {{ file = 'ids.exr', id = 'id.object', values = [2] }}, order = {order} }}");
        assert_eq!(is_in_front(&ids, "", ""), wanted, "{ids}");
    }
    assert!(!is_in_front(&mask("order = 1"), "", "order = 2"), "pins of the body say what of it is in front");
    assert!(is_in_front(&mask("order = -1"), "order = 1", ""), "the pin of the part goes before");
    let fixed = [&body, &hand].map(|pins| pins.replace(", frame = 1 }", " }"));
    assert_ne!(fixed, [body.clone(), hand.clone()]);
    let is_seen = seen_in_front(&mask("order = -1"), [&fixed[0], &fixed[1]], ["", "order = 1"]);
    assert!(is_seen, "so does one at a place of the screen");
}

/// The fault of a shot of a picture with these cuts.
fn fault_of(image: &str, cuts: &str) -> String {
    let wall = wall();
    let text = format!("frames = {{ first = 1, last = 2 }}\n{}", text_of(image, cuts, ""));
    match Shot::parse(&text, &wall.folder.path().join("shot.toml")) {
        Ok(shot) => wall.fault(shot),
        Err(error) => error.to_string(),
    }
}

#[test]
fn cuts_of_a_picture_that_separate_nothing_are_told() {
    let faults = [
        ("[[0.0, 0.99], [0.1, 0.99]]", ["cuts nothing", "cuts[0]"]),
        ("{ mask = { file = 'black.png' } }", ["selects 0 of", "which lies over the whole picture"]),
        (
            "{ mask = { file = 'square.png' } }",
            ["the mask has 64 x 64 pixels, the picture 96 x 64", "cuts[0].mask.file"],
        ),
        ("{ mask = { file = 'none.png' } }", ["none.png", "cuts[0].mask.file"]),
        ("{ mask = { file = 'black.png', texcoord = 1 } }", ["a picture has no UVs", "cuts[0].mask.texcoord"]),
        ("{ joints = ['Arm'] }", ["only a `scene` has parts with names", "paint a mask"]),
    ];
    for (cuts, parts) in faults {
        let told = fault_of("one.exr", cuts);
        assert!(parts.iter().all(|part| told.contains(part)), "{cuts}: {told}");
    }
}

#[test]
fn ids_that_are_missing_or_separate_nothing_are_told() {
    let faults = [
        ("{ ids = { file = 'black.png' } }", ["separates nothing: it divides the picture into 1 part;", "cuts[0]"]),
        ("{ ids = { file = 'noise.png' } }", ["no colour fills", "cuts[0].ids.file"]),
        ("{ ids = { file = 'square.png' } }", ["64 x 64 pixels, the picture 96 x 64", "cuts[0].ids.file"]),
        ("{ ids = { file = 'isd.png' } }", ["did you mean \"ids.png\"", "cuts[0].ids.file"]),
        ("{ ids = { file = 'ids.png', cryptomatte = ['arm'] } }", ["it has no Cryptomatte", "cuts[0].ids"]),
        ("{ ids = { file = 'ids.exr', id = 'id.objekt' } }", ["did you mean \"id.object\"", "cuts[0].ids.id"]),
        ("{ ids = { file = 'ids.exr', id = 'id.object', values = [7] } }", ["separates nothing", "cuts[0]"]),
        ("{ ids = { file = 'ids.exr', of = 'CryptoAsset' } }", ["no Cryptomatte of", "cuts[0].ids"]),
        ("{ ids = { file = 'ids.exr', values = [7] } }", ["belongs to `id`", "cuts[0].ids.values"]),
        ("{ ids = { file = 'ids.png' }, open = true }", ["stands alone", "cuts[0].open"]),
    ];
    for (cuts, parts) in faults {
        let told = fault_of("one.exr", cuts);
        assert!(parts.iter().all(|part| told.contains(part)), "{cuts}: {told}");
    }
}

#[test]
fn regions_that_are_missing_or_separate_nothing_are_told() {
    let faults = [
        ("{ regions = { file = 'black.png' } }", ["divides the picture into 1 part;", "raise `gap`"]),
        ("{ regions = { at = [[0.82, 0.4], [1.6, 0.5]] } }", ["outside the picture", "cuts[0].regions.at[1]"]),
        ("{ regions = { at = [[0.7, 0.4]] } }", ["lies on a line", "cuts[0].regions.at[0]"]),
        ("{ regions = { at = [[0.05, 0.4]] } }", ["outside of what the lines close", "cuts[0].regions.at[0]"]),
        ("{ regions = { threshold = 1.0 } }", ["no closed region", "cuts[0].regions"]),
        ("{ regions = { file = 'square.png' } }", ["64 x 64 pixels, the picture 96 x 64", "cuts[0].regions.file"]),
        ("{ regions = { file = 'line.exr' } }", ["did you mean \"lines.exr\"", "cuts[0].regions.file"]),
        ("{ regions = {}, ids = { file = 'ids.png' } }", ["stands alone", "cuts[0].regions"]),
    ];
    for (cuts, parts) in faults {
        let told = fault_of("lines.exr", cuts);
        assert!(parts.iter().all(|part| told.contains(part)), "{cuts}: {told}");
    }
}
