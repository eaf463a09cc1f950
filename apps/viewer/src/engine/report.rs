//! What the engine tells the window.

use crate::{camera::Look, engine::wire};
use conray::Method;
use serde::{Deserialize, Serialize};
use std::{path::PathBuf, sync::Arc};

/// A message of the engine.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Report {
    /// A scene is open.
    Scene(SceneFacts),
    /// What was built for it, and where estimates are made.
    Built(Built),
    /// A picture, as good as it is by now.
    Picture(Box<Picture>),
    /// A stage of long work: its name, and the share that is done where that is known.
    Busy(String, Option<f32>),
    /// All that was wished for is shown.
    Idle,
    /// Something did not work; what is shown stays.
    Trouble(Trouble),
    /// The engine begins anew: scenes must be opened again.
    Lost,
    /// Something that one should know.
    Notice(String),
    /// The answer to a probe; `None` where the pixel sees nothing.
    Probe(Option<Box<Probe>>),
    /// Nodes of an octree.
    Boxes(Boxes),
    /// A truth, better from one to the next.
    Truth(Truth),
    /// A file was written.
    Written(PathBuf),
    /// The bytes of a file, its name first, for those who have no files.
    Bytes(String, #[serde(with = "wire::as_bytes")] Vec<u8>),
}

/// Whose work failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// A file that cannot be used.
    Input,
    /// Settings that do not go together.
    Request,
    /// The work itself.
    Work,
}

/// Something that did not work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trouble {
    /// By whose fault.
    pub fault: Fault,
    /// For people.
    pub message: String,
    /// The scene that could not be opened, if that is what failed.
    pub scene: Option<u64>,
}

/// What is in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneFacts {
    /// Its number.
    pub number: u64,
    /// Its name.
    pub name: String,
    /// As the program is told it: a name or a path.
    pub word: String,
    /// Triangles, those of placed copies counted each time.
    pub triangles: u64,
    /// Named views, `whole` the last; never empty.
    pub views: Vec<(String, Look)>,
    /// Diagonal of its bounds in world units.
    pub diagonal: f32,
    /// What was mended or ignored.
    pub warnings: Vec<String>,
}

/// What was built.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Built {
    /// Where the estimates of each side are made.
    pub places: Vec<String>,
    /// Levels of the octree; 0 without one.
    pub levels: u32,
    /// Edge of a leaf in world units; 0 without an octree.
    pub voxel_size: f32,
    /// AO distance in world units; may be infinite.
    pub distance: f32,
}

/// One number a pixel, row by row from the top; NaN where nothing is seen.
pub type Plane = Arc<Vec<f32>>;

/// What is shown.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Picture {
    /// From where.
    pub look: Look,
    /// The number of its scene.
    pub scene: u64,
    /// Width and height of the planes: fewer pixels than were wished for while it is a preview.
    pub size: [u32; 2],
    /// Width and height that were wished for.
    pub wished: [u32; 2],
    /// Cosine between shading normal and sight, in [0, 1].
    #[serde(with = "wire::plane")]
    pub facing: Plane,
    /// One or two.
    pub sides: Vec<SidePicture>,
    /// Seconds since the wish was taken up.
    pub seconds: f64,
}

impl Picture {
    /// True while it has fewer pixels than were wished for.
    pub fn is_preview(&self) -> bool {
        self.size != self.wished
    }
}

/// The estimates of one method.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SidePicture {
    /// By which method.
    #[serde(with = "wire::as_json")]
    pub method: Method,
    /// Visibility in [0, 1]: 1 is open.
    #[serde(with = "wire::plane")]
    pub visibility: Plane,
    /// Its expected error.
    #[serde(with = "wire::plane")]
    pub error: Plane,
    /// Rays traced for the pixel.
    #[serde(with = "wire::plane")]
    pub rays: Plane,
    /// What the cones said, where the method marches them.
    pub cones: Option<ConePlanes>,
    /// Expected RMSE over all pixels; infinite where that is not known.
    pub expected_rmse: f64,
    /// Rays a pixel on average.
    pub rays_per_pixel: f64,
    /// Seconds that its estimates took.
    pub seconds: f64,
    /// Why it gets no better, once it does not.
    pub ended: Option<String>,
}

/// What cones said.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ConePlanes {
    /// Visibility of the cones alone.
    #[serde(with = "wire::plane")]
    pub visibility: Plane,
    /// Their error (epsilon).
    #[serde(with = "wire::plane")]
    pub error: Plane,
    /// The weight of their result in the blend.
    #[serde(with = "wire::plane")]
    pub alpha: Plane,
}

/// A surface point looked at closely, in world space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// The pixel, of the wanted size.
    pub pixel: [u32; 2],
    /// Where it is.
    pub position: [f32; 3],
    /// Unit normal about which the hemisphere is taken.
    pub normal: [f32; 3],
    /// World size of the pixel there.
    pub footprint: f32,
    /// AO distance; may be infinite.
    pub distance: f32,
    /// Its cones; empty where there is no octree.
    pub cones: Vec<ProbedCone>,
    /// Some of its rays: unit direction, and how far the first surface in the way is.
    pub rays: Vec<([f32; 3], Option<f32>)>,
}

/// One cone of a probed point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbedCone {
    /// Unit axis in world space.
    pub axis: [f32; 3],
    /// Half of its aperture.
    pub half_angle_rad: f32,
    /// Its share of the hemisphere.
    pub weight: f32,
    /// Its visibility.
    pub visibility: f32,
    /// Its error (epsilon).
    pub error: f32,
    /// The weight of its result in the published blend.
    pub alpha: f32,
    /// Rays that the published blend sends into it.
    pub rays: u32,
}

/// Nodes of one level of an octree that the seen surfaces lie in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Boxes {
    /// Their level: 0 is the leaves.
    pub level: u32,
    /// Their edge in world units.
    pub edge: f32,
    /// Lowest corner and mean opacity of each, those that most pixels lie in first.
    pub nodes: Vec<([f32; 3], f32)>,
    /// How many there were before only the first were kept.
    pub found: usize,
}

/// What a picture is compared with.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Truth {
    /// As it was asked for.
    pub key: String,
    /// Width and height.
    pub size: [u32; 2],
    /// NaN where nothing is seen.
    #[serde(with = "wire::plane")]
    pub visibility: Plane,
    /// For people: how it came about.
    pub origin: String,
    /// Share of the work that is done: 1 at the end.
    pub done: f32,
}
