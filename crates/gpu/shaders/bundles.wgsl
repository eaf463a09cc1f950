// Bundles of method `hybrid`: crates/estimate/src/hybrid/bundles.rs. A thread traces one ray, sixteen threads a unit, and a workgroup four
// units, which may be the full bundle of one point.

//#include shared/sobol.wgsl
//#include shared/hemisphere.wgsl
//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/seen.wgsl

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

const GROUP: u32 = 64u;
const UNIT: u32 = 16u;
// Cells of the square on each side.
const SIDE: f32 = 4.0;
// Rays of a bundle in each of them, and of a unit in each four.
const IN_CELL: f32 = 4.0;

// Visibility in x, and the direction times it.
var<workgroup> seen: array<vec4<f32>, GROUP>;
var<workgroup> cells: array<u32, GROUP>;

// Variance of the mean of some rays, as if they were independent within each cell; `quarters` puts four cells together.
fn within(first: u32, count: u32, quarters: bool) -> f32 {
    var open: array<f32, 16>;
    var squares = 0.0;
    for (var k = first; k < first + count; k++) {
        let visible = seen[k].x;
        let cell = select(cells[k], (cells[k] / 2u) % 2u + cells[k] / 8u * 2u, quarters);
        open[cell] += visible;
        squares += visible * visible;
    }
    var together = 0.0;
    for (var cell = 0u; cell < 16u; cell++) {
        together += open[cell] * open[cell];
    }
    return max(squares - together / IN_CELL, 0.0) / f32(count * count);
}

@compute @workgroup_size(GROUP)
fn bundles(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let place = ((group.y * groups.x + group.x) * GROUP + lane) / UNIT;
    let is_asked = place < plan.units;
    var found = vec4<f32>();
    var cell = 0u;
    if is_asked {
        let point = points[units[place].point];
        let sample = units[place].index * UNIT + lane % UNIT;
        let square = owen_sobol_2d(sample, hash_u32(point.id ^ plan.seed));
        let at = min(vec2<u32>(square * SIDE), vec2(3u));
        cell = at.x + at.y * 4u;
        let direction = to_world(point.shading_normal, cosine_cone(square, plan.reach));
        found = seen_along(point, direction, Reach(plan.distance, plan.bias, plan.falloff));
    }
    seen[lane] = found;
    cells[lane] = cell;
    workgroupBarrier();
    if !is_asked || lane % UNIT > 0u {
        return;
    }
    var sum = vec4<f32>();
    for (var k = 0u; k < UNIT; k++) {
        sum += seen[lane + k];
    }
    let mean = sum / f32(UNIT);
    let of_full = select(0.0, within(0u, GROUP, false), lane == 0u);
    told[place] = UnitTold(mean.yzw, mean.x, within(lane, UNIT, true), of_full, 0u, 0u);
}
