#!/bin/sh
# What the documentation shows is compiled and run; its tables match the code. Prints TAP; run from the root.
set -u
B=build/docs
mkdir -p "$B"
n=0
ok() { n=$((n + 1)); echo "ok $n - $1"; }
bad() { n=$((n + 1)); echo "not ok $n - $1"; sed 's/^/# /' "$B/log" | head -20; }
skip() { n=$((n + 1)); echo "ok $n # SKIP $1"; }

# compile_and_run FILE TITLE EXPECTED
compile_and_run() {
    for how in "gcc -x c -Wall -Wextra -std=c99" "g++ -x c++ -Wall -Wextra -std=c++11 -Wno-missing-field-initializers"; do
        rm -f "$B/example"
        if $how -I. "$1" -o "$B/example" -lm >"$B/log" 2>&1 && [ ! -s "$B/log" ] && timeout 60 "$B/example" >"$B/log" 2>&1 &&
            grep -q "$3" "$B/log"; then ok "$2: ${how%% *}"; else bad "$2: ${how%% *}"; fi
    done
}

sed -n '/^ *@example$/,/^ *@end$/{/^ *@/d;s/^       //;p;}' lensflare.h >"$B/head.c"
if grep -q 'int main' "$B/head.c"; then compile_and_run "$B/head.c" "example in lensflare.h" '[1-9][0-9]* ghosts drawn'; else
    echo "no @example ... @end with a main" >"$B/log"; bad "example in lensflare.h"; fi

if [ -f README.md ]; then
    rm -f "$B"/readme_*.c
    awk -v base="$B/readme_" '/^```/ {if (on) {on = 0; close(file)} else if ($0 ~ /^```c *$/) {on = 1; k++; file = base k ".c"; printf "" >file}; next} on {print >file}' README.md
    found=0
    for f in "$B"/readme_*.c; do
        [ -f "$f" ] && grep -q 'int main' "$f" || continue
        found=$((found + 1))
        compile_and_run "$f" "README.md, program $found" ''
    done
    [ $found -gt 0 ] || skip "README.md shows no whole program"
    # every file that it names is there
    : >"$B/log"
    grep -oE '\]\([^)#]+\)|src="[^"]+"' README.md | sed -E 's/^\]\(//; s/\)$//; s/^src="//; s/"$//' | grep -v '^https\?:' | sort -u |
        while read -r f; do [ -e "$f" ] || echo "README.md names $f" >>"$B/log"; done
    [ -s "$B/log" ] && bad "README.md names files that exist" || ok "README.md names files that exist"
else
    skip "no README.md yet"
fi

sed -n '/CONTENTS/,/QUICK EXAMPLE/s/^ *>> \([0-9]* .*\)$/\1/p' lensflare.h >"$B/contents"
sed -n 's,^/\* >> \([0-9]* .*\) \*/$,\1,p' lensflare.h >"$B/rooms"
if [ -s "$B/contents" ] && diff "$B/contents" "$B/rooms" >"$B/log"; then ok "the contents name the rooms in order"; else bad "the contents name the rooms in order"; fi
awk '{if ($1 != NR - 1) {print "room " $0 " is number " NR - 1; wrong = 1}} END {exit wrong}' "$B/rooms" >"$B/log" && ok "rooms are numbered through" || bad "rooms are numbered through"
version=$(sed -n 's/^#define LFLARE_VERSION \([0-9]*\).*/\1/p' lensflare.h)
named=$(sed -n '1s/.* v\([0-9]*\)\.\([0-9]*\)\.\([0-9]*\) .*/\1 \2 \3/p' lensflare.h | awk '{print $1 * 10000 + $2 * 100 + $3}')
echo "first line says $named, LFLARE_VERSION $version" >"$B/log"
[ "$version" = "$named" ] && ok "the first line names LFLARE_VERSION" || bad "the first line names LFLARE_VERSION"

# sizes in the documentation's tables
{
    printf '#include "lensflare.h"\n'
    printf 'typedef char head[LFLARE_HEAD_FLOATS * 4 == %s ? 1 : -1];\n' "$(sed -n 's/^ *lens *head .* \([0-9]*\) bytes$/\1/p' lensflare.h)"
    printf 'typedef char rims[LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS * 4 == %s ? 1 : -1];\n' "$(sed -n 's/^ *lens *rims .* \([0-9]*\) bytes$/\1/p' lensflare.h)"
    printf 'typedef char film[LFLARE_FILM_SAMPLES * 16 == %s ? 1 : -1];\n' "$(sed -n 's/^ *lens *film .* \([0-9]*\) bytes$/\1/p' lensflare.h)"
    printf 'typedef char field[LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS * 4 == %s ? 1 : -1];\n' "$(sed -n 's/^ *settings *field .* \([0-9]*\) bytes$/\1/p' lensflare.h)"
    printf 'typedef char cull[sizeof(lflare_cull) == %s ? 1 : -1];\n' "$(sed -n 's/^ *settings *cull .* \([0-9]*\) bytes$/\1/p' lensflare.h)"
    printf 'typedef char light[sizeof(lflare_frame_light) == %s ? 1 : -1];\n' "$(sed -n 's/^ *frame *lights *\([0-9]*\) bytes each$/\1/p' lensflare.h)"
    printf 'typedef char instance[sizeof(lflare_instance) == %s ? 1 : -1];\n' "$(sed -n 's/^ *instance .* \([0-9]*\) bytes$/\1/p' lensflare.h)"
} >"$B/sizes.c"
gcc -std=c99 -I. -fsyntax-only "$B/sizes.c" >"$B/log" 2>&1 && ok "the bytes stated for the tables are right" || bad "the bytes stated for the tables are right"

{ git ls-files -z 2>/dev/null; git ls-files -z --others --exclude-standard 2>/dev/null; } | xargs -0 grep -nIE '(TO''DO|FIX''ME|XX''X)' 2>/dev/null | grep -v '^tests/check_docs.sh' >"$B/log"
[ -s "$B/log" ] && bad "no reminders are left in the files" || ok "no reminders are left in the files"
echo "1..$n"
