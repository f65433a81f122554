//! The real program, run as people run it: its output, its files, its exit codes.

#[path = "common/shared.rs"]
mod shared;

#[path = "commands/calibrating.rs"]
mod calibrating;
#[path = "commands/detecting.rs"]
mod detecting;
#[path = "commands/drawing.rs"]
mod drawing;
#[cfg(unix)]
#[path = "commands/ending_well.rs"]
mod ending_well;
#[path = "commands/inspecting.rs"]
mod inspecting;
#[path = "commands/interrupting.rs"]
mod interrupting;
#[cfg(feature = "colmap")]
#[path = "commands/killed.rs"]
mod killed;
#[path = "commands/making.rs"]
mod making;
#[path = "commands/matching.rs"]
mod matching;
#[path = "commands/measuring.rs"]
mod measuring;
#[path = "commands/memory.rs"]
mod memory;
#[cfg(unix)]
#[path = "commands/overwriting.rs"]
mod overwriting;
#[path = "commands/real.rs"]
mod real;
#[path = "commands/reconstructing.rs"]
mod reconstructing;
#[path = "commands/remaking.rs"]
mod remaking;
#[path = "commands/support.rs"]
mod support;
#[path = "commands/teaching.rs"]
mod teaching;
#[path = "commands/trajectories.rs"]
mod trajectories;
