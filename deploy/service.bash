# Where the service keeps its things and whether it runs; read by deploy/start and deploy/stop.
# shellcheck shell=bash disable=SC2034

checkout=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
programs=$checkout/build/release/bin
data=${VACUFORM_DATA:-$checkout/var}  # jobs and scans, readable by the owner alone
case $data in /*) ;; *) data=$PWD/$data ;; esac
pid_file=$data/server.pid
log_file=$data/server.log
url_file=$data/server.url
token_file=$data/token  # of the owner "local": makes jobs and sees them
build_file=$data/server.build  # checksums of the programs that were started

# Prints the server's process id; fails when it does not run. A process id that now belongs to another program,
# as after a reboot, does not count.
server_pid() {
  local pid program
  pid=$(cat "$pid_file" 2>/dev/null) && [[ $pid =~ ^[0-9]+$ ]] || return 1
  program=$(readlink "/proc/$pid/exe" 2>/dev/null) || return 1
  [[ ${program% (deleted)} == "$programs/vacuform-server" ]] || return 1
  echo "$pid"
}
