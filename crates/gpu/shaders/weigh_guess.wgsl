// What cells of one size say of each place, its own rays left out, and what those rays say of that: crates/estimate/src/hybrid/guesses.rs and
// regress.rs. A thread looks at a place; sixteen places ask together.

//#include shared/weighing.wgsl
//#include shared/layer.wgsl
//#include shared/cells.wgsl
//#include shared/marks.wgsl
//#include shared/likeness.wgsl
//#include shared/state.wgsl

struct LiveCounts {
    sizes: atomic<u32>,
    lacking: array<atomic<u32>, 7>,
}

@group(1) @binding(0) var<uniform> layer: Layer;
@group(1) @binding(1) var<storage, read> cells: array<Cell>;
@group(1) @binding(2) var<storage, read_write> marks: array<u32>;
// Of each size one after the other: value and formal variance, in that of one unit.
@group(1) @binding(3) var<storage, read_write> heads: array<vec2<f32>>;
// The same: squared difference to what the place's own rays found, less their variance, and the formal variance where that is told.
@group(1) @binding(4) var<storage, read_write> told: array<vec2<f32>>;
@group(1) @binding(5) var<storage, read> state: State;
@group(1) @binding(6) var<storage, read_write> counts: LiveCounts;

// Cells on either side.
const REACH: i32 = 2;
// One of so many places is too few to look at another size for.
const FEW: u32 = 200u;
// Least weight, in units of rays, from which something can be said.
const LEAST_WEIGHT: f32 = 0.05;
// Formal variance of a guess that says nothing.
const NOTHING: f32 = 1e4;
const SIXTEEN: u32 = 16u;

var<workgroup> wanted: array<atomic<u32>, 4>;
var<workgroup> able: array<atomic<u32>, 4>;
var<workgroup> lacking: atomic<u32>;

// The same for all threads.
fn is_looked_at() -> bool {
    let size = layer.size;
    if layer.again == 1u {
        return size + 1u < atomicLoad(&counts.sizes);
    }
    return size < 2u || atomicLoad(&counts.lacking[size - 1u]) >= (weighing.points + FEW - 1u) / FEW;
}

// Could the rays of all neighbours be enough, even if all were alike?
fn can_say_enough(cell: vec2<i32>) -> bool {
    if layer.again == 1u || layer.size + 1u == SIZES {
        return true;
    }
    let grid = grid_of(layer.size);
    var worth = 0.0;
    for (var y = -REACH; y <= REACH; y++) {
        for (var x = -REACH; x <= REACH; x++) {
            worth += worth_at(grid, cell + vec2(x, y));
        }
    }
    return worth >= 1.0 / weighing.enough;
}

struct Fit {
    value: f32,
    formal: f32,
}

// A linear function of the tangent plane through the cells about, read off at the place.
fn fitted(at: u32, cell: vec2<i32>) -> Fit {
    let size = layer.size;
    let grid = grid_of(size);
    let centre = centre_of(places[at], size);
    let n = centre.normal;
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let along_u = vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let along_v = vec3(b, sign + n.y * n.y * a, -n.y);
    let bend = weighing.bend / state.unit;
    var weights = 0.0;
    var first = vec3<f32>();
    var uu_uv_vv = vec3<f32>();
    var uy_vy = vec2<f32>();
    for (var y = -REACH; y <= REACH; y++) {
        for (var x = -REACH; x <= REACH; x++) {
            let about = cell_at(grid, cell + vec2(x, y));
            if about.worth <= 0.0 {
                continue;
            }
            var worth = about.worth;
            var value = about.value;
            var to = about.position - centre.position;
            if x == 0 && y == 0 {
                // The place's own part leaves its cell; what is left stands further off, on the other side.
                let own = select(0.0, worth_of(f32(tallies[at].units)), widest_of(marks[at]) >= size);
                let left = worth - own;
                let some = left > 0.5;
                let share = select(0.0, own / left, some);
                value += (value - mean_of(tallies[at])) * share;
                to += to * share;
                worth = select(0.0, left, some);
            }
            let likeness = likeness_of(centre, to, about.normal);
            let weight = worth * likeness.near / (1.0 + worth * likeness.bent * bend);
            let u = dot(to, along_u);
            let v = dot(to, along_v);
            weights += weight;
            first += weight * vec3(u, v, value);
            uu_uv_vv += weight * vec3(u * u, u * v, v * v);
            uy_vy += weight * value * vec2(u, v);
        }
    }
    if weights < LEAST_WEIGHT {
        return Fit(0.0, INFINITE);
    }
    let scale = 1.0 / weights;
    let mean = first * scale;
    let ridge = state.unit / (weighing.slope * weighing.slope) * scale;
    let uu = uu_uv_vv.x * scale - mean.x * mean.x + ridge;
    let uv = uu_uv_vv.y * scale - mean.x * mean.y;
    let vv = uu_uv_vv.z * scale - mean.y * mean.y + ridge;
    let uy = uy_vy.x * scale - mean.x * mean.z;
    let vy = uy_vy.y * scale - mean.y * mean.z;
    let inverse = 1.0 / max(uu * vv - uv * uv, LEAST);
    let slope_u = (uy * vv - vy * uv) * inverse;
    let slope_v = (vy * uu - uy * uv) * inverse;
    let beyond = (mean.x * mean.x * vv - 2.0 * mean.x * mean.y * uv + mean.y * mean.y * uu) * inverse;
    let formal = (1.0 + max(beyond, 0.0)) * scale;
    return Fit(mean.z - slope_u * mean.x - slope_v * mean.y, select(INFINITE, formal, formal < NOTHING));
}

// What the place's own rays say of a guess.
fn telling(at: u32, fit: Fit) -> vec2<f32> {
    let tally = tallies[at];
    if tally.units == 0u || fit.formal >= FINITE {
        return vec2<f32>();
    }
    let off = mean_of(tally) - fit.value;
    // A guess that says next to nothing tells little of others: it counts as one that just says enough.
    let heard = min(weighing.enough / fit.formal, 1.0);
    return vec2(off * off - variance_of(unit_variance_of(tally), tally.units), fit.formal) * heard;
}

@compute @workgroup_size(GROUP)
fn weigh_guess(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let at = (group.y * groups.x + group.x) * GROUP + lane;
    let size = layer.size;
    let is_inside = at < place_count() && is_looked_at();
    let cell = vec2<i32>(vec2(at % weighing.stride, at / weighing.stride) >> vec2(size));
    let sixteen = lane / SIXTEEN;
    var mark = 0u;
    if is_inside {
        mark = marks[at];
        let least = select(size + 1u, ALL, layer.again == 1u);
        let before = layer.again == 1u && has_asked(mark, size);
        if asks_of(mark) >= least && !before {
            atomicStore(&wanted[sixteen], 1u);
        }
    }
    workgroupBarrier();
    if is_inside && atomicLoad(&wanted[sixteen]) == 1u && can_say_enough(cell) {
        atomicStore(&able[sixteen], 1u);
    }
    workgroupBarrier();
    if is_inside {
        let asked_now = atomicLoad(&able[sixteen]) == 1u;
        let asked_before = has_asked(mark, size);
        let place = size * place_count() + at;
        var fit = Fit(0.0, INFINITE);
        if asked_now && places[at].sharpness > 0.0 {
            fit = fitted(at, cell);
        }
        if asked_now || !asked_before {
            heads[place] = vec2(fit.value, fit.formal);
            told[place] = telling(at, fit);
        }
        if asked_now {
            mark = with_asked(mark, size);
            if layer.again == 0u && asks_of(mark) == ALL && fit.formal <= weighing.enough {
                mark = with_asks(mark, size + 2u);
            }
            marks[at] = mark;
        }
        if layer.again == 0u && asks_of(mark) > size + 1u {
            atomicAdd(&lacking, 1u);
        }
    }
    workgroupBarrier();
    if lane == 0u && is_inside && layer.again == 0u {
        atomicMax(&counts.sizes, size + 1u);
        atomicAdd(&counts.lacking[size], atomicLoad(&lacking));
    }
}
