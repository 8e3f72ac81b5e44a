#!/bin/sh
# Fuzzes every stage for SECONDS (1800) in build/fuzz, two jobs at most (JOBS). The corpus is kept and merged; what breaks
# lies in build/fuzz/crash-*. Needs clang with libFuzzer (tests/run installs it). Run from the root: tests/fuzz.sh 600
set -eu
seconds=${1:-${SECONDS_:-1800}}
jobs=${JOBS:-2}
root=$(pwd)
B=build/fuzz
mkdir -p "$B/corpus"
clang -std=c99 -g -O2 -fsanitize=fuzzer,address,undefined,float-cast-overflow -fno-sanitize-recover=undefined,float-cast-overflow \
    -I. tests/fuzz.c -o "$B/fuzz" -lm
cd "$B"
rm -f fuzz-*.log
status=0
./fuzz corpus "$root/tests/fuzz_seeds" -dict="$root/tests/fuzz.dict" -max_len=8000 -timeout=20 -rss_limit_mb=2000 \
    -jobs="$jobs" -workers="$jobs" -max_total_time="$seconds" >jobs.log 2>&1 || status=$?
rm -rf merged
mkdir merged
./fuzz -merge=1 merged corpus "$root/tests/fuzz_seeds" >merge.log 2>&1 && { rm -rf corpus; mv merged corpus; }
cat fuzz-*.log | awk '
    /^Done [0-9]+ runs/ {runs += $2}
    /^reached:/ {inputs += $3; rendered += $9; ghosts += $11}
    END {printf "%d executions, %d inputs rendered (%.1f %%), %d of them with ghosts in the picture\n", inputs, rendered, inputs ? 100 * rendered / inputs : 0, ghosts}'
echo "corpus: $(ls corpus | wc -l) inputs in $B/corpus"
for f in crash-* timeout-* oom-* leak-*; do
    [ -e "$f" ] || continue
    echo "FOUND: $B/$f"
    status=1
done
grep -hE 'check failed|runtime error|SUMMARY' fuzz-*.log | sort | uniq -c | head -20
exit $status
