#!/bin/sh
# Fuzzes the readers of lensimport.h, and with what they accept every later stage, for SECONDS (1200) each, in
# build/fuzz_import; then prints the share of lensimport.h's lines that the corpus reaches, per room. FORMATS="1 4": some of
# them, numbered as lensimport_format is; FORMATS=all: one run that takes them all. A unit takes milliseconds (test_import looks
# after that): the time given to it is wall time, and machines are shared. Needs clang with libFuzzer. Run from the root.
set -eu
seconds=${1:-1200}
root=$(pwd)
B=build/fuzz_import
mkdir -p "$B"
status=0
clang -std=c99 -g -O2 -fsanitize=fuzzer,address,undefined,float-cast-overflow -fno-sanitize-recover=undefined,float-cast-overflow \
    -I. -Itests tests/fuzz_import.c -o "$B/fuzz" -lm
for format in ${FORMATS:-2 3 4 5 6 7 8 9}; do
    only=$format
    [ "$format" = all ] && only=0
    mkdir -p "$B/corpus-$format"
    (cd "$B" && FUZZ_FORMAT=$only ./fuzz "corpus-$format" "$root/tests/fuzz_seeds_import" -dict="$root/tests/fuzz_import.dict" -max_len=8000 -timeout=120 -rss_limit_mb=2000 \
        -artifact_prefix="found-$format-" -max_total_time="$seconds" >"log-$format" 2>&1) || status=1
    echo "format $format: $(grep -E '^(Done|reached)' "$B/log-$format" | tr '\n' ' ')"
    grep -hE 'check failed|runtime error|SUMMARY: [AUl]' "$B/log-$format" || true
done
tool() { for t in "$1" "$1-14" "/usr/lib/llvm-14/bin/$1"; do command -v "$t" >/dev/null 2>&1 && { echo "$t"; return; }; done; echo false; }
clang -std=c99 -DLFLARE_NO_GL -g -O1 -fprofile-instr-generate -fcoverage-mapping -DFUZZ_MAIN -DFUZZ_STAGES=1000000 -I. -Itests tests/fuzz_import.c -o "$B/replay" -lm
find "$B"/corpus-* tests/fuzz_seeds_import -type f | tr '\n' '\0' | LLVM_PROFILE_FILE="$B/part-%p.raw" xargs -0 "$B/replay" 2>/dev/null
$(tool llvm-profdata) merge "$B"/part-*.raw -o "$B/all.profdata"
rm -f "$B"/part-*.raw
$(tool llvm-cov) show "$B/replay" -instr-profile="$B/all.profdata" "$root/lenses/lensimport.h" >"$B/lines.txt"
awk -F'|' '
    {line = $1 + 0; count = $2; gsub(/ /, "", count)}
    $0 ~ /\/\* >> [0-9]+ / {room = $0; sub(/.*>> /, "", room); sub(/ \*\/.*/, "", room)}
    line > 0 && count != "" && room != "" {if (!(room in all)) order[++rooms] = room; all[room]++; total++; if (count != "0") {hit[room]++; reached++} }
    END {
        for (i = 1; i <= rooms; i++) printf "%-22s %5d of %5d lines  %5.1f %%\n", order[i], hit[order[i]], all[order[i]], 100 * hit[order[i]] / all[order[i]]
        printf "%-22s %5d of %5d lines  %5.1f %%\n", "all", reached, total, total ? 100 * reached / total : 0
    }' "$B/lines.txt"
exit $status
