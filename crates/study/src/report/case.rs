//! One scene and view.

use super::{
    CauseReport, ConeReport, EqualTime, EstimateCalibration, Failure, Figure, TableRow, TrialReport,
    TunedReport,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything found for one scene and view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CaseReport {
    /// Unique in the report and fit for file names: `cornell-front`.
    pub id: String,
    /// Name of the scene.
    pub scene: String,
    /// The view.
    pub view: ViewReport,
    /// Triangles, placements counted.
    pub triangles: u64,
    /// Surface points: pixels that see the scene.
    pub points: usize,
    /// AO distance in world units; `None` is infinite.
    pub distance: Option<f64>,
    /// Leaves of the octree along the longest side of the scene.
    pub voxels: u32,
    /// Edge of a leaf in world units.
    pub voxel_size: f64,
    /// The truth.
    pub truth: TruthReport,
    /// Every method at every effort, method by method, efforts ascending.
    pub trials: Vec<TrialReport>,
    /// The paper's Table 1: rows for rays, cones and the blend at one frame.
    pub table: Vec<TableRow>,
    /// Each method against rays at equal time, from interpolated curves.
    pub equal_time: Vec<EqualTime>,
    /// The cones, looked at one by one.
    pub cones: ConeReport,
    /// The blend's constants found for each budget.
    pub tuned: Vec<TunedReport>,
    /// Predicted against true error of the estimates.
    pub calibration: Vec<EstimateCalibration>,
    /// What the squared error of cones and blend comes from.
    pub causes: Vec<CauseReport>,
    /// Where methods fail, with crops.
    pub failures: Vec<Failure>,
    /// The figures, those of the paper first.
    pub figures: Vec<Figure>,
    /// Times of building.
    pub timing: CaseTiming,
}

/// A view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ViewReport {
    /// Its name in the scene, or `given`.
    pub name: String,
    /// Position of the eye, world units.
    pub eye: [f32; 3],
    /// Point in the middle of the image.
    pub look_at: [f32; 3],
    /// Vertical field of view in degrees.
    pub vertical_fov_deg: f32,
}

/// How the truth was found and how far it can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TruthReport {
    /// Rays per point in all, over both halves.
    pub rays: u32,
    /// Its own error (RMSE), from two halves with independent random numbers: half the RMSE between them.
    pub error: f64,
    /// Smallest RMSE judged by it.
    pub smallest_judged: f64,
    /// `smallest_judged / error`. Below 3, the smallest errors are partly the truth's own.
    pub ratio: f64,
    /// Mean true visibility over the points.
    pub mean_visibility: f64,
}

/// Times of building what the contenders share, in seconds of wall-clock time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CaseTiming {
    /// Loading or making the scene.
    pub load_seconds: f64,
    /// The BVH.
    pub bvh_seconds: f64,
    /// The octree.
    pub octree_seconds: f64,
    /// Machine noise in this case; see the study's.
    pub noise: Option<f64>,
}
