//! Lists of things with memory of their own, which they keep from frame to frame.

/// What a list of changing length has no use for at the moment. The k-th element gets the k-th memory back, so that a
/// frame like one before it needs no new memory.
#[derive(Debug, Clone, Default)]
pub(super) struct Spare<T>(Vec<T>);

impl<T: Default> Spare<T> {
    /// Makes a list `length` elements long. Those that come to it hold what they held before.
    pub(super) fn resize(&mut self, list: &mut Vec<T>, length: usize) {
        // room for the whole list, so that a shorter one never takes memory
        let longest = list.len().max(length);
        self.0.reserve(longest.saturating_sub(self.0.len()));
        while list.len() > length {
            self.0.extend(list.pop());
        }
        while list.len() < length {
            list.push(self.0.pop().unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_that_shrinks_and_grows_again_keeps_its_memory() {
        let mut spare = Spare::default();
        let mut list: Vec<Vec<u8>> = Vec::new();
        spare.resize(&mut list, 3);
        list[2].reserve(100);
        spare.resize(&mut list, 1);
        assert_eq!(list.len(), 1);
        spare.resize(&mut list, 4);
        assert!(list[2].capacity() >= 100);
    }
}
