//! Shots of pictures: what they may say, and what they may not.

use super::{parse, replaced};
use pinwarp::shot::template::{self, Subject, TemplateFacts};
use pinwarp::shot::{BoxRule, LayerSpace, Shot, Source};
use pinwarp::solve::Topology;
use pinwarp::space::FrameSize;
use std::path::PathBuf;

/// Two pictures. Tests count its lines.
const PICTURES: &str = r#"image  = ["back.png", "girls/girl.exr"]
frames = { first = 1, last = 3 }
size   = [200, 100]

[[layer]]
nodes = ["girl*"]

  [[layer.pin]]
  anchor = { screen = [0.5, 0.5], frame = 1 }
  keys   = [{ frame = 1, offset = [0.1, 0.0] }]
"#;

#[test]
fn pictures_stand_in_for_the_scene() {
    let shot = parse(PICTURES).unwrap();
    let paths = ["shots/back.png", "shots/girls/girl.exr"].map(PathBuf::from);
    assert_eq!((&shot.source, shot.scene()), (&Source::Images(paths.to_vec()), None));
    assert_eq!(shot.size, FrameSize::new(200, 100));
    assert_eq!(shot.layers[0].space, LayerSpace::Screen { dims: [10, 10], bounds: BoxRule::Follow });
    let one = parse(&replaced(PICTURES, "[\"back.png\", \"girls/girl.exr\"]", "\"back.JPG\"")).unwrap();
    assert_eq!(one.source, Source::Images(vec!["shots/back.JPG".into()]));
    assert_ne!(one.hash(), shot.hash());
}

/// Frames are rendered again if one of these files changes, and farms send them along.
#[test]
fn files_that_cut_are_files_of_the_shot() {
    let cuts = "{ mask = { file = \"m.png\" } }, { ids = { file = \"i.png\" } }, { regions = { file = \"l.png\" } }, { regions = {} }";
    let text = replaced(PICTURES, "nodes = [\"girl*\"]\n", &format!("nodes = [\"girl*\"]\nlattice.cuts = [{cuts}]\n"));
    let shot = parse(&text).unwrap();
    let names: Vec<&PathBuf> = shot.files().collect();
    let wanted =
        ["back.png", "girls/girl.exr", "m.png", "i.png", "l.png"].map(|name| PathBuf::from("shots").join(name));
    assert_eq!(names, wanted.iter().collect::<Vec<_>>());
    assert_ne!(shot.hash(), parse(&replaced(&text, "l.png", "k.png")).unwrap().hash());
    let moved = Shot::parse(&text, std::path::Path::new("elsewhere/pot.toml")).unwrap();
    assert_eq!(shot.hash(), moved.hash(), "the folder does not count");
}

#[test]
fn the_first_picture_gives_the_size() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbaImage::new(30, 20).save(folder.path().join("back.png")).unwrap();
    let text = replaced(PICTURES, "size   = [200, 100]\n", "");
    let shot = Shot::parse(&text, &folder.path().join("shot.toml")).unwrap();
    assert_eq!(shot.size, FrameSize::new(30, 20));
    let wide = Shot::parse(&format!("pixel_aspect = 2.0\n{text}"), &folder.path().join("shot.toml")).unwrap();
    assert_eq!(wide.size.aspect(), 3.0);
    let error = parse(&text).unwrap_err().to_string();
    assert!(error.starts_with("shots/pot.toml:1: image: cannot read shots/back.png: "), "{error}");
    assert!(error.contains("mend its path, or give `size`"), "{error}");
}

#[test]
fn a_picture_may_have_the_sign_of_a_counter_in_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let shot = folder.path().join("shot.toml");
    let text = replaced(PICTURES, "back.png", "back#2.png");
    assert!(Shot::parse(&text, &shot).unwrap_err().to_string().contains("this is a sequence"));
    image::RgbaImage::new(30, 20).save(folder.path().join("back#2.png")).unwrap();
    let images = ["back#2.png", "girls/girl.exr"].map(|name| folder.path().join(name));
    assert_eq!(Shot::parse(&text, &shot).unwrap().source, Source::Images(images.to_vec()));
}

/// A change of the shot above, the line and key of its fault, and what is said about it.
type Case = ([&'static str; 2], usize, &'static str, &'static str);

#[test]
fn faults_name_line_key_and_remedy() {
    let cases: &[Case] = &[
        (["\"back.png\"", "\"back.glb\""], 1, "image[0]", "is not the name of a picture"),
        (["\"back.png\"", "\"back\""], 1, "image[0]", "give a .png, .jpg or .exr file"),
        (["\"back.png\"", "\"girls/girl.exr\""], 1, "image[1]", "is listed twice"),
        (["\"back.png\"", "\"back.####.png\""], 1, "image[0]", "run `pinwarp warp`"),
        (["\"back.png\"", "\"\""], 1, "image[0]", "is empty"),
        (["[\"back.png\", \"girls/girl.exr\"]", "[]"], 1, "image", "at least 1"),
        (["[\"back.png\", \"girls/girl.exr\"]", "3"], 1, "image", "expected text in quotes or a list"),
        (["size ", "scene = \"a.glb\"\nsize "], 1, "image", "keep one of `image` and `scene`"),
        (["image ", "images "], 1, "images", "did you mean `image`?"),
        (["nodes = ", "lattice.space = \"world\"\nnodes = "], 6, "layer[0].lattice.space", "pictures are flat"),
        (["size ", "warp.holes = \"geometry\"\nsize "], 3, "warp.holes", "has no scene that could fill holes"),
    ];
    for ([from, to], line, key, says) in cases {
        let error = parse(&replaced(PICTURES, from, to)).expect_err(to).to_string();
        let place = format!("shots/pot.toml:{line}: {key}: ");
        assert!(error.lines().any(|fault| fault.starts_with(&place) && fault.contains(says)), "{to}: {error}");
        assert!(!error.contains("scene: is missing"), "{error}");
    }
}

#[test]
fn a_picture_beside_a_plate_is_its_reference_frame() {
    let shot = parse(&replaced(PICTURES, "size ", "plate = \"a.####.exr\"\nsize ")).expect("a right shot");
    assert!(matches!(&shot.source, Source::Images(images) if images.len() == 2), "{:?}", shot.source);
    assert!(shot.plate.is_some_and(|plate| plate.ends_with("a.####.exr")));
    let told = shot_with("plate = 'a.####.exr'", "lattice.cuts = [[[0, 0], [1, 1]]]").expect_err("no shape");
    assert!(told.contains("layer[0].lattice.cuts[0]") && told.contains("a reference frame of the plate"), "{told}");
}

#[test]
fn the_template_of_a_picture_is_a_working_shot() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbaImage::new(30, 20).save(folder.path().join("my girl.png")).unwrap();
    let facts = TemplateFacts {
        subject: Subject::Image,
        can_branch: true,
        cameras: Vec::new(),
        has_camera: true,
        clips: Vec::new(),
        spare_nodes: Vec::new(),
        mesh_nodes: vec!["my girl".to_owned()],
        frames: [1, 24],
        rate: 24.0,
        size: FrameSize::new(30, 20),
    };
    let text = template::write("my girl.png", &facts);
    let read = |text: &str| Shot::parse(text, &folder.path().join("shot.toml"));
    let shot = read(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!((shot.size, shot.frames.count()), (FrameSize::new(30, 20), 24));
    let line = |line: &str| {
        let is_example = line.trim_start().starts_with("# ");
        if is_example { line.replacen("# ", "", 1) } else { line.to_owned() }
    };
    let all = text.lines().map(line).collect::<Vec<_>>().join("\n");
    let shot = read(&all).unwrap_or_else(|error| panic!("{error}\n{all}"));
    assert_eq!((shot.layers[0].pins.len(), shot.samples, shot.shutter.angle), (1, 16, 180.0));
    assert!(!text.contains("world") && !text.contains("camera"), "{text}");
}

/// A shot of this source with one layer.
fn shot_with(source: &str, layer: &str) -> Result<Shot, String> {
    let text = format!(
        "version = 1\n{source}\nsize = [96, 64]\nframes = {{ first = 1, last = 2 }}\noutput.path = 'o.####.exr'\n[[layer]]\n{layer}"
    );
    Shot::parse(&text, std::path::Path::new("shot.toml")).map_err(|error| error.to_string())
}

#[test]
fn branching_lattices_need_a_shape_and_local_handles() {
    let fault = |from: &str, layer: &str| shot_with(from, layer).map(drop);
    let branching = "lattice.topology = 'branching'";
    assert_eq!(fault("image = 'a.png'", branching), Ok(()));
    assert_eq!(fault("scene = 'a.glb'", branching), Ok(()));
    assert_eq!(fault("image = 'a.png'", &format!("{branching}\nsolve.temporal = 0.3")), Ok(()));
    for (from, layer, says) in [
        ("plate = 'p.####.exr'", branching.to_owned(), "needs a shape"),
        ("image = 'a.png'", format!("{branching}\nlattice.basis = 'bernstein'"), "local support"),
        ("image = 'a.png'", format!("{branching}\nsolve.preset = 'paper'"), "energy than `area`"),
        ("image = 'a.png'", format!("{branching}\nsolve.regularizer = 'rest'"), "regulariser than `bend`"),
    ] {
        let told = fault(from, &layer).expect_err(&layer);
        let key = "layer[0].lattice.topology";
        assert!(told.contains(key) && told.contains(says) && told.contains("topology = \"plain\""), "{told}");
    }
    for (from, layer, key, says) in [
        ("scene = 'a.glb'", "lattice = { space = 'world', dims = 'auto' }", "dims", "of the screen only"),
        ("image = 'a.png'", "lattice = { basis = 'bernstein', dims = 'auto' }", "dims", "bspline"),
        ("image = 'a.png'", "lattice = { dims = 'most' }", "dims", "auto"),
        (
            "image = 'a.png'",
            "lattice.topology = 'plain'\n[[layer.pin]]\nanchor.screen = [0, 0]\norder = 1",
            "pin[0].order",
            "branching",
        ),
        (
            "scene = 'a.glb'",
            "lattice.topology = 'branching'\n[[layer.pin]]\nanchor.screen = [0, 0]\norder = 1",
            "pin[0].order",
            "by their depth",
        ),
        (
            "image = 'a.png'",
            "lattice.topology = 'branching'\n[[layer.pin]]\nanchor.screen = [0, 0]\n\
             order = [{ frame = 2, value = 1 }, { frame = 2, value = 0 }]",
            "pin[0].order[1].frame",
            "does not come after",
        ),
        ("image = 'a.png'", "lattice.cuts = [{ ids = { file = 'i.png' }, order = 1 }]", "cuts[0].order", "is chosen"),
        ("image = 'a.png'", "lattice.cuts = [{ regions = {}, order = 1 }]", "cuts[0].order", "is chosen"),
        ("scene = 'a.glb'", "lattice.cuts = [{ nodes = ['Arm'], order = 1 }]", "cuts[0].order", "by their depth"),
        (
            "image = 'a.png'",
            "lattice.cuts = [{ mask = { file = 'm.png' }, order = [{ frame = 2, value = 1 }, { frame = 1, value = 0 }] }]",
            "cuts[0].order[1].frame",
            "does not come after",
        ),
        ("image = 'a.png'", "lattice = { topology = 'plain', cuts = [[[0, 0], [1, 1]]] }", "cuts", "branching"),
        ("image = 'a.png'", "lattice = { basis = 'bernstein', cuts = [[[0, 0], [1, 1]]] }", "cuts", "branching"),
        ("scene = 'a.glb'", "lattice = { topology = 'branching', cuts = [[[0, 0], [1, 1]]] }", "cuts[0]", "frame = 1"),
        ("image = 'a.png'", "lattice = { topology = 'branching', cuts = [[[0, 0]]] }", "cuts[0]", "at least 2 lists"),
    ] {
        let told = fault(from, layer).expect_err(layer);
        assert!(told.contains(key) && told.contains(says), "{layer}: {told}");
    }
}

#[test]
fn lattices_branch_by_default_where_they_can() {
    let topology = |from: &str, layer: &str| shot_with(from, layer).expect("a right shot").layers[0].settings.topology;
    for (from, layer, wanted) in [
        ("image = 'a.png'", "", Topology::Branching),
        ("image = 'a.png'", "lattice.basis = 'bilinear'", Topology::Branching),
        ("image = 'a.png'", "lattice.topology = 'plain'", Topology::Plain),
        ("image = 'a.png'", "lattice.basis = 'bernstein'", Topology::Plain),
        ("image = 'a.png'", "solve.preset = 'paper'", Topology::Plain),
        ("scene = 'a.glb'", "", Topology::Branching),
        ("scene = 'a.glb'", "lattice.topology = 'plain'", Topology::Plain),
        ("scene = 'a.glb'", "lattice.basis = 'bernstein'", Topology::Plain),
        ("scene = 'a.glb'", "lattice.space = 'world'", Topology::Plain),
        ("scene = 'a.glb'", "lattice.topology = 'branching'", Topology::Branching),
        ("scene = 'a.glb'", "lattice = { space = 'world', topology = 'branching' }", Topology::Branching),
        ("plate = 'p.####.exr'", "", Topology::Plain),
    ] {
        assert_eq!(topology(from, layer), wanted, "{from} {layer}");
    }
}
