// Method `rays`: some rays of each point's sequence, added to what is known. A thread traces one ray; the rays of a point lie side by
// side in a workgroup, whose first of them adds them up.

//#include shared/sobol.wgsl
//#include shared/hemisphere.wgsl
//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/points.wgsl

const GROUP: u32 = 64u;

// Visibility in x, and the direction times it.
var<workgroup> seen: array<vec4<f32>, GROUP>;

fn ray_of(point: Point, sample: u32) -> vec4<f32> {
    let seed = hash_u32(point.id ^ hash_u32(ao.seed));
    let local = cosine_cone(owen_sobol_2d(sample, seed), ao.reach);
    let direction = to_world(point.shading_normal, local);
    var visible = 0.0;
    // Below the geometric surface the point's own surface is in the way.
    if dot(direction, point.geometric_normal) > 0.0 {
        visible = visibility(Ray(point.origin, direction, 0.0, ao.distance), ao.falloff);
    }
    if ao.bias > 0.0 {
        let height = dot(direction, point.shading_normal);
        visible = 1.0 - (1.0 - visible) * clamp(height / ao.bias, 0.0, 1.0);
    }
    return vec4(visible, visible * direction);
}

@compute @workgroup_size(GROUP)
fn rays(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let thread = (group.y * groups.x + group.x) * GROUP + lane;
    let index = thread / ao.stride;
    let k = thread % ao.stride;
    let is_asked = index < ao.points && k < ao.samples;
    var found = vec4<f32>();
    if is_asked {
        found = ray_of(points[index], ao.first_sample + k);
    }
    seen[lane] = found;
    workgroupBarrier();
    if !is_asked || k > 0u {
        return;
    }
    var tally = tallies[index];
    for (var other = 0u; other < ao.samples; other++) {
        let one = seen[lane + other];
        tally.sum += one.x;
        tally.squares += one.x * one.x;
        tally.open += one.yzw;
    }
    tally.rays += ao.samples;
    tallies[index] = tally;
}
