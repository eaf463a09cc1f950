//! The device beside the CPU: opened where it is wished for, left where it is not, and where it fails.
use super::{Engine, Fault, Report, Trouble, Wish, pictures};
use conray::Device;

/// What is not asked for again.
#[derive(Clone, Copy)]
pub(super) struct Refused {
    device: Device,
    /// True where it was asked for with an octree: it may have room for all else.
    with_octree: bool,
}
impl Engine {
    /// Opens a device where one is wished for and not there; true where that changed anything. The first picture comes before: it does not wait for
    /// shaders.
    pub(super) async fn open_device(&mut self, report: &(dyn Fn(Report) + Sync)) -> bool {
        let (Some(held), Some(job)) = (&self.held, &self.job) else { return false };
        let with_octree = held.sessions.iter().any(|session| session.plan().method.needs_octree());
        let in_vain =
            |refused: &Refused| refused.device == job.wish.device && (with_octree || !refused.with_octree);
        let is_in_vain = self.refused.as_ref().is_some_and(in_vain);
        if is_in_vain
            || self.pictures.is_some()
            || !job.has_first_picture()
            || !pictures::are_wished(&held.sessions, &job.wish)
        {
            return false;
        }
        report(Report::Busy("opening a graphics processor".into(), None));
        match pictures::Pictures::open(&held.sessions, &job.wish).await {
            Ok(opened) => {
                self.pictures = Some(opened);
                self.tell_built(report);
            }
            Err(e) => {
                self.refused = Some(Refused { device: job.wish.device, with_octree });
                let nothing = matches!(e, conray::gpu::GpuError::NoAdapter { wanted: None, .. });
                let why = if nothing { "there is no graphics processor".into() } else { e.to_string() };
                report(Report::Notice(format!("on the CPU: {why}")));
            }
        }
        true
    }

    /// Gives the device back where it is not wished for any more; true where that changed anything.
    pub(super) fn leave_device(&mut self, wish: &Wish) -> bool {
        self.refused = self.refused.filter(|refused| refused.device == wish.device);
        let sessions = self.held.as_ref().map_or(&[][..], |held| &held.sessions);
        let is_other = self.pictures.as_ref().is_some_and(|pictures| !pictures.are_of(sessions, wish));
        is_other && self.pictures.take().is_some()
    }

    /// Has the device fail, as drivers do; for tests.
    #[doc(hidden)]
    pub fn lose_device(&self) {
        if let Some(pictures) = &self.pictures {
            pictures.backend().gpu().destroy();
        }
    }

    /// Gives the device back; one that failed is not asked for again.
    pub(super) fn drop_device(&mut self, failed: Option<Device>) {
        self.pictures = None;
        self.refused = failed.map(|device| Refused { device, with_octree: false });
    }

    /// What is built, and where pictures are made.
    pub(super) fn tell_built(&self, report: &(dyn Fn(Report) + Sync)) {
        let Some(held) = &self.held else { return };
        let mut built = held.built();
        if let Some(pictures) = &self.pictures {
            let served = built.places.iter_mut().zip(&held.sessions).filter(|(_, s)| pictures.serve(s));
            served.for_each(|(place, _)| *place = pictures.place());
        }
        report(Report::Built(built));
    }

    /// Leaves a device that failed, and says so; trouble of another kind is handed back.
    pub(super) fn take_over(
        &mut self,
        device: Device,
        trouble: Trouble,
        report: &(dyn Fn(Report) + Sync),
    ) -> Result<(), Trouble> {
        if self.pictures.is_none() || trouble.fault != Fault::Work {
            return Err(trouble);
        }
        report(Report::Trouble(trouble));
        self.drop_device(Some(device));
        self.tell_built(report);
        report(Report::Notice("the CPU has taken over".into()));
        Ok(())
    }
}
