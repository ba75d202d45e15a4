# shellcheck shell=bash
# Shared by the scripts of this folder; sourced, not run. Gives ROOT (the repository) and JOBS (the machine's processors).

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
JOBS=$(nproc)

say() { printf '%s\n' "$*"; }
warn() { printf 'warning: %s\n' "$*" >&2; }
die() {
  printf 'error: %s\n' "$*" >&2
  exit 1
}

# Prints the comment at the head of the calling script: its help.
print_help() { sed -n '2,/^[^#]/{/^#/!d;s/^# \{0,1\}//;p}' "$0"; }

# Compiled objects are kept between builds where the home folder allows it.
use_ccache() {
  export CCACHE_DIR=${CCACHE_DIR:-${HOME:-/nonexistent}/.cache/ccache}
  if ! mkdir -p "$CCACHE_DIR" 2>/dev/null || [ ! -w "$CCACHE_DIR" ]; then
    warn "cannot write to CCACHE_DIR=$CCACHE_DIR: building without a compiler cache"
    export CCACHE_DISABLE=1
  fi
}

# build PRESET [TARGET...]: configures and builds; all targets when none is named.
build() {
  local preset=$1
  shift
  use_ccache
  mkdir -p "$ROOT/build"
  (cd "$ROOT" && cmake --preset "$preset" >"$ROOT/build/configure-$preset.log" 2>&1) || {
    tail -n 30 "$ROOT/build/configure-$preset.log" >&2
    die "cmake --preset $preset failed; all of its output is in build/configure-$preset.log"
  }
  (cd "$ROOT" && cmake --build --preset "$preset" --parallel "$JOBS" ${1:+--target "$@"}) ||
    die "the build of preset $preset failed"
}
