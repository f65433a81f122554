//! Tables of reports: printed for people, and written into files.

use crate::evaluate::accuracy::{AccuracyReport, AccuracyRow, RangeCount};
use crate::evaluate::advice::{AdviceReport, AdviceStudy, AdvisedBurst, Statement};
use crate::evaluate::chart::{ChartReport, ChartRow, MethodReport};
use crate::evaluate::frames_of_burst::{BurstFramesReport, BurstFramesRow};
use crate::evaluate::motion_label;
use crate::evaluate::pure_noise::{NoiseCount, NoiseLevel, NoiseReport, NoiseRow};
use crate::evaluate::statistics::{Errors, Mean};
use crate::export::{ACCURACY_COLUMNS, BURST_FRAMES_COLUMNS, Cell, METHOD_COLUMNS, NOISE_COLUMNS, Table};
use crate::inspect::words::counted;
use crate::synth::{ChartParams, RadiusLaw};

/// Heads over rows of cells, see [`Table::text`].
pub(super) fn table(heads: &[impl AsRef<str>], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let heads: Vec<&str> = heads.iter().map(AsRef::as_ref).collect();
    let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::Text).collect()).collect();
    Table::new("", &",".repeat(heads.len() - 1), rows).headed(&heads).text()
}

pub(super) fn or_dash<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

/// `frames` is a number of frames, or a range of them; `each` names the setting that has `seeds` charts.
fn charts_text(chart: &ChartParams, frames: &str, each: &str, first_seed: u64, seeds: u64) -> String {
    let charts = if seeds == 1 {
        format!("one chart for each {each}, seed {first_seed}")
    } else {
        format!("{seeds} charts for each {each}, seeds {first_seed} to {}", first_seed.saturating_add(seeds - 1))
    };
    let ChartParams { discs, radius, contrast, width, height, bits, max_slope, .. } = chart;
    let (least, most) = (radius.start(), radius.end());
    let law = if chart.radius_law == RadiusLaw::Log { " (log-uniform)" } else { "" };
    let discs = format!("{discs} discs of radius {least} to {most} px{law}, contrast {contrast}");
    let frames = format!("in {frames} frames of {width}×{height}, {bits} bits");
    let slopes = format!("slopes up to ±{max_slope} px/frame in {}", motion_label(chart.motion));
    format!("{discs}, {frames}, {slopes}\n{charts}\n")
}

fn frames_of(chart: &ChartParams) -> usize {
    chart.uneven.count_and_span(chart.frames).0
}

pub(super) fn chart_text(report: &ChartReport) -> String {
    let (setup, last, discs) = (&report.setup, frames_of(&report.chart), report.chart.discs);
    let first = report.rows.first().map_or(0.0, |row| row.at.value()) as usize;
    let (each, head, frames) = match report.snr {
        None => ("SNR", "SNR", last.to_string()),
        Some(_) if first == last => ("number of frames", "frames", last.to_string()),
        Some(_) => ("number of frames", "frames", format!("{first} to {last}")),
    };
    let snr = report.snr.map_or_else(String::new, |snr| format!("SNR {snr}\n"));
    let of_methods = |title: String, cell: &dyn Fn(&MethodReport) -> String| {
        let methods = report.rows.first().map_or(&[][..], |row| &row.methods).iter().map(|one| one.method.label());
        let heads: Vec<&str> = std::iter::once(head).chain(methods).collect();
        let cells = |row: &ChartRow| std::iter::once(row.at.to_string()).chain(row.methods.iter().map(cell)).collect();
        format!("\n{title}\n{}", table(&heads, report.rows.iter().map(cells)))
    };
    let title = format!(
        "Discs found, of {discs}, at the threshold on {} where {} % of the detections are false (mean ± standard error)",
        <&str>::from(setup.ranking),
        (setup.false_fraction * 1000.0).round() / 10.0
    );
    charts_text(&report.chart, &frames, each, setup.first_seed, setup.seeds)
        + &snr
        + &of_methods(title, &|method| format!("{:.1}", method.true_positives))
        + &of_methods("Discs found + false features among all that was detected (means)".to_owned(), &|method| {
            format!("{:.1} + {:.1}", method.default_true_positives.mean, method.default_false_features.mean)
        })
        + &of_methods("False features a disc among all that was detected (mean)".to_owned(), &|method| {
            or_dash(method.default_false_per_disc, |n| format!("{:.2}", n.mean))
        })
        + &of_methods("Estimated over true noise of a frame".to_owned(), &|method| {
            or_dash(method.noise_estimate_ratio, |ratio| format!("{:.3}", ratio.mean))
        })
}

pub(super) fn burst_frames_text(report: &BurstFramesReport) -> String {
    let grid = report.detector.used_slopes();
    let mut text = format!(
        "{}: the middle frames as a burst, searched at slopes u {} and v {} (min:max:count, px/frame)\n\
         features of all frames: {} (orientations of one keypoint count once)\n",
        report.burst, grid.u, grid.v, report.features
    );
    text.extend(report.discs.map(|discs| format!("discs known: {discs}\n")));
    text.extend(report.second.iter().map(|second| format!("matched with as many middle frames of {second}\n")));
    let heads = ["frames", "features", "confirmed", "not", "discs", "false", "putative", "inliers"];
    let mut table = burst_frames_table(report).headed(&heads);
    // Truth and second burst may be missing: a column without any value is left out.
    let is_known = |column: &usize| table.rows.iter().any(|row| row[*column] != Cell::Missing);
    let known: Vec<usize> = (0..heads.len()).filter(is_known).collect();
    table.columns = known.iter().map(|&column| table.columns[column].clone()).collect();
    for row in &mut table.rows {
        *row = known.iter().map(|&column| row[column].clone()).collect();
    }
    text + "\n" + &table.text()
}

pub(super) fn burst_frames_table(report: &BurstFramesReport) -> Table {
    let row = |row: &BurstFramesRow| {
        let (putative, inliers) = (row.matches.map(|m| m.putative), row.matches.and_then(|m| m.inliers));
        let counts = [row.frames, row.features, row.confirmed, row.unconfirmed].map(Some).into_iter();
        let known = counts.chain([row.discs_found, row.false_features, putative, inliers]);
        known.map(|count| count.map_or(Cell::Missing, Cell::count)).collect()
    };
    Table::new(&report.burst, BURST_FRAMES_COLUMNS, report.rows.iter().map(row).collect())
}

/// The numbers of each method on charts: of each ratio, or of each number of frames.
pub(super) fn methods_table(report: &ChartReport) -> Table {
    let with_error = |mean: Mean| [Cell::of(Some(mean.mean), 1), Cell::of(mean.standard_error, 2)];
    let row = |(at, of): (&ChartRow, &MethodReport)| {
        let (snr, frames) = match report.snr {
            Some(snr) => (snr, at.at.value() as usize),
            None => (at.at.value(), frames_of(&report.chart)),
        };
        let begin = [Cell::Text(snr.to_string()), Cell::count(frames), of.method.name().into()];
        let means = [of.true_positives, of.default_true_positives, of.default_false_features];
        let per_disc = Cell::of(of.default_false_per_disc.map(|n| n.mean), 2);
        let noise = Cell::of(of.noise_estimate_ratio.map(|ratio| ratio.mean), 3);
        begin.into_iter().chain(means.into_iter().flat_map(with_error)).chain([per_disc, noise]).collect()
    };
    let rows = report.rows.iter().flat_map(|at| at.methods.iter().map(move |of| (at, of)));
    Table::new("Discs found", METHOD_COLUMNS, rows.map(row).collect())
}

/// The errors of crowded charts, and of charts of discs that stand apart.
pub(super) fn accuracy_table(reports: &[(&str, &AccuracyReport)]) -> Table {
    let mut rows = Vec::new();
    for (charts, row) in reports.iter().flat_map(|(charts, report)| report.rows.iter().map(move |row| (*charts, row))) {
        let mut add = |name: &str, count: usize, numbers: [Option<f64>; 4]| {
            let begin = [charts.into(), Cell::Text(row.snr.to_string()), name.into(), Cell::count(count)];
            rows.push(begin.into_iter().chain(numbers.map(|x| Cell::of(x, 4))).collect());
        };
        let signed = [("u", &row.u), ("v", &row.v), ("scale", &row.scale)];
        for (name, e) in signed.into_iter().chain([("slope_u", &row.slope_u), ("slope_v", &row.slope_v)]) {
            let mean = (e.count > 0).then_some(e.signed.mean);
            add(name, e.count, [Some(e.median_magnitude), Some(e.magnitude_95), mean, e.signed.standard_error]);
        }
        let distances = [("distance", row.u.count, row.distance), ("distance_apart", row.apart, row.distance_apart)];
        for (name, count, [median, most]) in
            distances.into_iter().chain([("slope_distance", row.u.count, row.slope_distance)])
        {
            add(name, count, [Some(median), Some(most), None, None]);
        }
    }
    Table::new("Errors of features", ACCURACY_COLUMNS, rows)
}

pub(super) fn noise_table(report: &NoiseReport) -> Table {
    let rows = report.rows.iter().flat_map(|row| row.searches.iter().map(move |search| (row.level, search)));
    let row = |(NoiseLevel { sigma, bits, case, mean }, search): (NoiseLevel, &NoiseCount)| {
        let most = search.of_bursts.iter().max().map_or(0.0, |most| *most as f64);
        let numbers = [
            (f64::from(search.noise_gate_factor), 2),
            (search.per_megapixel, 2),
            (search.standard_error, 2),
            (search.false_features as f64, 0),
            (most, 0),
        ];
        let bits = bits.map_or(Cell::Missing, |bits| Cell::Number(bits.into(), 0));
        let level = vec![Cell::Text(case.name()), Cell::Text(sigma.to_string()), Cell::Text(mean.to_string()), bits];
        let search = [search.label.as_str().into(), Cell::count(search.slopes)];
        level.into_iter().chain(search).chain(numbers.map(|(x, decimals)| Cell::of(Some(x), decimals))).collect()
    };
    Table::new("False features on noise", NOISE_COLUMNS, rows.map(row).collect())
}

pub(super) fn accuracy_text(crowded: &AccuracyReport, apart: Option<&AccuracyReport>) -> String {
    let grid = crowded.detector.used_slopes();
    let mut text = format!("searched at slopes u {} and v {} (min:max:count, px/frame)\n", grid.u, grid.v);
    let titles = ["Crowded charts: neighbours draw features aside", "Charts of discs that stand apart in all frames"];
    for (title, report) in titles.into_iter().zip([Some(crowded), apart]) {
        let Some(report) = report else { continue };
        let frames = frames_of(&report.chart).to_string();
        let charts = charts_text(&report.chart, &frames, "SNR", report.first_seed, report.seeds);
        text += &format!("\n{title}\n{charts}");
        text.extend(report.rows.iter().map(errors_text));
    }
    text + "\nErrors are those of found discs that are not on the rim of the slopes. Scales are compared with the σ at which a\n\
        difference of Gaussians answers a disc most strongly, not with r/√2.\n"
}

fn errors_text(row: &AccuracyRow) -> String {
    let counts = |words: &str, RangeCount { discs, found, marked }: RangeCount| {
        format!("{words} {discs}, found {found}, of these on the rim of the slopes {marked}\n")
    };
    // Without discs there are no errors.
    let number = |x: f64| or_dash((!x.is_nan()).then_some(x), |x| format!("{x:.4}"));
    let line = |words: &str, [median, most]: [f64; 2], signed: String| {
        vec![words.to_owned(), number(median), number(most), signed]
    };
    let errors = |words: &str, e: &Errors, factor: f64| {
        let signed = match e.signed.standard_error {
            _ if e.count == 0 => "–".to_owned(),
            Some(error) => format!("{:+.4} ± {:.4}", e.signed.mean * factor, error * factor),
            None => format!("{:+.4}", e.signed.mean * factor),
        };
        line(words, [e.median_magnitude * factor, e.magnitude_95 * factor], signed)
    };
    let lines = [
        errors("place u, px", &row.u, 1.0),
        errors("place v, px", &row.v, 1.0),
        errors("scale, %", &row.scale, 100.0),
        errors("slope u, px/frame", &row.slope_u, 1.0),
        errors("slope v, px/frame", &row.slope_v, 1.0),
        line("distance, px", row.distance, format!("of {} discs", row.u.count)),
        line("distance, px", row.distance_apart, format!("of {} discs that stand apart", row.apart)),
        line("slope distance, px/frame", row.slope_distance, String::new()),
    ];
    format!("\nSNR {}\n", row.snr)
        + &counts("discs within the range of slopes", row.within)
        + &counts("discs beyond the range", row.beyond)
        + &table(&["", "median |error|", "95 %", "mean ± standard error"], lines)
}

/// `drawn` is the study of all kinds, of which `report` has the worst.
pub(super) fn noise_text(report: &NoiseReport, drawn: Option<&NoiseReport>) -> String {
    let columns = report.rows.first().map_or(&[][..], |row| &row.searches);
    let heads = ["noise", "sigma", "mean", "bits"].map(str::to_owned).into_iter();
    let searches = columns.iter().map(|search| format!("{}, {} slopes", search.label, search.slopes));
    let heads: Vec<String> = heads.chain(searches).collect();
    let rows = report.rows.iter().map(|row| {
        let NoiseLevel { sigma, bits, case, mean } = row.level;
        let level = [case.name(), sigma.to_string(), mean.to_string(), or_dash(bits, |bits| bits.to_string())];
        let counts = row.searches.iter().map(|search| {
            let most = search.of_bursts.iter().max().unwrap_or(&0);
            let (rate, error, count) = (search.per_megapixel, search.standard_error, search.false_features);
            match search.refused {
                0 => format!("{rate:.2} ± {error:.2} ({count}, {most})"),
                refused if refused == report.bursts => "refused".to_owned(),
                refused => format!("{rate:.2} ± {error:.2} ({count}, {most}; {refused} refused)"),
            }
        });
        level.into_iter().chain(counts).collect()
    });
    let gates = columns.iter().map(|search| format!("{:.2} σ", search.noise_gate_factor));
    let gates = std::iter::once("noise gate".to_owned()).chain(std::iter::repeat_n(String::new(), 3)).chain(gates);
    let NoiseReport { bursts, frames, width, height, megapixels, first_seed, .. } = report;
    let table = table(&heads, rows.chain([gates.collect()]));
    let worst = report.rows.iter().max_by(|a, b| a.most().total_cmp(&b.most())).zip(drawn);
    let worst = worst.map_or_else(String::new, |(worst, drawn)| {
        let NoiseLevel { sigma, case, mean, .. } = worst.level;
        let in_burst = |burst: usize| worst.searches.iter().map(|search| search.of_bursts[burst]).max();
        let seed = first_seed + (0..*bursts).rev().max_by_key(|burst| in_burst(*burst)).unwrap_or(0) as u64;
        let made = format!("synth noise --case {} --sigma {sigma} --level {mean} --seed {seed}", case.name());
        let size = format!("--width {width} --height {height} --frames {frames} --out noise");
        let is_refused = |row: &&NoiseRow| row.searches.iter().any(|search| search.refused > 0);
        let refused = drawn.rows.iter().filter(is_refused).count();
        let drawn = format!("{}, {refused} of which the gate refuses", counted(drawn.rows.len(), "kind"));
        format!("\nthe worst of {drawn}; its burst with most of them:\nburstscope {made} {size}\n")
    });
    format!(
        "{} of {frames} frames of {width}×{height} for each row, {megapixels:.1} Mpx of image, seeds from {first_seed}\n\n\
         False features in a million pixels of the image (± standard error), how many there were, and most in a burst\n{table}{worst}",
        counted(*bursts, "burst")
    )
}

pub(super) fn advice_tables(report: &AdviceReport) -> String {
    let AdviceReport { study: AdviceStudy { snrs, seeds, first_seed }, said, bursts, .. } = report;
    let name = |statement: &Statement| format!("{statement:?}").to_lowercase();
    let heads: Vec<String> = ["said \\ true".to_owned()].into_iter().chain(Statement::ALL.iter().map(name)).collect();
    let rows = said.iter().map(|(said, of)| {
        // Most are 0, and would hide the others.
        let counts = of.values().map(|&count| if count > 0 { count.to_string() } else { "·".to_owned() });
        [name(said)].into_iter().chain(counts).collect()
    });
    let share = or_dash(report.wrong_share, |share| format!("{:.1} %", 100.0 * share));
    let text = format!(
        "{} for each kind and SNR, seeds from {first_seed}\n\n{}wrong, of what is said and not unknown: {share}\n\n",
        counted(*seeds as usize, "burst"),
        table(&heads, rows)
    );
    let heads: Vec<String> =
        ["right, wrong, unknown".to_owned()].into_iter().chain(snrs.iter().map(|snr| format!("SNR {snr}"))).collect();
    // All bursts of a kind lie together, and so do those of a ratio.
    let by_kind = bursts.chunk_by(|a, b| a.kind == b.kind).map(|of_kind| {
        let cell = |of_snr: &[AdvisedBurst]| {
            let right = of_snr.iter().filter(|burst| burst.said == burst.truth).count();
            let wrong = of_snr.iter().filter(|burst| burst.is_wrong()).count();
            format!("{right} {wrong} {}", of_snr.len() - right - wrong)
        };
        let cells = of_kind.chunks(*seeds as usize).map(cell);
        [of_kind[0].kind.to_owned()].into_iter().chain(cells).collect()
    });
    text + &table(&heads, by_kind)
}
