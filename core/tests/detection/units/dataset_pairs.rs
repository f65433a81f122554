//! Tests of `dataset::pairs`.

use burstscope_core::burst::*;
use burstscope_core::dataset::pairs::*;
use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::matching::PairSelection;
use burstscope_core::matching::*;
use burstscope_core::monitor::*;

struct Counted {
    missing: Option<usize>,
    loads: usize,
}

impl PairSource<Error> for Counted {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>> {
        self.loads += 1;
        let (places, descriptors) = (vec![[1.0, 2.0]; 3], vec![[7; 128]; 3]);
        let side = BurstSide { places, descriptors, blobs: Vec::new(), pictures: None };
        Ok((Some(index) != self.missing).then_some(side))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams)> {
        unreachable!("the pictures of burst {index} are not needed")
    }
}

#[test]
fn each_pair_is_matched_once_with_few_loads_and_pairs_without_features_are_left_out() {
    for (selection, missing) in
        [(PairSelection::All, None), (PairSelection::All, Some(4)), (PairSelection::Sequential(1), Some(0))]
    {
        let pairs = selection.pairs(40);
        let (mut source, mut seen) = (Counted { missing, loads: 0 }, Vec::new());
        let mut on = |pair: MatchedPair<'_>| {
            seen.push(pair.indices);
            Ok(())
        };
        let params = MatchParams { align: false, ..MatchParams::default() };
        let left_out = match_pairs(&pairs, &params, &mut source, &mut on, &Monitor::default()).expect("matched");
        seen.sort_unstable();
        let is_there = |&&(a, b): &&(usize, usize)| Some(a) != missing && Some(b) != missing;
        assert_eq!(seen, pairs.iter().filter(is_there).copied().collect::<Vec<_>>());
        assert_eq!(left_out, pairs.len() - seen.len());
        assert!(source.loads < 40 + pairs.len() / 3, "{} loads for {} pairs", source.loads, pairs.len());
    }
}
