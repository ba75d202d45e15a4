#!/usr/bin/env bash
# What `downrange` says when something is wrong: a clear message, the right exit code, never a crash.
# usage: command_fault_test.sh DOWNRANGE_DIR SOURCE_DIR DOWNRANGED_DIR
set -uo pipefail

downrange=$1/downrange
source=$2
downranged=$3/downranged
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

# expect CODE TEXT COMMAND...: the exit code, and TEXT somewhere in what is printed.
expect() {
  local code=$1 text=$2
  shift 2
  local printed status
  printed=$("$@" 2>&1)
  status=$?
  if [[ $status != "$code" || $printed != *"$text"* ]]; then
    echo "FAILED: $*"
    echo "  exit $status, wanted $code; printed, wanted '$text':"
    sed 's/^/    /' <<< "$printed" | head -12
    failures=$((failures + 1))
  fi
}

naro=$source/config/naro.toml
launch=$source/tools/scenarios/launch.toml
expect 2 "FILE" "$downrange" check
expect 2 "absent.toml" "$downrange" check "$work/absent.toml"
sed 's/^sigma_range_m = .*/sigma_range_m = -3/' "$naro" > "$work/bad.toml"
expect 2 "sigma_range_m" "$downrange" check "$work/bad.toml"
# What is allowed but hardly meant is a warning; a range without a bus is one until something talks.
sed -e '/^id = "jeju-tgs"/,/^height_m/ s/^longitude_deg = .*/longitude_deg = -126.366/' "$naro" > "$work/odd.toml"
cp "$source/config/dds-qos.xml" "$work"
expect 0 "odd.toml:" "$downrange" check "$work/odd.toml"
expect 0 "the longitude's sign?" "$downrange" check "$work/odd.toml"
expect 0 "" bash -c "[[ \$('$downrange' check '$work/odd.toml' 2> /dev/null) != *warning* ]]"
sed -e '/^\[dds\]/,/^peers/d' "$naro" > "$work/no_bus.toml"
expect 0 "valid" "$downrange" check "$work/no_bus.toml"
expect 2 "dds: missing" "$downrange" watch "$work/no_bus.toml" --plain --idle 1
expect 2 "absent.mcap" "$downrange" replay "$work/absent.mcap" --config "$work/absent.mcap"
expect 1 "absent.mcap" "$downrange" replay "$work/absent.mcap" --config "$naro"
expect 2 "--rate" "$downrange" simulate "$naro" --scenario "$launch" --archive "$work/x.mcap" --rate fast
expect 2 "where the flight shall go" "$downrange" simulate "$naro" --scenario "$launch"
expect 1 "absent-scenario" "$downrange" simulate "$naro" --scenario "$work/absent-scenario" --archive "$work/x.mcap"
expect 2 "dds.domain" "$downrange" watch "$naro" --domain 1000
expect 1 "--clock range" "$downrange" simulate "$naro" --scenario "$launch" --dds --clock wall --rate 2

# Profiles of a bus that are not there are missed by whoever talks on it.
mkdir "$work/alone" && cp "$naro" "$work/alone"
expect 2 "dds-qos.xml\", no such file" "$downrange" check "$work/alone/naro.toml"
expect 2 "dds-qos.xml\", no such file" "$downrange" record "$work/alone/naro.toml" --out "$work/x.mcap" --duration 1
expect 2 "dds-qos.xml\", no such file" "$downrange" watch "$work/alone/naro.toml" --record "$work/x.mcap" --plain --idle 1
expect 0 "" bash -c "! ls '$work/x.mcap' 2> /dev/null"

expect 2 "launch" "$downrange" experiment nonesuch
expect 2 "NAME" "$downrange" experiment
expect 2 "allowed are" "$downrange" experiment launch --methods nonesuch
expect 2 "name one experiment" "$downrange" experiment all --methods joint
expect 2 "--runs" "$downrange" experiment launch --runs 0
expect 0 "runs; methods" "$downrange" experiment --list
expect 2 "not compared here" "$downrange" experiment alphabeta --methods exact,nonesuch
expect 2 "not compared here" "$downrange" experiment flights --methods ts
expect 2 "nothing is drawn" "$downrange" experiment flights --runs 3
expect 2 "nothing is drawn" "$downrange" experiment flights --seed 3
expect 2 "only experiment flights, honesty and without-gps" "$downrange" experiment alphabeta --data "$work"
expect 1 "there is no folder" "$downrange" experiment alphabeta --html "$work/absent/page.html"
expect 1 "no recorded flights in $work" "$downrange" experiment flights --data "$work"
expect 1 "no recorded flights in $work" env DOWNRANGE_DATA="$work" "$downrange" experiment flights
# One run reaches no statistical figure: exit code 1 is that, not the absent flights.
expect 1 "flights: left out, no recorded flights in $work" \
  env DOWNRANGE_DATA="$work" "$downrange" experiment all --runs 1

# Rules for a firewall, out of the configured peers alone; downranged looks at its own command line without starting.
expect 2 "dds.peers: none named" "$downrange" firewall "$naro" --for nftables
expect 2 "--for" "$downrange" firewall "$naro" --set 'dds.peers=["192.0.2.7"]'
expect 2 "allowed: a list of IP addresses" "$downrange" firewall "$naro" --for systemd --set 'dds.peers=["192.0.2.7\nUser=root"]'
expect 2 "dds: missing" "$downrange" firewall "$work/no_bus.toml" --for systemd
peers='dds.peers=["192.0.2.7", "2001:db8::/64"]'
expect 0 "udp dport != 7650-7899 accept" "$downrange" firewall "$naro" --for nftables --domain 1 --set "$peers"
expect 0 "udp dport != 65400-65535 accept" "$downrange" firewall "$naro" --for nftables --domain 232 --set "$peers"
expect 0 "elements = { 2001:db8::/64 }" "$downrange" firewall "$naro" --for nftables --set "$peers"
expect 0 $'IPAddressAllow=192.0.2.7\nIPAddressAllow=2001:db8::/64' "$downrange" firewall "$naro" --for systemd --set "$peers"
expect 0 "" "$downranged" --check --config "$naro" --stages ingest
expect 2 "sigma_range_m" "$downranged" --check --config "$work/bad.toml"
expect 2 "node.stages" "$downranged" --check --config "$naro" --stages nonesuch
expect 2 "dds: missing" "$downranged" --check --config "$work/no_bus.toml"

# A small flight to spoil.
sed -e 's/^end_s = .*/end_s = 60/' "$launch" > "$work/short.toml"
"$downrange" simulate "$naro" --scenario "$work/short.toml" --set ingest.expect_simulated=true \
  --archive "$work/good.mcap" || exit 1
expect 0 "events over" "$downrange" replay "$work/good.mcap" --out "$work/out.mcap"
expect 0 "events over" "$downrange" replay "$work/good.mcap" --config "$work/alone/naro.toml" \
  --set ingest.expect_simulated=true
expect 1 "holds no results" "$downrange" report "$work/good.mcap"
expect 1 "holds no true trajectory" "$downrange" report "$work/out.mcap" --truth "$work/good.mcap"
expect 2 "nonesuch" "$downrange" replay "$work/good.mcap" --methods nonesuch
expect 1 "identical" "$downrange" diff "$work/good.mcap" "$work/out.mcap"
expect 0 "identical" "$downrange" diff "$work/out.mcap" "$work/out.mcap"

# On the pad there are the vehicle's fixes, and the radars do not see it yet.
expect 1 "GO     goheung-tgs" "$downrange" preflight --archive "$work/good.mcap" --json "$work/preflight.json"
expect 1 "NO-GO: nothing heard" "$downrange" preflight --archive "$work/good.mcap" --seconds 5
expect 0 '"pad_sigmas"' cat "$work/preflight.json"
expect 1 "absent.mcap" "$downrange" preflight "$naro" --archive "$work/absent.mcap"
expect 2 "CONFIG or --archive" "$downrange" preflight
expect 1 "on the wall clock" "$downrange" preflight "$naro" --clock range

# Orders: what is missing or wrong is said before anything is sent.
expect 2 "--as" "$downrange" operator inhibit goheung --config "$naro" --reason x
expect 2 "--reason" "$downrange" operator inhibit goheung --config "$naro" --as kim
expect 2 "1 to 31 characters" "$downrange" operator inhibit goheung --config "$naro" --reason x --as ""
expect 2 "--at" "$downrange" operator mission planned --config "$naro" --at tomorrow
expect 2 "--at" "$downrange" operator mission planned --config "$naro" --at 2026-11-26T06:00:00
expect 1 "wall clock" "$downrange" operator mission liftoff --config "$naro" --clock range
expect 2 "subcommand" "$downrange" operator

# Antennas without DDS: what is wrong is said before anything is moved or told.
sed -e '/^# \[antenna.rotctl\]/,/^# timeout_ms/ s/^# //' "$naro" > "$work/rotator.toml"
expect 0 "valid" "$downrange" check "$work/rotator.toml"
expect 2 "no antenna has a rotator" "$downrange" rotctl "$naro"
expect 2 'antenna: "jeju-tm" has no rotator' "$downrange" rotctl "$work/rotator.toml" --antenna jeju-tm
expect 2 "'nonesuch': allowed is the id of an [[antenna]]" "$downrange" rotctl "$work/rotator.toml" --antenna nonesuch
expect 2 "clock.mode: found" "$downrange" rotctl "$work/rotator.toml" --clock range
expect 2 "'nonesuch': allowed is the id of an [[antenna]]" "$downrange" rotctld "$naro" nonesuch
expect 2 "--port" "$downrange" rotctld "$naro" goheung-tm --port 70000
expect 1 "192.0.2.1:4533: cannot be listened on" "$downrange" rotctld "$naro" goheung-tm --listen 192.0.2.1
expect 2 "clock.mode: found" "$downrange" rotctld "$naro" goheung-tm --clock range

head -c 30000 "$work/good.mcap" > "$work/cut.mcap"
expect 3 "cut off at byte" "$downrange" replay "$work/cut.mcap" --config "$naro" --set ingest.expect_simulated=true
expect 3 "events over" "$downrange" replay "$work/cut.mcap" --config "$naro" --set ingest.expect_simulated=true
cp "$work/good.mcap" "$work/flipped.mcap"
printf '\x55\xaa\x55\xaa' | dd of="$work/flipped.mcap" bs=1 seek=30000 conv=notrunc status=none
expect 1 "flipped.mcap" "$downrange" replay "$work/flipped.mcap" --config "$naro"
# A replay that fails leaves nothing that could be taken for a flight, and what was there before as it was.
expect 1 "never.mcap is not written" "$downrange" replay "$work/flipped.mcap" --config "$naro" --out "$work/never.mcap"
echo "older" > "$work/older.mcap"
expect 1 "older.mcap is not written" \
  "$downrange" replay "$work/flipped.mcap" --config "$naro" --out "$work/older.mcap" --force
expect 0 "older" cat "$work/older.mcap"
expect 1 "nothing of it is kept" bash -c "ulimit -f 16; '$downrange' replay '$work/good.mcap' --out '$work/never.mcap'"
expect 0 "" bash -c "! ls '$work'/never.mcap* '$work'/*.part 2> /dev/null"
# A wrong length in the middle of a file that was closed: damage, not a crash's loss.
cp "$work/good.mcap" "$work/length.mcap"
printf '\xff\xff\xff\x7f' | dd of="$work/length.mcap" bs=1 seek=9 conv=notrunc status=none
expect 1 "damaged at byte 8" "$downrange" replay "$work/length.mcap" --config "$naro"
# A message of a channel that no record declares: whoever needs all messages says that one is lost.
{ printf '\x89MCAP0\r\n\x01\x08\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x05\x16\0\0\0\0\0\0\0\x09\0' && head -c 20 /dev/zero
  printf '\x0f\x04\0\0\0\0\0\0\0\0\0\0\0\x02\x14\0\0\0\0\0\0\0' && head -c 20 /dev/zero
  printf '\x89MCAP0\r\n'; } > "$work/undeclared.mcap"
lost="1 message of channel 9"
expect 1 "it holds $lost" "$downrange" replay "$work/undeclared.mcap" --config "$naro"
expect 1 "undeclared.mcap: found $lost" "$downrange" report "$work/undeclared.mcap" --config "$naro"
expect 1 "undeclared.mcap: found $lost" "$downrange" report "$work/undeclared.mcap" --config "$naro" --calibration "$work/c"
expect 1 "undeclared.mcap: found $lost" "$downrange" diff "$work/out.mcap" "$work/undeclared.mcap"
expect 1 "it holds $lost" "$downrange" preflight "$naro" --archive "$work/undeclared.mcap"
echo "not an archive" > "$work/text.mcap"
expect 1 "text.mcap" "$downrange" replay "$work/text.mcap" --config "$naro"
expect 1 "No space left" "$downrange" replay "$work/good.mcap" --out /dev/full

# Judged as far as it goes: a flight with its truth, cut off.
"$downrange" simulate "$naro" --scenario "$work/short.toml" --set ingest.expect_simulated=true \
  --truth "$work/truth.mcap" || exit 1
head -c $(($(stat -c %s "$work/out.mcap") * 9 / 10)) "$work/out.mcap" > "$work/out_cut.mcap"
expect 0 "fused" "$downrange" report "$work/out.mcap" --truth "$work/truth.mcap" --json "$work/report.json"
expect 3 "is cut off at byte" "$downrange" report "$work/out_cut.mcap" --truth "$work/truth.mcap"

# The biases found, out and in again: what was flown with a calibration carries it along.
expect 0 "goheung: " "$downrange" report "$work/out.mcap" --calibration "$work/cal.toml"
expect 1 "exists already" "$downrange" report "$work/out.mcap" --calibration "$work/cal.toml"
expect 1 "holds no biases of method" "$downrange" report "$work/good.mcap" --calibration "$work/none.toml"
expect 1 "it has biases of: " "$downrange" report "$work/out.mcap" --calibration "$work/none.toml" --method uncorrected
expect 2 "nonesuch" "$downrange" report "$work/out.mcap" --calibration "$work/none.toml" --method nonesuch
expect 2 "--calibration" "$downrange" report "$work/out.mcap" --method joint
sed -e '0,/^calibration = ""/s//calibration = "cal.toml"/' -e 's/^bias_blocks = .*/bias_blocks = ["polar", "sez_offset", "sez_scale", "time"]/' \
  "$naro" > "$work/calibrated.toml"
expect 0 "valid" "$downrange" check "$work/calibrated.toml"
expect 0 "events over" "$downrange" replay "$work/good.mcap" --config "$work/calibrated.toml" \
  --set ingest.expect_simulated=true --methods joint --out "$work/calibrated.mcap"
mv "$work/cal.toml" "$work/moved.toml"
expect 2 "no such file" "$downrange" check "$work/calibrated.toml"
expect 0 "events over" "$downrange" replay "$work/calibrated.mcap" --out "$work/again.mcap"
expect 0 "identical" "$downrange" diff "$work/calibrated.mcap" "$work/again.mcap"

# A tracker is checked, calibrated, and told of by check as a radar is.
sed -e '/^# \[\[angle_sensor\]\]/,/^$/ s/^# //' "$naro" > "$work/tracked.toml"
{ cat "$work/short.toml" && printf '[[angle_sensor]]\nid = "goheung-optical-angles"\n[angle_sensor.bias]\nazimuth_deg = 0.02\n'; } \
  > "$work/tracked_launch.toml"
expect 0 "2 radars, 1 angle sensors" "$downrange" check "$work/tracked.toml"
expect 0 "1 angle sensors" "$downrange" simulate "$work/tracked.toml" --scenario "$work/tracked_launch.toml" \
  --set ingest.expect_simulated=true --archive "$work/tracked.mcap"
expect 0 "events over" "$downrange" replay "$work/tracked.mcap" --methods joint --out "$work/tracked_out.mcap"
expect 0 "goheung-optical-angles: 2 terms after" \
  "$downrange" report "$work/tracked_out.mcap" --calibration "$work/tracked_cal.toml"
expect 0 "[[angle_sensor.term]]" cat "$work/tracked_cal.toml"
sed -i '/^\[\[angle_sensor\]\]/,/^$/ s/^calibration = ""/calibration = "tracked_cal.toml"/' "$work/tracked.toml"
expect 0 "valid" "$downrange" check "$work/tracked.toml"
sed -i '/^\[\[angle_sensor/,$ { /"offset_elevation"/,$ { s/offset_elevation/scale_elevation/; s/^\(value\|sigma\)_deg/\1/ } }' \
  "$work/tracked_cal.toml"
expect 2 "angle_sensor[0].calibration" "$downrange" check "$work/tracked.toml"

# No file is lost to a slip of the keyboard.
cp "$work/good.mcap" "$work/kept.mcap"
ln -s "$work/good.mcap" "$work/link.mcap"
written_over="exists already; --force writes over it"
expect 1 "$written_over" "$downrange" replay "$work/good.mcap" --out "$work/out.mcap"
expect 0 "events over" "$downrange" replay "$work/good.mcap" --out "$work/out.mcap" --force
for same in "$work/good.mcap" "$work/../${work##*/}/good.mcap" "$work/link.mcap"; do
  expect 1 "is read as well" "$downrange" replay "$work/good.mcap" --out "$same"
  expect 1 "is read as well" "$downrange" replay "$work/good.mcap" --out "$same" --force
done
for option in --archive --truth; do
  expect 1 "$written_over" "$downrange" simulate "$naro" --scenario "$work/short.toml" $option "$work/good.mcap"
done
expect 1 "written twice" "$downrange" simulate "$naro" --scenario "$work/short.toml" \
  --archive "$work/new.mcap" --truth "$work/new.mcap"
expect 1 "is read as well" "$downrange" report "$work/out.mcap" --truth "$work/truth.mcap" --json "$work/out.mcap" --force
expect 1 "$written_over" "$downrange" watch "$naro" --record "$work/good.mcap"
cp "$source/tests/support/gps.map.toml" "$work/mapping.toml"
printf 't,lat,lon,h\n0,34.4319,127.5351,100\n' > "$work/gps.csv"
expect 0 "wrap_s" "$downrange" import --keys
expect 2 "MAPPING" "$downrange" import
expect 2 "--out" "$downrange" import "$work/mapping.toml"
printf 't,lat,lon,h\n0,?,0,0\n' > "$work/none.csv"
sed 's/gps.csv/none.csv/' "$work/mapping.toml" > "$work/none.toml"
expect 1 "none of its 1 rows can be imported" "$downrange" import "$work/none.toml" --out "$work/none.mcap"
expect 1 "line 2: lat: '?' is no value (columns: t, lat, lon, h)" "$downrange" import "$work/none.toml" --out "$work/none.mcap"
expect 1 "$written_over" "$downrange" import "$work/mapping.toml" --out "$work/good.mcap"
expect 1 "is read as well" "$downrange" import "$work/mapping.toml" --out "$work/gps.csv" --force
expect 0 "1 of 1 rows" "$downrange" import "$work/mapping.toml" --out "$work/imported.mcap"
cmp "$work/good.mcap" "$work/kept.mcap" || failures=$((failures + 1))

# A recording whose file is taken away goes on in another.
"$downrange" record "$naro" --domain 228 --out "$work/taken.mcap" --duration 5 2> "$work/record.log" &
recording=$!
until grep -q "^recording" "$work/record.log"; do sleep 0.1; done
rm "$work/taken.mcap"
wait "$recording"
expect 0 "recording goes on in $work/taken-2.mcap" cat "$work/record.log"
expect 0 "taken.mcap was removed or replaced: its 0 messages are lost" cat "$work/record.log"
expect 0 "0 messages in $work/taken-2.mcap" cat "$work/record.log"
[ -s "$work/taken-2.mcap" ] || failures=$((failures + 1))

"$downrange" watch "$naro" --domain 229 --plain --idle 4 --record "$work/seen.mcap" > /dev/null 2> "$work/watch.log" &
watching=$!
until [ -e "$work/seen.mcap" ]; do sleep 0.1; done
rm "$work/seen.mcap"
wait "$watching"
expect 0 "recording goes on in $work/seen-2.mcap" cat "$work/watch.log"
[ -s "$work/seen-2.mcap" ] || failures=$((failures + 1))

# A screen on a range that is silent from the start ends when told to.
expect 0 "nothing received yet" timeout 60 "$downrange" watch "$naro" --domain 229 --plain --idle 1.5

# A live node never takes simulated input: every message rejected, no track, no pointing.
expect 1 "0 downrange/slaving" "$downrange" replay "$work/good.mcap" --config "$naro"
expect 1 "measurements was accepted" "$downrange" replay "$work/good.mcap" --config "$naro"
expect 1 "is written: of each measurement, why it was rejected" \
  "$downrange" replay "$work/good.mcap" --config "$naro" --out "$work/rejected.mcap"
expect 1 "ingest.expect_simulated=true" "$downrange" replay "$work/good.mcap" --config "$naro"

# Files that are no files, and files that ask for more than there is.
mkfifo "$work/pipe"
for input in "$work" /dev/zero "$work/pipe"; do
  expect 2 ", not a file" timeout 20 "$downrange" check "$input"
  expect 1 ", not a file" timeout 20 "$downrange" simulate "$naro" --scenario "$input" --archive "$work/x.mcap"
  expect 1 ", not a file" timeout 20 "$downrange" import "$input" --out "$work/x.mcap"
  expect 1 ", not a file" timeout 20 "$downrange" replay "$input" --config "$naro"
done
{ for _ in {1..50000}; do printf 'a.'; done && echo 'a = 1'; } > "$work/deep.toml"
expect 2 "deep.toml:1: a key of more than 16 parts" "$downrange" check "$work/deep.toml"
expect 1 "deep.toml:1: a key of more than 16 parts" "$downrange" simulate "$naro" --scenario "$work/deep.toml" \
  --archive "$work/x.mcap"
expect 1 "deep.toml:1: a key of more than 16 parts" "$downrange" import "$work/deep.toml" --out "$work/x.mcap"
sed '0,/^azimuth_deg = .*/s//azimuth_deg = 9223372036854775807/' "$launch" > "$work/integer.toml"
expect 1 "integer.toml" "$downrange" simulate "$naro" --scenario "$work/integer.toml" --archive "$work/x.mcap"

[[ $failures == 0 ]] && echo "all as expected"
exit $((failures > 0))
