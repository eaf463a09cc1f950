//! The work on one wish: a coarse picture at once, then all pixels, then better and better ones.
//!
//! ```text
//! few pixels, few rays -> Picture   (never interrupted: it is there within a tenth of a second)
//! all pixels, few rays -> Picture
//! side after side, twice as many rays -> Picture ... until each has what it was to reach
//! ```
use super::{
    Picture, SidePicture, Stop, Trouble, Wish,
    pace::Pace,
    pictures::Pictures,
    planes,
    scenes::trouble_of,
    side::{Side, side_picture},
};
use conray::{
    Budget, Control, Ended, Estimate, Method, Session,
    target::{Camera, CameraTarget, Target},
};
use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};
use web_time::Instant;

/// Rays a pixel of the first, coarse picture.
const COARSE_RAYS: u32 = 4;

/// What a step came to.
pub(super) enum Step {
    /// A better picture.
    Picture(Box<Picture>),
    /// Something newer waits; nothing to show.
    Stopped,
    /// All sides are as good as they were to be.
    Done,
}

/// The work on one wish.
pub(super) struct Job {
    pub(super) wish: Wish,
    start: Instant,
    coarse_done: bool,
    /// What all pixels see, once traced.
    target: Option<CameraTarget>,
    facing: planes::Facing,
    sides: Vec<Side>,
}

/// What the work is done with.
pub(super) struct Means<'a> {
    /// One a side.
    pub(super) sessions: &'a [Session],
    /// A device whose answers come later.
    pub(super) pictures: Option<&'a mut Pictures>,
}

impl Job {
    pub(super) fn new(wish: Wish) -> Self {
        let sides = wish.sides.iter().map(|_| Side::new()).collect();
        let facing = planes::Facing::default();
        Self { wish, start: Instant::now(), coarse_done: false, target: None, facing, sides }
    }

    /// The next piece of work.
    pub(super) async fn step(
        &mut self,
        means: Means<'_>,
        pace: &mut Pace,
        stop: &Stop<'_>,
        tell: &(dyn Fn(f32) + Sync),
    ) -> Result<Step, Trouble> {
        let Means { sessions, mut pictures } = means;
        if !self.coarse_done {
            return self.coarse(sessions, pace);
        }
        // A device sees for itself: its first pictures come before the points that the CPU knows.
        if let Some(pictures) = &mut pictures
            && let Some(index) = self.not_yet_drawn(sessions, pictures)
        {
            return self.draw(index, &sessions[index], pictures).await;
        }
        if self.target.is_none() && !self.trace(sessions, stop)? {
            return Ok(Step::Stopped);
        }
        // The side that had the least time is next; of those that had as much, the first.
        let open = self.sides.iter().enumerate().filter(|(_, side)| side.ended.is_none());
        let next = open.min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds)).map(|(index, _)| index);
        let (Some(index), Some(target)) = (next, &self.target) else { return Ok(Step::Done) };
        let session = &sessions[index];
        if let Some(pictures) = &mut pictures
            && pictures.draw_for(session)
        {
            return self.draw(index, session, pictures).await;
        }
        let on = pictures.as_deref().filter(|pictures| pictures.serve(session)).map(Pictures::backend);
        let grew = self.sides[index].go_on(on, session, target, stop, tell).await?;
        if !grew {
            return Ok(Step::Stopped);
        }
        let wish = &self.wish;
        self.sides[index].picture = self.sides[index].picture_of(session, target, wish.size);
        Ok(self.whole())
    }

    /// A picture has all its sides; before that, the coarse one stays.
    fn whole(&self) -> Step {
        let whole = self.sides.iter().map(|side| side.picture.clone()).collect::<Option<Vec<_>>>();
        whole.map_or(Step::Stopped, |sides| {
            Step::Picture(Box::new(self.picture(self.wish.size, self.facing.plane.clone(), sides)))
        })
    }

    /// The first picture, of fewer pixels.
    fn coarse(&mut self, sessions: &[Session], pace: &mut Pace) -> Result<Step, Trouble> {
        let start = Instant::now();
        let [width, height] = self.wish.size;
        let divisor = pace.divisor(u64::from(width) * u64::from(height));
        let size = [width.div_ceil(divisor), height.div_ceil(divisor)];
        let Some(first) = sessions.first() else { return Ok(Step::Done) };
        let view = self.wish.look.view("view");
        let target = first.camera(&view, size[0], size[1]).map_err(|e| trouble_of(&e))?;
        let facing = planes::Facing::of(&target, &self.wish.look).plane;
        let mut sides = Vec::new();
        for session in sessions {
            let start = Instant::now();
            let mut refinement = session.refinement(&target);
            let budget = Budget::rays(COARSE_RAYS.min(session.plan().budget.rays));
            let ended = session.go_on(&mut refinement, target.points(), budget, Control::none());
            ended.map_err(|e| trouble_of(&e))?;
            let seconds = start.elapsed().as_secs_f64();
            sides.push(side_picture(session, &target, &refinement, size, seconds, None));
        }
        self.coarse_done = true;
        pace.note(u64::from(size[0]) * u64::from(size[1]), start.elapsed().as_secs_f64());
        Ok(Step::Picture(Box::new(self.picture(size, facing, sides))))
    }

    /// Finds what all pixels see; false where something newer waits.
    fn trace(&mut self, sessions: &[Session], stop: &Stop<'_>) -> Result<bool, Trouble> {
        let Some(session) = sessions.first() else { return Ok(false) };
        let [width, height] = self.wish.size;
        let camera = Camera::new(&self.wish.look.view("view"), width, height);
        let camera = camera.map_err(|e| trouble_of(&e.into()))?;
        let bvh = session.bvh();
        // Where orders wait outside they are asked for, but not at every ray: that is a call out of the module.
        let rays = AtomicU64::new(0);
        let asks =
            || cfg!(target_arch = "wasm32") && rays.fetch_add(1, Ordering::Relaxed).is_multiple_of(1024);
        let target = session.install(|| {
            CameraTarget::trace(camera, |ray| {
                if stop.flag.load(Ordering::Relaxed) || (asks() && stop.is_set()) {
                    return None;
                }
                bvh.nearest(ray).map(|hit| bvh.surface_point(&hit, ray))
            })
        });
        if stop.is_set() {
            return Ok(false);
        }
        self.facing = planes::Facing::of(&target, &self.wish.look);
        self.target = Some(target);
        Ok(true)
    }

    fn picture(&self, size: [u32; 2], facing: Arc<Vec<f32>>, sides: Vec<SidePicture>) -> Picture {
        let (look, scene, wished) = (self.wish.look, self.wish.scene, self.wish.size);
        Picture { look, scene, size, wished, facing, sides, seconds: self.start.elapsed().as_secs_f64() }
    }

    /// True once something is shown.
    pub(super) fn has_first_picture(&self) -> bool {
        self.coarse_done
    }

    /// What all pixels see, once that is known.
    pub(super) fn target(&self) -> Option<&CameraTarget> {
        self.target.as_ref()
    }

    /// The estimates of a side so far.
    pub(super) fn estimates(&self, side: usize) -> Option<Vec<Estimate>> {
        let side = self.sides.get(side)?;
        if let (Some(drawn), Some(target)) = (&side.drawn, &self.target) {
            return Some(drawn.estimates(target.points()));
        }
        Some(side.refinement.as_ref()?.estimates())
    }
}
impl Job {
    /// True where a device made a side's picture, which keeps no directions.
    pub(super) fn is_drawn(&self, side: usize) -> bool {
        self.sides.get(side).is_some_and(|side| side.drawn.is_some())
    }

    /// A side that a device draws, and has not begun with.
    fn not_yet_drawn(&self, sessions: &[Session], pictures: &Pictures) -> Option<usize> {
        let is_new = |(side, session): (&Side, &Session)| {
            side.drawn.is_none() && side.ended.is_none() && pictures.draw_for(session)
        };
        self.sides.iter().zip(sessions).position(is_new)
    }

    /// The next picture of a side that a device draws.
    async fn draw(
        &mut self,
        index: usize,
        session: &Session,
        pictures: &mut Pictures,
    ) -> Result<Step, Trouble> {
        let side = &mut self.sides[index];
        let start = Instant::now();
        let drawn = pictures.draw(index, session, &self.wish, side.drawn.as_ref()).await;
        let drawn = drawn.map_err(|e| trouble_of(&e))?;
        side.seconds += start.elapsed().as_secs_f64();
        let (found, budget) = (drawn.found, session.plan().budget);
        let is_late = budget.seconds.is_some_and(|seconds| side.seconds >= seconds);
        side.ended = drawn.has_reached(&budget).or(is_late.then_some(Ended::Time));
        let planes = drawn.planes();
        side.picture = Some(SidePicture {
            method: Method::Hybrid,
            visibility: planes.visibility,
            error: planes.error,
            rays: planes.rays,
            cones: None,
            expected_rmse: found.expected_rmse,
            rays_per_pixel: found.rays as f64 / found.points.max(1) as f64,
            seconds: side.seconds,
            ended: side.ended.map(|ended| ended.to_string()),
        });
        if self.target.is_none() {
            self.facing = drawn.facing(self.wish.look.eye.into());
        }
        side.drawn = Some(drawn);
        Ok(self.whole())
    }
}
