/* 00_null: the library with no window, no GL and no picture: reads a lens, prints its ghosts and the instances of one frame.
   Usage: 00_null [LENS]. Read 01_one_flare.c next to see them drawn with GL, 02_own_renderer.c to draw them yourself. */

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

static const char *const default_lens = "lenses/heliar-tronnier.lens";

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : default_lens;
    lflare_desc desc = {0};
    lflare_view view = {0};
    lflare_light sun = {{0.15f, 0.08f, -1.0f}, {1, 1, 1}, {0}, 0.00465f, 0, 0};
    const lflare_tables *tables;
    const lflare_frame_data *frame;
    lflare_error error;
    lflare *flare;
    char *text;
    int32_t i;

    if (lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error) < 0) {
        fprintf(stderr, "%s: %s\n", path, error.text);
        return 2;
    }
    desc.text = text;
    if (lflare_create(&desc, &flare, &error) < 0) {
        fprintf(stderr, "%s:%d:%d: %s\n", path, (int)error.line, (int)error.column, error.text);
        return 2;
    }
    free(text);

    tables = lflare_get_tables(flare);
    printf("%s: EFL %.2f mm, f/%.2g, %d ghosts\n", lflare_get_lens(flare)->prescription.name, (double)tables->efl, (double)tables->fnumber, (int)tables->ghost_count);
    for (i = 0; i < tables->ghost_count; i++) {
        const float *green = tables->head + i * LFLARE_HEAD_FLOATS + 4; /* Ma11 Ma12 M11 M12 at 510 nm */
        printf("  ghost %3d: surfaces %2d and %2d, iris scaled by %8.3f on the sensor\n", (int)i, (int)tables->pairs[i].first + 1,
               (int)tables->pairs[i].second + 1, (double)(green[2] / green[0]));
    }

    view.width = 1280;
    view.height = 720;
    lflare_frame(flare, &view, &sun, 1);
    frame = lflare_get_frame(flare);
    printf("one frame: %d lights, %d instances of %d bytes\n", (int)frame->light_count, (int)frame->instance_count, (int)sizeof(lflare_instance));
    for (i = 0; i < frame->instance_count; i++)
        printf("  instance %3d: ghost %d of light %d\n", (int)i, frame->instances[i].ghost, frame->instances[i].light);
    lflare_destroy(flare);
    return 0;
}
