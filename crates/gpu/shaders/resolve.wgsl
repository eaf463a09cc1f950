// What is shown of a picture: visibility as grey, eight bits a channel, linear. And squared errors, summed by workgroups.

//#include shared/weighing.wgsl

struct Shown {
    // Colour where there is no point, as the pictures have it.
    background: u32,
    // Of each row of the picture, in pixels.
    width: u32,
    pad_a: u32,
    pad_b: u32,
}

@group(1) @binding(0) var<uniform> shown: Shown;
@group(1) @binding(1) var<storage, read> known: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read_write> picture: array<u32>;
// Of each workgroup: the sum, and how many places have a point.
@group(1) @binding(3) var<storage, read_write> parts: array<vec2<f32>>;

var<workgroup> errors: array<vec2<f32>, GROUP>;

@compute @workgroup_size(GROUP)
fn resolve(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let part = group.y * groups.x + group.x;
    let at = part * GROUP + lane;
    var error = vec2<f32>();
    if at < place_count() {
        let x = at % weighing.stride;
        var colour = shown.background;
        if places[at].sharpness > 0.0 {
            colour = pack4x8unorm(vec4(vec3(known[at].x), 1.0));
            error = vec2(known[at].y, 1.0);
        }
        if x < shown.width {
            picture[at / weighing.stride * shown.width + x] = colour;
        }
    }
    errors[lane] = error;
    workgroupBarrier();
    if lane > 0u || part >= arrayLength(&parts) {
        return;
    }
    var all = vec2<f32>();
    for (var k = 0u; k < GROUP; k++) {
        all += errors[k];
    }
    parts[part] = all;
}
