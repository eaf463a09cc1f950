//! From maps to the places where AO is asked for.

use crate::Sheets;
use conray::Session;
use conray_core::{SurfacePoint, Vec2, Vec3};
use conray_target::AtlasTarget;

/// The texels of maps as a target: estimate it with [`Session::run_target`], and its [`resolve`](conray_target::Target::resolve) gives a map for
/// each sheet. For `supersample` see [`AtlasTarget::new`], for `v_up` [`Sheets::surfaces`].
pub fn texels(session: &Session, sheets: &Sheets, supersample: u32, v_up: bool) -> AtlasTarget {
    let (instances, surfaces): (Vec<u32>, Vec<_>) =
        sheets.surfaces(session.geometry(), v_up).into_iter().unzip();
    let sizes: Vec<_> = sheets.sheets.iter().map(|sheet| sheet.size).collect();
    let scale = |map: usize| Vec2::new(sizes[map].width as f32, sizes[map].height as f32);
    let point = |surface: usize, triangle: usize, weights: [f32; 3]| {
        let (instance, triangle_index) = (instances[surface], triangle as u32);
        let point = session.bvh().front_point(instance, triangle_index, [weights[1], weights[2]]);
        let corners = session.bvh().world_corners(instance, triangle_index);
        let uvs = surfaces[surface].uvs[triangle].map(|uv| uv * scale(surfaces[surface].map));
        SurfacePoint { footprint: texel_size(corners, uvs), ..point }
    };
    session.install(|| AtlasTarget::new(sizes.clone(), &surfaces, supersample, point))
}

/// World size of a texel on a triangle; 0, which is not known, where the triangle has no area in the map.
fn texel_size([a, b, c]: [Vec3; 3], [u, v, w]: [Vec2; 3]) -> f32 {
    let world = (b - a).cross(c - a).length();
    let texels = (v - u).perp_dot(w - u).abs();
    if texels > 0.0 { (world / texels).sqrt() } else { 0.0 }
}
