//! Values that are made again when their key changes.

use egui::{Context, Id};
use std::any::Any;
use std::fmt::Debug;
use std::hash::Hash;
use std::sync::Arc;

/// The last value, with its key.
#[derive(Debug, Clone)]
pub struct Memo<K, V>(Option<(K, V)>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, V> Memo<K, V> {
    pub fn get(&mut self, key: K, make: impl FnOnce() -> V) -> &V {
        let kept = self.0.take().filter(|(of, _)| *of == key);
        &self.0.insert(kept.unwrap_or_else(|| (key, make()))).1
    }
}

/// The value of `key`, which the toolkit keeps under `id` until that of another key is asked for.
pub fn kept<K, V>(ctx: &Context, id: impl Debug + Hash, key: K, make: impl FnOnce() -> V) -> V
where
    K: PartialEq + Clone + Send + Sync + 'static,
    V: Clone + Send + Sync + 'static,
{
    let id = Id::unique(id);
    let mut memo: Memo<K, V> = ctx.data_mut(|data| data.remove_temp(id)).unwrap_or_default();
    let value = memo.get(key, make).clone();
    ctx.data_mut(|data| data.insert_temp(id, memo));
    value
}

/// A shared value, which equals itself alone. It is kept alive, so that no other has its address.
#[derive(Debug, Clone)]
pub struct Itself(Arc<dyn Any + Send + Sync>);

impl<T: Any + Send + Sync> From<&Arc<T>> for Itself {
    fn from(shared: &Arc<T>) -> Self {
        Self(shared.clone())
    }
}

impl PartialEq for Itself {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(Arc::as_ptr(&self.0), Arc::as_ptr(&other.0))
    }
}
