//! Shots of pictures: nothing moves to the bit, pins move smoothly, pictures lie over one another.

use super::support::at;
use pinwarp::image::{Channel, Compression, Frame, FrameMetadata, Storage, read_exr, write_exr};
use pinwarp::pipeline::{Event, OpenShot, PreparedShot, RenderOptions, render};
use pinwarp::raster::ChannelGroup;
use pinwarp::shot::Shot;
use pinwarp::solve::Topology;
use pinwarp::space::{FrameSize, PixelRect};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

pub(crate) const SIZE: PixelRect = PixelRect { x: 0, y: 0, width: 96, height: 64 };

/// Where things lie: a disc of a size around a place.
fn disc(x: f32, y: f32, radius: f32) -> impl Fn(f32, f32) -> f32 {
    move |px, py| (radius + 0.5 - (px - x).hypot(py - y)).clamp(0.0, 1.0)
}

/// A picture of a field's coverage in a colour that runs across, negative and bright values included.
pub(crate) fn drawn(window: PixelRect, prefix: &str, coverage: impl Fn(f32, f32) -> f32) -> Vec<Channel> {
    let place = |k: usize| {
        let (x, y) = (k % window.width as usize, k / window.width as usize);
        (x as f32 + window.x as f32 + 0.5, y as f32 + window.y as f32 + 0.5)
    };
    let channel = |name: &str, value: &dyn Fn(f32, f32) -> f32| {
        let samples = (0..window.area()).map(|k| {
            let (x, y) = place(k);
            // Not −0: what holds nothing is not stored.
            half_rounded(value(x, y)) + 0.0
        });
        Channel { name: format!("{prefix}{name}"), storage: Storage::Half, samples: samples.collect() }
    };
    vec![
        channel("R", &|x, y| coverage(x, y) * (x * 0.02 - 0.3)),
        channel("G", &|x, y| coverage(x, y) * 3.7),
        channel("B", &|x, y| coverage(x, y) * y * 0.01),
        channel("A", &|x, y| coverage(x, y)),
    ]
}

/// To eleven bits, so that a half holds it.
fn half_rounded(value: f32) -> f32 {
    f32::from_bits((value.to_bits() + 0x1000) & !0x1fff)
}

/// A folder with pictures.
pub(crate) struct Wall {
    pub(crate) folder: TempDir,
}

impl Wall {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub(crate) fn hang(&self, name: &str, data_window: PixelRect, channels: Vec<Channel>) -> Frame {
        let frame = Frame { display: SIZE, data_window, pixel_aspect: 1.0, channels };
        let path = self.folder.path().join(name);
        write_exr(&path, &frame, &FrameMetadata::default(), Compression::Zip).expect("the folder can be written to");
        frame
    }

    pub(crate) fn shot(&self, text: &str) -> Shot {
        let text = format!("frames = {{ first = 1, last = 2 }}\noutput.path = \"out/f.####.exr\"\n{text}");
        Shot::parse(&text, &self.folder.path().join("shot.toml")).expect("a right shot")
    }

    /// The first frame, and what was said on the way.
    pub(crate) fn render(&self, shot: Shot) -> (Frame, Vec<String>) {
        let notes = Mutex::new(Vec::new());
        let options =
            RenderOptions { frames: vec![1], has_preview: true, has_overlay: true, ..RenderOptions::default() };
        let tell = |event: Event| {
            if let Event::Note { text } | Event::FrameFailed { error: text, .. } = event {
                notes.lock().expect("nobody panics").push(text);
            }
        };
        let prepared = PreparedShot::new(shot).expect("the pictures are there");
        let summary = render(&prepared, &options, &AtomicBool::new(false), &tell).expect("it renders");
        assert_eq!((summary.rendered, summary.failed), (1, 0));
        let path = self.folder.path().join("out/f.0001.exr");
        assert!(path.with_extension("png").exists());
        (read_exr(&path).expect("it was written"), notes.into_inner().expect("nobody panics"))
    }

    pub(crate) fn fault(&self, shot: Shot) -> String {
        PreparedShot::new(shot).expect_err("a fault").to_string()
    }
}

/// A sample by place in the frame; 0 outside the data window.
fn sample(frame: &Frame, channel: &str, x: i32, y: i32) -> f32 {
    let window = frame.data_window;
    let (column, row) = (x - window.x, y - window.y);
    let is_inside = (0..window.width as i32).contains(&column) && (0..window.height as i32).contains(&row);
    let channel = frame.channel(channel).expect("the channel is written");
    if is_inside { channel.samples[row as usize * window.width as usize + column as usize] } else { 0.0 }
}

const PIN: &str = "[[layer]]\nlattice.dims = [5, 5]\n[[layer.pin]]\nanchor = { screen = [0.6, 0.5] }\nkeys = ";

#[test]
fn pins_of_a_picture_are_found_by_their_place_if_its_triangles_are_others() {
    let wall = Wall::new();
    wall.hang(
        "square.exr",
        SIZE,
        drawn(SIZE, "", |x, y| f32::from(u8::from(x > 10.0 && x < 80.0 && y > 5.0 && y < 60.0))),
    );
    let shot = |anchors: &[String]| {
        let pins: String = anchors.iter().map(|anchor| format!("[[layer.pin]]\nanchor = {anchor}\n")).collect();
        wall.shot(&format!(
            "version = 1\nimage = 'square.exr'\n[[layer]]\nname = 'all'\nlattice = {{ dims = [6, 6] }}\n{pins}"
        ))
    };
    let places = [[0.5, 0.5], [1.1, 0.3]];
    let prepared = |anchors: &[String]| PreparedShot::new(shot(anchors)).expect("the picture is there");
    let on_screen = prepared(&places.map(|at| format!("{{ screen = {at:?}, frame = 1 }}")));
    let node = &on_screen.scene.nodes[0].name;
    let stored = |[x, y]: [f64; 2], triangle: usize| {
        format!("{{ node = '{node}', triangle = {triangle}, barycentric = [1.0, 0.0, 0.0], rest = [{x}, {y}, 0.0] }}")
    };
    let of_another = prepared(&[stored(places[0], 0), stored(places[1], 99_999)]);
    for (found, at) in of_another.rests_of(0, 1.0).iter().zip(places) {
        assert!((found.point.0 - glam::DVec2::from(at)).length() < 1e-6, "{:?} instead of {at:?}", found.point);
    }
    assert!(of_another.notes.iter().all(|note| !note.contains("exported again")), "{:?}", of_another.notes);
}

#[test]
fn where_nothing_moves_every_sample_keeps_its_bits() {
    let wall = Wall::new();
    let window = PixelRect { x: 5, y: 3, width: 70, height: 50 };
    let picture = wall.hang("girl.exr", window, drawn(window, "", disc(40.0, 30.0, 18.3)));
    for layers in ["", "[[layer]]\n", &format!("{PIN}[{{ frame = 1, offset = [0, 0] }}]\n")] {
        let (frame, _) = wall.render(wall.shot(&format!("image = \"girl.exr\"\n{layers}")));
        assert_eq!(frame.display, SIZE, "the frame is as large as the picture");
        for name in ["R", "G", "B", "A"] {
            for (x, y) in (0..64).flat_map(|y| (0..96).map(move |x| (x, y))) {
                let [found, wanted] = [&frame, &picture].map(|frame| sample(frame, name, x, y));
                assert_eq!(found.to_bits(), wanted.to_bits(), "{name} at {x}, {y}: {found}, not {wanted}; {layers}");
            }
        }
        std::fs::remove_dir_all(wall.folder.path().join("out")).expect("frames were written");
    }
}

#[test]
fn a_pin_carries_the_picture_along() {
    let wall = Wall::new();
    wall.hang("girl.exr", SIZE, drawn(SIZE, "", disc(40.0, 30.0, 18.0)));
    // A single pin of the default solver is a translation: 8 pixels to the right, 4 up.
    let keys = "[{ frame = 1, offset = [0.125, 0.0625] }]\n";
    let mut shot = wall.shot(&format!("image = \"girl.exr\"\n{PIN}{keys}"));
    shot.output.channels.push(ChannelGroup::Depth);
    let (frame, notes) = wall.render(shot);
    for (x, y, wanted) in
        [(48, 26, 1.0), (48 - 16, 26, 1.0), (48 + 16, 26, 1.0), (40 - 16, 30, 0.0), (48, 26 + 19, 0.0)]
    {
        assert!((sample(&frame, "A", x, y) - wanted).abs() < 0.02, "{x}, {y}: {}", sample(&frame, "A", x, y));
    }
    let red = sample(&frame, "R", 50, 26);
    assert!((red - (42.5 * 0.02 - 0.3)).abs() < 2e-3, "{red}");
    assert!(notes.iter().any(|note| note.contains("pictures have colour and ids only")), "{notes:?}");
}

#[test]
fn pictures_lie_in_the_order_of_the_list_and_of_their_layers() {
    let wall = Wall::new();
    wall.hang("back.exr", SIZE, drawn(SIZE, "", |_, _| 1.0));
    let mut channels = drawn(SIZE, "arm.", disc(30.0, 30.0, 12.0));
    channels.extend(drawn(SIZE, "head.", disc(40.0, 30.0, 12.0)));
    wall.hang("girl.exr", SIZE, channels);
    let text = "image = [\"back.exr\", \"girl.exr\"]\n[[layer]]\nname = \"head\"\nnodes = [\"head\"]\n";
    let prepared = PreparedShot::new(wall.shot(text)).expect("the pictures are there");
    let names: Vec<&str> = prepared.scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["back", "arm", "head", "camera"]);
    let (frame, _) = wall.render(wall.shot(text));
    let ids = |x: i32, y: i32| (sample(&frame, "id.layer", x, y), sample(&frame, "id.object", x, y));
    assert_eq!((ids(2, 2), ids(22, 30), ids(36, 30)), ((0.0, 1.0), (0.0, 2.0), (1.0, 3.0)));
    assert_eq!(sample(&frame, "A", 2, 2), 1.0);
    // Half covered by the head's rim: what lies behind shows through.
    let behind = 0.01 * 30.5;
    assert!((sample(&frame, "B", 36, 30) - behind).abs() < 1e-3);
}

/// Channels of one value everywhere.
fn flat(names: &[&str], storage: Storage) -> Vec<Channel> {
    let channel = |name: &&str| Channel { name: (*name).to_owned(), storage, samples: vec![0.25; SIZE.area()] };
    names.iter().map(channel).collect()
}

#[test]
fn of_a_render_only_the_picture_is_painted() {
    let wall = Wall::new();
    let mut channels = drawn(SIZE, "", disc(40.0, 30.0, 18.0));
    wall.hang("alone.exr", SIZE, channels.clone());
    channels.extend(flat(&["albedo.R", "albedo.G", "albedo.B", "hair.R", "hair.A"], Storage::Half));
    channels.extend(flat(&["N.X", "N.Y", "N.Z", "P.R", "P.G", "P.B", "Z"], Storage::Float));
    channels.extend(flat(&["right.R", "right.G", "right.B", "right.A"], Storage::Half));
    wall.hang("girl.exr", SIZE, channels);
    let nodes = |text: &str| {
        let prepared = PreparedShot::new(wall.shot(text)).expect("the pictures are there");
        let names: Vec<String> = prepared.scene.nodes.iter().map(|node| node.name.clone()).collect();
        (names, prepared.notes.join("\n"))
    };
    let (names, notes) = nodes("image = \"girl.exr\"\n");
    assert_eq!(names, ["girl", "camera"]);
    for told in
        ["girl.exr: albedo, hair (already contained in the picture", "N, P, Z (no colour)", "right (belong to views"]
    {
        assert!(notes.contains(told), "{told}: {notes}");
    }
    let (frame, _) = wall.render(wall.shot("image = \"girl.exr\"\n"));
    std::fs::remove_dir_all(wall.folder.path().join("out")).expect("frames were written");
    let (alone, _) = wall.render(wall.shot("image = \"alone.exr\"\n"));
    assert_eq!(frame.channel("G"), alone.channel("G"));
    // The shot knows better.
    let (names, notes) = nodes("image = \"girl.exr\"\n[[warp.channels]]\nname = \"hair.*\"\nmeaning = \"color\"\n");
    assert_eq!(names, ["girl", "hair", "camera"]);
    assert!(notes.contains(": albedo (already contained in the picture"), "{notes}");
}

#[test]
fn layers_of_names_that_passes_have_are_painted_where_there_is_no_picture_beside_them() {
    let wall = Wall::new();
    let mut channels = drawn(SIZE, "background.", |_, _| 1.0);
    channels.extend(drawn(SIZE, "girl.", disc(40.0, 30.0, 18.0)));
    channels.extend(flat(&["Z"], Storage::Float));
    wall.hang("girl.exr", SIZE, channels);
    let prepared = PreparedShot::new(wall.shot("image = \"girl.exr\"\n")).expect("the pictures are there");
    let names: Vec<&str> = prepared.scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["background", "girl", "camera"]);
}

#[test]
fn what_lies_behind_a_transparent_fold_shows() {
    let wall = Wall::new();
    wall.hang("girl.exr", SIZE, drawn(SIZE, "", |x, _| f32::from(u8::from(x < 48.0))));
    // Columns 0, 32, 64 and 96 go to 0, 64, 32 and 96: the middle turns over, and only the left half is opaque.
    let by = [0.0, 1.0 / 3.0, -1.0 / 3.0, 0.0];
    let handle = |index: usize| {
        let (column, row) = (index % 4, index / 4);
        format!(
            "[[layer.handle]]\nindex = [{column}, {row}]\nkeys = [{{ frame = 1, offset = [{}, 0.0] }}]\n",
            by[column]
        )
    };
    let lattice = "[[layer]]\nsolve = { guard = \"report\" }\nlattice = { dims = [4, 2], basis = \"bilinear\", box = \"frame\" }\n";
    let handles: String = (0..8).map(handle).collect();
    let (frame, _) = wall.render(wall.shot(&format!("image = \"girl.exr\"\n{lattice}{handles}")));
    // 40 comes from 20 (opaque), from 56 (turned over, transparent) and from 68 (transparent).
    for (x, wanted) in [(10, 1.0), (40, 1.0), (60, 1.0), (80, 0.0)] {
        assert!((sample(&frame, "A", x, 30) - wanted).abs() < 0.05, "{x}: {}", sample(&frame, "A", x, 30));
    }
}

#[test]
fn a_shutter_blurs_the_warp() {
    let wall = Wall::new();
    wall.hang("girl.exr", SIZE, drawn(SIZE, "", disc(40.0, 30.0, 14.0)));
    let keys = "[{ frame = 0, offset = [-0.2, 0.0] }, { frame = 2, offset = [0.2, 0.0] }]\n";
    let edge = |shutter: &str| {
        let text = format!("image = \"girl.exr\"\nshutter = {{ angle = {shutter} }}\nsamples = 8\n{PIN}{keys}");
        let (frame, _) = wall.render(wall.shot(&text));
        std::fs::remove_dir_all(wall.folder.path().join("out")).expect("frames were written");
        (sample(&frame, "A", 40, 30), sample(&frame, "A", 56, 30))
    };
    let (still, blurred) = (edge("0"), edge("360"));
    assert!(still.0 == 1.0 && still.1 < 0.01, "{still:?}");
    // The disc runs over 0.2 frame heights: 12.8 pixels.
    assert!((blurred.0 - 1.0).abs() < 1e-3 && blurred.1 > 0.1 && blurred.1 < 0.5, "{blurred:?}");
}

#[test]
fn pictures_are_scaled_with_the_frame() {
    let wall = Wall::new();
    wall.hang("girl.exr", SIZE, drawn(SIZE, "", disc(40.0, 30.0, 18.0)));
    let mut shot = wall.shot("image = \"girl.exr\"\n");
    let triangles = |shot: &Shot| {
        PreparedShot::new(shot.clone()).expect("a prepared shot").scene.meshes[0].primitives[0].triangles.clone()
    };
    let whole = triangles(&shot);
    shot.size = FrameSize::new(48, 32);
    assert_eq!(triangles(&shot), whole, "pins name triangles");
    let (frame, _) = wall.render(shot);
    let area: f32 = frame.channel("A").expect("alpha").samples.iter().sum();
    let wanted = std::f32::consts::PI * 9.0 * 9.0;
    assert!((area / wanted - 1.0).abs() < 0.03, "{area} of {wanted}");
}

#[test]
fn faults_say_what_to_do() {
    let wall = Wall::new();
    wall.hang("girl.exr", SIZE, drawn(SIZE, "", disc(40.0, 30.0, 18.0)));
    wall.hang("empty.exr", SIZE, drawn(SIZE, "", |_, _| 0.0));
    wall.hang(
        "depth.exr",
        SIZE,
        vec![Channel { name: "Z".into(), storage: Storage::Float, samples: vec![1.0; SIZE.area()] }],
    );
    std::fs::create_dir(wall.folder.path().join("b")).expect("a folder");
    std::fs::copy(wall.folder.path().join("girl.exr"), wall.folder.path().join("b/girl.exr")).expect("a copy");
    image::RgbaImage::from_pixel(10, 10, image::Rgba([255; 4]))
        .save(wall.folder.path().join("small.png"))
        .expect("saved");
    std::fs::write(wall.folder.path().join("torn.png"), b"no picture").expect("written");
    let cases = [
        ("image = \"empty.exr\"", "its alpha is 0 everywhere"),
        ("image = \"depth.exr\"", "has no channels R, G, B or Y"),
        ("image = [\"girl.exr\", \"small.png\"]", "canvases of one size"),
        ("image = [\"girl.exr\", \"b/girl.exr\"]", "both hold a picture 'girl'"),
        ("image = \"girl.exr\"\nsize = [100, 100]", "does not have the aspect ratio of"),
        ("image = [\"girl.exr\", \"torn.png\"]", "torn.png"),
        ("image = \"girl.exr\"\n[[layer]]\nnodes = [\"gril\"]", "did you mean \"girl\"?"),
    ];
    for (text, wanted) in cases {
        let error = wall.fault(wall.shot(text));
        assert!(error.contains(wanted), "{text}: {error}");
    }
    assert!(Path::new(wall.folder.path()).exists());
}

/// A body, and an arm beside it that hangs on at the top.
pub(crate) fn body_and_arm(x: f32, y: f32) -> f32 {
    let bar = |left: f32, right: f32, low: f32| f32::from(u8::from(x > left && x < right && y > 6.0 && y < low));
    bar(16.0, 40.0, 58.0).max(bar(50.0, 60.0, 50.0)).max(bar(16.0, 60.0, 14.0))
}

/// A shot of [`body_and_arm`] whose three pins on the body rest; the fourth, at the end of the arm, moves.
fn arm_shot(wall: &Wall, topology: &str, offset: [f64; 2], all: [f64; 2]) -> Shot {
    drawn_arm_shot(wall, body_and_arm, topology, (offset, all))
}

/// The same of another drawing.
fn drawn_arm_shot(
    wall: &Wall,
    drawing: fn(f32, f32) -> f32,
    topology: &str,
    (offset, all): ([f64; 2], [f64; 2]),
) -> Shot {
    wall.hang("arm.exr", SIZE, drawn(SIZE, "", drawing));
    let pins: Vec<String> = [(18.0, 10.0, all), (38.0, 40.0, all), (28.0, 55.0, all), (55.0, 46.0, offset)]
        .into_iter()
        .map(|(x, y, [dx, dy])| {
            format!(
                "[[layer.pin]]\nname = \"at {x}\"\nanchor = {{ screen = [{}, {}], frame = 1 }}\nkeys = [{{ frame = 1, offset = [{dx}, {dy}] }}]",
                x / 64.0,
                1.0 - y / 64.0
            )
        })
        .collect();
    let lattice = format!("{{ dims = [16, 20], topology = \"{topology}\" }}");
    wall.shot(&format!("version = 1\nimage = \"arm.exr\"\n[[layer]]\nlattice = {lattice}\n{}", pins.join("\n")))
}

#[test]
fn branches_of_a_picture_move_apart() {
    // The arm swings out; pixels of the body, the arm's root apart, in which coverage changes.
    let changed = |topology: &str| {
        let wall = Wall::new();
        let (frame, _) = wall.render(arm_shot(&wall, topology, [18.0 / 64.0, 6.0 / 64.0], [0.0; 2]));
        let pixels = (24..60).flat_map(|y| (12..44).map(move |x| (x, y)));
        let differs =
            |&(x, y): &(i32, i32)| (at(&frame, "A", x, y) - body_and_arm(x as f32 + 0.5, y as f32 + 0.5)).abs() > 0.25;
        assert!(at(&frame, "A", 73, 40) > 0.9, "{topology}: the hand is where its pin is");
        pixels.filter(differs).count()
    };
    let [plain, branching] = ["plain", "branching"].map(changed);
    println!("pixels of the body that change: plain {plain}, branching {branching}");
    assert!(branching < 20 && plain > 3 * branching, "plain {plain}, branching {branching}");
}

#[test]
fn branches_leave_no_seams() {
    let wall = Wall::new();
    let by = [8.0 / 64.0, 0.0];
    let (frame, _) = wall.render(arm_shot(&wall, "branching", by, by));
    for (x, y) in (0..64).flat_map(|y| (8..90).map(move |x| (x, y))) {
        let inner = |dx: f32, dy: f32| body_and_arm(x as f32 - 7.5 + dx, y as f32 + 0.5 + dy);
        if [(0.0, 0.0), (2.0, 2.0), (-2.0, 2.0), (2.0, -2.0), (-2.0, -2.0)].iter().all(|&(dx, dy)| inner(dx, dy) == 1.0)
        {
            let found = at(&frame, "A", x, y);
            assert!((found - 1.0).abs() < 0.01, "{x}, {y}: {found}");
        }
    }
}

/// Parts overlap along their seams by a rim. Soft pixels of the rim are drawn once.
#[test]
fn branches_keep_soft_edges() {
    let soft = |x: f32, y: f32| {
        let steps = [-1.5, -0.5, 0.5, 1.5];
        steps.iter().flat_map(|dx| steps.map(|dy| body_and_arm(x + dx, y + dy) / 16.0)).sum()
    };
    let wall = Wall::new();
    let by = [8.0 / 64.0, 0.0];
    let (frame, _) = wall.render(drawn_arm_shot(&wall, soft, "branching", (by, by)));
    let pixels = (0..64).flat_map(|y| (8..90).map(move |x| (x, y)));
    let difference = |(x, y): (i32, i32)| (at(&frame, "A", x, y) - soft(x as f32 - 7.5, y as f32 + 0.5)).abs();
    let greatest = pixels.map(difference).fold(0.0, f32::max);
    println!("greatest difference of coverage {greatest:.4}");
    assert!(greatest < 0.005, "{greatest}");
}

/// A hip with two legs whose feet pass each other, and what the frame with them warns of.
fn warnings_of_crossed_legs(topology: &str) -> Vec<String> {
    let legs = |x: f32, y: f32| {
        let is_hip = (28.0..68.0).contains(&x) && (8.0..18.0).contains(&y);
        let is_leg = (18.0..58.0).contains(&y) && ((28.0..37.0).contains(&x) || (59.0..68.0).contains(&x));
        f32::from(u8::from(is_hip || is_leg))
    };
    let wall = Wall::new();
    wall.hang("legs.exr", SIZE, drawn(SIZE, "", legs));
    let pins = [(32.0, 13.0, 0.0), (64.0, 13.0, 0.0), (32.5, 55.0, 27.0), (63.5, 55.0, -27.0)].map(|(x, y, dx)| {
        let (at, offset) = ([x / 64.0, 1.0 - y / 64.0], [dx / 64.0, 0.0]);
        format!(
            "[[layer.pin]]\nanchor = {{ screen = {at:?}, frame = 1 }}\nkeys = [{{ frame = 1, offset = {offset:?} }}]\n"
        )
    });
    let text = format!(
        "version = 1\nimage = \"legs.exr\"\n[[layer]]\nlattice = {{ dims = [24, 24], topology = \"{topology}\" }}\n\
         solve = {{ guard = \"report\" }}\n{}",
        pins.concat()
    );
    let prepared = PreparedShot::new(wall.shot(&text)).expect("the picture is there");
    let found = Mutex::new(Vec::new());
    let keep = |event: Event| {
        if let Event::FrameDone(report) = event {
            found.lock().expect("nobody panics").extend(report.warnings);
        }
    };
    let options = RenderOptions { frames: vec![1], ..RenderOptions::default() };
    render(&prepared, &options, &AtomicBool::new(false), &keep).expect("it renders");
    found.into_inner().expect("nobody panics")
}

#[test]
fn legs_that_cross_are_not_told_as_a_fold() {
    let is_of_picture = |warning: &String| warning.contains("the picture overlaps itself");
    let [branching, plain] = ["branching", "plain"].map(warnings_of_crossed_legs);
    assert!(!branching.iter().any(is_of_picture), "{branching:?}");
    assert!(plain.iter().any(is_of_picture), "{plain:?}");
}

/// Islands that are too small to be a part of the shape are moved with the nearest part.
#[test]
fn small_islands_are_drawn() {
    // Dots beside a body, and dots alone.
    let dots = |x: f32, y: f32| f32::from(u8::from(x.rem_euclid(5.0) < 1.6 && y.rem_euclid(5.0) < 1.6));
    let body = |x: f32, y: f32| f32::from(u8::from(x < 40.0 && y > 20.0 && y < 50.0));
    let both = |x: f32, y: f32| dots(x, y).max(body(x, y));
    for (name, drawing) in [("body", &both as &dyn Fn(f32, f32) -> f32), ("dots", &dots)] {
        let wall = Wall::new();
        wall.hang("dots.exr", SIZE, drawn(SIZE, "", drawing));
        let pins = [(12.0, 32.0), (32.0, 32.0), (37.0, 47.0)].map(|(x, y)| {
            let at = [(x - 1.0) / 64.0, 1.0 - (y - 1.0) / 64.0];
            format!("[[layer.pin]]\nanchor = {{ screen = {at:?}, frame = 1 }}\nkeys = [{{ frame = 1, offset = [0.0625, 0] }}]\n")
        });
        let text =
            "version = 1\nimage = \"dots.exr\"\n[[layer]]\nlattice = { dims = [12, 12], topology = \"branching\" }\n";
        let (frame, _) = wall.render(wall.shot(&format!("{text}{}", pins.concat())));
        let covered = |from: i32, alpha: &dyn Fn(i32, i32) -> f32| -> f32 {
            (0..64).flat_map(|y| (from..from + 92).map(move |x| (x, y))).map(|(x, y)| alpha(x, y)).sum()
        };
        let wanted = covered(0, &|x, y| drawing(x as f32 + 0.5, y as f32 + 0.5));
        let found = covered(4, &|x, y| sample(&frame, "A", x, y));
        println!("{name}: coverage {found} of {wanted}");
        assert!((found - wanted).abs() < 0.01 * wanted, "{name}: {found} of {wanted}");
    }
}

/// An arm that is laid over the body, or behind it, as its pin's order says.
#[test]
fn the_order_of_pins_says_which_part_is_in_front() {
    let red = |x: f32| x * 0.02 - 0.3;
    let text_of = |wall: &Wall, order: &str| {
        wall.hang("arm.exr", SIZE, drawn(SIZE, "", body_and_arm));
        let pins = [(18.0, 10.0, 0.0), (38.0, 40.0, 0.0), (28.0, 55.0, 0.0), (55.0, 46.0, -25.0)].map(|(x, y, dx)| {
            let order = if dx == 0.0 { "" } else { order };
            format!(
                "[[layer.pin]]\nanchor = {{ screen = [{}, {}], frame = 1 }}\n{order}\nkeys = [{{ frame = 1, offset = [{}, 0] }}]\n",
                x / 64.0,
                1.0 - y / 64.0,
                dx / 64.0
            )
        });
        let lattice = "{ dims = [16, 20], topology = \"branching\" }";
        format!("version = 1\nimage = \"arm.exr\"\n[[layer]]\nlattice = {lattice}\n{}", pins.concat())
    };
    // What is seen where the hand now is, and how far it is from the colours of body and arm.
    let seen = |order: &str| {
        let wall = Wall::new();
        let (frame, _) = wall.render(wall.shot(&text_of(&wall, order)));
        let found = at(&frame, "R", 30, 45);
        [30.5, 55.5].map(|x| (found - red(x)).abs())
    };
    let behind = seen("order = -1");
    let [in_front, keyed] = ["order = 1", "order = [{ frame = 1, value = 2 }, { frame = 2, value = -1 }]"].map(seen);
    println!("behind {behind:?}, in front {in_front:?}, keyed {keyed:?}");
    assert!(behind[0] < 0.02 && behind[1] > 0.3, "{behind:?}");
    assert!([in_front, keyed].iter().all(|seen| seen[1] < 0.08 && seen[0] > 0.3), "{in_front:?} {keyed:?}");
    // Lattice files list branches from back to front.
    let owner_in_front = |order: &str, frame: i32| {
        let wall = Wall::new();
        let prepared = PreparedShot::new(wall.shot(&text_of(&wall, order))).expect("the pictures are there");
        let file = pinwarp::pipeline::lattices(&prepared, &[frame], |_| ()).expect("solvable");
        let branches = &file.layers[0].branches[&frame];
        let hand = [55.0 / 64.0, 1.0 - 46.0 / 64.0];
        let holds = |branch: usize| {
            branches.polygons(branch).any(|polygon| {
                let range = |axis: usize| {
                    let values = || polygon.iter().map(|corner| corner[axis]);
                    [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
                };
                (0..2).all(|axis| (range(axis)[0]..=range(axis)[1]).contains(&hand[axis]))
            })
        };
        let count = branches.list.len();
        ((0..count).position(holds).expect("some branch has the hand"), count)
    };
    let (place, _) = owner_in_front("order = -1", 1);
    let (last, count) = owner_in_front("order = 1", 1);
    assert!(place == 0 && last + 1 == count, "{place}, {last} of {count}");
    assert_eq!(owner_in_front("order = [{ frame = 1, value = 2 }, { frame = 2, value = -1 }]", 2).0, 0);
}

#[test]
fn comparisons_are_plain_and_several_pictures_in_a_branching_layer_are_refused() {
    let wall = Wall::new();
    let prepared =
        PreparedShot::new(arm_shot(&wall, "branching", [0.1, 0.0], [0.0; 2])).expect("the pictures are there");
    let problem =
        pinwarp::pipeline::layer_problem(&prepared, 0, 1.0).expect("a plain problem").expect("a solved layer");
    assert_eq!(problem.problem().settings.topology, Topology::Plain, "other methods know no branches");
    wall.hang("two.exr", SIZE, drawn(SIZE, "", disc(70.0, 40.0, 9.0)));
    let both = "version = 1\nimage = [\"arm.exr\", \"two.exr\"]\n[[layer]]\nlattice.topology = \"branching\"";
    let told = wall.fault(wall.shot(both));
    assert!(told.contains("a layer of its own"), "{told}");
    // Unless the shot asks for branches, several pictures get a plain lattice.
    let open = wall.shot(&both.replace("lattice.topology = \"branching\"", ""));
    assert_eq!(open.layers[0].settings.topology, Topology::Branching);
    let prepared = PreparedShot::new(open).expect("two pictures in one layer");
    assert_eq!(prepared.shot.layers[0].settings.topology, Topology::Plain);
    // What acts on branches alone is not ignored there.
    let plain = both.replace("lattice.topology = \"branching\"", "");
    let order = format!("{plain}[[layer.pin]]\nanchor = {{ screen = [0.5, 0.5] }}\norder = 1\n");
    let cut = format!("{plain}lattice.cuts = [[[0.5, 0.0], [0.5, 1.0]]]\n");
    for (text, key) in [(order, "layer[0].pin[0].order"), (cut, "layer[0].lattice.cuts")] {
        let told = wall.fault(wall.shot(&text));
        assert!(told.contains(key) && told.contains("it has several pictures"), "{told}");
    }
    // The same holds for edits of a shot that is open: a pin with an order, and an order for a pin.
    let pin = "[[layer.pin]]\nanchor = { screen = [0.5, 0.5] }\n";
    let mut open = OpenShot::new(wall.shot(&plain)).expect("two pictures in one layer");
    for before in [plain.clone(), format!("{plain}{pin}")] {
        open.edit(wall.shot(&before)).expect("no order yet");
        let told = open.edit(wall.shot(&format!("{plain}{pin}order = 1\n"))).expect_err("as in a render").to_string();
        assert!(told.contains("layer[0].pin[0].order") && told.contains("it has several pictures"), "{told}");
        assert_eq!(open.prepared().shot.layers[0].pins.len(), before.matches("anchor").count(), "nothing changed");
    }
}

#[test]
fn an_order_that_says_nothing_is_told() {
    let wall = Wall::new();
    wall.hang("disc.exr", SIZE, drawn(SIZE, "", disc(48.0, 32.0, 20.0)));
    let text = "version = 1\nimage = \"disc.exr\"\n[[layer]]\nname = \"disc\"\n\
                lattice = { dims = [5, 5], topology = \"branching\" }\n\
                [[layer.pin]]\nanchor = { screen = [0.75, 0.5], frame = 1 }\norder = 1\n";
    let warnings = |text: &str| {
        let prepared = PreparedShot::new(wall.shot(text)).expect("the picture is there");
        let sample = prepared.sample_at(1.0).expect("solvable");
        pinwarp::pipeline::report(&prepared, 1, &sample).warnings
    };
    let is_told = |told: &String| told.contains("layer 'disc'") && told.contains("moves as one part");
    assert!(warnings(text).iter().any(is_told), "{:?}", warnings(text));
    assert!(!warnings(&text.replace("order = 1\n", "")).iter().any(is_told));
}

#[test]
fn pins_hold_the_border_of_a_picture_however_it_is_rounded() {
    let wall = Wall::new();
    wall.hang("full.exr", SIZE, drawn(SIZE, "", |_, _| 1.0));
    let shot = |x: f64| {
        wall.shot(&format!(
            "version = 1\nimage = \"full.exr\"\n[[layer]]\n[[layer.pin]]\nanchor = {{ screen = [{x}, 0.5], frame = 1 }}"
        ))
    };
    for x in [0.0, 1.5, 1.500_001, -1e-7] {
        PreparedShot::new(shot(x)).unwrap_or_else(|error| panic!("{x}: {error}"));
    }
    assert!(wall.fault(shot(1.53)).contains("no surface"), "two pixels beyond");
}
