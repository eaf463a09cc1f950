//! The engine: takes orders, does the work in steps, and reports. It knows nothing of windows, threads or pages.
//!
//! ```text
//!            Order                         step()                          Report
//! window ---------------> Engine: scenes.rs (what is open and built) -------------> window
//!   newest wish counts    job.rs (the work on one wish: coarse, whole, better)
//!                         device.rs, pictures.rs (what a graphics processor does of it)
//!                         answers.rs (probe, boxes, files), truth.rs
//! ```
//!
//! Whoever runs it calls [`Engine::take`] with what came in and [`Engine::step`] while that says that there is more to do. A [`Stop`] tells it in
//! the middle of a step that something newer waits; all but the coarse picture then ends at once. Estimates are made by
//! [`conray::Session`] on the CPU, or on a device that answers later (pictures.rs): so the same code runs where nobody may wait for one.

mod answers;
mod device;
mod job;
mod order;
mod pace;
mod pictures;
mod planes;
mod report;
mod scenes;
mod side;
mod stop;
mod truth;
pub mod wire;

pub use order::{NamedBytes, Order, Question, Source, Wish};
pub use report::{
    Boxes, Built, ConePlanes, Fault, Picture, Plane, Probe, ProbedCone, Report, SceneFacts, SidePicture,
    Trouble, Truth,
};
pub use stop::Stop;

use job::{Job, Step};
use pace::Pace;
use scenes::{Held, stage_of};
use std::{
    collections::VecDeque,
    sync::atomic::{AtomicU64, Ordering},
};
use web_time::Instant;

/// Milliseconds between two words on how far a round is.
const TELL_MS: u64 = 120;

/// Works on the newest wish.
#[derive(Default)]
pub struct Engine {
    held: Option<Held>,
    opening: Option<(u64, Source)>,
    wish: Option<Wish>,
    job: Option<Job>,
    questions: VecDeque<Question>,
    truth: Option<truth::TruthWork>,
    pace: Pace,
    /// A device's part, where there is one.
    pictures: Option<pictures::Pictures>,
    /// Wishes for this are in vain: it is not there, or failed, or takes no octree. It is asked for again once another place was wished for.
    refused: Option<device::Refused>,
    /// True once it was told that nothing is left to do.
    is_idle: bool,
}

impl Engine {
    /// Takes an order; the work is done by the next steps.
    pub fn take(&mut self, order: Order) {
        match order {
            Order::Open(number, source) => self.opening = Some((number, source)),
            Order::Wish(wish) => self.wish = Some(*wish),
            Order::Ask(Question::StopTruth) => self.truth = None,
            Order::Ask(question) => self.questions.push_back(question),
        }
        self.is_idle = false;
    }

    /// Does a piece of work and reports what came of it; false once nothing is left to do.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn step(&mut self, stop: &Stop<'_>, report: &(dyn Fn(Report) + Sync)) -> bool {
        pollster::block_on(self.step_later(stop, report))
    }

    /// The same as a future.
    pub async fn step_later(&mut self, stop: &Stop<'_>, report: &(dyn Fn(Report) + Sync)) -> bool {
        if let Err(trouble) = self.try_step(stop, report).await {
            report(Report::Trouble(trouble));
        }
        if self.is_idle {
            report(Report::Idle);
        }
        !self.is_idle
    }

    async fn try_step(&mut self, stop: &Stop<'_>, report: &(dyn Fn(Report) + Sync)) -> Result<(), Trouble> {
        if let Some((number, source)) = self.opening.take() {
            report(Report::Busy(format!("reading {}", source.word()), None));
            let (held, facts) = Held::open(number, source)?;
            // From here on the former scene is gone; its picture is the window's.
            (self.held, self.job, self.truth) = (Some(held), None, None);
            (self.wish, self.pace) = (None, Pace::default());
            self.drop_device(None);
            report(Report::Scene(facts));
            return Ok(());
        }
        if let Some(wish) = self.wish.take() {
            return self.begin(wish, report);
        }
        if let Some(question) = self.questions.pop_front() {
            return self.answer(question, report);
        }
        if self.truth.is_some() {
            return self.truth_pass(stop, report).await;
        }
        self.refine(stop, report).await
    }

    /// Takes a wish up: what it needs is built, and the work on it begins.
    fn begin(&mut self, wish: Wish, report: &(dyn Fn(Report) + Sync)) -> Result<(), Trouble> {
        let Some(held) = self.held.as_mut().filter(|held| held.number == wish.scene) else { return Ok(()) };
        if wish.size.contains(&0) {
            // A window that is folded up: what was shown comes back with it.
            return Ok(());
        }
        let is_built = held.prepare(&wish, &told(report))?;
        if self.leave_device(&wish) || is_built {
            self.pace = Pace::default();
            self.tell_built(report);
        }
        self.truth = None;
        self.job = Some(Job::new(wish));
        Ok(())
    }

    /// Makes the picture better.
    async fn refine(&mut self, stop: &Stop<'_>, report: &(dyn Fn(Report) + Sync)) -> Result<(), Trouble> {
        if self.open_device(report).await {
            return Ok(());
        }
        let (Some(held), Some(job)) = (&mut self.held, &mut self.job) else {
            self.is_idle = true;
            return Ok(());
        };
        // Each word wakes the window: seldom is enough.
        let (begun, told) = (Instant::now(), AtomicU64::new(0));
        let tell = |share| {
            let now = begun.elapsed().as_millis() as u64;
            if now >= TELL_MS + told.load(Ordering::Relaxed) {
                told.store(now, Ordering::Relaxed);
                report(Report::Busy("refining".into(), Some(share)));
            }
        };
        let work = job::Means { sessions: &held.sessions, pictures: self.pictures.as_mut() };
        match job.step(work, &mut self.pace, stop, &tell).await {
            Ok(Step::Picture(picture)) => report(Report::Picture(picture)),
            Ok(Step::Stopped) => {}
            Ok(Step::Done) => self.is_idle = true,
            Err(trouble) => {
                let wish = job.wish.clone();
                self.job = None;
                self.take_over(wish.device, trouble, report)?;
                // From the beginning.
                self.job = Some(Job::new(wish));
            }
        }
        Ok(())
    }

    fn answer(&mut self, question: Question, report: &(dyn Fn(Report) + Sync)) -> Result<(), Trouble> {
        if let Question::ReadExr { key, source } = question {
            report(Report::Truth(answers::truth_of_exr(key, &source)?));
            return Ok(());
        }
        let (Some(held), Some(job)) = (&mut self.held, &self.job) else {
            return Err(answers::request("there is no picture yet; try again in a moment"));
        };
        match question {
            Question::Probe { pixel, side } => {
                let probe = answers::probe(held, &job.wish, pixel, side)?;
                report(Report::Probe(probe.map(Box::new)));
            }
            Question::Boxes { level } => {
                let (is_built, boxes) = (held.need_octree(&told(report))?, answers::boxes(held, job, level));
                if is_built {
                    self.tell_built(report);
                }
                if let Some(boxes) = boxes {
                    report(Report::Boxes(boxes));
                }
            }
            Question::Truth { key, rays } => self.begin_truth(key, rays)?,
            Question::Exr { side, path } => {
                let (layers, attributes) = answers::layers(held, job, side, &held.word())?;
                match path {
                    Some(path) => {
                        let written = conray::target::write_exr(&path, &layers, &attributes);
                        written.map_err(|e| scenes::trouble_of(&e.into()))?;
                        report(Report::Written(path));
                    }
                    None => {
                        let bytes = conray::target::encode_exr(&layers, &attributes);
                        let bytes = bytes.map_err(|e| scenes::trouble_of(&e.into()))?;
                        report(Report::Bytes("conray.exr".into(), bytes));
                    }
                }
            }
            Question::StopTruth | Question::ReadExr { .. } => {}
        }
        Ok(())
    }
}

/// Passes on what a build tells.
fn told(report: &(dyn Fn(Report) + Sync)) -> impl Fn(conray::Event) + Sync {
    move |event| {
        if let conray::Event::Warning { message } = &event {
            report(Report::Notice(message.clone()));
        }
        if let Some(stage) = stage_of(&event) {
            report(Report::Busy(stage, None));
        }
    }
}
