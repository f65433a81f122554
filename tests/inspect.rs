//! Explanations are held to what they explain: over a whole picture the verdicts add up to the tally, and what they
//! call kept is what was kept.

#[path = "inspect/comparing.rs"]
mod comparing;
#[path = "inspect/law.rs"]
mod law;
#[path = "inspect/probing.rs"]
mod probing;
#[path = "inspect/slopes.rs"]
mod slopes;
#[path = "inspect/surveying.rs"]
mod surveying;
