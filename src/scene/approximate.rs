//! Approximates unsupported material extensions by the nearest metallic-roughness material.
//!
//! In: the JSON of a file. Out: the same JSON with materials that the typed reader understands.

use serde_json::{Value, json};

/// Reflectance of dielectrics at normal incidence.
const DIELECTRIC: f64 = 0.04;

/// Opacity of a fully transmissive surface: what remains of it is its reflections.
const TRANSMISSIVE_COVERAGE: f64 = 0.15;

/// Extensions outside materials that affect only shading, or nothing visible.
const SHADING_ONLY: [&str; 5] =
    ["EXT_lights_ies", "EXT_lights_image_based", "KHR_lights_ies", "KHR_xmp", "KHR_xmp_json_ld"];

/// Returns whether a scene without the extension has the same geometry and motion, with different shading, as for
/// `KHR_materials_sheen`.
pub(super) fn only_changes_shading(extension: &str) -> bool {
    let is_of_materials = extension.split_once('_').is_some_and(|(_, rest)| rest.starts_with("materials_"));
    is_of_materials || SHADING_ONLY.contains(&extension)
}

/// Rewrites the materials of a file. Must run before unsupported extensions are stripped.
pub(super) fn materials(root: &mut Value) {
    for material in root.get_mut("materials").and_then(Value::as_array_mut).into_iter().flatten() {
        let extension = |name: &str| material.pointer(&format!("/extensions/{name}")).cloned();
        let glossy = extension("KHR_materials_pbrSpecularGlossiness").filter(Value::is_object);
        let transmission = extension("KHR_materials_transmission").filter(Value::is_object);
        // A file may provide its own fallback.
        if let (Some(glossy), None) = (glossy, material.get("pbrMetallicRoughness")) {
            material["pbrMetallicRoughness"] = metallic_roughness(&glossy);
        }
        if let Some(transmission) = transmission {
            thin_out(material, &transmission);
        }
    }
}

/// Converts a specular-glossiness material to metallic-roughness parameters.
fn metallic_roughness(glossy: &Value) -> Value {
    let color = |key: &str, count: usize| -> Vec<f64> {
        let stored: Vec<f64> = glossy[key].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        if stored.len() == count { stored } else { vec![1.0; count] }
    };
    let glossiness = glossy["glossinessFactor"].as_f64().unwrap_or(1.0).clamp(0.0, 1.0);
    let (mut base, specular) = (color("diffuseFactor", 4), color("specularFactor", 3));
    // Factors say little if a texture scales them: the surface is then treated as a half-glossy dielectric.
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

/// Returns the metallic factor at which a metallic-roughness material reflects as brightly as one of these colours. It
/// solves diffuse = base (1 − metallic) (1 − F0) and specular = F0 (1 − metallic) + base · metallic for metallic.
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

/// Makes a transmissive surface partly transparent. If a texture modulates the transmission, the surface stays opaque.
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
    // The alpha of an opaque material is ignored by the format, so it may be replaced.
    surface["baseColorFactor"] = json!([r, g, b, 1.0 - (1.0 - TRANSMISSIVE_COVERAGE) * factor]);
    material["alphaMode"] = json!("BLEND");
}
