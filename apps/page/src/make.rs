//! From the sources to the folder of the page.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";
/// The viewer's program, and so the name of its files.
const VIEWER: &str = "conray-viewer";
/// Name of what wasm-bindgen writes.
const MODULE: &str = "conray_viewer";
/// Files that are as they are.
const FILES: [&str; 3] = ["index.html", "page.js", "worker.js"];

/// Builds the page into a folder.
pub(crate) fn page(out: &Path) -> Result<(), String> {
    let root = root()?;
    need_target()?;
    let module = build(&root)?;
    let package = out.join("pkg");
    fs::create_dir_all(&package).map_err(|e| format!("{}: {e}", package.display()))?;
    let mut bindgen = Bindgen::new();
    // Names of functions are a tenth of the module, and nobody reads them there.
    bindgen.remove_name_section(true).remove_producers_section(true);
    let web = bindgen.input_path(&module).out_name(MODULE).typescript(false).web(true);
    web.and_then(|bindgen| bindgen.generate(&package)).map_err(|e| format!("wasm-bindgen: {e:#}"))?;
    for file in FILES {
        let from = root.join("apps/page/web").join(file);
        fs::copy(&from, out.join(file)).map_err(|e| format!("{}: {e}", from.display()))?;
    }
    Ok(())
}

/// The workspace.
fn root() -> Result<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().map_err(|e| format!("the sources are not where they were built from: {e}"))
}

/// Has rustup fetch the target where it is not there.
fn need_target() -> Result<(), String> {
    let found = Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]).output();
    let folder = found.map_err(|e| format!("rustc cannot be run: {e}"))?.stdout;
    if Path::new(String::from_utf8_lossy(&folder).trim()).is_dir() {
        return Ok(());
    }
    let added = Command::new("rustup").args(["target", "add", TARGET]).status();
    match added {
        Ok(status) if status.success() => Ok(()),
        _ => {
            Err(format!("the target {TARGET} is not there, and rustup target add {TARGET} does not fetch it"))
        }
    }
}

/// Builds the module and says where it is.
fn build(root: &Path) -> Result<PathBuf, String> {
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    // Bundles of rays are as wide as the processor's vectors; every browser since 2021 has those of WebAssembly.
    let flags = format!("{} -C target-feature=+simd128", env::var("RUSTFLAGS").unwrap_or_default());
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(root).env("RUSTFLAGS", flags.trim());
    cargo.args(["build", "--release", "--bin", VIEWER, "-p", VIEWER, "--target", TARGET]);
    let status = cargo.status().map_err(|e| format!("cargo cannot be run: {e}"))?;
    if !status.success() {
        return Err("the viewer does not build; see above".into());
    }
    Ok(target.join(TARGET).join("release").join(format!("{VIEWER}.wasm")))
}
