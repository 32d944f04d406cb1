#!/bin/bash
# Writes the NanoVDB test files into the folder $1 with NanoVDB 32.4.2, by nanovdb.cpp. It needs Debian 12 (bookworm) with
# g++ and zlib1g-dev; it installs nothing.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$(mkdir -p "$1" && cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -q -o APT::Sandbox::User=root libnanovdb-dev=10.0.1-2 libblosc-dev=1.21.3+ds-1 libblosc1=1.21.3+ds-1 \
    liblz4-1=1.9.4-1 libsnappy1v5=1.1.9-3 libzstd1=1.5.4+dfsg2-5
for package in *.deb; do dpkg -x "$package" root; done
libraries=root/usr/lib/x86_64-linux-gnu
g++ -std=c++17 -O1 -pthread -DNANOVDB_USE_ZIP -DNANOVDB_USE_BLOSC -isystem root/usr/include "$here/nanovdb.cpp" -o write \
    "$libraries/libblosc.so.1" -Wl,-rpath-link,"$libraries" -lz
LD_LIBRARY_PATH=$libraries ./write "$out" "${@:2}"
