// Bundles of method `hybrid`: crates/estimate/src/hybrid/bundles.rs. A thread traces one ray, sixteen threads a unit, and a workgroup four
// units, which may be the full bundle of one point.

//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/bundle.wgsl

struct Bundles {
    // Infinite as the greatest number.
    distance: f32,
    reach: f32,
    bias: f32,
    // 0 none, 1 linear, 2 smooth.
    falloff: u32,
    // The hash of the plan's seed and the salt.
    seed: u32,
    units: u32,
    pad_a: u32,
    pad_b: u32,
}

// Of which point, and which of its sequence.
struct Unit {
    point: u32,
    index: u32,
}

// What a unit found; `of_full` is that of the bundle whose first unit it is.
struct UnitTold {
    bent: vec3<f32>,
    mean: f32,
    variance: f32,
    of_full: f32,
    pad_a: u32,
    pad_b: u32,
}

@group(1) @binding(0) var<uniform> plan: Bundles;
@group(1) @binding(1) var<storage, read> points: array<Point>;
@group(1) @binding(2) var<storage, read> units: array<Unit>;
@group(1) @binding(3) var<storage, read_write> told: array<UnitTold>;

@compute @workgroup_size(GROUP)
fn bundles(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let place = ((group.y * groups.x + group.x) * GROUP + lane) / UNIT;
    let is_asked = place < plan.units;
    if is_asked {
        let unit = units[place];
        let sample = unit.index * UNIT + lane % UNIT;
        send(lane, points[unit.point], sample, plan.seed, plan.reach, Reach(plan.distance, plan.bias, plan.falloff));
    }
    workgroupBarrier();
    if !is_asked || lane % UNIT > 0u {
        return;
    }
    let mean = mean_of_unit(lane);
    let of_full = select(0.0, within(0u, GROUP, false), lane == 0u);
    told[place] = UnitTold(mean.yzw, mean.x, within(lane, UNIT, true), of_full, 0u, 0u);
}
