//! Tests of `matching::params`.

use burstscope_core::detector::params::Word;
use burstscope_core::matching::camera::*;
use burstscope_core::matching::params::*;

#[test]
fn the_defaults_are_valid_and_survive_a_file() {
    let params = MatchParams::default();
    assert_eq!(params.validate(), Ok(()));
    let text = toml::to_string(&params).expect("plain values");
    assert_eq!(toml::from_str(&text), Ok(params));
    assert!(toml::from_str::<MatchParams>("ration = 0.7").is_err());
    let params = MatchParams { camera: Some(Camera::centred(8, 6, 5.0)), ..MatchParams::default() };
    let table = toml::Table::try_from(params).expect("plain values");
    let described: Vec<String> =
        burstscope_core::matching::params::doc::ALL.iter().map(|record| record.name.replace('-', "_")).collect();
    assert!(table.len() == described.len() && table.keys().all(|field| described.contains(field)), "{table:?}");
    for geometry in Geometry::ALL {
        assert_eq!(serde_json::to_value(geometry).ok(), Some(serde_json::Value::from(geometry.word())));
    }
}

#[test]
fn nonsense_is_named() {
    let flat = Camera { width: 0, ..Camera::centred(8, 6, 5.0) };
    type Spoil = fn(&mut MatchParams, Camera);
    let cases: [(&str, Spoil); 8] = [
        ("ratio", |p, _| p.ratio = f32::NAN),
        ("ratio", |p, _| p.ratio = 1.01),
        ("max-error-px", |p, _| p.max_error_px = 0.0),
        ("max-error-px", |p, _| p.max_error_px = f32::INFINITY),
        ("confidence", |p, _| p.confidence = 1.0),
        ("max-iterations", |p, _| p.max_iterations = 0),
        ("camera", |p, _| p.geometry = Geometry::Essential),
        ("camera", |p, flat| p.camera = Some(flat)),
    ];
    for (name, spoil) in cases {
        let mut params = MatchParams::default();
        spoil(&mut params, flat.clone());
        assert_eq!(params.validate().expect_err(name).subject, name);
    }
}
