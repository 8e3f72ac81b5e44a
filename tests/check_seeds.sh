#!/bin/sh
# Replays every fuzzing seed and everything that once broke through the fuzzing target, with sanitisers; each is also
# mutated a few times. Prints TAP; run from the root. FUZZ_ROUNDS=n for more.
set -u
B=build/seeds
mkdir -p "$B"
echo 1..2
if ! gcc -std=c99 -Wall -Wextra -g -O1 -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -DFUZZ_MAIN -I. tests/fuzz.c -o "$B/replay" -lm >"$B/log" 2>&1; then
    echo "not ok 1 - the fuzzing target compiles"; sed 's/^/# /' "$B/log" | head; echo "not ok 2 - replay"; exit 1
fi
echo "ok 1 - the fuzzing target compiles"
set -- tests/fuzz_seeds/* tests/data/*.lens lenses/*.lens
for f in tests/data/broken/*; do [ -f "$f" ] && set -- "$@" "$f"; done
if FUZZ_ROUNDS=${FUZZ_ROUNDS:-8} FUZZ_DUMP="$B/last" timeout 500 "$B/replay" "$@" >"$B/log" 2>&1; then
    echo "ok 2 - $(sed -n 's/^reached: //p' "$B/log")"
else
    echo "not ok 2 - a seed, or a mutant of one: it is in $B/last"
    sed 's/^/# /' "$B/log" | head -30
fi
