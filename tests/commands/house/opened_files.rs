//! Checks that all files which others made are opened by one function, which waits for no pipe and no device.

use super::reading::modules;

/// Modules that open by themselves: the function's own; those of decoders, whose files the front of all decoders has
/// opened before; those that read what the system writes; and those that make a file that was not there.
const OTHERS: [&str; 9] = [
    "files",
    "burst::reading::exif",
    "burst::reading::plain",
    "burst::reading::tiles",
    "cli::signals",
    "export::atomic",
    "export::colmap::database",
    "files::lock",
    "plane::memory",
];

#[test]
fn files_of_others_are_opened_by_one_function() {
    let calls = ["File::open(", "File::options()", "fs::read(", "fs::read_to_string("];
    let mut used = 0;
    for (module, code) in modules() {
        let name = module.join("::");
        used += code.matches("files::open").count() + code.matches("read_bytes(").count();
        let code = code.split("mod tests {").next().unwrap_or_default();
        let found = code.lines().find(|line| {
            // Options may be made for the function.
            let opens = line.contains("OpenOptions::new()") && !line.contains("open_as(");
            opens && line.contains(".open(") || calls.iter().any(|call| line.contains(call))
        });
        if !OTHERS.contains(&name.as_str()) {
            assert_eq!(found, None, "{name} opens a file by itself; use files::open, open_as, read_bytes or read_text");
        }
    }
    assert!(used > 10, "{used} uses were read: too few to be all");
}
