//! The `patrold` program: parse, run, exit code.

fn main() {}
