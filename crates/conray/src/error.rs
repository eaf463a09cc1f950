//! What can go wrong, by whose fault it is.

use thiserror::Error;

/// Any error of the library.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// Arrays that are no geometry: the input's fault.
    #[error(transparent)]
    Geometry(#[from] conray_core::GeometryError),
    /// A file that is no scene: the input's fault.
    #[error(transparent)]
    Scene(#[from] conray_scene::SceneError),
    /// A setting outside its range: the caller's fault.
    #[error(transparent)]
    Settings(#[from] conray_estimate::SettingsError),
    /// A target that cannot be read, made or written.
    #[error(transparent)]
    Target(#[from] conray_target::TargetError),
    /// The BVH could not be built.
    #[error(transparent)]
    Bvh(#[from] conray_bvh::BvhError),
    /// The octree could not be built, within the memory allowed if a limit was set.
    #[error(transparent)]
    Voxel(#[from] conray_voxel::VoxelError),
    /// There is no such device, or it lacks something that the plan or the scene needs: the caller's fault.
    #[error("{0}")]
    Device(String),
    /// The backend lacks something that the plan needs.
    #[error(transparent)]
    Backend(#[from] conray_estimate::BackendError),
    /// Kept work that cannot be gone on with.
    #[error("{}: {problem}", path.display())]
    State {
        /// Its file.
        path: std::path::PathBuf,
        /// Why not.
        problem: conray_estimate::StateError,
    },
    /// A file of kept work that cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    StateFile {
        /// Its name.
        path: std::path::PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The machine gave no threads.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many were asked for; 0 for one a core.
        threads: usize,
        /// What the system says.
        reason: String,
    },
}
