// A surface point: twin of crates/gpu/src/points.rs.

struct Point {
    // Where rays start; for cones the position on the surface.
    origin: vec3<f32>,
    id: u32,
    geometric_normal: vec3<f32>,
    pad_a: u32,
    shading_normal: vec3<f32>,
    pad_b: u32,
}
