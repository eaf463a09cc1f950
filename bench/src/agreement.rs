//! Whether kernels gave the same answers: a race between kernels that do not agree says nothing.
//!
//! Our kernels are exact and must agree with each other to the last ray. Embree (without its robust flag) and obvhs round
//! their edge tests, so a ray that all but touches an edge may go either way; each such ray is counted, not only the
//! sums, in which errors cancel.

use crate::{kernels::Family, race::Race};

/// Share of the rays on which a rival may differ. Seen: up to some 1e-5, of rays that touch edges.
pub const TOLERANCE: f64 = 1e-4;

/// Says which kernels do not agree with the first.
///
/// # Errors
/// One line for each.
pub fn check(race: &Race) -> Result<(), String> {
    let allowed = |family| match family {
        Family::Conray => 0,
        Family::Embree | Family::Obvhs => (TOLERANCE * race.rays as f64) as u64,
    };
    let wrong = race.finishes.iter().filter(|f| f.differing > allowed(f.family));
    let lines: Vec<String> = wrong
        .map(|f| {
            format!(
                "{} differs from {} on {} of {} rays, {} are allowed",
                f.name,
                race.finishes[0].name,
                f.differing,
                race.rays,
                allowed(f.family)
            )
        })
        .collect();
    if lines.is_empty() { Ok(()) } else { Err(lines.join("\n")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        hemispheres::{Hemispheres, Order},
        judged,
        kernels::{Bundles, Kernel, Obvhs, Single, Tile, Tracer},
        race,
    };
    use conray::AoSettings;

    /// A kernel whose answers are turned round for one ray in so many.
    struct Wrong<'a> {
        inner: Single<'a>,
        family: Family,
        one_in: usize,
    }

    impl Kernel for Wrong<'_> {
        fn name(&self) -> String {
            "wrong".into()
        }

        fn family(&self) -> Family {
            self.family
        }

        fn order(&self) -> Order {
            Order::Cells
        }

        fn tracer(&self) -> Box<dyn Tracer + '_> {
            Box::new(WrongTracer { inner: self.inner.tracer(), one_in: self.one_in })
        }
    }

    struct WrongTracer<'a> {
        inner: Box<dyn Tracer + 'a>,
        one_in: usize,
    }

    impl Tracer for WrongTracer<'_> {
        fn prepare(&mut self, tile: Tile<'_>) {
            self.inner.prepare(tile);
        }

        fn trace(&mut self) {
            self.inner.trace();
        }

        fn answers(&self, open: &mut Vec<bool>) {
            let start = open.len();
            self.inner.answers(open);
            open[start..].iter_mut().step_by(self.one_in).for_each(|o| *o = !*o);
        }
    }

    fn race_with(wrong: Option<(Family, usize)>) -> Race {
        let scene = Hemispheres::new(judged("cornell").unwrap(), &AoSettings::default(), 24).unwrap();
        let (bvh, distance) = (scene.session.bvh(), scene.distance);
        let obvhs = Obvhs::build(scene.session.geometry(), distance);
        let mut kernels: Vec<Box<dyn Kernel + '_>> =
            vec![Box::new(Single { bvh, distance }), Box::new(Bundles { bvh, distance }), Box::new(obvhs)];
        if let Some((family, one_in)) = wrong {
            kernels.push(Box::new(Wrong { inner: Single { bvh, distance }, family, one_in }));
        }
        race::race(&scene.points, 64, &kernels, 1)
    }

    #[test]
    fn the_kernels_agree() {
        let race = race_with(None);
        assert!(race.rays > 30_000, "{} rays", race.rays);
        let open = race.finishes[0].open;
        assert!(open > 0 && open < race.rays, "both answers must occur: {open} of {}", race.rays);
        check(&race).unwrap();
    }

    #[test]
    fn a_rival_that_is_wrong_on_one_ray_in_a_hundred_fails() {
        let race = race_with(Some((Family::Embree, 100)));
        assert!(race.finishes[3].differing >= race.rays / 100);
        assert!(check(&race).unwrap_err().contains("wrong differs"));
    }

    #[test]
    fn a_kernel_of_ours_that_is_wrong_on_few_rays_fails_where_a_rival_would_pass() {
        // One ray of each tile of 1024: above the tolerance; so judge the count alone.
        let mut race = race_with(Some((Family::Conray, 1024)));
        race.finishes[3].differing = 1;
        assert!(check(&race).is_err());
        race.finishes[3].family = Family::Embree;
        check(&race).unwrap();
    }
}
