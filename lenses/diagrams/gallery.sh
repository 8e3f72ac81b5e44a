#!/bin/sh
# A diagram of every lens, and lenses/README.md, the page that shows them: `make diagrams`. From the root, once build/flare is there.
set -eu
flare=build/flare out=lenses/diagrams page=lenses/README.md
LC_ALL=C
export LC_ALL
field() { sed -nE "s/.*\"$2\": (\"([^\"]*)\"|([^\",]*)),.*/\2\3/p" "$1"; } # FILE KEY of `flare info --json`
info=$(mktemp)
trap 'rm -f "$info"' EXIT
{
    echo '# The lenses'
    echo
    echo 'Prescriptions from patents, each with its sources in the first lines of its file. Every drawing has a scale of its own: glass in'
    echo 'blue, the stop as two bars, the sensor on the right, five exact rays of a light on the axis in green. `make'
    echo 'diagrams` draws this page; `flare diagram LENS -o OUT.svg` draws a lens of your own, and with `--ghost I,J` how a ghost comes'
    echo 'about: here two reflections, at surfaces 4 and 2, of light 5 degrees off the axis.'
    echo
    "$flare" diagram lenses/heliar-tronnier.lens --ghost 4,2 --angle 0,5 -o $out/ghost.svg
    echo '![A ghost of the Heliar: rays reflected at its surfaces 4 and 2](diagrams/ghost.svg)'
    echo
    echo '| lens | patent | focal length | f-number | ghosts |'
    echo '| --- | --- | --- | --- | --- |'
    for lens in lenses/*.lens; do
        "$flare" info "$lens" --json >"$info"
        id=$(basename "$lens" .lens)
        printf '| [%s](%s.lens) | %s | %.4g mm | %.3g | %s |\n' "$(field "$info" name)" "$id" "$(field "$info" patent)" "$(field "$info" efl_mm)" \
            "$(field "$info" fnumber)" "$(field "$info" ghosts)"
    done
    for lens in lenses/*.lens; do
        "$flare" info "$lens" --json >"$info"
        id=$(basename "$lens" .lens) name=$(field "$info" name)
        "$flare" diagram "$lens" -o "$out/$id.svg"
        printf '\n## %s\n\n![%s in cross-section](diagrams/%s.svg)\n' "$name" "$name" "$id"
    done
} >"$page.new"
mv "$page.new" "$page"
