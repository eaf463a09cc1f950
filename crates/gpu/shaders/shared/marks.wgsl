// What is marked at each place: in the lowest byte the widest size of cells that it is part of, then how many sizes it asks, then a bit
// for each size that its sixteen places asked.

// Part of every cell.
const EVERY: u32 = 255u;
// More sizes than there are: until one says enough.
const ALL: u32 = SIZES + 1u;

fn fresh_marks(is_covered: bool) -> u32 {
    return EVERY | (select(0u, ALL, is_covered) << 8u);
}

fn widest_of(marks: u32) -> u32 {
    return marks & 0xffu;
}

fn asks_of(marks: u32) -> u32 {
    return (marks >> 8u) & 0xffu;
}

fn with_widest(marks: u32, size: u32) -> u32 {
    return (marks & 0xffffff00u) | min(widest_of(marks), size);
}

fn with_asks(marks: u32, asks: u32) -> u32 {
    return (marks & 0xffff00ffu) | (asks << 8u);
}

fn has_asked(marks: u32, size: u32) -> bool {
    return ((marks >> (16u + size)) & 1u) == 1u;
}

fn with_asked(marks: u32, size: u32) -> u32 {
    return marks | (1u << (16u + size));
}
