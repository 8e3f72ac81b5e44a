/* The rooms "aberration" and what is made of it: fits against exact rays, what is no fit, memory, models, and the pictures of
   meshes, of ordinary lenses and of lenses made to be hard. Run from the root of the repository. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "examples/reference.h"
#include "oracle.h"

#define DEGREE (3.14159265358979323846 / 180)

/* ---- lenses ---- */

/* Limits of what a fit may err by: median and 95th percentile. */
typedef struct limits {
    double sensor[2];  /* pixels of a picture 1280 wide */
    double stop[2];    /* radii of the open stop */
    double weight[2];  /* shares of the exact weight */
} limits;

typedef struct subject {
    const char *path;
    char *text;
    lflare_lens lens;
    void *fit;
    size_t size;
} subject;

enum { HELIAR, DISTAGON, NIKON, SUBJECTS };

static subject subjects[SUBJECTS];

static const char *const paths[SUBJECTS] = {"lenses/heliar-tronnier.lens", "lenses/distagon-25.lens", "lenses/nikon-80-200-mid.lens"};

static const limits allowed[SUBJECTS] = {
    {{0.085, 0.5}, {3.3e-5, 2.2e-4}, {2.5e-4, 3.6e-3}},
    {{0.17, 1.1}, {1.8e-4, 1.3e-3}, {2.4e-4, 4.5e-3}},
    {{0.1, 1.5}, {1.3e-4, 2.8e-3}, {2.8e-4, 2.9e-2}},
};

static int open_subjects(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < SUBJECTS; i++) {
        subject *s = &subjects[i];
        lflare_error error;
        s->path = paths[i];
        s->text = oracle_read(s->path);
        if (s->text == NULL || !oracle_lens_load(s->path, &s->lens)) return 1;
        if (lflare_aberration_fit(&s->lens, NULL, &s->fit, &s->size, &error) != LFLARE_OK) return 1;
    }
    return 0;
}

static int close_subjects(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < SUBJECTS; i++) {
        free(subjects[i].text);
        free(subjects[i].fit);
    }
    return 0;
}

static lflare_pair *ghosts_of(const lflare_lens *lens)
{
    int32_t count = lens->ghost_count;
    lflare_pair *pairs = (lflare_pair *)malloc(sizeof *pairs * ((size_t)count + 1));
    assert_non_null(pairs);
    assert_int_equal(lflare_ghost_list(lens, pairs, &count), LFLARE_OK);
    return pairs;
}

static const double wavelengths[LFLARE_WAVELENGTHS] = {650, 510, 475};

/* ---- accuracy ---- */

static double length(double x, double y) { return sqrt(x * x + y * y); }

/* A ray into the front element, up to 40 degrees off the axis. */
static void draw_ray(const lflare_lens *lens, oracle_random *random, double *at, double *slope)
{
    const lflare_surface *front = &lens->prescription.surfaces[0];
    double u = tan(oracle_between(random, 0, 0.7)), turn = oracle_between(random, 0, 6.2832), reach, r;
    slope[0] = u * cos(turn);
    slope[1] = u * sin(turn);
    reach = front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter)) * u;
    r = reach * sqrt(oracle_unit(random));
    turn = oracle_between(random, 0, 6.2832);
    at[0] = r * cos(turn);
    at[1] = r * sin(turn);
}

/* Whether a ray meets the sensor no farther out than 0.6 of its width. */
static int lands(const lflare_lens *lens, const lflare_ray *ray) { return length(ray->sensor[0], ray->sensor[1]) <= 0.6 * lens->sensor_width; }

static double stop_height(const lflare_lens *lens, const lflare_ray *ray)
{
    return length(ray->stop[0], ray->stop[1]) / lens->prescription.surfaces[lens->stop].semi_diameter;
}

typedef struct errors {
    double *value;
    long count, room;
} errors;

static void errors_add(errors *e, double value)
{
    assert_true(value >= 0 && value < 1e300); /* not NaN either */
    if (e->count == e->room) {
        e->room = 2 * e->room + 1000;
        e->value = (double *)realloc(e->value, sizeof(double) * (size_t)e->room);
        assert_non_null(e->value);
    }
    e->value[e->count++] = value;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts, reports, and frees; `most` is what median and 95th percentile may be. */
static int errors_within(errors *e, const char *lens, const char *name, const double *most)
{
    double median, rare;
    assert_true(e->count > 1000);
    qsort(e->value, (size_t)e->count, sizeof(double), by_size);
    median = e->value[e->count / 2];
    rare = e->value[e->count * 95 / 100];
    print_message("%s: %-6s %6ld rays, median %.2e, 95 %% below %.2e, 99 %% below %.2e, worst %.2e\n", lens, name, e->count, median, rare, e->value[e->count * 99 / 100],
                  e->value[e->count - 1]);
    free(e->value);
    return median <= most[0] && rare <= most[1];
}

typedef struct accuracy {
    errors sensor, stop, weight;
    long passing, outside; /* of one ghost: rays that pass, and of these those of which the fit says that it knows nothing */
} accuracy;

static void add_rays(const subject *s, lflare_pair pair, int32_t g, int32_t k, int rays, oracle_random *random, accuracy *a)
{
    static lflare_path path;
    double pixel = s->lens.sensor_width / 1280, semi = s->lens.prescription.surfaces[s->lens.stop].semi_diameter;
    int i;
    assert_int_equal(lflare_path_make(&s->lens, wavelengths[k], &pair, &path), LFLARE_OK);
    for (i = 0; i < rays; i++) {
        double at[2], slope[2];
        lflare_ray ray;
        lflare_fitted_ray fitted;
        lflare_result result;
        draw_ray(&s->lens, random, at, slope);
        path.unweighted = 1;
        if (lflare_path_trace(&path, at, slope, &ray, NULL) != LFLARE_RAY_ARRIVES || ray.relative > 1) continue;
        if (stop_height(&s->lens, &ray) > 1 || !lands(&s->lens, &ray)) continue;
        path.unweighted = 0;
        lflare_path_trace(&path, at, slope, &ray, NULL);
        result = lflare_aberration_ray(s->fit, g, k, at, slope, &fitted);
        a->passing++;
        a->outside += result == LFLARE_INCOMPLETE;
        if (result == LFLARE_INCOMPLETE) continue;
        assert_int_equal(result, LFLARE_OK);
        errors_add(&a->sensor, length((double)fitted.sensor[0] - ray.sensor[0], (double)fitted.sensor[1] - ray.sensor[1]) / pixel);
        errors_add(&a->stop, length((double)fitted.stop[0] - ray.stop[0], (double)fitted.stop[1] - ray.stop[1]) / semi);
        errors_add(&a->weight, fabs((double)fitted.weight - ray.weight) / ray.weight);
    }
}

/* Where a fit says what a ray does it is near the exact ray, and it says so of nearly all rays that pass. */
static void fits_follow_exact_rays(void **state)
{
    static const int rays[SUBJECTS] = {4000, 1500, 800};
    int i, bad = 0;
    (void)state;
    for (i = 0; i < SUBJECTS; i++) {
        const subject *s = &subjects[i];
        lflare_pair *pairs = ghosts_of(&s->lens);
        oracle_random random = {11};
        accuracy a;
        long passing = 0, outside = 0;
        int32_t g, k;
        memset(&a, 0, sizeof a);
        for (g = 0; g < s->lens.ghost_count; g++) {
            a.passing = a.outside = 0;
            for (k = 0; k < LFLARE_WAVELENGTHS; k++) add_rays(s, pairs[g], g, k, rays[i], &random, &a);
            passing += a.passing;
            outside += a.outside;
            if (a.passing < 20 || a.outside * 8 <= a.passing) continue;
            print_message("%s: ghost %d,%d: the fit knows nothing of %ld of %ld rays that pass\n", s->path, (int)pairs[g].first + 1, (int)pairs[g].second + 1,
                          a.outside, a.passing);
            bad++;
        }
        print_message("%s: %ld of %ld rays that pass are outside the fit\n", s->path, outside, passing);
        bad += outside * 100 > passing;
        bad += !errors_within(&a.sensor, s->path, "sensor", allowed[i].sensor);
        bad += !errors_within(&a.stop, s->path, "stop", allowed[i].stop);
        bad += !errors_within(&a.weight, s->path, "weight", allowed[i].weight);
        free(pairs);
    }
    assert_int_equal(bad, 0);
}

/* Next to the axis every ghost of every lens passes light: none may be missing from its fit. */
static void no_ghost_is_lost(void **state)
{
    static const char *const others[] = {"lenses/topogon.lens", "lenses/tessar-50-35.lens", "lenses/petzval-kodak.lens", "lenses/biogon-35-28.lens",
                                        "lenses/fisheye-nikkor-16.lens", "lenses/angenieux-double-gauss.lens", "lenses/planar-50-14.lens", "lenses/sonnar-20.lens"};
    static lflare_lens lens;
    size_t i;
    int lost = 0;
    (void)state;
    for (i = 0; i < sizeof others / sizeof *others; i++) {
        const double slope[2] = {1e-4, 0};
        lflare_pair *pairs;
        void *fit;
        size_t size;
        int32_t g;
        assert_true(oracle_lens_load(others[i], &lens));
        assert_int_equal(lflare_aberration_fit(&lens, NULL, &fit, &size, NULL), LFLARE_OK);
        pairs = ghosts_of(&lens);
        for (g = 0; g < lens.ghost_count; g++) {
            static lflare_path path;
            const double at[2] = {1e-4 * lens.prescription.surfaces[0].semi_diameter, 0};
            lflare_ray ray;
            lflare_fitted_ray fitted;
            assert_int_equal(lflare_path_make(&lens, 510, &pairs[g], &path), LFLARE_OK);
            assert_int_equal(lflare_path_trace(&path, at, slope, &ray, NULL), LFLARE_RAY_ARRIVES);
            assert_true(ray.relative < 1 && stop_height(&lens, &ray) < 1 && lands(&lens, &ray));
            if (lflare_aberration_ray(fit, g, 1, at, slope, &fitted) == LFLARE_OK) continue;
            print_message("%s: ghost %d,%d is not in the fit\n", others[i], (int)pairs[g].first + 1, (int)pairs[g].second + 1);
            lost++;
        }
        free(pairs);
        free(fit);
    }
    assert_int_equal(lost, 0);
}

/* ---- rims ---- */

enum { RIM_RAYS = 1500 };

/* Heights of one ghost's rays, exact at every step and as fitted. */
typedef struct rim_rays {
    int count, steps, rims;
    int32_t surface[LFLARE_MAX_STEPS];
    double exact[RIM_RAYS][LFLARE_MAX_STEPS];
    double fitted[RIM_RAYS][LFLARE_FIT_RIMS];
} rim_rays;

static void collect_rims(const subject *s, lflare_pair pair, int32_t g, int32_t k, int rays, oracle_random *random, rim_rays *out)
{
    static lflare_path path;
    static lflare_hit hits[LFLARE_MAX_STEPS];
    int i, n;
    assert_int_equal(lflare_path_make(&s->lens, wavelengths[k], &pair, &path), LFLARE_OK);
    path.unweighted = 1;
    out->count = out->rims = 0;
    out->steps = path.step_count;
    for (i = 0; i < rays && out->count < RIM_RAYS; i++) {
        double at[2], slope[2];
        lflare_ray ray;
        lflare_fitted_ray fitted;
        draw_ray(&s->lens, random, at, slope);
        if (lflare_aberration_ray(s->fit, g, k, at, slope, &fitted) != LFLARE_OK) continue;
        if (lflare_path_trace(&path, at, slope, &ray, hits) != LFLARE_RAY_ARRIVES || ray.relative > 1.2) continue;
        if (stop_height(&s->lens, &ray) > 1.03 || !lands(&s->lens, &ray)) continue;
        out->rims = fitted.rim_count;
        for (n = 0; n < path.step_count; n++) {
            out->exact[out->count][n] = hits[n].relative;
            out->surface[n] = hits[n].surface;
        }
        for (n = 0; n < fitted.rim_count; n++) out->fitted[out->count][n] = length((double)fitted.rims[n][0], (double)fitted.rims[n][1]);
        out->count++;
    }
}

/* The step whose heights a fitted rim's follow best. */
static int step_of_rim(const rim_rays *r, int32_t stop, int rim)
{
    double least = 1e300;
    int n, i, best = -1;
    for (n = 0; n < r->steps; n++) {
        double sum = 0;
        if (r->surface[n] == stop) continue;
        for (i = 0; i < r->count; i++) sum += fmin(fabs(r->exact[i][n] - r->fitted[i][rim]), 0.1);
        if (sum < least) least = sum, best = n;
    }
    return best;
}

typedef struct rim_count {
    long judged, wrong;     /* heights 2 % or more from the rim; on the wrong side of it */
    long stopped, unlisted; /* rays that a rim stops; of these, those that no listed rim does */
} rim_count;

static void judge_rims(const rim_rays *r, int32_t stop, rim_count *c)
{
    int i, n, rim, step[LFLARE_FIT_RIMS];
    for (rim = 0; rim < r->rims; rim++) step[rim] = step_of_rim(r, stop, rim);
    for (i = 0; i < r->count; i++) {
        double widest = 0, fitted = 0;
        for (rim = 0; rim < r->rims; rim++) {
            double exact = r->exact[i][step[rim]];
            fitted = fmax(fitted, r->fitted[i][rim]);
            if (fabs(exact - 1) <= 0.02) continue;
            c->judged++;
            c->wrong += (exact > 1) != (r->fitted[i][rim] > 1);
        }
        for (n = 0; n < r->steps; n++)
            if (r->surface[n] != stop) widest = fmax(widest, r->exact[i][n]);
        c->stopped += widest > 1.02;
        c->unlisted += widest > 1.02 && fitted < 1;
    }
}

/* A fit says of the rims that it lists which rays they stop, and those that it does not list stop next to none. */
static void rims_stop_what_they_should(void **state)
{
    static const int rays[SUBJECTS] = {10000, 2500, 3000};
    static rim_rays r;
    int s, bad = 0;
    (void)state;
    for (s = 0; s < SUBJECTS; s++) {
        const lflare_lens *lens = &subjects[s].lens;
        lflare_pair *pairs = ghosts_of(lens);
        oracle_random random = {5};
        rim_count c = {0, 0, 0, 0};
        int32_t g, k;
        for (g = 0; g < lens->ghost_count; g++)
            for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
                collect_rims(&subjects[s], pairs[g], g, k, rays[s], &random, &r);
                assert_in_range(r.rims, 0, LFLARE_FIT_RIMS);
                if (r.count >= 30) judge_rims(&r, lens->stop, &c); /* enough to know which rim is which */
            }
        print_message("%s: %ld heights at rims, %ld on the wrong side; %ld rays stopped, %ld by no listed rim\n", subjects[s].path, c.judged, c.wrong, c.stopped,
                      c.unlisted);
        assert_true(c.judged > 5000 && c.stopped > 400);
        bad += c.wrong * 2000 > c.judged || c.unlisted * 100 > c.stopped;
        free(pairs);
    }
    assert_int_equal(bad, 0);
}

/* ---- symmetry ---- */

static void turn(const double *v, double cosine, double sine, double mirror, double *out)
{
    out[0] = cosine * v[0] - sine * mirror * v[1];
    out[1] = sine * v[0] + cosine * mirror * v[1];
}

static double apart(const float *a, const float *b, double cosine, double sine, double mirror)
{
    double from[2], to[2];
    from[0] = (double)a[0];
    from[1] = (double)a[1];
    turn(from, cosine, sine, mirror, to);
    return length(to[0] - (double)b[0], to[1] - (double)b[1]) / (1 + length(from[0], from[1]));
}

/* Turning, or mirroring, entrance point and slope does the same to what is behind the lens. */
static void fits_turn_and_mirror(void **state)
{
    oracle_random random = {3};
    double worst = 0, worst_weight = 0;
    long rays = 0;
    int s, i, k;
    (void)state;
    for (s = 0; s < SUBJECTS; s++) {
        for (i = 0; i < 30000; i++) {
            int32_t g = (int32_t)(oracle_unit(&random) * subjects[s].lens.ghost_count), channel = i % 3;
            double at[2], slope[2], at2[2], slope2[2], angle = i % 4 == 0 ? 0 : oracle_between(&random, 0, 6.2832), mirror = i % 2 == 0 ? -1 : 1;
            lflare_fitted_ray a, b;
            lflare_result result;
            draw_ray(&subjects[s].lens, &random, at, slope);
            turn(at, cos(angle), sin(angle), mirror, at2);
            turn(slope, cos(angle), sin(angle), mirror, slope2);
            result = lflare_aberration_ray(subjects[s].fit, g, channel, at, slope, &a);
            if (result != LFLARE_OK || lflare_aberration_ray(subjects[s].fit, g, channel, at2, slope2, &b) != LFLARE_OK) continue;
            rays++;
            worst = fmax(worst, apart(a.sensor, b.sensor, cos(angle), sin(angle), mirror));
            worst = fmax(worst, apart(a.stop, b.stop, cos(angle), sin(angle), mirror));
            assert_int_equal(a.rim_count, b.rim_count);
            for (k = 0; k < a.rim_count; k++) worst = fmax(worst, apart(a.rims[k], b.rims[k], cos(angle), sin(angle), mirror));
            worst_weight = fmax(worst_weight, fabs((double)(a.weight - b.weight)) / ((double)a.weight + 1e-9));
        }
    }
    print_message("%ld rays turned or mirrored: places %.2e apart, weights %.2e\n", rays, worst, worst_weight);
    assert_true(rays > 3000 && worst < 1.5e-5 && worst_weight < 1e-4);
}

typedef struct scene {
    int width, height;
    double angle, way; /* of the light from the axis; of its place round the middle; degrees */
    float lamp;
} scene;

static double draw(lflare *flare, const scene *c, float *pixels);

/* ---- what is no fit ---- */

static lflare_desc a_desc(const subject *s)
{
    lflare_desc d;
    memset(&d, 0, sizeof d);
    d.text = s->text;
    d.text_size = strlen(s->text);
    return d;
}

static void expect_sentence(const lflare_error *error, lflare_result code, const char *word)
{
    assert_int_equal(error->code, code);
    assert_in_range(strlen(error->text), 10, sizeof error->text - 1);
    assert_null(strchr(error->text, '\n'));
    if (word != NULL && strstr(error->text, word) == NULL) fail_msg("\"%s\" does not say \"%s\"", error->text, word);
}

/* Refused by itself and by an object, with a sentence that holds `word` (unless NULL). */
static void expect_refused(const subject *s, const void *fit, size_t size, const char *word)
{
    lflare_desc desc = a_desc(s);
    lflare_error error;
    lflare *flare = (lflare *)&desc;
    assert_int_equal(lflare_aberration_check(&s->lens, fit, size, &error), LFLARE_ERROR_FIT);
    expect_sentence(&error, LFLARE_ERROR_FIT, word);
    assert_int_equal(lflare_aberration_check(&s->lens, fit, size, NULL), LFLARE_ERROR_FIT);
    desc.fit = fit;
    desc.fit_size = size;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_ERROR_FIT);
    assert_null(flare);
    expect_sentence(&error, LFLARE_ERROR_FIT, word);
}

/* A copy in a block of its own, so that a sanitizer sees any step beyond. */
static uint8_t *part_of(const subject *s, size_t size)
{
    uint8_t *part = (uint8_t *)malloc(size > 0 ? size : 1);
    assert_non_null(part);
    memcpy(part, s->fit, size < s->size ? size : s->size);
    return part;
}

static void truncated_fits(void **state)
{
    const subject *s = &subjects[HELIAR];
    oracle_random random = {21};
    size_t size;
    int i;
    (void)state;
    for (i = 0; i < 500; i++) {
        uint8_t *part;
        size = i <= 200 ? (size_t)i : 201 + (size_t)(oracle_unit(&random) * (double)(s->size - 201));
        if (i == 499) size = s->size - 1;
        part = part_of(s, size);
        expect_refused(s, part, size, NULL);
        free(part);
    }
}

static void sentences_fit(void **state)
{
    const subject *s = &subjects[HELIAR];
    lflare_error error;
    uint8_t *other = part_of(s, s->size + 1);
    (void)state;
    expect_refused(s, other, 0, "not a fit");
    expect_refused(s, other, 500, "cut off");
    other[3] ^= 1;
    expect_refused(s, other, s->size, "not a fit");
    other[3] ^= 1;
    other[6] ^= 2;
    expect_refused(s, other, s->size, "version");
    other[6] ^= 2;
    other[s->size / 2] ^= 1;
    expect_refused(s, other, s->size, "damaged");
    free(other);
    expect_refused(s, subjects[DISTAGON].fit, subjects[DISTAGON].size, "another lens");
    assert_int_equal(lflare_aberration_check(&s->lens, NULL, s->size, &error), LFLARE_ERROR_ARGUMENT);
    expect_sentence(&error, LFLARE_ERROR_ARGUMENT, NULL);
    assert_int_equal(lflare_aberration_check(&s->lens, NULL, 0, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_aberration_check(NULL, s->fit, s->size, &error), LFLARE_ERROR_ARGUMENT);
    expect_sentence(&error, LFLARE_ERROR_ARGUMENT, NULL);
}

/* What begins as a fit does but ends too early, or too late, is told so: with both sizes, once the head says what it should be. */
static void sentences_name_sizes(void **state)
{
    const subject *s = &subjects[HELIAR];
    static const int sizes[] = {32, 100, 5000, -1, 1};
    char is[32], should[32];
    lflare_error error;
    size_t i;
    uint8_t *part = part_of(s, 20);
    (void)state;
    snprintf(should, sizeof should, " %lu", (unsigned long)s->size);
    for (i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        size_t size = sizes[i] > 1 ? (size_t)sizes[i] : sizes[i] > 0 ? s->size + 1 : s->size - 1;
        uint8_t *other = part_of(s, size);
        snprintf(is, sizeof is, " %lu ", (unsigned long)size);
        if (size > s->size) other[s->size] = 0;
        assert_int_equal(lflare_aberration_check(&s->lens, other, size, &error), LFLARE_ERROR_FIT);
        if (strstr(error.text, is) == NULL || strstr(error.text, should) == NULL) fail_msg("%d bytes of %d: \"%s\"", (int)size, (int)s->size, error.text);
        free(other);
    }
    assert_int_equal(lflare_aberration_check(&s->lens, part, 20, &error), LFLARE_ERROR_FIT);
    if (strstr(error.text, "does not begin") != NULL) fail_msg("the first 20 bytes of a fit: \"%s\"", error.text);
    free(part);
}

/* Any changed byte is noticed. */
static void damaged_fits(void **state)
{
    const subject *s = &subjects[HELIAR];
    uint8_t *part = part_of(s, s->size);
    oracle_random random = {22};
    lflare_error error;
    int i, bit;
    (void)state;
    for (i = 0; i < 3000; i++) {
        size_t at = i < 400 ? (size_t)i : (size_t)(oracle_unit(&random) * (double)s->size);
        for (bit = 0; bit < 9; bit++) {
            uint8_t flip = (uint8_t)(bit == 8 ? 0xff : 1 << bit);
            if (i >= 400 && bit != i % 9) continue;
            part[at] ^= flip;
            if (lflare_aberration_check(&s->lens, part, s->size, &error) != LFLARE_ERROR_FIT) fail_msg("byte %d changed by %02x is not noticed", (int)at, flip);
            expect_sentence(&error, LFLARE_ERROR_FIT, NULL);
            part[at] ^= flip;
        }
        if (i % 100 == 0) {
            part[at] ^= 0x40;
            expect_refused(s, part, s->size, NULL);
            part[at] ^= 0x40;
        }
    }
    assert_int_equal(lflare_aberration_check(&s->lens, part, s->size, &error), LFLARE_OK); /* all put back */
    assert_int_equal(error.code, LFLARE_OK);
    free(part);
}

/* Gives bytes the checksum that they should have. */
static void seal(uint8_t *fit, size_t size)
{
    uint64_t hash = lflare__hash_bytes(fit + LFLARE__FIT_HEAD, size - LFLARE__FIT_HEAD);
    int i;
    for (i = 0; i < 8; i++) fit[24 + i] = (uint8_t)(hash >> (8 * i));
}

/* Fits made up by somebody, with a right checksum: refused, or drawn without nonsense. */
static void crafted_fits(void **state)
{
    static const uint32_t odd[6] = {0x7f800000u, 0xffc00000u, 0x7f7fffffu, 0, 0x80000000u, 0x00000001u}; /* floats: infinite, NaN, largest, 0, -0, least */
    static float pixels[4 * 32 * 18];
    const subject *s = &subjects[HELIAR];
    size_t rows = LFLARE__FIT_HEAD + (size_t)s->lens.ghost_count * LFLARE__FIT_ROW;
    oracle_random random = {77};
    int i, k, refused = 0, drawn = 0;
    (void)state;
    for (i = 0; i < 120; i++) {
        uint8_t *part = part_of(s, s->size);
        lflare_desc desc = a_desc(s);
        lflare *flare;
        for (k = 0; k <= i % 5; k++) {
            size_t at = (i + k) % 2 ? LFLARE__FIT_HEAD + (size_t)(oracle_unit(&random) * (double)(rows - LFLARE__FIT_HEAD)) :
                                      rows + (size_t)(oracle_unit(&random) * (double)(s->size - rows));
            if (i % 3 == 0 && at + 4 <= s->size) memcpy(part + at, &odd[(i / 3 + k) % 6], 4);
            else part[at] = (uint8_t)(oracle_unit(&random) * 256);
        }
        seal(part, s->size);
        desc.fit = part;
        desc.fit_size = s->size;
        if (lflare_create(&desc, &flare, NULL) == LFLARE_OK) {
            static const scene scenes[2] = {{32, 18, 0.5, 25, 0}, {32, 18, 12, 100, 0.00465f}};
            for (k = 0; k < 2; k++) draw(flare, &scenes[k], pixels);
            lflare_destroy(flare);
            drawn++;
        } else {
            refused++;
        }
        free(part);
    }
    print_message("%d crafted fits refused, %d drawn\n", refused, drawn);
    assert_true(refused > 20 && drawn > 40);
}

/* A fit belongs to the numbers of its lens, whatever that is called. */
static void fits_of_other_lenses(void **state)
{
    static lflare_lens other;
    const subject *s = &subjects[HELIAR];
    lflare_error error;
    int what;
    (void)state;
    for (what = 0; what < 8; what++) {
        lflare_surface *surface;
        other = s->lens;
        surface = &other.prescription.surfaces[2];
        switch (what) {
        case 0: surface->radius += 1e-6; break;
        case 1: surface->thickness += 1e-6; break;
        case 2: surface->semi_diameter -= 1e-6; break;
        case 3: surface->conic = 1e-9; break;
        case 4: surface->aspheric[7] = 1e-30; break;
        case 5: other.prescription.surfaces[0].medium.c[0] += 1e-9; break;
        case 6: surface->coating = LFLARE_COATING_QUARTER, surface->quarter_nm = 550; break;
        default: other.sensor_width += 1; break;
        }
        if (lflare_aberration_check(&other, s->fit, s->size, &error) != LFLARE_ERROR_FIT) fail_msg("change %d of the lens is not noticed", what);
        expect_sentence(&error, LFLARE_ERROR_FIT, "lens");
    }
    other = s->lens;
    strcpy(other.prescription.name, "the same by another name");
    assert_int_equal(lflare_aberration_check(&other, s->fit, s->size, &error), LFLARE_OK);
}

static void rays_refused(void **state)
{
    const subject *s = &subjects[HELIAR];
    const double at[2] = {0, 0}, slope[2] = {0, 0}, far[2] = {0, 50}, beyond[2] = {1000, 0};
    lflare_fitted_ray out;
    (void)state;
#define REFUSED(call) assert_int_equal(call, LFLARE_ERROR_ARGUMENT)
    REFUSED(lflare_aberration_ray(NULL, 0, 0, at, slope, &out));
    REFUSED(lflare_aberration_ray(s->fit, -1, 0, at, slope, &out));
    REFUSED(lflare_aberration_ray(s->fit, s->lens.ghost_count, 0, at, slope, &out));
    REFUSED(lflare_aberration_ray(s->fit, 0, -1, at, slope, &out));
    REFUSED(lflare_aberration_ray(s->fit, 0, 3, at, slope, &out));
    REFUSED(lflare_aberration_ray(s->fit, 0, 0, NULL, slope, &out));
    REFUSED(lflare_aberration_ray(s->fit, 0, 0, at, NULL, &out));
    REFUSED(lflare_aberration_ray(s->fit, 0, 0, at, slope, NULL));
#undef REFUSED
    assert_int_equal(lflare_aberration_ray(s->fit, 0, 0, at, slope, &out), LFLARE_OK);
    assert_int_equal(lflare_aberration_ray(s->fit, 0, 0, beyond, slope, &out), LFLARE_INCOMPLETE);
    memset(&out, 0xa5, sizeof out);
    assert_int_equal(lflare_aberration_ray(s->fit, 0, 0, at, far, &out), LFLARE_INCOMPLETE); /* hidden: all zeroes, as promised */
    assert_true(out.sensor[0] == 0 && out.sensor[1] == 0 && out.stop[0] == 0 && out.stop[1] == 0 && out.rim_count == 0 && out.weight == 0);
}

/* ---- memory ---- */

typedef struct ledger {
    size_t bytes;          /* in use */
    long calls, blocks;    /* calls that allocate or change a size; blocks in use */
    long fail_at;          /* the call that fails, from 1; 0 = none */
    int wrong_sizes;       /* old sizes that were not right */
    int32_t seen, count, stop_at, disorder; /* of progress: last `done`, `count`, when to stop, calls out of order */
} ledger;

enum { LEDGER_HEAD = 16 };

static void *ledger_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    ledger *l = (ledger *)user;
    char *base = block != NULL ? (char *)block - LEDGER_HEAD : NULL;
    size_t known = 0;
    if (base != NULL) memcpy(&known, base, sizeof known);
    l->wrong_sizes += known != old_size;
    if (new_size == 0) {
        l->wrong_sizes += block == NULL; /* nothing to free */
        l->bytes -= known;
        l->blocks -= block != NULL;
        free(base);
        return NULL;
    }
    if (++l->calls == l->fail_at) return NULL;
    base = (char *)realloc(base, LEDGER_HEAD + new_size);
    if (base == NULL) return NULL;
    if (known < new_size) memset(base + LEDGER_HEAD + known, 0xa5, new_size - known); /* nobody may count on zeroes */
    memcpy(base, &new_size, sizeof new_size);
    l->bytes += new_size - known;
    l->blocks += block == NULL;
    return base + LEDGER_HEAD;
}

static void expect_settled(const ledger *l)
{
    assert_int_equal(l->wrong_sizes, 0);
    assert_int_equal(l->blocks, 0);
    assert_true(l->bytes == 0);
}

static int32_t progress(void *user, int32_t done, int32_t count)
{
    ledger *l = (ledger *)user;
    l->disorder += done != l->seen + 1 || (l->count != 0 && l->count != count);
    l->seen = done;
    l->count = count;
    return done == l->stop_at;
}

static lflare_aberration_desc a_fit_desc(ledger *l)
{
    lflare_aberration_desc d;
    memset(&d, 0, sizeof d);
    memset(l, 0, sizeof *l);
    d.allocate = ledger_realloc;
    d.user = l;
    return d;
}

/* The same bytes whatever the memory held before. */
static void fits_are_the_same_each_time(void **state)
{
    const subject *s = &subjects[HELIAR];
    ledger l;
    lflare_aberration_desc desc = a_fit_desc(&l);
    lflare_error error;
    void *fit;
    size_t size;
    (void)state;
    desc.progress = progress;
    assert_int_equal(lflare_aberration_fit(&s->lens, &desc, &fit, &size, &error), LFLARE_OK);
    assert_int_equal(error.code, LFLARE_OK);
    assert_true(size == s->size);
    assert_memory_equal(fit, s->fit, size);
    assert_true(l.blocks == 1 && l.bytes == size); /* no more than was promised stays */
    assert_true(l.disorder == 0 && l.seen == s->lens.ghost_count && l.count == s->lens.ghost_count);
    ledger_realloc(&l, fit, size, 0);
    expect_settled(&l);
}

static void fit_allocations_fail(void **state)
{
    const subject *s = &subjects[HELIAR];
    ledger l;
    lflare_aberration_desc desc;
    lflare_error error;
    void *fit;
    size_t size;
    long n;
    (void)state;
    for (n = 1;; n++) {
        lflare_result result;
        desc = a_fit_desc(&l);
        l.fail_at = n;
        fit = &l;
        size = 77;
        result = lflare_aberration_fit(&s->lens, &desc, &fit, &size, &error);
        if (result == LFLARE_OK) break;
        assert_int_equal(result, LFLARE_ERROR_MEMORY);
        expect_sentence(&error, LFLARE_ERROR_MEMORY, "memory");
        assert_true(fit == NULL && size == 0);
        expect_settled(&l);
    }
    assert_true(n > 4 && l.calls == n - 1);
    ledger_realloc(&l, fit, size, 0);
    expect_settled(&l);
}

static void fit_stopped(void **state)
{
    const subject *s = &subjects[HELIAR];
    const int32_t stops[3] = {1, 5, 13};
    ledger l;
    lflare_aberration_desc desc;
    lflare_error error;
    int i;
    (void)state;
    assert_int_equal(s->lens.ghost_count, 13);
    for (i = 0; i < 3; i++) {
        void *fit = &l;
        size_t size = 77;
        desc = a_fit_desc(&l);
        desc.progress = progress;
        l.stop_at = stops[i];
        assert_int_equal(lflare_aberration_fit(&s->lens, &desc, &fit, &size, &error), LFLARE_INCOMPLETE);
        assert_int_equal(error.code, LFLARE_INCOMPLETE);
        assert_true(fit == NULL && size == 0 && l.disorder == 0 && l.seen == stops[i]);
        expect_settled(&l);
    }
}

static void fit_arguments(void **state)
{
    const subject *s = &subjects[HELIAR];
    lflare_error error;
    void *fit;
    size_t size;
    (void)state;
    assert_int_equal(lflare_aberration_fit(NULL, NULL, &fit, &size, &error), LFLARE_ERROR_ARGUMENT);
    expect_sentence(&error, LFLARE_ERROR_ARGUMENT, NULL);
    assert_int_equal(lflare_aberration_fit(&s->lens, NULL, NULL, &size, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_aberration_fit(&s->lens, NULL, &fit, NULL, NULL), LFLARE_ERROR_ARGUMENT);
}

static void create_with_fit_fails(void **state)
{
    const subject *s = &subjects[HELIAR];
    ledger l;
    lflare_desc desc = a_desc(s);
    lflare_override tint = {3, 1, 0, {1, 0.5f, 0.5f}, 0, 0, {0, 0}, 0, 0};
    lflare_error error;
    lflare *flare;
    long n;
    (void)state;
    desc.fit = s->fit;
    desc.fit_size = s->size;
    desc.allocate = ledger_realloc;
    desc.user = &l;
    desc.settings.overrides = &tint;
    desc.settings.override_count = 1;
    desc.settings.no_starburst = 1;
    for (n = 1;; n++) {
        lflare_result result;
        memset(&l, 0, sizeof l);
        l.fail_at = n;
        flare = (lflare *)&l;
        result = lflare_create(&desc, &flare, &error);
        if (result == LFLARE_OK) break;
        assert_int_equal(result, LFLARE_ERROR_MEMORY);
        expect_sentence(&error, LFLARE_ERROR_MEMORY, "memory");
        assert_null(flare);
        expect_settled(&l);
    }
    assert_true(n > 5 && l.calls == n - 1);
    lflare_destroy(flare);
    expect_settled(&l);
}

/* ---- pictures ---- */

enum { MOST_PIXELS = 320 * 180 };

static const scene plain = {160, 90, 9, 25, 0.00465f};

static lflare *create(const subject *s, int with_fit, const lflare_settings *settings)
{
    lflare_desc desc = a_desc(s);
    lflare_error error;
    lflare *flare = NULL;
    if (settings != NULL) desc.settings = *settings;
    desc.fit = with_fit ? s->fit : NULL;
    desc.fit_size = with_fit ? s->size : 0;
    if (lflare_create(&desc, &flare, &error) != LFLARE_OK) fail_msg("%s", error.text);
    return flare;
}

static void set_frame(lflare *flare, const scene *c)
{
    lflare_view view;
    lflare_light light;
    int k;
    memset(&view, 0, sizeof view);
    memset(&light, 0, sizeof light);
    view.width = c->width;
    view.height = c->height;
    light.direction[0] = (float)(sin(c->angle * DEGREE) * cos(c->way * DEGREE));
    light.direction[1] = (float)(sin(c->angle * DEGREE) * sin(c->way * DEGREE));
    light.direction[2] = (float)-cos(c->angle * DEGREE);
    for (k = 0; k < 3; k++) light.color[k] = 1;
    light.angular_radius = c->lamp;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
}

static lflare_image image_of(const scene *c, float *pixels)
{
    lflare_image image;
    memset(&image, 0, sizeof image);
    image.pixels = pixels;
    image.width = c->width;
    image.height = c->height;
    return image;
}

/* Draws and returns the sum of all pixels; none may be negative or no number. */
static double draw(lflare *flare, const scene *c, float *pixels)
{
    lflare_image image = image_of(c, pixels);
    int i, count = 4 * c->width * c->height;
    double sum = 0;
    memset(pixels, 0, sizeof(float) * (size_t)count);
    set_frame(flare, c);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (i = 0; i < count; i++) {
        if (!(pixels[i] >= 0 && pixels[i] < 1e30f))
            fail_msg("%dx%d at %g degrees, lamp %g: float %d is %g", c->width, c->height, c->angle, (double)c->lamp, i, (double)pixels[i]);
        sum += (double)pixels[i];
    }
    return sum;
}

/* As a photographer would turn the dials; ghosts alone, with plain edges. */
static lflare_settings dials(double fnumber, int blades, lflare_model model)
{
    lflare_settings s;
    memset(&s, 0, sizeof s);
    s.no_starburst = s.no_ringing = 1;
    s.fnumber = fnumber;
    s.blades = blades;
    s.model = model;
    return s;
}

/* Lights from the axis to beside the camera, points and discs, in pictures of one pixel, of a few and of many. */
static void pictures_are_sane(lflare *flare, const lflare_settings *settings)
{
    static const double angles[] = {0, 0.01, 5, 20, 60, 89};
    static const int sizes[3][2] = {{1, 1}, {7, 5}, {320, 180}};
    static float pixels[4 * MOST_PIXELS];
    double sum = 0;
    int a, v, lamp;
    assert_int_equal(lflare_configure(flare, settings, NULL), LFLARE_OK);
    for (a = 0; a < 6; a++)
        for (v = 0; v < 3; v++)
            for (lamp = 0; lamp < 2; lamp++) {
                scene c;
                c.width = sizes[v][0];
                c.height = sizes[v][1];
                c.angle = angles[a];
                c.way = a == 2 ? 90 : 25;
                c.lamp = lamp ? 0.00465f : 0;
                sum += draw(flare, &c, pixels);
            }
    assert_true(sum > 0);
}

static void pictures_hold_no_nonsense(void **state)
{
    static const double fnumbers[SUBJECTS][5] = {{1, 3.5, 8, 22, 64}, {1, 64}, {64}};
    int s, f;
    (void)state;
    for (s = 0; s < SUBJECTS; s++) {
        lflare *flare = create(&subjects[s], 1, NULL);
        for (f = 0; f < 5 && fnumbers[s][f] > 0; f++) {
            lflare_settings settings = dials(fnumbers[s][f], f % 2 ? 0 : 5, LFLARE_MODEL_POLYNOMIAL);
            settings.no_ringing = f == 2;
            pictures_are_sane(flare, &settings);
            settings.blades = 5 - settings.blades;
            if (s == HELIAR) pictures_are_sane(flare, &settings);
        }
        lflare_destroy(flare);
    }
}

/* Rows in two halves, through the object and through the stage below it, are the picture. */
static void halves_equal_the_whole(void **state)
{
    static float whole[4 * MOST_PIXELS], halves[4 * MOST_PIXELS], stage[4 * MOST_PIXELS];
    scene c = plain;
    lflare_settings settings = dials(4, 5, LFLARE_MODEL_AUTO);
    lflare *flare = create(&subjects[DISTAGON], 1, &settings);
    lflare_image image = image_of(&c, halves), below;
    const lflare_tables *tables;
    size_t bytes;
    (void)state;
    c.width = 320;
    c.height = 180;
    image = image_of(&c, halves);
    below = image_of(&c, stage);
    bytes = sizeof(float) * 4 * 320 * 180;
    assert_true(draw(flare, &c, whole) > 0);
    assert_int_equal(lflare_render_begin(flare), LFLARE_OK);
    assert_int_equal(lflare_render_rows(flare, &image, 77, 180), LFLARE_OK);
    assert_int_equal(lflare_render_rows(flare, &image, 0, 77), LFLARE_OK);
    assert_memory_equal(whole, halves, bytes);
    tables = lflare_get_tables(flare);
    assert_int_equal(lflare_software_patches(tables, lflare_get_frame(flare), &below, 0, 1), LFLARE_OK);
    assert_int_equal(lflare_software_patches(tables, lflare_get_frame(flare), &below, 1, 180), LFLARE_OK);
    assert_memory_equal(whole, stage, bytes);
    assert_int_equal(lflare_software_patches(NULL, lflare_get_frame(flare), &below, 0, 180), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_software_patches(tables, NULL, &below, 0, 180), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_software_patches(tables, lflare_get_frame(flare), NULL, 0, 180), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_software_patches(tables, lflare_get_frame(flare), &below, -1, 180), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_software_patches(tables, lflare_get_frame(flare), &below, 0, 181), LFLARE_ERROR_ARGUMENT);
    below.width = 319;
    assert_int_equal(lflare_software_patches(tables, lflare_get_frame(flare), &below, 0, 180), LFLARE_ERROR_ARGUMENT);
    lflare_destroy(flare);
}

/* A light turned by 90 degrees about the axis turns a square picture. Four blades turn into themselves. */
static void pictures_turn_with_the_light(void **state)
{
    enum { N = 160 };
    static float a[4 * N * N], b[4 * N * N];
    double worst = 0, worst_sum = 0;
    int s, blades, quarter, x, y, k;
    (void)state;
    for (s = 0; s < NIKON; s++)
        for (blades = 0; blades <= 4; blades += 4) {
            lflare_settings settings = dials(5.6, blades, LFLARE_MODEL_AUTO);
            lflare *flare = create(&subjects[s], 1, &settings);
            for (quarter = 1; quarter < 4; quarter++) {
                scene c = {N, N, 8, 31, 0.002f}, turned;
                double sum, other, difference = 0;
                turned = c;
                turned.way += 90 * quarter;
                sum = draw(flare, &c, a);
                other = draw(flare, &turned, b);
                assert_true(sum > 0);
                for (y = 0; y < N; y++)
                    for (x = 0; x < N; x++) {
                        int tx = quarter == 1 ? y : quarter == 2 ? N - 1 - x : N - 1 - y, ty = quarter == 1 ? N - 1 - x : quarter == 2 ? N - 1 - y : x;
                        for (k = 0; k < 3; k++) difference += fabs((double)a[4 * (y * N + x) + k] - (double)b[4 * (ty * N + tx) + k]);
                    }
                worst = fmax(worst, difference / sum);
                worst_sum = fmax(worst_sum, fabs(other / sum - 1));
            }
            lflare_destroy(flare);
        }
    print_message("pictures turned by quarters: %.1e of the light elsewhere, sums %.1e apart\n", worst, worst_sum);
    assert_true(worst < 1e-3 && worst_sum < 1e-4);
}

typedef struct inner_count {
    long patches, vertices, outside; /* inner vertices with light; of these, more than 1 % outside of the iris or a rim */
    double beyond;                   /* the most that one is outside */
} inner_count;

static void count_inner(const lflare_patch *p, inner_count *c)
{
    int r, d, k;
    c->patches++;
    assert_true(p->iris_soft > 0);
    for (r = 0; r < LFLARE_PATCH_RINGS; r++)
        for (d = 0; d < LFLARE_PATCH_DIRECTIONS; d++) {
            const lflare_patch_vertex *v = &p->inside[r][d];
            int lit = 0;
            assert_true(fabsf(v->position[0]) < 1e6f && fabsf(v->position[1]) < 1e6f);
            for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
                double closed = fmax((double)v->rim[k], length((double)v->iris[k][0], (double)v->iris[k][1]));
                assert_true(v->irradiance[k] >= 0 && v->irradiance[k] < 1e12f && v->flux[k] >= 0 && v->flux[k] < 1e12f);
                if (!(v->irradiance[k] + v->flux[k] > 0)) continue;
                lit = 1;
                c->vertices++;
                c->outside += closed > 1.01;
                c->beyond = fmax(c->beyond, closed - 1);
            }
            assert_true(!lit || v->rim_soft > 0);
        }
}

/* Patches are what they say: all numbers, light nowhere negative, insides within iris and rims. */
static void patches_keep_their_word(void **state)
{
    static const double angles[] = {0, 3, 12, 30}, fnumbers[SUBJECTS] = {3.5, 8, 5.6};
    inner_count c = {0, 0, 0, 0};
    int s, a, i;
    (void)state;
    for (s = 0; s < SUBJECTS; s++) {
        lflare_settings settings = dials(fnumbers[s], 0, LFLARE_MODEL_AUTO);
        lflare *flare = create(&subjects[s], 1, &settings);
        const lflare_frame_data *frame = lflare_get_frame(flare);
        for (a = 0; a < 4; a++) {
            scene shown = plain;
            shown.lamp = 0;
            shown.angle = angles[a];
            set_frame(flare, &shown);
            for (i = 0; i < frame->instance_count; i++) {
                lflare_patch patch;
                if (lflare_patch_resolve(lflare_get_tables(flare), frame, frame->instances[i], &patch)) count_inner(&patch, &c);
            }
        }
        lflare_destroy(flare);
    }
    print_message("%ld patches: %ld of %ld inner vertices more than 1 %% outside, by %.2g at most\n", c.patches, c.outside, c.vertices, c.beyond);
    assert_true(c.patches > 1000 && c.outside * 75 < c.vertices && c.beyond < 0.2);
}

/* ---- models ---- */

static void expect_same_picture(lflare *a, lflare *b)
{
    static float first[4 * MOST_PIXELS], second[4 * MOST_PIXELS];
    assert_true(draw(a, &plain, first) > 0);
    draw(b, &plain, second);
    assert_memory_equal(first, second, sizeof(float) * 4 * (size_t)plain.width * (size_t)plain.height);
}

static void expect_other_picture(lflare *a, lflare *b)
{
    static float first[4 * MOST_PIXELS], second[4 * MOST_PIXELS];
    draw(a, &plain, first);
    draw(b, &plain, second);
    assert_true(memcmp(first, second, sizeof(float) * 4 * (size_t)plain.width * (size_t)plain.height) != 0);
}

static void models_without_fit(void **state)
{
    lflare_settings polynomial = dials(5.6, 0, LFLARE_MODEL_POLYNOMIAL), odd = dials(5.6, 0, (lflare_model)9), minus = dials(5.6, 0, (lflare_model)-1);
    lflare_desc desc = a_desc(&subjects[HELIAR]);
    lflare *flare = create(&subjects[HELIAR], 0, NULL), *fresh = create(&subjects[HELIAR], 0, NULL), *none = flare;
    lflare_error error;
    (void)state;
    assert_int_equal(lflare_get_tables(flare)->model, LFLARE_MODEL_PARAXIAL);
    assert_null(lflare_get_tables(flare)->fit);
    assert_int_equal(lflare_configure(flare, &polynomial, &error), LFLARE_ERROR_ARGUMENT);
    expect_sentence(&error, LFLARE_ERROR_ARGUMENT, "fit");
    assert_int_equal(lflare_configure(flare, &odd, &error), LFLARE_ERROR_ARGUMENT);
    expect_sentence(&error, LFLARE_ERROR_ARGUMENT, "model");
    assert_int_equal(lflare_configure(flare, &minus, &error), LFLARE_ERROR_ARGUMENT);
    expect_same_picture(flare, fresh); /* what was refused changed nothing */
    desc.settings.model = LFLARE_MODEL_POLYNOMIAL;
    assert_int_equal(lflare_create(&desc, &none, &error), LFLARE_ERROR_ARGUMENT);
    assert_null(none);
    expect_sentence(&error, LFLARE_ERROR_ARGUMENT, "fit");
    lflare_destroy(flare);
    lflare_destroy(fresh);
}

static void models_with_fit(void **state)
{
    const subject *s = &subjects[HELIAR];
    lflare_settings settings[3];
    lflare *with, *without, *fresh[3];
    int i, k;
    (void)state;
    for (i = 0; i < 3; i++) settings[i] = dials(5.6, 6, (lflare_model)i);
    with = create(s, 1, &settings[LFLARE_MODEL_AUTO]);
    without = create(s, 0, &settings[LFLARE_MODEL_AUTO]);
    for (i = 0; i < 3; i++) fresh[i] = create(s, 1, &settings[i]);
    assert_int_equal(lflare_get_tables(with)->model, LFLARE_MODEL_POLYNOMIAL);
    expect_same_picture(fresh[LFLARE_MODEL_AUTO], fresh[LFLARE_MODEL_POLYNOMIAL]);
    expect_same_picture(fresh[LFLARE_MODEL_PARAXIAL], without);
    expect_other_picture(with, without);
    for (k = 0; k < 7; k++) { /* back and forth */
        static const int order[7] = {1, 2, 1, 1, 0, 2, 1};
        i = order[k];
        assert_int_equal(lflare_configure(with, &settings[i], NULL), LFLARE_OK);
        assert_int_equal(lflare_get_tables(with)->model, i == 1 ? LFLARE_MODEL_PARAXIAL : LFLARE_MODEL_POLYNOMIAL);
        expect_same_picture(with, fresh[i]);
    }
    lflare_destroy(with);
    lflare_destroy(without);
    for (i = 0; i < 3; i++) lflare_destroy(fresh[i]);
}

static void expect_same_meshes(const lflare_tables *a, const lflare_tables *b)
{
    assert_true(a->mesh_texels == b->mesh_texels && a->mesh_texels > 0);
    assert_memory_equal(a->mesh, b->mesh, a->mesh_texels * 4 * sizeof(float));
    assert_memory_equal(a->mesh_head, b->mesh_head, (size_t)a->ghost_count * LFLARE_MESH_HEAD_FLOATS * sizeof(float));
    assert_int_equal(a->active_count, b->active_count);
}

static void configure_in_steps(void **state)
{
    const subject *s = &subjects[HELIAR];
    lflare_settings old = dials(0, 0, LFLARE_MODEL_AUTO), settings = dials(11, 7, LFLARE_MODEL_AUTO);
    lflare *whole = create(s, 1, &settings), *before = create(s, 1, &old), *stepped;
    int32_t step;
    (void)state;
    for (step = 1; step < 14; step += 4) {
        int steps = 1;
        stepped = create(s, 1, &old);
        assert_int_equal(lflare_configure_begin(stepped, &settings, NULL), LFLARE_OK);
        while (lflare_configure_step(stepped, step) == LFLARE_INCOMPLETE) {
            steps++;
            if (steps == 3) expect_same_picture(before, stepped);
        }
        assert_int_equal(steps, (13 + step - 1) / step);
        expect_same_meshes(lflare_get_tables(whole), lflare_get_tables(stepped));
        expect_same_picture(whole, stepped);
        lflare_destroy(stepped);
    }
    lflare_destroy(whole);
    lflare_destroy(before);
}

/* New settings that are refused leave those that are being built in steps as they are. */
static void refused_between_steps(void **state)
{
    lflare_settings settings = dials(5.6, 0, LFLARE_MODEL_AUTO), bad = dials(16, 5, LFLARE_MODEL_POLYNOMIAL);
    int with_fit;
    (void)state;
    for (with_fit = 0; with_fit < 2; with_fit++) {
        lflare *flare = create(&subjects[HELIAR], with_fit, NULL), *fresh = create(&subjects[HELIAR], with_fit, &settings);
        if (with_fit) bad.model = (lflare_model)9;
        assert_int_equal(lflare_configure_begin(flare, &settings, NULL), LFLARE_OK);
        assert_int_equal(lflare_configure_step(flare, 3), LFLARE_INCOMPLETE);
        assert_int_equal(lflare_configure_begin(flare, &bad, NULL), LFLARE_ERROR_ARGUMENT);
        assert_int_equal(lflare_configure_step(flare, INT32_MAX), LFLARE_OK);
        expect_same_picture(flare, fresh);
        lflare_destroy(flare);
        lflare_destroy(fresh);
    }
}

/* Bytes may lie anywhere. */
static void fits_lie_anywhere(void **state)
{
    subject s = subjects[HELIAR];
    uint8_t *room = (uint8_t *)malloc(s.size + 4);
    lflare *flare = create(&subjects[HELIAR], 1, NULL), *odd;
    oracle_random random = {31};
    int shift, i;
    (void)state;
    assert_non_null(room);
    for (shift = 1; shift < 4; shift++) {
        memcpy(room + shift, subjects[HELIAR].fit, s.size);
        s.fit = room + shift;
        assert_int_equal(lflare_aberration_check(&s.lens, s.fit, s.size, NULL), LFLARE_OK);
        for (i = 0; i < 300; i++) {
            double at[2], slope[2];
            lflare_fitted_ray a, b;
            draw_ray(&s.lens, &random, at, slope);
            assert_int_equal(lflare_aberration_ray(subjects[HELIAR].fit, i % 13, i % 3, at, slope, &a), lflare_aberration_ray(s.fit, i % 13, i % 3, at, slope, &b));
            assert_memory_equal(&a, &b, sizeof a);
        }
        odd = create(&s, 1, NULL);
        expect_same_meshes(lflare_get_tables(flare), lflare_get_tables(odd));
        expect_same_picture(flare, odd);
        lflare_destroy(odd);
    }
    lflare_destroy(flare);
    free(room);
}

/* ---- hard lenses ---- */

/* Reads, derives and fits. */
static void hard_open(subject *s, const char *name, const char *text)
{
    static lflare_prescription p;
    lflare_error error;
    memset(s, 0, sizeof *s);
    s->path = name;
    s->text = (char *)malloc(strlen(text) + 1);
    assert_non_null(s->text);
    strcpy(s->text, text);
    if (lflare_text_read(text, strlen(text), &p, &error) != LFLARE_OK || lflare_lens_derive(&p, &s->lens, &error) != LFLARE_OK)
        fail_msg("%d: %s", (int)error.line, error.text);
    if (lflare_aberration_fit(&s->lens, NULL, &s->fit, &s->size, &error) != LFLARE_OK) fail_msg("%s", error.text);
    assert_int_equal(lflare_aberration_check(&s->lens, s->fit, s->size, NULL), LFLARE_OK);
}

static void hard_close(subject *s)
{
    free(s->text);
    free(s->fit);
}

/* The light of a ghost in the middle channel, summed over the frame: drawn, and by exact rays. Of the frame only the ghost's own
   patches are drawn. */
static double light_drawn(const lflare *flare, const scene *c, int32_t ghost)
{
    static float pixels[4 * MOST_PIXELS];
    lflare_image image = image_of(c, pixels);
    lflare_frame_data frame = *lflare_get_frame(flare);
    const lflare_instance *all = frame.instances;
    int32_t count = frame.instance_count, i;
    double sum = 0;
    frame.instance_count = 0;
    for (i = 0; i < count; i++)
        if (all[i].ghost == ghost && frame.instance_count++ == 0) frame.instances += i;
    memset(pixels, 0, sizeof(float) * 4 * (size_t)c->width * (size_t)c->height);
    assert_int_equal(lflare_software_patches(lflare_get_tables(flare), &frame, &image, 0, c->height), LFLARE_OK);
    for (i = 0; i < c->width * c->height; i++) sum += (double)pixels[4 * i + 1];
    assert_true(sum >= 0 && sum < 1e30);
    return sum;
}

static double light_exact(const lflare_lens *lens, double fnumber, const scene *c, const lflare_pair *pair)
{
    static reference_desc d;
    static float rgb[3 * MOST_PIXELS];
    lflare_iris iris;
    double sum = 0;
    int i;
    assert_int_equal(lflare_iris_make(lens, fnumber, 0, 0, 0, &iris, NULL), LFLARE_OK);
    memset(&d, 0, sizeof d);
    d.lens = lens;
    d.iris = &iris;
    d.slope[0] = -tan(c->angle * DEGREE) * cos(c->way * DEGREE);
    d.slope[1] = -tan(c->angle * DEGREE) * sin(c->way * DEGREE);
    d.half[0] = 0.5 * lens->sensor_width;
    d.half[1] = d.half[0] * c->height / c->width;
    d.width = c->width;
    d.height = c->height;
    d.wavelengths = 1;
    d.nm[0] = wavelengths[1];
    d.rgb[0][1] = 1;
    d.cells = 24;
    d.threads = 1;
    d.only = pair;
    assert_int_equal(reference_render(&d, rgb), 1);
    for (i = 0; i < c->width * c->height; i++) sum += (double)rgb[3 * i + 1];
    return sum;
}

/* What the light of a hard ghost may be off: in general, and where it is all in a caustic of a few pixels, whose edges are cut by
   the iris as well. */
#define FEW_PERCENT 0.04
#define CAUSTIC 0.12

static int same_pair(const lflare_pair *a, const lflare_pair *b) { return a->first == b->first && a->second == b->second; }

typedef struct light_error {
    double worst; /* of any ghost, as a share of its own light or, if it is faint, of a hundredth of the brightest ghost's */
    double share; /* of all ghosts together, of all light */
} light_error;

static void add_light(const char *name, lflare_pair pair, double drawn, double exact, double brightest, light_error *e)
{
    double off = fabs(drawn - exact) / fmax(exact, fmax(0.01 * brightest, 1e-9));
    e->worst = fmax(e->worst, off);
    e->share += fabs(drawn - exact);
    if (off > 0.1 && fabs(drawn - exact) > 0.05 * brightest)
        print_message("    %s, ghost %d,%d: light %.4g, of exact rays %.4g\n", name, (int)pair.first + 1, (int)pair.second + 1, drawn, exact);
}

/* How far the light of ghosts is off: of all, of one alone, or of all but one. */
static light_error light_off(const subject *s, double fnumber, double angle, const lflare_pair *only, const lflare_pair *but)
{
    lflare_settings settings = dials(fnumber, 0, LFLARE_MODEL_POLYNOMIAL);
    lflare_pair *pairs = ghosts_of(&s->lens);
    double *drawn = (double *)calloc((size_t)s->lens.ghost_count, 2 * sizeof(double)), *exact = drawn + s->lens.ghost_count, brightest = 0, all = 0;
    light_error e = {0, 0};
    scene c = {160, 90, 0, 25, 0};
    lflare *flare;
    int32_t g;
    assert_non_null(drawn);
    settings.raw = 1;
    flare = create(s, 1, &settings);
    c.angle = angle;
    set_frame(flare, &c);
    for (g = 0; g < s->lens.ghost_count; g++) {
        if ((only != NULL && !same_pair(only, &pairs[g])) || (but != NULL && same_pair(but, &pairs[g]))) continue;
        drawn[g] = light_drawn(flare, &c, g);
        exact[g] = light_exact(&s->lens, fnumber, &c, &pairs[g]);
        brightest = fmax(brightest, exact[g]);
        all += exact[g];
    }
    for (g = 0; g < s->lens.ghost_count; g++) add_light(s->path, pairs[g], drawn[g], exact[g], brightest, &e);
    e.share = all > 0 ? e.share / all : 0;
    print_message("  %s, f/%g, %g degrees: brightest %.2e, a ghost off by %.2g at most, together by %.2g of all light\n", s->path, fnumber, angle, brightest,
                  e.worst, e.share);
    free(drawn);
    free(pairs);
    lflare_destroy(flare);
    return e;
}

static const lflare_pair nearly_total = {3, 1, 0, 0}; /* 4,2 of the Heliar: total reflection lies within its bundle */

static void light_of_the_heliar(void **state)
{
    static const double angles[] = {0, 4, 12, 20};
    double worst = 0;
    int a;
    (void)state;
    for (a = 0; a < 4; a++) {
        worst = fmax(worst, light_off(&subjects[HELIAR], 3.5, angles[a], NULL, &nearly_total).worst);
        worst = fmax(worst, light_off(&subjects[HELIAR], 8, angles[a], NULL, &nearly_total).worst);
    }
    assert_true(worst < 0.01);
}

/* Whole lenses, with all that is hard in them: each ghost's error counts, whether too bright or too dark. */
static void light_of_whole_lenses(void **state)
{
    static const struct {
        int subject;
        double fnumber, angle;
    } scenes[] = {{DISTAGON, 2.8, 3}, {DISTAGON, 5.6, 7}, {NIKON, 11, 3}};
    double worst = 0;
    size_t i;
    (void)state;
    for (i = 0; i < sizeof scenes / sizeof *scenes; i++)
        worst = fmax(worst, light_off(&subjects[scenes[i].subject], scenes[i].fnumber, scenes[i].angle, NULL, NULL).share);
    assert_true(worst < FEW_PERCENT);
}

static void light_near_total_reflection(void **state)
{
    static const double angles[] = {0, 2, 4, 8, 12};
    double worst = 0;
    int a;
    (void)state;
    for (a = 0; a < 5; a++) {
        worst = fmax(worst, light_off(&subjects[HELIAR], 3.5, angles[a], &nearly_total, NULL).worst);
        worst = fmax(worst, light_off(&subjects[HELIAR], 8, angles[a], &nearly_total, NULL).worst);
    }
    assert_true(worst < CAUSTIC);
}

/* No nonsense at any setting; and if it is asked, some light. */
static void hard_pictures(const subject *s, int lit)
{
    static const double angles[] = {0, 0.01, 5, 20, 60}, fnumbers[] = {0, 8, 1000};
    static float pixels[4 * MOST_PIXELS];
    lflare *flare = create(s, 1, NULL);
    int f, a;
    for (f = 0; f < 3; f++) {
        lflare_settings settings = dials(fnumbers[f], f == 1 ? 5 : 0, LFLARE_MODEL_POLYNOMIAL);
        double sum = 0;
        assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
        for (a = 0; a < 10; a++) {
            scene c = {160, 90, 0, 25, 0};
            c.angle = angles[a / 2];
            c.lamp = a % 2 ? 0.00465f : 0;
            sum += draw(flare, &c, pixels);
        }
        if (lit) assert_true(sum > 0);
    }
    lflare_destroy(flare);
}

/* A light moves out from the axis: how far the light of the first ghost, wherever its point falls between the pixels,
   is off that of exact rays, which hardly changes. */
static double light_wanders(const subject *s, float lamp)
{
    lflare_settings settings = dials(0, 0, LFLARE_MODEL_POLYNOMIAL);
    scene c = {160, 90, 1, 25, 0};
    lflare_pair *pairs = ghosts_of(&s->lens);
    double exact = light_exact(&s->lens, 0, &c, &pairs[0]), least = 1e300, most = 0;
    lflare *flare;
    int i;
    settings.raw = 1;
    flare = create(s, 1, &settings);
    c.lamp = lamp;
    for (i = 0; i < 60; i++) {
        double light;
        c.angle = 0.01 + 0.0511 * i;
        set_frame(flare, &c);
        light = light_drawn(flare, &c, 0);
        least = fmin(least, light / exact);
        most = fmax(most, light / exact);
    }
    print_message("  %s, light wandering, lamp %g: ghost %d,%d from %.3g to %.3g of exact rays' light\n", s->path, (double)lamp, (int)pairs[0].first + 1,
                  (int)pairs[0].second + 1, least, most);
    lflare_destroy(flare);
    free(pairs);
    return fmax(1 - least, most - 1);
}

/* Plane-parallel plates return light in its own direction: their ghosts are points of light in focus, and between two plates the
   ghost of each pair lies on the image itself. */
static void plates(void **state)
{
    static subject s;
    static const double angles[] = {0, 1, 3};
    double worst = 0;
    int a;
    (void)state;
    hard_open(&s, "plates", "lensflare 1\nname Plates\nsensor 36 24\nflat 3 n 1.5 semi 30\nflat 2 air semi 30\nflat 4 n 1.6 semi 30\nflat 2 air semi 30\n"
                  "120 4 n 1.52 semi 20\nflat 5 air semi 20\nstop 5 semi 6\nflat 2 n 1.7 semi 12\nflat focus semi 12\n");
    hard_pictures(&s, 1);
    for (a = 0; a < 3; a++) worst = fmax(worst, light_off(&s, 0, angles[a], NULL, NULL).worst);
    worst = fmax(worst, light_off(&s, 22, 1, NULL, NULL).worst);
    for (a = 0; a < 2; a++) worst = fmax(worst, light_wanders(&s, a == 0 ? 0 : 0.00465f));
    hard_close(&s);
    assert_true(worst < FEW_PERCENT);
}

/* ---- lenses tuned until a ghost is at its worst ---- */

enum { HELIAR_ROWS = 9, STOP_ROW = 5 };

static const double heliar_rows[HELIAR_ROWS][4] = { /* radius, gap, index, semi-diameter */
    {30.81, 7.7, 1.652, 14.5}, {-89.35, 1.85, 1.603, 14.5}, {580.38, 3.52, 1, 14.5}, {-80.63, 1.85, 1.643, 12.3}, {28.34, 4.18, 1, 12},
    {0, 3, 0, 11.6}, {0, 1.85, 1.581, 12.3}, {32.19, 7.27, 1.694, 12.3}, {-52.99, 81.857, 1, 12.3}};

/* The Heliar with one radius changed. */
static void heliar_text(int row, double factor, char *out)
{
    char medium[32];
    int i;
    out += sprintf(out, "lensflare 1\nfnumber 3.5\nsensor 36 24\n");
    for (i = 0; i < HELIAR_ROWS; i++) {
        const double *r = heliar_rows[i];
        sprintf(medium, r[2] > 1 ? "n %g" : "air", r[2]);
        if (i == STOP_ROW) out += sprintf(out, "stop %g semi %g\n", r[1], r[3]);
        else if (r[0] == 0) out += sprintf(out, "flat %g %s semi %g\n", r[1], medium, r[3]);
        else out += sprintf(out, "%.17g %g %s semi %g\n", r[0] * (i == row ? factor : 1), r[1], medium, r[3]);
    }
}

/* M11 (or Ma11) of a ghost at the d line. */
static double heliar_entry(int row, double factor, lflare_pair pair, int at_stop)
{
    static lflare_prescription p;
    static lflare_lens lens;
    lflare_ghost_matrices m;
    char text[1000];
    heliar_text(row, factor, text);
    assert_int_equal(lflare_text_read(text, strlen(text), &p, NULL), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(&p, &lens, NULL), LFLARE_OK);
    assert_int_equal(lflare_ghost_optics(&lens, ORACLE_D, &pair, 1, &m), LFLARE_OK);
    return at_stop ? m.ma.a : m.m.a;
}

/* What to change: a scan of all ghosts and radii found these between a factor and another. */
typedef struct tuning {
    int at_stop, row;
    lflare_pair pair;
    double lo, hi;
} tuning;

static const tuning tunings[] = {
    {0, 0, {3, 1, 0, 0}, 1.05, 1.2}, {0, 0, {4, 0, 0, 0}, 1.4, 1.5}, {0, 1, {3, 1, 0, 0}, 0.85, 0.9}, /* M11: in focus */
    {1, 0, {2, 0, 0, 0}, 1.7, 1.8},  {1, 0, {4, 0, 0, 0}, 0.85, 0.92}, {1, 4, {4, 0, 0, 0}, 1.6, 1.8}}; /* Ma11: at the stop */

/* The factor that brings the entry to within 1e-4 of 0. */
static double tune(const tuning *t)
{
    double lo = t->lo, hi = t->hi, at_lo = heliar_entry(t->row, lo, t->pair, t->at_stop);
    int i;
    assert_true(at_lo * heliar_entry(t->row, hi, t->pair, t->at_stop) < 0);
    for (i = 0; i < 40; i++) {
        double middle = 0.5 * (lo + hi), at = heliar_entry(t->row, middle, t->pair, t->at_stop);
        if ((at < 0) == (at_lo < 0)) lo = middle;
        else hi = middle;
    }
    assert_true(fabs(heliar_entry(t->row, lo, t->pair, t->at_stop)) < 1e-4);
    return lo;
}

/* Each of the lenses must draw its ghost's light. Returns how far that is off at most. */
static double tuned_lenses(int at_stop)
{
    static subject s;
    double worst = 0;
    size_t i;
    for (i = 0; i < sizeof tunings / sizeof *tunings; i++) {
        const tuning *t = &tunings[i];
        char text[1000];
        double factor;
        if (t->at_stop != at_stop) continue;
        factor = tune(t);
        heliar_text(t->row, factor, text);
        print_message("  Heliar, %s of ghost %d,%d is 0 with radius %d at %.6f of what it was\n", at_stop ? "Ma11" : "M11", (int)t->pair.first + 1,
                      (int)t->pair.second + 1, t->row + 1, factor);
        hard_open(&s, "tuned Heliar", text);
        hard_pictures(&s, 1);
        worst = fmax(worst, light_off(&s, 0, 2, &t->pair, NULL).worst);
        worst = fmax(worst, light_off(&s, 11, 0.3, &t->pair, NULL).worst);
        worst = fmax(worst, light_off(&s, 11, 5, &t->pair, NULL).worst);
        hard_close(&s);
    }
    return worst;
}

static void ghosts_in_focus(void **state)
{
    (void)state;
    assert_true(tuned_lenses(0) < CAUSTIC);
}

static void stops_seen_as_a_point(void **state)
{
    (void)state;
    assert_true(tuned_lenses(1) < FEW_PERCENT);
}

/* The ray of a ghost through the middle of the stop, by Newton's method from where the fit puts it, and how much larger an area
   of the stop is than of the entrance. 0 if there is none. */
static int middle_ray(const lflare_path *path, const double *slope, double *at, lflare_ray *ray, double *enlarged)
{
    const double step = 1e-5;
    int i, k;
    for (i = 0; i < 30; i++) {
        double j[2][2], det;
        if (lflare_path_trace(path, at, slope, ray, NULL) != LFLARE_RAY_ARRIVES) return 0;
        for (k = 0; k < 2; k++) {
            lflare_ray beside;
            double to[2];
            to[0] = at[0] + (k == 0 ? step : 0);
            to[1] = at[1] + (k == 1 ? step : 0);
            if (lflare_path_trace(path, to, slope, &beside, NULL) != LFLARE_RAY_ARRIVES) return 0;
            j[0][k] = (beside.stop[0] - ray->stop[0]) / step;
            j[1][k] = (beside.stop[1] - ray->stop[1]) / step;
        }
        det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        *enlarged = fabs(det);
        if (length(ray->stop[0], ray->stop[1]) < 1e-9) return 1;
        at[0] -= (j[1][1] * ray->stop[0] - j[0][1] * ray->stop[1]) / det;
        at[1] -= (j[0][0] * ray->stop[1] - j[1][0] * ray->stop[0]) / det;
    }
    return 0;
}

/* A stop like a pinhole: all of a ghost's light is in one ray. Ghosts whose ray lands well within the frame. */
static double pinhole_off(const subject *s, double fnumber, double angle, int *judged)
{
    static lflare_path path;
    lflare_settings settings = dials(fnumber, 0, LFLARE_MODEL_POLYNOMIAL);
    lflare_pair *pairs = ghosts_of(&s->lens);
    scene c = {160, 90, 0, 25, 0};
    double worst = 0, slope[2], pixel = s->lens.sensor_width / 160;
    lflare *flare;
    lflare_iris iris;
    int32_t g;
    settings.raw = 1;
    flare = create(s, 1, &settings);
    c.angle = angle;
    slope[0] = -tan(c.angle * DEGREE) * cos(c.way * DEGREE);
    slope[1] = -tan(c.angle * DEGREE) * sin(c.way * DEGREE);
    set_frame(flare, &c);
    assert_int_equal(lflare_iris_make(&s->lens, fnumber, 0, 0, 0, &iris, NULL), LFLARE_OK);
    for (g = 0; g < s->lens.ghost_count; g++) {
        double at[2] = {0, 0}, enlarged, exact, drawn;
        lflare_ray ray;
        lflare_path_make(&s->lens, wavelengths[1], &pairs[g], &path);
        if (!middle_ray(&path, slope, at, &ray, &enlarged) || ray.relative > 0.99) continue;
        if (fabs(ray.sensor[0]) > 0.3 * s->lens.sensor_width || fabs(ray.sensor[1]) > 0.15 * s->lens.sensor_width) continue;
        exact = ray.weight * cos(angle * DEGREE) * 3.14159265 * (double)iris.radius * (double)iris.radius / enlarged / (pixel * pixel);
        drawn = light_drawn(flare, &c, g);
        (*judged)++;
        worst = fmax(worst, fabs(drawn / exact - 1));
        if (fabs(drawn / exact - 1) <= FEW_PERCENT) continue;
        print_message("    %s, f/%g, %g degrees, ghost %d,%d: light %.4g, of the exact ray %.4g\n", s->path, fnumber, angle, (int)pairs[g].first + 1,
                      (int)pairs[g].second + 1, drawn, exact);
    }
    print_message("  %s, f/%g, %g degrees: off by %.2g at most\n", s->path, fnumber, angle, worst);
    free(pairs);
    lflare_destroy(flare);
    return worst;
}

/* Next to nothing passes, and that is drawn. */
static void stopped_far_down(void **state)
{
    static const double angles[] = {0.5, 3, 6};
    double worst = 0;
    int a, judged = 0;
    (void)state;
    hard_pictures(&subjects[HELIAR], 1);
    for (a = 0; a < 3; a++) worst = fmax(worst, pinhole_off(&subjects[HELIAR], 128, angles[a], &judged));
    assert_true(judged > 20 && worst < FEW_PERCENT);
}

/* A light at 60 degrees, which only a lens of very wide angle takes in. Not its ghost 4,2, drawn five times too bright there: the
   square root of total reflection passes through its bundle, and beyond it polynomials open the iris again. */
static void light_from_the_side(void **state)
{
    static subject s;
    char *text = oracle_read("lenses/fisheye-nikkor-16.lens");
    double worst;
    (void)state;
    assert_non_null(text);
    hard_open(&s, "fisheye", text);
    worst = light_off(&s, 2.8, 60, NULL, &nearly_total).share;
    worst = fmax(worst, light_off(&s, 8, 60, NULL, &nearly_total).share);
    free(text);
    hard_close(&s);
    assert_true(worst < FEW_PERCENT);
}

/* `quick` leaves out what compares light with exact rays: under sanitisers that would take long. */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fits_follow_exact_rays),
        cmocka_unit_test(rims_stop_what_they_should),
        cmocka_unit_test(fits_turn_and_mirror),
        cmocka_unit_test(truncated_fits),
        cmocka_unit_test(sentences_fit),
        cmocka_unit_test(sentences_name_sizes),
        cmocka_unit_test(damaged_fits),
        cmocka_unit_test(crafted_fits),
        cmocka_unit_test(fits_of_other_lenses),
        cmocka_unit_test(rays_refused),
        cmocka_unit_test(fits_are_the_same_each_time),
        cmocka_unit_test(fit_allocations_fail),
        cmocka_unit_test(fit_stopped),
        cmocka_unit_test(fit_arguments),
        cmocka_unit_test(create_with_fit_fails),
        cmocka_unit_test(pictures_hold_no_nonsense),
        cmocka_unit_test(halves_equal_the_whole),
        cmocka_unit_test(pictures_turn_with_the_light),
        cmocka_unit_test(models_without_fit),
        cmocka_unit_test(models_with_fit),
        cmocka_unit_test(configure_in_steps),
        cmocka_unit_test(refused_between_steps),
        cmocka_unit_test(fits_lie_anywhere),
        cmocka_unit_test(patches_keep_their_word),
    };
    const struct CMUnitTest lights[] = {
        cmocka_unit_test(light_of_the_heliar),
        cmocka_unit_test(stops_seen_as_a_point),
        cmocka_unit_test(no_ghost_is_lost),
        cmocka_unit_test(light_of_whole_lenses),
        cmocka_unit_test(light_near_total_reflection),
        cmocka_unit_test(plates),
        cmocka_unit_test(ghosts_in_focus),
        cmocka_unit_test(stopped_far_down),
        cmocka_unit_test(light_from_the_side),
    };
    int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    return cmocka_run_group_tests(tests, open_subjects, close_subjects) + (quick ? 0 : cmocka_run_group_tests(lights, open_subjects, close_subjects));
}
