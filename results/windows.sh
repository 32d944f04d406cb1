#!/usr/bin/env bash
# Builds gobo with its window for Windows, runs it in Wine on a Vulkan driver of this machine, and compares with the native program
# (GOBO, by default target/release/gobo): F12 of the window and the command that it copies have to give the same bytes on both. For macOS
# types are checked, since its SDK cannot be had elsewhere. Needs `rustup target add x86_64-pc-windows-gnu aarch64-apple-darwin` and Debian's
# g++-mingw-w64-x86-64-posix, wine, wine64 and xvfb.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
native=${GOBO:-$PWD/target/release/gobo} target=${CARGO_TARGET_DIR:-$PWD/target} work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cargo build --release --features view --bin gobo --target x86_64-pc-windows-gnu
# The one part in C++ is only compiled where there is an SDK: for its types a compiler that writes nothing is enough.
printf '#!/bin/bash\nwhile [ $# -gt 0 ]; do case $1 in -o) touch "$2" ;; *.a) touch "$1" ;; esac; shift; done\n' >"$work/nothing"
chmod +x "$work/nothing"
env {CC,CXX,AR}_aarch64_apple_darwin="$work/nothing" SDKROOT="$work" \
  cargo check --release --features view --bin gobo --target aarch64-apple-darwin
echo "macOS, arm64: types are checked"

cp "$target/x86_64-pc-windows-gnu/release/gobo.exe" "$work"
cp "$(dirname "$(x86_64-w64-mingw32-g++-posix -print-file-name=libstdc++-6.dll)")"/lib{stdc++-6,gcc_s_seh-1}.dll "$work"
cp "$(x86_64-w64-mingw32-g++-posix -print-file-name=libwinpthread-1.dll)" "$work"
cd "$work"
# Wine before 8.19 lacks this library of Windows.
printf '#include <windows.h>\nBOOLEAN NTAPI SystemFunction036(PVOID, ULONG);\n
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE to, SIZE_T count) { return SystemFunction036(to, count); }\n' >random.c
x86_64-w64-mingw32-gcc -shared -o bcryptprimitives.dll random.c -ladvapi32
export WINEPREFIX=$work/wine WINEDEBUG=-all
windows() { xvfb-run -a -s "-screen 0 1280x800x24" wine gobo.exe "$@" 2>&1 | tr -d '\r' | grep -v '^X connection'; }

printf 'frames 3\nkey a\nframes 2\nkey c\nkey f12\nquit\n' >script
windows view plume_8k --technique avsm:size=64 --picture 320x180 --script script >said
command=$(grep '^gobo render' said)
# shellcheck disable=SC2086
windows ${command#gobo } -o windows.png >/dev/null
# shellcheck disable=SC2086
"$native" ${command#gobo } -o native.png
cmp gobo-view-00.png native.png
cmp windows.png native.png
echo "Windows, x86-64, in $(wine --version): the window's F12, render and the native render have the same bytes ($command)"
