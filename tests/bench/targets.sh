#!/usr/bin/env bash
# The run behind `tools/bench targets`: CPU time per plot of a replay of 10, 100, 1000 targets, or as many as are named, each tracked by two
# radars at 5 Hz and by GPS; beside that of the first.
# usage: targets.sh BUILD_DIR SECONDS METHOD TARGETS...
set -euo pipefail
build=$1
run_s=$2
method=$3
shift 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# shellcheck source=tests/bench/crowd.sh
. "$(dirname "$0")/crowd.sh"

TIMEFORMAT='%U %S'
# CPU time of a command, in us; what it prints goes nowhere.
cpu_us() {
  { time "$@" >"$work/log" 2>&1; } 2>"$work/time" || { cat "$work/log" >&2 && exit 1; }
  awk '{ printf "%d\n", 1e6 * ($1 + $2) }' "$work/time"
}

printf '%-12s %8s %9s %12s %6s\n' "$method" targets plots 'us/plot' ratio
first=
for targets in "$@"; do
  crowd "$work" "$targets" 2 5 4 "$run_s"
  plots=$("$build/tests/bench/downrange_crowd" "$work/range.toml" "$work/scenario.toml" "$work/crowd.mcap")
  us=$(cpu_us "$build/src/app/downrange/downrange" replay "$work/crowd.mcap" --methods "$method")
  : "${first:=$((1000 * us / plots))}"
  awk -v us="$us" -v plots="$plots" -v first="$first" -v targets="$targets" \
    'BEGIN { printf "%-12s %8d %9d %12.1f %6.2f\n", "", targets, plots, us / plots, 1000 * us / plots / first }'
done
