//! Material extensions that this program does not shade: the nearest metallic-roughness material takes their place.
//!
//! In: the JSON of a file. Out: the same JSON with materials that the typed reader understands.

use serde_json::{Value, json};

/// Reflectance of dielectrics at normal incidence.
const DIELECTRIC: f64 = 0.04;

/// How much of a fully transmissive surface stays visible: its reflections.
const TRANSMISSIVE_COVERAGE: f64 = 0.15;

/// Extensions outside the materials that only change shading, or nothing that is drawn.
const SHADING_ONLY: [&str; 5] =
    ["EXT_lights_ies", "EXT_lights_image_based", "KHR_lights_ies", "KHR_xmp", "KHR_xmp_json_ld"];

/// Whether a scene without the extension has the same geometry and motion, shaded differently: `KHR_materials_sheen`.
pub(super) fn only_changes_shading(extension: &str) -> bool {
    let is_of_materials = extension.split_once('_').is_some_and(|(_, rest)| rest.starts_with("materials_"));
    is_of_materials || SHADING_ONLY.contains(&extension)
}

/// Rewrites the materials of a file. Runs before foreign extensions are stripped.
pub(super) fn materials(root: &mut Value) {
    for material in root.get_mut("materials").and_then(Value::as_array_mut).into_iter().flatten() {
        let extension = |name: &str| material.pointer(&format!("/extensions/{name}")).cloned();
        let glossy = extension("KHR_materials_pbrSpecularGlossiness").filter(Value::is_object);
        let transmission = extension("KHR_materials_transmission").filter(Value::is_object);
        // A file may bring its own approximation.
        if let (Some(glossy), None) = (glossy, material.get("pbrMetallicRoughness")) {
            material["pbrMetallicRoughness"] = metallic_roughness(&glossy);
        }
        if let Some(transmission) = transmission {
            thin_out(material, &transmission);
        }
    }
}

/// The metallic-roughness parameters of a specular-glossiness material.
fn metallic_roughness(glossy: &Value) -> Value {
    let color = |key: &str, count: usize| -> Vec<f64> {
        let stored: Vec<f64> = glossy[key].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        if stored.len() == count { stored } else { vec![1.0; count] }
    };
    let glossiness = glossy["glossinessFactor"].as_f64().unwrap_or(1.0).clamp(0.0, 1.0);
    let (mut base, specular) = (color("diffuseFactor", 4), color("specularFactor", 3));
    // Factors say little where a texture scales them: then the surface counts as a half-glossy dielectric.
    let is_textured = glossy.get("specularGlossinessTexture").is_some_and(|texture| !texture.is_null());
    let metallic = if is_textured { 0.0 } else { metallic(&base, &specular) };
    let roughness = 1.0 - if is_textured { 0.5 * glossiness } else { glossiness };
    for (base, specular) in base.iter_mut().zip(&specular) {
        *base += (specular - *base) * metallic;
    }
    let mut approximated = json!({ "baseColorFactor": base, "metallicFactor": metallic, "roughnessFactor": roughness });
    if let Some(texture) = glossy.get("diffuseTexture").filter(|texture| texture.is_object()) {
        approximated["baseColorTexture"] = texture.clone();
    }
    approximated
}

/// How metallic a surface of these colours is: the metallic factor at which a metallic-roughness material reflects as brightly.
/// It solves diffuse = base (1 − metallic) (1 − F0) and specular = F0 (1 − metallic) + base · metallic for metallic.
fn metallic(diffuse: &[f64], specular: &[f64]) -> f64 {
    let brightness =
        |color: &[f64]| (0.299 * color[0].powi(2) + 0.587 * color[1].powi(2) + 0.114 * color[2].powi(2)).sqrt();
    let (diffuse, bright) = (brightness(diffuse), brightness(specular));
    if bright <= DIELECTRIC {
        return 0.0;
    }
    let strongest = specular.iter().copied().fold(0.0, f64::max);
    let b = diffuse * (1.0 - strongest) / (1.0 - DIELECTRIC) + bright - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - bright;
    let root = (b * b - 4.0 * DIELECTRIC * c).max(0.0).sqrt();
    ((root - b) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
}

/// Lets what is behind a transmissive surface show through. Where a texture says which parts transmit, all stay opaque.
fn thin_out(material: &mut Value, transmission: &Value) {
    let factor = transmission["transmissionFactor"].as_f64().unwrap_or(0.0).clamp(0.0, 1.0);
    let is_textured = transmission.get("transmissionTexture").is_some_and(Value::is_object);
    let is_opaque = material.get("alphaMode").and_then(Value::as_str).is_none_or(|mode| mode == "OPAQUE");
    if factor == 0.0 || is_textured || !is_opaque || !material.is_object() {
        return;
    }
    if !material["pbrMetallicRoughness"].is_object() {
        material["pbrMetallicRoughness"] = json!({});
    }
    let surface = &mut material["pbrMetallicRoughness"];
    let color: Vec<f64> =
        surface["baseColorFactor"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    let [r, g, b] = if color.len() == 4 { [color[0], color[1], color[2]] } else { [1.0; 3] };
    // The alpha of an opaque material is ignored, so it is replaced.
    surface["baseColorFactor"] = json!([r, g, b, 1.0 - (1.0 - TRANSMISSIVE_COVERAGE) * factor]);
    material["alphaMode"] = json!("BLEND");
}
