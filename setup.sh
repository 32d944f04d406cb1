#!/usr/bin/env bash
# Installs what the build and the tests need beyond Rust. Safe to run again: it does nothing when nothing is missing.
#
#   ./setup.sh                       compiler, Vulkan loader, software driver, validation layer, shaderc
#   ./setup.sh --interlock-lavapipe  a newer software driver with fragment shader interlock, in a cache folder
#   ./setup.sh --swiftshader         another software driver, which has little beyond Vulkan 1.3, in a cache folder
set -euo pipefail

repo=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
shaderc="$repo/.shaderc" # .cargo/config.toml names it to the shaderc crate
cache="${XDG_CACHE_HOME:-${HOME:?setup.sh: set HOME or XDG_CACHE_HOME}/.cache}/gobo"
scratch=
trap '[ -z "$scratch" ] || rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

say() { echo "setup.sh: $*"; }
die() {
  echo "setup.sh: $*" >&2
  exit 1
}
have() { command -v "$1" >/dev/null 2>&1; }
on_apt() { have apt-get && have dpkg-query; }

# --- packages ---------------------------------------------------------------------------------------------------------

# Prints those of the packages that are not installed.
missing_packages() {
  local installed package
  installed=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "$@" 2>/dev/null || true)
  for package; do
    grep -qx "$package installed" <<<"$installed" || echo "$package"
  done
}

lists_fresh=
# Installs packages; returns 1 with apt's last error in $apt_error when that fails.
apt_install() {
  local sudo=() log
  if [ "$(id -u)" != 0 ]; then
    have sudo || die "missing packages: $*; run as root: apt-get install --no-install-recommends $*"
    sudo=(sudo)
  fi
  say "installing $*"
  log=$(mktemp)
  if [ -z "$lists_fresh" ]; then
    # A broken third-party source must not stop us: what counts is whether the packages are found.
    "${sudo[@]}" apt-get update -qq </dev/null >"$log" 2>&1 || say "apt-get update had errors; going on with the lists it has"
    lists_fresh=1
  fi
  if ! "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" </dev/null >"$log" 2>&1; then
    apt_error=$(grep '^E:' "$log" | tail -n 1 || true)
    rm -f "$log"
    return 1
  fi
  rm -f "$log"
}

# --- shaderc ----------------------------------------------------------------------------------------------------------

# True once a library that passed the check, or the decision to build from source, is in place. A link to a system
# library that has since gone counts as absent.
shaderc_ready() {
  local name
  for name in libshaderc_combined.a libshaderc.so libshaderc.dylib build-from-source; do
    [ -e "$shaderc/$name" ] && return 0
  done
  return 1
}

# Does a program that compiles a shader link with library $2 of folder $1, and run?
shaderc_links() {
  local flags=("-L$1" "-l$2" -pthread) prefix
  for prefix in "${VULKAN_SDK:-}" /usr/local /opt/homebrew; do
    [ -n "$prefix" ] && [ -e "$prefix/include/shaderc/shaderc.h" ] && flags+=("-I$prefix/include")
  done
  cat >"$scratch/probe.cc" <<'PROBE'
#include <shaderc/shaderc.h>
#include <cstring>
int main() {
  const char* text = "#version 450\nlayout(local_size_x = 8) in; void main() {}";
  shaderc_compiler_t compiler = shaderc_compiler_initialize();
  shaderc_compile_options_t options = shaderc_compile_options_initialize();
  shaderc_compile_options_set_optimization_level(options, shaderc_optimization_level_performance);
  shaderc_compilation_result_t result =
      shaderc_compile_into_spv(compiler, text, std::strlen(text), shaderc_compute_shader, "probe", "main", options);
  return shaderc_result_get_compilation_status(result) != shaderc_compilation_status_success;
}
PROBE
  c++ "$scratch/probe.cc" -o "$scratch/probe" "${flags[@]}" >/dev/null 2>&1 && "$scratch/probe" >/dev/null 2>&1
}

# The path of a library file, or nothing.
find_library() {
  local dir path
  for dir in "${VULKAN_SDK:+$VULKAN_SDK/lib}" /usr/local/lib /opt/homebrew/lib; do
    [ -n "$dir" ] && [ -e "$dir/$1" ] && echo "$dir/$1" && return
  done
  path=$(cc "-print-file-name=$1") # the bare name when the compiler's folders do not have it
  [ "$path" = "$1" ] || echo "$(cd "$(dirname "$path")" && pwd)/$1"
}

# Debian 12's shaderc lacks glslang's code, and the crate offers no way to name more libraries: one archive of all of
# them. Returns 1 when there is nothing to merge.
merge_shaderc() {
  local name path script=$'CREATE libshaderc_combined.a\n'
  mkdir "$scratch/merge"
  for name in shaderc_combined glslang MachineIndependent GenericCodeGen OSDependent OGLCompiler HLSL SPIRV \
    SPIRV-Tools-opt SPIRV-Tools; do
    path=$(find_library "lib$name.a")
    if [ -z "$path" ]; then
      [ "$name" != shaderc_combined ] || return 1
      continue # newer glslang has fewer libraries; the link check judges the result
    fi
    # ar's script language has no quoting, so it sees plain names in its own folder only.
    ln -s "$path" "$scratch/merge/$name.a"
    script+="ADDLIB $name.a"$'\n'
  done
  script+=$'SAVE\nEND\n'
  (cd "$scratch/merge" && ar -M <<<"$script") >/dev/null 2>&1 || return 1
  mkdir "$scratch/merged" && mv "$scratch/merge/libshaderc_combined.a" "$scratch/merged/"
}

prepare_shaderc() {
  local library path ready
  scratch=$(mktemp -d "$repo/.shaderc.XXXXXX")
  ready="$scratch/ready"
  mkdir "$ready"
  # The system's own library where it works. Only the one file is linked: the crate would prefer a broken static library
  # that lies beside a working shared one.
  for library in libshaderc.so libshaderc.dylib libshaderc_combined.a; do
    path=$(find_library "$library")
    [ -n "$path" ] || continue
    ln -s "$path" "$ready/$library"
    library=${library#lib}
    if shaderc_links "$ready" "${library%.*}"; then
      say "shaderc: using $path"
      break
    fi
    rm "$ready/lib$library"
  done
  if [ -z "$(ls "$ready")" ]; then
    if merge_shaderc && shaderc_links "$scratch/merged" shaderc_combined; then
      mv "$scratch/merged/libshaderc_combined.a" "$ready/"
      say "shaderc: the system's library does not link by itself; merged it with glslang and SPIRV-Tools in .shaderc"
    else
      echo "No system shaderc passed setup.sh's link check. Remove this folder to look again." >"$ready/build-from-source"
      say "shaderc: no system library links; cargo will build it from source (about 6 minutes, once)"
    fi
  fi
  rm -rf "$shaderc"
  mv "$ready" "$shaderc"
  rm -rf "$scratch"
  scratch=
}

# The tools for building shaderc from source.
source_tools() {
  local tool
  for tool in cmake make python3 git; do
    have "$tool" || echo "$tool"
  done
}

# --- ./setup.sh -------------------------------------------------------------------------------------------------------

setup_apt() {
  local need=()
  have cc && have c++ && have ar || need+=(g++)
  mapfile -t -O "${#need[@]}" need < <(missing_packages libvulkan1 mesa-vulkan-drivers vulkan-validationlayers)
  if [ "${#need[@]}" != 0 ]; then
    apt_install "${need[@]}" || die "could not install ${need[*]} (${apt_error:-apt-get failed}); install them by hand and run setup.sh again"
  fi
  # One test asks it what other languages look-ups compile to, and stands aside without it.
  if ! have spirv-cross; then
    apt_install spirv-cross || say "could not install spirv-cross (${apt_error:-apt-get failed}); going on without"
  fi
  # Another opens the report in it, and fails without.
  if ! have chromium && ! have chromium-browser && ! have google-chrome; then
    apt_install chromium || say "could not install chromium (${apt_error:-apt-get failed}); going on without"
  fi
  # The window's tests open it in a virtual X server, with what opens windows in one.
  mapfile -t need < <(missing_packages xvfb libxkbcommon-x11-0 libxcursor1 libxi6 libxrandr2 libx11-xcb1)
  if [ "${#need[@]}" != 0 ]; then
    apt_install "${need[@]}" || say "could not install ${need[*]} (${apt_error:-apt-get failed}); going on without"
  fi
  if ! shaderc_ready; then
    mapfile -t need < <(missing_packages libshaderc-dev glslang-dev spirv-tools)
    if [ "${#need[@]}" != 0 ]; then
      apt_install "${need[@]}" || say "could not install ${need[*]} (${apt_error:-apt-get failed}); going on without"
    fi
    prepare_shaderc
  fi
  if [ -e "$shaderc/build-from-source" ]; then
    mapfile -t need < <(source_tools)
    if [ "${#need[@]}" != 0 ]; then
      apt_install "${need[@]}" || die "could not install ${need[*]} (${apt_error:-apt-get failed}), needed to build shaderc from source; install them by hand"
    fi
  fi
}

# No apt: look, say what is missing, install nothing.
setup_elsewhere() {
  local lacking=() hint
  case "$(uname -s)" in
    Darwin) hint="install the Xcode command line tools and the Vulkan SDK (vulkan.lunarg.com), which brings MoltenVK and shaderc, and source its setup-env.sh" ;;
    Linux) hint="install from your distribution: a C++ compiler, the Vulkan loader, a Vulkan driver (Mesa's lavapipe is the software one), the Khronos validation layer, and shaderc with its headers or cmake + python3 + git" ;;
    *) hint="install a C++ compiler and the Vulkan SDK (vulkan.lunarg.com), and set SHADERC_LIB_DIR to the SDK's Lib folder" ;;
  esac
  if have cc && have c++; then
    # A Mac's Vulkan SDK or the distribution may have been installed since we last fell back.
    rm -f "$shaderc/build-from-source"
    if [ -z "${SHADERC_LIB_DIR:-}" ] && ! shaderc_ready; then prepare_shaderc; fi
    if [ -e "$shaderc/build-from-source" ] && [ -n "$(source_tools)" ]; then
      lacking+=("shaderc, or to build it: $(source_tools | xargs)")
    fi
    [ -n "$(find_library libvulkan.so.1)$(find_library libvulkan.dylib)" ] || lacking+=("the Vulkan loader")
  else
    lacking+=("a C and C++ compiler")
  fi
  [ "${#lacking[@]}" = 0 ] || die "missing ${lacking[*]}; $hint"
}

# --- ./setup.sh --interlock-lavapipe ----------------------------------------------------------------------------------

# Debian 12's lavapipe has no fragment shader interlock; Mesa 26.1 in Debian 13's backports has, but needs a newer libc.
# So the driver and all it depends on go into a folder of their own, and programs start through that folder's ld.so.
# apt resolves, downloads and verifies them with a state of its own; the system's packages stay as they are.
interlock_lavapipe() {
  local home="$cache/interlock-lavapipe" keyring=/usr/share/keyrings/debian-archive-keyring.gpg arch
  if [ ! -e "$home/tree" ]; then
    on_apt && have dpkg-deb || die "--interlock-lavapipe unpacks Debian packages: it needs apt-get and dpkg-deb; elsewhere use Mesa 26.1 or later"
    arch=$(dpkg --print-architecture)
    [ -e "$keyring" ] || apt_install debian-archive-keyring || die "no Debian archive keys; install the package debian-archive-keyring"
    mkdir -p "$cache" 2>/dev/null || die "cannot create $cache; set XDG_CACHE_HOME to a folder that can be written"
    # One at a time; the lock is also why a left-over of a killed run can be removed.
    exec 9>"$cache/interlock-lavapipe.lock"
    flock 9
  fi
  if [ ! -e "$home/tree" ]; then
    local apt start=$SECONDS deb
    scratch="$cache/interlock-lavapipe.partial"
    rm -rf "$scratch"
    mkdir -p "$scratch"/{home/tree,apt/lists/partial,apt/cache/archives/partial}
    touch "$scratch/apt/status"
    cat >"$scratch/apt/sources.list" <<SOURCES
deb [arch=$arch signed-by=$keyring] http://deb.debian.org/debian trixie main
deb [arch=$arch signed-by=$keyring] http://deb.debian.org/debian trixie-backports main
SOURCES
    # An empty status file makes apt take everything down to libc. The system's apt.conf stays in force: it may name a proxy.
    apt=(apt-get -qq
      -o "Dir::State=$scratch/apt" -o "Dir::State::lists=$scratch/apt/lists" -o "Dir::State::status=$scratch/apt/status"
      -o "Dir::Cache=$scratch/apt/cache" -o "Dir::Cache::archives=$scratch/apt/cache/archives"
      -o "Dir::Etc::sourcelist=$scratch/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null
      -o Dir::Etc::preferences=/dev/null -o Dir::Etc::preferencesparts=/dev/null
      -o Acquire::Languages=none -o Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false -o Acquire::Retries=3
      -o Acquire::AllowInsecureRepositories=false -o APT::Get::AllowUnauthenticated=false
      -o APT::Update::Error-Mode=any -o APT::Sandbox::User=root)
    say "interlock lavapipe: downloading Debian 13's Mesa and what it depends on (about 80 MB)"
    "${apt[@]}" update </dev/null >"$scratch/log" 2>&1 ||
      die "interlock lavapipe: no package index ($(grep '^E:' "$scratch/log" | head -n 1)); check the network to deb.debian.org"
    "${apt[@]}" install --download-only -y --no-install-recommends -t trixie-backports \
      mesa-vulkan-drivers vulkan-validationlayers libvulkan1 </dev/null >"$scratch/log" 2>&1 ||
      die "interlock lavapipe: download failed ($(grep '^E:' "$scratch/log" | head -n 1)); run it again, or check the disk and the network"
    for deb in "$scratch"/apt/cache/archives/*.deb; do
      dpkg-deb -x "$deb" "$scratch/home/tree" || die "interlock lavapipe: cannot unpack ${deb##*/}; is the disk full?"
      basename "$deb" .deb >>"$scratch/home/packages.txt"
    done
    rm -rf "$home"
    mv "$scratch/home" "$home"
    rm -rf "$scratch"
    scratch=
    say "interlock lavapipe: $(grep mesa-vulkan "$home/packages.txt") unpacked in $((SECONDS - start)) s"
  fi
  write_runner "$home"
  say "interlock lavapipe: start programs with $home/run"
}

# Written on every run, so that a new setup.sh needs no new download.
write_runner() {
  local home=$1 lib loader driver
  driver=$(echo "$home"/tree/usr/lib/*-linux-gnu*/libvulkan_lvp.so)
  lib=${driver%/*}
  loader=$(echo "$lib"/ld-linux*.so.*)
  [ -e "$driver" ] && [ -e "$loader" ] || die "interlock lavapipe: $home is incomplete; remove it and run this again"
  cat >"$home/lvp_icd.json.new" <<ICD
{ "file_format_version": "1.0.0", "ICD": { "library_path": "$driver", "api_version": "1.3.0" } }
ICD
  cat >"$home/run.new" <<RUNNER
#!/bin/sh
# run PROGRAM ARGS...: starts a program on the unpacked lavapipe. Written by setup.sh.
# Only the program started here gets the unpacked libraries: a child process has to be started through GOBO_RUNNER too.
# (The program sees the loader as its own executable, so it cannot start itself by that path.)
home='$home'
export GOBO_RUNNER="\$home/run"
export VK_DRIVER_FILES="\$home/lvp_icd.json" VK_ICD_FILENAMES="\$home/lvp_icd.json"
export VK_LAYER_PATH="\$home/tree/usr/share/vulkan/explicit_layer.d"
# The system's implicit layers are built for the system's libraries.
export VK_IMPLICIT_LAYER_PATH="\$home/tree/usr/share/vulkan/implicit_layer.d"
program=\$(command -v -- "\${1:?usage: run PROGRAM ARGS...}") || { echo "run: \$1: not found" >&2; exit 127; }
shift
exec '$loader' --library-path '$lib' "\$program" "\$@"
RUNNER
  chmod +x "$home/run.new"
  mv "$home/lvp_icd.json.new" "$home/lvp_icd.json"
  mv "$home/run.new" "$home/run"
}

# --- ./setup.sh --swiftshader -----------------------------------------------------------------------------------------

# SwiftShader comes with Chromium; of its package one library is kept, which needs no more than a libc.
swiftshader() {
  local home="$cache/swiftshader" library deb
  library="$home/libvk_swiftshader.so"
  if [ ! -e "$library" ]; then
    on_apt && have dpkg-deb || die "--swiftshader unpacks a Debian package: it needs apt-get and dpkg-deb; elsewhere take libvk_swiftshader.so from a Chromium"
    mkdir -p "$cache" 2>/dev/null || die "cannot create $cache; set XDG_CACHE_HOME to a folder that can be written"
    exec 9>"$cache/swiftshader.lock"
    flock 9
  fi
  if [ ! -e "$library" ]; then
    scratch="$cache/swiftshader.partial"
    rm -rf "$scratch"
    mkdir -p "$scratch/home"
    say "swiftshader: downloading Debian's chromium-common (about 30 MB)"
    download_chromium_common ||
      die "swiftshader: no chromium-common ($(grep '^E:' "$scratch/log" | head -n 1)); run apt-get update, or check the network"
    deb=$(echo "$scratch"/chromium-common_*.deb)
    dpkg-deb -x "$deb" "$scratch/tree" || die "swiftshader: cannot unpack ${deb##*/}; is the disk full?"
    mv "$scratch/tree/usr/lib/chromium/libvk_swiftshader.so" "$scratch/home/" 2>/dev/null ||
      die "swiftshader: ${deb##*/} holds no libvk_swiftshader.so"
    basename "$deb" .deb >"$scratch/home/packages.txt"
    rm -rf "$home"
    mv "$scratch/home" "$home"
    rm -rf "$scratch"
    scratch=
    say "swiftshader: unpacked from $(cat "$home/packages.txt")"
  fi
  cat >"$home/icd.json.new" <<ICD
{ "file_format_version": "1.0.0", "ICD": { "library_path": "$library", "api_version": "1.3.0" } }
ICD
  mv "$home/icd.json.new" "$home/icd.json"
  say "swiftshader: start programs with VK_DRIVER_FILES=$home/icd.json"
}

# From the system's own sources; package lists that are out of date name files that are gone.
download_chromium_common() {
  local sudo=()
  (cd "$scratch" && apt-get -qq -o APT::Sandbox::User=root download chromium-common </dev/null >log 2>&1) && return
  [ "$(id -u)" = 0 ] || sudo=(sudo)
  "${sudo[@]}" apt-get update -qq </dev/null >/dev/null 2>&1 || true
  (cd "$scratch" && apt-get -qq -o APT::Sandbox::User=root download chromium-common </dev/null >log 2>&1)
}

case "${1:-}" in
  '')
    if on_apt; then setup_apt; else setup_elsewhere; fi
    say "ready"
    ;;
  --interlock-lavapipe) interlock_lavapipe ;;
  --swiftshader) swiftshader ;;
  *) die "unknown argument $1; usage: setup.sh [--interlock-lavapipe | --swiftshader]" ;;
esac
