// The variance of one unit of rays, summed over places by workgroups, and marks of places as they begin: crates/estimate/src/hybrid/columns.rs.

//#include shared/weighing.wgsl
//#include shared/marks.wgsl

@group(1) @binding(0) var<storage, read_write> marks: array<u32>;
// Of each workgroup: the sum, and how many places have rays.
@group(1) @binding(1) var<storage, read_write> parts: array<vec2<f32>>;

// Places of a thread.
const EACH: u32 = 16u;

var<workgroup> sums: array<vec2<f32>, GROUP>;

@compute @workgroup_size(GROUP)
fn weigh_units(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let part = group.y * groups.x + group.x;
    var sum = vec2<f32>();
    for (var k = 0u; k < EACH; k++) {
        let at = (part * EACH + k) * GROUP + lane;
        if at < place_count() {
            let tally = tallies[at];
            sum += select(vec2(0.0), vec2(unit_variance_of(tally), 1.0), tally.units > 0u);
            marks[at] = fresh_marks(places[at].sharpness > 0.0);
        }
    }
    sums[lane] = sum;
    workgroupBarrier();
    if lane > 0u {
        return;
    }
    var all = vec2<f32>();
    for (var k = 0u; k < GROUP; k++) {
        all += sums[k];
    }
    if part < arrayLength(&parts) {
        parts[part] = all;
    }
}
