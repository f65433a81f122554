//! Choice of the methods that are compared, and display settings.

use crate::app::project::compare::Contender;
use serde::{Deserialize, Serialize};

/// Choice of the methods that are compared, and display settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CompareLook {
    /// The methods.
    pub methods: Vec<Contender>,
    /// Whether features are drawn.
    pub features: bool,
}

impl Default for CompareLook {
    fn default() -> Self {
        Self { methods: Contender::ALL.to_vec(), features: true }
    }
}

impl CompareLook {
    /// Whether `method` is compared.
    pub fn shows(&self, method: Contender) -> bool {
        self.methods.contains(&method)
    }

    /// Adds `method` to the comparison, or removes it.
    pub fn show(&mut self, method: Contender, shown: bool) {
        self.methods.retain(|m| *m != method);
        if shown {
            self.methods.push(method);
            self.methods.sort_unstable();
        }
    }

    /// Copy with the methods sorted, each once: a file may contain any values.
    #[must_use]
    pub fn sanitised(mut self) -> Self {
        self.methods.sort_unstable();
        self.methods.dedup();
        self
    }
}
