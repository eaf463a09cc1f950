//! Vertex normals where a file has none: smooth across gentle edges, split at creases.

use super::soup::{NONE, Soup};
use super::weld::first_equal;
use conray_core::Vec3;

/// Faces that meet at an edge by more than this angle between their normals keep normals of their own, in degrees.
///
/// Between the 30 degrees of common modelling programs and the 45 degrees of an octagonal prism, which shall stay
/// sharp; a cylinder of ten or more sides becomes smooth.
pub const CREASE_ANGLE_DEG: f32 = 40.0;

/// At an edge of more faces than this only neighbours in file order are compared, so that the time stays linear.
const MAX_PAIRED_FACES: usize = 16;

/// Gives every corner without a normal one: the mean, weighted by the corners' angles, over the faces around its
/// position that are reached across edges of at most [`CREASE_ANGLE_DEG`].
///
/// Angle weights after Thuermer and Wuethrich, "Computing Vertex Normals from Polygonal Facets", 1998. Positions with
/// equal coordinates count as one vertex. Faces that have all their normals do not take part.
pub(super) fn fill_normals(soup: &mut Soup) {
    let faces: Vec<u32> = (0..soup.triangles.len() as u32)
        .filter(|&t| soup.triangles[t as usize].iter().any(|c| c.normal == NONE))
        .collect();
    if faces.is_empty() {
        return;
    }
    let welded = first_equal(&soup.positions);
    let corners: Vec<FaceCorner> = faces.iter().flat_map(|&t| face_corners(soup, &welded, t)).collect();
    let (starts, order) = corners_by_vertex(&corners, soup.positions.len());

    let mut fan = Fan::default();
    for vertex in starts.windows(2).filter(|w| w[0] < w[1]) {
        let around = &order[vertex[0] as usize..vertex[1] as usize];
        fan.split(&corners, around);
        for (i, &corner) in around.iter().enumerate() {
            let (triangle, k) = (faces[corner as usize / 3] as usize, corner as usize % 3);
            if soup.triangles[triangle][k].normal == NONE {
                soup.triangles[triangle][k].normal =
                    fan.normal_index(i, corners[corner as usize].normal, &mut soup.normals);
            }
        }
    }
}

/// One corner of a face as its vertex sees it.
#[derive(Clone, Copy)]
struct FaceCorner {
    /// Welded vertices: its own, the next and the one before.
    vertices: [u32; 3],
    /// Unit normal of the face; zero where it has no area.
    normal: Vec3,
    /// Interior angle in radians.
    angle_rad: f32,
}

fn face_corners(soup: &Soup, welded: &[u32], triangle: u32) -> [FaceCorner; 3] {
    let corners = soup.triangles[triangle as usize];
    let p = corners.map(|c| soup.positions[c.position as usize]);
    let normal = face_normal(p);
    [0, 1, 2].map(|k| {
        let ring = [k, (k + 1) % 3, (k + 2) % 3];
        let [own, next, last] = ring.map(|i| p[i].as_dvec3());
        let angle_rad = (next - own).angle_between(last - own) as f32;
        FaceCorner {
            vertices: ring.map(|i| welded[corners[i].position as usize]),
            normal,
            angle_rad: if angle_rad.is_finite() { angle_rad } else { 0.0 },
        }
    })
}

/// Unit normal of a triangle; zero where it has no area. In double precision, where no `f32` triangle overflows and
/// the tiniest still has an area.
pub(crate) fn face_normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let normal = (b - a).cross(c - a);
    let length = normal.length();
    if length > 0.0 { (normal / length).as_vec3() } else { Vec3::ZERO }
}

/// Corners sorted by vertex: where each vertex's corners start, and the corners.
fn corners_by_vertex(corners: &[FaceCorner], vertices: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; vertices + 1];
    corners.iter().for_each(|c| starts[c.vertices[0] as usize + 1] += 1);
    for v in 0..vertices {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut order = vec![0u32; corners.len()];
    for (i, c) in corners.iter().enumerate() {
        let slot = &mut next[c.vertices[0] as usize];
        order[*slot as usize] = i as u32;
        *slot += 1;
    }
    (starts, order)
}

/// The corners around one vertex, split into groups that are smooth among themselves.
#[derive(Default)]
struct Fan {
    /// Disjoint sets: each corner's parent, by its place around the vertex.
    parent: Vec<u32>,
    /// Sum of weighted normals, at the root of each set.
    sum: Vec<Vec3>,
    /// Index of the group's normal once it has one.
    index: Vec<u32>,
    /// (vertex at the other end of an edge, place of the corner that has it).
    edges: Vec<(u32, u32)>,
}

impl Fan {
    fn split(&mut self, corners: &[FaceCorner], around: &[u32]) {
        let n = around.len();
        self.parent.clear();
        self.parent.extend(0..n as u32);
        self.index.clear();
        self.index.resize(n, NONE);
        self.edges.clear();
        for (place, &corner) in around.iter().enumerate() {
            let [_, next, last] = corners[corner as usize].vertices;
            self.edges.extend([(next, place as u32), (last, place as u32)]);
        }
        self.edges.sort_unstable();

        let edges = std::mem::take(&mut self.edges);
        let normal = |place: u32| corners[around[place as usize] as usize].normal;
        let smooth = CREASE_ANGLE_DEG.to_radians().cos();
        for edge in edges.chunk_by(|a, b| a.0 == b.0) {
            for (i, &(_, a)) in edge.iter().enumerate() {
                let reach = if edge.len() <= MAX_PAIRED_FACES { edge.len() } else { (i + 2).min(edge.len()) };
                for &(_, b) in &edge[i + 1..reach] {
                    if normal(a).dot(normal(b)) >= smooth {
                        let (a, b) = (self.root(a), self.root(b));
                        self.parent[a.max(b) as usize] = a.min(b);
                    }
                }
            }
        }
        self.edges = edges;

        self.sum.clear();
        self.sum.resize(n, Vec3::ZERO);
        for (place, &corner) in around.iter().enumerate() {
            let (root, c) = (self.root(place as u32), corners[corner as usize]);
            self.sum[root as usize] += c.angle_rad * c.normal;
        }
    }

    fn root(&mut self, mut place: u32) -> u32 {
        while self.parent[place as usize] != place {
            let parent = self.parent[place as usize];
            self.parent[place as usize] = self.parent[parent as usize];
            place = parent;
        }
        place
    }

    /// Index of the normal of a corner's group, added to `normals` at its first use.
    fn normal_index(&mut self, place: usize, face_normal: Vec3, normals: &mut Vec<Vec3>) -> u32 {
        let root = self.root(place as u32) as usize;
        if self.index[root] == NONE {
            self.index[root] = normals.len() as u32;
            // A face without area is never seen: any unit vector does.
            let fallback = face_normal.try_normalize().unwrap_or(Vec3::Z);
            normals.push(self.sum[root].try_normalize().unwrap_or(fallback));
        }
        self.index[root]
    }
}

/// Replaces zero normals of vertices that triangles use by the mean over their triangles, weighted by area.
///
/// Returns how many there were and the first of them.
pub(super) fn repair_normals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    normals: &mut [Vec3],
) -> (u64, usize) {
    let Some(first) = normals.iter().position(|n| *n == Vec3::ZERO) else { return (0, 0) };
    let mut sums = std::collections::HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize].as_dvec3());
        let area = (b - a).cross(c - a);
        for &v in triangle.iter().filter(|v| normals[**v as usize] == Vec3::ZERO) {
            *sums.entry(v).or_insert(conray_core::Vec3::ZERO.as_dvec3()) += area;
        }
    }
    let mut bad = 0;
    for (v, normal) in normals.iter_mut().enumerate().filter(|(_, n)| **n == Vec3::ZERO) {
        let mean = sums.get(&(v as u32)).and_then(|sum| sum.try_normalize());
        *normal = mean.map_or(Vec3::Z, |mean| mean.as_vec3());
        bad += u64::from(sums.contains_key(&(v as u32)));
    }
    (bad, first)
}

/// The unit vector of a normal; zero where it has no direction.
pub(super) fn unit(normal: Vec3) -> Vec3 {
    // In double precision the square of the shortest f32 does not vanish and that of the longest does not overflow.
    let n = normal.as_dvec3();
    n.try_normalize().map_or(Vec3::ZERO, |n| n.as_vec3())
}
