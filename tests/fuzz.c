/* Fuzzing target: takes any text through every stage of the library. View, lights and settings come from a hash of the
   text, so that an input says all. Built three ways: with libFuzzer (tests/fuzz.sh), with coverage (tests/coverage.sh) and
   with a main of its own that replays files, each also mutated FUZZ_ROUNDS times (-DFUZZ_MAIN, tests/check_seeds.sh). */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

#include <stdio.h>

#define CHECK(x)                                                                          \
    do {                                                                                  \
        if (!(x)) {                                                                       \
            fprintf(stderr, "fuzz.c:%d: check failed: %s\n", __LINE__, #x);               \
            abort();                                                                      \
        }                                                                                 \
    } while (0)

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);
size_t LLVMFuzzerCustomCrossOver(const uint8_t *a, size_t a_size, const uint8_t *b, size_t b_size, uint8_t *out, size_t max_size,
                                 unsigned int seed);

/* ---- chance ---- */

typedef struct rng {
    uint64_t state;
} rng;

static uint64_t next(rng *r)
{
    uint64_t z = (r->state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}
static int32_t below(rng *r, int32_t n) { return (int32_t)(next(r) % (uint64_t)n); }
static double unit(rng *r) { return (double)(next(r) >> 11) / 9007199254740992.0; }
static double between(rng *r, double lo, double hi) { return lo + (hi - lo) * unit(r); }
static float betweenf(rng *r, double lo, double hi) { return (float)between(r, lo, hi); }

static uint64_t hash(const uint8_t *data, size_t size)
{
    uint64_t h = 1469598103934665603u;
    size_t i;
    for (i = 0; i < size; i++) h = (h ^ data[i]) * 1099511628211u;
    return h;
}

/* ---- what was reached ---- */

static long inputs, parsed, derived, created, drawn;

static void print_counts(void)
{
    fprintf(stderr, "reached: inputs %ld parsed %ld derived %ld rendered %ld with_ghosts %ld (%.1f %% rendered)\n", inputs, parsed, derived, created,
            drawn, inputs > 0 ? 100.0 * (double)created / (double)inputs : 0);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    atexit(print_counts);
    return 0;
}

/* ---- memory: capped, counted, every size checked ---- */

typedef struct pool {
    size_t used, cap;
} pool;

static void *pool_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    pool *p = (pool *)user;
    size_t *head = block != NULL ? (size_t *)block - 2 : NULL;
    size_t *moved;
    CHECK(head == NULL ? old_size == 0 : *head == old_size);
    if (new_size == 0) {
        p->used -= old_size;
        free(head);
        return NULL;
    }
    if (new_size > p->cap || p->used - old_size > p->cap - new_size) return NULL;
    moved = (size_t *)realloc(head, new_size + 2 * sizeof(size_t));
    if (moved == NULL) return NULL;
    p->used += new_size - old_size;
    *moved = new_size;
    return moved + 2;
}

/* ---- stages ---- */

static void check_error(lflare_result result, const lflare_error *e)
{
    size_t i, n = 0;
    while (n < sizeof e->text && e->text[n] != 0) n++;
    CHECK(n < sizeof e->text);
    CHECK(e->code == result);
    if (result == LFLARE_OK) {
        CHECK(n == 0 && e->line == 0 && e->column == 0);
        return;
    }
    CHECK(n > 0);
    for (i = 0; i < n; i++) CHECK(e->text[i] >= 32 && e->text[i] < 127);
    CHECK((e->line == 0) == (e->column == 0));
}

static int same_double(double a, double b) { return a == b; } /* the sign of zero is not kept */

static void check_same(const lflare_prescription *a, const lflare_prescription *b)
{
    int32_t i, k;
    CHECK(strcmp(a->name, b->name) == 0 && strcmp(a->patent, b->patent) == 0 && strcmp(a->source, b->source) == 0);
    CHECK(same_double(a->fnumber, b->fnumber) && same_double(a->sensor_width, b->sensor_width) && same_double(a->sensor_height, b->sensor_height));
    CHECK(a->focus == b->focus && a->surface_count == b->surface_count && a->layer_count == b->layer_count);
    for (i = 0; i < a->surface_count; i++) {
        const lflare_surface *s = &a->surfaces[i], *t = &b->surfaces[i];
        CHECK(same_double(s->radius, t->radius) && same_double(s->thickness, t->thickness) && same_double(s->semi_diameter, t->semi_diameter));
        CHECK(same_double(s->conic, t->conic) && s->is_stop == t->is_stop && s->coating == t->coating && same_double(s->quarter_nm, t->quarter_nm));
        for (k = 0; k < 8; k++) CHECK(same_double(s->aspheric[k], t->aspheric[k]));
        CHECK(s->medium.kind == t->medium.kind && strcmp(s->medium.glass, t->medium.glass) == 0);
        for (k = 0; k < 6; k++) CHECK(same_double(s->medium.c[k], t->medium.c[k]));
        CHECK(s->layer_count == t->layer_count && s->first_layer == t->first_layer);
    }
    for (i = 0; i < a->layer_count; i++)
        CHECK(same_double(a->layers[i].n, b->layers[i].n) && same_double(a->layers[i].thickness_nm, b->layers[i].thickness_nm));
}

static char *write_text(const lflare_prescription *p, size_t *size)
{
    char *text;
    *size = 0;
    CHECK(lflare_text_write(p, NULL, size) == LFLARE_INCOMPLETE && *size > 0);
    text = (char *)malloc(*size);
    CHECK(text != NULL);
    CHECK(lflare_text_write(p, text, size) == LFLARE_OK);
    return text;
}

static void round_trip(const lflare_prescription *p)
{
    static lflare_prescription again;
    size_t size, size2, half;
    char *text = write_text(p, &size), *text2, *part;
    CHECK(lflare_text_read(text, size, &again, NULL) == LFLARE_OK);
    check_same(p, &again);
    text2 = write_text(&again, &size2);
    CHECK(size == size2 && memcmp(text, text2, size) == 0);
    half = size2 = size / 2;
    part = (char *)malloc(half + 1);
    CHECK(part != NULL);
    part[half] = 'x';
    CHECK(lflare_text_write(p, part, &size2) == LFLARE_INCOMPLETE && size2 == size && part[half] == 'x');
    CHECK(memcmp(part, text, half) == 0);
    free(part);
    free(text);
    free(text2);
}

static void notes(const lflare_lens *lens)
{
    char text[LFLARE_MAX_NOTES];
    int32_t i;
    CHECK(lens->note_count >= 0 && lens->note_count <= LFLARE_MAX_NOTES);
    for (i = 0; i < lens->note_count; i++) {
        size_t room = (size_t)(1 + i * 7 % 159);
        memset(text, 'x', sizeof text);
        CHECK(lflare_note_text(&lens->notes[i], text, room) == text && memchr(text, 0, room) != NULL);
        lflare_note_text(&lens->notes[i], text, sizeof text);
        CHECK(strcmp(text, "unknown note") != 0 && strlen(text) > 5);
    }
}

static int is_finite(double x) { return x - x == 0; }

static void lens_invariants(const lflare_lens *lens)
{
    const lflare_surface *s = lens->prescription.surfaces;
    int32_t i;
    CHECK(lens->surface_count == lens->prescription.surface_count && lens->stop >= 0 && lens->stop < lens->surface_count && s[lens->stop].is_stop);
    CHECK(is_finite(lens->efl) && lens->efl > 0 && is_finite(lens->bfd) && is_finite(lens->fnumber) && lens->fnumber > 0);
    CHECK(is_finite(lens->stop_a11) && lens->stop_a11 != 0 && lens->sensor_width > 0 && lens->sensor_height > 0);
    for (i = 0; i < lens->surface_count; i++) {
        CHECK(s[i].semi_diameter > 0 && is_finite(s[i].semi_diameter) && is_finite(s[i].thickness) && s[i].thickness >= 0);
        CHECK(is_finite(lens->curvature[i]));
    }
}

static void ghosts(const lflare_lens *lens, rng *r)
{
    int32_t count = lens->ghost_count, half = count / 2, i, k, n;
    size_t room = sizeof(lflare_pair) * (size_t)(count + 1);
    lflare_pair *pairs = (lflare_pair *)malloc(room);
    lflare_ghost_matrices *m = (lflare_ghost_matrices *)malloc(sizeof *m * (size_t)(count + 1));
    static lflare_crossing path[LFLARE_MAX_CIRCLES];
    CHECK(pairs != NULL && m != NULL);
    n = half;
    CHECK(lflare_ghost_list(lens, pairs, &n) == (count > half ? LFLARE_INCOMPLETE : LFLARE_OK) && n == count);
    CHECK(lflare_ghost_list(lens, pairs, &n) == LFLARE_OK && n == count);
    CHECK(lflare_ghost_optics(lens, between(r, 380, 780), pairs, count, m) == LFLARE_OK);
    for (i = 0; i < 6 && count > 0; i++) {
        lflare_pair p = pairs[below(r, count)];
        double u = between(r, 0, 1.5), iris = lens->prescription.surfaces[lens->stop].semi_diameter * between(r, 0.1, 1);
        lflare_region region;
        lflare_clip clip;
        int stops = 0;
        n = 1;
        CHECK(lflare_ghost_path(lens, 550, p, path, &n) == LFLARE_INCOMPLETE && n <= 3 * LFLARE_MAX_SURFACES);
        CHECK(lflare_ghost_path(lens, 550, p, path, &n) == LFLARE_OK);
        for (k = 0; k < n; k++) stops += path[k].surface == lens->stop;
        CHECK(stops == 1);
        clip = lflare_ghost_clip(lens, 550, p, iris, u, &region);
        CHECK(region.area >= 0);
        {
            double weight = lflare_ghost_weight(lens, 550, p, between(r, -1, 1) * lens->prescription.surfaces[0].semi_diameter, u);
            CHECK(weight >= 0 && weight <= 1);
        }
        if (clip != LFLARE_CLIP_HIDDEN) CHECK(region.lo <= region.centroid && region.centroid <= region.hi);
    }
    for (i = 0; i < 4; i++) {
        static lflare_layer layers[LFLARE_MAX_LAYERS];
        int32_t s = below(r, lens->surface_count);
        double n0 = between(r, 1, 2.5), n1 = between(r, 1, 2.5), sine = between(r, 0, n0 < n1 ? n0 : n1), reflectance;
        n = LFLARE_MAX_LAYERS;
        CHECK(lflare_film_layers(lens, s, layers, &n) == LFLARE_OK);
        reflectance = lflare_film_reflectance(n0, n1, layers, n, between(r, 380, 780), sine);
        CHECK(reflectance >= 0 && reflectance <= 1);
        (void)lflare_sag(&lens->prescription.surfaces[s], between(r, 0, 30));
    }
    free(pairs);
    free(m);
}

static double special(rng *r)
{
    static const double values[] = {0, -0.0, 1, -1, 1e-30, 1e30, 3e38, -3e38, 1e300};
    switch (below(r, 6)) {
    case 0: return HUGE_VAL;
    case 1: return -HUGE_VAL;
    case 2: return HUGE_VAL - HUGE_VAL;
    default: return values[below(r, (int32_t)(sizeof values / sizeof *values))];
    }
}

static float specialf(rng *r)
{
    double v = special(r);
    return v > 3.4e38 || v < -3.4e38 ? (float)(v * HUGE_VAL) : (float)v;
}

/* `wild`: numbers that may be anything, which must give an error or be survived; pixels are then not looked at. */
static void make_settings(rng *r, const lflare_lens *lens, lflare_settings *s, lflare_override *overrides, int wild)
{
    int32_t i, k;
    memset(s, 0, sizeof *s);
    memset(overrides, 0, sizeof *overrides * 4);
    if (below(r, 2)) s->fnumber = between(r, 0.5, 30);
    if (below(r, 2)) s->blades = 3 + below(r, 14);
    s->blade_rotation = betweenf(r, -7, 7);
    s->blade_curvature = below(r, 3) ? betweenf(r, 0, 1) : (float)below(r, 2);
    s->raw = below(r, 4) == 0;
    s->exposure_ev = betweenf(r, -8, 8);
    if (below(r, 6) == 0) s->ghost_budget = 1 + below(r, 20);
    if (below(r, 6) == 0) s->min_flux = betweenf(r, 0, 0.1);
    s->paper_clipping = below(r, 5) == 0;
    if (below(r, 2) && lens->ghost_count > 0) {
        lflare_pair *pairs = (lflare_pair *)malloc(sizeof(lflare_pair) * (size_t)lens->ghost_count);
        int32_t n = lens->ghost_count;
        CHECK(pairs != NULL && lflare_ghost_list(lens, pairs, &n) == LFLARE_OK);
        s->override_count = 1 + below(r, 4);
        s->overrides = overrides;
        for (i = 0; i < s->override_count; i++) {
            lflare_override *o = &overrides[i];
            lflare_pair p = pairs[below(r, n)];
            o->first = p.first + 1;
            o->second = p.second + 1;
            o->hide = below(r, 4) == 0;
            if (below(r, 2))
                for (k = 0; k < 3; k++) o->tint[k] = betweenf(r, 0, 2);
            o->ev = betweenf(r, -5, 5);
            if (below(r, 2)) o->scale = betweenf(r, 0.1, 3);
            if (below(r, 2))
                for (k = 0; k < 2; k++) o->move[k] = betweenf(r, -2, 2);
            if (wild && below(r, 4) == 0) o->first = below(r, 300) - 100;
            if (wild && below(r, 4) == 0) o->ev = specialf(r);
            if (wild && below(r, 4) == 0) o->scale = specialf(r);
            if (wild && below(r, 4) == 0) o->move[below(r, 2)] = specialf(r);
            if (wild && below(r, 4) == 0) o->tint[below(r, 3)] = specialf(r);
        }
        free(pairs);
    }
    if (!wild) return;
    if (below(r, 3) == 0) s->fnumber = special(r);
    if (below(r, 3) == 0) s->blades = below(r, 40) - 10;
    if (below(r, 5) == 0) s->blade_rotation = specialf(r);
    if (below(r, 5) == 0) s->blade_curvature = specialf(r);
    if (below(r, 5) == 0) s->exposure_ev = specialf(r);
    if (below(r, 5) == 0) s->min_flux = specialf(r);
    if (below(r, 8) == 0) s->ghost_budget = (int32_t)next(r);
    if (below(r, 8) == 0) s->override_count = -1;
}

static void make_view(rng *r, lflare_view *v, int wild)
{
    memset(v, 0, sizeof *v);
    v->width = below(r, 4) ? 64 : 1 + below(r, 64);
    v->height = below(r, 4) ? 48 : 1 + below(r, 48);
    if (below(r, 3) == 0) v->fov_y = betweenf(r, 0.02, 2.9);
    v->fit = (lflare_fit)below(r, 4);
    if (below(r, 4) == 0) {
        v->centre[0] = betweenf(r, -2, 2);
        v->centre[1] = betweenf(r, -2, 2);
    }
    if (wild && below(r, 3) == 0) v->fov_y = specialf(r);
    if (wild && below(r, 3) == 0) v->centre[below(r, 2)] = specialf(r);
    if (wild && below(r, 8) == 0) v->width = -v->width;
}

static void make_light(rng *r, lflare_light *l, int wild)
{
    int32_t k;
    double spread = below(r, 3) ? 0.4 : 3;
    memset(l, 0, sizeof *l);
    l->direction[0] = betweenf(r, -spread, spread);
    l->direction[1] = betweenf(r, -spread, spread);
    l->direction[2] = below(r, 16) ? -1.0f : betweenf(r, -1, 1);
    if (below(r, 8) == 0) l->direction[0] = l->direction[1] = 0;
    for (k = 0; k < 3; k++) {
        l->color[k] = betweenf(r, -0.1, 2);
        if (below(r, 4) == 0) l->occlusion[k] = betweenf(r, -0.5, 1.5);
    }
    if (below(r, 2)) l->angular_radius = below(r, 4) ? 0.00465f : betweenf(r, 0, 1.4);
    if (below(r, 16) == 0) l->flags = LFLARE_LIGHT_NO_GHOSTS;
    if (wild && below(r, 3) == 0) l->direction[below(r, 3)] = specialf(r);
    if (wild && below(r, 3) == 0) l->color[below(r, 3)] = specialf(r);
    if (wild && below(r, 3) == 0) l->occlusion[below(r, 3)] = specialf(r);
    if (wild && below(r, 3) == 0) l->angular_radius = specialf(r);
}

static uint64_t hash_tables(const lflare_tables *t)
{
    size_t g = (size_t)t->ghost_count;
    return hash((const uint8_t *)t->field, g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS * sizeof(float)) ^
           hash((const uint8_t *)t->style, g * LFLARE_STYLE_FLOATS * sizeof(float));
}

static void check_tables(const lflare_tables *t)
{
    size_t i, g = (size_t)t->ghost_count, surfaces = (size_t)t->surface_count;
    for (i = 0; i < surfaces * LFLARE_FILM_SAMPLES * 4; i++) CHECK(t->film[i] >= 0 && t->film[i] <= 1);
    for (i = 0; i < g * LFLARE_HEAD_FLOATS; i++) CHECK(is_finite((double)t->head[i]));
    for (i = 0; i < g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS; i++) {
        if (!is_finite((double)t->field[i]))
            fprintf(stderr, "ghost %d, sample %d, float %d is %g; iris %g mm\n", (int)(i / (LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS)), (int)(i / LFLARE_FIELD_FLOATS % LFLARE_FIELD_SAMPLES), (int)(i % LFLARE_FIELD_FLOATS), (double)t->field[i], (double)t->iris.radius);
        CHECK(is_finite((double)t->field[i]));
    }
    for (i = 0; i < g * LFLARE_STYLE_FLOATS; i++) CHECK(is_finite((double)t->style[i]));
    for (i = 0; i < (size_t)t->active_count; i++) CHECK(is_finite((double)t->cull[i].radius) && is_finite((double)t->cull[i].along));
    CHECK(is_finite((double)t->exposure) && t->exposure > 0);
}

static void picture(lflare *flare, rng *r, int wild)
{
    static float pixels[64 * 48 * 4 + 4];
    lflare_view view;
    lflare_light lights[3];
    lflare_image image;
    lflare_result result;
    int32_t i, n = 1 + below(r, 3);
    make_view(r, &view, wild);
    for (i = 0; i < n; i++) make_light(r, &lights[i], wild);
    result = lflare_frame(flare, &view, lights, n);
    CHECK(result == LFLARE_OK || (wild && result == LFLARE_ERROR_ARGUMENT));
    memset(&image, 0, sizeof image);
    image.pixels = pixels;
    image.width = lflare_get_frame(flare)->width;
    image.height = lflare_get_frame(flare)->height;
    image.bottom_up = below(r, 2);
    if (result != LFLARE_OK) CHECK(lflare_get_frame(flare)->instance_count == 0);
    if (image.width <= 0 || image.width > 64 || image.height > 48) return;
    memset(pixels, 0, sizeof pixels);
    pixels[image.width * image.height * 4] = 77;
    result = lflare_render(flare, &image);
    CHECK(result == LFLARE_OK || result == LFLARE_ERROR_MEMORY);
    CHECK(pixels[image.width * image.height * 4] == 77);
    if (wild) return;
    for (i = 0; i < image.width * image.height * 4; i++) {
        if (!(is_finite((double)pixels[i]) && pixels[i] >= 0)) fprintf(stderr, "pixel float %d is %g\n", (int)i, (double)pixels[i]);
        CHECK(is_finite((double)pixels[i]) && pixels[i] >= 0);
    }
    for (i = 0; i < 4 && lflare_get_frame(flare)->instance_count > 0; i++) {
        const lflare_frame_data *frame = lflare_get_frame(flare);
        lflare_footprint footprint;
        int32_t k = below(r, 3);
        if (lflare_footprint_resolve(lflare_get_tables(flare), frame, frame->instances[below(r, frame->instance_count)], &footprint)) {
            float x = footprint.centre[k][0] + betweenf(r, -1.2, 1.2) * footprint.radius;
            float coverage = lflare_footprint_coverage(&footprint, k, &lflare_get_tables(flare)->iris, x, footprint.centre[k][1]);
            CHECK(coverage >= 0 && coverage <= 2);
        }
    }
    drawn += lflare_get_frame(flare)->instance_count > 0;
    {
        uint8_t bytes[3 * 8];
        lflare_to_rgb8(pixels, 8, betweenf(r, 0, 2), below(r, 2), bytes);
    }
}

static void object(const lflare_prescription *p, const lflare_lens *lens, rng *r)
{
    pool memory;
    lflare_desc desc;
    lflare_override overrides[4];
    lflare_settings settings;
    lflare_error error;
    lflare *flare = NULL;
    lflare_result result;
    char *text = NULL;
    int wild = below(r, 8) == 0;
    memset(&desc, 0, sizeof desc);
    memory.used = 0;
    memory.cap = below(r, 16) ? (size_t)256 << 20 : (size_t)100000 << below(r, 8);
    desc.prescription = p;
    if (below(r, 4) == 0) { /* through the text, which is the same */
        desc.prescription = NULL;
        desc.text = text = write_text(p, &desc.text_size);
    }
    desc.allocate = pool_realloc;
    desc.user = &memory;
    desc.max_lights = 3;
    desc.paths.across_stop = below(r, 2);
    desc.paths.four = below(r, 8) == 0 ? below(r, LFLARE_MAX_FOUR + (wild ? 20 : 1)) : below(r, 4);
    make_settings(r, lens, &desc.settings, overrides, wild);
    result = lflare_create(&desc, &flare, &error);
    free(text);
    check_error(result, &error);
    CHECK(strcmp(lflare_result_text(result), "unknown result") != 0);
    if (result != LFLARE_OK) {
        CHECK(flare == NULL && memory.used == 0);
        CHECK(result == LFLARE_ERROR_MEMORY || (wild && result == LFLARE_ERROR_ARGUMENT));
        return;
    }
    if (!wild) check_tables(lflare_get_tables(flare));
    picture(flare, r, wild);
    created++;
    if (below(r, 4) == 0) {
        uint64_t before = hash_tables(lflare_get_tables(flare));
        wild |= below(r, 4) == 0;
        make_settings(r, lens, &settings, overrides, wild);
        if (below(r, 2)) {
            result = lflare_configure(flare, &settings, &error);
        } else {
            result = lflare_configure_begin(flare, &settings, &error);
            if (result == LFLARE_OK) {
                CHECK(hash_tables(lflare_get_tables(flare)) == before);
                while ((result = lflare_configure_step(flare, 1 + below(r, 50))) == LFLARE_INCOMPLETE) {
                    if (below(r, 8) == 0) picture(flare, r, 1);
                    CHECK(hash_tables(lflare_get_tables(flare)) == before);
                }
            }
        }
        if (result != LFLARE_OK) CHECK(result == LFLARE_ERROR_MEMORY || (wild && result == LFLARE_ERROR_ARGUMENT));
        if (result != LFLARE_OK) CHECK(hash_tables(lflare_get_tables(flare)) == before);
        picture(flare, r, wild);
    }
    lflare_destroy(flare);
    CHECK(memory.used == 0);
}

/* Lenses of many ghosts: a slice of the tables is prepared and configured, for the object would take a second. */
static void slice(const lflare_lens *lens, rng *r)
{
    lflare_tables t;
    lflare_settings settings;
    lflare_override overrides[4];
    lflare_tables_size size;
    void *lens_memory, *settings_memory;
    int32_t begin = below(r, lens->ghost_count), end = begin + 40 < lens->ghost_count ? begin + 40 : lens->ghost_count;
    memset(&t, 0, sizeof t);
    size = lflare_tables_layout(lens, NULL, NULL, NULL, &t);
    lens_memory = calloc(1, size.lens);
    settings_memory = calloc(1, size.settings);
    CHECK(lens_memory != NULL && settings_memory != NULL);
    lflare_tables_layout(lens, NULL, lens_memory, settings_memory, &t);
    CHECK(lflare_tables_prepare(lens, &t, 0, 1) == LFLARE_OK && lflare_tables_prepare(lens, &t, begin, end) == LFLARE_OK);
    make_settings(r, lens, &settings, overrides, 0);
    CHECK(lflare_tables_configure_begin(lens, &t, &settings, NULL) == LFLARE_OK);
    lflare_tables_configure_range(lens, &t, &settings, begin, end);
    lflare_tables_configure_end(&t, &settings);
    check_tables(&t);
    free(lens_memory);
    free(settings_memory);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static lflare_prescription p;
    static lflare_lens lens;
    lflare_error error;
    lflare_result result;
    rng r;
    r.state = hash(data, size);
    inputs++;
    result = lflare_text_read((const char *)data, size, &p, &error);
    check_error(result, &error);
    if (result != LFLARE_OK) {
        CHECK(result == LFLARE_ERROR_SYNTAX && error.line >= 1 && (size_t)error.line <= size + 1 && (size_t)error.column <= size + 1);
        return 0;
    }
    parsed++;
    CHECK(p.surface_count > 0 && p.surface_count <= LFLARE_MAX_SURFACES && p.layer_count <= LFLARE_MAX_LAYERS);
    round_trip(&p);
    result = lflare_lens_derive(&p, &lens, &error);
    check_error(result, &error);
    if (result != LFLARE_OK) {
        CHECK(result == LFLARE_ERROR_LENS);
        return 0;
    }
    derived++;
    lens_invariants(&lens);
    notes(&lens);
    { /* what was derived can be written, read and derived again, unless a derived number is beyond what may be stated */
        static lflare_lens again;
        if (lflare_lens_derive(&lens.prescription, &again, NULL) == LFLARE_OK) {
            CHECK(again.ghost_count == lens.ghost_count);
            if (p.focus) lens.prescription.surfaces[lens.surface_count - 1].thickness = 0; /* written as 'focus' */
            round_trip(&lens.prescription);
        }
    }
    ghosts(&lens, &r);
    if (lens.ghost_count <= 120 || (lens.ghost_count <= 600 && below(&r, 8) == 0)) object(&p, &lens, &r);
    else slice(&lens, &r);
    return 0;
}

/* ---- mutation of rows, words and numbers: most results stay prescriptions ---- */

enum { TEXT = 1 << 15 };

typedef struct words {
    char bytes[TEXT];
    size_t size;
} words;

static void put(words *w, const char *text)
{
    size_t n = strlen(text);
    if (w->size + n > sizeof w->bytes) return;
    memcpy(w->bytes + w->size, text, n);
    w->size += n;
}

static void put_bytes(words *w, const char *text, size_t n)
{
    if (w->size + n > sizeof w->bytes) return;
    memcpy(w->bytes + w->size, text, n);
    w->size += n;
}

static void put_number(words *w, double v)
{
    char number[32];
    put_bytes(w, number, (size_t)lflare_number_write(v, number));
}

static double rounded(rng *r, double lo, double hi)
{
    double step = below(r, 3) ? 100 : 1e6;
    return floor(between(r, lo, hi) * step + 0.5) / step;
}

static void put_medium(words *w, rng *r)
{
    static const char *const sellmeier[] = {
        "sellmeier 1.03961212 0.231792344 1.01046945 0.00600069867 0.0200179144 103.560653",
        "sellmeier 1.62153902 0.256287842 1.64447552 0.0122241457 0.0595736775 147.468793",
        "sellmeier 0.6961663 0.4079426 0.8974794 0.00467914826 0.0135120631 97.9340025"};
    switch (below(r, 5)) {
    case 0: put(w, sellmeier[below(r, 3)]); break;
    case 1:
        put(w, "cauchy ");
        put_number(w, rounded(r, 1.45, 1.8));
        put(w, " ");
        put_number(w, rounded(r, 0.002, 0.012));
        if (below(r, 2)) put(w, " 0.00002");
        break;
    case 2:
        put(w, "n ");
        put_number(w, rounded(r, 1.4, 2));
        break;
    default:
        put(w, "nd ");
        put_number(w, rounded(r, 1.4, 2));
        put(w, " vd ");
        put_number(w, rounded(r, 20, 90));
    }
    if (below(r, 6) == 0) put(w, " glass N-BK7");
}

static void put_option(words *w, rng *r)
{
    int32_t i, n;
    switch (below(r, 6)) {
    case 0: put(w, " semi "); put_number(w, rounded(r, 2, 40)); break;
    case 1: put(w, " conic "); put_number(w, rounded(r, -3, 1)); break;
    case 2:
        put(w, " asphere");
        for (i = 4; i <= 4 + 2 * below(r, 3); i += 2) {
            put(w, " ");
            put_number(w, i);
            put(w, ":");
            put_number(w, between(r, -1, 1) * pow(10, -1.5 * i));
        }
        break;
    case 3: put(w, " coating quarter "); put_number(w, rounded(r, 380, 780)); break;
    case 4:
        put(w, " coating stack");
        for (i = 0, n = 1 + below(r, 5); i < n; i++) {
            put(w, " ");
            put_number(w, rounded(r, 1.38, 2.3));
            put(w, ":");
            put_number(w, rounded(r, 20, 200));
        }
        break;
    default: put(w, " glass X"); break;
    }
}

/* A lens of positive power most of the time: elements of two surfaces, the stop somewhere between. */
static void put_lens(words *w, rng *r)
{
    int32_t elements = below(r, 20) ? 1 + below(r, 6) : 10 + below(r, 30), stop = below(r, elements + 1), i;
    put(w, "lensflare 1\n");
    if (below(r, 3) == 0) put(w, "name a # b\n");
    if (below(r, 3)) { put(w, "fnumber "); put_number(w, rounded(r, 1, 12)); put(w, "\n"); }
    if (below(r, 3) == 0) { put(w, "sensor "); put_number(w, rounded(r, 5, 60)); put(w, " "); put_number(w, rounded(r, 5, 60)); put(w, "\n"); }
    for (i = 0; i < elements; i++) {
        double radius = between(r, 15, 200);
        int negative = below(r, 3) == 0;
        if (i == stop) { put(w, "stop "); put_number(w, rounded(r, 0.5, 8)); if (below(r, 2)) { put(w, " semi "); put_number(w, rounded(r, 1, 15)); } put(w, "\n"); }
        if (below(r, 8)) put_number(w, floor((negative ? -2 : 1) * radius * 100) / 100);
        else put(w, "flat");
        put(w, " ");
        put_number(w, rounded(r, 0.5, 9));
        put(w, " ");
        put_medium(w, r);
        if (below(r, 3) == 0) put_option(w, r);
        put(w, "\n");
        put_number(w, floor((negative ? 2 : -1) * between(r, 15, 300) * 100) / 100);
        put(w, " ");
        if (i + 1 < elements) put_number(w, rounded(r, 0.1, 9));
        else if (stop == elements) put_number(w, rounded(r, 0.1, 3));
        else if (below(r, 2)) put(w, "focus");
        else put_number(w, rounded(r, 10, 80));
        if (below(r, 3) == 0) put_option(w, r);
        put(w, "\n");
    }
    if (stop == elements) put(w, below(r, 2) ? "stop focus semi 3\n" : "stop 35\n");
}

/* Where lines begin; the last entry is the size. */
static int32_t find_lines(const char *text, size_t size, size_t *starts, int32_t room)
{
    int32_t n = 0;
    size_t i;
    starts[n++] = 0;
    for (i = 0; i < size && n + 1 < room; i++)
        if (text[i] == '\n' && i + 1 < size) starts[n++] = i + 1;
    starts[n] = size;
    return n;
}

static int is_row(const char *line, size_t size)
{
    return size > 0 && (line[0] == '-' || (line[0] >= '0' && line[0] <= '9') || line[0] == 's' || line[0] == 'f' || line[0] == ' ' || line[0] == '.');
}

/* Changes one number of the text, chosen by chance. */
static void change_number(const char *text, size_t size, rng *r, words *w)
{
    size_t at, end, tries;
    double v;
    for (tries = 0; tries < 64; tries++) {
        at = size > 0 ? (size_t)(next(r) % size) : 0;
        while (at > 0 && strchr(" \t\n:", text[at - 1]) == NULL) at--;
        for (end = at; end < size && strchr(" \t\n:#", text[end]) == NULL; end++) {}
        if (end > at && end - at < 40 && lflare_number_read(text + at, end - at, &v) && !(at == 10 && end == 11)) {
            put_bytes(w, text, at);
            switch (below(r, 10)) {
            case 0: put_number(w, -v); break;
            case 1: put_number(w, floor(v)); break;
            case 2: put_number(w, v * pow(10, below(r, 9) - 4)); break;
            case 3: put_number(w, (double)below(r, 17)); break;
            case 4: {
                static const char *const odd[] = {"0", "1", "1e9", "1e-3", "1000000", "0.0001", "5", "1e12", "-1", "1e-300", "1e309", "nan", "+3", ".5", "7.", "100000", "200", "16"};
                put(w, odd[below(r, (int32_t)(sizeof odd / sizeof *odd))]);
                break;
            }
            default: put_number(w, v * (below(r, 2) ? between(r, 0.5, 2) : between(r, 0.95, 1.05))); break;
            }
            put_bytes(w, text + end, size - end);
            return;
        }
    }
    put_bytes(w, text, size);
}

static void mutate_once(const char *text, size_t size, rng *r, words *w)
{
    enum { LINES = 600 };
    static size_t lines[LINES];
    int32_t n = find_lines(text, size, lines, LINES), i = below(r, n), k = below(r, n), tries, line;
    size_t from, to;
    w->size = 0;
    for (tries = 0; tries < 8 && !is_row(text + lines[i], lines[i + 1] - lines[i]); tries++) i = below(r, n);
    from = lines[i];
    to = lines[i + 1];
    switch (below(r, 16)) {
    case 0: /* a row again, elsewhere */
        put_bytes(w, text, lines[k + 1]);
        put_bytes(w, text + from, to - from);
        put_bytes(w, text + lines[k + 1], size - lines[k + 1]);
        break;
    case 1: /* a row less */
        put_bytes(w, text, from);
        put_bytes(w, text + to, size - to);
        break;
    case 2: case 3: /* an option more */
        while (to > from && (text[to - 1] == '\n' || text[to - 1] == '\r')) to--;
        put_bytes(w, text, to);
        put_option(w, r);
        put_bytes(w, text + to, size - to);
        break;
    case 4: /* two rows change places */
        if (i > k) { line = i; i = k; k = line; }
        if (i == k) { change_number(text, size, r, w); break; }
        put_bytes(w, text, lines[i]);
        put_bytes(w, text + lines[k], lines[k + 1] - lines[k]);
        put_bytes(w, text + lines[i + 1], lines[k] - lines[i + 1]);
        put_bytes(w, text + lines[i], lines[i + 1] - lines[i]);
        put_bytes(w, text + lines[k + 1], size - lines[k + 1]);
        break;
    case 5: /* a word less */
        for (tries = 0; tries < 8 && to > from; tries++) {
            size_t at = from + (size_t)(next(r) % (to - from));
            if (text[at] != ' ') continue;
            put_bytes(w, text, at);
            while (++at < to && text[at] != ' ' && text[at] != '\n') {}
            put_bytes(w, text + at, size - at);
            return;
        }
        put_bytes(w, text, size);
        break;
    case 6: /* another medium */
        put_bytes(w, text, from);
        put_number(w, rounded(r, -100, 100) + 0.001);
        put(w, " ");
        put_number(w, rounded(r, 0, 9));
        put(w, " ");
        put_medium(w, r);
        if (below(r, 2)) put_option(w, r);
        put(w, "\n");
        if (below(r, 2)) from = to;
        put_bytes(w, text + from, size - from);
        break;
    case 7:
        if (below(r, 4)) change_number(text, size, r, w);
        else put_lens(w, r);
        break;
    default: change_number(text, size, r, w); break;
    }
}

static int is_lens(const char *text, size_t size)
{
    static lflare_prescription p;
    static lflare_lens lens;
    return lflare_text_read(text, size, &p, NULL) == LFLARE_OK && lflare_lens_derive(&p, &lens, NULL) == LFLARE_OK;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    static words a, b;
    rng r;
    int32_t times, tries;
    r.state = seed;
#ifndef FUZZ_MAIN
    if (below(&r, 12) == 0) return LLVMFuzzerMutate(data, size, max_size);
#endif
    for (tries = below(&r, 4) ? 6 : 1; tries > 0; tries--) { /* most that break the lens are thrown away */
        a.size = 0;
        if (size < 12 || size > sizeof a.bytes / 2 || below(&r, 40) == 0 || (below(&r, 4) && !is_lens((const char *)data, size))) put_lens(&a, &r);
        else put_bytes(&a, (const char *)data, size);
        for (times = 1 + below(&r, 3); times > 0; times--) {
            mutate_once(a.bytes, a.size, &r, &b);
            a.size = 0;
            put_bytes(&a, b.bytes, b.size);
        }
        if (is_lens(a.bytes, a.size)) break;
    }
    if (a.size > max_size) a.size = max_size;
    memcpy(data, a.bytes, a.size);
    return a.size;
}

/* The head of one, rows of both. */
size_t LLVMFuzzerCustomCrossOver(const uint8_t *a, size_t a_size, const uint8_t *b, size_t b_size, uint8_t *out, size_t max_size, unsigned int seed)
{
    static words w;
    static size_t la[600], lb[600];
    int32_t na, nb, i, k;
    rng r;
    r.state = seed;
    w.size = 0;
    na = find_lines((const char *)a, a_size, la, 600);
    nb = find_lines((const char *)b, b_size, lb, 600);
    i = below(&r, na + 1);
    k = below(&r, nb + 1);
    put_bytes(&w, (const char *)a, la[i]);
    put_bytes(&w, (const char *)b + lb[k], b_size - lb[k]);
    if (w.size > max_size) w.size = max_size;
    memcpy(out, w.bytes, w.size);
    return w.size;
}

#ifdef FUZZ_MAIN
int main(int argc, char **argv)
{
    const char *rounds_text = getenv("FUZZ_ROUNDS"), *dump = getenv("FUZZ_DUMP");
    int rounds = rounds_text != NULL ? atoi(rounds_text) : 0, i, k;
    for (i = 1; i < argc; i++) {
        static uint8_t original[TEXT], buffer[TEXT];
        size_t size, whole;
        uint8_t *exact;
        FILE *file = fopen(argv[i], "rb");
        if (file == NULL) {
            fprintf(stderr, "%s: cannot be opened\n", argv[i]);
            return 1;
        }
        size = whole = fread(original, 1, sizeof original, file);
        memcpy(buffer, original, size);
        fclose(file);
        for (k = 0; k <= rounds; k++) {
            if (k % 8 == 0) memcpy(buffer, original, size = whole);
            if (k > 0) size = LLVMFuzzerCustomMutator(buffer, size, sizeof buffer / 2, (unsigned int)(i * 1000 + k));
            exact = (uint8_t *)malloc(size > 0 ? size : 1); /* so that a byte too far is seen */
            if (exact == NULL) return 1;
            memcpy(exact, buffer, size);
            if (dump != NULL && (file = fopen(dump, "wb")) != NULL) { /* the last one written is the one that failed */
                fwrite(exact, 1, size, file);
                fclose(file);
            }
            LLVMFuzzerTestOneInput(exact, size);
            free(exact);
        }
    }
    print_counts();
    return 0;
}
#endif
