//! From maps to the places where AO is asked for, and where a smooth surface is cut.

use crate::{Facing, Sheets, Uvs};
use conray::Session;
use conray_core::{Geometry, Vec2, Vec3};
use conray_target::{Atlas, AtlasTarget, Corner, MapSize, Portion, Seam, Surface, seams};

/// The surfaces that read maps.
#[derive(Clone, Debug)]
pub struct Places {
    /// Which way points look.
    pub facing: Facing,
    /// The maps and their surfaces.
    pub atlas: Atlas,
    /// The scene's instance of each surface.
    pub instances: Vec<u32>,
    /// Which surfaces read their map by the first UV set that they had.
    pub reads_first_set: Vec<bool>,
}

impl Places {
    /// Those of a model's maps, each texel divided into `supersample` parts in both directions. `v_up` where the first row of an image is at v = 1,
    /// as in OBJ files.
    pub fn of(geometry: &Geometry, sheets: &Sheets, v_up: bool, supersample: u32, facing: Facing) -> Self {
        let (instances, surfaces) = sheets.surfaces(geometry, v_up).into_iter().unzip();
        let sizes = sheets.sheets.iter().map(|sheet| sheet.size).collect();
        let atlas = Atlas { sizes, surfaces, supersample: supersample.max(1) };
        let is_first = |surface: &Surface| matches!(sheets.sheets[surface.map].uvs, Uvs::Set(0));
        let reads_first_set = atlas.surfaces.iter().map(is_first).collect();
        Self { facing, atlas, instances, reads_first_set }
    }

    /// The texels of a portion as a target: estimate it with [`Session::run_target`], and its [`resolve`](conray_target::Target::resolve) gives what
    /// becomes of each.
    pub fn texels(&self, session: &Session, portion: &Portion) -> AtlasTarget {
        // Once for each triangle, not for each of its texels.
        let texel_sizes = |(surface, &instance): (&Surface, &u32)| {
            let MapSize { width, height } = self.atlas.sizes[surface.map];
            let scale = Vec2::new(width as f32, height as f32);
            let of = |(triangle, uvs): (u32, &[Vec2; 3])| {
                texel_size(session.bvh().world_corners(instance, triangle), uvs.map(|uv| uv * scale))
            };
            (0..).zip(&surface.uvs).map(of).collect()
        };
        let texel_sizes: Vec<Vec<f32>> =
            self.atlas.surfaces.iter().zip(&self.instances).map(texel_sizes).collect();
        let point = |surface: usize, triangle: usize, weights: [f32; 3]| {
            let (at, place) = ([self.instances[surface], triangle as u32], [weights[1], weights[2]]);
            let footprint = texel_sizes[surface][triangle];
            self.facing.point(session, at, place, footprint, footprint / self.atlas.supersample as f32)
        };
        session.install(|| self.atlas.texels(portion, point))
    }

    /// The seams of the surfaces.
    pub fn seams(&self, session: &Session) -> Vec<Seam> {
        let corners = |surface: usize, triangle: usize| {
            let (instance, triangle) = (self.instances[surface], triangle as u32);
            let positions = session.bvh().world_corners(instance, triangle);
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|weights| {
                let normal = session.bvh().front_point(instance, triangle, weights).shading_normal;
                let position = positions[usize::from(weights[0] > 0.0) + 2 * usize::from(weights[1] > 0.0)];
                Corner { position, normal }
            })
        };
        session.install(|| seams(&self.atlas.surfaces, corners))
    }
}

/// World size of a texel on a triangle; 0, which is not known, where the triangle has no area in the map.
fn texel_size([a, b, c]: [Vec3; 3], [u, v, w]: [Vec2; 3]) -> f32 {
    let world = (b - a).cross(c - a).length();
    let texels = (v - u).perp_dot(w - u).abs();
    if texels > 0.0 { (world / texels).sqrt() } else { 0.0 }
}
