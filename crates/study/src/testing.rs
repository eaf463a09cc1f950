//! Cases for tests.

use crate::Case;
use conray::{AoSettings, Geometry, Method, Session, View, scene::builtin};
use std::sync::Arc;

/// The built-in `cornell` from its usual view, square, that many pixels wide; 64 voxels.
pub(crate) fn test_case(size: u32) -> Case {
    let scene = builtin("cornell").unwrap();
    let view = scene.default_view();
    case_of(scene.geometry, view, size, AoSettings { voxels: 64, ..AoSettings::default() })
}

/// A case of any geometry.
pub(crate) fn case_of(geometry: Geometry, view: View, size: u32, settings: AoSettings) -> Case {
    let built = AoSettings { method: Method::Paper, ..settings.clone() };
    let session = Arc::new(Session::build(geometry, &built).unwrap());
    let target = session.camera(&view, size, size).unwrap();
    Case {
        id: format!("test-{}", view.name),
        scene: "test".into(),
        view,
        places: Vec::new(),
        session,
        target,
        settings,
    }
}
