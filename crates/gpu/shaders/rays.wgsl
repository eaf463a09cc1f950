// Method `rays`: some rays of each point's sequence, added to what is known. A thread traces one ray; the rays of a point lie side by
// side in a workgroup, whose first of them adds them up.

//#include shared/sobol.wgsl
//#include shared/hemisphere.wgsl
//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/seen.wgsl
//#include shared/points.wgsl

const GROUP: u32 = 64u;

// Visibility in x, and the direction times it.
var<workgroup> seen: array<vec4<f32>, GROUP>;

fn ray_of(point: Point, sample: u32) -> vec4<f32> {
    let seed = hash_u32(point.id ^ hash_u32(ao.seed));
    let local = cosine_cone(owen_sobol_2d(sample, seed), ao.reach);
    return seen_along(point, to_world(point.shading_normal, local), Reach(ao.distance, ao.bias, ao.falloff));
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
        tally = with_ray(tally, seen[lane + other]);
    }
    tallies[index] = tally;
}
