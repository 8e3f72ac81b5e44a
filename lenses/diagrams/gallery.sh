#!/bin/sh
# A diagram of every lens, and lenses/README.md, the page that shows them and their flares: `make diagrams`. From the root, once
# build/flare is there. The pictures of the flares are those of flares.sh.
set -eu
flare=build/flare out=lenses/diagrams page=lenses/README.md
LC_ALL=C
export LC_ALL
field() { sed -nE "s/.*\"$2\": (\"([^\"]*)\"|([^\",]*)),.*/\2\3/p" "$1"; } # FILE KEY of `flare info --json`
elements() { sed 's/#.*//' "$1" | grep -cE '^ *(-?[0-9.]+|flat) .* (nd?|sellmeier|cauchy) '; }
year() { sed '/^# Figures/,$d' "$1" | tr '\n' ' ' | grep -oE '(, |the |it |of )(18|19|20)[0-9][0-9]s?' | head -n 1 | grep -oE '[0-9]+s?$'; } # of what the first lines cite
info=$(mktemp)
trap 'rm -f "$info"' EXIT
{
    echo '# The lenses'
    echo
    echo "$(ls lenses/*.lens | wc -l) prescriptions from patents and textbooks, each with its sources in the first lines of its file, which also say where clear"
    echo 'diameters are a transcription'\''s or derived, and why the coatings are as they are: none before about 1940, one layer from then'
    echo 'on, several from the seventies. Patents are silent about coatings.'
    echo
    echo 'Every drawing has a scale of its own: glass in blue, the stop as two bars, the sensor on the right, five exact rays of a'
    echo 'light on the axis in green. Every flare is that of the sun, at half of the frame'\''s width and a third of its height from the'
    echo 'middle, at f/5.6 or wide open, with seven blades, in the quick model. `make diagrams` draws this page, `make flares` its'
    echo 'pictures; `flare diagram LENS -o OUT.svg` draws a lens of your own, and with `--ghost I,J` how a ghost comes about: here two'
    echo 'reflections, at surfaces 4 and 2, of light 5 degrees off the axis.'
    echo
    "$flare" diagram lenses/heliar-tronnier.lens --ghost 4,2 --angle 0,5 -o $out/ghost.svg
    echo '![A ghost of the Heliar: rays reflected at its surfaces 4 and 2](diagrams/ghost.svg)'
    echo
    echo '| lens | patent | year | focal length | f-number | elements | ghosts | cross-section | flare |'
    echo '| --- | --- | --- | --- | --- | --- | --- | --- | --- |'
    for lens in lenses/*.lens; do
        "$flare" info "$lens" --json >"$info"
        id=$(basename "$lens" .lens) name=$(field "$info" name)
        "$flare" diagram "$lens" -o "$out/$id.svg"
        printf '| [%s](%s.lens) | %s | %s | %.4g mm | %.3g | %s | %s ' "$name" "$id" "$(field "$info" patent)" "$(year "$lens")" \
            "$(field "$info" efl_mm)" "$(field "$info" fnumber)" "$(elements "$lens")" "$(field "$info" ghosts)"
        printf '| [<img src="diagrams/%s.svg" width="260" alt="%s in cross-section">](diagrams/%s.svg) ' "$id" "$name" "$id"
        printf '| <img src="flares/%s.jpg" width="240" alt="flare of the %s"> |\n' "$id" "$name"
    done
} >"$page.new"
mv "$page.new" "$page"
