// Adds up what workgroups of weigh_units found, and sets counters back; one workgroup.

//#include shared/weighing.wgsl
//#include shared/state.wgsl

@group(1) @binding(0) var<storage, read> parts: array<vec2<f32>>;
@group(1) @binding(1) var<storage, read_write> state: State;
@group(1) @binding(2) var<storage, read_write> counts: Counts;

var<workgroup> sums: array<vec2<f32>, GROUP>;

@compute @workgroup_size(GROUP)
fn weigh_begin(@builtin(local_invocation_index) lane: u32) {
    var sum = vec2<f32>();
    for (var k = lane; k < arrayLength(&parts); k += GROUP) {
        sum += parts[k];
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
    state.unit = variance_of(all.x / max(all.y, 1.0), 1u);
    counts = Counts();
}
