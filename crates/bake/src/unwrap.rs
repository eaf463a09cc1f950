//! New UVs for surfaces that have none that suit.

use crate::{MAX_MAP_SIDE, MapExtent, extent::world_corners};
use conray_core::{Geometry, Vec2};
use conray_target::MapSize;
use uvunwrap::{Density, MeshInput, Options, generate};

/// Texels between charts and the map's rim, and half of those between charts: taps and the first levels of a mipmap stay apart.
const PADDING: u32 = 2;

/// UVs of one surface: its triangles with vertices of their own, split where the map is cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewUvs {
    /// For each new vertex the vertex of the scene's mesh that it is.
    pub vertices: Vec<u32>,
    /// UVs of the new vertices.
    pub uvs: Vec<Vec2>,
    /// The mesh's triangles, in order, by new vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl NewUvs {
    /// UVs of the corners of the triangles.
    pub fn corners(&self) -> Vec<[Vec2; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|vertex| self.uvs[vertex as usize])).collect()
    }
}

/// Lays surfaces out together in a map of at most that size, or as large as it must be for a density, in world units, so that texels are of one size on all of them. Tells the size that the
/// map has: rows that are not needed are left out.
///
/// # Errors
/// Why they cannot be laid out, for people.
pub(crate) fn unwrapped(
    geometry: &Geometry,
    instances: &[u32],
    extent: MapExtent,
) -> Result<(MapSize, Vec<NewUvs>), String> {
    let meshes: Vec<(Vec<[f32; 3]>, Vec<u32>)> = instances
        .iter()
        .map(|&instance| {
            let placed = &geometry.instances()[instance as usize];
            let mesh = geometry.mesh_of(instance as usize);
            let world = |&p: &conray_core::Vec3| placed.world_from_mesh.transform_point3(p).to_array();
            (mesh.positions().iter().map(world).collect(), mesh.triangles().concat())
        })
        .collect();
    let inputs: Vec<MeshInput<'_>> =
        meshes.iter().map(|(positions, indices)| MeshInput::new(positions, indices)).collect();
    let (density, side) = match extent {
        MapExtent::Size(size) => {
            let page_size = size.width.min(size.height);
            (Density::Auto { page_size }, page_size)
        }
        MapExtent::Density(texels_per_unit) => {
            let side = (area(geometry, instances).sqrt() * f64::from(texels_per_unit)).ceil();
            if side > f64::from(MAX_MAP_SIDE) {
                return Err(format!(
                    "it would need a map of {side} texels on each side; choose less --density"
                ));
            }
            (Density::Fixed { texels_per_unit, page_size: None }, MAX_MAP_SIDE)
        }
    };
    let options = Options { density, padding: PADDING, ..Options::default() };
    let atlas = generate(&inputs, &options).map_err(|e| e.to_string())?;
    if atlas.page_count > 1 {
        return Err(format!("{} charts do not fit into one map of {side} texels", atlas.chart_count));
    }
    let uvs = atlas.meshes.iter().map(|mesh| NewUvs {
        vertices: mesh.vertices.iter().map(|vertex| vertex.xref).collect(),
        uvs: mesh.vertices.iter().map(|vertex| Vec2::from_array(vertex.uv)).collect(),
        triangles: mesh.indices.as_chunks::<3>().0.to_vec(),
    });
    Ok((MapSize { width: atlas.width, height: atlas.height }, uvs.collect()))
}

/// World area of surfaces.
fn area(geometry: &Geometry, instances: &[u32]) -> f64 {
    let of = |&instance: &u32| {
        let triangles = 0..geometry.mesh_of(instance as usize).triangles().len();
        let area = |triangle| {
            let [a, b, c] = world_corners(geometry, instance, triangle).map(|p| p.as_dvec3());
            0.5 * (b - a).cross(c - a).length()
        };
        triangles.map(area).sum::<f64>()
    };
    instances.iter().map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Affine3A, TriangleMesh, Vec3};
    use conray_target::UvUse;

    /// A closed box, each corner one vertex.
    fn solid() -> TriangleMesh {
        let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap()
    }

    fn square(side: u32) -> MapExtent {
        MapExtent::Size(MapSize { width: side, height: side })
    }

    #[test]
    fn texels_are_as_large_as_the_density_says() {
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(solid()).unwrap();
        geometry.add_instance(mesh, Affine3A::from_scale(Vec3::splat(3.0))).unwrap();
        for density in [10.0, 40.0] {
            let (size, found) = unwrapped(&geometry, &[0], MapExtent::Density(density)).unwrap();
            let share = UvUse::of(&found[0].corners(), 16).area;
            let texels = share * f64::from(size.width) * f64::from(size.height);
            let expected = 6.0 * 9.0 * f64::from(density).powi(2);
            assert!((texels / expected - 1.0).abs() < 0.02, "{texels} of {expected}");
        }
        let refused = unwrapped(&geometry, &[0], MapExtent::Density(1e5)).unwrap_err();
        assert_eq!(refused, "it would need a map of 734847 texels on each side; choose less --density");
    }

    #[test]
    fn surfaces_are_laid_out_without_overlap_and_in_one_density() {
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(solid()).unwrap();
        for scale in [1.0, 2.0] {
            geometry.add_instance(mesh, Affine3A::from_scale(Vec3::splat(scale))).unwrap();
        }
        let (size, found) = unwrapped(&geometry, &[0, 1], square(256)).unwrap();
        assert!(size.width <= 256 && size.height <= 256);
        let all: Vec<[Vec2; 3]> = found.iter().flat_map(NewUvs::corners).collect();
        let judged = UvUse::of(&all, 512);
        assert!(judged.outside.is_none() && judged.area > 0.3, "{judged:?}");
        assert!(judged.overlap < 1e-3 * judged.area, "{judged:?}");
        let area = |uvs: &NewUvs| UvUse::of(&uvs.corners(), 16).area;
        assert!((area(&found[1]) / area(&found[0]) - 4.0).abs() < 0.05, "one density in the world");
        // The triangles are the mesh's own.
        for uvs in &found {
            let before: Vec<[u32; 3]> =
                uvs.triangles.iter().map(|t| t.map(|vertex| uvs.vertices[vertex as usize])).collect();
            assert_eq!(before, geometry.meshes()[0].triangles());
        }
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(solid()).unwrap();
        let instance = geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        let found = unwrapped(&geometry, &[instance], square(1));
        assert!(found.is_err_and(|reason| !reason.is_empty()));
    }
}
