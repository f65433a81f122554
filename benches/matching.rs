//! Time of the exact search for the two nearest descriptors, on request: the partner of `versus_opencv_matching.py`,
//! which asks for runs in turns with OpenCV's brute-force matcher, so that both see the same machine and the same
//! descriptors.
//!
//! Arguments: the number of descriptors on each side, and a folder, into which `a.npy` and `b.npy` (`[N, 128]` u8) are
//! written. Then each line of the standard input is a number of threads, and is answered with `wall_secs cpu_secs`.
//! `nearest` in place of a number writes the answer itself into `nearest.npy` (`[N, 3]` i64: index, squared distance,
//! second squared distance).
//!
//! Descriptors are made like the detector's: roots of numbers whose sum is 1, times 512. Half of B's are noisy copies
//! of A's.

use burstscope::Monitor;
use burstscope::detector::Descriptor;
use burstscope::matching::putative::nearest_two;
use ndarray_npy::write_npy;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::io::BufRead;
use std::path::Path;

/// A number from 0 to 1.
fn uniform(rng: &mut ChaCha8Rng) -> f32 {
    rng.next_u32() as f32 / u32::MAX as f32
}

/// Root of shares whose sum is 1, times 512, as bytes.
fn rooted(values: [f32; 128]) -> Descriptor {
    let sum: f32 = values.iter().sum();
    values.map(|x| ((x / sum).sqrt() * 512.0).min(255.0) as u8)
}

fn descriptors(count: usize) -> [Vec<Descriptor>; 2] {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut fresh = || std::array::from_fn(|_| uniform(&mut rng).powi(4));
    let values: Vec<[f32; 128]> = (0..count).map(|_| fresh()).collect();
    let others: Vec<[f32; 128]> = (0..count).map(|_| fresh()).collect();
    let mixed = |k: usize| {
        let (own, part) = (others[k], if k.is_multiple_of(2) { 0.2 } else { 1.0 });
        rooted(std::array::from_fn(|i| (1.0 - part) * values[k][i] + part * own[i]))
    };
    [values.iter().map(|v| rooted(*v)).collect(), (0..count).map(mixed).collect()]
}

fn write(path: &Path, descriptors: &[Descriptor]) {
    let array = ndarray::Array2::from_shape_vec((descriptors.len(), 128), descriptors.concat());
    write_npy(path, &array.expect("128 elements each")).expect("the file can be written");
}

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    let (Some(count), Some(folder)) = (arguments.next().and_then(|n| n.parse().ok()), arguments.next()) else {
        println!("give the number of descriptors and a folder; see benches/versus_opencv_matching.py");
        return;
    };
    let folder = Path::new(&folder);
    let [a, b] = descriptors(count);
    write(&folder.join("a.npy"), &a);
    write(&folder.join("b.npy"), &b);
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("text");
        if line == "nearest" {
            let nearest = nearest_two(&a, &b, &Monitor::default()).expect("not cancelled");
            let rows = nearest.iter().flat_map(|n| {
                let second = n.second_distance_squared.map_or(-1, i64::from);
                [n.index as i64, i64::from(n.distance_squared), second]
            });
            let array = ndarray::Array2::from_shape_vec((a.len(), 3), rows.collect()).expect("three numbers each");
            write_npy(folder.join("nearest.npy"), &array).expect("the file can be written");
            println!("written");
            continue;
        }
        let Ok(threads) = line.trim().parse() else { break };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let (cpu, wall) = (cpu_time::ProcessTime::now(), std::time::Instant::now());
        let found = pool.install(|| nearest_two(&a, &b, &Monitor::default())).expect("not cancelled");
        let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
        assert_eq!(found.len(), a.len());
        println!("{wall:.6} {cpu:.6}");
    }
}
