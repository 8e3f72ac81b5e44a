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
    while read -r define vertex fragment cuts shared; do
        for stage in $vertex.vert $fragment.frag; do
            {
                echo "#version $version"
                [ "$version" = "300 es" ] && printf 'precision highp float;\nprecision highp int;\n'
                echo "$define" | tr , '\n' | sed 's/^/#define /'
                [ "$stage" = "$vertex.vert" ] && echo '#define PATCH_VERTEX'
                cat $shared
                [ "$cuts" = cuts ] && [ "$stage" = "$fragment.frag" ] && cat shaders_embedded/cuts.glsl
                cat "shaders_embedded/$stage.glsl"
            } >"$dir/$stage"
            if command -v glslangValidator >/dev/null; then
                glslangValidator -S "${stage##*.}" "$dir/$stage" >"$dir/log" 2>&1 </dev/null
                status=$?
                [ $status = 0 ] || sed 's/^/# /' "$dir/log"
                result $status "glslangValidator: $version, $define, $stage"
            else
                n=$((n + 1))
                echo "ok $n # SKIP glslangValidator is not here: $version, $define, $stage"
            fi
        done
    done <<PROGRAMS
RIM ghost ghost cuts shaders_embedded/frame.glsl
RIM,FRINGES ghost ghost cuts shaders_embedded/frame.glsl
INSIDE ghost ghost cuts shaders_embedded/frame.glsl
PATCH patch patch - shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH_RIM,FRINGES patch patch cuts shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH_RIM,PATCH_STRIP patch patch cuts shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH_RIM,PATCH_STRIP,FRINGES patch patch cuts shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH traced patch - shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH_RIM,FRINGES traced patch cuts shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH_RIM,PATCH_STRIP traced patch cuts shaders_embedded/frame.glsl shaders_embedded/patches.glsl
PATCH_RIM,PATCH_STRIP,FRINGES traced patch cuts shaders_embedded/frame.glsl shaders_embedded/patches.glsl
STRIP screen strip - /dev/null
ADD screen add - /dev/null
STARBURST starburst starburst - shaders_embedded/frame.glsl
PROGRAMS
done
echo "1..$n"
