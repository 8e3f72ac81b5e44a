#!/bin/sh
# Compilers, standards, feature macros, linkage, symbols, size, 32 bits, sanitisers. Prints TAP; run from the root.
# `check_matrix.sh PART` is one of the parts below, in a folder of its own; without PART all are run, as many at a time as there
# are processors (JOBS=n: n), and what they print is numbered in their order. A part that does not end well counts as failed.
set -u
if [ $# -eq 0 ]; then
    B=build/matrix
    rm -rf "$B" && mkdir -p "$B"
    # ALL=1 runs the tests of the picture under sanitisers too, which are slow
    tests=
    for t in tests/test_*.c; do
        case "$t" in
        *_text.c | *_failure.c | *_gl.c | *_aberration.c) ;;
        *) [ "${ALL:-}" ] || continue ;;
        esac
        tests="$(basename "$t" .c) $tests"
    done
    parts="objects standards lensopt no_diffraction switches_0 switches_1 switches_2 switches_3 bits32"
    # the longest come first, of these test_gl near the head: hence the alphabet backwards
    printf '%s\n' $tests $parts | xargs -P "${JOBS:-$(getconf _NPROCESSORS_ONLN)}" -n 1 sh -c 'sh "$0" "$2" >"$1/$2.tap"; echo $? >"$1/$2.status"' "$0" "$B"
    for part in $parts $tests; do
        cat "$B/$part.tap" 2>/dev/null
        status=$(cat "$B/$part.status" 2>/dev/null)
        [ "$status" = 0 ] || printf '\nnot ok - %s was not done: status %s\n' "$part" "${status:-unknown}"
    done | awk '/^ok/ {sub(/^ok/, "ok " ++n)} /^not ok/ {sub(/^not ok/, "not ok " ++n)} NF {print} END {print "1.." n + 0}'
    exit
fi
B=build/matrix/$1
rm -rf "$B" && mkdir -p "$B"
ok() { echo "ok - $1"; }
bad() { echo "not ok - $1"; sed 's/^/# /' "$B/log" | head -20; }
skip() { echo "ok # SKIP $1"; }
try() { what=$1; shift; if "$@" >"$B/log" 2>&1; then ok "$what"; else bad "$what"; fi; }
silent() { what=$1; shift; if "$@" >"$B/log" 2>&1 && [ ! -s "$B/log" ]; then ok "$what"; else bad "$what"; fi; }

W="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Werror -I."
C="$W -Wstrict-prototypes"
printf '#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\n' >"$B/impl.c"
cp "$B/impl.c" "$B/impl.cpp"
printf '#include "lensflare.h"\nint main(void) { return lflare_version() == 0; }\n' >"$B/user.c"
cp "$B/user.c" "$B/user.cpp"
printf '#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\nint main(void) { return lflare_version() == 0; }\n' >"$B/main.c"

case "$1" in
objects)
# strict warnings; these objects are used below
try "gcc c99 without a warning" gcc -std=c99 $C -O2 -c "$B/impl.c" -o "$B/impl.o"
try "g++ c++11 without a warning" g++ -std=c++11 $W -O2 -c "$B/impl.cpp" -o "$B/impl_cpp.o"

# declarations alone, twice, two units, implementation twice
try "declarations alone" gcc -std=c99 $C -fsyntax-only -include lensflare.h -x c /dev/null
try "declarations alone, C++" g++ -std=c++11 $W -fsyntax-only -include lensflare.h -x c++ /dev/null
printf '#include "lensflare.h"\n#include "lensflare.h"\n%s\n' "$(cat "$B/impl.c")" >"$B/twice.c"
printf '#include "lensflare.h"\n#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\n#include "lensflare.h"\n' >>"$B/twice.c"
try "included twice, before and after the implementation" gcc -std=c99 $C -c "$B/twice.c" -o "$B/twice.o"
printf '#include "lensflare.h"\nint other(void);\nint other(void) { return lflare_version(); }\n' >"$B/other.c"
try "three units link" gcc -std=c99 $C "$B/user.c" "$B/other.c" "$B/impl.o" -o "$B/units" -lm
try "C++ calls what C compiled" g++ -std=c++11 $W "$B/user.cpp" "$B/impl.o" -o "$B/units" -lm
try "C calls what C++ compiled" gcc -std=c99 $C "$B/user.c" "$B/impl_cpp.o" -o "$B/units" -lm

# symbols (without position-independent code: tables of strings would count as writable until relocated)
silent "every symbol exported begins with lflare_, and there is no writable global" sh -c "gcc -std=c99 -fno-pic -fno-pie -I. -O1 -c $B/impl.c -o $B/symbols.o && nm $B/symbols.o >$B/names &&
    awk '\$2 ~ /^[TWV]\$/ && \$3 !~ /^lflare_[a-z0-9]/ || \$2 ~ /^[DBCGSdbcgs]\$/ {print; wrong = 1} END {exit wrong}' $B/names"
silent "no private function is exported" sh -c "nm -g $B/impl.o >$B/names && awk '\$2 == \"T\" && \$3 ~ /^lflare__/' $B/names"
silent "LFLARE_STATIC exports nothing" sh -c "gcc -std=c99 -DLFLARE_STATIC -I. -O2 -c $B/impl.c -o $B/static.o && nm -g $B/static.o >$B/names && sed '/ U /d' $B/names"
silent "no output, no exit, no libc number conversion" sh -c "nm $B/impl.o >$B/names && awk '\$1 == \"U\" && \$2 ~ /^(printf|puts|exit|abort|atof|strtod|setlocale)\$/' $B/names"

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
;;
standards)
# strict warnings. A later standard of C changes what the front end says, for gcc not a byte of the object; clang's warnings all
# come from its front end: there the rest need not be compiled again
try "clang c99 without a warning" clang -std=c99 $C -O2 -c "$B/impl.c" -o "$B/impl.o"
try "clang++ c++11 without a warning" clang++ -std=c++11 $W -O2 -c "$B/impl.cpp" -o "$B/impl.o"
try "g++ c++20 without a warning" g++ -std=c++20 $W -O2 -c "$B/impl.cpp" -o "$B/impl.o"
try "clang++ c++20 without a warning" clang++ -std=c++20 $W -fsyntax-only "$B/impl.cpp"
for cc in gcc clang; do
    for std in c11 c17; do try "$cc $std without a warning" $cc -std=$std $C -fsyntax-only "$B/impl.c"; done
done
;;
lensopt)
# the optional header: warnings, linkage, symbols, macros; links against the smallest lensflare.h
printf '#define LENSOPT_IMPLEMENTATION\n#include "lensopt.h"\n' >"$B/opt.c"
cp "$B/opt.c" "$B/opt.cpp"
printf '#include "lensopt.h"\nint main(void) { lflare_error e; return lensopt_resize_stop(NULL, 1, &e) != LFLARE_ERROR_ARGUMENT || e.text[0] == 0; }\n' >"$B/user.c"
cp "$B/user.c" "$B/user.cpp"
printf '#include "lensopt.h"\nlflare_result other(void);\nlflare_result other(void) { return lensopt_coat_bare(NULL, 0, NULL); }\n' >"$B/other.c"
try "lensopt.h: gcc c99 without a warning" gcc -std=c99 $C -O2 -c "$B/opt.c" -o "$B/opt.o"
try "lensopt.h: g++ c++11 without a warning" g++ -std=c++11 $W -O2 -c "$B/opt.cpp" -o "$B/opt_cpp.o"
try "lensopt.h: g++ c++20 without a warning" g++ -std=c++20 $W -fsyntax-only "$B/opt.cpp"
try "lensopt.h: clang c99 without a warning" clang -std=c99 $C -O2 -c "$B/opt.c" -o "$B/clang.o"
for std in c++11 c++20; do try "lensopt.h: clang++ $std without a warning" clang++ -std=$std $W -fsyntax-only "$B/opt.cpp"; done
try "lensopt.h: LENSOPT_STATIC without a warning" gcc -std=c99 $C -DLENSOPT_STATIC -fsyntax-only "$B/opt.c"
try "lensopt.h: LENSOPT_STATIC without a warning, C++" clang++ -std=c++11 $W -DLENSOPT_STATIC -fsyntax-only "$B/opt.cpp"
for cc in "gcc -std=c99" "clang -std=c99"; do
    try "lensopt.h: LENSOPT_NO_THREADS without a warning: ${cc%% *}" $cc $C -DLENSOPT_NO_THREADS -O1 -c "$B/opt.c" -o "$B/alone.o"
done
try "lensopt.h: LENSOPT_NO_THREADS without a warning, C++" clang++ -std=c++11 $W -DLENSOPT_NO_THREADS -fsyntax-only "$B/opt.cpp"
silent "lensopt.h: LENSOPT_NO_THREADS uses no threads" sh -c "nm $B/alone.o >$B/names && awk '/pthread_/' $B/names"
try "lensopt.h: test_search with LENSOPT_NO_THREADS" sh -c "gcc -std=c99 -DLENSOPT_NO_THREADS -I. -O2 tests/test_search.c -o $B/alone -lcmocka -lm && $B/alone"
try "lensopt.h: test_problem without vectors" sh -c "gcc -std=c99 -U__FLT_EVAL_METHOD__ -I. -O2 tests/test_problem.c -o $B/scalar -lcmocka -lpthread -lm && $B/scalar"
if printf 'int main(void) { return 0; }\n' | clang -fsanitize=thread -x c - -o "$B/tsan" 2>/dev/null && "$B/tsan"; then
    try "lensopt.h: test_search with ThreadSanitizer" sh -c "clang -std=c99 -g -O1 -fsanitize=thread -I. tests/test_search.c -o $B/tsan -lcmocka -lpthread -lm && TSAN_OPTIONS=halt_on_error=1 $B/tsan threads"
else
    skip "lensopt.h: no ThreadSanitizer here"
fi
try "lensopt.h: declarations alone" gcc -std=c99 $C -fsyntax-only -include lensopt.h -x c /dev/null
printf '#include "lensopt.h"\n#define LENSOPT_IMPLEMENTATION\n#include "lensopt.h"\n#include "lensopt.h"\n' >"$B/twice.c"
try "lensopt.h: included twice, before and after the implementation" gcc -std=c99 $C -c "$B/twice.c" -o "$B/twice.o"
gcc -std=c99 -I. -O0 -DLFLARE_NO_STDIO -DLFLARE_NO_ABERRATION -DLFLARE_NO_DIFFRACTION -DLFLARE_NO_TRACE -DLFLARE_NO_SOFTWARE -DLFLARE_NO_GL -c "$B/impl.c" -o "$B/impl.o"
try "lensopt.h: three units link and run" sh -c "gcc -std=c99 $C $B/user.c $B/other.c $B/opt.o $B/impl.o -o $B/units -lm && $B/units"
try "lensopt.h: C++ calls what C compiled" g++ -std=c++11 $W "$B/user.cpp" "$B/opt.o" "$B/impl.o" -o "$B/units" -lm
try "lensopt.h: C calls what C++ compiled" gcc -std=c99 $C "$B/user.c" "$B/opt_cpp.o" "$B/impl.o" -o "$B/units" -lm
silent "lensopt.h: every symbol exported begins with lensopt_, and there is no writable global" sh -c "gcc -std=c99 -fno-pic -fno-pie -I. -O1 -c $B/opt.c -o $B/symbols.o && nm $B/symbols.o >$B/names &&
    awk '\$2 ~ /^[TWV]\$/ && \$3 !~ /^lensopt_[a-z0-9]/ || \$2 ~ /^[DBCGSdbcgs]\$/ {print; wrong = 1} END {exit wrong}' $B/names"
silent "lensopt.h: it calls public stages, libc and libm alone, without output or exit" sh -c "nm $B/opt.o >$B/names && awk '\$1 == \"U\" && (\$2 ~ /^lflare__/ || \$2 ~ /^(printf|puts|exit|abort|atof|strtod|setlocale)\$/)' $B/names"
printf '#include "lensopt.h"\n' | gcc -std=c99 -I. -dM -E -x c - | awk '{sub(/\(.*/, "", $2); print $2}' | sort -u >"$B/with"
printf '#include "lensflare.h"\n' | gcc -std=c99 -I. -dM -E -x c - | awk '{sub(/\(.*/, "", $2); print $2}' | sort -u >"$B/without"
comm -23 "$B/with" "$B/without" | grep -v '^LENSOPT_' >"$B/log"
[ -s "$B/log" ] && bad "lensopt.h: the declarations leak no unprefixed macro" || ok "lensopt.h: the declarations leak no unprefixed macro"
;;
no_diffraction)
# without starbursts, fringes and masks the rest passes its tests
for name in test_optics test_picture test_failure test_lenses; do
    try "$name with LFLARE_NO_DIFFRACTION" sh -c "gcc -std=c99 -DLFLARE_NO_DIFFRACTION -I. -O2 tests/$name.c -o $B/$name -lcmocka -lm && $B/$name quick"
done
;;
switches_*)
# every combination of the switches (STDIO goes with every other), plain and LFLARE_STATIC: warning-free; compiled, and nothing
# undefined but libc and libm
i=${1#switches_}
while [ $i -lt 32 ]; do
    flags=
    for bit in 1:STDIO 1:DIFFRACTION 2:ABERRATION 4:TRACE 8:SOFTWARE 16:GL; do
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
    i=$((i + 4))
done
;;
bits32)
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
;;
test_*)
# sanitisers: the tests, where numbers out of a converted range count too.
# A GL driver leaks on its own account, from modules that are unloaded by then and so cannot be suppressed by name: in test_gl
# a leak counts where our code stands in its stack.
# What runs for minutes is worth -O2, and clang, whose sanitisers look for the same, is the faster there by a third.
S="-std=c99 -g -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -I. -Itests"
name=$1 cc="gcc -O1" libs= leaks=1 argument=
case "$name" in
test_gl)
    [ -x "build/$name" ] || { skip "$name with sanitisers: it could not be built"; exit 0; }
    cc="gcc -O2" libs="-lEGL -lGL" leaks=0 argument=quick
    ;;
test_aberration) cc="clang -O2" libs=-lpthread argument=quick ;;
test_lenses) argument=quick ;;
test_picture) cc="clang -O2" ;;
test_reference | test_paths | test_search) libs=-lpthread ;;
test_traced) cc="clang -O2" libs=-lpthread ;;
test_diffraction) libs=-lfftw3 ;;
esac
if $cc $S "tests/$name.c" -o "$B/$name" -lcmocka $libs -lm >"$B/log" 2>&1 && LSAN_OPTIONS=exitcode=$((23 * leaks)) "$B/$name" $argument >"$B/log" 2>&1 &&
    ! sed -n '/LeakSanitizer/,$p' "$B/log" | grep -E 'lensflare\.h|tests/' >"$B/log2"; then ok "$name with sanitisers"; else
    grep -E 'runtime error|ERROR: AddressSanitizer|LeakSanitizer|FAILED|rror' "$B/log" >>"$B/log2"; mv "$B/log2" "$B/log"; bad "$name with sanitisers"; fi
;;
*) exit 2 ;;
esac
exit 0
