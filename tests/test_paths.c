/* Ghosts across the stop and of four reflections: which they are, their matrices and rays against the tests' own physics (oracle.h),
   their ranking against all candidates, their clipping against dense rays, fits, overrides, pictures against exact rays.
   Runs from the repository's root. */

#define _POSIX_C_SOURCE 200809L
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "oracle.h"
#include "../examples/reference.h"

#define PI 3.14159265358979323846
#define HELIAR "lenses/heliar-tronnier.lens"
#define TESSAR "lenses/tessar-50-35.lens"
#define NIKON "lenses/nikon-80-200-mid.lens"

static lflare_lens lens; /* too large for the stack */

static void load(const char *path, int across, int four)
{
    lflare_paths paths;
    lflare_error error;
    paths.across_stop = across;
    paths.four = four;
    if (!oracle_lens_load(path, &lens)) fail_msg("%s does not load", path);
    if (lflare_lens_paths(&lens, &paths, &error) != LFLARE_OK) fail_msg("%s", error.text);
}

static lflare_pair *list_ghosts(int32_t *count)
{
    lflare_pair *pairs = (lflare_pair *)calloc((size_t)lens.ghost_count + 1, sizeof *pairs);
    assert_non_null(pairs);
    *count = lens.ghost_count;
    assert_int_equal(lflare_ghost_list(&lens, pairs, count), LFLARE_OK);
    assert_int_equal(*count, lens.ghost_count);
    return pairs;
}

static int steps_of(const oracle_lens *o, lflare_pair p, oracle_step *steps)
{
    int turns[4];
    turns[0] = p.first;
    turns[1] = p.second;
    turns[2] = p.third;
    turns[3] = p.fourth;
    return oracle_path_of(o, turns, p.third > 0 ? 4 : 2, steps);
}

static int crossings_of_stop(const oracle_step *steps, int n, int stop)
{
    int i, count = 0;
    for (i = 0; i < n; i++) count += steps[i].surface == stop;
    return count;
}

/* ---- which ---- */

enum { MOST = 40000 };

typedef struct candidate {
    lflare_pair pair;
    float flux;
} candidate;

static candidate all[MOST];

/* The documented measure, from public functions alone. */
static float flux_of(lflare_pair pair)
{
    double iris = fabs(lens.stop_a11) * lens.efl / (2 * fmax(8, lens.fnumber)), frame = lens.sensor_width * lens.sensor_height;
    lflare_ghost_matrices m;
    lflare_region region;
    assert_int_equal(lflare_ghost_optics(&lens, 510, &pair, 1, &m), LFLARE_OK);
    lflare_ghost_clip(&lens, 510, pair, iris, 0, &region);
    return (float)(lflare_ghost_weight(&lens, 510, pair, 0, 0) * region.area / fmax(frame, region.area * m.m.a * m.m.a));
}

static int steps_at(int i) { return i != lens.stop && lflare__reflects(&lens.prescription, i); }

static int by_flux(const void *a, const void *b)
{
    float x = ((const candidate *)a)->flux, y = ((const candidate *)b)->flux;
    return (x < y) - (x > y);
}

/* All paths of four reflections, four nested loops; the strongest first. */
static int all_of_four(int across)
{
    int n = 0, i, j, k, l, last = lens.surface_count - 1;
    for (i = 1; i <= last; i++)
        for (j = 0; j < i; j++)
            for (k = j + 1; k <= last; k++)
                for (l = 0; l < k; l++) {
                    int front = j < l ? j : l, back = i > k ? i : k;
                    candidate *c = &all[n];
                    if (!steps_at(i) || !steps_at(j) || !steps_at(k) || !steps_at(l) || (!across && front < lens.stop && back > lens.stop)) continue;
                    c->pair.first = i;
                    c->pair.second = j;
                    c->pair.third = k;
                    c->pair.fourth = l;
                    c->flux = flux_of(c->pair);
                    assert_true(n < MOST);
                    n += c->flux > 0;
                }
    qsort(all, (size_t)n, sizeof *all, by_flux);
    return n;
}

static int same(const lflare_pair *a, const lflare_pair *b) { return memcmp(a, b, sizeof *a) == 0; }

static void counts(void **state)
{
    lflare_pair *plain, *pairs;
    int32_t plain_count, count, i;
    int across, reflecting[2] = {0, 0}, pairs_all, n;
    (void)state;
    load(HELIAR, 0, 0);
    plain = list_ghosts(&plain_count);
    assert_int_equal(plain_count, 13);
    for (i = 0; i < lens.surface_count; i++) reflecting[i > lens.stop] += steps_at(i);
    pairs_all = (reflecting[0] + reflecting[1]) * (reflecting[0] + reflecting[1] - 1) / 2;
    for (across = 0; across < 2; across++) {
        load(HELIAR, across, 0);
        assert_int_equal(lens.ghost_count, across ? pairs_all : plain_count);
        n = all_of_four(across);
        load(HELIAR, across, LFLARE_MAX_FOUR);
        assert_int_equal(lens.four_count, n < LFLARE_MAX_FOUR ? n : LFLARE_MAX_FOUR);
        assert_int_equal(lens.ghost_count, (across ? pairs_all : plain_count) + lens.four_count);
        pairs = list_ghosts(&count);
        for (i = 0; i < count; i++) { /* those of two come first, in order; so do those of four */
            const lflare_pair *p = &pairs[i], *q = &pairs[i > 0 ? i - 1 : 0];
            int two = i < count - lens.four_count;
            assert_true(two == (p->third == 0 && p->fourth == 0));
            assert_true(lflare_path_make(&lens, 510, p, (lflare_path *)all) == LFLARE_OK);
            if (i == 0 || i == count - lens.four_count) continue;
            assert_true(p->first > q->first || (p->first == q->first && (p->second > q->second || (p->second == q->second && (p->third > q->third || (p->third == q->third && p->fourth > q->fourth))))));
        }
        print_message("Heliar, %s: %d ghosts of two, %d of four of %d\n", across ? "across the stop, too" : "on one side", (int)(count - lens.four_count), (int)lens.four_count, n);
        free(pairs);
    }
    load(HELIAR, 1, 9);
    assert_int_equal(lflare_lens_paths(&lens, NULL, NULL), LFLARE_OK); /* back to what it was */
    pairs = list_ghosts(&count);
    assert_int_equal(count, plain_count);
    assert_memory_equal(pairs, plain, sizeof *pairs * (size_t)count);
    free(pairs);
    free(plain);
}

/* The best N are the best N of all, N by N, and the same again. */
static void ranking(void **state)
{
    static const char *const paths[3] = {HELIAR, TESSAR, "lenses/sonnar-20.lens"};
    static const int rooms[4] = {1, 7, 64, LFLARE_MAX_FOUR};
    static lflare_pair again[LFLARE_MAX_FOUR];
    int l, across, r, i, k, n;
    (void)state;
    for (l = 0; l < 3; l++)
        for (across = 0; across < 2; across++) {
            load(paths[l], across, 0);
            n = all_of_four(across);
            for (r = 0; r < 4; r++) {
                int kept = n < rooms[r] ? n : rooms[r];
                load(paths[l], across, rooms[r]);
                assert_int_equal(lens.four_count, kept);
                for (i = 0; i < kept; i++) { /* none weaker than the weakest that belongs in, but for rounding */
                    for (k = 0; k < n && !same(&all[k].pair, &lens.four[i]); k++) {}
                    assert_true(k < n);
                    assert_true((double)all[k].flux >= (1 - 1e-6) * (double)all[kept - 1].flux);
                }
                for (k = 0; k < kept; k++) { /* and all that are stronger */
                    if (!((double)all[k].flux > (1 + 1e-6) * (double)all[kept - 1].flux)) continue;
                    for (i = 0; i < kept && !same(&all[k].pair, &lens.four[i]); i++) {}
                    assert_true(i < kept);
                }
                memcpy(again, lens.four, sizeof again);
                load(paths[l], across, rooms[r]);
                assert_memory_equal(again, lens.four, sizeof(lflare_pair) * (size_t)kept);
            }
        }
}

/* Each reflection more costs: the strongest ghost of four has little of the strongest of two. */
static void energy(void **state)
{
    static const char *const paths[3] = {HELIAR, TESSAR, NIKON};
    int l;
    (void)state;
    for (l = 0; l < 3; l++) {
        lflare_pair *pairs;
        int32_t count, g;
        double sum[3] = {0, 0, 0}, most[3] = {0, 0, 0};
        load(paths[l], 1, LFLARE_MAX_FOUR);
        pairs = list_ghosts(&count);
        for (g = 0; g < count; g++) {
            const lflare_pair *p = &pairs[g];
            int kind = p->third > 0 ? 2 : p->first > lens.stop && p->second < lens.stop;
            double flux = (double)flux_of(*p);
            sum[kind] += flux;
            most[kind] = fmax(most[kind], flux);
            if (kind == 2) { /* the same path without the last two */
                lflare_pair two = {0, 0, 0, 0};
                two.first = p->first;
                two.second = p->second;
                assert_true(lflare_ghost_weight(&lens, 510, *p, 0, 0) < 0.05 * lflare_ghost_weight(&lens, 510, two, 0, 0));
            }
        }
        print_message("%s: flux of two reflections %.2g, across the stop %.2g, of four (%d) %.2g; strongest %.2g %.2g %.2g\n", paths[l], sum[0], sum[1], (int)lens.four_count, sum[2], most[0],
                      most[1], most[2]);
        assert_true(most[2] < 0.05 * most[0] && sum[2] < 0.2 * sum[0]);
        free(pairs);
    }
}

/* ---- matrices and rays ---- */

static double matrix_error(oracle_matrix o, lflare_matrix m)
{
    double most = (double)fmaxl(fmaxl(fabsl(o.a), fabsl(o.b)), fmaxl(fabsl(o.c), fabsl(o.d)));
    return fmax(fmax(fabs((double)o.a - m.a), fabs((double)o.b - m.b)), fmax(fabs((double)o.c - m.c), fabs((double)o.d - m.d))) / most;
}

static void matrices(void **state)
{
    static const char *const paths[3] = {HELIAR, TESSAR, NIKON};
    static const double nm[3] = {ORACLE_D, 650, 475};
    double worst = 0;
    int l, k;
    (void)state;
    for (l = 0; l < 3; l++) {
        lflare_pair *pairs;
        int32_t count, g;
        load(paths[l], 1, LFLARE_MAX_FOUR);
        pairs = list_ghosts(&count);
        for (k = 0; k < 3; k++) {
            oracle_lens o, d;
            lflare_ghost_matrices *m = (lflare_ghost_matrices *)calloc((size_t)count, sizeof *m);
            oracle_lens_make(&o, &lens.prescription, nm[k]);
            oracle_lens_make(&d, &lens.prescription, ORACLE_D);
            assert_int_equal(lflare_ghost_optics(&lens, nm[k], pairs, count, m), LFLARE_OK);
            for (g = 0; g < count; g++) {
                oracle_step steps[ORACLE_STEPS];
                oracle_matrix at[ORACLE_STEPS + 1], at_d[ORACLE_STEPS + 1], ms = {1, 0, 0, 1};
                lflare_crossing path[LFLARE_MAX_STEPS];
                int n = steps_of(&o, pairs[g], steps), i, iris = -1;
                int32_t used = LFLARE_MAX_STEPS;
                oracle_paraxial(&o, steps, n, at);
                oracle_paraxial(&d, steps, n, at_d);
                assert_int_equal(lflare_ghost_path(&lens, nm[k], pairs[g], path, &used), LFLARE_OK);
                assert_int_equal(used, n);
                for (i = 0; i < n; i++) {
                    assert_true(path[i].surface == steps[i].surface && path[i].backwards == steps[i].backwards && path[i].reflected == steps[i].reflects);
                    worst = fmax(worst, fabs(path[i].a - (double)at[i].a) / (1 + fabs(path[i].a)));
                    if (!path[i].iris) continue;
                    assert_true(iris < 0 && steps[i].surface == lens.stop); /* one of them */
                    iris = i;
                }
                assert_true(iris >= 0);
                for (i = 0; i < n; i++) /* none clips sooner on the axis */
                    if (steps[i].surface == lens.stop) assert_true(fabsl(at_d[i].a) <= fabsl(at_d[iris].a) * (1 + 2e-6L));
                for (i = iris; i < n; i++) ms = oracle_times(oracle_gap_matrix(&steps[i]), oracle_times(oracle_crossing_matrix(&o, &steps[i]), ms));
                worst = fmax(worst, matrix_error(at[iris], m[g].ma));
                worst = fmax(worst, matrix_error(ms, m[g].ms));
                worst = fmax(worst, matrix_error(at[n], m[g].m));
            }
            free(m);
        }
        free(pairs);
    }
    print_message("matrices within %.1e of their largest element\n", worst);
    assert_true(worst < 1e-11);
}

static void rays(void **state)
{
    static lflare_path path;
    static const char *const paths[2] = {HELIAR, NIKON};
    oracle_random random = {3};
    double worst = 0, worst_stop = 0, worst_weight = 0;
    long arrived = 0, crossed[LFLARE_MAX_STOPS + 1] = {0, 0, 0, 0, 0, 0};
    int l, i, k;
    (void)state;
    for (l = 0; l < 2; l++) {
        lflare_pair *pairs;
        int32_t count, g;
        oracle_lens o;
        load(paths[l], 1, LFLARE_MAX_FOUR);
        oracle_lens_make(&o, &lens.prescription, 510);
        pairs = list_ghosts(&count);
        for (g = 0; g < count; g++) {
            oracle_step steps[ORACLE_STEPS];
            int n = steps_of(&o, pairs[g], steps), stops = crossings_of_stop(steps, n, lens.stop), tries;
            assert_int_equal(lflare_path_make(&lens, 510, &pairs[g], &path), LFLARE_OK);
            crossed[stops]++;
            for (tries = 0; tries < 40; tries++) {
                double reach = 0.5 * lens.prescription.surfaces[0].semi_diameter, weight = 1, far;
                double at[2] = {oracle_between(&random, -reach, reach), oracle_between(&random, -reach, reach)};
                double slope[2] = {oracle_between(&random, -0.1, 0.1), oracle_between(&random, -0.1, 0.1)};
                long double at_l[2] = {(long double)at[0], (long double)at[1]}, slope_l[2] = {(long double)slope[0], (long double)slope[1]};
                oracle_ray exact;
                lflare_ray ray;
                int arrives = oracle_trace(&o, steps, n, at_l, slope_l, &exact), at_stop = 0;
                assert_int_equal(arrives, lflare_path_trace(&path, at, slope, &ray, NULL) == LFLARE_RAY_ARRIVES);
                if (!arrives) continue;
                arrived++;
                far = 1 + hypot(ray.sensor[0], ray.sensor[1]);
                for (k = 0; k < 2; k++) worst = fmax(worst, fabs(ray.sensor[k] - (double)exact.sensor[k]) / (far * far));
                assert_int_equal(ray.stop_count, stops);
                for (i = 0; i < n; i++) {
                    int s = steps[i].surface, used;
                    lflare_layer layers[LFLARE_MAX_LAYERS], turned[LFLARE_MAX_LAYERS];
                    double n1 = (double)o.n[s + steps[i].backwards], n2 = (double)o.n[s + 1 - steps[i].backwards], film;
                    if (s == lens.stop) {
                        const double *here = ray.stops[at_stop++];
                        worst_stop = fmax(worst_stop, fabs(hypot(here[0], here[1]) - (double)exact.height[i]) / (1 + (double)exact.height[i]));
                        if (path.steps[i].iris) assert_true(here[0] == ray.stop[0] && here[1] == ray.stop[1]);
                        continue;
                    }
                    used = oracle_layers(o.p, s, layers);
                    for (k = 0; k < used; k++) turned[k] = layers[steps[i].backwards ? used - 1 - k : k];
                    film = oracle_film(n1, n2, turned, used, o.nm, n1 * sqrt(fmax(0, 1 - (double)(exact.cosine[i] * exact.cosine[i]))));
                    weight *= steps[i].reflects ? film : 1 - film;
                }
                worst_weight = fmax(worst_weight, fabs(ray.weight - weight) / (weight + 1e-12));
            }
        }
        free(pairs);
    }
    print_message("%ld rays arrive of ghosts that cross the stop once (%ld), three times (%ld), five times (%ld): sensor within %.1e mm per (1 + distance)^2, stops %.1e, weight %.1e\n", arrived,
                  crossed[1], crossed[3], crossed[5], worst, worst_stop, worst_weight);
    assert_true(arrived > 1000 && crossed[1] > 0 && crossed[3] > 0 && crossed[5] > 0);
    assert_true(worst < 1e-8 && worst_stop < 1e-8 && worst_weight < 1e-6);
}

/* ---- clipping ---- */

/* Area of the entrance through which dense paraxial rays pass: every rim, and the iris at every crossing. */
static double dense_area(const oracle_step *steps, const oracle_matrix *at, int n, double iris, double u, const lflare_region *where)
{
    enum { GRID = 400 };
    double half = 0.5 * (where->hi - where->lo), high = lens.prescription.surfaces[0].semi_diameter, area = 0;
    int i, j, k;
    for (i = 0; i < n; i++) { /* the open part is no higher than the narrowest rim's image */
        double h = steps[i].surface == lens.stop ? iris : lens.prescription.surfaces[steps[i].surface].semi_diameter;
        high = fmin(high, h / fabs((double)at[i].a));
    }
    for (j = 0; j < GRID; j++)
        for (i = 0; i < GRID; i++) {
            double x = where->lo + 2 * half * (i + 0.5) / GRID, y = high * (j + 0.5) / GRID;
            for (k = 0; k < n; k++) {
                double h = steps[k].surface == lens.stop ? iris : lens.prescription.surfaces[steps[k].surface].semi_diameter;
                if (hypot((double)at[k].a * x + (double)at[k].b * u, (double)at[k].a * y) > h) break;
            }
            area += k == n;
        }
    return 2 * area * 2 * half * high / ((double)GRID * GRID);
}

static void clipping(void **state)
{
    lflare_pair *pairs;
    int32_t count, g;
    oracle_lens o;
    double worst = 0, worst_table = 0, moved = 0;
    int tested = 0, f;
    static const double stops[2] = {0, 11};
    (void)state;
    load(HELIAR, 1, 48);
    oracle_lens_make(&o, &lens.prescription, 510);
    pairs = list_ghosts(&count);
    for (f = 0; f < 2; f++) {
        lflare_desc desc;
        lflare *flare;
        const lflare_tables *t;
        memset(&desc, 0, sizeof desc);
        desc.prescription = &lens.prescription;
        desc.paths = lens.paths;
        desc.settings.fnumber = stops[f];
        desc.settings.no_starburst = 1;
        assert_int_equal(lflare_create(&desc, &flare, NULL), LFLARE_OK);
        t = lflare_get_tables(flare);
        assert_int_equal(t->ghost_count, count);
        for (g = 0; g < count; g++) {
            oracle_step steps[ORACLE_STEPS];
            oracle_matrix at[ORACLE_STEPS + 1];
            int n = steps_of(&o, pairs[g], steps), j;
            if (crossings_of_stop(steps, n, lens.stop) < 2) continue;
            oracle_paraxial(&o, steps, n, at);
            for (j = 0; j < 60; j += 19) { /* at field samples, so that nothing is interpolated */
                double u = tan((double)t->style[(size_t)g * LFLARE_STYLE_FLOATS + 6] * j / (LFLARE_FIELD_SAMPLES - 1)), dense, table;
                const float *field = t->field + ((size_t)g * LFLARE_FIELD_SAMPLES + (size_t)j) * LFLARE_FIELD_FLOATS;
                lflare_region region, once;
                lflare_clip clip = lflare_ghost_clip(&lens, 510, pairs[g], (double)t->iris.radius, u, &region);
                if (clip == LFLARE_CLIP_HIDDEN) continue;
                dense = dense_area(steps, at, n, (double)t->iris.radius, u, &region);
                table = PI * (double)field[4] * (double)field[4];
                worst = fmax(worst, fabs(region.area / dense - 1));
                worst_table = fmax(worst_table, fabs(table / region.area - 1));
                lflare_ghost_clip(&lens, 510, pairs[g], 1e5, u, &once); /* an iris that stops nothing: what all crossings of it take */
                moved = fmax(moved, once.area / region.area);
                tested++;
            }
        }
        lflare_destroy(flare);
    }
    print_message("%d footprints across the stop: area within %.2g %% of dense rays, tables within %.1e; without the iris up to %.0f times as large\n", tested, 100 * worst, worst_table, moved);
    assert_true(tested > 100);
    assert_true(worst < 0.02 && worst_table < 1e-4 && moved > 4);
    free(pairs);
}

/* ---- what is refused; overrides; fits ---- */

static void refusals(void **state)
{
    static lflare_lens before;
    static const lflare_pair wrong[7] = {{3, 1, 0, 2}, {3, 1, 1, 0}, {3, 1, 4, 4}, {3, 1, 4, -1}, {3, 1, 99, 0}, {3, 1, 5, 0}, {7, 1, 8, 0}};
    lflare_paths paths = {0, 0};
    lflare_desc desc;
    lflare *flare;
    lflare_error error;
    lflare_ghost_matrices m;
    static lflare_path path;
    int i;
    (void)state;
    load(HELIAR, 0, 20);
    before = lens;
    for (i = 0; i < 4; i++) {
        paths.across_stop = i == 0 ? -1 : i == 1 ? 2 : 0;
        paths.four = i == 2 ? -1 : i == 3 ? LFLARE_MAX_FOUR + 1 : 0;
        assert_int_equal(lflare_lens_paths(&lens, &paths, &error), LFLARE_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "across_stop"));
        assert_int_equal(lflare_lens_paths(&lens, &paths, NULL), LFLARE_ERROR_ARGUMENT);
        assert_memory_equal(&before, &lens, sizeof lens);
        memset(&desc, 0, sizeof desc);
        desc.prescription = &lens.prescription;
        desc.paths = paths;
        assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_ERROR_ARGUMENT);
        assert_null(flare);
    }
    assert_int_equal(lflare_lens_paths(NULL, NULL, &error), LFLARE_ERROR_ARGUMENT);
    for (i = 0; i < 7; i++) { /* the stop is surface 5 from 0 */
        assert_int_equal(lflare_path_make(&lens, 510, &wrong[i], &path), LFLARE_ERROR_ARGUMENT);
        assert_int_equal(lflare_ghost_optics(&lens, 510, &wrong[i], 1, &m), LFLARE_ERROR_ARGUMENT);
    }
}

static void overrides(void **state)
{
    lflare_override o;
    lflare_desc desc;
    lflare *flare;
    lflare_error error;
    const lflare_tables *t;
    int32_t g, hidden = 0;
    (void)state;
    load(HELIAR, 0, 20);
    memset(&o, 0, sizeof o);
    o.first = lens.four[3].first + 1;
    o.second = lens.four[3].second + 1;
    o.third = lens.four[3].third + 1;
    o.fourth = lens.four[3].fourth + 1;
    o.hide = 1;
    memset(&desc, 0, sizeof desc);
    desc.prescription = &lens.prescription;
    desc.paths = lens.paths;
    desc.settings.no_starburst = 1;
    desc.settings.overrides = &o;
    desc.settings.override_count = 1;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_OK);
    t = lflare_get_tables(flare);
    for (g = 0; g < t->ghost_count; g++)
        if (t->style[(size_t)g * LFLARE_STYLE_FLOATS] == 0) {
            hidden++;
            assert_true(same(&t->pairs[g], &lens.four[3]));
            assert_true(t->head[(size_t)g * LFLARE_HEAD_FLOATS + 15] == (float)(lens.four[3].third * LFLARE_MAX_SURFACES + lens.four[3].fourth));
        }
    assert_int_equal(hidden, 1);
    lflare_destroy(flare);
    desc.paths.four = 0;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "has no ghost ("));
    o.third = o.fourth = 0; /* that of two reflections alone */
    o.first = 4;
    o.second = 2;
    desc.paths.four = 20;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_OK);
    t = lflare_get_tables(flare);
    for (hidden = g = 0; g < t->ghost_count; g++) hidden += t->style[(size_t)g * LFLARE_STYLE_FLOATS] == 0;
    assert_int_equal(hidden, 1);
    lflare_destroy(flare);
}

static void fits_belong(void **state)
{
    void *plain, *more;
    size_t plain_size, more_size;
    lflare_error error;
    (void)state;
    load(TESSAR, 0, 0);
    assert_int_equal(lflare_aberration_fit(&lens, NULL, &plain, &plain_size, &error), LFLARE_OK);
    assert_int_equal(lflare_aberration_check(&lens, plain, plain_size, &error), LFLARE_OK);
    load(TESSAR, 1, 4);
    assert_int_equal(lflare_aberration_check(&lens, plain, plain_size, &error), LFLARE_ERROR_FIT);
    assert_non_null(strstr(error.text, "other paths"));
    assert_int_equal(lflare_aberration_fit(&lens, NULL, &more, &more_size, &error), LFLARE_OK);
    assert_int_equal(lflare_aberration_check(&lens, more, more_size, &error), LFLARE_OK);
    load(TESSAR, 0, 0);
    assert_int_equal(lflare_aberration_check(&lens, more, more_size, &error), LFLARE_ERROR_FIT);
    assert_non_null(strstr(error.text, "other paths"));
    load(TESSAR, 0, 4);
    assert_int_equal(lflare_aberration_check(&lens, more, more_size, &error), LFLARE_ERROR_FIT);
    load(HELIAR, 1, 4);
    assert_int_equal(lflare_aberration_check(&lens, more, more_size, &error), LFLARE_ERROR_FIT);
    assert_non_null(strstr(error.text, "another lens"));
    free(plain);
    free(more);
}

/* ---- pictures ---- */

enum { WIDTH = 240, HEIGHT = 160, PIXELS = WIDTH * HEIGHT };

/* Draws the paths beyond those of two reflections on one side: the whole picture less the plain one. */
static void draw(const char *lens_path, lflare_paths paths, const void *fit, size_t fit_size, double degrees, double fnumber, float *rgb)
{
    static float pixels[4 * PIXELS];
    lflare_desc desc;
    lflare_view view;
    lflare_light light;
    lflare_image image;
    lflare_override *hidden;
    lflare_error error;
    lflare *flare;
    int32_t i, k, plain;
    lflare_pair *pairs;
    load(lens_path, paths.across_stop, paths.four);
    pairs = list_ghosts(&i);
    hidden = (lflare_override *)calloc((size_t)i, sizeof *hidden);
    for (plain = k = 0; k < i; k++)
        if (pairs[k].third == 0 && !(pairs[k].first > lens.stop && pairs[k].second < lens.stop)) {
            hidden[plain].first = pairs[k].first + 1;
            hidden[plain].second = pairs[k].second + 1;
            hidden[plain++].hide = 1;
        }
    memset(&desc, 0, sizeof desc);
    memset(&view, 0, sizeof view);
    memset(&light, 0, sizeof light);
    memset(&image, 0, sizeof image);
    memset(pixels, 0, sizeof pixels);
    desc.prescription = &lens.prescription;
    desc.paths = paths;
    desc.fit = fit;
    desc.fit_size = fit_size;
    desc.settings.fnumber = fnumber;
    desc.settings.raw = desc.settings.no_starburst = desc.settings.no_ringing = 1;
    desc.settings.overrides = hidden;
    desc.settings.override_count = plain;
    if (lflare_create(&desc, &flare, &error) != LFLARE_OK) fail_msg("%s", error.text);
    view.width = image.width = WIDTH;
    view.height = image.height = HEIGHT;
    image.pixels = pixels;
    light.direction[0] = (float)tan(degrees * PI / 180);
    light.direction[1] = 0.5f * light.direction[0];
    light.direction[2] = -1;
    for (k = 0; k < 3; k++) light.color[k] = 1;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (k = 0; k < 3 * PIXELS; k++) rgb[k] = pixels[k / 3 * 4 + k % 3];
    lflare_destroy(flare);
    free(hidden);
    free(pairs);
}

static void draw_exact(const char *lens_path, lflare_paths paths, double degrees, double fnumber, float *rgb)
{
    static reference_desc d;
    static float one[3 * PIXELS];
    static const double nm[3] = {650, 510, 475};
    lflare_iris iris;
    lflare_pair *pairs;
    int32_t count, g, k;
    load(lens_path, paths.across_stop, paths.four);
    pairs = list_ghosts(&count);
    lflare_iris_make(&lens, fnumber, 0, 0, 0, &iris, NULL);
    memset(&d, 0, sizeof d);
    d.lens = &lens;
    d.iris = &iris;
    d.slope[0] = -tan(degrees * PI / 180);
    d.slope[1] = 0.5 * d.slope[0];
    d.half[0] = 0.5 * lens.sensor_width;
    d.half[1] = d.half[0] * HEIGHT / WIDTH;
    d.width = WIDTH;
    d.height = HEIGHT;
    d.wavelengths = 3;
    for (k = 0; k < 3; k++) d.nm[k] = nm[k], d.rgb[k][k] = 1;
    d.cells = 24;
    memset(rgb, 0, sizeof one);
    for (g = 0; g < count; g++) {
        if (pairs[g].third == 0 && !(pairs[g].first > lens.stop && pairs[g].second < lens.stop)) continue;
        d.only = &pairs[g];
        assert_int_equal(reference_render(&d, one), 1);
        for (k = 0; k < 3 * PIXELS; k++) rgb[k] += one[k];
    }
    free(pairs);
}

static double psnr(const float *a, const float *b, double *power)
{
    double most = 0, error = 0, sums[2] = {0, 0};
    long lit = 0, i;
    for (i = 0; i < 3 * PIXELS; i++) most = fmax(most, (double)a[i]);
    for (i = 0; i < 3 * PIXELS; i++) {
        double x = (double)a[i], y = (double)b[i];
        sums[0] += x;
        sums[1] += y;
        if (fmax(x, y) < 1e-4 * most) continue;
        error += (x - y) * (x - y);
        lit++;
    }
    *power = sums[1] / sums[0];
    return 10 * log10(most * most * (double)lit / error);
}

static void pictures(void **state)
{
    static float exact[3 * PIXELS], drawn[3 * PIXELS];
    static const struct {
        const char *path;
        lflare_paths paths;
        double paraxial, polynomial; /* dB, at least */
    } cases[2] = {{HELIAR, {1, 0}, 31, 29}, {HELIAR, {0, 24}, 38, 34}};
    int i;
    (void)state;
    for (i = 0; i < 2; i++) {
        void *fit;
        size_t size;
        double db[2], power[2];
        draw_exact(cases[i].path, cases[i].paths, 2, 16, exact);
        draw(cases[i].path, cases[i].paths, NULL, 0, 2, 16, drawn);
        db[0] = psnr(exact, drawn, &power[0]);
        assert_int_equal(lflare_aberration_fit(&lens, NULL, &fit, &size, NULL), LFLARE_OK);
        draw(cases[i].path, cases[i].paths, fit, size, 2, 16, drawn);
        db[1] = psnr(exact, drawn, &power[1]);
        print_message("%s, f/16, 2 degrees: %s: paraxial %.1f dB, power %.4f; polynomial %.1f dB, power %.4f\n", cases[i].path, cases[i].paths.across_stop ? "across the stop" : "four reflections",
                      db[0], power[0], db[1], power[1]);
        assert_true(db[0] > cases[i].paraxial && db[1] > cases[i].polynomial);
        assert_true(fabs(power[0] - 1) < 0.05 && fabs(power[1] - 1) < 0.05);
        free(fit);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts),   cmocka_unit_test(ranking),   cmocka_unit_test(energy),      cmocka_unit_test(matrices), cmocka_unit_test(rays),
        cmocka_unit_test(clipping), cmocka_unit_test(refusals),  cmocka_unit_test(overrides),   cmocka_unit_test(fits_belong), cmocka_unit_test(pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
