#!/bin/bash
# try_on.sh <bookworm|trixie|...> [command...]: runs commands, `make demo` and `make test` unless others are given, in a
# fresh clone of what is committed here, on a fresh system of that name, and says at the end how each of them ended.
#
# It needs root, debootstrap, and some 6 GB where TMPDIR is (default: /var/tmp). Mirror and settings of apt, pip and
# proxies are those of this machine; MIRROR=<address> names another mirror. Network and kernel are shared with this
# machine, so nothing else should use lcm meanwhile. All that it makes is removed when it ends.
set -euo pipefail
cd "$(dirname "$0")/.."

# What runs inside, as the first process of its own namespaces, in the folder of the fresh system.
inside() {
  mount --bind "$1" "$1"  # a mount point, as the root of a system is: unshare(1) wants one
  cd "$1"
  shift
  mount -t proc proc proc
  mount --rbind /sys sys
  mount --rbind /dev dev
  mount -t tmpfs tmpfs run
  mount -t tmpfs tmpfs dev/shm
  local kept=()
  mapfile -t kept < <(env | grep -E '^(PIP_|SSL_CERT_|https?_proxy=|HTTPS?_PROXY=|no_proxy=|NO_PROXY=|TERM=)')
  local in_tree=(env -i "${kept[@]}" HOME=/root LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
    chroot . env -C /root/robcl)

  local verdicts=() failed=0 command started status
  for command; do
    printf '\n════ %s\n' "$command"
    started=$SECONDS
    status=0
    "${in_tree[@]}" bash -c "$command" </dev/null 2>&1 | tee last-output || status=$?
    [ "$status" = 0 ] || failed=1
    verdicts+=("$(printf '%s %6d s  %s: %s' "$([ "$status" = 0 ] && echo passed || echo FAILED)" \
      $((SECONDS - started)) "$command" "$(grep -v '^[[:space:]]*$' last-output | tail -1)")")
  done
  printf '\n════ %s, %s\n' "$(. etc/os-release && echo "$PRETTY_NAME")" "$("${in_tree[@]}" git log -1 --format='commit %h')"
  printf '%s\n' "${verdicts[@]}"
  exit "$failed"
}
if [ "${1-}" = --inside ]; then
  shift
  inside "$@"
fi

[ $# -gt 0 ] || { sed -n '2,/^set/s/^# \{0,1\}//p' "$0" >&2; exit 2; }
suite=$1
shift
[ $# -gt 0 ] || set -- "make demo" "make test"
[ "$(id -u)" = 0 ] || { echo "try_on: this needs root, for chroot and mounts: sudo $0 $suite" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "try_on: there is no debootstrap: apt-get install debootstrap" >&2; exit 1; }
[ -z "$(git status --porcelain --untracked-files=no)" ] || echo "try_on: what is not committed is left out" >&2

codename=$(. /etc/os-release && echo "$VERSION_CODENAME")
mirror=${MIRROR:-$(apt-get indextargets --format '$(SITE) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' \
  | awk -v release="$codename" '$2 == release && $3 == "main" { print $1; exit }')}
[ -n "$mirror" ] || { echo "try_on: apt's sources name no mirror of $codename; set MIRROR" >&2; exit 1; }

system=$(mktemp -d "${TMPDIR:-/var/tmp}/try_on.XXXXXX")
trap 'rm -rf --one-file-system "$system"' EXIT  # the mounts were in namespaces of their own, which are gone
chmod 755 "$system"  # apt downloads as a user of its own
echo "try_on: $suite from $mirror"
debootstrap --variant=minbase --include=ca-certificates,git,make "$suite" "$system" "$mirror" >"$system.log" 2>&1 || {
  tail "$system.log"
  exit 1
}
rm "$system.log"

echo force-unsafe-io >"$system/etc/dpkg/dpkg.cfg.d/90try_on"  # what is thrown away need not reach the disk at once
cp /etc/resolv.conf /etc/hosts "$system/etc/"
apt-config dump | grep -E '^Acquire::(https?::|Check-|Retries)' >"$system/etc/apt/apt.conf.d/90host" || true
[ ! -f /etc/pip.conf ] || cp /etc/pip.conf "$system/etc/"
[ ! -f ~/.config/pip/pip.conf ] || install -D ~/.config/pip/pip.conf "$system/root/.config/pip/pip.conf"
cp -r /usr/local/share/ca-certificates "$system/usr/local/share/"
said=$(env -u TMPDIR chroot "$system" update-ca-certificates 2>&1) || { echo "$said"; exit 1; }
git clone --quiet --no-hardlinks . "$system/root/robcl"
unshare --mount --pid --fork --kill-child --propagation private "$0" --inside "$system" "$@"
