# make         the command-line tool and the examples, in build/
# make demo    renders the flare of a real lens to a PNG and says where it is (a C compiler and make are enough)
# make test    everything that is checked; installs what it needs when run as root, else says what to install
# make bench   speed, as ratios side by side in one run
# make bench-opt  the optimiser, beside pagmo 2 (libpagmo-dev): PART=functions, rate, heliar, canon, scratch or constrained for one part, ARGS='time=5 seeds=2'
#                 for less of it (tests/bench_opt.cpp has more); seven hours for all on two cores, functions two minutes, rate 15 s;
#                 make bench-opt-plot draws its curves, build/bench_opt.png
# make models  how near each model of the ghosts comes to exact rays, on six lenses; the first run takes half an hour
# make fringes draws irises as ghosts show them beside the exact integral, build/fringes.pgm; needs FFTW (libfftw3-dev)
# make shaders writes shaders_embedded/*.glsl into lensflare.h
# make glasses writes lenses/glasses*.csv into lenses/lensimport.h
# make diagrams draws the lenses and their page, lenses/README.md
# make flares  renders the small pictures on that page; needs ImageMagick
# make fits    fits the lenses whose fits are small enough to lie beside them
# make fuzz    thirty minutes of fuzzing (SECONDS=n for less); make coverage shows what it reached
# make fuzz-import fuzzes each reader of foreign formats for twenty minutes (SECONDS=n), and shows what that reached

CC      ?= cc
CFLAGS  ?= -O2
CXX     ?= c++
WARN    := -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Wstrict-prototypes
ALL     := -std=c99 $(WARN) -I. $(CFLAGS)
B       := build

# PNG files written by others can be compared where libpng is there; nothing else needs a package.
PNG     := $(shell printf '\043include <png.h>\n' | $(CC) -E - >/dev/null 2>&1 && echo yes)
ifeq ($(PNG),yes)
FLAREPNG := -DFLARE_HAVE_PNG
LIBPNG   := -lpng
endif

EXAMPLES := $(B)/00_null $(B)/02_own_renderer
# GL is loaded at run time, for which older C libraries keep dlopen apart. Examples with a window need GLFW.
LIBDL    := $(if $(findstring linux,$(shell $(CC) -dumpmachine 2>/dev/null)),-ldl)
THREADS  := $(if $(findstring mingw,$(shell $(CC) -dumpmachine 2>/dev/null)),,-lpthread)
LIBGLFW  ?= -lglfw
GLFW     := $(shell printf '\043include <GLFW/glfw3.h>\n' | $(CC) -DGLFW_INCLUDE_NONE -E - >/dev/null 2>&1 && echo yes)
WINDOWS  := $(B)/01_one_flare $(B)/03_hdr_occlusion
# GL is tested where EGL's and GL's headers are there.
EGL      := $(shell printf '\043include <EGL/egl.h>\n\043include <GL/glext.h>\n' | $(CC) -E - >/dev/null 2>&1 && echo yes)
TESTS    := $(patsubst tests/%.c,$(B)/%,$(if $(EGL),$(wildcard tests/test_*.c),$(filter-out tests/test_gl.c,$(wildcard tests/test_*.c))))

all: $(B)/flare $(EXAMPLES) $(if $(GLFW),$(WINDOWS),no-windows)

$(B)/flare: examples/flare.c examples/gl_host.h examples/reference.h examples/diagram.h examples/import.h examples/edit.h examples/optimize.h examples/coatings.h lenses/lensimport.h lensopt.h lensflare.h | $(B)
	$(CC) $(ALL) $(FLAREPNG) $< -o $@ $(LIBPNG) $(LIBDL) $(THREADS) -lm

$(WINDOWS): $(B)/%: examples/%.c examples/gl_host.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ $(LIBGLFW) $(LIBDL) -lm

no-windows:
	@echo "$(notdir $(WINDOWS)) are left out: they need GLFW (Debian: libglfw3-dev)"

$(B)/%: examples/%.c lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lm

# The implementations by themselves, for the tests that call nothing but what the headers declare: compiling them takes longer than
# all of such a test, so it is done once. The guard on the command line leaves them out of the test, whose text says where they
# belong when it is compiled alone (tests/check_matrix.sh).
$(B)/lensflare.o: lensflare.h | $(B)
	printf '\043define LENSFLARE_IMPLEMENTATION\n\043include "lensflare.h"\n' | $(CC) $(ALL) -x c -c - -o $@

$(B)/lensopt.o: lensopt.h lensflare.h | $(B)
	printf '\043define LENSOPT_IMPLEMENTATION\n\043include "lensopt.h"\n' | $(CC) $(ALL) -x c -c - -o $@

$(B)/test_%: tests/test_%.c $(B)/lensflare.o $(wildcard tests/*.h) | $(B)
	$(CC) $(ALL) -DLENSFLARE_IMPLEMENTED $< $(B)/lensflare.o -o $@ -lcmocka -lm

$(B)/test_reference: tests/test_reference.c tests/oracle.h examples/reference.h $(B)/lensflare.o | $(B)
	$(CC) $(ALL) -DLENSFLARE_IMPLEMENTED $< $(B)/lensflare.o -o $@ -lcmocka $(THREADS) -lm

$(B)/test_import: tests/test_import.c lenses/lensimport.h $(B)/lensflare.o | $(B)
	$(CC) $(ALL) -DLENSFLARE_IMPLEMENTED $< $(B)/lensflare.o -o $@ -lcmocka -lm

$(B)/test_spots $(B)/test_coatings: $(B)/test_%: tests/test_%.c lensopt.h $(B)/lensflare.o | $(B)
	$(CC) $(ALL) -DLENSFLARE_IMPLEMENTED $< $(B)/lensflare.o -o $@ -lcmocka $(THREADS) -lm

$(B)/test_edit $(B)/test_target $(B)/test_problem: $(B)/test_%: tests/test_%.c $(B)/lensopt.o $(B)/lensflare.o | $(B)
	$(CC) $(ALL) -DLENSFLARE_IMPLEMENTED -DLENSOPT_IMPLEMENTED $< $(B)/lensopt.o $(B)/lensflare.o -o $@ -lcmocka $(THREADS) -lm

# These look inside, or choose what is compiled.
$(B)/test_aberration $(B)/test_traced $(B)/test_paths: $(B)/test_%: tests/test_%.c tests/oracle.h examples/reference.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lcmocka $(THREADS) -lm

$(B)/test_search: tests/test_search.c lensopt.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lcmocka $(THREADS) -lm

$(B)/test_diffraction: tests/test_diffraction.c tests/fresnel.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lcmocka -lfftw3 -lm

$(B)/test_gl: tests/test_gl.c examples/gl_host.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lcmocka -lEGL -lGL -lm

$(B)/bench: tests/bench.c tests/bench.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lm

# pagmo's headers are C++17 and full of warnings
$(B)/bench_opt: tests/bench_opt.cpp lensopt.h lensflare.h | $(B)
	@printf '\043include <pagmo/config.hpp>\n' | $(CXX) -x c++ -E - >/dev/null 2>&1 || { echo "bench-opt compares with pagmo 2 (Debian: libpagmo-dev), which is not here" >&2; exit 2; }
	$(CXX) -std=c++17 -Wall -Wextra -I. $(CFLAGS) $< -o $@ -lpagmo $(THREADS) -lm

$(B)/models: tests/models.c examples/reference.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ $(THREADS) -lm

$(B)/fringes: tests/fringes.c tests/fresnel.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lfftw3 -lm

$(B)/bench_gl: tests/bench_gl.c tests/bench.h examples/gl_host.h lensflare.h | $(B)
	$(CC) $(ALL) $< -o $@ -lEGL -lGL -lm

$(B):
	mkdir -p $@

demo: $(B)/flare
	$(B)/flare render lenses/nikon-80-200-mid.lens -o $(B)/demo.png --angle 5,3 --fnumber 5.6 --radius 4.65
	@echo "The flare of a Nikon 80-200 mm zoom is in $(CURDIR)/$(B)/demo.png"

test:
	@tests/run

tests: $(TESTS)

bench: $(B)/bench $(if $(EGL),$(B)/bench_gl)
	$(B)/bench
	@$(if $(EGL),$(B)/bench_gl,echo "gl: no EGL and GL headers here (libegl-dev libgl-dev), so it is not measured")

bench-opt: $(B)/bench_opt
	$(B)/bench_opt $(or $(PART),all) $(ARGS)

# and of the pictures that pictures=1 writes some above each other
PAIRS = $(wildcard $(addprefix $(B)/bench_opt_,heliar-13.40_memetic_1.pgm canon-5.45_seen_1.pgm scratch-5_seen_1.pgm scratch-10_seen_1.pgm scratch-15_seen_1.pgm))
bench-opt-plot:
	@command -v gnuplot >/dev/null || { echo "bench-opt-plot draws with gnuplot (Debian: gnuplot-nox), which is not here" >&2; exit 2; }
	gnuplot tests/bench_opt.gp
	$(if $(PAIRS),convert $(PAIRS) -resize 1280x -bordercolor black -border 0x2 -append -quality 88 $(B)/bench_opt.jpg)

models: $(B)/models
	$(B)/models

fringes: $(B)/fringes
	$(B)/fringes

# The GLSL sources as string literals in the header; a test compares both.
shaders:
	shaders_embedded/embed.sh lensflare.h > lensflare.h.new && mv lensflare.h.new lensflare.h

# The glass catalogue as tables in the header; a test compares both.
glasses:
	lenses/glasses.sh lenses/lensimport.h > lenses/lensimport.h.new && mv lenses/lensimport.h.new lenses/lensimport.h

# Cross-sections of all lenses; a test compares them.
diagrams: $(B)/flare
	lenses/diagrams/gallery.sh

# Their flares, in seconds.
flares: $(B)/flare
	lenses/flares/flares.sh

# Under 100 KB each; `flare fit` makes the others in seconds.
fits: $(B)/flare
	for lens in cooke-triplet-27 heliar-tronnier petzval-kodak topogon; do $(B)/flare fit lenses/$$lens.lens -o lenses/$$lens.fit || exit; done

fuzz:
	tests/fuzz.sh $(or $(SECONDS),1800)

fuzz-import:
	tests/fuzz_import.sh $(or $(SECONDS),1200)

coverage:
	tests/coverage.sh

clean:
	rm -rf $(B)

.PHONY: all no-windows demo test tests bench bench-opt bench-opt-plot models fringes shaders glasses diagrams flares fits fuzz fuzz-import coverage clean
