#!/usr/bin/env bash
# A real Slurm on this machine runs a campaign as an array of eight. Merged, its results must equal those of a single
# process, byte for byte, even if a task is killed halfway and runs again.
# Usage: tests/slurm.sh STEWARD
# Needs slurm-wlm and munge (Debian's names). They run as the current user, on their own ports and with their own files,
# and are stopped at the end; a Slurm that is already on the machine is not touched.
set -euo pipefail
steward=$(realpath "$1")
repository=$(realpath "$(dirname "$0")/..")
PATH=$PATH:/usr/sbin
for program in munged slurmctld slurmd sbatch scontrol sinfo; do
  command -v "$program" > /dev/null || { echo "$program is missing: install slurm-wlm and munge" >&2; exit 3; }
done

work=$(mktemp -d)
chmod 755 "$work"
daemons=()
stop() {
  status=$?
  [ $status = 0 ] || tail -n 20 "$work"/*.log >&2
  for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do
    kill "${daemons[i]}" 2> /dev/null && wait "${daemons[i]}" 2> /dev/null || true
  done
  rm -rf "$work"
  exit $status
}
trap stop EXIT

# Waits until the command succeeds, for a minute at most.
until_done() {
  for _ in $(seq 120); do
    "$@" > /dev/null 2>&1 && return
    sleep 0.5
  done
  echo "timed out waiting for: $*" >&2
  return 1
}

mkdir -m 755 "$work/munge"
(umask 077 && head -c 1024 /dev/urandom > "$work/munge/key")
munged --foreground --key-file="$work/munge/key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
  --log-file="$work/munge.log" --seed-file="$work/munge/seed" > "$work/munged.log" 2>&1 &
daemons+=($!)
until_done test -S "$work/munge/socket"

host=$(hostname -s)
mkdir "$work/state" "$work/spool"
cat > "$work/slurm.conf" << CONF
ClusterName=steward
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
AccountingStorageType=accounting_storage/none
MailProg=/bin/true
SchedulerParameters=batch_sched_delay=0,sched_interval=1
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
slurmctld -D > "$work/slurmctld.log" 2>&1 &
daemons+=($!)
slurmd -D > "$work/slurmd.log" 2>&1 &
daemons+=($!)
idle() { [ "$(sinfo --noheader --format=%t)" = idle ]; }
until_done idle

cat > "$work/sharded.toml" << TOML
scenario = "errand"
sampling = "sobol"
runs = 50
[[parameters]]
key = "battery.initial_pct"
from = 20
to = 60
TOML

"$steward" campaign "$work/sharded.toml" --out "$work/alone" --quiet
array() {
  STEWARD=$steward sbatch --quiet "$@" --chdir="$work" "$repository/scenarios/campaigns/slurm.sbatch" "$work/sharded.toml" "$work/array"
}
merged_is_the_same() {
  "$steward" campaign merge "$work"/array/shard-* --out "$work/merged-$1" > /dev/null
  for file in dataset.parquet summary.json; do
    cmp "$work/alone/$file" "$work/merged-$1/$file"
  done
}

array --wait
[ "$(ls -d "$work"/array/shard-* | wc -l)" = 8 ]
merged_is_the_same whole

# A task that breaks off in the middle of a line is submitted again, together with the others, which have nothing left
# to do.
journal=$work/array/shard-3-of-8/journal.jsonl
truncate --size=$(($(stat --format=%s "$journal") * 2 / 3)) "$journal"
array --wait
merged_is_the_same resumed
echo "an array of 8 in Slurm, merged: the same bytes as from one process, even after a task broke off"
