#!/usr/bin/env bash
# What `downrange` says when something is wrong: a clear message, the right exit code, never a crash.
# usage: command_fault_test.sh DOWNRANGE_DIR SOURCE_DIR
set -uo pipefail

downrange=$1/downrange
source=$2
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
expect 2 "absent.mcap" "$downrange" replay "$work/absent.mcap" --config "$work/absent.mcap"
expect 1 "absent.mcap" "$downrange" replay "$work/absent.mcap" --config "$naro"
expect 2 "--rate" "$downrange" simulate "$naro" --scenario "$launch" --archive "$work/x.mcap" --rate fast
expect 2 "where the flight shall go" "$downrange" simulate "$naro" --scenario "$launch"
expect 1 "absent-scenario" "$downrange" simulate "$naro" --scenario "$work/absent-scenario" --archive "$work/x.mcap"
expect 2 "dds.domain" "$downrange" watch "$naro" --domain 1000
expect 1 "range clock" "$downrange" simulate "$naro" --scenario "$launch" --dds

# A small flight to spoil.
sed -e 's/^end_s = .*/end_s = 60/' "$launch" > "$work/short.toml"
"$downrange" simulate "$naro" --scenario "$work/short.toml" --set ingest.expect_simulated=true \
  --archive "$work/good.mcap" || exit 1
expect 0 "events over" "$downrange" replay "$work/good.mcap" --out "$work/out.mcap"
expect 1 "holds no true trajectory" "$downrange" report "$work/out.mcap"
expect 2 "nonesuch" "$downrange" replay "$work/good.mcap" --methods nonesuch
expect 1 "identical" "$downrange" diff "$work/good.mcap" "$work/out.mcap"
expect 0 "identical" "$downrange" diff "$work/out.mcap" "$work/out.mcap"

head -c 30000 "$work/good.mcap" > "$work/cut.mcap"
expect 0 "cut off at byte" "$downrange" replay "$work/cut.mcap" --config "$naro" --set ingest.expect_simulated=true
cp "$work/good.mcap" "$work/flipped.mcap"
printf '\x55\xaa\x55\xaa' | dd of="$work/flipped.mcap" bs=1 seek=30000 conv=notrunc status=none
expect 1 "flipped.mcap" "$downrange" replay "$work/flipped.mcap" --config "$naro"
echo "not an archive" > "$work/text.mcap"
expect 1 "text.mcap" "$downrange" replay "$work/text.mcap" --config "$naro"
expect 1 "/dev/full" "$downrange" replay "$work/good.mcap" --out /dev/full

# A live node never takes simulated input: every message rejected, no track, no pointing.
expect 0 "0 slaving commands" "$downrange" replay "$work/good.mcap" --config "$naro"

[[ $failures == 0 ]] && echo "all as expected"
exit $((failures > 0))
