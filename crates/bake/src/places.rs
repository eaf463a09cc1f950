//! From maps to the places where AO is asked for, and where a smooth surface is cut.

use crate::{Sheets, buried};
use conray::Session;
use conray_core::{Estimate, Geometry, SurfacePoint, Vec2, Vec3};
use conray_target::{AtlasTarget, Corner, MapSize, Seam, Surface, Target, seams};

/// The surfaces that read maps.
#[derive(Clone, Debug)]
pub struct Places {
    sizes: Vec<MapSize>,
    instances: Vec<u32>,
    surfaces: Vec<Surface>,
}

impl Places {
    /// Those of a model's maps. `v_up` where the first row of an image is at v = 1, as in OBJ files.
    pub fn of(geometry: &Geometry, sheets: &Sheets, v_up: bool) -> Self {
        let (instances, surfaces) = sheets.surfaces(geometry, v_up).into_iter().unzip();
        Self { sizes: sheets.sheets.iter().map(|sheet| sheet.size).collect(), instances, surfaces }
    }

    /// The texels as a target: estimate it with [`Session::run_target`], and its [`resolve`](conray_target::Target::resolve) gives a map for each
    /// sheet. For `supersample` see [`AtlasTarget::new`].
    pub fn texels(&self, session: &Session, supersample: u32) -> AtlasTarget {
        // Once for each triangle, not for each of its texels.
        let texel_sizes = |(surface, &instance): (&Surface, &u32)| {
            let MapSize { width, height } = self.sizes[surface.map];
            let scale = Vec2::new(width as f32, height as f32);
            let of = |(triangle, uvs): (u32, &[Vec2; 3])| {
                texel_size(session.bvh().world_corners(instance, triangle), uvs.map(|uv| uv * scale))
            };
            (0..).zip(&surface.uvs).map(of).collect()
        };
        let texel_sizes: Vec<Vec<f32>> = self.surfaces.iter().zip(&self.instances).map(texel_sizes).collect();
        let point = |surface: usize, triangle: usize, weights: [f32; 3]| {
            let place = [weights[1], weights[2]];
            let point = session.bvh().front_point(self.instances[surface], triangle as u32, place);
            SurfacePoint { footprint: texel_sizes[surface][triangle], ..point }
        };
        session.install(|| AtlasTarget::new(self.sizes.clone(), &self.surfaces, supersample, point))
    }

    /// Takes back the estimates of texels that lie inside other geometry, so that they are filled from their neighbours; tells how many.
    pub fn unbury(&self, session: &Session, texels: &AtlasTarget, estimates: &mut [Estimate]) -> usize {
        let instances: Vec<u32> =
            texels.surfaces().iter().map(|&surface| self.instances[surface as usize]).collect();
        let buried = buried(session, texels.points(), estimates, &instances);
        for (estimate, _) in estimates.iter_mut().zip(&buried).filter(|(_, buried)| **buried) {
            *estimate = Estimate::PENDING;
        }
        buried.iter().filter(|buried| **buried).count()
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
        session.install(|| seams(&self.surfaces, corners))
    }
}

/// World size of a texel on a triangle; 0, which is not known, where the triangle has no area in the map.
fn texel_size([a, b, c]: [Vec3; 3], [u, v, w]: [Vec2; 3]) -> f32 {
    let world = (b - a).cross(c - a).length();
    let texels = (v - u).perp_dot(w - u).abs();
    if texels > 0.0 { (world / texels).sqrt() } else { 0.0 }
}
