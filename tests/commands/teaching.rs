//! `--lesson`, `completions` and `man`.

use super::support::{names, run_badly, run_well};

#[test]
fn a_lesson_is_begun_by_its_name_or_from_its_file() {
    let home = tempfile::tempdir().expect("a folder");
    let text = run_well(home.path(), &["--lesson", "what-noise-does"]);
    assert!(text.contains("burstscope-what-noise-does.png"), "{text}");
    let own = "title = \"Mine\"\nabout = \"Own.\"\n[[step]]\ntitle = \"One\"\ncaption = \"Look.\"\n";
    std::fs::write(home.path().join("mine.toml"), own).expect("written");
    run_well(home.path(), &["--lesson", "mine.toml"]);
    let drawn: Vec<String> = names(home.path()).into_iter().filter(|name| name.ends_with(".png")).collect();
    assert_eq!(drawn, ["burstscope-mine.png", "burstscope-what-noise-does.png"]);
    for name in drawn {
        let image = image::open(home.path().join(name)).expect("a picture").to_rgb8();
        assert!(image.dimensions() == (1280, 800) && image.pixels().any(|p| p.0[0] > 200));
    }
}

#[test]
fn a_lesson_that_is_not_there_or_has_a_mistake_is_said() {
    let home = tempfile::tempdir().expect("a folder");
    let error = run_badly(home.path(), &["--lesson", "nothing"], 2);
    assert!(error.contains("nothing") && error.contains("out-of-the-dark"), "{error}");
    std::fs::write(home.path().join("bad.toml"), "title = \"Mine\"\nabuot = \"x\"\n").expect("written");
    let error = run_badly(home.path(), &["--lesson", "bad.toml"], 1);
    assert!(error.contains("bad.toml, line 2") && error.contains("abuot"), "{error}");
}

#[test]
fn shells_get_their_completions() {
    let home = tempfile::tempdir().expect("a folder");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = run_well(home.path(), &["completions", shell]);
        for word in ["burstscope", "detect", "slope-extrema", "lesson"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    run_badly(home.path(), &["completions", "dos"], 2);
}

#[test]
fn the_program_and_its_commands_have_manual_pages() {
    let home = tempfile::tempdir().expect("a folder");
    let title = |arguments: &[&str]| {
        let page = run_well(home.path(), arguments);
        page.lines().find(|line| line.starts_with(".TH")).map(str::to_owned).unwrap_or_else(|| panic!("{page}"))
    };
    for (arguments, name) in
        [(&["man"][..], "burstscope"), (&["man", "evaluate", "chart"], "burstscope-evaluate-chart")]
    {
        assert!(title(arguments).starts_with(&format!(".TH {name} 1 ")), "{}", title(arguments));
    }
    assert!(run_badly(home.path(), &["man", "dog"], 2).contains("no command 'dog'"));
}
