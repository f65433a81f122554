//! Shared budget for all searches of the process: a search plans with the memory that the running ones have left.
//!
//! A search that does not fit beside others is done in its smallest form (one thread, the smallest groups of slopes)
//! rather than made to wait: another search may be waiting for the thread that started it.

use super::Plan;
use crate::detector::params::{DetectorParams, ParamError};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Memory taken by searches that share a budget.
#[derive(Debug, Default)]
pub(crate) struct Account {
    /// Sum of the shares, bytes.
    taken: Mutex<u64>,
}

/// The account of all searches of the process.
pub(crate) static OF_PROCESS: Account = Account::new();

/// Memory of a search, released when dropped.
#[derive(Debug)]
pub(crate) struct Share<'account> {
    account: &'account Account,
    bytes: u64,
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        let mut taken = self.account.taken();
        *taken = taken.saturating_sub(self.bytes);
    }
}

impl Account {
    pub(crate) const fn new() -> Self {
        Self { taken: Mutex::new(0) }
    }

    fn taken(&self) -> MutexGuard<'_, u64> {
        // A number stays valid if a thread panics while it holds the lock.
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Plans as [`Plan::new`], within the part of `budget` that the other searches of this account leave.
    ///
    /// # Errors
    /// As [`Plan::new`] within the whole budget.
    pub(crate) fn plan(
        &self,
        params: &DetectorParams,
        frames: usize,
        size: (usize, usize),
        budget: Option<u64>,
    ) -> Result<(Plan, Share<'_>), ParamError> {
        let mut taken = self.taken();
        let left = budget.map(|budget| budget.saturating_sub(*taken));
        let plan = Plan::new(params, frames, size, left).or_else(|_| Plan::smallest(params, frames, size, budget))?;
        let share = Share { account: self, bytes: plan.bytes };
        *taken = taken.saturating_add(share.bytes);
        Ok((plan, share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::SlopeGrid;

    #[test]
    fn a_search_plans_with_what_others_leave() {
        let params =
            DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 20, -3.0..=3.0, 20), ..DetectorParams::default() };
        let account = Account::new();
        let plan = |budget| account.plan(&params, 10, (1600, 1200), Some(budget));
        let (alone, share) = plan(1 << 50).expect("it fits");
        assert_eq!((alone.search.len(), share.bytes), (1, alone.bytes));
        let budget = alone.bytes + alone.bytes / 2;
        let (beside, second) = plan(budget).expect("in groups");
        assert!(beside.search.len() > 1 && beside.bytes < alone.bytes, "{beside:?}");
        let (third, _) = plan(budget).expect("in its smallest form");
        assert_eq!(third, Plan::smallest(&params, 10, (1600, 1200), Some(budget)).expect("it fits"));
        assert_eq!(third.threads, 1);
        drop((share, second));
        let (again, _) = plan(budget).expect("the others gave back what they had");
        assert_eq!(again, alone);
        assert!(plan(1000).is_err(), "a search that never fits is refused");
    }
}
