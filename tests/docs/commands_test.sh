#!/bin/bash
# Each command line that a document shows is tried here as it stands there, or is named beside what tries it. A command that is
# documented and not in the list below fails, and so does one in the list that is documented no more. Then each option that
# running text names (`downrange check --keys`) must be known to its program.
# usage: commands_test.sh SOURCE_DIR BUILD_DIR DOWNRANGE_DIR DOWNRANGED_DIR
set -uo pipefail
source=$1
build=$2
PATH=$3:$4:$PATH
work=$(mktemp -d)
background=
cleanup() {
  [ -z "$background" ] || kill -KILL "$background" 2>/dev/null
  rm -rf "$work"
}
trap cleanup EXIT
failures=0
listed=$work/listed
log=$work/log
touch "$listed"

fail() {
  echo "FAILED: $*"
  [ ! -s "$log" ] || tail -n 12 "$log" | sed 's/^/    /'
  failures=$((failures + 1))
}

# run COMMAND: in the scratch folder. run COMMAND INSTEAD: where a person's machine would be changed.
run() {
  printf '%s\n' "$1" >>"$listed"
  (cd "$work/scratch" && eval "${2:-$1}") >"$log" 2>&1 </dev/null || fail "$1"
}
# starts COMMAND: in the background, until it says that it is ready.
starts() {
  printf '%s\n' "$1" >>"$listed"
  (cd "$work/scratch" && eval "exec $1") >"$work/service.log" 2>&1 </dev/null &
  background=$!
  for _ in {1..300}; do
    grep -q 'of range .*, DDS domain' "$work/service.log" && return
    kill -0 "$background" 2>/dev/null || break
    sleep 0.1
  done
  cp "$work/service.log" "$log"
  fail "$1"
}
# It stops as it should when it is told to.
stops() {
  kill -TERM "$background" 2>/dev/null
  wait "$background" || { cp "$work/service.log" "$log" && fail "ended with an error: $(tail -n 1 "$listed")"; }
  background=
}
# by WHAT COMMAND: tried by the test WHAT, or by the line of .ci/run that has it.
by() {
  printf '%s\n' "$2" >>"$listed"
  if [ "$1" = .ci/run ]; then
    grep -qF -- "$2" "$source/.ci/run" || fail "$2: not in .ci/run"
  else
    ctest --test-dir "$build" -N -R "^$1\$" | grep -q "Total Tests: 1" || fail "$2: there is no test $1"
  fi
}
# only COMMAND WHY: not tried.
only() { printf '%s\n' "$1" >>"$listed"; }

mkdir "$work/scratch"
cp "$source/config/dds-qos.xml" "$work/scratch"
cp "$source"/tools/examples/flight/*.csv "$work/scratch"
cp "$source/tools/examples/flight/mapping.toml" "$work/scratch/my-mapping.toml"
# A DDS domain of this test's own.
sed 's/^domain = .*/domain = 97/' "$source/config/naro.toml" >"$work/scratch/my-range.toml"

# ---- README.md
by .ci/run "tools/run"
by .ci/run "tools/test"
run "downrange check my-range.toml"
starts "downranged --config my-range.toml --node site-a --stages ingest --sources goheung,goheung-tgs"
stops
starts "downranged --config my-range.toml --node centre --stages align,fuse,slave --set 'dds.ingest_nodes=[\"site-a\"]'"
stops
starts "downranged --config my-range.toml"
only "downrange preflight my-range.toml" "no-go without sources: tried by unit_preflight and command_fault_test"
run "downrange operator mission planned --at +600 --config my-range.toml"
run "downrange operator inhibit goheung --as kim --reason \"spent stage in the beam\" --config my-range.toml"
run "downrange operator release goheung --as kim --reason \"beam is clear\" --config my-range.toml"
stops
by interop_rotctl_test "downrange rotctl my-range.toml"
by interop_rotctl_test "downrange rotctld my-range.toml goheung-tm"
run "downrange import my-mapping.toml --out flight.mcap"
run "downrange replay flight.mcap --config my-range.toml --out flown.mcap"
run "downrange report flown.mcap"
starts "downranged --config my-range.toml --clock range --archive live.mcap"
run "downrange replay flight.mcap --config my-range.toml --clock range --dds"
stops
run "downrange diff flown.mcap live.mcap"
starts "downranged --config my-range.toml --clock wall --set ingest.expect_simulated=true --archive now.mcap"
run "downrange replay flight.mcap --config my-range.toml --clock wall --dds --rate 1"
stops
# Rehearsed as in operations it is the same flight: as many of each source's messages accepted as in the replay.
accepted() { (cd "$work/scratch" && downrange report "$1" 2>/dev/null) | awk '/^Messages of each/ { on = 1 } on && /^\*/ { exit } on && $2 ~ /^[0-9]+$/ { print $1, $2 }'; }
[[ -n $(accepted flown.mcap) && $(accepted flown.mcap) == "$(accepted now.mcap)" ]] ||
  fail "the wall clock's flight is not the replayed one: $(accepted now.mcap | tr '\n' ' ')"

# ---- tools/scenarios/faults/README.md
cp "$source/tools/scenarios/launch.toml" "$source/tools/scenarios/faults/catalogue.toml" "$work/scratch"
run "downrange experiment faults --list"
by scenario_faults_test "downrange experiment faults --only gps-step-200,side-lobe --runs 1"
by scenario_faults_test "downrange experiment faults --html faults.html --json faults.json"
run "downrange simulate my-range.toml --scenario launch.toml --faults catalogue.toml --fault gps-step-200 --archive faulty.mcap"
run "downrange replay flight.mcap --config my-range.toml --faults catalogue.toml --fault spent-stage-20 --fault-begin 10"

# ---- deploy/README.md: the packages
by .ci/run "tools/package"
# by tests/system: what only a machine that systemd runs can do, tried by that long run.
in_system() {
  printf '%s\n' "$1" >>"$listed"
  grep -qE -- "$2" "$source/tests/system/package_test.sh" || fail "$1: not in tests/system/package_test.sh"
}
version=$(sed -nE 's/^project\(downrange VERSION ([0-9.]+).*/\1/p' "$source/CMakeLists.txt")
in_system "sudo apt install ./build/package/downrange_$version-1_amd64.deb" 'install.*downrange_\*\.deb'
in_system "downrange check /etc/downrange/range.toml" 'downrange check /etc/downrange/range.toml'
in_system "sudo systemctl enable --now downranged" 'systemctl enable --now downranged$'
in_system "sudo systemctl enable --now downranged@site-a" 'systemctl enable --now downranged@site-a'
in_system "echo 'downrange downrange/remove-flights boolean true' | sudo debconf-set-selections" 'downrange/remove-flights boolean true'
in_system "sudo mkdir -p /etc/systemd/system/downranged.service.d" 'mkdir -p /etc/systemd/system/downranged.service.d'
in_system "downrange firewall /etc/downrange/range.toml --for systemd | sudo tee /etc/systemd/system/downranged.service.d/peers.conf" '--for systemd .*downranged.service.d/peers.conf'
in_system "sudo systemctl daemon-reload && sudo systemctl restart downranged" 'systemctl restart downranged'
in_system "downrange firewall /etc/downrange/range.toml --for nftables | sudo tee /etc/nftables-downrange.conf" '--for nftables .*/etc/nftables-downrange.conf'
in_system "sudo nft -f /etc/nftables-downrange.conf" 'nft -f /etc/nftables-downrange.conf'
run "downrange simulate /etc/downrange/range.toml --set ingest.expect_simulated=true --scenario /usr/share/downrange/scenarios/launch.toml --archive rehearsal.mcap --truth truth.mcap" \
  "downrange simulate my-range.toml --set ingest.expect_simulated=true --scenario launch.toml --archive rehearsal.mcap --truth truth.mcap"
run "downrange replay rehearsal.mcap --out rehearsed.mcap"
run "downrange report rehearsed.mcap --truth truth.mcap"

# ---- deploy/README.md, without packages: installed into a folder instead of the machine
root=$work/root
sudo() { # what follows sudo, on that folder
  case $1 in
    install)
      local arguments=()
      for argument in "${@:2}"; do arguments+=("${argument/#\//$root/}"); done
      command install "${arguments[@]}"
      ;;
    systemd-*) if command -v "$1" >/dev/null; then command "$1" --root="$root" "${@:2}"; fi ;;
    *) "$@" ;;
  esac
}
mkdir -p "$root/etc"
by .ci/run "cmake --preset release && cmake --build --preset release"
run "sudo cmake --install build/release --prefix /usr --strip" "DESTDIR=$root cmake --install $build --prefix /usr --strip"
run "sudo systemd-sysusers && sudo systemd-tmpfiles --create downrange.conf"
run "sudo install -D -m 644 /usr/share/downrange/config/naro.toml /etc/downrange/range.toml"
run "sudo install -m 644 /usr/share/downrange/config/dds-qos.xml /etc/downrange/"
run "downrange check /etc/downrange/range.toml" "$root/usr/bin/downrange check $root/etc/downrange/range.toml"
only "sudo systemctl daemon-reload && sudo systemctl enable --now downranged" "needs a machine that systemd runs"

# ---- tools/README.md
by .ci/run "tools/bench latency"
only "tools/bench load" "a machine that does something else beside it may miss a tick"
by .ci/run "tools/bench targets"

# ---- CONTRIBUTING.md, tools/examples/README.md
by .ci/run "tools/lint"
by docs_documents_test "tools/check-documents"
by .ci/run "cmake --preset core && cmake --build --preset core"
by install_examples_test "cmake --install build/core --prefix build/downrange"
by install_examples_test 'cmake -S tools/examples -B build/examples -DCMAKE_PREFIX_PATH="$PWD/build/downrange"'
by install_examples_test "cmake --build build/examples"
by install_examples_test "build/examples/fly_csv tools/examples/flight"
by install_examples_test "downranged --config config/naro.toml --set 'fuse.methods=[\"alpha-beta\"]'"
by install_examples_test "build/examples/radar_sender 0 goheung kslv config/dds-qos.xml 60"
by install_examples_test "build/examples/antenna_client 0 goheung-tm config/dds-qos.xml 60"

# ---- src/est
by scenario_recorded_flights_test "downrange experiment flights --html flights.html"

# What the documents show: lines of code blocks whose first word is a program or a script of the house, without the comment at
# their end. In blocks that are indented or fenced as sh any program counts; in plain fences, which hold pictures too, ours only.
documents=$(cd "$source" && find . -name '*.md' -not -path './build*' | sort)
(cd "$source" && awk '
  FNR == 1 { block = ""; before = "" }
  /^```/ { block = block != "" ? "" : ($0 == "```" ? "plain" : $0 == "```sh" ? "sh" : "other"); before = ""; next }
  block == "plain" || block == "sh" || (block == "" && /^    [^ ]/ && (before == "" || before ~ /^    /)) {
    line = $0
    sub(/^ +/, "", line)
    sub(/ +#.*/, "", line)
    print FILENAME ":" FNR "\t" (block == "plain" ? "ours" : "any") "\t" line
  }
  { before = $0 }' $documents) >"$work/shown"
: >"$work/documented"
while IFS=$'\t' read -r where programs line; do
  first=${line%% *}
  case $first in
    downrange | downranged | tools/* | build/* | .ci/* | sudo) ;;
    *) [[ $programs = any && $first =~ ^[a-z][a-z0-9_.+-]*$ ]] && type -P "$first" >/dev/null || continue ;;
  esac
  printf '%s\n' "$line" >>"$work/documented"
  grep -qxF -- "$line" "$listed" || { : >"$log" && fail "$where shows a command that is not tried here: $line"; }
done <"$work/shown"
while IFS= read -r line; do
  grep -qxF -- "$line" "$work/documented" || { : >"$log" && fail "no document shows this command any more: $line"; }
done <"$listed"

# Running text: `downrange SUBCOMMAND ... --option`. Subcommand and options must be in the help.
while IFS= read -r command; do
  read -ra words <<<"$command"
  case ${words[0]} in
    downrange) help=$(downrange "${words[1]}" --help 2>&1) || { : >"$log" && fail "\`$command\`: no such subcommand" && continue; } ;;
    downranged) help=$(downranged --help 2>&1) ;;
    tools/*) help=$("$source/${words[0]}" --help 2>&1) ;;
  esac
  for word in "${words[@]:1}"; do
    [[ $word != --?* || $word = --help ]] || grep -qF -- "${word%%=*}" <<<"$help" || { : >"$log" && fail "\`$command\`: no option $word"; }
  done
done < <(cd "$source" && grep -ohE '`(downranged?|tools/[a-z-]+) [a-z-][^`]*`' $documents | tr -d '`' | sort -u)

[ "$failures" -eq 0 ] && echo "$(wc -l <"$listed") documented commands are tried"
exit $((failures > 0))
