//! Checks the order of the rooms, which are the top-level modules.

use super::reading::{code, files, rooms_used};

/// Rooms from the bottom up. Those up to floor 10 are the library, those up to 13 the measuring bench (but for its part
/// of `synth`); Cargo separates both from those above. A room uses rooms of lower numbers only, and none of its own
/// number.
const FLOORS: [(&str, u32); 24] = [
    ("monitor", 0),
    ("error", 1),
    ("files", 2),
    ("camera", 3),
    ("plane", 3),
    ("kernel", 4),
    ("burst", 4),
    ("detector", 5),
    ("synth", 5),
    ("export", 6),
    ("matching", 7),
    ("baseline", 7),
    ("detect", 8),
    ("dataset", 9),
    ("inspect", 10),
    ("evaluate", 11),
    ("recover", 12),
    ("study", 13),
    ("figures", 13),
    ("requests", 14),
    ("engine", 15),
    ("teach", 15),
    ("app", 16),
    ("cli", 17),
];

fn floor(room: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

#[test]
fn no_room_reaches_up() {
    let mut uses = 0;
    for (name, path) in files() {
        let name = name.to_string_lossy().replace('\\', "/");
        let room = name.split(['/', '.']).next().expect("a name").to_owned();
        if matches!(room.as_str(), "lib" | "main") || name.ends_with("/tests.rs") || name.contains("/tests/") {
            continue;
        }
        let own = floor(&room)
            .unwrap_or_else(|| panic!("the room {room} has no floor; give it one in tests/commands/house/floors.rs"));
        for used in rooms_used(&code(&std::fs::read_to_string(&path).expect("text"))) {
            let Some(other) = floor(&used) else { continue };
            uses += 1;
            assert!(used == room || other < own, "{name} uses crate::{used}, which does not stand below {room}");
        }
    }
    assert!(uses > 300, "{uses} uses were read: too few to be all");
}
