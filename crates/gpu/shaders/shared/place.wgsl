// A place of a picture: twins in crates/gpu/src/weighing/structs.rs.

// What is known of a place without a ray; sharpness is 0 where there is no point.
struct Place {
    position: vec3<f32>,
    sharpness: f32,
    normal: vec3<f32>,
    pad: u32,
}

// What its rays found.
struct PlaceTally {
    units: u32,
    sum: f32,
    in_units: f32,
    in_fulls: f32,
}
