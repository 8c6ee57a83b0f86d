# The release build; read by deploy/start, deploy/install and deploy/package, which define refuse().
# shellcheck shell=bash
# shellcheck source=deploy/machine.bash
source "$(dirname "${BASH_SOURCE[0]}")/machine.bash"

# build_release CHECKOUT [TARGET...]: its programs are then in CHECKOUT/build/release/bin.
build_release() {
  local checkout=$1 jobs configured
  "$checkout/deploy/packages"
  jobs=$(least "$cores" "$(at_least_one $((memory_mib / 1536)))")
  echo "Building the release in $checkout/build/release ($jobs at a time)."
  cd "$checkout" || refuse "there is no $checkout"
  configured=$(cmake --preset release 2>&1) || { echo "$configured" >&2; refuse "the build cannot be configured"; }
  cmake --build --preset release -j "$jobs" --target vacuform vacuform-server vacuform-worker "${@:2}"
}
