#!/bin/bash
# Makes the CSVs of a folder here anew: `results/measure.sh FOLDER gpu|lavapipe|swiftshader [NAME…]`; without names all
# of that kind, in the order of commands.txt beside this script, which has the list. What is measured is what the default
# device is; GOBO is the program, by default `cargo run --release --`. Nothing else is needed but this folder: all scenes
# are built in, but for those in $FILES, which commands.txt names.
#
# Writes FOLDER/NAME.csv, and what commands.txt keeps beside it; FOLDER/NAME.log has what was printed where it failed.
# Says the seconds of each, goes on after a failure, and ends with one if there was any. GOBO=echo prints
# the commands.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
export FILES=${FILES:-$here/files}
folder=${1:-} kind=${2:-}
case $kind in
gpu | lavapipe | swiftshader) ;;
*)
    sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
    ;;
esac
shift 2
wanted=("$@")
mkdir -p "$folder" || exit 1

# A line per command: what is indented goes on.
lines=()
while IFS= read -r line || [ -n "$line" ]; do
    case $line in
    '' | '#'*) ;;
    ' '*) lines[${#lines[@]} - 1]+=$line ;;
    *) lines+=("$line") ;;
    esac
done <"$here/commands.txt"

known=() failed=()
for line in "${lines[@]}"; do
    read -r kinds name arguments <<<"$line"
    keep=${name#*=} name=${name%%=*}
    [[ ,$kinds, == *,$kind,* ]] || continue
    known+=("$name")
    [ ${#wanted[@]} -eq 0 ] || [[ " ${wanted[*]} " == *" $name "* ]] || continue
    eval "set -- $arguments"
    [ "${GOBO:-}" != echo ] || { echo "$name: gobo $*" && continue; }
    out=$(mktemp -d)
    SECONDS=0 status=0
    ${GOBO:-cargo run --release --quiet --} "$@" --out "$out" >"$out/text" 2>"$out/errors" || status=$?
    # Where a row failed the others are there.
    for csv in results stress; do
        [ ! -e "$out/$csv.csv" ] || cp "$out/$csv.csv" "$folder/$name.csv"
    done
    [[ ,$keep, != *,json,* ]] || cp "$out/results.json" "$folder/$name.json"
    [[ ,$keep, != *,text,* ]] || cp "$out/text" "$folder/$name.txt"
    [[ ,$keep, != *,plots,* ]] || cp "$out"/*-vs-error.svg "$folder/"
    if [ $status -eq 0 ]; then
        echo "$name: $SECONDS s"
    else
        cat "$out/text" "$out/errors" >"$folder/$name.log"
        echo "$name: failed after $SECONDS s: $(tail -n 1 "$out/errors")"
        failed+=("$name")
    fi
    rm -r "$out"
done
for name in "${wanted[@]}"; do
    [[ " ${known[*]} " == *" $name "* ]] || { echo "$name: no such command of $kind" && failed+=("$name"); }
done
[ ${#failed[@]} -eq 0 ] || { echo "failed: ${failed[*]}" && exit 1; }
