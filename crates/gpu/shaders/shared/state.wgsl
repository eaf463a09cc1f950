// What weighing found that holds everywhere.

struct State {
    // Mean squared error of one unit of rays.
    unit: f32,
    // Sizes of cells that were asked.
    sizes: u32,
    // Mean variance of one unit where rays tell of guesses.
    unit_variance: f32,
    pad: u32,
    // Of each size of cells, the squared error of guesses over their formal variance; the rest is padding.
    factors: array<f32, 8>,
}

struct Counts {
    sizes: u32,
    // For each size, places that ask the next one.
    lacking: array<u32, 7>,
}
