#!/bin/sh
# lensimport.h: compilers, standards, linkage, symbols, sizes, its generated tables, sanitisers, a decimal comma. Prints TAP;
# run from the root.
set -u
B=build/import
rm -rf "$B" && mkdir -p "$B"
n=0
ok() { n=$((n + 1)); echo "ok $n - $1"; }
bad() { n=$((n + 1)); echo "not ok $n - $1"; sed 's/^/# /' "$B/log" | head -20; }
try() { what=$1; shift; if "$@" >"$B/log" 2>&1; then ok "$what"; else bad "$what"; fi; }
silent() { what=$1; shift; if "$@" >"$B/log" 2>&1 && [ ! -s "$B/log" ]; then ok "$what"; else bad "$what"; fi; }

W="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Werror -I."
C="$W -Wstrict-prototypes"
printf '#define LENSIMPORT_IMPLEMENTATION\n#include "lenses/lensimport.h"\n' >"$B/impl.c"
cp "$B/impl.c" "$B/impl.cpp"
printf '#include "lenses/lensimport.h"\nint main(void) { return lensimport_sniff("x", 1) != LENSIMPORT_UNKNOWN; }\n' >"$B/user.c"
cp "$B/user.c" "$B/user.cpp"
printf '#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\n' >"$B/lens.c"

try "gcc c99 without a warning" gcc -std=c99 $C -O2 -c "$B/impl.c" -o "$B/impl.o"
try "g++ c++11 without a warning" g++ -std=c++11 $W -O2 -c "$B/impl.cpp" -o "$B/impl_cpp.o"
try "clang c99 without a warning" clang -std=c99 $C -O2 -c "$B/impl.c" -o "$B/clang.o"
try "clang++ c++11 without a warning" clang++ -std=c++11 $W -fsyntax-only "$B/impl.cpp"
for std in c11 c17; do
    for cc in gcc clang; do try "$cc $std without a warning" $cc -std=$std $C -fsyntax-only "$B/impl.c"; done
done
try "g++ c++20 without a warning" g++ -std=c++20 $W -fsyntax-only "$B/impl.cpp"
try "clang++ c++20 without a warning" clang++ -std=c++20 $W -fsyntax-only "$B/impl.cpp"
try "LENSIMPORT_STATIC without a warning" gcc -std=c99 $C -DLENSIMPORT_STATIC -fsyntax-only "$B/impl.c"
try "LENSIMPORT_STATIC without a warning, C++" clang++ -std=c++11 $W -DLENSIMPORT_STATIC -fsyntax-only "$B/impl.cpp"
try "declarations alone" gcc -std=c99 $C -fsyntax-only -include lenses/lensimport.h -x c /dev/null
printf '#include "lenses/lensimport.h"\n#define LENSIMPORT_IMPLEMENTATION\n#include "lenses/lensimport.h"\n#include "lenses/lensimport.h"\n' >"$B/twice.c"
try "included twice, before and after the implementation" gcc -std=c99 $C -c "$B/twice.c" -o "$B/twice.o"
gcc -std=c99 -I. -O1 -c "$B/lens.c" -o "$B/lens.o"
try "C++ calls what C compiled" g++ -std=c++11 $W "$B/user.cpp" "$B/impl.o" "$B/lens.o" -o "$B/units" -lm
try "C calls what C++ compiled" gcc -std=c99 $C "$B/user.c" "$B/impl_cpp.o" "$B/lens.o" -o "$B/units" -lm

silent "every symbol exported begins with lensimport_, and there is no writable global" sh -c "gcc -std=c99 -fno-pic -fno-pie -I. -O1 -c $B/impl.c -o $B/symbols.o && nm $B/symbols.o >$B/names &&
    awk '\$2 ~ /^[TWV]\$/ && \$3 !~ /^lensimport_[a-z0-9]/ || \$2 ~ /^[DBCGSdbcgs]\$/ {print; wrong = 1} END {exit wrong}' $B/names"
silent "LENSIMPORT_STATIC exports nothing" sh -c "gcc -std=c99 -DLENSIMPORT_STATIC -I. -O2 -c $B/impl.c -o $B/static.o && nm -g $B/static.o >$B/names && sed '/ U /d' $B/names"
silent "nothing undefined but strings, mathematics and lflare_" sh -c "nm $B/impl.o >$B/names && awk '\$1 == \"U\" && \$2 !~ /^(lflare_[a-z0-9_]+|mem[a-z]+|str[a-z]+|pow|log10|floor|hypot|tan|sqrt|__stack_chk_fail|_GLOBAL_OFFSET_TABLE_)\$/' $B/names"
tables=$(nm -S --size-sort "$B/symbols.o" | awk '$4 ~ /^lensimport__(glasses|list|makers)$/ {print $2}' | while read -r hex; do printf '%d\n' "0x$hex"; done | awk '{sum += $1} END {print sum + 0}')
echo "$tables bytes" >"$B/log"
[ "$tables" -gt 20000 ] && [ "$tables" -le 40960 ] && ok "the glass catalogue takes $tables bytes" || bad "the glass catalogue's size"
lenses/glasses.sh lenses/lensimport.h >"$B/made.h" 2>"$B/log"
try "the tables of glasses are those beside the header (make glasses)" cmp "$B/made.h" lenses/lensimport.h
sed -n '/^ *@example$/,/^ *@end$/{/^ *@/d;s/^       //;p;}' lenses/lensimport.h >"$B/example.c"
for how in "gcc -x c -std=c99" "g++ -x c++ -std=c++11"; do
    if $how -Wall -Wextra -I. "$B/example.c" -o "$B/example" -lm >"$B/log" 2>&1 && [ ! -s "$B/log" ] && "$B/example" tests/fuzz_seeds_import/seq-radii >"$B/log" && grep -qx 'CODE V, focal length 100.00 mm' "$B/log"; then ok "the example in lensimport.h: ${how%% *}"; else bad "the example in lensimport.h: ${how%% *}"; fi
done
grep -o '^/\* >> [0-9]* [a-z0-9 ]*' lenses/lensimport.h | sed 's,^/\* ,,; s/ *$//' >"$B/rooms"
sed -n '/CONTENTS/,/FORMATS/s/^ *\(>> [0-9]* .*\)/\1/p' lenses/lensimport.h >"$B/contents"
try "the contents name the rooms" diff "$B/rooms" "$B/contents"

S="-std=c99 -g -O1 -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -I."
if gcc $S tests/test_import.c -o "$B/test_import" -lcmocka -lm >"$B/log" 2>&1 && "$B/test_import" >"$B/log" 2>&1; then ok "test_import with sanitisers"; else
    grep -E 'runtime error|ERROR|FAILED|rror' "$B/log" >"$B/log2"; mv "$B/log2" "$B/log"; bad "test_import with sanitisers"; fi
if printf 'int main(void) { return 0; }\n' | gcc -m32 -x c - -o "$B/m32" 2>/dev/null; then
    try "32 bits without a warning" gcc -m32 -std=c99 $C -O2 -c "$B/impl.c" -o "$B/impl32.o"
else
    n=$((n + 1)); echo "ok $n # SKIP 32 bits: gcc-multilib is missing"
fi

# ---- the fuzzing target, with seeds and mutants of them ----
if gcc -Wall -Wextra $S -DFUZZ_MAIN -DFUZZ_STAGES=6 -Itests tests/fuzz_import.c -o "$B/replay" -lm >"$B/log" 2>&1 &&
    FUZZ_ROUNDS=${FUZZ_ROUNDS:-6} FUZZ_DUMP="$B/last" timeout 500 "$B/replay" tests/fuzz_seeds_import/* >"$B/log" 2>&1; then ok "$(sed -n 's/^reached: //p' "$B/log")"; else bad "a seed of the readers, or a mutant of one: it is in $B/last"; fi

# ---- the tool ----
flare=build/flare seeds=tests/fuzz_seeds_import
result() { if [ "$1" = 0 ]; then ok "$2"; else bad "$2"; fi; }
refused() { # WHAT PATTERN ARGUMENTS...: status 2, one line on stderr that matches, nothing on stdout
    what=$1 pattern=$2
    shift 2
    "$flare" "$@" >"$B/out" 2>"$B/log"
    [ $? = 2 ] && [ ! -s "$B/out" ] && [ "$(wc -l <"$B/log")" = 1 ] && grep -qE "$pattern" "$B/log"
    result $? "$what"
}
efl() { "$flare" info "$@" --json | sed -nE 's/.*"efl_mm": ([0-9.]+).*/\1/p'; }
own=$(efl lenses/cooke-triplet-27.lens) wrong=0
for seed in zmx-inches zmx-utf16le-mark zmx-utf16be report-tabs report-width seq-radii seq-curvatures bench pbrt pbrt-before xml xml-line json json-line flaresim flaresim-diameters; do
    rm -f "$B/out.lens"
    "$flare" convert "$seeds/$seed" -o "$B/out.lens" >"$B/log" 2>&1 && head -1 "$B/out.lens" | grep -qx 'lensflare 1' &&
        awk "BEGIN {a = $(efl "$seeds/$seed"); b = $(efl "$B/out.lens"); exit !(a == b && a / $own - 1 < 1e-9 && 1 - a / $own < 1e-9)}" || { wrong=1; echo "# $seed"; }
done
result $wrong "convert: every format gives the lens that it was written from"
"$flare" render "$seeds/zmx-utf16le-mark" -o "$B/a.pfm" --size 64x36 --angle 5,3 >"$B/log" 2>&1 && "$flare" diagram "$seeds/xml" -o "$B/a.svg" >"$B/log" 2>&1 && "$flare" ghosts "$seeds/json" --csv | grep -q '^first,'
result $? "other commands take other formats"
one=$(efl "$seeds/zmx-zoom" --config 1) two=$(efl "$seeds/zmx-zoom" --config 2)
[ -n "$one" ] && [ -n "$two" ] && [ "$one" != "$two" ] && [ "$one" = "$(efl "$seeds/zmx-zoom")" ]
result $? "--config: $one mm, $two mm"
refused "a zoom state that is not there" "zmx-zoom: zoom state 3 was asked for, the file has 2" info "$seeds/zmx-zoom" --config 3
refused "a refused file says FILE:LINE:COLUMN and why" "^$seeds/zmx-refused:[0-9]+:1: refused: a mirror" info "$seeds/zmx-refused"
"$flare" check lenses/*.lens >"$B/out" 2>"$B/log"
[ $? = 0 ] && [ ! -s "$B/log" ] && [ "$(wc -l <"$B/out")" = "$(ls lenses/*.lens | wc -l)" ] && ! grep -v ': ok, lensflare, [0-9]* surfaces, EFL ' "$B/out"
result $? "check: our own lenses are well"
"$flare" check "$seeds" >"$B/out" 2>"$B/log"
[ $? = 2 ] && [ ! -s "$B/log" ] && [ "$(wc -l <"$B/out")" = "$(ls "$seeds" | wc -l)" ] && grep -qE '^tests/fuzz_seeds_import/seq-refused:[0-9]+:1: refused: a mirror' "$B/out" && grep -q '/xml: ok, OpenLensFlare, 7 surfaces, EFL ' "$B/out"
result $? "check: a line for each file of a folder, and status 2 for those refused"
"$flare" check "$B/none" lenses/topogon.lens >"$B/out" 2>"$B/log"
[ $? = 2 ] && [ "$(wc -l <"$B/out")" = 2 ] && sed -n 1p "$B/out" | grep -q 'none: No such file' && sed -n 2p "$B/out" | grep -q 'topogon.lens: ok'
result $? "check goes on behind a file that is not there"
[ "$("$flare" glass NBK7_SCHOTT | sed -n 's/^name *//p')" = N-BK7 ] && "$flare" glass 517642 | grep -qx 'nd        1.51680' && "$flare" glass 1.5168,64.17 | grep -qx 'name      N-BK7' && "$flare" glass 1.5168,64.17 --catalogue OHARA | grep -qx 'name      S-BSL7'
result $? "glass: by name, by code, nearest"
refused "a glass nobody knows" "no glass is known by the name 'XQ9'" glass XQ9
refused "a glass by halves" '^flare: flare glass: ' glass 1.5,
refused "nothing to check" 'needs files or folders' check
refused "an option that check has not" "unknown option '--json' for 'flare check'" check --json
refused "a lens that goes nowhere" 'with -o OUT.lens' convert "$seeds/xml"
refused "a lens into a folder that is not there" 'cannot be written' convert "$seeds/xml" -o "$B/no/x.lens"
refused "a zoom state of no lens" "unknown option '--config' for 'flare coating'" coating 1 1.5 --config 2
"$flare" convert "$seeds/pbrt" -o "$B/out.lens" >"$B/log" 2>&1 && grep -q '^# ' "$B/out.lens" && "$flare" info "$seeds/pbrt" | grep -q '^note .*no dispersion'
result $? "what was guessed is said, and stands in the file"
echo "1..$n"
