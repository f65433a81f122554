//! `--lesson`, `completions` and `man`.

use crate::support::*;
use clap::CommandFactory;

#[test]
fn a_lesson_is_begun_by_name_or_file_and_one_that_is_not_there_or_has_a_mistake_is_said() {
    let home = folder();
    says(home.run_well("--lesson what-noise-does"), &["burstscope-what-noise-does.png"]);
    let own = "title = \"Mine\"\nabout = \"Own.\"\n[[step]]\ntitle = \"One\"\ncaption = \"Look.\"\n";
    home.write("mine.toml", own);
    home.run_well("--lesson mine.toml");
    let drawn: Vec<String> = names(&home).into_iter().filter(|name| name.ends_with(".png")).collect();
    assert_eq!(drawn, ["burstscope-mine.png", "burstscope-what-noise-does.png"]);
    for name in drawn {
        let image = image::open(home.join(name)).expect("a picture").to_rgb8();
        assert!(image.dimensions() == (1280, 800) && image.pixels().any(|p| p.0[0] > 200));
    }
    let home = folder();
    says(home.run_badly("--lesson nothing", 2), &["nothing", "out-of-the-dark"]);
    home.write("bad.toml", "title = \"Mine\"\nabuot = \"x\"\n");
    says(home.run_badly("--lesson bad.toml", 1), &["bad.toml, line 2", "abuot"]);
}

#[test]
fn shells_get_their_completions_and_every_command_has_a_manual_page_with_its_options() {
    let home = folder();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        says(home.run_well(&["completions", shell]), &["burstscope", "detect", "slope-extrema", "lesson"]);
    }
    home.run_badly("completions dos", 2);
    let options = check_page(&home, &burstscope::cli::commands::Cli::command(), &[]);
    assert!(options > 300, "{options} options are too few to be all");
    for wrong in [&["man", "dog"][..], &["man", "evaluate", "charts"]] {
        says(home.run_badly(wrong, 2), &[&format!("no command '{}'", wrong[1..].join(" "))]);
    }
}

/// Checks that the page of the `command` that these words name has its options and commands, and so on for these;
/// returns the number of options.
fn check_page(home: &Path, command: &clap::Command, words: &[&str]) -> usize {
    let page = home.run_well(&[&["man"], words].concat());
    let escaped = |text: String| text.replace('-', "\\-");
    let title = [&["burstscope"], words].concat().join("-");
    assert!(page.contains(&format!("\n.TH {title} 1 ")), "{words:?}: {page}");
    let mut options = 0;
    for long in command.get_arguments().filter(|arg| !arg.is_hide_set()).filter_map(clap::Arg::get_long) {
        assert!(page.contains(&format!("\\fB{}\\fR", escaped(format!("--{long}")))), "{words:?}: --{long}");
        options += 1;
    }
    for inner in command.get_subcommands() {
        let name = inner.get_name();
        assert!(page.contains(&escaped(format!("{title}-{name}(1)"))), "{words:?}: {name}");
        options += check_page(home, inner, &[words, &[name]].concat());
    }
    options
}
