//! Checks boundaries within the top-level modules, and forbidden type names.

use super::reading::modules;

#[test]
fn the_kernel_knows_no_detector_and_the_engine_hands_on_no_requests() {
    for (module, code) in modules() {
        let name = module.join("::");
        let used = |path: &str| code.contains(&format!("crate::{path}"));
        if name.starts_with("kernel") {
            assert!(!used("detector"), "{name} uses the detector");
        }
    }
    for (module, code) in modules() {
        if module.first().is_some_and(|room| room == "engine") {
            let hands_on = code.lines().any(|line| line.trim_start().starts_with("pub use crate::"));
            assert!(!hands_on, "{} hands on what is below it", module.join("::"));
        }
    }
}

/// The shell: the files that see the whole window, and of these the ones that have its methods. Everything else is
/// given what it reads and what it owns.
#[test]
fn only_the_shell_sees_the_whole_window_and_no_type_is_called_only_answer_found_pair_or_job() {
    let (shell, with_methods) =
        (["app::effects", "app::render", "app::run", "app::window"], ["app::effects", "app::window"]);
    let mut seen = Vec::new();
    for (module, code) in modules() {
        let name = module.join("::");
        let is_method_of = |line: &str| line.starts_with("impl") && line.contains("BurstscopeApp");
        assert!(
            with_methods.contains(&name.as_str()) || !code.lines().any(is_method_of),
            "{name} adds methods to the whole window; write them for the part that owns the state, and return an Effect"
        );
        // The program and the tests reach the window by this re-export.
        let code = code.replace("pub use window::BurstscopeApp;", "");
        if code.contains("BurstscopeApp") {
            seen.push(name);
        }
    }
    assert_eq!(seen, shell, "give the others what they read and what they own");
    for (module, code) in modules() {
        for line in code.lines() {
            let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
            let kind = words.find(|word| !["pub", "crate", "super", "in"].contains(word));
            // An associated type is named together with its trait.
            let is_associated = kind == Some("type") && line.starts_with(' ');
            let is_type =
                kind.is_some_and(|kind| ["struct", "enum", "type", "trait"].contains(&kind)) && !is_associated;
            let name = words.next().unwrap_or_default();
            assert!(
                !(is_type && ["Answer", "Found", "Pair", "Job"].contains(&name)),
                "{}: say which {name} it is: {line}",
                module.join("::")
            );
        }
    }
}

#[test]
fn the_state_knows_no_widget_and_of_the_engine_what_it_wants() {
    let above = [
        "canvas",
        "panel",
        "inspector",
        "workspace",
        "dialogs",
        "lesson",
        "recovery",
        "actions",
        "gpu",
        "histogram",
        "figure",
        "measure",
        "dataset",
    ];
    let mut requests = 0;
    for (module, code) in modules() {
        let name = module.join("::");
        if !["app::results", "app::document", "app::pane", "app::view"]
            .iter()
            .any(|folder| format!("{name}::").starts_with(&format!("{folder}::")))
        {
            continue;
        }
        // What was done names rows of the action table.
        let names_rows = name.starts_with("app::document");
        for used in above.into_iter().filter(|used| !(names_rows && *used == "actions")) {
            assert!(!code.contains(&format!("app::{used}::")), "{name} uses app::{used}");
        }
        // The results hold what is wanted of the engine; the document, panes and views do not.
        let of_engine: Vec<&str> = code.lines().filter(|line| line.contains("engine::")).collect();
        let may_want = |line: &&str| name.starts_with("app::results") && line.starts_with("use crate::engine::");
        assert!(of_engine.iter().all(may_want), "{name} uses the engine: {of_engine:?}");
        requests += usize::from(code.contains("crate::requests::"));
    }
    assert!(requests > 10, "{requests} files use requests: too few to be all");
}
