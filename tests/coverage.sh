#!/bin/sh
# Which lines of lensflare.h the fuzzing corpus reaches: replays build/fuzz/corpus, the seeds and the lenses, and prints the
# share of lines per room and altogether, without the room "gl", which nothing a file holds reaches. Run from the root, after tests/fuzz.sh.
set -eu
B=build/coverage
mkdir -p "$B"
tool() { for t in "$1" "$1-14" "/usr/lib/llvm-14/bin/$1"; do command -v "$t" >/dev/null 2>&1 && { echo "$t"; return; }; done; echo "$1 is missing: apt-get install llvm" >&2; exit 2; }
profdata=$(tool llvm-profdata)
cov=$(tool llvm-cov)
clang -std=c99 -DLFLARE_NO_GL -g -O1 -fprofile-instr-generate -fcoverage-mapping -DFUZZ_MAIN -I. tests/fuzz.c -o "$B/replay" -lm
find build/fuzz/corpus tests/fuzz_seeds lenses tests/data -type f 2>/dev/null >"$B/inputs"
tr '\n' '\0' <"$B/inputs" | LLVM_PROFILE_FILE="$B/part-%p.raw" xargs -0 "$B/replay" 2>"$B/log" || { tail -5 "$B/log"; exit 1; }
$profdata merge "$B"/part-*.raw -o "$B/all.profdata"
rm -f "$B"/part-*.raw
$cov show "$B/replay" -instr-profile="$B/all.profdata" "$(pwd)/lensflare.h" >"$B/lensflare.txt" 2>/dev/null ||
    $cov show "$B/replay" -instr-profile="$B/all.profdata" -name-regex='lflare' >"$B/lensflare.txt"
# "line| count|text": lines with a count are code
awk -F'|' '
    {line = $1 + 0; count = $2; gsub(/ /, "", count)}
    $0 ~ /\/\* >> [0-9]+ / {room = $0; sub(/.*>> /, "", room); sub(/ \*\/.*/, "", room)}
    line > 0 && count != "" && room != "" {if (!(room in all)) order[++rooms] = room; all[room]++; total++; if (count != "0") {hit[room]++; reached++} }
    END {
        for (i = 1; i <= rooms; i++) printf "%-22s %5d of %5d lines  %5.1f %%\n", order[i], hit[order[i]], all[order[i]], 100 * hit[order[i]] / all[order[i]]
        printf "%-22s %5d of %5d lines  %5.1f %%\n", "all", reached, total, total ? 100 * reached / total : 0
    }' "$B/lensflare.txt"
echo "$(wc -l <"$B/inputs") inputs; not reached: grep '|      0|' $B/lensflare.txt"
