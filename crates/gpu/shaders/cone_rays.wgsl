// The rays of the published blend: some in each cone of each point. A thread traces one ray; those of a cone lie side by side in a workgroup, whose
// first of them adds them up.

//#include shared/sobol.wgsl
//#include shared/hemisphere.wgsl
//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/seen.wgsl

struct ConeRays {
    distance: f32,
    bias: f32,
    falloff: u32,
    seed: u32,
    // Of the point's frames, the first and the one after the last.
    frames_start: u32,
    frames_end: u32,
    // The first of a cone's rays in all frames that are traced here.
    first: u32,
    // Threads of each cone, a power of two up to a workgroup.
    stride: u32,
    cones: u32,
    points: u32,
    pad_a: u32,
    pad_b: u32,
}

struct Cone {
    axis: vec3<f32>,
    cos_half_angle: f32,
    // The square that is taken to the cone; edge 0 for a cap.
    low: vec2<f32>,
    edge: f32,
    pad: u32,
}

@group(1) @binding(0) var<uniform> plan: ConeRays;
@group(1) @binding(1) var<storage, read> points: array<Point>;
@group(1) @binding(2) var<storage, read> cones: array<Cone>;
// Rays of each cone of each point in a frame.
@group(1) @binding(3) var<storage, read> counts: array<u32>;
@group(1) @binding(4) var<storage, read_write> tallies: array<Tally>;

const GROUP: u32 = 64u;

var<workgroup> seen: array<vec4<f32>, GROUP>;

// Sine and cosine of a share of a turn.
fn sin_cos_of_turn(turn: f32) -> vec2<f32> {
    let quarter = floor(4.0 * turn + 0.5);
    let sc = sin_cos_of_eighth((turn - 0.25 * quarter) * 6.2831853);
    switch u32(quarter) % 4u {
        case 0u: { return sc; }
        case 1u: { return vec2(sc.y, -sc.x); }
        case 2u: { return -sc; }
        default: { return vec2(-sc.y, sc.x); }
    }
}

fn direction_in(cone: Cone, square: vec2<f32>) -> vec3<f32> {
    if cone.edge > 0.0 {
        return cosine_cone(cone.low + square * cone.edge, 1.0);
    }
    let z = 1.0 - square.x * (1.0 - cone.cos_half_angle);
    let r = sqrt(max(1.0 - z * z, 0.0));
    let sc = sin_cos_of_turn(square.y);
    return to_world(cone.axis, vec3(r * sc.y, r * sc.x, z));
}

@compute @workgroup_size(GROUP)
fn cone_rays(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let thread = (group.y * groups.x + group.x) * GROUP + lane;
    let place = thread / plan.stride;
    let k = thread % plan.stride;
    let index = place / plan.cones;
    var asked = 0u;
    var found = vec4<f32>();
    if index < plan.points {
        let per_frame = counts[place];
        let all = (plan.frames_end - plan.frames_start) * per_frame;
        asked = min(all - min(plan.first, all), plan.stride);
        if k < asked {
            let point = points[index];
            let seed = hash_u32(point.id ^ hash_u32(plan.seed));
            let sample = plan.frames_start * per_frame + plan.first + k;
            let square = owen_sobol_2d(sample, hash_u32(seed + place % plan.cones));
            let local = direction_in(cones[place % plan.cones], square);
            let direction = to_world(point.shading_normal, local);
            found = seen_along(point, direction, Reach(plan.distance, plan.bias, plan.falloff));
        }
    }
    seen[lane] = found;
    workgroupBarrier();
    if asked == 0u || k > 0u {
        return;
    }
    var tally = tallies[place];
    for (var other = 0u; other < asked; other++) {
        tally = with_ray(tally, seen[lane + other]);
    }
    tallies[place] = tally;
}
