//! `pinwarp warp` with `holes = "geometry"`: what the scene shows where something moved away, with its ids and names.

use crate::support::Bench;
use crate::tiny::{Tiny, grid};
use pinwarp::image::cryptomatte::{Manifest, MatteId};
use pinwarp::image::{Channel, Frame, Plate, Storage, read_plate, write_plate};
use pinwarp::space::PixelRect;

/// A shot of 64 x 36 pixels: a wall, and before it a thing; both are layers of their own. The plate is drawn without the keys.
fn shot(keys: &str, output: &str) -> String {
    format!(
        r#"
scene  = "tiny.gltf"
plate  = "in/b.####.exr"
frames = {{ first = 1, last = 1 }}
size   = [64, 36]
samples = 1

[[layer]]
name  = "behind"
nodes = ["Wall"]
lattice = {{ dims = [4, 4] }}

[[layer]]
name  = "before"
nodes = ["Thing"]
matte = {{ id = "id.layer", values = [2] }}
lattice = {{ dims = [4, 4] }}

  [[layer.pin]]
  anchor = {{ screen = [0.889, 0.5] }}
  {keys}

[warp]
holes = "geometry"

[output]
path     = "{output}"
channels = ["beauty", "depth", "motion", "normal", "id", "cryptomatte"]
"#
    )
}

/// The plate is rendered, and the shot lies beside it.
fn bench() -> Bench {
    let mut thing = grid("Thing", [-0.2, -0.2, 0.2, 0.2], 2);
    thing.place = [0.0, 0.0, 1.0];
    let wall = grid("Wall", [-0.8, -0.45, 0.8, 0.45], 2);
    let keys = "keys = [{ frame = 1, offset = [0.25, 0.0] }]";
    let bench = Bench::with(&Tiny::of(vec![wall, thing]).json(), &shot(keys, "out/w.####.exr"));
    bench.write("still.toml", shot("", "in/b.####.exr").as_bytes());
    bench.run("render still.toml --device cpu").says(0, &[]);
    bench
}

/// A sample of the middle row.
fn at(plate: &Plate, channel: &str, column: usize) -> f32 {
    let part = &plate.parts[0];
    let x = column as i32 - part.data_window.x;
    let row = (18 - part.data_window.y) as usize;
    part.channel(channel).expect(channel).samples[row * part.data_window.width as usize + x as usize]
}

/// The thing covers columns 25 to 38; it moves 9 to the right.
const HOLE: std::ops::Range<usize> = 26..33;

#[test]
fn what_the_scene_fills_has_the_ids_and_names_of_a_render() {
    let bench = bench();
    bench.run("warp --shot shot.toml --device cpu -o out/w.####.exr").says(0, &[]);
    bench.run("render shot.toml --device cpu -o out/g.####.exr").says(0, &[]);
    let [warped, drawn] =
        ["out/w.0001.exr", "out/g.0001.exr"].map(|name| read_plate(&bench.path(name)).expect("a plate"));
    for column in HOLE {
        assert_eq!((at(&warped, "id.layer", column), at(&warped, "id.object", column)), (1.0, 1.0), "{column}");
        let names = [("CryptoObject", "Wall"), ("CryptoMaterial", "material_0"), ("CryptoLayer", "behind")];
        for (matte, name) in names {
            let [id, coverage] = ["00.R", "00.G"].map(|rank| at(&warped, &format!("{matte}{rank}"), column));
            assert_eq!((MatteId::from_sample(id), coverage), (MatteId::of_name(name), 1.0), "{matte} {column}");
        }
    }
    let ids = |plate: &Plate| (5..60).map(|column| at(plate, "CryptoLayer00.R", column).to_bits()).collect::<Vec<_>>();
    let differ = ids(&warped).into_iter().zip(ids(&drawn)).filter(|(a, b)| a != b).count();
    assert!(differ <= 2, "the edges may be a pixel off: {differ}");
    assert_eq!(warped.parts[0].texts("cryptomatte/"), drawn.parts[0].texts("cryptomatte/"));
}

#[test]
fn names_of_what_fills_come_into_the_manifest() {
    let bench = bench();
    let path = bench.path("in/b.0001.exr");
    let mut plate = read_plate(&path).expect("a plate");
    let texts = plate.parts[0].texts("cryptomatte/");
    let key = texts.iter().find(|(_, text)| *text == "CryptoObject").map(|(key, _)| key.replace("name", "manifest"));
    let key = key.expect("a Cryptomatte of objects");
    plate.parts[0].set_text(&key, &Manifest::of_names(["Thing"]).to_json());
    pinwarp::image::write_plate(&path, &plate).expect("written");
    bench.run("warp --shot shot.toml --device cpu -o out/w.####.exr").says(0, &[]);
    let warped = read_plate(&bench.path("out/w.0001.exr")).expect("a plate");
    let manifest = Manifest::from_json(&warped.parts[0].text(&key).expect("a manifest"));
    assert_eq!(manifest, Manifest::of_names(["Thing", "Wall"]));
}

#[test]
fn a_clean_plate_of_another_size_is_refused() {
    let bench = bench();
    let of_size = |name: &str, [width, height]: [u32; 2]| {
        let window = PixelRect { x: 0, y: 0, width, height };
        let channel =
            |name: &str| Channel { name: name.into(), storage: Storage::Half, samples: vec![0.5; window.area()] };
        let channels = ["R", "G", "B", "A"].map(channel).into();
        let frame = Frame { display: window, data_window: window, pixel_aspect: 1.0, channels };
        write_plate(&bench.path(name), &Plate::from_frame(frame)).expect("written");
    };
    of_size("small.exr", [32, 18]);
    of_size("tall.exr", [64, 40]);
    let says = |size: &str| format!("the clean plate shows {size} pixels, the plate 64 x 36; render or scale");
    for (name, size) in [("small.exr", "32 x 18"), ("tall.exr", "64 x 40")] {
        let refused = bench.run(&format!("warp --shot shot.toml --device cpu --clean {name} -o out/w.####.exr"));
        refused.says(2, &[&format!("error: {name}: {}", says(size))]);
        assert!(bench.frames().is_empty(), "nothing was begun");
    }
    bench.write(
        "named.toml",
        shot("", "out/w.####.exr").replace("\"geometry\"", "{ plate = \"small.exr\" }").as_bytes(),
    );
    bench.run("warp --shot named.toml --device cpu -o out/w.####.exr").says(2, &[&says("32 x 18")]);
    // A frame between the first and the last fails alone.
    for (frame, size) in [(1, [64, 36]), (2, [32, 18]), (3, [64, 36])] {
        of_size(&format!("c.000{frame}.exr"), size);
    }
    let long = shot("", "out/w.####.exr").replace("last = 1", "last = 3").replace("in/b.####.exr", "in/b.0001.exr");
    bench.write("long.toml", long.as_bytes());
    let partly = bench.run("warp --shot long.toml --device cpu --clean c.####.exr -o out/w.####.exr");
    partly.says(1, &["error: frame 2", "c.0002.exr", &says("32 x 18"), "1 FAILED"]);
    assert_eq!(bench.frames(), ["w.0001.exr", "w.0003.exr"]);
}
