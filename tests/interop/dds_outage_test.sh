#!/bin/bash
# dds_outage_test.sh FOLDER [CASE...]: radars and antennas of two vendors with their own default leases, and a node, on either
# side of a link. CASE is link:SECONDS (the link is down that long) or stop:SECONDS (the node is stopped). Afterwards everybody
# who was heard before must be heard again within 3 s. FOLDER: where the programs are. Each case has network namespaces of its
# own, so all run at once; they need the right to make them (root, or user namespaces), without which the test is skipped.
set -u
folder=$1
shift
[ $# -gt 0 ] || set -- link:3 link:7 link:12 link:30 stop:3 stop:7 stop:12 stop:30
domain=44
allowed_ns=3000000000
meeting_s=30 # at most, until everybody has met
cyclone='<Discovery><ParticipantIndex>auto</ParticipantIndex></Discovery>'

if [ "${OUTAGE_CASE:-}" = "" ]; then
  if ! unshare --user --map-root-user --net --mount true 2>/dev/null; then
    echo "skipped: no right to make network namespaces here"
    exit 77
  fi
  running=()
  for name in "$@"; do
    OUTAGE_CASE=$name unshare --user --map-root-user --net --mount --pid --fork --kill-child "$0" "$folder" &
    running+=($!)
  done
  failed=0
  for pid in "${running[@]}"; do wait "$pid" || failed=1; done
  exit $failed
fi

# From here on: one case, in namespaces of its own. A bridge, and one cable to the node, one to the instruments.
work=$(mktemp -d)
trap 'rm -rf "$work"; kill $(jobs -p) 2>/dev/null' EXIT
mount -t proc proc /proc 2>/dev/null
mount -t tmpfs tmpfs /dev/shm 2>/dev/null
ip link set lo up
ip link add switch type bridge mcast_snooping 0
ip link set switch up
declare -A holder
for side in node site; do
  unshare --net sleep infinity &
  holder[$side]=$!
  while [ "$(readlink "/proc/${holder[$side]}/ns/net")" = "$(readlink /proc/self/ns/net)" ]; do sleep 0.05; done
  ip link add "to-$side" type veth peer name eth0 netns "${holder[$side]}"
  ip link set "to-$side" master switch up
done
on() { # on SIDE COMMAND...
  local side=$1
  shift
  nsenter --target "${holder[$side]}" --net "$@"
}
address=1
for side in node site; do
  on $side ip link set lo up
  on $side ip address add 10.0.0.$address/24 dev eth0
  on $side ip link set eth0 up
  on $side ip route add 224.0.0.0/4 dev eth0
  address=$((address + 1))
done

export CYCLONEDDS_URI=$cyclone
on node "$folder/dds_outage_node" $domain >"$work/node" 2>"$work/node.errors" &
on site "$folder/fast_range_peer" $domain radar fast-radar 2>/dev/null &
on site "$folder/fast_range_peer" $domain antenna fast >"$work/fast-antenna" 2>/dev/null &
peers=(fast-radar fast-antenna)
if [ -x "$folder/cyclone_radar_sender" ]; then
  on site "$folder/cyclone_radar_sender" $domain cyclone-radar vehicle 50 2>/dev/null &
  on site "$folder/cyclone_slaving_client" $domain cyclone 100000000 1000 >"$work/cyclone-antenna" 2>/dev/null &
  peers+=(cyclone-radar cyclone-antenna)
fi

# Times at which a peer was heard, or heard the node.
times() {
  case $1 in
    *-radar) awk -v who="$1" '$1 == "heard" && $2 == who { print $3 }' "$work/node" 2>/dev/null ;;
    fast-antenna) awk '$1 == "heard" { print $3 }' "$work/fast-antenna" ;;
    cyclone-antenna) sed -n 's/.*apply_at_ns //p' "$work/cyclone-antenna" ;;
  esac
}
first_after() { # first_after PEER TIME: the first time after it, nothing where there is none
  times "$1" | awk -v t="$2" '$1 > t { print; exit }'
}
everybody_since() { # everybody_since TIME SECONDS: waits; those not heard since
  local since=$1 end=$((SECONDS + $2)) silent peer
  while true; do
    silent=""
    for peer in "${peers[@]}"; do [ "$(first_after "$peer" "$since")" != "" ] || silent="$silent $peer"; done
    [ "$silent" != "" ] && [ $SECONDS -lt $end ] || break
    sleep 0.2
  done
  echo "$silent"
}

silent=$(everybody_since 0 $meeting_s)
if [ "$silent" != "" ]; then
  echo "$OUTAGE_CASE: never met:$silent"
  cat "$work/node.errors"
  exit 1
fi
sleep 2 # discovery comes to rest
node=$(pgrep --ns $$ --nslist pid -x dds_outage_node 2>/dev/null || pgrep -x dds_outage_node)
case ${OUTAGE_CASE%:*} in
  link) ip link set to-node down ;;
  stop) kill -STOP "$node" ;;
esac
sleep "${OUTAGE_CASE#*:}"
over=$(date +%s%N)
case ${OUTAGE_CASE%:*} in
  link) ip link set to-node up ;;
  stop) kill -CONT "$node" ;;
esac

everybody_since "$over" 20 >/dev/null
lost=$(everybody_since $((over + allowed_ns)) 10) # what stood in a buffer is not enough
code=0
line="$OUTAGE_CASE:"
for peer in "${peers[@]}"; do
  first=$(first_after "$peer" "$over")
  if [ "$first" = "" ]; then
    line="$line $peer never"
    code=1
  else
    line="$line $peer $(((first - over) / 1000000)) ms"
    [ $((first - over)) -le $allowed_ns ] || code=1
  fi
done
[ "$lost" = "" ] || {
  line="$line, no more heard:$lost"
  code=1
}
[ $code = 0 ] || line="$line: later than $((allowed_ns / 1000000)) ms"
echo "$line"
exit $code
