# Sets `jobs`: how many compilers fit into this machine. One on this code needs up to 1.5 GiB.
cores=$(nproc)
fitting=$(awk '/^MemAvailable:/ { print int($2 / 1024 / 1536) }' /proc/meminfo)
# shellcheck disable=SC2034
jobs=$((fitting < 1 ? 1 : fitting < cores ? fitting : cores))
