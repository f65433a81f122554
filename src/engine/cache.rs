//! Cache of pictures with a byte budget; the least recently used is dropped first.

use crate::requests::{Picture, PictureKey, PictureRequest};
use std::collections::HashMap;

#[derive(Debug)]
pub struct PictureCache {
    budget_bytes: usize,
    bytes: usize,
    clock: u64,
    entries: HashMap<PictureKey, (Picture, u64)>,
}

impl PictureCache {
    pub fn new(budget_bytes: usize) -> Self {
        Self { budget_bytes, bytes: 0, clock: 0, entries: HashMap::new() }
    }

    pub fn bytes(&self) -> usize {
        self.bytes
    }

    pub fn len(&self) -> usize {
        self.entries.len()
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub fn get(&mut self, request: &PictureRequest) -> Option<Picture> {
        self.clock += 1;
        let (picture, used) = self.entries.get_mut(&request.key())?;
        *used = self.clock;
        Some(picture.clone())
    }

    /// Frames are not kept: the burst holds them. Nor is a picture that exceeds the budget.
    pub fn insert(&mut self, picture: &Picture) {
        let size = picture.bytes();
        if picture.is_frame() || size > self.budget_bytes {
            return;
        }
        self.clock += 1;
        if let Some((old, _)) = self.entries.insert(picture.request.key(), (picture.clone(), self.clock)) {
            self.bytes -= old.bytes();
        }
        self.bytes += size;
        self.set_budget(self.budget_bytes);
    }

    /// Drops pictures beyond the budget, those first that were unused for longest.
    pub fn set_budget(&mut self, budget_bytes: usize) {
        self.budget_bytes = budget_bytes;
        while self.bytes > self.budget_bytes {
            let oldest = self.entries.iter().min_by_key(|(_, (_, used))| *used).map(|(key, _)| *key);
            let Some((old, _)) = oldest.and_then(|key| self.entries.remove(&key)) else { break };
            self.bytes -= old.bytes();
        }
    }
}
