//! Cell updates per second of the explicit step, beside the machine's copy bandwidth:
//! the same measurement as `patterns bench`. `cargo bench --bench reaction_diffusion [-- SIZE]`
#![allow(clippy::print_stdout, reason = "a benchmark prints")]

fn main() -> anyhow::Result<()> {
    // Cargo passes `--bench`.
    let n = std::env::args().skip(1).find_map(|arg| arg.parse().ok()).unwrap_or(1024);
    let copy = lab::bench::copy_bandwidth(1)?;
    println!("copy {:.1} GB/s; {n} x {n} cells, million cell updates per second", copy / 1e9);
    for row in lab::bench::reaction_diffusion(n, copy)? {
        let [one, two] = row.rate;
        println!("{:16} {one:6.0} (1 thread) {two:6.0} (2 threads)", row.name);
    }
    Ok(())
}
