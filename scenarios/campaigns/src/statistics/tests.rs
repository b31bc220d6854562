//! Tests reference values from the literature, and the guarantees: all of them by simulation, and some also exactly, by
//! enumerating all outcomes.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::Streams;

use super::*;

fn confidence(value: f64) -> Confidence {
    Confidence::new(value).unwrap()
}

fn simulated(name: &str) -> ChaCha8Rng {
    Streams::new(20_261_120).stream(name)
}

/// A sequential procedure, computed exactly: calls `at_stop` with every count at which `stops` can first hold and with
/// the probability that the procedure stops there. Returns the probability that it is still running after `max_runs`.
fn follow(p: f64, max_runs: u64, stops: impl Fn(Count) -> bool, mut at_stop: impl FnMut(Count, f64)) -> f64 {
    let mut going = vec![1.0_f64];
    for runs in 1..=max_runs {
        let mut next = vec![0.0; runs as usize + 1];
        for (happened, mass) in going.iter().enumerate() {
            next[happened] += mass * (1.0 - p);
            next[happened + 1] += mass * p;
        }
        for (happened, mass) in next.iter_mut().enumerate() {
            let count = Count::new(happened as u64, runs);
            if *mass > 0.0 && stops(count) {
                at_stop(count, std::mem::take(mass));
            }
        }
        going = next;
    }
    going.iter().sum()
}

/// The values are those of R's `binom.test`, as quoted in textbooks, including Conover's 682 of 925.
#[test]
fn intervals_agree_with_published_ones() {
    for (happened, runs, level, low, high) in [
        (682, 925, 0.95, 0.707_668_3, 0.765_406_6),
        (10, 100, 0.95, 0.049_004_7, 0.176_222_6),
        (5, 10, 0.95, 0.187_086_0, 0.812_914_0),
        (0, 10, 0.95, 0.0, 0.308_497_1),
        (10, 10, 0.95, 0.691_502_9, 1.0),
        (0, 300, 0.99, 0.0, 1.0 - libm::pow(0.005, 1.0 / 300.0)),
        (0, 0, 0.95, 0.0, 1.0),
    ] {
        let interval = Count::new(happened, runs).interval(confidence(level));
        let near = |a: f64, b: f64| (a - b).abs() < 6e-8;
        assert!(near(interval.low, low) && near(interval.high, high), "{happened} of {runs}: {interval}");
    }
}

#[test]
fn intervals_have_at_least_the_stated_coverage() {
    for level in [0.8, 0.95, 0.99] {
        for runs in [1, 5, 20, 100] {
            let intervals: Vec<_> = (0..=runs).map(|x| Count::new(x, runs).interval(confidence(level))).collect();
            for step in 0..=200 {
                let p = f64::from(step) / 200.0;
                let mut covered = 0.0;
                let _ = follow(
                    p,
                    runs,
                    |count| count.runs() == runs,
                    |count, mass| {
                        covered += if intervals[count.happened() as usize].contains(p) { mass } else { 0.0 };
                    },
                );
                assert!(covered >= level - 1e-9, "{covered} at {p} with {runs} runs");
            }
        }
    }
}

#[test]
fn intervals_have_the_stated_coverage_in_simulated_campaigns() {
    let mut rng = simulated("interval");
    for p in [0.003, 0.05, 0.4] {
        let covers = |_| {
            let mut count = Count::default();
            (0..300).for_each(|_| count.push(rng.random_bool(p)));
            count.interval(confidence(0.9)).contains(p)
        };
        let covered = (0..2000).map(covers).filter(|covers| *covers).count();
        // Three standard deviations below 0.9 of 2000.
        assert!(covered >= 1760, "{covered} of 2000 at {p}");
    }
}

#[test]
fn stopping_when_precise_enough_keeps_the_confidence_and_the_width() {
    for (half_width, level) in [(0.05, 0.95), (0.1, 0.9), (0.1, 0.99)] {
        let goal = Precision::new(half_width, confidence(level)).unwrap();
        for p in [0.0, 0.001, 0.02, 0.1, 0.3, 0.5, 0.93, 1.0] {
            let (mut covered, mut runs) = (0.0, 0.0);
            let left = follow(
                p,
                goal.max_runs(),
                |count| goal.reached(count).is_some(),
                |count, mass| {
                    let interval = goal.reached(count).unwrap();
                    assert!(interval.half_width() <= half_width);
                    covered += if interval.contains(p) { mass } else { 0.0 };
                    runs += mass * count.runs() as f64;
                },
            );
            assert_eq!(left, 0.0, "it goes on after {} runs", goal.max_runs());
            assert!(covered >= level, "{covered} at {p} instead of {level}");
            let few = goal.looks()[0] as f64 * 1.2;
            assert!((0.002..0.998).contains(&p) || runs < few, "{runs} runs at {p}");
        }
    }
}

/// Shows that the mistake that [`Precision`] avoids is real.
#[test]
fn stopping_at_the_first_narrow_interval_would_break_the_guarantee() {
    let (p, usual) = (0.12, |count: Count| count.interval(confidence(0.8)));
    let mut covered = 0.0;
    let left = follow(
        p,
        150,
        |count| usual(count).half_width() <= 0.05,
        |count, mass| {
            covered += if usual(count).contains(p) { mass } else { 0.0 };
        },
    );
    assert!(covered + left < 0.78, "the usual interval kept its coverage: {covered}");
}

#[test]
fn the_last_look_is_always_precise_enough() {
    let goal = Precision::new(0.1, confidence(0.95)).unwrap();
    let last = goal.max_runs();
    assert!((0..=last).all(|happened| goal.reached(Count::new(happened, last)).is_some()));
    assert!(goal.looks().is_sorted());
    assert_eq!(goal.reached(Count::new(0, goal.looks()[0] - 1)), None);
    let widest = goal.interval(Count::new(5, 10));
    assert!(widest.half_width() > Count::new(5, 10).interval(confidence(0.95)).half_width());
}

#[test]
fn the_sequential_test_keeps_its_error_rate() {
    for (bound, indifference, error) in [(0.1, 0.05, 0.05), (0.5, 0.1, 0.01), (0.02, 0.015, 0.1)] {
        let test = Sprt::new(bound, indifference, error).unwrap();
        for (p, wrong) in [
            (bound - indifference, SprtDecision::Above),
            ((bound - indifference) / 2.0, SprtDecision::Above),
            (bound + indifference, SprtDecision::Below),
            (bound + 2.0 * indifference, SprtDecision::Below),
        ] {
            let mut errors = 0.0;
            let left = follow(
                p,
                3000,
                |count| test.decision(count).is_some(),
                |count, mass| {
                    errors += if test.decision(count) == Some(wrong) { mass } else { 0.0 };
                },
            );
            assert!(left < 1e-6, "{left} undecided at {p}");
            assert!(errors <= error, "{errors} wrong at {p} instead of {error}");
        }
    }
}

#[test]
fn the_sequential_test_keeps_its_error_rate_in_simulated_campaigns() {
    let test = Sprt::new(0.1, 0.05, 0.05).unwrap();
    let mut rng = simulated("sprt");
    let (mut wrong, mut runs) = (0, 0);
    for _ in 0..4000 {
        let mut count = Count::default();
        while test.decision(count).is_none() {
            count.push(rng.random_bool(0.15));
        }
        wrong += u64::from(test.decision(count) == Some(SprtDecision::Below));
        runs += count.runs();
    }
    assert!(wrong <= 4000 / 20, "{wrong} of 4000 wrong");
    // Wald's approximation of the expected number of runs, for thresholds of ln 20.
    let (up, down) = (libm::log(3.0), libm::log(0.85 / 0.95));
    let wald = libm::log(20.0) * 0.9 / (0.15 * up + 0.85 * down);
    let mean = runs as f64 / 4000.0;
    assert!((0.9..1.3).contains(&(mean / wald)), "{mean} runs on average, about {wald} expected");
}

/// Fisher's lady tasting tea, the convictions of twins (Fisher 1962), and two tables from the manuals of R and SciPy.
#[test]
fn the_exact_test_agrees_with_published_values() {
    for ([a, b], [c, d], p) in [
        ([3, 4], [1, 4], 0.485_714_285_714),
        ([2, 12], [15, 18], 0.000_536_724_12),
        ([6, 8], [1, 5], 0.102_564_102_564),
        ([8, 10], [1, 6], 0.034_965_034_965),
    ] {
        let got = Comparison::of(Count::new(a, b), Count::new(c, d), confidence(0.95)).p_value;
        assert!((got / p - 1.0).abs() < 1e-6, "{a} of {b} and {c} of {d}: {got}, not {p}");
    }
}

#[test]
fn effect_sizes_agree_with_published_values() {
    // Newcombe's example a: 56 of 70 and 48 of 80, a difference of 0.2; his method 10 gives 0.0524 to 0.3339 with
    // Wilson's intervals, and the wider exact ones a slightly wider interval around that.
    let got = Comparison::of(Count::new(48, 80), Count::new(56, 70), confidence(0.95));
    assert!((got.difference.unwrap() - 0.2).abs() < 1e-12);
    assert!((0.03..0.0524).contains(&got.interval.low), "{}", got.interval);
    assert!((0.3339..0.36).contains(&got.interval.high), "{}", got.interval);
    assert!((got.odds_ratio.unwrap() - 8.0 / 3.0).abs() < 1e-12);
    // Cohen's table 6.2.2: φ = 2·arcsin √P is 1.772 at 0.60 and 2.214 at 0.80.
    assert!((got.cohens_h.unwrap() - (2.214 - 1.772)).abs() < 1e-3);
    let nothing = Comparison::of(Count::default(), Count::new(1, 1), confidence(0.95));
    assert_eq!((nothing.difference, nothing.cohens_h, nothing.odds_ratio), (None, None, None));
    assert_eq!(nothing.p_value, 1.0);
    assert_eq!(nothing.interval, Interval { low: -1.0, high: 1.0 });
}

#[test]
fn the_exact_test_keeps_its_false_positive_rate() {
    let (before, after) = (18, 25);
    let p_values: Vec<Vec<f64>> = (0..=before)
        .map(|x| {
            let p = |y| Comparison::of(Count::new(x, before), Count::new(y, after), confidence(0.95)).p_value;
            (0..=after).map(p).collect()
        })
        .collect();
    for step in 1..50 {
        let p = f64::from(step) / 50.0;
        // The probability of each count, exactly: a simulation could not tell 0.0500 from 0.0501.
        let mass = |runs| {
            let mut mass = vec![0.0; runs as usize + 1];
            let _ = follow(p, runs, |count| count.runs() == runs, |count, m| mass[count.happened() as usize] = m);
            mass
        };
        let (mass_before, mass_after) = (mass(before), mass(after));
        let chance = |level: f64| -> f64 {
            let of_row = |(row, m): (&Vec<f64>, &f64)| {
                let small = row.iter().zip(&mass_after).filter(|(p_value, _)| **p_value <= level);
                m * small.map(|(_, m)| m).sum::<f64>()
            };
            p_values.iter().zip(&mass_before).map(of_row).sum()
        };
        for level in [0.01, 0.05, 0.2] {
            assert!(chance(level) <= level, "{} at {p} instead of {level}", chance(level));
        }
    }
}

#[test]
fn the_interval_of_the_difference_covers_it_in_simulated_campaigns() {
    let mut rng = simulated("difference");
    for (p, q) in [(0.02, 0.02), (0.05, 0.2), (0.5, 0.4)] {
        let mut draw = |p: f64, runs| {
            let mut count = Count::default();
            (0..runs).for_each(|_| count.push(rng.random_bool(p)));
            count
        };
        let covers = |_| {
            let comparison = Comparison::of(draw(p, 80), draw(q, 120), confidence(0.9));
            comparison.interval.contains(q - p)
        };
        let covered = (0..1500).map(covers).filter(|covers| *covers).count();
        assert!(covered >= 1320, "{covered} of 1500 at {p} and {q}");
    }
}

/// Runs with a violation end four times sooner. Eight cores start a new run whenever one ends, so a rule that looks at
/// the runs in the order in which they end would see too many violations.
#[test]
fn stopping_on_many_cores_does_not_favor_short_runs() {
    let goal = Precision::new(0.2, confidence(0.8)).unwrap();
    let (p, campaigns) = (0.5, 2000);
    let mut rng = simulated("order");
    let mut first_to_end = Count::default();
    for _ in 0..campaigns {
        let runs: Vec<bool> = (0..goal.max_runs() + 8).map(|_| rng.random_bool(p)).collect();
        // Each core has the time at which its run ends, and the run; the one that ends first starts the next run.
        let mut cores: Vec<(u64, u64)> = (0..8).map(|k| (if runs[k] { 1 } else { 4 }, k as u64)).collect();
        let (mut order, mut counted, mut early) = (batch::InOrder::from(0), Count::default(), Count::default());
        let (mut stopped, mut next) = (None, 8);
        while stopped.is_none() {
            cores.sort_unstable();
            let (now, k) = cores.remove(0);
            order.put(k, runs[k as usize]);
            if early.runs() < 8 {
                early.push(runs[k as usize]);
            }
            while let (None, Some((_, violated))) = (stopped, order.take()) {
                counted.push(violated);
                stopped = goal.reached(counted).map(|_| counted);
            }
            if let Some(violated) = runs.get(next as usize) {
                cores.push((now + if *violated { 1 } else { 4 }, next));
                next += 1;
            }
        }
        let mut alone = Count::default();
        let mut runs = runs.iter();
        while goal.reached(alone).is_none() {
            alone.push(*runs.next().unwrap());
        }
        assert_eq!(stopped, Some(alone), "many cores stop where one does");
        first_to_end = first_to_end.and(early);
    }
    let biased = first_to_end.rate().unwrap();
    assert!(biased > p + 0.1, "what ends first is violated in {biased}: the test would notice");
}

#[test]
fn invalid_goals_are_rejected() {
    assert_eq!(Confidence::new(1.0), Err(StatisticsError::Confidence(1.0)));
    assert!(Confidence::new(f64::NAN).is_err());
    assert_eq!(Precision::new(0.0, confidence(0.95)), Err(StatisticsError::HalfWidth(0.0)));
    assert!(Sprt::new(0.1, 0.1, 0.05).is_err());
    assert!(Sprt::new(0.95, 0.1, 0.05).is_err());
    assert_eq!(Sprt::new(0.1, 0.05, 0.5), Err(StatisticsError::ErrorRate(0.5)));
}

/// The lady tasting tea: 3 of 4 and 1 of 4. Fisher's weights are 1, 16, 36, 16, 1, and at the upper end of the
/// interval ω⁴/(1 + 16ω + 36ω² + 16ω³ + ω⁴) is 0.975. The other two are those of SciPy's `odds_ratio`.
#[test]
fn odds_intervals_agree_with_published_ones() {
    for ([a, b], [c, d], low, high) in [
        ([1, 4], [3, 4], 0.211_735_595, 626.243_531),
        ([12, 100], [30, 100], 1.429_887_45, 7.217_549_18),
        ([700, 1000], [682, 925], 0.980_635_307, 1.475_921_59),
    ] {
        let got = Comparison::of(Count::new(a, b), Count::new(c, d), confidence(0.95)).odds_interval;
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
        assert!(near(got.low, low) && near(got.high.unwrap(), high), "{a} of {b} and {c} of {d}: {got:?}");
    }
    // Never and always: ω/(1 + ω) is 0.025 at the lower end, and there is no upper one.
    let extreme = Comparison::of(Count::new(0, 1), Count::new(1, 1), confidence(0.95)).odds_interval;
    assert!((extreme.low - 1.0 / 39.0).abs() < 1e-9 && extreme.high.is_none(), "{extreme:?}");
}

#[test]
fn odds_intervals_have_at_least_the_stated_coverage() {
    let (before, after) = (8, 10);
    let choose = |n: u64, k: u64| (1..=k).fold(1.0, |ways, i| ways * (n - k + i) as f64 / i as f64);
    let mass = |n: u64, k: u64, p: f64| choose(n, k) * libm::pow(p, k as f64) * libm::pow(1.0 - p, (n - k) as f64);
    for (p, ratio) in [(0.2, 0.3), (0.2, 1.0), (0.5, 3.0), (0.7, 0.1), (0.4, 12.0)] {
        let odds = p / (1.0 - p) * ratio;
        let q = odds / (1.0 + odds);
        let mut covered = 0.0;
        for (x, y) in (0..=before).flat_map(|x| (0..=after).map(move |y| (x, y))) {
            let interval = Comparison::of(Count::new(x, before), Count::new(y, after), confidence(0.9)).odds_interval;
            if interval.low <= ratio && interval.high.is_none_or(|high| ratio <= high) {
                covered += mass(before, x, p) * mass(after, y, q);
            }
        }
        assert!(covered >= 0.9, "{ratio} from {p}: {covered}");
    }
}

#[test]
fn pairs_are_tested_like_coin_tosses() {
    let p = |only_before, only_after| Paired { only_before, only_after }.p_value();
    // 2·(1 + 12 + 66 + 220)/2¹².
    assert!((p(9, 3) - 598.0 / 4096.0).abs() < 1e-12 && p(9, 3) == p(3, 9));
    assert!((p(6, 0) - 2.0 / 64.0).abs() < 1e-12);
    assert_eq!([p(0, 0), p(5, 5), p(1, 0)], [1.0; 3]);
}
