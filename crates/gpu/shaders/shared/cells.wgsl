// Reads cells of any size; the file that includes it binds `cells`.

// Nothing outside.
fn cell_at(size: u32, at: vec2<i32>) -> Cell {
    let across = cells_across(size);
    if any(at < vec2(0)) || any(at >= vec2<i32>(across)) {
        return Cell();
    }
    let place = vec2<u32>(at);
    if size > 0u {
        return cells[first_cell(size) + place.y * across.x + place.x];
    }
    let index = place.y * weighing.stride + place.x;
    let tally = tallies[index];
    return Cell(places[index].position, worth_of(f32(tally.units)), places[index].normal, mean_of(tally));
}
