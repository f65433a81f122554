//! Checks what the rooms of the window may do: what is set, what was found, and the hand that changes both.

use super::reading::{code, files};

/// Code of the window's files, each with its path below `app`.
fn window() -> Vec<(String, String)> {
    let below = |name: &std::path::Path| {
        Some(name.to_str().expect("text").replace('\\', "/").strip_prefix("app/")?.to_owned())
            .filter(|name| !name.ends_with("tests.rs"))
    };
    let read = |(name, path): (std::path::PathBuf, std::path::PathBuf)| {
        Some((below(&name)?, code(&std::fs::read_to_string(path).expect("text"))))
    };
    let window: Vec<_> = files().into_iter().filter_map(read).collect();
    assert!(window.len() > 100, "too few files were read to be all");
    window
}

/// A field of the document, a result and a field of the window cannot be taken for one another.
#[test]
fn no_room_is_read_as_if_it_were_another_and_an_action_is_told_by_its_row() {
    let window = window();
    let wrappers: Vec<&str> =
        window.iter().filter(|(_, code)| code.contains("impl Deref")).map(|(name, _)| name.as_str()).collect();
    assert!(wrappers.len() <= 2, "{wrappers:?} dereference; name the part that is read");
    for (name, code) in &window {
        for whole in ["Model", "Results", "Document", "Read<'_>"] {
            assert!(!code.contains(&format!("impl Deref for {whole} ")), "{name} reads through {whole}");
        }
    }
    for name in ["apply/change.rs", "actions/when.rs"] {
        let code = &window.iter().find(|(file, _)| file == name).expect("it is there").1;
        assert!(!code.contains("ActionId::") && !code.contains("ActionId as"), "{name} names actions");
    }
}

/// The document is values: nothing in it is computed, and nothing it is made of knows how answers come.
#[test]
fn the_document_imports_neither_results_nor_engine_and_the_whole_is_written_in_one_room() {
    let mut files = 0;
    for (name, code) in window().iter().filter(|(name, _)| name.starts_with("document/") || name.starts_with("pane/")) {
        files += 1;
        for room in ["app::results", "engine::", "app::effects", "super::super"] {
            assert!(!code.contains(room), "{name} uses {room}");
        }
    }
    assert!(files > 20, "{files} files were read: too few to be all");
    let window = window();
    for (name, code) in &window {
        assert!(!code.contains("impl Model"), "{name}: write a function of what is read (`Read`), or one of app/apply");
        if name.starts_with("results/") {
            for word in ["&mut Model", "&mut Document", "app::apply"] {
                assert!(!code.contains(word), "{name} has `{word}`: what is found does not change what is set");
            }
        }
    }
    assert!(window.iter().any(|(name, code)| name == "apply/mod.rs" && code.contains("model: &mut Model")));
}
