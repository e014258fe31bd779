#!/bin/sh
# Requests per second for a small JSON answer: faultlab, and nginx serving the same bytes from a
# file. Same machine, same client, alternating rounds; servers on core 0, wrk on core 1.
#   tests/bench/http_bench.sh [FAULTLAB_BINARY] [SECONDS] [ROUNDS]
set -eu
binary=${1:-build/release/faultlab}
seconds=${2:-5}
rounds=${3:-3}
for tool in nginx wrk taskset curl; do
  command -v "$tool" >/dev/null || { echo "http_bench: $tool is not installed" >&2; exit 1; }
done
work=$(mktemp -d)
pids=
trap 'kill $pids 2>/dev/null || true; wait; rm -rf "$work"' EXIT

mkdir "$work/root"
printf '{"status":"ok","service":"faultlab"}' >"$work/root/healthz"
cat >"$work/nginx.conf" <<CONF
daemon off; pid $work/nginx.pid; error_log $work/nginx.log; worker_processes 1;
events { worker_connections 1024; }
http {
  access_log off; keepalive_requests 1000000; default_type application/json; sendfile on; tcp_nopush on;
  open_file_cache max=100;
  client_body_temp_path $work/a; proxy_temp_path $work/b; fastcgi_temp_path $work/c;
  uwsgi_temp_path $work/d; scgi_temp_path $work/e;
  server { listen 127.0.0.1:18990; root $work/root; }
}
CONF
chmod -R a+rX "$work"
taskset -c 0 nginx -c "$work/nginx.conf" &
pids="$pids $!"
taskset -c 0 "$binary" serve --listen 127.0.0.1:18991 --data "$work/data" >"$work/out" &
pids="$pids $!"
for port in 18990 18991; do
  until curl -fs "http://127.0.0.1:$port/healthz" >/dev/null; do sleep 0.1; done
done

rate() { # PORT PATH
  taskset -c 1 wrk -t1 -c64 -d"${seconds}s" "http://127.0.0.1:$1$2" | awk '/Requests\/sec/ {print $2}'
}
round=1
while [ "$round" -le "$rounds" ]; do
  theirs=$(rate 18990 /healthz)
  ours=$(rate 18991 /healthz)
  awk -v r="$round" -v a="$ours" -v b="$theirs" 'BEGIN {
    printf "round %d: faultlab %.0f/s, nginx static %.0f/s, ratio %.2f (goal >= 0.8)\n", r, a, b, a / b }'
  round=$((round + 1))
done
