//! A model with the UVs by which its maps are read, for files that are not written back: an OBJ and its materials.

use crate::{Sheets, Uvs, vertex::title};
use conray_core::{Geometry, Vec2, Vec3};
use conray_target::{TargetError, write_atomically};
use std::{
    io::{self, Write},
    path::Path,
};

/// Writes what reads maps as an OBJ in world space: an object for each surface, `vt` by the map's UVs, and materials by the names of the maps.
/// `names` are those of the materials; `v_up` is true where the scene's own UVs have the first row at v = 1, as the file's have. The material file that it names,
/// `library`, is [`write_mtl`]'s. The file is whole or not there.
///
/// # Errors
/// What the disc refuses.
///
/// # Panics
/// Where the sheets are not those of the scene.
pub fn write_mapped_obj(
    path: impl AsRef<Path>,
    geometry: &Geometry,
    sheets: &Sheets,
    names: &[String],
    library: &str,
    v_up: bool,
) -> Result<(), TargetError> {
    write_atomically(path, |out| {
        writeln!(out, "mtllib {library}")?;
        // Counted from 1, vertices, their UVs and normals each for themselves.
        let (mut vertex, mut normal) = (1, 1);
        for (sheet, name) in sheets.sheets.iter().zip(names) {
            for (instance, k) in sheet.readers() {
                let surface = Mapped::of(geometry, instance, &sheet.uvs, k, v_up);
                writeln!(out, "o {}\nusemtl {name}", title(geometry, instance))?;
                let (vertices, normals) = surface.write(out, geometry, instance, vertex, normal)?;
                (vertex, normal) = (vertex + vertices, normal + normals);
            }
        }
        Ok(())
    })
}

/// Writes materials that show images as their ambient and their plain colour, for [`write_mapped_obj`]. The file is whole or not there.
///
/// # Errors
/// What the disc refuses.
pub fn write_mtl(path: impl AsRef<Path>, names: &[String], images: &[String]) -> Result<(), TargetError> {
    write_atomically(path, |out| {
        for (name, image) in names.iter().zip(images) {
            writeln!(out, "newmtl {name}\nKa 1 1 1\nKd 1 1 1\nmap_Ka {image}\nmap_Kd {image}")?;
        }
        Ok(())
    })
}

/// A surface by the vertices that it is written with.
struct Mapped {
    /// Vertices of the scene's mesh.
    vertices: Vec<u32>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
}

impl Mapped {
    fn of(geometry: &Geometry, instance: u32, uvs: &Uvs, k: usize, v_up: bool) -> Self {
        let mesh = geometry.mesh_of(instance as usize);
        let turned = |uv: &Vec2| Vec2::new(uv.x, 1.0 - uv.y);
        match uvs {
            Uvs::New { of, .. } => Self {
                vertices: of[k].vertices.clone(),
                uvs: of[k].uvs.iter().map(turned).collect(),
                triangles: of[k].triangles.clone(),
            },
            Uvs::Set(set) => {
                let uvs = &mesh.uv_sets()[*set];
                Self {
                    vertices: (0..mesh.positions().len() as u32).collect(),
                    uvs: if v_up { uvs.clone() } else { uvs.iter().map(turned).collect() },
                    triangles: mesh.triangles().to_vec(),
                }
            }
        }
    }

    /// Tells how many vertices and normals were written.
    fn write(
        &self,
        out: &mut dyn Write,
        geometry: &Geometry,
        instance: u32,
        vertex: u64,
        normal: u64,
    ) -> io::Result<(u64, u64)> {
        let mesh = geometry.mesh_of(instance as usize);
        let world = geometry.instances()[instance as usize].world_from_mesh;
        for &at in &self.vertices {
            let Vec3 { x, y, z } = world.transform_point3(mesh.positions()[at as usize]);
            writeln!(out, "v {x} {y} {z}")?;
        }
        for Vec2 { x, y } in &self.uvs {
            writeln!(out, "vt {x} {y}")?;
        }
        let has_normals = !mesh.normals().is_empty();
        let to_world = world.matrix3.inverse().transpose();
        for &at in self.vertices.iter().filter(|_| has_normals) {
            let Vec3 { x, y, z } = (to_world * mesh.normals()[at as usize]).normalize_or_zero();
            writeln!(out, "vn {x} {y} {z}")?;
        }
        let is_mirrored = world.matrix3.determinant() < 0.0;
        for &[a, b, c] in &self.triangles {
            let corner = |at: u32| {
                let at = u64::from(at);
                let both = format!("{0}/{0}", vertex + at);
                if has_normals { format!("{both}/{}", normal + at) } else { both }
            };
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            writeln!(out, "f {} {} {}", corner(a), corner(b), corner(c))?;
        }
        let count = self.vertices.len() as u64;
        Ok((count, if has_normals { count } else { 0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MapExtent, Unwrap};
    use conray_core::{Affine3A, Material, TriangleMesh};
    use conray_scene::{Limits, load};
    use conray_target::MapSize;

    /// A square with UVs of its own, and a mirrored one whose UVs lie over each other.
    fn geometry() -> Geometry {
        let mut geometry = Geometry::default();
        geometry.add_material(Material { name: "a b".into(), ..Material::default() });
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
        let mesh = |uvs: Vec<Vec2>| {
            let positions = corners.map(|c| c.extend(0.0)).to_vec();
            let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
            mesh.with_normals(vec![Vec3::Z; 4]).unwrap().with_uv_set(uvs).unwrap()
        };
        let over = vec![corners[0], corners[1], corners[2], corners[1]];
        for (uvs, x) in [(corners.to_vec(), 1.0), (over, -2.0)] {
            let mesh = geometry.add_mesh(mesh(uvs)).unwrap();
            let placed = Affine3A::from_scale(Vec3::new(x, 1.0, 1.0));
            geometry.add_named_instance(mesh, placed, format!("at {x}")).unwrap();
        }
        geometry
    }

    #[test]
    fn what_is_written_is_read_back_with_the_uvs_of_the_maps() {
        let geometry = geometry();
        let size = MapSize { width: 32, height: 32 };
        let sheets = Sheets::of(&geometry, &[0, 1], MapExtent::Size(size), Unwrap::Yes);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("m.obj");
        let names = crate::file_names(&sheets);
        write_mapped_obj(&path, &geometry, &sheets, &names, "m.mtl", true).unwrap();
        let images: Vec<String> = names.iter().map(|name| format!("{name}.png")).collect();
        write_mtl(dir.path().join("m.mtl"), &names, &images).unwrap();
        let found = load(&path, &Limits::default()).unwrap();
        assert_eq!(found.geometry.instances().len(), 2);
        for (at, (instance, surface)) in sheets.surfaces(&geometry, true).into_iter().enumerate() {
            let (mesh, before) = (found.geometry.mesh_of(at), geometry.mesh_of(instance as usize));
            assert_eq!(mesh.triangles().len(), before.triangles().len());
            let material = &found.geometry.materials()[mesh.material as usize];
            assert_eq!(material.name, names[surface.map]);
            for triangle in 0..mesh.triangles().len() {
                let place = geometry.instances()[instance as usize].world_from_mesh;
                let [a, b, c] = before.corners(triangle).map(|p| place.transform_point3(p));
                let is_mirrored = instance == 1;
                assert_eq!(mesh.corners(triangle), if is_mirrored { [a, c, b] } else { [a, b, c] });
                let [u, v, w] = surface.uvs[triangle].map(|uv| Vec2::new(uv.x, 1.0 - uv.y));
                let uvs = mesh.corner_uvs(triangle, 0);
                let expected = if is_mirrored { [u, w, v] } else { [u, v, w] };
                assert!(uvs.iter().zip(expected).all(|(a, b)| (*a - b).length() < 1e-6), "{uvs:?}");
            }
        }
    }
}
