#!/bin/sh
# The contract of the command-line tool: keys, columns, file formats, complaints with exit status 2. TAP.
set -u
cd "$(dirname "$0")/.." || exit 2
flare=build/flare dir=build/tool n=0
rm -rf "$dir" && mkdir -p "$dir"
result() { # STATUS WHAT
    n=$((n + 1))
    if [ "$1" = 0 ]; then echo "ok $n - $2"; else echo "not ok $n - $2"; fi
}
refused() { # WHAT PATTERN ARGUMENTS...: status 2, one line on stderr that matches, nothing on stdout
    what=$1 pattern=$2
    shift 2
    "$flare" "$@" >"$dir/out" 2>"$dir/err"
    status=$?
    [ $status = 2 ] && [ ! -s "$dir/out" ] && [ "$(wc -l <"$dir/err")" = 1 ] && grep -qE "$pattern" "$dir/err"
    ok=$?
    [ $ok = 0 ] || sed 's/^/# /' "$dir/err"
    result $ok "$what"
}
heliar=tests/data/heliar-golden.lens

keys=$("$flare" info $heliar --json | tr ',{' '\n\n' | sed -nE 's/^ *"([a-z_]+)":.*/\1/p' | tr '\n' ' ')
[ "$keys" = "name patent surfaces stop efl_mm bfd_mm fnumber ghosts sensor_mm notes " ]
result $? "info --json has its keys in order"
"$flare" info $heliar --json | grep -q '"surfaces": 9, "stop": 6, "efl_mm": 99.2357963491[0-9]*, "bfd_mm": 81.3150564217[0-9]*, .*"ghosts": 13'
result $? "info --json has the Heliar's numbers"

"$flare" ghosts $heliar --angle 10,5 --fnumber 8 --csv >"$dir/ghosts.csv"
[ "$(head -1 "$dir/ghosts.csv")" = "first,second,Ma11,Ma12,M11,M12,iris_x,iris_y,iris_r,pupil_x,pupil_y,pupil_r,clip,r,g,b" ]
result $? "ghosts --csv has its columns"
[ "$(tail -n +2 "$dir/ghosts.csv" | wc -l)" = 13 ] && awk -F, 'NF != 16 {exit 1}' "$dir/ghosts.csv"
result $? "ghosts --csv has 13 rows of 16 fields"
"$flare" ghosts $heliar --across-stop --four --csv >"$dir/more.csv"
[ "$(head -1 "$dir/more.csv")" = "$(head -1 "$dir/ghosts.csv"),third,fourth" ] && awk -F, 'NR > 1 && NF != 18 {exit 1} NR > 1 && $17 == 0 {two++} NR > 1 && $17 > $2 && $18 < $17 {four++} END {exit two != 28 || four != 64}' "$dir/more.csv"
result $? "ghosts --across-stop --four --csv appends third and fourth"
"$flare" info $heliar --across-stop --four | grep -q '^ghosts    92, .* across the stop, 64 of four reflections'
result $? "info counts them"
"$flare" trace $heliar --ghost 7,2 --ray 0,0 --across-stop >"$dir/ray.txt" && [ "$(grep -c 'the stop$' "$dir/ray.txt")" = 3 ] && "$flare" trace $heliar --ghost 4,2,3,1 --ray 0,0 --json | grep -q '"ghost": \[4,2,3,1\]'
result $? "trace follows them"
"$flare" diagram $heliar -o "$dir/more.svg" --ghost 4,2,3,1 --rays 0 && [ "$(grep -c 'class="mirror"' "$dir/more.svg")" = 4 ] && grep -q 'ghost 4,2,3,1 ' "$dir/more.svg"
result $? "diagram draws four mirrors"
"$flare" render $heliar -o "$dir/plain.pfm" --size 64x48 --angle 5,3 --ghosts-only && "$flare" render $heliar -o "$dir/more.pfm" --size 64x48 --angle 5,3 --ghosts-only --across-stop --four && ! cmp -s "$dir/plain.pfm" "$dir/more.pfm"
result $? "render draws them"
# (4,2): u = -(tan 10, tan 5), M12 = 140.265: the pupil's image lies left and below on the sensor
awk -F, '$1 == 4 && $2 == 2 {found = ($10 + 24.7326 < 0.001 && $10 + 24.7326 > -0.001 && $11 < 0)} END {exit !found}' "$dir/ghosts.csv"
result $? "ghosts prints sensor coordinates with their sign"

# exact rays computed independently in double precision (the project's golden numbers): entrance 0.01 mm, light at 1e-4 rad
traced() { # FILE KEY INDEX: the number there
    sed -nE "s/.*\"$2\": \[([^]]*)\].*/\1/p" "$1" | cut -d, -f"$3"
}
near() { awk "BEGIN {d = ($1) - ($2); exit !(d < $3 && -d < $3)}"; } # A B TOLERANCE
bad=0
while read -r pair stop sensor; do
    "$flare" trace $heliar --ghost "$pair" --ray 0.01,0 --angle -0.005729577951308232,0 --json >"$dir/ray.json" || bad=1
    near "$(traced "$dir/ray.json" stop_mm 1)" "$stop" 1e-12 && near "$(traced "$dir/ray.json" sensor_mm 1)" "$sensor" 1e-12 || { bad=1; echo "# ghost $pair"; }
done <<'END'
2,1 -0.011680697963755026 -0.10900388772409833
4,2 0.007949443332523018 0.011110923445107054
5,2 0.03493283258249548 0.17970205570452324
9,8 0.009625746804144467 -0.11928530079532852
END
result $bad "trace meets the golden rays to 1e-12 mm"
# the same ray turned a quarter: everything in y
"$flare" trace $heliar --ghost 4,2 --ray 0,0.01 --angle 0,-0.005729577951308232 --json >"$dir/ray.json"
near "$(traced "$dir/ray.json" sensor_mm 2)" 0.011110923445107054 1e-12 && near "$(traced "$dir/ray.json" sensor_mm 1)" 0 1e-12
result $? "trace has y as it has x"
[ "$(tr -d '\n' <"$dir/ray.json" | sed -E 's/\{"surface"[^}]*\}(, )?//g' | grep -oE '"[a-z_]+":' | tr -d '":' | tr '\n' ' ')" = "name ghost lambda_nm entrance_mm slope hits sensor_mm stop_mm weight widest widest_relative fate lost_at blocked_by " ] &&
    [ "$(grep -oE '\{"surface"[^}]*\}' "$dir/ray.json" | sed -n 4p | grep -oE '"[a-z_]+":' | tr -d '":' | tr '\n' ' ')" = "surface backwards reflected x y z dx dy dz relative incidence_deg share " ]
result $? "trace --json has its keys in order"
[ "$(grep -oE '"surface": [0-9]+' "$dir/ray.json" | sed 's/.* //' | tr '\n' ' ')" = "1 2 3 4 3 2 3 4 5 6 7 8 9 " ] && [ "$(grep -o '"reflected": true' "$dir/ray.json" | wc -l)" = 2 ]
result $? "trace --ghost 4,2 goes 1 2 3 4, 3 2, 3 to 9"
# on the axis: normal incidence, Fresnel's ((n - 1) / (n + 1))^2 of each surface
"$flare" trace $heliar --ghost 4,2 --ray 0,0 --json >"$dir/ray.json"
weight=$(awk 'BEGIN {
    n = split("1.652 1.603 1 1.643 1 1 1.581 1.694 1", behind, " "); before = 1; w = 1
    for (i = 1; i <= n; i++) { r[i] = ((behind[i] - before) / (behind[i] + before)) ^ 2; before = behind[i]; w *= i == 4 ? r[4] * (1 - r[3]) * r[2] * (1 - r[3]) * (1 - r[4]) : 1 - r[i] }
    printf "%.15g", w }')
near "$(sed -nE 's/.*"weight": ([^,]*),.*/\1/p' "$dir/ray.json")" "$weight" 1e-18
result $? "trace on the axis weighs by Fresnel's formula: $weight"
fate() { # WHAT PATTERN ARGUMENTS...: both the sentence and the JSON
    what=$1 sentence=$2 json=$3
    shift 3
    "$flare" trace "$@" | grep -qE "^fate      $sentence\$" && "$flare" trace "$@" --json | grep -q "$json"
    result $? "trace: $what"
}
printf 'lensflare 1\nfnumber 4\nstop 1 semi 4\nflat 12 n 1.7 semi 12\n-10 50 air semi 9.9\n' >"$dir/ball.lens"
fate "a ray that arrives" 'arrives' '"fate": "arrives", "lost_at": null, "blocked_by": null' "$dir/ball.lens" --ray 2,1
fate "a ray past the stop" 'arrives, but for the stop, .*' '"fate": "arrives", "lost_at": null, "blocked_by": 1' "$dir/ball.lens" --ray 5,0
fate "a ray through a rim" 'arrives, but for the rim of surface 1, .*' '"fate": "arrives", "lost_at": null, "blocked_by": 1' $heliar --ray 14.6,0
fate "total reflection" 'totally reflected at surface 3, .*' '"fate": "total", "lost_at": 3' "$dir/ball.lens" --ray 9,0
fate "a ray beside the surface" 'misses surface 3' '"sensor_mm": null, .*"fate": "misses", "lost_at": 3' "$dir/ball.lens" --ray 10.5,0
"$flare" trace $heliar --ghost 4,2 --ray 3,4 --angle 10,5 >"$dir/ray.txt" && [ "$(grep -cE '^ +[0-9]+ (->|<-|->\||\|<-) ' "$dir/ray.txt")" = 13 ] && grep -q '^sensor  ' "$dir/ray.txt"
result $? "trace prints a table of 13 hits"

"$flare" render $heliar -o "$dir/a.pfm" --size 64x48 --angle 5,3 --ghosts-only && [ "$(head -c 12 "$dir/a.pfm" | tr '\n' ' ')" = "PF 64 48 -1." ] && [ "$(wc -c <"$dir/a.pfm")" = $((3 + 6 + 5 + 64 * 48 * 12)) ]
result $? "render writes a PFM of the right size"
"$flare" render $heliar -o "$dir/a.png" --size 64x48 --angle 5,3 && head -c 8 "$dir/a.png" | od -An -tx1 | grep -q '89 50 4e 47 0d 0a 1a 0a'
result $? "render writes a PNG"
"$flare" compare "$dir/a.pfm" "$dir/a.pfm" --json | grep -q '"psnr_db": null, .*"ssim": 1.*"largest_error": 0,'
result $? "compare finds a picture equal to itself"
"$flare" render $heliar -o "$dir/b.pfm" --size 64x48 --angle 5,3 --fnumber 22
"$flare" compare "$dir/a.pfm" "$dir/b.pfm" | grep -qE '^PSNR +[0-9.]+ dB'
result $? "compare prints PSNR"
[ "$("$flare" coating 1 1.5168 --csv | head -1)" = "lambda_nm,R" ] && "$flare" coating 1 1.5 --csv | awk -F, 'NR == 2 {exit !($2 > 0.03999 && $2 < 0.04001)}'
result $? "coating prints 4 % for bare glass of index 1.5"
frame="lenses/planar-50-14.lens --size 640x360 --angle 10,6 --fnumber 5.6 --blades 7 --curvature 0.3 --radius 4.65"
"$flare" render $frame -o "$dir/software.pfm" --backend software
for host in egl osmesa; do
    rm -f "$dir/gl.pfm"
    GL_HOST=$host "$flare" render $frame -o "$dir/gl.pfm" --backend gl 2>"$dir/err"
    if grep -q 'cannot be loaded' "$dir/err"; then
        n=$((n + 1))
        echo "ok $n # SKIP render --backend gl with $host: $(sed 's/^flare: --backend gl: //' "$dir/err")"
        continue
    fi
    sed 's/^/# /' "$dir/err"
    db=$("$flare" compare "$dir/software.pfm" "$dir/gl.pfm" --json | sed -nE 's/.*"psnr_linear_db": ([0-9]+|null).*/\1/p') # null: equal
    [ "$db" = null ] || [ "${db:-0}" -ge 50 ]
    result $? "render --backend gl draws with $host what software does: ${db:-no} dB, linear"
done
# ---- the reference ----
picture=tests/data/heliar-picture.lens
"$flare" render $picture -o "$dir/ref.pfm" --size 80x45 --angle 10,5 --fnumber 8 --ghosts-only --model reference --cells 20 2>"$dir/err" && [ "$(cat "$dir/err")" = "flare: reference: a mesh of 20 cells a side" ]
db=$("$flare" compare tests/data/heliar-picture.pfm "$dir/ref.pfm" --json | sed -nE 's/.*"psnr_db": ([0-9]+).*/\1/p')
[ "${db:-0}" -ge 50 ]
result $? "render --model reference meets the golden picture: ${db:-no} dB"
"$flare" render $picture -o "$dir/ref2.pfm" --size 64x36 --angle 10,5 --fnumber 8 --model reference 2>"$dir/err"
grep -qE '^flare: reference: meshes of 60 and 96 cells a side agree to [5-9][0-9]\.[0-9] dB$' "$dir/err" && [ "$(wc -l <"$dir/err")" = 1 ]
result $? "render --model reference says how well two meshes agree"
# ---- starbursts ----
"$flare" starburst lenses/heliar-tronnier.lens -o "$dir/burst.pfm" --size 64 --blades 5 --dust 20 --grating 12 --seed 3 && [ "$(head -n 2 "$dir/burst.pfm" | tr '\n' ' ')" = "PF 64 64 " ]
result $? "starburst writes a picture of the size asked for"
"$flare" starburst lenses/heliar-tronnier.lens -o "$dir/burst2.pfm" --size 64 --blades 5 --dust 20 --grating 12 --seed 3 && cmp -s "$dir/burst.pfm" "$dir/burst2.pfm"
result $? "starburst: the same seed, the same bytes"
"$flare" render lenses/heliar-tronnier.lens -o "$dir/x.pfm" --size 64x36 --angle 5,2 --mask "$dir/burst.pfm" 2>"$dir/err"
[ $? = 2 ] && grep -q "share of power" "$dir/err"
result $? "render --mask says which pixel is no share of power"
"$flare" render lenses/heliar-tronnier.lens -o "$dir/a.pfm" --size 64x36 --angle 5,2 && "$flare" render lenses/heliar-tronnier.lens -o "$dir/b.pfm" --size 64x36 --angle 5,2 --ghosts-only &&
    ! cmp -s "$dir/a.pfm" "$dir/b.pfm"
result $? "render draws the whole flare unless --ghosts-only"
# near the axis and stopped down both models are one: a ghost's colour and place, the same exposure in a PNG
small="$picture --size 160x90 --angle 1,0.5 --fnumber 22 --blades 5 --fov 10 --ghosts-only"
"$flare" render $small -o "$dir/par.pfm" && "$flare" render $small -o "$dir/exact.pfm" --model reference --cells 20 2>"$dir/err"
"$flare" render $small -o "$dir/par.png" && "$flare" render $small -o "$dir/exact.png" --model reference --cells 20 --radius 1 2>"$dir/err"
grep -q '^flare: --radius has no effect' "$dir/err"
result $? "render --model reference says that it leaves --radius out"
for kind in pfm png; do
    db=$("$flare" compare "$dir/par.$kind" "$dir/exact.$kind" --json 2>/dev/null | sed -nE 's/.*"psnr_db": ([0-9]+).*/\1/p')
    if [ $kind = png ] && "$flare" compare "$dir/par.png" "$dir/par.png" 2>&1 | grep -q 'built without libpng'; then
        n=$((n + 1))
        echo "ok $n # SKIP this flare was built without libpng: both models as PNG"
        continue
    fi
    [ "${db:-0}" -ge 30 ]
    result $? "both models agree near the axis ($kind): ${db:-no} dB"
done
# white is white: with any number of wavelengths, glass of constant index and no film has no colour
printf 'lensflare 1\nfnumber 4\n50 4 n 1.5 semi 12\n-60 2 air semi 12\nstop 40 semi 8\n' >"$dir/grey.lens"
"$flare" render "$dir/grey.lens" -o "$dir/three.pfm" --size 32x18 --model reference --cells 20 --angle 3,2 2>"$dir/err"
"$flare" render "$dir/grey.lens" -o "$dir/many.pfm" --size 32x18 --model reference --cells 20 --angle 3,2 --wavelengths 12 2>"$dir/err"
db=$("$flare" compare "$dir/three.pfm" "$dir/many.pfm" --json | sed -nE 's/.*"psnr_db": ([0-9]+|null).*/\1/p')
[ "$db" = null ] || [ "${db:-0}" -ge 90 ]
result $? "twelve wavelengths are as white as three: $db dB"
for signal in INT TERM; do
    rm -f "$dir/never.pfm"
    "$flare" render lenses/nikon-80-200-mid.lens -o "$dir/never.pfm" --model reference --size 640x360 --cells 400 2>"$dir/err" &
    pid=$!
    sleep 1
    kill -$signal $pid
    wait $pid
    [ $? = 130 ] && [ ! -e "$dir/never.pfm" ] && [ ! -e "$dir/never.pfm.part" ] && [ "$(cat "$dir/err")" = "flare: interrupted; nothing was written" ]
    result $? "SIG$signal ends a long render: status 130, no file"
done

# ---- fits ----
tronnier=$dir/tronnier.lens fit=$dir/heliar.fit # a copy without a fit beside it
cp lenses/heliar-tronnier.lens "$tronnier"
"$flare" fit $tronnier -o "$fit" >"$dir/out" 2>"$dir/err" && [ ! -s "$dir/err" ] &&
    [ "$(sed -E 's/[0-9]+\.[0-9][0-9] s$/S s/' "$dir/out")" = "$fit: 13 ghosts, $(wc -c <"$fit" | tr -d ' ') bytes, S s" ]
result $? "fit prints one line: $(sed 's/.*: //' "$dir/out")"
mkdir -p "$dir/fits" && echo old >"$dir/fits/again.fit" && ln -sf again.fit "$dir/fits/link.fit"
"$flare" fit $tronnier -o "$dir/fits/link.fit" >/dev/null && cmp -s "$fit" "$dir/fits/again.fit" && [ -L "$dir/fits/link.fit" ]
result $? "fit gives the same bytes again, replaces what was there and keeps a link"
"$flare" fit $tronnier -o /dev/stdout 2>"$dir/err" | cmp -s - "$fit" && grep -q '13 ghosts' "$dir/err"
result $? "fit into a pipe gives the same bytes"
flat="$tronnier --size 320x180 --ghosts-only --angle 13.4,0 --fnumber 8"
"$flare" render $flat -o "$dir/par.pfm" --model paraxial && "$flare" render $flat -o "$dir/plain.pfm" && cmp -s "$dir/par.pfm" "$dir/plain.pfm"
result $? "render is paraxial without --model and --fit"
"$flare" render $flat -o "$dir/poly.pfm" --model polynomial >"$dir/out" 2>"$dir/err" && [ ! -s "$dir/out" ] && [ ! -s "$dir/err" ]
result $? "render --model polynomial fits by itself, silently where no one looks"
"$flare" render $flat -o "$dir/loaded.pfm" --fit "$fit" && cmp -s "$dir/poly.pfm" "$dir/loaded.pfm" && ! cmp -s "$dir/poly.pfm" "$dir/par.pfm"
result $? "render --fit is polynomial, and the same picture"
cp "$fit" "$dir/tronnier.fit"
"$flare" render $flat -o "$dir/beside.pfm" && cmp -s "$dir/poly.pfm" "$dir/beside.pfm" && "$flare" render $flat -o "$dir/beside.pfm" --model paraxial &&
    cmp -s "$dir/par.pfm" "$dir/beside.pfm"
result $? "render takes the fit that lies beside the lens, unless it is to be paraxial"
echo broken >"$dir/tronnier.fit"
"$flare" render $flat -o "$dir/beside.pfm" 2>"$dir/err" && cmp -s "$dir/par.pfm" "$dir/beside.pfm" && grep -q 'tronnier.fit is not used: ' "$dir/err"
result $? "render says that a fit beside the lens is none: $(cat "$dir/err")"
rm -f "$dir/tronnier.fit"
wrong=0
for lens in lenses/*.fit; do
    "$flare" render "${lens%.fit}.lens" -o "$dir/shipped.pfm" --size 64x36 --fit "$lens" || wrong=1
done
result $wrong "shipped fits are those of their lenses"
"$flare" render $flat -o "$dir/loaded.pfm" --fit "$fit" --model polynomial && cmp -s "$dir/poly.pfm" "$dir/loaded.pfm"
result $? "render --fit --model polynomial is too"
"$flare" render $flat -o "$dir/exact.pfm" --model reference --cells 60 2>"$dir/err"
worth() { "$flare" compare "$dir/exact.pfm" "$1" --json | sed -nE 's/.*"psnr_db": ([0-9.]+).*/\1/p' | cut -c1-5; } # PICTURE: dB against exact rays
poly=$(worth "$dir/poly.pfm") par=$(worth "$dir/par.pfm")
awk "BEGIN {exit !(${poly:-0} > 45 && ${poly:-0} > ${par:-99})}"
result $? "render --model polynomial comes near to exact rays: ${poly:-no} dB, paraxial ${par:-no} dB"
if script --version 2>/dev/null | grep -q util-linux; then
    script -qec "$flare render $flat -o $dir/seen.pfm --model polynomial" /dev/null </dev/null >"$dir/out" && cmp -s "$dir/poly.pfm" "$dir/seen.pfm" &&
        tr '\r' '\n' <"$dir/out" | grep -qE '^fitting: [0-9]+ %, about [0-9]+ s left' && tr '\r' '\n' <"$dir/out" | grep -qE '^flare: 13 ghosts fitted in [0-9.]+ s; '
    result $? "render --model polynomial says on a terminal what it fits, and how long it took"
    script -qec "$flare fit $tronnier -o $dir/fits/seen.fit" /dev/null </dev/null >"$dir/out" && tr '\r' '\n' <"$dir/out" | grep -qE '^fitting: [0-9]+ %, about [0-9]+ s left'
    result $? "fit shows on a terminal how far it is"
else
    n=$((n + 2))
    echo "ok $((n - 1)) # SKIP no script(1) of util-linux: render's progress on a terminal"
    echo "ok $n # SKIP no script(1) of util-linux: fit's progress on a terminal"
fi
interrupted() { # WHAT SIGNAL OUT ARGUMENTS...: status 130, one line, no file
    what=$1 signal=$2 out=$3
    shift 3
    "$flare" "$@" -o "$out" >"$dir/out" 2>"$dir/err" &
    pid=$!
    for wait in 1 2 3 4 5; do [ -e "$out.part" ] || sleep 0.1; done # no longer than until it is at work
    kill -"$signal" $pid
    wait $pid
    [ $? = 130 ] && [ ! -s "$dir/out" ] && [ ! -e "$out" ] && [ ! -e "$out.part" ] && [ "$(cat "$dir/err")" = "flare: interrupted; nothing was written" ]
    result $? "$what"
}
long=lenses/canon-70-200-mid.lens # 312 ghosts, 9 s
interrupted "SIGINT ends a fit: status 130, no file" INT "$dir/never.fit" fit $long
interrupted "SIGTERM ends a fit: status 130, no file" TERM "$dir/never.fit" fit $long
interrupted "SIGINT ends a fit for a picture: status 130, no file" INT "$dir/never.pfm" render $long --model polynomial
# a limit of 4 or 8 KB on files is a disk that fills up
cp "$dir/fits/again.fit" "$dir/fits/kept.fit"
(trap '' XFSZ && ulimit -f 8 && exec "$flare" fit $tronnier -o "$dir/fits/kept.fit") >"$dir/out" 2>"$dir/err"
[ $? = 2 ] && [ ! -s "$dir/out" ] && [ "$(wc -l <"$dir/err")" = 1 ] && grep -q "^flare: $dir/fits/kept.fit: cannot be written: " "$dir/err" &&
    cmp -s "$fit" "$dir/fits/kept.fit" && [ ! -e "$dir/fits/kept.fit.part" ]
result $? "a fit that does not fit leaves the one before"
half=$(($(wc -c <"$fit") / 2))
head -c $half "$fit" >"$dir/fits/cut.fit"
cp "$fit" "$dir/fits/flipped.fit"
printf "\\$(printf %o $(($(od -An -tu1 -j$half -N1 "$fit") ^ 16)))" | dd of="$dir/fits/flipped.fit" bs=1 seek=$half conv=notrunc 2>/dev/null
cp "$fit" "$dir/fits/older.fit"
printf '\000\000' | dd of="$dir/fits/older.fit" bs=1 seek=6 conv=notrunc 2>/dev/null
: >"$dir/fits/empty.fit"
with="render $tronnier -o $dir/c.png --size 32x18 --fit"
refused "a fit that is cut off" "^flare: $dir/fits/cut.fit: the fit is cut off" $with "$dir/fits/cut.fit"
refused "a fit with one bit turned" "^flare: $dir/fits/flipped.fit: the fit is damaged" $with "$dir/fits/flipped.fit"
refused "a fit of an older version" "^flare: $dir/fits/older.fit: the fit has version 0" $with "$dir/fits/older.fit"
refused "an empty fit" "^flare: $dir/fits/empty.fit: this is not a fit" $with "$dir/fits/empty.fit"
refused "a lens for a fit" "^flare: $tronnier: this is not a fit" $with $tronnier
refused "a folder for a fit" "^flare: $dir/fits: Is a directory" $with "$dir/fits"
refused "a fit that is not there" "^flare: $dir/fits/none.fit: No such file" $with "$dir/fits/none.fit"
refused "a fit of another lens" "^flare: $fit: the fit belongs to another lens" render $heliar -o "$dir/c.png" --fit "$fit"
refused "a fit for the paraxial model" '^flare: --fit belongs to --model polynomial, not to --model paraxial$' $with "$fit" --model paraxial
refused "a fit for the reference" '^flare: --fit belongs to --model polynomial, not to --model reference$' $with "$fit" --model reference
refused "cells of the polynomial model" '^flare: --cells belongs to --model reference$' $with "$fit" --cells 20
refused "a fit that goes nowhere" '^flare: flare fit: say where the fit goes' fit $tronnier
refused "a fit in place of a lens" "^flare: $dir/c.lens: a lens would be lost" fit $tronnier -o "$dir/c.lens"
refused "a fit in place of a folder" "^flare: $dir/fits: cannot be written: Is a directory" fit $tronnier -o "$dir/fits"
refused "a fit in a folder that is not there" "^flare: $dir/no/c.fit: cannot be written: " fit $tronnier -o "$dir/no/c.fit"
refused "a fit of a lens that is not there" "^flare: $dir/none.lens: No such file" fit "$dir/none.lens" -o "$dir/c.fit"
refused "a fit with an option of another command" "unknown option '--fnumber' for 'flare fit'" fit $tronnier -o "$dir/c.fit" --fnumber 8
if [ -w /dev/full ]; then
    refused "a fit on a full disk" '^flare: /dev/full: cannot be written: ' fit $tronnier -o /dev/full
    [ -c /dev/full ] && [ ! -e /dev/full.part ]
    result $? "a device stays one"
fi

# ---- diagrams ----
well_formed() { # FILE: by xmllint, or else every element closed
    if command -v xmllint >/dev/null; then xmllint --noout "$1"; else
        awk '{ while (match($0, /<[^>]*>/)) { t = substr($0, RSTART, RLENGTH); $0 = substr($0, RSTART + RLENGTH); d += t ~ /^<\// ? -1 : t ~ /\/>$/ ? 0 : 1 } } END { exit d != 0 || NR < 5 }' "$1"
    fi
}
glasses() { sed 's/#.*//' "$1" | grep -cE '^ *(-?[0-9.]+|flat) .* (nd?|sellmeier|cauchy) '; }
same_drawing() { # FILE FILE: other machines may round a last digit otherwise
    [ "$(tr -d '0-9.\n-' <"$1")" = "$(tr -d '0-9.\n-' <"$2")" ] && { tr -cs '0-9.\n-' '\n' <"$1" >"$dir/one"; tr -cs '0-9.\n-' '\n' <"$2" >"$dir/two"; } &&
        paste -d ' ' "$dir/one" "$dir/two" | awk 'NF == 2 && ($1 - $2 > 0.02 || $2 - $1 > 0.02) { exit 1 }'
}
bad=0
for lens in lenses/*.lens; do
    svg=lenses/diagrams/$(basename "$lens" .lens).svg
    "$flare" diagram "$lens" -o "$dir/lens.svg" && well_formed "$dir/lens.svg" && [ "$(grep -c 'class="glass"' "$dir/lens.svg")" = "$(glasses "$lens")" ] &&
        [ "$(grep -c '^<path d=' "$dir/lens.svg")" = 5 ] && [ "$(grep -c 'class="stop"' "$dir/lens.svg")" = 2 ] && ! grep -qE 'nan|inf' "$dir/lens.svg" ||
        { bad=1; echo "# $lens"; }
    [ -f "$svg" ] && [ "$(wc -c <"$svg")" -lt 20000 ] && same_drawing "$svg" "$dir/lens.svg" && grep -q "(diagrams/$(basename "$svg"))" lenses/README.md ||
        { bad=1; echo "# $svg is not what 'make diagrams' makes"; }
done
result $bad "diagram: an outline a glass, five rays, in lenses/README.md, for every lens"
# cemented glasses share a face: the arc of the common surface is there twice, once each way
printf 'lensflare 1\nname A & B <"C">\nfnumber 8\nstop 2 semi 4\n50 4 n 1.5 semi 10\n-40 2 n 1.7 semi 10\n-90 80 air semi 10\n' >"$dir/pair.lens"
"$flare" diagram "$dir/pair.lens" -o "$dir/pair.svg" && well_formed "$dir/pair.svg" && grep -q '<title>A &amp; B &lt;"C"&gt;</title>' "$dir/pair.svg"
result $? "diagram writes names as XML wants them"
[ "$(grep 'class="glass"' "$dir/pair.svg" | grep -oE 'A[0-9.]+ ' | sort | uniq -c | awk '{print $1}' | sort | tr '\n' ' ')" = "1 1 2 " ]
result $? "diagram: cemented glasses share a face"
"$flare" diagram $heliar -o "$dir/ghost.svg" --ghost 4,2 --rays 9 --angle 0,5 && well_formed "$dir/ghost.svg" && [ "$(grep -c '^<path d=' "$dir/ghost.svg")" = 18 ] && [ "$(grep -c 'class="mirror"' "$dir/ghost.svg")" = 2 ]
result $? "diagram --ghost draws its rays and both mirrors"
# the bounds are where `flare trace` finds that rays begin to pass
bounds=$(sed -nE 's/.*ghost 4,2 enters at ([-0-9.]+) to ([-0-9.]+) mm.*/\1 \2/p' "$dir/ghost.svg")
bad=0
for side in 1 2; do
    at=$(echo "$bounds" | cut -d' ' -f$side)
    for step in 0.02 -0.02; do
        y=$(awk "BEGIN {print $at + $step}")
        passes=$("$flare" trace $heliar --ghost 4,2 --angle 0,5 --ray "0,$y" --json | grep -c '"fate": "arrives", "lost_at": null, "blocked_by": null')
        case "$side$step$passes" in 10.021 | 1-0.020 | 20.020 | 2-0.021) ;; *) bad=1 ;; esac
    done
done
result $bad "diagram --ghost states the entrance heights that pass: ${bounds:-none}"

"$flare" --version | grep -q '^flare [0-9]' && "$flare" --help | grep -q 'flare render' && "$flare" --help | grep -q 'flare fit ' && "$flare" --help | grep -q -e '--fit FILE' && "$flare" render --help | grep -q 'flare render'
result $? "--version and --help"

printf 'lensflare 1\nfnumber 2\n50 3 n 1.5\n-50 x\n' >"$dir/bad.lens"
refused "an unreadable lens says FILE:LINE:COLUMN" "^$dir/bad.lens:4:5: " info "$dir/bad.lens"
refused "a missing file" 'No such file' info "$dir/none.lens"
refused "a directory" . info "$dir"
refused "an unknown command" "unknown command 'draw'" draw
refused "an unknown option" "unknown option '--sice'" render $heliar -o "$dir/c.png" --sice 3x3
refused "a bad number" "^flare: --fnumber: .*'fast'" render $heliar -o "$dir/c.png" --fnumber fast
refused "a ghost that is none" "7,2 is no ghost" trace $heliar --ray 0,0 --ghost 7,2
refused "a pair the wrong way round" "2,4 is no ghost" trace $heliar --ray 0,0 --ghost 2,4
refused "three surfaces" "'2,3' is one|a number from 1|two numbers" trace $heliar --ray 0,0 --ghost 4,2,3
refused "no path" "4,2,2,1 is no ghost" trace $heliar --ray 0,0 --ghost 4,2,2,1
refused "surface 0" "^flare: --ghost: a number from 1" trace $heliar --ray 0,0 --ghost 0,1
refused "half a surface" "^flare: --ghost: two surface numbers" trace $heliar --ray 0,0 --ghost 4.5,2
refused "no ray" "with --ray X,Y" trace $heliar --ghost 4,2
refused "half a ray" "^flare: --ray: two numbers joined by ','" trace $heliar --ray 3
refused "a wavelength of nothing" "^flare: --lambda: " trace $heliar --ray 0,0 --lambda 0
refused "an option of another command" "unknown option '--fnumber' for 'flare trace'" trace $heliar --ray 0,0 --fnumber 8
refused "a missing value" "a value is missing" render $heliar -o
refused "no output named" "with -o" render $heliar
refused "an unknown picture format" "\.png or \.pfm" render $heliar -o "$dir/c.jpg"
refused "a folder that is not there" "cannot be written" render $heliar -o "$dir/no/c.png"
refused "two blades" "3 to 16" render $heliar -o "$dir/c.png" --blades 2
refused "an unknown model" "^flare: --model: 'paraxial', 'polynomial', 'traced' or 'reference' was expected, not 'exact'" render $heliar -o "$dir/c.png" --model exact
# budgets leave out weak ghosts, imperfections move them
budget="render $heliar --size 96x54 --angle 5,3 --ghosts-only"
"$flare" $budget -o "$dir/all.pfm" && "$flare" $budget -o "$dir/most.pfm" --budget 1000 --vertices 100000 --pixels 100000000 && "$flare" $budget -o "$dir/three.pfm" --budget 3 &&
    "$flare" $budget -o "$dir/few.pfm" --vertices 200 && "$flare" $budget -o "$dir/small.pfm" --pixels 9000 && "$flare" $budget -o "$dir/bad.pfm" --imperfection 0.01 --seed 3
cmp -s "$dir/all.pfm" "$dir/most.pfm" && ! cmp -s "$dir/all.pfm" "$dir/three.pfm" && ! cmp -s "$dir/all.pfm" "$dir/few.pfm" && ! cmp -s "$dir/all.pfm" "$dir/small.pfm" && ! cmp -s "$dir/all.pfm" "$dir/bad.pfm"
result $? "budgets that are large change nothing, small ones and imperfections do"
refused "a budget of nothing" '^flare: --budget: ' render $heliar -o "$dir/c.png" --budget 0
refused "a budget of half a ghost" 'whole number' render $heliar -o "$dir/c.png" --budget 2.5
refused "pixels below 1" '^flare: --pixels: ' render $heliar -o "$dir/c.png" --pixels -5
refused "vertices that are no number" '^flare: --vertices: ' render $heliar -o "$dir/c.png" --vertices many
refused "a broken lens" '^flare: --imperfection: ' render $heliar -o "$dir/c.png" --imperfection 0.5
refused "budgets of the reference" '^flare: --model reference draws every ghost' render $heliar -o "$dir/c.png" --model reference --budget 3
refused "33 wavelengths of traced ghosts" '^flare: --wavelengths: 33 is too many' render $heliar -o "$dir/c.png" --model traced --wavelengths 33
refused "wavelengths of undistorted ghosts" '^flare: --wavelengths belongs to' render $heliar -o "$dir/c.png" --model paraxial --wavelengths 8
"$flare" render $heliar -o "$dir/w.pfm" --size 64x36 --model traced --wavelengths 9 --ghosts-only --across-stop --four >"$dir/out" 2>"$dir/err"
result $? "nine wavelengths of traced ghosts, more paths too"
refused "two wavelengths" '^flare: --wavelengths: ' render $heliar -o "$dir/c.png" --model reference --wavelengths 2
refused "a share of a cell" 'whole number' render $heliar -o "$dir/c.png" --model reference --cells 20.5
refused "cells of the paraxial model" '^flare: --cells belongs to --model reference$' render $heliar -o "$dir/c.png" --cells 20
refused "the reference with GL" 'has no --backend gl' render $heliar -o "$dir/c.png" --model reference --backend gl
refused "a diagram of no kind" "\.svg was expected" diagram $heliar -o "$dir/c.png"
refused "a diagram that goes nowhere" "with -o OUT\.svg" diagram $heliar
refused "a diagram of no ghost" "3,4 is no ghost" diagram $heliar -o "$dir/c.svg" --ghost 3,4
refused "half a ray drawn" "^flare: --rays: a whole number" diagram $heliar -o "$dir/c.svg" --rays 2.5
refused "a diagram in a folder that is not there" "cannot be written" diagram $heliar -o "$dir/no/c.svg"
refused "an unknown backend" "'software' or 'gl'.*'vulkan'" render $heliar -o "$dir/c.png" --backend vulkan
GL_HOST=none
export GL_HOST
refused "no GL context" '^flare: --backend gl: GL_HOST is none of egl, gpu, osmesa$' render $heliar -o "$dir/c.png" --backend gl
unset GL_HOST
"$flare" render $heliar -o "$dir/small.pfm" --size 32x24
refused "pictures of two sizes" "one size" compare "$dir/a.pfm" "$dir/small.pfm"
# ---- edit and colour-map ----

"$flare" edit lenses/heliar-tronnier.lens -o "$dir/stop.lens" --stop-radius 0.5 >"$dir/out" && "$flare" info "$dir/stop.lens" | grep -qx 'fnumber   7' && grep -q '^edited    the stop is f/7, not f/3.5: ' "$dir/out" &&
    grep -q '^# edited: the stop is f/7, not f/3.5: ' "$dir/stop.lens"
result $? "edit --stop-radius"
"$flare" edit lenses/heliar-tronnier.lens -o "$dir/coated.lens" --coating 3=layer:1.7,150 --coating 1=bare --coating 4=quarter:444 >"$dir/out" && grep -qE '^580.38 .*coating stack 1.7:150' "$dir/coated.lens" &&
    grep -qE '^-80.63 .*coating quarter 444$' "$dir/coated.lens" && ! grep -E '^30.81' "$dir/coated.lens" | grep -q coating
result $? "edit --coating, three times"
"$flare" edit lenses/heliar-tronnier.lens -o "$dir/moved.lens" --move-stop 3,0.25 >"$dir/out" && "$flare" info "$dir/moved.lens" --json | grep -q '"stop": 4' && grep -q '^edited    7 ghosts stay, 6 are no more, 6 are new$' "$dir/out" &&
    [ "$("$flare" info "$dir/moved.lens" | grep -E '^(efl|bfd|fnumber)')" = "$("$flare" info lenses/heliar-tronnier.lens | grep -E '^(efl|bfd|fnumber)')" ]
result $? "edit --move-stop keeps focal length, focus and f-number"
"$flare" edit lenses/heliar-tronnier.lens -o "$dir/pupil.lens" --pupil 0.5 >"$dir/out" && grep -qE '^30.81 .*semi 8.5' "$dir/pupil.lens"
result $? "edit --pupil"
# the new lens's ghost, measured where the iris bounds it
"$flare" edit lenses/heliar-tronnier.lens -o "$dir/sized.lens" --ghost 4,2 --size 1.5 --surface 4 --angle 0,3 --fnumber 16 >"$dir/out" && grep -qE '^ +4 +2 .* 1\.500 \*$' "$dir/out" && [ "$(grep -cE '^ +[0-9]+ +[0-9]+ ' "$dir/out")" -ge 10 ]
result $? "edit --size has its table"
radius() { "$flare" ghosts "$1" --angle 0,3 --fnumber "$2" --csv | awk -F, '$1 == 4 && $2 == 2 {print $9}'; }
sed -nE 's/^ +4 +2 +[^ ]+ +[^ ]+ +([0-9.]+) +([0-9.]+) .*/\1 \2/p' "$dir/out" >"$dir/sizes"
read -r was is <"$dir/sizes"
near "$is" "1.5 * $was" 0.002 && near "$(radius lenses/heliar-tronnier.lens 16)" "$was" "0.02 * $was" &&
    [ "$(grep -E '^(-?[0-9.]+|stop|flat) ' "$dir/sized.lens" | awk '{print $1}' | tr '\n' ' ' | sed 's/-76\.736[0-9]* /X /')" = "30.81 -89.35 580.38 X 28.34 stop flat 32.19 -52.99 " ]
result $? "and the size that it says"
"$flare" colour-map lenses/heliar-tronnier.lens --ghost 4,2 -o "$dir/map.png" --angle 5,3 --target 1,0.3,0.1 >"$dir/out" && [ "$(head -c 4 "$dir/map.png" | od -An -c | tr -d ' ')" = '211PNG' ] &&
    grep -qE '^best      0\.71[0-9]+, 0\.2[0-9]+, 0\.0[67][0-9]+, off by 0\.0[0-9]+; ' "$dir/out"
result $? "colour-map writes its map and the best point"
# what it says to do does it
set -- $(sed -nE 's/.*-o OUT\.lens (.*)/\1/p' "$dir/out")
"$flare" edit lenses/heliar-tronnier.lens -o "$dir/hue.lens" "$@" >/dev/null && "$flare" colour-map "$dir/hue.lens" --ghost 4,2 -o "$dir/again.png" --angle 5,3 | sed -n 's/^now *//p' >"$dir/hue" &&
    [ "$(cat "$dir/hue")" = "$(sed -nE 's/^best *([^ ]+ [^ ]+ [0-9.]+), off.*/\1/p' "$dir/out")" ]
result $? "the coatings that it names give that hue"
"$flare" colour-map lenses/heliar-tronnier.lens --ghost 4,2 -o "$dir/plain.png" --angle 5,3 >/dev/null && ! cmp -s "$dir/plain.png" "$dir/map.png"
result $? "colour-map marks the best point"
edit() { what=$1 pattern=$2; shift 2; refused "$what" "$pattern" edit $heliar -o "$dir/c.lens" "$@"; }
edit "nothing to edit" 'say what is to change'
refused "an edit that goes nowhere" 'with -o OUT\.lens' edit $heliar --pupil 2
edit "a stop in glass" '^flare: --move-stop: behind row 1 is glass' --move-stop 1
edit "the stop behind itself" 'is the stop itself' --move-stop 6
edit "beyond the gap" 'from 0 to 1' --move-stop 3,1.5
edit "an opening that is none" 'f-number' --stop-radius 900
edit "a coated stop" 'row 6 is the stop' --coating 6=quarter:500
edit "a coating of no kind" 'ROW=quarter:NM.*3=gold' --coating 3=gold
edit "a coating of no row" 'from 1 to 9' --coating 30=bare
edit "no index" "layer's index from 1 to 10" --coating 3=layer:0.5,100
edit "a ghost across the stop" "'flare ghosts' lists them" --ghost 9,2 --size 2
edit "a ghost that cannot be so large" 'can be about .* times as large, not 900' --ghost 4,2 --size 900
edit "a surface that reflects it not" '4 or 2.*not 3' --ghost 4,2 --size 1.1 --surface 3
edit "a size of no ghost" 'with --ghost I,J' --size 2
edit "a ghost of no size" 'with --size FACTOR' --ghost 4,2
edit "an angle for nothing" 'belong to --size' --pupil 0.9 --angle 3,3
# ---- target ----
"$flare" target $heliar -o "$dir/t.target" --light 5,0 --light 10,0 --fnumber 8 --remove 9,7 --move 4,2=3 --scale 4,2=0.5 --colour 4,3=1,0.2,0 --weight 4,1=3 --add -4,1.5 >"$dir/out" &&
    grep -q ': 13 ghosts for 2 lights' "$dir/out" && "$flare" target $heliar -o "$dir/plain.target" --light 5,0 --light 10,0 --fnumber 8 >/dev/null &&
    diff "$dir/plain.target" "$dir/t.target" | grep -c '^>' | grep -qx 7 && grep -q '^ghost 4,3 color 1 0.2 0$' "$dir/t.target" && ! grep -q '^ghost 9,7' "$dir/t.target" &&
    tail -3 "$dir/t.target" | sed -n 2p | grep -q '^  spot -4 1.5$'
result $? "a target is a lens's spots, changed as asked for"
"$flare" target "$dir/t.target" -o "$dir/same.target" >/dev/null && cmp -s "$dir/t.target" "$dir/same.target"
result $? "a target so far is taken as it is"
refused "a ghost that the target has not" "has no ghost 9,7" target "$dir/t.target" -o "$dir/x.target" --move 9,7=1
refused "a change without a value" "I,J=VALUE was expected" target $heliar -o "$dir/x.target" --scale 4,2
refused "a target of nothing" "1 to 1024 ghosts" target $heliar -o "$dir/x.target" --remove all
refused "lights for what has some" "go with a lens" target "$dir/t.target" -o "$dir/x.target" --light 1,1
refused "a light that shows nothing" "none of the lights" target $heliar -o "$dir/x.target" --light 80,0
echo nothing >"$dir/x.target"
refused "a target that is none" "x.target:1:1: expected lensopt 1" target "$dir/x.target" -o "$dir/y.target"
refused "a target of another name" "ending in .target" target $heliar -o "$dir/x.txt"

# ---- optimize-colour ----
tronnier=lenses/heliar-tronnier.lens
"$flare" target $tronnier -o "$dir/own.target" --light 5,3 --fnumber 8 >/dev/null
"$flare" edit $tronnier -o "$dir/other.lens" --coating 1=quarter:400 --coating 3=bare --coating 4=quarter:700 --coating 5=quarter:333 --coating 7=layer:1.8,40 --coating 9=quarter:450 >/dev/null
optimize() { "$flare" optimize-colour "$@" 2>"$dir/err" >"$dir/out"; }
optimize "$dir/other.lens" "$dir/own.target" -o "$dir/found.lens" --fnumber 8 --threads 1 && [ ! -s "$dir/err" ] && grep -q '^search    the goal is reached, ' "$dir/out" &&
    [ "$(sed -nE 's/^ +([0-9]+)  quarter ([0-9.]+) .*/\1 \2/p' "$dir/out" | awk '{printf "%d %.0f, ", $1, $2}')" = "1 550, 3 520, 4 480, 5 600, 7 500, 9 580, " ] &&
    grep -qE '^ +3  quarter 5.* bare$' "$dir/out" && grep -qE '^ +7 .* layer 1.8, 40 nm$' "$dir/out" && grep -qE '^# row 3: quarter 5.*, was bare$' "$dir/found.lens"
result $? "optimize-colour finds the coatings of a lens again: $(sed -n 's/^search *the goal is reached, //p' "$dir/out")"
"$flare" target "$dir/found.lens" -o "$dir/found.target" --light 5,3 --fnumber 8 >/dev/null && paste -d' ' "$dir/own.target" "$dir/found.target" | awk '/^ghost/ {n++; for (i = 1; i <= 3; i++) if ($(3 + i) / $(9 + i) > 1.001 || $(3 + i) / $(9 + i) < 0.999) exit 1} END {exit n != 13}'
result $? "whose ghosts then have their colours"
"$flare" target "$dir/own.target" -o "$dir/red.target" --colour 4,2=1,0.3,0.1 --weight 4,2=20 >/dev/null
optimize $tronnier "$dir/red.target" -o "$dir/red.lens" --fnumber 8 --layers --evaluations 40000 --threads 1 --seed 2 &&
    [ "$(sed -nE 's/.*objective ([0-9.]+), was ([0-9.]+); 6 surfaces$/\1 \2/p' "$dir/out" | awk '{print ($1 < 0.5 * $2)}')" = 1 ] && grep -qE '^ +4 +2 +1 +20  0\.714 0\.214 0\.071  0\.7' "$dir/out"
result $? "optimize-colour --layers makes a ghost red: $(sed -n '1s/.*: //p' "$dir/out")"
optimize $tronnier "$dir/red.target" -o "$dir/red2.lens" --fnumber 8 --layers --evaluations 40000 --threads 2 --seed 2 && cmp -s "$dir/red.lens" "$dir/red2.lens" &&
    optimize $tronnier "$dir/red.target" -o "$dir/red3.lens" --fnumber 8 --layers --evaluations 40000 --seed 3 && ! cmp -s "$dir/red.lens" "$dir/red3.lens"
result $? "the same seed and evaluations, the same bytes with two threads; another seed, others"
"$flare" colour-map "$dir/red.lens" --ghost 4,2 -o "$dir/red.png" --angle 5,3 --fnumber 8 | sed -nE 's/^now +([0-9.]+), .*/\1/p' | awk '{exit !($1 > 0.69)}'
result $? "and colour-map finds it so"
sed '/^ghost 4,2 /!s/ color.*//; s/^ghost 4,2 .*/ghost 4,2 color 1 0.3 0.1 weight 2/' "$dir/red.target" >"$dir/one.target"
optimize "$dir/found.lens" "$dir/one.target" -o "$dir/one.lens" --cemented --by-spots --brightness 0.01 --time 0.1 --threads 1 --from-nothing && grep -q '; 8 surfaces$' "$dir/out" && grep -qE ' times$' "$dir/out" && [ "$(grep -cE ' +4 +2 +1 +2  ' "$dir/out")" = 1 ]
result $? "optimize-colour --cemented --by-spots --brightness --time --from-nothing"
"$flare" optimize-colour $tronnier "$dir/red.target" -o "$dir/best.lens" --time 60 --threads 1 >"$dir/out" 2>"$dir/err" &
pid=$!
sleep 0.4
kill -INT $pid
wait $pid
[ $? = 130 ] && grep -q '^flare: interrupted; .*best.lens has the best so far$' "$dir/err" && grep -q '^search    interrupted, ' "$dir/out" && "$flare" info "$dir/best.lens" >/dev/null && grep -q 'evaluations, interrupted$' "$dir/best.lens"
result $? "SIGINT ends it with the best so far: status 130"
wish() { what=$1 pattern=$2; shift 2; refused "$what" "$pattern" optimize-colour "$@" -o "$dir/c.lens"; }
wish "colours for no lens" 'nothing.lens: No such file' "$dir/nothing.lens" "$dir/own.target"
wish "colours of no target" 'nothing.target: No such file' $tronnier "$dir/nothing.target"
wish "colours of half a target" "one argument|two arguments" $tronnier
sed 's/^ghost 4,2 .*/ghost 4,2 color 1 -0.3/' "$dir/own.target" >"$dir/bad.target"
wish "a colour that is none" 'bad.target:[0-9]+:[0-9]+: ' $tronnier "$dir/bad.target"
sed 's/^\(ghost [0-9],[0-9]\).*/\1/' "$dir/own.target" >"$dir/grey.target"
wish "a target without colours" 'grey.target: no ghost of the target counts: ghosts with a color' $tronnier "$dir/grey.target"
{ cat "$dir/own.target" && for row in 1 3 4 5 7 9; do echo "lock $row coating"; done; } >"$dir/locked.target"
wish "a target that locks all" 'locked.target: no surface is free' $tronnier "$dir/locked.target"
wish "half an evaluation" 'whole number' $tronnier "$dir/own.target" --evaluations 1.5
refused "colours that go nowhere" 'with -o OUT\.lens' optimize-colour $tronnier "$dir/own.target"

refused "a map of no ghost" "9,2 is no ghost" colour-map $heliar --ghost 9,2 -o "$dir/c.png"
refused "a map without a ghost" "with --ghost I,J" colour-map $heliar -o "$dir/c.png"
refused "a map of no kind" "\.png was expected" colour-map $heliar --ghost 4,2 -o "$dir/c.pfm"
refused "black" "black is not" colour-map $heliar --ghost 4,2 -o "$dir/c.png" --target 0,0,0
refused "half a colour" "three numbers" colour-map $heliar --ghost 4,2 -o "$dir/c.png" --target 1,2
# ---- optimize ----
wish="$dir/wish.target" found="optimize $dir/wish.target --base lenses/heliar-tronnier.lens --fnumber 22"
"$flare" target lenses/heliar-tronnier.lens -o "$wish" --light 5,3 --fnumber 22 --move 4,2=3 --colour 3,2=0.2,0.4,1 >/dev/null &&
    "$flare" $found -o "$dir/best.lens" --evaluations 20000 --seed 1 --threads 1 --top 3 --picture "$dir/best.png" >"$dir/out" 2>"$dir/err" && [ ! -s "$dir/err" ] &&
    "$flare" info "$dir/best.lens" | grep -qx 'ghosts    13' && "$flare" info "$dir/best-2.lens" >/dev/null && [ "$(head -c 4 "$dir/best.png" | od -An -c | tr -d ' ')" = '211PNG' ] &&
    awk '/^objective seen / {found = $3 > 0 && $3 < 0.01} END {exit !found}' "$dir/out" && [ "$(grep -cE '^[0-9]+,[0-9]+ +-?[0-9]' "$dir/out")" = 13 ] &&
    grep -q "^# memetic: objective seen, [0-9.e-]*, [0-9]* evaluations, seed 1$" "$dir/best.lens"
result $? "optimize finds a lens for a target"
# what it says to do shows what it says: the ghost that was moved, where rims cut nothing
stop=$(sed -nE 's/^# iris .*render with --fnumber ([0-9.]+)$/\1/p' "$dir/best.lens")
"$flare" render "$dir/best.lens" -o "$dir/c.pfm" --size 64x36 --angle 5,3 --fnumber "$stop" --ghosts-only &&
    "$flare" target "$dir/best.lens" -o "$dir/got.target" --light 5,3 --fnumber "$stop" >/dev/null &&
    near "$(sed -n '/^ghost 4,2 /{n;p;}' "$dir/got.target" | awk '{print $2}')" "$(awk '$1 == "4,2" {print $3}' "$dir/out")" 0.002
result $? "and that lens shows the spots of its table"
"$flare" $found -o "$dir/two.lens" --evaluations 20000 --seed 1 --threads 2 --top 3 >/dev/null && cmp "$dir/best.lens" "$dir/two.lens" && cmp "$dir/best-2.lens" "$dir/two-2.lens" && cmp "$dir/best-3.lens" "$dir/two-3.lens"
result $? "optimize: the same bytes on one thread and two"
"$flare" $found -o "$dir/half.lens" --evaluations 10000 --seed 1 --checkpoint "$dir/half.search" >/dev/null && ! cmp -s "$dir/half.lens" "$dir/best.lens" &&
    "$flare" $found -o "$dir/whole.lens" --evaluations 20000 --seed 1 --resume "$dir/half.search" --top 3 >/dev/null && cmp "$dir/best.lens" "$dir/whole.lens" && cmp "$dir/best-3.lens" "$dir/whole-3.lens"
result $? "optimize --resume goes on as if unbroken"
"$flare" optimize "$wish" --scratch -o "$dir/new.lens" --algorithm jde --objective thesis --evaluations 20000 --edges 1 --efl 20,200 --threads 1 >"$dir/out" && "$flare" info "$dir/new.lens" >/dev/null &&
    grep -q '^# from scratch$' "$dir/new.lens" && grep -q '^objective thesis ' "$dir/out"
result $? "optimize --scratch"
"$flare" optimize "$wish" --scratch -o "$dir/listed.lens" --evaluations 20000 --glasses SCHOTT,OHARA >/dev/null && "$flare" info "$dir/listed.lens" >/dev/null &&
    awk -F, 'NR == FNR {if ($2 == "SCHOTT" || $2 == "OHARA") known[$1] = 1; next} {gsub(/#.*/, "")} / glass / {sub(/.* glass +/, ""); sub(/ .*/, ""); n++; if (!($0 in known)) wrong = 1} END {exit wrong || n == 0}' lenses/glasses.csv "$dir/listed.lens"
result $? "optimize --glasses takes those of the makers named"
"$flare" target lenses/planar-50-14.lens --light 8,5 --fnumber 22 -o "$dir/planar.target" >/dev/null && "$flare" optimize "$dir/planar.target" -o "$dir/planar.lens" --evaluations 20000 --threads 1 >"$dir/out" &&
    grep -q '^read      the spots are those of lenses of 6 surfaces in front of the stop and 7 behind it, EFL 49\.9[0-9] mm$' "$dir/out" && awk '/^objective/ && $3 < 0.01 { close_by = 1 } END { exit !close_by }' "$dir/out" &&
    "$flare" optimize "$dir/planar.target" -o "$dir/planar.lens" --evaluations 2000 --threads 1 --blind >"$dir/out" && ! grep -q '^read' "$dir/out"
result $? "optimize reads a lens from the spots, but blind"
"$flare" $found -o "$dir/cut.lens" --time 100 --threads 1 --goal 1e-300 >"$dir/out" 2>"$dir/err" &
searching=$!
sleep 1
kill -INT $searching
wait $searching
[ $? = 130 ] && grep -q 'interrupted; the best so far is in ' "$dir/err" && grep -q ': interrupted$' "$dir/out" && "$flare" info "$dir/cut.lens" >/dev/null
result $? "optimize: an interrupt writes the best so far, status 130"
wanted() { what=$1 pattern=$2; shift 2; refused "$what" "$pattern" optimize "$@"; }
wanted "a target that is not there" 'No such file' "$dir/none.target" -o "$dir/c.lens"
wanted "no target" 'needs a target' -o "$dir/c.lens"
printf 'lensopt 1\nsensor 36 24\nlight 5 0\nghost\n  spot 3 x\n' >"$dir/bad.target"
wanted "a malformed target" "^$dir/bad.target:5:10: " "$dir/bad.target" -o "$dir/c.lens"
wanted "a lens that goes nowhere" 'with -o BEST\.lens' "$wish"
wanted "a lens in a folder that is not there" '^flare: .*cannot be written' "$wish" -o "$dir/no/c.lens"
wanted "a checkpoint there" '^flare: .*cannot be written' "$wish" -o "$dir/c.lens" --checkpoint "$dir/no/c"
wanted "a range the wrong way round" '^flare: --efl: .*90 is more than 80' "$wish" -o "$dir/c.lens" --efl 90,80
wanted "ranges that exclude each other" 'no lens has a back focus' "$wish" -o "$dir/c.lens" --back-focus 90,95 --length 20,50
wanted "none of the best" '^flare: --top: ' "$wish" -o "$dir/c.lens" --top 0
wanted "an algorithm of no name" "'memetic', 'de', 'jde' or 'pso' was expected, not 'luck'" "$wish" -o "$dir/c.lens" --algorithm luck
wanted "a lens and none" 'not both' "$wish" -o "$dir/c.lens" --base lenses/heliar-tronnier.lens --scratch
wanted "order of nothing" 'belong to --base' "$wish" -o "$dir/c.lens" --keep-order
wanted "glass of nobody" "all.* or makers of the catalogue .*OHARA.* were expected, not 'SCHOTT,NOBODY'" "$wish" -o "$dir/c.lens" --glasses SCHOTT,NOBODY
wanted "half an evaluation" 'whole number' "$wish" -o "$dir/c.lens" --evaluations 2.5
wanted "to go on from another search" 'checkpoint is of another search' "$wish" -o "$dir/c.lens" --resume "$dir/half.search"
wanted "to go on from no search" 'is no checkpoint' "$wish" -o "$dir/c.lens" --resume "$wish"
if [ -w /dev/full ]; then wanted "a checkpoint on a full disk" 'No space left' "$wish" -o "$dir/c.lens" --checkpoint /dev/full; fi
[ ! -e "$dir/c.png" ] && [ ! -e "$dir/c.svg" ] && [ ! -e "$dir/c.fit" ] && [ ! -e "$dir/c.lens" ] && [ -z "$(find "$dir" -name '*.part')" ]
result $? "what is refused leaves no file"
if [ -w /dev/full ]; then
    "$flare" ghosts $heliar --csv >/dev/full 2>"$dir/err"
    [ $? = 2 ] && grep -q 'cannot be written' "$dir/err"
    result $? "a full disk is noticed"
fi
build/00_null $heliar | grep -q 'one frame: 1 lights, 13 instances of 8 bytes'
result $? "00_null runs"
build/02_own_renderer lenses/planar-50-14.lens >/dev/null && build/02_own_renderer lenses/nikon-80-200-mid.lens >/dev/null
result $? "02_own_renderer draws what lflare_render draws"
echo "1..$n"
