//! The program `conray-viewer`. For browsers it is the module that the page loads: what JavaScript calls is in the library.

#[cfg(target_arch = "wasm32")]
use conray_viewer as _;

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    conray_viewer::native::main()
}

#[cfg(target_arch = "wasm32")]
fn main() {}
