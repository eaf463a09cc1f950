// Rays of a workgroup, and how they vary: crates/estimate/src/hybrid/bundles.rs. A thread traces one ray, sixteen threads a unit.

//#include shared/sobol.wgsl
//#include shared/hemisphere.wgsl
//#include shared/seen.wgsl

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

// Traces a ray of a point's sequence, for all threads to see after a barrier.
fn send(lane: u32, point: Point, sample: u32, seed: u32, spread: f32, reach: Reach) {
    let square = owen_sobol_2d(sample, hash_u32(point.id ^ seed));
    let at = min(vec2<u32>(square * SIDE), vec2(3u));
    cells[lane] = at.x + at.y * 4u;
    seen[lane] = seen_along(point, to_world(point.shading_normal, cosine_cone(square, spread)), reach);
}

// Mean visibility of a unit whose first ray is that of a thread, and its mean open direction.
fn mean_of_unit(lane: u32) -> vec4<f32> {
    var sum = vec4<f32>();
    for (var k = 0u; k < UNIT; k++) {
        sum += seen[lane + k];
    }
    return sum / f32(UNIT);
}
