//! The engine in a worker of a page: messages are bytes, and a shared counter tells the worker in the middle of its work that something newer waits.

use super::Host;
use crate::engine::{
    Engine, Fault, Order, Report, Stop, Trouble,
    wire::{pack, unpack},
};
use js_sys::{Atomics, Function, Int32Array, Uint8Array};
use std::{cell::RefCell, rc::Rc, sync::atomic::AtomicBool};
use wasm_bindgen::{JsCast, JsValue, closure::Closure, prelude::wasm_bindgen};
use web_sys::{ErrorEvent, MessageEvent, Worker};

/// The page's end.
pub struct WorkerHost {
    state: Rc<State>,
}

struct State {
    /// Makes another worker, where one has failed.
    make: Function,
    worker: RefCell<Option<Worker>>,
    /// Counts orders, in memory that page and worker share; `None` where the page may share none.
    counter: Option<Int32Array>,
    reports: RefCell<Vec<Report>>,
    wake: Box<dyn Fn()>,
}

impl WorkerHost {
    /// Starts a worker by the page's function `make`; `wake` is called when reports have come in.
    pub fn start(make: Function, counter: Option<Int32Array>, wake: impl Fn() + 'static) -> Self {
        let (worker, reports) = (RefCell::default(), RefCell::default());
        let state = Rc::new(State { make, worker, counter, reports, wake: Box::new(wake) });
        State::start_worker(&state);
        Self { state }
    }
}

impl State {
    fn start_worker(self: &Rc<Self>) {
        let made = self.make.call0(&JsValue::NULL).ok().and_then(|worker| worker.dyn_into::<Worker>().ok());
        let Some(worker) = made else {
            return self.tell(trouble("the page can start no worker".into()));
        };
        let state = Rc::clone(self);
        let message = Closure::<dyn FnMut(MessageEvent)>::new(move |event: MessageEvent| {
            let bytes = Uint8Array::new(&event.data()).to_vec();
            state.tell(unpack(&bytes).unwrap_or_else(|e| trouble(format!("a message cannot be read: {e}"))));
        });
        worker.set_onmessage(Some(message.as_ref().unchecked_ref()));
        let state = Rc::clone(self);
        let error = Closure::<dyn FnMut(ErrorEvent)>::new(move |event: ErrorEvent| {
            event.prevent_default();
            let said = event.message();
            state
                .tell(trouble(format!("the work failed, maybe for want of memory, and begins anew: {said}")));
            if let Some(worker) = state.worker.take() {
                worker.terminate();
            }
            State::start_worker(&state);
            state.tell(Report::Lost);
        });
        worker.set_onerror(Some(error.as_ref().unchecked_ref()));
        // Both live as long as the page.
        message.forget();
        error.forget();
        *self.worker.borrow_mut() = Some(worker);
    }

    fn tell(&self, report: Report) {
        self.reports.borrow_mut().push(report);
        (self.wake)();
    }
}

fn trouble(message: String) -> Report {
    Report::Trouble(Trouble { fault: Fault::Work, message, scene: None })
}

impl Host for WorkerHost {
    fn order(&self, order: Order) {
        let worker = self.state.worker.borrow();
        let Some(worker) = worker.as_ref() else { return };
        match pack(&order) {
            Ok(bytes) => {
                let bytes = Uint8Array::from(&bytes[..]);
                let transfer = js_sys::Array::of1(&bytes.buffer());
                if worker.post_message_with_transfer(&bytes.buffer(), &transfer).is_ok()
                    && let Some(counter) = &self.state.counter
                {
                    // Nothing more can be done where the memory is not there: then the worker looks up less often.
                    let _ = Atomics::add(counter, 0, 1);
                }
            }
            Err(e) => self.state.tell(trouble(format!("a message cannot be sent: {e}"))),
        }
    }

    fn reports(&self) -> Vec<Report> {
        std::mem::take(&mut *self.state.reports.borrow_mut())
    }
}

#[allow(unsafe_code, reason = "declarations of what JavaScript gives, written out by wasm-bindgen")]
mod outside {
    use super::wasm_bindgen;

    #[wasm_bindgen]
    extern "C" {
        /// Posts a message's bytes to the page.
        #[wasm_bindgen(js_name = conray_post)]
        pub(super) fn post(bytes: Vec<u8>);

        /// Whether an order waits.
        #[wasm_bindgen(js_name = conray_is_newer)]
        pub(super) fn is_newer() -> bool;
    }
}

/// The worker's end: `worker.js` calls it.
#[wasm_bindgen]
pub struct WorkerEngine {
    engine: Engine,
}

#[wasm_bindgen]
impl WorkerEngine {
    /// An engine without a scene.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::new_without_default, reason = "for JavaScript")]
    pub fn new() -> Self {
        console_error_panic_hook::set_once();
        Self { engine: Engine::default() }
    }

    /// Takes an order's bytes.
    pub fn take(&mut self, bytes: &[u8]) {
        match unpack(bytes) {
            Ok(order) => self.engine.take(order),
            Err(e) => report(trouble(format!("an order cannot be read: {e}"))),
        }
    }

    /// Does a piece of work; false once nothing is left to do. No order may be taken before it is done.
    pub async fn step(&mut self) -> bool {
        let flag = AtomicBool::new(false);
        self.engine.step_later(&Stop { flag: &flag, poll: &outside::is_newer }, &report).await
    }
}

fn report(report: Report) {
    if let Ok(bytes) = pack(&report) {
        outside::post(bytes);
    }
}
