// Sums what rays tell of guesses over cells: crates/estimate/src/hybrid/told.rs. A thread makes a cell; of the finer ones workgroups add
// theirs up.

//#include shared/weighing.wgsl
//#include shared/layer.wgsl
//#include shared/marks.wgsl
//#include shared/state.wgsl
//#include shared/sums.wgsl

@group(1) @binding(0) var<uniform> layer: Layer;
@group(1) @binding(1) var<storage, read> marks: array<u32>;
@group(1) @binding(2) var<storage, read> told: array<vec2<f32>>;
@group(1) @binding(3) var<storage, read> counts: Counts;
@group(1) @binding(4) var<storage, read_write> sums: array<Sums>;
@group(1) @binding(5) var<storage, read_write> parts: array<Sums>;

var<workgroup> found: array<Sums, GROUP>;

fn sum_of(cell: vec2<u32>) -> Sums {
    var sum = Sums();
    let side = 1u << layer.size;
    let end = min((cell + 1u) * side, vec2(weighing.width, weighing.height));
    for (var y = cell.y * side; y < end.y; y++) {
        for (var x = cell.x * side; x < end.x; x++) {
            let at = y * weighing.stride + x;
            let tally = tallies[at];
            if tally.units == 0u || widest_of(marks[at]) < layer.size {
                continue;
            }
            let unit_variance = unit_variance_of(tally);
            sum.samples += 1.0;
            sum.unit_variance += unit_variance;
            sum.variance += variance_of(unit_variance, tally.units);
            for (var size = 0u; size < counts.sizes; size++) {
                sum.guesses[size] += told[size * place_count() + at];
            }
        }
    }
    return sum;
}

@compute @workgroup_size(GROUP)
fn weigh_sums(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let part = group.y * groups.x + group.x;
    let index = part * GROUP + lane;
    let across = cells_across(layer.size);
    var sum = Sums();
    if index < across.x * across.y {
        sum = sum_of(vec2(index % across.x, index / across.x));
        sums[first_sum(layer.size) + index] = sum;
    }
    found[lane] = sum;
    workgroupBarrier();
    if lane > 0u || layer.size != FINER || part >= arrayLength(&parts) {
        return;
    }
    var all = Sums();
    for (var k = 0u; k < GROUP; k++) {
        all.samples += found[k].samples;
        all.unit_variance += found[k].unit_variance;
        for (var size = 0u; size < SIZES; size++) {
            all.guesses[size] += found[k].guesses[size];
        }
    }
    parts[part] = all;
}
