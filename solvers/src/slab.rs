//! Slabs of planes as the parts of a parallel loop.

/// Fewest voxels that are worth a second thread.
const SERIAL_VOXELS: usize = 1 << 14;

/// Planes of each slab of a box of `nz` planes and `voxels` voxels: all of them on one
/// thread; otherwise two slabs per thread, which even out what the threads are given.
pub fn planes_per_slab(nz: usize, voxels: usize) -> usize {
    let threads = if voxels < SERIAL_VOXELS { 1 } else { rayon::current_num_threads() };
    if threads == 1 { nz } else { nz.div_ceil(2 * threads).max(4.min(nz)) }
}
