//! Advice on slopes, against the truth.

use crate::prelude::*;
use burstscope_lab::evaluate::{AdviceStudy, advice::AdvisedBurst, advice::Statement};

fn study(seeds: u64) -> AdviceStudy {
    AdviceStudy { snrs: vec![2.0], seeds, first_seed: 1 }
}

#[test]
fn a_table_sums_to_the_bursts_whatever_the_threads_and_nonsense_is_refused() {
    let on = |threads| on_threads(threads, || study(1).run(&quiet())).expect("a report");
    let report = on(1);
    assert_eq!(report, on(2));
    assert_eq!(report.bursts.len(), 14);
    assert_eq!(report.said.values().flat_map(|truths| truths.values()).sum::<usize>(), 14);
    let of = |kind| report.bursts.iter().find(|burst| burst.kind == kind).expect("one of each");
    for (kind, said) in [
        ("noise", Statement::Unknown),
        ("camera", Statement::Unknown),
        ("striped", Statement::Fits),
        ("line", Statement::Fits),
        ("narrow", Statement::Range),
        ("beside", Statement::Direction),
        ("exchanged", Statement::Times),
    ] {
        assert_eq!((of(kind).said, of(kind).truth), (said, said), "{:?}", of(kind));
    }
    let (said, wrong) = (|burst: &&AdvisedBurst| burst.said != Statement::Unknown, AdvisedBurst::is_wrong);
    let share = report.bursts.iter().filter(|burst| wrong(burst)).count() as f64
        / report.bursts.iter().filter(said).count() as f64;
    assert_eq!(report.wrong_share, Some(share));
    for (study, start) in [
        (AdviceStudy { snrs: Vec::new(), ..study(1) }, "snr"),
        (AdviceStudy { snrs: vec![-1.0], ..study(1) }, "snr"),
        (study(0), "seeds"),
        (study(u64::MAX), "seeds"),
    ] {
        let error = study.run(&quiet()).expect_err(start).to_string();
        assert!(error.starts_with(start), "{error}");
    }
}
