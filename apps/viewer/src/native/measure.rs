//! How long one waits: from a move of the camera to its first picture, and from an input while refining to the frame that shows it.

use super::{Ending, Failed};
use crate::Viewer;
use egui::Context;
use std::{
    sync::{Arc, Mutex},
    thread,
    time::{Duration, Instant},
};

/// Moves that are timed, after some that are not.
const MOVES: usize = 30;
const UNTIMED: usize = 4;
/// Inputs that are timed.
const INPUTS: usize = 60;
/// Refining goes on for so long between moves, so that each interrupts work.
const BETWEEN: Duration = Duration::from_millis(700);
/// Nothing takes longer.
const PATIENCE: Duration = Duration::from_secs(240);

/// Shows the viewer and moves its camera.
pub(super) struct Measure {
    viewer: Viewer,
    begun: Instant,
    /// When the camera was moved, until its first picture is there.
    moved: Option<Instant>,
    next_move: Instant,
    moves: Vec<f64>,
    previews: Vec<[u64; 2]>,
    /// When something was put in, until a frame takes it up.
    input: Arc<Mutex<Option<Instant>>>,
    /// Seconds until the frame began; its own are known one frame later.
    waited: Option<f64>,
    inputs: Vec<f64>,
    ending: Ending,
}

impl Measure {
    pub(super) fn new(viewer: Viewer, ending: Ending) -> Self {
        let now = Instant::now();
        Self {
            viewer,
            begun: now,
            moved: None,
            next_move: now,
            moves: Vec::new(),
            previews: Vec::new(),
            input: Arc::default(),
            waited: None,
            inputs: Vec::new(),
            ending,
        }
    }

    fn end(&self, ctx: &Context, how: Result<String, Failed>) {
        if let Ok(mut ending) = self.ending.lock() {
            ending.get_or_insert(how);
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Notes the first picture of the last move.
    fn note_picture(&mut self) {
        if let Some(moved) = self.moved
            && let Some(size) = self.viewer.shows_present_view()
        {
            self.moves.push(moved.elapsed().as_secs_f64());
            self.previews.push(size.map(u64::from));
            (self.moved, self.next_move) = (None, Instant::now() + BETWEEN);
        }
    }

    /// Moves again when it is time.
    fn move_camera(&mut self) {
        let timed = self.moves.len() < MOVES + UNTIMED;
        if timed
            && self.moved.is_none()
            && self.viewer.shows_whole_picture()
            && Instant::now() >= self.next_move
        {
            self.viewer.orbit(0.02, 0.0);
            self.moved = Some(Instant::now());
        }
    }

    /// Times inputs once the moves are over: one is put in from another thread, at a moment of its own.
    fn time_inputs(&mut self, ctx: &Context, begun: Instant, frame_seconds: Option<f32>) {
        if let Some(waited) = self.waited.take()
            && let Some(own) = frame_seconds
        {
            self.inputs.push(waited + f64::from(own));
            if self.inputs.len() < INPUTS {
                self.put_in(ctx);
            }
        }
        let taken = self.input.lock().map(|mut input| input.take()).unwrap_or_default();
        if let Some(at) = taken {
            self.waited = Some(begun.saturating_duration_since(at).as_secs_f64());
            // The frame after this one knows how long this one took.
            ctx.request_repaint();
        }
    }

    fn put_in(&self, ctx: &Context) {
        let (input, ctx) = (Arc::clone(&self.input), ctx.clone());
        // Unlike any rhythm of frames or rounds.
        let pause = Duration::from_millis(40 + (self.inputs.len() as u64 * 37) % 90);
        thread::spawn(move || {
            thread::sleep(pause);
            if let Ok(mut place) = input.lock() {
                *place = Some(Instant::now());
            }
            ctx.request_repaint();
        });
    }

    fn told(&self) -> String {
        let [width, height] = self.previews.last().copied().unwrap_or_default();
        let [smallest, _] = self.previews.iter().min().copied().unwrap_or_default();
        format!(
            "{}\ncamera move to first picture: {}; the last of {width} x {height} pixels, the smallest {smallest} wide\n\
             input to frame while refining: {}",
            self.viewer.what_is_measured(),
            spread(&self.moves[UNTIMED.min(self.moves.len())..]),
            spread(&self.inputs),
        )
    }
}

/// Median and range, in milliseconds.
fn spread(seconds: &[f64]) -> String {
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.last() else { return "none".into() };
    let at = |share: f64| 1e3 * sorted[((sorted.len() - 1) as f64 * share).round() as usize];
    format!(
        "median {:.0} ms, 95 % within {:.0} ms, {:.0} to {:.0} ms, {} times",
        at(0.5),
        at(0.95),
        1e3 * sorted[0],
        1e3 * last,
        sorted.len()
    )
}

impl eframe::App for Measure {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let begun = Instant::now();
        let ctx = ui.ctx().clone();
        // As by the mouse: the frame that moves the camera is the one that asks for its picture.
        self.move_camera();
        self.viewer.show(ui);
        self.note_picture();
        if self.moves.len() >= MOVES + UNTIMED {
            if self.inputs.is_empty() && self.waited.is_none() && self.moved.is_none() {
                // The first input; the moves are over and refining goes on.
                self.moved = Some(begun);
                self.put_in(&ctx);
            }
            self.time_inputs(&ctx, begun, frame.info().cpu_usage);
        }
        if let Some(message) = self.viewer.scene_trouble() {
            self.end(&ctx, Err(Failed { code: 3, message }));
        } else if self.inputs.len() >= INPUTS {
            self.end(&ctx, Ok(self.told()));
        } else if self.begun.elapsed() > PATIENCE {
            self.end(&ctx, Err(Failed { code: 1, message: "it takes too long".into() }));
        }
        // What comes back wakes the window by itself; frames in between would take the processor from what is measured.
        if self.moves.len() < MOVES + UNTIMED && self.moved.is_none() {
            let wait = self.next_move.saturating_duration_since(Instant::now());
            ctx.request_repaint_after(wait.max(Duration::from_millis(2)));
        }
    }
}
