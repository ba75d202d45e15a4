#!/usr/bin/env bash
# What `downrange report` says of flights that lack something: truth, radars, all but one sample. And that the flight
# begins with its first accepted measurement of any kind.
# usage: report_test.sh DOWNRANGE_DIR SOURCE_DIR
set -uo pipefail

downrange=$1/downrange
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
  echo "FAILED: $1"
  sed 's/^/    /' <<< "$2" | head -60
  failures=$((failures + 1))
}

# report FLIGHT OPTION...: exit 0, no "nan" or "inf" in text or JSON. Sets `printed` and `json`.
report() {
  local status=0
  rm -f "$work/report.json"
  printed=$("$downrange" report "$@" --json "$work/report.json" 2>&1) || status=$?
  json=$(cat "$work/report.json" 2> /dev/null)
  [[ $status == 0 ]] || fail "report $* exits with $status" "$printed"
  ! grep -qiwE 'nan|inf' <<< "$printed$json" || fail "report $* prints what is no number" "$printed"
}
says() { grep -qE -- "$1" <<< "$printed" || fail "the report does not say '$1'" "$printed"; }
says_not() { ! grep -qE -- "$1" <<< "$printed" || fail "the report says '$1'" "$printed"; }
json_says() { grep -qE -- "$1" <<< "$json" || fail "the JSON does not say '$1'" "$json"; }

run() {
  local output
  output=$("$@" 2>&1) || fail "$*" "$output"
}

# A launch of 60 s: the vehicle's GPS from 10 s before lift-off on, the radars from 20 and 48 s on.
sed -e 's/^end_s = .*/end_s = 60/' "$source/tools/scenarios/launch.toml" > "$work/launch.toml"
run "$downrange" simulate "$source/config/naro.toml" --scenario "$work/launch.toml" --set ingest.expect_simulated=true \
  --archive "$work/flight.mcap" --truth "$work/truth.mcap"
run "$downrange" replay "$work/flight.mcap" --out "$work/flown.mcap"

report "$work/flown.mcap" --truth "$work/truth.mcap"
says 'Position error against the truth'
says 'flight -1[01](\.[0-9]+)?-6[01]'
says '^fused \(joint\)'
says '^goheung alone'
says '^goheung-tgs'
says_not 'planted'
says_not 'No lift-off'
json_says '"truth": true'
json_says '"outliers_told_by": "truth"'

report "$work/flown.mcap"
says 'No true trajectory is known'
says '^fused \(joint\)'
says 'Systematic errors: not without a true trajectory'
says 'offset_range'
json_says '"truth": false'
json_says '"against_gps"'

# The same flight at a range that has no radar and no bus.
cat > "$work/gps_only.toml" << 'RANGE'
[range]
name = "gps-only"
[[target]]
id = "kslv"
[[telemetry]]
id = "goheung-tgs"
latitude_deg = 34.448
longitude_deg = 127.5165
height_m = 105
[[antenna]]
id = "dish"
latitude_deg = 34.4478
longitude_deg = 127.5168
height_m = 112
link_delay_ms = 5
lead_ms = 50
[ingest]
expect_simulated = true
RANGE
run "$downrange" check "$work/gps_only.toml"
run "$downrange" replay "$work/flight.mcap" --config "$work/gps_only.toml" --out "$work/gps_only.mcap"
report "$work/gps_only.mcap"
says 'No true trajectory is known'
says '^goheung-tgs +[1-9]'
says '^dish'
says_not 'alone'
report "$work/gps_only.mcap" --truth "$work/truth.mcap"
says 'no radar and no angle sensor is configured'
says '^dish +fused'

# One fix.
cp "$source/tests/support/gps.map.toml" "$work"
printf 't,lat,lon,h\n5,34.4319,127.5351,400\n' > "$work/gps.csv"
sed -e 's/expect_simulated = true/expect_simulated = false/' "$work/gps_only.toml" > "$work/one.toml"
run "$downrange" import "$work/gps.map.toml" --out "$work/one.mcap"
run "$downrange" replay "$work/one.mcap" --config "$work/one.toml" --out "$work/one_flown.mcap"
report "$work/one_flown.mcap"
says 'Nothing to judge in flight'
says '^goheung-tgs +1 '

# Nothing that was accepted: said, with the reasons.
"$downrange" replay "$work/flight.mcap" --config "$work/one.toml" --out "$work/rejected.mcap" > /dev/null 2>&1
printed=$("$downrange" report "$work/rejected.mcap" 2>&1) && fail "a flight without a measurement is judged" "$printed"
says 'no accepted measurement.*simulated_mismatch [1-9]'

[[ $failures == 0 ]] && echo "all as expected"
exit $((failures > 0))
