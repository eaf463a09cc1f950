// What rays tell of guesses, summed over the places that are part of a cell: crates/estimate/src/hybrid/told.rs.

struct Sums {
    // How many have rays.
    samples: f32,
    // Variances of one unit, and of all rays of a place.
    unit_variance: f32,
    variance: f32,
    pad: f32,
    // Of each size of guesses what it is off by and its formal variance; the rest is padding.
    guesses: array<vec2<f32>, 6>,
}

// Cells of four places a side, then those of sixteen.
const FINER: u32 = 2u;
const WIDER: u32 = 4u;

fn first_sum(size: u32) -> u32 {
    let across = cells_across(FINER);
    return select(across.x * across.y, 0u, size == FINER);
}
