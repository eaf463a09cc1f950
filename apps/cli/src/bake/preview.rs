//! `--preview`: what a bake will look like, at once, refined while it goes on.

use super::output::map_paths;
use crate::{args::BakeArgs, failure::Failure};
use conray::{
    Budget, Control, Session,
    target::{self, AtlasMap, PngDepth},
};
use conray_bake::{Apart, Look, MapOptions, Places, PngOptions, Sheets, bake_maps, file_names, png};
use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// Rays a texel of the first picture, or a point of vertices.
pub(super) const FIRST_RAYS: u32 = 2;
/// Pictures are written no oftener.
const PAUSE: Duration = Duration::from_secs(2);

/// Pictures that are being refined.
pub(super) struct Preview {
    paths: Vec<PathBuf>,
    maps: Vec<AtlasMap>,
    written: Instant,
}

/// Refuses a file that could not be written, before any work.
pub(super) fn check(args: &BakeArgs, for_vertices: bool) -> Result<(), Failure> {
    let Some(path) = &args.preview else { return Ok(()) };
    let expected = if for_vertices { "ply" } else { "png" };
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case(expected)) {
        let what = if for_vertices { "vertices" } else { "maps" };
        let problem = format!("--preview {}: must end in .{expected}, for {what}", path.display());
        return Err(Failure::Request(problem));
    }
    if *path == args.output() {
        return Err(Failure::Request(format!("--preview {}: is the output too", path.display())));
    }
    Ok(target::check_writable(path)?)
}

impl Preview {
    /// Writes the first pictures.
    pub(super) fn begin(
        path: &Path,
        session: &Session,
        apart: &[Apart],
        places: &Places,
        sheets: &Sheets,
        options: &MapOptions,
    ) -> Result<Self, Failure> {
        let maps = bake_maps(
            session,
            apart,
            places,
            Budget::rays(FIRST_RAYS),
            &MapOptions { state: None, ..options.clone() },
            Control::none(),
            &mut |_| {},
        )?
        .maps;
        let paths = map_paths(path, &file_names(sheets));
        let preview = Self { paths, maps, written: Instant::now() };
        preview.write()?;
        Ok(preview)
    }

    /// Takes over what is done of the maps; the next picture tells when the last could not be written.
    pub(super) fn refine(&mut self, done: &[AtlasMap]) {
        for (map, done) in self.maps.iter_mut().zip(done) {
            for (value, new) in map.visibility.iter_mut().zip(&done.visibility) {
                if !new.is_nan() {
                    *value = *new;
                }
            }
        }
        if self.written.elapsed() >= PAUSE {
            // A picture that is missed is followed by another, and the last one says what is wrong.
            _ = self.write();
            self.written = Instant::now();
        }
    }

    /// Writes the finished maps.
    pub(super) fn end(self, maps: &[AtlasMap]) -> Result<(), Failure> {
        Self { maps: maps.to_vec(), ..self }.write()
    }

    fn write(&self) -> Result<(), Failure> {
        for (path, map) in self.paths.iter().zip(&self.maps) {
            let bytes = png(map, PngOptions { depth: PngDepth::Eight, look: Look::default(), packs: false });
            target::write_atomically(path, |out| out.write_all(&bytes))?;
        }
        Ok(())
    }
}
