//! Explanations are held to what they explain: over a whole picture the verdicts add up to the tally, and what they
//! call kept is what was kept.

mod comparing;
mod law;
mod probing;
mod slopes;
mod surveying;
