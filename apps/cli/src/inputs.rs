//! Scenes by name or path, and views.

use crate::{args::RenderArgs, failure::Failure};
use conray::{
    Vec3, View,
    scene::{self, Scene},
};
use std::path::Path;

/// A built-in scene by its name, else a file.
pub(crate) fn load_scene(name: &str) -> Result<Scene, Failure> {
    let path = Path::new(name);
    if let Some(scene) = scene::builtin(name) {
        return Ok(scene);
    }
    if !path.exists() && path.extension().is_none() {
        let names = scene::BUILTIN_NAMES.join(", ");
        return Err(Failure::Input(format!("{name}: no such file, and no built-in scene ({names})")));
    }
    Ok(scene::load(path, &scene::Limits::default())?)
}

/// The view that the options ask for.
pub(crate) fn choose_view(scene: &Scene, args: &RenderArgs) -> Result<View, Failure> {
    let mut view = match (&args.view, args.eye, args.look_at) {
        (Some(name), ..) => match scene.view(name) {
            Some(view) => view.clone(),
            None if name == "whole" => scene.whole_view(),
            None => {
                let names: Vec<&str> =
                    scene.views.iter().map(|v| &v.name[..]).chain(std::iter::once("whole")).collect();
                return Err(Failure::Request(format!(
                    "--view {name}: {} has {}",
                    scene.name,
                    names.join(", ")
                )));
            }
        },
        (None, Some(eye), Some(look_at)) => {
            View { name: "given".into(), eye, look_at, up: Vec3::Y, vertical_fov_deg: 50.0 }
        }
        _ => scene.default_view(),
    };
    view.vertical_fov_deg = args.fov.unwrap_or(view.vertical_fov_deg);
    view.up = args.up.unwrap_or(view.up);
    Ok(view)
}
