//! Each rule of the shot file has a file that breaks it; line, key and remedy are what the user needs.

use super::{GOOD, parse, replaced};
use pinwarp::shot::ShotError;

/// What is changed in the good shot, and what has to be said about it.
struct Case {
    from: &'static str,
    to: &'static str,
    line: usize,
    key: &'static str,
    says: &'static [&'static str],
}

const fn case(
    [from, to]: [&'static str; 2],
    (line, key): (usize, &'static str),
    says: &'static [&'static str],
) -> Case {
    Case { from, to, line, key, says }
}

fn check(cases: &[Case]) {
    for Case { from, to, line, key, says } in cases {
        let error = parse(&replaced(GOOD, from, to)).expect_err(to);
        let fault = |error: &ShotError| match error {
            ShotError::Invalid { line, key, .. } => (*line, key.clone()),
            other => panic!("{to}: {other}"),
        };
        let faults: Vec<_> = error.each().iter().map(fault).collect();
        assert_eq!(faults, [(*line, (*key).to_owned())], "{from} -> {to}: {error}");
        let text = error.to_string();
        assert!(text.starts_with(&format!("shots/pot.toml:{line}: {key}: ")), "{text}");
        for part in *says {
            assert!(text.contains(part), "{from} -> {to}: {part:?} is not in: {text}");
        }
    }
}

#[test]
fn keys_and_types() {
    check(&[
        case(["camera =", "kamera ="], (3, "kamera"), &["did you mean `camera`?", "keys here: camera, environment"]),
        case(["camera =", "zzz ="], (3, "zzz"), &["not a key of a shot", "remove it", "keys here: camera"]),
        case(["camera =", "clip ="], (3, "clip"), &["belongs in frames"]),
        case(["camera = \"ShotCam\"", "\"a b\" = 1"], (3, "\"a b\""), &["not a key"]),
        case(["unit =", "uint ="], (26, "layer[0].pin[1].uint"), &["did you mean `unit`?"]),
        case(["ease = {", "eas = {"], (30, "layer[0].handle[0].keys[1].eas"), &["did you mean `ease`?"]),
        case(["scene  =", "scenes  ="], (2, "scenes"), &["did you mean `scene`?"]),
        case(["scene  =", "image  ="], (2, "image"), &["\"teapot.glb\" is not the name of a picture", "is a `scene`"]),
        case(["scene  = \"teapot.glb\"", ""], (1, "scene"), &["is missing", "scene = \"scene.glb\"", "plate = "]),
        case(["first = 1,", ""], (4, "frames.first"), &["is missing", "first = 1"]),
        case(
            ["  anchor = { screen = [0.91, 0.52], frame = 1 }\n", ""],
            (24, "layer[0].pin[1].anchor"),
            &["is missing"],
        ),
        case(["\"teapot.glb\"", "3"], (2, "scene"), &["expected text in quotes, found 3", "scene = \"scene.glb\""]),
        case(["\"teapot.glb\"", "\"\""], (2, "scene"), &["is empty"]),
        case(["\"teapot.glb\"", "1979-05-27"], (2, "scene"), &["found a date"]),
        case(["last = 48", "last = 48.5"], (4, "frames.last"), &["expected a whole number, found 48.5"]),
        case(["last = 48", "last = \"48\""], (4, "frames.last"), &["found the text \"48\""]),
        case(["loop = true", "loop = 1"], (4, "frames.loop"), &["expected true or false"]),
        case(["\"Walk\"", "true"], (4, "frames.clip"), &["expected a whole number or text in quotes"]),
        case(["\"Walk\"", "-1"], (4, "frames.clip"), &["-1 is out of range", "from 0"]),
        case(["\"Walk\"", "99999999999"], (4, "frames.clip"), &["out of range"]),
        case(["[1920, 1080]", "1920"], (6, "size"), &["a list of 2 whole numbers, found 1920", "size = [1920, 1080]"]),
        case(["[1920, 1080]", "[1, 2, 3]"], (6, "size"), &["found a list of 3"]),
        case(
            ["\"smooth\"", "\"smoth\""],
            (22, "layer[0].pin[0].keys[1].ease"),
            &["did you mean \"smooth\"?", "allowed: \"hold\", \"linear\", \"smooth\", { bezier = .. }"],
        ),
        case(["\"smooth\"", "[1]"], (22, "layer[0].pin[0].keys[1].ease"), &["found a list"]),
        case(["bezier =", "besier ="], (30, "layer[0].handle[0].keys[1].ease.besier"), &["did you mean `bezier`?"]),
        case(["\"bspline\"", "\"b-spline\""], (13, "layer[0].lattice.basis"), &["did you mean \"bspline\"?"]),
        case(["[\"Teapot*\"]", "[]"], (12, "layer[0].nodes"), &["at least 1"]),
        case(["[\"Teapot*\"]", "[\"\"]"], (12, "layer[0].nodes[0]"), &["is empty"]),
    ]);
}

#[test]
fn ranges() {
    check(&[
        case(["version = 1", "version = 2"], (1, "version"), &["has version 2", "write `version = 1`"]),
        case(["first = 1,", "first = 99,"], (4, "frames.last"), &["99 to 48 is empty", "99 or later"]),
        case(["first = 1,", "first = 99999999999,"], (4, "frames.first"), &["out of range"]),
        case(["rate = 24", "rate = 0"], (4, "frames.rate"), &["0 is out of range", "from 0.01 to 1000"]),
        case(["rate = 24", "rate = -24.0"], (4, "frames.rate"), &["-24.0 is out of range"]),
        case(["1080]", "0]"], (6, "size[1]"), &["0 is out of range", "a whole number from 1 to 65536"]),
        case(["1920,", "100000,"], (6, "size[0]"), &["100000 is out of range", "from 1 to 65536"]),
        case(["angle = 180", "angle = 361"], (5, "shutter.angle"), &["from 0 to 360"]),
        case(["angle = 180", "angle = -1"], (5, "shutter.angle"), &["from 0 to 360"]),
        case(["size ", "samples = 0\nsize "], (6, "samples"), &["from 1 to 4096"]),
        case(["size ", "samples = 4097\nsize "], (6, "samples"), &["from 1 to 4096"]),
        case(["size ", "pixel_aspect = 0\nsize "], (6, "pixel_aspect"), &["from 0.1 to 10"]),
        case(["size ", "exposure = 40\nsize "], (6, "exposure"), &["from -32 to 32"]),
        case(["= 0.5\nstrength", "= -0.5\nstrength"], (7, "environment"), &["from 0 to 1000"]),
        case(["= 0.5\nstrength", "= nan\nstrength"], (7, "environment"), &["nan is not a number that can be used"]),
        case(["strength = 0.5", "strength = inf"], (8, "strength"), &["inf is not a number"]),
        case(["0.06, 0.03", "nan, 0.03"], (22, "layer[0].pin[0].keys[1].offset[0]"), &["nan is not a number"]),
        case(["0.2, 1.5", "-inf, 1.5"], (13, "layer[0].lattice.box.fixed[1]"), &["-inf is not a number"]),
        case(["step    = 2", "step    = 0"], (15, "layer[0].step"), &["from 1 to 1000"]),
        case(["[10, 8]", "[10, 65]"], (13, "layer[0].lattice.dims[1]"), &["from 2 to 64"]),
        case(["rotate = 20", "scale = 0"], (22, "layer[0].pin[0].keys[1].scale"), &["from 0.001 to 1000"]),
        case(["triangle = 312", "triangle = -1"], (20, "layer[0].pin[0].anchor.triangle"), &["from 0 to"]),
    ]);
}

#[test]
fn numbers_are_taken_for_pixels_by_the_shape_of_the_frame() {
    let long = |size: &str, x: &str| {
        let text = replaced(&replaced(GOOD, "[1920, 1080]", size), "screen = [0.91,", &format!("screen = [{x},"));
        parse(&text).err().map(|error| error.to_string())
    };
    for (size, x) in [("[64, 1]", "63.5"), ("[500, 3]", "166.0"), ("[1920, 1080]", "31.0")] {
        assert_eq!(long(size, x), None, "{size} {x}");
    }
    for (size, x) in [("[64, 1]", "129.0"), ("[500, 3]", "499.5"), ("[1920, 1080]", "33.0"), ("[1, 64]", "33.0")] {
        assert!(long(size, x).is_some_and(|error| error.contains("look like pixels")), "{size} {x}");
    }
}

#[test]
fn layers() {
    const TWIN: &str = "[[layer]]\nname = \"body\"\n[output]";
    check(&[
        case(["[output]", TWIN], (33, "layer[1].name"), &["a layer named \"body\" is there already"]),
        case(
            ["[output]", "[[layer]]\nlattice.dims = [10, 3]\n[output]"],
            (33, "layer[1].lattice.dims"),
            &["needs at least 4", "bernstein"],
        ),
        case(["0.1, 0.2, 1.5", "1.5, 0.2, 1.5"], (13, "layer[0].lattice.box.fixed"), &["is empty", "left < right"]),
        case(["1.5, 0.9", "1920, 0.9"], (13, "layer[0].lattice.box.fixed"), &["look like pixels", "1080 is 1.7778"]),
        case(["\"edge\"", "\"area\""], (14, "layer[0].solve.weights"), &["add energy = \"edge\" or remove `weights`"]),
        case(
            ["energy = \"edge\", regularizer = \"rest\", weights", "preset = \"paper\", weights"],
            (14, "layer[0].solve.weights"),
            &["is already set by the preset", "remove `preset` or `weights`"],
        ),
        case(
            ["index = [9, 4]", "index = [9, 8]"],
            (29, "layer[0].handle[0].index"),
            &["no handle [9, 8] in a lattice of 10 x 8", "rows from 0 to 7"],
        ),
        case(["[output]", "[[layer.handle]]\nindex = [9, 4]\n[output]"], (33, "layer[0].handle[1].index"), &["twice"]),
    ]);
}

#[test]
fn stiff_parts() {
    const TWO: &str = "[[layer.stiffness]]\nnodes = [\"a\"]\nmaterial = \"b\"\nvalue = 4\n[output]";
    const NONE: &str = "[[layer.stiffness]]\nmaterial = \"b\"\nvalue = 0\n[output]";
    const STROKE: &str = "[[layer.stiffness]]\nvalue = 4\nstroke = { radius = 0.1, points = [] }\n[output]";
    const RED: &str = "[[layer.stiffness]]\nvertex_color = \"red\"\nvalue = 2\n[output]";
    check(&[
        case(
            ["[output]", "[[layer.stiffness]]\nvalue = 4\n[output]"],
            (32, "layer[0].stiffness[0]"),
            &["does not say what is stiff", "nodes = [\"Head*\"]"],
        ),
        case(["[output]", TWO], (32, "layer[0].stiffness[0]"), &["or two of them", "their values multiply"]),
        case(["[output]", NONE], (34, "layer[0].stiffness[0].value"), &["from 0.001 to 1000"]),
        case(["[output]", STROKE], (34, "layer[0].stiffness[0].stroke.points"), &["points"]),
        case(["[output]", RED], (33, "layer[0].stiffness[0].vertex_color"), &["\"r\""]),
        case(
            ["name   = \"spout\"", "region = { radius = 0.1 }"],
            (19, "layer[0].pin[0].region"),
            &["does nothing", "rigidity = 1.0", "stiffness = 5.0"],
        ),
        case(
            ["name   = \"spout\"", "region = { radius = 108, rigidity = 1 }"],
            (19, "layer[0].pin[0].region.radius"),
            &["look like pixels", "108 px of 1080 is 0.1"],
        ),
        case(
            ["name   = \"spout\"", "region = { radius = 0.1, rigidity = 2 }"],
            (19, "layer[0].pin[0].region.rigidity"),
            &["from 0 to 1"],
        ),
        case(["name   = \"spout\"", "rigidity = 1"], (19, "layer[0].pin[0].rigidity"), &["it belongs in region"]),
    ]);
}

#[test]
fn former_keys() {
    check(&[
        case(
            ["name   = \"spout\"", "region = { radius = 0.1, grip = 1 }"],
            (19, "layer[0].pin[0].region.grip"),
            &["is not a key", "it is called `rigidity`"],
        ),
        case(
            ["name   = \"spout\"", "region = { radius = 0.1, starch = 5 }"],
            (19, "layer[0].pin[0].region.starch"),
            &["is not a key", "it is called `stiffness`"],
        ),
        case(
            ["energy = \"edge\"", "stiffness = 2, energy = \"edge\""],
            (14, "layer[0].solve.stiffness"),
            &["is not a key", "it is called `smoothness`"],
        ),
        case(
            ["energy = \"edge\"", "energy = \"rims\""],
            (14, "layer[0].solve.energy"),
            &["it is called \"spokes-and-rims\""],
        ),
    ]);
}

#[test]
fn pins() {
    const UNIT: [&str; 2] = ["unit = \"box\"", "name = \"spout\""];
    check(&[
        case(UNIT, (26, "layer[0].pin[1].name"), &["named \"spout\" is there already"]),
        case(["0.3005", "0.305"], (20, "layer[0].pin[0].anchor.barycentric"), &["sum to 1.005", "divide"]),
        case(["0.2, 0.5, 0.3005", "-0.2, 0.9, 0.3"], (20, "layer[0].pin[0].anchor.barycentric"), &["negative"]),
        case(["triangle = 312, ", ""], (20, "layer[0].pin[0].anchor.triangle"), &["is missing", "pinwarp pick"]),
        case(["node = \"Teapot\", ", ""], (20, "layer[0].pin[0].anchor"), &["neither a point of the screen"]),
        case(
            ["screen = [0.91, 0.52]", "node = \"a\", triangle = 0, barycentric = [1, 0, 0]"],
            (25, "layer[0].pin[1].anchor.frame"),
            &["needs no frame"],
        ),
        case(["screen = [0.91", "node = \"a\", screen = [0.91"], (25, "layer[0].pin[1].anchor.node"), &["not both"]),
        case(["[0.91, 0.52]", "[960, 0.52]"], (25, "layer[0].pin[1].anchor.screen"), &["960 px of 1080 is 0.8889"]),
        case(["0.06, 0.03", "0.06, -54"], (22, "layer[0].pin[0].keys[1].offset"), &["-54 px of 1080 is -0.05"]),
        case(["frame = 12", "frame = 1"], (22, "layer[0].pin[0].keys[1].frame"), &["does not come after frame 1"]),
        case(["frame = 24", "frame = 0.5"], (30, "layer[0].handle[0].keys[1].frame"), &["does not come after"]),
        case(["offset = [0.06", "target = [0.06"], (22, "layer[0].pin[0].keys[1].target"), &["all a `target`"]),
        case(["{ frame = 1, offset", "{ frame = 1, target"], (22, "layer[0].pin[0].keys[1]"), &["this one has none"]),
        case(["rotate = 20", "target = [1, 1]"], (22, "layer[0].pin[0].keys[1].target"), &["an offset and a target"]),
        case(["[0.2, 0, 0.8", "[1.2, 0, 0.8"], (30, "layer[0].handle[0].keys[1].ease.bezier"), &["x1 and x2 within"]),
    ]);
}

#[test]
fn outputs() {
    check(&[
        case(["teapot.%04d.exr", "teapot.exr"], (33, "output.path"), &["48 frames", "teapot.####.exr"]),
        case(["teapot.%04d.exr", "teapot.##.##.exr"], (33, "output.path"), &["two frame counters"]),
        case(["teapot.%04d.exr", "teapot.%04d.png"], (33, "output.path"), &["let it end in .exr"]),
        case(["\"id\"", "\"velocity\""], (34, "output.channels[1]"), &["called \"motion\""]),
        case(["\"id\"", "\"beauty\""], (34, "output.channels[1]"), &["twice"]),
        case(["[\"beauty\", \"id\"]", "[]"], (34, "output.channels"), &["at least 1"]),
        case(["channels =", "compression = \"zap\"\n#"], (34, "output.compression"), &["did you mean \"zip\"?"]),
    ]);
}

#[test]
fn all_faults_are_reported_in_the_order_of_the_file() {
    let text = GOOD.replace("\"id\"", "\"ids\"").replace("last = 48", "last = 0").replace("0.3005", "3");
    let error = parse(&text.replace("camera", "kamera")).unwrap_err();
    let lines: Vec<String> = error.to_string().lines().map(|line| line.split(' ').next().unwrap().to_owned()).collect();
    // A value that cannot be read at all (line 34) hides relations between values (lines 4 and 20).
    assert_eq!(lines, ["shots/pot.toml:3:", "shots/pot.toml:34:"]);
    let text = GOOD.replace("camera", "kamera").replace("last = 48", "last = 0").replace("0.3005", "3");
    let lines = parse(&text).unwrap_err().each().len();
    assert_eq!(lines, 3, "unknown keys hide nothing");
}

#[test]
fn broken_toml_names_line_and_column() {
    let error = parse(&replaced(GOOD, "[1920, 1080]", "[1920, 1080")).unwrap_err();
    assert!(matches!(error, ShotError::Syntax { line: 6 | 7, .. }), "{error}");
    let error = parse("a = 1\na = 2\n").unwrap_err();
    assert!(error.to_string().starts_with("shots/pot.toml:2:1: not valid TOML: duplicate key"), "{error}");
}
