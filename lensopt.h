/* lensopt.h - v0.1.0 - edits a lens for its flare, and finds one for the flare that is wanted
   Optional companion of lensflare.h, under the same two licences (MIT or the Unlicense, at the end of lensflare.h).

   Do this in *one* C or C++ file to create the implementation, and include it plainly everywhere else:

       #define LENSOPT_IMPLEMENTATION
       #include "lensopt.h"

   It includes lensflare.h's declarations and calls its public stages only; one file of the program must hold the
   implementation of that, too. LENSOPT_API, before that line: your own linkage; LENSOPT_STATIC: every function static.
   LENSOPT_NO_THREADS, too: a search works on the thread that runs it alone.

   Needs libc, libm and, for searches, POSIX threads or Windows'. No globals, no output, no exit. All lengths are millimetres, angles radians, wavelengths nanometres. */

/* >> 0 documentation */
/*
   CONTENTS (the lines that begin each room; grep for "[>]>")

       >> 0 documentation
       >> 1 public interface
       >> 2 spots
       >> 3 edit
       >> 4 colour
       >> 5 target
       >> 6 problem
       >> 7 mirrors
       >> 8 assignment
       >> 9 objective
       >> 10 polish
       >> 11 lenses
       >> 12 algorithms
       >> 13 search
       >> 14 coatings

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

/* ---- search: an archipelago of algorithms over a function ---- */

enum {
    LENSOPT_MAX_VARIABLES = 512,
    LENSOPT_MAX_ISLANDS = 1024,
    LENSOPT_MAX_POPULATION = 65536, /* of an island */
    LENSOPT_MAX_THREADS = 256,
    LENSOPT_ARCHIVE = 16            /* champions of earlier lives that an island keeps */
};

/* The next number, evenly in [0,1), of a generator (splitmix64) whose whole state is *state: any value is a seed. */
LENSOPT_API double lensopt_random(uint64_t *state);

/* What is to become as small as it can. All callbacks are called from several threads at once, with 4 MB of stack, and what they give depends on their
   arguments alone; x they are given, and the x they give, is within the bounds. Points are `variables` doubles each. */
typedef struct lensopt_function {
    int32_t variables;               /* 1 to LENSOPT_MAX_VARIABLES */
    const double *lower, *upper;     /* variables each, finite, lower <= upper */
    const int32_t *blocks;           /* variables of one number belong together (those of one surface), and blocks whose numbers are near
                                        are neighbours; NULL: each variable alone */
    void *user;
    void (*evaluate)(void *user, const double *x, int32_t count, double *f); /* count points one after the other; what is not finite counts as
                                                                                the worst */
    void (*sample)(void *user, uint64_t *random, double *x);                 /* a point to start from; NULL: evenly within the bounds */
    int32_t (*polish)(void *user, double *x, double *f, int32_t steps);      /* goes downhill from x, whose value is *f, or is not known (HUGE_VAL),
                                                                                at most `steps` steps; returns how many evaluations that was
                                                                                worth; x and *f stay where nothing better is found; NULL: none */
} lensopt_function;

typedef enum lensopt_method {
    LENSOPT_MEMETIC = 0, /* children of blocks perturbed, crossed and moved by differences, each polished */
    LENSOPT_DE,          /* differential evolution, Storn & Price 1997 */
    LENSOPT_JDE,         /* which adapts its two parameters itself, Brest et al. 2006 */
    LENSOPT_PSO          /* particle swarm, Clerc & Kennedy 2002 */
} lensopt_method;

typedef enum lensopt_strategy { LENSOPT_RAND_1_BIN = 0, LENSOPT_BEST_1_EXP, LENSOPT_RAND_1_EXP, LENSOPT_BEST_1_BIN } lensopt_strategy;
typedef enum lensopt_swarm { LENSOPT_CONSTRICTION = 0, LENSOPT_INERTIA } lensopt_swarm;          /* omega times all of the new velocity, or the old one alone */
typedef enum lensopt_topology { LENSOPT_RING = 0, LENSOPT_FULL, LENSOPT_ISOLATED } lensopt_topology;
typedef enum lensopt_policy { LENSOPT_BEST_FOR_WORST = 0, LENSOPT_RANDOM_FOR_RANDOM } lensopt_policy;

/* All zeroes but for the function is fine. Where 0 is a default, 1e-300 is as good as 0. */
typedef struct lensopt_search_desc {
    lensopt_function function;    /* arrays are copied */
    lensopt_method method;
    int32_t islands;              /* 0: 15; memetic 8 */
    int32_t population;           /* of an island, at least 4; 0: 15 for each variable (Van Acoleyen 2025), at least 16; memetic 20 */
    uint64_t seed;
    int32_t threads;              /* the calling one among them, at most one an island works; 0: as many as there are processors. Results do not depend on it */
    const double *starts;         /* start_count points, copied: every island begins with them. They are moved into the bounds */
    int32_t start_count;          /* 0 to population */

    lensopt_strategy strategy;    /* DE and jDE */
    double weight, crossover;     /* DE: F, 0 to 2, 0: 0.8; CR, 0 to 1, 0: 0.9 */
    double tau1, tau2;            /* jDE: how likely F and CR are drawn anew, 0 to 1; 0: 0.1 */
    double weight_low, weight_up; /* jDE: F_l and F_u, F is F_l to F_l + F_u; 0: 0.1 and 0.9 */

    lensopt_swarm swarm;          /* PSO, defaults as pagmo has them */
    int32_t neighbours;           /* of a particle on a ring of all, half on either side, even; 0: 4; -1: all are, itself, too */
    double omega, c1, c2;         /* 0 to 1, 0: 0.7298; 0 to 4, 0: 2.05, with LENSOPT_INERTIA 1.49618, which is the same */
    double speed;                 /* the highest, in ranges of a variable, 0 to 1; 0: 0.5 */

    int32_t polish_steps;         /* memetic: 1 to 10000; 0: 40 */
    int32_t patience;             /* generations without a better point (by a thousandth) after which an island keeps its champion and
                                     begins anew; 0: memetic 50, others -1; -1: never */

    lensopt_topology topology;
    int32_t migrants;             /* from an island to another, at most population / 2; 0: 1 */
    lensopt_policy policy;        /* best: replaces the worst if it is better; random: any but the best */
    int32_t period;               /* generations from one migration to the next; 0: 10; memetic 1000. A generation of memetic islands is as many children as members */
    int32_t (*exchange)(void *user, int32_t island, const double *x, double f, double *in); /* trades with other processes: after each migration,
                                     on the thread that runs the search, for each island its best point and value; anything but 0: a point was put
                                     into `in`, which comes as a migrant does and is evaluated here. NULL: none */

    lflare_realloc allocate;      /* NULL = libc's; called by create and free alone */
    void *user;                   /* of exchange and allocate */
} lensopt_search_desc;

typedef struct lensopt_search lensopt_search;

/* Checks, copies and allocates all at once: in bytes some 8 * islands * population * (variables + 2), three times that for PSO, and as much as
   one island's again a thread. Evaluates nothing. On error *out is NULL, nothing leaks, *error (may be NULL) says why. */
LENSOPT_API lflare_result lensopt_search_create(const lensopt_search_desc *desc, lensopt_search **out, lflare_error *error);
LENSOPT_API void lensopt_search_free(lensopt_search *search); /* NULL is fine; not while it runs */

/* What ends a run. 0: no such limit. */
typedef struct lensopt_limits {
    double seconds;               /* of this run */
    int64_t evaluations;          /* of the search, those of earlier runs and of a checkpoint counted. Shared out among the islands; each ends with the
                                     generation (memetic: child) in which it has had its share, or waits at the end of a round */
    double target;                /* a value at or below which the search has succeeded */
} lensopt_limits;

typedef enum lensopt_end {
    LENSOPT_RUNNING = 0, /* or never begun */
    LENSOPT_ENDED_TARGET,
    LENSOPT_ENDED_EVALUATIONS,
    LENSOPT_ENDED_SECONDS,
    LENSOPT_ENDED_STOPPED,   /* by the callback */
    LENSOPT_ENDED_CANCELLED
} lensopt_end;

typedef struct lensopt_progress {
    int64_t evaluations;          /* of the search */
    int64_t rounds;               /* migrations so far */
    double seconds, rate;         /* of this run; its evaluations a second */
    double best;                  /* the least value so far, HUGE_VAL: none yet */
    const double *x;              /* where that was; until the callback returns, or the next call with this search */
    double diversity;             /* root mean square distance of members from the mean of their island, in ranges: 0.29 is even, 0 are copies; mean of
                                     the islands */
    double remaining;             /* seconds till a limit ends it, at this rate; negative: unknown */
    int64_t restarts;             /* of all islands */
    lensopt_end end;
} lensopt_progress;

/* Anything but 0 ends the run: that is how an interrupt does it, whose handler sets a flag that this reads. */
typedef int32_t (*lensopt_progress_callback)(void *user, const lensopt_progress *progress);

/* Searches until a limit is reached (LFLARE_OK), or until the callback or lensopt_search_cancel end it (LFLARE_INCOMPLETE); at
   least one limit or a callback is needed. What ended it is in lensopt_search_status. Go on with another run, or another process's, after lensopt_search_load: every island stops
   after a whole generation (memetic: child; before the first one: member drawn), where it then goes on, and does to the bit what it would have done unbroken; so limits
   decide where it stops and never where it goes. Two runs that evaluations alone end are the same to the byte, whatever the number of
   threads. (The machine code must be the same, too.)
   progress (may be NULL) is called on this thread, every 50 ms as far as single generations and polishes are shorter, and once at the end,
   where its answer does not matter. Where a thread cannot be started, fewer work. Nothing is allocated. LFLARE_ERROR_ARGUMENT: *error
   (may be NULL) says why. */
LENSOPT_API lflare_result lensopt_search_run(lensopt_search *search, const lensopt_limits *limits, lensopt_progress_callback progress, void *user, lflare_error *error);

/* From any thread, but no signal handler: ends the run that is on, or else the next one, when each thread has done what it is at. */
LENSOPT_API void lensopt_search_cancel(lensopt_search *search);

/* After a run: how it ended. LFLARE_ERROR_ARGUMENT, like what follows, while it runs, in its callbacks too. */
LENSOPT_API lflare_result lensopt_search_status(lensopt_search *search, lensopt_progress *out);

/* The best points that the search holds, best first, each once, those without a value left out: members of the populations
   and champions of earlier lives of islands. x: room for *count points, f (may be NULL): for *count values; *count: how
   many are wanted on entry, how many of these there are on return. */
LENSOPT_API lflare_result lensopt_search_points(lensopt_search *search, double *x, double *f, int32_t *count);

/* The whole state as bytes, the same on every machine. *size: room on entry, what is needed on return (the same for every state of a search); LFLARE_INCOMPLETE if
   there was too little, then nothing is written and bytes may be NULL. */
LENSOPT_API lflare_result lensopt_search_save(lensopt_search *search, void *bytes, size_t *size);

/* Puts a search where that one was. Both were created alike: function, starts, method and all numbers, but for seed and threads. Any bytes are safe;
   on error nothing changes and *error (may be NULL) says why: LFLARE_ERROR_SYNTAX for what is no checkpoint, or a damaged one, and
   LFLARE_ERROR_ARGUMENT for one of another search. */
LENSOPT_API lflare_result lensopt_search_load(lensopt_search *search, const void *bytes, size_t size, lflare_error *error);

/* ---- problem: what a search may change, and what it is to come near to ---- */

enum {
    LENSOPT_MAX_SEARCHED = 64, /* surfaces of a lens that is searched for, the stop not counted */
    LENSOPT_MAX_GLASSES = 1024 /* to choose from */
};

typedef enum lensopt_objective {
    LENSOPT_SEEN = 0, /* least-cost assignment of ghosts, differences in units of a spot's size, weighed by what of it is on the frame, all lights:
                         its root is a mean relative difference. A spot that is where it should be, and hidden, counts as off by its radius or more */
    LENSOPT_MATCHED,  /* the same in mm^2, all spots of weight > 0 alike at the first light: the thesis' sum without its jumps where two sizes change
                         places. A ghost too many costs 500 mm over its radius, as many times the thesis' price as there are spots: there it
                         has to be larger than all spots, lest the pairs by rank no longer fit */
    LENSOPT_THESIS    /* Van Acoleyen 2025, algorithm 1: pairs by rank of size. A lens of too few ghosts costs 1e5. Polished by the same pairs, or by least cost
                         where lenses are read from the spots */
} lensopt_objective;

typedef struct lensopt_range {
    double lo, hi; /* both 0: the default */
} lensopt_range;

/* All zeroes but the target is a valid start: from scratch, within the bounds of Van Acoleyen 2025, 5.2. A base's own numbers are always
   within bounds. */
typedef struct lensopt_problem_desc {
    const lensopt_target *target;     /* copied; spots that no light or ghost gives a weight, and ghosts of no spot, ask for nothing */
    const lflare_prescription *base;  /* copied; what locks speak of; NULL: from scratch, and no locks */
    lensopt_objective objective;
    int32_t surfaces;                 /* without the stop; 0: the base's, or as the spots tell (with MATCHED and THESIS if that makes as many ghosts), or as
                                         few as have so many ghosts (Van Acoleyen 2025, eq. 5.5) */
    int32_t keep_order;               /* 1: which gaps are air stays as in the base */
    double iris;                      /* radius on the stop plane of the base; 0: its full opening */
    double pupil;                     /* clear radius of the entrance, mm; 0: 100, so that the iris shapes the ghosts */
    lensopt_range glass_gap, air_gap; /* mm; 1 to 15, 0.1 to 100 */
    lensopt_range index;              /* of glass, at 510 nm; 1.5 to 2, or as the glasses have it */
    const lflare_medium *glasses;     /* the only ones that there are, those within `index` and the base's own; copied; NULL: any index. Of those that
                                         have the same index at 510 nm the base's, or else the first, is taken */
    int32_t glass_count;              /* up to LENSOPT_MAX_GLASSES */
    lensopt_range stop_radius;        /* mm; 0.1 to 20 */
    double least_radius;              /* of curvature, mm; 0: 5 */
    /* What makes a lens a lens: penalties for what lies outside, 0 inside; 0, 0: none. At the d line; glasses have the base's Abbe numbers, or usual ones. */
    lensopt_range efl, back_focus, fnumber, length; /* mm; back_focus: the last gap; fnumber: with the iris; length: first surface to sensor */
    double focus;                     /* the image of what is far lies this near to the sensor, mm; 0: anywhere */
    double glass_edge, air_edge;      /* least gaps at the edge of what the direct light passes, mm; 0: any */
    int32_t blind;                    /* 1: no lens is read from the spots (lensopt_problem_create) */
    lflare_realloc allocate;          /* NULL = libc's; called from the threads of a search */
    void *allocate_user;
} lensopt_problem_desc;

typedef struct lensopt_problem lensopt_problem;

/* 0.5 MB. Of lenses the paraxial ones at 510 nm: each numbers' point within the bounds is one. LFLARE_ERROR_ARGUMENT names what is contradictory.
   Where most spots of a light are those of one lens of so many surfaces, to 1e-6, whichever that is and in whatever order, they give it away (room 7): up to half of
   the points that the function's sample then gives are lenses with these spots, many different ones, since a light tells two of a surface's three numbers. Not
   where radii, gaps or the stop are locked, nor for more than 512 spots or with `blind`. That takes 0.05 s and 1 MB for 171 spots, at most 2 s and 7 MB. */
LENSOPT_API lflare_result lensopt_problem_create(const lensopt_problem_desc *desc, lensopt_problem **out, lflare_error *error);
LENSOPT_API void lensopt_problem_free(lensopt_problem *problem); /* NULL is fine */

/* Whether lenses are read from the spots: 1, and what the spots tell: how many surfaces there are in front of the stop and behind it (of one or two that have one ghost
   or none it is desc.surfaces or a guess), and the focal length at 510 nm, as far as the light is in focus. 0: they are not. */
LENSOPT_API int32_t lensopt_problem_reading(const lensopt_problem *problem, int32_t *front, int32_t *behind, double *efl);

/* As what lensopt_search_create minimises; it points into the problem. Variables: the stop's place (the surface behind which it stands,
   from 0, and the fraction of that gap; the nearest air gap is taken) and radius, then of each surface curvature, index behind it (below the
   least of glass: air; of glasses from a list the nearest is meant, and polishing changes none) and gap, but for what is locked. A sample takes 1 us, or up to
   20 ms where lenses are read from the spots: too long for populations of thousands, for which there is `blind`.
   One evaluation of THESIS costs 0.15 to 0.2 us at 13 ghosts and 1.3 to 2 us at 171 if many are asked for at once; with others all ghosts are assigned,
   which takes as long as one or more steps of polishing. */
LENSOPT_API void lensopt_problem_function(lensopt_problem *problem, lensopt_function *out);

/* The point of a lens: variables(problem) numbers, clamped to the bounds. LFLARE_ERROR_LENS where it has another number of surfaces. */
LENSOPT_API lflare_result lensopt_problem_point(const lensopt_problem *problem, const lflare_prescription *prescription, double iris, double *x, lflare_error *error);

/* The lens of a point: what the base says of it stays where the search has not changed it. Semi-diameters are as wide as light of the
   target's spots needs, as far as surfaces reach and leave glass_edge and air_edge between them; iris (may be NULL): the iris's radius that the spots are for. */
LENSOPT_API lflare_result lensopt_problem_prescription(const lensopt_problem *problem, const double *x, lflare_prescription *out, double *iris, lflare_error *error);

/* A spot of a point's lens. */
typedef struct lensopt_shown {
    lflare_pair pair;      /* in rows of its prescription */
    int32_t ghost;         /* of the target, which it stands for; -1: it is one too many */
    double centre, radius; /* mm; radius 0: hidden */
    double cost;           /* its share of the objective */
} lensopt_shown;

/* What a point's lens shows at a light. *count: room on entry, number on return; LFLARE_INCOMPLETE and the number if there was too little. */
LENSOPT_API lflare_result lensopt_problem_shows(const lensopt_problem *problem, const double *x, int32_t light, lensopt_shown *out, int32_t *count);

/* Residuals whose squares add up to the objective of SEEN or MATCHED, but for goals without a ghost, at x, and how they change with the variables while the
   assignment stays: jacobian[row * variables + variable]. Those of constraints are differences. *rows: room on entry, number on return; LFLARE_INCOMPLETE as above. */
LENSOPT_API lflare_result lensopt_problem_residuals(const lensopt_problem *problem, const double *x, double *residuals, double *jacobian, int32_t *rows);

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

static void *lensopt__libc_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(block);
        return NULL;
    }
    return realloc(block, new_size);
}

/* >> 6 problem */
/* Numbers that a search changes, and the lens that they stand for. */

typedef enum lensopt__kind { LENSOPT__PLACE, LENSOPT__IRIS, LENSOPT__CURVATURE, LENSOPT__GAP, LENSOPT__INDEX } lensopt__kind;

typedef struct lensopt__variable {
    lensopt__kind kind;
    int32_t row;
} lensopt__variable;

/* A number's place among all that a lens has. */
enum { LENSOPT__AT_C = 0, LENSOPT__AT_D = LENSOPT_MAX_SEARCHED, LENSOPT__AT_N = 2 * LENSOPT_MAX_SEARCHED, LENSOPT__AT_PLACE = 3 * LENSOPT_MAX_SEARCHED, LENSOPT__AT_IRIS, LENSOPT__NUMBERS };

static int32_t lensopt__number_at(const lensopt__variable *v)
{
    switch (v->kind) {
    case LENSOPT__PLACE: return LENSOPT__AT_PLACE;
    case LENSOPT__IRIS: return LENSOPT__AT_IRIS;
    case LENSOPT__CURVATURE: return LENSOPT__AT_C + v->row;
    case LENSOPT__GAP: return LENSOPT__AT_D + v->row;
    default: return LENSOPT__AT_N + v->row;
    }
}

/* A candidate as paraxial rays see it, the stop apart from the surfaces. */
typedef struct lensopt__design {
    int32_t surfaces, stop; /* the stop stands in the gap behind that surface; -1: in front of all */
    double ahead, iris;     /* from that surface to the stop; from the stop to the first surface where it stands in front */
    double c[LENSOPT_MAX_SEARCHED], d[LENSOPT_MAX_SEARCHED], n[LENSOPT_MAX_SEARCHED]; /* curvature; gap and index behind */
} lensopt__design;

/* Bounds of one surface's numbers; they hold the base's own. */
typedef struct lensopt__limits {
    lensopt_range glass_gap, air_gap, index;
    int32_t may_air, may_glass; /* what the gap behind it may be */
} lensopt__limits;

typedef struct lensopt__listed {
    double n, nd;                    /* at 510 nm, at the d line */
    lflare_medium medium;
} lensopt__listed;

/* Room 7 has what these are. */
typedef struct lensopt__row2 {
    double x, y;
} lensopt__row2;

typedef struct lensopt__mirror {
    double a, b, c; /* [a b; c -a] */
} lensopt__mirror;

enum { LENSOPT__READINGS = 16 };

typedef struct lensopt__mirrors {
    int32_t usable;
    int32_t count[2];                 /* found behind the stop, and in front of it */
    int32_t few, few_front;           /* surfaces known in part, and where */
    int32_t few_spots, few_ways;      /* what their ghosts may be; how many ways there are to be those of three */
    double slope, chief, marginal;    /* of the light that they are read from; its chief and marginal rays' heights at the sensor */
    lensopt__mirror group[2][LENSOPT_MAX_SEARCHED];
    uint64_t ahead[2][LENSOPT_MAX_SEARCHED]; /* bits: of which others a mirror is known to be in front */
    lensopt__row2 few_spot[LENSOPT__READINGS], few_rows[LENSOPT__READINGS][3]; /* of each way v 1,2, v 1,3 and v 2,3 */
} lensopt__mirrors;

struct lensopt_problem {
    lensopt_problem_desc desc;       /* defaults filled in; desc.target and .base point to what follows */
    lensopt_target target;
    lflare_prescription base;
    int32_t surfaces, has_base;
    int32_t constrained;             /* some of what makes a lens a lens is asked for */
    lensopt__design fixed;           /* what is no variable */
    double base_opening;             /* the base's full one */
    double abbe[LENSOPT_MAX_SEARCHED]; /* of the base's glasses; 0: air, or no base */
    int32_t glasses;                 /* to choose from, by index at 510 nm; 0: any index */
    lensopt__listed glass[LENSOPT_MAX_GLASSES + LENSOPT_MAX_SEARCHED];
    double fraction;                 /* of its gap in front of the stop, where its place is none */
    lensopt__limits limits[LENSOPT_MAX_SEARCHED];
    int32_t variables, place_of, iris_of, index_of[LENSOPT_MAX_SEARCHED]; /* -1: fixed */
    int32_t number_at[LENSOPT_MAX_VARIABLES];
    lensopt__variable variable[LENSOPT_MAX_VARIABLES];
    double lower[LENSOPT_MAX_VARIABLES], upper[LENSOPT_MAX_VARIABLES];
    int32_t blocks[LENSOPT_MAX_VARIABLES];
    int32_t lights;                  /* that the objective looks at */
    double slopes[LENSOPT_MAX_LIGHTS];
    /* goals: of all ghosts that some light should show or hide */
    int32_t goals;
    int32_t ghost_of[LENSOPT_MAX_GHOSTS];
    double weight[LENSOPT_MAX_LIGHTS][LENSOPT_MAX_GHOSTS]; /* of squared differences in mm^2 */
    double surplus;                  /* MATCHED, THESIS: of a ghost too many, over its radius */
    double unit, light_root[LENSOPT_MAX_LIGHTS], surplus_root; /* SEEN: 1 % of the frame's diagonal; of a ghost too many, over its radius and unit */
    double missing[LENSOPT_MAX_GHOSTS]; /* of a goal without a ghost */
    double sorted_centre[LENSOPT_MAX_GHOSTS], sorted_radius[LENSOPT_MAX_GHOSTS]; /* THESIS: by rank */
    int32_t goal_at[LENSOPT_MAX_GHOSTS]; /* by rank */
    lensopt__mirrors mirrors;        /* that the target's spots come from */
};

static int32_t lensopt__pairs_of(int32_t n) { return n * (n - 1) / 2; }

static double lensopt__clamped(double v, double lo, double hi) { return v < lo ? lo : v > hi ? hi : v; }

static int lensopt__is_air(const lensopt_problem *p, const double *x, int32_t row)
{
    int32_t v = p->index_of[row];
    return v < 0 ? p->fixed.n[row] == 1 : p->limits[row].may_air && x[v] < p->limits[row].index.lo;
}

/* The gap of the stop: the air gap nearest to its place; the last gap is one. */
static int32_t lensopt__stop_of(const lensopt_problem *p, const double *x)
{
    int32_t k, step;
    if (p->place_of < 0) return p->fixed.stop;
    k = (int32_t)floor(x[p->place_of]);
    if (k < 0) return -1;
    if (k >= p->surfaces) k = p->surfaces - 1;
    for (step = 0; step < p->surfaces; step++) {
        if (k - step >= 0 && lensopt__is_air(p, x, k - step)) return k - step;
        if (k + step < p->surfaces && lensopt__is_air(p, x, k + step)) return k + step;
    }
    return p->surfaces - 1;
}

/* Of the glasses of a list the one whose index is nearest. */
static const lensopt__listed *lensopt__nearest_glass(const lensopt_problem *p, double n)
{
    int32_t lo = 0, hi = p->glasses - 1;
    while (hi - lo > 1) {
        int32_t middle = (lo + hi) / 2;
        if (p->glass[middle].n <= n) lo = middle;
        else hi = middle;
    }
    if (n - p->glass[lo].n > p->glass[hi].n - n) lo = hi;
    while (lo > 0 && p->glass[lo - 1].n == p->glass[lo].n) lo--;
    return &p->glass[lo];
}

/* The lens that a point stands for: any numbers within the bounds are one. */
static void lensopt__decode(const lensopt_problem *p, const double *x, lensopt__design *d)
{
    double place = 0;
    int32_t i;
    *d = p->fixed;
    for (i = 0; i < p->variables; i++) {
        int32_t row = p->variable[i].row;
        switch (p->variable[i].kind) {
        case LENSOPT__PLACE: place = x[i]; break;
        case LENSOPT__IRIS: d->iris = x[i]; break;
        case LENSOPT__CURVATURE: d->c[row] = x[i]; break;
        case LENSOPT__GAP: d->d[row] = x[i]; break;
        case LENSOPT__INDEX: d->n[row] = lensopt__is_air(p, x, row) ? 1 : p->glasses > 0 ? lensopt__nearest_glass(p, x[i])->n : x[i]; break;
        }
    }
    for (i = 0; i < p->variables; i++) {
        int32_t row = p->variable[i].row;
        const lensopt_range *r;
        if (p->variable[i].kind != LENSOPT__GAP) continue;
        r = d->n[row] == 1 ? &p->limits[row].air_gap : &p->limits[row].glass_gap;
        d->d[row] = lensopt__clamped(d->d[row], r->lo, r->hi);
    }
    d->stop = lensopt__stop_of(p, x);
    if (d->stop < 0) d->ahead = p->place_of < 0 ? p->fixed.ahead : -place * p->desc.air_gap.hi;
    else d->ahead = (p->place_of < 0 ? p->fraction : lensopt__clamped(place - floor(place), 0, 1)) * d->d[d->stop];
}

static void lensopt__encode(const lensopt_problem *p, const lensopt__design *d, double *x)
{
    int32_t v;
    for (v = 0; v < p->variables; v++) {
        int32_t row = p->variable[v].row;
        double value = 0;
        switch (p->variable[v].kind) {
        case LENSOPT__PLACE:
            if (d->stop < 0) value = -d->ahead / p->desc.air_gap.hi;
            else value = d->stop + (d->d[d->stop] > 0 ? lensopt__clamped(d->ahead / d->d[d->stop], 0, 1 - 1e-12) : 0);
            break;
        case LENSOPT__IRIS: value = d->iris; break;
        case LENSOPT__CURVATURE: value = d->c[row]; break;
        case LENSOPT__GAP: value = d->d[row]; break;
        case LENSOPT__INDEX: value = d->n[row] == 1 ? p->lower[v] : d->n[row]; break;
        }
        x[v] = lensopt__clamped(value, p->lower[v], p->upper[v]);
    }
}

/* -- from a lens -- */

/* The row of a prescription that holds surface i, the stop not counted. */
static int32_t lensopt__row(const lflare_prescription *p, int32_t i)
{
    int32_t row;
    for (row = 0; row < p->surface_count; row++)
        if (!p->surfaces[row].is_stop && i-- == 0) return row;
    return -1;
}

/* Two rows' gaps around the stop are one here. */
static void lensopt__design_of(const lflare_prescription *q, lensopt__design *d)
{
    int32_t row;
    memset(d, 0, sizeof *d);
    d->stop = -1;
    for (row = 0; row < q->surface_count; row++) {
        const lflare_surface *s = &q->surfaces[row];
        int32_t i = d->surfaces;
        if (s->is_stop) {
            d->stop = i - 1;
            d->ahead = i > 0 ? d->d[i - 1] : s->thickness;
            d->iris = s->semi_diameter;
            if (i > 0) d->d[i - 1] += s->thickness;
            continue;
        }
        d->c[i] = (s->radius != 0 ? 1 / s->radius : 0) + 2 * s->aspheric[0];
        d->d[i] = s->thickness;
        d->n[i] = lflare_index(&s->medium, lensopt__nm[1]);
        d->surfaces++;
    }
}

/* Locks of surface i and, for its gap, of the stop that stands in it. */
static int32_t lensopt__locks(const lensopt_problem *p, int32_t i)
{
    int32_t row;
    if (!p->has_base) return 0;
    row = lensopt__row(&p->base, i);
    return p->target.locks[row] | (row + 1 < p->base.surface_count && p->base.surfaces[row + 1].is_stop ? p->target.locks[row + 1] & LENSOPT_LOCK_GAP : 0);
}

static void lensopt__hold(lensopt_range *r, double v)
{
    if (v < r->lo) r->lo = v;
    if (v > r->hi) r->hi = v;
}

static void lensopt__add_variable(lensopt_problem *p, lensopt__kind kind, int32_t row, double lower, double upper)
{
    int32_t i = p->variables++;
    if (kind == LENSOPT__PLACE) p->place_of = i;
    if (kind == LENSOPT__IRIS) p->iris_of = i;
    if (kind == LENSOPT__INDEX) p->index_of[row] = i;
    p->variable[i].kind = kind;
    p->variable[i].row = row;
    p->lower[i] = lower;
    p->upper[i] = upper;
    p->blocks[i] = row + 1;
    p->number_at[i] = lensopt__number_at(&p->variable[i]);
}

static void lensopt__surface_variables(lensopt_problem *p, int32_t i)
{
    lensopt__limits *l = &p->limits[i];
    int32_t locks = lensopt__locks(p, i), last = i + 1 == p->surfaces, air = p->has_base && p->fixed.n[i] == 1;
    double c = 1 / p->desc.least_radius;
    l->glass_gap = p->desc.glass_gap;
    l->air_gap = p->desc.air_gap;
    l->index = p->desc.index;
    l->may_air = last || !p->has_base || air || !p->desc.keep_order;
    l->may_glass = !last && (!p->has_base || !air || !p->desc.keep_order);
    if (p->has_base) {
        lensopt__hold(air ? &l->air_gap : &l->glass_gap, p->fixed.d[i]);
        if (!air) lensopt__hold(&l->index, p->fixed.n[i]);
        if (fabs(p->fixed.c[i]) > c) c = fabs(p->fixed.c[i]);
    }
    if (!(locks & LENSOPT_LOCK_RADIUS)) lensopt__add_variable(p, LENSOPT__CURVATURE, i, -c, c);
    if (locks & LENSOPT_LOCK_MEDIUM) {
        l->may_air = air;
        l->may_glass = !air;
    } else if (l->may_glass) {
        lensopt__add_variable(p, LENSOPT__INDEX, i, l->may_air ? 2 * l->index.lo - l->index.hi : l->index.lo, l->index.hi);
    }
    if (locks & LENSOPT_LOCK_GAP) return;
    lensopt__add_variable(p, LENSOPT__GAP, i, l->may_air && (!l->may_glass || l->air_gap.lo < l->glass_gap.lo) ? l->air_gap.lo : l->glass_gap.lo,
                          l->may_air && (!l->may_glass || l->air_gap.hi > l->glass_gap.hi) ? l->air_gap.hi : l->glass_gap.hi);
}

static int32_t lensopt__read_in_front(const lensopt__mirrors *m) { return m->count[1] + (m->few_front ? m->few : 0); }

/* Whether the stop may stand in front of all: where it does in the base, or in what is read from scratch. */
static int lensopt__may_lead(const lensopt_problem *p)
{
    return p->has_base ? p->fixed.stop < 0 : p->mirrors.usable && lensopt__read_in_front(&p->mirrors) == 0;
}

static void lensopt__variables(lensopt_problem *p)
{
    int32_t i, locks = p->has_base ? p->target.stop_locks : 0;
    p->place_of = p->iris_of = -1;
    for (i = 0; i < p->surfaces; i++) p->index_of[i] = -1;
    p->fraction = p->fixed.stop >= 0 && p->fixed.d[p->fixed.stop] > 0 ? p->fixed.ahead / p->fixed.d[p->fixed.stop] : 0;
    if (!(locks & LENSOPT_LOCK_STOP_PLACE)) lensopt__add_variable(p, LENSOPT__PLACE, -1, lensopt__may_lead(p) ? -1 : 0, p->surfaces * (1 - 1e-12));
    if (p->has_base) lensopt__hold(&p->desc.stop_radius, p->fixed.iris);
    if (!(locks & LENSOPT_LOCK_STOP_RADIUS)) lensopt__add_variable(p, LENSOPT__IRIS, -1, p->desc.stop_radius.lo, p->desc.stop_radius.hi);
    for (i = 0; i < p->surfaces; i++) lensopt__surface_variables(p, i);
}

/* -- goals -- */

/* How much of a disc lies on the frame, 0 to 1, by strips across the light's line. */
static double lensopt__on_frame(const lensopt_problem *p, int32_t light, double centre, double radius)
{
    enum { STRIPS = 32 };
    double x = tan(p->target.lights[light].direction[0] * (LENSOPT__PI / 180)), y = tan(p->target.lights[light].direction[1] * (LENSOPT__PI / 180));
    double u = p->slopes[light], w = 0.5 * p->target.sensor_width, h = 0.5 * p->target.sensor_height, on = 0, all = 0;
    int32_t i, k;
    x = u > 0 ? x / u : 1;
    y = u > 0 ? y / u : 0;
    for (i = 0; i < STRIPS; i++)
        for (k = 0; k < STRIPS; k++) {
            double s = (2 * i + 1 - STRIPS) / (double)STRIPS, t = (2 * k + 1 - STRIPS) / (double)STRIPS;
            if (s * s + t * t > 1) continue;
            all++;
            on += fabs(centre * x + radius * s) <= w && fabs(centre * y + radius * t) <= h;
        }
    return on / all;
}

/* Differences count in units of the spot, and spots by how much of them is on the frame; all weights of seen spots then add up to 1. */
static void lensopt__weigh(lensopt_problem *p)
{
    double sum = 0, size = 0, lights = 0;
    int32_t g, l;
    p->unit = 0.01 * sqrt(p->target.sensor_width * p->target.sensor_width + p->target.sensor_height * p->target.sensor_height);
    for (l = 0; l < p->target.light_count; l++) lights += p->target.lights[l].weight;
    for (l = 0; l < p->target.light_count; l++)
        for (g = 0; g < p->goals; g++) {
            const lensopt_ghost *ghost = &p->target.ghosts[p->ghost_of[g]];
            const lensopt_goal *goal = &ghost->goals[l];
            double w = p->target.lights[l].weight * ghost->weight, s = goal->wish == LENSOPT_SPOT ? goal->radius + p->unit : p->unit;
            if (goal->wish == LENSOPT_SPOT) w *= 0.02 + 0.98 * lensopt__on_frame(p, l, goal->centre, goal->radius);
            if (goal->wish == LENSOPT_SPOT_ANY || w == 0) continue;
            p->weight[l][g] = w / (s * s);
            p->missing[g] += 4 * w;
            sum += w;
            size += w * s;
        }
    for (l = 0; l < p->target.light_count; l++) p->light_root[l] = sqrt(p->target.lights[l].weight / lights);
    for (g = 0; g < p->goals; g++) p->missing[g] /= sum;
    for (l = 0; l < p->target.light_count; l++)
        for (g = 0; g < p->goals; g++) p->weight[l][g] /= sum;
    p->surplus_root = size / sum / sqrt(p->goals);
}

/* The thesis knows one light, and spots alone; all that have a weight are alike. */
static void lensopt__rank_goals(lensopt_problem *p)
{
    int32_t g, i;
    for (g = 0; g < p->goals; g++) {
        double radius = p->target.ghosts[p->ghost_of[g]].goals[0].radius;
        for (i = g; i > 0 && p->sorted_radius[i - 1] > radius; i--) {
            p->sorted_radius[i] = p->sorted_radius[i - 1];
            p->goal_at[i] = p->goal_at[i - 1];
        }
        p->sorted_radius[i] = radius;
        p->goal_at[i] = g;
        p->weight[0][g] = 1.0 / p->goals;
    }
    for (i = 0; i < p->goals; i++) p->sorted_centre[i] = p->target.ghosts[p->ghost_of[p->goal_at[i]]].goals[0].centre;
    p->surplus = p->desc.objective == LENSOPT_THESIS ? 500.0 / p->goals : 500;
    for (g = 0; g < p->goals; g++) p->missing[g] = 1e5 / p->goals; /* all of them: the thesis' 1e5 */
}

static lflare_result lensopt__goals(lensopt_problem *p, lflare_error *error)
{
    const lensopt_target *t = &p->target;
    int32_t g, l;
    for (l = 0; l < t->light_count; l++) p->slopes[l] = lensopt_slope(&t->lights[l]);
    for (g = 0; g < t->ghost_count; g++) {
        int asked = 0;
        for (l = 0; l < t->light_count; l++) {
            lensopt_wish wish = t->ghosts[g].goals[l].wish;
            if (t->ghosts[g].weight * t->lights[l].weight > 0) asked |= wish == LENSOPT_SPOT && (l == 0 || p->desc.objective == LENSOPT_SEEN);
        }
        if (asked) p->ghost_of[p->goals++] = g;
    }
    if (p->goals == 0)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "the target asks for no spot%s: at least one of a ghost and a light with weights above 0 was expected",
                             p->desc.objective != LENSOPT_SEEN ? " at its first light, all that this objective knows" : "");
    p->lights = p->desc.objective == LENSOPT_SEEN ? t->light_count : 1;
    if (p->desc.objective == LENSOPT_SEEN) lensopt__weigh(p);
    else lensopt__rank_goals(p);
    return LFLARE_OK;
}

/* -- what makes a lens a lens -- */

enum { LENSOPT__CONSTRAINTS = 5 + LENSOPT_MAX_SEARCHED };

static int lensopt__constrained(const lensopt_problem_desc *d)
{
    return d->efl.hi > 0 || d->back_focus.hi > 0 || d->fnumber.hi > 0 || d->length.hi > 0 || d->focus > 0 || d->glass_edge > 0 || d->air_edge > 0;
}

/* How far v is out of a range, in tenths of its upper end. */
static double lensopt__out_of(double v, lensopt_range r)
{
    return r.hi == 0 ? 0 : 10 * (v < r.lo ? v - r.lo : v > r.hi ? v - r.hi : 0) / r.hi;
}

/* Abbe number of the glass behind surface i where its index is n at 510 nm: the base's own if that is glass, too, or what is usual. */
static double lensopt__abbe(const lensopt_problem *p, int32_t i, double n)
{
    static const double usual[6][2] = {{1.4, 75}, {1.515, 60.4}, {1.626, 36.4}, {1.75, 28.2}, {1.861, 23.8}, {2.12, 17}}; /* n, Vd of common crowns and flints */
    int32_t k = 0;
    if (p->abbe[i] > 0) return p->abbe[i];
    while (k < 4 && n > usual[k + 1][0]) k++;
    return fmax(15, usual[k][1] + (n - usual[k][0]) * (usual[k + 1][1] - usual[k][1]) / (usual[k + 1][0] - usual[k][0]));
}

/* Index at the d line, at which focal lengths are meant, of what has n at 510 nm, by n = A + B / nm^2 (LFLARE_MEDIUM_ABBE). */
static double lensopt__nd(const lensopt_problem *p, int32_t i, double n)
{
    const double d = 1 / (587.5618 * 587.5618), share = (1 / (510.0 * 510.0) - d) / (1 / (486.1327 * 486.1327) - 1 / (656.2725 * 656.2725));
    double v;
    if (n == 1) return 1;
    if (p->glasses > 0) return lensopt__nearest_glass(p, n)->nd;
    v = share / lensopt__abbe(p, i, n);
    return (n + v) / (1 + v);
}

/* The direct path: heights before each surface and behind the last gap, per entrance height [0] and slope [1], and the power. */
typedef struct lensopt__direct {
    double y[LENSOPT_MAX_SEARCHED + 1][2], power, a00, a01;
} lensopt__direct;

static void lensopt__direct_path(const lensopt__design *d, lensopt__direct *out)
{
    double y0 = 1, y1 = d->stop < 0 ? d->ahead : 0, w0 = 0, w1 = 1, before = 1;
    int32_t s;
    out->a00 = 1;
    out->a01 = 0;
    for (s = 0; s < d->surfaces; s++) {
        double phi = (d->n[s] - before) * d->c[s];
        out->y[s][0] = y0;
        out->y[s][1] = y1;
        w0 -= phi * y0;
        w1 -= phi * y1;
        if (s == d->stop) {
            out->a00 = y0 + d->ahead * w0;
            out->a01 = y1 + d->ahead * w1;
        }
        y0 += d->d[s] / d->n[s] * w0;
        y1 += d->d[s] / d->n[s] * w1;
        before = d->n[s];
    }
    out->y[s][0] = y0;
    out->y[s][1] = y1;
    out->power = -w0;
}

/* How high the direct light of all lights meets a surface through the iris. */
static double lensopt__direct_reach(const lensopt_problem *p, const lensopt__design *d, const lensopt__direct *path, int32_t s)
{
    double most = 0;
    int32_t l;
    for (l = 0; l < p->target.light_count; l++) {
        double chief = p->slopes[l] * (path->y[s][1] - path->y[s][0] * path->a01 / path->a00);
        most = fmax(most, fabs(chief));
    }
    return most + fabs(path->y[s][0] / path->a00) * d->iris;
}

/* The sag of a sphere; where it does not reach, as if it went on along its rim. */
static double lensopt__sag(double c, double y)
{
    double cy = c * y;
    return fabs(cy) < 1 ? cy * y / (1 + sqrt(1 - cy * cy)) : (cy > 0 ? 1 : -1) * (2 * y - 1 / fabs(c));
}

static double lensopt__edge_of(const lensopt__design *d, int32_t s, double y) { return d->d[s] + (s + 1 < d->surfaces ? lensopt__sag(d->c[s + 1], y) : 0) - lensopt__sag(d->c[s], y); }

/* out: LENSOPT__CONSTRAINTS residuals, 0 where a lens is as it should be; returns how many. */
static int32_t lensopt__constraints(const lensopt_problem *p, const lensopt__design *at_510, double *out)
{
    lensopt__design at_d = *at_510;
    const lensopt__design *d = &at_d;
    const lensopt_problem_desc *desc = &p->desc;
    lensopt__direct path;
    double length = 0, y = 0;
    int32_t s, count = 0;
    for (s = 0; s < d->surfaces; s++) {
        at_d.n[s] = lensopt__nd(p, s, at_510->n[s]);
        length += d->d[s];
    }
    lensopt__direct_path(d, &path);
    /* by power, which has no pole */
    if (desc->efl.hi > 0) {
        double lo = 1 / desc->efl.hi, hi = desc->efl.lo > 0 ? 1 / desc->efl.lo : HUGE_VAL;
        out[count++] = 10 * (path.power < lo ? path.power - lo : path.power > hi ? path.power - hi : 0) / lo;
    }
    if (desc->fnumber.hi > 0) {
        double lo = 1 / desc->fnumber.hi, hi = desc->fnumber.lo > 0 ? 1 / desc->fnumber.lo : HUGE_VAL, v = 2 * d->iris * path.power / fmax(fabs(path.a00), 1e-9);
        out[count++] = 10 * (v < lo ? v - lo : v > hi ? v - hi : 0) / lo;
    }
    if (desc->back_focus.hi > 0) out[count++] = lensopt__out_of(d->d[d->surfaces - 1], desc->back_focus);
    if (desc->length.hi > 0) out[count++] = lensopt__out_of(length, desc->length);
    if (desc->focus > 0) {
        double off = path.y[d->surfaces][0] / (fabs(path.power) > 1e-6 ? path.power : 1e-6);
        out[count++] = off > desc->focus ? off - desc->focus : off < -desc->focus ? off + desc->focus : 0;
    }
    for (s = 0; s < d->surfaces && (desc->glass_edge > 0 || desc->air_edge > 0); s++) {
        double least = d->n[s] == 1 ? desc->air_edge : desc->glass_edge, next = s + 1 < d->surfaces ? lensopt__direct_reach(p, d, &path, s + 1) : 0, edge;
        if (s == 0) y = lensopt__direct_reach(p, d, &path, 0);
        edge = lensopt__edge_of(d, s, fmax(y, next));
        out[count++] = least > 0 && edge < least ? edge - least : 0;
        y = next;
    }
    return count;
}

static double lensopt__penalty(const lensopt_problem *p, const lensopt__design *d)
{
    double out[LENSOPT__CONSTRAINTS], sum = 0;
    int32_t i, count;
    if (!p->constrained) return 0;
    count = lensopt__constraints(p, d, out);
    for (i = 0; i < count; i++) sum += out[i] * out[i];
    return sum;
}


/* >> 7 mirrors */
/* What spots tell of the lens that they come from, without any search. (Derived for this library.)

   Seen from the sensor's side each surface is a mirror, which takes a ray (height, slope) to M ray. M has determinant -1 and trace 0, since reflected
   twice a ray is as it was: two numbers, for the images of the vertex and of the centre of curvature. A ghost is G = M i M j, i < j. Of the direct light
   at the sensor let the chief ray have height h, and the marginal ray e, which is next to nothing where the light is in focus. With rays written as
   x chief / h + y marginal, heights at the sensor are r = (1, e), and a ghost whose light has passed the stop before has centre and radius (of either
   sign) in a row, v = r G = (centre / h, radius). One whose light passes it afterwards has them in a column of G; all transposed, that is a row of the
   same kind, v = (h / centre, h radius / centre), and the order of surfaces is the other way round.

   Let w i = r M i, so that v i,k = w i M k. Then v j,k x v i,k = w i x w j whatever k is: among the cross products of all pairs of spots, one value
   comes up as often as there are surfaces behind j, which sorting finds without knowing which spot is which. The value is v i,j . (-e, 1), and three such
   equations among the ghosts of four surfaces give h, e, and a proof. All that is left is linear.

   So spots tell 2 numbers a surface, h and e, where a lens has 3. One that has them is built from its last surface to the front: the images tell gap
   and radius, for whatever index is chosen in front. The chief and marginal rays' slopes are then set so that the light comes from far away, under its
   angle. */

typedef struct lensopt__square {
    double a, b, c, d;
} lensopt__square;

/* A mirror as rays see it that m takes to these: the inverse of m, mirror, m. */
static lensopt__mirror lensopt__seen_through(lensopt__square m, lensopt__mirror mirror)
{
    double det = m.a * m.d - m.b * m.c, ac = mirror.a * m.a + mirror.b * m.c, bd = mirror.a * m.b + mirror.b * m.d;
    double ca = mirror.c * m.a - mirror.a * m.c, db = mirror.c * m.b - mirror.a * m.d;
    lensopt__mirror out;
    out.a = (m.d * ac - m.b * ca) / det;
    out.b = (m.d * bd - m.b * db) / det;
    out.c = (m.a * ca - m.c * ac) / det;
    return out;
}

static lensopt__row2 lensopt__row2_of(double x, double y)
{
    lensopt__row2 v;
    v.x = x;
    v.y = y;
    return v;
}

static double lensopt__cross_product(lensopt__row2 v, lensopt__row2 w) { return v.x * w.y - v.y * w.x; }
static lensopt__row2 lensopt__mirrored(lensopt__row2 v, lensopt__mirror m) { return lensopt__row2_of(v.x * m.a + v.y * m.c, v.x * m.b - v.y * m.a); }

/* The one mirror that takes v, whose x is not 0, to w. */
static lensopt__mirror lensopt__mirror_between(lensopt__row2 v, lensopt__row2 w)
{
    lensopt__mirror m;
    m.a = (v.x * v.y - w.x * w.y) / lensopt__cross_product(w, v);
    m.b = (w.y + v.y * m.a) / v.x;
    m.c = fabs(v.y) > 1e-6 * fabs(v.x) ? (w.x - v.x * m.a) / v.y : (1 - m.a * m.a) / m.b;
    return m;
}

/* -- mirrors out of spots -- */

/* Of two spots, the second one's radius times `sign`. */
typedef struct lensopt__crossing {
    double value;          /* of the cross product, without its sign */
    int32_t u, v, sign;
} lensopt__crossing;

/* A value that comes up more often than it would by chance. */
typedef struct lensopt__cluster {
    double value;
    int32_t front, members; /* with the front group's rows */
    lensopt__crossing two[2];
} lensopt__cluster;

enum { LENSOPT__CLUSTERS = 4096, LENSOPT__MOST_READ = 512 /* spots */ };

typedef struct lensopt__reading {
    int32_t count, clusters;
    const double *centre, *radius;   /* by centre */
    lensopt__cluster cluster[LENSOPT__CLUSTERS];
    lensopt__crossing *crossing;
    double exact;                    /* how well numbers of one lens agree, relatively */
    double blur;                     /* the most that e may be */
    int32_t every;                   /* from scratch: there have to be as many ghosts as spots */
    int32_t proofs_left;             /* spots in rows have many clusters that prove nothing */
    char explained[LENSOPT_MAX_GHOSTS]; /* ghosts of what has been found */
    lensopt__mirrors *out;
} lensopt__reading;

/* A spot's row, its radius times `sign`; while h is not known it is 1. */
static lensopt__row2 lensopt__spot_row(const lensopt__reading *r, int32_t i, int front, int32_t sign)
{
    double h = r->out->chief, c = r->centre[i];
    return front ? lensopt__row2_of(h / c, sign * h * r->radius[i] / c) : lensopt__row2_of(c / h, sign * r->radius[i]);
}

/* What v j,k x v i,k is for every k, where v is v i,j. */
static double lensopt__common(const lensopt__mirrors *m, lensopt__row2 v) { return v.y - m->marginal * v.x; }

/* Whether v 1,2, v 1,k and v 2,k are ghosts of three surfaces. */
static int lensopt__agree(const lensopt__mirrors *m, lensopt__row2 v, lensopt__row2 with_first, lensopt__row2 with_second)
{
    double terms = fabs(with_first.x * with_second.y) + fabs(with_first.y * with_second.x) + fabs(v.y) + fabs(m->marginal * v.x);
    return fabs(lensopt__cross_product(with_second, with_first) - lensopt__common(m, v)) < 1e-6 * terms;
}

static int lensopt__compare_crossings(const void *a, const void *b)
{
    const lensopt__crossing *x = (const lensopt__crossing *)a, *y = (const lensopt__crossing *)b;
    if (x->value != y->value) return x->value < y->value ? -1 : 1;
    if (x->u != y->u) return x->u - y->u;
    return x->v != y->v ? x->v - y->v : x->sign - y->sign;
}

/* How often a value has to come up so that chance makes less than one in ten readings do so, among `values` of them. */
static int32_t lensopt__least_members(double values, double exact)
{
    double expected = values;
    int32_t members = 1;
    while (expected > 0.1) expected *= values * exact / members++;
    return members;
}

static void lensopt__find_clusters(lensopt__reading *r, int front)
{
    int32_t u, v, sign, i, end, count = 0, least = lensopt__least_members((double)r->count * r->count, r->exact);
    for (u = 0; u < r->count; u++)
        for (v = u + 1; v < r->count; v++)
            for (sign = -1; sign <= 1; sign += 2) {
                lensopt__crossing *c = &r->crossing[count];
                lensopt__row2 x = lensopt__spot_row(r, u, front, 1), y = lensopt__spot_row(r, v, front, 1);
                c->value = fabs(x.x * y.y * sign - x.y * y.x);
                c->u = u;
                c->v = v;
                c->sign = sign;
                count += c->value > 0 && c->value < 1e100;
            }
    qsort(r->crossing, (size_t)count, sizeof *r->crossing, lensopt__compare_crossings);
    for (i = 0; i < count; i = end) {
        lensopt__cluster *c = &r->cluster[r->clusters];
        for (end = i + 1; end < count && r->crossing[end].value - r->crossing[end - 1].value < r->exact * r->crossing[i].value;) end++;
        if (end - i < least || r->clusters == LENSOPT__CLUSTERS) continue;
        c->value = r->crossing[i].value;
        c->front = front;
        c->members = end - i;
        c->two[0] = r->crossing[i];
        c->two[1] = r->crossing[i + 1];
        r->clusters++;
    }
}

static int lensopt__compare_clusters(const void *a, const void *b)
{
    const lensopt__cluster *x = (const lensopt__cluster *)a, *y = (const lensopt__cluster *)b;
    if (x->members != y->members) return y->members - x->members;
    if (x->front != y->front) return x->front - y->front;
    return x->value < y->value ? -1 : x->value > y->value;
}

/* If spot i, its radius times `sign`, has made a cluster then (x, y) . (h, e) = 1, where e is next to nothing beside radii. */
static lensopt__row2 lensopt__cluster_asks(const lensopt__reading *r, const lensopt__cluster *c, int32_t i, int32_t sign)
{
    if (c->front) return lensopt__row2_of(c->value * fabs(r->centre[i]) / r->radius[i], sign / r->radius[i]);
    return lensopt__row2_of(r->radius[i] / c->value, -sign * r->centre[i] / c->value);
}

/* The spot that has made a cluster, or -1. */
static int32_t lensopt__maker_of(const lensopt__reading *r, const lensopt__cluster *c, double h, double e, int32_t *sign)
{
    int32_t i;
    for (i = 0; i < r->count; i++)
        for (*sign = -1; *sign <= 1; *sign += 2) {
            lensopt__row2 v = lensopt__cluster_asks(r, c, i, *sign);
            if (fabs(v.x * h + v.y * e - 1) < 10 * r->exact) return i;
        }
    return -1;
}

/* How many of the first clusters some spot has made. */
static int32_t lensopt__proofs(const lensopt__reading *r, double h, double e)
{
    enum { MOST = 24 };
    int32_t c, sign, count = 0;
    for (c = 0; c < r->clusters && c < MOST; c++) count += lensopt__maker_of(r, &r->cluster[c], h, e, &sign) >= 0;
    return count;
}

/* h and e from a cluster of surfaces 1 and 2, where v[0] are the rows v 1,3 and v 2,3 and v[1] those with 4: any spot may be v 1,2 and any be v 3,4. Two of three
   equations give them, the third one proves it. `best` is the most proofs so far. */
static int32_t lensopt__rays_by_four(lensopt__reading *r, int front, lensopt__row2 v[2][2], int32_t best, double *rays)
{
    int32_t i, j, proofs;
    for (i = 0; i < r->count; i++)
        for (j = 0; j < 2 * r->count; j++) {
            lensopt__row2 first = lensopt__spot_row(r, i, front, 1), last = lensopt__spot_row(r, j / 2, front, j % 2 ? -1 : 1);
            double common = lensopt__cross_product(v[0][1], v[0][0]), one, two, det, x, y, h, e;
            if ((first.y > 0) != (common > 0)) first.y = -first.y;
            one = lensopt__cross_product(last, v[1][0]);
            two = lensopt__cross_product(last, v[1][1]);
            det = lensopt__cross_product(first, v[0][0]);
            x = (common * v[0][0].x - one * first.x) / -det;
            y = (common * v[0][0].y - one * first.y) / -det;
            h = front ? 1 / x : x;
            e = front ? y / x : y;
            if (!(h > 0 && h < 1e6 && fabs(e) < r->blur) || fabs(x * v[0][1].y - y * v[0][1].x - two) > 10 * r->exact * fabs(two)) continue;
            if (r->proofs_left-- <= 0) return best;
            proofs = lensopt__proofs(r, h, e);
            if (proofs <= best) continue;
            best = proofs;
            rays[0] = h;
            rays[1] = e;
        }
    return best;
}

/* The rows of a crossing's two spots as v 1,k and v 2,k. Which is which, `swapped` says; the sign follows from that of their cross product. */
static void lensopt__sides(const lensopt__reading *r, const lensopt__cluster *c, int32_t k, int swapped, double common, lensopt__row2 *v)
{
    const lensopt__crossing *x = &c->two[k];
    v[swapped] = lensopt__spot_row(r, x->v, c->front, x->sign);
    v[!swapped] = lensopt__spot_row(r, x->u, c->front, 1);
    if (lensopt__cross_product(v[1], v[0]) * common > 0) return;
    v[0].y = -v[0].y;
    v[1].y = -v[1].y;
}

/* 0: there are none. */
static int lensopt__find_rays(lensopt__reading *r)
{
    enum { TRIED = 6 };
    double rays[2] = {1, 0};
    int32_t c, way, k, best = 0;
    for (c = 0; c < r->clusters && c < TRIED; c++) /* a cluster's own spot may be missing */
        for (way = 0; way < 8 && best < (r->clusters < 16 ? r->clusters : 16); way++) {
            lensopt__row2 v[2][2];
            for (k = 0; k < 2; k++) lensopt__sides(r, &r->cluster[c], k, way >> k & 1, 1, v[k ^ way >> 2]);
            best = lensopt__rays_by_four(r, r->cluster[c].front, v, best, rays);
        }
    r->out->chief = rays[0];
    r->out->marginal = rays[1];
    return best > 0;
}

/* The spot that has a row, or -1. */
static int32_t lensopt__spot_at(const lensopt__reading *r, int front, lensopt__row2 v)
{
    double h = r->out->chief, centre = front ? h / v.x : h * v.x, radius = fabs(front ? v.y / v.x : v.y), tolerance = 100 * r->exact * (fabs(centre) + radius);
    int32_t lo = 0, hi = r->count;
    while (lo < hi) {
        int32_t middle = (lo + hi) / 2;
        if (r->centre[middle] < centre - tolerance) lo = middle + 1;
        else hi = middle;
    }
    for (; lo < r->count && r->centre[lo] <= centre + tolerance; lo++)
        if (fabs(r->radius[lo] - radius) < tolerance) return lo;
    return -1;
}

static lensopt__row2 lensopt__sensor_row(const lensopt__mirrors *m) { return lensopt__row2_of(1, m->marginal); }

/* The spot that is the ghost of two mirrors in this order, or -1. */
static int32_t lensopt__ghost_at(const lensopt__reading *r, int front, lensopt__mirror m, lensopt__mirror n)
{
    return lensopt__spot_at(r, front, lensopt__mirrored(lensopt__mirrored(lensopt__sensor_row(r->out), m), n));
}

/* Whether a third of a group's mirrors, and two at least, make spots with another one, which is none of them. */
static int lensopt__belongs(const lensopt__reading *r, int front, const lensopt__mirror *group, int32_t count, lensopt__mirror m)
{
    int32_t i, with = 0, least = count > 6 ? count / 3 : 2;
    if (!(fabs(m.a) + fabs(m.b) + fabs(m.c) < 1e100)) return 0;
    for (i = 0; i < count; i++)
        if (fabs(m.a - group[i].a) < 1e-4 * (1 + fabs(m.a)) && fabs(m.b - group[i].b) < 1e-4 * (1 + fabs(m.b))) return 0;
    for (i = 0; i < count && with < least && with + count - i >= least; i++) with += lensopt__ghost_at(r, front, group[i], m) >= 0 || lensopt__ghost_at(r, front, m, group[i]) >= 0;
    return with >= least;
}

/* Ghosts of a mirror with the `count` others. */
static void lensopt__explain(lensopt__reading *r, int front, const lensopt__mirror *group, int32_t count, lensopt__mirror m)
{
    int32_t i;
    for (i = 0; i < count; i++) {
        int32_t before = lensopt__ghost_at(r, front, m, group[i]), after = lensopt__ghost_at(r, front, group[i], m);
        if (before >= 0) r->explained[before] = 1;
        if (after >= 0) r->explained[after] = 1;
    }
}

/* Each spot that is no ghost yet with each of the mirrors, as the other one's ghost, in either order. */
static int32_t lensopt__grow(lensopt__reading *r, int front, lensopt__mirror *group, int32_t count)
{
    const lensopt__row2 to = lensopt__sensor_row(r->out);
    int32_t i, k, side;
    memset(r->explained, 0, sizeof r->explained);
    for (k = 1; k < count; k++) lensopt__explain(r, front, group, k, group[k]);
    for (k = 0; k < count; k++)
        for (i = 0; i < 2 * r->count; i++)
            for (side = 0; side < 2 && count < LENSOPT_MAX_SEARCHED && !r->explained[i / 2]; side++) {
                lensopt__row2 v = lensopt__spot_row(r, i / 2, front, i % 2 ? 1 : -1);
                lensopt__mirror m = side ? lensopt__mirror_between(to, lensopt__mirrored(v, group[k])) : lensopt__mirror_between(lensopt__mirrored(to, group[k]), v);
                if (!lensopt__belongs(r, front, group, count, m)) continue;
                lensopt__explain(r, front, group, count, m);
                group[count++] = m;
            }
    return count;
}

/* Row of four numbers, times which w 1 and w 2 are 0, where a mirror takes them to v and w. */
static void lensopt__no_trace(lensopt__row2 v, lensopt__row2 w, double *row)
{
    row[0] = w.y;
    row[1] = -w.x;
    row[2] = -v.y;
    row[3] = v.x;
}

static double lensopt__minor(double rows[3][4], int32_t i, int32_t j, int32_t k)
{
    return rows[0][i] * (rows[1][j] * rows[2][k] - rows[1][k] * rows[2][j]) - rows[0][j] * (rows[1][i] * rows[2][k] - rows[1][k] * rows[2][i]) +
           rows[0][k] * (rows[1][i] * rows[2][j] - rows[1][j] * rows[2][i]);
}

/* w 1 and w 2, where mirror 2 takes them to v 1,2 and r, and two more take them to what rows 1 and 2 say. 0: no lens does. */
static int lensopt__first_two(const lensopt__mirrors *m, lensopt__row2 v, double rows[3][4], lensopt__row2 *w)
{
    double q[4], square;
    lensopt__no_trace(v, lensopt__sensor_row(m), rows[0]);
    q[0] = lensopt__minor(rows, 1, 2, 3);
    q[1] = -lensopt__minor(rows, 0, 2, 3);
    q[2] = lensopt__minor(rows, 0, 1, 3);
    q[3] = -lensopt__minor(rows, 0, 1, 2);
    square = lensopt__common(m, v) / (q[0] * q[3] - q[1] * q[2]);
    if (!(square > 0 && square < 1e200)) return 0;
    w[0] = lensopt__row2_of(sqrt(square) * q[0], sqrt(square) * q[1]);
    w[1] = lensopt__row2_of(sqrt(square) * q[2], sqrt(square) * q[3]);
    return 1;
}

/* Mirrors 1 and 2, whose ghost has made a cluster, and the two that stand behind it there, in one of the eight ways that signs and sides leave. */
static int32_t lensopt__four(const lensopt__reading *r, const lensopt__cluster *c, int32_t way, lensopt__mirror *group)
{
    const lensopt__row2 to = lensopt__sensor_row(r->out);
    lensopt__row2 v, sides[2][2], w[2];
    double rows[3][4];
    int32_t k, sign, maker = lensopt__maker_of(r, c, r->out->chief, r->out->marginal, &sign);
    if (maker < 0) return 0;
    v = lensopt__spot_row(r, maker, c->front, way & 4 ? 1 : -1);
    for (k = 0; k < 2; k++) {
        lensopt__sides(r, c, k, way >> k & 1, lensopt__common(r->out, v), sides[k]);
        if (!lensopt__agree(r->out, v, sides[k][0], sides[k][1])) return 0;
        lensopt__no_trace(sides[k][0], sides[k][1], rows[k + 1]);
    }
    if (!lensopt__first_two(r->out, v, rows, w)) return 0;
    for (k = 0; k < 2; k++) {
        group[k] = lensopt__mirror_between(to, w[k]);
        group[2 + k] = lensopt__mirror_between(w[0], sides[k][0]);
    }
    return lensopt__belongs(r, c->front, group, 3, group[3]) && lensopt__belongs(r, c->front, group + 1, 3, group[0]) ? 4 : 0;
}

/* Which of a group's mirrors light meets before which others, as far as their ghosts are there. */
static void lensopt__order_group(const lensopt__reading *r, int front)
{
    lensopt__mirrors *m = r->out;
    int32_t i, j;
    for (i = 0; i < m->count[front]; i++)
        for (j = 0, m->ahead[front][i] = 0; j < m->count[front]; j++)
            if (i != j && lensopt__ghost_at(r, front, m->group[front][i], m->group[front][j]) >= 0 && lensopt__ghost_at(r, front, m->group[front][j], m->group[front][i]) < 0)
                m->ahead[front][i] |= (uint64_t)1 << j;
}

/* The mirrors of one side of the stop, those that explain most spots; 0: none are found. */
static int32_t lensopt__find_group(lensopt__reading *r, int front, lensopt__mirror *group)
{
    lensopt__mirror trial[LENSOPT_MAX_SEARCHED];
    int32_t c, i, way, count, explained, tried = 0, best = 0, found = 0;
    for (c = 0; c < r->clusters && tried < 8 && found == 0; c++) {
        tried += r->cluster[c].front == front;
        for (way = 0; way < 8 && r->cluster[c].front == front; way++) {
            count = lensopt__four(r, &r->cluster[c], way, trial);
            if (count == 0) continue;
            count = lensopt__grow(r, front, trial, count);
            for (i = 0, explained = 0; i < r->count; i++) explained += r->explained[i];
            if (explained <= best) continue;
            best = explained;
            found = count;
            memcpy(group, trial, sizeof *trial * (size_t)count);
        }
    }
    return found;
}

/* Spots that are no ghost of the mirrors that have been found: how many, and the first of them. */
static int32_t lensopt__unexplained(lensopt__reading *r, int32_t *spots)
{
    const lensopt__mirrors *m = r->out;
    int32_t front, i, found = 0;
    memset(r->explained, 0, sizeof r->explained);
    for (front = 0; front < 2; front++)
        for (i = 1; i < m->count[front]; i++) lensopt__explain(r, front, m->group[front], i, m->group[front][i]);
    for (i = 0; i < r->count; i++) {
        if (r->explained[i]) continue;
        if (found < LENSOPT__READINGS) spots[found] = i;
        found++;
    }
    return found;
}

/* Three spots as v 1,2, v 1,3 and v 2,3, with all signs that make them ghosts of three mirrors. */
static void lensopt__read_three(const lensopt__reading *r, int32_t i, int32_t j, int32_t k)
{
    lensopt__mirrors *m = r->out;
    int32_t way;
    for (way = 0; way < 8 && m->few_ways < LENSOPT__READINGS; way++) {
        lensopt__row2 *v = m->few_rows[m->few_ways];
        v[0] = lensopt__spot_row(r, i, m->few_front, way & 1 ? 1 : -1);
        v[1] = lensopt__spot_row(r, j, m->few_front, way & 2 ? 1 : -1);
        v[2] = lensopt__spot_row(r, k, m->few_front, way & 4 ? 1 : -1);
        m->few_ways += lensopt__agree(m, v[0], v[1], v[2]);
    }
}

/* How many surfaces stand on the other side of the stop, whose ghosts are the spots that are left: up to three, which are too few for clusters. -1: more do. */
static int32_t lensopt__how_few(const lensopt__reading *r, int32_t left)
{
    if (r->out->count[0] > 0 && r->out->count[1] > 0) return 0;
    if (left == 0) return 0;
    if (left == 1) return 2;
    if (left == 3 && r->out->few_ways > 0) return 3;
    return 4 * left < r->count ? 0 : -1; /* these have been moved */
}

/* Up to three surfaces on the other side of the stop: their ghosts say most of what they are. surfaces 0: as many as there must be. 0: there are
   more, or no such ghosts, or (from scratch, where that is asked for) fewer than spots. */
static int lensopt__find_few(lensopt__reading *r, int32_t surfaces)
{
    lensopt__mirrors *m = r->out;
    int32_t spots[LENSOPT__READINGS], left = lensopt__unexplained(r, spots), some = left < LENSOPT__READINGS ? left : LENSOPT__READINGS, i, j, k;
    m->few_front = m->count[1] == 0;
    for (i = 0; i < some; i++) m->few_spot[m->few_spots++] = lensopt__spot_row(r, spots[i], m->few_front, 1);
    for (i = 0; i < some; i++)
        for (j = 0; j < some; j++)
            for (k = 0; k < some; k++)
                if (i != j && i != k && j != k) lensopt__read_three(r, spots[i], spots[j], spots[k]);
    m->few = surfaces > 0 ? surfaces - m->count[0] - m->count[1] : lensopt__how_few(r, left);
    if (m->few < 0 || m->few > 3 || m->count[0] + m->count[1] + m->few > LENSOPT_MAX_SEARCHED || (m->few > 0 && m->count[m->few_front] > 0)) return 0;
    if (surfaces == 0 && r->every && lensopt__pairs_of(m->count[0]) + lensopt__pairs_of(m->count[1]) + lensopt__pairs_of(m->few) < r->count) return 0;
    return m->few < 3 ? left >= m->few - 1 : m->few_ways > 0; /* three of which a ghost is missing: found faster by searching */
}

/* Whether mirrors explain most spots, and more of them than they are themselves, 2 numbers each, h and e, and enough of their ghosts are there: spots in
   regular rows have many equal cross products, too, and mirrors that explain them, with as many ghosts besides. */
static int lensopt__convinces(lensopt__reading *r, int32_t surfaces)
{
    const lensopt__mirrors *m = r->out;
    int32_t spots[LENSOPT__READINGS], explained = r->count - lensopt__unexplained(r, spots), mirrors = m->count[0] + m->count[1];
    int32_t ghosts = lensopt__pairs_of(m->count[0]) + lensopt__pairs_of(m->count[1]);
    return mirrors > 0 && 2 * explained >= r->count && explained >= mirrors + 2 && 10 * explained >= (surfaces > 0 ? 4 : 6) * ghosts;
}

/* Reads the spots. out->usable: whether all surfaces are known that a lens of so many (0: any number) has. */
static void lensopt__read_mirrors(lensopt__reading *r, int32_t surfaces)
{
    lensopt__mirrors *m = r->out;
    int32_t front;
    memset(m, 0, sizeof *m);
    m->chief = 1;
    r->clusters = 0;
    r->proofs_left = 2000;
    for (front = 0; front < 2; front++) lensopt__find_clusters(r, front);
    qsort(r->cluster, (size_t)r->clusters, sizeof r->cluster[0], lensopt__compare_clusters);
    if (!lensopt__find_rays(r)) return;
    for (front = 0; front < 2; front++) {
        m->count[front] = lensopt__find_group(r, front, m->group[front]);
        lensopt__order_group(r, front);
    }
    m->usable = lensopt__convinces(r, surfaces) && lensopt__find_few(r, surfaces);
}

/* The light with a slope that has the most spots; -1: none has. */
static int32_t lensopt__light_to_read(const lensopt_problem *p, int32_t *spots)
{
    int32_t l, g, count, best = -1;
    *spots = 3; /* which tell nothing */
    for (l = 0; l < p->lights; l++) {
        for (g = 0, count = 0; g < p->goals; g++) count += p->target.ghosts[p->ghost_of[g]].goals[l].wish == LENSOPT_SPOT;
        if (count <= *spots || !(p->slopes[l] > 1e-9) || !(p->target.lights[l].weight > 0)) continue;
        *spots = count;
        best = l;
    }
    return best;
}

/* Whether a lens can be built freely: nothing but its media and coatings is locked. */
static int lensopt__is_free(const lensopt_problem *p)
{
    int32_t i, locks = p->has_base ? p->target.stop_locks : 0;
    for (i = 0; p->has_base && i < p->surfaces; i++) locks |= lensopt__locks(p, i) & (LENSOPT_LOCK_RADIUS | LENSOPT_LOCK_GAP);
    return locks == 0;
}

/* Reads the target's spots as those of a lens of so many surfaces, or (0) any number. 0: no memory. */
static int lensopt__find_mirrors(lensopt_problem *p, int32_t surfaces)
{
    lensopt__reading *r;
    double *spots;
    size_t size;
    int32_t count, g, i, light = lensopt__light_to_read(p, &count);
    if (light < 0 || count > LENSOPT__MOST_READ || p->desc.blind || !lensopt__is_free(p)) return 1;
    size = sizeof *r + sizeof(lensopt__crossing) * (size_t)count * (size_t)(count - 1) + 2 * sizeof(double) * (size_t)count;
    r = (lensopt__reading *)p->desc.allocate(p->desc.allocate_user, NULL, 0, size);
    if (r == NULL) return 0;
    r->crossing = (lensopt__crossing *)(void *)(r + 1);
    spots = (double *)(void *)(r->crossing + (size_t)count * (size_t)(count - 1));
    for (g = 0, r->count = 0; g < p->goals; g++) {
        const lensopt_goal *goal = &p->target.ghosts[p->ghost_of[g]].goals[light];
        if (goal->wish != LENSOPT_SPOT) continue;
        for (i = r->count++; i > 0 && spots[i - 1] > goal->centre; i--) {
            spots[i] = spots[i - 1];
            spots[count + i] = spots[count + i - 1];
        }
        spots[i] = goal->centre;
        spots[count + i] = goal->radius;
    }
    r->centre = spots;
    r->radius = spots + count;
    r->out = &p->mirrors;
    r->every = p->desc.objective != LENSOPT_SEEN;
    r->blur = 0.01 * sqrt(p->target.sensor_width * p->target.sensor_width + p->target.sensor_height * p->target.sensor_height);
    for (r->exact = 1e-10; r->exact < 2e-6 && !p->mirrors.usable; r->exact *= 100) lensopt__read_mirrors(r, surfaces);
    p->mirrors.slope = p->slopes[light];
    p->desc.allocate(p->desc.allocate_user, r, size, 0);
    return 1;
}

/* -- a lens out of mirrors -- */

typedef struct lensopt__build {
    const lensopt_problem *p;
    uint64_t *random;
    int32_t stop;                                   /* the surface in front of it; -1: none is */
    int32_t left;                                   /* surfaces that may still be tried */
    lensopt__mirror mirror[2][LENSOPT_MAX_SEARCHED];
    uint64_t after[2][LENSOPT_MAX_SEARCHED];        /* bits: which others stand behind it */
    int32_t at[LENSOPT_MAX_SEARCHED];               /* the mirror that surface i is */
    double slope[2];                                /* at the sensor, of the chief and the marginal ray */
    double off[2];                                  /* what the light that comes in lacks: the marginal ray's slope over its height, the chief ray's slope */
    lensopt__design design;
} lensopt__build;

static double lensopt__either_sign(uint64_t *random) { return lensopt_random(random) < 0.5 ? -1 : 1; }

static lensopt__row2 lensopt__draw_row(uint64_t *random)
{
    double x = lensopt__either_sign(random) * 0.1 * pow(30, lensopt_random(random)), y = lensopt__either_sign(random) * 0.1 * pow(300, lensopt_random(random));
    return lensopt__row2_of(x, y);
}

/* Three mirrors whose ghosts three spots are: all but one number of theirs. */
static void lensopt__draw_three(const lensopt__mirrors *m, uint64_t *random, lensopt__mirror *group)
{
    const lensopt__row2 to = lensopt__sensor_row(m), *v = m->few_rows[(int32_t)(lensopt_random(random) * m->few_ways)];
    double rows[3][4];
    lensopt__row2 w[2];
    int32_t k, tries;
    for (tries = 0; tries < 8; tries++) {
        lensopt__no_trace(v[1], v[2], rows[1]);
        for (k = 0; k < 4; k++) rows[2][k] = lensopt__either_sign(random) * pow(100, lensopt_random(random));
        if (!lensopt__first_two(m, v[0], rows, w)) continue;
        group[0] = lensopt__mirror_between(to, w[0]);
        group[1] = lensopt__mirror_between(to, w[1]);
        group[2] = lensopt__mirror_between(w[0], v[1]);
        return;
    }
}

/* Mirrors of a group that is known in part, by chance as far as it is not. */
static void lensopt__draw_few(const lensopt__mirrors *m, uint64_t *random, lensopt__mirror *group)
{
    if (m->few == 3) {
        lensopt__draw_three(m, random, group);
        return;
    }
    group[0] = lensopt__mirror_between(lensopt__sensor_row(m), lensopt__draw_row(random));
    if (m->few == 2) {
        lensopt__row2 v = m->few_spot[(int32_t)(lensopt_random(random) * m->few_spots)];
        v.y *= lensopt__either_sign(random);
        group[1] = lensopt__mirror_between(lensopt__mirrored(lensopt__sensor_row(m), group[0]), v);
    }
}

/* As rays see it: the transposed of what is read from rows against the marginal ray and the sensor. */
static lensopt__mirror lensopt__transposed(const lensopt__mirrors *m, lensopt__mirror one)
{
    lensopt__square rows = {0, 1, 1, 0};
    lensopt__mirror out;
    rows.a = -m->marginal;
    one = lensopt__seen_through(rows, one);
    out.a = one.a;
    out.b = one.c;
    out.c = one.b;
    return out;
}

/* The mirrors of both groups, and what is known of their order. With the other sign, which no ghost tells, a group's vertices are its centres of
   curvature, and the other way round. */
static void lensopt__line_up(lensopt__build *b)
{
    const lensopt__mirrors *m = &b->p->mirrors;
    int32_t front, i, j;
    for (front = 0; front < 2; front++) {
        int32_t some = m->few > 0 && m->few_front == front, count = some ? m->few : m->count[front];
        double sign = lensopt__either_sign(b->random);
        lensopt__mirror few[3];
        memset(few, 0, sizeof few); /* where none can be drawn: it fits nowhere */
        if (some) lensopt__draw_few(m, b->random, few);
        if (front) b->stop = count - 1;
        for (i = 0; i < count; i++) {
            lensopt__mirror one = some ? few[i] : m->group[front][i];
            if (front) one = lensopt__transposed(m, one);
            b->mirror[front][i].a = sign * one.a;
            b->mirror[front][i].b = sign * one.b;
            b->mirror[front][i].c = sign * one.c;
            b->after[front][i] = 0;
            for (j = 0; j < count; j++) { /* those in front of the stop are read the other way round */
                uint64_t first = some ? front ? j < i : j > i : front ? m->ahead[1][j] >> i & 1 : m->ahead[0][i] >> j & 1;
                b->after[front][i] |= first << j;
            }
        }
    }
}

/* All of a group, as bits. */
static uint64_t lensopt__everyone(const lensopt__build *b, int front)
{
    int32_t count = front ? b->stop + 1 : b->p->surfaces - b->stop - 1;
    return count > 0 ? ~(uint64_t)0 >> (64 - count) : 0;
}

static int lensopt__stop_in(lensopt__build *b, const lensopt__square *q, double *behind)
{
    *behind = -q->d / q->c; /* where the chief ray is on the axis */
    b->design.iris = fabs((q->b + *behind * q->a) / (q->a * q->d - q->b * q->c));
    return *behind >= 0 && lensopt__within(b->design.iris, b->p->desc.stop_radius.lo, b->p->desc.stop_radius.hi);
}

/* Surface i and the gap behind it, where q takes rays from: its medium's index is known. q is moved to the surface. 0: outside the bounds. */
static int lensopt__stand(lensopt__build *b, int32_t i, lensopt__square *q)
{
    const lensopt__limits *l = &b->p->limits[i];
    lensopt__mirror m = lensopt__seen_through(*q, b->mirror[i <= b->stop][b->at[i]]);
    double n = b->design.n[i], tau = -m.b / (1 + m.a), behind, d = n * tau, c = -m.c / (2 * n);
    const lensopt_range *r = n == 1 ? &l->air_gap : &l->glass_gap;
    int ok = lensopt__within(d, r->lo, r->hi) && fabs(c) <= fmax(1 / b->p->desc.least_radius, fabs(b->p->fixed.c[i]));
    b->design.c[i] = c;
    b->design.d[i] = d;
    if (i == b->stop) {
        ok = lensopt__stop_in(b, q, &behind) && behind <= d && n == 1 && ok;
        b->design.ahead = d - behind;
    }
    q->b += tau * q->a;
    q->d += tau * q->c;
    return ok;
}

/* On through surface i, to what stands in front. */
static void lensopt__pass(const lensopt__build *b, int32_t i, lensopt__square *q)
{
    double phi = (b->design.n[i] - (i > 0 ? b->design.n[i - 1] : 1)) * b->design.c[i];
    q->a -= phi * q->b;
    q->c -= phi * q->d;
}

static lensopt__square lensopt__at_sensor(const lensopt__build *b)
{
    const lensopt__mirrors *m = &b->p->mirrors;
    double det = b->slope[1] - m->marginal * b->slope[0] / m->chief;
    lensopt__square q; /* the inverse of [1, marginal; slope / chief, slope] */
    q.a = b->slope[1] / det;
    q.b = -m->marginal / det;
    q.c = -b->slope[0] / m->chief / det;
    q.d = 1 / det;
    return q;
}

/* In front of all. */
static int lensopt__come_in(lensopt__build *b, const lensopt__square *q)
{
    b->off[0] = -q->a / q->b;
    b->off[1] = -q->c * b->p->mirrors.chief / (q->a * q->d - q->b * q->c) - b->p->mirrors.slope;
    return b->stop >= 0 || (lensopt__stop_in(b, q, &b->design.ahead) && b->design.ahead <= -b->p->lower[b->p->place_of] * b->p->desc.air_gap.hi);
}

/* An index for gap i: air in one of five tries, if it may be there. 0: none. */
static double lensopt__draw_index(const lensopt__build *b, int32_t i, int air)
{
    const lensopt_problem *p = b->p;
    if (p->index_of[i] < 0) return air ? p->fixed.n[i] : 0;
    if (air) return p->limits[i].may_air ? 1 : 0;
    if (!p->limits[i].may_glass || i == b->stop) return 0;
    if (p->glasses > 0) return p->glass[(int32_t)(lensopt_random(b->random) * p->glasses)].n;
    return p->limits[i].index.lo + (p->limits[i].index.hi - p->limits[i].index.lo) * lensopt_random(b->random);
}

static int lensopt__build_from(lensopt__build *b, int32_t i, lensopt__square q, uint64_t left);

/* Mirror b->at[i] as surface i, the index behind it being known, and all in front of it; left: which others of its group are. */
static int lensopt__build_on(lensopt__build *b, int32_t i, lensopt__square q, uint64_t left)
{
    int32_t t, air = (int32_t)(3 * lensopt_random(b->random));
    if (b->left-- <= 0 || !lensopt__stand(b, i, &q)) return 0;
    for (t = 0; t < 5; t++) {
        lensopt__square next = q;
        if (i > 0) b->design.n[i - 1] = lensopt__draw_index(b, i - 1, t == air);
        if (i > 0 ? b->design.n[i - 1] == 0 || b->design.n[i - 1] == b->design.n[i] : b->design.n[0] == 1) continue;
        lensopt__pass(b, i, &next);
        if (i == 0 ? lensopt__come_in(b, &next) : lensopt__build_from(b, i - 1, next, i - 1 == b->stop ? lensopt__everyone(b, 1) : left)) return 1;
    }
    return 0;
}

/* Any of the mirrors that are left, that none which is left stands behind. */
static int lensopt__build_from(lensopt__build *b, int32_t i, lensopt__square q, uint64_t left)
{
    const uint64_t *after = b->after[i <= b->stop];
    int32_t first = (int32_t)(64 * lensopt_random(b->random)), c;
    for (c = 0; c < 64; c++) {
        int32_t k = (first + c) & 63;
        if (!(left >> k & 1) || (after[k] & left) != 0) continue;
        b->at[i] = k;
        if (lensopt__build_on(b, i, q, left & ~((uint64_t)1 << k))) return 1;
    }
    return 0;
}

/* The same with mirrors and indices as they are: whether it is within the bounds. */
static int lensopt__rebuild(lensopt__build *b, double chief, double marginal)
{
    lensopt__square q;
    int32_t i;
    int ok = 1;
    b->slope[0] = chief;
    b->slope[1] = marginal;
    q = lensopt__at_sensor(b);
    for (i = b->p->surfaces - 1; i >= 0; i--) {
        ok = lensopt__stand(b, i, &q) && ok;
        lensopt__pass(b, i, &q);
    }
    return lensopt__come_in(b, &q) && ok;
}

/* Newton's steps to the two slopes for which light comes in as it should. */
static int lensopt__aim(lensopt__build *b)
{
    double x = b->slope[0], y = b->slope[1], dx, dy, off[2], by_x[2], by_y[2], det;
    int32_t step, k;
    for (step = 0; step < 16 && b->left > 0; step++, b->left -= 3 * b->p->surfaces) {
        int ok = lensopt__rebuild(b, x, y);
        if (fabs(b->off[0]) < 1e-14 && fabs(b->off[1]) < 1e-14) return ok;
        memcpy(off, b->off, sizeof off);
        dx = 1e-7 * (fabs(x) + 1e-3);
        dy = 1e-7 * fabs(y);
        lensopt__rebuild(b, x + dx, y);
        for (k = 0; k < 2; k++) by_x[k] = (b->off[k] - off[k]) / dx;
        lensopt__rebuild(b, x, y + dy);
        for (k = 0; k < 2; k++) by_y[k] = (b->off[k] - off[k]) / dy;
        det = by_x[0] * by_y[1] - by_x[1] * by_y[0];
        x -= (by_y[1] * off[0] - by_y[0] * off[1]) / det;
        y -= (by_x[0] * off[1] - by_x[1] * off[0]) / det;
        if (!(fabs(x) < 10 && fabs(y) < 10)) return 0;
    }
    return lensopt__rebuild(b, x, y) && fabs(b->off[0]) < 1e-9 && fabs(b->off[1]) < 1e-9;
}

/* A lens whose ghosts are the spots that the mirrors are read from. *left: surfaces that may still be tried. 0: it has used them up. */
static int lensopt__build_lens(const lensopt_problem *p, uint64_t *random, int32_t *left, lensopt__design *out)
{
    enum { SLOPES = 64, MOST = 2000 };
    lensopt__build b;
    int32_t k, built = 0;
    b.p = p;
    b.random = random;
    while (*left > 0 && !built) {
        lensopt__line_up(&b);
        for (k = 0; k < (p->mirrors.few > 0 ? SLOPES / 8 : SLOPES) && *left > 0 && !built; k++) {
            int32_t some = *left < MOST ? *left : MOST;
            b.design = p->fixed;
            b.design.n[p->surfaces - 1] = 1;
            b.design.stop = b.stop;
            b.slope[0] = lensopt__either_sign(random) * p->mirrors.slope * 0.05 * pow(100, lensopt_random(random)); /* the light's own, more or less */
            b.slope[1] = lensopt__either_sign(random) * 0.003 * pow(100, lensopt_random(random));
            b.left = some;
            built = lensopt__build_from(&b, p->surfaces - 1, lensopt__at_sensor(&b), lensopt__everyone(&b, b.stop == p->surfaces - 1)) && lensopt__aim(&b);
            *left -= some - b.left + 1;
        }
    }
    if (built) *out = b.design;
    return built;
}

/* Few spots are easily taken for those of a lens that is none. */
static int lensopt__is_built(const lensopt_problem *p)
{
    int32_t left = 2000000;
    uint64_t random = 1;
    lensopt__design d;
    return p->goals > 40 || lensopt__build_lens(p, &random, &left, &d);
}

/* >> 8 assignment */
/* Which of a lens's ghosts is which of the target's: rows (those of the target) are given columns (those of the lens), each column at most once,
   or none at a price of their own, so that all costs add up to the least. */

/* -- numbers in lanes -- */

#if defined(__GNUC__) && defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ == 0
#define LENSOPT__INLINE static inline __attribute__((always_inline))
#define LENSOPT__LANES 4
typedef double lensopt__vec __attribute__((vector_size(32)));
typedef int64_t lensopt__mask __attribute__((vector_size(32)));
#define LENSOPT__BITS(v) ((lensopt__mask)(v))
#define LENSOPT__VEC(m) ((lensopt__vec)(m))
#define LENSOPT__WHERE(mask, a, b) LENSOPT__VEC((LENSOPT__BITS(mask) & LENSOPT__BITS(a)) | (~LENSOPT__BITS(mask) & LENSOPT__BITS(b)))
#define LENSOPT__ABS(v) LENSOPT__VEC(LENSOPT__BITS(v) & INT64_MAX)
#else
#define LENSOPT__INLINE static
#define LENSOPT__LANES 1
typedef double lensopt__vec;
typedef int lensopt__mask;
#define LENSOPT__BITS(v) (v)
#define LENSOPT__WHERE(mask, a, b) ((mask) ? (a) : (b))
#define LENSOPT__ABS(v) fabs(v)
#endif
#define LENSOPT__LANE(v, l) (((double *)&(v))[l])

/* The same arithmetic, and so the same results, in wider registers where the processor has them. */
#if LENSOPT__LANES > 1 && defined(__x86_64__) && !defined(_WIN32) /* where stacks are not aligned for them */
#define LENSOPT__WIDE __attribute__((target("avx2")))
#define LENSOPT__KERNEL(name) (__builtin_cpu_supports("avx2") ? name##_wide : name##_plain)
#else
#define LENSOPT__KERNEL(name) name##_plain
#endif

/* -- assignments -- */

typedef struct lensopt__assignment {
    int32_t rows, columns;
    double *cost;           /* a row's columns after each other */
    double *none;           /* of a row without a column */
    int32_t *column_of;     /* of each row; -1: none */
    int32_t *row_of;        /* of each column; -1: none */
    int32_t stride;         /* columns, up to whole lanes: those behind the last cost HUGE_VAL */
    double *price, *least;  /* of a column; the shortest way to it */
    double *way, *closed;   /* the row before it on that way; 0, or HUGE_VAL where that is final: doubles for the lanes' sake */
    int32_t *alone;         /* rows that wait */
} lensopt__assignment;

static int32_t lensopt__whole_lanes(int32_t count) { return (count + LENSOPT__LANES - 1) / LENSOPT__LANES * LENSOPT__LANES; }

/* Bytes that an assignment's arrays take. */
static size_t lensopt__assignment_size(int32_t rows, int32_t columns)
{
    size_t r = (size_t)rows, stride = (size_t)lensopt__whole_lanes(columns);
    return sizeof(double) * ((r + 4) * stride + r) + sizeof(int32_t) * (2 * r + stride) + sizeof(lensopt__vec);
}

/* memory: lensopt__assignment_size bytes, aligned or not. */
static void lensopt__assignment_in(void *memory, int32_t rows, int32_t columns, lensopt__assignment *out)
{
    int32_t i, j;
    out->rows = rows;
    out->columns = columns;
    out->stride = lensopt__whole_lanes(columns);
    out->cost = (double *)(((uintptr_t)memory + sizeof(lensopt__vec) - 1) / sizeof(lensopt__vec) * sizeof(lensopt__vec));
    out->price = out->cost + (size_t)rows * (size_t)out->stride;
    out->least = out->price + out->stride;
    out->way = out->least + out->stride;
    out->closed = out->way + out->stride;
    out->none = out->closed + out->stride;
    out->column_of = (int32_t *)(void *)(out->none + rows);
    out->row_of = out->column_of + rows;
    out->alone = out->row_of + out->stride;
    for (i = 0; i < rows; i++)
        for (j = columns; j < out->stride; j++) out->cost[(size_t)i * (size_t)out->stride + (size_t)j] = HUGE_VAL;
}

/* Rows bid: each takes the column that is best for it, whose price falls until the second best would do as well, and the row that had it bids
   again (augmenting row reduction; Jonker and Volgenant, Computing 38, 1987). Where all want the same few columns, prices fall in so many small
   steps that the search below is faster: hence a limit. Returns how many rows are left alone. */
static int32_t lensopt__bid(lensopt__assignment *a)
{
    int32_t left = a->rows, bids = 8 * a->rows, round, i, j;
    for (i = 0; i < a->rows; i++) a->alone[i] = i;
    for (round = 0; round < 3; round++) {
        int32_t waiting = left;
        for (left = i = 0; i < waiting; bids--) {
            int32_t row = a->alone[i++], best = -1, other;
            const double *cost = a->cost + (size_t)row * (size_t)a->stride;
            double first = a->none[row], second = HUGE_VAL;
            if (bids <= 0) {
                a->alone[left++] = row;
                continue;
            }
            for (j = 0; j < a->columns; j++) {
                double c = cost[j] - a->price[j];
                if (!(c < second)) continue;
                second = c < first ? first : c;
                if (c < first) {
                    first = c;
                    best = j;
                }
            }
            a->column_of[row] = best;
            if (best < 0) continue;
            other = a->row_of[best];
            a->row_of[best] = row;
            a->price[best] -= second - first;
            if (other < 0) continue;
            a->column_of[other] = -1;
            if (second > first) a->alone[--i] = other;
            else a->alone[left++] = other;
        }
    }
    return left;
}

/* Ways over `row`: a column lies as far on as its price leaves of the row's cost, less base. The nearest that is not closed; *shortest: how far. */
LENSOPT__INLINE int32_t lensopt__reach_over(lensopt__assignment *a, int32_t row, double base, double *shortest)
{
    const lensopt__vec none = {0};
    const lensopt__vec *cost = (const lensopt__vec *)(const void *)(a->cost + (size_t)row * (size_t)a->stride), *price = (const lensopt__vec *)(const void *)a->price;
    const lensopt__vec *closed = (const lensopt__vec *)(const void *)a->closed;
    lensopt__vec *least = (lensopt__vec *)(void *)a->least, *way = (lensopt__vec *)(void *)a->way, nearest = none - 1, best = none + HUGE_VAL, at = none, from = none + row;
    int32_t k, l, out = -1;
    for (l = 0; l < LENSOPT__LANES; l++) LENSOPT__LANE(at, l) = l;
    for (k = 0; k < a->stride / LENSOPT__LANES; k++, at += LENSOPT__LANES) {
        lensopt__vec here = cost[k] - price[k] - base + closed[k], open;
        lensopt__mask shorter = LENSOPT__BITS(here < least[k]);
        least[k] = LENSOPT__WHERE(shorter, here, least[k]);
        way[k] = LENSOPT__WHERE(shorter, from, way[k]);
        open = least[k] + closed[k];
        shorter = LENSOPT__BITS(open < best);
        best = LENSOPT__WHERE(shorter, open, best);
        nearest = LENSOPT__WHERE(shorter, at, nearest);
    }
    *shortest = HUGE_VAL;
    for (l = 0; l < LENSOPT__LANES; l++) {
        double d = LENSOPT__LANE(best, l), j = LENSOPT__LANE(nearest, l);
        if (!(d < *shortest || (d == *shortest && j < out))) continue;
        *shortest = d;
        out = (int32_t)j;
    }
    return out;
}

/* The shortest way from a row that is alone to a column that is free, or to a row that does without, by Dijkstra's search; all rows on it
   change their columns. */
LENSOPT__INLINE void lensopt__augment_lanes(lensopt__assignment *a, int32_t source)
{
    int32_t row = source, at = -1, without = source, j;
    double reached = 0, none = HUGE_VAL, base = 0;
    for (j = 0; j < a->stride; j++) {
        a->least[j] = HUGE_VAL;
        a->closed[j] = 0;
    }
    for (;;) {
        double shortest;
        int32_t nearest = lensopt__reach_over(a, row, base, &shortest);
        if (a->none[row] - base < none) {
            none = a->none[row] - base;
            without = row;
        }
        at = -1;
        reached = none;
        if (nearest < 0 || none <= shortest) break;
        at = nearest;
        reached = shortest;
        row = a->row_of[at];
        if (row < 0) break;
        a->closed[at] = HUGE_VAL;
        base = a->cost[(size_t)row * (size_t)a->stride + (size_t)at] - a->price[at] - reached;
    }
    for (j = 0; j < a->columns; j++)
        if (a->closed[j] > 0) a->price[j] += a->least[j] - reached;
    do {
        row = at >= 0 ? (int32_t)a->way[at] : without;
        j = a->column_of[row];
        a->column_of[row] = at;
        if (at >= 0) a->row_of[at] = row;
        at = j;
    } while (row != source);
}

static void lensopt__augment_plain(lensopt__assignment *a, int32_t source) { lensopt__augment_lanes(a, source); }
#if defined(LENSOPT__WIDE)
LENSOPT__WIDE static void lensopt__augment_wide(lensopt__assignment *a, int32_t source) { lensopt__augment_lanes(a, source); }
#endif

/* What costs HUGE_VAL, or is not a number, is not taken; none costs a number. column_of and row_of are filled. */
static void lensopt__assignment_solve(lensopt__assignment *a)
{
    int32_t i, alone;
    for (i = 0; i < a->stride; i++) {
        a->price[i] = 0;
        a->row_of[i] = -1;
    }
    for (i = 0; i < a->rows; i++) a->column_of[i] = -1;
    alone = lensopt__bid(a);
    for (i = 0; i < alone; i++) LENSOPT__KERNEL(lensopt__augment)(a, a->alone[i]);
}

/* >> 9 objective */
/* Many candidates at a time: each number is an array over lanes. Optical lengths and angles are the reduced ones (gap / n, n * angle), so that
   every matrix has determinant 1: refraction [1 0; -phi 1], a mirror [1 0; psi 1], a gap [1 tau; 0 1]. Mirrors met from the front have
   psi = 2 n c, from behind -2 n c.

   The first row of a ghost's matrix to the sensor is: what lies behind surface i (s), mirror i, back from i to j, mirror j, and the way there (P j).
   For one i it grows with j by two multiply-adds; the mirror takes one, the way there four. */

#define LENSOPT__MOST_PAIRS 2016 /* of LENSOPT_MAX_SEARCHED surfaces */

/* Candidates whose stop stands in the same gap. */
typedef struct lensopt__batch {
    int32_t surfaces, stop;
    lensopt__vec iris, ahead;
    lensopt__vec c[LENSOPT_MAX_SEARCHED], tau[LENSOPT_MAX_SEARCHED], n[LENSOPT_MAX_SEARCHED + 1]; /* n: in front of the surface */
    lensopt__vec phi[LENSOPT_MAX_SEARCHED];
    lensopt__vec p00[LENSOPT_MAX_SEARCHED + 1], p01[LENSOPT_MAX_SEARCHED + 1], p10[LENSOPT_MAX_SEARCHED + 1], p11[LENSOPT_MAX_SEARCHED + 1];
    lensopt__vec s0[LENSOPT_MAX_SEARCHED], s1[LENSOPT_MAX_SEARCHED], z0[LENSOPT_MAX_SEARCHED], z1[LENSOPT_MAX_SEARCHED]; /* z: to the stop */
    lensopt__vec a00, a01;  /* directly to the stop */
    lensopt__vec m00, m01;  /* from the stop directly to the sensor */
} lensopt__batch;

/* What the spots of a batch follow from: first rows of the matrices to the sensor, to the stop, and from there to the sensor. a00 is 0 where
   one of the surfaces parts nothing, so that there is no ghost. */
typedef struct lensopt__rows {
    int32_t pairs;
    lensopt__vec m00[LENSOPT__MOST_PAIRS], m01[LENSOPT__MOST_PAIRS], a00[LENSOPT__MOST_PAIRS], s01[LENSOPT__MOST_PAIRS];
} lensopt__rows;

LENSOPT__INLINE void lensopt__prefixes(lensopt__batch *b)
{
    const lensopt__vec none = {0};
    int32_t s;
    b->p00[0] = b->p11[0] = b->a00 = none + 1;
    b->p10[0] = b->a01 = none;
    b->p01[0] = b->stop < 0 ? b->ahead : none;
    for (s = 0; s < b->surfaces; s++) {
        b->phi[s] = (b->n[s + 1] - b->n[s]) * b->c[s];
        b->p10[s + 1] = b->p10[s] - b->phi[s] * b->p00[s];
        b->p11[s + 1] = b->p11[s] - b->phi[s] * b->p01[s];
        b->p00[s + 1] = b->p00[s] + b->tau[s] * b->p10[s + 1];
        b->p01[s + 1] = b->p01[s] + b->tau[s] * b->p11[s + 1];
    }
    if (b->stop < 0) return;
    b->a00 = b->p00[b->stop] + b->ahead * b->p10[b->stop + 1];
    b->a01 = b->p01[b->stop] + b->ahead * b->p11[b->stop + 1];
}

LENSOPT__INLINE void lensopt__suffixes(lensopt__batch *b)
{
    const lensopt__vec none = {0};
    lensopt__vec r0 = none + 1, r1 = none;
    int32_t s;
    for (s = b->surfaces - 1; s >= 0; s--) {
        if (s == b->stop) {
            b->m00 = r0;
            b->m01 = r1 + (b->tau[s] - b->ahead) * r0;
        }
        b->s0[s] = r0;
        b->s1[s] = r1 += b->tau[s] * r0;
        r0 -= b->phi[s] * r1;
    }
    r0 = none + 1;
    r1 = b->ahead;
    for (s = b->stop; s >= 0; s--) {
        b->z0[s] = r0;
        b->z1[s] = r1;
        if (s == 0) break;
        r0 -= b->phi[s] * r1;
        r1 += b->tau[s - 1] * r0;
    }
}

/* Ghosts whose reflections lie from surface `from` to `to`, in front of the stop or behind it. */
LENSOPT__INLINE void lensopt__rows_between(const lensopt__batch *b, int32_t from, int32_t to, const int front, lensopt__rows *out)
{
    int32_t i, j, g = out->pairs;
    for (i = from; i < to; i++) {
        const lensopt__vec none = {0};
        lensopt__vec psi = -2 * b->n[i + 1] * b->c[i], y0 = none, y1 = none, a = b->a00;
        lensopt__vec r0 = b->s0[i] + psi * b->s1[i], r1 = b->s1[i] + b->tau[i] * r0;
        if (front) {
            y0 = b->z0[i] + psi * b->z1[i];
            y1 = b->z1[i] + b->tau[i] * y0;
        }
        for (j = i + 1; j <= to; j++, g++) {
            lensopt__vec q;
            psi = 2 * b->n[j] * b->c[j];
            q = r0 + psi * r1;
            out->m00[g] = q * b->p00[j] + r1 * b->p10[j];
            out->m01[g] = q * b->p01[j] + r1 * b->p11[j];
            if (front) {
                a = (y0 + psi * y1) * b->p00[j] + y1 * b->p10[j];
                out->s01[g] = b->m01;
                y0 -= b->phi[j] * y1;
                y1 += b->tau[j] * y0;
            } else {
                out->s01[g] = out->m01[g] * a - out->m00[g] * b->a01;
            }
            out->a00[g] = LENSOPT__WHERE(LENSOPT__BITS(b->n[i] != b->n[i + 1]) & LENSOPT__BITS(b->n[j] != b->n[j + 1]), a, none);
            r0 -= b->phi[j] * r1;
            r1 += b->tau[j] * r0;
        }
    }
    out->pairs = g;
}

LENSOPT__INLINE void lensopt__all_rows(lensopt__batch *b, lensopt__rows *out)
{
    lensopt__prefixes(b);
    lensopt__suffixes(b);
    out->pairs = 0;
    lensopt__rows_between(b, 0, b->stop, 1, out);
    lensopt__rows_between(b, b->stop + 1, b->surfaces - 1, 0, out);
}

/* -- the thesis' objective -- */

/* Radii over m00, centres over m01, at one light; returns how many are seen. The smaller of both images is what is seen, if they meet
   (P 3; optimiser.md); what is hidden has a radius that sorts behind all. */
LENSOPT__INLINE void lensopt__merge(const lensopt__batch *b, lensopt__rows *rows, double u, double pupil, lensopt__vec *count)
{
    const lensopt__vec none = {0}, one = none + 1, hidden = none + 1e300;
    lensopt__vec seen = none;
    int32_t g;
    for (g = 0; g < rows->pairs; g++) {
        lensopt__vec size = LENSOPT__ABS(rows->m00[g]), inverse = 1 / rows->a00[g], shrink = b->iris * LENSOPT__ABS(inverse);
        lensopt__vec pupil_radius = pupil * size, iris_radius = shrink * size;
        lensopt__vec pupil_centre = u * rows->m01[g], iris_centre = u * (rows->s01[g] * inverse), apart = pupil_centre - iris_centre;
        lensopt__mask by_pupil = LENSOPT__BITS(shrink > pupil);
        lensopt__mask meet = LENSOPT__BITS(LENSOPT__ABS(apart) <= pupil_radius + iris_radius) & LENSOPT__BITS(rows->a00[g] != none);
        rows->m00[g] = LENSOPT__WHERE(meet, LENSOPT__WHERE(by_pupil, pupil_radius, iris_radius), hidden);
        rows->m01[g] = LENSOPT__WHERE(by_pupil, pupil_centre, iris_centre);
        seen += LENSOPT__WHERE(meet, one, none);
    }
    *count = seen;
}

LENSOPT__INLINE void lensopt__order_two(lensopt__rows *rows, int32_t low, int32_t high)
{
    lensopt__vec a = rows->m00[low], b = rows->m00[high], ca = rows->m01[low], cb = rows->m01[high];
    lensopt__mask swap = LENSOPT__BITS(b < a);
    rows->m00[low] = LENSOPT__WHERE(swap, b, a);
    rows->m00[high] = LENSOPT__WHERE(swap, a, b);
    rows->m01[low] = LENSOPT__WHERE(swap, cb, ca);
    rows->m01[high] = LENSOPT__WHERE(swap, ca, cb);
}

/* All lanes at once by size: Batcher's merge exchange (Knuth, The Art of Computer Programming 3, 5.2.2, algorithm M). */
LENSOPT__INLINE void lensopt__sort(lensopt__rows *rows)
{
    int32_t n = rows->pairs, top = 1, p, q, r, d, i;
    while (2 * top < n) top *= 2;
    for (p = top; p > 0; p /= 2)
        for (q = top, r = 0, d = p;; d = q - p, q /= 2, r = p) {
            for (i = 0; i + d < n; i++)
                if ((i & p) == r) lensopt__order_two(rows, i, i + d);
            if (q == p) break;
        }
}

LENSOPT__INLINE void lensopt__thesis_batch(const lensopt_problem *p, lensopt__batch *b, lensopt__rows *rows, lensopt__vec *f)
{
    const lensopt__vec none = {0}, few = none + 1e5;
    lensopt__vec count, sum = none;
    int32_t g;
    lensopt__all_rows(b, rows);
    lensopt__merge(b, rows, p->slopes[0], p->desc.pupil, &count);
    lensopt__sort(rows);
    for (g = 0; g < p->goals; g++) {
        lensopt__vec dr = rows->m00[g] - p->sorted_radius[g], dc = rows->m01[g] - p->sorted_centre[g];
        sum += dr * dr + dc * dc;
    }
    sum /= p->goals;
    for (; g < rows->pairs; g++) sum += p->surplus / rows->m00[g];
    *f = LENSOPT__WHERE(count < p->goals, few, sum);
}

static void lensopt__rows_plain(lensopt__batch *b, lensopt__rows *rows) { lensopt__all_rows(b, rows); }
static void lensopt__thesis_plain(const lensopt_problem *p, lensopt__batch *b, lensopt__rows *rows, lensopt__vec *f) { lensopt__thesis_batch(p, b, rows, f); }
#if defined(LENSOPT__WIDE)
LENSOPT__WIDE static void lensopt__rows_wide(lensopt__batch *b, lensopt__rows *rows) { lensopt__all_rows(b, rows); }
LENSOPT__WIDE static void lensopt__thesis_wide(const lensopt_problem *p, lensopt__batch *b, lensopt__rows *rows, lensopt__vec *f)
{
    lensopt__thesis_batch(p, b, rows, f);
}
#endif

static void lensopt__lane(lensopt__batch *b, int l, const lensopt__design *d)
{
    int32_t s;
    b->surfaces = d->surfaces;
    b->stop = d->stop;
    LENSOPT__LANE(b->iris, l) = d->iris;
    LENSOPT__LANE(b->ahead, l) = d->ahead;
    LENSOPT__LANE(b->n[0], l) = 1;
    for (s = 0; s < d->surfaces; s++) {
        LENSOPT__LANE(b->c[s], l) = d->c[s];
        LENSOPT__LANE(b->tau[s], l) = d->d[s] / d->n[s];
        LENSOPT__LANE(b->n[s + 1], l) = d->n[s];
    }
}

/* Candidates of a chunk in the order of their stop's gap, so that lanes share it. */
static void lensopt__by_stop(const int32_t *stops, int32_t count, int32_t *order)
{
    int32_t start[LENSOPT_MAX_SEARCHED + 2] = {0}, i;
    for (i = 0; i < count; i++) start[stops[i] + 2]++;
    for (i = 1; i < LENSOPT_MAX_SEARCHED + 2; i++) start[i] += start[i - 1];
    for (i = 0; i < count; i++) order[start[stops[i] + 1]++] = i;
}

static int32_t lensopt__pairs_at(int32_t surfaces, int32_t stop) { return lensopt__pairs_of(stop + 1) + lensopt__pairs_of(surfaces - 1 - stop); }

static void lensopt__thesis(const lensopt_problem *p, const double *x, int32_t count, double *f)
{
    enum { CHUNK = 256 };
    void (*const kernel)(const lensopt_problem *, lensopt__batch *, lensopt__rows *, lensopt__vec *) = LENSOPT__KERNEL(lensopt__thesis);
    int32_t stops[CHUNK], order[CHUNK], i, some, at;
    lensopt__batch b;
    lensopt__rows rows;
    lensopt__design d;
    for (; count > 0; count -= some, x += some * p->variables, f += some) {
        some = count < CHUNK ? count : CHUNK;
        for (i = 0; i < some; i++) stops[i] = lensopt__stop_of(p, x + i * p->variables);
        lensopt__by_stop(stops, some, order);
        for (at = 0; at < some;) {
            int32_t stop = stops[order[at]], filled = 0;
            lensopt__vec out;
            for (i = 0; i < LENSOPT__LANES; i++) {
                int32_t take = at + i < some && stops[order[at + i]] == stop;
                if (take) lensopt__decode(p, x + order[at + i] * p->variables, &d);
                lensopt__lane(&b, i, &d);
                filled += take;
            }
            if (lensopt__pairs_at(p->surfaces, stop) >= p->goals) kernel(p, &b, &rows, &out);
            for (i = 0; i < filled; i++) f[order[at + i]] = lensopt__pairs_at(p->surfaces, stop) >= p->goals ? LENSOPT__LANE(out, i) : 1e5;
            at += filled;
        }
    }
}

/* >> 10 polish */
/* Downhill with exact slopes: each goal is given its ghost (least-cost assignment), then Levenberg-Marquardt steps for the sum of squares. */

/* One candidate's tables, out of a batch. */
typedef struct lensopt__trace {
    int32_t surfaces, stop, variables;
    double n[LENSOPT_MAX_SEARCHED + 1], c[LENSOPT_MAX_SEARCHED], d[LENSOPT_MAX_SEARCHED];
    double tau[LENSOPT_MAX_SEARCHED], phi[LENSOPT_MAX_SEARCHED];
    double p[LENSOPT_MAX_SEARCHED + 1][4];                          /* before each surface: 00 01 10 11 */
    double s[LENSOPT_MAX_SEARCHED][2], z[LENSOPT_MAX_SEARCHED][2];  /* behind each: first rows to the sensor, to the stop */
    double ahead, iris, fraction, place, a00, a01, m00, m01;  /* place: what ahead changes by with the variable */
} lensopt__trace;

/* How a first row's element changes with what its path meets. */
typedef struct lensopt__slope {
    double phi[LENSOPT_MAX_SEARCHED], tau[LENSOPT_MAX_SEARCHED], psi_i, psi_j;
    double ahead; /* the stop moved within its gap */
} lensopt__slope;

static void lensopt__trace_of(const lensopt_problem *p, const lensopt__batch *b, int l, const lensopt__design *d, lensopt__trace *t)
{
    int32_t s;
    t->place = d->stop >= 0 ? d->d[d->stop] : -p->desc.air_gap.hi;
    t->surfaces = d->surfaces;
    t->stop = d->stop;
    t->ahead = d->ahead;
    t->iris = d->iris;
    t->fraction = d->stop >= 0 && d->d[d->stop] > 0 ? d->ahead / d->d[d->stop] : 0;
    t->n[0] = 1;
    for (s = 0; s < d->surfaces; s++) {
        t->n[s + 1] = d->n[s];
        t->c[s] = d->c[s];
        t->d[s] = d->d[s];
        t->tau[s] = LENSOPT__LANE(b->tau[s], l);
        t->phi[s] = LENSOPT__LANE(b->phi[s], l);
        t->p[s][0] = LENSOPT__LANE(b->p00[s], l);
        t->p[s][1] = LENSOPT__LANE(b->p01[s], l);
        t->p[s][2] = LENSOPT__LANE(b->p10[s], l);
        t->p[s][3] = LENSOPT__LANE(b->p11[s], l);
        t->s[s][0] = LENSOPT__LANE(b->s0[s], l);
        t->s[s][1] = LENSOPT__LANE(b->s1[s], l);
        t->z[s][0] = s <= d->stop ? LENSOPT__LANE(b->z0[s], l) : 0;
        t->z[s][1] = s <= d->stop ? LENSOPT__LANE(b->z1[s], l) : 0;
    }
    t->a00 = LENSOPT__LANE(b->a00, l);
    t->a01 = LENSOPT__LANE(b->a01, l);
    t->m00 = LENSOPT__LANE(b->m00, l);
    t->m01 = LENSOPT__LANE(b->m01, l);
}

/* From behind surface `from`, whose rays' matrix is x (00 01 10 11), on to the stop or the sensor. */
static void lensopt__forward_slopes(const lensopt__trace *t, int32_t from, const double *x, int to_stop, lensopt__slope *col0, lensopt__slope *col1)
{
    const double (*rows)[2] = to_stop ? t->z : t->s;
    double x00 = x[0], x01 = x[1], x10 = x[2], x11 = x[3];
    int32_t k, last = to_stop ? t->stop : t->surfaces - 1;
    for (k = from;; k++) {
        double tau = to_stop && k == last ? t->ahead : t->tau[k], w;
        if (to_stop && k == last) {
            col0->ahead += rows[k][0] * x10;
            col1->ahead += rows[k][0] * x11;
        } else {
            col0->tau[k] += rows[k][0] * x10;
            col1->tau[k] += rows[k][0] * x11;
        }
        if (k == last) return;
        x00 += tau * x10;
        x01 += tau * x11;
        w = rows[k + 1][1];
        col0->phi[k + 1] -= w * x00;
        col1->phi[k + 1] -= w * x01;
        x10 -= t->phi[k + 1] * x00;
        x11 -= t->phi[k + 1] * x01;
    }
}

static void lensopt__clear_slopes(int32_t surfaces, lensopt__slope *col0, lensopt__slope *col1)
{
    memset(col0->phi, 0, sizeof(double) * (size_t)surfaces);
    memset(col0->tau, 0, sizeof(double) * (size_t)surfaces);
    memset(col1->phi, 0, sizeof(double) * (size_t)surfaces);
    memset(col1->tau, 0, sizeof(double) * (size_t)surfaces);
    col0->psi_i = col0->psi_j = col0->ahead = col1->psi_i = col1->psi_j = col1->ahead = 0;
}

/* Of the direct path, from the entrance or (past != 0) from the stop. */
static void lensopt__direct_slopes(const lensopt__trace *t, int past, int to_stop, lensopt__slope *col0, lensopt__slope *col1)
{
    double x[4] = {1, 0, 0, 1}, rest;
    int32_t first = past ? t->stop + 1 : 0;
    const double (*rows)[2] = to_stop ? t->z : t->s;
    lensopt__clear_slopes(t->surfaces, col0, col1);
    if (to_stop && t->stop < 0) return;
    if (past && t->stop >= 0) { /* the rest of the stop's gap */
        rest = t->tau[t->stop] - t->ahead;
        col1->tau[t->stop] = t->m00;
        col1->ahead = -t->m00;
        x[1] = rest;
    } else if (t->stop < 0) {
        col1->ahead = t->m00;
        x[1] = t->ahead;
    }
    if (first == t->surfaces) return;
    col0->phi[first] -= rows[first][1] * x[0];
    col1->phi[first] -= rows[first][1] * x[1];
    x[2] -= t->phi[first] * x[0];
    x[3] -= t->phi[first] * x[1];
    lensopt__forward_slopes(t, first, x, to_stop, col0, col1);
}

/* Of the ghost that surface j reflects first and i < j second. */
static void lensopt__ghost_slopes(const lensopt__trace *t, int32_t i, int32_t j, int to_stop, lensopt__slope *col0, lensopt__slope *col1)
{
    const double (*rows)[2] = to_stop ? t->z : t->s;
    double back_tau[LENSOPT_MAX_SEARCHED], back_phi[LENSOPT_MAX_SEARCHED]; /* what follows, in time, each crossing on the way back */
    double psi_i = -2 * t->n[i + 1] * t->c[i], psi_j = 2 * t->n[j] * t->c[j], r0 = rows[i][0] + psi_i * rows[i][1], r1 = rows[i][1], x[4];
    int32_t k;
    lensopt__clear_slopes(t->surfaces, col0, col1);
    for (k = i; k < j; k++) {
        back_tau[k] = r0;
        r1 += t->tau[k] * r0;
        back_phi[k + 1] = r1;
        if (k + 1 < j) r0 -= t->phi[k + 1] * r1;
    }
    memcpy(x, t->p[j], sizeof x);
    col0->psi_j = r1 * x[0];
    col1->psi_j = r1 * x[1];
    r0 += psi_j * r1;
    for (k = j - 1; k >= 0; k--) { /* on the way there */
        const double *p = t->p[k];
        double y10 = p[2] - t->phi[k] * p[0], y11 = p[3] - t->phi[k] * p[1];
        col0->tau[k] = r0 * y10;
        col1->tau[k] = r0 * y11;
        r1 += t->tau[k] * r0;
        col0->phi[k] = -r1 * p[0];
        col1->phi[k] = -r1 * p[1];
        r0 -= t->phi[k] * r1;
    }
    if (t->stop < 0) col1->ahead = r0;
    x[2] += psi_j * x[0];
    x[3] += psi_j * x[1];
    for (k = j - 1; k >= i; k--) {
        col0->tau[k] += back_tau[k] * x[2];
        col1->tau[k] += back_tau[k] * x[3];
        x[0] += t->tau[k] * x[2];
        x[1] += t->tau[k] * x[3];
        if (k == i) break;
        col0->phi[k] -= back_phi[k] * x[0];
        col1->phi[k] -= back_phi[k] * x[1];
        x[2] -= t->phi[k] * x[0];
        x[3] -= t->phi[k] * x[1];
    }
    col0->psi_i = rows[i][1] * x[0];
    col1->psi_i = rows[i][1] * x[1];
    x[2] += psi_i * x[0];
    x[3] += psi_i * x[1];
    lensopt__forward_slopes(t, i, x, to_stop, col0, col1);
}

/* From what a path meets to the lens's numbers; i < 0: the direct path. */
static void lensopt__chain(const lensopt__trace *t, const lensopt__slope *s, int32_t i, int32_t j, double *out)
{
    int32_t k;
    for (k = 0; k < t->surfaces; k++) {
        double n = t->n[k + 1];
        out[LENSOPT__AT_C + k] = (n - t->n[k]) * s->phi[k];
        out[LENSOPT__AT_D + k] = s->tau[k] / n;
        out[LENSOPT__AT_N + k] = t->c[k] * s->phi[k] - (k + 1 < t->surfaces ? t->c[k + 1] * s->phi[k + 1] : 0) - t->tau[k] / n * s->tau[k];
    }
    if (i >= 0) {
        out[LENSOPT__AT_C + i] -= 2 * t->n[i + 1] * s->psi_i;
        out[LENSOPT__AT_N + i] -= 2 * t->c[i] * s->psi_i;
        out[LENSOPT__AT_C + j] += 2 * t->n[j] * s->psi_j;
        out[LENSOPT__AT_N + j - 1] += 2 * t->c[j] * s->psi_j;
    }
    out[LENSOPT__AT_PLACE] = s->ahead * t->place;
    if (t->stop >= 0) out[LENSOPT__AT_D + t->stop] += s->ahead * t->fraction;
    out[LENSOPT__AT_IRIS] = 0;
}

/* -- spots and their slopes -- */

/* A spot for one light, and its partial derivatives by m00, m01, a00, s01 and the iris's radius. */
typedef struct lensopt__image {
    double centre, radius, overlap; /* overlap: of the pupil's and the iris's images, negative where they do not meet */
    double by_centre[5], by_radius[5], by_overlap[5];
} lensopt__image;

static void lensopt__image_of(double m00, double m01, double a00, double s01, double iris, double pupil, double u, lensopt__image *out)
{
    double size = fabs(m00), sign = m00 < 0 ? -1 : 1, inverse = 1 / a00;
    double pupil_radius = pupil * size, iris_radius = iris * size * fabs(inverse), pupil_centre = u * m01, iris_centre = u * s01 * inverse, apart;
    double pc[5] = {0}, pr[5] = {0}, ic[5] = {0}, ir[5] = {0};
    int k, by_pupil = pupil_radius < iris_radius;
    pc[1] = u;
    pr[0] = pupil * sign;
    ic[2] = -iris_centre * inverse;
    ic[3] = u * inverse;
    ir[0] = iris * fabs(inverse) * sign;
    ir[2] = -iris_radius * inverse;
    ir[4] = size * fabs(inverse);
    out->centre = by_pupil ? pupil_centre : iris_centre;
    out->radius = by_pupil ? pupil_radius : iris_radius;
    out->overlap = pupil_radius + iris_radius - fabs(pupil_centre - iris_centre);
    apart = pupil_centre < iris_centre ? -1 : 1;
    for (k = 0; k < 5; k++) {
        out->by_centre[k] = by_pupil ? pc[k] : ic[k];
        out->by_radius[k] = by_pupil ? pr[k] : ir[k];
        out->by_overlap[k] = pr[k] + ir[k] - apart * (pc[k] - ic[k]);
    }
}

enum { LENSOPT__ROWS = 4, LENSOPT__VECTORS = LENSOPT_MAX_VARIABLES / LENSOPT__LANES + 1 };

/* What a polish works on; one block of memory. */
typedef struct lensopt__descent {
    const lensopt_problem *p;
    lensopt__batch batch;
    lensopt__rows rows;
    lensopt__design designs[LENSOPT__LANES];
    lensopt__trace trace;
    lensopt__slope slopes[2];
    double numbers[LENSOPT__NUMBERS];
    int32_t count, there[LENSOPT__MOST_PAIRS];      /* pairs that are ghosts */
    int32_t mate[LENSOPT_MAX_GHOSTS];               /* of each goal: index into there, or -1 */
    int32_t goal_of[LENSOPT__MOST_PAIRS];           /* of each that is there: goal, or -1 */
    double sign[LENSOPT__MOST_PAIRS];               /* of those: which way round its image should be */
    double spot[LENSOPT_MAX_LIGHTS][LENSOPT__MOST_PAIRS][3]; /* of those: centre, radius (negative where it is the wrong way round), overlap */
    double x[LENSOPT__LANES][LENSOPT_MAX_VARIABLES], kept[LENSOPT_MAX_VARIABLES], lo[LENSOPT_MAX_VARIABLES], hi[LENSOPT_MAX_VARIABLES];
    int32_t vectors;                                /* that hold one number a variable */
    lensopt__vec gradient[LENSOPT__VECTORS], step[LENSOPT_MAX_VARIABLES]; /* step: a lane each */
    lensopt__vec row[LENSOPT__ROWS][LENSOPT__VECTORS]; /* residuals' slopes that are not yet in the sums */
    double residual[LENSOPT__ROWS];
    int32_t rows_full;
    double m00[LENSOPT_MAX_VARIABLES], m01[LENSOPT_MAX_VARIABLES], a00[LENSOPT_MAX_VARIABLES], s01[LENSOPT_MAX_VARIABLES]; /* slopes of a ghost's */
    double direct_a00[LENSOPT_MAX_VARIABLES], direct_a01[LENSOPT_MAX_VARIABLES], direct_m01[LENSOPT_MAX_VARIABLES];
    int32_t by_size[LENSOPT__MOST_PAIRS];           /* THESIS: those that are there */
    double paid[LENSOPT_MAX_GHOSTS];                /* what goals cost as they are assigned */
    int32_t rows_made;
    double *jacobian, *residuals;                   /* NULL, or where rows are written, too, by variables as they are */
    int32_t held[LENSOPT_MAX_VARIABLES];
    void *memory;
    lensopt__vec *normal, *factor;                  /* behind this: a row of vectors a variable; a triangle of lanes */
    void *assignment;                               /* memory for that of goals to ghosts */
    double *constraint_slopes;                      /* a row each */
} lensopt__descent;

LENSOPT__INLINE void lensopt__load_lanes(lensopt__descent *w, int lanes)
{
    int l;
    for (l = 0; l < LENSOPT__LANES; l++) {
        const int from = l < lanes ? l : 0;
        if (l == from) lensopt__decode(w->p, w->x[l], &w->designs[l]);
        lensopt__lane(&w->batch, l, &w->designs[from]);
    }
}

/* Which pairs are ghosts; the same for all lanes, since polishing changes no order. */
static void lensopt__find_ghosts(lensopt__descent *w)
{
    int32_t g;
    for (g = w->count = 0; g < w->rows.pairs; g++)
        if (LENSOPT__LANE(w->rows.a00[g], 0) != 0) w->there[w->count++] = g;
}

/* Images are the right way round as they are. */
static void lensopt__right_way(lensopt__descent *w)
{
    int32_t k;
    for (k = 0; k < w->count; k++) w->sign[k] = LENSOPT__LANE(w->rows.m00[w->there[k]], 0) < 0 ? -1 : 1;
}

static void lensopt__spots_of_lane(lensopt__descent *w, int l)
{
    const lensopt_problem *p = w->p;
    double iris = LENSOPT__LANE(w->batch.iris, l), pupil = p->desc.pupil;
    int32_t k, light;
    for (k = 0; k < w->count; k++) {
        int32_t g = w->there[k];
        double size = fabs(LENSOPT__LANE(w->rows.m00[g], l)), inverse = 1 / LENSOPT__LANE(w->rows.a00[g], l), shrink = iris * fabs(inverse);
        double pupil_centre = LENSOPT__LANE(w->rows.m01[g], l), iris_centre = LENSOPT__LANE(w->rows.s01[g], l) * inverse;
        for (light = 0; light < p->lights; light++) {
            double *spot = w->spot[light][k], u = p->slopes[light];
            spot[0] = u * (pupil < shrink ? pupil_centre : iris_centre);
            spot[1] = (LENSOPT__LANE(w->rows.m00[g], l) < 0 ? -w->sign[k] : w->sign[k]) * size * (pupil < shrink ? pupil : shrink);
            spot[2] = size * (pupil + shrink) - u * fabs(pupil_centre - iris_centre);
        }
    }
}

/* -- what a pairing costs -- */

/* The images of a spot that is wanted have to overlap by a part of the smaller one's radius; one that is just hidden is as bad as one that is off by
   its radius. If less is asked for, searches find lenses all of whose spots are where they should be, and hidden by next to nothing. THESIS prices
   what is seen by its place and size alone. */
#define LENSOPT__OVERLAP 0.1

static double lensopt__unseen(const lensopt__descent *w, double radius, double overlap)
{
    double e = overlap / LENSOPT__OVERLAP - (w->p->desc.objective == LENSOPT_THESIS ? 0 : fabs(radius));
    return e < 0 ? e : 0;
}

static double lensopt__cost(const lensopt__descent *w, int32_t goal, int32_t k)
{
    const lensopt_problem *p = w->p;
    const lensopt_goal *goals = p->target.ghosts[p->ghost_of[goal]].goals;
    int32_t l;
    double sum = 0;
    for (l = 0; l < p->lights; l++) {
        const double *spot = w->spot[l][k];
        double dc = spot[0] - goals[l].centre, dr = spot[1] - goals[l].radius, unseen = lensopt__unseen(w, spot[1], spot[2]), e = 0;
        if (goals[l].wish == LENSOPT_SPOT) e = dc * dc + dr * dr + unseen * unseen;
        else if (goals[l].wish == LENSOPT_SPOT_HIDDEN) e = spot[2] > 0 ? spot[2] * spot[2] : 0;
        sum += p->weight[l][goal] * e;
    }
    return sum;
}

/* The root of what a ghost too many costs at one light. */
static double lensopt__too_many(const lensopt__descent *w, int32_t l, int32_t k)
{
    const lensopt_problem *p = w->p;
    const double *spot = w->spot[l][k];
    if (spot[2] < 0) return 0;
    if (p->desc.objective != LENSOPT_SEEN) return sqrt(p->surplus / fabs(spot[1]));
    return fabs(spot[0]) - fabs(spot[1]) > 50 * p->unit ? 0 : p->light_root[l] * p->surplus_root / (fabs(spot[1]) + p->unit);
}

static double lensopt__surplus(const lensopt__descent *w, int32_t k)
{
    int32_t l;
    double sum = 0;
    for (l = 0; l < w->p->lights; l++) sum += lensopt__too_many(w, l, k) * lensopt__too_many(w, l, k);
    return sum;
}

static double lensopt__total(const lensopt__descent *w, int l)
{
    double sum = lensopt__penalty(w->p, &w->designs[l]);
    int32_t g, k;
    for (g = 0; g < w->p->goals; g++) sum += w->mate[g] >= 0 ? lensopt__cost(w, g, w->mate[g]) : w->p->missing[g];
    for (k = 0; k < w->count; k++)
        if (w->goal_of[k] < 0) sum += lensopt__surplus(w, k);
    return sum;
}

static double lensopt__size(const lensopt__descent *w, int32_t k) { return w->spot[0][k][2] < 0 ? HUGE_VAL : fabs(w->spot[0][k][1]); }

/* As the thesis pairs: by rank of size, what is hidden last. The order is that of the last time, sorted anew. 1 if it has changed. */
static int lensopt__pair_by_rank(lensopt__descent *w)
{
    int32_t g, i, k, changed = 0;
    for (k = 1; k < w->count; k++) {
        int32_t ghost = w->by_size[k];
        double size = lensopt__size(w, ghost);
        for (i = k; i > 0 && lensopt__size(w, w->by_size[i - 1]) > size; i--) w->by_size[i] = w->by_size[i - 1];
        w->by_size[i] = ghost;
        changed |= i != k;
    }
    for (k = 0; k < w->count; k++) w->goal_of[k] = -1;
    for (g = 0; g < w->p->goals; g++) {
        w->mate[w->p->goal_at[g]] = g < w->count ? w->by_size[g] : -1;
        if (g < w->count) w->goal_of[w->by_size[g]] = w->p->goal_at[g];
    }
    return changed;
}

/* A ghost that is given to a goal is not too many. */
static void lensopt__assign_least(lensopt__descent *w)
{
    lensopt__assignment a;
    int32_t g, k;
    lensopt__assignment_in(w->assignment, w->p->goals, w->count, &a);
    for (k = 0; k < w->count; k++) {
        double surplus = fmin(lensopt__surplus(w, k), 1e12); /* a point costs HUGE_VAL; the digits of what goals cost are to stay */
        for (g = 0; g < a.rows; g++) a.cost[g * a.stride + k] = lensopt__cost(w, g, k) - surplus;
    }
    memcpy(a.none, w->p->missing, sizeof *a.none * (size_t)a.rows);
    lensopt__assignment_solve(&a);
    memcpy(w->mate, a.column_of, sizeof *w->mate * (size_t)a.rows);
    memcpy(w->goal_of, a.row_of, sizeof *w->goal_of * (size_t)a.columns);
}

/* The thesis' pairs. Where lenses of these very spots are known their ranks say less than what lies nearest. */
static int lensopt__goes_by_rank(const lensopt__descent *w) { return w->p->desc.objective == LENSOPT_THESIS && !w->p->mirrors.usable; }

static void lensopt__assign(lensopt__descent *w)
{
    int32_t k;
    if (!lensopt__goes_by_rank(w)) {
        lensopt__assign_least(w);
        return;
    }
    for (k = 0; k < w->count; k++) w->by_size[k] = k;
    lensopt__pair_by_rank(w);
}

/* Between steps little changes: exchanges of two goals' ghosts, and of a ghost too many, as long as they help. */
static int lensopt__reassign(lensopt__descent *w)
{
    int32_t g, h, k, changed = 0;
    if (lensopt__goes_by_rank(w)) return lensopt__pair_by_rank(w);
    for (g = 0; g < w->p->goals; g++) {
        int32_t mine = w->mate[g];
        double now;
        if (mine < 0) continue;
        now = w->paid[g] = lensopt__cost(w, g, mine);
        for (h = 0; h < g; h++) {
            int32_t other = w->mate[h];
            double a, b;
            if (other < 0) continue;
            a = lensopt__cost(w, g, other);
            if (!(a < now + w->paid[h])) continue;
            b = lensopt__cost(w, h, mine);
            if (!(a + b < now + w->paid[h])) continue;
            w->mate[g] = other;
            w->mate[h] = mine;
            w->goal_of[other] = g;
            w->goal_of[mine] = h;
            now = w->paid[g] = a;
            w->paid[h] = b;
            mine = other;
            changed = 1;
        }
        for (k = 0; k < w->count && w->count > w->p->goals; k++)
            if (w->goal_of[k] < 0 && lensopt__cost(w, g, k) + lensopt__surplus(w, mine) < now + lensopt__surplus(w, k)) {
                w->goal_of[mine] = -1;
                w->goal_of[k] = g;
                w->mate[g] = mine = k;
                now = w->paid[g] = lensopt__cost(w, g, k);
                changed = 1;
            }
    }
    return changed;
}

/* -- normal equations -- */

/* Some rows at a time, so that the sums are read and written less often. */
LENSOPT__INLINE void lensopt__add_rows_lanes(lensopt__descent *w)
{
    const lensopt__vec *r0 = w->row[0], *r1 = w->row[1], *r2 = w->row[2], *r3 = w->row[3];
    int32_t i, k;
    for (k = 0; k < w->vectors; k++) w->gradient[k] += w->residual[0] * r0[k] + w->residual[1] * r1[k] + w->residual[2] * r2[k] + w->residual[3] * r3[k];
    for (i = 0; i < w->p->variables; i++) {
        const double a0 = LENSOPT__LANE(r0[0], i), a1 = LENSOPT__LANE(r1[0], i), a2 = LENSOPT__LANE(r2[0], i), a3 = LENSOPT__LANE(r3[0], i);
        lensopt__vec *to = w->normal + i * w->vectors;
        for (k = 0; k <= i / LENSOPT__LANES; k++) to[k] += a0 * r0[k] + a1 * r1[k] + a2 * r2[k] + a3 * r3[k];
    }
}

static void lensopt__add_rows_plain(lensopt__descent *w) { lensopt__add_rows_lanes(w); }
#if defined(LENSOPT__WIDE)
LENSOPT__WIDE static void lensopt__add_rows_wide(lensopt__descent *w) { lensopt__add_rows_lanes(w); }
#endif

static void lensopt__flush_rows(lensopt__descent *w)
{
    int32_t i;
    if (w->rows_full > 0) LENSOPT__KERNEL(lensopt__add_rows)(w);
    for (i = 0; i < LENSOPT__ROWS; i++) memset(w->row[i], 0, sizeof(lensopt__vec) * (size_t)w->vectors);
    memset(w->residual, 0, sizeof w->residual);
    w->rows_full = 0;
}

/* Where the next residual's slopes are written. */
static double *lensopt__next_row(lensopt__descent *w) { return &LENSOPT__LANE(w->row[w->rows_full][0], 0); }

/* One residual, whose slopes are in the next row, joins the sums. */
static void lensopt__add_row(lensopt__descent *w, double residual)
{
    const double *row = lensopt__next_row(w);
    int32_t i, n = w->p->variables;
    if (w->jacobian != NULL) {
        for (i = 0; i < n; i++) w->jacobian[w->rows_made * n + i] = w->hi[i] > w->lo[i] ? row[i] / (w->hi[i] - w->lo[i]) : 0;
        w->residuals[w->rows_made] = residual;
    }
    w->rows_made++;
    w->residual[w->rows_full++] = residual;
    if (w->rows_full == LENSOPT__ROWS) lensopt__flush_rows(w);
}

/* Slopes by the variables, each in units of its range. */
static void lensopt__by_variables(const lensopt__descent *w, const lensopt__slope *s, int32_t i, int32_t j, double *numbers, double *out)
{
    int32_t v;
    lensopt__chain(&w->trace, s, i, j, numbers);
    for (v = 0; v < w->p->variables; v++) out[v] = numbers[w->p->number_at[v]] * (w->hi[v] - w->lo[v]);
}

static void lensopt__ghost_by_variables(lensopt__descent *w, int32_t i, int32_t j, double m00, double m01)
{
    const lensopt__trace *t = &w->trace;
    int32_t v, n = w->p->variables;
    lensopt__ghost_slopes(t, i, j, 0, &w->slopes[0], &w->slopes[1]);
    lensopt__by_variables(w, &w->slopes[0], i, j, w->numbers, w->m00);
    lensopt__by_variables(w, &w->slopes[1], i, j, w->numbers, w->m01);
    if (j <= t->stop) {
        lensopt__ghost_slopes(t, i, j, 1, &w->slopes[0], &w->slopes[1]);
        lensopt__by_variables(w, &w->slopes[0], i, j, w->numbers, w->a00);
        memcpy(w->s01, w->direct_m01, sizeof w->s01[0] * (size_t)n);
        return;
    }
    memcpy(w->a00, w->direct_a00, sizeof w->a00[0] * (size_t)n);
    for (v = 0; v < n; v++) w->s01[v] = w->m01[v] * t->a00 + m01 * w->direct_a00[v] - w->m00[v] * t->a01 - m00 * w->direct_a01[v];
}

static void lensopt__direct_by_variables(lensopt__descent *w)
{
    lensopt__direct_slopes(&w->trace, 0, 1, &w->slopes[0], &w->slopes[1]);
    lensopt__by_variables(w, &w->slopes[0], -1, -1, w->numbers, w->direct_a00);
    lensopt__by_variables(w, &w->slopes[1], -1, -1, w->numbers, w->direct_a01);
    lensopt__direct_slopes(&w->trace, 1, 0, &w->slopes[0], &w->slopes[1]);
    lensopt__by_variables(w, &w->slopes[1], -1, -1, w->numbers, w->direct_m01);
}

static void lensopt__add_partials(lensopt__descent *w, const double *by, double scale, double residual)
{
    double *row = lensopt__next_row(w);
    int32_t v, iris = w->p->iris_of;
    for (v = 0; v < w->p->variables; v++) row[v] = scale * (by[0] * w->m00[v] + by[1] * w->m01[v] + by[2] * w->a00[v] + by[3] * w->s01[v]);
    if (iris >= 0) row[iris] += scale * by[4] * (w->hi[iris] - w->lo[iris]);
    lensopt__add_row(w, residual);
}

/* Residuals of ghost k: those of its goal, or the cost of being too many. */
static void lensopt__add_ghost(lensopt__descent *w, int32_t k, double m00, double m01, double a00, double s01)
{
    const lensopt_problem *p = w->p;
    int32_t g = w->goal_of[k], l, i;
    lensopt__image image;
    for (l = 0; l < p->lights; l++) {
        const lensopt_goal *goal = g >= 0 ? &p->target.ghosts[p->ghost_of[g]].goals[l] : NULL;
        double root = g >= 0 ? sqrt(p->weight[l][g]) : 0;
        lensopt__image_of(m00, m01, a00, s01, w->trace.iris, p->desc.pupil, p->slopes[l], &image);
        if (g < 0) {
            double e = lensopt__too_many(w, l, k);
            if (e > 0) lensopt__add_partials(w, image.by_radius, p->desc.objective == LENSOPT_SEEN ? -e / (image.radius + p->unit) : -0.5 * e / image.radius, e);
        } else if (goal->wish == LENSOPT_SPOT && root > 0) {
            double way = m00 < 0 ? -w->sign[k] : w->sign[k], unseen = lensopt__unseen(w, image.radius, image.overlap);
            lensopt__add_partials(w, image.by_centre, root, root * (image.centre - goal->centre));
            lensopt__add_partials(w, image.by_radius, way * root, root * (way * image.radius - goal->radius));
            if (unseen < 0) {
                for (i = 0; i < 5; i++) image.by_overlap[i] = image.by_overlap[i] / LENSOPT__OVERLAP - (p->desc.objective == LENSOPT_THESIS ? 0 : image.by_radius[i]);
                lensopt__add_partials(w, image.by_overlap, root, root * unseen);
            }
        } else if (goal->wish == LENSOPT_SPOT_HIDDEN && root > 0 && image.overlap > 0) {
            lensopt__add_partials(w, image.by_overlap, root, root * image.overlap);
        }
    }
}

/* Their slopes are differences: they cost little, next to those of ghosts. */
static void lensopt__add_constraints(lensopt__descent *w, int l)
{
    double at[LENSOPT__CONSTRAINTS], kept;
    int32_t v, i, count = lensopt__constraints(w->p, &w->designs[l], at), n = w->p->variables;
    lensopt__design d;
    for (v = 0; v < n; v++) {
        double h = 1e-6 * (w->hi[v] - w->lo[v]), low[LENSOPT__CONSTRAINTS], high[LENSOPT__CONSTRAINTS], a, b;
        kept = w->x[l][v];
        a = lensopt__clamped(kept - h, w->lo[v], w->hi[v]);
        b = lensopt__clamped(kept + h, w->lo[v], w->hi[v]);
        w->x[l][v] = a;
        lensopt__decode(w->p, w->x[l], &d);
        lensopt__constraints(w->p, &d, low);
        w->x[l][v] = b;
        lensopt__decode(w->p, w->x[l], &d);
        lensopt__constraints(w->p, &d, high);
        w->x[l][v] = kept;
        for (i = 0; i < count; i++) w->constraint_slopes[i * n + v] = b > a ? (high[i] - low[i]) / (b - a) * (w->hi[v] - w->lo[v]) : 0;
    }
    for (i = 0; i < count; i++) {
        if (at[i] == 0) continue;
        memcpy(lensopt__next_row(w), w->constraint_slopes + i * n, sizeof(double) * (size_t)n);
        lensopt__add_row(w, at[i]);
    }
}

/* Reflecting surfaces of pair g, in the order of lensopt__all_rows. */
static void lensopt__pair_at(const lensopt__trace *t, int32_t g, int32_t *i, int32_t *j)
{
    int32_t from = 0, to = t->stop;
    if (g >= lensopt__pairs_of(t->stop + 1)) {
        g -= lensopt__pairs_of(t->stop + 1);
        from = t->stop + 1;
        to = t->surfaces - 1;
    }
    for (*i = from; g >= to - *i; (*i)++) g -= to - *i;
    *j = *i + 1 + g;
}

/* At the candidate in lane l, whose spots are up to date. */
static void lensopt__normal_equations(lensopt__descent *w, int l)
{
    int32_t k, i, j;
    memset(w->normal, 0, sizeof *w->normal * (size_t)(w->vectors * w->p->variables));
    memset(w->gradient, 0, sizeof(lensopt__vec) * (size_t)w->vectors);
    w->rows_made = w->rows_full = 0;
    lensopt__flush_rows(w);
    lensopt__trace_of(w->p, &w->batch, l, &w->designs[l], &w->trace);
    lensopt__direct_by_variables(w);
    for (k = 0; k < w->count; k++) {
        int32_t g = w->there[k];
        double m00 = LENSOPT__LANE(w->rows.m00[g], l), m01 = LENSOPT__LANE(w->rows.m01[g], l);
        lensopt__pair_at(&w->trace, g, &i, &j);
        lensopt__ghost_by_variables(w, i, j, m00, m01);
        lensopt__add_ghost(w, k, m00, m01, LENSOPT__LANE(w->rows.a00[g], l), LENSOPT__LANE(w->rows.s01[g], l));
    }
    if (w->p->constrained) lensopt__add_constraints(w, l);
    lensopt__flush_rows(w);
}

/* -- steps -- */

/* Within which a variable may move while order and stop gap stay; nothing moves where both are equal. */
static void lensopt__polish_bounds(lensopt__descent *w, const double *x)
{
    const lensopt_problem *p = w->p;
    int32_t v, stop = lensopt__stop_of(p, x);
    for (v = 0; v < p->variables; v++) {
        int32_t row = p->variable[v].row, air = row >= 0 && lensopt__is_air(p, x, row);
        const lensopt_range *gap = row >= 0 ? air ? &p->limits[row].air_gap : &p->limits[row].glass_gap : NULL;
        w->lo[v] = p->lower[v];
        w->hi[v] = p->upper[v];
        w->x[0][v] = x[v];
        if (p->variable[v].kind == LENSOPT__INDEX && (air || p->glasses > 0)) {
            w->lo[v] = w->hi[v] = x[v];
        } else if (p->variable[v].kind == LENSOPT__INDEX) {
            w->lo[v] = p->limits[row].index.lo;
        } else if (p->variable[v].kind == LENSOPT__GAP) {
            w->lo[v] = gap->lo;
            w->hi[v] = gap->hi;
        } else if (p->variable[v].kind == LENSOPT__PLACE) {
            w->lo[v] = stop;
            w->hi[v] = stop + 1 - 1e-9;
            if (stop >= 0) w->x[0][v] = stop + (x[v] - floor(x[v]));
        }
        w->x[0][v] = lensopt__clamped(w->x[0][v], w->lo[v], w->hi[v]);
    }
}

/* Variables that stand at an end which they would leave. */
static void lensopt__hold_at_ends(lensopt__descent *w, const double *x)
{
    int32_t i;
    for (i = 0; i < w->p->variables; i++) {
        double g = LENSOPT__LANE(w->gradient[0], i);
        w->held[i] = w->hi[i] == w->lo[i] || (x[i] <= w->lo[i] && g > 0) || (x[i] >= w->hi[i] && g < 0);
    }
}

/* Each lane's step = -(normal + damping * its diagonal)^-1 gradient, by Cholesky; held variables stay. Where rounding leaves no factor the
   step is one of many, and is tried like any. */
LENSOPT__INLINE void lensopt__solve_lanes(lensopt__descent *w, const lensopt__vec *damping)
{
    const lensopt__vec none = {0};
    const int32_t n = w->p->variables;
    lensopt__vec least = none, *fi = w->factor;
    int32_t i, j, k;
    for (i = 0; i < n; i++) least += LENSOPT__LANE(w->normal[i * w->vectors], i);
    least = least * 1e-9 / n * *damping + 1e-290;
    for (i = 0; i < n; fi += ++i) {
        const lensopt__vec *fj = w->factor;
        const double *normal = &LENSOPT__LANE(w->normal[i * w->vectors], 0);
        lensopt__vec sum = none - LENSOPT__LANE(w->gradient[0], i), d;
        for (j = 0; j < i; fj += ++j) {
            lensopt__vec s = none + normal[j];
            if (w->held[i] || w->held[j]) s = none;
            else for (k = 0; k < j; k++) s -= fi[k] * fj[k];
            fi[j] = s * fj[j];
            sum -= fi[j] * w->step[j];
        }
        d = normal[i] * (1 + *damping) + least;
        for (k = 0; k < i; k++) d -= fi[k] * fi[k];
        for (k = 0; k < LENSOPT__LANES; k++) LENSOPT__LANE(d, k) = w->held[i] || !(LENSOPT__LANE(d, k) > 0) ? 0 : 1 / sqrt(LENSOPT__LANE(d, k));
        fi[i] = d; /* one over it */
        w->step[i] = sum * d;
    }
    for (i = n - 1; i >= 0; i--) {
        fi -= i + 1;
        w->step[i] *= fi[i];
        for (k = 0; k < i; k++) w->step[k] -= fi[k] * w->step[i];
    }
}

static void lensopt__solve_plain(lensopt__descent *w, const lensopt__vec *damping) { lensopt__solve_lanes(w, damping); }
#if defined(LENSOPT__WIDE)
LENSOPT__WIDE static void lensopt__solve_wide(lensopt__descent *w, const lensopt__vec *damping) { lensopt__solve_lanes(w, damping); }
#endif

/* More and less damped steps from x; the best one's lane, or -1 where none is better than *sum, the least sum. */
static int lensopt__try(lensopt__descent *w, const double *x, double lambda, double *sum, double *best_lambda)
{
    enum { TRIES = 4 };
    static const double factors[TRIES] = {0.03, 1, 30, 1000};
    lensopt__vec damping;
    int first, l, best = -1;
    int32_t v;
    for (first = 0; first < TRIES; first += LENSOPT__LANES) {
        for (l = 0; l < LENSOPT__LANES; l++) LENSOPT__LANE(damping, l) = lambda * factors[first + l];
        LENSOPT__KERNEL(lensopt__solve)(w, &damping);
        for (l = 0; l < LENSOPT__LANES; l++)
            for (v = 0; v < w->p->variables; v++) w->x[l][v] = lensopt__clamped(x[v] + (w->hi[v] - w->lo[v]) * LENSOPT__LANE(w->step[v], l), w->lo[v], w->hi[v]);
        lensopt__load_lanes(w, LENSOPT__LANES);
        LENSOPT__KERNEL(lensopt__rows)(&w->batch, &w->rows);
        for (l = 0; l < LENSOPT__LANES; l++) {
            double total;
            lensopt__spots_of_lane(w, l);
            total = lensopt__total(w, l);
            if (!(total < *sum)) continue;
            *sum = total;
            *best_lambda = LENSOPT__LANE(damping, l);
            best = l;
            if (LENSOPT__LANES < TRIES) memcpy(w->kept, w->x[l], sizeof w->kept);
        }
    }
    if (best >= 0 && LENSOPT__LANES < TRIES) { /* a later try has taken its place */
        memcpy(w->x[0], w->kept, sizeof w->kept);
        lensopt__load_lanes(w, 1);
        LENSOPT__KERNEL(lensopt__rows)(&w->batch, &w->rows);
    }
    return best;
}

static lensopt__descent *lensopt__descent_create(const lensopt_problem *p, size_t *size)
{
    int32_t vectors = (p->variables + LENSOPT__LANES - 1) / LENSOPT__LANES;
    lensopt__descent *w;
    char *memory;
    *size = sizeof *w + sizeof(lensopt__vec) * (size_t)(vectors * p->variables + p->variables * (p->variables + 1) / 2) + 64 +
            sizeof(double) * (size_t)(p->constrained ? LENSOPT__CONSTRAINTS * p->variables : 0) + lensopt__assignment_size(p->goals, lensopt__pairs_of(p->surfaces));
    memory = (char *)p->desc.allocate(p->desc.allocate_user, NULL, 0, *size);
    if (memory == NULL) return NULL;
    w = (lensopt__descent *)(void *)(memory + 32 - ((uintptr_t)memory & 31));
    w->memory = memory;
    w->p = p;
    w->vectors = vectors;
    w->normal = (lensopt__vec *)(void *)(((uintptr_t)(w + 1) + 31) & ~(uintptr_t)31);
    w->factor = w->normal + vectors * p->variables;
    w->constraint_slopes = (double *)(void *)(w->factor + p->variables * (p->variables + 1) / 2);
    w->assignment = w->constraint_slopes + (p->constrained ? LENSOPT__CONSTRAINTS * p->variables : 0);
    w->jacobian = w->residuals = NULL;
    return w;
}

/* A point's spots and their assignment; its sum. */
static double lensopt__place_at(lensopt__descent *w, const double *x)
{
    lensopt__polish_bounds(w, x);
    lensopt__load_lanes(w, 1);
    LENSOPT__KERNEL(lensopt__rows)(&w->batch, &w->rows);
    lensopt__find_ghosts(w);
    lensopt__right_way(w);
    lensopt__spots_of_lane(w, 0);
    lensopt__assign(w);
    return lensopt__total(w, 0);
}

/* Images that have passed through a point are the right way round now. 1 if one had. */
static int lensopt__turn(lensopt__descent *w)
{
    int32_t k, l, turned = 0;
    for (k = 0; k < w->count; k++) {
        if (!(w->spot[0][k][1] < 0)) continue;
        w->sign[k] = -w->sign[k];
        for (l = 0; l < w->p->lights; l++) w->spot[l][k][1] = -w->spot[l][k][1];
        turned = 1;
    }
    return turned;
}

/* Steps downhill from x, which lane 0 holds, from `sum`; returns the sum there. */
static double lensopt__steps(lensopt__descent *w, double *x, double sum, int32_t steps, int32_t *done)
{
    const size_t size = sizeof *x * (size_t)w->p->variables;
    double before, lambda = 1e-2;
    int32_t stalled = 0, l = 0;
    for (; steps > 0 && stalled < 3 && sum > 1e-26 && lambda < 1e9; steps--, (*done)++) {
        if (l >= 0) {
            lensopt__normal_equations(w, l);
            lensopt__hold_at_ends(w, x);
        }
        before = sum;
        l = lensopt__try(w, x, lambda, &sum, &lambda);
        if (l < 0) {
            lambda *= 1e4;
            continue;
        }
        memcpy(x, w->x[l], size);
        lambda = fmax(lambda, 1e-12);
        lensopt__spots_of_lane(w, l);
        if (lensopt__turn(w) + lensopt__reassign(w) > 0) sum = lensopt__total(w, l);
        stalled = sum > 0.999 * before ? stalled + 1 : 0;
    }
    return sum;
}

/* Goes downhill from x, to whose sum of squares; *done: steps. */
static double lensopt__descend(lensopt__descent *w, double *x, int32_t steps, int32_t *done)
{
    double sum = lensopt__place_at(w, x);
    *done = 0;
    if (!(sum < HUGE_VAL) || (w->p->desc.objective == LENSOPT_THESIS && w->count < w->p->goals)) return HUGE_VAL;
    memcpy(x, w->x[0], sizeof *x * (size_t)w->p->variables);
    sum = lensopt__steps(w, x, sum, steps, done);
    return *done > 0 ? lensopt__place_at(w, x) : sum; /* another assignment may be better yet */
}

/* -- as a function -- */

static void lensopt__lens_evaluate(void *user, const double *x, int32_t count, double *f)
{
    const lensopt_problem *p = (const lensopt_problem *)user;
    lensopt__design d;
    lensopt__descent *w;
    size_t size;
    int32_t i;
    if (p->desc.objective == LENSOPT_THESIS) {
        lensopt__thesis(p, x, count, f);
        for (i = 0; i < count && p->constrained; i++) {
            lensopt__decode(p, x + i * p->variables, &d);
            f[i] += lensopt__penalty(p, &d);
        }
        return;
    }
    w = lensopt__descent_create(p, &size);
    for (i = 0; i < count; i++) f[i] = w != NULL ? lensopt__place_at(w, x + i * p->variables) : HUGE_VAL;
    if (w != NULL) p->desc.allocate(p->desc.allocate_user, w->memory, size, 0);
}

static int32_t lensopt__lens_polish(void *user, double *x, double *f, int32_t steps)
{
    const lensopt_problem *p = (const lensopt_problem *)user;
    double moved[LENSOPT_MAX_VARIABLES], value;
    size_t size;
    int32_t done, evaluated = 0;
    lensopt__descent *w = lensopt__descent_create(p, &size);
    if (w == NULL) return 0;
    if (p->desc.objective == LENSOPT_THESIS && *f == HUGE_VAL) { /* its pairs change for the worse, too, and so may the sum */
        lensopt__lens_evaluate(user, x, 1, f);
        evaluated = 1;
    }
    memcpy(moved, x, sizeof *x * (size_t)p->variables);
    value = lensopt__descend(w, moved, steps, &done);
    p->desc.allocate(p->desc.allocate_user, w->memory, size, 0);
    if (p->desc.objective == LENSOPT_THESIS && value < HUGE_VAL) lensopt__lens_evaluate(user, moved, 1, &value);
    if (value < *f) {
        *f = value;
        memcpy(x, moved, sizeof *x * (size_t)p->variables);
    }
    return 1 + evaluated + done * (LENSOPT__LANES + 4);
}

/* Which gaps are air: never two in a row, so that every surface parts something, and that behind the last; and the stop's. Places of the stop that give just
   enough ghosts come up most often. */
static int32_t lensopt__sample_order(const lensopt_problem *p, uint64_t *random, int32_t *air)
{
    int32_t n = p->surfaces, tries, i, k = 0, ok = 0;
    for (tries = 0; tries < 1000 && !ok; tries++) {
        int32_t more;
        k = (int32_t)(lensopt_random(random) * n);
        more = lensopt__pairs_at(n, k) - p->goals;
        ok = more >= 0 && lensopt_random(random) * (1 + more) < 1 && k != 0 && k != n - 2;
    }
    for (tries = 0, ok = 0; tries < 1000 && !ok; tries++) {
        for (i = 0; i < n; i++) air[i] = i + 1 == n || (lensopt_random(random) < 0.4 && i > 0);
        air[k] = 1;
        for (i = 0, ok = 1; i + 1 < n; i++) ok = ok && !(air[i] && air[i + 1]);
    }
    return k;
}

static double lensopt__sample_number(const lensopt_problem *p, int32_t v, const int32_t *air, int32_t stop, uint64_t *random)
{
    double r = lensopt_random(random), q = lensopt_random(random), lo = p->lower[v], hi = p->upper[v];
    int32_t row = p->variable[v].row;
    const lensopt__limits *l = row >= 0 ? &p->limits[row] : NULL;
    switch (p->variable[v].kind) {
    case LENSOPT__PLACE: return lensopt__clamped(stop + r, lo, hi);
    case LENSOPT__IRIS: return lo * pow(hi / lo, r);
    case LENSOPT__CURVATURE: return lensopt__clamped((q < 0.5 ? -0.125 : 0.125) * pow(100, -r), lo, hi); /* 8 to 800 mm */
    case LENSOPT__GAP:
        if (row + 1 == p->surfaces) return lensopt__clamped(20 + 80 * r, lo, hi);
        return air[row] ? lensopt__clamped(0.2 + 15 * r * q, l->air_gap.lo, l->air_gap.hi) : lensopt__clamped(1 + 9 * r, l->glass_gap.lo, l->glass_gap.hi);
    default:
        if (!(air[row] && l->may_air) && p->glasses > 0) return lensopt__clamped(p->glass[(int32_t)(r * p->glasses)].n, l->index.lo, l->index.hi);
        return air[row] && l->may_air ? lo : l->index.lo + (l->index.hi - l->index.lo) * 0.8 * r;
    }
}

/* The best of a few lenses that are read from the spots: one may not be read for what bounds it, and not all are what is asked for. 0: there is none. */
static int lensopt__sample_read(lensopt_problem *p, uint64_t *random, double *x)
{
    enum { LENSES = 6 };
    double one[LENSOPT_MAX_VARIABLES], f, best = HUGE_VAL;
    lensopt__design d;
    int32_t k, found = 0, left = 200000; /* 10 to 20 ms */
    for (k = 0; k < LENSES && best > 1e-15 && lensopt__build_lens(p, random, &left, &d); k++) {
        lensopt__encode(p, &d, one);
        lensopt__lens_evaluate(p, one, 1, &f);
        if (found && !(f < best)) continue;
        found = 1;
        best = f;
        memcpy(x, one, sizeof *x * (size_t)p->variables);
    }
    return found;
}

/* As lenses are: most radii are short, air gaps short but for the last. */
static void lensopt__lens_sample(void *user, uint64_t *random, double *x)
{
    lensopt_problem *p = (lensopt_problem *)user;
    int32_t air[LENSOPT_MAX_SEARCHED], v, stop = lensopt__sample_order(p, random, air);
    if (p->mirrors.usable && lensopt_random(random) < 0.5 && lensopt__sample_read(p, random, x)) return;
    for (v = 0; v < p->surfaces; v++) air[v] = p->limits[v].may_air && (air[v] || !p->limits[v].may_glass);
    for (v = 0; v < p->variables; v++) x[v] = lensopt__sample_number(p, v, air, stop, random);
}

LENSOPT_API void lensopt_problem_function(lensopt_problem *p, lensopt_function *out)
{
    memset(out, 0, sizeof *out);
    out->variables = p->variables;
    out->lower = p->lower;
    out->upper = p->upper;
    out->blocks = p->blocks;
    out->user = p;
    out->evaluate = lensopt__lens_evaluate;
    out->sample = lensopt__lens_sample;
    out->polish = lensopt__lens_polish;
}
/* >> 11 lenses */
/* Problems out of descriptors, and lenses out of points. */

/* -- creation -- */

static int lensopt__default_range(lensopt_range *r, double lo, double hi, double least, double most)
{
    if (r->lo == 0 && r->hi == 0) {
        r->lo = lo;
        r->hi = hi;
    }
    return lensopt__within(r->lo, least, most) && lensopt__within(r->hi, r->lo, most);
}

static lflare_result lensopt__check_ranges(lensopt_problem_desc *d, lflare_error *error)
{
    const struct { lensopt_range *range; double lo, hi, least, most; const char *name; } table[] = {
        {&d->glass_gap, 1, 15, 0, 1e4, "glass_gap"},     {&d->air_gap, 0.1, 100, 0, 1e4, "air_gap"},
        {&d->index, 1.5, 2, 1.01, 10, "index"},          {&d->stop_radius, 0.1, 20, 1e-6, 1e4, "stop_radius"},
        {&d->efl, 0, 0, 0, 1e6, "efl"},                  {&d->back_focus, 0, 0, 0, 1e6, "back_focus"},
        {&d->fnumber, 0, 0, 0, 1e6, "fnumber"},          {&d->length, 0, 0, 0, 1e6, "length"}};
    size_t i;
    for (i = 0; i < sizeof table / sizeof table[0]; i++)
        if (!lensopt__default_range(table[i].range, table[i].lo, table[i].hi, table[i].least, table[i].most))
            return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "%s: lo <= hi within %g and %g were expected", table[i].name, table[i].least, table[i].most);
    if (d->pupil == 0) d->pupil = 100;
    if (d->least_radius == 0) d->least_radius = 5;
    if (!lensopt__within(d->pupil, 1e-3, 1e6)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "pupil: a radius from 0.001 mm was expected");
    if (!lensopt__within(d->least_radius, 1e-3, 1e6)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "least_radius: a radius from 0.001 mm was expected");
    if (!lensopt__within(d->focus, 0, 1e6) || !lensopt__within(d->glass_edge, 0, 1e4) || !lensopt__within(d->air_edge, 0, 1e4) || !lensopt__within(d->iris, 0, 1e4))
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "focus, glass_edge, air_edge, iris: lengths in mm were expected, 0 where any will do");
    if ((int)d->objective < LENSOPT_SEEN || (int)d->objective > LENSOPT_THESIS) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "objective: one of lensopt_objective was expected");
    if (d->surfaces != 0 && (d->surfaces < 2 || d->surfaces > LENSOPT_MAX_SEARCHED)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "surfaces: 2 to 64 were expected, or 0");
    return LFLARE_OK;
}

/* Van Acoleyen 2025, eq. 5.5, whose n counts the stop, too. 0: not even 64 surfaces have so many ghosts. */
static int32_t lensopt__surfaces_for(int32_t ghosts)
{
    int32_t n;
    for (n = 3; n <= LENSOPT_MAX_SEARCHED; n++)
        if (lensopt__pairs_of(n / 2) + lensopt__pairs_of(n - n / 2) >= ghosts) return n;
    return 0;
}

static void lensopt__base_abbe(lensopt_problem *p)
{
    int32_t i;
    for (i = 0; i < p->fixed.surfaces; i++) {
        const lflare_medium *m = &p->base.surfaces[lensopt__row(&p->base, i)].medium;
        double spread = lflare_index(m, 486.1327) - lflare_index(m, 656.2725);
        p->abbe[i] = spread > 0 ? lensopt__clamped((lflare_index(m, 587.5618) - 1) / spread, 10, 200) : 0;
    }
}

/* Into the list, by index, behind those that have the same. */
static void lensopt__list_glass(lensopt_problem *p, const lflare_medium *m)
{
    double n = lflare_index(m, lensopt__nm[1]);
    int32_t i;
    for (i = p->glasses; i > 0 && p->glass[i - 1].n > n; i--) p->glass[i] = p->glass[i - 1];
    p->glass[i].n = n;
    p->glass[i].nd = lflare_index(m, 587.5618);
    p->glass[i].medium = *m;
    p->glasses++;
}

/* The glasses within the range, and the base's own; the range then is theirs, a little wider, lest a single one leaves no room. */
static lflare_result lensopt__list_glasses(lensopt_problem *p, lensopt_range range, lflare_error *error)
{
    const lensopt_problem_desc *d = &p->desc;
    int32_t i, own;
    if (d->glasses == NULL || d->glass_count < 1 || d->glass_count > LENSOPT_MAX_GLASSES)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "glasses: 1 to %i were expected, not %i, or NULL and 0", LENSOPT_MAX_GLASSES, d->glass_count);
    for (i = 0; p->has_base && i < p->surfaces; i++) /* first, so that they are taken before others of the same index */
        if (p->fixed.n[i] != 1) lensopt__list_glass(p, &p->base.surfaces[lensopt__row(&p->base, i)].medium);
    own = p->glasses;
    for (i = 0; i < d->glass_count; i++) {
        double n = lflare_index(&d->glasses[i], lensopt__nm[1]), nd = lflare_index(&d->glasses[i], 587.5618);
        if (d->glasses[i].kind == LFLARE_MEDIUM_AIR || !lensopt__within(n, 1.01, 10) || !lensopt__within(nd, 1.01, 10))
            return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "glasses[%i]: an index within 1.01 and 10 was expected, not %g at 510 nm and %g at 587.6", i, n, nd);
        if (range.hi == 0 || lensopt__within(n, range.lo, range.hi)) lensopt__list_glass(p, &d->glasses[i]);
    }
    if (p->glasses == own) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "glasses: at least one was expected whose index at 510 nm lies within %g and %g", range.lo, range.hi);
    p->desc.index.lo = p->glass[0].n - 1e-3;
    p->desc.index.hi = p->glass[p->glasses - 1].n + 1e-3;
    p->desc.glasses = NULL; /* they are the caller's */
    return LFLARE_OK;
}

static lflare_result lensopt__problem_base(lensopt_problem *p, lflare_error *error)
{
    lflare_lens lens;
    lflare_result result = lflare_lens_derive(p->desc.base, &lens, error);
    if (result != LFLARE_OK) return result;
    if (lens.surface_count - 1 > LENSOPT_MAX_SEARCHED || lens.surface_count < 3)
        return lensopt__fail(error, LFLARE_ERROR_LIMIT, "base: a lens of 2 to 64 surfaces was expected, not %i", lens.surface_count - 1);
    if (p->desc.surfaces != 0 && p->desc.surfaces != lens.surface_count - 1)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "surfaces: 0 or the base's %i were expected, not %i", lens.surface_count - 1, p->desc.surfaces);
    p->has_base = 1;
    p->base = lens.prescription;
    lensopt__design_of(&p->base, &p->fixed);
    lensopt__base_abbe(p);
    p->base_opening = p->fixed.iris;
    if (p->desc.iris > 0) p->fixed.iris = p->desc.iris;
    p->surfaces = p->fixed.surfaces;
    return LFLARE_OK;
}

static lflare_result lensopt__problem_fill(lensopt_problem *p, const lensopt_problem_desc *desc, lflare_realloc allocate, lflare_error *error)
{
    lflare_result result = lensopt_target_check(desc->target, error);
    if (result != LFLARE_OK) return result;
    p->desc = *desc;
    p->desc.allocate = allocate;
    p->target = *desc->target;
    result = lensopt__check_ranges(&p->desc, error);
    if (result == LFLARE_OK) result = lensopt__goals(p, error);
    if (result == LFLARE_OK && desc->base != NULL) result = lensopt__problem_base(p, error);
    if (result != LFLARE_OK) return result;
    if (!lensopt__find_mirrors(p, desc->base != NULL ? p->surfaces : desc->surfaces)) return lensopt__fail(error, LFLARE_ERROR_MEMORY, "no memory to compare the spots of %i ghosts with each other", p->goals);
    if (desc->base == NULL) {
        if (p->desc.keep_order) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "keep_order: a base was expected, whose order it is");
        if (p->desc.surfaces != 0) p->surfaces = p->desc.surfaces;
        else if (p->mirrors.usable) p->surfaces = p->mirrors.count[0] + p->mirrors.count[1] + p->mirrors.few;
        else p->surfaces = lensopt__surfaces_for(p->goals);
        if (p->surfaces == 0) return lensopt__fail(error, LFLARE_ERROR_LIMIT, "a target of at most 992 ghosts was expected, not %i: more than 64 surfaces have", p->goals);
        p->fixed.surfaces = p->surfaces;
        p->fixed.n[p->surfaces - 1] = 1;
    }
    if (desc->glasses != NULL || desc->glass_count != 0) result = lensopt__list_glasses(p, desc->index, error);
    if (result != LFLARE_OK) return result;
    p->constrained = lensopt__constrained(&p->desc);
    p->desc.target = &p->target;
    p->desc.base = desc->base != NULL ? &p->base : NULL;
    lensopt__variables(p);
    if (p->variables == 0) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "everything is locked: at least one number that may change was expected");
    p->mirrors.usable = p->mirrors.usable && (lensopt__read_in_front(&p->mirrors) > 0 || lensopt__may_lead(p)) && lensopt__is_built(p);
    return LFLARE_OK;
}

LENSOPT_API lflare_result lensopt_problem_create(const lensopt_problem_desc *desc, lensopt_problem **out, lflare_error *error)
{
    lflare_realloc allocate;
    lensopt_problem *p;
    lflare_result result;
    if (out != NULL) *out = NULL;
    if (desc == NULL || out == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a descriptor and room for a problem were expected, not NULL");
    allocate = desc->allocate != NULL ? desc->allocate : lensopt__libc_realloc;
    p = (lensopt_problem *)allocate(desc->allocate_user, NULL, 0, sizeof *p);
    if (p == NULL) return lensopt__fail(error, LFLARE_ERROR_MEMORY, "no memory for a problem");
    memset(p, 0, sizeof *p);
    result = lensopt__problem_fill(p, desc, allocate, error);
    if (result == LFLARE_OK) *out = p;
    else allocate(desc->allocate_user, p, sizeof *p, 0);
    return result;
}

LENSOPT_API void lensopt_problem_free(lensopt_problem *p)
{
    if (p != NULL) p->desc.allocate(p->desc.allocate_user, p, sizeof *p, 0);
}

LENSOPT_API int32_t lensopt_problem_reading(const lensopt_problem *p, int32_t *front, int32_t *behind, double *efl)
{
    if (p == NULL || front == NULL || behind == NULL || efl == NULL || !p->mirrors.usable) return 0;
    *front = lensopt__read_in_front(&p->mirrors);
    *behind = p->surfaces - *front;
    *efl = p->mirrors.chief / p->mirrors.slope;
    return 1;
}

/* -- points and lenses -- */

LENSOPT_API lflare_result lensopt_problem_point(const lensopt_problem *p, const lflare_prescription *prescription, double iris, double *x, lflare_error *error)
{
    lflare_lens lens;
    lensopt__design d;
    lflare_result result;
    if (p == NULL || prescription == NULL || x == NULL || !lensopt__within(iris, 0, 1e4))
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a problem, a prescription, an iris's radius or 0, and room for a point were expected");
    result = lflare_lens_derive(prescription, &lens, error);
    if (result != LFLARE_OK) return result;
    if (lens.surface_count - 1 != p->surfaces) return lensopt__fail(error, LFLARE_ERROR_LENS, "a lens of %i surfaces was expected, not %i", p->surfaces, lens.surface_count - 1);
    lensopt__design_of(&lens.prescription, &d);
    if (iris > 0) d.iris = iris;
    lensopt__encode(p, &d, x);
    return LFLARE_OK;
}

/* The glass of a gap, whose index is n at 510 nm. */
static void lensopt__glass_of(const lensopt_problem *p, int32_t i, double n, lflare_medium *out)
{
    if (p->glasses > 0) {
        *out = lensopt__nearest_glass(p, n)->medium;
        return;
    }
    memset(out, 0, sizeof *out);
    out->kind = LFLARE_MEDIUM_ABBE;
    out->c[0] = lensopt__nd(p, i, n);
    out->c[1] = lensopt__abbe(p, i, n);
}

/* Surface i of a candidate; the base's own where nothing of it has changed. */
static void lensopt__surface_of(const lensopt_problem *p, const lensopt__design *d, int32_t i, lflare_surface *out)
{
    const lflare_surface *was = p->has_base ? &p->base.surfaces[lensopt__row(&p->base, i)] : NULL;
    memset(out, 0, sizeof *out);
    if (was != NULL) *out = *was;
    out->line = 0;
    if (was == NULL || fabs(p->fixed.c[i] - d->c[i]) > 1e-12) {
        out->radius = fabs(d->c[i]) > 1e-9 ? 1 / d->c[i] : 0;
        out->conic = 0;
        memset(out->aspheric, 0, sizeof out->aspheric);
    }
    if (was == NULL || fabs(p->fixed.n[i] - d->n[i]) > 1e-9) {
        memset(&out->medium, 0, sizeof out->medium);
        if (d->n[i] != 1) lensopt__glass_of(p, i, d->n[i], &out->medium);
    }
    out->thickness = d->d[i];
}

/* How high light of the ghosts, and the direct light, meets each row of a lens; `reach` holds the direct one's on entry. */
static void lensopt__ghost_reach(const lensopt_problem *p, const lflare_lens *lens, double iris, double *reach)
{
    lflare_pair pairs[LENSOPT__MOST_PAIRS];
    lflare_crossing path[LFLARE_MAX_CIRCLES];
    int32_t count = LENSOPT__MOST_PAIRS, g, k, l, crossings, at;
    lflare_ghost_list(lens, pairs, &count);
    for (g = 0; g < count; g++) {
        crossings = LFLARE_MAX_CIRCLES;
        if (lflare_ghost_path(lens, lensopt__nm[1], pairs[g], path, &crossings) != LFLARE_OK) continue;
        for (at = 0; at < crossings && !path[at].iris; at++) {}
        for (l = 0; l < p->target.light_count && at < crossings; l++) {
            double u = p->slopes[l], a = path[at].a, lo = -p->desc.pupil, hi = p->desc.pupil;
            if (fabs(a) * p->desc.pupil > 1e-9) {
                lo = fmax(lo, -u * path[at].b / a - iris / fabs(a));
                hi = fmin(hi, -u * path[at].b / a + iris / fabs(a));
            }
            for (k = 0; k < crossings && lo < hi; k++)
                reach[path[k].surface] = fmax(reach[path[k].surface], fmax(fabs(path[k].a * lo + path[k].b * u), fabs(path[k].a * hi + path[k].b * u)));
        }
    }
}

/* Two surfaces end where they would come nearer to each other than the least edge, as far as they are so far apart in the middle. */
static void lensopt__trim_pair(lflare_surface *a, lflare_surface *b, double gap, double least)
{
    double lo = 0, hi = fmin(a->semi_diameter, b->semi_diameter);
    int32_t step;
    least = fmin(least, 0.999 * gap);
    if (gap + lflare_sag(b, hi) - lflare_sag(a, hi) >= least) return;
    for (step = 0; step < 60; step++) {
        double r = 0.5 * (lo + hi);
        if (gap + lflare_sag(b, r) - lflare_sag(a, r) >= least) lo = r;
        else hi = r;
    }
    if (!a->is_stop) a->semi_diameter = fmin(a->semi_diameter, fmax(lo, 0.1));
    if (!b->is_stop) b->semi_diameter = fmin(b->semi_diameter, fmax(lo, 0.1));
}

/* Surfaces end where they or their neighbours do; the stop, which is narrow, keeps none apart beyond its own radius. */
static void lensopt__trim(const lensopt_problem *p, lflare_prescription *q)
{
    int32_t i;
    for (i = 0; i < q->surface_count; i++) {
        lflare_surface *s = &q->surfaces[i];
        if (s->radius != 0 && !s->is_stop) s->semi_diameter = fmin(s->semi_diameter, 0.98 * fabs(s->radius));
    }
    for (i = 0; i + 1 < q->surface_count; i++) {
        lflare_surface *s = &q->surfaces[i];
        int stop = s[0].is_stop || s[1].is_stop;
        lensopt__trim_pair(&s[0], &s[1], s[0].thickness, stop ? 0 : s[0].medium.kind == LFLARE_MEDIUM_AIR ? p->desc.air_edge : p->desc.glass_edge);
        if (s[1].is_stop && i + 2 < q->surface_count) lensopt__trim_pair(&s[0], &s[2], s[0].thickness + s[1].thickness, p->desc.air_edge);
    }
}

/* Rows of a candidate, the stop among them; semi-diameters are those of the direct light. */
static void lensopt__rows_of(const lensopt_problem *p, const lensopt__design *d, double opening, lflare_prescription *q)
{
    lensopt__direct path;
    lflare_surface stop;
    int32_t i, row = 0;
    memset(&stop, 0, sizeof stop);
    stop.is_stop = 1;
    stop.semi_diameter = d->iris * opening;
    lensopt__direct_path(d, &path);
    if (d->stop < 0) {
        stop.thickness = d->ahead;
        q->surfaces[row++] = stop;
    }
    for (i = 0; i < d->surfaces; i++) {
        lensopt__surface_of(p, d, i, &q->surfaces[row]);
        q->surfaces[row++].semi_diameter = fmax(0.1, lensopt__direct_reach(p, d, &path, i) * opening);
        if (i != d->stop) continue;
        q->surfaces[row - 1].thickness = d->ahead;
        stop.thickness = d->d[i] - d->ahead;
        q->surfaces[row++] = stop;
    }
    q->surface_count = row;
}

LENSOPT_API lflare_result lensopt_problem_prescription(const lensopt_problem *p, const double *x, lflare_prescription *out, double *iris, lflare_error *error)
{
    lflare_lens lens;
    lflare_prescription q;
    lensopt__design d;
    double reach[LFLARE_MAX_SURFACES], opening;
    lflare_result result;
    int32_t row;
    if (p == NULL || x == NULL || out == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a problem, a point and room for a prescription were expected, not NULL");
    memset(&q, 0, sizeof q);
    if (p->has_base) q = p->base;
    else memcpy(q.name, p->target.name, sizeof q.name);
    lensopt__decode(p, x, &d);
    opening = p->has_base ? fmax(1, p->base_opening / p->fixed.iris) : 1;
    q.sensor_width = p->target.sensor_width;
    q.sensor_height = p->target.sensor_height;
    q.fnumber = q.focus = 0;
    lensopt__rows_of(p, &d, opening, &q);
    result = lflare_lens_derive(&q, &lens, error);
    if (result != LFLARE_OK) return result;
    for (row = 0; row < q.surface_count; row++) reach[row] = q.surfaces[row].semi_diameter;
    lensopt__ghost_reach(p, &lens, d.iris, reach);
    for (row = 0; row < q.surface_count; row++)
        if (!q.surfaces[row].is_stop) q.surfaces[row].semi_diameter = fmin(1.02 * reach[row], p->desc.pupil);
    lensopt__trim(p, &q);
    result = lflare_lens_derive(&q, &lens, error);
    if (result != LFLARE_OK) return result;
    *out = q;
    if (iris != NULL) *iris = d.iris;
    return LFLARE_OK;
}

static lflare_pair lensopt__row_pair(const lensopt__design *d, int32_t i, int32_t j)
{
    lflare_pair pair = {0, 0, 0, 0};
    pair.first = j + (j > d->stop);
    pair.second = i + (i > d->stop);
    return pair;
}

LENSOPT_API lflare_result lensopt_problem_shows(const lensopt_problem *p, const double *x, int32_t light, lensopt_shown *out, int32_t *count)
{
    lensopt__descent *w;
    size_t size;
    int32_t k, i, j, room;
    if (p == NULL || x == NULL || count == NULL || *count < 0 || (out == NULL && *count > 0) || light < 0 || light >= p->lights) return LFLARE_ERROR_ARGUMENT;
    w = lensopt__descent_create(p, &size);
    if (w == NULL) return LFLARE_ERROR_MEMORY;
    lensopt__place_at(w, x);
    room = *count;
    *count = w->count;
    lensopt__trace_of(p, &w->batch, 0, &w->designs[0], &w->trace);
    for (k = 0; k < w->count && room >= w->count; k++) {
        const double *spot = w->spot[light][k];
        int32_t goal = w->goal_of[k];
        lensopt__pair_at(&w->trace, w->there[k], &i, &j);
        out[k].pair = lensopt__row_pair(&w->designs[0], i, j);
        out[k].ghost = goal >= 0 ? p->ghost_of[goal] : -1;
        out[k].centre = spot[0];
        out[k].radius = spot[2] >= 0 ? spot[1] : 0;
        out[k].cost = goal >= 0 ? lensopt__cost(w, goal, k) : lensopt__surplus(w, k);
    }
    p->desc.allocate(p->desc.allocate_user, w->memory, size, 0);
    return room >= *count ? LFLARE_OK : LFLARE_INCOMPLETE;
}

LENSOPT_API lflare_result lensopt_problem_residuals(const lensopt_problem *p, const double *x, double *residuals, double *jacobian, int32_t *rows)
{
    lensopt__descent *w;
    size_t size;
    int32_t room, v, i;
    if (p == NULL || x == NULL || rows == NULL || *rows < 0 || (*rows > 0 && (residuals == NULL || jacobian == NULL))) return LFLARE_ERROR_ARGUMENT;
    w = lensopt__descent_create(p, &size);
    if (w == NULL) return LFLARE_ERROR_MEMORY;
    lensopt__place_at(w, x);
    room = *rows;
    lensopt__normal_equations(w, 0);
    *rows = w->rows_made;
    if (room >= *rows) {
        w->jacobian = jacobian;
        w->residuals = residuals;
        lensopt__normal_equations(w, 0);
        for (v = 0; v < p->variables; v++)
            for (i = 0; i < *rows && (x[v] < w->lo[v] || x[v] > w->hi[v]); i++) jacobian[i * p->variables + v] = 0; /* cut off there, for a gap of that kind */
    }
    p->desc.allocate(p->desc.allocate_user, w->memory, size, 0);
    return room >= *rows ? LFLARE_OK : LFLARE_INCOMPLETE;
}


/* >> 12 algorithms */

/* How a child differs from its parent. */
typedef enum lensopt__move { LENSOPT__PERTURB, LENSOPT__RESAMPLE, LENSOPT__CROSS_PERTURB, LENSOPT__CROSS, LENSOPT__DIFFER, LENSOPT__MOVES } lensopt__move;

/* One population and all that decides how it goes on: what a checkpoint holds, and nothing else but what stands last. */
typedef struct lensopt__island {
    uint64_t random;
    int64_t evaluations, used; /* in all; in this round */
    int64_t life;              /* units of work since it began, or began anew */
    int64_t stale;             /* units of work since its best fell below `mark`; before its birth: members drawn */
    int64_t restarts;
    int32_t units;             /* of work, done in this round */
    int32_t born, archived;    /* its members are evaluated; how many champions it keeps */
    double mark;
    double success[LENSOPT__MOVES]; /* memetic: of the last children of each kind, how many were better */
    double *x, *f;             /* members; of a swarm what each particle has found */
    double *extra;             /* jDE: F, then CR of each member; PSO: where each particle is, then its velocity */
    double *archive_x, *archive_f;
    int64_t allowance;         /* of evaluations in this round */
    int64_t known_restarts;
    int32_t busy;
    double diversity, measured; /* as last measured, and when */
} lensopt__island;

/* What the algorithms need to know: the descriptor with its defaults put in, and its arrays. */
typedef struct lensopt__setup {
    lensopt_search_desc d;
    int32_t n, population, block_count;
    double *lower, *upper, *slowest, *fastest, *starts; /* slowest and fastest: a particle's velocities */
    int32_t *block_begin, *block_members;     /* variables of block b: block_members[block_begin[b]] up to block_begin[b + 1] */
} lensopt__setup;

/* A thread's room: points and values of a whole generation, and two doubles a member for jDE. */
typedef struct lensopt__room {
    double *x, *f, *extra;
} lensopt__room;

static uint64_t lensopt__bits(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double lensopt__random(uint64_t *state) { return (double)(int64_t)(lensopt__bits(state) >> 11) * (1.0 / 9007199254740992.0); }

LENSOPT_API double lensopt_random(uint64_t *state) { return lensopt__random(state); }

/* 0 to count - 1 */
static int32_t lensopt__below(uint64_t *state, int32_t count) { return (int32_t)((lensopt__bits(state) >> 32) * (uint64_t)(uint32_t)count >> 32); }

static int lensopt__is_finite(double v) { return v - v == 0; }

static double lensopt__even(const lensopt__setup *s, int32_t j, uint64_t *random)
{
    double v = s->lower[j] + lensopt__random(random) * (s->upper[j] - s->lower[j]);
    return v < s->upper[j] ? v : s->upper[j]; /* rounding may lead past it */
}

static size_t lensopt__points(const lensopt__setup *s, int32_t count) { return (size_t)count * (size_t)s->n; }

static void lensopt__copy(const lensopt__setup *s, double *to, const double *from) { memcpy(to, from, sizeof *to * (size_t)s->n); }

/* Into the bounds; 0 if something of it is no number. */
static int lensopt__into_bounds(const lensopt__setup *s, double *x)
{
    int32_t j, good = 1;
    for (j = 0; j < s->n; j++) {
        good &= lensopt__is_finite(x[j]);
        x[j] = !(x[j] >= s->lower[j]) ? s->lower[j] : x[j] > s->upper[j] ? s->upper[j] : x[j];
    }
    return good;
}

static void lensopt__island_evaluate(const lensopt__setup *s, lensopt__island *o, const double *x, int32_t count, double *f)
{
    int32_t i;
    s->d.function.evaluate(s->d.function.user, x, count, f);
    for (i = 0; i < count; i++)
        if (!lensopt__is_finite(f[i])) f[i] = HUGE_VAL;
    o->evaluations += count;
    o->used += count;
}

static int32_t lensopt__best(const double *f, int32_t count)
{
    int32_t i, best = 0;
    for (i = 1; i < count; i++)
        if (f[i] < f[best]) best = i;
    return best;
}

static int32_t lensopt__worst(const double *f, int32_t count)
{
    int32_t i, worst = 0;
    for (i = 1; i < count; i++)
        if (f[i] > f[worst]) worst = i;
    return worst;
}

/* Some member other than those of others[count]. */
static int32_t lensopt__other(const lensopt__setup *s, lensopt__island *o, const int32_t *others, int32_t count)
{
    for (;;) {
        int32_t i, k = lensopt__below(&o->random, s->population);
        for (i = 0; i < count && others[i] != k; i++) {}
        if (i == count) return k;
    }
}

/* Root mean square of all variables' distances from their means. */
static double lensopt__diversity(const lensopt__setup *s, const lensopt__island *o)
{
    double sum = 0;
    int32_t i, j;
    if (!o->born) return 0;
    for (j = 0; j < s->n; j++) {
        double mean = 0, square = 0, range = s->upper[j] - s->lower[j];
        if (!(range > 0)) continue;
        for (i = 0; i < s->population; i++) mean += o->x[(size_t)i * (size_t)s->n + (size_t)j] / s->population;
        for (i = 0; i < s->population; i++) {
            double off = (o->x[(size_t)i * (size_t)s->n + (size_t)j] - mean) / range;
            square += off * off;
        }
        sum += square / s->population;
    }
    return sqrt(sum / s->n);
}

/* -- lives -- */

static void lensopt__draw(const lensopt__setup *s, uint64_t *random, double *x)
{
    int32_t j;
    if (s->d.function.sample == NULL) {
        for (j = 0; j < s->n; j++) x[j] = lensopt__even(s, j, random);
        return;
    }
    for (j = 0; j < s->n; j++) x[j] = s->lower[j];
    s->d.function.sample(s->d.function.user, random, x);
    lensopt__into_bounds(s, x);
}

/* The next member is drawn, which may take long; the first life begins with what the caller gave. 1: all are, and have been evaluated. */
static int lensopt__birth(const lensopt__setup *s, lensopt__island *o)
{
    size_t points = lensopt__points(s, s->population), k;
    int32_t i, given = o->restarts == 0 ? s->d.start_count : 0;
    if (o->stale < given) {
        memcpy(o->x, s->starts, sizeof *o->x * lensopt__points(s, given));
        o->stale = given;
    }
    if (o->stale < s->population) lensopt__draw(s, &o->random, o->x + lensopt__points(s, (int32_t)o->stale++));
    if (o->stale < s->population) return 0;
    for (i = 0; i < s->population; i++) lensopt__into_bounds(s, o->x + lensopt__points(s, i)); /* some may come from a checkpoint */
    lensopt__island_evaluate(s, o, o->x, s->population, o->f);
    if (s->d.method == LENSOPT_JDE) {
        for (i = 0; i < s->population; i++) {
            o->extra[i] = s->d.weight_low + 0.5 * s->d.weight_up;
            o->extra[s->population + i] = 0.9;
        }
    } else if (s->d.method == LENSOPT_PSO) {
        memcpy(o->extra, o->x, sizeof *o->x * points);
        for (k = 0; k < points; k++) o->extra[points + k] = s->fastest[k % (size_t)s->n] * (2 * lensopt__random(&o->random) - 1);
    }
    for (i = 0; i < LENSOPT__MOVES; i++) o->success[i] = 1;
    o->born = 1;
    o->mark = HUGE_VAL;
    o->life = o->stale = 0;
    return 1;
}

/* Whether two points are one for all that a search can tell. */
static int lensopt__twins(const lensopt__setup *s, const double *x, const double *y)
{
    int32_t j;
    for (j = 0; j < s->n; j++)
        if (!(fabs(x[j] - y[j]) <= 1e-6 * (s->upper[j] - s->lower[j]))) return 0;
    return 1;
}

/* The champion goes to the archive, in the place of its twin or of the worst, if it is better. */
static void lensopt__retire(const lensopt__setup *s, lensopt__island *o)
{
    int32_t best = lensopt__best(o->f, s->population), k;
    const double *x = o->x + lensopt__points(s, best);
    if (!(o->f[best] < HUGE_VAL)) return;
    for (k = 0; k < o->archived && !lensopt__twins(s, x, o->archive_x + lensopt__points(s, k)); k++) {}
    if (k == o->archived && k == LENSOPT_ARCHIVE) k = lensopt__worst(o->archive_f, LENSOPT_ARCHIVE);
    if (k < o->archived && !(o->f[best] < o->archive_f[k])) return;
    lensopt__copy(s, o->archive_x + lensopt__points(s, k), x);
    o->archive_f[k] = o->f[best];
    if (k == o->archived) o->archived++;
}

/* -- differential evolution -- */

/* What left the bounds is drawn anew. */
static double lensopt__inside(const lensopt__setup *s, lensopt__island *o, int32_t j, double v)
{
    return v >= s->lower[j] && v <= s->upper[j] ? v : lensopt__even(s, j, &o->random);
}

/* Without a branch, which would be guessed wrong for a tenth of all variables. */
static double lensopt__choose(int yes, double a, double b)
{
    uint64_t mask = (uint64_t)0 - (uint64_t)(yes != 0), bits[2];
    memcpy(&bits[0], &a, sizeof a);
    memcpy(&bits[1], &b, sizeof b);
    bits[0] = (bits[0] & mask) | (bits[1] & ~mask);
    memcpy(&a, &bits[0], sizeof a);
    return a;
}

/* x[i] crossed with base + weight (a - b): variables one by one, or a run of them. */
static void lensopt__trial(const lensopt__setup *s, lensopt__island *o, int32_t i, int32_t best, double weight, double crossover, double *out)
{
    int best_base = s->d.strategy == LENSOPT_BEST_1_EXP || s->d.strategy == LENSOPT_BEST_1_BIN;
    int32_t picked[4], j, forced, run;
    const double *x = o->x + lensopt__points(s, i), *base, *a, *b;
    picked[0] = i;
    for (j = 1; j < 4 - best_base; j++) picked[j] = lensopt__other(s, o, picked, j);
    a = o->x + lensopt__points(s, picked[1]);
    b = o->x + lensopt__points(s, picked[2]);
    base = o->x + lensopt__points(s, best_base ? best : picked[3]);
    forced = lensopt__below(&o->random, s->n);
    if (s->d.strategy == LENSOPT_RAND_1_BIN || s->d.strategy == LENSOPT_BEST_1_BIN) {
        uint64_t random = o->random;
        for (j = 0; j < s->n; j++) {
            double v = base[j] + weight * (a[j] - b[j]);
            out[j] = lensopt__choose(lensopt__random(&random) < crossover, v, x[j]);
        }
        o->random = random;
        out[forced] = base[forced] + weight * (a[forced] - b[forced]);
        for (j = 0; j < s->n; j++) out[j] = lensopt__inside(s, o, j, out[j]);
        return;
    }
    lensopt__copy(s, out, x);
    for (run = 0, j = forced; run == 0 || (run < s->n && lensopt__random(&o->random) < crossover); run++, j = j + 1 < s->n ? j + 1 : 0)
        out[j] = lensopt__inside(s, o, j, base[j] + weight * (a[j] - b[j]));
}

/* A generation: all trials from the members as they are, then each takes its parent's place unless it is worse. */
static void lensopt__de(const lensopt__setup *s, lensopt__island *o, lensopt__room *room)
{
    int32_t i, best = lensopt__best(o->f, s->population), adaptive = s->d.method == LENSOPT_JDE;
    double *weight = o->extra, *crossover = o->extra + s->population, *new_weight = room->extra, *new_crossover = room->extra + s->population;
    for (i = 0; i < s->population; i++) {
        if (adaptive) {
            new_weight[i] = lensopt__random(&o->random) < s->d.tau1 ? s->d.weight_low + lensopt__random(&o->random) * s->d.weight_up : weight[i];
            new_crossover[i] = lensopt__random(&o->random) < s->d.tau2 ? lensopt__random(&o->random) : crossover[i];
        }
        lensopt__trial(s, o, i, best, adaptive ? new_weight[i] : s->d.weight, adaptive ? new_crossover[i] : s->d.crossover, room->x + lensopt__points(s, i));
    }
    lensopt__island_evaluate(s, o, room->x, s->population, room->f);
    for (i = 0; i < s->population; i++) {
        if (!(room->f[i] <= o->f[i])) continue;
        lensopt__copy(s, o->x + lensopt__points(s, i), room->x + lensopt__points(s, i));
        o->f[i] = room->f[i];
        if (!adaptive) continue;
        weight[i] = new_weight[i];
        crossover[i] = new_crossover[i];
    }
}

/* -- particle swarm -- */

/* The best of a particle's neighbours on the ring. It is not one itself, as in pagmo: who leads would fly nowhere but to where it is. */
static int32_t lensopt__leader(const lensopt__setup *s, const lensopt__island *o, int32_t i)
{
    int32_t best = -1, k, reach = s->d.neighbours / 2, count = s->population;
    for (k = i - reach; k <= i + reach; k++) {
        int32_t at = k < 0 ? k + count : k >= count ? k - count : k;
        if (k != i && (best < 0 || o->f[at] < o->f[best])) best = at;
    }
    return best;
}

/* A particle moves; it stops at walls. One number from the generator gives both of a variable's weights. */
static void lensopt__fly(const lensopt__setup *s, lensopt__island *o, const double *own, const double *leader, double *at, double *speed)
{
    int constricted = s->d.swarm == LENSOPT_CONSTRICTION;
    double omega = s->d.omega, c1 = (constricted ? omega : 1) * s->d.c1 / 4294967296.0, c2 = (constricted ? omega : 1) * s->d.c2 / 4294967296.0;
    uint64_t random = o->random;
    int32_t j;
    for (j = 0; j < s->n; j++) {
        uint64_t bits = lensopt__bits(&random);
        double x = at[j], most = s->fastest[j];
        double v = omega * speed[j] + c1 * (double)(int64_t)(bits >> 32) * (own[j] - x) + c2 * (double)(int64_t)(bits & 0xffffffffu) * (leader[j] - x);
        v = v > most ? most : v < -most ? -most : v;
        x += v;
        if (x < s->lower[j] || x > s->upper[j]) {
            x = x < s->lower[j] ? s->lower[j] : s->upper[j];
            v = 0;
        }
        at[j] = x;
        speed[j] = v;
    }
    o->random = random;
}

/* A generation, eight particles at a time: the next ones know what these have found, as far as batches that suit a vectorised function allow. */
static void lensopt__pso(const lensopt__setup *s, lensopt__island *o, lensopt__room *room)
{
    enum { BATCH = 8 };
    double *at = o->extra, *speed = o->extra + lensopt__points(s, s->population);
    int32_t begin, i, count, best = lensopt__best(o->f, s->population);
    for (begin = 0; begin < s->population; begin += count) {
        count = s->population - begin < BATCH ? s->population - begin : BATCH;
        for (i = begin; i < begin + count; i++) {
            int32_t leader = s->d.neighbours < 0 ? best : lensopt__leader(s, o, i);
            size_t p = lensopt__points(s, i);
            lensopt__fly(s, o, o->x + p, o->x + lensopt__points(s, leader), at + p, speed + p);
        }
        lensopt__island_evaluate(s, o, at + lensopt__points(s, begin), count, room->f + begin);
        for (i = begin; i < begin + count; i++) {
            if (!(room->f[i] <= o->f[i])) continue;
            o->f[i] = room->f[i];
            lensopt__copy(s, o->x + lensopt__points(s, i), at + lensopt__points(s, i));
            if (o->f[i] < o->f[best]) best = i;
        }
    }
}

/* -- memetic -- */

static int32_t lensopt__block_size(const lensopt__setup *s, int32_t block) { return s->block_begin[block + 1] - s->block_begin[block]; }

/* A value that left the bounds comes back from the wall: at the wall itself children would gather. */
static double lensopt__reflected(const lensopt__setup *s, int32_t j, double v)
{
    if (v < s->lower[j]) v = 2 * s->lower[j] - v;
    else if (v > s->upper[j]) v = 2 * s->upper[j] - v;
    return v < s->lower[j] ? s->lower[j] : v > s->upper[j] ? s->upper[j] : v;
}

/* One to three blocks moved, each by its own scale: from the whole range down to a three-hundredth of it. */
static void lensopt__perturb(const lensopt__setup *s, lensopt__island *o, double *child)
{
    int32_t count = 1 + lensopt__below(&o->random, 3), k;
    for (; count > 0; count--) {
        int32_t block = lensopt__below(&o->random, s->block_count);
        double scale = pow(10, -2.5 * lensopt__random(&o->random));
        for (k = 0; k < lensopt__block_size(s, block); k++) {
            int32_t j = s->block_members[s->block_begin[block] + k];
            double bell = lensopt__random(&o->random) + lensopt__random(&o->random) + lensopt__random(&o->random) - 1.5; /* half as wide as a normal one */
            child[j] = lensopt__reflected(s, j, child[j] + 2 * scale * (s->upper[j] - s->lower[j]) * bell);
        }
    }
}

static void lensopt__take_block(const lensopt__setup *s, int32_t block, const double *from, double *child)
{
    int32_t k;
    for (k = s->block_begin[block]; k < s->block_begin[block + 1]; k++) child[s->block_members[k]] = from[s->block_members[k]];
}

/* One to three blocks as a new point has them. fresh: room for that. */
static void lensopt__resample(const lensopt__setup *s, lensopt__island *o, double *fresh, double *child)
{
    int32_t count = 1 + lensopt__below(&o->random, 3);
    lensopt__draw(s, &o->random, fresh);
    for (; count > 0; count--) lensopt__take_block(s, lensopt__below(&o->random, s->block_count), fresh, child);
}

/* A run of neighbouring blocks, or each with an even chance, from another member. */
static void lensopt__cross(const lensopt__setup *s, lensopt__island *o, int32_t parent, double *child)
{
    const double *other = o->x + lensopt__points(s, lensopt__other(s, o, &parent, 1));
    int32_t begin = lensopt__below(&o->random, s->block_count), length = 1 + lensopt__below(&o->random, s->block_count), k;
    int run = lensopt__random(&o->random) < 0.5;
    for (k = 0; k < s->block_count; k++)
        if (run ? (k - begin + s->block_count) % s->block_count < length : k == begin || lensopt__random(&o->random) < 0.5) lensopt__take_block(s, k, other, child);
}

/* Moved by the difference of two others, in most blocks or in few. */
static void lensopt__differ(const lensopt__setup *s, lensopt__island *o, int32_t parent, double *child)
{
    int32_t picked[3], forced = lensopt__below(&o->random, s->block_count), block, k;
    double weight = 0.4 + 0.6 * lensopt__random(&o->random), share = lensopt__random(&o->random) < 0.5 ? 0.9 : 0.3;
    const double *a, *b;
    picked[0] = parent;
    picked[1] = lensopt__other(s, o, picked, 1);
    picked[2] = lensopt__other(s, o, picked, 2);
    a = o->x + lensopt__points(s, picked[1]);
    b = o->x + lensopt__points(s, picked[2]);
    for (block = 0; block < s->block_count; block++) {
        if (block != forced && !(lensopt__random(&o->random) < share)) continue;
        for (k = s->block_begin[block]; k < s->block_begin[block + 1]; k++) {
            int32_t j = s->block_members[k];
            child[j] = lensopt__reflected(s, j, child[j] + weight * (a[j] - b[j]));
        }
    }
}

/* Goes downhill from a child; its value, HUGE_VAL where that is not found out. What polishing gives is checked, since a point out of bounds, or a value that
   is none, would stay for good. */
static double lensopt__polish_child(const lensopt__setup *s, lensopt__island *o, double *child, double *polished)
{
    double value = HUGE_VAL;
    int32_t cost, j;
    lensopt__copy(s, polished, child);
    cost = s->d.function.polish(s->d.function.user, polished, &value, s->d.polish_steps);
    cost = cost < 1 ? 1 : cost; /* that limits of evaluations are reached */
    o->evaluations += cost;
    o->used += cost;
    for (j = 0; j < s->n; j++)
        if (!(polished[j] >= s->lower[j] && polished[j] <= s->upper[j])) return HUGE_VAL;
    if (!lensopt__is_finite(value)) return HUGE_VAL;
    lensopt__copy(s, child, polished);
    return value;
}

/* The member whose place a child takes: its parent, or a member that it has come to, so that there are no copies. */
static int32_t lensopt__rival(const lensopt__setup *s, const lensopt__island *o, const double *child, double f, int32_t parent)
{
    int32_t i;
    for (i = 0; i < s->population; i++) /* the values first: few are alike */
        if (fabs(o->f[i] - f) <= 1e-3 * fabs(f) + 1e-12 && lensopt__twins(s, child, o->x + lensopt__points(s, i))) return i;
    return parent;
}

/* Which kind of child comes next: those that were better of late come up more often, but none less than once in twenty times (probability matching;
   Thierens, GECCO 2005). Few surfaces want crossing, many surfaces small moves. Where nothing is polished it would be the smallest moves alone
   that are better: there all kinds have the same chance. */
static lensopt__move lensopt__pick_move(const lensopt__setup *s, lensopt__island *o)
{
    double sum = 0, dice = lensopt__random(&o->random), even = 1.0 / (int)LENSOPT__MOVES, adapted = s->d.function.polish != NULL ? 0.75 : 0;
    int32_t i;
    for (i = 0; i < LENSOPT__MOVES; i++) sum += o->success[i];
    for (i = 0; i + 1 < LENSOPT__MOVES; i++) {
        dice -= (1 - adapted) * even + adapted * (sum > 0 ? o->success[i] / sum : even);
        if (dice < 0) break;
    }
    return (lensopt__move)i;
}

static void lensopt__make_child(const lensopt__setup *s, lensopt__island *o, lensopt__move move, int32_t parent, double *fresh, double *child)
{
    lensopt__copy(s, child, o->x + lensopt__points(s, parent));
    switch (move) {
    case LENSOPT__PERTURB: lensopt__perturb(s, o, child); break;
    case LENSOPT__RESAMPLE: lensopt__resample(s, o, fresh, child); break;
    case LENSOPT__CROSS: lensopt__cross(s, o, parent, child); break;
    case LENSOPT__CROSS_PERTURB:
        lensopt__cross(s, o, parent, child);
        lensopt__perturb(s, o, child);
        break;
    default: lensopt__differ(s, o, parent, child);
    }
}

/* One child of each member in turn. */
static void lensopt__memetic(const lensopt__setup *s, lensopt__island *o, lensopt__room *room)
{
    int32_t parent = (int32_t)(o->life % s->population), rival;
    lensopt__move move = lensopt__pick_move(s, o);
    double *child = room->x, *other = room->x + s->n, f = HUGE_VAL;
    lensopt__make_child(s, o, move, parent, other, child);
    if (s->d.function.polish != NULL) f = lensopt__polish_child(s, o, child, other);
    if (f == HUGE_VAL) lensopt__island_evaluate(s, o, child, 1, &f);
    rival = lensopt__rival(s, o, child, f, parent);
    o->success[move] += 0.02 * ((f < o->f[rival]) - o->success[move]);
    if (!(f <= o->f[rival])) return;
    lensopt__copy(s, o->x + lensopt__points(s, rival), child);
    o->f[rival] = f;
}

/* -- all of them -- */

/* Units of work of a generation. */
static int32_t lensopt__generation(const lensopt__setup *s) { return s->d.method == LENSOPT_MEMETIC ? s->population : 1; }

/* One unit of an island's work, or a part of its birth; its best value then. */
static double lensopt__advance(const lensopt__setup *s, lensopt__island *o, lensopt__room *room)
{
    double best;
    if (!o->born) { /* all of it is one */
        if (!lensopt__birth(s, o)) return HUGE_VAL;
        o->units++;
        return o->f[lensopt__best(o->f, s->population)];
    }
    o->units++;
    if (s->d.method == LENSOPT_MEMETIC) lensopt__memetic(s, o, room);
    else if (s->d.method == LENSOPT_PSO) lensopt__pso(s, o, room);
    else lensopt__de(s, o, room);
    o->life++;
    best = o->f[lensopt__best(o->f, s->population)];
    if (best < o->mark && (o->mark == HUGE_VAL || best < o->mark - 1e-3 * fabs(o->mark))) {
        o->mark = best;
        o->stale = 0;
    } else if (s->d.patience > 0 && ++o->stale / lensopt__generation(s) >= s->d.patience) {
        lensopt__retire(s, o);
        o->born = 0;
        o->stale = 0;
        o->restarts++;
    }
    return best;
}

/* >> 13 search */

/* -- threads and time -- */

#if !defined(LENSOPT_NO_THREADS) && (defined(_WIN32) || defined(__unix__) || defined(__APPLE__))
#define LENSOPT__THREADS
#endif

/* <windows.h> takes names such as near and far from whoever includes this: what is used of it is declared here as it is there. */
#ifdef _WIN32
#ifdef __cplusplus
extern "C" {
#endif
__declspec(dllimport) uint64_t __stdcall GetTickCount64(void);
#ifdef LENSOPT__THREADS
struct _RTL_SRWLOCK;
struct _RTL_CONDITION_VARIABLE;
__declspec(dllimport) void __stdcall AcquireSRWLockExclusive(struct _RTL_SRWLOCK *lock);
__declspec(dllimport) void __stdcall ReleaseSRWLockExclusive(struct _RTL_SRWLOCK *lock);
__declspec(dllimport) int __stdcall SleepConditionVariableSRW(struct _RTL_CONDITION_VARIABLE *changed, struct _RTL_SRWLOCK *lock, unsigned long ms, unsigned long flags);
__declspec(dllimport) void __stdcall WakeAllConditionVariable(struct _RTL_CONDITION_VARIABLE *changed);
__declspec(dllimport) unsigned long __stdcall GetActiveProcessorCount(unsigned short group);
__declspec(dllimport) unsigned long __stdcall WaitForSingleObject(void *handle, unsigned long ms);
__declspec(dllimport) int __stdcall CloseHandle(void *handle);
#endif
#ifdef __cplusplus
}
#endif
#ifdef LENSOPT__THREADS
#include <process.h>
#endif
#else
#include <time.h>
#if defined(__unix__) || defined(__APPLE__)
#include <sys/time.h>
#ifdef LENSOPT__THREADS
#include <pthread.h>
#include <unistd.h>
#endif
#endif
#endif

/* Seconds, from anywhere. Strict C99 hides POSIX's steady clock, and no header can ask for it any more once another was included: then it is
   the clock on the wall, whose steps back lensopt__tick leaves out. */
static double lensopt__now(void)
{
#if defined(_WIN32)
    return 1e-3 * (double)(int64_t)GetTickCount64();
#elif defined(CLOCK_MONOTONIC)
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
#elif defined(__unix__) || defined(__APPLE__)
    struct timeval t;
    gettimeofday(&t, NULL);
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
#else
    return (double)time(NULL);
#endif
}

/* A lock, and a condition that all wait for who have nothing to do. */
typedef struct lensopt__gate {
#if !defined(LENSOPT__THREADS)
    int unused;
#elif defined(_WIN32)
    void *lock, *changed; /* as large as SRWLOCK and CONDITION_VARIABLE are, and all zeroes to begin with, as they are */
#else
    pthread_mutex_t lock;
    pthread_cond_t changed;
#endif
} lensopt__gate;

#if !defined(LENSOPT__THREADS)
typedef int lensopt__thread;
static int lensopt__gate_open(lensopt__gate *g) { return g->unused == 0; }
static void lensopt__gate_close(lensopt__gate *g) { (void)g; }
static void lensopt__lock(lensopt__gate *g) { (void)g; }
static void lensopt__unlock(lensopt__gate *g) { (void)g; }
static void lensopt__wait(lensopt__gate *g) { (void)g; }
static void lensopt__wake(lensopt__gate *g) { (void)g; }
static int32_t lensopt__processors(void) { return 1; }
#elif defined(_WIN32)
typedef uintptr_t lensopt__thread;
static int lensopt__gate_open(lensopt__gate *g) { return g->lock == NULL && g->changed == NULL; }
static void lensopt__gate_close(lensopt__gate *g) { (void)g; }
static void lensopt__lock(lensopt__gate *g) { AcquireSRWLockExclusive((struct _RTL_SRWLOCK *)&g->lock); }
static void lensopt__unlock(lensopt__gate *g) { ReleaseSRWLockExclusive((struct _RTL_SRWLOCK *)&g->lock); }
static void lensopt__wait(lensopt__gate *g) { SleepConditionVariableSRW((struct _RTL_CONDITION_VARIABLE *)&g->changed, (struct _RTL_SRWLOCK *)&g->lock, 0xffffffffu, 0); }
static void lensopt__wake(lensopt__gate *g) { WakeAllConditionVariable((struct _RTL_CONDITION_VARIABLE *)&g->changed); }
static int32_t lensopt__processors(void) { return (int32_t)GetActiveProcessorCount(0xffff); }
#else
typedef pthread_t lensopt__thread;
static int lensopt__gate_open(lensopt__gate *g)
{
    if (pthread_mutex_init(&g->lock, NULL) != 0) return 0;
    if (pthread_cond_init(&g->changed, NULL) == 0) return 1;
    pthread_mutex_destroy(&g->lock);
    return 0;
}
static void lensopt__gate_close(lensopt__gate *g)
{
    pthread_cond_destroy(&g->changed);
    pthread_mutex_destroy(&g->lock);
}
static void lensopt__lock(lensopt__gate *g) { pthread_mutex_lock(&g->lock); }
static void lensopt__unlock(lensopt__gate *g) { pthread_mutex_unlock(&g->lock); }
static void lensopt__wait(lensopt__gate *g) { pthread_cond_wait(&g->changed, &g->lock); }
static void lensopt__wake(lensopt__gate *g) { pthread_cond_broadcast(&g->changed); }
static int32_t lensopt__processors(void)
{
#ifdef _SC_NPROCESSORS_ONLN
    return (int32_t)sysconf(_SC_NPROCESSORS_ONLN);
#else
    return 1;
#endif
}
#endif

typedef struct lensopt__worker {
    struct lensopt_search *search;
    lensopt__room room;
    lensopt__thread thread;
    int32_t started;
} lensopt__worker;

/* A point to sort by its value: a member, or beyond the population a champion in the archive. */
typedef struct lensopt__rank {
    double f;
    int32_t island, member;
} lensopt__rank;

/* What it points to lies behind it in the same block. What is below `gate` is only touched under its lock while a run is on, but for the
   insides of an island that is busy: these are its worker's. */
struct lensopt_search {
    lensopt__setup setup;
    lflare_realloc allocate;
    void *user;
    size_t size;               /* of the block */
    uint64_t hash;             /* of what a checkpoint must agree with */
    int32_t islands, threads, round; /* round: units of work of an island from one migration to the next */
    lensopt__island *island;
    lensopt__worker *workers;
    double *migrants, *shown;  /* points, each with its value behind it; a copy of best_x for the callback */
    int32_t *migrant_of;       /* the members that migrate */
    lensopt__rank *ranks;

    lensopt__gate gate;
    int32_t running, quit, cancelled, waiting, caller_waits;
    lensopt_end end;
    lensopt_limits limits;
    int64_t rounds, evaluations, begun; /* begun: evaluations before this run */
    int64_t restarts;
    double best, *best_x;
    double raw, elapsed, told;  /* the clock as last read; seconds of this run; when the callback was last called */
    lensopt_progress_callback progress;
    void *progress_user;
};

/* -- creation -- */

/* Room for count things in a block whose address is not yet known (NULL) or known; *at becomes SIZE_MAX where it is too much. */
static void *lensopt__carve(char *block, size_t *at, size_t count, size_t size)
{
    size_t begin = *at, most = (size_t)-1;
    if (begin == most || (count > 0 && size > (most - 16 - begin) / count)) {
        *at = most;
        return NULL;
    }
    *at = (begin + count * size + 15) & ~(size_t)15;
    return block != NULL ? block + begin : NULL;
}

/* Puts all pointers where they belong and returns the block's size; search is the block, or a head without one (block NULL). */
static size_t lensopt__layout(lensopt_search *o, char *block)
{
    lensopt__setup *s = &o->setup;
    size_t n = (size_t)s->n, members = (size_t)s->population, at = 0;
    size_t extra = s->d.method == LENSOPT_PSO ? 2 * n : s->d.method == LENSOPT_JDE ? 2 : 0;
    size_t migrants = (size_t)o->islands * (size_t)s->d.migrants;
    int32_t i;
#define LENSOPT__CARVE(type, count) (type *)lensopt__carve(block, &at, (size_t)(count), sizeof(type))
    (void)LENSOPT__CARVE(lensopt_search, 1);
    s->lower = LENSOPT__CARVE(double, n);
    s->upper = LENSOPT__CARVE(double, n);
    s->fastest = LENSOPT__CARVE(double, n);
    s->slowest = LENSOPT__CARVE(double, n);
    s->starts = LENSOPT__CARVE(double, (size_t)s->d.start_count * n);
    s->block_begin = LENSOPT__CARVE(int32_t, n + 1);
    s->block_members = LENSOPT__CARVE(int32_t, n);
    o->island = LENSOPT__CARVE(lensopt__island, o->islands);
    o->workers = LENSOPT__CARVE(lensopt__worker, o->threads);
    o->migrants = LENSOPT__CARVE(double, migrants * (n + 1));
    o->migrant_of = LENSOPT__CARVE(int32_t, members);
    o->shown = LENSOPT__CARVE(double, n);
    o->best_x = LENSOPT__CARVE(double, n);
    o->ranks = LENSOPT__CARVE(lensopt__rank, (size_t)o->islands * (members + LENSOPT_ARCHIVE));
    for (i = 0; i < o->islands; i++) {
        lensopt__island none, *p = block != NULL ? &o->island[i] : &none;
        p->x = LENSOPT__CARVE(double, members * n);
        p->f = LENSOPT__CARVE(double, members);
        p->extra = LENSOPT__CARVE(double, members * extra);
        p->archive_x = LENSOPT__CARVE(double, LENSOPT_ARCHIVE * n);
        p->archive_f = LENSOPT__CARVE(double, LENSOPT_ARCHIVE);
    }
    for (i = 0; i < o->threads; i++) {
        lensopt__room none, *p = block != NULL ? &o->workers[i].room : &none;
        p->x = LENSOPT__CARVE(double, members * n);
        p->f = LENSOPT__CARVE(double, members);
        p->extra = LENSOPT__CARVE(double, members * 2);
    }
#undef LENSOPT__CARVE
    return at;
}

static const char *lensopt__bad_function(const lensopt_function *f, lflare_error *error)
{
    int32_t j;
    if (f->variables < 1 || f->variables > LENSOPT_MAX_VARIABLES) return "1 to 512 variables were expected";
    if (f->lower == NULL || f->upper == NULL) return "lower and upper bounds were expected, not NULL";
    if (f->evaluate == NULL) return "a function to evaluate was expected, not NULL";
    for (j = 0; j < f->variables; j++) {
        if (lensopt__is_finite(f->lower[j]) && lensopt__is_finite(f->upper[j]) && lensopt__is_finite(f->upper[j] - f->lower[j]) && f->lower[j] <= f->upper[j]) continue;
        if (!(f->lower[j] > f->upper[j])) lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "variable %i: finite bounds, their difference too, were expected", j + 1);
        else lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "variable %i: its lower bound %g is above its upper bound %g", j + 1, f->lower[j], f->upper[j]);
        return "";
    }
    return NULL;
}

static int lensopt__between(double v, double low, double high) { return v >= low && v <= high; }

/* What is wrong with a descriptor's numbers, defaults put in. */
static const char *lensopt__bad_numbers(const lensopt_search_desc *d)
{
    if (d->islands < 1 || d->islands > LENSOPT_MAX_ISLANDS) return "1 to 1024 islands were expected, or 0";
    if (d->population < 4 || d->population > LENSOPT_MAX_POPULATION) return "a population of 4 to 65536 was expected, or 0";
    if (d->threads < 1) return "a number of threads was expected, or 0";
    if (d->start_count < 0 || d->start_count > d->population) return "no more starts than an island has members were expected";
    if (d->start_count > 0 && d->starts == NULL) return "starts were expected, not NULL";
    if ((int32_t)d->strategy < 0 || d->strategy > LENSOPT_BEST_1_BIN) return "the strategy is none";
    if (!lensopt__between(d->weight, 0, 2)) return "weight is 0 to 2";
    if (!lensopt__between(d->crossover, 0, 1)) return "crossover is 0 to 1";
    if (!lensopt__between(d->tau1, 0, 1) || !lensopt__between(d->tau2, 0, 1)) return "tau1 and tau2 are 0 to 1";
    if (!lensopt__between(d->weight_low, 0, 2) || !lensopt__between(d->weight_up, 0, 2)) return "weight_low and weight_up are 0 to 2";
    if ((int32_t)d->swarm < 0 || d->swarm > LENSOPT_INERTIA) return "the swarm is none";
    if (d->neighbours != -1 && (d->neighbours < 2 || d->neighbours % 2 != 0)) return "an even number of neighbours was expected, or -1 for all, or 0";
    if (d->method == LENSOPT_PSO && d->neighbours >= d->population) return "fewer neighbours than the population were expected, or -1 for all";
    if (!lensopt__between(d->omega, 0, 1)) return "omega is 0 to 1";
    if (!lensopt__between(d->c1, 0, 4) || !lensopt__between(d->c2, 0, 4)) return "c1 and c2 are 0 to 4";
    if (!lensopt__between(d->speed, 0, 1)) return "speed is 0 to 1";
    if (d->polish_steps < 1 || d->polish_steps > 10000) return "1 to 10000 steps of polishing were expected, or 0";
    if (d->patience != -1 && (d->patience < 1 || d->patience > 1000000)) return "a patience of 1 to 1000000 generations was expected, or -1 for no restart, or 0";
    if ((int32_t)d->topology < 0 || d->topology > LENSOPT_ISOLATED) return "the topology is none";
    if (d->migrants < 1 || d->migrants > d->population / 2) return "1 migrant to half of a population were expected, or 0";
    if ((int32_t)d->policy < 0 || d->policy > LENSOPT_RANDOM_FOR_RANDOM) return "the policy is none";
    if (d->period < 1 || d->period > 10000) return "a period of 1 to 10000 generations was expected, or 0";
    return NULL;
}

static void lensopt__default(int32_t *v, int32_t value) { if (*v == 0) *v = value; }
static void lensopt__default_number(double *v, double value) { if (*v == 0) *v = value; }

static void lensopt__search_defaults(lensopt_search_desc *d)
{
    int memetic = d->method == LENSOPT_MEMETIC;
    lensopt__default(&d->islands, memetic ? 8 : 15);
    lensopt__default(&d->population, memetic ? 20 : d->function.variables > 1 ? 15 * d->function.variables : 16);
    lensopt__default(&d->threads, lensopt__processors());
    lensopt__default_number(&d->weight, 0.8);
    lensopt__default_number(&d->crossover, 0.9);
    lensopt__default_number(&d->tau1, 0.1);
    lensopt__default_number(&d->tau2, 0.1);
    lensopt__default_number(&d->weight_low, 0.1);
    lensopt__default_number(&d->weight_up, 0.9);
    lensopt__default(&d->neighbours, 4);
    lensopt__default_number(&d->omega, 0.7298);
    lensopt__default_number(&d->c1, d->swarm == LENSOPT_INERTIA ? 1.49618 : 2.05);
    lensopt__default_number(&d->c2, d->swarm == LENSOPT_INERTIA ? 1.49618 : 2.05);
    lensopt__default_number(&d->speed, 0.5);
    lensopt__default(&d->polish_steps, 40);
    lensopt__default(&d->patience, memetic ? 50 : -1);
    lensopt__default(&d->migrants, 1);
    lensopt__default(&d->period, memetic ? 1000 : 10);
}

/* Blocks in the order of their numbers; variables in theirs. */
static void lensopt__make_blocks(lensopt__setup *s, const int32_t *blocks)
{
    int32_t i, j;
    for (j = 0; j < s->n; j++) { /* sorted by insertion, which keeps the order of equals */
        for (i = j; blocks != NULL && i > 0 && blocks[s->block_members[i - 1]] > blocks[j]; i--) s->block_members[i] = s->block_members[i - 1];
        s->block_members[i] = j;
    }
    for (j = 0; j < s->n; j++)
        if (j == 0 || blocks == NULL || blocks[s->block_members[j]] != blocks[s->block_members[j - 1]]) s->block_begin[s->block_count++] = j;
    s->block_begin[s->block_count] = s->n;
}

static void lensopt__hash(uint64_t *hash, const void *bytes, size_t size) /* FNV-1a */
{
    const uint8_t *p = (const uint8_t *)bytes;
    for (; size > 0; size--) *hash = (*hash ^ *p++) * 0x100000001b3u;
}

static uint64_t lensopt__double_bits(double v)
{
    uint64_t bits;
    v += 0.0; /* one zero, not two */
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static void lensopt__hash_word(uint64_t *hash, uint64_t word) /* the same on every machine */
{
    uint8_t bytes[8];
    int k;
    for (k = 0; k < 8; k++) bytes[k] = (uint8_t)(word >> 8 * k);
    lensopt__hash(hash, bytes, sizeof bytes);
}

static uint64_t lensopt__setup_hash(const lensopt_search *o)
{
    const lensopt__setup *s = &o->setup;
    const lensopt_search_desc *d = &s->d;
    const int32_t words[] = {s->n, s->population, o->islands, (int32_t)d->method, (int32_t)d->strategy, (int32_t)d->swarm, d->neighbours, d->polish_steps, d->patience,
                             (int32_t)d->topology, d->migrants, (int32_t)d->policy, d->period, d->start_count, d->function.sample != NULL, d->function.polish != NULL};
    const double numbers[] = {d->weight, d->crossover, d->tau1, d->tau2, d->weight_low, d->weight_up, d->omega, d->c1, d->c2, d->speed};
    uint64_t hash = 0xcbf29ce484222325u;
    size_t k;
    int32_t j;
    for (k = 0; k < sizeof words / sizeof words[0]; k++) lensopt__hash_word(&hash, (uint64_t)words[k]);
    for (k = 0; k < sizeof numbers / sizeof numbers[0]; k++) lensopt__hash_word(&hash, lensopt__double_bits(numbers[k]));
    for (k = 0; k < lensopt__points(s, d->start_count); k++) lensopt__hash_word(&hash, lensopt__double_bits(s->starts[k]));
    for (j = 0; j < s->n; j++) {
        lensopt__hash_word(&hash, lensopt__double_bits(s->lower[j]));
        lensopt__hash_word(&hash, lensopt__double_bits(s->upper[j]));
        lensopt__hash_word(&hash, (uint64_t)s->block_members[j]);
    }
    for (j = 0; j <= s->block_count; j++) lensopt__hash_word(&hash, (uint64_t)s->block_begin[j]);
    return hash;
}

/* The descriptor's arrays, and islands before their birth. */
static lflare_result lensopt__fill(lensopt_search *o, const lensopt_search_desc *desc, lflare_error *error)
{
    lensopt__setup *s = &o->setup;
    uint64_t random = desc->seed;
    int32_t i;
    lensopt__copy(s, s->lower, desc->function.lower);
    lensopt__copy(s, s->upper, desc->function.upper);
    for (i = 0; i < s->n; i++) {
        s->fastest[i] = s->d.speed * (s->upper[i] - s->lower[i]);
        s->slowest[i] = -s->fastest[i];
    }
    lensopt__make_blocks(s, desc->function.blocks);
    for (i = 0; i < s->d.start_count; i++) {
        lensopt__copy(s, s->starts + lensopt__points(s, i), desc->starts + lensopt__points(s, i));
        if (!lensopt__into_bounds(s, s->starts + lensopt__points(s, i))) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "start %i: finite numbers were expected", i + 1);
    }
    s->d.starts = NULL; /* the caller's arrays may go */
    s->d.function.lower = s->d.function.upper = NULL;
    s->d.function.blocks = NULL;
    for (i = 0; i < o->islands; i++) o->island[i].random = lensopt__bits(&random);
    for (i = 0; i < o->threads; i++) o->workers[i].search = o;
    o->hash = lensopt__setup_hash(o);
    o->best = HUGE_VAL;
    return LFLARE_OK;
}

LENSOPT_API lflare_result lensopt_search_create(const lensopt_search_desc *desc, lensopt_search **out, lflare_error *error)
{
    lensopt_search head, *o;
    const char *wrong = NULL;
    lflare_result result;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (out != NULL) *out = NULL;
    if (desc == NULL || out == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a descriptor and room for a search were expected, not NULL");
    if ((int32_t)desc->method < 0 || desc->method > LENSOPT_PSO) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "the method is none");
    wrong = lensopt__bad_function(&desc->function, error);
    memset(&head, 0, sizeof head);
    head.setup.d = *desc;
    lensopt__search_defaults(&head.setup.d);
    if (wrong == NULL) wrong = lensopt__bad_numbers(&head.setup.d);
    if (wrong != NULL) return *wrong != 0 ? lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "%s", wrong) : LFLARE_ERROR_ARGUMENT;
    head.setup.n = desc->function.variables;
    head.setup.population = head.setup.d.population;
    head.islands = head.setup.d.islands;
    head.threads = head.setup.d.threads < head.islands ? head.setup.d.threads : head.islands;
    if (head.threads > LENSOPT_MAX_THREADS) head.threads = LENSOPT_MAX_THREADS;
#ifndef LENSOPT__THREADS
    head.threads = 1;
#endif
    head.round = head.setup.d.period * lensopt__generation(&head.setup);
    head.allocate = desc->allocate != NULL ? desc->allocate : lensopt__libc_realloc;
    head.user = desc->user;
    head.size = lensopt__layout(&head, NULL);
    o = head.size != (size_t)-1 ? (lensopt_search *)head.allocate(head.user, NULL, 0, head.size) : NULL;
    if (o == NULL) return lensopt__fail(error, LFLARE_ERROR_MEMORY, "out of memory");
    memset((void *)o, 0, head.size);
    *o = head;
    lensopt__layout(o, (char *)o);
    result = lensopt__fill(o, desc, error);
    if (result == LFLARE_OK && !lensopt__gate_open(&o->gate)) result = lensopt__fail(error, LFLARE_ERROR_MEMORY, "no lock could be made");
    if (result == LFLARE_OK) *out = o;
    else head.allocate(head.user, o, head.size, 0);
    return result;
}

LENSOPT_API void lensopt_search_free(lensopt_search *o)
{
    if (o == NULL) return;
    lensopt__gate_close(&o->gate);
    o->allocate(o->user, o, o->size, 0);
}

/* -- migration -- */

/* Puts a member or a point from outside into slot i; a swarm's particle goes there, too. */
static void lensopt__place(const lensopt__setup *s, lensopt__island *o, int32_t i, const double *x, double f)
{
    lensopt__copy(s, o->x + lensopt__points(s, i), x);
    o->f[i] = f;
    if (s->d.method == LENSOPT_PSO) lensopt__copy(s, o->extra + lensopt__points(s, i), x);
}

static void lensopt__receive(const lensopt__setup *s, lensopt__island *o, const double *x, double f)
{
    int32_t i, best;
    if (!(f < HUGE_VAL)) return;
    for (i = 0; i < s->population; i++) /* who is there already does not come again, or a champion would fill the island with its copies */
        if (o->f[i] == f && memcmp(o->x + lensopt__points(s, i), x, sizeof *x * (size_t)s->n) == 0) return;
    if (s->d.policy == LENSOPT_BEST_FOR_WORST) {
        i = lensopt__worst(o->f, s->population);
        if (f < o->f[i]) lensopt__place(s, o, i, x, f);
        return;
    }
    best = lensopt__best(o->f, s->population);
    lensopt__place(s, o, lensopt__other(s, o, &best, 1), x, f);
}

/* Copies the members that migrate, with their values, to `out`. */
static void lensopt__emigrate(const lensopt__setup *s, lensopt__island *o, int32_t *members, double *out)
{
    int32_t i, k, at;
    for (i = 0; i < s->population; i++) members[i] = i;
    for (k = 0; k < s->d.migrants; k++) {
        if (s->d.policy == LENSOPT_RANDOM_FOR_RANDOM) {
            at = k + lensopt__below(&o->random, s->population - k);
        } else {
            for (i = at = k; i < s->population; i++)
                if (o->f[members[i]] < o->f[members[at]]) at = i;
        }
        i = members[at];
        members[at] = members[k];
        members[k] = i;
        lensopt__copy(s, out, o->x + lensopt__points(s, i));
        out[s->n] = o->f[i];
        out += s->n + 1;
    }
}

/* An island that began anew is left alone by older ones, whose champion would take it over before it has one of its own. */
static int lensopt__welcomes(const lensopt__island *to, const lensopt__island *from) { return to != from && to->born && from->born && from->life <= to->life; }

/* All go before any comes. */
static void lensopt__migrate(lensopt_search *o)
{
    const lensopt__setup *s = &o->setup;
    size_t size = (size_t)s->d.migrants * (size_t)(s->n + 1);
    int32_t to, from, k, full = s->d.topology == LENSOPT_FULL;
    if (s->d.topology == LENSOPT_ISOLATED || o->islands == 1) return;
    for (from = 0; from < o->islands; from++)
        if (o->island[from].born) lensopt__emigrate(s, &o->island[from], o->migrant_of, o->migrants + (size_t)from * size);
    for (to = 0; to < o->islands; to++)
        for (from = 0; from < o->islands; from++) {
            const double *x = o->migrants + (size_t)from * size;
            if ((!full && (from + 1) % o->islands != to) || !lensopt__welcomes(&o->island[to], &o->island[from])) continue;
            for (k = 0; k < s->d.migrants; k++, x += s->n + 1) lensopt__receive(s, &o->island[to], x, x[s->n]);
        }
}

/* What other processes send is evaluated here: a value of theirs that was wrong would stay for good. */
static void lensopt__exchange(lensopt_search *o)
{
    const lensopt__setup *s = &o->setup;
    double *in = o->workers[0].room.x, f;
    int32_t i, best;
    for (i = 0; i < o->islands && s->d.exchange != NULL; i++) {
        lensopt__island *p = &o->island[i];
        if (!p->born) continue;
        best = lensopt__best(p->f, s->population);
        lensopt__copy(s, in, p->x + lensopt__points(s, best));
        if (!s->d.exchange(o->user, i, p->x + lensopt__points(s, best), p->f[best], in) || !lensopt__into_bounds(s, in)) continue;
        lensopt__island_evaluate(s, p, in, 1, &f);
        lensopt__receive(s, p, in, f);
    }
}

/* -- running -- */

/* Under the lock. Steps of the clock backwards are no time. */
static void lensopt__tick(lensopt_search *o)
{
    double raw = lensopt__now();
    if (raw > o->raw) o->elapsed += raw - o->raw;
    o->raw = raw;
}

static int lensopt__may_go_on(const lensopt_search *o, const lensopt__island *p) { return p->units < o->round && p->used < p->allowance; }

/* The island to go on with: of those whose work is not done and that no one is at, the one farthest behind. */
static lensopt__island *lensopt__pick_island(lensopt_search *o)
{
    lensopt__island *pick = NULL;
    int32_t i;
    if (o->end != LENSOPT_RUNNING) return NULL;
    for (i = 0; i < o->islands; i++) {
        lensopt__island *p = &o->island[i];
        if (!p->busy && lensopt__may_go_on(o, p) && (pick == NULL || p->units < pick->units)) pick = p;
    }
    return pick;
}

static int lensopt__succeeded(const lensopt_search *o, double best) { return o->limits.target != 0 && best <= o->limits.target; }

/* Under the lock: what some of an island's work has brought. */
static void lensopt__account(lensopt_search *o, lensopt__island *p, int64_t evaluations, double diversity)
{
    const lensopt__setup *s = &o->setup;
    int32_t best = lensopt__best(p->f, s->population);
    o->evaluations += evaluations;
    o->restarts += p->restarts - p->known_restarts;
    p->known_restarts = p->restarts;
    if ((p->born || p->stale == 0) && p->f[best] < o->best) { /* not while its members are drawn */
        o->best = p->f[best];
        lensopt__copy(s, o->best_x, p->x + lensopt__points(s, best));
    }
    lensopt__tick(o);
    if (diversity >= 0) {
        p->diversity = diversity;
        p->measured = o->elapsed;
    }
    if (o->end != LENSOPT_RUNNING) return;
    if (o->cancelled) o->end = LENSOPT_ENDED_CANCELLED;
    else if (lensopt__succeeded(o, o->best)) o->end = LENSOPT_ENDED_TARGET;
    else if (o->limits.seconds > 0 && o->elapsed >= o->limits.seconds) o->end = LENSOPT_ENDED_SECONDS;
}

static void lensopt__report(lensopt_search *o, lensopt_progress *out)
{
    int32_t i;
    double left;
    memset(out, 0, sizeof *out);
    out->evaluations = o->evaluations;
    out->rounds = o->rounds;
    out->seconds = o->elapsed;
    out->rate = o->elapsed > 0 ? (double)(o->evaluations - o->begun) / o->elapsed : 0;
    out->best = o->best;
    lensopt__copy(&o->setup, o->shown, o->best_x);
    out->x = o->shown;
    for (i = 0; i < o->islands; i++) out->diversity += o->island[i].diversity / o->islands;
    out->remaining = o->limits.seconds > 0 ? o->limits.seconds - o->elapsed : -1;
    if (o->limits.evaluations > 0 && out->rate > 0) {
        left = (double)(o->limits.evaluations - o->evaluations) / out->rate;
        if (!(o->limits.seconds > 0) || left < out->remaining) out->remaining = left;
    }
    if (out->remaining < 0 && (o->limits.seconds > 0 || (o->limits.evaluations > 0 && out->rate > 0))) out->remaining = 0;
    out->restarts = o->restarts;
    out->end = o->end;
}

/* Under the lock, which it gives up while the callback is at work. */
static void lensopt__tell(lensopt_search *o, double period)
{
    lensopt_progress progress;
    int32_t stop;
    if (o->progress == NULL || o->elapsed - o->told < period) return;
    lensopt__report(o, &progress);
    o->told = o->elapsed;
    lensopt__unlock(&o->gate);
    stop = o->progress(o->progress_user, &progress);
    lensopt__lock(&o->gate);
    if (stop && o->end == LENSOPT_RUNNING) o->end = LENSOPT_ENDED_STOPPED;
}

#define LENSOPT__PERIOD 0.04 /* seconds between two calls of the callback: less than promised, by what a unit of work takes */

/* Under the lock: some of an island's work for this round; an eighth, so that all threads end it at nearly the same time. Units so short that the
   lock would take much of the time are done several at once. */
static void lensopt__toil(lensopt_search *o, lensopt__worker *w, lensopt__island *p)
{
    int32_t left = o->round / 8 > 1 ? o->round / 8 : 1, at_once = 1;
    p->busy = 1;
    while (left > 0 && o->end == LENSOPT_RUNNING && lensopt__may_go_on(o, p)) {
        int64_t before = p->evaluations;
        int measure = o->progress != NULL && (p->measured < 0 || o->elapsed - p->measured > 2 * LENSOPT__PERIOD);
        double diversity, best, began = o->elapsed;
        int32_t k = 0;
        lensopt__unlock(&o->gate);
        do best = lensopt__advance(&o->setup, p, &w->room);
        while (++k < at_once && k < left && p->born && lensopt__may_go_on(o, p) && !lensopt__succeeded(o, best));
        diversity = measure ? lensopt__diversity(&o->setup, p) : -1;
        lensopt__lock(&o->gate);
        lensopt__account(o, p, p->evaluations - before, diversity);
        left -= k;
        at_once = o->elapsed - began < 1e-4 ? 2 * at_once : 1;
        if (w == o->workers) lensopt__tell(o, LENSOPT__PERIOD);
        else if (o->caller_waits && o->progress != NULL && o->elapsed - o->told >= LENSOPT__PERIOD) lensopt__wake(&o->gate);
    }
    p->busy = 0;
}

static int lensopt__anyone_busy(const lensopt_search *o)
{
    int32_t i;
    for (i = 0; i < o->islands && !o->island[i].busy; i++) {}
    return i < o->islands;
}

/* Under the lock: works while there is work. The calling thread's share of a round ends when all have done theirs, a helper's with the run. */
static void lensopt__work(lensopt_search *o, lensopt__worker *w)
{
    int caller = w == o->workers;
    lensopt__island *p;
    for (;;) {
        while ((p = lensopt__pick_island(o)) != NULL) {
            lensopt__toil(o, w, p);
            /* wakes who could take over what was left, or waits for the end of the round */
            if (o->waiting > 0 && (o->end != LENSOPT_RUNNING || !lensopt__anyone_busy(o) || lensopt__pick_island(o) != NULL)) lensopt__wake(&o->gate);
        }
        if (caller ? !lensopt__anyone_busy(o) : o->quit) return;
        o->waiting++;
        o->caller_waits += caller;
        lensopt__wait(&o->gate);
        o->caller_waits -= caller;
        o->waiting--;
        if (caller) lensopt__tell(o, LENSOPT__PERIOD);
    }
}

#ifdef LENSOPT__THREADS
#ifdef _WIN32
static unsigned __stdcall lensopt__help(void *worker)
#else
static void *lensopt__help(void *worker)
#endif
{
    lensopt__worker *w = (lensopt__worker *)worker;
    lensopt__lock(&w->search->gate);
    lensopt__work(w->search, w);
    lensopt__unlock(&w->search->gate);
    return 0;
}
#endif

/* Where a function goes deep: some systems give threads that are not the first but half a megabyte. */
static void lensopt__helpers_start(lensopt_search *o)
{
#ifdef LENSOPT__THREADS
    const unsigned stack = 4u << 20;
    int32_t i;
#ifndef _WIN32
    pthread_attr_t attributes;
    int plain = pthread_attr_init(&attributes) != 0;
    if (!plain) pthread_attr_setstacksize(&attributes, stack);
#endif
    for (i = 1; i < o->threads; i++) {
        lensopt__worker *w = &o->workers[i];
#ifdef _WIN32
        w->thread = _beginthreadex(NULL, stack, lensopt__help, w, 0x10000, NULL); /* 0x10000: room, not memory at once */
        w->started = w->thread != 0;
#else
        w->started = pthread_create(&w->thread, plain ? NULL : &attributes, lensopt__help, w) == 0;
#endif
    }
#ifndef _WIN32
    if (!plain) pthread_attr_destroy(&attributes);
#endif
#else
    (void)o;
#endif
}

static void lensopt__helpers_join(lensopt_search *o)
{
#ifdef LENSOPT__THREADS
    int32_t i;
    for (i = 1; i < o->threads; i++) {
        if (!o->workers[i].started) continue;
#ifdef _WIN32
        WaitForSingleObject((void *)o->workers[i].thread, 0xffffffffu);
        CloseHandle((void *)o->workers[i].thread);
#else
        pthread_join(o->workers[i].thread, NULL);
#endif
        o->workers[i].started = 0;
    }
#else
    (void)o;
#endif
}

/* Shares out what may still be evaluated, counted from the beginning of the round, so that an island's share is the same however often the round was
   interrupted. 0: no island may do anything. */
static int lensopt__allow(lensopt_search *o)
{
    int64_t left = o->limits.evaluations;
    int32_t i, some = 0;
    for (i = 0; i < o->islands; i++) left -= o->island[i].evaluations - o->island[i].used;
    if (left < 0) left = 0;
    for (i = 0; i < o->islands; i++) {
        lensopt__island *p = &o->island[i];
        p->allowance = o->limits.evaluations > 0 ? left / o->islands + (i < left % o->islands) : INT64_MAX;
        some |= lensopt__may_go_on(o, p);
    }
    return some;
}

static int lensopt__round_done(const lensopt_search *o)
{
    int32_t i;
    for (i = 0; i < o->islands && o->island[i].units >= o->round; i++) {}
    return i == o->islands;
}

/* Counts and the best point from the islands, in their order: what threads found depends on who was first among equals. */
static void lensopt__sum_up(lensopt_search *o)
{
    const lensopt__setup *s = &o->setup;
    int32_t i, k;
    o->best = HUGE_VAL;
    o->evaluations = 0;
    o->restarts = 0;
    for (i = 0; i < o->islands; i++) {
        lensopt__island *p = &o->island[i];
        o->evaluations += p->evaluations;
        o->restarts += p->restarts;
        p->known_restarts = p->restarts;
        p->diversity = lensopt__diversity(s, p);
        p->measured = -1;
        for (k = 0; k < s->population + p->archived; k++) {
            int archived = k >= s->population, at = archived ? k - s->population : k;
            double f = archived ? p->archive_f[at] : p->f[at];
            if ((!archived && !p->born) || !(f < o->best)) continue;
            o->best = f;
            lensopt__copy(s, o->best_x, (archived ? p->archive_x : p->x) + lensopt__points(s, at));
        }
    }
}

/* Under the lock, no one at work: the end of a round, and all that the calling thread does between two. */
static void lensopt__between_rounds(lensopt_search *o)
{
    int32_t i;
    if (o->limits.evaluations > 0 && o->evaluations >= o->limits.evaluations) {
        o->end = LENSOPT_ENDED_EVALUATIONS;
        return;
    }
    lensopt__unlock(&o->gate);
    lensopt__migrate(o);
    lensopt__exchange(o);
    lensopt__lock(&o->gate);
    o->evaluations = 0;
    for (i = 0; i < o->islands; i++) {
        o->evaluations += o->island[i].evaluations;
        o->island[i].used = 0;
        o->island[i].units = 0;
    }
    o->rounds++;
}

static void lensopt__run(lensopt_search *o)
{
    if (o->cancelled) o->end = LENSOPT_ENDED_CANCELLED;
    else if (lensopt__succeeded(o, o->best)) o->end = LENSOPT_ENDED_TARGET;
    lensopt__helpers_start(o);
    while (o->end == LENSOPT_RUNNING) {
        if (lensopt__round_done(o)) lensopt__between_rounds(o);
        if (o->end != LENSOPT_RUNNING) break;
        if (lensopt__allow(o)) {
            if (o->waiting > 0) lensopt__wake(&o->gate);
            lensopt__work(o, o->workers);
        } else o->end = LENSOPT_ENDED_EVALUATIONS;
    }
    o->quit = 1;
    lensopt__wake(&o->gate);
    lensopt__unlock(&o->gate);
    lensopt__helpers_join(o);
    lensopt__lock(&o->gate);
    if (o->end == LENSOPT_ENDED_CANCELLED) o->cancelled = 0;
    lensopt__tick(o);
    lensopt__sum_up(o);
    lensopt__tell(o, -1);
}

static lflare_result lensopt__bad_run(const lensopt_search *o, const lensopt_limits *limits, lensopt_progress_callback progress, lflare_error *error)
{
    if (o == NULL || limits == NULL) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a search and its limits were expected, not NULL");
    if (!(limits->seconds >= 0)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a limit of 0 or more seconds was expected");
    if (limits->evaluations < 0) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a limit of 0 or more evaluations was expected");
    if (!lensopt__is_finite(limits->target)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a finite target was expected, or 0 for none");
    if (limits->seconds == 0 && limits->evaluations == 0 && limits->target == 0 && progress == NULL)
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "it would never end: a limit was expected (seconds, evaluations or target), or a callback");
    return LFLARE_OK;
}

/* Takes the search for oneself; 0 while it runs. */
static int lensopt__take(lensopt_search *o)
{
    int taken;
    lensopt__lock(&o->gate);
    taken = !o->running;
    o->running = 1;
    lensopt__unlock(&o->gate);
    return taken;
}

static void lensopt__give(lensopt_search *o)
{
    lensopt__lock(&o->gate);
    o->running = 0;
    lensopt__unlock(&o->gate);
}

LENSOPT_API lflare_result lensopt_search_run(lensopt_search *o, const lensopt_limits *limits, lensopt_progress_callback progress, void *user, lflare_error *error)
{
    lflare_result result = lensopt__bad_run(o, limits, progress, error);
    if (result != LFLARE_OK) return result;
    if (!lensopt__take(o)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a search that does not run already was expected");
    if (error != NULL) memset(error, 0, sizeof *error);
    lensopt__lock(&o->gate);
    o->limits = *limits;
    o->progress = progress;
    o->progress_user = user;
    o->quit = 0;
    o->end = LENSOPT_RUNNING;
    o->raw = lensopt__now();
    o->elapsed = o->told = 0;
    lensopt__sum_up(o);
    o->begun = o->evaluations;
    lensopt__run(o);
    result = o->end == LENSOPT_ENDED_STOPPED || o->end == LENSOPT_ENDED_CANCELLED ? LFLARE_INCOMPLETE : LFLARE_OK;
    lensopt__unlock(&o->gate);
    lensopt__give(o);
    return result;
}

LENSOPT_API void lensopt_search_cancel(lensopt_search *o)
{
    if (o == NULL) return;
    lensopt__lock(&o->gate);
    o->cancelled = 1;
    if (o->running && o->end == LENSOPT_RUNNING) o->end = LENSOPT_ENDED_CANCELLED;
    lensopt__unlock(&o->gate);
}

LENSOPT_API lflare_result lensopt_search_status(lensopt_search *o, lensopt_progress *out)
{
    if (o == NULL || out == NULL || !lensopt__take(o)) return LFLARE_ERROR_ARGUMENT;
    lensopt__report(o, out);
    lensopt__give(o);
    return LFLARE_OK;
}

/* -- results -- */

static int lensopt__by_rank(const void *left, const void *right)
{
    const lensopt__rank *a = (const lensopt__rank *)left, *b = (const lensopt__rank *)right;
    if (a->f != b->f) return a->f < b->f ? -1 : 1;
    if (a->island != b->island) return a->island < b->island ? -1 : 1;
    return a->member < b->member ? -1 : a->member > b->member;
}

static const double *lensopt__ranked(const lensopt_search *o, const lensopt__rank *r)
{
    const lensopt__setup *s = &o->setup;
    const lensopt__island *p = &o->island[r->island];
    return r->member < s->population ? p->x + lensopt__points(s, r->member) : p->archive_x + lensopt__points(s, r->member - s->population);
}

/* Members and champions, best first; how many. */
static int32_t lensopt__rank_all(lensopt_search *o)
{
    int32_t i, k, count = 0;
    for (i = 0; i < o->islands; i++) {
        const lensopt__island *p = &o->island[i];
        for (k = 0; k < o->setup.population + p->archived; k++) {
            lensopt__rank *r = &o->ranks[count];
            if (k < o->setup.population && !p->born) continue;
            r->f = k < o->setup.population ? p->f[k] : p->archive_f[k - o->setup.population];
            r->island = i;
            r->member = k;
            count++;
        }
    }
    qsort(o->ranks, (size_t)count, sizeof o->ranks[0], lensopt__by_rank);
    return count;
}

LENSOPT_API lflare_result lensopt_search_points(lensopt_search *o, double *x, double *f, int32_t *count)
{
    int32_t i, k, all, found = 0;
    if (o == NULL || count == NULL || *count < 0 || (x == NULL && *count > 0) || !lensopt__take(o)) return LFLARE_ERROR_ARGUMENT;
    all = lensopt__rank_all(o);
    for (i = 0; i < all && found < *count && o->ranks[i].f < HUGE_VAL; i++) {
        const double *point = lensopt__ranked(o, &o->ranks[i]);
        for (k = i - 1; k >= 0 && o->ranks[k].f == o->ranks[i].f && memcmp(point, lensopt__ranked(o, &o->ranks[k]), sizeof *point * (size_t)o->setup.n) != 0; k--) {}
        if (k >= 0 && o->ranks[k].f == o->ranks[i].f) continue; /* a copy: copies have the same value */
        lensopt__copy(&o->setup, x + lensopt__points(&o->setup, found), point);
        if (f != NULL) f[found] = o->ranks[i].f;
        found++;
    }
    *count = found;
    lensopt__give(o);
    return LFLARE_OK;
}

/* -- checkpoints -- */

enum { LENSOPT__CHECKPOINT_VERSION = 3 };

/* Visits the state word by word: writes it (to), reads it (from), only checks what would be read (from, dry), or only counts (neither). */
typedef struct lensopt__store {
    uint8_t *to;
    const uint8_t *from;
    size_t at;
    int dry, bad;
} lensopt__store;

/* What is written, or was read. */
static uint64_t lensopt__word(lensopt__store *t, uint64_t v)
{
    int k;
    if (t->to != NULL) {
        for (k = 0; k < 8; k++) t->to[t->at + (size_t)k] = (uint8_t)(v >> 8 * k);
    } else if (t->from != NULL) {
        for (k = 0, v = 0; k < 8; k++) v |= (uint64_t)t->from[t->at + (size_t)k] << 8 * k;
    }
    t->at += 8;
    return v;
}

/* Keeps a count within its range; returns it as it is written or read, and puts it into *v unless that is dry. */
static int64_t lensopt__store_count(lensopt__store *t, int64_t *v, int64_t low, int64_t high)
{
    uint64_t word = lensopt__word(t, (uint64_t)*v);
    int64_t count = word <= (uint64_t)INT64_MAX ? (int64_t)word : -1;
    t->bad |= count < low || count > high;
    if (!t->dry) *v = count;
    return count;
}

static int32_t lensopt__store_count32(lensopt__store *t, int32_t *v, int32_t high)
{
    int64_t wide = *v, count = lensopt__store_count(t, &wide, 0, high);
    *v = (int32_t)wide;
    return (int32_t)(count >= 0 && count <= high ? count : 0);
}

/* Numbers in [low, high], which are `period` numbers each, again and again; low NULL: any that is one. */
static void lensopt__store_doubles(lensopt__store *t, double *v, size_t count, const double *low, const double *high, size_t period)
{
    size_t k;
    for (k = 0; k < count; k++) {
        uint64_t bits;
        double value;
        memcpy(&bits, &v[k], sizeof bits);
        bits = lensopt__word(t, bits);
        memcpy(&value, &bits, sizeof value);
        if (low != NULL) t->bad |= !(value >= low[k % period] && value <= high[k % period]);
        if (!t->dry) memcpy(&v[k], &value, sizeof value);
    }
}

static void lensopt__store_island(lensopt__store *t, const lensopt__setup *s, lensopt__island *o, int32_t round)
{
    static const double none = -1.7976931348623157e308, most = HUGE_VAL, factor[2] = {0, 4}, share = 1;
    const int64_t many = (int64_t)1 << 52;
    size_t points = lensopt__points(s, s->population), extra = s->d.method == LENSOPT_PSO ? points : s->d.method == LENSOPT_JDE ? 2 * (size_t)s->population : 0;
    const double *low = s->lower, *high = s->upper, *f_low = &none;
    int64_t evaluations;
    uint64_t random = lensopt__word(t, o->random);
    int32_t archived;
    if (!t->dry) o->random = random;
    evaluations = lensopt__store_count(t, &o->evaluations, 0, many);
    lensopt__store_count(t, &o->used, 0, evaluations);
    lensopt__store_count(t, &o->life, 0, many);
    lensopt__store_count32(t, &o->units, round);
    lensopt__store_count(t, &o->restarts, 0, many);
    lensopt__store_count(t, &o->stale, 0, many);
    archived = lensopt__store_count32(t, &o->archived, LENSOPT_ARCHIVE);
    if (!lensopt__store_count32(t, &o->born, 1)) low = f_low = NULL; /* what is there is moved into the bounds first, or not read */
    lensopt__store_doubles(t, &o->mark, 1, f_low, &most, 1);
    lensopt__store_doubles(t, o->success, LENSOPT__MOVES, low != NULL ? &factor[0] : NULL, &share, 1);
    lensopt__store_doubles(t, o->x, points, low, high, (size_t)s->n);
    lensopt__store_doubles(t, o->f, (size_t)s->population, f_low, &most, 1);
    lensopt__store_doubles(t, o->extra, extra, s->d.method == LENSOPT_PSO || low == NULL ? low : &factor[0], s->d.method == LENSOPT_PSO ? high : &factor[1],
                           s->d.method == LENSOPT_PSO ? (size_t)s->n : 1);
    if (s->d.method == LENSOPT_PSO) lensopt__store_doubles(t, o->extra + points, points, low != NULL ? s->slowest : NULL, s->fastest, (size_t)s->n);
    lensopt__store_doubles(t, o->archive_x, lensopt__points(s, archived), s->lower, s->upper, (size_t)s->n);
    lensopt__store_doubles(t, o->archive_x + lensopt__points(s, archived), lensopt__points(s, LENSOPT_ARCHIVE - archived), NULL, NULL, 1);
    lensopt__store_doubles(t, o->archive_f, (size_t)archived, &none, &most, 1);
    lensopt__store_doubles(t, o->archive_f + archived, (size_t)(LENSOPT_ARCHIVE - archived), NULL, NULL, 1);
}

/* "lensopt" as a number, a version, what it must agree with, and the state. */
static void lensopt__store_search(lensopt__store *t, lensopt_search *o)
{
    int32_t i;
    lensopt__word(t, 0x0074706f736e656cu);
    lensopt__word(t, LENSOPT__CHECKPOINT_VERSION);
    lensopt__word(t, o->hash);
    lensopt__store_count(t, &o->rounds, 0, (int64_t)1 << 52);
    for (i = 0; i < o->islands; i++) lensopt__store_island(t, &o->setup, &o->island[i], o->round);
}

static size_t lensopt__checkpoint_size(lensopt_search *o)
{
    lensopt__store t;
    memset(&t, 0, sizeof t);
    t.dry = 1;
    lensopt__store_search(&t, o);
    return t.at + 8;
}

static uint64_t lensopt__checksum(const uint8_t *bytes, size_t size)
{
    uint64_t sum = 0xcbf29ce484222325u;
    lensopt__hash(&sum, bytes, size);
    return sum;
}

LENSOPT_API lflare_result lensopt_search_save(lensopt_search *o, void *bytes, size_t *size)
{
    lensopt__store t;
    size_t room;
    if (o == NULL || size == NULL || (bytes == NULL && *size > 0) || !lensopt__take(o)) return LFLARE_ERROR_ARGUMENT;
    room = *size;
    *size = lensopt__checkpoint_size(o);
    if (room >= *size) {
        memset(&t, 0, sizeof t);
        t.to = (uint8_t *)bytes;
        lensopt__store_search(&t, o);
        lensopt__word(&t, lensopt__checksum(t.to, t.at));
    }
    lensopt__give(o);
    return room < *size ? LFLARE_INCOMPLETE : LFLARE_OK;
}

static lflare_result lensopt__load(lensopt_search *o, const void *bytes, size_t size, lflare_error *error)
{
    lensopt__store t;
    uint64_t magic, version, hash;
    memset(&t, 0, sizeof t);
    t.from = (const uint8_t *)bytes;
    t.dry = 1;
    if (size < 32) return lensopt__fail(error, LFLARE_ERROR_SYNTAX, "a checkpoint of a search was expected, but that is only %i bytes", (int)size);
    magic = lensopt__word(&t, 0);
    version = lensopt__word(&t, 0);
    hash = lensopt__word(&t, 0);
    if (magic != 0x0074706f736e656cu) return lensopt__fail(error, LFLARE_ERROR_SYNTAX, "that is no checkpoint of a search");
    if (version != LENSOPT__CHECKPOINT_VERSION)
        return lensopt__fail(error, LFLARE_ERROR_SYNTAX, "a checkpoint of version %i was expected, this is of another", LENSOPT__CHECKPOINT_VERSION);
    t.at = size - 8;
    if (lensopt__word(&t, 0) != lensopt__checksum(t.from, size - 8)) return lensopt__fail(error, LFLARE_ERROR_SYNTAX, "the checkpoint is damaged or cut off: its checksum is wrong");
    if (hash != o->hash || size != lensopt__checkpoint_size(o))
        return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "the checkpoint is of another search: other variables, bounds, starts, method or numbers");
    t.at = 0;
    lensopt__store_search(&t, o);
    if (t.bad) return lensopt__fail(error, LFLARE_ERROR_SYNTAX, "the checkpoint is damaged: it holds numbers that no search can have");
    t.at = 0;
    t.dry = 0;
    lensopt__store_search(&t, o);
    o->end = LENSOPT_RUNNING;
    o->elapsed = 0;
    lensopt__sum_up(o);
    o->begun = o->evaluations;
    return LFLARE_OK;
}

LENSOPT_API lflare_result lensopt_search_load(lensopt_search *o, const void *bytes, size_t size, lflare_error *error)
{
    lflare_result result;
    if (o == NULL || (bytes == NULL && size > 0)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a search and the bytes of a checkpoint were expected, not NULL");
    if (!lensopt__take(o)) return lensopt__fail(error, LFLARE_ERROR_ARGUMENT, "a search that does not run was expected");
    result = lensopt__load(o, bytes, size, error);
    lensopt__give(o);
    return result;
}

/* >> 14 coatings */

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
    int32_t done = 0, slow = 0, unknown = *f == HUGE_VAL;
    if (steps <= 0) return 0;
    if (unknown) lensopt__coat_evaluate(user, x, 1, f);
    s = lensopt__coat_slopes_make(c);
    if (s.value == NULL) return unknown;
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
    return unknown + done * 2 * LENSOPT__COAT_LANES;
}

/* -- making -- */

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

/* How far a ghost of the lens is, whose spots are given, from what one of the target should be, mm^2. */
static double lensopt__coat_off(const lensopt_target *t, const lensopt_ghost *ghost, const lensopt_goal *spots)
{
    double cost = 0, weights = 0;
    int32_t i;
    for (i = 0; i < t->light_count; i++) {
        double x = ghost->goals[i].centre - spots[i].centre, y = ghost->goals[i].radius - spots[i].radius;
        weights += t->lights[i].weight;
        if (ghost->goals[i].wish == LENSOPT_SPOT) cost += t->lights[i].weight * (spots[i].wish == LENSOPT_SPOT ? fmin(x * x + y * y, 1e8) : 1e8);
    }
    return weights > 0 ? cost / weights : 0;
}

/* match: of each ghost of the target the lens's ghost, -1: none. By spots, for those whose entry is -1; taken says which of the lens's are. */
static lflare_result lensopt__coat_match_spots(lensopt_coatings *c, const lensopt_coatings_desc *desc, double iris, const lflare_pair *pairs, int32_t count, const char *taken, int32_t *match)
{
    const lensopt_target *t = desc->target;
    lensopt_goal spots[LENSOPT_MAX_LIGHTS];
    lensopt__assignment a;
    int32_t rows[LENSOPT_MAX_GHOSTS], row_count = 0, i, k;
    size_t size;
    void *block;
    for (i = 0; i < t->ghost_count; i++)
        if (match[i] < 0 && lensopt__coat_has_spot(t, &t->ghosts[i])) rows[row_count++] = i;
    size = lensopt__assignment_size(row_count, count);
    block = c->allocate(c->user, NULL, 0, size);
    if (block == NULL) return LFLARE_ERROR_MEMORY;
    lensopt__assignment_in(block, row_count, count, &a);
    for (k = 0; k < count; k++) {
        if (!taken[k]) lensopt__coat_goals(desc, iris, pairs[k], spots);
        for (i = 0; i < row_count; i++) a.cost[(size_t)i * (size_t)a.stride + (size_t)k] = taken[k] ? HUGE_VAL : lensopt__coat_off(t, &t->ghosts[rows[i]], spots);
    }
    for (i = 0; i < row_count; i++) a.none[i] = 1e9; /* any ghost is better than none */
    lensopt__assignment_solve(&a);
    for (i = 0; i < row_count; i++) match[rows[i]] = a.column_of[i];
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
    allocate = desc->allocate != NULL ? desc->allocate : lensopt__libc_realloc;
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
