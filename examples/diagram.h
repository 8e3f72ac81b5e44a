/* A lens's cross-section as SVG: its glasses with their true faces, the stop, the sensor, and exact rays of the image and of one
   ghost, in the plane of the axis and the light. flare.c includes it, after lensflare.h with its implementation and <stdio.h>. */
#ifndef DIAGRAM_H
#define DIAGRAM_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { DIAGRAM_WIDTH = 1000, DIAGRAM_DRAWN = 920, DIAGRAM_TALLEST = 480, DIAGRAM_TOP = 84, DIAGRAM_BOTTOM = 50, DIAGRAM_SPANS = 4 };

typedef struct diagram_desc {
    const lflare_lens *lens;
    const lflare_pair *ghost; /* NULL: none */
    double slope;             /* of the light in the drawn plane; negative comes from above */
    int rays;                 /* of each bundle */
} diagram_desc;

typedef struct diagram {
    const diagram_desc *d;
    FILE *file;
    double z[LFLARE_MAX_SURFACES], sensor; /* vertices and sensor, mm from the first vertex */
    double left, right, height;            /* what is drawn, mm: along the axis, and to both sides of it */
    double scale, x, y;                    /* pixels a mm; where z = 0 on the axis is */
} diagram;

/* Entrance heights whose rays pass every rim and the full opening, mm. */
typedef struct diagram_spans {
    int count, widest;
    double lo[DIAGRAM_SPANS], hi[DIAGRAM_SPANS];
} diagram_spans;

static double diagram_x(const diagram *g, double z) { return g->x + g->scale * z; }
static double diagram_y(const diagram *g, double y) { return g->y - g->scale * y; }

/* ---- text ---- */

/* Bytes of the UTF-8 character here, 0 if it is none that XML allows. */
static int diagram_character(const unsigned char *c)
{
    int n = c[0] < 0x80 ? 1 : c[0] >= 0xc2 && c[0] < 0xe0 ? 2 : c[0] >= 0xe0 && c[0] < 0xf0 ? 3 : c[0] >= 0xf0 && c[0] < 0xf5 ? 4 : 0, i;
    for (i = 1; i < n; i++)
        if ((c[i] & 0xc0) != 0x80) return 0;
    if (n == 1 && (c[0] < 0x20 || c[0] == 0x7f)) return 0;
    if ((c[0] == 0xe0 && c[1] < 0xa0) || (c[0] == 0xed && c[1] > 0x9f) || (c[0] == 0xef && c[1] >= 0xbf)) return 0;
    if ((c[0] == 0xf0 && c[1] < 0x90) || (c[0] == 0xf4 && c[1] > 0x8f)) return 0;
    return n;
}

static void diagram_text(FILE *file, const char *text)
{
    while (*text != 0) {
        int n = diagram_character((const unsigned char *)text);
        if (*text == '&') fputs("&amp;", file);
        else if (*text == '<') fputs("&lt;", file);
        else if (*text == '>') fputs("&gt;", file);
        else if (n > 0) fwrite(text, 1, (size_t)n, file);
        else fputc('?', file);
        text += n > 0 ? n : 1;
    }
}

/* ---- glass ---- */

static double diagram_edge(const diagram *g, int surface)
{
    const lflare_surface *s = &g->d->lens->prescription.surfaces[surface];
    return g->z[surface] + lflare_sag(s, s->semi_diameter);
}

static int diagram_is_sphere(const lflare_surface *s)
{
    int i;
    for (i = 0; i < 8; i++)
        if (s->aspheric[i] != 0) return 0;
    return s->conic == 0;
}

/* Continues a path from a surface's one rim to its other; down: from the top. Spheres are arcs, the rest 32 chords. */
static void diagram_face(const diagram *g, int surface, int down)
{
    const lflare_surface *s = &g->d->lens->prescription.surfaces[surface];
    double h = s->semi_diameter, way = down ? -1 : 1;
    int i, chords = s->radius == 0 ? 1 : 32;
    if (diagram_is_sphere(s) && s->radius != 0) {
        double r = g->scale * fabs(s->radius);
        fprintf(g->file, "A%.2f %.2f 0 0 %d %.2f %.2f", r, r, (s->radius > 0) != down, diagram_x(g, diagram_edge(g, surface)), diagram_y(g, way * h));
        return;
    }
    if (!diagram_is_sphere(s)) chords = 32;
    for (i = 1; i <= chords; i++) {
        double y = h * (2.0 * i / chords - 1);
        fprintf(g->file, "L%.2f %.2f", diagram_x(g, g->z[surface] + lflare_sag(s, fabs(y))), diagram_y(g, way * y));
    }
}

static int diagram_is_glass(const lflare_medium *m) { return m->kind != LFLARE_MEDIUM_AIR && fabs(lflare_index(m, 587.5618) - 1) > 1e-3; }

/* The surface behind, the stop passed over; -1 behind the last. */
static int diagram_next(const lflare_lens *lens, int surface)
{
    do surface++;
    while (surface == lens->stop);
    return surface < lens->surface_count ? surface : -1;
}

/* One glass: down its front face, along the lower edge, up its back face, along the upper one. The narrower face has a flat rim
   as ground on real elements, unless that would cut the other face. */
static void diagram_element(const diagram *g, int front, int back)
{
    const lflare_surface *s = g->d->lens->prescription.surfaces;
    double hf = s[front].semi_diameter, hb = s[back].semi_diameter, wide = fmax(hf, hb), zf = diagram_edge(g, front), zb = diagram_edge(g, back);
    int rim = zf < zb, side;
    fprintf(g->file, "<path class=\"glass\" d=\"M%.2f %.2f", diagram_x(g, zf), diagram_y(g, hf));
    diagram_face(g, front, 1);
    for (side = -1; side <= 1; side += 2) { /* below, then above */
        if (rim && hf != hb) fprintf(g->file, "L%.2f %.2f", diagram_x(g, side < 0 ? (hf < hb ? zf : zb) : (hb < hf ? zb : zf)), diagram_y(g, side * wide));
        if (side < 0) {
            fprintf(g->file, "L%.2f %.2f", diagram_x(g, zb), diagram_y(g, -hb));
            diagram_face(g, back, 0);
        }
    }
    fputs("Z\"/>\n", g->file);
}

static void diagram_glasses(const diagram *g)
{
    const lflare_lens *lens = g->d->lens;
    int i;
    for (i = 0; i < lens->surface_count; i++) {
        int next = diagram_next(lens, i);
        if (i != lens->stop && next >= 0 && diagram_is_glass(&lens->prescription.surfaces[i].medium)) diagram_element(g, i, next);
    }
}

/* ---- rays ---- */

static int diagram_stops_pass(const lflare_ray *ray, double semi)
{
    int i, pass = 1;
    for (i = 0; i < ray->stop_count; i++) pass &= fabs(ray->stops[i][1]) <= semi;
    return pass;
}

static int diagram_passes(const lflare_path *path, double height, double slope)
{
    const lflare_lens *lens = path->lens;
    double at[2], u[2];
    lflare_ray ray;
    at[0] = u[0] = 0;
    at[1] = height;
    u[1] = slope;
    return lflare_path_trace(path, at, u, &ray, NULL) == LFLARE_RAY_ARRIVES && ray.relative <= 1 &&
           diagram_stops_pass(&ray, lens->prescription.surfaces[lens->stop].semi_diameter);
}

/* Between a height that passes and one that does not. */
static double diagram_limit(const lflare_path *path, double slope, double inside, double outside)
{
    int i;
    for (i = 0; i < 40; i++) {
        double middle = 0.5 * (inside + outside);
        if (diagram_passes(path, middle, slope)) inside = middle;
        else outside = middle;
    }
    return inside;
}

static diagram_spans diagram_find(const lflare_path *path, double slope)
{
    enum { STEPS = 2000 };
    const lflare_surface *front = &path->lens->prescription.surfaces[0];
    double reach = front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter) * slope), last = -1.001 * reach;
    diagram_spans s;
    int i, before = 0;
    s.count = s.widest = 0;
    for (i = 0; i <= STEPS + 1; i++) {
        double at = 1.001 * reach * (2.0 * i / STEPS - 1);
        int now = i <= STEPS && diagram_passes(path, at, slope);
        if (now && !before && s.count < DIAGRAM_SPANS) s.lo[s.count] = i > 0 ? diagram_limit(path, slope, at, last) : at;
        if (!now && before && s.count < DIAGRAM_SPANS) s.hi[s.count++] = diagram_limit(path, slope, last, at);
        before = now;
        last = at;
    }
    for (i = 0; i < s.count; i++)
        if (s.hi[i] - s.lo[i] > s.hi[s.widest] - s.lo[s.widest]) s.widest = i;
    return s;
}

/* Where a coordinate is far outside the picture, browsers draw badly: kept near it, for lines that are clipped anyway. */
static double diagram_near(double pixels) { return fmin(fmax(pixels, -20000), 20000); }

static void diagram_ray(const diagram *g, const lflare_path *path, double height)
{
    static lflare_hit hits[LFLARE_MAX_STEPS];
    lflare_ray ray;
    double at[2], u[2];
    int i;
    at[0] = u[0] = 0;
    at[1] = height;
    u[1] = g->d->slope;
    if (lflare_path_trace(path, at, u, &ray, hits) != LFLARE_RAY_ARRIVES) return;
    fprintf(g->file, "<path d=\"M%.2f %.2f", diagram_x(g, g->left), diagram_near(diagram_y(g, height + g->left * g->d->slope)));
    for (i = 0; i < ray.steps; i++) {
        const double *p = hits[i].position;
        if (hits[i].surface != g->d->lens->stop) fprintf(g->file, "L%.2f %.2f", diagram_x(g, p[2]), diagram_near(diagram_y(g, p[1])));
    }
    fprintf(g->file, "L%.2f %.2f\"/>\n", diagram_x(g, g->sensor), diagram_near(diagram_y(g, ray.sensor[1])));
}

/* Rays evenly over the widest span of entrance heights that pass. */
static diagram_spans diagram_bundle(const diagram *g, const lflare_pair *pair, const char *name)
{
    static lflare_path path;
    diagram_spans s;
    int i, n = g->d->rays;
    lflare_path_make(g->d->lens, 587.5618, pair, &path);
    path.unweighted = 1;
    s = diagram_find(&path, g->d->slope);
    if (s.count == 0) return s;
    fprintf(g->file, "<g class=\"%s\" clip-path=\"url(#frame)\">\n", name);
    for (i = 0; i < n; i++) {
        double t = n == 1 ? 0.5 : 0.002 + 0.996 * i / (n - 1); /* not on the very rim */
        diagram_ray(g, &path, s.lo[s.widest] + t * (s.hi[s.widest] - s.lo[s.widest]));
    }
    fputs("</g>\n", g->file);
    return s;
}

/* ---- the rest ---- */

static void diagram_line(const diagram *g, const char *name, double z0, double y0, double z1, double y1)
{
    fprintf(g->file, "<path class=\"%s\" d=\"M%.2f %.2fL%.2f %.2f\"/>\n", name, diagram_x(g, z0), diagram_y(g, y0), diagram_x(g, z1), diagram_y(g, y1));
}

/* A reflecting surface, drawn over, with its number below on the given side, so that neighbours do not write over each other. */
static void diagram_mirror(const diagram *g, int surface, int right)
{
    double h = g->d->lens->prescription.surfaces[surface].semi_diameter, z = diagram_edge(g, surface);
    fprintf(g->file, "<path class=\"mirror\" d=\"M%.2f %.2f", diagram_x(g, z), diagram_y(g, h));
    diagram_face(g, surface, 1);
    fprintf(g->file, "\"/>\n<text class=\"mirrored%s\" x=\"%.2f\" y=\"%.2f\">%d</text>\n", right ? "" : " right", diagram_x(g, z) + (right ? 2 : -2),
            diagram_y(g, -g->height) + 14, surface + 1);
}

/* Vertices and what they reach, then the scale that lets it all fit. */
static void diagram_layout(diagram *g)
{
    const lflare_lens *lens = g->d->lens;
    const lflare_surface *s = lens->prescription.surfaces;
    double first = 0, z = 0, sensor_half = 0.5 * lens->sensor_height;
    int i;
    g->height = sensor_half;
    for (i = 0; i < lens->surface_count; i++) {
        g->z[i] = z;
        z += s[i].thickness;
        g->height = fmax(g->height, s[i].semi_diameter * (i == lens->stop ? 1.35 : 1.04));
        if (i != lens->stop) first = fmin(first, diagram_edge(g, i));
    }
    g->sensor = z;
    g->left = first - 0.12 * (z - first);
    g->right = z + 0.015 * (z - g->left);
    g->scale = fmin(DIAGRAM_DRAWN / (g->right - g->left), DIAGRAM_TALLEST / (2 * g->height));
    g->x = 0.5 * DIAGRAM_WIDTH - 0.5 * g->scale * (g->left + g->right);
    g->y = DIAGRAM_TOP + g->scale * g->height;
}

static void diagram_head(const diagram *g)
{
    const lflare_lens *lens = g->d->lens;
    const lflare_prescription *p = &lens->prescription;
    double tall = 2 * g->scale * g->height;
    fprintf(g->file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %.0f\" font-family=\"Helvetica, Arial, sans-serif\">\n<title>",
            DIAGRAM_WIDTH, DIAGRAM_TOP + tall + DIAGRAM_BOTTOM);
    diagram_text(g->file, p->name[0] ? p->name : "A lens");
    /* colours of middling lightness show on white and on black alike */
    fputs("</title>\n<style>path{fill:none;stroke-linejoin:round}text{fill:#768090;font-size:14px}.name{font-size:21px;font-weight:bold}"
          ".glass{fill:#5aa0d8;fill-opacity:.3;stroke:#5f86ab;stroke-width:1.2}.stop{stroke:#808894;stroke-width:4}.sensor{stroke:#808894;stroke-width:5}"
          ".axis{stroke:#808894;stroke-width:.8;stroke-dasharray:14 4 2 4}.bar{stroke:#808894;stroke-width:1.5}.image path{stroke:#3f9b6c;stroke-width:1}"
          ".ghost path{stroke:#dd8030;stroke-width:1}.mirror{stroke:#d8433b;stroke-width:3}.bound{stroke:#dd8030;stroke-width:5}"
          ".mirrored{fill:#d8433b}.right{text-anchor:end}.bounds{fill:#dd8030;text-anchor:end}</style>\n", g->file);
    fprintf(g->file, "<clipPath id=\"frame\"><rect x=\"%.2f\" y=\"%d\" width=\"%.2f\" height=\"%.2f\"/></clipPath>\n", diagram_x(g, g->left),
            DIAGRAM_TOP - 12, g->scale * (g->right - g->left), tall + 24);
    fputs("<text class=\"name\" x=\"40\" y=\"32\">", g->file);
    diagram_text(g->file, p->name[0] ? p->name : "A lens");
    fputs("</text>\n<text x=\"40\" y=\"54\">", g->file);
    diagram_text(g->file, p->patent);
    fprintf(g->file, "%s%.4g mm, f/%.3g, %d ghosts</text>\n", p->patent[0] ? " &#183; " : "", lens->efl, lens->fnumber, (int)lens->ghost_count);
}

/* 1, 2 or 5 times a power of ten, about 120 pixels long. */
static void diagram_scale_bar(const diagram *g)
{
    double most = 170 / g->scale, power = pow(10, floor(log10(most))), length = most >= 5 * power ? 5 * power : most >= 2 * power ? 2 * power : power;
    double y = g->y + g->scale * g->height + 30;
    fprintf(g->file, "<path class=\"bar\" d=\"M40 %.2fv8m0 -4h%.2fm0 -4v8\"/>\n<text x=\"%.2f\" y=\"%.2f\">%g mm</text>\n", y - 4, g->scale * length,
            48 + g->scale * length, y + 5, length);
}

/* Which entrance heights the ghost takes, as bars in front of the lens and as a line of text. */
static void diagram_bounds(const diagram *g, const diagram_spans *s)
{
    double z = 0.25 * g->left;
    int i;
    for (i = 0; i < g->d->lens->surface_count; i++)
        if (i != g->d->lens->stop) z = fmin(z, diagram_edge(g, i) + 0.15 * g->left);
    fprintf(g->file, "<text class=\"bounds\" x=\"960\" y=\"54\">ghost %d,%d", (int)g->d->ghost->first + 1, (int)g->d->ghost->second + 1);
    if (g->d->ghost->third > 0) fprintf(g->file, ",%d,%d", (int)g->d->ghost->third + 1, (int)g->d->ghost->fourth + 1);
    fputc(' ', g->file);
    if (s->count == 0) fputs("does not pass", g->file);
    else fputs("enters at", g->file);
    for (i = 0; i < s->count; i++) fprintf(g->file, "%s %.2f to %.2f", i > 0 ? "," : "", s->lo[i] + 0.0, s->hi[i] + 0.0);
    fputs(s->count > 0 ? " mm</text>\n" : "</text>\n", g->file);
    for (i = 0; i < s->count; i++) diagram_line(g, "bound", z, s->lo[i] + z * g->d->slope, z, s->hi[i] + z * g->d->slope);
}

/* Writes the whole SVG; the file's own error flag says if that failed. */
static void diagram_write(FILE *file, const diagram_desc *d)
{
    static diagram g;
    const lflare_surface *stop = &d->lens->prescription.surfaces[d->lens->stop];
    double sensor = 0.5 * d->lens->sensor_height, degrees = atan(-d->slope) * 180 / 3.14159265358979323846;
    int side;
    g.d = d;
    g.file = file;
    diagram_layout(&g);
    diagram_head(&g);
    diagram_line(&g, "axis", g.left, 0, g.right, 0);
    diagram_glasses(&g);
    if (d->rays > 0 && diagram_bundle(&g, NULL, "image").count == 0)
        fputs("<text class=\"right\" x=\"960\" y=\"72\">no ray of the image passes</text>\n", file);
    if (d->ghost != NULL) {
        diagram_spans spans = diagram_bundle(&g, d->ghost, "ghost");
        diagram_mirror(&g, (int)d->ghost->first, 1);
        diagram_mirror(&g, (int)d->ghost->second, 0);
        if (d->ghost->third > 0) {
            diagram_mirror(&g, (int)d->ghost->third, 1);
            diagram_mirror(&g, (int)d->ghost->fourth, 0);
        }
        diagram_bounds(&g, &spans);
    }
    for (side = -1; side <= 1; side += 2)
        diagram_line(&g, "stop", g.z[d->lens->stop], side * stop->semi_diameter, g.z[d->lens->stop], side * 1.35 * stop->semi_diameter);
    diagram_line(&g, "sensor", g.sensor, -sensor, g.sensor, sensor);
    diagram_scale_bar(&g);
    if (d->slope != 0) fprintf(file, "<text class=\"right\" x=\"960\" y=\"32\">light %.3g&#176; off the axis</text>\n", fabs(degrees));
    fputs("</svg>\n", file);
}

#endif
