//! Random numbers of a path: Owen-scrambled Sobol points (Burley 2020), four dimensions at a time, for its first
//! bounces; beyond them, where evenness no longer tells, hashes.
//!
//! Each number follows from the pixel, the sample, the run and the place in the path alone: results do not depend on
//! threads.

use crate::geometry::hash;

/// Points of the sequence before its scrambling changes: what the library holds.
const LENGTH: u32 = 1 << 16;

/// Sets of four numbers that are even: the camera's, and two for each of two bounces.
const EVEN_SETS: u32 = 3;

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
        if set < EVEN_SETS {
            return sobol_burley::sample_4d(self.index, set, self.seed);
        }
        let word = hash::mix(hash::mix(self.seed, self.index), set);
        [0, 1, 2, 3].map(|number| hash::unit(word, number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_pixel_fill_space_evenly() {
        const COUNT: usize = 256;
        for place in [1, EVEN_SETS] {
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
    fn later_numbers_are_random() {
        // χ² over 64 strata of each number and of pairs of neighbours: 63 ± 11.
        const COUNT: u32 = 1 << 14;
        let draws: Vec<[f32; 4]> = (0..COUNT)
            .map(|index| {
                let mut sampler = Sampler::new(index % 64, index / 64, 5);
                let place = EVEN_SETS + 1 + index % 3;
                (0..place).map(|_| sampler.draw()).last().expect("some")
            })
            .collect();
        let check = |stratum: &dyn Fn(&[f32; 4]) -> usize| {
            let mut counts = [0u32; 64];
            for draw in &draws {
                counts[stratum(draw)] += 1;
            }
            let expected = f64::from(COUNT) / 64.0;
            let squares = counts.map(|count| (f64::from(count) - expected).powi(2));
            squares.iter().sum::<f64>() / expected
        };
        for axis in 0..4 {
            let alone = check(&|draw| (draw[axis] * 64.0) as usize);
            let next = (axis + 1) % 4;
            let pair = check(&|draw| (draw[axis] * 8.0) as usize * 8 + (draw[next] * 8.0) as usize);
            for found in [alone, pair] {
                assert!(
                    (20.0..120.0).contains(&found),
                    "axis {axis}: {alone} {pair}"
                );
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
