#!/usr/bin/env bash
# `downrange experiment faults` on twelve scenarios that must be as expected, one seed each; that its alarm rings: an expectation that
# cannot be met, and a catalogue that is wrong; and that a fault put into a recorded flight is the fault put into the simulated one.
# usage: faults_test.sh DOWNRANGE_DIR SOURCE_DIR
set -uo pipefail

downrange=$1/downrange
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
  echo "FAILED: $1"
  sed 's/^/    /' <<< "$2" | tail -60
  failures=$((failures + 1))
}

# A comma-separated list. As the service learns to arbitrate, the harder ones move up here.
twelve=gps-frozen@150/2,gps-step-5000@150/2,gps-ramp-20@150/3,gps-velocity-sign@150/2,radar-lost@150/2,all-lost@290/2,feet@150/2,azimuth-sign@290/3,side-lobe@150/2
twelve+=,radar-clock-1-slow@290/2,gps-step-200@290/3,outliers-5-percent@290/2

output=$("$downrange" experiment faults --only "$twelve" --runs 1 --json "$work/faults.json" --html "$work/faults.html" 2>&1) ||
  fail "the twelve are not as expected" "$output"
grep -q '12.00' <<< "$(grep 'scenarios flown' <<< "$output")" || fail "not twelve were flown" "$output"
grep -q '"expected": "met' "$work/faults.json" || fail "the JSON does not say what was met" "$(head -c 2000 "$work/faults.json")"
[ "$(grep -c '<figure' "$work/faults.html")" -ge 12 ] || fail "the page has no plots" ""
# At the antennas: a radar that is lost costs nothing; where every source is silent the mounts stand, and the table says for how long.
antennas=$(sed -n '/^The same at the antennas/,/^catalogue/p' <<< "$output")
awk '$1 == "radar-lost@150/2" { lost = $2 } $1 == "all-lost@290/2" { blind = $2; withheld = $4 }
  $1 == "all" { all = $2 } END { exit !(lost == 100 && blind > 55 && blind < 80 && withheld > 50 && withheld < 60 && all > blind) }' \
  <<< "$antennas" || fail "what the mounts made of it is not told" "$antennas"
grep -q '"withheld s": 5[0-9]' "$work/faults.json" || fail "the JSON does not tell of the antennas" "$antennas"

# A limit that cannot be held.
faults=$source/tools/scenarios/faults
cat > "$work/strict.toml" << EOF
scenario = "$faults/launch.toml"
range = "$faults/range.toml"
[[fault]]
name = "strict"
what = "GPS jumps by 5 km"
begin_s = [90.0]
lasts_s = 10
liars = ["gps"]
[[fault.do]]
kind = "displace"
sources = ["gps"]
east_m = 5000
[fault.expect]
error_m = 0.001
EOF
status=0
output=$("$downrange" experiment faults --faults "$work/strict.toml" --runs 1 2>&1) || status=$?
[ "$status" = 1 ] && grep -q 'strict@90.0/2: worst [0-9]* m, allowed 0.001 m' <<< "$output" ||
  fail "an expectation that cannot be met: exit $status" "$output"

# Mounts that nobody commands for half a minute are not on target, whatever is expected of the track.
sed -e 's/^name = .*/name = "blind"/; s/^lasts_s = .*/lasts_s = 30/; /^liars/d; s/"displace"/"silence"/; s/sources = .*/sources = ["all"]/' \
  -e '/^east_m/d; s/^error_m = .*/on_target_share = 0.99/' "$work/strict.toml" > "$work/blind.toml"
status=0
output=$("$downrange" experiment faults --faults "$work/blind.toml" --runs 1 2>&1) || status=$?
[ "$status" = 1 ] && grep -q 'blind@90.0/2: mounts [0-9.]* % of the time on target, at least 99 % expected' <<< "$(tr -s ' \n' ' ' <<< "$output")" ||
  fail "mounts that stand: exit $status" "$output"

sed -i 's/kind = "displace"/kind = "misplace"/' "$work/strict.toml"
status=0
output=$("$downrange" experiment faults --faults "$work/strict.toml" 2>&1) || status=$?
[ "$status" != 0 ] && grep -q 'strict.toml:10: fault.do.kind: "misplace" is no fault' <<< "$output" ||
  fail "a catalogue that is wrong: exit $status" "$output"

# Into the flight as it is simulated, or into its archive: the same flight.
sed -e "s/^end_s = .*/end_s = 120/" -e "s/to_s = 480/to_s = 120/" "$faults/launch.toml" > "$work/launch.toml"
fault=(--faults "$faults/catalogue.toml" --fault gps-ramp-20 --fault-begin 30)
output=$("$downrange" simulate "$faults/range.toml" --scenario "$work/launch.toml" --archive "$work/healthy.mcap" 2>&1 &&
  "$downrange" simulate "$faults/range.toml" --scenario "$work/launch.toml" "${fault[@]}" --archive "$work/faulty.mcap" 2>&1 &&
  "$downrange" replay "$work/healthy.mcap" "${fault[@]}" --out "$work/a.mcap" 2>&1 &&
  "$downrange" replay "$work/faulty.mcap" --out "$work/b.mcap" 2>&1 &&
  "$downrange" replay "$work/healthy.mcap" --out "$work/c.mcap" 2>&1 &&
  "$downrange" diff "$work/a.mcap" "$work/b.mcap" 2>&1) || fail "a fault over a recorded flight is not the simulated one" "$output"
"$downrange" diff "$work/a.mcap" "$work/c.mcap" > /dev/null 2>&1 && fail "the fault changed nothing" ""

[ "$failures" -eq 0 ] && echo "faults: the twelve are as expected, and the alarms ring"
exit $((failures > 0))
