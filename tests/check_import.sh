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
silent "nothing undefined but strings, mathematics and lflare_" sh -c "nm $B/impl.o >$B/names && awk '\$1 == \"U\" && \$2 !~ /^(lflare_[a-z0-9_]+|mem[a-z]+|str[a-z]+|pow|log10|floor|hypot|tan|__stack_chk_fail|_GLOBAL_OFFSET_TABLE_)\$/' $B/names"
tables=$(nm -S --size-sort "$B/symbols.o" | awk '$4 ~ /^lensimport__(glasses|list|makers)$/ {print $2}' | while read -r hex; do printf '%d\n' "0x$hex"; done | awk '{sum += $1} END {print sum + 0}')
echo "$tables bytes" >"$B/log"
[ "$tables" -gt 20000 ] && [ "$tables" -le 40960 ] && ok "the glass catalogue takes $tables bytes" || bad "the glass catalogue's size"
lenses/glasses.sh lenses/lensimport.h >"$B/made.h" 2>"$B/log"
try "the tables of glasses are those beside the header (make glasses)" cmp "$B/made.h" lenses/lensimport.h
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
echo "1..$n"
