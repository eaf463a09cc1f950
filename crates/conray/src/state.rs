//! Refinements kept in files, so that work goes on where it was stopped.

use crate::{Error, Session};
use conray_core::{Fingerprint, SurfacePoint};
use conray_estimate::{AoPlan, Hybrid};
use conray_target::write_atomically;
use std::{fs::File, io::ErrorKind, io::Read, path::Path};

impl Session {
    /// Writes a refinement to a file, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Target`] where the file cannot be written.
    pub fn save(
        &self,
        hybrid: &Hybrid,
        plan: &AoPlan,
        points: &[SurfacePoint],
        path: &Path,
    ) -> Result<(), Error> {
        Ok(write_atomically(path, |out| hybrid.save(plan, self.fingerprint(), points, out))?)
    }

    /// Takes up the refinement that a file holds in place of one without a ray yet, which comes back as it is where there is no
    /// file.
    ///
    /// # Errors
    /// [`Error::StateFile`] where the file cannot be read, [`Error::State`] where it is damaged or of other work.
    pub fn load(
        &self,
        hybrid: Hybrid,
        plan: &AoPlan,
        points: &[SurfacePoint],
        path: &Path,
    ) -> Result<Hybrid, Error> {
        let unreadable = |e: std::io::Error| Error::StateFile { path: path.into(), reason: e.to_string() };
        let file = match File::open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(hybrid),
            Err(e) => return Err(unreadable(e)),
        };
        let mut bytes = Vec::new();
        // A file of any length takes no more memory than the longest that can be right.
        file.take(hybrid.most_saved_bytes() + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        self.install(|| hybrid.load(plan, self.fingerprint(), points, self.bvh.level(), &bytes))
            .map_err(|problem| Error::State { path: path.into(), problem })
    }

    /// Stands for what occludes.
    fn fingerprint(&self) -> Fingerprint {
        Fingerprint::of(|feed| feed.geometry(&self.geometry))
    }
}
