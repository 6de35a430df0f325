//! Files that the editor did not make: models of others, pictures, plates, lattices in the scene, broken shots.

use super::assets;
use super::seen::texts;
use super::stage::{SHOT, Stage, TIMEOUT, at, place_pin, press, until};
use super::window::window;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use pinwarp::edit::{Document, MatteChoice, Quality, Session, open};
use pinwarp::image::cryptomatte::{Manifest, MatteId};
use pinwarp::image::{Channel, Plate, PlatePart, Preview, Storage, preview, write_plate, write_png};
use pinwarp::pipeline::{Draft, PreparedShot};
use pinwarp::raster::DeviceChoice;
use pinwarp::raster::geometry::KeptParts;
use pinwarp::scene::FileAccess;
use pinwarp::shot::Shot;
use pinwarp::space::FrameSize;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};
use toml_edit::{Array, DocumentMut};

fn opened(path: &Path) -> Session {
    let document = open(path, FileAccess::SceneFolder).expect("it opens");
    let mut session = Session::new(document, DeviceChoice::Cpu, || ());
    assert!(session.settle(TIMEOUT), "{}: {:?}", path.display(), session.fault());
    session
}

/// Places a pin, drags and keys it, undoes it all, does it again, saves, and opens what is saved.
fn is_edited(session: &mut Session, on: [f64; 2]) {
    let untouched = session.document().text().to_owned();
    place_pin(session, at(on[0], on[1]));
    let [layer, pin] = session.selection.single_pin().expect("the new pin is chosen");
    let last = session.playhead.shot_range()[1].min(session.playhead.frame() + 3);
    session.go(last);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let marks = session.marks().iter().find(|marks| marks.layer == layer).expect("it is warped").clone();
    let from = marks.pins.iter().find(|mark| mark.pin == pin).expect("it is seen").target.0;
    press(session, at(from.x, from.y));
    session.motion(at(from.x + 0.04, from.y + 0.05));
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert_eq!(session.document().shot().layers[layer].pins[pin].keys.len(), 2);
    assert_eq!(session.picture().map(|picture| picture.quality), Some(Quality::Final));
    let edited = session.document().text().to_owned();
    session.undo();
    session.undo();
    assert_eq!(session.document().text(), untouched);
    session.redo();
    session.redo();
    session.save().expect("writable");
    let path = session.document().path().to_owned();
    assert_eq!(fs::read_to_string(&path).expect("saved"), edited);
    let again = Document::open(&path).expect("what is saved opens");
    assert_eq!(again.shot(), session.document().shot());
    for line in untouched.lines().filter(|line| line.contains('#')) {
        assert!(edited.contains(line), "the comment is lost: {line}");
    }
}

/// A shot of a model that the editor writes, with a small picture and few frames.
fn small(shot: &str) -> String {
    let mut shot: DocumentMut = shot.parse().expect("TOML");
    shot["size"] = [192, 108].into_iter().collect::<Array>().into();
    if let Some(frames) = shot.get_mut("frames") {
        frames["last"] = 4.into();
    }
    shot["solve_range"] = [1, 4].into_iter().collect::<Array>().into();
    shot.to_string()
}

#[test]
fn models_of_others_are_edited() {
    // Places where something is seen in the first frame, in parts of the frame's width and height.
    for (file, [x, y]) in [
        ("kaykit/Knight.glb", [0.505, 0.33]),
        ("gltf-samples/Fox.glb", [0.52, 0.55]),
        ("gltf-samples/BoxVertexColors.glb", [0.5, 0.5]),
    ] {
        let Some(path) = assets::asset(file) else { continue };
        let folder = tempfile::tempdir().expect("a folder");
        let own = folder.path().join(path.file_name().expect("a file"));
        fs::copy(&path, &own).expect("copied");
        let document = open(&own, FileAccess::SceneFolder).expect("it opens");
        let path = own.with_extension("toml");
        fs::write(&path, small(document.text())).expect("written");
        let mut session = opened(&path);
        let aspect = session.shot().size.aspect();
        is_edited(&mut session, [x * aspect, y]);
    }
}

#[test]
fn files_outside_the_folder_of_a_scene_are_read_if_they_are_allowed() {
    let stage = Stage::new();
    let root = stage.folder.path();
    let mut json: Value =
        serde_json::from_slice(&fs::read(root.join("cards.gltf")).expect("there")).expect("it is JSON");
    let uri = std::mem::replace(&mut json["buffers"][0]["uri"], "../cards.bin".into());
    let (_, data) = uri.as_str().and_then(|uri| uri.split_once(',')).expect("its bytes");
    fs::write(root.join("cards.bin"), STANDARD.decode(data).expect("base64")).expect("written");
    let scene = root.join("inner/far.gltf");
    fs::create_dir(root.join("inner")).expect("made");
    fs::write(&scene, json.to_string()).expect("written");
    assert!(open(&scene, FileAccess::SceneFolder).is_err());
    let text = open(&scene, FileAccess::Anywhere).expect("it opens").text().replace("1920, 1080", "96, 54");
    fs::write(scene.with_extension("toml"), text).expect("written");
    let document = open(&scene, FileAccess::Anywhere).expect("its shot opens");
    let mut session = Session::new(document, DeviceChoice::Cpu, || ());
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert!(session.document().shot().allow_outside);
}

#[test]
fn files_beside_a_scene_are_watched_where_a_broken_edit_is_saved_elsewhere() {
    let stage = Stage::new();
    let root = stage.folder.path();
    let scene = fs::read_to_string(root.join("cards.gltf")).expect("there");
    let mut json: Value = serde_json::from_str(&scene).expect("JSON");
    let uri = std::mem::replace(&mut json["buffers"][0]["uri"], "cards.bin".into());
    let data = uri.as_str().and_then(|uri| uri.split_once(',')).expect("a data URI").1;
    fs::write(root.join("cards.bin"), STANDARD.decode(data).expect("base64")).expect("written");
    fs::write(root.join("cards.gltf"), json.to_string()).expect("written");
    fs::create_dir(root.join("below")).expect("made");
    let mut session = stage.session();
    session.set_nodes(vec!["Nobody".into()]);
    until(&mut session, "the edit cannot be drawn", |session| session.fault().is_some());
    session.save_as(&root.join("below/shot.toml")).expect("writable");
    until(&mut session, "it cannot be drawn there, either", |session| session.fault().is_some());
    let later = SystemTime::now() + Duration::from_secs(10);
    let file = fs::File::options().write(true).open(root.join("cards.bin")).expect("there");
    file.set_modified(later).expect("dated");
    until(&mut session, "it is read again", |session| {
        session.message().is_some_and(|told| told.contains("The scene changed on disk"))
    });
}

/// A picture with colours that tell where a pixel was.
fn chequered(width: u32, height: u32) -> Preview {
    let mut picture = Preview::transparent(width, height);
    for (index, pixel) in picture.rgba.chunks_exact_mut(4).enumerate() {
        let [x, y] = [index % width as usize, index / width as usize];
        let [red, green] = [192 * x / width as usize, 216 * y / height as usize];
        pixel.copy_from_slice(&[red as u8, green as u8, if (x / 8 + y / 8) % 2 == 0 { 200 } else { 20 }, 255]);
    }
    picture
}

/// The pixels of a draft of frame 1.
fn draft(prepared: &PreparedShot, [width, height]: [u32; 2]) -> Vec<u8> {
    let sample = prepared.provisional(1).expect("solved");
    let draft = Draft { sample: &sample, kept: &KeptParts::default(), size: FrameSize::new(width, height) };
    let frame = prepared.draft(None, draft, &|| false).expect("drawn").expect("not cancelled");
    let drawn = preview(&frame);
    assert_eq!((drawn.width, drawn.height), (width, height));
    drawn.rgba
}

/// Checks that a draft of half the size shows the same as one of 192 x 108 pixels, and is warped.
fn assert_half_shows_the_same(prepared: &PreparedShot) {
    let (full, half) = (draft(prepared, [192, 108]), draft(prepared, [96, 54]));
    let [mut count, mut sum] = [0.0; 2];
    for (index, small) in half.chunks_exact(4).enumerate() {
        let [x, y] = [2 * (index % 96), 2 * (index / 96)];
        let large = |channel: usize| [0, 1, 192, 193].map(|step| f64::from(full[4 * (192 * y + x + step) + channel]));
        if small[3] == 255 && large(3) == [255.0; 4] {
            count += 1.0;
            let difference = |k: usize| (f64::from(small[k]) - large(k).iter().sum::<f64>() / 4.0).abs();
            sum += (0..3).map(difference).sum::<f64>() / 3.0;
        }
    }
    assert!(count > 0.8 * 96.0 * 54.0 && sum / count < 4.0, "{count} pixels differ by {:.2} on average", sum / count);
    assert!(half != chequered(96, 54).rgba, "it is warped");
    assert_eq!(half, draft(prepared, [96, 54]), "what is kept of the size is the same");
}

/// A lattice that bends what it holds.
const BENT: &str = "frames = { first = 1, last = 1 }\n[[layer]]\nname = 'all'\n\
                    lattice = { dims = [6, 6], topology = 'plain' }\n\
                    [[layer.pin]]\nname = 'a'\nanchor = { screen = [0.4, 0.5], frame = 1 }\n\
                    [[layer.pin]]\nname = 'b'\nanchor = { screen = [1.3, 0.5], frame = 1 }\n\
                    keys = [{ frame = 1, offset = [-0.1, 0.1] }]\n";

/// Drags of large drawings would be slow otherwise.
#[test]
fn a_draft_of_a_drawing_is_as_small_as_wanted_and_shows_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    write_png(&folder.path().join("drawing.png"), &chequered(192, 108)).expect("written");
    let shot = Shot::parse(&format!("image = 'drawing.png'\n{BENT}"), &folder.path().join("shot.toml"));
    assert_half_shows_the_same(&PreparedShot::new(shot.expect("a shot")).expect("it loads"));
}

/// Plates are decoded once for a drag, and again when their file changes.
#[test]
fn a_draft_of_a_plate_is_as_small_as_wanted_and_shows_the_file_as_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let plate = folder.path().join("plate.png");
    write_png(&plate, &chequered(192, 108)).expect("written");
    let text = format!("plate = 'plate.png'\nsize = [192, 108]\n{BENT}");
    let shot = Shot::parse(&text, &folder.path().join("shot.toml")).expect("a shot");
    let prepared = PreparedShot::new(shot).expect("it loads");
    assert_half_shows_the_same(&prepared);
    let mut black = Preview::transparent(192, 108);
    black.rgba.as_chunks_mut::<4>().0.fill([0, 0, 0, 255]);
    write_png(&plate, &black).expect("written");
    assert_eq!(draft(&prepared, [96, 54]), [0, 0, 0, 255].repeat(96 * 54));
}

/// A plate of the chequered picture whose middle is chosen by a painted mask and by a Cryptomatte, and the left of it by an id.
fn matted_plate() -> Plate {
    let (size, picture) = (FrameSize::new(192, 108), chequered(192, 108));
    let channel = |name: &str, storage: Storage, sample: &dyn Fn(usize) -> f32| Channel {
        name: name.into(),
        storage,
        samples: (0..size.window().area()).map(sample).collect(),
    };
    let is_middle = |place: usize| (50..150).contains(&(place % 192)) && (20..90).contains(&(place / 192));
    let of_middle = |place: usize, value: f32| if is_middle(place) { value } else { 0.0 };
    let mut channels: Vec<Channel> = ["R", "G", "B", "A"]
        .into_iter()
        .enumerate()
        .map(|(k, name)| channel(name, Storage::Half, &|place| f32::from(picture.rgba[4 * place + k]) / 255.0))
        .collect();
    channels.push(channel("mask.Y", Storage::Half, &|place| of_middle(place, 1.0)));
    let id = |place: usize| if is_middle(place) && place % 192 < 120 { 3 } else { 0 };
    channels.push(channel("id.object", Storage::Uint, &|place| f32::from_bits(id(place))));
    let body = MatteId::of_name("Body").sample();
    channels.push(channel("CryptoObject00.R", Storage::Float, &|place| of_middle(place, body)));
    channels.push(channel("CryptoObject00.G", Storage::Float, &|place| of_middle(place, 1.0)));
    let mut part = PlatePart::new(size.window(), channels);
    part.set_text("cryptomatte/7654321/name", "CryptoObject");
    part.set_text("cryptomatte/7654321/manifest", &Manifest::of_names(["Body"]).to_json());
    Plate::new(size.window(), 1.0, vec![part])
}

/// Each kind of matte: the draft is as small as wanted, the same in each size, and moves what the rendered frame moves.
#[test]
fn a_draft_of_a_plate_with_mattes_is_as_small_as_wanted_and_moves_what_they_choose() {
    let folder = tempfile::tempdir().expect("a folder");
    write_plate(&folder.path().join("plate.exr"), &matted_plate()).expect("written");
    let shot = |matte: &str| {
        let layer = BENT.replacen("name = 'all'", &format!("name = 'all'\nmatte = {matte}"), 1);
        let text = format!("plate = 'plate.exr'\nsize = [192, 108]\n{layer}");
        Shot::parse(&text, &folder.path().join("shot.toml")).expect("a shot")
    };
    let mut prepared = PreparedShot::new(shot("'none'")).expect("it loads");
    for matte in ["channel = 'mask.Y'", "id = 'id.object', values = [3]", "cryptomatte = ['Body']"] {
        // What is kept of the plate must be that of this matte.
        prepared.shot = shot(&format!("{{ {matte} }}"));
        assert_half_shows_the_same(&prepared);
        let finished = prepared.finished(None, 1, &|| false).expect("drawn").expect("not cancelled");
        let (finished, full) = (preview(&finished).rgba, draft(&prepared, [192, 108]));
        let most = finished.iter().zip(&full).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(1), "{matte}: {most:?}");
        assert!(finished.chunks_exact(4).any(|pixel| pixel[3] == 0), "{matte}: the rest stays");
    }
}

#[test]
fn the_start_page_names_all_that_may_be_dropped() {
    let folder = tempfile::tempdir().expect("a folder");
    let start = window(folder.path(), None);
    for words in [".glb", ".gltf", "picture", "plates", ".exr", ".png", ".jpg", ".toml", ".json"] {
        let is_there = texts(&start).iter().any(|text| text.starts_with("or drop") && text.contains(words));
        assert!(is_there, "{words}: {:?}", texts(&start));
    }
}

#[test]
fn a_picture_and_plates_are_edited() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = chequered(96, 54);
    let drawing = folder.path().join("drawing.png");
    write_png(&drawing, &picture).expect("written");
    is_edited(&mut opened(&drawing), [0.9, 0.5]);
    for frame in 11..=14 {
        write_png(&folder.path().join(format!("plate.{frame:04}.png")), &picture).expect("written");
    }
    let mut session = opened(&folder.path().join("plate.####.png"));
    assert_eq!(session.playhead.shot_range(), [11, 14]);
    is_edited(&mut session, [0.9, 0.5]);
    for (matte, text) in [
        (MatteChoice::Alpha, "matte = \"alpha\""),
        (MatteChoice::Channel("A".into()), "matte = { channel = \"A\" }"),
        (MatteChoice::Picture, "matte = \"none\""),
    ] {
        session.set_matte(&matte);
        assert!(session.document().text().contains(text), "{}", session.document().text());
        assert_eq!(MatteChoice::of(&session.document().shot().layers[0]), Some(matte));
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    }
    session.set_matte(&MatteChoice::Cryptomatte(vec!["Body*".into()]));
    assert!(!session.settle(TIMEOUT), "the plate has no Cryptomatte");
    assert!(session.fault().is_some_and(|text| text.to_lowercase().contains("cryptomatte")), "{:?}", session.fault());
    session.undo();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

#[test]
fn a_plate_that_another_program_writes_is_drawn_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |frame: i32, grey: u8| {
        let mut picture = Preview::transparent(96, 54);
        picture.rgba.chunks_exact_mut(4).for_each(|pixel| pixel.copy_from_slice(&[grey, grey, grey, 255]));
        write_png(&folder.path().join(format!("plate.{frame:04}.png")), &picture).expect("written");
    };
    (1..=3).for_each(|frame| write(frame, 40));
    let mut session = opened(&folder.path().join("plate.####.png"));
    until(&mut session, "all frames are drawn", Session::is_idle);
    let grey = |session: &Session| session.picture().map(|picture| (picture.frame, picture.rgba[0]));
    assert!(grey(&session).is_some_and(|(frame, grey)| frame == 1 && grey < 100), "{:?}", grey(&session));
    // Files written within the resolution of modification times are told apart.
    std::thread::sleep(std::time::Duration::from_millis(50));
    write(1, 200);
    until(&mut session, "the new plate is seen", |session| grey(session).is_some_and(|(_, grey)| grey > 150));
    assert!(session.message().is_some_and(|told| told.contains("plates changed")), "{:?}", session.message());
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

#[test]
fn a_lattice_in_the_scene_is_edited_beside_one_of_the_screen() {
    let stage = Stage::new();
    let text =
        SHOT.replacen("lattice = { dims = [6, 6] }   #", "lattice = { space = \"world\", dims = [4, 4, 4] }   #", 1);
    fs::write(stage.shot(), text).expect("written");
    let mut session = stage.session();
    is_edited(&mut session, [0.4, 0.5]);
    session.set_dims(&[8, 8]);
    assert!(session.message().is_some_and(|text| text.contains("three dims")), "{:?}", session.message());
    is_edited(&mut session, [1.25, 0.5]);
}

#[test]
fn a_problem_becomes_a_shot_with_its_poses_as_keys() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = folder.path().join("frog.json");
    fs::copy(root.join("scenes/figures/frog.json"), &own).expect("copied");
    let document = open(&own, FileAccess::SceneFolder).expect("it opens");
    let path = own.with_extension("toml");
    fs::write(&path, document.text().replace("[1920, 1080]", "[192, 108]")).expect("written");
    let mut session = opened(&path);
    let pins = &session.document().shot().layers[0].pins;
    assert!(pins.len() > 2 && pins.iter().any(|pin| pin.keys.len() > 1), "{pins:?}");
    assert!(session.picture().expect("drawn").rgba.chunks_exact(4).any(|pixel| pixel[3] == 255), "something is seen");
    session.go(13);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let far = |session: &Session| {
        let marks = session.marks()[0].pins.iter();
        marks.map(|mark| (mark.target - mark.rest).0.length()).fold(0.0, f64::max)
    };
    assert!(far(&session) > 0.02, "{}", far(&session));
    // In space, too; and other files are told apart.
    let space = folder.path().join("space.json");
    fs::copy(root.join("tests/fuzz/sound/problem_3d.json"), &space).expect("copied");
    let document = open(&space, FileAccess::SceneFolder).expect("it opens");
    assert!(document.text().contains("space = \"world\""), "{}", document.text());
    let lattice = folder.path().join("lattice.json");
    fs::copy(root.join("tests/fuzz/sound/lattice.json"), &lattice).expect("copied");
    let error = open(&lattice, FileAccess::SceneFolder).map(|_| ()).expect_err("no problem");
    assert!(error.to_string().contains("not a problem file"), "{error}");
}

#[test]
fn a_problem_keeps_its_weights_and_its_number_of_iterations() {
    let folder = tempfile::tempdir().expect("a folder");
    let frog = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/figures/frog.json");
    let text = fs::read_to_string(frog).expect("a problem");
    let mut problem: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    problem["lambdas"] = serde_json::json!({ "mp": 25.0, "gr": 0.5 });
    problem["iterations"] = serde_json::json!(7);
    let own = folder.path().join("frog.json");
    fs::write(&own, problem.to_string()).expect("written");
    let document = open(&own, FileAccess::SceneFolder).expect("it opens");
    let settings = &document.shot().layers[0].settings;
    let lambdas = settings.lambdas;
    assert_eq!([lambdas.shape, lambdas.pins, lambdas.handles, lambdas.regularizer], [1.0, 25.0, 100.0, 0.5]);
    assert_eq!((settings.iteration_limit, settings.acceleration, settings.temporal), (7, 0, 0.0));
    let small = document.text().replace("[1920, 1080]", "[192, 108]");
    let solved = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("written");
        let mut session = opened(&path);
        session.go(13);
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        session.marks()[0].handles.clone()
    };
    assert_ne!(solved("weak.toml", &small), solved("firm.toml", &small.replace("mp = 25.0", "mp = 2500.0")));
}

#[test]
fn broken_files_are_reported_and_a_shot_that_breaks_on_disk_changes_nothing() {
    let stage = Stage::new();
    let told = |path: &Path| open(path, FileAccess::SceneFolder).map(|_| ()).expect_err("it is broken").to_string();
    let folder = stage.folder.path();
    fs::write(folder.join("broken.toml"), "version = 1\nscene = \"cards.gltf").expect("written");
    assert!(told(&folder.join("broken.toml")).contains("broken.toml:2"));
    fs::write(folder.join("bad.glb"), "glTF").expect("written");
    assert!(told(&folder.join("bad.glb")).contains("bad.glb"));
    assert!(told(&folder.join("none.####.exr")).contains("no such file or sequence"));
    // The scene is missing: the shot opens, and what fails is told.
    fs::write(folder.join("lost.toml"), SHOT.replace("cards.gltf", "lost.gltf")).expect("written");
    let mut session =
        Session::new(Document::open(&folder.join("lost.toml")).expect("a shot"), DeviceChoice::Cpu, || ());
    assert!(!session.settle(TIMEOUT));
    assert!(session.fault().is_some_and(|text| text.contains("lost.gltf")), "{:?}", session.fault());
    session.set_shot("Choose scene", &["scene"], &pinwarp::shot::edit::Setting::Text("cards.gltf".into()), None);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());

    let mut session = stage.session();
    place_pin(&mut session, at(0.4, 0.5));
    fs::write(stage.shot(), "version = [").expect("written");
    let text = session.document().text().to_owned();
    assert!(session.document_mut().check_disk().is_ok(), "there are changes here: it asks");
    session.undo();
    let error = session.document_mut().check_disk().expect_err("what is on disk is no shot");
    assert!(error.to_string().contains("TOML"), "{error}");
    session.redo();
    assert_eq!(session.document().text(), text);
    let error = session.save().expect_err("another program wrote it");
    assert!(error.to_string().contains("another program"), "{error}");
    assert_eq!(fs::read_to_string(stage.shot()).expect("there"), "version = [", "nothing is overwritten unasked");
    fs::write(stage.shot(), SHOT).expect("written");
    session.save().expect("writable");
    Shot::read(&stage.shot()).expect("whole again");
}
