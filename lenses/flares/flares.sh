#!/bin/sh
# A small picture of every lens's flare, or of the lenses named: `make flares`. From the root, once build/flare is there; needs ImageMagick.
set -eu
flare=build/flare out=lenses/flares
LC_ALL=C
export LC_ALL
info=$(mktemp) picture=$(mktemp).png
trap 'rm -f "$info" "$picture" "${picture%.png}"' EXIT
[ $# -gt 0 ] || set -- lenses/*.lens
for lens; do
    "$flare" info "$lens" --json >"$info"
    # the sun's place: half of the half width to the right, a third of the half height up
    set_up=$(sed -nE 's/.*"efl_mm": ([0-9.e+-]+),.*"fnumber": ([0-9.e+-]+),.*"sensor_mm": \[([0-9.]+), ([0-9.]+)\].*/\1 \2 \3/p' "$info" |
        awk '{ d = 180 / atan2(0, -1); f = $2 > 5.6 ? $2 : 5.6; printf "--angle %.4f,%.4f --fnumber %.4f", d * atan2($3 / 4, $1), d * atan2($3 * 9 / 16 / 6, $1), f }')
    # shellcheck disable=SC2086
    "$flare" render "$lens" -o "$picture" --size 320x180 $set_up --blades 7 --curvature 0.3 --radius 4.65 --model paraxial
    convert "$picture" -quality 85 "$out/$(basename "$lens" .lens).jpg"
done
