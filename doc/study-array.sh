#!/usr/bin/env bash
# A study shared out over a Slurm array: each task makes one shard, and what a task has finished is on the disk, so that
# an array that ran out of time is submitted again as it was. OUT is on a disk that all nodes see.
#
#   sbatch --array=1-8 doc/study-array.sh OUT SCENE... --methods A,B,... [more of perp study]
#   perp study --merge OUT/shard-* --out OUT                                      # when all have ended
#
#SBATCH --job-name=perp-study
#SBATCH --array=1-4
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --time=01:00:00
#SBATCH --output=perp-study-%A-%a.log
set -euo pipefail

out=$1
shift
shard=$SLURM_ARRAY_TASK_ID
exec "${PERP:-perp}" study "$@" --shard "$shard/$SLURM_ARRAY_TASK_COUNT" --out "$out/shard-$shard"
