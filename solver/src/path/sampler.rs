//! Random numbers of a path: Owen-scrambled Sobol points (Burley 2020), four dimensions at a time.
//!
//! Each number follows from the pixel, the sample, the run and the place in the path alone: results do not depend on
//! threads.

use crate::geometry::hash;

/// Points of the sequence before its scrambling changes: what the library holds.
const LENGTH: u32 = 1 << 16;

/// Sets of four dimensions that the library holds; paths that need more take them again, scrambled otherwise.
const SETS: u32 = 64;

/// Numbers for one path.
#[derive(Clone, Debug)]
pub struct Sampler {
    index: u32,
    seed: u32,
    drawn: u32,
}

impl Sampler {
    /// For sample `index` of `pixel` in a run with its own `seed`: samples 0, 1, ... of one pixel and seed fill space
    /// evenly together; different seeds are independent.
    pub fn new(pixel: u32, index: u32, seed: u32) -> Self {
        Self {
            index: index % LENGTH,
            seed: hash::mix(hash::mix(pixel, seed), index / LENGTH),
            drawn: 0,
        }
    }

    /// Four numbers in [0, 1).
    pub fn draw(&mut self) -> [f32; 4] {
        let set = self.drawn;
        self.drawn += 1;
        sobol_burley::sample_4d(self.index, set % SETS, hash::mix(self.seed, set / SETS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_pixel_fill_space_evenly() {
        const COUNT: usize = 256;
        for place in [1, 2, 7] {
            let points: Vec<[f32; 4]> = (0..COUNT as u32)
                .map(|index| {
                    let mut sampler = Sampler::new(77, index, 3);
                    (0..place).map(|_| sampler.draw()).last().expect("some")
                })
                .collect();
            // One in each of as many strata, along every axis.
            for axis in 0..4 {
                let mut met = [false; COUNT];
                for point in &points {
                    met[(point[axis] * COUNT as f32) as usize] = true;
                }
                assert!(met.iter().all(|&met| met), "place {place}, axis {axis}");
            }
        }
    }

    #[test]
    fn pixels_samples_seeds_and_places_differ() {
        let drawn = |pixel, index, seed| {
            let mut sampler = Sampler::new(pixel, index, seed);
            [sampler.draw(), sampler.draw()]
        };
        let plain = drawn(5, 6, 7);
        assert_ne!(plain[0], plain[1]);
        for other in [drawn(6, 6, 7), drawn(5, 7, 7), drawn(5, 6, 8)] {
            assert_ne!(plain, other);
        }
    }
}
