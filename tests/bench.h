/* What the bench programs share: a clock, medians, a lens from a file, its fit and lights that move. */
#ifndef BENCH_H
#define BENCH_H

#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

enum { RUNS = 31 };

/* Median seconds of `body`, run `runs` times, at most RUNS. */
#define MEDIAN_OF(runs, result, body)                        \
    do {                                                     \
        double times[RUNS];                                  \
        int run;                                             \
        for (run = 0; run < (runs); run++) {                 \
            double start = now();                            \
            body;                                            \
            times[run] = now() - start;                      \
        }                                                    \
        qsort(times, (runs), sizeof times[0], by_value);     \
        result = times[(runs) / 2];                          \
    } while (0)
#define MEDIAN(result, body) MEDIAN_OF(RUNS, result, body)

/* fit: NULL for the paraxial model. */
static lflare *open_fitted(const char *path, const lflare_settings *settings, lflare_realloc allocate, const void *fit, size_t fit_size)
{
    lflare_desc desc = {0};
    lflare_error error;
    lflare *flare = NULL;
    char *text;
    if (lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error) < 0) {
        printf("%s: %s\n", path, error.text);
        exit(2);
    }
    desc.text = text;
    desc.fit = fit;
    desc.fit_size = fit_size;
    desc.settings = *settings;
    desc.allocate = allocate;
    if (lflare_create(&desc, &flare, &error) < 0) {
        printf("%s:%d:%d: %s\n", path, (int)error.line, (int)error.column, error.text);
        exit(2);
    }
    free(text);
    return flare;
}

/* Ghosts with plain edges; what diffraction costs is measured apart. */
static lflare_settings ghosts_alone(void)
{
    lflare_settings s = {0};
    s.no_starburst = s.no_ringing = 1;
    return s;
}

static lflare *open_lens(const char *path, const lflare_settings *settings, lflare_realloc allocate)
{
    return open_fitted(path, settings, allocate, NULL, 0);
}

/* From malloc. */
static void *fit_of(const lflare *flare, size_t *size, double *seconds)
{
    lflare_error error;
    void *fit = NULL;
    double start = now();
    if (lflare_aberration_fit(lflare_get_lens(flare), NULL, &fit, size, &error) < 0) {
        printf("%s\n", error.text);
        exit(2);
    }
    *seconds = now() - start;
    return fit;
}

/* Lights on a slow circle, moved every frame. */
static void move_lights(lflare_light *lights, int count, int frame)
{
    int i;
    for (i = 0; i < count; i++) {
        float angle = 0.7f * (float)i + 0.01f * (float)frame, size = 0.05f + 0.012f * (float)i;
        memset(&lights[i], 0, sizeof lights[i]);
        lights[i].direction[0] = size * cosf(angle);
        lights[i].direction[1] = size * sinf(angle);
        lights[i].direction[2] = -1;
        lights[i].color[0] = lights[i].color[1] = lights[i].color[2] = 1;
    }
}

#endif
