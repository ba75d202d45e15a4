#!/bin/bash
# The manual pages and the completion tell what the programs know, no more and no less: every subcommand and option of --help, every key of
# `downrange check --keys`, and in their own words no option that is not there.
# usage: manual_test.sh SOURCE_DIR BUILD_DIR DOWNRANGE_DIR DOWNRANGED_DIR
set -euo pipefail
source=$1
pages=$2/deploy
PATH=$3:$4:$PATH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# page NAME: as text, its markup and escapes taken out.
page() { gzip -dc "$pages/$1.gz" | sed -e 's/\\f[BIR]//g' -e 's/\\-/-/g' -e 's/\\&//g' -e 's/\\e/\\/g'; }
options() { grep -oE -- '--[a-z][a-z-]*' | sort -u; }
subcommands() { downrange "$@" --help | sed -n '/^Subcommands:$/,/^$/s/^  \([^ ]*\).*/\1/p'; }

# Every leaf of the tree of subcommands has a part of the page with its options.
page downrange.1 >"$work/downrange.1"
leaf() {
  local name=$*
  if [ -n "$(subcommands "$@")" ]; then
    for sub in $(subcommands "$@"); do leaf "$@" "$sub"; done
    return
  fi
  leaves=$((leaves + 1))
  downrange "$@" --help >>"$work/all"
  awk -v head=".SS \"downrange $name [" 'index($0, head) == 1 { on = 1; next } /^\.S[SH]/ { on = 0 } on' "$work/downrange.1" >"$work/part"
  downrange "$@" --help | sed '/^Exit code/,$d' | options | grep -vx -- --help >"$work/known" || true
  options <"$work/part" >"$work/told" || true
  cmp -s "$work/known" "$work/told" || fail "downrange.1, $name: $(diff "$work/known" "$work/told" | grep '^[<>]' | tr '\n' ' ')"
}
leaves=0
downrange --help >"$work/all"
leaf
[ $leaves -ge 10 ] || fail "only $leaves subcommands were found"
page downranged.8 >"$work/downranged.8"
downranged --help | options >"$work/known"
awk '/^\.SH OPTIONS/ { on = 1; next } /^\.SH/ { on = 0 } on' "$work/downranged.8" | options >"$work/told"
cmp -s <(grep -vx -- --help "$work/known") "$work/told" || fail "downranged.8: $(diff "$work/known" "$work/told" | grep '^[<>]' | tr '\n' ' ')"
downranged --help >>"$work/all"

# What the pages and units say around it.
for words in "$work/downrange.1" "$work/downranged.8" "$source"/deploy/downranged.service.in "$source"/deploy/deb/downranged.env; do
  while IFS= read -r option; do
    grep -qF -- "$option" "$work/all" || fail "$(basename "$words") names $option, which no program knows"
  done < <(options <"$words")
done

page downrange.toml.5 >"$work/downrange.toml.5"
downrange check --keys | sed -nE 's/^(\[+[^]]+\]+) .*/\1/p; s/^  ([a-z0-9_]+): .*/\1/p' >"$work/known"
sed -nE 's/^\.SS "(\[.*\])"$/\1/p; /^\.TP$/{n;/^[a-z0-9_]+$/p}' "$work/downrange.toml.5" >"$work/told"
[ "$(wc -l <"$work/known")" -ge 100 ] || fail "only $(wc -l <"$work/known") keys were found"
cmp -s "$work/known" "$work/told" || fail "downrange.toml.5: $(diff "$work/known" "$work/told" | grep '^[<>]' | head -n 5 | tr '\n' ' ')"

if command -v groff >/dev/null; then
  for name in downrange.1 downranged.8 downrange.toml.5; do
    said=$(gzip -dc "$pages/$name.gz" | groff -K utf8 -man -ww -z -Tutf8 2>&1) || true
    [ -z "$said" ] || fail "$name: $said"
  done
fi

# completes WORDS... WANTED: with the last of WORDS begun, WANTED is what it may become.
. "$source/deploy/completion.bash"
completes() {
  COMP_WORDS=("${@:1:$#-1}")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  _downrange "$1"
  [ "${COMPREPLY[*]}" = "${!#}" ] || fail "completion of '${COMP_WORDS[*]}': '${COMPREPLY[*]}', not '${!#}'"
}
completes downrange si "simulate"
completes downrange "" "$(subcommands | paste -sd ' ')"
completes downrange operator mission pl "planned"
completes downrange simulate --see "--seed"
completes downrange simulate --clock "" "wall range"
completes downrange simulate --archive x ""
completes downranged --arch "--archive"

[ $failures -eq 0 ] && echo "$leaves subcommands and $(wc -l <"$work/known") keys are told as they are"
exit $((failures > 0))
