//! Writes the .glb files and figures of `scenes/`: `cargo run --example make_scenes`.

#[path = "mod.rs"]
mod make;

use anyhow::Context as _;
use std::path::Path;

fn main() -> anyhow::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for (name, bytes) in make::files().context("drawing a texture")? {
        let path = folder.join(name);
        std::fs::write(&path, &bytes).with_context(|| format!("writing {}", path.display()))?;
        println!("{name}: {} bytes", bytes.len());
    }
    for (name, text) in make::figures::files() {
        let path = folder.join(&name);
        std::fs::write(&path, &text).with_context(|| format!("writing {}", path.display()))?;
        println!("{name}: {} bytes", text.len());
    }
    Ok(())
}
