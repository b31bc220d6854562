//! The accuracy of localization: a table over ten noisy drives of about 50 m through the house.
//!
//! ```sh
//! cargo bench -p trials --bench accuracy
//! ```

#![expect(clippy::print_stdout, reason = "prints a table")]

mod drive;
mod noisy_drive;

use std::time::{Duration, Instant};

use noisy_drive::Accuracy;
use robot::Reading;

fn main() {
    let atlas = noisy_drive::floor();
    println!("seed  driven  odometry ends off   RMSE             heading RMSE  at most   NEES  update");
    let mut all: Vec<Accuracy> = Vec::new();
    for seed in 1..=10 {
        let mut took = Duration::ZERO;
        let drive = noisy_drive::drive(&atlas, seed, |localization, reading| match reading {
            Reading::Odometry(odometry) => localization.odometry(odometry),
            Reading::Scan(scan) => {
                let start = now();
                localization.scan(scan);
                took += start.elapsed();
            }
            Reading::Battery(_) => {}
        });
        println!(
            "{seed:>4}  {:>4.1} m  {:>4.2} m, {:.3} rad     {:.4} m         {:.5} rad   {:.3} m   {:>4.2}  {:.2} ms",
            drive.driven_m,
            drive.odometry_off_m,
            drive.odometry_off_rad,
            drive.rmse_m,
            drive.rmse_rad,
            drive.max_m,
            drive.normalized_squared,
            took.as_secs_f64() * 1e3 / drive.updates as f64,
        );
        all.push(drive);
    }
    let median = |of: fn(&Accuracy) -> f64| trials::median(all.iter().map(of)).unwrap_or_default();
    println!(
        "median {:>3.1} m  {:>4.2} m, {:.3} rad     {:.4} m         {:.5} rad   {:.3} m   {:>4.2}",
        median(|drive| drive.driven_m),
        median(|drive| drive.odometry_off_m),
        median(|drive| drive.odometry_off_rad),
        median(|drive| drive.rmse_m),
        median(|drive| drive.rmse_rad),
        median(|drive| drive.max_m),
        median(|drive| drive.normalized_squared),
    );
}

#[expect(clippy::disallowed_methods, reason = "measures the time of updates")]
fn now() -> Instant {
    Instant::now()
}
