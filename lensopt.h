/* lensopt.h - v0.1.0 - edits a lens for its flare, and searches for one
   Optional companion of lensflare.h, under the same two licences (MIT or the Unlicense, at the end of lensflare.h).

   Do this in *one* C or C++ file to create the implementation, and include it plainly everywhere else:

       #define LENSOPT_IMPLEMENTATION
       #include "lensopt.h"

   It includes lensflare.h's declarations and calls its public stages only; one file of the program must hold the
   implementation of that, too. LENSOPT_API, before that line: your own linkage; LENSOPT_STATIC: every function static.

   Needs libc and libm. No globals, no output, no exit. All lengths are millimetres, angles radians, wavelengths nanometres. */

/* >> 0 documentation */
/*
   CONTENTS (the lines that begin each room; grep for "[>]>")

       >> 0 documentation
       >> 1 public interface
       >> 2 spots
       >> 3 edit
       >> 4 colour
       >> 5 target

   THE TARGET FORMAT

   What a flare should look like: lights, ghosts, and where each ghost's spot should be for each light. Lines, comments, blanks and numbers are
   as in prescriptions (lensflare.h, THE PRESCRIPTION FORMAT). The first statement is the version.

       file      = { [ statement ] [ "#" comment ] newline }
       statement = "lensopt" "1"
                 | "name" text
                 | "sensor" width height                          mm: the frame; once, before the ghosts
                 | "light" right up [ "weight" w ]                degrees from the axis; at least one, before the ghosts
                 | "ghost" [ i "," j [ "," k "," l ] ] { "color" r g b | "weight" w }
                 | "spot" centre radius | "spot" "hidden" | "spot" "any"
                 | "lock" "stop" { "radius" | "place" }
                 | "lock" surface { "radius" | "gap" | "medium" | "coating" }

   Surfaces count from 1. i,j are the reflecting surfaces, in the order of time, of the ghost that this one was picked from; without them it
   was made from nothing. A ghost is followed by a spot for each light, in the lights' order: centre and radius in mm (lensopt_spot), or hidden,
   if nothing of it should be seen there, or any. color is linear RGB, only its ratios count; without it any colour does. Weights are 1
   where nothing is said. Locks keep what a lens that is searched from has there.
*/

#ifndef LENSOPT_H
#define LENSOPT_H

/* >> 1 public interface */

#include "lensflare.h"

#ifndef LENSOPT_API
#if defined(LENSOPT_STATIC) && defined(__GNUC__)
#define LENSOPT_API static __attribute__((unused))
#elif defined(LENSOPT_STATIC)
#define LENSOPT_API static
#elif defined(__cplusplus)
#define LENSOPT_API extern "C"
#else
#define LENSOPT_API extern
#endif
#endif

/* ---- spots: what a lens shows ---- */

/* A ghost's image on the sensor for one light: all lie on the line through the centre and the light's image. */
typedef struct lensopt_spot {
    double centre;                        /* along that line, positive on the light's side */
    double radius;                        /* of a circle of the same area; 0 if nothing passes */
    double irradiance[LFLARE_WAVELENGTHS];/* its mean, over the light's; before it is laid over the frame */
    lflare_clip clip;                     /* what bounds it */
} lensopt_spot;

/* The spots of `count` ghosts of a lens (lflare_ghost_list), paraxially, at 510 nm, for a light whose direction is `u` >= 0 from the
   axis (its tangent), through a round iris of radius `iris` on the stop plane. out: count. Allocates nothing. */
LENSOPT_API lflare_result lensopt_spots(const lflare_lens *lens, const lflare_pair *pairs, int32_t count, double u, double iris, lensopt_spot *out);

/* ---- target: what a flare should look like ---- */

enum {
    LENSOPT_MAX_LIGHTS = 8,
    LENSOPT_MAX_GHOSTS = 1024 /* of a target */
};

typedef enum lensopt_wish { LENSOPT_SPOT = 0, LENSOPT_SPOT_HIDDEN, LENSOPT_SPOT_ANY } lensopt_wish;

/* Where a ghost should be for one light. */
typedef struct lensopt_goal {
    lensopt_wish wish;
    double centre, radius; /* as in lensopt_spot; radius > 0. 0 unless wish is LENSOPT_SPOT */
} lensopt_goal;

typedef struct lensopt_ghost {
    lflare_pair pair;      /* whose spots it was picked from, from 0; first -1: made from nothing */
    double color[3];       /* linear, only ratios count; all 0: any */
    double weight;         /* >= 0 */
    lensopt_goal goals[LENSOPT_MAX_LIGHTS];
} lensopt_ghost;

typedef struct lensopt_light {
    double direction[2];   /* degrees from the axis, right and up, each within (-90, 90): tangents add */
    double weight;         /* >= 0 */
} lensopt_light;

/* Bits of lensopt_target.locks[surface]; the last two stand at the stop's row alone. */
enum { LENSOPT_LOCK_RADIUS = 1, LENSOPT_LOCK_GAP = 2, LENSOPT_LOCK_MEDIUM = 4, LENSOPT_LOCK_COATING = 8 };
enum { LENSOPT_LOCK_STOP_RADIUS = 1, LENSOPT_LOCK_STOP_PLACE = 2 };

/* Plain data, 270 KB, copied by assignment. */
typedef struct lensopt_target {
    char name[96];
    double sensor_width, sensor_height; /* > 0 */
    int32_t light_count, ghost_count;   /* at least one of each */
    uint8_t stop_locks, locks[LFLARE_MAX_SURFACES];
    lensopt_light lights[LENSOPT_MAX_LIGHTS];
    lensopt_ghost ghosts[LENSOPT_MAX_GHOSTS];
} lensopt_target;

/* The tangent of a light's angle from the axis, the `u` of lensopt_spots. */
LENSOPT_API double lensopt_slope(const lensopt_light *light);

/* Fills a target with what a lens shows through a round iris of radius `iris` for light_count lights: every ghost of lflare_ghost_list
   that any of them shows, its spots there (hidden where nothing passes) and its colour at the first that does. Change it as you like
   from there. LFLARE_ERROR_LIMIT if the lens has more ghosts than a target takes. error may be NULL. */
LENSOPT_API lflare_result lensopt_target_of(const lflare_lens *lens, const lensopt_light *lights, int32_t light_count, double iris, lensopt_target *out,
                                            lflare_error *error);

/* Whether a target is one: counts, ranges, everything finite. error (may be NULL) names the ghost or light, from 1. */
LENSOPT_API lflare_result lensopt_target_check(const lensopt_target *target, lflare_error *error);

/* Reads `size` bytes of text (see THE TARGET FORMAT) into a target that lensopt_target_check accepts. Any bytes are safe; on error *out is
   unspecified and *error (may be NULL) says where. Linear in size, allocates nothing. */
LENSOPT_API lflare_result lensopt_target_read(const char *text, size_t size, lensopt_target *out, lflare_error *error);

/* Writes it so that lensopt_target_read gives back the same values, to the bit; *size as in lflare_text_write. */
LENSOPT_API lflare_result lensopt_target_write(const lensopt_target *target, char *text, size_t *size);

#endif /* LENSOPT_H */

/* ---------------------------------------------------------------------------------------------------------------------
   Stop here if you only want to use it. What follows is the implementation, room after room in the data's order; each
   room knows only the rooms above it. */

#ifdef LENSOPT_IMPLEMENTATION
#ifndef LENSOPT_IMPLEMENTED
#define LENSOPT_IMPLEMENTED

#include <math.h>
#include <string.h>

/* LENSOPT_STATIC leaves declared what a program does not call, which is not worth a warning. */
#if defined(LENSOPT_STATIC) && defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#define LENSOPT__PI 3.14159265358979323846

/* >> 2 spots */

static const double lensopt__nm[LFLARE_WAVELENGTHS] = {650, 510, 475}; /* of lensflare.h's channels (P 10) */

static void lensopt__spot(const lflare_lens *lens, lflare_pair pair, const lflare_matrix *m, double u, double iris, lensopt_spot *out)
{
    lflare_region region;
    int32_t k;
    memset(out, 0, sizeof *out);
    out->clip = lflare_ghost_clip(lens, lensopt__nm[1], pair, iris, u, &region);
    out->centre = m->a * region.centroid + m->b * u + 0.0; /* no negative zero */
    if (out->clip == LFLARE_CLIP_HIDDEN || !(region.area > 0)) return;
    out->radius = fabs(m->a) * sqrt(region.area / LENSOPT__PI);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++)
        out->irradiance[k] = lflare_ghost_weight(lens, lensopt__nm[k], pair, region.centroid, u) / sqrt(1 + u * u) / fmax(m->a * m->a, 1e-12);
}

LENSOPT_API lflare_result lensopt_spots(const lflare_lens *lens, const lflare_pair *pairs, int32_t count, double u, double iris, lensopt_spot *out)
{
    enum { BLOCK = 64 };
    lflare_ghost_matrices m[BLOCK];
    lflare_result result = LFLARE_OK;
    int32_t g, k, some;
    if (lens == NULL || count < 0 || (count > 0 && (pairs == NULL || out == NULL)) || !(u >= 0 && u < 1e6) || !(iris > 0 && iris < 1e9)) return LFLARE_ERROR_ARGUMENT;
    for (g = 0; g < count && result == LFLARE_OK; g += some) {
        some = count - g < BLOCK ? count - g : BLOCK;
        result = lflare_ghost_optics(lens, lensopt__nm[1], pairs + g, some, m);
        for (k = 0; k < some && result == LFLARE_OK; k++) lensopt__spot(lens, pairs[g + k], &m[k].m, u, iris, &out[g + k]);
    }
    return result;
}

/* >> 5 target */

LENSOPT_API double lensopt_slope(const lensopt_light *light)
{
    double x = tan(light->direction[0] * (LENSOPT__PI / 180)), y = tan(light->direction[1] * (LENSOPT__PI / 180));
    return sqrt(x * x + y * y);
}

/* Puts together what an error says. */
static void lensopt__say(lflare_error *error, const char *text)
{
    size_t at = strlen(error->text), i;
    for (i = 0; text[i] != 0 && at + 1 < sizeof error->text; i++, at++) error->text[at] = text[i] < 32 || text[i] > 126 ? '?' : text[i];
    error->text[at] = 0;
}

/* "<what> <number>: <why>", or without a number if it is 0. */
static lflare_result lensopt__refuse(lflare_error *error, lflare_result code, const char *what, int32_t number, const char *why)
{
    char digits[32];
    if (error == NULL) return code;
    memset(error, 0, sizeof *error);
    error->code = code;
    lensopt__say(error, what);
    if (number > 0) {
        digits[lflare_number_write(number, digits)] = 0;
        lensopt__say(error, " ");
        lensopt__say(error, digits);
    }
    lensopt__say(error, ": ");
    lensopt__say(error, why);
    return code;
}

static int lensopt__within(double x, double lo, double hi) { return x >= lo && x <= hi; } /* no number is not */

static const char *lensopt__light_fault(const lensopt_light *l)
{
    int32_t i;
    for (i = 0; i < 2; i++)
        if (!(l->direction[i] > -90 && l->direction[i] < 90)) return "expected a direction within 90 degrees of the axis";
    return lensopt__within(l->weight, 0, 1e9) ? NULL : "expected a weight from 0 to 1e9";
}

/* NULL, or what a path should be. */
static const char *lensopt__pair_fault(const lflare_pair *p)
{
    if (p->first >= LFLARE_MAX_SURFACES || p->second < 0 || p->second >= p->first) return "surfaces I,J from 1 to 128 with I behind J";
    if ((p->third != 0 || p->fourth != 0) && (p->third >= LFLARE_MAX_SURFACES || p->third <= p->second || p->fourth < 0 || p->fourth >= p->third)) return "surfaces I,J,K,L from 1 to 128 with K behind J and L in front of K";
    return NULL;
}

static const char *lensopt__ghost_fault(const lensopt_target *t, const lensopt_ghost *g)
{
    int32_t i;
    if (g->pair.first != -1 && lensopt__pair_fault(&g->pair) != NULL) return "expected a path: each reflection backwards behind the last one forwards, each forwards in front of it";
    for (i = 0; i < 3; i++)
        if (!lensopt__within(g->color[i], 0, 1e9)) return "expected a color of three numbers from 0 to 1e9";
    if (!lensopt__within(g->weight, 0, 1e9)) return "expected a weight from 0 to 1e9";
    for (i = 0; i < t->light_count; i++) {
        const lensopt_goal *goal = &g->goals[i];
        if ((int)goal->wish < LENSOPT_SPOT || (int)goal->wish > LENSOPT_SPOT_ANY) return "a spot's wish is none of lensopt_wish";
        if (goal->wish != LENSOPT_SPOT) continue;
        if (!lensopt__within(goal->centre, -1e6, 1e6)) return "expected a spot's centre within 1e6 mm";
        if (!lensopt__within(goal->radius, 1e-6, 1e6)) return "expected a spot's radius from 1e-6 to 1e6 mm; of what should not be seen the spot is hidden";
    }
    return NULL;
}

LENSOPT_API lflare_result lensopt_target_check(const lensopt_target *t, lflare_error *error)
{
    const char *fault;
    int32_t i;
    if (t == NULL) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "target", 0, "it is NULL");
    if (!lensopt__within(t->sensor_width, 1e-3, 1e5) || !lensopt__within(t->sensor_height, 1e-3, 1e5)) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "sensor", 0, "expected a width and a height from 0.001 to 1e5 mm");
    if (t->light_count < 1 || t->light_count > LENSOPT_MAX_LIGHTS) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "lights", 0, "expected 1 to 8 of them");
    if (t->ghost_count < 1 || t->ghost_count > LENSOPT_MAX_GHOSTS) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "ghosts", 0, "expected 1 to 1024 of them");
    for (i = 0; i < t->light_count; i++)
        if ((fault = lensopt__light_fault(&t->lights[i])) != NULL) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "light", i + 1, fault);
    for (i = 0; i < t->ghost_count; i++)
        if ((fault = lensopt__ghost_fault(t, &t->ghosts[i])) != NULL) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "ghost", i + 1, fault);
    return LFLARE_OK;
}

/* A ghost's spots for all lights; 0 if none shows it. */
static int lensopt__pick(const lflare_lens *lens, lflare_pair pair, const lensopt_target *t, double iris, lensopt_ghost *g)
{
    lensopt_spot spot;
    int32_t i, k;
    int seen = 0;
    memset(g, 0, sizeof *g);
    g->pair = pair;
    g->weight = 1;
    for (i = 0; i < t->light_count; i++) {
        lensopt_goal *goal = &g->goals[i];
        lensopt_spots(lens, &pair, 1, lensopt_slope(&t->lights[i]), iris, &spot);
        goal->wish = spot.radius >= 1e-6 && spot.radius <= 1e6 && fabs(spot.centre) <= 1e6 ? LENSOPT_SPOT : LENSOPT_SPOT_HIDDEN;
        if (goal->wish == LENSOPT_SPOT_HIDDEN) continue;
        goal->centre = spot.centre;
        goal->radius = spot.radius;
        for (k = 0; k < 3 && !seen; k++) g->color[k] = spot.irradiance[k];
        seen = 1;
    }
    return seen;
}

LENSOPT_API lflare_result lensopt_target_of(const lflare_lens *lens, const lensopt_light *lights, int32_t light_count, double iris, lensopt_target *out,
                                            lflare_error *error)
{
    static const char few[] = "none of the lights shows any: give lights nearer to the axis, or a larger iris";
    lflare_pair pairs[LENSOPT_MAX_GHOSTS];
    const char *fault;
    int32_t i, count = LENSOPT_MAX_GHOSTS;
    if (lens == NULL || out == NULL || lights == NULL) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "target", 0, "lens, lights and out may not be NULL");
    if (light_count < 1 || light_count > LENSOPT_MAX_LIGHTS) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "lights", 0, "expected 1 to 8 of them");
    if (!lensopt__within(iris, 1e-9, 1e6)) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "iris", 0, "expected a radius up to 1e6 mm");
    memset(out, 0, sizeof *out);
    memcpy(out->name, lens->prescription.name, sizeof out->name);
    out->sensor_width = lens->sensor_width;
    out->sensor_height = lens->sensor_height;
    for (i = 0; i < light_count; i++) {
        if ((fault = lensopt__light_fault(&lights[i])) != NULL) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "light", i + 1, fault);
        out->lights[out->light_count++] = lights[i];
    }
    if (lflare_ghost_list(lens, pairs, &count) == LFLARE_INCOMPLETE) return lensopt__refuse(error, LFLARE_ERROR_LIMIT, "ghosts", count, "so many the lens has, a target takes 1024");
    for (i = 0; i < count; i++) out->ghost_count += lensopt__pick(lens, pairs[i], out, iris, &out->ghosts[out->ghost_count]);
    return out->ghost_count > 0 ? LFLARE_OK : lensopt__refuse(error, LFLARE_ERROR_LENS, "ghosts", 0, few);
}

/* -- reading -- */

/* The text and a word of it. A fault, once there, stays. */
typedef struct lensopt__reader {
    const char *at, *end, *line_begin, *word;
    size_t size;            /* of the word; 0: the line has no more */
    int32_t line, column;   /* of the word */
    lflare_error *error;
    lflare_result result;
} lensopt__reader;

static void lensopt__fault(lensopt__reader *r, const char *expected)
{
    lflare_error local, *e = r->error != NULL ? r->error : &local;
    char word[33];
    size_t n = r->size < 32 ? r->size : 32;
    if (r->result != LFLARE_OK) return;
    r->result = LFLARE_ERROR_SYNTAX;
    memset(e, 0, sizeof *e);
    e->code = r->result;
    e->line = r->line;
    e->column = r->column;
    memcpy(word, r->word, n);
    word[n] = 0;
    lensopt__say(e, "expected ");
    lensopt__say(e, expected);
    lensopt__say(e, n == 0 ? ", found the end of the line" : ", found '");
    if (n > 0) lensopt__say(e, word);
    if (n > 0) lensopt__say(e, r->size > n ? "...'" : "'");
}

static int lensopt__ends(const lensopt__reader *r) { return r->at == r->end || *r->at == '\n' || *r->at == '\r' || *r->at == '#'; }

/* The next word of the line; 0 if there is none. */
static int lensopt__next(lensopt__reader *r)
{
    while (!lensopt__ends(r) && (*r->at == ' ' || *r->at == '\t')) r->at++;
    r->word = r->at;
    r->column = (int32_t)(r->at - r->line_begin) + 1;
    while (!lensopt__ends(r) && *r->at != ' ' && *r->at != '\t') r->at++;
    r->size = (size_t)(r->at - r->word);
    return r->size > 0;
}

/* To the next line; 0 behind the last. */
static int lensopt__next_line(lensopt__reader *r)
{
    while (r->at < r->end && *r->at != '\n' && *r->at != '\r') r->at++;
    if (r->at == r->end) return 0;
    r->at += *r->at == '\r' && r->end - r->at > 1 && r->at[1] == '\n' ? 2 : 1;
    r->line++;
    r->line_begin = r->at;
    return 1;
}

static int lensopt__is(const lensopt__reader *r, const char *word) { return strlen(word) == r->size && memcmp(word, r->word, r->size) == 0; }

static double lensopt__number(lensopt__reader *r, const char *expected, double lo, double hi)
{
    double v = 0;
    if (r->result != LFLARE_OK) return lo;
    if (!lensopt__next(r) || !lflare_number_read(r->word, r->size, &v) || !lensopt__within(v, lo, hi)) lensopt__fault(r, expected);
    return v;
}

static void lensopt__read_name(lensopt__reader *r, lensopt_target *t)
{
    size_t n = 0;
    lensopt__next(r);
    r->at = r->word;
    while (!lensopt__ends(r)) r->at++;
    r->size = (size_t)(r->at - r->word);
    while (r->size > 0 && (r->word[r->size - 1] == ' ' || r->word[r->size - 1] == '\t')) r->size--;
    if (r->size == 0 || r->size >= sizeof t->name || t->name[0] != 0) {
        lensopt__fault(r, t->name[0] != 0 ? "one name only" : "a name of 1 to 95 bytes");
        return;
    }
    for (n = 0; n < r->size && (uint8_t)r->word[n] >= 32 && r->word[n] != 127; n++) t->name[n] = r->word[n];
    if (n < r->size) lensopt__fault(r, "a name without control characters");
}

static void lensopt__read_light(lensopt__reader *r, lensopt_target *t)
{
    lensopt_light *l = &t->lights[t->light_count];
    int32_t i;
    if (t->ghost_count > 0) lensopt__fault(r, "lights before the ghosts");
    else if (t->light_count == LENSOPT_MAX_LIGHTS) lensopt__fault(r, "at most 8 lights");
    for (i = 0; i < 2; i++) l->direction[i] = lensopt__number(r, "degrees between -90 and 90: light RIGHT UP", -89.999999, 89.999999);
    l->weight = 1;
    while (r->result == LFLARE_OK && lensopt__next(r)) {
        if (lensopt__is(r, "weight")) l->weight = lensopt__number(r, "a weight from 0 to 1e9", 0, 1e9);
        else lensopt__fault(r, "weight");
    }
    t->light_count += r->result == LFLARE_OK;
}

/* i,j or i,j,k,l as the word that is there. */
static void lensopt__read_pair(lensopt__reader *r, lensopt_ghost *g)
{
    int32_t v[4] = {0, 0, 0, 0}, n = 0;
    size_t i;
    for (i = 0; i < r->size && n < 4; i++) {
        if (r->word[i] >= '0' && r->word[i] <= '9' && v[n] < 1000) v[n] = 10 * v[n] + (r->word[i] - '0');
        else if (r->word[i] == ',' && v[n] > 0 && i + 1 < r->size) n++;
        else break;
    }
    if (i < r->size || v[n & 3] == 0 || (n != 1 && n != 3)) {
        lensopt__fault(r, "surfaces I,J or I,J,K,L, counted from 1");
        return;
    }
    g->pair.first = v[0] - 1;
    g->pair.second = v[1] - 1;
    if (n == 3) {
        g->pair.third = v[2] - 1;
        g->pair.fourth = v[3] - 1;
    }
    if (lensopt__pair_fault(&g->pair) != NULL) lensopt__fault(r, lensopt__pair_fault(&g->pair));
}

static void lensopt__read_ghost(lensopt__reader *r, lensopt_target *t)
{
    lensopt_ghost *g = &t->ghosts[t->ghost_count];
    int32_t i;
    if (t->light_count == 0) lensopt__fault(r, "a light before the ghosts");
    else if (t->ghost_count == LENSOPT_MAX_GHOSTS) lensopt__fault(r, "at most 1024 ghosts");
    if (r->result != LFLARE_OK) return;
    g->pair.first = -1;
    g->weight = 1;
    while (r->result == LFLARE_OK && lensopt__next(r)) {
        if (r->word[0] >= '0' && r->word[0] <= '9') lensopt__read_pair(r, g);
        else if (lensopt__is(r, "weight")) g->weight = lensopt__number(r, "a weight from 0 to 1e9", 0, 1e9);
        else if (lensopt__is(r, "color"))
            for (i = 0; i < 3; i++) g->color[i] = lensopt__number(r, "three numbers from 0 to 1e9: color R G B", 0, 1e9);
        else lensopt__fault(r, "surfaces I,J, color or weight");
    }
    t->ghost_count++;
}

static void lensopt__read_spot(lensopt__reader *r, lensopt_target *t, int32_t spot)
{
    lensopt_goal *goal;
    if (t->ghost_count == 0 || spot >= t->light_count) {
        lensopt__fault(r, t->ghost_count == 0 ? "a ghost before its spots" : "no more spots than lights");
        return;
    }
    goal = &t->ghosts[t->ghost_count - 1].goals[spot];
    if (!lensopt__next(r)) lensopt__fault(r, "CENTRE RADIUS, hidden or any");
    else if (lensopt__is(r, "hidden")) goal->wish = LENSOPT_SPOT_HIDDEN;
    else if (lensopt__is(r, "any")) goal->wish = LENSOPT_SPOT_ANY;
    else {
        r->at = r->word;
        goal->centre = lensopt__number(r, "a centre within 1e6 mm, hidden or any", -1e6, 1e6);
        goal->radius = lensopt__number(r, "a radius from 1e-6 to 1e6 mm", 1e-6, 1e6);
    }
    if (r->result == LFLARE_OK && lensopt__next(r)) lensopt__fault(r, "the end of the line");
}

static void lensopt__read_lock(lensopt__reader *r, lensopt_target *t)
{
    static const char *const words[2][4] = {{"radius", "gap", "medium", "coating"}, {"radius", "place", "", ""}};
    double surface = 0;
    int32_t i, stop;
    uint8_t *locks;
    lensopt__next(r);
    stop = lensopt__is(r, "stop");
    if (!stop && !(lflare_number_read(r->word, r->size, &surface) && surface == floor(surface) && lensopt__within(surface, 1, LFLARE_MAX_SURFACES))) lensopt__fault(r, "stop or a surface from 1 to 128");
    if (r->result != LFLARE_OK) return;
    locks = stop ? &t->stop_locks : &t->locks[(int32_t)surface - 1];
    if (!lensopt__next(r)) lensopt__fault(r, stop ? "radius or place" : "radius, gap, medium or coating");
    for (; r->result == LFLARE_OK && r->size > 0; lensopt__next(r)) {
        for (i = 0; i < 4 && !lensopt__is(r, words[stop][i]); i++) {}
        if (i == 4) lensopt__fault(r, stop ? "radius or place" : "radius, gap, medium or coating");
        else *locks = (uint8_t)(*locks | 1 << i);
    }
}

/* The statement whose first word is there; *spots: of the last ghost so far. */
static void lensopt__read_statement(lensopt__reader *r, lensopt_target *t, int32_t *spots)
{
    int more = lensopt__is(r, "spot");
    if (!more && t->ghost_count > 0 && *spots < t->light_count && !lensopt__is(r, "lock")) lensopt__fault(r, "a spot for each light");
    else if (lensopt__is(r, "name")) lensopt__read_name(r, t);
    else if (lensopt__is(r, "light")) lensopt__read_light(r, t);
    else if (lensopt__is(r, "lock")) lensopt__read_lock(r, t);
    else if (more) lensopt__read_spot(r, t, (*spots)++);
    else if (lensopt__is(r, "ghost")) {
        *spots = 0;
        lensopt__read_ghost(r, t);
    } else if (lensopt__is(r, "sensor") && t->sensor_width == 0) {
        t->sensor_width = lensopt__number(r, "a width from 0.001 to 1e5 mm", 1e-3, 1e5);
        t->sensor_height = lensopt__number(r, "a height from 0.001 to 1e5 mm", 1e-3, 1e5);
        if (r->result == LFLARE_OK && lensopt__next(r)) lensopt__fault(r, "the end of the line");
    } else lensopt__fault(r, "name, sensor (once), light, ghost, spot or lock");
}

LENSOPT_API lflare_result lensopt_target_read(const char *text, size_t size, lensopt_target *out, lflare_error *error)
{
    lensopt__reader r;
    int32_t spots = 0;
    int begun = 0;
    if (out == NULL || (text == NULL && size > 0)) return lensopt__refuse(error, LFLARE_ERROR_ARGUMENT, "target", 0, "text and out may not be NULL");
    memset(out, 0, sizeof *out);
    memset(&r, 0, sizeof r);
    r.at = r.line_begin = r.word = size > 0 ? text : "";
    r.end = r.at + size;
    r.line = 1;
    r.error = error;
    do {
        if (!lensopt__next(&r)) continue;
        if (begun) lensopt__read_statement(&r, out, &spots);
        else if (!lensopt__is(&r, "lensopt") || lensopt__number(&r, "version 1", 1, 1) != 1) lensopt__fault(&r, "lensopt 1, the format's version, before anything else");
        begun = 1;
    } while (r.result == LFLARE_OK && lensopt__next_line(&r));
    if (r.result != LFLARE_OK) return r.result;
    r.word = r.at;
    r.size = 0;
    r.column = 1;
    if (!begun) lensopt__fault(&r, "lensopt 1, the format's version, before anything else");
    else if (out->sensor_width == 0) lensopt__fault(&r, "sensor WIDTH HEIGHT somewhere");
    else if (out->light_count == 0) lensopt__fault(&r, "at least one light");
    else if (out->ghost_count == 0) lensopt__fault(&r, "at least one ghost");
    else if (spots < out->light_count) lensopt__fault(&r, "a spot for each light");
    if (r.result != LFLARE_OK) return r.result;
    return lensopt_target_check(out, error) == LFLARE_OK ? LFLARE_OK : LFLARE_ERROR_SYNTAX;
}

/* -- writing -- */

typedef struct lensopt__writer {
    char *at;
    size_t room, size;
} lensopt__writer;

static void lensopt__put(lensopt__writer *w, const char *text)
{
    for (; *text != 0; text++, w->size++)
        if (w->size < w->room) w->at[w->size] = *text;
}

static void lensopt__put_number(lensopt__writer *w, double v)
{
    char number[33];
    number[0] = ' ';
    number[1 + lflare_number_write(v, number + 1)] = 0;
    lensopt__put(w, number);
}

static void lensopt__put_ghost(lensopt__writer *w, const lensopt_target *t, const lensopt_ghost *g)
{
    int32_t i;
    lensopt__put(w, "ghost");
    if (g->pair.first >= 0) {
        const int32_t surfaces[4] = {g->pair.first, g->pair.second, g->pair.third, g->pair.fourth};
        int32_t count = g->pair.third != 0 || g->pair.fourth != 0 ? 4 : 2;
        for (i = 0; i < count; i++) {
            char number[33];
            number[lflare_number_write(surfaces[i] + 1, number)] = 0;
            lensopt__put(w, i == 0 ? " " : ",");
            lensopt__put(w, number);
        }
    }
    if (g->color[0] + g->color[1] + g->color[2] > 0) {
        lensopt__put(w, " color");
        for (i = 0; i < 3; i++) lensopt__put_number(w, g->color[i]);
    }
    if (g->weight != 1) {
        lensopt__put(w, " weight");
        lensopt__put_number(w, g->weight);
    }
    for (i = 0; i < t->light_count; i++) {
        const lensopt_goal *goal = &g->goals[i];
        lensopt__put(w, goal->wish == LENSOPT_SPOT ? "\n  spot" : goal->wish == LENSOPT_SPOT_HIDDEN ? "\n  spot hidden" : "\n  spot any");
        if (goal->wish != LENSOPT_SPOT) continue;
        lensopt__put_number(w, goal->centre);
        lensopt__put_number(w, goal->radius);
    }
    lensopt__put(w, "\n");
}

static void lensopt__put_locks(lensopt__writer *w, const lensopt_target *t)
{
    static const char *const words[4] = {" radius", " gap", " medium", " coating"};
    int32_t i, k;
    if (t->stop_locks != 0) {
        lensopt__put(w, "lock stop");
        if (t->stop_locks & LENSOPT_LOCK_STOP_RADIUS) lensopt__put(w, " radius");
        if (t->stop_locks & LENSOPT_LOCK_STOP_PLACE) lensopt__put(w, " place");
        lensopt__put(w, "\n");
    }
    for (i = 0; i < LFLARE_MAX_SURFACES; i++) {
        if ((t->locks[i] & 15) == 0) continue;
        lensopt__put(w, "lock");
        lensopt__put_number(w, i + 1);
        for (k = 0; k < 4; k++)
            if (t->locks[i] >> k & 1) lensopt__put(w, words[k]);
        lensopt__put(w, "\n");
    }
}

static void lensopt__put_name(lensopt__writer *w, const char *name, size_t room)
{
    char clean[96];
    size_t i, n = 0;
    for (i = 0; i < room && name[i] != 0; i++)
        if (n > 0 || (uint8_t)name[i] > 32) clean[n++] = (uint8_t)name[i] < 32 || name[i] == 127 || name[i] == '#' ? ' ' : name[i];
    while (n > 0 && clean[n - 1] == ' ') n--;
    if (n == 0) return;
    clean[n] = 0;
    lensopt__put(w, "name ");
    lensopt__put(w, clean);
    lensopt__put(w, "\n");
}

LENSOPT_API lflare_result lensopt_target_write(const lensopt_target *t, char *text, size_t *size)
{
    lensopt__writer w;
    int32_t i;
    if (size == NULL || (text == NULL && *size > 0) || lensopt_target_check(t, NULL) != LFLARE_OK) return LFLARE_ERROR_ARGUMENT;
    w.at = text;
    w.room = *size;
    w.size = 0;
    lensopt__put(&w, "lensopt 1\n");
    lensopt__put_name(&w, t->name, sizeof t->name - 1);
    lensopt__put(&w, "sensor");
    lensopt__put_number(&w, t->sensor_width);
    lensopt__put_number(&w, t->sensor_height);
    lensopt__put(&w, "\n");
    for (i = 0; i < t->light_count; i++) {
        const lensopt_light *l = &t->lights[i];
        lensopt__put(&w, "light");
        lensopt__put_number(&w, l->direction[0]);
        lensopt__put_number(&w, l->direction[1]);
        if (l->weight != 1) {
            lensopt__put(&w, " weight");
            lensopt__put_number(&w, l->weight);
        }
        lensopt__put(&w, "\n");
    }
    for (i = 0; i < t->ghost_count; i++) lensopt__put_ghost(&w, t, &t->ghosts[i]);
    lensopt__put_locks(&w, t);
    *size = w.size;
    return w.size > w.room ? LFLARE_INCOMPLETE : LFLARE_OK;
}

#endif /* LENSOPT_IMPLEMENTED */
#endif /* LENSOPT_IMPLEMENTATION */
