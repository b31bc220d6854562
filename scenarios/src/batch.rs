//! Many runs at once, on all cores, with results in the order of the jobs.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

/// Does all jobs and gives their results in the order of the jobs, whatever the number of cores. `progress` is told how
/// many are done, from whichever thread did one.
pub(crate) fn run<J: Sync, R: Send>(
    jobs: &[J],
    work: impl Fn(&J) -> R + Sync,
    progress: impl Fn(usize) + Sync,
) -> Vec<R> {
    let done = AtomicUsize::new(0);
    let one = |job: &J| {
        let result = work(job);
        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        result
    };
    jobs.par_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_jobs_and_every_job_is_told_of() {
        let jobs: Vec<u64> = (0..200).collect();
        let told = Mutex::new(Vec::new());
        let slow_first = |job: &u64| {
            let steps = (200 - job) * 100;
            std::hint::black_box((0..steps).fold(*job, |sum, step| sum.wrapping_mul(31) ^ step));
            *job
        };
        let results = run(&jobs, slow_first, |done| told.lock().expect("no thread panics").push(done));
        assert_eq!(results, jobs);
        let mut told = told.into_inner().expect("no thread panics");
        told.sort_unstable();
        assert_eq!(told, (1..=200).collect::<Vec<_>>());
    }
}
