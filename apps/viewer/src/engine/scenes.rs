//! The scene that is open, and the sessions that answer for it.

use super::{
    Fault, Source, Trouble, Wish,
    report::{Built, SceneFacts},
};
use crate::camera::Look;
use conray::{
    Alpha, AoSettings, Error, Event, Observer, Session, SessionOptions,
    scene::{self, Limits, Scene},
};
use std::{io, path::Path};

/// A scene and what was built for it.
pub(super) struct Held {
    pub(super) number: u64,
    source: Source,
    /// As read; it moves into the first session.
    scene: Option<Scene>,
    /// One a side, in order.
    pub(super) sessions: Vec<Session>,
    /// The settings that they are by.
    sides: Vec<AoSettings>,
    alpha: Alpha,
}

impl Held {
    /// Reads a scene and tells what is in it.
    pub(super) fn open(number: u64, source: Source) -> Result<(Self, SceneFacts), Trouble> {
        let scene =
            read(&source).map_err(|message| Trouble { fault: Fault::Input, message, scene: Some(number) })?;
        let mut views: Vec<(String, Look)> =
            scene.views.iter().map(|view| (view.name.clone(), Look::of_view(view))).collect();
        views.retain(|(name, _)| name != "whole");
        views.push(("whole".into(), Look::of_view(&scene.whole_view())));
        let facts = SceneFacts {
            number,
            name: scene.name.clone(),
            word: source.word(),
            triangles: scene.geometry.triangle_count(),
            views,
            diagonal: scene.geometry.bounds().diagonal(),
            warnings: scene.warnings.iter().map(ToString::to_string).collect(),
        };
        let (sessions, sides) = (Vec::new(), Vec::new());
        let alpha = Alpha::default();
        Ok((Self { number, source, scene: Some(scene), sessions, sides, alpha }, facts))
    }

    /// Builds what a wish needs and is not there; where that fails all stays as it was.
    pub(super) fn prepare(&mut self, wish: &Wish, observer: Observer<'_>) -> Result<bool, Trouble> {
        if self.sides == wish.sides && !self.sessions.is_empty() {
            return Ok(false);
        }
        // On the CPU, on all of its threads: devices are asked beside it (pictures.rs).
        let options = SessionOptions::default();
        let trouble = |e: Error| trouble_of(&e);
        // What is wrong with settings is told before anything is built.
        for settings in &wish.sides {
            settings.validate().map_err(|e| trouble(e.into()))?;
        }
        let Some(first) = wish.sides.first() else { return Ok(false) };
        let built;
        let base = match self.sessions.iter().find(|s| s.octree().is_some()).or(self.sessions.first()) {
            Some(session) if self.alpha == first.alpha => session,
            // Opacity is in what is built: it is built anew, from the scene read again where it has moved already.
            _ => {
                let scene = match self.scene.take() {
                    Some(scene) => scene,
                    None => read(&self.source).map_err(|message| Trouble {
                        fault: Fault::Input,
                        message,
                        scene: None,
                    })?,
                };
                let session = Session::build_observed(scene.geometry, &plain(first), &options, observer);
                built = session.map_err(trouble)?;
                &built
            }
        };
        let mut sessions: Vec<Session> = Vec::new();
        for settings in &wish.sides {
            let base = sessions.iter().find(|s| s.octree().is_some()).unwrap_or(base);
            sessions.push(base.with(settings, &options, observer).map_err(trouble)?);
        }
        self.alpha = first.alpha;
        (self.sessions, self.sides) = (sessions, wish.sides.clone());
        Ok(true)
    }

    /// Builds the octree where no side has one.
    pub(super) fn need_octree(&mut self, observer: Observer<'_>) -> Result<bool, Trouble> {
        if self.sessions.iter().any(|s| s.octree().is_some()) {
            return Ok(false);
        }
        let (Some(session), Some(settings)) = (self.sessions.first(), self.sides.first()) else {
            return Ok(false);
        };
        let session = session
            .with_octree(settings, &SessionOptions::default(), observer)
            .map_err(|e| trouble_of(&e))?;
        self.sessions[0] = session;
        Ok(true)
    }

    /// The session that knows the octree, if one does.
    pub(super) fn with_octree(&self, side: usize) -> Option<&Session> {
        let own = self.sessions.get(side).filter(|s| s.octree().is_some());
        own.or_else(|| self.sessions.iter().find(|s| s.octree().is_some()))
    }

    /// The scene as the program is told it.
    pub(super) fn word(&self) -> String {
        self.source.word()
    }

    /// What there is by now.
    pub(super) fn built(&self) -> Built {
        let octree = self.with_octree(0).and_then(Session::octree);
        Built {
            places: self.sessions.iter().map(|s| s.report().device.clone()).collect(),
            levels: octree.map_or(0, |o| o.levels()),
            voxel_size: octree.map_or(0.0, |o| o.voxel_size()),
            distance: self.sessions.first().map_or(0.0, |s| s.plan().distance),
        }
    }
}

/// The settings of the first build, of the BVH alone: the rest is built where sides ask for it.
fn plain(settings: &AoSettings) -> AoSettings {
    let AoSettings { alpha, max_memory, distance, .. } = *settings;
    AoSettings { alpha, max_memory, distance, ..AoSettings::default() }
}

fn read(source: &Source) -> Result<Scene, String> {
    match source {
        Source::Builtin(name) => scene::builtin(name).ok_or_else(|| {
            format!("{name}: no such file, and no built-in scene ({})", scene::BUILTIN_NAMES.join(", "))
        }),
        Source::File(path) => scene::load(path, &Limits::default()).map_err(|e| e.to_string()),
        Source::Bytes(file, beside) => {
            let resolve = |name: &str| {
                let name = Path::new(name).file_name().unwrap_or_default();
                let found = beside.iter().find(|other| *other.name == *name);
                found.map(|other| other.bytes.to_vec()).ok_or_else(|| {
                    let message = "it was not dropped together with the scene";
                    io::Error::new(io::ErrorKind::NotFound, message)
                })
            };
            scene::load_bytes(&file.name, &file.bytes, None, &resolve, &limits_of_a_page())
                .map_err(|e| e.to_string())
        }
    }
}

/// A page has 4 GiB for all, and this is about what fits.
fn limits_of_a_page() -> Limits {
    Limits {
        max_file_bytes: 1 << 30,
        max_triangles: 12_000_000,
        max_vertices: 36_000_000,
        max_texture_pixels: 1 << 26,
        ..Limits::default()
    }
}

/// An error for people, by whose fault.
pub(super) fn trouble_of(error: &Error) -> Trouble {
    let fault = match error {
        Error::Scene(_) | Error::Geometry(_) => Fault::Input,
        Error::Settings(_) | Error::Device(_) | Error::Target(_) => Fault::Request,
        _ => Fault::Work,
    };
    Trouble { fault, message: error.to_string(), scene: None }
}

/// Names a stage for people.
pub(super) fn stage_of(event: &Event) -> Option<String> {
    match event {
        Event::Started { stage: conray::Stage::Bvh } => Some("building the BVH".into()),
        Event::Started { stage: conray::Stage::Octree } => Some("building the octree".into()),
        _ => None,
    }
}
