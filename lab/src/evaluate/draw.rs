//! Chance, always from an explicit seed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A source of draws. The same seed and stream give the same draws on any machine.
#[derive(Debug, Clone)]
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// Stream number `stream` of `seed`; streams share nothing.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Self(rng)
    }

    /// A seed for something of its own.
    pub fn seed(&mut self) -> u64 {
        self.0.random()
    }

    /// Another source, which goes its own way from here.
    pub fn fork(&mut self) -> Self {
        Self::new(self.seed(), 0)
    }

    /// Uniform between the two.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// True with this chance.
    pub fn chance(&mut self, chance: f64) -> bool {
        self.0.random::<f64>() < chance
    }

    /// Plus or minus one.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// A whole number from `low` to `high`, both possible.
    pub fn count(&mut self, low: usize, high: usize) -> usize {
        let kinds = (high - low + 1) as f64;
        low + ((self.0.random::<f64>() * kinds) as usize).min(high - low)
    }

    /// One of them; `None` of none.
    pub fn pick<'a, T>(&mut self, among: &'a [T]) -> Option<&'a T> {
        let last = among.len().checked_sub(1)?;
        among.get(self.count(0, last))
    }

    /// Gaussian, mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }
}
