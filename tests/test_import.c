/* Foreign formats: one lens written in all of them reads the same; each format's traps; what is refused, and why; the glass
   catalogue; inputs cut at every byte, mutated, large. Real files of other people are read where they lie, in ../shared.
   Run from the root of the repository. */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSIMPORT_IMPLEMENTATION
#include "lenses/lensimport.h"

#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

static lflare_prescription prescription;
static lflare_lens lens;
static lensimport_report report;
static lflare_error error;

static lflare_result import_config(const void *bytes, size_t size, int32_t config)
{
    lensimport_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.config = config;
    return lensimport_read(bytes, size, &desc, &prescription, &report, &error);
}

static lflare_result import_text(const char *text) { return lensimport_read(text, strlen(text), NULL, &prescription, &report, &error); }

/* Reads and derives, or fails with the message. */
static void import_lens(const char *text)
{
    if (import_text(text) < 0 || lflare_lens_derive(&prescription, &lens, &error) < 0) fail_msg("line %d: %s", (int)error.line, error.text);
}

static const lensimport_note *find_note(lensimport_note_kind kind)
{
    int32_t i;
    for (i = 0; i < report.note_count; i++)
        if (report.notes[i].kind == kind) return &report.notes[i];
    return NULL;
}

static void assert_near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.10g is not %.10g", a, b);
}

/* ---- one lens, written in every format ---- */

typedef struct sheet {
    char text[400000];
    size_t size;
} sheet;

static sheet page, other;

static void put(sheet *s, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    s->size += (size_t)vsnprintf(s->text + s->size, sizeof s->text - s->size, format, list);
    va_end(list);
}

static double nd_of(const lflare_medium *m) { return lflare_index(m, 587.5618); }
static double vd_of(const lflare_medium *m)
{
    double spread = lflare_index(m, 486.1327) - lflare_index(m, 656.2725);
    return spread > 0 ? (nd_of(m) - 1) / spread : 0;
}
static int is_air(const lflare_surface *s) { return s->is_stop || s->medium.kind == LFLARE_MEDIUM_AIR; }

static void write_zmx(sheet *o, const lflare_prescription *p, double unit, const char *name)
{
    int32_t i, k;
    put(o, "VERS 150514 39 37269\r\nMODE SEQ\r\nNAME %s\r\nUNIT %s X W X CM MR CPMM\r\nFNUM %.17g 0\r\nGCAT SCHOTT\r\nFTYP 0 0 1 3 0 0 0\r\nYFLN 0 2.0E+1\r\n", "a lens", name, p->fnumber);
    put(o, "SURF 0\r\n  TYPE STANDARD\r\n  CURV 0.0 0 0 0 0 \"\"\r\n  DISZ INFINITY\r\n  DIAM 0 0 0 0 1 \"\"\r\n");
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        put(o, "SURF %d\r\n%s  TYPE %s\r\n  CURV %.17E 0 0 0 0 \"\"\r\n", (int)i + 1, s->is_stop ? "  STOP\r\n" : "", "EVENASPH", s->radius != 0 ? unit / s->radius : 0);
        for (k = 0; k < 8; k++) put(o, "  PARM %d %.17E\r\n", (int)k + 1, s->aspheric[k] * pow(unit, 2 * k + 1));
        put(o, "  DISZ %.17E\r\n  CONI %.17E\r\n", s->thickness / unit, s->conic);
        if (!is_air(s)) put(o, "  GLAS ___BLANK 1 0 %.17E %.17E 0 0 0 0 0 0\r\n", nd_of(&s->medium), vd_of(&s->medium));
        put(o, "  DIAM %.17E 0 0 0 1 \"\"\r\n", s->semi_diameter / unit);
    }
    put(o, "SURF %d\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 0\r\n  DIAM %.17g 0\r\nTOL TOFF 0 0\r\nMNUM 1 1\r\nMOFF 0 1 \"\" 0 0 0\r\n", (int)p->surface_count + 1, 21.63 / unit);
}

static void write_report(sheet *o, const lflare_prescription *p, double efl, int tabs)
{
    const char *t = tabs ? "\t" : " ";
    int32_t i, k;
    put(o, "System/Prescription Data\n\nFile : C:\\x.zmx\nTitle: a lens\n\nGENERAL LENS DATA:\n\nSurfaces                : %s%d\nEffective Focal Length  : %s%.10g%s(in air at system temperature and pressure)\n", t, (int)p->surface_count + 1, t, efl, t);
    put(o, "Image Space F/#         : %s%.17g\nLens Units              : %sMillimeters\n\nSURFACE DATA SUMMARY:\n\n", t, p->fnumber, t);
    put(o, tabs ? "Surf     \tType         \tRadius      \tThickness                \tGlass      \tDiameter          \tConic\tComment\n" : "Surf     Type              Comment              Radius              Thickness                                    Glass             Diameter                Conic\n");
    put(o, tabs ? " OBJ\tSTANDARD\tInfinity\tInfinity\t\t0\t0\t\n" : " OBJ STANDARD                             Infinity                 Infinity                                                            0                    0\n");
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        char id[12], radius[40], glass[80] = "";
        sprintf(id, s->is_stop ? "STO" : "%d", (int)i + 1);
        sprintf(radius, s->radius != 0 ? "%.15g" : "Infinity", s->radius);
        if (!is_air(s)) sprintf(glass, "%.12g, %.12g", nd_of(&s->medium), vd_of(&s->medium));
        if (tabs) put(o, " %3s\tEVENASPH\t%s\t%.17g\t%s\t%.15g\t%.15g\t\n", id, radius, s->thickness, glass, 2 * s->semi_diameter, s->conic);
        else put(o, "%4s EVENASPH         %8s %20s %24.15g %40s %20.12g %20.12g\n", id, i == 1 ? "a word" : "", radius, s->thickness, glass, 2 * s->semi_diameter, s->conic);
    }
    put(o, tabs ? " IMA\tSTANDARD\tInfinity\t\t\t43.26\t0\t\n" : " IMA STANDARD                             Infinity                                                                                 43.26                    0\n");
    put(o, "\nSURFACE DATA DETAIL:\n\n");
    for (i = 0; i < p->surface_count; i++) {
        if (p->surfaces[i].is_stop) put(o, "Surface STO     %sEVENASPH\n", t);
        else put(o, "Surface %3d     %sEVENASPH\n", (int)i + 1, t);
        for (k = 0; k < 8; k++) put(o, " Coefficient on r^%2d      : %s%.17g\n", 2 * ((int)k + 1), t, p->surfaces[i].aspheric[k]);
    }
}

static void write_seq(sheet *o, const lflare_prescription *p, int radii)
{
    int32_t i, k;
    put(o, "RDM%s;LEN       \"VERSION: 10.7       LENS VERSION: 80\"\nTITLE 'a lens; with ! all'\nFNO   %.17g ! comment\nDIM   M\nWL    656.3 587.6 &\n 486.1\nREF   2\nYAN   0.0 20.0\nSO    0.0 0.1e14\n", radii ? "" : " N", p->fnumber);
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        put(o, "S     %.17g %.17g", radii ? s->radius : s->radius != 0 ? 1 / s->radius : 0, s->thickness);
        if (!is_air(s)) put(o, " %.16g:%.16g", nd_of(&s->medium), vd_of(&s->medium));
        put(o, "\n  CCY 0; THC 0; CIR EDG %.17g\n  CIR %.17g\n", s->semi_diameter + 1, s->semi_diameter);
        if (s->is_stop) put(o, "  STO\n");
        if (s->conic != 0) put(o, "  K %.17g\n", s->conic);
        for (k = 1; k < 8; k++)
            if (s->aspheric[k] != 0) put(o, "%s %c %.17g", k == 1 ? "  ASP\n " : ";", "ABCDEFG"[k - 1], s->aspheric[k]);
        put(o, "\n");
    }
    put(o, "SI    0.0 -0.1\n  THC 0\nGO \n");
}

static void write_bench(sheet *o, const lflare_prescription *p, double efl)
{
    int32_t i, k;
    put(o, "[descriptive data]\t\t\ntitle\ta lens\n[constants]\nAsphericalA2\n[variable distances]\nFocal Length\t%.10g\t\t\nF-Number\t%.17g\nImage Height\t43.28\nMagnification\t0\nd0\tInfinity\nBf\t%.17g\n[lens data]\n", efl, p->fnumber,
        p->surfaces[p->surface_count - 1].thickness);
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        put(o, "%d\t", (int)i + 1);
        if (s->is_stop) put(o, "AS");
        else if (s->radius == 0) put(o, "Infinity");
        else put(o, "%.17g", s->radius);
        if (i + 1 == p->surface_count) put(o, "\tBf");
        else put(o, "\t%.17g", s->thickness);
        if (is_air(s)) put(o, "\t\t%.17g\n", 2 * s->semi_diameter);
        else put(o, "\t%.17g\t%.17g\t%.17g\n", nd_of(&s->medium), 2 * s->semi_diameter, vd_of(&s->medium));
    }
    put(o, "[aspherical data]\n");
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        put(o, "%d\t%.17g\t%.17g", (int)i + 1, s->radius, s->conic);
        for (k = 0; k < 8; k++) put(o, "\t%.17g", s->aspheric[k]);
        put(o, "\n");
    }
    put(o, "[notes]\n1\t2\t3\t4\n");
}

static void write_pbrt(sheet *o, const lflare_prescription *p, int before)
{
    int32_t i;
    put(o, "# a lens\n# radius\taxpos\tN\taperture\t\t\n");
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        double gap = before ? i == 0 ? 0 : p->surfaces[i - 1].thickness : i + 1 == p->surface_count ? 0 : s->thickness;
        put(o, " %.17g\t%.17g  %.17g\t%.17g \t\n", s->radius, gap, s->is_stop ? 0 : nd_of(&s->medium), 2 * s->semi_diameter);
    }
}

static void write_xml(sheet *o, const lflare_prescription *p, double efl, const char *end)
{
    int32_t i;
    put(o, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>%s<!-- a <comment> -->%s<opticalSystem>%s<name>a lens</name>%s<fnumber>%.17g</fnumber>%s<effectiveFocalLength>%.10g</effectiveFocalLength>%s<elements>%s", end, end, end, end, p->fnumber, end, efl, end, end);
    for (i = 0; i <= p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i < p->surface_count ? i : 0];
        int sensor = i == p->surface_count;
        put(o, "<element>%s<type>%s</type>%s<height>%.17g</height><thickness>%.17g</thickness>%s", end, sensor ? "sensor" : s->is_stop ? "apertureStop" : "lensSpherical", end, s->semi_diameter, sensor ? 0.001 : s->thickness, end);
        put(o, "<radius> %.17g%s</radius><refractiveIndex>%.17g</refractiveIndex><abbeNumber>%.17g</abbeNumber>%s", sensor ? 0 : s->radius, end, is_air(s) ? 1 : nd_of(&s->medium), is_air(s) ? 89.3 : vd_of(&s->medium), end);
        put(o, "<coatingLambda>%g</coatingLambda><coatingIor>1.38</coatingIor><mask></mask><maskFT/></element>%s", i == 0 ? 552.0 : 0.0, end);
    }
    put(o, "</elements>%s</opticalSystem>%s", end, end);
}

static void write_json(sheet *o, const lflare_prescription *p, double efl, const char *end)
{
    int32_t i;
    put(o, "{%s\"name\": \"a lens\",%s\"year\": 1981, \"patent_number\": \"US 1\", \"notes\": \"\\\"{[\", \"focal_length\": %.10g, \"fstop\": %.17g,%s", end, end, efl, p->fnumber, end);
    for (i = 0; i < p->surface_count; i++)
        if (p->surfaces[i].is_stop) put(o, "\"aperture_index\": %d,%s\"lens_elements\": [", (int)i, end);
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        put(o, "%s{\"radius\":%.17g,%s\"distance\" :\t%.17g, \"refractive_index\": %.17g, \"abbe_nr\": %.17g, \"height\": %.17g}", i > 0 ? "," : "", s->radius, end, s->thickness, is_air(s) ? 1 : nd_of(&s->medium), is_air(s) ? 0 : vd_of(&s->medium), s->semi_diameter);
    }
    put(o, "]%s}%s", end, end);
}

static void write_flaresim(sheet *o, const lflare_prescription *p, double efl, double times)
{
    int32_t i;
    put(o, "# a lens\n#\n# Patent: US1\n# %d surfaces, 7 glass elements, f/%.10g\n\nname: a lens\nfocal_length: %.10g\n\nsurfaces:\n# radius thickness ior abbe semi_ap coating\n", (int)p->surface_count, p->fnumber, efl);
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        if (s->is_stop) put(o, "  stop");
        else if (s->radius == 0) put(o, "  inf");
        else put(o, "  %.17g", s->radius);
        put(o, " %.17g %.17g %.17g %.17g %d\n", s->thickness, is_air(s) ? 1 : nd_of(&s->medium), is_air(s) ? 0 : vd_of(&s->medium), times * s->semi_diameter, !is_air(s));
    }
}

/* The same text as UTF-16. */
static size_t to_utf16(const sheet *from, uint8_t *out, int big, int mark)
{
    size_t i, n = 0;
    if (mark) {
        out[n++] = big ? 0xfe : 0xff;
        out[n++] = big ? 0xff : 0xfe;
    }
    for (i = 0; i < from->size; i++) {
        out[n++] = big ? 0 : (uint8_t)from->text[i];
        out[n++] = big ? (uint8_t)from->text[i] : 0;
    }
    return n;
}

enum { WRITTEN = 20 };
static const char *const written_names[WRITTEN] = {"zmx", "zmx in inches", "zmx in UTF-16LE with a mark", "zmx in UTF-16BE with a mark", "zmx in UTF-16LE", "zmx in UTF-16BE", "report with tabs", "report by width",
                                                   "seq with radii", "seq with curvatures", "bench", "pbrt", "pbrt, gaps before", "xml", "xml on one line", "json", "json on one line", "flaresim", "flaresim with diameters", "lensflare"};
static const lensimport_format written_formats[WRITTEN] = {
    LENSIMPORT_ZEMAX, LENSIMPORT_ZEMAX, LENSIMPORT_ZEMAX, LENSIMPORT_ZEMAX, LENSIMPORT_ZEMAX, LENSIMPORT_ZEMAX, LENSIMPORT_ZEMAX_REPORT, LENSIMPORT_ZEMAX_REPORT, LENSIMPORT_CODEV, LENSIMPORT_CODEV,
    LENSIMPORT_BENCH, LENSIMPORT_PBRT, LENSIMPORT_PBRT, LENSIMPORT_XML, LENSIMPORT_XML, LENSIMPORT_JSON, LENSIMPORT_JSON, LENSIMPORT_FLARESIM, LENSIMPORT_FLARESIM, LENSIMPORT_LENSFLARE};

/* Into `other`, byte by byte. */
static void write_as(const lflare_lens *l, int which)
{
    const lflare_prescription *p = &l->prescription;
    page.size = other.size = 0;
    switch (which) {
    case 1: write_zmx(&page, p, 25.4, "IN"); break;
    case 6: case 7: write_report(&page, p, l->efl, which == 6); break;
    case 8: case 9: write_seq(&page, p, which == 8); break;
    case 10: write_bench(&page, p, l->efl); break;
    case 11: case 12: write_pbrt(&page, p, which == 12); break;
    case 13: case 14: write_xml(&page, p, l->efl, which == 13 ? "\r\n  " : ""); break;
    case 15: case 16: write_json(&page, p, l->efl, which == 15 ? "\n  " : ""); break;
    case 17: case 18: write_flaresim(&page, p, l->efl, which == 17 ? 1 : 2); break;
    case 19: page.size = sizeof page.text; lflare_text_write(p, page.text, &page.size); break;
    default: write_zmx(&page, p, 1, "MM"); break;
    }
    if (which >= 2 && which <= 5) other.size = to_utf16(&page, (uint8_t *)other.text, which % 2, which < 4);
    else memcpy(other.text, page.text, other.size = page.size);
}

static const char *const lenses[] = {"angenieux-double-gauss", "biogon-35-28", "canon-28-80", "canon-70-200-mid", "cooke-triplet-27", "distagon-25", "fisheye-nikkor-16", "heliar-tronnier", "kreitzer-tele",
                                     "nikkor-105-14", "nikon-80-200-mid", "petzval-kodak", "planar-50-14", "sonnar-20", "tessar-50-35", "topogon",
                                     "apo-telyt-280", "biotar-14", "canon-70-200-long", "canon-70-200-short", "cooke-triplet-smith", "dagor", "fisheye-minolta-16", "flektagon-100-28", "nikkor-50-12", "nikkor-80-200-afs",
                                     "nikon-80-200-long", "nikon-80-200-short", "nikon-retrofocus-28", "sonnar-15", "speed-panchro", "takumar-14", "tessar-100-28", "ultron-100-20"};
enum { LENSES = sizeof lenses / sizeof lenses[0] };

static void read_own(const char *name, lflare_lens *out)
{
    char path[120], *text;
    size_t size;
    sprintf(path, "lenses/%s.lens", name);
    assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &size, NULL), LFLARE_OK);
    assert_int_equal(lflare_text_read(text, size, &prescription, NULL), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(&prescription, out, NULL), LFLARE_OK);
    free(text);
}

/* Focal length, back focus, rows, semi-diameters, f-number as they were. */
static void compare_lens(const lflare_lens *own, int which, const char *name)
{
    int32_t i;
    double digits = which == 7 ? 1e-9 : 1e-12; /* columns by width hold 12 digits */
    int closed = which == 11 || which == 12; /* no f-number, no dispersion in the format */
    int open = which == 15 || which == 16;   /* the f-number decides there, not the stop's height */
    if (lflare_lens_derive(&prescription, &lens, &error) < 0) fail_msg("%s as %s: %s", name, written_names[which], error.text);
    if (report.format != written_formats[which]) fail_msg("%s as %s: taken for %s", name, written_names[which], lensimport_format_name(report.format));
    if (!(fabs(lens.efl - own->efl) < digits * own->efl)) fail_msg("%s as %s: focal length %.12g, not %.12g", name, written_names[which], lens.efl, own->efl);
    if (!(fabs(lens.bfd - own->bfd) < 10 * digits * own->efl)) fail_msg("%s as %s: back focus %.12g, not %.12g", name, written_names[which], lens.bfd, own->bfd);
    if (!(fabs(report.efl - own->efl) < digits * own->efl)) fail_msg("%s as %s: the report's focal length is %.12g", name, written_names[which], report.efl);
    if (lens.surface_count != own->surface_count || lens.stop != own->stop) fail_msg("%s as %s: %d rows, the stop is %d", name, written_names[which], (int)lens.surface_count, (int)lens.stop + 1);
    if (!closed && !open && fabs(lens.fnumber - own->fnumber) > 1e-3 * own->fnumber) fail_msg("%s as %s: f/%g, not f/%g", name, written_names[which], lens.fnumber, own->fnumber);
    for (i = 0; i < lens.surface_count; i++) {
        const lflare_surface *a = &lens.prescription.surfaces[i], *b = &own->prescription.surfaces[i];
        if (a->is_stop && open) continue;
        if (fabs(a->semi_diameter - b->semi_diameter) > (a->is_stop ? 1e-3 : 1e-9) * b->semi_diameter) fail_msg("%s as %s: row %d: semi-diameter %g, not %g", name, written_names[which], (int)i + 1, a->semi_diameter, b->semi_diameter);
        if (!a->is_stop && fabs(nd_of(&a->medium) - nd_of(&b->medium)) > 1e-10) fail_msg("%s as %s: row %d: another index", name, written_names[which], (int)i + 1);
        if (!a->is_stop && !closed && fabs(vd_of(&a->medium) - vd_of(&b->medium)) > 1e-6) fail_msg("%s as %s: row %d: another Abbe number", name, written_names[which], (int)i + 1);
    }
}

static void test_written(void **state)
{
    static lflare_lens own;
    int i, which;
    (void)state;
    for (i = 0; i < LENSES; i++) {
        read_own(lenses[i], &own);
        for (which = 0; which < WRITTEN; which++) {
            write_as(&own, which);
            if (import_config(other.text, other.size, 0) < 0) fail_msg("%s as %s: line %d, column %d: %s", lenses[i], written_names[which], (int)error.line, (int)error.column, error.text);
            compare_lens(&own, which, lenses[i]);
        }
    }
}


/* ---- real files of other people, read where they lie ---- */

typedef struct sample {
    const char *name;
    int32_t config;
    double efl;           /* 0: refused, for `reason` */
    double tolerance;     /* relative */
    const char *reason;
    lensimport_refusal refusal;
} sample;

/* Focal lengths as their README states them; where it states none, or other than the surfaces make, computed apart from this code. */
static const sample samples[] = {
    {"zmx/2645156.zmx", 0, 100.02, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/1792917.zmx", 0, 100.246, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/2031792a.zmx", 0, 66.5, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/7643216b.zmx", 0, 100.473, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Smith1998a.zmx", 0, 52.036, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Yan2017.zmx", 0, 9.2301, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Yan2017.zmx", 1, 9.2301, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Yan2017.zmx", 2, 10.7683, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Yan2017.zmx", 3, 16.1103, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Yan2017.zmx", 4, 0, 0, "zoom state 4 was asked for, the file has 3", LENSIMPORT_REFUSED_NOT},
    {"zmx/6744570a.zmx", 0, 7.2718, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/Liang2006c.zmx", 0, 1.0914, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"zmx/prism_spect.zmx", 0, 0, 0, "refused: tilted or decentred (COORDBRK)", LENSIMPORT_REFUSED_TILT},
    {"xml/heliar-tronnier.xml", 0, 99.24, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"xml/kreitzer-tele.xml", 0, 400.9, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"json/ai_50_135mm.json", 0, 35.8, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"lens/tessar-50mm-f3.5.lens", 0, 50.0, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"lens/biogon-35mm-f2.8.lens", 0, 34.711, 1e-3, NULL, LENSIMPORT_REFUSED_NOT}, /* "35" */
    {"lens/mirror-500mm.lens", 0, 0, 0, "refused: a negative gap: light would go backwards, as behind a mirror", LENSIMPORT_REFUSED_BACKWARDS},
    {"dat/dgauss.50mm.dat", 0, 50.36, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"dat/wide.dat", 0, 100.1, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"seq/ag_dblgauss.seq", 0, 100, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
    {"seq/CODV_32327.seq", 0, 100, 1e-3, NULL, LENSIMPORT_REFUSED_NOT},
};
enum { SAMPLES = sizeof samples / sizeof samples[0] };

/* NULL where the samples are not there. */
static char *read_sample(const char *name, size_t *size)
{
    char path[160], *text = NULL;
    sprintf(path, "../shared/data/samples/%s", name);
    return lflare_file_read(path, NULL, NULL, &text, size, NULL) < 0 ? NULL : text;
}

static void test_samples(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < SAMPLES; i++) {
        const sample *s = &samples[i];
        size_t size;
        char *text = read_sample(s->name, &size);
        lflare_result result;
        if (text == NULL) { print_message("# %s is not here\n", s->name); skip(); }
        result = import_config(text, size, s->config);
        free(text);
        if (s->efl == 0) {
            if (result >= 0 || strcmp(error.text, s->reason) != 0 || report.refusal != s->refusal) fail_msg("%s: %s", s->name, result < 0 ? error.text : "was read");
            continue;
        }
        if (result < 0 || lflare_lens_derive(&prescription, &lens, &error) < 0) fail_msg("%s: line %d: %s", s->name, (int)error.line, error.text);
        if (!(fabs(lens.efl - s->efl) < s->tolerance * s->efl)) fail_msg("%s: focal length %.10g, not %.10g", s->name, lens.efl, s->efl);
    }
}

/* What the samples' README says beside focal lengths. */
static void test_sample_notes(void **state)
{
    size_t size;
    char *text = read_sample("xml/kreitzer-tele.xml", &size);
    (void)state;
    if (text == NULL) { print_message("# the samples are not here\n"); skip(); }
    assert_int_equal(import_config(text, size, 0), LFLARE_OK);
    free(text);
    assert_non_null(find_note(LENSIMPORT_NOTE_EFL_DIFFERS));
    assert_near(find_note(LENSIMPORT_NOTE_EFL_DIFFERS)->stated, 100, 0);
    text = read_sample("json/ai_50_135mm.json", &size);
    assert_int_equal(import_config(text, size, 0), LFLARE_OK);
    free(text);
    assert_near(find_note(LENSIMPORT_NOTE_EFL_DIFFERS)->stated, 90, 0);
    text = read_sample("lens/tessar-50mm-f3.5.lens", &size);
    assert_int_equal(import_config(text, size, 0), LFLARE_OK);
    free(text);
    assert_non_null(find_note(LENSIMPORT_NOTE_SEMI_HALVED));
    assert_near(prescription.surfaces[0].semi_diameter, 7.82, 1e-12);
    text = read_sample("dat/wide.dat", &size);
    assert_int_equal(import_config(text, size, 0), LFLARE_OK);
    free(text);
    assert_non_null(find_note(LENSIMPORT_NOTE_GAPS_BEFORE));
    assert_near(prescription.surfaces[0].thickness, 5.529, 0);
}

/* ---- glass ---- */

/* The table's stated values, from the file that the header's tables are made from. */
static void test_glass_table(void **state)
{
    char *text, *at;
    size_t size;
    int32_t n = 0;
    (void)state;
    assert_int_equal(lflare_file_read("lenses/glasses.csv", NULL, NULL, &text, &size, NULL), LFLARE_OK);
    text = (char *)realloc(text, size + 1);
    text[size] = 0;
    for (at = strchr(text, '\n') + 1; *at != 0; at = strchr(at, '\n') + 1, n++) {
        char name[32], maker[16];
        double nd, vd;
        lensimport_glass g, found;
        assert_int_equal(sscanf(at, "%31[^,],%15[^,],%lf,%lf,", name, maker, &nd, &vd), 4);
        assert_int_equal(lensimport_glass_get(n, &g), LFLARE_OK);
        assert_string_equal(g.name, name);
        assert_string_equal(g.maker, maker);
        if (!(fabs(g.nd - nd) < 1e-5) || !(fabs(g.vd - vd) < 0.05)) fail_msg("%s: nd %.7f Vd %.4f, not %.7f %.4f", name, g.nd, g.vd, nd, vd);
        if (lensimport_glass_find(name, strlen(name), maker, &found) != LENSIMPORT_MATCH_NAME || strcmp(found.name, name) != 0) fail_msg("%s of %s is not found", name, maker);
        if (!(lensimport_glass_nearest(nd, vd, maker, &found) < 0.05) || fabs(found.nd - nd) > 1e-4) fail_msg("%s: the nearest to it is %s", name, found.name);
    }
    free(text);
    assert_int_equal(n, 648);
    assert_int_equal(lensimport_glass_count(), 648);
    assert_int_equal(lensimport_glass_get(648, (lensimport_glass *)other.text), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensimport_glass_get(-1, (lensimport_glass *)other.text), LFLARE_ERROR_ARGUMENT);
}

/* Every row of the list says what it was checked against, and is found by its name, unless a glass with coefficients is. */
static void test_glass_list(void **state)
{
    char *text, *at;
    size_t size;
    int32_t listed = 0;
    (void)state;
    assert_int_equal(lflare_file_read("lenses/glasses_listed.csv", NULL, NULL, &text, &size, NULL), LFLARE_OK);
    text = (char *)realloc(text, size + 1);
    text[size] = 0;
    for (at = strstr(text, "\nname,") + 1, at = strchr(at, '\n') + 1; *at != 0; at = strchr(at, '\n') + 1) {
        char name[32], evidence[100];
        double nd, vd = 0;
        lensimport_glass g;
        if (sscanf(at, "%31[^,],%lf,%lf,%99[^\n]", name, &nd, &vd, evidence) != 4) assert_int_equal(sscanf(at, "%31[^,],%lf,,%99[^\n]", name, &nd, evidence), 3);
        if (lensimport_glass_find(name, strlen(name), NULL, &g) != LENSIMPORT_MATCH_NUMBERS) continue;
        listed++;
        assert_near(g.nd, nd, 1e-9);
        assert_near(g.vd, vd, 1e-9);
        assert_int_equal(g.medium.kind, vd == 0 ? LFLARE_MEDIUM_CONSTANT : LFLARE_MEDIUM_ABBE);
    }
    free(text);
    assert_true(listed > 300);
}

static const struct {
    const char *asked, *prefer, *name;
    lensimport_match match;
    double nd, vd;
} glass_names[] = {
    {"N-BK7", NULL, "N-BK7", LENSIMPORT_MATCH_NAME, 1.5168, 64.17},
    {"n-bk7", NULL, "N-BK7", LENSIMPORT_MATCH_NAME, 1.5168, 64.17},
    {"NBK7", NULL, "N-BK7", LENSIMPORT_MATCH_NAME, 1.5168, 64.17},
    {"BK7", NULL, "N-BK7", LENSIMPORT_MATCH_SUCCESSOR, 1.5168, 64.17},
    {"NBK7_SCHOTT", NULL, "N-BK7", LENSIMPORT_MATCH_NAME, 1.5168, 64.17},
    {"nbk7_schott", NULL, "N-BK7", LENSIMPORT_MATCH_NAME, 1.5168, 64.17},
    {"BK7_SCHOTT", NULL, "N-BK7", LENSIMPORT_MATCH_SUCCESSOR, 1.5168, 64.17},
    {"517642", NULL, "N-BK7", LENSIMPORT_MATCH_CODE, 1.5168, 64.17},
    {"517.642", NULL, "N-BK7", LENSIMPORT_MATCH_CODE, 1.5168, 64.17},
    {"516800.641700", NULL, "N-BK7", LENSIMPORT_MATCH_CODE, 1.5168, 64.17},
    {"517642.251", NULL, "N-BK7", LENSIMPORT_MATCH_CODE, 1.5168, 64.17},
    {"517642", "CDGM", "H-K9L", LENSIMPORT_MATCH_CODE, 1.5168, 64.20},
    {"500.700", NULL, "500.700", LENSIMPORT_MATCH_CODE_ONLY, 1.5, 70},
    {"123456.654321", NULL, "123456.654321", LENSIMPORT_MATCH_CODE_ONLY, 2.123456, 65.4321},
    {"003283", NULL, "S-LAH79", LENSIMPORT_MATCH_CODE, 2.00330, 28.27}, /* an index over 2 */
    {"001291", NULL, "001291", LENSIMPORT_MATCH_CODE_ONLY, 2.001, 29.1},
    {"NSK2_SCHOTT", NULL, "N-SK2", LENSIMPORT_MATCH_NAME, 1.60738, 56.65},
    {"NSSK2_SCHOTT", NULL, "N-SSK2", LENSIMPORT_MATCH_NAME, 1.62229, 53.27},
    {"SF6", NULL, "SF6", LENSIMPORT_MATCH_NAME, 1.80518, 25.43},
    {"F2", NULL, "F2", LENSIMPORT_MATCH_NAME, 1.62004, 36.37},
    {"F2", "SCHOTT", "F2", LENSIMPORT_MATCH_NAME, 1.62004, 36.37},
    {"LAKN7", NULL, "N-LAK7", LENSIMPORT_MATCH_SUCCESSOR, 1.6516, 58.52},
    {"BAFN10", NULL, "N-BAF10", LENSIMPORT_MATCH_SUCCESSOR, 1.67003, 47.11},
    {"BSL7", NULL, "S-BSL7", LENSIMPORT_MATCH_SUCCESSOR, 1.51633, 64.14},
    {"BSL7_OHARA", NULL, "S-BSL7", LENSIMPORT_MATCH_SUCCESSOR, 1.51633, 64.14},
    {"J-LAK14", NULL, "N-LAK14", LENSIMPORT_MATCH_SUCCESSOR, 1.6968, 55.41},
    {"JLAK14_HIKARI", NULL, "N-LAK14", LENSIMPORT_MATCH_SUCCESSOR, 1.6968, 55.41},
    {"JLASF05_HIKARI", NULL, "J-LASF05", LENSIMPORT_MATCH_NUMBERS, 1.83481, 42.73},
    {"KFK5_SUMITA", NULL, "N-FK5", LENSIMPORT_MATCH_SUCCESSOR, 1.48749, 70.41},
    {"MFCD1_HOYA", NULL, "M-FCD1", LENSIMPORT_MATCH_NUMBERS, 1.4971, 81.49},
    {"LAC7", NULL, "LAC7", LENSIMPORT_MATCH_NUMBERS, 1.6516, 58.44},
    {"SSK4", NULL, "SSK4", LENSIMPORT_MATCH_NUMBERS, 1.61765, 55.14},
    {"LAKN6", NULL, "LAKN6", LENSIMPORT_MATCH_NUMBERS, 1.6425, 0}, /* its Vd is not known */
    {"F4", NULL, "F4", LENSIMPORT_MATCH_NUMBERS, 1.61659, 36.63}, /* Schott's */
    {"F4", "SCHOTT CDGM", "F4", LENSIMPORT_MATCH_NUMBERS, 1.61659, 36.63},
    {"F4", "HOYA CDGM SCHOTT", "H-F4", LENSIMPORT_MATCH_SUCCESSOR, 1.62005, 36.35},
    {"H-LAF3", NULL, "H-LAF3B", LENSIMPORT_MATCH_SUCCESSOR, 1.744, 44.9}, /* not N-LAF3 */
    {"H-ZLAF53A", NULL, "H-ZLAF53B", LENSIMPORT_MATCH_SUCCESSOR, 1.834, 37.21},
    {"MC-TAFD51-50", NULL, "M-TAFD51", LENSIMPORT_MATCH_NUMBERS, 1.8208, 42.71},
    {"MP-NBF1", NULL, "M-NBF1", LENSIMPORT_MATCH_NUMBERS, 1.7433, 49.33},
    {"ZEONEX_E48R_2017", NULL, "ZEONEX", LENSIMPORT_MATCH_NUMBERS, 1.53116, 56.04},
    {"E48R_2017_ZEON", NULL, "E48R", LENSIMPORT_MATCH_NUMBERS, 1.53116, 56.04},
    {"EFDS1W_HOYA", NULL, "FDS1", LENSIMPORT_MATCH_NUMBERS, 1.92286, 20.88},
    {"K-SSK4", NULL, "SSK4", LENSIMPORT_MATCH_NUMBERS, 1.61765, 55.14},
    {"K-LASFN9", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0}, /* another glass than Schott's LASFN9 */
    {"KLAK7_SUMITA", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"SK55", NULL, "SK55", LENSIMPORT_MATCH_NUMBERS, 1.62041, 0},
    {"PSK53A", NULL, "PSK53A", LENSIMPORT_MATCH_NUMBERS, 1.62014, 0}, /* N-PSK53A is another glass */
    {"LAF3", NULL, "N-LAF3", LENSIMPORT_MATCH_SUCCESSOR, 1.717, 47.96},
    {"MC-NOBODY", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"H-SF6", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"K-SFLD6_SUMITA", NULL, "SFLD6", LENSIMPORT_MATCH_NUMBERS, 1.80518, 25.46},
    {"SLAL8_OHARA", NULL, "S-LAL8", LENSIMPORT_MATCH_NAME, 1.713, 53.87},
    {"J-LASF05", NULL, "J-LASF05", LENSIMPORT_MATCH_NUMBERS, 1.83481, 42.73},
    {"E-FD10", NULL, "FD10", LENSIMPORT_MATCH_NUMBERS, 1.72825, 28.32},
    {"L-TIM28_MOLD", NULL, "L-TIM28", LENSIMPORT_MATCH_NAME, 1.68948, 31.02},
    {"TAFD30", NULL, "TAFD30", LENSIMPORT_MATCH_NUMBERS, 1.883, 40.81},
    {"LAFN21", NULL, "LAFN21", LENSIMPORT_MATCH_NUMBERS, 1.78831, 47.47},
    {"SF10HT", NULL, "SF10", LENSIMPORT_MATCH_SUCCESSOR, 1.72825, 28.41},
    {"CAF2", NULL, "CAF2", LENSIMPORT_MATCH_NUMBERS, 1.43385, 94.99},
    {"F_SILICA", NULL, "F_SILICA", LENSIMPORT_MATCH_NUMBERS, 1.45846, 67.82},
    {"PMMA", NULL, "PMMA", LENSIMPORT_MATCH_NUMBERS, 1.49176, 57.44},
    {"BAF3", NULL, "N-BAF3", LENSIMPORT_MATCH_SUCCESSOR, 1.58272, 46.64},
    {"BAF3", "CDGM", "H-BAF3", LENSIMPORT_MATCH_SUCCESSOR, 1.57957, 53.71},
    {"XYZ99", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"_", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"-", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"12", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"517000", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
    {"N", NULL, "", LENSIMPORT_MATCH_NONE, 0, 0},
};

static void test_glass_names(void **state)
{
    size_t i;
    lensimport_glass g;
    (void)state;
    for (i = 0; i < sizeof glass_names / sizeof glass_names[0]; i++) {
        lensimport_match match = lensimport_glass_find(glass_names[i].asked, strlen(glass_names[i].asked), glass_names[i].prefer, &g);
        if (match != glass_names[i].match) fail_msg("'%s': match %d (%s), not %d", glass_names[i].asked, (int)match, match ? g.name : "", (int)glass_names[i].match);
        if (match == LENSIMPORT_MATCH_NONE) continue;
        if (strcmp(g.name, glass_names[i].name) != 0) fail_msg("'%s': %s, not %s", glass_names[i].asked, g.name, glass_names[i].name);
        assert_near(g.nd, glass_names[i].nd, 1e-5);
        assert_near(g.vd, glass_names[i].vd, 0.011);
        assert_near(lflare_index(&g.medium, 587.5618), g.nd, 1e-9);
    }
    assert_int_equal(lensimport_glass_find(NULL, 3, NULL, &g), LENSIMPORT_MATCH_NONE);
    assert_int_equal(lensimport_glass_find("BK7", 3, NULL, NULL), LENSIMPORT_MATCH_NONE);
    assert_near(lensimport_glass_nearest(1.5168, 64.17, NULL, &g), 0, 0.1);
    assert_string_equal(g.name, "N-BK7");
    assert_true(lensimport_glass_nearest(1.5168, 64.17, "OHARA", &g) < 1);
    assert_string_equal(g.name, "S-BSL7");
    assert_false(lensimport_glass_nearest(1.5168, 64.17, "NOBODY", &g) < 1e9);
    assert_true(lensimport_glass_nearest(1.8, 25, NULL, NULL) < 100);
}


/* ---- each format's traps ---- */

/* A plano-convex singlet of index 1.5, f = 100, in front of it the stop; %s: what the test is about. */
#define ZMX_HEAD "VERS 150514 39 37269\nMODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 20 0\nGCAT SCHOTT\n"
#define ZMX_OBJECT "SURF 0\n  TYPE STANDARD\n  CURV 0.0\n  DISZ INFINITY\n"
#define ZMX_STOP "SURF 1\n  STOP\n  TYPE STANDARD\n  CURV 0.0\n  DISZ 1\n  DIAM 10 1\n"
#define ZMX_FRONT "SURF 2\n  TYPE STANDARD\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60 0 0\n  DIAM 12 1\n"
#define ZMX_REAR "SURF 3\n  TYPE STANDARD\n  CURV 0.0\n  DISZ 96\n  DIAM 12 1\n"
#define ZMX_IMAGE "SURF 4\n  TYPE STANDARD\n  CURV 0.0\n  DISZ 0\n  DIAM 18\n"

static void test_zmx(void **state)
{
    const lensimport_note *note;
    (void)state;
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT ZMX_REAR ZMX_IMAGE);
    assert_near(lens.efl, 100, 1e-9);
    assert_near(lens.fnumber, 5, 1e-9);
    assert_near(lens.sensor_width, 29.9538, 1e-3);
    assert_near(lens.bfd, 100 - 5 / 1.5, 1e-9);
    assert_near(report.stated_bfd, 96, 0);

    /* TYPE missing; blank lines within a surface; merit functions and tolerances behind; the terms' powers */
    import_lens(ZMX_HEAD "SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  FIMP \n\n  CURV 0.0 0 0 0 0 \"\"\n  DISZ 1.0E+0\n  DIAM 0 0\n"
                "SURF 2\n  TYPE EVENASPH\n  CURV 0.0\n  PARM 1 0.01\n  PARM 2 -1.5E-5\n  PARM 8 1e-20\n  CONI -.5\n  DISZ 5\n  GLAS ___BLANK 2 1 1.5 60\n  DIAM 0 0\n" ZMX_REAR ZMX_IMAGE
                "BLNK \nCURV 9 9\nTOL TOFF 0 0\nMNUM 1 1\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_near(prescription.surfaces[1].aspheric[0], 0.01, 0);
    assert_near(prescription.surfaces[1].aspheric[1], -1.5e-5, 0);
    assert_near(prescription.surfaces[1].aspheric[7], 1e-20, 0);
    assert_near(prescription.surfaces[1].conic, -0.5, 0);

    /* lines of surfaces that are not indented; lower case; CR alone */
    import_lens("VERS 50203\rMODE SEQ\rUNIT IN\rFNUM 5 0\rSURF 0\rTYPE STANDARD\rDISZ 1e10\rSURF 1\rSTOP\rDISZ .1\rSURF 2\rCURV .5\rDISZ .2\rGLAS ___BLANK 1 0 1.5 60\rSURF 3\rCURV 0\rDISZ 4\rSURF 4\rDISZ 0\rTOL X\rMNUM 1 1\r");
    assert_near(lens.efl, 4 * 25.4, 1e-9);
    assert_non_null(note = find_note(LENSIMPORT_NOTE_UNITS));
    assert_near(note->value, 25.4, 0);

    /* an odd asphere: the r^2 term counts, r^3 is left out; an extended one, over a radius of 10 */
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  TYPE ODDASPHE\n  CURV 0.0\n  PARM 1 0\n  PARM 2 0.01\n  PARM 3 1e-6\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\n" ZMX_REAR ZMX_IMAGE);
    assert_near(lens.efl, 100, 1e-9);
    assert_non_null(note = find_note(LENSIMPORT_NOTE_ASPHERE_CUT));
    assert_near(note->value, 3, 0);
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  TYPE XASPHERE\n  CURV 0.0\n  XDAT 1 2 0 0 1\n  XDAT 2 10 0 0 1\n  XDAT 3 1 0 0 1\n  XDAT 4 0.5\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\n" ZMX_REAR ZMX_IMAGE);
    assert_near(lens.efl, 100, 1e-9);
    assert_near(prescription.surfaces[1].aspheric[1], 0.5e-4, 1e-18);

    /* glass: catalogue, not the default numbers behind the name; a name with a pickup's flag falls back on its numbers */
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS BK7 0 0 1.5 4.0E+1 0 0\n" ZMX_REAR ZMX_IMAGE);
    assert_near(lens.efl, 50 / 0.5168, 1e-2);
    assert_string_equal(prescription.surfaces[1].medium.glass, "N-BK7");
    assert_non_null(find_note(LENSIMPORT_NOTE_GLASS_REPLACED));
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS NOBODY 1 0 1.5 4.0E+1 0 0\n" ZMX_REAR ZMX_IMAGE);
    assert_near(lens.efl, 100, 1e-9);
    assert_string_equal(prescription.surfaces[1].medium.glass, "NOBODY");
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS NOBODY 0 0 1.5 4.0E+1 0 0\n" ZMX_REAR ZMX_IMAGE), LFLARE_ERROR_LENS);
    assert_string_equal(error.text, "the glass 'NOBODY' is in no catalogue known here, and the file has no index for it");
    assert_int_equal(error.line, 19);
    /* only flags 1 and 2 mean that the numbers are the glass's; picked up from another surface they may be the default, 1.5 40 */
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS NOBODY 4 0 1.5 4.0E+1 0 0\n" ZMX_REAR ZMX_IMAGE), LFLARE_ERROR_LENS);
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS NOBODY 1 0 1.6 50\nSURF 3\n  DISZ 1\nSURF 4\n  DISZ 2\n  GLAS NOBODY 2 2 1.5 40\nSURF 5\n  DISZ 90\nSURF 6\n  DISZ 0\n");
    assert_near(prescription.surfaces[3].medium.c[0], 1.6, 0);
    assert_near(prescription.surfaces[3].medium.c[1], 50, 0);
    /* the file's own catalogue comes first: F2 and BAF3 are other glasses at CDGM */
    import_lens("VERS 1\nMODE SEQ\nUNIT MM\nENPD 20\nGCAT CDGM SCHOTT\n" ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS H-BAF3 0 0 1.5 4.0E+1\n" ZMX_REAR ZMX_IMAGE);
    assert_near(lens.efl, 50 / 0.57957, 1e-2);

    /* a stop on a refracting surface becomes a row: in front of a bulge, behind a hollow */
    import_lens(ZMX_HEAD ZMX_OBJECT "SURF 1\n  STOP\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\n" "SURF 2\n  CURV 0.0\n  DISZ 96\n" "SURF 3\n  DISZ 0\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_int_equal(lens.stop, 0);
    assert_non_null(find_note(LENSIMPORT_NOTE_STOP_SPLIT));
    import_lens(ZMX_HEAD ZMX_OBJECT "SURF 1\n  CURV 0.0\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\n" "SURF 2\n  STOP\n  CURV -0.02\n  DISZ 100\n" "SURF 3\n  DISZ 0\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_int_equal(lens.stop, 2);
    assert_near(prescription.surfaces[1].thickness, 0, 0);
    assert_near(prescription.surfaces[2].thickness, 100, 0);
    /* a stop behind its neighbour's vertex goes to it */
    import_lens(ZMX_HEAD ZMX_OBJECT "SURF 1\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\nSURF 2\n  CURV 0.0\n  DISZ 3\nSURF 3\n  STOP\n  DISZ -1\nSURF 4\n  CURV 0\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60\nSURF 5\n  DISZ 90\nSURF 6\n  DISZ 0\n");
    assert_near(prescription.surfaces[1].thickness, 2, 0);
    assert_near(prescription.surfaces[2].thickness, 0, 0);
    assert_near(find_note(LENSIMPORT_NOTE_STOP_MOVED)->value, 1, 0);
    /* dummies vanish and their gaps stay; a stop that is missing is put into the widest gap */
    import_lens(ZMX_HEAD ZMX_OBJECT "SURF 1\n  DISZ 7\nSURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\nSURF 3\n  CURV 0.0\n  DISZ 3\nSURF 4\n  DISZ 4\nSURF 5\n  CURV 0\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60\nSURF 6\n  DISZ 80\nSURF 7\n  DISZ 5\nSURF 8\n  DISZ 0\n");
    assert_int_equal(lens.surface_count, 5);
    assert_int_equal(lens.stop, 2);
    assert_near(prescription.surfaces[1].thickness, 3.5, 0);
    assert_near(report.stated_bfd, 85, 0);
    assert_non_null(find_note(LENSIMPORT_NOTE_STOP_GUESSED));
    assert_near(find_note(LENSIMPORT_NOTE_ROWS_LEFT_OUT)->value, 3, 0);
    /* dummies at any distance in front of the lens */
    import_lens(ZMX_HEAD ZMX_OBJECT "SURF 1\n  DISZ 1E+10\nSURF 2\n  DISZ 1\nSURF 3\n  STOP\n  DISZ 1\nSURF 4\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\nSURF 5\n  DISZ 80\nSURF 6\n  DISZ 0\n");
    assert_int_equal(lens.surface_count, 3);
    /* object and image in glass: faces are added, the focal length in air stays */
    import_lens(ZMX_HEAD "SURF 0\n  DISZ 2\n  GLAS ___BLANK 1 0 1.5 60\nSURF 1\n  DISZ 3\nSURF 2\n  STOP\n  DISZ 1\nSURF 3\n  CURV 0.02\n  DISZ 96\n  GLAS ___BLANK 1 0 1.5 60\nSURF 4\n  DISZ 0\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_non_null(find_note(LENSIMPORT_NOTE_OBJECT_IN_GLASS));
    assert_non_null(find_note(LENSIMPORT_NOTE_OBJECT_FINITE));
    assert_non_null(find_note(LENSIMPORT_NOTE_ENDS_IN_GLASS));
    /* coordinate breaks that break nothing */
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  TYPE COORDBRK\n  CURV 0.0\n  PARM 1 0\n  PARM 3 0\n  PARM 5 12\n  PARM 6 1\n  DISZ 1\nSURF 3\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\nSURF 4\n  DISZ 96\nSURF 5\n  DISZ 0\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_near(prescription.surfaces[0].thickness, 2, 0);
    /* clear apertures win over semi-diameters; other shapes are noted */
    import_lens(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\n  DIAM 12 1\n  CLAP 0 11 0\n  OBDC 0 1\n" "SURF 3\n  DISZ 96\n  SQAP 3 4\n" ZMX_IMAGE);
    assert_near(prescription.surfaces[1].semi_diameter, 11, 0);
    assert_string_equal(find_note(LENSIMPORT_NOTE_APERTURE_IGNORED)->label, "OBDC");
    /* as shops write them: no TYPE, no image surface, names of glasses alone */
    import_lens("UNIT MM\nSURF 0\n  COMM x\n  FIMP \n\n  CURV 0.0\n  DISZ INFINITY\n  MEMA 0 0 0 0 1 \"\"\nSURF 1\n  STOP\n  CURV 0.02\n  COAT A_B\n  DISZ 5\n  GLAS N-SF11\n  DIAM 5.75 1 0 0 1 \"\"\n  OEMA 0.5 0 0 0 0 \"\"\n  CLAP 0 5.7 0\nSURF 2\n  CURV 0\n  DISZ 60.5\n  DIAM 5\n");
    assert_near(lens.efl, 50 / 0.78472, 1e-3);
    assert_near(report.stated_bfd, 60.5, 0);
    assert_near(prescription.surfaces[1].semi_diameter, 5.7, 0);
    /* Latin-1 in a name becomes UTF-8, UTF-8 stays */
    import_lens("VERS 1\nNAME \xe9t\xc3\xa9 \nENPD 20\n" ZMX_OBJECT ZMX_STOP ZMX_FRONT ZMX_REAR ZMX_IMAGE);
    assert_string_equal(prescription.name, "\xc3\xa9t\xc3\xa9");
}

static void test_zmx_zoom(void **state)
{
    static const char zoom[] = ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT "SURF 3\n  DISZ 10\nSURF 4\n  CURV -0.01\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60\nSURF 5\n  DISZ 96\n  MAZH 0 0\nSURF 6\n  DISZ 0\n"
                               "MNUM 2 1\nMOFF   0   1 \"\" 0\nTHIC   3   1 1.0E+1 0 0\nTHIC   3   2 2.0E+1 0 0\nAPER   0   2 1.0E+1 0\nGLSS 2 2 0 0 \"N-BK7\" 0\nGLSS 4 2 0 \"\" 0\nCRVT 4 1 -0.01\nCRVT 4 2 -0.012 0\nWAVE 1 2 0.6\n";
    double one, two;
    (void)state;
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 0), LFLARE_OK);
    assert_int_equal(report.config, 1);
    assert_int_equal(report.config_count, 2);
    one = report.efl;
    assert_null(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY));
    assert_int_equal(prescription.focus, 0);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 2), LFLARE_OK);
    two = report.efl;
    assert_near(prescription.surfaces[2].thickness, 20, 0);
    assert_near(prescription.surfaces[3].radius, -1 / 0.012, 1e-9);
    assert_near(prescription.fnumber, two / 10, 1e-9);
    assert_int_equal(prescription.focus, 1); /* the last gap was solved for, in the first state alone */
    assert_string_equal(prescription.surfaces[1].medium.glass, "N-BK7");
    assert_near(prescription.surfaces[3].medium.c[0], 1.5, 0); /* it has no name in that state */
    assert_string_equal(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY)->label, "GLSS");
    assert_near(two, 172.98792, 1e-4); /* computed apart from this code */
    assert_true(fabs(one - two) > 1);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 3), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, -1), LFLARE_ERROR_ARGUMENT);
}

/* A gap that is another's follows it in every state; rules that the file itself breaks are said. */
static void test_zmx_pickups(void **state)
{
    static const char good[] = ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT "SURF 3\n  DISZ 10\nSURF 4\n  CURV -0.01\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60\nSURF 5\n  DISZ 86\n  PZUP 3 -1.0E+0 9.6E+1 0\nSURF 6\n  DISZ 0\nMNUM 2 1\nTHIC 3 1 10\nTHIC 3 2 20\n",
                      bad[] = ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT "SURF 3\n  DISZ 10\n  MAZH 0 0\nSURF 4\n  CURV -0.01\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60\nSURF 5\n  DISZ 86\n  PZUP 3 1 0 0\nSURF 6\n  DISZ 0\nMNUM 2 1\nTHIC 0 2 1e10\n";
    (void)state;
    assert_int_equal(import_config(good, sizeof good - 1, 0), LFLARE_OK);
    assert_near(report.stated_bfd, 86, 0);
    assert_int_equal(import_config(good, sizeof good - 1, 2), LFLARE_OK);
    assert_near(prescription.surfaces[2].thickness, 20, 0);
    assert_near(report.stated_bfd, 76, 1e-12);
    assert_null(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY));
    assert_int_equal(import_config(bad, sizeof bad - 1, 0), LFLARE_OK);
    assert_null(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY));
    assert_int_equal(import_config(bad, sizeof bad - 1, 2), LFLARE_OK);
    assert_near(report.stated_bfd, 86, 0);
    assert_string_equal(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY)->label, "PZUP");
    assert_string_equal(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY)[1].label, "MAZH");
}

static void test_report_text(void **state)
{
    (void)state;
    /* a glass nobody knows has its index in the report's own table */
    import_lens("System/Prescription Data\nConfiguration 2 of 3\nLens Units : Centimeters\nImage Space F/# : 5\nEffective Focal Length : 10 (in air)\n\nSURFACE DATA SUMMARY:\n\nSurf\tType\tRadius\tThickness\tGlass\tDiameter\tConic\tComment\n"
                "OBJ\tSTANDARD\tInfinity\tInfinity\t\t0\t0\t\nSTO\tSTANDARD\tInfinity\t0.1\t\t2\t0\t\n2\tSTANDARD\t5\t0.5\tNOBODY\t2.4\t-1\t\n3\tSTANDARD\tInfinity\t9.6\t\t2.4\t0\t\nIMA\tSTANDARD\tInfinity\t\t\t3.6\t0\t\n\n"
                "INDEX OF REFRACTION DATA:\n\nSystem Temperature: 20\n\n Surf\tGlass\tTemp\tPres\t  0.486133\t  0.587562\t  0.656273\n   0\t\t20\t1\t1\t1\t1\n   2\tNOBODY\t20.0\t1.0\t1.506\t1.5\t1.497\n   3\t\t20\t1\t1\t1\t1\n");
    assert_near(lens.efl, 100, 1e-4);
    assert_near(prescription.surfaces[1].medium.c[1], 0.5 / 0.009, 1e-2);
    assert_near(prescription.surfaces[1].semi_diameter, 12, 1e-12);
    assert_int_equal(report.config, 2);
    assert_int_equal(report.config_count, 3);
    assert_near(report.stated_efl, 100, 0);
    assert_null(find_note(LENSIMPORT_NOTE_EFL_DIFFERS));
}

/* A report's own table of zoom states, as such reports have it. */
#define REPORT_ZOOM(aperture, solves)                                                                                                                         \
    "System/Prescription Data\nTitle: \nConfiguration 1 of 3\nSystem Aperture         : \t" aperture "\nEffective Focal Length  :\t 98.0\t(in air)\nImage Space F/# :\t 5\nEntrance Pupil Diameter :\t 20\n\n" \
    "SURFACE DATA SUMMARY:\n\nSurf\tType\tRadius\tThickness\tGlass\tDiameter\tConic\tComment\n OBJ\tSTANDARD\tInfinity\tInfinity\t\t0\t0\t\n   1\tSTANDARD\t50\t5\t1.5, 60\t24\t0\t\n   2\tSTANDARD\tInfinity\t10\t\t24\t0\t\n" \
    " STO\tSTANDARD\tInfinity\t1\t\t18\t0\t\n   4\tSTANDARD\t-100\t1\t1.5, 60\t20\t0\t\n   5\tSTANDARD\tInfinity\t80\t\t20\t0\t\n IMA\tSTANDARD\tInfinity\t\t\t36\t0\t\n\nSURFACE DATA DETAIL:\n\nSurface OBJ STANDARD \n\nEDGE THICKNESS DATA:\n\nSurf\tEdge\n   1\t0.04\n\n" \
    "MULTI-CONFIGURATION DATA:\n\nConfiguration   1:\n\n  1 Thickness   2 :            10 \n  2 Thickness   5 :            80 \n\nConfiguration   2:\n\n  1 Thickness   2 :          20.5 \n  2 Thickness   5 :        81.25 \n  3 Aperture      :            25 \n\n" \
    "Configuration   3:\n\n  1 Thickness   2 :            30 \n  3 Wave    1 :  0.6\n  4 Curvature   4 :         -0.02\n  5 Conic 4 : -1 \n  6 Glass   4 : N-BK7\n\nSOLVE AND VARIABLE DATA:\n\n" solves "\nINDEX OF REFRACTION DATA:\n"

static void test_report_zoom(void **state)
{
    static const char pupil[] = REPORT_ZOOM("Entrance Pupil Diameter = \t 20", " Thickness of   5       : Solve, marginal ray height = 0\n"), number[] = REPORT_ZOOM("Image Space F/# = \t 5", " Thickness of   5       : Variable\n"),
                      opened[] = REPORT_ZOOM("Float By Stop Size = \t 9", " Thickness of   2       : Solve, pick up\n");
    (void)state;
    assert_int_equal(import_config(pupil, sizeof pupil - 1, 0), LFLARE_OK);
    assert_int_equal(report.config, 1);
    assert_int_equal(report.config_count, 3);
    assert_near(report.stated_efl, 98, 0);
    assert_near(prescription.surfaces[1].thickness, 10, 0);
    assert_null(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY));
    assert_int_equal(import_config(pupil, sizeof pupil - 1, 2), LFLARE_OK);
    assert_int_equal(report.config, 2);
    assert_near(report.stated_efl, 0, 0); /* that was the first state's */
    assert_near(prescription.surfaces[1].thickness, 20.5, 0);
    assert_near(report.stated_bfd, 81.25, 0);
    assert_near(prescription.fnumber, report.efl / 25, 1e-9);
    assert_near(prescription.surfaces[2].semi_diameter, 0, 0); /* the first state's stop */
    assert_int_equal(prescription.focus, 0);
    assert_int_equal(import_config(pupil, sizeof pupil - 1, 3), LFLARE_OK);
    assert_near(prescription.surfaces[3].radius, -50, 1e-9);
    assert_near(prescription.surfaces[3].conic, -1, 0);
    assert_near(prescription.fnumber, report.efl / 20, 1e-9);
    assert_int_equal(prescription.focus, 1); /* the last gap was solved for, in the first state */
    assert_string_equal(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY)->label, "Glass");
    assert_int_equal(import_config(pupil, sizeof pupil - 1, 4), LFLARE_ERROR_ARGUMENT);
    assert_string_equal(error.text, "zoom state 4 was asked for, the file has 3");
    assert_int_equal(import_config(number, sizeof number - 1, 2), LFLARE_OK);
    assert_near(prescription.fnumber, 25, 0); /* this aperture is an f-number */
    assert_int_equal(import_config(number, sizeof number - 1, 3), LFLARE_OK);
    assert_near(prescription.fnumber, 5, 0);
    assert_near(report.stated_bfd, 80, 0);
    assert_int_equal(import_config(opened, sizeof opened - 1, 3), LFLARE_OK);
    assert_near(prescription.fnumber, 0, 0);
    assert_near(prescription.surfaces[2].semi_diameter, 9, 0); /* what is set is the stop's size, which stays */
    assert_string_equal(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY)[1].label, "Solve");
    /* without the table there is the one state */
    assert_int_equal(import_config(pupil, (size_t)(strstr(pupil, "MULTI") - pupil), 2), LFLARE_ERROR_ARGUMENT);
    assert_string_equal(error.text, "this report has zoom state 1 alone");
}

static void test_seq(void **state)
{
    const lensimport_note *note;
    (void)state;
    /* lower case, no RDM: curvatures; a comment, continued lines, the image the last surface */
    import_lens("tit 'this is a title'\n! a comment\ndim m\nso 0. 1e+11\ns 0.02 5 500.600  ! was bk7\nsto\ns &\n0 96.7\ns 0 0\nepd 20.; wl 650 550 450 ! waves; yan 0 5 7.07\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_near(lens.fnumber, 5, 1e-9);
    assert_string_equal(prescription.name, "this is a title");
    assert_int_equal(lens.stop, 0);
    /* radii in cm, private glass after the surfaces, numbers as glass, aspheric terms, an edge aperture alone */
    import_lens("RDM\nLEN NEW\nTITLE \"x\"\nDIM C\nFNO 5\nSO 0 0.1E+14\nS 5 0.5 'PRV1'; CIR EDG 1.5; STO\nASP\nK -1.0\nA 1.0E-05 ; B -2.0E-08; D&\n 0.0\nS 0.0 9.6\nSI 0 0\nPRV\nPWL 656.2725 587.5618 486.1327\n'PRV1' 1.497 1.5 1.506\nEND\nGO\nS 1 2 3\n");
    assert_near(lens.efl, 100, 1e-6);
    assert_near(prescription.surfaces[1].semi_diameter, 15, 1e-12);
    assert_near(prescription.surfaces[1].aspheric[1], 1e-8, 1e-20);
    assert_near(prescription.surfaces[1].aspheric[2], -2e-13, 1e-25);
    assert_near(prescription.surfaces[1].conic, -1, 0);
    import_lens("RDM;LEN \"VERSION\"\nEPD 20\nSO 0 1e10\nS 50 5 1.5 60\nSTO S1\nS 0 96 \nSI 0 0\n");
    assert_near(lens.efl, 100, 1e-9);
    import_lens("RDM;LEN\nEPD 20\nSO 0 1e10\nS 50 5 1.5:60\nSTO\nS 0 96 AIR\nSI 0 0\n");
    assert_near(lens.efl, 100, 1e-9);
    import_lens("LEN NEW; DIM M\nEPD 20\nSO 0 0.1e14; S 0.02 5 1.5:60; STO\nS 0 96 AIR\nSI 0 0\n");
    assert_near(lens.efl, 100, 1e-9);
    import_lens("RDM;LEN\nEPD 20\nSO 0 1e10\nS 50 5 500000.600000\nSTO\nS 0 96\nSI 0 0\n");
    assert_near(lens.efl, 100, 1e-9);
    assert_near(prescription.surfaces[1].medium.c[1], 60, 1e-9);
    import_lens("RDM;LEN\nFNO 5\nSO 0 1e14\nS 50 5 'NOA61'; STO\nS 0.0 9.6\nSI 0 0\nPRV\nPWL 550\n'XYZ' SEL 1 2 3\n'NOA61' LAU 2.36390625 0.0 0.025493134 -0.000580235 -0.349933e-5 0.445404e-7\nEND\nGO\n");
    assert_near(prescription.surfaces[1].medium.c[0], 1.5597436, 1e-6); /* computed apart from this code */
    assert_near(prescription.surfaces[1].medium.c[1], 42.4352, 1e-3);
    assert_int_equal(import_text("RDM;LEN\nFNO 5\nSO 0 1e14\nS 50 5 'XYZ'; STO\nS 0.0 9.6\nSI 0 0\nPRV\nPWL 550\n'XYZ' SEL 1 2 3\nEND\nGO\n"), LFLARE_ERROR_LENS);
    /* zoom positions, in every way they are written */
    static const char solved[] = "RDM;LEN\nFNO 5\nSO 0 1e10\nS 50 5 500.600\nSTO\nS 0 10\nS -100 1 500.600\nS 0 80\nPIM\nSI 0 0\nZOO 2\nZOO THI S2 10 15\nZOO GLA S1 BK7 F2\nZOO YAN F1 0 0\nGO\n";
    static const char zoom[] = "RDM;LEN\nFNO 5\nSO 0 1e10\nS 50 5 500.600\nSTO\nS 0 10\nS -100 1 500.600\nS 0 80\nSI 0 0\nZOO 3\nZOO TIT\nTIT Z1 \"a\"\nZOO THI S2 10 15 20\nZOO THI S4\nTHI S4 Z1 80; THI S4 Z2 81; THI S4 Z3 82\nZOO FNO 5 6 7\nZOO THC S2 100 100 100\nGO\n";
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 0), LFLARE_OK);
    assert_near(prescription.surfaces[2].thickness, 10, 0);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 3), LFLARE_OK);
    assert_int_equal(report.config_count, 3);
    assert_near(prescription.surfaces[2].thickness, 20, 0);
    assert_near(report.stated_bfd, 82, 0);
    assert_near(prescription.fnumber, 7, 0);
    assert_null(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY));
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 4), LFLARE_ERROR_ARGUMENT);
    /* the last gap solved for the image: that of the first position; what is zoomed and not followed is said */
    assert_int_equal(import_config(solved, sizeof solved - 1, 1), LFLARE_OK);
    assert_near(report.stated_bfd, 80, 0);
    assert_null(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY));
    assert_int_equal(import_config(solved, sizeof solved - 1, 2), LFLARE_OK);
    assert_int_equal(prescription.focus, 1);
    assert_string_equal(find_note(LENSIMPORT_NOTE_CONFIG_PARTLY)->label, "GLA");
    assert_int_equal(import_text("RDM;LEN\nS 50 5 BK7\n"), LFLARE_ERROR_SYNTAX);
    assert_int_equal(import_text("RDM;LEN\nEPD 20\nSO 0 1e10\nS 50 5 NOBODY_SCHOTT\nSTO\nS 0 96\nSI 0 0\n"), LFLARE_ERROR_LENS);
    assert_int_equal(error.line, 4);
    import_lens("RDM;LEN\nEPD 20\nSO 0 1e10\nS 50 5 500.600\nSTO\nREX 3\nS 0 96\nSI 0 0\n");
    assert_non_null(note = find_note(LENSIMPORT_NOTE_APERTURE_IGNORED));
    assert_int_equal(note->line, 6);
}

#define BENCH_TAIL "[lens data]\n1\t50\t5\t1.5\t24\t60\n2\tInfinity\td2\t\t24\n3AS\tAS\t1\t\t20\t\n4\t-100\t1\t1.5\t24\t60\tXYZ\tNobody\n5\t\tBf\t\t24\t\n6\tCG\t2\t1.51633\t40\t64.14\tS-BSL7\tOhara\n7\tCG\t0.5\t\t40\n"

static void test_bench(void **state)
{
    static const char zoom[] = "[descriptive data]\t\t\ntitle\ta lens\n\t\t\npatent\tUS\tUS20070236805\tEX 1\nlens name\tnot this\n[constants]\n[variable distances]\t\t\nFocal Length\t140\t170\t140\t\nF-Number\t5\t6\t5\nImage Height\t43.28\t43.28\t43.28\nd0\tInfinity\tInfinity\t500\n# d2\t9\t9\nd2\t10\t20\t11\nBf\t60\t61\t62\nAperture Diameter\t18\t19\t18\n"
                               "[Lens Data]\n" "1\t50\t5\t1.5\t24\t60\n\t\t\t\n" "2\tInfinity\td2\t\t24\n" "3AS\tAS\t1\t\t20\t\n" "# 4\t1\t1\n" "4\t-100\t1\t1.5\t24\t60\tXYZ\tNobody\n" "5\t\tBf\t\t24\t\n" "6\tCG\t2\t1.51633\t40\t64.14\tS-BSL7\tOhara\n" "7\tCG\t0.5\t\t40\n";
    (void)state;
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 0), LFLARE_OK);
    assert_int_equal(report.config_count, 3);
    assert_near(prescription.surfaces[1].thickness, 10, 0);
    assert_near(prescription.surfaces[2].semi_diameter, 9, 0);
    assert_near(report.stated_bfd, 0.5, 0);
    assert_near(prescription.sensor_width, 36, 1e-3);
    assert_near(prescription.sensor_height, 24, 1e-3);
    assert_string_equal(prescription.name, "a lens");
    assert_string_equal(prescription.patent, "US20070236805");
    assert_string_equal(prescription.surfaces[3].medium.glass, "XYZ");
    assert_int_equal(prescription.surfaces[5].medium.kind, LFLARE_MEDIUM_SELLMEIER);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 2), LFLARE_OK);
    assert_near(prescription.surfaces[1].thickness, 20, 0);
    assert_near(prescription.surfaces[2].semi_diameter, 9.5, 0);
    assert_near(prescription.fnumber, 6, 0);
    assert_near(report.stated_efl, 170, 0);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 3), LFLARE_OK);
    assert_near(find_note(LENSIMPORT_NOTE_OBJECT_FINITE)->value, 500, 0);
    assert_int_equal(import_config(zoom, sizeof zoom - 1, 4), LFLARE_ERROR_ARGUMENT);
    /* the first state at infinity, not the first; a distance that is not defined; the stop of another state unknown */
    import_lens("[variable distances]\nd0\t500\tInfinity\nF-Number\t5\t5\nBf\t60\t61\n" BENCH_TAIL);
    assert_int_equal(report.config, 2);
    assert_string_equal(find_note(LENSIMPORT_NOTE_GAP_MISSING)->label, "d2");
    assert_near(prescription.surfaces[1].thickness, 0, 0);
    assert_near(prescription.surfaces[2].semi_diameter, 0, 0);
    /* odd powers between: A3, A4, A6 */
    import_lens("[constants]\nAsphericalOddCount\t1\n[variable distances]\nF-Number\t5\nBf\t60\nd2\tundefined\n" BENCH_TAIL "[aspherical data]\n1\t50.2\t-1\t1e-7\t2e-6\t3e-9\n9\t1\t0\t1\n[patent info]\nnumber\tUS7\n");
    assert_string_equal(prescription.patent, "US7");
    assert_string_equal(find_note(LENSIMPORT_NOTE_ASPHERE_LOST)->label, "9");
    assert_near(prescription.surfaces[0].aspheric[1], 2e-6, 0);
    assert_near(prescription.surfaces[0].aspheric[2], 3e-9, 0);
    assert_near(prescription.surfaces[0].conic, -1, 0);
    assert_near(find_note(LENSIMPORT_NOTE_ASPHERE_CUT)->value, 3, 0);
    assert_near(find_note(LENSIMPORT_NOTE_RADIUS_DIFFERS)->stated, 50.2, 0);
}

static void test_tables(void **state)
{
    (void)state;
    /* pbrt: planes that are no stop, the index 0 for air; a fifth column with Vd */
    import_lens("50 5 1.5 24\n0 3 1 24\n0 2 0 20\n0 3 1.5 24\n-100 80 0 24 \n");
    assert_int_equal(lens.stop, 2);
    assert_int_equal(lens.surface_count, 5);
    import_lens("50 5 1.5 24 60\n0 3 1 24\n0 2 1 20\n100 3 1.5 24 60\n-100 0 1 24 # end\n");
    assert_int_equal(lens.stop, 2); /* a plane in air; the rear of the first lens is none */
    assert_int_equal(prescription.surfaces[0].medium.kind, LFLARE_MEDIUM_ABBE);
    import_lens("radius thickness eta aperture\n50 5 1.5 24\n0 2 0 20\n0 90 1 24\n");
    assert_int_equal(lens.surface_count, 3);
    assert_int_equal(import_text("50 5 1.5 24\n0 3 1\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "four numbers were expected, radius, gap, index and diameter");
    assert_int_equal(error.line, 2);
    /* FlareSim: no f-number: diameters are taken for granted; a placeholder at the stop; glass without Vd; no stop */
    import_lens("name: x\nfocal_length: 90\nsurfaces:\n50 5 1.5 0 24 1\nstop 3 1 0 1000000 0\n0 96 1 0 24 0 sph\n");
    assert_near(prescription.surfaces[0].semi_diameter, 12, 0);
    assert_non_null(find_note(LENSIMPORT_NOTE_SEMI_IGNORED));
    assert_non_null(find_note(LENSIMPORT_NOTE_DISPERSION_MISSING));
    assert_non_null(find_note(LENSIMPORT_NOTE_EFL_DIFFERS));
    assert_int_equal(import_text("focal_length: 90\nsurfaces:\n50 5 1.5\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "the Abbe number is missing here");
    assert_int_equal(import_text("focal_length: 90\nsurfaces:\nabc 5 1.5\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "a radius or 'stop' was expected, not 'abc'");
}

static void test_markup(void **state)
{
    (void)state;
    /* a working stop is not the full opening; a coating of its own index */
    import_lens("<opticalSystem><fnumber>22</fnumber><elements><element><type>lensSpherical</type><radius>50</radius><thickness>5</thickness><height>12</height><refractiveIndex>1.5</refractiveIndex><abbeNumber>60</abbeNumber><coatingLambda>552</coatingLambda><coatingIor>1.38</coatingIor></element>"
                "<element><type>apertureStop</type><radius>0</radius><thickness>1</thickness><height>10</height></element><element><type>lensSpherical</type><radius>0</radius><thickness>90</thickness><height>12</height><refractiveIndex>1</refractiveIndex></element></elements></opticalSystem>");
    assert_non_null(find_note(LENSIMPORT_NOTE_FNUMBER_IGNORED));
    assert_near(prescription.layers[0].thickness_nm, 100, 1e-12);
    assert_near(prescription.layers[0].n, 1.38, 0);
    assert_true(lens.fnumber < 6);
    assert_int_equal(import_text("<?xml version=\"1.0\"?>\n<ghostList></ghostList>"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "the root <opticalSystem> was expected, not <ghostList>");
    assert_int_equal(error.line, 2);
    assert_int_equal(import_text("<\xc3\xa9t\xe9>"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "the root <opticalSystem> was expected, not <\?\?t\?\?>");
    assert_int_equal(import_text("<!DOCTYPE x [<!ENTITY a \"b\">]><opticalSystem></opticalSystem>"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "document types and entities are not read");
    assert_int_equal(import_text("<opticalSystem><elements><element><radius>x</radius></element></elements></opticalSystem>"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "a number was expected for radius, not 'x'");
    assert_int_equal(import_text("<opticalSystem><elements>"), LFLARE_ERROR_SYNTAX);
    /* json: the stop by its index or as the first plane in air; nulls; unknown members of any shape; LensSim's names */
    import_lens("{\"x\": [1, {\"radius\": 3}, [\"}\"]], \"fstop\": 5, \"focal_length\": null, \"lens_elements\": [{\"radius\": 50, \"distance\": 5, \"refractive_index\": 1.5, \"abbe_nr\": 60, \"height\": 12},"
                "{\"radius\": 0, \"distance\": 3, \"refractive_index\": 1.0, \"height\": 12}, {\"radius\": 0.0, \"distance\": 94, \"refractive_index\": 1.0, \"height\": 0, \"is_stop\": false}]}");
    assert_near(lens.efl, 100, 1e-9);
    assert_int_equal(lens.stop, 2);
    import_lens("{\"lens0\": {\"index\": 0, \"curvature_radius\": 50, \"thickness\": 5, \"nd\": 1.5, \"aperture_diameter\": 24, \"is_stop\": false}, \"lens1\": {\"index\": 1, \"curvature_radius\": 0, \"thickness\": 2, \"nd\": 1.0, \"aperture_diameter\": 24, \"is_stop\": false},"
                "\"lens2\": {\"index\": 2, \"curvature_radius\": 0.0, \"thickness\": 0, \"nd\": 0.0, \"aperture_diameter\": 20, \"is_stop\": true}}");
    assert_near(lens.efl, 100, 1e-9);
    assert_int_equal(lens.stop, 2);
    assert_near(prescription.surfaces[2].semi_diameter, 10, 0);
    /* members in the order of their names, as some write them: lens10 before lens2 */
    import_lens("{\"lens10\": {\"curvature_radius\": 0, \"thickness\": 0, \"nd\": 0, \"aperture_diameter\": 20, \"is_stop\": true}, \"lens2\": {\"curvature_radius\": 0, \"thickness\": 2, \"nd\": 1.0, \"aperture_diameter\": 24},"
                "\"lens1\": {\"curvature_radius\": 50, \"thickness\": 5, \"nd\": 1.5, \"aperture_diameter\": 24}}");
    assert_near(lens.efl, 100, 1e-9);
    assert_near(prescription.surfaces[0].radius, 50, 0);
    assert_int_equal(lens.stop, 2);
    assert_int_equal(import_text("{\"lens_elements\": [{\"radius\": \"abc\"}]}"), LFLARE_ERROR_SYNTAX);
    assert_int_equal(import_text("{\"lens_elements\": [{\"radius\": 1"), LFLARE_ERROR_SYNTAX);
    assert_int_equal(import_text("{\"name\": \"abc"), LFLARE_ERROR_SYNTAX);
    assert_int_equal(import_text("{}"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "there are no surfaces");
}

/* The sensor moved to the focus on request; numbers that the whole lens decides. */
static void test_options(void **state)
{
    static const char text[] = ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT ZMX_REAR ZMX_IMAGE;
    static const char own[] = "lensflare 1\nfnumber 4\nstop 1\n50 3 n 1.5\n-50 40\n";
    lensimport_desc desc;
    (void)state;
    memset(&desc, 0, sizeof desc);
    desc.focus = 1;
    assert_int_equal(lensimport_read(text, sizeof text - 1, &desc, &prescription, &report, &error), LFLARE_OK);
    assert_int_equal(prescription.focus, 1);
    assert_int_equal(lensimport_read(own, sizeof own - 1, &desc, &prescription, &report, &error), LFLARE_OK);
    assert_int_equal(prescription.focus, 1);
    assert_int_equal(report.format, LENSIMPORT_LENSFLARE);
    assert_true(report.efl > 49 && report.efl < 52);
    assert_near(report.stated_bfd, 40, 0);
    desc.config = 2;
    assert_int_equal(lensimport_read(own, sizeof own - 1, &desc, &prescription, &report, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensimport_read(text, sizeof text - 1, NULL, NULL, &report, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensimport_read(NULL, 3, NULL, &prescription, &report, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensimport_read(NULL, 0, NULL, &prescription, NULL, NULL), LFLARE_ERROR_SYNTAX);
    assert_int_equal(lensimport_read("x", 1, NULL, &prescription, NULL, &error), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "no format of prescriptions known here");
    assert_int_equal(import_text("efl  49.99\nspots 1 2 3 4 5\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "no format of prescriptions known here");
    assert_int_equal(lensimport_sniff(text, sizeof text - 1), LENSIMPORT_ZEMAX);
    assert_int_equal(lensimport_sniff(NULL, 0), LENSIMPORT_UNKNOWN);
    memset(&desc, 0, sizeof desc);
    desc.catalogues = "OHARA";
    assert_int_equal(lensimport_read(own, sizeof own - 1, &desc, &prescription, NULL, NULL), LFLARE_OK);
}

/* ---- what is refused ---- */

#define ZMX_BEFORE ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT "SURF 3\n"
#define ZMX_AFTER "  DISZ 96\nSURF 4\n  DISZ 0\n"
#define SEQ_BEFORE "RDM;LEN\nEPD 20\nSO 0 1e10\nS 50 5 500.600\nSTO\n"
#define SEQ_AFTER "\nS 0 96\nSI 0 0\n"

static const struct {
    const char *text, *message;
    lensimport_refusal refusal;
    int32_t line;
} refused[] = {
    {ZMX_BEFORE "  GLAS MIRROR 0 0 1.5 40\n  DISZ -96\nSURF 4\n  DISZ 0\n", "refused: a mirror (MIRROR)", LENSIMPORT_REFUSED_MIRROR, 23},
    {ZMX_BEFORE "  TYPE COORDBRK\n  PARM 1 0\n  PARM 3 1.6E+1\n" ZMX_AFTER, "refused: tilted or decentred (COORDBRK)", LENSIMPORT_REFUSED_TILT, 25},
    {ZMX_BEFORE "  TYPE TILTSURF\n" ZMX_AFTER, "refused: tilted or decentred (TILTSURF)", LENSIMPORT_REFUSED_TILT, 23},
    {ZMX_BEFORE "  SCBD 1 0 0 0.0 0.0 9.0E+01\n" ZMX_AFTER, "refused: tilted or decentred (SCBD)", LENSIMPORT_REFUSED_TILT, 23},
    {ZMX_BEFORE "  TYPE DGRATING\n" ZMX_AFTER, "refused: a grating or another diffractive surface (DGRATING)", LENSIMPORT_REFUSED_GRATING, 23},
    {ZMX_BEFORE "  TYPE BINARY_2\n" ZMX_AFTER, "refused: a grating or another diffractive surface (BINARY_2)", LENSIMPORT_REFUSED_GRATING, 23},
    {ZMX_BEFORE "  TYPE TOROGRAT\n" ZMX_AFTER, "refused: a grating or another diffractive surface (TOROGRAT)", LENSIMPORT_REFUSED_GRATING, 23},
    {ZMX_BEFORE "  TYPE TOROIDAL\n" ZMX_AFTER, "refused: curved differently in two directions (TOROIDAL)", LENSIMPORT_REFUSED_TOROID, 23},
    {ZMX_BEFORE "  TYPE BICONICX\n" ZMX_AFTER, "refused: curved differently in two directions (BICONICX)", LENSIMPORT_REFUSED_TOROID, 23},
    {ZMX_BEFORE "  TYPE GRINSUR9\n" ZMX_AFTER, "refused: an index that varies within the glass (GRINSUR9)", LENSIMPORT_REFUSED_GRADIENT, 23},
    {ZMX_BEFORE "  TYPE PARAXIAL\n" ZMX_AFTER, "refused: an ideal lens without glass (PARAXIAL)", LENSIMPORT_REFUSED_IDEAL, 23},
    {ZMX_BEFORE "  TYPE USERSURF us.dll\n" ZMX_AFTER, "refused: a surface of a type not known to be rotationally symmetric and refracting (USERSURF)", LENSIMPORT_REFUSED_SURFACE, 23},
    {ZMX_BEFORE "  TYPE ODDASPHE\n  PARM 1 0.1\n" ZMX_AFTER, "refused: a surface of a type not known to be rotationally symmetric and refracting (a cone: r^1)", LENSIMPORT_REFUSED_SURFACE, 24},
    {"VERS 1\nMODE NSC\n" ZMX_OBJECT ZMX_STOP ZMX_FRONT ZMX_REAR ZMX_IMAGE, "refused: not sequential (NSC)", LENSIMPORT_REFUSED_SEQUENCE, 2},
    /* of several reasons the most telling: a mirror first, an ideal lens late */
    {ZMX_BEFORE "  TYPE PARAXIAL\n  DISZ 1\nSURF 4\n  TYPE COORDBRK\n  PARM 4 1\nSURF 5\n  GLAS MIRROR 0\n  DISZ -3\nSURF 6\n", "refused: a mirror (MIRROR)", LENSIMPORT_REFUSED_MIRROR, 29},
    /* and any of them before a glass nobody knows */
    {ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ 5\n  GLAS NOBODY 0 0 1.5 40\nSURF 3\n  GLAS MIRROR 0 0 1.5 40\n  DISZ -96\nSURF 4\n  DISZ 0\n", "refused: a mirror (MIRROR)", LENSIMPORT_REFUSED_MIRROR, 21},
    {ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV 0.02\n  DISZ -5\n  GLAS ___BLANK 1 0 1.5 60\n" ZMX_REAR ZMX_IMAGE, "refused: a negative gap: light would go backwards, as behind a mirror", LENSIMPORT_REFUSED_BACKWARDS, 16},
    {SEQ_BEFORE "S 0 -96 REFL\nSI 0 0\n", "refused: a mirror (REFL)", LENSIMPORT_REFUSED_MIRROR, 6},
    {SEQ_BEFORE "REFL" SEQ_AFTER, "refused: a mirror (REFL)", LENSIMPORT_REFUSED_MIRROR, 6},
    {SEQ_BEFORE "XDE 0.0; ADE 3.0" SEQ_AFTER, "refused: tilted or decentred (ADE)", LENSIMPORT_REFUSED_TILT, 6},
    {SEQ_BEFORE "DIF DOE" SEQ_AFTER, "refused: a grating or another diffractive surface (DIF)", LENSIMPORT_REFUSED_GRATING, 6},
    {SEQ_BEFORE "CYL; RDX 5" SEQ_AFTER, "refused: curved differently in two directions (CYL)", LENSIMPORT_REFUSED_TOROID, 6},
    {SEQ_BEFORE "SPS QBF" SEQ_AFTER, "refused: a surface of a type not known to be rotationally symmetric and refracting (QBF)", LENSIMPORT_REFUSED_SURFACE, 6},
    {"focal_length: 1\nsurfaces:\n50 5 1.5 60 10 1 cyl_x\n0 90 1 0 10 0\n", "refused: curved differently in two directions (cyl_x)", LENSIMPORT_REFUSED_TOROID, 3},
    {"focal_length: 1\nsurfaces:\n50 5 1.5 60 10 1\n0 -3 1 0 10 0\n50 5 1.5 60 10 1\n0 90 1 0 10 0\n", "refused: a negative gap: light would go backwards, as behind a mirror", LENSIMPORT_REFUSED_BACKWARDS, 4},
    {"<opticalSystem><elements><element><type>lensAnamorphic</type><radius>50</radius></element></elements></opticalSystem>", "refused: curved differently in two directions (lensAnamorphic)", LENSIMPORT_REFUSED_TOROID, 1},
    {"SURFACE DATA SUMMARY:\nSurf\tType\tRadius\tThickness\tGlass\tDiameter\tConic\tComment\nOBJ\tSTANDARD\tInfinity\tInfinity\t\t0\t0\t\n1\tSTANDARD\t50\t5\tMIRROR\t10\t0\t\nIMA\tSTANDARD\t50\t5\t\t10\t0\t\n", "refused: a mirror (MIRROR)", LENSIMPORT_REFUSED_MIRROR, 4},
    {"SURFACE DATA SUMMARY:\nSurf\tType\tRadius\tThickness\tGlass\tDiameter\tConic\tComment\nOBJ\tSTANDARD\tInfinity\tInfinity\t\t0\t0\t\n1\tCOORDBRK\t-\t5\t\t-\t-\t\nIMA\tSTANDARD\t50\t5\t\t10\t0\t\n", "refused: tilted or decentred (COORDBRK)", LENSIMPORT_REFUSED_TILT, 4},
};

static void test_refused(void **state)
{
    size_t i;
    (void)state;
    for (i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        if (import_text(refused[i].text) != LFLARE_ERROR_LENS) fail_msg("%d, '%s': not refused but %d: %s", (int)i, refused[i].message, (int)error.code, error.text);
        if (strcmp(error.text, refused[i].message) != 0) fail_msg("'%s', not '%s'", error.text, refused[i].message);
        if (report.refusal != refused[i].refusal || error.line != refused[i].line) fail_msg("'%s': refusal %d, line %d", error.text, (int)report.refusal, (int)error.line);
    }
}

/* Every note has a sentence of its own. */
static void test_sentences(void **state)
{
    char text[200], before[200] = "";
    lensimport_note note;
    int kind;
    (void)state;
    memset(&note, 0, sizeof note);
    memcpy(note.label, "X", 2);
    note.value = 2.5;
    note.stated = 1e-7;
    for (kind = 1; kind <= LENSIMPORT_NOTE_SENSOR_DERIVED; kind++) {
        note.kind = (lensimport_note_kind)kind;
        note.line = 0;
        lensimport_note_text(&note, text, sizeof text);
        assert_string_not_equal(text, "unknown note");
        assert_string_not_equal(text, before);
        memcpy(before, text, sizeof text);
        note.line = 12;
        lensimport_note_text(&note, text, sizeof text);
        assert_memory_equal(text, "line 12: ", 9);
        assert_string_equal(text + 9, before);
        lensimport_note_text(&note, text, 5);
        assert_string_equal(text, "line");
        lensimport_note_text(&note, text, 0);
    }
    for (kind = 0; kind <= LENSIMPORT_FLARESIM; kind++) assert_true(strcmp(lensimport_format_name((lensimport_format)kind), "unknown") != 0 || kind == 0);
}


/* ---- any bytes ---- */

/* An answer, and a whole one: an error has a sentence, a prescription can be derived or says why not, and can be written. */
static void check_any(const char *bytes, size_t size, int32_t config)
{
    static lflare_prescription before;
    char *exact = (char *)malloc(size > 0 ? size : 1); /* a byte too far is seen by sanitisers */
    lflare_result result;
    int32_t i;
    assert_non_null(exact);
    memcpy(exact, bytes, size);
    result = import_config(exact, size, config);
    free(exact);
    if (result < 0) {
        assert_int_equal(error.code, result);
        assert_true(error.text[0] != 0);
        for (i = 0; error.text[i] != 0; i++) assert_true(error.text[i] >= 32 && error.text[i] < 127);
        return;
    }
    assert_int_equal(result, LFLARE_OK);
    assert_true(report.format != LENSIMPORT_UNKNOWN && report.config >= 1 && report.config <= report.config_count);
    if (memcmp(&prescription, &before, sizeof before) == 0) return; /* of the last cut, too */
    before = prescription;
    if (lflare_lens_derive(&prescription, &lens, &error) >= 0) {
        page.size = sizeof page.text;
        assert_int_equal(lflare_text_write(&prescription, page.text, &page.size), LFLARE_OK);
        assert_int_equal(lflare_text_read(page.text, page.size, &prescription, &error), LFLARE_OK);
        assert_near(lens.efl, report.efl, 1e-9 * fabs(report.efl));
    } else {
        assert_true(error.text[0] != 0);
    }
}

/* Every byte counts, but for sanitisers, which are slow: every 17th of large files, so at both bytes of UTF-16. */
#if defined(__SANITIZE_ADDRESS__)
enum { CUT_STEP = 17 };
#else
enum { CUT_STEP = 1 };
#endif

/* Milliseconds to read so much of a text, the best of several. */
static double time_to_read(const char *text, size_t size)
{
    double best = 1e9;
    int round, k;
    for (round = 0; round < 5; round++) {
        clock_t began = clock();
        for (k = 0; k < 10; k++) lensimport_read(text, size, NULL, &prescription, &report, &error);
        if (best > (double)(clock() - began)) best = (double)(clock() - began);
    }
    return best / CLOCKS_PER_SEC * 1e3 / 10;
}

/* Every format, and the samples where they are, cut at every byte; how long parts of them take. */
static void test_cut(void **state)
{
    static lflare_lens own;
    static char whole[400000];
    size_t n, size;
    int which, i;
    (void)state;
    read_own("heliar-tronnier", &own);
    print_message("#                                       bytes   ms: a quarter    half   three quarters  whole\n");
    for (which = 0; which < WRITTEN; which++) {
        write_as(&own, which);
        memcpy(whole, other.text, size = other.size);
        print_message("# %-34s %9d %14.3f %10.3f %10.3f %10.3f\n", written_names[which], (int)size, time_to_read(whole, size / 4), time_to_read(whole, size / 2), time_to_read(whole, size * 3 / 4), time_to_read(whole, size));
        for (n = 0; n < size; n++) check_any(whole, n, 0);
    }
    for (i = 0; i < SAMPLES; i++) {
        char *text;
        if (i > 0 && strcmp(samples[i].name, samples[i - 1].name) == 0) continue; /* another zoom state of it */
        text = read_sample(samples[i].name, &size);
        if (text == NULL) break;
        print_message("# %-34s %9d %14.3f %10.3f %10.3f %10.3f\n", samples[i].name, (int)size, time_to_read(text, size / 4), time_to_read(text, size / 2), time_to_read(text, size * 3 / 4), time_to_read(text, size));
        for (n = 0; n < size; n += size > 20000 ? CUT_STEP : 1) check_any(text, n, i % 3);
        free(text);
    }
}

static uint64_t chance_state = 1;
static uint32_t chance(uint32_t below)
{
    chance_state = chance_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(chance_state >> 33) % below;
}

/* Bytes changed, removed, doubled; whole words exchanged for others of the same file. */
static void test_mutated(void **state)
{
    static lflare_lens own;
    static char text[400000];
    int which, round, k;
    (void)state;
    for (round = 0; round < 40; round++) {
        read_own(lenses[round % LENSES], &own);
        for (which = 0; which < WRITTEN; which++) {
            size_t size;
            write_as(&own, which);
            size = other.size;
            memcpy(text, other.text, size);
            for (k = 1 + (int)chance(8); k > 0; k--) {
                size_t at = chance((uint32_t)size), from = chance((uint32_t)size), n = 1 + chance(12);
                if (at + n > size || from + n > size) continue;
                switch (chance(4)) {
                case 0: text[at] = (char)chance(256); break;
                case 1: memmove(text + at, text + at + n, size - at - n); size -= n; break;
                case 2: memmove(text + at, text + from, n); break;
                default: text[at] = "\n\t 0-.<>\"{}[];&!'#,:e\0"[chance(22)]; break;
                }
            }
            check_any(text, size, round % 4);
        }
    }
    for (round = 0; round < 2000; round++) { /* noise behind each format's first words */
        static const char *const heads[] = {"VERS 1\nSURF 0\n", "SURFACE DATA SUMMARY:\nSurf Type Radius Thickness Glass Diameter Conic\n", "RDM\nSO 0 1e10\n", "[lens data]\n", "1 2 3 4\n", "<opticalSystem>", "{\"lens_elements\":[", "surfaces:\n"};
        size_t size = (size_t)sprintf(text, "%s", heads[round % 8]), n = chance(300);
        for (; n > 0; n--) text[size++] = chance(3) ? (char)(32 + chance(96)) : "\n\t 0123456789.-"[chance(15)];
        check_any(text, size, 0);
    }
}

/* Too many rows, words and numbers out of range: said, not swallowed. */
static void test_limits(void **state)
{
    int i;
    (void)state;
    page.size = 0;
    put(&page, ZMX_HEAD ZMX_OBJECT);
    for (i = 1; i < 300; i++) put(&page, "SURF %d\n  DISZ 1\n", i);
    assert_int_equal(import_text(page.text), LFLARE_ERROR_LENS);
    assert_string_equal(error.text, "more than 125 surfaces");
    page.size = 0; /* 120 rows are read */
    put(&page, "focal_length: 1\nsurfaces:\nstop 1 1 0 1 0\n");
    for (i = 1; i < 60; i++) put(&page, "1000 1 1.5 60 20 0\n0 0.1 1 0 20 0\n");
    import_lens(page.text);
    assert_int_equal(lens.surface_count, 119);
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT "SURF 2\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "surfaces are numbered from 0 in order, not '2'");
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT "SURF 1\n  CURV abc\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "a number was expected, not 'abc'");
    assert_int_equal(error.line, 11);
    assert_int_equal(error.column, 8);
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT "SURF 1\n  CURV nan\n"), LFLARE_ERROR_SYNTAX);
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT "SURF 1\n  CURV\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "a number is missing here");
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV .02\n  DISZ INFINITY\n  GLAS ___BLANK 1 0 1.5 60\nSURF 3\n  DISZ 3\nSURF 4\n"), LFLARE_ERROR_LENS);
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  CURV .02\n  DISZ 3\n  GLAS ___BLANK 1 0 0.5 60\nSURF 3\n  DISZ 3\nSURF 4\n"), LFLARE_ERROR_LENS);
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT ZMX_STOP "SURF 2\n  DISZ 3\n"), LFLARE_ERROR_LENS);
    assert_string_equal(error.text, "there is no surface that refracts");
    assert_int_equal(import_text(ZMX_HEAD ZMX_OBJECT ZMX_STOP ZMX_FRONT "SURF 3\n  STOP\n  DISZ 9\nSURF 4\n"), LFLARE_ERROR_LENS);
    assert_string_equal(error.text, "a second stop (the first is on line 10)");
    assert_int_equal(import_text("RDM;LEN\nSO 0 1e10\nS 50 5 500.600\nPRV\n'A' 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n"), LFLARE_ERROR_SYNTAX);
    assert_string_equal(error.text, "more than 32 wavelengths");
}

/* Linear time: four times the bytes take about four times as long, whatever is repeated. */
static void test_time(void **state)
{
    static const struct {
        const char *head, *repeated;
    } texts[] = {
        {"", "x y z\n"}, {"", "                                                                    "}, {"", "\n"}, {"", "\"a b"}, {"VERS 1\n", "XFLN 1 2 3 4 5 6 7 8 9 10 11 12\n"},
        {ZMX_HEAD ZMX_OBJECT "SURF 1\n", "  PARM 2 1e-9\n"}, {ZMX_HEAD ZMX_OBJECT "SURF 1\n", "  GLAS NOBODYS 1 0 1.5 60\n"}, {ZMX_HEAD ZMX_OBJECT "SURF 1\n", "  GLAS MC-A_B_C-1_D_E_F_G_H_I_J_K_L_M_N_O_P_1HT 1 0 1.5 60\n"}, {ZMX_HEAD ZMX_OBJECT ZMX_STOP "MNUM 3 1\n", "THIC 1 2 3.5\n"},
        {"SURFACE DATA SUMMARY:\n", "Surf Type Radius\n"}, {"SURFACE DATA SUMMARY:\nSurf Type Radius\n OBJ STANDARD 1\nx\nINDEX OF REFRACTION DATA:\n", " Surf 1 2 3\n 0 1 2 3\n"},
        {"SURFACE DATA SUMMARY:\nSurf Type Radius\n OBJ STANDARD 1\nx\nMULTI-CONFIGURATION DATA:\n", "Configuration 2:\n 1 Glass 0 : 3\n"}, {ZMX_HEAD ZMX_OBJECT "SURF 1\n", "  PZUP 0 1 0\n"}, {"{\"", "lens1\":{},\""},
        {"RDM;LEN\nSO 0 1\n", "K 1;"}, {"RDM;LEN\nSO 0 1\n", "GLA S0 NOBODY\n"}, {"RDM;LEN\nSO 0 1\nTHI ", "&\n"}, {"RDM;LEN\nSO 0 1\n", "ZOO "}, {"RDM;LEN\nSO 0 1\n", "'"}, {"RDM;LEN\nSO 0 1\nYAN", " 1"},
        {"[variable distances]\n", "d1\t1\t2\t3\n"}, {"[lens data]\n1\t1\t1\n[aspherical data]\n", "1\t1\t0\t1e-9\n"}, {"[lens data]\n", "\t"}, {"1 2 3 4\n", "# comment\n"},
        {"<opticalSystem>", "<a>b</a>"}, {"<opticalSystem>", "<"}, {"<opticalSystem>", "<!--x"}, {"<opticalSystem a=\"", "<"}, {"{", "\"a\":{"}, {"{", "[1,"}, {"{\"", "\\\""}, {"surfaces:\n", "#\n"}};
    enum { BIG = 1000000 };
    char *text = (char *)malloc(BIG);
    size_t i, n;
    (void)state;
    assert_non_null(text);
    for (i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        double seconds[2] = {1e9, 1e9};
        int round, part;
        size_t head = strlen(texts[i].head), step = strlen(texts[i].repeated);
        memcpy(text, texts[i].head, head);
        for (n = head; n < BIG; n++) text[n] = texts[i].repeated[(n - head) % step];
        for (part = 0; part < 2; part++)
            for (round = 0; round < 3; round++) {
                clock_t began = clock();
                double spent;
                lensimport_read(text, part ? BIG : BIG / 4, NULL, &prescription, &report, &error);
                spent = (double)(clock() - began) / CLOCKS_PER_SEC;
                if (spent < seconds[part]) seconds[part] = spent;
            }
        print_message("# 1 MB of '%.12s...': %.1f ms, a quarter of it %.1f ms\n", texts[i].repeated[0] == '\n' ? "empty lines" : texts[i].repeated, 1e3 * seconds[1], 1e3 * seconds[0]);
        if (seconds[1] > 0.002 && seconds[1] > 8 * seconds[0]) fail_msg("'%s' is not linear: %g s, a quarter of it %g s", texts[i].repeated, seconds[1], seconds[0]);
        if (getenv("SPEED") != NULL) assert_true(seconds[1] < 0.05);
    }
    free(text);
}

/* Numbers have points, whatever the locale; odd addresses are as good as even ones. */
static void test_places(void **state)
{
    static lflare_lens own;
    static char odd[400001];
    int which;
    (void)state;
    if (setlocale(LC_ALL, "de_DE.UTF-8") == NULL) print_message("# no locale with a decimal comma here\n");
    read_own("heliar-tronnier", &own);
    for (which = 0; which < WRITTEN; which++) {
        setlocale(LC_ALL, "C");
        write_as(&own, which);
        setlocale(LC_ALL, "de_DE.UTF-8");
        memcpy(odd + 1, other.text, other.size);
        assert_int_equal(import_config(odd + 1, other.size, 0), LFLARE_OK);
        compare_lens(&own, which, "heliar-tronnier");
    }
    setlocale(LC_ALL, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_written), cmocka_unit_test(test_samples), cmocka_unit_test(test_sample_notes), cmocka_unit_test(test_glass_table), cmocka_unit_test(test_glass_list), cmocka_unit_test(test_glass_names),
                                       cmocka_unit_test(test_zmx), cmocka_unit_test(test_zmx_zoom), cmocka_unit_test(test_zmx_pickups), cmocka_unit_test(test_report_text), cmocka_unit_test(test_report_zoom), cmocka_unit_test(test_seq), cmocka_unit_test(test_bench), cmocka_unit_test(test_tables), cmocka_unit_test(test_markup),
                                       cmocka_unit_test(test_options), cmocka_unit_test(test_refused), cmocka_unit_test(test_sentences), cmocka_unit_test(test_cut), cmocka_unit_test(test_mutated), cmocka_unit_test(test_limits),
                                       cmocka_unit_test(test_time), cmocka_unit_test(test_places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
