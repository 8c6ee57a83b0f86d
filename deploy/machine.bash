# The capacity of this machine, its users, and the first profiles of a service; read by deploy/start, deploy/install and
# deploy/setup, which define refuse().
# shellcheck shell=bash disable=SC2034

# Memory: a compiler needs up to 1.5 GiB for this code, and a worker needs up to 1 GiB.
cores=$(nproc)
memory_mib=$(awk '/^MemAvailable:/ { print int($2 / 1024) }' /proc/meminfo)
at_least_one() { echo $(($1 < 1 ? 1 : $1)); }
least() { echo $(($1 < $2 ? $1 : $2)); }

# The number of workers for a machine of this size.
fitting_workers() { least 2 "$(least "$cores" "$(at_least_one $((memory_mib / 2048)))")"; }

# make_user NAME: creates a user without rights if it is absent. As root.
make_user() {
  getent passwd "$1" >/dev/null && return
  useradd --system --user-group --no-create-home --home-dir /nonexistent --shell /usr/sbin/nologin "$1" ||
    refuse "the user $1 cannot be made; make it, then repeat this"
  echo "The user $1 is made."
}

# load_profiles FOLDER URL ADMIN_TOKEN: the files of that folder become profiles of the service.
load_profiles() {
  local profile
  for profile in "$1"/*.json; do
    curl -sf --noproxy '*' -o /dev/null -X PUT -H @<(echo "Authorization: Bearer $3") -H 'Content-Type: application/json' \
      --data-binary "@$profile" "$2/api/v1/profiles/$(basename "$profile" .json)" ||
      refuse "the profile $profile was not taken (the service is running); repeat this to try again"
  done
  echo "The machines and sheets of $1 are profiles of the service."
}
