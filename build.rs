//! Compiles `shaders/*.wgsl` to SPIR-V with naga, once for every variant that the Vulkan raster uses.
//!
//! In: the WGSL files. Out: `$OUT_DIR/<variant>.spv`, and `$OUT_DIR/shaders.rs`, a table of the modules by name.

use naga::back::spv;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::{env, fs};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// A SPIR-V module to write: an entry point with values for its overrides.
struct Variant {
    name: String,
    stage: ShaderStage,
    entry: &'static str,
    overrides: Vec<(&'static str, f64)>,
}

fn main() -> Outcome<()> {
    println!("cargo:rerun-if-changed=shaders");
    println!("cargo:rerun-if-changed=build.rs");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let mut table = String::from("pub(super) static SHADERS: &[(&str, &[u8])] = &[\n");
    let sources = [
        (&["shading.wgsl", "geometry.wgsl"][..], geometry_variants()),
        (&["resolve.wgsl"], resolve_variants()),
        (&["remap.wgsl"], remap_variants()),
    ];
    for (files, variants) in &sources {
        let (module, info) = parse(files)?;
        for variant in variants {
            let words = compile(&module, &info, variant)?;
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            fs::write(out.join(&variant.name).with_extension("spv"), bytes)?;
            writeln!(table, "    (\"{0}\", include_bytes!(\"{0}.spv\")),", variant.name)?;
        }
    }
    table.push_str("];\n");
    fs::write(out.join("shaders.rs"), table)?;
    Ok(())
}

/// The vertex stage, and a fragment stage for each combination of alpha mode, set of textures and shading, such as
/// `beauty_2_0_lit`.
fn geometry_variants() -> Vec<Variant> {
    let mut variants =
        vec![Variant { name: "vertex".into(), stage: ShaderStage::Vertex, entry: "vertex", overrides: Vec::new() }];
    for entry in ["beauty", "data", "both"] {
        for alpha in 0..3 {
            // Blended surfaces never write colour and data in one pass, because order and depth test differ.
            if entry == "both" && alpha == 2 {
                continue;
            }
            for textures in 0..3 {
                variants.push(fragment(entry, (alpha, textures), false));
                if entry != "data" {
                    variants.push(fragment(entry, (alpha, textures), true));
                }
            }
        }
    }
    variants
}

fn fragment(entry: &'static str, (alpha, textures): (u8, u8), is_unlit: bool) -> Variant {
    let shading = if is_unlit { "unlit" } else { "lit" };
    Variant {
        name: format!("{entry}_{alpha}_{textures}_{shading}"),
        stage: ShaderStage::Fragment,
        entry,
        overrides: vec![
            ("ALPHA", f64::from(alpha)),
            ("TEXTURES", f64::from(textures)),
            ("UNLIT", f64::from(u8::from(is_unlit))),
        ],
    }
}

fn resolve_variants() -> Vec<Variant> {
    let variant = |name: &str, stage, entry| Variant { name: name.into(), stage, entry, overrides: Vec::new() };
    vec![variant("resolve_vertex", ShaderStage::Vertex, "vertex"), variant("resolve", ShaderStage::Fragment, "resolve")]
}

/// A compute entry for each filter of plates, such as `remap_ewa`.
fn remap_variants() -> Vec<Variant> {
    let variant =
        |entry| Variant { name: format!("remap_{entry}"), stage: ShaderStage::Compute, entry, overrides: Vec::new() };
    ["ewa", "cubic", "lanczos", "nearest"].map(variant).into()
}

/// Reads, concatenates and validates WGSL files.
fn parse(files: &[&str]) -> Outcome<(Module, ModuleInfo)> {
    let mut source = String::new();
    for file in files {
        source.push_str(&fs::read_to_string(PathBuf::from("shaders").join(file))?);
    }
    let module = naga::front::wgsl::parse_str(&source).map_err(|error| error.emit_to_string(&source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::IMMEDIATES);
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(&source))?;
    Ok((module, info))
}

fn compile(module: &Module, info: &ModuleInfo, variant: &Variant) -> Outcome<Vec<u32>> {
    let constants = variant.overrides.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let entry = Some((variant.stage, variant.entry));
    let (module, info) = naga::back::pipeline_constants::process_overrides(module, info, entry, &constants)?;
    let options = spv::Options {
        lang_version: (1, 3),
        // No ADJUST_COORDINATE_SPACE: geometry.wgsl outputs Vulkan's y-down clip coordinates itself.
        // No CLAMP_FRAG_DEPTH: no shader writes depth.
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::DEBUG,
        fake_missing_bindings: false,
        // All loops have bounded trip counts: lights, filter taps, and samples of a footprint, whose size is clamped.
        force_loop_bounding: false,
        binding_map: binding_map(&module),
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage: variant.stage, entry_point: variant.entry.into() };
    Ok(spv::write_vec(&module, &info, &options, Some(&pipeline))?)
}

/// Maps WGSL's groups and bindings to equal descriptor sets and bindings.
fn binding_map(module: &Module) -> spv::BindingMap {
    let bindings = module.global_variables.iter().filter_map(|(_, variable)| variable.binding);
    bindings
        .map(|at| (at, spv::BindingInfo { descriptor_set: at.group, binding: at.binding, binding_array_size: None }))
        .collect()
}
