//! The same surfaces in more triangles.

use conray_core::{Geometry, GeometryError, TriangleMesh, Vec3};

/// Every triangle cut into `segments` times `segments` of the same shape; placements are kept; materials, texture
/// coordinates and normals are not, as opaque surfaces and geometric normals need none.
///
/// Corners on an edge that two triangles share are the same bits in both, so nothing opens between them.
///
/// # Errors
/// More vertices than indices reach.
pub fn tessellated(geometry: &Geometry, segments: u32) -> Result<Geometry, GeometryError> {
    let mut finer = Geometry::default();
    for mesh in geometry.meshes() {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for triangle in 0..mesh.triangles().len() {
            cut(mesh.corners(triangle), segments, &mut positions, &mut triangles);
        }
        finer.add_mesh(TriangleMesh::new(positions, triangles)?)?;
    }
    for instance in geometry.instances() {
        finer.add_instance(instance.mesh, instance.world_from_mesh)?;
    }
    Ok(finer)
}

/// One triangle into rows of small ones; they share corners among themselves.
fn cut(corners: [Vec3; 3], segments: u32, positions: &mut Vec<Vec3>, triangles: &mut Vec<[u32; 3]>) {
    let [a, b, c] = corners;
    let first = positions.len() as u32;
    // Row j has segments - j + 1 corners, from edge ca to edge bc.
    let index = |i: u32, j: u32| first + j * (2 * segments + 3 - j) / 2 + i;
    for j in 0..=segments {
        for i in 0..=segments - j {
            let weights = [segments - i - j, i, j].map(|w| w as f32);
            // On an edge one weight is 0, and a sum of two does not depend on their order.
            positions.push((a * weights[0] + b * weights[1] + c * weights[2]) / segments as f32);
        }
    }
    for j in 0..segments {
        for i in 0..segments - j {
            triangles.push([index(i, j), index(i + 1, j), index(i, j + 1)]);
            if i + j + 1 < segments {
                triangles.push([index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Affine3A;
    use std::collections::HashMap;

    fn area(geometry: &Geometry) -> f64 {
        let mesh = &geometry.meshes()[0];
        let area = |t| {
            let [a, b, c] = mesh.corners(t).map(|p: Vec3| p.as_dvec3());
            0.5 * (b - a).cross(c - a).length()
        };
        (0..mesh.triangles().len()).map(area).sum()
    }

    /// A tetrahedron with corners that no binary fraction holds.
    fn tetrahedron() -> Geometry {
        let corners = vec![
            Vec3::new(0.1, 0.2, 0.3),
            Vec3::new(1.1, 0.3, 0.7),
            Vec3::new(0.3, 1.7, 0.1),
            Vec3::ONE * 1.3,
        ];
        let triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(TriangleMesh::new(corners, triangles).unwrap()).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        geometry
    }

    #[test]
    fn count_and_area_are_right_and_nothing_opens() {
        for segments in [1, 2, 3, 7] {
            let finer = tessellated(&tetrahedron(), segments).unwrap();
            assert_eq!(finer.triangle_count(), 4 * u64::from(segments * segments));
            assert!((area(&finer) / area(&tetrahedron()) - 1.0).abs() < 1e-6);
            // A closed surface: every edge, by the bits of its ends, is run along once in each direction.
            let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
            let mesh = &finer.meshes()[0];
            for t in 0..mesh.triangles().len() {
                let bits = mesh.corners(t).map(|p| p.to_array().map(f32::to_bits));
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    *edges.entry([bits[a], bits[b]]).or_default() += 1;
                    *edges.entry([bits[b], bits[a]]).or_default() -= 1;
                }
            }
            assert!(edges.values().all(|&n| n == 0), "{segments} segments");
        }
    }
}
