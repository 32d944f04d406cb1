#!/bin/bash
# Measures the renderer of examples/engine on a device: `results/embed.sh > results/nvidia-h100/embed.md`.
#
# Prints a Markdown row per technique and variant: frames; how often Gobo called a function that submits or waits; whether the device's memory was
# the same after the last frame as after frame 100; Gobo's part of a frame on the host and on the device, medians; and how far answers at the
# particles are from the truth, the mean. Then what each step of a frame takes, and a frame of three-emitters (docs/notebook/embedding.md).
# EMBED is the program of tests/embed.rs, by default cargo builds and runs it; a row that fails says why, and the script then fails too.
set -u
read -ra embed <<<"${EMBED:-cargo test --release --quiet --test embed --}"
failed=0

# What a measuring test prints, without what the harness says about it.
measure() {
    "${embed[@]}" --exact "measure::$1" --ignored --nocapture --test-threads=1 2>/dev/null | grep -vE '^(running|test) |^(ok|FAILED|\.|F)$'
    [ "${PIPESTATUS[0]}" = 0 ] || failed=1
}

measure rows
measure steps
measure alone
exit $failed
