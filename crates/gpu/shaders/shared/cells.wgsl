// Reads cells of any size; the file that includes it binds `cells`.

// Cells of one size.
struct Grid {
    size: u32,
    first: u32,
    across: vec2<u32>,
}

fn grid_of(size: u32) -> Grid {
    return Grid(size, first_cell(size), cells_across(size));
}

fn is_in(grid: Grid, at: vec2<i32>) -> bool {
    return all(at >= vec2(0)) && all(at < vec2<i32>(grid.across));
}

// Nothing outside.
fn cell_at(grid: Grid, at: vec2<i32>) -> Cell {
    if !is_in(grid, at) {
        return Cell();
    }
    let place = vec2<u32>(at);
    if grid.size > 0u {
        return cells[grid.first + place.y * grid.across.x + place.x];
    }
    let index = place.y * weighing.stride + place.x;
    let tally = tallies[index];
    return Cell(places[index].position, worth_of(f32(tally.units)), places[index].normal, mean_of(tally));
}

// The worth of that cell alone.
fn worth_at(grid: Grid, at: vec2<i32>) -> f32 {
    if !is_in(grid, at) {
        return 0.0;
    }
    let place = vec2<u32>(at);
    if grid.size > 0u {
        return cells[grid.first + place.y * grid.across.x + place.x].worth;
    }
    return worth_of(f32(tallies[place.y * weighing.stride + place.x].units));
}
