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
       >> 11 coatings

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

/* TEMPORARY until the search is merged, which declares the same above this section: drop this copy. */
enum { LENSOPT_MAX_VARIABLES = 512 };
typedef struct lensopt_function {
    int32_t variables;
    const double *lower, *upper;
    const int32_t *blocks;
    void *user;
    void (*evaluate)(void *user, const double *x, int32_t count, double *f);
    void (*sample)(void *user, uint64_t *random, double *x);
    int32_t (*polish)(void *user, double *x, double *f, int32_t steps);
} lensopt_function;
/* END OF TEMPORARY */

/* ---- coatings: what makes ghosts have the target's colours ---- */

typedef enum lensopt_film {
    LENSOPT_FILM_QUARTER = 0, /* quarter-wave coatings: a surface's variable is its design wavelength */
    LENSOPT_FILM_LAYER        /* one layer of any kind: its index, then its thickness */
} lensopt_film;

typedef enum lensopt_matching {
    LENSOPT_MATCHING_PAIRS = 0, /* a ghost of the target is the lens's ghost of its pair; if it has none, or none in the lens's list, by spots */
    LENSOPT_MATCHING_SPOTS      /* all by spots: for a lens that is not the one that the target was picked from */
} lensopt_matching;

/* A lens whose surfaces stay what they are, and what its ghosts should look like. All zeroes but lens and target is fine. */
typedef struct lensopt_coatings_desc {
    const lflare_lens *lens;       /* only read while the object is made, as is */
    const lensopt_target *target;  /* what counts: its lights, its ghosts with a color and a weight above 0, locks on coatings */
    double iris;                   /* radius on the stop plane, as in lensopt_spots; 0: the full opening */
    lensopt_film film;
    lensopt_matching matching;
    int32_t cemented;              /* 1: surfaces between two glasses get coatings, too; 0: they keep theirs */
    double brightness;             /* >= 0; 0: hue alone. Above, a color's sum is meant as that of lensopt_spot.irradiance */
    double nm[2];                  /* bounds of design wavelengths, 100 to 20000; both 0: 200 and 750 */
    double index[2];               /* of a layer's index, 1.3 to 4; both 0: 1.38 and 1.9, */
    double thickness[2];           /* and its thickness in nm, 1 to 10000; both 0: 25 and 750 (Van Acoleyen 2025, 5.4) */
    lflare_realloc allocate;       /* NULL = libc's; called only while the object is made and freed */
    void *user;
} lensopt_coatings_desc;

/* The problem, ready to be evaluated. Constant once made: any number of threads may use it at once. */
typedef struct lensopt_coatings lensopt_coatings;

/* Coatings are sought for all surfaces that have glass on one side and air on the other, but for those whose coating the target locks.
   By spots, what is left of target and lens is paired so that the sum over lights of weight * (difference of centres^2 + of radii^2)
   is least; ghosts without a spot to go by stay alone. A ghost's color is meant at the first light that shows it, along the ray
   through the middle of what is open, as lensopt_target_of has it. LFLARE_ERROR_LENS where no ghost is left that counts or no surface
   is free, LFLARE_ERROR_ARGUMENT, _MEMORY, and _LIMIT for a lens and target that need more than 4096 films (171 ghosts of 27 surfaces
   need 700). error may be NULL. *out: free it with lensopt_coatings_destroy; NULL on error. 50 ms and 2 MB for those, and as much again
   while it works; ghosts by spots cost their number cubed in nanoseconds. */
LENSOPT_API lflare_result lensopt_coatings_create(const lensopt_coatings_desc *desc, lensopt_coatings **out, lflare_error *error);
LENSOPT_API void lensopt_coatings_destroy(lensopt_coatings *coatings); /* NULL is fine */

/* What a search needs; it points into *coatings. f = sum over the ghosts that count of weight * (|target / sum - rgb / sum| + brightness *
   |ln(sum of irradiance / sum of target)|), over three channels: at 0 brightness the measure of Van Acoleyen 2025, 5.6.4 (there every
   weight is 1). polish takes Levenberg's and Marquardt's steps on squares, each over its distance or the mean of all if that is more,
   anew at each step, as f falls, and never returns a worse point. W is within 1e-4 of lflare_ghost_weight's, a channel that has next to no light
   (reflectance below 1e-4) aside. A core evaluates 1.6 million quarter-wave coatings or 0.35 million layers a second for 13 ghosts of 8 surfaces,
   0.09 and 0.055 million for 171 of 27. 160 KB of stack; polish takes memory from libc, or does nothing where there is none. */
LENSOPT_API void lensopt_coatings_function(const lensopt_coatings *coatings, lensopt_function *out);

/* The rows of the free surfaces, in the variables' order: of quarter-wave coatings one variable each, of layers two. rows: LFLARE_MAX_SURFACES,
   or NULL. Returns their number. */
LENSOPT_API int32_t lensopt_coatings_surfaces(const lensopt_coatings *coatings, int32_t *rows);

/* The variables of a prescription's coatings, whose rows are those of the lens. Where they are of another kind or beyond the bounds the
   nearest within, for other films the middle, and LFLARE_INCOMPLETE is returned. x: the function's variables. */
LENSOPT_API lflare_result lensopt_coatings_read(const lensopt_coatings *coatings, const lflare_prescription *prescription, double *x);

/* Gives a prescription, whose rows are those of the lens, the coatings of x; what is missing in it stays missing. On error it stays as it
   was: LFLARE_ERROR_ARGUMENT, _LIMIT where the layers would be more than LFLARE_MAX_LAYERS, or what lflare_lens_derive says. */
LENSOPT_API lflare_result lensopt_coatings_apply(const lensopt_coatings *coatings, const double *x, lflare_prescription *prescription, lflare_error *error);

/* What becomes of one ghost of the target. */
typedef struct lensopt_coated_ghost {
    lflare_pair pair;               /* of the lens; first -1: it has none */
    int32_t light;                  /* from 0: the one at which its color is meant; -1: it does not count, and what follows is 0 */
    double rgb[LFLARE_WAVELENGTHS]; /* W */
    double scale;                   /* irradiance of lensopt_spots over W */
    double distance;                /* its part of f, weight apart */
} lensopt_coated_ghost;

/* out: one for each ghost of the target. Costs an evaluation. */
LENSOPT_API void lensopt_coatings_ghosts(const lensopt_coatings *coatings, const double *x, lensopt_coated_ghost *out);

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

/* >> 11 coatings */

/* W of a ghost is a product over its crossings, whose angles are known before any coating is. So films are computed at few angles a surface
   and channel (nodes), one way for all ghosts; what a crossing lets through is interpolated in the logarithm, so that a ghost's product
   is a sum over surfaces, of which neighbouring surfaces' common part comes from running sums; and what it reflects is interpolated
   as it is. Films of quarter-wave coatings, which one number describes, come from tables. Four candidates go side by side: loops over LENSOPT__COAT_LANES are what compilers turn into vectors. */

#if defined(__GNUC__) && !defined(__clang__)
#define LENSOPT__COAT_FAST __attribute__((optimize("O3"))) /* unrolls loops over lanes, which -O2 makes vectors of but keeps: half as fast again */
#else
#define LENSOPT__COAT_FAST
#endif

enum {
    LENSOPT__COAT_LANES = 4,
    LENSOPT__COAT_NODES = 4096, /* running sums counted: 128 KB of stack while they are evaluated */
    LENSOPT__COAT_ORDER = 4,    /* nodes from which an angle is interpolated, at most */
    LENSOPT__COAT_TRIALS = 32   /* films on which interpolation is tried */
};

typedef struct lensopt__coat_quad { double v[LENSOPT__COAT_LANES]; } lensopt__coat_quad;

/* A film at one surface, wavelength and angle, but for index n and thickness d of its layer. With admittances y0, y1 in front and behind
   and y of the layer, and q = sin^2 of its phase, the characteristic matrix of one layer (Born & Wolf 1.6) comes to
   R = (a + K q) / (b + K q), K = y^2 + p / y^2 - s, where a = (y0 - y1)^2, b = (y0 + y1)^2, p = (y0 y1)^2, s = y0^2 + y1^2; [0]: s, [1]: p polarised. */
typedef struct lensopt__coat_node {
    double s2, per_nm;               /* (n sin(angle))^2, one over the wavelength */
    double a[2], b[2], p[2], s[2];
    int32_t coat;                    /* whose film */
} lensopt__coat_node;

/* Angles of one surface and channel that are interpolated from the same nodes, by Newton's polynomial in s2. */
typedef struct lensopt__coat_panel {
    double lo, hi, step[LENSOPT__COAT_ORDER][LENSOPT__COAT_ORDER]; /* s2; step[k][i]: 1 over that from node i - k to node i */
    double reach[LENSOPT__COAT_ORDER];                        /* the greatest coefficients on trial */
    int32_t node, count, members;                        /* nodes; crossings */
    int32_t coat, channel, mirror;
} lensopt__coat_panel;

/* A surface that gets a coating. */
typedef struct lensopt__coated {
    lflare_medium media[2];                /* in front and behind */
    int32_t row, node, mirror, end;        /* its nodes: let through from `node`, reflect from `mirror` on */
    int32_t main[LFLARE_WAVELENGTHS];      /* the panel that goes into the running sums, -1: none */
    double cut[2], per_cell[2];            /* its table's two parts: where they begin, nm, and one over the width of a cell; */
    int32_t cells[2], table;               /* how many cells each has, and where the first is: see lensopt__coat_table_make */
} lensopt__coated;

typedef struct lensopt__coat_term { double weight; int32_t at; } lensopt__coat_term;
typedef struct lensopt__coat_span { int32_t begin, end; } lensopt__coat_span;

/* W of one ghost and channel: fixed * exp(sum of terms) * product over the mirrors of their sums of terms. */
typedef struct lensopt__coat_beam {
    double fixed;
    lensopt__coat_span passes, terms, mirrors; /* passes: into the crossings, while the object is made */
} lensopt__coat_beam;

/* A ghost that counts. */
typedef struct lensopt__coat_shown {
    lflare_pair pair;
    int32_t target, light;
    double u, scale, weight, goal[LFLARE_WAVELENGTHS], level; /* goal: adds up to 1; level: of the target's sum, in W, the logarithm */
} lensopt__coat_shown;

typedef struct lensopt__coat_pass { double s2; int32_t coat, mirror; } lensopt__coat_pass;

typedef struct lensopt__coat_list { void *items; int32_t count, room; size_t item; } lensopt__coat_list;

struct lensopt_coatings {
    lflare_realloc allocate;
    void *user;
    lensopt_film film;
    int32_t coat_count, variables, surface_count, target_count, stop;
    double brightness, least;                        /* least square of a layer's index */
    lensopt__coat_list nodes, panels, beams, terms, mirrors, shown, passes, matched, tables;
    lensopt__coated coats[LFLARE_MAX_SURFACES];
    double lower[2 * LFLARE_MAX_SURFACES], upper[2 * LFLARE_MAX_SURFACES];
    int32_t blocks[2 * LFLARE_MAX_SURFACES];
};

/* -- films -- */

static void lensopt__coat_node_make(lensopt__coat_node *node, double n0, double n1, double s2, double nm, int32_t coat)
{
    double c0 = sqrt(1 - s2 / (n0 * n0)), c1 = sqrt(1 - s2 / (n1 * n1));
    int32_t k;
    node->s2 = s2;
    node->per_nm = 1 / nm;
    node->coat = coat;
    for (k = 0; k < 2; k++) {
        double y0 = k == 0 ? n0 * c0 : n0 / c0, y1 = k == 0 ? n1 * c1 : n1 / c1;
        node->a[k] = (y0 - y1) * (y0 - y1);
        node->b[k] = (y0 + y1) * (y0 + y1);
        node->p[k] = y0 * y1 * y0 * y1;
        node->s[k] = y0 * y0 + y1 * y1;
    }
}

/* Layers of four candidates on one surface: n^2, 1 / n^2, 2 n d. */
typedef struct lensopt__coat_layers { lensopt__coat_quad n2, per_n2, path; } lensopt__coat_layers;

/* What a film reflects (mirror 1) or lets through, to 1e-11. The square root is Newton's from a quartic, relative to the layer's index, of which
   s2 / n^2 <= 0.6 is asked; sin^2 is that of half the angle, to 1e-12. Numbers of its own alone, so that it is clear that nothing overlaps. */
LENSOPT__COAT_FAST static lensopt__coat_quad lensopt__coat_film(const lensopt__coat_node *node, const lensopt__coat_layers *layers, int mirror)
{
    const double share = mirror ? 1 : 0, base[2] = {mirror ? node->a[0] : node->b[0] - node->a[0], mirror ? node->a[1] : node->b[1] - node->a[1]};
    lensopt__coat_quad turns, root, out;
    int32_t l, whole[LENSOPT__COAT_LANES];
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double z = node->s2 * layers->per_n2.v[l], c = 1 - z, r;
        r = 1.00023523083 + z * (0.480618150099 + z * (0.618182990498 + z * (-0.679164305163 + z * 1.66776550191)));
        r *= 1.5 - 0.5 * c * r * r;
        r *= 1.5 - 0.5 * c * r * r; /* 1 / sqrt(c) */
        root.v[l] = r;
        turns.v[l] = layers->path.v[l] * c * r * node->per_nm; /* phase over pi */
    }
    for (l = 0; l < LENSOPT__COAT_LANES; l++) whole[l] = (int32_t)(turns.v[l] + 0.5);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) turns.v[l] -= (double)whole[l];
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double n2 = layers->n2.v[l], per_n2 = layers->per_n2.v[l], m = n2 - node->s2, t = turns.v[l] * turns.v[l], per_m = root.v[l] * root.v[l] * per_n2, y2 = n2 * n2 * per_m;
        double h = t * (2.46740110026629222 + t * (-2.029356061466472521 + t * (0.6676313030776605693 + t * (-0.1176639246759449128 + t * (0.01289268739420333895 - t * 0.0009262951272374889576)))));
        double q = 4 * h * (1 - h), e0 = (m + node->p[0] * per_m - node->s[0]) * q, e1 = (y2 + node->p[1] * m * per_n2 * per_n2 - node->s[1]) * q;
        double d0 = node->b[0] + e0, d1 = node->b[1] + e1;
        e0 = base[0] + share * e0; /* the numerators */
        e1 = base[1] + share * e1;
        out.v[l] = 0.5 * (e0 * d1 + e1 * d0) / (d0 * d1);
    }
    return out;
}

/* Reflectance of one film, plainly, and its derivatives by n^2 and by d. */
static double lensopt__coat_film_slopes(const lensopt__coat_node *node, double n2, double d, double *by_n2, double *by_d)
{
    double m = n2 - node->s2, root = sqrt(m), phase = 2 * LENSOPT__PI * d * root * node->per_nm, q = sin(phase) * sin(phase), dq = sin(2 * phase), r = 0;
    int32_t k;
    *by_n2 = *by_d = 0;
    for (k = 0; k < 2; k++) {
        double y2 = k == 0 ? m : n2 * n2 / m, dy2 = k == 0 ? 1 : n2 * (2 * m - n2) / (m * m); /* by n^2 */
        double big = y2 + node->p[k] / y2 - node->s[k], dbig = dy2 * (1 - node->p[k] / (y2 * y2)), b = node->b[k] + big * q, slope = 0.5 * (node->b[k] - node->a[k]) / (b * b);
        r += 0.5 * (node->a[k] + big * q) / b;
        *by_n2 += slope * (dbig * q + big * dq * phase / (2 * m));
        if (d > 0) *by_d += slope * big * dq * phase / d;
    }
    return r;
}

/* n^2 and d of variables, and their derivatives by them: out[2] each; by[1] only of layers. */
static void lensopt__coat_layer_of(const lensopt_coatings *c, int32_t coat, const double *x, double *out, double (*by)[2])
{
    const lflare_medium *media = c->coats[coat].media;
    double nm = x[coat], n2, n, slope = 0, step = 0.05;
    if (c->film == LENSOPT_FILM_LAYER) {
        n = x[2 * coat];
        out[0] = n * n;
        out[1] = x[2 * coat + 1];
        if (by == NULL) return;
        by[0][0] = 2 * n;
        by[1][1] = 1;
        by[0][1] = by[1][0] = 0;
        return;
    }
    n2 = lflare_index(&media[0], nm) * lflare_index(&media[1], nm);
    if (n2 > 1.38 * 1.38 && by != NULL) /* by the glass's dispersion, which differences give well enough */
        slope = (lflare_index(&media[0], nm + step) * lflare_index(&media[1], nm + step) - lflare_index(&media[0], nm - step) * lflare_index(&media[1], nm - step)) / (2 * step);
    n2 = n2 > 1.38 * 1.38 ? n2 : 1.38 * 1.38;
    n = sqrt(n2);
    out[0] = n2;
    out[1] = nm / (4 * n);
    if (by == NULL) return;
    by[0][0] = slope;
    by[0][1] = 1 / (4 * n) - out[1] * slope / (2 * n2);
}

/* Logarithms of normal numbers above 0, to 1e-13. */
LENSOPT__COAT_FAST static lensopt__coat_quad lensopt__coat_logs(lensopt__coat_quad x)
{
    uint64_t bits[LENSOPT__COAT_LANES], power[LENSOPT__COAT_LANES];
    double e[LENSOPT__COAT_LANES], m[LENSOPT__COAT_LANES];
    int32_t l;
    memcpy(bits, x.v, sizeof bits);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) power[l] = bits[l] >> 52 | (uint64_t)0x433 << 52; /* 2^52 + the exponent */
    for (l = 0; l < LENSOPT__COAT_LANES; l++) bits[l] = (bits[l] & (((uint64_t)1 << 52) - 1)) | (uint64_t)0x3ff << 52;
    memcpy(e, power, sizeof e);
    memcpy(m, bits, sizeof m);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double z = (m[l] - 1.41421356237309505) / (m[l] + 1.41421356237309505), w = z * z;
        z *= 1.999999999999947188 + w * (0.6666666667957925211 + w * (0.3999999489183238274 + w * (0.2857216614587572507 + w * (0.2217424991007748979 + w * 0.1960809563975305275))));
        x.v[l] = (e[l] - 4503599627370496.0 - 1022.5) * 0.693147180559945309 + z;
    }
    return x;
}

/* exp of what is from -700 to 0, to 1e-12. */
LENSOPT__COAT_FAST static lensopt__coat_quad lensopt__coat_exps(lensopt__coat_quad x)
{
    double power[LENSOPT__COAT_LANES];
    uint64_t bits[LENSOPT__COAT_LANES];
    int32_t l, whole[LENSOPT__COAT_LANES];
    for (l = 0; l < LENSOPT__COAT_LANES; l++) x.v[l] *= 1.44269504088896341;
    for (l = 0; l < LENSOPT__COAT_LANES; l++) whole[l] = (int32_t)(x.v[l] - 0.5);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) power[l] = (double)whole[l];
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double f = x.v[l] - power[l];
        x.v[l] = 1.0 + f * (0.6931471805459334549 + f * (0.2402265069581298821 + f * (0.05550410941205932993 + f * (0.009618129159402558188 + f * (0.001333345056800064568 + f * (0.0001540345585245383944 + f * (0.00001531007940224929744 + f * 1.325522487866881698e-6)))))));
        power[l] += 4503599627370496.0 + 1023;
    }
    memcpy(bits, power, sizeof bits);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) bits[l] <<= 52;
    memcpy(power, bits, sizeof power);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) x.v[l] *= power[l];
    return x;
}

/* -- evaluating -- */

/* Films at all nodes of a surface for four candidates: what is reflected, and the logarithm of what passes. */
LENSOPT__COAT_FAST static void lensopt__coat_films(const lensopt_coatings *c, int32_t coat, const double *const *x, lensopt__coat_quad *out)
{
    const lensopt__coat_node *nodes = (const lensopt__coat_node *)c->nodes.items;
    const lensopt__coated *at = &c->coats[coat];
    lensopt__coat_layers layers;
    int32_t i, l;
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double layer[2];
        lensopt__coat_layer_of(c, coat, x[l], layer, NULL);
        layers.n2.v[l] = layer[0];
        layers.per_n2.v[l] = 1 / layer[0];
        layers.path.v[l] = 2 * sqrt(layer[0]) * layer[1];
    }
    for (i = at->node; i < at->mirror; i++) out[i] = lensopt__coat_logs(lensopt__coat_film(&nodes[i], &layers, 0));
    for (; i < at->end; i++) out[i] = lensopt__coat_film(&nodes[i], &layers, 1);
}

/* The same of quarter-wave coatings from their table. */
LENSOPT__COAT_FAST static void lensopt__coat_look_up(const lensopt_coatings *c, int32_t coat, const double *const *x, lensopt__coat_quad *out)
{
    const lensopt__coated *at = &c->coats[coat];
    int32_t i, l, count = at->end - at->node;
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double nm = x[l][coat];
        int32_t part = at->cells[1] > 0 && nm >= at->cut[1], last = at->cells[part] - 1, cell;
        double t = (nm - at->cut[part]) * at->per_cell[part];
        const double *row = (const double *)c->tables.items + at->table;
        cell = t > 0 ? t < last ? (int32_t)t : last : 0; /* 0 of what is no number, too */
        t -= cell;
        row += (size_t)((part == 0 ? 0 : at->cells[0]) + cell) * 4 * (size_t)count;
        for (i = 0; i < count; i++) out[at->node + i].v[l] = row[i] + t * (row[count + i] + t * (row[2 * count + i] + t * row[3 * count + i]));
    }
}

/* All that is known of four candidates: films at nodes, panels of them in Newton's form, and behind them the running sums. */
LENSOPT__COAT_FAST static void lensopt__coat_values(const lensopt_coatings *c, const double *const *x, lensopt__coat_quad *out)
{
    const lensopt__coat_panel *panels = (const lensopt__coat_panel *)c->panels.items;
    lensopt__coat_quad *sums = out + c->nodes.count;
    int32_t coat, channel, p, i, k, l;
    for (coat = 0; coat < c->coat_count; coat++) {
        if (c->tables.count > 0) lensopt__coat_look_up(c, coat, x, out);
        else lensopt__coat_films(c, coat, x, out);
    }
    for (p = 0; p < c->panels.count; p++)
        for (k = 1; k < panels[p].count; k++)
            for (i = panels[p].count - 1; i >= k; i--) {
                lensopt__coat_quad *v = &out[panels[p].node + i];
                const double step = panels[p].step[k][i];
                for (l = 0; l < LENSOPT__COAT_LANES; l++) v->v[l] = (v->v[l] - v[-1].v[l]) * step;
            }
    for (channel = 0; channel < LFLARE_WAVELENGTHS; channel++) {
        lensopt__coat_quad sum = {{0, 0, 0, 0}};
        *sums++ = sum;
        for (coat = 0; coat < c->coat_count; coat++) {
            int32_t main = c->coats[coat].main[channel];
            for (l = 0; l < LENSOPT__COAT_LANES && main >= 0; l++) sum.v[l] += out[panels[main].node].v[l];
            *sums++ = sum;
        }
    }
}

LENSOPT__COAT_FAST static lensopt__coat_quad lensopt__coat_sum(const lensopt__coat_term *terms, lensopt__coat_span span, const lensopt__coat_quad *value)
{
    lensopt__coat_quad sum = {{0, 0, 0, 0}};
    int32_t i, l;
    for (i = span.begin; i < span.end; i++)
        for (l = 0; l < LENSOPT__COAT_LANES; l++) sum.v[l] += terms[i].weight * value[terms[i].at].v[l];
    return sum;
}

/* W of one ghost. */
LENSOPT__COAT_FAST static void lensopt__coat_w(const lensopt_coatings *c, int32_t ghost, const lensopt__coat_quad *value, lensopt__coat_quad *out)
{
    const lensopt__coat_term *terms = (const lensopt__coat_term *)c->terms.items;
    const lensopt__coat_span *mirrors = (const lensopt__coat_span *)c->mirrors.items;
    const lensopt__coat_beam *beam = (const lensopt__coat_beam *)c->beams.items + LFLARE_WAVELENGTHS * ghost;
    int32_t channel, i, l;
    for (channel = 0; channel < LFLARE_WAVELENGTHS; channel++, beam++) {
        lensopt__coat_quad w = lensopt__coat_sum(terms, beam->terms, value);
        for (l = 0; l < LENSOPT__COAT_LANES; l++) w.v[l] = w.v[l] > -600 ? w.v[l] : -600;
        w = lensopt__coat_exps(w);
        for (l = 0; l < LENSOPT__COAT_LANES; l++) w.v[l] *= beam->fixed;
        for (i = beam->mirrors.begin; i < beam->mirrors.end; i++) {
            lensopt__coat_quad r = lensopt__coat_sum(terms, mirrors[i], value);
            for (l = 0; l < LENSOPT__COAT_LANES; l++) w.v[l] *= r.v[l];
        }
        out[channel] = w;
    }
}

/* A ghost's distance, without its weight. */
LENSOPT__COAT_FAST static void lensopt__coat_distances(const lensopt__coat_shown *ghost, const lensopt__coat_quad *rgb, double brightness, lensopt__coat_quad *out)
{
    lensopt__coat_quad sum;
    int32_t l;
    for (l = 0; l < LENSOPT__COAT_LANES; l++) {
        double per, r, g, b;
        sum.v[l] = rgb[0].v[l] + rgb[1].v[l] + rgb[2].v[l];
        per = 1 / sum.v[l];
        r = rgb[0].v[l] * per - ghost->goal[0];
        g = rgb[1].v[l] * per - ghost->goal[1];
        b = rgb[2].v[l] * per - ghost->goal[2];
        out->v[l] = r * r + g * g + b * b;
    }
    for (l = 0; l < LENSOPT__COAT_LANES; l++) out->v[l] = sqrt(out->v[l]);
    if (!(brightness > 0)) return;
    sum = lensopt__coat_logs(sum);
    for (l = 0; l < LENSOPT__COAT_LANES; l++) out->v[l] += brightness * fabs(sum.v[l] - ghost->level);
}

LENSOPT__COAT_FAST static void lensopt__coat_evaluate_four(const lensopt_coatings *c, const double *const *x, lensopt__coat_quad *f)
{
    const lensopt__coat_shown *shown = (const lensopt__coat_shown *)c->shown.items;
    lensopt__coat_quad value[LENSOPT__COAT_NODES], rgb[LFLARE_WAVELENGTHS], distance;
    int32_t g, l;
    lensopt__coat_values(c, x, value);
    memset(f, 0, sizeof *f);
    for (g = 0; g < c->shown.count; g++) {
        lensopt__coat_w(c, g, value, rgb);
        lensopt__coat_distances(&shown[g], rgb, c->brightness, &distance);
        for (l = 0; l < LENSOPT__COAT_LANES; l++) f->v[l] += shown[g].weight * distance.v[l];
    }
}

static void lensopt__coat_evaluate(void *user, const double *x, int32_t count, double *f)
{
    const lensopt_coatings *c = (const lensopt_coatings *)user;
    int32_t i, l;
    for (i = 0; i < count; i += LENSOPT__COAT_LANES) {
        const double *lanes[LENSOPT__COAT_LANES];
        lensopt__coat_quad four;
        for (l = 0; l < LENSOPT__COAT_LANES; l++) lanes[l] = x + (size_t)(i + l < count ? i + l : count - 1) * (size_t)c->variables;
        lensopt__coat_evaluate_four(c, lanes, &four);
        for (l = 0; l < LENSOPT__COAT_LANES && i + l < count; l++) f[i + l] = four.v[l];
    }
}

/* -- going downhill -- */

/* A candidate and what its surroundings look like; one block of memory. */
typedef struct lensopt__coat_slopes {
    const lensopt_coatings *c;
    double *value, *by;         /* of nodes and running sums; derivatives of nodes by their surface's two variables at most */
    double *rows;               /* of one ghost's channels, then of its residuals: variables each */
    double *normal, *factor, *gradient, *step, *trial; /* variables^2 twice, variables, LENSOPT__COAT_LANES x variables twice */
} lensopt__coat_slopes;

static int32_t lensopt__coat_per_coat(const lensopt_coatings *c) { return c->film == LENSOPT_FILM_LAYER ? 2 : 1; }

static lensopt__coat_slopes lensopt__coat_slopes_make(const lensopt_coatings *c)
{
    lensopt__coat_slopes s;
    size_t n = (size_t)c->variables, nodes = (size_t)c->nodes.count + (size_t)(LFLARE_WAVELENGTHS * (c->coat_count + 1));
    memset(&s, 0, sizeof s);
    s.c = c;
    s.value = (double *)malloc(sizeof(double) * (3 * nodes + (size_t)(LFLARE_WAVELENGTHS + 1 + 1 + 2 * LENSOPT__COAT_LANES) * n + 2 * n * n));
    if (s.value == NULL) return s;
    s.by = s.value + nodes;
    s.rows = s.by + 2 * nodes;
    s.gradient = s.rows + (LFLARE_WAVELENGTHS + 1) * n;
    s.step = s.gradient + n;
    s.trial = s.step + LENSOPT__COAT_LANES * n;
    s.normal = s.trial + LENSOPT__COAT_LANES * n;
    s.factor = s.normal + n * n;
    return s;
}

/* lensopt__coat_values of one candidate, with derivatives. */
static void lensopt__coat_slopes_at(lensopt__coat_slopes *s, const double *x)
{
    const lensopt_coatings *c = s->c;
    const lensopt__coat_node *nodes = (const lensopt__coat_node *)c->nodes.items;
    const lensopt__coat_panel *panels = (const lensopt__coat_panel *)c->panels.items;
    double *sums = s->value + c->nodes.count, *v = s->value, (*by)[2] = (double (*)[2])s->by;
    int32_t i, k, j, p, coat, channel;
    for (coat = 0; coat < c->coat_count; coat++) {
        double layer[2], of[2][2] = {{0, 0}, {0, 0}};
        lensopt__coat_layer_of(c, coat, x, layer, of);
        for (i = c->coats[coat].node; i < c->coats[coat].end; i++) {
            double n2, d, r = lensopt__coat_film_slopes(&nodes[i], layer[0], layer[1], &n2, &d), scale = i < c->coats[coat].mirror ? -1 / (1 - r) : 1;
            v[i] = i < c->coats[coat].mirror ? log(1 - r) : r;
            for (j = 0; j < 2; j++) by[i][j] = scale * (n2 * of[j][0] + d * of[j][1]);
        }
    }
    for (p = 0; p < c->panels.count; p++)
        for (k = 1; k < panels[p].count; k++)
            for (i = panels[p].count - 1; i >= k; i--) {
                int32_t at = panels[p].node + i;
                double step = panels[p].step[k][i];
                v[at] = (v[at] - v[at - 1]) * step;
                for (j = 0; j < 2; j++) by[at][j] = (by[at][j] - by[at - 1][j]) * step;
            }
    for (channel = 0; channel < LFLARE_WAVELENGTHS; channel++) {
        double sum = 0;
        *sums++ = sum;
        for (coat = 0; coat < c->coat_count; coat++) {
            if (c->coats[coat].main[channel] >= 0) sum += v[panels[c->coats[coat].main[channel]].node];
            *sums++ = sum;
        }
    }
}

/* Adds `scale` times the derivatives of a sum of terms to a row; returns the sum. */
static double lensopt__coat_sum_slopes(const lensopt__coat_slopes *s, lensopt__coat_span span, int32_t channel, double scale, double *row)
{
    const lensopt_coatings *c = s->c;
    const lensopt__coat_node *nodes = (const lensopt__coat_node *)c->nodes.items;
    const lensopt__coat_panel *panels = (const lensopt__coat_panel *)c->panels.items;
    const lensopt__coat_term *terms = (const lensopt__coat_term *)c->terms.items;
    double ends[LFLARE_MAX_SURFACES + 1], sum = 0, run = 0;
    int32_t i, j, coat, per = lensopt__coat_per_coat(c), first = c->nodes.count + channel * (c->coat_count + 1);
    memset(ends, 0, sizeof(double) * (size_t)(c->coat_count + 1));
    for (i = span.begin; i < span.end; i++) {
        int32_t at = terms[i].at;
        sum += terms[i].weight * s->value[at];
        if (at >= c->nodes.count) ends[at - first] += terms[i].weight; /* of a running sum: all coats before that */
        else for (j = 0; j < per; j++) row[per * nodes[at].coat + j] += scale * terms[i].weight * s->by[2 * at + j];
    }
    for (coat = c->coat_count - 1; coat >= 0; coat--) {
        run += ends[coat + 1];
        for (j = 0; j < per && run != 0 && c->coats[coat].main[channel] >= 0; j++) row[per * coat + j] += scale * run * s->by[2 * panels[c->coats[coat].main[channel]].node + j];
    }
    return sum;
}

/* W of one ghost, and its derivatives in three rows. */
static void lensopt__coat_w_slopes(const lensopt__coat_slopes *s, int32_t ghost, double *rgb)
{
    const lensopt_coatings *c = s->c;
    const lensopt__coat_span *mirrors = (const lensopt__coat_span *)c->mirrors.items;
    const lensopt__coat_beam *beam = (const lensopt__coat_beam *)c->beams.items + LFLARE_WAVELENGTHS * ghost;
    int32_t channel, i, k, v, n = c->variables;
    memset(s->rows, 0, sizeof(double) * (size_t)(LFLARE_WAVELENGTHS * n));
    for (channel = 0; channel < LFLARE_WAVELENGTHS; channel++, beam++) {
        double *row = s->rows + channel * n, mirror[4], through;
        through = beam->fixed * exp(lensopt__coat_sum_slopes(s, beam->terms, channel, 1, row));
        rgb[channel] = through;
        for (i = beam->mirrors.begin; i < beam->mirrors.end; i++) rgb[channel] *= mirror[i - beam->mirrors.begin] = lensopt__coat_sum_slopes(s, mirrors[i], channel, 0, row);
        for (v = 0; v < n; v++) row[v] *= rgb[channel];
        for (i = beam->mirrors.begin; i < beam->mirrors.end; i++) {
            double others = through;
            for (k = beam->mirrors.begin; k < beam->mirrors.end; k++) others *= k == i ? 1 : mirror[k - beam->mirrors.begin];
            lensopt__coat_sum_slopes(s, mirrors[i], channel, others, row);
        }
    }
}

/* A ghost's residuals, those of its hue and, with brightness, that of its sum, and their derivatives in so many rows; returns the number of
   rows, 0 where there is no light. */
static int32_t lensopt__coat_residuals(const lensopt__coat_slopes *s, int32_t ghost, double *out)
{
    const lensopt_coatings *c = s->c;
    const lensopt__coat_shown *at = (const lensopt__coat_shown *)c->shown.items + ghost;
    double rgb[LFLARE_WAVELENGTHS], sum;
    int32_t k, v, n = c->variables;
    lensopt__coat_w_slopes(s, ghost, rgb);
    sum = rgb[0] + rgb[1] + rgb[2];
    if (!(sum > 0)) return 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) out[k] = rgb[k] / sum - at->goal[k];
    out[LFLARE_WAVELENGTHS] = c->brightness > 0 ? c->brightness * (log(sum) - at->level) : 0;
    for (v = 0; v < n; v++) {
        double *row = s->rows + v, all = (row[0] + row[n] + row[2 * n]) / sum;
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) row[k * n] = row[k * n] / sum - rgb[k] / sum * all;
        row[LFLARE_WAVELENGTHS * n] = c->brightness * all;
    }
    return c->brightness > 0 ? LFLARE_WAVELENGTHS + 1 : LFLARE_WAVELENGTHS;
}

/* Adds one residual to the normal equations, its variables in units of their ranges. */
static void lensopt__coat_normal_add(const lensopt__coat_slopes *s, const double *row, double residual, double weight)
{
    int32_t n = s->c->variables, i, k;
    for (i = 0; i < n; i++) {
        double w = weight * row[i], *a = s->normal + (size_t)i * (size_t)n;
        s->gradient[i] += w * residual;
        for (k = 0; k <= i; k++) a[k] += w * row[k];
    }
}

/* The normal equations at a point where f is known. Squares of a distance are weighed by 1 over it, which makes them
   distances, but by no more than 1 over the mean: ghosts that have nearly all they want shall not rule. */
static void lensopt__coat_normal_make(const lensopt__coat_slopes *s, double f)
{
    const lensopt_coatings *c = s->c;
    const lensopt__coat_shown *shown = (const lensopt__coat_shown *)c->shown.items;
    double residual[LFLARE_WAVELENGTHS + 1], floor_hue, total = 0;
    int32_t g, k, v, n = c->variables, count;
    memset(s->normal, 0, sizeof(double) * (size_t)n * (size_t)n);
    memset(s->gradient, 0, sizeof(double) * (size_t)n);
    for (g = 0; g < c->shown.count; g++) total += shown[g].weight;
    floor_hue = f / total + 1e-300;
    for (g = 0; g < c->shown.count; g++) {
        double hue, sum;
        count = lensopt__coat_residuals(s, g, residual);
        if (count == 0) continue;
        for (k = 0; k < count; k++)
            for (v = 0; v < n; v++) s->rows[k * n + v] *= c->upper[v] - c->lower[v];
        hue = sqrt(residual[0] * residual[0] + residual[1] * residual[1] + residual[2] * residual[2]);
        sum = fabs(residual[LFLARE_WAVELENGTHS]);
        for (k = 0; k < count; k++) lensopt__coat_normal_add(s, s->rows + k * n, residual[k], shown[g].weight / fmax(k < LFLARE_WAVELENGTHS ? hue : sum, floor_hue));
    }
}

/* The variables that may move: not those at a bound which would leave it. free: variables. */
static int32_t lensopt__coat_free(const lensopt__coat_slopes *s, const double *x, int32_t *free)
{
    const lensopt_coatings *c = s->c;
    int32_t v, n = 0;
    for (v = 0; v < c->variables; v++)
        if (c->upper[v] > c->lower[v] && !(x[v] <= c->lower[v] && s->gradient[v] > 0) && !(x[v] >= c->upper[v] && s->gradient[v] < 0)) free[n++] = v;
    return n;
}

/* The step that the normal equations advise with that damping, by Cholesky's factors; 0 if there is none. */
static int lensopt__coat_advise(const lensopt__coat_slopes *s, const int32_t *free, int32_t count, double damping, double *step)
{
    size_t n = (size_t)s->c->variables;
    double part[2 * LFLARE_MAX_SURFACES];
    int32_t i, k, j;
    for (i = 0; i < count; i++) {
        double *row = s->factor + (size_t)i * n;
        for (k = 0; k <= i; k++) {
            const double *other = s->factor + (size_t)k * n;
            double sum = s->normal[(size_t)free[i] * n + (size_t)free[k]];
            if (k == i) sum += damping * (sum + 1e-9 * s->normal[(size_t)free[0] * n + (size_t)free[0]]) + 1e-300;
            for (j = 0; j < k; j++) sum -= row[j] * other[j];
            if (k < i) row[k] = sum / other[k];
            else if (!(sum > 0)) return 0;
            else row[i] = sqrt(sum);
        }
        part[i] = -s->gradient[free[i]];
        for (k = 0; k < i; k++) part[i] -= row[k] * part[k];
        part[i] /= row[i];
    }
    memset(step, 0, sizeof(double) * n);
    for (i = count - 1; i >= 0; i--) {
        for (k = i + 1; k < count; k++) part[i] -= s->factor[(size_t)k * n + (size_t)i] * part[k];
        part[i] /= s->factor[(size_t)i * n + (size_t)i];
        step[free[i]] = part[i];
    }
    return 1;
}

/* Tries four dampings at once, each 16 times the one before; the best takes x's place if it is better, and *damping becomes its. */
static int lensopt__coat_try_four(const lensopt__coat_slopes *s, double *x, double *f, double *damping)
{
    const lensopt_coatings *c = s->c;
    int32_t free[2 * LFLARE_MAX_SURFACES], l, v, n = c->variables, best = -1, count = lensopt__coat_free(s, x, free);
    double tried = *damping, value[LENSOPT__COAT_LANES];
    if (count == 0) *damping = HUGE_VAL; /* nothing can move */
    if (count == 0) return 0;
    for (l = 0; l < LENSOPT__COAT_LANES; l++, tried *= 16) {
        double *trial = s->trial + l * n;
        memcpy(trial, x, sizeof(double) * (size_t)n);
        if (!lensopt__coat_advise(s, free, count, tried, s->step)) continue;
        for (v = 0; v < n; v++) trial[v] = fmin(fmax(x[v] + s->step[v] * (c->upper[v] - c->lower[v]), c->lower[v]), c->upper[v]);
    }
    lensopt__coat_evaluate((void *)(uintptr_t)c, s->trial, LENSOPT__COAT_LANES, value);
    for (l = 0; l < LENSOPT__COAT_LANES; l++)
        if (value[l] < *f && (best < 0 || value[l] < value[best])) best = l;
    *damping = tried;
    if (best < 0) return 0;
    for (l = LENSOPT__COAT_LANES; l > best; l--) *damping /= 16;
    memcpy(x, s->trial + best * n, sizeof(double) * (size_t)n);
    *f = value[best];
    return 1;
}

/* A step is worth its four evaluations and about as many again for the derivatives. */
static int32_t lensopt__coat_polish(void *user, double *x, double *f, int32_t steps)
{
    const lensopt_coatings *c = (const lensopt_coatings *)user;
    lensopt__coat_slopes s;
    double damping = 1e-4;
    int32_t done = 0, slow = 0;
    if (steps <= 0 || !(*f < HUGE_VAL)) return 0;
    s = lensopt__coat_slopes_make(c);
    if (s.value == NULL) return 0;
    while (done < steps && slow < 3 && *f > 0) {
        double before = *f;
        lensopt__coat_slopes_at(&s, x);
        lensopt__coat_normal_make(&s, *f);
        damping = fmax(damping / 16, 1e-12);
        done++;
        while (!lensopt__coat_try_four(&s, x, f, &damping) && damping < 1e6) done++;
        if (!(*f < before)) break;
        slow = *f > before * (1 - 1e-4) ? slow + 1 : 0;
    }
    free(s.value);
    return done * 2 * LENSOPT__COAT_LANES;
}

/* -- making -- */

static void *lensopt__coat_libc_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(block);
        return NULL;
    }
    return realloc(block, new_size);
}

/* One more item, all zeroes; NULL if memory is out. */
static void *lensopt__coat_more(lensopt_coatings *c, lensopt__coat_list *list)
{
    if (list->count == list->room) {
        size_t grown = 2 * (size_t)list->room + 64;
        void *items = grown < (size_t)INT32_MAX / list->item ? c->allocate(c->user, list->items, (size_t)list->room * list->item, grown * list->item) : NULL;
        if (items == NULL) return NULL;
        list->items = items;
        list->room = (int32_t)grown;
    }
    return memset((char *)list->items + (size_t)list->count++ * list->item, 0, list->item);
}

static void lensopt__coat_drop(lensopt_coatings *c, lensopt__coat_list *list)
{
    if (list->items != NULL) c->allocate(c->user, list->items, (size_t)list->room * list->item, 0);
    list->items = NULL;
    list->count = list->room = 0;
}

/* Gives back room that is not used, if the allocator likes. */
static void lensopt__coat_trim(lensopt_coatings *c, lensopt__coat_list *list)
{
    void *items = list->count > 0 ? c->allocate(c->user, list->items, (size_t)list->room * list->item, (size_t)list->count * list->item) : NULL;
    if (items == NULL) return;
    list->items = items;
    list->room = list->count;
}

static lflare_result lensopt__coat_no_memory(lflare_error *error) { return lensopt__fail(error, LFLARE_ERROR_MEMORY, "out of memory"); }

/* Finite bounds, lower first. */
static int lensopt__coat_bounds(const double *asked, double lo, double hi, double least, double most, double *out)
{
    int plain = asked[0] == 0 && asked[1] == 0;
    out[0] = plain ? lo : asked[0];
    out[1] = plain ? hi : asked[1];
    return lensopt__within(out[0], least, most) && lensopt__within(out[1], out[0], most);
}

/* Free surfaces, and what their variables may be. */
static lflare_result lensopt__coat_choose_coats(lensopt_coatings *c, const lensopt_coatings_desc *desc, lflare_error *error)
{
    const lflare_lens *lens = desc->lens;
    double bounds[3][2];
    int32_t row, v, per = lensopt__coat_per_coat(c);
    lflare_medium before;
    memset(&before, 0, sizeof before);
    if (!lensopt__coat_bounds(desc->nm, 200, 750, 100, 20000, bounds[0])) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "bounds of design wavelengths within 100 and 20000 nm were expected");
    if (!lensopt__coat_bounds(desc->index, 1.38, 1.9, 1.3, 4, bounds[1])) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "bounds of a layer's index within 1.3 and 4 were expected");
    if (!lensopt__coat_bounds(desc->thickness, 25, 750, 1, 10000, bounds[2])) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "bounds of a layer's thickness within 1 and 10000 nm were expected");
    for (row = 0; row < lens->surface_count; row++) {
        const lflare_medium *behind = &lens->prescription.surfaces[row].medium;
        lensopt__coated *coat = &c->coats[c->coat_count];
        int air = (before.kind == LFLARE_MEDIUM_AIR) + (behind->kind == LFLARE_MEDIUM_AIR);
        if (row == lens->stop) continue; /* which keeps the medium in front of it */
        coat->media[0] = before;
        coat->media[1] = before = *behind;
        coat->row = row;
        if (air == 2 || (air == 0 && !desc->cemented) || desc->target->locks[row] & LENSOPT_LOCK_COATING) continue;
        for (v = 0; v < per; v++) {
            c->lower[c->variables] = bounds[per == 1 ? 0 : 1 + v][0];
            c->upper[c->variables] = bounds[per == 1 ? 0 : 1 + v][1];
            c->blocks[c->variables++] = c->coat_count;
        }
        c->coat_count++;
    }
    c->least = per == 1 ? 1.38 * 1.38 : bounds[1][0] * bounds[1][0];
    return c->coat_count > 0 ? LFLARE_OK : lensopt__fail(error, LFLARE_ERROR_LENS, "no surface is free to be coated: all between glass and air have locked coatings");
}

/* -- which ghost of the lens a ghost of the target is -- */

typedef struct lensopt__coat_pairing {
    const lensopt_target *target;
    const lensopt_goal *spots;     /* of the lens's ghosts: target->light_count each */
    const int32_t *rows, *columns; /* ghosts of the target and of the lens that are still alone */
    int32_t row_count, column_count;
    double scale;                  /* 1 over the sum of the lights' weights */
} lensopt__coat_pairing;

/* How far a ghost of the lens is from what one of the target should be, mm^2. A column behind the last stands for none, for which any other is
   preferred. */
static double lensopt__coat_pairing_cost(const lensopt__coat_pairing *p, int32_t row, int32_t column)
{
    const lensopt_ghost *ghost = &p->target->ghosts[p->rows[row]];
    const lensopt_goal *spots;
    double cost = 0;
    int32_t i;
    if (column >= p->column_count) return 1e9;
    spots = p->spots + (size_t)p->columns[column] * (size_t)p->target->light_count;
    for (i = 0; i < p->target->light_count; i++) {
        double x = ghost->goals[i].centre - spots[i].centre, y = ghost->goals[i].radius - spots[i].radius;
        if (ghost->goals[i].wish != LENSOPT_SPOT) continue;
        cost += p->target->lights[i].weight * p->scale * (spots[i].wish == LENSOPT_SPOT ? fmin(x * x + y * y, 1e8) : 1e8);
    }
    return cost;
}

/* Rows are given columns one after the other by the shortest augmenting path (Kuhn's Hungarian method with Dijkstra's search). Row and column
   0 of the arrays stand for none. work: 3 * columns + rows doubles, owner and way: columns each, rows and columns counted with these. */
static void lensopt__coat_pairing_solve(const lensopt__coat_pairing *p, int32_t columns, double *work, int32_t *owner, int32_t *way)
{
    double *potential = work, *least = work + columns, *used = least + columns, *price = used + columns;
    int32_t row, k, at, next, m = columns - 1;
    memset(work, 0, sizeof(double) * (size_t)(3 * columns + p->row_count + 1));
    memset(owner, 0, sizeof(int32_t) * (size_t)columns);
    for (row = 1; row <= p->row_count; row++) {
        owner[0] = row;
        for (k = 0; k <= m; k++) {
            least[k] = HUGE_VAL;
            used[k] = 0;
        }
        for (at = 0; owner[at] != 0; at = next) {
            double delta = HUGE_VAL;
            used[at] = 1;
            for (next = 0, k = 1; k <= m; k++) {
                double cost;
                if (used[k] != 0) continue;
                cost = lensopt__coat_pairing_cost(p, owner[at] - 1, k - 1) - price[owner[at]] - potential[k];
                if (cost < least[k]) {
                    least[k] = cost;
                    way[k] = at;
                }
                if (least[k] < delta) {
                    delta = least[k];
                    next = k;
                }
            }
            for (k = 0; k <= m; k++) {
                if (used[k] != 0) {
                    price[owner[k]] += delta;
                    potential[k] -= delta;
                } else least[k] -= delta;
            }
        }
        for (; at != 0; at = way[at]) owner[at] = owner[way[at]];
    }
}

/* A ghost's spots for all lights, as a target has them. */
static void lensopt__coat_goals(const lensopt_coatings_desc *desc, double iris, lflare_pair pair, lensopt_goal *out)
{
    lensopt_spot spot;
    int32_t i;
    for (i = 0; i < desc->target->light_count; i++) {
        lensopt_spots(desc->lens, &pair, 1, lensopt_slope(&desc->target->lights[i]), iris, &spot);
        out[i].wish = spot.radius >= 1e-6 && spot.radius <= 1e6 && fabs(spot.centre) <= 1e6 ? LENSOPT_SPOT : LENSOPT_SPOT_HIDDEN;
        out[i].centre = spot.centre;
        out[i].radius = spot.radius;
    }
}

/* Whether a ghost of the target has a spot to go by. */
static int lensopt__coat_has_spot(const lensopt_target *t, const lensopt_ghost *g)
{
    int32_t i;
    for (i = 0; i < t->light_count; i++)
        if (g->goals[i].wish == LENSOPT_SPOT && t->lights[i].weight > 0) return 1;
    return 0;
}

/* match: of each ghost of the target the lens's ghost, -1: none. By spots, for those whose entry is -1; taken says which of the lens's are. */
static lflare_result lensopt__coat_match_spots(lensopt_coatings *c, const lensopt_coatings_desc *desc, double iris, const lflare_pair *pairs, int32_t count, const char *taken, int32_t *match)
{
    const lensopt_target *t = desc->target;
    lensopt__coat_pairing p;
    int32_t i, columns, *rows, *owner;
    size_t lights = (size_t)t->light_count, all = (size_t)count + (size_t)t->ghost_count + 1;
    size_t size = sizeof(lensopt_goal) * (size_t)count * lights + sizeof(double) * (3 * all + (size_t)t->ghost_count + 1) + sizeof(int32_t) * (4 * all);
    char *block = (char *)c->allocate(c->user, NULL, 0, size);
    double *work;
    if (block == NULL) return LFLARE_ERROR_MEMORY;
    memset(&p, 0, sizeof p);
    p.target = t;
    p.spots = (const lensopt_goal *)(void *)block;
    work = (double *)(void *)(block + sizeof(lensopt_goal) * (size_t)count * lights);
    rows = (int32_t *)(void *)(work + 3 * all + (size_t)t->ghost_count + 1);
    owner = rows + 2 * all;
    p.rows = rows;
    p.columns = rows + all;
    for (i = 0; i < t->ghost_count; i++)
        if (match[i] < 0 && lensopt__coat_has_spot(t, &t->ghosts[i])) rows[p.row_count++] = i;
    for (i = 0; i < count; i++) {
        if (taken[i]) continue;
        rows[all + (size_t)p.column_count++] = i;
        lensopt__coat_goals(desc, iris, pairs[i], (lensopt_goal *)(void *)block + (size_t)i * lights);
    }
    for (i = 0; i < t->light_count; i++) p.scale += t->lights[i].weight;
    p.scale = p.scale > 0 ? 1 / p.scale : 0;
    columns = p.column_count + p.row_count + 1;
    lensopt__coat_pairing_solve(&p, columns, work, owner, owner + all);
    for (i = 1; i <= p.column_count; i++)
        if (owner[i] > 0) match[rows[owner[i] - 1]] = p.columns[i - 1];
    c->allocate(c->user, block, size, 0);
    return LFLARE_OK;
}

/* c->matched: the lens's pair of each ghost of the target. */
static lflare_result lensopt__coat_match_ghosts(lensopt_coatings *c, const lensopt_coatings_desc *desc, double iris)
{
    const lensopt_target *t = desc->target;
    int32_t match[LENSOPT_MAX_GHOSTS], count = desc->lens->ghost_count, i, k, alone = 0;
    size_t size = (sizeof(lflare_pair) + 1) * (size_t)(count + 1);
    lflare_pair *pairs = (lflare_pair *)c->allocate(c->user, NULL, 0, size);
    lflare_result result = pairs == NULL ? LFLARE_ERROR_MEMORY : LFLARE_OK;
    char *taken = (char *)(pairs + count + 1);
    if (result != LFLARE_OK) return result;
    memset(taken, 0, (size_t)count + 1);
    lflare_ghost_list(desc->lens, pairs, &count);
    for (i = 0; i < t->ghost_count; i++) {
        match[i] = -1;
        for (k = 0; k < count && desc->matching == LENSOPT_MATCHING_PAIRS && match[i] < 0; k++)
            if (memcmp(&pairs[k], &t->ghosts[i].pair, sizeof pairs[k]) == 0) taken[match[i] = k] = 1;
        alone += match[i] < 0;
    }
    if (alone > 0) result = lensopt__coat_match_spots(c, desc, iris, pairs, count, taken, match);
    for (i = 0; i < t->ghost_count && result == LFLARE_OK; i++) {
        lflare_pair *pair = (lflare_pair *)lensopt__coat_more(c, &c->matched);
        if (pair == NULL) result = LFLARE_ERROR_MEMORY;
        else if (match[i] >= 0) *pair = pairs[match[i]];
        else pair->first = -1;
    }
    c->allocate(c->user, pairs, size, 0);
    return result;
}

/* -- what is known of their paths -- */

/* One channel of a ghost: crossings of surfaces that are coated go into the list, the others' shares into `fixed`. */
static lflare_result lensopt__coat_beam_make(lensopt_coatings *c, const lflare_lens *lens, const lensopt__meeting *at, int32_t count, int32_t channel, lensopt__coat_beam *beam)
{
    lflare_layer layers[LFLARE_MAX_LAYERS];
    int32_t i, k;
    beam->fixed = count > 0;
    beam->passes.begin = c->passes.count;
    for (i = 0; i < count; i++) {
        int32_t films = LFLARE_MAX_LAYERS;
        lensopt__coat_pass *pass;
        for (k = 0; k < c->coat_count && c->coats[k].row != at[i].surface; k++) {}
        if (k == c->coat_count || at[i].sine >= at[i].n0 || at[i].sine >= at[i].n1) { /* total reflection, whatever the coating is */
            lflare_film_layers(lens, at[i].surface, layers, &films);
            beam->fixed *= lensopt__share(&at[i], layers, films, lensopt__nm[channel]);
            continue;
        }
        if (at[i].sine * at[i].sine > 0.6 * c->least) beam->fixed = 0; /* between glasses so obliquely that no light comes from air */
        pass = (lensopt__coat_pass *)lensopt__coat_more(c, &c->passes);
        if (pass == NULL) return LFLARE_ERROR_MEMORY;
        pass->s2 = fmin(at[i].sine * at[i].sine, 0.6 * c->least);
        pass->coat = k;
        pass->mirror = at[i].reflected;
    }
    beam->passes.end = c->passes.count;
    return LFLARE_OK;
}

/* A ghost of the target becomes one that counts, if it does. */
static lflare_result lensopt__coat_shown_make(lensopt_coatings *c, const lensopt_coatings_desc *desc, double iris, int32_t index)
{
    const lensopt_ghost *ghost = &desc->target->ghosts[index];
    lensopt__meeting at[LFLARE_MAX_CIRCLES];
    lensopt_goal goals[LENSOPT_MAX_LIGHTS];
    lensopt__coat_shown shown, *kept;
    lflare_ghost_matrices m;
    lflare_region region;
    double sum = ghost->color[0] + ghost->color[1] + ghost->color[2], light = 0;
    int32_t k, beams = c->beams.count, passes = c->passes.count;
    memset(&shown, 0, sizeof shown);
    shown.pair = ((const lflare_pair *)c->matched.items)[index];
    if (!(sum > 0) || !(ghost->weight > 0) || shown.pair.first < 0) return LFLARE_OK;
    lensopt__coat_goals(desc, iris, shown.pair, goals);
    while (shown.light < desc->target->light_count && goals[shown.light].wish != LENSOPT_SPOT) shown.light++;
    if (shown.light == desc->target->light_count) return LFLARE_OK;
    shown.target = index;
    shown.u = lensopt_slope(&desc->target->lights[shown.light]);
    shown.weight = ghost->weight;
    lflare_ghost_optics(desc->lens, lensopt__nm[1], &shown.pair, 1, &m);
    lflare_ghost_clip(desc->lens, lensopt__nm[1], shown.pair, iris, shown.u, &region);
    shown.scale = 1 / sqrt(1 + shown.u * shown.u) / fmax(m.m.a * m.m.a, 1e-12);
    shown.level = log(sum / shown.scale);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        lensopt__coat_beam *beam = (lensopt__coat_beam *)lensopt__coat_more(c, &c->beams);
        int32_t count = lensopt__meetings(desc->lens, lensopt__nm[k], shown.pair, region.centroid, shown.u, at);
        if (beam == NULL || lensopt__coat_beam_make(c, desc->lens, at, count, k, beam) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
        shown.goal[k] = ghost->color[k] / sum;
        light += beam->fixed;
    }
    if (!(light > 0)) { /* dark whatever the coatings are */
        c->beams.count = beams;
        c->passes.count = passes;
        return LFLARE_OK;
    }
    kept = (lensopt__coat_shown *)lensopt__coat_more(c, &c->shown);
    if (kept == NULL) return LFLARE_ERROR_MEMORY;
    *kept = shown;
    return LFLARE_OK;
}

/* -- at which angles films are computed -- */

/* Films on which interpolation is tried: over the bounds, evenly and by steps that never repeat. n^2 and d. */
static void lensopt__coat_trial(const lensopt_coatings *c, int32_t coat, int32_t trial, double *out)
{
    double x[2 * LFLARE_MAX_SURFACES], t = (double)trial / (LENSOPT__COAT_TRIALS - 1);
    int32_t per = lensopt__coat_per_coat(c), v = per * coat;
    x[v] = c->lower[v] + (c->upper[v] - c->lower[v]) * t;
    if (per == 2) x[v + 1] = c->lower[v + 1] + (c->upper[v + 1] - c->lower[v + 1]) * (trial % 8 == 7 ? 1 : fmod(0.618033988749895 * trial, 1));
    lensopt__coat_layer_of(c, coat, x, out, NULL);
}

/* Newton's basis of a panel at an angle: out[count]. */
static void lensopt__coat_basis(const lensopt_coatings *c, const lensopt__coat_panel *p, double s2, double *out)
{
    const lensopt__coat_node *nodes = (const lensopt__coat_node *)c->nodes.items + p->node;
    int32_t k;
    out[0] = 1;
    for (k = 1; k < p->count; k++) out[k] = out[k - 1] * (s2 - nodes[k - 1].s2);
}

/* What of one film is interpolated at a node. */
static double lensopt__coat_shape(const lensopt__coat_node *node, const double *layer, int32_t mirror)
{
    double a, b, r = lensopt__coat_film_slopes(node, layer[0], layer[1], &a, &b);
    return mirror ? r : log(1 - r);
}

/* Whether the panel, whose nodes are in the list, is good enough at nine angles for all films on trial: 2e-7 of what passes, 2e-6 of what is
   reflected, or 1e-10. */
static int lensopt__coat_panel_works(const lensopt_coatings *c, lensopt__coat_panel *p, const double *n)
{
    const lensopt__coat_node *nodes = (const lensopt__coat_node *)c->nodes.items + p->node;
    lensopt__coat_node between[9];
    double basis[9][LENSOPT__COAT_ORDER];
    int32_t i, k, trial;
    for (i = 0; i < 9; i++) {
        double s2 = p->lo + (p->hi - p->lo) * i / 8;
        lensopt__coat_node_make(&between[i], n[0], n[1], s2, lensopt__nm[p->channel], p->coat);
        lensopt__coat_basis(c, p, s2, basis[i]);
    }
    memset(p->reach, 0, sizeof p->reach);
    for (trial = 0; trial < LENSOPT__COAT_TRIALS; trial++) {
        double layer[2], v[LENSOPT__COAT_ORDER];
        lensopt__coat_trial(c, p->coat, trial, layer);
        for (k = 0; k < p->count; k++) v[k] = lensopt__coat_shape(&nodes[k], layer, p->mirror);
        for (k = 1; k < p->count; k++)
            for (i = p->count - 1; i >= k; i--) v[i] = (v[i] - v[i - 1]) * p->step[k][i];
        for (k = 0; k < p->count; k++) p->reach[k] = fmax(p->reach[k], fabs(v[k]));
        for (i = 0; i < 9; i++) {
            double exact = lensopt__coat_shape(&between[i], layer, p->mirror), sum = 0;
            for (k = 0; k < p->count; k++) sum += v[k] * basis[i][k];
            if (!(fabs(sum - exact) <= (p->mirror ? 2e-6 * exact + 1e-10 : 2e-7))) return 0;
        }
    }
    return 1;
}

/* Nodes for `count` angles in ascending order: at each of them, or Chebyshev's for their range, of which the one nearest to the angle in the middle
   of the list comes first, so that further terms are small. */
static lflare_result lensopt__coat_panel_nodes(lensopt_coatings *c, lensopt__coat_panel *p, const double *s2, int32_t count, const double *n)
{
    double at[LENSOPT__COAT_ORDER], swap;
    int32_t i, k, first = 0;
    for (k = 0; k < p->count; k++) {
        at[k] = 0.5 * (p->lo + p->hi) + 0.5 * (p->hi - p->lo) * cos(LENSOPT__PI * (2 * k + 1) / (2 * p->count));
        if (fabs(at[k] - s2[count / 2]) < fabs(at[first] - s2[count / 2])) first = k;
    }
    swap = at[0];
    at[0] = at[first];
    at[first] = swap;
    c->nodes.count = p->node;
    for (k = 0; k < p->count; k++) {
        lensopt__coat_node *node = (lensopt__coat_node *)lensopt__coat_more(c, &c->nodes);
        if (node == NULL) return LFLARE_ERROR_MEMORY;
        lensopt__coat_node_make(node, n[0], n[1], at[k], lensopt__nm[p->channel], p->coat);
        for (i = 1; i <= k; i++) p->step[i][k] = 1 / (at[k] - at[k - i]);
    }
    return LFLARE_OK;
}

/* Panels for ascending angles: as few nodes as do, else halves of the range, down to one angle. `p` says whose. */
static lflare_result lensopt__coat_panels_make(lensopt_coatings *c, lensopt__coat_panel p, const double *s2, int32_t count, const double *n)
{
    lensopt__coat_panel *kept;
    int32_t cut = 1;
    if (count == 0) return LFLARE_OK;
    p.lo = s2[0];
    p.hi = s2[count - 1];
    p.members = count;
    p.node = c->nodes.count;
    for (p.count = 1; p.count <= LENSOPT__COAT_ORDER; p.count++) {
        if (lensopt__coat_panel_nodes(c, &p, s2, count, n) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
        if (!(p.hi > p.lo) || lensopt__coat_panel_works(c, &p, n)) break;
    }
    if (p.count <= LENSOPT__COAT_ORDER) {
        kept = (lensopt__coat_panel *)lensopt__coat_more(c, &c->panels);
        if (kept == NULL) return LFLARE_ERROR_MEMORY;
        *kept = p;
        if (!(p.hi > p.lo)) kept->reach[0] = 1;
        return LFLARE_OK;
    }
    c->nodes.count = p.node;
    while (cut < count - 1 && s2[cut] < 0.5 * (p.lo + p.hi)) cut++;
    if (lensopt__coat_panels_make(c, p, s2, cut, n) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
    return lensopt__coat_panels_make(c, p, s2 + cut, count - cut, n);
}

static int lensopt__coat_ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* All nodes of one surface. scratch: as many angles as there are crossings. */
static lflare_result lensopt__coat_nodes(lensopt_coatings *c, int32_t index, double *scratch)
{
    lensopt__coated *coat = &c->coats[index];
    const lensopt__coat_beam *beams = (const lensopt__coat_beam *)c->beams.items;
    const lensopt__coat_pass *passes = (const lensopt__coat_pass *)c->passes.items;
    int32_t set, b, i, count;
    coat->node = c->nodes.count;
    for (set = 0; set < 2 * LFLARE_WAVELENGTHS; set++) {
        lensopt__coat_panel p;
        double n[2];
        int32_t begin = c->panels.count;
        memset(&p, 0, sizeof p);
        p.coat = index;
        p.mirror = set / LFLARE_WAVELENGTHS;
        p.channel = set % LFLARE_WAVELENGTHS;
        if (set == LFLARE_WAVELENGTHS) coat->mirror = c->nodes.count;
        for (count = 0, b = p.channel; b < c->beams.count; b += LFLARE_WAVELENGTHS)
            for (i = beams[b].passes.begin; i < beams[b].passes.end; i++)
                if (passes[i].coat == index && passes[i].mirror == p.mirror) scratch[count++] = passes[i].s2;
        qsort(scratch, (size_t)count, sizeof *scratch, lensopt__coat_ascending);
        for (i = 0; i < 2; i++) n[i] = lflare_index(&coat->media[i], lensopt__nm[p.channel]);
        if (lensopt__coat_panels_make(c, p, scratch, count, n) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
        if (p.mirror) continue;
        coat->main[p.channel] = -1;
        for (i = begin; i < c->panels.count; i++)
            if (coat->main[p.channel] < 0 || ((const lensopt__coat_panel *)c->panels.items)[i].members > ((const lensopt__coat_panel *)c->panels.items)[coat->main[p.channel]].members) coat->main[p.channel] = i;
    }
    coat->end = c->nodes.count;
    return LFLARE_OK;
}

/* -- tables of quarter-wave coatings -- */

/* What lensopt__coat_films has, of one candidate whose design wavelength there is `nm`. out: the surface's nodes. */
static void lensopt__coat_exact(const lensopt_coatings *c, int32_t coat, double nm, double *out)
{
    const lensopt__coat_node *nodes = (const lensopt__coat_node *)c->nodes.items;
    const lensopt__coated *at = &c->coats[coat];
    double x[LFLARE_MAX_SURFACES], layer[2];
    int32_t i;
    x[coat] = nm;
    lensopt__coat_layer_of(c, coat, x, layer, NULL);
    for (i = at->node; i < at->end; i++) out[i - at->node] = lensopt__coat_shape(&nodes[i], layer, i >= at->mirror);
}

/* One cell: cubics through four films each, four coefficients of all nodes one after the other. 0 if they are not good enough between. */
static int lensopt__coat_cell_make(const lensopt_coatings *c, int32_t coat, double nm, double width, double *cell)
{
    const lensopt__coated *at = &c->coats[coat];
    double exact[LENSOPT__COAT_NODES];
    int32_t i, k, count = at->end - at->node;
    for (k = 0; k < 4; k++) lensopt__coat_exact(c, coat, nm + width * k / 3, cell + k * count);
    lensopt__coat_exact(c, coat, nm + 0.5 * width, exact);
    for (i = 0; i < count; i++) {
        double a = cell[i], b = 3 * (cell[count + i] - a), second = 4.5 * (cell[2 * count + i] - 2 * cell[count + i] + a);
        double third = 4.5 * (cell[3 * count + i] - 3 * cell[2 * count + i] + 3 * cell[count + i] - a), sum;
        cell[count + i] = b - second / 3 + third * 2 / 9; /* of t and its powers, from Newton's form */
        cell[2 * count + i] = second - third;
        cell[3 * count + i] = third;
        sum = a + 0.5 * (cell[count + i] + 0.5 * (cell[2 * count + i] + 0.5 * third));
        if (!(fabs(sum - exact[i]) <= (at->node + i >= at->mirror ? 2e-6 * exact[i] + 2e-10 : 1e-7))) return 0;
    }
    return 1;
}

/* Where between its bounds the index of a quarter-wave coating begins or ceases to be the least there is, 1.38; `hi` if nowhere. */
static double lensopt__coat_kink(const lflare_medium *media, double lo, double hi)
{
    double end = hi;
    int32_t i, low = lflare_index(&media[0], lo) * lflare_index(&media[1], lo) > 1.38 * 1.38;
    if (low == (lflare_index(&media[0], hi) * lflare_index(&media[1], hi) > 1.38 * 1.38)) return end;
    for (i = 0; i < 60; i++) {
        double middle = 0.5 * (lo + hi);
        if ((lflare_index(&media[0], middle) * lflare_index(&media[1], middle) > 1.38 * 1.38) == low) lo = middle;
        else hi = middle;
    }
    return hi;
}

/* Films over the design wavelength, in cells of at most 7 nm, between which and the kink cubics are exact to 1e-10. Where they would not be, or
   bounds are so far apart that tables were large, there are none and films are computed. */
static lflare_result lensopt__coat_table_make(lensopt_coatings *c)
{
    int32_t coat, part, k, good = c->film == LENSOPT_FILM_QUARTER;
    for (coat = 0; coat < c->coat_count && good; coat++) {
        lensopt__coated *at = &c->coats[coat];
        double lo = c->lower[coat], hi = c->upper[coat], kink = lensopt__coat_kink(at->media, lo, hi);
        good = hi - lo <= 1200;
        at->table = c->tables.count;
        for (part = 0; part < 2 && good; part++) {
            double begin = part == 0 ? lo : kink, length = part == 0 ? kink - lo : hi - kink;
            at->cut[part] = begin;
            at->cells[part] = part == 1 && !(length > 0) ? 0 : (int32_t)ceil(length / 7 + 1e-9);
            at->per_cell[part] = length > 0 ? at->cells[part] / length : 0;
            for (k = 0; k < at->cells[part] && good; k++) {
                int32_t i, count = 4 * (at->end - at->node), first = c->tables.count;
                for (i = 0; i < count; i++)
                    if (lensopt__coat_more(c, &c->tables) == NULL) return LFLARE_ERROR_MEMORY;
                good = lensopt__coat_cell_make(c, coat, begin + length * k / at->cells[part], length / at->cells[part], (double *)c->tables.items + first);
            }
        }
    }
    if (!good) lensopt__coat_drop(c, &c->tables);
    else lensopt__coat_trim(c, &c->tables);
    return LFLARE_OK;
}

/* -- what of them each ghost takes -- */

static lflare_result lensopt__coat_term_add(lensopt_coatings *c, double weight, int32_t at)
{
    lensopt__coat_term *term = (lensopt__coat_term *)lensopt__coat_more(c, &c->terms);
    if (term == NULL) return LFLARE_ERROR_MEMORY;
    term->weight = weight;
    term->at = at;
    return LFLARE_OK;
}

static int32_t lensopt__coat_panel_of(const lensopt_coatings *c, const lensopt__coat_pass *pass, int32_t channel)
{
    const lensopt__coat_panel *p = (const lensopt__coat_panel *)c->panels.items;
    int32_t i;
    for (i = 0; i + 1 < c->panels.count; i++)
        if (p[i].coat == pass->coat && p[i].channel == channel && p[i].mirror == pass->mirror && pass->s2 <= p[i].hi) break;
    return i;
}

/* What is reflected: a sum of terms for each mirror. */
static lflare_result lensopt__coat_mirrors_make(lensopt_coatings *c, lensopt__coat_beam *beam, int32_t channel)
{
    int32_t i, k;
    beam->mirrors.begin = c->mirrors.count;
    for (i = beam->passes.begin; i < beam->passes.end; i++) {
        const lensopt__coat_pass *pass = (const lensopt__coat_pass *)c->passes.items + i;
        const lensopt__coat_panel *panel;
        double basis[LENSOPT__COAT_ORDER];
        lensopt__coat_span *mirror;
        if (!pass->mirror) continue;
        mirror = (lensopt__coat_span *)lensopt__coat_more(c, &c->mirrors);
        if (mirror == NULL) return LFLARE_ERROR_MEMORY;
        panel = (const lensopt__coat_panel *)c->panels.items + lensopt__coat_panel_of(c, pass, channel);
        lensopt__coat_basis(c, panel, pass->s2, basis);
        mirror->begin = c->terms.count;
        for (k = 0; k < panel->count; k++)
            if (lensopt__coat_term_add(c, basis[k], panel->node + k) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
        mirror->end = c->terms.count;
    }
    beam->mirrors.end = c->mirrors.count;
    return LFLARE_OK;
}

/* What passes: how often each surface is crossed, by running sums, and how angles differ from the first nodes', where it matters: terms below
   5e-7 are left. weights: of all nodes, zeroes. */
static lflare_result lensopt__coat_terms_make(lensopt_coatings *c, lensopt__coat_beam *beam, int32_t channel, double *weights)
{
    const lensopt__coat_panel *panels = (const lensopt__coat_panel *)c->panels.items;
    double often[LFLARE_MAX_SURFACES + 1];
    int32_t i, k, sums = c->nodes.count + channel * (c->coat_count + 1);
    memset(often, 0, sizeof often);
    memset(weights, 0, sizeof(double) * (size_t)c->nodes.count);
    for (i = beam->passes.begin; i < beam->passes.end; i++) {
        const lensopt__coat_pass *pass = (const lensopt__coat_pass *)c->passes.items + i;
        double basis[LENSOPT__COAT_ORDER];
        int32_t at;
        if (pass->mirror) continue;
        at = lensopt__coat_panel_of(c, pass, channel);
        lensopt__coat_basis(c, &panels[at], pass->s2, basis);
        often[pass->coat] += at == c->coats[pass->coat].main[channel];
        for (k = at == c->coats[pass->coat].main[channel]; k < panels[at].count; k++) weights[panels[at].node + k] += basis[k];
    }
    beam->terms.begin = c->terms.count;
    for (i = 0; i < c->coat_count; i++) /* surfaces that no ghost crosses add nothing */
        if (c->coats[i].main[channel] < 0 && i > 0) often[i] = often[i - 1];
    for (i = 1; i <= c->coat_count; i++) {
        double end = often[i - 1] - (i < c->coat_count ? often[i] : 0);
        if (end != 0 && lensopt__coat_term_add(c, end, sums + i) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
    }
    for (i = 0; i < c->panels.count; i++)
        for (k = 0; k < panels[i].count && !panels[i].mirror; k++) {
            double weight = weights[panels[i].node + k];
            if (fabs(weight) * panels[i].reach[k] > (k == 0 ? 0 : 5e-7) && lensopt__coat_term_add(c, weight, panels[i].node + k) != LFLARE_OK) return LFLARE_ERROR_MEMORY;
        }
    beam->terms.end = c->terms.count;
    return LFLARE_OK;
}

static lflare_result lensopt__coat_program_make(lensopt_coatings *c, lflare_error *error)
{
    size_t size = sizeof(double) * ((size_t)c->passes.count + 1);
    double weights[LENSOPT__COAT_NODES], *scratch = (double *)c->allocate(c->user, NULL, 0, size);
    lflare_result result = scratch == NULL ? LFLARE_ERROR_MEMORY : LFLARE_OK;
    int32_t i;
    for (i = 0; i < c->coat_count && result == LFLARE_OK; i++) result = lensopt__coat_nodes(c, i, scratch);
    if (scratch != NULL) c->allocate(c->user, scratch, size, 0);
    if (result != LFLARE_OK) return lensopt__coat_no_memory(error);
    i = c->nodes.count + LFLARE_WAVELENGTHS * (c->coat_count + 1);
    if (i > LENSOPT__COAT_NODES) return lensopt__fail(error, LFLARE_ERROR_LIMIT, "the ghosts need %i films, of which 4096 are taken: a target with fewer ghosts was expected", i);
    for (i = 0; i < c->beams.count && result == LFLARE_OK; i++) {
        lensopt__coat_beam *beam = (lensopt__coat_beam *)c->beams.items + i;
        result = lensopt__coat_mirrors_make(c, beam, i % LFLARE_WAVELENGTHS);
        if (result == LFLARE_OK) result = lensopt__coat_terms_make(c, beam, i % LFLARE_WAVELENGTHS, weights);
    }
    lensopt__coat_drop(c, &c->passes);
    if (result == LFLARE_OK) result = lensopt__coat_table_make(c);
    return result == LFLARE_OK ? LFLARE_OK : lensopt__coat_no_memory(error);
}

static lflare_result lensopt__coat_coatings_make(lensopt_coatings *c, const lensopt_coatings_desc *desc, lflare_error *error)
{
    double iris = desc->iris > 0 ? desc->iris : fabs(desc->lens->stop_a11) * desc->lens->efl / (2 * desc->lens->fnumber);
    lflare_result result = lensopt__coat_choose_coats(c, desc, error);
    int32_t i;
    iris = fabs(iris);
    if (result != LFLARE_OK) return result;
    result = lensopt__coat_match_ghosts(c, desc, iris);
    for (i = 0; i < desc->target->ghost_count && result == LFLARE_OK; i++) result = lensopt__coat_shown_make(c, desc, iris, i);
    if (result != LFLARE_OK) return lensopt__coat_no_memory(error);
    if (c->shown.count == 0) return lensopt__fail(error, LFLARE_ERROR_LENS, "no ghost of the target counts: ghosts with a color and a weight that the lens shows were expected");
    return lensopt__coat_program_make(c, error);
}

LENSOPT_API lflare_result lensopt_coatings_create(const lensopt_coatings_desc *desc, lensopt_coatings **out, lflare_error *error)
{
    lflare_realloc allocate;
    lensopt_coatings *c;
    lflare_result result;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (out == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a place for the coatings was expected, not NULL");
    *out = NULL;
    if (desc == NULL || desc->lens == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a lens and a target were expected, not NULL");
    if ((result = lensopt_target_check(desc->target, error)) != LFLARE_OK) return result;
    if (!lensopt__within(desc->iris, 0, 1e6)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "an iris of a radius up to 1000000 mm was expected");
    if (!lensopt__within(desc->brightness, 0, 1e9)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a weight of brightness from 0 to 1e9 was expected");
    if ((int)desc->film < LENSOPT_FILM_QUARTER || (int)desc->film > LENSOPT_FILM_LAYER) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "film is none of lensopt_film");
    if ((int)desc->matching < LENSOPT_MATCHING_PAIRS || (int)desc->matching > LENSOPT_MATCHING_SPOTS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "matching is none of lensopt_matching");
    allocate = desc->allocate != NULL ? desc->allocate : lensopt__coat_libc_realloc;
    c = (lensopt_coatings *)allocate(desc->user, NULL, 0, sizeof *c);
    if (c == NULL) return lensopt__coat_no_memory(error);
    memset(c, 0, sizeof *c);
    c->allocate = allocate;
    c->user = desc->user;
    c->film = desc->film;
    c->brightness = desc->brightness;
    c->surface_count = desc->lens->surface_count;
    c->stop = desc->lens->stop;
    c->target_count = desc->target->ghost_count;
    c->nodes.item = sizeof(lensopt__coat_node);
    c->panels.item = sizeof(lensopt__coat_panel);
    c->beams.item = sizeof(lensopt__coat_beam);
    c->terms.item = sizeof(lensopt__coat_term);
    c->mirrors.item = sizeof(lensopt__coat_span);
    c->shown.item = sizeof(lensopt__coat_shown);
    c->passes.item = sizeof(lensopt__coat_pass);
    c->matched.item = sizeof(lflare_pair);
    c->tables.item = sizeof(double);
    result = lensopt__coat_coatings_make(c, desc, error);
    if (result == LFLARE_OK) *out = c;
    else lensopt_coatings_destroy(c);
    return result;
}

LENSOPT_API void lensopt_coatings_destroy(lensopt_coatings *c)
{
    if (c == NULL) return;
    lensopt__coat_drop(c, &c->nodes);
    lensopt__coat_drop(c, &c->panels);
    lensopt__coat_drop(c, &c->beams);
    lensopt__coat_drop(c, &c->terms);
    lensopt__coat_drop(c, &c->mirrors);
    lensopt__coat_drop(c, &c->shown);
    lensopt__coat_drop(c, &c->passes);
    lensopt__coat_drop(c, &c->matched);
    lensopt__coat_drop(c, &c->tables);
    c->allocate(c->user, c, sizeof *c, 0);
}

/* -- what comes of it -- */

LENSOPT_API void lensopt_coatings_function(const lensopt_coatings *c, lensopt_function *out)
{
    memset(out, 0, sizeof *out);
    out->variables = c->variables;
    out->lower = c->lower;
    out->upper = c->upper;
    out->blocks = c->blocks;
    out->user = (void *)(uintptr_t)c; /* which is only read */
    out->evaluate = lensopt__coat_evaluate;
    out->polish = lensopt__coat_polish;
}

LENSOPT_API int32_t lensopt_coatings_surfaces(const lensopt_coatings *c, int32_t *rows)
{
    int32_t i;
    for (i = 0; i < c->coat_count && rows != NULL; i++) rows[i] = c->coats[i].row;
    return c->coat_count;
}

LENSOPT_API lflare_result lensopt_coatings_read(const lensopt_coatings *c, const lflare_prescription *p, double *x)
{
    lflare_result result = LFLARE_OK;
    int32_t i, k, per = lensopt__coat_per_coat(c);
    if (p == NULL || x == NULL || p->surface_count != c->surface_count) return LFLARE_ERROR_ARGUMENT;
    for (i = 0; i < c->coat_count; i++) {
        const lflare_surface *s = &p->surfaces[c->coats[i].row];
        double is[2] = {-1, -1};
        if (per == 1 && s->coating == LFLARE_COATING_QUARTER) is[0] = s->quarter_nm;
        if (per == 2 && s->coating == LFLARE_COATING_QUARTER) {
            is[0] = fmax(sqrt(lflare_index(&c->coats[i].media[0], s->quarter_nm) * lflare_index(&c->coats[i].media[1], s->quarter_nm)), 1.38);
            is[1] = s->quarter_nm / (4 * is[0]);
        }
        if (per == 2 && s->coating == LFLARE_COATING_STACK && s->layer_count == 1 && s->first_layer >= 0 && s->first_layer < LFLARE_MAX_LAYERS) {
            is[0] = p->layers[s->first_layer].n;
            is[1] = p->layers[s->first_layer].thickness_nm;
        }
        for (k = 0; k < per; k++) {
            double lo = c->lower[per * i + k], hi = c->upper[per * i + k];
            x[per * i + k] = !(is[0] > 0) ? 0.5 * (lo + hi) : fmin(fmax(is[k], lo), hi);
            if (x[per * i + k] != is[k]) result = LFLARE_INCOMPLETE;
        }
    }
    return result;
}

LENSOPT_API lflare_result lensopt_coatings_apply(const lensopt_coatings *c, const double *x, lflare_prescription *p, lflare_error *error)
{
    lflare_prescription q;
    lflare_lens lens;
    lflare_result result = lensopt__derive(p, &lens, error);
    int32_t i;
    if (result != LFLARE_OK) return result;
    if (x == NULL || p->surface_count != c->surface_count || lens.stop != c->stop)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "coatings, and a prescription of the lens that they are for, of %i rows, were expected", c->surface_count);
    if (p->layer_count < 0 || p->layer_count > LFLARE_MAX_LAYERS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a prescription of 0 to 1024 layers was expected, not %i", p->layer_count);
    q = *p;
    for (i = 0; i < c->coat_count; i++) lensopt__drop_layers(&q, c->coats[i].row);
    if (c->film == LENSOPT_FILM_LAYER && q.layer_count + c->coat_count > LFLARE_MAX_LAYERS)
        return lensopt__fail(error, LFLARE_ERROR_LIMIT, "the prescription would have %i layers of the 1024 that it can have: make another surface bare first", q.layer_count + c->coat_count);
    for (i = 0; i < c->coat_count; i++) {
        lflare_surface *s = &q.surfaces[c->coats[i].row];
        s->coating = c->film == LENSOPT_FILM_LAYER ? LFLARE_COATING_STACK : LFLARE_COATING_QUARTER;
        s->quarter_nm = c->film == LENSOPT_FILM_LAYER ? 0 : x[i];
        if (c->film != LENSOPT_FILM_LAYER) continue;
        s->first_layer = q.layer_count;
        s->layer_count = 1;
        q.layers[q.layer_count].n = x[2 * i];
        q.layers[q.layer_count++].thickness_nm = x[2 * i + 1];
    }
    result = lflare_lens_derive(&q, &lens, error);
    if (result == LFLARE_OK) *p = q;
    return result;
}

LENSOPT_API void lensopt_coatings_ghosts(const lensopt_coatings *c, const double *x, lensopt_coated_ghost *out)
{
    const lensopt__coat_shown *shown = (const lensopt__coat_shown *)c->shown.items;
    const double *lanes[LENSOPT__COAT_LANES];
    lensopt__coat_quad value[LENSOPT__COAT_NODES], rgb[LFLARE_WAVELENGTHS], distance;
    int32_t i, k;
    for (i = 0; i < LENSOPT__COAT_LANES; i++) lanes[i] = x;
    memset(out, 0, sizeof *out * (size_t)c->target_count);
    for (i = 0; i < c->target_count; i++) {
        out[i].pair = ((const lflare_pair *)c->matched.items)[i];
        out[i].light = -1;
    }
    lensopt__coat_values(c, lanes, value);
    for (i = 0; i < c->shown.count; i++) {
        lensopt_coated_ghost *ghost = &out[shown[i].target];
        lensopt__coat_w(c, i, value, rgb);
        lensopt__coat_distances(&shown[i], rgb, c->brightness, &distance);
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) ghost->rgb[k] = rgb[k].v[0];
        ghost->light = shown[i].light;
        ghost->scale = shown[i].scale;
        ghost->distance = distance.v[0];
    }
}

#endif /* LENSOPT_IMPLEMENTED */
#endif /* LENSOPT_IMPLEMENTATION */
