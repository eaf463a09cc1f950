//! The cameras of a glTF as views.

use super::data::get;
use super::nodes::Placed;
use super::schema::Root;
use crate::WarningKind;
use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use conray_core::{Vec3, View};

/// More cameras than this are not read.
const MAX_VIEWS: usize = 1000;

/// Adds a view for each node with a perspective camera; others are warned about.
///
/// Cameras look along -z with y up ("glTF 2.0 Specification", section 3.10). The point looked at is as far as the
/// middle of the scene.
pub(super) fn add(root: &Root, placed: &[Placed], intake: &mut Intake) -> Result<(), Fault> {
    let bounds = intake.scene.geometry.bounds();
    for place in placed {
        let node = &root.nodes[place.node];
        let Some(index) = node.camera else { continue };
        let camera = get(&root.cameras, index, "camera", &format!("node {}", place.node))?;
        if intake.scene.views.len() == MAX_VIEWS {
            intake.scene.warn(
                WarningKind::IgnoredFeature,
                1,
                format!("camera {index}, one of more than {MAX_VIEWS}"),
            );
            continue;
        }
        let m = &place.world_from_node;
        let eye = Vec3::from(m.translation);
        let ahead = m.transform_vector3(Vec3::NEG_Z).normalize_or_zero();
        let up = m.transform_vector3(Vec3::Y).normalize_or_zero();
        let vertical_fov_deg = camera.perspective.as_ref().map_or(0.0, |p| p.yfov.to_degrees());
        let usable = vertical_fov_deg > 0.0 && vertical_fov_deg < 180.0 && ahead.cross(up) != Vec3::ZERO;
        if !usable {
            let kind =
                if camera.kind == "orthographic" { "orthographic camera" } else { "camera without a view" };
            intake.scene.warn(WarningKind::IgnoredFeature, 1, format!("{kind} {index}"));
            continue;
        }
        let to_middle = ahead.dot(bounds.centre() - eye);
        let reach = if to_middle > 0.0 { to_middle } else { bounds.diagonal().max(1.0) };
        let look_at = eye + reach * ahead;
        if !look_at.is_finite() || look_at == eye {
            intake.scene.warn(WarningKind::IgnoredFeature, 1, format!("camera {index}, out of range"));
            continue;
        }
        let name = [&node.name, &camera.name].into_iter().find(|name| !name.is_empty());
        let name = name.map_or_else(|| format!("camera {index}"), |name| shown(name.as_bytes()));
        let view = View { name: unused(&name, &intake.scene.views), eye, look_at, up, vertical_fov_deg };
        intake.scene.views.push(view);
    }
    Ok(())
}

/// The name, or the name with the first free number from 2.
fn unused(name: &str, views: &[View]) -> String {
    let taken = |name: &str| views.iter().any(|view| view.name == name);
    if !taken(name) {
        return name.to_string();
    }
    (2..).map(|i| format!("{name} {i}")).find(|name| !taken(name)).unwrap_or_default()
}
