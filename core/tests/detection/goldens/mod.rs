//! Agreement with the published implementations: VLFeat's SIFT, LiFF, and the authors' own BuFF code; and a real
//! camera's noise.
//!
//! Each test sets our parameters to theirs, converts coordinates as the method page says, and counts. Two features
//! agree when they are within 0.1 px, 2 % in scale and 0.03 rad, at the same slope. The bounds explain the remaining
//! differences.

mod authors;
mod own;
mod published;
mod vlfeat_liff;
