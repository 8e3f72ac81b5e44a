/* The lenses in lenses/: each one is read, derived and rendered, and must show ghosts at three places of the light, in every model.
   Run from the repository root; with -v it says what it measured; `quick` leaves out the models with meshes,
   `all` tries these with lenses of more than 30 ghosts, too, which takes minutes. */

#define _POSIX_C_SOURCE 200809L
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

/* Focal lengths as stated by the patents or, for the production lenses, by their makers. Not here: canon-28-80, whose
   table is one unnamed position of the zoom. */
static const struct {
    const char *file;
    double efl;
} stated[] = {
    {"angenieux-double-gauss", 100}, {"apo-telyt-280", 279.25},     {"biogon-35-28", 35},         {"biotar-14", 100},
    {"canon-70-200-long", 194.01},   {"canon-70-200-mid", 135},     {"canon-70-200-short", 72.1}, {"cooke-triplet-27", 100},
    {"cooke-triplet-smith", 52},     {"dagor", 239.89},             {"distagon-25", 25},          {"fisheye-minolta-16", 16},
    {"fisheye-nikkor-16", 15.67},    {"flektagon-100-28", 100},     {"heliar-tronnier", 100},     {"kreitzer-tele", 400},
    {"nikkor-105-14", 102.15},       {"nikon-80-200-long", 200},    {"nikon-80-200-mid", 140},    {"nikon-80-200-short", 80},
    {"nikon-retrofocus-28", 100},    {"petzval-kodak", 100},        {"planar-50-14", 50},         {"sonnar-15", 92.6},
    {"sonnar-20", 100},              {"speed-panchro", 50},         {"takumar-14", 100},          {"tessar-100-28", 100},
    {"tessar-50-35", 50},            {"topogon", 66.5},             {"ultron-100-20", 100},
};

enum { WIDTH = 480, STATED = sizeof stated / sizeof stated[0] };

static glob_t files;
static int verbose, failures, most_ghosts = 30;

static void complain(const char *path, const char *format, ...)
{
    char text[256];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    print_error("%s: %s\n", path, text);
    failures++;
}

static int is_file_of(const char *path, const char *name)
{
    const char *base = strrchr(path, '/');
    size_t length = strlen(name);
    base = base != NULL ? base + 1 : path;
    return strncmp(base, name, length) == 0 && strcmp(base + length, ".lens") == 0;
}

/* The file's text; the caller frees it. */
static char *text_of(const char *path, size_t *size)
{
    lflare_error error;
    char *text = NULL;
    if (lflare_file_read(path, NULL, NULL, &text, size, &error) != LFLARE_OK) fail_msg("%s: %s", path, error.text);
    return text;
}

static void read_lens(const char *path, lflare_prescription *out)
{
    lflare_error error;
    size_t size = 0;
    char *text = text_of(path, &size);
    lflare_result result = lflare_text_read(text, size, out, &error);
    free(text);
    if (result != LFLARE_OK) fail_msg("%s:%d:%d: %s", path, (int)error.line, (int)error.column, error.text);
}

static void test_enough_of_them(void **state)
{
    size_t i, k;
    (void)state;
    failures = 0;
    assert_true(files.gl_pathc >= 30);
    for (k = 0; k < STATED; k++) {
        for (i = 0; i < files.gl_pathc && !is_file_of(files.gl_pathv[i], stated[k].file); i++) continue;
        if (i == files.gl_pathc) complain(stated[k].file, "has a stated focal length, but no file");
    }
    assert_int_equal(failures, 0);
}

static void test_optics(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    size_t i, k;
    int32_t n;
    (void)state;
    failures = 0;
    for (i = 0; i < files.gl_pathc; i++) {
        const char *path = files.gl_pathv[i];
        lflare_error error;
        read_lens(path, &p);
        if (p.name[0] == 0) complain(path, "has no name");
        if (p.patent[0] == 0 && p.source[0] == 0) complain(path, "has neither patent nor source");
        if (lflare_lens_derive(&p, &lens, &error) != LFLARE_OK) {
            complain(path, "line %d: %s", (int)error.line, error.text);
            continue;
        }
        for (n = 0; n < lens.note_count; n++) {
            const lflare_note *note = &lens.notes[n];
            char text[200];
            lflare_note_text(note, text, sizeof text);
            if (note->kind == LFLARE_NOTE_EDGES_CROSS || note->kind == LFLARE_NOTE_OUT_OF_FOCUS || note->kind == LFLARE_NOTE_SEMI_REDUCED)
                complain(path, "%s", text);
            else if (verbose)
                print_message("%s: %s\n", path, text);
        }
        for (k = 0; k < STATED; k++)
            if (is_file_of(path, stated[k].file) && !(fabs(lens.efl - stated[k].efl) <= 0.01 * stated[k].efl))
                complain(path, "focal length %g, stated %g", lens.efl, stated[k].efl);
        if (verbose) print_message("%s: focal length %.3f, f/%.3f, %d ghosts\n", path, lens.efl, lens.fnumber, (int)lens.ghost_count);
    }
    assert_int_equal(failures, 0);
}

static int same_number(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static int same_surface(const lflare_surface *a, const lflare_surface *b)
{
    int same = same_number(a->radius, b->radius) && same_number(a->thickness, b->thickness) && same_number(a->conic, b->conic) &&
               same_number(a->semi_diameter, b->semi_diameter) && same_number(a->quarter_nm, b->quarter_nm);
    int i;
    for (i = 0; i < 8; i++) same = same && same_number(a->aspheric[i], b->aspheric[i]);
    for (i = 0; i < 6; i++) same = same && same_number(a->medium.c[i], b->medium.c[i]);
    return same && a->medium.kind == b->medium.kind && strcmp(a->medium.glass, b->medium.glass) == 0 && a->coating == b->coating &&
           a->first_layer == b->first_layer && a->layer_count == b->layer_count && a->is_stop == b->is_stop;
}

static int same_prescription(const lflare_prescription *a, const lflare_prescription *b)
{
    int32_t i;
    int same = strcmp(a->name, b->name) == 0 && strcmp(a->patent, b->patent) == 0 && strcmp(a->source, b->source) == 0 &&
               same_number(a->fnumber, b->fnumber) && same_number(a->sensor_width, b->sensor_width) &&
               same_number(a->sensor_height, b->sensor_height) && a->focus == b->focus && a->surface_count == b->surface_count &&
               a->layer_count == b->layer_count;
    for (i = 0; same && i < a->surface_count; i++) same = same_surface(&a->surfaces[i], &b->surfaces[i]);
    for (i = 0; same && i < a->layer_count; i++)
        same = same_number(a->layers[i].n, b->layers[i].n) && same_number(a->layers[i].thickness_nm, b->layers[i].thickness_nm);
    return same;
}

static void test_round_trip(void **state)
{
    static lflare_prescription p, again;
    static char text[65536], second[65536];
    size_t i;
    (void)state;
    failures = 0;
    for (i = 0; i < files.gl_pathc; i++) {
        const char *path = files.gl_pathv[i];
        size_t size = sizeof text, second_size = sizeof second;
        lflare_error error;
        read_lens(path, &p);
        if (lflare_text_write(&p, text, &size) != LFLARE_OK) complain(path, "not written");
        else if (lflare_text_read(text, size, &again, &error) != LFLARE_OK) complain(path, "not read again: line %d: %s", (int)error.line, error.text);
        else if (!same_prescription(&p, &again)) complain(path, "changed by writing and reading");
        else if (lflare_text_write(&again, second, &second_size) != LFLARE_OK || size != second_size || memcmp(text, second, size) != 0)
            complain(path, "written differently the second time");
    }
    assert_int_equal(failures, 0);
}

typedef struct ghost_measure {
    float peak; /* over the frame, of the strongest channel */
    int pixels; /* of at least a tenth of it */
} ghost_measure;

static float strongest(const float *rgba)
{
    float m = rgba[0] > rgba[1] ? rgba[0] : rgba[1];
    return m > rgba[2] ? m : rgba[2];
}

static ghost_measure measure(const float *pixels, size_t count)
{
    ghost_measure m = {0, 0};
    size_t i;
    for (i = 0; i < count; i++)
        if (strongest(pixels + 4 * i) > m.peak) m.peak = strongest(pixels + 4 * i);
    for (i = 0; i < count && m.peak > 0; i++) m.pixels += strongest(pixels + 4 * i) >= 0.1f * m.peak;
    return m;
}

/* Renders each instance of the flare's frame alone into `one`, and all of them added up into `sum`. Returns how many ghosts
   have a peak within 1e-3 of the brightest and cover more than 0.05 % of the frame. */
static int count_ghosts(const lflare *flare, const lflare_image *one, float *sum)
{
    const lflare_frame_data *frame = lflare_get_frame(flare);
    const lflare_tables *tables = lflare_get_tables(flare);
    size_t i, count = (size_t)one->width * (size_t)one->height;
    ghost_measure *all = (ghost_measure *)calloc((size_t)frame->instance_count + 1, sizeof *all);
    float brightest = 0;
    int32_t k;
    int good = 0;
    assert_non_null(all);
    for (k = 0; k < frame->instance_count; k++) {
        lflare_footprint footprint;
        if (!lflare_footprint_resolve(tables, frame, frame->instances[k], &footprint)) continue;
        memset(one->pixels, 0, count * 4 * sizeof(float));
        assert_int_equal(lflare_software_rows(&footprint, 1, &tables->iris, frame, one, 0, one->height), LFLARE_OK);
        all[k] = measure(one->pixels, count);
        if (all[k].peak > brightest) brightest = all[k].peak;
        for (i = 0; i < 4 * count; i++) sum[i] += one->pixels[i];
    }
    for (k = 0; k < frame->instance_count; k++)
        good += all[k].peak > 0 && all[k].peak >= 1e-3f * brightest && (double)all[k].pixels > 0.0005 * (double)count;
    free(all);
    return good;
}

/* The whole flare at one place of the light: as many ghosts as asked for, and the sum of its ghosts. */
static void check_place(const char *path, lflare *flare, double ux, double uy, const char *place)
{
    const lflare_lens *lens = lflare_get_lens(flare);
    lflare_view view;
    lflare_light light;
    lflare_image one, whole;
    size_t i, count;
    float *sum, largest = 0, apart = 0;
    int good, finite = 1;
    memset(&view, 0, sizeof view);
    memset(&light, 0, sizeof light);
    memset(&one, 0, sizeof one);
    view.width = WIDTH;
    view.height = (int32_t)(WIDTH * lens->sensor_height / lens->sensor_width + 0.5);
    light.direction[0] = (float)ux;
    light.direction[1] = (float)uy;
    light.direction[2] = -1;
    light.color[0] = light.color[1] = light.color[2] = 1;
    one.width = view.width;
    one.height = view.height;
    whole = one;
    count = (size_t)view.width * (size_t)view.height;
    one.pixels = (float *)calloc(4 * count, sizeof(float));
    whole.pixels = (float *)calloc(4 * count, sizeof(float));
    sum = (float *)calloc(4 * count, sizeof(float));
    assert_true(one.pixels != NULL && whole.pixels != NULL && sum != NULL);
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &whole), LFLARE_OK);
    good = count_ghosts(flare, &one, sum);
    for (i = 0; i < 4 * count; i++) {
        float difference = fabsf(whole.pixels[i] - sum[i]);
        finite = finite && whole.pixels[i] >= 0 && whole.pixels[i] < 1e30f;
        if (sum[i] > largest) largest = sum[i];
        if (difference > apart) apart = difference;
    }
    if (verbose) print_message("%s: %s: %d of %d ghosts\n", path, place, good, (int)lflare_get_frame(flare)->instance_count);
    if (good < 3) complain(path, "%s: only %d ghosts worth seeing", place, good);
    if (!finite) complain(path, "%s: a pixel is negative or not finite", place);
    if (!(apart <= 1e-4f * largest)) complain(path, "%s: the flare is not the sum of its ghosts: %g of %g", place, (double)apart, (double)largest);
    free(one.pixels);
    free(whole.pixels);
    free(sum);
}

static void test_ghosts(void **state)
{
    size_t i;
    (void)state;
    failures = 0;
    for (i = 0; i < files.gl_pathc; i++) {
        const char *path = files.gl_pathv[i];
        const lflare_lens *lens;
        lflare_desc desc;
        lflare_error error;
        lflare *flare = NULL;
        double x, y;
        char *text;
        memset(&desc, 0, sizeof desc);
        text = text_of(path, &desc.text_size);
        desc.text = text;
        desc.settings.no_starburst = desc.settings.no_ringing = 1;
        if (lflare_create(&desc, &flare, &error) < 0) {
            complain(path, "line %d, column %d: %s", (int)error.line, (int)error.column, error.text);
        } else {
            lens = lflare_get_lens(flare);
            x = 0.5 * lens->sensor_width / lens->efl;
            y = 0.5 * lens->sensor_height / lens->efl;
            check_place(path, flare, 0.0874886635, 0, "5 degrees");
            check_place(path, flare, 0.5 * x, 0.5 * y, "half field");
            check_place(path, flare, x, y, "corner");
        }
        lflare_destroy(flare);
        free(text);
    }
    assert_int_equal(failures, 0);
}

/* Light on a small picture of a model, the light at some share of the half frame's diagonal. */
static void check_model(const char *path, lflare *flare, lflare_model model, double share)
{
    static float pixels[96 * 64 * 4];
    const lflare_lens *lens = lflare_get_lens(flare);
    lflare_view view;
    lflare_light light;
    lflare_image image;
    double sum = 0;
    size_t i;
    int finite = 1;
    memset(&view, 0, sizeof view);
    memset(&light, 0, sizeof light);
    memset(&image, 0, sizeof image);
    memset(pixels, 0, sizeof pixels);
    view.width = image.width = 96;
    view.height = image.height = 64;
    image.pixels = pixels;
    light.direction[0] = (float)(share * 0.5 * lens->sensor_width / lens->efl);
    light.direction[1] = (float)(share * 0.5 * lens->sensor_height / lens->efl);
    light.direction[2] = -1;
    light.color[0] = light.color[1] = light.color[2] = 1;
    light.angular_radius = 0.00465f;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (i = 0; i < sizeof pixels / sizeof pixels[0]; i++) {
        finite = finite && pixels[i] >= 0 && pixels[i] < 1e30f;
        if (i % 4 != 3) sum += (double)pixels[i] / (96 * 64 * 3);
    }
    if (verbose) print_message("%s: model %d, %g of the half diagonal: mean %.3g\n", path, (int)model, share, sum);
    if (!finite) complain(path, "model %d: a pixel is negative or not finite", (int)model);
    if (!(sum > 1e-4)) complain(path, "model %d is black at %g of the half diagonal: mean %g", (int)model, share, sum); /* white is 1 */
}

static void test_models(void **state)
{
    static const lflare_model models[3] = {LFLARE_MODEL_PARAXIAL, LFLARE_MODEL_POLYNOMIAL, LFLARE_MODEL_TRACED};
    static lflare_prescription p;
    static lflare_lens lens;
    size_t i, size;
    int m, a;
    (void)state;
    failures = 0;
    for (i = 0; i < files.gl_pathc; i++) {
        const char *path = files.gl_pathv[i];
        lflare_desc desc;
        lflare_error error;
        lflare *flare = NULL;
        void *fit = NULL;
        read_lens(path, &p);
        assert_int_equal(lflare_lens_derive(&p, &lens, &error), LFLARE_OK);
        if (lens.ghost_count > most_ghosts) continue;
        if (lflare_aberration_fit(&lens, NULL, &fit, &size, &error) != LFLARE_OK) fail_msg("%s: %s", path, error.text);
        memset(&desc, 0, sizeof desc);
        desc.prescription = &p;
        desc.fit = fit;
        desc.fit_size = size;
        desc.settings.no_starburst = desc.settings.no_ringing = 1;
        if (lflare_create(&desc, &flare, &error) < 0) fail_msg("%s: %s", path, error.text);
        for (m = 0; m < 3; m++) {
            lflare_settings s = desc.settings;
            s.model = models[m];
            assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
            for (a = 0; a < 3; a++) check_model(path, flare, models[m], 0.25 + 0.3 * a);
        }
        lflare_destroy(flare);
        free(fit);
    }
    assert_int_equal(failures, 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest meshes[] = {cmocka_unit_test(test_models)};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_enough_of_them),
        cmocka_unit_test(test_optics),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_ghosts),
    };
    int result;
    verbose = argc > 1 && strcmp(argv[1], "-v") == 0;
    if (argc > 1 && strcmp(argv[argc - 1], "all") == 0) most_ghosts = INT32_MAX;
    if (glob("lenses/*.lens", 0, NULL, &files) != 0) files.gl_pathc = 0;
    result = cmocka_run_group_tests(tests, NULL, NULL);
    if (!(argc > 1 && strcmp(argv[1], "quick") == 0)) result += cmocka_run_group_tests(meshes, NULL, NULL);
    globfree(&files);
    return result;
}
