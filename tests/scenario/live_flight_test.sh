#!/usr/bin/env bash
# One flight, four ways, the same bits: in this process, live over DDS all-in-one, live split over three nodes, and the
# replay of what the live service recorded. Binaries as a person starts them.
# usage: live_flight_test.sh DOWNRANGE_DIR DOWNRANGED_DIR SOURCE_DIR DOMAIN
set -euo pipefail

downrange=$1/downrange
downranged=$2/downranged
source=$3
domain=$4
work=$(mktemp -d)
pids=()
cleanup() {
  for pid in "${pids[@]}"; do kill -9 "$pid" 2>/dev/null || true; done
  rm -rf "$work"
}
trap cleanup EXIT

# A short flight is enough for bits: 60 s around the acquisition of the second radar.
sed -e 's/^end_s = .*/end_s = 90/' "$source/tools/scenarios/launch.toml" \
  | sed -e '/^\[\[phase\]\]/,/^$/d' > "$work/short.toml"
cat >> "$work/short.toml" <<'PHASE'

[[phase]]
name = "flight"
from_s = 20
to_s = 90
PHASE
config=$source/config/naro.toml
sim=(--set ingest.expect_simulated=true --clock range)
results=(--topic downrange/trajectory --topic downrange/bias --topic downrange/slaving)

stop_nodes() {
  for pid in "${pids[@]}"; do kill -TERM "$pid"; done
  for pid in "${pids[@]}"; do wait "$pid" || { echo "a node ended with an error"; exit 1; }; done
  pids=()
}

echo "== in this process"
"$downrange" simulate "$config" --scenario "$work/short.toml" "${sim[@]}" --archive "$work/messages.mcap"
"$downrange" replay "$work/messages.mcap" --out "$work/here.mcap"

echo "== live, all in one"
"$downranged" --config "$config" --clock range --set ingest.expect_simulated=true --domain "$domain" \
  --archive "$work/live.mcap" > "$work/live.log" 2>&1 &
pids+=($!)
"$downrange" simulate "$config" --scenario "$work/short.toml" "${sim[@]}" --domain "$domain" --dds --rate max
stop_nodes
"$downrange" diff "$work/here.mcap" "$work/live.mcap"

echo "== replay of the live recording, full speed and paced"
"$downrange" replay "$work/live.mcap" --out "$work/again.mcap"
"$downrange" diff "$work/live.mcap" "$work/again.mcap"
"$downrange" replay "$work/live.mcap" --rate 20 --out "$work/paced.mcap"
"$downrange" diff "$work/live.mcap" "$work/paced.mcap"

echo "== live, split: two ingest nodes and a centre"
nodes='dds.ingest_nodes=["ingest-a", "ingest-b"]'
common=(--config "$config" --clock range --set ingest.expect_simulated=true --domain "$domain")
"$downranged" "${common[@]}" --node ingest-a --stages ingest --sources goheung,goheung-tgs > "$work/a.log" 2>&1 &
pids+=($!)
"$downranged" "${common[@]}" --node ingest-b --stages ingest --sources jeju,jeju-tgs,ship-tgs > "$work/b.log" 2>&1 &
pids+=($!)
"$downranged" "${common[@]}" --node centre --stages align,fuse,slave --set "$nodes" --archive "$work/centre.mcap" \
  > "$work/c.log" 2>&1 &
pids+=($!)
"$downrange" simulate "$config" --scenario "$work/short.toml" "${sim[@]}" --domain "$domain" --dds --rate max \
  --nodes ingest-a,ingest-b,centre || { tail -5 "$work"/*.log; exit 1; }
stop_nodes
"$downrange" diff "$work/here.mcap" "$work/centre.mcap" "${results[@]}"
echo "all the same"
