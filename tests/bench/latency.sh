#!/usr/bin/env bash
# The run behind `tools/bench latency`: the service on the wall clock with one method, the simulated radars of the benchmark's flight
# (two radars at about 20 Hz, GPS), a relay of the same plots, and an observer: four processes, one machine.
# usage: latency.sh BUILD_DIR SOURCE_DIR DOMAIN SECONDS
set -euo pipefail
build=$1
source=$2
domain=$3
run_s=$4
# shellcheck source=tests/bench/live.sh
. "$(dirname "$0")/live.sh"

# A plot is written when it is true: no delays. Rates that do not fit the tick's 40 Hz: the plots come at any phase of it.
sed -E "s/^(latency|delay)(_jitter)?_ms = .*/\1\2_ms = 0/; s/^(end|to)_s = .*/\1_s = $((run_s + 15))/; \
  0,/^rate_hz = 20/s//rate_hz = 19.7/; s/^rate_hz = 20\$/rate_hz = 20.3/" "$source/tools/scenarios/bench.toml" >"$work/flight.toml"
options=("$source/config/naro.toml" --set ingest.expect_simulated=true --clock wall --domain "$domain")
profiles=$source/config/dds-qos.xml
latency=$build/tests/bench/downrange_latency

start relay "$latency" relay "$domain" "$profiles"
start_service "$build/src/app/downranged/downranged" --config "${options[@]}" --set 'fuse.methods=["joint"]' --archive "$work/flight.mcap"
start radars "$build/src/app/downrange/downrange" simulate "${options[@]}" --dds --scenario "$work/flight.toml"
sleep 10 # they have met, and fly
"$latency" observe "$domain" "$profiles" "$run_s" || fail "nothing to measure"
