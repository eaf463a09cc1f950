//! The program `conray-viewer`; the page starts in the library.

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    conray_viewer::native::main()
}

#[cfg(target_arch = "wasm32")]
fn main() {}
