#!/bin/sh
# One run as a job, with curl alone: submit, wait, fetch diagnosis and data.
#   client.sh URL API_KEY [component value]
# The key needs the scopes jobs and runs:read.
set -eu
url=${1:?URL, for example http://localhost:8080}/api/v1
key=${2:?API key}
component=${3:-R1}
value=${4:-100}

api() {
  curl --silent --show-error --fail-with-body --retry 5 --header "Authorization: Bearer $key" "$@"
}
# The first "name":"text" of an answer.
field() {
  sed -n "s/.*\"$1\":\"\([^\"]*\)\".*/\1/p" | head -n 1
}

answer=$(api --header 'Content-Type: application/json' --header "Idempotency-Key: $(date +%s)-$$" \
  --data "{\"runs\":[{\"faults\":[{\"component\":\"$component\",\"value\":$value,\"at_s\":10}]}]}" \
  "$url/jobs")
job=$(printf '%s' "$answer" | sed 's/.*"items"//' | field id)

state=waiting
while [ "$state" = waiting ] || [ "$state" = running ]; do
  sleep 0.5
  answer=$(api "$url/jobs/$job")
  state=$(printf '%s' "$answer" | field state)
done
if [ "$state" != finished ]; then
  printf 'the job %s: %s\n' "$state" "$answer" >&2
  exit 1
fi
run=$(printf '%s' "$answer" | field run)
api "$url/runs/$run/diagnosis"
echo
api --output "$run.csv" "$url/runs/$run/export.csv"
echo "samples in $run.csv" >&2
