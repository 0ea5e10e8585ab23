//! `patterns`: the command line over [`lab`].

fn main() {}
