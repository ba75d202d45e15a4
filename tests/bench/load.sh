#!/usr/bin/env bash
# The run behind `tools/bench load`: a service on the wall clock, ten targets and antennas, five radars at 20 Hz that track every target
# (1000 plots a second), GPS of each. Sent as radars do; an observer counts the ticks.
# usage: load.sh BUILD_DIR SOURCE_DIR DOMAIN SECONDS METHOD
set -euo pipefail
build=$1
source=$2
domain=$3
run_s=$4
method=$5
# shellcheck source=tests/bench/live.sh
. "$(dirname "$0")/live.sh"
# shellcheck source=tests/bench/crowd.sh
. "$(dirname "$0")/crowd.sh"

crowd "$work" 10 5 20 10 "$((run_s + 20))"
printf '[dds]\ndomain = %s\nprofiles = "%s"\n' "$domain" "$source/config/dds-qos.xml" >>"$work/range.toml"
plots=$("$build/tests/bench/downrange_crowd" "$work/range.toml" "$work/scenario.toml" "$work/crowd.mcap")
printf '%s: 10 targets, 5 radars at 20 Hz, %s plots in %s s, on %s cores\n' "$method" "$plots" "$((run_s + 20))" "$(nproc)"

options=("$work/range.toml" --clock wall)
start_service "$build/src/app/downranged/downranged" --config "${options[@]}" --set "fuse.methods=[\"$method\"]" --archive "$work/flight.mcap"
service=$started
start radars "$build/src/app/downrange/downrange" replay "$work/crowd.mcap" --config "${options[@]}" --dds --rate 1
sleep 12 # they have met, and every target has its track

# CPU time of the service so far, in hundredths of a second.
used() { awk '{ print $14 + $15 }' "/proc/$service/stat"; }
before=$(used)
status=0
"$build/tests/bench/downrange_ticks" "$domain" "$source/config/dds-qos.xml" "$run_s" 25 || status=$?
printf 'CPU of the service: %s %% of a core\n' "$((($(used) - before) / run_s))"
for trouble in 'behind its clock' 'had expired' 'inputs lost' 'not written'; do # each is counted up: the last line tells
  grep "$trouble" "$work/service.log" | tail -n 1 | grep . && status=1
done
[ "$status" -eq 0 ] && printf 'every tick was met\n' || printf 'NOT every tick was met\n'
exit "$status"
