//! One of many, chosen by weight.
//!
//! By cutpoints (Chen and Asau 1974, "On generating random variates from an empirical distribution"): even parts of
//! [0, 1) know where a search starts. Cost: about two steps a choice, for any number of weights.

/// Weights of many, cumulated.
#[derive(Clone)]
pub(super) struct Choice {
    up_to: Vec<f32>,
    /// For each of as many even parts of [0, 1): the one that the part's beginning chooses.
    first: Vec<u32>,
}

impl Choice {
    /// Of these weights, which are not negative.
    pub(super) fn new(weights: Vec<f32>) -> Self {
        let whole: f64 = weights.iter().map(|&weight| f64::from(weight)).sum();
        let mut sum = 0.0;
        let up_to: Vec<f32> = weights
            .into_iter()
            .map(|weight| {
                sum += f64::from(weight);
                (sum / whole) as f32
            })
            .collect();
        let count = up_to.len();
        let first = (0..count)
            .map(|part| {
                let begin = part as f32 / count as f32;
                up_to.partition_point(|&up_to| up_to <= begin) as u32
            })
            .collect();
        Self { up_to, first }
    }

    /// The one that a number in [0, 1) chooses, and a new such number; `None` where there is none.
    pub(super) fn choose(&self, at: f32) -> Option<(usize, f32)> {
        let part = (at * self.first.len() as f32) as usize;
        let mut index = *self.first.get(part)? as usize;
        // A product may round up to the next part.
        while index > 0 && self.up_to[index - 1] > at {
            index -= 1;
        }
        while *self.up_to.get(index)? <= at {
            index += 1;
        }
        let before = self.before(index);
        let share = self.up_to[index] - before;
        Some((index, (at - before) / share))
    }

    fn before(&self, index: usize) -> f32 {
        if index > 0 {
            self.up_to[index - 1]
        } else {
            0.0
        }
    }

    /// How often [`Self::choose`] chooses this one.
    pub(super) fn share(&self, index: usize) -> f32 {
        self.up_to[index] - self.before(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash;

    #[test]
    fn choices_are_as_frequent_as_their_shares() {
        let choice = Choice::new(vec![0.0, 3.0, 0.0, 1.0, 4.0, 0.0]);
        let mut counts = [0u32; 6];
        const COUNT: u32 = 8000;
        for i in 0..COUNT {
            let (index, rest) = choice.choose(i as f32 / COUNT as f32).expect("some");
            assert!((0.0..1.0).contains(&rest), "{rest}");
            counts[index] += 1;
        }
        assert_eq!(counts, [0, 3000, 0, 1000, 4000, 0]);
        let shares = [0.0, 0.375, 0.0, 0.125, 0.5, 0.0];
        for (index, share) in shares.into_iter().enumerate() {
            assert_eq!(choice.share(index), share);
        }
    }

    #[test]
    fn choices_are_those_of_a_search_through_all() {
        // Weights over nine orders of magnitude.
        let weights = (0..1000u32).map(|i| hash::unit(i, 0).powi(30)).collect();
        let choice = Choice::new(weights);
        for i in 0..4096u32 {
            let at = hash::unit(i, 1);
            let found = choice.choose(at).expect("some").0;
            assert_eq!(found, choice.up_to.partition_point(|&up_to| up_to <= at));
        }
    }

    #[test]
    fn nothing_is_chosen_of_none() {
        assert!(Choice::new(Vec::new()).choose(0.5).is_none());
    }
}
