// The march of cones: crates/voxel/src/march.rs, steps.rs and compose.rs. A thread marches one cone.

//#include shared/hemisphere.wgsl
//#include shared/octree.wgsl
//#include shared/point.wgsl

struct March {
    // Lowest corner of the octree's cube.
    origin: vec3<f32>,
    voxel_size: f32,
    // Lengths from here on are in leaves: of the cube's side,
    resolution: f32,
    // of a node's edge per length,
    spread: f32,
    // of a step, and of the least height over the tangent plane, in edges of the sampled nodes,
    step: f32,
    lift: f32,
    // of the AO distance.
    distance: f32,
    // The coarsest level.
    top: f32,
    // 0 none, 1 linear, 2 smooth.
    falloff: u32,
    cones: u32,
    points: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(1) @binding(0) var<uniform> march: March;
@group(1) @binding(1) var<storage, read> points: array<Point>;
// Of the cones, about +z.
@group(1) @binding(2) var<storage, read> axes: array<vec4<f32>>;
// Visibility and error of each cone of each point.
@group(1) @binding(3) var<storage, read_write> results: array<vec2<f32>>;

// A cone takes fewer through the finest octree, in steps of leaves.
const MOST_STEPS: u32 = 4096u;
const CLOSED: f32 = 1e-3;
const CLEAR_CHANGE: f32 = 0.25;
const UNKNOWN_SHARE: f32 = 0.8;

// How much of the mean opacity along a line counts, by the angle at which the line meets the surface.
fn met_share(mean: f32, change: vec3<f32>, axis: vec3<f32>) -> f32 {
    let size = abs(change);
    let largest = max(size.x, max(size.y, size.z));
    if largest <= 0.0 {
        return UNKNOWN_SHARE;
    }
    let clear = min(largest / (CLEAR_CHANGE * mean), 1.0);
    return clear * (abs(dot(change, axis)) / largest) + (1.0 - clear) * UNKNOWN_SHARE;
}

fn falloff_at(middle: f32) -> f32 {
    let x = clamp(middle / march.distance, 0.0, 1.0);
    if march.falloff == 0u {
        return 1.0;
    }
    return select(1.0 - x * x * (3.0 - 2.0 * x), 1.0 - x, march.falloff == 1u);
}

fn marched(point: Point, axis: vec3<f32>) -> vec2<f32> {
    let apex = (point.origin - march.origin) / march.voxel_size;
    let rise = dot(point.geometric_normal, axis);
    let outside = length(apex - clamp(apex, vec3(0.0), vec3(march.resolution)));
    let end = min(march.distance, outside + 1.732051 * march.resolution);
    var t = max((outside - march.lift) / (1.0 + march.lift * march.spread), 0.0);
    var passing = 1.0;
    var before = vec2(1.0);
    var closed = 0.0;
    var error = 0.0;
    for (var k = 0u; k < MOST_STEPS && t < end; k++) {
        let top = exp2(march.top);
        let node = min(max(march.spread * t, 1.0), top);
        let level = firstLeadingBit(u32(node));
        let share = select(clamp(log2(node) - f32(level), 0.0, 1.0), 0.0, node >= top);
        let whole = march.step * node;
        let middle = t + 0.5 * whole;
        let len = min(whole, end - t);
        t += whole;
        let lift = max(march.lift * node - middle * rise, 0.0);
        let position = apex + axis * middle + point.geometric_normal * lift;
        let slope = slope_at(level, share, position);
        if slope.mean <= 0.0 && slope.sd <= 0.0 {
            before = vec2(passing);
            continue;
        }
        let weight = falloff_at(middle);
        error += passing * slope.sd * (len / node) * weight;
        let blocked = slope.mean * len * met_share(slope.mean, slope.gradient * node, axis);
        // What two steps in a row block adds up, since the filter smears one surface over them.
        let less = min(blocked * before.y, passing);
        passing -= less;
        before = vec2(passing, before.x);
        closed += less * weight;
        if passing < CLOSED {
            closed += passing * weight;
            break;
        }
    }
    return vec2(clamp(1.0 - closed, 0.0, 1.0), error);
}

@compute @workgroup_size(64)
fn cones(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let thread = id.y * groups.x * 64u + id.x;
    let index = thread / march.cones;
    if index >= march.points {
        return;
    }
    let point = points[index];
    results[thread] = marched(point, to_world(point.shading_normal, axes[thread % march.cones].xyz));
}
