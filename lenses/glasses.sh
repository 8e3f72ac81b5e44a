#!/bin/sh
# glasses.sh HEADER: prints the header with the block between its "glasses begin" and "glasses end" lines made anew from the
# tables beside this script: glasses.csv (makers' Sellmeier coefficients) and glasses_listed.csv (nd and, where known, Vd of what
# is obsolete or of other makers). What is listed but has its own coefficients, or a successor named N-... within 5e-4, is left out.
set -eu
here=$(dirname "$0")
awk '{ print } /glasses begin/ { exit }' "$1"
awk -F, '
function plain(name) { name = toupper(name); gsub(/[^A-Z0-9]/, "", name); return name }
function number(v) { return (v ~ /[.eE]/ ? v : v ".0") "f" }
FNR == 1 { file++ }
FNR == 1 || /^#/ || /^name,/ { next }
file == 1 {
    if (length($1) > 14) { print "glasses.sh: the name " $1 " is too long" >"/dev/stderr"; exit 1 }
    if ($2 != maker) { makers = makers (makers == "" ? "" : ", ") "\"" $2 "\""; maker = $2; count++ }
    known[plain($1)] = $3
    rows[++n] = sprintf("    {\"%s\", %d, {%s, %s, %s, %s, %s, %s}},", $1, count - 1, number($5), number($6), number($7), number($8), number($9), number($10))
    next
}
{
    key = plain($1)
    if (key in known || (("N" key) in known && ($2 - known["N" key]) ^ 2 < 2.5e-7) || key in listed) next
    listed[key] = 1
    lines[++m] = sprintf("    {\"%s\", %d, %d},", $1, $3 * 100 + 0.5, $2 * 100000 + 0.5)
}
END {
    print "static const char lensimport__makers[][8] = {" makers "};"
    print "static const lensimport__glass lensimport__glasses[] = {"
    for (i = 1; i <= n; i++) print rows[i]
    print "};"
    print "static const lensimport__listed lensimport__list[] = {"
    for (i = 1; i <= m; i++) print lines[i]
    print "};"
}' "$here/glasses.csv" "$here/glasses_listed.csv"
awk '/glasses end/ { on = 1 } on { print }' "$1"
