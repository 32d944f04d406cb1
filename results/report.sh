#!/bin/bash
# Makes the report of four drivers anew: `results/report.sh` on a quiet machine, or `results/report.sh draw` from the rows that are there.
# Measures `devices` and `devices-meshes` of commands.txt on three software drivers, by one program: lavapipe as the system has it, that of
# setup.sh --interlock-lavapipe, and that of setup.sh --swiftshader. Writes their files, results/report, and with Chromium
# results/pictures/devices.png. A GPU's rows are measured on its machine, by results/measure.sh, with a program of the same commit.
# GOBO is the program, by default target/release/gobo.
set -eu
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/gobo
gobo=$(realpath "${GOBO:-$here/../target/release/gobo}")
# measure KIND FOLDER PROGRAM
measure() { echo "$2" && GOBO=$3 "$here/measure.sh" "$here/$2" "$1" devices devices-meshes; }
if [ "${1:-}" != draw ]; then
    measure lavapipe lavapipe-22.3 "$gobo"
    measure lavapipe lavapipe-26.1 "$cache/interlock-lavapipe/run $gobo"
    icd=$cache/swiftshader/icd.json
    VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd measure swiftshader swiftshader "$gobo"
fi
cd "$here/.."
files=()
for folder in nvidia-h200 lavapipe-26.1 lavapipe-22.3 swiftshader; do
    files+=("results/$folder/devices.json" "results/$folder/devices-meshes.json")
done
"$gobo" report "${files[@]}" -o results/report
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
chromium --headless=new --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$profile" --window-size=1400,1318 \
    --screenshot="$PWD/results/pictures/devices.png" "file://$PWD/results/report/devices.html" 2>"$profile/said" ||
    { cat "$profile/said" >&2 && exit 1; }
echo "$SECONDS s"
