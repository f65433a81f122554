//! Tests of `export::kept`.

use burstscope_core::export::*;
use burstscope_core::files::mark::Checksum;
use serde::{Deserialize, Serialize};
use serde_json::json;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    content: Checksum,
    values: Vec<f64>,
}

fn record() -> Record<Row> {
    let of = Row { content: Checksum::of(b"3 128\n"), values: vec![0.1, 2.5e-7] };
    Record { made_from: MadeFrom::new(json!({ "levels": 4 })), of }
}

#[test]
fn records_come_back_and_go() {
    let home = tempfile::tempdir().expect("a folder");
    let records = Records::of(home.path());
    assert_eq!(records.read::<Row>("night"), None);
    records.write("night", &record()).expect("written");
    assert_eq!(records.read("night"), Some(record()));
    assert_eq!(records.read::<Record<String>>("night"), None, "it is no text");
    assert!(record().made_from.is_of_this_program());
    assert_ne!(MadeFrom::new(json!({ "levels": 5 })), record().made_from);
    records.remove("night").expect("removed");
    records.remove("night").expect("it is not there");
    assert_eq!(records.read::<Row>("night"), None);
}
