/* Foreign formats: one lens written in all of them reads the same; each format's traps; what is refused, and why; the glass
   catalogue; inputs cut at every byte, mutated, large. Real files of other people are read where they lie, in ../shared.
   Run from the root of the repository. */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSIMPORT_IMPLEMENTATION
#include "lenses/lensimport.h"

#include <locale.h>
#include <setjmp.h>
#include <stdio.h>
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
                                     "nikkor-105-14", "nikon-80-200-mid", "petzval-kodak", "planar-50-14", "sonnar-20", "tessar-50-35", "topogon"};
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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_written)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
