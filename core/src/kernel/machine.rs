//! What is fitted to the machine: sizes of tiles, strips and blocks.
//!
//! None of these changes a bit of any result; they decide how much fits into registers and caches. The benches named
//! beside each measure it, the single routines in `stages`, a whole detection in `cpu_time` (one thread's CPU time, so
//! that a busy machine matters little). Whoever changes one runs its bench before and after.
//!
//! | constant | held to | what it trades | bench |
//! | --- | --- | --- | --- |
//! | `MAX_VECTORS` | 16 vector registers | sums that hide one another's latency, against spilled registers | `stages` |
//! | `BLOCK_COLUMNS`, `WIDEST_VECTOR` | the widest vectors | whole vectors of any kind | `stages` |
//! | `BATCH_ROWS`, `MAX_LEVEL_ROWS` | second cache, registers | rows that are shared, against their size | `stages` |
//! | `TILE_COLUMNS`, `TILE_ROWS` | second cache | what the filters need around a tile, against its size | `cpu_time` |
//! | `WINDOW_BYTES`, `WINDOWS_BYTES` | third cache, memory | slopes held for the joint search | `cpu_time` |
//! | `STACKED_SLOPES` | second cache | rows of the frames that slopes share | `cpu_time` |
//! | `STRIP_COLUMNS`, `KEYPOINTS_TOGETHER` | second cache | patches that share pixels of the frames | `cpu_time` |
//! | `PATCH_ROWS_TOGETHER` | vector registers | rows of a patch that are read once | `stages` |

/// Vectors whose sums are held at once: enough to hide each other's latency, and two sums of each still fit into
/// sixteen registers.
pub(crate) const MAX_VECTORS: usize = 6;
/// Values of the widest kind of vector.
pub(crate) const WIDEST_VECTOR: usize = 16;
/// Columns that the filter bank makes together: two vectors of the widest kind, a whole number of any kind.
pub(crate) const BLOCK_COLUMNS: usize = 32;
/// Rows that the filter bank finishes before it begins the next ones: few enough that what lies between the passes
/// stays in the second cache.
pub(crate) const BATCH_ROWS: usize = 112;
/// Rows of one level that are made at once, at most; half of them where vectors are shorter and registers fewer.
pub(crate) const MAX_LEVEL_ROWS: usize = 8;
/// Rows of a patch that are combined together: of the rows that one reads, the next one reads all but one.
pub(crate) const PATCH_ROWS_TOGETHER: usize = 4;
/// Columns of a tile. With those held around it for the moves of the refinement it is five blocks of vectors wide, and
/// what lies between the two passes of its filters stays in the second cache.
pub(crate) const TILE_COLUMNS: usize = 148;
/// Rows of a tile where the window does not ask for fewer: enough that the rows its filters need around it matter
/// little.
pub(crate) const TILE_ROWS: usize = 548;
/// Bytes of DoG tiles that the threads' windows of slopes may hold together.
pub(crate) const WINDOWS_BYTES: usize = 128 << 20;
/// Bytes that one of them holds at most: as much as stays in a thread's share of the third cache. Fewer rows than that
/// repeat too much of what the filters need around a tile.
pub(crate) const WINDOW_BYTES: usize = 6 << 20;
/// Slopes whose frames are stacked together, at most: whole rows of the grid where it has two axes, which share the
/// mixing of rows.
pub(crate) const STACKED_SLOPES: usize = 16;
/// Keypoints are described in strips of this many columns, each from top to bottom: what their patches share of the
/// frames is then still in the cache.
pub(crate) const STRIP_COLUMNS: f32 = 200.0;
/// Keypoints that one thread describes in a row.
pub(crate) const KEYPOINTS_TOGETHER: usize = 32;
