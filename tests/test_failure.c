/* What goes wrong from outside: allocations that fail, arguments that are missing, files that cannot be read; and the
   promises that hold then: nothing leaks, nothing changes, nothing is allocated where none is promised.
   Run from the root of the repository. */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- memory that counts, and fails when told ---- */

typedef struct ledger {
    size_t bytes, largest;   /* in use; the largest block asked for */
    long calls, blocks;      /* calls that allocate or grow; blocks in use */
    long fail_at;            /* the call that fails, from 1; 0 = none */
    size_t refuse;           /* sizes from here on fail; 0 = none */
    int wrong_sizes;         /* old sizes that were not right */
} ledger;

enum { HEAD = 16 };

static void *ledger_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    ledger *l = (ledger *)user;
    char *base = block != NULL ? (char *)block - HEAD : NULL;
    size_t known = 0;
    if (base != NULL) memcpy(&known, base, sizeof known);
    l->wrong_sizes += known != old_size;
    if (new_size == 0) {
        l->wrong_sizes += block == NULL; /* nothing to free */
        l->bytes -= known;
        l->blocks -= block != NULL;
        free(base);
        return NULL;
    }
    l->calls++;
    if (new_size > l->largest) l->largest = new_size;
    if (l->calls == l->fail_at || (l->refuse > 0 && new_size >= l->refuse)) return NULL;
    base = (char *)realloc(base, HEAD + new_size);
    if (base == NULL) return NULL;
    if (known < new_size) memset(base + HEAD + known, 0xa5, new_size - known); /* nobody may count on zeroes */
    memcpy(base, &new_size, sizeof new_size);
    l->bytes += new_size - known;
    l->blocks += block == NULL;
    return base + HEAD;
}

static void expect_settled(const ledger *l)
{
    assert_int_equal(l->wrong_sizes, 0);
    assert_int_equal(l->blocks, 0);
    assert_true(l->bytes == 0);
}

static const char heliar[] = "lensflare 1\nname Heliar\nfnumber 3.5\nsensor 36 24\n"
                             "30.81 7.7 n 1.652 semi 14.5 coating quarter 550\n-89.35 1.85 n 1.603 semi 14.5\n580.38 3.52 air semi 14.5\n"
                             "-80.63 1.85 n 1.643 semi 12.3\n28.34 4.18 air semi 12\nstop 3 semi 11.6\nflat 1.85 n 1.581 semi 12.3\n"
                             "32.19 7.27 n 1.694 semi 12.3\n-52.99 81.857 air semi 12.3\n";

enum { W = 64, H = 48 };

static const lflare_light sun = {{0.17f, 0.09f, -1}, {1, 0.9f, 0.8f}, {0, 0, 0}, 0.00465f, 0, 0};

static lflare_view a_view(void)
{
    lflare_view v;
    memset(&v, 0, sizeof v);
    v.width = W;
    v.height = H;
    return v;
}

static lflare_image an_image(float *pixels)
{
    lflare_image image;
    memset(&image, 0, sizeof image);
    image.pixels = pixels;
    image.width = W;
    image.height = H;
    return image;
}

static lflare_desc a_desc(ledger *l)
{
    lflare_desc d;
    memset(&d, 0, sizeof d);
    memset(l, 0, sizeof *l);
    d.text = heliar;
    d.text_size = sizeof heliar - 1;
    d.allocate = ledger_realloc;
    d.user = l;
    return d;
}

static lflare *create(const lflare_desc *d)
{
    lflare *flare = NULL;
    lflare_error error;
    if (lflare_create(d, &flare, &error) != LFLARE_OK) fail_msg("%d:%d %s", (int)error.line, (int)error.column, error.text);
    assert_non_null(flare);
    return flare;
}

/* A picture of the sun with the object as it is. */
static void draw(lflare *flare, float *pixels)
{
    lflare_view view = a_view();
    lflare_image image = an_image(pixels);
    double sum = 0;
    int32_t i;
    memset(pixels, 0, sizeof(float) * 4 * W * H);
    assert_int_equal(lflare_frame(flare, &view, &sun, 1), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    for (i = 0; i < 4 * W * H; i++) {
        assert_true(pixels[i] >= 0 && pixels[i] < 1e30f);
        sum += (double)pixels[i];
    }
    assert_true(sum > 0);
}

static lflare_override overrides[2];

static lflare_settings some_settings(void)
{
    lflare_settings s;
    memset(&s, 0, sizeof s);
    memset(overrides, 0, sizeof overrides);
    overrides[0].first = 9;
    overrides[0].second = 7;
    overrides[0].ev = 3;
    overrides[0].scale = 2;
    overrides[1].first = 3;
    overrides[1].second = 1;
    overrides[1].hide = 1;
    s.fnumber = 8;
    s.blades = 6;
    s.blade_rotation = 0.3f;
    s.overrides = overrides;
    s.override_count = 2;
    return s;
}

/* ---- allocations ---- */

static void test_create_fails(void **state)
{
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare *flare;
    lflare_error error;
    long n;
    int with_overrides;
    (void)state;
    for (with_overrides = 0; with_overrides < 2; with_overrides++) {
        desc = a_desc(&l);
        if (with_overrides) desc.settings = some_settings();
        for (n = 1;; n++) {
            lflare_result result;
            memset(&l, 0, sizeof l);
            l.fail_at = n;
            flare = (lflare *)&l;
            result = lflare_create(&desc, &flare, &error);
            assert_int_equal(result, error.code);
            if (result == LFLARE_OK) break;
            assert_int_equal(result, LFLARE_ERROR_MEMORY);
            assert_null(flare);
            assert_true(error.line == 0 && error.column == 0 && strlen(error.text) > 5);
            expect_settled(&l);
            flare = (lflare *)&l;
            l.calls = 0;
            assert_int_equal(lflare_create(&desc, &flare, NULL), LFLARE_ERROR_MEMORY);
            expect_settled(&l);
        }
        assert_true(n > 4 + with_overrides && l.calls == n - 1);
        lflare_destroy(flare);
        expect_settled(&l);
    }
}

static void test_create_refused(void **state)
{
    static const char *const bad[] = {"", "lensflare 2", "lensflare 1\nfnumber 4\n50 3 n 1.5\n-50 48\n"};
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare *flare;
    size_t i;
    (void)state;
    for (i = 0; i < 3; i++) {
        desc.text = bad[i];
        desc.text_size = strlen(bad[i]);
        flare = (lflare *)&l;
        assert_int_equal(lflare_create(&desc, &flare, NULL), i < 2 ? LFLARE_ERROR_SYNTAX : LFLARE_ERROR_LENS);
        assert_null(flare);
        expect_settled(&l);
    }
    desc = a_desc(&l);
    desc.settings.blades = 2;
    flare = (lflare *)&l;
    assert_int_equal(lflare_create(&desc, &flare, NULL), LFLARE_ERROR_ARGUMENT);
    assert_null(flare);
    expect_settled(&l);
    desc = a_desc(&l);
    desc.max_lights = -1;
    assert_int_equal(lflare_create(&desc, &flare, NULL), LFLARE_ERROR_ARGUMENT);
    desc.max_lights = 65536;
    assert_int_equal(lflare_create(&desc, &flare, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(l.calls, 0);
}

static void test_configure_fails(void **state)
{
    static float before[4 * W * H], after[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare_settings settings = some_settings();
    lflare *flare = create(&desc);
    lflare_error error;
    long n;
    size_t bytes;
    (void)state;
    draw(flare, before);
    bytes = l.bytes;
    for (n = 1;; n++) {
        lflare_result result;
        l.calls = 0;
        l.fail_at = n;
        result = lflare_configure(flare, &settings, &error);
        assert_int_equal(result, error.code);
        l.fail_at = 0;
        if (result == LFLARE_OK) break;
        assert_int_equal(result, LFLARE_ERROR_MEMORY);
        assert_true(l.bytes == bytes);
        draw(flare, after);
        assert_memory_equal(before, after, sizeof before);
    }
    assert_true(n > 1);
    draw(flare, after);
    assert_true(memcmp(before, after, sizeof before) != 0);
    /* settings that are refused change nothing either */
    memcpy(before, after, sizeof before);
    settings.override_count = 0;
    settings.blades = 17;
    assert_int_equal(lflare_configure(flare, &settings, &error), LFLARE_ERROR_ARGUMENT);
    draw(flare, after);
    assert_memory_equal(before, after, sizeof before);
    settings = some_settings();
    overrides[1].first = 2; /* the first surface behind reflects nothing onto itself */
    overrides[1].second = 2;
    assert_int_equal(lflare_configure(flare, &settings, &error), LFLARE_ERROR_ARGUMENT);
    assert_string_equal(error.text, "override 1: the lens has no ghost (2,2)");
    draw(flare, after);
    assert_memory_equal(before, after, sizeof before);
    lflare_destroy(flare);
    expect_settled(&l);
}

/* While new settings are built in steps, other new settings fail: the first go on as if nothing had been. */
static void test_configure_fails_between_steps(void **state)
{
    static float expected[4 * W * H], got[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare_settings first, second = some_settings();
    lflare *flare = create(&desc);
    int what;
    (void)state;
    memset(&first, 0, sizeof first);
    first.fnumber = 5.6;
    assert_int_equal(lflare_configure(flare, &first, NULL), LFLARE_OK);
    draw(flare, expected);
    for (what = 0; what < 2; what++) {
        memset(&first, 0, sizeof first);
        assert_int_equal(lflare_configure(flare, &first, NULL), LFLARE_OK);
        first.fnumber = 5.6;
        assert_int_equal(lflare_configure_begin(flare, &first, NULL), LFLARE_OK);
        assert_int_equal(lflare_configure_step(flare, 3), LFLARE_INCOMPLETE);
        if (what == 0) second.blades = 1;
        else second.blades = 6;
        l.fail_at = what == 0 ? 0 : l.calls + 1;
        assert_int_equal(lflare_configure_begin(flare, &second, NULL), what == 0 ? LFLARE_ERROR_ARGUMENT : LFLARE_ERROR_MEMORY);
        l.fail_at = 0;
        while (lflare_configure_step(flare, 2) == LFLARE_INCOMPLETE) {}
        draw(flare, got);
        assert_memory_equal(expected, got, sizeof got);
    }
    lflare_destroy(flare);
    expect_settled(&l);
}

static void test_render_fails(void **state)
{
    static float pixels[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare *flare = create(&desc);
    lflare_view view = a_view();
    lflare_image image = an_image(pixels);
    long calls = l.calls, n;
    int32_t i;
    (void)state;
    assert_int_equal(lflare_frame(flare, &view, &sun, 1), LFLARE_OK);
    assert_int_equal(l.calls, calls); /* a frame allocates nothing, not even the first */
    for (n = 1; n < 20; n++) {
        lflare_result result;
        l.fail_at = l.calls + n;
        calls = l.calls;
        result = lflare_render(flare, &image);
        if (result == LFLARE_OK) break;
        assert_int_equal(result, LFLARE_ERROR_MEMORY);
        for (i = 0; i < 4 * W * H; i++) assert_true(pixels[i] == 0);
    }
    assert_true(n > 1 && n < 20);
    l.fail_at = 0;
    calls = l.calls;
    for (i = 0; i < 5; i++) { /* nor do later ones, nor renders after the first */
        draw(flare, pixels);
        assert_int_equal(l.calls, calls);
    }
    lflare_destroy(flare);
    expect_settled(&l);
}

static void test_never_allocates(void **state)
{
    static float pixels[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare_settings settings = some_settings();
    lflare_view view = a_view();
    lflare_light lights[16];
    lflare *flare = create(&desc);
    int32_t i;
    long calls;
    (void)state;
    for (i = 0; i < 16; i++) {
        lights[i] = sun;
        lights[i].direction[0] = 0.05f * (float)(i - 8);
    }
    draw(flare, pixels);
    calls = l.calls;
    for (i = 0; i <= 16; i++) {
        assert_int_equal(lflare_frame(flare, &view, lights, i), LFLARE_OK);
        assert_int_equal(lflare_render_begin(flare), LFLARE_OK);
    }
    settings.overrides = NULL;
    settings.override_count = 0;
    settings.blades = 0; /* as before: the same starburst */
    assert_int_equal(lflare_configure(flare, &settings, NULL), LFLARE_OK);
    draw(flare, pixels);
    assert_int_equal(l.calls, calls); /* settings without overrides need no memory either */
    lflare_destroy(flare);
    expect_settled(&l);
}

/* On 32 bits the room for footprints must not wrap round. */
static void test_sizes_do_not_wrap(void **state)
{
    static char text[LFLARE_MAX_SURFACES * 40];
    static lflare_prescription p;
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare_view view = a_view();
    lflare *flare;
    int32_t i, n;
    double need;
    lflare_result result;
    (void)state;
    n = sprintf(text, "lensflare 1\nfnumber 16\nstop 1\n50 3 n 1.5\n-50 1\n");
    for (i = 0; i < 62; i++) n += sprintf(text + n, "flat 0.1 n 1.5\nflat 0.1\n");
    assert_int_equal(lflare_text_read(text, (size_t)n, &p, NULL), LFLARE_OK);
    desc.prescription = &p;
    desc.max_lights = 2400;
    l.refuse = (size_t)200 << 20;
    flare = create(&desc);
    l.largest = 0;
    assert_int_equal(lflare_frame(flare, &view, &sun, 1), LFLARE_OK);
    need = (double)lflare_get_frame(flare)->instance_capacity * (double)sizeof(lflare_footprint);
    assert_true(need > 4294967296.0);
    result = lflare_render_begin(flare);
    if ((double)l.largest < need) assert_int_equal(result, LFLARE_ERROR_MEMORY); /* on 64 bits it is our ledger that refuses */
    assert_int_equal(result, LFLARE_ERROR_MEMORY);
    lflare_destroy(flare);
    expect_settled(&l);
}

/* ---- steps ---- */

static void expect_same_tables(const lflare_tables *a, const lflare_tables *b)
{
    size_t g = (size_t)a->ghost_count;
    assert_int_equal(a->ghost_count, b->ghost_count);
    assert_int_equal(a->active_count, b->active_count);
    assert_memory_equal(a->field, b->field, g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS * sizeof(float));
    assert_memory_equal(a->style, b->style, g * LFLARE_STYLE_FLOATS * sizeof(float));
    assert_memory_equal(a->rank, b->rank, g * 2 * sizeof(float));
    assert_memory_equal(a->cull, b->cull, (size_t)a->active_count * sizeof(lflare_cull));
    assert_memory_equal(a->head, b->head, g * LFLARE_HEAD_FLOATS * sizeof(float));
    assert_memory_equal(&a->iris, &b->iris, sizeof a->iris);
    assert_true(a->exposure == b->exposure && a->fnumber == b->fnumber && a->ghost_budget == b->ghost_budget);
}

static void test_steps_equal_whole(void **state)
{
    static float old_picture[4 * W * H], new_picture[4 * W * H], during[4 * W * H];
    static const int32_t sizes[] = {1, 2, 7, 100000, INT32_MAX};
    ledger l, m;
    lflare_desc desc = a_desc(&l), desc2 = a_desc(&m);
    lflare_settings settings = some_settings(), plain;
    lflare *whole = create(&desc), *stepped = create(&desc2);
    const lflare_tables *shown;
    size_t i;
    int steps;
    lflare_result result;
    (void)state;
    memset(&plain, 0, sizeof plain);
    plain.no_starburst = settings.no_starburst = 1; /* its steps are counted elsewhere */
    assert_int_equal(lflare_configure(whole, &plain, NULL), LFLARE_OK);
    assert_int_equal(lflare_configure_step(stepped, 1), LFLARE_OK); /* nothing to do */
    assert_int_equal(lflare_configure_step(stepped, 0), LFLARE_ERROR_ARGUMENT);
    draw(whole, old_picture);
    assert_int_equal(lflare_configure(whole, &settings, NULL), LFLARE_OK);
    draw(whole, new_picture);
    assert_true(memcmp(old_picture, new_picture, sizeof new_picture) != 0);
    for (i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        assert_int_equal(lflare_configure(stepped, &plain, NULL), LFLARE_OK);
        settings = some_settings();
        settings.no_starburst = 1;
        assert_int_equal(lflare_configure_begin(stepped, &settings, NULL), LFLARE_OK);
        memset(overrides, 0xee, sizeof overrides); /* they were copied */
        memset(&settings, 0xee, sizeof settings);
        shown = lflare_get_tables(stepped);
        for (steps = 1; (result = lflare_configure_step(stepped, sizes[i])) == LFLARE_INCOMPLETE; steps++) {
            assert_ptr_equal(lflare_get_tables(stepped), shown);
            draw(stepped, during); /* still the old tables */
            assert_memory_equal(during, old_picture, sizeof during);
        }
        assert_int_equal(result, LFLARE_OK);
        assert_true(sizes[i] >= 100000 ? steps == 1 : steps == (lflare_get_lens(whole)->ghost_count + sizes[i] - 1) / sizes[i]);
        assert_int_equal(lflare_get_frame(stepped)->instance_count, 0); /* the last frame belonged to the old tables */
        expect_same_tables(lflare_get_tables(whole), lflare_get_tables(stepped));
        draw(stepped, during);
        assert_memory_equal(during, new_picture, sizeof during);
    }
    /* a new beginning gives up the one under way */
    settings = some_settings();
    assert_int_equal(lflare_configure_begin(stepped, &settings, NULL), LFLARE_OK);
    assert_int_equal(lflare_configure_step(stepped, 2), LFLARE_INCOMPLETE);
    assert_int_equal(lflare_configure_begin(stepped, &plain, NULL), LFLARE_OK);
    assert_int_equal(lflare_configure_step(stepped, INT32_MAX), LFLARE_OK);
    draw(stepped, during);
    assert_memory_equal(during, old_picture, sizeof during);
    /* destroyed halfway */
    assert_int_equal(lflare_configure_begin(stepped, &plain, NULL), LFLARE_OK);
    assert_int_equal(lflare_configure_step(stepped, 2), LFLARE_INCOMPLETE);
    lflare_destroy(stepped);
    lflare_destroy(whole);
    expect_settled(&l);
    expect_settled(&m);
}

/* ---- arguments ---- */

static void test_no_arguments(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    static lflare_tables tables;
    static float pixels[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare *flare = create(&desc);
    lflare_error error;
    lflare_settings settings;
    lflare_view view = a_view();
    lflare_image image = an_image(pixels);
    lflare_frame_data frame;
    lflare_footprint footprint;
    lflare_iris iris;
    lflare_pair pair = {1, 0, 0, 0};
    lflare_ghost_matrices matrices;
    int32_t n = 1;
    size_t size = 1;
    char *text = NULL;
    (void)state;
    memset(&settings, 0, sizeof settings);
    memset(&frame, 0, sizeof frame);
    memset(&footprint, 0, sizeof footprint);
    memset(&tables, 0, sizeof tables);
    lens = *lflare_get_lens(flare);
#define REFUSED(call) assert_int_equal(call, LFLARE_ERROR_ARGUMENT)
    REFUSED(lflare_text_read(NULL, 1, &p, &error));
    assert_true(error.code == LFLARE_ERROR_ARGUMENT && error.text[0] != 0);
    REFUSED(lflare_text_read("x", 1, NULL, &error));
    REFUSED(lflare_text_read(NULL, 1, NULL, NULL));
    assert_int_equal(lflare_text_read(NULL, 0, &p, NULL), LFLARE_ERROR_SYNTAX); /* empty, and allowed */
    REFUSED(lflare_text_write(NULL, NULL, &size));
    REFUSED(lflare_text_write(&p, NULL, NULL));
    REFUSED(lflare_text_write(&p, NULL, &size));
    REFUSED(lflare_lens_derive(NULL, &lens, &error));
    REFUSED(lflare_lens_derive(&p, NULL, NULL));
    REFUSED(lflare_ghost_list(NULL, &pair, &n));
    REFUSED(lflare_ghost_list(&lens, &pair, NULL));
    n = 1;
    REFUSED(lflare_ghost_list(&lens, NULL, &n));
    REFUSED(lflare_ghost_optics(NULL, 550, &pair, 1, &matrices));
    REFUSED(lflare_ghost_optics(&lens, 550, NULL, 1, &matrices));
    REFUSED(lflare_ghost_optics(&lens, 550, &pair, 1, NULL));
    REFUSED(lflare_ghost_optics(&lens, 550, &pair, -1, &matrices));
    pair.first = 8; /* on different sides of the stop */
    REFUSED(lflare_ghost_optics(&lens, 550, &pair, 1, &matrices));
    pair.first = 77;
    REFUSED(lflare_ghost_optics(&lens, 550, &pair, 1, &matrices));
    pair.first = -1;
    REFUSED(lflare_ghost_path(&lens, 550, pair, NULL, (n = 0, &n)));
    pair.first = 1;
    REFUSED(lflare_ghost_path(NULL, 550, pair, NULL, &n));
    REFUSED(lflare_ghost_path(&lens, 550, pair, NULL, NULL));
    REFUSED(lflare_ghost_path(&lens, 550, pair, NULL, (n = 1, &n)));
    REFUSED(lflare_film_layers(NULL, 0, NULL, (n = 0, &n)));
    REFUSED(lflare_film_layers(&lens, 0, NULL, NULL));
    REFUSED(lflare_film_layers(&lens, 0, NULL, (n = 1, &n)));
    REFUSED(lflare_film_layers(&lens, -1, NULL, (n = 0, &n)));
    REFUSED(lflare_film_layers(&lens, 9, NULL, (n = 0, &n)));
    REFUSED(lflare_iris_make(NULL, 0, 0, 0, 0, &iris, NULL));
    REFUSED(lflare_iris_make(&lens, 0, 0, 0, 0, NULL, NULL));
    REFUSED(lflare_iris_make(&lens, -1, 0, 0, 0, &iris, NULL));
    REFUSED(lflare_iris_make(&lens, 0, 2, 0, 0, &iris, NULL));
    REFUSED(lflare_iris_make(&lens, 0, 17, 0, 0, &iris, NULL));
    REFUSED(lflare_iris_make(&lens, 0, 5, HUGE_VAL, 0, &iris, NULL));
    REFUSED(lflare_iris_make(&lens, 0, 5, 0, 1.5, &iris, NULL));
    REFUSED(lflare_iris_make(&lens, HUGE_VAL - HUGE_VAL, 5, 0, 0, &iris, NULL));
    REFUSED(lflare_tables_prepare(NULL, &tables, 0, 0));
    REFUSED(lflare_tables_prepare(&lens, NULL, 0, 0));
    REFUSED(lflare_tables_prepare(&lens, &tables, 0, 0));
    REFUSED(lflare_tables_configure_begin(NULL, &tables, &settings, NULL));
    REFUSED(lflare_tables_configure_begin(&lens, NULL, &settings, NULL));
    REFUSED(lflare_tables_configure_begin(&lens, &tables, NULL, &error));
    REFUSED(lflare_tables_configure_begin(&lens, &tables, &settings, &error));
    REFUSED(lflare_frame_build(NULL, &view, &sun, 1, &frame));
    REFUSED(lflare_frame_build(lflare_get_tables(flare), NULL, &sun, 1, &frame));
    REFUSED(lflare_frame_build(lflare_get_tables(flare), &view, NULL, 1, &frame));
    REFUSED(lflare_frame_build(lflare_get_tables(flare), &view, &sun, -1, &frame));
    REFUSED(lflare_frame_build(lflare_get_tables(flare), &view, &sun, 1, NULL));
    assert_int_equal(lflare_frame_build(lflare_get_tables(flare), &view, &sun, 1, &frame), LFLARE_ERROR_LIMIT); /* no room at all */
    REFUSED(lflare_software_rows(NULL, 1, &iris, &frame, &image, 0, 1));
    REFUSED(lflare_software_rows(&footprint, 1, NULL, &frame, &image, 0, 1));
    REFUSED(lflare_software_rows(&footprint, 1, &iris, NULL, &image, 0, 1));
    REFUSED(lflare_software_rows(&footprint, 1, &iris, &frame, NULL, 0, 1));
    REFUSED(lflare_software_rows(&footprint, -1, &iris, &frame, &image, 0, 1));
    lflare_destroy(flare);
    REFUSED(lflare_create(NULL, &flare, NULL));
    assert_null(flare);
    REFUSED(lflare_create(&desc, NULL, &error));
    flare = create(&desc);
    desc.text = NULL;
    {
        lflare *none = flare;
        REFUSED(lflare_create(&desc, &none, &error));
        assert_null(none);
    }
    REFUSED(lflare_configure(NULL, &settings, NULL));
    REFUSED(lflare_configure(flare, NULL, &error));
    REFUSED(lflare_configure_begin(NULL, &settings, NULL));
    REFUSED(lflare_configure_begin(flare, NULL, NULL));
    REFUSED(lflare_configure_step(NULL, 1));
    settings.override_count = 1;
    REFUSED(lflare_configure(flare, &settings, NULL));
    REFUSED(lflare_frame(NULL, &view, &sun, 1));
    REFUSED(lflare_frame(flare, NULL, &sun, 1));
    REFUSED(lflare_frame(flare, &view, NULL, 1));
    assert_int_equal(lflare_frame(flare, &view, NULL, 0), LFLARE_OK);
    REFUSED(lflare_render(NULL, &image));
    REFUSED(lflare_render(flare, NULL));
    REFUSED(lflare_render_begin(NULL));
    REFUSED(lflare_render_rows(NULL, &image, 0, 1));
    REFUSED(lflare_render_rows(flare, NULL, 0, 1));
    REFUSED(lflare_render_rows(flare, &image, -1, 1));
    REFUSED(lflare_render_rows(flare, &image, 0, H + 1));
    image.width = W + 1;
    REFUSED(lflare_render(flare, &image));
    image.width = W;
    image.pixels = NULL;
    REFUSED(lflare_render(flare, &image));
    REFUSED(lflare_file_read(NULL, NULL, NULL, &text, &size, &error));
    REFUSED(lflare_file_read("README.md", NULL, NULL, NULL, &size, NULL));
    REFUSED(lflare_file_read("README.md", NULL, NULL, &text, NULL, NULL));
#undef REFUSED
    assert_null(lflare_get_lens(NULL));
    assert_null(lflare_get_tables(NULL));
    assert_null(lflare_get_frame(NULL));
    lflare_destroy(NULL);
    lflare_destroy(flare);
}

/* Views and lights that are not numbers are refused before anything is drawn; too many lights too. */
static void test_wrong_views_and_lights(void **state)
{
    static float pixels[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare *flare;
    lflare_light lights[3];
    const float nan = (float)(HUGE_VAL - HUGE_VAL), inf = (float)HUGE_VAL;
    int32_t what;
    (void)state;
    desc.max_lights = 2;
    flare = create(&desc);
    for (what = 0; what < 22; what++) {
        lflare_view v = a_view();
        lflare_light s = sun;
        switch (what) {
        case 0: v.width = 0; break;
        case 1: v.height = -1; break;
        case 2: v.width = INT32_MAX; break;
        case 3: v.fov_y = nan; break;
        case 4: v.fov_y = 3.2f; break;
        case 5: v.fov_y = -1; break;
        case 6: v.fit = (lflare_fit)7; break;
        case 7: v.fit = (lflare_fit)-1; break;
        case 8: v.centre[1] = nan; break;
        case 9: v.centre[0] = -inf; break;
        case 10: case 11: case 12: s.direction[what - 10] = nan; break;
        case 13: s.direction[2] = -inf; break;
        case 14: case 15: case 16: s.color[what - 14] = inf; break;
        case 17: s.color[1] = nan; break;
        case 18: s.occlusion[2] = nan; break;
        case 19: s.angular_radius = nan; break;
        case 20: s.angular_radius = -0.1f; break;
        default: s.angular_radius = 3; break;
        }
        if (lflare_frame(flare, &v, &s, 1) != LFLARE_ERROR_ARGUMENT) fail_msg("case %d is accepted", (int)what);
        assert_int_equal(lflare_get_frame(flare)->instance_count, 0);
        assert_int_equal(lflare_get_frame(flare)->light_count, 0);
    }
    for (what = 0; what < 3; what++) lights[what] = sun;
    {
        lflare_view v = a_view();
        lflare_image image = an_image(pixels);
        assert_int_equal(lflare_frame(flare, &v, lights, 2), LFLARE_OK);
        assert_int_equal(lflare_frame(flare, &v, lights, 3), LFLARE_ERROR_LIMIT);
        assert_in_range(lflare_get_frame(flare)->light_count, 0, 2);
        lights[1].direction[2] = 1; /* behind the camera: takes no room */
        assert_int_equal(lflare_frame(flare, &v, lights, 3), LFLARE_OK);
        assert_int_equal(lflare_get_frame(flare)->light_count, 2);
        assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    }
    lflare_destroy(flare);
    expect_settled(&l);
}

/* Before any frame there is nothing to draw, and no picture that fits. */
static void test_render_before_frame(void **state)
{
    static float pixels[4 * W * H];
    ledger l;
    lflare_desc desc = a_desc(&l);
    lflare *flare = create(&desc);
    lflare_image image = an_image(pixels);
    (void)state;
    assert_int_equal(lflare_get_frame(flare)->instance_count, 0);
    assert_int_equal(lflare_render(flare, &image), LFLARE_ERROR_ARGUMENT);
    lflare_destroy(flare);
    expect_settled(&l);
}

/* ---- files ---- */

#define FILE_NAME "build/test_failure_file"

static void make_file(size_t size)
{
    FILE *file;
    size_t i;
    assert_int_equal(system("mkdir -p build"), 0);
    file = fopen(FILE_NAME, "wb");
    assert_non_null(file);
    if (size > 1000000) {
        assert_int_equal(fseek(file, (long)size - 1, SEEK_SET), 0);
        fputc('x', file);
    } else {
        for (i = 0; i < size; i++) fputc((int)(i * 7 % 251), file);
    }
    fclose(file);
}

static void test_file_read(void **state)
{
    static const size_t sizes[] = {0, 1, 16382, 16383, 16384, 16385, 32767, 32768, 100000};
    ledger l;
    lflare_error error;
    size_t i, size, k;
    long n;
    char *text;
    (void)state;
    for (i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        make_file(sizes[i]);
        for (n = 1;; n++) {
            lflare_result result;
            memset(&l, 0, sizeof l);
            l.fail_at = n;
            text = (char *)&l;
            result = lflare_file_read(FILE_NAME, ledger_realloc, &l, &text, &size, &error);
            assert_int_equal(result, error.code);
            if (result == LFLARE_OK) break;
            assert_int_equal(result, LFLARE_ERROR_MEMORY);
            assert_null(text);
            expect_settled(&l);
        }
        assert_true(n > 1);
        assert_true(size == sizes[i] && l.bytes == size + 1 && text[size] == 0);
        for (k = 0; k < size; k++) assert_int_equal((uint8_t)text[k], k * 7 % 251);
        ledger_realloc(&l, text, size + 1, 0);
        expect_settled(&l);
        assert_int_equal(lflare_file_read(FILE_NAME, NULL, NULL, &text, &size, NULL), LFLARE_OK);
        free(text);
    }
    remove(FILE_NAME);
}

static void test_file_refused(void **state)
{
    ledger l;
    lflare_error error;
    size_t size = 99;
    char *text;
    (void)state;
    memset(&l, 0, sizeof l);
    text = (char *)&l;
    assert_int_equal(lflare_file_read("build/there is no such file", ledger_realloc, &l, &text, &size, &error), LFLARE_ERROR_FILE);
    assert_true(text == NULL && size == 0 && error.code == LFLARE_ERROR_FILE);
    assert_string_equal(error.text, "the file cannot be opened");
    assert_int_equal(lflare_file_read("", NULL, NULL, &text, &size, NULL), LFLARE_ERROR_FILE);
    text = (char *)&l;
    assert_int_equal(lflare_file_read("tests", ledger_realloc, &l, &text, &size, &error), LFLARE_ERROR_FILE); /* a directory */
    assert_null(text);
    assert_string_equal(error.text, "the file cannot be read");
    expect_settled(&l);
    make_file((size_t)16 << 20); /* just allowed */
    assert_int_equal(lflare_file_read(FILE_NAME, ledger_realloc, &l, &text, &size, &error), LFLARE_OK);
    assert_true(size == (size_t)16 << 20 && text[size - 1] == 'x' && text[size] == 0);
    ledger_realloc(&l, text, size + 1, 0);
    make_file(((size_t)40 << 20) + 1);
    assert_int_equal(lflare_file_read(FILE_NAME, ledger_realloc, &l, &text, &size, &error), LFLARE_ERROR_FILE);
    assert_null(text);
    assert_string_equal(error.text, "the file is larger than 16 MB, which no prescription is");
    expect_settled(&l);
    make_file(((size_t)16 << 20) + 1);
    assert_int_equal(lflare_file_read(FILE_NAME, ledger_realloc, &l, &text, &size, &error), LFLARE_ERROR_FILE);
    assert_null(text);
    assert_string_equal(error.text, "the file is larger than 16 MB, which no prescription is");
    expect_settled(&l);
    remove(FILE_NAME);
}

static void test_results_have_texts(void **state)
{
    int32_t r;
    (void)state;
    for (r = LFLARE_ERROR_LIMIT; r <= LFLARE_INCOMPLETE; r++) {
        assert_non_null(lflare_result_text((lflare_result)r));
        assert_string_not_equal(lflare_result_text((lflare_result)r), "unknown result");
    }
    assert_string_equal(lflare_result_text((lflare_result)77), "unknown result");
    assert_int_equal(lflare_version(), LFLARE_VERSION);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_create_fails),    cmocka_unit_test(test_create_refused),
        cmocka_unit_test(test_configure_fails), cmocka_unit_test(test_configure_fails_between_steps),
        cmocka_unit_test(test_render_fails),    cmocka_unit_test(test_never_allocates),
        cmocka_unit_test(test_sizes_do_not_wrap), cmocka_unit_test(test_steps_equal_whole),
        cmocka_unit_test(test_no_arguments),    cmocka_unit_test(test_wrong_views_and_lights),
        cmocka_unit_test(test_render_before_frame), cmocka_unit_test(test_file_read),
        cmocka_unit_test(test_file_refused),    cmocka_unit_test(test_results_have_texts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
