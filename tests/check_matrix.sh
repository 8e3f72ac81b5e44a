#!/bin/sh
# Compilers, standards, feature macros, linkage, symbols, size, 32 bits, sanitisers. Prints TAP; run from the root.
set -u
B=build/matrix
mkdir -p "$B"
n=0
ok() { n=$((n + 1)); echo "ok $n - $1"; }
bad() { n=$((n + 1)); echo "not ok $n - $1"; sed 's/^/# /' "$B/log" | head -20; }
skip() { n=$((n + 1)); echo "ok $n # SKIP $1"; }
try() { what=$1; shift; if "$@" >"$B/log" 2>&1; then ok "$what"; else bad "$what"; fi; }

W="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Werror -I."
C="$W -Wstrict-prototypes"
printf '#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\n' >"$B/impl.c"
cp "$B/impl.c" "$B/impl.cpp"

# strict warnings
for cc in gcc clang; do
    for std in c99 c11 c17; do try "$cc $std without a warning" $cc -std=$std $C -O2 -c "$B/impl.c" -o "$B/impl.o"; done
    cxx=g++; [ $cc = clang ] && cxx=clang++
    for std in c++11 c++20; do try "$cxx $std without a warning" $cxx -std=$std $W -O2 -c "$B/impl.cpp" -o "$B/impl.o"; done
done

# every combination of the switches, plain and LFLARE_STATIC: warning-free; compiled, and nothing undefined but libc and libm
printf '#include "lensflare.h"\nint main(void) { return lflare_version() == 0; }\n' >"$B/user.c"
printf '#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\nint main(void) { return lflare_version() == 0; }\n' >"$B/main.c"
i=0
while [ $i -lt 32 ]; do
    flags=
    for bit in 1:STDIO 2:ABERRATION 4:TRACE 8:SOFTWARE 16:GL; do
        [ $((i & ${bit%%:*})) -ne 0 ] && flags="$flags -DLFLARE_NO_${bit#*:}"
    done
    if gcc -std=c99 $C $flags "$B/main.c" -o "$B/main" -lm >"$B/log" 2>&1 && "$B/main" >>"$B/log" 2>&1 &&
        gcc -std=c99 $C -DLFLARE_STATIC $flags -fsyntax-only "$B/main.c" >>"$B/log" 2>&1 &&
        clang -std=c99 $C -DLFLARE_STATIC $flags -fsyntax-only "$B/main.c" >>"$B/log" 2>&1 &&
        clang++ -x c++ -std=c++11 $W $flags -fsyntax-only "$B/main.c" >>"$B/log" 2>&1; then
        ok "switches:${flags:- none}"
    else
        bad "switches:$flags"
    fi
    i=$((i + 1))
done

try "switches: -DLFLARE_NO_DIFFRACTION, whose room is yet to come" gcc -std=c99 $C -DLFLARE_NO_DIFFRACTION "$B/main.c" -o "$B/main" -lm

# declarations alone, twice, two units, implementation twice
try "declarations alone" gcc -std=c99 $C -fsyntax-only -include lensflare.h -x c /dev/null
try "declarations alone, C++" g++ -std=c++11 $W -fsyntax-only -include lensflare.h -x c++ /dev/null
printf '#include "lensflare.h"\n#include "lensflare.h"\n%s\n' "$(cat "$B/impl.c")" >"$B/twice.c"
printf '#include "lensflare.h"\n#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\n#include "lensflare.h"\n' >>"$B/twice.c"
try "included twice, before and after the implementation" gcc -std=c99 $C -c "$B/twice.c" -o "$B/twice.o"
gcc -std=c99 $C -O2 -c "$B/impl.c" -o "$B/impl.o" && gcc -std=c99 $C -c "$B/user.c" -o "$B/user.o"
printf '#include "lensflare.h"\nint other(void);\nint other(void) { return lflare_version(); }\n' >"$B/other.c"
gcc -std=c99 $C -c "$B/other.c" -o "$B/other.o"
try "three units link" gcc "$B/user.o" "$B/other.o" "$B/impl.o" -o "$B/units" -lm
cp "$B/user.c" "$B/user.cpp"
g++ -std=c++11 $W -c "$B/user.cpp" -o "$B/user_cpp.o" && try "C++ calls what C compiled" g++ "$B/user_cpp.o" "$B/impl.o" -o "$B/units" -lm
g++ -std=c++11 $W -c "$B/impl.cpp" -o "$B/impl_cpp.o" && try "C calls what C++ compiled" g++ "$B/user.o" "$B/impl_cpp.o" -o "$B/units" -lm

# symbols (without position-independent code: tables of strings would count as writable until relocated)
gcc -std=c99 -fno-pic -fno-pie -I. -O2 -c "$B/impl.c" -o "$B/symbols.o"
nm "$B/symbols.o" | awk '$2 ~ /^[TWV]$/ && $3 !~ /^lflare_[a-z0-9]/ || $2 ~ /^[DBCGSdbcgs]$/ {print; wrong = 1} END {exit wrong}' >"$B/log"
[ -s "$B/log" ] && bad "every symbol exported begins with lflare_, and there is no writable global" || ok "every symbol exported begins with lflare_, and there is no writable global"
nm -g "$B/impl.o" | awk '$2 == "T" && $3 ~ /^lflare__/' >"$B/log"
[ -s "$B/log" ] && bad "no private function is exported" || ok "no private function is exported"
gcc -std=c99 -DLFLARE_STATIC -I. -O2 -c "$B/impl.c" -o "$B/static.o" && nm -g "$B/static.o" | grep -v ' U ' >"$B/log"
[ -s "$B/log" ] && bad "LFLARE_STATIC exports nothing" || ok "LFLARE_STATIC exports nothing"
nm "$B/impl.o" | awk '$1 == "U" && $2 ~ /^(printf|puts|exit|abort|atof|strtod|setlocale|__stack_chk_fail)$/ {print}' | grep -v __stack >"$B/log"
[ -s "$B/log" ] && bad "no output, no exit, no libc number conversion" || ok "no output, no exit, no libc number conversion"

# macros and includes
std_only() { printf '%s' "$1" | gcc -std=c99 -I. -dM -E -x c - | awk '{sub(/\(.*/, "", $2); print $2}' | sort -u; }
leaked() { std_only "$1" >"$B/with"; std_only "$2" >"$B/without"; comm -23 "$B/with" "$B/without" | grep -vE '^(LFLARE_|LENSFLARE_)' >"$B/log"; }
leaked '#include "lensflare.h"
' '#include <stddef.h>
#include <stdint.h>
'
[ -s "$B/log" ] && bad "the declarations leak no unprefixed macro, and include <stddef.h> and <stdint.h> only" || ok "the declarations leak no unprefixed macro, and include <stddef.h> and <stdint.h> only"
[ "$(sed -n '/^#ifndef LENSFLARE_H/,/^#endif \/\* LENSFLARE_H/p' lensflare.h | sed -n 's/^#include *//p' | tr '\n' ' ')" = "<stddef.h> <stdint.h> " ] && ok "the declarations name no other header" || bad "the declarations name no other header"
heads=$(sed -n '/^#ifndef LENSFLARE_H/,$s/^ *#include *\(<[a-z]*\.h>\).*/#include \1/p' lensflare.h)
leaked '#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
' "#define LENSFLARE_IMPLEMENTATION
$heads
"
[ -s "$B/log" ] && bad "the implementation leaks no unprefixed macro" || ok "the implementation leaks no unprefixed macro"

# size
off="-DLFLARE_NO_STDIO -DLFLARE_NO_ABERRATION -DLFLARE_NO_DIFFRACTION -DLFLARE_NO_TRACE -DLFLARE_NO_SOFTWARE -DLFLARE_NO_GL"
# (code and constants; tables for unwinding the stack are not code)
gcc -std=c99 -I. -O2 -fno-asynchronous-unwind-tables $off -c "$B/impl.c" -o "$B/small.o" 2>"$B/log"
text=$(size "$B/small.o" | awk 'NR == 2 {print $1}')
whole=$(size "$B/impl.o" | awk 'NR == 2 {print $1}')
echo "text $text bytes" >>"$B/log"
[ "${text:-99999}" -lt 60000 ] && ok "smallest build: $text bytes of text (all rooms: $whole)" || bad "smallest build: $text bytes of text"

# 32 bits: with SSE numbers are exact; on the x87 what is written stays what it is from the second writing on
cat >"$B/round.c" <<'END'
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
static lflare_prescription a, b;
static char first[200000], second[200000];
int main(int argc, char **argv)
{
    int i;
    for (i = 1; i < argc; i++) {
        char *text;
        size_t size, n = sizeof first, m = sizeof second;
        lflare_error e;
        if (lflare_file_read(argv[i], NULL, NULL, &text, &size, &e) < 0 || lflare_text_read(text, size, &a, &e) < 0 ||
            lflare_text_write(&a, first, &n) != LFLARE_OK || lflare_text_read(first, n, &b, &e) < 0 || lflare_text_write(&b, second, &m) != LFLARE_OK ||
            n != m || memcmp(first, second, n) != 0) {
            printf("%s does not come back the same\n", argv[i]);
            return 1;
        }
        free(text);
    }
#ifdef EXACT
    {
        uint64_t state = 1, z;
        double v, back;
        char text[40];
        int32_t length;
        for (i = 0; i < 300000; i++) {
            z = (state += 0x9e3779b97f4a7c15u);
            z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
            z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
            memcpy(&v, &z, sizeof v);
            if (!(fabs(v) > 1e-300 && fabs(v) < 1e300)) continue;
            length = lflare_number_write(v, text);
            if (!lflare_number_read(text, (size_t)length, &back) || back != v) {
                printf("%.17g is written %.*s\n", v, (int)length, text);
                return 1;
            }
        }
    }
#endif
    {   /* room for the footprints of 1,500 lights and 4,000 ghosts does not wrap round */
        lflare_desc desc;
        lflare *flare;
        int n;
        memset(&desc, 0, sizeof desc);
        n = sprintf(first, "lensflare 1\nfnumber 16\nstop 1\n50 3 n 1.5\n-50 1\n");
        for (i = 0; i < 62; i++) n += sprintf(first + n, "flat 0.1 n 1.5\nflat 0.1\n");
        desc.text = first;
        desc.text_size = (size_t)n;
        desc.max_lights = 1500;
        if (lflare_create(&desc, &flare, NULL) < 0) return 2;
        if (sizeof(size_t) == 4 && lflare_render_begin(flare) != LFLARE_ERROR_MEMORY) {
            printf("4 GB of footprints were allocated on 32 bits\n");
            return 1;
        }
        lflare_destroy(flare);
    }
    return 0;
}
END
if printf '#include <stdio.h>\nint main(void) { return 0; }\n' | gcc -m32 -x c - -o "$B/m32" 2>/dev/null && "$B/m32"; then
    try "32 bits without a warning" gcc -m32 -std=c99 $C -O2 -c "$B/impl.c" -o "$B/impl32.o"
    try "32 bits, SSE: numbers and lenses round trip" sh -c "gcc -m32 -msse2 -mfpmath=sse -DEXACT -std=c99 -O2 -I. $B/round.c -o $B/round32 -lm && $B/round32 tests/data/*.lens lenses/*.lens"
    try "32 bits, x87: lenses round trip" sh -c "gcc -m32 -std=c99 -O2 -I. $B/round.c -o $B/round87 -lm && $B/round87 tests/data/*.lens lenses/*.lens"
else
    skip "32 bits: gcc-multilib is missing"
fi

# sanitisers: the tests, where numbers out of a converted range count too. ALL=1 runs those of the picture too, which are slow.
# A GL driver leaks on its own account, from modules that are unloaded by then and so cannot be suppressed by name: in test_gl
# a leak counts where our code stands in its stack.
S="-std=c99 -g -O1 -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -I. -Itests"
for t in tests/test_*.c; do
    name=$(basename "$t" .c) libs= leaks=1 part=
    case "$name" in
    test_text | test_failure) ;;
    test_gl)
        [ -x "build/$name" ] || { skip "$name with sanitisers: it could not be built"; continue; }
        libs="-lEGL -lGL" leaks=0
        ;;
    test_aberration) libs=-lpthread part=quick ;;
    test_reference)
        [ "${ALL:-}" ] || continue
        libs=-lpthread
        ;;
    *) [ "${ALL:-}" ] || continue ;;
    esac
    rm -f "$B/log2"
    if gcc $S "$t" -o "$B/san_$name" -lcmocka $libs -lm >"$B/log" 2>&1 && LSAN_OPTIONS=exitcode=$((23 * leaks)) "$B/san_$name" $part >"$B/log" 2>&1 &&
        ! sed -n '/LeakSanitizer/,$p' "$B/log" | grep -E 'lensflare\.h|tests/' >"$B/log2"; then ok "$name with sanitisers"; else
        grep -E 'runtime error|ERROR: AddressSanitizer|LeakSanitizer|FAILED|rror' "$B/log" >>"$B/log2"; mv "$B/log2" "$B/log"; bad "$name with sanitisers"; fi
done
echo "1..$n"
