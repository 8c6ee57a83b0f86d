# For tests/check/package and tests/check/plain_clone: fresh Debian systems in folders, and commands in them. As root; needs
# mmdebstrap. Sets `checkout`, `place` (the folder for the systems), `cache` (ccache's) and `path`. The script that sources it sets
# `name`, the release's name, and `begin`, the SECONDS from which `say` counts.
checkout=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
place=${VACUFORM_PACKAGE_CHECK:-/var/tmp/vacuform-package}
cache=${CCACHE_DIR:-$HOME/.cache/ccache}
declare -A names=([12]=bookworm [13]=trixie)
path=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin

fail() { echo "tests/check/${0##*/}: $1" >&2; exit 1; }
say() { printf '%s %5d s  %s\n' "$name" $((SECONDS - begin)) "$1"; }

# in_own_mounts "$@": runs the script again in mount and process namespaces that end with it.
in_own_mounts() {
  if [ -z "${VACUFORM_UNSHARED-}" ]; then
    [ "$(id -u)" -eq 0 ] || fail "run this as root"
    command -v mmdebstrap >/dev/null || fail "mmdebstrap is missing: apt-get install mmdebstrap"
    exec env VACUFORM_UNSHARED=yes unshare --mount --propagation private --kill-child --fork --pid --mount-proc "$0" "$@"
  fi
  mkdir -p "$place" "$cache"
}

# fresh FOLDER: a system with no more than Debian's required packages, systemd and certificates.
fresh() {
  local tar=$place/$name.tar
  if [ ! -e "$tar" ]; then
    mmdebstrap -q --format=tar --variant=minbase --include=systemd-sysv,dbus,ca-certificates "$name" "$tar.part" http://deb.debian.org/debian
    mv "$tar.part" "$tar"
  fi
  rm -rf "$1"
  mkdir -p "$1"
  tar -C "$1" -xf "$tar"
}

# within FOLDER COMMAND...: in that system, with this machine's network and processes; nothing is started. It is the root of its
# mount namespace, since processes in a chroot get no user namespaces.
within() {
  local system=$1
  (
    unshare_and_run() {
      mount --bind "$system" "$system"
      for own in proc sys dev; do mount --rbind "/$own" "$system/$own"; done
      cp /etc/resolv.conf /etc/hosts "$system/etc/"
      [ ! -d "$system/ccache" ] || mount --bind "$cache" "$system/ccache"
      certificates=()
      if [ -n "${NODE_EXTRA_CA_CERTS-}" ]; then
        cp "$NODE_EXTRA_CA_CERTS" "$system/certificates.pem"
        certificates=(NODE_EXTRA_CA_CERTS=/certificates.pem)
      fi
      cd "$system"
      pivot_root . mnt
      umount -l /mnt
      exec env -i "PATH=$path" HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive CCACHE_DIR=/ccache "${certificates[@]}" "$@"
    }
    export -f unshare_and_run
    export system cache path
    unshare --mount bash -euc 'unshare_and_run "$@"' - "${@:2}"
  )
}
