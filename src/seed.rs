//! One seed a run, and from it a stream of random numbers for every purpose by name.
//!
//! A stream depends on the seed, its name and its index only: not on how many threads run, nor on what other streams
//! were drawn before it. So adding a use of randomness somewhere changes nothing elsewhere.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// The generator behind every stream: fast, portable, the same numbers on every machine.
pub type Stream = ChaCha8Rng;

/// The one seed of a run.
///
/// ```
/// use ballmark::seed::Seed;
/// use rand::RngExt;
/// let seed = Seed(7);
/// let a: u64 = seed.stream("initial weights").random();
/// let b: u64 = seed.stream("initial weights").random();
/// let c: u64 = seed.stream("trial starts").random();
/// assert!(a == b && a != c);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seed(pub u64);

impl Seed {
    /// The stream of that name.
    pub fn stream(self, name: &str) -> Stream {
        self.numbered_stream(name, 0)
    }

    /// One of many streams of that name: the `index`-th trial, restart, snapshot.
    pub fn numbered_stream(self, name: &str, index: u64) -> Stream {
        let mut hash = Sha256::new();
        hash.update(self.0.to_le_bytes());
        hash.update(index.to_le_bytes());
        hash.update(name.as_bytes());
        Stream::from_seed(hash.finalize().into())
    }

    /// The seed that a part of the run has to itself, such as one of several environments: what is drawn from it has nothing
    /// in common with what the other parts draw.
    ///
    /// ```
    /// use ballmark::seed::Seed;
    /// assert!(Seed(7).within("a") == Seed(7).within("a") && Seed(7).within("a") != Seed(7).within("b"));
    /// ```
    pub fn within(self, name: &str) -> Seed {
        let mut hash = Sha256::new();
        hash.update(self.0.to_le_bytes());
        hash.update(b"within ");
        hash.update(name.as_bytes());
        let digest: [u8; 32] = hash.finalize().into();
        let mut first = [0; 8];
        first.copy_from_slice(&digest[..8]);
        Seed(u64::from_le_bytes(first))
    }
}
