//! Numbers, names and files that are made to end the program, to make it wait, or to do what nobody asked for.

use crate::support::*;
use burstscope::files::{shell_path, shell_word};
use burstscope::requests::{detect_line, next_commands};

#[test]
fn a_misspelt_command_opens_nothing_and_a_list_that_is_played_writes_nothing_but_its_picture() {
    let home = folder();
    for (words, meant) in
        [(&["matchs", "demo", "demo-later"][..], "match"), (&["detct"], "detect"), (&["Film"], "film")]
    {
        says(home.run_badly(words, 2), &[&format!("did you mean 'burstscope {meant}'?")]);
    }
    let error = home.run_badly("night", 1);
    assert!(error.contains("there is no such file or folder") && !error.contains("mean"), "{error}");
    assert_eq!(names(&home), [""; 0], "nothing is drawn of what cannot be opened");
    for name in ["a", "b"] {
        let size = ["--width", "320", "--height", "240", "--frames", "2", "--discs", "5"];
        let out = format!("ds/{name}");
        home.run_well(&[&["synth", "chart", "--out", &out, "--quiet"][..], &size].concat());
    }
    for action in ["{ do = \"detect_all\" }", "\"detect_all_anyway\""] {
        let list = format!(
            "version = 1\ndid = [\n[{{ open_dataset = {{ paths = [\"./ds\"] }} }}],\n[{{ use_feature_folder = \"./victim\" }}],\n[{action}],\n]\n"
        );
        home.write("list.toml", list);
        says(home.run_badly("render --play list.toml --out a.png", 2), &["detect_all", "writes files"]);
        assert_eq!(names(&home), ["ds", "list.toml"]);
    }
}

const LARGEST: &str = "9223372036854775807";

#[test]
fn a_number_that_no_file_can_keep_is_refused_where_it_is_read() {
    let home = folder();
    let beyond = ["9223372036854775808", "18446744073709551615", "99999999999999999999999"];
    for command in [
        "detect demo-tripod --out o --json --max-features N",
        "detect demo-tripod --out o --json --frames 0..N",
        "detect demo-tripod --out o --take 0..N",
        "detect demo-tripod --out o --burst-length N",
        "probe demo-tripod --at 9,9 --json --max-features N",
        "decoys demo-tripod --json --frames N..5",
        "case demo-tripod --out a.burstcase --max-features N",
        "match demo demo-later --out o --json --max-features N",
        "synth chart --out o --seed N",
        "evaluate chart --seeds N",
        "render demo --out a.png --frame N",
        "detect demo-tripod --out o --memory N",
    ] {
        for number in beyond {
            let command = command.replace('N', number);
            let words = command.words();
            let error = home.run_badly(&words, 2);
            assert!(error.contains(number), "{command}: {error}");
            let is_told = [LARGEST, "too large", "is neither", "is not in"].iter().any(|words| error.contains(words));
            assert!(is_told, "{command}: {error}");
        }
    }
    assert_eq!(names(&home), Vec::<String>::new());
    let error = home.run_badly("detect demo-tripod --out o --frames 0..18446744073709551615", 2);
    assert!(error.contains(&format!("18446744073709551615 is more than {LARGEST}")), "{error}");
    let error = home.run_badly("synth chart --out o --seed 9223372036854775808", 2);
    assert!(error.contains(&format!("--seed: 9223372036854775808 is more than {LARGEST}")), "{error}");
    home.run_well(&["case", "demo-tripod", "--out", "a.burstcase", "--json", "--max-features", LARGEST]);
}

#[cfg(unix)]
#[test]
fn no_pipe_is_waited_for() {
    let home = folder();
    let pipe = |name: &str| {
        assert!(Command::new("mkfifo").arg(home.join(name)).status().expect("mkfifo runs").success());
    };
    let folder = |name: &str| fs::create_dir_all(home.join(name)).expect("made");
    folder("bag");
    ["bag/metadata.yaml", "a.burstcase", "a.toml", "times.csv", "a.csv"].iter().for_each(|name| pipe(name));
    for left in ["out/.burstscope-abcdef.tmp", "out/.burstscope-lock.tmp"] {
        folder(left);
        pipe(&format!("{left}/in-use"));
    }
    ["out/.burstscope-x.lock", "locked.pipe"].iter().for_each(|lock| pipe(lock));
    folder("taken");
    pipe("taken/.burstscope-lock");
    let list =
        "version = 1\ndid = [[{ open = [\"a\", \"demo-tripod\"] }], [{ open_features = [\"a\", \"./a.csv\"] }]]\n";
    home.write("list.toml", list);
    for (command, code) in [
        ("info bag", Some(1)),
        ("detect bag --out found", None),
        ("info a.burstcase", Some(1)),
        ("detect demo-tripod --out o --params a.toml", None),
        ("detect demo-tripod --out o --times times.csv", None),
        ("render --play a.toml --out a.png", Some(2)),
        ("render --play list.toml --timeout 60 --out a.png", None),
        ("detect demo-tripod --out taken --octaves 1 --quiet", Some(1)),
        ("detect demo-tripod --out out --octaves 1 --quiet", Some(0)),
        ("synth chart --out out/made --frames 2 --quiet", Some(0)),
    ] {
        let output = ended(home.start(command));
        assert!(code.is_none_or(|code| output.status.code() == Some(code)), "{command}: {}", stderr(&output));
        assert!(output.status.code().is_some_and(|code| code < 3), "{command}: {}", stderr(&output));
    }
}

#[test]
fn pictures_of_files_without_header_or_of_senseless_sizes_are_refused_with_the_reason() {
    let home = folder();
    home.write("x.raw", [7; 4096]);
    let expected = home.run_badly("detect x.raw --out o", 1);
    let words = expected.split("error: ").nth(1).and_then(|error| error.split_once(": ")).expect("an error").1;
    let output = ended(home.start("render x.raw --out r.png"));
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains(words.trim()) && words.contains("--raw"), "{}", stderr(&output));
    assert!(!home.join("r.png").exists());
    let home = folder();
    for size in ["", "1280", "0x0", "-5x9", "99999x99999"] {
        says(home.run_badly(&["render", "demo", "--out", "a.png", &format!("--size={size}")], 2), &["--size"]);
    }
    for scale in ["nan", "9"] {
        home.run_badly(&["render", "demo", "--out", "a.png", "--scale", scale], 2);
    }
    assert_eq!(names(&home), Vec::<String>::new());
}

#[cfg(unix)]
#[test]
fn names_are_one_word_for_a_shell_and_one_line_for_people() {
    let home = folder();
    let odd = "o'; touch pwned; '";
    for line in [false, true].into_iter().flat_map(|is_known| next_commands(&home.join(odd), is_known)) {
        // What the lines start is not here; that they say nothing else to the shell is.
        let stubs = "mkdir() { :; }; colmap() { :; }; python3() { :; }; ";
        let shell = Command::new("sh").current_dir(&home).args(["-c", &format!("{stubs}{line}")]).status();
        assert!(shell.expect("it runs").success(), "{line}");
    }
    assert_eq!(names(&home), Vec::<String>::new());
    let line = detect_line(&["-odd".to_owned(), odd.to_owned()], &SearchParams::default(), &OpenOptions::default());
    assert_eq!(line, format!("burstscope detect ./-odd {} --out features", shell_word(odd)));
    for text in [odd, "$(touch pwned)", "`x`", "a\nb", "it's\n100 % \\n", "-x", "", "~", "a b", "ü/1.png", "\"", "\\"]
    {
        let printed = |word: &str| {
            let output = Command::new("sh").args(["-c", &format!("printf '%s' {word}")]).output().expect("it runs");
            String::from_utf8(output.stdout).expect("text")
        };
        assert_eq!(printed(&shell_word(text)), text);
        assert!(!shell_word(text).contains('\n'));
        assert_eq!(printed(&shell_path(Path::new(text))), if text == "-x" { "./-x" } else { text });
    }
    for (start, tool) in [(&b"\x1f\x8b"[..], "gunzip"), (b"\x89HDF\r\n\x1a\n", "python3"), (b"ZISRAWFILE", "bfconvert")]
    {
        let name = format!("{odd}.x");
        fs::write(home.join(&name), [start, &[0; 64]].concat()).expect("written");
        says(home.run_badly(&["info", &name], 1), &[tool, &shell_word(&name)]);
        fs::remove_file(home.join(&name)).expect("removed");
    }
    // What a terminal reads as a command, and a line feed, are written out.
    let name = "a\u{1b}[31m\u{9b}2J\r.png";
    fs::write(home.join(name), "no picture").expect("written");
    let text = home.run_badly(&["info", name], 1);
    assert!(text.contains("a\\u{1b}[31m\\u{9b}2J\\u{d}.png") && !text.contains(['\u{1b}', '\u{9b}', '\r']), "{text}");
    let name = "a\nerror: all is lost.png";
    image::GrayImage::from_pixel(9, 9, image::Luma([9])).save(home.join("a.png")).expect("saved");
    fs::rename(home.join("a.png"), home.join(name)).expect("renamed");
    let text = home.run_well(&["info", name]);
    assert!(text.contains("a\\u{a}error") && !text.contains("\nerror"), "{text}");
    fs::write(home.join(name), "no picture").expect("written");
    let text = home.run_badly(&["info", name], 1);
    assert!(text.contains("a\\u{a}error") && !text.contains("\nerror"), "{text}");
}
