/* Optics against the tests' own physics (oracle.h) and the golden numbers: matrices, exact rays, signs, films, regions,
   glass. Runs from the repository's root; the golden numbers lie beside it. */

#define _POSIX_C_SOURCE 200809L
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "oracle.h"

#define PI 3.14159265358979323846
#define GOLDEN "../shared/golden/"

static lflare_lens lens;      /* 80 KB each: not on the stack */
static oracle_lenses lenses;

static int setup(void **state)
{
    (void)state;
    oracle_lenses_find(&lenses);
    return 0;
}

static void load(const char *path)
{
    if (!oracle_lens_load(path, &lens)) fail_msg("%s does not load", path);
}

static lflare_pair *list_ghosts(int32_t *count)
{
    lflare_pair *pairs;
    *count = 0;
    lflare_ghost_list(&lens, NULL, count);
    pairs = (lflare_pair *)calloc((size_t)*count + 1, sizeof *pairs);
    assert_non_null(pairs);
    assert_int_equal(lflare_ghost_list(&lens, pairs, count), LFLARE_OK);
    assert_int_equal(*count, lens.ghost_count);
    return pairs;
}

/* ---- golden numbers ---- */

/* Largest difference over the golden matrix's largest element. */
static double matrix_error(const double *golden, lflare_matrix m)
{
    const double ours[4] = {m.a, m.b, m.c, m.d};
    double largest = 0, worst = 0;
    int i;
    for (i = 0; i < 4; i++) {
        largest = fmax(largest, fabs(golden[i]));
        worst = fmax(worst, fabs(golden[i] - ours[i]));
    }
    return worst / largest;
}

static void check_golden(const char *json, const char *path, int32_t expected)
{
    char *text = oracle_read(json);
    const char *at = text;
    lflare_pair *pairs;
    lflare_ghost_matrices *m;
    oracle_lens o;
    oracle_step steps[ORACLE_STEPS];
    int32_t count, g;
    double value[4] = {0}, worst_matrix = 0, worst_ray = 0;
    if (text == NULL) {
        print_message("%s is not there: golden numbers not compared\n", json);
        skip();
    }
    load(path);
    pairs = list_ghosts(&count);
    m = (lflare_ghost_matrices *)calloc((size_t)count, sizeof *m);
    assert_non_null(m);
    assert_int_equal(count, expected);
    assert_int_equal(lflare_ghost_optics(&lens, ORACLE_D, pairs, count, m), LFLARE_OK);
    assert_true(oracle_json_numbers(&at, "efl_mm", value, 1));
    assert_true(fabs(lens.efl / value[0] - 1) < 1e-6);
    assert_true(oracle_json_numbers(&at, "bfd_mm", value, 1));
    assert_true(fabs(lens.bfd / value[0] - 1) < 1e-6);
    assert_true(oracle_json_numbers(&at, "ghost_count", value, 1));
    assert_true(value[0] == (double)expected);
    oracle_lens_make(&o, &lens.prescription, ORACLE_D);
    for (g = 0; g < count; g++) {
        double ray[4] = {0}, scale;
        long double start[2] = {0, 0}, slope[2] = {0, 0};
        oracle_ray exact;
        int n = oracle_path(&o, pairs[g].first, pairs[g].second, steps);
        assert_true(oracle_json_numbers(&at, "first", value, 1));
        assert_int_equal((int)value[0], pairs[g].first + 1);
        assert_true(oracle_json_numbers(&at, "second", value, 1));
        assert_int_equal((int)value[0], pairs[g].second + 1);
        assert_true(oracle_json_numbers(&at, "Ma", value, 4));
        worst_matrix = fmax(worst_matrix, matrix_error(value, m[g].ma));
        assert_true(oracle_json_numbers(&at, "Ms", value, 4));
        worst_matrix = fmax(worst_matrix, matrix_error(value, m[g].ms));
        assert_true(oracle_json_numbers(&at, "M", value, 4));
        worst_matrix = fmax(worst_matrix, matrix_error(value, m[g].m));
        assert_true(oracle_json_numbers(&at, "entrance_x", &ray[0], 1) && oracle_json_numbers(&at, "theta_x", &ray[1], 1));
        assert_true(oracle_json_numbers(&at, "stop_x", &ray[2], 1) && oracle_json_numbers(&at, "sensor_x", &ray[3], 1));
        start[0] = (long double)ray[0];
        slope[0] = tanl((long double)ray[1]);
        assert_true(oracle_trace(&o, steps, n, start, slope, &exact));
        scale = fmax(fabs(ray[2]), fabs(ray[3])); /* 1e-2 mm and up, printed to 17 digits */
        worst_ray = fmax(worst_ray, fabs((double)exact.stop[0] - ray[2]) / scale);
        worst_ray = fmax(worst_ray, fabs((double)exact.sensor[0] - ray[3]) / scale);
    }
    assert_null(oracle_json_find(at, "first")); /* no ghost of theirs is left */
    print_message("%s: %d ghosts, worst matrix element %.1e, worst exact ray of the oracle %.1e\n", path, (int)count, worst_matrix, worst_ray);
    assert_true(worst_matrix < 1e-6);
    assert_true(worst_ray < 1e-10);
    free(m);
    free(pairs);
    free(text);
}

static void golden_heliar(void **state)
{
    (void)state;
    check_golden(GOLDEN "heliar.json", "tests/data/heliar-golden.lens", 13);
}

static void golden_canon(void **state)
{
    (void)state;
    check_golden(GOLDEN "canon_us5576890.json", "tests/data/canon-golden.lens", 171);
}

static void golden_films(void **state)
{
    char *text = oracle_read(GOLDEN "films.json");
    const char *at = text;
    int count = 0;
    double worst = 0, worst_oracle = 0;
    (void)state;
    if (text == NULL) {
        print_message(GOLDEN "films.json is not there: films not compared\n");
        skip();
    }
    at = oracle_json_find(at, "films");
    for (; oracle_json_find(at, "n0") != NULL; count++) {
        lflare_layer layers[16];
        int used = 0;
        double n0 = 0, ns = 0, nm = 0, degrees = 0, golden = 0, s;
        assert_true(oracle_json_numbers(&at, "n0", &n0, 1) && oracle_json_numbers(&at, "ns", &ns, 1));
        at = oracle_json_find(at, "layers");
        assert_non_null(at);
        at += strspn(at, " \r\n\t[");
        while (*at != ']') { /* [[n, nm], [n, nm]] */
            char *end;
            assert_true(used < 16);
            layers[used].n = strtod(at, &end);
            at = end + strspn(end, " \r\n\t,");
            layers[used++].thickness_nm = strtod(at, &end);
            at = end + strspn(end, " \r\n\t");
            assert_true(*at == ']');
            at++;
            at += strspn(at, " \r\n\t,[");
        }
        assert_true(oracle_json_numbers(&at, "lambda_nm", &nm, 1) && oracle_json_numbers(&at, "theta_deg", &degrees, 1));
        assert_true(oracle_json_numbers(&at, "R", &golden, 1));
        s = n0 * sin(degrees * PI / 180);
        worst = fmax(worst, fabs(lflare_film_reflectance(n0, ns, layers, used, nm, s) - golden));
        worst_oracle = fmax(worst_oracle, fabs(oracle_film(n0, ns, layers, used, nm, s) - golden));
    }
    print_message("%d golden films: library %.1e, oracle %.1e\n", count, worst, worst_oracle);
    assert_true(count >= 30);
    assert_true(worst < 1e-9);
    assert_true(worst_oracle < 1e-9);
    free(text);
}

/* ---- paraxial against exact ---- */

static double relative(oracle_matrix o, lflare_matrix m)
{
    double golden[4];
    golden[0] = (double)o.a;
    golden[1] = (double)o.b;
    golden[2] = (double)o.c;
    golden[3] = (double)o.d;
    return matrix_error(golden, m);
}

/* The library's matrices and paths are the oracle's own (products in long double). */
static void matrices_agree(void **state)
{
    int l;
    double worst = 0, worst_path = 0;
    (void)state;
    assert_true(lenses.count >= 2);
    for (l = 0; l < lenses.count; l++) {
        static const double nm[4] = {ORACLE_D, 650, 510, 475};
        int32_t count, g, k;
        lflare_pair *pairs;
        lflare_ghost_matrices *m;
        load(lenses.path[l]);
        pairs = list_ghosts(&count);
        m = (lflare_ghost_matrices *)calloc((size_t)count + 1, sizeof *m);
        assert_non_null(m);
        for (k = 0; k < 4; k++) {
            oracle_lens o;
            oracle_lens_make(&o, &lens.prescription, nm[k]);
            assert_int_equal(lflare_ghost_optics(&lens, nm[k], pairs, count, m), LFLARE_OK);
            for (g = 0; g < count; g++) {
                oracle_step steps[ORACLE_STEPS];
                oracle_matrix at[ORACLE_STEPS + 1], ms = {1, 0, 0, 1};
                lflare_crossing path[ORACLE_STEPS];
                int n = oracle_path(&o, pairs[g].first, pairs[g].second, steps), i, stop = -1;
                int32_t used = ORACLE_STEPS;
                oracle_paraxial(&o, steps, n, at);
                for (i = 0; i < n; i++) {
                    if (stop >= 0 || steps[i].surface == o.stop) {
                        if (stop < 0) stop = i;
                        ms = oracle_times(oracle_gap_matrix(&steps[i]), oracle_times(oracle_crossing_matrix(&o, &steps[i]), ms));
                    }
                }
                assert_true(stop >= 0);
                worst = fmax(worst, relative(at[stop], m[g].ma));
                worst = fmax(worst, relative(ms, m[g].ms));
                worst = fmax(worst, relative(at[n], m[g].m));
                assert_int_equal(lflare_ghost_path(&lens, nm[k], pairs[g], path, &used), LFLARE_OK);
                assert_int_equal(used, n);
                for (i = 0; i < n; i++) { /* a b; p q: height and tangent of incidence */
                    long double c = steps[i].backwards ? -o.curvature[steps[i].surface] : o.curvature[steps[i].surface];
                    oracle_matrix mine = at[i];
                    lflare_matrix theirs;
                    mine.c += c * mine.a;
                    mine.d += c * mine.b;
                    theirs.a = path[i].a;
                    theirs.b = path[i].b;
                    theirs.c = path[i].p;
                    theirs.d = path[i].q;
                    worst_path = fmax(worst_path, relative(mine, theirs));
                    assert_int_equal(path[i].surface, steps[i].surface);
                    assert_int_equal(path[i].backwards, steps[i].backwards);
                    assert_int_equal(path[i].reflected, steps[i].reflects);
                    worst_path = fmax(worst_path, fabs(path[i].n_in - (double)o.n[steps[i].surface + steps[i].backwards]));
                    worst_path = fmax(worst_path, fabs(path[i].n_out - (double)o.n[steps[i].surface + 1 - steps[i].backwards]));
                }
            }
        }
        free(m);
        free(pairs);
    }
    print_message("%d lenses: matrices within %.1e, paths within %.1e of their largest element\n", lenses.count, worst, worst_path);
    assert_true(worst < 1e-12);
    assert_true(worst_path < 1e-12);
}

/* Halving height and angle together divides the paraxial error by 8, at the stop and on the sensor. Skew rays in long
   double: the error at 0.005 mm is about 1e-10 mm, rounding about 1e-18. An error that is below 1e-14 mm (flat surfaces only,
   or none, on the way to the stop) cannot show its order; those are counted and few. */
static void error_is_cubic(void **state)
{
    int l, tested = 0, nothing = 0, k;
    long double least = 1e30L, most = 0;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        int32_t count, g;
        lflare_pair *pairs;
        oracle_lens o;
        load(lenses.path[l]);
        pairs = list_ghosts(&count);
        oracle_lens_make(&o, &lens.prescription, ORACLE_D);
        for (g = -1; g < count; g++) { /* -1: the direct path */
            oracle_step steps[ORACLE_STEPS];
            oracle_matrix at[ORACLE_STEPS + 1];
            int n = oracle_path(&o, g < 0 ? -1 : pairs[g].first, g < 0 ? -1 : pairs[g].second, steps), i, half, stop = 0;
            long double error[2][2] = {{0, 0}, {0, 0}};
            oracle_paraxial(&o, steps, n, at);
            for (i = 0; i < n; i++)
                if (steps[i].surface == o.stop) stop = i;
            for (half = 0; half < 2; half++) {
                long double r = half ? 0.005L : 0.01L, t = half ? 5e-5L : 1e-4L, start[2], slope[2], wrong;
                oracle_ray ray;
                start[0] = r * cosl(0.4L); /* skew: not in one plane with the axis */
                start[1] = r * sinl(0.4L);
                slope[0] = t * cosl(1.9L);
                slope[1] = t * sinl(1.9L);
                if (!oracle_trace(&o, steps, n, start, slope, &ray)) fail_msg("%s: ghost %d does not trace", lenses.path[l], (int)g);
                for (k = 0; k < 2; k++) {
                    wrong = ray.stop[k] - (at[stop].a * start[k] + at[stop].b * slope[k]);
                    error[0][half] = hypotl(error[0][half], wrong);
                    wrong = ray.sensor[k] - (at[n].a * start[k] + at[n].b * slope[k]);
                    error[1][half] = hypotl(error[1][half], wrong);
                }
            }
            for (k = 0; k < 2; k++) {
                long double ratio = error[k][0] / error[k][1];
                if (error[k][1] < 1e-14L) {
                    nothing++;
                    continue;
                }
                tested++;
                if (ratio < least) least = ratio;
                if (ratio > most) most = ratio;
                if (!(fabsl(ratio - 8) <= 0.5L))
                    fail_msg("%s: ghost %d at the %s: error %Lg, halved %Lg, ratio %Lf", lenses.path[l], (int)g, k ? "sensor" : "stop", error[k][0],
                             error[k][1], ratio);
            }
        }
        free(pairs);
    }
    print_message("%d errors divide by %.4Lf to %.4Lf, %d are nothing\n", tested, least, most, nothing);
    assert_true(tested >= 368);
    assert_true(nothing * 20 < tested);
}

/* ---- signs: a pentagon, corner by corner ---- */

typedef struct bench {
    lflare *flare;
    lflare_tables tables; /* a copy whose plain numbers may be bent */
    lflare_frame_light light;
    lflare_frame_data frame;
} bench;

static void bench_open(bench *b, const char *path, const lflare_settings *settings)
{
    lflare_desc desc;
    char *text = oracle_read(path);
    lflare_error error;
    memset(b, 0, sizeof *b);
    memset(&desc, 0, sizeof desc);
    assert_non_null(text);
    desc.text = text;
    desc.text_size = strlen(text);
    desc.settings = *settings;
    if (lflare_create(&desc, &b->flare, &error) < 0) fail_msg("%s: %s", path, error.text);
    b->tables = *lflare_get_tables(b->flare);
    b->frame.lights = &b->light;
    b->frame.light_capacity = 1;
    free(text);
}

/* The entrance point from which an exact ray passes the stop at `target`, by Newton's method from the paraxial one. */
static int aim(const oracle_lens *o, const oracle_step *steps, int n, oracle_matrix to_stop, const long double *slope, const long double *target,
               oracle_ray *ray)
{
    long double r[2];
    int i, k;
    for (k = 0; k < 2; k++) r[k] = (target[k] - to_stop.b * slope[k]) / to_stop.a;
    for (i = 0; i < 60; i++) {
        if (!oracle_trace(o, steps, n, r, slope, ray)) return 0;
        for (k = 0; k < 2; k++) r[k] -= (ray->stop[k] - target[k]) / to_stop.a;
    }
    return oracle_trace(o, steps, n, r, slope, ray) && hypotl(ray->stop[0] - target[0], ray->stop[1] - target[1]) < 1e-13L;
}

static void pentagon_corners(void **state)
{
    int l, positive = 0, negative = 0, left_out = 0;
    double worst = 0;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings settings;
        bench b;
        int32_t g, k, corner;
        double radius;
        memset(&settings, 0, sizeof settings);
        load(lenses.path[l]);
        settings.blades = 5;
        settings.blade_rotation = 0.3f;
        settings.fnumber = fabs(lens.stop_a11) * lens.efl / 0.002; /* 0.001 mm on the stop: what rays err by, over the radius, goes with its square */
        bench_open(&b, lenses.path[l], &settings);
        radius = (double)b.tables.iris.radius;
        assert_true(fabs(radius - 0.001) < 1e-7);
        /* the plain geometry is wanted: no diffraction, no pixel, no lamp to give so small a ghost a least size */
        for (k = 0; k < 3; k++) b.tables.wavelengths[k] = 1e-9f;
        b.frame.pixel = 1e-9f;
        b.frame.light_count = 1;
        b.light.slope[0] = -6e-6f;
        b.light.slope[1] = -8e-6f;
        b.light.slope_length = 1e-5f;
        b.light.axis[0] = -0.6f;
        b.light.axis[1] = -0.8f;
        b.light.field_angle = 1e-5f;
        b.light.irradiance[0] = b.light.irradiance[1] = b.light.irradiance[2] = 1;
        for (g = 0; g < b.tables.ghost_count; g++)
            for (k = 0; k < 3; k++) {
                static const double nm[3] = {650, 510, 475};
                lflare_pair pair = b.tables.pairs[g];
                lflare_footprint fp;
                lflare_instance instance = {0, 0, 0, 0};
                lflare_edge edge;
                oracle_lens o;
                oracle_step steps[ORACLE_STEPS];
                oracle_matrix at[ORACLE_STEPS + 1];
                int n, i, stop = 0;
                double size;
                oracle_lens_make(&o, &lens.prescription, nm[k]);
                n = oracle_path(&o, pair.first, pair.second, steps);
                oracle_paraxial(&o, steps, n, at);
                for (i = 0; i < n; i++)
                    if (steps[i].surface == o.stop) stop = i;
                instance.ghost = (uint16_t)g;
                if (fabsl(at[stop].a) < 0.02L || !lflare_footprint_resolve(&b.tables, &b.frame, instance, &fp)) {
                    left_out++; /* the entrance would be scanned over 0.05 mm and more, or the ghost is dark */
                    continue;
                }
                edge = fp.edges[0];
                size = radius * fabs((double)(at[n].a / at[stop].a));
                for (corner = 0; corner < 5; corner++) {
                    double angle = (double)0.3f + 2 * PI * corner / 5, drawn[2];
                    long double target[2], slope[2];
                    oracle_ray ray;
                    slope[0] = (long double)b.light.slope[0];
                    slope[1] = (long double)b.light.slope[1];
                    target[0] = (long double)(radius * cos(angle));
                    target[1] = (long double)(radius * sin(angle));
                    if (!aim(&o, steps, n, at[stop], slope, target, &ray)) fail_msg("%s: ghost %d cannot be aimed", lenses.path[l], (int)g);
                    for (i = 0; i < 2; i++) {
                        drawn[i] = (double)fp.centre[k][i] + ((double)target[i] / (double)b.tables.iris.radius - (double)edge.offset[k] * (double)fp.axis[i]) / (double)edge.gain[k];
                        drawn[i] -= (double)ray.sensor[i];
                    }
                    worst = fmax(worst, hypot(drawn[0], drawn[1]) / size);
                    if (hypot(drawn[0], drawn[1]) > 0.01 * size)
                        fail_msg("%s: ghost (%d,%d) channel %d corner %d: drawn %g of its radius %g mm from where the exact ray lands", lenses.path[l],
                                 (int)pair.first + 1, (int)pair.second + 1, (int)k, (int)corner, hypot(drawn[0], drawn[1]) / size, size);
                }
                if (at[n].a / at[stop].a > 0) positive++;
                else negative++;
            }
        lflare_destroy(b.flare);
    }
    print_message("pentagons: %d upright, %d turned, %d left out; corners within %.1e of the radius\n", positive, negative, left_out, worst);
    assert_true(positive >= 100 && negative >= 100);
    assert_true(left_out * 5 < positive + negative);
}

/* The same in the picture, which is the sensor turned by 180 degrees: towards a vertex lit at 0.9 of the radius, opposite
   to it, towards the middle of a blade at 0.81, dark. */
static void pentagon_picture(void **state)
{
    enum { SIZE = 200 };
    static float pixels[SIZE * SIZE * 4];
    int l, positive = 0, negative = 0;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings settings;
        bench b;
        int32_t g, k, corner;
        memset(&settings, 0, sizeof settings);
        load(lenses.path[l]);
        settings.raw = 1;
        settings.no_starburst = settings.no_ringing = 1;
        settings.blades = 5;
        settings.blade_rotation = 0.3f;
        settings.fnumber = lens.fnumber * 3;
        bench_open(&b, lenses.path[l], &settings);
        for (g = 0; g < b.tables.ghost_count; g += 1 + b.tables.ghost_count / 12) {
            lflare_override *hidden = (lflare_override *)calloc((size_t)b.tables.ghost_count, sizeof *hidden);
            lflare_pair pair = b.tables.pairs[g];
            lflare_ghost_matrices m;
            lflare_view view;
            lflare_light light;
            lflare_image image;
            double u = 0.004, size, ma, vx, vy;
            int32_t j, n = 0;
            assert_non_null(hidden);
            assert_int_equal(lflare_ghost_optics(&lens, 510, &pair, 1, &m), LFLARE_OK);
            ma = m.ma.a;
            size = fabs(m.m.a / ma) * (double)b.tables.iris.radius;
            /* the iris alone bounds it, and it keeps its own size */
            if (lflare_ghost_clip(&lens, 510, pair, (double)b.tables.iris.radius, u, NULL) != LFLARE_CLIP_IRIS ||
                fabs(m.m.a) * (double)b.tables.iris.radius / fabs(ma) < 0.5 || size / lens.efl > 5 || size < 100 * 0.61e-6 * 510 * fabs(m.m.b) / (double)b.tables.iris.radius * fabs(ma)) {
                free(hidden);
                continue;
            }
            for (j = 0; j < b.tables.ghost_count; j++)
                if (j != g) {
                    hidden[n].first = b.tables.pairs[j].first + 1;
                    hidden[n].second = b.tables.pairs[j].second + 1;
                    hidden[n++].hide = 1;
                }
            settings.overrides = hidden;
            settings.override_count = n;
            assert_int_equal(lflare_configure(b.flare, &settings, NULL), LFLARE_OK);
            memset(&view, 0, sizeof view);
            memset(&light, 0, sizeof light);
            memset(&image, 0, sizeof image);
            memset(pixels, 0, sizeof pixels);
            view.width = view.height = SIZE;
            view.fit = LFLARE_FIT_PHYSICAL;
            view.fov_y = (float)(2 * atan(1.6 * size / lens.efl));
            light.direction[0] = (float)(0.6 * u);
            light.direction[1] = (float)(0.8 * u);
            light.direction[2] = -1;
            light.color[0] = light.color[1] = light.color[2] = 1;
            image.pixels = pixels;
            image.width = image.height = SIZE;
            /* the iris's centre lands at Bs / Ma11 u on the sensor; the view's middle goes there */
            vx = -m.ms.b / ma * -0.6 * u;
            vy = -m.ms.b / ma * -0.8 * u;
            view.centre[0] = (float)(-vx / (1.6 * size));
            view.centre[1] = (float)(-vy / (1.6 * size));
            assert_int_equal(lflare_frame(b.flare, &view, &light, 1), LFLARE_OK);
            assert_int_equal(lflare_render(b.flare, &image), LFLARE_OK);
            for (k = 1; k < 2; k++)
                for (corner = 0; corner < 5; corner++) {
                    double angle = (double)0.3f + 2 * PI * corner / 5, scale = m.m.a / ma * (double)b.tables.iris.radius / (1.6 * size) * (0.5 * SIZE), lit, dark, middle;
                    double px = -cos(angle) * scale, py = -sin(angle) * scale; /* pixels right and up of the middle */
                    lit = (double)pixels[((int)floor(0.5 * SIZE - 0.9 * py) * SIZE + (int)floor(0.5 * SIZE + 0.9 * px)) * 4 + k];
                    dark = (double)pixels[((int)floor(0.5 * SIZE + 0.9 * py) * SIZE + (int)floor(0.5 * SIZE - 0.9 * px)) * 4 + k];
                    middle = (double)pixels[(SIZE / 2 * SIZE + SIZE / 2) * 4 + k];
                    assert_true(middle > 0);
                    if (!(lit > 0.99 * middle)) fail_msg("%s: ghost (%d,%d) vertex %d is dark", lenses.path[l], (int)pair.first + 1, (int)pair.second + 1, (int)corner);
                    if (!(dark < 0.01 * middle))
                        fail_msg("%s: ghost (%d,%d) is lit opposite vertex %d", lenses.path[l], (int)pair.first + 1, (int)pair.second + 1, (int)corner);
                }
            if (m.m.a / ma > 0) positive++;
            else negative++;
            free(hidden);
        }
        lflare_destroy(b.flare);
    }
    print_message("pentagons in the picture: %d upright, %d turned\n", positive, negative);
    assert_true(positive >= 5 && negative >= 5);
}

/* ---- films ---- */

static void films_random(void **state)
{
    oracle_random r = {1};
    int i, k, total = 0, evanescent = 0;
    double worst = 0, worst_turned = 0;
    (void)state;
    for (i = 0; i < 20000; i++) {
        lflare_layer layers[12], turned[12];
        int count = (int)(oracle_unit(&r) * 13), buried = 0;
        double n0 = oracle_between(&r, 1, 2.1), n1 = oracle_between(&r, 1, 2.1), nm = oracle_between(&r, 380, 780), s, ours, back;
        if (i % 3 == 0) n0 = 1;
        for (k = 0; k < count; k++) {
            layers[k].n = oracle_between(&r, 1.3, 2.5);
            layers[k].thickness_nm = oracle_between(&r, 10, 400);
        }
        s = fmin(n0, n1) * sin(oracle_between(&r, 0, 0.4999 * PI)); /* below the critical angle */
        if (i % 50 == 0) s = 0;
        for (k = 0; k < count; k++) {
            turned[k] = layers[count - 1 - k];
            buried |= layers[k].n < s;
        }
        evanescent += buried;
        ours = lflare_film_reflectance(n0, n1, count ? layers : NULL, count, nm, s);
        back = lflare_film_reflectance(n1, n0, count ? turned : NULL, count, nm, s);
        worst = fmax(worst, fabs(ours - oracle_film(n0, n1, layers, count, nm, s)));
        worst_turned = fmax(worst_turned, fabs(ours - back));
        if (n0 > n1) { /* total reflection */
            s = oracle_between(&r, n1, n0);
            assert_true(lflare_film_reflectance(n0, n1, layers, count, nm, s) == 1);
            worst = fmax(worst, fabs(1 - oracle_film(n0, n1, layers, count, nm, s)));
            total++;
        }
    }
    print_message("20000 films: within %.1e of the oracle, %.1e of the turned stack; %d totally reflecting, %d with an evanescent layer\n", worst,
                  worst_turned, total, evanescent);
    assert_true(total > 1000 && evanescent > 100);
    assert_true(worst < 1e-9);
    assert_true(worst_turned < 1e-9);
}

/* The footprint that the tables describe at one wavelength. */
static lflare_region table_region(const lflare_tables *t, int32_t g, int32_t k, double u)
{
    const float *head = t->head + g * LFLARE_HEAD_FLOATS, *rims = t->rims + g * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS;
    lflare_circle c[2 + LFLARE_MAX_RIMS];
    double entrance = (double)t->entrance_radius;
    int32_t i, count = 2 + (int32_t)head[14];
    c[0].centre = 0;
    c[0].radius = entrance;
    for (i = 1; i < count; i++) { /* the iris, then the rims; near a = 0 a large circle stands for a straight edge */
        const float *row = i == 1 ? head + 4 * k : rims + (i - 2) * LFLARE_RIM_FLOATS + 4 * k;
        double h = i == 1 ? (double)t->iris.radius : (double)row[2], a = fmax(fabs((double)row[0]), 1e-4 * h / entrance);
        c[i].centre = -(double)row[1] / (row[0] < 0 ? -a : a);
        c[i].radius = h / a;
    }
    return lflare_region_of(c, count, u, NULL);
}

/* A ghost's colour in the tables against an exact product of the oracle's films along the paraxial ray through the
   footprint's centroid. */
static void film_tables(void **state)
{
    int l, tested = 0, over = 0;
    double worst = 0;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings settings;
        bench b;
        int32_t g, k, j;
        double worst_here = 0;
        memset(&settings, 0, sizeof settings);
        load(lenses.path[l]);
        settings.fnumber = 8;
        bench_open(&b, lenses.path[l], &settings);
        for (k = 0; k < 3; k++) {
            static const double nm[3] = {650, 510, 475};
            oracle_lens o;
            oracle_lens_make(&o, &lens.prescription, nm[k]);
            for (g = 0; g < b.tables.ghost_count; g++) {
                oracle_step steps[ORACLE_STEPS];
                oracle_matrix at[ORACLE_STEPS + 1];
                int n = oracle_path(&o, b.tables.pairs[g].first, b.tables.pairs[g].second, steps);
                oracle_paraxial(&o, steps, n, at);
                double most = 0;
                for (j = 0; j < LFLARE_FIELD_SAMPLES; j++) most = fmax(most, (double)b.tables.field[(g * LFLARE_FIELD_SAMPLES + j) * LFLARE_FIELD_FLOATS + k]);
                for (j = 0; j < LFLARE_FIELD_SAMPLES; j++) {
                    lflare_region region;
                    const float *row = b.tables.field + (g * LFLARE_FIELD_SAMPLES + j) * LFLARE_FIELD_FLOATS;
                    double angle = (double)b.tables.style[g * LFLARE_STYLE_FLOATS + 6] * j / (LFLARE_FIELD_SAMPLES - 1), u = tan(angle), w, error;
                    if (angle > 60 * PI / 180) continue; /* no light is seen there */
                    region = table_region(&b.tables, g, k, u);
                    if (region.area <= 0) continue; /* dark at this wavelength */
                    w = oracle_weight(&o, steps, n, at, region.centroid, u);
                    error = fabs((double)row[k] - w) / fmax(w, 1e-3 * most);
                    if (w < 1e-12 && (double)row[k] < 1e-12) error = 0;
                    tested++;
                    over += error > 0.01;
                    if (error > worst_here) worst_here = error;
                    if (error > 0.01 && over < 20)
                        print_error("%s: ghost (%d,%d) channel %d at %.2f degrees: table %g, exact %g\n", lenses.path[l],
                                    (int)b.tables.pairs[g].first + 1, (int)b.tables.pairs[g].second + 1, (int)k, angle * 180 / PI, (double)row[k], w);
                }
            }
        }
        print_message("    %s: worst %.2e\n", lenses.path[l], worst_here);
        worst = fmax(worst, worst_here);
        lflare_destroy(b.flare);
    }
    print_message("film tables: %d colours, worst %.2e, %d over 1 %%\n", tested, worst, over);
    assert_true(tested > 10000);
    assert_int_equal(over, 0);
}

/* ---- regions ---- */

static int inside_all(const lflare_circle *c, int count, double u, double x, double y, int but, int but_too)
{
    int i;
    for (i = 0; i < count; i++)
        if (i != but && i != but_too && hypot(x - c[i].centre * u, y) > c[i].radius) return 0;
    return 1;
}

/* Area and first moment summed over thin slices; arcs by walking each circle; and with the corners, found as crossings of
   two circles inside all the others, the outline turns by 2 pi. */
static void regions(void **state)
{
    oracle_random r = {7};
    int i, k, j, filled = 0, empty = 0, corners = 0;
    double worst_area = 0, worst_centroid = 0, worst_turn = 0, worst_sum = 0;
    (void)state;
    for (i = 0; i < 1500; i++) {
        enum { SLICES = 4000, WALK = 4000 };
        lflare_circle c[8];
        int count = 1 + (int)(oracle_unit(&r) * 8), s;
        double u = i % 10 == 0 ? 0 : oracle_between(&r, 0, 0.6), turn[8], lo = -1e9, hi = 1e9, area = 0, moment = 0, smallest = 1e9, sum = 0;
        lflare_region region;
        for (k = 0; k < count; k++) {
            c[k].centre = oracle_between(&r, -30, 30);
            c[k].radius = oracle_between(&r, 3, 25);
            lo = fmax(lo, c[k].centre * u - c[k].radius);
            hi = fmin(hi, c[k].centre * u + c[k].radius);
            smallest = fmin(smallest, c[k].radius);
        }
        region = lflare_region_of(c, count, u, turn);
        if (lo >= hi) {
            empty++;
            assert_true(region.area == 0);
            continue;
        }
        for (s = 0; s < SLICES; s++) { /* closer towards the ends, where the outline is steep */
            double t = (s + 0.5) / SLICES * PI, x = 0.5 * (lo + hi) - 0.5 * (hi - lo) * cos(t), dx = 0.5 * (hi - lo) * sin(t) * PI / SLICES, y = 1e9;
            for (k = 0; k < count; k++) y = fmin(y, sqrt(fmax(0, c[k].radius * c[k].radius - (x - c[k].centre * u) * (x - c[k].centre * u))));
            area += 2 * y * dx;
            moment += 2 * y * dx * x;
        }
        if (area < 1e-6) continue; /* they touch */
        filled++;
        worst_area = fmax(worst_area, fabs(region.area - area) / area);
        worst_centroid = fmax(worst_centroid, fabs(region.centroid - moment / area) / (hi - lo));
        assert_true(fabs(region.lo - lo) < 1e-9 && fabs(region.hi - hi) < 1e-9);
        for (k = 0; k < count; k++) {
            int lit = 0;
            for (s = 0; s < WALK; s++) {
                double angle = 2 * PI * (s + 0.5) / WALK;
                lit += inside_all(c, count, u, c[k].centre * u + c[k].radius * cos(angle), c[k].radius * sin(angle), k, k);
            }
            assert_true(turn[k] >= 0);
            worst_turn = fmax(worst_turn, fabs(turn[k] - 2 * PI * lit / WALK));
            sum += turn[k];
            for (j = 0; j < k; j++) { /* corners */
                double a = c[j].centre * u, d = c[k].centre * u - a, x, y2;
                if (d == 0) continue;
                x = (d * d + c[j].radius * c[j].radius - c[k].radius * c[k].radius) / (2 * d);
                y2 = c[j].radius * c[j].radius - x * x;
                if (y2 <= 0 || !inside_all(c, count, u, a + x, sqrt(y2), j, k)) continue;
                sum += 2 * acos(fmin(1, fmax(-1, (x * (x - d) + y2) / (c[j].radius * c[k].radius)))); /* between the normals, above and below */
                corners += 2;
            }
        }
        worst_sum = fmax(worst_sum, fabs(sum - 2 * PI));
    }
    print_message("%d regions, %d empty, %d corners: area %.1e, centroid %.1e, arcs %.1e, whole turn %.1e\n", filled, empty, corners, worst_area,
                  worst_centroid, worst_turn, worst_sum);
    assert_true(filled > 500 && empty > 50 && corners > 500);
    assert_true(worst_area < 2e-6);
    assert_true(worst_centroid < 2e-6);
    assert_true(worst_turn < 4.1 * 2 * PI / 4000); /* up to two arcs, four ends, each found to within a step */
    assert_true(worst_sum < 1e-6);
}

/* ---- glass ---- */

static void glass(void **state)
{
    static const char text[] =
        "lensflare 1\n"
        "50 5 sellmeier 1.03961212 0.231792344 1.01046945 0.00600069867 0.0200179144 103.560653\n"
        "stop 1\n"
        "-50 5 nd 1.6511 vd 58.6\n"
        "-60 5 cauchy 1.5 0.004215 0.0001\n"
        "-70 5 cauchy 1.5 0.004215\n"
        "-80 5 n 1.7\n"
        "-90 50 air\n";
    static lflare_prescription p;
    const lflare_medium *bk7, *abbe, *cauchy, *two, *constant, *air;
    double vd;
    (void)state;
    assert_int_equal(lflare_text_read(text, sizeof text - 1, &p, NULL), LFLARE_OK);
    bk7 = &p.surfaces[0].medium;
    abbe = &p.surfaces[2].medium;
    cauchy = &p.surfaces[3].medium;
    two = &p.surfaces[4].medium;
    constant = &p.surfaces[5].medium;
    air = &p.surfaces[6].medium;
    /* Schott's catalogue of N-BK7: n_d, n_F, n_C, n_g, n_r, V_d */
    assert_true(fabs(lflare_index(bk7, 587.5618) - 1.51680) < 5e-6);
    assert_true(fabs(lflare_index(bk7, 486.1327) - 1.52238) < 5e-6);
    assert_true(fabs(lflare_index(bk7, 656.2725) - 1.51432) < 5e-6);
    assert_true(fabs(lflare_index(bk7, 435.8343) - 1.52668) < 5e-6);
    assert_true(fabs(lflare_index(bk7, 706.5188) - 1.51289) < 5e-6);
    vd = (lflare_index(bk7, 587.5618) - 1) / (lflare_index(bk7, 486.1327) - lflare_index(bk7, 656.2725));
    assert_true(fabs(vd - 64.17) < 5e-3);
    /* n_d as given, n_F - n_C = 0.6511 / 58.6 = 0.01111092, and a straight line over 1 / l^2: B = 0.01111092 / (4.2314929 - 2.3218223) =
       0.005818233 um^2, so n(510) = 1.6511 + 0.005818233 (3.8446751 - 2.8966345) = 1.6566159 */
    assert_true(fabs(lflare_index(abbe, 587.5618) - 1.6511) < 1e-12);
    assert_true(fabs(lflare_index(abbe, 486.1327) - lflare_index(abbe, 656.2725) - 0.011110922) < 1e-9);
    assert_true(fabs(lflare_index(abbe, 510) - 1.6566159) < 2e-7);
    /* at 500 nm 1 / l^2 = 4, 1 / l^4 = 16 */
    assert_true(fabs(lflare_index(cauchy, 500) - (1.5 + 0.01686 + 0.0016)) < 1e-12);
    assert_true(fabs(lflare_index(two, 500) - 1.51686) < 1e-12);
    assert_true(lflare_index(constant, 400) == 1.7 && lflare_index(constant, 700) == 1.7);
    assert_true(lflare_index(air, 400) == 1 && lflare_index(air, 700) == 1);
}

/* The catalogue's own n_d and V_d from its coefficients. */
static void glass_catalogue(void **state)
{
    char *text = oracle_read("../shared/data/glasses.csv"), *line;
    int count = 0, off = 0;
    (void)state;
    if (text == NULL) {
        print_message("../shared/data/glasses.csv is not there\n");
        skip();
    }
    for (line = strchr(text, '\n'); line != NULL && line[1] != 0; line = strchr(line + 1, '\n')) {
        lflare_medium m;
        double nd, vd, ours;
        char glass_name[32];
        memset(&m, 0, sizeof m);
        m.kind = LFLARE_MEDIUM_SELLMEIER;
        if (sscanf(line + 1, "%31[^,],%*[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", glass_name, &nd, &vd, &m.c[0], &m.c[1], &m.c[2], &m.c[3], &m.c[4], &m.c[5]) != 9) continue;
        count++;
        ours = lflare_index(&m, 587.5618);
        off += fabs(ours - nd) > 1e-6 || fabs((ours - 1) / (lflare_index(&m, 486.1327) - lflare_index(&m, 656.2725)) - vd) > 1e-3;
    }
    print_message("%d glasses, %d whose n_d or V_d differs\n", count, off);
    assert_true(count > 600);
    assert_int_equal(off, 0);
    free(text);
}

/* ---- degenerate lenses ---- */

static void all_finite(const float *v, size_t count, const char *what)
{
    size_t i;
    for (i = 0; i < count; i++)
        if (!isfinite(v[i])) fail_msg("%s [%d] is not finite", what, (int)i);
}

static void degenerate(void **state)
{
    static const struct {
        const char *what, *text;
        int ghosts;
    } odd[] = {
        {"stop first", "lensflare 1\nfnumber 8\nstop 5\n50 4 n 1.6\n-80 focus\n", 1},
        {"stop first, touching", "lensflare 1\nfnumber 8\nstop 0\n50 4 n 1.6\n-80 focus\n", 1},
        {"stop last", "lensflare 1\nfnumber 8\n50 4 n 1.6\n-80 5\nstop focus\n", 1},
        {"stop last, touching the sensor", "lensflare 1\nfnumber 8\n50 4 n 1.6\n-80 5\nstop 0\n", 1},
        {"stop in the middle of one element", "lensflare 1\nfnumber 8\n50 4 n 1.6\nstop 4\n-80 focus\n", 0},
        {"biconvex", "lensflare 1\nfnumber 2\n60 6 n 1.5\n-60 2\nstop focus semi 10\n", 1},
        {"ball and plane window", "lensflare 1\nfnumber 4\n20 40 n 1.5\n-20 1\nflat 1 n 1.5\nflat 1\nstop focus\n", 6},
        {"without an index step", "lensflare 1\nfnumber 4\n20 4 n 1.5\nstop 1\n-20 2 n 1.5\n30 2 n 1.5\n-50 focus\n", 0},
    };
    size_t i;
    (void)state;
    for (i = 0; i < sizeof odd / sizeof odd[0]; i++) {
        lflare_desc desc;
        lflare_error error;
        lflare *flare = NULL;
        const lflare_tables *t;
        lflare_view view;
        lflare_light light;
        int angle;
        memset(&desc, 0, sizeof desc);
        memset(&view, 0, sizeof view);
        memset(&light, 0, sizeof light);
        desc.text = odd[i].text;
        desc.text_size = strlen(odd[i].text);
        if (lflare_create(&desc, &flare, &error) < 0) fail_msg("%s: %s", odd[i].what, error.text);
        t = lflare_get_tables(flare);
        if (t->ghost_count != odd[i].ghosts) fail_msg("%s: %d ghosts", odd[i].what, (int)t->ghost_count);
        assert_true(isfinite(lflare_get_lens(flare)->efl) && lflare_get_lens(flare)->efl > 0 && isfinite(lflare_get_lens(flare)->bfd));
        all_finite(t->head, (size_t)t->ghost_count * LFLARE_HEAD_FLOATS, odd[i].what);
        all_finite(t->rims, (size_t)t->ghost_count * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS, odd[i].what);
        all_finite(t->film, (size_t)t->surface_count * LFLARE_FILM_SAMPLES * 4, odd[i].what);
        all_finite(t->index, (size_t)t->surface_count * 4, odd[i].what);
        all_finite(t->field, (size_t)t->ghost_count * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS, odd[i].what);
        all_finite(t->style, (size_t)t->ghost_count * LFLARE_STYLE_FLOATS, odd[i].what);
        all_finite(&t->exposure, 1, odd[i].what);
        view.width = 64;
        view.height = 48;
        for (angle = 0; angle < 89; angle += 4) {
            static float pixels[64 * 48 * 4];
            lflare_image image;
            memset(&image, 0, sizeof image);
            memset(pixels, 0, sizeof pixels);
            image.pixels = pixels;
            image.width = 64;
            image.height = 48;
            light.direction[0] = (float)tan(angle * PI / 180);
            light.direction[2] = -1;
            light.color[0] = light.color[1] = light.color[2] = 1;
            assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
            assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
            all_finite(pixels, sizeof pixels / sizeof pixels[0], odd[i].what);
        }
        lflare_destroy(flare);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(golden_heliar),    cmocka_unit_test(golden_canon),     cmocka_unit_test(golden_films), cmocka_unit_test(matrices_agree),
        cmocka_unit_test(error_is_cubic),   cmocka_unit_test(pentagon_corners), cmocka_unit_test(pentagon_picture), cmocka_unit_test(films_random),
        cmocka_unit_test(film_tables),      cmocka_unit_test(regions),          cmocka_unit_test(glass),        cmocka_unit_test(glass_catalogue),
        cmocka_unit_test(degenerate),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
