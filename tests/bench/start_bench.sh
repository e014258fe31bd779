#!/bin/sh
# Time from exec to the first answer, and resident memory when idle.
#   tests/bench/start_bench.sh [FAULTLAB_BINARY] [ROUNDS]       goals: <= 0.3 s, <= 60 MB
set -eu
binary=${1:-build/release/faultlab}
rounds=${2:-5}
round=1
while [ "$round" -le "$rounds" ]; do
  work=$(mktemp -d)
  begin=$(date +%s.%N)
  "$binary" serve --listen 127.0.0.1:18992 --data "$work/data" >"$work/out" 2>"$work/err" &
  pid=$!
  until curl -fs http://127.0.0.1:18992/healthz >/dev/null; do sleep 0.01; done
  end=$(date +%s.%N)
  resident=$(awk '/VmRSS/ {print $2}' "/proc/$pid/status")
  awk -v r="$round" -v a="$begin" -v b="$end" -v m="$resident" 'BEGIN {
    printf "round %d: first answer after %.3f s (goal <= 0.3), resident %.1f MB (goal <= 60)\n", r, b - a, m / 1024 }'
  kill "$pid"
  wait "$pid" || true
  rm -rf "$work"
  round=$((round + 1))
done
