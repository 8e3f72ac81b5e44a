/* lensimport.h - v0.1.0 - reads lens prescriptions in the formats that people have; a catalogue of optical glasses
   Optional companion of lensflare.h, under the same two licences (MIT or the Unlicense, at the end of lensflare.h).

   Do this in *one* C or C++ file to create the implementation, and include it plainly everywhere else:

       #define LENSIMPORT_IMPLEMENTATION
       #include "lenses/lensimport.h"

   It includes ../lensflare.h's declarations; one file of the program must hold the implementation of that, too.
   LENSIMPORT_API, before that line: your own linkage; LENSIMPORT_STATIC: every function static.

   Needs libc and libm. No globals, no output, no exit, no allocation. Any bytes are safe; time is linear in their number. */

/* >> 0 documentation */
/*
   CONTENTS (the lines that begin each room; grep for "[>]>")

       >> 0 documentation
       >> 1 public interface
       >> 2 sentences
       >> 3 glass
       >> 4 text
       >> 5 lens
       >> 6 zemax
       >> 7 zemax report
       >> 8 code v
       >> 9 optical bench
       >> 10 plain tables
       >> 11 xml and json
       >> 12 reading

   FORMATS, recognised by content, never by a file's name

       Zemax .zmx                    UTF-16 of either order, UTF-8, Latin-1; zoom configurations; catalogue and model glasses
       Zemax prescription report     text, columns by tabs or by width; indices of unknown glasses and zoom configurations from its
                                     own tables
       CODE V .seq                   radius or curvature mode, private glasses, zoom positions
       PhotonsToPhotos Optical Bench text with [sections]; zoom and focus states
       pbrt .dat                     gaps behind or in front of each row, told apart
       OpenLensFlare .xml, RealFlare .json, LensSim .json
       FlareSim .lens                diameters where semi-diameters are meant, told apart
       lensflare.h's own             as lflare_text_read reads it

   WHAT COMES OUT

   An lflare_prescription in millimetres as lflare_lens_derive takes it: object and image surfaces taken off, surfaces between
   equal media left out, the stop a flat row of its own. What the file does not say stays open where lflare_lens_derive
   derives it (semi-diameters, the stop's radius, the sensor) and is noted there; what is guessed or changed here, or where the
   file contradicts itself, is in the report as data, with a sentence for each. What is not a lens of rotationally
   symmetric refracting surfaces is refused, with the line and the reason.

   QUICK EXAMPLE (a test extracts, compiles and runs it)

   @example
       #define LENSFLARE_IMPLEMENTATION
       #include "lensflare.h"
       #define LENSIMPORT_IMPLEMENTATION
       #include "lenses/lensimport.h"
       #include <stdio.h>

       int main(int argc, char **argv)
       {
           static lflare_prescription prescription;
           static lensimport_report report;
           lflare_error error;
           char *text, sentence[200];
           size_t size;
           int i;

           if (argc < 2 || lflare_file_read(argv[1], NULL, NULL, &text, &size, &error) < 0) return 1;
           if (lensimport_read(text, size, NULL, &prescription, &report, &error) < 0) {
               printf("line %d, column %d: %s\n", (int)error.line, (int)error.column, error.text);
               return 1;
           }
           printf("%s, focal length %.2f mm\n", lensimport_format_name(report.format), report.efl);
           for (i = 0; i < report.note_count; i++) printf("%s\n", lensimport_note_text(&report.notes[i], sentence, sizeof sentence));
           free(text);
           return 0; // prescription: to lflare_lens_derive, or as text (lflare_text_write) to lflare_create
       }
   @end
*/

#ifndef LENSIMPORT_H
#define LENSIMPORT_H

#include "../lensflare.h"

/* >> 1 public interface */

#ifndef LENSIMPORT_API
#if defined(LENSIMPORT_STATIC) && defined(__GNUC__)
#define LENSIMPORT_API static __attribute__((unused))
#elif defined(LENSIMPORT_STATIC)
#define LENSIMPORT_API static
#elif defined(__cplusplus)
#define LENSIMPORT_API extern "C"
#else
#define LENSIMPORT_API extern
#endif
#endif

enum { LENSIMPORT_MAX_NOTES = 160 };

typedef enum lensimport_format {
    LENSIMPORT_UNKNOWN = 0,
    LENSIMPORT_LENSFLARE,    /* lensflare.h's own */
    LENSIMPORT_ZEMAX,        /* .zmx */
    LENSIMPORT_ZEMAX_REPORT, /* "System/Prescription Data" */
    LENSIMPORT_CODEV,        /* .seq */
    LENSIMPORT_BENCH,        /* PhotonsToPhotos Optical Bench */
    LENSIMPORT_PBRT,         /* .dat */
    LENSIMPORT_XML,          /* OpenLensFlare */
    LENSIMPORT_JSON,         /* RealFlare, LensSim */
    LENSIMPORT_FLARESIM      /* .lens */
} lensimport_format;

/* What was guessed, changed or contradicts itself. `line` is the file's, 0 for the lens as a whole; `label` a glass or a
   name, "" for none. What lflare_lens_derive derives is in lflare_lens.notes instead. */
typedef enum lensimport_note_kind {
    LENSIMPORT_NOTE_EFL_DIFFERS = 1,    /* value: focal length computed, `stated` by the file; over 0.5 % apart */
    LENSIMPORT_NOTE_FNUMBER_IGNORED,    /* value: f-number of the stop's size, which counts; `stated` is a working stop */
    LENSIMPORT_NOTE_FNUMBER_GUESSED,    /* value: assumed, since nothing says how wide the stop or any surface is */
    LENSIMPORT_NOTE_UNITS,              /* value: millimetres of the file's unit */
    LENSIMPORT_NOTE_CONFIG,             /* value: zoom state read, from 1, of `stated` */
    LENSIMPORT_NOTE_CONFIG_PARTLY,      /* label: an operand of the zoom table that is not followed */
    LENSIMPORT_NOTE_STOP_GUESSED,       /* no stop in the file; value: the gap in front of where it was put, mm */
    LENSIMPORT_NOTE_STOP_SPLIT,         /* the stop was a refracting surface: a flat row at its vertex stands for it */
    LENSIMPORT_NOTE_STOP_MOVED,         /* the stop lay beyond a neighbour's vertex; value: mm it was moved to that vertex */
    LENSIMPORT_NOTE_ROWS_LEFT_OUT,      /* value: surfaces between equal media, which do nothing */
    LENSIMPORT_NOTE_SEMI_HALVED,        /* all semi-diameters were diameters; value: stop's ratio to its paraxial radius, 0 unknown */
    LENSIMPORT_NOTE_SEMI_IGNORED,       /* value: a semi-diameter that cannot be meant; it is derived instead */
    LENSIMPORT_NOTE_GLASS_REPLACED,     /* label: glass whose name is another's today, `value` its nd */
    LENSIMPORT_NOTE_GLASS_BY_NUMBERS,   /* label: glass known by nd (value) and Vd (stated) alone */
    LENSIMPORT_NOTE_DISPERSION_MISSING, /* value: index of a medium without an Abbe number: constant */
    LENSIMPORT_NOTE_OBJECT_FINITE,      /* value: the object's distance in the file; lenses here look at infinity */
    LENSIMPORT_NOTE_OBJECT_IN_GLASS,    /* a flat front face was added */
    LENSIMPORT_NOTE_ENDS_IN_GLASS,      /* a flat rear face was added at the image */
    LENSIMPORT_NOTE_GAP_UNKNOWN,        /* the file says nothing usable of the last gap: the sensor goes into focus */
    LENSIMPORT_NOTE_GAP_MISSING,        /* label: a distance that is named and not defined: 0 assumed */
    LENSIMPORT_NOTE_GAPS_BEFORE,        /* the rows give the distance to the previous row */
    LENSIMPORT_NOTE_ASPHERE_CUT,        /* value: power of a term left out, odd or over 16; its coefficient is `stated` */
    LENSIMPORT_NOTE_ASPHERE_LOST,       /* label: a surface that has aspheric terms and is not there */
    LENSIMPORT_NOTE_RADIUS_DIFFERS,     /* value: radius of the surface, `stated` with its aspheric terms */
    LENSIMPORT_NOTE_APERTURE_IGNORED,   /* label: an aperture that is no circle about the axis */
    LENSIMPORT_NOTE_SENSOR_DERIVED      /* value, stated: width and height within the file's image circle */
} lensimport_note_kind;

typedef struct lensimport_note {
    lensimport_note_kind kind;
    int32_t line;
    double value, stated;
    char label[24];
} lensimport_note;

/* Why a system is refused: the first of these that it has. */
typedef enum lensimport_refusal {
    LENSIMPORT_REFUSED_NOT = 0,
    LENSIMPORT_REFUSED_MIRROR,       /* a reflecting surface */
    LENSIMPORT_REFUSED_TILT,         /* tilted or decentred */
    LENSIMPORT_REFUSED_GRATING,      /* gratings, holograms, diffractive surfaces */
    LENSIMPORT_REFUSED_TOROID,       /* curved differently in two directions */
    LENSIMPORT_REFUSED_GRADIENT,     /* a gradient of the index */
    LENSIMPORT_REFUSED_IDEAL,        /* ideal lenses without glass */
    LENSIMPORT_REFUSED_SEQUENCE,     /* not sequential */
    LENSIMPORT_REFUSED_SURFACE,      /* another type of surface */
    LENSIMPORT_REFUSED_BACKWARDS     /* a negative gap between surfaces */
} lensimport_refusal;

typedef struct lensimport_report {
    lensimport_format format;
    int32_t config, config_count;  /* zoom state read, from 1, and how many the file has */
    double efl, bfd;               /* mm, at the d line; 0 if the system has no focal length */
    double stated_efl, stated_bfd; /* as the file has them, mm; 0 if it does not say */
    lensimport_refusal refusal;
    int32_t note_count;
    lensimport_note notes[LENSIMPORT_MAX_NOTES];
} lensimport_report;

/* All zeroes is the default. */
typedef struct lensimport_desc {
    int32_t config;          /* zoom state, from 1; 0 = the file's own, or its first focused at infinity */
    int32_t focus;           /* 1: the sensor goes to the paraxial focus whatever the file says */
    const char *catalogues;  /* makers searched first for glasses, e.g. "OHARA SCHOTT"; NULL = the file's, then SCHOTT, OHARA, CDGM */
} lensimport_desc;

LENSIMPORT_API lensimport_format lensimport_sniff(const void *bytes, size_t size);
LENSIMPORT_API const char *lensimport_format_name(lensimport_format format);

/* Reads `size` bytes (NULL if 0). desc, report and error may be NULL. Returns LFLARE_OK, and *out is ready for lflare_lens_derive;
   or LFLARE_ERROR_SYNTAX (no format known here, or broken), LFLARE_ERROR_LENS (refused, see report->refusal; or a glass nobody
   knows), LFLARE_ERROR_ARGUMENT (no `out`, or a zoom state that the file lacks); then *out is unspecified, *error says where.
   Columns count from 1, in bytes of the line as UTF-8. Any bytes are safe. Linear in size, allocates nothing; some 30 KB of stack. */
LENSIMPORT_API lflare_result lensimport_read(const void *bytes, size_t size, const lensimport_desc *desc, lflare_prescription *out,
                                             lensimport_report *report, lflare_error *error);

/* One sentence about a note; `out` of `size` bytes is always terminated if size > 0. Returns out. */
LENSIMPORT_API const char *lensimport_note_text(const lensimport_note *note, char *out, size_t size);

/* ---- glass ---- */

typedef enum lensimport_match {
    LENSIMPORT_MATCH_NONE = 0,
    LENSIMPORT_MATCH_NAME,      /* the catalogue's own name, but for capitals and hyphens */
    LENSIMPORT_MATCH_NUMBERS,   /* a name of which only nd and Vd are kept: obsolete, another maker's, plastics, crystals */
    LENSIMPORT_MATCH_SUCCESSOR, /* the glass that bears the name today: BK7 is N-BK7 */
    LENSIMPORT_MATCH_CODE,      /* a six-digit code or its longer forms, and a catalogue glass has it */
    LENSIMPORT_MATCH_CODE_ONLY  /* such a code, and no catalogue glass has it: nd and Vd from its digits */
} lensimport_match;

typedef struct lensimport_glass {
    char name[24], maker[8]; /* maker "" where only nd and Vd are kept */
    double nd, vd;           /* vd 0: not known */
    lflare_medium medium;    /* Sellmeier, nd and Vd, or a constant */
    lensimport_match match;
} lensimport_glass;

/* The glass of a name as people write it: N-BK7, nbk7, BK7, NBK7_SCHOTT, 517642, 517.642, 516800.641700. `prefer`: makers
   searched first, in order, NULL for none. Returns what kind of match it is; *out is untouched if there is none. */
LENSIMPORT_API lensimport_match lensimport_glass_find(const char *name, size_t size, const char *prefer, lensimport_glass *out);

/* The catalogue glass next to nd and Vd, 0.001 of nd counting as much as 0.5 of Vd; of `makers` alone, NULL for all. Returns
   the distance in those units, infinite if there is none. */
LENSIMPORT_API double lensimport_glass_nearest(double nd, double vd, const char *makers, lensimport_glass *out);

/* The catalogue itself, by index below lensimport_glass_count. */
LENSIMPORT_API int32_t lensimport_glass_count(void);
LENSIMPORT_API lflare_result lensimport_glass_get(int32_t index, lensimport_glass *out);

#endif /* LENSIMPORT_H */

#ifdef LENSIMPORT_IMPLEMENTATION
#ifndef LENSIMPORT_IMPLEMENTED
#define LENSIMPORT_IMPLEMENTED

#include <math.h>
#include <stdarg.h>
#include <string.h>

#define LENSIMPORT__NM_D 587.5618
#define LENSIMPORT__NM_F 486.1327
#define LENSIMPORT__NM_C 656.2725

/* >> 2 sentences */

static int lensimport__finite(double v) { return v - v == 0; }

/* %s string, %i int32_t, %g double to 6 digits. */
static void lensimport__format_list(char *out, size_t size, const char *format, va_list list)
{
    size_t n = 0;
    for (; *format != 0; format++) {
        char buffer[40];
        const char *piece = buffer;
        size_t length = 1;
        buffer[0] = *format;
        if (*format == '%') {
            if (*++format == 's') {
                piece = va_arg(list, const char *);
                length = strlen(piece);
            } else {
                double v = *format == 'i' ? (double)va_arg(list, int32_t) : va_arg(list, double);
                if (v != 0 && lensimport__finite(v)) {
                    double unit = pow(10.0, floor(log10(fabs(v))) - 5), rounded = floor(v / unit + 0.5);
                    v = unit < 1 ? rounded / floor(1 / unit + 0.5) : rounded * unit;
                }
                length = (size_t)lflare_number_write(v, buffer);
            }
        }
        for (; length > 0 && n + 1 < size; length--, piece++) out[n++] = *piece;
    }
    if (size > 0) out[n] = 0;
}

static void lensimport__format(char *out, size_t size, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    lensimport__format_list(out, size, format, list);
    va_end(list);
}

LENSIMPORT_API const char *lensimport_format_name(lensimport_format format)
{
    switch (format) {
    case LENSIMPORT_LENSFLARE: return "lensflare";
    case LENSIMPORT_ZEMAX: return "Zemax";
    case LENSIMPORT_ZEMAX_REPORT: return "Zemax report";
    case LENSIMPORT_CODEV: return "CODE V";
    case LENSIMPORT_BENCH: return "Optical Bench";
    case LENSIMPORT_PBRT: return "pbrt";
    case LENSIMPORT_XML: return "OpenLensFlare";
    case LENSIMPORT_JSON: return "RealFlare";
    case LENSIMPORT_FLARESIM: return "FlareSim";
    default: return "unknown";
    }
}

static void lensimport__note_body(const lensimport_note *note, char *out, size_t size)
{
    double v = note->value, w = note->stated;
    const char *label = note->label;
    switch (note->kind) {
    case LENSIMPORT_NOTE_EFL_DIFFERS: lensimport__format(out, size, "a focal length of %g mm is stated, the surfaces make %g mm", w, v); break;
    case LENSIMPORT_NOTE_FNUMBER_IGNORED: lensimport__format(out, size, "f/%g is stated, the stop's size makes f/%g, which counts as the full opening", w, v); break;
    case LENSIMPORT_NOTE_FNUMBER_GUESSED: lensimport__format(out, size, "nothing says how wide the lens opens: f/%g assumed", v); break;
    case LENSIMPORT_NOTE_UNITS: lensimport__format(out, size, "lengths are in units of %g mm", v); break;
    case LENSIMPORT_NOTE_CONFIG: lensimport__format(out, size, "zoom state %g of %g", v, w); break;
    case LENSIMPORT_NOTE_CONFIG_PARTLY: lensimport__format(out, size, "'%s' of the zoom table is not followed", label); break;
    case LENSIMPORT_NOTE_STOP_GUESSED: lensimport__format(out, size, "the file has no stop: one is put %g mm behind this surface, which is a guess", v); break;
    case LENSIMPORT_NOTE_STOP_SPLIT: lensimport__format(out, size, "the stop is a refracting surface: a flat stop at its vertex stands for it"); break;
    case LENSIMPORT_NOTE_STOP_MOVED: lensimport__format(out, size, "the stop lies beyond its neighbour's vertex: moved there, by %g mm", v); break;
    case LENSIMPORT_NOTE_ROWS_LEFT_OUT: lensimport__format(out, size, "surfaces between equal media are left out: %g", v); break;
    case LENSIMPORT_NOTE_SEMI_HALVED:
        if (v > 0) lensimport__format(out, size, "semi-diameters are diameters (the stop's is %g times its paraxial radius): halved", v);
        else lensimport__format(out, size, "semi-diameters are taken for diameters, as this format's files have them: halved");
        break;
    case LENSIMPORT_NOTE_SEMI_IGNORED: lensimport__format(out, size, "a semi-diameter of %g mm cannot be meant: it is left to be derived", v); break;
    case LENSIMPORT_NOTE_GLASS_REPLACED: lensimport__format(out, size, "glass '%s' is no longer listed: its successor is taken, nd %g", label, v); break;
    case LENSIMPORT_NOTE_GLASS_BY_NUMBERS: lensimport__format(out, size, "of glass '%s' only nd %g and Vd %g are known", label, v, w); break;
    case LENSIMPORT_NOTE_DISPERSION_MISSING: lensimport__format(out, size, "index %g without an Abbe number: no dispersion", v); break;
    case LENSIMPORT_NOTE_OBJECT_FINITE: lensimport__format(out, size, "made for an object at %g mm; here it looks at infinity", v); break;
    case LENSIMPORT_NOTE_OBJECT_IN_GLASS: lensimport__format(out, size, "the object lies in glass: a flat front face is added"); break;
    case LENSIMPORT_NOTE_ENDS_IN_GLASS: lensimport__format(out, size, "the image lies in glass: a flat rear face is added there"); break;
    case LENSIMPORT_NOTE_GAP_UNKNOWN: lensimport__format(out, size, "the distance to the image is not given, or negative: the sensor goes into focus"); break;
    case LENSIMPORT_NOTE_GAP_MISSING: lensimport__format(out, size, "the distance '%s' is not defined: 0 assumed", label); break;
    case LENSIMPORT_NOTE_GAPS_BEFORE: lensimport__format(out, size, "distances are those to the previous surface"); break;
    case LENSIMPORT_NOTE_ASPHERE_CUT: lensimport__format(out, size, "the aspheric term %g r^%g is left out (terms here are even, r^2 to r^16)", w, v); break;
    case LENSIMPORT_NOTE_ASPHERE_LOST: lensimport__format(out, size, "aspheric terms of surface '%s', which is not there", label); break;
    case LENSIMPORT_NOTE_RADIUS_DIFFERS: lensimport__format(out, size, "the radius is %g mm, with the aspheric terms stands %g mm", v, w); break;
    case LENSIMPORT_NOTE_APERTURE_IGNORED: lensimport__format(out, size, "the aperture '%s' is no circle about the axis: taken for one", label); break;
    case LENSIMPORT_NOTE_SENSOR_DERIVED: lensimport__format(out, size, "sensor %g x %g mm, within the file's image circle", v, w); break;
    default: lensimport__format(out, size, "unknown note"); break;
    }
}

LENSIMPORT_API const char *lensimport_note_text(const lensimport_note *note, char *out, size_t size)
{
    size_t n = 0;
    if (note->line > 0) {
        lensimport__format(out, size, "line %i: ", note->line);
        n = size > 0 ? strlen(out) : 0;
    }
    lensimport__note_body(note, out + n, size - n);
    return out;
}

/* >> 3 glass */

/* Makers' coefficients; rows of one maker stand together. */
typedef struct lensimport__glass {
    char name[15];
    uint8_t maker;
    float c[6];
} lensimport__glass;

/* Vd in hundredths, 0 unknown; nd in 1e-5. */
typedef struct lensimport__listed {
    char name[14];
    uint16_t vd;
    int32_t nd;
} lensimport__listed;

/* made by lenses/glasses.sh (make glasses) from the tables beside it; glasses begin */
static const char lensimport__makers[][8] = {"SCHOTT", "OHARA", "CDGM", "HIKARI"};
static const lensimport__glass lensimport__glasses[] = {
    {"AF32ECO", 0, {1.11332955f, 0.141527282f, 0.860743147f, 0.00707493977f, 0.0225358637f, 90.1552652f}},
    {"D263TECO", 0, {1.23795755f, 0.0466468888f, 2.46700556f, 0.00863080926f, 0.0469074501f, 264.146296f}},
    {"LITHOSIL-Q", 0, {0.67071081f, 0.433322857f, 0.877379057f, 0.00449192312f, 0.0132812976f, 95.8899878f}},
    {"LITHOTEC-CAF2", 0, {0.617617011f, 0.421117656f, 3.79711183f, 0.00275381936f, 0.0105900875f, 1182.67444f}},
    {"ZERODUR", 0, {1.3182408f, 0.0244f, 1.08915181f, 0.00879f, 0.0609f, 110.0f}},
    {"LF7", 0, {1.26879731f, 0.156697051f, 0.887676301f, 0.00919553925f, 0.0447256764f, 106.820361f}},
    {"BAFN6", 0, {1.36719201f, 0.10907994f, 1.02108011f, 0.00882820704f, 0.0438731646f, 113.58602f}},
    {"BK7G18", 0, {1.26538542f, 0.0144191073f, 1.00323028f, 0.00813104078f, 0.0543303226f, 102.821166f}},
    {"F2", 0, {1.34533359f, 0.209073176f, 0.937357162f, 0.00997743871f, 0.0470450767f, 111.886764f}},
    {"F2G12", 0, {1.34702224f, 0.210037763f, 19.5350768f, 0.00980850553f, 0.0471788018f, 2279.1547f}},
    {"F2HT", 0, {1.34533359f, 0.209073176f, 0.937357162f, 0.00997743871f, 0.0470450767f, 111.886764f}},
    {"F5", 0, {1.3104463f, 0.19603426f, 0.96612977f, 0.00958633048f, 0.0457627627f, 115.011883f}},
    {"FK3", 0, {0.973346627f, 0.146642231f, 0.679304225f, 0.00640795469f, 0.020565293f, 80.4965389f}},
    {"FK5HTi", 0, {0.90936218f, 0.279077054f, 0.891813298f, 0.0052014247f, 0.0158938446f, 95.9109448f}},
    {"K10", 0, {1.15687082f, 0.0642625444f, 0.872376139f, 0.00809424251f, 0.0386051284f, 104.74773f}},
    {"K5G20", 0, {1.14094396f, 0.14500119f, 37.4705786f, 0.00694945478f, 0.0310574444f, 4536.25624f}},
    {"K7", 0, {1.1273555f, 0.124412303f, 0.827100531f, 0.00720341707f, 0.0269835916f, 100.384588f}},
    {"KZFS12", 0, {1.55624873f, 0.239769276f, 0.947887658f, 0.0102012744f, 0.0469277969f, 69.8370722f}},
    {"KZFSN4", 0, {1.37994218f, 0.168496708f, 0.874885726f, 0.00891159699f, 0.040533407f, 69.6628237f}},
    {"LAFN7", 0, {1.66842615f, 0.298512803f, 1.0774376f, 0.0103159999f, 0.0469216348f, 82.5078509f}},
    {"LAK9G15", 0, {1.28773667f, 0.518244853f, 26.1756109f, 0.0055754192f, 0.0223679524f, 1892.2533f}},
    {"LAKL12", 0, {1.28115389f, 0.482607607f, 1.16553538f, 0.00636439821f, 0.0213764262f, 93.2771532f}},
    {"LASF35", 0, {2.45505861f, 0.453006077f, 2.3851308f, 0.0135670404f, 0.054580302f, 167.904715f}},
    {"LASFN9", 0, {1.97888194f, 0.320435298f, 1.92900751f, 0.0118537266f, 0.052738177f, 166.25654f}},
    {"LF5", 0, {1.28035628f, 0.163505973f, 0.893930112f, 0.00929854416f, 0.0449135769f, 110.493685f}},
    {"LF5G15", 0, {1.28887331f, 0.162818811f, 10.5579792f, 0.0092001566f, 0.0456954308f, 1275.44015f}},
    {"LF5G19", 0, {1.34611327f, 0.142428018f, 0.900477176f, 0.0097174385f, 0.0501911619f, 111.959703f}},
    {"LF5HTi", 0, {1.28552924f, 0.158357622f, 0.892175122f, 0.0093988626f, 0.0452566659f, 110.544829f}},
    {"LLF1", 0, {1.21640125f, 0.13366454f, 0.883399468f, 0.00857807248f, 0.0420143003f, 107.59306f}},
    {"LLF1HTi", 0, {1.22510445f, 0.125155671f, 0.892236751f, 0.00870432098f, 0.0427325235f, 108.049968f}},
    {"N-BAF10", 0, {1.5851495f, 0.143559385f, 1.08521269f, 0.00926681282f, 0.0424489805f, 105.613573f}},
    {"N-BAF3", 0, {1.34859634f, 0.10764424f, 1.13207084f, 0.00871492932f, 0.0478406436f, 112.936116f}},
    {"N-BAF4", 0, {1.42056328f, 0.102721269f, 1.14380976f, 0.00942015382f, 0.0531087291f, 110.278856f}},
    {"N-BAF51", 0, {1.51503623f, 0.153621958f, 1.15427909f, 0.00942734715f, 0.04308265f, 124.889868f}},
    {"N-BAF52", 0, {1.43903433f, 0.0967046052f, 1.09875818f, 0.00907800128f, 0.050821208f, 105.691856f}},
    {"N-BAK1", 0, {1.12365662f, 0.309276848f, 0.881511957f, 0.00644742752f, 0.0222284402f, 107.297751f}},
    {"N-BAK2", 0, {1.01662154f, 0.319903051f, 0.937232995f, 0.00592383763f, 0.0203828415f, 113.118417f}},
    {"N-BAK4", 0, {1.28834642f, 0.132817724f, 0.945395373f, 0.00779980626f, 0.0315631177f, 105.965875f}},
    {"N-BAK4HT", 0, {1.28834642f, 0.132817724f, 0.945395373f, 0.00779980626f, 0.0315631177f, 105.965875f}},
    {"N-BALF4", 0, {1.31004128f, 0.142038259f, 0.964929351f, 0.0079659645f, 0.0330672072f, 109.19732f}},
    {"N-BALF5", 0, {1.28385965f, 0.0719300942f, 1.05048927f, 0.00825815975f, 0.0441920027f, 107.097324f}},
    {"N-BASF2", 0, {1.53652081f, 0.156971102f, 1.30196815f, 0.0108435729f, 0.0562278762f, 131.3397f}},
    {"N-BASF64", 0, {1.65554268f, 0.17131977f, 1.33664448f, 0.0104485644f, 0.0499394756f, 118.961472f}},
    {"N-BK10", 0, {0.888308131f, 0.328964475f, 0.984610769f, 0.00516900822f, 0.0161190045f, 99.7575331f}},
    {"N-BK7", 0, {1.03961212f, 0.231792344f, 1.01046945f, 0.00600069867f, 0.0200179144f, 103.560653f}},
    {"N-BK7HT", 0, {1.03961212f, 0.231792344f, 1.01046945f, 0.00600069867f, 0.0200179144f, 103.560653f}},
    {"N-BK7HTi", 0, {1.03961212f, 0.231792344f, 1.01046945f, 0.00600069867f, 0.0200179144f, 103.560653f}},
    {"N-F2", 0, {1.39757037f, 0.159201403f, 1.2686543f, 0.00995906143f, 0.0546931752f, 119.248346f}},
    {"N-FK5", 0, {0.844309338f, 0.344147824f, 0.910790213f, 0.00475111955f, 0.0149814849f, 97.8600293f}},
    {"N-FK51", 0, {0.971247817f, 0.216901417f, 0.904651666f, 0.00472301995f, 0.0153575612f, 168.68133f}},
    {"N-FK51A", 0, {0.971247817f, 0.216901417f, 0.904651666f, 0.00472301995f, 0.0153575612f, 168.68133f}},
    {"N-FK58", 0, {0.738042712f, 0.363371967f, 0.989296264f, 0.00339065607f, 0.0117551189f, 212.842145f}},
    {"N-K5", 0, {1.08511833f, 0.199562005f, 0.930511663f, 0.00661099503f, 0.024110866f, 111.982777f}},
    {"N-KF9", 0, {1.19286778f, 0.0893346571f, 0.920819805f, 0.00839154696f, 0.0404010786f, 112.572446f}},
    {"N-KZFS11", 0, {1.3322245f, 0.28924161f, 1.15161734f, 0.0084029848f, 0.034423972f, 88.4310532f}},
    {"N-KZFS2", 0, {1.23697554f, 0.153569376f, 0.903976272f, 0.00747170505f, 0.0308053556f, 70.1731084f}},
    {"N-KZFS4", 0, {1.35055424f, 0.197575506f, 1.09962992f, 0.0087628207f, 0.0371767201f, 90.3866994f}},
    {"N-KZFS4HT", 0, {1.35055424f, 0.197575506f, 1.09962992f, 0.0087628207f, 0.0371767201f, 90.3866994f}},
    {"N-KZFS5", 0, {1.47460789f, 0.193584488f, 1.26589974f, 0.00986143816f, 0.0445477583f, 106.436258f}},
    {"N-KZFS8", 0, {1.62693651f, 0.24369876f, 1.62007141f, 0.010880863f, 0.0494207753f, 131.009163f}},
    {"N-LAF2", 0, {1.80984227f, 0.15729555f, 1.0930037f, 0.0101711622f, 0.0442431765f, 100.687748f}},
    {"N-LAF21", 0, {1.87134529f, 0.25078301f, 1.22048639f, 0.0093332228f, 0.0345637762f, 83.2404866f}},
    {"N-LAF3", 0, {1.73155854f, 0.150874455f, 1.06586596f, 0.00953833914f, 0.0407887211f, 98.0758545f}},
    {"N-LAF32", 0, {1.91731106f, 0.224019825f, 1.22087075f, 0.00978600358f, 0.0386141473f, 84.6431265f}},
    {"N-LAF33", 0, {1.79653417f, 0.311577903f, 1.15981863f, 0.00927313493f, 0.0358201181f, 87.3448712f}},
    {"N-LAF34", 0, {1.75836958f, 0.313537785f, 1.18925231f, 0.00872810026f, 0.0293020832f, 85.1780644f}},
    {"N-LAF35", 0, {1.51697436f, 0.455875464f, 1.07469242f, 0.00750943203f, 0.0260046715f, 80.5945159f}},
    {"N-LAF36", 0, {1.85744228f, 0.294098729f, 1.16615417f, 0.00982397191f, 0.0384309138f, 89.3984634f}},
    {"N-LAF7", 0, {1.74028764f, 0.226710554f, 1.32525548f, 0.010792558f, 0.0538626639f, 106.268665f}},
    {"N-LAK10", 0, {1.72878017f, 0.169257825f, 1.19386956f, 0.00886014635f, 0.0363416509f, 82.9009069f}},
    {"N-LAK12", 0, {1.17365704f, 0.588992398f, 0.978014394f, 0.00577031797f, 0.0200401678f, 95.4873482f}},
    {"N-LAK14", 0, {1.50781212f, 0.318866829f, 1.14287213f, 0.00746098727f, 0.0242024834f, 80.9565165f}},
    {"N-LAK21", 0, {1.22718116f, 0.420783743f, 1.01284843f, 0.00602075682f, 0.0196862889f, 88.4370099f}},
    {"N-LAK22", 0, {1.14229781f, 0.535138441f, 1.04088385f, 0.00585778594f, 0.0198546147f, 100.834017f}},
    {"N-LAK33A", 0, {1.44116999f, 0.571749501f, 1.16605226f, 0.00680933877f, 0.0222291824f, 80.9379555f}},
    {"N-LAK33B", 0, {1.42288601f, 0.593661336f, 1.1613526f, 0.00670283452f, 0.021941621f, 80.7407701f}},
    {"N-LAK34", 0, {1.26661442f, 0.665919318f, 1.1249612f, 0.00589278062f, 0.0197509041f, 78.8894174f}},
    {"N-LAK7", 0, {1.23679889f, 0.445051837f, 1.01745888f, 0.00610105538f, 0.0201388334f, 90.638038f}},
    {"N-LAK8", 0, {1.33183167f, 0.546623206f, 1.19084015f, 0.00620023871f, 0.0216465439f, 82.5827736f}},
    {"N-LAK9", 0, {1.46231905f, 0.344399589f, 1.15508372f, 0.00724270156f, 0.0243353131f, 85.4686868f}},
    {"N-LASF31", 0, {1.71317198f, 0.718575109f, 1.7233247f, 0.00819172228f, 0.0297801704f, 138.461313f}},
    {"N-LASF31A", 0, {1.96485075f, 0.475231259f, 1.48360109f, 0.00982060155f, 0.0344713438f, 110.739863f}},
    {"N-LASF40", 0, {1.98550331f, 0.274057042f, 1.28945661f, 0.010958331f, 0.0474551603f, 96.9085286f}},
    {"N-LASF41", 0, {1.86348331f, 0.413307255f, 1.35784815f, 0.00910368219f, 0.0339247268f, 93.3580595f}},
    {"N-LASF43", 0, {1.93502827f, 0.23662935f, 1.26291344f, 0.0104001413f, 0.0447505292f, 87.437569f}},
    {"N-LASF44", 0, {1.78897105f, 0.38675867f, 1.30506243f, 0.00872506277f, 0.0308085023f, 92.7743824f}},
    {"N-LASF45", 0, {1.87140198f, 0.267777879f, 1.73030008f, 0.011217192f, 0.0505134972f, 147.106505f}},
    {"N-LASF45HT", 0, {1.87140198f, 0.267777879f, 1.73030008f, 0.011217192f, 0.0505134972f, 147.106505f}},
    {"N-LASF46", 0, {2.18073678f, 0.298978656f, 1.62190046f, 0.0125642118f, 0.056469999f, 105.662819f}},
    {"N-LASF46A", 0, {2.16701566f, 0.319812761f, 1.66004486f, 0.0123595524f, 0.0560610282f, 107.047718f}},
    {"N-LASF46B", 0, {2.17988922f, 0.306495184f, 1.56882437f, 0.0125805384f, 0.0567191367f, 105.316538f}},
    {"N-LASF9", 0, {2.00029547f, 0.298926886f, 1.80691843f, 0.0121426017f, 0.0538736236f, 156.530829f}},
    {"N-LASF9HT", 0, {2.00029547f, 0.298926886f, 1.80691843f, 0.0121426017f, 0.0538736236f, 156.530829f}},
    {"N-PK51", 0, {1.15610775f, 0.153229344f, 0.785618966f, 0.00585597402f, 0.0194072416f, 140.537046f}},
    {"N-PK52A", 0, {1.029607f, 0.1880506f, 0.736488165f, 0.00516800155f, 0.0166658798f, 138.964129f}},
    {"N-PSK3", 0, {0.88727211f, 0.489592425f, 1.04865296f, 0.00469824067f, 0.0161818463f, 104.374975f}},
    {"N-PSK53", 0, {1.3434087f, 0.241417935f, 0.952896897f, 0.00675074317f, 0.0219910513f, 103.551457f}},
    {"N-PSK53A", 0, {1.38121836f, 0.196745645f, 0.886089205f, 0.00706416337f, 0.0233251345f, 97.4847345f}},
    {"N-SF1", 0, {1.60865158f, 0.237725916f, 1.51530653f, 0.0119654879f, 0.0590589722f, 135.521676f}},
    {"N-SF10", 0, {1.62153902f, 0.256287842f, 1.64447552f, 0.0122241457f, 0.0595736775f, 147.468793f}},
    {"N-SF11", 0, {1.73759695f, 0.313747346f, 1.89878101f, 0.013188707f, 0.0623068142f, 155.23629f}},
    {"N-SF14", 0, {1.69022361f, 0.288870052f, 1.7045187f, 0.0130512113f, 0.061369188f, 149.517689f}},
    {"N-SF15", 0, {1.57055634f, 0.218987094f, 1.50824017f, 0.0116507014f, 0.0597856897f, 132.709339f}},
    {"N-SF19", 0, {1.52005444f, 0.17573947f, 1.43623424f, 0.01096144f, 0.0593248486f, 126.795151f}},
    {"N-SF2", 0, {1.47343127f, 0.163681849f, 1.36920899f, 0.0109019098f, 0.0585683687f, 127.404933f}},
    {"N-SF4", 0, {1.67780282f, 0.282849893f, 1.63539276f, 0.012679345f, 0.0602038419f, 145.760496f}},
    {"N-SF5", 0, {1.52481889f, 0.187085527f, 1.42729015f, 0.011254756f, 0.0588995392f, 129.141675f}},
    {"N-SF56", 0, {1.73562085f, 0.317487012f, 1.95398203f, 0.0129624742f, 0.0612884288f, 161.559441f}},
    {"N-SF57", 0, {1.87543831f, 0.37375749f, 2.30001797f, 0.0141749518f, 0.0640509927f, 177.389795f}},
    {"N-SF57HT", 0, {1.87543831f, 0.37375749f, 2.30001797f, 0.0141749518f, 0.0640509927f, 177.389795f}},
    {"N-SF57HTultra", 0, {1.87543831f, 0.37375749f, 2.30001797f, 0.0141749518f, 0.0640509927f, 177.389795f}},
    {"N-SF6", 0, {1.77931763f, 0.338149866f, 2.08734474f, 0.0133714182f, 0.0617533621f, 174.01759f}},
    {"N-SF64", 0, {1.59163762f, 0.219908428f, 1.46929315f, 0.0118623434f, 0.0594585499f, 133.310762f}},
    {"N-SF66", 0, {2.0245976f, 0.470187196f, 2.59970433f, 0.0147053225f, 0.0692998276f, 161.817601f}},
    {"N-SF6HT", 0, {1.77931763f, 0.338149866f, 2.08734474f, 0.0133714182f, 0.0617533621f, 174.01759f}},
    {"N-SF6HTultra", 0, {1.77931763f, 0.338149866f, 2.08734474f, 0.0133714182f, 0.0617533621f, 174.01759f}},
    {"N-SF8", 0, {1.55075812f, 0.209816918f, 1.46205491f, 0.0114338344f, 0.0582725652f, 133.24165f}},
    {"N-SK10", 0, {1.34972093f, 0.238587973f, 0.9667336f, 0.00736272269f, 0.0253765327f, 103.502909f}},
    {"N-SK11", 0, {1.17963631f, 0.229817295f, 0.935789652f, 0.00680282081f, 0.0219737205f, 101.513232f}},
    {"N-SK14", 0, {0.936155374f, 0.594052018f, 1.04374583f, 0.00461716525f, 0.016885927f, 103.736265f}},
    {"N-SK15", 0, {1.30417786f, 0.28584116f, 0.974781572f, 0.00695051276f, 0.0232023703f, 99.016884f}},
    {"N-SK16", 0, {1.34317774f, 0.241144399f, 0.994317969f, 0.00704687339f, 0.0229005f, 92.7508526f}},
    {"N-SK2", 0, {1.28189012f, 0.257738258f, 0.96818604f, 0.0072719164f, 0.0242823527f, 110.377773f}},
    {"N-SK2HT", 0, {1.28189012f, 0.257738258f, 0.96818604f, 0.0072719164f, 0.0242823527f, 110.377773f}},
    {"N-SK4", 0, {1.32993741f, 0.228542996f, 0.988465211f, 0.00716874107f, 0.0246455892f, 100.886364f}},
    {"N-SK5", 0, {0.991463823f, 0.495982121f, 0.987393925f, 0.00522730467f, 0.0172733646f, 98.3594579f}},
    {"N-SSK2", 0, {1.4306027f, 0.153150554f, 1.01390904f, 0.00823982975f, 0.0333736841f, 106.870822f}},
    {"N-SSK5", 0, {1.59222659f, 0.103520774f, 1.05174016f, 0.00920284626f, 0.0423530072f, 106.927374f}},
    {"N-SSK8", 0, {1.44857867f, 0.117965926f, 1.06937528f, 0.00869310149f, 0.0421566593f, 111.300666f}},
    {"N-ZK7", 0, {1.07715032f, 0.168079109f, 0.851889892f, 0.00676601657f, 0.0230642817f, 89.0498778f}},
    {"N-ZK7A", 0, {1.07509891f, 0.168895044f, 0.860503983f, 0.00676601657f, 0.0230642817f, 89.0498778f}},
    {"P-BK7", 0, {1.18318503f, 0.0871756426f, 1.03133701f, 0.00722141956f, 0.0268216805f, 101.702362f}},
    {"P-LAF37", 0, {1.76003244f, 0.248286745f, 1.15935122f, 0.00938006396f, 0.0360537464f, 86.4324693f}},
    {"P-LAK35", 0, {1.3932426f, 0.418882766f, 1.043807f, 0.00715959695f, 0.0233637446f, 88.3284426f}},
    {"P-LASF47", 0, {1.85543101f, 0.315854649f, 1.28561839f, 0.0100328203f, 0.0387095168f, 94.5421507f}},
    {"P-LASF50", 0, {1.84910553f, 0.329828674f, 1.30400901f, 0.00999234757f, 0.0387437988f, 95.8967681f}},
    {"P-LASF51", 0, {1.84568806f, 0.3390016f, 1.32418921f, 0.00988495571f, 0.0378097402f, 97.841543f}},
    {"P-PK53", 0, {0.960316767f, 0.340437227f, 0.777865595f, 0.00531032986f, 0.0175073434f, 106.87533f}},
    {"P-SF67", 0, {1.97464225f, 0.467095921f, 2.43154209f, 0.0145772324f, 0.0669790359f, 157.444895f}},
    {"P-SF68", 0, {2.3330067f, 0.452961396f, 1.25172339f, 0.0168838419f, 0.0716086325f, 118.707479f}},
    {"P-SF69", 0, {1.62594647f, 0.235927609f, 1.67434623f, 0.0121696677f, 0.0600710405f, 145.651908f}},
    {"P-SF8", 0, {1.55370411f, 0.206332561f, 1.39708831f, 0.011658267f, 0.0582087757f, 130.748028f}},
    {"P-SK57", 0, {1.31053414f, 0.169376189f, 1.10987714f, 0.00740877235f, 0.0254563489f, 107.751087f}},
    {"P-SK57Q1", 0, {1.30536483f, 0.171434328f, 1.10117219f, 0.00736408831f, 0.0255786047f, 106.72606f}},
    {"P-SK58A", 0, {1.3167841f, 0.171154756f, 1.12501473f, 0.00720717498f, 0.0245659595f, 102.739728f}},
    {"P-SK60", 0, {1.40790442f, 0.143381417f, 1.16513947f, 0.00784382378f, 0.0287769365f, 105.373397f}},
    {"SF1", 0, {1.55912923f, 0.284246288f, 0.968842926f, 0.0121481001f, 0.0534549042f, 112.174809f}},
    {"SF10", 0, {1.61625977f, 0.259229334f, 1.07762317f, 0.0127534559f, 0.0581983954f, 116.60768f}},
    {"SF11", 0, {1.73848403f, 0.311168974f, 1.17490871f, 0.0136068604f, 0.0615960463f, 121.922711f}},
    {"SF14", 0, {1.69182538f, 0.285919934f, 1.12595145f, 0.0133151542f, 0.0612647445f, 118.405242f}},
    {"SF15", 0, {1.53925927f, 0.247620926f, 1.03816409f, 0.0119307961f, 0.0556077536f, 116.416747f}},
    {"SF2", 0, {1.40301821f, 0.231767504f, 0.939056586f, 0.0105795466f, 0.0493226978f, 112.405955f}},
    {"SF4", 0, {1.61957826f, 0.339493189f, 1.02566931f, 0.0125502104f, 0.0544559822f, 117.652222f}},
    {"SF5", 0, {1.46141885f, 0.247713019f, 0.949995832f, 0.0111826126f, 0.0508594669f, 112.041888f}},
    {"SF56A", 0, {1.70579259f, 0.344223052f, 1.09601828f, 0.0133874699f, 0.0579561608f, 121.616024f}},
    {"SF57", 0, {1.81651371f, 0.428893641f, 1.07186278f, 0.0143704198f, 0.0592801172f, 121.419942f}},
    {"SF57HTultra", 0, {1.81651371f, 0.428893641f, 1.07186278f, 0.0143704198f, 0.0592801172f, 121.419942f}},
    {"SF6", 0, {1.72448482f, 0.390104889f, 1.04572858f, 0.0134871947f, 0.0569318095f, 118.557185f}},
    {"SF66", 0, {2.07842233f, 0.407120032f, 1.76711292f, 0.0180875134f, 0.0679493572f, 215.266127f}},
    {"SF6G05", 0, {1.62113942f, 0.506586092f, 10.4032298f, 0.0113478992f, 0.0535840223f, 1118.83658f}},
    {"SFL57", 0, {1.88742326f, 0.360534025f, 2.26189313f, 0.0145939341f, 0.0648198946f, 176.062211f}},
    {"SFL6", 0, {1.78922056f, 0.328427448f, 2.01639441f, 0.0135163537f, 0.0622729599f, 168.014713f}},
    {"BAH32", 1, {1.498643f, 0.2175678f, 1.559728f, 0.009643255f, 0.04511666f, 171.1121f}},
    {"BAL15Y", 1, {1.28348331f, 0.102800765f, 0.404609885f, 0.00790900515f, 0.0305971274f, 46.5268356f}},
    {"BAL35Y", 1, {1.26231429f, 0.22515421f, 0.639119345f, 0.00695586355f, 0.0221310699f, 63.1662736f}},
    {"BAM3", 1, {1.264742f, 0.189784f, 1.105094f, 0.007911881f, 0.03806705f, 133.8316f}},
    {"BPH5", 1, {1.44845677f, 0.22044806f, 0.99476362f, 0.0092817361f, 0.0433001987f, 77.6475264f}},
    {"BPH8", 1, {1.59323023f, 0.277775516f, 1.04070526f, 0.0103458172f, 0.0474089271f, 81.2863792f}},
    {"BPM51", 1, {1.37436455f, 0.174025602f, 0.905485504f, 0.00877165624f, 0.0405249716f, 72.7685343f}},
    {"BSL7Y", 1, {1.13329383f, 0.136897201f, 0.703456004f, 0.00669407868f, 0.023739176f, 70.7030316f}},
    {"BSM22", 1, {1.35097f, 0.2324447f, 1.179f, 0.007454835f, 0.02949403f, 131.6202f}},
    {"BSM51Y", 1, {1.22393171f, 0.306482383f, 0.823950901f, 0.00649521083f, 0.0208194161f, 79.5168951f}},
    {"BSM9", 1, {1.095086f, 0.4642304f, 1.203056f, 0.005354893f, 0.02206781f, 133.3129f}},
    {"L-BAL35", 1, {1.1626263f, 0.325661051f, 1.35132486f, 0.0125957437f, -0.0032691105f, 119.214596f}},
    {"L-BAL35P", 1, {0.806742194f, 0.690488648f, 1.26477947f, 0.0148836231f, 0.00251943058f, 111.31457f}},
    {"L-BAL42", 1, {1.39528097f, 0.072551952f, 1.66335848f, 0.011186203f, -0.0246748575f, 167.717958f}},
    {"L-BAL42P", 1, {0.881090017f, 0.595038859f, 1.22582098f, 0.0148496655f, 0.00163577371f, 125.11372f}},
    {"L-BAL43", 1, {1.04745291f, 0.428452873f, 1.14111303f, 0.00563209756f, 0.0188321416f, 114.197069f}},
    {"L-BBH1", 1, {2.56597628f, 0.526892298f, 1.27957402f, 0.0205164012f, 0.0831737967f, 109.78774f}},
    {"L-BBH2", 1, {2.53279005f, 0.583375125f, 1.5299288f, 0.0186909889f, 0.0765409078f, 112.197368f}},
    {"L-BSL7", 1, {0.917473918f, 0.352687665f, 1.05579788f, 0.00527701411f, 0.0170809497f, 104.302583f}},
    {"L-LAH53", 1, {1.87409991f, 0.297921402f, 1.35064285f, 0.00993318344f, 0.0405501825f, 100.5022f}},
    {"L-LAH81", 1, {1.89927344f, 0.270978866f, 1.33163819f, 0.0102901828f, 0.0424227173f, 100.967566f}},
    {"L-LAH83", 1, {1.82331579f, 0.548625885f, 1.63182855f, 0.00911468875f, 0.032841967f, 123.611174f}},
    {"L-LAH84", 1, {1.83606127f, 0.341720032f, 1.35280173f, 0.00981969903f, 0.0385636264f, 107.04553f}},
    {"L-LAH84P", 1, {1.83485816f, 0.355717498f, 1.37757002f, 0.009788482f, 0.03837087f, 109.71692f}},
    {"L-LAH85", 1, {1.93889988f, 0.39787919f, 1.49937713f, 0.00996381644f, 0.036975114f, 107.951467f}},
    {"L-LAH85V", 1, {1.97460503f, 0.361903592f, 1.38433241f, 0.0101854258f, 0.0384829118f, 103.713627f}},
    {"L-LAH86", 1, {2.11102709f, 0.370368094f, 1.62687484f, 0.0120714135f, 0.0532464416f, 109.166396f}},
    {"L-LAH87", 1, {1.44196269f, 0.617507311f, 1.21890079f, 0.00731826717f, 0.0245370775f, 105.976009f}},
    {"L-LAH90", 1, {1.97595301f, 0.283924985f, 1.35176368f, 0.0104276395f, 0.0427708222f, 101.45371f}},
    {"L-LAH91", 1, {1.26144128f, 0.782115273f, 1.15823645f, 0.00572512582f, 0.0219829752f, 88.04822f}},
    {"L-LAH94", 1, {2.0062142f, 0.347029888f, 1.41688382f, 0.0105499238f, 0.0445845013f, 105.99525f}},
    {"L-LAL12", 1, {1.28516283f, 0.478333797f, 1.21605301f, 0.00641062082f, 0.0214815099f, 100.243378f}},
    {"L-LAL13", 1, {1.17776146f, 0.634591345f, 1.20435649f, 0.00557618243f, 0.0206821469f, 99.6322776f}},
    {"L-LAL15", 1, {1.07959634f, 0.731872134f, 1.17111107f, 0.00470047543f, 0.0198615758f, 87.03599f}},
    {"L-LAM60", 1, {1.47574184f, 0.496132743f, 1.23796236f, 0.0073695f, 0.0251891746f, 98.0306651f}},
    {"L-LAM69", 1, {1.7403896f, 0.176996917f, 1.76775413f, 0.010339887f, 0.0484822765f, 136.671996f}},
    {"L-LAM72", 1, {1.50483297f, 0.433346414f, 1.2714921f, 0.0075034233f, 0.026900952f, 95.7631272f}},
    {"L-NBH54", 1, {2.00722652f, 0.442086773f, 3.37287426f, 0.0135705124f, 0.0591808873f, 219.832665f}},
    {"L-PHL1", 1, {1.07570798f, 0.335020347f, 0.810997558f, 0.00591654042f, 0.0203432769f, 106.182158f}},
    {"L-PHL2", 1, {1.08137176f, 0.31325766f, 0.879192863f, 0.00594210177f, 0.0198011567f, 109.893817f}},
    {"L-TIH53", 1, {1.83464643f, 0.415079602f, 2.82563492f, 0.0134992001f, 0.0618608854f, 201.62917f}},
    {"L-TIM28", 1, {1.52780829f, 0.232776367f, 1.71638781f, 0.0114135883f, 0.0559068566f, 171.5118f}},
    {"L-TIM28P", 1, {1.53013396f, 0.24536228f, 1.78233031f, 0.0114236857f, 0.0555101852f, 179.0743f}},
    {"LAH78", 1, {2.08122726f, 0.398632407f, 2.21679491f, 0.011190641f, 0.0521753272f, 141.893166f}},
    {"LAH80", 1, {2.06636247f, 0.349315832f, 1.91746463f, 0.0122133846f, 0.0555959908f, 125.47362f}},
    {"LAL58", 1, {1.53415f, 0.2744946f, 1.210527f, 0.008014497f, 0.03023701f, 118.7442f}},
    {"LAM58", 1, {1.704423f, 0.1778568f, 1.425726f, 0.01024939f, 0.04576819f, 153.5267f}},
    {"LAM59", 1, {1.626945f, 0.1906681f, 1.281079f, 0.008757497f, 0.03779724f, 123.7784f}},
    {"LAM61", 1, {1.706024f, 0.182716f, 1.204833f, 0.009579771f, 0.04044097f, 127.571f}},
    {"LAM7", 1, {1.734192f, 0.2314896f, 1.517096f, 0.01110755f, 0.05153277f, 163.4134f}},
    {"PBH1", 1, {1.55408138f, 0.289397861f, 1.06727944f, 0.0120146818f, 0.0532883208f, 122.863029f}},
    {"PBH3", 1, {1.59470208f, 0.317791814f, 1.29219485f, 0.0122277091f, 0.0544975824f, 147.63368f}},
    {"PBH55", 1, {1.81022611f, 0.447772917f, 1.12017569f, 0.013972897f, 0.0582195245f, 120.984115f}},
    {"PBH56", 1, {1.78552677f, 0.446684871f, 1.21749317f, 0.0136046011f, 0.0570875152f, 129.967536f}},
    {"PBH71", 1, {1.97039844f, 0.520330498f, 1.30696186f, 0.0155780448f, 0.0632642123f, 142.045097f}},
    {"PBL1Y", 1, {1.24772961f, 0.101954909f, 0.350479619f, 0.00926606623f, 0.0451754311f, 45.0186705f}},
    {"PBL25Y", 1, {1.31960626f, 0.123752633f, 0.210055351f, 0.0101863415f, 0.0483593508f, 27.3272029f}},
    {"PBL26", 1, {1.23494993f, 0.169136142f, 1.09067013f, 0.00862847509f, 0.0422686058f, 132.796906f}},
    {"PBL26Y", 1, {1.29471773f, 0.108880981f, 0.220322964f, 0.00986579479f, 0.0477568828f, 28.8509863f}},
    {"PBL35Y", 1, {1.31884698f, 0.125014653f, 0.215794324f, 0.0101474939f, 0.0481636043f, 28.5517448f}},
    {"PBL6Y", 1, {1.22310794f, 0.0811217929f, 0.321400939f, 0.00897805333f, 0.0445756957f, 40.5962247f}},
    {"PBM18Y", 1, {1.34660215f, 0.136322343f, 0.183371587f, 0.0106313733f, 0.0491403013f, 23.9154655f}},
    {"PBM2Y", 1, {1.39446503f, 0.159230985f, 0.245470216f, 0.0110571872f, 0.0507194882f, 31.4440142f}},
    {"PBM3", 1, {1.32567543f, 0.208112474f, 1.15985207f, 0.00973013804f, 0.046285933f, 137.559854f}},
    {"PBM8Y", 1, {1.35351322f, 0.130212912f, 0.158337266f, 0.0105624626f, 0.0496606652f, 20.7965806f}},
    {"S-BAH10", 1, {1.59034337f, 0.138464579f, 1.21988043f, 0.0093273434f, 0.0427498654f, 119.251777f}},
    {"S-BAH11", 1, {1.5713886f, 0.147869313f, 1.28092846f, 0.00910807936f, 0.0402401684f, 130.399367f}},
    {"S-BAH27", 1, {1.68939052f, 0.133081013f, 1.41165515f, 0.0103598193f, 0.0533982239f, 126.515503f}},
    {"S-BAH28", 1, {1.69493484f, 0.192890298f, 1.56385948f, 0.010272319f, 0.052118764f, 137.818035f}},
    {"S-BAH32", 1, {1.5802363f, 0.137504632f, 1.60603298f, 0.0103578062f, 0.0548393088f, 147.982885f}},
    {"S-BAL11", 1, {0.821314256f, 0.612586478f, 1.24859637f, 0.00351436131f, 0.0179762375f, 133.45667f}},
    {"S-BAL12", 1, {0.714605258f, 0.621993289f, 1.22537681f, 0.00301763913f, 0.016650545f, 143.506314f}},
    {"S-BAL14", 1, {1.27553696f, 0.146083393f, 1.16754699f, 0.00749692359f, 0.031042153f, 128.947092f}},
    {"S-BAL2", 1, {1.30923813f, 0.114137353f, 1.17882259f, 0.00838873953f, 0.0399436485f, 140.257892f}},
    {"S-BAL22", 1, {1.16333541f, 0.26332321f, 1.12551059f, 0.0118079103f, -0.00438112893f, 106.905682f}},
    {"S-BAL3", 1, {1.2936689f, 0.132440252f, 1.10197293f, 0.00800367962f, 0.0354711196f, 134.517431f}},
    {"S-BAL35", 1, {0.941357273f, 0.546174895f, 1.16168917f, 0.0140333996f, 0.000906635683f, 114.163758f}},
    {"S-BAL41", 1, {1.243442f, 0.166301104f, 1.10586114f, 0.0116396708f, -0.00890464938f, 114.11122f}},
    {"S-BAL42", 1, {1.39570615f, 0.071850507f, 1.27129267f, 0.0112218843f, -0.0252117422f, 134.49786f}},
    {"S-BAM12", 1, {1.50161605f, 0.126987445f, 1.43544052f, 0.00940761826f, 0.0472602195f, 141.666499f}},
    {"S-BAM3", 1, {1.36955358f, 0.0853825867f, 1.16159771f, 0.00941331434f, 0.0504359027f, 130.548899f}},
    {"S-BAM4", 1, {1.41059317f, 0.111201306f, 1.34148939f, 0.00963312192f, 0.049877821f, 152.237696f}},
    {"S-BSL7", 1, {1.1515019f, 0.118583612f, 1.26301359f, 0.010598413f, -0.011822519f, 129.617662f}},
    {"S-BSM10", 1, {0.945443081f, 0.643237376f, 1.17752968f, 0.0157263798f, 0.00161924066f, 121.361748f}},
    {"S-BSM14", 1, {1.2828627f, 0.247647429f, 1.10383999f, 0.0122902399f, -0.00613142361f, 106.883378f}},
    {"S-BSM15", 1, {0.953128328f, 0.637613977f, 1.65245647f, 0.00387638985f, 0.0185094632f, 159.442367f}},
    {"S-BSM16", 1, {1.14490383f, 0.439563911f, 1.27688079f, 0.0137034916f, -0.00186514205f, 119.535585f}},
    {"S-BSM18", 1, {0.927886025f, 0.708858526f, 1.18610897f, 0.00417549199f, 0.0184691838f, 122.210416f}},
    {"S-BSM2", 1, {0.867168676f, 0.672848343f, 1.18456107f, 0.00369311003f, 0.0181652804f, 132.376147f}},
    {"S-BSM21", 1, {1.47867898f, 0.0899501399f, 1.03056525f, 0.00869705653f, 0.0399353993f, 108.550949f}},
    {"S-BSM22", 1, {1.44305741f, 0.140786358f, 1.26093951f, 0.0081920891f, 0.0356911455f, 131.959337f}},
    {"S-BSM25", 1, {1.34814257f, 0.347530319f, 1.38798368f, 0.00695364366f, 0.0277863478f, 142.138122f}},
    {"S-BSM28", 1, {1.43822841f, 0.128100017f, 1.3435553f, 0.0085977975f, 0.0408617854f, 143.70989f}},
    {"S-BSM4", 1, {0.96244308f, 0.595939234f, 1.10558352f, 0.00468062141f, 0.0178772082f, 115.896432f}},
    {"S-BSM71", 1, {1.50847885f, 0.158099826f, 1.36815368f, 0.00812769076f, 0.0354200898f, 136.110038f}},
    {"S-BSM81", 1, {0.996356844f, 0.651392837f, 1.22432622f, 0.0144821587f, 0.00154826389f, 89.9818604f}},
    {"S-BSM9", 1, {1.37020077f, 0.189397267f, 1.24202324f, 0.00757631457f, 0.0300787515f, 131.350111f}},
    {"S-FPL51", 1, {1.17010505f, 0.0475710783f, 0.763832445f, 0.00616203924f, 0.0263372876f, 141.882642f}},
    {"S-FPL51Y", 1, {1.14031443f, 0.0771496272f, 1.43721957f, 0.00595466872f, 0.0223953953f, 274.290057f}},
    {"S-FPL52", 1, {1.06785857f, 0.0335857718f, 1.10219763f, 0.00699227302f, -0.0207608925f, 226.496541f}},
    {"S-FPL53", 1, {0.983532327f, 0.069568814f, 1.11409238f, 0.00492234955f, 0.0193581091f, 264.275294f}},
    {"S-FPL55", 1, {0.839067682f, 0.214083503f, 1.47914677f, 0.00795286639f, -0.00232581717f, 340.0437f}},
    {"S-FPM2", 1, {0.761242785f, 0.747033375f, 0.938928947f, 0.00321174095f, 0.0140234423f, 139.52353f}},
    {"S-FPM3", 1, {0.809407286f, 0.527007033f, 0.909127704f, 0.00376072389f, 0.0135654895f, 142.503612f}},
    {"S-FSL5", 1, {1.17447043f, 0.0140056154f, 1.19272435f, 0.00841855181f, -0.0581790767f, 129.599726f}},
    {"S-FSL5Y", 1, {0.977409944f, 0.210950834f, 1.37142848f, 0.00557649364f, 0.0177000313f, 149.211443f}},
    {"S-FTL10", 1, {1.10542993f, 0.116184325f, 1.15396111f, 0.00669004168f, 0.0360840691f, 137.546485f}},
    {"S-FTM16", 1, {1.32940907f, 0.141512125f, 1.44299068f, 0.0102377287f, 0.0578081956f, 150.597139f}},
    {"S-LAH51", 1, {1.82586991f, 0.283023349f, 1.35964319f, 0.00935297152f, 0.0373803057f, 100.655798f}},
    {"S-LAH52", 1, {1.85390925f, 0.297925555f, 1.39382086f, 0.00955320687f, 0.039381685f, 102.706848f}},
    {"S-LAH52Q", 1, {1.91082318f, 0.239854589f, 1.16159733f, 0.0103565352f, 0.0413805081f, 96.60373f}},
    {"S-LAH53", 1, {1.91811619f, 0.253724399f, 1.39473885f, 0.0102147684f, 0.0433176011f, 101.938021f}},
    {"S-LAH53V", 1, {1.96600955f, 0.205143305f, 1.23200934f, 0.0107817785f, 0.0463727869f, 97.69406f}},
    {"S-LAH55", 1, {1.95615766f, 0.319216215f, 1.39173189f, 0.00979338965f, 0.0376836296f, 94.8775271f}},
    {"S-LAH55V", 1, {1.97025325f, 0.30489414f, 1.39214665f, 0.00991088134f, 0.0383202295f, 97.7785249f}},
    {"S-LAH55VS", 1, {1.92591095f, 0.34895346f, 1.42230744f, 0.0096115249f, 0.036513298f, 103.36409f}},
    {"S-LAH58", 1, {1.78764964f, 0.6526356f, 1.79914564f, 0.00847378536f, 0.0313126408f, 132.788001f}},
    {"S-LAH59", 1, {1.51372967f, 0.702462343f, 1.33600982f, 0.00705246901f, 0.0249488689f, 100.085908f}},
    {"S-LAH60", 1, {1.95243469f, 0.30710021f, 1.56578094f, 0.0106442437f, 0.0456735302f, 110.28141f}},
    {"S-LAH60V", 1, {2.05081962f, 0.208475257f, 1.31486394f, 0.0116035991f, 0.0526489359f, 99.38065f}},
    {"S-LAH63", 1, {1.89458276f, 0.268702978f, 1.45705526f, 0.0102277048f, 0.0442801243f, 104.874927f}},
    {"S-LAH63Q", 1, {1.96723017f, 0.194953915f, 1.25386282f, 0.0110456086f, 0.0497137061f, 104.84352f}},
    {"S-LAH64", 1, {1.83021453f, 0.29156359f, 1.28544024f, 0.0090482329f, 0.0330756689f, 89.3675501f}},
    {"S-LAH65", 1, {1.68191258f, 0.493779818f, 1.45682822f, 0.0077668425f, 0.0288916181f, 99.2574356f}},
    {"S-LAH65V", 1, {1.81419034f, 0.361376301f, 1.32729484f, 0.00874935029f, 0.0318352836f, 91.3406898f}},
    {"S-LAH65VS", 1, {1.76068422f, 0.414128906f, 1.33415439f, 0.00853607198f, 0.0301826383f, 98.09421f}},
    {"S-LAH66", 1, {1.39280586f, 0.679577094f, 1.38702069f, 0.00608475118f, 0.0233925351f, 95.8354094f}},
    {"S-LAH71", 1, {1.98280031f, 0.31675845f, 2.44472646f, 0.0118987456f, 0.0527156001f, 213.220697f}},
    {"S-LAH79", 1, {2.32557148f, 0.507967133f, 2.43087198f, 0.0132895208f, 0.0528335449f, 161.122408f}},
    {"S-LAH88", 1, {2.1284434f, 0.405082139f, 1.67918461f, 0.0117309815f, 0.0508706599f, 107.091456f}},
    {"S-LAH89", 1, {1.95118827f, 0.377607223f, 1.47757262f, 0.00976560799f, 0.0382232043f, 112.23672f}},
    {"S-LAH92", 1, {2.10440311f, 0.358346161f, 1.63010064f, 0.0108531811f, 0.044340592f, 123.2498f}},
    {"S-LAH93", 1, {2.17884378f, 0.325508683f, 1.70608646f, 0.0115760879f, 0.0495982503f, 128.91358f}},
    {"S-LAH95", 1, {2.15636617f, 0.329558178f, 1.72178935f, 0.012288051f, 0.0555507835f, 124.43934f}},
    {"S-LAH96", 1, {1.85078519f, 0.189204854f, 1.19763137f, 0.00940657541f, 0.0380345187f, 101.426835f}},
    {"S-LAH97", 1, {1.0273018f, 0.989293564f, 1.25781057f, 0.0183406129f, 0.00371264195f, 87.85105f}},
    {"S-LAL10", 1, {1.52812575f, 0.367965267f, 1.11751784f, 0.00776817644f, 0.0272026548f, 88.86974f}},
    {"S-LAL12", 1, {0.992053895f, 0.771377731f, 1.18296264f, 0.0167095063f, 0.00236750156f, 105.90108f}},
    {"S-LAL13", 1, {0.980071267f, 0.832904776f, 1.28111995f, 0.00389123698f, 0.0189164592f, 98.9052676f}},
    {"S-LAL14", 1, {1.2372097f, 0.589722623f, 1.3192188f, 0.015355132f, -0.00030789625f, 93.7202947f}},
    {"S-LAL18", 1, {1.50276318f, 0.430224497f, 1.3472606f, 0.0145462356f, -0.00332784153f, 93.3508342f}},
    {"S-LAL19", 1, {0.973997577f, 0.958186322f, 1.20163359f, 0.00379332678f, 0.0177574581f, 83.79896f}},
    {"S-LAL20", 1, {1.06788467f, 0.75873535f, 1.02804682f, 0.00518896058f, 0.0204004357f, 120.82632f}},
    {"S-LAL54", 1, {1.41910189f, 0.258416881f, 1.07385537f, 0.00726647428f, 0.0263842499f, 102.555463f}},
    {"S-LAL54Q", 1, {0.920085087f, 0.758646115f, 1.07073096f, 0.0160829667f, 0.00292059306f, 85.12112f}},
    {"S-LAL56", 1, {1.54052f, 0.217748704f, 1.30456122f, 0.00826765101f, 0.0328533726f, 124.527479f}},
    {"S-LAL58", 1, {1.06368789f, 0.744939067f, 1.59178942f, 0.018519964f, 0.00116295862f, 156.636025f}},
    {"S-LAL59", 1, {1.13962742f, 0.805227838f, 1.29488061f, 0.00493294862f, 0.020247996f, 93.4746507f}},
    {"S-LAL61", 1, {1.11073292f, 0.859347773f, 1.26707433f, 0.00464181248f, 0.0192989261f, 87.3917698f}},
    {"S-LAL7", 1, {0.916121247f, 0.765948319f, 1.27745023f, 0.00395889743f, 0.0167547425f, 110.762706f}},
    {"S-LAL8", 1, {1.30663291f, 0.571377253f, 1.24303605f, 0.00611862448f, 0.021272147f, 90.6285686f}},
    {"S-LAL9", 1, {1.16195687f, 0.644860099f, 1.25062221f, 0.0159659509f, 0.000505502467f, 93.8284169f}},
    {"S-LAM2", 1, {1.7713f, 0.19581423f, 1.19487834f, 0.00976652444f, 0.0412718628f, 110.458122f}},
    {"S-LAM3", 1, {1.64258713f, 0.23963461f, 1.22483026f, 0.0086824602f, 0.0351226242f, 116.604369f}},
    {"S-LAM51", 1, {1.638472f, 0.188330533f, 1.47502357f, 0.00904853452f, 0.0372740173f, 137.77005f}},
    {"S-LAM52", 1, {1.73442942f, 0.15155391f, 1.46225433f, 0.0100690928f, 0.0470634701f, 140.084396f}},
    {"S-LAM54", 1, {1.84213306f, 0.175468631f, 1.25750878f, 0.0094399322f, 0.0395281122f, 86.5463013f}},
    {"S-LAM55", 1, {1.85412979f, 0.165450323f, 1.27255422f, 0.0108438152f, 0.051405098f, 109.986837f}},
    {"S-LAM58", 1, {1.70984856f, 0.173342897f, 1.64833565f, 0.0100852127f, 0.0470890831f, 157.46852f}},
    {"S-LAM59", 1, {1.63056133f, 0.186994897f, 1.30014289f, 0.00899690705f, 0.0368011993f, 122.239544f}},
    {"S-LAM60", 1, {1.60673056f, 0.36641564f, 1.31761804f, 0.0077504614f, 0.0289967611f, 93.0720709f}},
    {"S-LAM61", 1, {1.7388333f, 0.15093743f, 1.12118445f, 0.00980244105f, 0.0433179685f, 101.214625f}},
    {"S-LAM66", 1, {1.92094221f, 0.219901208f, 1.72705231f, 0.0115075241f, 0.0547993543f, 120.133674f}},
    {"S-LAM7", 1, {1.71014712f, 0.256943292f, 1.63986271f, 0.010516108f, 0.0502809636f, 146.181217f}},
    {"S-LAM73", 1, {1.86353123f, 0.255215617f, 1.23399133f, 0.0107620673f, 0.0487248679f, 117.12511f}},
    {"S-NBH5", 1, {1.47544521f, 0.193060095f, 1.5093901f, 0.0095583674f, 0.0460430483f, 126.422746f}},
    {"S-NBH51", 1, {1.71203689f, 0.255989588f, 1.81456998f, 0.0107724134f, 0.0488593504f, 136.359013f}},
    {"S-NBH52", 1, {1.50305799f, 0.221715926f, 1.84496391f, 0.00999021738f, 0.0450327698f, 163.722302f}},
    {"S-NBH52V", 1, {1.51336868f, 0.212341478f, 1.54149143f, 0.00987077827f, 0.0462843662f, 126.97851f}},
    {"S-NBH53", 1, {1.6582834f, 0.263275666f, 2.10142759f, 0.0113872516f, 0.0522108137f, 165.523649f}},
    {"S-NBH53V", 1, {1.65444141f, 0.267453927f, 2.14530347f, 0.0112485533f, 0.052027274f, 167.3661f}},
    {"S-NBH55", 1, {1.83145156f, 0.287818024f, 2.152083f, 0.0122443139f, 0.057387731f, 186.099124f}},
    {"S-NBH56", 1, {1.85191438f, 0.431102852f, 3.45278284f, 0.013273262f, 0.0585944644f, 239.357089f}},
    {"S-NBH57", 1, {1.92026488f, 0.37153524f, 2.55205704f, 0.0118468028f, 0.0532105472f, 204.5493f}},
    {"S-NBH8", 1, {1.61344136f, 0.257295888f, 1.98364455f, 0.0106386752f, 0.0487071624f, 159.784404f}},
    {"S-NBM51", 1, {1.37023101f, 0.177665568f, 1.30515471f, 0.00871920342f, 0.0405725552f, 112.703058f}},
    {"S-NPH1", 1, {1.75156623f, 0.364006304f, 2.47874141f, 0.0135004681f, 0.0668245147f, 170.756006f}},
    {"S-NPH1W", 1, {1.75156623f, 0.364006304f, 2.47874141f, 0.0135004681f, 0.0668245147f, 170.756006f}},
    {"S-NPH2", 1, {2.0386951f, 0.437269641f, 2.96711461f, 0.0170796224f, 0.0749254813f, 174.155354f}},
    {"S-NPH3", 1, {2.09834903f, 0.489088388f, 2.94009268f, 0.0179123869f, 0.0776653353f, 160.930428f}},
    {"S-NPH4", 1, {1.93563931f, 0.449596478f, 2.71828573f, 0.0152585289f, 0.0696815778f, 170.327149f}},
    {"S-NPH5", 1, {1.89108996f, 0.395220126f, 2.20492127f, 0.0141164499f, 0.0662834445f, 148.6807f}},
    {"S-NPH53", 1, {1.85484904f, 0.396194484f, 2.43512461f, 0.0134621486f, 0.0631945361f, 170.864886f}},
    {"S-NSL2", 1, {0.951239368f, 0.313094652f, 1.70928507f, 0.00513091895f, 0.0231960516f, 201.539573f}},
    {"S-NSL3", 1, {0.882514764f, 0.389271907f, 1.10693448f, 0.00464504582f, 0.0200551397f, 136.234339f}},
    {"S-NSL36", 1, {1.09666153f, 0.168990073f, 1.20580827f, 0.00667491123f, 0.033609545f, 141.668738f}},
    {"S-NSL5", 1, {1.04574577f, 0.239613026f, 1.1590685f, 0.0058523228f, 0.0236858752f, 131.329061f}},
    {"S-PHM52", 1, {1.0996655f, 0.478125422f, 1.13214074f, 0.0132718559f, -0.000601649685f, 130.595472f}},
    {"S-PHM53", 1, {1.09775423f, 0.434816432f, 1.13894976f, 0.01233694f, -0.000372522903f, 124.276984f}},
    {"S-TIH1", 1, {1.60326759f, 0.242980935f, 1.81313592f, 0.0118019139f, 0.0591363658f, 161.218747f}},
    {"S-TIH10", 1, {1.61549392f, 0.262433239f, 2.09426189f, 0.0119830897f, 0.059651024f, 181.657554f}},
    {"S-TIH11", 1, {1.72677471f, 0.324568628f, 2.65816809f, 0.0129369958f, 0.0618255245f, 221.904637f}},
    {"S-TIH13", 1, {1.62224674f, 0.293844589f, 1.99225164f, 0.0118368386f, 0.0590208025f, 171.959976f}},
    {"S-TIH14", 1, {1.68915108f, 0.290462024f, 2.37971516f, 0.0128202514f, 0.0618090841f, 201.094352f}},
    {"S-TIH18", 1, {1.59921608f, 0.259532164f, 2.12454543f, 0.0116469304f, 0.0584824883f, 186.927779f}},
    {"S-TIH20", 1, {1.59255052f, 0.218805922f, 1.60254262f, 0.0119420495f, 0.0592770292f, 143.961778f}},
    {"S-TIH23", 1, {1.73986485f, 0.313894918f, 2.31093206f, 0.01294413f, 0.0612116868f, 197.420482f}},
    {"S-TIH3", 1, {1.64797648f, 0.267261917f, 2.19772845f, 0.0121917693f, 0.0597893039f, 192.15834f}},
    {"S-TIH4", 1, {1.66755531f, 0.294411865f, 2.49422119f, 0.0122052137f, 0.0597775329f, 214.869618f}},
    {"S-TIH53", 1, {1.87904886f, 0.369719775f, 2.33730863f, 0.014412177f, 0.063881799f, 182.66818f}},
    {"S-TIH53W", 1, {1.87904886f, 0.369719775f, 2.33730863f, 0.014412177f, 0.063881799f, 182.66818f}},
    {"S-TIH57", 1, {2.21103256f, 0.450346986f, 2.47746663f, 0.0142330268f, 0.0638573392f, 161.9376f}},
    {"S-TIH6", 1, {1.77227611f, 0.34569125f, 2.40788501f, 0.0131182633f, 0.0614479619f, 200.753254f}},
    {"S-TIL1", 1, {1.25088944f, 0.0997973327f, 1.20583504f, 0.00883921279f, 0.0482685052f, 137.414953f}},
    {"S-TIL2", 1, {1.23401499f, 0.0959796833f, 1.20503991f, 0.00869507801f, 0.0465611429f, 137.953301f}},
    {"S-TIL25", 1, {1.32122534f, 0.123824976f, 1.43685254f, 0.00952091436f, 0.0516062665f, 149.064883f}},
    {"S-TIL26", 1, {1.31066488f, 0.0941903094f, 1.23292644f, 0.00968897812f, 0.0527763106f, 133.296422f}},
    {"S-TIL27", 1, {1.31433154f, 0.112300168f, 1.413901f, 0.00950404477f, 0.0524112772f, 148.429972f}},
    {"S-TIL6", 1, {1.17701777f, 0.12795803f, 1.34740124f, 0.00771087686f, 0.0411325328f, 154.531692f}},
    {"S-TIM1", 1, {1.4496383f, 0.122986408f, 1.38066723f, 0.0112094282f, 0.059626577f, 138.178326f}},
    {"S-TIM2", 1, {1.42193846f, 0.133827968f, 1.45060574f, 0.0107291511f, 0.0572587546f, 145.381805f}},
    {"S-TIM22", 1, {1.44222294f, 0.194432265f, 1.74092482f, 0.0104249404f, 0.0550235257f, 169.710769f}},
    {"S-TIM25", 1, {1.50659233f, 0.204786135f, 1.92036668f, 0.0109501562f, 0.0574980285f, 178.128535f}},
    {"S-TIM27", 1, {1.4168047f, 0.196785057f, 1.68001322f, 0.0100732158f, 0.0537616908f, 164.672436f}},
    {"S-TIM28", 1, {1.5427081f, 0.217113891f, 1.81904459f, 0.0113925005f, 0.0579224572f, 167.697189f}},
    {"S-TIM3", 1, {1.40691144f, 0.128369745f, 1.51826191f, 0.0105633641f, 0.0568483105f, 152.107924f}},
    {"S-TIM35", 1, {1.55849775f, 0.230767007f, 1.84436099f, 0.0115367235f, 0.0586095947f, 162.981888f}},
    {"S-TIM39", 1, {1.47008105f, 0.224752746f, 2.44968592f, 0.0102900432f, 0.0541276904f, 237.43494f}},
    {"S-TIM5", 1, {1.38531342f, 0.122372945f, 1.40508326f, 0.0104074567f, 0.0557440088f, 144.878733f}},
    {"S-TIM6", 1, {1.41315067f, 0.1914654f, 1.68833255f, 0.00995172814f, 0.0527932739f, 168.804627f}},
    {"S-TIM8", 1, {1.37262713f, 0.112636276f, 1.39786421f, 0.0103220068f, 0.0550195044f, 147.735609f}},
    {"S-YGH51", 1, {1.0828017f, 0.933988681f, 1.32367286f, 0.018115636f, 0.00304157575f, 91.0353195f}},
    {"D-FK61-25", 2, {0.894432499f, 0.321652123f, 0.748704285f, 0.00436678978f, 0.0141909741f, 149.771388f}},
    {"D-FK61", 2, {0.872991432f, 0.756437828f, 0.344497102f, 0.00422111331f, 151.201184f, 0.0138938225f}},
    {"D-FK61A-25", 2, {0.714581002f, 0.502174967f, 0.838296164f, 0.0108378966f, 0.00132310137f, 153.775939f}},
    {"D-FK61A", 2, {0.714812161f, 0.502984998f, 0.836119846f, 0.0108370689f, 0.00132155859f, 153.360674f}},
    {"D-FK95-25", 2, {0.989211963f, 0.060141262f, 0.685377886f, 0.005065907f, 0.019705386f, 158.935083f}},
    {"D-FK95", 2, {0.973027043f, 0.077363216f, 0.687944956f, 0.004919458f, 0.01820094f, 159.44609f}},
    {"D-K59-25", 2, {1.16665743f, 0.105028598f, 0.990269002f, 0.00707953299f, 0.0261090052f, 98.6724455f}},
    {"D-K59", 2, {1.1209538f, 0.152690608f, 1.07502924f, 0.00657908073f, 0.0235724778f, 106.309977f}},
    {"D-K9-25", 2, {1.08234297f, 0.548438846f, 0.719999855f, 107.907645f, 0.002190929f, 0.013407002f}},
    {"D-K9", 2, {0.567853792f, 0.702269689f, 1.08102455f, 0.00238581579f, 0.0135348332f, 107.748228f}},
    {"D-K9GT-25", 2, {1.08234297f, 0.548438846f, 0.719999855f, 107.907645f, 0.002190929f, 0.013407002f}},
    {"D-K9GT", 2, {0.567853792f, 0.702269689f, 1.08102455f, 0.00238581579f, 0.0135348332f, 107.748228f}},
    {"D-LAF050-25", 2, {1.22950343f, 0.641767823f, 1.41136391f, 87.307119f, 0.023765216f, 0.006459327f}},
    {"D-LAF050", 2, {0.653249512f, 1.20557745f, 1.40453781f, 0.023644288f, 85.5377962f, 0.006364015f}},
    {"D-LAF50-25", 2, {0.734700246f, 1.33716574f, 1.13513348f, 0.022666746f, 0.006016769f, 95.7512696f}},
    {"D-LAF50", 2, {1.34473873f, 1.13288204f, 0.731048914f, 0.006036194f, 95.5213185f, 0.022706198f}},
    {"D-LAF53-25", 2, {1.32239317f, 0.646347208f, 1.17507569f, 0.00606224219f, 0.0234824415f, 87.8164211f}},
    {"D-LAF53", 2, {0.645397592f, 1.17528667f, 1.32747885f, 0.023499357f, 87.7755219f, 0.0060601597f}},
    {"D-LAF79-25", 2, {0.244124156f, 1.39592511f, 1.66977539f, 0.0430784572f, 113.324709f, 0.00964211165f}},
    {"D-LAF79", 2, {0.26530456f, 1.45255299f, 1.65170478f, 0.0420844203f, 117.349274f, 0.00935611552f}},
    {"D-LAK5-25", 2, {0.60236351f, 1.15823046f, 1.30267215f, 3.07499779e-08f, 0.0158379352f, 101.976296f}},
    {"D-LAK5", 2, {0.60503157f, 1.15901922f, 1.30308775f, 2.87640355e-08f, 0.015837052f, 101.946508f}},
    {"D-LAK52-25", 2, {1.04345567f, 0.888612736f, 1.2310265f, 0.017366945f, 0.00301494124f, 87.1255673f}},
    {"D-LAK52", 2, {1.04647517f, 0.889910862f, 1.23173612f, 0.0173536556f, 0.00298398431f, 87.1100488f}},
    {"D-LAK6-25", 2, {1.22299893f, 0.471209941f, 1.33928922f, 94.0859262f, 0.0227830104f, 0.00665285316f}},
    {"D-LAK6", 2, {0.477723115f, 1.33623366f, 1.22543438f, 0.0226962287f, 0.00659605302f, 94.2027569f}},
    {"D-LAK70-25", 2, {0.615746796f, 1.11671184f, 1.29436779f, 0.000310601738f, 0.015811421f, 102.149797f}},
    {"D-LAK70", 2, {0.616886534f, 1.11924765f, 1.29814839f, 0.000249888602f, 0.0158113883f, 102.017679f}},
    {"D-PK3-25", 2, {0.513407653f, 0.923806373f, 0.781224837f, 0.00173535467f, 95.3262202f, 0.0118350221f}},
    {"D-PK3", 2, {0.631688714f, 0.666896432f, 0.874644819f, 0.0127792227f, 0.00313927857f, 90.174067f}},
    {"D-QK3L-25", 2, {0.8348882f, 0.140256117f, 1.0463805f, 90.1036067f, 0.019928316f, 0.006081957f}},
    {"D-QK3L", 2, {0.601737491f, 0.858737004f, 0.586761501f, 0.012574974f, 92.3325663f, 0.002687509f}},
    {"D-ZF10-25", 2, {1.39531577f, 0.180389834f, 1.57395389f, 134.661574f, 0.0604305431f, 0.0122657049f}},
    {"D-ZF10", 2, {0.181090971f, 1.38321826f, 1.57814468f, 0.0606385885f, 132.946691f, 0.0122919204f}},
    {"D-ZF93-25", 2, {1.4330228f, 2.13630545f, 0.630184037f, 101.185435f, 0.0138161232f, 0.065857845f}},
    {"D-ZF93", 2, {1.51323628f, 2.16740096f, 0.606108042f, 106.262695f, 0.014231857f, 0.0666586743f}},
    {"D-ZK2-25", 2, {1.1044946f, 0.36094124f, 1.01208343f, 0.0062094807f, 0.0196844329f, 101.038646f}},
    {"D-ZK2", 2, {0.402765796f, 1.01706887f, 1.06495499f, 0.019063471f, 101.270923f, 0.00590052089f}},
    {"D-ZK21-25", 2, {1.08777542f, 0.505694645f, 1.31533152f, 0.0143531981f, -0.000448862561f, 104.063333f}},
    {"D-ZK21", 2, {1.31514915f, 1.08358135f, 0.513108754f, 103.989436f, 0.0143813024f, -0.00036392391f}},
    {"D-ZK2L-25", 2, {0.530248488f, 1.12537335f, 0.947317341f, 0.0175027403f, 109.192004f, 0.00498306497f}},
    {"D-ZK2L", 2, {0.512521894f, 0.967402158f, 1.12488967f, 0.0176943616f, 0.00510795325f, 109.10377f}},
    {"D-ZK3-25", 2, {1.24347604f, 0.918798491f, 0.567180042f, 108.031442f, 0.0139520404f, 0.00127620015f}},
    {"D-ZK3", 2, {1.33936811f, 0.148690268f, 1.00954033f, 0.00760612309f, 0.0238444644f, 89.0419787f}},
    {"D-ZK3L-25", 2, {0.636443631f, 0.856921557f, 1.23247717f, 0.0021737174f, 0.0144861653f, 107.585666f}},
    {"D-ZK3L", 2, {0.638506128f, 0.857387558f, 1.23664057f, 0.00216674072f, 0.0144860621f, 107.881152f}},
    {"D-ZK79-25", 2, {0.754687333f, 0.788729239f, 1.10213843f, 0.00315353195f, 0.0162517857f, 112.78636f}},
    {"D-ZK79", 2, {0.756950911f, 0.788924494f, 1.10449853f, 0.00314478995f, 0.0162552471f, 112.960367f}},
    {"D-ZLAF50-25", 2, {0.281077854f, 1.19505397f, 1.88534009f, 0.0346761107f, 91.8385642f, 0.00975311743f}},
    {"D-ZLAF50", 2, {1.13754975f, 0.27377557f, 1.89653755f, 87.6010757f, 0.0348809856f, 0.00982589937f}},
    {"D-ZLAF52LA-25", 2, {1.85743559f, 0.323469816f, 1.2894946f, 0.00962363637f, 0.0398398385f, 98.4654718f}},
    {"D-ZLAF52LA", 2, {1.88205933f, 0.302908859f, 1.2538738f, 0.00984915169f, 0.0406191391f, 95.893604f}},
    {"D-ZLAF61-25", 2, {0.384732155f, 1.8424092f, 1.21280764f, 0.0355326885f, 0.00916902591f, 95.9091697f}},
    {"D-ZLAF61", 2, {0.42742586f, 1.80371405f, 1.2694916f, 0.0344432015f, 0.00878105468f, 99.795367f}},
    {"D-ZLAF67-25", 2, {1.36012388f, 2.09601012f, 0.333537105f, 103.579888f, 0.011037962f, 0.0449413554f}},
    {"D-ZLAF67", 2, {2.10977576f, 0.324313076f, 1.37618163f, 0.0111387884f, 0.0453343979f, 104.419881f}},
    {"D-ZLAF81-25", 2, {1.90958888f, 0.266893034f, 1.26585975f, 0.0102182926f, 0.0421328894f, 97.0733228f}},
    {"D-ZLAF81", 2, {1.8861875f, 0.294671919f, 1.27989084f, 0.00991169457f, 0.0409687583f, 97.797523f}},
    {"D-ZLAF85A-25", 2, {1.37428361f, 0.412199165f, 1.91320505f, 105.610997f, 0.0373787374f, 0.00975370563f}},
    {"D-ZLAF85A", 2, {1.95969458f, 0.36979719f, 1.41004927f, 0.0101035507f, 0.0386876073f, 107.905684f}},
    {"D-ZLAF85L-25", 2, {1.71754157f, 0.614249641f, 1.49329677f, 0.0081252668f, 0.0323072933f, 115.416839f}},
    {"D-ZLAF85L", 2, {0.516695305f, 1.81900011f, 1.42320717f, 0.0340497474f, 0.00895670808f, 110.045928f}},
    {"D-ZLAF85LN-25", 2, {1.22657126f, 0.367411998f, 1.93493865f, 93.6444885f, 0.0394561346f, 0.00982834912f}},
    {"D-ZLAF85LN", 2, {1.92017081f, 0.386379034f, 1.291166f, 0.00961912018f, 0.0389567822f, 97.9773368f}},
    {"D-ZLAF85LS-25", 2, {1.70152719f, 0.633298236f, 1.43191921f, 0.00796295658f, 0.0320099725f, 110.67927f}},
    {"D-ZLAF85LS", 2, {0.638690484f, 1.69998504f, 1.45547394f, 0.0319257637f, 0.00791790668f, 112.179157f}},
    {"D-ZPK1A-25", 2, {0.860621496f, 0.723408663f, 0.91527878f, 0.0142471941f, 0.00293226364f, 109.074599f}},
    {"D-ZPK1A", 2, {0.723324526f, 0.863552452f, 0.985077169f, 0.00288945758f, 0.0142439384f, 116.596916f}},
    {"D-ZPK3-25", 2, {0.580374258f, 0.923503788f, 1.03923776f, 0.00172131188f, 0.0126541722f, 105.366349f}},
    {"D-ZPK3", 2, {0.922289896f, 0.584492874f, 1.04970792f, 0.0126503387f, 0.00176614589f, 106.089243f}},
    {"D-ZPK5-25", 2, {0.353073711f, 1.14580426f, 0.795754681f, 0.0178712877f, 0.00563723799f, 125.202885f}},
    {"D-ZPK5", 2, {0.259562934f, 1.24131969f, 0.78723739f, 0.0196231869f, 0.00619669959f, 123.753444f}},
    {"D-ZPK7-25", 2, {0.71411271f, 0.713400795f, 0.765480668f, 0.0133604289f, 0.0028939123f, 134.125223f}},
    {"D-ZPK7", 2, {0.725400532f, 0.703767661f, 0.77228314f, 0.00296983783f, 0.013434264f, 135.211711f}},
    {"F4GTI", 2, {0.953714037f, 1.31399551f, 0.24063751f, 115.513417f, 0.00931937546f, 0.0452869078f}},
    {"H-BAF2", 2, {0.131856447f, 1.28686729f, 1.0068252f, 0.0404229746f, 0.0080740739f, 113.574742f}},
    {"H-BAF3", 2, {1.16102167f, 0.926012255f, 0.290935978f, 0.00637008736f, 107.341889f, 0.0265573391f}},
    {"H-BAF4", 2, {1.32811418f, 0.126865199f, 1.04004826f, 0.0086851075f, 0.0440786174f, 120.899619f}},
    {"H-BAF5", 2, {1.06904566f, 0.10415751f, 1.41843612f, 112.003965f, 0.0516103587f, 0.00956493179f}},
    {"H-BAF6", 2, {1.06475107f, 1.38638809f, 0.146161462f, 115.35395f, 0.00853300947f, 0.0437434703f}},
    {"H-BAF7", 2, {1.08754258f, 1.41618001f, 0.12698713f, 117.535981f, 0.0100875311f, 0.0526006682f}},
    {"H-BAF8", 2, {1.18828507f, 1.43848614f, 0.140002385f, 128.446962f, 0.0101637552f, 0.0524582573f}},
    {"H-BAK1", 2, {0.685984613f, 0.901677469f, 0.622429167f, 0.0154934494f, 106.588731f, 0.00222670016f}},
    {"H-BAK2", 2, {0.618389223f, 0.718400306f, 1.07451466f, 0.00174653825f, 0.0158112967f, 126.584788f}},
    {"H-BAK3", 2, {0.63512858f, 0.920839763f, 0.724654326f, 0.00255407022f, 92.9065095f, 0.0143580146f}},
    {"H-BAK4", 2, {0.559279457f, 0.985286498f, 0.818059461f, 0.0017275627f, 97.8673314f, 0.0135929957f}},
    {"H-BAK5", 2, {0.858085903f, 0.38007029f, 1.01787547f, 101.018871f, 0.0203677495f, 0.0056451589f}},
    {"H-BAK6", 2, {0.813984879f, 0.595734077f, 1.00704301f, 0.00392398403f, 0.0164900015f, 107.665801f}},
    {"H-BAK7", 2, {0.659469741f, 0.7621967f, 1.19935835f, 0.000766009635f, 0.0177403402f, 129.975103f}},
    {"H-BAK7GT", 2, {0.659469741f, 0.7621967f, 1.19935835f, 0.000766009635f, 0.0177403402f, 129.975103f}},
    {"H-BAK8", 2, {0.845101506f, 1.01452466f, 0.418518474f, 100.298196f, 0.00555241848f, 0.0202280796f}},
    {"H-F1", 2, {0.132375817f, 1.15564934f, 1.37547893f, 0.0545903225f, 116.78574f, 0.0101495335f}},
    {"H-F13", 2, {0.141150321f, 1.23908619f, 1.43200332f, 0.0576025273f, 117.259382f, 0.0106818976f}},
    {"H-F2", 2, {1.40477521f, 1.17495845f, 0.130830575f, 0.0104153446f, 113.688956f, 0.0568962426f}},
    {"H-F3", 2, {1.40512926f, 0.140987722f, 1.52292764f, 0.0103407899f, 0.0561355281f, 149.776911f}},
    {"H-F4", 2, {0.131898794f, 1.42441827f, 1.21746316f, 0.05793195f, 0.0106270032f, 117.376535f}},
    {"H-F5", 2, {1.43541709f, 0.133104631f, 1.2215186f, 0.0108394789f, 0.058152846f, 120.768299f}},
    {"H-F51", 2, {1.19880199f, 0.146782039f, 1.46655148f, 118.703083f, 0.0586919967f, 0.0111709187f}},
    {"H-FK61", 2, {0.502504076f, 0.715240076f, 0.836628986f, 0.00132743798f, 0.0108378966f, 155.933755f}},
    {"H-FK61B", 2, {0.714812161f, 0.502984998f, 0.836119846f, 0.0108370689f, 0.00132155859f, 153.360674f}},
    {"H-FK71", 2, {0.22226661f, 0.880444178f, 0.797848915f, 0.014065122f, 0.004204574f, 171.029818f}},
    {"H-FK95N", 2, {0.973027043f, 0.077363216f, 0.687944956f, 0.004919458f, 0.01820094f, 159.44609f}},
    {"H-K1", 2, {0.841282669f, 1.01521166f, 0.204021337f, 103.641667f, 0.00623224915f, 0.022057042f}},
    {"H-K10", 2, {0.231760668f, 1.03993508f, 0.966966878f, 0.0237840711f, 0.00615271269f, 117.740117f}},
    {"H-K11", 2, {0.795536936f, 0.500949252f, 0.905052235f, 0.00400873219f, 0.0175436655f, 111.287063f}},
    {"H-K2", 2, {0.951357962f, 0.969614738f, 0.273207194f, 0.0112894891f, 99.1744348f, -0.00245665699f}},
    {"H-K3", 2, {0.296004558f, 0.940420083f, 1.0056654f, 0.0185989847f, 0.00513632873f, 97.555431f}},
    {"H-K50", 2, {1.19524701f, 0.0895076933f, 0.920217443f, 0.00764077104f, 0.0318085706f, 109.312054f}},
    {"H-K51", 2, {0.960161808f, 1.18368963f, 0.102338243f, 116.24248f, 0.0118029997f, -0.0189575777f}},
    {"H-K7", 2, {0.854802452f, 0.442226826f, 0.820484068f, 103.20426f, 0.0179643059f, 0.00433831623f}},
    {"H-K8", 2, {0.89042231f, 0.220099174f, 1.0437922f, 109.831873f, 0.0247288604f, 0.00657041675f}},
    {"H-K90GTI", 2, {1.15678766f, 0.960974772f, 0.121868843f, 0.007006478f, 100.981876f, 0.024955389f}},
    {"H-K9L", 2, {0.614555251f, 0.656775017f, 1.02699346f, 0.0145987884f, 0.00287769588f, 107.653051f}},
    {"H-K9LA", 2, {0.684743072f, 0.586772376f, 1.14804248f, 0.00313539741f, 0.014810133f, 116.583792f}},
    {"H-K9LAGT", 2, {0.684743072f, 0.586772376f, 1.14804248f, 0.00313539741f, 0.014810133f, 116.583792f}},
    {"H-K9LGT", 2, {0.614555251f, 0.656775017f, 1.02699346f, 0.0145987884f, 0.00287769588f, 107.653051f}},
    {"H-K9Lstar", 2, {0.614555251f, 0.656775017f, 1.02699346f, 0.0145987884f, 0.00287769588f, 107.653051f}},
    {"H-KF6", 2, {0.0736995941f, 1.19277164f, 1.01749455f, 0.0478548878f, 0.00781132706f, 104.241959f}},
    {"H-LAF1", 2, {1.1615525f, 1.49000619f, 0.317836401f, 106.692961f, 0.0073654243f, 0.0313945298f}},
    {"H-LAF10LA", 2, {1.93178403f, 0.189897276f, 1.09736515f, 0.00997340769f, 0.0368891042f, 77.2777489f}},
    {"H-LAF2", 2, {1.62865121f, 1.11837078f, 0.253252293f, 0.00864219294f, 109.900598f, 0.0342503107f}},
    {"H-LAF3B", 2, {1.66486969f, 0.30162248f, 1.1973888f, 0.00895646712f, 0.0350299695f, 123.334438f}},
    {"H-LAF4", 2, {0.210645313f, 1.75547352f, 1.28979005f, 0.0542759294f, 0.0112370777f, 119.852069f}},
    {"H-LAF4GT", 2, {0.210645313f, 1.75547352f, 1.28979005f, 0.0542759294f, 0.0112370777f, 119.852069f}},
    {"H-LAF50B", 2, {1.17461263f, 1.65889744f, 0.413174064f, 82.6267633f, 0.0080512806f, 0.026961264f}},
    {"H-LAF51", 2, {1.16091555f, 1.53441573f, 0.293141701f, 102.913644f, 0.00759735684f, 0.0338071716f}},
    {"H-LAF52", 2, {0.225893751f, 1.88248028f, 1.11307009f, 0.0391551736f, 0.0100951886f, 85.0042906f}},
    {"H-LAF53", 2, {1.52005515f, 1.09140777f, 0.452588708f, 0.00746606502f, 81.9422153f, 0.0263954349f}},
    {"H-LAF55", 2, {1.73920103f, 1.16162575f, 0.279488106f, 0.00974400845f, 111.118099f, 0.0423325277f}},
    {"H-LAF62", 2, {1.68895143f, 0.196642406f, 1.18909464f, 0.00969035554f, 0.0423750782f, 118.147033f}},
    {"H-LAF6LA", 2, {1.12023521f, 0.897573526f, 1.3665486f, 0.00335766705f, 0.0227710735f, 92.0376324f}},
    {"H-LAF7", 2, {1.85620526f, 1.38494652f, 0.223526441f, 0.0109606128f, 114.47738f, 0.0505771615f}},
    {"H-LAFL5", 2, {1.26562517f, 1.8132477f, 0.173525791f, 102.654797f, 0.011161487f, 0.0541388764f}},
    {"H-LAK1", 2, {0.964886701f, 0.468480585f, 1.23722796f, 91.193933f, 0.0205810529f, 0.00608509423f}},
    {"H-LAK10", 2, {0.783174579f, 0.894315049f, 1.138969f, 0.0027316949f, 0.0169034325f, 111.158589f}},
    {"H-LAK11", 2, {1.09089534f, 0.628435989f, 1.01438282f, 0.00492618902f, 0.0203181412f, 100.530943f}},
    {"H-LAK12", 2, {0.786703112f, 1.21770392f, 1.04086924f, 0.00202073208f, 86.703479f, 0.0163643393f}},
    {"H-LAK2A", 2, {0.914808038f, 1.00522491f, 0.803415958f, 82.3260698f, 0.004505044f, 0.018371342f}},
    {"H-LAK3", 2, {1.27801447f, 1.19473815f, 0.793028102f, 90.6830082f, 0.0181704833f, 0.00108737276f}},
    {"H-LAK4L", 2, {0.402312889f, 1.24575177f, 1.28904431f, -0.00267679247f, 0.013171611f, 93.3654804f}},
    {"H-LAK50A", 2, {0.759437631f, 1.16056755f, 0.92336083f, 0.0022319671f, 91.0466256f, 0.0158590987f}},
    {"H-LAK51A", 2, {0.639398694f, 1.18748481f, 1.26545352f, 5.67124825e-05f, 0.0158001968f, 91.097053f}},
    {"H-LAK52", 2, {0.648528792f, 1.28450424f, 1.23774593f, 0.000165816179f, 0.0158113883f, 85.7406109f}},
    {"H-LAK53A", 2, {1.21007394f, 1.19495815f, 0.806533246f, 0.00521679919f, 83.5557501f, 0.02008035f}},
    {"H-LAK53B", 2, {1.0314122f, 0.985282193f, 1.17066017f, 0.00395421648f, 0.0186863118f, 81.1326753f}},
    {"H-LAK54", 2, {1.20772937f, 0.737418371f, 1.35749026f, 0.0176389155f, 0.000666515982f, 96.9938806f}},
    {"H-LAK59A", 2, {1.63613242f, 0.169161636f, 0.929984618f, 0.00869769737f, 0.0295057126f, 82.4994109f}},
    {"H-LAK5A", 2, {1.54437415f, 1.00066972f, 0.219123775f, 0.00815901025f, 88.9110754f, 0.0267011064f}},
    {"H-LAK6A", 2, {1.13018444f, 1.60589f, 0.207868982f, 81.4541493f, 0.00817222723f, 0.030380314f}},
    {"H-LAK7A", 2, {1.20674811f, 1.06717731f, 0.811229515f, 84.3499012f, 0.004381895f, 0.018982889f}},
    {"H-LAK8A", 2, {1.13861881f, 0.158050538f, 1.73934635f, 80.074466f, 0.0368197669f, 0.00909531981f}},
    {"H-LAK8B", 2, {1.55351121f, 0.342243754f, 1.07011974f, 0.00793041249f, 0.0280174591f, 90.2590858f}},
    {"H-QF1", 2, {1.24414177f, 1.08792977f, 0.106583226f, 0.00867592204f, 124.77088f, 0.0473895753f}},
    {"H-QF14", 2, {1.17413204f, 1.36038248f, 0.125239591f, 119.558629f, 0.00992935549f, 0.0538484281f}},
    {"H-QF3", 2, {1.31974395f, 0.106724103f, 1.12240441f, 0.0096223383f, 0.0534250071f, 121.814727f}},
    {"H-QF50", 2, {1.29450546f, 0.150752291f, 1.08698065f, 0.00894503808f, 0.0483713581f, 113.959763f}},
    {"H-QF50A", 2, {0.113568363f, 1.07619407f, 1.33131033f, 0.0529496322f, 114.277366f, 0.00976687365f}},
    {"H-QF56", 2, {1.01193506f, 0.110711906f, 1.29397308f, 116.639064f, 0.051103672f, 0.00923739628f}},
    {"H-QF6A", 2, {0.0830014908f, 1.22223237f, 1.01475439f, 0.0493974056f, 0.00830688707f, 114.773547f}},
    {"H-QF8", 2, {0.127874264f, 1.20201357f, 0.92946936f, 0.0424546034f, 0.00811385854f, 109.832978f}},
    {"H-QK1", 2, {0.841944073f, 0.991785467f, 0.146213376f, 93.2638704f, 0.0103998728f, -0.00820300741f}},
    {"H-QK3L", 2, {0.601737491f, 0.858737004f, 0.586761501f, 0.012574974f, 92.3325663f, 0.002687509f}},
    {"H-QK3LGTI", 2, {0.601737491f, 0.858737004f, 0.586761501f, 0.012574974f, 92.3325663f, 0.002687509f}},
    {"H-TF3L", 2, {1.35609817f, 0.192047799f, 1.325836f, 0.00823370212f, 0.0410079104f, 111.798686f}},
    {"H-TF5", 2, {1.55856807f, 0.109731968f, 1.10774896f, 0.0110562787f, 0.054404745f, 88.3222356f}},
    {"H-TF8", 2, {1.6056299f, 1.32554029f, 0.265358825f, 0.0103174707f, 108.474162f, 0.0488739276f}},
    {"H-ZBAF1", 2, {1.05607188f, 1.45456542f, 0.129035718f, 114.460233f, 0.00840268049f, 0.036305429f}},
    {"H-ZBAF16", 2, {0.18224764f, 1.53664805f, 1.2307217f, 0.0368484589f, 0.0088564742f, 134.124694f}},
    {"H-ZBAF20", 2, {0.155463018f, 1.22204789f, 1.6661164f, 0.050049662f, 119.801735f, 0.0102206327f}},
    {"H-ZBAF21", 2, {1.71447483f, 0.172919641f, 1.37586664f, 0.0106695401f, 0.0536257488f, 127.687623f}},
    {"H-ZBAF3", 2, {0.175551746f, 1.51566987f, 1.11140587f, 0.0360804664f, 0.00823043679f, 113.991537f}},
    {"H-ZBAF4", 2, {0.151466661f, 1.54020133f, 1.18737385f, 0.0571831045f, 0.0111587138f, 120.128948f}},
    {"H-ZBAF5", 2, {0.265135611f, 1.46645391f, 1.68212208f, 0.0342928637f, 0.00799326644f, 179.124162f}},
    {"H-ZBAF50", 2, {1.63431974f, 0.988379475f, 0.0611984018f, 0.00983161322f, 102.398826f, 0.0499038842f}},
    {"H-ZBAF52", 2, {1.51688354f, 0.211371553f, 1.35763017f, 0.00857006565f, 0.0370160061f, 144.349229f}},
    {"H-ZF1", 2, {1.06294164f, 0.146910876f, 1.48922543f, 108.400406f, 0.0591797128f, 0.0115933111f}},
    {"H-ZF10", 2, {1.50060292f, 1.57641199f, 0.18307627f, 145.496272f, 0.0121805144f, 0.0605139545f}},
    {"H-ZF11", 2, {1.59868051f, 0.189448887f, 1.26870155f, 0.0126057844f, 0.0617894718f, 121.376823f}},
    {"H-ZF12", 2, {0.323730379f, 1.65668629f, 2.1214152f, 0.0598308169f, 0.0120542686f, 174.18792f}},
    {"H-ZF13", 2, {1.73521591f, 0.316277446f, 2.16384634f, 0.0131087904f, 0.0621421663f, 178.845558f}},
    {"H-ZF13GT", 2, {1.73521591f, 0.316277446f, 2.16384634f, 0.0131087904f, 0.0621421663f, 178.845558f}},
    {"H-ZF1A", 2, {0.157527094f, 1.4792285f, 1.18166385f, 0.0585466694f, 0.0111805229f, 115.153843f}},
    {"H-ZF2", 2, {0.16764338f, 1.54335076f, 1.17313123f, 0.0605177711f, 0.0118524273f, 113.6711f}},
    {"H-ZF3", 2, {0.203624748f, 1.64202576f, 1.38768085f, 0.0620712732f, 0.0127139992f, 128.254467f}},
    {"H-ZF39", 2, {0.153633529f, 1.54070508f, 1.20956745f, 0.060380621f, 0.0118591415f, 119.979606f}},
    {"H-ZF4A", 2, {1.67238093f, 1.34134437f, 0.204305471f, 0.0133653851f, 122.464022f, 0.0641192325f}},
    {"H-ZF4AGT", 2, {1.67238093f, 1.34134437f, 0.204305471f, 0.0133653851f, 122.464022f, 0.0641192325f}},
    {"H-ZF5", 2, {1.70024855f, 1.36322884f, 0.214513422f, 0.0133277515f, 122.33381f, 0.0635762871f}},
    {"H-ZF50", 2, {1.38419227f, 0.216862697f, 1.69855074f, 121.210226f, 0.0642534343f, 0.0135195855f}},
    {"H-ZF52", 2, {0.409982615f, 2.37517176f, 1.83913582f, 0.0621421199f, 185.055134f, 0.0136093459f}},
    {"H-ZF52GT", 2, {0.409982615f, 2.37517176f, 1.83913582f, 0.0621421199f, 185.055134f, 0.0136093459f}},
    {"H-ZF52TT", 2, {0.409982615f, 2.37517176f, 1.83913582f, 0.0621421199f, 185.055134f, 0.0136093459f}},
    {"H-ZF6", 2, {1.64768548f, 0.314478021f, 2.03864924f, 0.0118179362f, 0.0585408205f, 173.964477f}},
    {"H-ZF62", 2, {2.55246796f, 0.465681607f, 2.0289468f, 162.450683f, 0.069560081f, 0.014771138f}},
    {"H-ZF62GT", 2, {2.55246796f, 0.465681607f, 2.0289468f, 162.450683f, 0.069560081f, 0.014771138f}},
    {"H-ZF71", 2, {0.406804868f, 1.70831097f, 2.36137303f, 0.064515213f, 0.0127703237f, 163.275585f}},
    {"H-ZF71GT", 2, {0.406804868f, 1.70831097f, 2.36137303f, 0.064515213f, 0.0127703237f, 163.275585f}},
    {"H-ZF72A", 2, {0.470478653f, 2.55040233f, 2.00593441f, 0.0736024509f, 149.306621f, 0.0162999226f}},
    {"H-ZF72AGT", 2, {0.470478653f, 2.55040233f, 2.00593441f, 0.0736024509f, 149.306621f, 0.0162999226f}},
    {"H-ZF73", 2, {0.528336971f, 2.05959954f, 3.5863808f, 0.0759305743f, 0.0171346469f, 189.364809f}},
    {"H-ZF73GT", 2, {0.528336971f, 2.05959954f, 3.5863808f, 0.0759305743f, 0.0171346469f, 189.364809f}},
    {"H-ZF7LA", 2, {1.65846092f, 0.298796445f, 1.8184834f, 144.874699f, 0.0635424599f, 0.0141908346f}},
    {"H-ZF7LAGT", 2, {1.65846092f, 0.298796445f, 1.8184834f, 144.874699f, 0.0635424599f, 0.0141908346f}},
    {"H-ZF88", 2, {2.04275349f, 1.98276153f, 0.504267829f, 0.0169742976f, 109.068151f, 0.075171071f}},
    {"H-ZF88GT", 2, {2.04275349f, 1.98276153f, 0.504267829f, 0.0169742976f, 109.068151f, 0.075171071f}},
    {"H-ZK1", 2, {1.06131555f, 0.365740168f, 1.03466756f, 0.00543666583f, 0.0187659148f, 97.5169702f}},
    {"H-ZK10", 2, {1.48007727f, 0.874190019f, 0.1058395f, 0.00852142302f, 93.1901383f, 0.0327272904f}},
    {"H-ZK10L", 2, {0.957266324f, 1.44528215f, 0.143179062f, 100.408853f, 0.008043802f, 0.030435308f}},
    {"H-ZK11", 2, {0.053461546f, 1.5837823f, 0.918196297f, 0.0456429986f, 0.00912260162f, 89.3234474f}},
    {"H-ZK14", 2, {0.821911395f, 0.995367381f, 0.708381156f, 0.00369659724f, 97.9765358f, 0.0159409871f}},
    {"H-ZK2", 2, {0.427442699f, 0.907023646f, 1.04012009f, 0.0191755139f, 94.6355569f, 0.00552619449f}},
    {"H-ZK20", 2, {0.812249368f, 0.755251214f, 1.15073913f, 0.0181753969f, 0.00247827771f, 144.030731f}},
    {"H-ZK21", 2, {0.894248925f, 0.696413489f, 1.07122355f, 0.00384521718f, 0.0174130132f, 102.205952f}},
    {"H-ZK3", 2, {0.85567832f, 0.897778708f, 0.631730586f, 0.00441734284f, 89.6045798f, 0.015804179f}},
    {"H-ZK3A", 2, {0.964352845f, 0.77489966f, 0.712663198f, 94.8895042f, 0.014985413f, 0.00294423381f}},
    {"H-ZK4", 2, {0.805862971f, 0.74036711f, 0.904054991f, 0.00365339732f, 0.0162978769f, 95.9876087f}},
    {"H-ZK5", 2, {0.920219055f, 0.531425413f, 1.01909144f, 109.361864f, 0.0198985689f, 0.00525819605f}},
    {"H-ZK50", 2, {0.434311306f, 1.10560033f, 0.988776159f, -0.00192252587f, 0.0147271072f, 110.41165f}},
    {"H-ZK50GT", 2, {0.434311306f, 1.10560033f, 0.988776159f, -0.00192252587f, 0.0147271072f, 110.41165f}},
    {"H-ZK6", 2, {1.3513924f, 0.206957487f, 0.961153882f, 0.00735017182f, 0.0254398321f, 99.5133128f}},
    {"H-ZK7A", 2, {0.938065696f, 0.623491935f, 1.00587058f, 0.00438468072f, 0.0169391481f, 93.2750706f}},
    {"H-ZK8", 2, {0.600949826f, 0.958288632f, 1.1405978f, 5.19864453e-11f, 0.0167563008f, 133.109431f}},
    {"H-ZK9B", 2, {0.874918734f, 0.7096273f, 1.09453882f, 0.00373965378f, 0.0163972089f, 100.204324f}},
    {"H-ZLAF1", 2, {0.513637795f, 1.65030785f, 1.47644096f, 0.0313064446f, 0.0073538878f, 100.105262f}},
    {"H-ZLAF2A", 2, {1.76389273f, 0.407585264f, 1.27020239f, 0.00842148915f, 0.0304194282f, 89.5802552f}},
    {"H-ZLAF4LA", 2, {2.212551f, 0.312542616f, 1.56862457f, 0.011817254f, 0.049586258f, 115.52649f}},
    {"H-ZLAF4LB", 2, {0.30378754f, 2.22145931f, 1.54968685f, 0.050087732f, 0.011875826f, 113.957667f}},
    {"H-ZLAF50D", 2, {0.497440659f, 1.67780264f, 1.32327423f, 0.0285446966f, 0.00788379288f, 94.0514342f}},
    {"H-ZLAF50E", 2, {1.22239213f, 0.952859931f, 1.37994067f, 0.00445444481f, 0.0229973985f, 99.1991267f}},
    {"H-ZLAF51", 2, {1.22431136f, 0.302590305f, 1.86090715f, 91.245183f, 0.0426067628f, 0.0098703156f}},
    {"H-ZLAF52A", 2, {1.85313688f, 0.317938591f, 1.16396318f, 0.00985534639f, 0.0392611678f, 93.1032763f}},
    {"H-ZLAF53B", 2, {0.302813825f, 1.25522353f, 1.95575794f, 0.04559202f, 99.9412194f, 0.010816711f}},
    {"H-ZLAF53BGT", 2, {0.302813825f, 1.25522353f, 1.95575794f, 0.04559202f, 99.9412194f, 0.010816711f}},
    {"H-ZLAF55C", 2, {1.89206469f, 0.383013491f, 1.32100138f, 0.00927969961f, 0.035625946f, 93.6667669f}},
    {"H-ZLAF55D", 2, {0.227765275f, 2.04686906f, 1.20888928f, 0.0412221798f, 0.010748949f, 87.8518998f}},
    {"H-ZLAF66", 2, {0.233018785f, 1.90660392f, 1.37147086f, 0.0537435377f, 0.0114336559f, 110.630887f}},
    {"H-ZLAF66GT", 2, {0.233018785f, 1.90660392f, 1.37147086f, 0.0537435377f, 0.0114336559f, 110.630887f}},
    {"H-ZLAF68C", 2, {1.58833884f, 0.851761035f, 1.58277416f, 0.00689365045f, 0.0288290435f, 125.035659f}},
    {"H-ZLAF68N", 2, {1.49455025f, 2.07574257f, 0.361138143f, 109.762523f, 0.010404077f, 0.041262142f}},
    {"H-ZLAF69", 2, {0.659414732f, 1.55675638f, 1.25417967f, 0.025605996f, 0.00727769577f, 93.1176682f}},
    {"H-ZLAF69A", 2, {1.39269903f, 0.823697428f, 1.29547295f, 0.00593335223f, 0.0240980834f, 95.3762858f}},
    {"H-ZLAF71", 2, {0.276154598f, 2.02569085f, 1.44513509f, 0.0557996382f, 0.0120700588f, 99.8778223f}},
    {"H-ZLAF71AGT", 2, {1.54172779f, 2.03469901f, 0.264811834f, 131.963779f, 0.0125481283f, 0.055979471f}},
    {"H-ZLAF73", 2, {0.507090015f, 1.9243026f, 1.4988641f, 0.0349987602f, 0.00942878144f, 116.086666f}},
    {"H-ZLAF75A", 2, {1.50615126f, 2.18809221f, 0.297955776f, 102.994725f, 0.0127716105f, 0.0569661668f}},
    {"H-ZLAF75B", 2, {0.322804345f, 2.16371144f, 1.59867722f, 0.055262706f, 0.0124574436f, 108.245897f}},
    {"H-ZLAF76", 2, {0.279518569f, 2.01429741f, 1.5507336f, 0.0593856526f, 0.012625744f, 100.032291f}},
    {"H-ZLAF76A", 2, {2.00079286f, 1.53020671f, 0.289955307f, 0.012959987f, 131.107483f, 0.057737977f}},
    {"H-ZLAF78B", 2, {0.299636528f, 2.19452718f, 1.53572385f, 0.047054626f, 0.011540397f, 112.608928f}},
    {"H-ZLAF89L", 2, {2.33250033f, 0.338027439f, 1.63568735f, 0.0127519393f, 0.0535631807f, 114.949418f}},
    {"H-ZLAF90", 2, {0.494167183f, 2.31375143f, 2.2792987f, 0.0602358038f, 0.0137149187f, 148.088436f}},
    {"H-ZLAF92", 2, {1.86762237f, 0.375569196f, 2.45933103f, 123.07862f, 0.059664373f, 0.014148158f}},
    {"H-ZPK1A", 2, {0.944049498f, 1.05017122f, 0.527568709f, 109.035762f, 0.0132903754f, 0.000741462968f}},
    {"H-ZPK3", 2, {0.814545367f, 1.105589f, 0.690102416f, 0.00353645413f, 111.251357f, 0.0141865271f}},
    {"H-ZPK5", 2, {0.259562934f, 1.24131969f, 0.78723739f, 0.0196231869f, 0.00619669959f, 123.753444f}},
    {"H-ZPK7", 2, {0.725400532f, 0.703767661f, 0.77228314f, 0.00296983783f, 0.013434264f, 135.211711f}},
    {"K4A", 2, {0.749532263f, 0.494866234f, 0.96016866f, 0.0148033503f, -0.000264092219f, 95.7190154f}},
    {"QF50", 2, {1.31145759f, 0.840047425f, 0.132407269f, 0.00988576985f, 102.880258f, 0.047752793f}},
    {"QF50GTI", 2, {1.31145759f, 0.840047425f, 0.132407269f, 0.00988576985f, 102.880258f, 0.047752793f}},
    {"4786", 3, {0.795944286f, 0.356650937f, 0.98008113f, 0.00371401467f, 0.0125884185f, 190.314843f}},
    {"5165", 3, {1.12790724f, 0.129745283f, 0.994872985f, 0.00673602593f, 0.0228274219f, 94.2587142f}},
    {"5742", 3, {1.30326513f, 0.127313632f, 0.895143157f, 0.00977713845f, 0.0463756328f, 107.962139f}},
    {"5859", 3, {1.06973916f, 0.422042806f, 0.897510953f, 0.00562417858f, 0.0188055076f, 71.2142596f}},
    {"7054", 3, {1.18710503f, 0.669241576f, 1.10329256f, 0.00549101471f, 0.0196008925f, 83.1244339f}},
};
static const lensimport__listed lensimport__list[] = {
    {"FC5", 7044, 148749},
    {"FCD1", 8161, 149700},
    {"FCD1B", 8149, 149710},
    {"FCD10A", 9028, 145860},
    {"FCD100", 9510, 143700},
    {"FCD515", 6862, 159282},
    {"FCD600", 6050, 159410},
    {"FCD705", 7549, 155032},
    {"PCD4", 6339, 161800},
    {"PCD40", 6388, 161997},
    {"PCD51", 6700, 159349},
    {"BSC7", 6420, 151680},
    {"C3", 5896, 151823},
    {"BAC4", 5604, 156883},
    {"BACD5", 6125, 158913},
    {"BACD14", 6069, 160311},
    {"BACD15", 5812, 162299},
    {"BACD16", 6034, 162041},
    {"BACD18", 5545, 163854},
    {"BACED5", 5085, 165844},
    {"LAC8", 5394, 171300},
    {"LAC14", 5546, 169680},
    {"TAC8", 5467, 172916},
    {"CF6", 5215, 151742},
    {"FEL1", 4582, 154814},
    {"FEL2", 4720, 154072},
    {"FL5", 4089, 158144},
    {"FL6", 4284, 156732},
    {"FD1", 2950, 171736},
    {"FD2", 3384, 164769},
    {"FD4", 2753, 175520},
    {"FD5", 3217, 167270},
    {"FD8", 3116, 168893},
    {"FD10", 2832, 172825},
    {"FD13", 2776, 174077},
    {"FD15", 3005, 169895},
    {"FD60", 2546, 180518},
    {"FD110", 2572, 178472},
    {"FD140", 2661, 176182},
    {"FD225", 2276, 180809},
    {"FDS1", 2088, 192286},
    {"FDS2", 1932, 200272},
    {"FDS3", 1702, 210420},
    {"FDS16", 1648, 198612},
    {"FDS18", 1798, 194595},
    {"FDS20", 2002, 186966},
    {"FDS24", 2396, 192119},
    {"FDS90", 2378, 184666},
    {"FF5", 3545, 159270},
    {"FF8", 2505, 175211},
    {"BAFD7", 4115, 170154},
    {"BAFD8", 3799, 172342},
    {"NBF1", 4923, 174330},
    {"NBFD3", 3963, 180450},
    {"NBFD10", 3734, 183400},
    {"NBFD11", 4393, 178590},
    {"NBFD12", 4235, 179950},
    {"NBFD13", 4073, 180610},
    {"NBFD15", 3327, 180610},
    {"NBFD25", 2515, 185451},
    {"NBFD29", 2974, 177047},
    {"NBFD30", 3000, 185883},
    {"TAF1", 4962, 177250},
    {"TAF2", 4540, 179450},
    {"TAF3", 4650, 180420},
    {"TAF3D", 4650, 180420},
    {"TAF4", 4749, 178800},
    {"TAF5", 4657, 181600},
    {"TAFD5G", 4272, 183481},
    {"TAFD5F", 4272, 183481},
    {"TAFD25", 3131, 190366},
    {"TAFD30", 4081, 188300},
    {"TAFD32", 4074, 187070},
    {"TAFD33", 4014, 188100},
    {"TAFD35", 3525, 191082},
    {"TAFD37", 3737, 190043},
    {"TAFD37A", 3738, 190043},
    {"TAFD40", 2546, 200069},
    {"TAFD45", 3232, 195375},
    {"TAFD55", 2913, 200100},
    {"TAFD65", 2694, 205090},
    {"FCD10", 9027, 145650},
    {"FCD505", 6862, 159282},
    {"LBC3N", 6368, 160625},
    {"BACD2", 5671, 160738},
    {"BACD4", 5858, 161272},
    {"BACD10", 5693, 162280},
    {"BACD11", 6083, 156384},
    {"BACED20", 5303, 164850},
    {"LAC7", 5844, 165160},
    {"LAC9", 5470, 169100},
    {"LAC10", 5034, 172000},
    {"LAC12", 5552, 167790},
    {"LAC13", 5334, 169350},
    {"LACL60", 6021, 164000},
    {"FEL6", 4884, 153172},
    {"FD7", 3457, 163980},
    {"TAC2", 5260, 174100},
    {"TAC4", 5105, 173400},
    {"TAC6", 5232, 175500},
    {"ADF10", 4436, 161310},
    {"ADF50", 3962, 165412},
    {"M-FCD1", 8149, 149710},
    {"M-FCD500", 7167, 155332},
    {"M-PCD4", 6386, 161881},
    {"M-PCD51", 6705, 159201},
    {"M-BACD5N", 6124, 158913},
    {"M-BACD12", 5946, 158313},
    {"M-BACD15", 5819, 162263},
    {"M-LAC130", 5322, 169350},
    {"M-TAC60", 5115, 175501},
    {"M-TAC80", 5404, 172903},
    {"M-FD80", 3116, 168893},
    {"M-FDS1", 2088, 192286},
    {"M-FDS2", 1932, 200178},
    {"M-FDS910", 2406, 182115},
    {"M-NBF1", 4932, 174330},
    {"M-NBFD10", 3728, 183441},
    {"M-NBFD130", 4071, 180610},
    {"M-TAF1", 4949, 177250},
    {"M-TAF31", 4546, 180139},
    {"M-TAF101", 4923, 176802},
    {"M-TAF105", 4949, 177250},
    {"M-TAF401", 4718, 177377},
    {"M-TAFD51", 4271, 182080},
    {"M-TAFD305", 4010, 185135},
    {"M-TAFD307", 3723, 188202},
    {"M-TAFD405", 2983, 195150},
    {"M-LAF81", 4051, 173077},
    {"J-FK01A", 8165, 149700},
    {"J-FKH1", 8257, 149782},
    {"J-FKH2", 9137, 145600},
    {"J-PKH1", 6989, 151860},
    {"J-PSK02", 6334, 161800},
    {"J-PSK03", 6544, 160300},
    {"J-PSKH1", 6790, 159319},
    {"J-PSKH4", 6700, 159349},
    {"J-PSKH8", 5917, 162846},
    {"J-BK7A", 6414, 151680},
    {"J-KZFH1", 4446, 161266},
    {"J-KZFH4", 5507, 155298},
    {"J-KZFH6", 3764, 168376},
    {"J-KZFH7", 4618, 173211},
    {"J-KZFH9", 3226, 173800},
    {"J-BAF12", 4483, 163930},
    {"J-BASF7", 4102, 170154},
    {"J-BASF8", 3803, 172342},
    {"J-F16", 3527, 159270},
    {"J-SF03", 2380, 184666},
    {"J-SFS3", 2627, 178470},
    {"J-SFH1", 2274, 180809},
    {"J-SFH2", 2308, 186074},
    {"J-SFH4", 2735, 166382},
    {"J-SFH5", 2471, 175575},
    {"J-SFH6", 2604, 171338},
    {"J-LAK18", 5461, 172916},
    {"J-LAK01", 6020, 164000},
    {"J-LAK02", 5735, 167000},
    {"J-LAK04", 5624, 165100},
    {"J-LAK06", 5067, 167790},
    {"J-LAK09", 5151, 173400},
    {"J-LAK011", 5277, 174100},
    {"J-LASKH2", 5234, 175500},
    {"J-LAF01", 4811, 170000},
    {"J-LAF02", 4361, 172000},
    {"J-LAF04", 4786, 175700},
    {"J-LAF05", 4011, 176200},
    {"J-LAF09", 4845, 169700},
    {"J-LAF010", 4926, 174320},
    {"J-LAF016", 3492, 180100},
    {"J-LAFH3", 2869, 179504},
    {"J-LASF01", 4417, 178590},
    {"J-LASF02", 4209, 179952},
    {"J-LASF03", 4097, 180610},
    {"J-LASF05", 4273, 183481},
    {"J-LASF08A", 4069, 188300},
    {"J-LASF09A", 4659, 181600},
    {"J-LASF010", 3718, 183400},
    {"J-LASF013", 3961, 180440},
    {"J-LASF014", 4735, 178800},
    {"J-LASF015", 4660, 180400},
    {"J-LASF016", 4962, 177250},
    {"J-LASF017", 4531, 179500},
    {"J-LASF021", 3235, 185026},
    {"J-LASFH2", 4678, 176684},
    {"J-LASFH6", 3334, 180610},
    {"J-LASFH9A", 3577, 190265},
    {"J-LASFH13", 3127, 190366},
    {"J-LASFH15", 2937, 195000},
    {"J-LASFH16", 2912, 200100},
    {"J-LASFH17", 2546, 200069},
    {"J-LASFH21", 3233, 195375},
    {"J-LASFH22", 4379, 184850},
    {"J-LASFH23", 2703, 185000},
    {"J-LASFH24", 2526, 190200},
    {"Q-SK52S", 5951, 158286},
    {"Q-SK55S", 6114, 158887},
    {"Q-LAK52S", 5489, 167798},
    {"Q-LAK53S", 5330, 169343},
    {"Q-LASF03S", 4074, 180604},
    {"E-PKH1", 6989, 151860},
    {"E-BAF12", 4489, 163930},
    {"E-LAF11", 3159, 175692},
    {"E-LAFH2", 3389, 180384},
    {"E-LASF04", 4435, 181554},
    {"E-LASF08", 4077, 188300},
    {"E-LASF09", 4663, 181600},
    {"E-LASFH9", 3571, 190265},
    {"E-LAKH1", 5228, 174810},
    {"E-SFS3", 2630, 178470},
    {"LAF9", 2856, 179504},
    {"SF03", 2388, 184666},
    {"J-FK01", 8160, 149700},
    {"J-LASF08", 4069, 188300},
    {"LAFH3", 2854, 179504},
    {"BK7A", 6413, 151680},
    {"BALKN3", 6025, 151849},
    {"BASF1", 3909, 162606},
    {"BASF6", 4193, 166755},
    {"BASF10", 0, 165016},
    {"BASF12", 3920, 166998},
    {"BASF13", 0, 169761},
    {"BASF51", 3811, 172373},
    {"BASF52", 4101, 170181},
    {"BASF54", 0, 173627},
    {"BASF56", 0, 165715},
    {"BASF57", 0, 165147},
    {"BK1", 6346, 151009},
    {"BK3", 6506, 149831},
    {"BK6", 0, 153113},
    {"BK8", 6369, 152015},
    {"F1", 3570, 162588},
    {"F3", 3704, 161293},
    {"F4", 3663, 161659},
    {"F6", 3534, 163636},
    {"F7", 0, 162536},
    {"F8", 3918, 159551},
    {"F9", 0, 162045},
    {"F13", 0, 162237},
    {"F14", 0, 160140},
    {"F15", 0, 160565},
    {"FK52", 0, 148605},
    {"FK54", 9070, 143700},
    {"FN11", 3618, 162096},
    {"K3", 5882, 151823},
    {"K4", 0, 151895},
    {"K11", 0, 150013},
    {"K50", 6018, 152257},
    {"KF3", 5470, 151454},
    {"KF6", 5220, 151742},
    {"KZFN1", 0, 155115},
    {"KZFN2", 0, 152944},
    {"KZFS1", 0, 161310},
    {"KZFS6", 0, 159197},
    {"KZFSN7", 0, 168064},
    {"KZFSN2", 5416, 155836},
    {"KZFSN9", 0, 159856},
    {"LAF11A", 0, 175693},
    {"LAF13", 0, 177551},
    {"LAF20", 0, 168248},
    {"LAF22A", 0, 178179},
    {"LAFN8", 0, 173520},
    {"LAFN10", 0, 178443},
    {"LAFN21", 4747, 178831},
    {"LAFN23", 0, 168900},
    {"LAFN24", 0, 175719},
    {"LAFN28", 4957, 177314},
    {"LAK11", 5726, 165830},
    {"LAK16A", 5178, 173350},
    {"LAK23", 5738, 166882},
    {"LAK28", 0, 174429},
    {"LAK31", 5642, 169673},
    {"LAK33", 0, 175398},
    {"LAKN6", 0, 164250},
    {"LAKN13", 5333, 169350},
    {"LAK13", 5333, 169350},
    {"LASF3", 4061, 180801},
    {"LASF14A", 0, 182223},
    {"LASF18A", 0, 191348},
    {"LASF32", 0, 180349},
    {"LASF33", 0, 180596},
    {"LASFN15", 0, 187800},
    {"LASFN30", 4638, 180318},
    {"LASFN31", 4101, 188067},
    {"LF8", 0, 156444},
    {"LLF2", 4722, 154072},
    {"LLF6", 4876, 153172},
    {"LLF7", 4539, 154883},
    {"PK1", 0, 150378},
    {"PK2", 0, 151821},
    {"PK3", 0, 152542},
    {"PK50", 0, 152054},
    {"PSK2", 6310, 156873},
    {"PSK50", 0, 155753},
    {"PSK52", 6541, 160310},
    {"PSK54", 0, 158599},
    {"SF3", 2820, 174000},
    {"SF9", 0, 165446},
    {"SF12", 3384, 164831},
    {"SF13", 2760, 174077},
    {"SF16", 0, 164611},
    {"SF18", 2925, 172151},
    {"SF53", 2869, 172830},
    {"SF54", 2809, 174080},
    {"SF55", 2695, 176180},
    {"SF58", 0, 191761},
    {"SF59", 0, 195250},
    {"SF63", 0, 174840},
    {"SFL4", 0, 175520},
    {"SFL56", 0, 178470},
    {"SK1", 0, 161025},
    {"SK3", 5886, 160881},
    {"SK6", 0, 161375},
    {"SK7", 0, 160729},
    {"SK8", 0, 161117},
    {"SK12", 5945, 158313},
    {"SK13", 0, 159181},
    {"SK18A", 5542, 163854},
    {"SKN18", 5542, 163854},
    {"SK51", 6031, 162090},
    {"SSK1", 5391, 161720},
    {"SSK3", 0, 161484},
    {"SSK4", 5514, 161765},
    {"SSK50", 0, 161795},
    {"SSK51", 5365, 160361},
    {"ZK1", 0, 153315},
    {"TIF6", 0, 161650},
    {"LASF36A", 0, 179712},
    {"PSK53A", 0, 162014},
    {"SK55", 0, 162041},
    {"TIF3", 0, 154765},
    {"TIFN5", 0, 159356},
    {"UBK7", 0, 151680},
    {"UK50", 0, 152257},
    {"SSKN5", 0, 165844},
    {"BAF9", 4776, 164328},
    {"TAFD5", 4298, 183500},
    {"NBFD5", 4026, 176200},
    {"FDS9", 2383, 184666},
    {"KZFSN5", 3970, 165412},
    {"NLASF", 4970, 177300},
    {"NLAF9", 2840, 179500},
    {"NLK1", 5750, 167000},
    {"PBL1", 4580, 154814},
    {"PBL2", 4720, 154072},
    {"PBL6", 4890, 153172},
    {"PBL25", 4070, 158144},
    {"PBM1", 3570, 162588},
    {"PBM2", 3630, 162004},
    {"PBM5", 3800, 160342},
    {"PBM8", 3920, 159551},
    {"PBM22", 3380, 164769},
    {"PBM25", 3210, 167270},
    {"PBM27", 3450, 163980},
    {"PBM28", 3108, 168893},
    {"PBM35", 3010, 169895},
    {"PBH4", 2750, 175520},
    {"PBH6", 2540, 180518},
    {"PBH10", 2850, 172825},
    {"PBH11", 2570, 178472},
    {"PBH13", 2780, 174077},
    {"PBH14", 2650, 176182},
    {"PBH18", 2924, 172151},
    {"PBH23", 2620, 178470},
    {"PBH53", 2390, 184666},
    {"SFLD4", 2753, 175520},
    {"SFLD6", 2546, 180518},
    {"SFLD14", 2661, 176182},
    {"PMMA", 5744, 149176},
    {"ACRYLIC", 5744, 149176},
    {"POLYCARB", 2991, 158547},
    {"POLYCARBONATE", 2991, 158547},
    {"PC", 2991, 158547},
    {"POLYSTYR", 3087, 159048},
    {"POLYSTYRENE", 3087, 159048},
    {"POLYC", 2991, 158547},
    {"POLYS", 3087, 159048},
    {"E48R", 5604, 153116},
    {"ZEONEX", 5604, 153116},
    {"OKP4", 2699, 160730},
    {"OKP4HT", 2333, 163200},
    {"COC", 5623, 153373},
    {"F_SILICA", 6782, 145846},
    {"SILICA", 6782, 145846},
    {"FUSEDSILICA", 6782, 145846},
    {"SIO2", 6782, 145846},
    {"CAF2", 9499, 143385},
    {"FLUORITE", 9499, 143385},
    {"FLUORSPAR", 9499, 143385},
    {"BAF8", 4700, 162374},
    {"BAFN11", 4833, 166672},
    {"SF7", 3455, 163980},
    {"WATER", 5576, 133340},
    {"SEAWATER", 5490, 133946},
    {"QUARTZ", 6969, 154428},
    {"MGF2", 10622, 137774},
    {"BAF2", 8161, 147447},
    {"SAPPHIRE", 7224, 176818},
    {"B270", 5850, 152300},
};
/* glasses end */

enum {
    LENSIMPORT__GLASSES = sizeof lensimport__glasses / sizeof lensimport__glasses[0],
    LENSIMPORT__LISTED = sizeof lensimport__list / sizeof lensimport__list[0],
    LENSIMPORT__MAKERS = sizeof lensimport__makers / sizeof lensimport__makers[0]
};

static char lensimport__upper(char ch) { return ch >= 'a' && ch <= 'z' ? (char)(ch - 'a' + 'A') : ch; }
static int lensimport__digit(char ch) { return ch >= '0' && ch <= '9'; }
static int lensimport__plain(char ch) { return lensimport__digit(ch) || (lensimport__upper(ch) >= 'A' && lensimport__upper(ch) <= 'Z'); }

/* Equal but for capitals and what is neither letter nor digit. */
static int lensimport__alike(const char *a, size_t size, const char *b)
{
    size_t i = 0;
    for (;;) {
        while (i < size && !lensimport__plain(a[i])) i++;
        while (*b != 0 && !lensimport__plain(*b)) b++;
        if (i == size || *b == 0) return i == size && *b == 0;
        if (lensimport__upper(a[i++]) != lensimport__upper(*b++)) return 0;
    }
}

/* The next word of a list of makers; 0 at its end. */
static int lensimport__maker_word(const char **list, const char **word, size_t *size)
{
    if (*list == NULL) return 0;
    while (**list != 0 && !lensimport__plain(**list)) ++*list;
    *word = *list;
    while (lensimport__plain(**list)) ++*list;
    *size = (size_t)(*list - *word);
    return *size > 0;
}

/* Index of a maker, or -1. */
static int32_t lensimport__maker(const char *word, size_t size)
{
    int32_t i;
    for (i = 0; i < LENSIMPORT__MAKERS; i++)
        if (lensimport__alike(word, size, lensimport__makers[i])) return i;
    return -1;
}

/* A row whose name is `prefix`-NAME, or NAME if prefix is 0, of one maker or of all (-1); or -1. */
static int32_t lensimport__row_named(char prefix, const char *name, size_t size, int32_t maker)
{
    int32_t i;
    for (i = 0; i < LENSIMPORT__GLASSES; i++) {
        const lensimport__glass *g = &lensimport__glasses[i];
        if (maker >= 0 && g->maker != maker) continue;
        if (prefix == 0 ? lensimport__alike(name, size, g->name) : g->name[0] == prefix && g->name[1] == '-' && lensimport__alike(name, size, g->name + 2))
            return i;
    }
    return -1;
}

static int32_t lensimport__listed_named(const char *name, size_t size)
{
    int32_t i;
    for (i = 0; i < LENSIMPORT__LISTED; i++)
        if (lensimport__alike(name, size, lensimport__list[i].name)) return i;
    return -1;
}

static void lensimport__numbers(lensimport_glass *out, double nd, double vd)
{
    memset(out->medium.c, 0, sizeof out->medium.c);
    out->nd = out->medium.c[0] = nd;
    out->vd = out->medium.c[1] = vd;
    out->medium.kind = LFLARE_MEDIUM_ABBE;
}

/* A float's decimal digits, 8 of them, so that it is written short. */
static double lensimport__round(double v)
{
    double unit = v != 0 ? pow(10.0, 7 - floor(log10(fabs(v)))) : 1;
    return floor(v * unit + 0.5) / unit;
}

static void lensimport__take_row(int32_t row, lensimport_glass *out)
{
    const lensimport__glass *g = &lensimport__glasses[row];
    int32_t i;
    memset(out, 0, sizeof *out);
    memcpy(out->name, g->name, sizeof g->name);
    memcpy(out->medium.glass, g->name, sizeof g->name);
    memcpy(out->maker, lensimport__makers[g->maker], sizeof out->maker);
    out->medium.kind = LFLARE_MEDIUM_SELLMEIER;
    for (i = 0; i < 6; i++) out->medium.c[i] = lensimport__round((double)g->c[i]);
    out->nd = lflare_index(&out->medium, LENSIMPORT__NM_D);
    out->vd = (out->nd - 1) / (lflare_index(&out->medium, LENSIMPORT__NM_F) - lflare_index(&out->medium, LENSIMPORT__NM_C));
    out->match = LENSIMPORT_MATCH_NAME;
}

static lensimport_match lensimport__take(int32_t row, lensimport_match match, lensimport_glass *out)
{
    lensimport__take_row(row, out);
    return out->match = match;
}

/* Digits of a code: 517642, 517.642, 516800.641700, 517642.251 (with the density). */
static int lensimport__code(const char *name, size_t size, double *nd, double *vd, double *half)
{
    size_t i, point = size, front, back;
    double a = 0, b = 0;
    for (i = 0; i < size; i++) {
        if (name[i] == '.' && point == size) point = i;
        else if (!lensimport__digit(name[i])) return 0;
    }
    front = point;
    back = point < size ? size - point - 1 : 0;
    if (front == 6 && (back == 0 || back == 3)) { front = back = 3; point = 3; }
    else if (front < 3 || front > 7 || back < 3 || back > 7) return 0;
    else point++;
    for (i = 0; i < front; i++) a = a * 10 + (name[i] - '0');
    for (i = point; i < point + back; i++) b = b * 10 + (name[i] - '0');
    *nd = 1 + a * pow(10.0, -(double)front);
    *vd = b * pow(10.0, 2 - (double)back);
    if (*nd < 1.2) *nd += 1; /* 001291 is a glass of index 2.001 */
    half[0] = 0.5000001 * pow(10.0, -(double)(front < 5 ? front : 5));
    half[1] = 0.5000001 * pow(10.0, 2 - (double)(back < 4 ? back : 4));
    return *vd >= 5;
}

/* The catalogue glass that rounds to a code, the preferred makers' first. */
static int32_t lensimport__row_coded(double nd, double vd, const double *half, const char *prefer)
{
    const char *word;
    size_t size;
    int32_t i;
    for (;;) {
        int32_t maker = -1, more = lensimport__maker_word(&prefer, &word, &size), found = -1;
        double best = HUGE_VAL;
        if (more && (maker = lensimport__maker(word, size)) < 0) continue;
        for (i = 0; i < LENSIMPORT__GLASSES; i++) {
            lensimport_glass g;
            if (maker >= 0 && lensimport__glasses[i].maker != maker) continue;
            if (!more && maker < 0 && found >= 0 && lensimport__glasses[i].maker != lensimport__glasses[found].maker) break; /* the first maker that has it */
            lensimport__take_row(i, &g);
            if (fabs(g.nd - nd) > half[0] || fabs(g.vd - vd) > half[1] || fabs(g.nd - nd) >= best) continue;
            best = fabs(g.nd - nd);
            found = i;
        }
        if (found >= 0 || !more) return found;
    }
}

static lensimport_match lensimport__take_listed(int32_t row, lensimport_glass *out)
{
    memset(out, 0, sizeof *out);
    memcpy(out->name, lensimport__list[row].name, sizeof lensimport__list[row].name);
    memcpy(out->medium.glass, out->name, sizeof out->name);
    lensimport__numbers(out, lensimport__list[row].nd / 1e5, lensimport__list[row].vd / 1e2);
    if (lensimport__list[row].vd == 0) out->medium.kind = LFLARE_MEDIUM_CONSTANT;
    return out->match = LENSIMPORT_MATCH_NUMBERS;
}

/* A name as it stands: the preferred makers, then all, then the list. CDGM's F3 is H-F3 today and Schott's F3 another glass, on
   the list: which of the two is preferred decides. */
static lensimport_match lensimport__find_exact(const char *name, size_t size, const char *prefer, lensimport_glass *out)
{
    const char *word;
    size_t length;
    int32_t row, maker;
    while (lensimport__maker_word(&prefer, &word, &length)) {
        if ((maker = lensimport__maker(word, length)) < 0) continue;
        if ((row = lensimport__row_named(0, name, size, maker)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_NAME, out);
        if (lensimport__alike(word, length, "CDGM") && (row = lensimport__row_named('H', name, size, maker)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_SUCCESSOR, out);
        if (lensimport__alike(word, length, "SCHOTT") && (row = lensimport__listed_named(name, size)) >= 0) return lensimport__take_listed(row, out);
    }
    if ((row = lensimport__row_named(0, name, size, -1)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_NAME, out);
    if ((row = lensimport__listed_named(name, size)) >= 0) return lensimport__take_listed(row, out);
    return LENSIMPORT_MATCH_NONE;
}

/* Today's name of an old one: N-BK7 of BK7, N-LAK7 of LAKN7, S-BSL7 of BSL7; CDGM's H- only where that maker is preferred, since
   its names mean other glasses elsewhere. */
static lensimport_match lensimport__find_successor(const char *name, size_t size, const char *prefer, lensimport_glass *out)
{
    char old[24];
    const char *word;
    size_t length, i;
    int32_t row, cdgm = 0;
    while (lensimport__maker_word(&prefer, &word, &length)) cdgm |= lensimport__alike(word, length, "CDGM");
    if (cdgm && (row = lensimport__row_named('H', name, size, -1)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_SUCCESSOR, out);
    if ((row = lensimport__row_named('N', name, size, -1)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_SUCCESSOR, out);
    for (i = 1; i + 1 < size && size < sizeof old; i++)
        if (lensimport__upper(name[i]) == 'N' && lensimport__digit(name[i + 1])) { /* LAKN7 */
            memcpy(old, name, i);
            memcpy(old + i, name + i + 1, size - i - 1);
            if ((row = lensimport__row_named('N', old, size - 1, -1)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_SUCCESSOR, out);
        }
    if ((row = lensimport__row_named('S', name, size, -1)) >= 0) return lensimport__take(row, LENSIMPORT_MATCH_SUCCESSOR, out);
    return LENSIMPORT_MATCH_NONE;
}

/* A name up to its last digit. */
static size_t lensimport__stem(const char *name, size_t size)
{
    size_t n = size;
    while (n > 0 && !lensimport__digit(name[n - 1])) n--;
    return n > 0 ? n : size;
}

/* CDGM's melts follow each other by letters: H-LAF3 is H-LAF3B today, H-K9 H-K9L. */
static lensimport_match lensimport__find_melt(const char *name, size_t size, lensimport_glass *out)
{
    size_t stem = lensimport__stem(name, size);
    int32_t i;
    for (i = 0; i < LENSIMPORT__GLASSES; i++) {
        char other[sizeof lensimport__glasses[0].name + 1];
        memset(other, 0, sizeof other);
        memcpy(other, lensimport__glasses[i].name, lensimport__stem(lensimport__glasses[i].name, strlen(lensimport__glasses[i].name)));
        if (lensimport__alike(name, stem, other)) return lensimport__take(i, LENSIMPORT_MATCH_SUCCESSOR, out);
    }
    return LENSIMPORT_MATCH_NONE;
}

/* K-LASFN9, KLAK7: Sumita numbers its lanthanum glasses in its own way. */
static int lensimport__sumita_lanthanum(const char *name, size_t size)
{
    return size > 4 && (lensimport__alike(name, 3, "KLA") || lensimport__alike(name, 4, "KLA"));
}

/* HOYA's MC-TAFD51-50 and MP-TAFD51 are M-TAFD51, moulded in other ways. */
static lensimport_match lensimport__find_mould(const char *name, size_t size, lensimport_glass *out)
{
    char mould[24];
    size_t n = 5 < size ? 5 : size;
    while (n < size && name[n] != '-') n++;
    if (n > sizeof mould) return LENSIMPORT_MATCH_NONE;
    mould[0] = 'M';
    memcpy(mould + 1, name + 2, n - 2);
    return lensimport__find_exact(mould, n - 1, NULL, out);
}

/* Without its maker's prefix (J-LAK14, E-FD10, MC-FD80) or a quality's suffix (SF6HT, SF57HTULTRA): the same glass type. CDGM's
   types are other makers' by number, not by name. */
static lensimport_match lensimport__find_stripped(const char *name, size_t size, const char *prefer, lensimport_glass *out)
{
    static const char *const tails[] = {"HTULTRA", "ULTRA", "HTI", "HT", "W", "FG"};
    lensimport_match match = LENSIMPORT_MATCH_NONE;
    size_t i, k;
    if (size > 2 && name[1] == '-' && (lensimport__upper(name[0]) == 'H' || lensimport__upper(name[0]) == 'D')) return lensimport__find_melt(name, size, out);
    if (size > 2 && lensimport__upper(name[0]) == 'M' && name[2] == '-' && (lensimport__upper(name[1]) == 'C' || lensimport__upper(name[1]) == 'P')) match = lensimport__find_mould(name, size, out);
    for (i = 1; i <= 2 && i + 1 < size && match == LENSIMPORT_MATCH_NONE; i++) {
        if (name[i] != '-' || lensimport__sumita_lanthanum(name, size)) continue;
        match = lensimport__find_exact(name + i + 1, size - i - 1, prefer, out);
        if (match == LENSIMPORT_MATCH_NONE) match = lensimport__find_successor(name + i + 1, size - i - 1, NULL, out);
    }
    for (i = 0; i < sizeof tails / sizeof tails[0] && match == LENSIMPORT_MATCH_NONE; i++) {
        k = strlen(tails[i]);
        if (size <= k + 1 || !lensimport__alike(name + size - k, k, tails[i])) continue;
        match = lensimport__find_exact(name, size - k, prefer, out);
        if (match == LENSIMPORT_MATCH_NONE) match = lensimport__find_successor(name, size - k, prefer, out);
    }
    if (match == LENSIMPORT_MATCH_NAME) match = out->match = LENSIMPORT_MATCH_SUCCESSOR;
    return match;
}

static lensimport_match lensimport__find_any(const char *name, size_t size, const char *prefer, lensimport_glass *out)
{
    lensimport_match match = lensimport__find_exact(name, size, prefer, out);
    if (match == LENSIMPORT_MATCH_NONE) match = lensimport__find_successor(name, size, prefer, out);
    if (match == LENSIMPORT_MATCH_NONE) match = lensimport__find_stripped(name, size, prefer, out);
    return match;
}

/* CODE V writes J-LAK14 of Hikari as JLAK14_HIKARI: the prefix without its hyphen. */
static lensimport_match lensimport__find_fused(const char *name, size_t size, const char *maker, size_t maker_size, lensimport_glass *out)
{
    static const struct {
        char maker[8], letter;
    } fused[] = {{"HIKARI", 'J'}, {"SUMITA", 'K'}, {"HOYA", 'M'}, {"HOYA", 'E'}};
    lensimport_match match = LENSIMPORT_MATCH_NONE;
    size_t i;
    for (i = 0; i < sizeof fused / sizeof fused[0] && match == LENSIMPORT_MATCH_NONE; i++) {
        if (size < 3 || lensimport__upper(name[0]) != fused[i].letter || !lensimport__alike(maker, maker_size, fused[i].maker) || lensimport__sumita_lanthanum(name, size)) continue;
        match = lensimport__find_any(name + 1, size - 1, NULL, out);
        if (match == LENSIMPORT_MATCH_NAME) match = out->match = LENSIMPORT_MATCH_SUCCESSOR;
    }
    return match;
}

LENSIMPORT_API lensimport_match lensimport_glass_find(const char *name, size_t size, const char *prefer, lensimport_glass *out)
{
    lensimport_match match;
    lensimport_glass g;
    double nd, vd, half[2];
    size_t i, k;
    int32_t parts = 2; /* at its end that may not be the glass's */
    if (name == NULL || out == NULL || size == 0 || size > 40) return LENSIMPORT_MATCH_NONE;
    memset(&g, 0, sizeof g);
    if (lensimport__code(name, size, &nd, &vd, half)) {
        int32_t row = lensimport__row_coded(nd, vd, half, prefer);
        if (row >= 0) {
            lensimport__take(row, LENSIMPORT_MATCH_CODE, &g);
        } else {
            lensimport__numbers(&g, nd, vd);
            memcpy(g.name, name, size < sizeof g.name ? size : sizeof g.name - 1);
            memcpy(g.medium.glass, g.name, sizeof g.name);
            g.match = LENSIMPORT_MATCH_CODE_ONLY;
        }
        *out = g;
        return g.match;
    }
    match = lensimport__find_any(name, size, prefer, &g);
    for (i = size; i > 1 && match == LENSIMPORT_MATCH_NONE && parts > 0; i--) { /* NBK7_SCHOTT, L-TIM28_MOLD, E48R_2017_ZEON */
        char maker[16];
        if (name[i - 1] != '_') continue;
        parts--;
        k = size - i;
        if (k > 0 && k < sizeof maker && lensimport__maker(name + i, k) >= 0) {
            memcpy(maker, name + i, k);
            maker[k] = 0;
            match = lensimport__find_any(name, i - 1, maker, &g);
        } else {
            match = lensimport__find_any(name, i - 1, prefer, &g);
        }
        if (match == LENSIMPORT_MATCH_NONE) match = lensimport__find_fused(name, i - 1, name + i, k, &g);
    }
    if (match != LENSIMPORT_MATCH_NONE) *out = g;
    return match;
}

LENSIMPORT_API double lensimport_glass_nearest(double nd, double vd, const char *makers, lensimport_glass *out)
{
    double best = HUGE_VAL;
    int32_t i, found = -1;
    for (i = 0; i < LENSIMPORT__GLASSES; i++) {
        lensimport_glass g;
        const char *list = makers, *word;
        size_t size;
        int wanted = makers == NULL;
        double d;
        while (lensimport__maker_word(&list, &word, &size)) wanted |= lensimport__maker(word, size) == lensimport__glasses[i].maker;
        if (!wanted) continue;
        lensimport__take_row(i, &g);
        d = hypot((g.nd - nd) / 0.001, (g.vd - vd) / 0.5);
        if (d < best) { best = d; found = i; }
    }
    if (found >= 0 && out != NULL) lensimport__take_row(found, out);
    return best;
}

LENSIMPORT_API int32_t lensimport_glass_count(void) { return LENSIMPORT__GLASSES; }

LENSIMPORT_API lflare_result lensimport_glass_get(int32_t index, lensimport_glass *out)
{
    if (out == NULL || index < 0 || index >= LENSIMPORT__GLASSES) return LFLARE_ERROR_ARGUMENT;
    lensimport__take_row(index, out);
    return LFLARE_OK;
}

/* >> 4 text */
/* Bytes to lines of UTF-8, whatever they were; lines to words, or to cells between tabs. */

enum { LENSIMPORT__LINE = 2048 };

/* What a reader has learnt of the system, beside the prescription's rows. Lengths in the file's unit. */
typedef struct lensimport__facts {
    double scale;              /* mm of the file's unit, 0 = 1 */
    double epd;                /* diameter of the entrance pupil, 0 unknown */
    double image_radius;       /* of the image circle, 0 unknown */
    double field_degrees;      /* half the field angle, 0 unknown */
    double object_distance;    /* infinite, unless the file has a finite one */
    lflare_medium object;      /* the medium in front of the first surface */
    int32_t gap_unknown;       /* the last gap is to be derived */
    int32_t diameters;         /* semi-diameters may be diameters: FlareSim */
    int32_t stop_counts;       /* the f-number may be a working stop, which the stop's size shows: OpenLensFlare */
    const char *catalogues;    /* the file's own preference, "" for none */
    int32_t refusal_line;
    lensimport_refusal refusal;
    char refused[24];          /* the offending word */
} lensimport__facts;

typedef struct lensimport__reader {
    const uint8_t *bytes;
    size_t size, at;
    int32_t unit, high;        /* bytes a character; of two, which is the high one */
    int32_t line, partly;      /* number of the line in `text`; the line goes on beyond it */
    size_t length, next;       /* of `text`; what is read next */
    const char *word;          /* the word last read */
    size_t word_size;
    lflare_prescription *p;
    lensimport_report *report;
    const lensimport_desc *desc;
    lflare_error *error;
    lflare_result failed;
    lensimport__facts facts;
    int32_t lookups;           /* of glasses, bounded: they are not cheap */
    char catalogues[128];
    char text[LENSIMPORT__LINE + 4];
} lensimport__reader;

static int32_t lensimport__column(const lensimport__reader *r)
{
    return r->word >= r->text && r->word <= r->text + r->length ? (int32_t)(r->word - r->text) + 1 : 1;
}

/* The first failure counts. Always returns 0. */
static int lensimport__fail_at(lensimport__reader *r, lflare_result code, int32_t line, int32_t column, const char *format, ...)
{
    va_list list;
    if (r->failed != LFLARE_OK) return 0;
    r->failed = code;
    if (r->error == NULL) return 0;
    r->error->code = code;
    r->error->line = line > 0 || column == 0 ? line : 1;
    r->error->column = column;
    va_start(list, format);
    lensimport__format_list(r->error->text, sizeof r->error->text, format, list);
    va_end(list);
    return 0;
}

/* Any text fit for a message or a label: short, printable, no blanks in a label. */
static const char *lensimport__clean(const char *text, size_t size, int label, char *out, size_t room)
{
    size_t i, n = size < room - 1 ? size : room - 1;
    for (i = 0; i < n; i++) out[i] = text[i] > 32 && text[i] < 127 && !(label && text[i] == '#') ? text[i] : label ? '_' : text[i] == ' ' ? ' ' : '?';
    out[n] = 0;
    return out;
}

/* About the word last read; `format` has one %s for it. */
static int lensimport__bad(lensimport__reader *r, const char *format)
{
    char quoted[28];
    return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), format, lensimport__clean(r->word, r->word_size, 0, quoted, sizeof quoted));
}

static void lensimport__note(lensimport__reader *r, lensimport_note_kind kind, int32_t line, double value, double stated, const char *label)
{
    lensimport_note *note;
    if (r->report->note_count == LENSIMPORT_MAX_NOTES) return;
    note = &r->report->notes[r->report->note_count++];
    memset(note, 0, sizeof *note);
    note->kind = kind;
    note->line = line;
    note->value = value;
    note->stated = stated;
    if (label != NULL) lensimport__clean(label, strlen(label), 0, note->label, sizeof note->label);
}

/* What cannot be a refracting lens. The file is read on: of several reasons the most telling is given. */
static void lensimport__refuse(lensimport__reader *r, lensimport_refusal refusal, int32_t line, const char *word, size_t size)
{
    if (r->facts.refusal != LENSIMPORT_REFUSED_NOT && r->facts.refusal <= refusal) return;
    r->facts.refusal = refusal;
    r->facts.refusal_line = line;
    lensimport__clean(word, size, 0, r->facts.refused, sizeof r->facts.refused);
}

static int32_t lensimport__unit_at(const lensimport__reader *r, size_t at)
{
    return r->unit == 1 ? r->bytes[at] : r->bytes[at + (size_t)r->high] << 8 | r->bytes[at + (size_t)(1 - r->high)];
}

/* Byte order marks; UTF-16 without one shows as every second byte zero. */
static void lensimport__rewind(lensimport__reader *r)
{
    const uint8_t *b = r->bytes;
    r->at = r->length = r->next = r->word_size = 0;
    r->line = r->partly = 0;
    r->unit = 1;
    r->word = r->text;
    r->text[0] = 0;
    if (r->size >= 2 && ((b[0] == 0xff && b[1] == 0xfe) || (b[0] == 0xfe && b[1] == 0xff))) {
        r->unit = 2;
        r->high = b[0] == 0xff;
        r->at = 2;
    } else if (r->size >= 2 && (b[0] == 0) != (b[1] == 0)) {
        r->unit = 2;
        r->high = b[1] == 0;
    } else if (r->size >= 3 && b[0] == 0xef && b[1] == 0xbb && b[2] == 0xbf) {
        r->at = 3;
    }
}

/* The length of a well-formed UTF-8 sequence here, 0 if it is none. */
static size_t lensimport__utf8(const uint8_t *b, size_t left)
{
    size_t n = b[0] >= 0xc2 && b[0] < 0xe0 ? 2 : b[0] >= 0xe0 && b[0] < 0xf0 ? 3 : b[0] >= 0xf0 && b[0] < 0xf5 ? 4 : 0, i;
    if (n > left) return 0;
    for (i = 1; i < n; i++)
        if ((b[i] & 0xc0) != 0x80) return 0;
    return n;
}

/* One character to `text`: what is not UTF-8 is Latin-1; control characters are blanks. */
static void lensimport__put_char(lensimport__reader *r)
{
    int32_t c = lensimport__unit_at(r, r->at);
    size_t n = r->unit == 1 && c >= 128 ? lensimport__utf8(r->bytes + r->at, r->size - r->at) : 0;
    if (n > 0) {
        memcpy(r->text + r->length, r->bytes + r->at, n);
        r->length += n;
        r->at += n;
        return;
    }
    r->at += (size_t)r->unit;
    if (c >= 0xd800 && c < 0xe000) c = '?'; /* beyond the first plane: in names only */
    if (c < 128) {
        r->text[r->length++] = (char)(c < 32 && c != '\t' ? ' ' : c == 127 ? ' ' : c);
    } else if (c < 0x800) {
        r->text[r->length++] = (char)(0xc0 | c >> 6);
        r->text[r->length++] = (char)(0x80 | (c & 63));
    } else {
        r->text[r->length++] = (char)(0xe0 | c >> 12);
        r->text[r->length++] = (char)(0x80 | (c >> 6 & 63));
        r->text[r->length++] = (char)(0x80 | (c & 63));
    }
}

/* Fills `text` with the next line, or with what follows of one that is longer than that. */
static int lensimport__fill(lensimport__reader *r)
{
    size_t step = (size_t)r->unit;
    if (r->at + step > r->size) return 0;
    if (!r->partly) r->line++;
    r->partly = 0;
    r->length = r->next = 0;
    while (r->at + step <= r->size) {
        int32_t c = lensimport__unit_at(r, r->at);
        if (c == '\n' || c == '\r') {
            r->at += step;
            if (c == '\r' && r->at + step <= r->size && lensimport__unit_at(r, r->at) == '\n') r->at += step;
            break;
        }
        if (r->length + 4 > LENSIMPORT__LINE) { r->partly = 1; break; }
        lensimport__put_char(r);
    }
    r->text[r->length] = 0;
    r->word = r->text;
    r->word_size = 0;
    return 1;
}

/* The next line, of one that is too long its beginning; 0 at the end. */
static int lensimport__line(lensimport__reader *r)
{
    while (r->partly) {
        int32_t c = r->at + (size_t)r->unit <= r->size ? lensimport__unit_at(r, r->at) : '\n';
        if (c == '\n' || c == '\r') r->partly = 0;
        if (r->at + (size_t)r->unit > r->size) return 0;
        r->at += (size_t)r->unit;
        if (c == '\r' && r->at + (size_t)r->unit <= r->size && lensimport__unit_at(r, r->at) == '\n') r->at += (size_t)r->unit;
    }
    return lensimport__fill(r);
}

/* The next character of the whole text, lines ended by '\n'; 0 at the end. */
static char lensimport__char(lensimport__reader *r)
{
    while (r->next >= r->length) {
        if (r->next == r->length && r->line > 0 && !r->partly) {
            r->next++;
            return '\n';
        }
        if (!lensimport__fill(r)) return 0;
    }
    r->word = r->text + r->next;
    return r->text[r->next++];
}

static int lensimport__blank(char ch) { return ch == ' ' || ch == '\t'; }

/* The next word of the line, between blanks; what stands in double quotes is one. 0 at the end of the line. */
static int lensimport__word(lensimport__reader *r)
{
    const char *t = r->text;
    int quoted;
    while (r->next < r->length && lensimport__blank(t[r->next])) r->next++;
    r->word = t + r->next;
    quoted = r->next < r->length && t[r->next] == '"';
    if (quoted) r->next++;
    while (r->next < r->length && (quoted ? t[r->next] != '"' : !lensimport__blank(t[r->next]))) r->next++;
    if (quoted && r->next < r->length) r->next++;
    r->word_size = (size_t)(t + r->next - r->word);
    return r->word_size > 0;
}

static void lensimport__trim(lensimport__reader *r)
{
    while (r->word_size > 0 && lensimport__blank(r->word[0])) { r->word++; r->word_size--; }
    while (r->word_size > 0 && lensimport__blank(r->word[r->word_size - 1])) r->word_size--;
}

/* Nothing but blanks is left of the line. */
static int lensimport__empty(const lensimport__reader *r)
{
    size_t at = r->next;
    while (at < r->length && lensimport__blank(r->text[at])) at++;
    return at >= r->length;
}

/* The next cell of the line, between tabs, without the blanks about it; empty ones count. 0 at the end of the line. */
static int lensimport__cell(lensimport__reader *r)
{
    r->word = r->text + r->length;
    r->word_size = 0;
    if (r->next > r->length) return 0;
    r->word = r->text + r->next;
    while (r->next < r->length && r->text[r->next] != '\t') r->next++;
    r->word_size = (size_t)(r->text + r->next - r->word);
    r->next++;
    lensimport__trim(r);
    return 1;
}

/* What is left of the line, trimmed. */
static void lensimport__rest(lensimport__reader *r)
{
    r->word = r->text + (r->next < r->length ? r->next : r->length);
    r->word_size = (size_t)(r->text + r->length - r->word);
    r->next = r->length;
    lensimport__trim(r);
}

static int lensimport__same(const char *a, size_t size, const char *b)
{
    size_t i;
    for (i = 0; i < size && b[i] != 0; i++)
        if (lensimport__upper(a[i]) != lensimport__upper(b[i])) return 0;
    return i == size && b[i] == 0;
}

/* The word last read is `word`, but for capitals. */
static int lensimport__is(const lensimport__reader *r, const char *word) { return lensimport__same(r->word, r->word_size, word); }

/* Begins with it, but for capitals. */
static int lensimport__begins(const char *text, size_t size, const char *with)
{
    size_t n = strlen(with);
    return size >= n && lensimport__same(text, n, with);
}

/* A number, infinite ones too; not-a-number is none. */
static int lensimport__read_number(const char *text, size_t size, double *out)
{
    static const char *const infinite[] = {"INF", "INFINITY", "1.#INF"};
    size_t sign = size > 0 && (text[0] == '-' || text[0] == '+'), i;
    for (i = 0; i < 3; i++)
        if (lensimport__same(text + sign, size - sign, infinite[i])) {
            *out = text[0] == '-' ? -HUGE_VAL : HUGE_VAL;
            return 1;
        }
    return lflare_number_read(text, size, out);
}

static int lensimport__number(const lensimport__reader *r, double *out) { return lensimport__read_number(r->word, r->word_size, out); }

/* The next word, which must be a number. */
static int lensimport__next_number(lensimport__reader *r, double *out)
{
    if (!lensimport__word(r)) return lensimport__bad(r, r->partly ? "the line is too long" : "a number is missing here");
    return lensimport__number(r, out) || lensimport__bad(r, "a number was expected, not '%s'");
}

/* The word last read as a text of the prescription; a longer one is cut, between characters. */
static void lensimport__copy_text(const lensimport__reader *r, char *out, size_t room)
{
    size_t n = r->word_size < room - 1 ? r->word_size : room - 1;
    while (n > 0 && n < r->word_size && ((uint8_t)r->word[n] & 0xc0) == 0x80) n--;
    while (n > 0 && lensimport__blank(r->word[n - 1])) n--;
    memcpy(out, r->word, n);
    out[n] = 0;
    while (n-- > 0)
        if (out[n] == '\t') out[n] = ' ';
}

/* >> 5 lens */
/* Rows as the file has them to the prescription. */

/* A new row; NULL if there are too many, one being kept for a stop of its own and two for faces at object and image. */
static lflare_surface *lensimport__row(lensimport__reader *r)
{
    lflare_surface *s;
    if (r->p->surface_count >= LFLARE_MAX_SURFACES - 3) {
        lensimport__fail_at(r, LFLARE_ERROR_LENS, r->line, 1, "more than %i surfaces", (int32_t)(LFLARE_MAX_SURFACES - 3));
        return NULL;
    }
    s = &r->p->surfaces[r->p->surface_count++];
    memset(s, 0, sizeof *s);
    s->line = r->line;
    return s;
}

/* Takes row i away. */
static void lensimport__remove(lflare_prescription *p, int32_t i)
{
    p->surface_count--;
    memmove(&p->surfaces[i], &p->surfaces[i + 1], (size_t)(p->surface_count - i) * sizeof p->surfaces[0]);
}

/* An empty row before row i; lensimport__row keeps room. */
static lflare_surface *lensimport__insert(lflare_prescription *p, int32_t i, int32_t line)
{
    memmove(&p->surfaces[i + 1], &p->surfaces[i], (size_t)(p->surface_count - i) * sizeof p->surfaces[0]);
    p->surface_count++;
    memset(&p->surfaces[i], 0, sizeof p->surfaces[i]);
    p->surfaces[i].line = line;
    return &p->surfaces[i];
}

static void lensimport__set_radius(lflare_surface *s, double radius) { s->radius = lensimport__finite(radius) && fabs(radius) < 1e9 ? radius : 0; }

/* A file's curvature is the inverse of a radius of few digits, more often than not. */
static void lensimport__set_curvature(lflare_surface *s, double c)
{
    double radius = fabs(c) > 1e-9 ? 1 / c : 0, unit, few;
    s->radius = lensimport__finite(radius) ? radius : 0;
    if (s->radius == 0) return;
    unit = pow(10.0, 11 - floor(log10(fabs(radius))));
    few = floor(radius * unit + 0.5) / unit;
    if (fabs(few - radius) < 1e-14 * fabs(radius)) s->radius = few;
}


/* A medium from nd and Vd; without a usable Vd the index is constant. */
static int lensimport__set_numbers(lensimport__reader *r, lflare_medium *m, double nd, double vd, int32_t line)
{
    memset(m->c, 0, sizeof m->c);
    m->c[0] = nd;
    if (!(nd >= 0.9 && nd <= 5)) return lensimport__fail_at(r, LFLARE_ERROR_LENS, line, 1, "an index of refraction of %g", nd);
    if (fabs(nd - 1) < 0.001) {
        m->kind = LFLARE_MEDIUM_AIR;
        m->c[0] = 0;
    } else if (vd >= 5 && vd <= 200) {
        m->kind = LFLARE_MEDIUM_ABBE;
        m->c[1] = vd;
    } else {
        m->kind = LFLARE_MEDIUM_CONSTANT;
        lensimport__note(r, LENSIMPORT_NOTE_DISPERSION_MISSING, line, nd, 0, NULL);
    }
    return 1;
}

/* A medium by its name; 0, and nothing said, if nobody knows it. */
static int lensimport__set_glass(lensimport__reader *r, lflare_medium *m, const char *name, size_t size, int32_t line)
{
    char label[24];
    lensimport_glass g;
    const char *prefer = r->desc->catalogues != NULL ? r->desc->catalogues : r->facts.catalogues;
    memset(m, 0, sizeof *m);
    if (size == 0 || lensimport__same(name, size, "AIR") || lensimport__same(name, size, "VACUUM")) return 1;
    lensimport__clean(name, size, 1, m->glass, sizeof m->glass);
    if (r->lookups++ == 4 * LFLARE_MAX_SURFACES) return lensimport__fail_at(r, LFLARE_ERROR_LENS, line, 1, "more than %i names of glasses", (int32_t)(4 * LFLARE_MAX_SURFACES));
    if (lensimport_glass_find(name, size, prefer, &g) == LENSIMPORT_MATCH_NONE) return 0;
    lensimport__clean(name, size, 0, label, sizeof label);
    if (g.match == LENSIMPORT_MATCH_CODE) { /* the code's own digits: 517642 need not be N-BK7 */
        double nd, vd, half[2];
        lensimport__code(name, size, &nd, &vd, half);
        lensimport__numbers(&g, nd, vd);
    }
    if (g.match == LENSIMPORT_MATCH_SUCCESSOR) lensimport__note(r, LENSIMPORT_NOTE_GLASS_REPLACED, line, g.nd, g.vd, label);
    if (g.medium.kind == LFLARE_MEDIUM_CONSTANT) lensimport__note(r, LENSIMPORT_NOTE_DISPERSION_MISSING, line, g.nd, 0, label);
    else if (g.match == LENSIMPORT_MATCH_NUMBERS) lensimport__note(r, LENSIMPORT_NOTE_GLASS_BY_NUMBERS, line, g.nd, g.vd, label);
    m->kind = g.medium.kind;
    memcpy(m->c, g.medium.c, sizeof m->c);
    if (g.match == LENSIMPORT_MATCH_NAME || g.match == LENSIMPORT_MATCH_SUCCESSOR) memcpy(m->glass, g.name, sizeof m->glass);
    return 1;
}

static int lensimport__unknown_glass(lensimport__reader *r, const char *glass, int32_t line)
{
    return lensimport__fail_at(r, LFLARE_ERROR_LENS, line, 1, "the glass '%s' is in no catalogue known here, and the file has no index for it", glass);
}

/* From indices at some wavelengths: nd, nF and nC between the nearest, linear in 1 / wavelength^2. */
static double lensimport__index_between(const double *nm, const double *n, int32_t count, double at)
{
    int32_t i, below = -1, above = -1;
    for (i = 0; i < count; i++) {
        if (nm[i] <= at && (below < 0 || nm[i] > nm[below])) below = i;
        if (nm[i] >= at && (above < 0 || nm[i] < nm[above])) above = i;
    }
    if (below < 0 || above < 0 || nm[above] == nm[below]) { /* beyond an end: the line through the next two */
        int32_t end = below < 0 ? above : below, other = -1;
        if (nm[end] == at) return n[end];
        for (i = 0; i < count; i++)
            if (nm[i] != nm[end] && (other < 0 || fabs(nm[i] - nm[end]) < fabs(nm[other] - nm[end]))) other = i;
        if (other < 0) return n[end];
        below = end;
        above = other;
    }
    {
        double x0 = 1 / (nm[below] * nm[below]), x1 = 1 / (nm[above] * nm[above]);
        return n[below] + (n[above] - n[below]) * (1 / (at * at) - x0) / (x1 - x0);
    }
}

static int lensimport__set_samples(lensimport__reader *r, lflare_medium *m, const double *nm, const double *n, int32_t count, int32_t line)
{
    double nd = lensimport__index_between(nm, n, count, LENSIMPORT__NM_D);
    double spread = lensimport__index_between(nm, n, count, LENSIMPORT__NM_F) - lensimport__index_between(nm, n, count, LENSIMPORT__NM_C);
    return lensimport__set_numbers(r, m, nd, spread > 0 ? (nd - 1) / spread : 0, line);
}

static int lensimport__same_medium(const lflare_medium *a, const lflare_medium *b)
{
    int32_t i;
    for (i = 0; i < 6; i++)
        if (a->c[i] != b->c[i]) return 0;
    return a->kind == b->kind;
}

static double lensimport__curvature(const lflare_surface *s) { return (s->radius != 0 ? 1 / s->radius : 0) + 2 * s->aspheric[0]; }

/* To millimetres; what is not finite goes. */
static int lensimport__scale(lensimport__reader *r)
{
    double k = r->facts.scale != 0 ? r->facts.scale : 1;
    int32_t i, j;
    if (k != 1) lensimport__note(r, LENSIMPORT_NOTE_UNITS, 0, k, 0, NULL);
    for (i = 0; i < r->p->surface_count; i++) {
        lflare_surface *s = &r->p->surfaces[i];
        double power = k;
        s->radius *= k;
        if (fabs(s->radius) >= 1e9) s->radius = 0;
        s->thickness *= k;
        s->semi_diameter *= k;
        for (j = 0; j < 8; j++, power *= k * k) s->aspheric[j] /= power;
        for (j = 0; j < 8; j++)
            if (!lensimport__finite(s->aspheric[j])) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, s->line, 1, "an aspheric term is infinite");
        if (!lensimport__finite(s->conic)) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, s->line, 1, "a conic constant is infinite");
        if (s->semi_diameter < 0) s->semi_diameter = -s->semi_diameter;
        if (s->semi_diameter > 1e4 || !lensimport__finite(s->semi_diameter)) {
            lensimport__note(r, LENSIMPORT_NOTE_SEMI_IGNORED, s->line, s->semi_diameter, 0, NULL);
            s->semi_diameter = 0;
        }
        if (s->semi_diameter < 1e-4) s->semi_diameter = 0;
    }
    r->report->stated_efl *= k;
    if (!lensimport__finite(r->report->stated_efl)) r->report->stated_efl = 0;
    r->facts.epd *= k;
    r->facts.image_radius *= k;
    r->facts.object_distance *= k;
    return 1;
}

/* Faces where object or image lie in glass. */
static void lensimport__close(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    double far = r->facts.object_distance;
    int32_t i = p->surface_count - 1;
    if (fabs(far) < 1e6) lensimport__note(r, LENSIMPORT_NOTE_OBJECT_FINITE, 0, far, 0, NULL);
    if (r->facts.object.kind != LFLARE_MEDIUM_AIR) {
        lflare_surface *s = lensimport__insert(p, 0, p->surfaces[0].line);
        s->medium = r->facts.object;
        s->thickness = fabs(far) < 1e6 ? fabs(far) : 0;
        lensimport__note(r, LENSIMPORT_NOTE_OBJECT_IN_GLASS, s->line, 0, 0, NULL);
        i++;
    }
    if (p->surfaces[i].medium.kind != LFLARE_MEDIUM_AIR) {
        lensimport__note(r, LENSIMPORT_NOTE_ENDS_IN_GLASS, p->surfaces[i].line, 0, 0, NULL);
        if (!(p->surfaces[p->surface_count - 1].thickness >= 0)) p->surfaces[p->surface_count - 1].thickness = 0;
        lensimport__insert(p, p->surface_count, p->surfaces[i].line);
    }
}

/* The stop as a row of its own. A curved surface bends away from the flat stop: in front of it if it bulges towards the light. */
static int lensimport__split_stop(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    lflare_medium before;
    int32_t i, stop = -1;
    memset(&before, 0, sizeof before);
    for (i = 0; i < p->surface_count; i++) {
        lflare_surface *s = &p->surfaces[i], *row;
        if (!s->is_stop) { before = s->medium; continue; }
        if (stop >= 0) return lensimport__fail_at(r, LFLARE_ERROR_LENS, s->line, 1, "a second stop (the first is on line %i)", p->surfaces[stop].line);
        stop = i;
        if (!lensimport__same_medium(&before, &s->medium)) {
            int front = lensimport__curvature(s) >= 0;
            lensimport__note(r, LENSIMPORT_NOTE_STOP_SPLIT, s->line, 0, 0, NULL);
            before = s->medium;
            row = lensimport__insert(p, front ? i : i + 1, s->line);
            s = &p->surfaces[front ? i + 1 : i];
            row->semi_diameter = s->semi_diameter;
            s->is_stop = 0;
            if (!front) {
                row->thickness = s->thickness;
                s->thickness = 0;
                stop = i + 1;
            }
            i++;
        } else {
            row = s;
        }
        row->is_stop = 1;
        row->radius = row->conic = 0;
        memset(row->aspheric, 0, sizeof row->aspheric);
        memset(&row->medium, 0, sizeof row->medium);
    }
    return 1;
}

/* The films of rows that were left out go, too; a row has one at most. */
static void lensimport__pack_films(lflare_prescription *p)
{
    int32_t i, n = 0;
    for (i = 0; i < p->surface_count; i++) {
        lflare_surface *s = &p->surfaces[i];
        if (s->coating != LFLARE_COATING_STACK) continue;
        p->layers[n] = p->layers[s->first_layer];
        s->first_layer = n++;
    }
    p->layer_count = n;
}

/* Leaves out what does nothing; gaps add up. Surfaces beyond the last glass add to the last gap. */
static int lensimport__merge(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    lflare_medium before;
    int32_t i, n = 0, left_out = 0, glasses = 0;
    memset(&before, 0, sizeof before);
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        if (!s->is_stop && lensimport__same_medium(&before, &s->medium)) {
            if (n > 0) p->surfaces[n - 1].thickness += s->thickness;
            left_out++;
            continue;
        }
        if (!s->is_stop) {
            before = s->medium;
            glasses++;
        }
        if (n != i) p->surfaces[n] = p->surfaces[i];
        n++;
    }
    p->surface_count = n;
    lensimport__pack_films(p);
    if (left_out > 0) lensimport__note(r, LENSIMPORT_NOTE_ROWS_LEFT_OUT, 0, left_out, 0, NULL);
    if (glasses == 0) return lensimport__fail_at(r, LFLARE_ERROR_LENS, r->line, 1, "there is no surface that refracts");
    return 1;
}

/* A negative gap beside the stop: the stop stands beyond its neighbour's vertex, and goes there. Others lead backwards. */
static int lensimport__gaps(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    int32_t i;
    for (i = 0; i + 1 < p->surface_count; i++) {
        lflare_surface *s = &p->surfaces[i], *t = &p->surfaces[i + 1];
        double together = s->thickness + t->thickness, moved = 0;
        int last = i + 2 == p->surface_count;
        if (t->is_stop && s->thickness < 0 && (together >= 0 || last)) { /* stop before its neighbour in front */
            moved = -s->thickness;
            s->thickness = 0;
            t->thickness = together;
        } else if (t->is_stop && t->thickness < 0 && together >= 0 && !last) { /* behind that behind */
            moved = -t->thickness;
            s->thickness = together;
            t->thickness = 0;
        } else if (i == 0 && s->is_stop && s->thickness < 0) {
            moved = -s->thickness;
            s->thickness = 0;
        } else if (s->thickness < 0 && s->thickness > -1e-6) {
            s->thickness = 0;
        }
        if (!(fabs(s->thickness) <= 1e6)) return lensimport__fail_at(r, LFLARE_ERROR_LENS, s->line, 1, "a gap of %g mm within the lens", s->thickness);
        if (moved > 0) lensimport__note(r, LENSIMPORT_NOTE_STOP_MOVED, s->is_stop ? s->line : t->line, moved, 0, NULL);
        if (s->thickness < 0) lensimport__refuse(r, LENSIMPORT_REFUSED_BACKWARDS, s->line, "", 0);
    }
    return 1;
}

/* Where a stop is missing: in the middle of the inner air gap with the narrowest surfaces, or the widest gap where semi-diameters
   are unknown; in front of a lens without one. */
static void lensimport__guess_stop(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    int32_t i, best = -1;
    double narrow = HUGE_VAL;
    lflare_surface *s;
    for (i = 0; i < p->surface_count; i++)
        if (p->surfaces[i].is_stop) return;
    for (i = 0; i + 1 < p->surface_count; i++) {
        double a = p->surfaces[i].semi_diameter, b = p->surfaces[i + 1].semi_diameter;
        double size = a > 0 && b > 0 ? (a < b ? a : b) : 1e6 - p->surfaces[i].thickness;
        if (p->surfaces[i].medium.kind != LFLARE_MEDIUM_AIR || p->surfaces[i].thickness <= 0 || size >= narrow) continue;
        narrow = size;
        best = i;
    }
    s = lensimport__insert(p, best + 1, p->surfaces[best < 0 ? 0 : best].line);
    s->is_stop = 1;
    if (best >= 0) s->thickness = p->surfaces[best].thickness *= 0.5;
    lensimport__note(r, LENSIMPORT_NOTE_STOP_GUESSED, s->line, s->thickness, 0, NULL);
}

/* EFL and BFD at the d line; *before_stop: height at the stop per height at the entrance. */
static int lensimport__optics(const lflare_prescription *p, double *efl, double *bfd, double *at_stop)
{
    double h = 1, u = 0, n = 1;
    int32_t i;
    *at_stop = 0;
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        if (s->is_stop) {
            *at_stop = fabs(h);
        } else {
            double next = lflare_index(&s->medium, LENSIMPORT__NM_D);
            u = (n * u - h * (next - n) * lensimport__curvature(s)) / next;
            n = next;
        }
        if (i + 1 < p->surface_count) h += s->thickness * u;
    }
    *efl = *bfd = 0;
    if (!(fabs(u) > 1e-9) || !lensimport__finite(h / u)) return 0;
    *efl = -1 / u;
    *bfd = -h / u;
    return 1;
}

/* FlareSim's files have diameters in a column of semi-diameters: the stop tells, where the f-number is known. */
static void lensimport__halve(lensimport__reader *r, double at_stop)
{
    lflare_prescription *p = r->p;
    double ratio = 0;
    int32_t i;
    for (i = 0; i < p->surface_count; i++)
        if (p->surfaces[i].is_stop && p->fnumber > 0) ratio = p->surfaces[i].semi_diameter / (at_stop * fabs(r->report->efl) / (2 * p->fnumber));
    if (!lensimport__finite(ratio)) ratio = 0;
    if (ratio > 0 && ratio <= 1.5) return;
    for (i = 0; i < p->surface_count; i++) p->surfaces[i].semi_diameter /= 2;
    lensimport__note(r, LENSIMPORT_NOTE_SEMI_HALVED, 0, ratio, 0, NULL);
}

/* Semi-diameters beyond their own sphere and far above the others' are placeholders or of another unit. */
static void lensimport__drop_semis(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    int32_t i, j;
    double median = 0;
    for (i = 0; i < p->surface_count; i++) { /* the largest that half of them reach */
        int32_t reach = 0, known = 0;
        for (j = 0; j < p->surface_count; j++) {
            known += p->surfaces[j].semi_diameter > 0;
            reach += p->surfaces[j].semi_diameter > 0 && p->surfaces[j].semi_diameter >= p->surfaces[i].semi_diameter;
        }
        if (2 * reach >= known && p->surfaces[i].semi_diameter > median) median = p->surfaces[i].semi_diameter;
    }
    for (i = 0; i < p->surface_count; i++) {
        lflare_surface *s = &p->surfaces[i];
        if (median == 0 || s->semi_diameter <= 3 * median) continue;
        if (s->radius != 0 ? s->semi_diameter < fabs(s->radius) : s->semi_diameter < 5 * median) continue;
        lensimport__note(r, LENSIMPORT_NOTE_SEMI_IGNORED, s->line, s->semi_diameter, 0, NULL);
        s->semi_diameter = 0;
    }
}

/* The sensor from the image circle: 36 x 24 mm within 43.3, other circles in the same shape. */
static void lensimport__sensor(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    double radius = r->facts.image_radius, efl = r->report->efl, degrees = r->facts.field_degrees;
    if (p->sensor_width >= 0.01 && p->sensor_width <= 1e4 && p->sensor_height >= 0.01 && p->sensor_height <= 1e4) return;
    p->sensor_width = p->sensor_height = 0;
    if (!(radius > 0) && degrees > 0 && degrees < 80) radius = fabs(efl) * tan(degrees * 0.017453292519943295);
    if (!(radius >= 0.01 && radius <= 5000)) return;
    if (fabs(radius - 21.633) < 0.3) radius = 21.63330765;
    p->sensor_width = floor(radius * 6 / 3.6055512755 * 1000 + 0.5) / 1000;
    p->sensor_height = floor(radius * 4 / 3.6055512755 * 1000 + 0.5) / 1000;
    lensimport__note(r, LENSIMPORT_NOTE_SENSOR_DERIVED, 0, p->sensor_width, p->sensor_height, NULL);
}

/* The opening: from the f-number or the entrance pupil; where the stop's size counts, from that. */
static void lensimport__opening(lensimport__reader *r, double at_stop)
{
    lflare_prescription *p = r->p;
    double efl = fabs(r->report->efl), stop = 0, widest = 0;
    int32_t i;
    if (r->facts.epd > 0 && p->fnumber == 0) p->fnumber = efl / r->facts.epd;
    for (i = 0; i < p->surface_count; i++) {
        if (p->surfaces[i].is_stop) stop = p->surfaces[i].semi_diameter;
        if (p->surfaces[i].semi_diameter > widest) widest = p->surfaces[i].semi_diameter;
    }
    if (r->facts.stop_counts && stop > 0 && p->fnumber > 1.25 * at_stop * efl / (2 * stop)) {
        lensimport__note(r, LENSIMPORT_NOTE_FNUMBER_IGNORED, 0, at_stop * efl / (2 * stop), p->fnumber, NULL);
        p->fnumber = 0;
    }
    if (!(p->fnumber >= 0.1 && p->fnumber <= 1000)) p->fnumber = 0;
    for (i = 0; i < p->surface_count; i++) { /* made for a near object, the stop may lie close to a focus of ours */
        double f = stop > 0 ? at_stop * efl / (2 * stop) : 1;
        if (!p->surfaces[i].is_stop || (f >= 0.1 && f <= 1000)) continue;
        lensimport__note(r, LENSIMPORT_NOTE_SEMI_IGNORED, p->surfaces[i].line, stop, 0, NULL);
        p->surfaces[i].semi_diameter = 0;
    }
    if (p->fnumber == 0 && widest == 0) {
        p->fnumber = 4;
        lensimport__note(r, LENSIMPORT_NOTE_FNUMBER_GUESSED, 0, 4, 0, NULL);
    }
}

static int lensimport__refused(lensimport__reader *r)
{
    static const char *const reasons[] = {
        "", "a mirror", "tilted or decentred", "a grating or another diffractive surface", "curved differently in two directions",
        "an index that varies within the glass", "an ideal lens without glass", "not sequential", "a surface of a type not known to be rotationally symmetric and refracting",
        "a negative gap: light would go backwards, as behind a mirror"};
    lensimport_refusal refusal = r->facts.refusal;
    if (refusal == LENSIMPORT_REFUSED_NOT) return 0;
    r->report->refusal = refusal;
    lensimport__fail_at(r, LFLARE_ERROR_LENS, r->facts.refusal_line, 1, r->facts.refused[0] != 0 ? "refused: %s (%s)" : "refused: %s", reasons[refusal], r->facts.refused);
    return 1;
}

/* Everything that follows reading: rows in the file's unit, the last one's gap leading to the image. */
static int lensimport__finish(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    lensimport_report *report = r->report;
    lflare_surface *last;
    double at_stop, stated;
    int32_t i;
    if (r->failed != LFLARE_OK || lensimport__refused(r)) return 0;
    if (p->surface_count == 0) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, 1, "there are no surfaces");
    for (i = 0; i < p->surface_count; i++)
        if (p->surfaces[i].medium.kind == LFLARE_MEDIUM_AIR && p->surfaces[i].medium.glass[0] != 0)
            return lensimport__unknown_glass(r, p->surfaces[i].medium.glass, p->surfaces[i].line);
    if (!lensimport__scale(r)) return 0;
    lensimport__close(r);
    if (!lensimport__split_stop(r) || !lensimport__merge(r)) return 0;
    if (!lensimport__gaps(r) || lensimport__refused(r)) return 0;
    lensimport__guess_stop(r);
    last = &p->surfaces[p->surface_count - 1];
    stated = r->facts.gap_unknown || !(last->thickness >= 0 && last->thickness <= 1e6) ? -1 : last->thickness;
    if (stated < 0) {
        if (!r->desc->focus) lensimport__note(r, LENSIMPORT_NOTE_GAP_UNKNOWN, 0, 0, 0, NULL);
    } else {
        report->stated_bfd = stated;
    }
    p->focus = stated < 0 || r->desc->focus;
    if (p->focus) last->thickness = 0;
    if (lensimport__optics(p, &report->efl, &report->bfd, &at_stop)) {
        if (report->stated_efl != 0 && fabs(report->efl - report->stated_efl) > 0.005 * fabs(report->stated_efl))
            lensimport__note(r, LENSIMPORT_NOTE_EFL_DIFFERS, 0, report->efl, report->stated_efl, NULL);
    }
    if (r->facts.diameters) lensimport__halve(r, at_stop);
    lensimport__drop_semis(r);
    lensimport__opening(r, at_stop);
    lensimport__sensor(r);
    return 1;
}

/* >> 6 zemax */

/* What a type of surface is, for .zmx and the report alike. `terms`: what its parameters mean. */
typedef enum lensimport__terms { LENSIMPORT__SPHERE, LENSIMPORT__EVEN, LENSIMPORT__ODD, LENSIMPORT__EXTENDED, LENSIMPORT__BREAK } lensimport__terms;

static lensimport__terms lensimport__surface_type(lensimport__reader *r, const char *type, size_t size, int32_t line)
{
    static const struct {
        char begins[12];
        lensimport_refusal refusal;
    } types[] = {
        {"TILTSURF", LENSIMPORT_REFUSED_TILT},    {"TILTED", LENSIMPORT_REFUSED_TILT},
        {"DGRATING", LENSIMPORT_REFUSED_GRATING}, {"DIFFRACT", LENSIMPORT_REFUSED_GRATING},  {"TOROGRAT", LENSIMPORT_REFUSED_GRATING},
        {"ELLIGRAT", LENSIMPORT_REFUSED_GRATING}, {"VARLINES", LENSIMPORT_REFUSED_GRATING},  {"BINARY", LENSIMPORT_REFUSED_GRATING},
        {"HOLOGRM", LENSIMPORT_REFUSED_GRATING},  {"HOLOGRAM", LENSIMPORT_REFUSED_GRATING},  {"ZONE", LENSIMPORT_REFUSED_GRATING},
        {"TOROID", LENSIMPORT_REFUSED_TOROID},    {"BICONIC", LENSIMPORT_REFUSED_TOROID},    {"CYLIND", LENSIMPORT_REFUSED_TOROID},
        {"GRIN", LENSIMPORT_REFUSED_GRADIENT},    {"GRADIUM", LENSIMPORT_REFUSED_GRADIENT},  {"PARAXIAL", LENSIMPORT_REFUSED_IDEAL},
        {"NONSEQCO", LENSIMPORT_REFUSED_SEQUENCE}, {"NON-SEQ", LENSIMPORT_REFUSED_SEQUENCE}};
    size_t i;
    if (size == 0 || lensimport__same(type, size, "STANDARD")) return LENSIMPORT__SPHERE;
    if (lensimport__same(type, size, "EVENASPH") || lensimport__same(type, size, "EVEN ASPHERE")) return LENSIMPORT__EVEN;
    if (lensimport__same(type, size, "ODDASPHE") || lensimport__same(type, size, "ODD ASPHERE")) return LENSIMPORT__ODD;
    if (lensimport__same(type, size, "XASPHERE") || lensimport__same(type, size, "EXTENDED ASPHERE")) return LENSIMPORT__EXTENDED;
    if (lensimport__same(type, size, "COORDBRK")) return LENSIMPORT__BREAK;
    for (i = 0; i < sizeof types / sizeof types[0]; i++)
        if (lensimport__begins(type, size, types[i].begins)) {
            lensimport__refuse(r, types[i].refusal, line, type, size);
            return LENSIMPORT__SPHERE;
        }
    lensimport__refuse(r, LENSIMPORT_REFUSED_SURFACE, line, type, size);
    return LENSIMPORT__SPHERE;
}

/* A term of a sag, c r^power. */
static void lensimport__term(lensimport__reader *r, lflare_surface *s, int32_t power, double c, int32_t line)
{
    if (c == 0) return;
    if (power % 2 == 0 && power >= 2 && power <= 16) s->aspheric[power / 2 - 1] = c;
    else if (power == 1) lensimport__refuse(r, LENSIMPORT_REFUSED_SURFACE, line, "a cone: r^1", 11);
    else lensimport__note(r, LENSIMPORT_NOTE_ASPHERE_CUT, line, power, c, NULL);
}

typedef struct lensimport__zmx {
    lflare_surface *s;       /* the surface being read, NULL outside */
    lensimport__terms terms;
    double norm;             /* of an extended asphere */
    int32_t flat;            /* lines of surfaces are not indented in this file */
    int32_t first;           /* the next line is the first after a SURF */
    int32_t current, config; /* zoom state that the surfaces hold; that is wanted */
    int32_t fields, field_type;
    double field[2][12];
    int32_t solved;          /* surface whose gap is solved for the image, -1 none */
    int32_t pick_count;      /* gaps that are others times `scale` plus `offset` */
    struct {
        int32_t surface, from;
        double scale, offset;
    } pick[LFLARE_MAX_SURFACES];
} lensimport__zmx;

/* FNUM 2.8 0 and the like; fields of no interest are left unread. */
static int lensimport__zmx_header(lensimport__reader *r, lensimport__zmx *z)
{
    double v = 0;
    int32_t i;
    if (lensimport__is(r, "MODE")) {
        if (lensimport__word(r) && !lensimport__is(r, "SEQ")) lensimport__refuse(r, LENSIMPORT_REFUSED_SEQUENCE, r->line, r->word, r->word_size);
        return 1;
    }
    if (lensimport__is(r, "NAME")) {
        lensimport__rest(r);
        lensimport__copy_text(r, r->p->name, sizeof r->p->name);
        return 1;
    }
    if (lensimport__is(r, "UNIT")) {
        if (!lensimport__word(r)) return 1;
        r->facts.scale = lensimport__is(r, "CM") ? 10 : lensimport__is(r, "IN") || lensimport__is(r, "INCH") ? 25.4 : lensimport__is(r, "M") || lensimport__is(r, "METER") ? 1000 : 1;
        if (r->facts.scale == 1 && !lensimport__is(r, "MM")) return lensimport__bad(r, "a unit was expected, MM, CM, IN or M, not '%s'");
        return 1;
    }
    if (lensimport__is(r, "FNUM")) return lensimport__next_number(r, &r->p->fnumber);
    if (lensimport__is(r, "ENPD")) return lensimport__next_number(r, &r->facts.epd);
    if (lensimport__is(r, "GCAT")) {
        lensimport__rest(r);
        lensimport__clean(r->word, r->word_size, 0, r->catalogues, sizeof r->catalogues);
        r->facts.catalogues = r->catalogues;
        return 1;
    }
    if (lensimport__is(r, "FTYP")) {
        for (i = 0; i < 3 && lensimport__word(r) && lensimport__number(r, &v); i++) {
            if (i == 0) z->field_type = (int32_t)(v >= 0 && v < 10 ? v : 9);
            if (i == 2) z->fields = (int32_t)(v >= 1 && v <= 12 ? v : 12);
        }
        return 1;
    }
    if (lensimport__is(r, "XFLN") || lensimport__is(r, "YFLN")) {
        double *field = z->field[lensimport__is(r, "YFLN")];
        for (i = 0; i < 12 && lensimport__word(r) && lensimport__number(r, &v); i++) field[i] = v;
    }
    return 1;
}

static int lensimport__zmx_glass(lensimport__reader *r, lensimport__zmx *z)
{
    lflare_medium *m = &z->s->medium;
    const char *name;
    size_t size;
    double flag = 0, pickup = 0, nd = 0, vd = 0;
    if (!lensimport__word(r)) return 1;
    name = r->word;
    size = r->word_size;
    if (lensimport__is(r, "MIRROR")) {
        lensimport__refuse(r, LENSIMPORT_REFUSED_MIRROR, r->line, name, size);
        return 1;
    }
    if (lensimport__word(r)) lensimport__number(r, &flag);
    if (lensimport__word(r)) lensimport__number(r, &pickup);
    if (lensimport__word(r)) lensimport__number(r, &nd);
    if (lensimport__word(r)) lensimport__number(r, &vd);
    if (lensimport__same(name, size, "___BLANK") || !lensimport__set_glass(r, m, name, size, r->line)) {
        int picked = flag == 2 && pickup >= 0 && pickup < r->p->surface_count - 1;
        if (picked && r->p->surfaces[(int32_t)pickup].medium.kind != LFLARE_MEDIUM_AIR) { /* the default 1.5, 40 may stand behind it */
            *m = r->p->surfaces[(int32_t)pickup].medium;
            return 1;
        }
        if (flag != 1 && flag != 2 && !lensimport__same(name, size, "___BLANK")) { /* said in the end, if nothing worse is found */
            z->s->line = r->line;
            return 1;
        }
        if (!lensimport__set_numbers(r, m, nd, vd, r->line)) return 0; /* written out with flags 1 and 2 alone */
        if (m->kind == LFLARE_MEDIUM_AIR || lensimport__same(name, size, "___BLANK")) memset(m->glass, 0, sizeof m->glass);
    }
    return 1;
}

/* PARM i v, XDAT i v. */
static int lensimport__zmx_parameter(lensimport__reader *r, lensimport__zmx *z, int extra)
{
    double index, v;
    int32_t i;
    if (!lensimport__next_number(r, &index) || !lensimport__next_number(r, &v)) return 0;
    i = index >= 1 && index <= 300 ? (int32_t)index : 0;
    if (extra) {
        if (z->terms != LENSIMPORT__EXTENDED) return 1;
        if (i == 2) z->norm = v != 0 ? v : 1;
        if (i > 2 && v != 0) lensimport__term(r, z->s, 2 * (i - 2), v / pow(z->norm, 2.0 * (i - 2)), r->line);
    } else if (z->terms == LENSIMPORT__EVEN && i > 0) {
        lensimport__term(r, z->s, 2 * i, v, r->line);
    } else if (z->terms == LENSIMPORT__ODD && i > 0) {
        lensimport__term(r, z->s, i, v, r->line);
    } else if (z->terms == LENSIMPORT__BREAK && i >= 1 && i <= 4 && fabs(v) > 1e-12) {
        lensimport__refuse(r, LENSIMPORT_REFUSED_TILT, r->line, "COORDBRK", 8);
    }
    return 1;
}

/* "PZUP surface scale offset": the gap is another's. The rows hold the current zoom state; another one needs the rule. */
static void lensimport__zmx_pickup(lensimport__reader *r, lensimport__zmx *z)
{
    double from, scale = 1, offset = 0;
    if (z->pick_count == LFLARE_MAX_SURFACES || !lensimport__word(r) || !lensimport__number(r, &from) || !(from >= 0 && from < 1000)) return;
    if (lensimport__word(r)) lensimport__number(r, &scale);
    if (lensimport__word(r)) lensimport__number(r, &offset);
    z->pick[z->pick_count].surface = r->p->surface_count - 1;
    z->pick[z->pick_count].from = (int32_t)from;
    z->pick[z->pick_count].scale = scale;
    z->pick[z->pick_count++].offset = offset;
}

/* Before the zoom table: rules that the rows do not follow are not understood, and said. */
static void lensimport__zmx_check_pickups(lensimport__reader *r, lensimport__zmx *z)
{
    int32_t i, n = 0;
    for (i = 0; i < z->pick_count && z->config != z->current; i++) {
        int32_t from = z->pick[i].from;
        double gap = r->p->surfaces[z->pick[i].surface].thickness;
        double rule = from < r->p->surface_count ? z->pick[i].scale * r->p->surfaces[from].thickness + z->pick[i].offset : HUGE_VAL;
        if (fabs(rule - gap) <= 1e-6 * (1 + fabs(gap))) z->pick[n++] = z->pick[i];
        else lensimport__note(r, LENSIMPORT_NOTE_CONFIG_PARTLY, r->line, 0, 0, "PZUP");
    }
    z->pick_count = n;
}

/* A line of a surface; the word is read. */
static int lensimport__zmx_surface(lensimport__reader *r, lensimport__zmx *z)
{
    lflare_surface *s = z->s;
    double v = 0, w = 0;
    if (lensimport__is(r, "STOP")) { s->is_stop = 1; return 1; }
    if (lensimport__is(r, "TYPE")) {
        lensimport__word(r);
        z->terms = lensimport__surface_type(r, r->word, r->word_size, r->line);
        return 1;
    }
    if (lensimport__is(r, "CURV")) {
        if (!lensimport__next_number(r, &v)) return 0;
        lensimport__set_curvature(s, v);
        return 1;
    }
    if (lensimport__is(r, "DISZ")) return lensimport__next_number(r, &s->thickness);
    if (lensimport__is(r, "CONI")) return lensimport__next_number(r, &s->conic);
    if (lensimport__is(r, "GLAS")) return lensimport__zmx_glass(r, z);
    if (lensimport__is(r, "PARM") || lensimport__is(r, "XDAT")) return lensimport__zmx_parameter(r, z, lensimport__is(r, "XDAT"));
    if (lensimport__is(r, "DIAM")) {
        if (!lensimport__next_number(r, &v)) return 0;
        if (s->semi_diameter == 0) s->semi_diameter = v;
        return 1;
    }
    if (lensimport__is(r, "CLAP")) { /* rmin rmax */
        if (!lensimport__next_number(r, &v) || !lensimport__next_number(r, &w)) return 0;
        if (w > 0) s->semi_diameter = w;
        return 1;
    }
    if (lensimport__is(r, "MAZH")) { z->solved = r->p->surface_count - 1; return 1; }
    if (lensimport__is(r, "PZUP")) { lensimport__zmx_pickup(r, z); return 1; }
    if (lensimport__is(r, "SQAP") || lensimport__is(r, "ELAP") || lensimport__is(r, "UDAP")) {
        lensimport__note(r, LENSIMPORT_NOTE_APERTURE_IGNORED, r->line, 0, 0, lensimport__is(r, "SQAP") ? "SQAP" : lensimport__is(r, "ELAP") ? "ELAP" : "UDAP");
    } else if (lensimport__is(r, "OBDC")) {
        if (lensimport__word(r)) lensimport__number(r, &v);
        if (lensimport__word(r)) lensimport__number(r, &w);
        if (v != 0 || w != 0) lensimport__note(r, LENSIMPORT_NOTE_APERTURE_IGNORED, r->line, 0, 0, "OBDC");
    } else if (lensimport__is(r, "SCBD")) { /* the surface's own tilt: three numbers, then decentres and angles */
        int32_t i;
        for (i = 0; lensimport__word(r) && lensimport__number(r, &v); i++)
            if (i >= 3 && fabs(v) > 1e-12) lensimport__refuse(r, LENSIMPORT_REFUSED_TILT, r->line, "SCBD", 4);
    }
    return 1;
}

/* SURF n begins a surface; they are numbered in order. */
static int lensimport__zmx_begin(lensimport__reader *r, lensimport__zmx *z)
{
    double number;
    if (!lensimport__next_number(r, &number)) return 0;
    if (number != r->p->surface_count) return lensimport__bad(r, "surfaces are numbered from 0 in order, not '%s'");
    z->s = lensimport__row(r);
    z->terms = LENSIMPORT__SPHERE;
    z->norm = 1;
    z->first = 1;
    return z->s != NULL;
}

/* Behind GLSS the name stands in quotes; 0 if there is none that is known. */
static int lensimport__zmx_other_glass(lensimport__reader *r, lflare_surface *s)
{
    lflare_medium m;
    while (lensimport__word(r)) {
        if (r->word_size < 3 || r->word[0] != '"') continue;
        if (lensimport__is(r, "\"MIRROR\"")) lensimport__refuse(r, LENSIMPORT_REFUSED_MIRROR, r->line, r->word + 1, r->word_size - 2);
        else if (!lensimport__set_glass(r, &m, r->word + 1, r->word_size - 2, r->line)) return 0;
        else s->medium = m;
        return 1;
    }
    return 0;
}

/* A line of the zoom table: OPERAND surface state value. The surfaces hold the current state. */
static int lensimport__zmx_operand(lensimport__reader *r, lensimport__zmx *z)
{
    static const char harmless[] = " MOFF LTTL XFIE YFIE FLTP FLWT FVDX FVDY FVCX FVCY FVAN WAVE WLWT PRWV TEMP PRES CWGT COTN RATIO SATP ";
    char name[12], padded[16];
    double surface = 0, state = 0, value = 0;
    lflare_surface *s;
    lensimport__clean(r->word, r->word_size, 0, name, sizeof name);
    if (!lensimport__word(r) || !lensimport__number(r, &surface) || !lensimport__word(r) || !lensimport__number(r, &state)) return 1;
    if (state != z->config || z->config == z->current) return 1;
    lensimport__format(padded, sizeof padded, " %s ", name);
    if (strstr(harmless, padded) != NULL) return 1;
    s = surface >= 0 && surface < r->p->surface_count ? &r->p->surfaces[(int32_t)surface] : NULL;
    if (s != NULL && strcmp(name, "GLSS") == 0 && lensimport__zmx_other_glass(r, s)) return 1;
    if (!lensimport__word(r) || !lensimport__number(r, &value)) s = NULL;
    if (strcmp(name, "APER") == 0) {
        if (r->facts.epd != 0) r->facts.epd = value;
        else if (r->p->fnumber != 0) r->p->fnumber = value;
        return 1;
    }
    if (s != NULL && strcmp(name, "THIC") == 0) {
        s->thickness = value;
        if (z->solved == (int32_t)surface) z->solved = -1;
    } else if (s != NULL && strcmp(name, "CRVT") == 0) {
        lensimport__set_curvature(s, value);
    } else if (s != NULL && strcmp(name, "CONN") == 0) {
        s->conic = value;
    } else if (s != NULL && strcmp(name, "SDIA") == 0) {
        s->semi_diameter = value;
    } else {
        lensimport__note(r, LENSIMPORT_NOTE_CONFIG_PARTLY, r->line, 0, 0, name);
    }
    return 1;
}

/* "MNUM n current" */
static int lensimport__zmx_configs(lensimport__reader *r, lensimport__zmx *z)
{
    double count = 1, current = 1;
    if (lensimport__word(r)) lensimport__number(r, &count);
    if (lensimport__word(r)) lensimport__number(r, &current);
    r->report->config_count = (int32_t)(count >= 1 && count <= 1e6 ? count : 1);
    z->current = (int32_t)(current >= 1 && current <= count ? current : 1);
    z->config = r->desc->config > 0 ? r->desc->config : z->current;
    r->report->config = z->config;
    return 1;
}

/* In another zoom state than the rows', the opening is known and the stop's size is not. */
static void lensimport__forget_stop(lensimport__reader *r)
{
    int32_t i;
    if (r->p->fnumber == 0 && r->facts.epd == 0) return;
    for (i = 0; i < r->p->surface_count; i++)
        if (r->p->surfaces[i].is_stop) r->p->surfaces[i].semi_diameter = 0;
}

/* Object and image off; what they tell of object space and the image circle. */
static int lensimport__strip(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    if (p->surface_count < 3) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, 1, "there are no surfaces between object and image");
    r->facts.object_distance = p->surfaces[0].thickness;
    r->facts.object = p->surfaces[0].medium;
    if (p->surfaces[p->surface_count - 1].semi_diameter > 0) r->facts.image_radius = p->surfaces[p->surface_count - 1].semi_diameter;
    p->surface_count--;
    lensimport__remove(p, 0);
    return 1;
}

/* What follows from the zoom table in another state than the rows'. */
static void lensimport__zmx_other_state(lensimport__reader *r, lensimport__zmx *z)
{
    int32_t i;
    for (i = 0; i < z->pick_count; i++) r->p->surfaces[z->pick[i].surface].thickness = z->pick[i].scale * r->p->surfaces[z->pick[i].from].thickness + z->pick[i].offset;
    if (z->solved >= 0 && z->solved == r->p->surface_count - 2) r->facts.gap_unknown = 1;
    else if (z->solved >= 0) lensimport__note(r, LENSIMPORT_NOTE_CONFIG_PARTLY, r->p->surfaces[z->solved].line, 0, 0, "MAZH");
    lensimport__forget_stop(r);
}

static int lensimport__read_zmx(lensimport__reader *r)
{
    lensimport__zmx z;
    int table = 0;
    int32_t i;
    memset(&z, 0, sizeof z);
    z.solved = -1;
    z.fields = 12;
    while (r->failed == LFLARE_OK && lensimport__line(r)) {
        int indented = r->length > 0 && lensimport__blank(r->text[0]);
        if (!lensimport__word(r)) continue;
        if (z.first) z.flat = !indented && !lensimport__is(r, "SURF");
        z.first = 0;
        if (z.s != NULL && !table && (indented || z.flat) && !lensimport__is(r, "SURF") && !lensimport__is(r, "MNUM") && !lensimport__is(r, "TOL")) {
            lensimport__zmx_surface(r, &z);
            continue;
        }
        if (lensimport__is(r, "SURF")) { lensimport__zmx_begin(r, &z); continue; }
        if (r->p->surface_count == 0) { lensimport__zmx_header(r, &z); continue; }
        z.s = NULL; /* merit functions and tolerances, until the zoom table */
        if (lensimport__is(r, "MNUM")) {
            table = 1;
            lensimport__zmx_configs(r, &z);
            lensimport__zmx_check_pickups(r, &z);
        }
        else if (table) lensimport__zmx_operand(r, &z);
    }
    if (r->failed != LFLARE_OK || lensimport__refused(r)) return 0;
    for (i = 0; i < z.fields; i++) {
        double h = hypot(z.field[0][i], z.field[1][i]);
        if (z.field_type == 0 && h > r->facts.field_degrees) r->facts.field_degrees = h;
        if ((z.field_type == 2 || z.field_type == 3) && h > r->facts.image_radius) r->facts.image_radius = h;
    }
    if (z.config != z.current) lensimport__zmx_other_state(r, &z);
    if (r->p->surface_count > 0) { /* images have no gap behind them: this is a lens's last surface */
        double behind = r->p->surfaces[r->p->surface_count - 1].thickness;
        if (behind != 0 && lensimport__finite(behind) && lensimport__row(r) == NULL) return 0;
    }
    return lensimport__strip(r);
}

/* >> 7 zemax report */
/* "System/Prescription Data", with columns between tabs, or in older ones right-aligned under their titles. */

enum { LENSIMPORT__COLUMNS = 16, LENSIMPORT__WAVES = 32 };

typedef enum lensimport__column_kind {
    LENSIMPORT__OTHER, LENSIMPORT__SURF, LENSIMPORT__TYPE, LENSIMPORT__CURVE, LENSIMPORT__THICK, LENSIMPORT__GLASS_CELL, LENSIMPORT__DIAMETER, LENSIMPORT__CONIC_CELL
} lensimport__column_kind;

typedef struct lensimport__table {
    int32_t count, tabs;
    lensimport__column_kind kind[LENSIMPORT__COLUMNS];
    size_t end[LENSIMPORT__COLUMNS];
} lensimport__table;

/* The line of titles. */
static void lensimport__titles(lensimport__reader *r, lensimport__table *t)
{
    static const char *const names[] = {"Surf", "Type", "Radius", "Thickness", "Glass", "Diameter", "Conic"};
    int32_t i;
    memset(t, 0, sizeof *t);
    t->tabs = memchr(r->text, '\t', r->length) != NULL;
    r->next = 0;
    while (t->count < LENSIMPORT__COLUMNS && (t->tabs ? lensimport__cell(r) : lensimport__word(r))) {
        lensimport__column_kind kind = LENSIMPORT__OTHER;
        for (i = 0; i < 7; i++)
            if (lensimport__is(r, names[i])) kind = (lensimport__column_kind)(i + 1);
        if (lensimport__is(r, "Clear Diam") || (!t->tabs && lensimport__is(r, "Clear"))) kind = LENSIMPORT__DIAMETER;
        if (lensimport__is(r, "Material")) kind = LENSIMPORT__GLASS_CELL;
        if (!t->tabs && t->count > 0 && (lensimport__is(r, "Diam") || lensimport__is(r, "Zone"))) { /* "Clear Diam" in two words */
            t->end[t->count - 1] = r->next;
            continue;
        }
        t->kind[t->count] = kind;
        t->end[t->count++] = r->next;
    }
}

/* The next cell of a row; by width where there are no tabs: up to the end of its title, but the type, which begins there. */
static int lensimport__table_cell(lensimport__reader *r, const lensimport__table *t, int32_t column)
{
    size_t end;
    if (t->tabs) return lensimport__cell(r);
    if (t->kind[column] == LENSIMPORT__TYPE || t->kind[column] == LENSIMPORT__SURF) return lensimport__word(r);
    end = column + 1 == t->count || t->end[column] > r->length ? r->length : t->end[column];
    if (r->next > end) end = r->next;
    while (end < r->length && !lensimport__blank(r->text[end]) && end > 0 && !lensimport__blank(r->text[end - 1]) && t->kind[column] != LENSIMPORT__OTHER) end++;
    r->word = r->text + r->next;
    r->word_size = end - r->next;
    r->next = end;
    lensimport__trim(r);
    return 1;
}

/* "N-BK7", or "1.61087, 55.8" */
static int lensimport__report_glass(lensimport__reader *r, lflare_surface *s)
{
    const char *comma = (const char *)memchr(r->word, ',', r->word_size);
    double nd, vd = 0;
    size_t front = comma != NULL ? (size_t)(comma - r->word) : r->word_size;
    if (lensimport__is(r, "MIRROR")) {
        lensimport__refuse(r, LENSIMPORT_REFUSED_MIRROR, r->line, r->word, r->word_size);
        return 1;
    }
    if (front > 0 && front < 12 && lflare_number_read(r->word, front, &nd) && nd < 10) {
        size_t back = front + 1;
        while (back < r->word_size && lensimport__blank(r->word[back])) back++;
        if (back < r->word_size) lflare_number_read(r->word + back, r->word_size - back, &vd);
        return lensimport__set_numbers(r, &s->medium, nd, vd, r->line);
    }
    lensimport__set_glass(r, &s->medium, r->word, r->word_size, r->line); /* an unknown one may be in the table of indices */
    return 1;
}

/* A row of the surface table, from OBJ to IMA. Returns 0 where there is none: at the table's end. */
static int lensimport__report_row(lensimport__reader *r, const lensimport__table *t)
{
    lflare_surface *s = NULL;
    double v;
    int32_t i;
    r->next = 0;
    for (i = 0; i < t->count && r->failed == LFLARE_OK && lensimport__table_cell(r, t, i); i++) {
        int number = lensimport__number(r, &v), none = r->word_size == 0 || lensimport__is(r, "-");
        if (t->kind[i] == LENSIMPORT__SURF) {
            if (!number && !lensimport__is(r, "OBJ") && !lensimport__is(r, "STO") && !lensimport__is(r, "IMA")) return 0;
            if ((s = lensimport__row(r)) == NULL) return 0;
            s->is_stop = lensimport__is(r, "STO");
            continue;
        }
        if (s == NULL) return 0;
        if (t->kind[i] == LENSIMPORT__TYPE) {
            if (lensimport__surface_type(r, r->word, r->word_size, r->line) == LENSIMPORT__BREAK) lensimport__refuse(r, LENSIMPORT_REFUSED_TILT, r->line, r->word, r->word_size);
        } else if (t->kind[i] == LENSIMPORT__GLASS_CELL) {
            if (!none) lensimport__report_glass(r, s);
        } else if (t->kind[i] != LENSIMPORT__OTHER && !none) {
            if (!number) return lensimport__bad(r, "a number was expected, not '%s'");
            if (t->kind[i] == LENSIMPORT__CURVE) lensimport__set_radius(s, v);
            if (t->kind[i] == LENSIMPORT__THICK) s->thickness = v;
            if (t->kind[i] == LENSIMPORT__DIAMETER) s->semi_diameter = v / 2;
            if (t->kind[i] == LENSIMPORT__CONIC_CELL) s->conic = v;
        }
    }
    return s != NULL;
}

/* "Effective Focal Length : 100.02 (in air ...)": the value behind the colon. */
static int lensimport__report_value(lensimport__reader *r, const char *title, double *v)
{
    const char *colon = (const char *)memchr(r->text, ':', r->length);
    size_t at = 0;
    while (at < r->length && lensimport__blank(r->text[at])) at++;
    if (colon == NULL || !lensimport__begins(r->text + at, r->length - at, title)) return 0;
    r->next = (size_t)(colon - r->text) + 1;
    return lensimport__word(r) && (v == NULL || lensimport__number(r, v));
}

static void lensimport__report_general(lensimport__reader *r)
{
    double v = 0;
    if (lensimport__report_value(r, "Effective Focal Length", &v) && r->report->stated_efl == 0) r->report->stated_efl = v;
    else if (lensimport__report_value(r, "Entrance Pupil Diameter", &v)) r->facts.epd = v;
    else if (lensimport__report_value(r, "Image Space F/#", &v) && r->p->fnumber == 0) r->p->fnumber = v;
    else if (lensimport__report_value(r, "Lens Units", NULL)) {
        r->facts.scale = lensimport__begins(r->word, r->word_size, "Centim") ? 10 : lensimport__begins(r->word, r->word_size, "Inch") ? 25.4 : lensimport__begins(r->word, r->word_size, "Meter") ? 1000 : 1;
    } else if (lensimport__report_value(r, "Title", NULL)) {
        r->next = (size_t)(r->word - r->text);
        lensimport__rest(r);
        lensimport__copy_text(r, r->p->name, sizeof r->p->name);
    }
    r->next = 0; /* "Configuration 1 of 3" */
    if (lensimport__word(r) && lensimport__is(r, "Configuration") && lensimport__word(r) && lensimport__number(r, &v) && v >= 1 && v < 1000) {
        double count = 0;
        if (lensimport__word(r) && lensimport__is(r, "of") && lensimport__word(r) && lensimport__number(r, &count) && count >= v && count < 1000) {
            r->report->config = (int32_t)v;
            r->report->config_count = (int32_t)count;
        }
    }
}

/* A line of "SURFACE DATA DETAIL": "Surface 3 EVENASPH", "Coefficient on r^ 4 : 1e-5". */
static void lensimport__report_detail(lensimport__reader *r, int32_t *surface)
{
    double v = 0;
    r->next = 0;
    if (!lensimport__word(r)) return;
    if (lensimport__is(r, "Surface")) {
        *surface = -1;
        if (!lensimport__word(r)) return;
        if (lensimport__number(r, &v) && v >= 0 && v < r->p->surface_count) *surface = (int32_t)v;
        else if (lensimport__is(r, "STO"))
            for (*surface = r->p->surface_count - 1; *surface >= 0 && !r->p->surfaces[*surface].is_stop; --*surface) {}
    } else if (lensimport__is(r, "Coefficient") && *surface >= 0) {
        const char *power = (const char *)memchr(r->text, '^', r->length);
        double p = 0;
        if (power == NULL || !lensimport__report_value(r, "Coefficient", &v)) return;
        r->next = (size_t)(power - r->text) + 1;
        if (lensimport__word(r) && lensimport__number(r, &p) && p >= 1 && p < 100) lensimport__term(r, &r->p->surfaces[*surface], (int32_t)p, v, r->line);
    }
}

/* The last numbers of the line; returns how many. */
static int32_t lensimport__report_waves(lensimport__reader *r, double *v)
{
    int32_t n = 0;
    while (lensimport__word(r) && n < LENSIMPORT__WAVES)
        if (lensimport__number(r, &v[n]) && v[n] > 0.1 && v[n] < 30) n++;
        else n = 0;
    return n;
}

/* A row of "INDEX OF REFRACTION DATA", under the wavelengths in um: for glasses that are not in the catalogue. */
static int lensimport__report_index(lensimport__reader *r, double *nm, int32_t *count)
{
    double n[LENSIMPORT__WAVES + 4], surface;
    int32_t found, i;
    r->next = 0;
    if (!lensimport__word(r)) return 1;
    if (lensimport__is(r, "Surf")) {
        *count = lensimport__report_waves(r, nm);
        for (i = 0; i < *count; i++) nm[i] *= 1000;
        return 1;
    }
    if (*count == 0 || !lensimport__number(r, &surface) || !(surface >= 0 && surface < r->p->surface_count)) return 1;
    found = lensimport__report_waves(r, n);
    if (found >= *count) {
        lflare_medium *m = &r->p->surfaces[(int32_t)surface].medium;
        if (m->kind == LFLARE_MEDIUM_AIR && m->glass[0] != 0) return lensimport__set_samples(r, m, nm, n + found - *count, *count, r->line);
    }
    return 1;
}

/* What a report's zoom table says of the state that is wanted; the rows are in the state of its head. */
typedef struct lensimport__report_zoom {
    int32_t wanted, block;      /* state, 0 for the rows'; that whose lines are being read */
    int32_t seen;               /* the wanted one has lines */
    int32_t pupil, image_space; /* the aperture is set as the entrance pupil's diameter, or as the f-number */
    int32_t last_set, last_solved;
} lensimport__report_zoom;

/* "System Aperture : Image Space F/# = 2.8" */
static void lensimport__report_aperture(lensimport__reader *r, lensimport__report_zoom *z)
{
    if (!lensimport__report_value(r, "System Aperture", NULL)) return;
    r->next = (size_t)(r->word - r->text);
    lensimport__rest(r);
    z->pupil = lensimport__begins(r->word, r->word_size, "Entrance Pupil Diameter");
    z->image_space = lensimport__begins(r->word, r->word_size, "Image Space F/#");
}

/* An operand that is not followed, unless it does not matter here. */
static void lensimport__report_unfollowed(lensimport__reader *r, const char *name)
{
    static const char harmless[] = " X-FIELD Y-FIELD FIELD WAVE WAVELENGTH WEIGHT TEMPERATURE PRESSURE MOFF TITLE ";
    char padded[28];
    size_t i;
    lensimport__format(padded, sizeof padded, " %s ", name);
    for (i = 0; padded[i] != 0; i++) padded[i] = lensimport__upper(padded[i]);
    if (strstr(harmless, padded) == NULL) lensimport__note(r, LENSIMPORT_NOTE_CONFIG_PARTLY, r->line, 0, 0, name);
}

/* "Configuration   2:", then "  1 Thickness   8 :   17.3". */
static void lensimport__report_state(lensimport__reader *r, lensimport__report_zoom *z)
{
    double v = 0, surface = -1;
    char name[24];
    const char *colon = (const char *)memchr(r->text, ':', r->length);
    lflare_surface *s;
    r->next = 0;
    if (colon == NULL || !lensimport__word(r)) return;
    if (lensimport__is(r, "Configuration")) {
        r->next = (size_t)(r->word + r->word_size - r->text);
        if (lensimport__word(r) && lensimport__read_number(r->word, r->word[r->word_size - 1] == ':' ? r->word_size - 1 : r->word_size, &v) && v >= 1 && v < 1000) z->block = (int32_t)v;
        return;
    }
    if (z->wanted == 0 || z->block != z->wanted || !lensimport__number(r, &v) || !lensimport__word(r)) return;
    z->seen = 1;
    lensimport__clean(r->word, r->word_size, 0, name, sizeof name);
    while (lensimport__word(r) && r->word < colon)
        if (!lensimport__number(r, &surface)) surface = -1;
    r->next = (size_t)(colon + 1 - r->text);
    s = surface >= 0 && surface < r->p->surface_count ? &r->p->surfaces[(int32_t)surface] : NULL;
    if (!lensimport__word(r) || !lensimport__number(r, &v)) s = NULL;
    if (s != NULL && strcmp(name, "Thickness") == 0) {
        s->thickness = v;
        z->last_set |= surface == r->p->surface_count - 2;
    } else if (s != NULL && strcmp(name, "Curvature") == 0) {
        lensimport__set_curvature(s, v);
    } else if (s != NULL && strcmp(name, "Conic") == 0) {
        s->conic = v;
    } else if (strcmp(name, "Aperture") == 0) {
        if (z->pupil) r->facts.epd = v;
        else if (z->image_space) r->p->fnumber = v;
    } else {
        lensimport__report_unfollowed(r, name);
    }
}

/* "Thickness of  20 : Solve, marginal ray height": in another state it is another one. */
static void lensimport__report_solve(lensimport__reader *r, lensimport__report_zoom *z)
{
    double v = 0;
    r->next = 0;
    if (z->wanted == 0 || !lensimport__word(r) || !lensimport__is(r, "Thickness") || !lensimport__word(r) || !lensimport__word(r) || !lensimport__number(r, &v)) return;
    lensimport__rest(r);
    if (strstr(r->text, "ariable") != NULL) return;
    if (v == r->p->surface_count - 2) z->last_solved = 1;
    else lensimport__note(r, LENSIMPORT_NOTE_CONFIG_PARTLY, r->line, 0, 0, "Solve");
}

/* Another state than the rows' is wanted: what the head says holds for theirs. */
static int lensimport__report_other_state(lensimport__reader *r, const lensimport__report_zoom *z)
{
    int32_t i;
    if (z->wanted > r->report->config_count) { r->report->config = z->wanted; return 1; } /* said for all formats alike */
    if (!z->seen) return lensimport__fail_at(r, LFLARE_ERROR_ARGUMENT, 0, 0, "this report has zoom state %i alone", r->report->config);
    r->report->config = z->wanted;
    r->report->stated_efl = 0;
    if (!z->image_space) r->p->fnumber = 0;
    if (!z->pupil) r->facts.epd = 0;
    if (r->p->fnumber > 0 || r->facts.epd > 0)
        for (i = 0; i < r->p->surface_count; i++)
            if (r->p->surfaces[i].is_stop) r->p->surfaces[i].semi_diameter = 0;
    if (z->last_solved && !z->last_set) r->facts.gap_unknown = 1;
    return 1;
}

static int lensimport__read_report(lensimport__reader *r)
{
    enum { GENERAL, TITLES, ROWS, DETAIL, STATES, SOLVES, INDEX, REST } part = GENERAL;
    lensimport__table table;
    lensimport__report_zoom zoom;
    double nm[LENSIMPORT__WAVES];
    int32_t surface = -1, waves = 0;
    memset(&zoom, 0, sizeof zoom);
    while (r->failed == LFLARE_OK && lensimport__line(r)) {
        size_t at = 0;
        while (at < r->length && lensimport__blank(r->text[at])) at++;
        if (at == r->length) continue;
        if (lensimport__begins(r->text + at, r->length - at, "SURFACE DATA SUMMARY")) { if (r->p->surface_count == 0) part = TITLES; continue; }
        if (lensimport__begins(r->text + at, r->length - at, "SURFACE DATA DETAIL")) { part = DETAIL; continue; }
        if (lensimport__begins(r->text + at, r->length - at, "MULTI-CONFIGURATION DATA")) { part = STATES; continue; }
        if (lensimport__begins(r->text + at, r->length - at, "SOLVE AND VARIABLE DATA")) { part = SOLVES; continue; }
        if (lensimport__begins(r->text + at, r->length - at, "INDEX OF REFRACTION DATA")) { part = INDEX; continue; }
        if (part == TITLES) {
            lensimport__titles(r, &table);
            if (table.count > 0 && table.kind[0] == LENSIMPORT__SURF) part = ROWS;
        } else if (part == ROWS) {
            if (!lensimport__report_row(r, &table)) part = REST;
        } else if (part == DETAIL) {
            if (r->text[at] >= 'A' && r->text[at] <= 'Z' && r->text[r->length - 1] == ':' && !lensimport__begins(r->text + at, r->length - at, "Surface")) part = REST;
            else lensimport__report_detail(r, &surface);
        } else if (part == STATES) {
            lensimport__report_state(r, &zoom);
        } else if (part == SOLVES) {
            lensimport__report_solve(r, &zoom);
        } else if (part == INDEX) {
            lensimport__report_index(r, nm, &waves);
        } else if (part == GENERAL) {
            lensimport__report_general(r);
            lensimport__report_aperture(r, &zoom);
            zoom.wanted = r->desc->config == r->report->config ? 0 : r->desc->config;
        }
    }
    if (r->failed != LFLARE_OK || lensimport__refused(r)) return 0;
    if (zoom.wanted > 0 && !lensimport__report_other_state(r, &zoom)) return 0;
    return lensimport__strip(r);
}

/* >> 8 code v */
/* Commands, ended by ';' or the line; '!' begins a comment, '&' at a line's end goes on with the next. */

enum { LENSIMPORT__PRIVATE = 24, LENSIMPORT__VALUES = 24 };

typedef struct lensimport__seq {
    int32_t radii;     /* surfaces have radii, not curvatures */
    int32_t surface;   /* row that commands belong to, -1 none */
    int32_t zooms, image_seen, clear; /* clear: the surface has a plain CIR */
    int32_t solved;    /* surface whose gap leads to the paraxial image in the first zoom position, 0 none */
    double solved_gap;
    int32_t private_table, waves, glasses;
    double nm[LENSIMPORT__WAVES];
    double n[LENSIMPORT__PRIVATE][LENSIMPORT__WAVES];
    int32_t samples[LENSIMPORT__PRIVATE];
    int32_t form[LENSIMPORT__PRIVATE]; /* 0: indices at the wavelengths; 1: Laurent's coefficients; -1: a form not known here */
    char name[LENSIMPORT__PRIVATE][24];
    int quoted;        /* the word last read was */
} lensimport__seq;

/* Nothing but blanks and a comment follow. */
static int lensimport__seq_ends(const lensimport__reader *r, size_t at)
{
    while (at < r->length && lensimport__blank(r->text[at])) at++;
    return at >= r->length || r->text[at] == '!';
}

/* The next word of the command; 0 at its end. */
static int lensimport__seq_word(lensimport__reader *r, lensimport__seq *q)
{
    const char *t = r->text;
    char end;
    q->quoted = 0;
    r->word_size = 0;
    for (;;) {
        while (r->next < r->length && lensimport__blank(t[r->next])) r->next++;
        r->word = t + r->next;
        if (r->next >= r->length || t[r->next] == '!' || t[r->next] == ';') return 0;
        if (t[r->next] != '&' || !lensimport__seq_ends(r, r->next + 1)) break;
        if (!lensimport__line(r)) { r->next = r->length; return 0; }
    }
    end = t[r->next];
    if (end == '\'' || end == '"') {
        q->quoted = 1;
        r->word = t + ++r->next;
        while (r->next < r->length && t[r->next] != end) r->next++;
        r->word_size = (size_t)(t + r->next - r->word);
        if (r->next < r->length) r->next++;
        return 1;
    }
    while (r->next < r->length && !lensimport__blank(t[r->next]) && strchr(";!\"'", t[r->next]) == NULL && !(t[r->next] == '&' && lensimport__seq_ends(r, r->next + 1))) r->next++;
    r->word_size = (size_t)(t + r->next - r->word);
    if (r->word_size == 0) r->next++; /* never stand still */
    return 1;
}

/* To the first word of the next command. */
static int lensimport__seq_command(lensimport__reader *r, lensimport__seq *q)
{
    for (;;) {
        while (lensimport__seq_word(r, q)) {}
        if (r->next < r->length && r->text[r->next] == ';') r->next++;
        else if (!lensimport__line(r)) return 0;
        if (lensimport__seq_word(r, q)) return 1;
    }
}

/* The glass of a surface: NBK7_SCHOTT, 500.700, 1.5168:64.2, 1.5168 64.2, 'PRIVATE', REFL. */
static int lensimport__seq_glass(lensimport__reader *r, lensimport__seq *q, lflare_surface *s)
{
    lflare_medium *m = &s->medium;
    const char *colon = (const char *)memchr(r->word, ':', r->word_size);
    double nd, vd = 0;
    memset(m, 0, sizeof *m);
    if (lensimport__is(r, "REFL") || lensimport__is(r, "REFT")) {
        lensimport__refuse(r, LENSIMPORT_REFUSED_MIRROR, r->line, r->word, r->word_size);
        return 1;
    }
    if (lensimport__is(r, "REFR")) return 1;
    if (q->quoted) {
        lensimport__clean(r->word, r->word_size, 1, m->glass, sizeof m->glass);
        return 1;
    }
    if (colon != NULL && lflare_number_read(r->word, (size_t)(colon - r->word), &nd) && nd < 5) {
        lflare_number_read(colon + 1, r->word_size - (size_t)(colon + 1 - r->word), &vd);
        return lensimport__set_numbers(r, m, nd, vd, r->line);
    }
    if (lensimport__number(r, &nd) && nd < 5) {
        if (lensimport__seq_word(r, q)) lensimport__number(r, &vd);
        return lensimport__set_numbers(r, m, nd, vd, r->line);
    }
    lensimport__set_glass(r, m, r->word, r->word_size, r->line); /* unknown ones may be private */
    return 1;
}

/* S, SO, SI, Sn: first number, gap, glass. */
static int lensimport__seq_surface(lensimport__reader *r, lensimport__seq *q)
{
    double v = 0, number = 0;
    lflare_surface *s;
    if (r->word_size > 1 && lflare_number_read(r->word + 1, r->word_size - 1, &number) && number >= 0 && number < r->p->surface_count) {
        q->surface = (int32_t)number;
        s = &r->p->surfaces[q->surface];
    } else {
        if (r->p->surface_count == 0 && !lensimport__is(r, "SO")) return lensimport__bad(r, "the object, SO, was expected first, not '%s'");
        if ((s = lensimport__row(r)) == NULL) return 0;
        q->surface = r->p->surface_count - 1;
        if (lensimport__is(r, "SI")) q->image_seen = 1;
    }
    q->clear = 0;
    if (!lensimport__seq_word(r, q)) return 1;
    if (!lensimport__number(r, &v)) return lensimport__bad(r, "a number was expected, not '%s'");
    if (q->radii) lensimport__set_radius(s, v);
    else lensimport__set_curvature(s, v);
    if (!lensimport__seq_word(r, q)) return 1;
    if (!lensimport__number(r, &s->thickness)) return lensimport__bad(r, "a number was expected, not '%s'");
    if (s == &r->p->surfaces[0] && fabs(s->thickness) >= 1e8) s->thickness = HUGE_VAL;
    return !lensimport__seq_word(r, q) || lensimport__seq_glass(r, q, s);
}

static int lensimport__among(const lensimport__reader *r, const char *words)
{
    char padded[20];
    size_t i;
    if (r->word_size > 16) return 0;
    padded[0] = ' ';
    for (i = 0; i < r->word_size; i++) padded[i + 1] = lensimport__upper(r->word[i]);
    padded[i + 1] = ' ';
    padded[i + 2] = 0;
    return strstr(words, padded) != NULL;
}

/* One value of a surface, in the file's terms. */
static int lensimport__seq_set(lensimport__reader *r, lensimport__seq *q, const char *what, int32_t surface, double v)
{
    static const char letters[] = "ABCDEFGHJ"; /* r^4 ... r^20 */
    lflare_surface *s;
    const char *letter;
    if (strcmp(what, "FNO") == 0) { r->p->fnumber = v; return 1; }
    if (strcmp(what, "EPD") == 0) { r->facts.epd = v; return 1; }
    if (strcmp(what, "NA") == 0) { if (v > 0) r->p->fnumber = 1 / (2 * v); return 1; }
    if (surface < 0 || surface >= r->p->surface_count) return 1;
    s = &r->p->surfaces[surface];
    letter = what[1] == 0 ? strchr(letters, what[0]) : NULL;
    if (strcmp(what, "THI") == 0) s->thickness = v;
    else if (strcmp(what, "RDY") == 0 || strcmp(what, "RAD") == 0) lensimport__set_radius(s, v);
    else if (strcmp(what, "CUY") == 0) lensimport__set_curvature(s, v);
    else if (strcmp(what, "K") == 0) s->conic = v;
    else if (letter != NULL) lensimport__term(r, s, 4 + 2 * (int32_t)(letter - letters), v, r->line);
    else if (strcmp(what, "CIR") == 0) { s->semi_diameter = v; q->clear = 1; }
    else if (strcmp(what, "EDG") == 0) { if (!q->clear) s->semi_diameter = v; }
    else if (strcmp(what, "CUF") == 0) { if (v != 0) lensimport__refuse(r, LENSIMPORT_REFUSED_SURFACE, r->line, "CUF", 3); }
    else if (v != 0) lensimport__refuse(r, LENSIMPORT_REFUSED_TILT, r->line, what, strlen(what)); /* decentres and angles */
    return 1;
}

/* WHAT [Sn] [Zn] value, or a value for each zoom position. */
static int lensimport__seq_parameter(lensimport__reader *r, lensimport__seq *q, int zoomed)
{
    char what[12];
    double v[LENSIMPORT__VALUES], number;
    int32_t count = 0, surface = q->surface, position = 0, config = r->desc->config > 0 ? r->desc->config : 1, i;
    size_t k = r->word_size < sizeof what - 1 ? r->word_size : sizeof what - 1;
    for (i = 0; i < (int32_t)k; i++) what[i] = lensimport__upper(r->word[i]);
    what[k] = 0;
    while (count < LENSIMPORT__VALUES && lensimport__seq_word(r, q)) {
        char first = r->word_size > 0 ? lensimport__upper(r->word[0]) : 0;
        if (lensimport__is(r, "EDG")) { memcpy(what, "EDG", 4); continue; }
        if (lensimport__number(r, &v[count])) { count++; continue; }
        if (count > 0) break;
        if (r->word_size > 1 && first == 'S' && lflare_number_read(r->word + 1, r->word_size - 1, &number)) surface = number >= 0 && number < 1000 ? (int32_t)number : -1;
        else if (r->word_size > 1 && first == 'Z' && lflare_number_read(r->word + 1, r->word_size - 1, &number)) position = number >= 1 && number < 1000 ? (int32_t)number : -1;
        else if (lensimport__is(r, "SI") || lensimport__is(r, "SO")) surface = lensimport__is(r, "SO") ? 0 : -1;
        else return 1; /* solves, holes and obstructions */
    }
    if (count == 0) return 1;
    for (i = 0; i < count; i++)
        if (!lensimport__finite(v[i])) return lensimport__bad(r, "a finite number was expected");
    if (position != 0) return position != config || lensimport__seq_set(r, q, what, surface, v[0]);
    if (!zoomed && count == 1) return lensimport__seq_set(r, q, what, surface, v[0]);
    if (count > q->zooms) q->zooms = count;
    return config > count || lensimport__seq_set(r, q, what, surface, v[config - 1]);
}

/* Between PRV and END: PWL wavelengths, then 'NAME' indices. */
static int lensimport__seq_private(lensimport__reader *r, lensimport__seq *q)
{
    double *out;
    int32_t *count;
    if (lensimport__is(r, "END")) { q->private_table = 0; return 1; }
    if (!q->quoted && lensimport__is(r, "PWL")) {
        out = q->nm;
        count = &q->waves;
    } else {
        if (q->glasses == LENSIMPORT__PRIVATE) return lensimport__bad(r, "more than 24 private glasses");
        lensimport__clean(r->word, r->word_size, 1, q->name[q->glasses], sizeof q->name[0]);
        out = q->n[q->glasses];
        count = &q->samples[q->glasses++];
    }
    *count = 0;
    while (lensimport__seq_word(r, q)) {
        if (*count == LENSIMPORT__WAVES) return lensimport__bad(r, "more than 32 wavelengths");
        if (out != q->nm && *count == 0 && !lensimport__number(r, &out[0])) {
            q->form[q->glasses - 1] = lensimport__is(r, "LAU") ? 1 : -1;
            continue;
        }
        if (!lensimport__number(r, &out[*count]) || !lensimport__finite(out[*count])) return lensimport__bad(r, "a wavelength or an index was expected, not '%s'");
        ++*count;
    }
    return 1;
}

/* The medium of private glass k; 0 if its form is not known or its numbers are too few. */
static int lensimport__seq_medium(lensimport__reader *r, const lensimport__seq *q, int32_t k, lflare_surface *s)
{
    static const double nm[3] = {LENSIMPORT__NM_F, LENSIMPORT__NM_D, LENSIMPORT__NM_C};
    const double *c = q->n[k];
    double n[3];
    int32_t i;
    if (q->form[k] == 0 && q->waves > 0 && q->samples[k] >= q->waves) {
        for (i = 0; i < q->waves; i++)
            if (!(q->nm[i] > 1)) return 0;
        return lensimport__set_samples(r, &s->medium, q->nm, c, q->waves, s->line);
    }
    if (q->form[k] != 1) return 0;
    for (i = 0; i < 3; i++) { /* n^2 = c0 + c1 l^2 + c2 / l^2 + c3 / l^4 ..., l in um; missing ones are 0 */
        double l2 = nm[i] * nm[i] * 1e-6;
        n[i] = sqrt(c[0] + c[1] * l2 + (c[2] + (c[3] + (c[4] + c[5] / l2) / l2) / l2) / l2);
    }
    return lensimport__set_samples(r, &s->medium, nm, n, 3, s->line);
}

/* The largest of a command's numbers, whatever their signs. */
static double lensimport__seq_largest(lensimport__reader *r, lensimport__seq *q)
{
    double best = 0, v;
    while (lensimport__seq_word(r, q))
        if (lensimport__number(r, &v) && fabs(v) > best && lensimport__finite(v)) best = fabs(v);
    return best;
}

static int lensimport__seq_system(lensimport__reader *r, lensimport__seq *q)
{
    double v;
    if (lensimport__is(r, "RDM")) {
        q->radii = !lensimport__seq_word(r, q) || !lensimport__begins(r->word, r->word_size, "N");
    } else if (lensimport__is(r, "TIT") || lensimport__is(r, "TITLE")) {
        if (lensimport__seq_word(r, q) && q->quoted && r->p->name[0] == 0) {
            lensimport__trim(r);
            lensimport__copy_text(r, r->p->name, sizeof r->p->name);
        }
    } else if (lensimport__is(r, "DIM")) {
        if (lensimport__seq_word(r, q)) r->facts.scale = lensimport__begins(r->word, r->word_size, "C") ? 10 : lensimport__begins(r->word, r->word_size, "I") ? 25.4 : 1;
    } else if (lensimport__among(r, " XAN YAN ")) {
        if ((v = lensimport__seq_largest(r, q)) > r->facts.field_degrees) r->facts.field_degrees = v;
    } else if (lensimport__among(r, " XIM YIM XRI YRI ")) {
        if ((v = lensimport__seq_largest(r, q)) > r->facts.image_radius) r->facts.image_radius = v;
    } else if (lensimport__is(r, "PRV")) {
        q->private_table = 1;
    } else {
        return 0;
    }
    return 1;
}

static void lensimport__seq_do(lensimport__reader *r, lensimport__seq *q, int zoomed);

/* Behind ZOO: what has a value for each position. */
static void lensimport__seq_zoomed(lensimport__reader *r, lensimport__seq *q)
{
    static const char followed[] = " FNO EPD NA THI RDY RAD CUY CUF K A B C D E F G H J CIR XDE YDE ZDE ADE BDE CDE STO ", harmless[] = " THC CCY GLC YAN XAN YOB XOB YIM XIM YRI XRI WTF WTW WTC TIT VUX VLX VUY VLY POS REF WL PIM ";
    char name[12];
    if (lensimport__among(r, followed)) lensimport__seq_do(r, q, 1);
    else if (r->desc->config > 1 && !q->quoted && !lensimport__among(r, harmless))
        lensimport__note(r, LENSIMPORT_NOTE_CONFIG_PARTLY, r->line, 0, 0, lensimport__clean(r->word, r->word_size, 0, name, sizeof name));
}

/* A command; its first word is read. */
static void lensimport__seq_do(lensimport__reader *r, lensimport__seq *q, int zoomed)
{
    double v;
    char first = r->word_size > 0 ? lensimport__upper(r->word[0]) : 0;
    if (q->private_table) {
        lensimport__seq_private(r, q);
    } else if (q->quoted || first == 0 || (!zoomed && lensimport__seq_system(r, q))) {
        return;
    } else if (!zoomed && (lensimport__among(r, " S SO SI ") || (first == 'S' && lflare_number_read(r->word + 1, r->word_size - 1, &v)))) {
        lensimport__seq_surface(r, q);
    } else if (lensimport__is(r, "ZOO") || lensimport__is(r, "ZOOM")) {
        if (zoomed || !lensimport__seq_word(r, q)) return;
        if (!lensimport__number(r, &v)) lensimport__seq_zoomed(r, q);
        else if (v >= 1 && v < 1000) q->zooms = (int32_t)v;
    } else if (lensimport__is(r, "STO")) {
        int32_t surface = q->surface;
        if (lensimport__seq_word(r, q) && r->word_size > 1 && lflare_number_read(r->word + 1, r->word_size - 1, &v)) surface = v >= 0 && v < 1000 ? (int32_t)v : -1;
        if (surface > 0 && surface < r->p->surface_count) r->p->surfaces[surface].is_stop = 1;
    } else if (lensimport__among(r, " FNO EPD NA THI RDY RAD CUY CUF K A B C D E F G H J CIR XDE YDE ZDE ADE BDE CDE ")) {
        lensimport__seq_parameter(r, q, zoomed);
    } else if (lensimport__is(r, "PIM") && q->surface > 0) {
        q->solved = q->surface;
        q->solved_gap = r->p->surfaces[q->surface].thickness;
    } else if (lensimport__among(r, " REFL RMD ")) {
        if (lensimport__is(r, "REFL") || (lensimport__seq_word(r, q) && lensimport__begins(r->word, r->word_size, "REFL")))
            lensimport__refuse(r, LENSIMPORT_REFUSED_MIRROR, r->line, r->word, r->word_size);
    } else if (lensimport__among(r, " GLA GL1 ")) {
        int32_t surface = q->surface;
        if (lensimport__seq_word(r, q) && first == 'G' && r->word_size > 1 && lensimport__upper(r->word[0]) == 'S' && lflare_number_read(r->word + 1, r->word_size - 1, &v)) {
            surface = v >= 0 && v < 1000 ? (int32_t)v : -1;
            lensimport__seq_word(r, q);
        }
        if (r->word_size > 0 && surface >= 0 && surface < r->p->surface_count) lensimport__seq_glass(r, q, &r->p->surfaces[surface]);
    } else if (lensimport__among(r, " DIF GRT HOE ")) {
        lensimport__refuse(r, LENSIMPORT_REFUSED_GRATING, r->line, r->word, r->word_size);
    } else if (lensimport__among(r, " CYL XTO YTO AAS CUX RDX ")) {
        lensimport__refuse(r, LENSIMPORT_REFUSED_TOROID, r->line, r->word, r->word_size);
    } else if (lensimport__among(r, " SPS SPL ")) {
        lensimport__seq_word(r, q);
        lensimport__refuse(r, LENSIMPORT_REFUSED_SURFACE, r->line, r->word, r->word_size);
    } else if (lensimport__among(r, " NSS MOD LMO ")) {
        lensimport__refuse(r, lensimport__is(r, "NSS") ? LENSIMPORT_REFUSED_SEQUENCE : LENSIMPORT_REFUSED_IDEAL, r->line, r->word, r->word_size);
    } else if (lensimport__among(r, " REX REY ELX ELY ADX ADY ")) {
        const char *name = lensimport__is(r, "REX") || lensimport__is(r, "REY") ? "rectangle" : lensimport__is(r, "ELX") || lensimport__is(r, "ELY") ? "ellipse" : "decentred";
        lensimport__note(r, LENSIMPORT_NOTE_APERTURE_IGNORED, r->line, 0, 0, name);
    }
}

static int lensimport__read_seq(lensimport__reader *r)
{
    lensimport__seq q;
    int32_t i, k;
    memset(&q, 0, sizeof q);
    q.surface = -1;
    q.zooms = 1;
    while (r->failed == LFLARE_OK && lensimport__seq_command(r, &q)) {
        if (!q.quoted && lensimport__is(r, "GO")) break;
        lensimport__seq_do(r, &q, 0);
    }
    if (r->failed != LFLARE_OK || lensimport__refused(r)) return 0;
    for (i = 0; i < r->p->surface_count; i++) {
        lflare_surface *s = &r->p->surfaces[i];
        char name[24];
        if (s->medium.kind != LFLARE_MEDIUM_AIR || s->medium.glass[0] == 0) continue;
        for (k = 0; k < q.glasses && strcmp(q.name[k], s->medium.glass) != 0; k++) {}
        if (k < q.glasses && lensimport__seq_medium(r, &q, k, s)) continue;
        if (r->failed != LFLARE_OK) return 0;
        memcpy(name, s->medium.glass, sizeof name);
        lensimport__set_glass(r, &s->medium, name, strlen(name), s->line);
    }
    if (r->desc->config > 1) lensimport__forget_stop(r);
    if (r->desc->config > 1 && q.solved > 0 && q.solved == r->p->surface_count - 2 && r->p->surfaces[q.solved].thickness == q.solved_gap) r->facts.gap_unknown = 1;
    r->report->config_count = q.zooms;
    r->report->config = r->desc->config > 0 ? r->desc->config : 1;
    return lensimport__strip(r);
}

/* >> 9 optical bench */
/* Lines of cells between tabs, in [sections]. Read three times: which zoom state; its distances and the constants; the rows. */

enum { LENSIMPORT__VARIABLES = 96 };

typedef enum lensimport__section {
    LENSIMPORT__ELSEWHERE, LENSIMPORT__DESCRIPTIVE, LENSIMPORT__CONSTANTS, LENSIMPORT__DISTANCES, LENSIMPORT__LENS, LENSIMPORT__ASPHERES, LENSIMPORT__PATENT
} lensimport__section;

typedef struct lensimport__bench {
    lensimport__section section;
    int32_t columns, config, seen; /* seen: d0 told which state looks at infinity */
    int32_t odd, a2;               /* aspheric terms: so many odd powers from 3 on; r^2 first */
    int32_t count;
    char name[LENSIMPORT__VARIABLES][16];
    double value[LENSIMPORT__VARIABLES];
    char id[LFLARE_MAX_SURFACES][8];
} lensimport__bench;

/* The next line that says something; sections are noticed on the way. The first cell is read. */
static int lensimport__bench_line(lensimport__reader *r, lensimport__bench *b)
{
    static const char *const names[] = {"[descriptive data]", "[constants]", "[variable distances]", "[lens data]", "[aspherical data]", "[patent info]"};
    int32_t i;
    while (lensimport__line(r)) {
        if (lensimport__empty(r) || !lensimport__cell(r) || (r->word_size > 0 && r->word[0] == '#')) continue;
        if (r->word_size == 0 || r->word[0] != '[') return 1;
        b->section = LENSIMPORT__ELSEWHERE;
        for (i = 0; i < 6; i++)
            if (lensimport__begins(r->word, r->word_size, names[i])) b->section = (lensimport__section)(i + 1);
    }
    return 0;
}

/* How many zoom states there are, and the one that is wanted: the first that looks at infinity. */
static void lensimport__bench_states(lensimport__reader *r, lensimport__bench *b)
{
    double v;
    b->columns = 1;
    b->config = 1;
    while (lensimport__bench_line(r, b)) {
        int32_t column = 0;
        int distance = lensimport__is(r, "d0");
        if (b->section != LENSIMPORT__DISTANCES) continue;
        while (lensimport__cell(r)) {
            column++;
            if (r->word_size == 0) continue;
            if (column > b->columns && column < 100) b->columns = column;
            if (distance && !b->seen && lensimport__number(r, &v) && !lensimport__finite(v)) {
                b->seen = 1;
                b->config = column;
            }
        }
    }
    if (r->desc->config > 0) b->config = r->desc->config;
    r->report->config = b->config;
    r->report->config_count = b->columns;
}

static double lensimport__bench_value(const lensimport__bench *b, const char *name, size_t size, int *found)
{
    int32_t i;
    for (i = 0; i < b->count; i++)
        if (lensimport__same(name, size, b->name[i])) {
            *found = 1;
            return b->value[i];
        }
    *found = 0;
    return 0;
}

/* A row of [variable distances]: of the state's column, or the only one. */
static void lensimport__bench_variable(lensimport__reader *r, lensimport__bench *b)
{
    double v, value = 0, first = 0;
    int32_t column = 0, cells = 0, found = 0;
    char name[16];
    if (r->word_size == 0 || r->word_size >= sizeof name + 8 || b->count == LENSIMPORT__VARIABLES) return;
    lensimport__clean(r->word, r->word_size, 0, name, sizeof name);
    while (lensimport__cell(r)) {
        column++;
        if (r->word_size == 0) continue;
        cells++;
        if (!lensimport__number(r, &v)) continue;
        if (column == 1) first = v;
        if (column == b->config) { value = v; found = 1; }
    }
    if (!found && !(cells == 1 && column >= 1)) return;
    if (!found) value = first;
    memcpy(b->name[b->count], name, sizeof name);
    b->value[b->count++] = value;
}

static void lensimport__bench_constants(lensimport__reader *r, lensimport__bench *b)
{
    double v = 0;
    if (lensimport__is(r, "AsphericalOddCount")) {
        if (lensimport__cell(r) && lensimport__number(r, &v) && v >= 0 && v <= 16) b->odd = (int32_t)v;
    } else if (lensimport__is(r, "AsphericalA2")) {
        b->a2 = 1;
        if (lensimport__cell(r) && lensimport__number(r, &v) && v == 0) b->a2 = 0;
    }
}

static void lensimport__bench_distances(lensimport__reader *r, lensimport__bench *b)
{
    while (lensimport__bench_line(r, b)) {
        if (b->section == LENSIMPORT__DISTANCES) lensimport__bench_variable(r, b);
        if (b->section == LENSIMPORT__CONSTANTS) lensimport__bench_constants(r, b);
        if (b->section == LENSIMPORT__DESCRIPTIVE && (lensimport__is(r, "title") || lensimport__is(r, "lens name"))) {
            int title = lensimport__is(r, "title");
            lensimport__rest(r);
            if (title || r->p->name[0] == 0) lensimport__copy_text(r, r->p->name, sizeof r->p->name);
        }
        if ((b->section == LENSIMPORT__DESCRIPTIVE && lensimport__is(r, "patent")) || (b->section == LENSIMPORT__PATENT && lensimport__is(r, "number"))) {
            lensimport__cell(r); /* the number, or the country and then the number */
            if (r->word_size == 2) lensimport__cell(r);
            if (r->word_size > 0) lensimport__copy_text(r, r->p->patent, sizeof r->p->patent);
        }
    }
}

/* nd and Vd as numbers; a catalogue's coefficients where the name agrees with both. */
static int lensimport__bench_medium(lensimport__reader *r, lflare_surface *s, double nd, double vd, const char *glass, size_t size)
{
    lensimport_glass g;
    if (size > 0 && lensimport_glass_find(glass, size, r->desc->catalogues, &g) == LENSIMPORT_MATCH_NAME && (nd == 0 || (fabs(g.nd - nd) < 2e-5 && fabs(g.vd - vd) < 0.06))) {
        s->medium = g.medium;
        return 1;
    }
    if (nd == 0) return size == 0 || lensimport__set_glass(r, &s->medium, glass, size, r->line) || lensimport__unknown_glass(r, s->medium.glass, r->line);
    if (!lensimport__set_numbers(r, &s->medium, nd, vd, r->line)) return 0;
    if (size > 0 && s->medium.kind != LFLARE_MEDIUM_AIR) lensimport__clean(glass, size, 1, s->medium.glass, sizeof s->medium.glass);
    return 1;
}

/* id radius gap nd diameter Vd glass maker */
static int lensimport__bench_row(lensimport__reader *r, lensimport__bench *b)
{
    lflare_surface *s = lensimport__row(r);
    double radius = 0, nd = 0, vd = 0, v = 0;
    const char *index;
    size_t index_size;
    int found;
    if (s == NULL) return 0;
    lensimport__clean(r->word, r->word_size, 0, b->id[r->p->surface_count - 1], sizeof b->id[0]);
    lensimport__cell(r);
    if (lensimport__is(r, "AS")) s->is_stop = 1;
    else if (!lensimport__is(r, "FS") && !lensimport__is(r, "CG") && r->word_size > 0) {
        if (!lensimport__number(r, &radius)) return lensimport__bad(r, "a radius, AS, FS or CG was expected, not '%s'");
        lensimport__set_radius(s, radius);
    }
    lensimport__cell(r);
    r->facts.gap_unknown = r->word_size == 0; /* of the last row in the end */
    if (r->word_size > 0 && !lensimport__number(r, &s->thickness)) {
        char name[24];
        s->thickness = lensimport__bench_value(b, r->word, r->word_size, &found);
        if (!found) {
            r->facts.gap_unknown = 1;
            lensimport__note(r, LENSIMPORT_NOTE_GAP_MISSING, r->line, 0, 0, lensimport__clean(r->word, r->word_size, 0, name, sizeof name));
        }
    }
    lensimport__cell(r);
    index = r->word;
    index_size = r->word_size;
    if (index_size > 0 && !lensimport__number(r, &nd)) nd = 0;
    else if (index_size > 0) index_size = 0;
    lensimport__cell(r);
    if (lensimport__number(r, &v) && v > 0) s->semi_diameter = v / 2;
    lensimport__cell(r);
    if (!lensimport__number(r, &vd)) vd = 0;
    lensimport__cell(r);
    if (index_size > 0) return lensimport__bench_medium(r, s, 0, 0, index, index_size);
    if (nd == 0 && s->is_stop) return 1;
    if (nd == 0 && !(r->word_size > 0)) return 1;
    return lensimport__bench_medium(r, s, nd, vd, r->word, r->word_size);
}

/* id radius K, then A4 A6 ..., or A2 first, or odd powers between */
static int lensimport__bench_asphere(lensimport__reader *r, const lensimport__bench *b)
{
    char id[8];
    double v;
    int32_t i, power = b->a2 ? 2 : b->odd > 0 ? 3 : 4, odd = 0;
    lflare_surface *s;
    lensimport__clean(r->word, r->word_size, 0, id, sizeof id);
    for (i = 0; i < r->p->surface_count && strcmp(b->id[i], id) != 0; i++) {}
    if (i == r->p->surface_count) {
        lensimport__note(r, LENSIMPORT_NOTE_ASPHERE_LOST, r->line, 0, 0, id);
        return 1;
    }
    s = &r->p->surfaces[i];
    if (lensimport__cell(r) && lensimport__number(r, &v) && lensimport__finite(v) && fabs(v - s->radius) > 1e-3 * fabs(v)) lensimport__note(r, LENSIMPORT_NOTE_RADIUS_DIFFERS, r->line, s->radius, v, NULL);
    if (lensimport__cell(r) && lensimport__number(r, &v)) s->conic = v;
    for (; lensimport__cell(r); power++) {
        if (power % 2 != 0 && odd == b->odd) power++;
        odd += power % 2;
        if (r->word_size == 0) continue;
        if (!lensimport__number(r, &v) || !lensimport__finite(v)) return lensimport__bad(r, "an aspheric coefficient was expected, not '%s'");
        lensimport__term(r, s, power, v, r->line);
    }
    return 1;
}

static int lensimport__read_bench(lensimport__reader *r)
{
    lensimport__bench b;
    lflare_prescription *p = r->p;
    double v;
    int found;
    int32_t i;
    memset(&b, 0, sizeof b);
    lensimport__bench_states(r, &b);
    lensimport__rewind(r);
    lensimport__bench_distances(r, &b);
    lensimport__rewind(r);
    while (r->failed == LFLARE_OK && lensimport__bench_line(r, &b)) {
        if (b.section == LENSIMPORT__LENS) lensimport__bench_row(r, &b);
        if (b.section == LENSIMPORT__ASPHERES) lensimport__bench_asphere(r, &b);
    }
    if (r->failed != LFLARE_OK) return 0;
    v = lensimport__bench_value(&b, "Focal Length", 12, &found);
    if (found && lensimport__finite(v)) r->report->stated_efl = v;
    v = lensimport__bench_value(&b, "F-Number", 8, &found);
    if (found && lensimport__finite(v)) p->fnumber = v;
    v = lensimport__bench_value(&b, "Image Height", 12, &found);
    if (found && lensimport__finite(v)) r->facts.image_radius = v / 2;
    v = lensimport__bench_value(&b, "d0", 2, &found);
    if (found) r->facts.object_distance = v;
    if (b.config > 1) lensimport__forget_stop(r); /* the row's size is the first state's */
    v = lensimport__bench_value(&b, "Aperture Diameter", 15, &found); /* names are kept to 15 bytes */
    for (i = 0; found && lensimport__finite(v) && i < p->surface_count; i++)
        if (p->surfaces[i].is_stop) p->surfaces[i].semi_diameter = v / 2;
    return 1;
}

/* >> 10 plain tables */

/* Gaps that belong to the previous row, where the first is 0 and the last is not, as pbrt's older files have them. */
static void lensimport__shift_gaps(lensimport__reader *r)
{
    lflare_prescription *p = r->p;
    int32_t i, last = p->surface_count - 1;
    if (last < 1) return;
    if (p->surfaces[0].thickness == 0 && p->surfaces[last].thickness != 0) {
        for (i = 0; i < last; i++) p->surfaces[i].thickness = p->surfaces[i + 1].thickness;
        p->surfaces[last].thickness = 0;
        lensimport__note(r, LENSIMPORT_NOTE_GAPS_BEFORE, 0, 0, 0, NULL);
    }
    if (p->surfaces[last].thickness == 0) r->facts.gap_unknown = 1;
}

/* Without a stop marked so: the first plane that does nothing else. */
static void lensimport__find_plane_stop(lflare_prescription *p)
{
    int32_t i, plane = -1;
    lflare_medium before;
    memset(&before, 0, sizeof before);
    for (i = 0; i < p->surface_count; i++) {
        if (p->surfaces[i].is_stop) return;
        if (plane < 0 && p->surfaces[i].radius == 0 && lensimport__same_medium(&before, &p->surfaces[i].medium)) plane = i;
        before = p->surfaces[i].medium;
    }
    if (plane >= 0) p->surfaces[plane].is_stop = 1;
}

/* radius gap index diameter [Vd]; the index 0 is the stop's, or air's */
static int lensimport__pbrt_row(lensimport__reader *r)
{
    double v[5] = {0, 0, 0, 0, 0};
    lflare_surface *s = lensimport__row(r);
    int32_t i;
    if (s == NULL) return 0;
    r->next = 0;
    for (i = 0; i < 5 && lensimport__word(r) && r->word[0] != '#'; i++)
        if (!lensimport__number(r, &v[i])) return lensimport__bad(r, "a number was expected, not '%s'");
    if (i < 4) return lensimport__bad(r, "four numbers were expected, radius, gap, index and diameter");
    lensimport__set_radius(s, v[0]);
    s->thickness = v[1];
    s->semi_diameter = v[3] / 2;
    s->is_stop = v[0] == 0 && v[2] == 0;
    return v[2] == 0 || lensimport__set_numbers(r, &s->medium, v[2], v[4], r->line);
}

static int lensimport__read_pbrt(lensimport__reader *r)
{
    int named = 0;
    int32_t i, stops = 0;
    while (r->failed == LFLARE_OK && lensimport__line(r)) {
        if (!lensimport__word(r) || lensimport__is(r, "radius")) continue;
        if (r->word[0] != '#') { lensimport__pbrt_row(r); continue; }
        if (named++) continue;
        r->next = (size_t)(r->word + 1 - r->text);
        lensimport__rest(r);
        lensimport__copy_text(r, r->p->name, sizeof r->p->name);
    }
    for (i = 0; i < r->p->surface_count; i++) /* planes may be written like the stop */
        if (r->p->surfaces[i].is_stop && stops++ > 0) r->p->surfaces[i].is_stop = 0;
    lensimport__find_plane_stop(r->p);
    lensimport__shift_gaps(r);
    return r->failed == LFLARE_OK;
}

/* radius|0|inf|stop gap index Vd semi coating [shape]; the column of coatings is its converter's and means nothing */
static int lensimport__flaresim_row(lensimport__reader *r)
{
    static const char *const names[] = {"the gap", "the index", "the Abbe number", "the semi-diameter"};
    lflare_surface *s = lensimport__row(r);
    double v[4], radius;
    int32_t i;
    if (s == NULL) return 0;
    if (lensimport__is(r, "stop")) s->is_stop = 1;
    else if (lensimport__number(r, &radius)) lensimport__set_radius(s, radius);
    else return lensimport__bad(r, "a radius or 'stop' was expected, not '%s'");
    for (i = 0; i < 4; i++) {
        if (!lensimport__word(r)) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "%s is missing here", names[i]);
        if (!lensimport__number(r, &v[i])) return lensimport__bad(r, "a number was expected, not '%s'");
    }
    s->thickness = v[0];
    s->semi_diameter = v[3];
    if (!lensimport__set_numbers(r, &s->medium, v[1], v[2], r->line)) return 0;
    if (lensimport__word(r) && lensimport__word(r) && r->word[0] != '#' && !lensimport__is(r, "sph")) lensimport__refuse(r, LENSIMPORT_REFUSED_TOROID, r->line, r->word, r->word_size);
    return 1;
}

/* "# 12 surfaces, 7 glass elements, f/2.8", "# Patent: CH314381" */
static void lensimport__flaresim_comment(lensimport__reader *r)
{
    const char *at = r->text;
    double v;
    while ((at = strstr(at, "f/")) != NULL) {
        r->next = (size_t)(at + 2 - r->text);
        if (lensimport__word(r) && r->p->fnumber == 0 && lensimport__number(r, &v) && v > 0.1 && v < 1000) r->p->fnumber = v;
        at += 2;
    }
    r->next = 1;
    if (lensimport__word(r) && lensimport__is(r, "Patent:") && r->p->patent[0] == 0) {
        lensimport__rest(r);
        lensimport__copy_text(r, r->p->patent, sizeof r->p->patent);
    }
}

static int lensimport__read_flaresim(lensimport__reader *r)
{
    int rows = 0;
    double v;
    r->facts.diameters = 1;
    while (r->failed == LFLARE_OK && lensimport__line(r)) {
        if (!lensimport__word(r)) continue;
        if (r->word[0] == '#') {
            if (!rows) lensimport__flaresim_comment(r);
        } else if (rows) {
            lensimport__flaresim_row(r);
        } else if (lensimport__is(r, "surfaces:")) {
            rows = 1;
        } else if (lensimport__is(r, "name:")) {
            lensimport__rest(r);
            lensimport__copy_text(r, r->p->name, sizeof r->p->name);
        } else if (lensimport__is(r, "focal_length:")) {
            if (lensimport__word(r) && lensimport__number(r, &v) && lensimport__finite(v)) r->report->stated_efl = v;
        }
    }
    return r->failed == LFLARE_OK;
}

/* >> 11 xml and json */
/* Characters to names and values, whatever the lines. */

typedef struct lensimport__value {
    char key[32], text[96];
    size_t size;  /* of the text, cut if it was longer */
    int is_text;  /* JSON: in quotes */
} lensimport__value;

static int lensimport__space(char ch) { return ch == ' ' || ch == '\t' || ch == '\n'; }

static void lensimport__value_put(lensimport__value *v, char ch)
{
    if (v->size + 1 < sizeof v->text) v->text[v->size++] = ch;
    v->text[v->size] = 0;
}

static int lensimport__value_number(lensimport__reader *r, const lensimport__value *v, double *out)
{
    char quoted[28];
    if (lensimport__read_number(v->text, v->size, out)) return 1;
    return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "a number was expected for %s, not '%s'", v->key, lensimport__clean(v->text, v->size, 0, quoted, sizeof quoted));
}

static void lensimport__value_text(lensimport__reader *r, const lensimport__value *v, char *out, size_t room)
{
    r->word = v->text;
    r->word_size = v->size;
    lensimport__trim(r);
    lensimport__copy_text(r, out, room);
    r->word = r->text;
    r->word_size = 0;
}

/* The row being read, of both formats. */
typedef struct lensimport__element {
    double n, vd, nm, ior;
    int32_t sensor, stop, line;
} lensimport__element;

/* One film of its own index, a quarter of its wavelength thick. */
static void lensimport__film(lensimport__reader *r, lflare_surface *s, const lensimport__element *e)
{
    lflare_prescription *p = r->p;
    if (!(e->nm >= 100 && e->nm <= 20000) || !(e->ior > 1 && e->ior <= 10) || s->is_stop || p->layer_count == LFLARE_MAX_LAYERS) return;
    s->coating = LFLARE_COATING_STACK;
    s->first_layer = p->layer_count;
    s->layer_count = 1;
    p->layers[p->layer_count].n = e->ior;
    p->layers[p->layer_count++].thickness_nm = e->nm / (4 * e->ior);
}

/* A row is whole: its medium and coating, or it was the sensor. */
static int lensimport__element_end(lensimport__reader *r, lflare_surface *s, const lensimport__element *e)
{
    if (s == NULL) return 1;
    if (e->sensor) { r->p->surface_count--; return 1; }
    if (e->stop) {
        s->is_stop = 1;
        return 1;
    }
    if (e->n != 0 && !lensimport__set_numbers(r, &s->medium, e->n, e->vd, s->line)) return 0;
    lensimport__film(r, s, e);
    return 1;
}

static int lensimport__xml_value(lensimport__reader *r, const lensimport__value *v, lflare_surface *s, lensimport__element *e)
{
    double x;
    if (s == NULL) {
        if (strcmp(v->key, "name") == 0) lensimport__value_text(r, v, r->p->name, sizeof r->p->name);
        if (v->size == 0) return 1;
        if (strcmp(v->key, "fnumber") == 0) return lensimport__value_number(r, v, &r->p->fnumber);
        if (strcmp(v->key, "effectiveFocalLength") == 0) return lensimport__value_number(r, v, &r->report->stated_efl);
        if (strcmp(v->key, "filmWidth") == 0) return lensimport__value_number(r, v, &r->p->sensor_width);
        if (strcmp(v->key, "filmHeight") == 0) return lensimport__value_number(r, v, &r->p->sensor_height);
        return 1;
    }
    if (strcmp(v->key, "type") == 0) {
        e->stop = strcmp(v->text, "apertureStop") == 0;
        e->sensor = strcmp(v->text, "sensor") == 0;
        if (e->stop || e->sensor || strcmp(v->text, "lensSpherical") == 0 || strcmp(v->text, "lensAspherical") == 0) return 1;
        lensimport__refuse(r, lensimport__begins(v->text, v->size, "lensAnamorph") || lensimport__begins(v->text, v->size, "lensCyl") ? LENSIMPORT_REFUSED_TOROID : LENSIMPORT_REFUSED_SURFACE, r->line, v->text, v->size);
        return 1;
    }
    if (v->size == 0) return 1;
    if (strcmp(v->key, "radius") == 0) {
        if (!lensimport__value_number(r, v, &x)) return 0;
        lensimport__set_radius(s, x);
        return 1;
    }
    if (strcmp(v->key, "thickness") == 0) return lensimport__value_number(r, v, &s->thickness);
    if (strcmp(v->key, "height") == 0) return lensimport__value_number(r, v, &s->semi_diameter);
    if (strcmp(v->key, "refractiveIndex") == 0) return lensimport__value_number(r, v, &e->n);
    if (strcmp(v->key, "abbeNumber") == 0) return lensimport__value_number(r, v, &e->vd);
    if (strcmp(v->key, "coatingLambda") == 0) return lensimport__value_number(r, v, &e->nm);
    if (strcmp(v->key, "coatingIor") == 0) return lensimport__value_number(r, v, &e->ior);
    return 1;
}

/* Behind '<': a tag's name, '/' before an end's; its attributes are passed over. *empty: it ends itself. 0 at the text's end. */
static int lensimport__xml_tag(lensimport__reader *r, char *name, size_t room, int *empty)
{
    size_t n = 0;
    char ch, last = 0, quote = 0;
    int in_name = 1;
    while ((ch = lensimport__char(r)) != 0 && (ch != '>' || quote != 0)) {
        if (lensimport__space(ch)) in_name = 0;
        if (in_name && n + 1 < room && !(ch == '/' && n > 0)) name[n++] = ch;
        if (quote != 0) { if (ch == quote) quote = 0; }
        else if (!in_name && (ch == '"' || ch == '\'')) quote = ch;
        if (n == 3 && memcmp(name, "!--", 3) == 0) { /* a comment */
            char a = 0, b = 0;
            while ((ch = lensimport__char(r)) != 0 && !(a == '-' && b == '-' && ch == '>')) { a = b; b = ch; }
            last = '!';
            break;
        }
        last = ch;
    }
    name[n] = 0;
    *empty = last == '/' && n > 0 && name[0] != '/';
    return ch != 0;
}

static int lensimport__read_xml(lensimport__reader *r)
{
    lensimport__value v;
    lensimport__element e;
    lflare_surface *s = NULL;
    char ch, tag[32];
    int empty, root = 0, ended = 0;
    memset(&v, 0, sizeof v);
    memset(&e, 0, sizeof e);
    r->facts.stop_counts = 1;
    while (r->failed == LFLARE_OK && !ended && (ch = lensimport__char(r)) != 0) {
        if (ch != '<') { lensimport__value_put(&v, lensimport__space(ch) ? ' ' : ch); continue; }
        if (!lensimport__xml_tag(r, tag, sizeof tag, &empty)) break;
        if (lensimport__begins(tag, strlen(tag), "!DOCTYPE")) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "document types and entities are not read");
        if (tag[0] == '?' || tag[0] == '!') continue;
        if (!root) {
            char root_name[32];
            if (strcmp(tag, "opticalSystem") != 0)
                return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "the root <opticalSystem> was expected, not <%s>", lensimport__clean(tag, strlen(tag), 0, root_name, sizeof root_name));
            root = 1;
        } else if (strcmp(tag, "element") == 0) {
            if ((s = lensimport__row(r)) == NULL) return 0;
            memset(&e, 0, sizeof e);
        } else if (strcmp(tag, "/element") == 0) {
            if (!lensimport__element_end(r, s, &e)) return 0;
            s = NULL;
        } else if (tag[0] == '/') {
            ended = strcmp(tag, "/opticalSystem") == 0;
            while (v.size > 0 && v.text[v.size - 1] == ' ') v.text[--v.size] = 0;
            if (strcmp(tag + 1, v.key) == 0) lensimport__xml_value(r, &v, s, &e);
            v.key[0] = 0;
        }
        if (tag[0] != '/') memcpy(v.key, tag, sizeof tag);
        v.size = 0;
        v.text[0] = 0;
        if (!empty) /* blanks in front of a value */
            while ((ch = lensimport__char(r)) != 0)
                if (!lensimport__space(ch)) { r->next--; break; }
    }
    if (r->failed == LFLARE_OK && !ended) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "the text ends within <opticalSystem>");
    return r->failed == LFLARE_OK;
}

static int lensimport__json_value(lensimport__reader *r, const lensimport__value *v, lflare_surface *s, lensimport__element *e, double *stop)
{
    double x;
    if (s == NULL) {
        if (strcmp(v->key, "name") == 0) lensimport__value_text(r, v, r->p->name, sizeof r->p->name);
        if (strcmp(v->key, "patent_number") == 0) lensimport__value_text(r, v, r->p->patent, sizeof r->p->patent);
        if (strcmp(v->text, "null") == 0) return 1;
        if (strcmp(v->key, "focal_length") == 0) return lensimport__value_number(r, v, &r->report->stated_efl);
        if (strcmp(v->key, "fstop") == 0) return lensimport__value_number(r, v, &r->p->fnumber);
        if (strcmp(v->key, "aperture_index") == 0) return lensimport__value_number(r, v, stop);
        return 1;
    }
    if (strcmp(v->key, "is_stop") == 0) e->stop = strcmp(v->text, "true") == 0 || strcmp(v->text, "1") == 0;
    if (strcmp(v->text, "null") == 0) return 1;
    if (strcmp(v->key, "radius") == 0 || strcmp(v->key, "curvature_radius") == 0) {
        if (!lensimport__value_number(r, v, &x)) return 0;
        lensimport__set_radius(s, x);
        return 1;
    }
    if (strcmp(v->key, "distance") == 0 || strcmp(v->key, "thickness") == 0) return lensimport__value_number(r, v, &s->thickness);
    if (strcmp(v->key, "height") == 0) return lensimport__value_number(r, v, &s->semi_diameter);
    if (strcmp(v->key, "aperture_diameter") == 0) {
        if (!lensimport__value_number(r, v, &x)) return 0;
        s->semi_diameter = x / 2;
        return 1;
    }
    if (strcmp(v->key, "refractive_index") == 0 || strcmp(v->key, "nd") == 0) return lensimport__value_number(r, v, &e->n);
    if (strcmp(v->key, "abbe_nr") == 0) return lensimport__value_number(r, v, &e->vd);
    return 1;
}

/* Behind the opening quote. */
static int lensimport__json_string(lensimport__reader *r, lensimport__value *v)
{
    char ch;
    v->size = 0;
    v->text[0] = 0;
    while ((ch = lensimport__char(r)) != 0 && ch != '"') {
        if (ch == '\\') {
            if ((ch = lensimport__char(r)) == 0) break;
            if (ch == 'n' || ch == 't' || ch == 'r' || ch == 'u') ch = ' ';
        }
        lensimport__value_put(v, ch == '\n' ? ' ' : ch);
    }
    return ch != 0 || lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "the text ends within a string");
}

/* LensSim's members are named by their number and may stand in any order. */
static void lensimport__json_sort(lflare_prescription *p, double *number)
{
    int32_t i, k;
    for (i = 1; i < p->surface_count; i++) {
        lflare_surface s = p->surfaces[i];
        double n = number[i];
        for (k = i; k > 0 && number[k - 1] > n; k--) {
            p->surfaces[k] = p->surfaces[k - 1];
            number[k] = number[k - 1];
        }
        p->surfaces[k] = s;
        number[k] = n;
    }
}

/* A JSON text flattened: an object within the list lens_elements, or named lens0, lens1 ..., is a row. */
static int lensimport__read_json(lensimport__reader *r)
{
    lensimport__value v;
    lensimport__element e;
    lflare_surface *s = NULL;
    double stop = -1, number[LFLARE_MAX_SURFACES];
    int32_t depth = 0, list = 0, row = 0, numbered = 0, ended = 0;
    char ch;
    memset(&v, 0, sizeof v);
    memset(number, 0, sizeof number);
    memset(&e, 0, sizeof e);
    while (r->failed == LFLARE_OK && !ended && (ch = lensimport__char(r)) != 0) {
        if (lensimport__space(ch) || ch == ',' || ch == ':') continue;
        if (ch == '{' || ch == '[') {
            int named = lensimport__begins(v.key, strlen(v.key), "lens") && lensimport__digit(v.key[4]);
            depth++;
            if (ch == '[' && strcmp(v.key, "lens_elements") == 0) list = depth;
            if (ch == '{' && row == 0 && (named || (list > 0 && depth == list + 1))) {
                if ((s = lensimport__row(r)) == NULL) return 0;
                memset(&e, 0, sizeof e);
                row = depth;
                numbered |= named;
                if (named) lensimport__read_number(v.key + 4, strlen(v.key + 4), &number[r->p->surface_count - 1]);
            }
            v.key[0] = 0;
        } else if (ch == '}' || ch == ']') {
            if (depth == row && row > 0) {
                if (!lensimport__element_end(r, s, &e)) return 0;
                s = NULL;
                row = 0;
            }
            if (depth == list) list = 0;
            v.key[0] = 0;
            ended = --depth <= 0;
        } else if (ch == '"') {
            if (!lensimport__json_string(r, &v)) return 0;
            while ((ch = lensimport__char(r)) != 0 && lensimport__space(ch)) {}
            if (ch == ':') {
                memcpy(v.key, v.text, sizeof v.key - 1);
                if (v.size >= sizeof v.key) v.key[0] = 0; /* none of ours */
                continue;
            }
            if (ch != 0) r->next--;
            if (v.key[0] != 0) lensimport__json_value(r, &v, s, &e, &stop);
            v.key[0] = 0;
        } else { /* a number, true, false, null */
            for (v.size = 0; ch != 0 && !lensimport__space(ch) && strchr(",:]}", ch) == NULL; ch = lensimport__char(r)) lensimport__value_put(&v, ch);
            if (ch != 0) r->next--;
            if (v.key[0] != 0) lensimport__json_value(r, &v, s, &e, &stop);
            v.key[0] = 0;
        }
    }
    if (r->failed != LFLARE_OK) return 0;
    if (!ended) return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, r->line, lensimport__column(r), "the text ends within an object");
    if (numbered) lensimport__json_sort(r->p, number);
    if (stop >= 0 && stop < r->p->surface_count && r->p->surfaces[(int32_t)stop].radius == 0) r->p->surfaces[(int32_t)stop].is_stop = 1;
    lensimport__find_plane_stop(r->p);
    if (numbered) lensimport__shift_gaps(r);
    else if (r->p->fnumber > 0) { /* the stop's height is its neighbours', or 0 */
        int32_t i;
        for (i = 0; i < r->p->surface_count; i++)
            if (r->p->surfaces[i].is_stop) r->p->surfaces[i].semi_diameter = 0;
    }
    return 1;
}

/* >> 12 reading */

/* What a line gives away; LENSIMPORT_UNKNOWN for nothing. *said counts lines that are no comments. */
static lensimport_format lensimport__sniff_line(lensimport__reader *r, int32_t *said)
{
    double v;
    int32_t i;
    size_t at = 0;
    while (at < r->length && lensimport__blank(r->text[at])) at++;
    if (at == r->length) return LENSIMPORT_UNKNOWN;
    if (r->text[at] == '<') return LENSIMPORT_XML;
    if (r->text[at] == '{') return LENSIMPORT_JSON;
    if (lensimport__begins(r->text + at, r->length - at, "SURFACE DATA SUMMARY") || lensimport__begins(r->text + at, r->length - at, "System/Prescription Data")) return LENSIMPORT_ZEMAX_REPORT;
    if (lensimport__begins(r->text + at, r->length - at, "[lens data]") || lensimport__begins(r->text + at, r->length - at, "[descriptive data]") ||
        lensimport__begins(r->text + at, r->length - at, "[variable distances]"))
        return LENSIMPORT_BENCH;
    lensimport__word(r);
    if (lensimport__is(r, "lensflare")) return lensimport__word(r) && lensimport__number(r, &v) ? LENSIMPORT_LENSFLARE : LENSIMPORT_UNKNOWN;
    if (lensimport__is(r, "surfaces:") || lensimport__is(r, "focal_length:")) return LENSIMPORT_FLARESIM;
    if (lensimport__is(r, "VERS") || lensimport__is(r, "SURF")) return lensimport__word(r) && lensimport__number(r, &v) ? LENSIMPORT_ZEMAX : LENSIMPORT_UNKNOWN;
    if (lensimport__is(r, "MODE")) return lensimport__word(r) && (lensimport__is(r, "SEQ") || lensimport__is(r, "NSC")) ? LENSIMPORT_ZEMAX : LENSIMPORT_UNKNOWN;
    if (lensimport__begins(r->word, r->word_size, "RDM") && (r->word_size == 3 || r->word[3] == ';')) return LENSIMPORT_CODEV;
    if (lensimport__is(r, "SO")) {
        if (!lensimport__word(r) || !lensimport__number(r, &v) || !lensimport__word(r)) return LENSIMPORT_UNKNOWN;
        for (at = 0; at < r->word_size && r->word[at] != ';' && r->word[at] != '!'; at++) {}
        return lensimport__read_number(r->word, at, &v) ? LENSIMPORT_CODEV : LENSIMPORT_UNKNOWN;
    }
    if (lensimport__is(r, "radius")) return LENSIMPORT_UNKNOWN; /* titles without a '#' */
    if (r->word[0] != '#' && ++*said > 1) return LENSIMPORT_UNKNOWN; /* pbrt's tables begin with a row, but for comments */
    for (i = 0; lensimport__number(r, &v); i++)
        if (i == 3) return LENSIMPORT_PBRT;
        else lensimport__word(r);
    return LENSIMPORT_UNKNOWN;
}

static lensimport_format lensimport__sniff(lensimport__reader *r)
{
    lensimport_format format = LENSIMPORT_UNKNOWN;
    int32_t said = 0;
    lensimport__rewind(r);
    while (format == LENSIMPORT_UNKNOWN && lensimport__line(r)) format = lensimport__sniff_line(r, &said);
    lensimport__rewind(r);
    return format;
}

static void lensimport__begin(lensimport__reader *r, const void *bytes, size_t size)
{
    memset(r, 0, sizeof *r);
    r->bytes = (const uint8_t *)bytes;
    r->size = size;
    r->facts.catalogues = "";
    r->facts.object_distance = HUGE_VAL;
}

LENSIMPORT_API lensimport_format lensimport_sniff(const void *bytes, size_t size)
{
    lensimport__reader r;
    if (bytes == NULL) return LENSIMPORT_UNKNOWN;
    lensimport__begin(&r, bytes, size);
    return lensimport__sniff(&r);
}

/* Our own format needs no more than its focal length. */
static lflare_result lensimport__own(lensimport__reader *r)
{
    double at_stop;
    r->failed = lflare_text_read((const char *)r->bytes, r->size, r->p, r->error);
    if (r->failed != LFLARE_OK) return r->failed;
    if (lensimport__optics(r->p, &r->report->efl, &r->report->bfd, &at_stop) && !r->p->focus) r->report->stated_bfd = r->p->surfaces[r->p->surface_count - 1].thickness;
    if (r->desc->focus) {
        r->p->focus = 1;
        r->p->surfaces[r->p->surface_count - 1].thickness = 0;
    }
    return LFLARE_OK;
}

static int lensimport__dispatch(lensimport__reader *r)
{
    switch (r->report->format) {
    case LENSIMPORT_ZEMAX: return lensimport__read_zmx(r);
    case LENSIMPORT_ZEMAX_REPORT: return lensimport__read_report(r);
    case LENSIMPORT_CODEV: return lensimport__read_seq(r);
    case LENSIMPORT_BENCH: return lensimport__read_bench(r);
    case LENSIMPORT_PBRT: return lensimport__read_pbrt(r);
    case LENSIMPORT_XML: return lensimport__read_xml(r);
    case LENSIMPORT_JSON: return lensimport__read_json(r);
    case LENSIMPORT_FLARESIM: return lensimport__read_flaresim(r);
    default: return lensimport__fail_at(r, LFLARE_ERROR_SYNTAX, 1, 1, "no format of prescriptions known here");
    }
}

LENSIMPORT_API lflare_result lensimport_read(const void *bytes, size_t size, const lensimport_desc *desc, lflare_prescription *out, lensimport_report *report,
                                             lflare_error *error)
{
    static const lensimport_desc plain = {0, 0, NULL};
    lensimport_report unwanted;
    lensimport__reader r;
    if (error != NULL) memset(error, 0, sizeof *error);
    if (report == NULL) report = &unwanted;
    memset(report, 0, sizeof *report);
    lensimport__begin(&r, bytes, size);
    r.p = out;
    r.report = report;
    r.desc = desc != NULL ? desc : &plain;
    r.error = error;
    if (out == NULL || (bytes == NULL && size > 0) || r.desc->config < 0) {
        lensimport__fail_at(&r, LFLARE_ERROR_ARGUMENT, 0, 0, "no bytes, no prescription, or a negative zoom state");
        return r.failed;
    }
    memset(out, 0, sizeof *out);
    report->format = lensimport__sniff(&r);
    report->config = report->config_count = 1;
    if (report->format == LENSIMPORT_LENSFLARE) lensimport__own(&r);
    else if (lensimport__dispatch(&r)) {
        if (report->config > report->config_count) /* of other formats, too: they have one */
            lensimport__fail_at(&r, LFLARE_ERROR_ARGUMENT, 0, 0, "zoom state %i was asked for, the file has %i", report->config, report->config_count);
        else if (report->config_count > 1) lensimport__note(&r, LENSIMPORT_NOTE_CONFIG, 0, report->config, report->config_count, NULL);
        lensimport__finish(&r);
    }
    if (r.failed == LFLARE_OK && r.facts.refusal != LENSIMPORT_REFUSED_NOT) lensimport__refused(&r);
    if (r.failed == LFLARE_OK && r.desc->config > report->config_count)
        lensimport__fail_at(&r, LFLARE_ERROR_ARGUMENT, 0, 0, "zoom state %i was asked for, the file has %i", r.desc->config, report->config_count);
    return r.failed;
}

#endif /* LENSIMPORT_IMPLEMENTED */
#endif /* LENSIMPORT_IMPLEMENTATION */
