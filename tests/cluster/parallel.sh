#!/usr/bin/env bash
# A study's shards under GNU parallel, put together: its tables must be those of the study in one piece.
#   tests/cluster/parallel.sh PERP
set -euo pipefail
perp=$(realpath "$1")
command -v parallel >/dev/null || { echo "skipped: GNU parallel is not installed"; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

study=(oblique-sphere bead-in-ring --methods lcp,lcp-ap --steps T/20,T/40,T/80,T/160,T/320)
parallel --will-cite --halt now,fail=1 \
  "$perp" study "${study[@]}" --shard '{}/3' --out "$work/out/shard-{}" ::: 1 2 3
"$perp" study --merge "$work"/out/shard-* --out "$work/out"
"$perp" study "${study[@]}" --out "$work/whole" >/dev/null
tables() { cut -d, -f1-7,9- "$1/study.csv"; }  # all but the seconds
diff <(tables "$work/whole") <(tables "$work/out")
diff "$work/whole/orders.csv" "$work/out/orders.csv"
echo "the shards' tables are those of the study in one piece"
