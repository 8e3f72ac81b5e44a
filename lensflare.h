/* lensflare.h - v0.1.0 - physically based lens flares from the prescriptions of real lenses
   Choose either of two licences, MIT or the Unlicense; both stand at the end of this file.

   Do this in *one* C or C++ file to create the implementation, and include it plainly everywhere else:

       #define LENSFLARE_IMPLEMENTATION
       #include "lensflare.h"

   Optional, before that line; they act on the implementation only:

       LFLARE_STATIC           every function static
       LFLARE_API              your own linkage, __declspec(dllexport) say
       LFLARE_ASSERT(x)        guards the library's own mistakes, never your input; default: nothing
       LFLARE_NO_STDIO         leaves out lflare_file_read and the include of <stdio.h>
       LFLARE_NO_SOFTWARE      leaves out the room "software"
       LFLARE_NO_GL            leaves out the room "gl"
       LFLARE_NO_TRACE         leaves out the room "trace", traced ghosts, ghosts across the stop and of four reflections: fits of
                               the others made elsewhere are still loaded and drawn
       LFLARE_NO_ABERRATION    leaves out the polynomial model: room "aberration", fitting, meshes
       LFLARE_NO_DIFFRACTION   leaves out the room "diffraction": starbursts, masks

   Needs libc and libm. No globals, no output, no exit. All lengths are millimetres, angles radians, wavelengths
   nanometres, unless a name says otherwise. */

/* >> 0 documentation */
/*
   CONTENTS (the lines that begin each room; grep for "[>]>")

       >> 0 documentation
       >> 1 public interface
       >> 2 text
       >> 3 glass
       >> 4 paraxial
       >> 5 lens
       >> 6 ghosts
       >> 7 coating
       >> 8 iris
       >> 9 diffraction
       >> 10 aberration
       >> 11 trace
       >> 12 tables
       >> 13 frame
       >> 14 software
       >> 15 gl
       >> 16 object
       >> 17 licence

   QUICK EXAMPLE (a test extracts, compiles and runs it)

   @example
       #define LENSFLARE_IMPLEMENTATION
       #include "lensflare.h"
       #include <stdio.h>
       #include <stdlib.h>

       int main(void)
       {
           static const char heliar[] =
               "lensflare 1\n"
               "name    Heliar\n"
               "fnumber 3.5\n"
               "sensor  36 24\n"
               "#radius  gap     medium               clear semi-diameter\n"
               " 30.81   7.702   nd 1.6511  vd 58.6   semi 14.5  coating quarter 550\n"
               "-89.35   1.849   nd 1.60266 vd 38.4   semi 14.5\n"
               "580.38   3.521   air                  semi 14.5  coating quarter 520\n"
               "-80.63   1.849   nd 1.64282 vd 47.9   semi 12.3  coating quarter 480\n"
               " 28.34   4.625   air                  semi 11.5  coating quarter 550\n"
               "  stop   2.554                        semi 11.6\n"
               "  flat   1.849   nd 1.58241 vd 40.6   semi 12.3  coating quarter 520\n"
               " 32.19   7.271   nd 1.69347 vd 53.5   semi 12.3\n"
               "-52.99   focus   air                  semi 12.3  coating quarter 550\n";
           enum { W = 640, H = 360 };
           lflare_desc desc = {0};
           lflare_view view = {0};
           lflare_light sun = {{0.17f, 0.09f, -1.0f}, {1.0f, 1.0f, 1.0f}, {0}, 0.00465f, 0, 0};
           lflare_image image = {0};
           lflare *flare = NULL;
           lflare_error error;

           desc.text = heliar;
           desc.text_size = sizeof heliar - 1;
           if (lflare_create(&desc, &flare, &error) < 0) {
               fprintf(stderr, "line %d, column %d: %s\n", (int)error.line, (int)error.column, error.text);
               return 1;
           }
           view.width = W;
           view.height = H;
           image.width = W;
           image.height = H;
           image.pixels = (float *)calloc(W * H, 4 * sizeof(float));

           lflare_frame(flare, &view, &sun, 1);      // every frame: lights and view to instances
           lflare_render(flare, &image);             // or upload tables and instances to a GPU of your own
           printf("%d ghosts drawn\n", (int)lflare_get_frame(flare)->instance_count);

           free(image.pixels);
           lflare_destroy(flare);
           return 0;
       }
   @end

   THE THREE VERBS

       prepare     once per lens: ghosts, matrices, clipping circles, films          (in lflare_create)
       configure   when f-number, iris, overrides or exposure change                 (lflare_configure, or in slices)
       frame       every frame: lights and view to instances; allocates nothing      (lflare_frame)

   The object `lflare` strings together pure stages over plain structs, each of which you may call yourself:

       lflare_text_read -> lflare_lens_derive -> lflare_tables_prepare -> lflare_tables_configure
                                             \-> lflare_ghost_* , lflare_film_*, for optics users and editors
       -> lflare_frame_build -> lflare_footprint_resolve -> lflare_software_rows

   THE PRESCRIPTION FORMAT

   Lines end in LF, CR LF or CR; a '#' starts a comment; blanks and tabs separate words; numbers are written with a
   point whatever the locale. The first statement is the version.

       file      = { [ statement | row ] [ "#" comment ] newline }
       statement = "lensflare" "1"            first, required
                 | "name"   text              texts reach to the end of the line, '#' included
                 | "patent" text              number and claimant
                 | "source" text              where the numbers come from
                 | "fnumber" N                the full opening
                 | "sensor" WIDTH HEIGHT      mm
       row       = RADIUS GAP { option }      a surface, from the front; RADIUS > 0 bulges towards the light
                 | "stop" GAP [ "semi" MM ]   the iris, flat, in the medium of the row above it; exactly one
       RADIUS    = N | "flat"
       GAP       = N | "focus"                to the next row; the last one to the sensor, "focus" puts it in focus
       option    = medium                     the medium behind the surface; none = air
                 | "glass" NAME               a label for the medium, not looked up
                 | "semi" MM                  clear semi-diameter; missing ones are derived
                 | "conic" K                  conic constant (0 = sphere, -1 = paraboloid)
                 | "asphere" { POWER ":" N }  even terms N r^POWER of the sag, POWER 2 to 16
                 | "coating" "none" | "coating" "quarter" NM | "coating" "stack" { N ":" NM }
                                              films from the front side; quarter: one layer of index max(sqrt(n1 n2), 1.38)
       medium    = "air" | "n" N | "nd" N "vd" N                      constant; Cauchy fit to index and Abbe number
                 | "sellmeier" B1 B2 B3 C1 C2 C3 | "cauchy" A B [C]   um^2; n = A + B/l^2 + C/l^4, l in um

   ORIENTATION

   Camera space is GL's: x right, y up, looking along -z. Light travels along +z in the lens. A light in direction d has
   the slope u = (d.x/d.z, d.y/d.z); its image lies at EFL u on the sensor, and the picture is the sensor turned by 180
   degrees. A light up and to the right appears up and to the right.

   THE MODEL (sources: Lee & Eisemann 2013 = LE; Hullin et al. 2011 = H; project notes = P with their section)

   A ghost is a pair of surfaces (first, second), second in front of first, on one side of the stop. Two kinds more may be asked for
   (lflare_desc.paths): pairs with the stop between them, whose light passes it three times, and four reflections, of which those that
   lay most light on the frame are kept. Where a path crosses the stop more than once the blades shape one crossing, the one that clips
   first on the axis; at the others the iris clips as its circumscribed circle. Per wavelength two
   2x2 matrices carry an entrance point r (on the plane of the first vertex) and slope u to the stop, a = Ma11 r +
   Ma12 u, and to the sensor, s = M11 r + M12 u (LE 3). Every crossing k of the path clips: |A_k r + B_k u| <= h_k (P 3).
   All clipping circles have their centres on the line through the axis and the light, hence two facts used throughout:
     - a ghost is lit for slopes 0 <= |u| < u_hidden and for no others: one number per ghost culls it;
     - seen along that line, y^2 + x^2 is a lower envelope of straight lines, so area, centroid and binding circles of
       the footprint are exact and need no search.
   Irradiance is E cos(theta) W / M11^2, W the product of film reflectances and transmittances along the ray through the
   centroid of the footprint (P 3, 5). Small ghosts keep a least size, and lamps soften edges by their own size (P 3).

   The polynomial model takes a fit, made once per lens from exact rays by lflare_aberration_fit and stored: per ghost, at
   twelve field angles, polynomials of the entrance point for the places on sensor, stop and rims and for W. A frame does not
   evaluate them. Configure samples them over what the iris leaves open, on rings of vertices that end where iris or rims
   cut; a frame interpolates these meshes between field angles and draws them in patches of one size, an instance each.
   Irradiance is W times entrance area over sensor area: at a vertex, or, where a map turns over (caustics) and where a ghost is of
   few pixels, of the triangle that is drawn, so that its power stays whatever its shape.

   The traced model (H 4) needs no fit. Configure looks with exact rays for what the iris leaves open, per ghost and wavelength at twelve
   field angles: the outline on the entrance, in polar coordinates. A frame lays rings of vertices over it and traces each of them
   anew, from `steps`, `surface` and `film`, with neighbours for its irradiance; clipping is by interpolated heights (P 7). One mesh serves
   all wavelengths: where a vertex lands the others' heights are found to first order from one more ray of each. Where that is wrong by over a
   pixel, or the map turns over, each has its own. Between two field angles meshes have as many rings and directions as the map there bends; where
   what is open is ragged (in pieces, or it jumps), rims are everywhere.

   More than three wavelengths (settings.wavelengths; P 10). Places and heights at each are made of those at three by a parabola in 1 / lambda^2,
   W is known for each over the ghost's bundle. One mesh for all is drawn once: what rims cut is added up wavelength by wavelength per pixel. Each
   edge is softened as far as it moves from one wavelength to the next, so that they blend.

   Diffraction (H 3.3, P 9). The light's own image is the iris's power spectrum, folded over the spectrum: kept as means over
   logarithms of the distance and what angles have over them, in units of wavelength times f-number, so that no f-number makes it
   anew, spikes go on as far as a frame reaches, and a lamp's size is a level of blur. Its energy is that of the light through the
   pupil. Edges of ghosts carry the fringes of a straight edge, of length sqrt(lambda |M11 c| / 2) where the edge's image moves by c a
   radian, washed out by lamp and pixel; where edges meet their shares are multiplied, which comes within 3 % of the integral (rms) down to Fresnel
   number 50 and 6 % at 12 (make fringes). Masks (dust, scratches, gratings, images) serve starburst and ghosts alike; in ghosts their marks
   have fringes too, from pictures made beforehand.

   THE TABLES, BY LIFETIME (all float; every row is a whole number of RGBA32F texels, so a GPU reads it with texelFetch)

       lens      head      ghost:  3 x (Ma11 Ma12 M11 M12), one per wavelength; (reflections, rims, steps)     64 bytes
       lens      rims      ghost:  LFLARE_MAX_RIMS x 3 x (A B h surface), h 0: the iris again             576 bytes
       lens      film      surface: 128 x (R at 3 wavelengths, 0) over cos(theta) in the rarer medium     2048 bytes
       lens      index     surface: index behind it at 3 wavelengths
       lens      surface   surface: vertex, curvature, rim, conic and aspheric terms                             48 bytes
       settings  field     ghost:  LFLARE_FIELD_SAMPLES x 2 x (W_r W_g W_b centroid)(radius turn0 turn2 binding) 2048 bytes
       settings  style     ghost:  (tint rgb, scale)(move along, move across, field angle where hidden, 1/that)
                           (shift x, y, mm; stops of its ramp, 0), 8 x (rgb, field angle)                 176 bytes
       settings  cull      active ghosts, strongest first: bounds, for the CPU's loop                       28 bytes
       settings  mesh_head ghost: (first texel, directions, rings, diffraction)(hidden angle, bits, meshes, texels a knot)
       settings  mesh      ghost: 12 or 23 angles x 2 texels of the whole, then 5 a vertex, or 3 channels x 3    80 KB to 1.9 MB
       settings  outline   ghost: for traced rays, 12 field angles x 17 directions x 3 wavelengths                12.7 KB
       settings  steps     ghost: the surfaces that its traced rays meet, in order                             32 bytes each
       settings  spectrum  ghost: 12 field angles x (centre, half axes)(W over the bundle) of up to 33 wavelengths 7.1 KB
       settings  films     surface: 128 x R at up to 33 wavelengths                                              16.9 KB
       settings  blades    (normal x y, distance, arc radius) per blade
       settings  mask      what stands in the iris besides: 512 x 512 bytes and its halves                    350 KB
       settings  fringed   the mask as diffraction shows it: 25 pictures of 256 x 256 and their halves        2.2 MB
       settings  starburst 168 distances x 1536 columns of angles, 15 x 193 of discs; halves on a GPU         4.2 MB
       lens      ringing   an edge's fringes: 16 blurs x 256 places across it                                16 KB
       frame     lights    64 bytes each
       instance            ghost, light, patch, band: four 16-bit numbers                                    8 bytes

   BUDGETS

   lflare_settings.vertex_budget and pixel_budget hold for a frame: what lflare_gl_draw runs for its ghosts (undistorted 52 vertices, else 72 a
   patch; fragments of one sample, insides and rims; starbursts and streaks are not counted, lflare_gl_draw_half shades a quarter). Fragments are
   estimated from each ghost's area within the frame: all together within 5 % wide open, up to 12 % where lamps or fringes widen meshes that fold.
   Each light has a share in proportion to its brightness, and what it does not need goes to the others. Within it ghosts come strongest first;
   traced ones give up density (half the rings, then half the directions) before the weakest are left out, but for a tenth of what is left of the budget;
   one that does not fit is left out, and smaller ones after it may still be drawn. So a budget is used but for less than the smallest ghost left out.
   Nothing pops where areas change as lights move: a ghost that gets near the limit fades out over a twentieth of the budget, and those that take
   the place of one left out fade in as it gets farther from fitting. Numbers of vertices do change in steps, where a ghost comes into the frame and where
   a light crosses one of a traced ghost's field angles: there the weakest ghosts, or the density of one, may change at once. ghost_budget and
   min_flux count ghosts and so choose, too, at once when a stronger ghost leaves the frame. Cost a ghost and light: vertices 15 to 25 ns more, pixels 250 to 400. Ignored
   where LFLARE_NO_SOFTWARE, _GL, _ABERRATION and _TRACE leave nobody to draw.

   LIMITS

   128 rows, 1024 layers in all, 65,535 ghosts, 65,535 lights as fixed at creation, pictures of any size. Rotationally
   symmetric refracting lenses. Two reflections on one side of the stop; on request across it, and at most 256 ghosts of four.

   GL STATE

   The lflare_gl functions touch this state and, unless no_restore is set, put it back as it was found (a test compares each
   value): BLEND, DEPTH_TEST, STENCIL_TEST, CULL_FACE, SCISSOR_TEST, RASTERIZER_DISCARD, SAMPLE_ALPHA_TO_COVERAGE,
   SAMPLE_COVERAGE; not in ES (where 3.1 has it too, leave it off) SAMPLE_MASK, COLOR_LOGIC_OP, PRIMITIVE_RESTART, CLIP_DISTANCE0, CLIP_DISTANCE1, CLIP_DISTANCE2, CLIP_DISTANCE3,
   CLIP_DISTANCE4, CLIP_DISTANCE5, CLIP_DISTANCE6, CLIP_DISTANCE7, POLYGON_MODE; COLOR_WRITEMASK, BLEND_SRC_RGB,
   BLEND_DST_RGB, BLEND_SRC_ALPHA, BLEND_DST_ALPHA, BLEND_EQUATION_RGB, BLEND_EQUATION_ALPHA, CURRENT_PROGRAM,
   VERTEX_ARRAY_BINDING, ARRAY_BUFFER_BINDING, UNIFORM_BUFFER_BINDING, PIXEL_UNPACK_BUFFER_BINDING, UNPACK_ALIGNMENT,
   UNPACK_SWAP_BYTES (not in ES), UNPACK_ROW_LENGTH, UNPACK_SKIP_ROWS, UNPACK_SKIP_PIXELS, in WebGL alone UNPACK_FLIP_Y_WEBGL and
   UNPACK_PREMULTIPLY_ALPHA_WEBGL, DRAW_FRAMEBUFFER_BINDING, VIEWPORT, ACTIVE_TEXTURE; 2D texture and sampler of units 0 to 5; uniform buffer 0 with its range.
   lflare_gl_draw and lflare_gl_add_half leave framebuffer, viewport and scissor to the caller and so never change them; with
   no_restore lflare_gl_draw_half and lflare_gl_occlusion leave their own bound. Colour mask and blending are those of draw
   buffer 0, put back to all draw buffers. sRGB encoding on write stays the caller's. No transform feedback may be active.

   THREADS

   No function touches anything but its arguments. Different objects may be used by different threads at once, and one
   object's const functions too (lflare_render_rows after lflare_render_begin).
*/

#ifndef LENSFLARE_H
#define LENSFLARE_H

/* >> 1 public interface */

#include <stddef.h>
#include <stdint.h>

#define LFLARE_VERSION 100 /* major * 10000 + minor * 100 + patch */

#ifndef LFLARE_API
#if defined(LFLARE_STATIC) && defined(__GNUC__)
#define LFLARE_API static __attribute__((unused)) /* what the program does not call is not worth a warning */
#elif defined(LFLARE_STATIC)
#define LFLARE_API static
#elif defined(__cplusplus)
#define LFLARE_API extern "C"
#else
#define LFLARE_API extern
#endif
#endif

enum {
    LFLARE_MAX_SURFACES = 128, /* rows of a prescription, the stop counted */
    LFLARE_MAX_LAYERS = 1024,  /* coating layers of a prescription, all surfaces together */
    LFLARE_MAX_BLADES = 16,
    LFLARE_MAX_EDGES = 5,      /* of a drawn footprint: the iris and the four rims that bind most for its light */
    LFLARE_MAX_RIMS = 12,      /* clipping circles kept per ghost, pupil and iris not counted; those that bind most */
    LFLARE_MAX_CIRCLES = 5 * LFLARE_MAX_SURFACES + 2, /* of a path: a rim per crossing */
    LFLARE_MAX_FOUR = 256,     /* ghosts of four reflections */
    LFLARE_MAX_STOPS = 5,      /* crossings of the stop by one path */
    LFLARE_MAX_NOTES = 160,
    LFLARE_WAVELENGTHS = 3,    /* at which lenses are known */
    LFLARE_MAX_WAVELENGTHS = 32, /* of which pictures are made, if settings ask for more: in between, and beyond, the three are interpolated */
    LFLARE_SPECTRUM_ROWS = 37, /* of a ghost's colours at a field angle */
    LFLARE_FIELD_SAMPLES = 64, /* of a ghost's colour and footprint over the field angle */
    LFLARE_FILM_SAMPLES = 128,
    LFLARE_HEAD_FLOATS = 16,
    LFLARE_RIM_FLOATS = 12,    /* of one rim: 3 x (A B h surface) */
    LFLARE_FIELD_FLOATS = 8,   /* of one sample */
    LFLARE_RAMP_STOPS = 8,
    LFLARE_STYLE_FLOATS = 12 + 4 * LFLARE_RAMP_STOPS,
    LFLARE_MESH_HEAD_FLOATS = 8,
    LFLARE_SURFACE_FLOATS = 12,
    LFLARE_OUTLINE_KNOTS = 12,   /* field angles at which traced ghosts' outlines are kept; */
    LFLARE_OUTLINE_SIDES = 17,   /* directions, over half a turn */
    LFLARE_OUTLINE_FLOATS = LFLARE_WAVELENGTHS * (4 + LFLARE_OUTLINE_KNOTS * (20 + 4 * LFLARE_OUTLINE_SIDES)),
    LFLARE_STEP_FLOATS = 8,
    LFLARE_PATCH_DIRECTIONS = 9, /* vertices of a patch of a mesh: round its inside and its rim, */
    LFLARE_PATCH_RINGS = 5,      /* outwards in the inside, */
    LFLARE_PATCH_BANDS = 3       /* and in the rim */
};

/* 0 done, positive partial, negative failed. */
typedef enum lflare_result {
    LFLARE_OK = 0,
    LFLARE_INCOMPLETE = 1,        /* the array was too small, *count says what is needed; or more steps remain */
    LFLARE_ERROR_SYNTAX = -1,     /* the text is not a prescription: see line and column */
    LFLARE_ERROR_LENS = -2,       /* readable, but no lens: no stop, no focal length, ... */
    LFLARE_ERROR_ARGUMENT = -3,   /* an argument is NULL, out of range or not finite */
    LFLARE_ERROR_MEMORY = -4,     /* an allocation failed; nothing leaked, nothing changed */
    LFLARE_ERROR_FILE = -5,       /* the file cannot be read */
    LFLARE_ERROR_LIMIT = -6,      /* more lights than were asked for, or than a draw takes */
    LFLARE_ERROR_GL = -7,         /* a GL function or version is missing, or a shader fails: see the error's text and the log */
    LFLARE_ERROR_FIT = -8         /* not a fit, damaged, of another version or of another lens: see the error's text */
} lflare_result;

/* What went wrong and where. `line` and `column` count from 1, columns in bytes; 0 where there is no text to point at. */
typedef struct lflare_error {
    lflare_result code;
    int32_t line, column;
    char text[200]; /* one sentence, no line break, zero-terminated */
} lflare_error;

/* realloc-shaped: block NULL allocates, new_size 0 frees (and returns NULL). Both sizes are always right. */
typedef void *(*lflare_realloc)(void *user, void *block, size_t old_size, size_t new_size);

/* ---- prescriptions ---- */

typedef enum lflare_medium_kind {
    LFLARE_MEDIUM_AIR = 0,   /* 1 exactly; prescriptions give indices relative to air */
    LFLARE_MEDIUM_CONSTANT,  /* c[0] = n */
    LFLARE_MEDIUM_ABBE,      /* c[0] = nd, c[1] = Vd */
    LFLARE_MEDIUM_SELLMEIER, /* c[0..2] = B, c[3..5] = C in um^2 */
    LFLARE_MEDIUM_CAUCHY     /* c[0] + c[1]/l^2 + c[2]/l^4, l in um */
} lflare_medium_kind;

typedef struct lflare_medium {
    lflare_medium_kind kind;
    double c[6];
    char glass[24]; /* a label, "" for none */
} lflare_medium;

typedef struct lflare_layer {
    double n, thickness_nm;
} lflare_layer;

typedef enum lflare_coating_kind { LFLARE_COATING_NONE = 0, LFLARE_COATING_QUARTER, LFLARE_COATING_STACK } lflare_coating_kind;

typedef struct lflare_surface {
    double radius;         /* signed, 0 = flat; positive bulges towards the light */
    double thickness;      /* gap to the next row, the last one to the sensor; >= 0 */
    double semi_diameter;  /* clear radius; 0 = derive it */
    double conic;
    double aspheric[8];    /* coefficients of r^2, r^4 ... r^16 */
    lflare_medium medium;  /* behind the surface; ignored for the stop, which keeps the medium in front of it */
    lflare_coating_kind coating;
    double quarter_nm;     /* LFLARE_COATING_QUARTER: design wavelength */
    int32_t first_layer, layer_count; /* LFLARE_COATING_STACK: into prescription.layers, from the front side */
    int32_t is_stop;
    int32_t line;          /* where it stood in the text, 0 if nowhere */
} lflare_surface;

/* Plain data, about 43 KB, copied by assignment. All zeroes is a valid start for one made by hand. */
typedef struct lflare_prescription {
    char name[96], patent[96], source[256];
    double fnumber;                      /* full opening; 0 = derive it from the stop */
    double sensor_width, sensor_height;  /* 0 = 36 x 24 */
    int32_t focus;                       /* 1: the last gap is derived so that the sensor is in focus */
    int32_t surface_count, layer_count;
    lflare_surface surfaces[LFLARE_MAX_SURFACES];
    lflare_layer layers[LFLARE_MAX_LAYERS];
} lflare_prescription;

/* Reads `size` bytes of text (no terminating zero needed; text may be NULL if size is 0). Any bytes are safe. On error
   *out is unspecified and *error (may be NULL) says where. Syntax and ranges of single numbers are checked here, the
   lens as a whole by lflare_lens_derive. Linear in size, allocates nothing. */
LFLARE_API lflare_result lflare_text_read(const char *text, size_t size, lflare_prescription *out, lflare_error *error);

/* Writes the prescription so that lflare_text_read gives back the same values, to the bit. *size holds the room in
   `text` on entry and the bytes needed on return, without a terminating zero, of which none is written. Returns
   LFLARE_INCOMPLETE if there was too little room (what fits is written; text may be NULL if *size is 0). */
LFLARE_API lflare_result lflare_text_write(const lflare_prescription *prescription, char *text, size_t *size);

/* The library's own locale-free numbers. Reads all of `size` bytes as one number: 1 if it is one (`*out` infinite if too
   large), 0 if not. Writes the shortest decimal that reads back the same; `out` holds at least 32 bytes; returns its length. */
LFLARE_API int32_t lflare_number_read(const char *text, size_t size, double *out);
LFLARE_API int32_t lflare_number_write(double value, char *out);

/* Index of refraction at a wavelength (P 4). From nd and Vd: n = A + B/l^2 through the lines F and C. */
LFLARE_API double lflare_index(const lflare_medium *medium, double nm);

/* What one wavelength adds to linear sRGB, by the CIE's observer of 1931, interpolated from steps of 5 nm; 0 beyond 380 to 780 nm, negative where
   sRGB lacks the colour. Not scaled: see P 10. Not if LFLARE_NO_DIFFRACTION and LFLARE_NO_TRACE are both given. */
LFLARE_API void lflare_wavelength_rgb(double nm, double *rgb);

/* ---- lens ---- */

typedef enum lflare_note_kind {
    LFLARE_NOTE_SEMI_DERIVED = 1,  /* value: semi-diameter from marginal and chief ray */
    LFLARE_NOTE_SEMI_REDUCED,      /* value: reduced to this, from `stated`, because the sphere ends there */
    LFLARE_NOTE_STOP_DERIVED,      /* value: stop's semi-diameter, from the f-number or from what the other rims pass */
    LFLARE_NOTE_FNUMBER_DERIVED,   /* value: f-number of the full stop */
    LFLARE_NOTE_FNUMBER_LIMITED,   /* value: the f-number that the stop's semi-diameter allows, where `stated` is faster */
    LFLARE_NOTE_SENSOR_ASSUMED,    /* value: width of the sensor that was assumed */
    LFLARE_NOTE_FOCUS_DERIVED,     /* value: last gap, the paraxial back focal distance */
    LFLARE_NOTE_OUT_OF_FOCUS,      /* value: back focal distance, where `stated` is the last gap; over 0.5 % of EFL apart */
    LFLARE_NOTE_EDGES_CROSS        /* value: thickness at the edge between this surface and the next, negative */
} lflare_note_kind;

typedef struct lflare_note {
    lflare_note_kind kind;
    int32_t surface; /* from 0, -1 if the lens as a whole */
    double value, stated;
} lflare_note;

/* [a b; c d] acting on (height, slope) in the unfolded frame: path length always positive. */
typedef struct lflare_matrix {
    double a, b, c, d;
} lflare_matrix;

/* Which light paths are ghosts, besides those of two reflections on one side of the stop. All zeroes: no others. */
typedef struct lflare_paths {
    int32_t across_stop; /* 1: ghosts whose reflections have the stop between them, too, which so pass it three or five times */
    int32_t four;        /* most ghosts of four reflections, those that lay most light on the frame: see lflare_lens_paths; 0 = none */
} lflare_paths;

/* Surfaces that reflect, from 0, in the order of time: the second in front of the first, the third behind the second, the fourth in
   front of the third. Two reflections: third and fourth are 0. Tables for people count from 1. */
typedef struct lflare_pair {
    int32_t first, second, third, fourth;
} lflare_pair;

/* A validated lens in which nothing is missing. Plain data. */
typedef struct lflare_lens {
    lflare_prescription prescription; /* with every derived value filled in */
    double curvature[LFLARE_MAX_SURFACES]; /* at the vertex, r^2 term included */
    int32_t surface_count, stop;      /* stop: index from 0 */
    double efl, bfd, fnumber;         /* at the d line; fnumber: the full opening that the stop allows */
    double stop_a11;                  /* height at the stop per height at the entrance, direct path, d line */
    double sensor_width, sensor_height;
    int32_t ghost_count;
    lflare_paths paths;               /* which these are: see lflare_lens_paths */
    int32_t four_count;               /* ghosts of four reflections, ordered by their surfaces */
    lflare_pair four[LFLARE_MAX_FOUR];
    int32_t note_count;               /* what was derived or looks odd */
    lflare_note notes[LFLARE_MAX_NOTES];
} lflare_lens;

/* Checks a prescription and derives what is missing: sensor, focus, stop from the f-number or the reverse, clear
   semi-diameters from the paraxial marginal ray and the chief ray to the sensor's corner (half the beam passes there).
   Allocates nothing; O(surfaces^2). *error may be NULL. Its ghosts have two reflections on one side of the stop. */
LFLARE_API lflare_result lflare_lens_derive(const lflare_prescription *prescription, lflare_lens *out, lflare_error *error);

/* Chooses which paths of a derived lens are ghosts: everything that follows takes them from the lens, so this comes first; tables and
   fits made before no longer belong to it. paths NULL is as all zeroes. `four` is 0 to LFLARE_MAX_FOUR and, where across_stop is 0, counts
   paths on one side of the stop alone. Kept are those of most flux on the frame: paraxially, on the axis, at 510 nm and f/8 (or the full
   opening, if that is less), W times the area that is open over what it spreads to, the frame at least; of equals (to a float) those of the
   lower surfaces. Allocates nothing; 3 ms at 34 surfaces, 0.2 s at most: lenses of a hundred surfaces that are all much alike have more paths than
   that allows to look at. With LFLARE_NO_TRACE there are none of these. On error the lens stays as it
   is; error may be NULL. */
LFLARE_API lflare_result lflare_lens_paths(lflare_lens *lens, const lflare_paths *paths, lflare_error *error);

/* One sentence about a note; `out` of `size` bytes is always terminated if size > 0. Returns out. */
LFLARE_API const char *lflare_note_text(const lflare_note *note, char *out, size_t size);
LFLARE_API const char *lflare_result_text(lflare_result result);

/* From the vertex of the first surface to just behind the last, without the last gap: EFL = -1/c, BFD = -a/c (P 2). */
LFLARE_API lflare_matrix lflare_system_matrix(const lflare_lens *lens, double nm);

/* Sag at height r, NaN beyond the surface's end. */
LFLARE_API double lflare_sag(const lflare_surface *surface, double r);

/* ---- ghosts ---- */

/* All pairs of surfaces with an index step (P 3) on one side of the stop, or as lflare_lens_paths has it, ordered by first, then
   second; behind them the lens's ghosts of four reflections. *count: room in `out` on entry, number of ghosts on return;
   LFLARE_INCOMPLETE if there was too little. out may be NULL if *count is 0. What follows takes any path of four reflections, in the
   list or not, and across the stop if lens->paths.across_stop is set. */
LFLARE_API lflare_result lflare_ghost_list(const lflare_lens *lens, lflare_pair *out, int32_t *count);

typedef struct lflare_ghost_matrices {
    lflare_matrix ma, ms, m; /* entrance to stop (see lflare_crossing.iris), stop to sensor, entrance to sensor */
} lflare_ghost_matrices;

/* Matrices of `count` ghosts at one wavelength; O(surfaces + count) when the pairs are in the list's order, and O(surfaces) each for
   those of four reflections and across the stop. */
LFLARE_API lflare_result lflare_ghost_optics(const lflare_lens *lens, double nm, const lflare_pair *pairs, int32_t count,
                                             lflare_ghost_matrices *out);

typedef struct lflare_crossing {
    int32_t surface;
    int32_t backwards; /* 1 from behind the first reflection up to the second, that included, and again from the third to the fourth */
    int32_t reflected;
    int32_t iris;      /* 1 where the blades shape the ghost: of all crossings of the stop the one whose image on the entrance is smallest (at
                          the d line), and so clips first. At others the iris clips as a round rim, its circumscribed circle */
    double a, b;       /* height here = a r + b u */
    double p, q;       /* tangent of the paraxial angle of incidence = |p r + q u| (P 5) */
    double n_in, n_out;/* indices on the side the ray comes from and on the other side */
} lflare_crossing;

/* Every crossing of a ghost's path in order, those of the stop included. *count as in lflare_ghost_list; at most
   5 * LFLARE_MAX_SURFACES. */
LFLARE_API lflare_result lflare_ghost_path(const lflare_lens *lens, double nm, lflare_pair pair, lflare_crossing *out, int32_t *count);

/* Circles |x - centre u| <= radius, all on one line (in entrance mm along the light's direction). */
typedef struct lflare_circle {
    double centre, radius;
} lflare_circle;

typedef struct lflare_region {
    double area, centroid;  /* of the intersection; if it is empty 0 and the middle of the gap, kept within the first circle */
    double lo, hi;          /* its ends on the line */
} lflare_region;

/* Intersection of circles with their centres at centre*u, exact. `turn` (may be NULL, else one per circle) receives the
   angle through which the boundary turns along each circle, 0 where it does not bind. 1 <= count <= LFLARE_MAX_CIRCLES. */
LFLARE_API lflare_region lflare_region_of(const lflare_circle *circles, int32_t count, double u, double *turn);

typedef enum lflare_clip { LFLARE_CLIP_IRIS, LFLARE_CLIP_PUPIL, LFLARE_CLIP_BOTH, LFLARE_CLIP_RIM, LFLARE_CLIP_HIDDEN } lflare_clip;

/* What bounds a ghost for slope u >= 0 and a round iris of radius `iris` (P 3), and the exact footprint on the entrance. Where the stop is
   crossed more than once LFLARE_CLIP_IRIS speaks of the crossing that blades shape, LFLARE_CLIP_RIM of the others, too. */
LFLARE_API lflare_clip lflare_ghost_clip(const lflare_lens *lens, double nm, lflare_pair pair, double iris, double u, lflare_region *region);

/* ---- coating ---- */

/* Power reflectance of a stack between media n0 and n1, unpolarised, exact thin-film interference (characteristic
   matrix). `s` = n0 sin(theta0), the same on both sides; layers from the n0 side, NULL if count is 0. T = 1 - R.
   Total reflection gives 1. (P 5; Born & Wolf 1.6) */
LFLARE_API double lflare_film_reflectance(double n0, double n1, const lflare_layer *layers, int32_t count, double nm, double s);

/* The layers of a surface from its front side; *count room on entry, number on return. A quarter-wave coating gives one. */
LFLARE_API lflare_result lflare_film_layers(const lflare_lens *lens, int32_t surface, lflare_layer *out, int32_t *count);

/* Exact W of a ghost along the paraxial ray through entrance point x (mm along the light's direction) with slope u >= 0: the
   product of its reflectances and transmittances at one wavelength (P 3, 5). Irradiance is E cos(theta) W / M11^2. */
LFLARE_API double lflare_ghost_weight(const lflare_lens *lens, double nm, lflare_pair pair, double x, double u);

/* ---- iris ---- */

/* One edge of the iris on the stop plane, in units of the iris's radius. Straight: inside is n.a <= distance. Curved:
   |a + n distance| <= arc. */
typedef struct lflare_blade {
    float nx, ny, distance, arc; /* arc 0 = straight */
} lflare_blade;

typedef struct lflare_iris {
    float radius;        /* of the circumscribed circle, on the stop plane */
    float area;          /* open area over that of the circumscribed circle: 0.757 for five straight blades */
    float roundness;     /* share of the turning of its outline that is on arcs: 1 round, 0 straight blades */
    float softness;      /* edges fade over so much on either side, in radii; 0 = sharp */
    int32_t blade_count; /* 0 = round */
    lflare_blade blades[LFLARE_MAX_BLADES];
    const uint8_t *mask; /* of LFLARE_MASK_BYTES, multiplies what blades leave open; NULL = none: see lflare_iris_set_mask */
    int32_t dark_outline; /* 1: the mask lets nothing through next to the blades or the circumscribed circle: they have no fringes */
    const uint8_t *fringed; /* of LFLARE_FRINGED_BYTES, the mask as ghosts show it; NULL = as it is: see lflare_fringed_begin */
} lflare_iris;

/* Iris at f-number N: radius min(|A11| EFL / 2N, the stop's own) (P 6); N = 0 is the lens's. blades 0 or 3 to 16; rotation
   turns the first vertex from +x; curvature 0 straight to 1 round. *fnumber (may be NULL) gets the effective f-number. */
LFLARE_API lflare_result lflare_iris_make(const lflare_lens *lens, double fnumber, int32_t blades, double rotation, double curvature,
                                          lflare_iris *out, double *fnumber_effective);

/* Masks: bytes of a picture of LFLARE_MASK_SIZE x LFLARE_MASK_SIZE and of its halves down to one texel, one after the other. */
enum { LFLARE_MASK_SIZE = 512, LFLARE_MASK_LEVELS = 10 };
#define LFLARE_MASK_BYTES (((size_t)4 * LFLARE_MASK_SIZE * LFLARE_MASK_SIZE - 1) / 3)

/* Power that passes at a point of the stop plane, in units of the iris's radius; edges fade over +-soft besides its softness. Not with
   LFLARE_NO_DIFFRACTION. */
LFLARE_API float lflare_iris_transmission(const lflare_iris *iris, float x, float y, float soft);

/* ---- diffraction (not with LFLARE_NO_DIFFRACTION) ---- */

enum {
    LFLARE_MAX_MASK = 4096,         /* of a caller's image for it, either way */
    LFLARE_MAX_MARKS = 4096,        /* specks of dust, or scratches */
    LFLARE_STARBURST_ROWS = 168,    /* distances, LFLARE_STARBURST_OCTAVE to a doubling, from 1/16 on */
    LFLARE_STARBURST_OCTAVE = 14,
    LFLARE_STARBURST_BINS = 512,    /* angles of half a turn: the other half is the same */
    LFLARE_STARBURST_LEVELS = 7,    /* of blur: none; over about a bin; then each twice as far, in half as many bins */
    LFLARE_STARBURST_COLUMNS = 1536,/* all levels' bins with their neighbours round the corner, then the row's mean twice */
    LFLARE_STARBURST_SIZES = 15,    /* radii of discs, doubling, from 1/8 on */
    LFLARE_STARBURST_SAMPLES = 193  /* of a disc, from its middle to 6 radii, 32 to a radius */
};

/* What stands in the iris besides its blades. All zeroes: nothing. */
typedef struct lflare_mask_desc {
    const float *pixels;      /* grey image of the share of power that passes, 0 to 1, top row first; its longer side spans the iris's
                                 circumscribed circle, beyond the shorter one nothing passes. NULL: none */
    int32_t width, height;    /* at most LFLARE_MAX_MASK */
    int32_t dust_count;       /* round specks */
    float dust_size;          /* mean radius, in radii of the iris; 0 = 0.01 */
    int32_t scratch_count;
    float scratch_length;     /* mean, in radii; 0 = 0.5 */
    float scratch_width;      /* 0 = 0.006 */
    float scratch_angle, scratch_spread; /* mean direction and how far it varies either way, radians; spread 0 = all alike, pi/2 = any */
    float grating_lines;      /* across the iris; 0 = none */
    float grating_depth, grating_angle; /* share of power that a line takes away; direction across the lines */
    uint32_t seed;            /* of dust and scratches: the same seed, the same marks */
} lflare_mask_desc;

/* Whether such a mask can be made; error (may be NULL) says what is wrong. Reads every pixel. */
LFLARE_API lflare_result lflare_mask_check(const lflare_mask_desc *desc, lflare_error *error);

/* Rows begin <= row < end (from -y up) of the mask of a checked desc, LFLARE_MASK_SIZE bytes each, into out, which is row 0. 255 =
   all passes. 2 to 6 us a row, and 3 ns a pixel of the image that falls on it. */
LFLARE_API void lflare_mask_rows(const lflare_mask_desc *desc, uint8_t *out, int32_t begin, int32_t end);

/* Puts a mask of LFLARE_MASK_BYTES, of which the largest picture's rows are made, into an iris that has none, which points to it from
   then on and whose open area it reduces; makes the smaller pictures. LFLARE_ERROR_ARGUMENT if nothing passes. 0.6 ms. */
LFLARE_API lflare_result lflare_iris_set_mask(lflare_iris *iris, uint8_t *mask);

/* The image that a point of light gets from diffraction at an iris (Fraunhofer; H 3.3, P 9), for white light of the same power at all
   wavelengths, linear sRGB, of flux 1 in each channel. Lengths are in units of 550 nm times the f-number (EFL over the diameter of
   the entrance pupil's circumscribed circle), so that one table serves all f-numbers. It holds the mean over angles of each
   distance, what angles differ from it by, and discs convolved with the mean. */
typedef struct lflare_starburst {
    float *angular;           /* [ROWS][COLUMNS][4] */
    float *radial;            /* [SIZES][SAMPLES][4]: square roots of the flux within a disc of the blur's radius */
    float tail[3];            /* mean times distance^3 where the table ends, and on */
    float peak;               /* of an angle over the mean, anywhere */
    int32_t size;             /* of the transform */
    uint64_t key;             /* of the iris's shape; 0 = not made */
} lflare_starburst;

/* Floats of its two tables, to be allocated as one block. */
#define LFLARE_STARBURST_FLOATS \
    ((size_t)4 * (LFLARE_STARBURST_ROWS * LFLARE_STARBURST_COLUMNS + LFLARE_STARBURST_SIZES * LFLARE_STARBURST_SAMPLES))

/* Under way. Plain data; its contents are the library's. */
typedef struct lflare_starburst_job {
    const lflare_iris *iris;
    lflare_starburst *out;
    float *amplitude, *core, *half, *power, *line, *spectrum, *raw, *row; /* working memory */
    int32_t size, across, phase, next;
    float kernel[LFLARE_WAVELENGTHS][20];
    double energy, flux[LFLARE_WAVELENGTHS];
} lflare_starburst_job;

/* Tells irises apart that need different starbursts: by shape, not by radius. Never 0. 50 us with a mask. */
LFLARE_API uint64_t lflare_starburst_key(const lflare_iris *iris);

/* Bytes of working memory for a transform of size x size, a power of two from 512 to 4096, of which the iris spans half: its detail
   reaches to 0.35 times that half, farther out the pattern goes on as it ends. 1024: 4.2 MB. 0 for other sizes. */
LFLARE_API size_t lflare_starburst_bytes(int32_t size);

/* Begins; `tables` holds LFLARE_STARBURST_FLOATS, `work` as many bytes as above; both and the iris must stay until the last step. Then
   step, `slices` of at most 0.2 ms at a time (size 1024), until it no longer returns LFLARE_INCOMPLETE. */
LFLARE_API lflare_result lflare_starburst_begin(const lflare_iris *iris, int32_t size, float *tables, void *work, lflare_starburst *out,
                                                lflare_starburst_job *job);
LFLARE_API lflare_result lflare_starburst_step(lflare_starburst_job *job, int32_t slices);

/* A mask as ghosts show it: its marks have Fresnel's fringes (P 9), the coarser the lower the ghost's Fresnel number. A picture for each of
   LFLARE_FRINGED_VIEWS lengths of fringes (lflare_edge.ring), falling by 2^0.2 from 0.4, which is Fresnel number 3, to 0.0144, 2400;
   five in a row from -y up, then all of them at half the size down to one texel each. Bytes: 127.5 is the light of the open iris. */
enum { LFLARE_FRINGED_SIZE = 256, LFLARE_FRINGED_ACROSS = 5, LFLARE_FRINGED_VIEWS = 25, LFLARE_FRINGED_LEVELS = 9, LFLARE_FRINGED_WIDTH = LFLARE_FRINGED_SIZE * LFLARE_FRINGED_ACROSS };
#define LFLARE_FRINGED_BYTES (((size_t)4 * LFLARE_FRINGED_WIDTH * LFLARE_FRINGED_WIDTH - LFLARE_FRINGED_VIEWS) / 3)

/* Bytes of working memory: 3.4 MB. */
#define LFLARE_FRINGED_WORK_BYTES (sizeof(float) * ((size_t)13 * LFLARE_FRINGED_SIZE * LFLARE_FRINGED_SIZE + (size_t)14 * LFLARE_FRINGED_SIZE + 2))

/* Under way. Plain data; its contents are the library's. */
typedef struct lflare_fringed_job {
    const uint8_t *mask;
    uint8_t *out;
    float *spectrum, *field, *light, *line, *roots, *factors; /* working memory */
    int32_t phase, next;
} lflare_fringed_job;

/* Begins with a whole mask of LFLARE_MASK_BYTES; `out` and `work` have the sizes above; all three must stay until the last step. Then
   step, `slices` of 0.1 to 0.5 ms at a time, until it no longer returns LFLARE_INCOMPLETE. 0.25 s in all. Edges of the mask at the
   iris's circumscribed circle count as going on beyond it. */
LFLARE_API lflare_result lflare_fringed_begin(const uint8_t *mask, uint8_t *out, void *work, lflare_fringed_job *job);
LFLARE_API lflare_result lflare_fringed_step(lflare_fringed_job *job, int32_t slices);

/* Fringes of edges: LFLARE_RINGING_BLURS rows of LFLARE_RINGING_SAMPLES, the share of light across an edge, for blurs of the edge up to
   8 fringe lengths (lflare_edge.soft over .ring), from 2.5 lengths and the blur outside to 5 and the blur inside. 3 ms. */
enum { LFLARE_RINGING_SAMPLES = 256, LFLARE_RINGING_BLURS = 16, LFLARE_RINGING_FLOATS = LFLARE_RINGING_SAMPLES * LFLARE_RINGING_BLURS };
LFLARE_API void lflare_ringing_make(float *out);

/* Irradiance at a distance (x, y) from the light's image, of a point of light blurred by a disc of radius `blur` > 0; all in the
   table's units. About 60 ns. */
LFLARE_API void lflare_starburst_at(const lflare_starburst *starburst, float x, float y, float blur, float *rgb);

/* ---- trace (not with LFLARE_NO_TRACE) ---- */

enum { LFLARE_MAX_STEPS = 5 * LFLARE_MAX_SURFACES };

/* A surface as a path meets it. */
typedef struct lflare_step {
    int32_t surface, backwards, reflected, iris; /* as in lflare_crossing */
    double z;                        /* of the vertex, from that of the first surface */
    double n_in, n_out, eta;         /* eta: n_in / n_out */
    double n_front, n_behind;        /* of the media on its two sides */
    double curvature, semi;          /* 1 / radius, 0 = flat; clear semi-diameter */
    int32_t polynomial;              /* the surface has aspheric terms */
    const lflare_layer *layers;      /* from the front side; NULL: the one below */
    lflare_layer quarter;
    int32_t layer_count;
} lflare_step;

/* A way through the lens at one wavelength, ready to trace many rays. About 77 KB; points into the lens, which must outlive it. */
typedef struct lflare_path {
    const lflare_lens *lens;
    double nm, sensor_z;
    int32_t step_count, unweighted;  /* unweighted: 1 leaves weights out (set it after lflare_path_make), which is faster */
    lflare_step steps[LFLARE_MAX_STEPS];
} lflare_path;

typedef enum lflare_fate {
    LFLARE_RAY_ARRIVES = 0,
    LFLARE_RAY_MISSES,               /* a surface, or the sensor, altogether */
    LFLARE_RAY_TOTAL                 /* total reflection where it should pass */
} lflare_fate;

typedef struct lflare_hit {
    int32_t surface, backwards, reflected;
    double position[3];              /* mm, z from the vertex of the first surface */
    double direction[3];             /* unit vector after the surface */
    double relative;                 /* distance from the axis over the clear semi-diameter */
    double cosine;                   /* of the angle of incidence */
    double share;                    /* of the power that goes on: reflectance or transmittance */
} lflare_hit;

typedef struct lflare_ray {
    lflare_fate fate;
    int32_t steps;                   /* crossings met, and so hits written */
    double sensor[2], stop[2];       /* mm; stop: where blades shape the path, see lflare_crossing.iris */
    double stops[LFLARE_MAX_STOPS][2]; /* each crossing of the stop in order, mm: light passes an iris that is open at all of them */
    int32_t stop_count;
    double direction[3];             /* unit vector at the sensor */
    double relative;                 /* largest of all surfaces but the stop: above 1 a rim stops the ray */
    int32_t widest;                  /* the surface where that is */
    double weight;                   /* product of the shares of the surfaces met; 0 if the path is unweighted */
} lflare_ray;

/* The path of a ghost, or with pair NULL of the image. */
LFLARE_API lflare_result lflare_path_make(const lflare_lens *lens, double nm, const lflare_pair *pair, lflare_path *out);

/* One exact ray from a point of the plane z = 0 (mm) with slope (dx/dz, dy/dz). Surfaces are met strictly in the path's order on
   the sheet that holds the vertex, even where that means going back a little (H 3; P 7); rims stop nothing, see
   lflare_ray.relative. Aspheres by Newton's method. hits (may be NULL): room for path->step_count. About 40 ns a crossing, with
   weights as much again and 100 ns a layer. */
LFLARE_API lflare_fate lflare_path_trace(const lflare_path *path, const double entrance[2], const double slope[2], lflare_ray *out, lflare_hit *hits);

/* ---- aberrations ---- */

enum { LFLARE_FIT_RIMS = 6 };

/* What fitting may be told. All zeroes is fine. */
typedef struct lflare_aberration_desc {
    int32_t (*progress)(void *user, int32_t done, int32_t count); /* after each ghost; anything but 0 stops it; may be NULL */
    lflare_realloc allocate; /* NULL = libc's */
    void *user;              /* of both */
} lflare_aberration_desc;

/* Fits polynomials to exact rays of every ghost (P 8), once per lens: 7 to 15 ms a ghost. *fit is allocated, *size bytes long, free
   it with the same callback: a block of bytes to store, to load at any address and to give to lflare_desc. Takes 14 MB while it works, of which
   most lenses touch half.
   LFLARE_INCOMPLETE if `progress` stopped it, with nothing left behind. desc and error may be NULL. Not with LFLARE_NO_TRACE. */
LFLARE_API lflare_result lflare_aberration_fit(const lflare_lens *lens, const lflare_aberration_desc *desc, void **fit, size_t *size, lflare_error *error);

/* Whether a fit is whole, of this version, and of this lens; error (may be NULL) says what is wrong. Any bytes are safe. What
   follows may then read it. 0.1 ms a megabyte. */
LFLARE_API lflare_result lflare_aberration_check(const lflare_lens *lens, const void *fit, size_t size, lflare_error *error);

/* What a fit says of a ray, as lflare_ray would. */
typedef struct lflare_fitted_ray {
    float sensor[2], stop[2];       /* mm */
    float rims[LFLARE_FIT_RIMS][2]; /* where it meets the rims that clip, in units of their clear radii */
    int32_t rim_count;
    float weight;
} lflare_fitted_ray;

/* From a checked fit: the ray of a ghost (index in lflare_ghost_list) at wavelength k of the tables' three, from a point of the
   plane z = 0 with a slope. LFLARE_INCOMPLETE: outside what was fitted, or hidden (then all zeroes). About 1.3 us. */
LFLARE_API lflare_result lflare_aberration_ray(const void *fit, int32_t ghost, int32_t k, const double entrance[2], const double slope[2],
                                               lflare_fitted_ray *out);

/* ---- settings, views, lights ---- */

typedef enum lflare_model {
    LFLARE_MODEL_AUTO = 0,   /* polynomial if there is a fit, else paraxial */
    LFLARE_MODEL_PARAXIAL,   /* undistorted ghosts (LE 3) */
    LFLARE_MODEL_POLYNOMIAL, /* near enough to exact rays; needs a fit */
    LFLARE_MODEL_TRACED      /* exact rays, traced at every vertex in each frame (H 4); needs no fit; configuring it takes 5 to 15 ms a ghost.
                                Not with LFLARE_NO_TRACE */
} lflare_model;

/* A stop of a ghost's ramp of colours: what multiplies its tint when the light is at that field angle. */
typedef struct lflare_stop {
    float rgb[3], angle; /* negative counts as 0; radians from the axis */
} lflare_stop;

/* Changes one ghost, by its surfaces counted from 1 as in tables and patents. */
typedef struct lflare_override {
    int32_t first, second;
    int32_t hide;
    float tint[3];  /* all 0 = white */
    float ev;       /* stops of intensity */
    float scale;    /* size about its own centroid, irradiance kept; 0 = 1 */
    float move[2];  /* along the line from the picture's centre to the light, and to the left of it, as a fraction of the
                       distance of the light's own image */
    int32_t ramp_count; /* stops in use, angles rising; between two of them linear, before the first and after the last as they are. Of several overrides
                           of one ghost the last one with a ramp holds */
    lflare_stop ramp[LFLARE_RAMP_STOPS];
    int32_t third, fourth; /* of four reflections; 0 0 = there are two */
} lflare_override;

/* The horizontal streak of anamorphic lenses, an element of its own and the artist's: it has no place in a rotationally symmetric
   lens. All zeroes: none. */
typedef struct lflare_streak {
    float share;               /* of the light's flux through the entrance pupil that goes into it */
    float length;              /* from end to end, in widths of the sensor; 0 = 2 */
    float thickness;           /* likewise; 0 = 0.004 */
    float tint[3];             /* all 0 = white */
} lflare_streak;

/* All zeroes is the lens as it is: full opening, round iris, every ghost, normalised exposure. */
typedef struct lflare_settings {
    double fnumber;
    lflare_model model;
    int32_t blades;
    float blade_rotation, blade_curvature;
    int32_t raw;               /* 1: irradiance in multiples of the light's; 0: times a constant of the lens, such that a white
                                  light halfway to the frame's side adds about LFLARE_NORMAL_MEAN on average at f/8 */
    float exposure_ev;         /* stops on top of either */
    int32_t ghost_budget;      /* most ghosts per light, strongest first; 0 = all */
    float min_flux;            /* leaves out ghosts whose peak flux is below this fraction of all ghosts' sum */
    int32_t wavelengths;       /* of meshes and traced ghosts: 4 to LFLARE_MAX_WAVELENGTHS from 400 to 700 nm, blended into each other; 0 or 3: those three at
                                  which channels are. Ghosts that are split by wavelength are drawn as many times.
                                  Not with LFLARE_NO_TRACE */
    int32_t vertex_budget;     /* most vertices and pixels (fragments) of a frame's ghosts, as lflare_gl_draw runs them: see BUDGETS; 0 = no limit */
    int32_t pixel_budget;
    float imperfection;        /* elements stand off the axis by up to so much of their clear radius: 0.001 a good lens, 0.01 a bad one; 0 = perfect,
                                  at most 0.1. Each of its ghosts moves off the mirror line by a constant on the sensor, on the axis too (see lflare__shift) */
    uint32_t imperfection_seed;/* the same one, the same lens */
    int32_t paper_clipping;    /* 1: only front rim and iris clip, as in Lee & Eisemann 2013 */
    float iris_softness;       /* edges of the iris fade over so much on either side, in its radii: 0 to 0.5 */
    lflare_mask_desc mask;     /* what stands in the iris besides; its image is read until configure is complete */
    int32_t no_ringing;        /* 1: ghosts' edges without diffraction's fringes. With them undistorted ghosts brighter than a twentieth of
                                  all ghosts' mean irradiance have some, and all meshes */
    int32_t no_starburst;
    int32_t starburst_size;    /* of its transform: see lflare_starburst_bytes; 0 = 1024 */
    float starburst_scale;     /* of its size, its flux kept; 0 = 1, as it is */
    float starburst_ev;        /* stops of its brightness */
    lflare_streak streak;
    const lflare_override *overrides; /* read during configure only */
    int32_t override_count;
} lflare_settings;

#define LFLARE_NORMAL_MEAN 0.06f
#define LFLARE_NORMAL_FNUMBER 8.0f

typedef enum lflare_fit {
    LFLARE_FIT_WIDTH = 0, /* frame width = sensor width; the light's place in the frame decides its slope */
    LFLARE_FIT_HEIGHT,
    LFLARE_FIT_DIAGONAL,
    LFLARE_FIT_PHYSICAL   /* true slopes: half the frame's height is EFL tan(fov_y / 2) */
} lflare_fit;

typedef struct lflare_view {
    int32_t width, height; /* pixels of the view, > 0; a viewport within a larger target is given as the viewport alone */
    float fov_y;           /* vertical field of view of the camera whose space the lights are in; 0 = the lens's own on this
                              frame, which makes all slopes true */
    lflare_fit fit;
    float centre[2];       /* where the optical axis meets the view, in half-widths and half-heights; 0 0 = the middle */
    float squeeze;         /* as behind an anamorphic attachment that squeezes the picture sideways by this: ghosts and starbursts, made behind
                              it, are as many times as wide as they are high, at their places; 1/8 to 8, 0 = 1, none */
    float edge_fade;       /* a light fades out over so many half-heights beyond the frame's edge; 0 = it does not, as in reality */
} lflare_view;

enum { LFLARE_LIGHT_NO_GHOSTS = 1, LFLARE_LIGHT_NO_STARBURST = 2, LFLARE_LIGHT_NO_STREAK = 4 };

typedef struct lflare_light {
    float direction[3];    /* in camera space, towards the light, any length; z >= 0 (beside or behind the camera) draws nothing */
    float color[3];        /* irradiance at the lens, linear; negative counts as 0 */
    float occlusion[3];    /* 1 - visibility, per channel: 0 all 0 = seen in full, 1 = hidden or absorbed */
    float angular_radius;  /* 0 = a point; the sun: 0.00465 */
    float distance;        /* from the camera, for lflare_gl_occlusion alone, in its projection's units; 0 = infinitely far */
    int32_t flags;
} lflare_light;

/* ---- tables ---- */

/* Bounds of an active ghost on the sensor, all linear in the slope vector. */
typedef struct lflare_cull {
    float hidden_slope;     /* dark from this slope on */
    float along, across;    /* centre = slope * along + slope turned left * across */
    float radius, reach;    /* radius of the bounding disc; growth per radian of angular radius */
    uint32_t ghost;
    uint16_t patches, reserved; /* instances a light; paraxial: 1 */
} lflare_cull;

/* Everything a renderer reads. Pointers are the caller's; see THE TABLES above for the rows. */
typedef struct lflare_tables {
    int32_t ghost_count, surface_count, stop; /* stop: its surface */
    float sensor_z;         /* from the vertex of the first surface, mm */
    float sensor_width, sensor_height, efl, entrance_radius; /* entrance_radius: of the first surface */
    float wavelengths[LFLARE_WAVELENGTHS];
    /* lens: filled by lflare_tables_prepare */
    lflare_pair *pairs;     /* [ghost_count] */
    float *head;            /* [ghost_count * LFLARE_HEAD_FLOATS]; the last four: first + LFLARE_MAX_SURFACES * third, second + that * fourth, rims, first row of steps */
    float *rims;            /* [ghost_count * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS]; h is 0 where the rim is the iris at a crossing that blades do
                               not shape: take the radius of the iris in force */
    float *film;            /* [surface_count * LFLARE_FILM_SAMPLES * 4] */
    float *index;           /* [surface_count * 4]: behind each surface, 0 */
    float *surface;         /* [surface_count * LFLARE_SURFACE_FLOATS]: z of the vertex, curvature, clear semi-diameter, 1 + conic constant; aspheric
                               terms r^2 to r^16 as the sag at the rim that each makes, mm */
    float *transmission;    /* [LFLARE_WAVELENGTHS]: of the lens for the light's own image, on its axis */
    float *ringing;         /* [LFLARE_RINGING_FLOATS]: see lflare_ringing_make; NULL with LFLARE_NO_DIFFRACTION */
    const uint8_t *fit;     /* checked; NULL: there is none */
    /* settings: filled by lflare_tables_configure_* */
    float *field;           /* [ghost_count * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS] */
    float *style;           /* [ghost_count * LFLARE_STYLE_FLOATS] */
    float *mesh_head;       /* [ghost_count * LFLARE_MESH_HEAD_FLOATS]; NULL where there is no fit, or the model is paraxial */
    float *mesh;            /* [mesh_texels * 4] */
    size_t mesh_texels;
    float *outline;         /* [ghost_count * LFLARE_OUTLINE_FLOATS]: where traced ghosts' rays pass; for that model: see lflare_tables_demand */
    float *steps;           /* a row of LFLARE_STEP_FLOATS for each surface that a traced ghost's rays meet, in order, ghost after ghost (the last of its
                               head's floats counts them): way along the axis from the last vertex, mm; curvature, 1 / clear semi-diameter, 1 + conic
                               constant; index before over index behind at three wavelengths; 16 x the surface, + 1 reflects, 2 is the stop, 3 that
                               where it clips as a circle, 4 has aspheric terms, 8 is met backwards */
    int32_t wavelength_count; /* 0: the three alone */
    float spectral[LFLARE_MAX_WAVELENGTHS + 1][8]; /* of each: shares of the three that make its places; nm; what it adds to RGB, 0 */
    float *spectrum;        /* [ghost_count * LFLARE_OUTLINE_KNOTS * LFLARE_SPECTRUM_ROWS * 4], if there are more than three, for field angles: centre and
                               half axes of the bundle on the entrance, 0; W of each wavelength over it, as a parabola: c0 + c1 a + c2 a^2 + c3 b^2, (a, b)
                               in half axes from the centre, a along the light's slope; the same summed to red, green and blue; see lflare_tables_demand */
    float *films;           /* [surface_count * LFLARE_FILM_SAMPLES * (LFLARE_MAX_WAVELENGTHS + 1)]: as `film`, at these; likewise */
    float *rank;            /* [ghost_count * 2]: peak flux; mean irradiance over the frame at the exposure's reference */
    lflare_cull *cull;      /* [ghost_count], the first active_count in use, strongest first */
    int32_t active_count, ghost_budget, vertex_budget, pixel_budget;
    lflare_model model;     /* in force, not LFLARE_MODEL_AUTO */
    int32_t fringes;        /* 1: edges have them */
    float exposure;         /* gain on the lights' colour */
    float mean_irradiance;  /* over the frame, of a light of 1 at the exposure's reference, without exposure */
    float fnumber;          /* effective */
    lflare_iris iris;       /* a mask: set by the caller between configure_begin and configure_range */
    const lflare_starburst *starburst; /* NULL = none; set by the caller before configure_end */
    float starburst_unit;   /* of its distances on the sensor, mm */
    float starburst_gain[LFLARE_WAVELENGTHS]; /* irradiance on the sensor, for a light of 1, over what lflare_starburst_at gives */
    float streak_gain[LFLARE_WAVELENGTHS];    /* flux in the streak for a light of 1, mm^2 */
    float streak_half[2];   /* half of length and thickness, mm; 0 = none */
    uint64_t lens_hash, settings_hash, mesh_hash, mask_hash; /* of head and rims; of field and style; of what the meshes come from;
                               of the iris's mask, 0 without one; by configure_end: upload anew what changed */
} lflare_tables;

/* Bytes of the lens's and of the settings' arrays. Several settings may share one lens part. */
typedef struct lflare_tables_size {
    size_t lens, settings;
} lflare_tables_size;

/* Sets sizes and counts of *out and, where memory is given (16-byte aligned, lflare_tables_size of it; NULL = leave as is),
   the array pointers into it. */
LFLARE_API lflare_tables_size lflare_tables_layout(const lflare_lens *lens, const void *fit, void *lens_memory, void *settings_memory, lflare_tables *out);

/* Prepare: the lens tables of ghosts begin <= g < end, so that slices or threads may share the work; films and indices
   come with begin == 0. Cost: 10 to 15 us a ghost. */
LFLARE_API lflare_result lflare_tables_prepare(const lflare_lens *lens, lflare_tables *tables, int32_t begin, int32_t end);

/* Floats that settings need besides (the traced model's outlines and steps, the colours of more than three wavelengths), and where memory is given
   (16-byte aligned; NULL = leave as is) sets the pointers into it: after prepare, before configure_begin. 0: none. Not
   if LFLARE_NO_ABERRATION and LFLARE_NO_TRACE are both given. */
LFLARE_API size_t lflare_tables_demand(lflare_tables *tables, const lflare_settings *settings, float *memory);

/* Configure, in three parts that may be spread over frames: begin (iris, overrides checked), any number of ranges
   covering all ghosts (50 to 120 us a ghost, with meshes 5 to 25 ms), end (order, normalisation). The lens tables must be whole. */
LFLARE_API lflare_result lflare_tables_configure_begin(const lflare_lens *lens, lflare_tables *tables, const lflare_settings *settings,
                                                       lflare_error *error);
LFLARE_API void lflare_tables_configure_range(const lflare_lens *lens, lflare_tables *tables, const lflare_settings *settings, int32_t begin,
                                              int32_t end);
LFLARE_API void lflare_tables_configure_end(lflare_tables *tables, const lflare_settings *settings);

/* ---- frame ---- */

typedef struct lflare_frame_light {
    float slope[2];        /* (d.x/d.z, d.y/d.z) as the lens sees it */
    float axis[2];         /* slope / |slope|; (1, 0) on the axis */
    float slope_length;
    float field_angle;     /* atan(slope_length) */
    float angular_radius;
    float image[2];        /* the light's own image on the sensor, mm */
    float irradiance[3];   /* color (1 - occlusion) cos(theta), exposure applied */
    int32_t source;        /* index among the caller's lights */
    int32_t flags;
    float starburst;       /* how far from the image the starburst is drawn, mm; 0 = not at all */
    float streak;          /* half its length, mm; 0 = none */
} lflare_frame_light;

typedef struct lflare_instance {
    uint16_t ghost, light, patch, band; /* band, bits 0-3: of traced ghosts, the knot before the light's field angle; 8-9: levels of density given
                                           up; 10-15, of all: intensity given up, in 63rds (see BUDGETS) */
} lflare_instance;

/* What one frame draws. The arrays are the caller's (the object's, if there is one). */
typedef struct lflare_frame_data {
    int32_t width, height;         /* of the view */
    float half_width, half_height; /* of the frame on the sensor, mm */
    float centre[2];               /* sensor point at the view's middle, mm (minus the picture's own centre offset) */
    float pixel_size[2];           /* of a pixel on the sensor, mm: a square unless the view squeezes */
    float pixel;                   /* side of a square of its area */
    lflare_frame_light *lights;
    int32_t light_capacity, light_count;
    lflare_instance *instances;
    int32_t instance_capacity, instance_count;
} lflare_frame_data;

/* Lights in front of the camera become frame lights, their visible ghosts instances, light by light. Fills *frame but for
   the arrays and capacities, which the caller sets: as many lights as given, and lights * active_count instances are always
   enough. Allocates nothing; 5 ns a ghost and light, with budgets of vertices or pixels more: see BUDGETS. */
LFLARE_API lflare_result lflare_frame_build(const lflare_tables *tables, const lflare_view *view, const lflare_light *lights, int32_t light_count,
                                            lflare_frame_data *frame);

/* A visibility that follows `target` without flicker: returns `now` moved towards it by the share 1 - exp(-dt / attack) of the
   way up, or with `release` of the way down; times in seconds, 0 = at once; within 1e-5 it is there, so that a hidden light ends
   up drawing nothing. The same after one second at any frame rate. From
   0.1 s on, a light that leaves hide in every other frame at 60 Hz changes by less than 10 %, what counts as a flash (WCAG 2.3.1). */
LFLARE_API float lflare_fade(float now, float target, float dt, float attack, float release);

/* An edge of a ghost, in units of its own radius: where the sensor point is d away from the footprint's centre[k], the ray
   meets the edge's plane at a = gain[k] d + offset[k] axis; inside is |a| <= 1, fading over +-soft[k]. edges[0] is the iris:
   with blades, the blades in its place. */
typedef struct lflare_edge {
    float gain[LFLARE_WAVELENGTHS], offset[LFLARE_WAVELENGTHS], soft[LFLARE_WAVELENGTHS];
    float ring[LFLARE_WAVELENGTHS]; /* length of diffraction's fringes, 1 / sqrt(2 x Fresnel number); 0: they do not show */
} lflare_edge;

/* A ghost as drawn for one light: what the vertex shader computes, for renderers of your own. */
typedef struct lflare_footprint {
    float axis[2];                           /* unit vector along the light's slope */
    float centre[LFLARE_WAVELENGTHS][2];     /* on the sensor, mm */
    float irradiance[LFLARE_WAVELENGTHS];    /* inside; linear, exposure applied */
    float radius;                            /* bounding, about every centre, soft edges included; mm */
    int32_t fine;                            /* 1: under 4 pixels in radius: edges are meant for 4 x 4 samples a pixel */
    int32_t edge_count;
    lflare_edge edges[LFLARE_MAX_EDGES];
    const float *ringing;                    /* the tables' */
} lflare_footprint;

/* Resolves one instance. Returns 0 if nothing is left to draw. */
LFLARE_API int32_t lflare_footprint_resolve(const lflare_tables *tables, const lflare_frame_data *frame, lflare_instance instance,
                                            lflare_footprint *out);

/* Share of light at a point of the sensor: soft edges, the two that cut most combined by the angle between them. 0 to 1, on fringes up to
   1.4, where two edges meet up to 1.9. */
LFLARE_API float lflare_footprint_coverage(const lflare_footprint *footprint, int32_t channel, const lflare_iris *iris, float x, float y);

/* Edge profile: 0 at -1, 1/2 at the edge, 1 at +1, slope and variance those of a lamp's disc and a pixel together. */
LFLARE_API float lflare_edge_coverage(float t);

/* A vertex of a ghost's mesh, drawn: all is linear between vertices. */
typedef struct lflare_patch_vertex {
    float position[2], entrance[2];        /* on the sensor and on the entrance, mm */
    float irradiance[LFLARE_WAVELENGTHS];  /* linear, exposure applied; to it comes */
    float flux[LFLARE_WAVELENGTHS];        /* times the triangle's area on the entrance over that on the sensor */
    float iris[LFLARE_WAVELENGTHS][2];     /* where the ray meets the iris, in units of its radius */
    float rim[LFLARE_WAVELENGTHS];         /* how far out on the rim that clips first, in units of its clear radius: inside is below 1 */
    float rim_soft;                        /* over which that rim's edge fades on either side, mm on the sensor */
    float rim_ring, iris_ring;             /* length of fringes at that rim and at the iris, likewise */
    float bundle[2];                       /* with more than three wavelengths: place in the bundle, see tables.spectrum */
    float apart;                           /* of meshes for one of many wavelengths: way to the next one's picture, mm; it softens their edges, too */
    float turn, bulge;                     /* counts directions; rims are round: subtract 4 bulge f (1 - f) from `rim`, f being the
                                              fraction of `turn` */
} lflare_patch_vertex;

/* A patch of a mesh for one light. Quads between neighbours, each of two triangles with the diagonal from [k + 1][i] to [k][i + 1]:
   those of `inside` are lit all over, those of `rim` within iris and rims. Triangles may overlap (caustics) and turn over. */
typedef struct lflare_patch {
    int32_t rimmed;                        /* 0: this patch has no rim */
    const float *spectrum;                 /* NULL: channels are red, green and blue. With more than three wavelengths the ghost's rows of tables.spectrum
                                              at the field angle before the light's: channels of what iris and rims cut (with a mask the inside's, too)
                                              are all alike and stand for W = 1; heights at each wavelength are made of the three by tables.spectral, its W
                                              of spectrum, */
    float between;                         /* interpolated to the next field angle's by this; to what it adds to RGB comes */
    float color[3];                        /* the light's colour, exposure applied */
    float iris_soft;                       /* as rim_soft, of the iris */
    lflare_patch_vertex inside[LFLARE_PATCH_RINGS][LFLARE_PATCH_DIRECTIONS], rim[LFLARE_PATCH_BANDS][LFLARE_PATCH_DIRECTIONS];
} lflare_patch;

/* Resolves one instance of tables with meshes: what the vertex shader computes, for renderers of your own. Returns 0 if nothing is
   left to draw. About 8 us. */
LFLARE_API int32_t lflare_patch_resolve(const lflare_tables *tables, const lflare_frame_data *frame, lflare_instance instance, lflare_patch *out);

/* ---- software ---- */

typedef struct lflare_image {
    float *pixels;      /* RGBA, linear; RGB is added to, A left as it is: clear it to 0 for a flare on transparent black */
    int32_t width, height; /* must equal the view's */
    ptrdiff_t stride;   /* floats from one row to the next; 0 = 4 * width. A view inside a larger target: its stride */
    int32_t bottom_up;  /* 1: row 0 is the bottom of the picture */
} lflare_image;

/* Adds the starbursts and streaks of a frame's lights to rows begin <= y < end of the picture. 0.1 us a pixel and light. */
LFLARE_API lflare_result lflare_software_starbursts(const lflare_tables *tables, const lflare_frame_data *frame, const lflare_image *image, int32_t begin,
                                                    int32_t end);

/* Draws rows begin <= y < end of the picture (0 at the top) from footprints[count]. Different rows may be drawn by
   different threads. Allocates nothing, uses 50 KB of stack. */
LFLARE_API lflare_result lflare_software_rows(const lflare_footprint *footprints, int32_t count, const lflare_iris *iris,
                                              const lflare_frame_data *frame, const lflare_image *image, int32_t begin, int32_t end);

/* The same from tables with meshes. */
LFLARE_API lflare_result lflare_software_patches(const lflare_tables *tables, const lflare_frame_data *frame, const lflare_image *image, int32_t begin,
                                                 int32_t end);

/* 8-bit sRGB (or, with srgb 0, linear 8-bit for targets that encode on write) from linear RGBA floats times `gain`,
   clipped; `out` holds 3 * count bytes. */
LFLARE_API void lflare_to_rgb8(const float *rgba, size_t count, float gain, int32_t srgb, uint8_t *out);

/* ---- gl ---- */

enum { LFLARE_GL_MAX_LIGHTS = 232 }; /* of one draw: a uniform block of 16 KB */

/* The shape of glfwGetProcAddress, eglGetProcAddress and OSMesaGetProcAddress: the only door to GL. */
typedef void (*lflare_gl_function)(void);
typedef lflare_gl_function (*lflare_gl_loader)(const char *name);

typedef struct lflare_gl lflare_gl;

typedef struct lflare_gl_desc {
    lflare_gl_loader load;
    int32_t no_restore;      /* 1: a draw makes no glGet and leaves what GL STATE lists changed */
    char *log;               /* receives a failing shader's log; may be NULL */
    size_t log_size;
    lflare_realloc allocate; /* NULL = libc's */
    void *user;
    uint32_t models;         /* 1 << LFLARE_MODEL_... for each that tables will have in force: no others are compiled, or drawn; 0 = all.
                                NVIDIA's driver compiles all for seconds until its cache has them, the paraxial one alone for a sixth of that */
} lflare_gl_desc;

/* With the context current: GL 3.3 core, ES 3.0 or WebGL 2, told apart at run time. On error *out is NULL, no GL object is
   left, *error (may be NULL) names the missing function or version. */
LFLARE_API lflare_result lflare_gl_create(const lflare_gl_desc *desc, lflare_gl **out, lflare_error *error);

/* Adds the frame's flare to the bound framebuffer and viewport: three instanced draws, starbursts with streaks, ghosts' insides and
   rims, whatever the number of lights. A starburst adds at most 30,000 a channel, since half floats end at 65,504. Uploads tables that changed since the last draw (allocating then), else 8 bytes an instance and 64 a light. Never
   reads back, never waits. The target has one colour buffer and is linear (or encodes on write). Half float is best. Where
   float targets cannot be blended 8 bits a channel remain (better sRGB-encoding than linear: a ghost fainter than half a step
   adds nothing, and rounding adds up over ghosts), or lflare_render into a texture. Edges of caustics are antialiased where
   the target has several samples a pixel. */
LFLARE_API lflare_result lflare_gl_draw(lflare_gl *gl, const lflare_tables *tables, const lflare_frame_data *frame);

/* The same for cheap machines, at a quarter of the fragments: draw_half draws into a picture of its own of half the width and
   height, add_half adds that, smoothly enlarged, to the bound framebuffer and viewport (bind them, and your scissor test,
   between the two calls if no_restore is set; a tiled GPU prefers draw_half before the frame's own pass). The picture is RGBA16F; where that cannot be
   drawn to (ES 3.0 without EXT_color_buffer_half_float or _float) RGB10_A2, which ends at 1 as every target there does. The
   first draw of a size allocates it. */
LFLARE_API lflare_result lflare_gl_draw_half(lflare_gl *gl, const lflare_tables *tables, const lflare_frame_data *frame);
LFLARE_API lflare_result lflare_gl_add_half(lflare_gl *gl);

/* How the caller's depth buffer is to be read. */
typedef struct lflare_gl_depth {
    uint32_t texture;       /* of GL, 2D, one sample a texel, with depth; its own sampling parameters do not matter */
    int32_t region[4];      /* x, y, width and height of the view in it, texels; all 0 = the whole texture */
    float projection[16];   /* the camera's, column by column as GL takes it, looking along -z. Reverse-Z and infinite far planes
                               are seen from it */
    int32_t zero_to_one;    /* 1: clip-space depth is 0 to 1 (glClipControl), not -1 to 1 */
    float depth_range[2];   /* glDepthRange; 0 0 = 0 1 */
    float sky_distance;     /* what is farther hides nothing: a skybox; 0 = everything drawn hides a light infinitely far away */
    float bias;             /* what is less than this in front of a light at a finite distance does not hide it: its own housing */
    int32_t samples;        /* over the light's disc, rounded up to a multiple of 4, at most 1024; 0 = 256: within 2 % of the open area */
    float dt, attack, release; /* seconds: see lflare_fade; attack and release 0 = at once */
    int32_t reset;          /* 1: no fade this time (a cut) */
} lflare_gl_depth;

/* Measures on the GPU how much of each light's disc (a texel in radius at least) the depth buffer leaves open, for all draws
   from now on, until called again; depth NULL ends it. Call it once the scene's depth is drawn, before the flare; the texture may
   stay attached to the bound framebuffer. Nothing is read back: it stays in a strip of a texel a light, which the
   ghosts' vertex shader reads and multiplies by. The part of a disc beyond the frame counts like the frame's nearest edge. The
   fade belongs to a light's index: keep it from frame to frame; an index that was not there last time does not fade in. Use one
   lflare_gl a view. At most LFLARE_GL_MAX_LIGHTS lights, which are those given to
   lflare_frame. Cost: one draw of a fragment a light. */
LFLARE_API lflare_result lflare_gl_occlusion(lflare_gl *gl, const lflare_light *lights, int32_t light_count, const lflare_gl_depth *depth);

/* The context is lost: GL is not called any more; destroy and create anew. */
LFLARE_API void lflare_gl_forget(lflare_gl *gl);
LFLARE_API void lflare_gl_destroy(lflare_gl *gl); /* with the context current, unless forgotten; NULL is fine */

/* ---- the object ---- */

typedef struct lflare lflare;

typedef struct lflare_desc {
    const char *text;       /* a prescription's text, or */
    size_t text_size;
    const lflare_prescription *prescription; /* one already read; text is then ignored */
    lflare_paths paths;     /* more ghosts: across the stop, of four reflections */
    const void *fit;        /* of lflare_aberration_fit, for the polynomial model: must outlive the object; NULL = none */
    size_t fit_size;
    lflare_settings settings;
    int32_t max_lights;     /* of a frame; 0 = 16 */
    lflare_realloc allocate; /* NULL = libc's */
    void *user;
} lflare_desc;

/* Parse, derive, prepare and configure. On error *out is NULL, nothing leaks, *error (may be NULL) says why. */
LFLARE_API lflare_result lflare_create(const lflare_desc *desc, lflare **out, lflare_error *error);
LFLARE_API void lflare_destroy(lflare *flare); /* NULL is fine */

/* New settings at once, or in steps: begin, then step (each of as many ghosts, or slices of mask and starburst) until it stops
   returning LFLARE_INCOMPLETE; a failed allocation, or an image for the mask that lflare_mask_check refuses, ends it and leaves the tables
   in use as they are. The starburst is made anew only
   if the iris's shape is neither the one in use nor the one before: an f-number alone does not change it. Frames use the old tables until then; the step that completes them empties the last frame, so step before
   lflare_frame, not after. A begin before that starts over. Overrides are copied. */
LFLARE_API lflare_result lflare_configure(lflare *flare, const lflare_settings *settings, lflare_error *error);
LFLARE_API lflare_result lflare_configure_begin(lflare *flare, const lflare_settings *settings, lflare_error *error);
LFLARE_API lflare_result lflare_configure_step(lflare *flare, int32_t ghosts);

/* Lights and view to instances. Never allocates. */
LFLARE_API lflare_result lflare_frame(lflare *flare, const lflare_view *view, const lflare_light *lights, int32_t light_count);

/* Valid until the next configure, frame or destroy. */
LFLARE_API const lflare_lens *lflare_get_lens(const lflare *flare);
LFLARE_API const lflare_tables *lflare_get_tables(const lflare *flare);
LFLARE_API const lflare_frame_data *lflare_get_frame(const lflare *flare);

/* Draws the last frame into an image: all at once, or begin once and rows from any number of threads. The first begin
   allocates room for the footprints of max_lights lights; later ones nothing. */
LFLARE_API lflare_result lflare_render(lflare *flare, const lflare_image *image);
LFLARE_API lflare_result lflare_render_begin(lflare *flare);
LFLARE_API lflare_result lflare_render_rows(const lflare *flare, const lflare_image *image, int32_t begin, int32_t end);

/* Reads a whole file into memory from `allocate` (NULL = libc's): *out has *size bytes and a zero behind them, which does
   not count; free it with the same callback (old size *size + 1). At most 16 MB. Not with LFLARE_NO_STDIO. */
LFLARE_API lflare_result lflare_file_read(const char *path, lflare_realloc allocate, void *user, char **out, size_t *size, lflare_error *error);

/* The version of the implementation, LFLARE_VERSION. */
LFLARE_API int32_t lflare_version(void);

#endif /* LENSFLARE_H */

/* ---------------------------------------------------------------------------------------------------------------------
   Stop here if you only want to use it. What follows is the implementation, room after room in the data's order; each
   room knows only the rooms above it. */

#ifdef LENSFLARE_IMPLEMENTATION
#ifndef LENSFLARE_IMPLEMENTED
#define LENSFLARE_IMPLEMENTED

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#ifndef LFLARE_NO_STDIO
#include <stdio.h>
#endif

#ifndef LFLARE_ASSERT
#define LFLARE_ASSERT(x) ((void)0)
#endif

/* LFLARE_STATIC leaves declared what a switch leaves undefined, which is not worth a warning. */
#if defined(LFLARE_STATIC) && defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#define LFLARE__PI 3.14159265358979323846
#if !defined(LFLARE_NO_ABERRATION) || !defined(LFLARE_NO_TRACE)
#define LFLARE__PATCHES /* ghosts as patches of triangles */
#endif

/* Small functions of many callers where speed does not matter: inlined they would be a tenth of the smallest build. */
#if defined(__GNUC__)
#define LFLARE__APART __attribute__((noinline))
#else
#define LFLARE__APART
#endif

static double lflare__min(double a, double b) { return a < b ? a : b; }
static double lflare__max(double a, double b) { return a > b ? a : b; }
static double lflare__clamp(double x, double lo, double hi) { return lflare__min(lflare__max(x, lo), hi); }
static float lflare__minf(float a, float b) { return a < b ? a : b; }
static float lflare__maxf(float a, float b) { return a > b ? a : b; }
static int lflare__finite(double x) { return x - x == 0; }
static int lflare__finite3(const float *v) { return lflare__finite((double)v[0] + (double)v[1] + (double)v[2]); }

static void *lflare__libc_realloc(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) { free(block); return NULL; }
    return realloc(block, new_size);
}

/* >> 2 text */
/* Bytes to rows, rows to bytes. No libc conversion is used: they follow the locale and need a terminating zero. */

/* value * 10^e as an unevaluated sum hi + lo of about 100 bits, so that 17 digits survive the way there and back. */
typedef struct lflare__pair_of_doubles {
    double hi, lo;
} lflare__wide;

static lflare__wide lflare__wide_product(double a, double b)
{
    /* Dekker's exact product: halves of 26 bits */
    lflare__wide r;
    double s = a * 134217729.0, t = b * 134217729.0;
    double ah = s - (s - a), bh = t - (t - b), al = a - ah, bl = b - bh;
    r.hi = a * b;
    r.lo = ((ah * bh - r.hi) + ah * bl + al * bh) + al * bl;
    return r;
}

static lflare__wide lflare__wide_scale(lflare__wide x, int32_t e)
{
    static const double powers[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                      1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    while (e != 0) {
        int32_t step = e > 22 ? 22 : e < -22 ? -22 : e;
        lflare__wide p;
        if (step > 0) {
            double d = powers[step];
            p = lflare__wide_product(x.hi, d);
            p.lo += x.lo * d;
        } else {
            double d = powers[-step], q = x.hi / d;
            lflare__wide back = lflare__wide_product(q, d);
            p.hi = q;
            p.lo = ((x.hi - back.hi) - back.lo + x.lo) / d;
        }
        x.hi = p.hi + p.lo;
        x.lo = (p.hi - x.hi) + p.lo;
        e -= step;
    }
    return x;
}

LFLARE_API int32_t lflare_number_read(const char *text, size_t size, double *out)
{
    size_t i = 0, digits = 0;
    int negative = 0, point = 0;
    int32_t scale = 0, exponent = 0;
    uint64_t m = 0;
    lflare__wide w;
    if (i < size && (text[i] == '-' || text[i] == '+')) negative = text[i++] == '-';
    for (; i < size; i++) {
        char ch = text[i];
        if (ch == '.' && !point) { point = 1; continue; }
        if (ch < '0' || ch > '9') break;
        digits++;
        if (m < 999999999999999999u) { /* 18 digits fit; later ones only move the point */
            m = m * 10 + (uint64_t)(ch - '0');
            scale -= point;
        } else if (!point) {
            scale += scale < 100000;
        }
    }
    if (digits == 0) return 0;
    if (i < size && (text[i] == 'e' || text[i] == 'E')) {
        int minus = 0;
        size_t first;
        i++;
        if (i < size && (text[i] == '-' || text[i] == '+')) minus = text[i++] == '-';
        for (first = i; i < size && text[i] >= '0' && text[i] <= '9'; i++)
            if (exponent < 100000) exponent = exponent * 10 + (text[i] - '0');
        if (i == first) return 0;
        scale += minus ? -exponent : exponent;
    }
    if (i != size) return 0;
    if (m == 0 || scale < -345) {
        *out = 0;
    } else if (scale > 308) {
        *out = HUGE_VAL;
    } else {
        w.hi = (double)(m >> 32) * 4294967296.0;
        w.lo = (double)(m & 0xffffffffu);
        m = 0; /* two exact halves, renormalised */
        {
            double sum = w.hi + w.lo;
            w.lo = (w.hi - sum) + w.lo;
            w.hi = sum;
        }
        {   /* a power of two keeps the products within range */
            double guard = scale > 0 ? 18446744073709551616.0 : scale < -280 ? 1 / 18446744073709551616.0 : 1;
            w.hi /= guard;
            w.lo /= guard;
            w = lflare__wide_scale(w, scale);
            *out = (w.hi + w.lo) * guard;
        }
    }
    if (negative && *out != 0) *out = -*out;
    return 1;
}

LFLARE__APART static int32_t lflare__put_unsigned(uint64_t v, char *out)
{
    char digits[20];
    int32_t n = 0, i;
    do digits[n++] = (char)('0' + (int)(v % 10));
    while ((v /= 10) != 0);
    for (i = 0; i < n; i++) out[i] = digits[n - 1 - i];
    return n;
}

/* Decimal digits and exponent: value = 0.digits * 10^point. */
static int32_t lflare__digits(double value, char *digits, int32_t *point)
{
    int32_t precision, e = (int32_t)floor(log10(value)), n = 0;
    double guard = value > 1e280 ? 18446744073709551616.0 : value < 1e-280 ? 1 / 18446744073709551616.0 : 1; /* keeps products in range */
    for (precision = 1; precision <= 17; precision++) {
        lflare__wide w;
        double back;
        uint64_t m;
        char text[32];
        w.hi = value / guard;
        w.lo = 0;
        w = lflare__wide_scale(w, precision - 1 - e);
        w.hi *= guard;
        w.lo *= guard;
        m = (uint64_t)w.hi;
        m = (uint64_t)((int64_t)m + (int64_t)floor((w.hi - (double)m) + w.lo + 0.5)); /* lo may be negative, and over 1 */
        n = lflare__put_unsigned(m, digits);
        *point = n + e - precision + 1;
        memcpy(text, digits, (size_t)n);
        text[n] = 'e';
        text[n + 1] = '-';
        {
            int32_t shift = e - precision + 1, length = n + 1;
            if (shift < 0) length++;
            length += lflare__put_unsigned((uint64_t)(shift < 0 ? -shift : shift), text + length);
            if (lflare_number_read(text, (size_t)length, &back) && back == value) break;
        }
    }
    while (n > 1 && digits[n - 1] == '0') n--;
    return n;
}

LFLARE_API int32_t lflare_number_write(double value, char *out)
{
    char digits[24];
    int32_t n = 0, count, point, i;
    if (value != value) { memcpy(out, "nan", 3); return 3; }
    if (value < 0) { out[n++] = '-'; value = -value; }
    if (value > 1.7976931348623157e308) { memcpy(out + n, "inf", 3); return n + 3; }
    if (value == 0) { out[n++] = '0'; return n; }
    count = lflare__digits(value, digits, &point);
    if (point < -4 || point > 15) { /* d.ddde+x */
        out[n++] = digits[0];
        if (count > 1) out[n++] = '.';
        for (i = 1; i < count; i++) out[n++] = digits[i];
        out[n++] = 'e';
        point--;
        if (point < 0) { out[n++] = '-'; point = -point; }
        return n + lflare__put_unsigned((uint64_t)point, out + n);
    }
    if (point <= 0) { out[n++] = '0'; out[n++] = '.'; }
    for (i = point; i < 0; i++) out[n++] = '0';
    for (i = 0; i < count || i < point; i++) {
        if (i == point && point > 0) out[n++] = '.';
        out[n++] = i < count ? digits[i] : '0';
    }
    return n;
}

/* A tiny formatter for sentences: %s string, %i int32_t, %g double (at most 6 digits), %c char, %% percent. */
static void lflare__format_list(char *out, size_t size, const char *format, va_list list)
{
    size_t n = 0;
    for (; *format != 0; format++) {
        char buffer[40];
        const char *piece = buffer;
        size_t length = 1;
        buffer[0] = *format;
        if (*format == '%') {
            format++;
            if (*format == 's') {
                piece = va_arg(list, const char *);
                length = strlen(piece);
            } else if (*format == 'c') {
                buffer[0] = (char)va_arg(list, int);
            } else {
                double v = *format == 'i' ? (double)va_arg(list, int32_t) : va_arg(list, double);
                if (v != 0 && lflare__finite(v)) { /* to 6 digits */
                    double unit = pow(10.0, floor(log10(fabs(v))) - 5);
                    double rounded = floor(v / unit + 0.5);
                    v = unit < 1 ? rounded / floor(1 / unit + 0.5) : rounded * unit;
                }
                length = (size_t)lflare_number_write(v, buffer);
            }
        }
        for (; length > 0 && n + 1 < size; length--, piece++) out[n++] = *piece;
    }
    if (size > 0) out[n] = 0;
}

static void lflare__format(char *out, size_t size, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    lflare__format_list(out, size, format, list);
    va_end(list);
}

static lflare_result lflare__fail(lflare_error *error, lflare_result code, int32_t line, int32_t column, const char *format, ...)
{
    if (error != NULL) {
        va_list list;
        va_start(list, format);
        error->code = code;
        error->line = line;
        error->column = column;
        lflare__format_list(error->text, sizeof error->text, format, list);
        va_end(list);
    }
    return code;
}

/* What single numbers may be, for the reader and for prescriptions made by hand alike. */
typedef enum lflare__quantity {
    LFLARE__RADIUS, LFLARE__GAP, LFLARE__SEMI, LFLARE__CONIC, LFLARE__INDEX, LFLARE__ABBE, LFLARE__COEFFICIENT,
    LFLARE__NM, LFLARE__FILM_NM, LFLARE__FILM_INDEX, LFLARE__FNUMBER, LFLARE__SIZE
} lflare__quantity;

static const char *lflare__range(lflare__quantity q, double v)
{
    static const struct {
        const char *what;
        double lo, hi;
    } ranges[] = {
        {"a radius is between 0.001 and 1e9 mm in size ('flat' for a plane)", 1e-3, 1e9},
        {"a gap is between 0 and 1e6 mm", 0, 1e6},
        {"a semi-diameter is between 0.0001 and 1e5 mm", 1e-4, 1e5},
        {"a conic constant is between -1e6 and 1e6", -1e6, 1e6},
        {"an index of refraction is between 1 and 5", 1, 5},
        {"an Abbe number is between 5 and 200", 5, 200},
        {"a coefficient is between -1e12 and 1e12", -1e12, 1e12},
        {"a wavelength is between 100 and 20000 nm", 100, 20000},
        {"a layer is between 0.01 and 100000 nm thick", 0.01, 1e5},
        {"a layer's index is between 1 and 10", 1, 10},
        {"an f-number is between 0.1 and 1000", 0.1, 1000},
        {"a sensor's side is between 0.01 and 10000 mm", 0.01, 1e4},
    };
    double size = q == LFLARE__RADIUS ? fabs(v) : v;
    return size >= ranges[q].lo && size <= ranges[q].hi ? NULL : ranges[q].what;
}

/* The reader's place in the text, and its error. */
typedef struct lflare__reader {
    const char *at, *end, *line_start;
    const char *word; /* the word last read */
    size_t length;
    int32_t line;
    lflare_error *error;
    lflare_result failed;
} lflare__reader;

static int32_t lflare__column(const lflare__reader *r, const char *p)
{
    ptrdiff_t column = p - r->line_start + 1;
    return column > 1000000000 ? 1000000000 : (int32_t)column;
}

/* A word fit for a message: short, printable. */
static const char *lflare__quote(const lflare__reader *r, char *out)
{
    size_t i, n = r->length < 24 ? r->length : 24;
    for (i = 0; i < n; i++) out[i] = r->word[i] >= 32 && r->word[i] < 127 ? r->word[i] : '?';
    if (r->length > n) { memcpy(out + n, "...", 3); n += 3; }
    out[n] = 0;
    return out;
}

/* Message about the last word: `format` has one %s for it, or none. */
LFLARE__APART static int lflare__bad(lflare__reader *r, const char *format)
{
    char quoted[32];
    if (r->failed == LFLARE_OK)
        r->failed = lflare__fail(r->error, LFLARE_ERROR_SYNTAX, r->line, lflare__column(r, r->word), format, lflare__quote(r, quoted));
    return 0;
}

static int lflare__line_end(char ch) { return ch == '\n' || ch == '\r'; }

/* Next word of the line, or 0 at its end or at a comment. */
static int lflare__word(lflare__reader *r)
{
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t')) r->at++;
    r->word = r->at;
    while (r->at < r->end && !lflare__line_end(*r->at) && *r->at != ' ' && *r->at != '\t' && *r->at != '#') r->at++;
    r->length = (size_t)(r->at - r->word);
    return r->length > 0;
}

static int lflare__is(const lflare__reader *r, const char *word)
{
    return r->length == strlen(word) && memcmp(r->word, word, r->length) == 0;
}

/* The last word as a number of a kind. */
static int lflare__value(lflare__reader *r, lflare__quantity q, double *out)
{
    const char *range;
    if (r->length == 0) return lflare__bad(r, "a number is missing here");
    if (!lflare_number_read(r->word, r->length, out)) return lflare__bad(r, "a number was expected, not '%s'");
    if (!lflare__finite(*out)) return lflare__bad(r, "the number '%s' is too large");
    if ((range = lflare__range(q, *out)) != NULL) {
        char quoted[32];
        if (r->failed == LFLARE_OK)
            r->failed = lflare__fail(r->error, LFLARE_ERROR_SYNTAX, r->line, lflare__column(r, r->word), "%s, not '%s'", range,
                                     lflare__quote(r, quoted));
        return 0;
    }
    return 1;
}

/* The next word as a number; `after` names what it belongs to. */
static int lflare__next_value(lflare__reader *r, lflare__quantity q, const char *after, double *out)
{
    if (lflare__word(r)) return lflare__value(r, q, out);
    if (r->failed == LFLARE_OK)
        r->failed = lflare__fail(r->error, LFLARE_ERROR_SYNTAX, r->line, lflare__column(r, r->word), "a number is missing after '%s'", after);
    return 0;
}

/* "N:N" */
static int lflare__split(lflare__reader *r, lflare__quantity q1, double *a, lflare__quantity q2, double *b)
{
    const char *word = r->word, *colon = (const char *)memchr(r->word, ':', r->length);
    size_t length = r->length;
    int ok;
    if (colon == NULL) return lflare__bad(r, "two numbers joined by a colon were expected, not '%s'");
    r->length = (size_t)(colon - word);
    ok = lflare__value(r, q1, a);
    r->word = colon + 1;
    r->length = length - (size_t)(colon + 1 - word);
    return ok && lflare__value(r, q2, b);
}

/* The rest of the line as a text. */
static int lflare__text(lflare__reader *r, char *out, size_t size)
{
    const char *last;
    size_t n;
    if (out[0] != 0) return lflare__bad(r, "'%s' is given twice");
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t')) r->at++;
    r->word = r->at;
    while (r->at < r->end && !lflare__line_end(*r->at)) r->at++;
    for (last = r->at; last > r->word && (last[-1] == ' ' || last[-1] == '\t'); last--) {}
    n = r->length = (size_t)(last - r->word);
    if (n == 0) return lflare__bad(r, "a text is missing here");
    if (n >= size) {
        r->word += size - 1;
        r->length -= size - 1;
        return lflare__bad(r, "the text is too long from here on");
    }
    memcpy(out, r->word, n);
    out[n] = 0;
    return 1;
}

static int lflare__once(lflare__reader *r, uint32_t *seen, uint32_t bit)
{
    if ((*seen & bit) != 0) return lflare__bad(r, "'%s' repeats or contradicts what this row already says");
    *seen |= bit;
    return 1;
}

static int lflare__read_coating(lflare__reader *r, lflare_prescription *p, lflare_surface *s)
{
    if (!lflare__word(r)) return lflare__bad(r, "'none', 'quarter NM' or 'stack N:NM ...' is missing after 'coating'");
    if (lflare__is(r, "none")) return 1;
    if (lflare__is(r, "quarter")) {
        s->coating = LFLARE_COATING_QUARTER;
        return lflare__next_value(r, LFLARE__NM, "quarter", &s->quarter_nm);
    }
    if (!lflare__is(r, "stack")) return lflare__bad(r, "'none', 'quarter NM' or 'stack N:NM ...' was expected, not '%s'");
    s->coating = LFLARE_COATING_STACK;
    s->first_layer = p->layer_count;
    for (;;) {
        const char *back = r->at;
        lflare_layer *layer = &p->layers[p->layer_count];
        if (!lflare__word(r) || memchr(r->word, ':', r->length) == NULL) {
            if (s->layer_count == 0)
                return lflare__bad(r, r->length > 0 ? "a layer such as 1.38:99.6 was expected, not '%s'" : "a layer such as 1.38:99.6 is missing after 'stack'");
            r->at = back;
            return 1;
        }
        if (p->layer_count == LFLARE_MAX_LAYERS) return lflare__bad(r, "more than 1024 coating layers");
        if (!lflare__split(r, LFLARE__FILM_INDEX, &layer->n, LFLARE__FILM_NM, &layer->thickness_nm)) return 0;
        p->layer_count++;
        s->layer_count++;
    }
}

static int lflare__read_asphere(lflare__reader *r, lflare_surface *s)
{
    uint32_t powers = 0;
    for (;;) {
        const char *back = r->at, *term;
        size_t length;
        double power = 0, value = 0;
        int32_t i;
        if (!lflare__word(r) || memchr(r->word, ':', r->length) == NULL) {
            if (powers == 0)
                return lflare__bad(r, r->length > 0 ? "a term such as 4:1.5e-6 was expected, not '%s'" : "a term such as 4:1.5e-6 is missing after 'asphere'");
            r->at = back;
            return 1;
        }
        term = r->word;
        length = r->length;
        if (!lflare__split(r, LFLARE__COEFFICIENT, &power, LFLARE__COEFFICIENT, &value)) return 0;
        r->word = term;
        r->length = length;
        i = power >= 2 && power <= 16 ? (int32_t)power / 2 - 1 : -1;
        if (i < 0 || power != 2.0 * (i + 1)) return lflare__bad(r, "the power of an aspheric term is even, 2 to 16, not as in '%s'");
        if ((powers & (1u << i)) != 0) return lflare__bad(r, "the power of '%s' is given twice");
        s->aspheric[i] = value;
        powers |= 1u << i;
    }
}

/* One option of a row; the word is read. */
static int lflare__read_option(lflare__reader *r, lflare_prescription *p, lflare_surface *s, uint32_t *seen)
{
    enum { MEDIUM = 1, GLASS = 2, SEMI = 4, CONIC = 8, ASPHERE = 16, COATING = 32 };
    lflare_medium *m = &s->medium;
    int32_t i;
    if (lflare__is(r, "semi")) return lflare__once(r, seen, SEMI) && lflare__next_value(r, LFLARE__SEMI, "semi", &s->semi_diameter);
    if (s->is_stop) return lflare__bad(r, "a stop has a gap and 'semi' only, not '%s'");
    if (lflare__is(r, "air")) return lflare__once(r, seen, MEDIUM);
    if (lflare__is(r, "n")) {
        m->kind = LFLARE_MEDIUM_CONSTANT;
        return lflare__once(r, seen, MEDIUM) && lflare__next_value(r, LFLARE__INDEX, "n", &m->c[0]);
    }
    if (lflare__is(r, "nd")) {
        m->kind = LFLARE_MEDIUM_ABBE;
        if (!lflare__once(r, seen, MEDIUM) || !lflare__next_value(r, LFLARE__INDEX, "nd", &m->c[0])) return 0;
        if (!lflare__word(r) || !lflare__is(r, "vd"))
            return lflare__bad(r, "'vd' and the Abbe number must follow nd (or write 'n' for an index without dispersion)");
        return lflare__next_value(r, LFLARE__ABBE, "vd", &m->c[1]);
    }
    if (lflare__is(r, "sellmeier")) {
        m->kind = LFLARE_MEDIUM_SELLMEIER;
        if (!lflare__once(r, seen, MEDIUM)) return 0;
        for (i = 0; i < 6; i++)
            if (!lflare__word(r)) return lflare__bad(r, "'sellmeier' takes six numbers, B1 B2 B3 C1 C2 C3");
            else if (!lflare__value(r, LFLARE__COEFFICIENT, &m->c[i])) return 0;
        return 1;
    }
    if (lflare__is(r, "cauchy")) {
        m->kind = LFLARE_MEDIUM_CAUCHY;
        if (!lflare__once(r, seen, MEDIUM)) return 0;
        for (i = 0; i < 2; i++)
            if (!lflare__word(r)) return lflare__bad(r, "'cauchy' takes two or three numbers, A B C");
            else if (!lflare__value(r, LFLARE__COEFFICIENT, &m->c[i])) return 0;
        {
            const char *back = r->at;
            double c;
            if (lflare__word(r) && lflare_number_read(r->word, r->length, &c)) return lflare__value(r, LFLARE__COEFFICIENT, &m->c[2]);
            r->at = back;
        }
        return 1;
    }
    if (lflare__is(r, "glass")) {
        if (!lflare__once(r, seen, GLASS)) return 0;
        if (!lflare__word(r)) return lflare__bad(r, "a name is missing after 'glass'");
        if (r->length >= sizeof m->glass) return lflare__bad(r, "the glass name '%s' is longer than 23 bytes");
        memcpy(m->glass, r->word, r->length);
        return 1;
    }
    if (lflare__is(r, "conic")) return lflare__once(r, seen, CONIC) && lflare__next_value(r, LFLARE__CONIC, "conic", &s->conic);
    if (lflare__is(r, "asphere")) return lflare__once(r, seen, ASPHERE) && lflare__read_asphere(r, s);
    if (lflare__is(r, "coating")) return lflare__once(r, seen, COATING) && lflare__read_coating(r, p, s);
    return lflare__bad(r, "unknown word '%s' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)");
}

LFLARE__APART static int lflare__read_row(lflare__reader *r, lflare_prescription *p)
{
    lflare_surface *s;
    uint32_t seen = 0;
    if (p->surface_count == LFLARE_MAX_SURFACES) return lflare__bad(r, "more than 128 rows");
    if (p->focus) return lflare__bad(r, "a row follows the one whose gap is 'focus', which only the last can have");
    s = &p->surfaces[p->surface_count++];
    s->line = r->line;
    s->is_stop = lflare__is(r, "stop");
    if (!s->is_stop && !lflare__is(r, "flat")) {
        double radius;
        if (!lflare_number_read(r->word, r->length, &radius))
            return lflare__bad(r, "unknown word '%s' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')");
        if (!lflare__value(r, LFLARE__RADIUS, &s->radius)) return 0;
    }
    if (!lflare__word(r)) return lflare__bad(r, "the gap to the next row is missing");
    if (lflare__is(r, "focus")) p->focus = 1;
    else if (!lflare__value(r, LFLARE__GAP, &s->thickness)) return 0;
    while (lflare__word(r))
        if (!lflare__read_option(r, p, s, &seen)) return 0;
    return 1;
}

static int lflare__read_statement(lflare__reader *r, lflare_prescription *p)
{
    if (lflare__is(r, "lensflare")) return lflare__bad(r, "'lensflare' is given twice");
    if (lflare__is(r, "name")) return lflare__text(r, p->name, sizeof p->name);
    if (lflare__is(r, "patent")) return lflare__text(r, p->patent, sizeof p->patent);
    if (lflare__is(r, "source")) return lflare__text(r, p->source, sizeof p->source);
    if (lflare__is(r, "fnumber")) {
        if (p->fnumber != 0) return lflare__bad(r, "'%s' is given twice");
        return lflare__next_value(r, LFLARE__FNUMBER, "fnumber", &p->fnumber);
    }
    if (lflare__is(r, "sensor")) {
        if (p->sensor_width != 0) return lflare__bad(r, "'%s' is given twice");
        return lflare__next_value(r, LFLARE__SIZE, "sensor", &p->sensor_width) &&
               lflare__next_value(r, LFLARE__SIZE, "sensor", &p->sensor_height);
    }
    return lflare__read_row(r, p);
}

/* Byte order marks, other encodings, control characters: found before anything else is. */
static int lflare__check_bytes(lflare__reader *r)
{
    const char *p = r->at, *line = p;
    int32_t n = 1;
    size_t size = (size_t)(r->end - r->at);
    r->length = 0;
    r->word = p;
    if (size >= 2 && (((uint8_t)p[0] == 0xff && (uint8_t)p[1] == 0xfe) || ((uint8_t)p[0] == 0xfe && (uint8_t)p[1] == 0xff)))
        return lflare__bad(r, "the text is UTF-16: save it as UTF-8");
    for (; p < r->end; p++) {
        uint8_t ch = (uint8_t)*p;
        if (lflare__line_end(*p)) {
            if (*p == '\r' && p + 1 < r->end && p[1] == '\n') p++;
            n++;
            line = p + 1;
        } else if ((ch < 32 && ch != '\t') || ch == 127) {
            r->line = n;
            r->line_start = line;
            r->word = p;
            return lflare__bad(r, ch == 0 ? "a zero byte: this is not a text (or it is UTF-16: save it as UTF-8)" : "a control character");
        }
    }
    return 1;
}

LFLARE_API lflare_result lflare_text_read(const char *text, size_t size, lflare_prescription *out, lflare_error *error)
{
    lflare__reader r;
    int32_t statements = 0;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (out == NULL || (text == NULL && size > 0)) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no text or no prescription given");
    memset(out, 0, sizeof *out);
    memset(&r, 0, sizeof r);
    r.at = r.line_start = text != NULL ? text : "";
    r.end = r.at + size;
    r.line = 1;
    r.error = error;
    if (size >= 3 && memcmp(r.at, "\xef\xbb\xbf", 3) == 0) r.at = r.line_start = r.at + 3;
    if (!lflare__check_bytes(&r)) return r.failed;
    while (r.at < r.end) {
        if (lflare__word(&r)) {
            if (statements++ == 0) {
                double version = 0;
                if (!lflare__is(&r, "lensflare")) lflare__bad(&r, "the first statement must be 'lensflare 1', not '%s'");
                else if (!lflare__word(&r)) lflare__bad(&r, "the version is missing: write 'lensflare 1'");
                else if (!lflare_number_read(r.word, r.length, &version) || version != 1)
                    lflare__bad(&r, "this reader knows version 1 of the format, not '%s'");
            } else {
                lflare__read_statement(&r, out);
            }
            if (r.failed == LFLARE_OK && lflare__word(&r)) lflare__bad(&r, "'%s' is one word too many");
        }
        if (r.failed != LFLARE_OK) return r.failed;
        while (r.at < r.end && !lflare__line_end(*r.at)) r.at++; /* a comment */
        if (r.at < r.end) {
            r.at += r.at + 1 < r.end && r.at[0] == '\r' && r.at[1] == '\n' ? 2 : 1;
            r.line++;
            r.line_start = r.at;
        }
    }
    r.word = r.at;
    r.length = 0;
    if (statements == 0) lflare__bad(&r, "the text is empty; it should begin with 'lensflare 1'");
    else if (out->surface_count == 0) lflare__bad(&r, "there are no surfaces");
    return r.failed;
}

/* Bytes written so far, counting those that no longer fit. */
typedef struct lflare__writer {
    char *at;
    size_t room, size, line_start;
} lflare__writer;

static void lflare__put_bytes(lflare__writer *w, const char *bytes, size_t n)
{
    size_t i;
    for (i = 0; i < n; i++, w->size++)
        if (w->size < w->room) w->at[w->size] = bytes[i];
}

LFLARE__APART static void lflare__put(lflare__writer *w, const char *text) { lflare__put_bytes(w, text, strlen(text)); }

static void lflare__put_number(lflare__writer *w, const char *before, double v)
{
    char number[32];
    lflare__put(w, before);
    lflare__put_bytes(w, number, (size_t)lflare_number_write(v, number));
}

static void lflare__put_line(lflare__writer *w)
{
    lflare__put(w, "\n");
    w->line_start = w->size;
}

/* Pads to a column, with one blank at least. */
static void lflare__put_column(lflare__writer *w, size_t column)
{
    do lflare__put(w, " ");
    while (w->size - w->line_start < column);
}

/* A text with anything that would end its line, or a label with anything that would end its word, made a blank or '_'. */
static void lflare__put_clean(lflare__writer *w, const char *text, size_t size, int word)
{
    size_t i;
    for (i = 0; i < size && text[i] != 0; i++) {
        char ch = text[i];
        if (word ? ((uint8_t)ch <= 32 || ch == 127 || ch == '#') : ((uint8_t)ch < 32 || ch == 127)) ch = word ? '_' : ' ';
        lflare__put_bytes(w, &ch, 1);
    }
}

static void lflare__put_medium(lflare__writer *w, const lflare_medium *m)
{
    int32_t i;
    switch (m->kind) {
    case LFLARE_MEDIUM_CONSTANT: lflare__put_number(w, "n ", m->c[0]); break;
    case LFLARE_MEDIUM_ABBE:
        lflare__put_number(w, "nd ", m->c[0]);
        lflare__put_number(w, " vd ", m->c[1]);
        break;
    case LFLARE_MEDIUM_SELLMEIER:
        for (i = 0; i < 6; i++) lflare__put_number(w, i == 0 ? "sellmeier " : " ", m->c[i]);
        break;
    case LFLARE_MEDIUM_CAUCHY:
        for (i = 0; i < 3; i++) lflare__put_number(w, i == 0 ? "cauchy " : " ", m->c[i]);
        break;
    default: lflare__put(w, "air"); break;
    }
    if (m->glass[0] != 0) {
        lflare__put(w, " glass ");
        lflare__put_clean(w, m->glass, sizeof m->glass - 1, 1);
    }
}

static void lflare__put_row(lflare__writer *w, const lflare_prescription *p, int32_t index)
{
    const lflare_surface *s = &p->surfaces[index];
    int32_t i;
    if (s->is_stop) lflare__put(w, "stop");
    else if (s->radius == 0) lflare__put(w, "flat");
    else lflare__put_number(w, "", s->radius);
    lflare__put_column(w, 12);
    if (p->focus && index == p->surface_count - 1) lflare__put(w, "focus");
    else lflare__put_number(w, "", s->thickness);
    if (!s->is_stop) {
        lflare__put_column(w, 22);
        lflare__put_medium(w, &s->medium);
    }
    if (s->semi_diameter != 0) {
        lflare__put_column(w, 60);
        lflare__put_number(w, "semi ", s->semi_diameter);
    }
    if (s->is_stop) return;
    if (s->conic != 0) lflare__put_number(w, " conic ", s->conic);
    {
        const char *before = " asphere ";
        for (i = 0; i < 8; i++)
            if (s->aspheric[i] != 0) {
                lflare__put_number(w, before, 2.0 * (i + 1));
                lflare__put_number(w, ":", s->aspheric[i]);
                before = " ";
            }
    }
    if (s->coating == LFLARE_COATING_QUARTER) lflare__put_number(w, " coating quarter ", s->quarter_nm);
    if (s->coating == LFLARE_COATING_STACK)
        for (i = 0; i < s->layer_count; i++) {
            const lflare_layer *layer = &p->layers[s->first_layer + i];
            lflare__put_number(w, i == 0 ? " coating stack " : " ", layer->n);
            lflare__put_number(w, ":", layer->thickness_nm);
        }
}

LFLARE_API lflare_result lflare_text_write(const lflare_prescription *p, char *text, size_t *size)
{
    lflare__writer w;
    int32_t i;
    if (p == NULL || size == NULL || (text == NULL && *size > 0)) return LFLARE_ERROR_ARGUMENT;
    if (p->surface_count < 0 || p->surface_count > LFLARE_MAX_SURFACES) return LFLARE_ERROR_ARGUMENT;
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        if (s->coating == LFLARE_COATING_STACK &&
            (s->first_layer < 0 || s->layer_count < 0 || s->first_layer > LFLARE_MAX_LAYERS - s->layer_count))
            return LFLARE_ERROR_ARGUMENT;
    }
    memset(&w, 0, sizeof w);
    w.at = text;
    w.room = *size;
    lflare__put(&w, "lensflare 1\n");
    for (i = 0; i < 3; i++) {
        static const char *const words[3] = {"name      ", "patent    ", "source    "};
        const char *value = i == 0 ? p->name : i == 1 ? p->patent : p->source;
        size_t room = (i == 2 ? sizeof p->source : sizeof p->name) - 1, k = 0;
        while (k < room && value[k] != 0 && ((uint8_t)value[k] <= 32 || value[k] == 127)) k++;
        if (k == room || value[k] == 0) continue; /* nothing but blanks */
        lflare__put(&w, words[i]);
        lflare__put_clean(&w, value, room, 0);
        lflare__put(&w, "\n");
    }
    if (p->fnumber != 0) {
        lflare__put_number(&w, "fnumber   ", p->fnumber);
        lflare__put(&w, "\n");
    }
    if (p->sensor_width != 0) {
        lflare__put_number(&w, "sensor    ", p->sensor_width);
        lflare__put_number(&w, " ", p->sensor_height);
        lflare__put(&w, "\n");
    }
    lflare__put(&w, "\n# radius    gap       medium behind\n");
    w.line_start = w.size;
    for (i = 0; i < p->surface_count; i++) {
        lflare__put_row(&w, p, i);
        lflare__put_line(&w);
    }
    *size = w.size;
    return w.size > w.room ? LFLARE_INCOMPLETE : LFLARE_OK;
}

/* >> 3 glass */

#define LFLARE__NM_D 587.5618
#define LFLARE__NM_F 486.1327
#define LFLARE__NM_C 656.2725

/* Red, green and blue of the model (P 4). */
static const double lflare__rgb_nm[LFLARE_WAVELENGTHS] = {650, 510, 475};

#if !defined(LFLARE_NO_DIFFRACTION) || !defined(LFLARE_NO_TRACE)
/* The CIE's standard observer of 1931, 380 to 780 nm in steps of 5 (CIE 15, colour matching functions), in 1e-6. */
enum { LFLARE__CIE_COUNT = 81 };
static const int32_t lflare__cie[3][LFLARE__CIE_COUNT] = {
    {1368, 2236, 4243, 7650, 14310, 23190, 43510, 77630, 134380, 214770, 283900, 328500, 348280, 348060, 336200, 318700,
     290800, 251100, 195360, 142100, 95640, 57950, 32010, 14700, 4900, 2400, 9300, 29100, 63270, 109600, 165500, 225750,
     290400, 359700, 433450, 512050, 594500, 678400, 762100, 842500, 916300, 978600, 1026300, 1056700, 1062200, 1045600,
     1002600, 938400, 854450, 751400, 642400, 541900, 447900, 360800, 283500, 218700, 164900, 121200, 87400, 63600, 46770,
     32900, 22700, 15840, 11359, 8111, 5790, 4109, 2899, 2049, 1440, 1000, 690, 476, 332, 235, 166, 117, 83, 59, 42},
    {39, 64, 120, 217, 396, 640, 1210, 2180, 4000, 7300, 11600, 16840, 23000, 29800, 38000, 48000, 60000, 73900, 90980, 112600,
     139020, 169300, 208020, 258600, 323000, 407300, 503000, 608200, 710000, 793200, 862000, 914850, 954000, 980300, 994950,
     1000000, 995000, 978600, 952000, 915400, 870000, 816300, 757000, 694900, 631000, 566800, 503000, 441200, 381000, 321000,
     265000, 217000, 175000, 138200, 107000, 81600, 61000, 44580, 32000, 23200, 17000, 11920, 8210, 5723, 4102, 2929, 2091,
     1484, 1047, 740, 520, 361, 249, 172, 120, 85, 60, 42, 30, 21, 15},
    {6450, 10550, 20050, 36210, 67850, 110200, 207400, 371300, 645600, 1039050, 1385600, 1622960, 1747060, 1782600, 1772110,
     1744100, 1669200, 1528100, 1287640, 1041900, 812950, 616200, 465180, 353300, 272000, 212300, 158200, 111700, 78250, 57250,
     42160, 29840, 20300, 13400, 8750, 5750, 3900, 2750, 2100, 1800, 1650, 1400, 1100, 1000, 800, 600, 340, 240, 190, 100, 50,
     30, 20, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}
};

static const double lflare__to_srgb[3][3] = {{3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};

LFLARE_API void lflare_wavelength_rgb(double nm, double *rgb)
{
    double at = (nm - 380) / 5, xyz[3], f;
    int32_t i = (int32_t)lflare__clamp(at, 0, LFLARE__CIE_COUNT - 2), k, c;
    f = at - i;
    for (k = 0; k < 3; k++) xyz[k] = at >= 0 && at <= LFLARE__CIE_COUNT - 1 ? 1e-6 * (lflare__cie[k][i] + f * (lflare__cie[k][i + 1] - lflare__cie[k][i])) : 0;
    for (k = 0; k < 3; k++)
        for (rgb[k] = 0, c = 0; c < 3; c++) rgb[k] += lflare__to_srgb[k][c] * xyz[c];
}
#endif

LFLARE_API double lflare_index(const lflare_medium *m, double nm)
{
    const double *c = m->c;
    double um = nm * 1e-3, l2 = um * um;
    switch (m->kind) {
    case LFLARE_MEDIUM_CONSTANT: return c[0];
    case LFLARE_MEDIUM_ABBE: {
        double slope = (c[0] - 1) / c[1] / (1 / (LFLARE__NM_F * LFLARE__NM_F) - 1 / (LFLARE__NM_C * LFLARE__NM_C));
        return c[0] + slope * (1 / (nm * nm) - 1 / (LFLARE__NM_D * LFLARE__NM_D));
    }
    case LFLARE_MEDIUM_SELLMEIER: return sqrt(1 + c[0] * l2 / (l2 - c[3]) + c[1] * l2 / (l2 - c[4]) + c[2] * l2 / (l2 - c[5]));
    case LFLARE_MEDIUM_CAUCHY: return c[0] + c[1] / l2 + c[2] / (l2 * l2);
    default: return 1;
    }
}

/* n[i] in front of surface i, n[i + 1] behind it; the stop takes the medium that it stands in. */
static void lflare__indices(const lflare_prescription *p, double nm, double *n)
{
    int32_t i;
    n[0] = 1;
    for (i = 0; i < p->surface_count; i++) n[i + 1] = p->surfaces[i].is_stop ? n[i] : lflare_index(&p->surfaces[i].medium, nm);
}

/* >> 4 paraxial */
/* P 2, after LE table 2. Matrices act on (height, slope); going backwards a surface shows its other side: its radius
   changes sign and the media swap (not the inverse matrix, as LE have it). */

static const lflare_matrix lflare__identity = {1, 0, 0, 1};

/* The matrices that follow multiply from the left, in place: what the ray meets next. */
static void lflare__translate(lflare_matrix *m, double d)
{
    m->a += d * m->c;
    m->b += d * m->d;
}

static void lflare__refract(lflare_matrix *m, double n1, double n2, double curvature)
{
    double power = (n1 - n2) / n2 * curvature, ratio = n1 / n2;
    m->c = power * m->a + ratio * m->c;
    m->d = power * m->b + ratio * m->d;
}

static void lflare__reflect(lflare_matrix *m, double curvature)
{
    m->c += 2 * curvature * m->a;
    m->d += 2 * curvature * m->b;
}

static lflare_matrix lflare__product(lflare_matrix l, lflare_matrix r)
{
    lflare_matrix m;
    m.a = l.a * r.a + l.b * r.c;
    m.b = l.a * r.b + l.b * r.d;
    m.c = l.c * r.a + l.d * r.c;
    m.d = l.c * r.b + l.d * r.d;
    return m;
}

static lflare_matrix lflare__inverse(lflare_matrix m)
{
    double det = m.a * m.d - m.b * m.c;
    lflare_matrix r;
    r.a = m.d / det;
    r.b = -m.b / det;
    r.c = -m.c / det;
    r.d = m.a / det;
    return r;
}

/* Everything paraxial that depends on the wavelength, for all ghosts at once: prefix and suffix products. */
typedef struct lflare__paraxial {
    double n[LFLARE_MAX_SURFACES + 1];
    lflare_matrix before[LFLARE_MAX_SURFACES + 1]; /* entrance to just before surface i; the last entry: to the sensor */
    lflare_matrix to_stop[LFLARE_MAX_SURFACES];    /* from just behind surface i < stop to the stop */
    lflare_matrix to_sensor[LFLARE_MAX_SURFACES];  /* from just behind surface i to the sensor */
} lflare__paraxial;

static void lflare__prefixes(const lflare_lens *lens, const double *n, lflare_matrix *before)
{
    int32_t i;
    before[0] = lflare__identity;
    for (i = 0; i < lens->surface_count; i++) {
        before[i + 1] = before[i];
        lflare__refract(&before[i + 1], n[i], n[i + 1], lens->curvature[i]);
        lflare__translate(&before[i + 1], lens->prescription.surfaces[i].thickness);
    }
}

/* The suffixes run towards the front: to_x(i-1) = to_x(i) refraction(i) gap(i-1). */
static void lflare__paraxial_make(const lflare_lens *lens, double nm, lflare__paraxial *x)
{
    const lflare_surface *s = lens->prescription.surfaces;
    int32_t i, count = lens->surface_count;
    lflare__indices(&lens->prescription, nm, x->n);
    lflare__prefixes(lens, x->n, x->before);
    for (i = count - 1; i >= 0; i--) {
        lflare_matrix step = lflare__identity;
        lflare__translate(&step, s[i].thickness);
        if (i == lens->stop - 1) x->to_stop[i] = step;
        if (i + 1 < count) lflare__refract(&step, x->n[i + 1], x->n[i + 2], lens->curvature[i + 1]);
        x->to_sensor[i] = i + 1 < count ? lflare__product(x->to_sensor[i + 1], step) : step;
        if (i < lens->stop - 1) x->to_stop[i] = lflare__product(x->to_stop[i + 1], step);
    }
}

LFLARE_API lflare_matrix lflare_system_matrix(const lflare_lens *lens, double nm)
{
    double n[LFLARE_MAX_SURFACES + 1];
    lflare_matrix before[LFLARE_MAX_SURFACES + 1], *m = &before[lens->surface_count - 1];
    lflare__indices(&lens->prescription, nm, n);
    lflare__prefixes(lens, n, before);
    lflare__refract(m, n[lens->surface_count - 1], n[lens->surface_count], lens->curvature[lens->surface_count - 1]);
    return *m;
}

/* >> 5 lens */

LFLARE_API const char *lflare_result_text(lflare_result result)
{
    switch (result) {
    case LFLARE_OK: return "done";
    case LFLARE_INCOMPLETE: return "incomplete: the array was too small, or more steps remain";
    case LFLARE_ERROR_SYNTAX: return "the text is not a prescription";
    case LFLARE_ERROR_LENS: return "the prescription makes no usable lens";
    case LFLARE_ERROR_ARGUMENT: return "an argument is missing, out of range or not finite";
    case LFLARE_ERROR_MEMORY: return "out of memory";
    case LFLARE_ERROR_FILE: return "the file cannot be read";
    case LFLARE_ERROR_LIMIT: return "more than was allowed for at creation";
    case LFLARE_ERROR_GL: return "GL lacks something, or a shader fails";
    case LFLARE_ERROR_FIT: return "the fit is damaged, or of another lens or version";
    }
    return "unknown result";
}

LFLARE_API const char *lflare_note_text(const lflare_note *note, char *out, size_t size)
{
    int32_t row = note->surface + 1;
    double v = note->value, w = note->stated;
    switch (note->kind) {
    case LFLARE_NOTE_SEMI_DERIVED: lflare__format(out, size, "row %i: semi-diameter %g mm derived from marginal and chief ray", row, v); break;
    case LFLARE_NOTE_SEMI_REDUCED: lflare__format(out, size, "row %i: semi-diameter %g mm is beyond the surface's end, reduced to %g", row, w, v); break;
    case LFLARE_NOTE_STOP_DERIVED: lflare__format(out, size, "row %i: the stop's semi-diameter %g mm is derived", row, v); break;
    case LFLARE_NOTE_FNUMBER_DERIVED: lflare__format(out, size, "f-number %g derived from the stop", v); break;
    case LFLARE_NOTE_FNUMBER_LIMITED: lflare__format(out, size, "f/%g is stated, but the stop's semi-diameter allows f/%g", w, v); break;
    case LFLARE_NOTE_SENSOR_ASSUMED: lflare__format(out, size, "no sensor is given: 36 x 24 mm assumed"); break;
    case LFLARE_NOTE_FOCUS_DERIVED: lflare__format(out, size, "row %i: the sensor is put in focus, %g mm behind", row, v); break;
    case LFLARE_NOTE_OUT_OF_FOCUS: lflare__format(out, size, "the sensor is %g mm behind the last surface, the paraxial focus %g mm", w, v); break;
    case LFLARE_NOTE_EDGES_CROSS: lflare__format(out, size, "rows %i and %i cross: %g mm thick at the edge", row, row + 1, v); break;
    default: lflare__format(out, size, "unknown note"); break;
    }
    return out;
}

LFLARE_API double lflare_sag(const lflare_surface *s, double r)
{
    double r2 = r * r, z = 0, term = 1;
    int32_t i;
    if (s->radius != 0) {
        double c = 1 / s->radius, root = 1 - (1 + s->conic) * c * c * r2;
        z = c * r2 / (1 + sqrt(root)); /* NaN beyond the end */
    }
    for (i = 0; i < 8; i++) z += s->aspheric[i] * (term *= r2);
    return z;
}

LFLARE__APART static void lflare__note(lflare_lens *lens, lflare_note_kind kind, int32_t surface, double value, double stated)
{
    lflare_note *note;
    if (lens->note_count == LFLARE_MAX_NOTES) return;
    note = &lens->notes[lens->note_count++];
    note->kind = kind;
    note->surface = surface;
    note->value = value;
    note->stated = stated;
}

/* An index step at any of the wavelengths in use: cemented glasses may agree at one. */
static int lflare__reflects(const lflare_prescription *p, int32_t i)
{
    static const double nm[4] = {LFLARE__NM_D, 650, 510, 475};
    int32_t k;
    if (p->surfaces[i].is_stop) return 0;
    for (k = 0; k < 4; k++) {
        int32_t j = i - 1;
        double front;
        while (j >= 0 && p->surfaces[j].is_stop) j--;
        front = j < 0 ? 1 : lflare_index(&p->surfaces[j].medium, nm[k]);
        if (fabs(front - lflare_index(&p->surfaces[i].medium, nm[k])) > 1e-6) return 1;
    }
    return 0;
}

/* Ranges again, for prescriptions made by hand, and what a single row cannot know. */
static lflare_result lflare__check_row(const lflare_prescription *p, int32_t index, lflare_error *error)
{
    const lflare_surface *s = &p->surfaces[index];
    const char *wrong = NULL;
    int32_t i;
    if (s->radius != 0) wrong = lflare__range(LFLARE__RADIUS, s->radius);
    if (wrong == NULL) wrong = lflare__range(LFLARE__GAP, s->thickness);
    if (wrong == NULL && s->semi_diameter != 0) wrong = lflare__range(LFLARE__SEMI, s->semi_diameter);
    if (wrong == NULL) wrong = lflare__range(LFLARE__CONIC, s->conic);
    for (i = 0; i < 8 && wrong == NULL; i++) wrong = lflare__range(LFLARE__COEFFICIENT, s->aspheric[i]);
    if (wrong == NULL && s->coating == LFLARE_COATING_QUARTER) wrong = lflare__range(LFLARE__NM, s->quarter_nm);
    if (wrong == NULL && s->coating == LFLARE_COATING_STACK) {
        if (s->first_layer < 0 || s->layer_count < 0 || s->first_layer > LFLARE_MAX_LAYERS - s->layer_count) wrong = "the coating's layers lie outside the prescription's";
        for (i = 0; wrong == NULL && i < s->layer_count; i++) {
            wrong = lflare__range(LFLARE__FILM_INDEX, p->layers[s->first_layer + i].n);
            if (wrong == NULL) wrong = lflare__range(LFLARE__FILM_NM, p->layers[s->first_layer + i].thickness_nm);
        }
    }
    if (wrong == NULL && !s->is_stop) {
        static const double nm[5] = {LFLARE__NM_D, 650, 510, 475, 380};
        for (i = 0; i < 5; i++) {
            double n = lflare_index(&s->medium, nm[i]);
            if (!(n >= 1 && n <= 5)) wrong = "the medium's index of refraction leaves 1 to 5 between 380 and 650 nm";
        }
    }
    if (wrong == NULL) return LFLARE_OK;
    return lflare__fail(error, LFLARE_ERROR_LENS, s->line, s->line > 0, "row %i: %s", index + 1, wrong);
}

static lflare_result lflare__check_rows(const lflare_prescription *p, lflare_lens *lens, lflare_error *error)
{
    int32_t i, last_line = 0, behind_line = 0;
    lflare_medium_kind behind = LFLARE_MEDIUM_AIR;
    lens->stop = -1;
    if (p->surface_count < 1 || p->surface_count > LFLARE_MAX_SURFACES)
        return lflare__fail(error, LFLARE_ERROR_LENS, 0, 0, "a lens has 1 to 128 rows, not %i", p->surface_count);
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        lflare_result result = lflare__check_row(p, i, error);
        if (result != LFLARE_OK) return result;
        last_line = s->line;
        if (!s->is_stop) {
            behind = s->medium.kind;
            behind_line = s->line;
        }
        lens->curvature[i] = (s->radius != 0 ? 1 / s->radius : 0) + 2 * s->aspheric[0];
        if (!s->is_stop) continue;
        if (lens->stop >= 0)
            return lflare__fail(error, LFLARE_ERROR_LENS, s->line, s->line > 0, "a second stop (the first is row %i); a lens has one", lens->stop + 1);
        if (s->radius != 0) return lflare__fail(error, LFLARE_ERROR_LENS, s->line, s->line > 0, "row %i: the stop must be flat", i + 1);
        lens->stop = i;
    }
    if (lens->stop < 0)
        return lflare__fail(error, LFLARE_ERROR_LENS, last_line, last_line > 0, "there is no stop: add a row 'stop GAP' where the iris is");
    if (behind != LFLARE_MEDIUM_AIR)
        return lflare__fail(error, LFLARE_ERROR_LENS, behind_line, behind_line > 0, "the lens ends in glass: the medium behind its last surface must be air");
    return LFLARE_OK;
}

/* Sensor, focal length, focus: P 2. */
static lflare_result lflare__derive_image(lflare_lens *lens, lflare_error *error)
{
    lflare_prescription *p = &lens->prescription;
    lflare_surface *last = &p->surfaces[p->surface_count - 1];
    lflare_matrix m = lflare_system_matrix(lens, LFLARE__NM_D);
    if (p->sensor_width == 0 && p->sensor_height == 0) {
        p->sensor_width = 36;
        p->sensor_height = 24;
        lflare__note(lens, LFLARE_NOTE_SENSOR_ASSUMED, -1, 36, 0);
    } else if (lflare__range(LFLARE__SIZE, p->sensor_width) != NULL || lflare__range(LFLARE__SIZE, p->sensor_height) != NULL) {
        return lflare__fail(error, LFLARE_ERROR_LENS, 0, 0, "%s", lflare__range(LFLARE__SIZE, -1));
    }
    lens->sensor_width = p->sensor_width;
    lens->sensor_height = p->sensor_height;
    if (!(fabs(m.c) > 1e-9)) return lflare__fail(error, LFLARE_ERROR_LENS, last->line, last->line > 0, "the lens has no focal length: parallel light leaves it parallel");
    lens->efl = -1 / m.c;
    lens->bfd = -m.a / m.c;
    if (!(lens->efl > 0)) return lflare__fail(error, LFLARE_ERROR_LENS, last->line, last->line > 0, "the focal length is negative, %g mm: the lens forms no real image", lens->efl);
    if (p->focus) {
        if (!(lens->bfd >= 0)) return lflare__fail(error, LFLARE_ERROR_LENS, last->line, last->line > 0, "'focus' would put the sensor %g mm inside the lens", -lens->bfd);
        last->thickness = lens->bfd;
        lflare__note(lens, LFLARE_NOTE_FOCUS_DERIVED, p->surface_count - 1, lens->bfd, 0);
    } else if (fabs(last->thickness - lens->bfd) > 0.005 * lens->efl) {
        lflare__note(lens, LFLARE_NOTE_OUT_OF_FOCUS, p->surface_count - 1, lens->bfd, last->thickness);
    }
    return LFLARE_OK;
}

/* Stop from f-number, f-number from stop: P 6. */
static lflare_result lflare__derive_stop(lflare_lens *lens, const lflare__paraxial *x, lflare_error *error)
{
    lflare_prescription *p = &lens->prescription;
    lflare_surface *stop = &p->surfaces[lens->stop];
    double a11 = fabs(x->before[lens->stop].a);
    int32_t i;
    if (p->fnumber != 0 && lflare__range(LFLARE__FNUMBER, p->fnumber) != NULL)
        return lflare__fail(error, LFLARE_ERROR_LENS, 0, 0, "%s", lflare__range(LFLARE__FNUMBER, p->fnumber));
    if (a11 < 1e-6)
        return lflare__fail(error, LFLARE_ERROR_LENS, stop->line, stop->line > 0, "the stop stands in a focus, where it cannot limit the aperture");
    if (stop->semi_diameter == 0) {
        double best = p->fnumber != 0 ? a11 * lens->efl / (2 * p->fnumber) : HUGE_VAL;
        for (i = 0; p->fnumber == 0 && i < p->surface_count; i++)
            if (p->surfaces[i].semi_diameter != 0)
                best = lflare__min(best, p->surfaces[i].semi_diameter * a11 / lflare__max(fabs(x->before[i].a), 1e-9));
        if (lflare__range(LFLARE__SEMI, best) != NULL)
            return lflare__fail(error, LFLARE_ERROR_LENS, stop->line, stop->line > 0, "the aperture is unknown: give 'fnumber', or 'semi' in the stop's row");
        stop->semi_diameter = best;
        lflare__note(lens, LFLARE_NOTE_STOP_DERIVED, lens->stop, best, 0);
    }
    lens->stop_a11 = x->before[lens->stop].a;
    lens->fnumber = a11 * lens->efl / (2 * stop->semi_diameter);
    if (lflare__range(LFLARE__FNUMBER, lens->fnumber) != NULL)
        return lflare__fail(error, LFLARE_ERROR_LENS, stop->line, stop->line > 0, "the stop's semi-diameter of %g mm makes an f-number of %g; it is between 0.1 and 1000",
                            stop->semi_diameter, lens->fnumber);
    if (p->fnumber == 0) {
        p->fnumber = lens->fnumber;
        lflare__note(lens, LFLARE_NOTE_FNUMBER_DERIVED, -1, lens->fnumber, 0);
    } else if (p->fnumber < lens->fnumber * 0.995) {
        lflare__note(lens, LFLARE_NOTE_FNUMBER_LIMITED, -1, lens->fnumber, p->fnumber);
    }
    lens->fnumber = lflare__max(lens->fnumber, p->fnumber);
    return LFLARE_OK;
}

/* Thickness between rows i and i + 1 at the edge of the smaller. */
static double lflare__edge(const lflare_prescription *p, int32_t i)
{
    double r = lflare__min(p->surfaces[i].semi_diameter, p->surfaces[i + 1].semi_diameter);
    return p->surfaces[i].thickness + lflare_sag(&p->surfaces[i + 1], r) - lflare_sag(&p->surfaces[i], r);
}

/* Semi-diameters that are missing pass the whole beam on the axis and half of it at the sensor's corner, as far as spheres
   and neighbours allow. */
static void lflare__derive_semis(lflare_lens *lens, const lflare__paraxial *x)
{
    lflare_prescription *p = &lens->prescription;
    double diagonal = sqrt(p->sensor_width * p->sensor_width + p->sensor_height * p->sensor_height);
    double u = lflare__min(0.5 * diagonal / lens->efl, 1.2);
    double entrance = p->surfaces[lens->stop].semi_diameter / fabs(lens->stop_a11);
    double chief = -x->before[lens->stop].b / lens->stop_a11 * u; /* meets the stop's centre */
    int32_t i, k;
    for (i = 0; i < p->surface_count; i++) {
        lflare_surface *s = &p->surfaces[i];
        int derived = s->semi_diameter == 0;
        double stated = s->semi_diameter;
        if (derived) {
            const lflare_matrix *m = &x->before[i];
            s->semi_diameter = lflare__clamp(1.02 * lflare__max(fabs(m->a) * entrance, fabs(m->a * chief + m->b * u)), 1e-4, 1e5);
        }
        for (k = 0; k < 400 && !lflare__finite(lflare_sag(s, s->semi_diameter * (derived ? 1.03 : 1))); k++) s->semi_diameter *= 0.98;
        if (derived) lflare__note(lens, LFLARE_NOTE_SEMI_DERIVED, i, s->semi_diameter, 0);
        else if (k > 0) lflare__note(lens, LFLARE_NOTE_SEMI_REDUCED, i, s->semi_diameter, stated);
    }
    for (i = 0; i < lens->note_count; i++) { /* neighbours: only what was derived gives way */
        lflare_note *note = &lens->notes[i];
        if (note->kind != LFLARE_NOTE_SEMI_DERIVED) continue;
        for (k = 0; k < 200; k++) {
            int32_t j = note->surface;
            if ((j == 0 || lflare__edge(p, j - 1) >= 0) && (j + 1 >= p->surface_count || lflare__edge(p, j) >= 0)) break;
            if (p->surfaces[j].semi_diameter < 0.5 * entrance * fabs(x->before[j].a)) break;
            note->value = p->surfaces[j].semi_diameter *= 0.98;
        }
    }
    for (i = 0; i + 1 < p->surface_count; i++) {
        double edge = lflare__edge(p, i);
        if (edge < -0.01 * lflare__min(p->surfaces[i].semi_diameter, p->surfaces[i + 1].semi_diameter))
            lflare__note(lens, LFLARE_NOTE_EDGES_CROSS, i, edge, 0);
    }
}

LFLARE_API lflare_result lflare_lens_derive(const lflare_prescription *prescription, lflare_lens *lens, lflare_error *error)
{
    lflare__paraxial x;
    lflare_result result;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (prescription == NULL || lens == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no prescription or no lens given");
    memset(lens, 0, sizeof *lens);
    lens->prescription = *prescription;
    lens->surface_count = prescription->surface_count;
    result = lflare__check_rows(&lens->prescription, lens, error);
    if (result == LFLARE_OK) result = lflare__derive_image(lens, error);
    if (result != LFLARE_OK) return result;
    lflare__paraxial_make(lens, LFLARE__NM_D, &x);
    result = lflare__derive_stop(lens, &x, error);
    if (result != LFLARE_OK) return result;
    lflare__derive_semis(lens, &x);
    lflare_ghost_list(lens, NULL, &lens->ghost_count);
    return LFLARE_OK;
}

/* >> 6 ghosts */

/* Whether there are paths across the stop and of four reflections. A constant, so that compilers leave out what serves them alone. */
#ifndef LFLARE_NO_TRACE
enum { LFLARE__MORE_PATHS = 1, LFLARE__TURNS = 4 };
#else
enum { LFLARE__MORE_PATHS = 0, LFLARE__TURNS = 2 };
#endif

LFLARE_API lflare_result lflare_ghost_list(const lflare_lens *lens, lflare_pair *out, int32_t *count)
{
    int32_t i, j, n = 0, room;
    int reflects[LFLARE_MAX_SURFACES];
    if (lens == NULL || count == NULL || (out == NULL && *count > 0)) return LFLARE_ERROR_ARGUMENT;
    room = *count;
    for (i = 0; i < lens->surface_count; i++) reflects[i] = lflare__reflects(&lens->prescription, i);
    for (i = 1; i < lens->surface_count; i++)
        for (j = i > lens->stop && !(LFLARE__MORE_PATHS && lens->paths.across_stop) ? lens->stop + 1 : 0; j < i && reflects[i]; j++) {
            if (!reflects[j]) continue;
            if (n < room) {
                out[n].first = i;
                out[n].second = j;
                out[n].third = out[n].fourth = 0;
            }
            n++;
        }
    for (i = 0; LFLARE__MORE_PATHS && i < lens->four_count; i++, n++)
        if (n < room) out[n] = lens->four[i];
    *count = n;
    return n > room ? LFLARE_INCOMPLETE : LFLARE_OK;
}

/* A path's reflections in order, and the foremost and rearmost of them. */
typedef struct lflare__turns {
    int32_t at[LFLARE__TURNS], count, front, back;
} lflare__turns;

static lflare__turns lflare__turns_of(lflare_pair p)
{
    lflare__turns t;
    t.at[0] = t.back = p.first;
    t.at[1] = t.front = p.second;
    t.count = 2;
#ifndef LFLARE_NO_TRACE
    if (p.third == 0 && p.fourth == 0) return t;
    t.at[2] = p.third;
    t.at[3] = p.fourth;
    t.count = 4;
    if (p.third > t.back) t.back = p.third;
    if (p.fourth < t.front) t.front = p.fourth;
#endif
    return t;
}

static int lflare__crosses_stop(const lflare_lens *lens, const lflare__turns *t) { return LFLARE__MORE_PATHS && t->front < lens->stop && t->back > lens->stop; }

static int lflare__valid_pair(const lflare_lens *lens, lflare_pair p)
{
    lflare__turns t = lflare__turns_of(p);
    int32_t i;
    for (i = 0; i < t.count; i++)
        if (t.at[i] == lens->stop || (i > 0 && (i % 2 != 0 ? t.at[i] >= t.at[i - 1] : t.at[i] <= t.at[i - 1]))) return 0;
    return t.front >= 0 && t.back < lens->surface_count && ((LFLARE__MORE_PATHS && lens->paths.across_stop) || t.front > lens->stop || t.back < lens->stop);
}

/* Walks the path, one crossing a call; m carries from the entrance to just before the crossing. */
typedef struct lflare__walk {
    const lflare_lens *lens;
    const double *n;
    int32_t turns[LFLARE__TURNS], turn_count;
    lflare_matrix m;
    int32_t surface, leg; /* forward on legs 0, 2 and 4, back on 1 and 3 */
    int32_t iris;         /* crossings of the stop up to the one that blades shape */
} lflare__walk;

static int lflare__walk_next(lflare__walk *w, lflare_crossing *out)
{
    const lflare_surface *s = w->lens->prescription.surfaces;
    int32_t i = w->surface;
    double c;
    if (i >= w->lens->surface_count) return 0;
    out->surface = i;
    out->reflected = w->leg < (LFLARE__MORE_PATHS ? w->turn_count : 2) && i == w->turns[w->leg];
    out->backwards = w->leg & 1;
    out->iris = i == w->lens->stop && (!LFLARE__MORE_PATHS || w->iris-- == 0);
    out->n_in = w->n[i + out->backwards];
    out->n_out = w->n[i + 1 - out->backwards];
    c = out->backwards ? -w->lens->curvature[i] : w->lens->curvature[i];
    out->a = w->m.a;
    out->b = w->m.b;
    out->p = w->m.c + c * w->m.a;
    out->q = w->m.d + c * w->m.b;
    if (out->reflected) {
        lflare__reflect(&w->m, c);
        w->leg++;
    } else {
        lflare__refract(&w->m, out->n_in, out->n_out, c);
    }
    w->surface = w->leg & 1 ? i - 1 : i + 1;
    lflare__translate(&w->m, s[w->leg & 1 ? i - 1 : i].thickness);
    return 1;
}

static void lflare__walk_start(lflare__walk *w, const lflare_lens *lens, const double *n, lflare_pair pair)
{
    double d_line[LFLARE_MAX_SURFACES + 1], most = -1;
    lflare__turns t = lflare__turns_of(pair);
    lflare__walk search;
    lflare_crossing x;
    int32_t stops = 0;
    w->lens = lens;
    w->n = n;
    for (w->turn_count = 0; w->turn_count < t.count; w->turn_count++) w->turns[w->turn_count] = t.at[w->turn_count];
    w->m = lflare__identity;
    w->surface = w->leg = w->iris = 0;
    if (!lflare__crosses_stop(lens, &t)) return;
    lflare__indices(&lens->prescription, LFLARE__NM_D, d_line); /* one wavelength, so that all agree */
    search = *w;
    search.n = d_line;
    while (lflare__walk_next(&search, &x)) {
        if (x.surface != lens->stop) continue;
        if (fabs(x.a) > 1.000001 * most) {
            most = fabs(x.a);
            w->iris = stops;
        }
        stops++;
    }
}

/* From just before `first`, going forward, to just before `second`, coming back: the part that all ghosts of one `first`
   share step by step. */
static void lflare__back_start(const lflare_lens *lens, int32_t first, lflare_matrix *m)
{
    lflare__reflect(m, lens->curvature[first]);
    lflare__translate(m, lens->prescription.surfaces[first - 1].thickness);
}

static void lflare__back_step(const lflare_lens *lens, const double *n, int32_t surface, lflare_matrix *m)
{
    lflare__refract(m, n[surface + 1], n[surface], -lens->curvature[surface]);
    lflare__translate(m, lens->prescription.surfaces[surface - 1].thickness);
}

/* Step by step, where ghosts share too little. */
static void lflare__walked_optics(const lflare_lens *lens, const double *n, lflare_pair pair, lflare_ghost_matrices *out)
{
    lflare__walk walk, before;
    lflare_crossing x;
    lflare__walk_start(&walk, lens, n, pair);
    for (before = walk; lflare__walk_next(&walk, &x); before = walk)
        if (x.iris) { /* begin anew there */
            out->ma = before.m;
            walk = before;
            walk.m = lflare__identity;
            lflare__walk_next(&walk, &x);
        }
    out->ms = walk.m;
    out->m = lflare__product(out->ms, out->ma);
}

LFLARE_API lflare_result lflare_ghost_optics(const lflare_lens *lens, double nm, const lflare_pair *pairs, int32_t count, lflare_ghost_matrices *out)
{
    lflare__paraxial x;
    lflare_matrix back = lflare__identity;
    int32_t g, first = -1, at = -1; /* `back` carries from the entrance to just before surface `at`, coming from `first` */
    if (lens == NULL || count < 0 || (count > 0 && (pairs == NULL || out == NULL))) return LFLARE_ERROR_ARGUMENT;
    lflare__paraxial_make(lens, nm, &x);
    for (g = count - 1; g >= 0; g--) { /* the list has second ascending: downwards every step is new */
        lflare_pair p = pairs[g];
        lflare__turns turns = lflare__turns_of(p);
        lflare_matrix m;
        if (!lflare__valid_pair(lens, p)) return LFLARE_ERROR_ARGUMENT;
        if (LFLARE__MORE_PATHS && (turns.count > 2 || lflare__crosses_stop(lens, &turns))) {
            lflare__walked_optics(lens, x.n, p, &out[g]);
            continue;
        }
        if (p.first != first || p.second > at) {
            first = p.first;
            at = first - 1;
            back = x.before[first];
            lflare__back_start(lens, first, &back);
        }
        for (; at > p.second; at--) lflare__back_step(lens, x.n, at, &back);
        m = back;
        lflare__reflect(&m, -lens->curvature[p.second]);
        out[g].m = lflare__product(x.to_sensor[p.second], m);
        if (p.first < lens->stop) {
            out[g].ma = lflare__product(x.to_stop[p.second], m);
            out[g].ms = x.to_sensor[lens->stop];
        } else {
            out[g].ma = x.before[lens->stop];
            out[g].ms = lflare__product(out[g].m, lflare__inverse(out[g].ma));
        }
    }
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_ghost_path(const lflare_lens *lens, double nm, lflare_pair pair, lflare_crossing *out, int32_t *count)
{
    double n[LFLARE_MAX_SURFACES + 1];
    lflare__walk walk;
    lflare_crossing crossing;
    int32_t used = 0;
    if (lens == NULL || count == NULL || (out == NULL && *count > 0) || !lflare__valid_pair(lens, pair)) return LFLARE_ERROR_ARGUMENT;
    lflare__indices(&lens->prescription, nm, n);
    lflare__walk_start(&walk, lens, n, pair);
    while (lflare__walk_next(&walk, &crossing)) {
        if (used < *count) out[used] = crossing;
        used++;
    }
    if (used <= *count) { *count = used; return LFLARE_OK; }
    *count = used;
    return LFLARE_INCOMPLETE;
}

/* A clipping condition |a r + b u| <= h as a circle in the entrance plane. Where a is tiny the rim passes all or nothing;
   a circle of 10^4 times the entrance then stands for its nearly straight edge (P 3). */
static lflare_circle lflare__circle(double a, double b, double h, double entrance)
{
    lflare_circle c;
    double least = 1e-4 * h / entrance;
    if (fabs(a) < least) a = a < 0 ? -least : least;
    c.centre = -b / a;
    c.radius = h / fabs(a);
    return c;
}

/* The boundary above the axis is y^2 = min over circles of (r^2 - (x - cu)^2) = min(alpha + beta x) - x^2: a lower envelope
   of lines, walked from left to right. `visit`, per stretch, gets circle and ends. */
typedef struct lflare__stretch {
    int32_t circle;
    double from, to;
} lflare__stretch;

/* alpha; beta is 2 centre u */
static double lflare__square_at(lflare_circle c, double u) { return (c.radius - c.centre * u) * (c.radius + c.centre * u); }

static int32_t lflare__envelope(const lflare_circle *c, int32_t count, double u, lflare__stretch *out, double *lo, double *hi)
{
    int32_t k, n = 0, at = 0;
    double x;
    *lo = -HUGE_VAL;
    *hi = HUGE_VAL;
    for (k = 0; k < count; k++) {
        double left = c[k].centre * u - c[k].radius, right = c[k].centre * u + c[k].radius;
        if (left > *lo || (left == *lo && c[k].radius < c[at].radius)) { *lo = left; at = k; }
        *hi = lflare__min(*hi, right);
    }
    if (!(*lo < *hi)) return 0;
    for (x = *lo; n < count;) {
        double next = *hi, here = lflare__square_at(c[at], u);
        int32_t follower = -1;
        for (k = 0; k < count; k++) { /* only lines of lesser slope can get below */
            double slope = 2 * u * (c[at].centre - c[k].centre), rise;
            if (!(slope > 0)) continue;
            rise = lflare__square_at(c[k], u) - here;
            if (rise < next * slope) {
                next = lflare__max(rise / slope, x);
                follower = k;
            }
        }
        out[n].circle = at;
        out[n].from = x;
        out[n].to = next;
        n++;
        if (follower < 0) break;
        x = next;
        at = follower;
    }
    return n;
}

/* Integrals over one stretch of circle, between t = x - cu of its ends: area, first moment, turning. */
static double lflare__chord(double r, double t) { return sqrt(lflare__max((r - t) * (r + t), 0)); }

LFLARE_API lflare_region lflare_region_of(const lflare_circle *circles, int32_t count, double u, double *turn)
{
    lflare__stretch stretches[LFLARE_MAX_CIRCLES];
    lflare_region region;
    double moment = 0;
    int32_t i, n;
    LFLARE_ASSERT(count >= 1 && count <= LFLARE_MAX_CIRCLES);
    n = lflare__envelope(circles, count, u, stretches, &region.lo, &region.hi);
    region.area = 0;
    region.centroid = 0.5 * (region.lo + region.hi);
    for (i = 0; turn != NULL && i < count; i++) turn[i] = 0;
    for (i = 0; i < n; i++) {
        lflare_circle c = circles[stretches[i].circle];
        double centre = c.centre * u, r = c.radius;
        double t0 = lflare__clamp(stretches[i].from - centre, -r, r), t1 = lflare__clamp(stretches[i].to - centre, -r, r);
        double y0 = lflare__chord(r, t0), y1 = lflare__chord(r, t1);
        double angle = asin(t1 / r) - asin(t0 / r);
        double area = t1 * y1 - t0 * y0 + r * r * angle; /* both halves */
        region.area += area;
        moment += centre * area + 2.0 / 3.0 * (y0 * y0 * y0 - y1 * y1 * y1);
        if (turn != NULL) turn[stretches[i].circle] += 2 * angle;
    }
    if (region.area > 1e-12 * (region.hi - region.lo) * (region.hi - region.lo)) {
        region.centroid = lflare__clamp(moment / region.area, region.lo, region.hi);
    } else {
        double reach = circles[0].radius, middle = circles[0].centre * u;
        region.area = 0;
        region.centroid = lflare__clamp(region.centroid, middle - reach, middle + reach);
    }
    return region;
}

/* From this slope on two of the circles no longer meet; all circles on one line meet if each two do. */
static double lflare__part(const lflare_circle *a, const lflare_circle *b, double u)
{
    double gap = fabs(a->centre - b->centre), reach = a->radius + b->radius;
    return reach < u * gap ? reach / gap : u;
}

static double lflare__hidden_slope(const lflare_circle *c, int32_t count, int32_t *pair)
{
    double u = 60; /* 89 degrees */
    int32_t i, k;
    pair[0] = pair[1] = 0;
    for (i = 0; i < count; i++)
        for (k = 0; k < i; k++) {
            double parted = lflare__part(&c[i], &c[k], u);
            if (parted < u) {
                u = parted;
                pair[0] = i;
                pair[1] = k;
            }
        }
    return u;
}

/* A path at one wavelength: its circles (the pupil at 0, the iris at 1, a rim per crossing after them, those of the stop that blades do not
   shape among them), each one's height coefficients, and the whole matrix. */
typedef struct lflare__rims {
    lflare_circle circles[LFLARE_MAX_CIRCLES];
    double a[LFLARE_MAX_CIRCLES], b[LFLARE_MAX_CIRCLES];
    int32_t surface[LFLARE_MAX_CIRCLES];
    lflare_matrix m;
} lflare__rims;

static int32_t lflare__collect_rims(const lflare_lens *lens, const double *n, lflare_pair pair, double iris, lflare__rims *out)
{
    const lflare_surface *s = lens->prescription.surfaces;
    int32_t count = 2, at;
    lflare__walk walk;
    lflare_crossing x;
    lflare__walk_start(&walk, lens, n, pair);
    out->circles[0].centre = 0;
    out->circles[0].radius = s[0].semi_diameter;
    while (lflare__walk_next(&walk, &x)) {
        at = x.iris ? 1 : count++;
        out->circles[at] = lflare__circle(x.a, x.b, x.surface == lens->stop ? iris : s[x.surface].semi_diameter, s[0].semi_diameter);
        out->a[at] = x.a;
        out->b[at] = x.b;
        out->surface[at] = x.surface;
    }
    out->m = walk.m;
    return count;
}

LFLARE_API lflare_clip lflare_ghost_clip(const lflare_lens *lens, double nm, lflare_pair pair, double iris, double u, lflare_region *region)
{
    lflare__rims rims;
    lflare_circle *c = rims.circles, pupil;
    int32_t count, k;
    double n[LFLARE_MAX_SURFACES + 1], d, whole, worst = 0, ends = 0;
    lflare_region local;
    if (region == NULL) region = &local;
    LFLARE_ASSERT(lflare__valid_pair(lens, pair));
    u = fabs(u);
    lflare__indices(&lens->prescription, nm, n);
    count = lflare__collect_rims(lens, n, pair, iris, &rims);
    *region = lflare_region_of(c, count, u, NULL);
    whole = region->area;
    d = fabs(c[1].centre) * u;
    if (whole <= 0 || d >= c[0].radius + c[1].radius) return LFLARE_CLIP_HIDDEN;
    /* what each circle takes from the intersection of the others */
    for (k = 0; k < count; k++) {
        lflare_circle kept = c[k];
        double cut;
        c[k] = c[k == 0 ? 1 : 0]; /* stands in for the one left out */
        cut = lflare_region_of(c, count, u, NULL).area - whole;
        c[k] = kept;
        if (k < 2) ends = lflare__max(ends, cut);
        else worst = lflare__max(worst, cut);
    }
    if (worst > ends) return LFLARE_CLIP_RIM;
    pupil = c[0];
    if (d + c[1].radius <= pupil.radius) return LFLARE_CLIP_IRIS;
    if (d + pupil.radius <= c[1].radius) return LFLARE_CLIP_PUPIL;
    return LFLARE_CLIP_BOTH;
}

/* >> 7 coating */

/* A stack's characteristic matrix [a, i b; i c, d] for one polarisation: its entries are real, for evanescent layers too. */
typedef struct lflare__stack {
    double a, b, c, d;
} lflare__stack;

/* One more layer behind: cosine and sine (hyperbolic if evanescent, `sign` then -1) of its phase, admittance y. */
LFLARE__APART static void lflare__stack_add(lflare__stack *m, double cosine, double sine, double y, double sign)
{
    double b = sine / y, c = sign * sine * y, na = m->a * cosine - m->b * c, nc = m->c * cosine + m->d * c;
    m->b = m->a * b + m->b * cosine;
    m->d = m->d * cosine - m->c * b;
    m->a = na;
    m->c = nc;
}

/* Power reflected between admittances y0 and y1. */
static double lflare__stack_reflectance(const lflare__stack *m, double y0, double y1)
{
    double er = y0 * m->a, ei = y0 * m->b * y1, hr = m->d * y1, hi = m->c;
    double scale = 1 / lflare__max(lflare__max(fabs(er), fabs(ei)), lflare__max(fabs(hr), fabs(hi)));
    double mr = (er - hr) * scale, mi = (ei - hi) * scale, pr = (er + hr) * scale, pi = (ei + hi) * scale;
    return (mr * mr + mi * mi) / (pr * pr + pi * pi);
}

/* Bare surfaces come out of the empty product; the cosine form has no 0/0 at normal incidence (P 5). */
LFLARE_API double lflare_film_reflectance(double n0, double n1, const lflare_layer *layers, int32_t count, double nm, double s)
{
    lflare__stack m[2] = {{1, 0, 0, 1}, {1, 0, 0, 1}}; /* s, p */
    double cos0, cos1, sum = 0;
    int32_t i, p;
    if (s >= n0 || s >= n1) return 1;
    cos0 = sqrt((1 - s / n0) * (1 + s / n0));
    cos1 = sqrt((1 - s / n1) * (1 + s / n1));
    for (i = 0; i < count; i++) {
        double n = layers[i].n, cos2 = (1 - s / n) * (1 + s / n), q = sqrt(lflare__max(fabs(cos2), 1e-18));
        double phase = 2 * LFLARE__PI * layers[i].thickness_nm / nm * n * q;
        int evanescent = cos2 < 0;
        double cosine = evanescent ? cosh(lflare__min(phase, 300)) : cos(phase), sine = evanescent ? sinh(lflare__min(phase, 300)) : sin(phase);
        for (p = 0; p < 2; p++) lflare__stack_add(&m[p], cosine, sine, p == 0 ? n * q : evanescent ? -n / q : n / q, evanescent ? -1 : 1);
    }
    for (p = 0; p < 2; p++) sum += p == 0 ? lflare__stack_reflectance(&m[p], n0 * cos0, n1 * cos1) : lflare__stack_reflectance(&m[p], n0 / cos0, n1 / cos1);
    return lflare__clamp(0.5 * sum, 0, 1);
}

LFLARE_API lflare_result lflare_film_layers(const lflare_lens *lens, int32_t surface, lflare_layer *out, int32_t *count)
{
    const lflare_surface *s;
    int32_t room, i;
    if (lens == NULL || count == NULL || surface < 0 || surface >= lens->surface_count || (out == NULL && *count > 0)) return LFLARE_ERROR_ARGUMENT;
    s = &lens->prescription.surfaces[surface];
    room = *count;
    *count = s->is_stop ? 0 : s->coating == LFLARE_COATING_STACK ? s->layer_count : s->coating == LFLARE_COATING_QUARTER;
    for (i = 0; i < *count && i < room; i++) {
        if (s->coating == LFLARE_COATING_STACK) {
            out[i] = lens->prescription.layers[s->first_layer + i];
        } else {
            double n[LFLARE_MAX_SURFACES + 1];
            lflare__indices(&lens->prescription, s->quarter_nm, n);
            out[i].n = lflare__max(sqrt(n[surface] * n[surface + 1]), 1.38);
            out[i].thickness_nm = s->quarter_nm / (4 * out[i].n);
        }
    }
    return *count > room ? LFLARE_INCOMPLETE : LFLARE_OK;
}

LFLARE_API double lflare_ghost_weight(const lflare_lens *lens, double nm, lflare_pair pair, double x, double u)
{
    double n[LFLARE_MAX_SURFACES + 1], w = 1;
    lflare_layer layers[LFLARE_MAX_LAYERS];
    lflare__walk walk;
    lflare_crossing at;
    LFLARE_ASSERT(lflare__valid_pair(lens, pair));
    lflare__indices(&lens->prescription, nm, n);
    lflare__walk_start(&walk, lens, n, pair);
    while (lflare__walk_next(&walk, &at)) {
        double tangent = at.p * x + at.q * u, s = at.n_in * fabs(tangent) / sqrt(1 + tangent * tangent), r;
        int32_t count = LFLARE_MAX_LAYERS;
        if (at.surface == lens->stop) continue;
        lflare_film_layers(lens, at.surface, layers, &count);
        /* from the front side whichever way the ray goes: the reflectance is the same from behind at equal n sin(theta) */
        r = n[at.surface] == n[at.surface + 1] && count == 0 ? 0 : lflare_film_reflectance(n[at.surface], n[at.surface + 1], layers, count, nm, s);
        w *= at.reflected ? r : 1 - r;
    }
    return w;
}

#ifndef LFLARE_NO_TRACE
/* -- ghosts of four reflections: which are worth keeping -- */

/* Paths make a tree, along which power and open entrance only fall: what can no longer reach the weakest of those kept is left. */
typedef struct lflare__ranker {
    const lflare_lens *lens;
    double n[LFLARE_MAX_SURFACES + 1], reflectance[LFLARE_MAX_SURFACES], clear[LFLARE_MAX_SURFACES];
    int reflects[LFLARE_MAX_SURFACES];
    double at_most[5];              /* power left by the reflections that follow on each leg */
    double frame;                   /* its area over pi */
    int32_t front, back;            /* paths turn from here to there */
    int32_t turns[4], count, room;
    int32_t crossings;              /* that may still be looked at */
    float flux[LFLARE_MAX_FOUR];    /* of those kept, the strongest first, */
    uint32_t keys[LFLARE_MAX_FOUR]; /* and their surfaces, 7 bits each */
} lflare__ranker;

/* On its way: height and slope, behind the last surface, of the ray that enters at 1 along the axis; power; radius of the open entrance. */
typedef struct lflare__branch {
    double height, slope, power, radius;
} lflare__branch;

static void lflare__rank_keep(lflare__ranker *r, float flux)
{
    uint32_t key = (uint32_t)r->turns[0] << 21 | (uint32_t)r->turns[1] << 14 | (uint32_t)r->turns[2] << 7 | (uint32_t)r->turns[3];
    int32_t at = r->count, i;
    while (at > 0 && (flux > r->flux[at - 1] || (flux == r->flux[at - 1] && key < r->keys[at - 1]))) at--; /* of equals the lesser key */
    if (!(flux > 0) || at == r->room) return;
    if (r->count < r->room) r->count++;
    for (i = r->count - 1; i > at; i--) {
        r->flux[i] = r->flux[i - 1];
        r->keys[i] = r->keys[i - 1];
    }
    r->flux[at] = flux;
    r->keys[at] = key;
}

/* The branch goes on to the vertex of surface `at`; 0 if it is not worth following. Equals come in the order of their keys, so that
   what can but equal the weakest is not, either. */
static int lflare__rank_reach(lflare__ranker *r, lflare__branch *b, int32_t at, int32_t leg)
{
    const lflare_surface *s = r->lens->prescription.surfaces;
    if (r->crossings-- <= 0) return 0;
    b->height += leg & 1 ? b->slope * s[at].thickness : at > 0 ? b->slope * s[at - 1].thickness : 0;
    b->radius = lflare__min(b->radius, r->clear[at] / fabs(b->height));
    return (float)((1 + 1e-12) * b->power * r->at_most[leg] * b->radius * b->radius / r->frame) > (r->count < r->room ? 0 : r->flux[r->room - 1]);
}

static void lflare__rank_cross(const lflare__ranker *r, lflare__branch *b, int32_t at, int32_t backwards)
{
    double c = backwards ? -r->lens->curvature[at] : r->lens->curvature[at], n1 = r->n[at + backwards], n2 = r->n[at + 1 - backwards];
    b->slope = (n1 - n2) / n2 * c * b->height + n1 / n2 * b->slope;
    b->power *= 1 - r->reflectance[at];
}

static void lflare__rank_turn(lflare__ranker *r, lflare__branch b, int32_t at, int32_t leg);

/* From just in front of surface at + 1 on: the foremost turn comes first. */
static void lflare__rank_back(lflare__ranker *r, lflare__branch b, int32_t at, int32_t leg)
{
    lflare__branch there[LFLARE_MAX_SURFACES];
    int32_t from = at, k;
    for (; at >= r->front && lflare__rank_reach(r, &b, at, leg); at--) {
        there[at] = b;
        lflare__rank_cross(r, &b, at, 1);
    }
    for (k = at + 1; k <= from; k++) lflare__rank_turn(r, there[k], k, leg);
}

/* From just behind surface at - 1 on, on an even leg, turning at every surface that comes. */
static void lflare__rank_forward(lflare__ranker *r, lflare__branch b, int32_t at, int32_t leg)
{
    int32_t last = leg < 4 ? r->back : r->lens->surface_count - 1;
    for (; at <= last; at++) {
        if (!lflare__rank_reach(r, &b, at, leg)) return;
        if (leg < 4 && at >= r->front) lflare__rank_turn(r, b, at, leg);
        lflare__rank_cross(r, &b, at, 0);
    }
    if (leg == 4) {
        double area = b.radius * b.radius, m11 = b.height + b.slope * r->lens->prescription.surfaces[last].thickness;
        lflare__rank_keep(r, (float)(b.power * area / lflare__max(r->frame, area * m11 * m11)));
    }
}

static void lflare__rank_turn(lflare__ranker *r, lflare__branch b, int32_t at, int32_t leg)
{
    if (!r->reflects[at]) return;
    b.slope += (leg & 1 ? -2 : 2) * r->lens->curvature[at] * b.height;
    b.power *= r->reflectance[at];
    r->turns[leg] = at;
    if (leg & 1) lflare__rank_forward(r, b, at + 1, leg + 1);
    else lflare__rank_back(r, b, at - 1, leg + 1);
}

static void lflare__rank_side(lflare__ranker *r, int32_t front, int32_t back)
{
    lflare__branch b = {1, 0, 1, 0};
    b.radius = r->clear[0];
    r->front = front;
    r->back = back;
    lflare__rank_forward(r, b, 0, 0);
}

static void lflare__rank_make(lflare__ranker *r, const lflare_lens *lens, double nm)
{
    lflare_layer layers[LFLARE_MAX_LAYERS];
    double most = 0;
    int32_t i;
    r->lens = lens;
    r->frame = lens->sensor_width * lens->sensor_height / LFLARE__PI;
    r->count = 0;
    r->room = lens->paths.four;
    r->crossings = 1 << 23; /* 40 times what a zoom of 34 surfaces takes; 0.15 s */
    lflare__indices(&lens->prescription, nm, r->n);
    for (i = 0; i < lens->surface_count; i++) {
        int32_t count = LFLARE_MAX_LAYERS;
        lflare_film_layers(lens, i, layers, &count);
        r->reflects[i] = lflare__reflects(&lens->prescription, i);
        r->reflectance[i] = lflare_film_reflectance(r->n[i], r->n[i + 1], layers, count, nm, 0);
        r->clear[i] = lens->prescription.surfaces[i].semi_diameter;
        if (r->reflects[i]) most = lflare__max(most, r->reflectance[i]);
    }
    r->clear[lens->stop] = fabs(lens->stop_a11) * lens->efl / (2 * lflare__max((double)LFLARE_NORMAL_FNUMBER, lens->fnumber));
    r->at_most[4] = 1;
    for (i = 3; i >= 0; i--) r->at_most[i] = most * r->at_most[i + 1];
}

static void lflare__rank_four(lflare_lens *lens)
{
    lflare__ranker r;
    int32_t i, k;
    lflare__rank_make(&r, lens, lflare__rgb_nm[1]);
    if (lens->paths.across_stop) {
        lflare__rank_side(&r, 0, lens->surface_count - 1);
    } else {
        lflare__rank_side(&r, 0, lens->stop - 1);
        lflare__rank_side(&r, lens->stop + 1, lens->surface_count - 1);
    }
    for (i = 1; i < r.count; i++) { /* by surfaces: rounding that differs from machine to machine then changes the last of them at most */
        uint32_t key = r.keys[i];
        for (k = i; k > 0 && key < r.keys[k - 1]; k--) r.keys[k] = r.keys[k - 1];
        r.keys[k] = key;
    }
    for (i = 0; i < r.count; i++) {
        lens->four[i].first = (int32_t)(r.keys[i] >> 21);
        lens->four[i].second = (int32_t)(r.keys[i] >> 14 & 127);
        lens->four[i].third = (int32_t)(r.keys[i] >> 7 & 127);
        lens->four[i].fourth = (int32_t)(r.keys[i] & 127);
    }
    lens->four_count = r.count;
}

LFLARE_API lflare_result lflare_lens_paths(lflare_lens *lens, const lflare_paths *paths, lflare_error *error)
{
    if (error != NULL) memset(error, 0, sizeof *error);
    if (lens == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no lens given");
    if (paths != NULL && (paths->across_stop < 0 || paths->across_stop > 1 || paths->four < 0 || paths->four > LFLARE_MAX_FOUR))
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "paths: across_stop is 0 or 1, four 0 to %i", (int32_t)LFLARE_MAX_FOUR);
    lens->paths.across_stop = paths != NULL ? paths->across_stop : 0;
    lens->paths.four = paths != NULL ? paths->four : 0;
    lens->four_count = lens->ghost_count = 0;
    if (lens->paths.four > 0) lflare__rank_four(lens);
    lflare_ghost_list(lens, NULL, &lens->ghost_count);
    return LFLARE_OK;
}
#else
LFLARE_API lflare_result lflare_lens_paths(lflare_lens *lens, const lflare_paths *paths, lflare_error *error)
{
    if (lens != NULL && (paths == NULL || (paths->across_stop | paths->four) == 0)) return LFLARE_OK;
    return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "LFLARE_NO_TRACE leaves out other paths");
}
#endif

/* A surface's reflectance over the cosine c in the rarer medium, where it is smooth up to grazing incidence; n sin(theta)
   follows from it. Beyond the critical angle it is 1. `row` holds 4 floats a sample. */
static void lflare__film_row(const lflare_lens *lens, int32_t surface, lflare_layer *scratch, float *row)
{
    int32_t i, k, count = LFLARE_MAX_LAYERS;
    lflare_film_layers(lens, surface, scratch, &count);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        double n[LFLARE_MAX_SURFACES + 1], rarer;
        lflare__indices(&lens->prescription, lflare__rgb_nm[k], n);
        rarer = lflare__min(n[surface], n[surface + 1]);
        for (i = 0; i < LFLARE_FILM_SAMPLES; i++) {
            double c = (double)i / (LFLARE_FILM_SAMPLES - 1);
            double r = n[surface] == n[surface + 1] && count == 0
                           ? 0
                           : lflare_film_reflectance(n[surface], n[surface + 1], scratch, count, lflare__rgb_nm[k], rarer * sqrt((1 - c) * (1 + c)));
            row[i * 4 + k] = (float)r;
        }
    }
    for (i = 0; i < LFLARE_FILM_SAMPLES; i++) row[i * 4 + 3] = 0;
}

/* Cubic through four samples `step` floats apart, the second of which is row[0]; f from there. */
static float lflare__cubic(const float *row, int32_t step, float f)
{
    float p0 = row[-step], p1 = row[0], p2 = row[step], p3 = row[2 * step];
    return p1 + f * (p2 - p0 / 3 - p1 / 2 - p3 / 6 + f * (p0 / 2 - p1 + p2 / 2 + f * ((p1 - p2) / 2 + (p3 - p0) / 6)));
}

/* Films have narrow minima, and a ghost's colour is made of them: hence the cubic. */
static float lflare__film_lookup(const float *row, int32_t k, float cosine)
{
    float t = cosine * (LFLARE_FILM_SAMPLES - 1);
    int32_t i = (int32_t)t;
    i = i < 1 ? 1 : i > LFLARE_FILM_SAMPLES - 3 ? LFLARE_FILM_SAMPLES - 3 : i;
    return lflare__cubic(row + i * 4 + k, 4, t - (float)i);
}

#ifdef LFLARE__PATCHES
/* Of a ghost whose wavelengths have one each, or all have one. */
static int32_t lflare__meshes(const lflare_tables *t, int split) { return !split ? 1 : t->wavelength_count > 0 ? t->wavelength_count : LFLARE_WAVELENGTHS; }

/* -- more than three wavelengths -- */

#ifndef LFLARE_NO_TRACE
#define LFLARE__LONGEST 700.0 /* nm */
#define LFLARE__SHORTEST 400.0

/* Indices go by 1 / wavelength^2, nearly: places are interpolated by it. */
static double lflare__dispersion(double nm) { return 1e6 / (nm * nm); }

/* The i-th end of the intervals that wavelengths stand for, equally far apart in dispersion. */
static double lflare__interval(int32_t i, int32_t count)
{
    double first = lflare__dispersion(LFLARE__LONGEST), last = lflare__dispersion(LFLARE__SHORTEST);
    return 1e3 / sqrt(first + (last - first) * i / count);
}

/* What an interval of equal power adds to RGB. */
static void lflare__interval_rgb(int32_t i, int32_t count, double *rgb)
{
    const int32_t parts = 16;
    double lo = lflare__interval(i, count), hi = lflare__interval(i + 1, count), part[3];
    int32_t j, k;
    for (k = 0; k < 3; k++) rgb[k] = 0;
    for (j = 0; j < parts; j++) {
        lflare_wavelength_rgb(lo + (hi - lo) * (j + 0.5) / parts, part);
        for (k = 0; k < 3; k++) rgb[k] += part[k] * fabs(hi - lo) / parts;
    }
}

/* Wavelengths, what of the three makes their places, and what of sRGB they add: all of them white. */
static void lflare__spectral_make(lflare_tables *t, int32_t count)
{
    double known[LFLARE_WAVELENGTHS], white[3] = {0, 0, 0};
    int32_t i, j, k;
    memset(t->spectral, 0, sizeof t->spectral);
    t->wavelength_count = count > LFLARE_WAVELENGTHS ? count : 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) known[k] = lflare__dispersion(lflare__rgb_nm[k]);
    for (i = 0; i < t->wavelength_count; i++) {
        float *row = t->spectral[i];
        double nm = lflare__interval(2 * i + 1, 2 * count), at = lflare__dispersion(nm), rgb[3];
        row[3] = (float)nm;
        for (k = 0; k < LFLARE_WAVELENGTHS; k++)
            for (row[k] = 1, j = 0; j < LFLARE_WAVELENGTHS; j++)
                if (j != k) row[k] *= (float)((at - known[j]) / (known[k] - known[j]));
        lflare__interval_rgb(i, count, rgb);
        for (k = 0; k < 3; k++) {
            row[4 + k] = (float)rgb[k];
            white[k] += rgb[k];
        }
    }
    for (i = 0; i < t->wavelength_count; i++)
        for (k = 0; k < 3; k++) t->spectral[i][4 + k] /= (float)white[k];
    for (i = t->wavelength_count; i <= LFLARE_MAX_WAVELENGTHS && i > 0; i++) /* shaders take three at a time: what is missing has places, no light */
        memcpy(t->spectral[i], t->spectral[i - 1], sizeof(float) * 4);
}

#endif

/* Shares of the three that make one of them. */
static const float lflare__shares[LFLARE_WAVELENGTHS][LFLARE_WAVELENGTHS] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* Of the longest wavelength, the middle one, the shortest. */
static void lflare__ends_of(const lflare_tables *t, const float **ends)
{
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) ends[k] = lflare__shares[k];
    if (t->wavelength_count == 0) return;
    ends[0] = t->spectral[0];
    ends[2] = t->spectral[t->wavelength_count - 1];
}

#ifndef LFLARE_NO_TRACE
/* See tables.films. */
static void lflare__films_make(const lflare_lens *lens, lflare_tables *t)
{
    double n[LFLARE_MAX_SURFACES + 1];
    int32_t i, w, j;
    for (w = 0; w < t->wavelength_count; w++) {
        lflare__indices(&lens->prescription, (double)t->spectral[w][3], n);
        for (i = 0; i < lens->surface_count; i++) {
            lflare_layer layers[LFLARE_MAX_LAYERS];
            int32_t count = LFLARE_MAX_LAYERS;
            double rarer = lflare__min(n[i], n[i + 1]);
            lflare_film_layers(lens, i, layers, &count);
            for (j = 0; j < LFLARE_FILM_SAMPLES; j++) {
                double c = (double)j / (LFLARE_FILM_SAMPLES - 1);
                t->films[((size_t)i * LFLARE_FILM_SAMPLES + (size_t)j) * (LFLARE_MAX_WAVELENGTHS + 1) + (size_t)w] =
                    i == lens->stop ? 0.0f : (float)lflare_film_reflectance(n[i], n[i + 1], layers, count, (double)t->spectral[w][3], rarer * sqrt((1 - c) * (1 + c)));
            }
        }
    }
}
#endif
#endif

/* >> 8 iris */

LFLARE_API lflare_result lflare_iris_make(const lflare_lens *lens, double fnumber, int32_t blades, double rotation, double curvature, lflare_iris *out,
                                          double *fnumber_effective)
{
    double a11, radius, full, half, area, sagitta;
    int32_t i;
    if (lens == NULL || out == NULL || !lflare__finite(fnumber) || fnumber < 0 || !lflare__finite(rotation)) return LFLARE_ERROR_ARGUMENT;
    if (!(curvature >= 0 && curvature <= 1) || blades < 0 || blades == 1 || blades == 2 || blades > LFLARE_MAX_BLADES) return LFLARE_ERROR_ARGUMENT;
    memset(out, 0, sizeof *out);
    a11 = fabs(lens->stop_a11);
    full = lens->prescription.surfaces[lens->stop].semi_diameter;
    radius = lflare__min(fnumber > 0 ? a11 * lens->efl / (2 * fnumber) : a11 * lens->efl / (2 * lens->fnumber), full);
    if (fnumber_effective != NULL) *fnumber_effective = a11 * lens->efl / (2 * radius);
    out->radius = (float)radius;
    out->area = out->roundness = 1;
    if (blades == 0 || curvature >= 1) return LFLARE_OK;
    /* arcs of radius R = radius / curvature through neighbouring vertices: circumscribed circle at 1, straight at 0 */
    half = LFLARE__PI / blades;
    sagitta = curvature > 1e-3 ? asin(curvature * sin(half)) : 0; /* half the angle of one arc */
    area = sin(half) * cos(half);
    if (sagitta > 0) area += (sagitta - sin(sagitta) * cos(sagitta)) / (curvature * curvature);
    out->area = (float)(area / half);
    out->roundness = (float)(sagitta / half);
    out->blade_count = blades;
    for (i = 0; i < blades; i++) {
        lflare_blade *b = &out->blades[i];
        double angle = rotation + (2 * i + 1) * half;
        b->nx = (float)cos(angle);
        b->ny = (float)sin(angle);
        b->arc = sagitta > 0 ? (float)(1 / curvature) : 0;
        b->distance = (float)(sagitta > 0 ? cos(sagitta) / curvature - cos(half) : cos(half));
    }
    return LFLARE_OK;
}

/* -- edges -- */

#define LFLARE__RING_WASHED 8.0f /* softness over the fringes' length from which on they do not show */
#define LFLARE__RING_INNER 5.0f  /* how far they are drawn, in their length */
#define LFLARE__RING_OUTER 2.5f
#define LFLARE__RING_MOST 0.4f /* radii: below Fresnel number 3, next to focus, what there is at 3 is drawn, which is a blob */
#define LFLARE__RING_LEAST 0.05f /* of all ghosts' mean irradiance over the frame: fringes of fainter ghosts stay below a step of 8 bits */

LFLARE_API float lflare_edge_coverage(float t)
{
    t = lflare__minf(lflare__maxf(t, -1), 1);
    return 0.5f + t * (0.75f - 0.25f * t * t);
}

/* How an edge fades: over +-soft, with the fringes of length `ring` that diffraction adds (P 9). Both in the edge's own units. */
typedef struct lflare__profile {
    float soft, ring, inner, outer; /* how far fringes reach inwards and shadow outwards */
    const float *ringing;           /* LFLARE_RINGING_FLOATS; NULL: none */
} lflare__profile;

/* Of fringes that matter, which are not washed out. */
static lflare__profile lflare__profile_make(const float *ringing, float soft, float ring)
{
    lflare__profile p;
#ifdef LFLARE_NO_DIFFRACTION
    ring = 0;
    ringing = NULL;
#endif
    ring = lflare__minf(ring, LFLARE__RING_MOST);
    if (ringing == NULL || !(LFLARE__RING_WASHED * ring > soft)) ring = 0;
    p.soft = soft;
    p.ring = ring;
    p.inner = soft + LFLARE__RING_INNER * ring;
    p.outer = soft + LFLARE__RING_OUTER * ring;
    p.ringing = ringing;
    return p;
}

/* Of an outline that no light comes near, which is the mask's matter: it ends where the fringes of what lies within have faded. */
static lflare__profile lflare__profile_dark(lflare__profile p)
{
#ifndef LFLARE_NO_DIFFRACTION
    p.inner = p.soft;
    p.ringing = NULL;
#endif
    return p;
}

/* Share of light at a distance inside the edge: 0 at -outer, 1 at inner; above 1 on fringes. */
static float lflare__profile_at(const lflare__profile *p, float d)
{
#ifndef LFLARE_NO_DIFFRACTION
    float blur, u, v, f, g;
    const float *a;
    int32_t i, j;
    if (p->ringing == NULL) return lflare_edge_coverage((d + 0.5f * (p->outer - p->soft)) / (0.5f * (p->outer + p->soft)));
    if (!(p->ring > 0)) return lflare_edge_coverage(d / p->soft);
    blur = p->soft / p->ring;
    u = lflare__minf(lflare__maxf((d + p->outer) / (p->inner + p->outer), 0), 1) * (LFLARE_RINGING_SAMPLES - 1);
    v = blur / (blur + 2) * ((LFLARE__RING_WASHED + 2) / LFLARE__RING_WASHED) * (LFLARE_RINGING_BLURS - 1);
    i = (int32_t)lflare__minf(u, LFLARE_RINGING_SAMPLES - 2);
    j = (int32_t)lflare__minf(v, LFLARE_RINGING_BLURS - 2);
    f = u - (float)i;
    g = v - (float)j;
    a = p->ringing + j * LFLARE_RINGING_SAMPLES + i;
    return (1 - g) * (a[0] + f * (a[1] - a[0])) + g * (a[LFLARE_RINGING_SAMPLES] + f * (a[LFLARE_RINGING_SAMPLES + 1] - a[LFLARE_RINGING_SAMPLES]));
#else
    return lflare_edge_coverage(d / p->soft);
#endif
}

/* The two edges that cut most at a point, with their inward normals. */
typedef struct lflare__cuts {
    float t[2], c[2], nx[2], ny[2]; /* distance inside over how far the edge reaches; share of light */
} lflare__cuts;

static const lflare__cuts lflare__uncut = {{1, 1}, {1, 1}, {0, 0}, {0, 0}};

/* An edge, d inside. */
static void lflare__cut(lflare__cuts *cuts, const lflare__profile *p, float d, float nx, float ny)
{
    float t = lflare__maxf(d > 0 ? d / p->inner : d / p->outer, -1);
    int32_t at = t < cuts->t[0] ? 0 : 1;
    if (t >= cuts->t[1]) return;
    if (at == 0) {
        cuts->t[1] = cuts->t[0];
        cuts->c[1] = cuts->c[0];
        cuts->nx[1] = cuts->nx[0];
        cuts->ny[1] = cuts->ny[0];
    }
    cuts->t[at] = t;
    cuts->c[at] = lflare__profile_at(p, d);
    cuts->nx[at] = nx;
    cuts->ny[at] = ny;
}

static void lflare__cut_circle(lflare__cuts *cuts, float ax, float ay, float radius, const lflare__profile *p, float sign)
{
    float length = sqrtf(ax * ax + ay * ay), inv;
    if (radius - length >= p->inner) return;
    inv = -sign / lflare__maxf(length, 1e-20f);
    lflare__cut(cuts, p, radius - length, ax * inv, ay * inv);
}

/* Two soft half planes whose normals enclose an angle of cosine rho: the mixture of "independent" and "one and the same"
   (or "opposite") that keeps the area, since the covariance of the edges' shifts is rho (Hoeffding's formula). */
static float lflare__both(const lflare__cuts *cuts)
{
    float a = cuts->c[0], b = cuts->c[1], rho, product = a * b;
    if (cuts->t[1] >= 1 || a <= 0) return a;
    rho = lflare__minf(lflare__maxf(cuts->nx[0] * cuts->nx[1] + cuts->ny[0] * cuts->ny[1], -1), 1);
    return rho > 0 ? product + rho * (a - product) : product - rho * (lflare__maxf(lflare__minf(a, 1) + lflare__minf(b, 1) - 1, 0) - product);
}

#ifndef LFLARE_NO_DIFFRACTION
/* A square of size x size texels in rows of `width`, between them linearly. */
static float lflare__texels_at(const uint8_t *texels, int32_t size, int32_t width, float x, float y)
{
    float half = 0.5f * (float)size, last = (float)(size - 1), low, high;
    float fx = lflare__minf(lflare__maxf((x + 1) * half - 0.5f, 0), last), fy = lflare__minf(lflare__maxf((y + 1) * half - 0.5f, 0), last);
    int32_t ix = (int32_t)fx, iy = (int32_t)fy, right = ix + 1 < size, up = iy + 1 < size ? width : 0;
    texels += iy * width + ix;
    fx -= (float)ix;
    fy -= (float)iy;
    low = (float)texels[0] + fx * (float)(texels[right] - texels[0]);
    high = (float)texels[up] + fx * (float)(texels[up + right] - texels[up]);
    return (low + fy * (high - low)) / 255;
}

static float lflare__mask_level(const uint8_t *mask, int32_t level, float x, float y)
{
    int32_t i;
    for (i = 0; i < level; i++) mask += (size_t)(LFLARE_MASK_SIZE >> i) * (size_t)(LFLARE_MASK_SIZE >> i);
    return lflare__texels_at(mask, LFLARE_MASK_SIZE >> level, LFLARE_MASK_SIZE >> level, x, y);
}

static float lflare__fringed_level(const uint8_t *fringed, int32_t view, int32_t level, float x, float y)
{
    int32_t size = LFLARE_FRINGED_SIZE >> level, width = LFLARE_FRINGED_WIDTH >> level, i;
    for (i = 0; i < level; i++) fringed += (size_t)(LFLARE_FRINGED_WIDTH >> i) * (size_t)(LFLARE_FRINGED_WIDTH >> i);
    return 2 * lflare__texels_at(fringed + size * (view / LFLARE_FRINGED_ACROSS * width + view % LFLARE_FRINGED_ACROSS), size, width, x, y);
}

/* Between two levels of a picture, the last of which is `last`. */
static float lflare__between_levels(const lflare_iris *iris, int32_t view, float lod, int32_t last, float x, float y)
{
    int32_t level = (int32_t)lflare__minf(lod, (float)(last - 1));
    float share = lod - (float)level, fine = 0, coarse = 0;
    if (share < 1) fine = view < 0 ? lflare__mask_level(iris->mask, level, x, y) : lflare__fringed_level(iris->fringed, view, level, x, y);
    if (share > 0) coarse = view < 0 ? lflare__mask_level(iris->mask, level + 1, x, y) : lflare__fringed_level(iris->fringed, view, level + 1, x, y);
    return (1 - share) * fine + share * coarse;
}

#define LFLARE__FRINGED_OCTAVE 5.0f /* pictures while the length of fringes halves */

/* How a ghost looks at the mask. */
typedef struct lflare__look {
    float lod, fringed, view, fade; /* level of the mask; of the pictures with fringes, which, and what share of them */
} lflare__look;

/* Edges fade over +-soft (the level whose texels, with the ramps between them, spread as much as the edges' density does); fringes of length `ring`. */
static lflare__look lflare__look_make(const lflare_iris *iris, float soft, float ring)
{
    lflare__look look;
    look.lod = lflare__minf(lflare__maxf(log2f(0.894f * soft * (0.5f * (float)LFLARE_MASK_SIZE)), 0), LFLARE_MASK_LEVELS - 1);
    look.fringed = lflare__maxf(look.lod - 1, 0);
    look.view = look.fade = 0;
    if (iris->fringed == NULL || !(ring > 0)) return look;
    look.view = LFLARE__FRINGED_OCTAVE * log2f(LFLARE__RING_MOST / ring);
    look.fade = lflare__minf(lflare__maxf(((float)LFLARE_FRINGED_VIEWS - 1 - look.view) / LFLARE__FRINGED_OCTAVE + 1, 0), 1);
    look.view = lflare__minf(look.view, LFLARE_FRINGED_VIEWS - 1);
    return look;
}

/* What the mask leaves of a point, 1 without one; above 1 on fringes. */
static float lflare__iris_mask(const lflare_iris *iris, float x, float y, const lflare__look *look)
{
    float plain, fringed, share;
    int32_t view = (int32_t)lflare__minf(look->view, LFLARE_FRINGED_VIEWS - 2);
    if (iris->mask == NULL) return 1;
    plain = look->fade < 1 ? lflare__between_levels(iris, -1, look->lod, LFLARE_MASK_LEVELS - 1, x, y) : 0;
    if (!(look->fade > 0)) return plain;
    share = look->view - (float)view;
    fringed = (1 - share) * lflare__between_levels(iris, view, look->fringed, LFLARE_FRINGED_LEVELS - 1, x, y);
    if (share > 0) fringed += share * lflare__between_levels(iris, view + 1, look->fringed, LFLARE_FRINGED_LEVELS - 1, x, y);
    return plain + look->fade * (fringed - plain);
}

/* What the blades, or the circumscribed circle, leave of a point. */
static float lflare__iris_outline(const lflare_iris *iris, float x, float y, float soft)
{
    lflare__cuts cuts = lflare__uncut;
    lflare__profile p = lflare__profile_make(NULL, sqrtf(soft * soft + iris->softness * iris->softness) + 1e-7f, 0);
    int32_t i;
    if (iris->blade_count == 0) lflare__cut_circle(&cuts, x, y, 1, &p, 1);
    for (i = 0; i < iris->blade_count; i++) {
        const lflare_blade *b = &iris->blades[i];
        if (b->arc > 0) lflare__cut_circle(&cuts, x + b->nx * b->distance, y + b->ny * b->distance, b->arc, &p, 1);
        else lflare__cut(&cuts, &p, b->distance - b->nx * x - b->ny * y, -b->nx, -b->ny);
    }
    return lflare__both(&cuts);
}

LFLARE_API float lflare_iris_transmission(const lflare_iris *iris, float x, float y, float soft)
{
    float open = lflare__iris_outline(iris, x, y, soft);
    lflare__look look = lflare__look_make(iris, soft, 0);
    return open > 0 ? open * lflare__iris_mask(iris, x, y, &look) : 0;
}
#elif !defined(LFLARE_NO_SOFTWARE)
typedef int lflare__look;
static int lflare__look_make(const lflare_iris *iris, float soft, float ring) { return (void)iris, (void)soft, (void)ring, 0; }
static float lflare__iris_mask(const lflare_iris *iris, float x, float y, const int *look) { return (void)iris, (void)x, (void)y, (void)look, 1.0f; }
#endif

#ifdef LFLARE__PATCHES
/* The largest disc within the blades, in radii. */
static float lflare__iris_inscribed(const lflare_iris *iris)
{
    float least = 1;
    int32_t i;
    for (i = 0; i < iris->blade_count; i++) {
        const lflare_blade *b = &iris->blades[i];
        least = lflare__minf(least, b->arc > 0 ? b->arc - b->distance : b->distance);
    }
    return least;
}
#endif

/* Tells two arrays of rows apart by content: addresses and counters come again when objects do. Even numbers of floats. */
static uint64_t lflare__hash(const float *a, size_t a_count, const float *b, size_t b_count)
{
    uint64_t hash = 0, word;
    size_t i;
    for (i = 0; i < a_count + b_count; i += 2) {
        memcpy(&word, i < a_count ? a + i : b + (i - a_count), sizeof word);
        hash = (hash ^ word) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return hash;
}

/* 0 without a mask. */
static uint64_t lflare__mask_hash(const lflare_iris *iris)
{
#ifndef LFLARE_NO_DIFFRACTION
    uint64_t hash = 1, part;
    size_t i;
    for (i = 0; iris->mask != NULL && i < (size_t)LFLARE_MASK_SIZE * LFLARE_MASK_SIZE; i += sizeof part) {
        memcpy(&part, iris->mask + i, sizeof part);
        hash = (hash ^ part) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return iris->mask != NULL ? hash | 1 : 0;
#else
    return (void)iris, 0;
#endif
}

/* >> 9 diffraction */
#ifndef LFLARE_NO_DIFFRACTION

/* -- the mask: what stands in the iris besides its blades -- */

/* All but the pixels. */
static lflare_result lflare__mask_check(const lflare_mask_desc *d, lflare_error *error)
{
    float sum;
    if (d == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no mask given");
    if (d->dust_count < 0 || d->dust_count > LFLARE_MAX_MARKS || d->scratch_count < 0 || d->scratch_count > LFLARE_MAX_MARKS)
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "mask: 0 to %i specks of dust and as many scratches", (int)LFLARE_MAX_MARKS);
    sum = d->dust_size + d->scratch_length + d->scratch_width;
    if (!lflare__finite((double)(sum + d->scratch_angle + d->scratch_spread + d->grating_angle)) || d->dust_size < 0 || d->scratch_length < 0 ||
        d->scratch_width < 0 || d->scratch_spread < 0 || sum > 6 || !(d->grating_lines >= 0 && d->grating_lines <= LFLARE_MASK_SIZE / 4) ||
        !(d->grating_depth >= 0 && d->grating_depth <= 1))
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "mask: sizes are 0 to 2 radii, a grating has 0 to %i lines of depth 0 to 1", (int)LFLARE_MASK_SIZE / 4);
    if (d->pixels != NULL && (d->width < 1 || d->height < 1 || d->width > LFLARE_MAX_MASK || d->height > LFLARE_MAX_MASK))
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "the mask's image is %i x %i; give 1 to %i either way", d->width, d->height, (int)LFLARE_MAX_MASK);
    return LFLARE_OK;
}

/* Rows of the image, if there is one; the brightest pixel in *open. */
static lflare_result lflare__mask_pixels(const lflare_mask_desc *d, int32_t begin, int32_t end, float *open, lflare_error *error)
{
    size_t width = (size_t)d->width, i;
    for (i = width * (size_t)begin; d->pixels != NULL && i < width * (size_t)end; i++) {
        if (!(d->pixels[i] >= 0 && d->pixels[i] <= 1))
            return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "the mask's pixel %i, %i is %g; give the share of power that passes, 0 to 1",
                                (int32_t)(i % width), (int32_t)(i / width), (double)d->pixels[i]);
        *open = lflare__maxf(*open, d->pixels[i]);
    }
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_mask_check(const lflare_mask_desc *d, lflare_error *error)
{
    float open = 0;
    lflare_result result;
    if (error != NULL) memset(error, 0, sizeof *error);
    result = lflare__mask_check(d, error);
    if (result == LFLARE_OK) result = lflare__mask_pixels(d, 0, d->height, &open, error);
    if (result != LFLARE_OK || d->pixels == NULL) return result;
    return open > 0 ? LFLARE_OK : lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "the mask is black: nothing passes");
}

/* Mean of the image over the square of half width `half` around (x, y), in radii. */
static float lflare__mask_image(const lflare_mask_desc *d, double x, double y, double half)
{
    double longer = d->width > d->height ? d->width : d->height, sum = 0, area = 4 * half * half * 0.25 * longer * longer;
    double x0 = 0.5 * (d->width + (x - half) * longer), x1 = x0 + half * longer, y0 = 0.5 * (d->height - (y + half) * longer), y1 = y0 + half * longer;
    int32_t i, j, i0 = (int32_t)floor(lflare__max(x0, 0)), j0 = (int32_t)floor(lflare__max(y0, 0));
    for (j = j0; j < d->height && j < y1; j++) {
        double high = lflare__min(y1, j + 1.0) - lflare__max(y0, j), row = 0;
        for (i = i0; i < d->width && i < x1; i++) row += (double)d->pixels[(size_t)j * (size_t)d->width + (size_t)i] * (lflare__min(x1, i + 1.0) - lflare__max(x0, i));
        sum += high * row;
    }
    return (float)(sum / area);
}

/* A random number from 0 to 1 that depends on its place alone. */
static float lflare__random(uint32_t seed, uint32_t index)
{
    uint32_t h = seed * 0x9E3779B9u ^ (index * 0x85EBCA6Bu + 0xC2B2AE35u);
    h = (h ^ h >> 16) * 0x7FEB352Du;
    h = (h ^ h >> 15) * 0x846CA68Bu;
    h ^= h >> 16;
    return (float)(h >> 8) / 16777216.0f;
}

/* A capsule: a speck of dust has length 0. */
typedef struct lflare__mark {
    float x, y, dx, dy, half, radius, depth; /* middle, direction, half the length, half the width, share of power it takes */
} lflare__mark;

static void lflare__mark_make(const lflare_mask_desc *d, int32_t i, lflare__mark *m)
{
    int scratch = i >= d->dust_count;
    uint32_t at = (uint32_t)i * 8 + (scratch ? 0x40000u - (uint32_t)d->dust_count * 8 : 0); /* more dust leaves scratches where they are */
    float r = sqrtf(lflare__random(d->seed, at)), turn = 6.2831853f * lflare__random(d->seed, at + 1), size = 0.5f + lflare__random(d->seed, at + 2);
    float angle = d->scratch_angle + d->scratch_spread * (2 * lflare__random(d->seed, at + 3) - 1);
    m->x = r * cosf(turn);
    m->y = r * sinf(turn);
    m->dx = cosf(angle);
    m->dy = sinf(angle);
    m->half = scratch ? 0.5f * size * (d->scratch_length > 0 ? d->scratch_length : 0.5f) : 0;
    m->radius = scratch ? 0.5f * (d->scratch_width > 0 ? d->scratch_width : 0.006f) : size * (d->dust_size > 0 ? d->dust_size : 0.01f);
    m->depth = 0.6f + 0.4f * lflare__random(d->seed, at + 4);
}

/* What a mark leaves of a row. */
static void lflare__mark_row(const lflare__mark *m, float y, float *row)
{
    const float texel = 2.0f / (float)LFLARE_MASK_SIZE;
    float ay = y - m->y, reach = m->radius + texel, span = m->half * fabsf(m->dx) + reach;
    int32_t i, end;
    if (fabsf(ay) > m->half * fabsf(m->dy) + reach) return;
    i = (int32_t)lflare__clamp(((double)(m->x - span) + 1) / (double)texel, 0, LFLARE_MASK_SIZE);
    end = (int32_t)lflare__clamp(((double)(m->x + span) + 1) / (double)texel + 1, 0, LFLARE_MASK_SIZE);
    for (; i < end; i++) {
        float ax = texel * ((float)i + 0.5f) - 1 - m->x, along = lflare__minf(lflare__maxf(ax * m->dx + ay * m->dy, -m->half), m->half);
        float bx = ax - along * m->dx, by = ay - along * m->dy, t = (m->radius - sqrtf(bx * bx + by * by)) / texel;
        /* thinner than a texel: what it covers of it */
        if (t > -1) row[i] *= 1 - m->depth * lflare__minf(lflare_edge_coverage(t), 2 * m->radius / texel);
    }
}

LFLARE_API void lflare_mask_rows(const lflare_mask_desc *d, uint8_t *out, int32_t begin, int32_t end)
{
    const double texel = 2.0 / (double)LFLARE_MASK_SIZE;
    float row[LFLARE_MASK_SIZE];
    lflare__mark mark;
    int32_t i, j;
    for (j = begin; j < end; j++) {
        double y = texel * (j + 0.5) - 1;
        for (i = 0; i < LFLARE_MASK_SIZE; i++) {
            double x = texel * (i + 0.5) - 1, phase;
            row[i] = d->pixels != NULL ? lflare__mask_image(d, x, y, 0.5 * texel) : 1;
            if (!(d->grating_lines > 0)) continue;
            phase = 0.5 * (double)d->grating_lines * (x * cos((double)d->grating_angle) + y * sin((double)d->grating_angle));
            phase = 4 * fabs(phase - floor(phase) - 0.5) - 1; /* a triangle from -1 to 1; lines are half a period wide */
            row[i] *= 1 - d->grating_depth * lflare_edge_coverage((float)(phase / (2 * (double)d->grating_lines * texel)));
        }
        for (i = 0; i < d->dust_count + d->scratch_count; i++) {
            lflare__mark_make(d, i, &mark);
            lflare__mark_row(&mark, (float)y, row);
        }
        for (i = 0; i < LFLARE_MASK_SIZE; i++) out[(size_t)j * LFLARE_MASK_SIZE + (size_t)i] = (uint8_t)(255 * row[i] + 0.5f);
    }
}

/* Halves down to one texel of a square picture, one of across x across that make up a picture, whose halves come behind it. */
static void lflare__halves(uint8_t *all, int32_t width, int32_t across, int32_t place)
{
    int32_t i, j;
    for (; width > across; width /= 2) {
        int32_t size = width / across, half = width / 2;
        uint8_t *fine = all + size * (place / across * width + place % across), *coarse;
        all += (size_t)width * (size_t)width;
        coarse = all + size / 2 * (place / across * half + place % across);
        for (j = 0; j < size / 2; j++)
            for (i = 0; i < size / 2; i++) {
                const uint8_t *at = fine + 2 * (j * width + i);
                coarse[j * half + i] = (uint8_t)((at[0] + at[1] + at[width] + at[width + 1] + 2) / 4);
            }
    }
}

LFLARE_API lflare_result lflare_iris_set_mask(lflare_iris *iris, uint8_t *mask)
{
    enum { HALF = LFLARE_MASK_SIZE / 2 };
    const float texel = 2.0f / (float)HALF;
    double open = 0, all = 0, rim = 0;
    int32_t i, j;
    uint8_t *coarse;
    if (iris == NULL || mask == NULL || iris->mask != NULL) return LFLARE_ERROR_ARGUMENT;
    lflare__halves(mask, LFLARE_MASK_SIZE, 1, 0);
    coarse = mask + (size_t)LFLARE_MASK_SIZE * LFLARE_MASK_SIZE; /* half the size is enough to add up, and takes a quarter of the time */
    for (j = 0; j < HALF; j++)
        for (i = 0; i < HALF; i++) {
            double within = (double)lflare_iris_transmission(iris, texel * ((float)i + 0.5f) - 1, texel * ((float)j + 0.5f) - 1, texel), passes = within * coarse[j * HALF + i] / 255;
            all += within;
            open += passes;
            if (within < 1) rim += passes;
        }
    if (!(open > 1e-6 * all)) return LFLARE_ERROR_ARGUMENT;
    iris->mask = mask;
    iris->dark_outline = !(rim > 1e-4 * all);
    iris->area *= (float)(open / all);
    return LFLARE_OK;
}

/* -- the Fourier transform -- */

/* Roots of unity e^(-2 pi i k / n), n complex numbers. */
static void lflare__roots(float *roots, int32_t n)
{
    int32_t k;
    for (k = 0; k < n; k++) {
        double angle = -2 * LFLARE__PI * k / n;
        roots[2 * k] = (float)cos(angle);
        roots[2 * k + 1] = (float)sin(angle);
    }
}

/* Forward transform of n = 2^k complex numbers, unscaled: Stockham's, radix 4, so that no digits need reversing. `data` and `other` are
   n complex numbers each; returns whichever holds the result. */
static float *lflare__fft(float *data, float *other, const float *roots, int32_t n)
{
    int32_t s = 1, m, p, q, rest = n;
    for (; rest >= 4; rest /= 4, s *= 4) {
        float *x = data, *y = other;
        m = rest / 4;
        for (p = 0; p < m; p++) {
            const float *w1 = roots + 2 * p * s, *w2 = roots + 4 * p * s, *w3 = roots + 6 * p * s;
            const float *a = x + 2 * s * p, *b = a + 2 * s * m, *c = b + 2 * s * m, *d = c + 2 * s * m;
            float *out = y + 8 * s * p;
            for (q = 0; q < 2 * s; q += 2) {
                float sr = a[q] + c[q], si = a[q + 1] + c[q + 1], dr = a[q] - c[q], di = a[q + 1] - c[q + 1];
                float tr = b[q] + d[q], ti = b[q + 1] + d[q + 1], ur = b[q + 1] - d[q + 1], ui = d[q] - b[q]; /* -i (b - d) */
                float er = dr + ur, ei = di + ui, fr = sr - tr, fi = si - ti, gr = dr - ur, gi = di - ui;
                out[q] = sr + tr;
                out[q + 1] = si + ti;
                out[q + 2 * s] = er * w1[0] - ei * w1[1];
                out[q + 2 * s + 1] = er * w1[1] + ei * w1[0];
                out[q + 4 * s] = fr * w2[0] - fi * w2[1];
                out[q + 4 * s + 1] = fr * w2[1] + fi * w2[0];
                out[q + 6 * s] = gr * w3[0] - gi * w3[1];
                out[q + 6 * s + 1] = gr * w3[1] + gi * w3[0];
            }
        }
        data = y;
        other = x;
    }
    if (rest == 2) {
        for (q = 0; q < 2 * s; q++) {
            float a = data[q], b = data[q + 2 * s];
            other[q] = a + b;
            other[q + 2 * s] = a - b;
        }
        return other;
    }
    return data;
}

/* -- power spectrum of a real picture: across x across amplitudes within n x n, of which columns 0..columns-1 and rows up to the
   same are kept; the other half plane is the same turned round -- */

typedef struct lflare__transform {
    const float *amplitude;
    float *half, *power, *line, *roots; /* across x columns complex; columns x (2 columns - 1); 2 n complex; n complex */
    int32_t across, n, columns;
} lflare__transform;

/* Rows 2 pair and 2 pair + 1, transformed as the two parts of one. */
static void lflare__transform_rows(const lflare__transform *t, int32_t pair)
{
    const float *a = t->amplitude + (size_t)(2 * pair) * (size_t)t->across, *b = a + t->across, *z;
    float *out = t->half + 4 * (size_t)pair * (size_t)t->columns, *below = out + 2 * t->columns;
    int32_t i;
    memset(t->line, 0, sizeof(float) * 2 * (size_t)t->n);
    for (i = 0; i < t->across; i++) {
        t->line[2 * i] = a[i];
        t->line[2 * i + 1] = b[i];
    }
    z = lflare__fft(t->line, t->line + 2 * t->n, t->roots, t->n);
    for (i = 0; i < t->columns; i++) {
        const float *u = z + 2 * i, *v = z + 2 * (i > 0 ? t->n - i : 0);
        out[2 * i] = 0.5f * (u[0] + v[0]);
        out[2 * i + 1] = 0.5f * (u[1] - v[1]);
        below[2 * i] = 0.5f * (u[1] + v[1]);
        below[2 * i + 1] = 0.5f * (v[0] - u[0]);
    }
}

static void lflare__transform_column(const lflare__transform *t, int32_t column)
{
    float *out = t->power + (size_t)column * (size_t)(2 * t->columns - 1), *z;
    int32_t k;
    for (k = 0; k < t->across; k++) {
        const float *v = t->half + 2 * ((size_t)k * (size_t)t->columns + (size_t)column);
        t->line[2 * k] = v[0];
        t->line[2 * k + 1] = v[1];
    }
    memset(t->line + 2 * t->across, 0, sizeof(float) * 2 * (size_t)(t->n - t->across));
    z = lflare__fft(t->line, t->line + 2 * t->n, t->roots, t->n);
    for (k = 1 - t->columns; k < t->columns; k++) {
        const float *v = z + 2 * (k < 0 ? k + t->n : k);
        *out++ = v[0] * v[0] + v[1] * v[1];
    }
}

static float lflare__power_at(const lflare__transform *t, int32_t x, int32_t y)
{
    if (x < 0) x = -x, y = -y;
    return t->power[(size_t)x * (size_t)(2 * t->columns - 1) + (size_t)(y + t->columns - 1)];
}

/* Between its samples, linearly or, where rings are near the grid's size, by Catmull-Rom's cubics. */
static float lflare__power_between(const lflare__transform *t, float x, float y, int cubic)
{
    float fx, fy, wx[4], wy[4], sum = 0;
    int32_t i, j, ix, iy;
    if (x < 0) x = -x, y = -y;
    fx = floorf(x);
    fy = floorf(y);
    ix = (int32_t)fx;
    iy = (int32_t)fy;
    fx = x - fx;
    fy = y - fy;
    if (!cubic) {
        float a = lflare__power_at(t, ix, iy), b = lflare__power_at(t, ix, iy + 1), c = lflare__power_at(t, ix + 1, iy), d = lflare__power_at(t, ix + 1, iy + 1);
        a += fy * (b - a);
        c += fy * (d - c);
        return a + fx * (c - a);
    }
    for (i = 0; i < 2; i++) {
        float f = i == 0 ? fx : fy, *w = i == 0 ? wx : wy;
        w[0] = f * (-0.5f + f * (1 - 0.5f * f));
        w[1] = 1 + f * f * (-2.5f + 1.5f * f);
        w[2] = f * (0.5f + f * (2 - 1.5f * f));
        w[3] = f * f * (-0.5f + 0.5f * f);
    }
    for (i = 0; i < 4; i++)
        for (j = 0; j < 4; j++) sum += wx[i] * wy[j] * lflare__power_at(t, ix + i - 1, iy + j - 1);
    return lflare__maxf(sum, 0);
}

/* -- colours -- */

/* Linear sRGB of equal power at 380 + 5 i nm, each channel's sum over all being 1. Pure colours that sRGB lacks are brought into it:
   channels below 0 would leave rings without any red, which no exposure hides. */
static double lflare__channel_weight(int32_t k, int32_t i)
{
    double value = 0, sum = 0;
    int32_t j, c;
    for (j = 0; j < LFLARE__CIE_COUNT; j++) {
        double part = 0;
        for (c = 0; c < 3; c++) part += lflare__to_srgb[k][c] * lflare__cie[c][j];
        part = lflare__max(part, 0);
        sum += part;
        if (j == i) value = part;
    }
    return value / sum;
}

/* -- the starburst -- */

enum {
    LFLARE__CORE_SHRINK = 8,   /* the middle is transformed again from a picture shrunk by this, padded 16 times */
    LFLARE__CORE_REACH = 8,    /* and used up to this distance */
    LFLARE__MARGIN = 4         /* texels beside the iris in the picture that is transformed */
};
static const double lflare__starburst_first = 0.0625, lflare__starburst_nm = 550;

enum {
    LFLARE__BURST_PICTURE, LFLARE__BURST_ROWS, LFLARE__BURST_COLUMNS, LFLARE__BURST_POLAR, LFLARE__BURST_CORE_ROWS, LFLARE__BURST_CORE_COLUMNS,
    LFLARE__BURST_CORE_POLAR, LFLARE__BURST_FOLD, LFLARE__BURST_RADIAL, LFLARE__BURST_DONE
};

static double lflare__row_distance(double row) { return lflare__starburst_first * exp2(row / (double)LFLARE_STARBURST_OCTAVE); }
static int32_t lflare__row_at(double distance) { return (int32_t)floor((double)LFLARE_STARBURST_OCTAVE * log2(distance / lflare__starburst_first)); }

static int32_t lflare__level_bins(int32_t level) { return level == 0 ? LFLARE_STARBURST_BINS : 2 * LFLARE_STARBURST_BINS >> level; }

/* Where a level's bins begin in a row. */
static int32_t lflare__level_first(int32_t level)
{
    int32_t first = 1, i;
    for (i = 0; i < level; i++) first += lflare__level_bins(i) + 2;
    return first;
}

/* The transform of the whole picture, or of its middle. */
static lflare__transform lflare__burst_transform(const lflare_starburst_job *job, int core)
{
    lflare__transform t;
    t.amplitude = core ? job->core : job->amplitude;
    t.across = core ? job->across / LFLARE__CORE_SHRINK : job->across;
    t.n = core ? 16 * t.across : job->size;
    t.columns = core ? 16 * LFLARE__CORE_REACH + 16 : (int32_t)(0.37 * job->size);
    t.half = job->half;
    t.power = job->power;
    t.line = job->line;
    t.roots = job->spectrum;
    return t;
}

/* How far the picture's detail reaches. */
static double lflare__burst_reach(const lflare_starburst_job *job) { return 0.35 * (job->across - LFLARE__MARGIN); }

LFLARE_API uint64_t lflare_starburst_key(const lflare_iris *iris)
{
    float shape[4 + 4 * LFLARE_MAX_BLADES];
    uint64_t key;
    memset(shape, 0, sizeof shape);
    shape[0] = (float)iris->blade_count;
    shape[1] = iris->softness;
    memcpy(shape + 4, iris->blades, sizeof(lflare_blade) * (size_t)iris->blade_count);
    key = lflare__hash(shape, 4 + 4 * LFLARE_MAX_BLADES, NULL, 0);
    key = (key ^ lflare__mask_hash(iris)) * 0x9E3779B97F4A7C15u;
    key ^= key >> 32;
    return key | 1;
}

LFLARE_API size_t lflare_starburst_bytes(int32_t size)
{
    size_t across = (size_t)size / 2, columns, core = 16 * LFLARE__CORE_REACH + 16, floats;
    if (size < 512 || size > 4096 || (size & (size - 1)) != 0) return 0;
    columns = (size_t)(0.37 * size);
    if (columns < core) columns = core;
    floats = across * across + across * across / (LFLARE__CORE_SHRINK * LFLARE__CORE_SHRINK); /* pictures */
    floats += 2 * columns * across + columns * (2 * columns - 1); /* their transforms */
    floats += 6 * (size_t)size; /* lines, roots */
    floats += (LFLARE_STARBURST_ROWS + 16) * (size_t)LFLARE_STARBURST_BINS + 4 * LFLARE_STARBURST_BINS;
    return sizeof(float) * floats;
}

LFLARE_API lflare_result lflare_starburst_begin(const lflare_iris *iris, int32_t size, float *tables, void *work, lflare_starburst *out,
                                                lflare_starburst_job *job)
{
    size_t across = (size_t)size / 2, columns, core = 16 * LFLARE__CORE_REACH + 16;
    float *at = (float *)work;
    int32_t i, k;
    if (iris == NULL || tables == NULL || work == NULL || out == NULL || job == NULL || lflare_starburst_bytes(size) == 0) return LFLARE_ERROR_ARGUMENT;
    memset(job, 0, sizeof *job);
    memset(out, 0, sizeof *out);
    out->angular = tables;
    out->radial = tables + (size_t)4 * LFLARE_STARBURST_ROWS * LFLARE_STARBURST_COLUMNS;
    job->iris = iris;
    job->out = out;
    job->size = out->size = size;
    job->across = size / 2;
    columns = (size_t)(0.37 * size);
    if (columns < core) columns = core;
    job->amplitude = at;
    job->core = at += across * across;
    job->half = at += across * across / (LFLARE__CORE_SHRINK * LFLARE__CORE_SHRINK);
    job->power = at += 2 * columns * across;
    job->line = at += columns * (2 * columns - 1);
    job->spectrum = at += 4 * size;
    job->raw = at += 2 * size;
    job->row = at + (LFLARE_STARBURST_ROWS + 16) * (size_t)LFLARE_STARBURST_BINS;
    memset(job->core, 0, sizeof(float) * (across * across / (LFLARE__CORE_SHRINK * LFLARE__CORE_SHRINK)));
    lflare__roots(job->spectrum, size);
    for (i = 0; i < LFLARE__CIE_COUNT; i++) {
        double ratio = (380 + 5.0 * i) / lflare__starburst_nm, shift = 9 - (double)LFLARE_STARBURST_OCTAVE * log2(ratio);
        int32_t whole = (int32_t)floor(shift);
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
            double weight = lflare__channel_weight(k, i) / (ratio * ratio);
            job->kernel[k][whole] += (float)(weight * (whole + 1 - shift));
            job->kernel[k][whole + 1] += (float)(weight * (shift - whole));
        }
    }
    return LFLARE_OK;
}

/* Four rows of the picture: amplitudes, antialiased over a texel on either side. */
static void lflare__burst_picture(lflare_starburst_job *job, int32_t slice)
{
    float texel = 2.0f / (float)(job->across - LFLARE__MARGIN), middle = 0.5f * (float)(job->across - 1);
    int soft = job->iris->softness > 2 * texel;
    lflare__look sharp = lflare__look_make(job->iris, 0, 0);
    int32_t i, j;
    for (j = 4 * slice; j < 4 * slice + 4; j++) {
        float *row = job->amplitude + (size_t)j * (size_t)job->across, *core = job->core + (size_t)(j / LFLARE__CORE_SHRINK) * (size_t)(job->across / LFLARE__CORE_SHRINK);
        for (i = 0; i < job->across; i++) {
            float x = texel * ((float)i - middle), y = texel * ((float)j - middle), power = lflare__iris_outline(job->iris, x, y, texel);
            /* the mean amplitude of a texel that an edge crosses is the share that is open; elsewhere that of power is its square */
            row[i] = (soft ? sqrtf(power) : power) * sqrtf(power > 0 ? lflare__iris_mask(job->iris, x, y, &sharp) : 0);
            core[i / LFLARE__CORE_SHRINK] += row[i];
            job->energy += (double)row[i] * (double)row[i];
        }
    }
}

/* What the texel's antialiasing leaves of frequency `cycles` per texel: the transform of lflare_edge_coverage's density. */
static double lflare__burst_response(double cycles)
{
    double x = 2 * LFLARE__PI * cycles;
    return x > 1e-2 ? 3 * (sin(x) - x * cos(x)) / (x * x * x) : 1 - 0.1 * x * x;
}

/* One distance: means over cells of a row and a bin, as flux per area. */
static void lflare__burst_polar(lflare_starburst_job *job, int32_t row, int core)
{
    lflare__transform t = lflare__burst_transform(job, core);
    double texels = job->across - LFLARE__MARGIN, step = texels / ((core ? LFLARE__CORE_SHRINK : 1) * t.n); /* distance from sample to sample */
    double low = lflare__row_distance(row - 0.5), high = lflare__row_distance(row + 0.5);
    int32_t rings = (int32_t)ceil((high - low) / step), turns = (int32_t)ceil(high * LFLARE__PI / (double)LFLARE_STARBURST_BINS / step), bin, i, j;
    float *out = job->raw + (size_t)row * LFLARE_STARBURST_BINS, gains[64];
    LFLARE_ASSERT(rings <= 64);
    for (i = 0; i < rings; i++) {
        double q = low + (high - low) * (i + 0.5) / rings, response = lflare__burst_response(q / texels), shrunk = LFLARE__PI * q * (double)LFLARE__CORE_SHRINK / texels;
        if (core) response *= sin(shrunk) / shrunk;
        gains[i] = (float)(1 / (response * response * job->energy * texels * texels * rings * turns));
    }
    for (bin = 0; bin < LFLARE_STARBURST_BINS; bin++) {
        float sum = 0;
        for (j = 0; j < turns; j++) {
            double angle = (bin + (j + 0.5) / turns) * LFLARE__PI / (double)LFLARE_STARBURST_BINS;
            float c = (float)(cos(angle) / step), s = (float)(sin(angle) / step);
            for (i = 0; i < rings; i++) {
                float q = (float)(low + (high - low) * (i + 0.5) / rings);
                sum += gains[i] * lflare__power_between(&t, q * c, q * s, core);
            }
        }
        out[bin] = sum;
    }
}

/* Beyond the picture's detail power falls with the cube of the distance, as that of all edges does; angles stay as they are over
   the last octave. */
static void lflare__burst_extend(lflare_starburst_job *job)
{
    int32_t last = lflare__row_at(lflare__burst_reach(job)), first = last - LFLARE_STARBURST_OCTAVE + 1, row, bin;
    for (bin = 0; bin < LFLARE_STARBURST_BINS; bin++) {
        double mean = 0;
        for (row = first; row <= last; row++) mean += (double)job->raw[(size_t)row * LFLARE_STARBURST_BINS + (size_t)bin] * pow(lflare__row_distance(row), 3) / (double)LFLARE_STARBURST_OCTAVE;
        for (row = last + 1; row < LFLARE_STARBURST_ROWS + 16; row++) job->raw[(size_t)row * LFLARE_STARBURST_BINS + (size_t)bin] = (float)(mean * pow(lflare__row_distance(row), -3));
    }
}

/* The row's bins, means 1, on all levels: halved by (1 3 3 1) / 8 from the second on, then blurred by (1 4 6 4 1) / 16, which
   ends in nearly Gaussians of 1.31 bins, linear interpolation included. */
static void lflare__burst_levels(float *texels, int32_t k, float *scratch)
{
    static const float halving[4] = {0.125f, 0.375f, 0.375f, 0.125f}, blur[5] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
    int32_t level, i, j;
    for (level = 0; level < LFLARE_STARBURST_LEVELS; level++) {
        int32_t count = lflare__level_bins(level), before = level > 0 ? lflare__level_bins(level - 1) : 0;
        float *bins = texels + 4 * lflare__level_first(level) + k, *source = level > 0 ? texels + 4 * lflare__level_first(level - 1) + k : NULL;
        for (i = 0; i < count && level > 0; i++) {
            scratch[i] = level == 1 ? source[4 * i] : 0;
            for (j = 0; j < 4 && level > 1; j++) scratch[i] += halving[j] * source[4 * ((2 * i + j - 1 + before) % before)];
        }
        for (i = 0; i < count && level > 0; i++) {
            bins[4 * i] = 0;
            for (j = 0; j < 5; j++) bins[4 * i] += blur[j] * scratch[(i + j - 2 + count) % count];
        }
        bins[-4] = bins[4 * (count - 1)];
        bins[4 * count] = bins[0];
    }
}

/* One distance in colour: the spectrum is a convolution over logarithms of the distance. */
static void lflare__burst_fold(lflare_starburst_job *job, int32_t row)
{
    float *texels = job->out->angular + (size_t)4 * LFLARE_STARBURST_COLUMNS * (size_t)row, *bins = texels + 4;
    double low = row > 0 ? lflare__row_distance(row - 0.5) : 0, high = lflare__row_distance(row + 0.5), q = lflare__row_distance(row);
    int32_t k, i, j;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        double mean = 0;
        for (i = 0; i < LFLARE_STARBURST_BINS; i++) job->row[i] = 0;
        for (j = 0; j < 20; j++) {
            const float *raw = job->raw + (size_t)(row + j > 9 ? row + j - 9 : 0) * LFLARE_STARBURST_BINS;
            for (i = 0; i < LFLARE_STARBURST_BINS && job->kernel[k][j] != 0; i++) job->row[i] += job->kernel[k][j] * raw[i];
        }
        for (i = 0; i < LFLARE_STARBURST_BINS; i++) mean += (double)job->row[i] / (double)LFLARE_STARBURST_BINS;
        for (i = 0; i < LFLARE_STARBURST_BINS; i++) {
            float share = mean > 0 ? (float)((double)job->row[i] / mean) : 1;
            bins[4 * i + k] = share;
            job->out->peak = lflare__maxf(job->out->peak, share);
        }
        lflare__burst_levels(texels, k, job->row);
        for (i = 1; i <= 2; i++) texels[4 * (LFLARE_STARBURST_COLUMNS - i) + k] = (float)(mean * (1 + q) * (1 + q) * (1 + q));
        job->flux[k] += mean * LFLARE__PI * (high * high - low * low);
    }
    for (i = 0; i < LFLARE_STARBURST_COLUMNS; i++) texels[4 * i + 3] = 0;
}

static float *lflare__burst_mean(const lflare_starburst *s, int32_t row) { return s->angular + (size_t)4 * ((size_t)(row + 1) * LFLARE_STARBURST_COLUMNS - 1); }

/* Flux 1 in each channel, what lies beyond the table included. */
static void lflare__burst_normalise(lflare_starburst_job *job)
{
    double last = lflare__row_distance(LFLARE_STARBURST_ROWS - 1), end = lflare__row_distance((double)LFLARE_STARBURST_ROWS - 0.5);
    int32_t row, k, i;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        double tail = (double)lflare__burst_mean(job->out, LFLARE_STARBURST_ROWS - 1)[k] * pow(last / (1 + last), 3);
        job->flux[k] += 2 * LFLARE__PI * tail / end;
        job->out->tail[k] = (float)(tail / job->flux[k]);
        for (row = 0; row < LFLARE_STARBURST_ROWS; row++)
            for (i = 0; i < 2; i++) lflare__burst_mean(job->out, row)[k - 4 * i] /= (float)job->flux[k];
    }
}

/* A quarter of the samples of one disc: the flux in it, over rings about the light's image of which it cuts out arcs. */
static void lflare__burst_radial(lflare_starburst_job *job, int32_t slice)
{
    enum { QUARTER = (LFLARE_STARBURST_SAMPLES + 3) / 4, ROWS = LFLARE_STARBURST_ROWS + 70, PARTS = 8 };
    const lflare_starburst *s = job->out;
    int32_t size = slice / 4, i, row, k, part, end = (slice % 4 + 1) * QUARTER < LFLARE_STARBURST_SAMPLES ? (slice % 4 + 1) * QUARTER : LFLARE_STARBURST_SAMPLES;
    double radius = ldexp(1, size - 3);
    for (i = slice % 4 * QUARTER; i < end; i++) {
        float *out = s->radial + 4 * ((size_t)size * LFLARE_STARBURST_SAMPLES + (size_t)i);
        double distance = radius * i / 32, sum[LFLARE_WAVELENGTHS] = {0, 0, 0};
        for (row = 0; row < ROWS; row++) {
            double low = row > 0 ? lflare__row_distance(row - 0.5) : 0, high = lflare__row_distance(row + 0.5), share = 0, q;
            if (low > distance + radius) break;
            if (high < distance - radius) continue;
            for (part = 0; part < (row == 0 ? PARTS : 2); part++) { /* rings of equal areas */
                double r = sqrt(low * low + (high * high - low * low) * (part + 0.5) / (row == 0 ? PARTS : 2)), cosine = (r * r + distance * distance - radius * radius) / lflare__max(2 * r * distance, 1e-9);
                share += cosine <= -1 ? 1 : cosine >= 1 ? 0 : acos(cosine) / LFLARE__PI;
            }
            share /= row == 0 ? PARTS : 2;
            q = lflare__row_distance(row);
            for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
                double mean = row < LFLARE_STARBURST_ROWS ? (double)lflare__burst_mean(s, row)[k] / ((1 + q) * (1 + q) * (1 + q)) : (double)s->tail[k] / (q * q * q);
                sum[k] += share * mean * LFLARE__PI * (high * high - low * low);
            }
        }
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) out[k] = (float)sqrt(sum[k]);
        out[3] = 0;
    }
}

/* Slices of a phase. */
static int32_t lflare__burst_slices(const lflare_starburst_job *job, int32_t phase)
{
    lflare__transform t = lflare__burst_transform(job, phase == LFLARE__BURST_CORE_ROWS || phase == LFLARE__BURST_CORE_COLUMNS);
    switch (phase) {
    case LFLARE__BURST_PICTURE: return job->across / 4;
    case LFLARE__BURST_ROWS: case LFLARE__BURST_CORE_ROWS: return t.across / 8;
    case LFLARE__BURST_COLUMNS: case LFLARE__BURST_CORE_COLUMNS: return (t.columns + 3) / 4;
    case LFLARE__BURST_POLAR: return lflare__row_at(lflare__burst_reach(job)) + 1 - lflare__row_at(LFLARE__CORE_REACH);
    case LFLARE__BURST_CORE_POLAR: return lflare__row_at(LFLARE__CORE_REACH);
    case LFLARE__BURST_FOLD: return LFLARE_STARBURST_ROWS;
    default: return 4 * LFLARE_STARBURST_SIZES;
    }
}

static void lflare__burst_slice(lflare_starburst_job *job, int32_t slice)
{
    int core = job->phase >= LFLARE__BURST_CORE_ROWS;
    lflare__transform t = lflare__burst_transform(job, core);
    int32_t i;
    switch (job->phase) {
    case LFLARE__BURST_PICTURE: lflare__burst_picture(job, slice); break;
    case LFLARE__BURST_ROWS: case LFLARE__BURST_CORE_ROWS:
        for (i = 4 * slice; i < 4 * slice + 4; i++) lflare__transform_rows(&t, i);
        break;
    case LFLARE__BURST_COLUMNS: case LFLARE__BURST_CORE_COLUMNS:
        for (i = 4 * slice; i < 4 * slice + 4 && i < t.columns; i++) lflare__transform_column(&t, i);
        break;
    case LFLARE__BURST_POLAR: lflare__burst_polar(job, lflare__row_at(LFLARE__CORE_REACH) + slice, 0); break;
    case LFLARE__BURST_CORE_POLAR: lflare__burst_polar(job, slice, 1); break;
    case LFLARE__BURST_FOLD:
        if (slice == 0) lflare__burst_extend(job);
        lflare__burst_fold(job, slice);
        if (slice == LFLARE_STARBURST_ROWS - 1) lflare__burst_normalise(job);
        break;
    default: lflare__burst_radial(job, slice); break;
    }
}

LFLARE_API lflare_result lflare_starburst_step(lflare_starburst_job *job, int32_t slices)
{
    if (job == NULL || slices < 1 || job->iris == NULL) return LFLARE_ERROR_ARGUMENT;
    while (job->phase < LFLARE__BURST_DONE && slices > 0) {
        for (; slices > 0 && job->next < lflare__burst_slices(job, job->phase); slices--) lflare__burst_slice(job, job->next++);
        if (job->next < lflare__burst_slices(job, job->phase)) break;
        job->phase++;
        job->next = 0;
    }
    if (job->phase < LFLARE__BURST_DONE) return LFLARE_INCOMPLETE;
    job->out->key = lflare_starburst_key(job->iris);
    return LFLARE_OK;
}

/* What an angle has over its row's mean, on one level, between two rows. */
static void lflare__burst_angle(const lflare_starburst *s, float row, float turn, int32_t level, float *out)
{
    int32_t r = (int32_t)lflare__minf(row, LFLARE_STARBURST_ROWS - 2), count = lflare__level_bins(level), k;
    float at = turn * (float)count - 0.5f, below = floorf(at), f = at - below, g = row - (float)r;
    const float *a = s->angular + 4 * ((size_t)r * LFLARE_STARBURST_COLUMNS + (size_t)(lflare__level_first(level) + (int32_t)below)), *b = a + 4 * LFLARE_STARBURST_COLUMNS;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) out[k] = (1 - g) * (a[k] + f * (a[k + 4] - a[k])) + g * (b[k] + f * (b[k + 4] - b[k]));
}

LFLARE_API void lflare_starburst_at(const lflare_starburst *s, float x, float y, float blur, float *rgb)
{
    const float bin = 3.14159265f / (float)LFLARE_STARBURST_BINS;
    float distance, relative, row, turn, level, size, below[LFLARE_WAVELENGTHS], above[LFLARE_WAVELENGTHS], fade, far;
    int32_t l, j, i, k;
    blur = lflare__maxf(blur, 0.125f);
    distance = lflare__maxf(sqrtf(x * x + y * y), 1e-3f);
    relative = distance / blur;
    row = lflare__minf(lflare__maxf((float)LFLARE_STARBURST_OCTAVE * log2f(16 * distance), 0), LFLARE_STARBURST_ROWS - 1);
    turn = atan2f(y, x) / 3.14159265f; /* half turns */
    turn -= floorf(turn);
    level = lflare__maxf(1 + log2f(0.382f / (relative * bin)), 0); /* which blurs as much as the disc does, seen from the image */
    l = (int32_t)lflare__minf(level, LFLARE_STARBURST_LEVELS - 2);
    lflare__burst_angle(s, row, turn, l, below);
    lflare__burst_angle(s, row, turn, l + 1, above);
    fade = lflare__minf(lflare__maxf(0.5f * (level - (LFLARE_STARBURST_LEVELS - 1)), 0), 1);
    level = (exp2f(2 * lflare__minf(level - (float)l, 1)) - 1) / 3; /* the mixture then has the spread that is asked for */
    size = lflare__minf(log2f(8 * blur), LFLARE_STARBURST_SIZES - 1);
    far = lflare__minf(lflare__maxf(relative - (LFLARE_STARBURST_SAMPLES - 1) / 32.0f + 1, 0), 1);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        float angle = below[k] + level * (above[k] - below[k]), mean = 0, q = 1 + distance;
        angle += fade * (1 - angle);
        if (far > 0) {
            i = (int32_t)lflare__minf(row, LFLARE_STARBURST_ROWS - 2);
            mean = lflare__burst_mean(s, i)[k];
            mean += (row - (float)i) * (lflare__burst_mean(s, i + 1)[k] - mean);
            mean = row < LFLARE_STARBURST_ROWS - 1 ? mean / (q * q * q) : s->tail[k] / (distance * distance * distance);
            mean *= far * (1 + 1.125f / (relative * relative) * (distance / q) * (distance / q)); /* what a disc sees of a cube's fall */
        }
        if (far < 1) {
            const float *a;
            float at = 32 * relative, f, g, v;
            j = (int32_t)lflare__minf(size, LFLARE_STARBURST_SIZES - 2);
            i = (int32_t)lflare__minf(at, LFLARE_STARBURST_SAMPLES - 2);
            f = at - (float)i;
            g = size - (float)j;
            a = s->radial + 4 * ((size_t)j * LFLARE_STARBURST_SAMPLES + (size_t)i) + k;
            v = (1 - g) * (a[0] + f * (a[4] - a[0]));
            a += 4 * LFLARE_STARBURST_SAMPLES;
            v += g * (a[0] + f * (a[4] - a[0]));
            mean += (1 - far) * v * v / (3.14159265f * blur * blur);
        }
        rgb[k] = angle * mean;
    }
}

/* -- ringing -- */

/* Adds to Fresnel's integrals of cos and sin of pi t^2 / 2 what lies between `from` and `from` + `step`: Gauss's two points a quarter. */
static void lflare__fresnel(double *c, double *s, double from, double step)
{
    int32_t i;
    for (i = 0; i < 8; i++) {
        double t = from + step * ((i / 2 + 0.5) / 4 + (i % 2 == 0 ? -1 : 1) / 8.0 / 1.7320508075688772);
        *c += step / 8 * cos(0.5 * LFLARE__PI * t * t);
        *s += step / 8 * sin(0.5 * LFLARE__PI * t * t);
    }
}

enum { LFLARE__KNIFE_STEP = 32, LFLARE__KNIFE_REACH = 16 * LFLARE__KNIFE_STEP }; /* samples a fringe's length; on either side */

/* A straight edge from 16 lengths outside to 16 inside, mean over a band of the wavelength: a Gaussian's spread of 5 %. */
static void lflare__knife_edge(float *out)
{
    enum { REACH = LFLARE__KNIFE_REACH + LFLARE__KNIFE_REACH / 4, BAND = 5 };
    float sharp[2 * REACH + 1];
    double c = 0, s = 0;
    int32_t i, k;
    for (i = 0; i <= REACH; i++) {
        sharp[REACH + i] = (float)(0.5 * ((c + 0.5) * (c + 0.5) + (s + 0.5) * (s + 0.5)));
        sharp[REACH - i] = (float)(0.5 * ((c - 0.5) * (c - 0.5) + (s - 0.5) * (s - 0.5)));
        lflare__fresnel(&c, &s, (double)i / (double)LFLARE__KNIFE_STEP, 1.0 / (double)LFLARE__KNIFE_STEP);
    }
    for (i = -LFLARE__KNIFE_REACH; i <= LFLARE__KNIFE_REACH; i++) {
        double sum = 0, weights = 0;
        for (k = -BAND; k <= BAND; k++) {
            double x = 2.5 * k / (double)BAND, weight = exp(-0.5 * x * x), at = (double)REACH + i / sqrt(1 + 0.05 * x), f = at - floor(at);
            sum += weight * ((1 - f) * (double)sharp[(int32_t)at] + f * (double)sharp[(int32_t)at + 1]);
            weights += weight;
        }
        out[i + LFLARE__KNIFE_REACH] = (float)(sum / weights);
    }
}

/* The knife edge at w lengths inside, blurred by the density of lflare_edge_coverage. */
static double lflare__knife_blurred(const float *knife, double w, double blur)
{
    double sum = 0, weights = 0, half = blur * (double)LFLARE__KNIFE_STEP + 1;
    int32_t k;
    for (k = -(int32_t)half; k <= (int32_t)half; k++) {
        double x = k / half, weight = lflare__max(1 - x * x, 0), at = lflare__clamp(w * (double)LFLARE__KNIFE_STEP + k + (double)LFLARE__KNIFE_REACH, 0, 2 * LFLARE__KNIFE_REACH - 1), f = at - floor(at);
        sum += weight * ((1 - f) * (double)knife[(int32_t)at] + f * (double)knife[(int32_t)at + 1]);
        weights += weight;
    }
    return sum / weights;
}

/* One blur: at both ends the profile fades to 0 and 1; what light that takes away is spread over the middle, so that an edge
   with fringes passes as much as a sharp one. */
static void lflare__ringing_row(const float *knife, double blur, float *out)
{
    double span = 2 * blur + (double)(LFLARE__RING_INNER + LFLARE__RING_OUTER), edge = (blur + (double)LFLARE__RING_OUTER) / span, last = LFLARE_RINGING_SAMPLES - 1, missing, spread = 0;
    int32_t i;
    missing = last * (1 - edge); /* what a sharp edge passes */
    for (i = 0; i < LFLARE_RINGING_SAMPLES; i++) {
        double u = i / last, sharp = u > edge ? 1 : 0, fade = lflare__min(lflare__min(u * span, (1 - u) * span / 1.5), 1);
        out[i] = (float)(sharp + fade * fade * (3 - 2 * fade) * (lflare__knife_blurred(knife, span * (u - edge), blur) - sharp));
        missing -= (i == 0 || i == LFLARE_RINGING_SAMPLES - 1 ? 0.5 : 1) * (double)out[i];
        spread += u * u * (1 - u) * (1 - u);
    }
    for (i = 0; i < LFLARE_RINGING_SAMPLES; i++) {
        double u = i / last;
        out[i] += (float)(missing * u * u * (1 - u) * (1 - u) / spread);
    }
}

LFLARE_API void lflare_ringing_make(float *out)
{
    float knife[2 * LFLARE__KNIFE_REACH + 1];
    int32_t j;
    lflare__knife_edge(knife);
    for (j = 0; j < LFLARE_RINGING_BLURS; j++) {
        double v = (double)j / (LFLARE_RINGING_BLURS - 1) * (double)(LFLARE__RING_WASHED / (LFLARE__RING_WASHED + 2));
        lflare__ringing_row(knife, 2 * v / (1 - v), out + j * LFLARE_RINGING_SAMPLES);
    }
}

/* -- masks in ghosts -- */

/* The mask, an amplitude, is carried on by Fresnel's propagator exp(i pi lambda z f^2), lambda z being twice the fringes' length squared in
   radii, on a grid of 4 x 4 radii. What that would carry farther than two radii is left out: it would come round to the other side. A band
   of the wavelength, a Gaussian's spread of 5 % as for edges, leaves exp(-(0.05 phase)^2 / 2) of what interferes with the direct light;
   the rest of the power passes all the same: a second field of its own, which is added as power. */
enum { LFLARE__FRINGED_GRID = 2 * LFLARE_FRINGED_SIZE, LFLARE__FRINGED_SLICE = 16 };

static float lflare__fringed_ring(int32_t view) { return LFLARE__RING_MOST * exp2f((float)-view / LFLARE__FRINGED_OCTAVE); }

/* Amplitude at a point of the grid, beyond the circumscribed circle that of the circle. */
static float lflare__fringed_amplitude(const uint8_t *mask, int32_t i, int32_t j)
{
    const float texel = 2.0f / (float)LFLARE_FRINGED_SIZE;
    float x = texel * ((float)(i - LFLARE_FRINGED_SIZE) + 0.5f), y = texel * ((float)(j - LFLARE_FRINGED_SIZE) + 0.5f), r = lflare__maxf(sqrtf(x * x + y * y) / (1 - texel), 1);
    const uint8_t *at = mask + 2 * ((size_t)((y / r + 1) / texel) * LFLARE_MASK_SIZE + (size_t)((x / r + 1) / texel));
    return 0.25f / sqrtf(255) * (sqrtf(at[0]) + sqrtf(at[1]) + sqrtf(at[LFLARE_MASK_SIZE]) + sqrtf(at[LFLARE_MASK_SIZE + 1]));
}

/* Its phase is a sum of those along x and y: factors for 0 to half the grid, in cycles per 4 radii. */
static void lflare__fringed_factors(float ring, float *out)
{
    int32_t k;
    for (k = 0; k <= LFLARE_FRINGED_SIZE; k++) {
        double phase = LFLARE__PI * 2 * (double)ring * (double)ring * (k * 0.25) * (k * 0.25);
        out[2 * k] = (float)cos(phase);
        out[2 * k + 1] = (float)sin(phase);
    }
}

/* What it makes of frequency (k, l), of what interferes or of the rest: a complex number. */
static void lflare__fringed_propagator(const float *factors, float ring, int rest, int32_t k, int32_t l, float *out)
{
    const float *a = factors + 2 * k, *b = factors + 2 * l;
    float f2 = 0.0625f * (float)(k * k + l * l), phase = 6.28318531f * ring * ring * f2;
    float fade = lflare__minf(lflare__maxf(4 - 4 * ring * ring * sqrtf(f2), 0), 1), gain = 0;
    if (fade > 0) {
        gain = expf(-0.00125f * phase * phase);
        gain = fade * fade * (3 - 2 * fade) * (rest ? sqrtf(1 - gain * gain) : gain);
    }
    out[0] = gain * (a[0] * b[0] - a[1] * b[1]);
    out[1] = gain * (a[0] * b[1] + a[1] * b[0]);
}

/* One row of the grid along x, kept as a column. */
static void lflare__fringed_row(lflare_fringed_job *job, int32_t j)
{
    const int32_t n = LFLARE__FRINGED_GRID;
    const float *z;
    int32_t i;
    for (i = 0; i < n; i++) {
        job->line[2 * i] = lflare__fringed_amplitude(job->mask, i, j);
        job->line[2 * i + 1] = 0;
    }
    z = lflare__fft(job->line, job->line + 2 * n, job->roots, n);
    for (i = 0; i < n; i++) memcpy(job->spectrum + 2 * ((size_t)i * (size_t)n + (size_t)j), z + 2 * i, 2 * sizeof(float));
}

/* The spectrum's column, which is one block. */
static void lflare__fringed_column(lflare_fringed_job *job, int32_t i)
{
    const int32_t n = LFLARE__FRINGED_GRID;
    float *column = job->spectrum + 2 * (size_t)i * (size_t)n, *z = lflare__fft(column, job->line, job->roots, n);
    if (z != column) memcpy(column, z, sizeof(float) * 2 * (size_t)n);
}

/* A number of the spectrum times the propagator's, conjugated: the inverse transform is the forward one of conjugates, of which only
   powers matter. */
static void lflare__fringed_product(const float *a, const float *h, float *out)
{
    out[0] = a[0] * h[0] - a[1] * h[1];
    out[1] = -(a[0] * h[1] + a[1] * h[0]);
}

/* A column of a view: the rows of the middle half of it. */
static void lflare__fringed_view_column(lflare_fringed_job *job, int32_t view, int rest, int32_t i)
{
    const int32_t n = LFLARE__FRINGED_GRID, across = i > n / 2 ? n - i : i;
    const float *column = job->spectrum + 2 * (size_t)i * (size_t)n, *z;
    float ring = lflare__fringed_ring(view), h[2];
    int32_t k;
    if (i == 0) lflare__fringed_factors(ring, job->factors);
    for (k = 0; k <= n / 2; k++) {
        lflare__fringed_propagator(job->factors, ring, rest, across, k, h);
        lflare__fringed_product(column + 2 * k, h, job->line + 2 * k);
        if (k > 0 && k < n / 2) lflare__fringed_product(column + 2 * (n - k), h, job->line + 2 * (n - k));
    }
    z = lflare__fft(job->line, job->line + 2 * n, job->roots, n);
    for (k = 0; k < n / 2; k++) memcpy(job->field + 2 * ((size_t)k * (size_t)n + (size_t)i), z + 2 * (k + n / 4), 2 * sizeof(float));
}

/* A row of a view: power, with the rest as bytes. */
static void lflare__fringed_view_row(lflare_fringed_job *job, int32_t view, int rest, int32_t j)
{
    const int32_t n = LFLARE__FRINGED_GRID, width = LFLARE_FRINGED_WIDTH, size = LFLARE_FRINGED_SIZE;
    const float scale = 127.5f / ((float)n * (float)n);
    float *row = job->field + 2 * (size_t)j * (size_t)n, *z = lflare__fft(row, job->line, job->roots, n), *light = job->light + (size_t)j * (size_t)size;
    uint8_t *out = job->out + (size_t)(view / LFLARE_FRINGED_ACROSS * size + j) * (size_t)width + view % LFLARE_FRINGED_ACROSS * size;
    int32_t i;
    for (i = 0; i < size; i++) {
        const float *v = z + 2 * (i + n / 4);
        float power = scale * (v[0] * v[0] + v[1] * v[1]) / ((float)n * (float)n);
        light[i] = rest ? light[i] + power : power;
        if (rest) out[i] = (uint8_t)(lflare__minf(light[i], 255) + 0.5f);
    }
}

LFLARE_API lflare_result lflare_fringed_begin(const uint8_t *mask, uint8_t *out, void *work, lflare_fringed_job *job)
{
    const size_t n = LFLARE__FRINGED_GRID;
    if (mask == NULL || out == NULL || work == NULL || job == NULL) return LFLARE_ERROR_ARGUMENT;
    memset(job, 0, sizeof *job);
    job->mask = mask;
    job->out = out;
    job->spectrum = (float *)work;
    job->field = job->spectrum + 2 * n * n;
    job->light = job->field + n * n;
    job->line = job->light + n * n / 4;
    job->roots = job->line + 4 * n;
    job->factors = job->roots + 2 * n;
    lflare__roots(job->roots, (int32_t)n);
    return LFLARE_OK;
}

/* Whose first touch costs the system 10 us a page: in parts, where a row of the grid would touch all of it. */
static void lflare__fringed_clear(lflare_fringed_job *job, int32_t i)
{
    const size_t part = (size_t)13 * LFLARE_FRINGED_SIZE * LFLARE_FRINGED_SIZE / LFLARE__FRINGED_GRID;
    memset(job->spectrum + (size_t)i * part, 0, sizeof(float) * part);
}

/* Rows and columns of the mask; columns and rows of each view, and those of the rest. */
LFLARE_API lflare_result lflare_fringed_step(lflare_fringed_job *job, int32_t slices)
{
    enum { CLEAR, ROWS, COLUMNS, VIEWS, LAST = VIEWS + 4 * LFLARE_FRINGED_VIEWS };
    if (job == NULL || slices < 1 || job->mask == NULL) return LFLARE_ERROR_ARGUMENT;
    for (; job->phase < LAST; slices--) {
        int32_t view = (job->phase - VIEWS) / 4, part = (job->phase - VIEWS) % 4, rest = part / 2, rows = job->phase >= VIEWS && part % 2, i;
        if (slices < 1) return LFLARE_INCOMPLETE;
        for (i = 0; i < LFLARE__FRINGED_SLICE; i++, job->next++) {
            if (job->phase == CLEAR) lflare__fringed_clear(job, job->next);
            else if (job->phase == ROWS) lflare__fringed_row(job, job->next);
            else if (job->phase == COLUMNS) lflare__fringed_column(job, job->next);
            else if (!rows) lflare__fringed_view_column(job, view, rest, job->next);
            else lflare__fringed_view_row(job, view, rest, job->next);
        }
        if (job->next < LFLARE__FRINGED_GRID >> rows) continue;
        if (rows && rest) lflare__halves(job->out, LFLARE_FRINGED_WIDTH, LFLARE_FRINGED_ACROSS, view);
        job->phase++;
        job->next = 0;
    }
    return LFLARE_OK;
}

#endif /* LFLARE_NO_DIFFRACTION */

/* >> 10 aberration */

/* Where rays land farther out than this, in sensor sizes from the axis, they do not matter. */
#define LFLARE__FIT_REACH 0.75

#ifdef LFLARE__PATCHES
/* Knots stand closer towards the angle where the ghost hides: its last sliver narrows with the root of what is left. */
static float lflare__knot_of(float angle, float hidden, int32_t count) { return (1 - sqrtf(lflare__maxf(1 - angle / hidden, 0))) * (float)(count - 1); }
static float lflare__knot_angle(int32_t knot, float hidden, int32_t count)
{
    float rest = 1 - (float)knot / (float)(count - 1);
    return hidden * (1 - rest * rest);
}
#endif

#ifndef LFLARE_NO_ABERRATION
/* The fit of a lens: what exact rays do, as polynomials. Per ghost and at LFLARE__KNOTS field angles, in the light's frame (x
   along its slope), polynomials of the entrance point about the middle of the bundle that passes: the places where a ray meets
   the sensor, the stop and the rims that clip, and its weight. Local polynomials of order 3 to 9 reach what global ones in
   powers of the field angle (P 8) do not, by 10 to 30 dB. By mirror symmetry x and the weight are even in y, y is odd.
   All numbers are little-endian: a head of LFLARE__FIT_HEAD bytes, a row of LFLARE__FIT_ROW bytes a ghost, then the knots. */

enum {
    LFLARE__KNOTS = 12,                    /* field angles of a fit, and of most meshes; */
    LFLARE__MORE_KNOTS = 23,               /* of meshes that change more from one to the next */
    LFLARE__MAX_ORDER = 9,
    LFLARE__EVEN = 30,                     /* even terms of that order */
    LFLARE__ODD = 25,
    LFLARE__MAX_LEVEL = 2,                 /* of a mesh's density */
    LFLARE__MESH_KNOT_TEXELS = 2,          /* of the whole: see lflare__mesh_whole */
    LFLARE__MESH_FUSED = 20,               /* floats of a vertex for three channels: see lflare__mesh_store */
    LFLARE__MESH_SPLIT = 12,               /* for one */
    LFLARE__PLACES = 2 + LFLARE_FIT_RIMS,  /* sensor, stop, rims */
    LFLARE__EVEN_FIELDS = 12,              /* x of the places, the weight, room up to whole vectors */
    LFLARE__FIT_VERSION = 2,
    LFLARE__FIT_HEAD = 32,                 /* magic, version, ghosts, size; hashes of lens and content */
    LFLARE__FIT_ROW = 28                   /* offset, angle where hidden; order, rims, level, bits; steps of the rims; error */
};

/* Terms x^i y^2j with i + 2j <= order, by total degree: a lower order is a prefix. Odd ones are y times those of order - 1. */
static int32_t lflare__terms(int32_t order) { return (order / 2 + 1) * ((order + 1) / 2 + 1); }

/* Other wavelengths are stored as what they differ by from the middle one, which is smoother. */
static int32_t lflare__difference_order(int32_t order) { return order > 3 ? order - 2 : order; }

static uint32_t lflare__get_bytes(const uint8_t *p, int32_t count)
{
    uint32_t v = 0;
    int32_t i;
    for (i = 0; i < count; i++) v |= (uint32_t)p[i] << (8 * i);
    return v;
}

static float lflare__get_float(const uint8_t *p)
{
    uint32_t bits = lflare__get_bytes(p, 4);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static int lflare__get_short(const uint8_t *p) { return (int)(lflare__get_bytes(p, 2) ^ 0x8000u) - 0x8000; }

/* A ghost's row of a fit. */
typedef struct lflare__fit_ghost {
    const uint8_t *knots;     /* NULL: no light comes this way */
    float hidden_angle;
    int32_t order, rims, level, folded, squarings, dense, steps[LFLARE_FIT_RIMS]; /* dense: more knots */
    float error;              /* of the sensor places, greatest of the rays fitted, mm */
    float shrunk[LFLARE_FIT_RIMS]; /* factors of the heights on rims: not 1 where the iris is closer than the full opening that was fitted */
} lflare__fit_ghost;

static size_t lflare__field_bytes(int32_t terms) { return 8 + 2 * (size_t)(terms - 1); }

/* Of one knot. */
static size_t lflare__knot_bytes(int32_t order, int32_t rims)
{
    size_t bytes = 24;
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        int32_t n = k == 0 ? order : lflare__difference_order(order);
        bytes += (size_t)(2 + rims) * lflare__field_bytes(lflare__terms(n) + lflare__terms(n - 1)) + lflare__field_bytes(lflare__terms(n));
    }
    return bytes;
}

static void lflare__fit_ghost_read(const uint8_t *fit, int32_t g, lflare__fit_ghost *out)
{
    const uint8_t *row = fit + LFLARE__FIT_HEAD + (size_t)g * LFLARE__FIT_ROW;
    uint32_t offset = lflare__get_bytes(row, 4);
    int32_t i;
    out->knots = offset > 0 ? fit + offset : NULL;
    out->hidden_angle = lflare__get_float(row + 4);
    out->order = row[8];
    out->rims = row[9];
    out->level = row[10];
    out->folded = row[11] & 1;
    out->squarings = row[11] >> 1 & 3;
    out->dense = row[11] >> 3 & 1;
    for (i = 0; i < LFLARE_FIT_RIMS; i++) {
        out->steps[i] = (int32_t)lflare__get_bytes(row + 12 + 2 * i, 2);
        out->shrunk[i] = 1;
    }
    out->error = lflare__get_float(row + 24);
}

/* A ghost's polynomials at one field angle. */
typedef struct lflare__bundle {
    int32_t order, rims, squarings;
    float middle, half[2];    /* box of the entrance points, mm: x = middle +- half[0], y = +- half[1] */
    float open_middle, open_half[2]; /* outside that box no exact ray passes, whatever polynomials say */
    float even[LFLARE_WAVELENGTHS][LFLARE__EVEN][LFLARE__EVEN_FIELDS]; /* x of the places, then the weight, to be squared so many times */
    float odd[LFLARE_WAVELENGTHS][LFLARE__ODD][LFLARE__PLACES];       /* y */
} lflare__bundle;

/* Adds `share` of a stored field; terms are a row of fields apart. */
static const uint8_t *lflare__field_add(const uint8_t *p, float share, float *even, int32_t even_terms, float *odd, int32_t odd_terms)
{
    float scale = share * lflare__get_float(p + 4);
    int32_t i;
    even[0] += share * lflare__get_float(p);
    p += 8;
    for (i = 1; i < even_terms; i++, p += 2) even[i * LFLARE__EVEN_FIELDS] += scale * (float)lflare__get_short(p);
    for (i = 0; i < odd_terms; i++, p += 2) odd[i * LFLARE__PLACES] += scale * (float)lflare__get_short(p);
    return p;
}

static void lflare__knot_add(const uint8_t *p, float share, lflare__bundle *b)
{
    static const int32_t sequence[LFLARE_WAVELENGTHS] = {1, 0, 2};
    int32_t k, place;
    b->middle += share * lflare__get_float(p);
    b->half[0] += share * lflare__get_float(p + 4);
    b->half[1] += share * lflare__get_float(p + 8);
    b->open_middle += share * lflare__get_float(p + 12);
    b->open_half[0] += share * lflare__get_float(p + 16);
    b->open_half[1] += share * lflare__get_float(p + 20);
    p += 24;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        int32_t w = sequence[k], n = k == 0 ? b->order : lflare__difference_order(b->order);
        for (place = 0; place < 2 + b->rims; place++)
            p = lflare__field_add(p, share, &b->even[w][0][place], lflare__terms(n), &b->odd[w][0][place], lflare__terms(n - 1));
        p = lflare__field_add(p, share, &b->even[w][0][LFLARE__PLACES], lflare__terms(n), NULL, 0);
    }
}

/* Shares of four neighbours among `count` samples in what lies `at` samples from the first; returns which is the first. */
static int32_t lflare__cubic_shares(float at, int32_t count, float *share)
{
    int32_t i = (int32_t)at - 1;
    float f;
    i = i < 0 ? 0 : i > count - 4 ? count - 4 : i;
    f = at - (float)i;
    share[0] = -(f - 1) * (f - 2) * (f - 3) / 6;
    share[1] = f * (f - 2) * (f - 3) / 2;
    share[2] = -f * (f - 1) * (f - 3) / 2;
    share[3] = f * (f - 1) * (f - 2) / 6;
    return i;
}

static void lflare__bundle_at(const lflare__fit_ghost *g, float angle, lflare__bundle *out)
{
    float share[4];
    int32_t first = lflare__cubic_shares(lflare__knot_of(angle, g->hidden_angle, LFLARE__KNOTS), LFLARE__KNOTS, share), i, k, p;
    size_t bytes = lflare__knot_bytes(g->order, g->rims);
    memset(out, 0, sizeof *out);
    out->order = g->order;
    out->rims = g->rims;
    out->squarings = g->squarings;
    for (i = 0; i < 4; i++) lflare__knot_add(g->knots + (size_t)(first + i) * bytes, share[i], out);
    for (k = 0; k < LFLARE_WAVELENGTHS; k += 2) { /* from differences */
        for (i = 0; i < lflare__terms(g->order); i++)
            for (p = 0; p <= LFLARE__PLACES; p++) out->even[k][i][p] += out->even[1][i][p];
        for (i = 0; i < lflare__terms(g->order - 1); i++)
            for (p = 0; p < LFLARE__PLACES; p++) out->odd[k][i][p] += out->odd[1][i][p];
    }
    for (p = 0; p < g->rims; p++)
        for (k = 0; k < LFLARE_WAVELENGTHS && g->shrunk[p] != 1; k++) {
            for (i = 0; i < lflare__terms(g->order); i++) out->even[k][i][2 + p] *= g->shrunk[p];
            for (i = 0; i < lflare__terms(g->order - 1); i++) out->odd[k][i][2 + p] *= g->shrunk[p];
        }
}

/* Every term at a point of the box (x and y from -1 to 1), and on demand its derivatives. */
typedef struct lflare__terms_at {
    float y, value[LFLARE__EVEN], dx[LFLARE__EVEN], dy[LFLARE__EVEN];
} lflare__terms_at;

static void lflare__terms_make(int32_t order, float x, float y, int slopes, lflare__terms_at *t)
{
    float px[LFLARE__MAX_ORDER + 1], py[LFLARE__MAX_ORDER / 2 + 1];
    int32_t d, j, n = 0;
    t->y = y;
    px[0] = py[0] = 1;
    for (d = 1; d <= order; d++) px[d] = px[d - 1] * x;
    for (d = 1; d <= order / 2; d++) py[d] = py[d - 1] * y * y;
    for (d = 0; d <= order; d++)
        for (j = 0; 2 * j <= d; j++) t->value[n++] = px[d - 2 * j] * py[j];
    if (!slopes) return;
    for (d = 0, n = 0; d <= order; d++)
        for (j = 0; 2 * j <= d; j++, n++) {
            int32_t i = d - 2 * j;
            t->dx[n] = i > 0 ? (float)i * px[i - 1] * py[j] : 0;
            t->dy[n] = j > 0 ? (float)(2 * j) * px[i] * py[j - 1] * y : 0;
        }
}

/* One field of many; `step` from term to term. */
static float lflare__sum_terms(const float *coefficients, int32_t step, const float *values, int32_t n)
{
    float sum = 0;
    int32_t i;
    for (i = 0; i < n; i++) sum += coefficients[i * step] * values[i];
    return sum;
}

static float lflare__sum_even(const lflare__bundle *b, int32_t k, int32_t field, const float *values)
{
    return lflare__sum_terms(&b->even[k][0][field], LFLARE__EVEN_FIELDS, values, lflare__terms(b->order));
}

static float lflare__sum_odd(const lflare__bundle *b, int32_t k, int32_t field, const float *values)
{
    return lflare__sum_terms(&b->odd[k][0][field], LFLARE__PLACES, values, lflare__terms(b->order - 1));
}

static void lflare__place_at(const lflare__bundle *b, int32_t k, int32_t place, const lflare__terms_at *t, float *out)
{
    out[0] = lflare__sum_even(b, k, place, t->value);
    out[1] = t->y * lflare__sum_odd(b, k, place, t->value);
}

/* d place / d (x, y) of the box: xx xy yx yy. */
static void lflare__place_slopes(const lflare__bundle *b, int32_t k, int32_t place, const lflare__terms_at *t, float *out)
{
    out[0] = lflare__sum_even(b, k, place, t->dx);
    out[1] = lflare__sum_even(b, k, place, t->dy);
    out[2] = t->y * lflare__sum_odd(b, k, place, t->dx);
    out[3] = t->y * lflare__sum_odd(b, k, place, t->dy) + lflare__sum_odd(b, k, place, t->value);
}

/* All fields at once, as vectors: x of the places and the weight's root, y. */
static void lflare__fields_at(const lflare__bundle *b, int32_t k, const lflare__terms_at *t, float *x, float *y)
{
    float ax[LFLARE__EVEN_FIELDS] = {0}, ay[LFLARE__PLACES] = {0};
    int32_t i, f, even = lflare__terms(b->order), odd = lflare__terms(b->order - 1);
    for (i = 0; i < even; i++)
        for (f = 0; f < LFLARE__EVEN_FIELDS; f++) ax[f] += t->value[i] * b->even[k][i][f];
    for (i = 0; i < odd; i++)
        for (f = 0; f < LFLARE__PLACES; f++) ay[f] += t->value[i] * b->odd[k][i][f];
    memcpy(x, ax, sizeof ax);
    for (f = 0; f < LFLARE__PLACES; f++) y[f] = t->y * ay[f];
}

static float lflare__weight_of(const lflare__bundle *b, float root)
{
    int32_t i;
    root = lflare__minf(lflare__maxf(root, 0), 1); /* beyond what was fitted it may be anything */
    for (i = 0; i < b->squarings; i++) root *= root;
    return root;
}

static float lflare__weight_at(const lflare__bundle *b, int32_t k, const lflare__terms_at *t)
{
    return lflare__weight_of(b, lflare__sum_even(b, k, LFLARE__PLACES, t->value));
}

/* Written out, compilers make one load of it. */
static uint64_t lflare__get_long(const uint8_t *p)
{
    return (uint64_t)p[0] | (uint64_t)p[1] << 8 | (uint64_t)p[2] << 16 | (uint64_t)p[3] << 24 | (uint64_t)p[4] << 32 | (uint64_t)p[5] << 40 |
           (uint64_t)p[6] << 48 | (uint64_t)p[7] << 56;
}

/* Eight lanes side by side: 0.1 ms a megabyte. */
static uint64_t lflare__hash_bytes(const uint8_t *p, size_t size)
{
    uint64_t lane[8], hash = size;
    size_t i;
    int32_t k;
    for (k = 0; k < 8; k++) lane[k] = (uint64_t)k;
    for (i = 0; i + 64 <= size; i += 64)
        for (k = 0; k < 8; k++) {
            lane[k] = (lane[k] ^ lflare__get_long(p + i + 8 * k)) * 0x9E3779B97F4A7C15u;
            lane[k] ^= lane[k] >> 29;
        }
    for (; i < size; i++) hash = (hash ^ p[i]) * 0x9E3779B97F4A7C15u;
    for (k = 0; k < 8; k++) {
        hash = (hash ^ lane[k]) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return hash;
}

static uint64_t lflare__hash_number(uint64_t hash, double v)
{
    uint64_t bits;
    if (v == 0) v = 0; /* -0 */
    memcpy(&bits, &v, sizeof bits);
    hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
    return hash ^ hash >> 32;
}

/* All of a lens that bends or dims its rays. */
static uint64_t lflare__lens_hash(const lflare_lens *lens)
{
    uint64_t hash = LFLARE__FIT_VERSION;
    int32_t i, k;
    for (i = 0; i < lens->surface_count; i++) {
        const lflare_surface *s = &lens->prescription.surfaces[i];
        double numbers[5];
        numbers[0] = s->radius;
        numbers[1] = s->thickness;
        numbers[2] = s->semi_diameter;
        numbers[3] = s->conic;
        numbers[4] = s->is_stop;
        for (k = 0; k < 5; k++) hash = lflare__hash_number(hash, numbers[k]);
        for (k = 0; k < 8; k++) hash = lflare__hash_number(hash, s->aspheric[k]);
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) hash = lflare__hash_number(hash, lflare_index(&s->medium, lflare__rgb_nm[k]));
        hash = lflare__hash_number(hash, s->coating);
        if (s->coating == LFLARE_COATING_QUARTER) hash = lflare__hash_number(hash, s->quarter_nm);
        for (k = 0; s->coating == LFLARE_COATING_STACK && k < s->layer_count; k++) {
            hash = lflare__hash_number(hash, lens->prescription.layers[s->first_layer + k].n);
            hash = lflare__hash_number(hash, lens->prescription.layers[s->first_layer + k].thickness_nm);
        }
    }
    hash = lflare__hash_number(hash, lens->sensor_width);
    return lflare__hash_number(hash, lens->sensor_height);
}

/* The head's word about the ghosts: how many, and above that 16 bits of which, 0 if all have two reflections on one side of the stop. */
static uint32_t lflare__fit_ghosts(const lflare_lens *lens)
{
    uint64_t hash = lflare__hash_number(0, lens->paths.across_stop);
    int32_t i;
    for (i = 0; i < lens->four_count; i++) {
        hash = lflare__hash_number(hash, lens->four[i].first * LFLARE_MAX_SURFACES + lens->four[i].second);
        hash = lflare__hash_number(hash, lens->four[i].third * LFLARE_MAX_SURFACES + lens->four[i].fourth);
    }
    if (!lens->paths.across_stop && lens->four_count == 0) return (uint32_t)lens->ghost_count;
    return (uint32_t)lens->ghost_count | (uint32_t)(hash >> 48 | 1) << 16;
}

static const char lflare__fit_magic[6] = {'L', 'F', 'L', 'F', 'I', 'T'};

/* The checksum of all that a fit holds. */
static uint64_t lflare__fit_hash(const uint8_t *fit) { return lflare__get_bytes(fit + 24, 4) | (uint64_t)lflare__get_bytes(fit + 28, 4) << 32; }

/* Whether a row and its knots are as the writer writes them. */
static int lflare__fit_ghost_valid(const lflare__fit_ghost *g, const uint8_t *fit, size_t size)
{
    size_t offset;
    if (g->knots == NULL) return 1;
    if (g->order < 3 || g->order > LFLARE__MAX_ORDER || g->rims > LFLARE_FIT_RIMS || g->level > LFLARE__MAX_LEVEL) return 0;
    if (!(g->hidden_angle > 0 && g->hidden_angle < 1.6f)) return 0;
    offset = (size_t)(g->knots - fit);
    return offset < size && size - offset >= LFLARE__KNOTS * lflare__knot_bytes(g->order, g->rims);
}

static int lflare__fit_number_valid(const uint8_t *p, float least)
{
    float v = lflare__get_float(p);
    return v >= least && v <= 1e12f; /* not NaN either; what is made of it stays within floats */
}

/* Whether all numbers of a ghost's knots are such that a mesh can be made of them. */
static int lflare__fit_numbers_valid(const lflare__fit_ghost *g)
{
    static const float least[6] = {-1e12f, 1e-9f, 1e-9f, -1e12f, 0, 0}; /* boxes */
    const uint8_t *p = g->knots;
    int32_t j, i, k;
    for (j = 0; j < LFLARE__KNOTS && p != NULL; j++) {
        for (i = 0; i < 6; i++, p += 4)
            if (!lflare__fit_number_valid(p, least[i])) return 0;
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
            int32_t n = k == 0 ? g->order : lflare__difference_order(g->order);
            for (i = 0; i <= 2 + g->rims; i++) {
                if (!lflare__fit_number_valid(p, -1e12f) || !lflare__fit_number_valid(p + 4, -1e12f)) return 0;
                p += lflare__field_bytes(lflare__terms(n) + (i < 2 + g->rims ? lflare__terms(n - 1) : 0));
            }
        }
    }
    return 1;
}

LFLARE_API lflare_result lflare_aberration_check(const lflare_lens *lens, const void *fit, size_t size, lflare_error *error)
{
    const uint8_t *p = (const uint8_t *)fit;
    uint64_t hash;
    int32_t g;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (lens == NULL || fit == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no lens or no fit given");
    if (memcmp(p, lflare__fit_magic, size < 6 ? size : 6) != 0 || size == 0)
        return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "this is not a fit: it does not begin with LFLFIT");
    if (size < LFLARE__FIT_HEAD) return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit is cut off: %g bytes, less than its head", (double)size);
    if (lflare__get_bytes(p + 6, 2) != LFLARE__FIT_VERSION)
        return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit has version %i, this library reads %i: make it anew", (int32_t)lflare__get_bytes(p + 6, 2),
                            (int32_t)LFLARE__FIT_VERSION);
    if (lflare__get_bytes(p + 12, 4) != size)
        return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, lflare__get_bytes(p + 12, 4) > size ? "the fit is cut off: %g bytes of %g" : "the fit is too long: %g bytes of %g",
                            (double)size, (double)lflare__get_bytes(p + 12, 4));
    hash = lflare__hash_bytes(p + LFLARE__FIT_HEAD, size - LFLARE__FIT_HEAD);
    if (lflare__fit_hash(p) != hash)
        return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit is damaged: its checksum is wrong");
    hash = lflare__lens_hash(lens);
    if (lflare__get_bytes(p + 16, 4) == (uint32_t)hash && lflare__get_bytes(p + 20, 4) == (uint32_t)(hash >> 32) && lflare__get_bytes(p + 8, 4) != lflare__fit_ghosts(lens))
        return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit was made for other paths of this lens (%i ghosts, not %i): see lflare_lens_paths; make it anew",
                            (int32_t)(lflare__get_bytes(p + 8, 4) & 65535), lens->ghost_count);
    if (lflare__get_bytes(p + 16, 4) != (uint32_t)hash || lflare__get_bytes(p + 20, 4) != (uint32_t)(hash >> 32))
        return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit belongs to another lens, or the lens was changed since: make it anew");
    if (size - LFLARE__FIT_HEAD < (size_t)lens->ghost_count * LFLARE__FIT_ROW) return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit is too short for its ghosts");
    for (g = 0; g < lens->ghost_count; g++) {
        lflare__fit_ghost ghost;
        lflare__fit_ghost_read(p, g, &ghost);
        if (!lflare__fit_ghost_valid(&ghost, p, size) || !lflare__fit_numbers_valid(&ghost)) return lflare__fail(error, LFLARE_ERROR_FIT, 0, 0, "the fit's row of ghost %i is out of range", g);
    }
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_aberration_ray(const void *fit, int32_t g, int32_t k, const double entrance[2], const double slope[2], lflare_fitted_ray *out)
{
    lflare__fit_ghost ghost;
    lflare__bundle b;
    lflare__terms_at terms;
    float u, ax, ay, x, y;
    int32_t p;
    if (fit == NULL || g < 0 || (uint32_t)g >= (lflare__get_bytes((const uint8_t *)fit + 8, 4) & 65535) || k < 0 || k >= LFLARE_WAVELENGTHS || entrance == NULL || slope == NULL || out == NULL)
        return LFLARE_ERROR_ARGUMENT;
    memset(out, 0, sizeof *out);
    lflare__fit_ghost_read((const uint8_t *)fit, g, &ghost);
    u = (float)sqrt(slope[0] * slope[0] + slope[1] * slope[1]);
    if (ghost.knots == NULL || !(atanf(u) < ghost.hidden_angle)) return LFLARE_INCOMPLETE;
    ax = u > 0 ? (float)slope[0] / u : 1;
    ay = u > 0 ? (float)slope[1] / u : 0;
    lflare__bundle_at(&ghost, atanf(u), &b);
    x = ((float)entrance[0] * ax + (float)entrance[1] * ay - b.middle) / b.half[0];
    y = ((float)entrance[1] * ax - (float)entrance[0] * ay) / b.half[1];
    lflare__terms_make(b.order, x, y, 0, &terms);
    for (p = 0; p < 2 + b.rims; p++) {
        float place[2], *to = p == 0 ? out->sensor : p == 1 ? out->stop : out->rims[p - 2];
        lflare__place_at(&b, k, p, &terms, place);
        to[0] = place[0] * ax - place[1] * ay;
        to[1] = place[1] * ax + place[0] * ay;
    }
    out->rim_count = b.rims;
    out->weight = lflare__weight_at(&b, k, &terms);
    return fabsf(x) <= 1 && fabsf(y) <= 1 ? LFLARE_OK : LFLARE_INCOMPLETE;
}

#endif /* LFLARE_NO_ABERRATION */

/* >> 11 trace */
#ifndef LFLARE_NO_TRACE

LFLARE_API lflare_result lflare_path_make(const lflare_lens *lens, double nm, const lflare_pair *pair, lflare_path *out)
{
    static const lflare_pair none = {-1, -1, 0, 0};
    double n[LFLARE_MAX_SURFACES + 1], z[LFLARE_MAX_SURFACES];
    lflare__walk walk;
    lflare_crossing at;
    int32_t i;
    if (lens == NULL || out == NULL || !(nm > 0) || (pair != NULL && !lflare__valid_pair(lens, *pair))) return LFLARE_ERROR_ARGUMENT;
    out->lens = lens;
    out->nm = nm;
    out->step_count = out->unweighted = 0;
    out->sensor_z = 0;
    for (i = 0; i < lens->surface_count; i++) {
        z[i] = out->sensor_z;
        out->sensor_z += lens->prescription.surfaces[i].thickness;
    }
    lflare__indices(&lens->prescription, nm, n);
    lflare__walk_start(&walk, lens, n, pair != NULL ? *pair : none);
    while (lflare__walk_next(&walk, &at)) {
        lflare_step *s = &out->steps[out->step_count++];
        const lflare_surface *surface = &lens->prescription.surfaces[at.surface];
        s->surface = at.surface;
        s->backwards = at.backwards;
        s->reflected = at.reflected;
        s->iris = at.iris;
        s->z = z[at.surface];
        s->n_in = at.n_in;
        s->n_out = at.n_out;
        s->eta = at.n_in / at.n_out;
        s->curvature = surface->radius != 0 ? 1 / surface->radius : 0;
        s->semi = surface->semi_diameter;
        s->polynomial = 0;
        for (i = 0; i < 8; i++) s->polynomial |= surface->aspheric[i] != 0;
        s->n_front = n[at.surface];
        s->n_behind = n[at.surface + 1];
        s->layer_count = surface->coating == LFLARE_COATING_STACK ? surface->layer_count : surface->coating == LFLARE_COATING_QUARTER;
        s->layers = surface->coating == LFLARE_COATING_STACK ? lens->prescription.layers + surface->first_layer : NULL;
        if (surface->coating == LFLARE_COATING_QUARTER) {
            int32_t one = 1;
            lflare_film_layers(lens, at.surface, &s->quarter, &one);
        }
    }
    return LFLARE_OK;
}

/* Sag's derivative over r, at r^2. */
static double lflare__sag_slope(const lflare_surface *s, double r2)
{
    double c = s->radius != 0 ? 1 / s->radius : 0, slope = c / sqrt(1 - (1 + s->conic) * c * c * r2), term = 1;
    int32_t i;
    for (i = 0; i < 8; i++, term *= r2) slope += 2 * (i + 1) * s->aspheric[i] * term;
    return slope;
}

/* Where a ray from p (seen from the vertex) along the unit vector d meets a surface: p is moved there, *normal faces the front.
   `way` is 1 or -1, along z. */
static int lflare__meet(const lflare_surface *s, double c, int polynomial, double *p, const double *d, double way, double *normal)
{
    double k = 1 + s->conic, a, b, e, root, t, norm;
    int32_t i;
    /* c (x^2 + y^2 + k z^2) = 2 z; of both roots the one on the vertex's sheet, in a form that holds for c = 0 */
    a = c * (d[0] * d[0] + d[1] * d[1] + k * d[2] * d[2]);
    b = c * (p[0] * d[0] + p[1] * d[1] + k * p[2] * d[2]) - d[2];
    e = c * (p[0] * p[0] + p[1] * p[1] + k * p[2] * p[2]) - 2 * p[2];
    root = b * b - a * e;
    if (root >= 0) t = e / (-b + way * sqrt(root));
    else if (polynomial) t = -p[2] / d[2];
    else return 0;
    for (i = 0; i < 3; i++) p[i] += t * d[i];
    if (polynomial) {
        double off = 1;
        for (i = 0; i < 50 && fabs(off) > 1e-13 * (1 + fabs(p[2])); i++) {
            double slope, r2 = p[0] * p[0] + p[1] * p[1];
            int32_t j;
            off = p[2] - lflare_sag(s, sqrt(r2));
            slope = lflare__sag_slope(s, r2);
            t = -off / (d[2] - slope * (p[0] * d[0] + p[1] * d[1]));
            for (j = 0; j < 3; j++) p[j] += t * d[j];
        }
        if (!(fabs(off) <= 1e-9)) return 0; /* not found, or beyond the surface's end */
        normal[0] = lflare__sag_slope(s, p[0] * p[0] + p[1] * p[1]);
        normal[2] = -1;
    } else {
        normal[0] = c;
        normal[2] = c * k * p[2] - 1;
        if (!(normal[2] < 0)) return 0; /* past the equator: the other sheet */
    }
    normal[1] = normal[0] * p[1];
    normal[0] *= p[0];
    if (k == 1 && !polynomial) return 1; /* a sphere's is a unit vector */
    norm = 1 / sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (i = 0; i < 3; i++) normal[i] *= norm;
    return lflare__finite(norm);
}

/* Share of the power that goes on. */
static double lflare__step_share(const lflare_step *s, double nm, double sine)
{
    double r;
    if (s->layer_count == 0 && s->n_front == s->n_behind) return s->reflected ? 0 : 1;
    r = lflare_film_reflectance(s->n_front, s->n_behind, s->layers != NULL ? s->layers : &s->quarter, s->layer_count, nm, s->n_in * sine);
    return s->reflected ? r : 1 - r;
}

LFLARE_API lflare_fate lflare_path_trace(const lflare_path *path, const double entrance[2], const double slope[2], lflare_ray *out, lflare_hit *hits)
{
    const lflare_surface *surfaces = path->lens->prescription.surfaces;
    double p[3] = {entrance[0], entrance[1], 0}, d[3] = {slope[0], slope[1], 1}, norm = 1 / sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]), z = 0;
    int32_t i, k;
    memset(out, 0, sizeof *out);
    out->weight = path->unweighted ? 0 : 1;
    for (k = 0; k < 3; k++) d[k] *= norm;
    for (i = 0; i < path->step_count; i++) {
        const lflare_step *s = &path->steps[i];
        const lflare_surface *surface = &surfaces[s->surface];
        double normal[3], cosine, share = 1, way = s->backwards ? -1 : 1, height;
        p[2] += z - s->z; /* seen from this vertex */
        z = s->z;
        if (!(d[2] * way > 0) || !lflare__meet(surface, s->curvature, s->polynomial, p, d, way, normal)) return out->fate = LFLARE_RAY_MISSES;
        cosine = -way * (d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]);
        height = sqrt(p[0] * p[0] + p[1] * p[1]) / s->semi;
        if (surface->is_stop) {
            double *at = out->stops[out->stop_count++];
            at[0] = p[0];
            at[1] = p[1];
            if (s->iris) {
                out->stop[0] = p[0];
                out->stop[1] = p[1];
            }
        } else if (height > out->relative) {
            out->relative = height;
            out->widest = s->surface;
        }
        if (s->reflected) {
            for (k = 0; k < 3; k++) d[k] += 2 * cosine * way * normal[k];
        } else if (s->n_in != s->n_out) {
            double eta = s->eta, after = 1 - eta * eta * (1 - cosine * cosine);
            if (after < 0) return out->fate = LFLARE_RAY_TOTAL;
            for (k = 0; k < 3; k++) d[k] = eta * d[k] + (eta * cosine - sqrt(after)) * way * normal[k];
        }
        if (!path->unweighted && !surface->is_stop) {
            share = lflare__step_share(s, path->nm, sqrt(lflare__max(1 - cosine * cosine, 0)));
            out->weight *= share;
        }
        out->steps = i + 1;
        if (hits != NULL) {
            lflare_hit *h = &hits[i];
            h->surface = s->surface;
            h->backwards = s->backwards;
            h->reflected = s->reflected;
            for (k = 0; k < 3; k++) h->position[k] = p[k], h->direction[k] = d[k];
            h->position[2] += s->z;
            h->relative = height;
            h->cosine = cosine;
            h->share = share;
        }
    }
    if (!(d[2] > 0)) return out->fate = LFLARE_RAY_MISSES;
    for (k = 0; k < 3; k++) out->direction[k] = d[k];
    for (k = 0; k < 2; k++) out->sensor[k] = p[k] + d[k] / d[2] * (path->sensor_z - z - p[2]);
    return LFLARE_RAY_ARRIVES;
}

/* -- traced rays: floats, from the tables alone, as shaders trace them -- */

/* The bits of a step, beside 16 times its surface; see lflare_tables.steps. */
enum { LFLARE__STEP_REFLECTS = 1, LFLARE__STEP_STOP = 2, LFLARE__STEP_BENT = 4, LFLARE__STEP_BACK = 8, LFLARE__STEP_SURFACE = 16 };

static int32_t lflare__step_count(const lflare_tables *t, lflare_pair p) { return t->surface_count + 2 * (p.first - p.second + p.third - p.fourth); }

/* The crossing of the stop that blades shape. */
static int lflare__step_is_iris(const float *step) { return ((int32_t)step[7] & 3) == LFLARE__STEP_STOP; }

/* Of all ghosts. */
static int32_t lflare__steps_of(const lflare_tables *t)
{
    int32_t last = t->ghost_count - 1;
    return last < 0 ? 0 : (int32_t)t->head[(size_t)last * LFLARE_HEAD_FLOATS + 15] + lflare__step_count(t, t->pairs[last]);
}

/* The steps of a ghost. */
static void lflare__steps_make(const lflare_lens *lens, lflare_tables *t, int32_t g, const double n[][LFLARE_MAX_SURFACES + 1])
{
    float *row = t->steps + (size_t)t->head[(size_t)g * LFLARE_HEAD_FLOATS + 15] * LFLARE_STEP_FLOATS, z = 0;
    lflare__walk walk[LFLARE_WAVELENGTHS];
    lflare_crossing at;
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) lflare__walk_start(&walk[k], lens, n[k], t->pairs[g]);
    while (lflare__walk_next(&walk[0], &at)) {
        const float *s = t->surface + at.surface * LFLARE_SURFACE_FLOATS;
        int32_t code = at.surface * LFLARE__STEP_SURFACE + (at.reflected ? LFLARE__STEP_REFLECTS : 0) + (at.backwards ? LFLARE__STEP_BACK : 0), j;
        if (at.surface == lens->stop) code += at.iris ? LFLARE__STEP_STOP : LFLARE__STEP_STOP + LFLARE__STEP_REFLECTS;
        for (j = 4; j < LFLARE_SURFACE_FLOATS; j++)
            if (s[j] != 0) code |= LFLARE__STEP_BENT;
        row[0] = s[0] - z;
        z = s[0];
        row[1] = s[1];
        row[2] = 1 / s[2];
        row[3] = s[3];
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
            if (k > 0) lflare__walk_next(&walk[k], &at);
            row[4 + k] = (float)(at.n_in / at.n_out);
        }
        row[7] = (float)code;
        row += LFLARE_STEP_FLOATS;
    }
}

/* What all rays of a ghost share. */
typedef struct lflare__tracer {
    const lflare_tables *t;
    const float *steps;
    int32_t count;
    float slope, sensor;               /* of the light, along x; from the last vertex to the sensor, mm */
    float *many;                       /* NULL, or receives the weights of all of more than three wavelengths */
    const float *ends[LFLARE_WAVELENGTHS]; /* shares of the longest wavelength, of the middle one, of the shortest */
} lflare__tracer;

static void lflare__tracer_make(const lflare_tables *t, int32_t g, lflare__tracer *o)
{
    o->t = t;
    o->steps = t->steps + (size_t)t->head[(size_t)g * LFLARE_HEAD_FLOATS + 15] * LFLARE_STEP_FLOATS;
    o->count = lflare__step_count(t, t->pairs[g]);
    o->many = NULL;
    lflare__ends_of(t, o->ends);
    o->sensor = t->sensor_z - t->surface[(t->surface_count - 1) * LFLARE_SURFACE_FLOATS];
}

/* A ray on its way through a ghost, in the light's frame; z from the vertex of the surface it meets. */
typedef struct lflare__traced_ray {
    float p[3], d[3], stop[2], sensor[2]; /* stop: in radii of the iris */
    float relative;                       /* largest of all clear semi-diameters, */
    int32_t widest, steps;                /* and at which step that is; crossings met */
    float weight[LFLARE_WAVELENGTHS];     /* with the films of each wavelength */
    int arrives;
} lflare__traced_ray;

/* The sag at the rim's share r2 of the radius squared that the aspheric terms make, and what it grows by with r2. */
static float lflare__traced_terms(const float *terms, float r2, float *slope)
{
    float sag = 0;
    int32_t j;
    for (*slope = 0, j = 7; j >= 0; j--) {
        *slope = *slope * r2 + sag;
        sag = sag * r2 + terms[j];
    }
    *slope = *slope * r2 + sag;
    return sag * r2;
}

/* Moves the ray to a step's surface, `way` 1 or -1 along z; terms: NULL, or of an asphere; the normal faces the front. See lflare__meet. */
static int lflare__traced_meet(const float *s, const float *terms, float way, lflare__traced_ray *ray, float *normal)
{
    float *p = ray->p, *d = ray->d, c = s[1], k = s[3], a, b, e, root, t = -p[2] / d[2], norm, slope = 0;
    int32_t i, pass;
    for (i = 0; i < 2; i++) p[i] += t * d[i]; /* to the vertex's plane first: smaller numbers */
    a = c * (d[0] * d[0] + d[1] * d[1] + k * d[2] * d[2]);
    b = c * (p[0] * d[0] + p[1] * d[1]) - d[2];
    e = c * (p[0] * p[0] + p[1] * p[1]);
    root = b * b - a * e;
    if (root >= 0) t = e / (-b + way * sqrtf(root));
    else if (terms != NULL) t = 0;
    else return 0;
    for (p[2] = 0, i = 0; i < 3; i++) p[i] += t * d[i];
    normal[0] = c;
    normal[2] = c * k * p[2] - 1;
    for (pass = 0; pass < 6 && terms != NULL; pass++) {
        float r2 = p[0] * p[0] + p[1] * p[1], inverse = s[2] * s[2], bent = 1 - k * c * c * r2, conic = sqrtf(lflare__maxf(bent, 1e-6f));
        float sag = c * r2 / (1 + conic) + lflare__traced_terms(terms, r2 * inverse, &slope);
        normal[0] = c / conic + 2 * slope * inverse;
        normal[2] = -1;
        if (bent < 0) return 0;
        t = (sag - p[2]) / (d[2] - normal[0] * (p[0] * d[0] + p[1] * d[1]));
        for (i = 0; i < 3; i++) p[i] += t * d[i];
    }
    if (!(normal[2] < 0)) return 0; /* past the equator: the other sheet */
    normal[1] = normal[0] * p[1];
    normal[0] *= p[0];
    if (k == 1 && terms == NULL) return 1; /* a sphere's is a unit vector */
    norm = 1 / sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (i = 0; i < 3; i++) normal[i] *= norm;
    return lflare__finite((double)norm);
}

/* Refracts it by `eta`, the index before over that behind, or reflects it; films, unless NULL, decide what goes on; *at: where they are looked up.
   0: total reflection. */
static int lflare__traced_pass(const float *film, float eta, int reflected, const float *normal, lflare__traced_ray *ray, float *at)
{
    float *d = ray->d, along = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2], cosine = fabsf(along), beyond = 1 - eta * eta * (1 - cosine * cosine);
    int32_t k;
    *at = eta > 1 ? sqrtf(lflare__maxf(beyond, 0)) : cosine;
    for (k = 0; k < LFLARE_WAVELENGTHS && film != NULL; k++) {
        float r = lflare__film_lookup(film, k, *at);
        ray->weight[k] *= reflected ? r : 1 - r;
    }
    if (reflected) {
        for (k = 0; k < 3; k++) d[k] -= 2 * along * normal[k];
        return 1;
    }
    if (beyond < 0) return 0;
    beyond = along < 0 ? -sqrtf(beyond) : sqrtf(beyond);
    for (k = 0; k < 3; k++) d[k] = eta * d[k] + (beyond - eta * along) * normal[k];
    return 1;
}

/* What the films of a surface let go on at each of more than three wavelengths. */
static void lflare__films_pass(const lflare_tables *t, int32_t surface, int reflected, float cosine, float *weights)
{
    float at = cosine * (LFLARE_FILM_SAMPLES - 1), f;
    int32_t i = (int32_t)lflare__minf(lflare__maxf(at, 0), LFLARE_FILM_SAMPLES - 2), w;
    const float *a = t->films + ((size_t)surface * LFLARE_FILM_SAMPLES + (size_t)i) * (LFLARE_MAX_WAVELENGTHS + 1), *b = a + LFLARE_MAX_WAVELENGTHS + 1;
    f = at - (float)i;
    for (w = 0; w < t->wavelength_count; w++) {
        float r = a[w] + f * (b[w] - a[w]);
        weights[w] *= reflected ? r : 1 - r;
    }
}

/* From the entrance point (x, y) through all steps to the sensor (H 4; P 7), at the wavelength that `shares` make; weighing costs as
   much again. */
static void lflare__traced_ray_make(const lflare__tracer *o, const float *shares, int weigh, float x, float y, lflare__traced_ray *ray)
{
    const float *s = o->steps;
    float norm = 1 / sqrtf(1 + o->slope * o->slope), widest = 0;
    int32_t j;
    memset(ray, 0, sizeof *ray);
    ray->p[0] = x;
    ray->p[1] = y;
    ray->d[0] = o->slope * norm;
    ray->d[2] = norm;
    for (j = 0; j < LFLARE_WAVELENGTHS; j++) ray->weight[j] = 1;
    for (; ray->steps < o->count; ray->steps++, s += LFLARE_STEP_FLOATS) {
        int32_t code = (int32_t)s[7], surface = code / LFLARE__STEP_SURFACE;
        float normal[3], way = code & LFLARE__STEP_BACK ? -1.0f : 1.0f, height, at;
        ray->p[2] -= s[0];
        if (!(ray->d[2] * way > 0)) return; /* it went the wrong way */
        if (!lflare__traced_meet(s, code & LFLARE__STEP_BENT ? o->t->surface + surface * LFLARE_SURFACE_FLOATS + 4 : NULL, way, ray, normal)) return;
        if ((code & LFLARE__STEP_STOP) && !(code & LFLARE__STEP_REFLECTS)) {
            for (j = 0; j < 2; j++) ray->stop[j] = ray->p[j] / o->t->iris.radius;
            continue;
        }
        height = (ray->p[0] * ray->p[0] + ray->p[1] * ray->p[1]) * (code & LFLARE__STEP_STOP ? 1 / (o->t->iris.radius * o->t->iris.radius) : s[2] * s[2]);
        if (height > widest) {
            widest = height;
            ray->widest = ray->steps;
        }
        if (code & LFLARE__STEP_STOP) continue;
        if (!lflare__traced_pass(weigh ? o->t->film + (size_t)surface * LFLARE_FILM_SAMPLES * 4 : NULL, s[4] * shares[0] + s[5] * shares[1] + s[6] * shares[2],
                                 code & LFLARE__STEP_REFLECTS, normal, ray, &at)) return;
        if (o->many != NULL) lflare__films_pass(o->t, surface, code & LFLARE__STEP_REFLECTS, at, o->many);
    }
    if (!(ray->d[2] > 0)) return;
    ray->relative = sqrtf(widest);
    for (j = 0; j < 2; j++) ray->sensor[j] = ray->p[j] + ray->d[j] / ray->d[2] * (o->sensor - ray->p[2]);
    ray->arrives = lflare__finite((double)(ray->sensor[0] + ray->sensor[1] + ray->relative));
}

/* -- the rays that a ghost lets through -- */

/* A ghost's paths, and what else stops rays: the iris, and that they land too far off to matter. */
typedef struct lflare__finder {
    const lflare_lens *lens;
    double iris, reach;               /* radii on the stop plane and on the sensor, mm */
    int32_t lead;                     /* the wavelength that searches look at */
    lflare__tracer *tracer;           /* traces in place of paths, faster; NULL: they do */
    lflare_path paths[LFLARE_WAVELENGTHS];
} lflare__finder;

#ifndef LFLARE_NO_ABERRATION
static void lflare__finder_make(lflare__finder *f, const lflare_lens *lens, lflare_pair pair, double iris)
{
    int32_t k;
    f->lens = lens;
    f->iris = iris;
    f->lead = 1;
    f->tracer = NULL;
    f->reach = LFLARE__FIT_REACH * lflare__max(lens->sensor_width, lens->sensor_height);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        lflare_path_make(lens, lflare__rgb_nm[k], &pair, &f->paths[k]);
        f->paths[k].unweighted = 1;
    }
}
#endif

/* lflare__closed by floats. */
static double lflare__closed_floats(lflare__finder *f, int32_t k, double x, double y, double slope, lflare__traced_ray *ray)
{
    double stop;
    f->tracer->slope = (float)slope;
    lflare__traced_ray_make(f->tracer, f->tracer->ends[k], 0, (float)x, (float)y, ray);
    if (!ray->arrives) return 5 - (double)ray->steps / f->tracer->count;
    stop = sqrt((double)(ray->stop[0] * ray->stop[0] + ray->stop[1] * ray->stop[1])) * (double)f->tracer->t->iris.radius / f->iris;
    stop = lflare__max(stop, sqrt((double)(ray->sensor[0] * ray->sensor[0] + ray->sensor[1] * ray->sensor[1])) / f->reach);
    return lflare__min(lflare__max(stop, (double)ray->relative), 4);
}

/* How closed the lens is to a ray: up to 1 it passes and lands near the frame, above 4 it never arrives. */
static double lflare__closed(lflare__finder *f, int32_t k, double x, double y, double slope, lflare_ray *ray, lflare_hit *hits)
{
    double entrance[2], u[2], stop = 0;
    int32_t i;
    entrance[0] = x;
    entrance[1] = y;
    u[0] = slope;
    u[1] = 0;
    if (lflare_path_trace(&f->paths[k], entrance, u, ray, hits) != LFLARE_RAY_ARRIVES) return 5 - (double)ray->steps / f->paths[k].step_count;
    for (i = 0; i < ray->stop_count; i++) stop = lflare__max(stop, sqrt(ray->stops[i][0] * ray->stops[i][0] + ray->stops[i][1] * ray->stops[i][1]) / f->iris);
    stop = lflare__max(stop, sqrt(ray->sensor[0] * ray->sensor[0] + ray->sensor[1] * ray->sensor[1]) / f->reach);
    return lflare__min(lflare__max(stop, ray->relative), 4);
}

/* LFLARE__LANES rays side by side, as lflare__traced_ray_make: heights alone. open: 0 once a ray is lost, at its `steps`. */
enum { LFLARE__LANES = 8 };
typedef struct lflare__lanes {
    float p[3][LFLARE__LANES], d[3][LFLARE__LANES], normal[3][LFLARE__LANES], stop[2][LFLARE__LANES], widest[LFLARE__LANES], root[LFLARE__LANES];
    int32_t open[LFLARE__LANES], steps[LFLARE__LANES];
} lflare__lanes;

/* As lflare__traced_meet without aspheric terms. Square roots, which may set errno, have loops of their own: compilers make vectors of the rest. */
static void lflare__lanes_meet(const float *s, float way, lflare__lanes *r)
{
    float a[LFLARE__LANES], b[LFLARE__LANES], e[LFLARE__LANES], c = s[1], k = s[3];
    int32_t i;
    for (i = 0; i < LFLARE__LANES; i++) {
        float dx = r->d[0][i], dy = r->d[1][i], dz = r->d[2][i], t = -r->p[2][i] / dz, x = r->p[0][i] + t * dx, y = r->p[1][i] + t * dy, root;
        a[i] = c * (dx * dx + dy * dy + k * dz * dz);
        b[i] = c * (x * dx + y * dy) - dz;
        e[i] = c * (x * x + y * y);
        root = b[i] * b[i] - a[i] * e[i];
        r->open[i] &= root >= 0;
        r->root[i] = root >= 0 ? root : 0;
        r->p[0][i] = x;
        r->p[1][i] = y;
    }
    for (i = 0; i < LFLARE__LANES; i++) r->root[i] = sqrtf(r->root[i]);
    for (i = 0; i < LFLARE__LANES; i++) {
        float t = e[i] / (way * r->root[i] - b[i]), x = r->p[0][i] + t * r->d[0][i], y = r->p[1][i] + t * r->d[1][i], z = t * r->d[2][i], n2 = c * k * z - 1;
        r->p[0][i] = x;
        r->p[1][i] = y;
        r->p[2][i] = z;
        r->normal[0][i] = c * x;
        r->normal[1][i] = c * y;
        r->normal[2][i] = n2;
        r->open[i] &= n2 < 0;
    }
    for (i = 0; i < LFLARE__LANES && k != 1; i++) {
        float norm = 1 / sqrtf(r->normal[0][i] * r->normal[0][i] + r->normal[1][i] * r->normal[1][i] + r->normal[2][i] * r->normal[2][i]);
        r->normal[0][i] *= norm;
        r->normal[1][i] *= norm;
        r->normal[2][i] *= norm;
    }
}

/* See lflare__traced_pass. */
static void lflare__lanes_pass(float eta, int reflected, lflare__lanes *r)
{
    float along[LFLARE__LANES];
    int32_t i;
    for (i = 0; i < LFLARE__LANES; i++) along[i] = r->d[0][i] * r->normal[0][i] + r->d[1][i] * r->normal[1][i] + r->d[2][i] * r->normal[2][i];
    if (reflected) {
        for (i = 0; i < LFLARE__LANES; i++) r->root[i] = -2 * along[i];
        eta = 1;
    } else {
        for (i = 0; i < LFLARE__LANES; i++) {
            float beyond = 1 - eta * eta * (1 - along[i] * along[i]);
            r->open[i] &= beyond >= 0;
            r->root[i] = beyond >= 0 ? beyond : 0;
        }
        for (i = 0; i < LFLARE__LANES; i++) r->root[i] = sqrtf(r->root[i]);
        for (i = 0; i < LFLARE__LANES; i++) r->root[i] = (along[i] < 0 ? -r->root[i] : r->root[i]) - eta * along[i];
    }
    for (i = 0; i < LFLARE__LANES; i++) {
        r->d[0][i] = eta * r->d[0][i] + r->root[i] * r->normal[0][i];
        r->d[1][i] = eta * r->d[1][i] + r->root[i] * r->normal[1][i];
        r->d[2][i] = eta * r->d[2][i] + r->root[i] * r->normal[2][i];
    }
}

/* From entrance points through all steps, or until all are lost. 0 if a surface is an asphere: then nothing is traced. */
static int lflare__lanes_trace(const lflare__tracer *o, const float *shares, const float *x, const float *y, lflare__lanes *r)
{
    const float *s = o->steps;
    float norm = 1 / sqrtf(1 + o->slope * o->slope);
    int32_t i, j, open = 1;
    memset(r, 0, sizeof *r);
    for (i = 0; i < LFLARE__LANES; i++) {
        r->p[0][i] = x[i];
        r->p[1][i] = y[i];
        r->d[0][i] = o->slope * norm;
        r->d[2][i] = norm;
        r->open[i] = 1;
    }
    for (j = 0; j < o->count && open; j++, s += LFLARE_STEP_FLOATS) {
        int32_t code = (int32_t)s[7];
        float way = code & LFLARE__STEP_BACK ? -1.0f : 1.0f, radius = code & LFLARE__STEP_STOP ? 1 / o->t->iris.radius : s[2];
        if (code & LFLARE__STEP_BENT) return 0;
        for (i = 0; i < LFLARE__LANES; i++) {
            r->p[2][i] -= s[0];
            r->open[i] &= r->d[2][i] * way > 0;
        }
        lflare__lanes_meet(s, way, r);
        if ((code & LFLARE__STEP_STOP) && !(code & LFLARE__STEP_REFLECTS)) {
            for (i = 0; i < LFLARE__LANES; i++) {
                r->stop[0][i] = r->p[0][i] * radius;
                r->stop[1][i] = r->p[1][i] * radius;
            }
        } else
            for (i = 0; i < LFLARE__LANES; i++) {
                float height = (r->p[0][i] * r->p[0][i] + r->p[1][i] * r->p[1][i]) * radius * radius;
                r->widest[i] = height > r->widest[i] ? height : r->widest[i];
            }
        if (!(code & LFLARE__STEP_STOP)) lflare__lanes_pass(s[4] * shares[0] + s[5] * shares[1] + s[6] * shares[2], code & LFLARE__STEP_REFLECTS, r);
        for (open = 0, i = 0; i < LFLARE__LANES; i++) {
            open |= r->open[i];
            r->steps[i] += r->open[i];
        }
    }
    return 1;
}

/* lflare__closed_floats of LFLARE__LANES rays at about the cost of two. */
static void lflare__closed_lanes(lflare__finder *f, int32_t k, const double *x, const double *y, double slope, double *closed)
{
    const lflare__tracer *o = f->tracer;
    float at[2][LFLARE__LANES];
    lflare__traced_ray ray;
    lflare__lanes r;
    int32_t i;
    for (i = 0; i < LFLARE__LANES; i++) {
        at[0][i] = (float)x[i];
        at[1][i] = (float)y[i];
    }
    f->tracer->slope = (float)slope;
    if (!lflare__lanes_trace(o, o->ends[k], at[0], at[1], &r)) {
        for (i = 0; i < LFLARE__LANES; i++) closed[i] = lflare__closed_floats(f, k, x[i], y[i], slope, &ray);
        return;
    }
    for (i = 0; i < LFLARE__LANES; i++) {
        float t = (o->sensor - r.p[2][i]) / r.d[2][i], sensor[2], stop, landing, relative;
        sensor[0] = r.p[0][i] + t * r.d[0][i];
        sensor[1] = r.p[1][i] + t * r.d[1][i];
        stop = (r.stop[0][i] * r.stop[0][i] + r.stop[1][i] * r.stop[1][i]) * o->t->iris.radius * o->t->iris.radius / (float)(f->iris * f->iris);
        landing = (sensor[0] * sensor[0] + sensor[1] * sensor[1]) / (float)(f->reach * f->reach);
        relative = lflare__maxf(lflare__maxf(stop, landing), r.widest[i]);
        closed[i] = r.open[i] && r.d[2][i] > 0 && lflare__finite((double)relative) ? lflare__min(sqrt((double)relative), 4) : 5 - (double)r.steps[i] / o->count;
    }
}

/* How closed the lens is to up to LFLARE__LANES rays of the meridional plane. */
static void lflare__lead_closed(lflare__finder *f, int32_t count, const double *x, double slope, double *closed)
{
    static const double y[LFLARE__LANES] = {0};
    double at[LFLARE__LANES];
    lflare_ray ray;
    int32_t i;
    if (f->tracer == NULL) {
        for (i = 0; i < count; i++) closed[i] = lflare__closed(f, f->lead, x[i], 0, slope, &ray, NULL);
        return;
    }
    for (i = 0; i < LFLARE__LANES; i++) at[i] = x[i < count ? i : 0];
    lflare__closed_lanes(f, f->lead, at, y, slope, closed);
}

/* The least closed ray of the meridional plane, to begin with of 2 `count` + 1: heights are nearly linear in x, so the greatest of
   them is nearly convex. Looks no further once `enough` is met. */
static double lflare__least_closed_of(lflare__finder *f, double slope, int32_t count, double enough, double *at)
{
    const lflare_surface *front = &f->lens->prescription.surfaces[0];
    double reach = front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter)) * slope, best = 9, step = reach / count, x[LFLARE__LANES], closed[LFLARE__LANES];
    int32_t i, j, some, sides = f->tracer != NULL ? LFLARE__LANES / 2 : 1, rounds = f->tracer != NULL ? 5 : 24; /* floats tell no more apart */
    for (i = -count; i <= count; i += some) {
        some = i + LFLARE__LANES <= count + 1 ? LFLARE__LANES : count + 1 - i;
        for (j = 0; j < some; j++) x[j] = (i + j) * step;
        lflare__lead_closed(f, some, x, slope, closed);
        for (j = 0; j < some; j++)
            if (closed[j] < best) best = closed[j], *at = x[j];
    }
    for (i = 0; i < rounds && best > enough && best < 5; i++) { /* walk to the lower side */
        double middle = *at;
        step *= sides > 1 ? 1.0 / sides : 0.6;
        for (j = 0; j < 2 * sides; j++) x[j] = middle + (j < sides ? j - sides : j - sides + 1) * step;
        lflare__lead_closed(f, 2 * sides, x, slope, closed);
        for (j = 0; j < 2 * sides; j++)
            if (closed[j] < best) best = closed[j], *at = x[j];
    }
    return best;
}

/* Bundles much narrower than the front element want a closer look. */
static double lflare__least_closed(lflare__finder *f, double slope, double enough, double *at)
{
    double best = lflare__least_closed_of(f, slope, 10, enough, at);
    return best > 1 ? lflare__least_closed_of(f, slope, 36, enough, at) : best;
}

/* The field angle from which on nothing passes; a ghost that comes again farther out is not followed. */
static double lflare__find_hidden(lflare__finder *f)
{
    double x, lo = 0, hi = 1.3;
    int32_t i;
    if (lflare__least_closed(f, 0, 1, &x) > 1) return 0;
    for (i = 1; i <= 13; i++) {
        hi = 0.1 * i;
        if (lflare__least_closed(f, tan(hi), 1, &x) > 1) break;
        lo = hi;
    }
    for (i = 0; i < 11 && lo < hi; i++) {
        double middle = 0.5 * (lo + hi);
        if (lflare__least_closed(f, tan(middle), 1, &x) <= 1) lo = middle;
        else hi = middle;
    }
    return lo; /* where rays still pass, up to total reflection perhaps */
}

#ifndef LFLARE_NO_ABERRATION
/* -- fitting the polynomials of room "aberration" to exact rays -- */

enum {
    LFLARE__FIT_RAYS = 20 * 10, /* of a knot, at most: Chebyshev places along x, and along y on one side of the mirror plane */
    LFLARE__FIT_ROWS = LFLARE__FIT_RAYS + LFLARE__EVEN /* of a least squares problem, those of the ridge counted */
};

/* How far beyond the rims rays are fitted: clipping by interpolated heights needs both sides of the edge. Those farther out, up to
   LFLARE__FIT_FAR, count next to nothing, but without them high orders would open what is shut in the corners of the box. */
#define LFLARE__FIT_MARGIN 1.06
#define LFLARE__FIT_FAR 1.3
#define LFLARE__FIT_FAR_SHARE 0.01

typedef struct lflare__fit_sample {
    double x, y, weight, closed;      /* x, y in the knot's smooth box */
    double place[LFLARE__PLACES][2];
} lflare__fit_sample;

/* A knot's rays and the box they fill. */
typedef struct lflare__fit_knot {
    double slope, middle, half[2];    /* the box where rays pass */
    double unit_middle, unit[2];      /* the box that stands for -1 to 1: much the same, but smooth from knot to knot */
    int32_t counts[LFLARE_WAVELENGTHS], near; /* near: within the margin, at the middle wavelength */
    lflare__fit_sample samples[LFLARE_WAVELENGTHS][LFLARE__FIT_RAYS];
    float heights[LFLARE__FIT_RAYS][LFLARE_MAX_STEPS][2]; /* on every step's rim, at the middle wavelength */
} lflare__fit_knot;

/* All that fitting needs: 14 MB, less for what is not touched. */
typedef struct lflare__fitter {
    lflare__finder find;
    double pixel;                     /* mm */
    lflare_hit hits[LFLARE_MAX_STEPS];
    lflare__fit_knot knots[LFLARE__KNOTS];
    float film[LFLARE_MAX_SURFACES * LFLARE_FILM_SAMPLES * 4];
    lflare_layer layers[LFLARE_MAX_LAYERS];
    int32_t cuts[LFLARE_MAX_STEPS];   /* rays that a step's rim alone stops */
    double matrix[(int)LFLARE__FIT_ROWS * LFLARE__EVEN], right[(int)LFLARE__FIT_ROWS * (LFLARE__PLACES + 1)], solution[(LFLARE__PLACES + 1) * LFLARE__EVEN];
    lflare__bundle bundles[LFLARE__KNOTS];
} lflare__fitter;

/* From a ray that passes, along (dx, dy), to the fit's margin: how far. */
static double lflare__fit_extent(lflare__fitter *f, double x, double y, double dx, double dy, double far, double slope)
{
    double near = 0;
    lflare_ray ray;
    int32_t i;
    for (i = 0; i < 8; i++) {
        double middle = 0.5 * (near + far);
        if (lflare__closed(&f->find, 1, x + middle * dx, y + middle * dy, slope, &ray, NULL) < LFLARE__FIT_MARGIN) near = middle;
        else far = middle;
    }
    return far;
}

/* The box of rays to fit. */
static int lflare__fit_box(lflare__fitter *f, lflare__fit_knot *k)
{
    const lflare_surface *front = &f->find.lens->prescription.surfaces[0];
    double reach = 1.1 * (front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter)) * k->slope), x, lo, hi;
    int32_t i;
    if (lflare__least_closed(&f->find, k->slope, 0.9, &x) > 1.03) return 0;
    lo = x - lflare__fit_extent(f, x, 0, -1, 0, reach + x, k->slope);
    hi = x + lflare__fit_extent(f, x, 0, 1, 0, reach - x, k->slope);
    k->middle = 0.5 * (lo + hi);
    k->half[0] = lflare__max(0.5 * (hi - lo), 1e-6 * reach);
    k->half[1] = 1e-6 * reach;
    for (i = -1; i <= 1; i++) k->half[1] = lflare__max(k->half[1], lflare__fit_extent(f, k->middle + 0.5 * i * k->half[0], 0, 0, 1, reach, k->slope));
    k->half[1] *= 1.03;
    return 1;
}

/* Boxes bend where one rim takes over from another; interpolated polynomials should not. */
static void lflare__fit_smooth_boxes(lflare__fitter *f)
{
    double v[3][LFLARE__KNOTS], more[2] = {1, 1};
    int32_t pass, i, k;
    for (i = 0; i < LFLARE__KNOTS; i++) {
        v[0][i] = f->knots[i].middle;
        v[1][i] = f->knots[i].half[0];
        v[2][i] = f->knots[i].half[1];
    }
    for (k = 0; k < 3; k++)
        for (pass = 0; pass < 4; pass++) {
            double before = 2 * v[k][0] - v[k][1];
            for (i = 0; i < LFLARE__KNOTS; i++) {
                double here = v[k][i], next = i + 1 < LFLARE__KNOTS ? v[k][i + 1] : here;
                if (i > 0 && i + 1 < LFLARE__KNOTS) v[k][i] = 0.25 * (before + 2 * here + next);
                before = here;
            }
        }
    for (i = 0; i < LFLARE__KNOTS; i++) { /* enlarged alike so that all hold what they stand for */
        more[0] = lflare__max(more[0], (f->knots[i].half[0] + fabs(f->knots[i].middle - v[0][i])) / v[1][i]);
        more[1] = lflare__max(more[1], f->knots[i].half[1] / v[2][i]);
    }
    for (i = 0; i < LFLARE__KNOTS; i++) {
        f->knots[i].unit_middle = v[0][i];
        f->knots[i].unit[0] = v[1][i] * lflare__min(more[0], 2);
        f->knots[i].unit[1] = v[2][i] * lflare__min(more[1], 2);
    }
}

static double lflare__hits_weight(const lflare__fitter *f, int32_t k, const lflare_path *path)
{
    double w = 1;
    int32_t i;
    for (i = 0; i < path->step_count; i++) {
        const lflare_step *s = &path->steps[i];
        double cosine = f->hits[i].cosine, r;
        if (s->surface == f->find.lens->stop || (s->layer_count == 0 && s->n_in == s->n_out)) continue;
        if (s->n_in > s->n_out) { /* films are listed over the cosine in the rarer medium */
            double ratio = s->n_in / s->n_out;
            cosine = sqrt(lflare__max(1 - ratio * ratio * (1 - cosine * cosine), 0));
        }
        r = (double)lflare__film_lookup(f->film + (size_t)s->surface * LFLARE_FILM_SAMPLES * 4, k, (float)cosine);
        w *= s->reflected ? r : 1 - r;
    }
    return w;
}

/* Counts a ray that one rim alone stops, by not much; the iris, open in full, is one where blades do not shape it. */
static void lflare__fit_count_cut(lflare__fitter *f, const lflare_path *path, const lflare_ray *ray)
{
    const double *stop = ray->stop;
    double semi = f->find.iris;
    int32_t i, worst = -1;
    if (stop[0] * stop[0] + stop[1] * stop[1] > semi * semi) return;
    for (i = 0; i < path->step_count; i++)
        if (!path->steps[i].iris && (worst < 0 || f->hits[i].relative > f->hits[worst].relative)) worst = i;
    if (f->hits[worst].relative > 1) f->cuts[worst]++;
}

/* Rays of a knot at one wavelength, across x up places. The middle wavelength comes first and finds out which rims clip: its rays'
   heights on all of them are kept. The others take those of the steps given. */
static void lflare__fit_shoot(lflare__fitter *f, lflare__fit_knot *knot, int32_t k, int32_t across, int32_t up, int32_t rims, const int32_t *steps)
{
    int32_t i, j, p, n = 0;
    if (k == 1) knot->near = 0;
    for (j = 0; j < up; j++)
        for (i = 0; i < across; i++) {
            lflare__fit_sample *s = &knot->samples[k][n];
            lflare_ray ray;
            double x = knot->middle + 1.05 * knot->half[0] * cos(LFLARE__PI * (i + 0.5) / across), y = 1.05 * knot->half[1] * sin(0.5 * LFLARE__PI * (j + 0.5) / up);
            s->closed = lflare__closed(&f->find, k, x, y, knot->slope, &ray, f->hits);
            if (s->closed > LFLARE__FIT_FAR) continue;
            s->x = (x - knot->unit_middle) / knot->unit[0];
            s->y = y / knot->unit[1];
            for (p = 0; p < 2; p++) {
                s->place[0][p] = ray.sensor[p];
                s->place[1][p] = ray.stop[p];
            }
            for (p = 0; p < 2 * rims; p++) s->place[2 + p / 2][p % 2] = f->hits[steps[p / 2]].position[p % 2] / f->find.paths[k].steps[steps[p / 2]].semi;
            s->weight = lflare__hits_weight(f, k, &f->find.paths[k]);
            if (k == 1) {
                knot->near += s->closed <= LFLARE__FIT_MARGIN;
                if (s->closed <= LFLARE__FIT_MARGIN) lflare__fit_count_cut(f, &f->find.paths[k], &ray);
                for (p = 0; p < 2 * f->find.paths[k].step_count; p++) knot->heights[n][p / 2][p % 2] = (float)(f->hits[p / 2].position[p % 2] / f->find.paths[k].steps[p / 2].semi);
            }
            n++;
        }
    knot->counts[k] = n;
}

/* Gives the middle wavelength's rays their heights on the rims that clip. */
static void lflare__fit_take_rims(lflare__fit_knot *knot, int32_t rims, const int32_t *steps)
{
    int32_t i, p;
    for (i = 0; i < knot->counts[1]; i++)
        for (p = 0; p < 2 * rims; p++) knot->samples[1][i].place[2 + p / 2][p % 2] = (double)knot->heights[i][steps[p / 2]][p % 2];
}

/* Least squares by Householder's reflections: `n` columns of `rows` in f->matrix, `sides` right sides; columns are brought to one
   length first and a ridge of 1e-6 of it keeps what the rays do not determine small. */
static void lflare__least_squares(lflare__fitter *f, int32_t rows, int32_t n, int32_t sides)
{
    double length[LFLARE__EVEN], *a = f->matrix, *b = f->right;
    int32_t all = rows + n, i, j, c;
    for (c = 0; c < n; c++) {
        double sum = 0;
        for (i = 0; i < rows; i++) sum += a[c * LFLARE__FIT_ROWS + i] * a[c * LFLARE__FIT_ROWS + i];
        length[c] = sum > 0 ? sqrt(sum) : 1;
        for (i = 0; i < rows; i++) a[c * LFLARE__FIT_ROWS + i] /= length[c];
        for (i = rows; i < all; i++) a[c * LFLARE__FIT_ROWS + i] = i - rows == c ? 1e-6 : 0;
    }
    for (c = 0; c < sides; c++)
        for (i = rows; i < all; i++) b[c * LFLARE__FIT_ROWS + i] = 0;
    for (c = 0; c < n; c++) {
        double *v = a + c * LFLARE__FIT_ROWS, norm = 0, diagonal, scale;
        for (i = c; i < all; i++) norm += v[i] * v[i];
        diagonal = v[c] > 0 ? -sqrt(norm) : sqrt(norm);
        v[c] -= diagonal;
        scale = norm > 0 ? -1 / (diagonal * v[c]) : 0; /* 2 over v's own length squared */
        for (j = c + 1; j < n + sides; j++) {
            double *w = j < n ? a + j * LFLARE__FIT_ROWS : b + (j - n) * LFLARE__FIT_ROWS, dot = 0;
            for (i = c; i < all; i++) dot += v[i] * w[i];
            dot *= scale;
            for (i = c; i < all; i++) w[i] -= dot * v[i];
        }
        v[c] = diagonal;
    }
    for (j = 0; j < sides; j++)
        for (c = n - 1; c >= 0; c--) {
            double sum = b[j * LFLARE__FIT_ROWS + c];
            for (i = c + 1; i < n; i++) sum -= a[i * LFLARE__FIT_ROWS + c] * f->solution[j * LFLARE__EVEN + i] * length[i];
            f->solution[j * LFLARE__EVEN + c] = sum / (a[c * LFLARE__FIT_ROWS + c] * length[c]);
        }
}

static double lflare__fit_root(double w, int32_t squarings)
{
    while (squarings-- > 0) w = sqrt(w);
    return w;
}

/* Solves for the even or odd part of all places (and the weight) at one wavelength, of what `b` does not already hold. */
static void lflare__fit_solve(lflare__fitter *f, const lflare__fit_knot *knot, int32_t k, int32_t order, int32_t places, int odd, lflare__bundle *b)
{
    int32_t n = lflare__terms(odd ? order - 1 : order), sides = places + !odd, rows = knot->counts[k], i, p;
    for (i = 0; i < rows; i++) {
        const lflare__fit_sample *s = &knot->samples[k][i];
        double counts = s->closed <= LFLARE__FIT_MARGIN ? 1 : LFLARE__FIT_FAR_SHARE;
        lflare__terms_at t;
        lflare__terms_make(b->order, (float)s->x, (float)s->y, 0, &t);
        for (p = 0; p < n; p++) f->matrix[p * LFLARE__FIT_ROWS + i] = counts * (double)t.value[p] * (odd ? s->y : 1);
        for (p = 0; p < sides; p++) {
            double value = p == places ? lflare__fit_root(s->weight, b->squarings) : s->place[p][odd];
            if (k != 1) /* the difference from the middle wavelength */
                value -= odd ? s->y * (double)lflare__sum_odd(b, 1, p, t.value) : (double)lflare__sum_even(b, 1, p == places ? LFLARE__PLACES : p, t.value);
            f->right[p * LFLARE__FIT_ROWS + i] = counts * value;
        }
    }
    lflare__least_squares(f, rows, n, sides);
    for (p = 0; p < sides; p++)
        for (i = 0; i < n; i++) *(odd ? &b->odd[k][i][p] : &b->even[k][i][p == places ? LFLARE__PLACES : p]) = (float)f->solution[p * LFLARE__EVEN + i];
}

/* Polynomials of a knot; the other wavelengths' as differences. Returns the greatest error on the sensor of rays that pass, mm. */
static double lflare__fit_polynomials(lflare__fitter *f, const lflare__fit_knot *knot, int32_t order, int32_t rims, int32_t squarings, lflare__bundle *b)
{
    static const int32_t sequence[LFLARE_WAVELENGTHS] = {1, 0, 2};
    double worst = 0;
    int32_t i, k;
    memset(b, 0, sizeof *b);
    b->order = order;
    b->rims = rims;
    b->squarings = squarings;
    b->middle = (float)knot->unit_middle;
    b->half[0] = (float)knot->unit[0];
    b->half[1] = (float)knot->unit[1];
    b->open_middle = (float)knot->middle;
    b->open_half[0] = (float)knot->half[0];
    b->open_half[1] = (float)knot->half[1];
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        int32_t w = sequence[k], n = k == 0 ? order : lflare__difference_order(order);
        lflare__fit_solve(f, knot, w, n, 2 + rims, 0, b);
        lflare__fit_solve(f, knot, w, n, 2 + rims, 1, b);
    }
    for (i = 0; i < knot->counts[1]; i++) {
        const lflare__fit_sample *s = &knot->samples[1][i];
        lflare__terms_at t;
        float place[2];
        if (s->closed > LFLARE__FIT_MARGIN) continue;
        lflare__terms_make(order, (float)s->x, (float)s->y, 0, &t);
        lflare__place_at(b, 1, 0, &t, place);
        worst = lflare__max(worst, fabs((double)place[0] - s->place[0][0]) + fabs((double)place[1] - s->place[0][1]));
    }
    return worst;
}

/* Weights may span many powers of ten (near total reflection, best fitted as roots) or touch zero (films, best as they are): which
   serves better, at the order given. */
static int32_t lflare__fit_squarings(lflare__fitter *f, int32_t order)
{
    double least = 1e300;
    int32_t squarings, best = 0, i, j;
    for (squarings = 0; squarings <= 3; squarings++) {
        double error = 0;
        for (j = 0; j < LFLARE__KNOTS; j += 2) {
            const lflare__fit_knot *knot = &f->knots[j];
            lflare__bundle *b = &f->bundles[j];
            double most = 1e-30;
            memset(b, 0, sizeof *b);
            b->order = order;
            b->squarings = squarings;
            lflare__fit_solve(f, knot, 1, order, 0, 0, b);
            for (i = 0; i < knot->counts[1]; i++)
                if (knot->samples[1][i].closed <= LFLARE__FIT_MARGIN) most = lflare__max(most, knot->samples[1][i].weight);
            for (i = 0; i < knot->counts[1]; i++) {
                const lflare__fit_sample *s = &knot->samples[1][i];
                lflare__terms_at t;
                if (s->closed > LFLARE__FIT_MARGIN) continue;
                lflare__terms_make(order, (float)s->x, (float)s->y, 0, &t);
                error += fabs((double)lflare__weight_at(b, 1, &t) - s->weight) / (s->weight + 0.02 * most);
            }
        }
        if (error < least) {
            least = error;
            best = squarings;
        }
    }
    return best;
}

/* Steps whose rims clip anywhere, those that clip most rays first; before them the iris where blades do not shape it, which may clip once it
   closes. */
static int32_t lflare__fit_rims(lflare__fitter *f, const lflare_path *path, int32_t *steps)
{
    int32_t rims = 0, i, total = 0, step_count = path->step_count;
    for (i = 0; i < LFLARE__KNOTS; i++) total += f->knots[i].near;
    for (i = 0; i < step_count; i++)
        if (path->steps[i].surface == f->find.lens->stop && !path->steps[i].iris) f->cuts[i] = INT32_MAX / 1000;
    while (rims < LFLARE_FIT_RIMS) {
        int32_t most = 0;
        for (i = 1; i < step_count; i++)
            if (f->cuts[i] > f->cuts[most]) most = i;
        if (f->cuts[most] * 1000 <= total) break;
        f->cuts[most] = 0;
        steps[rims++] = most;
    }
    return rims;
}

/* Whether rays of other wavelengths that land at one place come in far from each other: over 0.2 of the box. */
static int lflare__fit_apart(const lflare__bundle *b, const lflare__terms_at *t, const float *slopes)
{
    float det = slopes[0] * slopes[3] - slopes[1] * slopes[2];
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k += 2) {
        float d[2];
        lflare__place_at(b, k, 0, t, d); /* the difference from the middle wavelength */
        if (fabsf(d[0] * slopes[3] - d[1] * slopes[1]) > 0.2f * fabsf(det) || fabsf(d[1] * slopes[0] - d[0] * slopes[2]) > 0.2f * fabsf(det)) return 1;
    }
    return 0;
}

/* How bent the map is, over rays that pass: distance on the sensor, in pixels of a picture 1280 wide (twice the root mean square),
   between a place and where linear interpolation on the coarsest mesh puts it. Counts rays about which the map turns over, or nearly
   does, and those whose colours are apart. */
static double lflare__fit_bend(const lflare__fitter *f, const lflare__fit_knot *knot, const lflare__bundle *b, int32_t *turned, int32_t *apart)
{
    double sum = 0, mean = 0, step = 0.5 / 4; /* half a ring */
    float shrink[LFLARE__FIT_RAYS];
    int32_t i, j, over = 0, count = 0;
    for (i = 0; i < knot->counts[1]; i++) {
        const lflare__fit_sample *s = &knot->samples[1][i];
        float p[3][2], slopes[4];
        lflare__terms_at t;
        if (s->closed > 1) continue;
        for (j = 0; j < 2; j++) { /* along x, along y */
            int32_t e;
            for (e = 0; e < 3; e++) {
                double shift = step * (e - 1);
                lflare__terms_make(b->order, (float)(s->x + (j == 0 ? shift : 0)), (float)(s->y + (j == 1 ? shift : 0)), 1, &t);
                lflare__place_at(b, 1, 0, &t, p[e]);
                if (e == 1 && j == 0) {
                    lflare__place_slopes(b, 1, 0, &t, slopes);
                    shrink[count] = slopes[0] * slopes[3] - slopes[1] * slopes[2];
                    mean += (double)shrink[count++];
                    *apart += lflare__fit_apart(b, &t, slopes);
                }
            }
            for (e = 0; e < 2; e++) sum += 0.25 * (double)((p[0][e] - 2 * p[1][e] + p[2][e]) * (p[0][e] - 2 * p[1][e] + p[2][e]));
        }
    }
    for (i = 0; i < count; i++) over += (double)shrink[i] * mean < 0.1 * mean * mean / count;
    *turned += over;
    return count > 0 ? 2 * sqrt(sum / count) / f->pixel : 0;
}

static uint8_t *lflare__store_bytes(uint8_t *p, uint32_t v, int32_t count)
{
    int32_t i;
    for (i = 0; i < count; i++) *p++ = (uint8_t)(v >> (8 * i));
    return p;
}

static uint8_t *lflare__store_float(uint8_t *p, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return lflare__store_bytes(p, bits, 4);
}

/* Terms are a row of fields apart. */
static uint8_t *lflare__store_field(uint8_t *p, const float *even, int32_t even_terms, const float *odd, int32_t odd_terms)
{
    float most = 1e-30f;
    int32_t i;
    for (i = 1; i < even_terms; i++) most = lflare__maxf(most, fabsf(even[i * LFLARE__EVEN_FIELDS]));
    for (i = 0; i < odd_terms; i++) most = lflare__maxf(most, fabsf(odd[i * LFLARE__PLACES]));
    p = lflare__store_float(p, even[0]);
    p = lflare__store_float(p, most / 32767);
    for (i = 1; i < even_terms; i++) p = lflare__store_bytes(p, (uint32_t)(int32_t)floorf(even[i * LFLARE__EVEN_FIELDS] / most * 32767 + 0.5f), 2);
    for (i = 0; i < odd_terms; i++) p = lflare__store_bytes(p, (uint32_t)(int32_t)floorf(odd[i * LFLARE__PLACES] / most * 32767 + 0.5f), 2);
    return p;
}

static uint8_t *lflare__store_knot(uint8_t *p, const lflare__bundle *b)
{
    static const int32_t sequence[LFLARE_WAVELENGTHS] = {1, 0, 2};
    int32_t k, place;
    p = lflare__store_float(p, b->middle);
    p = lflare__store_float(p, b->half[0]);
    p = lflare__store_float(p, b->half[1]);
    p = lflare__store_float(p, b->open_middle);
    p = lflare__store_float(p, b->open_half[0]);
    p = lflare__store_float(p, b->open_half[1]);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        int32_t w = sequence[k], n = k == 0 ? b->order : lflare__difference_order(b->order);
        for (place = 0; place < 2 + b->rims; place++)
            p = lflare__store_field(p, &b->even[w][0][place], lflare__terms(n), &b->odd[w][0][place], lflare__terms(n - 1));
        p = lflare__store_field(p, &b->even[w][0][LFLARE__PLACES], lflare__terms(n), NULL, 0);
    }
    return p;
}

/* Boxes of all knots, and the first rays within. Returns at how many knots there are such rays, up to the first where there are none. */
static int32_t lflare__fit_begin(lflare__fitter *f, double hidden)
{
    int32_t j;
    memset(f->cuts, 0, sizeof f->cuts);
    for (j = 0; j < LFLARE__KNOTS; j++) {
        lflare__fit_knot *knot = &f->knots[j];
        knot->slope = tan((double)lflare__knot_angle(j, (float)hidden, LFLARE__KNOTS) * (j == LFLARE__KNOTS - 1 ? 0.99999 : 1));
        if (!lflare__fit_box(f, knot)) return j;
    }
    lflare__fit_smooth_boxes(f);
    for (j = 0; j < LFLARE__KNOTS; j++) {
        lflare__fit_shoot(f, &f->knots[j], 1, 12, 7, 0, NULL);
        if (f->knots[j].near < 4) return j;
    }
    return LFLARE__KNOTS;
}

/* Whether meshes at LFLARE__KNOTS field angles would be off between them: vertices of the boxes of rays, interpolated, against the
   polynomials there, which are smoother. */
static int lflare__fit_dense(const lflare__fitter *f, const uint8_t *row, const uint8_t *knots)
{
    static const float places[5][2] = {{0, 0}, {0.8f, 0}, {-0.8f, 0}, {0.3f, 0.8f}, {-0.3f, 0.8f}};
    float at[LFLARE__KNOTS][5][4], share[4];
    lflare__fit_ghost ghost;
    lflare__bundle b;
    lflare__terms_at t;
    int32_t j, i, k, c;
    lflare__fit_ghost_read(row - LFLARE__FIT_HEAD, 0, &ghost);
    ghost.knots = knots;
    for (j = 0; j < LFLARE__KNOTS; j++)
        for (i = 0; i < 5; i++) { /* entrance, sensor */
            const lflare__fit_knot *knot = &f->knots[j];
            at[j][i][0] = (float)knot->middle + (float)knot->half[0] * places[i][0];
            at[j][i][1] = (float)knot->half[1] * places[i][1];
            lflare__terms_make(ghost.order, (at[j][i][0] - f->bundles[j].middle) / f->bundles[j].half[0], at[j][i][1] / f->bundles[j].half[1], 0, &t);
            lflare__place_at(&f->bundles[j], 1, 0, &t, at[j][i] + 2);
        }
    for (j = 0; j + 1 < LFLARE__KNOTS; j++) {
        int32_t first = lflare__cubic_shares((float)j + 0.5f, LFLARE__KNOTS, share);
        float rest = 1 - ((float)j + 0.5f) / (LFLARE__KNOTS - 1);
        lflare__bundle_at(&ghost, ghost.hidden_angle * (1 - rest * rest), &b);
        for (i = 0; i < 5; i++) {
            float v[4] = {0, 0, 0, 0}, sensor[2];
            for (k = 0; k < 4; k++)
                for (c = 0; c < 4; c++) v[c] += share[k] * at[first + k][i][c];
            lflare__terms_make(b.order, (v[0] - b.middle) / b.half[0], v[1] / b.half[1], 0, &t);
            lflare__place_at(&b, 1, 0, &t, sensor);
            if (sqrtf(sensor[0] * sensor[0] + sensor[1] * sensor[1]) > (float)f->find.reach) continue;
            if (fabsf(v[2] - sensor[0]) + fabsf(v[3] - sensor[1]) > 2.0f * (float)f->pixel) return 1;
        }
    }
    return 0;
}

/* Fits one ghost; writes its row, and its knots to `out`. Returns the bytes of the knots, 0 if no light comes this way. */
static size_t lflare__fit_one(lflare__fitter *f, const lflare_lens *lens, lflare_pair pair, uint8_t *row, uint8_t *out)
{
    static const int32_t orders[4] = {3, 5, 7, 9};
    double hidden, worst = 0, bend = 0;
    int32_t k, j, rims, steps[LFLARE_FIT_RIMS] = {0, 0, 0}, order = 0, turned = 0, apart = 0, folded, level, tries, squarings;
    uint8_t *p = out;
    memset(row, 0, LFLARE__FIT_ROW);
    lflare__finder_make(&f->find, lens, pair, lens->prescription.surfaces[lens->stop].semi_diameter);
    hidden = lflare__find_hidden(&f->find);
    for (tries = 0; hidden > 0; tries++) {
        j = lflare__fit_begin(f, hidden);
        if (j == LFLARE__KNOTS) break;
        hidden = j > 0 && tries < 10 ? 0.5 * (double)(lflare__knot_angle(j - 1, (float)hidden, LFLARE__KNOTS) + lflare__knot_angle(j, (float)hidden, LFLARE__KNOTS)) : 0;
    }
    if (!(hidden > 0)) return 0;
    rims = lflare__fit_rims(f, &f->find.paths[1], steps);
    for (j = 0; j < LFLARE__KNOTS; j++) {
        lflare__fit_take_rims(&f->knots[j], rims, steps);
        for (k = 0; k < LFLARE_WAVELENGTHS; k += 2) lflare__fit_shoot(f, &f->knots[j], k, 8, 4, rims, steps);
    }
    squarings = lflare__fit_squarings(f, 5);
    for (tries = 0; tries < 4 && (tries == 0 || worst > 0.4 * f->pixel); tries++) {
        order = orders[tries];
        worst = 0;
        for (j = 0; j < LFLARE__KNOTS && tries == 2; j++) { /* more terms need more rays */
            lflare__fit_shoot(f, &f->knots[j], 1, 20, 10, 0, NULL);
            lflare__fit_take_rims(&f->knots[j], rims, steps);
            for (k = 0; k < LFLARE_WAVELENGTHS; k += 2) lflare__fit_shoot(f, &f->knots[j], k, 12, 6, rims, steps);
        }
        for (j = 0; j < LFLARE__KNOTS; j++) worst = lflare__max(worst, lflare__fit_polynomials(f, &f->knots[j], order, rims, squarings, &f->bundles[j]));
    }
    for (j = 0; j < LFLARE__KNOTS; j++) {
        bend = lflare__max(bend, lflare__fit_bend(f, &f->knots[j], &f->bundles[j], &turned, &apart));
        p = lflare__store_knot(p, &f->bundles[j]);
    }
    folded = turned > 0 || apart > 0;
    for (level = 0; level < LFLARE__MAX_LEVEL && bend > (folded ? 1 : 4); level++) bend /= 4;
    lflare__store_float(row + 4, (float)hidden);
    row[8] = (uint8_t)order;
    row[9] = (uint8_t)rims;
    row[10] = (uint8_t)level;
    row[11] = (uint8_t)(folded | squarings << 1);
    row[11] = (uint8_t)(row[11] | lflare__fit_dense(f, row, out) << 3);
    for (k = 0; k < LFLARE_FIT_RIMS; k++) lflare__store_bytes(row + 12 + 2 * k, (uint32_t)steps[k], 2);
    lflare__store_float(row + 24, (float)worst);
    return (size_t)(p - out);
}

static void lflare__fit_finish(const lflare_lens *lens, uint8_t *fit, size_t size)
{
    uint64_t hash = lflare__lens_hash(lens);
    memcpy(fit, lflare__fit_magic, 6);
    lflare__store_bytes(fit + 6, LFLARE__FIT_VERSION, 2);
    lflare__store_bytes(fit + 8, lflare__fit_ghosts(lens), 4);
    lflare__store_bytes(fit + 12, (uint32_t)size, 4);
    lflare__store_bytes(fit + 16, (uint32_t)hash, 4);
    lflare__store_bytes(fit + 20, (uint32_t)(hash >> 32), 4);
    hash = lflare__hash_bytes(fit + LFLARE__FIT_HEAD, size - LFLARE__FIT_HEAD);
    lflare__store_bytes(fit + 24, (uint32_t)hash, 4);
    lflare__store_bytes(fit + 28, (uint32_t)(hash >> 32), 4);
}

LFLARE_API lflare_result lflare_aberration_fit(const lflare_lens *lens, const lflare_aberration_desc *desc, void **fit, size_t *size, lflare_error *error)
{
    static const lflare_aberration_desc plain = {NULL, NULL, NULL};
    lflare_realloc allocate;
    lflare__fitter *f = NULL;
    uint8_t *block = NULL;
    size_t room, used, most = LFLARE__KNOTS * lflare__knot_bytes(LFLARE__MAX_ORDER, LFLARE_FIT_RIMS);
    lflare_result result = LFLARE_OK;
    lflare_pair *pairs = NULL;
    int32_t count, g;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (lens == NULL || fit == NULL || size == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no lens, or nowhere to put the fit");
    *fit = NULL;
    *size = 0;
    if (desc == NULL) desc = &plain;
    allocate = desc->allocate != NULL ? desc->allocate : lflare__libc_realloc;
    count = lens->ghost_count;
    used = room = LFLARE__FIT_HEAD + (size_t)count * LFLARE__FIT_ROW;
    block = (uint8_t *)allocate(desc->user, NULL, 0, room);
    f = (lflare__fitter *)allocate(desc->user, NULL, 0, sizeof *f);
    pairs = (lflare_pair *)allocate(desc->user, NULL, 0, sizeof(lflare_pair) * ((size_t)count + 1));
    if (block == NULL || f == NULL || pairs == NULL) result = lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
    if (result == LFLARE_OK) {
        lflare_ghost_list(lens, pairs, &count);
        f->pixel = lens->sensor_width / 1280;
        for (g = 0; g < lens->surface_count; g++) lflare__film_row(lens, g, f->layers, f->film + (size_t)g * LFLARE_FILM_SAMPLES * 4);
    }
    for (g = 0; g < count && result == LFLARE_OK; g++) {
        size_t bytes;
        if (room - used < most) {
            size_t grown = room + room / 2 + most;
            uint8_t *larger = (uint8_t *)allocate(desc->user, block, room, grown);
            if (larger == NULL) { result = lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory"); break; }
            block = larger;
            room = grown;
        }
        bytes = lflare__fit_one(f, lens, pairs[g], block + LFLARE__FIT_HEAD + (size_t)g * LFLARE__FIT_ROW, block + used);
        if (bytes > 0) lflare__store_bytes(block + LFLARE__FIT_HEAD + (size_t)g * LFLARE__FIT_ROW, (uint32_t)used, 4);
        used += bytes;
        if (desc->progress != NULL && desc->progress(desc->user, g + 1, count)) result = lflare__fail(error, LFLARE_INCOMPLETE, 0, 0, "stopped");
    }
    if (result == LFLARE_OK) {
        uint8_t *exact = (uint8_t *)allocate(desc->user, block, room, used);
        if (exact == NULL) {
            result = lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
        } else {
            block = exact;
            room = used;
            lflare__fit_finish(lens, block, used);
            *fit = block;
            *size = used;
        }
    }
    if (f != NULL) allocate(desc->user, f, sizeof *f, 0);
    if (pairs != NULL) allocate(desc->user, pairs, sizeof(lflare_pair) * ((size_t)lens->ghost_count + 1), 0);
    if (result != LFLARE_OK && block != NULL) allocate(desc->user, block, room, 0);
    return result;
}

#endif /* LFLARE_NO_ABERRATION */

#endif /* LFLARE_NO_TRACE */

/* >> 12 tables */

static void *lflare__carve(char **at, size_t bytes)
{
    void *here = *at;
    *at += (bytes + 15) & ~(size_t)15;
    return here;
}

enum { LFLARE__MESH_ROW = 2048 }; /* texels of a line of the meshes' texture: whole lines are allocated */


#ifndef LFLARE_NO_ABERRATION
/* -- meshes: the polynomials of room "aberration", sampled for the iris in force -- */

/* A mesh's density; directions are those of half a turn, the mirror plane at both ends. */
static int32_t lflare__mesh_rings(int32_t level) { return 4 << level; }
static int32_t lflare__mesh_directions(int32_t level) { return level < 2 ? 16 : 32; }

/* All patches of a ghost. */
static int32_t lflare__mesh_patches(const lflare__fit_ghost *g)
{
    return (g->folded ? LFLARE_WAVELENGTHS : 1) * (lflare__mesh_rings(g->level) / 4) * (lflare__mesh_directions(g->level) / 4);
}

static int32_t lflare__mesh_floats(int split) { return split ? LFLARE__MESH_SPLIT : LFLARE__MESH_FUSED; }
static int32_t lflare__mesh_knots(int dense) { return dense ? LFLARE__MORE_KNOTS : LFLARE__KNOTS; }

/* Texels of one mesh, all knots. */
static size_t lflare__mesh_size(const lflare__fit_ghost *g)
{
    size_t vertices = (size_t)(lflare__mesh_rings(g->level) + 1) * (size_t)(lflare__mesh_directions(g->level) + 1);
    return (size_t)lflare__mesh_knots(g->dense) * (LFLARE__MESH_KNOT_TEXELS + vertices * (size_t)lflare__mesh_floats(g->folded) / 4);
}

/* What shapes a ghost's mesh at one field angle. */
typedef struct lflare__mesher {
    lflare__bundle bundle;
    float iris, inscribed;    /* radius of the iris, mm; of the largest disc within its blades, as a share of that */
    float reach;              /* of the disc on the sensor where rays still matter, mm */
    float lamps[1 + LFLARE_FIT_RIMS]; /* blur of iris and rims, mm on the sensor per radian of the lamp's size */
    int32_t lead, begin, end; /* channel whose entrance points the mesh is laid over; channels drawn */
    const float *ends[LFLARE_WAVELENGTHS]; /* see lflare__ends_of */
    int32_t ragged, spectral; /* what is open is not seen all over from its centre, or is in pieces; there are more than three wavelengths */
    float middle, half[2], bend; /* centre and unit of the mesh's polar coordinates, in the bundle's box; x also goes with bend y^2 */
} lflare__mesher;

typedef struct lflare__mesh_point {
    float sensor[2], entrance[2], closed[LFLARE_WAVELENGTHS];
    float weight[LFLARE_WAVELENGTHS]; /* irradiance there is that over |shrink| */
    float shrink;             /* the leading channel's sensor area per entrance area, signed */
    float iris[LFLARE_WAVELENGTHS][2], rim[LFLARE_WAVELENGTHS]; /* in units of their radii; of the rim that clips first */
    float lamp;                                                 /* blur of that rim for the channel last looked at */
} lflare__mesh_point;

/* How closed a channel is to a point of the box, all its fields given: passes up to 1. The end of what matters and of what was
   fitted counts, but only meshes whose outline does not stop there need it as a rim: it has no soft edge. */
static float lflare__mesh_closed(const lflare__mesher *m, int32_t k, float x, float y, const float *fx, const float *fy, lflare__mesh_point *out)
{
    const lflare__bundle *b = &m->bundle;
    float across = fabsf(b->middle + b->half[0] * x - b->open_middle) / lflare__maxf(b->open_half[0], 1e-6f), up = fabsf(b->half[1] * y) / lflare__maxf(b->open_half[1], 1e-6f);
    float c, end = lflare__maxf(across, up), rim;
    int32_t i;
    end = lflare__maxf((fx[0] * fx[0] + fy[0] * fy[0]) / (m->reach * m->reach), end * end);
    rim = m->ragged ? end : 0;
    out->lamp = 0;
    for (i = 0; i < m->bundle.rims; i++) {
        c = fx[2 + i] * fx[2 + i] + fy[2 + i] * fy[2 + i];
        if (c <= rim) continue;
        rim = c;
        out->lamp = m->lamps[1 + i];
    }
    out->iris[k][0] = fx[1] / m->iris;
    out->iris[k][1] = fy[1] / m->iris;
    out->rim[k] = sqrtf(rim);
    return sqrtf(lflare__maxf(lflare__maxf(rim, end), out->iris[k][0] * out->iris[k][0] + out->iris[k][1] * out->iris[k][1]));
}

/* One channel alone, in the mesh's coordinates: above 0 it is open. */
static float lflare__mesh_open(const lflare__mesher *m, int32_t k, float x, float y)
{
    float fx[LFLARE__EVEN_FIELDS], fy[LFLARE__PLACES];
    lflare__mesh_point p;
    lflare__terms_at t;
    x += m->bend * y * y;
    lflare__terms_make(m->bundle.order, x, y, 0, &t);
    lflare__fields_at(&m->bundle, k, &t, fx, fy);
    return 1 - lflare__mesh_closed(m, k, x, y, fx, fy, &p);
}

/* Moves a point of the box towards where channel k's ray lands on `sensor`: one step of Newton's method. Returns how far off it was. */
static float lflare__mesh_match(const lflare__mesher *m, int32_t k, const float *sensor, float *x, float *y, lflare__terms_at *t)
{
    float at[2], j[4], det, off;
    lflare__place_at(&m->bundle, k, 0, t, at);
    lflare__place_slopes(&m->bundle, k, 0, t, j);
    at[0] = sensor[0] - at[0];
    at[1] = sensor[1] - at[1];
    off = fabsf(at[0]) + fabsf(at[1]);
    det = j[0] * j[3] - j[1] * j[2];
    if (!(fabsf(det) > 1e-20f)) return 0;
    *x = lflare__minf(lflare__maxf(*x + (at[0] * j[3] - at[1] * j[1]) / det, -1.3f), 1.3f);
    *y = lflare__minf(lflare__maxf(*y + (at[1] * j[0] - at[0] * j[2]) / det, -1.3f), 1.3f);
    lflare__terms_make(m->bundle.order, *x, *y, 1, t);
    return off;
}

/* All channels at the place where the lead channel's ray through (x, y) of the mesh's coordinates lands. */
static void lflare__mesh_point_at(const lflare__mesher *m, float x, float y, lflare__mesh_point *out)
{
    lflare__terms_at lead, t;
    float slopes[4];
    int32_t k;
    x += m->bend * y * y;
    out->entrance[0] = m->bundle.middle + m->bundle.half[0] * x;
    out->entrance[1] = m->bundle.half[1] * y;
    lflare__terms_make(m->bundle.order, x, y, 1, &lead);
    lflare__place_at(&m->bundle, m->lead, 0, &lead, out->sensor);
    lflare__place_slopes(&m->bundle, m->lead, 0, &lead, slopes);
    out->shrink = (slopes[0] * slopes[3] - slopes[1] * slopes[2]) / (m->bundle.half[0] * m->bundle.half[1]);
    for (k = m->begin; k < m->end; k++) {
        float j[4], shrink, px = x, py = y, fx[LFLARE__EVEN_FIELDS], fy[LFLARE__PLACES];
        t = lead;
        if (k != m->lead && lflare__mesh_match(m, k, out->sensor, &px, &py, &t) > 0.02f * m->reach) lflare__mesh_match(m, k, out->sensor, &px, &py, &t);
        lflare__fields_at(&m->bundle, k, &t, fx, fy);
        out->closed[k] = lflare__mesh_closed(m, k, px, py, fx, fy, out);
        out->weight[k] = lflare__weight_of(&m->bundle, fx[LFLARE__PLACES]);
        if (k == m->lead) continue;
        lflare__place_slopes(&m->bundle, k, 0, &t, j);
        shrink = (j[0] * j[3] - j[1] * j[2]) / (m->bundle.half[0] * m->bundle.half[1]);
        out->weight[k] *= lflare__minf(fabsf(out->shrink) / lflare__maxf(fabsf(shrink), 1e-12f), 4);
    }
}

/* The most open point of the mirror plane for one channel. */
static float lflare__mesh_widest_of(const lflare__mesher *m, int32_t k, float *at)
{
    float best = -9, step = 0.15f;
    int32_t i, side;
    for (i = -8; i <= 8; i++) {
        float open = lflare__mesh_open(m, k, 0.15f * (float)i, 0);
        if (open > best) best = open, *at = 0.15f * (float)i;
    }
    for (i = 0; i < (best < 0.05f ? 24 : 9); i++) {
        float x = *at;
        step *= 0.6f;
        for (side = -1; side <= 1; side += 2) {
            float open = lflare__mesh_open(m, k, x + (float)side * step, 0);
            if (open > best) best = open, *at = x + (float)side * step;
        }
    }
    return best;
}

/* The same for the channel that leads; where that is nearly shut, for the one that is most open, which leads from here on. */
static float lflare__mesh_widest(lflare__mesher *m, float *at)
{
    float best = lflare__mesh_widest_of(m, m->lead, at), there = 0;
    int32_t k;
    for (k = m->begin; k < m->end && best < 0.05f; k++) {
        float open = lflare__mesh_widest_of(m, k, &there);
        if (open > best) best = open, *at = there, m->lead = k;
    }
    return best;
}

/* How far from (x, y) along (dx, dy) channel k stays open. */
static float lflare__mesh_extent(const lflare__mesher *m, int32_t k, float x, float y, float dx, float dy, float guess)
{
    float near = 0, far = guess, open_near = lflare__mesh_open(m, k, x, y), open_far = 0;
    int32_t i;
    if (open_near <= 0) return 0;
    for (i = 0; i < 12; i++) {
        open_far = lflare__mesh_open(m, k, x + far * dx, y + far * dy);
        if (open_far <= 0) break;
        near = far;
        open_near = open_far;
        far *= 1.5f;
    }
    for (i = 0; i < 30 && far - near > 1e-3f * far; i++) { /* regula falsi, kept from creeping */
        float share = i % 3 == 2 ? 0.5f : lflare__minf(lflare__maxf(open_near / (open_near - open_far), 0.02f), 0.98f);
        float middle = near + share * (far - near), open = lflare__mesh_open(m, k, x + middle * dx, y + middle * dy);
        if (fabsf(open) < 3e-4f) return middle;
        if (open > 0) near = middle, open_near = open;
        else far = middle, open_far = open;
    }
    return 0.5f * (near + far);
}

/* Centre, unit and bend of the polar coordinates; 0 if all is closed. What two rims leave may be a crescent: bent by how its middle
   moves with y it is a lens again, seen all over from its centre. */
static int lflare__mesh_place(lflare__mesher *m)
{
    float x, lo, hi, up;
    m->middle = m->half[0] = m->half[1] = m->bend = 0;
    if (lflare__mesh_widest(m, &x) <= 0) {
        m->middle = x;
        return 0;
    }
    hi = x + lflare__mesh_extent(m, m->lead, x, 0, 1, 0, 0.5f);
    lo = x - lflare__mesh_extent(m, m->lead, x, 0, -1, 0, 0.5f);
    m->middle = 0.5f * (lo + hi);
    m->half[0] = lflare__maxf(0.5f * (hi - lo), 1e-5f);
    up = 0.7f * lflare__mesh_extent(m, m->lead, m->middle, 0, 0, 1, 0.5f);
    if (up > 0) {
        hi = m->middle + lflare__mesh_extent(m, m->lead, m->middle, up, 1, 0, m->half[0]);
        lo = m->middle - lflare__mesh_extent(m, m->lead, m->middle, up, -1, 0, m->half[0]);
        m->bend = (0.5f * (lo + hi) - m->middle) / (up * up);
    }
    m->half[1] = lflare__maxf(lflare__mesh_extent(m, m->lead, m->middle, 0, 0, 1, 0.5f), 1e-5f);
    return 1;
}

/* Whether the lead channel's open part of the box hides some of itself from the centre. */
static int lflare__mesh_ragged(lflare__mesher *m)
{
    int32_t i, j, k;
    if (!lflare__mesh_place(m)) return 0;
    for (j = 0; j <= 3; j++)
        for (i = -4; i <= 4; i++) {
            float y = 0.3f * (float)j, x = 0.28f * (float)i - m->bend * y * y;
            if (lflare__mesh_open(m, m->lead, x, y) < 0.04f) continue;
            for (k = 1; k <= 3; k++) /* on the way to the centre */
                if (lflare__mesh_open(m, m->lead, m->middle + 0.25f * (float)k * (x - m->middle), 0.25f * (float)k * y) < -0.02f) return 1;
        }
    return 0;
}

static float lflare__mesh_any_open(const lflare__mesher *m, float x, float y)
{
    float open = -9;
    int32_t k;
    for (k = m->begin; k < m->end; k++) open = lflare__maxf(open, lflare__mesh_open(m, k, x, y));
    return open;
}

/* Bounds of what is open: least and greatest x, greatest y, mm on the entrance. Returns 0 if nothing is. */
static int lflare__mesh_bounds(lflare__mesher *m, float *bounds)
{
    float lo = 9, hi = -9, up = 0;
    int32_t i, j;
    if (lflare__mesh_place(m)) { /* may be less than the grid below sees */
        lo = m->middle - m->half[0];
        hi = m->middle + m->half[0];
        up = m->half[1];
    }
    for (j = 0; j <= 14; j++)
        for (i = -14; i <= 14; i++) {
            float x = 0.08f * (float)i, y = 0.08f * (float)j;
            if (lflare__mesh_any_open(m, x, y) <= -0.03f) continue;
            lo = lflare__minf(lo, x - 0.06f);
            hi = lflare__maxf(hi, x + 0.06f);
            up = lflare__maxf(up, y + 0.06f);
        }
    bounds[0] = m->bundle.middle + m->bundle.half[0] * lo;
    bounds[1] = m->bundle.middle + m->bundle.half[0] * hi;
    bounds[2] = m->bundle.half[1] * up;
    return lo < hi;
}

/* A vertex, for three channels: place on the sensor, on the entrance; weights, shrink; rims, spread of the shrink; places on the iris;
   blur of the rim, see lflare__mesh_rates. For one: place, entrance; weight, shrink, its spread, blur; rim, place on the iris, the same. */
static void lflare__mesh_store(const lflare__mesher *m, const lflare__mesh_point *p, float *out)
{
    int32_t k, split = m->end - m->begin == 1, step = split ? 0 : 1;
    float *weight = out + 4, *shrink = split ? out + 5 : out + 7, *rim = out + 8, *iris = split ? out + 9 : out + 12;
    for (k = 0; k < 2; k++) {
        out[k] = p->sensor[k];
        out[2 + k] = p->entrance[k];
    }
    *shrink = p->shrink;
    for (k = m->begin; k < m->end; k++) {
        weight[step * k] = p->weight[k];
        rim[step * k] = p->rim[k];
        iris[2 * step * k] = p->iris[k][0];
        iris[2 * step * k + 1] = p->iris[k][1];
    }
    out[split ? 7 : 18] = p->lamp;
}

/* Twice the area of a triangle; a, b, c: its corners. */
static float lflare__mesh_area(const float *a, const float *b, const float *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
}

/* Along a direction, at `count` + 1 even places: the way on the sensor up to each of them, the map's shrink and how open it is there. */
static void lflare__mesh_walk(const lflare__mesher *m, float x, float y, float outer, int32_t count, float *way, float *shrink, float *open)
{
    float last[2] = {0, 0};
    int32_t i;
    for (i = 0; i <= count; i++) {
        float at = outer * (float)i / (float)count, sensor[2], j[4];
        lflare__terms_at t;
        lflare__terms_make(m->bundle.order, m->middle + at * x + m->bend * at * y * at * y, at * y, 1, &t);
        lflare__place_at(&m->bundle, m->lead, 0, &t, sensor);
        lflare__place_slopes(&m->bundle, m->lead, 0, &t, j);
        shrink[i] = j[0] * j[3] - j[1] * j[2];
        open[i] = m->ragged ? lflare__mesh_open(m, m->lead, m->middle + at * x, at * y) : 0;
        way[i] = i > 0 ? way[i - 1] + sqrtf((sensor[0] - last[0]) * (sensor[0] - last[0]) + (sensor[1] - last[1]) * (sensor[1] - last[1])) : 0;
        last[0] = sensor[0];
        last[1] = sensor[1];
    }
}

/* Whether a quantity passes through 0 within a tenth of the way from place i, as far as its slope says: 0 to 1. */
static float lflare__mesh_near(const float *v, int32_t i, int32_t count)
{
    int32_t before = i > 2 ? i - 2 : 0, after = i + 1 < count ? i + 1 : count;
    float near = 0.1f * (v[after] - v[before]) * (float)count / (float)(after - before), middle = 0.5f * (v[i] + v[i - 1]);
    return near * near / (near * near + middle * middle + 1e-30f);
}

/* Places the rings along a direction so that they divide the way on the sensor evenly, a little the way on the entrance too (rays
   near total reflection run apart by decimetres), and stand close where the map turns over: its outline there is that of triangles. */
static void lflare__mesh_spread(const lflare__mesher *m, float x, float y, float outer, int32_t rings, float *places)
{
    enum { FINE = 4, MOST = FINE * (4 << LFLARE__MAX_LEVEL) };
    float way[MOST + 1], shrink[MOST + 1], open[MOST + 1], sum[MOST + 1], even;
    int32_t i, r = 1, count = FINE * rings;
    lflare__mesh_walk(m, x, y, outer, count, way, shrink, open);
    even = 0.5f / (float)count;
    for (sum[0] = 0, i = 1; i <= count; i++) {
        float step = even + (way[i] - way[i - 1]) / (way[count] + 1e-9f);
        if (m->end - m->begin == 1) step += 6 / (float)count * lflare__mesh_near(shrink, i, count);
        if (m->ragged) step += 6 / (float)count * lflare__mesh_near(open, i, count);
        sum[i] = sum[i - 1] + step;
    }
    places[0] = 0;
    for (i = 1; i <= count && r < rings; i++)
        for (; r < rings && sum[i] * (float)rings >= sum[count] * (float)r; r++) {
            float f = (sum[count] * (float)r / (float)rings - sum[i - 1]) / (sum[i] - sum[i - 1]);
            places[r] = ((float)(i - 1) + f) / (float)count;
        }
    places[rings] = 1;
}

/* Which ring a place is at, as a fraction of all. */
static float lflare__mesh_ring_of(const float *places, int32_t rings, float place)
{
    int32_t r = 0;
    if (!(places[rings] > 0) || place >= places[rings]) return places[rings] > 0 ? 1.0f : 0.0f;
    while (r + 1 < rings && places[r + 1] <= place) r++;
    return ((float)r + lflare__maxf(place - places[r], 0) / lflare__maxf(places[r + 1] - places[r], 1e-12f)) / (float)rings;
}

/* How far a direction is open in all channels, and in any: the lead channel's outline, and where the others' lie by how closed they
   are there. */
static void lflare__mesh_outline(lflare__mesher *m, float x, float y, float *inner, float *outer)
{
    float edge = lflare__mesh_extent(m, m->lead, m->middle, 0, x, y, 1), most = edge, least = edge;
    lflare__mesh_point at, before;
    int32_t k;
    if (m->end - m->begin > 1 && edge > 0) {
        lflare__mesh_point_at(m, m->middle + edge * x, edge * y, &at);
        lflare__mesh_point_at(m, m->middle + 0.9f * edge * x, 0.9f * edge * y, &before);
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
            const float *e = m->ends[k];
            float here = e[0] * at.closed[0] + e[1] * at.closed[1] + e[2] * at.closed[2];
            float rate = lflare__maxf((here - e[0] * before.closed[0] - e[1] * before.closed[1] - e[2] * before.closed[2]) / 0.1f, 0.2f);
            most = lflare__maxf(most, edge * (1 + (1 - here) / rate));
            least = lflare__minf(least, edge * (1 + (1 - here) / rate));
        }
    }
    *outer = edge + 1.1f * (lflare__minf(most, 1.5f * edge) - edge);
    if (m->inscribed < 1) {
        m->iris *= m->inscribed;
        edge = lflare__mesh_extent(m, m->lead, m->middle, 0, x, y, edge);
        m->iris /= m->inscribed;
        least = lflare__minf(least, edge) - (most - least);
    }
    *inner = lflare__maxf(edge - 1.1f * (edge - least), 0);
}

/* A knot's vertices, in the making. */
typedef struct lflare__mesh_grid {
    float *vertices;
    int32_t rings, directions, floats;
} lflare__mesh_grid;

static float *lflare__mesh_at(const lflare__mesh_grid *g, int32_t ring, int32_t direction)
{
    return g->vertices + (size_t)(ring * (g->directions + 1) + direction) * (size_t)g->floats;
}

/* How much the shrink differs between a vertex and its neighbours: where it is no more than that, its inverse is no irradiance. */
static void lflare__mesh_spreads(const lflare__mesh_grid *g)
{
    int32_t r, d, i, shrink = g->floats == LFLARE__MESH_SPLIT ? 5 : 7, spread = g->floats == LFLARE__MESH_SPLIT ? 6 : 11;
    float centre = 0;
    for (r = 0; r <= g->rings; r++)
        for (d = 0; d <= g->directions; d++) {
            static const int32_t dr[4] = {1, -1, 0, 0}, dd[4] = {0, 0, 1, -1};
            float *v = lflare__mesh_at(g, r, d), most = 0;
            for (i = 0; i < 4; i++) {
                int32_t r1 = r + dr[i], d1 = d + dd[i];
                if (r1 < 0 || r1 > g->rings || d1 < 0 || d1 > g->directions) continue;
                most = lflare__maxf(most, fabsf(lflare__mesh_at(g, r1, d1)[shrink] - v[shrink]));
            }
            v[spread] = most;
            if (r == 0) centre = lflare__maxf(centre, most);
        }
    for (d = 0; d <= g->directions; d++) lflare__mesh_at(g, 0, d)[spread] = centre;
}

/* The last float of a vertex: where the rim begins (a share of the rings) on the last ring, what a unit of the polar radius is
   across the outline on the one before, no less than a quarter of the way there, and on the first, whose vertices are one point,
   the bulge of the rim. */
static void lflare__mesh_rates(const lflare__mesh_grid *g)
{
    int32_t d;
    for (d = 0; d <= g->directions; d++) {
        const float *a = lflare__mesh_at(g, g->rings, d > 0 ? d - 1 : 0), *b = lflare__mesh_at(g, g->rings, d < g->directions ? d + 1 : d);
        const float *v = lflare__mesh_at(g, g->rings, d);
        float *in = lflare__mesh_at(g, g->rings - 1, d), tx = b[0] - a[0], ty = b[1] - a[1], wx = v[0] - in[0], wy = v[1] - in[1], length;
        if (d == 0 || d == g->directions) tx = 0, ty = 1; /* across the mirror plane */
        length = lflare__maxf(sqrtf(tx * tx + ty * ty), 1e-12f);
        in[g->floats - 1] = (float)g->rings * lflare__maxf(fabsf(wx * ty - wy * tx) / length, 0.25f * sqrtf(wx * wx + wy * wy));
    }
}

/* Between two vertices of the outline a rim is an arc, along which its height stays while along the chord it falls: by how much. */
static void lflare__mesh_bulges(const lflare__mesher *m, const lflare__mesh_grid *g)
{
    int32_t d, k = m->lead, rim = g->floats == LFLARE__MESH_SPLIT ? 8 : 8 + k;
    float last = 0, bulge = 0;
    for (d = 0; d <= g->directions; d++) {
        if (d < g->directions) {
            const float *a = lflare__mesh_at(g, g->rings, d), *b = lflare__mesh_at(g, g->rings, d + 1);
            float fx[LFLARE__EVEN_FIELDS], fy[LFLARE__PLACES];
            float x = (0.5f * (a[2] + b[2]) - m->bundle.middle) / m->bundle.half[0], y = 0.5f * (a[3] + b[3]) / m->bundle.half[1];
            lflare__mesh_point p;
            lflare__terms_at t;
            lflare__terms_make(m->bundle.order, x, y, 0, &t);
            lflare__fields_at(&m->bundle, k, &t, fx, fy);
            lflare__mesh_closed(m, k, x, y, fx, fy, &p);
            bulge = 0.5f * (a[rim] + b[rim]) - p.rim[k];
        }
        lflare__mesh_at(g, 0, d)[g->floats - 1] = lflare__maxf(d == 0 ? bulge : d == g->directions ? last : 0.5f * (last + bulge), 0);
        last = bulge;
    }
}

/* What a knot says of its mesh as a whole: radius on the sensor (of a disc of the triangles' area), blur of the iris, radius on the
   entrance, the centre's x there; middle and radius of its bounds on the sensor, magnification from its ends, half the length of the bounds along x. */
static void lflare__mesh_whole(const lflare__mesher *m, const lflare__mesh_grid *g, float *out)
{
    const float *first = lflare__mesh_at(g, g->rings, 0), *last = lflare__mesh_at(g, g->rings, g->directions);
    float area[2] = {0, 0}, far[2] = {1e30f, -1e30f}, up = 0;
    int32_t r, d, k;
    for (r = 0; r <= g->rings; r++)
        for (d = 0; d <= g->directions; d++) {
            const float *v = lflare__mesh_at(g, r, d), *w, *x, *y;
            far[0] = lflare__minf(far[0], v[0]);
            far[1] = lflare__maxf(far[1], v[0]);
            up = lflare__maxf(up, fabsf(v[1]));
            if (r == g->rings || d == g->directions) continue;
            w = lflare__mesh_at(g, r + 1, d);
            x = lflare__mesh_at(g, r, d + 1);
            y = lflare__mesh_at(g, r + 1, d + 1);
            for (k = 0; k < 2; k++) area[k] += fabsf(lflare__mesh_area(v + 2 * k, w + 2 * k, x + 2 * k)) + fabsf(lflare__mesh_area(w + 2 * k, x + 2 * k, y + 2 * k));
        }
    out[0] = sqrtf(area[0] / (float)LFLARE__PI); /* half of two triangles, on both sides of the mirror plane */
    out[1] = m->lamps[0];
    out[2] = sqrtf(area[1] / (float)LFLARE__PI);
    out[3] = lflare__mesh_at(g, 0, 0)[2];
    out[4] = 0.5f * (far[0] + far[1]);
    out[5] = sqrtf(0.25f * (far[1] - far[0]) * (far[1] - far[0]) + up * up);
    out[6] = (first[0] - last[0]) / lflare__maxf(first[2] - last[2], 1e-12f);
    out[7] = 0.5f * (far[1] - far[0]);
}

/* Where the vertices of a knot stand: polar coordinates, and for each direction how far out it is open and where its rings are, as
   shares of that. */
typedef struct lflare__mesh_plan {
    float middle, half[2], bend;
    float inner[(8 << LFLARE__MAX_LEVEL) + 1], outer[(8 << LFLARE__MAX_LEVEL) + 1], rings[(8 << LFLARE__MAX_LEVEL) + 1][(4 << LFLARE__MAX_LEVEL) + 1];
} lflare__mesh_plan;

static void lflare__mesh_direction(const lflare__mesher *m, int32_t d, int32_t directions, float *x, float *y)
{
    float angle = (float)LFLARE__PI * (float)d / (float)directions;
    *x = m->half[0] * cosf(angle);
    *y = d == 0 || d == directions ? 0 : m->half[1] * sinf(angle);
}

static void lflare__mesh_plan_make(lflare__mesher *m, int32_t level, lflare__mesh_plan *p)
{
    int32_t rings = lflare__mesh_rings(level), directions = lflare__mesh_directions(level), d, r;
    int open = m->ragged || lflare__mesh_place(m);
    p->middle = m->middle;
    p->bend = m->bend;
    for (d = 0; d < 2; d++) p->half[d] = m->half[d];
    for (d = 0; d <= directions; d++) {
        float x, y;
        lflare__mesh_direction(m, d, directions, &x, &y);
        p->inner[d] = p->outer[d] = m->ragged ? 1.0f : 0.0f;
        if (open && !m->ragged) lflare__mesh_outline(m, x, y, &p->inner[d], &p->outer[d]);
        for (r = 0; r <= rings; r++) p->rings[d][r] = (float)r / (float)rings;
        if (p->outer[d] > 0) lflare__mesh_spread(m, x, y, p->outer[d], rings, p->rings[d]);
    }
}

/* Between knots vertices are interpolated: rings that crowd where a map turns over may come and go only slowly. */
static void lflare__mesh_plans_smooth(lflare__mesh_plan *plans, int32_t knots, int32_t level)
{
    int32_t r, d, pass, j;
    for (d = 0; d <= lflare__mesh_directions(level); d++)
        for (r = 1; r < lflare__mesh_rings(level); r++)
            for (pass = 0; pass < 3; pass++) {
                float before = plans[0].rings[d][r];
                for (j = 0; j < knots; j++) {
                    float here = plans[j].rings[d][r], after = plans[j + 1 < knots ? j + 1 : j].rings[d][r];
                    plans[j].rings[d][r] = 0.25f * (before + 2 * here + after);
                    before = here;
                }
            }
}

/* One field angle of a mesh. */
static void lflare__mesh_knot(lflare__mesher *m, int32_t level, const lflare__mesh_plan *p, float *out)
{
    lflare__mesh_grid g;
    int32_t r, d;
    g.vertices = out + 4 * LFLARE__MESH_KNOT_TEXELS;
    g.rings = lflare__mesh_rings(level);
    g.directions = lflare__mesh_directions(level);
    g.floats = lflare__mesh_floats(m->end - m->begin == 1);
    memset(g.vertices, 0, sizeof(float) * (size_t)((g.rings + 1) * (g.directions + 1) * g.floats));
    m->middle = p->middle;
    m->bend = p->bend;
    for (d = 0; d < 2; d++) m->half[d] = p->half[d];
    for (d = 0; d <= g.directions; d++) {
        float x, y;
        lflare__mesh_direction(m, d, g.directions, &x, &y);
        for (r = 0; r <= g.rings; r++) {
            lflare__mesh_point point;
            float at = p->outer[d] * p->rings[d][r];
            lflare__mesh_point_at(m, m->middle + at * x, at * y, &point);
            lflare__mesh_store(m, &point, lflare__mesh_at(&g, r, d));
        }
        lflare__mesh_at(&g, g.rings, d)[g.floats - 1] = m->ragged || !(p->outer[d] > 0) ? 0 : lflare__mesh_ring_of(p->rings[d], g.rings, p->inner[d] / p->outer[d]);
    }
    lflare__mesh_spreads(&g);
    lflare__mesh_rates(&g);
    if (!m->ragged) lflare__mesh_bulges(m, &g);
    lflare__mesh_whole(m, &g, out);
}

/* Blur of the images of iris and rims, mm on the sensor per radian of the lamp's size: how fast they move with its place (P 3). Rims that
   are the iris are given its size. */
static void lflare__mesh_lamps(const lflare_lens *lens, lflare_pair pair, const float *head, float iris, lflare__fit_ghost *ghost, float *lamps)
{
    double n[LFLARE_MAX_SURFACES + 1], m11 = (double)head[6], m12 = (double)head[7];
    lflare__walk walk;
    lflare_crossing at;
    int32_t step = 0, i;
    for (i = 0; i <= LFLARE_FIT_RIMS; i++) lamps[i] = 0;
    lflare__indices(&lens->prescription, lflare__rgb_nm[1], n);
    lflare__walk_start(&walk, lens, n, pair);
    for (; lflare__walk_next(&walk, &at); step++)
        for (i = 0; i <= ghost->rims; i++)
            if (i == 0 ? at.iris : step == ghost->steps[i - 1]) {
                if (i > 0 && at.surface == lens->stop) ghost->shrunk[i - 1] = (float)lens->prescription.surfaces[lens->stop].semi_diameter / iris;
                lamps[i] = (float)lflare__min(fabs(m12 - m11 * at.b / (fabs(at.a) > 1e-9 ? at.a : 1e-9)), 10 * fabs(m12) + lens->sensor_width);
            }
}

/* Where the ghost hides for the iris in force: a bisection on the polynomials. */
static float lflare__mesh_hidden(lflare__mesher *m, const lflare__fit_ghost *ghost, int full)
{
    float lo = 0, hi = ghost->hidden_angle, x;
    int32_t i;
    if (full) return hi; /* the iris is that of the fit */
    for (i = 0; i < 12; i++) {
        float middle = 0.5f * (lo + hi);
        lflare__bundle_at(ghost, middle, &m->bundle);
        m->lead = 1;
        if (lflare__mesh_widest(m, &x) > 0) lo = middle;
        else hi = middle;
    }
    return hi;
}

/* Knots where nothing is open take the bounds of their neighbours. */
static void lflare__mesh_fill_bounds(float (*bounds)[3], const int *open, int32_t knots)
{
    int32_t i, j, k;
    for (j = 0; j < knots; j++) {
        int32_t nearest = -1;
        for (i = 0; i < knots && !open[j]; i++)
            if (open[i] && (nearest < 0 || abs(i - j) < abs(nearest - j))) nearest = i;
        for (k = 0; k < 3 && nearest >= 0; k++) bounds[j][k] = bounds[nearest][k];
    }
}

/* The ellipses that ragged meshes lie over: between two knots vertices are interpolated, and an outline that jumped would drag them
   across the picture, so they hold what is open at the neighbouring knots too and change smoothly. */
static void lflare__mesh_frames(lflare__mesher *m, const lflare__fit_ghost *ghost, float hidden, float (*frames)[3])
{
    float bounds[LFLARE__MORE_KNOTS][3];
    int open[LFLARE__MORE_KNOTS];
    int32_t i, j, k, pass, knots = lflare__mesh_knots(ghost->dense);
    for (j = 0; j < knots; j++) {
        lflare__bundle_at(ghost, lflare__knot_angle(j, hidden, knots), &m->bundle);
        open[j] = lflare__mesh_bounds(m, bounds[j]);
    }
    lflare__mesh_fill_bounds(bounds, open, knots);
    for (j = 0; j < knots; j++)
        for (k = 0; k < 3; k++) {
            frames[j][k] = bounds[j][k];
            for (i = j - 1; i <= j + 1; i++)
                if (i >= 0 && i < knots) frames[j][k] = k == 0 ? lflare__minf(frames[j][k], bounds[i][k]) : lflare__maxf(frames[j][k], bounds[i][k]);
        }
    for (pass = 0; pass < 2; pass++)
        for (k = 0; k < 3; k++) {
            float before = frames[0][k];
            for (j = 0; j < knots; j++) {
                float here = frames[j][k];
                frames[j][k] = 0.25f * (before + 2 * here + frames[j + 1 < knots ? j + 1 : j][k]);
                before = here;
            }
        }
}

/* The ellipse of a knot, in its bundle's box. */
static void lflare__mesh_frame(lflare__mesher *m, const float *frame)
{
    m->bend = 0;
    m->middle = (0.5f * (frame[0] + frame[1]) - m->bundle.middle) / m->bundle.half[0];
    m->half[0] = lflare__maxf(1.2f * 0.5f * (frame[1] - frame[0]) / m->bundle.half[0], 0.01f);
    m->half[1] = lflare__maxf(1.2f * frame[2] / m->bundle.half[1], 0.01f);
}

/* Whether a mesh is to be ragged: a knot is, or what is open jumps from knot to knot. */
static int lflare__mesh_any_ragged(lflare__mesher *m, const lflare__fit_ghost *ghost, float hidden)
{
    float ends[LFLARE__MORE_KNOTS][2];
    int32_t first = m->lead, knots = lflare__mesh_knots(ghost->dense), j, k;
    for (j = 0; j < knots; j++) {
        lflare__bundle_at(ghost, lflare__knot_angle(j, hidden, knots), &m->bundle);
        m->lead = first;
        if (lflare__mesh_ragged(m)) return 1;
        for (k = 0; k < 2; k++) ends[j][k] = m->bundle.middle + m->bundle.half[0] * (m->middle + (k == 0 ? -m->half[0] : m->half[0]));
        if (j > 0 && ghost->folded && ends[j][1] - ends[j][0] > 1.15f * (ends[j - 1][1] - ends[j - 1][0]) + 1e-4f * m->bundle.half[0]) return 1;
    }
    return 0;
}

/* One mesh of a ghost, for the channels that `m` says. Returns whether it is ragged. */
static int lflare__mesh_make(lflare__mesher *m, const lflare__fit_ghost *ghost, float hidden, float *out, size_t floats)
{
    lflare__mesh_plan plans[LFLARE__MORE_KNOTS];
    float frames[LFLARE__MORE_KNOTS][3];
    int32_t lead[LFLARE__MORE_KNOTS], first = m->lead, knots = lflare__mesh_knots(ghost->dense), j;
    m->ragged = (m->spectral && m->end - m->begin == 1) || lflare__mesh_any_ragged(m, ghost, hidden); /* meshes that are to be mixed are all alike */
    m->lead = first;
    if (m->ragged) lflare__mesh_frames(m, ghost, hidden, frames);
    for (j = 0; j < knots; j++) {
        lflare__bundle_at(ghost, lflare__knot_angle(j, hidden, knots) * (j == knots - 1 ? 0.99999f : 1), &m->bundle);
        m->lead = first;
        if (m->ragged) lflare__mesh_frame(m, frames[j]);
        lflare__mesh_plan_make(m, ghost->level, &plans[j]);
        lead[j] = m->lead;
    }
    lflare__mesh_plans_smooth(plans, knots, ghost->level);
    for (j = 0; j < knots; j++) {
        lflare__bundle_at(ghost, lflare__knot_angle(j, hidden, knots) * (j == knots - 1 ? 0.99999f : 1), &m->bundle);
        m->lead = lead[j];
        lflare__mesh_knot(m, ghost->level, &plans[j], out + (size_t)j * floats);
    }
    return m->ragged;
}

/* All meshes of a ghost: one for the three channels together, or where the map turns over one for each. */
static void lflare__mesh_ghost(const lflare_lens *lens, lflare_tables *t, int32_t g)
{
    const float *lens_head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    float *head = t->mesh_head + (size_t)g * LFLARE_MESH_HEAD_FLOATS;
    lflare__fit_ghost ghost;
    lflare__mesher m;
    int32_t mesh, count = (int32_t)head[6];
    size_t floats = 4 * (size_t)head[7];
    lflare__fit_ghost_read(t->fit, g, &ghost);
    if (ghost.knots == NULL) return;
    lflare__mesh_lamps(lens, t->pairs[g], lens_head, t->iris.radius, &ghost, m.lamps);
    m.iris = t->iris.radius;
    m.inscribed = lflare__iris_inscribed(&t->iris);
    m.reach = (float)LFLARE__FIT_REACH * lflare__maxf(t->sensor_width, t->sensor_height);
    m.lead = 1;
    m.begin = 0;
    m.end = LFLARE_WAVELENGTHS;
    m.bend = 0;
    m.ragged = 0;
    m.spectral = t->wavelength_count > 0;
    lflare__ends_of(t, m.ends);
    head[4] = lflare__mesh_hidden(&m, &ghost, m.iris > 0.999f * (float)lens->prescription.surfaces[lens->stop].semi_diameter);
    head[3] = 0.61e-6f * t->wavelengths[1] * lens_head[7]; /* radius that diffraction leaves, times that of the bundle */
    head[5] = ghost.dense ? 8 : 0;
    for (mesh = 0; mesh < count; mesh++) {
        m.begin = ghost.folded ? mesh : 0;
        m.end = ghost.folded ? mesh + 1 : LFLARE_WAVELENGTHS;
        m.lead = ghost.folded ? mesh : 1;
        head[5] += (float)(lflare__mesh_make(&m, &ghost, head[4], t->mesh + 4 * (size_t)head[0] + (size_t)(mesh * lflare__mesh_knots(ghost.dense)) * floats, floats) << mesh);
    }
}

/* The rows of mesh_head that do not depend on settings; returns the texels of all meshes. */
static size_t lflare__mesh_layout(lflare_tables *t)
{
    size_t used = 0;
    int32_t g;
    for (g = 0; g < t->ghost_count && t->fit != NULL; g++) {
        lflare__fit_ghost ghost;
        lflare__fit_ghost_read(t->fit, g, &ghost);
        if (t->mesh_head != NULL) {
            float *head = t->mesh_head + (size_t)g * LFLARE_MESH_HEAD_FLOATS;
            memset(head, 0, sizeof(float) * LFLARE_MESH_HEAD_FLOATS);
            if (ghost.knots != NULL) {
                head[0] = (float)used;
                head[1] = (float)lflare__mesh_directions(ghost.level);
                head[2] = (float)lflare__mesh_rings(ghost.level);
                head[5] = ghost.dense ? 8 : 0;
                head[6] = ghost.folded ? (float)LFLARE_WAVELENGTHS : 1;
                head[7] = (float)(lflare__mesh_size(&ghost) / (size_t)lflare__mesh_knots(ghost.dense));
            }
        }
        if (ghost.knots != NULL) used += (ghost.folded ? LFLARE_WAVELENGTHS : 1) * lflare__mesh_size(&ghost);
    }
    return used;
}

#else
static size_t lflare__mesh_layout(lflare_tables *t)
{
    t->fit = NULL;
    return 0;
}
#endif /* LFLARE_NO_ABERRATION */

#ifndef LFLARE_NO_TRACE
/* -- outlines: where on the entrance the rays of a traced ghost pass, for the iris in force -- */

/* tables.outline, a ghost: outlines of the three wavelengths, of which all but the middle one's are filled in only where meshes are split. Head:
   field angle where hidden, radius that diffraction leaves times that of the bundle, 0, 0. Then knots: x of the centre, half axes,
   how far the ends along y are bent along x; blur of the iris, mm on the sensor per radian of the lamp's size, radius on the sensor, on the
   entrance, 1 or -1 as the ghost stands; middle and radius of its bounds on the sensor, the centre's place there, for the middle wavelength
   the mesh up to the next knot (see lflare__mesh_code); how much brighter the outer wavelengths' maps make them than the middle one's, half the length of the bounds along x,
   radius on the sensor of what is drawn up to the next knot if that is ragged; if
   what is open up to the next knot is ragged, the ellipse that holds it: x of its centre, half axes, 0; and for
   each direction how far out it is open to any wavelength, in half axes, where that is to all, as a share of it, mm on the sensor per half
   axis there, blur of what ends it. */
enum { LFLARE__OUTLINE_HEAD = 4, LFLARE__OUTLINE_WHOLE = 20, LFLARE__OUTLINE_KNOT = LFLARE__OUTLINE_WHOLE + 4 * LFLARE_OUTLINE_SIDES, LFLARE__OUTLINE_ONE = LFLARE__OUTLINE_HEAD + LFLARE_OUTLINE_KNOTS * LFLARE__OUTLINE_KNOT };

/* How far, in pixels, rays of the outer wavelengths may land from where the first order says: beyond, wavelengths have meshes of their own. */
#define LFLARE__OUTLINE_APART 1.0
#define LFLARE__OUTLINE_NARROW 0.04 /* how open a bundle is at its centre: below, heights hardly differ over it, and rims are everywhere */
#define LFLARE__OUTLINE_ENDS_APART 4.0 /* likewise, of a spectrum's ends, which are faint */

/* Rings, 64 for 32 directions over half a turn instead of 16, 128 if there is a mesh for each wavelength, 256 if it is ragged: what is open is
   in pieces, or hides some of itself from the centre, or jumps from knot to knot. */
static int32_t lflare__mesh_code(int32_t level, int fine, int split, int ragged) { return (4 << level) + (fine ? 64 : 0) + (split ? 128 : 0) + (ragged ? 256 : 0); }
static int32_t lflare__code_rings(int32_t code) { return code & 63; }
static int32_t lflare__code_directions(int32_t code) { return code & 64 ? 32 : 16; }
/* After giving up as many levels: rings first, whose number counts most. */
static int32_t lflare__code_coarser(int32_t code, int32_t levels)
{
    for (; levels > 0; levels--) code = lflare__code_rings(code) > 4 ? (code & ~63) | lflare__code_rings(code) / 2 : code & ~64;
    return code;
}
static int32_t lflare__code_patches(const lflare_tables *t, int32_t code) { return lflare__meshes(t, code & 128) * (lflare__code_directions(code) / 4) * (lflare__code_rings(code) / 4); }

typedef struct lflare__outliner {
    lflare__finder find;
    lflare__tracer tracer;
    double lamps[LFLARE_MAX_STEPS];   /* blur of each step's rim, the stop's too */
    double slope, middle, half[2], bend, inscribed, pixel;
    double open;                      /* how open the centre is */
    double most_apart;                /* LFLARE__OUTLINE_APART, or what ends may be */
    int ragged, matching;             /* outlines are ellipses over all; the outer wavelengths are looked at, too */
    double apart, curved, bulged;     /* of the knot, in pixels: what LFLARE__OUTLINE_APART limits; the map from a line, over half the way out; from
                                         one direction to the next */
    int turned, hides;                /* the map turns over there; what is open hides some of itself from the centre */
} lflare__outliner;

/* What searches found at the middle wavelength. */
typedef struct lflare__outline_plan {
    double bounds[LFLARE_OUTLINE_KNOTS][3], width[LFLARE_WAVELENGTHS][LFLARE_OUTLINE_KNOTS], apart[LFLARE_OUTLINE_KNOTS], curved[LFLARE_OUTLINE_KNOTS], bulged[LFLARE_OUTLINE_KNOTS];
    int open[LFLARE_OUTLINE_KNOTS], hides[LFLARE_OUTLINE_KNOTS], narrow[LFLARE_OUTLINE_KNOTS], bounded[LFLARE_OUTLINE_KNOTS], turned[LFLARE_OUTLINE_KNOTS], split[LFLARE_OUTLINE_KNOTS]; /* bounded: a bit for each wavelength whose
                                                   bounds are known; split: up to the next knot */
} lflare__outline_plan;

static void lflare__outline_at(const lflare__outliner *o, double u, double v, double *x, double *y)
{
    *y = o->half[1] * v;
    *x = o->middle + o->half[0] * u + o->bend * *y * *y;
}

/* See lflare__closed; (u, v) in half axes. */
static double lflare__outline_closed(lflare__outliner *o, int32_t k, double u, double v, lflare__traced_ray *ray)
{
    double x, y;
    lflare__outline_at(o, u, v, &x, &y);
    return lflare__closed_floats(&o->find, k, x, y, o->slope, ray);
}

static double lflare__outline_open(lflare__outliner *o, double u, double v)
{
    lflare__traced_ray ray;
    return 1 - lflare__outline_closed(o, o->find.lead, u, v, &ray);
}

/* How open the lens is at up to LFLARE__LANES places. */
static void lflare__outline_opens(lflare__outliner *o, int32_t count, const double *u, const double *v, double *open)
{
    double x[LFLARE__LANES], y[LFLARE__LANES];
    int32_t i;
    for (i = 0; i < LFLARE__LANES; i++) lflare__outline_at(o, u[i < count ? i : 0], v[i < count ? i : 0], &x[i], &y[i]);
    lflare__closed_lanes(&o->find, o->find.lead, x, y, o->slope, open);
    for (i = 0; i < count; i++) open[i] = 1 - open[i];
}

/* A search along a direction from a place that is open so far: between near and far, once that is shut, lies the edge. */
typedef struct lflare__outline_search {
    double near, far, open_near, open_far, at;
    int32_t tries; /* to find what is shut, then between */
    int shut, done;
} lflare__outline_search;

/* Where to look next. */
static void lflare__outline_next(lflare__outline_search *s)
{
    double share = s->tries % 3 == 2 ? 0.5 : lflare__clamp(s->open_near / (s->open_near - s->open_far), 0.02, 0.98);
    s->at = s->shut ? s->near + share * (s->far - s->near) : s->far;
}

/* Takes what is open there. Regula falsi: heights are nearly linear. */
static void lflare__outline_found(lflare__outline_search *s, double open)
{
    s->tries++;
    s->done = fabs(open) < 1e-3;
    if (s->done) s->far = s->at;
    else if (open > 0) {
        s->near = s->at;
        s->open_near = open;
        if (!s->shut) s->far *= lflare__clamp(1 + 1.2 * open, 1.02, 1.5);
    } else {
        if (!s->shut) s->tries = 0;
        s->shut = 1;
        s->far = s->at;
        s->open_far = open;
    }
    s->done |= s->tries >= (s->shut ? 24 : 16) || (s->shut && s->far - s->near <= 2e-3 * s->far);
}

/* How far from (u, v), open so far, along up to LFLARE__LANES directions (du, dv) it stays open. extents: first guesses, then the result. */
static void lflare__outline_extents(lflare__outliner *o, double u, double v, double open, int32_t count, const double *du, const double *dv, double *extents)
{
    lflare__outline_search searches[LFLARE__LANES];
    double x[LFLARE__LANES] = {0}, y[LFLARE__LANES] = {0}, there[LFLARE__LANES];
    int32_t i, going = open > 0;
    for (i = 0; i < count; i++) {
        memset(&searches[i], 0, sizeof searches[i]);
        searches[i].far = extents[i];
        searches[i].open_near = open;
    }
    while (going) {
        for (i = 0; i < count; i++) {
            if (!searches[i].done) lflare__outline_next(&searches[i]);
            x[i] = u + searches[i].at * du[i];
            y[i] = v + searches[i].at * dv[i];
        }
        lflare__outline_opens(o, count, x, y, there);
        for (going = 0, i = 0; i < count; i++) {
            if (!searches[i].done) lflare__outline_found(&searches[i], there[i]);
            going |= !searches[i].done;
        }
    }
    for (i = 0; i < count; i++) extents[i] = open > 0 ? searches[i].far : 0;
}

static double lflare__outline_extent(lflare__outliner *o, double open, double du, double dv, double guess)
{
    lflare__outline_extents(o, 0, 0, open, 1, &du, &dv, &guess);
    return guess;
}

/* Centre, half axes and bend of what is open; 0 if nothing is: then the centre is where least is missing. */
static int lflare__outline_place(lflare__outliner *o)
{
    static const double both[2] = {1, -1}, none[2] = {0};
    double reach = o->find.lens->prescription.surfaces[0].semi_diameter, x, up, least, ends[2];
    o->bend = o->middle = 0;
    o->half[0] = o->half[1] = 1;
    least = lflare__least_closed(&o->find, o->slope, 0.9, &x);
    if (least >= 1) {
        o->middle = x;
        return 0;
    }
    ends[0] = ends[1] = 0.3 * reach;
    lflare__outline_extents(o, x, 0, 1 - least, 2, both, none, ends);
    o->middle = x + 0.5 * (ends[0] - ends[1]);
    o->half[0] = lflare__max(0.5 * (ends[0] + ends[1]), 1e-5 * reach);
    o->open = lflare__outline_open(o, 0, 0);
    up = o->half[1] = lflare__outline_extent(o, o->open, 0, 1, o->half[0]);
    if (up > 0) {
        o->half[1] = 0.7 * up;
        ends[0] = ends[1] = 0.7;
        lflare__outline_extents(o, 0, 1, lflare__outline_open(o, 0, 1), 2, both, none, ends);
        o->bend = o->half[0] * 0.5 * (ends[0] - ends[1]) / (o->half[1] * o->half[1]);
        o->half[1] *= lflare__outline_extent(o, o->open, 0, 1, 1.0 / 0.7);
    }
    o->half[1] = lflare__max(o->half[1], 1e-5 * reach);
    return 1;
}

/* Whether there is another piece along the mirror plane. */
static int lflare__outline_parts(lflare__outliner *o)
{
    const lflare_surface *front = &o->find.lens->prescription.surfaces[0];
    double reach = front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter)) * o->slope;
    double x[LFLARE__LANES], closed[LFLARE__LANES];
    int32_t i, j;
    for (i = -2 * LFLARE__LANES; i < 2 * LFLARE__LANES; i += LFLARE__LANES) {
        for (j = 0; j < LFLARE__LANES; j++) x[j] = reach * (i + j + 0.5) / (2 * LFLARE__LANES);
        lflare__lead_closed(&o->find, LFLARE__LANES, x, o->slope, closed);
        for (j = 0; j < LFLARE__LANES; j++)
            if (fabs(x[j] - o->middle) > 1.2 * o->half[0] && closed[j] < 0.98) return 1;
    }
    return 0;
}

/* Whether a direction is shut on the way to its edge, or open again behind it: what is there hides from the centre. */
static int lflare__outline_hides(lflare__outliner *o, double u, double v, double edge)
{
    static const double places[LFLARE__LANES] = {0.2, 0.4, 0.6, 0.8, 1.1, 1.3, 1.6, 2.2};
    double x[LFLARE__LANES], y[LFLARE__LANES], open[LFLARE__LANES];
    int32_t i;
    for (i = 0; i < LFLARE__LANES; i++) {
        x[i] = places[i] * edge * u;
        y[i] = places[i] * edge * v;
    }
    lflare__outline_opens(o, LFLARE__LANES, x, y, open);
    for (i = 0; i < LFLARE__LANES; i++)
        if (places[i] < 1 ? open[i] < -0.02 : open[i] > 0.03) return 1;
    return 0;
}

/* Widens bounds to all that is open: of the outline and, if there may be more, on a grid over the front element: least and greatest x,
   greatest y. */
static void lflare__outline_bounds(lflare__outliner *o, int more, double *bounds)
{
    const int32_t across = 20; /* rows of whole lanes */
    const lflare_surface *front = &o->find.lens->prescription.surfaces[0];
    double reach = front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter)) * o->slope, step = reach / across, ends = o->bend * o->half[1] * o->half[1];
    int32_t i, j, k;
    bounds[0] = lflare__min(bounds[0], o->middle - o->half[0] + lflare__min(ends, 0));
    bounds[1] = lflare__max(bounds[1], o->middle + o->half[0] + lflare__max(ends, 0));
    bounds[2] = lflare__max(bounds[2], o->half[1]);
    if (!more) return;
    for (j = 0; j <= across; j++)
        for (i = -across; i < across; i += LFLARE__LANES) {
            double x[LFLARE__LANES], y[LFLARE__LANES], closed[LFLARE__LANES];
            for (k = 0; k < LFLARE__LANES; k++) {
                x[k] = (i + k + 0.5) * step;
                y[k] = j * step;
            }
            lflare__closed_lanes(&o->find, o->find.lead, x, y, o->slope, closed);
            for (k = 0; k < LFLARE__LANES; k++) {
                if (closed[k] > 1.03) continue;
                bounds[0] = lflare__min(bounds[0], x[k] - 0.7 * step);
                bounds[1] = lflare__max(bounds[1], x[k] + 0.7 * step);
                bounds[2] = lflare__max(bounds[2], y[k] + 0.7 * step);
            }
        }
}

/* The ellipse over what is open at two knots and, with a margin, between them. */
static void lflare__outline_ellipse(lflare__outliner *o, const lflare__outline_plan *p, int32_t knot)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL, up = 0;
    int32_t i;
    for (i = knot; i <= knot + 1; i++) {
        if (!(p->bounds[i][0] < p->bounds[i][1])) continue;
        lo = lflare__min(lo, p->bounds[i][0]);
        hi = lflare__max(hi, p->bounds[i][1]);
        up = lflare__max(up, p->bounds[i][2]);
    }
    o->middle = 0.5 * (lo + hi);
    o->half[0] = 1.2 * 0.5 * (hi - lo);
    o->half[1] = 1.2 * up;
    o->bend = 0;
}

/* The map about a ray through (x, y) that arrives: slopes of its place on the sensor, by rays nearer to the centre. 0 if one is lost. */
static int lflare__outline_slopes(lflare__outliner *o, const float *shares, double x, double y, const lflare__traced_ray *ray, double *slopes)
{
    int32_t axis, i;
    for (axis = 0; axis < 2; axis++) {
        double way = (axis == 0 ? x > o->middle : y > 0) ? -0.02 * o->half[axis] : 0.02 * o->half[axis];
        lflare__traced_ray near;
        lflare__traced_ray_make(&o->tracer, shares, 0, (float)(axis == 0 ? x + way : x), (float)(axis == 1 ? y + way : y), &near);
        if (!near.arrives) return 0;
        for (i = 0; i < 2; i++) slopes[2 * axis + i] = (double)(near.sensor[i] - ray->sensor[i]) / (double)((float)(axis == 0 ? x + way : y + way) - (float)(axis == 0 ? x : y));
    }
    return 1;
}

/* How closed the other wavelengths are where the leading one's ray through (u, v) lands, to first order, as vertices do it: the most and the
   least of them; what is wrong with that goes into o->apart. brighter (may be NULL): the leading map's area over theirs there. */
static void lflare__outline_match(lflare__outliner *o, double u, double v, const lflare__traced_ray *lead, double *most, double *least, double *brighter)
{
    double at[2], slopes[4], own[4], det;
    int32_t k, i;
    lflare__outline_at(o, u, v, &at[0], &at[1]);
    det = lflare__outline_slopes(o, o->tracer.ends[o->find.lead], at[0], at[1], lead, slopes) ? slopes[0] * slopes[3] - slopes[1] * slopes[2] : 0;
    *most = *least = 1;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        double off[2], x, y, closed;
        lflare__traced_ray ray;
        if (k == o->find.lead) continue;
        lflare__traced_ray_make(&o->tracer, o->tracer.ends[k], 0, (float)at[0], (float)at[1], &ray);
        if (!ray.arrives || !(fabs(det) > 1e-12)) {
            o->apart = HUGE_VAL;
            return;
        }
        for (i = 0; i < 2; i++) off[i] = (double)(lead->sensor[i] - ray.sensor[i]);
        x = at[0] + (off[0] * slopes[3] - off[1] * slopes[2]) / det;
        y = at[1] + (off[1] * slopes[0] - off[0] * slopes[1]) / det;
        closed = lflare__closed_floats(&o->find, k, x, y, o->slope, &ray);
        if (hypot((double)lead->sensor[0], (double)lead->sensor[1]) < o->find.reach)
            o->apart = lflare__max(o->apart, ray.arrives ? hypot((double)(ray.sensor[0] - lead->sensor[0]), (double)(ray.sensor[1] - lead->sensor[1])) / o->pixel : HUGE_VAL);
        *most = lflare__max(*most, closed);
        *least = lflare__min(*least, closed);
        if (brighter == NULL || !ray.arrives || !lflare__outline_slopes(o, o->tracer.ends[k], x, y, &ray, own)) continue;
        brighter[k] = fabs(det) / lflare__max(fabs(own[0] * own[3] - own[1] * own[2]), 1e-12);
        if (!(fabs(brighter[k] - 1) < 0.15)) o->apart = HUGE_VAL; /* next to focus: it differs from place to place */
    }
}

/* How far out a direction is open to the leading wavelength, all wavelengths, any of them. */
typedef struct lflare__outline_side {
    double edge, least, most;
} lflare__outline_side;

/* How far the others, matched to it, are open. */
static void lflare__outline_others(lflare__outliner *o, double u, double v, lflare__outline_side *s)
{
    double before, there, rate, most, least;
    lflare__traced_ray lead;
    before = 1 - lflare__outline_open(o, 0.9 * s->edge * u, 0.9 * s->edge * v);
    there = lflare__outline_closed(o, o->find.lead, 0.995 * s->edge * u, 0.995 * s->edge * v, &lead);
    if (!lead.arrives) return;
    rate = lflare__max((there - before) / 0.095, 0.2);
    lflare__outline_match(o, 0.995 * s->edge * u, 0.995 * s->edge * v, &lead, &most, &least, NULL);
    s->most = s->edge * lflare__clamp(0.995 + (1 - least) / rate, 1, 1.5);
    s->least = s->edge * lflare__clamp(0.995 + (1 - most) / rate, 0, 1);
}

static void lflare__outline_direction(int32_t d, double *u, double *v)
{
    *u = cos(LFLARE__PI * d / (LFLARE_OUTLINE_SIDES - 1));
    *v = d == 0 || d == LFLARE_OUTLINE_SIDES - 1 ? 0 : sin(LFLARE__PI * d / (LFLARE_OUTLINE_SIDES - 1));
}

/* All directions, and how far out they are open to the leading wavelength; of a ragged outline, 1. */
static void lflare__outline_edges(lflare__outliner *o, double *u, double *v, double *edges)
{
    int32_t d, some;
    for (d = 0; d < LFLARE_OUTLINE_SIDES; d++) {
        lflare__outline_direction(d, &u[d], &v[d]);
        edges[d] = 1;
    }
    for (d = 0; d < LFLARE_OUTLINE_SIDES && !o->ragged; d += some) {
        some = LFLARE_OUTLINE_SIDES - d < LFLARE__LANES ? LFLARE_OUTLINE_SIDES - d : LFLARE__LANES;
        lflare__outline_extents(o, 0, 0, o->open, some, u + d, v + d, edges + d);
    }
}

/* Those; the other wavelengths are looked at in every second one. */
static void lflare__outline_sides(lflare__outliner *o, lflare__outline_side *sides)
{
    double u[LFLARE_OUTLINE_SIDES], v[LFLARE_OUTLINE_SIDES], edges[LFLARE_OUTLINE_SIDES];
    int32_t d;
    o->hides = 0;
    lflare__outline_edges(o, u, v, edges);
    for (d = 0; d < LFLARE_OUTLINE_SIDES; d++) {
        lflare__outline_side *s = &sides[d];
        s->edge = s->least = s->most = edges[d];
        if (o->ragged || !(edges[d] > 0) || d % 2 != 0) continue;
        if (!o->hides) o->hides = lflare__outline_hides(o, u[d], v[d], s->edge);
        if (o->matching) lflare__outline_others(o, u[d], v[d], s);
    }
    for (d = 1; d < LFLARE_OUTLINE_SIDES && !o->ragged; d += 2) {
        const lflare__outline_side *a = &sides[d - 1], *b = &sides[d + 1];
        sides[d].most += 0.5 * (a->most - a->edge + b->most - b->edge);
        sides[d].least += 0.5 * (a->least - a->edge + b->least - b->edge);
    }
}

/* Its floats: how far out it is drawn, and where all of it is open, blades not in the way. */
static void lflare__outline_store(lflare__outliner *o, int32_t d, const lflare__outline_side *s, double *outer, double *inner)
{
    double least = s->least, u, v;
    *outer = s->edge + 1.1 * (s->most - s->edge);
    *inner = 0;
    if (o->ragged || !(*outer > 0)) return;
    if (o->inscribed < 1) {
        lflare__outline_direction(d, &u, &v);
        o->find.iris *= o->inscribed;
        least = lflare__min(least, lflare__outline_extent(o, lflare__outline_open(o, 0, 0), u, v, s->edge)) - (s->most - s->least);
        o->find.iris /= o->inscribed;
    }
    *inner = lflare__clamp((s->edge - 1.1 * (s->edge - least)) / *outer, 0, 1);
}

/* The ray at (u, v), or if it does not arrive one nearer to the centre that does. */
static void lflare__outline_ray(lflare__outliner *o, double u, double v, lflare__traced_ray *ray)
{
    int32_t i;
    for (i = 0; i < 12; i++, u *= 0.9, v *= 0.9) {
        lflare__outline_closed(o, o->find.lead, u, v, ray);
        if (ray->arrives) return;
    }
    memset(ray, 0, sizeof *ray);
}

/* The blur of what stops a ray first. */
static double lflare__outline_lamp(const lflare__outliner *o, const lflare__traced_ray *ray)
{
    double stop = sqrt((double)(ray->stop[0] * ray->stop[0] + ray->stop[1] * ray->stop[1])) * (double)o->tracer.t->iris.radius / o->find.iris;
    int32_t i;
    for (i = 0; i < o->tracer.count && stop >= (double)ray->relative; i++)
        if (lflare__step_is_iris(o->tracer.steps + i * LFLARE_STEP_FLOATS)) return o->lamps[i];
    return o->lamps[ray->widest];
}

/* How far the map is from a line between two directions' ends, where it matters. */
static void lflare__outline_bulge(lflare__outliner *o, const double *last, double u, double v, double (*ends)[2], double (*now)[2])
{
    double off[2];
    lflare__traced_ray ray;
    int32_t i;
    lflare__outline_closed(o, o->find.lead, 0.5 * (last[0] + u), 0.5 * (last[1] + v), &ray);
    for (i = 0; i < 2; i++) off[i] = (double)ray.sensor[i] - 0.5 * (ends[1][i] + now[1][i]);
    if (ray.arrives && hypot((double)ray.sensor[0], (double)ray.sensor[1]) < o->find.reach) o->bulged = lflare__max(o->bulged, hypot(off[0], off[1]) / o->pixel);
}

/* How far the map is from a line, where it matters. */
static void lflare__outline_measure(lflare__outliner *o, const double *centre, const lflare__traced_ray *half, const lflare__traced_ray *edge)
{
    double bent = 0;
    int32_t i;
    if (hypot((double)half->sensor[0], (double)half->sensor[1]) > o->find.reach) return;
    for (i = 0; i < 2; i++) bent += fabs(centre[i] - 2 * (double)half->sensor[i] + (double)edge->sensor[i]);
    o->curved = lflare__max(o->curved, bent / o->pixel);
}

static double lflare__outline_area(const double *a, const double *b, const double *c) { return 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])); }

/* Areas of a sector's triangles on the sensor, between centre, half way and edge; notes whether their signs differ. */
static double lflare__outline_sector(lflare__outliner *o, const double *centre, double (*last)[2], double (*now)[2], double *sign)
{
    double parts[3], area = 0;
    int32_t i;
    parts[0] = lflare__outline_area(centre, last[0], now[0]);
    parts[1] = lflare__outline_area(last[0], last[1], now[0]);
    parts[2] = lflare__outline_area(now[0], last[1], now[1]);
    for (i = 0; i < 3; i++) {
        if (parts[i] * *sign < 0) o->turned = 1;
        if (parts[i] != 0) *sign = parts[i];
        area += fabs(parts[i]);
    }
    return area;
}

static void lflare__outline_knot(lflare__outliner *o, float *out)
{
    double centre[2], rim[2] = {0, 0}, last[2][2] = {{0, 0}, {0, 0}}, now[2][2], area = 0, entrance = 0, lo, hi, up = 0, first = 0, sign = 0, most, least, brighter[LFLARE_WAVELENGTHS] = {1, 1, 1};
    lflare__outline_side sides[LFLARE_OUTLINE_SIDES];
    lflare__traced_ray ray, half, edge;
    int32_t d, k;
    o->apart = o->curved = o->bulged = 0;
    o->turned = 0;
    lflare__outline_ray(o, 0, 0, &ray);
    lflare__outline_sides(o, sides);
    lo = hi = centre[0] = (double)ray.sensor[0];
    centre[1] = 0;
    for (d = 0; d < LFLARE_OUTLINE_SIDES; d++) {
        double u, v, outer, inner;
        float *side = out + LFLARE__OUTLINE_WHOLE + 4 * d;
        lflare__outline_direction(d, &u, &v);
        lflare__outline_store(o, d, &sides[d], &outer, &inner);
        lflare__outline_ray(o, 0.5 * outer * u, 0.5 * outer * v, &half);
        lflare__outline_ray(o, outer * u, outer * v, &edge);
        if (o->matching && d % 4 == 0 && half.arrives) lflare__outline_match(o, 0.5 * outer * u, 0.5 * outer * v, &half, &most, &least, NULL);
        for (k = 0; k < 2; k++) {
            now[0][k] = (double)half.sensor[k];
            now[1][k] = (double)edge.sensor[k];
        }
        side[0] = (float)outer;
        side[1] = (float)inner;
        side[2] = (float)(outer > 0 ? 2 * hypot(now[1][0] - now[0][0], now[1][1] - now[0][1]) : 0);
        side[3] = (float)lflare__outline_lamp(o, &edge);
        lflare__outline_measure(o, centre, &half, &edge);
        lo = lflare__min(lo, lflare__min(now[0][0], now[1][0]));
        hi = lflare__max(hi, lflare__max(now[0][0], now[1][0]));
        up = lflare__max(up, lflare__max(fabs(now[0][1]), fabs(now[1][1])));
        if (d == 0) first = now[1][0];
        if (d > 0) {
            lflare__outline_bulge(o, rim, outer * u, outer * v, last, now);
            area += lflare__outline_sector(o, centre, last, now, &sign);
            entrance += outer * (double)side[-4] * o->half[0] * o->half[1] * 0.5 * sin(LFLARE__PI / (LFLARE_OUTLINE_SIDES - 1));
        }
        memcpy(last, now, sizeof last);
        rim[0] = outer * u;
        rim[1] = outer * v;
    }
    out[0] = (float)o->middle;
    out[1] = (float)o->half[0];
    out[2] = (float)o->half[1];
    out[3] = (float)(o->bend * o->half[1] * o->half[1]);
    for (d = 0; d < o->tracer.count; d++)
        if (lflare__step_is_iris(o->tracer.steps + d * LFLARE_STEP_FLOATS)) out[4] = (float)o->lamps[d];
    out[5] = (float)sqrt(2 * area / LFLARE__PI);
    out[6] = (float)sqrt(2 * entrance / LFLARE__PI);
    out[7] = first >= last[1][0] ? 1.0f : -1.0f;
    out[8] = (float)(0.5 * (lo + hi));
    out[9] = (float)hypot(0.5 * (hi - lo), up);
    out[10] = (float)centre[0];
    out[14] = (float)(0.5 * (hi - lo));
    if (o->matching && ray.arrives) lflare__outline_match(o, 0, 0, &ray, &most, &least, brighter);
    out[12] = (float)brighter[0];
    out[13] = (float)brighter[2];
}

/* Blur of the image of each step's rim, mm on the sensor per radian of the lamp's size (P 3). */
static void lflare__outline_lamps(lflare__outliner *o, const lflare_lens *lens, lflare_pair pair, const double *n, const float *head)
{
    double m11 = (double)head[6], m12 = (double)head[7];
    lflare__walk walk;
    lflare_crossing at;
    int32_t step = 0;
    lflare__walk_start(&walk, lens, n, pair);
    while (lflare__walk_next(&walk, &at) && step < LFLARE_MAX_STEPS)
        o->lamps[step++] = lflare__min(fabs(m12 - m11 * at.b / (fabs(at.a) > 1e-9 ? at.a : 1e-9)), 10 * fabs(m12) + lens->sensor_width);
}

static double lflare__outline_slope(int32_t knot, float hidden) { return tan((double)lflare__knot_angle(knot, hidden, LFLARE_OUTLINE_KNOTS) * (knot == LFLARE_OUTLINE_KNOTS - 1 ? 0.99999 : 1)); }

/* A shut knot: the outline of the nearest open one, about where the least is missing. */
static void lflare__outline_shut(float *knots, const int *open, const float *middles)
{
    int32_t i, j;
    for (j = 0; j < LFLARE_OUTLINE_KNOTS; j++) {
        int32_t nearest = -1;
        for (i = 0; i < LFLARE_OUTLINE_KNOTS && !open[j]; i++)
            if (open[i] && (nearest < 0 || abs(i - j) < abs(nearest - j))) nearest = i;
        if (nearest < 0) continue;
        memcpy(knots + j * LFLARE__OUTLINE_KNOT, knots + nearest * LFLARE__OUTLINE_KNOT, sizeof(float) * LFLARE__OUTLINE_KNOT);
        knots[j * LFLARE__OUTLINE_KNOT] = middles[j];
    }
}

/* The middle wavelength's outline at all knots. */
static void lflare__outline_middle(lflare__outliner *o, float hidden, float *knots, lflare__outline_plan *p)
{
    float middles[LFLARE_OUTLINE_KNOTS];
    int32_t j;
    o->find.lead = 1;
    o->matching = 1;
    for (j = 0; j < LFLARE_OUTLINE_KNOTS; j++) {
        o->slope = lflare__outline_slope(j, hidden);
        p->open[j] = lflare__outline_place(o);
        middles[j] = (float)o->middle;
        p->apart[j] = HUGE_VAL; /* of shut ones nothing is known */
        p->bounds[j][0] = HUGE_VAL;
        p->bounds[j][1] = -HUGE_VAL;
        if (!p->open[j]) continue;
        p->width[1][j] = o->half[0];
        lflare__outline_knot(o, knots + j * LFLARE__OUTLINE_KNOT);
        p->narrow[j] = o->open < LFLARE__OUTLINE_NARROW;
        p->hides[j] = o->hides || lflare__outline_parts(o);
        p->apart[j] = o->apart;
        p->curved[j] = o->curved;
        p->bulged[j] = o->bulged;
        p->turned[j] = o->turned;
    }
    lflare__outline_shut(knots, p->open, middles);
}

/* The leading wavelength's alone, at the knots where meshes are split; the middle one's stays matched to the others where it is not
   split on both sides. */
static void lflare__outline_alone(lflare__outliner *o, float hidden, const float *middle, const lflare__outline_plan *p, float *knots)
{
    int32_t j;
    o->matching = 0;
    for (j = 0; j < LFLARE_OUTLINE_KNOTS; j++) {
        float *knot = knots + j * LFLARE__OUTLINE_KNOT;
        const float *like = middle + j * LFLARE__OUTLINE_KNOT;
        int before = j > 0 && p->split[j - 1], behind = j + 1 < LFLARE_OUTLINE_KNOTS && p->split[j], ends = j == 0 || j + 1 == LFLARE_OUTLINE_KNOTS;
        if (like == knot ? before + behind + ends < 2 : !before && !behind) continue;
        o->slope = lflare__outline_slope(j, hidden);
        if (lflare__outline_place(o)) lflare__outline_knot(o, knot);
        else if (like != knot) memcpy(knot, like, sizeof(float) * LFLARE__OUTLINE_KNOT);
        if (like != knot) memcpy(knot + 16, like + 16, sizeof(float) * 4);
    }
}

/* Whether what is open grows or falls up to the next knot by much more than next to it: linear interpolation would not do. Towards
   where they hide outlines shrink evenly. */
static int lflare__outline_jumps(const double *width, int32_t knot)
{
    double fall = width[knot] - width[knot + 1], before = knot > 0 ? fabs(width[knot - 1] - width[knot]) : 0;
    double behind = knot + 2 < LFLARE_OUTLINE_KNOTS ? fabs(width[knot + 1] - width[knot + 2]) : 0;
    if (!(width[knot] > 0) || !(width[knot + 1] > 0)) return 0;
    return fall < -0.15 * width[knot] || (fall > 0.3 * width[knot] && fall > 2.5 * lflare__max(before, behind));
}

/* What is open up to the next knot, if it is ragged, has its ellipse: measured like an outline. 0 if it is not. */
static int lflare__outline_ragged(lflare__outliner *o, float hidden, lflare__outline_plan *p, int32_t knot, float *out)
{
    float unused[LFLARE__OUTLINE_KNOT], radius[2];
    int32_t i;
    int32_t k;
    int more = p->hides[knot] || p->hides[knot + 1], ragged = p->narrow[knot] || p->narrow[knot + 1];
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) more |= lflare__outline_jumps(p->width[k], knot);
    ragged |= o->tracer.t->wavelength_count > 0 && p->split[knot]; /* one ellipse for all wavelengths */
    if (!ragged && !more) return 0;
    for (i = knot; i <= knot + 1; i++) {
        o->slope = lflare__outline_slope(i, hidden);
        for (o->find.lead = 0; o->find.lead < LFLARE_WAVELENGTHS; o->find.lead++)
            if ((o->find.lead == 1 || p->split[knot]) && !(p->bounded[i] >> (o->find.lead + 3 * more) & 1) && lflare__outline_place(o)) {
                lflare__outline_bounds(o, more, p->bounds[i]);
                p->bounded[i] |= 1 << (o->find.lead + 3 * more);
            }
    }
    o->find.lead = 1;
    lflare__outline_ellipse(o, p, knot);
    o->ragged = 1;
    for (i = knot; i <= knot + 1; i++) {
        o->slope = lflare__outline_slope(i, hidden);
        lflare__outline_knot(o, unused);
        radius[i - knot] = unused[5];
        p->apart[i] = lflare__max(p->apart[i], o->apart);
        p->curved[i] = lflare__max(p->curved[i], o->curved);
        p->bulged[i] = lflare__max(p->bulged[i], o->bulged);
        p->turned[i] |= o->turned;
    }
    o->ragged = 0;
    out[16] = (float)o->middle;
    out[17] = (float)o->half[0];
    out[18] = (float)o->half[1];
    out[15] = 0.5f * (radius[0] + radius[1]);
    return 1;
}

/* Whether wavelengths have meshes of their own up to the next knot. */
static int lflare__outline_splits(const lflare__outliner *o, const lflare__outline_plan *p, int32_t knot)
{
    return p->turned[knot] || p->turned[knot + 1] || p->apart[knot] > o->most_apart || p->apart[knot + 1] > o->most_apart;
}

/* How wide the outer wavelengths are open, and whether they hide, where they have. */
static void lflare__outline_look(lflare__outliner *o, float hidden, lflare__outline_plan *p)
{
    lflare__outline_side sides[LFLARE_OUTLINE_SIDES];
    int32_t j;
    o->matching = 0;
    for (j = 0; j < LFLARE_OUTLINE_KNOTS - 1; j++) p->split[j] = lflare__outline_splits(o, p, j);
    for (o->find.lead = 0; o->find.lead < LFLARE_WAVELENGTHS; o->find.lead += 2)
        for (j = 0; j < LFLARE_OUTLINE_KNOTS; j++) {
            if (!p->split[j] && (j == 0 || !p->split[j - 1])) continue;
            o->slope = lflare__outline_slope(j, hidden);
            if (!lflare__outline_place(o)) continue;
            p->width[o->find.lead][j] = o->half[0];
            lflare__outline_sides(o, sides);
            p->hides[j] |= o->hides || lflare__outline_parts(o);
        }
    o->find.lead = 1;
    o->matching = 1;
}

/* The meshes between knots. Returns whether any is split. */
static int lflare__outline_codes(lflare__outliner *o, float hidden, lflare__outline_plan *p, float *knots)
{
    int32_t j, i, level;
    int any = 0;
    lflare__outline_look(o, hidden, p);
    for (j = 0; j < LFLARE_OUTLINE_KNOTS - 1; j++) {
        float *knot = knots + j * LFLARE__OUTLINE_KNOT;
        int ragged = lflare__outline_ragged(o, hidden, p, j, knot), turned = p->turned[j] || p->turned[j + 1], fine;
        int32_t most = ragged ? 2 : 0;
        p->split[j] = lflare__outline_splits(o, p, j);
        for (i = j; i <= j + 1; i++) {
            double curved = p->curved[i];
            for (level = 0; level < 3 && curved > (turned || ragged ? 3 : 10); level++) curved /= 4;
            most = level > most ? level : most;
        }
        fine = lflare__max(p->bulged[j], p->bulged[j + 1]) > (turned || ragged ? 0.2 : 0.5);
        knot[11] = (float)lflare__mesh_code(most, fine, p->split[j], ragged);
        any |= p->split[j];
    }
    return any;
}

/* Where the ghost is hidden to all wavelengths. */
static float lflare__outline_hidden(lflare__outliner *o)
{
    double hidden = lflare__find_hidden(&o->find), x, step;
    for (o->find.lead = 0; o->find.lead < LFLARE_WAVELENGTHS && hidden > 0; o->find.lead += 2)
        for (step = 0.002; step < 0.3 && hidden < 1.3 && lflare__least_closed(&o->find, tan(hidden + step), 1, &x) <= 1; step *= 2) hidden += step;
    o->find.lead = 1;
    return (float)hidden;
}

static void lflare__outliner_make(const lflare_lens *lens, lflare_tables *t, int32_t g, const double n[][LFLARE_MAX_SURFACES + 1], lflare__outliner *o)
{
    lflare__steps_make(lens, t, g, n);
    lflare__tracer_make(t, g, &o->tracer);
    o->find.lens = lens;
    o->find.tracer = &o->tracer;
    o->find.iris = (double)t->iris.radius;
    o->find.reach = LFLARE__FIT_REACH * lflare__max(lens->sensor_width, lens->sensor_height);
    o->find.lead = 1;
    o->inscribed = (double)lflare__iris_inscribed(&t->iris);
    o->pixel = lens->sensor_width / 1280;
    o->most_apart = t->wavelength_count > 0 ? LFLARE__OUTLINE_ENDS_APART : LFLARE__OUTLINE_APART;
    o->ragged = o->matching = 0;
    lflare__outline_lamps(o, lens, t->pairs[g], n[1], t->head + (size_t)g * LFLARE_HEAD_FLOATS);
}

/* W of many wavelengths along the middle one's ray through (u, v). 0 if it does not arrive. */
static int lflare__spectrum_weights(lflare__outliner *o, double u, double v, float *weights)
{
    lflare__traced_ray ray;
    double x, y;
    int32_t i;
    lflare__outline_at(o, u, v, &x, &y);
    o->tracer.slope = (float)o->slope;
    for (i = 0; i < o->tracer.t->wavelength_count; i++) weights[i] = 1;
    o->tracer.many = weights;
    lflare__traced_ray_make(&o->tracer, lflare__shares[1], 0, (float)x, (float)y, &ray);
    o->tracer.many = NULL;
    return ray.arrives;
}

/* How much brighter the outer of the three known wavelengths' maps make them about the centre than the middle one's. */
static void lflare__spectrum_brighter(lflare__outliner *o, double *brighter)
{
    const float *ends[LFLARE_WAVELENGTHS];
    double most, least;
    lflare__traced_ray ray;
    int32_t k;
    memcpy(ends, o->tracer.ends, sizeof ends);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) o->tracer.ends[k] = lflare__shares[k], brighter[k] = 1;
    lflare__outline_closed(o, 1, 0, 0, &ray);
    if (ray.arrives) lflare__outline_match(o, 0, 0, &ray, &most, &least, brighter);
    memcpy(o->tracer.ends, ends, sizeof ends);
}

/* One field angle's rows of colours: parabolas through four rays. */
static void lflare__spectrum_knot(lflare__outliner *o, int split, float *rows)
{
    static const double places[4][2] = {{0, 0}, {-0.7, 0}, {0.7, 0}, {0, 0.7}};
    const lflare_tables *t = o->tracer.t;
    float w[4][LFLARE_MAX_WAVELENGTHS + 1], *row = rows + 4;
    double brighter[LFLARE_WAVELENGTHS] = {1, 1, 1};
    int32_t i, j, k;
    rows[0] = (float)o->middle;
    for (k = 0; k < 2; k++) rows[1 + k] = (float)o->half[k];
    for (j = 0; j < 4; j++)
        if (!lflare__spectrum_weights(o, places[j][0], places[j][1], w[j]) && j > 0) memcpy(w[j], w[0], sizeof w[0]);
    if (!split) lflare__spectrum_brighter(o, brighter);
    for (i = 0; i < t->wavelength_count; i++, row += 4) {
        const float *s = t->spectral[i];
        float like = 1;
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) like += s[k] * (float)(brighter[k] - 1);
        like = lflare__minf(lflare__maxf(like, 0.3f), 3);
        row[0] = like * w[0][i];
        row[1] = like * (w[2][i] - w[1][i]) / 1.4f;
        row[2] = like * (0.5f * (w[1][i] + w[2][i]) - w[0][i]) / 0.49f;
        row[3] = like * (w[3][i] - w[0][i]) / 0.49f;
        for (k = 0; k < 3; k++)
            for (j = 0; j < 4; j++) rows[4 * (LFLARE_SPECTRUM_ROWS - 3 + k) + j] += s[4 + k] * row[j];
    }
}

/* A ghost's colours, hidden from a field angle on; split: a bit for each knot where wavelengths have meshes of their own, with their own maps. */
static void lflare__spectrum_ghost(const lflare_lens *lens, lflare_tables *t, int32_t g, const double n[][LFLARE_MAX_SURFACES + 1], float hidden, int32_t split)
{
    float *rows = t->spectrum + (size_t)g * LFLARE_OUTLINE_KNOTS * LFLARE_SPECTRUM_ROWS * 4;
    lflare__outliner o;
    int32_t j;
    memset(rows, 0, sizeof(float) * LFLARE_OUTLINE_KNOTS * LFLARE_SPECTRUM_ROWS * 4);
    if (!(hidden > 0)) return;
    lflare__outliner_make(lens, t, g, n, &o);
    for (j = 0; j < LFLARE_OUTLINE_KNOTS; j++, rows += LFLARE_SPECTRUM_ROWS * 4) {
        o.slope = lflare__outline_slope(j, hidden);
        if (!lflare__outline_place(&o) && j > 0) { /* shut: what the last one lets through, moved on */
            memcpy(rows, rows - LFLARE_SPECTRUM_ROWS * 4, sizeof(float) * LFLARE_SPECTRUM_ROWS * 4);
            rows[0] = (float)o.middle;
        } else {
            lflare__spectrum_knot(&o, split >> j & 1, rows);
        }
    }
}

/* Half way between two knots what is open may end farther out than half way between their outlines, then both grow by as much; or farther in than
   all should be open, then both have that end earlier. */
static void lflare__outline_between(lflare__outliner *o, float hidden, int32_t knot, float *a)
{
    float *b = a + LFLARE__OUTLINE_KNOT;
    double u[LFLARE_OUTLINE_SIDES], v[LFLARE_OUTLINE_SIDES], edges[LFLARE_OUTLINE_SIDES];
    int32_t d, k;
    o->slope = tan((double)lflare__knot_angle(2 * knot + 1, hidden, 2 * LFLARE_OUTLINE_KNOTS - 1));
    o->middle = 0.5 * (double)(a[0] + b[0]);
    for (k = 0; k < 2; k++) o->half[k] = 0.5 * (double)(a[1 + k] + b[1 + k]);
    o->bend = 0.5 * (double)(a[3] + b[3]) / (o->half[1] * o->half[1]);
    o->open = lflare__outline_open(o, 0, 0);
    lflare__outline_edges(o, u, v, edges);
    for (d = 0; d < LFLARE_OUTLINE_SIDES; d++) {
        float *from = a + LFLARE__OUTLINE_WHOLE + 4 * d, *to = b + LFLARE__OUTLINE_WHOLE + 4 * d, outer = 0.5f * (from[0] + to[0]), rate = 0.5f * (from[2] + to[2]);
        float more = lflare__minf((float)edges[d] - outer, 0.5f), less;
        if (!(from[0] > 0) || !(to[0] > 0)) continue;
        for (k = 0; k < 2 && more * rate > outer * (float)o->pixel; k++) {
            float *side = k == 0 ? from : to, grows = 1 + more / side[0];
            side[0] *= grows;
            side[1] /= grows;
            side[2] *= grows;
        }
        less = 0.5f * (from[1] + to[1]) - (float)edges[d] / (0.5f * (from[0] + to[0]));
        for (k = 0; k < 2 && less > 0; k++) {
            float *side = k == 0 ? from : to;
            side[1] = lflare__maxf(side[1] - less, 0);
        }
    }
}

static void lflare__outline_ghost(const lflare_lens *lens, lflare_tables *t, int32_t g, const double n[][LFLARE_MAX_SURFACES + 1])
{
    float *all = t->outline + (size_t)g * LFLARE_OUTLINE_FLOATS, *middle = all + LFLARE__OUTLINE_ONE + LFLARE__OUTLINE_HEAD, hidden;
    const float *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    lflare__outliner o;
    lflare__outline_plan p;
    int32_t k, j;
    int any;
    memset(all, 0, sizeof(float) * LFLARE_OUTLINE_FLOATS);
    memset(&p, 0, sizeof p);
    lflare__outliner_make(lens, t, g, n, &o);
    hidden = lflare__outline_hidden(&o);
    if (!(hidden > 0)) return;
    o.ragged = 0;
    lflare__outline_middle(&o, hidden, middle, &p);
    any = lflare__outline_codes(&o, hidden, &p, middle) && t->wavelength_count == 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        float *one = all + k * LFLARE__OUTLINE_ONE;
        if (k != 1 && !any) continue;
        o.find.lead = k;
        lflare__outline_alone(&o, hidden, middle, &p, one + LFLARE__OUTLINE_HEAD);
        for (j = 0; j + 1 < LFLARE_OUTLINE_KNOTS; j++)
            if ((k == 1 || p.split[j]) && p.open[j] && p.open[j + 1] && !((int32_t)middle[j * LFLARE__OUTLINE_KNOT + 11] & 256))
                lflare__outline_between(&o, hidden, j, one + LFLARE__OUTLINE_HEAD + j * LFLARE__OUTLINE_KNOT);
        one[0] = hidden;
        one[1] = 0.61e-6f * t->wavelengths[k] * head[4 * k + 3];
    }
}

/* The mesh's code for a field angle; *knot: the one before. 0 where the ghost is hidden. */
static int32_t lflare__outline_code(const lflare_tables *t, uint32_t g, float angle, int32_t *knot)
{
    const float *head = t->outline + (size_t)g * LFLARE_OUTLINE_FLOATS + LFLARE__OUTLINE_ONE;
    if (!(angle < head[0])) return 0;
    *knot = (int32_t)lflare__minf(lflare__knot_of(angle, head[0], LFLARE_OUTLINE_KNOTS), LFLARE_OUTLINE_KNOTS - 2);
    return (int32_t)head[LFLARE__OUTLINE_HEAD + *knot * LFLARE__OUTLINE_KNOT + 11];
}

/* A bit for each knot next to which meshes are split. */
static int32_t lflare__outline_split(const lflare_tables *t, int32_t g)
{
    const float *knots = t->outline + (size_t)g * LFLARE_OUTLINE_FLOATS + LFLARE__OUTLINE_ONE + LFLARE__OUTLINE_HEAD;
    int32_t j, bits = 0;
    for (j = 0; j < LFLARE_OUTLINE_KNOTS - 1; j++)
        if ((int32_t)knots[j * LFLARE__OUTLINE_KNOT + 11] & 128) bits |= 3 << j;
    return bits;
}

/* lflare__cull_ghost for a traced one. */
static void lflare__outline_cull(lflare_tables *t, int32_t g)
{
    const float *all = t->outline + (size_t)g * LFLARE_OUTLINE_FLOATS, *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    lflare_cull *cull = &t->cull[g];
    float along = 0, weight = 0, reach = 0, hidden = all[LFLARE__OUTLINE_ONE];
    int32_t i;
    cull->patches = 0;
    if (!(hidden > 0)) { /* nothing passes */
        t->rank[g * 2] = 0;
        return;
    }
    for (i = 0; i < LFLARE_WAVELENGTHS * LFLARE_OUTLINE_KNOTS; i++) {
        const float *knot = all + i / LFLARE_OUTLINE_KNOTS * LFLARE__OUTLINE_ONE + LFLARE__OUTLINE_HEAD + i % LFLARE_OUTLINE_KNOTS * LFLARE__OUTLINE_KNOT;
        float u = tanf(lflare__knot_angle(i % LFLARE_OUTLINE_KNOTS, hidden, LFLARE_OUTLINE_KNOTS));
        int32_t patches = lflare__code_patches(t, (int32_t)knot[11]);
        if (!(knot[1] > 0)) continue; /* not filled in */
        if (patches > cull->patches) cull->patches = (uint16_t)patches;
        along += knot[8] * u;
        weight += u * u;
        reach = lflare__maxf(reach, knot[4]);
    }
    along /= weight;
    cull->radius = 0;
    for (i = 0; i < LFLARE_WAVELENGTHS * LFLARE_OUTLINE_KNOTS; i++) {
        const float *knot = all + i / LFLARE_OUTLINE_KNOTS * LFLARE__OUTLINE_ONE + LFLARE__OUTLINE_HEAD + i % LFLARE_OUTLINE_KNOTS * LFLARE__OUTLINE_KNOT;
        if (knot[1] > 0) cull->radius = lflare__maxf(cull->radius, 1.2f * knot[9] + fabsf(knot[8] - along * tanf(lflare__knot_angle(i % LFLARE_OUTLINE_KNOTS, hidden, LFLARE_OUTLINE_KNOTS))));
    }
    if (style[3] != 1) cull->radius *= 1 + 2 * style[3];
    cull->radius += fabsf(style[8]) + fabsf(style[9]); /* wherever the light is */
    cull->along = along + style[4] * t->efl;
    cull->reach = 3 * reach * lflare__maxf(style[3], 1);
    cull->hidden_slope = tanf(hidden);
}

#endif /* LFLARE_NO_TRACE */

#ifdef LFLARE__PATCHES
LFLARE_API size_t lflare_tables_demand(lflare_tables *t, const lflare_settings *s, float *memory)
{
    size_t outlines = 0, steps = 0, spectra = 0, films = 0;
#ifndef LFLARE_NO_TRACE
    if (s->wavelengths > LFLARE_WAVELENGTHS) {
        spectra = (size_t)t->ghost_count * LFLARE_OUTLINE_KNOTS * LFLARE_SPECTRUM_ROWS * 4;
        films = (size_t)t->surface_count * LFLARE_FILM_SAMPLES * (LFLARE_MAX_WAVELENGTHS + 1);
    }
    if (s->model == LFLARE_MODEL_TRACED) outlines = (size_t)t->ghost_count * LFLARE_OUTLINE_FLOATS;
    if (outlines + spectra > 0) steps = (size_t)lflare__steps_of(t) * LFLARE_STEP_FLOATS;
#endif
    if (memory != NULL) {
        t->outline = outlines > 0 ? memory : NULL;
        t->steps = memory + outlines;
        t->spectrum = spectra > 0 ? memory + outlines + steps : NULL;
        t->films = memory + outlines + steps + spectra;
    }
    (void)s;
    return outlines + steps + spectra + films;
}
#endif

LFLARE_API lflare_tables_size lflare_tables_layout(const lflare_lens *lens, const void *fit, void *lens_memory, void *settings_memory, lflare_tables *t)
{
    const size_t f = sizeof(float), ghosts = (size_t)lens->ghost_count, surfaces = (size_t)lens->surface_count;
    lflare_tables_size size;
    static const double *const nm = lflare__rgb_nm;
    size_t arrays[11];
    int32_t i;
    t->ghost_count = lens->ghost_count;
    t->fit = (const uint8_t *)fit;
    t->mesh_head = t->mesh = t->outline = t->steps = t->spectrum = t->films = NULL;
    t->mesh_texels = lflare__mesh_layout(t);
    arrays[0] = ghosts * sizeof(lflare_pair);
    arrays[1] = ghosts * LFLARE_HEAD_FLOATS * f;
    arrays[2] = ghosts * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS * f;
    arrays[3] = surfaces * LFLARE_FILM_SAMPLES * 4 * f;
#ifndef LFLARE_NO_DIFFRACTION
    arrays[4] = ((surfaces + 1) * 4 + LFLARE_RINGING_FLOATS) * f;
#else
    arrays[4] = (surfaces + 1) * 4 * f;
#endif
#ifndef LFLARE_NO_TRACE
    arrays[4] += surfaces * LFLARE_SURFACE_FLOATS * f;
#endif
    arrays[5] = ghosts * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS * f;
    arrays[6] = ghosts * LFLARE_STYLE_FLOATS * f;
    arrays[7] = ghosts * 2 * f;
    arrays[8] = ghosts * sizeof(lflare_cull);
    arrays[9] = t->fit != NULL ? ghosts * LFLARE_MESH_HEAD_FLOATS * f : 0;
    arrays[10] = (t->mesh_texels + LFLARE__MESH_ROW - 1) / LFLARE__MESH_ROW * LFLARE__MESH_ROW * 4 * f;
    size.lens = size.settings = 0;
    for (i = 0; i < 11; i++) {
        size_t bytes = (arrays[i] + 15) & ~(size_t)15;
        if (i < 5) size.lens += bytes;
        else size.settings += bytes;
    }
    if (lens_memory != NULL) {
        char *at = (char *)lens_memory;
        t->pairs = (lflare_pair *)lflare__carve(&at, arrays[0]);
        t->head = (float *)lflare__carve(&at, arrays[1]);
        t->rims = (float *)lflare__carve(&at, arrays[2]);
        t->film = (float *)lflare__carve(&at, arrays[3]);
        t->index = (float *)lflare__carve(&at, arrays[4]);
        t->transmission = t->index + surfaces * 4;
#ifndef LFLARE_NO_TRACE
        t->surface = t->transmission;
        t->transmission += surfaces * LFLARE_SURFACE_FLOATS;
#endif
#ifndef LFLARE_NO_DIFFRACTION
        t->ringing = t->transmission + 4;
#else
        t->ringing = NULL;
#endif
    }
    if (settings_memory != NULL) {
        char *at = (char *)settings_memory;
        t->field = (float *)lflare__carve(&at, arrays[5]);
        t->style = (float *)lflare__carve(&at, arrays[6]);
        t->rank = (float *)lflare__carve(&at, arrays[7]);
        t->cull = (lflare_cull *)lflare__carve(&at, arrays[8]);
        if (t->fit != NULL) {
            t->mesh_head = (float *)lflare__carve(&at, arrays[9]);
            t->mesh = (float *)lflare__carve(&at, arrays[10]);
            lflare__mesh_layout(t);
        }
    }
    t->surface_count = lens->surface_count;
    t->stop = lens->stop;
#ifndef LFLARE_NO_TRACE
    t->sensor_z = 0;
    for (i = 0; i < lens->surface_count; i++) t->sensor_z += (float)lens->prescription.surfaces[i].thickness;
#endif
    t->sensor_width = (float)lens->sensor_width;
    t->sensor_height = (float)lens->sensor_height;
    t->efl = (float)lens->efl;
    t->entrance_radius = (float)lens->prescription.surfaces[0].semi_diameter;
    for (i = 0; i < LFLARE_WAVELENGTHS; i++) t->wavelengths[i] = (float)nm[i];
    return size;
}

/* Keeps the pupil, the iris at every crossing and each rim that does not wholly hold another circle for all slopes up to u_max, with a
   little to spare for dispersion. Holding is transitive, so one pass does it. Returns how many, their places in `keep`. */
static int32_t lflare__drop_holders(const lflare__rims *rims, int32_t count, double u_max, int32_t stop, int32_t *keep)
{
    const lflare_circle *c = rims->circles;
    double lo[LFLARE_MAX_CIRCLES], hi[LFLARE_MAX_CIRCLES]; /* a circle holds another if its interval at u_max does */
    int32_t i, k, kept = 2;
    keep[0] = 0;
    keep[1] = 1;
    for (i = 0; i < count; i++) {
        lo[i] = c[i].centre * u_max - c[i].radius;
        hi[i] = c[i].centre * u_max + c[i].radius;
    }
    for (i = 2; i < count; i++) {
        double least = lo[i] + 0.003 * c[i].radius, most = hi[i] - 0.003 * c[i].radius;
        for (k = 0; k < count && !(lo[k] > least && hi[k] < most); k++) {}
        if (k == count || (LFLARE__MORE_PATHS && rims->surface[i] == stop)) keep[kept++] = i;
    }
    return kept;
}

/* Which circles bind (1) or come within `margin` (of the smaller of circle and pupil) of it (0 to 1, the nearer the more): a circle
   binds if it comes near a corner of the intersection, since seen from its centre the farthest point of each stretch is one of its ends.
   With no stretches (n == 0) a point is left, at `middle`. */
static void lflare__near(const lflare_circle *c, int32_t count, double u, double margin, const lflare__stretch *s, int32_t n, double middle, double *out)
{
    int32_t i, k;
    double x[LFLARE_MAX_CIRCLES + 1], y2[LFLARE_MAX_CIRCLES + 1];
    for (i = 0; i <= n; i++) {
        const lflare_circle *on = &c[n > 0 ? s[i < n ? i : n - 1].circle : 0];
        double t;
        x[i] = n == 0 ? middle : i < n ? s[i].from : s[n - 1].to;
        t = x[i] - on->centre * u;
        y2[i] = n == 0 ? 0 : lflare__max((on->radius - t) * (on->radius + t), 0);
    }
    for (k = 0; k < count; k++) {
        double room = margin * lflare__min(c[k].radius, c[0].radius), limit = c[k].radius - room, far2 = 0;
        for (i = 0; i <= n; i++) {
            double dx = x[i] - c[k].centre * u;
            far2 = lflare__max(far2, dx * dx + y2[i]);
        }
        out[k] = far2 > limit * limit ? (sqrt(far2) - limit) / room : 0;
    }
}

/* How long a stretch of an outline is. */
static double lflare__stretch_length(const lflare_circle *c, const lflare__stretch *s, double u)
{
    double t0 = s->from - c[s->circle].centre * u, t1 = s->to - c[s->circle].centre * u, r = c[s->circle].radius;
    return hypot(t1 - t0, lflare__chord(r, t1) - lflare__chord(r, t0));
}

/* Which rims bind anywhere in the field at any wavelength, iris open: a circle needless beside the open iris is needless
   beside a smaller one. At most LFLARE_MAX_RIMS are kept, those with most of the outline, and the iris wherever else the path crosses it:
   there it may bind once it closes. */
static int32_t lflare__choose_rims(const lflare__rims *rims, int32_t count, int32_t stop, int32_t *chosen)
{
    enum { SAMPLES = 32 }; /* next to where a ghost is hidden rims take turns quickly */
    int32_t keep[LFLARE_MAX_CIRCLES], pair[2], kept, i, j, k, used = 0;
    double outline[LFLARE_MAX_CIRCLES], near[LFLARE_MAX_CIRCLES], u_max = 60;
    for (i = 1; i < count; i++) /* pairs with the pupil or the iris: enough for a bound */
        for (k = 0; k < 2 && k < i; k++) u_max = lflare__part(&rims[1].circles[i], &rims[1].circles[k], u_max);
    kept = lflare__drop_holders(&rims[1], count, 1.02 * u_max, stop, keep);
    for (i = 0; i < kept; i++) outline[i] = LFLARE__MORE_PATHS && i > 1 && rims[1].surface[keep[i]] == stop ? 1000 : 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        lflare_circle c[LFLARE_MAX_CIRCLES];
        double hidden, lo, hi;
        for (i = 0; i < kept; i++) c[i] = rims[k].circles[keep[i]];
        hidden = lflare__hidden_slope(c, kept, pair);
        outline[pair[0]] = outline[pair[1]] = 1000; /* the two that part first shut the ghost, however little of its outline they have */
        for (j = 1; j <= SAMPLES; j += k == 1 ? 1 : 3) { /* the other wavelengths differ little */
            lflare__stretch stretches[LFLARE_MAX_CIRCLES];
            double u = hidden * (j - 0.25) / (double)SAMPLES;
            int32_t n = lflare__envelope(c, kept, u, stretches, &lo, &hi);
            for (i = 0; i < n; i++) outline[stretches[i].circle] += lflare__stretch_length(c, &stretches[i], u) / (hi - lo);
            if (k != 1) continue;
            lflare__near(c, kept, u, 0.03, stretches, n, 0.5 * (lo + hi), near);
            for (i = 0; i < kept; i++)
                if (near[i] > 0) outline[i] += 1e-7; /* may bind between samples */
        }
    }
    while (used < LFLARE_MAX_RIMS) {
        int32_t best = 2;
        for (i = 2; i < kept; i++)
            if (outline[i] > outline[best]) best = i;
        if (best >= kept || !(outline[best] > 0)) break;
        chosen[used++] = keep[best];
        outline[best] = 0;
    }
    return used;
}

/* For the tables: lenses with gaps of kilometres make numbers beyond float, of ghosts too faint to see. */
static float lflare__single(double v) { return (float)lflare__clamp(v, -1e15, 1e15); }

static void lflare__prepare_ghost(const lflare_lens *lens, lflare_tables *t, int32_t g, const double n[][LFLARE_MAX_SURFACES + 1])
{
    lflare__rims rims[LFLARE_WAVELENGTHS];
    int32_t chosen[LFLARE_MAX_RIMS], count = 0, used, k, i;
    float *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    float *out = t->rims + (size_t)g * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        count = lflare__collect_rims(lens, n[k], t->pairs[g], lens->prescription.surfaces[lens->stop].semi_diameter, &rims[k]);
        head[k * 4] = lflare__single(rims[k].a[1]);
        head[k * 4 + 1] = lflare__single(rims[k].b[1]);
        head[k * 4 + 2] = lflare__single(rims[k].m.a);
        head[k * 4 + 3] = lflare__single(rims[k].m.b);
    }
    used = lflare__choose_rims(rims, count, lens->stop, chosen);
    memset(out, 0, sizeof(float) * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS);
    for (i = 0; i < used; i++)
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
            float *rim = out + i * LFLARE_RIM_FLOATS + k * 4;
            rim[0] = lflare__single(rims[k].a[chosen[i]]);
            rim[1] = lflare__single(rims[k].b[chosen[i]]);
            rim[3] = (float)rims[k].surface[chosen[i]];
            rim[2] = LFLARE__MORE_PATHS && rims[k].surface[chosen[i]] == lens->stop ? 0 : (float)lens->prescription.surfaces[rims[k].surface[chosen[i]]].semi_diameter;
        }
    head[12] = (float)(t->pairs[g].first + LFLARE_MAX_SURFACES * t->pairs[g].third);
    head[13] = (float)(t->pairs[g].second + LFLARE_MAX_SURFACES * t->pairs[g].fourth);
    head[14] = (float)used;
#ifdef LFLARE_NO_TRACE
    head[15] = 0;
#endif
}

#ifndef LFLARE_NO_TRACE
static void lflare__prepare_surface(const lflare_lens *lens, lflare_tables *t, int32_t i, double z)
{
    const lflare_surface *s = &lens->prescription.surfaces[i];
    float *row = t->surface + i * LFLARE_SURFACE_FLOATS;
    double term = 1;
    int32_t j;
    row[0] = (float)z;
    row[1] = s->radius != 0 ? (float)(1 / s->radius) : 0;
    row[2] = (float)s->semi_diameter;
    row[3] = (float)(1 + s->conic);
    for (j = 0; j < 8; j++) {
        term *= s->semi_diameter * s->semi_diameter;
        row[4 + j] = lflare__single(s->aspheric[j] * term);
    }
}
#endif

LFLARE_API lflare_result lflare_tables_prepare(const lflare_lens *lens, lflare_tables *t, int32_t begin, int32_t end)
{
    double n[LFLARE_WAVELENGTHS][LFLARE_MAX_SURFACES + 1];
#ifndef LFLARE_NO_TRACE
    double z = 0;
#endif
    int32_t g, i, k, count;
    if (lens == NULL || t == NULL || begin < 0 || end > t->ghost_count || t->head == NULL) return LFLARE_ERROR_ARGUMENT;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) lflare__indices(&lens->prescription, lflare__rgb_nm[k], n[k]);
    if (begin == 0) {
        lflare_layer scratch[LFLARE_MAX_LAYERS];
        count = t->ghost_count;
        lflare_ghost_list(lens, t->pairs, &count);
#ifndef LFLARE_NO_TRACE
        for (g = 0, i = 0; g < count; g++) {
            t->head[(size_t)g * LFLARE_HEAD_FLOATS + 15] = (float)i;
            i += lflare__step_count(t, t->pairs[g]);
        }
#endif
#ifndef LFLARE_NO_DIFFRACTION
        lflare_ringing_make(t->ringing);
#endif
        for (i = 0; i < lens->surface_count; i++) {
            lflare__film_row(lens, i, scratch, t->film + (size_t)i * LFLARE_FILM_SAMPLES * 4);
            for (k = 0; k < LFLARE_WAVELENGTHS; k++) t->index[i * 4 + k] = (float)n[k][i + 1];
            t->index[i * 4 + 3] = 0;
#ifndef LFLARE_NO_TRACE
            lflare__prepare_surface(lens, t, i, z);
            z += lens->prescription.surfaces[i].thickness;
#endif
            for (k = 0; k < LFLARE_WAVELENGTHS; k++)
                t->transmission[k] = (i == 0 ? 1 : t->transmission[k]) * (i == lens->stop ? 1 : 1 - t->film[((size_t)i * LFLARE_FILM_SAMPLES + LFLARE_FILM_SAMPLES - 1) * 4 + (size_t)k]);
        }
    }
    for (g = begin; g < end; g++) lflare__prepare_ghost(lens, t, g, (const double(*)[LFLARE_MAX_SURFACES + 1])n);
    return LFLARE_OK;
}

/* What a path does to light: per crossing the tangent of incidence |p x + q u|, and where to look the film up. */
typedef struct lflare__bounce {
    float p, q, n2, rarer; /* n_in^2; 1 / n_rarer^2 */
    const float *film;
    int32_t reflected;
} lflare__bounce;

static int32_t lflare__bounces(const lflare_lens *lens, const lflare_tables *t, lflare_pair pair, const double *n, lflare__bounce *out)
{
    lflare__walk walk;
    lflare_crossing x;
    int32_t count = 0;
    lflare__walk_start(&walk, lens, n, pair);
    while (lflare__walk_next(&walk, &x)) {
        lflare__bounce *b = &out[count];
        double rarer = lflare__min(x.n_in, x.n_out);
        if (x.n_in == x.n_out && lens->prescription.surfaces[x.surface].coating == LFLARE_COATING_NONE) continue;
        if (x.surface == lens->stop) continue;
        b->p = (float)x.p;
        b->q = (float)x.q;
        b->n2 = (float)(x.n_in * x.n_in);
        b->rarer = (float)(1 / (rarer * rarer));
        b->film = t->film + (size_t)x.surface * LFLARE_FILM_SAMPLES * 4;
        b->reflected = x.reflected;
        count++;
    }
    return count;
}

/* W of P 3 along the paraxial ray from entrance point x with slope u. */
static float lflare__weight(const lflare__bounce *b, int32_t count, int32_t k, float x, float u)
{
    float w = 1;
    int32_t i;
    for (i = 0; i < count; i++) {
        float tangent = b[i].p * x + b[i].q * u, t2 = tangent * tangent;
        float cos2 = 1 - b[i].n2 * b[i].rarer * t2 / (1 + t2);
        float r = lflare__film_lookup(b[i].film, k, cos2 > 0 ? sqrtf(cos2) : 0);
        w *= b[i].reflected ? r : 1 - r;
    }
    return w;
}

/* Of a row of rims: the iris once more, whose radius the settings know. */
static int lflare__rim_is_stop(const float *rim) { return LFLARE__MORE_PATHS && rim[2] == 0; }

/* Circles of a ghost from the tables, at one wavelength: pupil, iris, rims. */
static int32_t lflare__table_circles(const lflare_tables *t, int32_t g, int32_t k, double iris, int paper, lflare_circle *out)
{
    const float *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    const float *rims = t->rims + (size_t)g * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS + k * 4;
    double entrance = (double)t->entrance_radius;
    int32_t i, count = paper ? 0 : (int32_t)head[14];
    out[0].centre = 0;
    out[0].radius = entrance;
    out[1] = lflare__circle((double)head[k * 4], (double)head[k * 4 + 1], iris, entrance);
    for (i = 0; i < count; i++, rims += LFLARE_RIM_FLOATS) out[2 + i] = lflare__circle((double)rims[0], (double)rims[1], lflare__rim_is_stop(rims) ? iris : (double)rims[2], entrance);
    return 2 + count;
}

/* Surfaces count from 1, and 0 0 stay 0 0: no third reflection is at the first surface. */
static int lflare__overrides(const lflare_override *o, lflare_pair pair)
{
    int32_t one = pair.third > 0;
    if (!LFLARE__MORE_PATHS) return o->first == pair.first + 1 && o->second == pair.second + 1;
    return o->first == pair.first + 1 && o->second == pair.second + 1 && o->third == pair.third + one && o->fourth == pair.fourth + one;
}

LFLARE_API lflare_result lflare_tables_configure_begin(const lflare_lens *lens, lflare_tables *t, const lflare_settings *s, lflare_error *error)
{
    double fnumber = 0;
    int32_t i, k;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (lens == NULL || t == NULL || s == NULL || t->field == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no lens, tables or settings given");
    if (!lflare__finite(s->fnumber) || s->fnumber < 0 || s->fnumber > 1e6)
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "f-number %g: give a positive number, or 0 for the lens's own", s->fnumber);
    if (s->override_count < 0 || (s->override_count > 0 && s->overrides == NULL)) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no overrides given");
    if (!(fabsf(s->exposure_ev) <= 60) || !(s->min_flux >= 0 && s->min_flux <= 1) || !(s->imperfection >= 0 && s->imperfection <= 0.1f) || s->ghost_budget < 0 || s->vertex_budget < 0 || s->pixel_budget < 0)
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "exposure_ev is -60 to 60, min_flux 0 to 1, imperfection 0 to 0.1, budgets are 0 or more");
    for (i = 0; i < s->override_count; i++) {
        const lflare_override *o = &s->overrides[i];
        for (k = 0; k < t->ghost_count && !lflare__overrides(o, t->pairs[k]); k++) {}
        if (k == t->ghost_count)
            return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, LFLARE__MORE_PATHS && (o->third != 0 || o->fourth != 0) ? "override %i: the lens has no ghost (%i,%i,%i,%i)" : "override %i: the lens has no ghost (%i,%i)",
                                i, o->first, o->second, o->third, o->fourth);
        if (!lflare__finite3(o->tint) || !(fabsf(o->ev) <= 60) || !(o->scale >= 0 && o->scale <= 1000) || !(fabsf(o->move[0]) <= 1000) || !(fabsf(o->move[1]) <= 1000))
            return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "override %i of ghost (%i,%i): a number is out of range", i, o->first, o->second);
        if (o->ramp_count < 0 || o->ramp_count > LFLARE_RAMP_STOPS)
            return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "override %i of ghost (%i,%i): a ramp has up to 8 stops", i, o->first, o->second);
        for (k = 0; k < o->ramp_count; k++)
            if (!lflare__finite3(o->ramp[k].rgb) || !(fabsf(o->ramp[k].angle) <= 2) || (k > 0 && !(o->ramp[k].angle > o->ramp[k - 1].angle)))
                return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "override %i of ghost (%i,%i): stops are numbers, their angles rise", i, o->first, o->second);
    }
    if ((int)s->model < 0 || s->model > LFLARE_MODEL_TRACED || (s->model == LFLARE_MODEL_TRACED ? t->outline : s->model == LFLARE_MODEL_POLYNOMIAL ? t->mesh : t->field) == NULL)
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "the polynomial model needs a fit, the traced one its room");
    if (lflare_iris_make(lens, s->fnumber, s->blades, (double)s->blade_rotation, (double)s->blade_curvature, &t->iris, &fnumber) != LFLARE_OK)
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "the iris has 0 or 3 to 16 blades, curvature 0 to 1");
    if (!(s->iris_softness >= 0 && s->iris_softness <= 0.5f) || !(s->starburst_scale >= 0 && s->starburst_scale <= 1000) || !(fabsf(s->starburst_ev) <= 60) ||
        !(s->streak.share >= 0 && s->streak.share <= 1) || !(s->streak.length >= 0 && s->streak.length <= 100) || !(s->streak.thickness >= 0 && s->streak.thickness <= 100) ||
        !lflare__finite3(s->streak.tint))
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "iris_softness is 0 to 0.5, starburst_scale 0 to 1000, starburst_ev -60 to 60; a streak's share 0 to 1, its sizes 0 to 100");
#ifndef LFLARE_NO_TRACE
    if (s->wavelengths != 0 && (s->wavelengths < LFLARE_WAVELENGTHS || s->wavelengths > LFLARE_MAX_WAVELENGTHS))
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "%i wavelengths: give 3 to 32, or 0", s->wavelengths);
#endif
    t->iris.softness = s->iris_softness;
    t->fringes = t->ringing != NULL && !s->no_ringing;
    t->starburst = NULL;
    t->starburst_unit = 0.5f * 550e-6f * t->efl * (float)fabs(lens->stop_a11) / t->iris.radius * (s->starburst_scale > 0 ? s->starburst_scale : 1);
#ifdef LFLARE__PATCHES
    t->model = s->model != LFLARE_MODEL_AUTO ? s->model : t->mesh != NULL ? LFLARE_MODEL_POLYNOMIAL : LFLARE_MODEL_PARAXIAL;
    t->wavelength_count = 0;
#ifndef LFLARE_NO_TRACE
    lflare__spectral_make(t, t->model != LFLARE_MODEL_PARAXIAL && t->spectrum != NULL ? s->wavelengths : 0);
    lflare__films_make(lens, t);
#endif
#else
    t->model = LFLARE_MODEL_PARAXIAL;
#endif
    t->fnumber = (float)fnumber;
    t->ghost_budget = s->ghost_budget;
    t->vertex_budget = s->vertex_budget;
    t->pixel_budget = s->pixel_budget;
    return LFLARE_OK;
}

/* -1 to 1, from a seed and two numbers: two rounds of a mixer of 32 bits. */
static float lflare__noise(uint32_t seed, int32_t a, int32_t b)
{
    uint32_t x = seed * 2654435761u + (uint32_t)a * 2246822519u + (uint32_t)b * 3266489917u + 374761393u;
    int32_t i;
    for (i = 0; i < 2; i++) {
        x = (x ^ x >> 15) * 2246822519u;
        x = (x ^ x >> 13) * 3266489917u;
    }
    return (float)(x >> 8) / 8388608.0f - 1;
}

/* How far elements that stand off the axis move a ghost, mm on the sensor. A surface shifted by d bends every ray by -C d more than a centred one,
   C being its power (P 2), which the rest of the path, M of P 2 after it, turns into a move by its B: the same for all rays and field angles to first
   order. (The part that grows with the slope is of third order, and left out.) Surfaces with glass or cement between them move together. */
static void lflare__shift(const lflare_lens *lens, const lflare_tables *t, int32_t g, const lflare_settings *s, const double *n, float *out)
{
    const float *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    lflare__walk walk;
    lflare_crossing x;
    int32_t i, element;
    lflare__walk_start(&walk, lens, n, t->pairs[g]);
    while (lflare__walk_next(&walk, &x)) {
        double c = x.backwards ? -lens->curvature[x.surface] : lens->curvature[x.surface], after = (double)head[7] * x.a - (double)head[6] * x.b;
        double moved = x.reflected ? -2 * c * x.n_in * after : -c * (x.n_in - x.n_out) * after;
        for (element = x.surface; element > 0 && n[element] > 1.001; element--) {}
        for (i = 0; i < 2; i++)
            out[i] = lflare__single((double)out[i] + moved * (double)(s->imperfection * lflare__noise(s->imperfection_seed, element, i)) * lens->prescription.surfaces[element].semi_diameter);
    }
}

/* The tint of a style at a field angle. */
LFLARE__APART static void lflare__style_tint(const float *style, float angle, float *out)
{
    const float *a = style + 12;
    int32_t k, left = (int32_t)style[10] - 1;
    for (k = 0; k < 3; k++) out[k] = style[k];
    if (left < 0) return;
    while (left > 1 && angle > a[7]) {
        a += 4;
        left--;
    }
    for (k = 0; k < 3; k++) out[k] *= left > 0 ? a[k] + lflare__minf(lflare__maxf((angle - a[3]) / (a[7] - a[3]), 0), 1) * (a[k + 4] - a[k]) : a[k];
}

static void lflare__style_ghost(const lflare_lens *lens, lflare_tables *t, int32_t g, const lflare_settings *s, const double *n, double hidden_slope)
{
    float *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    float angle = (float)atan(hidden_slope);
    int32_t i, k;
    memset(style, 0, sizeof(float) * LFLARE_STYLE_FLOATS);
    for (k = 0; k < 4; k++) style[k] = 1;
    if (s->imperfection > 0) lflare__shift(lens, t, g, s, n, style + 8);
    style[6] = angle;
    style[7] = 1 / lflare__maxf(angle, 1e-30f);
    for (i = 0; i < s->override_count; i++) {
        const lflare_override *o = &s->overrides[i];
        int tinted = o->tint[0] != 0 || o->tint[1] != 0 || o->tint[2] != 0;
        if (!lflare__overrides(o, t->pairs[g])) continue;
        for (k = 0; k < 3; k++) style[k] *= o->hide ? 0 : (tinted ? lflare__maxf(o->tint[k], 0) : 1) * exp2f(o->ev);
        if (o->scale > 0) style[3] *= o->scale;
        style[4] += o->move[0];
        style[5] += o->move[1];
        if (o->ramp_count == 0) continue;
        style[10] = (float)o->ramp_count;
        memcpy(style + 12, o->ramp, sizeof o->ramp);
        for (k = 0; k < 4 * LFLARE_RAMP_STOPS; k++)
            if (k % 4 < 3) style[12 + k] = lflare__maxf(style[12 + k], 0);
    }
}

/* Bounding disc on the sensor: the image of the pupil or of the iris, whichever is smaller, at all wavelengths. */
static void lflare__cull_ghost(lflare_tables *t, int32_t g, double hidden_slope)
{
    const float *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS, *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    const float *field = t->field + (size_t)g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS;
    lflare_cull *cull = &t->cull[g];
    double centre[LFLARE_WAVELENGTHS], radius[LFLARE_WAVELENGTHS], reach = 0;
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        double ma11 = (double)head[k * 4], ma12 = (double)head[k * 4 + 1], m11 = (double)head[k * 4 + 2], m12 = (double)head[k * 4 + 3];
        double pupil = fabs(m11) * (double)t->entrance_radius, iris = fabs(ma11) > 1e-9 ? fabs(m11 / ma11) * (double)t->iris.radius : HUGE_VAL;
        centre[k] = iris < pupil ? m12 - m11 * ma12 / ma11 : m12;
        radius[k] = lflare__min(iris, pupil) + 4 * 0.61e-6 * (double)t->wavelengths[k] * fabs(m12) / lflare__max((double)field[4], 1e-6);
        reach = lflare__max(reach, lflare__max(fabs(m12), fabs(centre[k])));
    }
    cull->radius = 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++)
        cull->radius = lflare__maxf(cull->radius, (float)(radius[k] + fabs(centre[k] - centre[1]) * hidden_slope));
    if (style[3] != 1) cull->radius *= 1 + 2 * style[3];
    cull->radius += fabsf(style[8]) + fabsf(style[9]); /* wherever the light is */
    cull->along = (float)centre[1] + style[4] * t->efl;
    cull->across = style[5] * t->efl;
    cull->reach = (float)(3 * reach) * lflare__maxf(style[3], 1);
    cull->hidden_slope = (float)hidden_slope;
    cull->ghost = (uint32_t)g;
    cull->patches = 1;
}

#ifndef LFLARE_NO_ABERRATION
/* The same of a mesh. */
static void lflare__mesh_cull(lflare_tables *t, int32_t g)
{
    const float *head = t->mesh_head + (size_t)g * LFLARE_MESH_HEAD_FLOATS, *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    const float *first = t->mesh + 4 * (size_t)head[0];
    lflare_cull *cull = &t->cull[g];
    float along = 0, weight = 0, reach = 0;
    int32_t j, knots = lflare__mesh_knots((int32_t)head[5] & 8), count = knots * (int32_t)head[6];
    cull->patches = 0;
    if (!(head[6] > 0)) { /* exact rays say that nothing passes */
        t->rank[g * 2] = 0;
        return;
    }
    for (j = 0; j < count; j++) {
        const float *knot = first + (size_t)j * 4 * (size_t)head[7];
        float u = tanf(lflare__knot_angle(j % knots, head[4], knots));
        along += knot[4] * u;
        weight += u * u;
        reach = lflare__maxf(reach, knot[1]);
    }
    along /= weight;
    cull->radius = 0;
    for (j = 0; j < count; j++) {
        const float *knot = first + (size_t)j * 4 * (size_t)head[7];
        cull->radius = lflare__maxf(cull->radius, 1.1f * knot[5] + fabsf(knot[4] - along * tanf(lflare__knot_angle(j % knots, head[4], knots))));
    }
    if (style[3] != 1) cull->radius *= 1 + 2 * style[3];
    cull->radius += fabsf(style[8]) + fabsf(style[9]); /* wherever the light is */
    cull->along = along + style[4] * t->efl;
    cull->reach = 3 * reach * lflare__maxf(style[3], 1);
    cull->hidden_slope = tanf(head[4]);
    cull->patches = (uint16_t)(lflare__meshes(t, head[6] > 1) * (int32_t)(head[1] / 4) * (int32_t)(head[2] / 4));
}

#endif /* LFLARE_NO_ABERRATION */

/* A ghost's circles at all wavelengths: see lflare__table_circles. */
typedef struct lflare__circles {
    lflare_circle at[LFLARE_WAVELENGTHS][2 + LFLARE_MAX_RIMS];
    int32_t count;
} lflare__circles;

/* Rims this far from binding, in radii, are looked at: they may cut the light of parts of a lamp. */
#define LFLARE__BINDING_NEAR 0.3

/* How much of the outline each circle makes at slope u, over the outline's extent, at all wavelengths together. Those that nearly bind count a
   little, for soft edges: the more, the nearer they come. */
static void lflare__binding_shares(const lflare__circles *c, double u, double *share)
{
    int32_t k, i;
    for (i = 0; i < c->count; i++) share[i] = 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        lflare__stretch stretches[LFLARE_MAX_CIRCLES];
        double near[LFLARE_MAX_CIRCLES], lo, hi;
        int32_t n = lflare__envelope(c->at[k], c->count, u, stretches, &lo, &hi);
        for (i = 0; i < n; i++) share[stretches[i].circle] += lflare__stretch_length(c->at[k], &stretches[i], u) / (hi - lo);
        lflare__near(c->at[k], c->count, u, LFLARE__BINDING_NEAR, stretches, n, 0.5 * (lo + hi), near);
        for (i = 0; i < c->count; i++) share[i] += 1e-6 * near[i];
    }
}

/* Bits of the circles that bind between two samples of the field, given their shares at both: bit 0 the pupil, then the rims. A footprint has room
   for LFLARE_MAX_EDGES - 1 beside the iris: those with most of the outline. Rims much alike, of which one hides the others, leave room so. */
static int32_t lflare__binding(const double *first, const double *second, int32_t count)
{
    int32_t chosen = 2, room, k; /* the iris is no matter of choice */
    for (room = LFLARE_MAX_EDGES - 1; room > 0; room--) {
        double most = 0;
        int32_t best = 1;
        for (k = 0; k < count; k++)
            if (!(chosen >> k & 1) && first[k] + second[k] > most) {
                most = first[k] + second[k];
                best = k;
            }
        chosen |= 1 << best;
    }
    return (chosen & 1) | (chosen >> 1 & ~1);
}

/* Geometry of the field's samples, at the middle wavelength but for what binds. */
static void lflare__configure_shape(lflare_tables *t, int32_t g, const lflare__circles *c, double hidden)
{
    float *sample = t->field + (size_t)g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS;
    double m11 = (double)t->head[(size_t)g * LFLARE_HEAD_FLOATS + 6], m12 = (double)t->head[(size_t)g * LFLARE_HEAD_FLOATS + 7];
    double turn[2 + LFLARE_MAX_RIMS], shares[2][2 + LFLARE_MAX_RIMS];
    int32_t j, i;
    for (j = 0; j < LFLARE_FIELD_SAMPLES; j++, sample += LFLARE_FIELD_FLOATS) {
        double u = j + 1 < LFLARE_FIELD_SAMPLES ? tan(atan(hidden) * j / (LFLARE_FIELD_SAMPLES - 1)) : hidden, turn0 = 0, turn2 = 0;
        lflare_region region = lflare_region_of(c->at[1], c->count, u, turn);
        region.area *= 1 - turn[1] / (2 * LFLARE__PI) * (1 - (double)t->iris.area);
        for (i = 0; i < c->count; i++) {
            double shift = m12 + m11 * c->at[1][i].centre, share = 0.5 * turn[i] * (i == 1 ? (double)t->iris.roundness : 1);
            turn0 += share;
            turn2 += share * shift * shift;
        }
        sample[3] = (float)region.centroid;
        sample[4] = (float)sqrt(region.area / LFLARE__PI);
        sample[5] = (float)turn0;
        sample[6] = (float)lflare__min(turn2, 1e30);
        lflare__binding_shares(c, u, shares[j & 1]);
        if (j > 0) sample[7 - LFLARE_FIELD_FLOATS] = (float)lflare__binding(shares[0], shares[1], c->count);
        sample[7] = 0; /* at the last one the ghost is hidden */
    }
}

static void lflare__configure_ghost(const lflare_lens *lens, lflare_tables *t, const lflare_settings *s, int32_t g,
                                    const double n[][LFLARE_MAX_SURFACES + 1])
{
    double m11 = (double)t->head[(size_t)g * LFLARE_HEAD_FLOATS + 6], hidden = 0;
    float *field = t->field + (size_t)g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS;
    lflare__bounce bounces[LFLARE_MAX_CIRCLES];
    lflare__circles c;
    int32_t pair[2], j, k;
    float peak = 0, mean = 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        c.count = lflare__table_circles(t, g, k, (double)t->iris.radius, s->paper_clipping, c.at[k]);
        hidden = lflare__max(hidden, lflare__hidden_slope(c.at[k], c.count, pair));
    }
    lflare__style_ghost(lens, t, g, s, n[1], hidden);
    lflare__configure_shape(t, g, &c, hidden);
    {   /* for the exposure: as if at f/8, whatever the iris is, so that stopping down does not brighten the picture */
        double u = 0.25 * lens->sensor_width / lens->efl, area, frame = lens->sensor_width * lens->sensor_height;
        double iris = fabs(lens->stop_a11) * lens->efl / (2 * lflare__max((double)LFLARE_NORMAL_FNUMBER, lens->fnumber));
        lflare_circle normal[2 + LFLARE_MAX_RIMS];
        int32_t count = lflare__table_circles(t, g, 1, iris, s->paper_clipping, normal);
        area = lflare_region_of(normal, count, u, NULL).area;
        mean = (float)(area / lflare__max(frame, area * m11 * m11));
    }
    {
        float reference = lflare__minf((float)atan(0.25 * lens->sensor_width / lens->efl), (float)atan(hidden)), weight = 0;
        int32_t at = (int32_t)(reference / (float)atan(hidden) * (LFLARE_FIELD_SAMPLES - 1));
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
            int32_t bounce_count = lflare__bounces(lens, t, t->pairs[g], n[k], bounces);
            for (j = 0; j < LFLARE_FIELD_SAMPLES; j++) { /* each wavelength along the ray through its own footprint's centroid */
                double u = j + 1 < LFLARE_FIELD_SAMPLES ? tan(atan(hidden) * j / (LFLARE_FIELD_SAMPLES - 1)) : hidden;
                float x = k == 1 ? field[j * LFLARE_FIELD_FLOATS + 3] : (float)lflare_region_of(c.at[k], c.count, u, NULL).centroid;
                field[j * LFLARE_FIELD_FLOATS + k] = lflare__weight(bounces, bounce_count, k, x, (float)u);
            }
            weight += field[at * LFLARE_FIELD_FLOATS + k] / (float)LFLARE_WAVELENGTHS;
        }
        mean *= weight;
    }
    for (j = 0; j < LFLARE_FIELD_SAMPLES; j++) {
        const float *sample = field + j * LFLARE_FIELD_FLOATS;
        float tint[3];
        lflare__style_tint(t->style + (size_t)g * LFLARE_STYLE_FLOATS, (float)(atan(hidden) * j / (LFLARE_FIELD_SAMPLES - 1)), tint);
        peak = lflare__maxf(peak, (sample[0] * tint[0] + sample[1] * tint[1] + sample[2] * tint[2]) * sample[4] * sample[4]);
    }
    t->rank[g * 2] = peak;
    t->rank[g * 2 + 1] = mean;
    lflare__cull_ghost(t, g, hidden);
#ifndef LFLARE_NO_ABERRATION
    if (t->model == LFLARE_MODEL_POLYNOMIAL) {
        lflare__mesh_ghost(lens, t, g);
        lflare__mesh_cull(t, g);
#ifndef LFLARE_NO_TRACE
        if (t->wavelength_count > 0) lflare__spectrum_ghost(lens, t, g, n, t->mesh_head[(size_t)g * LFLARE_MESH_HEAD_FLOATS + 4], t->mesh_head[(size_t)g * LFLARE_MESH_HEAD_FLOATS + 6] > 1 ? -1 : 0);
#endif
    }
#endif
#ifndef LFLARE_NO_TRACE
    if (t->model == LFLARE_MODEL_TRACED) {
        lflare__outline_ghost(lens, t, g, n);
        lflare__outline_cull(t, g);
        if (t->wavelength_count > 0) lflare__spectrum_ghost(lens, t, g, n, t->outline[(size_t)g * LFLARE_OUTLINE_FLOATS + LFLARE__OUTLINE_ONE], lflare__outline_split(t, g));
    }
#endif
}

LFLARE_API void lflare_tables_configure_range(const lflare_lens *lens, lflare_tables *t, const lflare_settings *s, int32_t begin, int32_t end)
{
    double n[LFLARE_WAVELENGTHS][LFLARE_MAX_SURFACES + 1];
    int32_t g, k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) lflare__indices(&lens->prescription, lflare__rgb_nm[k], n[k]);
    for (g = begin; g < end && g < t->ghost_count; g++) lflare__configure_ghost(lens, t, s, g, (const double(*)[LFLARE_MAX_SURFACES + 1])n);
}

/* Heap order by peak flux, ties by index: the same everywhere. */
static int lflare__weaker(const lflare_tables *t, const lflare_cull *a, const lflare_cull *b)
{
    float fa = t->rank[a->ghost * 2], fb = t->rank[b->ghost * 2];
    return fa < fb || (fa == fb && a->ghost > b->ghost);
}

static void lflare__sift(const lflare_tables *t, lflare_cull *heap, int32_t at, int32_t count)
{
    for (;;) {
        int32_t child = 2 * at + 1;
        lflare_cull kept;
        if (child >= count) return;
        if (child + 1 < count && lflare__weaker(t, &heap[child + 1], &heap[child])) child++;
        if (!lflare__weaker(t, &heap[child], &heap[at])) return;
        kept = heap[at];
        heap[at] = heap[child];
        heap[child] = kept;
        at = child;
    }
}

/* The light's own image: all that passes the pupil, but for what surfaces reflect. */
static void lflare__configure_image(lflare_tables *t, const lflare_settings *s)
{
    const lflare_streak *k = &s->streak;
    float scale = s->starburst_scale > 0 ? s->starburst_scale : 1, pupil = 0.5f * 550e-6f * t->efl / t->starburst_unit * scale; /* radius of the entrance pupil */
    int32_t i, tinted = k->tint[0] != 0 || k->tint[1] != 0 || k->tint[2] != 0;
    for (i = 0; i < LFLARE_WAVELENGTHS; i++) {
        float flux = 3.14159265f * pupil * pupil * t->iris.area * t->transmission[i];
        t->starburst_gain[i] = flux * exp2f(s->starburst_ev) / (t->starburst_unit * t->starburst_unit);
        t->streak_gain[i] = flux * k->share * (tinted ? lflare__maxf(k->tint[i], 0) : 1);
    }
    t->streak_half[0] = k->share > 0 ? 0.5f * t->sensor_width * (k->length > 0 ? k->length : 2) : 0;
    t->streak_half[1] = k->share > 0 ? 0.5f * t->sensor_width * (k->thickness > 0 ? k->thickness : 0.004f) : 0;
}

LFLARE_API void lflare_tables_configure_end(lflare_tables *t, const lflare_settings *s)
{
    double flux = 0, mean = 0;
    size_t ghosts;
    int32_t g, n = 0;
    for (g = 0; g < t->ghost_count; g++) {
        flux += (double)t->rank[g * 2];
        mean += (double)t->rank[g * 2 + 1];
    }
    for (g = 0; g < t->ghost_count; g++)
        if (t->rank[g * 2] > 0 && (double)t->rank[g * 2] >= (double)s->min_flux * flux) t->cull[n++] = t->cull[g];
    t->active_count = n;
    for (g = n / 2 - 1; g >= 0; g--) lflare__sift(t, t->cull, g, n);
    for (g = n - 1; g > 0; g--) { /* the weakest goes last */
        lflare_cull weakest = t->cull[0];
        t->cull[0] = t->cull[g];
        t->cull[g] = weakest;
        lflare__sift(t, t->cull, 0, g);
    }
    ghosts = (size_t)t->ghost_count;
    t->lens_hash = lflare__hash(t->head, ghosts * LFLARE_HEAD_FLOATS, t->rims, ghosts * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS);
    t->settings_hash = lflare__hash(t->field, ghosts * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS, t->style, ghosts * LFLARE_STYLE_FLOATS);
    t->mesh_hash = 0;
    t->mask_hash = lflare__mask_hash(&t->iris);
#ifndef LFLARE_NO_ABERRATION
    if (t->model == LFLARE_MODEL_POLYNOMIAL) {
        float iris[2];
        iris[0] = t->iris.radius;
        iris[1] = lflare__iris_inscribed(&t->iris);
        t->mesh_hash = lflare__hash(iris, 2, t->head, ghosts * LFLARE_HEAD_FLOATS) ^ lflare__fit_hash(t->fit);
    }
#endif
#ifndef LFLARE_NO_TRACE
    if (t->model == LFLARE_MODEL_TRACED) t->mesh_hash = lflare__hash(t->outline, ghosts * LFLARE_OUTLINE_FLOATS, t->steps, (size_t)lflare__steps_of(t) * LFLARE_STEP_FLOATS);
#endif
#ifdef LFLARE__PATCHES
    if (t->wavelength_count > 0) t->mesh_hash ^= lflare__hash(t->spectrum, ghosts * LFLARE_OUTLINE_KNOTS * LFLARE_SPECTRUM_ROWS * 4, t->spectral[0], 8);
#endif
    lflare__configure_image(t, s);
    t->mean_irradiance = (float)mean;
    t->exposure = exp2f(s->exposure_ev) * (s->raw || !(mean > 0) ? 1 : (float)((double)LFLARE_NORMAL_MEAN / mean));
}

/* >> 13 frame */

/* Size of the frame on the sensor; how the lens's slope follows from the camera's. */
static float lflare__frame_size(const lflare_tables *t, const lflare_view *v, lflare_frame_data *f)
{
    float w = (float)v->width, h = (float)v->height, tangent = v->fov_y > 0 ? tanf(0.5f * v->fov_y) : 0, squeeze = v->squeeze > 0 ? v->squeeze : 1, half;
    switch (v->fit) {
    case LFLARE_FIT_HEIGHT: half = 0.5f * t->sensor_height; break;
    case LFLARE_FIT_DIAGONAL: half = 0.5f * sqrtf(t->sensor_width * t->sensor_width + t->sensor_height * t->sensor_height) * h / sqrtf(w * w + h * h); break;
    case LFLARE_FIT_PHYSICAL:
        if (tangent > 0) { half = t->efl * tangent; break; }
        /* fall through */
    default: half = 0.5f * t->sensor_width * h / w; break;
    }
    f->half_height = half;
    f->half_width = half * w / h / squeeze;
    f->pixel_size[0] = 2 * f->half_width / w;
    f->pixel_size[1] = 2 * half / h;
    f->pixel = sqrtf(f->pixel_size[0] * f->pixel_size[1]);
    f->centre[0] = v->centre[0] * f->half_width;
    f->centre[1] = v->centre[1] * f->half_height;
    f->width = v->width;
    f->height = v->height;
    return tangent > 0 && v->fit != LFLARE_FIT_PHYSICAL ? half / (t->efl * tangent) : 1;
}

static int lflare__valid_view(const lflare_view *v)
{
    return v != NULL && v->width > 0 && v->height > 0 && v->width <= 1 << 20 && v->height <= 1 << 20 && v->fov_y >= 0 && v->fov_y < 3.1f &&
           (int)v->fit >= 0 && v->fit <= LFLARE_FIT_PHYSICAL && fabsf(v->centre[0]) <= 1000 && fabsf(v->centre[1]) <= 1000 && v->edge_fade >= 0 &&
           (v->squeeze == 0 || (v->squeeze >= 0.125f && v->squeeze <= 8));
}

static int lflare__valid_light(const lflare_light *l)
{
    double sum = 0; /* of floats: does not overflow */
    int32_t k;
    for (k = 0; k < 3; k++) sum += (double)l->direction[k] + (double)l->color[k] + (double)l->occlusion[k];
    return lflare__finite(sum + (double)l->distance) && l->angular_radius >= 0 && l->angular_radius < 1.5f && l->distance >= 0;
}

/* What is left of a light whose image lies beyond the frame's edge. */
static float lflare__edge_fade(const lflare_frame_data *f, float width, const float *image)
{
    float x = lflare__maxf(fabsf(image[0] - f->centre[0]) - f->half_width, 0), y = lflare__maxf(fabsf(image[1] - f->centre[1]) - f->half_height, 0), t;
    if (!(width > 0)) return 1;
    t = lflare__maxf(1 - sqrtf(x * x + y * y) / (width * f->half_height), 0);
    return t * t * (3 - 2 * t);
}

/* The profile's density is a parabola of variance soft^2 / 5; it stands for a pixel of 0.715 on either side (its spectrum
   then vanishes at the pixel grid's frequency) and a lamp's disc of radius b, of variance b^2 / 4. */
#define LFLARE__PIXEL_VARIANCE (0.715f * 0.715f / 5)

#ifndef LFLARE_NO_DIFFRACTION
/* Radius of the disc that stands for lamp and pixel on the sensor, mm: a pixel's is that of a disc of its area. */
static float lflare__image_blur(const lflare_tables *t, const lflare_frame_light *l, float pixel)
{
    float lamp = t->efl * l->angular_radius;
    return sqrtf(lamp * lamp + 0.318f * pixel * pixel);
}
#endif

/* Half of it, of a profile (1 - u^2)^2, whose variance is a seventh of its half width squared. */
static float lflare__streak_thickness(const lflare_tables *t, const lflare_frame_light *l, float pixel)
{
    float lamp = t->efl * l->angular_radius;
    return sqrtf(t->streak_half[1] * t->streak_half[1] + 7 * (LFLARE__PIXEL_VARIANCE * pixel * pixel + 0.25f * lamp * lamp));
}

/* How far a light's starburst and streak are drawn: the first to where all of its angles fall below LFLARE__STARBURST_LEAST of the ghosts'
   mean irradiance, which no exposure for ghosts shows. */
#define LFLARE__STARBURST_LEAST 1e-3f
static void lflare__frame_image(const lflare_tables *t, const lflare_frame_data *f, lflare_frame_light *l)
{
    float x = fabsf(l->image[0] - f->centre[0]) - f->half_width, y = fabsf(l->image[1] - f->centre[1]) - f->half_height;
    float streak = t->streak_half[0] * f->pixel_size[0] / f->pixel_size[1]; /* as long in the view whatever it squeezes */
#ifndef LFLARE_NO_DIFFRACTION
    if (t->starburst != NULL && !(l->flags & LFLARE_LIGHT_NO_STARBURST)) {
        float strongest = 0, unit = t->starburst_unit, far = 4 * (f->half_width + f->half_height) + lflare__maxf(x, 0) + lflare__maxf(y, 0);
        int32_t k;
        for (k = 0; k < LFLARE_WAVELENGTHS; k++) strongest = lflare__maxf(strongest, t->starburst_gain[k] * t->starburst->tail[k]);
        if (t->mean_irradiance > 0)
            far = lflare__minf(far, unit * cbrtf(strongest * t->starburst->peak / (LFLARE__STARBURST_LEAST * t->mean_irradiance)) + 4 * lflare__image_blur(t, l, f->pixel));
        l->starburst = x < far && y < far ? far : 0;
    }
#endif
    if (t->streak_half[0] > 0 && !(l->flags & LFLARE_LIGHT_NO_STREAK) && x < streak && y < lflare__streak_thickness(t, l, f->pixel)) l->streak = streak;
}

/* 0 if the light draws nothing. */
static int lflare__frame_light_make(const lflare_tables *t, const lflare_frame_data *f, const lflare_light *l, float slope_scale, float edge_fade,
                                    lflare_frame_light *out)
{
    float cosine, faded, lit = 0;
    int32_t k;
    if (!(l->direction[2] < 0)) return 0;
    memset(out, 0, sizeof *out);
    for (k = 0; k < 2; k++) out->slope[k] = slope_scale * l->direction[k] / l->direction[2];
    out->slope[0] *= f->pixel_size[0] / f->pixel_size[1];
    out->slope_length = sqrtf(out->slope[0] * out->slope[0] + out->slope[1] * out->slope[1]);
    if (!(out->slope_length < 60)) return 0; /* 89 degrees off the axis */
    out->axis[0] = 1;
    if (out->slope_length > 1e-12f)
        for (k = 0; k < 2; k++) out->axis[k] = out->slope[k] / out->slope_length;
    out->field_angle = atanf(out->slope_length);
    out->angular_radius = l->angular_radius;
    out->flags = l->flags;
    cosine = 1 / sqrtf(1 + out->slope_length * out->slope_length);
    for (k = 0; k < 2; k++) out->image[k] = t->efl * out->slope[k];
    faded = lflare__edge_fade(f, edge_fade, out->image) * cosine * t->exposure;
    for (k = 0; k < 3; k++) {
        float visible = 1 - lflare__minf(lflare__maxf(l->occlusion[k], 0), 1);
        out->irradiance[k] = lflare__maxf(l->color[k], 0) * visible * faded;
        lit += out->irradiance[k];
    }
    lflare__frame_image(t, f, out);
    return lit > 0;
}

/* -- budgets: what ghosts cost -- */

enum {
    LFLARE__GHOST_VERTICES = 52, /* of an undistorted ghost: LFLARE__GL_RING and LFLARE__GL_INSIDE */
    LFLARE__COARSER = 3          /* most levels of density that a mesh gives up */
};

/* What is left of an instance's intensity where a budget fades it out: see lflare_instance. */
static float lflare__instance_share(lflare_instance instance) { return 1 - (float)(instance.band >> 10) / 63; }

/* With neither renderer nor meshes there is nobody whose vertices and fragments these are. */
#if defined(LFLARE__PATCHES) || !defined(LFLARE_NO_SOFTWARE) || !defined(LFLARE_NO_GL)
#define LFLARE__BUDGETS

/* How a budget sees a ghost, or one of its meshes: an ellipse on the sensor with one axis on the line to the light. */
typedef struct lflare__blot {
    float middle;  /* on that line, without the override's move, mm */
    float half[2]; /* along it and across, mm */
    float area;    /* of all that is drawn: a map that folds has more than the ellipse, mm^2 */
} lflare__blot;

/* Twice the signed area of the unit disc within the triangle that its centre makes with p and q. */
static float lflare__disc_triangle(const float *p, const float *q)
{
    float d[2], t[2], ends[4], a, b, c, sum = 0;
    int32_t i;
    for (i = 0; i < 2; i++) d[i] = q[i] - p[i];
    a = d[0] * d[0] + d[1] * d[1];
    b = p[0] * d[0] + p[1] * d[1];
    c = b * b - a * (p[0] * p[0] + p[1] * p[1] - 1);
    if (!(c > 0)) return atan2f(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
    t[0] = lflare__minf(lflare__maxf((-b - sqrtf(c)) / a, 0), 1);
    t[1] = lflare__minf(lflare__maxf((-b + sqrtf(c)) / a, 0), 1);
    for (i = 0; i < 4; i++) ends[i] = p[i % 2] + t[i / 2] * d[i % 2];
    if (t[0] > 0) sum += atan2f(p[0] * ends[1] - p[1] * ends[0], p[0] * ends[0] + p[1] * ends[1]);
    if (t[1] < 1) sum += atan2f(ends[2] * q[1] - ends[3] * q[0], ends[2] * q[0] + ends[3] * q[1]);
    return sum + ends[0] * ends[3] - ends[1] * ends[2];
}

/* Pixels of it within the frame. */
static float lflare__blot_pixels(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, const float *style, const lflare__blot *b)
{
    float at[2], corners[4][2], least[2], most = lflare__maxf(b->half[0], b->half[1]), area = 0;
    int32_t i, inside = 1;
    at[0] = b->middle * l->axis[0] + t->efl * (style[4] * l->slope[0] - style[5] * l->slope[1]) + style[8] - f->centre[0];
    at[1] = b->middle * l->axis[1] + t->efl * (style[4] * l->slope[1] + style[5] * l->slope[0]) + style[9] - f->centre[1];
    least[0] = f->half_width - fabsf(at[0]);
    least[1] = f->half_height - fabsf(at[1]);
    if (least[0] >= most && least[1] >= most) return b->area / (f->pixel * f->pixel);
    if (least[0] <= -most || least[1] <= -most || !(b->half[0] > 0) || !(b->half[1] > 0)) return 0;
    for (i = 0; i < 4; i++) {
        float x = (i == 1 || i == 2 ? f->half_width : -f->half_width) - at[0], y = (i < 2 ? -f->half_height : f->half_height) - at[1];
        corners[i][0] = (x * l->axis[0] + y * l->axis[1]) / b->half[0];
        corners[i][1] = (y * l->axis[0] - x * l->axis[1]) / b->half[1];
        inside &= corners[i][0] * corners[i][0] + corners[i][1] * corners[i][1] <= 1;
    }
    if (inside) area = 8 * f->half_width * f->half_height / (b->half[0] * b->half[1]);
    for (i = 0; i < 4 && !inside; i++) area += lflare__disc_triangle(corners[i], corners[(i + 1) & 3]);
    return lflare__maxf(area, 0) / (2 * (float)LFLARE__PI) * b->area / (f->pixel * f->pixel);
}

/* How far an edge reaches beyond itself, fringes included, mm: lflare__profile_make in another measure. */
static float lflare__blot_edge(const lflare_frame_data *f, float blur, float ring)
{
    float soft = sqrtf(5 * (LFLARE__PIXEL_VARIANCE * f->pixel * f->pixel + 0.25f * blur * blur));
#ifndef LFLARE_NO_DIFFRACTION
    if (LFLARE__RING_WASHED * ring > soft) soft += LFLARE__RING_OUTER * ring;
#endif
    (void)ring;
    return soft;
}

/* An undistorted ghost: discs of the footprints' area about their centroids, an ellipse around those of all wavelengths. */
static float lflare__ghost_pixels(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, int32_t g)
{
    const float *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS, *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    const float *row = t->field + (size_t)g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS;
    float at = lflare__minf(l->field_angle * style[7] * (LFLARE_FIELD_SAMPLES - 1), (float)LFLARE_FIELD_SAMPLES - 1.001f), v[5], ends[2], wide = 0, bright = 0, lamp, edge, corners;
    int by_iris = fabsf(head[4]) * t->entrance_radius > t->iris.radius; /* its image is the smaller one */
    int32_t k;
    lflare__blot b;
    row += (int32_t)at * LFLARE_FIELD_FLOATS;
    at -= (float)(int32_t)at;
    for (k = 0; k < 5; k++) v[k] = row[k] + at * (row[k + LFLARE_FIELD_FLOATS] - row[k]);
    v[4] = lflare__maxf(v[4], 1e-6f * t->entrance_radius);
    ends[0] = 3e38f;
    ends[1] = -3e38f;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) { /* as lflare_footprint_resolve */
        const float *m = head + k * 4;
        float spread = 0.61e-6f * t->wavelengths[k] * m[3] / v[4], disc = l->angular_radius * m[3], middle = m[2] * v[3] + m[3] * l->slope_length;
        float size = lflare__maxf(fabsf(m[2]) * v[4], sqrtf(f->pixel * f->pixel + spread * spread + disc * disc));
        bright = lflare__maxf(bright, v[k] * style[k] * v[4] * v[4] / (size * size));
        size *= style[3];
        ends[0] = lflare__minf(ends[0], middle - size);
        ends[1] = lflare__maxf(ends[1], middle + size);
        wide = lflare__maxf(wide, size);
    }
    lamp = style[3] * (by_iris ? head[7] - head[6] * head[5] / head[4] : head[7]);
    edge = lflare__blot_edge(f, lamp * l->angular_radius, t->fringes && bright >= LFLARE__RING_LEAST * t->mean_irradiance ? style[3] * sqrtf(0.5e-6f * t->wavelengths[1] * fabsf(head[6] * lamp)) : 0);
    if (by_iris) edge += t->iris.softness * wide;
    b.middle = 0.5f * (ends[0] + ends[1]);
    corners = t->iris.blade_count > 0 && by_iris ? 1 : 1.0065f; /* 16 tangents around a disc */
    b.half[0] = corners * (0.5f * (ends[1] - ends[0]) + edge);
    b.half[1] = corners * (wide + edge);
    b.area = (float)LFLARE__PI * b.half[0] * b.half[1];
    return lflare__blot_pixels(t, f, l, style, &b);
}

#ifdef LFLARE__PATCHES
enum { LFLARE__KNOWN_SIDES = 5 };

/* What is known of a mesh as a whole, between two knots. */
typedef struct lflare__mesh_known {
    float middle, bounds, length; /* bounds on the sensor: middle, radius, half of their length */
    float radius, entrance, lamp, diffraction; /* see lflare__patch_grow */
    float beyond;                 /* how much farther than iris and rims it is drawn, a share */
    float whole;                  /* ragged: radius of all that is drawn; else 0 */
    float rate[LFLARE__KNOWN_SIDES], blur[LFLARE__KNOWN_SIDES]; /* in some directions: see lflare__traced_band */
} lflare__mesh_known;

/* How much larger than what iris and rims leave open the area is that edges and fringes fade over, too. */
static float lflare__known_beyond(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, float scale, float shrink, float grown, const lflare__mesh_known *m)
{
    float wave = t->fringes ? 0.5e-6f * sqrtf(t->wavelengths[0] * t->wavelengths[1]) * shrink : 0, sum = 0, all = 0;
    int32_t i;
    for (i = 0; i < LFLARE__KNOWN_SIDES; i++) {
        float blur = scale * lflare__maxf(m->blur[i], fabsf(m->lamp)), rate = lflare__maxf(scale * m->rate[i] + grown, 1.5f * f->pixel);
        float side = 1 + m->beyond + t->iris.softness + 1.1f / rate * lflare__blot_edge(f, blur * l->angular_radius, sqrtf(scale * wave * blur));
        sum += rate * rate * side * side;
        all += rate * rate;
    }
    return sqrtf(sum / all);
}

static float lflare__known_pixels(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, const float *style, const lflare__mesh_known *m)
{
    float entrance = lflare__maxf(m->entrance, 1e-6f), spread = lflare__minf(m->diffraction / entrance, 0.5f * f->half_width), disc = m->lamp * l->angular_radius;
    float least = sqrtf(2.25f * f->pixel * f->pixel + spread * spread + disc * disc), grown = lflare__maxf(least - m->radius, 0), drawn = style[3] * (m->radius + grown);
    float more = m->whole > 0 ? (m->whole + grown) / (m->radius + grown) : lflare__known_beyond(t, f, l, style[3], m->radius / entrance, style[3] * grown, m);
    lflare__blot b;
    int32_t i;
    b.middle = m->middle;
    b.half[0] = more * style[3] * (m->length + grown);
    b.half[1] = more * style[3] * (sqrtf(lflare__maxf(m->bounds * m->bounds - m->length * m->length, 0)) + grown);
    b.area = (float)LFLARE__PI * more * more * drawn * drawn;
    if (m->whole > 0) { /* bounds are those of what is lit, which the mesh goes far beyond: a disc at the least, and once over all of it */
        for (i = 0; i < 2; i++) b.half[i] = lflare__maxf(b.half[i], style[3] * (m->whole + grown));
        b.area = lflare__maxf(b.area, (float)LFLARE__PI * b.half[0] * b.half[1]);
    }
    return lflare__blot_pixels(t, f, l, style, &b);
}
#endif

#ifndef LFLARE_NO_ABERRATION
static float lflare__mesh_pixels(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, int32_t g)
{
    const float *head = t->mesh_head + (size_t)g * LFLARE_MESH_HEAD_FLOATS, *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    int32_t knots = lflare__mesh_knots((int32_t)head[5] & 8), floats = lflare__mesh_floats(head[6] > 1), mesh, first, i;
    float at = lflare__knot_of(l->field_angle, head[4], knots), sum = 0, v[8];
    lflare__mesh_known m;
    first = (int32_t)lflare__minf(at, (float)(knots - 2));
    at -= (float)first;
    for (mesh = 0; mesh < (int32_t)head[6]; mesh++) {
        const float *a = t->mesh + 4 * (size_t)head[0] + (size_t)(mesh * knots + first) * 4 * (size_t)head[7], *b = a + 4 * (size_t)head[7];
        for (i = 0; i < 8; i++) v[i] = a[i] + at * (b[i] - a[i]);
        m.middle = v[4];
        m.bounds = v[5];
        m.length = v[7];
        m.radius = v[0];
        m.entrance = v[2];
        m.lamp = v[1];
        m.diffraction = head[3];
        m.beyond = 0.01f;
        m.whole = 0;
        for (i = 0; i < LFLARE__KNOWN_SIDES; i++) {
            const float *edge = a + 4 * LFLARE__MESH_KNOT_TEXELS + (size_t)(((int32_t)head[2] * ((int32_t)head[1] + 1) + (int32_t)head[1] * i / (LFLARE__KNOWN_SIDES - 1)) * floats);
            m.rate[i] = edge[floats - 1 - ((int32_t)head[1] + 1) * floats];
            m.blur[i] = edge[head[6] > 1 ? 7 : 18];
        }
        sum += lflare__known_pixels(t, f, l, style, &m);
    }
    return sum * (float)lflare__meshes(t, head[6] > 1) / head[6];
}
#endif

#ifndef LFLARE_NO_TRACE
/* code and first: lflare__outline_code's. */
static float lflare__traced_pixels(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, int32_t g, int32_t code, int32_t first)
{
    const float *all = t->outline + (size_t)g * LFLARE_OUTLINE_FLOATS, *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    const float *middle = all + LFLARE__OUTLINE_ONE + LFLARE__OUTLINE_HEAD + first * LFLARE__OUTLINE_KNOT;
    float at = lflare__knot_of(l->field_angle, all[LFLARE__OUTLINE_ONE], LFLARE_OUTLINE_KNOTS) - (float)first, sum = 0, v[15];
    int32_t split = lflare__meshes(t, code & 128) == LFLARE_WAVELENGTHS, k, i; /* of more, the middle one stands for all */
    lflare__mesh_known m;
    for (k = split ? 0 : 1; k < (split ? LFLARE_WAVELENGTHS : 2); k++) {
        const float *head = all + k * LFLARE__OUTLINE_ONE, *a = head + LFLARE__OUTLINE_HEAD + first * LFLARE__OUTLINE_KNOT, *b = a + LFLARE__OUTLINE_KNOT;
        for (i = 4; i < 15; i++) v[i] = a[i] + at * (b[i] - a[i]);
        m.middle = v[8];
        m.bounds = v[9];
        m.length = v[14];
        m.radius = v[5];
        m.entrance = v[6];
        m.lamp = v[4];
        m.diffraction = head[1];
        m.beyond = 0.04f; /* lflare__traced_band's */
        m.whole = code & 256 ? middle[15] : 0;
        for (i = 0; i < LFLARE__KNOWN_SIDES; i++) {
            const float *side = a + LFLARE__OUTLINE_WHOLE + 4 * (i * (LFLARE_OUTLINE_SIDES - 1) / (LFLARE__KNOWN_SIDES - 1));
            m.rate[i] = side[2];
            m.blur[i] = side[3];
        }
        sum += lflare__known_pixels(t, f, l, style, &m);
    }
    return split ? sum : sum * (float)lflare__meshes(t, code & 128);
}
#endif

/* -- budgets: who is drawn -- */

/* A ghost in the frame. */
typedef struct lflare__seen {
    int32_t ghost, patches, each, code, knot; /* vertices of a patch; for traced ghosts what lflare__outline_code says */
} lflare__seen;

/* What the budgets leave to one light's ghosts. */
typedef struct lflare__purse {
    float vertices, pixels, vertex_fade, pixel_fade; /* to spend; over how much ghosts fade out */
    float coarse; /* vertices that those still to come have at the least */
    float gate;   /* what is left of those to come: see lflare__purse_pay */
} lflare__purse;

static float lflare__seen_pixels(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, const lflare__seen *s)
{
#ifndef LFLARE_NO_TRACE
    if (t->model == LFLARE_MODEL_TRACED) return lflare__traced_pixels(t, f, l, s->ghost, s->code, s->knot);
#endif
#ifndef LFLARE_NO_ABERRATION
    if (t->model == LFLARE_MODEL_POLYNOMIAL) return lflare__mesh_pixels(t, f, l, s->ghost);
#endif
    return lflare__ghost_pixels(t, f, l, s->ghost);
}

/* Patches after giving up `levels` of density. */
static int32_t lflare__seen_patches(const lflare_tables *t, const lflare__seen *s, int32_t levels)
{
#ifndef LFLARE_NO_TRACE
    if (s->code > 0) return lflare__code_patches(t, lflare__code_coarser(s->code, levels));
#endif
    (void)t;
    (void)levels;
    return s->patches;
}

/* Whether a ghost that can be seen is drawn: how many patches, *band its instances' bits. Which ghosts are depends on the light's place,
   yet none may pop: the last that fits fades as it gets near the limit, over a twentieth of the budget, and those after one that just
   does not fit fade in as it gets farther from fitting, so that all are at 0 when it changes sides. */
static int32_t lflare__purse_pay(lflare__purse *p, const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, const lflare__seen *s, int32_t *band)
{
    float pixels = t->pixel_budget > 0 ? lflare__seen_pixels(t, f, l, s) : 0, vertices = (float)(s->patches * s->each), room, kept;
    int32_t levels = 0;
    p->coarse -= (float)(lflare__seen_patches(t, s, LFLARE__COARSER) * s->each);
    kept = lflare__minf(lflare__maxf(p->coarse, 0), 0.9f * p->vertices); /* for weaker ones; a tenth of what is left is for this one */
    while (levels < LFLARE__COARSER && vertices > p->vertices - kept) vertices = (float)(lflare__seen_patches(t, s, ++levels) * s->each);
    if (!(p->gate > 0.004f)) return 0;
    room = lflare__minf((p->vertices - vertices) / p->vertex_fade, (p->pixels - pixels) / p->pixel_fade);
    if (!(room > 0)) {
        p->gate *= lflare__minf(-room, 1);
        return 0;
    }
    p->vertices -= vertices;
    p->pixels -= pixels;
    *band |= levels << 8 | (int32_t)(63 * (1 - p->gate * lflare__minf(room, 1))) << 10;
    return lflare__seen_patches(t, s, levels);
}
#else
typedef struct lflare__seen {
    int32_t ghost, patches;
} lflare__seen;
#endif /* LFLARE__BUDGETS */

/* The next ghost of a light from *at on that may be in the frame; 0 if there is none. */
static int lflare__seen_next(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, int32_t *at, lflare__seen *s)
{
    float growth = 4 * f->pixel;
    if (l->flags & LFLARE_LIGHT_NO_GHOSTS) return 0;
    while (*at < t->active_count) {
        const lflare_cull *c = &t->cull[(*at)++];
        float x = l->slope[0] * c->along - l->slope[1] * c->across - f->centre[0];
        float y = l->slope[1] * c->along + l->slope[0] * c->across - f->centre[1];
        float r = c->radius + growth + c->reach * l->angular_radius;
        if (l->slope_length >= c->hidden_slope || fabsf(x) > f->half_width + r || fabsf(y) > f->half_height + r) continue;
        s->ghost = (int32_t)c->ghost;
        s->patches = c->patches;
#ifdef LFLARE__BUDGETS
        s->each = t->model == LFLARE_MODEL_PARAXIAL ? LFLARE__GHOST_VERTICES : LFLARE_PATCH_DIRECTIONS * (LFLARE_PATCH_RINGS + LFLARE_PATCH_BANDS);
        s->code = s->knot = 0;
#endif
#ifndef LFLARE_NO_TRACE
        if (t->model != LFLARE_MODEL_TRACED) return 1;
        s->code = lflare__outline_code(t, c->ghost, l->field_angle, &s->knot);
        s->patches = s->code > 0 ? lflare__code_patches(t, s->code) : 0;
        if (s->patches == 0) continue;
#endif
        return 1;
    }
    return 0;
}

#ifdef LFLARE__BUDGETS
/* Vertices (of the coarsest meshes: `coarse` 1) and pixels of all ghosts of a light that can be seen. */
static void lflare__light_needs(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, int coarse, float *needs)
{
    int32_t at = 0, ghosts = t->ghost_budget > 0 ? t->ghost_budget : t->active_count;
    lflare__seen s;
    needs[0] = needs[1] = 0;
    for (; ghosts > 0 && lflare__seen_next(t, f, l, &at, &s); ghosts--) {
        needs[0] += (float)(lflare__seen_patches(t, &s, coarse ? LFLARE__COARSER : 0) * s.each);
        if (!coarse && t->pixel_budget > 0) needs[1] += lflare__seen_pixels(t, f, l, &s);
    }
}

static float lflare__light_weight(const lflare_frame_light *l) { return l->flags & LFLARE_LIGHT_NO_GHOSTS ? 0 : l->irradiance[0] + l->irradiance[1] + l->irradiance[2]; }

/* A budget over a light's brightness: what lights do not need goes to the others. Needs lie where the lights' images will be. */
static float lflare__budget_share(const lflare_frame_data *f, int32_t which, float budget)
{
    float share = 0, next;
    int32_t i, pass;
    for (pass = 0; pass < 32; pass++) {
        float left = budget, wanting = 0, all = 0, most = 0;
        for (i = 0; i < f->light_count; i++) {
            float weight = lflare__light_weight(&f->lights[i]), need = f->lights[i].image[which];
            if (!(weight > 0)) continue;
            all += weight;
            most = lflare__maxf(most, need / weight);
            if (need <= share * weight) left -= need;
            else wanting += weight;
        }
        next = wanting > 0 ? left / wanting : most + lflare__maxf(left, 0) / lflare__maxf(all, 1e-30f);
        if (!(next > share * 1.00001f)) break;
        share = next;
    }
    return share;
}

/* Shares of both budgets. */
static void lflare__budget_shares(const lflare_tables *t, lflare_frame_data *f, float *shares)
{
    int32_t i, k;
    for (i = 0; i < f->light_count; i++) lflare__light_needs(t, f, &f->lights[i], 0, f->lights[i].image);
    shares[0] = t->vertex_budget > 0 ? lflare__budget_share(f, 0, (float)t->vertex_budget) : 0;
    shares[1] = t->pixel_budget > 0 ? lflare__budget_share(f, 1, (float)t->pixel_budget) : 0;
    for (i = 0; i < f->light_count; i++)
        for (k = 0; k < 2; k++) f->lights[i].image[k] = t->efl * f->lights[i].slope[k];
}

static void lflare__purse_make(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, const float *shares, lflare__purse *p)
{
    float needs[2] = {0, 0}, weight = lflare__light_weight(l);
    if (t->vertex_budget > 0) lflare__light_needs(t, f, l, 1, needs);
    p->vertices = t->vertex_budget > 0 ? shares[0] * weight : 1e30f;
    p->pixels = t->pixel_budget > 0 ? shares[1] * weight : 1e30f;
    p->vertex_fade = lflare__maxf(0.05f * p->vertices, 1e-6f);
    p->pixel_fade = lflare__maxf(0.05f * p->pixels, 1e-6f);
    p->coarse = needs[0];
    p->gate = 1;
}
#endif /* LFLARE__BUDGETS */

/* The instances of one light's ghosts; shares: NULL without budgets. */
static lflare_result lflare__frame_ghosts(const lflare_tables *t, lflare_frame_data *f, int32_t light, const float *shares)
{
    const lflare_frame_light *l = &f->lights[light];
    int32_t budget = t->ghost_budget > 0 ? t->ghost_budget : t->active_count, at = 0, k;
    lflare__seen s;
#ifdef LFLARE__BUDGETS
    lflare__purse purse;
    memset(&purse, 0, sizeof purse);
    if (shares != NULL) lflare__purse_make(t, f, l, shares, &purse);
#endif
    (void)shares;
    while (budget > 0 && lflare__seen_next(t, f, l, &at, &s)) {
        lflare_instance *instance = &f->instances[f->instance_count];
        int32_t patches = s.patches, band = 0;
#ifdef LFLARE__BUDGETS
        band = s.knot;
        if (shares != NULL) patches = lflare__purse_pay(&purse, t, f, l, &s, &band);
#endif
        if (f->instance_capacity - f->instance_count < patches) return LFLARE_ERROR_LIMIT;
        for (k = 0; k < patches; k++, instance++) {
            instance->ghost = (uint16_t)s.ghost;
            instance->light = (uint16_t)light;
            instance->patch = (uint16_t)k;
            instance->band = (uint16_t)band;
        }
        f->instance_count += patches;
        budget -= patches > 0;
    }
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_frame_build(const lflare_tables *t, const lflare_view *view, const lflare_light *lights, int32_t light_count,
                                            lflare_frame_data *f)
{
    float slope_scale, *shares = NULL;
    lflare_result result = LFLARE_OK;
    int32_t i;
#ifdef LFLARE__BUDGETS
    float of_budgets[2];
#endif
    if (f == NULL) return LFLARE_ERROR_ARGUMENT;
    f->light_count = f->instance_count = 0;
    if (t == NULL || !lflare__valid_view(view) || light_count < 0 || (light_count > 0 && lights == NULL)) return LFLARE_ERROR_ARGUMENT;
    for (i = 0; i < light_count; i++)
        if (!lflare__valid_light(&lights[i])) return LFLARE_ERROR_ARGUMENT;
    slope_scale = lflare__frame_size(t, view, f);
    for (i = 0; i < light_count; i++) {
        lflare_frame_light *l = &f->lights[f->light_count];
        if (f->light_count == f->light_capacity) {
            result = LFLARE_ERROR_LIMIT; /* those that there is room for are drawn */
            break;
        }
        if (!lflare__frame_light_make(t, f, &lights[i], slope_scale, view->edge_fade, l)) continue;
        l->source = i;
        f->light_count++;
    }
#ifdef LFLARE__BUDGETS
    if (t->vertex_budget > 0 || t->pixel_budget > 0) {
        shares = of_budgets;
        lflare__budget_shares(t, f, shares);
    }
#endif
    for (i = 0; i < f->light_count; i++)
        if (lflare__frame_ghosts(t, f, i, shares) < 0) return LFLARE_ERROR_LIMIT;
    return result;
}

LFLARE_API float lflare_fade(float now, float target, float dt, float attack, float release)
{
    float time = target > now ? attack : release;
    if (!(now - now == 0) || !(time > 0)) return target;
    if (dt > 0) now += (target - now) * (1 - expf(-dt / time));
    return fabsf(target - now) < 1e-5f ? target : now;
}

typedef struct lflare__sample {
    float weight[3], centroid, radius, turn0, turn2;
    int32_t binding; /* bits, see lflare__binding */
} lflare__sample;

/* A ghost's field row at an angle; 0 where the ghost is hidden. */
static int lflare__field_sample(const lflare_tables *t, int32_t g, float angle, lflare__sample *out)
{
    const float *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS, *row;
    float at = angle * style[7] * (LFLARE_FIELD_SAMPLES - 1), f, v[7];
    int32_t j = (int32_t)at, i, k;
    if (!(at < LFLARE_FIELD_SAMPLES - 1)) return 0;
    row = t->field + (size_t)g * LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS;
    i = j < 1 ? 1 : j > LFLARE_FIELD_SAMPLES - 3 ? LFLARE_FIELD_SAMPLES - 3 : j; /* colours turn faster than shapes */
    for (k = 0; k < 3; k++) out->weight[k] = lflare__maxf(lflare__cubic(row + i * LFLARE_FIELD_FLOATS + k, LFLARE_FIELD_FLOATS, at - (float)i), 0);
    row += j * LFLARE_FIELD_FLOATS;
    f = at - (float)j;
    for (k = 3; k < 7; k++) v[k] = row[k] + f * (row[k + LFLARE_FIELD_FLOATS] - row[k]);
    out->centroid = v[3];
    out->radius = lflare__maxf(v[4], 1e-6f * t->entrance_radius);
    out->turn0 = v[5];
    out->turn2 = v[6];
    out->binding = (int32_t)row[7];
    return 1;
}

/* What a footprint needs per wavelength: drawn is the magnification with the least size in force, scale the override's. */
typedef struct lflare__drawn {
    float drawn[LFLARE_WAVELENGTHS], scale;
    int fringes; /* bright enough for them to show */
} lflare__drawn;

/* An edge |a r + b u| <= h in coordinates of the drawn footprint; `rim` and `head` are 4 floats apart per wavelength. Softness and
   fringes of the middle wavelength serve all three, in their measure. */
static lflare_edge lflare__edge_make(const lflare_tables *t, const float *rim, float h, const float *head, const lflare__drawn *d, const lflare__sample *s,
                                     const lflare_frame_light *l, float pixel, float softness)
{
    float a = rim[4] / h, c = head[7] * a - head[6] * rim[5] / h, grid = pixel * a / d->drawn[1], lamp = c * d->scale / d->drawn[1] * l->angular_radius; /* |c| alpha, seen in the rim's plane */
    float soft = sqrtf(5 * (LFLARE__PIXEL_VARIANCE * grid * grid + 0.25f * lamp * lamp));
    float ring = 0;
    lflare_edge e;
    int32_t k;
#ifndef LFLARE_NO_DIFFRACTION
    if (d->fringes) ring = sqrtf(0.5e-6f * t->wavelengths[1] * fabsf(a * c) / lflare__maxf(fabsf(head[6]), 1e-12f)); /* P 9 */
#endif
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        e.gain[k] = rim[4 * k] / h / d->drawn[k];
        e.offset[k] = rim[4 * k] / h * s->centroid + rim[4 * k + 1] / h * l->slope_length;
        e.soft[k] = soft * fabsf(d->drawn[1] / d->drawn[k]);
        e.soft[k] = sqrtf(e.soft[k] * e.soft[k] + softness * softness) + 1e-7f;
        e.ring[k] = ring > 0 ? ring * sqrtf(t->wavelengths[k] / t->wavelengths[1]) : 0;
    }
    return e;
}

static lflare__profile lflare__edge_profile(const lflare_edge *e, int32_t k, const float *ringing) { return lflare__profile_make(ringing, e->soft[k], e->ring[k]); }

/* Reach of an edge's image about its own centre, soft edge included. */
static float lflare__edge_extent(const lflare_edge *e, int32_t k, const float *ringing)
{
    return (1 + lflare__edge_profile(e, k, ringing).outer) / lflare__maxf(fabsf(e->gain[k]), 1e-12f);
}

/* Whether an edge cuts into what another one leaves, at any wavelength: where rims are nearly straight they differ much. */
static int lflare__edge_cuts(const lflare_edge *e, const lflare_edge *of, const float *ringing)
{
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        float middle = -of->offset[k] / of->gain[k];
        if (fabsf(e->gain[k] * middle + e->offset[k]) + fabsf(e->gain[k]) * lflare__edge_extent(of, k, ringing) - 1 + e->soft[k] > 0) return 1;
    }
    return 0;
}

/* The iris, then those of pupil and rims that bind hereabouts and do not hold all of the smallest edge. */
static void lflare__footprint_edges(const lflare_tables *t, int32_t g, const lflare__drawn *d, const lflare__sample *s, const lflare_frame_light *l,
                                    float pixel, lflare_footprint *out)
{
    static const float pupil[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    const float *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS, *rim = t->rims + (size_t)g * LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS;
    lflare_edge e[LFLARE_MAX_EDGES];
    float reach = 3e38f;
    int32_t count = 1, i, k, smallest = 0;
    out->ringing = t->ringing;
    e[0] = lflare__edge_make(t, head, t->iris.radius, head, d, s, l, pixel, t->iris.softness);
    if (s->binding & 1) e[count++] = lflare__edge_make(t, pupil, t->entrance_radius, head, d, s, l, pixel, 0);
    for (i = 0; i < LFLARE_MAX_RIMS; i++, rim += LFLARE_RIM_FLOATS)
        if (s->binding >> (i + 1) & 1) {
            int stop = lflare__rim_is_stop(rim);
            e[count++] = lflare__edge_make(t, rim, stop ? t->iris.radius : rim[2], head, d, s, l, pixel, stop ? t->iris.softness : 0);
        }
    for (i = 0; i < count; i++) {
        float extent = lflare__edge_extent(&e[i], 1, t->ringing);
        if (extent < reach) {
            reach = extent;
            smallest = i;
        }
    }
    out->radius = 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++)
        out->radius = lflare__maxf(out->radius, fabsf(e[smallest].offset[k]) / lflare__maxf(fabsf(e[smallest].gain[k]), 1e-12f) + lflare__edge_extent(&e[smallest], k, t->ringing));
    out->edges[0] = e[0];
    out->edge_count = 1;
    for (i = 1; i < count; i++)
        if (i == smallest || lflare__edge_cuts(&e[i], &e[smallest], t->ringing)) out->edges[out->edge_count++] = e[i];
}

/* Soft edges change the area really drawn: on a curve of radius R by sigma^2 / 2 per radian of turning, to pi (R^2 + sigma^2)
   for a disc; where the soft width H = sqrt(5) sigma exceeds R the integral of the profile stops at the centre. Both over pi. */
static float lflare__soft_size2(float size2, float variance)
{
    float h2 = 5 * variance, p;
    if (h2 <= size2) return size2 + variance;
    p = sqrtf(size2 / h2);
    return 2 * h2 * (0.05f + p * (0.1875f + p * (0.25f + p * (0.125f - 0.0125f * p * p))));
}

LFLARE_API int32_t lflare_footprint_resolve(const lflare_tables *t, const lflare_frame_data *f, lflare_instance instance, lflare_footprint *out)
{
    const lflare_frame_light *l = &f->lights[instance.light];
    int32_t g = instance.ghost, k;
    const float *style = t->style + (size_t)g * LFLARE_STYLE_FLOATS, *head = t->head + (size_t)g * LFLARE_HEAD_FLOATS;
    float lit = 0, pixel = f->pixel, brightest = 0, tint[3];
    lflare__sample s;
    lflare__drawn d;
    if (!lflare__field_sample(t, g, l->field_angle, &s)) return 0;
    d.scale = style[3];
    lflare__style_tint(style, l->field_angle, tint);
    for (k = 0; k < 2; k++) out->axis[k] = l->axis[k];
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        const float *m = head + k * 4;
        float spread = 0.61e-6f * t->wavelengths[k] * m[3] / s.radius, lamp = l->angular_radius * m[3];
        float least = sqrtf(pixel * pixel + spread * spread + lamp * lamp) / s.radius; /* P 3: r_min / rho */
        float size = lflare__maxf(fabsf(m[2]), least), along = m[2] * s.centroid + m[3] * l->slope_length;
        d.drawn[k] = (m[2] < 0 ? -size : size) * d.scale;
        out->centre[k][0] = along * l->axis[0] + t->efl * (style[4] * l->slope[0] - style[5] * l->slope[1]) + style[8];
        out->centre[k][1] = along * l->axis[1] + t->efl * (style[4] * l->slope[1] + style[5] * l->slope[0]) + style[9];
        out->irradiance[k] = l->irradiance[k] * s.weight[k] * tint[k] / (size * size);
        brightest = lflare__maxf(brightest, s.weight[k] * tint[k] / (size * size));
        lit += out->irradiance[k];
    }
    d.fringes = t->fringes && brightest >= LFLARE__RING_LEAST * t->mean_irradiance;
    out->fine = s.radius * fabsf(d.drawn[1]) < 4 * pixel;
    if (out->fine) pixel *= 0.25f;
    lflare__footprint_edges(t, g, &d, &s, l, pixel, out);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        float size2 = s.radius * s.radius * d.drawn[k] * d.drawn[k], lamp = d.scale * l->angular_radius;
        float variance = (LFLARE__PIXEL_VARIANCE * pixel * pixel * s.turn0 + 0.25f * lamp * lamp * s.turn2) / (float)LFLARE__PI;
        out->irradiance[k] *= lflare__instance_share(instance) * size2 / lflare__soft_size2(size2, variance);
    }
    return lit > 0;
}

#ifdef LFLARE__PATCHES
/* -- patches -- */

/* What all vertices of a patch share. */
typedef struct lflare__patch_shape {
    const lflare_frame_light *light;
    const float *style;
    float tint[3];
    float even;               /* 1: few pixels, where triangles say better than vertices what the irradiance is */
    float grown;              /* what a ghost smaller than a pixel, or than what diffraction and lamp leave, grows by: mm on the sensor per mm on the entrance */
    float gain;               /* for soft edges that light more than the ghost's area */
    float shift[2], middle, entrance; /* of the centre: sensor, mirror plane; mm */
    float pixel, grid;        /* mm; its variance, mm^2 */
    float softness;           /* of the iris, in its radii */
    const float *ringing;     /* NULL: no fringes */
    float half_wave, widest;  /* mm, middle wavelength; fringes of the longest over its */
    const float *spectrum;    /* the ghost's rows before the light's field angle; NULL: three wavelengths are the channels */
    float between, bundle[3]; /* to the next; centre and half axes of the bundle that they are about */
    const float *shares, *next[2]; /* of a mesh for one wavelength that is drawn, see lflare_tables.spectral, and of those beside it; NULL: one for all */
    int32_t mesh;             /* which it is */
} lflare__patch_shape;

/* Width over which an edge fades that a lamp of one radian would blur by `lamp` mm. */
static float lflare__patch_soft(const lflare__patch_shape *p, float lamp)
{
    lamp *= p->light->angular_radius * p->style[3];
    return sqrtf(5 * (p->grid + 0.25f * lamp * lamp));
}

/* Length of the fringes of such an edge, mm, where the map shrinks areas so (P 9; sqrt |shrink| stands for |M11|). */
static float lflare__patch_ring(const lflare__patch_shape *p, float shrink, float lamp)
{
    return p->ringing != NULL ? p->style[3] * sqrtf(p->half_wave * sqrtf(fabsf(shrink)) * fabsf(lamp)) : 0;
}

/* Turns a vector from the light's frame. */
static void lflare__turn(const float *axis, float x, float y, float *out)
{
    out[0] = x * axis[0] - y * axis[1];
    out[1] = x * axis[1] + y * axis[0];
}

/* All but what the ghost's own size decides. */
static void lflare__patch_shape_make(const lflare_tables *t, const lflare_frame_data *f, const lflare_frame_light *l, int32_t g, lflare__patch_shape *p)
{
    p->light = l;
    p->style = t->style + (size_t)g * LFLARE_STYLE_FLOATS;
    p->softness = t->iris.softness;
    p->ringing = t->fringes ? t->ringing : NULL;
    p->half_wave = 0.5e-6f * t->wavelengths[1];
    p->widest = sqrtf(t->wavelengths[0] / t->wavelengths[1]);
    p->pixel = f->pixel;
    p->grid = LFLARE__PIXEL_VARIANCE * f->pixel * f->pixel;
    lflare__style_tint(p->style, l->field_angle, p->tint);
    p->shift[0] = t->efl * (p->style[4] * l->slope[0] - p->style[5] * l->slope[1]) + p->style[8];
    p->shift[1] = t->efl * (p->style[4] * l->slope[1] + p->style[5] * l->slope[0]) + p->style[9];
    p->spectrum = p->shares = NULL;
    p->between = 0;
}

/* What more than three wavelengths need of a ghost that is hidden from a field angle on. */
static void lflare__patch_spectrum(const lflare_tables *t, int32_t g, float hidden, lflare__patch_shape *p)
{
    float at = lflare__knot_of(p->light->field_angle, hidden, LFLARE_OUTLINE_KNOTS);
    int32_t first = (int32_t)lflare__minf(at, LFLARE_OUTLINE_KNOTS - 2), k;
    if (t->wavelength_count == 0) return;
    p->between = at - (float)first;
    p->spectrum = t->spectrum + ((size_t)g * LFLARE_OUTLINE_KNOTS + (size_t)first) * LFLARE_SPECTRUM_ROWS * 4;
    for (k = 0; k < 3; k++) p->bundle[k] = p->spectrum[k] + p->between * (p->spectrum[k + LFLARE_SPECTRUM_ROWS * 4] - p->spectrum[k]);
    if (p->mesh < 0) return;
    p->shares = t->spectral[p->mesh];
    p->next[0] = t->spectral[p->mesh > 0 ? p->mesh - 1 : 0];
    p->next[1] = t->spectral[p->mesh + 1 < t->wavelength_count ? p->mesh + 1 : p->mesh];
}

/* A parabola of the spectrum's rows at a place in the bundle. */
static float lflare__spectrum_at(const float *spectrum, float between, int32_t row, const float *bundle)
{
    const float *c = spectrum + 4 * row, *d = c + LFLARE_SPECTRUM_ROWS * 4;
    float a = bundle[0], b2 = bundle[1] * bundle[1], here = c[0] + a * (c[1] + a * c[2]) + b2 * c[3], next = d[0] + a * (d[1] + a * d[2]) + b2 * d[3];
    return here + between * (next - here);
}

/* What a vertex at a place of the entrance lights its channels with: weights are those of the three wavelengths, unless there are more. */
static void lflare__patch_light(const lflare__patch_shape *p, const float *weight, const float *entrance, lflare_patch_vertex *out, float *flux)
{
    float one = 1;
    int32_t k;
    for (k = 0; k < 2; k++) out->bundle[k] = 0;
    if (p->spectrum != NULL) {
        out->bundle[0] = (entrance[0] - p->bundle[0]) / lflare__maxf(p->bundle[1], 1e-9f);
        out->bundle[1] = entrance[1] / lflare__maxf(p->bundle[2], 1e-9f);
        if (p->shares != NULL) one = lflare__maxf(lflare__spectrum_at(p->spectrum, p->between, 1 + p->mesh, out->bundle), 0);
    }
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        float light = p->gain * p->light->irradiance[k] * p->tint[k];
        if (p->shares != NULL) flux[k] = one * p->shares[4 + k] * light;
        else if (p->spectrum != NULL) flux[k] = p->gain; /* W and the light's colour come to it */
        else flux[k] = p->mesh < 0 || p->mesh == k ? weight[k] * light : 0;
    }
}

/* What a mesh for all of more than three wavelengths hands on with its vertices; where nothing cuts them they are colours at once. */
static void lflare__patch_colour(const lflare__patch_shape *p, int masked, lflare_patch *out)
{
    int32_t i, j, c;
    out->spectrum = p->shares == NULL ? p->spectrum : NULL;
    out->between = p->between;
    for (c = 0; c < 3; c++) out->color[c] = p->light->irradiance[c] * p->tint[c];
    if (out->spectrum == NULL || masked) return;
    for (i = 0; i < LFLARE_PATCH_RINGS; i++)
        for (j = 0; j < LFLARE_PATCH_DIRECTIONS; j++) {
            lflare_patch_vertex *v = &out->inside[i][j];
            for (c = 0; c < 3; c++) {
                float lit = lflare__spectrum_at(p->spectrum, p->between, LFLARE_SPECTRUM_ROWS - 3 + c, v->bundle) * out->color[c];
                v->irradiance[c] *= lit;
                v->flux[c] *= lit;
            }
        }
}

/* Ghosts never get smaller than a disc (P 3): smaller ones would flicker as they pass from pixel to pixel, or be brighter than
   diffraction and the lamp's size let them be. What is missing to its radius is added, in the shape of the entrance, whose radius is given;
   blur of the iris; radius that diffraction leaves times that of the entrance; whether the ghost stands upside down. */
static void lflare__patch_grow(const lflare_frame_data *f, float radius, float entrance, float lamp, float spread, int turned, lflare__patch_shape *p)
{
    float scale = p->style[3], least, size;
    entrance = lflare__maxf(entrance, 1e-6f);
    lamp *= p->light->angular_radius;
    spread = lflare__minf(spread / entrance, 0.5f * f->half_width);
    least = sqrtf(2.25f * f->pixel * f->pixel + spread * spread + lamp * lamp);
    p->grown = (turned ? -scale : scale) * lflare__maxf(least - radius, 0) / entrance;
    p->even = lflare__minf(lflare__maxf(2 - scale * radius / lflare__maxf(4 * f->pixel, scale * least), 0), 1);
    size = scale * lflare__maxf(radius, least);
    lamp *= scale;
    p->gain = size * size / lflare__soft_size2(size * size, p->grid + 0.25f * lamp * lamp);
}

#ifndef LFLARE_NO_ABERRATION
/* -- patches of meshes -- */

/* A mesh at the light's field angle. */
typedef struct lflare__mesh_view {
    const float *first;       /* knot that `share` begins with, its vertices */
    size_t knot, row;         /* floats from knot to knot, ring to ring */
    float share[4], knots[4 * LFLARE__MESH_KNOT_TEXELS]; /* what knots say of the whole, interpolated */
    int32_t between, rings, directions, floats, channel; /* the light comes after knot `between` of the four; the one that a mesh for one has */
    size_t mesh;              /* floats to the next wavelength's mesh, if three are mixed by */
    const float *shares;      /* these; NULL: they are not */
} lflare__mesh_view;

static int lflare__mesh_view_make(const lflare_tables *t, int32_t g, int32_t mesh, const float *shares, float angle, lflare__mesh_view *v)
{
    const float *head = t->mesh_head + (size_t)g * LFLARE_MESH_HEAD_FLOATS, *knot;
    float at;
    int32_t knots, first, i, k;
    if (!(angle < head[4])) return 0;
    knots = lflare__mesh_knots((int32_t)head[5] & 8);
    at = lflare__knot_of(angle, head[4], knots);
    first = lflare__cubic_shares(at, knots, v->share);
    v->directions = (int32_t)head[1];
    v->rings = (int32_t)head[2];
    v->knot = 4 * (size_t)head[7];
    v->floats = lflare__mesh_floats(head[6] > 1);
    v->channel = mesh;
    v->shares = shares;
    v->mesh = (size_t)knots * v->knot;
    if (shares != NULL) mesh = 0;
    v->row = (size_t)(v->directions + 1) * (size_t)v->floats;
    knot = t->mesh + 4 * (size_t)head[0] + ((size_t)mesh * (size_t)knots + (size_t)first) * v->knot;
    v->first = knot + 4 * LFLARE__MESH_KNOT_TEXELS;
    at -= (float)first;
    v->between = i = (int32_t)lflare__minf(at, 2);
    if (shares != NULL) knot += v->mesh; /* of the whole, the middle one's */
    for (k = 0; k < 4 * LFLARE__MESH_KNOT_TEXELS; k++) { /* linearly, so that what is positive stays so */
        float a = knot[(size_t)i * v->knot + (size_t)k], b = knot[((size_t)i + 1) * v->knot + (size_t)k];
        v->knots[k] = a + (at - (float)i) * (b - a);
    }
    return 1;
}

/* A vertex of the table, between two rings and four field angles. */
typedef struct lflare__mesh_vertex {
    float sensor[2], entrance[2], weight[LFLARE_WAVELENGTHS], shrink, spread, rim[LFLARE_WAVELENGTHS], iris[LFLARE_WAVELENGTHS][2], lamp;
} lflare__mesh_vertex;

/* One of its floats; `kept` to what the nearest two field angles say: weight and shrink next to caustics would swing on a cubic. */
static float lflare__mesh_float_at(const lflare__mesh_view *v, const float *at, int kept)
{
    float value = v->share[0] * at[0] + v->share[1] * at[v->knot] + v->share[2] * at[2 * v->knot] + v->share[3] * at[3 * v->knot], least, most;
    if (!kept) return value;
    at += (size_t)v->between * v->knot;
    least = lflare__minf(at[0], at[v->knot]);
    most = lflare__maxf(at[0], at[v->knot]);
    return lflare__minf(lflare__maxf(value, least - 0.1f * (most - least)), most + 0.1f * (most - least));
}

/* Mixed where one of many wavelengths is drawn from the meshes of three. */
static float lflare__mesh_float(const lflare__mesh_view *v, int32_t ring, int32_t direction, int32_t i, int kept)
{
    const float *at = v->first + (size_t)ring * v->row + (size_t)(direction * v->floats + i);
    float sum = 0;
    int32_t k;
    if (v->shares == NULL) return lflare__mesh_float_at(v, at, kept);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) sum += v->shares[k] * lflare__mesh_float_at(v, at + (size_t)k * v->mesh, kept);
    return sum;
}

/* `at` counts rings; beyond the last, places go on as between the last two. */
static void lflare__mesh_vertex_at(const lflare__mesh_view *v, float at, int32_t direction, lflare__mesh_vertex *out)
{
    float a[LFLARE__MESH_FUSED], f;
    int32_t ring = (int32_t)lflare__minf(lflare__maxf(at, 0), (float)(v->rings - 1)), k, i; /* whatever a fit holds */
    int split = v->floats == LFLARE__MESH_SPLIT;
    f = at - (float)ring;
    for (i = 0; i < v->floats; i++) {
        int kept = i >= 4 && (i < 8 || (i == 11 && !split)), scalar = kept || (i == 18 && !split);
        a[i] = lflare__mesh_float(v, ring, direction, i, kept);
        if (f > 0) a[i] += (scalar ? lflare__minf(f, 1) : f) * (lflare__mesh_float(v, ring + 1, direction, i, kept) - a[i]);
    }
    for (k = 0; k < 2; k++) {
        out->sensor[k] = a[k];
        out->entrance[k] = a[2 + k];
    }
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        out->weight[k] = lflare__maxf(a[split ? 4 : 4 + k], 0);
        out->rim[k] = a[split ? 8 : 8 + k];
        for (i = 0; i < 2; i++) out->iris[k][i] = a[(split ? 9 : 12 + 2 * k) + i];
    }
    out->shrink = a[split ? 5 : 7];
    out->spread = lflare__maxf(a[split ? 6 : 11], 1e-20f);
    out->lamp = a[split ? 7 : 18];
}

/* The vertex `at` rings from the centre, which may be beyond the last. */
static void lflare__patch_vertex(const lflare__mesh_view *v, const lflare__patch_shape *p, float at, int32_t direction, float side, lflare_patch_vertex *out)
{
    const float *axis = p->light->axis, scale = p->style[3];
    lflare__mesh_vertex m;
    float flat, shrink, flux[LFLARE_WAVELENGTHS];
    int32_t k;
    lflare__mesh_vertex_at(v, at, direction, &m);
    lflare__patch_light(p, m.weight, m.entrance, out, flux);
    shrink = fabsf(m.shrink);
    flat = lflare__maxf(p->even, lflare__minf(lflare__maxf(2 - shrink / m.spread, 0), 1));
    shrink = lflare__maxf(shrink, m.spread);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        out->irradiance[k] = (1 - flat) * flux[k] / shrink;
        out->flux[k] = flat * flux[k] * scale * scale;
        lflare__turn(axis, m.iris[k][0], side * m.iris[k][1], out->iris[k]);
        out->rim[k] = m.rim[k];
    }
    m.entrance[0] -= p->entrance;
    lflare__turn(axis, m.entrance[0], side * m.entrance[1], out->entrance);
    lflare__turn(axis, p->middle + scale * (m.sensor[0] - p->middle) + p->grown * m.entrance[0], side * (scale * m.sensor[1] + p->grown * m.entrance[1]), out->position);
    for (k = 0; k < 2; k++) out->position[k] += p->shift[k];
    out->rim_soft = lflare__patch_soft(p, m.lamp);
    out->rim_ring = lflare__patch_ring(p, m.shrink, m.lamp);
    out->iris_ring = lflare__patch_ring(p, m.shrink, v->knots[1]);
    out->apart = 0;
    if (v->shares != NULL) {
        float ways[2] = {0, 0};
        int32_t ring = (int32_t)lflare__minf(lflare__maxf(at, 0), (float)v->rings), i;
        for (k = 0; k < LFLARE_WAVELENGTHS; k++)
            for (i = 0; i < 2; i++) ways[i] += 0.5f * (p->next[1][k] - p->next[0][k]) * lflare__mesh_float_at(v, v->first + (size_t)ring * v->row + (size_t)(direction * v->floats + i) + (size_t)k * v->mesh, 0);
        out->apart = scale * sqrtf(ways[0] * ways[0] + ways[1] * ways[1]);
    }
    out->turn = side > 0 ? (float)direction : (float)(2 * v->directions - direction);
    out->bulge = lflare__mesh_float(v, 0, direction, v->floats - 1, 0);
}

/* From where to where the rim reaches in a direction, in rings, its soft edges and fringes included. */
static void lflare__patch_band(const lflare__mesh_view *v, const lflare__patch_shape *p, float iris_soft, int32_t direction, float *begin, float *end)
{
    int32_t last = v->floats - 1, split = v->floats == LFLARE__MESH_SPLIT;
    float lamp = lflare__mesh_float(v, v->rings, direction, split ? 7 : 18, 0), shrink = lflare__mesh_float(v, v->rings, direction, split ? 5 : 7, 1);
    float rate = p->style[3] * lflare__mesh_float(v, v->rings - 1, direction, last, 0) + fabsf(p->grown) * v->knots[2];
    float inverse = 1.1f / lflare__maxf(rate, 1.5f * p->pixel); /* see lflare__cut_slope */
    lflare__profile iris = lflare__profile_make(p->ringing, inverse * iris_soft, inverse * p->widest * lflare__patch_ring(p, shrink, v->knots[1]));
    lflare__profile rim = lflare__profile_make(p->ringing, inverse * lflare__patch_soft(p, lamp), inverse * p->widest * lflare__patch_ring(p, shrink, lamp));
    *begin = (float)v->rings * lflare__maxf(lflare__mesh_float(v, v->rings, direction, last, 0) - lflare__maxf(iris.inner, rim.inner) - p->softness - 0.01f, 0);
    *end = (float)v->rings * (1 + lflare__maxf(iris.outer, rim.outer) + p->softness + 1.2f * lflare__mesh_float(v, 0, direction, last, 0)); /* heights grow by about 1 on the way */
}

static int32_t lflare__mesh_resolve(const lflare_tables *t, const lflare_frame_data *f, lflare_instance instance, lflare_patch *out)
{
    const lflare_frame_light *l = &f->lights[instance.light];
    const float *head = t->mesh_head + (size_t)instance.ghost * LFLARE_MESH_HEAD_FLOATS;
    int32_t sectors = (int32_t)head[1] / 4, blocks = (int32_t)head[2] / 4, mesh = instance.patch / (sectors * blocks), block = instance.patch / sectors % blocks, i, k, ragged;
    lflare__mesh_view v;
    lflare__patch_shape p;
    lflare__patch_shape_make(t, f, l, instance.ghost, &p);
    p.mesh = head[6] > 1 ? mesh : -1;
    lflare__patch_spectrum(t, instance.ghost, head[4], &p);
    if (!lflare__mesh_view_make(t, instance.ghost, mesh, p.shares, l->field_angle, &v)) return 0;
    out->iris_soft = lflare__patch_soft(&p, v.knots[1]);
    lflare__patch_grow(f, v.knots[0], v.knots[2], v.knots[1], head[3], v.knots[6] < 0, &p);
    p.gain *= lflare__instance_share(instance);
    p.middle = lflare__mesh_float(&v, 0, 0, 0, 0);
    p.entrance = lflare__mesh_float(&v, 0, 0, 2, 0);
    ragged = (int32_t)head[5] >> (p.shares != NULL ? 0 : mesh) & 1;
    if (ragged) memset(out->inside, 0, sizeof out->inside);
    for (i = 0; i < LFLARE_PATCH_DIRECTIONS; i++) {
        int32_t direction = instance.patch % sectors * (LFLARE_PATCH_DIRECTIONS - 1) + i;
        float side = direction > v.directions ? -1.0f : 1.0f, begin, end;
        if (direction > v.directions) direction = 2 * v.directions - direction;
        lflare__patch_band(&v, &p, out->iris_soft, direction, &begin, &end);
        if (ragged) { /* the rim is everywhere, and every block has its part */
            begin = (float)block / (float)blocks * end;
            end *= (float)(block + 1) / (float)blocks;
        }
        for (k = 0; k < LFLARE_PATCH_RINGS && !ragged; k++)
            lflare__patch_vertex(&v, &p, lflare__minf((float)(block * (LFLARE_PATCH_RINGS - 1) + k), begin), direction, side, &out->inside[k][i]);
        for (k = 0; k < LFLARE_PATCH_BANDS; k++)
            lflare__patch_vertex(&v, &p, begin + (end - begin) * (float)k / (LFLARE_PATCH_BANDS - 1), direction, side, &out->rim[k][i]);
    }
    out->rimmed = ragged || block == blocks - 1;
    lflare__patch_colour(&p, t->iris.mask != NULL, out);
    return 1;
}

#endif /* LFLARE_NO_ABERRATION */

#ifndef LFLARE_NO_TRACE
/* -- traced ghosts -- */

/* A ghost's mesh at the light's field angle. */
typedef struct lflare__traced_view {
    lflare__tracer tracer;
    float knot[LFLARE__OUTLINE_KNOT];   /* see lflare__outline_ghost */
    int32_t directions, rings, mesh;    /* which one, -1: one for all wavelengths */
    const float *shares;                /* of the wavelength traced */
    int ragged;
    float diffraction;
} lflare__traced_view;

/* The one that a patch belongs to, which counts within it from there on. 0 if it is hidden. */
static int lflare__traced_view_make(const lflare_tables *t, lflare_instance instance, const lflare_frame_light *l, int32_t *patch, lflare__traced_view *o)
{
    const float *head = t->outline + (size_t)instance.ghost * LFLARE_OUTLINE_FLOATS, *middle = head + LFLARE__OUTLINE_ONE, *a;
    int32_t first = instance.band & 15, code, meshes, each, i;
    float f;
    if (!(l->field_angle < middle[0]) || first > LFLARE_OUTLINE_KNOTS - 2) return 0;
    code = lflare__code_coarser((int32_t)middle[LFLARE__OUTLINE_HEAD + first * LFLARE__OUTLINE_KNOT + 11], instance.band >> 8 & 3);
    meshes = lflare__meshes(t, code & 128);
    each = lflare__code_patches(t, code) / meshes;
    *patch = instance.patch % each;
    o->mesh = meshes > 1 ? instance.patch / each : -1;
    if (o->mesh >= meshes) return 0;
    o->shares = lflare__shares[o->mesh < 0 ? 1 : o->mesh < LFLARE_WAVELENGTHS ? o->mesh : 0];
    if (t->wavelength_count > 0 && o->mesh >= 0) o->shares = t->spectral[o->mesh];
    head += (o->mesh < 0 || t->wavelength_count > 0 ? 1 : o->mesh) * LFLARE__OUTLINE_ONE;
    a = head + LFLARE__OUTLINE_HEAD + first * LFLARE__OUTLINE_KNOT;
    f = lflare__knot_of(l->field_angle, head[0], LFLARE_OUTLINE_KNOTS) - (float)first;
    for (i = 0; i < LFLARE__OUTLINE_KNOT; i++) o->knot[i] = a[i] + f * (a[i + LFLARE__OUTLINE_KNOT] - a[i]);
    lflare__tracer_make(t, instance.ghost, &o->tracer);
    o->tracer.slope = l->slope_length;
    o->directions = lflare__code_directions(code);
    o->rings = lflare__code_rings(code);
    o->ragged = (code & 256) != 0;
    o->diffraction = head[1];
    if (o->ragged) {
        memcpy(o->knot, a + 16, sizeof(float) * 4);
        for (i = 0; i < LFLARE_OUTLINE_SIDES; i++) o->knot[LFLARE__OUTLINE_WHOLE + 4 * i] = 1;
    }
    return 1;
}

/* What stands beside a direction: interpolated where the mesh has more of them. */
static void lflare__outline_beside(const lflare__traced_view *o, int32_t direction, float *out)
{
    float at = (float)direction * (LFLARE_OUTLINE_SIDES - 1) / (float)o->directions;
    int32_t first = (int32_t)lflare__minf(at, LFLARE_OUTLINE_SIDES - 2), i;
    const float *a = o->knot + LFLARE__OUTLINE_WHOLE + 4 * first;
    for (i = 0; i < 4; i++) out[i] = a[i] + (at - (float)first) * (a[i + 4] - a[i]);
}

/* A vertex's ray and what its neighbours say of the map there. */
typedef struct lflare__traced_point {
    float place[2];                     /* on the entrance */
    lflare__traced_ray ray;
    float sensor[4], stop[4], height[2];/* slopes over the place: by x, then by y */
    float shrink, spread, curved;       /* see lflare__traced_slopes */
    int whole;                          /* all neighbours arrive */
} lflare__traced_point;

/* Slopes at a vertex by rays beside it, 0.3 of the way to the next one. The area on the sensor per area on the entrance, signed, and how much
   that differs from the next vertices': `radial` and `around` lead there. How heights curve across: rims are round, and along a line outwards
   heights grow evenly, so that this is what their second slopes add up to. */
static void lflare__traced_slopes(const lflare__traced_view *o, const float *radial, const float *around, lflare__traced_point *p)
{
    float step[2], bent[4], twist[2], grows[2];
    lflare__traced_ray near[2][2], corner;
    int32_t axis, side, i;
    p->whole = p->ray.arrives;
    p->curved = 0;
    for (axis = 0; axis < 2; axis++) {
        step[axis] = 0.3f * o->knot[1 + axis] / (float)o->rings;
        for (side = 0; side < 2; side++) {
            float way = side == 0 ? -step[axis] : step[axis];
            lflare__traced_ray_make(&o->tracer, o->shares, 0, axis == 0 ? p->place[0] + way : p->place[0], axis == 1 ? p->place[1] + way : p->place[1], &near[axis][side]);
            p->whole &= near[axis][side].arrives;
            p->curved += (near[axis][side].relative - p->ray.relative) / (step[axis] * step[axis]);
        }
        p->height[axis] = (near[axis][1].relative - near[axis][0].relative) / (2 * step[axis]);
        for (i = 0; i < 2; i++) {
            p->stop[2 * axis + i] = (near[axis][1].stop[i] - near[axis][0].stop[i]) / (2 * step[axis]);
            p->sensor[2 * axis + i] = (near[axis][1].sensor[i] - near[axis][0].sensor[i]) / (2 * step[axis]);
            bent[2 * axis + i] = ((near[axis][1].sensor[i] - p->ray.sensor[i]) - (p->ray.sensor[i] - near[axis][0].sensor[i])) / (step[axis] * step[axis]);
        }
    }
    lflare__traced_ray_make(&o->tracer, o->shares, 0, p->place[0] + step[0], p->place[1] + step[1], &corner);
    p->whole &= corner.arrives;
    for (i = 0; i < 2; i++) twist[i] = ((corner.sensor[i] - near[0][1].sensor[i]) - (near[1][1].sensor[i] - p->ray.sensor[i])) / (step[0] * step[1]);
    grows[0] = bent[0] * p->sensor[3] + p->sensor[0] * twist[1] - bent[1] * p->sensor[2] - p->sensor[1] * twist[0];
    grows[1] = twist[0] * p->sensor[3] + p->sensor[0] * bent[3] - twist[1] * p->sensor[2] - p->sensor[1] * bent[2];
    p->spread = p->whole ? lflare__maxf(lflare__maxf(fabsf(grows[0] * radial[0] + grows[1] * radial[1]), fabsf(grows[0] * around[0] + grows[1] * around[1])), 1e-20f) : 1e30f;
    p->shrink = p->whole ? p->sensor[0] * p->sensor[3] - p->sensor[1] * p->sensor[2] : 0;
}

/* Where another wavelength's ray that lands with this one meets the iris and the rims, to first order. */
static void lflare__traced_match(const lflare__traced_view *o, const lflare__traced_point *p, int32_t k, float *stop, float *relative)
{
    lflare__traced_ray ray;
    float off[2], move[2];
    int32_t i;
    lflare__traced_ray_make(&o->tracer, lflare__shares[k], 0, p->place[0], p->place[1], &ray);
    if (!ray.arrives || !p->whole || !(fabsf(p->shrink) > 1e-20f)) ray = p->ray;
    for (i = 0; i < 2; i++) off[i] = p->ray.sensor[i] - ray.sensor[i];
    move[0] = (off[0] * p->sensor[3] - off[1] * p->sensor[2]) / p->shrink;
    move[1] = (off[1] * p->sensor[0] - off[0] * p->sensor[1]) / p->shrink;
    for (i = 0; i < 2; i++) move[i] = fabsf(p->shrink) > 1e-20f ? lflare__minf(lflare__maxf(move[i], -0.5f * o->knot[1 + i]), 0.5f * o->knot[1 + i]) : 0;
    for (i = 0; i < 2; i++) stop[i] = ray.stop[i] + p->stop[i] * move[0] + p->stop[2 + i] * move[1];
    *relative = lflare__maxf(ray.relative + p->height[0] * move[0] + p->height[1] * move[1], 0);
}

/* The ray `at` half axes from the centre. Where none arrives (total reflection, mostly) the last one on the way there that does stands for
   it, on the edge of what is lit. Returns where that is. */
static float lflare__traced_last(const lflare__traced_view *o, float at, float c, float s, lflare__traced_point *p)
{
    float near = 0, far = at;
    int32_t tries, last = 1;
    for (tries = 0; tries < last; tries++) {
        p->place[1] = at * o->knot[2] * s;
        p->place[0] = o->knot[0] + at * o->knot[1] * c + o->knot[3] * at * s * at * s;
        lflare__traced_ray_make(&o->tracer, o->shares, tries == 0 || tries == 8, p->place[0], p->place[1], &p->ray);
        if (tries == 0 && !p->ray.arrives) last = 9;
        if (p->ray.arrives) near = at;
        else far = at;
        if (tries < 8 && last > 1) at = tries < 7 ? 0.5f * (near + far) : near; /* the last is one that arrives */
    }
    if (last > 1) p->ray.relative = p->ray.arrives ? lflare__maxf(p->ray.relative, 1) : 2;
    return at;
}

/* The vertex `at` rings from the centre. */
static void lflare__traced_vertex(const lflare__traced_view *o, const lflare__patch_shape *p, float at, int32_t direction, float side, lflare_patch_vertex *out)
{
    const float *axis = p->light->axis, scale = p->style[3];
    float angle = 3.14159265f * (float)direction / (float)o->directions, c = cosf(angle), s = direction == 0 || direction == o->directions ? 0 : sinf(angle);
    float beside[4], local[2], entrance[2], radial[2], around[2], flux[LFLARE_WAVELENGTHS], chord, flat;
    lflare__traced_point v;
    int32_t k;
    lflare__outline_beside(o, direction, beside);
    at = lflare__traced_last(o, at * beside[0] / (float)o->rings, c, s, &v);
    chord = 3.14159265f / (float)o->directions * at;
    radial[0] = o->knot[1] * c * beside[0] / (float)o->rings;
    radial[1] = o->knot[2] * s * beside[0] / (float)o->rings;
    around[0] = -o->knot[1] * s * chord;
    around[1] = o->knot[2] * c * chord;
    lflare__traced_slopes(o, radial, around, &v);
    chord = sqrtf(around[0] * around[0] + around[1] * around[1]);
    flat = lflare__maxf(p->even, lflare__minf(lflare__maxf(2 - fabsf(v.shrink) / v.spread, 0), 1));
    memset(out, 0, sizeof *out);
    for (k = 0; k < LFLARE_WAVELENGTHS; k += 2)
        if (o->mesh < 0) v.ray.weight[k] *= o->knot[12 + k / 2];
    lflare__patch_light(p, v.ray.weight, v.place, out, flux);
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        float stop[2], relative = v.ray.relative;
        memcpy(stop, v.ray.stop, sizeof stop);
        if (o->mesh < 0 && k != 1) lflare__traced_match(o, &v, k, stop, &relative);
        out->irradiance[k] = flat < 1 ? (1 - flat) * flux[k] / lflare__maxf(fabsf(v.shrink), v.spread) : 0;
        out->flux[k] = flat * flux[k] * scale * scale;
        lflare__turn(axis, stop[0], side * stop[1], out->iris[k]);
        out->rim[k] = relative;
    }
    entrance[0] = v.place[0] - p->entrance;
    entrance[1] = side * v.place[1];
    lflare__turn(axis, entrance[0], entrance[1], out->entrance);
    local[0] = p->middle + scale * (v.ray.sensor[0] - p->middle) + p->grown * entrance[0];
    local[1] = scale * side * v.ray.sensor[1] + p->grown * entrance[1];
    lflare__turn(axis, local[0], local[1], out->position);
    for (k = 0; k < 2; k++) out->position[k] += p->shift[k];
    out->rim_soft = lflare__patch_soft(p, beside[3]);
    out->rim_ring = lflare__patch_ring(p, v.shrink, beside[3]);
    out->iris_ring = lflare__patch_ring(p, v.shrink, o->knot[4]);
    if (p->shares != NULL) {
        lflare__traced_ray next[2];
        for (k = 0; k < 2; k++) lflare__traced_ray_make(&o->tracer, p->next[k], 0, v.place[0], v.place[1], &next[k]);
        if (next[0].arrives && next[1].arrives) out->apart = 0.5f * scale * hypotf(next[1].sensor[0] - next[0].sensor[0], next[1].sensor[1] - next[0].sensor[1]);
    }
    out->turn = side > 0 ? (float)direction : (float)(2 * o->directions - direction);
    out->bulge = lflare__minf(lflare__maxf(0.125f * chord * chord * v.curved, 0), 0.05f);
}

/* See lflare__patch_band. Outlines are interpolated, and so not exact: a share more on either side. */
static void lflare__traced_band(const lflare__traced_view *o, const lflare__patch_shape *p, float iris_soft, int32_t direction, float *begin, float *end)
{
    const float spare = 0.04f;
    float beside[4], inverse, shrink = o->knot[5] / lflare__maxf(o->knot[6], 1e-6f);
    lflare__profile iris, rim;
    lflare__outline_beside(o, direction, beside);
    shrink *= shrink;
    inverse = 1.1f / lflare__maxf(p->style[3] * beside[2] + fabsf(p->grown) * o->knot[6], 1.5f * p->pixel);
    iris = lflare__profile_make(p->ringing, inverse * iris_soft, inverse * p->widest * lflare__patch_ring(p, shrink, o->knot[4]));
    rim = lflare__profile_make(p->ringing, inverse * lflare__patch_soft(p, beside[3]), inverse * p->widest * lflare__patch_ring(p, shrink, beside[3]));
    *begin = (float)o->rings * lflare__maxf(beside[1] - lflare__maxf(iris.inner, rim.inner) - p->softness - spare, 0);
    *end = (float)o->rings * (1 + lflare__maxf(iris.outer, rim.outer) + p->softness + spare);
}

static int32_t lflare__traced_resolve(const lflare_tables *t, const lflare_frame_data *f, lflare_instance instance, lflare_patch *out)
{
    const lflare_frame_light *l = &f->lights[instance.light];
    int32_t index, sectors, blocks, block, i, k;
    lflare__traced_view o;
    lflare__patch_shape p;
    if (!lflare__traced_view_make(t, instance, l, &index, &o)) return 0;
    sectors = o.directions / 4;
    blocks = o.rings / 4;
    block = index / sectors;
    lflare__patch_shape_make(t, f, l, instance.ghost, &p);
    p.mesh = o.mesh;
    lflare__patch_spectrum(t, instance.ghost, t->outline[(size_t)instance.ghost * LFLARE_OUTLINE_FLOATS + LFLARE__OUTLINE_ONE], &p);
    out->iris_soft = lflare__patch_soft(&p, o.knot[4]);
    lflare__patch_grow(f, o.knot[5], o.knot[6], o.knot[4], o.diffraction, o.knot[7] < 0, &p);
    p.gain *= lflare__instance_share(instance);
    p.middle = o.knot[10];
    p.entrance = o.knot[0];
    if (o.ragged) memset(out->inside, 0, sizeof out->inside);
    for (i = 0; i < LFLARE_PATCH_DIRECTIONS; i++) {
        int32_t direction = index % sectors * (LFLARE_PATCH_DIRECTIONS - 1) + i;
        float side = direction > o.directions ? -1.0f : 1.0f, begin, end;
        if (direction > o.directions) direction = 2 * o.directions - direction;
        lflare__traced_band(&o, &p, out->iris_soft, direction, &begin, &end);
        if (o.ragged) { /* the rim is everywhere, and every block has its part */
            begin = (float)(block * (LFLARE_PATCH_RINGS - 1));
            end = begin + (float)(LFLARE_PATCH_RINGS - 1);
        }
        for (k = 0; k < LFLARE_PATCH_RINGS && !o.ragged; k++)
            lflare__traced_vertex(&o, &p, lflare__minf((float)(block * (LFLARE_PATCH_RINGS - 1) + k), begin), direction, side, &out->inside[k][i]);
        for (k = 0; k < LFLARE_PATCH_BANDS; k++)
            if (o.ragged || block == blocks - 1) lflare__traced_vertex(&o, &p, begin + (end - begin) * (float)k / (LFLARE_PATCH_BANDS - 1), direction, side, &out->rim[k][i]);
    }
    out->rimmed = o.ragged || block == blocks - 1;
    lflare__patch_colour(&p, t->iris.mask != NULL, out);
    return 1;
}

#endif /* LFLARE_NO_TRACE */

LFLARE_API int32_t lflare_patch_resolve(const lflare_tables *t, const lflare_frame_data *f, lflare_instance instance, lflare_patch *out)
{
#ifndef LFLARE_NO_TRACE
    if (t->model == LFLARE_MODEL_TRACED) return lflare__traced_resolve(t, f, instance, out);
#endif
#ifndef LFLARE_NO_ABERRATION
    return lflare__mesh_resolve(t, f, instance, out);
#else
    return 0;
#endif
}

#endif /* LFLARE__PATCHES */

static float lflare__coverage(const lflare_footprint *fp, int32_t k, const lflare_iris *iris, float dx, float dy)
{
    lflare__cuts cuts = lflare__uncut;
    const lflare_edge *e = fp->edges;
    lflare__profile p = lflare__edge_profile(e, k, fp->ringing);
    float sign = e->gain[k] < 0 ? -1.0f : 1.0f, open;
    float ax = e->gain[k] * dx + e->offset[k] * fp->axis[0], ay = e->gain[k] * dy + e->offset[k] * fp->axis[1];
    int32_t i;
    if (iris->dark_outline) p = lflare__profile_dark(p);
    if (iris->blade_count == 0) lflare__cut_circle(&cuts, ax, ay, 1, &p, sign);
    for (i = 0; i < iris->blade_count; i++) {
        const lflare_blade *b = &iris->blades[i];
        if (b->arc > 0) {
            lflare__cut_circle(&cuts, ax + b->nx * b->distance, ay + b->ny * b->distance, b->arc, &p, sign);
        } else {
            lflare__cut(&cuts, &p, b->distance - b->nx * ax - b->ny * ay, -sign * b->nx, -sign * b->ny);
        }
    }
    for (i = 1; i < fp->edge_count; i++) {
        e = &fp->edges[i];
        ax = e->gain[k] * dx + e->offset[k] * fp->axis[0];
        ay = e->gain[k] * dy + e->offset[k] * fp->axis[1];
        p = lflare__edge_profile(e, k, fp->ringing);
        lflare__cut_circle(&cuts, ax, ay, 1, &p, e->gain[k] < 0 ? -1.0f : 1.0f);
    }
    open = lflare__both(&cuts);
#ifndef LFLARE_NO_DIFFRACTION
    if (iris->mask != NULL) {
        lflare__look look;
        e = fp->edges;
        p = lflare__edge_profile(e, k, fp->ringing);
        look = lflare__look_make(iris, p.soft, p.ring);
        open *= lflare__iris_mask(iris, e->gain[k] * dx + e->offset[k] * fp->axis[0], e->gain[k] * dy + e->offset[k] * fp->axis[1], &look);
    }
#endif
    return open;
}

LFLARE_API float lflare_footprint_coverage(const lflare_footprint *fp, int32_t channel, const lflare_iris *iris, float x, float y)
{
    return lflare__coverage(fp, channel, iris, x - fp->centre[channel][0], y - fp->centre[channel][1]);
}

/* >> 14 software */
#ifndef LFLARE_NO_SOFTWARE
/* Row by row, every footprint is an intersection of convex edges, so on a row it is one span. The part where nothing is cut
   is entered as two numbers, +irradiance where it begins and -irradiance where it ends, and summed once per row: the cost
   is that of the outlines, not of the areas. Only pixels on soft edges are evaluated one by one. */

enum { LFLARE__TILE = 2048 }; /* pixels summed at once */

typedef struct lflare__row {
    double run[3][LFLARE__TILE + 1];
    int16_t open[LFLARE__TILE + 1];   /* spans that begin less spans that end: where none is open the sum is 0 exactly */
    uint8_t event[LFLARE__TILE + 16]; /* 1 where any span begins or ends, and behind the last pixel */
} lflare__row;

typedef struct lflare__span {
    double lo, hi; /* empty if lo > hi */
} lflare__span;

static lflare__span lflare__common(lflare__span a, lflare__span b)
{
    a.lo = lflare__max(a.lo, b.lo);
    a.hi = lflare__min(a.hi, b.hi);
    return a;
}

/* An edge or a blade on one row: the height vector is (x0 + step X, y) at pixel X. A circle |a| <= radius, or with `line`
   a half plane normal.a <= radius. */
typedef struct lflare__cutter {
    double x0, step, y, radius;
    lflare__profile profile;
    float nx, ny, sign;
    int32_t line;
    lflare__span inner; /* where it cuts nothing */
} lflare__cutter;

static lflare__span lflare__cutter_span(const lflare__cutter *c, double radius)
{
    lflare__span s = {1, 0};
    if (c->line) {
        double slope = (double)c->nx * c->step, rest = radius - (double)c->ny * c->y - (double)c->nx * c->x0;
        s.lo = -1e9;
        s.hi = 1e9;
        if (fabs(slope) < 1e-12) {
            if (rest < 0) s.lo = 1e9, s.hi = -1e9;
        } else if (slope > 0) {
            s.hi = rest / slope;
        } else {
            s.lo = rest / slope;
        }
    } else if (radius > fabs(c->y)) {
        double root = sqrt((radius - c->y) * (radius + c->y)), a = (-root - c->x0) / c->step, b = (root - c->x0) / c->step;
        s.lo = lflare__min(a, b);
        s.hi = lflare__max(a, b);
    }
    return s;
}

/* A channel on one row: its cutters, the span they leave and the span they leave whole. */
typedef struct lflare__row_shape {
    lflare__cutter cutters[LFLARE_MAX_BLADES + LFLARE_MAX_EDGES];
    int32_t count;
    lflare__span outer, inner;
    const lflare_iris *iris;
    lflare__cutter stop;       /* where the row meets it */
} lflare__row_shape;

static int lflare__row_add(lflare__row_shape *r)
{
    lflare__cutter *c = &r->cutters[r->count++];
    r->outer = lflare__common(r->outer, lflare__cutter_span(c, c->radius + (double)c->profile.outer));
    c->inner = lflare__cutter_span(c, c->radius - (double)c->profile.inner);
    r->inner = lflare__common(r->inner, c->inner);
    return r->outer.lo <= r->outer.hi;
}

/* `dx0`: sensor x of pixel 0 less the footprint's centre, `dx` per pixel, `dy` of the row. 0 if the row is dark. */
static int lflare__row_shape_make(const lflare_footprint *fp, int32_t channel, const lflare_iris *iris, double dx0, double dx, double dy,
                                  lflare__row_shape *r)
{
    int32_t i, k;
    r->count = 0;
    r->iris = iris;
    for (i = 0; i < fp->edge_count; i++) {
        const lflare_edge *e = &fp->edges[i];
        double gain = (double)e->gain[channel], offset = (double)e->offset[channel];
        lflare__cutter edge;
        edge.step = gain * dx;
        if (fabs(edge.step) < 1e-12) edge.step = edge.step < 0 ? -1e-12 : 1e-12;
        edge.x0 = gain * dx0 + offset * (double)fp->axis[0];
        edge.y = gain * dy + offset * (double)fp->axis[1];
        edge.radius = 1;
        edge.profile = lflare__edge_profile(e, channel, fp->ringing);
        edge.sign = gain < 0 ? -1.0f : 1.0f;
        edge.nx = edge.ny = 0;
        edge.line = 0;
        if (i == 0) r->stop = edge;
        if (i == 0 && iris->dark_outline) edge.profile = lflare__profile_dark(edge.profile);
        if (i > 0 || iris->blade_count == 0) {
            r->cutters[r->count] = edge;
            if (!lflare__row_add(r)) return 0;
            continue;
        }
        for (k = 0; k < iris->blade_count; k++) {
            const lflare_blade *b = &iris->blades[k];
            lflare__cutter *c = &r->cutters[r->count];
            *c = edge;
            c->line = !(b->arc > 0);
            c->radius = (double)(c->line ? b->distance : b->arc);
            c->nx = b->nx;
            c->ny = b->ny;
            if (!c->line) {
                c->x0 += (double)(b->nx * b->distance);
                c->y += (double)(b->ny * b->distance);
            }
            if (!lflare__row_add(r)) return 0;
        }
    }
    return 1;
}

/* Pixels from..to-1 (4 floats apart), all on soft edges. */
static void lflare__row_soft(const lflare__row_shape *r, int32_t from, int32_t to, float irradiance, float *pixels)
{
    const lflare__cutter *active[LFLARE_MAX_BLADES + LFLARE_MAX_EDGES];
    lflare__look look = lflare__look_make(r->iris, r->stop.profile.soft, r->stop.profile.ring);
    float open = 1;
    int32_t count = 0, i, x;
    for (i = 0; i < r->count; i++)
        if (r->cutters[i].inner.lo > from || r->cutters[i].inner.hi < to - 1) active[count++] = &r->cutters[i];
    if (count == 1 && !active[0]->line && r->iris->mask == NULL && !(active[0]->profile.ring > 0)) { /* the usual case, kept simple enough to be vectorised */
        float x0 = (float)active[0]->x0, step = (float)active[0]->step, y2 = (float)(active[0]->y * active[0]->y), inv = 1 / active[0]->profile.soft;
        float radius = (float)active[0]->radius;
        for (x = from; x < to; x++) {
            float ax = x0 + step * (float)x, t = (radius - sqrtf(ax * ax + y2)) * inv;
            pixels[(ptrdiff_t)4 * (x - from)] += irradiance * lflare_edge_coverage(t);
        }
        return;
    }
    for (x = from; x < to; x++) {
        lflare__cuts cuts = lflare__uncut;
        for (i = 0; i < count; i++) {
            const lflare__cutter *c = active[i];
            float ax = (float)(c->x0 + c->step * x), ay = (float)c->y;
            if (c->line) {
                lflare__cut(&cuts, &c->profile, (float)c->radius - c->nx * ax - c->ny * ay, -c->sign * c->nx, -c->sign * c->ny);
            } else {
                lflare__cut_circle(&cuts, ax, ay, (float)c->radius, &c->profile, c->sign);
            }
        }
        if (r->iris->mask != NULL) open = lflare__iris_mask(r->iris, (float)(r->stop.x0 + r->stop.step * x), (float)r->stop.y, &look);
        pixels[(ptrdiff_t)4 * (x - from)] += irradiance * open * lflare__both(&cuts);
    }
}

static void lflare__row_edges(const lflare__row_shape *r, int32_t from, int32_t to, float irradiance, float *pixels)
{
    enum { RUN = 64 }; /* short enough that most runs meet one edge only */
    for (; from < to; from += RUN) {
        int32_t end = to - from < RUN ? to : from + RUN;
        lflare__row_soft(r, from, end, irradiance, pixels);
        pixels += (ptrdiff_t)4 * (end - from);
    }
}

/* A footprint of a few pixels: mean of 4 x 4 samples. */
static void lflare__row_fine(const lflare_footprint *fp, int32_t k, const lflare_iris *iris, double dx0, double dy, double wide, double pixel, int32_t from,
                             int32_t to, float *pixels)
{
    double middle = dx0 / wide, reach = (double)fp->radius / wide + 1;
    int32_t begin = (int32_t)lflare__clamp(floor(middle - reach), from, to), end = (int32_t)lflare__clamp(ceil(middle + reach), from, to), x, i;
    for (x = begin; x < end; x++) {
        float sum = 0;
        for (i = 0; i < 16; i++)
            sum += lflare__coverage(fp, k, iris, (float)(dx0 - wide * x - pixel * ((i & 3) - 1.5) * 0.25), (float)(dy + pixel * ((i >> 2) - 1.5) * 0.25));
        pixels[(ptrdiff_t)4 * (x - from)] += fp->irradiance[k] * sum / 16;
    }
}

/* One footprint's channel on one row; pixels[0] is the channel of pixel `from`. */
static void lflare__row_channel(const lflare_footprint *fp, int32_t k, const lflare_iris *iris, const lflare_frame_data *f, double sy, int32_t from,
                                int32_t to, lflare__row *row, float *pixels)
{
    float irradiance = fp->irradiance[k];
    double wide = (double)f->pixel_size[0], high = (double)f->pixel_size[1], dy = sy - (double)fp->centre[k][1];
    double dx0 = (double)f->centre[0] + (0.5 * f->width - 0.5) * wide - (double)fp->centre[k][0]; /* screen = -sensor */
    int32_t begin, end, full, rest;
    lflare__row_shape r;
    if (!(irradiance > 0) || fabs(dy) > (double)fp->radius + high) return;
    if (fp->fine) {
        lflare__row_fine(fp, k, iris, dx0, dy, wide, (double)f->pixel, from, to, pixels);
        return;
    }
    r.outer.lo = r.inner.lo = from - 1.0;
    r.outer.hi = r.inner.hi = to;
    if (!lflare__row_shape_make(fp, k, iris, dx0, -wide, dy, &r)) return;
    begin = (int32_t)lflare__max(floor(r.outer.lo), from);
    end = (int32_t)lflare__min(ceil(r.outer.hi) + 1, to);
    full = rest = end;
    r.inner = lflare__common(r.inner, r.outer);
    if (r.inner.lo <= r.inner.hi && iris->mask == NULL) { /* rounded inwards */
        full = (int32_t)lflare__max(ceil(r.inner.lo), begin);
        rest = (int32_t)lflare__min(floor(r.inner.hi) + 1, end);
        if (full >= rest) full = rest = end;
    }
    lflare__row_edges(&r, begin, full, irradiance, pixels + (ptrdiff_t)4 * (begin - from));
    if (full >= rest) return;
    row->run[k][full - from] += (double)irradiance;
    row->run[k][rest - from] -= (double)irradiance;
    row->open[full - from]++;
    row->open[rest - from]--;
    row->event[full - from] = row->event[rest - from] = 1;
    lflare__row_edges(&r, rest, end, irradiance, pixels + (ptrdiff_t)4 * (rest - from));
}

/* Takes the event at x into the sum and clears it for the next row. */
static int32_t lflare__row_event(lflare__row *row, int32_t x, double *sum)
{
    int32_t k, change = row->open[x];
    for (k = 0; k < 3; k++) {
        sum[k] += row->run[k][x];
        row->run[k][x] = 0;
    }
    row->open[x] = 0;
    row->event[x] = 0;
    return change;
}

/* Between events the sum is constant, and 0 where no span is open. */
static void lflare__row_flush(lflare__row *row, int32_t count, float *pixels)
{
    double sum[3] = {0, 0, 0};
    int32_t x = 0, open = 0;
    row->event[count] = 1;
    while (x < count) {
        int32_t end = x + 1;
        float r, g, b;
        open += lflare__row_event(row, x, sum);
        while (!row->event[end]) end++;
        r = (float)lflare__max(sum[0], 0); /* rounding may leave less than nothing */
        g = (float)lflare__max(sum[1], 0);
        b = (float)lflare__max(sum[2], 0);
        if (open == 0) sum[0] = sum[1] = sum[2] = 0;
        for (; x < end && open > 0; x++) {
            pixels[4 * x] += r;
            pixels[4 * x + 1] += g;
            pixels[4 * x + 2] += b;
        }
        x = end;
    }
    lflare__row_event(row, count, sum);
}

LFLARE_API lflare_result lflare_software_rows(const lflare_footprint *footprints, int32_t count, const lflare_iris *iris, const lflare_frame_data *f,
                                              const lflare_image *image, int32_t begin, int32_t end)
{
    lflare__row row;
    int32_t y, i, k, from;
    ptrdiff_t stride;
    if (f == NULL || iris == NULL || image == NULL || image->pixels == NULL || count < 0 || (count > 0 && footprints == NULL)) return LFLARE_ERROR_ARGUMENT;
    if (image->width != f->width || image->height != f->height || begin < 0 || end > image->height) return LFLARE_ERROR_ARGUMENT;
    stride = image->stride != 0 ? image->stride : (ptrdiff_t)4 * image->width;
    memset(&row, 0, sizeof row);
    for (y = begin; y < end; y++) {
        float *pixels = image->pixels + stride * (image->bottom_up ? image->height - 1 - y : y);
        double sy = (double)f->centre[1] + (y + 0.5 - 0.5 * f->height) * (double)f->pixel_size[1];
        for (from = 0; from < image->width; from += LFLARE__TILE) {
            int32_t to = from + LFLARE__TILE < image->width ? from + LFLARE__TILE : image->width, used = 0;
            for (i = 0; i < count; i++) {
                const lflare_footprint *fp = &footprints[i];
                if (fabs(sy - (double)fp->centre[1][1]) > (double)fp->radius + fabs((double)fp->centre[0][1] - (double)fp->centre[2][1]) + (double)f->pixel_size[1]) continue;
                used = 1;
                for (k = 0; k < 3; k++) lflare__row_channel(fp, k, iris, f, sy, from, to, &row, pixels + (ptrdiff_t)4 * from + k);
            }
            if (used) lflare__row_flush(&row, to - from, pixels + (ptrdiff_t)4 * from);
        }
    }
    return LFLARE_OK;
}

#ifdef LFLARE__PATCHES
/* -- patches -- */

/* A quantity over a triangle, linear: at its first corner, and per pixel. */
typedef struct lflare__plane {
    float at, dx, dy;
} lflare__plane;

/* A triangle in pixels from the top left corner. */
typedef struct lflare__triangle {
    double x[3], y[3], twice_area;
    int32_t begin, end; /* channels lit */
    lflare__plane share[2], irradiance[3], iris[3][2], rim[3], rim_soft, rim_ring, iris_ring, bulge, turn, apart, bundle[2]; /* share: of the second and third corner */
} lflare__triangle;

/* What cuts the triangles of a patch. */
typedef struct lflare__outline {
    const lflare_iris *iris;
    float iris_soft;      /* pixels; 0: nothing does, they lie quite inside */
    const float *ringing; /* NULL: no fringes */
    float waves[LFLARE_WAVELENGTHS]; /* fringes' length over that at the middle wavelength */
    const lflare_tables *t;
    const float *spectrum; /* of lflare_patch; NULL: channels are colours */
    const float *color;
    float between;
    float least;          /* of what a pixel gets: with more than three wavelengths colours may be negative */
} lflare__outline;

/* What of a side lies on a row of pixels: from x = lo to hi, `height` of it, negative if it leads the other way round. */
typedef struct lflare__side {
    double lo, hi, height;
} lflare__side;

static lflare__side lflare__side_on(const lflare__triangle *t, int32_t i, int32_t j, double row)
{
    lflare__side s = {0, 0, 0};
    double top, bottom, slope, a, b, sign = t->twice_area > 0 ? -1 : 1;
    if (t->y[i] > t->y[j]) {
        int32_t swap = i;
        i = j;
        j = swap;
        sign = -sign;
    }
    top = lflare__max(row, t->y[i]);
    bottom = lflare__min(row + 1, t->y[j]);
    if (!(bottom > top)) return s;
    slope = (t->x[j] - t->x[i]) / (t->y[j] - t->y[i]);
    a = t->x[i] + (top - t->y[i]) * slope;
    b = t->x[i] + (bottom - t->y[i]) * slope;
    s.lo = lflare__min(a, b);
    s.hi = lflare__max(a, b);
    s.height = sign * (bottom - top);
    return s;
}

/* Integral of what of a pixel lies to the right of a place t before its right end. */
static double lflare__ramp(double t) { return t <= 0 ? 0 : t < 1 ? 0.5 * t * t : t - 0.5; }

/* Share of the pixel from x to x + 1 that a triangle covers, exactly: areas to the right of its sides. */
static double lflare__covered(const lflare__side *s, double x)
{
    double sum = 0;
    int32_t i;
    for (i = 0; i < 3; i++) {
        if (x >= s[i].hi) sum += s[i].height;
        else if (x + 1 > s[i].lo)
            sum += s[i].height * (s[i].hi - s[i].lo > 1e-9 ? (lflare__ramp(x + 1 - s[i].lo) - lflare__ramp(x + 1 - s[i].hi)) / (s[i].hi - s[i].lo) : x + 1 - s[i].lo);
    }
    return sum;
}

static lflare__plane lflare__plane_make(const lflare__triangle *t, float a, float b, float c)
{
    lflare__plane p;
    double x1 = t->x[1] - t->x[0], y1 = t->y[1] - t->y[0], x2 = t->x[2] - t->x[0], y2 = t->y[2] - t->y[0], u = (double)(b - a), v = (double)(c - a);
    p.at = a;
    p.dx = (float)((u * y2 - v * y1) / t->twice_area);
    p.dy = (float)((v * x1 - u * x2) / t->twice_area);
    return p;
}

static float lflare__plane_at(const lflare__plane *p, float x, float y) { return p->at + p->dx * x + p->dy * y; }

/* Of three planes, `step` from one to the next. */
static lflare__plane lflare__plane_mix(const lflare__plane *p, int32_t step, const float *shares)
{
    lflare__plane sum = {0, 0, 0};
    int32_t k;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++, p += step) {
        sum.at += shares[k] * p->at;
        sum.dx += shares[k] * p->dx;
        sum.dy += shares[k] * p->dy;
    }
    return sum;
}

/* How an edge fades: pixels; what else softens it, in its own units. */
typedef struct lflare__fade {
    float soft, ring, softness;
    const float *ringing;
    int32_t dark; /* see lflare__profile_dark */
} lflare__fade;

/* What cuts at a pixel: places on the iris and on the rim, what a ray is there over the rim, and how they grow. */
typedef struct lflare__height {
    lflare__plane iris[2], rim;
    float x, y, over; /* the planes' values, rim's less 1 */
} lflare__height;

/* An edge where the height, `over` beyond it, grows by (gx, gy) a pixel. Next to caustics heights race: a fade as wide as that would
   light what the iris stops. */
static void lflare__cut_slope(lflare__cuts *cuts, const lflare__fade *fade, float over, float gx, float gy)
{
    float g = lflare__maxf(sqrtf(gx * gx + gy * gy), 1e-20f), pixels = lflare__minf(g, 0.6f), width = fade->soft * pixels;
    lflare__profile p = lflare__profile_make(fade->ringing, sqrtf(width * width + fade->softness * fade->softness), fade->ring * pixels);
    if (fade->dark) p = lflare__profile_dark(p);
    lflare__cut(cuts, &p, -over, -gx / g, -gy / g);
}

/* How far a place on the iris is beyond a blade. */
static float lflare__blade_over(const lflare_blade *b, const lflare__height *h)
{
    if (b->arc > 0) return hypotf(h->x + b->nx * b->distance, h->y + b->ny * b->distance) - b->arc;
    return b->nx * h->x + b->ny * h->y - b->distance;
}

/* From one of many wavelengths to the next the edge moves: as wide as that it is softened, so that they blend into one another. */
static float lflare__blend(float softness, float first, float last)
{
    float step = 0.715f * 0.5f * (last - first);
    return sqrtf(softness * softness + step * step);
}

static void lflare__cut_iris(lflare__cuts *cuts, const lflare__fade *fade, const lflare__height *h, const lflare__height *three, const lflare_blade *b)
{
    lflare__fade f = *fade;
    if (three != NULL) f.softness = lflare__blend(f.softness, lflare__blade_over(b, &three[0]), lflare__blade_over(b, &three[2]));
    if (b->arc > 0) {
        float x = h->x + b->nx * b->distance, y = h->y + b->ny * b->distance, length = sqrtf(x * x + y * y), inv = 1 / lflare__maxf(length, 1e-20f);
        lflare__cut_slope(cuts, &f, length - b->arc, (x * h->iris[0].dx + y * h->iris[1].dx) * inv, (x * h->iris[0].dy + y * h->iris[1].dy) * inv);
    } else {
        lflare__cut_slope(cuts, &f, b->nx * h->x + b->ny * h->y - b->distance, b->nx * h->iris[0].dx + b->ny * h->iris[1].dx, b->nx * h->iris[0].dy + b->ny * h->iris[1].dy);
    }
}

/* Heights at a pixel (x, y) from the first corner, at the wavelength that `shares` make of three; NULL: at the k-th. */
static void lflare__height_at(const lflare__triangle *t, int32_t k, const float *shares, float x, float y, lflare__height *h)
{
    float turn = lflare__plane_at(&t->turn, x, y), bulge = 4 * lflare__plane_at(&t->bulge, x, y), bend = bulge * (1 - 2 * turn);
    if (shares == NULL) {
        memcpy(h->iris, t->iris[k], sizeof h->iris);
        h->rim = t->rim[k];
    } else {
        h->iris[0] = lflare__plane_mix(&t->iris[0][0], 2, shares);
        h->iris[1] = lflare__plane_mix(&t->iris[0][1], 2, shares);
        h->rim = lflare__plane_mix(t->rim, 1, shares);
    }
    h->x = lflare__plane_at(&h->iris[0], x, y);
    h->y = lflare__plane_at(&h->iris[1], x, y);
    h->over = lflare__plane_at(&h->rim, x, y) - 1 - bulge * turn * (1 - turn);
    h->rim.dx -= bend * t->turn.dx;
    h->rim.dy -= bend * t->turn.dy;
}

/* Share of light at a pixel (x, y) from the first corner, where heights are such; wave: fringes' length over the middle wavelength's; three: the
   heights of the three of many wavelengths that are looked at together, NULL if there are only three. */
static float lflare__rim_coverage(const lflare__triangle *t, const lflare__outline *o, const lflare__height *h, const lflare__height *three, float wave, float x, float y)
{
    static const lflare_blade round = {0, 0, 0, 1};
    const lflare_iris *iris = o->iris;
    lflare__cuts cuts = lflare__uncut;
    lflare__fade fade;
    lflare__profile profile;
    lflare__look look;
    float slope, apart = 0.715f * lflare__plane_at(&t->apart, x, y), iris_soft = sqrtf(o->iris_soft * o->iris_soft + apart * apart);
    int32_t i;
    fade.soft = iris_soft;
    fade.ring = wave * lflare__plane_at(&t->iris_ring, x, y);
    fade.softness = iris->softness;
    fade.ringing = o->ringing;
    fade.dark = iris->dark_outline;
    for (i = 0; i < iris->blade_count; i++) lflare__cut_iris(&cuts, &fade, h, three, &iris->blades[i]);
    if (iris->blade_count == 0) lflare__cut_iris(&cuts, &fade, h, three, &round);
    fade.soft = lflare__plane_at(&t->rim_soft, x, y);
    fade.soft = sqrtf(fade.soft * fade.soft + apart * apart);
    fade.ring = wave * lflare__plane_at(&t->rim_ring, x, y);
    fade.softness = three != NULL ? lflare__blend(0, three[0].over, three[2].over) : 0;
    fade.dark = 0;
    lflare__cut_slope(&cuts, &fade, h->over, h->rim.dx, h->rim.dy);
    if (iris->mask == NULL) return lflare__both(&cuts);
    slope = sqrtf(0.5f * (h->iris[0].dx * h->iris[0].dx + h->iris[0].dy * h->iris[0].dy + h->iris[1].dx * h->iris[1].dx + h->iris[1].dy * h->iris[1].dy));
    slope = lflare__minf(slope, 0.6f);
    profile = lflare__profile_make(o->ringing, iris_soft * slope, wave * lflare__plane_at(&t->iris_ring, x, y) * slope);
    look = lflare__look_make(iris, profile.soft, profile.ring);
    return lflare__both(&cuts) * lflare__iris_mask(iris, h->x, h->y, &look);
}

/* Adds what of more than three wavelengths passes at a pixel: three at a time. */
static void lflare__spectrum_pixel(const lflare__triangle *t, const lflare__outline *o, float covered, float x, float y, float *pixel)
{
    lflare__height three[LFLARE_WAVELENGTHS];
    float lit = lflare__maxf(lflare__plane_at(&t->irradiance[0], x, y), 0) * covered, bundle[2];
    int32_t i, j, c;
    for (i = 0; i < 2; i++) bundle[i] = lflare__plane_at(&t->bundle[i], x, y);
    for (i = 0; i < o->t->wavelength_count; i += LFLARE_WAVELENGTHS) {
        for (j = 0; j < LFLARE_WAVELENGTHS; j++) lflare__height_at(t, 0, o->t->spectral[i + j], x, y, &three[j]);
        for (j = 0; j < LFLARE_WAVELENGTHS; j++) {
            const float *row = o->t->spectral[i + j];
            float one = lit * lflare__spectrum_at(o->spectrum, o->between, 1 + i + j, bundle);
            if (!(one > 0)) continue;
            one *= lflare__rim_coverage(t, o, &three[j], three, sqrtf(row[3] / o->t->wavelengths[1]), x, y);
            for (c = 0; c < 3; c++) pixel[c] += one * row[4 + c] * o->color[c];
        }
    }
}

/* Corners to pixels; 0 if nothing is lit of rows begin <= row < end. */
static int lflare__triangle_make(const lflare_patch_vertex *const *v, const lflare_frame_data *f, int rim, int32_t begin, int32_t end, lflare__triangle *t)
{
    float ratio;
    double entrance;
    int32_t i, k;
    for (i = 0; i < 3; i++) {
        t->x[i] = 0.5 * f->width * (1 - ((double)v[i]->position[0] - (double)f->centre[0]) / (double)f->half_width);
        t->y[i] = 0.5 * f->height * (1 + ((double)v[i]->position[1] - (double)f->centre[1]) / (double)f->half_height);
    }
    if ((t->y[0] < begin && t->y[1] < begin && t->y[2] < begin) || (t->y[0] > end && t->y[1] > end && t->y[2] > end)) return 0;
    if ((t->x[0] < 0 && t->x[1] < 0 && t->x[2] < 0) || (t->x[0] > f->width && t->x[1] > f->width && t->x[2] > f->width)) return 0;
    for (t->begin = 3, t->end = k = 0; k < 3; k++) {
        float lit = 0;
        for (i = 0; i < 3; i++) lit = lflare__maxf(lit, fabsf(v[i]->irradiance[k] + v[i]->flux[k]));
        if (!(lit > 0)) continue;
        if (k < t->begin) t->begin = k;
        t->end = k + 1;
    }
    t->twice_area = (t->x[1] - t->x[0]) * (t->y[2] - t->y[0]) - (t->x[2] - t->x[0]) * (t->y[1] - t->y[0]);
    if (t->begin >= t->end || !(fabs(t->twice_area) > 1e-12) || !lflare__finite(t->twice_area)) return 0;
    entrance = (double)(v[1]->entrance[0] - v[0]->entrance[0]) * (double)(v[2]->entrance[1] - v[0]->entrance[1]) -
               (double)(v[2]->entrance[0] - v[0]->entrance[0]) * (double)(v[1]->entrance[1] - v[0]->entrance[1]);
    ratio = (float)fabs(entrance / (t->twice_area * (double)f->pixel * (double)f->pixel));
    for (i = 0; i < 2; i++) t->share[i] = lflare__plane_make(t, 0, i == 0, i == 1);
    for (k = t->begin; k < t->end; k++) {
        float e[3];
        for (i = 0; i < 3; i++) e[i] = v[i]->irradiance[k] + v[i]->flux[k] * ratio;
        t->irradiance[k] = lflare__plane_make(t, e[0], e[1], e[2]);
        if (!rim) continue;
        for (i = 0; i < 2; i++) t->iris[k][i] = lflare__plane_make(t, v[0]->iris[k][i], v[1]->iris[k][i], v[2]->iris[k][i]);
        t->rim[k] = lflare__plane_make(t, v[0]->rim[k], v[1]->rim[k], v[2]->rim[k]);
    }
    if (rim) {
        float least = lflare__minf(v[0]->turn, lflare__minf(v[1]->turn, v[2]->turn)); /* a triangle lies between two directions */
        t->rim_soft = lflare__plane_make(t, v[0]->rim_soft / f->pixel, v[1]->rim_soft / f->pixel, v[2]->rim_soft / f->pixel);
        t->rim_ring = lflare__plane_make(t, v[0]->rim_ring / f->pixel, v[1]->rim_ring / f->pixel, v[2]->rim_ring / f->pixel);
        t->iris_ring = lflare__plane_make(t, v[0]->iris_ring / f->pixel, v[1]->iris_ring / f->pixel, v[2]->iris_ring / f->pixel);
        t->turn = lflare__plane_make(t, v[0]->turn - least, v[1]->turn - least, v[2]->turn - least);
        t->bulge = lflare__plane_make(t, v[0]->bulge, v[1]->bulge, v[2]->bulge);
        for (i = 0; i < 2; i++) t->bundle[i] = lflare__plane_make(t, v[0]->bundle[i], v[1]->bundle[i], v[2]->bundle[i]);
        t->apart = lflare__plane_make(t, v[0]->apart / f->pixel, v[1]->apart / f->pixel, v[2]->apart / f->pixel);
    }
    return 1;
}

/* Moves a point (from the first corner) that lies outside into the triangle: planes do not hold beyond it. */
static void lflare__triangle_clamp(const lflare__triangle *t, float *x, float *y)
{
    float b = lflare__maxf(lflare__plane_at(&t->share[0], *x, *y), 0), c = lflare__maxf(lflare__plane_at(&t->share[1], *x, *y), 0);
    float a = lflare__maxf(1 - lflare__plane_at(&t->share[0], *x, *y) - lflare__plane_at(&t->share[1], *x, *y), 0), sum = a + b + c;
    if (!(sum > 0)) return;
    b /= sum;
    c /= sum;
    *x = b * (float)(t->x[1] - t->x[0]) + c * (float)(t->x[2] - t->x[0]);
    *y = b * (float)(t->y[1] - t->y[0]) + c * (float)(t->y[2] - t->y[0]);
}

/* A pixel of which a triangle covers a share. */
static void lflare__triangle_pixel(const lflare__triangle *t, const lflare__outline *o, float covered, float x, float y, float *pixel)
{
    int32_t k;
    if (covered < 0.999f) lflare__triangle_clamp(t, &x, &y);
    if (o->iris_soft > 0 && o->spectrum != NULL) {
        lflare__spectrum_pixel(t, o, covered, x, y, pixel);
        return;
    }
    for (k = t->begin; k < t->end; k++) {
        float e = lflare__maxf(lflare__plane_at(&t->irradiance[k], x, y), o->least) * covered;
        lflare__height h;
        if (o->iris_soft > 0 && e != 0) {
            lflare__height_at(t, k, NULL, x, y, &h);
            e *= lflare__rim_coverage(t, o, &h, NULL, o->waves[k], x, y);
        }
        pixel[k] += e;
    }
}

/* Pixels from..to-1 of a row, wholly between a triangle's sides: lit evenly but for what their irradiance says. */
static void lflare__triangle_run(const lflare__triangle *t, const lflare__outline *o, int32_t from, int32_t to, float covered, float y, float *pixels)
{
    int32_t x, k;
    for (k = t->begin; k < t->end; k++) {
        const lflare__plane *p = &t->irradiance[k];
        float at = (p->at + p->dy * y + p->dx * (float)(from + 0.5 - t->x[0])) * covered, step = p->dx * covered;
        for (x = from; x < to; x++) pixels[(ptrdiff_t)4 * x + k] += lflare__maxf(at + step * (float)(x - from), o->least);
    }
}

/* One row of a triangle. */
static void lflare__triangle_row(const lflare__triangle *t, const lflare__outline *o, int32_t row, int32_t width, float *pixels)
{
    lflare__side sides[3];
    double lo = 1e300, hi = -1e300, full = -1e300, rest = 1e300, height = 0;
    float y = (float)(row + 0.5 - t->y[0]);
    int32_t x, to, run, run_end;
    for (x = 0; x < 3; x++) {
        sides[x] = lflare__side_on(t, x, (x + 1) % 3, row);
        if (sides[x].height == 0) continue;
        lo = lflare__min(lo, sides[x].lo);
        hi = lflare__max(hi, sides[x].hi);
        if (sides[x].height > 0) {
            full = lflare__max(full, sides[x].hi);
            height += sides[x].height;
        } else {
            rest = lflare__min(rest, sides[x].lo);
        }
    }
    x = (int32_t)lflare__clamp(floor(lo), 0, width);
    to = (int32_t)lflare__clamp(ceil(hi), 0, width);
    run = (int32_t)lflare__clamp(ceil(full), x, to);
    run_end = (int32_t)lflare__clamp(floor(rest), run, to);
    if (o->iris_soft > 0 || run_end - run < 2) run = run_end = to;
    for (; x < to; x++) {
        float covered;
        if (x == run && run < run_end) {
            lflare__triangle_run(t, o, run, run_end, (float)height, y, pixels);
            x = run_end - 1;
            continue;
        }
        covered = (float)lflare__covered(sides, x);
        if (covered > 0) lflare__triangle_pixel(t, o, covered, (float)(x + 0.5 - t->x[0]), y, pixels + (ptrdiff_t)4 * x);
    }
}

/* One triangle on rows begin <= row < end. */
static void lflare__triangle_draw(const lflare_patch_vertex *const *v, const lflare_frame_data *f, const lflare__outline *o,
                                  const lflare_image *image, int32_t begin, int32_t end)
{
    ptrdiff_t stride = image->stride != 0 ? image->stride : (ptrdiff_t)4 * image->width;
    lflare__triangle t;
    int32_t row;
    if (!lflare__triangle_make(v, f, o->iris_soft > 0, begin, end, &t)) return;
    begin = (int32_t)lflare__clamp(floor(lflare__min(t.y[0], lflare__min(t.y[1], t.y[2]))), begin, end);
    end = (int32_t)lflare__clamp(ceil(lflare__max(t.y[0], lflare__max(t.y[1], t.y[2]))), begin, end);
    for (row = begin; row < end; row++)
        lflare__triangle_row(&t, o, row, image->width, image->pixels + stride * (image->bottom_up ? image->height - 1 - row : row));
}

static void lflare__quads_draw(const lflare_patch_vertex *a, const lflare_patch_vertex *b, const lflare_frame_data *f, const lflare__outline *o,
                               const lflare_image *image, int32_t begin, int32_t end)
{
    int32_t i;
    for (i = 0; i + 1 < LFLARE_PATCH_DIRECTIONS; i++) {
        const lflare_patch_vertex *v[4];
        v[0] = &a[i];
        v[1] = &b[i];
        v[2] = &a[i + 1];
        v[3] = &b[i + 1];
        lflare__triangle_draw(v, f, o, image, begin, end);
        lflare__triangle_draw(v + 1, f, o, image, begin, end);
    }
}

LFLARE_API lflare_result lflare_software_patches(const lflare_tables *t, const lflare_frame_data *f, const lflare_image *image, int32_t begin, int32_t end)
{
    lflare__outline o;
    lflare_patch patch;
    int32_t i, k;
    if (t == NULL || f == NULL || image == NULL || image->pixels == NULL || t->model == LFLARE_MODEL_PARAXIAL) return LFLARE_ERROR_ARGUMENT;
    if (image->width != f->width || image->height != f->height || begin < 0 || end > image->height) return LFLARE_ERROR_ARGUMENT;
    o.iris = &t->iris;
    o.ringing = t->fringes ? t->ringing : NULL;
    o.t = t;
    o.least = t->wavelength_count > 0 ? -1e30f : 0;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) o.waves[k] = sqrtf(t->wavelengths[k] / t->wavelengths[1]);
    for (i = 0; i < f->instance_count; i++) {
        if (!lflare_patch_resolve(t, f, f->instances[i], &patch)) continue;
        o.spectrum = patch.spectrum;
        o.color = patch.color;
        o.between = patch.between;
        o.iris_soft = t->iris.mask != NULL ? patch.iris_soft / f->pixel : 0; /* a mask is looked up everywhere */
        for (k = 0; k + 1 < LFLARE_PATCH_RINGS; k++) lflare__quads_draw(patch.inside[k], patch.inside[k + 1], f, &o, image, begin, end);
        o.iris_soft = patch.iris_soft / f->pixel;
        for (k = 0; k + 1 < LFLARE_PATCH_BANDS && patch.rimmed; k++) lflare__quads_draw(patch.rim[k], patch.rim[k + 1], f, &o, image, begin, end);
    }
    return LFLARE_OK;
}

#endif /* LFLARE__PATCHES */

/* -- the light's own image -- */

/* One row of a light's streak: `y` from its middle, `half` its thickness, mm. */
static void lflare__streak_row(const lflare_tables *t, const lflare_frame_light *l, float x0, float step, float y, float half, int32_t width, float *pixels)
{
    float u = 1 - y * y / (half * half), across = 0.9375f * u * u / half;
    int32_t x, k;
    if (!(u > 0)) return;
    for (x = 0; x < width; x++) {
        float along = 1 - fabsf(x0 + step * (float)x) / l->streak, share = 2 / l->streak * along * along * along * across;
        for (k = 0; k < LFLARE_WAVELENGTHS && along > 0; k++) pixels[(ptrdiff_t)4 * x + k] += t->streak_gain[k] * l->irradiance[k] * share;
    }
}

LFLARE_API lflare_result lflare_software_starbursts(const lflare_tables *t, const lflare_frame_data *f, const lflare_image *image, int32_t begin, int32_t end)
{
    ptrdiff_t stride;
    int32_t i, k, x, y;
    if (t == NULL || f == NULL || image == NULL || image->pixels == NULL) return LFLARE_ERROR_ARGUMENT;
    if (image->width != f->width || image->height != f->height || begin < 0 || end > image->height) return LFLARE_ERROR_ARGUMENT;
    stride = image->stride != 0 ? image->stride : (ptrdiff_t)4 * image->width;
    for (y = begin; y < end; y++) {
        float *pixels = image->pixels + stride * (image->bottom_up ? image->height - 1 - y : y);
        for (i = 0; i < f->light_count; i++) {
            const lflare_frame_light *l = &f->lights[i];
            /* from the image of the light, on the sensor, which is the picture turned round */
            float sensor_y = f->centre[1] - f->half_height + ((float)y + 0.5f) * f->pixel_size[1] - l->image[1], wide = f->pixel_size[0], x0 = f->centre[0] + f->half_width - 0.5f * wide - l->image[0];
            if (l->streak > 0) lflare__streak_row(t, l, x0, -wide, sensor_y, lflare__streak_thickness(t, l, f->pixel), f->width, pixels);
#ifndef LFLARE_NO_DIFFRACTION
            if (l->starburst > 0 && fabsf(sensor_y) < l->starburst) {
                float inverse = 1 / t->starburst_unit, blur = lflare__image_blur(t, l, f->pixel) * inverse, rgb[LFLARE_WAVELENGTHS];
                int32_t from = (int32_t)lflare__clamp((double)((x0 - l->starburst) / wide), 0, f->width), to = (int32_t)lflare__clamp((double)((x0 + l->starburst) / wide) + 1, 0, f->width);
                for (x = from; x < to; x++) {
                    lflare_starburst_at(t->starburst, (x0 - wide * (float)x) * inverse, sensor_y * inverse, blur, rgb);
                    for (k = 0; k < LFLARE_WAVELENGTHS; k++) pixels[(ptrdiff_t)4 * x + k] += t->starburst_gain[k] * l->irradiance[k] * rgb[k];
                }
            }
#else
            (void)x;
            (void)k;
#endif
        }
    }
    return LFLARE_OK;
}

LFLARE_API void lflare_to_rgb8(const float *rgba, size_t count, float gain, int32_t srgb, uint8_t *out)
{
    size_t i;
    int32_t k;
    for (i = 0; i < count; i++)
        for (k = 0; k < 3; k++) {
            float v = rgba[4 * i + (size_t)k] * gain;
            v = v > 0 ? lflare__minf(v, 1) : 0; /* NaN becomes 0 */
            if (srgb) v = v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1 / 2.4f) - 0.055f;
            out[3 * i + (size_t)k] = (uint8_t)(255 * v + 0.5f);
        }
}
#endif /* LFLARE_NO_SOFTWARE */

/* >> 15 gl */
#ifndef LFLARE_NO_GL
/* No GL header: names, constants and functions are private. Every function comes from the caller's loader. */

#if defined(_WIN32) && !defined(_WIN64)
#define LFLARE__GLCALL __stdcall
#else
#define LFLARE__GLCALL
#endif

typedef unsigned int lflare__glenum;
typedef unsigned int lflare__gluint;
typedef int lflare__glint;

/* What has a function or a state: all, all but ES and WebGL, WebGL alone. */
enum { LFLARE__GL_ALL, LFLARE__GL_DESKTOP, LFLARE__GL_WEB };

/* One row per function: who has it, result, name, arguments. */
#define LFLARE__GL_FUNCTIONS(X)                                                                                       \
    X(LFLARE__GL_ALL, void, ActiveTexture, (lflare__glenum))                                                                       \
    X(LFLARE__GL_ALL, void, AttachShader, (lflare__gluint, lflare__gluint))                                                        \
    X(LFLARE__GL_ALL, void, BindAttribLocation, (lflare__gluint, lflare__gluint, const char *))                                    \
    X(LFLARE__GL_ALL, void, BindBuffer, (lflare__glenum, lflare__gluint))                                                          \
    X(LFLARE__GL_ALL, void, BindBufferBase, (lflare__glenum, lflare__gluint, lflare__gluint))                                      \
    X(LFLARE__GL_ALL, void, BindBufferRange, (lflare__glenum, lflare__gluint, lflare__gluint, ptrdiff_t, ptrdiff_t))               \
    X(LFLARE__GL_ALL, void, BindFramebuffer, (lflare__glenum, lflare__gluint))                                                     \
    X(LFLARE__GL_ALL, void, BindSampler, (lflare__gluint, lflare__gluint))                                                         \
    X(LFLARE__GL_ALL, void, BindTexture, (lflare__glenum, lflare__gluint))                                                         \
    X(LFLARE__GL_ALL, void, BindVertexArray, (lflare__gluint))                                                                     \
    X(LFLARE__GL_ALL, void, BlendEquationSeparate, (lflare__glenum, lflare__glenum))                                               \
    X(LFLARE__GL_ALL, void, BlendFuncSeparate, (lflare__glenum, lflare__glenum, lflare__glenum, lflare__glenum))                   \
    X(LFLARE__GL_ALL, void, BufferData, (lflare__glenum, ptrdiff_t, const void *, lflare__glenum))                                 \
    X(LFLARE__GL_ALL, void, BufferSubData, (lflare__glenum, ptrdiff_t, ptrdiff_t, const void *))                                   \
    X(LFLARE__GL_ALL, lflare__glenum, CheckFramebufferStatus, (lflare__glenum))                                                    \
    X(LFLARE__GL_ALL, void, ClearBufferfv, (lflare__glenum, lflare__glint, const float *))                                         \
    X(LFLARE__GL_ALL, void, ColorMask, (unsigned char, unsigned char, unsigned char, unsigned char))                               \
    X(LFLARE__GL_ALL, void, CompileShader, (lflare__gluint))                                                                       \
    X(LFLARE__GL_ALL, lflare__gluint, CreateProgram, (void))                                                                       \
    X(LFLARE__GL_ALL, lflare__gluint, CreateShader, (lflare__glenum))                                                              \
    X(LFLARE__GL_ALL, void, DeleteBuffers, (int, const lflare__gluint *))                                                          \
    X(LFLARE__GL_ALL, void, DeleteFramebuffers, (int, const lflare__gluint *))                                                     \
    X(LFLARE__GL_ALL, void, DeleteProgram, (lflare__gluint))                                                                       \
    X(LFLARE__GL_ALL, void, DeleteSamplers, (int, const lflare__gluint *))                                                         \
    X(LFLARE__GL_ALL, void, DeleteShader, (lflare__gluint))                                                                        \
    X(LFLARE__GL_ALL, void, DeleteTextures, (int, const lflare__gluint *))                                                         \
    X(LFLARE__GL_ALL, void, DeleteVertexArrays, (int, const lflare__gluint *))                                                     \
    X(LFLARE__GL_ALL, void, Disable, (lflare__glenum))                                                                             \
    X(LFLARE__GL_ALL, void, DrawArraysInstanced, (lflare__glenum, int, int, int))                                                  \
    X(LFLARE__GL_ALL, void, DrawElementsInstanced, (lflare__glenum, int, lflare__glenum, const void *, int))                       \
    X(LFLARE__GL_ALL, void, Enable, (lflare__glenum))                                                                              \
    X(LFLARE__GL_ALL, void, EnableVertexAttribArray, (lflare__gluint))                                                             \
    X(LFLARE__GL_ALL, void, FramebufferTexture2D, (lflare__glenum, lflare__glenum, lflare__glenum, lflare__gluint, lflare__glint)) \
    X(LFLARE__GL_ALL, void, GenBuffers, (int, lflare__gluint *))                                                                   \
    X(LFLARE__GL_ALL, void, GenFramebuffers, (int, lflare__gluint *))                                                              \
    X(LFLARE__GL_ALL, void, GenSamplers, (int, lflare__gluint *))                                                                  \
    X(LFLARE__GL_ALL, void, GenTextures, (int, lflare__gluint *))                                                                  \
    X(LFLARE__GL_ALL, void, GenVertexArrays, (int, lflare__gluint *))                                                              \
    X(LFLARE__GL_ALL, void, GetInteger64i_v, (lflare__glenum, lflare__gluint, int64_t *))                                          \
    X(LFLARE__GL_ALL, void, GetIntegeri_v, (lflare__glenum, lflare__gluint, lflare__glint *))                                      \
    X(LFLARE__GL_ALL, void, GetIntegerv, (lflare__glenum, lflare__glint *))                                                        \
    X(LFLARE__GL_ALL, void, GetProgramInfoLog, (lflare__gluint, int, int *, char *))                                               \
    X(LFLARE__GL_ALL, void, GetProgramiv, (lflare__gluint, lflare__glenum, lflare__glint *))                                       \
    X(LFLARE__GL_ALL, void, GetShaderInfoLog, (lflare__gluint, int, int *, char *))                                                \
    X(LFLARE__GL_ALL, void, GetShaderiv, (lflare__gluint, lflare__glenum, lflare__glint *))                                        \
    X(LFLARE__GL_ALL, const unsigned char *, GetString, (lflare__glenum))                                                          \
    X(LFLARE__GL_ALL, lflare__gluint, GetUniformBlockIndex, (lflare__gluint, const char *))                                        \
    X(LFLARE__GL_ALL, lflare__glint, GetUniformLocation, (lflare__gluint, const char *))                                           \
    X(LFLARE__GL_ALL, unsigned char, IsEnabled, (lflare__glenum))                                                                  \
    X(LFLARE__GL_ALL, void, LinkProgram, (lflare__gluint))                                                                         \
    X(LFLARE__GL_ALL, void, PixelStorei, (lflare__glenum, lflare__glint))                                                          \
    X(LFLARE__GL_DESKTOP, void, PolygonMode, (lflare__glenum, lflare__glenum))                                                         \
    X(LFLARE__GL_ALL, void, SamplerParameteri, (lflare__gluint, lflare__glenum, lflare__glint))                                    \
    X(LFLARE__GL_ALL, void, ShaderSource, (lflare__gluint, int, const char *const *, const lflare__glint *))                       \
    X(LFLARE__GL_ALL, void, TexImage2D, (lflare__glenum, lflare__glint, lflare__glint, int, int, lflare__glint, lflare__glenum, lflare__glenum, const void *))\
    X(LFLARE__GL_ALL, void, TexParameteri, (lflare__glenum, lflare__glenum, lflare__glint))                                        \
    X(LFLARE__GL_ALL, void, Uniform1i, (lflare__glint, lflare__glint))                                                             \
    X(LFLARE__GL_ALL, void, Uniform3f, (lflare__glint, float, float, float))                                                       \
    X(LFLARE__GL_ALL, void, UniformBlockBinding, (lflare__gluint, lflare__gluint, lflare__gluint))                                 \
    X(LFLARE__GL_ALL, void, UseProgram, (lflare__gluint))                                                                          \
    X(LFLARE__GL_ALL, void, VertexAttribDivisor, (lflare__gluint, lflare__gluint))                                                 \
    X(LFLARE__GL_ALL, void, VertexAttribIPointer, (lflare__gluint, lflare__glint, lflare__glenum, int, const void *))              \
    X(LFLARE__GL_ALL, void, Viewport, (lflare__glint, lflare__glint, int, int))

#define LFLARE__GL_MEMBER(who, result, name, arguments) result(LFLARE__GLCALL *name) arguments;
typedef struct lflare__glapi {
    LFLARE__GL_FUNCTIONS(LFLARE__GL_MEMBER)
} lflare__glapi;
#undef LFLARE__GL_MEMBER

enum {
    LFLARE__GL_UNITS = 6,
    LFLARE__GL_ROW = 1024, /* texels of a line of the tables' textures */
    LFLARE__GL_LENS_TEXELS = 4 + 3 * LFLARE_MAX_RIMS,
    LFLARE__GL_SETTINGS_TEXELS = 2 * LFLARE_FIELD_SAMPLES + LFLARE_STYLE_FLOATS / 4,
    LFLARE__GL_RING = 34,   /* vertices of a ghost's rim, of its inside */
    LFLARE__GL_INSIDE = 18,
    LFLARE__GL_PATCH_ROW = 6 * (LFLARE_PATCH_DIRECTIONS - 1), /* indices of a row of a patch's quads */
    LFLARE__GL_PATCH = LFLARE__GL_PATCH_ROW * (LFLARE_PATCH_RINGS - 1)
};

enum { LFLARE__GL_RIM, LFLARE__GL_RIM_FRINGES, LFLARE__GL_FILL, LFLARE__GL_STRIP, LFLARE__GL_ADD, LFLARE__GL_PATCHES, LFLARE__GL_PATCH_RIMS,
       LFLARE__GL_PATCH_FRINGES, LFLARE__GL_PATCHES_MASKED,
       LFLARE__GL_TRACED, LFLARE__GL_TRACED_RIMS, LFLARE__GL_TRACED_FRINGES, LFLARE__GL_TRACED_MASKED, LFLARE__GL_STARBURST, LFLARE__GL_PROGRAMS };
enum { LFLARE__GL_LENS, LFLARE__GL_SETTINGS, LFLARE__GL_STRIP_A, LFLARE__GL_STRIP_B, LFLARE__GL_HALF, LFLARE__GL_MESH, LFLARE__GL_MESH_HEADS, LFLARE__GL_ANGULAR, LFLARE__GL_RADIAL, LFLARE__GL_MASK, LFLARE__GL_RINGING, LFLARE__GL_FRINGED, LFLARE__GL_TRACED_LENS, LFLARE__GL_TRACED_GHOSTS, LFLARE__GL_TEXTURES };
enum { LFLARE__GL_TO_STRIP_A, LFLARE__GL_TO_STRIP_B, LFLARE__GL_TO_HALF, LFLARE__GL_FRAMEBUFFERS };

/* All state that is touched, in the order of its restoring. Capabilities: enum, who has it, what drawing needs (2: as the
   caller has it). Values: enum to ask, who has it, how to set (v: the values). Per texture unit and the indexed uniform buffer
   are below. The paragraph "GL STATE" of the documentation lists the same names. */
#define LFLARE__GL_CAPABILITIES(X)                         \
    X(0x0BE2, LFLARE__GL_ALL, 1, BLEND)                    \
    X(0x0B71, LFLARE__GL_ALL, 0, DEPTH_TEST)               \
    X(0x0B90, LFLARE__GL_ALL, 0, STENCIL_TEST)             \
    X(0x0B44, LFLARE__GL_ALL, 0, CULL_FACE)                \
    X(0x0C11, LFLARE__GL_ALL, 2, SCISSOR_TEST)             \
    X(0x8C89, LFLARE__GL_ALL, 0, RASTERIZER_DISCARD)       \
    X(0x809E, LFLARE__GL_ALL, 0, SAMPLE_ALPHA_TO_COVERAGE) \
    X(0x80A0, LFLARE__GL_ALL, 0, SAMPLE_COVERAGE)          \
    X(0x8E51, LFLARE__GL_DESKTOP, 0, SAMPLE_MASK)          \
    X(0x0BF2, LFLARE__GL_DESKTOP, 0, COLOR_LOGIC_OP)       \
    X(0x8F9D, LFLARE__GL_DESKTOP, 0, PRIMITIVE_RESTART)    \
    X(0x3000, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE0)       \
    X(0x3001, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE1)       \
    X(0x3002, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE2)       \
    X(0x3003, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE3)       \
    X(0x3004, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE4)       \
    X(0x3005, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE5)       \
    X(0x3006, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE6)       \
    X(0x3007, LFLARE__GL_DESKTOP, 0, CLIP_DISTANCE7)

#define LFLARE__GL_VALUES(X)                                                                                              \
    X(0x0C23, LFLARE__GL_ALL, COLOR_WRITEMASK, gl->ColorMask(v[0] != 0, v[1] != 0, v[2] != 0, v[3] != 0))                 \
    X(0x80C9, LFLARE__GL_ALL, BLEND_SRC_RGB, blend[0] = (lflare__glenum)v[0])                                             \
    X(0x80C8, LFLARE__GL_ALL, BLEND_DST_RGB, blend[1] = (lflare__glenum)v[0])                                             \
    X(0x80CB, LFLARE__GL_ALL, BLEND_SRC_ALPHA, blend[2] = (lflare__glenum)v[0])                                           \
    X(0x80CA, LFLARE__GL_ALL, BLEND_DST_ALPHA, gl->BlendFuncSeparate(blend[0], blend[1], blend[2], (lflare__glenum)v[0])) \
    X(0x8009, LFLARE__GL_ALL, BLEND_EQUATION_RGB, blend[0] = (lflare__glenum)v[0])                                        \
    X(0x883D, LFLARE__GL_ALL, BLEND_EQUATION_ALPHA, gl->BlendEquationSeparate(blend[0], (lflare__glenum)v[0]))            \
    X(0x8B8D, LFLARE__GL_ALL, CURRENT_PROGRAM, gl->UseProgram((lflare__gluint)v[0]))                                      \
    X(0x85B5, LFLARE__GL_ALL, VERTEX_ARRAY_BINDING, gl->BindVertexArray((lflare__gluint)v[0]))                            \
    X(0x8894, LFLARE__GL_ALL, ARRAY_BUFFER_BINDING, gl->BindBuffer(0x8892, (lflare__gluint)v[0]))                         \
    X(0x8A28, LFLARE__GL_ALL, UNIFORM_BUFFER_BINDING, gl->BindBuffer(0x8A11, (lflare__gluint)v[0]))                       \
    X(0x88EF, LFLARE__GL_ALL, PIXEL_UNPACK_BUFFER_BINDING, gl->BindBuffer(0x88EC, (lflare__gluint)v[0]))                  \
    X(0x0CF5, LFLARE__GL_ALL, UNPACK_ALIGNMENT, gl->PixelStorei(0x0CF5, v[0]))                                            \
    X(0x0CF0, LFLARE__GL_DESKTOP, UNPACK_SWAP_BYTES, gl->PixelStorei(0x0CF0, v[0]))                                       \
    X(0x0CF2, LFLARE__GL_ALL, UNPACK_ROW_LENGTH, gl->PixelStorei(0x0CF2, v[0]))                                           \
    X(0x0CF3, LFLARE__GL_ALL, UNPACK_SKIP_ROWS, gl->PixelStorei(0x0CF3, v[0]))                                            \
    X(0x0CF4, LFLARE__GL_ALL, UNPACK_SKIP_PIXELS, gl->PixelStorei(0x0CF4, v[0]))                                          \
    X(0x0B40, LFLARE__GL_DESKTOP, POLYGON_MODE, gl->PolygonMode(0x0408, (lflare__glenum)v[0]))                            \
    X(0x9240, LFLARE__GL_WEB, UNPACK_FLIP_Y_WEBGL, gl->PixelStorei(0x9240, v[0]))                                         \
    X(0x9241, LFLARE__GL_WEB, UNPACK_PREMULTIPLY_ALPHA_WEBGL, gl->PixelStorei(0x9241, v[0]))                              \
    X(0x8CA6, LFLARE__GL_ALL, DRAW_FRAMEBUFFER_BINDING, gl->BindFramebuffer(0x8CA9, (lflare__gluint)v[0]))                \
    X(0x0BA2, LFLARE__GL_ALL, VIEWPORT, gl->Viewport(v[0], v[1], v[2], v[3]))                                             \
    X(0x84E0, LFLARE__GL_ALL, ACTIVE_TEXTURE, gl->ActiveTexture((lflare__glenum)v[0]))

#define LFLARE__GL_COUNT(...) +1
enum { LFLARE__GL_CAPABILITY_COUNT = 0 LFLARE__GL_CAPABILITIES(LFLARE__GL_COUNT), LFLARE__GL_VALUE_COUNT = 0 LFLARE__GL_VALUES(LFLARE__GL_COUNT) };
#undef LFLARE__GL_COUNT

typedef struct lflare__glstate {
    unsigned char capability[LFLARE__GL_CAPABILITY_COUNT];
    lflare__glint value[LFLARE__GL_VALUE_COUNT][4];
    lflare__glint texture[LFLARE__GL_UNITS], sampler[LFLARE__GL_UNITS];
    lflare__glint uniform_buffer;
    int64_t uniform_start, uniform_size;
} lflare__glstate;

/* Has the layout of the block in shaders_embedded/frame.glsl. */
typedef struct lflare__gl_frame {
    float half[4], lens[4], spectrum[4], strip[4], burst[3][4];
    float blades[LFLARE_MAX_BLADES][4];
    float bands[4], spectral[LFLARE_MAX_WAVELENGTHS + 1][8];
    lflare_frame_light lights[LFLARE_GL_MAX_LIGHTS];
} lflare__gl_frame;

/* That of the block in shaders_embedded/strip.frag.glsl. */
typedef struct lflare__gl_strip {
    float clip[3][4], region[4], fade[4];
    float disc[LFLARE_GL_MAX_LIGHTS][4];
} lflare__gl_strip;

struct lflare_gl {
    lflare__glapi api;
    lflare_realloc allocate;
    void *user;
    int32_t no_restore, es, web, forgotten;
    uint32_t models; /* as in lflare_gl_desc, all where that is 0 */
    lflare__gluint programs[LFLARE__GL_PROGRAMS], textures[LFLARE__GL_TEXTURES], framebuffers[LFLARE__GL_FRAMEBUFFERS];
    lflare__gluint vertex_array, instances, indices, uniforms, sampler;
    lflare__glint enlarge;                  /* location of a uniform */
    uint64_t lens_hash, settings_hash, mesh_hash, heads_hash, burst_key, mask_hash, fringed_hash, traced_lens_hash, traced_hash; /* of what was uploaded */
    int32_t uploaded;                       /* bit 0: something of the lens, 1: of the settings, 2: meshes, 3: their heads, 4: ringing */
    int32_t strip_lights, strip_now;        /* lights that the strip holds, which of the two strips */
    int32_t full_width, full_height;        /* of the half-size picture, when enlarged; 0 = none */
    int32_t half_empty, coarse;             /* nothing was drawn into it; it is RGB10_A2 */
    lflare__glint max_size;                 /* of a texture */
    float half_gain;                        /* on what is stored in it */
    union {
        lflare__gl_frame frame;
        lflare__gl_strip strip;
    } block;                                /* made here, then uploaded */
};

/* -- shaders begin (made by `make shaders` from shaders_embedded; edit there) */
static const char *const lflare__glsl_add_frag[] = {
    "uniform highp sampler2D u_half_picture;\n"
    "uniform vec3 u_enlarge;\n"
    "in vec2 v_place;\n"
    "out vec4 o_color;\n"
    "void main() { o_color = vec4(texture(u_half_picture, v_place * u_enlarge.xy).rgb * u_enlarge.z, 0.0); }\n"
    , NULL};
static const char *const lflare__glsl_cuts[] = {
    "uniform highp sampler2D u_ringing;\n"
    "uniform highp sampler2D u_mask;\n"
    "uniform highp sampler2D u_fringed;\n"
    "vec3 t1, t2, nx1, ny1, nx2, ny2;\n"
    "#ifdef FRINGES\n"
    "vec3 s1, s2, r1, r2;\n"
    "#endif\n"
    "void uncut()\n"
    "{\n"
    "t1 = t2 = vec3(1.0);\n"
    "nx1 = ny1 = nx2 = ny2 = vec3(0.0);\n"
    "#ifdef FRINGES\n"
    "s1 = s2 = vec3(1.0);\n"
    "r1 = r2 = vec3(0.0);\n"
    "#endif\n"
    "}\n"
    "void cut(Profile p, vec3 d, vec3 nx, vec3 ny)\n"
    "{\n"
    "vec3 t = max(d / mix(p.outer, p.inner, greaterThan(d, vec3(0.0))), -1.0);\n"
    "bvec3 first = lessThan(t, t1), second = lessThan(t, t2);\n"
    "t2 = mix(mix(t2, t, second), t1, first);\n"
    "nx2 = mix(mix(nx2, nx, second), nx1, first);\n"
    "ny2 = mix(mix(ny2, ny, second), ny1, first);\n"
    "t1 = mix(t1, t, first);\n"
    "nx1 = mix(nx1, nx, first);\n"
    "ny1 = mix(ny1, ny, first);\n"
    "#ifdef FRINGES\n"
    "s2 = mix(mix(s2, p.soft, second), s1, first);\n"
    "r2 = mix(mix(r2, p.ring, second), r1, first);\n"
    "s1 = mix(s1, p.soft, first);\n"
    "r1 = mix(r1, p.ring, first);\n"
    "#endif\n"
    "}\n"
    "vec3 plain_at(vec3 t)\n"
    "{\n"
    "t = clamp(t, -1.0, 1.0);\n"
    "return 0.5 + t * (0.75 - 0.25 * t * t);\n"
    "}\n"
    "#ifdef FRINGES\n"
    "vec3 profile_at(vec3 t, vec3 soft, vec3 ring)\n"
    "{\n"
    "vec3 inner = soft + 5.0 * max(ring, 0.0), outer = soft + 2.5 * abs(ring), d = t * mix(outer, inner, greaterThan(t, vec3(0.0)));\n"
    "vec3 beyond = 1.25 * max(-ring, 0.0), plain = plain_at((d + beyond) / (soft + beyond));\n"
    "if (all(lessThanEqual(ring, vec3(0.0)))) return plain;\n"
    "vec3 blur = soft / max(ring, vec3(1e-20)), u = clamp((d + outer) / (inner + outer), 0.0, 1.0), v = min(blur / (blur + 2.0) * 1.25, 1.0);\n"
    "u = (u * 255.0 + 0.5) / 256.0;\n"
    "v = (v * 15.0 + 0.5) / 16.0;\n"
    "vec3 fringes = vec3(texture(u_ringing, vec2(u.x, v.x)).r, texture(u_ringing, vec2(u.y, v.y)).r, texture(u_ringing, vec2(u.z, v.z)).r);\n"
    "return mix(plain, fringes, greaterThan(ring, vec3(0.0)));\n"
    "}\n"
    "#endif\n"
    "#ifdef FRINGES\n"
    "float fringed(float view, float lod, vec2 at)\n"
    "{\n"
    "float edge = exp2(ceil(lod)) / 512.0;\n"
    "return 2.0 * textureLod(u_fringed, (vec2(mod(view, 5.0), floor(view / 5.0)) + clamp(at, edge, 1.0 - edge)) / 5.0, lod).r;\n"
    "}\n"
    "float mask_at(float x, float y, float soft, float ring)\n"
    "{\n"
    "vec2 at = vec2(x, y) * 0.5 + 0.5;\n"
    "float lod = clamp(log2(0.894 * 256.0 * soft), 0.0, 9.0), plain = textureLod(u_mask, at, lod).r;\n"
    "if (mod(u_strip.z, 2.0) == 1.0 || ring == 0.0) return plain;\n"
    "float view = 5.0 * log2(0.4 / ring), fade = clamp(5.8 - 0.2 * view, 0.0, 1.0);\n"
    "lod = max(lod - 1.0, 0.0);\n"
    "view = min(view, 24.0);\n"
    "float first = min(floor(view), 23.0), fine = fringed(first, lod, at);\n"
    "return mix(plain, mix(fine, fringed(first + 1.0, lod, at), view - first), fade);\n"
    "}\n"
    "vec3 mask(vec3 x, vec3 y, Profile p)\n"
    "{\n"
    "return vec3(mask_at(x.x, y.x, p.soft.x, p.ring.x), mask_at(x.y, y.y, p.soft.y, p.ring.y), mask_at(x.z, y.z, p.soft.z, p.ring.z));\n"
    "}\n"
    "#endif\n"
    "vec3 within()\n"
    "{\n"
    "#ifdef FRINGES\n"
    "vec3 c1 = profile_at(t1, s1, r1), c2 = profile_at(t2, s2, r2);\n"
    "#else\n"
    "vec3 c1 = plain_at(t1), c2 = plain_at(t2);\n"
    "#endif\n"
    "vec3 rho = clamp(nx1 * nx2 + ny1 * ny2, -1.0, 1.0), both = c1 * c2;\n"
    "vec3 less = both - rho * (max(min(c1, 1.0) + min(c2, 1.0) - 1.0, 0.0) - both), more = both + rho * (c1 - both);\n"
    ,
    "return mix(mix(less, more, greaterThan(rho, vec3(0.0))), c1, greaterThanEqual(t2, vec3(1.0)));\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_frame[] = {
    "layout(std140) uniform lflare_frame {\n"
    "vec4 u_half;\n"
    "vec4 u_lens;\n"
    "vec4 u_spectrum;\n"
    "vec4 u_strip;\n"
    "vec4 u_burst[3];\n"
    "vec4 u_blades[16];\n"
    "vec4 u_bands;\n"
    "vec4 u_spectral[66];\n"
    "vec4 u_lights[928];\n"
    "};\n"
    "struct Profile {\n"
    "vec3 soft, ring, inner, outer;\n"
    "};\n"
    "Profile profile_over(vec3 soft, vec3 ring, float softness, vec3 waves)\n"
    "{\n"
    "Profile p;\n"
    "p.soft = sqrt(soft * soft + vec3(softness * softness)) + vec3(1e-7);\n"
    "p.ring = min(ring * waves, 0.4);\n"
    "p.ring *= step(p.soft, 8.0 * p.ring);\n"
    "p.inner = p.soft + 5.0 * p.ring;\n"
    "p.outer = p.soft + 2.5 * p.ring;\n"
    "return p;\n"
    "}\n"
    "Profile profile_of(vec3 soft, vec3 ring, float softness) { return profile_over(soft, ring, softness, sqrt(u_spectrum.xyz / u_spectrum.y)); }\n"
    "Profile dark(Profile p)\n"
    "{\n"
    "p.ring = -p.ring;\n"
    "p.inner = p.soft;\n"
    "return p;\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_ghost_frag[] = {
    "out vec4 o_color;\n"
    "#ifndef RIM\n"
    "flat in vec4 v_irradiance;\n"
    "void main() { o_color = v_irradiance; }\n"
    "#else\n"
    "flat in vec4 v_data[13];\n"
    "in vec2 v_position;\n"
    "void cut_circle(vec3 ax, vec3 ay, float radius, Profile p, vec3 side)\n"
    "{\n"
    "vec3 far = sqrt(ax * ax + ay * ay), inverse = -side / max(far, vec3(1e-20));\n"
    "cut(p, radius - far, ax * inverse, ay * inverse);\n"
    "}\n"
    "vec3 coverage(vec2 position)\n"
    "{\n"
    "vec2 axis = v_data[10].xy;\n"
    "int count = int(v_data[10].z), blades = int(u_spectrum.w);\n"
    "vec3 ratio = vec3(v_data[11].w, 1.0, v_data[12].w), along = v_data[12].xyz, dx = position.x - along * axis.x, dy = position.y - along * axis.y;\n"
    "uncut();\n"
    "for (int i = 0; i < count; i++) {\n"
    "vec4 g = v_data[i], o = v_data[5 + i];\n"
    "Profile p = profile_of(g.w * ratio, vec3(o.w), i == 0 ? u_strip.w : 0.0);\n"
    "if (i == 0 && u_strip.z > 2.0) p = dark(p);\n"
    "vec3 ax = g.xyz * dx + o.xyz * axis.x, ay = g.xyz * dy + o.xyz * axis.y;\n"
    "vec3 side = mix(vec3(1.0), vec3(-1.0), lessThan(g.xyz, vec3(0.0)));\n"
    "if (i > 0 || blades == 0) {\n"
    "cut_circle(ax, ay, 1.0, p, side);\n"
    "continue;\n"
    "}\n"
    "for (int k = 0; k < blades; k++) {\n"
    "vec4 b = u_blades[k];\n"
    "if (b.w > 0.0) cut_circle(ax + b.x * b.z, ay + b.y * b.z, b.w, p, side);\n"
    "else cut(p, b.z - b.x * ax - b.y * ay, -side * b.x, -side * b.y);\n"
    "}\n"
    "}\n"
    "#ifdef FRINGES\n"
    "if (u_strip.z == 0.0) return within();\n"
    "vec4 g = v_data[0], o = v_data[5];\n"
    "vec3 ax = g.xyz * dx + o.xyz * axis.x, ay = g.xyz * dy + o.xyz * axis.y;\n"
    "return within() * mask(ax, ay, profile_of(g.w * ratio, vec3(o.w), u_strip.w));\n"
    "#else\n"
    "return within();\n"
    "#endif\n"
    "}\n"
    "void main()\n"
    "{\n"
    "int samples = int(v_data[10].w);\n"
    "float grid = samples > 1 ? 0.25 * u_lens.x : 0.0;\n"
    "vec3 sum = vec3(0.0);\n"
    "for (int i = 0; i < samples; i++) sum += coverage(v_position + grid * (vec2(i & 3, i >> 2) - 1.5));\n"
    "o_color = vec4(v_data[11].rgb * sum / v_data[10].w, 0.0);\n"
    "}\n"
    "#endif\n"
    , NULL};
static const char *const lflare__glsl_ghost_vert[] = {
    "uniform highp sampler2D u_lens_table;\n"
    "uniform highp sampler2D u_settings_table;\n"
    "uniform highp usampler2D u_visibility;\n"
    "invariant gl_Position;\n"
    "in uvec4 a_instance;\n"
    "const int CORNERS = 16, EDGES = 5, RIMS = 12, SAMPLES = 64;\n"
    "const int LENS_TEXELS = 4 + 3 * RIMS, SETTINGS_TEXELS = 2 * SAMPLES + 11, ROW = 1024;\n"
    "const float PI = 3.14159265, PIXEL_VARIANCE = 0.715 * 0.715 / 5.0;\n"
    "#ifdef RIM\n"
    "flat out vec4 v_data[13];\n"
    "out vec2 v_position;\n"
    "#else\n"
    "flat out vec4 v_irradiance;\n"
    "#endif\n"
    "vec4 lens_texel(int i) { return texelFetch(u_lens_table, ivec2(i % ROW, i / ROW), 0); }\n"
    "vec4 settings_texel(int i) { return texelFetch(u_settings_table, ivec2(i % ROW, i / ROW), 0); }\n"
    "vec3 ramp(int at, int left, float angle)\n"
    "{\n"
    "vec4 a = settings_texel(at), b = left > 0 ? settings_texel(at + 1) : a;\n"
    "for (; left > 1 && angle > b.w; left--) {\n"
    "at++;\n"
    "a = b;\n"
    "b = settings_texel(at + 1);\n"
    "}\n"
    "return mix(a.rgb, b.rgb, left > 0 ? clamp((angle - a.w) / (b.w - a.w), 0.0, 1.0) : 0.0);\n"
    "}\n"
    "struct Edge {\n"
    "vec3 gain, offset, inner, outer;\n"
    "float soft, ring;\n"
    "};\n"
    "vec3 g_drawn, g_m11, g_m12, g_ratio;\n"
    "float g_centroid, g_slope, g_lamp, g_pixel, g_fringes;\n"
    "Edge edge_of(vec3 a, vec3 b, float radius, float softness)\n"
    "{\n"
    "Edge e;\n"
    "a /= radius;\n"
    "b /= radius;\n"
    "e.gain = a / g_drawn;\n"
    "e.offset = a * g_centroid + b * g_slope;\n"
    "float c = g_m12.y * a.y - g_m11.y * b.y, lamp = c / g_drawn.y * g_lamp, grid = g_pixel * e.gain.y;\n"
    "e.soft = sqrt(5.0 * (PIXEL_VARIANCE * grid * grid + 0.25 * lamp * lamp));\n"
    "e.ring = g_fringes * sqrt(0.5 * u_spectrum.y * abs(a.y * c) / max(abs(g_m11.y), 1e-12));\n"
    "Profile p = profile_of(e.soft * g_ratio, vec3(e.ring), softness);\n"
    "e.inner = p.inner;\n"
    "e.outer = p.outer;\n"
    "return e;\n"
    "}\n"
    "Edge g_edges[EDGES];\n"
    "int g_count;\n"
    "vec3 tangent(vec2 d, vec2 axis, vec3 along)\n"
    "{\n"
    "float best = 3e37;\n"
    "vec2 normal = d;\n"
    "vec3 reach = vec3(0.0);\n"
    "int blades = int(u_spectrum.w);\n"
    "for (int i = 0; i < g_count; i++) {\n"
    "Edge e = g_edges[i];\n"
    "float side = e.gain.y < 0.0 ? -1.0 : 1.0;\n"
    "vec3 gain = max(abs(e.gain), vec3(1e-12));\n"
    "int parts = i == 0 && blades > 0 ? blades : 1;\n"
    "for (int k = 0; k < parts; k++) {\n"
    "vec4 blade = i == 0 && blades > 0 ? u_blades[k] : vec4(0.0);\n"
    "vec2 offset = e.offset.y * axis;\n"
    "float t;\n"
    "vec2 n;\n"
    "vec3 far;\n"
    "if (i > 0 || blades == 0 || blade.w > 0.0) {\n"
    "float arc = blade.w > 0.0 ? blade.w : 1.0, radius = arc + e.outer.y;\n"
    "offset += blade.xy * blade.z;\n"
    "float b = dot(offset, d) * side;\n"
    "t = (sqrt(max(radius * radius - dot(offset, offset) + b * b, 0.0)) - b) / gain.y;\n"
    "n = (gain.y * t * d + side * offset) / radius;\n"
    "n /= max(length(n), 1e-6);\n"
    "far = (vec3(arc) + e.outer - side * (e.offset * dot(axis, n) + vec3(dot(blade.xy, n) * blade.z))) / gain;\n"
    "} else {\n"
    "float facing = dot(blade.xy, d) * side;\n"
    "float room = blade.z + e.outer.y - dot(blade.xy, offset);\n"
    "t = facing > 1e-6 ? max(room, 0.0) / (gain.y * facing) : 3e38;\n"
    "n = side * blade.xy;\n"
    "far = (vec3(blade.z) + e.outer - e.offset * dot(axis, blade.xy)) / gain;\n"
    "}\n"
    "if (t < best) {\n"
    "best = t;\n"
    "normal = n;\n"
    "reach = far;\n"
    "}\n"
    "}\n"
    "}\n"
    "reach += along * dot(axis, normal);\n"
    ,
    "return vec3(normal, max(reach.x, max(reach.y, reach.z)));\n"
    "}\n"
    "float uncut(vec2 d, vec2 axis, vec3 along)\n"
    "{\n"
    "float best = 3e37;\n"
    "int blades = int(u_spectrum.w);\n"
    "for (int i = 0; i < g_count; i++) {\n"
    "Edge e = g_edges[i];\n"
    "vec3 side = mix(vec3(1.0), vec3(-1.0), lessThan(e.gain, vec3(0.0))), gain = max(abs(e.gain), vec3(1e-12));\n"
    "vec3 start = e.offset + e.gain * (vec3(along.y) - along);\n"
    "int parts = i == 0 && blades > 0 ? blades : 1;\n"
    "for (int k = 0; k < parts; k++) {\n"
    "vec4 blade = i == 0 && blades > 0 ? u_blades[k] : vec4(0.0);\n"
    "vec3 t;\n"
    "if (i > 0 || blades == 0 || blade.w > 0.0) {\n"
    "vec3 radius = vec3(blade.w > 0.0 ? blade.w : 1.0) - e.inner;\n"
    "vec3 ox = start * axis.x + vec3(blade.x * blade.z), oy = start * axis.y + vec3(blade.y * blade.z);\n"
    "vec3 b = (ox * d.x + oy * d.y) * side, c = radius * radius - ox * ox - oy * oy;\n"
    "t = (sqrt(max(c + b * b, vec3(0.0))) - b) / gain;\n"
    "if (min(radius.x, min(radius.y, radius.z)) <= 0.0 || min(c.x, min(c.y, c.z)) <= 0.0) t = vec3(0.0);\n"
    "} else {\n"
    "vec3 facing = dot(blade.xy, d) * side, room = vec3(blade.z) - e.inner - start * dot(blade.xy, axis);\n"
    "t = mix(vec3(3e37), room / max(gain * facing, vec3(1e-12)), greaterThan(facing, vec3(1e-6)));\n"
    "t = mix(t, vec3(0.0), lessThan(room, vec3(0.0)));\n"
    "}\n"
    "best = min(best, min(t.x, min(t.y, t.z)));\n"
    "}\n"
    "}\n"
    "return max(best, 0.0);\n"
    "}\n"
    "void main()\n"
    "{\n"
    "int ghost = int(a_instance.x), light = int(a_instance.y), i;\n"
    "vec4 l0 = u_lights[light * 4], l1 = u_lights[light * 4 + 1], l2 = u_lights[light * 4 + 2];\n"
    "vec2 slope = l0.xy, axis = l0.zw;\n"
    "vec3 irradiance = l2.yzw * u_strip.y * (1.0 - float(a_instance.w >> 10) / 63.0);\n"
    "int place = int(u_lights[light * 4 + 3].x);\n"
    "int lens = ghost * LENS_TEXELS, settings = ghost * SETTINGS_TEXELS;\n"
    "vec4 h0 = lens_texel(lens), h1 = lens_texel(lens + 1), h2 = lens_texel(lens + 2);\n"
    "vec4 style0 = settings_texel(settings + 2 * SAMPLES), style1 = settings_texel(settings + 2 * SAMPLES + 1), style2 = settings_texel(settings + 2 * SAMPLES + 2);\n"
    "if (style2.z > 0.0) style0.rgb *= ramp(settings + 2 * SAMPLES + 3, int(style2.z) - 1, l1.y);\n"
    "gl_Position = vec4(2.0, 2.0, 0.0, 1.0);\n"
    "if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);\n"
    "float at = l1.y * style1.w * float(SAMPLES - 1);\n"
    "int j = int(min(at, float(SAMPLES - 2)));\n"
    "vec4 a1 = settings_texel(settings + 2 * j + 1), b1 = settings_texel(settings + 2 * j + 3), s1 = mix(a1, b1, at - float(j));\n"
    "float middle_x = mix(settings_texel(settings + 2 * j).w, settings_texel(settings + 2 * j + 2).w, at - float(j));\n"
    "int c = clamp(j, 1, SAMPLES - 3);\n"
    "float f = at - float(c);\n"
    "vec3 p0 = settings_texel(settings + 2 * c - 2).rgb, p1 = settings_texel(settings + 2 * c).rgb;\n"
    "vec3 p2 = settings_texel(settings + 2 * c + 2).rgb, p3 = settings_texel(settings + 2 * c + 4).rgb;\n"
    "vec3 weight = p1 + f * (p2 - p0 / 3.0 - p1 / 2.0 - p3 / 6.0 + f * (p0 / 2.0 - p1 + p2 / 2.0 + f * ((p1 - p2) / 2.0 + (p3 - p0) / 6.0)));\n"
    "int binding = int(a1.w);\n"
    "float radius = max(s1.x, 1e-6 * u_lens.z), scale = style0.w;\n"
    ,
    "vec3 ma11 = vec3(h0.x, h1.x, h2.x), ma12 = vec3(h0.y, h1.y, h2.y);\n"
    "g_m11 = vec3(h0.z, h1.z, h2.z);\n"
    "g_m12 = vec3(h0.w, h1.w, h2.w);\n"
    "vec3 spread = 0.61 * u_spectrum.xyz * g_m12 / radius, lamp = l1.z * g_m12;\n"
    "vec3 size = max(abs(g_m11), sqrt(vec3(u_lens.x * u_lens.x) + spread * spread + lamp * lamp) / radius);\n"
    "g_drawn = mix(size, -size, lessThan(g_m11, vec3(0.0))) * scale;\n"
    "g_ratio = abs(vec3(g_drawn.y) / g_drawn);\n"
    "vec3 bright = max(weight, vec3(0.0)) * style0.rgb / (size * size);\n"
    "g_fringes = u_burst[2].w >= 0.0 && max(bright.x, max(bright.y, bright.z)) >= u_burst[2].w ? 1.0 : 0.0;\n"
    "g_centroid = middle_x;\n"
    "g_slope = l1.x;\n"
    "g_lamp = l1.z * scale;\n"
    "g_pixel = u_lens.x;\n"
    "bool fine = radius * abs(g_drawn.y) < 4.0 * g_pixel;\n"
    "if (fine) g_pixel *= 0.25;\n"
    "Edge found[EDGES];\n"
    "int count = 1;\n"
    "found[0] = edge_of(ma11, ma12, u_lens.w, u_strip.w);\n"
    "if ((binding & 1) != 0) found[count++] = edge_of(vec3(1.0), vec3(0.0), u_lens.z, 0.0);\n"
    "for (i = 0; i < RIMS; i++)\n"
    "if ((binding >> (i + 1) & 1) != 0) {\n"
    "vec4 r0 = lens_texel(lens + 4 + i * 3), r1 = lens_texel(lens + 5 + i * 3), r2 = lens_texel(lens + 6 + i * 3);\n"
    "found[count++] = edge_of(vec3(r0.x, r1.x, r2.x), vec3(r0.y, r1.y, r2.y), r0.z > 0.0 ? r0.z : u_lens.w, r0.z > 0.0 ? 0.0 : u_strip.w);\n"
    "}\n"
    "int smallest = 0;\n"
    "float reach = 3e38;\n"
    "for (i = 0; i < count; i++) {\n"
    "float extent = (1.0 + found[i].outer.y) / max(abs(found[i].gain.y), 1e-12);\n"
    "if (extent < reach) { reach = extent; smallest = i; }\n"
    "}\n"
    "Edge least = found[smallest];\n"
    "vec3 middle = -least.offset / least.gain, far = (vec3(1.0) + least.outer) / max(abs(least.gain), vec3(1e-12));\n"
    "g_edges[0] = found[0];\n"
    "g_count = 1;\n"
    "for (i = 1; i < count; i++) {\n"
    "Edge e = found[i];\n"
    "vec3 over = abs(e.gain * middle + e.offset) + abs(e.gain) * far - 1.0 + e.soft * g_ratio;\n"
    "if (i == smallest || max(over.x, max(over.y, over.z)) > 0.0) g_edges[g_count++] = e;\n"
    "}\n"
    "vec3 size2 = radius * radius * g_drawn * g_drawn;\n"
    "float wash = (PIXEL_VARIANCE * g_pixel * g_pixel * s1.y + 0.25 * g_lamp * g_lamp * s1.z) / PI, wash5 = max(5.0 * wash, 1e-30);\n"
    "vec3 q = sqrt(size2 / wash5), wide = 2.0 * wash5 * (0.05 + q * (0.1875 + q * (0.25 + q * (0.125 - 0.0125 * q * q))));\n"
    "irradiance *= max(weight, vec3(0.0)) * style0.rgb / (size * size) * size2 / mix(wide, size2 + wash, lessThanEqual(vec3(wash5), size2));\n"
    "vec3 along = g_m11 * g_centroid + g_m12 * g_slope;\n"
    "#ifdef RIM\n"
    "for (i = 0; i < EDGES; i++) {\n"
    "Edge e = g_edges[i < g_count ? i : 0];\n"
    "v_data[i] = vec4(e.gain, e.soft);\n"
    "v_data[5 + i] = vec4(e.offset, e.ring);\n"
    "}\n"
    "v_data[10] = vec4(axis, float(g_count), fine ? 16.0 : 1.0);\n"
    "v_data[11] = vec4(irradiance, g_ratio.x);\n"
    "v_data[12] = vec4(along, g_ratio.z);\n"
    "v_position = vec2(0.0);\n"
    "#else\n"
    "v_irradiance = vec4(irradiance, 0.0);\n"
    "#endif\n"
    "if (at >= float(SAMPLES - 1) || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;\n"
    "#ifdef RIM\n"
    "int corner = gl_VertexID >> 1;\n"
    "bool low = (gl_VertexID & 1) != 0;\n"
    "#else\n"
    "int corner = gl_VertexID;\n"
    "bool low = true;\n"
    "#endif\n"
    "float turn = 2.0 * PI / float(CORNERS), angle = (float(corner % CORNERS) + 0.37) * turn;\n"
    ,
    "vec2 centre = along.y * axis, between = vec2(cos(angle + 0.5 * turn), sin(angle + 0.5 * turn)), position;\n"
    "vec3 p = tangent(vec2(cos(angle), sin(angle)), axis, along);\n"
    "vec3 next = tangent(vec2(cos(angle + turn), sin(angle + turn)), axis, along);\n"
    "float bend = p.x * next.y - p.y * next.x;\n"
    "if (bend > 1e-3) position = vec2(p.z * next.y - next.z * p.y, p.x * next.z - next.x * p.z) / bend;\n"
    "else position = centre + between * max(p.z - dot(p.xy, centre), 0.0) / max(dot(p.xy, between), 0.05);\n"
    "if (low) {\n"
    "vec2 way = position - centre;\n"
    "float far = max(length(way), 1e-20);\n"
    "position = centre + way * (fine || u_strip.z > 0.0 ? 0.0 : min(uncut(way / far, axis, along) / far, 1.0));\n"
    "}\n"
    "#ifndef RIM\n"
    "if (gl_VertexID == 0) position = centre;\n"
    "#else\n"
    "v_position = position;\n"
    "#endif\n"
    "vec2 shift = u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x)) + style2.xy;\n"
    "gl_Position = vec4(-(position + shift - u_half.zw) / u_half.xy, 0.0, 1.0);\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_patch_frag[] = {
    "out vec4 o_color;\n"
    "centroid in vec3 v_irradiance;\n"
    "centroid in vec3 v_flux;\n"
    "centroid in float v_most;\n"
    "in vec2 v_entrance;\n"
    "vec3 lit()\n"
    "{\n"
    "vec2 ex = dFdx(v_entrance), ey = dFdy(v_entrance);\n"
    "return v_irradiance + v_flux * min(abs(ex.x * ey.y - ex.y * ey.x) / (u_lens.x * u_lens.x), v_most);\n"
    "}\n"
    "#ifndef PATCH_RIM\n"
    "void main() { o_color = vec4(lit(), 0.0); }\n"
    "#else\n"
    "flat in vec4 v_light;\n"
    "flat in vec2 v_spectrum;\n"
    "in vec2 v_bundle;\n"
    "in vec4 v_iris01;\n"
    "in vec4 v_iris2;\n"
    "in vec3 v_rim;\n"
    "in vec4 v_bulge;\n"
    "void cut_slope(vec3 over, vec3 gx, vec3 gy, float soft, float ring, float softness, bool is_dark, bool blend, vec3 waves)\n"
    "{\n"
    "vec3 g = max(sqrt(gx * gx + gy * gy), vec3(1e-20)), pixels = min(g, 0.6);\n"
    "Profile p = profile_over(soft * pixels, ring * pixels, blend ? length(vec2(softness, 0.3575 * (over.z - over.x))) : softness, waves);\n"
    "if (is_dark) p = dark(p);\n"
    "cut(p, -over, -gx / g, -gy / g);\n"
    "}\n"
    "vec3 covered(vec3 hx, vec3 hy, vec3 rim, bool blend, vec3 waves)\n"
    "{\n"
    "vec3 xx = dFdx(hx), xy = dFdy(hx), yx = dFdx(hy), yy = dFdy(hy), rim_x = dFdx(rim), rim_y = dFdy(rim);\n"
    "float turn = fract(v_bulge.x), bend = v_bulge.y * (1.0 - 2.0 * turn);\n"
    "int blades = int(u_spectrum.w);\n"
    "uncut();\n"
    "for (int i = 0; i < max(blades, 1); i++) {\n"
    "vec4 b = blades > 0 ? u_blades[i] : vec4(0.0, 0.0, 0.0, 1.0);\n"
    "if (b.w > 0.0) {\n"
    "vec3 ax = hx + b.x * b.z, ay = hy + b.y * b.z, far = sqrt(ax * ax + ay * ay), inverse = 1.0 / max(far, vec3(1e-20));\n"
    "cut_slope(far - b.w, (ax * xx + ay * yx) * inverse, (ax * xy + ay * yy) * inverse, v_iris2.w, v_bulge.z, u_strip.w, u_strip.z > 2.0, blend, waves);\n"
    "} else {\n"
    "cut_slope(b.x * hx + b.y * hy - b.z, b.x * xx + b.y * yx, b.x * xy + b.y * yy, v_iris2.w, v_bulge.z, u_strip.w, u_strip.z > 2.0, blend, waves);\n"
    "}\n"
    "}\n"
    "cut_slope(rim - 1.0 - v_bulge.y * turn * (1.0 - turn), rim_x - bend * dFdx(v_bulge.x), rim_y - bend * dFdy(v_bulge.x), v_iris2.z, v_bulge.w, 0.0, false, blend, waves);\n"
    "vec3 open = within();\n"
    "#ifdef FRINGES\n"
    "if (u_strip.z > 0.0) {\n"
    "vec3 slope = min(sqrt(0.5 * (xx * xx + xy * xy + yx * yx + yy * yy)), 0.6);\n"
    "open *= mask(hx, hy, profile_over(v_iris2.w * slope, v_bulge.z * slope, 0.0, waves));\n"
    "}\n"
    "#endif\n"
    "return open;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "vec3 hx = vec3(v_iris01.xz, v_iris2.x), hy = vec3(v_iris01.yw, v_iris2.y), light = lit(), sum = vec3(0.0);\n"
    "int count = int(v_light.w);\n"
    "if (count == 0) sum = light * covered(hx, hy, v_rim, false, sqrt(u_spectrum.xyz / u_spectrum.y));\n"
    "for (int i = 0; i < count; i += 3) {\n"
    "mat3 places = mat3(place_shares(i), place_shares(i + 1), place_shares(i + 2));\n"
    "vec3 waves = sqrt(vec3(u_spectral[2 * i].w, u_spectral[2 * i + 2].w, u_spectral[2 * i + 4].w) / u_spectrum.y);\n"
    "vec3 open = max(vec3(spectrum_at(v_spectrum, 1 + i, v_bundle), spectrum_at(v_spectrum, 2 + i, v_bundle), spectrum_at(v_spectrum, 3 + i, v_bundle)), 0.0);\n"
    "open *= max(light, 0.0) * covered(hx * places, hy * places, v_rim * places, true, waves);\n"
    "sum += open.x * colour_of(i) + open.y * colour_of(i + 1) + open.z * colour_of(i + 2);\n"
    "}\n"
    "o_color = vec4(sum * v_light.rgb, 0.0);\n"
    "}\n"
    "#endif\n"
    , NULL};
static const char *const lflare__glsl_patch_vert[] = {
    "uniform highp sampler2D u_mesh_table;\n"
    "uniform highp usampler2D u_visibility;\n"
    "invariant gl_Position;\n"
    "in uvec4 a_instance;\n"
    "const int KNOT_TEXELS = 2, DIRECTIONS = 9, RINGS = 5, BANDS = 3, HEAD = 13, MESH_ROW = 2048;\n"
    "centroid out vec3 v_irradiance, v_flux;\n"
    "centroid out float v_most;\n"
    "out vec2 v_entrance;\n"
    "#ifdef PATCH_RIM\n"
    "out vec4 v_iris01, v_iris2;\n"
    "out vec3 v_rim;\n"
    "out vec4 v_bulge;\n"
    "flat out vec4 v_light;\n"
    "flat out vec2 v_spectrum;\n"
    "out vec2 v_bundle;\n"
    "#endif\n"
    "vec4 mesh(int i) { return texelFetch(u_mesh_table, ivec2(i % MESH_ROW, i / MESH_ROW), 0); }\n"
    "int g_knot, g_size;\n"
    "int g_between;\n"
    "int g_rings, g_directions;\n"
    "int g_texels;\n"
    "vec4 g_shares;\n"
    "int g_mesh;\n"
    "int g_next;\n"
    "vec4 smooth_of(int i)\n"
    "{\n"
    "i += g_knot;\n"
    "return g_shares.x * mesh(i) + g_shares.y * mesh(i + g_size) + g_shares.z * mesh(i + 2 * g_size) + g_shares.w * mesh(i + 3 * g_size);\n"
    "}\n"
    "vec4 kept_of(int i)\n"
    "{\n"
    "i += g_knot;\n"
    "vec4 k0 = mesh(i), k1 = mesh(i + g_size), k2 = mesh(i + 2 * g_size), k3 = mesh(i + 3 * g_size);\n"
    "vec4 a = g_between == 0 ? k0 : g_between == 1 ? k1 : k2, b = g_between == 0 ? k1 : g_between == 1 ? k2 : k3, least = min(a, b), most = max(a, b);\n"
    "return clamp(g_shares.x * k0 + g_shares.y * k1 + g_shares.z * k2 + g_shares.w * k3, least - 0.1 * (most - least), most + 0.1 * (most - least));\n"
    "}\n"
    "vec4 smooth_texel(int i)\n"
    "{\n"
    "if (g_mesh < 0) return smooth_of(i);\n"
    "vec3 s = place_shares(g_mesh);\n"
    "return s.x * smooth_of(i) + s.y * smooth_of(i + g_next) + s.z * smooth_of(i + 2 * g_next);\n"
    "}\n"
    "vec4 kept_texel(int i)\n"
    "{\n"
    "if (g_mesh < 0) return kept_of(i);\n"
    "vec3 s = place_shares(g_mesh);\n"
    "return s.x * kept_of(i) + s.y * kept_of(i + g_next) + s.z * kept_of(i + 2 * g_next);\n"
    "}\n"
    "int vertex(int ring, int direction) { return KNOT_TEXELS + (ring * (g_directions + 1) + direction) * g_texels; }\n"
    "float last(int ring, int direction) { return smooth_texel(vertex(ring, direction) + g_texels - 1).w; }\n"
    "void main()\n"
    "{\n"
    "int ghost = int(a_instance.x) * HEAD, light = int(a_instance.y) * 4, patch_index = int(a_instance.z);\n"
    "vec4 h0 = ghosts(ghost), h1 = ghosts(ghost + 1), style0 = ghosts(ghost + 2), style1 = ghosts(ghost + 3), style2 = ghosts(ghost + 4);\n"
    "vec4 l0 = u_lights[light], l1 = u_lights[light + 1], l2 = u_lights[light + 2];\n"
    "if (style2.z > 0.0) style0.rgb *= ramp(ghost + 5, int(style2.z) - 1, l1.y);\n"
    "vec2 slope = l0.xy, axis = l0.zw;\n"
    "vec3 irradiance = l2.yzw * u_strip.y * (1.0 - float(a_instance.w >> 10) / 63.0);\n"
    "int place = int(u_lights[light + 3].x);\n"
    "gl_Position = vec4(2.0, 2.0, 0.0, 1.0);\n"
    "v_irradiance = v_flux = vec3(0.0);\n"
    "v_entrance = vec2(0.0);\n"
    "v_most = 0.0;\n"
    "#ifdef PATCH_RIM\n"
    "v_iris01 = v_iris2 = vec4(1.0);\n"
    "v_rim = vec3(1.0);\n"
    "v_bulge = v_light = vec4(0.0);\n"
    "v_spectrum = v_bundle = vec2(0.0);\n"
    "#endif\n"
    "if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);\n"
    "g_directions = int(h0.y);\n"
    "g_rings = int(h0.z);\n"
    "int sectors = g_directions / 4, blocks = g_rings / 4, mesh_index = patch_index / (sectors * blocks), block = patch_index / sectors % blocks;\n"
    ,
    "bool split_mesh = h1.z > 1.0, mixed = split_mesh && u_bands.x > 0.0, ragged = (int(h1.y) >> (mixed ? 0 : mesh_index) & 1) != 0;\n"
    "#ifdef PATCH_STRIP\n"
    "bool drawn = ragged || block == blocks - 1;\n"
    "#else\n"
    "bool drawn = !ragged;\n"
    "#endif\n"
    "if (!(l1.y < h1.x) || !drawn || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;\n"
    "int knots = (int(h1.y) & 8) != 0 ? 23 : 12;\n"
    "float at = (1.0 - sqrt(max(1.0 - l1.y / h1.x, 0.0))) * float(knots - 1);\n"
    "int first = clamp(int(at) - 1, 0, knots - 4);\n"
    "float f = at - float(first), scale = style0.w;\n"
    "g_shares = vec4(-(f - 1.0) * (f - 2.0) * (f - 3.0) / 6.0, f * (f - 2.0) * (f - 3.0) / 2.0, -f * (f - 1.0) * (f - 3.0) / 2.0, f * (f - 1.0) * (f - 2.0) / 6.0);\n"
    "g_size = int(h1.w);\n"
    "g_next = knots * g_size;\n"
    "g_mesh = mixed ? mesh_index : -1;\n"
    "g_knot = int(h0.x) + ((mixed ? 0 : mesh_index) * knots + first) * g_size;\n"
    "g_texels = split_mesh ? 3 : 5;\n"
    "g_lamp = l1.z * scale;\n"
    "g_between = int(min(f, 2.0));\n"
    "int whole_at = g_knot + g_between * g_size + (mixed ? g_next : 0);\n"
    "vec4 whole = mix(mesh(whole_at), mesh(whole_at + g_size), f - float(g_between)), bounds = mix(mesh(whole_at + 1), mesh(whole_at + 1 + g_size), f - float(g_between));\n"
    "vec3 growth = grow(whole.x, max(whole.z, 1e-6), whole.y, h0.w, bounds.z < 0.0 ? -scale : scale, l1.z);\n"
    "float grown = growth.x, even = growth.y, gain = growth.z;\n"
    "int row = gl_VertexID / DIRECTIONS, direction = patch_index % sectors * (DIRECTIONS - 1) + gl_VertexID % DIRECTIONS;\n"
    "float side = direction > g_directions ? -1.0 : 1.0, turn = float(direction);\n"
    "if (direction > g_directions) direction = 2 * g_directions - direction;\n"
    "vec4 edge = smooth_texel(vertex(g_rings, direction) + (split_mesh ? 1 : 4));\n"
    "float edge_lamp = split_mesh ? edge.w : edge.z, edge_shrink = split_mesh ? kept_texel(vertex(g_rings, direction) + 1).y : kept_texel(vertex(g_rings, direction) + 1).w;\n"
    "float iris_soft = soft(whole.y), bulge = last(0, direction), widest = sqrt(u_spectrum.x / u_spectrum.y);\n"
    "float inverse = 1.1 / max(scale * last(g_rings - 1, direction) + abs(grown) * whole.z, 1.5 * u_lens.x);\n"
    "vec2 reach = edges(vec4(iris_soft, soft(edge_lamp), widest * fringe(edge_shrink, whole.y, scale), widest * fringe(edge_shrink, edge_lamp, scale)) * inverse);\n"
    "float begin = float(g_rings) * max((split_mesh ? last(g_rings, direction) : edge.w) - reach.x - u_strip.w - 0.01, 0.0);\n"
    "float end = float(g_rings) * (1.0 + reach.y + u_strip.w + 1.2 * bulge);\n"
    "if (ragged) {\n"
    "begin = float(block) / float(blocks) * end;\n"
    "end *= float(block + 1) / float(blocks);\n"
    "}\n"
    "#ifdef PATCH_STRIP\n"
    "at = begin + (end - begin) * float(row) / float(BANDS - 1);\n"
    "#else\n"
    "at = min(float(block * (RINGS - 1) + row), begin);\n"
    "#endif\n"
    "int ring = int(clamp(at, 0.0, float(g_rings - 1))), a = vertex(ring, direction);\n"
    "f = at - float(ring);\n"
    "vec4 t0 = smooth_texel(a), t1 = kept_texel(a + 1);\n"
    "float spread_of_shrink = split_mesh ? t1.z : kept_texel(a + 2).w;\n"
    "#ifdef PATCH_RIM\n"
    "vec4 t2 = smooth_texel(a + 2), t3 = vec4(0.0), t4 = vec4(0.0);\n"
    ,
    "if (!split_mesh) t3 = smooth_texel(a + 3), t4 = smooth_texel(a + 4);\n"
    "#endif\n"
    "if (f > 0.0) {\n"
    "float g = min(f, 1.0);\n"
    "int b = vertex(ring + 1, direction);\n"
    "t0 = mix(t0, smooth_texel(b), f);\n"
    "t1 = mix(t1, kept_texel(b + 1), g);\n"
    "spread_of_shrink = split_mesh ? t1.z : mix(spread_of_shrink, kept_texel(b + 2).w, g);\n"
    "#ifdef PATCH_RIM\n"
    "t2 = mix(t2, smooth_texel(b + 2), f);\n"
    "if (!split_mesh) {\n"
    "t3 = mix(t3, smooth_texel(b + 3), f);\n"
    "vec4 b4 = smooth_texel(b + 4);\n"
    "t4 = vec4(mix(t4.xy, b4.xy, f), mix(t4.z, b4.z, g), 0.0);\n"
    "}\n"
    "#endif\n"
    "}\n"
    "spread_of_shrink = max(spread_of_shrink, 1e-20);\n"
    "int mesh_or_all = split_mesh ? mesh_index : -1;\n"
    "vec2 spectrum = u_bands.x > 0.0 ? spectrum_of(int(a_instance.x), l1.y, h1.x) : vec2(0.0), bundle = u_bands.x > 0.0 ? bundle_of(spectrum, t0.zw) : vec2(0.0);\n"
    "vec3 weight = channels(spectrum, bundle, mesh_or_all, max(split_mesh ? t1.xxx : t1.xyz, vec3(0.0))) * gain, light_colour = irradiance * style0.rgb;\n"
    "#ifndef PATCH_RIM\n"
    "weight *= summed(spectrum, bundle, mesh_or_all) * light_colour;\n"
    "#endif\n"
    "float shrink = abs(split_mesh ? t1.y : t1.w), flat_share = max(even, clamp(2.0 - shrink / spread_of_shrink, 0.0, 1.0));\n"
    "v_irradiance = (1.0 - flat_share) * weight / max(shrink, spread_of_shrink);\n"
    "v_flux = flat_share * weight * scale * scale;\n"
    "vec4 centre = smooth_texel(KNOT_TEXELS);\n"
    "vec2 in_at = vec2(t0.z - centre.z, side * t0.w);\n"
    "vec2 local = vec2(centre.x + scale * (t0.x - centre.x), scale * side * t0.y) + grown * in_at;\n"
    "v_entrance = vec2(in_at.x * axis.x - in_at.y * axis.y, in_at.x * axis.y + in_at.y * axis.x);\n"
    "v_most = 8.0 / (spread_of_shrink * scale * scale);\n"
    "#ifdef PATCH_RIM\n"
    "v_light = vec4(light_colour, split_mesh ? 0.0 : u_bands.x);\n"
    "v_spectrum = spectrum;\n"
    "v_bundle = bundle;\n"
    "float apart = 0.0;\n"
    "if (mixed) {\n"
    "vec3 d = 0.5 * (place_shares(min(mesh_index + 1, int(u_bands.x) - 1)) - place_shares(max(mesh_index - 1, 0)));\n"
    "int v = vertex(int(clamp(at, 0.0, float(g_rings))), direction);\n"
    "apart = 0.715 * scale * length(d.x * smooth_of(v).xy + d.y * smooth_of(v + g_next).xy + d.z * smooth_of(v + 2 * g_next).xy) / u_lens.x;\n"
    "}\n"
    "mat2 to_sensor = mat2(axis.x, axis.y, -axis.y * side, axis.x * side);\n"
    "if (split_mesh) {\n"
    "vec2 iris = to_sensor * t2.yz;\n"
    "v_iris01 = vec4(iris, iris);\n"
    "v_iris2 = vec4(iris, length(vec2(soft(t1.w) / u_lens.x, apart)), length(vec2(iris_soft / u_lens.x, apart)));\n"
    "v_rim = vec3(t2.x);\n"
    "} else {\n"
    "v_iris01 = vec4(to_sensor * t3.xy, to_sensor * t3.zw);\n"
    "v_iris2 = vec4(to_sensor * t4.xy, soft(t4.z) / u_lens.x, iris_soft / u_lens.x);\n"
    "v_rim = t2.xyz;\n"
    "}\n"
    "float real_shrink = split_mesh ? t1.y : t1.w;\n"
    "v_bulge = vec4(turn, 4.0 * bulge, vec2(fringe(real_shrink, whole.y, scale), fringe(real_shrink, split_mesh ? t1.w : t4.z, scale)) / u_lens.x);\n"
    "#endif\n"
    "vec2 position = vec2(local.x * axis.x - local.y * axis.y, local.x * axis.y + local.y * axis.x);\n"
    "position += u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x)) + style2.xy;\n"
    "gl_Position = vec4(-(position - u_half.zw) / u_half.xy, 0.0, 1.0);\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_patches[] = {
    "uniform highp sampler2D u_ghosts;\n"
    "const float PIXEL_VARIANCE = 0.715 * 0.715 / 5.0;\n"
    "const int SPECTRUM_ROWS = 37, SPECTRUM_KNOTS = 12;\n"
    "vec4 ghosts(int i) { return texelFetch(u_ghosts, ivec2(i % 1024, i / 1024), 0); }\n"
    "vec3 place_shares(int i) { return u_spectral[2 * i].xyz; }\n"
    "vec3 colour_of(int i) { return u_spectral[2 * i + 1].xyz; }\n"
    "float spectrum_at(vec2 spectrum, int row, vec2 bundle)\n"
    "{\n"
    "int i = int(spectrum.x) + row;\n"
    "return dot(mix(ghosts(i), ghosts(i + SPECTRUM_ROWS), spectrum.y), vec4(1.0, bundle.x, bundle.x * bundle.x, bundle.y * bundle.y));\n"
    "}\n"
    "#ifdef PATCH_VERTEX\n"
    "vec3 ramp(int at, int left, float angle)\n"
    "{\n"
    "vec4 a = ghosts(at), b = left > 0 ? ghosts(at + 1) : a;\n"
    "for (; left > 1 && angle > b.w; left--) {\n"
    "at++;\n"
    "a = b;\n"
    "b = ghosts(at + 1);\n"
    "}\n"
    "return mix(a.rgb, b.rgb, left > 0 ? clamp((angle - a.w) / (b.w - a.w), 0.0, 1.0) : 0.0);\n"
    "}\n"
    "float g_lamp;\n"
    "float soft(float lamp)\n"
    "{\n"
    "lamp *= g_lamp;\n"
    "return sqrt(5.0 * (PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * lamp * lamp));\n"
    "}\n"
    "float fringe(float shrink, float lamp, float scale)\n"
    "{\n"
    "return (u_burst[2].w >= 0.0 ? scale : 0.0) * sqrt(0.5 * u_spectrum.y * sqrt(abs(shrink)) * abs(lamp));\n"
    "}\n"
    "vec3 grow(float radius, float entrance, float lamp, float diffraction, float turned, float lamp_radius)\n"
    "{\n"
    "float scale = abs(turned), spread = min(diffraction / entrance, 0.5 * u_half.x), disc = lamp * lamp_radius;\n"
    "float least = sqrt(2.25 * u_lens.x * u_lens.x + spread * spread + disc * disc), size2 = scale * max(radius, least);\n"
    "size2 *= size2;\n"
    "float wash = PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * g_lamp * g_lamp * lamp * lamp, wash5 = max(5.0 * wash, 1e-30);\n"
    "float q = sqrt(size2 / wash5), wide = 2.0 * wash5 * (0.05 + q * (0.1875 + q * (0.25 + q * (0.125 - 0.0125 * q * q))));\n"
    "return vec3(turned * max(least - radius, 0.0) / entrance, clamp(2.0 - scale * radius / max(4.0 * u_lens.x, scale * least), 0.0, 1.0), size2 / (wash5 <= size2 ? size2 + wash : wide));\n"
    "}\n"
    "vec2 edges(vec4 width)\n"
    "{\n"
    "width.zw = min(width.zw, 0.4);\n"
    "width.zw *= step(width.xy, 8.0 * width.zw);\n"
    "vec2 inner = width.xy + 5.0 * width.zw, outer = width.xy + 2.5 * width.zw;\n"
    "return vec2(max(inner.x, inner.y), max(outer.x, outer.y));\n"
    "}\n"
    "vec2 spectrum_of(int ghost, float angle, float hidden)\n"
    "{\n"
    "float at = (1.0 - sqrt(max(1.0 - angle / hidden, 0.0))) * float(SPECTRUM_KNOTS - 1);\n"
    "int first = int(min(at, float(SPECTRUM_KNOTS - 2)));\n"
    "return vec2(int(u_bands.y) + (ghost * SPECTRUM_KNOTS + first) * SPECTRUM_ROWS, at - float(first));\n"
    "}\n"
    "vec2 bundle_of(vec2 spectrum, vec2 entrance)\n"
    "{\n"
    "vec3 b = mix(ghosts(int(spectrum.x)), ghosts(int(spectrum.x) + SPECTRUM_ROWS), spectrum.y).xyz;\n"
    "return vec2((entrance.x - b.x) / max(b.y, 1e-9), entrance.y / max(b.z, 1e-9));\n"
    "}\n"
    "vec3 channels(vec2 spectrum, vec2 bundle, int mesh, vec3 weight)\n"
    "{\n"
    "if (u_bands.x > 0.0) return mesh < 0 ? vec3(1.0) : max(spectrum_at(spectrum, 1 + mesh, bundle), 0.0) * colour_of(mesh);\n"
    "return mesh < 0 ? weight : weight * vec3(equal(ivec3(0, 1, 2), ivec3(mesh)));\n"
    "}\n"
    "vec3 summed(vec2 spectrum, vec2 bundle, int mesh)\n"
    "{\n"
    ,
    "if (u_bands.x == 0.0 || mesh >= 0) return vec3(1.0);\n"
    "return vec3(spectrum_at(spectrum, SPECTRUM_ROWS - 3, bundle), spectrum_at(spectrum, SPECTRUM_ROWS - 2, bundle), spectrum_at(spectrum, SPECTRUM_ROWS - 1, bundle));\n"
    "}\n"
    "#endif\n"
    , NULL};
static const char *const lflare__glsl_screen_vert[] = {
    "out vec2 v_place;\n"
    "void main()\n"
    "{\n"
    "v_place = vec2(float(gl_VertexID & 1) * 2.0, float(gl_VertexID >> 1) * 2.0);\n"
    "gl_Position = vec4(2.0 * v_place - 1.0, 0.0, 1.0);\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_starburst_frag[] = {
    "out vec4 o_color;\n"
    "uniform highp sampler2D u_angular;\n"
    "uniform highp sampler2D u_radial;\n"
    "flat in vec4 v_irradiance;\n"
    "flat in float v_streak;\n"
    "in vec2 v_position;\n"
    "const int ROWS = 168, OCTAVE = 14, BINS = 512, LEVELS = 7, COLUMNS = 1536, SIZES = 15, SAMPLES = 193;\n"
    "const float PI = 3.14159265, MOST = 30000.0;\n"
    "vec3 angle_at(float row, float turn, int level)\n"
    "{\n"
    "int first = level == 0 ? 1 : 3 * BINS + 1 - (4 * BINS >> level) + 2 * level, count = level == 0 ? BINS : 2 * BINS >> level;\n"
    "return texture(u_angular, vec2((float(first) + turn * float(count)) / float(COLUMNS), (row + 0.5) / float(ROWS))).rgb;\n"
    "}\n"
    "vec3 starburst()\n"
    "{\n"
    "float blur = max(v_irradiance.w / u_burst[0].w, 0.125), q = max(length(v_position) / u_burst[0].w, 1e-3), relative = q / blur;\n"
    "float row = clamp(float(OCTAVE) * log2(16.0 * q), 0.0, float(ROWS - 1)), turn = atan(v_position.y, v_position.x) / PI;\n"
    "turn -= floor(turn);\n"
    "float level = max(1.0 + log2(0.382 * float(BINS) / (PI * relative)), 0.0);\n"
    "int l = int(min(level, float(LEVELS - 2)));\n"
    "vec3 angle = mix(angle_at(row, turn, l), angle_at(row, turn, l + 1), (exp2(2.0 * min(level - float(l), 1.0)) - 1.0) / 3.0);\n"
    "angle = mix(angle, vec3(1.0), clamp(0.5 * (level - float(LEVELS - 1)), 0.0, 1.0));\n"
    "vec3 mean = texture(u_angular, vec2(float(COLUMNS - 1) / float(COLUMNS), (row + 0.5) / float(ROWS))).rgb / ((1.0 + q) * (1.0 + q) * (1.0 + q));\n"
    "if (row >= float(ROWS - 1)) mean = u_burst[1].rgb / (q * q * q);\n"
    "float far = clamp(relative - float(SAMPLES - 1) / 32.0 + 1.0, 0.0, 1.0), size = min(log2(8.0 * blur), float(SIZES - 1));\n"
    "vec3 disc = texture(u_radial, vec2((min(32.0 * relative, float(SAMPLES - 1)) + 0.5) / float(SAMPLES), (size + 0.5) / float(SIZES))).rgb;\n"
    "return angle * (far * mean * (1.0 + 1.125 * q * q / (relative * relative * (1.0 + q) * (1.0 + q))) + (1.0 - far) * disc * disc / (PI * blur * blur));\n"
    "}\n"
    "void main()\n"
    "{\n"
    "vec3 share;\n"
    "if (v_streak > 0.0) {\n"
    "float along = max(1.0 - abs(v_position.x) / v_streak, 0.0), u = v_position.y / v_irradiance.w, across = max(1.0 - u * u, 0.0);\n"
    "share = vec3(1.875 * along * along * along / v_streak * across * across / v_irradiance.w);\n"
    "} else {\n"
    "share = starburst();\n"
    "}\n"
    "o_color = vec4(min(v_irradiance.rgb * share, MOST), 0.0);\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_starburst_vert[] = {
    "uniform highp usampler2D u_visibility;\n"
    "flat out vec4 v_irradiance;\n"
    "flat out float v_streak;\n"
    "out vec2 v_position;\n"
    "void main()\n"
    "{\n"
    "int light = (gl_InstanceID >> 1) * 4;\n"
    "vec4 l1 = u_lights[light + 1], l2 = u_lights[light + 2], l3 = u_lights[light + 3];\n"
    "vec2 image = vec2(l1.w, l2.x), corner = 2.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, reach = l3.zz;\n"
    "vec3 irradiance = l2.yzw * u_strip.y;\n"
    "int place = int(l3.x);\n"
    "float lamp = u_lens.y * l1.z;\n"
    "if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);\n"
    "v_irradiance = vec4(irradiance * u_burst[0].rgb, sqrt(lamp * lamp + 0.318 * u_lens.x * u_lens.x));\n"
    "v_streak = 0.0;\n"
    "if ((gl_InstanceID & 1) != 0) {\n"
    "float half_width = sqrt(u_burst[1].w * u_burst[1].w + 7.0 * (0.715 * 0.715 / 5.0 * u_lens.x * u_lens.x + 0.25 * lamp * lamp));\n"
    "reach = vec2(l3.w, l3.w > 0.0 ? half_width : 0.0);\n"
    "v_irradiance = vec4(irradiance * u_burst[2].rgb, half_width);\n"
    "v_streak = l3.w;\n"
    "}\n"
    "v_position = corner * reach;\n"
    "gl_Position = vec4(-(image + v_position - u_half.zw) / u_half.xy, 0.0, 1.0);\n"
    "if (!(reach.x > 0.0) || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) gl_Position = vec4(2.0, 2.0, 0.0, 1.0);\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_strip_frag[] = {
    "layout(std140) uniform lflare_strip {\n"
    "vec4 u_clip[3];\n"
    "vec4 u_region;\n"
    "vec4 u_fade;\n"
    "vec4 u_disc[232];\n"
    "};\n"
    "uniform highp sampler2D u_depth;\n"
    "uniform highp usampler2D u_before;\n"
    "out highp uint o_visibility;\n"
    "const float TURN = 2.3075, START = 0.55;\n"
    "float disc_open(vec4 disc)\n"
    "{\n"
    "vec2 whole = vec2(textureSize(u_depth, 0)), size = u_region.z > 0.0 ? u_region.zw : whole;\n"
    "vec2 last = min(u_region.xy + size, whole) - 1.0, from = min(u_region.xy, last);\n"
    "vec3 middle = normalize(vec3(disc.xy, -1.0)), across = normalize(cross(middle, vec3(0.0, 1.0, 0.0))), up = cross(across, middle);\n"
    "float radius = max(disc.z, 2.0 / (size.y * length(u_clip[1].xy))), open = 0.0;\n"
    "mat3 turned = mat3(across, up, middle), place = transpose(mat3(u_clip[0].xyz, u_clip[1].xyz, u_clip[2].xyz)) * turned;\n"
    "for (float i = START; i < u_fade.w; i += 4.0) {\n"
    "vec4 at = vec4(i, i + 1.0, i + 2.0, i + 3.0), far = radius * sqrt(at / u_fade.w), depth;\n"
    "vec4 x = far * cos(TURN * at), y = far * sin(TURN * at);\n"
    "for (int k = 0; k < 4; k++) {\n"
    "vec3 clip = place * vec3(x[k], y[k], 1.0);\n"
    "vec2 texel = u_region.xy + size * (0.5 + 0.5 * clip.xy / max(clip.z, 1e-3));\n"
    "depth[k] = texelFetch(u_depth, ivec2(clamp(texel, from, last)), 0).r;\n"
    "}\n"
    "open += dot(step(0.0, (depth - disc.w) * u_fade.z), vec4(1.0));\n"
    "}\n"
    "return open / u_fade.w;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "int light = int(gl_FragCoord.x);\n"
    "float before = uintBitsToFloat(texelFetch(u_before, ivec2(light, 0), 0).r), now = 0.0;\n"
    "vec4 disc = u_disc[light];\n"
    "if (disc.z >= 0.0) now = disc_open(disc);\n"
    "float faded = before + (now - before) * (now > before ? u_fade.x : u_fade.y);\n"
    "if (light >= int(u_clip[0].w) || abs(now - faded) < 1e-5) faded = now;\n"
    "o_visibility = floatBitsToUint(faded);\n"
    "}\n"
    , NULL};
static const char *const lflare__glsl_traced_vert[] = {
    "uniform highp sampler2D u_traced_lens;\n"
    "uniform highp usampler2D u_visibility;\n"
    "invariant gl_Position;\n"
    "in uvec4 a_instance;\n"
    "const int DIRECTIONS = 9, RINGS = 5, BANDS = 3, ROW = 1024, SURFACE = 131, STYLE = 11, GHOST = 796 + STYLE, OUTLINE = 265, KNOTS = 12, KNOT = 22, SIDES = 17;\n"
    "const float PI = 3.14159265;\n"
    "centroid out vec3 v_irradiance, v_flux;\n"
    "centroid out float v_most;\n"
    "out vec2 v_entrance;\n"
    "#ifdef PATCH_RIM\n"
    "out vec4 v_iris01, v_iris2;\n"
    "out vec3 v_rim;\n"
    "out vec4 v_bulge;\n"
    "flat out vec4 v_light;\n"
    "flat out vec2 v_spectrum;\n"
    "out vec2 v_bundle;\n"
    "#endif\n"
    "vec4 lens(int i) { return texelFetch(u_traced_lens, ivec2(i % ROW, i / ROW), 0); }\n"
    "int g_steps, g_count;\n"
    "float g_sensor, g_slope;\n"
    "mat4 g_shares;\n"
    "struct Rays {\n"
    "vec4 x, y, z, dx, dy, dz, stop_x, stop_y, sensor_x, sensor_y, relative;\n"
    "bvec4 arrives;\n"
    "};\n"
    "float term(vec4 a, vec4 b, int j) { return j < 4 ? a[j] : b[j - 4]; }\n"
    "bvec4 both(bvec4 a, bvec4 b) { return bvec4(a.x && b.x, a.y && b.y, a.z && b.z, a.w && b.w); }\n"
    "void meet(vec4 s, int surface, float way, bool bent, inout Rays r, out vec4 nx, out vec4 ny, out vec4 nz)\n"
    "{\n"
    "float c = s.y, k = s.w;\n"
    "vec4 t = r.z / r.dz;\n"
    "r.x -= t * r.dx;\n"
    "r.y -= t * r.dy;\n"
    "vec4 u = c * (r.dx * r.dx + r.dy * r.dy + k * r.dz * r.dz), v = c * (r.x * r.dx + r.y * r.dy) - r.dz, e = c * (r.x * r.x + r.y * r.y), root = v * v - u * e;\n"
    "bvec4 meets = greaterThanEqual(root, vec4(0.0));\n"
    "t = e / (way * sqrt(max(root, 0.0)) - v);\n"
    "if (bent) t = mix(vec4(0.0), t, meets);\n"
    "else r.arrives = both(r.arrives, meets);\n"
    "r.x += t * r.dx;\n"
    "r.y += t * r.dy;\n"
    "r.z = t * r.dz;\n"
    "nx = ny = vec4(c);\n"
    "nz = c * k * r.z - 1.0;\n"
    "if (bent) {\n"
    "vec4 a = lens(surface * SURFACE + 1), b = lens(surface * SURFACE + 2);\n"
    "float inverse = s.z * s.z;\n"
    "for (int pass = 0; pass < 6; pass++) {\n"
    "vec4 r2 = r.x * r.x + r.y * r.y, left = 1.0 - k * c * c * r2, conic = sqrt(max(left, 1e-6)), at = r2 * inverse, sag = vec4(0.0), slope = vec4(0.0);\n"
    "for (int j = 7; j >= 0; j--) {\n"
    "slope = slope * at + sag;\n"
    "sag = sag * at + term(a, b, j);\n"
    "}\n"
    "slope = slope * at + sag;\n"
    "sag = sag * at + c * r2 / (1.0 + conic);\n"
    "nx = c / conic + 2.0 * slope * inverse;\n"
    "r.arrives = both(r.arrives, greaterThanEqual(left, vec4(0.0)));\n"
    "t = (sag - r.z) / (r.dz - nx * (r.x * r.dx + r.y * r.dy));\n"
    "r.x += t * r.dx;\n"
    "r.y += t * r.dy;\n"
    "r.z += t * r.dz;\n"
    "}\n"
    "ny = nx;\n"
    "nz = vec4(-1.0);\n"
    "}\n"
    "r.arrives = both(r.arrives, lessThan(nz, vec4(0.0)));\n"
    "nx *= r.x;\n"
    "ny *= r.y;\n"
    "if (k != 1.0 || bent) {\n"
    "t = inversesqrt(nx * nx + ny * ny + nz * nz);\n"
    "nx *= t;\n"
    "ny *= t;\n"
    "nz *= t;\n"
    "}\n"
    "}\n"
    "void go_on(vec4 eta, bool reflected, float way, vec4 nx, vec4 ny, vec4 nz, inout Rays r, out float film_at)\n"
    "{\n"
    "vec4 along = r.dx * nx + r.dy * ny + r.dz * nz, beyond = 1.0 - eta * eta * (1.0 - along * along);\n"
    "film_at = eta.x > 1.0 ? sqrt(max(beyond.x, 0.0)) : abs(along.x);\n"
    "vec4 kept = vec4(1.0), more = -2.0 * along;\n"
    "if (!reflected) {\n"
    "r.arrives = both(r.arrives, greaterThanEqual(beyond, vec4(0.0)));\n"
    "kept = eta;\n"
    "more = -way * sqrt(max(beyond, 0.0)) - eta * along;\n"
    "}\n"
    "r.dx = kept * r.dx + more * nx;\n"
    "r.dy = kept * r.dy + more * ny;\n"
    ,
    "r.dz = kept * r.dz + more * nz;\n"
    "}\n"
    "Rays rays_at(vec4 x, vec4 y)\n"
    "{\n"
    "float norm = inversesqrt(1.0 + g_slope * g_slope);\n"
    "return Rays(x, y, vec4(0.0), vec4(g_slope * norm), vec4(0.0), vec4(norm), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), bvec4(true));\n"
    "}\n"
    "void pass_step(vec4 s, vec4 steps, int code, mat4 shares, inout Rays r, out float film_at)\n"
    "{\n"
    "float way = (code & 8) != 0 ? -1.0 : 1.0;\n"
    "vec4 nx, ny, nz;\n"
    "film_at = 1.0;\n"
    "r.z -= s.x;\n"
    "r.arrives = both(r.arrives, greaterThan(r.dz * way, vec4(0.0)));\n"
    "meet(s, code / 16, way, (code & 4) != 0, r, nx, ny, nz);\n"
    "if ((code & 3) == 2) {\n"
    "r.stop_x = r.x / u_lens.w;\n"
    "r.stop_y = r.y / u_lens.w;\n"
    "} else if ((code & 2) != 0) {\n"
    "r.relative = max(r.relative, (r.x * r.x + r.y * r.y) / (u_lens.w * u_lens.w));\n"
    "} else {\n"
    "r.relative = max(r.relative, (r.x * r.x + r.y * r.y) * (s.z * s.z));\n"
    "go_on(vec4(steps.xyz, 0.0) * shares, (code & 1) != 0, way, nx, ny, nz, r, film_at);\n"
    "}\n"
    "}\n"
    "void land(inout Rays r)\n"
    "{\n"
    "vec4 t = (g_sensor - r.z) / r.dz;\n"
    "r.relative = sqrt(r.relative);\n"
    "r.sensor_x = r.x + t * r.dx;\n"
    "r.sensor_y = r.y + t * r.dy;\n"
    "vec4 sum = r.sensor_x + r.sensor_y + r.relative;\n"
    "r.arrives = both(both(r.arrives, greaterThan(r.dz, vec4(0.0))), equal(sum, sum));\n"
    "}\n"
    "vec3 trace(inout Rays own, inout Rays near)\n"
    "{\n"
    "vec3 weight = vec3(1.0);\n"
    "mat4 alike = mat4(g_shares[0], g_shares[0], g_shares[0], g_shares[0]);\n"
    "for (int i = 0; i < g_count; i++) {\n"
    "vec4 s = ghosts(g_steps + 2 * i), steps = ghosts(g_steps + 2 * i + 1);\n"
    "int code = int(steps.w);\n"
    "float film_at, unused;\n"
    "pass_step(s, steps, code, g_shares, own, film_at);\n"
    "pass_step(s, steps, code, alike, near, unused);\n"
    "if ((code & 2) == 0) {\n"
    "float at = 127.0 * film_at;\n"
    "int first = int(clamp(at, 0.0, 126.0)), row = code / 16 * SURFACE + 3 + first;\n"
    "vec3 share = mix(lens(row).rgb, lens(row + 1).rgb, at - float(first));\n"
    "weight *= (code & 1) != 0 ? share : vec3(1.0) - share;\n"
    "}\n"
    "}\n"
    "land(own);\n"
    "land(near);\n"
    "return weight;\n"
    "}\n"
    "bool arrives_at(vec2 place)\n"
    "{\n"
    "Rays r = rays_at(vec4(place.x), vec4(place.y));\n"
    "float unused;\n"
    "for (int i = 0; i < g_count && r.arrives.x; i++) {\n"
    "vec4 steps = ghosts(g_steps + 2 * i + 1);\n"
    "pass_step(ghosts(g_steps + 2 * i), steps, int(steps.w), g_shares, r, unused);\n"
    "}\n"
    "land(r);\n"
    "return r.arrives.x;\n"
    "}\n"
    "int g_knot;\n"
    "float g_between;\n"
    "vec4 knot(int i) { return mix(ghosts(g_knot + i), ghosts(g_knot + KNOT + i), g_between); }\n"
    "vec2 place_at(float at, vec2 toward, vec4 shape)\n"
    "{\n"
    "vec2 p = at * shape.yz * toward;\n"
    "return vec2(shape.x + p.x + shape.w * at * toward.y * at * toward.y, p.y);\n"
    "}\n"
    "float last_at(float at, vec2 toward, vec4 shape)\n"
    "{\n"
    "float near = 0.0, far = at;\n"
    "for (int tries = 1; tries < 8; tries++) {\n"
    "at = 0.5 * (near + far);\n"
    "if (arrives_at(place_at(at, toward, shape))) near = at;\n"
    "else far = at;\n"
    "}\n"
    "return near;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "int ghost = int(a_instance.x) * GHOST, light = int(a_instance.y) * 4, patch_index = int(a_instance.z);\n"
    "vec4 style0 = ghosts(ghost + 1), style1 = ghosts(ghost + 2), style2 = ghosts(ghost + 3), l0 = u_lights[light], l1 = u_lights[light + 1], l2 = u_lights[light + 2];\n"
    ,
    "if (style2.z > 0.0) style0.rgb *= ramp(ghost + 4, int(style2.z) - 1, l1.y);\n"
    "vec2 slope = l0.xy, axis = l0.zw;\n"
    "vec3 irradiance = l2.yzw * u_strip.y * (1.0 - float(a_instance.w >> 10) / 63.0);\n"
    "int place = int(u_lights[light + 3].x), first = int(a_instance.w & 15u), outline = ghost + 1 + STYLE + OUTLINE;\n"
    "gl_Position = vec4(2.0, 2.0, 0.0, 1.0);\n"
    "v_irradiance = v_flux = vec3(0.0);\n"
    "v_entrance = vec2(0.0);\n"
    "v_most = 0.0;\n"
    "#ifdef PATCH_RIM\n"
    "v_iris01 = v_iris2 = vec4(1.0);\n"
    "v_rim = vec3(1.0);\n"
    "v_bulge = v_light = vec4(0.0);\n"
    "v_spectrum = v_bundle = vec2(0.0);\n"
    "#endif\n"
    "if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);\n"
    "int code = int(ghosts(outline + 1 + first * KNOT + 2).w), rings = code & 63, directions = (code & 64) != 0 ? 32 : 16;\n"
    "for (int levels = int(a_instance.w >> 8) & 3; levels > 0; levels--)\n"
    "if (rings > 4) rings /= 2;\n"
    "else directions = 16;\n"
    "bool split_mesh = (code & 128) != 0, ragged = (code & 256) != 0;\n"
    "int sectors = directions / 4, blocks = rings / 4, mesh = split_mesh ? patch_index / (sectors * blocks) : -1, block = patch_index / sectors % blocks;\n"
    "if (split_mesh && u_bands.x == 0.0) outline = ghost + 1 + STYLE + mesh * OUTLINE;\n"
    "vec4 h = ghosts(outline);\n"
    "#ifdef PATCH_STRIP\n"
    "bool drawn = ragged || block == blocks - 1;\n"
    "#else\n"
    "bool drawn = !ragged;\n"
    "#endif\n"
    "if (!(l1.y < h.x) || !drawn || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;\n"
    "vec4 path = ghosts(ghost);\n"
    "g_steps = int(path.x);\n"
    "g_count = int(path.y);\n"
    "g_sensor = path.z;\n"
    "g_slope = l1.x;\n"
    "g_lamp = l1.z * style0.w;\n"
    "int last_mesh = int(u_bands.x) - 1;\n"
    "vec4 lead = u_bands.x > 0.0 ? vec4(place_shares(max(mesh, 0)), 0.0) : vec4(equal(ivec4(mesh), ivec4(0, 1, 2, 3)));\n"
    "vec4 before = u_bands.x > 0.0 ? vec4(place_shares(max(mesh - 1, 0)), 0.0) : lead, behind = u_bands.x > 0.0 ? vec4(place_shares(min(mesh + 1, last_mesh)), 0.0) : lead;\n"
    "g_shares = split_mesh ? mat4(lead, before, behind, lead) : mat4(vec4(0.0, 1.0, 0.0, 0.0), vec4(1.0, 0.0, 0.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(0.0, 1.0, 0.0, 0.0));\n"
    "float at = (1.0 - sqrt(max(1.0 - l1.y / h.x, 0.0))) * float(KNOTS - 1), scale = style0.w;\n"
    "g_between = at - float(first);\n"
    "g_knot = outline + 1 + first * KNOT;\n"
    "vec4 shape = ragged ? ghosts(g_knot + 4) : knot(0), whole = knot(1), bounds = knot(2), brighter = knot(3);\n"
    "float entrance = max(whole.z, 1e-6);\n"
    "vec3 growth = grow(whole.y, entrance, whole.x, h.y, whole.w < 0.0 ? -scale : scale, l1.z);\n"
    "float grown = growth.x, even = growth.y, gain = growth.z;\n"
    "int row = gl_VertexID / DIRECTIONS, direction = patch_index % sectors * (DIRECTIONS - 1) + gl_VertexID % DIRECTIONS;\n"
    "float side = direction > directions ? -1.0 : 1.0, turn = float(direction);\n"
    "if (direction > directions) direction = 2 * directions - direction;\n"
    "float beside_at = float(direction) * float(SIDES - 1) / float(directions);\n"
    "int beside_first = int(min(beside_at, float(SIDES - 2)));\n"
    "vec4 beside = mix(knot(5 + beside_first), knot(6 + beside_first), beside_at - float(beside_first));\n"
    ,
    "float about = whole.y / entrance, iris_soft = soft(whole.x), widest = sqrt(u_spectrum.x / u_spectrum.y);\n"
    "float inverse = 1.1 / max(scale * beside.z + abs(grown) * whole.z, 1.5 * u_lens.x);\n"
    "vec2 reach = edges(vec4(iris_soft, soft(beside.w), widest * fringe(about * about, whole.x, scale), widest * fringe(about * about, beside.w, scale)) * inverse);\n"
    "float begin = float(rings) * max(beside.y - reach.x - u_strip.w - 0.04, 0.0), end = float(rings) * (1.0 + reach.y + u_strip.w + 0.04);\n"
    "if (ragged) {\n"
    "begin = float(block * (RINGS - 1));\n"
    "end = begin + float(RINGS - 1);\n"
    "beside.x = 1.0;\n"
    "}\n"
    "#ifdef PATCH_STRIP\n"
    "at = begin + (end - begin) * float(row) / float(BANDS - 1);\n"
    "#else\n"
    "at = min(float(block * (RINGS - 1) + row), begin);\n"
    "#endif\n"
    "float angle = PI * float(direction) / float(directions), edge = 0.0;\n"
    "vec2 toward = vec2(cos(angle), direction == 0 || direction == directions ? 0.0 : sin(angle)), h2 = 0.3 * shape.yz / float(rings), ray_at;\n"
    "vec4 ways = vec4(-h2.x, h2.x, -h2.y, h2.y);\n"
    "vec3 weight;\n"
    "Rays own, near;\n"
    "at *= beside.x / float(rings);\n"
    "for (int pass = 0; pass < 2; pass++) {\n"
    "ray_at = place_at(at, toward, shape);\n"
    "own = rays_at(ray_at.x + vec4(0.0, 0.0, 0.0, h2.x), ray_at.y + vec4(0.0, 0.0, 0.0, h2.y));\n"
    "near = rays_at(ray_at.x + vec4(ways.xy, 0.0, 0.0), ray_at.y + vec4(0.0, 0.0, ways.zw));\n"
    "weight = trace(own, near);\n"
    "if (own.arrives.x || pass == 1) break;\n"
    "at = last_at(at, toward, shape);\n"
    "edge = 1.0;\n"
    "}\n"
    "own.relative.x = own.arrives.x ? max(own.relative.x, edge) : 2.0;\n"
    "bool whole_ray = own.arrives.x && own.arrives.w && all(near.arrives);\n"
    "vec4 x = near.sensor_x - own.sensor_x.x, y = near.sensor_y - own.sensor_y.x, more = (near.relative - own.relative.x) / (ways * ways);\n"
    "float curved = more.x + more.y + more.z + more.w;\n"
    "vec4 middle = 0.5 * vec4((x.y - x.x) / h2.x, (y.y - y.x) / h2.x, (x.w - x.z) / h2.y, (y.w - y.z) / h2.y);\n"
    "vec4 bent = vec4(vec2(x.x + x.y, y.x + y.y) / (h2.x * h2.x), vec2(x.z + x.w, y.z + y.w) / (h2.y * h2.y));\n"
    "vec2 twist = vec2(own.sensor_x.w - near.sensor_x.y - x.w, own.sensor_y.w - near.sensor_y.y - y.w) / (h2.x * h2.y);\n"
    "vec2 grows = vec2(bent.x * middle.w + middle.x * twist.y - bent.y * middle.z - middle.y * twist.x,\n"
    "twist.x * middle.w + middle.x * bent.w - twist.y * middle.z - middle.y * bent.z);\n"
    "vec2 radial = shape.yz * toward * beside.x / float(rings), around = shape.yz * vec2(-toward.y, toward.x) * (PI / float(directions) * at);\n"
    "float shrink = whole_ray ? middle.x * middle.w - middle.y * middle.z : 0.0;\n"
    "float spread = whole_ray ? max(max(abs(dot(grows, radial)), abs(dot(grows, around))), 1e-20) : 1e30;\n"
    "float flat_share = max(even, clamp(2.0 - abs(shrink) / spread, 0.0, 1.0)), chord = length(around);\n"
    "if (!split_mesh) weight.rb *= brighter.xy;\n"
    "vec2 spectrum = u_bands.x > 0.0 ? spectrum_of(int(a_instance.x), l1.y, h.x) : vec2(0.0), bundle = u_bands.x > 0.0 ? bundle_of(spectrum, ray_at) : vec2(0.0);\n"
    "vec3 flux = channels(spectrum, bundle, mesh, weight) * gain, light_colour = irradiance * style0.rgb;\n"
    "#ifndef PATCH_RIM\n"
    ,
    "flux *= summed(spectrum, bundle, mesh) * light_colour;\n"
    "#endif\n"
    "if (flat_share < 1.0) v_irradiance = (1.0 - flat_share) * flux / max(abs(shrink), spread);\n"
    "v_flux = flat_share * flux * scale * scale;\n"
    "v_most = 8.0 / ((whole_ray ? spread : max(about * about, 1e-20)) * scale * scale);\n"
    "float centre = bounds.z;\n"
    "vec2 in_at = vec2(ray_at.x - shape.x, side * ray_at.y), local = vec2(centre + scale * (own.sensor_x.x - centre), scale * side * own.sensor_y.x) + grown * in_at;\n"
    "v_entrance = vec2(in_at.x * axis.x - in_at.y * axis.y, in_at.x * axis.y + in_at.y * axis.x);\n"
    "#ifdef PATCH_RIM\n"
    "v_light = vec4(light_colour, split_mesh ? 0.0 : u_bands.x);\n"
    "v_spectrum = spectrum;\n"
    "v_bundle = bundle;\n"
    "float apart = 0.0;\n"
    "if (split_mesh && own.arrives.y && own.arrives.z) apart = 0.715 * 0.5 * scale * length(vec2(own.sensor_x.z - own.sensor_x.y, own.sensor_y.z - own.sensor_y.y)) / u_lens.x;\n"
    "vec4 off_x = own.sensor_x.x - own.sensor_x, off_y = own.sensor_y.x - own.sensor_y;\n"
    "bvec4 matched = bvec4(!split_mesh && whole_ray && abs(shrink) > 1e-20);\n"
    "matched = both(matched, own.arrives);\n"
    "vec4 move_x = clamp(mix(vec4(0.0), (off_x * middle.w - off_y * middle.z) / shrink, matched), -0.5 * shape.y, 0.5 * shape.y);\n"
    "vec4 move_y = clamp(mix(vec4(0.0), (off_y * middle.x - off_x * middle.y) / shrink, matched), -0.5 * shape.z, 0.5 * shape.z);\n"
    "vec4 slopes_x = vec4(near.stop_x.y - near.stop_x.x, near.stop_y.y - near.stop_y.x, near.relative.y - near.relative.x, 0.0) / (2.0 * h2.x);\n"
    "vec4 slopes_y = vec4(near.stop_x.w - near.stop_x.z, near.stop_y.w - near.stop_y.z, near.relative.w - near.relative.z, 0.0) / (2.0 * h2.y);\n"
    "vec4 stop_x = mix(own.stop_x.xxxx, own.stop_x, matched) + slopes_x.x * move_x + slopes_y.x * move_y;\n"
    "vec4 stop_y = mix(own.stop_y.xxxx, own.stop_y, matched) + slopes_x.y * move_x + slopes_y.y * move_y;\n"
    "vec4 rims = max(mix(own.relative.xxxx, own.relative, matched) + slopes_x.z * move_x + slopes_y.z * move_y, 0.0);\n"
    "mat2 to_sensor = mat2(axis.x, axis.y, -axis.y * side, axis.x * side);\n"
    "v_iris01 = vec4(to_sensor * vec2(stop_x.y, stop_y.y), to_sensor * vec2(stop_x.x, stop_y.x));\n"
    "v_iris2 = vec4(to_sensor * vec2(stop_x.z, stop_y.z), length(vec2(soft(beside.w) / u_lens.x, apart)), length(vec2(iris_soft / u_lens.x, apart)));\n"
    "v_rim = rims.yxz;\n"
    "v_bulge = vec4(turn, 4.0 * clamp(0.125 * chord * chord * curved, 0.0, 0.05), vec2(fringe(shrink, whole.x, scale), fringe(shrink, beside.w, scale)) / u_lens.x);\n"
    "#endif\n"
    "vec2 position = vec2(local.x * axis.x - local.y * axis.y, local.x * axis.y + local.y * axis.x);\n"
    "position += u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x)) + style2.xy;\n"
    "gl_Position = vec4(-(position - u_half.zw) / u_half.xy, 0.0, 1.0);\n"
    "}\n"
    , NULL};
/* -- shaders end */

static int lflare__gl_has(const lflare_gl *o, int who)
{
    return who == LFLARE__GL_ALL || (who == LFLARE__GL_DESKTOP && !o->es) || (who == LFLARE__GL_WEB && o->web);
}

static void lflare__gl_save(const lflare_gl *o, lflare__glstate *s)
{
    const lflare__glapi *gl = &o->api;
    int32_t i = 0, k;
    memset(s, 0, sizeof *s);
#define LFLARE__GL_SAVE(name, who, need, text) \
    if (lflare__gl_has(o, who)) s->capability[i] = gl->IsEnabled(name); \
    i++;
    LFLARE__GL_CAPABILITIES(LFLARE__GL_SAVE)
#undef LFLARE__GL_SAVE
    i = 0;
#define LFLARE__GL_SAVE(name, who, text, set) \
    if (lflare__gl_has(o, who)) gl->GetIntegerv(name, s->value[i]); \
    i++;
    LFLARE__GL_VALUES(LFLARE__GL_SAVE)
#undef LFLARE__GL_SAVE
    for (k = 0; k < LFLARE__GL_UNITS; k++) {
        gl->ActiveTexture(0x84C0 + (lflare__glenum)k);
        gl->GetIntegerv(0x8069, &s->texture[k]);
        gl->GetIntegerv(0x8919, &s->sampler[k]);
    }
    gl->GetIntegeri_v(0x8A28, 0, &s->uniform_buffer);
    gl->GetInteger64i_v(0x8A29, 0, &s->uniform_start);
    gl->GetInteger64i_v(0x8A2A, 0, &s->uniform_size);
}

static void lflare__gl_restore(const lflare_gl *o, const lflare__glstate *s)
{
    const lflare__glapi *gl = &o->api;
    lflare__glenum blend[4] = {0, 0, 0, 0};
    int32_t i = 0, k;
#define LFLARE__GL_RESTORE(name, who, need, text)         \
    if (lflare__gl_has(o, who)) {                         \
        if (s->capability[i]) gl->Enable(name);               \
        else gl->Disable(name);                               \
    }                                                         \
    i++;
    LFLARE__GL_CAPABILITIES(LFLARE__GL_RESTORE)
#undef LFLARE__GL_RESTORE
    for (k = 0; k < LFLARE__GL_UNITS; k++) {
        gl->ActiveTexture(0x84C0 + (lflare__glenum)k);
        gl->BindTexture(0x0DE1, (lflare__gluint)s->texture[k]);
        gl->BindSampler((lflare__gluint)k, (lflare__gluint)s->sampler[k]);
    }
    if (s->uniform_size > 0)
        gl->BindBufferRange(0x8A11, 0, (lflare__gluint)s->uniform_buffer, (ptrdiff_t)s->uniform_start, (ptrdiff_t)s->uniform_size);
    else
        gl->BindBufferBase(0x8A11, 0, (lflare__gluint)s->uniform_buffer);
    i = 0;
#define LFLARE__GL_RESTORE(name, who, text, set) \
    if (lflare__gl_has(o, who)) {                             \
        const lflare__glint *v = s->value[i];               \
        set;                                                \
    }                                                       \
    i++;
    LFLARE__GL_VALUES(LFLARE__GL_RESTORE)
#undef LFLARE__GL_RESTORE
}

/* What the programs are made of; `shared` and `patches` go before both shaders, `cuts` before the fragment shader alone. */
typedef struct lflare__gl_source {
    const char *define, *const *shared, *const *patches, *const *vertex, *const *cuts, *const *fragment, *block, *samplers[LFLARE__GL_UNITS];
} lflare__gl_source;

static const lflare__gl_source lflare__gl_sources[LFLARE__GL_PROGRAMS] = {
    {"#define RIM\n", lflare__glsl_frame, NULL, lflare__glsl_ghost_vert, lflare__glsl_cuts, lflare__glsl_ghost_frag, "lflare_frame", {"u_lens_table", "u_settings_table", "u_visibility", NULL, NULL}},
    {"#define RIM\n#define FRINGES\n", lflare__glsl_frame, NULL, lflare__glsl_ghost_vert, lflare__glsl_cuts, lflare__glsl_ghost_frag, "lflare_frame", {"u_lens_table", "u_settings_table", "u_visibility", "u_mask", "u_ringing", "u_fringed"}},
    {"#define INSIDE\n", lflare__glsl_frame, NULL, lflare__glsl_ghost_vert, lflare__glsl_cuts, lflare__glsl_ghost_frag, "lflare_frame", {"u_lens_table", "u_settings_table", "u_visibility", NULL, NULL}},
    {"", NULL, NULL, lflare__glsl_screen_vert, NULL, lflare__glsl_strip_frag, "lflare_strip", {"u_depth", "u_before", NULL, NULL, NULL}},
    {"", NULL, NULL, lflare__glsl_screen_vert, NULL, lflare__glsl_add_frag, NULL, {"u_half_picture", NULL, NULL, NULL, NULL}},
    {"#define PATCH\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_patch_vert, NULL, lflare__glsl_patch_frag, "lflare_frame", {"u_mesh_table", "u_ghosts", "u_visibility", NULL, NULL}},
    {"#define PATCH_RIM\n#define PATCH_STRIP\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_patch_vert, lflare__glsl_cuts, lflare__glsl_patch_frag, "lflare_frame", {"u_mesh_table", "u_ghosts", "u_visibility", NULL, NULL}},
    {"#define PATCH_RIM\n#define PATCH_STRIP\n#define FRINGES\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_patch_vert, lflare__glsl_cuts, lflare__glsl_patch_frag, "lflare_frame", {"u_mesh_table", "u_ghosts", "u_visibility", "u_mask", "u_ringing", "u_fringed"}},
    {"#define PATCH_RIM\n#define FRINGES\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_patch_vert, lflare__glsl_cuts, lflare__glsl_patch_frag, "lflare_frame", {"u_mesh_table", "u_ghosts", "u_visibility", "u_mask", "u_ringing", "u_fringed"}},
    {"#define PATCH\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_traced_vert, NULL, lflare__glsl_patch_frag, "lflare_frame", {"u_traced_lens", "u_ghosts", "u_visibility", NULL, NULL}},
    {"#define PATCH_RIM\n#define PATCH_STRIP\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_traced_vert, lflare__glsl_cuts, lflare__glsl_patch_frag, "lflare_frame", {"u_traced_lens", "u_ghosts", "u_visibility", NULL, NULL}},
    {"#define PATCH_RIM\n#define PATCH_STRIP\n#define FRINGES\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_traced_vert, lflare__glsl_cuts, lflare__glsl_patch_frag, "lflare_frame", {"u_traced_lens", "u_ghosts", "u_visibility", "u_mask", "u_ringing", "u_fringed"}},
    {"#define PATCH_RIM\n#define FRINGES\n", lflare__glsl_frame, lflare__glsl_patches, lflare__glsl_traced_vert, lflare__glsl_cuts, lflare__glsl_patch_frag, "lflare_frame", {"u_traced_lens", "u_ghosts", "u_visibility", "u_mask", "u_ringing", "u_fringed"}},
    {"", lflare__glsl_frame, NULL, lflare__glsl_starburst_vert, NULL, lflare__glsl_starburst_frag, "lflare_frame", {"u_angular", "u_radial", "u_visibility", NULL, NULL}}};

/* Compilers of some drivers run beside us: shaders and programs are all begun before the first is asked how it went. */
static lflare__gluint lflare__gl_shader(const lflare_gl *o, lflare__glenum kind, const lflare__gl_source *source)
{
    static const char *const preludes[2] = {"#version 330 core\n", "#version 300 es\nprecision highp float;\nprecision highp int;\n"};
    const lflare__glapi *gl = &o->api;
    const char *const *body = kind == 0x8B31 ? source->vertex : source->fragment;
    const char *pieces[32];
    lflare__gluint shader = gl->CreateShader(kind);
    int count = 0, i;
    pieces[count++] = preludes[o->es];
    pieces[count++] = source->define;
    for (i = 0; source->shared != NULL && source->shared[i] != NULL; i++) pieces[count++] = source->shared[i];
    if (kind == 0x8B31) pieces[count++] = "#define PATCH_VERTEX\n";
    for (i = 0; source->patches != NULL && source->patches[i] != NULL; i++) pieces[count++] = source->patches[i];
    for (i = 0; kind == 0x8B30 && source->cuts != NULL && source->cuts[i] != NULL; i++) pieces[count++] = source->cuts[i];
    for (i = 0; body[i] != NULL; i++) pieces[count++] = body[i];
    LFLARE_ASSERT(count <= 32);
    gl->ShaderSource(shader, count, pieces, NULL);
    gl->CompileShader(shader);
    return shader;
}

/* `shaders`: its vertex and its fragment shader. */
static void lflare__gl_program_begin(lflare_gl *o, int program, lflare__gluint *shaders)
{
    const lflare__gl_source *source = &lflare__gl_sources[program];
    const lflare__glapi *gl = &o->api;
    lflare__gluint made = o->programs[program] = gl->CreateProgram();
    int k;
    for (k = 0; k < 2; k++) {
        shaders[k] = lflare__gl_shader(o, k == 0 ? 0x8B31 : 0x8B30, source);
        gl->AttachShader(made, shaders[k]);
    }
    gl->BindAttribLocation(made, 0, "a_instance");
    gl->LinkProgram(made);
}

static lflare_result lflare__gl_program_end(const lflare_gl *o, int program, const lflare__gluint *shaders, const lflare_gl_desc *desc, lflare_error *error)
{
    const lflare__gl_source *source = &lflare__gl_sources[program];
    const lflare__glapi *gl = &o->api;
    lflare__gluint made = o->programs[program];
    int k, log_size = desc->log != NULL ? (int)lflare__min((double)desc->log_size, 1e9) : 0;
    lflare__glint done = 0;
    gl->GetProgramiv(made, 0x8B82, &done);
    if (done) {
        gl->UseProgram(made);
        if (source->block != NULL) gl->UniformBlockBinding(made, gl->GetUniformBlockIndex(made, source->block), 0);
        for (k = 0; k < LFLARE__GL_UNITS && source->samplers[k] != NULL; k++) gl->Uniform1i(gl->GetUniformLocation(made, source->samplers[k]), k);
        return LFLARE_OK;
    }
    for (k = 0; k < 2; k++) { /* nothing links with what does not compile */
        gl->GetShaderiv(shaders[k], 0x8B81, &done);
        if (done) continue;
        if (log_size > 0) gl->GetShaderInfoLog(shaders[k], log_size, NULL, desc->log);
        return lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "the %s shader does not compile: see the log", k == 0 ? "vertex" : "fragment");
    }
    if (log_size > 0) gl->GetProgramInfoLog(made, log_size, NULL, desc->log);
    return lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "the shader program does not link: see the log");
}

/* NVIDIA's compilers run beside us only once they are told how many may, be it as many as before. In a browser there is nothing to tell. */
static void lflare__gl_wake_compilers(const lflare_gl *o, lflare_gl_loader load)
{
    lflare_gl_function named = load("glGetStringi"), told = load("glMaxShaderCompilerThreadsKHR");
    const unsigned char *(LFLARE__GLCALL *name_of)(lflare__glenum, lflare__gluint);
    void (LFLARE__GLCALL *tell)(lflare__gluint);
    lflare__glint count = 0, threads = 0, i;
    if (o->web || named == NULL || told == NULL) return; /* some loaders find whatever they are asked for: the extensions decide */
    memcpy(&name_of, &named, sizeof named);
    memcpy(&tell, &told, sizeof told);
    o->api.GetIntegerv(0x821D, &count); /* extensions */
    for (i = 0; i < count; i++) {
        const char *name = (const char *)name_of(0x1F03, (lflare__gluint)i);
        if (name == NULL || strcmp(name, "GL_KHR_parallel_shader_compile") != 0) continue;
        o->api.GetIntegerv(0x91B0, &threads);
        tell((lflare__gluint)threads);
    }
}

/* Of a model that is drawn, or of none. */
static int lflare__gl_wanted(const lflare_gl *o, int program)
{
    int traced = program >= LFLARE__GL_TRACED && program <= LFLARE__GL_TRACED_MASKED, meshes = program >= LFLARE__GL_PATCHES && program <= LFLARE__GL_PATCHES_MASKED;
    if (program > LFLARE__GL_FILL && !traced && !meshes) return 1;
    return (int)(o->models >> (traced ? LFLARE_MODEL_TRACED : meshes ? LFLARE_MODEL_POLYNOMIAL : LFLARE_MODEL_PARAXIAL) & 1);
}

static lflare_result lflare__gl_make_programs(lflare_gl *o, const lflare_gl_desc *desc, lflare_error *error)
{
    lflare__gluint shaders[LFLARE__GL_PROGRAMS][2];
    lflare_result result = LFLARE_OK;
    int program;
    o->models = desc->models != 0 ? desc->models : ~(uint32_t)0;
    lflare__gl_wake_compilers(o, desc->load);
    for (program = 0; program < LFLARE__GL_PROGRAMS; program++)
        if (lflare__gl_wanted(o, program)) lflare__gl_program_begin(o, program, shaders[program]);
    for (program = 0; program < LFLARE__GL_PROGRAMS; program++) {
        if (!lflare__gl_wanted(o, program)) continue;
        if (result == LFLARE_OK) result = lflare__gl_program_end(o, program, shaders[program], desc, error);
        o->api.DeleteShader(shaders[program][0]);
        o->api.DeleteShader(shaders[program][1]);
    }
    return result;
}

/* Unpack state as uploads from memory need it. */
static void lflare__gl_unpack(const lflare_gl *o)
{
    const lflare__glapi *gl = &o->api;
    gl->BindBuffer(0x88EC, 0);
    gl->PixelStorei(0x0CF5, 1);
    gl->PixelStorei(0x0CF2, 0);
    gl->PixelStorei(0x0CF3, 0);
    gl->PixelStorei(0x0CF4, 0);
    if (lflare__gl_has(o, LFLARE__GL_DESKTOP)) gl->PixelStorei(0x0CF0, 0);
    if (o->web) { /* act on uploads from memory too */
        gl->PixelStorei(0x9240, 0);
        gl->PixelStorei(0x9241, 0);
    }
}

/* Storage as GL names it. */
typedef struct lflare__gl_format {
    lflare__glint internal;
    lflare__glenum format, type;
    lflare__glint filter; /* nearest or linear */
} lflare__gl_format;

static const lflare__gl_format lflare__gl_rgba32f = {0x8814, 0x1908, 0x1406, 0x2600}, lflare__gl_r32ui = {0x8236, 0x8D94, 0x1405, 0x2600},
                               lflare__gl_rgba16f = {0x881A, 0x1908, 0x140B, 0x2601}, lflare__gl_rgb10_a2 = {0x8059, 0x1908, 0x8368, 0x2601},
                               lflare__gl_half_of_floats = {0x881A, 0x1908, 0x1406, 0x2601}, lflare__gl_r8 = {0x8229, 0x1903, 0x1401, 0x2601}, lflare__gl_r16f = {0x822D, 0x1903, 0x1406, 0x2601};

static void lflare__gl_texture(const lflare__glapi *gl, lflare__gluint texture, const lflare__gl_format *f, int32_t width, int32_t height, const void *texels)
{
    gl->ActiveTexture(0x84C0);
    gl->BindTexture(0x0DE1, texture);
    gl->TexImage2D(0x0DE1, 0, f->internal, width, height, 0, f->format, f->type, texels);
    gl->TexParameteri(0x0DE1, 0x2801, f->filter);
    gl->TexParameteri(0x0DE1, 0x2800, f->filter);
    gl->TexParameteri(0x0DE1, 0x2802, 0x812F); /* clamp to edge */
    gl->TexParameteri(0x0DE1, 0x2803, 0x812F);
}

/* Binds a framebuffer with a texture for its colour; 1 if it can be drawn to. */
static int lflare__gl_target(const lflare__glapi *gl, lflare__gluint framebuffer, lflare__gluint texture)
{
    gl->BindFramebuffer(0x8CA9, framebuffer);
    gl->FramebufferTexture2D(0x8CA9, 0x8CE0, 0x0DE1, texture, 0);
    return gl->CheckFramebufferStatus(0x8CA9) == 0x8CD5;
}

/* "3.3.0 ..." or "OpenGL ES 3.2 ..." or, in a browser, "OpenGL ES 3.0 (WebGL 2.0 ...". */
static lflare_result lflare__gl_version(lflare_gl *o, lflare_error *error)
{
    const char *version = (const char *)o->api.GetString(0x1F02), *at = version;
    int32_t number;
    if (version == NULL) return lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "glGetString gives no version: is a context current?");
    o->es = strncmp(version, "OpenGL ES", 9) == 0;
    o->web = o->es && strstr(version, "WebGL") != NULL;
    while (*at != 0 && (*at < '0' || *at > '9')) at++;
    number = at[0] != 0 && at[1] == '.' ? (at[0] - '0') * 10 + (at[2] - '0') : 0;
    if (number < (o->es ? 30 : 33)) return lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "GL 3.3 or ES 3.0 is needed; this is '%s'", version);
    return LFLARE_OK;
}

static lflare_result lflare__gl_load(lflare_gl *o, const lflare_gl_desc *desc, lflare_error *error)
{
    lflare_gl_function f = desc->load("glGetString");
    lflare_result result;
    if (f == NULL) return lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "the GL has no function glGetString");
    memcpy(&o->api.GetString, &f, sizeof f);
    result = lflare__gl_version(o, error);
    if (result != LFLARE_OK) return result;
#define LFLARE__GL_LOAD(who, result, name, arguments)                                                                    \
    f = desc->load("gl" #name);                                                                                              \
    if (f == NULL && lflare__gl_has(o, who)) return lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "the GL has no function gl%s", #name); \
    memcpy(&o->api.name, &f, sizeof f);
    LFLARE__GL_FUNCTIONS(LFLARE__GL_LOAD)
#undef LFLARE__GL_LOAD
    return LFLARE_OK;
}

/* Triangles of a patch: two a quad, row by row, so that a rim takes the first rows. The vertex array keeps them. */
static void lflare__gl_patch_indices(lflare_gl *o)
{
    static const uint16_t corners[6] = {0, LFLARE_PATCH_DIRECTIONS, 1, LFLARE_PATCH_DIRECTIONS, 1, LFLARE_PATCH_DIRECTIONS + 1};
    uint16_t indices[LFLARE__GL_PATCH];
    int32_t i;
    for (i = 0; i < LFLARE__GL_PATCH; i++)
        indices[i] = (uint16_t)(corners[i % 6] + i / LFLARE__GL_PATCH_ROW * LFLARE_PATCH_DIRECTIONS + i % LFLARE__GL_PATCH_ROW / 6);
    o->api.BindBuffer(0x8893, o->indices);
    o->api.BufferData(0x8893, (ptrdiff_t)sizeof indices, indices, 0x88E4);
}

/* Everything but the programs. */
static lflare_result lflare__gl_objects(lflare_gl *o, lflare_error *error)
{
    static const uint32_t nothing[LFLARE_GL_MAX_LIGHTS] = {0};
    const lflare__glapi *gl = &o->api;
    int k, whole = 1;
    o->enlarge = gl->GetUniformLocation(o->programs[LFLARE__GL_ADD], "u_enlarge");
    gl->GenTextures(LFLARE__GL_TEXTURES, o->textures);
    gl->GenFramebuffers(LFLARE__GL_FRAMEBUFFERS, o->framebuffers);
    gl->GenBuffers(1, &o->instances);
    gl->GenBuffers(1, &o->indices);
    gl->GenBuffers(1, &o->uniforms);
    gl->GenVertexArrays(1, &o->vertex_array);
    gl->GenSamplers(1, &o->sampler);
    gl->SamplerParameteri(o->sampler, 0x2801, 0x2600); /* nearest, no comparison: whatever the depth texture itself says */
    gl->SamplerParameteri(o->sampler, 0x2800, 0x2600);
    gl->SamplerParameteri(o->sampler, 0x884C, 0);
    lflare__gl_unpack(o);
    for (k = 0; k < 2 && whole; k++) {
        lflare__gl_texture(gl, o->textures[LFLARE__GL_STRIP_A + k], &lflare__gl_r32ui, LFLARE_GL_MAX_LIGHTS, 1, nothing);
        whole = lflare__gl_target(gl, o->framebuffers[LFLARE__GL_TO_STRIP_A + k], o->textures[LFLARE__GL_STRIP_A + k]);
    }
    lflare__gl_texture(gl, o->textures[LFLARE__GL_HALF], &lflare__gl_rgba16f, 1, 1, NULL);
    o->coarse = !lflare__gl_target(gl, o->framebuffers[LFLARE__GL_TO_HALF], o->textures[LFLARE__GL_HALF]);
    gl->GetIntegerv(0x0D33, &o->max_size);
    gl->BindVertexArray(o->vertex_array);
    gl->BindBuffer(0x8892, o->instances);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribIPointer(0, 4, 0x1403, sizeof(lflare_instance), NULL); /* unsigned short */
    gl->VertexAttribDivisor(0, 1);
    lflare__gl_patch_indices(o);
    return whole ? LFLARE_OK : lflare__fail(error, LFLARE_ERROR_GL, 0, 0, "the GL cannot draw to a texture of R32UI");
}

LFLARE_API lflare_result lflare_gl_create(const lflare_gl_desc *desc, lflare_gl **out, lflare_error *error)
{
    lflare_realloc allocate;
    lflare__glstate state;
    lflare_result result;
    lflare_gl *o;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (out != NULL) *out = NULL;
    if (desc == NULL || out == NULL || desc->load == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "give desc.load, your loader of GL functions");
    if (desc->log != NULL && desc->log_size > 0) desc->log[0] = 0;
    allocate = desc->allocate != NULL ? desc->allocate : lflare__libc_realloc;
    o = (lflare_gl *)allocate(desc->user, NULL, 0, sizeof *o);
    if (o == NULL) return lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
    memset(o, 0, sizeof *o);
    o->allocate = allocate;
    o->user = desc->user;
    o->no_restore = desc->no_restore;
    result = lflare__gl_load(o, desc, error);
    if (result != LFLARE_OK) {
        allocate(o->user, o, sizeof *o, 0);
        return result;
    }
    lflare__gl_save(o, &state); /* creating is rare: always restored */
    result = lflare__gl_make_programs(o, desc, error);
    if (result == LFLARE_OK) result = lflare__gl_objects(o, error);
    lflare__gl_restore(o, &state);
    if (result != LFLARE_OK) {
        lflare_gl_destroy(o);
        return result;
    }
    *out = o;
    return LFLARE_OK;
}

LFLARE_API void lflare_gl_forget(lflare_gl *o)
{
    if (o != NULL) o->forgotten = 1;
}

LFLARE_API void lflare_gl_destroy(lflare_gl *o)
{
    if (o == NULL) return;
    if (!o->forgotten) { /* names of 0 are ignored by GL */
        const lflare__glapi *gl = &o->api;
        int program;
        for (program = 0; program < LFLARE__GL_PROGRAMS; program++) gl->DeleteProgram(o->programs[program]);
        gl->DeleteTextures(LFLARE__GL_TEXTURES, o->textures);
        gl->DeleteFramebuffers(LFLARE__GL_FRAMEBUFFERS, o->framebuffers);
        gl->DeleteSamplers(1, &o->sampler);
        gl->DeleteBuffers(1, &o->instances);
        gl->DeleteBuffers(1, &o->indices);
        gl->DeleteBuffers(1, &o->uniforms);
        gl->DeleteVertexArrays(1, &o->vertex_array);
    }
    o->allocate(o->user, o, sizeof *o, 0);
}

/* Rows of `texels` RGBA texels a ghost, from two arrays, in a texture of LFLARE__GL_ROW texels a line. */
static lflare_result lflare__gl_upload_rows(lflare_gl *o, lflare__gluint texture, int32_t ghosts, int32_t texels, const float *first, size_t first_floats,
                                            const float *second, size_t second_floats)
{
    size_t lines = ((size_t)ghosts * (size_t)texels + LFLARE__GL_ROW - 1) / LFLARE__GL_ROW, bytes = lines * LFLARE__GL_ROW * 4 * sizeof(float), g;
    float *block, *at;
    if (lines == 0) return LFLARE_OK;
    block = at = (float *)o->allocate(o->user, NULL, 0, bytes);
    if (block == NULL) return LFLARE_ERROR_MEMORY;
    for (g = 0; g < (size_t)ghosts; g++) {
        memcpy(at, first + g * first_floats, first_floats * sizeof(float));
        memcpy(at + first_floats, second + g * second_floats, second_floats * sizeof(float));
        at += first_floats + second_floats;
    }
    memset(at, 0, bytes - (size_t)ghosts * (size_t)texels * 4 * sizeof(float));
    lflare__gl_texture(&o->api, texture, &lflare__gl_rgba32f, LFLARE__GL_ROW, (int32_t)lines, block);
    o->allocate(o->user, block, bytes, 0);
    return LFLARE_OK;
}

/* Rows of floats in a texture, made in a block of whole lines that `fill` writes. */
static lflare_result lflare__gl_upload_block(lflare_gl *o, lflare__gluint texture, size_t texels, const lflare_tables *t, void (*fill)(const lflare_tables *t, float *out))
{
    size_t lines = (texels + LFLARE__GL_ROW - 1) / LFLARE__GL_ROW, bytes = lines * LFLARE__GL_ROW * 4 * sizeof(float);
    float *block;
    if (lines > (size_t)o->max_size) return LFLARE_ERROR_LIMIT;
    block = (float *)o->allocate(o->user, NULL, 0, bytes);
    if (block == NULL) return LFLARE_ERROR_MEMORY;
    memset(block, 0, bytes);
    fill(t, block);
    lflare__gl_unpack(o);
    lflare__gl_texture(&o->api, texture, &lflare__gl_rgba32f, LFLARE__GL_ROW, (int32_t)lines, block);
    o->allocate(o->user, block, bytes, 0);
    return LFLARE_OK;
}

static size_t lflare__gl_head_texels(const lflare_tables *t) { return (size_t)t->ghost_count * ((LFLARE_MESH_HEAD_FLOATS + LFLARE_STYLE_FLOATS) / 4); }
static size_t lflare__gl_spectrum_texels(const lflare_tables *t) { return t->wavelength_count > 0 ? (size_t)t->ghost_count * LFLARE_OUTLINE_KNOTS * LFLARE_SPECTRUM_ROWS : 0; }

/* The meshes' heads with the ghosts' style; colours. */
static void lflare__gl_fill_heads(const lflare_tables *t, float *out)
{
    int32_t g;
    for (g = 0; g < t->ghost_count; g++, out += LFLARE_MESH_HEAD_FLOATS + LFLARE_STYLE_FLOATS) {
        memcpy(out, t->mesh_head + (size_t)g * LFLARE_MESH_HEAD_FLOATS, sizeof(float) * LFLARE_MESH_HEAD_FLOATS);
        memcpy(out + LFLARE_MESH_HEAD_FLOATS, t->style + (size_t)g * LFLARE_STYLE_FLOATS, sizeof(float) * LFLARE_STYLE_FLOATS);
    }
    if (t->wavelength_count > 0) memcpy(out, t->spectrum, sizeof(float) * 4 * lflare__gl_spectrum_texels(t));
}

/* The meshes as they stand in the tables, whose rows of LFLARE__MESH_ROW texels are whole; their heads. */
static lflare_result lflare__gl_upload_meshes(lflare_gl *o, const lflare_tables *t)
{
    lflare_result result;
    if (!(o->uploaded & 4) || o->mesh_hash != t->mesh_hash) {
        size_t lines = (t->mesh_texels + LFLARE__MESH_ROW - 1) / LFLARE__MESH_ROW;
        if (lines > (size_t)o->max_size) return LFLARE_ERROR_LIMIT;
        lflare__gl_unpack(o);
        lflare__gl_texture(&o->api, o->textures[LFLARE__GL_MESH], &lflare__gl_rgba32f, LFLARE__MESH_ROW, (int32_t)lines, t->mesh);
        o->mesh_hash = t->mesh_hash;
        o->uploaded |= 4;
    }
    if (!(o->uploaded & 8) || o->heads_hash != t->settings_hash + t->mesh_hash) {
        o->uploaded &= ~8;
        result = lflare__gl_upload_block(o, o->textures[LFLARE__GL_MESH_HEADS], lflare__gl_head_texels(t) + lflare__gl_spectrum_texels(t), t, lflare__gl_fill_heads);
        if (result != LFLARE_OK) return result;
        o->heads_hash = t->settings_hash + t->mesh_hash;
        o->uploaded |= 8;
    }
    return LFLARE_OK;
}

#ifndef LFLARE_NO_TRACE
enum { LFLARE__TRACED_SURFACE = LFLARE_SURFACE_FLOATS + 4 * LFLARE_FILM_SAMPLES, LFLARE__TRACED_GHOST = 4 + LFLARE_STYLE_FLOATS + LFLARE_OUTLINE_FLOATS };

static void lflare__gl_fill_lens(const lflare_tables *t, float *out)
{
    int32_t i;
    for (i = 0; i < t->surface_count; i++, out += LFLARE__TRACED_SURFACE) {
        memcpy(out, t->surface + i * LFLARE_SURFACE_FLOATS, sizeof(float) * LFLARE_SURFACE_FLOATS);
        memcpy(out + LFLARE_SURFACE_FLOATS, t->film + (size_t)i * LFLARE_FILM_SAMPLES * 4, sizeof(float) * 4 * LFLARE_FILM_SAMPLES);
    }
}

/* A ghost's steps, its style, its outlines; then the steps of all; colours. */
static void lflare__gl_fill_ghosts(const lflare_tables *t, float *out)
{
    lflare__tracer tracer;
    int32_t g, steps = 0;
    for (g = 0; g < t->ghost_count; g++, out += LFLARE__TRACED_GHOST) {
        lflare__tracer_make(t, g, &tracer);
        out[0] = (float)(t->ghost_count * (LFLARE__TRACED_GHOST / 4) + steps * (LFLARE_STEP_FLOATS / 4));
        out[1] = (float)tracer.count;
        out[2] = tracer.sensor;
        steps += tracer.count;
        memcpy(out + 4, t->style + (size_t)g * LFLARE_STYLE_FLOATS, sizeof(float) * LFLARE_STYLE_FLOATS);
        memcpy(out + 4 + LFLARE_STYLE_FLOATS, t->outline + (size_t)g * LFLARE_OUTLINE_FLOATS, sizeof(float) * LFLARE_OUTLINE_FLOATS);
    }
    memcpy(out, t->steps, sizeof(float) * LFLARE_STEP_FLOATS * (size_t)steps);
    if (t->wavelength_count > 0) memcpy(out + (size_t)steps * LFLARE_STEP_FLOATS, t->spectrum, sizeof(float) * 4 * lflare__gl_spectrum_texels(t));
}

static size_t lflare__gl_ghost_texels(const lflare_tables *t)
{
    return (size_t)t->ghost_count * (LFLARE__TRACED_GHOST / 4) + (size_t)lflare__steps_of(t) * (LFLARE_STEP_FLOATS / 4);
}

/* What the shader traces with; the ghosts' outlines with their style and steps. */
static lflare_result lflare__gl_upload_traced(lflare_gl *o, const lflare_tables *t)
{
    uint64_t hash = t->settings_hash ^ t->mesh_hash;
    lflare_result result;
    if (!(o->uploaded & 32) || o->traced_lens_hash != t->lens_hash) {
        o->uploaded &= ~32;
        result = lflare__gl_upload_block(o, o->textures[LFLARE__GL_TRACED_LENS], (size_t)t->surface_count * LFLARE__TRACED_SURFACE / 4, t, lflare__gl_fill_lens);
        if (result != LFLARE_OK) return result;
        o->traced_lens_hash = t->lens_hash;
        o->uploaded |= 32;
    }
    if (!(o->uploaded & 64) || o->traced_hash != hash) {
        o->uploaded &= ~64;
        result = lflare__gl_upload_block(o, o->textures[LFLARE__GL_TRACED_GHOSTS], lflare__gl_ghost_texels(t) + lflare__gl_spectrum_texels(t), t, lflare__gl_fill_ghosts);
        if (result != LFLARE_OK) return result;
        o->traced_hash = hash;
        o->uploaded |= 64;
    }
    return LFLARE_OK;
}
#endif

static void lflare__gl_upload_starburst(lflare_gl *o, const lflare_starburst *s)
{
    if (s == NULL || s->key + (uint64_t)s->size == o->burst_key) return;
    lflare__gl_unpack(o);
    lflare__gl_texture(&o->api, o->textures[LFLARE__GL_ANGULAR], &lflare__gl_half_of_floats, LFLARE_STARBURST_COLUMNS, LFLARE_STARBURST_ROWS, s->angular);
    lflare__gl_texture(&o->api, o->textures[LFLARE__GL_RADIAL], &lflare__gl_half_of_floats, LFLARE_STARBURST_SAMPLES, LFLARE_STARBURST_SIZES, s->radial);
    o->burst_key = s->key + (uint64_t)s->size;
}

/* A square picture and its halves, one behind the other. */
static void lflare__gl_upload_levels(lflare_gl *o, lflare__gluint texture, const uint8_t *texels, int32_t size, int32_t levels)
{
    const lflare__glapi *gl = &o->api;
    int32_t level;
    lflare__gl_unpack(o);
    for (level = 0; level < levels; level++, size /= 2) {
        if (level == 0) lflare__gl_texture(gl, texture, &lflare__gl_r8, size, size, texels);
        else gl->TexImage2D(0x0DE1, level, lflare__gl_r8.internal, size, size, 0, lflare__gl_r8.format, lflare__gl_r8.type, texels);
        texels += (size_t)size * (size_t)size;
    }
    gl->TexParameteri(0x0DE1, 0x2801, 0x2703); /* linear between levels too */
    gl->TexParameteri(0x0DE1, 0x813D, levels - 1); /* the last */
}

static void lflare__gl_upload_mask(lflare_gl *o, const lflare_tables *t)
{
    if (t->mask_hash == 0) return;
    if (t->mask_hash != o->mask_hash) lflare__gl_upload_levels(o, o->textures[LFLARE__GL_MASK], t->iris.mask, LFLARE_MASK_SIZE, LFLARE_MASK_LEVELS);
    o->mask_hash = t->mask_hash;
    if (t->iris.fringed == NULL || t->mask_hash == o->fringed_hash) return;
    lflare__gl_upload_levels(o, o->textures[LFLARE__GL_FRINGED], t->iris.fringed, LFLARE_FRINGED_WIDTH, LFLARE_FRINGED_LEVELS);
    o->fringed_hash = t->mask_hash;
}

/* Whatever changed since the last draw. */
static lflare_result lflare__gl_upload(lflare_gl *o, const lflare_tables *t)
{
    lflare_result result;
    int lens = !(o->uploaded & 1) || o->lens_hash != t->lens_hash, settings = !(o->uploaded & 2) || o->settings_hash != t->settings_hash;
    lflare__gl_upload_starburst(o, t->starburst);
    lflare__gl_upload_mask(o, t);
    if (t->fringes && !(o->uploaded & 16)) { /* the same whatever the lens */
        lflare__gl_unpack(o);
        lflare__gl_texture(&o->api, o->textures[LFLARE__GL_RINGING], &lflare__gl_r16f, LFLARE_RINGING_SAMPLES, LFLARE_RINGING_BLURS, t->ringing);
        o->uploaded |= 16;
    }
    if (t->model == LFLARE_MODEL_POLYNOMIAL) return lflare__gl_upload_meshes(o, t);
#ifndef LFLARE_NO_TRACE
    if (t->model == LFLARE_MODEL_TRACED) return lflare__gl_upload_traced(o, t);
#endif
    if (!lens && !settings) return LFLARE_OK;
    lflare__gl_unpack(o);
    if (lens) {
        o->uploaded &= ~1;
        result = lflare__gl_upload_rows(o, o->textures[LFLARE__GL_LENS], t->ghost_count, LFLARE__GL_LENS_TEXELS, t->head, LFLARE_HEAD_FLOATS, t->rims,
                                        LFLARE_MAX_RIMS * LFLARE_RIM_FLOATS);
        if (result != LFLARE_OK) return result;
        o->lens_hash = t->lens_hash;
        o->uploaded |= 1;
    }
    if (settings) {
        o->uploaded &= ~2;
        result = lflare__gl_upload_rows(o, o->textures[LFLARE__GL_SETTINGS], t->ghost_count, LFLARE__GL_SETTINGS_TEXELS, t->field,
                                        LFLARE_FIELD_SAMPLES * LFLARE_FIELD_FLOATS, t->style, LFLARE_STYLE_FLOATS);
        if (result != LFLARE_OK) return result;
        o->settings_hash = t->settings_hash;
        o->uploaded |= 2;
    }
    return LFLARE_OK;
}

/* Where in the ghosts' texture colours are. */
static size_t lflare__gl_spectrum_at(const lflare_tables *t)
{
#ifndef LFLARE_NO_TRACE
    if (t->model == LFLARE_MODEL_TRACED) return lflare__gl_ghost_texels(t);
#endif
    return lflare__gl_head_texels(t);
}

/* The uniform block of a frame; returns its bytes in use. */
static size_t lflare__gl_fill_frame(lflare_gl *o, const lflare_tables *t, const lflare_frame_data *f)
{
    lflare__gl_frame *u = &o->block.frame;
    int32_t k, i;
    memset(u, 0, offsetof(lflare__gl_frame, lights));
    u->half[0] = f->half_width;
    u->half[1] = f->half_height;
    u->half[2] = f->centre[0];
    u->half[3] = f->centre[1];
    u->lens[0] = f->pixel;
    u->lens[1] = t->efl;
    u->lens[2] = t->entrance_radius;
    u->lens[3] = t->iris.radius;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) u->spectrum[k] = t->wavelengths[k] * 1e-6f;
    u->spectrum[3] = (float)t->iris.blade_count;
    u->strip[0] = (float)o->strip_lights;
    u->strip[1] = 1;
    u->strip[2] = t->iris.mask == NULL ? 0.0f : 1.0f + (t->iris.fringed != NULL) + (t->iris.dark_outline ? 2.0f : 0.0f);
    u->strip[3] = t->iris.softness;
    for (k = 0; k < LFLARE_WAVELENGTHS; k++) {
        u->burst[0][k] = t->starburst_gain[k];
        u->burst[1][k] = t->starburst != NULL ? t->starburst->tail[k] : 0;
        u->burst[2][k] = t->streak_gain[k];
    }
    u->burst[0][3] = t->starburst_unit;
    u->burst[2][3] = t->fringes ? LFLARE__RING_LEAST * t->mean_irradiance : -1;
    u->burst[1][3] = t->streak_half[1];
    memcpy(u->blades, t->iris.blades, sizeof u->blades);
    for (i = 0; i < LFLARE_MAX_WAVELENGTHS + 1 && t->wavelength_count > 0; i++) {
        memcpy(u->spectral[i], t->spectral[i], sizeof u->spectral[i]);
        u->spectral[i][3] *= 1e-6f;
    }
    u->bands[0] = (float)t->wavelength_count;
    u->bands[1] = (float)lflare__gl_spectrum_at(t);
    memcpy(u->lights, f->lights, sizeof(lflare_frame_light) * (size_t)f->light_count);
    for (k = 0; k < f->light_count; k++) { /* an integer's bits may not survive as a float */
        float source = (float)f->lights[k].source;
        memcpy(&u->lights[k].source, &source, sizeof source);
    }
    return offsetof(lflare__gl_frame, lights) + sizeof(lflare_frame_light) * (size_t)f->light_count;
}

/* The first `bytes` of the block, to the shaders: a fresh buffer, never waits for the last frame's. */
static void lflare__gl_send_block(const lflare_gl *o, size_t bytes)
{
    const lflare__glapi *gl = &o->api;
    gl->BindBufferBase(0x8A11, 0, o->uniforms);
    gl->BufferData(0x8A11, (ptrdiff_t)sizeof o->block, NULL, 0x88E0);
    gl->BufferSubData(0x8A11, 0, (ptrdiff_t)bytes, &o->block);
}

static void lflare__gl_bind_texture(const lflare__glapi *gl, lflare__gluint unit, lflare__gluint texture, lflare__gluint sampler)
{
    gl->ActiveTexture(0x84C0 + unit);
    gl->BindTexture(0x0DE1, texture);
    gl->BindSampler(unit, sampler);
}

/* What every pass needs. */
static void lflare__gl_set_state(const lflare_gl *o)
{
    const lflare__glapi *gl = &o->api;
#define LFLARE__GL_SET(name, who, need, text) \
    if (lflare__gl_has(o, who)) {                   \
        if ((need) == 1) gl->Enable(name);        \
        else if ((need) == 0) gl->Disable(name);  \
    }
    LFLARE__GL_CAPABILITIES(LFLARE__GL_SET)
#undef LFLARE__GL_SET
    if (lflare__gl_has(o, LFLARE__GL_DESKTOP)) gl->PolygonMode(0x0408, 0x1B02);
    gl->ColorMask(1, 1, 1, 0); /* light is added, alpha stays */
    gl->BlendFuncSeparate(1, 1, 0, 1);
    gl->BlendEquationSeparate(0x8006, 0x8006);
    gl->BindVertexArray(o->vertex_array);
}

/* A pass into a texture of our own: all of it. */
static void lflare__gl_own_viewport(const lflare__glapi *gl, int32_t width, int32_t height)
{
    gl->Viewport(0, 0, width, height);
    gl->Disable(0x0C11); /* scissor test */
}

static int lflare__gl_has_images(const lflare_frame_data *f)
{
    int32_t i;
    for (i = 0; i < f->light_count; i++)
        if (f->lights[i].starburst > 0 || f->lights[i].streak > 0) return 1;
    return 0;
}

/* Starbursts and streaks of all lights, if there are any. */
static void lflare__gl_images(lflare_gl *o, const lflare_frame_data *f)
{
    const lflare__glapi *gl = &o->api;
    if (!lflare__gl_has_images(f)) return;
    lflare__gl_bind_texture(gl, 0, o->textures[LFLARE__GL_ANGULAR], 0);
    lflare__gl_bind_texture(gl, 1, o->textures[LFLARE__GL_RADIAL], 0);
    gl->UseProgram(o->programs[LFLARE__GL_STARBURST]);
    gl->DrawArraysInstanced(0x0005, 0, 4, 2 * f->light_count);
}

/* The block is filled, the target bound: all draws. */
static void lflare__gl_flare(lflare_gl *o, const lflare_tables *t, const lflare_frame_data *f, size_t bytes)
{
    const lflare__glapi *gl = &o->api;
    int traced = t->model == LFLARE_MODEL_TRACED, meshes = t->model != LFLARE_MODEL_PARAXIAL;
    int first = traced ? LFLARE__GL_TRACED : LFLARE__GL_PATCHES; /* of four: inside, rims, rims with fringes, inside of a masked iris */
    lflare__gl_send_block(o, bytes);
    lflare__gl_bind_texture(gl, 2, o->textures[LFLARE__GL_STRIP_A + o->strip_now], 0);
    lflare__gl_images(o, f);
    if (f->instance_count == 0) return;
    lflare__gl_bind_texture(gl, 0, o->textures[traced ? LFLARE__GL_TRACED_LENS : meshes ? LFLARE__GL_MESH : LFLARE__GL_LENS], 0);
    lflare__gl_bind_texture(gl, 1, o->textures[traced ? LFLARE__GL_TRACED_GHOSTS : meshes ? LFLARE__GL_MESH_HEADS : LFLARE__GL_SETTINGS], 0);
    gl->BindBuffer(0x8892, o->instances);
    gl->BufferData(0x8892, (ptrdiff_t)sizeof(lflare_instance) * f->instance_count, f->instances, 0x88E0);
    lflare__gl_bind_texture(gl, 3, o->textures[LFLARE__GL_MASK], 0);
    lflare__gl_bind_texture(gl, 4, o->textures[LFLARE__GL_RINGING], 0);
    lflare__gl_bind_texture(gl, 5, o->textures[LFLARE__GL_FRINGED], 0);
    gl->UseProgram(o->programs[!meshes ? LFLARE__GL_FILL : t->iris.mask != NULL ? first + 3 : first]);
    if (meshes) gl->DrawElementsInstanced(0x0004, LFLARE__GL_PATCH, 0x1403, NULL, f->instance_count);
    else gl->DrawArraysInstanced(0x0006, 0, LFLARE__GL_INSIDE, f->instance_count); /* fans */
    gl->UseProgram(o->programs[(meshes ? first + 1 : LFLARE__GL_RIM) + (t->fringes || t->iris.mask != NULL)]); /* with FRINGES */
    if (meshes) gl->DrawElementsInstanced(0x0004, LFLARE__GL_PATCH_ROW * (LFLARE_PATCH_BANDS - 1), 0x1403, NULL, f->instance_count);
    else gl->DrawArraysInstanced(0x0005, 0, LFLARE__GL_RING, f->instance_count);   /* strips */
}

static lflare_result lflare__gl_valid(const lflare_gl *o, const lflare_tables *t, const lflare_frame_data *f)
{
    if (o == NULL || t == NULL || f == NULL || o->forgotten || f->width < 1 || f->height < 1 || f->light_count < 0 || f->instance_count < 0 ||
        !(o->models >> (t->model & 31) & 1))
        return LFLARE_ERROR_ARGUMENT;
    return f->light_count > LFLARE_GL_MAX_LIGHTS ? LFLARE_ERROR_LIMIT : LFLARE_OK;
}

LFLARE_API lflare_result lflare_gl_draw(lflare_gl *o, const lflare_tables *t, const lflare_frame_data *f)
{
    lflare__glstate state;
    lflare_result result;
    lflare_result valid = lflare__gl_valid(o, t, f);
    if (valid != LFLARE_OK || (f->instance_count == 0 && !lflare__gl_has_images(f))) return valid;
    if (!o->no_restore) lflare__gl_save(o, &state);
    result = lflare__gl_upload(o, t);
    if (result == LFLARE_OK) {
        lflare__gl_set_state(o);
        lflare__gl_flare(o, t, f, lflare__gl_fill_frame(o, t, f));
    }
    if (!o->no_restore) lflare__gl_restore(o, &state);
    return result;
}

/* The picture that draw_half draws into, bound; made anew when its size changes. */
static lflare_result lflare__gl_half_target(lflare_gl *o, int32_t width, int32_t height)
{
    const lflare__glapi *gl = &o->api;
    lflare__gluint texture = o->textures[LFLARE__GL_HALF], framebuffer = o->framebuffers[LFLARE__GL_TO_HALF];
    int32_t w = (width + 1) / 2, h = (height + 1) / 2;
    if (width == o->full_width && height == o->full_height) {
        gl->BindFramebuffer(0x8CA9, framebuffer);
        return LFLARE_OK;
    }
    o->full_width = 0;
    if (w > o->max_size || h > o->max_size) return LFLARE_ERROR_LIMIT;
    lflare__gl_unpack(o);
    lflare__gl_texture(gl, texture, o->coarse ? &lflare__gl_rgb10_a2 : &lflare__gl_rgba16f, w, h, NULL);
    if (!lflare__gl_target(gl, framebuffer, texture)) return LFLARE_ERROR_GL;
    o->full_width = width;
    o->full_height = height;
    return LFLARE_OK;
}

/* Half floats end at 65504 and 6e-8: a power of two brings the flare of the strongest light that draws something to 32 times
   where normalised exposure has it (pictures of all shipped lenses then stay below 16,000). */
static float lflare__gl_half_gain(const lflare_tables *t, const lflare_frame_data *f)
{
    float strongest = 0;
    int32_t i, light = -1;
    for (i = 0; i < f->instance_count; i++) {
        const lflare_frame_light *l = &f->lights[f->instances[i].light];
        if (f->instances[i].light == light) continue;
        light = f->instances[i].light;
        strongest = lflare__maxf(strongest, lflare__maxf(l->irradiance[0], lflare__maxf(l->irradiance[1], l->irradiance[2])));
    }
    strongest *= t->mean_irradiance / LFLARE_NORMAL_MEAN;
    return strongest > 1e-30f && strongest < 1e30f ? ldexpf(1, 5 - ilogbf(strongest)) : 1;
}

/* The same frame, seen by a target of half its pixels, rounded up: an odd pixel at the right and top falls outside the frame. */
static void lflare__gl_halve(lflare_gl *o, const lflare_tables *t, const lflare_frame_data *f)
{
    lflare__gl_frame *u = &o->block.frame;
    const int32_t size[2] = {f->width, f->height};
    int k;
    for (k = 0; k < 2; k++) {
        float share = (float)size[k] / (float)(size[k] + (size[k] & 1)), half = u->half[k] / share;
        u->half[2 + k] += (share - 1) * half;
        u->half[k] = half;
    }
    u->lens[0] *= 2;
    o->half_gain = u->strip[1] = o->coarse ? 1 : lflare__gl_half_gain(t, f);
}

LFLARE_API lflare_result lflare_gl_draw_half(lflare_gl *o, const lflare_tables *t, const lflare_frame_data *f)
{
    static const float black[4] = {0, 0, 0, 0};
    lflare__glstate state;
    lflare_result result = lflare__gl_valid(o, t, f);
    if (result != LFLARE_OK) return result;
    o->half_empty = f->instance_count == 0 && !lflare__gl_has_images(f);
    if (o->half_empty) return LFLARE_OK;
    if (!o->no_restore) lflare__gl_save(o, &state);
    result = lflare__gl_upload(o, t);
    if (result == LFLARE_OK) result = lflare__gl_half_target(o, f->width, f->height);
    if (result == LFLARE_OK) {
        size_t bytes = lflare__gl_fill_frame(o, t, f);
        lflare__gl_halve(o, t, f);
        lflare__gl_set_state(o);
        lflare__gl_own_viewport(&o->api, (f->width + 1) / 2, (f->height + 1) / 2);
        o->api.ClearBufferfv(0x1800, 0, black); /* colour */
        lflare__gl_flare(o, t, f, bytes);
    }
    if (!o->no_restore) lflare__gl_restore(o, &state);
    return result;
}

LFLARE_API lflare_result lflare_gl_add_half(lflare_gl *o)
{
    const lflare__glapi *gl;
    lflare__glstate state;
    if (o == NULL || o->forgotten || (o->full_width == 0 && !o->half_empty)) return LFLARE_ERROR_ARGUMENT;
    if (o->half_empty) return LFLARE_OK;
    gl = &o->api;
    if (!o->no_restore) lflare__gl_save(o, &state);
    lflare__gl_set_state(o);
    lflare__gl_bind_texture(gl, 0, o->textures[LFLARE__GL_HALF], 0);
    gl->UseProgram(o->programs[LFLARE__GL_ADD]);
    gl->Uniform3f(o->enlarge, (float)o->full_width / (float)((o->full_width + 1) / 2 * 2), (float)o->full_height / (float)((o->full_height + 1) / 2 * 2),
                  1 / o->half_gain);
    gl->DrawArraysInstanced(0x0004, 0, 3, 1);
    if (!o->no_restore) lflare__gl_restore(o, &state);
    return LFLARE_OK;
}

/* Window depth of what is `distance` away, 0 = infinitely far. */
static float lflare__gl_depth_of(const lflare_gl_depth *d, float distance)
{
    const float *p = d->projection;
    float ndc = distance > 0 ? (p[14] - p[10] * distance) / (p[15] - p[11] * distance) : p[10] / p[11], to = d->depth_range[1];
    if (d->depth_range[0] == 0 && to == 0) to = 1;
    ndc = lflare__minf(lflare__maxf(ndc, d->zero_to_one ? 0 : -1), 1);
    return d->depth_range[0] + (to - d->depth_range[0]) * (d->zero_to_one ? ndc : 0.5f * ndc + 0.5f);
}

static int lflare__valid_depth(const lflare_gl_depth *d)
{
    float sum = d->depth_range[0] + d->depth_range[1] + d->sky_distance + d->bias + d->dt + d->attack + d->release;
    int k;
    for (k = 0; k < 16; k++) sum += d->projection[k];
    return lflare__finite((double)sum) && d->projection[11] < 0 && d->projection[14] != 0 && d->region[0] >= 0 && d->region[1] >= 0 &&
           (d->region[2] > 0 ? d->region[3] > 0 : d->region[2] == 0 && d->region[3] == 0) && d->texture != 0 && d->sky_distance >= 0 &&
           d->samples >= 0 && d->samples <= 1024;
}

/* The occlusion pass's uniform block; returns its bytes in use. */
static size_t lflare__gl_fill_strip(lflare_gl *o, const lflare_light *lights, int32_t count, const lflare_gl_depth *d)
{
    lflare__gl_strip *u = &o->block.strip;
    float direction = d->depth_range[1] < d->depth_range[0] ? -1.0f : 1.0f, scale = -1 / d->projection[11];
    int32_t i, k;
    memset(u, 0, offsetof(lflare__gl_strip, disc));
    for (k = 0; k < 3; k++) {
        u->clip[0][k] = scale * d->projection[4 * k];
        u->clip[1][k] = scale * d->projection[4 * k + 1];
        u->clip[2][k] = scale * d->projection[4 * k + 3];
    }
    u->clip[0][3] = d->reset ? 0 : (float)o->strip_lights;
    for (k = 0; k < 4; k++) u->region[k] = (float)d->region[k];
    u->fade[0] = lflare_fade(0, 1, d->dt, d->attack, 0);
    u->fade[1] = 1 - lflare_fade(1, 0, d->dt, 0, d->release);
    u->fade[2] = d->projection[14] < 0 ? direction : -direction; /* reverse-Z: depth falls with distance */
    u->fade[3] = (float)(d->samples > 0 ? (d->samples + 3) / 4 * 4 : 256);
    for (i = 0; i < count; i++) {
        const lflare_light *l = &lights[i];
        float x = -l->direction[0] / l->direction[2], y = -l->direction[1] / l->direction[2];
        int in_front = l->direction[2] < 0 && x * x + y * y < 3600;
        float distance = l->distance > 0 ? lflare__maxf(l->distance / sqrtf(1 + x * x + y * y) - d->bias, 1e-6f * l->distance) : d->sky_distance;
        u->disc[i][0] = in_front ? x : 0;
        u->disc[i][1] = in_front ? y : 0;
        u->disc[i][2] = in_front ? tanf(l->angular_radius) : -1;
        u->disc[i][3] = in_front ? lflare__gl_depth_of(d, distance) : 0;
    }
    return offsetof(lflare__gl_strip, disc) + sizeof u->disc[0] * (size_t)count;
}

LFLARE_API lflare_result lflare_gl_occlusion(lflare_gl *o, const lflare_light *lights, int32_t count, const lflare_gl_depth *d)
{
    const lflare__glapi *gl;
    lflare__glstate state;
    int32_t i;
    if (o == NULL || o->forgotten || count < 0 || (count > 0 && lights == NULL)) return LFLARE_ERROR_ARGUMENT;
    if (d == NULL) {
        o->strip_lights = 0;
        return LFLARE_OK;
    }
    if (!lflare__valid_depth(d)) return LFLARE_ERROR_ARGUMENT;
    for (i = 0; i < count; i++)
        if (!lflare__valid_light(&lights[i])) return LFLARE_ERROR_ARGUMENT;
    if (count > LFLARE_GL_MAX_LIGHTS) return LFLARE_ERROR_LIMIT;
    gl = &o->api;
    if (!o->no_restore) lflare__gl_save(o, &state);
    lflare__gl_send_block(o, lflare__gl_fill_strip(o, lights, count, d));
    lflare__gl_set_state(o);
    lflare__gl_bind_texture(gl, 0, d->texture, o->sampler);
    lflare__gl_bind_texture(gl, 1, o->textures[LFLARE__GL_STRIP_A + o->strip_now], 0);
    o->strip_now = !o->strip_now;
    gl->BindFramebuffer(0x8CA9, o->framebuffers[LFLARE__GL_TO_STRIP_A + o->strip_now]);
    lflare__gl_own_viewport(gl, count, 1);
    gl->Disable(0x0BE2); /* integers do not blend */
    gl->UseProgram(o->programs[LFLARE__GL_STRIP]);
    gl->DrawArraysInstanced(0x0004, 0, 3, 1);
    o->strip_lights = count;
    if (!o->no_restore) lflare__gl_restore(o, &state);
    return LFLARE_OK;
}

#endif /* LFLARE_NO_GL */

/* >> 16 object */

struct lflare {
    lflare_realloc allocate;
    void *user;
    void *lens_memory, *settings_memory[2], *frame_memory;
    float *demand[2];          /* what some settings need besides, once they are asked for */
    size_t demand_floats[2];
    lflare_tables_size size;
    size_t frame_bytes;
    lflare_tables tables[2];   /* sharing the lens part; `current` is shown, the other built */
    int32_t current, next_ghost, configuring;
    lflare_settings settings;  /* being built; overrides are our copy */
    lflare_override *overrides;
    size_t override_bytes;
    lflare_frame_data frame;
    lflare_footprint *footprints;
    int32_t footprint_capacity, footprint_count;
#ifndef LFLARE_NO_DIFFRACTION
    uint8_t *masks[2];         /* of the tables' irises */
    int32_t next_row, bursting;/* of the mask being built; a starburst is being made */
    lflare_starburst bursts[2];/* what the shown tables use, and the other: remade, or found again, for the next */
    float *burst_tables[2];
    lflare_starburst_job job;
    uint8_t *fringed[2];       /* likewise */
    uint64_t fringed_keys[2];  /* hashes of masks; 0 = not made */
    int32_t fringing, fringed_last; /* 1 + place of what is being made, 0 = none; that of the last */
    lflare_fringed_job fringed_job;
    void *work;
    size_t work_bytes;
#endif
    lflare_lens lens;
};

static void *lflare__allocate(lflare *o, size_t size) { return o->allocate(o->user, NULL, 0, size > 0 ? size : 1); }

static void lflare__release(lflare *o, void *block, size_t size)
{
    if (block != NULL) o->allocate(o->user, block, size > 0 ? size : 1, 0);
}

LFLARE_API int32_t lflare_version(void) { return LFLARE_VERSION; }

LFLARE_API void lflare_destroy(lflare *o)
{
#if defined(LFLARE__PATCHES) || !defined(LFLARE_NO_DIFFRACTION)
    int32_t i;
#endif
    if (o == NULL) return;
    lflare__release(o, o->lens_memory, o->size.lens);
    lflare__release(o, o->settings_memory[0], o->size.settings);
    lflare__release(o, o->settings_memory[1], o->size.settings);
    lflare__release(o, o->frame_memory, o->frame_bytes);
#ifdef LFLARE__PATCHES
    for (i = 0; i < 2; i++) lflare__release(o, o->demand[i], sizeof(float) * o->demand_floats[i]);
#endif
    lflare__release(o, o->overrides, o->override_bytes);
    lflare__release(o, o->footprints, sizeof(lflare_footprint) * (size_t)o->footprint_capacity);
#ifndef LFLARE_NO_DIFFRACTION
    for (i = 0; i < 2; i++) {
        lflare__release(o, o->masks[i], LFLARE_MASK_BYTES);
        lflare__release(o, o->fringed[i], LFLARE_FRINGED_BYTES);
        lflare__release(o, o->burst_tables[i], sizeof(float) * LFLARE_STARBURST_FLOATS);
    }
    lflare__release(o, o->work, o->work_bytes);
#endif
    o->allocate(o->user, o, sizeof *o, 0);
}

/* Of one light: ghosts, or the patches of their meshes. */
static int32_t lflare__most_instances(const lflare_lens *lens, const uint8_t *fit)
{
    int32_t count = lens->ghost_count;
#ifndef LFLARE_NO_ABERRATION
    int32_t g;
    for (g = 0; fit != NULL && g < lens->ghost_count; g++) {
        lflare__fit_ghost ghost;
        lflare__fit_ghost_read(fit, g, &ghost);
        if (ghost.knots != NULL) count += lflare__mesh_patches(&ghost);
    }
#endif
    (void)fit;
    return count;
}

/* Everything behind the object itself; what was allocated so far is released by lflare_destroy. */
static lflare_result lflare__create_tables(lflare *o, const void *fit, int32_t max_lights, lflare_error *error)
{
    size_t lights = (size_t)max_lights, instances = (size_t)lflare__most_instances(&o->lens, (const uint8_t *)fit);
    int32_t i;
    if (o->lens.ghost_count > 65535) return lflare__fail(error, LFLARE_ERROR_LIMIT, 0, 0, "%i ghosts; at most 65535", o->lens.ghost_count);
    o->size = lflare_tables_layout(&o->lens, fit, NULL, NULL, &o->tables[0]);
    if (o->tables[0].mesh_texels > (size_t)1 << 24) /* places in the table are floats */
        return lflare__fail(error, LFLARE_ERROR_LIMIT, 0, 0, "meshes of %g texels; at most 16777216: use the lens without its fit", (double)o->tables[0].mesh_texels);
    if (instances > 0 && lights > (size_t)INT32_MAX / instances)
        return lflare__fail(error, LFLARE_ERROR_LIMIT, 0, 0, "%i lights of a lens with %g ghosts or patches; give a smaller max_lights", max_lights, (double)instances);
    o->frame_bytes = lights * (sizeof(lflare_frame_light) + instances * sizeof(lflare_instance));
    o->lens_memory = lflare__allocate(o, o->size.lens);
    for (i = 0; i < 2; i++) o->settings_memory[i] = lflare__allocate(o, o->size.settings);
    o->frame_memory = lflare__allocate(o, o->frame_bytes);
    if (o->lens_memory == NULL || o->settings_memory[0] == NULL || o->settings_memory[1] == NULL || o->frame_memory == NULL)
        return lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
    for (i = 0; i < 2; i++) lflare_tables_layout(&o->lens, fit, o->lens_memory, o->settings_memory[i], &o->tables[i]);
    o->frame.lights = (lflare_frame_light *)o->frame_memory;
    o->frame.light_capacity = max_lights;
    o->frame.instances = (lflare_instance *)(void *)((char *)o->frame_memory + lights * sizeof(lflare_frame_light));
    o->frame.instance_capacity = (int32_t)(lights * instances);
    return lflare_tables_prepare(&o->lens, &o->tables[0], 0, o->lens.ghost_count);
}

LFLARE_API lflare_result lflare_create(const lflare_desc *desc, lflare **out, lflare_error *error)
{
    lflare_realloc allocate;
    lflare *o;
    lflare_result result = LFLARE_OK;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (out != NULL) *out = NULL;
    if (desc == NULL || out == NULL || (desc->text == NULL && desc->prescription == NULL))
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "give a prescription: desc.text with desc.text_size, or desc.prescription");
    if (desc->max_lights < 0 || desc->max_lights > 65535) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "max_lights is 0 to 65535");
    allocate = desc->allocate != NULL ? desc->allocate : lflare__libc_realloc;
    o = (lflare *)allocate(desc->user, NULL, 0, sizeof *o);
    if (o == NULL) return lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
    memset(o, 0, sizeof *o);
    o->allocate = allocate;
    o->user = desc->user;
    if (desc->prescription != NULL) {
        result = lflare_lens_derive(desc->prescription, &o->lens, error);
    } else {
        lflare_prescription read;
        result = lflare_text_read(desc->text, desc->text_size, &read, error);
        if (result == LFLARE_OK) result = lflare_lens_derive(&read, &o->lens, error);
    }
    if (result == LFLARE_OK) result = lflare_lens_paths(&o->lens, &desc->paths, error);
    if (result == LFLARE_OK && desc->fit != NULL) {
#ifndef LFLARE_NO_ABERRATION
        result = lflare_aberration_check(&o->lens, desc->fit, desc->fit_size, error);
#else
        result = lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "this build has LFLARE_NO_ABERRATION: it takes no fit");
#endif
    }
    if (result == LFLARE_OK) result = lflare__create_tables(o, desc->fit, desc->max_lights > 0 ? desc->max_lights : 16, error);
    if (result == LFLARE_OK) result = lflare_configure(o, &desc->settings, error);
    if (result != LFLARE_OK) {
        lflare_destroy(o);
        return result;
    }
    *out = o;
    return LFLARE_OK;
}

static int lflare__masked(const lflare_mask_desc *d) { return d->pixels != NULL || d->dust_count != 0 || d->scratch_count != 0 || d->grating_lines != 0; }

#ifndef LFLARE_NO_DIFFRACTION

/* Whether settings for the iris and the starburst make sense; room for the mask. */
static lflare_result lflare__configure_iris(lflare *o, const lflare_settings *s, lflare_error *error)
{
    lflare_result result;
    if (s->starburst_size != 0 && lflare_starburst_bytes(s->starburst_size) == 0)
        return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "starburst_size %i: give 512, 1024, 2048 or 4096, or 0 for 1024", s->starburst_size);
    if (!lflare__masked(&s->mask)) return LFLARE_OK;
    result = lflare__mask_check(&s->mask, error);
    if (result != LFLARE_OK || o->masks[!o->current] != NULL) return result;
    o->masks[!o->current] = (uint8_t *)lflare__allocate(o, LFLARE_MASK_BYTES);
    return o->masks[!o->current] != NULL ? LFLARE_OK : lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
}

static void lflare__release_work(lflare *o)
{
    lflare__release(o, o->work, o->work_bytes);
    o->work = NULL;
    o->bursting = o->fringing = 0;
}

/* The fringed pictures of the mask being configured, likewise found again, or begun. */
static lflare_result lflare__fringed_begin(lflare *o)
{
    lflare_iris *iris = &o->tables[!o->current].iris;
    const uint8_t *shown = o->tables[o->current].iris.fringed;
    int32_t place = shown != NULL ? shown == o->fringed[0] : !o->fringed_last, i;
    uint64_t key = lflare__mask_hash(iris);
    for (i = 0; i < 2; i++)
        if (o->fringed_keys[i] == key) {
            iris->fringed = o->fringed[i];
            return LFLARE_OK;
        }
    if (o->fringed[place] == NULL) o->fringed[place] = (uint8_t *)lflare__allocate(o, LFLARE_FRINGED_BYTES);
    o->work_bytes = LFLARE_FRINGED_WORK_BYTES;
    o->work = lflare__allocate(o, o->work_bytes);
    if (o->fringed[place] == NULL || o->work == NULL) return LFLARE_ERROR_MEMORY;
    o->fringed_keys[place] = 0;
    o->fringed_last = place;
    o->fringing = 1 + place;
    return lflare_fringed_begin(iris->mask, o->fringed[place], o->work, &o->fringed_job);
}

/* What remains of `slices` comes back in it. */
static lflare_result lflare__fringed_step(lflare *o, int32_t *slices)
{
    lflare_iris *iris = &o->tables[!o->current].iris;
    lflare_result result = LFLARE_OK;
    if (iris->mask == NULL || iris->fringed != NULL || o->settings.no_ringing) return LFLARE_OK;
    if (!o->fringing) result = lflare__fringed_begin(o);
    if (o->fringing && result == LFLARE_OK) result = LFLARE_INCOMPLETE;
    for (; result == LFLARE_INCOMPLETE && *slices > 0; --*slices) result = lflare_fringed_step(&o->fringed_job, 1);
    if (o->fringing && result == LFLARE_OK) {
        iris->fringed = o->fringed[o->fringing - 1];
        o->fringed_keys[o->fringing - 1] = lflare__mask_hash(iris);
    }
    if (result != LFLARE_INCOMPLETE) lflare__release_work(o);
    return result;
}

/* The starburst of the iris being configured: found again, or begun in the place that the shown tables do not use. */
static lflare_result lflare__starburst_begin(lflare *o)
{
    lflare_tables *t = &o->tables[!o->current];
    int32_t size = o->settings.starburst_size > 0 ? o->settings.starburst_size : 1024, place = o->tables[o->current].starburst == &o->bursts[0] ? 1 : 0, i;
    uint64_t key = lflare_starburst_key(&t->iris);
    for (i = 0; i < 2; i++)
        if (o->bursts[i].key == key && o->bursts[i].size == size) {
            t->starburst = &o->bursts[i];
            return LFLARE_OK;
        }
    if (o->burst_tables[place] == NULL) o->burst_tables[place] = (float *)lflare__allocate(o, sizeof(float) * LFLARE_STARBURST_FLOATS);
    o->work_bytes = lflare_starburst_bytes(size);
    o->work = lflare__allocate(o, o->work_bytes);
    if (o->burst_tables[place] == NULL || o->work == NULL) return LFLARE_ERROR_MEMORY;
    t->starburst = &o->bursts[place];
    o->bursting = 1;
    return lflare_starburst_begin(&t->iris, size, o->burst_tables[place], o->work, &o->bursts[place], &o->job);
}

/* Part of the iris's mask, before ghosts; of the starburst, behind them. What remains of `slices` comes back in it. */
static lflare_result lflare__mask_step(lflare *o, int32_t *slices)
{
    enum { ROWS = 4 };
    lflare_tables *t = &o->tables[!o->current];
    const lflare_mask_desc *d = &o->settings.mask;
    if (!lflare__masked(d)) return LFLARE_OK;
    for (; o->next_row < LFLARE_MASK_SIZE && *slices > 0; --*slices, o->next_row += ROWS) {
        int32_t begin = d->height * o->next_row / LFLARE_MASK_SIZE, end = d->height * (o->next_row + ROWS) / LFLARE_MASK_SIZE; /* as many of the image are checked */
        float open = 0;
        lflare_result result = lflare__mask_pixels(d, begin, end, &open, NULL);
        if (result != LFLARE_OK) return result;
        lflare_mask_rows(d, o->masks[!o->current], o->next_row, o->next_row + ROWS);
    }
    if (o->next_row < LFLARE_MASK_SIZE) return LFLARE_INCOMPLETE;
    return t->iris.mask != NULL ? LFLARE_OK : lflare_iris_set_mask(&t->iris, o->masks[!o->current]);
}

static lflare_result lflare__starburst_step(lflare *o, int32_t slices)
{
    lflare_result result = LFLARE_OK;
    if (o->settings.no_starburst) return LFLARE_OK;
    if (!o->bursting && o->tables[!o->current].starburst == NULL) result = lflare__starburst_begin(o);
    if (o->bursting && result == LFLARE_OK) result = slices > 0 ? lflare_starburst_step(&o->job, slices) : LFLARE_INCOMPLETE;
    if (result != LFLARE_INCOMPLETE) lflare__release_work(o);
    return result;
}

/* Of a step that failed: what was allocated for tables that are not shown goes. */
static void lflare__release_iris(lflare *o)
{
    int32_t i;
    lflare__release_work(o);
    lflare__release(o, o->masks[!o->current], LFLARE_MASK_BYTES);
    o->masks[!o->current] = NULL;
    o->tables[!o->current].starburst = NULL;
    for (i = 0; i < 2; i++) {
        if (o->bursts[i].key == 0) {
            lflare__release(o, o->burst_tables[i], sizeof(float) * LFLARE_STARBURST_FLOATS);
            o->burst_tables[i] = NULL;
        }
        if (o->fringed[i] != o->tables[o->current].iris.fringed) {
            lflare__release(o, o->fringed[i], LFLARE_FRINGED_BYTES);
            o->fringed[i] = NULL;
            o->fringed_keys[i] = 0;
        }
    }
}
#else
static lflare_result lflare__configure_iris(const lflare *o, const lflare_settings *s, lflare_error *error)
{
    (void)o;
    return lflare__masked(&s->mask) ? lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "this build has LFLARE_NO_DIFFRACTION: it takes no mask") : LFLARE_OK;
}

#ifdef LFLARE__PATCHES
static void lflare__release_iris(lflare *o) { (void)o; }
#endif
#endif /* LFLARE_NO_DIFFRACTION */

#if defined(LFLARE__PATCHES) || !defined(LFLARE_NO_DIFFRACTION)
/* The step that fails ends it: the shown tables stay. */
static lflare_result lflare__configure_failed(lflare *o, lflare_result result)
{
    if (result >= 0) return result;
    o->configuring = 0;
    lflare__release_iris(o);
    lflare__release(o, o->overrides, o->override_bytes);
    o->overrides = NULL;
    o->override_bytes = 0;
    lflare__release(o, o->demand[!o->current], sizeof(float) * o->demand_floats[!o->current]);
    o->demand[!o->current] = o->tables[!o->current].outline = o->tables[!o->current].spectrum = NULL;
    o->demand_floats[!o->current] = 0;
    return result;
}

#endif

#ifdef LFLARE__PATCHES
/* Room for what some settings need besides. */
static lflare_result lflare__configure_demand(lflare *o, const lflare_settings *s, lflare_error *error)
{
    lflare_tables *t = &o->tables[!o->current];
    float *memory = o->demand[!o->current];
    size_t floats = lflare_tables_demand(t, s, NULL);
    if (floats > (size_t)1 << 26) return lflare__fail(error, LFLARE_ERROR_LIMIT, 0, 0, "too many ghosts for these settings: %g floats", (double)floats);
    if (floats > o->demand_floats[!o->current]) {
        memory = (float *)lflare__allocate(o, sizeof(float) * floats);
        if (memory == NULL) return lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
        lflare__release(o, o->demand[!o->current], sizeof(float) * o->demand_floats[!o->current]);
        o->demand[!o->current] = memory;
        o->demand_floats[!o->current] = floats;
    }
    if (memory != NULL) lflare_tables_demand(t, s, memory);
    return LFLARE_OK;
}

/* Room for the instances that the tables may ask of a frame. */
static lflare_result lflare__configure_frame(lflare *o)
{
    const lflare_tables *t = &o->tables[!o->current];
    size_t lights = (size_t)o->frame.light_capacity, instances = 0, bytes;
    void *memory;
    int32_t g;
    for (g = 0; g < t->active_count; g++) instances += t->cull[g].patches;
    if (lights * instances <= (size_t)o->frame.instance_capacity) return LFLARE_OK;
    if (lights * instances > (size_t)INT32_MAX) return LFLARE_ERROR_LIMIT;
    bytes = lights * (sizeof(lflare_frame_light) + instances * sizeof(lflare_instance));
    memory = lflare__allocate(o, bytes);
    if (memory == NULL) return LFLARE_ERROR_MEMORY;
    lflare__release(o, o->frame_memory, o->frame_bytes);
    o->frame_memory = memory;
    o->frame_bytes = bytes;
    o->frame.lights = (lflare_frame_light *)memory;
    o->frame.instances = (lflare_instance *)(void *)((char *)memory + lights * sizeof(lflare_frame_light));
    o->frame.instance_capacity = (int32_t)(lights * instances);
    return LFLARE_OK;
}

#endif /* LFLARE__PATCHES */

LFLARE_API lflare_result lflare_configure_begin(lflare *o, const lflare_settings *settings, lflare_error *error)
{
    lflare_override *copy = NULL;
    lflare_result result;
    size_t bytes;
    if (o == NULL || settings == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no object or no settings given");
    bytes = settings->override_count > 0 && settings->overrides != NULL ? sizeof(lflare_override) * (size_t)settings->override_count : 0;
    if (bytes > 0) {
        copy = (lflare_override *)lflare__allocate(o, bytes);
        if (copy == NULL) return lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
        memcpy(copy, settings->overrides, bytes);
    }
    result = lflare__configure_iris(o, settings, error);
#ifdef LFLARE__PATCHES
    if (result == LFLARE_OK) result = lflare__configure_demand(o, settings, error);
#endif
    if (result == LFLARE_OK) result = lflare_tables_configure_begin(&o->lens, &o->tables[!o->current], settings, error);
    if (result != LFLARE_OK) { /* what is being built stays as it is */
        lflare__release(o, copy, bytes);
        return result;
    }
    lflare__release(o, o->overrides, o->override_bytes);
    o->overrides = copy;
    o->override_bytes = bytes;
    o->settings = *settings;
    o->settings.overrides = copy;
    o->next_ghost = 0;
    o->configuring = 1;
#ifndef LFLARE_NO_DIFFRACTION
    lflare__release_work(o);
    o->next_row = 0;
#endif
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_configure_step(lflare *o, int32_t ghosts)
{
#if defined(LFLARE__PATCHES) || !defined(LFLARE_NO_DIFFRACTION)
    lflare_result result;
#endif
    int32_t end;
    if (o == NULL || ghosts < 1) return LFLARE_ERROR_ARGUMENT;
    if (!o->configuring) return LFLARE_OK;
#ifndef LFLARE_NO_DIFFRACTION
    result = lflare__mask_step(o, &ghosts);
    if (result != LFLARE_OK) return lflare__configure_failed(o, result);
#endif
    end = ghosts < o->lens.ghost_count - o->next_ghost ? o->next_ghost + ghosts : o->lens.ghost_count;
    lflare_tables_configure_range(&o->lens, &o->tables[!o->current], &o->settings, o->next_ghost, end);
    ghosts -= end - o->next_ghost;
    o->next_ghost = end;
    if (end < o->lens.ghost_count) return LFLARE_INCOMPLETE;
#ifndef LFLARE_NO_DIFFRACTION
    result = lflare__fringed_step(o, &ghosts);
    if (result == LFLARE_OK) result = lflare__starburst_step(o, ghosts);
    if (result != LFLARE_OK) return lflare__configure_failed(o, result);
#endif
    lflare_tables_configure_end(&o->tables[!o->current], &o->settings);
#ifdef LFLARE__PATCHES
    result = lflare__configure_frame(o);
    if (result != LFLARE_OK) return lflare__configure_failed(o, result);
#endif
    o->current = !o->current;
    o->configuring = 0;
    o->frame.light_count = o->frame.instance_count = o->footprint_count = 0; /* they belong to the old tables */
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_configure(lflare *o, const lflare_settings *settings, lflare_error *error)
{
    lflare_result result = lflare_configure_begin(o, settings, error);
    if (result == LFLARE_OK) result = lflare_configure_step(o, INT32_MAX);
    else return result;
    if (result == LFLARE_ERROR_MEMORY) return lflare__fail(error, result, 0, 0, "out of memory");
#ifdef LFLARE__PATCHES
    if (result == LFLARE_ERROR_LIMIT) return lflare__fail(error, result, 0, 0, "max_lights times the ghosts' patches is over 2^31");
#endif
#ifndef LFLARE_NO_DIFFRACTION
    if (result < 0 && lflare_mask_check(&settings->mask, error) == LFLARE_OK) return lflare__fail(error, result, 0, 0, "the mask and the blades together let nothing pass");
#endif
    return result;
}

LFLARE_API lflare_result lflare_frame(lflare *o, const lflare_view *view, const lflare_light *lights, int32_t light_count)
{
    if (o == NULL) return LFLARE_ERROR_ARGUMENT;
    o->footprint_count = 0;
    return lflare_frame_build(&o->tables[o->current], view, lights, light_count, &o->frame);
}

LFLARE_API const lflare_lens *lflare_get_lens(const lflare *o) { return o != NULL ? &o->lens : NULL; }
LFLARE_API const lflare_tables *lflare_get_tables(const lflare *o) { return o != NULL ? &o->tables[o->current] : NULL; }
LFLARE_API const lflare_frame_data *lflare_get_frame(const lflare *o) { return o != NULL ? &o->frame : NULL; }

#ifndef LFLARE_NO_SOFTWARE
LFLARE_API lflare_result lflare_render_begin(lflare *o)
{
    int32_t i;
    if (o == NULL) return LFLARE_ERROR_ARGUMENT;
    if (o->footprints == NULL && o->frame.instance_capacity > 0 && o->tables[o->current].model == LFLARE_MODEL_PARAXIAL) {
        size_t count = (size_t)o->frame.light_capacity * (size_t)o->lens.ghost_count;
        if (count > (size_t)-1 / sizeof(lflare_footprint) || count > (size_t)INT32_MAX) return LFLARE_ERROR_MEMORY;
        o->footprints = (lflare_footprint *)lflare__allocate(o, sizeof(lflare_footprint) * count);
        if (o->footprints == NULL) return LFLARE_ERROR_MEMORY;
        o->footprint_capacity = (int32_t)count;
    }
    o->footprint_count = 0;
    for (i = 0; i < o->frame.instance_count && o->tables[o->current].model == LFLARE_MODEL_PARAXIAL; i++)
        o->footprint_count += lflare_footprint_resolve(&o->tables[o->current], &o->frame, o->frame.instances[i], &o->footprints[o->footprint_count]);
    return LFLARE_OK;
}

LFLARE_API lflare_result lflare_render_rows(const lflare *o, const lflare_image *image, int32_t begin, int32_t end)
{
    const lflare_tables *t = o != NULL ? &o->tables[o->current] : NULL;
    lflare_result result;
    if (o == NULL || image == NULL) return LFLARE_ERROR_ARGUMENT;
    result = lflare_software_starbursts(t, &o->frame, image, begin, end);
    if (result != LFLARE_OK) return result;
#ifdef LFLARE__PATCHES
    if (t->model != LFLARE_MODEL_PARAXIAL) return lflare_software_patches(t, &o->frame, image, begin, end);
#endif
    return lflare_software_rows(o->footprints, o->footprint_count, &t->iris, &o->frame, image, begin, end);
}

LFLARE_API lflare_result lflare_render(lflare *o, const lflare_image *image)
{
    lflare_result result = image != NULL ? lflare_render_begin(o) : LFLARE_ERROR_ARGUMENT;
    return result == LFLARE_OK ? lflare_render_rows(o, image, 0, image->height) : result;
}
#endif /* LFLARE_NO_SOFTWARE */

#ifndef LFLARE_NO_STDIO
LFLARE_API lflare_result lflare_file_read(const char *path, lflare_realloc allocate, void *user, char **out, size_t *size, lflare_error *error)
{
    const size_t limit = (size_t)16 << 20;
    size_t room = 0, used = 0;
    char *block = NULL;
    FILE *file;
    lflare_result result = LFLARE_OK;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (path == NULL || out == NULL || size == NULL) return lflare__fail(error, LFLARE_ERROR_ARGUMENT, 0, 0, "no path, or nowhere to put the text");
    if (allocate == NULL) allocate = lflare__libc_realloc;
    *out = NULL;
    *size = 0;
    file = fopen(path, "rb");
    if (file == NULL) return lflare__fail(error, LFLARE_ERROR_FILE, 0, 0, "the file cannot be opened");
    for (;;) {
        size_t got;
        if (used + 1 >= room) {
            size_t grown = room == 0 ? 16384 : room * 2;
            char *larger = used < limit ? (char *)allocate(user, block, room, grown) : NULL;
            if (larger == NULL) {
                result = used < limit ? lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory")
                                      : lflare__fail(error, LFLARE_ERROR_FILE, 0, 0, "the file is larger than 16 MB, which no prescription is");
                break;
            }
            block = larger;
            room = grown;
        }
        got = fread(block + used, 1, room - used - 1, file);
        used += got;
        if (got == 0 || used > limit) break;
    }
    if (result == LFLARE_OK && used > limit) result = lflare__fail(error, LFLARE_ERROR_FILE, 0, 0, "the file is larger than 16 MB, which no prescription is");
    if (result == LFLARE_OK && ferror(file)) result = lflare__fail(error, LFLARE_ERROR_FILE, 0, 0, "the file cannot be read");
    fclose(file);
    if (result == LFLARE_OK) { /* to the promised size */
        char *exact = (char *)allocate(user, block, room, used + 1);
        if (exact == NULL) result = lflare__fail(error, LFLARE_ERROR_MEMORY, 0, 0, "out of memory");
        else block = exact, room = used + 1;
    }
    if (result != LFLARE_OK) {
        if (block != NULL) allocate(user, block, room, 0);
        return result;
    }
    block[used] = 0;
    *out = block;
    *size = used;
    return LFLARE_OK;
}
#endif /* LFLARE_NO_STDIO */

#undef LFLARE__PI
#undef LFLARE__PATCHES
#undef LFLARE__BUDGETS
#undef LFLARE__APART
#undef LFLARE__OUTLINE_APART
#undef LFLARE__NM_D
#undef LFLARE__NM_F
#undef LFLARE__NM_C
#undef LFLARE__PIXEL_VARIANCE
#undef LFLARE__RING_WASHED
#undef LFLARE__RING_INNER
#undef LFLARE__RING_OUTER
#undef LFLARE__RING_MOST
#undef LFLARE__FRINGED_OCTAVE
#undef LFLARE__RING_LEAST
#undef LFLARE__STARBURST_LEAST

#endif /* LENSFLARE_IMPLEMENTED */
#endif /* LENSFLARE_IMPLEMENTATION */

/* >> 17 licence */
/*
   This software is available under two licences: choose whichever you prefer.

   ALTERNATIVE A - MIT Licence
   Copyright (c) 2026 the lensflare.h authors
   Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
   documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
   rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
   persons to whom the Software is furnished to do so, subject to the following conditions:
   The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
   Software.
   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
   WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
   COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
   OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

   ALTERNATIVE B - Public Domain (www.unlicense.org)
   This is free and unencumbered software released into the public domain.
   Anyone is free to copy, modify, publish, use, compile, sell, or distribute this software, either in source code form or
   as a compiled binary, for any purpose, commercial or non-commercial, and by any means.
   In jurisdictions that recognize copyright laws, the author or authors of this software dedicate any and all copyright
   interest in the software to the public domain. We make this dedication for the benefit of the public at large and to the
   detriment of our heirs and successors. We intend this dedication to be an overt act of relinquishment in perpetuity of
   all present and future rights to this software under copyright law.
   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
   WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS BE
   LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT
   OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
*/
