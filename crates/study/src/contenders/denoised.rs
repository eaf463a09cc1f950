//! Rays followed by a neural denoiser.

use super::{
    filtered::gather,
    rays::{ray_efforts, trace},
};
use crate::{
    Answer, Case, Contender, Effort, Needs, Preparation, StudyError,
    oidn::{Api, Denoiser},
    quality::rmse,
};
use conray::{Control, Sampling};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Sobol rays, denoised.
#[derive(Default)]
pub(crate) struct Denoised {
    /// Without guides and with normals.
    denoisers: Option<[Denoiser; 2]>,
    /// Whether normals guide it, for each effort.
    guided: BTreeMap<u32, bool>,
}

impl Contender for Denoised {
    fn name(&self) -> &'static str {
        "rays-denoised"
    }

    fn about(&self) -> String {
        "Sobol rays and Intel Open Image Denoise 2, filter RT on linear values, with or without normals as guides, \
         whichever errs less with the truth at hand."
            .into()
    }

    fn needs(&self) -> Needs {
        Needs { bvh: true, octree: false }
    }

    fn unavailable(&self) -> Option<String> {
        Api::get().err().map(Into::into)
    }

    fn efforts(&self, budgets: &[u32]) -> Vec<Effort> {
        ray_efforts(budgets)
    }

    /// Makes devices and filters ready, with and without guides, and keeps for each effort what errs less.
    fn prepare(&mut self, preparation: &Preparation<'_>) -> Result<(), StudyError> {
        let case = preparation.case;
        let denoisers = self.denoisers(case).map_err(|problem| self.failure(problem))?;
        for &rays in preparation.budgets {
            if preparation.control.is_cancelled() {
                return Ok(());
            }
            let answer = trace(case, rays, Sampling::Sobol, preparation.control)?;
            let error = |denoiser: &Denoiser| {
                let visibility = self.denoise(case, &answer.visibility, denoiser)?;
                Ok::<_, StudyError>(rmse(&visibility, preparation.truth))
            };
            let guided = error(&denoisers[1])? < error(&denoisers[0])?;
            self.guided.insert(rays, guided);
        }
        self.denoisers = Some(denoisers);
        Ok(())
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        let (Some(denoisers), Some(&guided)) = (&self.denoisers, self.guided.get(&effort)) else {
            return Err(self.failure(format!("was not prepared for {effort} rays")));
        };
        let answer = trace(case, effort, Sampling::Sobol, control)?;
        let visibility = self.denoise(case, &answer.visibility, &denoisers[usize::from(guided)])?;
        Ok(Answer { visibility, expected_error: None, ..answer })
    }

    fn chosen(&self, effort: u32) -> Map<String, Value> {
        self.guided.get(&effort).map(|&guided| ("normals".into(), guided.into())).into_iter().collect()
    }
}

impl Denoised {
    fn denoisers(&self, case: &Case) -> Result<[Denoiser; 2], String> {
        let api = Api::get()?;
        let (width, height) = case.size();
        let size = (width as usize, height as usize);
        let mut normals = vec![0.0; 3 * size.0 * size.1];
        for point in case.points() {
            normals[3 * point.id as usize..][..3].copy_from_slice(&point.shading_normal.to_array());
        }
        let threads = case.session.threads();
        let new = |normals| Denoiser::new(api, size, threads, normals);
        Ok([new(None)?, new(Some(&normals))?])
    }

    /// Over an open background, held within the range of visibilities.
    fn denoise(&self, case: &Case, visibility: &[f32], denoiser: &Denoiser) -> Result<Vec<f32>, StudyError> {
        let image = case.pixels(visibility, 1.0);
        let mut denoised = denoiser.denoise(&image).map_err(|problem| self.failure(problem))?;
        denoised.iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
        Ok(gather(case, &denoised))
    }

    fn failure(&self, problem: String) -> StudyError {
        StudyError::Rival { name: self.name().into(), problem }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pilot, testing::test_case};

    /// Prepared for the budgets, with the truth.
    fn prepared(case: &Case, budgets: &[u32]) -> (Denoised, Vec<f32>) {
        let truth = trace(case, 1024, Sampling::Stratified, Control::none()).unwrap().visibility;
        let mut contender = Denoised::default();
        let pilot = Pilot { points: Vec::new() };
        let (settings, control) = (&case.settings, Control::none());
        let preparation = Preparation { case, truth: &truth, pilot: &pilot, budgets, settings, control };
        contender.prepare(&preparation).unwrap();
        (contender, truth)
    }

    #[test]
    fn unprepared_it_says_so() {
        let error = Denoised::default().run(&test_case(8), 4, Control::none()).unwrap_err();
        assert_eq!(error.to_string(), "rays-denoised: was not prepared for 4 rays");
    }

    #[test]
    #[ignore = "needs Open Image Denoise: bench/fetch-rivals"]
    fn denoising_gains_and_repeats() {
        let case = test_case(64);
        assert_eq!(Denoised::default().unavailable(), None);
        let (contender, truth) = prepared(&case, &[1, 4]);
        for rays in [1, 4] {
            let out = contender.run(&case, rays, Control::none()).unwrap();
            let plain = trace(&case, rays, Sampling::Sobol, Control::none()).unwrap();
            let (after, before) = (rmse(&out.visibility, &truth), rmse(&plain.visibility, &truth));
            assert!(after < 0.5 * before, "{rays}: {after} {before}");
            assert_eq!(out, contender.run(&case, rays, Control::none()).unwrap());
            assert_eq!(contender.chosen(rays).len(), 1);
            // The better of the two was kept.
            let other = &contender.denoisers.as_ref().unwrap()[usize::from(!contender.guided[&rays])];
            let rejected = contender.denoise(&case, &plain.visibility, other).unwrap();
            assert!(rmse(&rejected, &truth) >= after);
        }
    }
}
