/* Diffraction: the transform against FFTW, starbursts against closed forms and against sums over wavelengths and discs made here,
   masks, f-numbers, what is made once and what anew, and what is refused. */

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <fftw3.h>
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "fresnel.h"

#define HELIAR "lenses/heliar-tronnier.lens"
#define PI 3.14159265358979323846

/* ---- helpers ---- */

static uint32_t dice;

static double random_number(void) /* -1 to 1 */
{
    dice = dice * 1664525u + 1013904223u;
    return (double)(dice >> 8) / 8388608.0 - 1;
}

static lflare_iris iris_of(int32_t blades, double curvature)
{
    static lflare_lens lens;
    lflare_iris iris;
    lens.stop_a11 = 1;
    lens.efl = 2;
    lens.fnumber = 1;
    lens.prescription.surfaces[0].semi_diameter = 1;
    assert_int_equal(lflare_iris_make(&lens, 1, blades, 0.2, curvature, &iris, NULL), LFLARE_OK);
    return iris;
}

static lflare_iris masked(int32_t blades, const lflare_mask_desc *desc)
{
    static uint8_t mask[LFLARE_MASK_BYTES];
    lflare_iris iris = iris_of(blades, 0);
    lflare_error error;
    if (lflare_mask_check(desc, &error) != LFLARE_OK) fail_msg("%s", error.text);
    lflare_mask_rows(desc, mask, 0, LFLARE_MASK_SIZE);
    assert_int_equal(lflare_iris_set_mask(&iris, mask), LFLARE_OK);
    return iris;
}

typedef struct made {
    lflare_starburst s;
    double flux[3]; /* before it was normalised */
    float *tables;
} made;

static made make_starburst(const lflare_iris *iris, int32_t size)
{
    lflare_starburst_job job;
    made m;
    void *work = malloc(lflare_starburst_bytes(size));
    int k;
    m.tables = (float *)malloc(sizeof(float) * LFLARE_STARBURST_FLOATS);
    assert_true(work != NULL && m.tables != NULL);
    assert_int_equal(lflare_starburst_begin(iris, size, m.tables, work, &m.s, &job), LFLARE_OK);
    assert_int_equal(lflare_starburst_step(&job, 5), LFLARE_INCOMPLETE);
    assert_int_equal(lflare_starburst_step(&job, INT32_MAX), LFLARE_OK);
    for (k = 0; k < 3; k++) m.flux[k] = job.flux[k];
    free(work);
    return m;
}

/* Power spectrum of an iris, `across` texels wide, padded to n x n, by FFTW: [y][x], frequency 0 first. */
static double *spectrum_of(const lflare_iris *iris, int across, int n, double *energy)
{
    fftw_complex *a = (fftw_complex *)fftw_malloc(sizeof(fftw_complex) * (size_t)n * (size_t)n);
    double *power = (double *)malloc(sizeof(double) * (size_t)n * (size_t)n);
    fftw_plan plan = fftw_plan_dft_2d(n, n, a, a, FFTW_FORWARD, FFTW_ESTIMATE);
    int x, y, i, j;
    *energy = 0;
    memset(a, 0, sizeof(fftw_complex) * (size_t)n * (size_t)n);
    for (y = -1; y <= across; y++) /* 8 x 8 samples a texel */
        for (x = -1; x <= across; x++) {
            double sum = 0;
            for (j = 0; j < 8; j++)
                for (i = 0; i < 8; i++)
                    sum += sqrt((double)lflare_iris_transmission(iris, (float)((x + (i + 0.5) / 8) * 2 / across - 1), (float)((y + (j + 0.5) / 8) * 2 / across - 1), 1e-4f)) / 64;
            a[(y + n) % n * n + (x + n) % n][0] = sum;
            *energy += sum * sum;
        }
    fftw_execute(plan);
    for (i = 0; i < n * n; i++) power[i] = a[i][0] * a[i][0] + a[i][1] * a[i][1];
    fftw_destroy_plan(plan);
    fftw_free(a);
    return power;
}

static double between(const double *power, int n, double x, double y)
{
    int ix = (int)floor(x), iy = (int)floor(y), x0 = (ix + 4 * n) % n, y0 = (iy + 4 * n) % n, x1 = (x0 + 1) % n, y1 = (y0 + 1) % n;
    double fx = x - ix, fy = y - iy;
    return (1 - fy) * ((1 - fx) * power[y0 * n + x0] + fx * power[y0 * n + x1]) + fy * ((1 - fx) * power[y1 * n + x0] + fx * power[y1 * n + x1]);
}

/* ---- the transform ---- */

static void against_fftw(void **state)
{
    static const int sizes[] = {2, 8, 64, 512, 1024};
    size_t s;
    (void)state;
    for (s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        int n = sizes[s], i, j;
        size_t cells = (size_t)n * (size_t)n;
        fftw_complex *a = (fftw_complex *)fftw_malloc(sizeof(fftw_complex) * cells);
        float *b = (float *)malloc(2 * sizeof(float) * cells), *line = (float *)malloc(4 * sizeof(float) * (size_t)n), *roots = (float *)malloc(2 * sizeof(float) * (size_t)n);
        double wrong = 0, all = 0, worst = 0, before = 0;
        fftw_plan plan = fftw_plan_dft_2d(n, n, a, a, FFTW_FORWARD, FFTW_ESTIMATE);
        lflare__roots(roots, n);
        for (i = 0; i < (int)(2 * cells); i++) b[i] = (float)random_number();
        for (i = 0; i < (int)cells; i++) {
            a[i][0] = (double)b[2 * i];
            a[i][1] = (double)b[2 * i + 1];
            before += (double)b[2 * i] * (double)b[2 * i] + (double)b[2 * i + 1] * (double)b[2 * i + 1];
        }
        fftw_execute(plan);
        for (j = 0; j < n; j++) {
            memcpy(line, b + 2 * j * n, 2 * sizeof(float) * (size_t)n);
            memcpy(b + 2 * j * n, lflare__fft(line, line + 2 * n, roots, n), 2 * sizeof(float) * (size_t)n);
        }
        for (i = 0; i < n; i++) {
            float *out;
            for (j = 0; j < n; j++) memcpy(line + 2 * j, b + 2 * (j * n + i), 2 * sizeof(float));
            out = lflare__fft(line, line + 2 * n, roots, n);
            for (j = 0; j < n; j++) memcpy(b + 2 * (j * n + i), out + 2 * j, 2 * sizeof(float));
        }
        for (i = 0; i < (int)cells; i++) {
            double off = hypot(a[i][0] - (double)b[2 * i], a[i][1] - (double)b[2 * i + 1]);
            wrong += off * off;
            all += (double)b[2 * i] * (double)b[2 * i] + (double)b[2 * i + 1] * (double)b[2 * i + 1];
            worst = fmax(worst, off);
        }
        if (n == 1024) print_message("FFT of 1024 x 1024 against FFTW: rms %.2g, worst %.2g of the rms of what it finds; Parseval %.2g\n", sqrt(wrong / all), worst / sqrt(all / (double)cells), fabs(all / (before * (double)cells) - 1));
        assert_true(sqrt(wrong / all) < 1e-5);
        assert_true(worst / sqrt(all / (double)cells) < 1e-5);
        assert_true(fabs(all / (before * (double)cells) - 1) < 1e-6);
        fftw_destroy_plan(plan);
        fftw_free(a);
        free(b);
        free(line);
        free(roots);
    }
}

/* What the library keeps of a real picture's spectrum, in both of its sizes. */
static void half_plane_against_fftw(void **state)
{
    enum { ACROSS = 64, N = 256, COLUMNS = 90 };
    static float amplitude[ACROSS * ACROSS], half[2 * ACROSS * COLUMNS], power[COLUMNS * (2 * COLUMNS - 1)], line[4 * N], roots[2 * N];
    lflare__transform t;
    fftw_complex *a = (fftw_complex *)fftw_malloc(sizeof(fftw_complex) * N * N);
    fftw_plan plan = fftw_plan_dft_2d(N, N, a, a, FFTW_FORWARD, FFTW_ESTIMATE);
    double wrong = 0, all = 0;
    int x, y;
    (void)state;
    memset(a, 0, sizeof(fftw_complex) * N * N);
    for (y = 0; y < ACROSS; y++)
        for (x = 0; x < ACROSS; x++) a[y * N + x][0] = (double)(amplitude[y * ACROSS + x] = (float)(0.5 + 0.5 * random_number()));
    fftw_execute(plan);
    t.amplitude = amplitude;
    t.half = half;
    t.power = power;
    t.line = line;
    t.roots = roots;
    t.across = ACROSS;
    t.n = N;
    t.columns = COLUMNS;
    lflare__roots(roots, N);
    for (y = 0; y < ACROSS / 2; y++) lflare__transform_rows(&t, y);
    for (x = 0; x < COLUMNS; x++) lflare__transform_column(&t, x);
    for (x = 1 - COLUMNS; x < COLUMNS; x++)
        for (y = 1 - COLUMNS; y < COLUMNS; y++) {
            const double *z = a[(y + N) % N * N + (x + N) % N];
            double want = z[0] * z[0] + z[1] * z[1], off = (double)lflare__power_at(&t, x, y) - want;
            wrong += off * off;
            all += want * want;
        }
    assert_true(sqrt(wrong / all) < 1e-5);
    fftw_destroy_plan(plan);
    fftw_free(a);
}

/* ---- closed forms ---- */

static double along(const lflare__transform *t, int direction, int i)
{
    static const int steps[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    return (double)lflare__power_at(t, steps[direction][0] * i, steps[direction][1] * i);
}

/* One wavelength, through the library's own picture and transform: 256 texels across, padded eight times. */
static void airy(void **state)
{
    enum { ACROSS = 256, N = 2048, COLUMNS = 64 };
    static float amplitude[ACROSS * ACROSS], half[2 * ACROSS * COLUMNS], power[COLUMNS * (2 * COLUMNS - 1)], line[4 * N], roots[2 * N];
    const double wide = ACROSS - 4.0;
    lflare_iris iris = iris_of(0, 0);
    lflare__transform t;
    double flux = 0, within[2] = {0, 0}, ring[2];
    int x, y, k, d;
    (void)state;
    for (y = 0; y < ACROSS; y++)
        for (x = 0; x < ACROSS; x++) {
            float a = lflare__iris_outline(&iris, (float)((x - 0.5 * (ACROSS - 1)) * 2 / wide), (float)((y - 0.5 * (ACROSS - 1)) * 2 / wide), (float)(2 / wide));
            amplitude[y * ACROSS + x] = a;
            flux += (double)a * (double)a;
        }
    t.amplitude = amplitude;
    t.half = half;
    t.power = power;
    t.line = line;
    t.roots = roots;
    t.across = ACROSS;
    t.n = N;
    t.columns = COLUMNS;
    lflare__roots(roots, N);
    for (y = 0; y < ACROSS / 2; y++) lflare__transform_rows(&t, y);
    for (x = 0; x < COLUMNS; x++) lflare__transform_column(&t, x);
    for (d = 0; d < 4; d++) /* dark rings along rows, columns and diagonals, wavelengths times f-number */
        for (k = 0; k < 2; k++) {
            double expected = k == 0 ? 1.2197 : 2.2331, step = (d < 2 ? 1 : sqrt(2)) * wide / N, a[4], flipped;
            int at = (int)(expected / step), i, least = at - 1;
            for (i = at - 1; i <= at + 2; i++)
                if (along(&t, d, i) < along(&t, d, least)) least = i;
            for (i = 0; i < 4; i++) a[i] = sqrt(along(&t, d, least - 2 + i)) * (i < 3 ? 1 : -1);
            flipped = fabs(a[0] - 3 * a[1] - 3 * a[2] - a[3]); /* amplitudes change sign there: before the least power or behind it, whichever is smoother */
            if (flipped < fabs(a[0] - 3 * a[1] + 3 * a[2] - a[3])) ring[k] = (least - 1 + a[1] / (a[1] + a[2])) * step / expected - 1;
            else ring[k] = (least + a[2] / (a[2] - a[3])) * step / expected - 1;
            if (fabs(ring[k]) > 0.01) fail_msg("dark ring %d at %g wavelengths f-number", k + 1, expected * (1 + ring[k]));
        }
    for (x = 1 - COLUMNS; x < COLUMNS; x++)
        for (y = 1 - COLUMNS; y < COLUMNS; y++)
            for (k = 0; k < 2; k++)
                if (hypot(x, y) < (k == 0 ? 1.2197 : 2.2331) * N / wide) within[k] += (double)lflare__power_at(&t, x, y) / ((double)N * N * flux);
    print_message("round iris: dark rings off by %.2f and %.2f %%, encircled energy %.4f (0.838), %.4f (0.910)\n", 100 * ring[0], 100 * ring[1], within[0], within[1]);
    assert_true(fabs(within[0] / 0.8378 - 1) < 0.01 && fabs(within[1] / 0.9099 - 1) < 0.01);
}

/* A square hole gives sinc^2 along both sides, in the tables of three wavelengths: here folded with the same colours. */
static void square(void **state)
{
    static float pixels[64 * 64];
    lflare_mask_desc desc;
    lflare_iris iris;
    made m;
    double wrong = 0, all = 0;
    int i, k, x, y;
    (void)state;
    for (y = 0; y < 64; y++)
        for (x = 0; x < 64; x++) pixels[64 * y + x] = x >= 16 && x < 48 && y >= 16 && y < 48; /* half the diameter */
    memset(&desc, 0, sizeof desc);
    desc.pixels = pixels;
    desc.width = desc.height = 64;
    iris = masked(0, &desc);
    assert_true(fabs((double)iris.area - 1 / PI) < 0.003);
    m = make_starburst(&iris, 1024);
    for (i = 0; i < 600; i++) { /* within the middle, along one side and aslant */
        double q = 0.3 + 0.02 * (i / 2), angle = i % 2 == 0 ? 0.01 : 0.6, want[3] = {0, 0, 0};
        float got[3];
        for (k = 0; k < 81; k++) {
            double ratio = (380 + 5.0 * k) / 550, a = PI * 0.5 * q / ratio * cos(angle), b = PI * 0.5 * q / ratio * sin(angle);
            double value = 0.25 / (ratio * ratio) * pow(sin(a) / a * sin(b) / b, 2);
            int c;
            for (c = 0; c < 3; c++) want[c] += value * lflare__channel_weight(c, k);
        }
        lflare_starburst_at(&m.s, (float)(q * cos(angle)), (float)(q * sin(angle)), 0.125f, got);
        for (k = 0; k < 3; k++) {
            wrong += pow((double)got[k] - want[k], 2);
            all += want[k] * want[k];
        }
    }
    print_message("square iris: rms difference from sinc^2 %.2f %% of its rms\n", 100 * sqrt(wrong / all));
    assert_true(sqrt(wrong / all) < 0.02);
    free(m.tables);
}

/* Even counts of straight blades have as many spikes, odd ones twice as many. */
static void spikes(void **state)
{
    int32_t blades;
    (void)state;
    for (blades = 3; blades <= 12; blades++) {
        lflare_iris iris = iris_of(blades, 0);
        made m = make_starburst(&iris, 1024);
        int i, count = 0;
        for (i = 0; i < 3600; i++) { /* tenths of degrees: what stands out among 3 degrees either way, and above the mean */
            float here[3], other[3];
            int j, most = 1;
            lflare_starburst_at(&m.s, (float)(60 * cos(i * PI / 1800)), (float)(60 * sin(i * PI / 1800)), 1, here);
            for (j = -30; j <= 30 && most; j++) {
                lflare_starburst_at(&m.s, (float)(60 * cos((i + j) * PI / 1800)), (float)(60 * sin((i + j) * PI / 1800)), 1, other);
                most = other[1] < here[1] || (other[1] <= here[1] && j >= 0);
            }
            count += most && here[1] > 4e-7f; /* the mean there is 1.7e-7 */
        }
        if (count != (blades % 2 == 0 ? blades : 2 * blades)) fail_msg("%d blades: %d spikes", (int)blades, count);
        free(m.tables);
    }
}

/* ---- against sums made here ---- */

/* PSNR of a part of the picture after a tone map that shows its middle or its spikes. */
static double against_sum(const lflare_iris *iris, double pixel, double blur, double exposure)
{
    enum { SIDE = 48, ACROSS = 128, N = 1024 };
    double energy, *power = spectrum_of(iris, ACROSS, N, &energy), wrong = 0;
    made m = make_starburst(iris, 1024);
    int x, y, s, i, k, count = 0, samples = blur < 1 ? 64 : 1024; /* the light is within 1 of a disc's middle */
    double weights[81][3];
    for (i = 0; i < 81; i++)
        for (k = 0; k < 3; k++) weights[i][k] = lflare__channel_weight(k, i);
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            double px = (x + 0.5 - SIDE / 3.0) * pixel, py = (y + 0.5 - SIDE / 2.0) * pixel, want[3] = {0, 0, 0};
            float got[3];
            lflare_starburst_at(&m.s, (float)px, (float)py, (float)blur, got);
            for (s = 0; s < samples; s++) {
                double r = blur * sqrt((s + 0.5) / samples), turn = 2.399963229728653 * s;
                for (i = 0; i < 81; i += 3) {
                    double ratio = (380 + 5.0 * i) / 550, scale = (double)N / ACROSS / ratio;
                    double value = between(power, N, (px + r * cos(turn)) * scale, (py + r * sin(turn)) * scale) / (energy * ACROSS * ACROSS * ratio * ratio);
                    for (k = 0; k < 3; k++) want[k] += 3 * value / samples * weights[i][k];
                }
            }
            for (k = 0; k < 3; k++) {
                double a = pow(1 - exp(-exposure * want[k]), 1 / 2.2), b = pow(1 - exp(-exposure * (double)got[k]), 1 / 2.2);
                wrong += (a - b) * (a - b);
                count++;
            }
        }
    free(power);
    free(m.tables);
    return 10 * log10(count / wrong);
}

static void folded_and_blurred(void **state)
{
    static const struct {
        int32_t blades;
        double curvature, pixel, blur, exposure;
    } cases[] = {
        {0, 0, 0.25, 0.2, 5},  {0, 0, 1, 0.6, 500}, {0, 0, 1, 8, 200},      {6, 0, 0.25, 0.2, 5},
        {6, 0, 1, 0.6, 1000},  {6, 0, 1, 6, 200},   {5, 0.5, 1, 0.6, 1000}, {7, 0, 1, 3, 500},
    };
    size_t i;
    (void)state;
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        lflare_iris iris = iris_of(cases[i].blades, cases[i].curvature);
        double found = against_sum(&iris, cases[i].pixel, cases[i].blur, cases[i].exposure);
        print_message("%d blades, curvature %g, pixel %g, disc %g: %.1f dB against the sum over wavelengths and disc\n", (int)cases[i].blades, cases[i].curvature, cases[i].pixel, cases[i].blur, found);
        if (found < 36) fail_msg("at least 36 dB");
    }
}

/* Before normalising the tables hold the light that the iris passes, whatever its shape; drawn, all of it. */
static void flux_is_whole(void **state)
{
    int what;
    (void)state;
    for (what = 0; what < 4; what++) {
        lflare_mask_desc desc;
        lflare_iris iris;
        double sum[3] = {0, 0, 0}, blur = 20;
        float rgb[3];
        made m;
        int k, x, y;
        memset(&desc, 0, sizeof desc);
        desc.dust_count = 40;
        desc.scratch_count = 20;
        desc.scratch_spread = 1.5f;
        iris = what == 3 ? masked(8, &desc) : iris_of(what == 0 ? 0 : 6, what == 2 ? 0.6 : 0);
        m = make_starburst(&iris, 512);
        for (y = -100; y < 100; y++)
            for (x = -100; x < 100; x++) {
                lflare_starburst_at(&m.s, 2.5f * ((float)x + 0.5f), 2.5f * ((float)y + 0.5f), (float)blur, rgb);
                for (k = 0; k < 3; k++) sum[k] += 6.25 * (double)rgb[k];
            }
        for (k = 0; k < 3; k++) {
            double beyond = 2 * PI * (double)m.s.tail[k] / 280; /* of the square: about that of a disc of equal area */
            if (fabs(m.flux[k] - 1) > 0.03) fail_msg("iris %d, channel %d: flux %g before normalising", what, k, m.flux[k]);
            if (fabs(sum[k] + beyond - 1) > 0.02) fail_msg("iris %d, channel %d: %g drawn", what, k, sum[k] + beyond);
        }
        free(m.tables);
    }
}

/* ---- f-numbers ---- */

static lflare *open_lens(const char *path, const lflare_settings *settings)
{
    lflare_desc desc;
    lflare_error error;
    lflare *flare;
    char *text;
    memset(&desc, 0, sizeof desc);
    assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error), LFLARE_OK);
    desc.text = text;
    desc.settings = *settings;
    if (lflare_create(&desc, &flare, &error) != LFLARE_OK) fail_msg("%s", error.text);
    free(text);
    return flare;
}

static lflare *open_with(const lflare_settings *settings) { return open_lens(HELIAR, settings); }

/* Of a light of fixed irradiance: distance within which half the flux falls, mm; flux; the brightest point. */
static void measure(const lflare_tables *t, double *width, double *flux, double *peak)
{
    double sum = 0, within = 0, step = (double)t->starburst_unit * 0.05, r;
    float rgb[3];
    for (r = 0.5 * step; r < 4000 * step; r += step) {
        lflare_starburst_at(t->starburst, (float)(r / (double)t->starburst_unit), 0, 0.125f, rgb);
        sum += (double)(rgb[1] * t->starburst_gain[1]) * 2 * PI * r * step;
    }
    for (r = 0.5 * step; within < 0.5 * sum; r += step) {
        lflare_starburst_at(t->starburst, (float)(r / (double)t->starburst_unit), 0, 0.125f, rgb);
        within += (double)(rgb[1] * t->starburst_gain[1]) * 2 * PI * r * step;
    }
    lflare_starburst_at(t->starburst, 0, 0, 0.125f, rgb);
    *width = r;
    *flux = sum;
    *peak = (double)(rgb[1] * t->starburst_gain[1]);
}

static void fnumbers(void **state)
{
    static const double stops[] = {0, 4, 5.6, 8, 11, 16, 22, 32};
    lflare_settings settings;
    lflare *flare;
    double width[2], flux[2], peak[2], first = 0, expected;
    const lflare_tables *t;
    const lflare_lens *lens;
    size_t i;
    (void)state;
    memset(&settings, 0, sizeof settings);
    settings.raw = 1;
    flare = open_with(&settings);
    lens = lflare_get_lens(flare);
    for (i = 0; i < sizeof stops / sizeof *stops; i++) {
        settings.fnumber = stops[i];
        assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
        t = lflare_get_tables(flare);
        assert_true(t->starburst != NULL);
        measure(t, &width[i > 0], &flux[i > 0], &peak[i > 0]);
        if (i == 0) {
            first = (double)t->fnumber;
            expected = PI / 4 * pow(lens->efl / first, 2) * (double)t->transmission[1]; /* of the whole pupil */
            assert_true(fabs(flux[0] / expected - 1) < 0.01);
            assert_true(t->transmission[1] > 0.9f && t->transmission[1] < 1);
            continue;
        }
        {
            double n = (double)t->fnumber / first;
            if (!(fabs(width[1] / width[0] / n - 1) < 0.01 && fabs(flux[1] / flux[0] * n * n - 1) < 0.01 && fabs(peak[1] / peak[0] * n * n * n * n - 1) < 0.01))
                fail_msg("f/%g to f/%g: width %g, flux %g, peak %g of what they should be", first, (double)t->fnumber, width[1] / width[0] / n, flux[1] / flux[0] * n * n, peak[1] / peak[0] * n * n * n * n);
        }
    }
    lflare_destroy(flare);
}

/* ---- ringing ---- */

extern double j0(double); /* of POSIX, which C99 hides */

/* A ghost of a point of light on the axis, iris round: Collins's integral from the stop to a point of the sensor, over the geometric
   irradiance. `bent`: m / (lambda Bs), `turned`: 1 / (lambda Bs). */
static double collins(double iris, double bent, double turned, double m, double s)
{
    int steps = 2000 + (int)(12 * fabs(bent) * iris * iris), i;
    double re = 0, im = 0;
    for (i = 0; i < steps; i++) {
        double a = iris * (i + 0.5) / steps, weight = a * j0(2 * PI * a * s * turned);
        re += weight * cos(PI * bent * a * a);
        im += weight * sin(PI * bent * a * a);
    }
    re *= 2 * PI * turned * iris / steps * m;
    im *= 2 * PI * turned * iris / steps * m;
    return re * re + im * im;
}

/* The same over the band that a channel stands for. */
static double collins_band(double iris, double bent, double turned, double m, double s, int band)
{
    double sum = 0, weights = 0;
    int k;
    for (k = -band; k <= band; k++) {
        double x = band > 0 ? 2.5 * k / band : 0, weight = exp(-0.5 * x * x);
        sum += weight * collins(iris, bent / (1 + 0.05 * x), turned / (1 + 0.05 * x), m, s);
        weights += weight;
    }
    return sum / weights;
}

/* Drawn edges against the integral, for real ghosts: the first maximum and where it is, and all fringes up to 4.2 lengths. */
static void fringes_against_collins(void **state)
{
    static const char *const paths[3] = {HELIAR, "lenses/nikon-80-200-mid.lens", "lenses/planar-50-14.lens"};
    int l, found = 0;
    (void)state;
    for (l = 0; l < 3; l++) {
        lflare_settings settings;
        lflare *flare;
        const lflare_tables *t;
        lflare_tables bare;
        lflare_light light;
        lflare_view view;
        int g, here = 0;
        memset(&settings, 0, sizeof settings);
        settings.no_starburst = settings.raw = 1;
        settings.fnumber = 8;
        flare = open_lens(paths[l], &settings);
        t = lflare_get_tables(flare);
        bare = *t;
        bare.mean_irradiance = 0; /* faint ghosts too */
        memset(&view, 0, sizeof view);
        view.width = 1 << 20; /* pixels far finer than fringes */
        view.height = 1 << 10;
        memset(&light, 0, sizeof light);
        light.direction[2] = -1;
        light.color[0] = light.color[1] = light.color[2] = 1;
        assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
        for (g = 0; g < lflare_get_frame(flare)->instance_count && here < 2; g++) {
            lflare_instance instance = lflare_get_frame(flare)->instances[g];
            lflare_ghost_matrices o;
            lflare_footprint fp;
            double lambda = 1e-6 * (double)t->wavelengths[1], iris = (double)t->iris.radius, m, number, ring, edge, w, best[3] = {0, 0, 0}, at[3] = {0, 0, 0}, near[3][64], places[64], wrong = 0;
            int n = 0, row = 0;
            assert_int_equal(lflare_ghost_optics(lflare_get_lens(flare), (double)t->wavelengths[1], &t->pairs[instance.ghost], 1, &o), LFLARE_OK);
            m = o.m.a / o.ma.a;
            number = iris * iris * fabs(m) / (lambda * fabs(o.ms.b));
            if (number < 100 || number > 3000 || !lflare_footprint_resolve(&bare, lflare_get_frame(flare), instance, &fp) || fp.edge_count > 1 || fp.fine) continue;
            edge = fabs(m) * iris;
            ring = edge / sqrt(2 * number);
            for (w = -1; w <= 4.2; w += 0.03) {
                double s = edge - w * ring, value[3];
                int k;
                value[0] = (double)lflare_footprint_coverage(&fp, 1, &t->iris, (float)s, 0);
                value[1] = collins_band(iris, m / (lambda * o.ms.b), 1 / (lambda * fabs(o.ms.b)), m, s, 2);
                value[2] = w > 0.9 && w < 1.6 ? collins(iris, m / (lambda * o.ms.b), 1 / (lambda * fabs(o.ms.b)), m, s) : 0;
                for (k = 0; k < 3; k++)
                    best[k] = fmax(best[k], value[k]);
                if (w > 0.9 && w < 1.6 && row < 64) {
                    for (k = 0; k < 3; k++) near[k][row] = value[k];
                    places[row++] = w;
                }
                if (w < 0) continue;
                wrong += pow(value[0] - value[1], 2);
                n++;
            }
            wrong = sqrt(wrong / n);
            for (w = 0; w < 3; w++) { /* the middle of what is above half of the fringe's height over the plateau */
                int k = (int)w, i;
                double sum = 0, weight = 0;
                for (i = 0; i < row; i++) {
                    double over = fmax(near[k][i] - 0.5 * (1 + best[k]), 0);
                    sum += over * places[i];
                    weight += over;
                }
                at[k] = sum / weight;
            }
            print_message("%s (%d,%d), Fresnel number %.0f: first maximum %.3f at %.2f lengths, of the integral %.3f at %.2f (one wavelength %.3f at %.2f); rms to 4.2 lengths %.1f %%\n", paths[l],
                          (int)t->pairs[instance.ghost].first + 1, (int)t->pairs[instance.ghost].second + 1, number, best[0], at[0], best[1], at[1], best[2], at[2], 100 * wrong);
            assert_true(fabs(best[0] / best[1] - 1) < 0.02 && fabs(best[0] / best[2] - 1) < 0.02);
            assert_true(fabs(at[0] / at[1] - 1) < 0.03 && fabs(at[0] / at[2] - 1) < 0.03);
            assert_true(wrong < 0.03);
            found++;
            here++;
        }
        lflare_destroy(flare);
    }
    assert_true(found >= 5);
}

/* What lamps leave of the first maximum: discs of half, one and two fringe lengths (P 9). */
static void lamps_wash_fringes_out(void **state)
{
    static const double expected[3] = {1.23, 1.09, 1.03};
    float table[LFLARE_RINGING_FLOATS];
    int i, w;
    (void)state;
    lflare_ringing_make(table);
    for (i = 0; i < 3; i++) {
        double blur = 0.5 * (1 << i), most = 0;
        lflare__profile p = lflare__profile_make(table, (float)(0.01 * sqrt(1.25) * blur), 0.01f); /* edges fade over sqrt(5/4) of a disc's radius: the same spread */
        for (w = 0; w < 1000; w++) most = fmax(most, (double)lflare__profile_at(&p, 1e-4f * (float)w));
        if (fabs(most - expected[i]) > 0.015) fail_msg("a disc of %g lengths leaves %g of %g", blur, most, expected[i]);
    }
}

/* Fringes move light, they make none: ghosts drawn with them hold what they hold without, whatever the iris. */
static void fringes_keep_the_light(void **state)
{
    enum { W = 480, H = 270 };
    static float pixels[2][4 * W * H];
    static const double fnumbers[2] = {5.6, 22};
    int blades, f;
    (void)state;
    for (blades = 0; blades < 7; blades += 6)
        for (f = 0; f < 2; f++) {
            int what, i, k;
            double sum[2][3] = {{0, 0, 0}, {0, 0, 0}}, apart = 0;
            for (what = 0; what < 2; what++) {
                lflare_settings settings;
                lflare_light light;
                lflare_view view;
                lflare_image image;
                lflare *flare;
                memset(&settings, 0, sizeof settings);
                settings.no_starburst = settings.raw = 1;
                settings.no_ringing = what == 0;
                settings.fnumber = fnumbers[f];
                settings.blades = blades;
                flare = open_lens("lenses/nikon-80-200-mid.lens", &settings);
                memset(&view, 0, sizeof view);
                view.width = W;
                view.height = H;
                view.fov_y = 0.5f; /* 72 mm high */
                view.fit = LFLARE_FIT_PHYSICAL;
                memset(&light, 0, sizeof light);
                light.direction[0] = 0.02f;
                light.direction[2] = -1;
                light.color[0] = light.color[1] = light.color[2] = 1;
                memset(&image, 0, sizeof image);
                image.pixels = pixels[what];
                image.width = W;
                image.height = H;
                memset(pixels[what], 0, sizeof pixels[what]);
                assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
                assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
                for (i = 0; i < W * H; i++)
                    for (k = 0; k < 3; k++) sum[what][k] += (double)pixels[what][4 * i + k];
                lflare_destroy(flare);
            }
            for (i = 0; i < W * H; i++) apart = fmax(apart, fabs((double)pixels[1][4 * i + 1] - (double)pixels[0][4 * i + 1]));
            assert_true(apart > 0); /* there are some */
            for (k = 0; k < 3; k++)
                if (fabs(sum[1][k] / sum[0][k] - 1) > 0.005) fail_msg("f/%g, %d blades: %g of the light in channel %d", fnumbers[f], blades, sum[1][k] / sum[0][k], k);
        }
}

/* How far what is drawn of an iris is from Fresnel's integral, rms over its inner part, with fringes and without. */
static void drawn_against_integral(const lflare_iris *iris, const float *ringing, double ring, double *fringed, double *plain)
{
    double *exact = fresnel(fresnel_amplitude, iris, ring), sum[2] = {0, 0};
    int n = 0, x, y, k;
    for (y = 0; y < 256; y++)
        for (x = 0; x < 256; x++) {
            double px = (x + 0.5) / 128 - 1, py = (y + 0.5) / 128 - 1;
            if (px * px + py * py > 0.72 || lflare_iris_transmission(iris, (float)px, (float)py, 1e-3f) < 0.01f) continue;
            for (k = 0; k < 2; k++) {
                lflare_footprint fp = fresnel_footprint(ringing, 0.004, k == 0 ? ring : 0);
                sum[k] += pow((double)lflare_footprint_coverage(&fp, 1, iris, (float)px, (float)py) - fresnel_at(exact, px, py), 2);
            }
            n++;
        }
    *fringed = sqrt(sum[0] / n);
    *plain = sqrt(sum[1] / n);
    free(exact);
}

/* Marks in masks, and masks that are the iris, against the integral; corners of blades too, and far below Fresnel numbers of 100. */
static void fringes_against_fresnel(void **state)
{
    static const struct {
        const char *what;
        double number, most;
    } cases[] = {{"five blades", 250, 0.03}, {"five blades", 20, 0.05}, {"eight blades", 10, 0.08}, {"a square", 200, 0.03}, {"a square", 50, 0.04}, {"dust", 600, 0.04}, {"dust", 130, 0.06}, {"dust", 30, 0.1}};
    static float ringing[LFLARE_RINGING_FLOATS], square[64 * 64];
    static uint8_t pictures[LFLARE_FRINGED_BYTES];
    size_t i;
    int k;
    (void)state;
    for (k = 0; k < 64 * 64; k++) square[k] = k % 64 >= 15 && k % 64 < 49 && k / 64 >= 15 && k / 64 < 49 ? 1.0f : 0.0f;
    lflare_ringing_make(ringing);
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        int blades = i < 2 ? 5 : i == 2 ? 8 : i < 5 ? 0 : 6;
        double fringed, plain;
        lflare_iris iris = iris_of(blades, 0);
        if (i > 2) {
            lflare_mask_desc desc;
            lflare_fringed_job job;
            void *work = malloc(LFLARE_FRINGED_WORK_BYTES);
            assert_non_null(work);
            memset(&desc, 0, sizeof desc);
            desc.pixels = i < 5 ? square : NULL;
            desc.width = desc.height = 64;
            desc.dust_count = i < 5 ? 0 : 30;
            desc.dust_size = 0.03f;
            desc.seed = 5;
            iris = masked(blades, &desc);
            assert_int_equal(iris.dark_outline, i < 5);
            assert_int_equal(lflare_fringed_begin(iris.mask, pictures, work, &job), LFLARE_OK);
            assert_int_equal(lflare_fringed_step(&job, 100), LFLARE_INCOMPLETE);
            assert_int_equal(lflare_fringed_step(&job, INT32_MAX), LFLARE_OK);
            iris.fringed = pictures;
            free(work);
        }
        drawn_against_integral(&iris, ringing, 1 / sqrt(2 * cases[i].number), &fringed, &plain);
        print_message("%s, Fresnel number %.0f: rms %.1f %%, without fringes %.1f %%\n", cases[i].what, cases[i].number, 100 * fringed, 100 * plain);
        assert_true(fringed < cases[i].most && fringed < 0.5 * plain);
    }
}

/* ---- the object ---- */

static int steps_of(lflare *flare, const lflare_settings *settings)
{
    int steps = 1;
    lflare_result result;
    assert_int_equal(lflare_configure_begin(flare, settings, NULL), LFLARE_OK);
    while ((result = lflare_configure_step(flare, 1)) == LFLARE_INCOMPLETE) steps++;
    assert_int_equal(result, LFLARE_OK);
    return steps;
}

static void made_once(void **state)
{
    lflare_settings settings, other;
    lflare *flare;
    const uint8_t *shown;
    int ghosts;
    (void)state;
    memset(&settings, 0, sizeof settings);
    settings.blades = 6;
    flare = open_with(&settings);
    ghosts = (int)lflare_get_lens(flare)->ghost_count;
    settings.fnumber = 11; /* another size of the same iris */
    assert_true(steps_of(flare, &settings) <= ghosts + 1);
    other = settings;
    other.blades = 7;
    assert_true(steps_of(flare, &other) > ghosts + 100);
    assert_true(steps_of(flare, &settings) <= ghosts + 1); /* the one before */
    assert_true(steps_of(flare, &other) <= ghosts + 1);
    other.mask.dust_count = 5;
    assert_true(steps_of(flare, &other) > ghosts + 200); /* rows of the mask, too */
    assert_true(lflare_get_tables(flare)->iris.mask != NULL);
    other.fnumber = 22;
    assert_true(steps_of(flare, &other) <= ghosts + LFLARE_MASK_SIZE / 4 + 1);
    shown = lflare_get_tables(flare)->iris.fringed;
    assert_non_null(shown);
    other.no_starburst = other.no_ringing = 1;
    steps_of(flare, &other);
    assert_null(lflare_get_tables(flare)->starburst);
    assert_null(lflare_get_tables(flare)->iris.fringed);
    other.no_ringing = 0;
    other.mask.dust_count = 6;
    assert_true(steps_of(flare, &other) > ghosts + 1000);
    other.mask.dust_count = 5; /* the one before */
    assert_true(steps_of(flare, &other) <= ghosts + LFLARE_MASK_SIZE / 4 + 1);
    assert_true(lflare_get_tables(flare)->iris.fringed == shown);
    lflare_destroy(flare);
}

typedef struct ledger {
    long calls, fail_at;
    size_t bytes;
} ledger;

static void *counted(void *user, void *block, size_t old_size, size_t new_size)
{
    ledger *l = (ledger *)user;
    void *fresh = NULL;
    if (new_size > 0) {
        if (++l->calls == l->fail_at) return NULL;
        fresh = realloc(block, new_size);
        l->bytes += new_size;
    } else {
        free(block);
    }
    if (block != NULL) l->bytes -= old_size;
    return fresh;
}

/* Every allocation fails in turn, while a mask and a starburst are made: nothing leaks, and the old ones are shown. */
static void allocations_fail(void **state)
{
    ledger l;
    lflare_desc desc;
    lflare_settings settings;
    lflare_error error;
    lflare *flare;
    char *text;
    const lflare_starburst *shown;
    uint64_t key;
    size_t bytes;
    long n;
    (void)state;
    memset(&l, 0, sizeof l);
    memset(&desc, 0, sizeof desc);
    assert_int_equal(lflare_file_read(HELIAR, NULL, NULL, &text, &desc.text_size, &error), LFLARE_OK);
    desc.text = text;
    desc.allocate = counted;
    desc.user = &l;
    desc.settings.starburst_size = 512;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_OK);
    free(text);
    shown = lflare_get_tables(flare)->starburst;
    key = shown->key;
    bytes = l.bytes;
    settings = desc.settings;
    settings.blades = 5;
    settings.mask.dust_count = 3;
    for (n = 1;; n++) {
        lflare_result result;
        l.calls = 0;
        l.fail_at = n;
        result = lflare_configure(flare, &settings, &error);
        if (result == LFLARE_OK) break;
        assert_int_equal(result, LFLARE_ERROR_MEMORY);
        assert_int_equal(error.code, LFLARE_ERROR_MEMORY);
        assert_true(lflare_get_tables(flare)->starburst == shown && shown->key == key);
        assert_true(l.bytes == bytes);
    }
    assert_true(n == 6); /* mask, its pictures with fringes, the starburst's tables, working memory of either */
    assert_true(lflare_get_tables(flare)->starburst->key != key);
    lflare_destroy(flare);
    assert_true(l.bytes == 0);
}

/* ---- masks ---- */

static void refused(lflare *flare, const lflare_settings *settings, const char *part)
{
    lflare_error error;
    assert_int_equal(lflare_configure(flare, settings, &error), LFLARE_ERROR_ARGUMENT);
    if (strstr(error.text, part) == NULL) fail_msg("'%s' does not say '%s'", error.text, part);
}

static void bad_masks(void **state)
{
    static float pixels[512];
    lflare_settings settings, good;
    lflare_result result;
    lflare *flare;
    int i;
    (void)state;
    memset(&good, 0, sizeof good);
    good.starburst_size = 512;
    flare = open_with(&good);
    for (i = 0; i < 512; i++) pixels[i] = 1;
    settings = good;
    settings.mask.pixels = pixels;
    refused(flare, &settings, "0 x 0");
    settings.mask.width = 5000;
    settings.mask.height = 1;
    refused(flare, &settings, "4096"); /* the limit is named */
    settings.mask.width = -1;
    refused(flare, &settings, "-1 x 1");
    settings.mask.width = 16;
    settings.mask.height = 16;
    pixels[37] = (float)NAN;
    refused(flare, &settings, "pixel 5, 2");
    pixels[37] = 1.5f;
    refused(flare, &settings, "pixel 5, 2");
    assert_int_equal(lflare_configure_begin(flare, &settings, NULL), LFLARE_OK); /* in steps, pixels are looked at when their turn comes */
    while ((result = lflare_configure_step(flare, 1)) == LFLARE_INCOMPLETE) {}
    assert_int_equal(result, LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_configure_step(flare, 1), LFLARE_OK); /* that is over */
    memset(pixels, 0, sizeof pixels);
    refused(flare, &settings, "black");
    pixels[0] = 1; /* only the corner, outside the circle */
    refused(flare, &settings, "nothing pass");
    settings = good;
    settings.mask.dust_count = LFLARE_MAX_MARKS + 1;
    refused(flare, &settings, "4096");
    settings = good;
    settings.mask.dust_count = -1;
    refused(flare, &settings, "dust");
    settings = good;
    settings.mask.grating_lines = 1000;
    refused(flare, &settings, "grating");
    settings = good;
    settings.starburst_size = 500;
    refused(flare, &settings, "512, 1024");
    settings = good;
    settings.starburst_scale = -1;
    refused(flare, &settings, "starburst_scale");
    settings = good;
    settings.streak.share = 2;
    refused(flare, &settings, "streak");
    settings = good;
    settings.iris_softness = (float)NAN;
    refused(flare, &settings, "softness");
    settings = good; /* one row of pixels is a slit */
    for (i = 0; i < 64; i++) pixels[i] = 1;
    settings.mask.pixels = pixels;
    settings.mask.width = 64;
    settings.mask.height = 1;
    assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
    assert_true(fabs((double)lflare_get_tables(flare)->iris.area - 2 * 2.0 / 64 / PI) < 0.002);
    settings.mask.width = 1;
    settings.mask.height = 64;
    assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
    lflare_destroy(flare);
    assert_int_equal(lflare_starburst_bytes(1000), 0);
    assert_int_equal(lflare_starburst_step(NULL, 1), LFLARE_ERROR_ARGUMENT);
}

/* A white mask changes nothing but roundings. */
static void white_mask(void **state)
{
    static float white[4] = {1, 1, 1, 1};
    lflare_mask_desc desc;
    lflare_iris plain = iris_of(6, 0), iris;
    made a, b;
    int i;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.pixels = white;
    desc.width = desc.height = 2;
    iris = masked(6, &desc);
    assert_true(fabsf(iris.area / plain.area - 1) < 1e-6f);
    a = make_starburst(&plain, 512);
    b = make_starburst(&iris, 512);
    assert_true(a.s.key != b.s.key);
    for (i = 0; i < (int)LFLARE_STARBURST_FLOATS; i++) assert_true(fabsf(a.tables[i] - b.tables[i]) <= 1e-4f * (1 + fabsf(a.tables[i])));
    free(a.tables);
    free(b.tables);
}

/* The same seed, the same marks; more specks leave the first where they were, and every speck takes light. */
static void marks(void **state)
{
    static uint8_t one[LFLARE_MASK_BYTES], two[LFLARE_MASK_BYTES];
    lflare_mask_desc desc;
    int i, same = 0, darker = 0, all = LFLARE_MASK_SIZE * LFLARE_MASK_SIZE;
    double sum[2] = {0, 0};
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.dust_count = 30;
    desc.dust_size = 0.02f;
    desc.scratch_count = 10;
    desc.seed = 7;
    lflare_mask_rows(&desc, one, 0, LFLARE_MASK_SIZE);
    for (i = LFLARE_MASK_SIZE; i > 0; i -= 8) lflare_mask_rows(&desc, two, i - 8, i); /* rows in any order */
    assert_memory_equal(one, two, (size_t)all);
    desc.dust_count = 60;
    lflare_mask_rows(&desc, two, 0, LFLARE_MASK_SIZE);
    for (i = 0; i < all; i++) {
        assert_true(two[i] <= one[i]);
        darker += two[i] < one[i];
    }
    assert_true(darker > 1000 && darker < all / 8);
    desc.seed = 8;
    lflare_mask_rows(&desc, one, 0, LFLARE_MASK_SIZE);
    for (i = 0; i < all; i++) same += one[i] == two[i] && one[i] < 128;
    assert_true(same < darker / 2);
    memset(&desc, 0, sizeof desc); /* a grating of depth d takes d / 2 */
    desc.grating_lines = 20;
    desc.grating_depth = 0.6f;
    lflare_mask_rows(&desc, one, 0, LFLARE_MASK_SIZE);
    for (i = 0; i < all; i++) sum[0] += one[i] / 255.0 / all;
    assert_true(fabs(sum[0] - 0.7) < 0.005);
}

/* Ghosts see the same iris: light and orientation. The upper half of the iris shut halves every ghost, and moves it as the matrices say. */
static void ghosts_see_the_mask(void **state)
{
    enum { W = 240, H = 240 };
    static float pixels[4 * W * H], mask[4];
    lflare_settings settings;
    lflare_override hidden[64];
    lflare_light light;
    lflare_view view;
    lflare_image image;
    int g, what, found = 0;
    lflare *flare;
    (void)state;
    mask[2] = mask[3] = 1; /* top row first: the lower half is open */
    memset(&settings, 0, sizeof settings);
    settings.no_starburst = settings.no_ringing = settings.raw = 1;
    settings.fnumber = 16;
    flare = open_with(&settings);
    memset(&view, 0, sizeof view);
    view.width = W;
    view.height = H;
    memset(&light, 0, sizeof light);
    light.direction[2] = -1;
    light.color[0] = light.color[1] = light.color[2] = 1;
    memset(&image, 0, sizeof image);
    image.pixels = pixels;
    image.width = W;
    image.height = H;
    for (g = 0; g < lflare_get_tables(flare)->ghost_count; g++) {
        const lflare_tables *t = lflare_get_tables(flare);
        double sum[2] = {0, 0}, at[2] = {0, 0}, scale = (double)(t->head[16 * g + 6] / t->head[16 * g + 4]) * (double)t->iris.radius / ((double)t->sensor_width / W);
        int i, n = 0;
        if (fabs(scale) < 8 || fabs(scale) > 100) continue; /* fits in the frame, on the axis: its iris does */
        memset(hidden, 0, sizeof hidden);
        for (i = 0; i < t->ghost_count; i++) {
            if (i == g) continue;
            hidden[n].first = t->pairs[i].first + 1;
            hidden[n].second = t->pairs[i].second + 1;
            hidden[n++].hide = 1;
        }
        for (what = 0; what < 2; what++) {
            settings.overrides = hidden;
            settings.override_count = n;
            settings.mask.pixels = what == 1 ? mask : NULL;
            settings.mask.width = settings.mask.height = 2;
            assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
            memset(pixels, 0, sizeof pixels);
            assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
            assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
            for (i = 0; i < W * H; i++) {
                sum[what] += (double)pixels[4 * i + 1];
                at[what] += (double)pixels[4 * i + 1] * (H / 2 - i / W - 0.5);
            }
        }
        if (!(sum[0] > 0)) continue;
        found++;
        /* the centroid of half a disc is 4/(3 pi) of its radius away, downwards on the iris; the picture is the sensor turned round */
        if (fabs(sum[1] / sum[0] - 0.5) > 0.01 || fabs(at[1] / sum[1] - 4 / (3 * PI) * scale) > 0.02 * fabs(scale))
            fail_msg("ghost %d: %g of the light, %g pixels up, expected %g", g, sum[1] / sum[0], at[1] / sum[1], 4 / (3 * PI) * scale);
    }
    assert_true(found >= 3);
    lflare_destroy(flare);
}

/* ---- on screen ---- */

/* The streak holds its share of the light through the pupil; starbursts are where the light is, and lights that fade dim them. */
static void streaks_and_lights(void **state)
{
    enum { W = 640, H = 360 };
    static float pixels[4 * W * H], faded[4 * W * H];
    lflare_settings settings;
    lflare_light light;
    lflare_view view;
    lflare_image image;
    lflare *flare;
    double sum = 0, most = 0;
    const lflare_tables *t;
    int i, at = 0;
    (void)state;
    memset(&settings, 0, sizeof settings);
    settings.no_starburst = settings.raw = 1;
    settings.fnumber = 8;
    settings.streak.share = 0.1f;
    settings.streak.length = 0.5f;
    settings.streak.tint[2] = 1;
    flare = open_with(&settings);
    memset(&view, 0, sizeof view);
    view.width = W;
    view.height = H;
    memset(&light, 0, sizeof light);
    light.direction[0] = 0.05f;
    light.direction[1] = 0.03f;
    light.direction[2] = -1;
    light.color[0] = light.color[1] = light.color[2] = 1;
    light.flags = LFLARE_LIGHT_NO_GHOSTS;
    memset(&image, 0, sizeof image);
    image.pixels = pixels;
    image.width = W;
    image.height = H;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    t = lflare_get_tables(flare);
    for (i = 0; i < W * H; i++) {
        assert_true(pixels[4 * i] == 0 && pixels[4 * i + 1] == 0);
        sum += (double)pixels[4 * i + 2] * pow((double)lflare_get_frame(flare)->pixel, 2);
    }
    {
        double pupil = PI / 4 * pow((double)t->efl / (double)t->fnumber, 2) * (double)t->transmission[2], cosine = 1 / sqrt(1 + 0.05 * 0.05 + 0.03 * 0.03);
        if (fabs(sum / (0.1 * pupil * cosine) - 1) > 0.01) fail_msg("the streak holds %g of what it should", sum / (0.1 * pupil * cosine));
    }
    settings.streak.share = 0;
    settings.no_starburst = 0;
    settings.blades = 6;
    assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
    memset(pixels, 0, sizeof pixels);
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (i = 0; i < W * H; i++)
        if ((double)pixels[4 * i] > most) most = (double)pixels[4 * i], at = i;
    {
        double pixel = (double)lflare_get_frame(flare)->pixel, x = W / 2.0 + 0.05 * (double)t->efl / pixel, y = H / 2.0 - 0.03 * (double)t->efl / pixel;
        assert_true(fabs(at % W + 0.5 - x) <= 1 && fabs(at / W + 0.5 - y) <= 1);
    }
    light.occlusion[0] = light.occlusion[1] = light.occlusion[2] = 0.75f; /* partly visible */
    image.pixels = faded;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (i = 0; i < W * H; i++) assert_true(fabsf(faded[4 * i + 1] - 0.25f * pixels[4 * i + 1]) <= 1e-4f * pixels[4 * i + 1]);
    light.flags |= LFLARE_LIGHT_NO_STARBURST;
    memset(pixels, 0, sizeof pixels);
    image.pixels = pixels;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (i = 0; i < 4 * W * H; i++) assert_true(pixels[i] == 0);
    lflare_destroy(flare);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_fftw),       cmocka_unit_test(half_plane_against_fftw), cmocka_unit_test(airy),
        cmocka_unit_test(square),             cmocka_unit_test(spikes),                  cmocka_unit_test(folded_and_blurred),
        cmocka_unit_test(flux_is_whole),      cmocka_unit_test(fnumbers),                cmocka_unit_test(made_once),
        cmocka_unit_test(fringes_against_collins), cmocka_unit_test(lamps_wash_fringes_out), cmocka_unit_test(fringes_against_fresnel),
        cmocka_unit_test(fringes_keep_the_light),
        cmocka_unit_test(allocations_fail),   cmocka_unit_test(bad_masks),               cmocka_unit_test(white_mask),
        cmocka_unit_test(marks),              cmocka_unit_test(ghosts_see_the_mask),     cmocka_unit_test(streaks_and_lights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
