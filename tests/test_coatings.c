/* Coatings for colours: W of coated lenses against lensflare.h's, derivatives against differences, and coatings that are found again. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSOPT_IMPLEMENTATION
#include "lensopt.h"

enum { VARIABLES = 2 * LFLARE_MAX_SURFACES, POPULATION = 16 };

static const char heliar[] = "lenses/heliar-tronnier.lens", canon[] = "lenses/canon-28-80.lens", nikon[] = "lenses/nikon-80-200-mid.lens";
static const lensopt_light sun = {{5.45, 5.45}, 1};
static lflare_prescription prescription;
static lflare_lens lens;
static lensopt_target target;
static lensopt_coated_ghost ghosts[LENSOPT_MAX_GHOSTS];

static uint64_t state_of_random;

static double random_number(void)
{
    uint64_t z = (state_of_random += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

static double iris_of(const lflare_lens *of) { return fabs(of->stop_a11) * of->efl / (2 * of->fnumber); }

/* A lens, and what it shows as a target. iris 0: the full opening. */
static double read_lens(const char *path, double iris)
{
    lflare_error error;
    char *text;
    size_t size;
    assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &size, &error), LFLARE_OK);
    assert_int_equal(lflare_text_read(text, size, &prescription, &error), LFLARE_OK);
    free(text);
    assert_int_equal(lflare_lens_derive(&prescription, &lens, &error), LFLARE_OK);
    if (iris == 0) iris = iris_of(&lens);
    assert_int_equal(lensopt_target_of(&lens, &sun, 1, iris, &target, &error), LFLARE_OK);
    return iris;
}

static lensopt_coatings_desc plain(double iris, lensopt_film film)
{
    lensopt_coatings_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.lens = &lens;
    desc.target = &target;
    desc.iris = iris;
    desc.film = film;
    return desc;
}

static lensopt_coatings *make(const lensopt_coatings_desc *desc, lensopt_function *f)
{
    lensopt_coatings *c;
    lflare_error error;
    if (lensopt_coatings_create(desc, &c, &error) != LFLARE_OK) fail_msg("%s", error.text);
    lensopt_coatings_function(c, f);
    assert_int_equal(f->variables, lensopt_coatings_surfaces(c, NULL) * (desc->film == LENSOPT_FILM_LAYER ? 2 : 1));
    assert_true(f->evaluate != NULL && f->polish != NULL && f->sample == NULL);
    return c;
}

static void random_point(const lensopt_function *f, double *x)
{
    int32_t v;
    for (v = 0; v < f->variables; v++) x[v] = f->lower[v] + (f->upper[v] - f->lower[v]) * random_number();
}

/* The lens gets random coatings of the kind that is sought, and the target is what it then shows. x: these. */
static void coat_at_random(double iris, lensopt_film film, double *x)
{
    lensopt_coatings_desc desc = plain(iris, film);
    lensopt_function f;
    lensopt_coatings *c = make(&desc, &f);
    lflare_error error;
    random_point(&f, x);
    assert_int_equal(lensopt_coatings_apply(c, x, &prescription, &error), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(&prescription, &lens, &error), LFLARE_OK);
    assert_int_equal(lensopt_target_of(&lens, &sun, 1, iris, &target, &error), LFLARE_OK);
    lensopt_coatings_destroy(c);
}

/* ---- evaluating ---- */

/* W of one lens with coatings x, against irradiances of the lens that has them. Returns the worst relative error. */
static double worst_error(const lensopt_coatings *c, const double *x, double iris)
{
    static lflare_lens coated;
    lflare_prescription p = prescription;
    lflare_error error;
    double worst = 0;
    int32_t g, k;
    assert_int_equal(lensopt_coatings_apply(c, x, &p, &error), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(&p, &coated, &error), LFLARE_OK);
    lensopt_coatings_ghosts(c, x, ghosts);
    for (g = 0; g < target.ghost_count; g++) {
        lensopt_spot spot;
        if (ghosts[g].light < 0) continue;
        assert_memory_equal(&ghosts[g].pair, &target.ghosts[g].pair, sizeof ghosts[g].pair);
        assert_int_equal(lensopt_spots(&coated, &ghosts[g].pair, 1, lensopt_slope(&sun), iris, &spot), LFLARE_OK);
        for (k = 0; k < 3; k++) worst = fmax(worst, fabs(ghosts[g].rgb[k] * ghosts[g].scale / spot.irradiance[k] - 1));
    }
    return worst;
}

static void w_is_that_of_the_coated_lens(void **state)
{
    static const struct { const char *path; double iris; } lenses[3] = {{heliar, 2.25}, {canon, 0}, {nikon, 4}};
    double x[VARIABLES], worst = 0;
    int32_t l, film, i;
    (void)state;
    state_of_random = 1;
    for (l = 0; l < 3; l++)
        for (film = 0; film < 2; film++) {
            double iris = read_lens(lenses[l].path, lenses[l].iris), error = 0;
            lensopt_coatings_desc desc = plain(iris, (lensopt_film)film);
            lensopt_function f;
            lensopt_coatings *c = make(&desc, &f);
            for (i = 0; i < (l == 0 ? 100 : 8); i++) {
                random_point(&f, x);
                error = fmax(error, worst_error(c, x, iris));
            }
            print_message("%s, %d variables: W within %.1e\n", lenses[l].path, (int)f.variables, error);
            worst = fmax(worst, error);
            lensopt_coatings_destroy(c);
        }
    assert_true(worst < 1e-4);
}

/* With coatings between glasses, several lights, four reflections and paths across the stop, too. */
static void any_path_counts(void **state)
{
    static const lensopt_light two[2] = {{{-20, 3}, 1}, {{1, 1}, 1}};
    static lflare_lens coated;
    lflare_paths paths;
    lensopt_coatings_desc desc;
    lensopt_function f;
    lensopt_coatings *c;
    lflare_error error;
    lflare_prescription p;
    double x[VARIABLES], worst = 0;
    int32_t g, k, film, i, second = 0, four = 0;
    (void)state;
    state_of_random = 2;
    read_lens(heliar, 0);
    paths.across_stop = 1;
    paths.four = 30;
    assert_int_equal(lflare_lens_paths(&lens, &paths, &error), LFLARE_OK);
    assert_int_equal(lensopt_target_of(&lens, two, 2, 5, &target, &error), LFLARE_OK);
    for (film = 0; film < 2; film++) {
        desc = plain(5, (lensopt_film)film);
        desc.cemented = 1;
        c = make(&desc, &f);
        assert_int_equal(lensopt_coatings_surfaces(c, NULL), 8);
        for (i = 0; i < 10; i++) {
            random_point(&f, x);
            p = prescription;
            assert_int_equal(lensopt_coatings_apply(c, x, &p, &error), LFLARE_OK);
            assert_int_equal(lflare_lens_derive(&p, &coated, &error), LFLARE_OK);
            coated.paths = paths;
            lensopt_coatings_ghosts(c, x, ghosts);
            for (g = 0; g < target.ghost_count; g++) {
                lensopt_spot spot;
                if (ghosts[g].light < 0) continue;
                second += ghosts[g].light == 1;
                four += ghosts[g].pair.third > 0;
                assert_int_equal(lensopt_spots(&coated, &ghosts[g].pair, 1, lensopt_slope(&two[ghosts[g].light]), 5, &spot), LFLARE_OK);
                for (k = 0; k < 3; k++) worst = fmax(worst, fabs(ghosts[g].rgb[k] * ghosts[g].scale / spot.irradiance[k] - 1));
            }
        }
        lensopt_coatings_destroy(c);
    }
    print_message("W within %.1e, %d at the second light, %d of four reflections\n", worst, (int)second, (int)four);
    assert_true(worst < 1e-4 && second > 0 && four > 0);
}

static void a_lens_is_its_own_target(void **state)
{
    static const char *const lenses[2] = {heliar, canon};
    double x[VARIABLES], again[VARIABLES], f_there;
    int32_t l, film, v;
    (void)state;
    state_of_random = 3;
    for (l = 0; l < 2; l++)
        for (film = 0; film < 2; film++) {
            double iris = read_lens(lenses[l], l == 0 ? 2.25 : 0);
            lensopt_coatings_desc desc;
            lensopt_function f;
            lensopt_coatings *c;
            coat_at_random(iris, (lensopt_film)film, x);
            desc = plain(iris, (lensopt_film)film);
            desc.brightness = 1;
            c = make(&desc, &f);
            assert_int_equal(lensopt_coatings_read(c, &prescription, again), LFLARE_OK);
            for (v = 0; v < f.variables; v++) assert_true(fabs(again[v] - x[v]) <= 1e-12 * x[v]);
            f.evaluate(f.user, x, 1, &f_there);
            print_message("%d ghosts: f %.1e at the answer\n", (int)target.ghost_count, f_there);
            assert_true(f_there < 5e-6 * target.ghost_count);
            lensopt_coatings_destroy(c);
        }
}

/* f is what its description says, and the same alone and in company. */
static void f_is_the_sum_of_distances(void **state)
{
    enum { POINTS = 9 };
    double x[POINTS * 32], f_all[POINTS], f_one, sum;
    int32_t film, i, g, k, bright, n;
    (void)state;
    state_of_random = 4;
    for (film = 0; film < 2; film++)
        for (bright = 0; bright < 2; bright++) {
            double iris = read_lens(heliar, 2.25);
            lensopt_coatings_desc desc = plain(iris, (lensopt_film)film);
            lensopt_function f;
            lensopt_coatings *c;
            for (g = 0; g < target.ghost_count; g++) {
                target.ghosts[g].weight = g % 4;
                for (k = 0; k < 3 && g != 5; k++) target.ghosts[g].color[k] *= random_number();
            }
            memset(target.ghosts[5].color, 0, sizeof target.ghosts[5].color);
            desc.brightness = 0.25 * bright;
            c = make(&desc, &f);
            n = f.variables;
            for (i = 0; i < POINTS; i++) random_point(&f, x + n * i);
            for (i = 1; i <= POINTS; i++) {
                f.evaluate(f.user, x, i, f_all);
                f.evaluate(f.user, x + n * (i - 1), 1, &f_one);
                assert_true(f_one == f_all[i - 1]);
            }
            for (i = 0; i < POINTS; i++) {
                lensopt_coatings_ghosts(c, x + n * i, ghosts);
                for (sum = 0, g = 0; g < target.ghost_count; g++) {
                    double rgb[3];
                    assert_int_equal(ghosts[g].light, g % 4 == 0 || g == 5 ? -1 : 0);
                    if (ghosts[g].light < 0) continue;
                    for (k = 0; k < 3; k++) rgb[k] = ghosts[g].rgb[k] * ghosts[g].scale;
                    assert_true(fabs(lensopt__colour_distance(rgb, target.ghosts[g].color, desc.brightness) - ghosts[g].distance) < 1e-9);
                    sum += target.ghosts[g].weight * ghosts[g].distance;
                }
                assert_true(fabs(sum - f_all[i]) < 1e-12 * sum);
            }
            lensopt_coatings_destroy(c);
        }
}

/* ---- going downhill ---- */

/* Residuals of a ghost, with derivatives where they are asked for. */
static int32_t residuals_at(lensopt__coat_slopes *s, int32_t ghost, const double *x, double *residual)
{
    lensopt__coat_slopes_at(s, x);
    return lensopt__coat_residuals(s, ghost, residual);
}

static void derivatives_are_those_of_differences(void **state)
{
    static const char *const lenses[2] = {heliar, canon};
    double x[VARIABLES], rows[4 * VARIABLES], was[4], low[4], high[4], worst = 0;
    int32_t l, film, i, g, k, v, n, tried = 0;
    (void)state;
    state_of_random = 5;
    for (l = 0; l < 2; l++)
        for (film = 0; film < 2; film++) {
            double iris = read_lens(lenses[l], l == 0 ? 2.25 : 0);
            lensopt_coatings_desc desc = plain(iris, (lensopt_film)film);
            lensopt_function f;
            lensopt_coatings *c;
            lensopt__coat_slopes s;
            desc.brightness = 0.5;
            c = make(&desc, &f);
            s = lensopt__coat_slopes_make(c);
            n = f.variables;
            for (i = 0; i < (l == 0 ? 40 : 3); i++) {
                random_point(&f, x);
                for (g = i % 3; g < c->shown.count; g += l == 0 ? 1 : 17) {
                    int32_t count = residuals_at(&s, g, x, was);
                    memcpy(rows, s.rows, sizeof(double) * (size_t)(4 * n));
                    for (v = 0; v < n; v++) {
                        double kept = x[v], step = 1e-6 * (f.upper[v] - f.lower[v]);
                        x[v] = kept - step;
                        residuals_at(&s, g, x, low);
                        x[v] = kept + step;
                        residuals_at(&s, g, x, high);
                        x[v] = kept;
                        for (k = 0; k < count; k++) {
                            double slope = (high[k] - low[k]) / (2e-6), claimed = rows[k * n + v] * (f.upper[v] - f.lower[v]);
                            worst = fmax(worst, fabs(slope - claimed) / (1e-2 + fabs(slope)));
                            tried++;
                        }
                    }
                }
            }
            free(s.value);
            lensopt_coatings_destroy(c);
        }
    print_message("%d derivatives within %.1e\n", (int)tried, worst);
    assert_true(worst < 1e-5 && tried > 10000);
}

static void polish_only_improves(void **state)
{
    double x[VARIABLES], at[VARIABLES], was, is, unknown, check;
    int32_t film, i, v, cost, better = 0;
    (void)state;
    state_of_random = 6;
    for (film = 0; film < 2; film++)
        for (i = 0; i < 40; i++) {
            double iris = read_lens(heliar, 2.25);
            lensopt_coatings_desc desc = plain(iris, (lensopt_film)film);
            lensopt_function f;
            lensopt_coatings *c;
            desc.brightness = i % 2 * 0.1;
            if (i % 4 > 1) desc.nm[0] = desc.nm[1] = 400, desc.index[0] = desc.index[1] = 1.5; /* nothing to change, or half of it */
            c = make(&desc, &f);
            random_point(&f, x);
            f.evaluate(f.user, x, 1, &was);
            memcpy(at, x, sizeof at);
            is = was;
            assert_int_equal(f.polish(f.user, at, &is, 0), 0);
            assert_memory_equal(x, at, sizeof(double) * (size_t)f.variables);
            cost = f.polish(f.user, at, &is, 20);
            assert_true(is <= was && cost > 0);
            unknown = HUGE_VAL;
            assert_int_equal(f.polish(f.user, x, &unknown, 20), cost + 1); /* for the value */
            assert_true(unknown == is && memcmp(x, at, sizeof(double) * (size_t)f.variables) == 0);
            for (v = 0; v < f.variables; v++) assert_true(at[v] >= f.lower[v] && at[v] <= f.upper[v]);
            f.evaluate(f.user, at, 1, &check);
            assert_true(check == is);
            better += is < 0.8 * was;
            lensopt_coatings_destroy(c);
        }
    print_message("of 80 points %d became better by a fifth\n", (int)better);
    assert_true(better > 40);
}

/* A few polished points, of which the worst are replaced by crossings of others that have a surface or two anew. Returns the best f. */
static double search(const lensopt_function *f, int32_t rounds, double enough, double *best_x, int32_t *spent)
{
    double x[POPULATION][VARIABLES], value[POPULATION], child[VARIABLES], child_f;
    int32_t i, k, v, a, b, round, best = 0;
    *spent = 0;
    for (i = 0; i < POPULATION; i++) {
        random_point(f, x[i]);
        f->evaluate(f->user, x[i], 1, &value[i]);
        *spent += 1 + f->polish(f->user, x[i], &value[i], 30);
    }
    for (round = 0; round < rounds; round++) {
        int32_t changed[2];
        for (best = 0, i = 1; i < POPULATION; i++)
            if (value[i] < value[best]) best = i;
        if (value[best] < enough) break;
        a = (int32_t)(POPULATION * random_number());
        b = (int32_t)(POPULATION * random_number());
        for (k = 0; k < 2; k++) changed[k] = f->blocks[(int32_t)(f->variables * random_number())];
        for (v = 0; v < f->variables; v++) {
            if (v == 0 || f->blocks[v] != f->blocks[v - 1]) k = random_number() < 0.5;
            child[v] = k ? x[a][v] : x[b][v];
            if (f->blocks[v] == changed[0] || f->blocks[v] == changed[1]) child[v] = f->lower[v] + (f->upper[v] - f->lower[v]) * random_number();
        }
        f->evaluate(f->user, child, 1, &child_f);
        *spent += 1 + f->polish(f->user, child, &child_f, 30);
        if (value[b] < value[a]) a = b;
        for (k = 0, i = 0; i < POPULATION; i++)
            if (value[i] > value[k]) k = i;
        if (child_f < value[k]) {
            memcpy(x[k], child, sizeof child);
            value[k] = child_f;
        }
    }
    memcpy(best_x, x[best], sizeof x[best]);
    return value[best];
}

static void coatings_are_found_again(void **state)
{
    double x[VARIABLES], found[VARIABLES], f_found;
    int32_t film, spent, v, i, hits = 0;
    (void)state;
    state_of_random = 7;
    for (film = 0; film < 2; film++)
        for (i = 0; i < 4; i++) {
            double iris = read_lens(heliar, 2.25), apart = 0;
            lensopt_coatings_desc desc;
            lensopt_function f;
            lensopt_coatings *c;
            if (i > 0) coat_at_random(iris, (lensopt_film)film, x);
            desc = plain(iris, (lensopt_film)film);
            desc.brightness = i % 2 == 0 ? 0 : 0.1;
            c = make(&desc, &f);
            lensopt_coatings_read(c, &prescription, x);
            f_found = search(&f, film == 0 ? 400 : 2000, 1e-4, found, &spent);
            for (v = 0; v < f.variables; v++) apart = fmax(apart, fabs(found[v] - x[v]) / (f.upper[v] - f.lower[v]));
            print_message("%d variables, brightness %g: f %.1e after %d evaluations, within %.1e of the range\n", (int)f.variables, desc.brightness, f_found, (int)spent, apart);
            hits += f_found < 1e-4;
            lensopt_coatings_destroy(c);
        }
    assert_true(hits >= 6);
}

/* ---- what is sought for what ---- */

static void locked_coatings_stay(void **state)
{
    int32_t rows[LFLARE_MAX_SURFACES], i, k, count, stacks = 0;
    lensopt_coatings_desc desc;
    lensopt_function f;
    lensopt_coatings *c;
    lflare_prescription p;
    lflare_error error;
    double iris = read_lens(canon, 0), x[VARIABLES], nm[3] = {650, 510, 475}, was[3], is[3];
    (void)state;
    state_of_random = 8;
    for (i = 0; i < lens.surface_count; i += 2) target.locks[i] = LENSOPT_LOCK_COATING | LENSOPT_LOCK_GAP;
    target.locks[1] = LENSOPT_LOCK_RADIUS;
    desc = plain(iris, LENSOPT_FILM_LAYER);
    c = make(&desc, &f);
    count = lensopt_coatings_surfaces(c, rows);
    for (i = 0; i < count; i++) {
        double n0 = lensopt__index(&lens, rows[i] - 1, 510), n1 = lensopt__index(&lens, rows[i], 510);
        assert_true(rows[i] % 2 == 1 && rows[i] != lens.stop && (i == 0 || rows[i] > rows[i - 1]) && ((n0 == 1) != (n1 == 1)));
        assert_int_equal(f.blocks[2 * i], i);
        assert_int_equal(f.blocks[2 * i + 1], i);
    }
    for (k = 0, i = 1; i < lens.surface_count; i += 2) k += i != lens.stop && (lensopt__index(&lens, i - 1, 510) == 1 || lensopt__index(&lens, i, 510) == 1);
    assert_int_equal(count, k);
    random_point(&f, x);
    p = prescription;
    assert_int_equal(lensopt_coatings_apply(c, x, &p, &error), LFLARE_OK);
    for (i = 0; i < p.surface_count; i++) {
        static lflare_lens coated;
        for (k = 0; k < count && rows[k] != i; k++) {}
        if (i == lens.stop || k < count) continue;
        assert_int_equal(lflare_lens_derive(&p, &coated, &error), LFLARE_OK);
        assert_int_equal(lensopt_reflectance(&lens, i, 0.1, nm, 3, was), LFLARE_OK);
        assert_int_equal(lensopt_reflectance(&coated, i, 0.1, nm, 3, is), LFLARE_OK);
        assert_memory_equal(was, is, sizeof was);
        stacks += p.surfaces[i].coating == LFLARE_COATING_STACK;
    }
    assert_true(stacks > 3 && worst_error(c, x, iris) < 1e-4);
    lensopt_coatings_destroy(c);
    for (i = 0; i < lens.surface_count; i++) target.locks[i] = LENSOPT_LOCK_COATING;
    assert_int_equal(lensopt_coatings_create(&desc, &c, &error), LFLARE_ERROR_LENS);
    assert_true(c == NULL && strstr(error.text, "no surface is free") != NULL);
}

/* Ghosts in another order and without pairs are found by their spots; a few too many, too few, and moved a little, too. */
static void ghosts_are_matched_by_spots(void **state)
{
    static lensopt_target original;
    lensopt_coatings_desc desc;
    lensopt_function f;
    lensopt_coatings *c;
    double iris = read_lens(canon, 5);
    int32_t i, count = target.ghost_count, alone = 0;
    (void)state;
    state_of_random = 9;
    original = target;
    for (i = 0; i < count; i++) { /* the k-th is the (7 k)-th of 171 or fewer */
        target.ghosts[i] = original.ghosts[(7 * i) % count];
        if (i % 3 != 0) target.ghosts[i].pair.first = -1, target.ghosts[i].pair.second = 0;
        target.ghosts[i].goals[0].centre += 1e-7 * random_number();
    }
    assert_true(count % 7 != 0);
    desc = plain(iris, LENSOPT_FILM_QUARTER);
    for (desc.matching = LENSOPT_MATCHING_PAIRS; desc.matching <= LENSOPT_MATCHING_SPOTS; desc.matching = (lensopt_matching)(desc.matching + 1)) {
        c = make(&desc, &f);
        lensopt_coatings_ghosts(c, f.lower, ghosts);
        for (i = 0; i < count; i++) assert_memory_equal(&ghosts[i].pair, &original.ghosts[(7 * i) % count].pair, sizeof(lflare_pair));
        lensopt_coatings_destroy(c);
    }
    target.ghosts[0].goals[0].wish = LENSOPT_SPOT_ANY; /* nothing to go by */
    target.ghosts[0].goals[0].centre = target.ghosts[0].goals[0].radius = 0;
    for (i = 0; i < 30; i++) target.ghosts[target.ghost_count++] = original.ghosts[i]; /* more than the lens can have */
    desc.matching = LENSOPT_MATCHING_SPOTS;
    c = make(&desc, &f);
    lensopt_coatings_ghosts(c, f.lower, ghosts);
    for (i = 0; i < target.ghost_count; i++) alone += ghosts[i].pair.first < 0 && ghosts[i].light < 0;
    assert_int_equal(alone, target.ghost_count - lens.ghost_count);
    assert_int_equal(ghosts[0].pair.first, -1);
    lensopt_coatings_destroy(c);
}

/* A number, or what must not be taken. */
static double random_cost(int kind)
{
    double c = random_number();
    if (c > 0.9) return c > 0.95 ? HUGE_VAL : (double)NAN;
    return kind == 0 ? floor(4 * c) : kind == 1 ? c - 0.5 : 1e6 * c * c * c;
}

/* Prices prove that the sum is the least: no row would rather have another column, or none, and what nobody has costs nothing. Numbers, ties among them,
   negative ones; up to 12 rows and columns, or none; memory that begins anywhere and holds anything. */
static void matches_cost_the_least(void **state)
{
    enum { MOST = 12 };
    static char memory[4000];
    int32_t run, i, j, with = 0, without = 0, left = 0;
    (void)state;
    state_of_random = 10;
    for (run = 0; run < 20000; run++) {
        lensopt__assignment a;
        int32_t rows = (int32_t)(random_number() * (MOST + 1)), columns = (int32_t)(random_number() * (MOST + 1)), shift = 4 * (run % 8);
        assert_true(lensopt__assignment_size(rows, columns) + 28 <= sizeof memory);
        memset(memory, 0xff, sizeof memory);
        lensopt__assignment_in(memory + shift, rows, columns, &a);
        for (i = 0; i < rows; i++) {
            for (j = 0; j < columns; j++) a.cost[i * a.stride + j] = random_cost(run % 3);
            a.none[i] = run % 3 == 2 ? 3e5 * random_number() : 2 * random_number();
        }
        lensopt__assignment_solve(&a);
        for (j = 0; j < columns; j++) {
            assert_true(a.price[j] <= 0 && (a.row_of[j] >= 0 || a.price[j] == 0));
            assert_true(a.row_of[j] < 0 || a.column_of[a.row_of[j]] == j);
            left += a.row_of[j] < 0;
        }
        for (i = 0; i < rows; i++) {
            const double *cost = a.cost + i * a.stride;
            int32_t at = a.column_of[i];
            double has = at < 0 ? a.none[i] : cost[at] - a.price[at], tie = 1e-12 * (run % 3 == 2 ? 1e6 : 1);
            assert_true(at >= -1 && at < columns && (at < 0 || a.row_of[at] == i));
            assert_true(has <= a.none[i] + tie);
            for (j = 0; j < columns; j++) assert_true(!(cost[j] - a.price[j] < has - tie));
            with += at >= 0;
            without += at < 0;
        }
    }
    assert_true(with > 20000 && without > 20000 && left > 20000);
}

/* ---- errors ---- */

static void refused(const lensopt_coatings_desc *desc, lflare_result expected, const char *says)
{
    lflare_error error;
    lensopt_coatings *c = (lensopt_coatings *)&error;
    lflare_result result = lensopt_coatings_create(desc, &c, &error);
    if (result != expected || error.code != expected || strstr(error.text, says) == NULL) fail_msg("%d, not %d: %s", (int)result, (int)expected, error.text);
    assert_true(c == NULL);
    assert_int_equal(lensopt_coatings_create(desc, &c, NULL), expected);
}

static void what_is_wrong_is_said(void **state)
{
    lensopt_coatings_desc good = plain(read_lens(heliar, 2.25), LENSOPT_FILM_QUARTER), d;
    lensopt_function f;
    lensopt_coatings *c;
    lflare_prescription p;
    lflare_error error;
    double x[VARIABLES];
    int32_t i;
    (void)state;
    refused(NULL, LFLARE_ERROR_ARGUMENT, "a lens and a target");
    assert_int_equal(lensopt_coatings_create(&good, NULL, &error), LFLARE_ERROR_ARGUMENT);
    d = good, d.lens = NULL, refused(&d, LFLARE_ERROR_ARGUMENT, "a lens and a target");
    d = good, d.target = NULL, refused(&d, LFLARE_ERROR_ARGUMENT, "a target was expected");
    d = good, d.iris = -1, refused(&d, LFLARE_ERROR_ARGUMENT, "iris");
    d = good, d.iris = (double)NAN, refused(&d, LFLARE_ERROR_ARGUMENT, "iris");
    d = good, d.brightness = -1, refused(&d, LFLARE_ERROR_ARGUMENT, "brightness");
    d = good, d.film = (lensopt_film)2, refused(&d, LFLARE_ERROR_ARGUMENT, "film");
    d = good, d.matching = (lensopt_matching)2, refused(&d, LFLARE_ERROR_ARGUMENT, "matching");
    d = good, d.nm[0] = 500, d.nm[1] = 400, refused(&d, LFLARE_ERROR_ARGUMENT, "design wavelengths within 100 and 20000");
    d = good, d.nm[1] = 400, refused(&d, LFLARE_ERROR_ARGUMENT, "design wavelengths");
    d = good, d.index[0] = 1.2, d.index[1] = 2, refused(&d, LFLARE_ERROR_ARGUMENT, "index within 1.3 and 4");
    d = good, d.thickness[0] = 1, d.thickness[1] = (double)INFINITY, refused(&d, LFLARE_ERROR_ARGUMENT, "thickness within 1 and 10000");
    for (i = 0; i < target.ghost_count; i++) target.ghosts[i].weight = 0;
    refused(&good, LFLARE_ERROR_LENS, "no ghost of the target counts");
    target.light_count = 0;
    refused(&good, LFLARE_ERROR_ARGUMENT, "1 to 8 lights");
    read_lens(heliar, 2.25);
    good.film = LENSOPT_FILM_LAYER;
    c = make(&good, &f);
    random_point(&f, x);
    p = prescription;
    p.surface_count--;
    assert_int_equal(lensopt_coatings_read(c, &p, x), LFLARE_ERROR_ARGUMENT);
    assert_true(lensopt_coatings_apply(c, x, &p, &error) < 0);
    p = prescription;
    assert_int_equal(lensopt_move_stop(&p, 2, 0.5, &error), LFLARE_OK);
    assert_int_equal(lensopt_coatings_apply(c, x, &p, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_coatings_apply(c, NULL, &prescription, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_coatings_apply(c, x, NULL, &error), LFLARE_ERROR_ARGUMENT);
    p = prescription;
    x[0] = (double)NAN;
    assert_true(lensopt_coatings_apply(c, x, &p, &error) < 0);
    assert_memory_equal(&p, &prescription, sizeof p);
    random_point(&f, x);
    p.layer_count = LFLARE_MAX_LAYERS;
    for (i = 0; i < LFLARE_MAX_LAYERS; i++) p.layers[i].n = 1.5, p.layers[i].thickness_nm = 100;
    p.surfaces[1].coating = LFLARE_COATING_STACK;
    p.surfaces[1].layer_count = LFLARE_MAX_LAYERS;
    assert_int_equal(lensopt_coatings_apply(c, x, &p, &error), LFLARE_ERROR_LIMIT);
    assert_non_null(strstr(error.text, "layers"));
    for (i = 0; i < prescription.surface_count; i++) lensopt_coat_bare(&prescription, i, NULL);
    assert_int_equal(lensopt_coatings_read(c, &prescription, x), LFLARE_INCOMPLETE);
    for (i = 0; i < f.variables; i++) assert_true(x[i] == 0.5 * (f.lower[i] + f.upper[i]));
    lensopt_coatings_destroy(c);
    lensopt_coatings_destroy(NULL);
}

static struct { size_t held; int32_t calls, fail_at; } heap;

static void *counted(void *user, void *block, size_t old_size, size_t new_size)
{
    assert_true(user == &heap && (block != NULL || old_size == 0));
    if (new_size > 0 && ++heap.calls == heap.fail_at) return NULL;
    heap.held += new_size;
    heap.held -= old_size;
    if (new_size > 0) return realloc(block, new_size);
    free(block);
    return NULL;
}

static void any_allocation_may_fail(void **state)
{
    lensopt_coatings_desc desc = plain(read_lens(heliar, 2.25), LENSOPT_FILM_LAYER);
    lensopt_coatings *c;
    lflare_error error;
    int32_t film;
    (void)state;
    desc.allocate = counted;
    desc.user = &heap;
    desc.matching = LENSOPT_MATCHING_SPOTS;
    for (film = 0; film < 2; film++) {
        lflare_result result = LFLARE_ERROR_MEMORY;
        desc.film = (lensopt_film)film;
        memset(&heap, 0, sizeof heap);
        for (heap.fail_at = 1; result == LFLARE_ERROR_MEMORY; heap.fail_at++) {
            heap.calls = 0;
            result = lensopt_coatings_create(&desc, &c, &error);
            if (result == LFLARE_OK) break;
            assert_int_equal(result, LFLARE_ERROR_MEMORY);
            assert_string_equal(error.text, "out of memory");
            assert_true(c == NULL && heap.held == 0);
        }
        print_message("%d allocations, %d bytes kept\n", (int)heap.calls, (int)heap.held);
        assert_int_equal(result, LFLARE_OK);
        assert_true(heap.fail_at > 15);
        lensopt_coatings_destroy(c);
        assert_true(heap.held == 0);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {cmocka_unit_test(w_is_that_of_the_coated_lens),
                                              cmocka_unit_test(any_path_counts),
                                              cmocka_unit_test(a_lens_is_its_own_target),
                                              cmocka_unit_test(f_is_the_sum_of_distances),
                                              cmocka_unit_test(derivatives_are_those_of_differences),
                                              cmocka_unit_test(polish_only_improves),
                                              cmocka_unit_test(coatings_are_found_again),
                                              cmocka_unit_test(locked_coatings_stay),
                                              cmocka_unit_test(ghosts_are_matched_by_spots),
                                              cmocka_unit_test(matches_cost_the_least),
                                              cmocka_unit_test(what_is_wrong_is_said),
                                              cmocka_unit_test(any_allocation_may_fail)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
