//! Vertices and faces of OBJ files, for measuring on real scenes.

use conray_core::{TriangleMesh, Vec3};

/// Vertices and faces of an OBJ file, faces as fans.
pub(crate) fn read(text: &str) -> TriangleMesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f32> = words.take(3).map(|w| w.parse().expect("a number")).collect();
                positions.push(Vec3::from_slice(&p));
            }
            Some("f") => {
                let index = |w: &str| {
                    let i: i64 = w.split('/').next().unwrap_or_default().parse().expect("an index");
                    (if i < 0 { positions.len() as i64 + i } else { i - 1 }) as u32
                };
                let face: Vec<u32> = words.map(index).collect();
                triangles.extend((2..face.len()).map(|i| [face[0], face[i - 1], face[i]]));
            }
            _ => {}
        }
    }
    TriangleMesh::new(positions, triangles).expect("the file is sound")
}
