#!/bin/sh
# The shaders in lensflare.h are those of shaders_embedded, and the reference compiler accepts every variant. TAP.
set -u
cd "$(dirname "$0")/.." || exit 2
dir=build/shaders
mkdir -p "$dir"
n=0
say() { n=$((n + 1)); echo "$1 $n - $2"; }
result() { if [ "$1" = 0 ]; then say ok "$2"; else say "not ok" "$2"; fi; }
shaders_embedded/embed.sh lensflare.h >"$dir/lensflare.h"
cmp -s "$dir/lensflare.h" lensflare.h
result $? "lensflare.h holds the shaders of shaders_embedded (else: make shaders)"
for version in "330 core" "300 es"; do
    for program in RIM INSIDE; do
        for stage in vert frag; do
            {
                echo "#version $version"
                [ "$version" = "300 es" ] && printf 'precision highp float;\nprecision highp int;\n'
                echo "#define $program"
                cat shaders_embedded/frame.glsl "shaders_embedded/ghost.$stage.glsl"
            } >"$dir/ghost.$stage"
            if command -v glslangValidator >/dev/null; then
                glslangValidator -S $stage "$dir/ghost.$stage" >"$dir/log" 2>&1
                status=$?
                [ $status = 0 ] || sed 's/^/# /' "$dir/log"
                result $status "glslangValidator: $version, $program, $stage"
            else
                n=$((n + 1))
                echo "ok $n # SKIP glslangValidator is not here: $version, $program, $stage"
            fi
        done
    done
done
echo "1..$n"
