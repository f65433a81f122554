//! Checks the order of the rooms, which are the top-level modules.

use super::reading::{code, files, rooms_used};

/// Rooms from the bottom up. Those up to floor 8 are the library, those up to 11 the measuring bench (but for its part
/// of `synth`); Cargo separates both from those above. A room uses rooms of lower numbers only, and none of its own
/// number.
const FLOORS: [(&str, u32); 22] = [
    ("monitor", 0),
    ("files", 0),
    ("plane", 1),
    ("kernel", 2),
    ("burst", 2),
    ("detector", 3),
    ("synth", 3),
    ("export", 4),
    ("matching", 5),
    ("baseline", 5),
    ("detect", 6),
    ("dataset", 7),
    ("inspect", 8),
    ("evaluate", 9),
    ("recover", 10),
    ("study", 11),
    ("figures", 11),
    ("requests", 12),
    ("engine", 13),
    ("teach", 13),
    ("app", 14),
    ("cli", 15),
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
