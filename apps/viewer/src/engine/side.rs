//! The work on one side: rounds of twice as many rays each, until it has what it was to reach.
use super::{SidePicture, Stop, Trouble, pictures::Drawn, planes, scenes::trouble_of};
use conray::{
    Budget, Control, Ended, Method, PROGRESS_UNITS, Refinement, Session, SurfacePoint,
    gpu::GpuBackend,
    target::{CameraTarget, Target},
};
use std::sync::atomic::{AtomicU64, Ordering};
use web_time::Instant;

/// Rays a pixel of the first round.
const FIRST_RAYS: u32 = 2;

/// The work on one side.
pub(super) struct Side {
    pub(super) refinement: Option<Refinement>,
    /// Instead of that, where a device makes the whole picture.
    pub(super) drawn: Option<Drawn>,
    /// Rays a pixel of the next round.
    next_rays: u32,
    pub(super) seconds: f64,
    pub(super) ended: Option<Ended>,
    pub(super) picture: Option<SidePicture>,
}

impl Side {
    /// Nothing done yet.
    pub(super) fn new() -> Self {
        Self {
            refinement: None,
            drawn: None,
            next_rays: FIRST_RAYS,
            seconds: 0.0,
            ended: None,
            picture: None,
        }
    }

    /// One round, on a device where one is given; false where something newer waits.
    pub(super) async fn go_on(
        &mut self,
        on: Option<&GpuBackend>,
        session: &Session,
        target: &CameraTarget,
        stop: &Stop<'_>,
        tell: &(dyn Fn(f32) + Sync),
    ) -> Result<bool, Trouble> {
        let (goal, start) = (session.plan().budget, Instant::now());
        let left = goal.seconds.map_or(f64::INFINITY, |seconds| seconds - self.seconds);
        let refinement = self.refinement.get_or_insert_with(|| session.refinement(target));
        let done = AtomicU64::new(0);
        let over = std::sync::atomic::AtomicBool::new(false);
        let progress = |units: usize| {
            let done = done.fetch_add(units as u64, Ordering::Relaxed) + units as u64;
            if start.elapsed().as_secs_f64() > left {
                over.store(true, Ordering::Relaxed);
                stop.flag.store(true, Ordering::Relaxed);
            }
            stop.is_set();
            tell(done as f32 / PROGRESS_UNITS as f32);
        };
        let budget = Budget { rays: self.next_rays.min(goal.rays), seconds: None, error: goal.error };
        let control = Control { cancelled: stop.flag, progress: &progress };
        let ended = more(on, session, refinement, target.points(), budget, control).await;
        self.seconds += start.elapsed().as_secs_f64();
        let timed_out = over.load(Ordering::Relaxed);
        if timed_out {
            // The flag was ours; whatever is newer is found out again.
            stop.flag.store(false, Ordering::Relaxed);
        }
        match ended.map_err(|e| trouble_of(&e))? {
            Ended::Cancelled if timed_out => self.ended = Some(Ended::Time),
            Ended::Cancelled => return Ok(false),
            Ended::Rays
                if self.next_rays < goal.rays && self.seconds < goal.seconds.unwrap_or(f64::INFINITY) =>
            {
                self.next_rays = self.next_rays.saturating_mul(2);
            }
            Ended::Rays if self.next_rays < goal.rays => self.ended = Some(Ended::Time),
            ended => self.ended = Some(ended),
        }
        Ok(true)
    }

    pub(super) fn picture_of(
        &self,
        session: &Session,
        target: &CameraTarget,
        size: [u32; 2],
    ) -> Option<SidePicture> {
        let refinement = self.refinement.as_ref()?;
        Some(side_picture(session, target, refinement, size, self.seconds, self.ended))
    }
}

/// [`Session::go_on`], on a device where one is given.
pub(super) async fn more(
    on: Option<&GpuBackend>,
    session: &Session,
    refinement: &mut Refinement,
    points: &[SurfacePoint],
    budget: Budget,
    control: Control<'_>,
) -> Result<Ended, conray::Error> {
    match on {
        Some(device) => session.go_on_later(device, refinement, points, budget, control).await,
        None => session.go_on(refinement, points, budget, control),
    }
}

pub(super) fn side_picture(
    session: &Session,
    target: &CameraTarget,
    refinement: &Refinement,
    size: [u32; 2],
    seconds: f64,
    ended: Option<Ended>,
) -> SidePicture {
    let estimates = session.install(|| refinement.estimates());
    let points = target.points().len().max(1);
    let planes = session.install(|| planes::of_estimates(target.points(), &estimates, size));
    let method: Method = refinement.plan().method;
    SidePicture {
        method,
        visibility: planes.visibility,
        error: planes.error,
        rays: planes.rays,
        cones: planes.cones,
        expected_rmse: session.install(|| refinement.expected_rmse()),
        rays_per_pixel: refinement.rays() as f64 / points as f64,
        seconds,
        ended: ended.map(|ended| ended.to_string()),
    }
}
