#!/bin/bash
# The Debian packages on a bare Debian 12, as an operator has them: a minimal system is made in a folder (debootstrap), booted
# (systemd-nspawn), and there the packages are installed, flown, killed, hung, reloaded, upgraded, removed and purged.
#
#   tests/system/package_test.sh [--chroot] [PACKAGES]   the folder of what tools/package built (default: build/package);
#                                                        --chroot: as where nothing boots
#
# As root, on Debian 12 with debootstrap and systemd-container, and a mirror that apt reaches: about 6 minutes, 4 where the bare
# system is there from the last time (build/system/base; remove it to have it made anew). Nothing of it touches the machine's own
# systemd or network. Where nothing boots, that is said, and what needs no systemd is tried in a chroot. Exit code 0: all as it should be.
set -euo pipefail
. "$(dirname "$0")/../../tools/lib.sh"
case ${1:-} in -h | --help) print_help && exit ;; esac

boot=yes
[ "${1:-}" != --chroot ] || { boot=no && shift; }
packages=$(realpath "${1:-$ROOT/build/package}")
[ "$(id -u)" -eq 0 ] || die "this needs root"
for program in debootstrap systemd-nspawn nsenter; do
  command -v $program >/dev/null || die "$program is missing: apt-get install debootstrap systemd-container"
done
ls "$packages"/downrange_*.deb "$packages"/downrange-{idl,dev}_*.deb >/dev/null || die "no packages in $packages: tools/package"

place=$ROOT/build/system
base=$place/base
root=$place/root
mkdir -p "$place"
log=$place/log
: >"$log"
container=

clean_up() {
  if [ -n "$container" ]; then
    in_it systemctl poweroff >/dev/null 2>&1 || true
    for _ in {1..100}; do kill -0 "$container" 2>/dev/null && sleep 0.1 || break; done
    kill -KILL "$container" 2>/dev/null || true
  fi
}
trap clean_up EXIT
step() { printf '%4d s  %s\n' $SECONDS "$*" | tee -a "$log"; }
fail() {
  printf 'FAILED: %s\n' "$*"
  tail -n 25 "$log" | sed 's/^/    /'
  [ -z "$container" ] || in_it journalctl -u 'downranged*' -n 25 --no-pager -o short-precise | sed 's/^/    journal: /'
  exit 1
}

# in_it COMMAND...: in the booted container, or in a chroot without a network of others.
in_it() {
  if [ -n "$container" ]; then
    nsenter -t "$(pgrep -P "$container" -o)" -a env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
      DEBIAN_FRONTEND=noninteractive "$@"
  else
    unshare -n -m -p -f sh -c 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"' "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
  fi
}
# must COMMAND...: succeeds. must_not COMMAND...: fails.
must() { in_it "$@" >>"$log" 2>&1 </dev/null || fail "$*"; }
must_not() { ! in_it "$@" >>"$log" 2>&1 </dev/null || fail "succeeded, and should not: $*"; }
# says TEXT COMMAND...: succeeds, and what it prints has TEXT (an extended regular expression).
says() {
  local text=$1 printed
  shift
  printed=$(in_it "$@" 2>&1 </dev/null) || { printf '%s\n' "$printed" >>"$log" && fail "$*"; }
  printf '%s\n' "$printed" >>"$log"
  grep -qE -- "$text" <<<"$printed" || fail "no '$text' from: $*"
}
# soon WHAT SECONDS COMMAND...: succeeds within that time. It is a limit for what never comes, not a measurement.
soon() {
  local what=$1 limit=$((SECONDS + $2))
  shift 2
  until in_it "$@" >/dev/null 2>&1 </dev/null; do
    [ $SECONDS -lt $limit ] || fail "$what did not come: $*"
    sleep 0.5
  done
}
property() { in_it systemctl show -P "$2" "$1"; }
journal_says() { in_it sh -c "journalctl -u '$1' -o cat --no-pager | grep -qE -- '$2'"; }

step "a bare Debian 12"
if [ ! -e "$base/complete" ]; then
  rm -rf "$base"
  debootstrap --variant=minbase --include=systemd,systemd-sysv,dbus,iproute2 bookworm "$base" \
    "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" >>"$log" 2>&1 || fail "debootstrap"
  chroot "$base" apt-get clean
  touch "$base/complete"
fi
rm -rf "$root"
cp -a "$base" "$root"
mkdir "$root/packages"
cp "$packages"/*.deb "$root/packages"
cp -L /etc/resolv.conf "$root/etc/resolv.conf"
# What the packages need comes now, by the machine's network; the container has none.
chroot "$root" sh -c 'apt-get -q update && apt-get -qy install --no-install-recommends --download-only /packages/downrange_*.deb bash-completion nftables' \
  >>"$log" 2>&1 || fail "downloading what the packages need"
needed=$(find "$root/var/cache/apt/archives" -name '*.deb' | wc -l)

booted=no
if [ $boot = yes ]; then
  # As on a machine of its own: unified cgroups, and systemd may filter addresses.
  SYSTEMD_NSPAWN_UNIFIED_HIERARCHY=1 systemd-nspawn --quiet --boot --register=no --keep-unit --private-network --capability=CAP_BPF,CAP_PERFMON \
    --system-call-filter=bpf -D "$root" >"$place/boot.log" 2>&1 </dev/null &
  container=$!
  for _ in {1..60}; do
    kill -0 $container 2>/dev/null || break
    case $(in_it systemctl is-system-running 2>/dev/null || true) in running | degraded) booted=yes && break ;; esac
    sleep 1
  done
fi
if [ $booted = no ]; then
  [ -z "$container" ] || kill -KILL "$container" 2>/dev/null || true
  container=
  warn "nothing was booted (build/system/boot.log): units, crash, hang, reload and upgrade of a running service are NOT tried"
fi
must ip link set lo up
must ip link set lo multicast on

install='apt-get -qy install --no-install-recommends -o Dpkg::Options::=--force-confold'
step "installed, with $needed packages that it needs or that this test needs"
must sh -c "$install bash-completion nftables /packages/downrange_*.deb"
must sh -c 'test "$(stat -c "%U %G %a" /var/lib/downrange)" = "downrange downrange 750"'
must test -e /usr/share/man/man8/downranged.8.gz -o -e /etc/dpkg/dpkg.cfg.d/docker
says '^0\.' downrange --version
says 'valid. Range naro' downrange check /etc/downrange/range.toml
says 'simulate' bash -ic '. /usr/share/bash-completion/completions/downrange; COMP_WORDS=(downrange si); COMP_CWORD=1; _downrange downrange; echo "${COMPREPLY[@]}"'
must sed -i 's|^peers = .*|peers = ["192.0.2.0/24", "192.0.2.7", "2001:db8::/64"]|' /etc/downrange/range.toml
must sh -c 'downrange firewall /etc/downrange/range.toml --for nftables >/etc/nftables-downrange.conf'
says '192.0.2.0/24' sh -c 'nft -f /etc/nftables-downrange.conf && nft -f /etc/nftables-downrange.conf && nft list table inet downrange'

step "a newcomer's rehearsal: simulated, flown, judged"
must sh -c 'sed "s/^end_s = .*/end_s = 60/" /usr/share/downrange/scenarios/launch.toml >/tmp/short.toml'
must downrange simulate /etc/downrange/range.toml --set ingest.expect_simulated=true --scenario /tmp/short.toml --archive /tmp/flight.mcap --truth /tmp/truth.mcap
must downrange replay /tmp/flight.mcap --out /tmp/flown.mcap
says 'fused \(joint\)' downrange report /tmp/flown.mcap --truth /tmp/truth.mcap
must sh -c 'downrange experiment faults --list | grep -q gps-step-200'

if [ $booted = yes ]; then
  step "neither enabled nor started by itself; exposure"
  must_not systemctl is-enabled downranged
  must_not systemctl is-active downranged
  for unit in downranged.service downranged@site-a.service; do
    exposure=$(in_it systemd-analyze security --no-pager --threshold=15 $unit) || fail "exposure of $unit above 1.5"
    step "  $(tail -n 1 <<<"$exposure" | grep -oE 'Overall.*[0-9]\.[0-9]')"
  done

  step "started, and flown on the wall clock"
  must sh -c 'echo "DOWNRANGE_OPTIONS=\"--set ingest.expect_simulated=true\"" >>/etc/downrange/downranged.env'
  must mkdir -p /etc/systemd/system/downranged.service.d
  must sh -c 'downrange firewall /etc/downrange/range.toml --for systemd >/etc/systemd/system/downranged.service.d/peers.conf'
  must systemctl daemon-reload
  says '192.0.2.0/24' systemctl show -P IPAddressAllow downranged
  must_not sh -c 'systemctl show -P IPAddressAllow downranged | grep -F 172.16'
  must systemctl enable --now downranged
  must systemctl is-active downranged
  in_it sh -c 'echo $$ >/tmp/watch.pid && exec downrange watch /etc/downrange/range.toml --plain --set ingest.expect_simulated=true' \
    >"$place/watch.log" 2>&1 </dev/null &
  watch=$!
  in_it downrange simulate /etc/downrange/range.toml --dds --clock wall --set ingest.expect_simulated=true --scenario /tmp/short.toml \
    >"$place/sensors.log" 2>&1 </dev/null &
  sensors=$!
  commanded() { grep -cE '^goheung-tm .*for .* az ' "$place/watch.log" || true; }
  # more WHAT: the antennas are given commands, newer than those until now.
  more() {
    local before
    before=$(commanded)
    for _ in {1..120}; do
      [ "$(commanded)" -le "$before" ] || return 0
      sleep 0.5
    done
    tail -n 5 "$place/sensors.log" "$place/watch.log" >>"$log"
    fail "no pointing command $1"
  }
  more "in flight"

  step "killed in flight: started again, and goes on pointing"
  pid=$(property downranged MainPID)
  must systemctl kill --kill-who=main --signal=KILL downranged
  soon "another process" 20 sh -c "test \$(systemctl show -P MainPID downranged) -ne $pid && systemctl is-active downranged"
  more "after kill -9"

  step "hung in flight: the watchdog ends it, started again"
  pid=$(property downranged MainPID)
  must systemctl kill --kill-who=main --signal=STOP downranged
  soon "the watchdog" 60 sh -c "test \$(systemctl show -P MainPID downranged) -ne $pid && systemctl is-active downranged"
  journal_says downranged 'Watchdog timeout' || fail "the journal knows nothing of the watchdog"
  wait $sensors || fail "the simulated sensors"
  must sh -c 'kill $(cat /tmp/watch.pid)'
  wait $watch || fail "downrange watch"

  step "who is no peer is not heard"
  must ip address add 192.0.2.10/32 dev lo
  must ip address add 203.0.113.10/32 dev lo
  # heard_from ADDRESS: do datagrams from there reach a process that is filtered as the unit is?
  cat >"$root/opt/send.pl" <<'EOF'
use IO::Socket::INET;
my $socket = IO::Socket::INET->new(LocalAddr => $ARGV[0], PeerAddr => "127.0.0.1", PeerPort => 7410, Proto => "udp") or die;
for (1 .. 80) { $socket->send("hello"); select undef, undef, undef, 0.1 }
EOF
  cat >"$root/opt/listen.pl" <<'EOF'
use IO::Socket::INET;
my $socket = IO::Socket::INET->new(LocalPort => 7410, Proto => "udp") or die;
$SIG{ALRM} = sub { print "heard nobody\n"; exit };
alarm 5;
my $text = "";
$socket->recv($text, 10) until $text eq "hello";
print "heard ", $socket->peerhost, "\n";
EOF
  heard_from() {
    local sender heard
    in_it perl /opt/send.pl "$1" >/dev/null 2>&1 </dev/null &
    sender=$!
    heard=$(in_it systemd-run -q --pipe --wait -p IPAddressDeny=any -p "IPAddressAllow=$(property downranged IPAddressAllow)" perl /opt/listen.pl </dev/null)
    wait $sender || true
    echo "$1: $heard" >>"$log"
    [ "$heard" = "heard $1" ]
  }
  must systemctl stop downranged
  heard_from 192.0.2.10 || fail "a peer of dds.peers is not heard"
  if heard_from 203.0.113.10; then
    in_it sh -c 'journalctl -b --no-pager | grep -q "does not support BPF/cgroup firewalling"' || fail "a stranger is heard"
    warn "this kernel filters no addresses for systemd: IPAddressAllow is NOT tried"
  fi
  must ip address del 192.0.2.10/32 dev lo
  must ip address del 203.0.113.10/32 dev lo
  must systemctl start downranged

  step "reload: a wrong file fails, and changes nothing"
  pid=$(property downranged MainPID)
  must systemctl reload downranged
  must sed -i.good 's/^sigma_range_m = .*/sigma_range_m = -3/' /etc/downrange/range.toml
  must_not systemctl reload downranged
  journal_says downranged 'sigma_range_m: found -3' || fail "the journal does not say what is wrong"
  must systemctl is-active downranged
  must mv /etc/downrange/range.toml.good /etc/downrange/range.toml
  must systemctl reload downranged
  [ "$(property downranged MainPID)" = "$pid" ] || fail "a reload restarted the service"

  step "a node of its own beside it; a start that never succeeds is given up"
  must sh -c 'echo "DOWNRANGE_OPTIONS=\"--stages ingest --sources goheung,goheung-tgs\"" >/etc/downrange/site-a.env'
  must systemctl enable --now downranged@site-a
  journal_says downranged@site-a 'node site-a of range naro' || fail "downranged@site-a is not node site-a"
  must sh -c 'echo "DOWNRANGE_OPTIONS=\"--set log.file=/absent/log\"" >/etc/downrange/site-b.env'
  must_not systemctl start downranged@site-b
  soon "the limit of starts" 120 sh -c 'test "$(systemctl show -P Result downranged@site-b)" = start-limit-hit || systemctl status downranged@site-b | grep -q "Start request repeated too quickly"'
  must systemctl reset-failed downranged@site-b
  must sh -c 'echo "DOWNRANGE_CONFIG=/etc/downrange/absent.toml" >/etc/downrange/site-c.env'
  must_not systemctl start downranged@site-c
  [ "$(property downranged@site-c NRestarts)" = 0 ] || fail "a wrong configuration was tried again"
  must systemctl reset-failed downranged@site-c

  step "upgraded: configuration stays as its owner left it, the running service goes on"
  mkdir -p "$place/next"
  rm -rf "$place/next/tree"
  dpkg-deb -R "$packages"/downrange_*.deb "$place/next/tree"
  sed -i 's/^Version: .*/&.1/' "$place/next/tree/DEBIAN/control"
  echo "# of the next version" >>"$place/next/tree/etc/downrange/range.toml"
  dpkg-deb --root-owner-group -b "$place/next/tree" "$root/packages/next.deb" >>"$log"
  must sh -c 'echo "# of the range" >>/etc/downrange/range.toml'
  pid=$(property downranged MainPID)
  must sh -c "$install /packages/next.deb"
  says '\.1$' dpkg-query -W -f '${Version}' downrange
  must grep -qx '# of the range' /etc/downrange/range.toml
  must_not grep -qx '# of the next version' /etc/downrange/range.toml
  [ "$(property downranged MainPID)" = "$pid" ] || fail "the upgrade restarted the service"
  must systemctl restart downranged
  must systemctl is-active downranged
fi

step "removed: nothing runs; configuration and flights stay"
must apt-get -qy remove downrange
must_not sh -c 'grep -qsx downranged /proc/[0-9]*/comm || test -e /usr/bin/downrange'
must test -e /etc/downrange/range.toml
if [ $booted = yes ]; then
  says 'mcap' ls /var/lib/downrange
  step "installed again: enabled as before"
  must sh -c "$install /packages/downrange_*.deb"
  must systemctl is-enabled downranged
  must grep -qx '# of the range' /etc/downrange/range.toml
  step "purged: the flights are kept, and said so"
  says 'recorded flights are kept in /var/lib/downrange' apt-get -qy purge downrange
  says 'mcap' ls /var/lib/downrange
  must_not test -e /etc/downrange
  step "purged as answered beforehand: nothing is left"
  must sh -c "$install /packages/downrange_*.deb"
  must sh -c 'echo "downrange downrange/remove-flights boolean true" | debconf-set-selections'
fi
must apt-get -qy purge downrange
# What was made by hand, as the handbook says.
rm -rf "$root/packages" "$root/etc/systemd/system/downranged.service.d" "$root/etc/nftables-downrange.conf"
left=$(cd "$root" && find . -xdev -name '*downrange*' -not -path './proc/*' -not -path './sys/*' -not -path './tmp/*')
[ -z "$left" ] || fail "left behind: $left"
must_not getent passwd downrange
must_not getent group downrange

step "downrange-dev: the examples are built against it and fly"
rm -rf "$place/develop"
for package in "$packages"/downrange-{idl,dev}_*.deb; do dpkg-deb -x "$package" "$place/develop"; done
cmake -S "$place/develop/usr/share/doc/downrange-dev/examples" -B "$place/develop/build" -DCMAKE_PREFIX_PATH="$place/develop/usr" >>"$log" 2>&1 &&
  cmake --build "$place/develop/build" --target fly_csv >>"$log" 2>&1 || fail "the examples are not built"
"$place/develop/build/fly_csv" "$place/develop/usr/share/doc/downrange-dev/examples/flight" >>"$log" || fail "fly_csv"

rm -rf "$place/next" "$place/develop"
if [ $booted = yes ]; then step "all as it should be"; else step "what needs no systemd is as it should be; the rest was not tried"; fi
