//! Random streams: one per named purpose, derived from (seed, name, index).

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

/// The generator of every stream; ChaCha8, whose output is fixed for all time.
pub type Stream = ChaCha8Rng;

/// The stream for a purpose. Streams of another seed, name or index are
/// independent, so adding one never changes the others.
///
/// ```
/// use rand::Rng as _;
/// let mut a = solvers::random::stream(7, "xi", 0);
/// let mut b = solvers::random::stream(7, "xi", 1);
/// assert_ne!(a.next_u64(), b.next_u64());
/// ```
pub fn stream(seed: u64, name: &str, index: u64) -> Stream {
    // FNV-1a, 64 bits, over the name; the key is (seed, name, index, length).
    let hash = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    let mut key = [0; 32];
    for (slot, word) in key.chunks_exact_mut(8).zip([seed, hash, index, name.len() as u64]) {
        slot.copy_from_slice(&word.to_le_bytes());
    }
    Stream::from_seed(key)
}

/// The next number of a stream, uniform in [0, 1) with 53 random bits.
pub fn uniform(stream: &mut Stream) -> f64 {
    use rand::Rng as _;
    (stream.next_u64() >> 11) as f64 * (-53.0_f64).exp2()
}

/// The next standard normal number of a stream (Box-Muller, one of the pair), the same bits
/// on every machine.
pub fn normal(stream: &mut Stream) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - uniform(stream))).sqrt();
    radius * libm::cos(std::f64::consts::TAU * uniform(stream))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_uniform_and_repeat() {
        let mut s = stream(1, "test", 0);
        let values: Vec<f64> = (0..20_000).map(|_| uniform(&mut s)).collect();
        let mean = values.iter().sum::<f64>() / 20_000.0;
        // Six standard errors of the mean of 20000 uniform numbers.
        assert!((mean - 0.5).abs() < 6.0 * (1.0_f64 / 12.0 / 20_000.0).sqrt(), "{mean}");
        assert_eq!(values[0].to_bits(), uniform(&mut stream(1, "test", 0)).to_bits());
    }
}
