// What rays, neighbours and errors come to, each weighed by its expected squared error: crates/estimate/src/hybrid/weigh.rs and residuals.rs.
// A thread weighs a place.

//#include shared/weighing.wgsl
//#include shared/cells.wgsl
//#include shared/likeness.wgsl
//#include shared/state.wgsl
//#include shared/sums.wgsl

@group(1) @binding(0) var<storage, read> cells: array<Cell>;
@group(1) @binding(1) var<storage, read> heads: array<vec2<f32>>;
@group(1) @binding(2) var<storage, read> told: array<vec2<f32>>;
@group(1) @binding(3) var<storage, read> sums: array<Sums>;
@group(1) @binding(4) var<storage, read> state: State;
// Visibility, its expected squared error, that of the guess, and the variance of one unit.
@group(1) @binding(5) var<storage, read_write> known: array<vec4<f32>>;

// Squared error of saying one half where nothing is known.
const UNKNOWN: f32 = 0.05;
// Most doubt about a sample whose rays err more than the guess.
const MOST_DOUBT: f32 = 1e4;

// What is known about errors at a place: the variance of one unit, and for each of two sizes of guesses its squared error over the formal
// variance.
struct Local {
    unit_variance: f32,
    factors: vec2<f32>,
}

// What one neighbour tells of the two.
struct Sample {
    position: vec3<f32>,
    normal: vec3<f32>,
    // How many, variance of one unit, variance of all rays.
    fixed: vec3<f32>,
    // What guesses are off by, and their formal variance.
    off: vec2<f32>,
    over: vec2<f32>,
}

fn told_of(size: u32, at: u32) -> vec2<f32> {
    if size >= state.sizes {
        return vec2<f32>();
    }
    return told[size * place_count() + at];
}

fn sample_at(size: u32, at: vec2<i32>, first: u32) -> Sample {
    var sample = Sample();
    let across = cells_across(size);
    if any(at < vec2(0)) || any(at >= vec2<i32>(across)) {
        return sample;
    }
    let place = vec2<u32>(at);
    var finer = vec2<f32>();
    var wider = vec2<f32>();
    if size == 0u {
        let index = place.y * weighing.stride + place.x;
        let tally = tallies[index];
        if tally.units == 0u {
            return sample;
        }
        sample.position = places[index].position;
        sample.normal = places[index].normal;
        let unit_variance = unit_variance_of(tally);
        sample.fixed = vec3(1.0, unit_variance, variance_of(unit_variance, tally.units));
        finer = told_of(first, index);
        wider = told_of(first + 1u, index);
    } else {
        let index = place.y * across.x + place.x;
        let cell = cells[first_cell(size) + index];
        let of_cell = first_sum(size) + index;
        sample.position = cell.position;
        sample.normal = cell.normal;
        sample.fixed = vec3(sums[of_cell].samples, sums[of_cell].unit_variance, sums[of_cell].variance);
        finer = sums[of_cell].guesses[first];
        wider = sums[of_cell].guesses[first + 1u];
    }
    sample.off = vec2(finer.x, wider.x);
    sample.over = vec2(finer.y, wider.y);
    return sample;
}

// The ratio found here, leaning on the one before as on so many samples.
fn leaning(found: f32, over: f32, before: f32, samples: f32, prior: f32) -> f32 {
    let here = select(before, found / max(over, LEAST), over > 0.0);
    return max(here + (before - here) * (prior / (samples + prior)), 0.0);
}

// With what the like samples in the 3 x 3 cells about tell.
fn refined(before: Local, place: Place, size: u32, cell: vec2<i32>, first: u32) -> Local {
    let centre = centre_of(place, size);
    var fixed = vec3<f32>();
    var off = vec2<f32>();
    var over = vec2<f32>();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let sample = sample_at(size, cell + vec2(x, y), first);
            if sample.fixed.x <= 0.0 {
                continue;
            }
            let near = likeness_of(centre, sample.position - centre.position, sample.normal).near;
            fixed += near * sample.fixed;
            off += near * sample.off;
            over += near * sample.over;
        }
    }
    let samples = fixed.x;
    let prior = weighing.prior_samples;
    var after = before;
    after.unit_variance = leaning(fixed.y, samples, before.unit_variance, samples, prior);
    // Rays that err more than the guess say little of it, unless they find far more than chance does.
    let chance = fixed.z * sqrt(2.0 / max(samples, 1.0)) * weighing.beyond_chance;
    for (var k = 0u; k < 2u; k++) {
        let sure = max(max(before.factors[k] * over[k], off[k] - chance), LEAST);
        let noise = min(1.0 + fixed.z / sure, MOST_DOUBT);
        let doubt = min(noise * noise, MOST_DOUBT);
        after.factors[k] = leaning(off[k], over[k], before.factors[k], samples, doubt * prior);
    }
    return after;
}

// The finest size that says enough, else the finest that says anything.
fn first_usable(at: u32) -> u32 {
    var enough = state.sizes;
    var any = state.sizes;
    for (var k = 0u; k < state.sizes; k++) {
        let size = state.sizes - 1u - k;
        let formal = heads[size * place_count() + at].y;
        enough = select(enough, size, formal <= weighing.enough);
        any = select(any, size, formal < FINITE);
    }
    return select(any, enough, enough < state.sizes);
}

@compute @workgroup_size(GROUP)
fn weigh(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let at = (group.y * groups.x + group.x) * GROUP + lane;
    if at >= place_count() || places[at].sharpness <= 0.0 {
        return;
    }
    let place = places[at];
    let here = vec2<i32>(vec2(at % weighing.stride, at / weighing.stride));
    let first = first_usable(at);
    let of_first = min(first, SIZES - 1u);
    var local = Local(state.unit_variance, vec2(state.factors[of_first], state.factors[of_first + 1u]));
    local = refined(local, place, WIDER, here >> vec2(WIDER), of_first);
    local = refined(local, place, FINER, here >> vec2(FINER), of_first);
    local = refined(local, place, 0u, here, of_first);
    let unit = local.unit_variance;
    let least = weighing.least_noise * unit;
    var weights = 0.0;
    var value = 0.0;
    var error2 = 0.0;
    for (var k = 0u; k < 2u; k++) {
        let size = first + k;
        if size >= state.sizes {
            continue;
        }
        let head = heads[size * place_count() + at];
        if head.y >= FINITE {
            continue;
        }
        let expected = head.y * max(local.factors[k], least) + UNSEEN * head.y * head.y;
        // Both see the same neighbours, so that their mean is no better than they are; the better one counts more.
        let weight = 1.0 / (expected * expected);
        weights += weight;
        value += weight * head.x;
        error2 += weight * expected;
    }
    let some = weights > 0.0;
    let guess = select(0.5, value / max(weights, LEAST), some);
    let found_error2 = select(UNKNOWN, error2 / max(weights, LEAST), some);
    let guess_error2 = min(found_error2, UNKNOWN);
    let tally = tallies[at];
    if tally.units == 0u {
        known[at] = vec4(clamp(guess, 0.0, 1.0), guess_error2, guess_error2, unit);
        return;
    }
    let own_error2 = unit / worth_of(f32(tally.units)) + unseen_of(tally.units);
    let doubted = found_error2 * (1.0 + f32(tally.units) / weighing.doubt_units);
    // One half is said of what nothing is known of, and no rays are pulled there.
    let share = select(1.0, doubted / (own_error2 + doubted), some);
    let rest = 1.0 - share;
    let mixed = clamp(guess + (mean_of(tally) - guess) * share, 0.0, 1.0);
    known[at] = vec4(mixed, own_error2 * share * share + guess_error2 * rest * rest, guess_error2, unit);
}
