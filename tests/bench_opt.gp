# make bench-opt-plot: best value over time of every run that build/bench_opt_*.csv holds (make bench-opt), into build/bench_opt.png.
# In Gnuplot's own language; a value below a plot's lower end counts as exact. blind: without lenses read from the spots.
set terminal pngcairo size 1650,560 font "Sans,10"
set output "build/bench_opt.png"
set datafile separator ","
set logscale xy
set format y "10^{%L}"
set grid lc rgb "#dddddd"
set key bottom left Left reverse samplen 2 opaque
set xlabel "seconds on two cores"
set ylabel "mean squared difference of spots paired by size (THESIS), mm^2"

# What begins at the foot of the plot is to be seen, too: a line down to it.
from_above(f) = sprintf("< awk -F, 'NR == 2 { print $1 \",1e4\" } NR > 1' %s", f)
runs(task, method) = system("ls build/bench_opt_" . task . "_" . method . "_[0-9]*.csv 2>/dev/null")

array tasks[3] = ["heliar-13.40", "heliar-5.45", "canon-5.45"]
array titles[3] = ["Heliar, 13.40 degrees: 13 spots", "Heliar, 5.45 degrees: 13 spots", "Canon 28-80, 5.45 degrees: 171 spots"]
array ours[3] = ["memetic", "memetic", "ranked"] # the memetic search for the objective that comes lowest
array longest[3] = [60, 60, 600]
lowest = 1e-12

set multiplot layout 1,3
do for [k = 1:3] {
    set title titles[k]
    set xrange [0.03:longest[k]]
    set yrange [lowest:1e4]
    curve(f) = f > lowest ? f : lowest
    plot for [f in runs(tasks[k], "pso")] f skip 1 using 1:(curve($2)) with steps lc rgb "#f08000" notitle, \
        for [f in runs(tasks[k], "jde")] f skip 1 using 1:(curve($2)) with steps lc rgb "#a09000" notitle, \
        for [f in runs(tasks[k], "pagmo-pso")] f skip 1 using 1:(curve($2)) with steps lc rgb "#d02020" notitle, \
        for [f in runs(tasks[k], "pagmo-sade")] f skip 1 using 1:(curve($2)) with steps lc rgb "#e060a0" notitle, \
        for [f in runs(tasks[k], ours[k]."-blind")] f skip 1 using 1:(curve($2)) with steps lc rgb "#60c0a0" notitle, \
        for [f in runs(tasks[k], ours[k])] from_above(f) using 1:(curve($2)) with steps lc rgb "#0000a0" lw 1.5 notitle, \
        keyentry with lines lc rgb "#0000a0" lw 2 title "memetic", keyentry with lines lc rgb "#60c0a0" title "memetic, blind", keyentry with lines lc rgb "#f08000" title "PSO", \
        keyentry with lines lc rgb "#a09000" title "jDE", keyentry with lines lc rgb "#d02020" title "pagmo: PSO", \
        keyentry with lines lc rgb "#e060a0" title "pagmo: SADE"
}
unset multiplot
