//! The engine on a thread of its own.

use super::Host;
use crate::engine::{Engine, Fault, Order, Report, Stop, Trouble};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread::JoinHandle,
};

/// Runs an engine on a thread until it is dropped.
pub struct ThreadHost {
    orders: Option<Sender<Order>>,
    reports: Arc<Mutex<Vec<Report>>>,
    /// Set while an order waits.
    newer: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl ThreadHost {
    /// Starts the thread; `wake` is called from it when reports have come in.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (orders, inbox) = channel();
        let (reports, newer) = (Arc::<Mutex<Vec<Report>>>::default(), Arc::<AtomicBool>::default());
        let (outbox, flag) = (Arc::clone(&reports), Arc::clone(&newer));
        let report = move |report| {
            if let Ok(mut all) = outbox.lock() {
                keep(&mut all, report);
            }
            wake();
        };
        let thread = std::thread::Builder::new().name("engine".into());
        let thread = thread.spawn(move || run(&inbox, &flag, &report)).ok();
        Self { orders: Some(orders), reports, newer, thread }
    }
}

/// Adds a report; of progress and pictures only the newest counts.
fn keep(all: &mut Vec<Report>, report: Report) {
    match report {
        Report::Busy(..) => all.retain(|r| !matches!(r, Report::Busy(..))),
        // A first picture is kept, so that none is missed by those who measure.
        Report::Picture(_) if all.len() > 64 => all.retain(|r| !matches!(r, Report::Picture(_))),
        _ => {}
    }
    all.push(report);
}

impl Host for ThreadHost {
    fn order(&self, order: Order) {
        if let Some(orders) = &self.orders
            && orders.send(order).is_ok()
        {
            self.newer.store(true, Ordering::Relaxed);
        }
    }

    fn reports(&self) -> Vec<Report> {
        self.reports.lock().map(|mut all| std::mem::take(&mut *all)).unwrap_or_default()
    }
}

impl Drop for ThreadHost {
    fn drop(&mut self) {
        self.orders = None;
        self.newer.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that failed has said so.
            let _ = thread.join();
        }
    }
}

/// Works on orders until nobody is left to give any.
fn run(inbox: &Receiver<Order>, newer: &AtomicBool, report: &(dyn Fn(Report) + Sync)) {
    let mut engine = Engine::default();
    let mut has_more = false;
    loop {
        // The flag goes down before the orders are looked at: one that comes in later raises it again.
        newer.store(false, Ordering::Relaxed);
        let mut waiting = Vec::new();
        if !has_more {
            match inbox.recv() {
                Ok(order) => waiting.push(order),
                Err(_) => return,
            }
        }
        loop {
            match inbox.try_recv() {
                Ok(order) => waiting.push(order),
                Err(std::sync::mpsc::TryRecvError::Empty) => break,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => return,
            }
        }
        waiting.into_iter().for_each(|order| engine.take(order));
        let stop = Stop { flag: newer, poll: &|| false };
        match catch_unwind(AssertUnwindSafe(|| engine.step(&stop, report))) {
            Ok(more) => has_more = more,
            Err(panic) => {
                let said = panic.downcast_ref::<String>().map(String::as_str);
                let said = said.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no reason");
                let message = format!("the work failed and begins anew with the next change: {said}");
                report(Report::Trouble(Trouble { fault: Fault::Work, message, scene: None }));
                report(Report::Lost);
                (engine, has_more) = (Engine::default(), false);
            }
        }
    }
}
