//! Damaged files must be refused or loaded, never bring the program down; what loads must pose.

use super::assets::shared;
use super::build::{Doc, load_bytes};
use crate::internal::numbers::{Random, SplitMix};
use pinwarp::pose::{ClipChoice, pose};
use serde_json::json;

fn survive(bytes: &[u8]) -> bool {
    let Ok(scene) = load_bytes(bytes) else { return false };
    for clip in [None, Some(0)] {
        let _ = pose(&scene, ClipChoice { clip, is_looped: true }, 0.3);
    }
    true
}

/// A file with every kind of data: skin, morph, sparse, clip.
fn rich() -> Doc {
    let mut doc = Doc::square();
    let joints = doc.accessor(&[0, 1, 0, 0].repeat(4), super::build::U8, "VEC4", 4);
    let weights = doc.floats("VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(4));
    let up = doc.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let indices = doc.view(&[1, 3]);
    let values = doc.view(&[0; 24]);
    doc.json["accessors"][up]["sparse"] = json!({
        "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values },
    });
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    doc.primitive()["targets"] = json!([{ "POSITION": up }]);
    doc.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "children": [2] }, {}]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    doc.json["skins"] = json!([{ "joints": [1, 2] }]);
    doc.clip(2, "rotation", "LINEAR", (&[0.0, 1.0], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]));
    doc.clip(0, "weights", "CUBICSPLINE", (&[0.0, 1.0], "SCALAR", &[0.0, 0.0, 1.0, 1.0, 1.0, 0.0]));
    doc
}

#[test]
fn flipped_bytes_of_a_small_file_do_no_harm() {
    let good = rich().glb();
    assert!(survive(&good));
    let seed = 0x5eed_0001;
    let mut numbers = SplitMix(seed);
    let mut taken = 0;
    for _ in 0..3000 {
        let mut bytes = good.clone();
        for _ in 0..=numbers.below(4) {
            // The chunk headers too; the magic stays, or nothing else would be reached.
            let at = 4 + numbers.below(bytes.len() - 4);
            bytes[at] = numbers.below(256) as u8;
        }
        taken += usize::from(survive(&bytes));
    }
    assert!(taken > 100, "most flips in the data are harmless, {taken} of 3000 loaded (seed {seed:#x})");
}

#[test]
fn changed_numbers_in_the_json_do_no_harm() {
    let doc = rich();
    let text = doc.with_data_uri().to_string();
    let cut = text.find("\"uri\"").unwrap();
    let places: Vec<usize> = text
        .char_indices()
        .filter(|(at, c)| c.is_ascii_digit() && (*at < cut || *at > cut + 3000))
        .map(|(at, _)| at)
        .collect();
    let mut refused = 0;
    for at in places {
        for digits in ["7", "123456789", "18446744073709551615", "-1", "0.5", "1e30", "null", "[]"] {
            let changed = format!("{}{digits}{}", &text[..at], &text[at + 1..]);
            refused += usize::from(!survive(changed.as_bytes()));
        }
    }
    assert!(refused > 100, "{refused} refused");
}

#[test]
fn a_cut_or_flipped_knight_does_no_harm() {
    let Some(path) = shared("kaykit/Knight.glb") else { return };
    let good = std::fs::read(path).unwrap();
    let mut numbers = SplitMix(0x5eed_0002);
    for length in (0..40).chain((1..24).map(|part| good.len() * part / 24)).chain([good.len() - 1]) {
        assert!(load_bytes(&good[..length]).is_err(), "{length} bytes");
    }
    let json_end = 20 + u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    for round in 0..60 {
        let mut bytes = good.clone();
        // Half of the rounds aim at the JSON, half at the data.
        let at = if round % 2 == 0 { 12 + numbers.below(json_end - 12) } else { numbers.below(bytes.len()) };
        bytes[at] = numbers.below(256) as u8;
        survive(&bytes);
    }
}

#[test]
fn a_cut_that_keeps_the_container_whole_is_refused() {
    let doc = rich();
    // The container pads to four bytes, which the last three may hide in.
    for length in 0..doc.bytes.len() - 3 {
        let cut = Doc { json: doc.json.clone(), bytes: doc.bytes[..length].to_vec() };
        assert!(load_bytes(&cut.glb()).is_err(), "{length} of {} bytes", doc.bytes.len());
    }
}
