/* make bench: what each verb costs, side by side in one run. Times are the median of repeated runs on one core. */
#define _POSIX_C_SOURCE 200809L
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "bench.h"

static long allocations;

static void *counting(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) { free(block); return NULL; }
    allocations++;
    return realloc(block, new_size);
}

static void bench_tables(const char *path)
{
    lflare_settings settings = ghosts_alone();
    lflare *flare = open_lens(path, &settings, counting);
    const lflare_lens *lens = lflare_get_lens(flare);
    lflare_tables tables = *lflare_get_tables(flare);
    lflare_tables_size size = lflare_tables_layout(lens, NULL, NULL, NULL, &tables);
    lflare_view view = {0};
    lflare_light lights[16];
    double prepare, configure, derive, one = 0, sixteen = 0;
    static lflare_lens derived;
    int count, frame = 0;
    void *lens_memory = malloc(size.lens), *settings_memory = malloc(size.settings);
    int32_t rims = 0, g;
    if (lens_memory == NULL || settings_memory == NULL) exit(2);
    lflare_tables_layout(lens, NULL, lens_memory, settings_memory, &tables);
    MEDIAN(derive, lflare_lens_derive(&lens->prescription, &derived, NULL));
    MEDIAN(prepare, lflare_tables_prepare(lens, &tables, 0, tables.ghost_count));
    MEDIAN(configure, {
        lflare_tables_configure_begin(lens, &tables, &settings, NULL);
        lflare_tables_configure_range(lens, &tables, &settings, 0, tables.ghost_count);
        lflare_tables_configure_end(&tables, &settings);
    });
    for (g = 0; g < tables.ghost_count; g++) rims += (int32_t)tables.head[g * LFLARE_HEAD_FLOATS + 14];
    view.width = 1280;
    view.height = 720;
    printf("%s: %d ghosts, %.2f rims a ghost\n", lens->prescription.name, (int)tables.ghost_count, (double)rims / tables.ghost_count);
    printf("  derive lens                 %9.3f ms\n", 1e3 * derive);
    printf("  prepare                     %9.3f ms   (aim for the Canon: 2)\n", 1e3 * prepare);
    printf("  configure                   %9.3f ms   %.1f us a ghost, the smallest step\n", 1e3 * configure, 1e6 * configure / tables.ghost_count);
    for (count = 1; count <= 16; count += 15) {
        double t;
        long before = allocations;
        MEDIAN(t, {
            int i;
            for (i = 0; i < 100; i++) {
                move_lights(lights, count, frame++);
                lflare_frame(flare, &view, lights, count);
            }
        });
        *(count == 1 ? &one : &sixteen) = t / 100;
        printf("  frame, %2d light%s            %9.3f us   %d instances, %d bytes, %ld allocations   (aim for the Canon: %d us)\n", count, count == 1 ? " " : "s",
               1e6 * t / 100, (int)lflare_get_frame(flare)->instance_count,
               (int)(lflare_get_frame(flare)->instance_count * (int32_t)sizeof(lflare_instance) + count * (int32_t)sizeof(lflare_frame_light)),
               allocations - before, count == 1 ? 5 : 60);
    }
    printf("  bytes: %.1f KB of tables for the lens, %.1f KB for settings\n", (double)size.lens / 1024, (double)size.settings / 1024);
    free(lens_memory);
    free(settings_memory);
    lflare_destroy(flare);
}

/* Pixels that each ghost lights, added one by one with a plain loop: what any renderer that fills pixels must at least do. */
static double fill_limit(lflare *flare, float *pixels, int width, int height, double *lit)
{
    const lflare_frame_data *frame = lflare_get_frame(flare);
    const lflare_tables *tables = lflare_get_tables(flare);
    int32_t count = frame->instance_count, i, y;
    int32_t *spans = (int32_t *)malloc(sizeof(int32_t) * (size_t)count * (size_t)height * 2);
    float *colours = (float *)malloc(sizeof(float) * 4 * (size_t)count);
    float *row = (float *)malloc(sizeof(float) * 4 * (size_t)width);
    double t;
    lflare_image image = {0};
    if (spans == NULL || colours == NULL || row == NULL) exit(2);
    *lit = 0;
    for (i = 0; i < count; i++) { /* spans found by drawing each ghost alone */
        lflare_footprint fp;
        int32_t k, x;
        if (!lflare_footprint_resolve(tables, frame, frame->instances[i], &fp)) memset(&fp, 0, sizeof fp);
        for (k = 0; k < 3; k++) colours[4 * i + k] = fp.irradiance[k];
        colours[4 * i + 3] = 0;
        for (y = 0; y < height; y++) {
            int32_t *span = spans + ((size_t)i * (size_t)height + (size_t)y) * 2;
            image.width = width;
            image.height = height;
            image.pixels = row - (ptrdiff_t)4 * width * y; /* row y lands in `row` */
            memset(row, 0, sizeof(float) * 4 * (size_t)width);
            if (fp.radius > 0) lflare_software_rows(&fp, 1, &tables->iris, frame, &image, y, y + 1);
            span[0] = span[1] = 0;
            for (x = 0; x < width; x++)
                if (row[4 * x] + row[4 * x + 1] + row[4 * x + 2] > 0) {
                    if (span[1] == 0) span[0] = x;
                    span[1] = x + 1;
                }
            *lit += span[1] - span[0];
        }
    }
    MEDIAN(t, {
        for (y = 0; y < height; y++)
            for (i = 0; i < count; i++) {
                const int32_t *span = spans + ((size_t)i * (size_t)height + (size_t)y) * 2;
                const float *c = colours + 4 * i;
                float *p = pixels + ((size_t)y * (size_t)width + (size_t)span[0]) * 4;
                int32_t x;
                for (x = span[0]; x < span[1]; x++, p += 4) {
                    p[0] += c[0];
                    p[1] += c[1];
                    p[2] += c[2];
                    p[3] += c[3];
                }
            }
    });
    free(spans);
    free(colours);
    free(row);
    return t;
}

static void bench_software(const char *path, double fnumber, float x, float y, float radius)
{
    enum { W = 1280, H = 720 };
    lflare_settings settings = ghosts_alone();
    lflare_view view = {0};
    lflare_light light = {0};
    lflare_image image = {0};
    lflare *flare;
    double ours, limit, lit;
    settings.fnumber = fnumber;
    flare = open_lens(path, &settings, counting);
    view.width = image.width = W;
    view.height = image.height = H;
    light.direction[0] = x;
    light.direction[1] = y;
    light.direction[2] = -1;
    light.color[0] = light.color[1] = light.color[2] = 1;
    light.angular_radius = radius;
    image.pixels = (float *)calloc((size_t)4 * W * H, sizeof(float));
    if (image.pixels == NULL) exit(2);
    MEDIAN(ours, {
        lflare_frame(flare, &view, &light, 1);
        lflare_render(flare, &image);
    });
    limit = fill_limit(flare, image.pixels, W, H, &lit);
    printf("software, %s, f/%g, light %.1f degrees off, lamp %g mrad: %7.2f ms; plain fill of the %.1f million lit pixels %7.2f ms; ratio %.2f (aim 2.5)\n",
           lflare_get_lens(flare)->prescription.name, fnumber, (double)lflare_get_frame(flare)->lights[0].field_angle * 57.2958, 1e3 * (double)radius, 1e3 * ours,
           lit * 1e-6, 1e3 * limit, ours / limit);
    free(image.pixels);
    lflare_destroy(flare);
}

/* Microseconds of lflare_frame, the median; *instances: of the last one. */
static double frame_us(lflare *flare, int count, int *instances)
{
    enum { REPEAT = 100 };
    lflare_view view = {0};
    lflare_light lights[16];
    int i, frame = 0;
    double t;
    view.width = 1280;
    view.height = 720;
    MEDIAN(t, {
        for (i = 0; i < REPEAT; i++) {
            move_lights(lights, count, frame++);
            lflare_frame(flare, &view, lights, count);
        }
    });
    *instances = (int)lflare_get_frame(flare)->instance_count;
    return 1e6 * t / REPEAT;
}

/* Milliseconds of what both models do, taking turns, so that whatever else the machine does meets them alike; the median. */
static void both(lflare *const *flares, void (*work)(lflare *flare, void *user), void *user, int runs, double *ms)
{
    double times[2][RUNS];
    int run, i;
    for (run = 0; run < runs; run++)
        for (i = 0; i < 2; i++) {
            double start = now();
            work(flares[i], user);
            times[i][run] = 1e3 * (now() - start);
        }
    for (i = 0; i < 2; i++) {
        qsort(times[i], (size_t)runs, sizeof times[i][0], by_value);
        ms[i] = times[i][runs / 2];
    }
}

static void configure_again(lflare *flare, void *settings)
{
    if (lflare_configure(flare, (const lflare_settings *)settings, NULL) != LFLARE_OK) exit(2);
}

static void draw_again(lflare *flare, void *image)
{
    lflare_view view = {0};
    lflare_light light = {{0.0954f, 0, -1}, {1, 1, 1}, {0}, 0, 0, 0}; /* 5.45 degrees */
    view.width = ((const lflare_image *)image)->width;
    view.height = ((const lflare_image *)image)->height;
    lflare_frame(flare, &view, &light, 1);
    if (lflare_render(flare, (const lflare_image *)image) != LFLARE_OK) exit(2);
}

/* The software renderer at two openings; flares: paraxial, polynomial. */
static void bench_models_software(lflare *const *flares)
{
    static const double fnumbers[2] = {0, 8};
    lflare_settings settings = ghosts_alone();
    lflare_image image = {0};
    double ms[2];
    int i;
    image.width = 1280;
    image.height = 720;
    image.pixels = (float *)calloc((size_t)4 * 1280 * 720, sizeof(float));
    if (image.pixels == NULL) exit(2);
    for (i = 0; i < 2; i++) {
        settings.fnumber = fnumbers[i];
        configure_again(flares[0], &settings);
        configure_again(flares[1], &settings);
        both(flares, draw_again, &image, 7, ms);
        printf("  software, f/%-4g             %8.2f ms   paraxial %8.2f ms, ratio %.2f\n", (double)lflare_get_tables(flares[1])->fnumber, ms[1], ms[0], ms[1] / ms[0]);
    }
    free(image.pixels);
}

/* The polynomial model beside the paraxial one. */
static void bench_models(const char *path)
{
    lflare_settings settings = ghosts_alone();
    lflare *flares[2]; /* paraxial, polynomial */
    const lflare_lens *lens;
    double seconds, check, ms[2];
    size_t size;
    void *fit;
    int count, instances;
    flares[0] = open_lens(path, &settings, counting);
    lens = lflare_get_lens(flares[0]);
    fit = fit_of(flares[0], &size, &seconds);
    flares[1] = open_fitted(path, &settings, counting, fit, size);
    MEDIAN(check, if (lflare_aberration_check(lens, fit, size, NULL) != LFLARE_OK) exit(2));
    both(flares, configure_again, &settings, 11, ms);
    printf("polynomial, %s: %d ghosts, f/%g\n", lens->prescription.name, (int)lens->ghost_count, (double)lflare_get_tables(flares[1])->fnumber);
    printf("  fit, once                   %9.3f s    %.2f ms a ghost, %.1f KB\n", seconds, 1e3 * seconds / lens->ghost_count, (double)size / 1024);
    printf("  check, to load a fit        %9.3f us   %.1f us a megabyte\n", 1e6 * check, 1e6 * check / ((double)size / 1048576));
    printf("  configure                   %9.3f ms   paraxial %.3f ms, ratio %.2f; %.1f KB of meshes\n", ms[1], ms[0], ms[1] / ms[0],
           (double)lflare_get_tables(flares[1])->mesh_texels * 16 / 1024);
    for (count = 1; count <= 16; count += 15) {
        double us = frame_us(flares[1], count, &instances);
        printf("  frame, %2d light%s            %9.3f us   %d instances, %ld bytes of them\n", count, count == 1 ? " " : "s", us, instances,
               (long)instances * (long)sizeof(lflare_instance));
    }
    bench_models_software(flares);
    lflare_destroy(flares[0]);
    lflare_destroy(flares[1]);
    free(fit);
}

/* A starburst of six blades, slice by slice; the slowest slice is the largest step of a spread rebuild. */
static void bench_starburst(int32_t size)
{
    lflare_settings settings = ghosts_alone();
    lflare *flare;
    lflare_starburst starburst;
    lflare_starburst_job job;
    lflare_iris iris;
    float *tables = (float *)malloc(sizeof(float) * LFLARE_STARBURST_FLOATS);
    void *work = malloc(lflare_starburst_bytes(size));
    double start, first, whole, slowest = 0;
    int slices = 0, more = 1;
    settings.blades = 6;
    flare = open_lens("lenses/heliar-tronnier.lens", &settings, counting);
    iris = lflare_get_tables(flare)->iris;
    if (tables == NULL || work == NULL) exit(2);
    start = now();
    if (lflare_starburst_begin(&iris, size, tables, work, &starburst, &job) != LFLARE_OK) exit(2);
    first = now() - start;
    while (more) {
        double began = now();
        more = lflare_starburst_step(&job, 1) == LFLARE_INCOMPLETE;
        began = now() - began;
        if (began > slowest) slowest = began;
        slices++;
    }
    whole = now() - start;
    printf("starburst, %4d x %-4d          %9.2f ms   %d slices, the slowest %.3f ms, to begin %.3f ms; %.2f MB on a GPU, %.2f MB to work in (aims: 60 and 300 ms, 1 ms)\n",
           (int)size, (int)size, 1e3 * whole, slices, 1e3 * slowest, 1e3 * first, 2e-6 * (double)LFLARE_STARBURST_FLOATS, 1e-6 * (double)lflare_starburst_bytes(size));
    lflare_destroy(flare);
    free(tables);
    free(work);
}

/* A frame in software: ghosts with plain edges, with fringes, the whole flare. */
static void bench_whole(const char *path, double fnumber)
{
    static const char *const names[2] = {"with fringes", "whole flare "};
    lflare_settings settings = ghosts_alone();
    lflare *flares[2];
    lflare_image image = {0};
    double ms[2];
    int i;
    settings.fnumber = fnumber;
    image.width = 1280;
    image.height = 720;
    image.pixels = (float *)calloc((size_t)image.width * (size_t)image.height, 4 * sizeof(float));
    if (image.pixels == NULL) exit(2);
    for (i = 0; i < 2; i++) {
        lflare_settings more = settings;
        more.no_ringing = 0;
        more.no_starburst = i == 0;
        flares[0] = open_lens(path, &settings, counting);
        flares[1] = open_lens(path, &more, counting);
        both(flares, draw_again, &image, 7, ms);
        printf("software, %s, f/%g, %s %8.2f ms   plain ghosts %8.2f ms, ratio %.2f\n", path, fnumber, names[i], ms[1], ms[0], ms[1] / ms[0]);
        lflare_destroy(flares[0]);
        lflare_destroy(flares[1]);
    }
    free(image.pixels);
}

int main(void)
{
    bench_tables("lenses/heliar-tronnier.lens");
    bench_tables("lenses/canon-28-80.lens");
    bench_tables("lenses/nikon-80-200-mid.lens");
    bench_software("lenses/heliar-tronnier.lens", 8, 0.0954f, 0, 0);
    bench_software("lenses/heliar-tronnier.lens", 22, 0.0954f, 0, 0);
    bench_software("lenses/heliar-tronnier.lens", 8, 0.0954f, 0, 0.00465f);
    bench_software("lenses/nikon-80-200-mid.lens", 2.8, 0.0954f, 0, 0);
    bench_software("lenses/nikon-80-200-mid.lens", 8, 0.0954f, 0, 0);
    bench_software("lenses/nikon-80-200-mid.lens", 8, 0.0954f, 0, 0.00465f);
    bench_starburst(512);
    bench_starburst(1024);
    bench_whole("lenses/heliar-tronnier.lens", 8);
    bench_whole("lenses/nikon-80-200-mid.lens", 8);
    bench_models("lenses/heliar-tronnier.lens");
    bench_models("lenses/nikon-80-200-mid.lens");
    return 0;
}
