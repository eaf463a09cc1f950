//! Loose triangles, from which parts are built.

use conray_core::{Affine3A, Vec2, Vec3};

/// One corner of a loose triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) position: Vec3,
    pub(crate) uv: Vec2,
}

/// A corner from its position and texture coordinates.
pub(crate) fn corner(position: Vec3, u: f32, v: f32) -> Corner {
    Corner { position, uv: Vec2::new(u, v) }
}

/// Loose triangles, counter-clockwise seen from outside; where they touch they share positions bit for bit.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faces {
    pub(crate) triangles: Vec<[Corner; 3]>,
}

impl Faces {
    /// Adds a triangle unless two of its corners coincide.
    pub(crate) fn triangle(&mut self, a: Corner, b: Corner, c: Corner) {
        if a.position != b.position && b.position != c.position && c.position != a.position {
            self.triangles.push([a, b, c]);
        }
    }

    /// Adds a quadrilateral as two triangles; one that has collapsed to a triangle gives one.
    pub(crate) fn quad(&mut self, a: Corner, b: Corner, c: Corner, d: Corner) {
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    /// Adds a flat quadrilateral with texture coordinates in its own lengths.
    pub(crate) fn panel(&mut self, a: Vec3, b: Vec3, c: Vec3, d: Vec3) {
        let (width, height) = (a.distance(b), b.distance(c));
        self.quad(
            corner(a, 0.0, 0.0),
            corner(b, width, 0.0),
            corner(c, width, height),
            corner(d, 0.0, height),
        );
    }

    /// A sheet over the unit square: `columns` by `rows` quadrilaterals with corners `point(u, v)`, u and v in [0, 1].
    ///
    /// Its front is the side from which u goes right when v goes up.
    pub(crate) fn sheet(columns: usize, rows: usize, mut point: impl FnMut(f32, f32) -> Vec3) -> Self {
        let at = |i: usize, n: usize| i as f32 / n as f32;
        let mut corners = Vec::with_capacity((columns + 1) * (rows + 1));
        for j in 0..=rows {
            for i in 0..=columns {
                let (u, v) = (at(i, columns), at(j, rows));
                corners.push(corner(point(u, v), u, v));
            }
        }
        let mut faces = Self::default();
        for j in 0..rows {
            for i in 0..columns {
                let [a, b] = [j, j + 1].map(|row| row * (columns + 1) + i);
                faces.quad(corners[a], corners[a + 1], corners[b + 1], corners[b]);
            }
        }
        faces
    }

    /// Adds other faces.
    pub(crate) fn extend(&mut self, other: &Self) {
        self.triangles.extend_from_slice(&other.triangles);
    }

    /// The faces moved; a mirroring transform also turns the winding, so that outside stays outside.
    pub(crate) fn transformed(&self, m: &Affine3A) -> Self {
        let moved = |c: Corner| Corner { position: m.transform_point3(c.position), uv: c.uv };
        let mirrored = m.matrix3.determinant() < 0.0;
        let triangle = |t: &[Corner; 3]| {
            let [a, b, c] = t.map(moved);
            if mirrored { [a, c, b] } else { [a, b, c] }
        };
        Self { triangles: self.triangles.iter().map(triangle).collect() }
    }

    /// The same faces seen from the other side.
    pub(crate) fn flipped(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }
}

/// Unit normal of a triangle by its winding; zero where it has no area.
pub(crate) fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    // In double precision, so that slender triangles keep their direction.
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_faces_the_viewer_and_mirroring_keeps_it_so() {
        let sheet = Faces::sheet(2, 3, |u, v| Vec3::new(u, v, 0.0));
        assert_eq!(sheet.triangles.len(), 12);
        let normals = |f: &Faces| -> Vec<Vec3> {
            f.triangles.iter().map(|t| face_normal(t.map(|c| c.position))).collect()
        };
        assert!(normals(&sheet).iter().all(|&n| n == Vec3::Z));
        let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        assert!(normals(&sheet.transformed(&mirror)).iter().all(|&n| n == Vec3::Z));
        assert!(normals(&sheet.flipped()).iter().all(|&n| n == -Vec3::Z));
    }

    #[test]
    fn collapsed_quads_give_one_triangle_or_none() {
        let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| corner(p, 0.0, 0.0));
        let mut faces = Faces::default();
        faces.quad(a, b, c, c);
        assert_eq!(faces.triangles.len(), 1);
        faces.quad(a, b, b, a);
        assert_eq!(faces.triangles.len(), 1);
    }
}
