//! Undo and redo: what was before each change, up to a number of them.

use std::collections::VecDeque;

/// Earlier and later values of something that people change.
#[derive(Debug, Clone)]
pub struct History<T> {
    past: VecDeque<T>,
    future: Vec<T>,
    /// What the last change was made with, while it may go on: a drag of one slider is one change.
    held: Option<String>,
    most: usize,
}

impl<T: Clone + PartialEq> History<T> {
    /// Nothing yet; at most so many steps are kept.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { past: VecDeque::new(), future: Vec::new(), held: None, most }
    }

    /// A change was made with `what`, before which the value was `before`. Changes with the same follow each other as one until
    /// [`Self::settle`]. What was undone is gone.
    pub fn record(&mut self, before: T, what: &str) {
        self.future.clear();
        if self.held.as_deref() == Some(what) {
            return;
        }
        self.held = Some(what.to_owned());
        self.past.push_back(before);
        while self.past.len() > self.most {
            self.past.pop_front();
        }
    }

    /// The hand lets go: the next change is another one.
    pub fn settle(&mut self) {
        self.held = None;
    }

    /// The value before the last change, if there was one; `now` is the present value.
    pub fn undo(&mut self, now: T) -> Option<T> {
        self.settle();
        let before = self.past.pop_back()?;
        self.future.push(now);
        Some(before)
    }

    /// The value after the last change that was undone, if there is one.
    pub fn redo(&mut self, now: T) -> Option<T> {
        self.settle();
        let after = self.future.pop()?;
        self.past.push_back(now);
        Some(after)
    }

    /// How many changes can be undone, and redone.
    #[must_use]
    pub fn steps(&self) -> [usize; 2] {
        [self.past.len(), self.future.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_undone_and_done_again_in_order() {
        let mut history = History::new(10);
        let mut now = 0;
        for next in 1..=3 {
            history.record(now, "a");
            history.settle();
            now = next;
        }
        for expected in [2, 1, 0] {
            now = history.undo(now).unwrap();
            assert_eq!(now, expected);
        }
        assert_eq!((history.undo(now), history.steps()), (None, [0, 3]));
        now = history.redo(now).unwrap();
        assert_eq!(now, 1);
        // A new change forgets what was undone.
        history.record(now, "b");
        assert_eq!((history.redo(9), history.steps()), (None, [2, 0]));
    }

    #[test]
    fn a_drag_is_one_change_and_the_oldest_are_forgotten() {
        let mut history = History::new(2);
        for value in 0..5 {
            history.record(value, "cortex");
        }
        assert_eq!(history.steps(), [1, 0]);
        history.record(5, "light");
        history.record(6, "cortex");
        assert_eq!(history.steps(), [2, 0]);
        assert_eq!((history.undo(7), history.undo(6), history.undo(5)), (Some(6), Some(5), None));
    }
}
