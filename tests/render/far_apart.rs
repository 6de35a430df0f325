//! Automatic dims of pictures with parts that wind inside the reach of one handle.

use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::Shot;
use std::path::Path;

/// A column or row of a drawing: left, top, right, bottom, in pixels.
type Bar = [u32; 4];

/// Prepares a picture of 540 x 500 pixels that is drawn of bars.
fn prepared(folder: &Path, bars: &[Bar], layer: &str) -> PreparedShot {
    let is_drawn = |x: u32, y: u32| {
        bars.iter().any(|&[left, top, right, bottom]| (left..right).contains(&x) && (top..bottom).contains(&y))
    };
    let pixel = |x, y| image::Rgba([200, 80, 40, 255 * u8::from(is_drawn(x, y))]);
    image::RgbaImage::from_fn(540, 500, pixel).save(folder.join("drawn.png")).expect("a temporary folder");
    let frames = "frames = { first = 1, last = 2, rate = 24 }";
    let text = format!("version = 1\nimage = \"drawn.png\"\n{frames}\n[[layer]]\nname = \"drawn\"\n{layer}\n");
    PreparedShot::new(Shot::parse(&text, &folder.join("shot.toml")).expect("a right shot"))
        .expect("the picture is there")
}

/// A comb whose teeth are 40 pixels wide.
fn comb() -> Vec<Bar> {
    let teeth = (0..6).map(|k| [20 + 80 * k, 60, 60 + 80 * k, 300]);
    std::iter::once([20, 20, 460, 60]).chain(teeth).collect()
}

/// A thread that winds up and down, of columns of this width and height, a pitch apart.
fn thread([left, top]: [u32; 2], [width, height, pitch]: [u32; 3], count: u32) -> Vec<Bar> {
    let columns = (0..count).map(|k| [left + pitch * k, top, left + pitch * k + width, top + height]);
    let turns = (0..count - 1).map(|k| {
        let from = if k.is_multiple_of(2) { top + height - width } else { top };
        [left + pitch * k, from, left + pitch * (k + 1) + width, from + width]
    });
    columns.chain(turns).collect()
}

fn dims(prepared: &PreparedShot) -> [usize; 2] {
    let [across, up, _] = prepared.shot.layers[0].space.dims();
    [across, up]
}

#[test]
fn a_lattice_is_refined_until_no_handle_holds_together_what_winds() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Too short to count as the thickness of the drawing.
    let bars = [comb(), vec![[460, 34, 470, 40]], thread([468, 34], [6, 50, 10], 5)].concat();
    let layer = |topology: &str| {
        format!("lattice = {{ dims = \"auto\", topology = \"{topology}\" }}\nsolve = {{ guard = \"report\" }}")
    };
    let [winding, plain] = ["branching", "plain"].map(|topology| prepared(folder.path(), &bars, &layer(topology)));
    let alone = prepared(folder.path(), &comb(), &layer("branching"));
    let (refined, coarse) = (dims(&winding), dims(&plain));
    println!("{refined:?}, plain {coarse:?}, without the thread {:?}", dims(&alone));
    assert!(refined[0] > coarse[0] && refined[1] > coarse[1], "{refined:?} {coarse:?}");
    let notes =
        |prepared: &PreparedShot, words: &str| prepared.notes.iter().filter(|note| note.contains(words)).count();
    assert_eq!((notes(&winding, "lies far apart along the drawing"), notes(&winding, "cuts")), (1, 0));
    for other in [plain, alone] {
        assert_eq!((notes(&other, "for its thinnest parts"), notes(&other, "far apart")), (1, 0), "{:?}", other.notes);
    }
}

#[test]
fn what_the_finest_lattice_holds_together_is_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bars = [vec![[20, 20, 60, 460]], thread([58, 116], [4, 25, 7], 56)].concat();
    let found = prepared(folder.path(), &bars, "lattice = { dims = \"auto\" }");
    assert_eq!(dims(&found), [64; 2]);
    let told: Vec<&String> = found.notes.iter().filter(|note| note.contains("far apart along the drawing")).collect();
    let words = ["layer 'drawn'", "handles move points together", "such as [", "cuts"];
    assert!(matches!(told[..], [note] if words.iter().all(|word| note.contains(word))), "{:?}", found.notes);
}
