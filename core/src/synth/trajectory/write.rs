//! Writing a trajectory: a folder of bursts with poses, lens, gold views and truth beside it, completely or not at all.

use super::Trajectory;
use crate::monitor::{Monitor, Stage};
use crate::synth::folder::WriteBurstError;
use crate::synth::folder::{io, write_folder};
use crate::synth::write::{frame_name, write_frame};
use std::fmt::Write as _;
use std::path::Path;

/// Entries of the folder.
const ENTRIES: [&str; 5] = ["bursts", "gold", "poses.txt", "lens.toml", TRUTH_FILE];
/// File that marks the folder as a trajectory and holds its truth.
const TRUTH_FILE: &str = "trajectory.json";

/// Writes a trajectory into the folder `dir`, which is created: `bursts/NAME/frame_000.png` … (16 bit), `gold/NAME.png`
/// (the views at mid-burst without noise, 16 bit), `poses.txt` (lines `timestamp tx ty tz qx qy qz qw`: the burst's
/// number, the camera in the world at mid-burst), `lens.toml` (the camera) and `trajectory.json` (the truth). An
/// earlier trajectory in `dir` is replaced as a whole; a folder that holds anything else is left unchanged.
///
/// # Errors
/// See [`WriteBurstError`]; the folder is then unchanged.
pub fn write_trajectory(dir: &Path, trajectory: &Trajectory, monitor: &Monitor) -> Result<(), WriteBurstError> {
    write_folder(dir, replaceable, |fresh| {
        let make = |folder: &Path| std::fs::create_dir(folder).map_err(io(folder));
        let (bursts, gold) = (fresh.join("bursts"), fresh.join("gold"));
        make(&bursts)?;
        make(&gold)?;
        let count = trajectory.cameras.len();
        for index in 0..count {
            let name = Trajectory::name(index);
            let folder = bursts.join(&name);
            make(&folder)?;
            let burst = trajectory.burst(index, monitor)?;
            for (t, frame) in burst.frames.iter().enumerate() {
                monitor.check()?;
                write_frame(&folder.join(frame_name(t)), frame)?;
            }
            write_frame(&gold.join(format!("{name}.png")), &trajectory.gold(index, monitor)?)?;
            monitor.report(Stage::Write, (index + 1) as f32 / count as f32);
        }
        let truth = serde_json::to_string_pretty(&trajectory.truth()).map_err(std::io::Error::other);
        let write = |name: &str, text: String| {
            let path = fresh.join(name);
            std::fs::write(&path, text).map_err(io(&path))
        };
        write(TRUTH_FILE, truth.map_err(io(&fresh.join(TRUTH_FILE)))? + "\n")?;
        write("poses.txt", poses(trajectory))?;
        write("lens.toml", trajectory.lens.to_toml())?;
        Ok(monitor.check()?)
    })
}

/// The text of the trajectory file.
fn poses(trajectory: &Trajectory) -> String {
    let mut text = String::from(
        "# timestamp tx ty tz qx qy qz qw: the burst's number, the camera in the world at mid-burst, metres\n",
    );
    for (index, camera) in trajectory.cameras.iter().enumerate() {
        let [tx, ty, tz, qx, qy, qz, qw] = camera.tum();
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{index} {tx} {ty} {tz} {qx} {qy} {qz} {qw}");
    }
    text
}

/// Whether `dir` holds only files that [`write_trajectory`] writes.
fn replaceable(dir: &Path) -> std::io::Result<bool> {
    let names = |folder: &Path| -> std::io::Result<Vec<String>> {
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
    };
    let numbered = |name: &str, start: &str, end: &str| {
        let number = name.strip_prefix(start).and_then(|rest| rest.strip_suffix(end));
        number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let top = names(dir)?;
    if !(top.iter().any(|name| name == TRUTH_FILE) && top.iter().all(|name| ENTRIES.contains(&name.as_str()))) {
        return Ok(false);
    }
    let gold = dir.join("gold");
    if gold.exists() && !names(&gold)?.iter().all(|name| numbered(name, "burst_", ".png")) {
        return Ok(false);
    }
    let bursts = dir.join("bursts");
    for name in if bursts.exists() { names(&bursts)? } else { Vec::new() } {
        let folder = bursts.join(&name);
        let frames = || Ok::<_, std::io::Error>(names(&folder)?.iter().all(|name| numbered(name, "frame_", ".png")));
        if !(numbered(&name, "burst_", "") && folder.is_dir() && frames()?) {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::super::TrajectoryParams;
    use super::*;

    #[test]
    fn an_earlier_trajectory_is_replaced_and_other_files_are_left_alone() {
        let home = tempfile::tempdir().expect("a folder");
        let dir = home.path().join("way");
        let params = TrajectoryParams { width: 48, height: 36, bursts: 2, frames: 2, planes: 2, ..Default::default() };
        let params = TrajectoryParams { max_slope: 1.0, ..params };
        let write = |bursts: usize| {
            let params = TrajectoryParams { bursts, ..params.clone() };
            let trajectory = Trajectory::new(&params, &Monitor::default()).expect("a trajectory");
            write_trajectory(&dir, &trajectory, &Monitor::default())
        };
        write(3).expect("written");
        write(2).expect("replaced");
        assert!(dir.join("bursts/burst_001/frame_001.png").is_file() && !dir.join("bursts/burst_002").exists());
        assert!(!dir.join("gold/burst_002.png").exists());
        // A foreign note among the frames, or beside them, protects the folder.
        for place in ["bursts/burst_000/notes.txt", "bursts/notes.txt", "gold/notes.txt", "notes.txt"] {
            std::fs::write(dir.join(place), "precious").expect("written");
            assert!(matches!(write(1), Err(WriteBurstError::Occupied(_))), "{place}");
            std::fs::remove_file(dir.join(place)).expect("removed");
        }
        write(1).expect("replaced");
    }

    #[test]
    fn cancelling_leaves_nothing() {
        let home = tempfile::tempdir().expect("a folder");
        let params = TrajectoryParams { width: 48, height: 36, bursts: 1, frames: 2, planes: 1, ..Default::default() };
        let trajectory = Trajectory::new(&params, &Monitor::default()).expect("a trajectory");
        let monitor = Monitor::default();
        monitor.cancel();
        let result = write_trajectory(&home.path().join("way"), &trajectory, &monitor);
        assert!(matches!(result, Err(WriteBurstError::Cancelled(_))));
        assert_eq!(std::fs::read_dir(home.path()).expect("a folder").count(), 0);
    }
}
