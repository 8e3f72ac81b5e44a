/* lensopt.h - v0.1.0 - edits a lens for its flare, and writes down what a flare should look like
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

/* ---- edit: a prescription changed for its flare ---- */

/* These change *prescription, which lflare_lens_derive then takes as it takes any. Rows count from 0, the stop among them. They derive
   it before and after, so what they return makes a lens; anything but LFLARE_OK leaves it as it was and puts a sentence into *error
   (may be NULL): LFLARE_ERROR_ARGUMENT for what no lens could do, LFLARE_ERROR_LENS, or what lflare_lens_derive says, for what this one
   cannot. But for coatings what was missing (semi-diameters, stop, sensor, focus) is filled in as derived, so that it does not follow
   the change. Allocate nothing; up to 250 KB of stack; 10 us on a lens of 34 rows. */

/* The iris's full opening times `factor`, and the f-number divided by it: every ghost that it bounds grows or shrinks, and all is as
   much brighter as its area. What other rims bound stays. */
LENSOPT_API lflare_result lensopt_resize_stop(lflare_prescription *prescription, double factor, lflare_error *error);

/* The clear semi-diameters of all rows in front of the stop times `factor`, as if the front group were made so much wider or narrower:
   ghosts that it bounds change. Narrower than the beam on the axis it takes the stop's place and the lens is slower than its f-number;
   off the axis the picture darkens sooner. LFLARE_ERROR_LENS where the stop stands in front of all, or a surface ends before that. */
LENSOPT_API lflare_result lensopt_resize_pupil(lflare_prescription *prescription, double factor, lflare_error *error);

/* The stop into the air behind row `surface`, at `fraction` (0 to 1) of the way to the next surface or the sensor; where it stands already, its own
   row does not count as an end. It passes the same beam on the axis as before: focal length, f-number and sensor stay, its radius
   becomes the marginal ray's height there. Rows between the two places move up or down by one; other pairs than before are ghosts
   (lensopt_changes). Not behind the row of the stop itself. From the front of the lens there is no way back. */
LENSOPT_API lflare_result lensopt_move_stop(lflare_prescription *prescription, int32_t surface, double fraction, lflare_error *error);

typedef enum lensopt_mirrors {
    LENSOPT_MIRRORS_BOTH = 0, /* shared so that the changes' squares add up to the least, to first order */
    LENSOPT_MIRRORS_FIRST,
    LENSOPT_MIRRORS_SECOND
} lensopt_mirrors;

/* The spot (lensopt_spots) of one ghost of two reflections `factor` times as large for slope u >= 0 and iris radius `iris`, by the curvature of
   the surfaces that reflect it: the nearest curvature that does it, to 1e-6, whichever way round the image then is. It is sought outwards from what
   is, as far as both surfaces reach their clear radius and do not newly cross a neighbour there, and the focal length stays within half
   and twice what it was; if that is too near LFLARE_ERROR_LENS, and the sentence says which factors are within and what ends them.
   Focal length, f-number (the iris keeps its radius) and all other ghosts change, too: lensopt_changes says how. The sensor follows where the prescription's focus is set.
   At most 1 ms at 9 rows, 10 ms at 34. */
LENSOPT_API lflare_result lensopt_resize_ghost(lflare_prescription *prescription, lflare_pair pair, double factor, lensopt_mirrors mirrors, double u,
                                               double iris, lflare_error *error);

/* One ghost before and after an edit. */
typedef struct lensopt_change {
    lflare_pair pair_before, pair_after; /* rows differ where the stop has moved past them */
    lensopt_spot before, after;          /* all zeroes where it is no ghost */
    int32_t there;                       /* 1: a ghost before, 2: after, 3: both */
} lensopt_change;

/* Side effects of an edit, by pairs of surfaces (the stop not counted): the ghosts of `before` in their order, then new ones. Both
   lenses have the same number of rows, and their own iris's radius; u >= 0. *count: room in `out` on entry, number on return;
   with less room than both lenses have ghosts LFLARE_INCOMPLETE, that number in *count and nothing in out. Allocates 16 bytes a ghost (LFLARE_ERROR_MEMORY);
   costs two lensopt_spots. */
LENSOPT_API lflare_result lensopt_changes(const lflare_lens *before, double iris_before, const lflare_lens *after, double iris_after, double u,
                                          lensopt_change *out, int32_t *count);

/* A surface's coating: a quarter-wave layer for `nm` (100 to 20000), or one of index n (1 to 10) and a thickness (0.01 to 1e5 nm), or none.
   Makers' single layers and what stacks of several come to lie within 1.38 to 1.9 and 25 to 750 nm (Van Acoleyen 2025, 5.4). A stack
   that it replaces leaves prescription.layers, unless another surface shares it. LFLARE_ERROR_LIMIT where all LFLARE_MAX_LAYERS are taken.
   What is missing stays missing. The image, too, is seen through it. */
LENSOPT_API lflare_result lensopt_coat_quarter(lflare_prescription *prescription, int32_t surface, double nm, lflare_error *error);
LENSOPT_API lflare_result lensopt_coat_layer(lflare_prescription *prescription, int32_t surface, double n, double thickness_nm, lflare_error *error);
LENSOPT_API lflare_result lensopt_coat_bare(lflare_prescription *prescription, int32_t surface, lflare_error *error);

/* ---- colour: what coatings make of a ghost ---- */

enum {
    LENSOPT_COLOUR_STEPS = 186,    /* design wavelengths of a quarter-wave coating: 380 nm, */
    LENSOPT_COLOUR_BEGIN = 380,
    LENSOPT_COLOUR_STEP = 2        /* and every 2 nm up to 750 */
};

/* The colour of a ghost over the quarter-wave coatings of the surfaces that reflect it first and second: W at 650, 510 and 475 nm is
   path * first[i] * second[j], each a product of reflectances and transmittances: light passes both surfaces, too, so that no coating
   but changes both. Plain data, 9 KB. */
typedef struct lensopt_colour_map {
    double path[LFLARE_WAVELENGTHS];    /* over the crossings of all other surfaces */
    double first[LENSOPT_COLOUR_STEPS][LFLARE_WAVELENGTHS], second[LENSOPT_COLOUR_STEPS][LFLARE_WAVELENGTHS];
    double now[LFLARE_WAVELENGTHS];     /* W with the coatings that are there */
    double scale;                       /* irradiance of lensopt_spots over W */
    lflare_clip clip;                   /* LFLARE_CLIP_HIDDEN: none of it is seen for this light */
} lensopt_colour_map;

/* For the ray of slope u >= 0 through the middle of what a round iris of radius `iris` leaves open, paraxially, as lensopt_spots has it.
   Any path that lflare_ghost_optics takes. Allocates nothing; 100 KB of stack; 0.3 ms. */
LENSOPT_API lflare_result lensopt_colour_map_make(const lflare_lens *lens, lflare_pair pair, double u, double iris, lensopt_colour_map *out);

/* W of all combinations, rgb[3 * (LENSOPT_COLOUR_STEPS * j + i)] for first[i] and second[j]: 103,788 floats. */
LENSOPT_API void lensopt_colour_map_floats(const lensopt_colour_map *map, float *rgb);

/* Where a map comes nearest to a colour. */
typedef struct lensopt_colour_point {
    double first_nm, second_nm; /* for lensopt_coat_quarter */
    double rgb[LFLARE_WAVELENGTHS]; /* W there */
    double distance;
} lensopt_colour_point;

/* Distance is that of hues, |target / sum - rgb / sum| over the three channels (Van Acoleyen 2025, 5.6), plus `brightness` >= 0 times
   |ln(sum of rgb / sum of target)|, for which the target is in units of W; 0: hue alone. target[3] >= 0 and not all 0. Of equals the
   first. LFLARE_ERROR_LENS where no combination lets light through. 0.5 ms. */
LENSOPT_API lflare_result lensopt_colour_best(const lensopt_colour_map *map, const double *target, double brightness, lensopt_colour_point *out);

/* Reflectance of a surface as it is coated, at nm[count] wavelengths (100 to 20000), for light whose n sin(angle), the same on both
   sides, is `sine` >= 0: 0 is along the surface's normal. out: count. */
LENSOPT_API lflare_result lensopt_reflectance(const lflare_lens *lens, int32_t surface, double sine, const double *nm, int32_t count, double *out);

/* The same of quarter-wave coatings for design wavelengths nm[count], at the channels' wavelengths 650, 510 and 475 nm. out: 3 * count. */
LENSOPT_API lflare_result lensopt_quarter_reflectance(const lflare_lens *lens, int32_t surface, double sine, const double *nm, int32_t count, double *out);

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
#include <stdarg.h>
#include <stdlib.h>
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

/* >> 3 edit */

static const double lensopt__nm_d = 587.5618; /* at which focal lengths are meant */

/* Six digits are what people read. */
static double lensopt__rounded(double v)
{
    double scale;
    if (!(fabs(v) > 1e-200 && fabs(v) < 1e200)) return v;
    scale = pow(10, 5 - floor(log10(fabs(v))));
    return floor(v * scale + 0.5) / scale;
}

/* %i, %g and %s as printf has them, but with a point in every locale; what is too long is cut off. */
static lflare_result lensopt__fail(lflare_error *error, lflare_result code, const char *format, ...)
{
    va_list list;
    size_t n = 0;
    if (error == NULL) return code;
    memset(error, 0, sizeof *error);
    error->code = code;
    va_start(list, format);
    for (; *format != 0; format++) {
        char written[32];
        const char *piece = written;
        size_t length = 1;
        if (*format != '%') {
            written[0] = *format;
        } else if (*++format == 's') {
            piece = va_arg(list, const char *);
            length = strlen(piece);
        } else {
            length = (size_t)lflare_number_write(*format == 'i' ? va_arg(list, int) : lensopt__rounded(va_arg(list, double)), written);
        }
        for (; length > 0 && n + 1 < sizeof error->text; length--) error->text[n++] = *piece++;
    }
    va_end(list);
    return code;
}

static lflare_result lensopt__derive(const lflare_prescription *p, lflare_lens *lens, lflare_error *error)
{
    if (p == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a prescription was expected, not NULL");
    return lflare_lens_derive(p, lens, error);
}

/* What was edited takes the prescription's place if it makes a lens. */
static lflare_result lensopt__keep(const lflare_prescription *edited, lflare_prescription *p, lflare_error *error)
{
    lflare_lens lens;
    lflare_result result = lflare_lens_derive(edited, &lens, error);
    if (result == LFLARE_OK) *p = lens.prescription;
    return result;
}

static int lensopt__is_factor(double factor) { return factor >= 1e-3 && factor <= 1e3; }

static lflare_result lensopt__bad_factor(lflare_error *error, double factor)
{
    if (!(factor - factor == 0)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a factor from 0.001 to 1000 was expected, not one that is no number");
    return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a factor from 0.001 to 1000 was expected, not %g", factor);
}

LENSOPT_API lflare_result lensopt_resize_stop(lflare_prescription *p, double factor, lflare_error *error)
{
    lflare_lens lens;
    lflare_result result = lensopt__derive(p, &lens, error);
    if (result != LFLARE_OK) return result;
    if (!lensopt__is_factor(factor)) return lensopt__bad_factor(error, factor);
    lens.prescription.surfaces[lens.stop].semi_diameter *= factor;
    lens.prescription.fnumber = lens.fnumber / factor; /* both, since the smaller opening of the two is the lens's */
    return lensopt__keep(&lens.prescription, p, error);
}

LENSOPT_API lflare_result lensopt_resize_pupil(lflare_prescription *p, double factor, lflare_error *error)
{
    lflare_lens lens;
    lflare_result result = lensopt__derive(p, &lens, error);
    int32_t i;
    if (result != LFLARE_OK) return result;
    if (!lensopt__is_factor(factor)) return lensopt__bad_factor(error, factor);
    if (lens.stop == 0) return lensopt__fail(error, LFLARE_ERROR_LENS, "the stop stands in front of all surfaces and is the entrance pupil: resize the stop");
    for (i = 0; i < lens.stop; i++) {
        lflare_surface *s = &lens.prescription.surfaces[i];
        s->semi_diameter *= factor;
        if (!(fabs(lflare_sag(s, s->semi_diameter)) < 1e9)) /* which deriving would quietly reduce */
            return lensopt__fail(error, LFLARE_ERROR_LENS, "row %i would have a clear semi-diameter of %g mm, but its surface ends before that: a smaller factor was expected", i + 1,
                                 s->semi_diameter);
    }
    return lensopt__keep(&lens.prescription, p, error);
}

/* Takes a row out; the gap behind it goes to the one in front. */
static lflare_surface lensopt__take_row(lflare_prescription *p, int32_t at)
{
    lflare_surface row = p->surfaces[at];
    if (at > 0) p->surfaces[at - 1].thickness += row.thickness;
    p->surface_count--;
    memmove(&p->surfaces[at], &p->surfaces[at + 1], sizeof row * (size_t)(p->surface_count - at));
    return row;
}

LENSOPT_API lflare_result lensopt_move_stop(lflare_prescription *p, int32_t surface, double fraction, lflare_error *error)
{
    lflare_lens lens;
    lflare_prescription *q = &lens.prescription;
    lflare_surface stop, *front;
    lflare_result result = lensopt__derive(p, &lens, error);
    if (result != LFLARE_OK) return result;
    if (surface < 0 || surface >= lens.surface_count) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a row from 1 to %i was expected, not %i", lens.surface_count, surface + 1);
    if (surface == lens.stop) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "row %i is the stop itself: the row of a surface was expected, behind which it goes", surface + 1);
    if (!(fraction >= 0 && fraction <= 1)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a fraction of the gap from 0 to 1 was expected");
    if (fabs(lflare_index(&q->surfaces[surface].medium, lensopt__nm_d) - 1) > 1e-9)
        return lensopt__fail(error, LFLARE_ERROR_LENS, "behind row %i is glass: the stop stands in air, behind a row whose medium is air", surface + 1);
    stop = lensopt__take_row(q, lens.stop);
    front = &q->surfaces[surface - (surface > lens.stop)];
    memmove(front + 2, front + 1, sizeof stop * (size_t)(&q->surfaces[q->surface_count] - (front + 1)));
    q->surface_count++;
    stop.thickness = front->thickness * (1 - fraction);
    front->thickness -= stop.thickness;
    stop.semi_diameter = 0; /* from the f-number, which is the marginal ray's height */
    q->fnumber = lens.fnumber;
    front[1] = stop;
    return lensopt__keep(q, p, error);
}

/* -- one ghost's size -- */

/* The lens along the way: curvatures change by t * share. */
typedef struct lensopt__bend {
    const lflare_lens *from;
    lflare_lens *lens;             /* working copy */
    lflare_pair pair;
    double u, iris;
    int32_t row[2];
    double curvature[2], share[2]; /* before, without the r^2 term */
    double span;                   /* a curvature that the wider of the surfaces hardly has */
} lensopt__bend;

/* What ends one direction of the search, and what was reached on the way. */
typedef struct lensopt__reach {
    const char *why;
    double smallest, largest;
} lensopt__reach;

static void lensopt__bend_to(lensopt__bend *b, double t)
{
    int32_t k;
    for (k = 0; k < 2; k++) {
        lflare_surface *s = &b->lens->prescription.surfaces[b->row[k]];
        double c = b->curvature[k] + t * b->share[k];
        if (fabs(c) < 1e-9) c = 0; /* radii end at 1e9 mm */
        s->radius = t * b->share[k] == 0 ? b->from->prescription.surfaces[b->row[k]].radius : c != 0 ? 1 / c : 0;
        b->lens->curvature[b->row[k]] = c + 2 * s->aspheric[0];
    }
    if (b->lens->prescription.focus) {
        lflare_matrix m = lflare_system_matrix(b->lens, lensopt__nm_d);
        b->lens->prescription.surfaces[b->lens->surface_count - 1].thickness = -m.a / m.c;
    }
}

/* The spot's radius with the image's sign, so that it goes straight through 0 where the ghost comes into focus. */
static double lensopt__signed_size(const lensopt__bend *b)
{
    lflare_ghost_matrices m;
    lflare_region region;
    if (lflare_ghost_optics(b->lens, lensopt__nm[1], &b->pair, 1, &m) != LFLARE_OK) return 0;
    if (lflare_ghost_clip(b->lens, lensopt__nm[1], b->pair, b->iris, b->u, &region) == LFLARE_CLIP_HIDDEN) return 0;
    return m.m.a * sqrt(region.area / LENSOPT__PI);
}

static double lensopt__edge(const lflare_lens *lens, int32_t i)
{
    const lflare_surface *s = &lens->prescription.surfaces[i];
    double r = s[0].semi_diameter < s[1].semi_diameter ? s[0].semi_diameter : s[1].semi_diameter;
    return s[0].thickness + lflare_sag(&s[1], r) - lflare_sag(&s[0], r);
}

/* The f-number of an iris of this radius: the front alone, up to the stop, has A11 in its matrix. */
static double lensopt__fnumber(lflare_lens *lens, double iris)
{
    lflare_matrix m = lflare_system_matrix(lens, lensopt__nm_d), front;
    int32_t count = lens->surface_count;
    lens->surface_count = lens->stop + 1;
    front = lflare_system_matrix(lens, lensopt__nm_d);
    lens->surface_count = count;
    return fabs(front.a) / -m.c / (2 * iris);
}

/* NULL while it still is a lens that can be made, or what is not. */
static const char *lensopt__bend_ends(const lensopt__bend *b)
{
    lflare_matrix m = lflare_system_matrix(b->lens, lensopt__nm_d);
    double fnumber = lensopt__fnumber(b->lens, b->lens->prescription.surfaces[b->lens->stop].semi_diameter);
    int32_t k, i;
    for (k = 0; k < 2; k++) {
        const lflare_surface *s = &b->lens->prescription.surfaces[b->row[k]];
        if (!(fabs(lflare_sag(s, s->semi_diameter)) < 1e9)) return "the surface would end within its rim";
        for (i = b->row[k] - 1; i <= b->row[k]; i++) {
            double was;
            if (i < 0 || i + 1 >= b->lens->surface_count) continue;
            was = lensopt__edge(b->from, i);
            if (!(lensopt__edge(b->lens, i) >= (was < 0 ? was : 0))) return "it would cross a neighbour at the edge";
        }
    }
    if (!(-1 / m.c >= 0.5 * b->from->efl && -1 / m.c <= 2 * b->from->efl)) return "the focal length would halve or double";
    if (b->lens->prescription.focus && !(-m.a / m.c >= 0)) return "the focus would lie in the lens";
    if (!(fnumber >= 0.11 && fnumber <= 900)) return "the f-number would leave 0.1 to 1000";
    return NULL;
}

/* Bisects down to the size between two places that lie on either side of it; 0 if the size jumps over it there. */
static int lensopt__bend_solve(lensopt__bend *b, double from, double to, double goal, double *t)
{
    int32_t k;
    double side, size = 0;
    lensopt__bend_to(b, from);
    side = lensopt__signed_size(b) - goal;
    for (k = 0; k < 80; k++) {
        *t = 0.5 * (from + to);
        lensopt__bend_to(b, *t);
        size = lensopt__signed_size(b);
        if ((size - goal < 0) == (side < 0)) from = *t;
        else to = *t;
    }
    return fabs(size - goal) <= 1e-6 * fabs(goal) && lensopt__bend_ends(b) == NULL;
}

/* The last place before `bad` that can be made; the lens is bent to it. */
static double lensopt__bend_limit(lensopt__bend *b, double good, double bad)
{
    int32_t k;
    for (k = 0; k < 40; k++) {
        double t = 0.5 * (good + bad);
        lensopt__bend_to(b, t);
        if (lensopt__bend_ends(b) == NULL) good = t;
        else bad = t;
    }
    lensopt__bend_to(b, good);
    return good;
}

/* Outwards in both directions at once, so that the nearest solution comes first. 1, and the lens is bent to it; or 0. */
static int lensopt__bend_search(lensopt__bend *b, double size, double goal, lensopt__reach *reach)
{
    double at[2] = {0, 0}, sizes[2] = {size, size}, step = 1e-4 * b->span, t;
    int32_t side, sign;
    for (side = 0; side < 2; side++) {
        reach[side].why = NULL;
        reach[side].smallest = reach[side].largest = fabs(size);
    }
    while (reach[0].why == NULL || reach[1].why == NULL) {
        for (side = 0; side < 2; side++) {
            double next = at[side] + (side == 0 ? step : -step), here;
            if (reach[side].why != NULL) continue;
            lensopt__bend_to(b, next);
            reach[side].why = fabs(next) > 3 * b->span ? "it would be all too curved" : lensopt__bend_ends(b);
            if (reach[side].why != NULL) next = lensopt__bend_limit(b, at[side], next);
            here = lensopt__signed_size(b);
            for (sign = -1; sign <= 1; sign += 2)
                if ((here - sign * goal < 0) != (sizes[side] - sign * goal < 0) && lensopt__bend_solve(b, at[side], next, sign * goal, &t)) return 1;
            if (here * sizes[side] <= 0) reach[side].smallest = 0;
            reach[side].smallest = fmin(reach[side].smallest, fabs(here));
            reach[side].largest = fmax(reach[side].largest, fabs(here));
            at[side] = next;
            sizes[side] = here;
        }
        step = fmin(1.1 * step, 0.01 * b->span);
    }
    return 0;
}

/* How much of the change each mirror takes. */
static void lensopt__bend_share(lensopt__bend *b, lensopt_mirrors mirrors)
{
    double h = 1e-5 * b->span, slope[2], length;
    int32_t k;
    b->share[0] = mirrors == LENSOPT_MIRRORS_FIRST;
    b->share[1] = mirrors == LENSOPT_MIRRORS_SECOND;
    if (mirrors != LENSOPT_MIRRORS_BOTH) return;
    for (k = 0; k < 2; k++) {
        b->share[k] = 1;
        b->share[1 - k] = 0;
        lensopt__bend_to(b, h);
        slope[k] = lensopt__signed_size(b);
        lensopt__bend_to(b, -h);
        slope[k] -= lensopt__signed_size(b);
    }
    length = sqrt(slope[0] * slope[0] + slope[1] * slope[1]);
    for (k = 0; k < 2; k++) b->share[k] = length > 0 ? slope[k] / length : sqrt(0.5);
}

static void lensopt__bend_start(lensopt__bend *b, const lflare_lens *from, lflare_lens *lens, lflare_pair pair, double u, double iris)
{
    int32_t k;
    *lens = *from;
    memset(b, 0, sizeof *b);
    b->from = from;
    b->lens = lens;
    b->pair = pair;
    b->u = u;
    b->iris = iris;
    b->row[0] = pair.first;
    b->row[1] = pair.second;
    for (k = 0; k < 2; k++) {
        const lflare_surface *s = &from->prescription.surfaces[b->row[k]];
        b->curvature[k] = s->radius != 0 ? 1 / s->radius : 0;
        b->span = k == 0 ? 1 / s->semi_diameter : fmin(b->span, 1 / s->semi_diameter);
    }
}

LENSOPT_API lflare_result lensopt_resize_ghost(lflare_prescription *p, lflare_pair pair, double factor, lensopt_mirrors mirrors, double u, double iris,
                                               lflare_error *error)
{
    lflare_lens lens, work;
    lensopt__bend b;
    lensopt__reach reach[2];
    lflare_ghost_matrices m;
    double size;
    int32_t i = pair.first + 1, j = pair.second + 1;
    lflare_result result = lensopt__derive(p, &lens, error);
    if (result != LFLARE_OK) return result;
    if (!lensopt__is_factor(factor)) return lensopt__bad_factor(error, factor);
    if (!(u >= 0 && u < 1e6) || !(iris > 0 && iris < 1e9)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a slope u >= 0 and an iris of more than 0 mm were expected");
    if (mirrors != LENSOPT_MIRRORS_BOTH && mirrors != LENSOPT_MIRRORS_FIRST && mirrors != LENSOPT_MIRRORS_SECOND)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "the first mirror, the second or both were expected");
    if (pair.third != 0 || pair.fourth != 0 || lflare_ghost_optics(&lens, lensopt__nm[1], &pair, 1, &m) != LFLARE_OK)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "rows %i and %i make no ghost of two reflections: two on one side of the stop (row %i) were expected, the rear one first", i, j,
                             lens.stop + 1);
    lensopt__bend_start(&b, &lens, &work, pair, u, iris);
    size = lensopt__signed_size(&b);
    if (size == 0) return lensopt__fail(error, LFLARE_ERROR_LENS, "the ghost of rows %i and %i is hidden for this light and iris, so it has no size to change", i, j);
    lensopt__bend_share(&b, mirrors);
    if (factor != 1 && !lensopt__bend_search(&b, size, factor * fabs(size), reach))
        return lensopt__fail(error, LFLARE_ERROR_LENS, "the ghost of rows %i and %i can be about %g to %g times as large, not %g: beyond that %s, the other way %s", i, j,
                             fmin(reach[0].smallest, reach[1].smallest) / fabs(size), fmax(reach[0].largest, reach[1].largest) / fabs(size), factor, reach[0].why, reach[1].why);
    if (factor == 1) lensopt__bend_to(&b, 0);
    work.prescription.fnumber = lensopt__fnumber(&work, fabs(lens.stop_a11) * lens.efl / (2 * lens.fnumber)); /* of the same opening */
    return lensopt__keep(&work.prescription, p, error);
}

/* -- side effects -- */

/* Rows as they count without the stop. */
static int32_t lensopt__without_stop(const lflare_lens *lens, int32_t row) { return row - (row > lens->stop); }

/* Where one ghost comes in lists, against another one of another lens: < 0, 0 or > 0. */
static int32_t lensopt__order(const lflare_lens *a, lflare_pair p, const lflare_lens *b, lflare_pair q)
{
    int32_t d = (p.third > 0) - (q.third > 0);
    if (d == 0) d = lensopt__without_stop(a, p.first) - lensopt__without_stop(b, q.first);
    if (d == 0) d = lensopt__without_stop(a, p.second) - lensopt__without_stop(b, q.second);
    if (d == 0) d = lensopt__without_stop(a, p.third) - lensopt__without_stop(b, q.third);
    return d != 0 ? d : lensopt__without_stop(a, p.fourth) - lensopt__without_stop(b, q.fourth);
}

/* Both lists run in the same order. */
static int32_t lensopt__match(const lflare_lens *before, const lflare_pair *was, const lflare_lens *after, const lflare_pair *is, lensopt_change *out)
{
    int32_t i, k = 0, n = before->ghost_count;
    for (i = 0; i < before->ghost_count; i++) {
        out[i].pair_before = was[i];
        out[i].there = 1;
    }
    for (i = 0; i < after->ghost_count; i++) {
        lensopt_change *to;
        while (k < before->ghost_count && lensopt__order(before, was[k], after, is[i]) < 0) k++;
        to = k < before->ghost_count && lensopt__order(before, was[k], after, is[i]) == 0 ? &out[k] : &out[n++];
        to->pair_after = is[i];
        to->there |= 2;
    }
    return n;
}

LENSOPT_API lflare_result lensopt_changes(const lflare_lens *before, double iris_before, const lflare_lens *after, double iris_after, double u,
                                          lensopt_change *out, int32_t *count)
{
    lflare_pair *pairs;
    lflare_result result = LFLARE_OK;
    int32_t room, i, was, is;
    if (before == NULL || after == NULL || count == NULL || *count < 0 || (out == NULL && *count > 0) || before->surface_count != after->surface_count ||
        !(u >= 0 && u < 1e6) || !(iris_before > 0 && iris_before < 1e9) || !(iris_after > 0 && iris_after < 1e9))
        return LFLARE_ERROR_ARGUMENT;
    room = *count;
    was = before->ghost_count;
    is = after->ghost_count;
    *count = was + is;
    if (room < *count) return LFLARE_INCOMPLETE;
    if (*count == 0) return LFLARE_OK;
    pairs = (lflare_pair *)malloc(sizeof *pairs * (size_t)*count);
    if (pairs == NULL) return LFLARE_ERROR_MEMORY;
    memset(out, 0, sizeof *out * (size_t)*count);
    lflare_ghost_list(before, pairs, &was);
    lflare_ghost_list(after, pairs + was, &is);
    *count = lensopt__match(before, pairs, after, pairs + was, out);
    free(pairs);
    for (i = 0; i < *count && result == LFLARE_OK; i++) {
        if (out[i].there & 1) result = lensopt_spots(before, &out[i].pair_before, 1, u, iris_before, &out[i].before);
        if (out[i].there & 2 && result == LFLARE_OK) result = lensopt_spots(after, &out[i].pair_after, 1, u, iris_after, &out[i].after);
    }
    return result;
}

/* -- coatings -- */

/* A surface's stack leaves the list, and those behind it move up; but not layers that another surface shares. */
static void lensopt__drop_layers(lflare_prescription *p, int32_t surface)
{
    lflare_surface *s = &p->surfaces[surface];
    int32_t i, first = s->first_layer, count = s->layer_count, end = first + count;
    int shared = s->coating != LFLARE_COATING_STACK || count == 0 || end > p->layer_count;
    s->first_layer = s->layer_count = 0;
    if (s->coating == LFLARE_COATING_STACK) s->coating = LFLARE_COATING_NONE;
    for (i = 0; i < p->surface_count && !shared; i++) {
        const lflare_surface *other = &p->surfaces[i];
        shared = other->coating == LFLARE_COATING_STACK && other->layer_count > 0 && other->first_layer < end && other->first_layer + other->layer_count > first;
    }
    if (shared) return;
    memmove(&p->layers[first], &p->layers[end], sizeof p->layers[0] * (size_t)(p->layer_count - end));
    p->layer_count -= count;
    for (i = 0; i < p->surface_count; i++)
        if (p->surfaces[i].coating == LFLARE_COATING_STACK && p->surfaces[i].first_layer >= end) p->surfaces[i].first_layer -= count;
}

/* `layer` is NULL but for a stack, of that one. */
static lflare_result lensopt__coat(lflare_prescription *p, int32_t surface, lflare_coating_kind kind, double nm, const lflare_layer *layer, lflare_error *error)
{
    lflare_lens lens;
    lflare_prescription q;
    lflare_surface *s;
    lflare_result result = lensopt__derive(p, &lens, error);
    if (result != LFLARE_OK) return result;
    if (surface < 0 || surface >= p->surface_count) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a surface from 1 to %i was expected, not %i", p->surface_count, surface + 1);
    if (surface == lens.stop) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "row %i is the stop, which has no coating: a surface was expected", surface + 1);
    if (p->layer_count < 0 || p->layer_count > LFLARE_MAX_LAYERS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a prescription of 0 to 1024 layers was expected, not %i", p->layer_count);
    q = *p;
    s = &q.surfaces[surface];
    lensopt__drop_layers(&q, surface);
    if (layer != NULL && q.layer_count >= LFLARE_MAX_LAYERS) return lensopt__fail(error, LFLARE_ERROR_LIMIT, "the prescription has all 1024 layers that it can have: make another surface bare first");
    s->coating = kind;
    s->quarter_nm = nm;
    if (layer != NULL) {
        s->first_layer = q.layer_count;
        s->layer_count = 1;
        q.layers[q.layer_count++] = *layer;
    }
    result = lflare_lens_derive(&q, &lens, error);
    if (result == LFLARE_OK) *p = q;
    return result;
}

LENSOPT_API lflare_result lensopt_coat_quarter(lflare_prescription *p, int32_t surface, double nm, lflare_error *error)
{
    if (!(nm >= 100 && nm <= 20000)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a design wavelength from 100 to 20000 nm was expected");
    return lensopt__coat(p, surface, LFLARE_COATING_QUARTER, nm, NULL, error);
}

LENSOPT_API lflare_result lensopt_coat_layer(lflare_prescription *p, int32_t surface, double n, double thickness_nm, lflare_error *error)
{
    lflare_layer layer;
    layer.n = n;
    layer.thickness_nm = thickness_nm;
    if (!(n >= 1 && n <= 10)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a layer's index from 1 to 10 was expected");
    if (!(thickness_nm >= 0.01 && thickness_nm <= 1e5)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a layer's thickness from 0.01 to 100000 nm was expected");
    return lensopt__coat(p, surface, LFLARE_COATING_STACK, 0, &layer, error);
}

LENSOPT_API lflare_result lensopt_coat_bare(lflare_prescription *p, int32_t surface, lflare_error *error)
{
    return lensopt__coat(p, surface, LFLARE_COATING_NONE, 0, NULL, error);
}

/* >> 4 colour */

/* Index of refraction behind a row, -1 being in front of all; the stop has the medium of the row above it. */
static double lensopt__index(const lflare_lens *lens, int32_t row, double nm)
{
    const lflare_surface *s = lens->prescription.surfaces;
    while (row >= 0 && s[row].is_stop) row--;
    return row >= 0 ? lflare_index(&s[row].medium, nm) : 1;
}

/* Where a path meets the surfaces: what of a crossing does not depend on coatings. */
typedef struct lensopt__meeting {
    int32_t surface, reflected;
    double n0, n1, sine; /* in front, behind, n sin(angle) */
} lensopt__meeting;

/* The share of light that goes on from there. */
static double lensopt__share(const lensopt__meeting *at, const lflare_layer *layers, int32_t count, double nm)
{
    double r = at->n0 == at->n1 && count == 0 ? 0 : lflare_film_reflectance(at->n0, at->n1, layers, count, nm, at->sine);
    return at->reflected ? r : 1 - r;
}

/* All of them but the stop, at one wavelength; out: LFLARE_MAX_CIRCLES. */
static int32_t lensopt__meetings(const lflare_lens *lens, double nm, lflare_pair pair, double x, double u, lensopt__meeting *out)
{
    lflare_crossing path[LFLARE_MAX_CIRCLES];
    int32_t count = LFLARE_MAX_CIRCLES, i, n = 0;
    if (lflare_ghost_path(lens, nm, pair, path, &count) != LFLARE_OK) return 0;
    for (i = 0; i < count; i++) {
        double tangent = path[i].p * x + path[i].q * u;
        if (path[i].surface == lens->stop) continue;
        out[n].surface = path[i].surface;
        out[n].reflected = path[i].reflected;
        out[n].n0 = path[i].backwards ? path[i].n_out : path[i].n_in;
        out[n].n1 = path[i].backwards ? path[i].n_in : path[i].n_out;
        out[n++].sine = path[i].n_in * fabs(tangent) / sqrt(1 + tangent * tangent);
    }
    return n;
}

/* One channel's factors of one mirror over its coatings. `work` is the lens but for that surface's coating. */
static void lensopt__mirror_table(lflare_lens *work, int32_t surface, const lensopt__meeting *at, int32_t count, int32_t channel, double (*out)[LFLARE_WAVELENGTHS])
{
    int32_t step, i;
    lflare_surface *s = &work->prescription.surfaces[surface], kept = *s;
    s->coating = LFLARE_COATING_QUARTER;
    for (step = 0; step < LENSOPT_COLOUR_STEPS; step++) {
        lflare_layer layer;
        int32_t one = 1;
        s->quarter_nm = LENSOPT_COLOUR_BEGIN + LENSOPT_COLOUR_STEP * step;
        lflare_film_layers(work, surface, &layer, &one);
        out[step][channel] = 1;
        for (i = 0; i < count; i++)
            if (at[i].surface == surface) out[step][channel] *= lensopt__share(&at[i], &layer, 1, lensopt__nm[channel]);
    }
    *s = kept;
}

LENSOPT_API lflare_result lensopt_colour_map_make(const lflare_lens *lens, lflare_pair pair, double u, double iris, lensopt_colour_map *out)
{
    lflare_lens work;
    lensopt__meeting at[LFLARE_MAX_CIRCLES];
    lflare_layer layers[LFLARE_MAX_LAYERS];
    lflare_ghost_matrices m;
    lflare_region region;
    int32_t c, i;
    if (lens == NULL || out == NULL || !(u >= 0 && u < 1e6) || !(iris > 0 && iris < 1e9)) return LFLARE_ERROR_ARGUMENT;
    if (lflare_ghost_optics(lens, lensopt__nm[1], &pair, 1, &m) != LFLARE_OK) return LFLARE_ERROR_ARGUMENT;
    work = *lens;
    out->clip = lflare_ghost_clip(lens, lensopt__nm[1], pair, iris, u, &region);
    out->scale = 1 / sqrt(1 + u * u) / fmax(m.m.a * m.m.a, 1e-12);
    for (c = 0; c < LFLARE_WAVELENGTHS; c++) {
        int32_t count = lensopt__meetings(lens, lensopt__nm[c], pair, region.centroid, u, at);
        out->path[c] = out->now[c] = 1;
        for (i = 0; i < count; i++) {
            int32_t films = LFLARE_MAX_LAYERS;
            double share;
            lflare_film_layers(lens, at[i].surface, layers, &films);
            share = lensopt__share(&at[i], layers, films, lensopt__nm[c]);
            out->now[c] *= share;
            if (at[i].surface != pair.first && at[i].surface != pair.second) out->path[c] *= share;
        }
        lensopt__mirror_table(&work, pair.first, at, count, c, out->first);
        lensopt__mirror_table(&work, pair.second, at, count, c, out->second);
    }
    return LFLARE_OK;
}

LENSOPT_API void lensopt_colour_map_floats(const lensopt_colour_map *map, float *rgb)
{
    int32_t i, j, c;
    for (j = 0; j < LENSOPT_COLOUR_STEPS; j++)
        for (i = 0; i < LENSOPT_COLOUR_STEPS; i++)
            for (c = 0; c < LFLARE_WAVELENGTHS; c++) *rgb++ = (float)(map->path[c] * map->first[i][c] * map->second[j][c]);
}

/* HUGE_VAL where there is no light and so no hue. */
static double lensopt__colour_distance(const double *rgb, const double *target, double brightness)
{
    double sum = rgb[0] + rgb[1] + rgb[2], goal = target[0] + target[1] + target[2], d = 0;
    int32_t c;
    if (!(sum > 0)) return HUGE_VAL;
    for (c = 0; c < LFLARE_WAVELENGTHS; c++) d += (rgb[c] / sum - target[c] / goal) * (rgb[c] / sum - target[c] / goal);
    return sqrt(d) + (brightness > 0 ? brightness * fabs(log(sum / goal)) : 0);
}

LENSOPT_API lflare_result lensopt_colour_best(const lensopt_colour_map *map, const double *target, double brightness, lensopt_colour_point *out)
{
    int32_t i, j, c;
    double sum = 0;
    if (map == NULL || target == NULL || out == NULL || !(brightness >= 0 && brightness < 1e9)) return LFLARE_ERROR_ARGUMENT;
    for (c = 0; c < LFLARE_WAVELENGTHS; c++) {
        if (!(target[c] >= 0 && target[c] < 1e30)) return LFLARE_ERROR_ARGUMENT;
        sum += target[c];
    }
    if (!(sum > 0)) return LFLARE_ERROR_ARGUMENT;
    memset(out, 0, sizeof *out);
    out->distance = HUGE_VAL;
    for (j = 0; j < LENSOPT_COLOUR_STEPS; j++)
        for (i = 0; i < LENSOPT_COLOUR_STEPS; i++) {
            double rgb[LFLARE_WAVELENGTHS], d;
            for (c = 0; c < LFLARE_WAVELENGTHS; c++) rgb[c] = map->path[c] * map->first[i][c] * map->second[j][c];
            d = lensopt__colour_distance(rgb, target, brightness);
            if (!(d < out->distance)) continue;
            out->distance = d;
            out->first_nm = LENSOPT_COLOUR_BEGIN + LENSOPT_COLOUR_STEP * i;
            out->second_nm = LENSOPT_COLOUR_BEGIN + LENSOPT_COLOUR_STEP * j;
            memcpy(out->rgb, rgb, sizeof rgb);
        }
    return out->distance < HUGE_VAL ? LFLARE_OK : LFLARE_ERROR_LENS;
}

static int lensopt__curve_asked(const lflare_lens *lens, int32_t surface, double sine, const double *nm, int32_t count, const double *out)
{
    int32_t i;
    if (lens == NULL || surface < 0 || surface >= lens->surface_count || surface == lens->stop || !(sine >= 0 && sine < 1e6) || count < 0) return 0;
    if (count > 0 && (nm == NULL || out == NULL)) return 0;
    for (i = 0; i < count; i++)
        if (!(nm[i] >= 100 && nm[i] <= 20000)) return 0;
    return 1;
}

LENSOPT_API lflare_result lensopt_reflectance(const lflare_lens *lens, int32_t surface, double sine, const double *nm, int32_t count, double *out)
{
    lflare_layer layers[LFLARE_MAX_LAYERS];
    lensopt__meeting at;
    int32_t i, films = LFLARE_MAX_LAYERS;
    if (!lensopt__curve_asked(lens, surface, sine, nm, count, out)) return LFLARE_ERROR_ARGUMENT;
    lflare_film_layers(lens, surface, layers, &films);
    at.surface = surface;
    at.reflected = 1;
    at.sine = sine;
    for (i = 0; i < count; i++) {
        at.n0 = lensopt__index(lens, surface - 1, nm[i]);
        at.n1 = lensopt__index(lens, surface, nm[i]);
        out[i] = lensopt__share(&at, layers, films, nm[i]);
    }
    return LFLARE_OK;
}

LENSOPT_API lflare_result lensopt_quarter_reflectance(const lflare_lens *lens, int32_t surface, double sine, const double *nm, int32_t count, double *out)
{
    lflare_lens work;
    int32_t i;
    if (!lensopt__curve_asked(lens, surface, sine, nm, count, out)) return LFLARE_ERROR_ARGUMENT;
    work = *lens;
    work.prescription.surfaces[surface].coating = LFLARE_COATING_QUARTER;
    for (i = 0; i < count; i++) {
        work.prescription.surfaces[surface].quarter_nm = nm[i];
        lensopt_reflectance(&work, surface, sine, lensopt__nm, LFLARE_WAVELENGTHS, out + 3 * i);
    }
    return LFLARE_OK;
}

/* >> 5 target */

LENSOPT_API double lensopt_slope(const lensopt_light *light)
{
    double x = tan(light->direction[0] * (LENSOPT__PI / 180)), y = tan(light->direction[1] * (LENSOPT__PI / 180));
    return sqrt(x * x + y * y);
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
    if (t == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a target was expected, not NULL");
    if (!lensopt__within(t->sensor_width, 1e-3, 1e5) || !lensopt__within(t->sensor_height, 1e-3, 1e5)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a sensor from 0.001 to 100000 mm wide and high was expected");
    if (t->light_count < 1 || t->light_count > LENSOPT_MAX_LIGHTS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "1 to 8 lights were expected");
    if (t->ghost_count < 1 || t->ghost_count > LENSOPT_MAX_GHOSTS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "1 to 1024 ghosts were expected");
    for (i = 0; i < t->light_count; i++)
        if ((fault = lensopt__light_fault(&t->lights[i])) != NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "light %i: %s", i + 1, fault);
    for (i = 0; i < t->ghost_count; i++)
        if ((fault = lensopt__ghost_fault(t, &t->ghosts[i])) != NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "ghost %i: %s", i + 1, fault);
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
    lflare_pair pairs[LENSOPT_MAX_GHOSTS];
    const char *fault;
    int32_t i, count = LENSOPT_MAX_GHOSTS;
    if (lens == NULL || out == NULL || lights == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a lens, lights and room for a target were expected, not NULL");
    if (light_count < 1 || light_count > LENSOPT_MAX_LIGHTS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "1 to 8 lights were expected");
    if (!lensopt__within(iris, 1e-9, 1e6)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "an iris of a radius up to 1000000 mm was expected");
    memset(out, 0, sizeof *out);
    memcpy(out->name, lens->prescription.name, sizeof out->name);
    out->sensor_width = lens->sensor_width;
    out->sensor_height = lens->sensor_height;
    for (i = 0; i < light_count; i++) {
        if ((fault = lensopt__light_fault(&lights[i])) != NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "light %i: %s", i + 1, fault);
        out->lights[out->light_count++] = lights[i];
    }
    if (lflare_ghost_list(lens, pairs, &count) == LFLARE_INCOMPLETE) return lensopt__fail(error, LFLARE_ERROR_LIMIT, "the lens has %i ghosts, a target takes 1024", count);
    for (i = 0; i < count; i++) out->ghost_count += lensopt__pick(lens, pairs[i], out, iris, &out->ghosts[out->ghost_count]);
    return out->ghost_count > 0 ? LFLARE_OK : lensopt__fail(error, LFLARE_ERROR_LENS, "none of the lights shows a ghost: lights nearer to the axis were expected, or a larger iris");
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
    char word[33];
    size_t n = r->size < 32 ? r->size : 32, i;
    if (r->result != LFLARE_OK) return;
    for (i = 0; i < n; i++) word[i] = r->word[i] < 32 || r->word[i] > 126 ? '?' : r->word[i];
    word[n] = 0;
    r->result = n == 0 ? lensopt__fail(r->error, LFLARE_ERROR_SYNTAX, "expected %s, found the end of the line", expected)
                       : lensopt__fail(r->error, LFLARE_ERROR_SYNTAX, "expected %s, found '%s%s'", expected, word, r->size > n ? "..." : "");
    if (r->error == NULL) return;
    r->error->line = r->line;
    r->error->column = r->column;
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
    if (out == NULL || (text == NULL && size > 0)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "text and room for a target were expected, not NULL");
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
