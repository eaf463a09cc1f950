// Directions: crates/core/src/lanes.rs and frame.rs. Sine and cosine by the same series, since a GPU's own may be off by 5e-4.

fn sin_cos_of_eighth(angle: f32) -> vec2<f32> {
    let square = angle * angle;
    let s = -1.0 / 6.0 + square * (1.0 / 120.0 + square * (-1.0 / 5040.0 + square * (1.0 / 362880.0)));
    let c = -0.5 + square * (1.0 / 24.0 + square * (-1.0 / 720.0 + square * (1.0 / 40320.0)));
    return vec2(angle + angle * square * s, 1.0 + square * c);
}

// About +z, the density proportional to the cosine, within the cone whose half-angle has the sine `reach`.
fn cosine_cone(square: vec2<f32>, reach: f32) -> vec3<f32> {
    let at = square + square - 1.0;
    let steep = abs(at.x) > abs(at.y);
    let radius = select(at.y, at.x, steep);
    let other = select(at.x, at.y, steep);
    var angle = 0.0;
    if radius != 0.0 {
        angle = other / radius * 0.78539816;
    }
    let turned = sin_cos_of_eighth(angle);
    let disc = radius * reach * select(turned, turned.yx, steep);
    return vec3(disc, sqrt(max(1.0 - disc.x * disc.x - disc.y * disc.y, 0.0)));
}

// Takes a direction about +z to one about a unit normal.
fn to_world(z: vec3<f32>, local: vec3<f32>) -> vec3<f32> {
    // Of zero too: -0 is below.
    let sign = select(1.0, -1.0, (bitcast<u32>(z.z) >> 31u) != 0u);
    let a = -1.0 / (sign + z.z);
    let b = z.x * z.y * a;
    let x = vec3(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x);
    let y = vec3(b, sign + z.y * z.y * a, -z.y);
    return x * local.x + y * local.y + z * local.z;
}
