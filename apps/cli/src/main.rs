//! The `conray` program.
fn main() {}
