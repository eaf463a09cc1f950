// What a point sees along a ray.

//#include shared/point.wgsl

struct Reach {
    // The AO distance; infinite as the greatest number.
    distance: f32,
    // Sine of the angle above the horizon below which occluders fade.
    bias: f32,
    // 0 none, 1 linear, 2 smooth.
    falloff: u32,
}

// Visibility, and the direction times it.
fn seen_along(point: Point, direction: vec3<f32>, reach: Reach) -> vec4<f32> {
    var visible = 0.0;
    // Below the geometric surface the point's own surface is in the way.
    if dot(direction, point.geometric_normal) > 0.0 {
        visible = visibility(Ray(point.origin, direction, 0.0, reach.distance), reach.falloff);
    }
    if reach.bias > 0.0 {
        let height = dot(direction, point.shading_normal);
        visible = 1.0 - (1.0 - visible) * clamp(height / reach.bias, 0.0, 1.0);
    }
    return vec4(visible, visible * direction);
}

// What rays met.
struct Tally {
    open: vec3<f32>,
    rays: u32,
    sum: f32,
    squares: f32,
    pad_a: u32,
    pad_b: u32,
}

fn with_ray(tally: Tally, seen: vec4<f32>) -> Tally {
    var more = tally;
    more.sum += seen.x;
    more.squares += seen.x * seen.x;
    more.open += seen.yzw;
    more.rays += 1u;
    return more;
}
