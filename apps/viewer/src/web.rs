//! The page: starts the viewer on a canvas, reads what is dropped, hands files out.

use crate::{Start, Viewer, engine::NamedBytes, engine::Source, host::WorkerHost};
use conray::Device;
use eframe::{WebOptions, WebRunner};
use egui::DroppedFileHandle;
use js_sys::{Array, Function, Int32Array, Uint8Array};
use std::cell::RefCell;
use wasm_bindgen::{JsCast, JsValue, prelude::wasm_bindgen};
use web_sys::{Blob, HtmlAnchorElement, HtmlCanvasElement, Url};

thread_local! {
    static RUNNER: RefCell<Option<WebRunner>> = const { RefCell::new(None) };
    /// Files that were read since the last frame.
    static READ: RefCell<Vec<Result<NamedBytes, String>>> = const { RefCell::new(Vec::new()) };
}

/// Shows the viewer on a canvas. `make_worker` gives a new worker that runs the engine; `counter` is one number of memory that the page and
/// its workers share, where they may.
///
/// # Errors
/// Where the browser offers neither WebGPU nor WebGL.
#[wasm_bindgen]
pub async fn start(
    canvas: HtmlCanvasElement,
    make_worker: Function,
    counter: Option<Int32Array>,
    scene: Option<String>,
    device: Option<String>,
) -> Result<(), JsValue> {
    console_error_panic_hook::set_once();
    let runner = WebRunner::new();
    let mut start = Start { source: scene.map(Source::Builtin), ..Start::default() };
    start.choices.device = match device.as_deref() {
        Some("cpu") => Device::Cpu,
        Some("gpu") => Device::Gpu,
        _ => Device::Auto,
    };
    let create: eframe::AppCreator<'static> = Box::new(move |context| {
        let ctx = context.egui_ctx.clone();
        let host = WorkerHost::start(make_worker, counter, move || ctx.request_repaint());
        Ok(Box::new(Viewer::new(Box::new(host), start)))
    });
    runner.start(canvas, WebOptions::default(), create).await?;
    RUNNER.with(|place| *place.borrow_mut() = Some(runner));
    Ok(())
}

/// What is shown, as JSON: for tests.
#[wasm_bindgen]
pub fn facts() -> Option<String> {
    RUNNER.with(|runner| {
        let runner = runner.borrow();
        let viewer = runner.as_ref()?.app_mut::<Viewer>()?;
        Some(viewer.facts().to_string())
    })
}

/// Why the page's part stopped, if it did.
#[wasm_bindgen]
pub fn failure() -> Option<String> {
    RUNNER.with(|runner| runner.borrow().as_ref()?.panic_summary().map(|panic| panic.message()))
}

/// Reads dropped files; [`take_read`] has them later. Nothing leaves the machine.
pub(crate) fn read_dropped(files: Vec<DroppedFileHandle>, ctx: egui::Context) {
    wasm_bindgen_futures::spawn_local(async move {
        let mut read = Vec::new();
        for file in files {
            let name = file.path().to_string_lossy().into_owned();
            let bytes = file.bytes_async().await;
            read.push(match bytes {
                Ok(bytes) => Ok(NamedBytes { name, bytes: bytes.into() }),
                Err(e) => Err(format!("{name}: cannot be read: {e}")),
            });
        }
        // All at once: a scene and what belongs to it are one drop.
        READ.with(|place| place.borrow_mut().extend(read));
        ctx.request_repaint();
    });
}

/// The files that were read since the last call.
pub(crate) fn take_read() -> Vec<Result<NamedBytes, String>> {
    READ.with(|place| std::mem::take(&mut *place.borrow_mut()))
}

/// Hands a file to the browser, which saves it.
pub(crate) fn download(name: &str, bytes: &[u8]) -> Result<(), String> {
    let save = || -> Result<(), JsValue> {
        let blob = Blob::new_with_u8_array_sequence(&Array::of1(&Uint8Array::from(bytes)))?;
        let url = Url::create_object_url_with_blob(&blob)?;
        let document = web_sys::window().and_then(|window| window.document()).ok_or(JsValue::NULL)?;
        let link: HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
        link.set_href(&url);
        link.set_download(name);
        link.click();
        Url::revoke_object_url(&url)
    };
    save().map_err(|_| format!("{name}: the browser does not save it"))
}
