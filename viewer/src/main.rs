//! The program sheen.
fn main() {}
