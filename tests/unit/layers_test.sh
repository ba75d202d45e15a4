#!/bin/bash
# The layer check passes on the sources as they are, and its alarm rings: each forbidden include, planted in a copy, is found
# with its file and line; each allowed one is not.
set -euo pipefail
source_dir=$1
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
cp -r "$source_dir/src" "$source_dir/include" "$source_dir/idl" "$copy"
check=$source_dir/tools/check-layers
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

"$check" "$source_dir" || fail "the repository itself"

# plant FILE INCLUDE: appends the line to FILE of the copy, runs the check, puts FILE back. Sets `rc`, `output`, `line`.
plant() {
  local file=$copy/$1 existed=no
  [ -f "$file" ] && existed=yes && cp "$file" "$copy/original"
  mkdir -p "$(dirname "$file")"
  printf '%s\n' "$2" >>"$file"
  line=$(wc -l <"$file")
  rc=0
  output=$("$check" "$copy") || rc=$?
  if [ "$existed" = yes ]; then mv "$copy/original" "$file"; else rm "$file"; fi
}

forbidden() {
  plant "$1" "$2"
  [ "$rc" -eq 1 ] || fail "exit $rc instead of 1 for '$2' in $1"
  grep -qF "$1:$line: " <<<"$output" || fail "'$2' in $1:$line was not reported: $output"
}

allowed() {
  plant "$1" "$2"
  [ "$rc" -eq 0 ] || fail "'$2' in $1 was reported: $output"
}

# Down the table.
forbidden include/downrange/geo/site.hpp '#include <downrange/est/method/method.hpp>'
forbidden src/geo/site.cpp '#include <downrange/stage/event.hpp>'
forbidden src/est/model/motion.cpp '#include <downrange/stage/event.hpp>'
forbidden src/est/model/motion.cpp '#include "../../stage/ingest.hpp"'
# The rooms of est.
forbidden src/est/model/motion.cpp '#include <downrange/est/filter/gaussian.hpp>'
forbidden include/downrange/est/model/sensors.hpp '#include <downrange/est/method/method.hpp>'
forbidden include/downrange/est/filter/hypothesis.hpp '#include <downrange/est/method/source_checks.hpp>'
forbidden src/est/filter/imm.cpp '#include "../track/track_rules.hpp"'
forbidden include/downrange/est/track/track_fusion.hpp '#include <downrange/est/method/joint.hpp>'
allowed include/downrange/est/track/track_fusion.hpp '#include <downrange/est/filter/imm.hpp>'
allowed src/est/method/joint.cpp '#include <downrange/est/track/assignment.hpp>'
forbidden src/stage/engine.cpp '#include "dds/participant.hpp"'
forbidden src/stage/engine.cpp '#  include "archive/writer.hpp"'
forbidden src/stage/engine.cpp '#include <config/load.hpp>'
forbidden src/score/scorer.cpp '#include "sim/scenario.hpp"'
forbidden src/sim/simulation.cpp '#include "dds/inputs.hpp"'
forbidden src/sim/simulation.cpp '#include "experiment/experiment.hpp"'
forbidden src/experiment/launch.cpp '#include "config/load.hpp"'
forbidden src/config/load.cpp '#include "archive/reader.hpp"'
forbidden src/archive/reader.cpp '#include "dds/inputs.hpp"'
forbidden src/archive/reader.cpp '#include "score/truth.hpp"'
forbidden src/dds/inputs.cpp '#include <archive/reader.hpp>'
forbidden src/dds/inputs.cpp '#include "app/downranged/service.hpp"'
forbidden idl/archive.proto 'import "other.proto";'
# The computation knows no DDS, Protobuf, log, thread, clock, file or environment.
for outside in fastdds/dds/topic/Topic.hpp downrange.h archive.pb.h google/protobuf/message.h spdlog/spdlog.h \
  thread mutex atomic condition_variable chrono ctime fstream iostream filesystem cstdlib random unordered_map unistd.h; do
  forbidden src/geo/polar.cpp "#include <$outside>"
  forbidden include/downrange/est/method/method.hpp "#include <$outside>"
  forbidden src/stage/slave.cpp "#include <$outside>"
done
# DDS itself is known to src/dds only; a folder that nobody put into the table is noticed.
forbidden src/app/downranged/main.cpp '#include <fastdds/dds/topic/Topic.hpp>'
forbidden src/extra/new.cpp '#include <vector>'
forbidden src/est/model/motion.cpp '#include NAME_OF_A_HEADER'

allowed src/est/new.cpp '#include <downrange/geo/site.hpp>'
allowed src/stage/slave.cpp '#include "ingest.hpp"'
allowed src/stage/slave.cpp '#include <Eigen/Dense>'
allowed src/score/truth.cpp '#include <downrange/stage/event.hpp>'
allowed src/sim/simulation.cpp '#include "score/scorer.hpp"'
allowed src/experiment/launch.cpp '#include "score/scorer.hpp"'
allowed src/dds/inputs.cpp '#include <thread>'
allowed src/app/downranged/main.cpp '#include "archive/writer.hpp"'

# A header that no CMakeLists.txt names.
touch "$copy/include/downrange/est/unlisted.hpp"
if output=$("$check" "$copy") || ! grep -q '^include/downrange/est/unlisted.hpp:1: ' <<<"$output"; then
  fail "the unlisted header was not reported: $output"
fi

[ "$failures" -eq 0 ] && echo "layer check: all planted includes judged rightly"
exit "$((failures > 0))"
