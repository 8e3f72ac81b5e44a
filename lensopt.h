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

#endif /* LENSOPT_IMPLEMENTED */
#endif /* LENSOPT_IMPLEMENTATION */
