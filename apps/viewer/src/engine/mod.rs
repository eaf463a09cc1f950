//! The engine: takes orders, does the work in steps, and reports. It knows nothing of windows, threads or pages.
//!
//! ```text
//!            Order                         step()                          Report
//! window ---------------> Engine: scenes.rs (what is open and built) -------------> window
//!   newest wish counts    job.rs (the work on one wish: coarse, whole, better)
//!                         answers.rs (probe, boxes, truth, files)
//! ```
//!
//! Whoever runs it calls [`Engine::take`] with what came in and [`Engine::step`] while that says that there is more to do. A [`Stop`] tells it in
//! the middle of a step that something newer waits; all but the coarse picture then ends at once. Estimates are made by
//! [`conray::Session`], and on a page's device by `conray::gpu::Frames` (pictures.rs).

mod answers;
mod job;
mod order;
mod pace;
#[cfg(feature = "gpu")]
mod pictures;
mod planes;
mod report;
mod scenes;
mod stop;
pub mod wire;

pub use order::{NamedBytes, Order, Question, Source, Wish};
pub use report::{
    Boxes, Built, ConePlanes, Fault, Picture, Plane, Probe, ProbedCone, Report, SceneFacts, SidePicture,
    Trouble, Truth,
};
pub use stop::Stop;

use conray::{Budget, Control, Device, Refinement, Session, target::Target};
use job::{Job, Step};
use pace::Pace;
use scenes::{Held, stage_of};
use std::{
    collections::VecDeque,
    sync::atomic::{AtomicU64, Ordering},
};
use web_time::Instant;

/// Rays of a truth between two looks at what is newer.
const TRUTH_PASS: u32 = 64;

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
    truth: Option<TruthWork>,
    pace: Pace,
    /// True where answers of devices come later: then no session works on one.
    is_page: bool,
    /// A device's part, where there is one.
    #[cfg(feature = "gpu")]
    pictures: Option<pictures::Pictures>,
    /// Wishes for this are in vain: it is not there, or failed. It is asked for again once another place was wished for.
    #[cfg(feature = "gpu")]
    refused: Option<Device>,
    /// True once it was told that nothing is left to do.
    is_idle: bool,
}

/// A truth that is being found.
struct TruthWork {
    key: String,
    rays: u32,
    done: u32,
    session: Session,
    refinement: Refinement,
}

impl Engine {
    /// An engine that never waits for a device: pictures by method `hybrid` are asked for and come later, all else is the CPU's.
    pub fn of_page() -> Self {
        Self { is_page: true, ..Self::default() }
    }

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
            return self.truth_pass(stop, report);
        }
        self.refine(stop, report).await
    }

    /// Takes a wish up: what it needs is built, and the work on it begins.
    fn begin(&mut self, mut wish: Wish, report: &(dyn Fn(Report) + Sync)) -> Result<(), Trouble> {
        let wished = wish.device;
        if self.is_page {
            wish.device = Device::Cpu;
        }
        let Some(held) = self.held.as_mut().filter(|held| held.number == wish.scene) else { return Ok(()) };
        if wish.size.contains(&0) {
            // A window that is folded up: what was shown comes back with it.
            return Ok(());
        }
        let is_built = held.prepare(&wish, &told(report))?;
        wish.device = wished;
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
        if self.is_page && self.open_device(report).await {
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
        let work = job::Means {
            sessions: &held.sessions,
            #[cfg(feature = "gpu")]
            pictures: self.pictures.as_mut(),
        };
        match job.step(work, &mut self.pace, stop, &tell).await {
            Ok(Step::Picture(picture)) => report(Report::Picture(picture)),
            Ok(Step::Stopped) => {}
            Ok(Step::Done) => self.is_idle = true,
            Err(trouble) => {
                let wish = job.wish.clone();
                self.job = None;
                let on_device = held.places_on_devices() || self.has_device();
                if !(on_device && wish.device != Device::Cpu) {
                    return Err(trouble);
                }
                // A device that failed: the CPU goes on from the beginning.
                report(Report::Trouble(trouble));
                if let Some(held) = &mut self.held {
                    held.move_to_cpu()?;
                }
                self.drop_device(Some(wish.device));
                self.tell_built(report);
                report(Report::Notice("the CPU has taken over".into()));
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

    fn begin_truth(&mut self, key: String, rays: u32) -> Result<(), Trouble> {
        let (Some(held), Some(job)) = (&self.held, &self.job) else { return Ok(()) };
        let (Some(target), Some(session)) = (job.target(), held.sessions.first()) else {
            return Err(answers::request("there is no whole picture yet; try again in a moment"));
        };
        let settings = answers::truth_settings(&job.wish.sides[0], rays);
        let session =
            session.with(&settings, &held.options_now(), &|_| {}).map_err(|e| scenes::trouble_of(&e))?;
        let refinement = session.refinement(target);
        self.truth = Some(TruthWork { key, rays, done: 0, session, refinement });
        Ok(())
    }

    /// Some more rays of the truth.
    fn truth_pass(&mut self, stop: &Stop<'_>, report: &(dyn Fn(Report) + Sync)) -> Result<(), Trouble> {
        let (Some(work), Some(job)) = (&mut self.truth, &self.job) else { return Ok(()) };
        let Some(target) = job.target() else { return Ok(()) };
        let next = (work.done + TRUTH_PASS).min(work.rays);
        let progress = |_| {
            stop.is_set();
        };
        let control = Control { cancelled: stop.flag, progress: &progress };
        let ended = work.session.go_on(&mut work.refinement, target.points(), Budget::rays(next), control);
        if let Err(e) = ended {
            self.truth = None;
            return Err(scenes::trouble_of(&e));
        }
        if stop.is_set() {
            return Ok(());
        }
        work.done = next;
        report(Report::Busy("finding the truth".into(), Some(next as f32 / work.rays as f32)));
        // Shown when it has doubled, and at the end.
        if next == work.rays || (next / TRUTH_PASS).is_power_of_two() {
            let estimates = work.refinement.estimates();
            let rmse = work.refinement.expected_rmse();
            let truth = answers::truth_so_far(&work.key, target, &estimates, [next, work.rays], rmse);
            report(Report::Truth(truth));
        }
        if next == work.rays {
            self.truth = None;
        }
        Ok(())
    }
}

/// The device of a page.
#[cfg(feature = "gpu")]
impl Engine {
    /// Opens a device where one is wished for and not there; true where that changed anything. The first picture comes before: it does not wait for
    /// shaders.
    async fn open_device(&mut self, report: &(dyn Fn(Report) + Sync)) -> bool {
        let (Some(held), Some(job)) = (&self.held, &self.job) else { return false };
        let Some(session) = held.sessions.first() else { return false };
        let is_in_vain = self.refused == Some(job.wish.device) || self.pictures.is_some();
        if is_in_vain || !job.has_first_picture() || !pictures::are_wished(&job.wish) {
            return false;
        }
        report(Report::Busy("opening a graphics processor".into(), None));
        match pictures::Pictures::open(session, &job.wish).await {
            Ok(opened) => {
                self.pictures = Some(opened);
                self.tell_built(report);
            }
            Err(e) => {
                self.refused = Some(job.wish.device);
                let nothing = matches!(e, conray::gpu::GpuError::NoAdapter { wanted: None, .. });
                let why = if nothing { "there is no graphics processor".into() } else { e.to_string() };
                report(Report::Notice(format!("on the CPU: {why}")));
            }
        }
        true
    }

    /// Gives the device back where it is not wished for any more; true where that changed anything.
    fn leave_device(&mut self, wish: &Wish) -> bool {
        self.refused = self.refused.filter(|refused| *refused == wish.device);
        let is_other = self.pictures.as_ref().is_some_and(|pictures| !pictures.are_of(wish));
        is_other && self.pictures.take().is_some()
    }

    fn has_device(&self) -> bool {
        self.pictures.is_some()
    }

    /// Gives the device back; one that failed is not asked for again.
    fn drop_device(&mut self, failed: Option<Device>) {
        self.pictures = None;
        self.refused = failed;
    }

    /// What is built, and where pictures are made.
    fn tell_built(&self, report: &(dyn Fn(Report) + Sync)) {
        let Some(held) = &self.held else { return };
        let mut built = held.built();
        if let Some(pictures) = &self.pictures {
            let methods = held.sessions.iter().map(|session| session.plan().method);
            let of_device =
                built.places.iter_mut().zip(methods).filter(|(_, m)| *m == conray::Method::Hybrid);
            of_device.for_each(|(place, _)| *place = pictures.place());
        }
        report(Report::Built(built));
    }
}

#[cfg(not(feature = "gpu"))]
impl Engine {
    async fn open_device(&mut self, _: &(dyn Fn(Report) + Sync)) -> bool {
        false
    }

    fn leave_device(&mut self, _: &Wish) -> bool {
        false
    }

    fn has_device(&self) -> bool {
        false
    }

    fn drop_device(&mut self, _: Option<Device>) {}

    fn tell_built(&self, report: &(dyn Fn(Report) + Sync)) {
        if let Some(held) = &self.held {
            report(Report::Built(held.built()));
        }
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
