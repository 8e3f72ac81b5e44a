/* The room "trace": exact rays against those of the tests' own physics, and against lenses whose exact answer is known. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "oracle.h"

static oracle_lenses lenses;
static lflare_lens lens;
static lflare_path path;

static int setup(void **state)
{
    (void)state;
    oracle_lenses_find(&lenses);
    return lenses.count < 10;
}

static double reach_of(const lflare_lens *l) { return 1.1 * l->prescription.surfaces[0].semi_diameter; }

/* One random ray of a ghost in both tracers; returns 1 if it arrives. */
static int compare_ray(const oracle_lens *o, lflare_pair pair, oracle_random *random, double *worst, double *worst_hit, double *worst_weight)
{
    oracle_step steps[ORACLE_STEPS];
    lflare_hit hits[LFLARE_MAX_STEPS];
    lflare_layer layers[LFLARE_MAX_LAYERS];
    oracle_ray exact;
    lflare_ray ray;
    double reach = reach_of(&lens), turn = oracle_between(random, 0, 6.28), tilt = tan(oracle_between(random, 0, 0.5));
    double at[2] = {oracle_between(random, -reach, reach), oracle_between(random, -reach, reach)}, slope[2] = {tilt * cos(turn), tilt * sin(turn)};
    long double at_l[2] = {(long double)at[0], (long double)at[1]}, slope_l[2] = {(long double)slope[0], (long double)slope[1]};
    int count = oracle_path(o, pair.first, pair.second, steps), arrives, i, k;
    double weight = 1, far;
    lflare_fate fate = lflare_path_trace(&path, at, slope, &ray, hits);
    arrives = oracle_trace(o, steps, count, at_l, slope_l, &exact);
    assert_int_equal(arrives, fate == LFLARE_RAY_ARRIVES);
    if (!arrives) return 0;
    assert_int_equal(ray.steps, count);
    far = 1 + hypot(ray.sensor[0], ray.sensor[1]);
    for (k = 0; k < 2; k++) {
        *worst = fmax(*worst, fabs(ray.sensor[k] - (double)exact.sensor[k]) / (far * far)); /* grazing rays: errors grow with distance, twice */
        *worst_hit = fmax(*worst_hit, fabs(ray.stop[k] - (double)exact.stop[k]));
    }
    for (i = 0; i < count; i++) {
        int s = steps[i].surface, used = oracle_layers(o->p, s, layers);
        double semi = o->p->surfaces[s].semi_diameter, n1 = (double)o->n[s + steps[i].backwards], n2 = (double)o->n[s + 1 - steps[i].backwards], film;
        lflare_layer turned[LFLARE_MAX_LAYERS];
        assert_int_equal(hits[i].surface, s);
        assert_int_equal(hits[i].reflected, steps[i].reflects);
        *worst_hit = fmax(*worst_hit, fabs(hypot(hits[i].position[0], hits[i].position[1]) - (double)exact.height[i]));
        *worst_hit = fmax(*worst_hit, fabs(hits[i].relative * semi - (double)exact.height[i]));
        if (s != o->stop) assert_true(ray.relative >= hits[i].relative);
        if (s == o->stop || (n1 == n2 && used == 0)) continue;
        for (k = 0; k < used; k++) turned[k] = layers[steps[i].backwards ? used - 1 - k : k];
        film = oracle_film(n1, n2, turned, used, o->nm, n1 * sqrt(fmax(0, 1 - (double)(exact.cosine[i] * exact.cosine[i]))));
        weight *= steps[i].reflects ? film : 1 - film;
    }
    *worst_weight = fmax(*worst_weight, fabs(ray.weight - weight) / (weight + 1e-12));
    return 1;
}

static void rays_equal_the_oracle(void **state)
{
    oracle_random random = {1};
    long arrived = 0, traced = 0;
    double worst = 0, worst_hit = 0, worst_weight = 0;
    int l, i;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        lflare_pair *pairs;
        int32_t count, g;
        assert_true(oracle_lens_load(lenses.path[l], &lens));
        count = lens.ghost_count;
        pairs = (lflare_pair *)malloc(sizeof *pairs * (size_t)count);
        lflare_ghost_list(&lens, pairs, &count);
        for (g = 0; g < count; g++) {
            double nm = oracle_between(&random, 400, 700);
            oracle_lens o;
            oracle_lens_make(&o, &lens.prescription, nm);
            assert_int_equal(lflare_path_make(&lens, nm, &pairs[g], &path), LFLARE_OK);
            for (i = 0; i < 20; i++, traced++) arrived += compare_ray(&o, pairs[g], &random, &worst, &worst_hit, &worst_weight);
        }
        free(pairs);
    }
    print_message("%ld rays, %ld arrive; worst on the sensor %.2e mm per (1 + distance in mm)^2, at a surface or the stop %.2e mm, weight %.2e\n", traced, arrived, worst,
                  worst_hit, worst_weight);
    assert_true(arrived > traced / 20);
    assert_true(worst < 1e-9 && worst_hit < 1e-9 && worst_weight < 1e-7);
}

/* Rays that a picture can show: the plain 1e-9 mm. */
static void rays_in_the_picture(void **state)
{
    oracle_random random = {7};
    double worst = 0;
    long shown = 0;
    int l, i;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        int32_t count = 0, g;
        lflare_pair pairs[512];
        assert_true(oracle_lens_load(lenses.path[l], &lens));
        count = 512;
        lflare_ghost_list(&lens, pairs, &count);
        for (g = 0; g < count; g++) {
            oracle_lens o;
            oracle_step steps[ORACLE_STEPS];
            int n;
            oracle_lens_make(&o, &lens.prescription, 510);
            n = oracle_path(&o, pairs[g].first, pairs[g].second, steps);
            lflare_path_make(&lens, 510, &pairs[g], &path);
            path.unweighted = 1;
            for (i = 0; i < 60; i++) {
                double reach = reach_of(&lens), at[2] = {oracle_between(&random, -reach, reach), oracle_between(&random, -reach, reach)};
                double slope[2] = {oracle_between(&random, -0.3, 0.3), oracle_between(&random, -0.3, 0.3)};
                long double at_l[2] = {(long double)at[0], (long double)at[1]}, slope_l[2] = {(long double)slope[0], (long double)slope[1]};
                oracle_ray exact;
                lflare_ray ray;
                if (lflare_path_trace(&path, at, slope, &ray, NULL) != LFLARE_RAY_ARRIVES || ray.relative > 1) continue;
                if (fabs(ray.sensor[0]) > lens.sensor_width || fabs(ray.sensor[1]) > lens.sensor_height) continue;
                shown++;
                assert_true(ray.weight == 0);
                assert_true(oracle_trace(&o, steps, n, at_l, slope_l, &exact));
                worst = fmax(worst, hypot(ray.sensor[0] - (double)exact.sensor[0], ray.sensor[1] - (double)exact.sensor[1]));
            }
        }
    }
    print_message("%ld rays that pass and land near the frame: worst %.2e mm\n", shown, worst);
    assert_true(shown > 2000 && worst < 1e-9);
}

/* A prescription of a few rows, made ready. */
static void make_lens(const char *text)
{
    lflare_prescription *p = (lflare_prescription *)malloc(sizeof *p);
    lflare_error error;
    if (lflare_text_read(text, strlen(text), p, &error) != LFLARE_OK || lflare_lens_derive(p, &lens, &error) != LFLARE_OK) fail_msg("%d: %s", (int)error.line, error.text);
    free(p);
}

/* Rays parallel to the axis all cross in one point behind a convex hyperboloid of glass with conic -n^2 (Descartes). */
static void hyperboloid_is_stigmatic(void **state)
{
    double height, worst = 0;
    (void)state;
    make_lens("lensflare 1\nfnumber 2\nstop 1 semi 20\nflat 10 n 1.5 semi 30\n-25 50 air semi 30 conic -2.25\n"); /* focal length 25 / 0.5 */
    assert_int_equal(lflare_path_make(&lens, 550, NULL, &path), LFLARE_OK);
    for (height = 0.5; height < 25; height += 0.5) {
        const double at[2] = {0.6 * height, 0.8 * height}, slope[2] = {0, 0};
        lflare_ray ray;
        assert_int_equal(lflare_path_trace(&path, at, slope, &ray, NULL), LFLARE_RAY_ARRIVES);
        worst = fmax(worst, hypot(ray.sensor[0], ray.sensor[1]));
    }
    print_message("hyperboloid: all rays within %.1e mm of the focus\n", worst);
    assert_true(worst < 1e-11);
}

/* A conic written out as a power series up to r^16 bends rays like the conic itself. */
static void series_equals_conic(void **state)
{
    static const char *const forms[2] = {
        "lensflare 1\nfnumber 2\nstop 1 semi 20\nflat 10 n 1.5 semi 15\n-50 50 air semi 15 conic -1\n",      /* a paraboloid is r^2 / 2R alone */
        "lensflare 1\nfnumber 2\nstop 1 semi 20\nflat 10 n 1.5 semi 15\nflat 50 air semi 15 asphere 2:-0.01\n"};
    double sensors[2][2];
    int form;
    (void)state;
    for (form = 0; form < 2; form++) {
        const double at[2] = {9, -7}, slope[2] = {0.1, 0.2};
        lflare_ray ray;
        make_lens(forms[form]);
        lflare_path_make(&lens, 550, NULL, &path);
        assert_int_equal(lflare_path_trace(&path, at, slope, &ray, NULL), LFLARE_RAY_ARRIVES);
        sensors[form][0] = ray.sensor[0];
        sensors[form][1] = ray.sensor[1];
    }
    assert_true(hypot(sensors[0][0] - sensors[1][0], sensors[0][1] - sensors[1][1]) < 1e-10);
}

/* A sphere as conic plus a series that cancels: the polynomial's branch against the closed form. */
static void polynomial_branch(void **state)
{
    double sensors[2][2];
    int form;
    (void)state;
    for (form = 0; form < 2; form++) {
        const double at[2] = {4, -3}, slope[2] = {0.05, 0.1};
        lflare_pair pair = {2, 1, 0, 0};
        lflare_ray ray;
        make_lens("lensflare 1\nfnumber 4\nstop 1 semi 8\n40 6 n 1.6 semi 12\n-60 50 air semi 12\n");
        if (form == 1) lens.prescription.surfaces[1].aspheric[7] = 1e-300; /* a term that changes nothing */
        lflare_path_make(&lens, 550, &pair, &path);
        assert_int_equal(lflare_path_trace(&path, at, slope, &ray, NULL), LFLARE_RAY_ARRIVES);
        sensors[form][0] = ray.sensor[0];
        sensors[form][1] = ray.sensor[1];
    }
    assert_true(hypot(sensors[0][0] - sensors[1][0], sensors[0][1] - sensors[1][1]) < 1e-10);
}

static void hard_cases(void **state)
{
    const double origin[2] = {0, 0}, wide[2] = {9, 0}, steep[2] = {0, 1.7320508}, along[2] = {0, 0};
    lflare_pair pair = {2, 1, 0, 0}, wrong = {1, 2, 0, 0}, across = {3, 1, 0, 0};
    lflare_ray ray;
    lflare_hit hits[LFLARE_MAX_STEPS];
    (void)state;
    /* a plane-parallel plate: both reflections return the ray in its own direction, three plate crossings further out */
    make_lens("lensflare 1\nfnumber 4\nstop 1 semi 8\nflat 6 n 1.5 semi 50\nflat 3 air semi 50\n400 3 n 1.6 semi 50\n-800 60 air semi 50\n");
    assert_int_equal(lflare_path_make(&lens, 550, &pair, &path), LFLARE_OK);
    assert_int_equal(lflare_path_trace(&path, origin, steep, &ray, hits), LFLARE_RAY_ARRIVES);
    assert_true(fabs(hits[ray.steps - 3].position[1] - (steep[1] + 3 * 6 * tan(asin(sin(1.0471975512) / 1.5)))) < 1e-6);
    assert_true(fabs(hits[ray.steps - 3].direction[1] - sin(1.0471975512)) < 1e-9);
    /* total reflection inside, a missed sphere, past the equator */
    make_lens("lensflare 1\nfnumber 4\nstop 1 semi 8\nflat 12 n 1.7 semi 12\n-10 50 air semi 9.9\n");
    lflare_path_make(&lens, 550, NULL, &path);
    assert_int_equal(lflare_path_trace(&path, wide, along, &ray, hits), LFLARE_RAY_TOTAL);
    assert_int_equal(ray.steps, 2);
    assert_true(ray.fate == LFLARE_RAY_TOTAL);
    {
        const double outside[2] = {10.5, 0};
        assert_int_equal(lflare_path_trace(&path, outside, along, &ray, NULL), LFLARE_RAY_MISSES);
        assert_int_equal(ray.steps, 2);
    }
    /* arguments */
    assert_int_equal(lflare_path_make(NULL, 550, NULL, &path), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_path_make(&lens, 0, NULL, &path), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_path_make(&lens, 550, &wrong, &path), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_path_make(&lens, 550, &across, &path), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_path_make(&lens, 550, NULL, NULL), LFLARE_ERROR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_equal_the_oracle),
        cmocka_unit_test(rays_in_the_picture),
        cmocka_unit_test(hyperboloid_is_stigmatic),
        cmocka_unit_test(series_equals_conic),
        cmocka_unit_test(polynomial_branch),
        cmocka_unit_test(hard_cases),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
