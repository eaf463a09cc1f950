//! Work on a device: whole pictures by method `hybrid`, passes over points by the others. Answers come later, since a page may not wait for them.

use super::{Wish, planes};
use conray::{
    AoSettings, BackendError, Budget, Device, Error, Estimate, Method, RayErrors, Session, SurfacePoint,
    Vec3,
    gpu::{FrameCamera, FrameFound, FramePixel, Frames, Gpu, GpuBackend, GpuError},
    target::{Camera, TargetError},
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

/// A scene on a device, and room for the picture of each side.
pub(super) struct Pictures {
    backend: Arc<GpuBackend>,
    /// What was uploaded, by the sessions that share it.
    scene: Scene,
    /// One a side, where it has one.
    rooms: Vec<Option<Room>>,
}

/// What sessions have of a scene.
type Scene = (Arc<conray::Bvh>, Option<Arc<conray::Octree>>);

/// Room for pictures of one size by one side's settings.
struct Room {
    made_for: (AoSettings, [u32; 2]),
    frames: Frames,
    /// Rays a pixel that are asked for next.
    rays: f32,
}

/// The picture of one side so far.
pub(super) struct Drawn {
    pub(super) found: FrameFound,
    pixels: Vec<Option<FramePixel>>,
}

/// Whether a wish asks for a device, for plans of which it has at least one.
pub(super) fn are_wished(sessions: &[Session], wish: &Wish) -> bool {
    wish.device != Device::Cpu && sessions.iter().any(|session| GpuBackend::check(session.plan()).is_ok())
}

/// What a device needs of these sessions: the octree is the first that a method asks for.
fn scene_of(sessions: &[Session]) -> Option<Scene> {
    let marching = |session: &&Session| session.plan().method.needs_octree();
    let octree = sessions.iter().filter(marching).find_map(Session::octree);
    Some((Arc::clone(sessions.first()?.bvh()), octree.cloned()))
}

fn has_all_of(scene: &Scene, wanted: &Scene) -> bool {
    let has_octree =
        |wanted: &Arc<conray::Octree>| scene.1.as_ref().is_some_and(|octree| Arc::ptr_eq(octree, wanted));
    Arc::ptr_eq(&scene.0, &wanted.0) && wanted.1.as_ref().is_none_or(has_octree)
}

impl Pictures {
    /// Uploads what sessions have. A program on the CPU counts where a device or its name is asked for.
    pub(super) async fn open(sessions: &[Session], wish: &Wish) -> Result<Self, GpuError> {
        let (Some(first), Some(scene)) = (sessions.first(), scene_of(sessions)) else {
            return Err(GpuError::Unsupported("a scene that is not built"));
        };
        let gpu = match (wish.device, &wish.adapter) {
            (Device::Auto, None) => Gpu::open_real_later().await?,
            (_, name) => Gpu::open_later(name.as_deref()).await?,
        };
        let backend = GpuBackend::new(gpu, Some(first.geometry()), scene.1.as_deref())?;
        Ok(Self { backend: Arc::new(backend), scene, rooms: Vec::new() })
    }

    /// Where they are made, for people.
    pub(super) fn place(&self) -> String {
        let facts = self.backend.gpu().facts();
        let software = if facts.is_software { ", a program on the CPU" } else { "" };
        format!("{} ({}{software})", facts.name, facts.backend)
    }

    /// Whether a wish by these sessions would have opened the same device with the same scene.
    pub(super) fn are_of(&self, sessions: &[Session], wish: &Wish) -> bool {
        let is_meant = wish.device == Device::Gpu || wish.adapter.is_some();
        wish.device != Device::Cpu
            && (is_meant || !self.backend.gpu().facts().is_software)
            && scene_of(sessions).is_some_and(|wanted| has_all_of(&self.scene, &wanted))
    }

    /// Whether a session's plan is carried out here: all but what devices have not, and octrees beside the first.
    pub(super) fn serve(&self, session: &Session) -> bool {
        let octree = session.octree().filter(|_| session.plan().method.needs_octree());
        GpuBackend::check(session.plan()).is_ok()
            && has_all_of(&self.scene, &(Arc::clone(session.bvh()), octree.cloned()))
    }

    /// Whether the pictures of a session are made here as a whole.
    pub(super) fn draw_for(&self, session: &Session) -> bool {
        session.plan().method == Method::Hybrid && self.serve(session)
    }

    /// Where passes are carried out.
    pub(super) fn backend(&self) -> &GpuBackend {
        &self.backend
    }

    /// The first picture of a side, or more rays for the one before.
    pub(super) async fn draw(
        &mut self,
        side: usize,
        session: &Session,
        wish: &Wish,
        before: Option<&Drawn>,
    ) -> Result<Drawn, Error> {
        let camera = camera_of(wish)?;
        self.drawn(side, session, wish, &camera, before)
            .await
            .map_err(|e| BackendError::Device(e.to_string()).into())
    }

    async fn drawn(
        &mut self,
        side: usize,
        session: &Session,
        wish: &Wish,
        camera: &FrameCamera,
        before: Option<&Drawn>,
    ) -> Result<Drawn, GpuError> {
        let (plan, made_for) = (session.plan(), (wish.sides[side].clone(), wish.size));
        self.rooms.resize_with(wish.sides.len(), || None);
        let is_same = self.rooms[side].as_ref().is_some_and(|room| room.made_for == made_for);
        if !is_same {
            // Room is given back before more is taken.
            self.rooms[side] = None;
        }
        let room = match &mut self.rooms[side] {
            Some(room) => room,
            empty => {
                let frames = self.backend.frames(plan, session.bounds(), wish.size)?;
                empty.insert(Room { made_for, frames, rays: FIRST_RAYS })
            }
        };
        let start = Instant::now();
        let (found, is_first) = match before {
            Some(_) if is_same => (room.frames.refine_later(room.rays, &RayErrors::UNKNOWN).await?, false),
            _ => (room.frames.render_later(camera, FIRST_RAYS, &RayErrors::UNKNOWN).await?, true),
        };
        let seconds = start.elapsed().as_secs_f64();
        room.rays = match seconds {
            _ if is_first => FIRST_RAYS,
            soon if soon < SOON_SECONDS => (2.0 * room.rays).min(RAYS[1]),
            late if late > LATE_SECONDS => (0.5 * room.rays).max(RAYS[0]),
            _ => room.rays,
        };
        Ok(Drawn { found, pixels: room.frames.pixels_later().await? })
    }
}

fn camera_of(wish: &Wish) -> Result<FrameCamera, TargetError> {
    let [width, height] = wish.size;
    let camera = Camera::new(&wish.look.view("view"), width, height)?;
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
