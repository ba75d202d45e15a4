#!/bin/bash
# What an outsider does: installs, finds the package, builds the programs of tools/examples against it, and runs them: a flight out
# of CSV files, a method of their own, and over DDS a radar, the service and two antennas of two vendors.
# usage: examples_test.sh SOURCE_DIR BUILD_DIR
set -euo pipefail
source=$1
build=$2
# Always the same folder, so that the compiler cache knows the programs again.
work=$build/tests/install/work
rm -rf "$work"
mkdir -p "$work"
prefix=$work/prefix
pids=()
trap '[ ${#pids[@]} -eq 0 ] || kill -KILL "${pids[@]}" 2>/dev/null || true' EXIT

# expect TEXT FILE: TEXT, an extended regular expression, is in FILE.
expect() {
  grep -qE -- "$1" "$2" || { echo "FAILED: no '$1' in $(basename "$2"):" && tail -n 15 "$2" && exit 1; }
}

echo "== the library alone"
for component in core idl; do
  cmake --install "$build" --prefix "$work/core" --component $component >"$work/install.log"
done
if find "$work/core" -name '*.hpp' | xargs grep -lE '#include <(fastdds|google|spdlog|boost|toml)'; then
  echo "FAILED: these headers need more than Eigen" && exit 1
fi
# Who asks for more than there is, is told.
mkdir "$work/ask"
printf 'cmake_minimum_required(VERSION 3.25)\nproject(ask CXX)\nfind_package(Downrange REQUIRED COMPONENTS core radar)\n' >"$work/ask/CMakeLists.txt"
if cmake -S "$work/ask" -B "$work/ask/build" -DCMAKE_PREFIX_PATH="$work/core" >"$work/ask.log" 2>&1; then
  echo "FAILED: a component that is not there was found" && exit 1
fi
expect "has no component radar" "$work/ask.log"

echo "== everything; the examples"
cmake --install "$build" --prefix "$prefix" >"$work/install.log"
cmake -S "$source/tools/examples" -B "$work/examples" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache)" >"$work/configure.log"
CCACHE_BASEDIR=$work CCACHE_NOHASHDIR=1 cmake --build "$work/examples" >"$work/build.log" || { tail -n 30 "$work/build.log" && exit 1; }

echo "== a flight out of CSV files"
"$work/examples/fly_csv" "$source/tools/examples/flight" >"$work/fly_csv.log"
expect '^T\+35.* km .* m/s  1-sigma +[0-9]\.[0-9] m   antenna' "$work/fly_csv.log"
expect '^0 observations rejected' "$work/fly_csv.log"

echo "== a method of one's own, beside joint"
"$work/examples/own_method" "$source/tools/examples/flight" >"$work/own_method.log"
expect '^joint +[0-9]\.[0-9] m rms at [0-9]{2,} instants' "$work/own_method.log"
# It knows no biases: 30 m of range, 0.03 degrees at up to 9 km.
expect '^plain-cv +[2-6][0-9]\.[0-9] m rms at [0-9]{2,} instants' "$work/own_method.log"

echo "== a radar, the service, and antennas of two vendors"
domain=96
profiles=$prefix/share/downrange/config/dds-qos.xml
"$prefix/bin/downranged" --config "$prefix/share/downrange/config/naro.toml" --domain $domain --set 'fuse.methods=["alpha-beta"]' \
  --set slave.coast_ms=1000 \
  >"$work/service.log" 2>&1 &
pids+=($!)
"$work/examples/radar_sender" $domain goheung kslv "$profiles" 12 >"$work/radar.log" 2>&1 &
pids+=($!)
"$work/examples/antenna_client" $domain goheung-tm "$profiles" 18 >"$work/antenna_client.log" 2>&1 &
pids+=($!)
"$work/examples/antenna_client_cyclonedds" $domain jeju-tm 18 >"$work/antenna_client_cyclonedds.log" 2>&1 &
pids+=($!)
# No-go, for the other sources are silent; what it says of the antennas is wanted.
"$prefix/bin/downrange" preflight "$prefix/share/downrange/config/naro.toml" --domain $domain --seconds 9 >"$work/preflight.log" 2>&1 || true
for pid in "${pids[@]:1}"; do
  wait "$pid" || { tail -n 5 "$work"/{service,radar,antenna_*}.log && echo "FAILED: a program of tools/examples ended with an error" && exit 1; }
done
kill -TERM "${pids[0]}" && wait "${pids[0]}"
pids=()
for client in antenna_client antenna_client_cyclonedds; do
  expect '^azimuth +[0-9.]+ deg, elevation +[0-9.]+ deg' "$work/$client.log"
  expect '^no valid command: standing still' "$work/$client.log" # the radar ends first
done
# Both report where they point, and which command they follow: a servo that lags by 50 ms, led by as much, is on target.
for antenna in goheung-tm jeju-tm; do
  expect "^GO +$antenna +slaved +0\\.0[0-4][0-9] deg off its commands +loop +0\\.[0-9]+ s" "$work/preflight.log"
done
echo "all examples run"
