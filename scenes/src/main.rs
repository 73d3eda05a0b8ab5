//! Writes the scenes of this folder.
fn main() {}
