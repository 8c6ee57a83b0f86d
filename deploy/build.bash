# The release build, and the capacity of this machine; read by deploy/start and deploy/install, which define refuse().
# shellcheck shell=bash

as_root=()

# Memory: a compiler needs up to 1.5 GiB for this code, and a worker needs up to 1 GiB.
cores=$(nproc)
memory_mib=$(awk '/^MemAvailable:/ { print int($2 / 1024) }' /proc/meminfo)
at_least_one() { echo $(($1 < 1 ? 1 : $1)); }
least() { echo $(($1 < $2 ? $1 : $2)); }

# The number of workers for a machine of this size.
fitting_workers() { least 2 "$(least "$cores" "$(at_least_one $((memory_mib / 2048)))")"; }

# build_release CHECKOUT: its programs are then in CHECKOUT/build/release/bin.
build_release() {
  local checkout=$1 jobs configured
  "$checkout/deploy/packages"
  jobs=$(least "$cores" "$(at_least_one $((memory_mib / 1536)))")
  echo "Building the release in $checkout/build/release ($jobs at a time)."
  cd "$checkout" || refuse "there is no $checkout"
  configured=$(cmake --preset release 2>&1) || { echo "$configured" >&2; refuse "the build cannot be configured"; }
  cmake --build --preset release -j "$jobs" --target vacuform vacuform-server vacuform-worker
}

# make_user NAME: creates a user without rights if it is absent, with the command in `as_root` if that is set.
make_user() {
  getent passwd "$1" >/dev/null && return
  "${as_root[@]}" useradd --system --user-group --no-create-home --home-dir /nonexistent --shell /usr/sbin/nologin "$1" ||
    refuse "the user $1 cannot be made; make it, then repeat this"
  echo "The user $1 is made."
}

# load_profiles CHECKOUT URL ADMIN_TOKEN: the machines and sheets of deploy/profiles become profiles of the service.
load_profiles() {
  local profile
  for profile in "$1"/deploy/profiles/*.json; do
    curl -sf --noproxy '*' -o /dev/null -X PUT -H @<(echo "Authorization: Bearer $3") -H 'Content-Type: application/json' \
      --data-binary "@$profile" "$2/api/v1/profiles/$(basename "$profile" .json)" ||
      refuse "the profile $profile was not taken (the service is running); repeat this to try again"
  done
  echo "The machines and sheets of deploy/profiles are profiles of the service."
}
