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
# (4,2): u = -(tan 10, tan 5), M12 = 140.265: the pupil's image lies left and below on the sensor
awk -F, '$1 == 4 && $2 == 2 {found = ($10 + 24.7326 < 0.001 && $10 + 24.7326 > -0.001 && $11 < 0)} END {exit !found}' "$dir/ghosts.csv"
result $? "ghosts prints sensor coordinates with their sign"

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
"$flare" --version | grep -q '^flare [0-9]' && "$flare" --help | grep -q 'flare render' && "$flare" render --help | grep -q 'flare render'
result $? "--version and --help"

printf 'lensflare 1\nfnumber 2\n50 3 n 1.5\n-50 x\n' >"$dir/bad.lens"
refused "an unreadable lens says FILE:LINE:COLUMN" "^$dir/bad.lens:4:5: " info "$dir/bad.lens"
refused "a missing file" 'No such file' info "$dir/none.lens"
refused "a directory" . info "$dir"
refused "an unknown command" "unknown command 'draw'" draw
refused "an unknown option" "unknown option '--sice'" render $heliar -o "$dir/c.png" --sice 3x3
refused "a bad number" "^flare: --fnumber: .*'fast'" render $heliar -o "$dir/c.png" --fnumber fast
refused "a missing value" "a value is missing" render $heliar -o
refused "no output named" "with -o" render $heliar
refused "an unknown picture format" "\.png or \.pfm" render $heliar -o "$dir/c.jpg"
refused "a folder that is not there" "cannot be written" render $heliar -o "$dir/no/c.png"
refused "two blades" "3 to 16" render $heliar -o "$dir/c.png" --blades 2
refused "a model of a later version" "paraxial" render $heliar -o "$dir/c.png" --model traced
refused "an unknown backend" "'software' or 'gl'.*'vulkan'" render $heliar -o "$dir/c.png" --backend vulkan
GL_HOST=none
export GL_HOST
refused "no GL context" '^flare: --backend gl: GL_HOST is neither egl nor osmesa$' render $heliar -o "$dir/c.png" --backend gl
unset GL_HOST
"$flare" render $heliar -o "$dir/small.pfm" --size 32x24
refused "pictures of two sizes" "one size" compare "$dir/a.pfm" "$dir/small.pfm"
[ ! -e "$dir/c.png" ] && [ -z "$(find "$dir" -name '*.part')" ]
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
