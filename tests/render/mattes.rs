//! Cryptomattes in files: names and ids agree, blur and edges are shared out, the bytes are the same every time.

use super::python;
use super::support::{Studio, at, pinned_layer, pixels};
use super::tiny::{Part, Tiny, grid};
use pinwarp::image::cryptomatte::{MatteHeader, MatteId, matte_layers};
use pinwarp::image::{Frame, read_plate};
use pinwarp::raster::{ChannelGroup, MATTE_LAYERS};
use pinwarp::shot::Shutter;
use std::collections::BTreeSet;
use std::path::Path;

/// Two squares side by side, cut by pixel edges; "Quad" is pinned down, both are in a layer.
fn two(names: [&'static str; 2]) -> Tiny {
    let [left, right] = names;
    Tiny::of(vec![grid(left, [-0.31, -0.2, 0.012, 0.2], 2), grid(right, [0.012, -0.2, 0.3, 0.2], 2)])
}

fn with_mattes(mut studio: Studio, samples: u32) -> Studio {
    studio.shot.output.channels = vec![ChannelGroup::Beauty, ChannelGroup::Id, ChannelGroup::Cryptomatte];
    studio.shot.samples = samples;
    studio
}

/// What a Cryptomatte holds at a pixel: (id, coverage), largest first, without empty ranks.
fn ranks(frame: &Frame, layer: &str, (x, y): (i32, i32)) -> Vec<(MatteId, f32)> {
    let names = frame.channels.iter().map(|channel| (channel.name.as_str(), channel.name.as_str()));
    let layers = matte_layers(names, &[]);
    let found = layers.iter().find(|found| found.name == layer).expect("it was asked for");
    let of = |rank: &pinwarp::image::cryptomatte::RankChannels<&str>| {
        (MatteId::from_sample(at(frame, rank.id, x, y)), at(frame, rank.coverage, x, y))
    };
    found.ranks.iter().map(of).filter(|(_, share)| *share > 0.0).collect()
}

fn headers(file: &Path) -> Vec<MatteHeader> {
    let texts = read_plate(file).expect("the frame is readable").parts[0].texts("cryptomatte/");
    MatteHeader::from_attributes(texts.iter().map(|(name, text)| (name.as_str(), text.as_str())))
}

fn names(header: &MatteHeader) -> Vec<&str> {
    header.manifest.iter().map(|(name, _)| name).collect()
}

#[test]
fn the_manifest_names_every_id_in_the_pixels() {
    let studio =
        with_mattes(Studio::tiny(&two(["Quad", "Стена"]), &pinned_layer("{ frame = 1, offset = [0.0, 0.0] }")), 4);
    let file = studio.files(&[1]).remove(0);
    let headers = headers(&file);
    assert_eq!(
        headers.iter().map(|header| header.name.as_str()).collect::<Vec<_>>(),
        ["CryptoLayer", "CryptoMaterial", "CryptoObject"]
    );
    assert_eq!(names(&headers[0]), ["all"]);
    assert_eq!(names(&headers[2]), ["Quad", "Стена"]);
    let frame = pinwarp::image::read_exr(&file).expect("the frame is readable");
    for header in &headers {
        let known: BTreeSet<MatteId> = header.manifest.iter().map(|(_, id)| id).collect();
        let seen: BTreeSet<MatteId> =
            pixels(&frame).flat_map(|pixel| ranks(&frame, &header.name, pixel)).map(|(id, _)| id).collect();
        assert_eq!(seen, known, "{}", header.name);
    }
}

#[test]
fn unclaimed_nodes_are_in_the_default_layer_and_nodes_of_one_name_are_one_matte() {
    let layer = pinned_layer("{ frame = 1, offset = [0.0, 0.0] }")
        .replace("name = \"all\"", "name = \"body\"\nnodes = [\"Quad\"]");
    let studio = with_mattes(Studio::tiny(&two(["Quad", "Wall"]), &layer), 4);
    assert_eq!(names(&headers(&studio.files(&[1])[0])[0]), ["body", "default"]);
    let mut twins = two(["Twin", "Twin"]).json();
    twins["materials"][0]["name"] = "".into();
    let studio = with_mattes(Studio::of_json(&twins, ""), 4);
    let file = studio.files(&[1]).remove(0);
    assert_eq!(names(&headers(&file)[2]), ["Twin"]);
    assert_eq!(names(&headers(&file)[1])[0], "material_0", "a material without a name");
    // The pixel column that both share is whole.
    let frame = pinwarp::image::read_exr(&file).expect("the frame is readable");
    assert_eq!(ranks(&frame, "CryptoObject", (32, 20)), [(MatteId::of_name("Twin"), 1.0)]);
}

/// Coverage sums to alpha in every Cryptomatte, within what half floats hold of alpha.
#[track_caller]
fn assert_sums(frame: &Frame) {
    for pixel in pixels(frame) {
        let alpha = at(frame, "A", pixel.0, pixel.1);
        for layer in MATTE_LAYERS {
            let sum: f32 = ranks(frame, layer, pixel).iter().map(|(_, share)| share).sum();
            assert!((sum - alpha).abs() <= 5e-4, "{layer} covers {sum} of {alpha} at {pixel:?}");
        }
    }
}

#[test]
fn edges_are_shared_out_and_sum_to_alpha() {
    let frame = with_mattes(Studio::tiny(&two(["Quad", "Wall"]), ""), 64).frame(1);
    assert_sums(&frame);
    let shares = ranks(&frame, "CryptoObject", (32, 20));
    let [(first, most), (second, least)] = shares[..] else { panic!("two objects meet here: {shares:?}") };
    assert_eq!(BTreeSet::from([first, second]), ["Quad", "Wall"].map(MatteId::of_name).into());
    assert!(most >= least && least > 0.1 && (most + least - 1.0).abs() < 1e-5, "{shares:?}");
}

#[test]
fn motion_blur_spreads_coverage() {
    // Eight pixels a frame to the right; the shutter is open for half of it.
    let velocity = [8.0 * 24.0 / 40.0, 0.0, 0.0];
    let tiny = Tiny::of(vec![Part { velocity, ..grid("Quad", [-0.4, -0.2, 0.0, 0.2], 2) }]);
    let mut studio = with_mattes(Studio::tiny(&tiny, ""), 32);
    studio.shot.shutter = Shutter { angle: 180.0, phase: 0.0 };
    let frame = studio.frame(2);
    assert_sums(&frame);
    let share = |x: i32| ranks(&frame, "CryptoObject", (x, 20)).iter().map(|(_, share)| share).sum::<f32>();
    let column: Vec<f32> = (0..64).map(share).collect();
    let partly = column.iter().filter(|share| **share > 0.02 && **share < 0.98).count();
    // Four pixels of blur at either edge, and half of the filter's width to both sides.
    assert!((8..=14).contains(&partly), "{partly} pixels: {column:?}");
    let area: f32 = column.iter().sum();
    assert!((area - 16.0).abs() < 0.05, "the square is 16 pixels wide, {area} are covered");
}

#[test]
fn the_same_frame_is_the_same_bytes() {
    let mut studio = with_mattes(Studio::teapot(96, 54), 4);
    studio.shot.shutter = Shutter { angle: 180.0, phase: -90.0 };
    let bytes = || std::fs::read(&studio.files(&[7])[0]).expect("the frame is there");
    let first = bytes();
    assert!((0..3).all(|_| bytes() == first), "fifteen attributes have one order");
}

#[test]
fn a_shot_that_does_not_ask_has_none() {
    let studio = Studio::tiny(&two(["Quad", "Wall"]), "");
    let file = studio.files(&[1]).remove(0);
    assert_eq!(headers(&file), []);
    let frame = pinwarp::image::read_exr(&file).expect("the frame is readable");
    assert!(frame.channels.iter().all(|channel| !channel.name.starts_with("Crypto")));
}

/// Decodes with its own hash, and prints for each Cryptomatte the names, how many ids of the pixels have one, and the
/// largest difference between the sum of coverage and alpha.
const DECODE: &str = r#"
import sys, json, struct, OpenEXR, numpy as np
def murmur3(data):
    h, n = 0, len(data)
    def mix(k):
        k = k * 0xcc9e2d51 & 0xffffffff
        return ((k << 15 | k >> 17) & 0xffffffff) * 0x1b873593 & 0xffffffff
    for i in range(0, n - n % 4, 4):
        h ^= mix(int.from_bytes(data[i:i + 4], 'little'))
        h = ((h << 13 | h >> 19) & 0xffffffff) * 5 + 0xe6546b64 & 0xffffffff
    if n % 4:
        h ^= mix(int.from_bytes(data[n - n % 4:], 'little'))
    h ^= n
    for shift, factor in ((16, 0x85ebca6b), (13, 0xc2b2ae35)):
        h = (h ^ h >> shift) * factor & 0xffffffff
    return h ^ h >> 16
def id_of(name):
    h = murmur3(name.encode('utf-8'))
    return h ^ 1 << 23 if h >> 23 & 255 in (0, 255) else h
with OpenEXR.File(sys.argv[1], separate_channels=True) as file:
    header, channels = file.header(), file.channels()
    alpha = channels['A'].pixels.astype(np.float32)
    for key in sorted(k for k in header if k.startswith('cryptomatte/') and k.endswith('/name')):
        base, name = key[:-5], header[key]
        assert base == 'cryptomatte/%07x' % (murmur3(name.encode()) >> 4), (base, name)
        assert header[base + '/hash'] == 'MurmurHash3_32' and header[base + '/conversion'] == 'uint32_to_float32'
        manifest = json.loads(header[base + '/manifest'])
        assert list(manifest) == sorted(manifest)
        for entry, hexadecimal in manifest.items():
            assert hexadecimal == '%08x' % id_of(entry), (entry, hexadecimal)
        seen, total = set(), np.zeros_like(alpha)
        for layer in range(3):
            for i, c in ('RG', 'BA'):
                ids = np.ascontiguousarray(channels['%s%02d.%s' % (name, layer, i)].pixels)
                total += channels['%s%02d.%s' % (name, layer, c)].pixels
                assert ids.dtype == np.float32
                seen |= set(ids.view(np.uint32).ravel().tolist())
        assert seen - {0} <= {int(v, 16) for v in manifest.values()}, 'ids without a name'
        print(name, ','.join(manifest), len(seen - {0}), 'ok' if abs(total - alpha).max() < 5e-4 else 'sums differ')
"#;

#[test]
fn another_program_decodes_our_mattes() {
    let mut studio = with_mattes(
        Studio::tiny(&two(["Quad", "Стена \"2\""]), &pinned_layer("{ frame = 1, offset = [0.0, 0.0] }")),
        16,
    );
    studio.shot.shutter = Shutter { angle: 180.0, phase: 0.0 };
    let file = studio.files(&[1]).remove(0);
    let Some(said) = python::run(&["OpenEXR", "numpy"], DECODE, &[file.as_os_str()]) else { return };
    let mut lines: Vec<&str> = said.lines().collect();
    lines.sort_unstable();
    assert_eq!(lines.len(), 3, "{said}");
    assert_eq!(lines[0], "CryptoLayer all 1 ok");
    assert_eq!(lines[2], "CryptoObject Quad,Стена \"2\" 2 ok");
}
