#!/usr/bin/env bash
# An antenna without DDS, with Hamlib's own programs: its dummy rotator (rotctld -m 1) follows a flight through
# `downrange rotctl`, is killed and comes back; its client (rotctl -m 2) asks `downrange rotctld` where the antenna points.
# usage: rotctl_test.sh DOWNRANGE_DIR DOWNRANGED_DIR SOURCE_DIR DOMAIN
set -euo pipefail
downrange=$1/downrange
downranged=$2/downranged
source=$3
domain=$4
work=$(mktemp -d)
pids=()
cleanup() {
  for pid in "${pids[@]}"; do kill -KILL "$pid" 2>/dev/null || true; done
  rm -rf "$work"
}
trap cleanup EXIT
fail() {
  echo "FAILED: $*"
  tail -n 15 "$work"/*.log
  exit 1
}
# until_logged TEXT FILE [COUNT]: so often.
until_logged() {
  for _ in {1..400}; do
    [ "$(grep -c -- "$1" "$2" 2>/dev/null || true)" -ge "${3:-1}" ] && return
    sleep 0.1
  done
  fail "no '$1' in $(basename "$2")"
}
# A daemon that takes port $port; false: it is taken.
start_rotator() {
  rotctld -m 1 -T 127.0.0.1 -t "$port" >>"$work/hamlib.log" 2>&1 &
  rotator=$!
  pids+=($rotator)
  for _ in {1..100}; do
    kill -0 "$rotator" 2>/dev/null || return 1
    (: <>"/dev/tcp/127.0.0.1/$port") 2>/dev/null && return
    sleep 0.1
  done
  return 1
}
ask() { timeout 10 rotctl -m 2 -r "$1" "${@:2}"; }
# Azimuth and elevation of the rotator at $1, whole degrees.
pointing() { ask "$1" p | awk '{ printf "%.0f ", $1 }'; }

for attempt in {1..20}; do
  port=$((20000 + (RANDOM + attempt) % 10000))
  start_rotator && break
done

# From the south the vehicle stands in the north: the dummy turns 6 deg a second.
mkdir "$work/range"
cp "$source/config/dds-qos.xml" "$work/range"
sed -e 's/^latitude_deg = 34.4478 .*/latitude_deg = 34.25/' -e "s/^domain = .*/domain = $domain/" \
  -e 's/^azimuth_min_deg = -270  .*/azimuth_min_deg = -180/' \
  -e '/^# \[antenna.rotctl\]/,/^# timeout_ms/ s/^# //' -e "s/^port = 4533 .*/port = $port/" \
  "$source/config/naro.toml" >"$work/range/my-range.toml"
grep -q "^port = $port" "$work/range/my-range.toml" || fail "config/naro.toml has no example of [antenna.rotctl] any more"
cd "$work/range"
live=(--clock wall --set ingest.expect_simulated=true)
"$downrange" import "$source/tools/examples/flight/mapping.toml" --out flight.mcap

"$downranged" --config my-range.toml "${live[@]}" >"$work/service.log" 2>&1 &
pids+=($!)
service=$!
"$downrange" rotctl my-range.toml "${live[@]}" >"$work/rotctl.log" 2>&1 &
pids+=($!)
rotctl=$!
"$downrange" rotctld my-range.toml goheung-tm --port 0 "${live[@]}" >"$work/rotctld.log" 2>&1 &
pids+=($!)
rotctld=$!
until_logged "connected, rotator model 1: azimuth -180 to 450, elevation 0 to 90 deg" "$work/rotctl.log"
until_logged "is told on 127.0.0.1:" "$work/rotctld.log"
told=127.0.0.1:$(sed -n 's/.*is told on 127.0.0.1:\([0-9]*\).*/\1/p' "$work/rotctld.log")

echo "== nothing is told while no command holds, and nothing is moved"
ask "$told" p >"$work/ask.log" 2>&1 && fail "a pointing before the flight"
grep -q "Feature not available" "$work/ask.log" || fail "no reason"
ask "$told" P 10 20 >"$work/ask.log" 2>&1 && fail "a tracker moved the antenna"
grep -q "Feature not available" "$work/ask.log" || fail "no reason"
ask "$told" S >"$work/ask.log" 2>&1 && fail "a tracker stopped the antenna"
ask "$told" _ | grep -q "commands to goheung-tm" || fail "no information"

echo "== a flight"
"$downrange" replay flight.mcap --config my-range.toml "${live[@]}" --dds --rate 1 >"$work/replay.log" 2>&1 &
pids+=($!)
replay=$!
until_logged "follows its commands" "$work/rotctl.log"
same=no
for _ in {1..200}; do
  # Within a degree: the dummy's own, which creeps up on its target.
  same=$(paste -d' ' <(pointing "127.0.0.1:$port") <(pointing "$told") | awk '{
    apart = ($1 - $3 + 540) % 360 - 180
    print(NF == 4 && apart ^ 2 <= 1 && ($2 - $4) ^ 2 <= 1 && $2 > 20 ? "yes" : "no: " $0)
  }')
  [ "$same" = yes ] && break
  sleep 0.1
done
[ "$same" = yes ] || fail "the rotator and the commands: $same"
"$downrange" preflight my-range.toml "${live[@]}" --seconds 3 >"$work/preflight.log" 2>&1 || true
grep -qE "goheung-tm +slaved +[0-9.]+ deg off its commands +loop +[0-9.]+ s" "$work/preflight.log" || fail "no report of where it points"

echo "== the daemon dies and comes back"
kill -KILL "$rotator"
wait "$rotator" 2>/dev/null || true
until_logged "tries again" "$work/rotctl.log"
start_rotator || fail "port $port is taken"
until_logged "connected" "$work/rotctl.log" 2
until_logged "follows its commands" "$work/rotctl.log" 2

echo "== the flight ends"
wait "$replay" || fail "replay"
until_logged "stopped: there is no command to follow" "$work/rotctl.log"
ask "$told" p >"$work/ask.log" 2>&1 && fail "a pointing after the flight"
for pid in "$rotctl" "$rotctld" "$service"; do
  kill -TERM "$pid"
  wait "$pid" || fail "ended with an error"
done
grep -q "goheung-tm: [1-9][0-9]* positions sent, 0 refused, 1 stops, [1-9][0-9]* reports" "$work/rotctl.log" || fail "no account"
echo "a rotator followed the flight"
