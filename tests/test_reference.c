/* The reference picture (examples/reference.h) against golden pictures made independently, its energy against rays of the tests' own
   physics, and itself with a finer mesh. The golden pictures are here in eighths of their size, pixels
   averaged; where the project's originals are at hand (../shared), the whole pictures are compared too. */
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

static lflare_lens lens;
static lflare_iris iris;
static reference_desc desc;

/* ---- pictures ---- */

typedef struct picture {
    int width, height;
    float *rgb;
} picture;

static picture picture_make(int width, int height)
{
    picture p;
    p.width = width;
    p.height = height;
    p.rgb = (float *)calloc((size_t)width * (size_t)height, 3 * sizeof(float));
    assert_non_null(p.rgb);
    return p;
}

/* A PFM written by a machine like this one; 0 if there is none. */
static int picture_read(const char *path, picture *p)
{
    static const uint16_t one = 1;
    FILE *f = fopen(path, "rb");
    double scale = 0;
    int y, ok;
    p->width = p->height = 0;
    if (f == NULL) return 0;
    ok = fscanf(f, "PF %d %d %lf", &p->width, &p->height, &scale) == 3 && fgetc(f) != EOF;
    ok = ok && p->width > 0 && p->height > 0 && p->width < 4096 && p->height < 4096 && (scale < 0) == (*(const uint8_t *)&one == 1);
    if (ok) *p = picture_make(p->width, p->height);
    for (y = p->height - 1; ok && y >= 0; y--) {
        size_t width = (size_t)p->width;
        ok = fread(p->rgb + 3 * width * (size_t)y, sizeof(float) * 3, width, f) == width;
    }
    fclose(f);
    return ok;
}

static float top(const float *rgb) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double toned(float v, float white) { return pow(fmin(fmax((double)(v / white), 0), 1), 1 / 2.2); }

/* PSNR as `flare compare` measures it: white is the 99.8th percentile of what a lights, gamma 2.2, over what either lights. */
static double likeness(const picture *a, const picture *b)
{
    size_t count = (size_t)a->width * (size_t)a->height, i, n = 0;
    float *lit = (float *)malloc(count * sizeof *lit), white;
    double sum = 0, seen = 0;
    int k;
    assert_true(a->width == b->width && a->height == b->height && lit != NULL);
    for (i = 0; i < count; i++)
        if (top(a->rgb + 3 * i) > 0) lit[n++] = top(a->rgb + 3 * i);
    assert_true(n > 0);
    qsort(lit, n, sizeof *lit, by_value);
    white = lit[(size_t)((double)(n - 1) * 0.998)];
    for (i = 0; i < count; i++) {
        if (fmaxf(top(a->rgb + 3 * i), top(b->rgb + 3 * i)) <= 1e-4f * white) continue;
        seen++;
        for (k = 0; k < 3; k++) sum += pow(toned(a->rgb[3 * i + (size_t)k], white) - toned(b->rgb[3 * i + (size_t)k], white), 2);
    }
    free(lit);
    return sum > 0 ? -10 * log10(sum / (3 * seen)) : 999;
}

/* ---- scenes ---- */

typedef struct scene {
    const char *file, *golden, *whole;
    double ax, ay;
} scene;

static const scene scenes[2] = {
    {"tests/data/heliar-picture.lens", "tests/data/heliar-picture.pfm", "../shared/golden/pictures/heliar-f8-10-5.pfm", 10, 5},
    {"tests/data/nikon-picture.lens", "tests/data/nikon-picture.pfm", "../shared/golden/pictures/nikon-f8-5.45-0.pfm", 5.45, 0},
};

/* f/8, a round iris, a frame of 36 x 20.25 mm, the library's three wavelengths. */
static void open_scene(const scene *s, int width, int cells)
{
    static const double nm[3] = {650, 510, 475};
    int k;
    assert_true(oracle_lens_load(s->file, &lens));
    assert_int_equal(lflare_iris_make(&lens, 8, 0, 0, 0, &iris, NULL), LFLARE_OK);
    memset(&desc, 0, sizeof desc);
    desc.lens = &lens;
    desc.iris = &iris;
    desc.slope[0] = -tan(s->ax * DEGREE);
    desc.slope[1] = -tan(s->ay * DEGREE);
    desc.half[0] = 18;
    desc.half[1] = 10.125;
    desc.width = width;
    desc.height = width * 9 / 16;
    desc.wavelengths = 3;
    for (k = 0; k < 3; k++) desc.nm[k] = nm[k], desc.rgb[k][k] = 1;
    desc.cells = cells;
}

static picture render(void)
{
    picture p = picture_make(desc.width, desc.height);
    assert_int_equal(reference_render(&desc, p.rgb), 1);
    return p;
}

/* ---- tests ---- */

/* A pixel holds the mean over its area, so a small picture is the large one's average. */
static void golden_pictures_small(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < 2; i++) {
        picture golden, p;
        double db;
        assert_true(picture_read(scenes[i].golden, &golden));
        open_scene(&scenes[i], 80, 24);
        p = render();
        db = likeness(&golden, &p);
        print_message("%s at 80 x 45: %.1f dB\n", scenes[i].golden, db);
        assert_true(db >= 55);
        free(golden.rgb);
        free(p.rgb);
    }
}

static void golden_pictures_whole(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < 2; i++) {
        picture golden, p;
        double db;
        if (!picture_read(scenes[i].whole, &golden)) {
            print_message("%s is not here\n", scenes[i].whole);
            skip();
        }
        open_scene(&scenes[i], 640, 20);
        p = render();
        db = likeness(&golden, &p);
        print_message("%s at 640 x 360: %.1f dB\n", scenes[i].whole, db);
        assert_true(db >= 50);
        free(golden.rgb);
        free(p.rgb);
    }
}

/* Meshes 1.6 times finer hardly change the picture. */
static void meshes_agree(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < 2; i++) {
        picture coarse, fine;
        double db;
        open_scene(&scenes[i], 320, 20);
        desc.wavelengths = 1;
        coarse = render();
        desc.cells = 32;
        fine = render();
        db = likeness(&fine, &coarse);
        print_message("%s at 320 x 180: meshes of 20 and 32 cells agree to %.1f dB\n", scenes[i].file, db);
        assert_true(db > 52);
        free(coarse.rgb);
        free(fine.rgb);
    }
}

/* A ghost for the oracle. */
typedef struct rays {
    oracle_lens o;
    oracle_step steps[ORACLE_STEPS];
    int count;
    long double slope[2];
} rays;

/* W of a ray that passes every rim and lands in the frame, else 0. */
static double oracle_power(const rays *r, double x, double y)
{
    static oracle_ray ray;
    static lflare_layer layers[LFLARE_MAX_LAYERS], turned[LFLARE_MAX_LAYERS];
    long double at[2] = {(long double)x, (long double)y};
    double weight = 1;
    int k, l;
    if (!oracle_trace(&r->o, r->steps, r->count, at, r->slope, &ray)) return 0;
    if (fabs((double)ray.sensor[0]) > desc.half[0] || fabs((double)ray.sensor[1]) > desc.half[1]) return 0;
    for (k = 0; k < r->count; k++) {
        int s = r->steps[k].surface;
        if ((double)ray.height[k] > (s == r->o.stop ? (double)iris.radius : r->o.p->surfaces[s].semi_diameter)) return 0;
    }
    for (k = 0; k < r->count; k++) {
        int s = r->steps[k].surface, back = r->steps[k].backwards, used = oracle_layers(r->o.p, s, layers);
        double n1 = (double)r->o.n[s + back], n2 = (double)r->o.n[s + 1 - back], film;
        if (s == r->o.stop || (n1 == n2 && used == 0)) continue;
        for (l = 0; l < used; l++) turned[l] = layers[back ? used - 1 - l : l];
        film = oracle_film(n1, n2, turned, used, r->o.nm, n1 * sqrt(fmax(0, 1 - (double)(ray.cosine[k] * ray.cosine[k]))));
        weight *= r->steps[k].reflects ? film : 1 - film;
    }
    return weight;
}

/* Mean power over a box, by a jittered grid; the box that the passing rays fill comes back in `lit`. */
static double oracle_mean(const rays *r, const double *box, int side, double *lit)
{
    oracle_random random = {11};
    double sum = 0, dx = (box[1] - box[0]) / side, dy = (box[3] - box[2]) / side;
    int i;
    lit[0] = lit[2] = 1e9;
    lit[1] = lit[3] = -1e9;
    for (i = 0; i < side * side; i++) {
        double x = box[0] + (i % side + oracle_unit(&random)) * dx, y = box[2] + (i / side + oracle_unit(&random)) * dy, power = oracle_power(r, x, y);
        sum += power;
        if (power == 0) continue;
        lit[0] = fmin(lit[0], x - 2 * dx), lit[1] = fmax(lit[1], x + 2 * dx);
        lit[2] = fmin(lit[2], y - 2 * dy), lit[3] = fmax(lit[3], y + 2 * dy);
    }
    return sum / (side * side);
}

/* The share of E that a ghost brings into the frame, mm^2: rays over the front element, then over where they pass. */
static double oracle_flux(const scene *s, lflare_pair pair, double nm)
{
    static rays r;
    double reach = 1.1 * lens.prescription.surfaces[0].semi_diameter, box[4] = {-reach, reach, -reach, reach}, lit[4], rest[4], mean;
    r.slope[0] = -tanl((long double)(s->ax * DEGREE));
    r.slope[1] = -tanl((long double)(s->ay * DEGREE));
    oracle_lens_make(&r.o, &lens.prescription, nm);
    r.count = oracle_path(&r.o, pair.first, pair.second, r.steps);
    oracle_mean(&r, box, 120, lit);
    mean = oracle_mean(&r, lit, 250, rest);
    return mean * (lit[1] - lit[0]) * (lit[3] - lit[2]) / sqrt((double)(1 + r.slope[0] * r.slope[0] + r.slope[1] * r.slope[1]));
}

/* Ghosts over the whole frame and a pixel in size, cut by rims, folded, partly outside; bare glass and films. */
static void energy_is_kept(void **state)
{
    static const struct {
        int lens, first, second;
    } cases[] = {{0, 9, 7}, {0, 8, 7}, {0, 3, 2}, {1, 11, 8}, {1, 13, 3}, {1, 8, 4}, {1, 22, 21}, {2, 3, 1}, {2, 6, 2}, {2, 10, 9}, {2, 14, 12}};
    static const scene coated = {"lenses/planar-50-14.lens", NULL, NULL, 9, 4};
    size_t i, j;
    (void)state;
    for (i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const scene *s = cases[i].lens < 2 ? &scenes[cases[i].lens] : &coated;
        lflare_pair pair = {0, 0, 0, 0};
        picture p;
        double sum = 0, flux;
        pair.first = cases[i].first - 1;
        pair.second = cases[i].second - 1;
        open_scene(s, 160, 48);
        desc.only = &pair;
        desc.wavelengths = 1;
        p = render();
        for (j = 0; j < 160 * 90; j++) sum += (double)p.rgb[3 * j];
        sum *= 4 * desc.half[0] * desc.half[1] / (160 * 90);
        flux = oracle_flux(s, pair, desc.nm[0]);
        print_message("%s %d,%d: %.5g mm^2 by the picture, %.5g by rays, %+.2f %%\n", s->file, cases[i].first, cases[i].second, sum, flux,
                      100 * (sum / flux - 1));
        assert_true(flux > 0 && fabs(sum / flux - 1) < 0.005);
        free(p.rgb);
    }
}

/* The same to the bit with any number of threads. */
static void threads_make_no_difference(void **state)
{
    static const int threads[] = {1, 2, 5, 64};
    picture first = {0, 0, NULL};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof threads / sizeof threads[0]; i++) {
        picture p;
        open_scene(&scenes[0], 96, 12);
        desc.threads = threads[i];
        p = render();
        if (i == 0) first = p;
        else assert_memory_equal(first.rgb, p.rgb, 96 * 54 * 3 * sizeof(float));
        if (i > 0) free(p.rgb);
    }
    free(first.rgb);
}

/* Frames far off, tiny or huge, grazing light: no undefined arithmetic, finite pixels. */
static void odd_frames(void **state)
{
    static const double halves[] = {1e-9, 1e-3, 1, 1e4, 1e12}, centres[] = {0, 17, -1e7}, slopes[] = {0, 0.3, 20};
    size_t h, c, s, i;
    (void)state;
    for (h = 0; h < 5; h++)
        for (c = 0; c < 3; c++)
            for (s = 0; s < 3; s++) {
                picture p;
                open_scene(&scenes[0], 16, 5);
                desc.half[0] = desc.half[1] = halves[h];
                desc.centre[0] = centres[c];
                desc.slope[0] = slopes[s];
                p = render();
                for (i = 0; i < 16 * 9 * 3; i++) assert_true(p.rgb[i] >= 0 && p.rgb[i] - p.rgb[i] == 0);
                free(p.rgb);
            }
}

static volatile sig_atomic_t stop_now;
static int calls;
static void stop_soon(void *user, double done)
{
    (void)user;
    assert_true(done > 0 && done <= 1);
    calls++;
    stop_now = 1;
}

static void stops_when_told(void **state)
{
    float rgb[16 * 9 * 3];
    (void)state;
    open_scene(&scenes[1], 16, 8);
    desc.stop = &stop_now;
    desc.progress = stop_soon;
    assert_int_equal(reference_render(&desc, rgb), 0);
    assert_int_equal(calls, 1);
    desc.stop = NULL;
    desc.cells = 0;
    assert_int_equal(reference_render(&desc, rgb), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(golden_pictures_small), cmocka_unit_test(golden_pictures_whole), cmocka_unit_test(meshes_agree),
        cmocka_unit_test(energy_is_kept),        cmocka_unit_test(threads_make_no_difference), cmocka_unit_test(odd_frames),
        cmocka_unit_test(stops_when_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
