# shellcheck shell=bash
# Shared by latency.sh and load.sh; sourced. A scratch folder `work`, and processes that end with the script.

work=$(mktemp -d)
pids=()
cleanup() {
  for pid in "${pids[@]}"; do kill -KILL "$pid" 2>/dev/null || true; done
  rm -rf "$work"
}
trap cleanup EXIT
trap 'exit 143' TERM INT HUP

# start NAME COMMAND...: in the background, output to NAME.log; its process id is `started`.
start() {
  local log=$work/$1.log
  shift
  "$@" >"$log" 2>&1 </dev/null &
  started=$!
  disown "$started" # its end is nobody's news
  pids+=("$started")
}

# start_service COMMAND...: and waits until it is there.
start_service() {
  start service "$@"
  for _ in {1..300}; do
    grep -q 'of range .*, DDS domain' "$work/service.log" 2>/dev/null && return
    sleep 0.1
  done
  fail "the service did not start"
}

fail() {
  for log in "$work"/*.log; do printf '==> %s\n' "${log##*/}" >&2 && tail -n 15 "$log" >&2; done
  printf 'error: %s\n' "$*" >&2
  exit 1
}
