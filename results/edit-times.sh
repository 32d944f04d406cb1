#!/bin/bash
# How long an edit takes until the program runs, and until one test has run: `results/edit-times.sh CHECKOUT [CHECKOUT…]`.
#
# Each CHECKOUT is a work tree that is built first, with its default features, and then edited in four places: the command line, a
# technique, Vulkan, a shader. An edit changes a text or a number that is compiled in; it is taken back at the end. Prints a Markdown row
# per edit with a column per checkout, seconds of the program and of the test. CARGO_TARGET_DIR is not used: each has its own `target`.
set -eu
[ $# -gt 0 ] || { sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2 && exit 2; }
unset CARGO_TARGET_DIR CARGO_INCREMENTAL

# What is edited: name, file names of which one exists, text, and what it becomes.
edits=(
    "cli|src/cli/help.rs|keys of every technique|keys of each technique"
    "technique|src/technique/beer_shadow_map.rs|beer_shadow_map.blend|beer_shadow_map.blends"
    "gpu|src/gpu/record/commands.rs src/gpu/commands.rs|MAX_UPDATE_BYTES: usize = 65536|MAX_UPDATE_BYTES: usize = 32768"
    "shader|glsl/technique/beer_shadow_map/visibility.glsl|0.0|0.00001"
)

seconds() {
    local start=${EPOCHREALTIME/./}
    "$@" >/dev/null 2>&1 || { echo "failed: $*" >&2 && exit 1; }
    echo $(((${EPOCHREALTIME/./} - start) / 1000000))
}

# The test that an edit is tried with: of the library's own, which every edit builds anew.
check() {
    cargo test --release --lib cli::help
}

declare -A table
for checkout in "$@"; do
    pushd "$checkout" >/dev/null
    first=$(seconds cargo build --release)
    seconds check >/dev/null
    table[first]="${table[first]:-} $first |"
    for edit in "${edits[@]}"; do
        IFS='|' read -r name files from to <<<"$edit"
        file=
        for candidate in $files; do [ ! -e "$candidate" ] || file=$candidate; done
        grep -qF "$from" "$file" || { echo "$checkout/$file lacks \"$from\"" >&2 && exit 1; }
        cp -p "$file" "$file.before"
        sed -i "0,/$from/s//$to/" "$file"
        program=$(seconds bash -c 'cargo build --release && target/release/gobo --version')
        test=$(seconds check)
        mv "$file.before" "$file" && touch "$file"
        table[$name]="${table[$name]:-} $program, $test |"
        echo "$checkout, $name: $program s, $test s" >&2
    done
    popd >/dev/null
done
printf '| edit |' && for checkout in "$@"; do printf ' %s |' "$(git -C "$checkout" log -1 --format=%h)"; done && echo
printf '|---|' && for _ in "$@"; do printf -- '---|'; done && echo
echo "| none: the program from what is there |${table[first]}"
for edit in "${edits[@]}"; do
    name=${edit%%|*}
    echo "| in \`$name\`: program, then a test |${table[$name]}"
done
