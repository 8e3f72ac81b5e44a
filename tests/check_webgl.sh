#!/bin/sh
# WebGL 2: the calls of a few frames, written down by webgl_record.c, are made again in a headless Chromium: shaders compile and
# link under ANGLE, nothing gives an error, the pictures are the software renderer's. TAP; skipped where Chromium is missing.
set -u
cd "$(dirname "$0")/.." || exit 2
dir=$(pwd)/build/webgl
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
if [ -z "$browser" ]; then
    echo "ok 1 # SKIP no Chromium is here: WebGL 2 is not tried (apt-get install chromium)"
    echo "1..1"
    exit 0
fi
rm -rf "$dir" && mkdir -p "$dir"
warn="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Wstrict-prototypes -Werror"
if ! { ${CC:-cc} -std=c99 $warn -I. -O2 tests/webgl_record.c -o "$dir/record" -lm && "$dir/record" >"$dir/calls.js"; } 2>"$dir/log"; then
    echo "not ok 1 - the calls are written down"
    sed 's/^/# /' "$dir/log"
    echo "1..1"
    exit 1
fi
cp tests/webgl.html "$dir"
sandbox=
[ "$(id -u)" = 0 ] && sandbox=--no-sandbox
timeout 300 "$browser" --headless $sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-component-update \
    --disable-sync --use-angle=swiftshader --enable-unsafe-swiftshader --user-data-dir="$dir/profile" --dump-dom "file://$dir/webgl.html" >"$dir/dom" 2>"$dir/log"
sed -n '/<pre id="tap">/,/<\/pre>/p' "$dir/dom" | sed 's/.*<pre id="tap">//; s/<\/pre>.*//; s/&lt;/</g; s/&gt;/>/g; s/&amp;/\&/g' |
    grep -E '^(ok|not ok|1\.\.|#)' >"$dir/tap"
cat "$dir/tap"
rm -rf "$dir/profile"
if ! grep -q '^1\.\.' "$dir/tap"; then
    n=$(grep -cE '^(not )?ok' "$dir/tap")
    echo "not ok $((n + 1)) - the browser did not finish the page"
    head -5 "$dir/log" | sed 's/^/# /'
    echo "1..$((n + 1))"
fi
