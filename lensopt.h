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
    out->centre = m->a * region.centroid + m->b * u;
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

#endif /* LENSOPT_IMPLEMENTED */
#endif /* LENSOPT_IMPLEMENTATION */
