// Which size of cells a run is about; 1 in `again` for a second look at places of which no size said enough.

struct Layer {
    size: u32,
    again: u32,
    pad_a: u32,
    pad_b: u32,
}
