//! The error of marching: what cones and the blend expect of themselves, and what the blend gains by it.

use conray::{AoSettings, Control, Epsilon, Estimate, Method, Session, SurfacePoint, scene, target::Target};

/// A built-in scene with the points of its first view and their visibility by many rays.
struct Judged {
    session: Session,
    points: Vec<SurfacePoint>,
    truth: Vec<Estimate>,
}

impl Judged {
    fn new(name: &str) -> Self {
        let scene = scene::builtin(name).unwrap();
        let view = scene.default_view();
        let paper = AoSettings { method: Method::Paper, ..AoSettings::default() };
        let mut session = Session::build(scene.geometry, &paper).unwrap();
        let points = session.camera(&view, 64, 64).unwrap().points().to_vec();
        session
            .set_plan(&AoSettings { method: Method::Rays, rays: Some(256), seed: 9, ..AoSettings::default() })
            .unwrap();
        let truth = session.estimate(&points).unwrap();
        Self { session, points, truth }
    }

    /// True and expected RMSE, and rays a point.
    fn run(&mut self, settings: &AoSettings) -> [f64; 3] {
        self.session.set_plan(settings).unwrap();
        let outcome = self.session.run(&self.points, Control::none()).unwrap();
        let n = self.points.len() as f64;
        let pairs = || outcome.estimates.iter().zip(&self.truth);
        let off = pairs().map(|(e, t)| f64::from(e.visibility - t.visibility).powi(2)).sum::<f64>();
        let expected = pairs().map(|(e, _)| f64::from(e.error).powi(2)).sum::<f64>();
        [(off / n).sqrt(), (expected / n).sqrt(), outcome.work.rays as f64 / n]
    }
}

/// To a factor of about two, without a ray.
fn cones_know_their_error(judged: &mut Judged) {
    let [error, expected, _] = judged.run(&AoSettings { method: Method::Cones, ..AoSettings::default() });
    assert!((0.45..2.3).contains(&(expected / error)), "{expected} for {error}");
}

#[test]
fn on_the_cornell_box() {
    cones_know_their_error(&mut Judged::new("cornell"));
}

#[test]
fn in_the_atrium_and_the_blend_does_more_with_fewer_rays_where_the_error_of_marching_counts() {
    let mut judged = Judged::new("atrium");
    cones_know_their_error(&mut judged);
    let blend =
        |epsilon, max_rays| AoSettings { method: Method::Paper, epsilon, max_rays, ..AoSettings::default() };
    let [marching, _, rays] = judged.run(&blend(Epsilon::Marching, 6));
    let [published, _, most] = judged.run(&blend(Epsilon::Published, 10));
    assert!(most > rays, "the published one has more rays: {most}, {rays}");
    assert!(marching < 0.7 * published, "{marching}, {published}");
}
