//! Bursts with exactly known truth: charts of discs, layered scenes, and the camera's noise.
