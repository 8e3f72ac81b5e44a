/* What lensopt.h shows, side by side with pagmo 2 where that has something like it. `bench_opt PART [NAME=VALUE ...]` runs one part, `bench_opt` all (seven
   hours at the defaults: a part says what it will take); time=SECONDS a run, seeds=N, from=SEED (the first, 1), methods=A,B,... and pictures=1 choose
   less or more.

       functions [memetic | de | jde | pso]
                   each algorithm with the same parameters, population and evaluations, on functions that papers take; the memetic one, without
                   anything that polishes, against pagmo's jDE: median evaluations to a value, median best value where that is not reached, evaluations a
                   second, as ratios. SEEDS=n in the environment: of how many runs medians are taken
       rate        evaluations of THESIS a second on one core, and what of that is the sort
       heliar      Van Acoleyen 2025, 6.3: the spots of the Heliar at iris 2.25 mm as target, the lens itself not among the starts, everything free;
                   13.40 and 5.45 degrees, each right and up; time=60 seeds=10
       canon       the same with the Canon at 5.45 degrees; time=600 seeds=3
       scratch     tests/data/scratch-*.target without a base; time= 60, 120 and 300; seeds=5 surfaces=N (default: as few as have so many ghosts)
       constrained the ghosts of real lenses by lenses that are lenses; time=60

   Methods: seen, memetic, ranked (all three memetic; the objective is SEEN, MATCHED, THESIS), these with -blind: the search alone, which reads no lens from the spots;
   pso, jde, pagmo-pso, pagmo-sade (its jDE), and the latter two with -ring: with migration on a ring. Reading counts as time. Swarms and DE have 15 islands of 15 for each variable on both sides, begin evenly within the same bounds and minimise
   the same THESIS; pagmo's islands keep their memory, and do not migrate unless told so, as in the thesis. All run on two cores till the time is up or f is
   1e-12 (the memetic search's own objective: 1e-24). For every run build/bench_opt_*.csv holds best f over time; pictures=1 writes target and result, side by side, as build/bench_opt_*.pgm. */
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#if defined(__linux__)
#include <sched.h>
#endif

#include <pagmo/algorithms/de.hpp>
#include <pagmo/algorithms/pso.hpp>
#include <pagmo/algorithms/sade.hpp>
#include <pagmo/algorithm.hpp>
#include <pagmo/archipelago.hpp>
#include <pagmo/island.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <pagmo/topologies/ring.hpp>

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

struct options {
    const char *only = nullptr;
    double time = 0; /* 0: the part's own */
    int seeds = 0, from = 1, surfaces = 0;
    bool pictures = false;
    std::string methods; /* commas between; "": the part's own */
};

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

static void part_functions(const options &choice)
{
    const char *only = choice.only;
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

/* ---- lenses, targets, problems ---- */

[[noreturn]] static void give_up(const std::string &what, const lflare_error &error)
{
    std::printf("%s:%d:%d: %s\n", what.c_str(), static_cast<int>(error.line), static_cast<int>(error.column), error.text);
    std::exit(2);
}

static std::string read_text(const std::string &path)
{
    lflare_error error;
    char *text = nullptr;
    size_t size = 0;
    if (lflare_file_read(path.c_str(), nullptr, nullptr, &text, &size, &error) < 0) give_up(path, error);
    std::string out(text, size);
    std::free(text);
    return out;
}

static lflare_prescription read_lens(const std::string &path)
{
    std::string text = read_text(path);
    lflare_prescription p;
    lflare_error error;
    if (lflare_text_read(text.data(), text.size(), &p, &error) < 0) give_up(path, error);
    return p;
}

using target_pointer = std::shared_ptr<lensopt_target>; /* 270 KB */
using problem_pointer = std::shared_ptr<lensopt_problem>;

static target_pointer read_target(const std::string &path)
{
    std::string text = read_text(path);
    target_pointer t = std::make_shared<lensopt_target>();
    lflare_error error;
    if (lensopt_target_read(text.data(), text.size(), t.get(), &error) < 0) give_up(path, error);
    return t;
}

static problem_pointer make_problem(lensopt_problem_desc desc, const lensopt_target *target, lensopt_objective objective)
{
    lensopt_problem *p;
    lflare_error error;
    desc.target = target;
    desc.objective = objective;
    if (lensopt_problem_create(&desc, &p, &error) < 0) give_up("problem", error);
    return problem_pointer(p, lensopt_problem_free);
}

static std::vector<double> point_of(const lensopt_problem *p, const lflare_prescription *lens, double iris)
{
    lensopt_function f;
    lflare_error error;
    lensopt_problem_function(const_cast<lensopt_problem *>(p), &f);
    std::vector<double> x(static_cast<size_t>(f.variables));
    if (lensopt_problem_point(p, lens, iris, x.data(), &error) < 0) give_up("point", error);
    return x;
}

static std::vector<lensopt_shown> shown(const lensopt_problem *p, const std::vector<double> &x, int32_t light)
{
    std::vector<lensopt_shown> out(2048);
    int32_t count = static_cast<int32_t>(out.size());
    if (lensopt_problem_shows(p, x.data(), light, out.data(), &count) != LFLARE_OK) std::printf("what a lens shows: failed\n"), std::exit(2);
    out.resize(static_cast<size_t>(count));
    return out;
}

static double value_of(const lensopt_problem *p, const std::vector<double> &x)
{
    lensopt_function f;
    double value;
    lensopt_problem_function(const_cast<lensopt_problem *>(p), &f);
    f.evaluate(f.user, x.data(), 1, &value);
    return value;
}

static std::vector<lensopt_light> lights_at(const std::vector<std::pair<double, double>> &degrees)
{
    std::vector<lensopt_light> out;
    for (const auto &d : degrees) out.push_back({{d.first, d.second}, 1});
    return out;
}

/* What the problem's own model makes of its base: of the lens itself not everything that rims cut off. */
static target_pointer model_target(const lensopt_problem_desc &desc, const std::vector<lensopt_light> &lights)
{
    target_pointer any = std::make_shared<lensopt_target>(), t = std::make_shared<lensopt_target>();
    lflare_lens lens;
    lflare_error error;
    if (lflare_lens_derive(desc.base, &lens, &error) < 0) give_up("base", error);
    std::memset(any.get(), 0, sizeof *any);
    any->sensor_width = lens.sensor_width;
    any->sensor_height = lens.sensor_height;
    any->light_count = static_cast<int32_t>(lights.size());
    std::copy(lights.begin(), lights.end(), any->lights);
    any->ghost_count = 1;
    any->ghosts[0].pair.first = -1;
    any->ghosts[0].weight = 1;
    for (int32_t l = 0; l < any->light_count; l++) any->ghosts[0].goals[l] = {LENSOPT_SPOT, 1, 1};
    problem_pointer p = make_problem(desc, any.get(), LENSOPT_SEEN);
    std::vector<double> x = point_of(p.get(), desc.base, desc.iris);
    *t = *any;
    t->ghost_count = 0;
    for (int32_t l = 0; l < any->light_count; l++) {
        std::vector<lensopt_shown> spots = shown(p.get(), x, l);
        for (size_t k = 0; k < spots.size() && k < LENSOPT_MAX_GHOSTS; k++) {
            lensopt_ghost *g = &t->ghosts[k];
            g->pair = spots[k].pair;
            g->weight = 1;
            if (spots[k].radius > 0) g->goals[l] = {LENSOPT_SPOT, spots[k].centre, spots[k].radius};
            else g->goals[l] = {LENSOPT_SPOT_HIDDEN, 0, 0};
        }
        t->ghost_count = static_cast<int32_t>(std::min<size_t>(spots.size(), LENSOPT_MAX_GHOSTS));
    }
    if (lensopt_target_check(t.get(), &error) < 0) give_up("target", error);
    return t;
}

/* ---- pictures of spots ---- */

enum { WIDTH = 1280, HEIGHT = 720 };

struct disc { double centre, radius; };

static std::vector<disc> discs_of(const std::vector<lensopt_shown> &spots)
{
    std::vector<disc> out;
    for (const lensopt_shown &s : spots)
        if (s.radius > 0) out.push_back({s.centre, s.radius});
    return out;
}

static std::vector<disc> discs_of(const lensopt_target *t, int32_t light)
{
    std::vector<disc> out;
    for (int32_t g = 0; g < t->ghost_count; g++)
        if (t->ghosts[g].goals[light].wish == LENSOPT_SPOT) out.push_back({t->ghosts[g].goals[light].centre, t->ghosts[g].goals[light].radius});
    return out;
}

/* Discs of the same flux each: ghosts alone, grey, linear. The frame's width fills the picture, of its height what 16:9 leaves. Edges are
   a pixel wide, no disc is less than one pixel across. */
static std::vector<float> draw(const std::vector<disc> &discs, const lensopt_light &light, double sensor_width)
{
    std::vector<float> out(WIDTH * HEIGHT);
    double scale = WIDTH / sensor_width, x = std::tan(light.direction[0] * (LENSOPT__PI / 180)), y = std::tan(light.direction[1] * (LENSOPT__PI / 180)), u = std::hypot(x, y);
    if (u > 0) x /= u, y /= u;
    for (const disc &d : discs) {
        double r = std::max(scale * d.radius, 0.5), cx = 0.5 * WIDTH + scale * d.centre * x, cy = 0.5 * HEIGHT - scale * d.centre * y, flux = 1 / (LENSOPT__PI * r * r);
        int top = static_cast<int>(std::max(0.0, std::floor(cy - r - 1))), bottom = static_cast<int>(std::min<double>(HEIGHT - 1, std::ceil(cy + r + 1)));
        int left = static_cast<int>(std::min(std::max(0.0, std::floor(cx - r - 1)), 1.0 * WIDTH)), right = static_cast<int>(std::max(-1.0, std::min<double>(WIDTH - 1, std::ceil(cx + r + 1))));
        for (int j = top; j <= bottom; j++)
            for (int i = left; i <= right; i++) {
                double covered = r + 0.5 - std::hypot(i + 0.5 - cx, j + 0.5 - cy);
                if (covered > 0) out[static_cast<size_t>(j * WIDTH + i)] += static_cast<float>(flux * std::min(covered, 1.0));
            }
    }
    return out;
}

static std::vector<float> exposed(const std::vector<float> &picture, double exposure)
{
    std::vector<float> out(picture);
    for (float &v : out) v = static_cast<float>(std::min(1.0, exposure * static_cast<double>(v)));
    return out;
}

/* The value below which `part` of what is not black lies; 1 if all is. */
static double lit_quantile(const std::vector<float> &picture, double part)
{
    std::vector<float> lit;
    for (float v : picture)
        if (v > 0) lit.push_back(v);
    if (lit.empty()) return 1;
    size_t k = std::min(lit.size() - 1, static_cast<size_t>(part * static_cast<double>(lit.size())));
    std::nth_element(lit.begin(), lit.begin() + static_cast<std::ptrdiff_t>(k), lit.end());
    return static_cast<double>(lit[k]);
}

static double psnr(const std::vector<float> &a, const std::vector<float> &b)
{
    double sum = 0;
    for (size_t i = 0; i < a.size(); i++) sum += (static_cast<double>(a[i]) - static_cast<double>(b[i])) * (static_cast<double>(a[i]) - static_cast<double>(b[i]));
    return std::min(-10 * std::log10(sum / static_cast<double>(a.size()) + 1e-30), 99.0);
}

/* Gaussian of sigma 1.5 pixels over 11, edges repeated. */
static std::vector<double> blurred(const std::vector<double> &picture)
{
    std::vector<double> across(picture.size()), out(picture.size());
    double g[11], sum = 0;
    for (int k = 0; k < 11; k++) sum += g[k] = std::exp(-(k - 5) * (k - 5) / 4.5);
    for (double &v : g) v /= sum;
    for (int j = 0; j < HEIGHT; j++)
        for (int i = 0; i < WIDTH; i++) {
            double v = 0;
            for (int k = 0; k < 11; k++) v += g[k] * picture[static_cast<size_t>(j * WIDTH + std::min(std::max(i + k - 5, 0), WIDTH - 1))];
            across[static_cast<size_t>(j * WIDTH + i)] = v;
        }
    for (int j = 0; j < HEIGHT; j++)
        for (int k = 0; k < 11; k++) {
            const double *from = &across[static_cast<size_t>(std::min(std::max(j + k - 5, 0), HEIGHT - 1) * WIDTH)];
            for (int i = 0; i < WIDTH; i++) out[static_cast<size_t>(j * WIDTH + i)] += g[k] * from[i];
        }
    return out;
}

/* Wang et al. 2004, mean over all pixels. */
static double ssim(const std::vector<float> &a, const std::vector<float> &b)
{
    size_t n = a.size();
    std::vector<double> x(a.begin(), a.end()), y(b.begin(), b.end()), xx(n), yy(n), xy(n);
    double sum = 0;
    for (size_t i = 0; i < n; i++) xx[i] = x[i] * x[i], yy[i] = y[i] * y[i], xy[i] = x[i] * y[i];
    x = blurred(x), y = blurred(y), xx = blurred(xx), yy = blurred(yy), xy = blurred(xy);
    for (size_t i = 0; i < n; i++)
        sum += (2 * x[i] * y[i] + 1e-4) * (2 * (xy[i] - x[i] * y[i]) + 9e-4) / ((x[i] * x[i] + y[i] * y[i] + 1e-4) * (xx[i] - x[i] * x[i] + yy[i] - y[i] * y[i] + 9e-4));
    return sum / static_cast<double>(n);
}

/* For eyes: target to the left, result to the right, grey by the logarithm, since small spots are ten thousand times brighter than large ones. */
static void write_pair(const std::string &pgm, const std::vector<float> &target, const std::vector<float> &result)
{
    double middle = lit_quantile(target, 0.5), most = std::log1p(4 * lit_quantile(target, 0.999) / middle);
    FILE *file = std::fopen(pgm.c_str(), "wb");
    if (file == nullptr) return;
    std::fprintf(file, "P5\n%d %d\n255\n", 2 * WIDTH, HEIGHT);
    for (int j = 0; j < HEIGHT; j++)
        for (int i = 0; i < 2 * WIDTH; i++) {
            double v = static_cast<double>((i < WIDTH ? target : result)[static_cast<size_t>(j * WIDTH + i % WIDTH)]);
            std::fputc(static_cast<int>(255 * std::min(1.0, std::log1p(4 * v / middle) / most) + 0.5), file);
        }
    std::fclose(file);
}

/* Of a result's picture against the target's: exposed so that the brightest 0.1 % of what the target lights clip at 1, and, which is harder, so that the
   median of what it lights is 0.5; and what a black picture would get at the first. */
struct likeness { double psnr = 0, ssim = 0, bright = 0, black = 0; };

static likeness compare(const std::vector<disc> &target, const std::vector<disc> &result, const lensopt_light &light, double sensor_width, const std::string &pgm)
{
    std::vector<float> t = draw(target, light, sensor_width), r = draw(result, light, sensor_width);
    double exposure = 1 / lit_quantile(t, 0.999), bright = 0.5 / lit_quantile(t, 0.5);
    std::vector<float> te = exposed(t, exposure), re = exposed(r, exposure);
    likeness out;
    out.psnr = psnr(te, re);
    out.ssim = ssim(te, re);
    out.black = psnr(te, std::vector<float>(te.size()));
    out.bright = psnr(exposed(t, bright), exposed(r, bright));
    if (!pgm.empty()) write_pair(pgm, t, r);
    return out;
}

/* A target's picture, drawn once, and the PSNR of others against it. */
struct view {
    lensopt_light light;
    double sensor_width, exposure;
    std::vector<float> picture;
    view(const std::vector<disc> &target, const lensopt_light &l, double width) : light(l), sensor_width(width), picture(draw(target, l, width))
    {
        exposure = 1 / lit_quantile(picture, 0.999);
        picture = exposed(picture, exposure);
    }
    double likeness_of(const std::vector<disc> &result) const { return psnr(picture, exposed(draw(result, light, sensor_width), exposure)); }
};

/* ---- part: rate ---- */

/* Median of nine times 0.1 s, in seconds a call. */
template <class F> static double seconds_of(F body)
{
    std::vector<double> times;
    for (int run = 0; run < 9; run++) {
        double begin = now(), spent;
        long calls = 0;
        do body(), calls++;
        while ((spent = now() - begin) < 0.1);
        times.push_back(spent / static_cast<double>(calls));
    }
    return median(times);
}

/* The objective's stages on one full set of lanes, as lensopt__thesis_batch has them. */
LENSOPT__INLINE void stages(const lensopt_problem *p, lensopt__batch *b, lensopt__rows *rows, int how_many)
{
    lensopt__vec count;
    lensopt__all_rows(b, rows);
    if (how_many > 1) lensopt__merge(b, rows, p->slopes[0], p->desc.pupil, &count);
    if (how_many > 2) lensopt__sort(rows);
}

static void stages_plain(const lensopt_problem *p, lensopt__batch *b, lensopt__rows *rows, int n) { stages(p, b, rows, n); }
#if defined(LENSOPT__WIDE)
LENSOPT__WIDE static void stages_wide(const lensopt_problem *p, lensopt__batch *b, lensopt__rows *rows, int n) { stages(p, b, rows, n); }
#endif

static void rate_of(const char *path, double aim, double direct)
{
    enum { BATCH = 4096 };
    lflare_prescription lens = read_lens(path);
    lensopt_problem_desc desc;
    lensopt_function f;
    uint64_t random = 1;
    std::memset(&desc, 0, sizeof desc);
    desc.base = &lens;
    desc.iris = 2.25;
    target_pointer target = model_target(desc, lights_at({{5.45, 5.45}}));
    problem_pointer p = make_problem(desc, target.get(), LENSOPT_THESIS);
    lensopt_problem_function(p.get(), &f);
    size_t n = static_cast<size_t>(f.variables);
    std::vector<double> own = point_of(p.get(), &lens, desc.iris), even(BATCH * n), near(BATCH * n), value(BATCH);
    for (size_t i = 0; i < BATCH; i++)
        for (size_t j = 0; j < n; j++) {
            double r = lensopt_random(&random), range = f.upper[j] - f.lower[j], v = own[j];
            even[i * n + j] = f.lower[j] + r * range;
            if (static_cast<int32_t>(j) == p->place_of) v = std::floor(v) + 0.999 * r;
            else if (v > f.lower[j]) v += 0.01 * (r - 0.5) * range; /* at the lower end: the index of air */
            near[i * n + j] = std::min(std::max(v, f.lower[j]), f.upper[j]);
        }
    std::printf("%s: %d ghosts seen, %d variables; f of the lens itself: %.3g\n", path, static_cast<int>(p->goals), static_cast<int>(n), value_of(p.get(), own));
    for (int which = 0; which < 2; which++) {
        const std::vector<double> &x = which == 0 ? even : near;
        double all = seconds_of([&] { f.evaluate(f.user, x.data(), BATCH, value.data()); });
        int few = 0;
        for (double v : value) few += v == 1e5;
        double one = seconds_of([&] { for (size_t i = 0; i < BATCH; i++) f.evaluate(f.user, &x[i * n], 1, &value[i]); });
        std::printf("  %-44s %7.3f M/s, one a call %7.3f M/s; of too few ghosts: %4.1f %%\n", which == 0 ? "4096 evenly within the bounds" : "4096 around the lens's own order and stop", 1e-6 * BATCH / all,
                    1e-6 * BATCH / one, 100.0 * few / BATCH);
        if (which == 0) continue;
        std::printf("  aim %g M/s, direct implementation %g M/s: %.1f times that\n", aim, direct, 1e-6 * BATCH / all / direct);
        static lensopt__batch b;
        static lensopt__rows rows;
        lensopt__design d;
        for (int l = 0; l < LENSOPT__LANES; l++) {
            lensopt__decode(p.get(), &near[static_cast<size_t>(l) * n], &d);
            lensopt__lane(&b, l, &d);
        }
        double t[4] = {0, 0, 0, 0};
        for (int s = 1; s < 4; s++) t[s] = seconds_of([&] { LENSOPT__KERNEL(stages)(p.get(), &b, &rows, s); }) / LENSOPT__LANES;
        double each = all / BATCH;
        std::printf("  of %.3f us: matrices %.3f, spots %.3f, sort %.3f (%.0f %%), decoding and sums %.3f; %d lanes\n", 1e6 * each, 1e6 * t[1], 1e6 * (t[2] - t[1]), 1e6 * (t[3] - t[2]),
                    100 * (t[3] - t[2]) / each, 1e6 * (each - t[3]), LENSOPT__LANES);
    }
}

static void part_rate(const options &)
{
    std::printf("evaluations of THESIS a second on one core, light 5.45, 5.45 degrees, iris 2.25 mm\n");
    rate_of("lenses/heliar-tronnier.lens", 5, 0.70);
    rate_of("lenses/canon-28-80.lens", 0.4, 0.032);
}

/* ---- runs ---- */

enum { THREADS = 2, ISLANDS = 15 };

struct sample { double seconds, best, own; long long evaluations; };

/* f is THESIS throughout, own what the method minimised: by that its point is the best. */
struct run {
    std::vector<sample> curve; /* whenever that had become better */
    std::vector<double> x;
    double f = HUGE_VAL, own = HUGE_VAL, seconds = 0, begin = 0;
    long long evaluations = 0;
    void add(double f_now, double own_now, long long evaluations_now)
    {
        seconds = now() - begin;
        evaluations = evaluations_now;
        if (own_now < own || curve.empty()) f = f_now, own = own_now, curve.push_back({seconds, f, own, evaluations});
    }
    double time_to(double level) const
    {
        for (const sample &s : curve)
            if (s.best < level) return s.seconds;
        return HUGE_VAL;
    }
};

struct task {
    std::string name;
    target_pointer target;
    lensopt_problem_desc desc; /* but for target and objective */
    double seconds = 60;
    int seeds = 10;
};

struct watcher { run *r; const lensopt_problem *thesis; double seen, f; }; /* f: of what is best by the search's own objective */

extern "C" int32_t watch(void *user, const lensopt_progress *progress)
{
    watcher *w = static_cast<watcher *>(user);
    if (progress->best < w->seen) {
        w->seen = progress->best;
        std::copy(progress->x, progress->x + w->r->x.size(), w->r->x.begin());
        w->f = value_of(w->thesis, w->r->x);
    }
    w->r->add(w->f, progress->best, progress->evaluations);
    return w->r->f < 1e-12;
}

static run search_ours(const task &t, const std::string &method, unsigned seed)
{
    size_t dash = method.find("-blind");
    std::string kind = method.substr(0, dash);
    bool memetic = kind == "memetic" || kind == "seen" || kind == "ranked";
    lensopt_objective objective = kind == "seen" ? LENSOPT_SEEN : kind == "memetic" ? LENSOPT_MATCHED : LENSOPT_THESIS;
    lensopt_problem_desc wanted = t.desc;
    wanted.blind = !memetic || dash != std::string::npos;
    run r;
    problem_pointer thesis = make_problem(t.desc, t.target.get(), LENSOPT_THESIS);
    r.begin = now();
    problem_pointer p = make_problem(wanted, t.target.get(), objective);
    lensopt_search_desc desc;
    lensopt_limits limits;
    lensopt_search *search;
    lflare_error error;
    std::memset(&desc, 0, sizeof desc);
    std::memset(&limits, 0, sizeof limits);
    lensopt_problem_function(p.get(), &desc.function);
    if (!memetic) desc.function.sample = nullptr; /* evenly, as pagmo's */
    if (!memetic) desc.islands = ISLANDS;
    desc.method = memetic ? LENSOPT_MEMETIC : method == "pso" ? LENSOPT_PSO : LENSOPT_JDE;
    desc.threads = THREADS;
    desc.seed = seed;
    limits.seconds = t.seconds;
    limits.target = memetic ? 1e-24 : 1e-12;
    r.x.resize(static_cast<size_t>(desc.function.variables));
    watcher w = {&r, thesis.get(), HUGE_VAL, HUGE_VAL};
    if (lensopt_search_create(&desc, &search, &error) < 0 || lensopt_search_run(search, &limits, watch, &w, &error) < 0) give_up(method, error);
    lensopt_search_free(search);
    return r;
}

struct pagmo_lenses {
    lensopt_function f = {};
    pagmo::vector_double fitness(const pagmo::vector_double &x) const
    {
        double value = HUGE_VAL;
        f.evaluate(f.user, x.data(), 1, &value);
        return {value};
    }
    std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const
    {
        if (f.variables == 0) return {{0.0}, {1.0}};
        return {pagmo::vector_double(f.lower, f.lower + f.variables), pagmo::vector_double(f.upper, f.upper + f.variables)};
    }
};

/* Rounds of some 0.25 s, for islands' algorithms keep their memory only while the number of generations stays. */
static run search_pagmo(const task &t, const std::string &method, unsigned seed)
{
    problem_pointer p = make_problem(t.desc, t.target.get(), LENSOPT_THESIS);
    pagmo_lenses wrapped;
    run r;
    bool swarm = method.compare(0, 9, "pagmo-pso") == 0;
    lensopt_problem_function(p.get(), &wrapped.f);
    r.begin = now();
    size_t n = static_cast<size_t>(wrapped.f.variables), population = 15 * n;
    std::vector<double> probe(wrapped.f.lower, wrapped.f.lower + n);
    double begin = now();
    for (size_t i = 0; i < 2000; i++) {
        for (size_t j = 0; j < n; j++) probe[j] = wrapped.f.lower[j] + (wrapped.f.upper[j] - wrapped.f.lower[j]) * static_cast<double>((i * 7919 + j * 104729) % 1009) / 1009;
        wrapped.fitness(probe);
    }
    double generation = (now() - begin) / 2000 * static_cast<double>(population) * ISLANDS / THREADS;
    unsigned generations = static_cast<unsigned>(std::min(1000.0, std::max(1.0, 0.25 / generation)));
    pagmo::archipelago islands;
    if (method.size() > 5 && method.compare(method.size() - 5, 5, "-ring") == 0) islands.set_topology(pagmo::topology(pagmo::ring()));
    islands.set_migrant_handling(pagmo::migrant_handling::preserve);
    for (unsigned i = 0; i < ISLANDS; i++) {
        unsigned own = seed * 1000 + i;
        pagmo::algorithm algorithm = swarm ? pagmo::algorithm(pagmo::pso(generations, 0.7298, 2.05, 2.05, 0.5, 5u, 2u, 4u, true, own)) : pagmo::algorithm(pagmo::sade(generations, 7u, 1u, 0, 0, true, own));
        islands.push_back(algorithm, pagmo::problem(wrapped), population, own);
    }
    long long evaluations = 0;
    do {
        islands.evolve();
        islands.wait_check();
        evaluations = 0;
        for (const pagmo::island &island : islands) evaluations += static_cast<long long>(island.get_population().get_problem().get_fevals());
        auto f = islands.get_champions_f();
        size_t best = 0;
        for (size_t i = 1; i < f.size(); i++)
            if (f[i][0] < f[best][0]) best = i;
        if (f[best][0] < r.f) r.x = islands.get_champions_x()[best];
        r.add(f[best][0], f[best][0], evaluations);
    } while (r.seconds < t.seconds && r.f >= 1e-12);
    return r;
}

static std::vector<std::string> split(const std::string &text)
{
    std::vector<std::string> out;
    for (size_t at = 0; at <= text.size();) {
        size_t end = std::min(text.find(',', at), text.size());
        out.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return out;
}

static void write_curve(const std::string &name, const run &r)
{
    FILE *file = std::fopen(name.c_str(), "w");
    if (file == nullptr) return;
    std::fprintf(file, "seconds,best,own,evaluations\n");
    for (const sample &s : r.curve) std::fprintf(file, "%.3f,%.9g,%.9g,%lld\n", s.seconds, s.best, s.own, s.evaluations);
    std::fprintf(file, "%.3f,%.9g,%.9g,%lld\n", r.seconds, r.f, r.own, r.evaluations);
    std::fclose(file);
}

static double quantile(std::vector<double> v, double part)
{
    std::sort(v.begin(), v.end());
    return v[static_cast<size_t>(part * static_cast<double>(v.size() - 1) + 0.5)];
}

static const char *const lens_methods = "memetic,memetic-blind,pso,jde,pagmo-pso,pagmo-sade";

/* All methods on one task, each seed in turn for all of them, so that what else the machine does falls on all alike. */
static void compare_methods(task t, const options &choice, const char *default_methods)
{
    std::vector<std::string> methods = split(choice.methods.empty() ? default_methods : choice.methods);
    struct summary { std::vector<double> f, found, psnr, ssim, bright; double evaluations = 0, seconds = 0; };
    std::vector<summary> all(methods.size());
    if (choice.time > 0) t.seconds = choice.time;
    if (choice.seeds > 0) t.seeds = choice.seeds;
    for (const std::string &m : methods) {
        static const std::vector<std::string> known = {"seen", "memetic", "ranked", "seen-blind", "memetic-blind", "ranked-blind", "pso", "jde", "pagmo-pso", "pagmo-sade", "pagmo-pso-ring", "pagmo-sade-ring"};
        if (std::find(known.begin(), known.end(), m) == known.end()) std::printf("no such method: %s\n", m.c_str()), std::exit(2);
    }
    problem_pointer thesis = make_problem(t.desc, t.target.get(), LENSOPT_THESIS);
    std::vector<disc> wanted = discs_of(t.target.get(), 0);
    std::printf("-- %s: %d spots, %d surfaces, %d variables; %g s, %d seeds: at most %.0f minutes\n", t.name.c_str(), static_cast<int>(thesis->goals), static_cast<int>(thesis->surfaces), static_cast<int>(thesis->variables),
                t.seconds, t.seeds, static_cast<double>(methods.size()) * t.seeds * t.seconds / 60);
    std::printf("%-16s %4s %11s %10s %9s %8s %10s %7s %6s %7s %6s\n", "", "seed", "f", "own", "s to 1e-6", "s", "evals", "PSNR", "SSIM", "bright", "black");
    for (int seed = choice.from; seed < choice.from + t.seeds; seed++)
        for (size_t m = 0; m < methods.size(); m++) {
            run r = (methods[m].compare(0, 5, "pagmo") == 0 ? search_pagmo : search_ours)(t, methods[m], static_cast<unsigned>(seed));
            std::string file = "build/bench_opt_" + t.name + "_" + methods[m] + "_" + std::to_string(seed);
            write_curve(file + ".csv", r);
            likeness like = compare(wanted, discs_of(shown(thesis.get(), r.x, 0)), t.target->lights[0], t.target->sensor_width, choice.pictures ? file + ".pgm" : "");
            double found = r.time_to(1e-6);
            std::printf("%-16s %4d %11.4g %10.3g %9s %8.1f %10.3g %7.2f %6.3f %7.2f %6.2f\n", methods[m].c_str(), seed, r.f, r.own, found < HUGE_VAL ? std::to_string(found).substr(0, 6).c_str() : "-", r.seconds,
                        static_cast<double>(r.evaluations), like.psnr, like.ssim, like.bright, like.black);
            std::fflush(stdout);
            summary &s = all[m];
            s.f.push_back(r.f), s.found.push_back(found), s.psnr.push_back(like.psnr), s.ssim.push_back(like.ssim), s.bright.push_back(like.bright);
            s.evaluations += static_cast<double>(r.evaluations), s.seconds += r.seconds;
        }
    std::printf("%-16s %9s %9s %9s %9s %9s  %5s %9s %7s %7s %6s %7s\n", "distribution of f", "least", "quarter", "median", "3/4", "most", "<1e-6", "median s", "Mev/s", "PSNR", "SSIM", "bright");
    for (size_t m = 0; m < methods.size(); m++) {
        const summary &s = all[m];
        int found = 0;
        for (double v : s.found) found += v < HUGE_VAL;
        double middle = median(s.found);
        std::printf("%-17s %9.3g %9.3g %9.3g %9.3g %9.3g  %2d/%-2d %9s %7.3f %7.2f %6.3f %7.2f\n", methods[m].c_str(), quantile(s.f, 0), quantile(s.f, 0.25), quantile(s.f, 0.5), quantile(s.f, 0.75), quantile(s.f, 1), found, t.seeds,
                    middle < HUGE_VAL ? std::to_string(middle).substr(0, 6).c_str() : "-", 1e-6 * s.evaluations / s.seconds, median(s.psnr), median(s.ssim), median(s.bright));
    }
}

static task own_spots(const std::string &name, const lflare_prescription *lens, double degrees)
{
    task t;
    t.name = name;
    std::memset(&t.desc, 0, sizeof t.desc);
    t.desc.base = lens; /* number of surfaces and bounds; never a start */
    t.desc.iris = 2.25;
    t.target = model_target(t.desc, lights_at({{degrees, degrees}}));
    return t;
}

static void part_heliar(const options &choice)
{
    lflare_prescription lens = read_lens("lenses/heliar-tronnier.lens");
    compare_methods(own_spots("heliar-13.40", &lens, 13.40), choice, lens_methods);
    compare_methods(own_spots("heliar-5.45", &lens, 5.45), choice, lens_methods);
}

static void part_canon(const options &choice)
{
    lflare_prescription lens = read_lens("lenses/canon-28-80.lens");
    task t = own_spots("canon-5.45", &lens, 5.45);
    t.seconds = 600;
    t.seeds = 3;
    compare_methods(t, choice, "seen,ranked,memetic,seen-blind,ranked-blind,pso,jde,pagmo-pso,pagmo-sade");
}

static void part_scratch(const options &choice)
{
    static const struct { const char *name; double seconds; } sets[] = {{"scratch-5", 60}, {"scratch-10", 120}, {"scratch-15", 300}};
    for (const auto &set : sets) {
        task t;
        t.name = set.name;
        t.seconds = set.seconds;
        t.seeds = 5;
        std::memset(&t.desc, 0, sizeof t.desc);
        t.desc.surfaces = choice.surfaces;
        t.target = read_target(std::string("tests/data/") + set.name + ".target");
        compare_methods(t, choice, "memetic,seen");
    }
}

/* ---- part: constrained ---- */

/* What lens optics say of a result, apart from the search's own penalties. */
struct checked { double efl, off_focus, fnumber, length, glass_edge, air_edge; int crossing; bool derived, ok; };

static checked check_lens(const lensopt_problem *p, const lensopt_problem_desc &desc, const std::vector<double> &x, lflare_lens *lens, double *iris)
{
    checked c = {0, 0, 0, 0, HUGE_VAL, HUGE_VAL, 0, false, false};
    lflare_prescription q;
    if (lensopt_problem_prescription(p, x.data(), &q, iris, nullptr) < 0 || lflare_lens_derive(&q, lens, nullptr) < 0) return c;
    const lflare_prescription &d = lens->prescription;
    lflare_matrix m = lflare_system_matrix(lens, 587.5618); /* what the ranges are for */
    c.derived = true;
    c.efl = -1 / m.c;
    c.off_focus = d.surfaces[d.surface_count - 1].thickness + m.a / m.c;
    c.fnumber = c.efl * std::fabs(lens->stop_a11) / (2 * *iris);
    for (int32_t i = 0, last = -1; i < d.surface_count; i++) {
        c.length += d.surfaces[i].thickness;
        if (d.surfaces[i].is_stop) continue;
        if (last >= 0) {
            double gap = 0;
            for (int32_t k = last; k < i; k++) gap += d.surfaces[k].thickness;
            double rim = std::min(d.surfaces[i].semi_diameter, d.surfaces[last].semi_diameter);
            double &edge = d.surfaces[last].medium.kind == LFLARE_MEDIUM_AIR ? c.air_edge : c.glass_edge;
            edge = std::min(edge, gap + lflare_sag(&d.surfaces[i], rim) - lflare_sag(&d.surfaces[last], rim));
        }
        last = i;
    }
    for (int32_t i = 0; i < lens->note_count; i++) c.crossing += lens->notes[i].kind == LFLARE_NOTE_EDGES_CROSS;
    auto within = [](double v, lensopt_range r) { return v >= 0.999 * r.lo && v <= 1.001 * r.hi; };
    c.ok = within(c.efl, desc.efl) && std::fabs(c.off_focus) <= 1.1 * desc.focus && within(c.fnumber, desc.fnumber) && within(c.length, desc.length) && c.crossing == 0 && c.glass_edge >= 0.99 * desc.glass_edge && c.air_edge >= 0.99 * desc.air_edge;
    return c;
}

static std::vector<disc> lens_discs(const lflare_lens *lens, double u, double iris)
{
    int32_t count = 0;
    lflare_ghost_list(lens, nullptr, &count);
    std::vector<lflare_pair> pairs(static_cast<size_t>(count));
    std::vector<lensopt_spot> spots(static_cast<size_t>(count));
    std::vector<disc> out;
    if (lflare_ghost_list(lens, pairs.data(), &count) != LFLARE_OK || lensopt_spots(lens, pairs.data(), count, u, iris, spots.data()) != LFLARE_OK) return out;
    for (const lensopt_spot &s : spots)
        if (s.radius > 0) out.push_back({s.centre, s.radius});
    return out;
}

static std::vector<std::vector<double>> ten_best(lensopt_search *search, const lensopt_function &f, std::vector<double> *values)
{
    size_t n = static_cast<size_t>(f.variables);
    int32_t count = 1000;
    std::vector<double> x(n * static_cast<size_t>(count)), v(static_cast<size_t>(count));
    std::vector<std::vector<double>> out;
    if (lensopt_search_points(search, x.data(), v.data(), &count) < 0) return out;
    for (size_t i = 0; i < static_cast<size_t>(count) && out.size() < 10; i++) {
        std::vector<double> point(&x[i * n], &x[i * n] + n);
        bool fresh = true;
        for (const auto &known : out) {
            double sum = 0;
            for (size_t j = 0; j < n; j++) sum += f.upper[j] > f.lower[j] ? std::pow((point[j] - known[j]) / (f.upper[j] - f.lower[j]), 2) : 0;
            fresh = fresh && std::sqrt(sum / static_cast<double>(n)) > 0.01;
        }
        if (fresh) out.push_back(point), values->push_back(v[i]);
    }
    return out;
}

static void constrained(const char *path, const std::vector<lensopt_light> &lights, double seconds, unsigned seed)
{
    static const std::vector<lensopt_light> others = lights_at({{1, 0.5}, {3, 1}, {4, 4}, {7, 2}, {6, 8}, {9, 3}, {11, 6}, {12, 9}, {14, 4}});
    lflare_prescription lens = read_lens(path);
    lensopt_problem_desc desc, plain;
    lensopt_search_desc search_desc;
    lensopt_limits limits;
    lensopt_search *search;
    lflare_error error;
    lflare_lens own;
    std::memset(&plain, 0, sizeof plain);
    plain.base = &lens;
    plain.iris = 2.25;
    desc = plain;
    desc.efl = {80, 120};
    desc.fnumber = {10, 40};
    desc.length = {60, 200};
    desc.focus = 0.1;
    desc.glass_edge = 0.5;
    desc.air_edge = 0.05;
    target_pointer target = model_target(plain, lights);
    problem_pointer p = make_problem(desc, target.get(), LENSOPT_SEEN);
    std::vector<double> truth = point_of(p.get(), &lens, desc.iris), values;
    if (lflare_lens_derive(&lens, &own, &error) < 0) give_up(path, error);
    std::printf("-- %s, %d light%s, %g s; the lens itself has %.3g\n", path, static_cast<int>(lights.size()), lights.size() > 1 ? "s" : "", seconds, value_of(p.get(), truth));
    std::memset(&search_desc, 0, sizeof search_desc);
    std::memset(&limits, 0, sizeof limits);
    lensopt_problem_function(p.get(), &search_desc.function);
    search_desc.threads = THREADS;
    search_desc.seed = seed;
    limits.seconds = seconds;
    if (lensopt_search_create(&search_desc, &search, &error) < 0 || lensopt_search_run(search, &limits, nullptr, nullptr, &error) < 0) give_up(path, error);
    std::vector<std::vector<double>> best = ten_best(search, search_desc.function, &values);
    lensopt_search_free(search);
    std::printf("     %10s %7s %8s %6s %7s %6s %6s %5s  %-15s %s\n", "f", "EFL", "focus", "f/", "length", "glass", "air", "cross", "PSNR: of lights", "other lights, model / with rims");
    double mean_model = 0, mean_rims = 0;
    std::vector<problem_pointer> at_others;
    std::vector<view> own_views, model_views, rim_views;
    for (size_t l = 0; l < lights.size(); l++) own_views.emplace_back(discs_of(target.get(), static_cast<int32_t>(l)), lights[l], own.sensor_width);
    for (const lensopt_light &light : others) {
        at_others.push_back(make_problem(plain, model_target(plain, {light}).get(), LENSOPT_SEEN));
        model_views.emplace_back(discs_of(shown(at_others.back().get(), truth, 0)), light, own.sensor_width);
        rim_views.emplace_back(lens_discs(&own, lensopt_slope(&light), plain.iris), light, own.sensor_width);
    }
    int good = 0;
    for (size_t i = 0; i < best.size(); i++) {
        lflare_lens found;
        double iris = 0, given = 0, model = 0, rims = 0;
        checked c = check_lens(p.get(), desc, best[i], &found, &iris);
        for (size_t l = 0; l < lights.size(); l++) given += own_views[l].likeness_of(discs_of(shown(p.get(), best[i], static_cast<int32_t>(l)))) / static_cast<double>(lights.size());
        for (size_t l = 0; l < others.size(); l++) {
            model += model_views[l].likeness_of(discs_of(shown(at_others[l].get(), best[i], 0))) / static_cast<double>(others.size());
            if (c.derived) rims += rim_views[l].likeness_of(lens_discs(&found, lensopt_slope(&others[l]), iris)) / static_cast<double>(others.size());
        }
        std::printf("  %2d %10.3g %7.2f %8.4f %6.2f %7.2f %6.3f %6.3f %5d  %15.2f %10.2f / %.2f  %s\n", static_cast<int>(i + 1), values[i], c.efl, c.off_focus, c.fnumber, c.length, c.glass_edge, c.air_edge, c.crossing, given, model, rims,
                    !c.derived ? "no lens" : c.ok ? "ok" : "BROKEN");
        good += c.ok;
        mean_model += model / static_cast<double>(best.size());
        mean_rims += rims / static_cast<double>(best.size());
        std::fflush(stdout);
    }
    std::printf("  %d of %d are lenses within the constraints; mean PSNR at nine other lights %.2f dB, with rims %.2f dB\n", good, static_cast<int>(best.size()), mean_model, mean_rims);
}

static void part_constrained(const options &choice)
{
    double seconds = choice.time > 0 ? choice.time : 60;
    std::printf("EFL 80 to 120, focus within 0.1, f/10 to f/40, 60 to 200 mm long, edges of glass 0.5 and of air 0.05, as it is written; at the d line, by lflare_lens_derive of what was found\n");
    for (const char *path : {"lenses/heliar-tronnier.lens", "lenses/tessar-100-28.lens"})
        for (unsigned seed = 1; seed <= static_cast<unsigned>(choice.seeds > 0 ? choice.seeds : 1); seed++) {
            constrained(path, lights_at({{5.45, 5.45}}), seconds, seed);
            constrained(path, lights_at({{2, 2}, {5.45, 5.45}, {10, 8}}), seconds, seed);
        }
}

/* ---- main ---- */

static const struct { const char *name; void (*run)(const options &choice); } parts[] = {{"functions", part_functions}, {"rate", part_rate}, {"heliar", part_heliar},
                                                                                          {"canon", part_canon}, {"scratch", part_scratch}, {"constrained", part_constrained}};

/* The first two processors that this may run on, so that pagmo's fifteen threads have no more than ours. */
static void two_cores()
{
#if defined(__linux__)
    cpu_set_t may, two;
    CPU_ZERO(&two);
    if (sched_getaffinity(0, sizeof may, &may) != 0) return;
    for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&two) < THREADS; i++)
        if (CPU_ISSET(i, &may)) CPU_SET(i, &two);
    sched_setaffinity(0, sizeof two, &two);
#endif
}

static options read_options(int argc, char **argv)
{
    options o;
    for (int i = 2; i < argc; i++) {
        std::string text = argv[i], name = text.substr(0, text.find('=')), value = text.size() > name.size() ? text.substr(name.size() + 1) : "";
        if (name == "time" && std::atof(value.c_str()) > 0) o.time = std::atof(value.c_str());
        else if (name == "from" && std::atoi(value.c_str()) > 0) o.from = std::atoi(value.c_str());
        else if (name == "seeds" && std::atoi(value.c_str()) > 0) o.seeds = std::atoi(value.c_str());
        else if (name == "surfaces" && std::atoi(value.c_str()) > 0) o.surfaces = std::atoi(value.c_str());
        else if (name == "methods" && !value.empty()) o.methods = value;
        else if (name == "pictures") o.pictures = value != "0";
        else if (text.find('=') == std::string::npos && o.only == nullptr) o.only = argv[i];
        else std::printf("what is %s?\n", argv[i]), std::exit(2);
    }
    return o;
}

int main(int argc, char **argv)
{
    options choice = read_options(argc, argv);
    bool any = false;
    two_cores();
    for (const auto &part : parts) {
        if (argc > 1 && std::strcmp(argv[1], part.name) != 0 && std::strcmp(argv[1], "all") != 0) continue;
        std::printf("== %s\n", part.name);
        part.run(choice);
        any = true;
    }
    if (!any) std::printf("no such part: %s\n", argv[1]);
    return any ? 0 : 2;
}
