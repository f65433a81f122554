//! Opened files are never written to, and files of others are replaced only with `--force`.

use crate::support::*;

const SMALL: [&str; 3] = ["--size", "640x480", "--no-detect"];

/// Checks that the command is refused with this word, with and without `--force`, before it begins, and changes
/// nothing.
fn refused_always(home: &Path, arguments: &[&str], word: &str) {
    let before = contents(home);
    for more in [&[][..], &["--force"]] {
        says(home.run_badly(&[arguments, more].concat(), 1), &[word]);
    }
    assert!(contents(home) == before, "{arguments:?} changed something");
}

#[test]
fn no_command_writes_over_what_it_opens() {
    let home = home_with(&["pb"]);
    let at = |name: &str| home.join(name);
    // Frames with the names of outputs.
    home.make_dir("tb");
    for t in 0..4 {
        let frame = image::open(at(&format!("pb/frame_00{t}.png"))).expect("a frame");
        frame.save(at(&format!("tb/f{t}.tiff"))).expect("written");
    }
    fs::hard_link(at("tb/f1.tiff"), at("other_name.tiff")).expect("linked");
    std::os::unix::fs::symlink(at("tb"), at("also_tb")).expect("linked");
    fs::copy(at("tb/f0.tiff"), at("bias.tiff")).expect("copied");
    home.run_well("stack tb --slope 0,0 --out ours.tiff");
    let opened = "files that were opened are never written to";
    for out in ["tb/f0.tiff", "./tb/../tb/f3.tiff", "also_tb/f2.tiff", "other_name.tiff"] {
        refused_always(&home, &["stack", "tb", "--slope", "0,0", "--out", out], opened);
        refused_always(&home, &["merge", "tb", "--out", out], opened);
    }
    let folder = ["stack", "tb", "--slope", "0,0", "--out", "folder.tiff"];
    home.make_dir("folder.tiff");
    refused_always(&home, &folder, "this is a folder or a device, not a file");
    std::os::unix::fs::symlink(at("tb/f0.tiff"), at("to_f0.tiff")).expect("linked");
    for out in ["to_f0.tiff", "tb/f0.tiff"] {
        refused_always(&home, &["merge", "to_f0.tiff", "tb/f1.tiff", "--out", out], opened);
    }
    refused_always(&home, &["merge", "tb/f0.tiff", "tb/f1.tiff", "--out", "tb/f1.tiff"], opened);
    refused_always(&home, &["stack", "ours.tiff", "--slope", "0,0", "--out", "ours.tiff"], opened);
    refused_always(&home, &["merge", "tb", "--bias", "bias.tiff", "--out", "bias.tiff"], opened);
    refused_always(&home, &["merge", "tb", "--flat", "tb", "--out", "tb/f3.tiff"], opened);
    let render = |input: &'static str, out: &'static str| [&["render", input, "--out", out][..], &SMALL].concat();
    refused_always(&home, &render("pb", "pb/frame_000.png"), opened);
    refused_always(&home, &[&render("pb", "bias.tiff")[..], &["--bias", "bias.tiff"]].concat(), opened);
    // Parameters and sessions are opened too, whatever their names are.
    home.write("p.tiff", "levels = 4\n");
    home.write("p.svg", "levels = 4\n");
    refused_always(&home, &["stack", "tb", "--slope", "0,0", "--params", "p.tiff", "--out", "p.tiff"], opened);
    for command in [&["probe", "tb", "--at", "40,40"][..], &["slopes", "tb"], &["evaluate", "frames", "tb"]] {
        refused_always(&home, &[command, &["--params", "p.svg", "--plot", "p.svg"]].concat(), opened);
    }
    refused_always(&home, &["evaluate", "chart", "--params", "p.svg", "--plot", "p.svg"], opened);
    let session = format!("version = 4\nburst = {{ paths = [{:?}] }}\n", at("pb"));
    home.write("night.toml", session);
    refused_always(&home, &render("night.toml", "night.toml"), opened);
    // The files of a session are known once it is open; a frame that Burstscope did not write is refused before.
    let over = render("night.toml", "pb/frame_001.png");
    let before = contents(&home);
    home.run_badly(&over, 1);
    let words = home.run_badly(&[&over[..], &["--force"]].concat(), 1);
    assert!(words.contains(opened) && contents(&home) == before, "{words}");
    // A frame whose name ends in .svg; nothing is opened by its name.
    fs::rename(at("pb/frame_000.png"), at("frame.svg")).expect("renamed");
    for command in [&["probe", "--at", "40,40"][..], &["slopes"]] {
        let frames = ["frame.svg", "pb/frame_001.png", "pb/frame_002.png", "--plot", "frame.svg"];
        refused_always(&home, &[command, &frames].concat(), opened);
    }
}

#[test]
fn a_folder_of_features_keeps_what_others_wrote_there() {
    let home = home_with(&["nights/c0", "nights/c1"]);
    let at = |name: &str| home.join(name);
    home.make_dir("out");
    home.write("out/c1.csv", "name,street\nAda,Main 1\n");
    home.write("out/notes.txt", "about the nights");
    let detect = [&["detect", "nights", "--out", "out", "--format", "csv,colmap,npz"][..], &SEARCH].concat();
    let before = contents(&home);
    let words = home.run_badly(&detect, 1);
    assert!(words.contains("Burstscope did not write this file") && words.contains("out/c1.csv"), "{words}");
    assert!(words.contains("--force") && contents(&home) == before, "nothing is begun");
    home.run_well(&[&detect[..], &["--force"]].concat());
    assert_eq!(names(&at("out")), ["c0.csv", "c0.npz", "c0.txt", "c1.csv", "c1.npz", "c1.txt", "notes.txt"]);
    assert_eq!(home.text("out/notes.txt"), "about the nights");
    // The command may replace its own files when run again, and others may write there too.
    home.run_well(&detect);
    let matching = [&["match", "nights/c0", "nights/c1", "--out", "out"][..], &SEARCH].concat();
    home.run_well(&matching);
    home.run_well(&matching);
    for name in ["c0_c1.matches.csv", "c0_c1.matches.png"] {
        fs::write(at("out").join(name), "mine").expect("written");
        says(home.run_badly(&matching, 1), &[name, "did not write"]);
        fs::remove_file(at("out").join(name)).expect("removed");
    }
    home.make_dir("flat");
    for t in 0..3 {
        fs::copy(at(&format!("nights/c0/frame_00{t}.png")), at(&format!("flat/{t}.png"))).expect("copied");
    }
    home.run_well(&[&["detect", "flat", "--out", "flat"][..], &SEARCH].concat());
    assert_eq!(names(&at("flat")), ["0.png", "1.png", "2.png", "flat.csv"]);
}

#[test]
fn one_file_is_replaced_if_burstscope_wrote_it() {
    let home = home_with(&["a"]);
    let at = |name: &str| home.join(name);
    let render = [&["render", "a", "--out", "x.png"][..], &SMALL].concat();
    let small = ["--seeds", "1", "--snr", "2", "--methods", "sift-frame", "--width", "96", "--height", "72"];
    let chart_plot =
        [&["evaluate", "chart", "--plot", "c.svg", "--discs", "3", "--radius", "3:6"][..], &small].concat();
    for (command, file) in [
        (&["stack", "a", "--slope", "0,0", "--out", "x.tiff"][..], "x.tiff"),
        (&["stack", "a", "--slope", "0,0", "--octave", "0", "--level", "1", "--out", "y.tif"], "y.tif"),
        (&["merge", "a", "--out", "z.tiff"], "z.tiff"),
        (&["probe", "a", "--at", "40,40", "--octaves", "2", "--plot", "p.svg"], "p.svg"),
        (&["slopes", "a", "--octaves", "2", "--plot", "s.svg"], "s.svg"),
        (&["evaluate", "frames", "a", "--octaves", "2", "--plot", "f.svg"], "f.svg"),
        (&chart_plot, "c.svg"),
        (&render, "x.png"),
    ] {
        home.run_well(command);
        home.run_well(command);
        fs::write(at(file), "").expect("emptied");
        home.run_well(command);
        fs::write(at(file), "somebody's").expect("written");
        says(home.run_badly(command, 1), &["did not write", file, "--force"]);
        assert_eq!(fs::read_to_string(at(file)).expect("there"), "somebody's");
        home.run_well(&[command, &["--force"]].concat());
        assert!(fs::metadata(at(file)).expect("there").len() > 100, "{file}");
    }
    home.write("burstscope-a.png", "somebody's");
    says(home.run_badly("a", 1), &["burstscope-a.png", "render --out"]);
    assert_eq!(home.text("burstscope-a.png"), "somebody's");
}

#[test]
fn links_are_not_followed_and_noisy_copies_do_not_replace_their_originals() {
    let home = home_with(&["a"]);
    let at = |name: &str| home.join(name);
    let link = |target: &str, name: &str| std::os::unix::fs::symlink(at(target), at(name)).expect("linked");
    home.run_well("stack a --slope 0,0 --out ours.tiff");
    home.write("thesis.tiff", "precious");
    home.make_dir("out");
    for (target, name) in [("thesis.tiff", "l1.tiff"), ("ours.tiff", "l2.tiff"), ("nowhere", "l3.tiff")] {
        link(target, name);
        let before = contents(&home);
        let stack = ["stack", "a", "--slope", "1,0", "--out", name];
        says(home.run_badly(&stack, 1), &["links are not followed", name]);
        assert!(contents(&home) == before);
        home.run_well(&[&stack[..], &["--force"]].concat());
        assert!(!fs::symlink_metadata(at(name)).expect("there").is_symlink(), "the link itself is replaced");
        let now = contents(&home);
        assert!(before.iter().filter(|(file, _)| file != name).all(|old| now.contains(old)), "{target} is as it was");
    }
    assert!(!at("nowhere").exists());
    link("thesis.tiff", "out/a.csv");
    let detect = [&["detect", "a", "--out", "out"][..], &SEARCH].concat();
    assert!(home.run_badly(&detect, 1).contains("out/a.csv"));
    home.run_well(&[&detect[..], &["--force"]].concat());
    assert_eq!(home.text("thesis.tiff"), "precious");
    // A link to a folder is followed, for files that go into it; a folder that is replaced as a whole must be named
    // itself.
    home.make_dir("elsewhere");
    link("elsewhere", "there");
    home.run_well(&[&["detect", "a", "--out", "there"][..], &SEARCH].concat());
    assert_eq!(names(&at("elsewhere")), ["a.csv"]);
    says(home.run_badly("synth chart --out there", 1), &["links are not followed"]);
    for out in ["/dev/stdout", "/dev/null"] {
        let output = home.run(&["render", "a", "--out", out, "--no-detect", "--force"]);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{}", stderr(&output));
    }
    let home = home_with(&["a"]);
    home.run_well("synth noisy a --out copies");
    home.run_well("synth noisy a --out copies");
    let before = contents(&home);
    for out in ["copies", "."] {
        let words = home.run_badly(&["synth", "noisy", "copies", "--out", out], 1);
        assert!(words.contains("files that were opened are never written to"), "{words}");
    }
    assert!(contents(&home) == before);
}

#[cfg(feature = "colmap")]
#[test]
fn a_dataset_does_not_write_over_its_frames_or_into_other_folders() {
    let home = home_with(&["nights/a", "nights/b"]);
    let colmap = |inputs: &str| format!("colmap {inputs} --out rec {}", SEARCH.join(" "));
    home.run_well(&colmap("nights"));
    // Pictures of the dataset, given as bursts of the same names, one frame each.
    let before = contents(&home);
    let one_frame = colmap("rec/images/a.png nights/b");
    says(home.run_badly(&one_frame, 1), &["files that were opened are never written to"]);
    assert!(contents(&home) == before);
    // A link among its files, and a folder with a user's own file.
    fs::remove_file(home.join("rec/database.db")).expect("removed");
    home.write("precious.db", "precious");
    std::os::unix::fs::symlink(home.join("precious.db"), home.join("rec/database.db")).expect("linked");
    says(home.run_badly(&colmap("nights"), 1), &["links are not followed"]);
    assert_eq!(home.text("precious.db"), "precious");
    for command in
        [&["colmap", "nights", "--out", "nights"][..], &["figures", "--out", "nights"], &["figures", "--out", "rec"]]
    {
        says(home.run_badly(command, 1), &["this folder holds files"]);
    }
}

#[test]
fn two_processes_do_not_write_into_one_folder() {
    let home = home_with(&["a", "b"]);
    let out = home.join("out");
    fs::create_dir(&out).expect("made");
    let locked = |path: PathBuf| {
        fs::write(&path, "process 4711 on lighthouse\n").expect("written");
        let file = fs::OpenOptions::new().read(true).write(true).open(path).expect("opened");
        file.try_lock().expect("free");
        file
    };
    let file = locked(out.join(".burstscope-lock"));
    let detect = [&["detect", "a", "--out", "out"][..], &SEARCH].concat();
    let matching = [&["match", "a", "b", "--out", "out"][..], &SEARCH].concat();
    let mut commands = vec![&detect[..], &matching, &["figures", "--out", "out", "--only", "fig9", "--quick"]];
    commands.extend(cfg!(feature = "colmap").then_some(&["colmap", "a", "b", "--out", "out"][..]));
    for command in commands {
        says(home.run_badly(command, 1), &["process 4711 on lighthouse writes into this folder"]);
    }
    assert_eq!(names(&out), [".burstscope-lock"], "nothing was begun");
    drop(file);
    home.run_well(&matching);
    assert_eq!(names(&out), ["a.csv", "a_b.matches.csv", "a_b.matches.png", "b.csv"], "the lock is not left");
    let file = locked(home.join(".burstscope-a.lock"));
    says(home.run_badly("synth chart --out a", 1), &["process 4711 on lighthouse writes into this folder"]);
    chart(&home, "c");
    drop(file);
    chart(&home, "a");
    assert_eq!(names(&home), ["a", "b", "c", "out"]);
    // Leftovers of killed runs do not make a folder a user's own.
    for command in
        [&["figures", "--out", "left", "--only", "fig9", "--quick"][..], &["synth", "chart", "--out", "left2"]]
    {
        let left = home.join(command[command.iter().position(|word| *word == "--out").expect("there") + 1]);
        fs::create_dir(&left).expect("made");
        fs::write(left.join(".burstscope-lock"), "process 4711\n").expect("written");
        leave_unfinished(&left);
        home.run_well(command);
    }
}

/// Of two runs at once one is refused, and the result is that of one of them.
#[test]
fn of_two_runs_into_one_folder_one_is_refused() {
    let home = home_with(&["a"]);
    let arguments = |edge: &'static str| {
        [&["detect", "a", "--out", "out", "--format", "csv,colmap,npz", "--edge-threshold", edge][..], &SEARCH].concat()
    };
    let made = ["5", "12"].map(|edge| {
        home.run_well(&arguments(edge));
        let made = contents(&home.join("out"));
        fs::remove_dir_all(home.join("out")).expect("removed");
        made
    });
    assert!(made[0] != made[1]);
    for round in 0..6 {
        let (first, second) = (home.start(&arguments("5")), home.start(&arguments("12")));
        let outputs = [first, second].map(|child| child.wait_with_output().expect("an end"));
        let codes = outputs.each_ref().map(|output| output.status.code());
        // The later one may have begun after the earlier one had ended.
        for output in outputs.iter().filter(|output| output.status.code() != Some(0)) {
            assert!(stderr(output).contains("writes into this folder"), "{}", stderr(output));
        }
        assert!(codes.contains(&Some(0)), "round {round}: {codes:?}");
        assert!(made.contains(&contents(&home.join("out"))), "round {round}: a mixture");
        fs::remove_dir_all(home.join("out")).expect("removed");
    }
}

#[test]
fn a_folder_that_is_removed_while_it_is_written_is_an_error() {
    let home = home_with(&["nights/a", "nights/b", "nights/c"]);
    // So many slopes that there is time to remove the folder.
    let search = ["--slopes-u", "-3:3:41", "--slopes-v", "-3:3:41", "--threads", "1"];
    let out = home.join("out");
    let mut commands = vec![(&["detect", "nights", "--out", "out"][..], "a.csv")];
    if cfg!(feature = "colmap") {
        commands.push((&["colmap", "nights", "--out", "out"], "records/a.png.json"));
    }
    for (command, first) in commands {
        let mut running = home.start(&[command, &search].concat());
        let end = Instant::now() + Duration::from_secs(300);
        while !out.join(first).exists() {
            assert!(Instant::now() < end, "{command:?} came to no file");
            assert!(running.try_wait().expect("a state").is_none(), "{command:?} came to no file");
            std::thread::sleep(Duration::from_millis(5));
        }
        fs::remove_dir_all(&out).expect("removed");
        let output = running.wait_with_output().expect("an end");
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains("this folder was removed while it was being written"), "{}", stderr(&output));
        assert!(!out.exists(), "{command:?} made it anew with a part of the files");
    }
}
