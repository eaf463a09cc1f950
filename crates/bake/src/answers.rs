//! What the points of a portion see: all together, or object by object where each is occluded by itself alone.

use crate::{inside, shares::Shares};
use conray::{Budget, Control, Ended, Error, Outcome, Session, Work};
use conray_core::{Estimate, Layout, SurfacePoint};
use conray_target::{Target, TargetError};
use std::path::{Path, PathBuf};

/// Points that fill less than one place in so many of a portion's image are taken as scattered: the image would be work for nothing.
const SPARSE: u64 = 16;

/// An object that nothing else occludes.
pub struct Apart {
    /// Its instances in the whole scene.
    pub instances: Vec<u32>,
    /// What occludes it: itself, and perhaps a ground.
    pub session: Session,
}

/// Who is asked about points: all that occludes, or each object's own where objects stand apart.
pub(crate) struct Asked<'a> {
    pub(crate) session: &'a Session,
    /// Empty where all occludes all.
    pub(crate) apart: &'a [Apart],
    /// Points look into the body that they lie on.
    pub(crate) looks_inside: bool,
}

/// What became of a target's points, one by one in its order.
pub(crate) struct Answers {
    pub(crate) estimates: Vec<Estimate>,
    /// Which lie inside other geometry.
    pub(crate) inside: Vec<bool>,
    pub(crate) works: Vec<Work>,
}

impl Asked<'_> {
    /// What becomes of the points of a target within a budget; `instances` are those of the points. Where objects stand apart, points of no object stay
    /// pending.
    ///
    /// With a file to keep the work in, only by method `hybrid`, work goes on with what is there, and is kept at the end and when it is stopped: in
    /// the end the bits are those of unbroken work. Objects that stand apart have files of their own beside it.
    pub(crate) fn answers<T: Target>(
        &self,
        target: &T,
        instances: &[u32],
        budget: Budget,
        control: Control<'_>,
        kept: Option<&Path>,
    ) -> Result<Answers, Error> {
        match self.apart {
            [] => self.one(self.session, target, budget, control, kept),
            _ => self.each(target, instances, budget, control, kept),
        }
    }

    fn one<T: Target>(
        &self,
        session: &Session,
        target: &T,
        budget: Budget,
        control: Control<'_>,
        kept: Option<&Path>,
    ) -> Result<Answers, Error> {
        let Outcome { estimates, work } = match kept {
            None => session.run_target_within(budget, target, control)?,
            Some(path) => session.run_target_kept(budget, target, control, path)?,
        };
        let points = target.points();
        // Who looks into a body lies inside it.
        let inside = match self.looks_inside {
            true => vec![false; points.len()],
            false => inside(session, points, &estimates, target.layout()),
        };
        Ok(Answers { estimates, inside, works: vec![work] })
    }

    fn each<T: Target>(
        &self,
        target: &T,
        instances: &[u32],
        budget: Budget,
        control: Control<'_>,
        kept: Option<&Path>,
    ) -> Result<Answers, Error> {
        let count = target.points().len();
        let mut all = Answers {
            estimates: vec![Estimate::PENDING; count],
            inside: vec![false; count],
            works: Vec::new(),
        };
        let most = instances.iter().max().map_or(0, |most| *most as usize + 1);
        let mut object_of = vec![usize::MAX; most];
        for (k, object) in self.apart.iter().enumerate() {
            object
                .instances
                .iter()
                .filter(|i| (**i as usize) < most)
                .for_each(|&i| object_of[i as usize] = k);
        }
        let mut of_objects: Vec<Vec<usize>> = vec![Vec::new(); self.apart.len()];
        for (point, &instance) in instances.iter().enumerate() {
            if let Some(object) = of_objects.get_mut(object_of[instance as usize]) {
                object.push(point);
            }
        }
        let objects: Vec<(usize, Vec<usize>)> =
            of_objects.into_iter().enumerate().filter(|(_, indices)| !indices.is_empty()).collect();
        let weights = objects.iter().map(|(_, indices)| indices.len() as f64).collect();
        let mut shares = Shares::new(weights, budget);
        for (k, indices) in objects {
            // One is begun in any case, so that there is work to tell of.
            if control.is_cancelled() && !all.works.is_empty() {
                break;
            }
            let part = Part::of(target, &indices);
            let kept = kept.map(|path| of_object(path, k));
            let found = shares.next(control, |budget, control| {
                let found = self.one(&self.apart[k].session, &part, budget, control, kept.as_deref())?;
                Ok::<_, Error>((found.seconds(), found))
            })?;
            for ((index, estimate), inside) in indices.into_iter().zip(&found.estimates).zip(&found.inside) {
                (all.estimates[index], all.inside[index]) = (*estimate, *inside);
            }
            all.works.extend(found.works);
        }
        Ok(all)
    }
}

impl Answers {
    /// Seconds of estimation.
    pub(crate) fn seconds(&self) -> f64 {
        self.works.iter().map(|work| work.seconds).sum()
    }
}

/// The file of an object's work beside that of the whole.
fn of_object(path: &Path, object: usize) -> PathBuf {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!("{stem}-object-{object}.state"))
}

/// Says of the last work that it was stopped, also where that was between two works.
pub(crate) fn mark_stopped(works: &mut [Work], control: Control<'_>) {
    if control.is_cancelled()
        && let Some(last) = works.last_mut()
    {
        (last.completed, last.ended) = (false, Ended::Cancelled);
    }
}

/// Some points of a target, and how they lie.
struct Part {
    points: Vec<SurfacePoint>,
    layout: Layout,
}

impl Part {
    fn of<T: Target>(target: &T, indices: &[usize]) -> Self {
        let points: Vec<SurfacePoint> = indices.iter().map(|&index| target.points()[index]).collect();
        let layout = match target.layout() {
            Layout::Image { width, height, .. }
                if (points.len() as u64) * SPARSE < u64::from(width) * u64::from(height) =>
            {
                Layout::Scattered
            }
            layout => layout,
        };
        Self { points, layout }
    }
}

impl Target for Part {
    type Output = ();

    fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    fn layout(&self) -> Layout {
        self.layout
    }

    fn resolve(&self, _: &[Estimate]) -> Result<(), TargetError> {
        Ok(())
    }
}
