//! What the measuring programs share: scenes with views, truths kept on disk, runs judged against them.

use conray::{
    AoSettings, Control, Error, Method, Outcome, Session, SessionOptions, SurfacePoint, Vec3, View,
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

/// A built-in scene, or a file with the camera that the scenes' README gives it.
///
/// # Errors
/// What the loader says.
pub fn judged(name: &str) -> Result<Judged, Error> {
    if let Some(scene) = scene::builtin(name) {
        let view = scene.default_view();
        return Ok(Judged { name: name.into(), scene, view });
    }
    let scene = scene::load(name.as_ref(), &scene::Limits::default())?;
    let view = known_view(&scene.name).unwrap_or_else(|| scene.default_view());
    Ok(Judged { name: scene.name.clone(), scene, view })
}

/// First cameras of well-known scene files.
fn known_view(name: &str) -> Option<View> {
    let (eye, look_at, vertical_fov_deg) = match name {
        "sponza" => ([950.0, 170.0, -40.0], [-1000.0, 430.0, -40.0], 65.0),
        "conference" => ([300.0, 300.0, 480.0], [560.0, 110.0, -200.0], 65.0),
        "CornellBox-Original" => ([0.0, 1.0, 3.9], [0.0, 1.0, 0.0], 38.0),
        "CornellBox-Sphere" => ([0.0, 0.8, 3.9], [0.0, 0.8, 0.0], 38.0),
        _ => return None,
    };
    let (eye, look_at) = (Vec3::from_array(eye), Vec3::from_array(look_at));
    Some(View { name: "first".into(), eye, look_at, up: Vec3::Y, vertical_fov_deg })
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
            AoSettings { method: Method::Rays, rays: truth_rays, seed: 0x7eed, ..settings.clone() };
        session.set_plan(&truth_settings)?;
        let truth = cached_truth(&name, &session, &target, &truth_settings)?;
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
    settings: &AoSettings,
) -> Result<Vec<f32>, Error> {
    let mut key = DefaultHasher::new();
    format!("{settings:?} {:?}", session.plan().distance).hash(&mut key);
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
    eprintln!("{name}: {} rays a point for the truth", settings.rays);
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
