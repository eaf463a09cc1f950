//! How large maps are.

use conray_core::{Geometry, Vec2, Vec3};
use conray_target::MapSize;

/// Texels on a side of a map at most.
pub const MAX_MAP_SIDE: u32 = 16384;
/// Sides of maps by density are multiples of this: the blocks of compressed textures.
const BLOCK: u32 = 4;

/// How large maps are to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapExtent {
    /// Each of that size.
    Size(MapSize),
    /// So many texels for each unit of length in the world, more than 0: each map as large as its surfaces need for that in the mean.
    Density(f32),
}

impl MapExtent {
    /// The size of a map that surfaces read by the UVs of their triangles. By density it may be more than [`MAX_MAP_SIDE`].
    pub(crate) fn by(self, geometry: &Geometry, uvs: &[(u32, Vec<[Vec2; 3]>)]) -> MapSize {
        let density = match self {
            Self::Size(size) => return size,
            Self::Density(density) => f64::from(density),
        };
        let mut sums = [0.0f64; 3];
        for (instance, uvs) in uvs {
            for (triangle, uvs) in uvs.iter().enumerate() {
                let [along_u, along_v, area] = lengths(world_corners(geometry, *instance, triangle), *uvs);
                sums = [sums[0] + along_u, sums[1] + along_v, sums[2] + area];
            }
        }
        let side = |sum: f64| {
            let texels = if sums[2] > 0.0 { density * sum / sums[2] } else { 0.0 };
            // Less than a thousandth of a texel is the rounding of UVs.
            ((texels - 1e-3).ceil() as u32).max(1).div_ceil(BLOCK).saturating_mul(BLOCK)
        };
        MapSize { width: side(sums[0]), height: side(sums[1]) }
    }
}

/// A triangle's corners in the world.
pub(crate) fn world_corners(geometry: &Geometry, instance: u32, triangle: usize) -> [Vec3; 3] {
    let world_from_mesh = geometry.instances()[instance as usize].world_from_mesh;
    geometry.mesh_of(instance as usize).corners(triangle).map(|p| world_from_mesh.transform_point3(p))
}

/// World lengths of the map's sides by a triangle, each times the triangle's area in the map, and that area.
fn lengths([a, b, c]: [Vec3; 3], [u, v, w]: [Vec2; 3]) -> [f64; 3] {
    let (p, q) = ((b - a).as_dvec3(), (c - a).as_dvec3());
    let (s, t) = ((v - u).as_dvec2(), (w - u).as_dvec2());
    // Derivatives of the position by u and v are these over twice the area.
    let [by_u, by_v] = [p * t.y - q * s.y, q * s.x - p * t.x];
    [0.5 * by_u.length(), 0.5 * by_v.length(), 0.5 * s.perp_dot(t).abs()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Affine3A, TriangleMesh};

    /// A rectangle of that size, which covers a quarter of the map in both directions.
    fn size(width: f32, height: f32, scale: f32, extent: MapExtent) -> MapSize {
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        let positions = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        let mut geometry = Geometry::default();
        let mesh =
            geometry.add_mesh(TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap();
        geometry.add_instance(mesh, Affine3A::from_scale(Vec3::splat(scale))).unwrap();
        let [a, b, c, d] = corners.map(|[x, y]| Vec2::new(0.5 + 0.25 * x / width, 0.5 + 0.25 * y / height));
        extent.by(&geometry, &[(0, vec![[a, b, c], [a, c, d]])])
    }

    #[test]
    fn a_map_is_as_large_as_its_surfaces_need() {
        let found = size(3.0, 0.5, 2.0, MapExtent::Density(10.0));
        assert_eq!(found, MapSize { width: 240, height: 40 });
        assert_eq!(size(3.0, 0.5, 2.0, MapExtent::Density(1e9)).width, u32::MAX);
        assert_eq!(size(3.0, 0.5, 2.0, MapExtent::Density(1e-9)), MapSize { width: 4, height: 4 });
        let given = MapSize { width: 7, height: 9 };
        assert_eq!(size(3.0, 0.5, 2.0, MapExtent::Size(given)), given);
    }

    #[test]
    fn surfaces_without_area_in_the_map_have_the_least_size() {
        let extent = MapExtent::Density(10.0);
        assert_eq!(extent.by(&Geometry::default(), &[]), MapSize { width: 4, height: 4 });
    }
}
