//! Tables of measurements, made from stored results.
//!
//! `docs/measurements/NAME.json` holds a table: the commands that measured it, its cells, and the values that they name
//! with the version, commit and detector revision of the program that gave them. In a document the table stands below
//! `<!-- measured NAME -->`, and its commands in a block above it. Here a test holds document and result equal, and
//! fails where a result, or a table without one, is of another revision and does not say so.
//!
//! `make measurements` writes the tables of the documents anew from the results. `BURSTSCOPE_MEASURE=NAME,…` (or
//! `all`) runs the commands first, which can take long, and stores what they give; inputs are found in the folder of
//! real frames.

use super::{house::documents::documents, shared::shared};
use crate::support::*;
use burstscope::detector::feature::REVISION;
use serde_json::{Map, json};

const DOCUMENTS: [&str; 2] = ["docs/MEASUREMENTS.md", "docs/PAPER.md"];
const MARK: &str = "<!-- measured ";
/// Words above a table, or in its paragraph, that tell what its numbers are of, where no stored result has them: these
/// marks, or of which revision they are.
const OTHER: [&str; 2] = ["<!-- not measured -->", "<!-- of the paper -->"];
const OF_REVISION: &str = "Of revision ";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn stored(name: &str) -> PathBuf {
    root().join(format!("docs/measurements/{name}.json"))
}

/// Parts of a cell between braces, `K/POINTER:FORMAT`: whole, the value's place in the JSON of the K-th command, and
/// the number of decimals, followed by `%` where a share is printed in hundredths. Without a format there is one
/// decimal.
fn named_values(cell: &str) -> impl Iterator<Item = (&str, &str, &str)> {
    cell.split('{').skip(1).filter_map(|part| part.split_once('}')).map(|(inside, _)| {
        let (place, format) = inside.rsplit_once(':').unwrap_or((inside, "1"));
        (inside, place, format)
    })
}

fn texts(list: &Value) -> impl Iterator<Item = &str> {
    list.as_array().expect("a list").iter().map(|text| text.as_str().expect("a text"))
}

/// A number, or a mean with its standard error, as it is printed; `–` where there is none.
fn printed(value: &Value, format: &str) -> String {
    let factor = if format.ends_with('%') { 100.0 } else { 1.0 };
    let decimals: usize = format.trim_end_matches('%').parse().expect("a number of decimals");
    let number = |value: &Value| value.as_f64().map(|n| format!("{:.decimals$}", n * factor).replace('-', "−"));
    let mean = value.get("mean").unwrap_or(value);
    match (number(mean), value.get("standard_error").and_then(number)) {
        (Some(mean), Some(error)) => format!("{mean} ± {error}"),
        (Some(mean), None) => mean,
        (None, _) => value.as_str().unwrap_or("–").to_owned(),
    }
}

/// The table in Markdown, with a line on its revision where that is not the program's.
fn table(result: &Value, revision: u32) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let columns: Vec<String> = texts(&result["columns"]).map(str::to_owned).collect();
    let mut text = line(columns.clone()) + &line(vec!["---".to_owned(); columns.len()]);
    for row in result["rows"].as_array().expect("rows") {
        let filled = |cell: &str| {
            let mut cell = cell.to_owned();
            for (inside, place, format) in named_values(&cell.clone()) {
                let value = result["values"].get(place).unwrap_or_else(|| panic!("{place} was not measured"));
                cell = cell.replace(&format!("{{{inside}}}"), &printed(value, format));
            }
            cell
        };
        text += &line(texts(row).map(filled).collect());
    }
    let of = &result["detector_revision"];
    if *of != json!(revision) {
        text += &format!("\n{OF_REVISION}{of} of the detector.\n");
    }
    text
}

/// Output of a command: its JSON, or of a table that it writes (`COMMAND > FILE.csv`) a list with an object a row.
fn output(home: &Path, command: &str) -> Value {
    let (command, file) = command.split_once(" > ").map_or((command, None), |(command, file)| (command, Some(file)));
    let mut words: Vec<&str> = command.split_whitespace().collect();
    let Some(file) = file else {
        words.extend(["--json", "--quiet"]);
        return home.run_json(&words);
    };
    home.run_well(&words);
    let text = fs::read_to_string(home.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let cell = |text: &str| text.parse::<f64>().map_or_else(|_| json!(text), |number| json!(number));
    let row = |line: &str| {
        let cells = header.iter().zip(line.split(','));
        Value::Object(cells.map(|(name, text)| ((*name).to_owned(), cell(text))).collect())
    };
    Value::Array(lines.map(row).collect())
}

fn measure(name: &str) {
    let mut result: Value = read(&stored(name));
    let home = folder();
    #[cfg(unix)]
    std::os::unix::fs::symlink(shared("data"), home.join("data")).expect("linked");
    let outputs: Vec<Value> = texts(&result["commands"]).map(|command| output(&home, command)).collect();
    let mut values = Map::new();
    let cells = result["rows"].as_array().expect("rows").iter().flat_map(texts);
    for (_, place, _) in cells.flat_map(named_values) {
        let (number, pointer) = place.split_once('/').expect("a place in an output");
        let of = &outputs[number.parse::<usize>().expect("number of a command")];
        let value = of.pointer(&format!("/{pointer}")).unwrap_or_else(|| panic!("{name}: no {place}"));
        values.insert(place.to_owned(), value.clone());
    }
    let git = Command::new("git").current_dir(root()).args(["describe", "--always", "--dirty", "--abbrev=12"]).output();
    result["version"] = json!(env!("CARGO_PKG_VERSION"));
    result["commit"] = json!(String::from_utf8_lossy(&git.expect("git").stdout).trim());
    result["detector_revision"] = json!(REVISION);
    result["values"] = Value::Object(values);
    fs::write(stored(name), serde_json::to_string_pretty(&result).expect("JSON") + "\n").expect("written");
}

fn read(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The document with the tables of its stored results, and the names of these.
fn with_tables(text: &str, of: impl Fn(&str) -> String) -> (String, Vec<String>) {
    let (mut made, mut rest, mut names) = (String::new(), text, Vec::new());
    while let Some((before, after)) = rest.split_once(MARK) {
        let (name, after) = after.split_once(" -->\n").expect("an end of the mark");
        // The table ends with its last line, or with the line on its revision.
        let is_table = |line: &&str| line.starts_with('|');
        let mut length: usize = after.split_inclusive('\n').take_while(is_table).map(str::len).sum();
        let line = after[length..].strip_prefix('\n').and_then(|rest| rest.split_inclusive('\n').next());
        length += line.filter(|line| revision_of(line).is_some()).map_or(0, |line| 1 + line.len());
        made += &format!("{before}{MARK}{name} -->\n{}", of(name));
        names.push(name.to_owned());
        rest = &after[length..];
    }
    (made + rest, names)
}

/// The revision of a line `Of revision N of the detector.`
fn revision_of(line: &str) -> Option<u32> {
    line.trim_end().strip_prefix(OF_REVISION)?.strip_suffix(" of the detector.")?.parse().ok()
}

/// Blocks with a table that neither stands below a mark nor says in it, or right above it, what it is of: a revision of
/// the detector that there has been, or no measurement of it.
fn unsourced(text: &str) -> Vec<&str> {
    let blocks: Vec<&str> = text.split("\n\n").collect();
    let says = |block: &&str| {
        let is_known = |line| revision_of(line).is_some_and(|revision| revision <= REVISION);
        OTHER.iter().any(|words| block.contains(words)) || block.lines().any(is_known)
    };
    let is_rule = |line: &str| {
        let cells = line.trim().strip_prefix('|').and_then(|line| line.strip_suffix('|'));
        cells.is_some_and(|cells| {
            cells
                .split('|')
                .all(|cell| cell.contains('-') && cell.trim().trim_matches(':').trim_matches('-').is_empty())
        })
    };
    let is_table = |block: &str| block.lines().any(is_rule);
    let has_source = |k: usize| blocks[k].contains(MARK) || says(&blocks[k]) || k > 0 && says(&blocks[k - 1]);
    (0..blocks.len()).filter(|k| is_table(blocks[*k]) && !has_source(*k)).map(|k| blocks[k]).collect()
}

#[test]
fn tables_of_measurements_are_those_of_stored_results() {
    let asked = std::env::var("BURSTSCOPE_MEASURE").unwrap_or_default();
    let mut used = Vec::new();
    for (path, text) in documents().into_iter().filter(|(path, _)| DOCUMENTS.iter().any(|name| path.ends_with(name))) {
        let (_, names) = with_tables(&text, |_| String::new());
        names
            .iter()
            .filter(|name| asked == "all" || asked.split(',').any(|a| a == *name))
            .for_each(|name| measure(name));
        let (made, names) = with_tables(&text, |name| table(&read(&stored(name)), REVISION));
        if std::env::var_os("BURSTSCOPE_UPDATE_DOCS").is_some() {
            fs::write(&path, &made).expect("written");
        } else {
            let name = path.display();
            assert!(made == text, "{name} has other tables than docs/measurements; `make measurements` writes them");
            assert_eq!(
                unsourced(&text),
                Vec::<&str>::new(),
                "{name}: these tables do not say of which revision they are"
            );
        }
        for name in &names {
            for command in texts(&read(&stored(name))["commands"]) {
                let command = command.split_once(" > ").map_or(command, |(command, _)| command);
                let shown = format!("burstscope {command}");
                assert!(text.contains(&shown), "{}: `{shown}`, which measured {name}, is not shown", path.display());
            }
        }
        used.extend(names);
    }
    let files = fs::read_dir(root().join("docs/measurements")).expect("results").map(|entry| entry.expect("a file"));
    let mut there: Vec<String> =
        files.map(|file| file.path().file_stem().expect("a name").to_string_lossy().into_owned()).collect();
    there.sort();
    used.sort();
    assert_eq!(used, there, "each stored result has one table");
}

#[test]
fn a_table_has_the_values_of_its_result_and_says_of_which_revision_it_is() {
    let result = json!({
        "commands": ["x"], "columns": ["a", "b"], "rows": [["1D", "{0/x}; {0/y:2}"], ["{0/z}", "{0/x:0%} %"]],
        "detector_revision": 3, "values": {"0/x": {"mean": 2.04, "standard_error": 0.26}, "0/y": -1, "0/z": null},
    });
    let lines = "| a | b |\n| --- | --- |\n| 1D | 2.0 ± 0.3; −1.00 |\n| – | 204 ± 26 % |\n";
    assert_eq!(table(&result, 3), lines);
    let old = format!("{lines}\nOf revision 3 of the detector.\n");
    assert_eq!(table(&result, 4), old);
    let document = |table: &str| format!("A\n\n<!-- measured n -->\n{table}\nB\n");
    for (before, now) in [(lines, lines), (&old, lines), (lines, &old), ("", &old)] {
        assert_eq!(with_tables(&document(before), |_| now.to_owned()), (document(now), vec!["n".to_owned()]));
    }
    let without = "Words.\n\n| a |\n| --- |\n| 1 |\n\nWords.";
    assert_eq!(unsourced(without).len(), 1);
    let of = |revision: &str| format!("Of {revision} of the detector.");
    assert_eq!(unsourced(&without.replacen("Words.", &of("revision 3"), 1)).len(), 0);
    // A revision that is not named or is none, words below the table, and those above another block are none of it.
    for words in [of("an earlier revision"), of(&format!("revision {}", REVISION + 1)), of("revision 3") + "\n\nWords."]
    {
        assert_eq!(unsourced(&without.replacen("Words.", &words, 1)).len(), 1, "{words}");
    }
    assert_eq!(unsourced(&(without.to_owned() + "\n\n" + &of("revision 3"))).len(), 1);
    assert_eq!(unsourced(&without.replace("---", ":--:")).len(), 1);
    assert_eq!(unsourced(&document(lines)).len(), 0);
}
