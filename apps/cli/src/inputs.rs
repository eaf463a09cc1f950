//! Scenes by name or path, and views.

use crate::{
    args::{CameraArgs, GivenCameraArgs},
    failure::Failure,
};
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
pub(crate) fn choose_view(scene: &Scene, args: &CameraArgs) -> Result<View, Failure> {
    let mut view = match &args.view {
        Some(name) => named_view(scene, name).ok_or_else(|| no_such_view(&[scene], name))?,
        None => given_view(&args.given).unwrap_or_else(|| scene.default_view()),
    };
    view.vertical_fov_deg = args.given.fov.unwrap_or(view.vertical_fov_deg);
    view.up = args.given.up.unwrap_or(view.up);
    Ok(view)
}

/// A view of the scene by its name; `whole` is always there.
pub(crate) fn named_view(scene: &Scene, name: &str) -> Option<View> {
    scene.view(name).cloned().or_else(|| (name == "whole").then(|| scene.whole_view()))
}

/// The camera given by its numbers.
pub(crate) fn given_view(args: &GivenCameraArgs) -> Option<View> {
    let (eye, look_at) = (args.eye?, args.look_at?);
    let up = args.up.unwrap_or(Vec3::Y);
    Some(View { name: "given".into(), eye, look_at, up, vertical_fov_deg: args.fov.unwrap_or(50.0) })
}

/// Says which views there are.
pub(crate) fn no_such_view(scenes: &[&Scene], name: &str) -> Failure {
    let known = |scene: &&Scene| {
        let names: Vec<&str> =
            scene.views.iter().map(|v| &v.name[..]).chain(std::iter::once("whole")).collect();
        format!("{} has {}", scene.name, names.join(", "))
    };
    Failure::Request(format!("--view {name}: {}", scenes.iter().map(known).collect::<Vec<_>>().join("; ")))
}
