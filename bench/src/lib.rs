//! What the measuring programs share: scenes with views, truths kept on disk, runs judged against them.

pub mod agreement;
pub mod builds;
pub mod cone_sets;
pub mod embree;
pub mod hemispheres;
pub mod kernels;
pub mod machine;
pub mod measures;
pub mod memory;
pub mod octree_build;
pub mod race;
pub mod rays;
pub mod scale;
pub mod tiles;
pub mod whole_program;

use conray::{
    AoSettings, Control, Error, Method, Outcome, Session, SessionOptions, SurfacePoint, View,
    scene::{self, Scene},
    target::{self, CameraTarget, Metrics, Target},
};
use std::{
    fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::PathBuf,
};

/// A scene with the view it is judged from.
pub struct Judged {
    /// Name in tables.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// The view.
    pub view: View,
}

/// A built-in scene or a file, from its default view.
///
/// # Errors
/// What the loader says.
pub fn judged(name: &str) -> Result<Judged, Error> {
    if let Some(scene) = scene::builtin(name) {
        let view = scene.default_view();
        return Ok(Judged { name: name.into(), scene, view });
    }
    let scene = scene::load(name.as_ref(), &scene::Limits::default())?;
    let view = scene.default_view();
    Ok(Judged { name: scene.name.clone(), scene, view })
}

/// A session with its camera image and the truth for it.
pub struct Bench {
    /// Name in tables.
    pub name: String,
    /// Built with BVH and octree.
    pub session: Session,
    /// The points that the camera sees.
    pub target: CameraTarget,
    /// True visibility of each point.
    pub truth: Vec<f32>,
}

impl Bench {
    /// Builds a scene and finds its truth by `truth_rays` rays a point, kept in `target/truth`.
    ///
    /// # Errors
    /// What building says.
    pub fn new(
        judged: Judged,
        settings: &AoSettings,
        size: (u32, u32),
        truth_rays: u32,
    ) -> Result<Self, Error> {
        let Judged { name, scene, view } = judged;
        let built = AoSettings { method: Method::Paper, ..settings.clone() };
        let mut session =
            Session::build_observed(scene.geometry, &built, &SessionOptions::default(), &|_| {})?;
        let target = session.camera(&view, size.0, size.1)?;
        // Other random numbers than those of the runs that are judged.
        let truth_settings =
            AoSettings { method: Method::Rays, rays: Some(truth_rays), seed: 0x7eed, ..settings.clone() };
        session.set_plan(&truth_settings)?;
        let truth = cached_truth(&name, &session, &target, truth_rays)?;
        Ok(Self { name, session, target, truth })
    }

    /// Runs a method over the image and judges it.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn run(&mut self, settings: &AoSettings) -> Result<(Outcome, Metrics), Error> {
        self.session.set_plan(settings)?;
        let outcome = self.session.run(self.target.points(), Control::none())?;
        let found: Vec<f32> = outcome.estimates.iter().map(|e| e.visibility).collect();
        let all = vec![true; found.len()];
        let metrics = target::compare(&found, &self.truth, &all)?;
        Ok((outcome, metrics))
    }
}

/// Visibility by many rays; computed once for each scene, view, size and setting.
fn cached_truth(
    name: &str,
    session: &Session,
    target: &CameraTarget,
    truth_rays: u32,
) -> Result<Vec<f32>, Error> {
    let mut key = DefaultHasher::new();
    format!("{:?}", session.plan()).hash(&mut key);
    target
        .points()
        .iter()
        .for_each(|p: &SurfacePoint| p.position.to_array().map(f32::to_bits).hash(&mut key));
    let path = PathBuf::from(format!("target/truth/{name}-{:016x}.f32", key.finish()));
    if let Ok(bytes) = fs::read(&path)
        && bytes.len() == 4 * target.points().len()
    {
        return Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect());
    }
    eprintln!("{name}: {truth_rays} rays a point for the truth");
    let truth: Vec<f32> = session.estimate(target.points())?.iter().map(|e| e.visibility).collect();
    let bytes: Vec<u8> = truth.iter().flat_map(|v| v.to_le_bytes()).collect();
    let kept = fs::create_dir_all("target/truth")
        .map_err(|e| e.to_string())
        .and_then(|()| target::write_atomically(&path, |w| w.write_all(&bytes)).map_err(|e| e.to_string()));
    if let Err(reason) = kept {
        eprintln!("{name}: the truth is not kept: {reason}");
    }
    Ok(truth)
}
