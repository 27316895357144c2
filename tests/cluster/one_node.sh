#!/usr/bin/env bash
# A study as an array on a Slurm of one node, this machine, started here and stopped again; its tables must be those of
# the study in one piece. Needs slurmctld, slurmd, munged and root. What cannot be had is said as "skipped: ...".
#   tests/cluster/one_node.sh PERP
set -euo pipefail
perp=$(realpath "$1")
root=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")
export PATH=$PATH:/usr/sbin:/sbin

for program in slurmctld slurmd munged sbatch squeue; do
  command -v "$program" >/dev/null || { echo "skipped: $program is not installed"; exit 0; }
done
((EUID == 0)) || { echo "skipped: daemons need root"; exit 0; }

work=$(mktemp -d /tmp/perp-cluster.XXXXXX)
chmod 755 "$work"
daemons=()
finish() {
  ((${#daemons[@]} == 0)) || kill "${daemons[@]}" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
say_why() { echo "skipped: $1"; tail -n 5 "$work"/*.log 2>/dev/null; exit 0; }

# munge: a key and a socket of its own
mkdir -m 755 "$work/munge"
head -c 128 /dev/urandom >"$work/munge/key"
chmod 600 "$work/munge/key"
munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge/socket" --num-threads=1 \
  --pid-file="$work/munge/pid" --log-file="$work/munged.log" --seed-file="$work/munge/seed" >"$work/munge.out" 2>&1 &
daemons+=($!)

host=$(hostname -s)
mkdir "$work/state" "$work/spool"
cat >"$work/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort=26817
SlurmdPort=26818
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=sched_interval=1
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf

slurmctld -D -f "$SLURM_CONF" >"$work/slurmctld.out" 2>&1 &
daemons+=($!)
slurmd -D -f "$SLURM_CONF" >"$work/slurmd.out" 2>&1 &
daemons+=($!)
for _ in {1..60}; do
  [[ $(sinfo --noheader --format=%t 2>/dev/null) == idle ]] && break
  sleep 0.5
done
[[ $(sinfo --noheader --format=%t 2>/dev/null) == idle ]] || say_why "the node does not come up: $(sinfo --noheader 2>&1)"

study=(oblique-sphere bead-in-ring --methods lcp,lcp-ap --steps T/20,T/40,T/80,T/160,T/320)
cd "$work"
PERP=$perp sbatch --wait --array=1-3 "$root/doc/study-array.sh" "$work/out" "${study[@]}"
cat "$work"/perp-study-*.log
[[ -n $(ls "$work"/out/shard-{1,2,3}/runs.journal) ]]
"$perp" study --merge "$work"/out/shard-* --out "$work/out"
"$perp" study "${study[@]}" --out "$work/whole" >/dev/null

tables() { cut -d, -f1-7,9- "$1/study.csv"; }  # all but the seconds
diff <(tables "$work/whole") <(tables "$work/out")
diff "$work/whole/orders.csv" "$work/out/orders.csv"
echo "the array's tables are those of the study in one piece"
