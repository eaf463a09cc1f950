// What holds of errors on average: crates/estimate/src/hybrid/told.rs. One workgroup adds up what those of weigh_sums found.

//#include shared/weighing.wgsl
//#include shared/state.wgsl
//#include shared/sums.wgsl

@group(1) @binding(0) var<storage, read> parts: array<Sums>;
@group(1) @binding(1) var<storage, read> counts: Counts;
@group(1) @binding(2) var<storage, read_write> state: State;

var<workgroup> found: array<Sums, GROUP>;

fn added(a: Sums, b: Sums) -> Sums {
    var sum = a;
    sum.samples += b.samples;
    sum.unit_variance += b.unit_variance;
    for (var size = 0u; size < SIZES; size++) {
        sum.guesses[size] += b.guesses[size];
    }
    return sum;
}

@compute @workgroup_size(GROUP)
fn weigh_everywhere(@builtin(local_invocation_index) lane: u32) {
    var sum = Sums();
    for (var k = lane; k < arrayLength(&parts); k += GROUP) {
        sum = added(sum, parts[k]);
    }
    found[lane] = sum;
    workgroupBarrier();
    if lane > 0u {
        return;
    }
    var all = Sums();
    for (var k = 0u; k < GROUP; k++) {
        all = added(all, found[k]);
    }
    state.sizes = counts.sizes;
    state.unit_variance = select(0.0, all.unit_variance / max(all.samples, 1.0), all.samples > 0.0);
    for (var size = 0u; size < SIZES; size++) {
        let over = all.guesses[size].y;
        state.factors[size] = select(1.0, max(all.guesses[size].x / max(over, LEAST), 0.0), over > 0.0);
    }
}
