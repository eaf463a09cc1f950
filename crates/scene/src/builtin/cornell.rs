//! The Cornell box as measured.
//!
//! Coordinates are those of Cornell University Program of Computer Graphics, "Cornell Box Data", 1998
//! (<http://www.graphics.cornell.edu/online/box/data.html>), in millimetres there and in metres here. The box is about
//! 0.55 wide, its walls are not quite at right angles, its front (z = 0) is open. The lamp lies in the plane of the ceiling
//! and is left out: the ceiling is closed. The blocks have no bottoms, as in the data: they stand on the floor.
//!
//! In `cornell` a ball takes the place of the short block, as in the figures of Podee, Dobashi and Yamamoto, "Combining
//! Cone and Ray Tracing for Ambient Occlusion Computation": about 0.17 of the box in radius, touching the floor in one point.

use super::assembly::Assembly;
use super::faces::Faces;
use super::part::Part;
use super::shapes::icosphere;
use crate::Scene;
use conray_core::{Affine3A, Vec3};

/// Corners in millimetres, counter-clockwise seen from inside the box.
type Quad = [[f32; 3]; 4];

const FLOOR: Quad = [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]];
const CEILING: Quad = [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]];
const BACK: Quad = [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]];
const RIGHT: Quad = [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]];
const LEFT: Quad = [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]];

/// The corners (x, z) of a block's top, in the order of the data, and its height.
struct Block {
    corners: [[f32; 2]; 4],
    height: f32,
}

const SHORT: Block =
    Block { corners: [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]], height: 165.0 };
const TALL: Block =
    Block { corners: [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]], height: 330.0 };

const METRES_PER_MILLIMETRE: f32 = 1e-3;
const BALL_RADIUS: f32 = 0.0935;
/// Where the short block has its middle.
const BALL_CENTRE: Vec3 = Vec3::new(0.1855, BALL_RADIUS, 0.169);

fn point(millimetres: [f32; 3]) -> Vec3 {
    Vec3::from_array(millimetres) * METRES_PER_MILLIMETRE
}

fn add_quad(faces: &mut Faces, corners: Quad) {
    let [a, b, c, d] = corners.map(point);
    faces.panel(a, b, c, d);
}

impl Block {
    /// The top and the four sides, facing out.
    fn faces(&self) -> Faces {
        let at = |i: usize, y: f32| [self.corners[i % 4][0], y, self.corners[i % 4][1]];
        let mut faces = Faces::default();
        add_quad(&mut faces, [0, 1, 2, 3].map(|i| at(i, self.height)));
        for i in 0..4 {
            let (low, high) = (0.0, self.height);
            add_quad(&mut faces, [at(i, low), at(i + 1, low), at(i + 1, high), at(i, high)]);
        }
        faces
    }
}

/// The room with its tall block, and the views that both scenes share.
fn room(name: &'static str) -> Assembly {
    let mut assembly = Assembly::new(name);
    let parts: [(&str, &[Quad]); 3] =
        [("white walls", &[FLOOR, CEILING, BACK]), ("right wall", &[RIGHT]), ("left wall", &[LEFT])];
    for (part, quads) in parts {
        let mut faces = Faces::default();
        quads.iter().for_each(|&quad| add_quad(&mut faces, quad));
        let material = assembly.opaque(part);
        assembly.add(part, faces.flat(), material);
    }
    let block = assembly.opaque("tall block");
    assembly.add("tall block", TALL.faces().flat(), block);
    // The measured camera: focal length 35, film 25 by 25.
    let vertical_fov_deg = 2.0 * (12.5f32 / 35.0).atan().to_degrees();
    assembly.view("front", [0.278, 0.273, -0.8], [0.278, 0.273, 0.2796], vertical_fov_deg);
    assembly.view("corner", [0.36, 0.50, 0.10], [0.465, 0.17, 0.43], 62.0);
    assembly
}

/// Scene `cornell`: tall block and ball.
pub(crate) fn with_ball() -> Scene {
    let mut assembly = room("cornell");
    let material = assembly.opaque("ball");
    let mut ball = Part::default();
    let world_from_ball =
        Affine3A::from_translation(BALL_CENTRE) * Affine3A::from_scale(Vec3::splat(BALL_RADIUS));
    ball.place(&icosphere(5), &world_from_ball);
    assembly.add("ball", ball, material);
    assembly.view("ball", [0.36, 0.17, -0.18], [0.20, 0.07, 0.17], 42.0);
    assembly.finish()
}

/// Scene `cornell-blocks`: tall and short block.
pub(crate) fn with_blocks() -> Scene {
    let mut assembly = room("cornell-blocks");
    let material = assembly.opaque("short block");
    assembly.add("short block", SHORT.faces().flat(), material);
    assembly.view("block", [0.43, 0.30, -0.17], [0.19, 0.08, 0.18], 40.0);
    assembly.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Bounds;

    #[test]
    fn the_room_has_its_measured_size_and_an_open_front() {
        for scene in [with_ball(), with_blocks()] {
            let expected = Bounds { min: Vec3::ZERO, max: Vec3::new(0.556, 0.5488, 0.5592) };
            let bounds = scene.geometry.bounds();
            assert!(bounds.min.distance(expected.min) < 1e-6 && bounds.max.distance(expected.max) < 1e-6);
            let inside = Vec3::new(0.278, 0.273, 0.02);
            for mesh in scene
                .geometry
                .meshes()
                .iter()
                .filter(|m| m.name.ends_with("walls") || m.name.ends_with("wall"))
            {
                for (t, _) in mesh.triangles().iter().enumerate() {
                    let [a, b, c] = mesh.corners(t);
                    assert!((b - a).cross(c - a).dot(inside - a) > 0.0, "{} faces inwards", mesh.name);
                    assert!([a, b, c].iter().any(|p| p.z > 0.1), "nothing closes the front");
                }
            }
        }
    }

    #[test]
    fn walls_meet_without_gaps_except_at_the_front() {
        let mut faces = Faces::default();
        [FLOOR, CEILING, BACK, LEFT, RIGHT].iter().for_each(|&quad| add_quad(&mut faces, quad));
        // Only the rims of floor, ceiling, left and right wall: the left wall leans just as the measured corners do.
        assert_eq!(crate::builtin::checks::open_edges(&faces.flat()), 4);
        faces.triangles.pop();
        assert_ne!(crate::builtin::checks::open_edges(&faces.flat()), 4);
    }

    #[test]
    fn the_ball_stands_on_the_floor_in_one_point_and_clear_of_the_block() {
        let scene = with_ball();
        let ball = scene.geometry.meshes().iter().find(|m| m.name == "ball").unwrap();
        let touching = ball.positions().iter().filter(|p| p.y == 0.0).count();
        assert_eq!((ball.bounds().min.y, touching), (0.0, 1));
        let share = BALL_RADIUS / 0.5488;
        assert!((share - 0.17).abs() < 0.005, "radius is {share} of the box");
        for &[x, z] in &TALL.corners {
            let gap = Vec3::new(1e-3 * x, BALL_RADIUS, 1e-3 * z).distance(BALL_CENTRE) - BALL_RADIUS;
            assert!(gap > 0.01);
        }
    }

    #[test]
    fn blocks_are_closed_but_for_their_bottoms() {
        for block in [SHORT, TALL] {
            let part = block.faces().flat();
            assert_eq!(part.triangles.len(), 10);
            crate::builtin::checks::assert_sound(&part, "block");
            assert_eq!(crate::builtin::checks::open_edges(&part), 4);
            let centre = part.positions.iter().sum::<Vec3>() / part.positions.len() as f32;
            for t in &part.triangles {
                let [a, b, c] = t.map(|v| part.positions[v as usize]);
                assert!((b - a).cross(c - a).dot(a - centre) > 0.0, "blocks face out");
            }
        }
    }
}
