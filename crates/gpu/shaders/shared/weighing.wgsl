// What weighing reads of places and of their rays: crates/estimate/src/hybrid. Every struct has a twin in crates/gpu/src/weighing/.

//#include shared/place.wgsl

struct Weighing {
    // Places: in a row, rows, and places from row to row.
    width: u32,
    height: u32,
    stride: u32,
    // Points that were asked about.
    points: u32,
    // How rays err: RayErrors, and the formal variance from which on cells say enough.
    unit: f32,
    full: f32,
    enough: f32,
    // HybridConstants.
    distance: f32,
    cells: f32,
    plane: f32,
    cosine: f32,
    slope: f32,
    bend: f32,
    prior_samples: f32,
    beyond_chance: f32,
    least_noise: f32,
    doubt_units: f32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

// Tallies of like places put together; worth is 0 where there is nothing.
struct Cell {
    position: vec3<f32>,
    worth: f32,
    normal: vec3<f32>,
    value: f32,
}

@group(0) @binding(0) var<uniform> weighing: Weighing;
@group(0) @binding(1) var<storage, read> places: array<Place>;
@group(0) @binding(2) var<storage, read> tallies: array<PlaceTally>;

const GROUP: u32 = 64u;
// Sizes of cells, places among them.
const SIZES: u32 = 5u;
const LEAST: f32 = 1.1754944e-38;
// Formal variance where nothing like was found, and below it all others.
const INFINITE: f32 = 3.0e38;
const FINITE: f32 = 1.0e38;
// Squared error of what one unit does not see.
const UNSEEN: f32 = 0.00015625;
// Units of a full bundle times its worth.
const FULL_FACTOR: f32 = 26.908684;

fn place_count() -> u32 {
    return weighing.stride * weighing.height;
}

// How many times the precision of one unit so many have.
fn worth_of(units: f32) -> f32 {
    let fourth = sqrt(sqrt(units));
    return units * fourth * sqrt(fourth);
}

fn mean_of(tally: PlaceTally) -> f32 {
    return tally.sum / f32(max(tally.units, 1u));
}

// Variance of one unit as a place's own rays tell it.
fn unit_variance_of(tally: PlaceTally) -> f32 {
    let both = weighing.unit * tally.in_units + FULL_FACTOR * weighing.full * tally.in_fulls;
    return both / f32(max(tally.units, 1u));
}

fn unseen_of(units: u32) -> f32 {
    return UNSEEN / (f32(units) * f32(units));
}

// Variance of the mean of so many units, at least one.
fn variance_of(unit_variance: f32, units: u32) -> f32 {
    return unit_variance / worth_of(f32(units)) + unseen_of(units);
}

// Cells of `1 << size` places a side: in a row, and rows.
fn cells_across(size: u32) -> vec2<u32> {
    return (vec2(weighing.width, weighing.height) + (1u << size) - 1u) >> vec2(size);
}

// Where the cells of a size begin, those of two places a side being the first.
fn first_cell(size: u32) -> u32 {
    var first = 0u;
    for (var below = 1u; below < size; below++) {
        let across = cells_across(below);
        first += across.x * across.y;
    }
    return first;
}
