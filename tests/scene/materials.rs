//! Materials, textures, images and lights.

use super::build::{Doc, base64, write};
use glam::{Vec2, Vec3, Vec4};
use pinwarp::pose::{ClipChoice, pose};
use pinwarp::scene::{AlphaMode, Filter, LightKind, TextureRef, Wrap, load};
use serde_json::json;
use std::io::Cursor;

/// A 2x1 image: opaque red, half transparent green.
fn png() -> Vec<u8> {
    let pixels = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 128]).unwrap();
    encode(&image::DynamicImage::ImageRgba8(pixels), image::ImageFormat::Png)
}

fn encode(image: &image::DynamicImage, format: image::ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, format).unwrap();
    out.into_inner()
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64(bytes))
}

/// A textured square.
fn textured(image: serde_json::Value) -> Doc {
    let mut doc = Doc::square();
    doc.attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    doc.json["images"] = json!([image]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    doc.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    doc.primitive()["material"] = json!(0);
    doc
}

#[test]
fn images_come_from_views_data_uris_and_files() {
    let expected = vec![255, 0, 0, 255, 0, 255, 0, 128];
    let inline = textured(json!({ "uri": data_uri(&png()) }));
    let mut viewed = textured(json!({}));
    let view = viewed.view(&png());
    viewed.json["images"][0] = json!({ "bufferView": view, "mimeType": "image/png" });
    for doc in [&inline, &viewed] {
        let scene = doc.scene();
        let image = &scene.images[0];
        assert_eq!((image.width, image.height, image.is_srgb), (2, 1, true));
        assert_eq!(image.rgba, expected);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "red green.png", &png());
    let beside = textured(json!({ "uri": "red%20green.png" })).with_data_uri().to_string();
    let scene = load(&write(folder.path(), "a.gltf", beside.as_bytes())).unwrap();
    assert_eq!(scene.images[0].rgba, expected);
}

#[test]
fn grey_16_bit_and_jpeg_images_become_rgba8() {
    let grey = image::DynamicImage::ImageLuma16(image::ImageBuffer::from_raw(2, 1, vec![0u16, 51 * 257]).unwrap());
    let scene = textured(json!({ "uri": data_uri(&encode(&grey, image::ImageFormat::Png)) })).scene();
    assert_eq!(scene.images[0].rgba, [0, 0, 0, 255, 51, 51, 51, 255]);
    let flat = image::DynamicImage::ImageRgb8(image::RgbImage::from_pixel(16, 8, image::Rgb([200, 100, 50])));
    let scene = textured(json!({ "uri": data_uri(&encode(&flat, image::ImageFormat::Jpeg)) })).scene();
    let image = &scene.images[0];
    assert_eq!((image.width, image.height, image.rgba.len()), (16, 8, 512));
    for (found, expected) in image.rgba.iter().zip([200u8, 100, 50, 255]) {
        assert!(found.abs_diff(expected) < 6, "{:?}", &image.rgba[..4]);
    }
}

#[test]
fn images_that_fail_are_warnings_and_their_textures_are_dropped() {
    let ktx2 = data_uri(b"\xabKTX 20\xbb\r\n\x1a\n then what");
    let webp = data_uri(b"RIFF\x10\0\0\0WEBPVP8 ");
    let cut = data_uri(&png()[..40]);
    for uri in ["gone.png", "https://example.com/a.png", &ktx2, &webp, &cut, "data:nothing"] {
        let scene = textured(json!({ "uri": uri })).scene();
        assert_eq!(scene.materials[0].base_color_texture, None);
        assert!(scene.textures.is_empty() && scene.images.is_empty());
        assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
        assert!(scene.warnings[0].contains("images[0]"), "{:?}", scene.warnings);
    }
    let mut sourceless = textured(json!({}));
    sourceless.json["textures"] = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    assert!(sourceless.scene().warnings[0].contains("textures[0]"));
    let mut missing = textured(json!({}));
    missing.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(3);
    assert!(missing.fault().contains("materials[0] names textures[3] (base colour)"));
}

#[test]
fn an_image_used_as_colour_and_as_data_stands_there_twice() {
    let mut doc = textured(json!({ "uri": data_uri(&png()) }));
    doc.json["materials"][0]["occlusionTexture"] = json!({ "index": 0, "strength": 0.5 });
    doc.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    let scene = doc.scene();
    assert_eq!(scene.images.len(), 2);
    let srgb = |texture: Option<TextureRef>| scene.images[scene.textures[texture.unwrap().texture].image].is_srgb;
    let material = &scene.materials[0];
    assert!(srgb(material.base_color_texture) && srgb(material.emissive_texture));
    assert!(!srgb(material.occlusion_texture));
    assert_eq!(material.base_color_texture, material.emissive_texture);
    assert_eq!(material.occlusion_strength, 0.5);
}

#[test]
fn samplers_say_how_textures_repeat_and_filter() {
    let mut doc = textured(json!({ "uri": data_uri(&png()) }));
    let plain = doc.scene().textures[0];
    assert_eq!((plain.wrap, plain.magnify), ([Wrap::Repeat; 2], Filter::Linear));
    assert_eq!((plain.minify, plain.mipmap), (Filter::Linear, Some(Filter::Linear)));
    doc.json["samplers"] = json!([{ "magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648 }]);
    doc.json["textures"][0]["sampler"] = json!(0);
    let found = doc.scene().textures[0];
    assert_eq!((found.wrap, found.magnify), ([Wrap::Clamp, Wrap::Mirror], Filter::Nearest));
    assert_eq!((found.minify, found.mipmap), (Filter::Linear, Some(Filter::Nearest)));
    doc.json["textures"][0]["sampler"] = json!(1);
    assert!(doc.fault().contains("sampler"));
}

#[test]
fn texture_transforms_scale_turn_and_move() {
    let mut doc = textured(json!({ "uri": data_uri(&png()) }));
    doc.attribute("TEXCOORD_1", "VEC2", &[0.0; 8]);
    let transform = json!({ "KHR_texture_transform": {
        "offset": [0.25, 0.5], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1 } });
    doc.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
    doc.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform.clone();
    doc.json["materials"][0]["normalTexture"] = json!({ "index": 0, "scale": 0.5, "extensions": transform });
    let scene = doc.scene();
    let material = &scene.materials[0];
    for texture in [material.base_color_texture.unwrap(), material.normal_texture.unwrap()] {
        assert_eq!(texture.uv_set, 1);
        let [u, v] = texture.texture_from_uv.map(|row| row.dot(Vec3::new(0.1, 0.2, 1.0)));
        // A quarter turn counter-clockwise in an image whose v points down: (u, v) -> (v, -u).
        assert!((Vec2::new(u, v) - Vec2::new(0.25 + 0.6, 0.5 - 0.2)).length() < 1e-6, "{u} {v}");
    }
    assert_eq!(material.normal_scale, 0.5);
}

#[test]
fn normal_maps_bring_tangents() {
    let mut doc = textured(json!({ "uri": data_uri(&png()) }));
    assert!(doc.scene().meshes[0].primitives[0].tangents.is_empty());
    doc.json["materials"][0]["normalTexture"] = json!({ "index": 0 });
    let scene = doc.scene();
    // v falls as y rises in these UVs, as in an upright image: the bitangent points along +y.
    assert_eq!(scene.meshes[0].primitives[0].tangents, [Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    doc.attribute("TANGENT", "VEC4", &[0.0, 2.0, 0.0, 1.0].repeat(4));
    let scene = doc.scene();
    assert_eq!(scene.meshes[0].primitives[0].tangents, [Vec4::new(0.0, 1.0, 0.0, 1.0); 4]);
    doc.json["nodes"][0]["rotation"] = json!([0.0, 0.0, 1.0, 0.0]);
    let posed = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!((posed.parts[0].tangents[0] - Vec4::new(0.0, -1.0, 0.0, 1.0)).length() < 1e-6);
}

#[test]
fn textures_without_uvs_show_one_texel_and_warn() {
    let mut doc = textured(json!({ "uri": data_uri(&png()) }));
    doc.primitive()["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let scene = doc.scene();
    assert_eq!(scene.meshes[0].primitives[0].uvs[0], [Vec2::ZERO; 4]);
    assert!(scene.warnings[0].contains("no TEXCOORD_0"));
    doc.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(2);
    let scene = doc.scene();
    assert!(scene.warnings[0].contains("TEXCOORD_2"));
    assert_eq!(scene.materials[0].base_color_texture, None);
}

#[test]
fn factors_modes_and_extensions_of_materials_are_read() {
    let mut doc = Doc::square();
    doc.json["materials"] = json!([
        {
            "name": "Glow", "doubleSided": true, "alphaMode": "MASK", "emissiveFactor": [0.5, 0.25, 0],
            "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 7 },
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4 }, "KHR_materials_unlit": {} },
        },
        { "alphaMode": "MASK", "alphaCutoff": 0.75 },
        { "alphaMode": "BLEND" },
    ]);
    let scene = doc.scene();
    let glow = &scene.materials[0];
    assert_eq!((glow.name.as_str(), glow.double_sided, glow.unlit), ("Glow", true, true));
    assert_eq!(glow.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((glow.metallic, glow.roughness), (0.5, 1.0));
    assert_eq!(glow.emissive, Vec3::new(2.0, 1.0, 0.0));
    assert_eq!(glow.alpha, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(scene.materials[1].alpha, AlphaMode::Mask { cutoff: 0.75 });
    assert_eq!(scene.materials[2].alpha, AlphaMode::Blend);
    assert_eq!(scene.meshes[0].primitives[0].material, 3, "a primitive without material gets the default one");
    assert_eq!(scene.materials[3], pinwarp::scene::Material::default());
    assert_eq!(Doc::empty().scene().materials.len(), 1, "there is always a material");
    doc.primitive()["material"] = json!(3);
    assert!(doc.fault().contains("materials[3]"));
}

#[test]
fn lights_are_placed_by_their_nodes() {
    let mut doc = Doc::square();
    doc.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "color": [1, 0.5, 0], "intensity": 2 },
        { "type": "point", "range": 5 },
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
        { "type": "spot", "spot": {} },
        { "type": "spot", "spot": { "innerConeAngle": 9, "outerConeAngle": 0.5 } },
    ] } });
    let node = |light: usize| {
        json!({ "translation": [light, 0, 0], "rotation": [-0.5f32.sqrt(), 0.0, 0.0, 0.5f32.sqrt()],
            "extensions": { "KHR_lights_punctual": { "light": light } } })
    };
    doc.json["nodes"] = (0..5).map(node).collect();
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 2, 3, 4] }]);
    let lights = pose(&doc.scene(), ClipChoice::default(), 0.0).lights;
    assert_eq!(lights[0].color, Vec3::new(2.0, 1.0, 0.0));
    assert!((lights[0].direction.0 - Vec3::NEG_Y).length() < 1e-6, "{:?}", lights[0].direction);
    assert_eq!((lights[0].range, lights[1].range), (f32::INFINITY, 5.0));
    assert_eq!(lights[2].position.0, Vec3::X * 2.0);
    assert_eq!(lights[2].kind, LightKind::Spot { inner: 0.1, outer: 0.2 });
    assert_eq!(lights[3].kind, LightKind::Spot { inner: 0.0, outer: std::f32::consts::FRAC_PI_4 });
    assert_eq!(lights[4].kind, LightKind::Spot { inner: 0.5, outer: 0.5 }, "cones are kept in order");
    doc.json["nodes"][0] = node(9);
    assert!(doc.fault().contains("lights[9]"));
}
