//! `figures`: every figure and table of the paper.

use crate::support::*;

const ALL: [&str; 12] =
    ["fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "table1", "table2", "table3"];

/// Checks that a picture is valid and readable alone, and that its table's rows are as long as its head.
fn assert_whole(folder: &Path, name: &str) {
    let text = fs::read_to_string(folder.join(format!("{name}.svg"))).expect("a picture");
    let document = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(document.root_element().has_tag_name("svg"), "{name}");
    // Embedded pictures are random letters.
    let numbers = text.split("data:image/png;base64,").enumerate().map(|(part, text)| match part {
        0 => text,
        _ => text.split_once('"').map_or("", |(_, after)| after),
    });
    assert!(numbers.into_iter().all(|text| !text.contains("NaN")), "{name}");
    let mut ids: Vec<&str> = document.descendants().filter_map(|node| node.attribute("id")).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "{name}: names of one document are given once");
    for image in document.descendants().filter(|node| node.has_tag_name("image")) {
        let href = image.attribute(("http://www.w3.org/1999/xlink", "href")).expect("a picture in it");
        assert!(href.starts_with("data:image/png;base64,"), "{name} needs another file");
    }
    let csv = fs::read_to_string(folder.join(format!("{name}.csv"))).expect("numbers");
    // Commas within quotes part nothing.
    let parts = |line: &str| 1 + line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>();
    let columns: Vec<usize> = csv.lines().map(parts).collect();
    assert!(columns.len() > 1 && columns[0] > 2, "{name}: {csv}");
    assert!(columns.iter().all(|&count| count == columns[0]), "{name}: rows are as long as the head");
}

fn figures(report: &Value) -> Vec<(&str, bool)> {
    let all = report["figures"].as_array().expect("figures").iter();
    all.map(|f| (f["figure"].as_str().expect("a name"), f["resumed"].as_bool().expect("a word"))).collect()
}

#[test]
fn all_figures_are_made_once_and_kept() {
    let (home, folder) = folder_with("paper");
    let arguments = "figures --out paper --quick --no-colmap --json";
    let made = home.run_json(arguments);
    let mut found: Vec<&str> = figures(&made).into_iter().map(|(name, _)| name).collect();
    found.sort_unstable();
    assert_eq!(found, ALL);
    assert!(figures(&made).iter().all(|(_, resumed)| !resumed));
    ALL.iter().for_each(|name| assert_whole(&folder, name));
    let page = fs::read_to_string(folder.join("index.html")).expect("a page");
    for name in ALL {
        assert!(page.contains(&format!("src=\"{name}.svg\"")) && page.contains(&format!("href=\"{name}.csv\"")));
    }
    assert!(page.contains("was not found (pycolmap alone is not enough)") && page.contains("--quick"));
    says(fs::read_to_string(folder.join("table1.csv")).expect("a table"), &["1D,BuFF 1D,,,", "2D,gold standard,,,"]);
    let numbers = fs::read(folder.join("fig7.csv")).expect("numbers");
    fs::write(folder.join("fig7.csv"), "mine").expect("written");
    says(home.run_badly(arguments, 1), &["fig7.csv", "did not write"]);
    assert_eq!(fs::read_to_string(folder.join("fig7.csv")).expect("there"), "mine");
    fs::write(folder.join("fig7.csv"), numbers).expect("put back");
    let dates = || names(&folder).iter().map(|n| folder.join(n).metadata().and_then(|m| m.modified()).ok()).collect();
    let before: Vec<_> = dates();
    let seconds = made["figures"][4]["seconds"].clone();
    let picture = fs::read_to_string(folder.join("fig7.svg")).expect("a picture");
    fs::write(folder.join("fig7.svg"), picture.replacen("<title>", "<title>Altered: ", 1)).expect("written");
    let again = home.run_json(arguments);
    figures(&again).into_iter().for_each(|(name, resumed)| assert_eq!(resumed, name != "fig7", "{name}"));
    assert_eq!(again["figures"][4]["seconds"], seconds);
    assert_whole(&folder, "fig7");
    let after: Vec<_> = dates();
    assert_eq!(before.len(), after.len());
    assert!(before.iter().zip(&after).filter(|(a, b)| a == b).count() >= 20, "what was kept is as it was");
}

#[test]
fn only_some_and_only_in_a_folder_of_figures() {
    let home = folder();
    let only = ["figures", "--out", "paper", "--quick", "--no-colmap", "--only", "fig9,fig3"];
    let text = home.run_well(&only);
    assert!(text.contains("Fig. 3") && text.contains("Fig. 9") && !text.contains("Fig. 4"), "{text}");
    let found = names(&home.join("paper"));
    let shown: Vec<&String> = found.iter().filter(|name| !name.starts_with('.')).collect();
    assert_eq!(shown, ["fig3.csv", "fig3.svg", "fig9.csv", "fig9.svg", "index.html", "records"]);
    for (arguments, code, words) in [
        (vec!["figures"], 2, "--out"),
        (vec!["figures", "--out", "paper", "--only", "fig12"], 2, "fig1 to fig9 or table1 to table3"),
        (vec!["figures", "--out", "paper/fig3.svg"], 2, "this is not a folder"),
    ] {
        assert!(home.run_badly(&arguments, code).contains(words), "{arguments:?}");
    }
    home.make_dir("own");
    home.write("own/fig3.svg", "mine");
    says(home.run_badly("figures --out own --quick", 1), &["this folder holds files"]);
    assert_eq!(names(&home.join("own")), ["fig3.svg"]);
}

#[cfg(all(unix, feature = "colmap"))]
const MAPPER: &str = r#"#!/bin/sh
set -e
[ "$1" = mapper ] && [ "$2" = --database_path ] && [ "$4" = --image_path ] && [ "$6" = --output_path ]
[ -s "$3" ] && [ -f "$5/burst_000.png" ]
mkdir -p "$7/0"
printf '1 0 0 9 0 0 0 0.5 1 0 2 0\n' > "$7/0/points3D.txt"
awk '!/^#/ { w=$8; qx=-$5; qy=-$6; qz=-$7; x=$2; y=$3; z=$4
  tx=(1-2*(qy*qy+qz*qz))*x+2*(qx*qy-w*qz)*y+2*(qx*qz+w*qy)*z
  ty=2*(qx*qy+w*qz)*x+(1-2*(qx*qx+qz*qz))*y+2*(qy*qz-w*qx)*z
  tz=2*(qx*qz-w*qy)*x+2*(qy*qz+w*qx)*y+(1-2*(qx*qx+qy*qy))*z
  printf "%d %.12f %.12f %.12f %.12f %.12f %.12f %.12f 1 burst_%03d.png\n1 1 1\n", $1+1, w, qx, qy, qz, -tx, -ty, -tz, $1
}' "$(dirname "$3")/../way/poses.txt" > "$7/0/images.txt"
"#;

#[cfg(all(unix, feature = "colmap"))]
#[test]
fn where_colmap_is_installed_it_fills_the_columns() {
    use std::os::unix::fs::PermissionsExt;
    let (home, tool) = folder_with("bin/colmap");
    home.make_dir("bin");
    fs::write(&tool, MAPPER).expect("written");
    fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).expect("set");
    let path = std::env::var("PATH").unwrap_or_default();
    let arguments = "figures --out paper --quick --only table1,table2,table3,fig8 --json";
    let mut command = home.program(arguments);
    let output = command.env("PATH", format!("{}:{path}", home.join("bin").display())).output().expect("runs");
    assert!(output.status.success(), "{}", stderr(&output));
    let folder = home.join("paper");
    ["table1", "table2", "table3", "fig8"].iter().for_each(|name| assert_whole(&folder, name));
    let csv = |name: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(folder.join(name)).expect("a table");
        // Commas within quotes part nothing.
        let plain = |(i, part): (usize, &str)| if i % 2 == 1 { part.replace(',', ";") } else { part.to_owned() };
        let line = |line: &str| line.split('"').enumerate().map(plain).collect::<String>();
        text.lines().skip(1).map(|row| line(row).split(',').map(str::to_owned).collect()).collect()
    };
    for row in csv("table1.csv") {
        assert_eq!((row[2].as_str(), row[3].as_str()), ("1", "100"), "{row:?}");
    }
    for row in csv("table2.csv") {
        let errors: Vec<f64> = row[2..].iter().map(|x| x.parse().expect("a number")).collect();
        assert!(errors.iter().all(|&error| error < 1e-3), "{row:?}");
    }
    assert!(csv("table3.csv").iter().all(|row| row[3].parse::<f64>().is_ok_and(|secs| secs > 0.0)));
    assert!(csv("fig8.csv").iter().any(|row| row[1] == "buff-2d"));
    assert!(names(&folder.join("records/pieces")).iter().all(|name| name.ends_with(".json")));
}
