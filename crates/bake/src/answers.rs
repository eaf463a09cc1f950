//! What the points of a portion see: all together, or object by object where each is occluded by itself alone.

use crate::{Facing, inside, shares::Shares};
use conray::{Budget, Control, Error, Outcome, Session, Work};
use conray_core::{Estimate, Layout, SurfacePoint};
use conray_target::{Target, TargetError};
use std::path::Path;

/// Points that fill less than one place in so many of a portion's image are taken as scattered: the image would be work for nothing.
const SPARSE: u64 = 16;

/// An object that nothing else occludes.
pub struct Apart {
    /// Its instances in the whole scene.
    pub instances: Vec<u32>,
    /// What occludes it: itself, and perhaps a ground.
    pub session: Session,
}

/// What became of a target's points, one by one in its order.
pub(crate) struct Answers {
    pub(crate) estimates: Vec<Estimate>,
    /// Which lie inside other geometry.
    pub(crate) inside: Vec<bool>,
    pub(crate) works: Vec<Work>,
}

impl Answers {
    /// Of all points among all that occludes.
    pub(crate) fn of<T: Target>(
        session: &Session,
        target: &T,
        budget: Budget,
        control: Control<'_>,
        facing: Facing,
    ) -> Result<Self, Error> {
        let Outcome { estimates, work } = session.run_target_within(budget, target, control)?;
        Ok(Self::with_inside(session, target, estimates, work, facing))
    }

    /// The same by method `hybrid`, going on with what a file keeps, where there is one, and keeping the work there at the end and when it is stopped: in the end
    /// the bits are those of unbroken work.
    pub(crate) fn kept<T: Target>(
        session: &Session,
        target: &T,
        budget: Budget,
        control: Control<'_>,
        facing: Facing,
        path: &Path,
    ) -> Result<Self, Error> {
        let Outcome { estimates, work } = session.run_target_kept(budget, target, control, path)?;
        Ok(Self::with_inside(session, target, estimates, work, facing))
    }

    /// Seconds of estimation.
    pub(crate) fn seconds(&self) -> f64 {
        self.works.iter().map(|work| work.seconds).sum()
    }

    fn with_inside<T: Target>(
        session: &Session,
        target: &T,
        estimates: Vec<Estimate>,
        work: Work,
        facing: Facing,
    ) -> Self {
        let points = target.points();
        // Who looks into a body lies inside it.
        let inside = match facing.inside {
            true => vec![false; points.len()],
            false => inside(session, points, &estimates, target.layout()),
        };
        Self { estimates, inside, works: vec![work] }
    }

    /// Of the points of each object among what occludes it; `instances` are those of the points. Points of no object stay pending.
    pub(crate) fn apart<T: Target>(
        apart: &[Apart],
        target: &T,
        instances: &[u32],
        budget: Budget,
        control: Control<'_>,
        facing: Facing,
    ) -> Result<Self, Error> {
        let count = target.points().len();
        let mut all =
            Self { estimates: vec![Estimate::PENDING; count], inside: vec![false; count], works: Vec::new() };
        let most = instances.iter().max().map_or(0, |most| *most as usize + 1);
        let mut object_of = vec![usize::MAX; most];
        for (k, object) in apart.iter().enumerate() {
            object
                .instances
                .iter()
                .filter(|i| (**i as usize) < most)
                .for_each(|&i| object_of[i as usize] = k);
        }
        let mut of_objects: Vec<Vec<usize>> = vec![Vec::new(); apart.len()];
        for (point, &instance) in instances.iter().enumerate() {
            if let Some(object) = of_objects.get_mut(object_of[instance as usize]) {
                object.push(point);
            }
        }
        let objects: Vec<(&Apart, Vec<usize>)> =
            apart.iter().zip(of_objects).filter(|(_, indices)| !indices.is_empty()).collect();
        let weights = objects.iter().map(|(_, indices)| indices.len() as f64).collect();
        let mut shares = Shares::new(weights, budget);
        for (object, indices) in objects {
            let part = Part::of(target, &indices);
            let found = shares.next(control, |budget, control| {
                let found = Self::of(&object.session, &part, budget, control, facing)?;
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
