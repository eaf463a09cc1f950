//! Values of vertices in plain meshes: PLY and OBJ, in world space.

use super::{
    slots::{SlotSurface, Slots},
    values::VertexValues,
};
use conray_core::{Affine3A, Geometry, TriangleMesh, Vec3};
use conray_target::{TargetError, write_atomically};
use std::{
    io::{self, Write},
    path::Path,
};

/// Writes surfaces as one PLY mesh, in world space: binary, little endian.
///
/// Vertices have `x y z`, where a surface has normals `nx ny nz`, the visibility as a grey `red green blue` of 8 bits, and as the float `visibility`, 1 is open.
/// UVs and materials are not written. The file is whole or not there. ("The PLY Polygon File Format", Turk, 1994.)
///
/// # Errors
/// What the disc refuses, and more vertices than indices of 32 bits with a sign tell apart.
///
/// # Panics
/// Where the slots or the values are not those of the scene.
pub fn write_ply(
    path: impl AsRef<Path>,
    geometry: &Geometry,
    slots: &Slots,
    values: &VertexValues,
) -> Result<(), TargetError> {
    let has_normals = slots.surfaces().iter().any(|surface| !mesh(geometry, surface).normals().is_empty());
    let vertices: usize = slots.surfaces().iter().map(|surface| surface.vertices.len()).sum();
    let triangles: usize = slots.surfaces().iter().map(|surface| surface.triangles.len()).sum();
    write_atomically(path, |out| {
        i32::try_from(vertices).map_err(|_| io::Error::other("a PLY file has at most 2^31 vertices"))?;
        let normals =
            if has_normals { "property float nx\nproperty float ny\nproperty float nz\n" } else { "" };
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment visibility: 1 is open\nelement vertex {vertices}\n\
             property float x\nproperty float y\nproperty float z\n{normals}\
             property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float visibility\n\
             element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
        )?;
        for surface in slots.surfaces() {
            let world = World::of(geometry, surface);
            let normals = if has_normals { world.normals() } else { Vec::new() };
            for (at, &slot) in surface.slots.iter().enumerate() {
                let visibility = values.visibility[slot as usize];
                put(out, world.position(at))?;
                normals.get(at).map_or(Ok(()), |&normal| put(out, normal))?;
                out.write_all(&[(visibility * f32::from(u8::MAX)).round() as u8; 3])?;
                out.write_all(&visibility.to_le_bytes())?;
            }
        }
        let mut first = 0;
        for surface in slots.surfaces() {
            for triangle in World::of(geometry, surface).triangles() {
                out.write_all(&[3])?;
                triangle.iter().try_for_each(|&vertex| out.write_all(&(first + vertex).to_le_bytes()))?;
            }
            first += surface.vertices.len() as u32;
        }
        Ok(())
    })
}

fn put(out: &mut dyn Write, vector: Vec3) -> io::Result<()> {
    vector.to_array().iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}

/// Writes surfaces as an OBJ file, an object for each, in world space.
///
/// Vertices are `v x y z r g b` with the visibility as a linear grey from 0 to 1, as many programs read colours of vertices, and have `vn` where a
/// surface has normals. UVs and materials are not written. The file is whole or not there.
///
/// ("Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, Wavefront, 1995; colours came later and have no document.)
///
/// # Errors
/// What the disc refuses.
///
/// # Panics
/// Where the slots or the values are not those of the scene.
pub fn write_obj(
    path: impl AsRef<Path>,
    geometry: &Geometry,
    slots: &Slots,
    values: &VertexValues,
) -> Result<(), TargetError> {
    write_atomically(path, |out| {
        writeln!(out, "# v x y z r g b: r g b are the visibility, 1 is open")?;
        // Counted from 1, vertices and normals each for themselves.
        let (mut vertex, mut normal) = (1, 1);
        for surface in slots.surfaces() {
            let world = World::of(geometry, surface);
            writeln!(out, "o {}", title(geometry, surface.instance))?;
            for (at, &slot) in surface.slots.iter().enumerate() {
                let (Vec3 { x, y, z }, grey) = (world.position(at), values.visibility[slot as usize]);
                writeln!(out, "v {x} {y} {z} {grey} {grey} {grey}")?;
            }
            let has_normals = !mesh(geometry, surface).normals().is_empty();
            let normals = if has_normals { world.normals() } else { Vec::new() };
            for Vec3 { x, y, z } in normals {
                writeln!(out, "vn {x} {y} {z}")?;
            }
            for [a, b, c] in world.triangles() {
                let corner = |at: u32| match has_normals {
                    true => format!("{}//{}", vertex + u64::from(at), normal + u64::from(at)),
                    false => (vertex + u64::from(at)).to_string(),
                };
                writeln!(out, "f {} {} {}", corner(a), corner(b), corner(c))?;
            }
            let count = surface.vertices.len() as u64;
            (vertex, normal) = (vertex + count, normal + if has_normals { count } else { 0 });
        }
        Ok(())
    })
}

/// Name of an instance, else of its mesh, else its number, in one line.
pub(crate) fn title(geometry: &Geometry, instance: u32) -> String {
    let names = [&geometry.instances()[instance as usize].name, &geometry.mesh_of(instance as usize).name];
    let name = names.into_iter().map(|name| name.split_whitespace().collect::<Vec<_>>().join(" "));
    name.into_iter().find(|name| !name.is_empty()).unwrap_or_else(|| format!("surface {instance}"))
}

fn mesh<'a>(geometry: &'a Geometry, surface: &SlotSurface) -> &'a TriangleMesh {
    geometry.mesh_of(surface.instance as usize)
}

/// A surface in the world.
struct World<'a> {
    mesh: &'a TriangleMesh,
    surface: &'a SlotSurface,
    world_from_mesh: Affine3A,
    is_mirrored: bool,
}

impl<'a> World<'a> {
    fn of(geometry: &'a Geometry, surface: &'a SlotSurface) -> Self {
        let world_from_mesh = geometry.instances()[surface.instance as usize].world_from_mesh;
        let is_mirrored = world_from_mesh.matrix3.determinant() < 0.0;
        Self { mesh: mesh(geometry, surface), surface, world_from_mesh, is_mirrored }
    }

    fn position(&self, at: usize) -> Vec3 {
        self.world_from_mesh.transform_point3(self.mesh.positions()[self.surface.vertices[at] as usize])
    }

    /// Unit normals of the vertices: the mesh's, or where it has none the mean over their triangles by area.
    fn normals(&self) -> Vec<Vec3> {
        if self.mesh.normals().is_empty() {
            let mut sums = vec![Vec3::ZERO.as_dvec3(); self.surface.vertices.len()];
            for triangle in self.triangles() {
                let [a, b, c] = triangle.map(|vertex| self.position(vertex as usize).as_dvec3());
                triangle.iter().for_each(|&vertex| sums[vertex as usize] += (b - a).cross(c - a));
            }
            // Of a vertex without any surface any will do.
            let unit = |sum: Vec3| sum.try_normalize().unwrap_or(Vec3::Z);
            return sums.into_iter().map(|sum| unit(sum.normalize_or_zero().as_vec3())).collect();
        }
        // The inverse transpose but for a factor, which is negative where the placement mirrors.
        let m = self.world_from_mesh.matrix3;
        let side = if self.is_mirrored { -1.0 } else { 1.0 };
        let columns = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
        let normal = |&vertex: &u32| {
            let own = self.mesh.normals()[vertex as usize];
            let turned = side * (columns[0] * own.x + columns[1] * own.y + columns[2] * own.z);
            turned.try_normalize().map_or(own, Vec3::from)
        };
        self.surface.vertices.iter().map(normal).collect()
    }

    /// Triangles by the surface's vertices; where the placement mirrors they are turned round, so that fronts stay fronts.
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let turned = |&[a, b, c]: &[u32; 3]| if self.is_mirrored { [a, c, b] } else { [a, b, c] };
        self.surface.triangles.iter().map(turned)
    }
}
