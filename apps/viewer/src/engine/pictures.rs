//! Pictures by method `hybrid` made wholly on a device whose answers come later: what a page has (WebGPU), where nobody may wait for them.

use super::{Wish, planes};
use conray::{
    AoSettings, Budget, Device, Estimate, Method, RayErrors, Session, SurfacePoint, Vec3,
    gpu::{FrameCamera, FrameFound, FramePixel, Frames, Gpu, GpuBackend, GpuError},
    target::Camera,
};
use std::sync::Arc;
use web_time::Instant;

/// Rays a pixel of a first picture.
const FIRST_RAYS: f32 = 1.0;
/// Nobody can interrupt a device: more rays than before are asked for where it answered sooner than this, fewer where it took longer than that.
const SOON_SECONDS: f64 = 0.1;
const LATE_SECONDS: f64 = 0.25;
/// Rays a pixel that are asked for at once: with fewer the weighing that follows takes longer than they do.
const RAYS: [f32; 2] = [1.0, 16.0];

/// A scene on a device, and room for pictures of one size.
pub(super) struct Pictures {
    backend: Arc<GpuBackend>,
    /// By whose settings, and how large.
    made_for: Option<(Vec<AoSettings>, [u32; 2])>,
    frames: Option<Frames>,
    /// Rays a pixel that are asked for next.
    rays: f32,
}

/// The picture of one side so far.
pub(super) struct Drawn {
    pub(super) found: FrameFound,
    pixels: Vec<Option<FramePixel>>,
}

/// Whether a wish asks for one: of the methods `hybrid` alone is made so, with what devices have of it.
pub(super) fn are_wished(wish: &Wish) -> bool {
    wish.device != Device::Cpu && wish.sides.iter().any(|side| side.method == Method::Hybrid)
}

impl Pictures {
    /// Uploads a session's scene. A program on the CPU counts where a device or its name is asked for.
    pub(super) async fn open(session: &Session, wish: &Wish) -> Result<Self, GpuError> {
        let gpu = match (wish.device, &wish.adapter) {
            (Device::Auto, None) => Gpu::open_real_later().await?,
            (_, name) => Gpu::open_later(name.as_deref()).await?,
        };
        let backend = GpuBackend::new(gpu, Some(session.geometry()), None)?;
        Ok(Self { backend: Arc::new(backend), made_for: None, frames: None, rays: FIRST_RAYS })
    }

    /// Where they are made, for people.
    pub(super) fn place(&self) -> String {
        let facts = self.backend.gpu().facts();
        let software = if facts.is_software { ", a program on the CPU" } else { "" };
        format!("{} ({}{software})", facts.name, facts.backend)
    }

    /// Whether a wish would have opened the same device.
    pub(super) fn are_of(&self, wish: &Wish) -> bool {
        let is_meant = wish.device == Device::Gpu || wish.adapter.is_some();
        are_wished(wish) && (is_meant || !self.backend.gpu().facts().is_software)
    }

    /// The first picture of a camera, or more rays for the one before.
    pub(super) async fn draw(
        &mut self,
        session: &Session,
        wish: &Wish,
        before: Option<&Drawn>,
    ) -> Result<Drawn, GpuError> {
        let plan = session.plan();
        let is_same =
            self.made_for.as_ref().is_some_and(|(sides, size)| (sides, *size) == (&wish.sides, wish.size));
        if !is_same {
            // Room is given back before more is taken.
            self.frames = None;
            self.frames = Some(self.backend.frames(plan, session.bounds(), wish.size)?);
            self.made_for = Some((wish.sides.clone(), wish.size));
        }
        let Some(frames) = &mut self.frames else { return Err(GpuError::NotUploaded(plan.method)) };
        let start = Instant::now();
        let (found, is_first) = match before {
            Some(_) if is_same => (frames.refine_later(self.rays, &RayErrors::UNKNOWN).await?, false),
            _ => (frames.render_later(&camera_of(wish)?, FIRST_RAYS, &RayErrors::UNKNOWN).await?, true),
        };
        let seconds = start.elapsed().as_secs_f64();
        self.rays = match seconds {
            _ if is_first => FIRST_RAYS,
            soon if soon < SOON_SECONDS => (2.0 * self.rays).min(RAYS[1]),
            late if late > LATE_SECONDS => (0.5 * self.rays).max(RAYS[0]),
            _ => self.rays,
        };
        Ok(Drawn { found, pixels: frames.pixels_later().await? })
    }
}

fn camera_of(wish: &Wish) -> Result<FrameCamera, GpuError> {
    let [width, height] = wish.size;
    // The session has refused what is no camera before.
    let camera = Camera::new(&wish.look.view("view"), width, height)
        .map_err(|_| GpuError::Unsupported("what this camera sees"))?;
    let [right, up, forward] = camera.basis();
    Ok(FrameCamera { eye: camera.eye(), right, up, forward, pixel_side: camera.pixel_side() })
}

impl Drawn {
    /// Whether it is what was asked for: by its expected error, or by its rays.
    pub(super) fn has_reached(&self, budget: &Budget) -> Option<conray::Ended> {
        let enough = self.found.rays >= u64::from(budget.rays) * self.found.points;
        let right = budget.error.is_some_and(|error| self.found.expected_rmse <= f64::from(error));
        match (right, enough) {
            (true, _) => Some(conray::Ended::Error),
            (_, true) => Some(conray::Ended::Rays),
            _ => None,
        }
    }

    /// All planes.
    pub(super) fn planes(&self) -> planes::EstimatePlanes {
        let plane = |of: fn(&FramePixel) -> f32| {
            Arc::new(
                self.pixels.iter().map(|pixel| pixel.as_ref().map_or(f32::NAN, of)).collect::<Vec<f32>>(),
            )
        };
        planes::EstimatePlanes {
            visibility: plane(|pixel| pixel.visibility),
            error: plane(|pixel| pixel.error),
            rays: plane(|pixel| pixel.rays as f32),
            cones: None,
        }
    }

    /// How surfaces face the camera.
    pub(super) fn facing(&self, eye: Vec3) -> planes::Facing {
        let facing =
            |pixel: &FramePixel| (eye - pixel.position).normalize_or_zero().dot(pixel.normal).clamp(0.0, 1.0);
        let values = self.pixels.iter().map(|pixel| pixel.as_ref().map_or(f32::NAN, facing));
        planes::Facing { plane: Arc::new(values.collect()) }
    }

    /// The estimates of points that have their pixels as ids; of no value where the device saw nothing there.
    pub(super) fn estimates(&self, points: &[SurfacePoint]) -> Vec<Estimate> {
        let estimate = |point: &SurfacePoint| {
            let pixel = self.pixels.get(point.id as usize).copied().flatten();
            pixel.map_or(Estimate::INVALID, |FramePixel { visibility, error, rays, .. }| Estimate {
                visibility,
                error,
                rays,
                // Devices keep no directions of pictures.
                bent: visibility * point.shading_normal,
                cone: None,
            })
        };
        points.iter().map(estimate).collect()
    }
}
