//! Tests of `detector::coherence`.

use burstscope_core::detector::coherence::*;
use burstscope_core::synth::random::Stream;
use proptest::prelude::*;

#[test]
fn level_answers_are_coherent_and_a_bump_is_its_part() {
    let level: Vec<(f32, f32)> = vec![(-0.1, 0.0); 10];
    assert_eq!(evenness(&level).coherence, Some(1.0));
    assert_eq!(evenness(&level).shape, Shape::Level);
    // Three of ten respond: the coherence is 0.3.
    let bump: Vec<(f32, f32)> = (0..10).map(|t| (if (4..7).contains(&t) { 0.2 } else { 0.0 }, 0.005)).collect();
    let seen = evenness(&bump);
    assert!((seen.coherence.expect("clear") - 0.3).abs() < 0.02, "{seen:?}");
    assert_eq!(seen.shape, Shape::Bump);
    // Equal responses that are not side by side.
    let apart: Vec<(f32, f32)> = (0..10).map(|t| (if t % 4 == 1 { 0.2 } else { 0.0 }, 0.005)).collect();
    assert_eq!(evenness(&apart).shape, Shape::Uneven);
}

#[test]
fn noise_alone_says_nothing_and_hides_nothing_strong() {
    let mut noise = Stream::new(4, 0);
    let (mut unclear, mut level) = (0, 0);
    for _ in 0..200 {
        let nothing: Vec<(f32, f32)> = (0..10).map(|_| (noise.normal() as f32, 1.0)).collect();
        unclear += usize::from(evenness(&nothing).shape == Shape::Unclear);
        let there: Vec<(f32, f32)> = (0..10).map(|_| (4.0 + noise.normal() as f32, 1.0)).collect();
        level += usize::from(evenness(&there).shape == Shape::Level);
    }
    assert!(unclear > 180 && level > 190, "{unclear} {level}");
}

proptest! {
    #[test]
    fn coherence_is_a_part_and_does_not_depend_on_sign_or_unit(
        values in prop::collection::vec(-1.0f32..1.0, 0..20), noise in 0.0f32..0.5, gain in 0.1f32..10.0,
    ) {
        let answers = |gain: f32| values.iter().map(|v| (gain * v, gain.abs() * noise)).collect::<Vec<_>>();
        let (a, b) = (evenness(&answers(1.0)), evenness(&answers(-gain)));
        prop_assert!(a.coherence.is_none_or(|c| (0.0..=1.0).contains(&c)));
        if let (Some(a), Some(b)) = (a.coherence, b.coherence) {
            prop_assert!((a - b).abs() < 1e-3);
        }
        prop_assert!(a.mean.is_finite() && a.unevenness.is_finite());
    }
}
