//! The commands: what the window can compute, a command can.
