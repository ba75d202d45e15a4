#!/bin/bash
# tools/check-documents passes on the repository as it is, and its alarm rings: each wrong name, planted in a copy, is found with
# its file and line; each right one is not.
set -euo pipefail
source_dir=$1
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
for part in cmake config deploy idl include src tests tools; do
  if [ -d "$source_dir/$part" ]; then cp -r "$source_dir/$part" "$copy"; fi
done
cp "$source_dir"/*.md "$source_dir"/CMake* "$source_dir"/LICENSE "$copy"
check=$source_dir/tools/check-documents
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

"$check" "$source_dir" || fail "the repository itself"

# plant FILE TEXT: appends TEXT to FILE of the copy, runs the check, puts FILE back. Sets `rc`, `output`, `line`.
plant() {
  local file=$copy/$1
  cp "$file" "$copy/original"
  printf '%b\n' "$2" >>"$file"
  line=$(($(wc -l <"$copy/original") + 1))
  rc=0
  output=$("$check" "$copy") || rc=$?
  mv "$copy/original" "$file"
}
wrong() {
  plant "$1" "$2"
  [ "$rc" -eq 1 ] || fail "exit $rc instead of 1 for '$2' in $1"
  grep -qF "$1:$line: " <<<"$output" || fail "'$2' in $1:$line was not reported: $output"
}
right() {
  plant "$1" "$2"
  [ "$rc" -eq 0 ] || fail "'$2' in $1 was reported: $output"
}

header=include/downrange/est/method/method.hpp
wrong $header "// as ABSENT.md says" # a document that is not there
wrong $header "// THEORY.md section 99"
wrong $header "// THEORY.md\n/// section 99" # broken over two lines
right $header "// THEORY.md section 3"
right $header "// THEORY.md\n/// section 4a, and src/est/ERRATA.md"
wrong src/est/README.md "[somewhere](absent/README.md)"
wrong src/est/README.md "[somewhere](#absent-heading)"
right src/est/README.md "[there](../geo/README.md) and [there](https://downrange.invalid/x.md)"
wrong README.md "see \`tools/absent\`"
right README.md "see \`tools/run\` and \`tests/FOLDER\`"
wrong config/naro.toml "# explained in src/config/absent.hpp"

[ "$failures" -eq 0 ] && echo "documents: every wrong name is found"
exit $((failures > 0))
