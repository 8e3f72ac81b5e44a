/* What lensopt.h's search needs, against pagmo 2: median evaluations to a value, median best value where that is not reached, evaluations a
   second, side by side as ratios. `bench_opt PART` runs one part, `bench_opt` all; SEEDS=n in the environment: of how many runs medians are taken.

       functions [memetic | de | jde | pso]
                   each algorithm with the same parameters, population and evaluations, on functions that papers take; the memetic one, without
                   anything that polishes, against pagmo's jDE */
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <pagmo/algorithms/de.hpp>
#include <pagmo/algorithms/pso.hpp>
#include <pagmo/algorithms/sade.hpp>
#include <pagmo/algorithm.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSOPT_IMPLEMENTATION
#include "lensopt.h"

static double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

static double median(std::vector<double> v)
{
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

static int seeds()
{
    const char *text = std::getenv("SEEDS");
    int n = text != nullptr ? std::atoi(text) : 25;
    return n > 0 ? n : 25;
}

/* ---- functions ---- */

struct test_function {
    const char *name;
    double bound, level; /* within -bound to bound; a value that counts as found */
    double (*value)(const double *x, int n);
};

static double sphere(const double *x, int n)
{
    double f = 0;
    for (int i = 0; i < n; i++) f += x[i] * x[i];
    return f;
}

static double rosenbrock(const double *x, int n)
{
    double f = 0;
    for (int i = 0; i + 1 < n; i++) {
        double a = x[i + 1] - x[i] * x[i], b = 1 - x[i];
        f += 100 * a * a + b * b;
    }
    return f;
}

static double rastrigin(const double *x, int n)
{
    double f = 10 * n;
    for (int i = 0; i < n; i++) f += x[i] * x[i] - 10 * std::cos(6.283185307179586 * x[i]);
    return f;
}

static double griewank(const double *x, int n)
{
    double f = 0, p = 1;
    for (int i = 0; i < n; i++) {
        f += x[i] * x[i] / 4000;
        p *= std::cos(x[i] / std::sqrt(i + 1.0));
    }
    return 1 + f - p;
}

static const test_function functions[] = {{"sphere", 5.12, 1e-6, sphere}, {"rosenbrock", 2.048, 1e-4, rosenbrock}, {"rastrigin", 5.12, 1e-4, rastrigin}, {"griewank", 600, 1e-4, griewank}};

/* What a run did so far. */
struct record {
    const test_function *function;
    int n;
    long evaluations, cap, reached; /* reached: after how many it had found it; 0: not */
    double best;
};

static double evaluate(record *r, const double *x)
{
    double f = r->function->value(x, r->n);
    r->evaluations++;
    if (f < r->best) r->best = f;
    if (r->reached == 0 && f <= r->function->level) r->reached = r->evaluations;
    return f;
}

/* ---- both sides ---- */

struct enough {};

struct pagmo_problem {
    record *r = nullptr;
    pagmo::vector_double fitness(const pagmo::vector_double &x) const
    {
        double f = evaluate(r, x.data());
        if (r->reached > 0 || r->evaluations >= r->cap) throw enough();
        return {f};
    }
    std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const
    {
        size_t n = r != nullptr ? static_cast<size_t>(r->n) : 1;
        double bound = r != nullptr ? r->function->bound : 1;
        return {pagmo::vector_double(n, -bound), pagmo::vector_double(n, bound)};
    }
};

/* pagmo has nothing like the memetic one, which stands beside jDE. */
static void run_pagmo(lensopt_method method, int population, unsigned seed, record *r)
{
    unsigned generations = static_cast<unsigned>(r->cap / population);
    pagmo_problem problem;
    problem.r = r;
    try {
        pagmo::algorithm algorithm = method == LENSOPT_DE    ? pagmo::algorithm(pagmo::de(generations, 0.8, 0.9, 7u, 0, 0, seed))
                                     : method != LENSOPT_PSO ? pagmo::algorithm(pagmo::sade(generations, 7u, 1u, 0, 0, false, seed))
                                                             : pagmo::algorithm(pagmo::pso(generations, 0.7298, 2.05, 2.05, 0.5, 5u, 2u, 4u, false, seed));
        pagmo::population members(pagmo::problem(problem), static_cast<size_t>(population), seed);
        algorithm.evolve(members);
    } catch (const enough &) {}
}

extern "C" void evaluate_batch(void *user, const double *x, int32_t count, double *f)
{
    record *r = static_cast<record *>(user);
    for (int32_t i = 0; i < count; i++) f[i] = evaluate(r, x + i * r->n);
}

static void run_ours(lensopt_method method, int population, unsigned seed, record *r)
{
    std::vector<double> lower(static_cast<size_t>(r->n), -r->function->bound), upper(static_cast<size_t>(r->n), r->function->bound);
    lensopt_search_desc desc;
    lensopt_limits limits;
    lensopt_search *search;
    lflare_error error;
    std::memset(&desc, 0, sizeof desc);
    std::memset(&limits, 0, sizeof limits);
    desc.function.variables = r->n;
    desc.function.lower = lower.data();
    desc.function.upper = upper.data();
    desc.function.user = r;
    desc.function.evaluate = evaluate_batch;
    desc.method = method;
    desc.islands = desc.threads = 1;
    desc.population = population;
    desc.seed = seed;
    limits.evaluations = r->cap;
    limits.target = r->function->level;
    if (lensopt_search_create(&desc, &search, &error) != LFLARE_OK || lensopt_search_run(search, &limits, nullptr, nullptr, &error) != LFLARE_OK) {
        std::printf("%s\n", error.text);
        std::exit(2);
    }
    lensopt_search_free(search);
}

/* ---- part: functions ---- */

struct outcome {
    std::vector<double> reached, best; /* of each seed; where it was not reached, twice the most that was allowed */
    long evaluations = 0;
    double seconds = 0;
    int found = 0;
};

static outcome many(bool ours, lensopt_method method, const test_function &f, int n)
{
    outcome o;
    for (int seed = 1; seed <= seeds(); seed++) {
        record r = {&f, n, 0, n == 10 ? 150000 : 450000, 0, HUGE_VAL};
        double begin = now();
        (ours ? run_ours : run_pagmo)(method, 5 * n > 100 ? 100 : 50, static_cast<unsigned>(seed), &r);
        o.seconds += now() - begin;
        o.evaluations += r.evaluations;
        o.found += r.reached > 0;
        o.reached.push_back(static_cast<double>(r.reached > 0 ? r.reached : 2 * r.cap));
        o.best.push_back(r.best);
    }
    return o;
}

static void part_functions(const char *only)
{
    static const lensopt_method methods[] = {LENSOPT_JDE, LENSOPT_DE, LENSOPT_PSO, LENSOPT_MEMETIC};
    static const char *const names[] = {"memetic", "de", "jde", "pso"};
    double log_sum = 0;
    int counted = 0;
    std::printf("medians of %d seeds: evaluations to reach a value, or the best value where either side fails; ratio: ours over pagmo's, below 1 is better\n", seeds());
    std::printf("%-7s %-10s %2s  %9s %9s  %5s %5s  %6s   %8s %8s\n", "", "", "n", "ours", "pagmo", "found", "", "ratio", "Mev/s", "pagmo");
    for (lensopt_method method : methods) {
        if (only != nullptr && std::strcmp(only, names[method]) != 0) continue;
        for (int n = 10; n <= 30; n += 20)
            for (const test_function &f : functions) {
                outcome ours = many(true, method, f, n), theirs = many(false, method, f, n);
                bool both = 2 * ours.found > seeds() && 2 * theirs.found > seeds();
                double a = median(both ? ours.reached : ours.best), b = median(both ? theirs.reached : theirs.best);
                std::printf("%-7s %-10s %2d  %9.4g %9.4g  %2d/%-2d %2d/%-2d  %6.3f   %8.2f %8.2f%s\n", names[method], f.name, n, a, b, ours.found, seeds(), theirs.found, seeds(), a / b,
                            1e-6 * static_cast<double>(ours.evaluations) / ours.seconds, 1e-6 * static_cast<double>(theirs.evaluations) / theirs.seconds, both ? "" : "  (best value)");
                if (both) log_sum += std::log(a / b), counted++;
                std::fflush(stdout);
            }
    }
    if (counted > 0) std::printf("geometric mean of the %d ratios of evaluations: %.3f\n", counted, std::exp(log_sum / counted));
}

/* ---- main ---- */

static const struct { const char *name; void (*run)(const char *only); } parts[] = {{"functions", part_functions}};

int main(int argc, char **argv)
{
    bool any = false;
    for (const auto &part : parts) {
        if (argc > 1 && std::strcmp(argv[1], part.name) != 0) continue;
        std::printf("== %s\n", part.name);
        part.run(argc > 2 ? argv[2] : nullptr);
        any = true;
    }
    if (!any) std::printf("no such part: %s\n", argv[1]);
    return any ? 0 : 2;
}
