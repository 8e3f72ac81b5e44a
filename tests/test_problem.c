/* Problems of lensopt.h: points as lenses, the objectives over them, their slopes and polishing. */
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

enum { ROOM = LENSOPT_MAX_VARIABLES, GHOSTS = 400, ROWS = 4000 };
static const char *const heliar = "lenses/heliar-tronnier.lens", *const canon = "lenses/canon-28-80.lens";
static lflare_prescription base;
static lflare_lens lens;
static lensopt_target target;
static int32_t blind; /* of the problems that own_target makes */

static void derive(const char *path)
{
    lflare_error error;
    char *file;
    size_t size;
    assert_int_equal(lflare_file_read(path, NULL, NULL, &file, &size, &error), LFLARE_OK);
    assert_int_equal(lflare_text_read(file, size, &base, &error), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(&base, &lens, &error), LFLARE_OK);
    free(file);
}

/* A problem whose target is what the base itself shows, as the problem sees it: f is 0 at its point. */
static lensopt_problem *base_target(lensopt_objective objective, double degrees, int32_t lights, double *x)
{
    static lensopt_shown shown[GHOSTS];
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lensopt_light light[3] = {{{0, 0}, 1}, {{0, 0}, 1}, {{0, 0}, 2}};
    lflare_error error;
    int32_t l, g, count;
    for (l = 0; l < lights; l++) light[l].direction[0] = light[l].direction[1] = degrees / (1 + l);
    assert_int_equal(lensopt_target_of(&lens, light, lights, 2.25, &target, &error), LFLARE_OK);
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    desc.base = &base;
    desc.iris = 2.25;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    assert_int_equal(lensopt_problem_point(problem, &base, 2.25, x, &error), LFLARE_OK);
    target.ghost_count = lens.ghost_count;
    for (l = 0; l < lights; l++) {
        count = GHOSTS;
        assert_int_equal(lensopt_problem_shows(problem, x, l, shown, &count), LFLARE_OK);
        assert_int_equal(count, lens.ghost_count);
        for (g = 0; g < count; g++) {
            lensopt_goal *goal = &target.ghosts[g].goals[l];
            target.ghosts[g].pair = shown[g].pair;
            target.ghosts[g].weight = 1;
            goal->wish = shown[g].radius > 0 ? LENSOPT_SPOT : LENSOPT_SPOT_HIDDEN;
            goal->centre = shown[g].centre;
            goal->radius = shown[g].radius;
        }
    }
    lensopt_problem_free(problem);
    desc.objective = objective;
    desc.blind = blind;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    return problem;
}

static lensopt_problem *own_target(const char *path, lensopt_objective objective, double degrees, int32_t lights, double *x)
{
    derive(path);
    return base_target(objective, degrees, lights, x);
}

/* Anywhere near x, or (spread 1) anywhere within the bounds. */
static void shaken(const lensopt_function *f, const double *x, double spread, uint64_t *random, double *out)
{
    int32_t v;
    for (v = 0; v < f->variables; v++) {
        double range = f->upper[v] - f->lower[v], y = x[v] + spread * range * (lensopt_random(random) - 0.5);
        if (spread >= 1) y = f->lower[v] + range * lensopt_random(random);
        out[v] = fmin(fmax(y, f->lower[v]), f->upper[v]);
    }
}

/* Against lflare's rays, where nothing but the iris clips them. */
static void spots_are_those_of_the_lens(void **state)
{
    const char *const paths[2] = {heliar, canon};
    static lensopt_shown shown[GHOSTS];
    double x[ROOM], worst = 0;
    int32_t i, g, count, compared = 0;
    (void)state;
    for (i = 0; i < 2; i++) {
        lensopt_problem *problem = own_target(paths[i], LENSOPT_SEEN, 5.45, 3, x);
        count = GHOSTS;
        assert_int_equal(lensopt_problem_shows(problem, x, 1, shown, &count), LFLARE_OK);
        for (g = 0; g < count; g++) {
            lensopt_spot spot;
            lflare_ghost_matrices m;
            lflare_region region;
            double u = lensopt_slope(&target.lights[1]), area;
            assert_int_equal(lensopt_spots(&lens, &shown[g].pair, 1, u, 2.25, &spot), LFLARE_OK);
            assert_int_equal(lflare_ghost_optics(&lens, 510, &shown[g].pair, 1, &m), LFLARE_OK);
            if (lflare_ghost_clip(&lens, 510, shown[g].pair, 2.25, u, &region) == LFLARE_CLIP_HIDDEN) continue;
            area = 3.14159265358979323846 * 2.25 * 2.25 / (m.ma.a * m.ma.a);
            if (fabs(region.area / area - 1) > 1e-9) continue; /* rims cut some of it */
            worst = fmax(worst, fmax(fabs(shown[g].centre - spot.centre), fabs(shown[g].radius - spot.radius)) / (1 + spot.radius));
            compared++;
            assert_true(shown[g].cost < 1e-20);
        }
        lensopt_problem_free(problem);
    }
    printf("           %d spots within %.1e of their size\n", compared, worst);
    assert_true(compared > 80 && worst < 1e-8);
}

/* Algorithm 1 of the thesis over again, one ghost at a time, from lflare's matrices of the lens that a point stands for. */
static double thesis_by_hand(const lensopt_problem *problem, const double *x, double u)
{
    static lflare_lens one;
    lflare_prescription q;
    lflare_pair pairs[GHOSTS];
    double centre[GHOSTS], radius[GHOSTS], wanted[GHOSTS][2], iris, f = 0;
    int32_t count = GHOSTS, g, k, n = 0, goals = 0;
    lflare_error error;
    if (lensopt_problem_prescription(problem, x, &q, &iris, &error) != LFLARE_OK || lflare_lens_derive(&q, &one, &error) != LFLARE_OK) return -1; /* its image is nowhere */
    lflare_ghost_list(&one, pairs, &count);
    for (g = 0; g < count; g++) {
        lflare_ghost_matrices m;
        double r1, r2, c1, c2, r, c;
        lflare_ghost_optics(&one, 510, &pairs[g], 1, &m);
        r1 = 100 * fabs(m.m.a);
        r2 = iris * fabs(m.m.a / m.ma.a);
        c1 = m.m.b * u;
        c2 = (m.m.b - m.m.a * m.ma.b / m.ma.a) * u;
        if (fabs(c1 - c2) > r1 + r2) continue;
        r = fmin(r1, r2);
        c = r1 < r2 ? c1 : c2;
        for (k = n++; k > 0 && radius[k - 1] > r; k--) {
            radius[k] = radius[k - 1];
            centre[k] = centre[k - 1];
        }
        radius[k] = r;
        centre[k] = c;
    }
    for (g = 0; g < target.ghost_count; g++) {
        const lensopt_goal *goal = &target.ghosts[g].goals[0];
        if (goal->wish != LENSOPT_SPOT) continue;
        for (k = goals++; k > 0 && wanted[k - 1][1] > goal->radius; k--) memcpy(wanted[k], wanted[k - 1], sizeof wanted[k]);
        wanted[k][0] = goal->centre;
        wanted[k][1] = goal->radius;
    }
    if (n < goals) return 1e5;
    for (g = 0; g < n; g++)
        f += g < goals ? (centre[g] - wanted[g][0]) * (centre[g] - wanted[g][0]) + (radius[g] - wanted[g][1]) * (radius[g] - wanted[g][1]) : 500 / radius[g];
    return f / goals;
}

static void thesis_is_the_thesis(void **state)
{
    enum { COUNT = 300 };
    static double x[COUNT * ROOM], f[COUNT];
    double own[ROOM], alone, hand;
    lensopt_function function;
    uint64_t random = 3;
    int32_t i, compared = 0, few = 0;
    lensopt_problem *problem = own_target(heliar, LENSOPT_THESIS, 13.4, 1, own);
    (void)state;
    lensopt_problem_function(problem, &function);
    function.evaluate(function.user, own, 1, f);
    assert_true(f[0] < 1e-20);
    for (i = 0; i < COUNT; i++) {
        if (i % 3 == 0) shaken(&function, own, 1, &random, x + i * function.variables);
        else if (i % 3 == 1) shaken(&function, own, 0.02, &random, x + i * function.variables);
        else function.sample(function.user, &random, x + i * function.variables);
    }
    function.evaluate(function.user, x, COUNT, f);
    for (i = 0; i < COUNT; i++) {
        function.evaluate(function.user, x + i * function.variables, 1, &alone);
        assert_true(f[i] == alone); /* whatever shares its lanes */
        hand = thesis_by_hand(problem, x + i * function.variables, lensopt_slope(&target.lights[0]));
        if (hand < 0) continue;
        few += hand == 1e5;
        compared++;
        if (!(fabs(hand - f[i]) <= 1e-6 * fabs(hand) + 1e-18)) fail_msg("point %d: %.10g, by hand %.10g", i, f[i], hand);
    }
    printf("           %d points, %d of them with too few ghosts\n", compared, few);
    assert_true(compared > 100 && few > 10 && few < compared - 50);
    lensopt_problem_free(problem);
}

/* Rows of a problem whose assignment is that of x: with the steps of differences it stays. */
static int32_t residuals(const lensopt_problem *problem, const double *x, double *r, double *jacobian)
{
    int32_t rows = ROWS;
    assert_int_equal(lensopt_problem_residuals(problem, x, r, jacobian, &rows), LFLARE_OK);
    return rows;
}

/* Fourth order central differences; where a step crosses an edge (a ghost hidden, another assignment) the number of rows or a residual jumps, and
   the point is left out and counted. */
static void slopes_are_differences(void **state)
{
    static double jacobian[ROWS * 90], other[ROWS * 90], r[ROWS], at[4][ROWS];
    static const double steps[4] = {-2, -1, 1, 2};
    const struct { const char *path; lensopt_objective objective; int32_t lights, lenses; } table[] = {
        {heliar, LENSOPT_SEEN, 3, 490}, {heliar, LENSOPT_MATCHED, 1, 490}, {canon, LENSOPT_MATCHED, 1, 20}};
    uint64_t random = 11;
    size_t t;
    (void)state;
    for (t = 0; t < sizeof table / sizeof table[0]; t++) {
        double own[ROOM], x[ROOM], worst = 0;
        int32_t k, v, i, s, jumps = 0, compared = 0;
        lensopt_function function;
        lensopt_problem *problem = own_target(table[t].path, table[t].objective, 5.45, table[t].lights, own);
        lensopt_problem_function(problem, &function);
        for (k = 0; k < table[t].lenses; k++) {
            int32_t n = function.variables, rows;
            shaken(&function, own, k % 2 ? 0.01 : 0.05, &random, x);
            rows = residuals(problem, x, r, jacobian);
            for (v = (int32_t)(5 * lensopt_random(&random)); v < n; v += 5) {
                double range = function.upper[v] - function.lower[v], h = 1e-5 * range, kept = x[v], scale = 0, off = 0;
                int same = 1;
                if (x[v] - 2 * h < function.lower[v] || x[v] + 2 * h > function.upper[v]) continue;
                for (s = 0; s < 4; s++) {
                    x[v] = kept + steps[s] * h;
                    same = same && residuals(problem, x, at[s], other) == rows;
                }
                x[v] = kept;
                for (i = 0; i < rows && same; i++) {
                    double d = (at[0][i] - 8 * at[1][i] + 8 * at[2][i] - at[3][i]) / (12 * h), near = at[2][i] - at[1][i], wide = (at[3][i] - at[0][i]) / 2;
                    same = fabs(near - wide) <= 1e-3 * fabs(near) + 1e-8 * fabs(r[i]) + 1e-12; /* smooth here: the step does not matter */
                    scale = fmax(scale, fabs(jacobian[i * n + v]));
                    off = fmax(off, fabs(d - jacobian[i * n + v]));
                }
                if (!same) jumps++;
                else if (scale > 0) {
                    compared++;
                    worst = fmax(worst, off / scale);
                }
            }
        }
        printf("           %s: %d columns of %d lenses within %.1e, %d left out\n", table[t].path, compared, table[t].lenses, worst, jumps);
        assert_true(worst < 1e-6 && compared > 2 * table[t].lenses && jumps < compared / 5);
        lensopt_problem_free(problem);
    }
}

/* Polishing never makes worse, stays within bounds, keeps order and stop, and finds back from nearby. */
static void polishing_goes_downhill(void **state)
{
    lensopt_objective objective;
    (void)state;
    for (objective = LENSOPT_SEEN; objective <= LENSOPT_THESIS; objective = (lensopt_objective)(objective + 1)) {
        double own[ROOM], x[ROOM], start[ROOM], before, after, again;
        lensopt_function function;
        lensopt_problem *problem;
        blind = 1; /* with the thesis' own pairs */
        problem = own_target(heliar, objective, 13.4, objective == LENSOPT_SEEN ? 2 : 1, own);
        uint64_t random = 1;
        int32_t i, v, back = 0;
        lensopt_problem_function(problem, &function);
        for (i = 0; i < 60; i++) {
            shaken(&function, own, i % 2 ? 0.001 : 0.3, &random, x);
            memcpy(start, x, sizeof x);
            function.evaluate(function.user, x, 1, &before);
            after = HUGE_VAL; /* not known */
            assert_true(function.polish(function.user, x, &after, 60) > 0);
            assert_true(after <= before);
            again = before;
            function.polish(function.user, start, &again, 60);
            assert_true(again == after);
            function.evaluate(function.user, x, 1, &again);
            assert_true(fabs(again - after) <= 1e-9 * after + 1e-20);
            for (v = 0; v < function.variables; v++) assert_true(x[v] >= function.lower[v] && x[v] <= function.upper[v]);
            back += i % 2 && after < 1e-12;
        }
        printf("           %d of 30 found back\n", back);
        assert_true(back >= 15);
        lensopt_problem_free(problem);
        blind = 0;
    }
}

/* Assignments of six goals to thirteen ghosts: no exchange makes them cheaper. */
static void pairs_cost_least(void **state)
{
    static lensopt_shown shown[GHOSTS];
    double own[ROOM], x[ROOM], f;
    lensopt_function function;
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lflare_error error;
    uint64_t random = 5;
    int32_t i, k, g, h, count;
    (void)state;
    lensopt_problem_free(own_target(heliar, LENSOPT_MATCHED, 5.45, 1, own));
    target.ghost_count = 6;
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    desc.base = &base;
    desc.objective = LENSOPT_MATCHED;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, &function);
    for (i = 0; i < 100; i++) {
        double sum = 0;
        shaken(&function, own, 0.1, &random, x);
        function.evaluate(function.user, x, 1, &f);
        count = GHOSTS;
        assert_int_equal(lensopt_problem_shows(problem, x, 0, shown, &count), LFLARE_OK);
        for (k = 0; k < count; k++) sum += shown[k].cost;
        assert_true(fabs(sum - f) <= 1e-9 * f);
        /* no exchange of two, and none with a ghost too many, is better */
        for (g = 0; g < count; g++)
            for (h = 0; h < count; h++) {
                double now, then = 0;
                int32_t a = shown[g].ghost, b = shown[h].ghost, side;
                if (a < 0 || h == g) continue;
                now = shown[g].cost + shown[h].cost;
                for (side = 0; side < 2; side++) {
                    const lensopt_shown *s = side ? &shown[g] : &shown[h];
                    int32_t ghost = side ? b : a;
                    const lensopt_goal *goal = ghost >= 0 ? &target.ghosts[ghost].goals[0] : NULL;
                    if (goal != NULL) then += ((s->centre - goal->centre) * (s->centre - goal->centre) + (s->radius - goal->radius) * (s->radius - goal->radius)) / 6;
                    else then += s->radius > 0 ? 500 / s->radius : 0;
                }
                if (shown[g].radius > 0 && shown[h].radius > 0 && !(then >= now * (1 - 1e-9))) fail_msg("lens %d: exchanging %d and %d: %g to %g", i, g, h, now, then);
            }
    }
    lensopt_problem_free(problem);
}

/* Lenses of points show what their points show, but for what rims cut; points of lenses are the lenses. */
static void points_are_lenses(void **state)
{
    double own[ROOM], x[ROOM], iris, worst = 0;
    static lflare_prescription q;
    static lflare_lens one;
    static lensopt_shown shown[GHOSTS];
    lensopt_function function;
    lensopt_problem *problem = own_target(heliar, LENSOPT_SEEN, 5.45, 1, own);
    lflare_error error;
    uint64_t random = 9;
    int32_t i, g, v, count, made = 0, whole = 0, all = 0;
    (void)state;
    lensopt_problem_function(problem, &function);
    for (i = 0; i < 60; i++) {
        double again[ROOM];
        shaken(&function, own, i == 0 ? 0 : 0.02, &random, x);
        if (lensopt_problem_prescription(problem, x, &q, &iris, &error) != LFLARE_OK) continue;
        made++;
        assert_int_equal(lflare_lens_derive(&q, &one, &error), LFLARE_OK);
        assert_int_equal(lensopt_problem_point(problem, &q, iris, again, &error), LFLARE_OK);
        for (v = 0; v < function.variables; v++) assert_true(fabs(again[v] - x[v]) <= 1e-8 * (function.upper[v] - function.lower[v]) || function.blocks[v] > 0); /* clamped gaps and air */
        count = GHOSTS;
        assert_int_equal(lensopt_problem_shows(problem, x, 0, shown, &count), LFLARE_OK);
        assert_int_equal(count, one.ghost_count);
        for (g = 0; g < count; g++) {
            lensopt_spot spot;
            assert_int_equal(lensopt_spots(&one, &shown[g].pair, 1, lensopt_slope(&target.lights[0]), iris, &spot), LFLARE_OK);
            all++;
            if (fabs(spot.radius / shown[g].radius - 1) > 1e-3) continue; /* cut */
            whole++;
            worst = fmax(worst, fabs(spot.centre - shown[g].centre) / (1 + spot.radius));
        }
    }
    printf("           %d lenses, %d of %d ghosts uncut, those within %.1e\n", made, whole, all, worst);
    assert_true(made > 40 && whole > all * 8 / 10 && worst < 2e-3);
    lensopt_problem_free(problem);
}

/* What makes a lens a lens, searched for from the Heliar shaken: within all ranges after polishing. */
static void constraints_hold(void **state)
{
    double own[ROOM], x[ROOM], iris, f;
    static lflare_prescription q;
    lensopt_function function;
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lflare_error error;
    uint64_t random = 4;
    int32_t i, row, good = 0, made = 0;
    (void)state;
    lensopt_problem_free(own_target(heliar, LENSOPT_SEEN, 5.45, 1, own));
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    desc.base = &base;
    desc.iris = 2.25;
    desc.efl.lo = 99;
    desc.efl.hi = 101.5;
    desc.focus = 0.05;
    desc.length.lo = 50;
    desc.length.hi = 150;
    desc.glass_edge = 0.5;
    desc.air_edge = 0.01;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, &function);
    for (i = 0; i < 20; i++) {
        shaken(&function, own, 0.01, &random, x);
        f = HUGE_VAL;
        function.polish(function.user, x, &f, 200);
        if (f > 0.01) continue;
        made++;
        assert_int_equal(lensopt_problem_prescription(problem, x, &q, &iris, &error), LFLARE_OK);
        assert_int_equal(lflare_lens_derive(&q, &lens, &error), LFLARE_OK);
        good += lens.efl > 98.5 && lens.efl < 102 && fabs(lens.bfd - q.surfaces[q.surface_count - 1].thickness) < 0.6;
        for (row = 0; row + 1 < q.surface_count; row++) { /* of the lens as it is written */
            const lflare_surface *s = &q.surfaces[row];
            const lflare_surface *next = s[1].is_stop ? &s[2] : &s[1];
            double rim = fmin(s->semi_diameter, next->semi_diameter), gap = s->thickness + (next > s + 1 ? s[1].thickness : 0), edge = gap + lflare_sag(next, rim) - lflare_sag(s, rim);
            if (!s->is_stop) assert_true(edge >= (s->medium.kind == LFLARE_MEDIUM_AIR ? 0.01 : 0.5) - 1e-6);
        }
    }
    printf("           %d lenses, %d within their ranges\n", made, good);
    assert_true(made >= 5 && good == made);
    lensopt_problem_free(problem);
}

static void locks_keep(void **state)
{
    double own[ROOM], x[ROOM], iris;
    static lflare_prescription q;
    lensopt_function function;
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lflare_error error;
    uint64_t random = 8;
    int32_t i, v, all;
    (void)state;
    problem = own_target(heliar, LENSOPT_SEEN, 5.45, 1, own);
    lensopt_problem_function(problem, &function);
    all = function.variables;
    lensopt_problem_free(problem);
    target.locks[0] = LENSOPT_LOCK_RADIUS | LENSOPT_LOCK_MEDIUM;
    target.locks[2] = LENSOPT_LOCK_GAP;
    target.stop_locks = LENSOPT_LOCK_STOP_RADIUS | LENSOPT_LOCK_STOP_PLACE;
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    desc.base = &base;
    desc.keep_order = 1;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, &function);
    assert_int_equal(function.variables, all - 3 - 2 - 2); /* and the two indices of air */
    for (i = 0; i < 50; i++) {
        for (v = 0; v < function.variables; v++) x[v] = function.lower[v] + lensopt_random(&random) * (function.upper[v] - function.lower[v]);
        if (lensopt_problem_prescription(problem, x, &q, &iris, &error) != LFLARE_OK) continue;
        assert_true(q.surfaces[0].radius == base.surfaces[0].radius && q.surfaces[0].medium.c[0] == base.surfaces[0].medium.c[0]);
        assert_true(fabs(q.surfaces[2].thickness - base.surfaces[2].thickness) < 1e-12);
        assert_true(q.surfaces[5].is_stop && q.surfaces[5].semi_diameter == base.surfaces[5].semi_diameter);
    }
    lensopt_problem_free(problem);
}

/* Short searches find lenses for what arbitrary ghosts ask. */
static void searches_find(void **state)
{
    double own[ROOM];
    lensopt_search_desc desc;
    lensopt_search *search;
    lensopt_limits limits = {0, 600000, 1e-9};
    lensopt_progress end;
    lflare_error error;
    lensopt_problem *problem;
    (void)state;
    blind = 1;
    problem = own_target(heliar, LENSOPT_MATCHED, 13.4, 1, own);
    blind = 0;
    memset(&desc, 0, sizeof desc);
    lensopt_problem_function(problem, &desc.function);
    desc.seed = 1;
    assert_int_equal(lensopt_search_create(&desc, &search, &error), LFLARE_OK);
    assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, &error), LFLARE_OK);
    assert_int_equal(lensopt_search_status(search, &end), LFLARE_OK);
    printf("           f %.3g after %.0f evaluations\n", end.best, (double)end.evaluations);
    assert_true(end.best < 30); /* random points: 500 and more */
    lensopt_search_free(search);
    lensopt_problem_free(problem);
}

/* -- what is wrong -- */

static int left;
static void *failing(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(block);
        return NULL;
    }
    return left-- > 0 ? realloc(block, new_size) : NULL;
}

static void refused(lensopt_problem_desc desc, const char *word)
{
    lensopt_problem *problem = NULL;
    lflare_error error;
    assert_true(lensopt_problem_create(&desc, &problem, &error) < 0);
    assert_null(problem);
    if (strstr(error.text, word) == NULL) fail_msg("'%s' does not say '%s'", error.text, word);
}

static void errors_say_what(void **state)
{
    static lensopt_target empty;
    lensopt_problem_desc good, bad;
    lensopt_problem *problem;
    lensopt_function function;
    lflare_error error;
    double own[ROOM], f = 1;
    int32_t none = 0, i;
    (void)state;
    lensopt_problem_free(own_target(heliar, LENSOPT_SEEN, 5.45, 2, own));
    memset(&good, 0, sizeof good);
    good.target = &target;
    good.base = &base;
    bad = good;
    bad.target = NULL;
    refused(bad, "target");
    bad.target = &empty;
    refused(bad, "sensor");
    bad = good;
    bad.air_gap.lo = 5;
    bad.air_gap.hi = 4;
    refused(bad, "air_gap");
    bad = good;
    bad.efl.lo = (double)NAN;
    refused(bad, "efl");
    bad = good;
    bad.surfaces = 5;
    refused(bad, "surfaces");
    bad = good;
    bad.pupil = -1;
    refused(bad, "pupil");
    bad = good;
    bad.objective = (lensopt_objective)7;
    refused(bad, "objective");
    bad = good;
    bad.base = NULL;
    bad.keep_order = 1;
    refused(bad, "keep_order");
    empty = target;
    empty.ghosts[3].weight = (double)NAN;
    bad = good;
    bad.target = &empty;
    refused(bad, "ghost 4");
    empty = target;
    for (i = 0; i < empty.ghost_count; i++) empty.ghosts[i].weight = 0;
    refused(bad, "asks for no spot");
    empty = target;
    for (i = 0; i < LFLARE_MAX_SURFACES; i++) empty.locks[i] = 15;
    empty.stop_locks = 3;
    refused(bad, "locked");
    empty = target;
    empty.ghost_count = LENSOPT_MAX_GHOSTS;
    for (i = 0; i < LENSOPT_MAX_GHOSTS; i++) empty.ghosts[i] = target.ghosts[0];
    bad.base = NULL;
    refused(bad, "992");
    /* memory */
    good.allocate = failing;
    left = 0;
    refused(good, "memory");
    left = 1;
    refused(good, "spots");
    left = 2;
    assert_int_equal(lensopt_problem_create(&good, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, &function);
    function.evaluate(function.user, own, 1, &f);
    assert_true(f == HUGE_VAL);
    assert_int_equal(function.polish(function.user, own, &f, 3), 0);
    assert_int_equal(lensopt_problem_shows(problem, own, 0, NULL, &none), LFLARE_ERROR_MEMORY);
    assert_int_equal(lensopt_problem_residuals(problem, own, NULL, NULL, &none), LFLARE_ERROR_MEMORY);
    left = 9;
    assert_int_equal(lensopt_problem_shows(problem, own, 0, NULL, &none), LFLARE_INCOMPLETE);
    assert_int_equal(none, lens.ghost_count);
    assert_int_equal(lensopt_problem_shows(problem, own, 2, NULL, &none), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_problem_point(problem, &base, -1, own, &error), LFLARE_ERROR_ARGUMENT);
    derive(canon);
    assert_int_equal(lensopt_problem_point(problem, &base, 0, own, &error), LFLARE_ERROR_LENS);
    lensopt_problem_free(problem);
    lensopt_problem_free(NULL);
}

static lflare_medium abbe_glass(double nd, double vd, const char *name)
{
    lflare_medium m;
    memset(&m, 0, sizeof m);
    m.kind = LFLARE_MEDIUM_ABBE;
    m.c[0] = nd;
    m.c[1] = vd;
    strcpy(m.glass, name);
    return m;
}

/* Whether all glasses of a lens are of the list, or the base's own. */
static int of_the_list(const lflare_prescription *q, const lflare_medium *glasses, int32_t count)
{
    int32_t row, k, i;
    for (row = 0; row < q->surface_count; row++) {
        const lflare_medium *m = &q->surfaces[row].medium;
        if (m->kind == LFLARE_MEDIUM_AIR) continue;
        for (k = 0; k < count && memcmp(m, &glasses[k], sizeof *m) != 0; k++) {}
        for (i = 0; i < base.surface_count && memcmp(m, &base.surfaces[i].medium, sizeof *m) != 0; i++) {}
        if (k == count && i == base.surface_count) return 0;
    }
    return 1;
}

/* -- lenses read from spots -- */

/* Samples of a problem: how many show all spots of its target; *x: the best. */
static int32_t readings(const lensopt_function *function, int32_t samples, double *x, double *best)
{
    double one[ROOM], f;
    uint64_t random = 5;
    int32_t i, v, exact = 0;
    for (i = 0, *best = HUGE_VAL; i < samples; i++) {
        function->sample(function->user, &random, one);
        for (v = 0; v < function->variables; v++) assert_true(one[v] >= function->lower[v] && one[v] <= function->upper[v]);
        function->evaluate(function->user, one, 1, &f);
        exact += f < 1e-15;
        if (f >= *best) continue;
        *best = f;
        memcpy(x, one, sizeof one);
    }
    return exact;
}

/* The spots of lenses of 6 to 32 surfaces, in no order and without their pairs, are those of other lenses, too, which samples are, by lflare's own matrices. */
static void spots_tell_their_lens(void **state)
{
    static const char *const paths[] = {"lenses/cooke-triplet-smith.lens", "lenses/heliar-tronnier.lens",       "lenses/topogon.lens",
                                        "lenses/dagor.lens",               "lenses/speed-panchro.lens",         "lenses/apo-telyt-280.lens",
                                        "lenses/planar-50-14.lens",        "lenses/fisheye-minolta-16.lens",    "lenses/nikon-80-200-mid.lens",
                                        "lenses/nikkor-80-200-afs.lens"};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        double own[ROOM], x[ROOM], best, hand, off = 0;
        int32_t v, exact;
        lensopt_function function;
        lensopt_problem *problem = own_target(paths[i], LENSOPT_THESIS, 5.45, 1, own);
        lensopt_problem_function(problem, &function);
        exact = readings(&function, 200, x, &best);
        for (v = 0; v < function.variables; v++) off += fabs(x[v] - own[v]) / (function.upper[v] - function.lower[v]) / function.variables;
        hand = thesis_by_hand(problem, x, lensopt_slope(&target.lights[0]));
        printf("           %-32s %d of 200, f %.1e, by hand %.1e, %.0f %% of the ranges off the lens\n", paths[i], exact, best, hand, 100 * off);
        if (exact == 0 || hand < 0 || hand > 1e-15 || off < 0.005) fail_msg("%s was not read", paths[i]);
        lensopt_problem_free(problem);
    }
}

/* Goals with a ghost that is where they ask for it. */
static int32_t hits(const lensopt_problem *problem, const double *x)
{
    static lensopt_shown shown[GHOSTS];
    int32_t k, g, count = GHOSTS, n = 0;
    assert_int_equal(lensopt_problem_shows(problem, x, 0, shown, &count), LFLARE_OK);
    for (g = 0; g < target.ghost_count; g++) {
        const lensopt_goal *goal = &target.ghosts[g].goals[0];
        for (k = 0; k < count && (fabs(shown[k].centre - goal->centre) > 1e-6 * (1 + fabs(goal->centre)) || fabs(shown[k].radius - goal->radius) > 1e-6 * (1 + goal->radius)); k++) {}
        n += k < count;
    }
    return n;
}

/* A third of the Canon's spots moved, or a quarter of them gone; or all of them larger and further out, which is another lens's flare. */
static void edited_spots_tell_it_too(void **state)
{
    int32_t way;
    (void)state;
    for (way = 0; way < 3; way++) {
        double own[ROOM], x[ROOM], one[ROOM];
        lensopt_problem_desc desc;
        lensopt_problem *problem;
        lensopt_function function;
        lflare_error error;
        uint64_t random = 21;
        double efl;
        int32_t g, i, k = 0, moved = 0, most = 0, n, front, behind;
        lensopt_problem_free(own_target(canon, LENSOPT_SEEN, 5.45, 1, own));
        for (g = 0; g < target.ghost_count; g++) {
            lensopt_goal *goal = &target.ghosts[g].goals[0];
            double r = lensopt_random(&random);
            if (way == 1 && r < 0.25) continue;
            if (way == 2) goal->centre *= 1.1, goal->radius *= 1.2;
            if (way == 0 && r < 0.33) {
                goal->centre += 2 * lensopt_random(&random);
                goal->radius *= 1.1;
                moved++;
            }
            target.ghosts[k++] = target.ghosts[g];
        }
        target.ghost_count = k;
        memset(&desc, 0, sizeof desc);
        desc.target = &target;
        assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK); /* from scratch; how many surfaces the spots tell */
        assert_int_equal(lensopt_problem_reading(problem, &front, &behind, &efl), 1);
        assert_true(front == 15 && behind == 12 && fabs(efl / lens.efl - (way == 2 ? 1.1 : 1)) < 0.003);
        lensopt_problem_function(problem, &function);
        for (i = 0; i < 400 && most < k - moved - 2; i++) {
            function.sample(function.user, &random, one);
            n = hits(problem, one);
            if (n <= most) continue;
            most = n;
            memcpy(x, one, sizeof one);
        }
        printf("           %d of %d spots, of which %d were moved, after %d samples\n", most, k, moved, i);
        assert_true(most >= k - moved - 2); /* the pupil bounds one, and a spot that was moved may have told which of two surfaces is in front */
        lensopt_problem_free(problem);
    }
}

/* The problem of the target from scratch, with so many surfaces, or (0) as many as it takes. */
static lensopt_problem *from_nothing(int32_t surfaces, lensopt_function *function)
{
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lflare_error error;
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    desc.surfaces = surfaces;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, function);
    return problem;
}

static void add_spot(double centre, double radius)
{
    lensopt_ghost *ghost = &target.ghosts[target.ghost_count++];
    memset(ghost, 0, sizeof *ghost);
    ghost->pair.first = -1;
    ghost->weight = 1;
    ghost->goals[0].wish = LENSOPT_SPOT;
    ghost->goals[0].centre = centre;
    ghost->goals[0].radius = radius;
}

/* Spots that no lens has: two that each say of two surfaces that the other one is in front, spots in rows, in rings, all alike. What matters is that all of it ends. */
static void odd_spots_end(void **state)
{
    enum { MANY = 160 };
    /* the Canon's last surface, were it in front of others behind the stop */
    static const double reversed[11][2] = {{-1.96947490281, 8.07581625339},  {-0.658175544426, 11.6202277324}, {0.676731428328, 1.83709168436},
                                           {-1.10777331398, 5.50931738998},  {-2.30143083844, 4.25208008674},  {1.1253427261, 0.960869957305},
                                           {2.66301919426, 0.289431656648},  {0.306128461659, 7.34706953728},  {-0.315785071928, 3.55218943808},
                                           {7.05608487958, 4.15302087133},   {6.00815938361, 4.83561086864}};
    double own[ROOM], x[ROOM], best;
    lensopt_function function;
    lensopt_problem *problem;
    int32_t i, kind;
    (void)state;
    lensopt_problem_free(own_target(canon, LENSOPT_SEEN, 5.45, 1, own));
    for (i = 0; i < 11; i++) add_spot(reversed[i][0], reversed[i][1]);
    problem = from_nothing(27, &function);
    readings(&function, 20, x, &best);
    lensopt_problem_free(problem);
    problem = from_nothing(0, &function); /* a few spots too many do not matter */
    assert_int_equal(function.variables, 3 * 27 - 1 + 2);
    lensopt_problem_free(problem);
    for (kind = 0; kind < 5; kind++) {
        target.ghost_count = 0;
        for (i = 0; i < MANY; i++) {
            if (kind == 0) add_spot(i + 1, 0.1 * (i + 1));
            else if (kind == 1) add_spot(i - 80, 1);
            else if (kind == 2) add_spot(i % 12 - 5, 1 + i / 12);
            else if (kind == 3) add_spot(3, 2);
            else add_spot(0, 0.1 * (i + 1));
        }
        problem = from_nothing(0, &function);
        readings(&function, 4, x, &best);
        lensopt_problem_free(problem);
    }
}

/* The stop in front of all, known by nothing but the spots; a light that counts for nothing is not read. */
static void stop_in_front_is_read(void **state)
{
    double own[ROOM], x[ROOM], best, efl;
    lensopt_function function;
    lensopt_problem *problem;
    lflare_surface stop;
    lflare_error error;
    int32_t row, front, behind, exact;
    (void)state;
    derive("lenses/planar-50-14.lens");
    base = lens.prescription;
    for (row = 0; !base.surfaces[row].is_stop; row++) {}
    stop = base.surfaces[row];
    base.surfaces[row - 1].thickness += stop.thickness;
    memmove(&base.surfaces[1], &base.surfaces[0], sizeof stop * (size_t)row);
    stop.thickness = 12;
    base.surfaces[0] = stop;
    base.fnumber = 0;
    assert_int_equal(lflare_lens_derive(&base, &lens, &error), LFLARE_OK);
    lensopt_problem_free(base_target(LENSOPT_SEEN, 5.45, 1, own));
    problem = from_nothing(0, &function);
    assert_int_equal(lensopt_problem_reading(problem, &front, &behind, &efl), 1);
    exact = readings(&function, 100, x, &best);
    printf("           %d + %d surfaces, %d of 100, f %.1e\n", front, behind, exact, best);
    assert_true(front == 0 && behind == 13 && exact > 0);
    lensopt_problem_free(problem);
    target.lights[1] = target.lights[0];
    target.lights[0].weight = 0;
    target.light_count = 2;
    for (row = 0; row < target.ghost_count; row++) {
        target.ghosts[row].goals[1] = target.ghosts[row].goals[0];
        target.ghosts[row].goals[1].radius = 1 + row % 7;
    }
    problem = from_nothing(14, &function);
    assert_int_equal(lensopt_problem_reading(problem, &front, &behind, &efl), 0);
    lensopt_problem_free(problem);
}

/* Locks, blindness: no lens is read. Order and glasses stay what they have to be. */
static void readings_keep_what_is_asked(void **state)
{
    enum { SAMPLES = 200 };
    lflare_medium glasses[8];
    double own[ROOM], x[ROOM], same[ROOM], best;
    static lflare_prescription q;
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lensopt_function function;
    lflare_error error;
    uint64_t one = 9, two = 9;
    double efl;
    int32_t way, i, front, behind;
    (void)state;
    for (i = 0; i < 8; i++) glasses[i] = abbe_glass(1.5 + 0.05 * i, 60 - 4 * i, "");
    for (way = 0; way < 4; way++) {
        lensopt_problem_free(own_target(heliar, LENSOPT_SEEN, 13.4, 1, own));
        memset(&desc, 0, sizeof desc);
        desc.target = &target;
        desc.base = &base;
        desc.iris = 2.25;
        desc.blind = way == 0;
        desc.keep_order = way == 2;
        if (way == 1) target.locks[2] = LENSOPT_LOCK_RADIUS;
        if (way == 3) desc.glasses = glasses, desc.glass_count = 8;
        assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
        lensopt_problem_function(problem, &function);
        assert_int_equal(lensopt_problem_reading(problem, &front, &behind, &efl), way >= 2);
        i = readings(&function, SAMPLES, x, &best);
        printf("           %d of %d, f %.1e\n", i, (int)SAMPLES, best);
        assert_true(way < 2 ? i == 0 && best > 1e-3 : i > 0);
        if (way >= 2) assert_int_equal(lensopt_problem_prescription(problem, x, &q, NULL, &error), LFLARE_OK);
        for (i = 0; i < q.surface_count && way == 2; i++) assert_int_equal(q.surfaces[i].medium.kind == LFLARE_MEDIUM_AIR, base.surfaces[i].medium.kind == LFLARE_MEDIUM_AIR);
        if (way == 3) assert_true(of_the_list(&q, glasses, 8));
        for (i = 0; i < 5; i++) {
            function.sample(function.user, &one, x);
            function.sample(function.user, &two, same);
            assert_true(one == two);
            assert_memory_equal(x, same, sizeof *x * (size_t)function.variables);
        }
        lensopt_problem_free(problem);
    }
}

/* A list of glasses, in any order, two alike: lenses have no others, what points show is what these show, and polishing changes none. */
static void glasses_from_a_list(void **state)
{
    static lflare_prescription q, unpolished;
    lflare_medium glasses[6], air;
    double own[ROOM], x[ROOM], before[ROOM], f, after, again, worst = 0;
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lensopt_function function;
    lflare_error error;
    uint64_t random = 12;
    int32_t i, k, v, made = 0, used = 0;
    (void)state;
    glasses[0] = abbe_glass(1.7552, 27.6, "N-SF4");
    glasses[1] = abbe_glass(1.5168, 64.2, "N-BK7");
    glasses[2] = abbe_glass(1.5168, 64.2, "S-BSL7");
    glasses[3] = abbe_glass(1.8467, 23.8, "N-SF57");
    glasses[4] = abbe_glass(1.6204, 60.3, "N-SK16");
    glasses[5] = abbe_glass(1.4339, 95.2, "CAF2");
    lensopt_problem_free(own_target(heliar, LENSOPT_SEEN, 5.45, 1, own));
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    desc.base = &base;
    desc.iris = 2.25;
    desc.glasses = glasses;
    desc.glass_count = 6;
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, &function);
    assert_int_equal(lensopt_problem_point(problem, &base, 2.25, own, &error), LFLARE_OK);
    function.evaluate(function.user, own, 1, &f);
    assert_true(f < 1e-18); /* its own glasses are there, too */
    for (i = 0; i < 100; i++) {
        double iris;
        shaken(&function, own, i == 0 ? 0 : 0.1, &random, x);
        function.evaluate(function.user, x, 1, &f);
        memcpy(before, x, sizeof x);
        after = f;
        function.polish(function.user, x, &after, 20);
        assert_true(after <= f);
        if (lensopt_problem_prescription(problem, x, &q, &iris, &error) != LFLARE_OK) continue;
        made++;
        assert_true(of_the_list(&q, glasses, 6));
        if (lensopt_problem_prescription(problem, before, &unpolished, NULL, &error) == LFLARE_OK)
            for (v = 0; v < q.surface_count; v++) assert_memory_equal(&unpolished.surfaces[v].medium, &q.surfaces[v].medium, sizeof(lflare_medium));
        for (v = 0; v < q.surface_count; v++) {
            for (k = 0; k < 6; k++) used |= (memcmp(&q.surfaces[v].medium, &glasses[k], sizeof glasses[k]) == 0) << k;
            assert_true(strcmp(q.surfaces[v].medium.glass, "S-BSL7") != 0); /* the first of two alike */
        }
        assert_int_equal(lensopt_problem_point(problem, &q, iris, before, &error), LFLARE_OK);
        function.evaluate(function.user, before, 1, &again);
        function.evaluate(function.user, x, 1, &after);
        worst = fmax(worst, fabs(again - after) / (after + 1e-9)); /* the lens's own indices give the same spots */
    }
    print_message("           %d lenses, the same within %.1e\n", made, worst);
    assert_true(made > 20 && (used & (used - 1)) != 0 && worst < 1e-6);
    lensopt_problem_free(problem);
    desc.index.lo = 1.7;
    desc.index.hi = 1.8;
    desc.base = NULL; /* one glass is left */
    assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
    lensopt_problem_function(problem, &function);
    for (i = 0; i < 20; i++) {
        function.sample(function.user, &random, x);
        if (lensopt_problem_prescription(problem, x, &q, NULL, &error) != LFLARE_OK) continue;
        for (v = 0; v < q.surface_count; v++) assert_true(q.surfaces[v].is_stop || q.surfaces[v].medium.kind == LFLARE_MEDIUM_AIR || memcmp(&q.surfaces[v].medium, &glasses[0], sizeof glasses[0]) == 0);
    }
    lensopt_problem_free(problem);
    desc.index.hi = 1.71;
    refused(desc, "within 1.7 and 1.71");
    memset(&desc.index, 0, sizeof desc.index);
    desc.glass_count = LENSOPT_MAX_GLASSES + 1;
    refused(desc, "1 to 1024");
    desc.glass_count = 0;
    refused(desc, "1 to 1024");
    desc.glass_count = 6;
    memset(&air, 0, sizeof air);
    air.kind = LFLARE_MEDIUM_AIR;
    glasses[3] = air;
    refused(desc, "glasses[3]");
    desc.glasses = NULL;
    refused(desc, "1 to 1024");
}

/* From scratch: as few surfaces as the thesis' formula says, and samples that have so many ghosts. */
static void from_scratch(void **state)
{
    static const int32_t surfaces[3][2] = {{5, 6}, {10, 8}, {15, 9}};
    static lensopt_shown shown[GHOSTS];
    double x[ROOM], iris;
    static lflare_prescription q;
    lensopt_problem_desc desc;
    lensopt_problem *problem;
    lensopt_function function;
    lflare_error error;
    uint64_t random = 2;
    int32_t i, k, count, enough = 0, made = 0;
    (void)state;
    lensopt_problem_free(own_target(canon, LENSOPT_SEEN, 5.45, 1, x));
    memset(&desc, 0, sizeof desc);
    desc.target = &target;
    for (i = 0; i < 3; i++) {
        target.ghost_count = surfaces[i][0];
        for (k = 0; k < target.ghost_count; k++) {
            target.ghosts[k].goals[0].wish = LENSOPT_SPOT;
            target.ghosts[k].goals[0].centre = k - 3;
            target.ghosts[k].goals[0].radius = 1 + 0.3 * k;
        }
        assert_int_equal(lensopt_problem_create(&desc, &problem, &error), LFLARE_OK);
        lensopt_problem_function(problem, &function);
        assert_int_equal(function.variables, 3 * surfaces[i][1] - 1 + 2);
        for (k = 0; k < 50; k++) {
            function.sample(function.user, &random, x);
            count = GHOSTS;
            assert_int_equal(lensopt_problem_shows(problem, x, 0, shown, &count), LFLARE_OK);
            enough += count >= target.ghost_count;
            made += lensopt_problem_prescription(problem, x, &q, &iris, &error) == LFLARE_OK;
        }
        lensopt_problem_free(problem);
    }
    printf("           %d of 150 samples with enough ghosts, %d make a picture somewhere\n", enough, made);
    assert_true(enough == 150 && made > 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spots_are_those_of_the_lens), cmocka_unit_test(thesis_is_the_thesis),   cmocka_unit_test(slopes_are_differences),
        cmocka_unit_test(polishing_goes_downhill),     cmocka_unit_test(pairs_cost_least),       cmocka_unit_test(points_are_lenses),
        cmocka_unit_test(glasses_from_a_list),         cmocka_unit_test(constraints_hold),       cmocka_unit_test(locks_keep),
        cmocka_unit_test(searches_find),               cmocka_unit_test(errors_say_what),        cmocka_unit_test(from_scratch),
        cmocka_unit_test(spots_tell_their_lens),       cmocka_unit_test(edited_spots_tell_it_too), cmocka_unit_test(readings_keep_what_is_asked),
        cmocka_unit_test(odd_spots_end),               cmocka_unit_test(stop_in_front_is_read)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
