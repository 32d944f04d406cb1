//! How often a build is timed.

use crate::Result;
use crate::technique::Lifetime;
use std::time::{Duration, Instant};

/// Shortest warm-up: an idle device needs a few milliseconds of work to reach its clock rate.
pub(in crate::bench) const WARM_UP: Duration = Duration::from_millis(200);

/// Warm-up of a GPU per timed build, and its maximum in all: after a pause an H200 was seen to drop from 1,980 to 1,260 MHz, and to need
/// 1.2 s of work to recover (docs/reference/drivers.md).
const GPU_WARM_UP: Duration = Duration::from_millis(50);
const MOST_WARM_UP: Duration = Duration::from_millis(1500);

/// Longest warm-up of a device whose clock is low, which may have idled while a truth was computed.
pub(in crate::bench) const SLOW_WARM_UP: Duration = Duration::from_secs(6);

/// Interval at which the clock is checked during this longer warm-up.
const ASK_AGAIN: Duration = Duration::from_millis(50);

/// When to stop repeating a bake, which may take a minute and is not part of a frame.
const BAKE_BUDGET: Duration = Duration::from_secs(2);

/// When to stop repeating a per-frame build: maps of a thousand lights take minutes each on a software device.
const FRAME_BUDGET: Duration = Duration::from_secs(60);

/// When to stop repeating if rows are measured only to choose between them: a few repeats are enough to see a difference. A software device
/// has no clock rate to reach in that time.
const CHOICE_BUDGET: Duration = Duration::from_secs(5);
const SOFTWARE_CHOICE_BUDGET: Duration = Duration::from_secs(2);

/// Whether a build takes so long that a software device does not repeat it for a choice.
pub(in crate::bench) fn is_long_for_a_choice(build_ns: f64) -> bool {
    build_ns > SOFTWARE_CHOICE_BUDGET.as_nanos() as f64
}

/// Whether a row's first build took about as long as its later ones. A first build is slower if the driver compiles shaders during it,
/// memory is touched for the first time, or a buffer is too small.
pub(in crate::bench) fn is_first_like_others(first_ns: f64, later_ns: f64) -> bool {
    first_ns < 1.25 * later_ns
}

/// How many builds warm up, how many are timed, and for how long.
pub struct Repetition {
    warm_up: usize,
    least: Duration,
    timed: usize,
    budget: Duration,
}

impl Repetition {
    /// Techniques that build each frame get `warm_up` warm-up builds and `timed` timed builds. Baked techniques get one warm-up build and
    /// at most `timed` timed builds. If builds take long, only as many are run as the budget allows. A software device has no clock rate to
    /// reach: with `warm_up` 0 it does not warm up at all.
    pub fn of(lifetime: Lifetime, software: bool, warm_up: usize, timed: usize) -> Self {
        if software && warm_up == 0 {
            let budget = if lifetime == Lifetime::Frame { FRAME_BUDGET } else { BAKE_BUDGET };
            return Self { warm_up, least: Duration::ZERO, timed, budget };
        }
        let of_gpu = (GPU_WARM_UP * timed as u32).clamp(WARM_UP, MOST_WARM_UP);
        let least = if software { WARM_UP } else { of_gpu };
        match lifetime {
            Lifetime::Frame => Self { warm_up, least, timed, budget: FRAME_BUDGET },
            Lifetime::Baked => Self { warm_up: 1, least: WARM_UP, timed, budget: BAKE_BUDGET },
        }
    }

    /// Shortens the repetition for a row that is measured only for a choice.
    pub fn of_choice(self, software: bool) -> Self {
        let budget = if software { SOFTWARE_CHOICE_BUDGET } else { CHOICE_BUDGET };
        Self { budget: self.budget.min(budget), ..self }
    }

    /// Calls `build` with the frame number and whether the build is timed. Returns the results of the timed builds, at least one. Warms up
    /// for as long as the device `is_slow`, within limits. If the budget is spent before the warm-up ends, the last build of the warm-up is
    /// the only result.
    ///
    /// # Errors
    /// Fails if `build` fails.
    pub fn run<B>(
        &self,
        is_slow: impl Fn() -> bool,
        mut build: impl FnMut(usize, bool) -> Result<B>,
    ) -> Result<Vec<B>> {
        let start = Instant::now();
        let (mut warmed, mut until) = (0, self.least);
        loop {
            if warmed >= self.warm_up && start.elapsed() >= until {
                if until >= self.least + SLOW_WARM_UP || !is_slow() {
                    break;
                }
                until = start.elapsed() + ASK_AGAIN;
            }
            let built = build(warmed, false)?;
            warmed += 1;
            if start.elapsed() >= self.budget {
                return Ok(vec![built]);
            }
        }
        let mut timed = vec![build(0, true)?];
        while timed.len() < self.timed && start.elapsed() < self.budget {
            timed.push(build(timed.len(), true)?);
        }
        Ok(timed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns how many builds are timed, and the frames of all builds, if each build takes `takes`.
    fn run(repeats: &Repetition, takes: Duration) -> (usize, Vec<usize>) {
        let (mut frames, mut timed) = (Vec::new(), 0);
        let build = |frame, is_timed| {
            std::thread::sleep(takes);
            frames.push(frame);
            timed += usize::from(is_timed);
            Ok(())
        };
        let count = repeats.run(|| false, build).expect("built").len();
        assert!(timed == count || (timed, count) == (0, 1), "{timed} of {count}");
        (count, frames)
    }

    /// The warm-up must continue until a clock has risen, here by the third check, but must end after [`SLOW_WARM_UP`] if the clock never
    /// rises.
    #[test]
    fn a_slow_device_warms_up_for_longer() {
        let repeats = Repetition { least: Duration::ZERO, ..Repetition::of(Lifetime::Frame, false, 1, 2) };
        let looks = std::cell::Cell::new(0);
        let is_slow = || looks.replace(looks.get() + 1) < 2;
        let start = Instant::now();
        let frames = repeats.run(is_slow, |frame, is_timed| Ok((frame, is_timed))).expect("built");
        assert_eq!((frames, looks.get()), (vec![(0, true), (1, true)], 3));
        assert!(start.elapsed() >= 2 * ASK_AGAIN, "{:?}", start.elapsed());
        let stuck = Repetition { budget: Duration::from_secs(60), ..repeats };
        let start = Instant::now();
        let build = |_, _| {
            std::thread::sleep(Duration::from_millis(10));
            Ok(())
        };
        assert_eq!(stuck.run(|| true, build).expect("built").len(), 2);
        assert!((SLOW_WARM_UP..2 * SLOW_WARM_UP).contains(&start.elapsed()), "{:?}", start.elapsed());
    }

    #[test]
    fn what_is_built_each_frame_is_built_as_often_as_asked() {
        let repeats = Repetition { least: Duration::ZERO, ..Repetition::of(Lifetime::Frame, true, 2, 3) };
        assert!(repeats.budget >= Duration::from_secs(30), "30 builds of a second are all timed");
        assert_eq!(run(&repeats, Duration::ZERO), (3, vec![0, 1, 0, 1, 2]));
    }

    #[test]
    fn a_gpu_warms_up_for_as_long_as_many_builds_need() {
        let least = |software, timed| Repetition::of(Lifetime::Frame, software, 5, timed).least.as_millis();
        assert_eq!([1, 8, 30, 1000].map(|timed| least(false, timed)), [200, 400, 1500, 1500]);
        assert_eq!(least(true, 1000), 200);
    }

    /// Without a warm-up, all builds are timed.
    #[test]
    fn a_software_device_need_not_warm_up() {
        for lifetime in [Lifetime::Frame, Lifetime::Baked] {
            assert_eq!(run(&Repetition::of(lifetime, true, 0, 2), Duration::ZERO), (2, vec![0, 1]));
        }
        assert_eq!(Repetition::of(Lifetime::Frame, false, 0, 2).least, WARM_UP);
    }

    #[test]
    fn a_build_that_takes_minutes_is_done_once() {
        let repeats = Repetition { budget: Duration::from_millis(1), ..Repetition::of(Lifetime::Frame, true, 5, 30) };
        assert_eq!(run(&repeats, Duration::from_millis(5)), (1, vec![0]));
    }

    #[test]
    fn a_long_bake_is_done_once() {
        let baked = Repetition::of(Lifetime::Baked, true, 5, 30);
        assert!(baked.budget < Duration::from_secs(60), "a bake of a minute spends it");
        let repeats = Repetition { budget: Duration::from_millis(1), ..baked };
        assert_eq!(run(&repeats, Duration::from_millis(5)), (1, vec![0]));
    }

    /// Sleeps last at least as long as requested, so the test can only check upper bounds of the number of builds.
    #[test]
    fn a_bake_is_repeated_until_the_budget_is_spent() {
        let baked = Repetition { least: Duration::ZERO, ..Repetition::of(Lifetime::Baked, true, 5, 30) };
        let repeats = Repetition { budget: Duration::from_millis(100), ..baked };
        let (timed, frames) = run(&repeats, Duration::from_millis(30));
        assert!((1..=3).contains(&timed) && frames.len() <= 4, "{timed} timed of {frames:?}");
        let endless = Repetition { budget: Duration::from_secs(3600), ..repeats };
        assert_eq!(run(&endless, Duration::ZERO).0, 30);
    }

    /// A row measured for a choice must be repeated for a shorter time than an ordinary row, or the same time if that is already short.
    #[test]
    fn a_choice_is_made_sooner() {
        let budget = |software, lifetime| {
            let repeats = Repetition::of(lifetime, software, 0, 2);
            (repeats.budget.as_secs(), repeats.of_choice(software).budget.as_secs())
        };
        assert_eq!(budget(false, Lifetime::Frame), (60, 5));
        assert_eq!(budget(true, Lifetime::Frame), (60, 2));
        assert_eq!([true, false].map(|software| budget(software, Lifetime::Baked)), [(2, 2); 2]);
        assert_eq!([1.9e9, 2.1e9].map(is_long_for_a_choice), [false, true]);
        assert_eq!([1.1e9, 3.8e9].map(|first| is_first_like_others(first, 1e9)), [true, false]);
    }

    #[test]
    fn a_build_that_fails_is_the_last() {
        let repeats = Repetition::of(Lifetime::Baked, true, 1, 2);
        let failed =
            repeats.run(|| false, |_, _| -> Result<()> { Err(crate::Error::input("it", "fails", "leave it")) });
        assert!(failed.is_err());
    }
}
