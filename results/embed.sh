#!/bin/bash
# Runs examples/embed on a device: `results/embed.sh > results/nvidia-h100/embed.md`.
#
# Prints a Markdown row a technique and variant: frames; how often Gobo called a function that submits or waits, counted by the renderer; whether the
# device's memory was the same after the last frame as after frame 100; Gobo's part of a frame on the host and on the device, medians; and how far
# answers at the particles are from the truth, the mean. Then what once-only steps take, and a frame of three-emitters (docs/notebook/embedding.md).
# EMBED is the example, by default `cargo run --release --example embed --`; VALIDATION is empty where no layer is installed. A run that fails
# is a row that says why, and the script then fails too.
set -u
read -ra embed <<<"${EMBED:-cargo run --release --quiet --example embed --}"
validation=${VALIDATION---validation}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0

# What is printed is kept in a file; of a failure the last line is a row.
run() {
    "${embed[@]}" "$@" >"$folder/out" 2>"$folder/err" && return
    failed=1
    echo "| $name | failed: $(tail -n 1 "$folder/err" | tr '|' '/') | | | | | |"
    return 1
}

row() {
    name="$1 | ${*:2}"
    run "$@" -o "$folder/smoke.png" --row "$name" && grep '^| ' "$folder/out"
}

echo '| technique | variant | frames | calls that submit or wait | memory | host, ms | device, ms | error |'
echo '|---|---|---|---|---|---|---|---|'
for technique in avsm psm beer-shadow-map; do
    row "$technique" --frames 1000 ${validation:+"$validation"} --truth
    row "$technique" --frames 300 --truth
    row "$technique" --frames 300 --truth --device-light
    row "$technique" --frames 300 --truth --no-interlock
    row "$technique" --frames 300 --truth --nothing-optional
    row "$technique" --frames 300 --truth --nothing-optional --no-timestamps
    row "$technique" --time
done
for technique in avsm psm beer-shadow-map avsm:path=binned; do
    time=(--time)
    [ "$technique" = avsm:path=binned ] && time=(--time --scene three-emitters)
    name="$technique | ${time[*]}"
    run "$technique" "${time[@]}" && printf '\n%s %s\n\n' "$technique" "${time[*]}" && sed -n '/^| /!s/^/    /p' "$folder/out"
done
exit $failed
