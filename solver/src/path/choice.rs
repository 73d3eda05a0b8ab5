//! One of many, chosen by weight.

/// Weights of many, cumulated.
#[derive(Clone)]
pub(super) struct Choice {
    up_to: Vec<f32>,
}

impl Choice {
    /// Of these weights, which are not negative.
    pub(super) fn new(weights: Vec<f32>) -> Self {
        let whole: f64 = weights.iter().map(|&weight| f64::from(weight)).sum();
        let mut sum = 0.0;
        let up_to = weights
            .into_iter()
            .map(|weight| {
                sum += f64::from(weight);
                (sum / whole) as f32
            })
            .collect();
        Self { up_to }
    }

    /// The one that a number in [0, 1) chooses, and a new such number; `None` where there is none.
    pub(super) fn choose(&self, at: f32) -> Option<(usize, f32)> {
        let index = self.up_to.partition_point(|&up_to| up_to <= at);
        let before = if index > 0 {
            self.up_to[index - 1]
        } else {
            0.0
        };
        let share = self.up_to.get(index)? - before;
        Some((index, (at - before) / share))
    }

    /// How often [`Self::choose`] chooses this one.
    pub(super) fn share(&self, index: usize) -> f32 {
        let before = if index > 0 {
            self.up_to[index - 1]
        } else {
            0.0
        };
        self.up_to[index] - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn nothing_is_chosen_of_none() {
        assert!(Choice::new(Vec::new()).choose(0.5).is_none());
    }
}
