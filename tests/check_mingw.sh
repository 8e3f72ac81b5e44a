#!/bin/sh
# Windows: the library, the tool and the examples build with mingw-w64 without a warning; where wine is, they run and give what
# they give here. TAP; run from the root.
set -u
cd "$(dirname "$0")/.." || exit 2
dir=build/mingw n=0
rm -rf "$dir" && mkdir -p "$dir"
result() { # STATUS WHAT
    n=$((n + 1))
    if [ "$1" = 0 ]; then echo "ok $n - $2"; else echo "not ok $n - $2"; [ -s "$dir/log" ] && head -20 "$dir/log" | sed 's/^/# /'; fi
    : >"$dir/log"
}
skip() { n=$((n + 1)); echo "ok $n # SKIP $1"; }
: >"$dir/log"
warn="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Wstrict-prototypes -Werror"
printf '#define LENSFLARE_IMPLEMENTATION\n#include "lensflare.h"\n' >"$dir/impl.c"

# lensopt.h takes no name from <windows.h>, and gets along with it; a search on 1 to 4 threads, whose bytes are the same there and here
printf '#include <windows.h>\n#define LENSOPT_IMPLEMENTATION\n#include "lensopt.h"\n' >"$dir/windows_first.c"
printf '#define LENSOPT_IMPLEMENTATION\n#include "lensopt.h"\nextern int near, far;\n' >"$dir/windows_not.c"
printf '#define LENSOPT_IMPLEMENTATION\n#include "lensopt.h"\n#include <windows.h>\n' >"$dir/windows_last.c"
cat >"$dir/search.c" <<'END'
#include <stdio.h>
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSOPT_IMPLEMENTATION
#include "lensopt.h"
static void evaluate(void *user, const double *x, int32_t count, double *f)
{
    int32_t i, j;
    (void)user;
    for (i = 0; i < count; i++)
        for (f[i] = 0, j = 0; j < 9; j++, x++) f[i] += (*x - 0.3) * (*x - 0.3) * (1 + j);
}
static int32_t told(void *user, const lensopt_progress *progress)
{
    (void)progress;
    ++*(int32_t *)user;
    return 0;
}
int main(void)
{
    static const double lower[9] = {-1, -1, -1, -1, -1, -1, -1, -1, -1}, upper[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
    static uint8_t bytes[4000000];
    int32_t threads;
    for (threads = 0; threads < 5; threads++) {
        lensopt_search_desc desc;
        lensopt_search *search;
        lensopt_limits limits;
        lensopt_progress progress;
        size_t size = sizeof bytes, i;
        uint32_t sum = 0;
        int32_t calls = 0;
        memset(&desc, 0, sizeof desc);
        memset(&limits, 0, sizeof limits);
        desc.function.variables = 9;
        desc.function.lower = lower;
        desc.function.upper = upper;
        desc.function.evaluate = evaluate;
        desc.method = LENSOPT_PSO;
        desc.threads = threads;
        limits.evaluations = 400000;
        if (lensopt_search_create(&desc, &search, NULL) != LFLARE_OK || lensopt_search_run(search, &limits, NULL, NULL, NULL) != LFLARE_OK) return 1;
        if (lensopt_search_save(search, bytes, &size) != LFLARE_OK) return 1;
        for (i = 0; i < size; i++) sum = (sum ^ bytes[i]) * 16777619u;
        limits.evaluations = 0;
        limits.seconds = 0.3;
        lensopt_search_run(search, &limits, told, &calls, NULL);
        lensopt_search_status(search, &progress);
        printf("%d threads: state %08lx, clock and callback %s\n", (int)threads, (unsigned long)sum, calls > 2 && progress.seconds >= 0.3 && progress.seconds < 5 ? "well" : "wrong");
        lensopt_search_free(search);
    }
    return 0;
}
END

for machine in x86_64 i686; do
    cc=$machine-w64-mingw32-gcc
    if ! command -v $cc >/dev/null; then
        # 32 bits are built where their compiler happens to be
        [ $machine = i686 ] || skip "$cc is not here: apt-get install gcc-mingw-w64-x86-64-win32"
        continue
    fi
    $cc -std=c99 $warn -I. -O2 -c "$dir/impl.c" -o "$dir/impl.o" >"$dir/log" 2>&1
    result $? "$machine: the header alone"
    # what names get in whose way the front end says: the code is the same in all three, and is compiled with search.c
    for name in windows_first windows_not windows_last; do $cc -std=c99 $warn -I. -fsyntax-only "$dir/$name.c" || echo "$name.c"; done >"$dir/log" 2>&1
    [ ! -s "$dir/log" ]
    result $? "$machine: lensopt.h without <windows.h>, before and behind it"
    $cc -std=c99 $warn -I. -O2 -DLENSFLARE_IMPLEMENTED "$dir/search.c" "$dir/impl.o" -o "$dir/search-$machine.exe" -lm >"$dir/log" 2>&1
    result $? "$machine: a search"
    for name in 00_null 02_own_renderer flare; do
        $cc -std=c99 $warn -I. -O2 "examples/$name.c" -o "$dir/$name-$machine.exe" -lm >"$dir/log" 2>&1
        result $? "$machine: examples/$name.c"
    done
done

# ---- run ----

wine=$(command -v wine64 || ls /usr/lib/wine/wine64 2>/dev/null || command -v wine)
if [ -z "$wine" ] || [ ! -x "$dir/flare-x86_64.exe" ]; then
    skip "no wine here, or nothing was built: nothing is run"
    echo "1..$n"
    exit 0
fi
WINEPREFIX=$(pwd)/build/wine WINEDEBUG=-all WINEDLLOVERRIDES='mscoree,mshtml=' # no offers to install anything
export WINEPREFIX WINEDEBUG WINEDLLOVERRIDES
unset DISPLAY
server=$(command -v wineserver || ls /usr/lib/wine/wineserver 2>/dev/null)
trap '[ -n "$server" ] && "$server" -k; rm -rf "$WINEPREFIX"' EXIT # 700 MB
trap 'exit 1' HUP INT TERM PIPE
exe() { # NAME ARGUMENTS...: standard output without its carriage returns; the program's status
    name=$1
    shift
    timeout 120 "$wine" "$dir/$name-x86_64.exe" "$@" >"$dir/raw" 2>"$dir/log"
    status=$?
    tr -d '\r' <"$dir/raw"
    return $status
}
same_numbers() { # FILE FILE of comma-separated fields: another libm rounds the last digits otherwise
    paste -d, "$1" "$2" | awk -F, '{
        for (i = 1; i <= NF / 2; i++) {
            a = $i; b = $(i + NF / 2); off = a - b; size = a < 0 ? -a : a
            if (a != b && (off > 1e-9 * size || -off > 1e-9 * size || size == 0)) { print NR ": " a " " b; bad = 1 }
        }
    } END { exit bad || NR < 10 }'
}
exe flare --version >"$dir/version" || sleep 1 # the first start makes the prefix
exe flare --version >"$dir/version"
result $? "flare.exe runs: $(cat "$dir/version")"

for name in 00_null 02_own_renderer flare; do
    make -s "build/$name" >"$dir/log" 2>&1 || cat "$dir/log" >&2
done
gcc -std=c99 -I. -O2 "$dir/search.c" -o "$dir/search" -lpthread -lm >"$dir/log" 2>&1 && "$dir/search" >"$dir/here"
exe search >"$dir/there" && [ "$(grep -c well "$dir/there")" = 5 ] && diff "$dir/here" "$dir/there" >>"$dir/log"
result $? "a search on threads comes to the same state as here"
for lens in heliar-tronnier canon-28-80; do
    build/flare info lenses/$lens.lens --json >"$dir/here"
    exe flare info lenses/$lens.lens --json >"$dir/there" && diff "$dir/here" "$dir/there" >>"$dir/log"
    result $? "flare.exe info --json, $lens: as here"
    build/flare ghosts lenses/$lens.lens --angle 5,3 --csv >"$dir/here"
    exe flare ghosts lenses/$lens.lens --angle 5,3 --csv >"$dir/there" && same_numbers "$dir/here" "$dir/there" >>"$dir/log"
    result $? "flare.exe ghosts --csv, $lens: as here to 1e-9"
done
build/00_null >"$dir/here"
exe 00_null >"$dir/there" && diff "$dir/here" "$dir/there" >>"$dir/log"
result $? "00_null.exe prints what it prints here"
exe 02_own_renderer >"$dir/there"
result $? "02_own_renderer.exe: its picture is the library's: $(cat "$dir/there")"

# pictures: a path with a backslash, a file that is there already
render="lenses/nikon-80-200-mid.lens --size 320x180 --angle 5,3 --fnumber 5.6 --blades 6 --radius 4.65"
build/flare render $render -o "$dir/here.pfm"
exe flare render $render -o "build\\mingw\\there.pfm"
result $? "flare.exe renders a PFM, the path with backslashes"
db=$(build/flare compare "$dir/here.pfm" "$dir/there.pfm" --json 2>>"$dir/log" | sed -nE 's/.*"psnr_linear_db": ([0-9.]+|null).*/\1/p')
cmp -s "$dir/here.pfm" "$dir/there.pfm" && db=identical
[ "$db" = identical ] || { [ -n "$db" ] && [ "$db" != null ] && awk "BEGIN {exit !($db >= 100)}"; }
result $? "the PFM of flare.exe against the one made here: $db"
cp "$dir/there.pfm" "$dir/first.pfm"
exe flare render $render -o "$dir/there.pfm" && cmp "$dir/first.pfm" "$dir/there.pfm" >>"$dir/log" 2>&1 && [ ! -e "$dir/there.pfm.part" ]
result $? "flare.exe writes over a file that is there"
build/flare render $render -o "$dir/here.png"
exe flare render $render -o "$dir/there.png" && cmp "$dir/here.png" "$dir/there.png" >>"$dir/log" 2>&1
result $? "flare.exe writes the same PNG"
exe flare info lenses/none.lens >"$dir/there"
[ $? = 2 ] && [ ! -s "$dir/there" ] && [ "$(wc -l <"$dir/log")" = 1 ]
result $? "flare.exe refuses a file that is not there with status 2 and one line: $(tr -d '\r' <"$dir/log")"
echo "1..$n"
