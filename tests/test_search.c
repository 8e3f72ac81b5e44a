/* The search of lensopt.h: every method finds what it should; threads, interruptions and checkpoints change nothing; what fails says why.
   With the argument `threads` only what threads share is run, for ThreadSanitizer. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* what a search has nothing to do with would take most of the time that compiling takes */
#define LFLARE_NO_STDIO
#define LFLARE_NO_ABERRATION
#define LFLARE_NO_DIFFRACTION
#define LFLARE_NO_TRACE
#define LFLARE_NO_SOFTWARE
#define LFLARE_NO_GL
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSOPT_IMPLEMENTATION
#include "lensopt.h"

enum { METHODS = 4 };
static const lensopt_method methods[METHODS] = {LENSOPT_MEMETIC, LENSOPT_DE, LENSOPT_JDE, LENSOPT_PSO};

/* ---- functions ---- */

typedef double (*test_function)(const double *x, int32_t n);

static double sphere(const double *x, int32_t n)
{
    double f = 0;
    int32_t i;
    for (i = 0; i < n; i++) f += x[i] * x[i];
    return f;
}

static double rosenbrock(const double *x, int32_t n)
{
    double f = 0;
    int32_t i;
    for (i = 0; i + 1 < n; i++) f += 100 * (x[i + 1] - x[i] * x[i]) * (x[i + 1] - x[i] * x[i]) + (1 - x[i]) * (1 - x[i]);
    return f;
}

static double rastrigin(const double *x, int32_t n)
{
    double f = 10 * n;
    int32_t i;
    for (i = 0; i < n; i++) f += x[i] * x[i] - 10 * cos(6.283185307179586 * x[i]);
    return f;
}

static double griewank(const double *x, int32_t n)
{
    double f = 1, p = 1;
    int32_t i;
    for (i = 0; i < n; i++) {
        f += x[i] * x[i] / 4000;
        p *= cos(x[i] / sqrt(i + 1.0));
    }
    return f - p;
}

/* No number on one side of a diagonal, infinite in a corner. */
static double holes(const double *x, int32_t n) { return x[0] > x[1] ? (double)NAN : x[0] < -4 ? -(double)INFINITY : sphere(x, n); }

typedef struct problem {
    test_function value;
    int32_t n;
    double lower[LENSOPT_MAX_VARIABLES], upper[LENSOPT_MAX_VARIABLES];
} problem;

static void evaluate(void *user, const double *x, int32_t count, double *f)
{
    const problem *p = (const problem *)user;
    int32_t i, j;
    for (i = 0; i < count; i++, x += p->n) {
        for (j = 0; j < p->n; j++)
            if (!(x[j] >= p->lower[j] && x[j] <= p->upper[j])) abort(); /* threads: no assertion of cmocka's */
        f[i] = p->value(x, p->n);
    }
}

/* Steps along the numeric gradient, each as long as pays. */
static int32_t polish(void *user, double *x, double *f, int32_t steps)
{
    const problem *p = (const problem *)user;
    double g[16], y[16], length = 0.1, value;
    int32_t cost = *f == HUGE_VAL, j, k;
    if (*f == HUGE_VAL) *f = p->value(x, p->n);
    for (k = 0; k < steps; k++, cost += p->n + 1) {
        double norm = 0;
        for (j = 0; j < p->n; j++) {
            double h = 1e-7 * (p->upper[j] - p->lower[j]), was = x[j];
            x[j] = was + (was + h > p->upper[j] ? -h : h);
            g[j] = (p->value(x, p->n) - *f) / (x[j] - was);
            x[j] = was;
            norm += g[j] * g[j];
        }
        if (!(norm > 0)) break;
        for (j = 0; j < p->n; j++) y[j] = fmin(fmax(x[j] - length * g[j] / sqrt(norm), p->lower[j]), p->upper[j]);
        value = p->value(y, p->n);
        if (!(value < *f)) {
            length *= 0.4;
            continue;
        }
        memcpy(x, y, sizeof *x * (size_t)p->n);
        *f = value;
        length *= 1.6;
    }
    return cost;
}

static problem *problem_of(test_function value, int32_t n, double bound)
{
    static problem p;
    int32_t j;
    p.value = value;
    p.n = n;
    for (j = 0; j < n; j++) {
        p.lower[j] = -bound;
        p.upper[j] = bound * (value == griewank ? 0.9 : 1); /* not in the very middle */
    }
    return &p;
}

static lensopt_search_desc desc_of(problem *p, lensopt_method method)
{
    lensopt_search_desc d;
    memset(&d, 0, sizeof d);
    d.function.variables = p->n;
    d.function.lower = p->lower;
    d.function.upper = p->upper;
    d.function.user = p;
    d.function.evaluate = evaluate;
    d.method = method;
    return d;
}

static lensopt_search *create(const lensopt_search_desc *d)
{
    lensopt_search *search;
    lflare_error error;
    lflare_result result = lensopt_search_create(d, &search, &error);
    if (result != LFLARE_OK) print_error("%s\n", error.text);
    assert_int_equal(result, LFLARE_OK);
    return search;
}

static lensopt_progress run_to(lensopt_search *search, int64_t evaluations)
{
    lensopt_limits limits;
    lensopt_progress progress;
    memset(&limits, 0, sizeof limits);
    limits.evaluations = evaluations;
    assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, NULL), LFLARE_OK);
    assert_int_equal(lensopt_search_status(search, &progress), LFLARE_OK);
    assert_int_equal(progress.end, LENSOPT_ENDED_EVALUATIONS);
    return progress;
}

static uint8_t *saved(lensopt_search *search, size_t *size)
{
    uint8_t *bytes;
    *size = 0;
    assert_int_equal(lensopt_search_save(search, NULL, size), LFLARE_INCOMPLETE);
    bytes = (uint8_t *)malloc(*size);
    assert_int_equal(lensopt_search_save(search, bytes, size), LFLARE_OK);
    return bytes;
}

static void same_state(lensopt_search *a, lensopt_search *b)
{
    size_t size, other;
    uint8_t *left = saved(a, &size), *right = saved(b, &other);
    assert_int_equal(size, other);
    assert_memory_equal(left, right, size);
    free(left);
    free(right);
}

/* ---- convergence ---- */

static void every_method_converges(void **state)
{
    static const struct {
        lensopt_method method;
        int steps; /* of polishing; 0: none */
        test_function value;
        double bound, target; /* a target that most of the runs reach, five of seven */
        int64_t evaluations;
    } cases[] = {
        {LENSOPT_DE, 0, sphere, 5.12, 1e-10, 120000},   {LENSOPT_DE, 0, rosenbrock, 2.048, 1e-4, 200000},     {LENSOPT_DE, 0, griewank, 600, 0.1, 200000},
        {LENSOPT_JDE, 0, sphere, 5.12, 1e-10, 40000},   {LENSOPT_JDE, 0, rosenbrock, 2.048, 1e-4, 200000},    {LENSOPT_JDE, 0, rastrigin, 5.12, 1e-6, 80000},
        {LENSOPT_JDE, 0, griewank, 600, 1e-4, 120000},  {LENSOPT_PSO, 0, sphere, 5.12, 1e-10, 40000},         {LENSOPT_PSO, 0, rosenbrock, 2.048, 1, 100000},
        {LENSOPT_PSO, 0, rastrigin, 5.12, 5, 80000},    {LENSOPT_PSO, 0, griewank, 600, 0.1, 60000},          {LENSOPT_MEMETIC, 0, sphere, 5.12, 1e-10, 100000},
        {LENSOPT_MEMETIC, 0, rastrigin, 5.12, 1e-6, 100000}, {LENSOPT_MEMETIC, 0, griewank, 600, 0.05, 150000}, {LENSOPT_MEMETIC, 0, rosenbrock, 2.048, 5, 200000},
        {LENSOPT_MEMETIC, 40, sphere, 5.12, 1e-10, 300000}, {LENSOPT_MEMETIC, 10, rastrigin, 5.12, 1e-8, 600000}, {LENSOPT_MEMETIC, 20, rosenbrock, 2.048, 1e-4, 600000},
        {LENSOPT_MEMETIC, 20, griewank, 600, 1e-7, 600000}};
    size_t k;
    (void)state;
    for (k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        int32_t seed, found = 0;
        for (seed = 1; seed <= 7; seed++) {
            problem *p = problem_of(cases[k].value, 10, cases[k].bound);
            lensopt_search_desc d = desc_of(p, cases[k].method);
            lensopt_limits limits;
            lensopt_progress progress;
            lensopt_search *search;
            int32_t count = 1;
            double x[10], f;
            d.seed = (uint64_t)seed;
            d.islands = d.threads = 1;
            d.population = d.method == LENSOPT_MEMETIC ? 0 : 50;
            if (cases[k].steps > 0) d.function.polish = polish;
            d.polish_steps = cases[k].steps;
            memset(&limits, 0, sizeof limits);
            limits.evaluations = cases[k].evaluations;
            limits.target = cases[k].target;
            search = create(&d);
            assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, NULL), LFLARE_OK);
            assert_int_equal(lensopt_search_status(search, &progress), LFLARE_OK);
            assert_int_equal(lensopt_search_points(search, x, &f, &count), LFLARE_OK);
            assert_int_equal(count, 1);
            assert_true(f == progress.best && f == cases[k].value(x, 10) && memcmp(x, progress.x, sizeof x) == 0);
            assert_int_equal(progress.end, f <= cases[k].target ? LENSOPT_ENDED_TARGET : LENSOPT_ENDED_EVALUATIONS);
            found += f <= cases[k].target;
            lensopt_search_free(search);
        }
        if (found < 5) print_error("case %d (method %d): %d of 7\n", (int)k, (int)cases[k].method, (int)found);
        assert_true(found >= 5);
    }
}

/* Strategies, swarms, topologies and policies that no other test uses. */
static void every_choice_works(void **state)
{
    int32_t k;
    (void)state;
    for (k = 0; k < 16; k++) {
        problem *p = problem_of(sphere, 6, 5);
        static const int32_t blocks[6] = {7, -1, 7, 3, 3, -1};
        lensopt_search_desc d = desc_of(p, methods[k % 4]);
        lensopt_search *search;
        d.strategy = (lensopt_strategy)(k / 4);
        d.swarm = (lensopt_swarm)(k / 4 % 2);
        d.neighbours = k < 8 ? -1 : 6;
        d.topology = (lensopt_topology)(k / 4 % 3);
        d.policy = (lensopt_policy)(k / 8);
        d.migrants = 1 + k % 3;
        d.population = 20;
        d.islands = 4;
        d.period = 3;
        d.function.blocks = blocks;
        search = create(&d);
        assert_true(run_to(search, 40000).best < 0.01);
        lensopt_search_free(search);
    }
}

static void fixed_and_single_variables(void **state)
{
    int32_t k, count = 1;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        problem *p = problem_of(sphere, 3, 1);
        lensopt_search_desc d = desc_of(p, methods[k]);
        lensopt_search *search;
        double x[3], f;
        p->lower[1] = p->upper[1] = 0.5; /* nothing to vary */
        search = create(&d);
        assert_true(run_to(search, 20000).best < 0.25 + 1e-6);
        assert_int_equal(lensopt_search_points(search, x, &f, &count), LFLARE_OK);
        assert_true(x[1] == 0.5);
        lensopt_search_free(search);
        p = problem_of(sphere, 1, 1);
        d = desc_of(p, methods[k]);
        search = create(&d);
        assert_true(run_to(search, 20000).best < 1e-6);
        lensopt_search_free(search);
    }
}

static void no_numbers_count_as_the_worst(void **state)
{
    int32_t k, count = 3;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        problem *p = problem_of(holes, 4, 5);
        lensopt_search_desc d = desc_of(p, methods[k]);
        lensopt_search *search;
        double x[12], f[3];
        d.islands = 3;
        search = create(&d);
        assert_true(run_to(search, 30000).best < 0.1);
        assert_int_equal(lensopt_search_points(search, x, f, &count), LFLARE_OK);
        assert_int_equal(count, 3);
        assert_true(f[0] <= f[1] && f[1] <= f[2] && x[0] <= x[1]);
        lensopt_search_free(search);
    }
}

static double nowhere(const double *x, int32_t n) { return n > 0 ? (double)NAN : x[0]; }

static void nothing_but_no_numbers(void **state)
{
    int32_t k;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        problem *p = problem_of(nowhere, 4, 5);
        lensopt_search_desc d = desc_of(p, methods[k]);
        lensopt_search *search, *again = create(&d);
        size_t size;
        uint8_t *bytes;
        search = create(&d);
        assert_true(run_to(search, 30000).best == HUGE_VAL);
        bytes = saved(search, &size);
        assert_int_equal(lensopt_search_load(again, bytes, size, NULL), LFLARE_OK);
        same_state(search, again);
        free(bytes);
        lensopt_search_free(search);
        lensopt_search_free(again);
    }
}

/* ---- the same, however it is run ---- */

/* Small islands that migrate, restart and are polished. */
static lensopt_search_desc busy_desc(lensopt_method method, int32_t threads)
{
    lensopt_search_desc d = desc_of(problem_of(rastrigin, 6, 5.12), method);
    d.islands = 5;
    d.population = 16;
    d.period = 3;
    d.patience = 2;
    d.polish_steps = 5;
    d.threads = threads;
    d.seed = 3;
    if (method == LENSOPT_MEMETIC) d.function.polish = polish;
    return d;
}

static void threads_change_nothing(void **state)
{
    int32_t k, t;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        lensopt_search_desc d = busy_desc(methods[k], 1);
        lensopt_search *one = create(&d);
        lensopt_progress progress = run_to(one, 30011);
        assert_true(progress.restarts > 0 && progress.rounds > 2);
        assert_true(progress.evaluations > 25000 && progress.evaluations < 32000);
        for (t = 2; t <= 4; t += 2) {
            lensopt_search *several;
            d.threads = t;
            several = create(&d);
            run_to(several, 30011);
            same_state(one, several);
            lensopt_search_free(several);
        }
        lensopt_search_free(one);
    }
}

static int32_t stop_now(void *user, const lensopt_progress *progress)
{
    (void)progress;
    return ++*(int32_t *)user > 0;
}

static void interruptions_change_nothing(void **state)
{
    int32_t k, i, calls = 0;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        lensopt_search_desc d = busy_desc(methods[k], 1);
        lensopt_search *whole = create(&d), *split;
        lensopt_limits limits;
        run_to(whole, 20000);
        d.threads = 2;
        d.seed = 4; /* which the checkpoint overrules */
        split = create(&d);
        {
            lensopt_search *first;
            size_t size;
            uint8_t *bytes;
            d.seed = 3;
            first = create(&d);
            run_to(first, 777);
            bytes = saved(first, &size);
            assert_int_equal(lensopt_search_load(split, bytes, size, NULL), LFLARE_OK);
            free(bytes);
            lensopt_search_free(first);
        }
        for (i = 1; i <= 19; i++) { /* evaluations, time, cancel: wherever they stop it */
            memset(&limits, 0, sizeof limits);
            limits.evaluations = 1000 * i + 137;
            if (i % 3 == 0) limits.seconds = 1e-5;
            if (i % 3 == 1) lensopt_search_cancel(split);
            assert_int_equal(lensopt_search_run(split, &limits, i % 4 == 0 ? stop_now : NULL, &calls, NULL), i % 3 == 1 ? LFLARE_INCOMPLETE : LFLARE_OK);
            if (i % 5 == 0) { /* another process goes on */
                size_t size;
                uint8_t *bytes = saved(split, &size);
                lensopt_search_free(split);
                d.threads = 1 + i % 2;
                split = create(&d);
                assert_int_equal(lensopt_search_load(split, bytes, size, NULL), LFLARE_OK);
                free(bytes);
            }
        }
        run_to(split, 20000);
        same_state(whole, split);
        lensopt_search_free(whole);
        lensopt_search_free(split);
    }
    assert_true(calls > 0);
}

/* ---- ends ---- */

typedef struct watch {
    lensopt_search *search;
    double began, last, longest, until, cancelled;
    int32_t calls, cancel, stop, bad;
} watch;

static int32_t watching(void *user, const lensopt_progress *p)
{
    watch *w = (watch *)user;
    double now = lensopt__now(), x[LENSOPT_MAX_VARIABLES], gap = now - w->last;
    lensopt_progress other;
    int32_t one = 1;
    size_t size = 0;
    if (gap > w->longest) w->longest = gap;
    w->last = now;
    w->calls++;
    w->bad += !(p->evaluations > 0 && p->seconds >= 0 && p->rate >= 0 && p->best < HUGE_VAL && p->diversity >= 0 && p->diversity < 1);
    w->bad += p->x == NULL || (p->end == LENSOPT_RUNNING && rastrigin(p->x, 6) != p->best);
    /* what would disturb it is refused */
    w->bad += lensopt_search_status(w->search, &other) != LFLARE_ERROR_ARGUMENT || lensopt_search_points(w->search, x, NULL, &one) != LFLARE_ERROR_ARGUMENT;
    w->bad += lensopt_search_save(w->search, NULL, &size) != LFLARE_ERROR_ARGUMENT || lensopt_search_load(w->search, x, 8, NULL) != LFLARE_ERROR_ARGUMENT;
    if (w->cancel && now - w->began > w->until && w->cancelled == 0) {
        w->cancelled = lensopt__now();
        lensopt_search_cancel(w->search);
    }
    return w->stop && now - w->began > w->until;
}

static watch watched(lensopt_search *search, const lensopt_limits *limits, double until, int32_t cancel, int32_t stop, lflare_result expected)
{
    watch w;
    memset(&w, 0, sizeof w);
    w.search = search;
    w.until = until;
    w.cancel = cancel;
    w.stop = stop;
    w.began = w.last = lensopt__now();
    assert_int_equal(lensopt_search_run(search, limits, watching, &w, NULL), expected);
    assert_int_equal(w.bad, 0);
    return w;
}

static void ends_are_told(void **state)
{
    int32_t t, k;
    (void)state;
    for (t = 1; t <= 3; t++)
        for (k = 0; k < METHODS; k++) {
            lensopt_search_desc d = busy_desc(methods[k], t);
            lensopt_search *search = create(&d);
            lensopt_limits limits;
            lensopt_progress progress;
            watch w;
            double took;
            memset(&limits, 0, sizeof limits);
            limits.seconds = 0.12;
            w = watched(search, &limits, 0, 0, 0, LFLARE_OK);
            assert_int_equal(lensopt_search_status(search, &progress), LFLARE_OK);
            assert_int_equal(progress.end, LENSOPT_ENDED_SECONDS);
            assert_true(progress.seconds >= 0.12 && progress.seconds < 2 && progress.remaining == 0);
            assert_true(w.calls >= 2 && w.longest < 1);
            limits.seconds = 0;
            watched(search, &limits, 0.02, 0, 1, LFLARE_INCOMPLETE);
            assert_int_equal(lensopt_search_status(search, &progress), LFLARE_OK);
            assert_int_equal(progress.end, LENSOPT_ENDED_STOPPED);
            w = watched(search, &limits, 0.02, 1, 0, LFLARE_INCOMPLETE);
            took = lensopt__now() - w.cancelled;
            if (took > 0.05 || w.longest > 0.06) print_message("method %d, %d threads: cancelled within %.1f ms, calls at most %.1f ms apart\n", (int)k, (int)t, 1e3 * took, 1e3 * w.longest);
            assert_true(took < 0.25);
            assert_int_equal(lensopt_search_status(search, &progress), LFLARE_OK);
            assert_int_equal(progress.end, LENSOPT_ENDED_CANCELLED);
            limits.evaluations = 1; /* long done */
            assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, NULL), LFLARE_OK);
            assert_int_equal(lensopt_search_status(search, &progress), LFLARE_OK);
            assert_int_equal(progress.end, LENSOPT_ENDED_EVALUATIONS);
            lensopt_search_free(search);
        }
}

#ifndef LENSOPT_NO_THREADS
typedef struct canceller {
    lensopt_search *search;
    double at;
} canceller;

static void *cancels(void *user)
{
    canceller *c = (canceller *)user;
    double began = lensopt__now();
    fd_set none;
    struct timeval wait = {0, 60000};
    FD_ZERO(&none);
    while (lensopt__now() - began < 0.05) select(0, &none, NULL, NULL, &wait);
    c->at = lensopt__now();
    lensopt_search_cancel(c->search);
    return NULL;
}

static void another_thread_cancels(void **state)
{
    int32_t k;
    double worst = 0;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        lensopt_search_desc d = busy_desc(methods[k], 2);
        lensopt_limits limits;
        lensopt_progress progress;
        canceller c;
        pthread_t thread;
        memset(&limits, 0, sizeof limits);
        limits.seconds = 20;
        c.search = create(&d);
        assert_int_equal(pthread_create(&thread, NULL, cancels, &c), 0);
        assert_int_equal(lensopt_search_run(c.search, &limits, NULL, NULL, NULL), LFLARE_INCOMPLETE);
        worst = fmax(worst, lensopt__now() - c.at);
        pthread_join(thread, NULL);
        assert_int_equal(lensopt_search_status(c.search, &progress), LFLARE_OK);
        assert_int_equal(progress.end, LENSOPT_ENDED_CANCELLED);
        lensopt_search_free(c.search);
    }
    print_message("cancelled from another thread within %.2f ms\n", 1e3 * worst);
    assert_true(worst < 0.25);
}
#endif

/* ---- migration and exchange ---- */

static void migrants_arrive(void **state)
{
    int32_t topology, k;
    (void)state;
    for (topology = LENSOPT_RING; topology <= LENSOPT_ISOLATED; topology++) {
        problem *p = problem_of(rastrigin, 8, 5.12);
        lensopt_search_desc d = desc_of(p, LENSOPT_JDE);
        lensopt_search *search;
        int32_t count = 0, i;
        d.islands = 6;
        d.population = 20;
        d.period = 1;
        d.topology = (lensopt_topology)topology;
        search = create(&d);
        /* a champion is put on the first island; with each of two migrations it reaches the next, or all at once */
        run_to(search, 6 * 20);
        for (k = 0; k < 8; k++) search->island[0].x[k] = 1e-9 * k;
        search->island[0].f[0] = rastrigin(search->island[0].x, 8);
        run_to(search, 6 * 20 * 3);
        for (i = 0; i < 6; i++) count += memcmp(search->island[i].x + 8 * lensopt__best(search->island[i].f, 20), search->island[0].x, 64) == 0;
        assert_int_equal(count, topology == LENSOPT_RING ? 3 : topology == LENSOPT_FULL ? 6 : 1);
        lensopt_search_free(search);
    }
}

typedef struct trade {
    int32_t calls, bad;
    double best;
} trade;

static int32_t trades(void *user, int32_t island, const double *x, double f, double *in)
{
    trade *t = (trade *)user;
    t->bad += rastrigin(x, 5) != f;
    if (f < t->best) t->best = f;
    if (t->calls++ < 3) return 0;
    memset(in, 0, 5 * sizeof *in);
    if (island == 1) in[2] = (double)NAN;
    if (island == 2) in[3] = 1e9;
    return 1;
}

static void *libc_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size > 0) return realloc(block, new_size);
    free(block);
    return NULL;
}

static void processes_trade(void **state)
{
    problem *p = problem_of(rastrigin, 5, 5.12);
    int32_t k;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        lensopt_search_desc d = desc_of(p, methods[k]);
        trade t;
        lensopt_search *search;
        lensopt_progress progress;
        int32_t count = 1000, i, edge = 0;
        double *x = (double *)malloc(5 * 1000 * sizeof *x);
        memset(&t, 0, sizeof t);
        t.best = HUGE_VAL;
        d.exchange = trades;
        d.allocate = libc_realloc;
        d.user = &t;
        d.islands = 3;
        d.population = 30;
        d.period = 1;
        d.topology = LENSOPT_ISOLATED;
        search = create(&d);
        progress = run_to(search, 600);
        assert_true(t.calls > 3 && t.bad == 0 && t.best < HUGE_VAL);
        assert_true(progress.best == 0); /* the point that came in */
        assert_int_equal(lensopt_search_points(search, x, NULL, &count), LFLARE_OK);
        assert_true(count > 3 && count <= 90);
        for (i = 0; i < count; i++) edge += x[5 * i + 3] == 5.12;
        if (methods[k] != LENSOPT_PSO) assert_true(edge <= 2); /* moved into the bounds, and too bad to stay */
        free(x);
        lensopt_search_free(search);
    }
}

static void starts_are_members(void **state)
{
    problem *p = problem_of(rosenbrock, 4, 2);
    int32_t k, count = 1;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        double starts[8] = {1, 1, 1, 1, 9, -9, 0, 0}, x[4], f;
        lensopt_search_desc d = desc_of(p, methods[k]);
        lensopt_search *search;
        d.starts = starts;
        d.start_count = 2;
        d.islands = 2;
        search = create(&d);
        starts[0] = 7; /* copied */
        run_to(search, 1);
        assert_int_equal(lensopt_search_points(search, x, &f, &count), LFLARE_OK);
        assert_true(f == 0 && x[0] == 1);
        assert_true(search->island[0].x[4] == 2 && search->island[0].x[5] == -2);
        lensopt_search_free(search);
    }
}

/* Champions of earlier lives are among the points, each point once, best first. */
static void champions_are_kept(void **state)
{
    lensopt_search_desc d = busy_desc(LENSOPT_JDE, 1);
    lensopt_search *search = create(&d);
    lensopt_progress progress;
    int32_t count = 5 * (16 + LENSOPT_ARCHIVE), i, all = count;
    double *x = (double *)malloc((size_t)count * 6 * sizeof *x), *f = (double *)malloc((size_t)count * sizeof *f);
    (void)state;
    progress = run_to(search, 100000);
    assert_true(progress.restarts > 20);
    assert_int_equal(lensopt_search_points(search, x, f, &count), LFLARE_OK);
    assert_true(count > 5 * LENSOPT_ARCHIVE / 2 && count < all && f[0] == progress.best);
    for (i = 1; i < count; i++) assert_true(f[i - 1] <= f[i] && memcmp(x + 6 * i - 6, x + 6 * i, 6 * sizeof *x) != 0);
    for (i = 0; i < count; i++) assert_true(rastrigin(x + 6 * i, 6) == f[i]);
    free(x);
    free(f);
    lensopt_search_free(search);
}

/* ---- checkpoints ---- */

static void checkpoints_are_safe(void **state)
{
    int32_t k, i;
    uint32_t random = 1;
    (void)state;
    for (k = 0; k < METHODS; k++) {
        lensopt_search_desc d = busy_desc(methods[k], 1);
        lensopt_search *search, *other;
        lflare_error error;
        size_t size, before_size, at;
        uint8_t *bytes, *before, *bad;
        uint64_t sum;
        search = create(&d);
        other = create(&d);
        run_to(search, 4000);
        run_to(other, 900);
        bytes = saved(search, &size);
        before = saved(other, &before_size);
        bad = (uint8_t *)malloc(size);
        for (at = 0; at < size; at += at < 64 ? 1 : 997) assert_int_equal(lensopt_search_load(other, bytes, at, &error), LFLARE_ERROR_SYNTAX);
        for (i = 0; i < 300; i++) {
            lflare_result result;
            memcpy(bad, bytes, size);
            random = random * 1664525u + 1013904223u;
            at = i < 32 ? (size_t)i : (random >> 4) % (size - 8);
            bad[at] = (uint8_t)(bad[at] ^ (1u << (random >> 29)));
            if (i % 2 == 0) assert_int_equal(lensopt_search_load(other, bad, size, &error), LFLARE_ERROR_SYNTAX);
            sum = lensopt__checksum(bad, size - 8); /* what a forger would do */
            for (at = 0; at < 8; at++) bad[size - 8 + at] = (uint8_t)(sum >> 8 * at);
            result = lensopt_search_load(other, bad, size, &error);
            if (result == LFLARE_OK) { /* a state that could be: it works */
                run_to(other, 5000);
                assert_int_equal(lensopt_search_load(other, before, before_size, &error), LFLARE_OK);
            } else assert_true(strlen(error.text) > 20);
        }
        free(bytes);
        bytes = saved(other, &size);
        assert_memory_equal(bytes, before, size); /* nothing has changed */
        d.polish_steps = 6;
        lensopt_search_free(other);
        other = create(&d);
        assert_int_equal(lensopt_search_load(other, bytes, size, &error), LFLARE_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "of another search"));
        free(bytes);
        free(before);
        free(bad);
        lensopt_search_free(search);
        lensopt_search_free(other);
    }
}

/* ---- what goes wrong ---- */

typedef struct ledger {
    long calls, blocks, fail_at;
} ledger;

static void *failing_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    ledger *l = (ledger *)user;
    if (new_size == 0) {
        l->blocks--;
        return libc_realloc(NULL, block, old_size, 0);
    }
    if (++l->calls == l->fail_at) return NULL;
    l->blocks += block == NULL;
    return realloc(block, new_size);
}

static void allocations_fail(void **state)
{
    long n;
    (void)state;
    for (n = 1;; n++) {
        lensopt_search_desc d = busy_desc(LENSOPT_JDE, 2);
        lensopt_search *search = (lensopt_search *)&d;
        lflare_error error;
        ledger l = {0, 0, 0};
        double x[6];
        int32_t count = 1;
        size_t size = 0;
        long calls;
        l.fail_at = n;
        d.allocate = failing_realloc;
        d.user = &l;
        if (lensopt_search_create(&d, &search, &error) == LFLARE_OK) {
            calls = l.calls;
            run_to(search, 2000);
            assert_int_equal(lensopt_search_points(search, x, NULL, &count), LFLARE_OK);
            assert_int_equal(lensopt_search_save(search, NULL, &size), LFLARE_INCOMPLETE);
            lensopt_search_free(search);
            assert_int_equal(l.calls, calls); /* none but at creation */
            assert_int_equal(l.blocks, 0);
            break;
        }
        assert_int_equal(error.code, LFLARE_ERROR_MEMORY);
        assert_null(search);
        assert_int_equal(l.blocks, 0);
    }
    assert_true(n > 1);
}

#define REFUSED(change, sentence)                                                                          \
    do {                                                                                                   \
        lensopt_search_desc d = desc_of(problem_of(sphere, 5, 2), LENSOPT_PSO);                            \
        lensopt_search *search = (lensopt_search *)&d;                                                     \
        lflare_error error;                                                                                \
        change;                                                                                            \
        assert_int_equal(lensopt_search_create(&d, &search, &error), LFLARE_ERROR_ARGUMENT);               \
        assert_int_equal(error.code, LFLARE_ERROR_ARGUMENT);                                               \
        assert_null(search);                                                                               \
        if (strstr(error.text, sentence) == NULL) print_error("%s\n", error.text);                         \
        assert_non_null(strstr(error.text, sentence));                                                     \
        assert_int_equal(lensopt_search_create(&d, &search, NULL), LFLARE_ERROR_ARGUMENT);                 \
    } while (0)

static void descriptors_are_refused(void **state)
{
    static double numbers[10] = {0};
    static double lower[5] = {0, 0, 0, 0, 0}, upper[5] = {1, 1, 1, 1, 1};
    (void)state;
    assert_int_equal(lensopt_search_create(NULL, NULL, NULL), LFLARE_ERROR_ARGUMENT);
    REFUSED(d.method = (lensopt_method)9, "the method is none");
    REFUSED(d.function.variables = 0, "1 to 512 variables");
    REFUSED(d.function.variables = 513, "1 to 512 variables");
    REFUSED(d.function.lower = NULL, "bounds were expected, not NULL");
    REFUSED(d.function.evaluate = NULL, "a function to evaluate");
    REFUSED(d.function.lower = lower; d.function.upper = upper; upper[3] = -1, "variable 4: its lower bound 0 is above its upper bound -1");
    REFUSED(d.function.lower = lower; d.function.upper = upper; upper[3] = (double)NAN, "variable 4: finite bounds");
    REFUSED(d.function.lower = lower; d.function.upper = upper; upper[3] = (double)INFINITY, "variable 4: finite bounds");
    REFUSED(d.function.lower = lower; d.function.upper = upper; upper[3] = 1.5e308; lower[3] = -1.5e308, "variable 4: finite bounds, their difference too");
    REFUSED(d.islands = -1, "1 to 1024 islands");
    REFUSED(d.population = 3, "a population of 4 to 65536");
    REFUSED(d.population = 65537, "a population of 4 to 65536");
    REFUSED(d.threads = -1, "a number of threads");
    REFUSED(d.start_count = -1, "no more starts than");
    REFUSED(d.start_count = 76, "no more starts than");
    REFUSED(d.start_count = 1, "starts were expected, not NULL");
    REFUSED(d.starts = numbers; d.start_count = 2; numbers[7] = (double)NAN, "start 2: finite numbers");
    REFUSED(d.strategy = (lensopt_strategy)4, "the strategy is none");
    REFUSED(d.weight = 2.5, "weight is 0 to 2");
    REFUSED(d.weight = (double)NAN, "weight is 0 to 2");
    REFUSED(d.crossover = -0.1, "crossover is 0 to 1");
    REFUSED(d.tau2 = 1.5, "tau1 and tau2");
    REFUSED(d.weight_up = 3, "weight_low and weight_up");
    REFUSED(d.swarm = (lensopt_swarm)-1, "the swarm is none");
    REFUSED(d.neighbours = 3, "an even number of neighbours");
    REFUSED(d.population = 4, "fewer neighbours than the population");
    REFUSED(d.omega = 1.1, "omega is 0 to 1");
    REFUSED(d.c2 = 5, "c1 and c2 are 0 to 4");
    REFUSED(d.speed = 2, "speed is 0 to 1");
    REFUSED(d.polish_steps = -1, "steps of polishing");
    REFUSED(d.patience = -2, "a patience of 1 to 1000000");
    REFUSED(d.topology = (lensopt_topology)3, "the topology is none");
    REFUSED(d.migrants = 38, "1 migrant to half of a population");
    REFUSED(d.policy = (lensopt_policy)2, "the policy is none");
    REFUSED(d.period = 10001, "a period of 1 to 10000");
}

static void runs_are_refused(void **state)
{
    lensopt_search_desc d = busy_desc(LENSOPT_DE, 1);
    lensopt_search *search = create(&d);
    lensopt_limits limits;
    lflare_error error;
    size_t size = 4;
    int32_t count = -1;
    (void)state;
    memset(&limits, 0, sizeof limits);
    assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, &error), LFLARE_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "it would never end"));
    limits.seconds = (double)NAN;
    assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, &error), LFLARE_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "seconds"));
    limits.seconds = 0;
    limits.evaluations = -1;
    assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, &error), LFLARE_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "evaluations"));
    limits.evaluations = 0;
    limits.target = (double)NAN;
    assert_int_equal(lensopt_search_run(search, &limits, NULL, NULL, &error), LFLARE_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "a finite target"));
    assert_int_equal(lensopt_search_run(NULL, &limits, NULL, NULL, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_search_run(search, NULL, NULL, NULL, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_search_status(search, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_search_points(search, NULL, NULL, &count), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_search_save(search, NULL, &size), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_search_save(search, NULL, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_search_load(search, NULL, 9, &error), LFLARE_ERROR_ARGUMENT);
    count = 0;
    assert_int_equal(lensopt_search_points(search, NULL, NULL, &count), LFLARE_OK);
    lensopt_search_cancel(NULL);
    lensopt_search_free(NULL);
    lensopt_search_free(search);
}

static void numbers_are_even(void **state)
{
    uint64_t a = 5, b = 5;
    double sum = 0, least = 1, most = 0;
    int32_t i;
    (void)state;
    for (i = 0; i < 100000; i++) {
        double v = lensopt_random(&a);
        assert_true(v >= 0 && v < 1 && v == lensopt_random(&b));
        sum += v;
        least = fmin(least, v);
        most = fmax(most, v);
    }
    assert_true(fabs(sum / 100000 - 0.5) < 0.005 && least < 1e-4 && most > 1 - 1e-4);
}

#ifndef LENSOPT_NO_THREADS
#define SHARED cmocka_unit_test(threads_change_nothing), cmocka_unit_test(interruptions_change_nothing), cmocka_unit_test(ends_are_told), cmocka_unit_test(another_thread_cancels)
#else
#define SHARED cmocka_unit_test(threads_change_nothing), cmocka_unit_test(interruptions_change_nothing), cmocka_unit_test(ends_are_told)
#endif

int main(int argc, char **argv)
{
    static const struct CMUnitTest shared[] = {SHARED};
    static const struct CMUnitTest all[] = {
        SHARED, cmocka_unit_test(every_method_converges), cmocka_unit_test(every_choice_works), cmocka_unit_test(fixed_and_single_variables),
        cmocka_unit_test(no_numbers_count_as_the_worst), cmocka_unit_test(nothing_but_no_numbers), cmocka_unit_test(migrants_arrive), cmocka_unit_test(processes_trade),
        cmocka_unit_test(starts_are_members), cmocka_unit_test(champions_are_kept), cmocka_unit_test(checkpoints_are_safe), cmocka_unit_test(allocations_fail),
        cmocka_unit_test(descriptors_are_refused), cmocka_unit_test(runs_are_refused), cmocka_unit_test(numbers_are_even)};
    if (argc > 1 && strcmp(argv[1], "threads") == 0) return cmocka_run_group_tests(shared, NULL, NULL);
    return cmocka_run_group_tests(all, NULL, NULL);
}
