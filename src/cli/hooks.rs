//! For tests: environment variables that lower the capabilities of devices, make calls fail and reduce the workload of
//! commands. The program reads them if it is started with `--test-hooks`, which `--help` does not list.

use crate::cli::test_reduction;
use crate::gpu::{Fault, Testing};

/// The option with which tests start the program.
pub(super) const OPTION: &str = "--test-hooks";

/// Applies these variables from now on, to the whole process:
///
/// - `GOBO_TEST_LIMITS=lowest`: limits as low as Vulkan 1.3 allows.
/// - `GOBO_TEST_FEATURES=none`: no optional features.
/// - `GOBO_TEST_VALIDATION=gpu-assisted`: the validation layer also adds checks to shaders.
/// - `GOBO_TEST_FAULT=KIND:N`: the N-th call of a kind fails, and with `N+` all later ones too; with 0 all succeed.
/// - `GOBO_TEST_BURDEN=MIB`: each build also fills this many MiB, so that it takes longer than it should.
/// - `GOBO_TEST_SLOW_TRUTH=MS`: each row of the window's reference takes this many milliseconds longer.
/// - `GOBO_TEST_LITTLE`, if set and not empty: commands run all their steps, on a reduced workload.
#[doc(hidden)]
pub fn test_hooks() {
    let is = |name, value| std::env::var(name).is_ok_and(|set| set == value);
    let number = |name| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    let testing = Testing {
        lowest_limits: is("GOBO_TEST_LIMITS", "lowest"),
        no_features: is("GOBO_TEST_FEATURES", "none"),
        checks_in_shaders: is("GOBO_TEST_VALIDATION", "gpu-assisted"),
        fault: std::env::var("GOBO_TEST_FAULT").ok().and_then(|text| Fault::read(&text)),
        burden: number("GOBO_TEST_BURDEN"),
        slow_truth_ms: number("GOBO_TEST_SLOW_TRUTH"),
    };
    testing.begin();
    if std::env::var_os("GOBO_TEST_LITTLE").is_some_and(|value| !value.is_empty()) {
        test_reduction::begin();
    }
}
