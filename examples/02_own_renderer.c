/* 02_own_renderer: draws the library's instances with code of its own, as an engine without GL would, and compares the
   picture with the library's software renderer. Everything it needs is in the resolved footprint: per wavelength a centre
   and an irradiance; for all of them a handful of edges, each |gain d + offset axis| <= 1, soft over +-soft.
   Usage: 02_own_renderer [LENS]; exits 1 if the pictures differ. Read flare.c next for a whole tool. */

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

enum { W = 640, H = 360 };

typedef struct vec {
    float x, y;
} vec;

/* How far inside an edge a point is, in soft widths, and the edge's inward normal on the sensor. */
static float inside_circle(vec a, float radius, float soft, float sign, vec *normal)
{
    float length = sqrtf(a.x * a.x + a.y * a.y);
    normal->x = -sign * a.x / (length + 1e-20f);
    normal->y = -sign * a.y / (length + 1e-20f);
    return (radius - length) / soft;
}

/* All edges at a point d of the sensor, measured from the footprint's centre; the two that cut most decide. */
static float coverage(const lflare_footprint *fp, int k, const lflare_iris *iris, vec d)
{
    float least[2] = {1, 1}, product, rho;
    vec normals[2] = {{0, 0}, {0, 0}};
    int e, b;
    for (e = 0; e < fp->edge_count; e++) {
        const lflare_edge *edge = &fp->edges[e];
        float sign = edge->gain[k] < 0 ? -1.0f : 1.0f;
        vec a;
        int blades = e == 0 ? iris->blade_count : 0;
        a.x = edge->gain[k] * d.x + edge->offset[k] * fp->axis[0];
        a.y = edge->gain[k] * d.y + edge->offset[k] * fp->axis[1];
        for (b = 0; b < (blades > 0 ? blades : 1); b++) {
            const lflare_blade *blade = &iris->blades[b];
            vec normal, moved = a;
            float t;
            if (blades == 0) {
                t = inside_circle(a, 1, edge->soft[k], sign, &normal);
            } else if (blade->arc > 0) {
                moved.x += blade->nx * blade->distance;
                moved.y += blade->ny * blade->distance;
                t = inside_circle(moved, blade->arc, edge->soft[k], sign, &normal);
            } else {
                t = (blade->distance - blade->nx * a.x - blade->ny * a.y) / edge->soft[k];
                normal.x = -sign * blade->nx;
                normal.y = -sign * blade->ny;
            }
            t = lflare_edge_coverage(t);
            if (t < least[0]) {
                least[1] = least[0];
                normals[1] = normals[0];
                least[0] = t;
                normals[0] = normal;
            } else if (t < least[1]) {
                least[1] = t;
                normals[1] = normal;
            }
        }
    }
    product = least[0] * least[1];
    rho = normals[0].x * normals[1].x + normals[0].y * normals[1].y;
    if (least[1] >= 1 || least[0] <= 0) return least[0];
    if (rho > 0) return product + rho * (least[0] - product);
    return product - rho * (fmaxf(least[0] + least[1] - 1, 0) - product);
}

static void draw(const lflare_footprint *fp, const lflare_iris *iris, const lflare_frame_data *frame, float *rgba)
{
    int grid = fp->fine ? 4 : 1, x, y, k, i; /* footprints of a few pixels are meant for 4 x 4 samples */
    for (y = 0; y < H; y++)
        for (x = 0; x < W; x++)
            for (k = 0; k < 3; k++) {
                float sum = 0;
                for (i = 0; i < grid * grid; i++) {
                    /* the picture is the sensor turned by 180 degrees; rows run downwards */
                    float px = (float)x + ((float)(i % grid) + 0.5f) / (float)grid, py = (float)y + ((float)(i / grid) + 0.5f) / (float)grid;
                    vec d;
                    d.x = frame->centre[0] - (px - 0.5f * W) * frame->pixel_size[0] - fp->centre[k][0];
                    d.y = frame->centre[1] + (py - 0.5f * H) * frame->pixel_size[1] - fp->centre[k][1];
                    if (d.x * d.x + d.y * d.y < fp->radius * fp->radius * 1.01f) sum += coverage(fp, k, iris, d);
                }
                rgba[4 * (y * W + x) + k] += fp->irradiance[k] * sum / (float)(grid * grid);
            }
}

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "lenses/nikon-80-200-mid.lens";
    static float ours[4 * W * H], theirs[4 * W * H];
    lflare_desc desc = {0};
    lflare_view view = {0};
    lflare_light sun = {{0.15f, 0.06f, -1.0f}, {1, 1, 1}, {0}, 0.00465f, 0, 0};
    lflare_image image = {theirs, W, H, 0, 0};
    const lflare_frame_data *frame;
    lflare_error error;
    lflare *flare;
    char *text;
    float largest = 0, brightest = 0;
    int i;

    if (lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error) < 0) {
        fprintf(stderr, "%s: %s\n", path, error.text);
        return 2;
    }
    desc.text = text;
    desc.settings.fnumber = 5.6;
    desc.settings.blades = 6;
    desc.settings.blade_curvature = 0.3f;
    desc.settings.no_ringing = 1;   /* for fringes and masks: lflare_footprint_coverage in place of ours */
    desc.settings.no_starburst = 1; /* for starbursts: lflare_starburst_at, as lflare_software_starbursts does */
    if (lflare_create(&desc, &flare, &error) < 0) {
        fprintf(stderr, "%s:%d:%d: %s\n", path, (int)error.line, (int)error.column, error.text);
        return 2;
    }
    free(text);
    view.width = W;
    view.height = H;
    lflare_frame(flare, &view, &sun, 1);
    frame = lflare_get_frame(flare);
    for (i = 0; i < frame->instance_count; i++) {
        lflare_footprint fp;
        if (lflare_footprint_resolve(lflare_get_tables(flare), frame, frame->instances[i], &fp))
            draw(&fp, &lflare_get_tables(flare)->iris, frame, ours);
    }
    lflare_render(flare, &image);
    for (i = 0; i < 4 * W * H; i++) {
        largest = fmaxf(largest, fabsf(ours[i] - theirs[i]));
        brightest = fmaxf(brightest, theirs[i]);
    }
    printf("%d ghosts; brightest pixel %g, largest difference to lflare_render %.2g of it\n", (int)frame->instance_count, (double)brightest,
           (double)(largest / brightest));
    lflare_destroy(flare);
    return largest > 1e-3f * brightest;
}
