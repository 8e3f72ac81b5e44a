#!/bin/sh
# embed.sh HEADER: prints the header with the block between its "shaders begin" and "shaders end" lines made anew from the
# GLSL files beside this script. Comments and leading blanks are left out; literals stay far below C99's 4,095 bytes.
set -eu
here=$(dirname "$0")
literal() { # NAME FILE
    printf 'static const char *const lflare__glsl_%s[] = {\n' "$1"
    awk '{
        line = $0
        while (comment || (start = index(line, "/*"))) {
            if (!comment) { head = substr(line, 1, start - 1); line = substr(line, start + 2); comment = 1 }
            stop = index(line, "*/")
            if (!stop) { line = head; head = ""; if (line ~ /^[ \t]*$/) line = ""; skip = 1; break }
            line = head substr(line, stop + 2); head = ""; comment = 0
        }
        sub(/^[ \t]+/, "", line); sub(/[ \t]+$/, "", line)
        if (line == "") next
        gsub(/\\/, "\\\\", line); gsub(/"/, "\\\"", line)
        if (size + length(line) > 3000) { print "    ,"; size = 0 }
        size += length(line) + 1
        printf "    \"%s\\n\"\n", line
    }' "$2"
    printf '    , NULL};\n'
}
awk '{ print } /shaders begin/ { exit }' "$1"
for file in "$here"/*.glsl; do
    name=$(basename "$file" .glsl | tr . _)
    literal "$name" "$file"
done
awk '/shaders end/ { on = 1 } on { print }' "$1"
