//! `report`: a burst on one page.

use crate::support::*;

/// A value without what depends on how long the work took.
fn timeless(mut value: Value) -> Value {
    if let Some(cost) = value.pointer_mut("/cost/search_secs") {
        *cost = Value::Null;
    }
    value
}

const LINE: [&str; 3] = ["demo", "--slopes-u", "-3:3:13"];

#[test]
fn a_report_says_what_the_other_commands_say() {
    let home = folder();
    let ask = |arguments: &[&str]| home.run_json(&[arguments, &LINE[..], &["--json"]].concat());
    let page = &ask(&["report", "--out", "r.md", "--at", "92,58", "--at", "12,34", "--copies", "2"]);
    let detected = &ask(&["detect", "--out", "found"])["bursts"][0];
    assert_eq!((&page["features"], &page["tally"]), (&detected["features"], &detected["tally"]));
    ["frame_noise", "noise_gate_factor"].into_iter().for_each(|key| assert_eq!(page[key], detected[key], "{key}"));
    assert_eq!(timeless(page["spectrum"].clone()), timeless(ask(&["slopes"])["spectrum"].clone()));
    assert_eq!(page["decoys"], ask(&["decoys", "--copies", "2"])["decoys"]);
    assert_eq!(page["places"].as_array().map(Vec::len), Some(2));
    for (index, place) in ["92,58", "12,34"].into_iter().enumerate() {
        assert_eq!(page["places"][index], ask(&["probe", "--at", place])["probe"], "{place}");
    }
    let text = home.text("r.md");
    let features = page["features"].as_u64().expect("a count");
    let copies = page["decoys"]["rates"][0]["in_copies"].as_array().expect("counts");
    let false_ones = copies.iter().filter_map(Value::as_f64).sum::<f64>() / copies.len() as f64;
    let told = format!("about {false_ones:.0} of {features} features are expected of noise");
    let samples = page["tally"]["rejected"]["noise_gate"].as_u64().expect("a count").to_string();
    says(
        text.chars().filter(|letter| *letter != ' ').collect::<String>(),
        &[&told.replace(' ', ""), &format!("|{samples}|belowthenoisegate")],
    );
    assert!(text.contains("## Place 1 at (92, 58)") && text.contains("## Place 2 at (12, 34)"), "{text}");
    assert!(
        text.contains(page["spectrum"]["judgement"]["sentence"].as_str().expect("words").get(1..30).expect("long"))
    );
}

#[test]
fn a_report_is_drawn_with_the_burst_on_top_and_replaces_only_its_own_files() {
    let home = folder();
    let at = ["--at", "92,58", "--at", "the mast=12,34"];
    let line = |out: &'static str| [&["report", "--out", out, "--quiet"], &at[..], &LINE[..]].concat();
    for out in ["r.md", "r.html", "r.svg", "r.pdf", "r.png"] {
        (0..2).for_each(|_| assert_eq!(home.run_well(&line(out)), ""));
        fs::write(home.join(out), "mine").expect("written");
        assert!(home.run_badly(&line(out), 1).contains("--force"), "{out}");
        home.run_well(&[&line(out)[..], &["--force"]].concat());
    }
    let svg = home.text("r.svg");
    let document = roxmltree::Document::parse(&svg).expect("valid XML");
    let count = |tag: &str| document.descendants().filter(|node| node.has_tag_name(tag)).count();
    let features = home.run_json(&[&["report", "--out", "r.svg", "--json"], &LINE[..]].concat())["features"].clone();
    assert_eq!((count("image"), Some(count("circle") as u64)), (1, features.as_u64()));
    assert!(svg.contains("Place 1 at (92, 58)") && svg.contains("below the noise gate"));
    let texts = || document.descendants().filter(|node| node.has_tag_name("text"));
    for (name, heading) in [("1", "Place 1 at (92, 58)"), ("the mast", "the mast at (12, 34)")] {
        let is_there = |words: &str| texts().any(|text| text.text() == Some(words));
        assert!(is_there(name) && is_there(heading), "{name} is in the picture, and {heading} below it");
    }
    let lowest = texts().filter_map(|text| text.attribute("y")?.parse::<f64>().ok()).fold(0.0, f64::max);
    let height =
        document.root_element().attribute("viewBox").and_then(|view| view.rsplit(' ').next()?.parse::<f64>().ok());
    assert!(height.is_some_and(|height| (100.0..height - 20.0).contains(&lowest)), "{lowest} of {height:?}");
    assert!(fs::read(home.join("r.pdf")).expect("a file").starts_with(b"%PDF"));
}

#[test]
fn what_cannot_be_reported_is_refused_and_nothing_is_written_and_names_have_no_marks_of_markdown() {
    let home = folder();
    for (line, code, words) in [
        ("report demo --out r.docx", 2, "name the report .md, .html, .svg, .pdf or .png"),
        ("report demo", 2, "--out"),
        ("report gone --out r.md", 1, "gone"),
        ("report demo --out r.md --at 900,5", 2, "is outside the"),
        ("report demo --out r.md --at 5", 2, "is not U,V in pixels"),
        ("report demo --out r.md --at mast=5", 2, "'5' is not U,V in pixels"),
        ("report demo --out r.md --copies 0", 2, "--copies: 0; give 1 to 100"),
        ("report demo demo-later --out r.svg", 2, "name the report of several bursts .md, .html or .csv"),
        ("report demo demo-later --out r.md --at 5,5", 2, "--at: a place is one of one burst"),
    ] {
        says(home.run_badly(line, code), &[words]);
    }
    assert_eq!(names(&home), [""; 0]);
    // Three frames have no other orders: the rest is told.
    let few = "report demo --frames 0..3 --out few.md --json";
    let page = &home.run_json(few);
    assert!(page["decoys"].is_null(), "{page}");
    assert!(page["no_decoys"].as_str().is_some_and(|why| why.contains("4 or more")), "{page}");
    let home = folder();
    let small = ["--width", "120", "--height", "90", "--discs", "2", "--frames", "5", "--max-slope", "1", "--quiet"];
    home.run_well(&[&["synth", "chart", "--out", "a_b*c*"], &small[..]].concat());
    let line = |out: &'static str| ["report", "a_b*c*", "--slopes-u", "-1:1:3", "--quiet", "--out", out];
    home.run_well(&line("r.md"));
    home.run_well(&line("r.svg"));
    let read = |name: &str| fs::read_to_string(home.join(name)).expect("text");
    assert!(read("r.md").contains(r"# a\_b\*c\*: 5 frames"), "{}", read("r.md"));
    assert!(read("r.svg").contains(">a_b*c*: 5 frames"));
}

#[test]
fn a_report_of_a_flight_has_a_row_for_each_burst_and_begins_with_the_worst() {
    let home = folder();
    let home = &*home;
    for (name, slope, seed) in [("n 1", "1.5", "1"), ("n2", "1.5", "2"), ("fast", "5", "3")] {
        let out = format!("nights/{name}");
        let scene = ["--width", "160", "--height", "120", "--frames", "6", "--snr", "8", "--max-slope", slope];
        home.run_well(&[&["synth", "scene", "--out", &out, "--seed", seed], &scene[..]].concat());
    }
    home.make_dir("nights/gone");
    home.write("nights/gone/f0.png", "broken");
    let ask = |arguments: &[&str]| {
        let output = home.run(&[arguments, &["nights", "--slopes-u", "-2:2:9", "--json"]].concat());
        assert_eq!(output.status.code(), Some(1), "one burst fails");
        assert!(stderr(&output).contains("error: gone: "), "{}", stderr(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("JSON")
    };
    let flight = ask(&["report", "--out", "flight.md"]);
    let detected = ask(&["detect", "--out", "found"]);
    let rows = flight["bursts"].as_array().expect("rows");
    let names: Vec<&str> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!(names, ["fast", "gone", "n 1", "n2"]);
    let health: Vec<&Value> = rows.iter().map(|row| &row["health"]).filter(|health| !health.is_null()).collect();
    for (health, alone) in health.into_iter().zip(detected["bursts"].as_array().expect("bursts")) {
        for key in ["frames", "features", "slopes_judged"] {
            assert_eq!(health[key], alone[key], "{key}");
        }
        assert!(health["motion"].as_f64().is_some_and(|motion| (0.1..2.5).contains(&motion)), "{health}");
    }
    let worst: Vec<&str> =
        flight["worst"].as_array().expect("a list").iter().filter_map(|one| one["name"].as_str()).collect();
    assert_eq!(worst[..2], ["gone", "fast"], "{flight}");
    let page = home.text("flight.md");
    let [first, second] = ["- gone: ", "- fast: "].map(|words| page.find(words).expect("named"));
    assert!(first < second && page[second..].contains(": try --slopes-u "), "{page}");
    says(&page, &["\n      burstscope nights/fast\n", "| n 1 | 6 | 160 | 120 | 0.0"]);
    assert_eq!(flight["bursts"][2]["open"], "burstscope 'nights/n 1'");
    (0..2).for_each(|_| drop(ask(&["report", "--out", "flight.csv"])));
    let table = home.text("flight.csv");
    assert_eq!(table.lines().count(), 5, "{table}");
    let cut = ["report", "nights/n2", "--burst-length", "3", "--slopes-u", "-2:2:5", "--out", "cut.md"];
    assert!(home.run_well(&cut).ends_with("wrote cut.md\n"));
    assert!(fs::read_to_string(home.join("cut.md")).is_ok_and(|page| page.contains("# 2 bursts\n")));
}

#[test]
fn a_page_of_html_says_what_the_page_of_markdown_says_and_needs_no_other_file() {
    let home = folder();
    let home = &*home;
    let small = ["--width", "120", "--height", "90", "--discs", "2", "--frames", "5", "--max-slope", "1", "--quiet"];
    for (name, seed) in [("a<b & \"c\"", "1"), ("it's &amp;", "2")] {
        let out = format!("nights/{name}");
        home.run_well(&[&["synth", "chart", "--out", &out, "--seed", seed], &small[..]].concat());
    }
    let broken = "<script> & \"co\"";
    fs::create_dir(home.join("nights").join(broken)).expect("a folder");
    fs::write(home.join("nights").join(broken).join("f0.png"), "broken").expect("written");
    for (input, out, code) in [("nights", "flight", 1), ("nights/a<b & \"c\"", "one", 0)] {
        let read = |ending: &str| {
            let out = format!("{out}.{ending}");
            let line = ["report", input, "--slopes-u", "-1:1:3", "--copies", "1", "--quiet", "--out", &out];
            assert_eq!(home.run(&line).status.code(), Some(code), "{out}");
            fs::read_to_string(home.join(&out)).expect("a page")
        };
        let (markdown, html) = (read("md").replace('\\', ""), read("html"));
        let (kind, page) = html.split_once('\n').expect("lines");
        assert_eq!(kind, "<!DOCTYPE html>");
        let page = roxmltree::Document::parse(page).expect("valid XML");
        let texts: Vec<(&str, &str)> =
            page.descendants().filter_map(|node| Some((node.tag_name().name(), node.text()?.trim()))).collect();
        let all = |tag: &str| texts.iter().filter(|text| text.0 == tag).map(|text| text.1).collect::<Vec<_>>();
        for text in ["h1", "h2", "p", "li", "pre", "th", "td"].into_iter().flat_map(all) {
            assert!(markdown.contains(&text.replace('\\', "")), "{text:?} is not in {markdown}");
        }
        assert_eq!(all("h2").len(), markdown.matches("\n## ").count());
        assert_eq!(page.descendants().filter(|node| node.has_tag_name("li")).count(), markdown.matches("\n- ").count());
        for word in ["<script", "<link", "<img", "src=", "href=", "url("] {
            assert!(!html.contains(word), "{word} in {html}");
        }
        if code == 1 {
            assert!(all("li")[0].starts_with(&format!("{broken}: ")), "{html}");
            let line = all("pre")[0];
            assert!(line.starts_with("burstscope ") && line.contains(&format!("nights/{broken}")), "{line}");
        }
    }
}
